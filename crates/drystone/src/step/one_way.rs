//! One-way surfaces: decides whether a surface stops a body, by the body's position and velocity.
//!
//! A pair is held while it has points. It becomes held only if the body comes from the front and is
//! not in the surface yet. So a body that passes needs no stored state: it has no points until it
//! is out.

use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::geometry::manifold::Manifold;
use crate::state::bodies::body::Body;
use crate::state::shapes::Shapes;
use crate::step::context::StepContext;

/// Minimum cosine of the angle between the front's direction and the normal of a contact at the
/// front. Sides, which are at right angles, let bodies pass; slopes of 60 degrees hold.
const FRONT: f32 = 0.5;

/// Maximum depth at which a body still counts as on the surface: this part of its half thickness,
/// and at most the contact margin. Placing a body on a surface involves rounding.
const ON_IT: f32 = 0.25;

/// Direction of a surface's front [world]; `None` if it holds from all sides.
pub(crate) fn front(shapes: &Shapes, row: u32, body: &Body) -> Option<Vec3> {
    let shape = shapes.at(row);
    if !shape.reports.is_one_way() {
        return None;
    }
    let local = shapes.one_way.get(&row)?;
    Some(body.rotation.rotate(shape.centered.rotation.rotate(*local)))
}

/// Fronts of both shapes of a pair.
pub(crate) type Fronts = [Option<Vec3>; 2];

/// True if a pair of shapes with these fronts touches where its manifold says. `held`: the pair had
/// points before.
pub(crate) fn holds(
    ctx: &StepContext,
    fronts: &Fronts,
    bodies: [&Body; 2],
    (manifold, pose_a): (&Manifold, &Pose),
    held: bool,
) -> bool {
    let normal = pose_a.direction(manifold.normal);
    (0..2).all(|side| {
        let Some(front) = fronts[side] else { return true };
        let out = if side == 0 { normal } else { -normal };
        if front.dot(out) < FRONT {
            return false;
        }
        let (mine, other) = (bodies[side], bodies[1 - side]);
        let maximum = if other.is_dynamic() { ON_IT * other.inner } else { f32::INFINITY };
        let comes = |position: Vec3| {
            let at = pose_a.point(position);
            let velocity = |body: &Body| body.velocity_at(at - body.center);
            (velocity(other) - velocity(mine)).dot(front) <= 0.0
        };
        let points = manifold.points();
        held || points.iter().all(|p| p.separation >= -ctx.margin.min(maximum))
            && points.iter().any(|p| comes(p.position))
    })
}

/// True if a ray along `delta` that hits a shape at this normal is stopped [world].
pub(crate) fn stops(shapes: &Shapes, row: u32, body: &Body, normal: Vec3, delta: Vec3) -> bool {
    front(shapes, row, body)
        .is_none_or(|front| front.dot(normal) >= FRONT && front.dot(delta) < 0.0)
}

/// True if two shapes may stop each other, where the second moves by `shift` relative to the first
/// [m, world].
pub(crate) fn may_stop(shapes: &Shapes, rows: [u32; 2], bodies: [&Body; 2], shift: Vec3) -> bool {
    let comes = |side: usize, shift: Vec3| {
        front(shapes, rows[side], bodies[side]).is_none_or(|front| front.dot(shift) < 0.0)
    };
    comes(0, shift) && comes(1, -shift)
}
