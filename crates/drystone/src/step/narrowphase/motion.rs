//! Motion of convex shapes against meshes, for eight pairs at a time. The motion of the shape, not
//! of its body, decides whether such a pair must be tested, and its speculative distance. A long
//! body with many shapes turns little at its center and much at its tip.

use fearless_simd::{Simd, SimdBase};

use super::waits::{Rows, columns, with};
use crate::base::math::{Vec3, vec3};
use crate::base::simd::wide::{Lanes, Vec3w, Wide, max, splat, sqrt};
use crate::base::simd::wide_quat::Quatw;
use crate::state::bodies::body::Body;
use crate::state::contacts::Probe;
use crate::state::shapes::ShapeRow;

/// Motion of a convex shape against a mesh: that of the corners of the box around its core. Each
/// point of the core is between the corners, so its motion is too. (The rounding moves with the
/// core: a ball that turns stays in place.)
#[derive(Clone, Copy, Debug)]
pub(super) struct Motion {
    /// Radius of a ball around the shape [m].
    pub(super) radius: f32,
    /// Velocity of the box's center against the mesh [m/s, frame of the shape's body].
    pub(super) velocity: Vec3,
    /// Maximum speed of a corner relative to the center, and its sum with the center's speed [m/s].
    /// The sum is a bound, since an impact at another end may stop one of the two motions and leave
    /// the other.
    pub(super) spin: f32,
    pub(super) speed: f32,
    /// Maximum displacement of a corner since the reference, in the frame of the mesh [m].
    pub(super) since: f32,
}

/// Motions of eight shapes.
#[derive(Clone, Debug, Default)]
pub(super) struct Motions {
    radius: Lanes,
    velocity: [Lanes; 3],
    spin: Lanes,
    speed: Lanes,
    since: Lanes,
}

impl Motions {
    #[inline]
    pub(super) fn at(&self, lane: usize) -> Motion {
        let [x, y, z] = &self.velocity;
        Motion {
            radius: self.radius[lane],
            velocity: vec3(x[lane], y[lane], z[lane]),
            spin: self.spin[lane],
            speed: self.speed[lane],
            since: self.since[lane],
        }
    }
}

/// Inputs of eight pairs of a mesh of body A and a shape of body B, in the layout of the tables.
/// Values of unused lanes do not matter.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub(super) struct Pairs {
    /// Center of B minus that of A, now and at the reference [world]; w: rounding radius of the
    /// shape.
    offset: Rows,
    offset_then: Rows,
    rotation_a: Rows,
    rotation_a_then: Rows,
    rotation_b: Rows,
    rotation_b_then: Rows,
    v_a: Rows,
    v_b: Rows,
    w_a: Rows,
    w_b: Rows,
    /// Pose of the shape [frame of B's center of mass].
    position: Rows,
    rotation: Rows,
    /// Box around the shape's core [frame of the shape].
    center: Rows,
    half: Rows,
}

impl Pairs {
    #[inline]
    pub(super) fn fill(&mut self, lane: usize, r: &Probe, a: &Body, b: &Body, shape_b: &ShapeRow) {
        let (core, placed) = (shape_b.solid.core_box(), &shape_b.centered);
        self.offset[lane] = with(b.center - a.center, shape_b.solid.radius);
        self.offset_then[lane] = with(r.offset, 0.0);
        self.rotation_a[lane] = bytemuck::cast(a.rotation);
        self.rotation_a_then[lane] = bytemuck::cast(r.rotation_a);
        self.rotation_b[lane] = bytemuck::cast(b.rotation);
        self.rotation_b_then[lane] = bytemuck::cast(r.rotation_b);
        self.v_a[lane] = with(a.v, 0.0);
        self.v_b[lane] = with(b.v, 0.0);
        self.w_a[lane] = with(a.w, 0.0);
        self.w_b[lane] = with(b.w, 0.0);
        self.position[lane] = with(placed.position, 0.0);
        self.rotation[lane] = bytemuck::cast(placed.rotation);
        self.center[lane] = with(core.center(), 0.0);
        self.half[lane] = with(core.half_extents(), 0.0);
    }

    /// Computes the motions.
    #[inline(always)]
    pub(super) fn find<S: Simd>(&self, simd: S, motions: &mut Motions) {
        let (apart, rounding) = columns(simd, &self.offset);
        let rotation_a = Quatw::of_rows(simd, &self.rotation_a);
        let rotation_b = Quatw::of_rows(simd, &self.rotation_b);
        let rotation_a_then = Quatw::of_rows(simd, &self.rotation_a_then);
        let rotation_b_then = Quatw::of_rows(simd, &self.rotation_b_then);
        let placed = Quatw::of_rows(simd, &self.rotation);
        let half = vectors(simd, &self.half);
        // From here on in the frame of the shape's body.
        let axes = placed.axes(simd);
        let (x, y, z) = (axes[0] * half.x, axes[1] * half.y, axes[2] * half.z);
        let center =
            placed.rotate(simd, vectors(simd, &self.center)) + vectors(simd, &self.position);
        let now = rotation_a.to(rotation_b).axes(simd);
        let before = rotation_a_then.to(rotation_b_then).axes(simd);
        let turn = [now[0] - before[0], now[1] - before[1], now[2] - before[2]];
        let shift = rotation_a.unrotate(simd, apart)
            - rotation_a_then.unrotate(simd, vectors(simd, &self.offset_then));
        let (w_a, v_a) = (vectors(simd, &self.w_a), vectors(simd, &self.v_a));
        let w = rotation_b.unrotate(simd, vectors(simd, &self.w_b) - w_a);
        let v = rotation_b.unrotate(simd, vectors(simd, &self.v_b) - (v_a + w_a.cross(apart)));
        let velocity = v + w.cross(center);
        let (mut moved, mut spin) = (splat(simd, 0.0), splat(simd, 0.0));
        // For each corner and the opposite one.
        for arm in [x + y + z, x + y - z, x - y + z, x - y - z] {
            for corner in [center + arm, center - arm] {
                moved = max(moved, square(turned(&turn, corner) + shift));
            }
            spin = max(spin, square(w.cross(arm)));
        }
        let spin = sqrt(spin);
        (sqrt(square(half)) + rounding).store_array(&mut motions.radius);
        velocity.store(&mut motions.velocity);
        spin.store_array(&mut motions.spin);
        (sqrt(square(velocity)) + spin).store_array(&mut motions.speed);
        sqrt(moved).store_array(&mut motions.since);
    }
}

#[inline(always)]
fn vectors<S: Simd>(simd: S, rows: &Rows) -> Vec3w<S> {
    columns(simd, rows).0
}

#[inline(always)]
fn turned<S: Simd>([x, y, z]: &[Vec3w<S>; 3], v: Vec3w<S>) -> Vec3w<S> {
    *x * v.x + *y * v.y + *z * v.z
}

#[inline(always)]
fn square<S: Simd>(v: Vec3w<S>) -> Wide<S> {
    v.dot(v)
}
