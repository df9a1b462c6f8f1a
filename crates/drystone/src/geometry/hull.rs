//! Convex hulls: vertices, planes, half-edges.

pub(crate) mod build;
mod facets;
pub(crate) mod lanes;
mod quickhull;

use self::lanes::HullLanes;
#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::mass::MassProperties;
use crate::base::aabb::Aabb;
use crate::base::math::{Vec3, greater, lesser, vec3};

/// A plane: points with `normal · p = offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Plane {
    /// Unit normal, outward [local].
    pub normal: Vec3,
    /// Distance from the origin along the normal [m].
    pub offset: f32,
}

impl Plane {
    /// Signed distance of a point [m]; above 0 outside.
    #[must_use]
    #[inline]
    pub fn distance(&self, p: Vec3) -> f32 {
        self.normal.dot(p) - self.offset
    }
}

/// One side of an edge. Half-edge `e` and `e ^ 1` are twins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct HalfEdge {
    /// Start vertex.
    pub(crate) origin: u16,
    /// Face on its left, seen from outside; its edges run counter-clockwise.
    pub(crate) face: u16,
    /// Next half-edge of that face.
    pub(crate) next: u16,
}

/// A convex polytope.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[cfg_attr(feature = "serde", serde(try_from = "Parts", into = "Parts"))]
pub struct Hull {
    pub(crate) vertices: Vec<Vec3>,
    /// One plane per face.
    pub(crate) planes: Vec<Plane>,
    /// First half-edge of each face.
    pub(crate) face_edges: Vec<u16>,
    /// Twins are adjacent: 2k and 2k + 1.
    pub(crate) edges: Vec<HalfEdge>,
    /// A point well inside [m].
    pub(crate) center: Vec3,
    /// Radius of the ball around the center that touches the nearest face [m].
    pub(crate) inner: f32,
    /// Maximum distance of a vertex from the origin [m].
    pub(crate) reach: f32,
    /// Number of corners of the face with the most corners.
    pub(crate) longest_face: usize,
    /// The same vertices and planes in groups of eight, with bounds on the separation along edges,
    /// for the search for separating axes.
    pub(crate) lanes: HullLanes,
    /// Half extents if the hull is a box along its own axes [m].
    pub(crate) cuboid: Option<Vec3>,
    bounds: Aabb,
}

/// The saved form of a hull: the data it is rebuilt from.
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
struct Parts {
    vertices: Vec<Vec3>,
    planes: Vec<Plane>,
    /// Vertex numbers of each face, starting at its first half-edge.
    faces: Vec<Vec<u16>>,
    cuboid: Option<Vec3>,
}

impl From<Hull> for Parts {
    fn from(hull: Hull) -> Self {
        let faces = (0..hull.face_count()).map(|f| hull.face(f)).collect();
        Self { faces, vertices: hull.vertices, planes: hull.planes, cuboid: hull.cuboid }
    }
}

impl TryFrom<Parts> for Hull {
    type Error = HullError;

    fn try_from(parts: Parts) -> Result<Self, HullError> {
        let Parts { vertices, planes, faces, cuboid } = parts;
        build::check_points(&vertices)?;
        let is_face =
            |f: &Vec<u16>| f.len() >= 3 && f.iter().all(|v| usize::from(*v) < vertices.len());
        if planes.len() != faces.len() || !faces.iter().all(is_face) {
            return Err(HullError::Numerical);
        }
        build::check_planes(&vertices, &planes, &faces)?;
        let (face_edges, edges) = link_loops(&faces).ok_or(HullError::Numerical)?;
        if vertices.len() + faces.len() != edges.len() / 2 + 2 {
            return Err(HullError::Numerical);
        }
        let hull = Self { cuboid, ..Self::from_parts(vertices, planes, face_edges, edges) };
        let Aabb { min, max } = hull.bounds;
        let fits =
            cuboid.is_none_or(|half| hull.vertices.len() == 8 && max == half && min == -half);
        if fits { Ok(hull) } else { Err(HullError::Numerical) }
    }
}

/// Reasons why points have no hull.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum HullError {
    /// Fewer than four points; the number given.
    TooFewPoints(usize),
    /// A coordinate is infinite or NaN; the index of the point.
    NotFinite(usize),
    /// A coordinate is larger than 1e7 m; the index of the point.
    TooLarge(usize),
    /// All points lie on one point, line or plane, or too close to one to have an inside; the
    /// thickness found [m].
    Flat(f32),
    /// The vertex limit is below 4; the number given.
    LimitTooSmall(usize),
    /// Rounding left no closed surface. This has never been seen; the check is a safeguard.
    Numerical,
}

impl core::fmt::Display for HullError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::TooFewPoints(n) => write!(f, "a hull needs at least 4 points, {n} given"),
            Self::NotFinite(i) => write!(f, "point {i} is not finite"),
            Self::TooLarge(i) => write!(f, "point {i} has a coordinate beyond 1e7 m"),
            Self::Flat(t) => write!(f, "the points have no volume (thickness {t:e} m)"),
            Self::LimitTooSmall(n) => write!(f, "the vertex limit is {n}, at least 4 is needed"),
            Self::Numerical => write!(f, "no closed hull within f32 precision"),
        }
    }
}

impl core::error::Error for HullError {}

impl Hull {
    /// Maximum number of vertices that [`Hull::from_points`] keeps.
    pub const DEFAULT_VERTEX_LIMIT: usize = 255;

    /// Computes the convex hull of `points` [m], reduced to at most [`Self::DEFAULT_VERTEX_LIMIT`]
    /// vertices. Duplicate points and inner points are allowed. A point within 1e-5 of the points'
    /// extent from a face counts as on it. The minimum thickness is 4e-5 of the extent, and 1e-5 m.
    ///
    /// # Errors
    /// See [`HullError`].
    pub fn from_points(points: &[Vec3]) -> Result<Self, HullError> {
        Self::from_points_limited(points, Self::DEFAULT_VERTEX_LIMIT)
    }

    /// Like [`Self::from_points`] with a vertex limit (4 or more). The farthest points are taken
    /// first, so the reduced hull lies inside the full one and close to it.
    ///
    /// # Errors
    /// See [`HullError`].
    pub fn from_points_limited(points: &[Vec3], max_vertices: usize) -> Result<Self, HullError> {
        build::quickhull(points, max_vertices)
    }

    /// Builds a hull from its parts. The caller (the builder) guarantees the invariants: outward
    /// planes, adjacent twins, every face a closed counter-clockwise loop.
    pub(crate) fn from_parts(
        vertices: Vec<Vec3>,
        planes: Vec<Plane>,
        face_edges: Vec<u16>,
        edges: Vec<HalfEdge>,
    ) -> Self {
        let bounds = Aabb::of_points(vertices.iter().copied());
        let sum = vertices.iter().fold(Vec3::ZERO, |s, v| s + *v);
        #[expect(clippy::cast_precision_loss, reason = "few vertices")]
        let center = sum * (1.0 / vertices.len() as f32);
        let inner = planes.iter().map(|p| -p.distance(center)).fold(f32::INFINITY, lesser);
        let reach = vertices.iter().map(|v| v.length()).fold(0.0, greater);
        let lanes = HullLanes::new(&vertices, &planes, &edges);
        let mut hull = Self {
            vertices,
            planes,
            face_edges,
            edges,
            center,
            inner: greater(inner, 0.0),
            reach,
            lanes,
            cuboid: None,
            bounds,
            longest_face: 0,
        };
        hull.longest_face =
            (0..hull.face_edges.len()).map(|f| hull.corners_of(f)).max().unwrap_or(0);
        hull
    }

    /// Number of corners of a face.
    pub(crate) fn corners_of(&self, face: usize) -> usize {
        let first = self.face_edges[face];
        let mut count = 1;
        let mut e = self.edges[usize::from(first)].next;
        while e != first && count < self.edges.len() {
            count += 1;
            e = self.edges[usize::from(e)].next;
        }
        count
    }

    /// The box of these half extents [m].
    pub(crate) fn cuboid(h: Vec3) -> Self {
        // Vertex i: bit 0 = +x, bit 1 = +y, bit 2 = +z.
        let sign = |i: u16, bit: u16, v: f32| if i >> bit & 1 == 1 { v } else { -v };
        let vertices =
            (0..8).map(|i| vec3(sign(i, 0, h.x), sign(i, 1, h.y), sign(i, 2, h.z))).collect();
        let loops: [([u16; 4], Vec3, f32); 6] = [
            ([0, 4, 6, 2], -Vec3::X, h.x),
            ([1, 3, 7, 5], Vec3::X, h.x),
            ([0, 1, 5, 4], -Vec3::Y, h.y),
            ([2, 6, 7, 3], Vec3::Y, h.y),
            ([0, 2, 3, 1], -Vec3::Z, h.z),
            ([4, 5, 7, 6], Vec3::Z, h.z),
        ];
        let faces: Vec<Vec<u16>> = loops.iter().map(|l| l.0.to_vec()).collect();
        let planes = loops.iter().map(|l| Plane { normal: l.1, offset: l.2 }).collect();
        let (face_edges, edges) = link_loops(&faces).expect("a box is closed");
        Self { cuboid: Some(h), ..Self::from_parts(vertices, planes, face_edges, edges) }
    }

    /// The vertices [m, local].
    #[must_use]
    pub fn vertices(&self) -> &[Vec3] {
        &self.vertices
    }

    /// The planes of the faces [local].
    #[must_use]
    pub fn planes(&self) -> &[Plane] {
        &self.planes
    }

    /// Returns the vertex numbers of face `face`, counter-clockwise seen from outside; empty if
    /// there is no such face.
    #[must_use]
    pub fn face(&self, face: usize) -> Vec<u16> {
        let Some(&first) = self.face_edges.get(face) else { return Vec::new() };
        let mut loop_ = Vec::new();
        let mut e = first;
        loop {
            let edge = self.edges[usize::from(e)];
            loop_.push(edge.origin);
            e = edge.next;
            if e == first {
                return loop_;
            }
        }
    }

    /// Number of faces.
    #[must_use]
    pub const fn face_count(&self) -> usize {
        self.face_edges.len()
    }

    /// Number of edges.
    #[must_use]
    pub const fn edge_count(&self) -> usize {
        self.edges.len() / 2
    }

    /// Volume [m³].
    #[must_use]
    pub fn volume(&self) -> f32 {
        MassProperties::of_hull(self, 1.0).mass
    }

    /// Smallest bounding box of the hull [m, local].
    #[must_use]
    pub const fn bounds(&self) -> Aabb {
        self.bounds
    }
}

/// Links face loops (counter-clockwise vertex numbers) to a closed surface. Returns the first
/// half-edge of each face, and the half-edges with adjacent twins. Returns `None` if some edge does
/// not have exactly two opposite sides.
pub(crate) fn link_loops(faces: &[Vec<u16>]) -> Option<(Vec<u16>, Vec<HalfEdge>)> {
    use std::collections::BTreeMap;
    let mut number = BTreeMap::<(u16, u16), u16>::new();
    let mut count = 0_u16;
    for face in faces {
        for k in 0..face.len() {
            let (a, b) = (face[k], face[(k + 1) % face.len()]);
            if number.contains_key(&(a, b)) {
                return None;
            }
            let id = match number.get(&(b, a)) {
                Some(&twin) if twin % 2 == 0 => twin + 1,
                Some(_) => return None,
                None => {
                    let id = count;
                    count = count.checked_add(2)?;
                    id
                }
            };
            number.insert((a, b), id);
        }
    }
    if number.len() != usize::from(count) {
        return None;
    }
    let mut edges = vec![HalfEdge { origin: 0, face: 0, next: 0 }; usize::from(count)];
    let mut face_edges = Vec::with_capacity(faces.len());
    for (f, face) in (0_u16..).zip(faces) {
        let n = face.len();
        let id = |k: usize| number[&(face[k % n], face[(k + 1) % n])];
        face_edges.push(id(0));
        for k in 0..n {
            edges[usize::from(id(k))] = HalfEdge { origin: face[k], face: f, next: id(k + 1) };
        }
    }
    Some((face_edges, edges))
}
