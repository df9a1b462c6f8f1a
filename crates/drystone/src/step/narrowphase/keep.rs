//! Manifolds that are kept, and what a new one takes over from the old one: impulses, and what the contact gave under its load.

use super::settling::{answer, settle};
use crate::base::math::Vec3;
use crate::base::quat::Quat;
use crate::state::bodies::{Body, NONE};
use crate::state::contacts::{Contact, Point, Probe, Slots};
use crate::step::context::StepContext;

/// Keeps points, anchors and normal, and works out the separations anew; false if that is not enough.
/// Frozen anchors are what keeps tall walls from buckling (docs/derivations/soft-step.md). `lands`: the bodies are so fast that a
/// point may land.
pub(super) fn recycle(
    ctx: &StepContext,
    contact: &mut Contact,
    probe: &Probe,
    (a, b): (&Body, &Body),
    slots: &Slots<'_>,
    lands: bool,
) -> bool {
    // Rows of a pair lie apart: those without points are not visited.
    let several = contact.others > 0;
    let mut part = Some(contact);
    while let Some(contact) = part {
        let normal = contact.normal;
        // The normal turned back with both bodies: then the anchors need no turning.
        let n_a = probe.rotation_a.rotate(a.rotation.unrotate(normal));
        let n_b = probe.rotation_b.rotate(b.rotation.unrotate(normal));
        let between = normal.dot(b.center - a.center) - n_b.dot(contact.offset);
        let tilt = n_b - n_a;
        let count = usize::from(contact.count);
        let mut least = f32::INFINITY;
        for p in &mut contact.points[..count] {
            p.separation = p.base + (between + tilt.dot(p.r_a));
            least = least.min(p.separation);
        }
        if count > 0 && !(least <= ctx.margin) {
            return false;
        }
        if contact.touching && lands {
            note_landing(contact, [a, b].map(|body| [body.v, body.w]));
        } else if contact.touching {
            contact.set_approach(0.0);
        }
        let next = contact.next_part;
        part = (several && next != NONE).then(|| slots.row(next as usize).as_mut()).flatten();
    }
    true
}

/// Notes how fast the points of a touching contact come together that bear nothing, of bodies with these velocities of the
/// center and angular velocities [m/s, rad/s; world]. The far end of a plank that falls over lands so.
#[inline]
pub(crate) fn note_landing(contact: &mut Contact, [[v_a, w_a], [v_b, w_b]]: [[Vec3; 2]; 2]) {
    let (normal, offset) = (contact.normal, contact.offset);
    let mut approach = 0.0_f32;
    for p in contact.points() {
        if !(p.impulse > 0.0) {
            let speed = (v_b + w_b.cross(p.r_a - offset)) - (v_a + w_a.cross(p.r_a));
            approach = approach.max(-normal.dot(speed));
        }
    }
    contact.set_approach(approach);
}

/// What a loaded contact gave in substeps of another length is no overlap in those of this step. Stiffness follows the substep: as time
/// slowed down, the depth that carried the load was an error, was pushed out, and a stack that rested hopped by its
/// own height. So the points are as far apart as if the contact had given by this step's stiffness.
pub(super) fn keep_load(ctx: &StepContext, contact: &mut Contact, a: &Body, b: &Body) {
    let last_h = if a.is_dynamic() { a.last_h } else { b.last_h };
    settle(ctx, contact, [a, b]);
    let more = ctx.gave_more(last_h);
    if more == 0.0 || contact.sensor {
        return;
    }
    let both = a.is_dynamic() && b.is_dynamic();
    // With static bodies they are of twice the frequency.
    let more = if both { more } else { 0.25 * more } / last_h;
    let (normal, offset) = (contact.normal, contact.offset);
    let count = usize::from(contact.count);
    for p in &mut contact.points[..count] {
        let gave =
            p.impulse * more * (answer(a, p.r_a, normal) + answer(b, p.r_a - offset, normal));
        p.base += gave;
        p.separation += gave;
    }
}

/// The impulse of the old point that a new one continues, and takes it away from it: the one of the same
/// feature, else the nearest one that is near. (Features change names when the two faces of a flush
/// contact change roles; without its impulses a loaded contact would give way for a step.)
pub(super) fn inherit(
    old: &mut [Point],
    feature: u32,
    r_a: Vec3,
    last: Quat,
    a: &Body,
    b: &Body,
) -> Option<f32> {
    // In the frame that A had when the old ones were made.
    inherit_near(old, feature, last.rotate(a.rotation.unrotate(r_a)), a, b)
}

/// The same, where that point is `here` in the frame of the old ones [m, from A's center].
pub(crate) fn inherit_near(
    old: &mut [Point],
    feature: u32,
    here: Vec3,
    a: &Body,
    b: &Body,
) -> Option<f32> {
    let size = |body: &Body| if body.is_dynamic() { body.extent } else { f32::INFINITY };
    let near = 0.1 * size(a).min(size(b));
    let found = old.iter().position(|p| p.feature == feature && p.impulse >= 0.0).or_else(|| {
        let distance = |p: &Point| (p.r_a - here).length();
        let nearest = (0..old.len())
            .filter(|i| old[*i].impulse >= 0.0)
            .min_by(|i, j| distance(&old[*i]).total_cmp(&distance(&old[*j])))?;
        (distance(&old[nearest]) < near).then_some(nearest)
    });
    // An impulse that was taken is marked by a negative one: impulses are never negative.
    found.map(|i| core::mem::replace(&mut old[i].impulse, -1.0))
}

/// Cosine of the angle by which a normal may turn so that a load is the same one: 0.1 rad.
const SAME_NORMAL: f32 = 0.995;

/// Shares the impulses that no new point of a flat disc took over among the new points that took over none: `fresh`, bits. The four
/// deepest places of a rim change with a lean of a micrometer. Without their impulses what stands on the disc would fall. Points of
/// other faces are corners, which have names.
pub(crate) fn share_lost(old: &[Point], (before, fresh): (Vec3, u8), contact: &mut Contact) {
    let is_disc = contact.round_patch && old.len() > 2 && contact.count > 2;
    if !is_disc || fresh == 0 || before.dot(contact.normal) < SAME_NORMAL {
        return;
    }
    let lost: f32 = old.iter().map(|p| p.impulse.max(0.0)).sum();
    let count: f32 = (0..4).map(|i| f32::from(fresh >> i & 1)).sum();
    let share = lost / count;
    for (i, point) in contact.points.iter_mut().enumerate() {
        if fresh >> i & 1 == 1 {
            point.impulse = share;
        }
    }
}
