//! A polytope in the frame of a mesh, eight vertices, faces or edges at a time.

use fearless_simd::{Simd, SimdBase, f32x4};

use super::triangle::Triangle;
use crate::base::aabb::Aabb;
use crate::base::math::{Mat3, Vec3, greater, vec3};
use crate::base::pose::Pose;
use crate::base::simd::wide::{
    ALL, LANES, Lanes, Mask, Vec3w, Wide, above, bits, lanes_in_use, load, max, min, reduce_max,
    reduce_min, scatter4, select, splat, sqrt,
};
use crate::geometry::hull::{HalfEdge, Hull, Plane};

/// Sine of the angle below which edges count as parallel: their axis is a face's.
const PARALLEL: f32 = 1.0e-3;

/// A vector, and a fourth number or 0.
pub(super) type Row = [f32; 4];

/// Memory for a placed polytope.
#[derive(Clone, Debug, Default)]
pub(super) struct Space {
    /// Vertices relative to the origin and to the center [m], and normals with offsets of the faces
    /// [m], one by one.
    vertices: Vec<Row>,
    arms: Vec<Row>,
    planes: Vec<Row>,
    /// The same in lanes.
    corners: Vec<[Lanes; 3]>,
    normals: Vec<[Lanes; 3]>,
    offsets: Vec<Lanes>,
    edges: Vec<Edges>,
    /// Vertex numbers, and distances [m].
    over: Vec<(u32, f32)>,
}

/// Eight edges: start point and direction vector [m], and the normals of their two faces.
#[derive(Clone, Copy, Debug)]
struct Edges {
    start: [Lanes; 3],
    along: [Lanes; 3],
    normals: [[Lanes; 3]; 2],
}

/// A polytope moved into the frame of the mesh.
#[derive(Debug)]
pub(super) struct PlacedHull<'a> {
    hull: &'a Hull,
    turn: Mat3,
    position: Vec3,
    space: &'a mut Space,
    pub(super) center: Vec3,
    pub(super) radius: f32,
}

/// An axis of two edges: first half-edge of the polytope, unit normal away from the triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct EdgeAxis {
    pub(super) edge: usize,
    pub(super) normal: Vec3,
    pub(super) separation: f32,
}

/// Result for two that are farther apart than contacts reach: a lower bound on the distance [m].
pub(super) struct Separated(pub(super) f32);

impl<'a> PlacedHull<'a> {
    /// Places a hull; uses `space` as memory.
    #[inline(always)]
    pub(super) fn new<S: Simd>(
        simd: S,
        hull: &'a Hull,
        pose: &Pose,
        radius: f32,
        space: &'a mut Space,
    ) -> Self {
        let turn = pose.rotation.to_mat3();
        let position = Vec3w::splat(simd, pose.position);
        let x = Vec3w::splat(simd, turn.x);
        let y = Vec3w::splat(simd, turn.y);
        let z = Vec3w::splat(simd, turn.z);
        let center = turn * hull.center + pose.position;
        let middle = Vec3w::splat(simd, center);
        space.vertices.clear();
        space.arms.clear();
        space.planes.clear();
        space.corners.clear();
        for v in hull.lanes.vertices() {
            let v = v.load(simd);
            let placed = x * v.x + y * v.y + z * v.z + position;
            let mut to = [[0.0; LANES]; 3];
            placed.store(&mut to);
            space.corners.push(to);
            let zero = splat(simd, 0.0);
            push_rows(&mut space.vertices, scatter4([placed.x, placed.y, placed.z, zero]));
            let arm = placed - middle;
            push_rows(&mut space.arms, scatter4([arm.x, arm.y, arm.z, zero]));
        }
        space.vertices.truncate(hull.vertices.len());
        space.arms.truncate(hull.vertices.len());
        space.normals.clear();
        space.offsets.clear();
        for (n, offset) in hull.lanes.planes() {
            let n = n.load(simd);
            let normal = x * n.x + y * n.y + z * n.z;
            let offset = load(simd, offset) + normal.dot(position);
            let mut to = [[0.0; LANES]; 3];
            normal.store(&mut to);
            space.normals.push(to);
            let mut to = [0.0; LANES];
            offset.store_array(&mut to);
            space.offsets.push(to);
            push_rows(&mut space.planes, scatter4([normal.x, normal.y, normal.z, offset]));
        }
        space.planes.truncate(hull.planes.len());
        space.edges.clear();
        Self { hull, turn, position: pose.position, space, center, radius }
    }

    /// Returns whether it is a box along its own axes.
    pub(super) fn is_cuboid(&self) -> bool {
        self.hull.cuboid.is_some()
    }

    /// Vertices, relative to the center [m].
    pub(super) fn arms(&self) -> &[Row] {
        &self.space.arms
    }

    /// Normals and offsets of the faces [m].
    pub(super) fn planes(&self) -> &[Row] {
        &self.space.planes
    }

    /// Plane of a face.
    #[inline(always)]
    pub(super) fn plane(&self, face: usize) -> Plane {
        let [x, y, z, offset] = self.space.planes[face];
        Plane { normal: vec3(x, y, z), offset }
    }

    #[inline(always)]
    fn vertex(&self, number: usize) -> Vec3 {
        let [x, y, z, _] = self.space.vertices[number];
        vec3(x, y, z)
    }

    /// Smallest bounding box.
    #[inline(always)]
    pub(super) fn bounds<S: Simd>(&self, simd: S) -> Aabb {
        let mut low = Vec3w::splat(simd, Vec3::splat(f32::INFINITY));
        let mut high = -low;
        for v in &self.space.corners {
            let v = Vec3w::load(simd, v);
            low = Vec3w { x: min(v.x, low.x), y: min(v.y, low.y), z: min(v.z, low.z) };
            high = Vec3w { x: max(v.x, high.x), y: max(v.y, high.y), z: max(v.z, high.z) };
        }
        let low = vec3(reduce_min(low.x), reduce_min(low.y), reduce_min(low.z));
        let high = vec3(reduce_max(high.x), reduce_max(high.y), reduce_max(high.z));
        Aabb::new(low, high).grown(self.radius)
    }

    /// Minimum of `normal` · (v - `at`) over the vertices.
    #[inline(always)]
    pub(super) fn min_along<S: Simd>(&self, simd: S, normal: Vec3, at: Vec3) -> f32 {
        let (n, at) = (Vec3w::splat(simd, normal), Vec3w::splat(simd, at));
        let mut low = splat(simd, f32::INFINITY);
        for v in &self.space.corners {
            low = min(low, n.dot(Vec3w::load(simd, v) - at));
        }
        reduce_min(low)
    }

    /// Height of the lowest vertex that is more than `limit` above the plane of a triangle [m].
    #[inline(always)]
    pub(super) fn next_above<S: Simd>(&self, simd: S, triangle: &Triangle, limit: f32) -> f32 {
        let infinite = splat(simd, f32::INFINITY);
        let limit = limit + self.radius;
        let (n, at) = (triangle.normal, triangle.corners[0]);
        let (n, at) = (Vec3w::splat(simd, n), Vec3w::splat(simd, at));
        let mut next = infinite;
        for v in &self.space.corners {
            let height = n.dot(Vec3w::load(simd, v) - at);
            next = min(next, select(above(height, splat(simd, limit)), height, infinite));
        }
        reduce_min(next) - self.radius
    }

    /// Returns true if no normal over edge `k`, from the triangle's to the neighbor's, separates
    /// more than `limit`. Every vertex bounds the separation, by its height over the plane and its
    /// distance beyond the edge.
    #[inline(always)]
    pub(super) fn is_within<S: Simd>(
        &self,
        simd: S,
        triangle: &Triangle,
        k: usize,
        limit: f32,
    ) -> bool {
        let bend = triangle.bend(k);
        let (cos, sin) = (greater(bend.cos, 0.0), if bend.cos < 0.0 { 1.0 } else { bend.sin });
        let (cos, sin) = (splat(simd, cos), splat(simd, sin));
        let up = Vec3w::splat(simd, triangle.normal);
        let outward = Vec3w::splat(simd, triangle.outward[k]);
        let corner = Vec3w::splat(simd, triangle.corners[k]);
        let zero = splat(simd, 0.0);
        let mut low = splat(simd, f32::INFINITY);
        for v in &self.space.corners {
            let to = Vec3w::load(simd, v) - corner;
            let (height, beyond) = (up.dot(to), outward.dot(to));
            low = min(low, max(height, height * cos) + max(beyond, zero) * sin);
        }
        bits(above(low, splat(simd, limit))) != ALL
    }

    /// Number of groups of faces.
    pub(super) fn face_groups(&self) -> usize {
        self.space.offsets.len()
    }

    /// Bit mask of the faces of a group.
    pub(super) fn faces_in(&self, group: usize) -> u32 {
        lanes_in_use(self.space.planes.len(), group)
    }

    /// Distance of the triangle from each of eight faces [m].
    #[inline(always)]
    pub(super) fn heights<S: Simd>(&self, simd: S, group: usize, triangle: &Triangle) -> Wide<S> {
        let n = Vec3w::load(simd, &self.space.normals[group]);
        let offset = load(simd, &self.space.offsets[group]);
        let a = n.dot(Vec3w::splat(simd, triangle.corners[0]));
        let b = n.dot(Vec3w::splat(simd, triangle.corners[1]));
        let c = n.dot(Vec3w::splat(simd, triangle.corners[2]));
        min(min(a, b), c) - offset
    }

    /// Returns the face most opposite to `normal`, the first of several.
    #[inline(always)]
    pub(super) fn face_against<S: Simd>(&self, simd: S, normal: Vec3) -> usize {
        let along = Vec3w::splat(simd, normal);
        let mut face = 0;
        let mut low = f32::INFINITY;
        for (group, n) in self.space.normals.iter().enumerate() {
            let d = Vec3w::load(simd, n).dot(along);
            let below = reduce_min(d);
            if below < low {
                low = below;
                let lanes = !bits(above(d, splat(simd, below)));
                face = group * LANES + lanes.trailing_zeros() as usize;
            }
        }
        face
    }

    /// Finds the vertices over the triangle with a distance of at least `minimum` [m]; 0: apart
    /// ones only.
    #[inline(always)]
    pub(super) fn find_vertices_over<S: Simd>(
        &mut self,
        simd: S,
        triangle: &Triangle,
        minimum: f32,
    ) {
        let (zero, lowest) = (splat(simd, 0.0), splat(simd, minimum));
        let (up, at) = (Vec3w::splat(simd, triangle.normal), triangle.corners[0]);
        let at = Vec3w::splat(simd, at);
        let space = &mut *self.space;
        space.over.clear();
        for (group, v) in space.corners.iter().enumerate() {
            let v = Vec3w::load(simd, v);
            let apart = up.dot(v - at) - splat(simd, self.radius);
            let mut outside = splat(simd, f32::NEG_INFINITY);
            for k in 0..3 {
                let outward = Vec3w::splat(simd, triangle.outward[k]);
                let d = outward.dot(v - Vec3w::splat(simd, triangle.corners[k]));
                outside = max(outside, d);
            }
            let mut over = !bits(above(lowest, apart) | above(outside, zero)) & ALL;
            if over == 0 {
                continue;
            }
            let mut heights = [0.0; LANES];
            apart.store_array(&mut heights);
            while over != 0 {
                let i = over.trailing_zeros();
                over &= over - 1;
                let number = group * LANES + i as usize;
                if number < space.vertices.len() {
                    #[expect(
                        clippy::cast_possible_truncation,
                        reason = "vertices have u16 numbers"
                    )]
                    space.over.push((number as u32, heights[i as usize]));
                }
            }
        }
    }

    /// Returns the vertices found, each with its distance [m].
    pub(super) fn vertices_over(&self) -> impl Iterator<Item = (u32, Vec3, f32)> {
        self.space.over.iter().map(|&(i, apart)| (i, self.vertex(i as usize), apart))
    }

    /// Places the edges.
    #[inline(always)]
    fn place_edges<S: Simd>(&mut self, simd: S) {
        let x = Vec3w::splat(simd, self.turn.x);
        let y = Vec3w::splat(simd, self.turn.y);
        let z = Vec3w::splat(simd, self.turn.z);
        let position = Vec3w::splat(simd, self.position);
        for group in self.hull.lanes.edges() {
            let zero = [[0.0; LANES]; 3];
            let mut placed = Edges { start: zero, along: zero, normals: [zero; 2] };
            let (p, q) = (group.ends[0].load(simd), group.ends[1].load(simd));
            let start = x * p.x + y * p.y + z * p.z + position;
            start.store(&mut placed.start);
            // Difference of the placed ends, equal to the difference of the placed vertices.
            (x * q.x + y * q.y + z * q.z + position - start).store(&mut placed.along);
            for side in 0..2 {
                let n = group.normals[side].load(simd);
                (x * n.x + y * n.y + z * n.z).store(&mut placed.normals[side]);
            }
            self.space.edges.push(placed);
        }
    }

    /// Returns the edge of the polytope whose axis with edge `k` of the triangle has the largest
    /// separation, if that is more than `limit`.
    #[inline(always)]
    pub(super) fn best_edge<S: Simd>(
        &mut self,
        simd: S,
        (triangle, k): (&Triangle, usize),
        limit: f32,
        reach: f32,
    ) -> Result<Option<EdgeAxis>, Separated> {
        if self.space.edges.is_empty() {
            self.place_edges(simd);
        }
        let [a, b] = triangle.edge(k);
        let along = Vec3w::splat(simd, b - a);
        let start = Vec3w::splat(simd, a);
        let outward = Vec3w::splat(simd, triangle.outward[k]);
        let up = Vec3w::splat(simd, triangle.normal);
        let square = splat(simd, PARALLEL * PARALLEL * (b - a).length_squared());
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let nothing = splat(simd, f32::NEG_INFINITY);
        let reach = splat(simd, reach);
        let mut best = None;
        let mut largest = limit;
        for (group, edges) in self.space.edges.iter().enumerate() {
            let u = Vec3w::load(simd, &edges.normals[0]);
            let v = Vec3w::load(simd, &edges.normals[1]);
            // If both face normals are on one side of `along`, no normal between them is
            // perpendicular to it.
            let aside = above(u.dot(along) * v.dot(along), zero);
            if bits(aside) == ALL {
                continue;
            }
            let d = Vec3w::load(simd, &edges.along);
            let cross = along.cross(d);
            let size = cross.dot(cross);
            let axis = cross * (one / sqrt(size));
            let out = axis.dot(outward);
            let flat = !above(out, zero) & above(zero, axis.dot(up));
            let axis = Vec3w::select(above(zero, out) | flat, -axis, axis);
            let separation = axis.dot(Vec3w::load(simd, &edges.start) - start);
            let proper = above(size, square * d.dot(d)) & above(separation, splat(simd, largest));
            let open = proper & !aside;
            if bits(open) == 0 {
                continue;
            }
            let open = open & supports(simd, axis, (u, v, d));
            if bits(open & above(separation, reach)) != 0 {
                return Err(Separated(reduce_max(select(open, separation, nothing))));
            }
            let open = open & triangle.allows_at_edge(simd, k, axis);
            if bits(open) == 0 {
                continue;
            }
            largest = reduce_max(select(open, separation, nothing));
            let first = bits(open & !above(splat(simd, largest), separation)).trailing_zeros();
            let first = first as usize;
            let mut lanes = [[0.0; LANES]; 3];
            axis.store(&mut lanes);
            best = Some(EdgeAxis {
                edge: 2 * (group * LANES + first),
                normal: vec3(lanes[0][first], lanes[1][first], lanes[2][first]),
                separation: largest,
            });
        }
        Ok(best)
    }

    /// Both ends of the edge that starts with half-edge `edge`.
    #[inline(always)]
    pub(super) fn ends(&self, edge: usize) -> [Vec3; 2] {
        [edge, edge ^ 1].map(|e| self.origin(self.hull.edges[e]))
    }

    /// Calls `f` with the half-edges of a face.
    #[inline(always)]
    pub(super) fn around(&self, face: usize, mut f: impl FnMut(HalfEdge)) {
        let first = self.hull.face_edges[face];
        let mut e = first;
        loop {
            let edge = self.hull.edges[usize::from(e)];
            f(edge);
            e = edge.next;
            if e == first {
                return;
            }
        }
    }

    /// Start vertex of a half-edge.
    #[inline(always)]
    pub(super) fn origin(&self, edge: HalfEdge) -> Vec3 {
        self.vertex(usize::from(edge.origin))
    }

    /// The half-edge after `edge`.
    #[inline(always)]
    pub(super) fn next(&self, edge: HalfEdge) -> HalfEdge {
        self.hull.edges[usize::from(edge.next)]
    }
}

/// Returns true where an axis supports the polytope at an edge with face normals u and v along d:
/// its opposite lies between the normals [Gregorius13].
#[inline(always)]
fn supports<S: Simd>(
    simd: S,
    axis: Vec3w<S>,
    (u, v, d): (Vec3w<S>, Vec3w<S>, Vec3w<S>),
) -> Mask<S> {
    let zero = splat(simd, 0.0);
    let turn = u.cross(v).dot(d);
    let opposite = -axis;
    let before = above(zero, u.cross(opposite).dot(d) * turn);
    let after = above(zero, opposite.cross(v).dot(d) * turn);
    !(before | after)
}

#[inline(always)]
fn push_rows<S: Simd>(to: &mut Vec<Row>, rows: [f32x4<S>; LANES]) {
    let mut block = [[0.0; 4]; LANES];
    for i in 0..LANES {
        rows[i].store_array(&mut block[i]);
    }
    to.extend_from_slice(&block);
}
