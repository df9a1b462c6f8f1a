//! Wavefront `.obj` files: vertices and faces, nothing else.

use std::io::Read;
use std::path::Path;

use drystone::Vec3;
use serde_json::json;

use crate::bake::{MeshPart, document_of_meshes};
use crate::error::SceneError;
use crate::file::{self, Kind};
use crate::gltf::mesh::Triangles;
use crate::gltf::{self, LoadedGltf, Options};

/// Reads the objects (`o`, `g`) of a file as nodes with a mesh each. Which bodies are made of them is
/// up to [`Options::auto_colliders`].
///
/// # Errors
/// A line that names the file, the line in it, what is wrong and what is allowed.
pub fn load(path: &Path, options: &Options) -> Result<LoadedGltf, SceneError> {
    let mut file = file::open(path, Kind::Surface)?;
    let mut bytes = Vec::new();
    let io = |e: std::io::Error| SceneError::new(path, "", e, "a file that can be read");
    file.by_ref().take(4096).read_to_end(&mut bytes).map_err(io)?;
    if bytes.contains(&0) {
        return Err(SceneError::new(path, "", "it is not text", "a Wavefront .obj file"));
    }
    let bytes = file::rest(file, bytes, path, Kind::Surface)?;
    let name = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
    interpret(&bytes, &name, options).map_err(|e| e.in_file(path))
}

/// Reads a scene from the bytes of an `.obj` file called `name`, as [`load`] does.
///
/// # Errors
/// A line that names the line in the file, what is wrong and what is allowed.
pub fn from_slice(bytes: &[u8], name: &str, options: &Options) -> Result<LoadedGltf, SceneError> {
    interpret(bytes, name, options).map_err(|e| e.in_file(Path::new(name)))
}

fn interpret(bytes: &[u8], name: &str, options: &Options) -> Result<LoadedGltf, SceneError> {
    let fail =
        |problem: &str, allowed: &str| Err(SceneError::new(Path::new(""), "", problem, allowed));
    if bytes.contains(&0) {
        return fail("it is not text", "a Wavefront .obj file");
    }
    let parts = parse(&String::from_utf8_lossy(bytes))?;
    if parts.is_empty() {
        return fail("it has no face", "lines f with at least 3 corners");
    }
    gltf::from_document(document_of_meshes(name, &parts), name, options)
}

/// The corners of all faces of a file's text.
pub(crate) fn points(text: &str) -> Result<Vec<Vec3>, SceneError> {
    Ok(parse(text)?.into_iter().flat_map(|part| part.points).collect())
}

/// The triangles of all objects of a file's text.
pub(crate) fn surface(text: &str) -> Result<Triangles, SceneError> {
    let mut all = Triangles::default();
    for part in parse(text)? {
        let base = u32::try_from(all.points.len()).unwrap_or(u32::MAX);
        all.points.extend(part.points);
        all.triangles.extend(part.triangles.iter().map(|t| t.map(|i| i.saturating_add(base))));
    }
    Ok(all)
}

/// Objects with their own vertices.
fn parse(text: &str) -> Result<Vec<MeshPart>, SceneError> {
    let mut points: Vec<Vec3> = Vec::new();
    let mut parts: Vec<(String, Vec<[usize; 3]>)> = vec![(String::new(), Vec::new())];
    for (number, line) in text.lines().enumerate() {
        let place = format!("line {}", number + 1);
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
                if corners.len() < 3 {
                    return fail(format!("a face of {} corners", corners.len()), "at least 3");
                }
                let Some((_, faces)) = parts.last_mut() else { continue };
                faces.extend(
                    (1..corners.len() - 1).map(|k| [corners[0], corners[k], corners[k + 1]]),
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

/// A part with only the vertices that its faces use. `number` has as many entries as the file has vertices, none of them
/// given before and after: a list for each part would make many parts of many vertices slow.
fn own_vertices(
    name: String,
    faces: &[[usize; 3]],
    points: &[Vec3],
    number: &mut [u32],
) -> MeshPart {
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
    MeshPart { name: json!(name), points: own, triangles }
}

#[cfg(test)]
mod tests {
    use super::parse;

    #[test]
    fn faces_are_fans_and_indices_count_from_either_end() {
        let text = "# a\no one\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1/1 2/2 3/3 4//4\no two\nv 0 0 1\nf -1 1 2\n";
        let parts = parse(text).unwrap();
        assert_eq!(parts.len(), 2);
        assert_eq!(parts[0].triangles, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!((parts[1].points.len(), parts[1].points[0].z), (3, 1.0));
    }

    #[test]
    fn mistakes_name_their_line() {
        for (text, part) in [
            ("v 0 0\n", "line 1"),
            ("v 0 0 nan\n", "line 1"),
            ("v 0 0 0\nf 1 2 3\n", "line 2: corner \"2\", expected vertices 1 to 1"),
            ("v 0 0 0\nf 1 1\n", "2 corners"),
        ] {
            let e = parse(text).unwrap_err().to_string();
            assert!(e.contains(part), "{e}");
        }
    }
}
