//! Edges that rounding, or a finer cut of the surface, keeps from having a neighbor.
//!
//! Exporters compute one corner twice, and transforms are baked in, so that corners of neighbors differ by some
//! roundings. Grids of different fineness meet in edges of different length (T-junctions). Both leave edges
//! that no other triangle shares, though the surface goes on. Only such edges are looked at, so that a mesh whose
//! corners agree pays for none of this.

use super::adjacency::{Bends, Edge, Sides, Wide, bend};
use crate::base::aabb::Aabb;
use crate::base::math::{Vec3, greater, lesser};
use crate::geometry::bvh::{Bvh, Children};

/// Corners are one up to this part of the longest edge: each may be off by 1e-5 of it, about a hundred roundings.
const SAME: f32 = 2.0e-5;
/// Or up to this part of their coordinates, four roundings of f32.
const ROUNDING: f32 = 4.8e-7;
/// But never farther than this part of the triangle's height, so that no thin triangle loses its shape.
const THIN: f32 = 0.1;

/// More than this many corners or edges about one are not looked through: a search stays short in any mesh.
const MOST: usize = 1024;

/// How far a corner of a triangle may be from what counts as the same place [m].
fn tolerance(corners: [Vec3; 3]) -> f32 {
    let [a, b, c] = corners;
    let longest = greater(greater((b - a).length(), (c - b).length()), (a - c).length());
    let height = (b - a).cross(c - a).length() / longest;
    let far = corners.map(|p| p.abs().max_element()).into_iter().fold(0.0, greater);
    lesser(greater(SAME * longest, ROUNDING * far), THIN * height)
}

/// Of sorted edges those that no other triangle has.
pub(super) fn lone(edges: &[Edge]) -> Vec<Edge> {
    edges.chunk_by(|x, y| x.ends == y.ends).filter(|s| s.len() == 1).flatten().copied().collect()
}

/// What a box overlaps; up to [`MOST`] items.
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
                if seen == MOST {
                    return;
                }
            }
        }
    }
}

/// Makes corners of lone edges one that are at one place but for rounding: each takes the number of the nearest one of
/// lower number that did not take another's.
pub(super) fn weld(vertices: &[Vec3], triangles: &[[u32; 3]], lone: &[Edge], welded: &mut [u32]) {
    let mut reach = vec![f32::INFINITY; vertices.len()];
    for t in triangles {
        let most = tolerance(t.map(|i| vertices[i as usize]));
        for i in t {
            let place = welded[*i as usize] as usize;
            reach[place] = lesser(reach[place], most);
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

/// A part of an edge along which another one lies, 0 to 1, and the number of that.
#[derive(Clone, Copy, Debug)]
struct Covered {
    from: f64,
    to: f64,
    by: usize,
}

/// Gives lone edges that lie along other ones, with all of their length, those as neighbors.
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
    let (along, way) = (b - a, q - p);
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
        let apart = p + way * ((at - s) / (t - s)) - (a + along * at);
        apart.dot(apart) <= near * near
    };
    (is_near(from) && is_near(to)).then_some([from, to])
}
