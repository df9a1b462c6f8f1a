//! Finds the triangles of a mesh that a solid may touch before the step ends: eight at a time, by
//! the cheapest axes. The remaining ones are then tested one by one.

use fearless_simd::{Simd, SimdBase};

use super::placed::Row;
use crate::base::aabb::Aabb;
use crate::base::math::{Vec3, greater, lesser};
use crate::base::simd::wide::{
    ALL, LANES, Vec3w, Wide, above, bits, load, max, min, prefetch, reduce_min, select, splat, sqrt,
};
use crate::geometry::mesh::{Mesh, Pack, Window};

/// Prefetch distance, in packs: about the number of outstanding loads of a core.
const PREFETCH: usize = 4;

/// Default of [`Reach::grain`] [m].
const GRAIN: f32 = 1.0e-6;

/// Search range for contacts of a mesh.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reach {
    /// Maximum separation of a contact point, in any direction of motion [m].
    pub(crate) margin: f32,
    /// Maximum distance of a triangle over the motion `displacement`; farther triangles are left
    /// out [m].
    pub(crate) rest: f32,
    /// Expected motion of the solid's center relative to the mesh in this step
    /// [m, frame of the mesh].
    pub(crate) displacement: Vec3,
    /// Whether the solid turns little in the motion, so that its hits on edges can be predicted.
    pub(crate) is_straight: bool,
    /// Whether the solid is fast: its corners over a face are contacts even where an edge is
    /// nearer. After a hit at the edge they may land within the step.
    pub(crate) corners: bool,
    /// Extra search distance, to find the distance of the two when they do not touch [m].
    pub(crate) room: f32,
    /// Points closer than this plus a fraction of the solid's size are merged [m].
    pub(crate) grain: f32,
}

impl Reach {
    /// Equal range in all directions.
    pub(crate) fn still(margin: f32) -> Self {
        let displacement = Vec3::ZERO;
        let (rest, grain) = (margin, GRAIN);
        Self { margin, rest, displacement, is_straight: false, corners: false, room: 0.0, grain }
    }

    /// Scales the grain to a world whose typical body has this length [m].
    pub(crate) fn in_lengths(self, length: f32) -> Self {
        Self { grain: GRAIN * length, ..self }
    }
}

/// A triangle that the solid may reach.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near {
    /// Triangle number in the upper half, pack and lane in the lower half.
    key: u64,
    /// Lower bound on the distance to the solid [m]; below 0: unknown.
    pub(super) apart: f32,
}

impl Near {
    fn new(number: u32, item: u32, lane: usize, apart: f32) -> Self {
        // A mesh has no more than 2^32 triangles, so far fewer packs.
        let place = u64::from(item) * LANES as u64 + lane as u64;
        Self { key: (u64::from(number) << 32) | place, apart }
    }

    /// Triangle number.
    pub(super) const fn number(self) -> u32 {
        (self.key >> 32) as u32
    }

    /// Number of its pack, and its lane there.
    #[expect(clippy::cast_possible_truncation, reason = "the lower half")]
    pub(super) const fn place(self) -> (u32, usize) {
        let place = self.key as u32;
        (place / LANES as u32, place as usize % LANES)
    }
}

/// The rims of a frustum's ends: unit axis, and the radius at each of the two points [m].
pub(super) type Discs = (Vec3, [f32; 2]);

/// The solid in the frame of the mesh, in the form that these tests use.
#[derive(Debug)]
pub(super) struct Outline<'a> {
    /// Bounding box, including the rounding.
    pub(super) bounds: Aabb,
    /// Bounding box of the core along its own axes: center, unit axes and half extents [m].
    pub(super) core: (Vec3, [Vec3; 3], Vec3),
    /// Point that decides on which side of a triangle the solid is.
    pub(super) center: Vec3,
    /// Corners, relative to the center.
    pub(super) points: &'a [Row],
    pub(super) discs: Option<Discs>,
    /// Faces: normals and offsets.
    pub(super) planes: &'a [Row],
    /// Rounding [m].
    pub(super) radius: f32,
}

/// Lists the triangles that the solid may reach, sorted by number. Returns a lower bound on the
/// distance [m] of the solid from all others.
#[inline(always)]
pub(super) fn find<S: Simd>(
    simd: S,
    mesh: &Mesh,
    solid: &Outline<'_>,
    reach: &Reach,
    [stack, packs]: [&mut Vec<u32>; 2],
    near: &mut Vec<Near>,
) -> f32 {
    near.clear();
    let displacement = reach.displacement;
    let moved = Aabb::new(solid.bounds.min + displacement, solid.bounds.max + displacement);
    let look = reach.rest + reach.room;
    let (center, axes, half) = solid.core;
    let mut along = Vec3::ZERO;
    along.x = 0.5 * axes[0].dot(displacement).abs() + solid.radius + look;
    along.y = 0.5 * axes[1].dot(displacement).abs() + solid.radius + look;
    along.z = 0.5 * axes[2].dot(displacement).abs() + solid.radius + look;
    let window = Window {
        bounds: solid.bounds.grown(look).union(&moved.grown(reach.rest)),
        center: center + displacement * 0.5,
        axes,
        half: half + along,
    };
    // The window extends `look` beyond the solid, so everything outside it is at least that far
    // away.
    let others = look + mesh.tree().find(simd, &window, stack, packs);
    let mut gap = splat(simd, others);
    let rest = splat(simd, reach.rest);
    // Prefetches the first packs, before the loop reads the first one.
    for &item in packs.iter().take(PREFETCH) {
        prefetch(mesh.pack(item));
    }
    for (k, &item) in packs.iter().enumerate() {
        if let Some(soon) = packs.get(k + PREFETCH) {
            prefetch(mesh.pack(*soon));
        }
        let pack = mesh.pack(item);
        let (apart, missed) = test(simd, pack, solid, reach);
        // Lanes not in use repeat another triangle.
        let left_out = above(missed, rest);
        gap = select(left_out, min(gap, apart), gap);
        let numbers = pack.numbers();
        let mut reached = !bits(left_out) & ((1 << numbers.len()) - 1);
        if reached == 0 {
            continue;
        }
        let mut distances = [0.0; LANES];
        apart.store_array(&mut distances);
        while reached != 0 {
            let lane = reached.trailing_zeros() as usize;
            reached &= reached - 1;
            prefetch(mesh.face(item, lane));
            near.push(Near::new(numbers[lane], item, lane, distances[lane]));
        }
    }
    near.sort_unstable_by_key(|n| n.key);
    reduce_min(gap)
}

/// For each lane: lower bounds on the current distance of triangle and solid, and on their distance
/// during the solid's motion.
#[inline(always)]
fn test<S: Simd>(simd: S, pack: &Pack, solid: &Outline<'_>, reach: &Reach) -> (Wide<S>, Wide<S>) {
    let zero = splat(simd, 0.0);
    let rest = splat(simd, reach.rest);
    let mut apart = splat(simd, f32::NEG_INFINITY);
    let mut missed = apart;
    for axis in 0..3 {
        let [p, q, r] = &pack.corners;
        let (p, q, r) = (load(simd, &p[axis]), load(simd, &q[axis]), load(simd, &r[axis]));
        let displacement = reach.displacement[axis];
        let (back, on) =
            (splat(simd, lesser(displacement, 0.0)), splat(simd, greater(displacement, 0.0)));
        let over = splat(simd, solid.bounds.min[axis]) - max(max(p, q), r);
        let under = min(min(p, q), r) - splat(simd, solid.bounds.max[axis]);
        apart = max(apart, max(over, under));
        missed = max(missed, max(over + back, under - on));
    }
    if bits(above(missed, rest)) == ALL {
        return (apart, missed);
    }
    let [p, q, r] = Vec3w::load3(simd, &pack.corners);
    let normal = Vec3w::load(simd, &pack.normals);
    let height = normal.dot(Vec3w::splat(simd, solid.center) - p);
    // Normal on the side of the solid.
    let normal = Vec3w::select(above(zero, height), -normal, normal);
    let mut low = splat(simd, f32::INFINITY);
    if let Some((axis, radii)) = &solid.discs {
        let along = normal.dot(Vec3w::splat(simd, *axis));
        let across = sqrt(max(splat(simd, 1.0) - along * along, zero));
        for (v, radius) in solid.points.iter().zip(radii) {
            low = min(low, normal.dot(across_lanes(simd, v)) - splat(simd, *radius) * across);
        }
    } else {
        for v in solid.points {
            low = min(low, normal.dot(across_lanes(simd, v)));
        }
    }
    let over = height.abs() + low - splat(simd, solid.radius);
    let closing = min(normal.dot(Vec3w::splat(simd, reach.displacement)), zero);
    apart = max(apart, over);
    missed = max(missed, over + closing);
    if bits(above(missed, rest)) == ALL {
        return (apart, missed);
    }
    let displacement = Vec3w::splat(simd, reach.displacement);
    for plane in solid.planes {
        let n = across_lanes(simd, plane);
        let closing = max(n.dot(displacement), zero);
        let offset = splat(simd, plane[3] + solid.radius);
        let over = min(min(n.dot(p), n.dot(q)), n.dot(r)) - offset;
        apart = max(apart, over);
        missed = max(missed, over - closing);
    }
    (apart, missed)
}

#[inline(always)]
fn across_lanes<S: Simd>(simd: S, [x, y, z, _]: &Row) -> Vec3w<S> {
    Vec3w { x: splat(simd, *x), y: splat(simd, *y), z: splat(simd, *z) }
}
