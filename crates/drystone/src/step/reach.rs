//! How far contacts are looked for: broadphase, narrowphase and the solver must agree on it.

use fearless_simd::{Simd, dispatch};

use super::context::StepContext;
use crate::base::aabb::Aabb;
use crate::base::math::{Mat3, Vec3, vec3};
use crate::base::pose::Pose;
use crate::base::quat::Quat;
use crate::state::bodies::Body;
use crate::state::shapes::{ShapeRow, Shapes};

/// The box that a shape needs in the tree.
pub(crate) struct Need {
    /// Its own with the contact margin; of one that turns far in the step the box of all that it may sweep.
    pub(crate) tight: Aabb,
    /// How far it moves in a step [m].
    step: Vec3,
}

/// A turn in a step that takes a shape out of its box [rad].
pub(crate) const FAR_TURN: f32 = 0.5;

impl Need {
    /// The rotation of a body of several shapes.
    pub(crate) fn turn_of(body: &Body) -> Option<Mat3> {
        (body.shapes.len() > 1).then(|| body.rotation.to_mat3())
    }

    /// `turn`: the body's rotation, for what is one of several shapes.
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
        if body.w.length_squared() * (ctx.dt * ctx.dt) >= FAR_TURN * FAR_TURN {
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

    /// The box that reaches as far as the shape moves in a step.
    #[inline(always)]
    pub(crate) fn fits(&self) -> Aabb {
        swept(&self.tight, self.step)
    }

    /// That box, `fits`, with room to move, so that the tree is not changed every step; none for what will leave it
    /// all the same.
    pub(crate) fn with_room(&self, fits: &Aabb, body: &Body, ctx: &StepContext) -> Aabb {
        if flies(body, ctx) {
            return *fits;
        }
        swept(fits, self.step).grown(spare(body, ctx))
    }
}

/// Around a box and where it comes by `step`.
#[inline(always)]
pub(crate) fn swept(fits: &Aabb, step: Vec3) -> Aabb {
    fits.union(&Aabb::new(fits.min + step, fits.max + step))
}

/// How far what has this velocity moves in a step [m], but no farther along an axis than the body's size: contacts
/// are not looked for beyond that (narrowphase), only rays are cast (sweep). (Cut along its way instead, what
/// flies along a wall would come into it unseen.)
pub(crate) fn reach(velocity: Vec3, body: &Body, ctx: &StepContext) -> Vec3 {
    let step = velocity * ctx.dt;
    let most = if body.extent > 0.0 { body.extent } else { f32::INFINITY };
    vec3(step.x.clamp(-most, most), step.y.clamp(-most, most), step.z.clamp(-most, most))
}

/// That of all shapes of a body, at most [m].
pub(crate) fn reach_of_all(body: &Body, ctx: &StepContext) -> f32 {
    let turning =
        if body.shapes.len() > 1 { body.w.length() * (body.extent * ctx.dt) } else { 0.0 };
    reach(body.v, body, ctx).length() + turning
}

/// Room around a box [m].
pub(crate) fn spare(body: &Body, ctx: &StepContext) -> f32 {
    ctx.margin + (0.1 * body.extent).min(0.1 * ctx.length)
}

/// True if a body moves so far beyond its [`reach`] in a step that no box with room keeps it for two.
/// (Of a diagonal way each axis sees 1/√3 at least.)
pub(crate) fn flies(body: &Body, ctx: &StepContext) -> bool {
    let step = body.v * ctx.dt;
    step.length() - reach(body.v, body, ctx).length() > 2.0 * spare(body, ctx)
}

/// Contacts are looked for as far as the bodies may come nearer in this step: a fast body is then stopped at
/// the surface, not in it. But no farther than the size of the smaller one, or of both where their bounding
/// spheres meet if nothing stops them. (Boxes reach as far as each one's own size: who flies at a larger one
/// that rests is seen that far only.) Of two that move side by side an impact can stop one, and if the pair
/// bounces it takes part in that.
pub(crate) fn speculative_margin(ctx: &StepContext, a: &Body, b: &Body, bounces: bool) -> f32 {
    let along = b.v - a.v;
    let mut speed = along.length();
    if bounces && a.is_dynamic() && b.is_dynamic() {
        speed = speed.max(a.v.length()).max(b.v.length());
    }
    let speed = speed + a.w.length() * a.extent + b.w.length() * b.extent;
    let size = |body: &Body| if body.is_dynamic() { body.extent } else { f32::INFINITY };
    let way = 1.1 * speed * ctx.dt;
    let mut most = size(a).min(size(b));
    if way > most && a.is_dynamic() && b.is_dynamic() {
        let apart = b.center - a.center;
        if will_meet(apart, along * (1.1 * ctx.dt), a.extent + b.extent) {
            most = a.extent + b.extent;
        }
    }
    ctx.margin.max(way.min(most))
}

/// True if two points, the second of which is at `apart` from the first and goes by `way`, come as near as `near`.
fn will_meet(apart: Vec3, way: Vec3, near: f32) -> bool {
    let nearest = (-apart.dot(way) / way.dot(way).max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
    let then = apart + way * nearest;
    then.dot(then) <= near * near
}
