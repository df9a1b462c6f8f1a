//! The text of Wavefront `.obj` files: vertices and faces, nothing else.

use std::borrow::Cow;
use std::path::Path;

use drystone::Vec3;

use super::mesh::Triangles;
use crate::error::SceneError;

/// An object (`o`, `g`) of a file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Object {
    /// Its name; may be empty.
    pub(crate) name: String,
    /// Its faces as triangles [m].
    pub(crate) surface: Triangles,
}

/// The triangles of all objects of a file's text.
pub(crate) fn surface(text: &str) -> Result<Triangles, SceneError> {
    let mut all = Triangles::default();
    for Object { surface, .. } in objects(text)? {
        let base = u32::try_from(all.points.len()).unwrap_or(u32::MAX);
        all.points.extend(surface.points);
        all.triangles.extend(surface.triangles.iter().map(|t| t.map(|i| i.saturating_add(base))));
    }
    Ok(all)
}

/// Lines with their numbers from 1; a backslash at its end joins a line to the next one.
fn lines(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let mut rest = text.lines().enumerate();
    core::iter::from_fn(move || {
        let (number, first) = rest.next()?;
        let mut whole = Cow::Borrowed(first);
        // A comment may end with anything.
        let mut end = first.strip_suffix('\\').filter(|_| !first.starts_with('#'));
        if end.is_some() {
            whole = Cow::Owned(String::new());
        }
        while let Some(part) = end {
            whole.to_mut().push_str(part);
            whole.to_mut().push(' ');
            let Some((_, next)) = rest.next() else { break };
            end = next.strip_suffix('\\');
            if end.is_none() {
                whole.to_mut().push_str(next);
            }
        }
        Some((number + 1, whole))
    })
}

/// The objects of a file's text, each with its own vertices.
pub(crate) fn objects(text: &str) -> Result<Vec<Object>, SceneError> {
    let mut points: Vec<Vec3> = Vec::new();
    let mut parts: Vec<(String, Vec<[usize; 3]>)> = vec![(String::new(), Vec::new())];
    for (number, line) in lines(text) {
        let place = format!("line {number}");
        let fail = |problem: String, allowed: &str| {
            Err(SceneError::new(Path::new(""), &place, problem, allowed))
        };
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let numbers: Vec<f32> = words.take(3).filter_map(|w| w.parse().ok()).collect();
                match numbers.as_slice() {
                    [x, y, z] if numbers.iter().all(|v| v.is_finite()) => {
                        points.push(Vec3::from([*x, *y, *z]));
                    }
                    _ => return fail(format!("\"{line}\""), "v and three finite numbers"),
                }
            }
            Some("f") => {
                let mut corners = Vec::new();
                for word in words {
                    let first = word.split('/').next().unwrap_or("");
                    let index: Option<i64> = first.parse().ok();
                    let count = i64::try_from(points.len()).unwrap_or(i64::MAX);
                    // From 1; negative ones count back from the last vertex.
                    let at = index.map(|i| if i < 0 { count + i } else { i - 1 });
                    match at
                        .filter(|a| (0..count).contains(a))
                        .and_then(|a| usize::try_from(a).ok())
                    {
                        Some(a) => corners.push(a),
                        None => {
                            return fail(
                                format!("corner \"{word}\""),
                                &format!("vertices 1 to {count}"),
                            );
                        }
                    }
                }
                // A face of two corners has no area, as one of three in a line.
                let Some((_, faces)) = parts.last_mut() else { continue };
                faces.extend(
                    (1..corners.len().saturating_sub(1))
                        .map(|k| [corners[0], corners[k], corners[k + 1]]),
                );
            }
            Some("o" | "g") => {
                let name = words.collect::<Vec<_>>().join(" ");
                match parts.last_mut() {
                    Some((last, faces)) if faces.is_empty() => *last = name,
                    _ => parts.push((name, Vec::new())),
                }
            }
            _ => {}
        }
    }
    parts.retain(|(_, faces)| !faces.is_empty());
    let mut number = vec![u32::MAX; points.len()];
    let own = |(name, faces): (String, Vec<_>)| own_vertices(name, &faces, &points, &mut number);
    Ok(parts.into_iter().map(own).collect())
}

/// An object with only the vertices that its faces use. `number` has an entry for each vertex of
/// the file; all are `u32::MAX` before and after. A list for each object would be slow where a file
/// has many objects and many vertices.
fn own_vertices(name: String, faces: &[[usize; 3]], points: &[Vec3], number: &mut [u32]) -> Object {
    let mut own = Vec::new();
    let mut triangles = Vec::with_capacity(faces.len());
    for face in faces {
        triangles.push(face.map(|v| {
            if number[v] == u32::MAX {
                number[v] = u32::try_from(own.len()).unwrap_or(0);
                own.push(points[v]);
            }
            number[v]
        }));
    }
    faces.iter().flatten().for_each(|&v| number[v] = u32::MAX);
    Object { name, surface: Triangles { points: own, triangles } }
}

#[cfg(test)]
mod tests {
    use super::objects;

    #[test]
    fn faces_are_fans_and_indices_count_from_either_end() {
        let text = "# a\no one\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1/1 2/2 3/3 4//4\no two\nv 0 0 1\nf -1 1 2\n";
        let read = objects(text).unwrap();
        assert_eq!(read.len(), 2);
        assert_eq!(read[0].surface.triangles, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!((read[1].surface.points.len(), read[1].surface.points[0].z), (3, 1.0));
    }

    #[test]
    fn lines_go_on_and_faces_of_two_corners_have_no_area() {
        let text = "# C:\\\nv 0 0 \\\n0\nv 1 0 0\nv 0 \\\n  1 \\\n0\nf 1 2\nf 1 \\\n2 3 \\";
        let read = objects(text).unwrap();
        assert_eq!(read.len(), 1);
        let object = &read[0];
        assert_eq!(object.surface.triangles, [[0, 1, 2]]);
        assert!((object.surface.points[2].y - 1.0).abs() < 1.0e-6);
    }

    #[test]
    fn mistakes_name_their_line() {
        for (text, part) in [
            ("v 0 0\n", "line 1"),
            ("v 0 0 nan\n", "line 1"),
            ("v 0 0 0\nf 1 2 3\n", "line 2: corner \"2\", expected vertices 1 to 1"),
            ("v 0 0 \\\n0\nf 1 2 3\n", "line 3: corner \"2\""),
        ] {
            let e = objects(text).unwrap_err().to_string();
            assert!(e.contains(part), "{e}");
        }
    }
}
