//! How far contacts are looked for: broadphase, narrowphase and the solver must agree on it.

use super::context::StepContext;
use crate::base::math::Vec3;
use crate::state::bodies::Body;

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
