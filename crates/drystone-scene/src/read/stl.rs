//! Stereolithography `.stl` files, text or binary: triangles, nothing else.

use drystone::{Vec3, vec3};

/// The corners of the triangles, three after three [units of the file].
///
/// # Errors
/// The problem, in words.
pub fn corners(bytes: &[u8]) -> Result<Vec<Vec3>, String> {
    let points = match binary(bytes) {
        Some((points, true)) => points,
        // Bytes behind the triangles: a text by chance, or what some exporters leave there.
        Some((points, false)) => ascii(bytes).unwrap_or(points),
        None => ascii(bytes)?,
    };
    if points.iter().any(|p| !p.is_finite()) {
        return Err("a corner is not finite".to_owned());
    }
    if points.is_empty() {
        return Err("it has no triangle".to_owned());
    }
    Ok(points)
}

/// A binary file is recognized by its length: many begin with `solid` as text files do. With the
/// corners, whether nothing stands behind them.
fn binary(bytes: &[u8]) -> Option<(Vec<Vec3>, bool)> {
    let count = bytes.get(80..84)?;
    let count = u32::from_le_bytes([count[0], count[1], count[2], count[3]]);
    let count = usize::try_from(count).ok()?;
    let records = bytes.get(84..)?;
    let length = count.checked_mul(50)?;
    let is_whole = records.len() == length;
    // More triangles than it says are no bytes left behind.
    let is_wrong = !is_whole && (length == 0 || records.len().abs_diff(length).is_multiple_of(50));
    let records = records.get(..length).filter(|_| !is_wrong)?;
    let number = |b: &[u8], at: usize| f32::from_le_bytes([b[at], b[at + 1], b[at + 2], b[at + 3]]);
    let mut points = Vec::with_capacity(3 * count);
    for record in records.chunks_exact(50) {
        for corner in 1..4 {
            let at = 12 * corner;
            points.push(vec3(number(record, at), number(record, at + 4), number(record, at + 8)));
        }
    }
    Some((points, is_whole))
}

fn ascii(bytes: &[u8]) -> Result<Vec<Vec3>, String> {
    let text =
        core::str::from_utf8(bytes).map_err(|_| "it is neither text nor whole".to_owned())?;
    let is = |word: Option<&str>, name: &str| word.is_some_and(|w| w.eq_ignore_ascii_case(name));
    if !is(text.trim_start().get(..5), "solid") {
        return Err("it is not an STL file".to_owned());
    }
    let mut points = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        if !is(words.next(), "vertex") {
            continue;
        }
        let numbers: Vec<f32> = words.filter_map(|w| w.parse().ok()).collect();
        let [x, y, z] = numbers[..] else {
            return Err(format!("line {} is no vertex of three numbers", number + 1));
        };
        points.push(vec3(x, y, z));
    }
    if !points.len().is_multiple_of(3) {
        return Err("its last triangle is not whole".to_owned());
    }
    Ok(points)
}

#[cfg(test)]
mod tests {
    use super::corners;

    #[test]
    fn text_and_binary_say_the_same() {
        let text = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n\
                    vertex 0 1.5 0\nendloop\nendfacet\nendsolid a\n";
        let mut bytes = vec![0_u8; 80];
        bytes[..5].copy_from_slice(b"solid");
        bytes.extend(1_u32.to_le_bytes());
        for x in [0.0_f32, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.5, 0.0] {
            bytes.extend(x.to_le_bytes());
        }
        bytes.extend([0, 0]);
        let (a, b) = (corners(text.as_bytes()).unwrap(), corners(&bytes).unwrap());
        assert_eq!(a, b);
        assert_eq!(a.len(), 3);
        assert_eq!(corners(text.to_uppercase().as_bytes()).unwrap(), a);
        let behind = [bytes.as_slice(), b"made by hand"].concat();
        assert_eq!(corners(&behind).unwrap(), a);
        let more = [bytes.as_slice(), &bytes[84..]].concat();
        for broken in
            [&more, &bytes[..100], b"solid\nvertex 1 2", b"", b"solid a\nvertex 0 0 nan\n"]
        {
            assert!(corners(broken).is_err());
        }
    }
}
