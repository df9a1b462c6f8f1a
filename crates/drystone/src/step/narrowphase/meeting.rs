//! Look-ahead normals: the manifold of a round shape where it meets the other shape within the
//! step.
//!
//! The normal between a ball and an edge ahead of it points back along the ball's path, and turns
//! up as the ball comes near. A contact with the present normal stops the ball in front of the
//! edge, as a wall would. So a contact that acts within the step takes its normal and arms from the
//! place where the two meet. If they do not meet, it takes those of the place where they are
//! nearest on the path: a shape that stays in front of that plane does not enter the other shape.
//!
//! Between polytopes the normal is mostly that of a face, which does not turn along the path. Mesh
//! triangles are handled one by one (`geometry/collide/mesh/round.rs`).

use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::geometry::approach::{Course, Sliding, meet};
use crate::geometry::collide::collide;
use crate::geometry::manifold::{Manifold, PairCache};
use crate::geometry::solid::{Core, Solid};
use crate::state::bodies::body::Body;
use crate::step::context::StepContext;

/// A normal stays if its turning displaces the surface by no more than this part of the radius
/// within the step. Over the gap it turns by gap · along / (closing · radius), where `along` is the
/// displacement tangential to it and `closing` the displacement along it.
const TURN: f32 = 1.0e-3;

/// Bisection steps to the place on the path where two shapes are nearest.
const HALVINGS: usize = 6;

/// A shape moves straight if its ends turn about its middle by no more than this part of its
/// displacement.
pub(super) const STRAIGHT: f32 = 0.1;

/// The manifold at the place where the two meet, or at the end of the step; `None` if the present
/// manifold `m` is accurate enough.
pub(super) fn look_ahead(
    ctx: &StepContext,
    [a, b]: [&Body; 2],
    [solid_a, solid_b]: [&Solid; 2],
    (pose_a, b_in_a): (&Pose, &Pose),
    m: &Manifold,
) -> Option<Manifold> {
    let nearest = m.points().iter().map(|p| p.separation).fold(f32::INFINITY, f32::min);
    if m.count == 0 || !(nearest > 0.0) {
        return None;
    }
    let radius = curvature(solid_a).max(curvature(solid_b));
    if !(radius > 0.0) || matches!(solid_a.core, Core::HalfSpace { .. }) {
        return None;
    }
    let moves = b.v - a.velocity_at(b.center - a.center);
    let displacement = pose_a.local_direction(moves) * ctx.dt;
    let closing = -m.normal.dot(displacement);
    let along = (displacement + m.normal * closing).length();
    // A row acts a substep before the touch, and in the last sweep up to a step before it.
    if !(2.0 * closing > nearest) || nearest * along < TURN * radius * radius {
        return None;
    }
    let spin = b.w - a.w;
    let turns = |solid: &Solid, axis: Vec3| half_height(solid) * spin.cross(axis).length();
    let (axis_a, axis_b) = (Vec3::Y, b_in_a.direction(Vec3::Y));
    let [axis_a, axis_b] = [axis_a, axis_b].map(|axis| pose_a.direction(axis));
    if turns(solid_a, axis_a).max(turns(solid_b, axis_b)) > STRAIGHT * moves.length() {
        return None;
    }
    let at = |fraction: f32, margin: f32| {
        let position = b_in_a.position + displacement * fraction;
        let then = Pose { position, ..*b_in_a };
        collide(ctx.level, solid_a, solid_b, &then, margin, &mut PairCache::default())
    };
    let met = meet(solid_a, solid_b, b_in_a, &Course::straight(displacement), &Sliding::default());
    let fraction = met.map_or_else(
        || {
            let reach = nearest + 2.0 * displacement.length();
            nearest_on_way(|fraction| at(fraction, reach).normal.dot(displacement))
        },
        |met| met.fraction,
    );
    let mut m = at(fraction, ctx.margin);
    if m.count == 0 {
        return Some(Manifold::default());
    }
    let shift = displacement * fraction;
    m.shift = shift;
    for p in &mut m.points[..m.count] {
        p.separation -= m.normal.dot(shift);
    }
    Some(m)
}

/// Part of a path without impact at which two shapes are nearest to each other: there the plane
/// between them is parallel to the path. `leaves` is positive where they move apart.
fn nearest_on_way(leaves: impl Fn(f32) -> f32) -> f32 {
    if !(leaves(1.0) > 0.0) {
        return 1.0;
    }
    let (mut before, mut after) = (0.0, 1.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (before + after);
        if leaves(middle) > 0.0 { after = middle } else { before = middle }
    }
    before
}

/// Radius of curvature at which a normal turns [m]; 0 for a flat side.
fn curvature(solid: &Solid) -> f32 {
    match &solid.core {
        Core::Frustum { radius_bottom, radius_top, .. } => radius_bottom.max(*radius_top),
        _ => solid.radius,
    }
}

/// Half the length of an elongated round shape [m].
fn half_height(solid: &Solid) -> f32 {
    match &solid.core {
        Core::Segment { half_height } | Core::Frustum { half_height, .. } => *half_height,
        _ => 0.0,
    }
}
