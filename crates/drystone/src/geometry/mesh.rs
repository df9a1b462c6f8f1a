//! Triangle meshes and their bounding volume hierarchy.

mod adjacency;
mod borders;
mod pack;
mod tree;

use std::collections::BTreeSet;

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

pub(crate) use adjacency::{Bend, Bends};
pub(crate) use pack::Pack;
pub(crate) use tree::{Tree, Window};

use super::bvh::Bvh;
use crate::base::aabb::Aabb;
use crate::base::limits;
use crate::base::math::Vec3;
use crate::base::simd::wide::LANES;

/// A triangle is useless if no edge is this long [m]: the smallest shape is ten times larger.
const MIN_EDGE: f64 = 1.0e-6;
/// A triangle lower than this fraction of its longest edge is a line: its normal would be noise.
const MIN_HEIGHT: f64 = 1.0e-6;

/// Data of a triangle for contacts, beyond the data in its [`Pack`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Face {
    /// Bend of the surface behind edge k (corner k to k + 1), seen from the side that the normal
    /// points to (0) and from the other (1).
    pub(crate) bends: Bends,
    /// Unit vectors in the plane, away from the triangle, one per edge.
    pub(crate) outward: [Vec3; 3],
    /// Vertex numbers of the corners.
    pub(crate) vertices: [u32; 3],
}

impl Face {
    fn new([a, b, c]: [Vec3; 3], normal: Vec3, bends: Bends, vertices: [u32; 3]) -> Self {
        let outward = [b - a, c - b, a - c].map(|e| e.cross(normal).normalize_or(Vec3::ZERO));
        Self { bends, outward, vertices }
    }
}

/// A triangle mesh that does not deform. Any winding; both sides are solid.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[cfg_attr(feature = "serde", serde(try_from = "Parts", into = "Parts"))]
pub struct Mesh {
    vertices: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    packs: Vec<Pack>,
    /// One per lane of each pack; lanes not in use repeat a triangle. Triangles near in space are
    /// near in memory.
    faces: Vec<Face>,
    /// Tree over the packs, for rays and for boxes.
    tree: Tree,
    bounds: Aabb,
}

/// The saved form of a mesh: its input, without the triangles that were left out.
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
struct Parts {
    vertices: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

impl From<Mesh> for Parts {
    fn from(mesh: Mesh) -> Self {
        Self { vertices: mesh.vertices, triangles: mesh.triangles }
    }
}

impl TryFrom<Parts> for Mesh {
    type Error = MeshError;

    fn try_from(parts: Parts) -> Result<Self, MeshError> {
        Self::new(parts.vertices, parts.triangles)
    }
}

/// Reasons why a mesh is refused.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum MeshError {
    /// No triangle, or none with an area.
    NoTriangles,
    /// A triangle refers to a missing vertex.
    IndexOutOfRange {
        /// Number of the triangle.
        triangle: usize,
        /// The missing vertex number.
        vertex: u32,
    },
    /// A coordinate is infinite or NaN; the number of the vertex.
    NotFinite(usize),
    /// A coordinate is larger than 1e7 m; the number of the vertex.
    TooLarge(usize),
}

impl core::fmt::Display for MeshError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::NoTriangles => write!(f, "the mesh has no triangle with an area"),
            Self::IndexOutOfRange { triangle, vertex } => {
                write!(f, "triangle {triangle} names vertex {vertex}, which is not there")
            }
            Self::NotFinite(i) => write!(f, "vertex {i} is not finite"),
            Self::TooLarge(i) => write!(f, "vertex {i} has a coordinate beyond 1e7 m"),
        }
    }
}

impl core::error::Error for MeshError {}

impl Mesh {
    /// Builds a mesh of `vertices` [m, local] and `triangles`, n × 3 vertex numbers of any
    /// winding. Unused vertices are allowed; duplicate and zero-area triangles are left out.
    ///
    /// # Errors
    /// See [`MeshError`].
    pub fn new(vertices: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Result<Self, MeshError> {
        for (i, v) in vertices.iter().enumerate() {
            if !v.is_finite() {
                return Err(MeshError::NotFinite(i));
            }
            if v.abs().max_element() > limits::POSITION.maximum {
                return Err(MeshError::TooLarge(i));
            }
        }
        for (triangle, t) in triangles.iter().enumerate() {
            for &vertex in t {
                if vertices.get(vertex as usize).is_none() {
                    return Err(MeshError::IndexOutOfRange { triangle, vertex });
                }
            }
        }
        let corners_of = |t: [u32; 3]| t.map(|i| vertices[i as usize]);
        let welded = adjacency::weld(&vertices);
        let mut seen = BTreeSet::new();
        let mut kept = Vec::with_capacity(triangles.len());
        let mut normals = Vec::with_capacity(triangles.len());
        for t in triangles {
            let Some(normal) = normal_of(corners_of(t)) else { continue };
            let mut corners = t.map(|i| welded[i as usize]);
            corners.sort_unstable();
            if seen.insert(corners) {
                kept.push(t);
                normals.push(normal);
            }
        }
        if kept.is_empty() {
            return Err(MeshError::NoTriangles);
        }
        let bends = bends(&vertices, &kept, welded);
        let boxes: Vec<Aabb> = kept.iter().map(|t| Aabb::of_points(corners_of(*t))).collect();
        let bounds = boxes.iter().fold(Aabb::EMPTY, |all, b| all.union(b));
        let packs: Vec<Pack> = Bvh::build(&boxes)
            .groups(LANES)
            .iter()
            .map(|group| {
                let rows = group.iter().map(|&t| (t, t as usize));
                Pack::new(rows.map(|(t, row)| (t, corners_of(kept[row]), normals[row])))
            })
            .collect();
        let lanes = packs.iter().flat_map(Pack::lanes).map(|t| t as usize);
        let faces = lanes
            .map(|row| Face::new(corners_of(kept[row]), normals[row], bends[row], kept[row]))
            .collect();
        let tree = Tree::new(&Bvh::build(&packs.iter().map(Pack::bounds).collect::<Vec<_>>()));
        Ok(Self { vertices, triangles: kept, packs, faces, tree, bounds })
    }

    /// The vertices [m, local].
    #[must_use]
    pub fn vertices(&self) -> &[Vec3] {
        &self.vertices
    }

    /// The triangles that were kept, as n × 3 vertex numbers.
    #[must_use]
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Smallest bounding box of the triangles [m, local].
    #[must_use]
    pub const fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// The tree over [`Self::pack`]s.
    pub(crate) const fn tree(&self) -> &Tree {
        &self.tree
    }

    /// Returns an item of the tree.
    #[inline]
    pub(crate) fn pack(&self, item: u32) -> &Pack {
        &self.packs[item as usize]
    }

    /// Contact data of the triangle in `lane` of [`Self::pack`] `item`.
    #[inline]
    pub(crate) fn face(&self, item: u32, lane: usize) -> &Face {
        &self.faces[item as usize * LANES + lane]
    }
}

/// Computes how the surface continues behind each edge. Corners that differ only by rounding, and
/// edges that lie along others, get the neighbors that they were meant to have.
fn bends(vertices: &[Vec3], triangles: &[[u32; 3]], mut welded: Vec<u32>) -> Vec<Bends> {
    let mut edges = adjacency::edges(triangles, &welded);
    let lone = borders::lone(&edges);
    if lone.is_empty() {
        return adjacency::bends(vertices, triangles, &edges);
    }
    borders::weld(vertices, triangles, &lone, &mut welded);
    edges = adjacency::edges(triangles, &welded);
    let mut bends = adjacency::bends(vertices, triangles, &edges);
    borders::join(vertices, triangles, &borders::lone(&edges), &mut bends);
    bends
}

/// Returns the unit normal, or `None` for a triangle without area. The products of f32 differences
/// are exact enough in f64 for the thinnest triangle that is kept.
fn normal_of(corners: [Vec3; 3]) -> Option<Vec3> {
    let [a, b, c] = corners.map(adjacency::Wide::from);
    let (u, v, w) = (b - a, c - a, c - b);
    let longest = u.dot(u).max(v.dot(v)).max(w.dot(w)).sqrt();
    let normal = u.cross(v);
    let doubled_area = normal.dot(normal).sqrt();
    let ok = longest > MIN_EDGE && doubled_area > MIN_HEIGHT * longest * longest;
    ok.then(|| (normal * (1.0 / doubled_area)).narrow())
}

#[cfg(test)]
mod tests {
    use super::{Face, Mesh, MeshError};
    use crate::base::math::{Vec3, vec3};

    fn square() -> Vec<Vec3> {
        vec![Vec3::ZERO, Vec3::X, vec3(1.0, 0.0, 1.0), Vec3::Z]
    }

    /// Normal and contact data of the triangle with a number.
    fn face_of(mesh: &Mesh, number: u32) -> (Vec3, &Face) {
        let packs = (0_u32..).zip(&mesh.packs);
        let mut all = packs.flat_map(|(item, pack)| {
            (0..).zip(pack.numbers()).map(move |(lane, n)| (item, lane, *n))
        });
        let (item, lane, _) = all.find(|(.., n)| *n == number).unwrap();
        (mesh.pack(item).normal(lane), mesh.face(item, lane))
    }

    #[test]
    fn what_is_wrong_is_named() {
        let new = |v: Vec<Vec3>, t: Vec<[u32; 3]>| Mesh::new(v, t).map(|_| ());
        assert_eq!(new(square(), vec![]), Err(MeshError::NoTriangles));
        assert_eq!(new(square(), vec![[0, 1, 1], [2, 2, 2]]), Err(MeshError::NoTriangles));
        assert_eq!(
            new(square(), vec![[0, 1, 2], [0, 4, 1]]),
            Err(MeshError::IndexOutOfRange { triangle: 1, vertex: 4 })
        );
        let mut v = square();
        v[2].y = f32::NAN;
        assert_eq!(new(v.clone(), vec![[0, 1, 3]]), Err(MeshError::NotFinite(2)));
        v[2].y = -2.0e7;
        assert_eq!(new(v, vec![[0, 1, 3]]), Err(MeshError::TooLarge(2)));
    }

    #[test]
    fn duplicates_lines_and_unused_vertices_leave_no_trace() {
        let mut v = square();
        v.push(vec3(0.5, 0.0, 0.5));
        v.push(Vec3::splat(100.0));
        v.push(vec3(-0.0, 0.0, -0.0));
        let t = vec![[0, 1, 2], [2, 1, 0], [1, 2, 0], [0, 4, 2], [1, 2, 6], [0, 2, 3]];
        let mesh = Mesh::new(v, t).unwrap();
        assert_eq!(mesh.triangles(), [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(mesh.bounds().max, vec3(1.0, 0.0, 1.0));
    }

    #[test]
    fn an_edge_is_flat_convex_or_concave_by_the_side_it_is_seen_from() {
        // A roof along z; its faces share no vertex numbers, and one of them has the opposite
        // winding.
        let roof = |drop: f32| {
            let v = vec![
                vec3(0.0, 0.0, 0.0),
                vec3(0.0, 0.0, 1.0),
                vec3(1.0, -drop, 0.0),
                vec3(0.0, 0.0, 0.0),
                vec3(0.0, 0.0, 1.0),
                vec3(-1.0, -drop, 0.0),
            ];
            Mesh::new(v, vec![[0, 1, 2], [3, 4, 5]]).unwrap()
        };
        for (drop, from_above, from_below) in
            [(0.0, false, false), (1.0, true, false), (-1.0, false, true)]
        {
            let mesh = roof(drop);
            for t in 0..2 {
                let (normal, face) = face_of(&mesh, t);
                let up = usize::from(normal.y < 0.0);
                assert_eq!(face.bends[up][0].active(), from_above, "{drop} {t}");
                assert_eq!(face.bends[1 - up][0].active(), from_below, "{drop} {t}");
                assert!(face.bends[up][1].active() && face.bends[1 - up][2].active());
            }
        }
    }

    #[test]
    fn a_wall_on_a_floor_leaves_the_floor_flat_from_below_and_concave_from_above() {
        let v = vec![Vec3::ZERO, Vec3::Z, Vec3::X, -Vec3::X, Vec3::Y];
        let mesh = Mesh::new(v, vec![[0, 1, 2], [1, 0, 3], [0, 1, 4]]).unwrap();
        let (normal, floor) = face_of(&mesh, 0);
        let up = usize::from(normal.y < 0.0);
        assert!(floor.bends[up][0].concave() && !floor.bends[1 - up][0].active());
        assert!(!floor.bends[1 - up][0].concave());
    }
}
