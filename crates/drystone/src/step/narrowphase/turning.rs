//! Properties of contacts for the solver: how far their bodies turn, against each other and
//! together (docs/derivations/friction.md, "What turns together"), and whether they may be parted.

use super::change::Change;
use crate::base::math::Vec3;
use crate::geometry::solid::Core;
use crate::state::bodies::NONE;
use crate::state::bodies::body::Body;
use crate::state::contacts::{Contact, Point, Traits};
use crate::state::shapes::ShapeRow;
use crate::step::context::StepContext;

/// Minimum drift of two dynamic bodies that turn together [m/s, times [`StepContext::length`]]. It
/// is the mean over the step of the velocity by which friction's target departs from that of the
/// step's start. A body on a freely rotating turntable would drift out at that speed.
const COROTATES: f32 = 1.0e-4;

/// Maximum turn of such bodies in a step [rad]: the correction grows in proportion to time, which
/// holds for small angles only.
const SMALL_TURN: f32 = 0.25;

/// Maximum turn against each other, as a part of their turn: beyond it two bodies meet rather than
/// turn together.
const TOGETHER: f32 = 0.25;

/// True if two bodies of a contact turn together, and so fast that their turn within the step
/// matters.
pub(crate) fn corotates(ctx: &StepContext, contact: &Contact, [a, b]: [&Body; 2]) -> bool {
    if !(a.is_dynamic() && b.is_dynamic()) || contact.sensor {
        return false;
    }
    let minimum = 2.0 * COROTATES * ctx.length / ctx.dt;
    let reach = a.extent + b.extent + ctx.margin;
    let square = a.w.length_squared().max(b.w.length_squared());
    if !(square * reach > minimum)
        || square * ctx.dt * ctx.dt > SMALL_TURN * SMALL_TURN
        || (b.w - a.w).length_squared() > TOGETHER * TOGETHER * square
    {
        return false;
    }
    let Some(first) = contact.points().first() else { return false };
    let (n, r_a) = (contact.normal, first.r_a);
    let pull = |w: Vec3, r: Vec3| w.cross(w.cross(r));
    let rate = pull(b.w, contact.r_b(first)) - pull(a.w, r_a);
    (rate - n * n.dot(rate)).length() > minimum
}

/// Minimum closing speed of an impact [m/s, times [`StepContext::length`]]: ten times the speed
/// that gravity gives in a substep.
pub(crate) const IMPACT_SPEED: f32 = 0.2;

/// True if two bodies meet within the step at impact speed, and do not bounce. Warm starting would
/// apply the impact impulse once more in the next substep. A body alone with one that cannot be
/// pushed is stopped by a single sweep. The impact of a body with joints passes through the joint
/// sweep, which has its own rule for impacts.
pub(crate) fn may_impact(ctx: &StepContext, contact: &Contact, [a, b]: [&Body; 2]) -> bool {
    let minimum = IMPACT_SPEED * ctx.length;
    let [moves, a_turns, b_turns] = [b.v - a.v, a.w, b.w].map(Vec3::length_squared);
    // Three speeds below a third are less than the whole. This needs no root, and most bodies of a
    // scene at rest are that slow.
    let third = 0.33 * minimum;
    let slow = |turns: f32, body: &Body| turns * (body.extent * body.extent) < third * third;
    if moves < third * third && slow(a_turns, a) && slow(b_turns, b) {
        return false;
    }
    if contact.sensor || contact.restitution > 0.0 {
        return false;
    }
    if [a, b].iter().any(|body| !body.ties.joints.is_empty()) {
        return false;
    }
    let is_alone = |body: &Body| body.sleep.previous == NONE && body.sleep.next == NONE;
    match [a.is_dynamic(), b.is_dynamic()] {
        [true, true] => {}
        [true, false] if !is_alone(a) => {}
        [false, true] if !is_alone(b) => {}
        _ => return false,
    }
    let maximum = moves.sqrt() + a_turns.sqrt() * a.extent + b_turns.sqrt() * b.extent;
    // A relax sweep looks a substep beyond the step's end.
    let ahead = ctx.dt + ctx.h;
    let meets = |p: &Point| {
        let speed = contact.normal.dot(b.velocity_at(contact.r_b(p)) - a.velocity_at(p.r_a));
        speed < -minimum && p.separation - ctx.rest_offset + speed * ahead < 0.0
    };
    maximum > minimum && contact.points().iter().any(meets)
}

/// Lists a contact whose bodies turn together, one with an impact, and one that may be parted.
pub(super) fn list_for_solver(
    ctx: &StepContext,
    (row, contact): (u32, &Contact),
    bodies: [&Body; 2],
    out: &mut Vec<Change>,
) {
    if corotates(ctx, contact, bodies) {
        out.push(Change::Corotates(row));
    }
    if may_impact(ctx, contact, bodies) {
        out.push(Change::Impacts(row));
    }
    list_parting(ctx, (row, contact), out);
}

impl super::scratch::Scratch {
    /// True for each if the bodies of some contact turn together, some contact may be parted, some
    /// contact has an impact.
    pub(crate) fn listed(&self) -> [bool; 3] {
        let mut listed = [false; 3];
        for change in self.changes.iter().flatten() {
            match change {
                Change::Corotates(_) => listed[0] = true,
                Change::Parts(_) => listed[1] = true,
                Change::Impacts(_) => listed[2] = true,
                _ => {}
            }
        }
        listed
    }
}

/// Turn of two shapes against each other in this step, plus a tenth [rad]. Rotation about an axis
/// of revolution does not count, since a shape that rolls on its side touches at the same lever.
pub(super) fn turn_ahead(
    ctx: &StepContext,
    (a, shape_a): (&Body, &ShapeRow),
    (b, shape_b): (&Body, &ShapeRow),
) -> f32 {
    let mut w = b.w - a.w;
    for (body, shape) in [(a, shape_a), (b, shape_b)] {
        match &shape.solid.core {
            Core::Point => return 0.0,
            Core::Segment { .. } | Core::Frustum { .. } => {
                let axis = body.rotation.rotate(shape.centered.rotation.rotate(Vec3::Y));
                w -= axis * axis.dot(w);
            }
            _ => {}
        }
    }
    1.1 * ctx.dt * w.length()
}

/// Lists a contact that may be parted: see [`StepContext::deep`].
fn list_parting(ctx: &StepContext, (row, contact): (u32, &Contact), out: &mut Vec<Change>) {
    let deep = |p: &Point| p.separation - ctx.rest_offset < -ctx.deep;
    let is_deep = contact.traits.any(Traits::PARTING) || contact.points().iter().any(deep);
    if is_deep && !contact.sensor {
        out.push(Change::Parts(row));
    }
}
