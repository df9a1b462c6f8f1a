//! Chooses the islands with joints that subdivide substeps, for two reasons.
//!
//! Fast-turning joints: the error of frozen rows and soft joints grows as the square of the angle
//! per substep (docs/derivations/joints.md). Impacts: an impact travels through one joint per sweep
//! (docs/decisions/023-hits-on-joints.md).

use crate::base::math::{Vec3, vec3};
use crate::base::threads::disjoint::Rows;
use crate::state::bodies::body::{Body, Subdivision};
use crate::state::bodies::{Bodies, NONE};
use crate::state::colors::Place;
use crate::state::contacts::{Contacts, Slots};
use crate::state::islands::Island;
use crate::state::joints::{Joint, JointModel, Joints};

/// Refinement of an island, from the list of choices.
pub(crate) fn subdivision_of(island: u32, chosen: &[Subdivision]) -> Subdivision {
    chosen.get(island as usize).copied().unwrap_or_default()
}

/// Maximum number of bodies of an island that subdivides substeps: the motion of one limb is no
/// reason to refine a whole pile.
const MAX_BODIES: u32 = 64;

/// Threshold on twice the distance of a joint's anchor from its tangent after a substep, relative
/// to the body's size. For an anchor at the body's end it is a tenth of a radian per substep.
const ENTER: f32 = 0.01;

/// Lower threshold, at which refinement ends: a mechanism near the limit does not change its
/// stiffness in each step.
const LEAVE: f32 = 0.005;

/// Thresholds at which a body begins and ceases to tumble, on the change of its angular velocity in
/// a step if nothing held it, times the step [rad]. A rod that rotates about an axis at 45 degrees
/// to it reaches the first at a seventh of a radian per step.
const TUMBLES: f32 = 0.01;

const TUMBLES_ON: f32 = 0.005;

/// True if the island is small and awake and some joint turns so fast that substeps of `h` [s] are
/// too long.
pub(crate) fn whirls(island: &Island, bodies: &Bodies, joints: &Joints, h: f32) -> bool {
    if island.len > MAX_BODIES {
        return false;
    }
    // Each joint is one or two cache lines for some ten instructions.
    for body in island.bodies(bodies) {
        body.ties.joints.iter().for_each(|joint| joints.rows.prefetch(*joint, 2));
    }
    for body in island.bodies(bodies) {
        if !body.active() {
            return false;
        }
        let limit = if body.history.subdivision == Subdivision::Jointed { LEAVE } else { ENTER };
        for joint in body.ties.joints.iter().map(|joint| joints.at(*joint)) {
            let sides = [(joint.body_a, joint.anchor_a), (joint.body_b, joint.anchor_b)];
            let is_bent = |end: u32, arm: Vec3| {
                let end = bodies.at(end);
                // Most bodies turn so slowly that no lever arm could exceed the limit. This bounds
                // the offset of an arm's end, up to rounding.
                let maximum = end.w.length_squared() * (h * h);
                maximum > 0.99 * limit && bend(end, arm, h) > limit * body.extent.max(arm.length())
            };
            if sides.iter().any(|(end, arm)| is_bent(*end, *arm)) {
                return true;
            }
        }
    }
    false
}

/// True if the island is small and awake, nothing touches it, and some body of it tumbles in steps
/// of `dt` [s]. Such an island can be solved in rounds: see `solver/rounds.rs`.
pub(crate) fn tumbles(
    island: &Island,
    bodies: &Bodies,
    joints: &Joints,
    contacts: &Contacts,
    dt: f32,
) -> bool {
    let is_fast = |body: &Body| {
        let limit =
            if body.history.subdivision == Subdivision::Tumbling { TUMBLES_ON } else { TUMBLES };
        let limit = limit / (dt * dt);
        // For any mass distribution it is at most the square of the speed.
        body.w.length_squared() > limit && precession(body) > limit
    };
    island.len <= MAX_BODIES
        && island.bodies(bodies).any(is_fast)
        && hangs(island, bodies, joints, contacts)
}

/// Rate at which the angular velocity of a free body turns [rad/s²].
fn precession(body: &Body) -> f32 {
    let m = body.inertia.moments;
    if !(m.min_element() > 0.0) || body.inertia.locks.angular != [false; 3] {
        return 0.0;
    }
    let w = (body.rotation * body.inertia.principal).unrotate(body.w);
    let torque = vec3(m.x * w.x, m.y * w.y, m.z * w.z).cross(w);
    vec3(torque.x / m.x, torque.y / m.y, torque.z / m.z).length()
}

/// True if joints between two bodies hold the island, and nothing touches it.
fn hangs(island: &Island, bodies: &Bodies, joints: &Joints, contacts: &Contacts) -> bool {
    let is_of_two = |joint: &u32| {
        matches!(
            joints.at(*joint).model,
            JointModel::Ball | JointModel::Distance { .. } | JointModel::SixDof(_)
        )
    };
    let presses = |(row, _): (u32, u32)| {
        let contact = contacts.at(row);
        contact.count > 0 && !contact.sensor
    };
    // A single body on a ball joint is integrated as a pendulum: see `joint/pivot.rs`.
    let is_ball = |joint: &u32| matches!(joints.at(*joint).model, JointModel::Ball);
    let swings = |body: &Body| island.len == 1 && body.ties.joints.iter().all(is_ball);
    island.bodies(bodies).all(|body| {
        body.active()
            && body.ties.joints.iter().all(is_of_two)
            && !contacts.of_body(body).any(presses)
            && !swings(body)
    })
}

/// Twice the distance of an arm's end from its tangent after `h` [m].
fn bend(body: &Body, arm: Vec3, h: f32) -> f32 {
    let arm = body.rotation.rotate(arm);
    body.w.cross(body.w.cross(arm)).length() * (h * h)
}

/// True if an island is small and has joints but no trees. (A tree transmits an impact at once.)
pub(crate) fn is_jointed(island: &Island, bodies: &Bodies, joints: &Joints) -> bool {
    if island.len > MAX_BODIES {
        return false;
    }
    let mut has_joints = false;
    for body in island.bodies(bodies) {
        if body.ties.joints.iter().any(|joint| joints.at(*joint).is_direct) {
            return false;
        }
        has_joints |= !body.ties.joints.is_empty();
    }
    has_joints
}

/// The islands in which contacts of the list `closing` are about to touch, once for each contact.
pub(crate) fn struck(
    closing: impl Iterator<Item = u32>,
    bodies: &Bodies,
    contacts: &Contacts,
) -> impl Iterator<Item = u32> {
    closing.filter_map(|row| {
        let c = contacts.at(row);
        let ends = [c.body_a, c.body_b].map(|body| bodies.at(body));
        // The contact may have become a ghost of a seam since it was listed.
        let dynamic = ends.into_iter().find(|body| body.is_dynamic() && body.active());
        dynamic.filter(|_| c.count > 0).map(|body| body.sleep.island)
    })
}

/// True if the body's island was hit in the last step.
pub(crate) fn was_struck(body: &Body) -> bool {
    body.active() && body.history.subdivision == Subdivision::Struck
}

/// Rescales the impulses of an island that was hit and now continues with undivided substeps.
pub(crate) fn take_back(
    island: &Island,
    bodies: &Bodies,
    joints: &Rows<'_, Option<Joint>>,
    slots: &Slots<'_>,
    factor: f32,
) {
    let mut at = island.first;
    while at != NONE {
        let (row, body) = (at, bodies.at(at));
        at = body.sleep.next;
        // Skip bodies that joined the island after the subdivided step.
        if !was_struck(body) {
            continue;
        }
        // The body with the lower row handles a constraint of two such bodies. Inactive constraints
        // may connect two islands.
        let is_mine = |ends: [u32; 2], place: Place| {
            let other = if ends[0] == row { ends[1] } else { ends[0] };
            place.is_somewhere() && (row <= other || !was_struck(bodies.at(other)))
        };
        let mut at = body.ties.contacts;
        while at != NONE {
            let (row, side) = ((at / 2) as usize, (at & 1) as usize);
            let Some(contact) = slots.read(row) else { break };
            at = contact.links[side].next.get();
            if is_mine([contact.body_a, contact.body_b], contact.place)
                && let Some(contact) = slots.row(row)
            {
                contact.scale_impulses(factor);
            }
        }
        for row in &body.ties.joints {
            if let Some(joint) = joints.read(*row as usize)
                && is_mine([joint.body_a, joint.body_b], joint.place)
                && let Some(joint) = joints.row(*row as usize)
            {
                scale(joint, factor);
            }
        }
    }
}

fn scale(joint: &mut Joint, factor: f32) {
    joint.impulse *= factor;
    match &mut joint.model {
        JointModel::SixDof(six_dof) => six_dof.state.scale_impulses(factor),
        JointModel::Coupling(coupling) => coupling.impulse *= factor,
        JointModel::Ball
        | JointModel::Distance { .. }
        | JointModel::Pulley(_)
        | JointModel::Link => {}
    }
}
