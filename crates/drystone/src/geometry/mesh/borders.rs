//! Edges without a neighbor because of rounding, or because the surface is cut more finely there.
//!
//! Exporters compute one corner twice and bake transforms in, so corners of neighbors differ by
//! some roundings. Grids of different fineness meet in edges of different length (T-junctions).
//! Both leave edges that no other triangle shares, though the surface continues. Only such edges
//! are processed, so a mesh whose corners agree pays nothing for this.

use super::adjacency::{Bends, Edge, Sides, Wide, bend};
use crate::base::aabb::Aabb;
use crate::base::math::{Vec3, greater, lesser};
use crate::geometry::bvh::{Bvh, Children};

/// Corners are the same up to this fraction of the longest edge: each may be off by 1e-5 of it,
/// about a hundred roundings.
const SAME: f32 = 2.0e-5;
/// Corners are also the same up to this fraction of their coordinates, four roundings of f32.
const ROUNDING: f32 = 4.8e-7;
/// Maximum of both tolerances, as a fraction of the triangle's height: no thin triangle loses its
/// shape.
const THIN: f32 = 0.1;

/// Maximum number of corners or edges that a search visits: it stays short in any mesh.
const MAX: usize = 1024;

/// Distance [m] up to which another corner counts as the same as a corner of a triangle.
fn tolerance(corners: [Vec3; 3]) -> f32 {
    let [a, b, c] = corners;
    let longest = greater(greater((b - a).length(), (c - b).length()), (a - c).length());
    let height = (b - a).cross(c - a).length() / longest;
    let far = corners.map(|p| p.abs().max_element()).into_iter().fold(0.0, greater);
    lesser(greater(SAME * longest, ROUNDING * far), THIN * height)
}

/// Returns the sorted edges that no other triangle shares.
pub(super) fn lone(edges: &[Edge]) -> Vec<Edge> {
    edges.chunk_by(|x, y| x.ends == y.ends).filter(|s| s.len() == 1).flatten().copied().collect()
}

/// Calls `visit` with the items whose boxes overlap `bounds`; at most [`MAX`] items.
fn around(tree: &Bvh, bounds: &Aabb, stack: &mut Vec<u32>, mut visit: impl FnMut(usize)) {
    stack.clear();
    stack.extend(tree.root());
    let mut seen = 0;
    while let Some(node) = stack.pop() {
        if !tree.bounds(node).overlaps(bounds) {
            continue;
        }
        match tree.children(node) {
            Children::Nodes(nodes) => stack.extend(nodes),
            Children::Item(item) => {
                visit(item as usize);
                seen += 1;
                if seen == MAX {
                    return;
                }
            }
        }
    }
}

/// Merges corners of lone edges that differ only by rounding. Each takes the number of the nearest
/// corner with a lower number that did not itself take another's number.
pub(super) fn weld(vertices: &[Vec3], triangles: &[[u32; 3]], lone: &[Edge], welded: &mut [u32]) {
    let mut reach = vec![f32::INFINITY; vertices.len()];
    for t in triangles {
        let maximum = tolerance(t.map(|i| vertices[i as usize]));
        for i in t {
            let place = welded[*i as usize] as usize;
            reach[place] = lesser(reach[place], maximum);
        }
    }
    let mut places: Vec<u32> = lone.iter().flat_map(|edge| edge.ends).collect();
    places.sort_unstable();
    places.dedup();
    let at = |k: usize| vertices[places[k] as usize];
    let boxes: Vec<Aabb> = (0..places.len()).map(|k| Aabb::of_points([at(k)])).collect();
    let tree = Bvh::build(&boxes);
    let mut stack = Vec::new();
    let mut first: Vec<usize> = (0..places.len()).collect();
    for k in 0..places.len() {
        let own = reach[places[k] as usize];
        let mut best: Option<(f32, usize)> = None;
        around(&tree, &boxes[k].grown(own), &mut stack, |other| {
            if other >= k || first[other] != other {
                return;
            }
            let apart = (at(other) - at(k)).length();
            let near = apart <= lesser(own, reach[places[other] as usize]);
            if near && best.is_none_or(|b| (apart, other) < b) {
                best = Some((apart, other));
            }
        });
        if let Some((_, other)) = best {
            first[k] = other;
        }
    }
    for place in welded {
        if let Ok(k) = places.binary_search(place) {
            *place = places[first[k]];
        }
    }
}

/// A part of an edge along which another edge lies, 0 to 1, and the number of that edge.
#[derive(Clone, Copy, Debug)]
struct Covered {
    from: f64,
    to: f64,
    by: usize,
}

/// Finds lone edges that are covered along their whole length by other edges, and makes those edges
/// their neighbors.
pub(super) fn join(vertices: &[Vec3], triangles: &[[u32; 3]], lone: &[Edge], bends: &mut [Bends]) {
    let corners = |e: &Edge| triangles[e.triangle as usize].map(|i| vertices[i as usize]);
    let ends = |e: &Edge| {
        let c = corners(e);
        [c[e.side], c[(e.side + 1) % 3]]
    };
    let boxes: Vec<Aabb> = lone.iter().map(|e| Aabb::of_points(ends(e))).collect();
    let reach: Vec<f32> = lone.iter().map(|e| tolerance(corners(e))).collect();
    let tree = Bvh::build(&boxes);
    let (mut stack, mut covered) = (Vec::new(), Vec::new());
    for (k, edge) in lone.iter().enumerate() {
        covered.clear();
        around(&tree, &boxes[k].grown(reach[k]), &mut stack, |other| {
            if lone[other].triangle != edge.triangle {
                let near = lesser(reach[k], reach[other]);
                let along = overlap(ends(edge), ends(&lone[other]), near);
                covered.extend(along.map(|[from, to]| Covered { from, to, by: other }));
            }
        });
        covered.sort_unstable_by(|a, b| a.from.total_cmp(&b.from).then(a.by.cmp(&b.by)));
        let [a, b] = ends(edge);
        let gap = f64::from(reach[k] / (b - a).length());
        let mut end = 0.0;
        for part in &covered {
            if part.from > end + gap {
                break;
            }
            end = if part.to > end { part.to } else { end };
        }
        if end + gap < 1.0 {
            continue;
        }
        let mut sides = Sides::default();
        for part in &covered {
            let other = &lone[part.by];
            sides.take(bend(corners(edge), edge.side, corners(other)[(other.side + 2) % 3]));
        }
        sides.write(&mut bends[edge.triangle as usize], edge.side);
    }
}

/// The part of the segment `e` along which `f` lies, no farther than `near` [m] from it.
fn overlap(e: [Vec3; 2], f: [Vec3; 2], near: f32) -> Option<[f64; 2]> {
    let ([a, b], [p, q]) = (e.map(Wide::from), f.map(Wide::from));
    let (along, displacement) = (b - a, q - p);
    let square = along.dot(along);
    let place = |x: Wide| (x - a).dot(along) / square;
    let (s, t) = (place(p), place(q));
    let (low, high) = if s < t { (s, t) } else { (t, s) };
    let (from, to) = (low.clamp(0.0, 1.0), high.clamp(0.0, 1.0));
    let near = f64::from(near);
    let length = square.sqrt();
    if !((to - from) * length > near) {
        return None;
    }
    let is_near = |at: f64| {
        let apart = p + displacement * ((at - s) / (t - s)) - (a + along * at);
        apart.dot(apart) <= near * near
    };
    (is_near(from) && is_near(to)).then_some([from, to])
}

#[cfg(test)]
mod tests {
    use super::super::adjacency::{Bends, edges, weld as weld_exact};
    use super::{lone, weld};
    use crate::base::math::{Vec3, vec3};

    fn bends(vertices: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Bends> {
        super::super::bends(vertices, triangles, weld_exact(vertices))
    }

    /// Number of edges where the surface ends.
    fn borders(vertices: &[Vec3], triangles: &[[u32; 3]]) -> usize {
        let all = bends(vertices, triangles);
        all.iter().map(|b| b[0].iter().filter(|bend| bend.is_border()).count()).sum()
    }

    /// Two unit squares side by side, with separate corners.
    fn squares(apart: Vec3) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let one = [Vec3::ZERO, Vec3::X, vec3(1.0, 0.0, 1.0), Vec3::Z];
        let vertices = one.into_iter().chain(one.map(|p| p + Vec3::X + apart)).collect();
        (vertices, vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]])
    }

    #[test]
    fn corners_that_differ_by_rounding_are_one_and_others_are_not() {
        for (apart, count) in [
            (Vec3::ZERO, 6),
            (vec3(1.0e-7, 0.0, 0.0), 6),
            (vec3(1.0e-5, -1.0e-5, 1.0e-5), 6),
            // A gap, a step and an overlap that are intended.
            (vec3(1.0e-4, 0.0, 0.0), 8),
            (vec3(0.0, 1.0e-4, 0.0), 8),
            (vec3(-1.0e-4, 0.0, 0.0), 8),
        ] {
            let (vertices, triangles) = squares(apart);
            assert_eq!(borders(&vertices, &triangles), count, "{apart:?}");
        }
    }

    #[test]
    fn thin_triangles_keep_their_corners() {
        // A slit of 1e-5 m between two squares, filled by two triangles: both of its sides stay.
        let (mut vertices, mut triangles) = squares(vec3(1.0e-5, 0.0, 0.0));
        triangles.extend([[1, 4, 7], [1, 7, 2]]);
        let mut welded = weld_exact(&vertices);
        let all = edges(&triangles, &welded);
        weld(&vertices, &triangles, &lone(&all), &mut welded);
        assert_eq!(welded, (0..8).collect::<Vec<_>>());
        assert_eq!(borders(&vertices, &triangles), 8);
        // A tiny slit far from the origin of the mesh stays too.
        for p in &mut vertices {
            *p = *p * 1.0e-3 + vec3(500.0, 0.0, 0.0);
        }
        let mut welded = weld_exact(&vertices);
        let before = welded.clone();
        let all = edges(&triangles, &welded);
        weld(&vertices, &triangles, &lone(&all), &mut welded);
        assert_eq!(welded, before);
    }

    #[test]
    fn an_edge_along_others_has_a_neighbor_if_they_cover_it() {
        // A square beside one that is cut into strips.
        let (mut vertices, mut triangles) = squares(Vec3::ZERO);
        vertices.truncate(4);
        triangles.truncate(2);
        for strip in 0..3_u8 {
            let [from, to] = [f32::from(strip) / 3.0, f32::from(strip + 1) / 3.0];
            let k = u32::try_from(vertices.len()).unwrap();
            let ends = [(1.0, from), (2.0, from), (2.0, to), (1.0, to)];
            vertices.extend(ends.map(|(x, z)| vec3(x, 0.0, z)));
            triangles.extend([[k, k + 1, k + 2], [k, k + 2, k + 3]]);
        }
        // The rim has 3 edges of the square, 3 ends of strips and 2 sides of strips.
        assert_eq!(borders(&vertices, &triangles), 8);
        // Without the middle strip the long edge ends there, and so do the two sides of the gap.
        let middle = triangles.len() - 4;
        triangles.drain(middle..middle + 2);
        assert_eq!(borders(&vertices, &triangles), 3 + 1 + 2 + 2 + 2);
    }

    #[test]
    fn the_result_does_not_depend_on_how_far_the_mesh_reaches() {
        let (vertices, triangles) = squares(vec3(3.0e-6, 2.0e-6, 0.0));
        let alone = bends(&vertices, &triangles);
        let (mut more, mut wider) = (vertices.clone(), triangles.clone());
        more.extend([vec3(50.0, 0.0, 0.0), vec3(60.0, 0.0, 0.0), vec3(50.0, 0.0, 9.0)]);
        wider.push([8, 9, 10]);
        assert_eq!(bends(&more, &wider)[..4], alone);
    }
}
