//! Speculative distances: how far ahead the broadphase, the narrowphase and the solver search for
//! contacts. All three must agree on them.

use fearless_simd::{Simd, dispatch};

use super::context::StepContext;
use crate::base::aabb::Aabb;
use crate::base::math::{Mat3, Vec3, vec3};
use crate::base::pose::Pose;
use crate::base::quat::Quat;
use crate::state::bodies::body::Body;
use crate::state::shapes::{ShapeRow, Shapes};

/// The box that a shape needs in the tree.
pub(crate) struct Need {
    /// The shape's box with the contact margin. If the shape turns far in the step, the box of
    /// everything that it may sweep.
    pub(crate) tight: Aabb,
    /// Displacement in a step [m].
    step: Vec3,
}

/// Minimum rotation in a step that takes a shape out of its box [rad].
pub(crate) const SWEPT_ROTATION: f32 = 0.5;

impl Need {
    /// Rotation of a body with several shapes.
    pub(crate) fn turn_of(body: &Body) -> Option<Mat3> {
        (body.ties.shapes.len() > 1).then(|| body.rotation.to_mat3())
    }

    /// `turn`: the body's rotation, for a shape that is one of several.
    #[inline(always)]
    pub(crate) fn of<S: Simd>(
        simd: S,
        shape: &ShapeRow,
        (body, turn): (&Body, Option<Mat3>),
        ctx: &StepContext,
    ) -> Self {
        let stands = turn.filter(|_| shape.centered.rotation == Quat::IDENTITY);
        let pose = match stands {
            Some(turn) => Pose::new(turn * shape.centered.position + body.center, body.rotation),
            None => shape.placed(body),
        };
        let tight = shape.solid.aabb_with(simd, &pose, stands).grown(0.5 * ctx.margin);
        if body.w.length_squared() * (ctx.dt * ctx.dt) >= SWEPT_ROTATION * SWEPT_ROTATION {
            let around = vec3(body.extent, body.extent, body.extent);
            let around = Aabb::new(body.center - around, body.center + around);
            return Self { tight: tight.union(&around), step: reach(body.v, body, ctx) };
        }
        let velocity = match turn {
            Some(_) => body.velocity_at(tight.center() - body.center),
            None => body.v,
        };
        Self { tight, step: reach(velocity, body, ctx) }
    }

    pub(crate) fn of_shape(shapes: &Shapes, shape: u32, body: &Body, ctx: &StepContext) -> Self {
        dispatch!(ctx.level, simd => Self::of(simd, shapes.at(shape), (body, Self::turn_of(body)), ctx))
    }

    /// The box extended by the shape's displacement in a step.
    #[inline(always)]
    pub(crate) fn fits(&self) -> Aabb {
        swept(&self.tight, self.step)
    }

    /// The box `fits`, grown so that the tree need not change every step. It is not grown for
    /// bodies that will leave it anyway.
    pub(crate) fn with_room(&self, fits: &Aabb, body: &Body, ctx: &StepContext) -> Aabb {
        if flies(body, ctx) {
            return *fits;
        }
        swept(fits, self.step).grown(spare(body, ctx))
    }
}

/// Union of a box and the same box displaced by `step`.
#[inline(always)]
pub(crate) fn swept(fits: &Aabb, step: Vec3) -> Aabb {
    fits.union(&Aabb::new(fits.min + step, fits.max + step))
}

/// Displacement at this velocity in a step [m], clamped on each axis to the body's size. The
/// narrowphase does not search for contacts beyond that; the sweep only casts rays there. (Clamped
/// along the path instead, a body flying along a wall would enter it unseen.)
pub(crate) fn reach(velocity: Vec3, body: &Body, ctx: &StepContext) -> Vec3 {
    let step = velocity * ctx.dt;
    let maximum = if body.extent > 0.0 { body.extent } else { f32::INFINITY };
    vec3(
        step.x.clamp(-maximum, maximum),
        step.y.clamp(-maximum, maximum),
        step.z.clamp(-maximum, maximum),
    )
}

/// Upper bound on the reach of all shapes of a body [m].
pub(crate) fn reach_of_all(body: &Body, ctx: &StepContext) -> f32 {
    let turning =
        if body.ties.shapes.len() > 1 { body.w.length() * (body.extent * ctx.dt) } else { 0.0 };
    reach(body.v, body, ctx).length() + turning
}

/// Margin by which boxes are grown [m].
pub(crate) fn spare(body: &Body, ctx: &StepContext) -> f32 {
    ctx.margin + (0.1 * body.extent).min(0.1 * ctx.length)
}

/// True if a body moves so far beyond its [`reach`] in a step that a grown box does not last for
/// two steps. (On a diagonal path each axis moves by at least 1/√3 of it.)
pub(crate) fn flies(body: &Body, ctx: &StepContext) -> bool {
    let step = body.v * ctx.dt;
    step.length() - reach(body.v, body, ctx).length() > 2.0 * spare(body, ctx)
}

/// Speculative distance of a pair: as far as the bodies may approach each other in this step, so
/// that a fast body is stopped at the surface, not in it. It is at most the size of the smaller
/// body, or the sum of both sizes if their bounding spheres would meet. (Boxes reach only as far as
/// each body's own size, which limits the distance for a fast body near a larger body at rest.) If
/// two bodies move side by side, an impact can stop one of them, so a pair that bounces uses the
/// greater of their speeds too.
pub(crate) fn speculative_margin(ctx: &StepContext, a: &Body, b: &Body, bounces: bool) -> f32 {
    let along = b.v - a.v;
    let mut speed = along.length();
    if bounces && a.is_dynamic() && b.is_dynamic() {
        speed = speed.max(a.v.length()).max(b.v.length());
    }
    let speed = speed + a.w.length() * a.extent + b.w.length() * b.extent;
    let size = |body: &Body| if body.is_dynamic() { body.extent } else { f32::INFINITY };
    let displacement = 1.1 * speed * ctx.dt;
    let mut maximum = size(a).min(size(b));
    if displacement > maximum && a.is_dynamic() && b.is_dynamic() {
        let apart = b.center - a.center;
        if will_meet(apart, along * (1.1 * ctx.dt), a.extent + b.extent) {
            maximum = a.extent + b.extent;
        }
    }
    ctx.margin.max(displacement.min(maximum))
}

/// True if two points come within `near` of each other; the second starts at `apart` from the first
/// and moves by `displacement` relative to it.
fn will_meet(apart: Vec3, displacement: Vec3, near: f32) -> bool {
    let nearest = (-apart.dot(displacement)
        / displacement.dot(displacement).max(f32::MIN_POSITIVE))
    .clamp(0.0, 1.0);
    let then = apart + displacement * nearest;
    then.dot(then) <= near * near
}
