//! Manifold persistence: recycles manifolds, and carries impulses and compression under load over
//! to new ones.

use super::settling::{answer, settle};
use crate::base::math::Vec3;
use crate::base::quat::Quat;
use crate::state::bodies::NONE;
use crate::state::bodies::body::Body;
use crate::state::contacts::{Contact, Point, Probe, Slots};
use crate::step::context::StepContext;

/// Keeps points, anchors and normal, and recomputes the separations; false if the manifold must be
/// rebuilt. Frozen anchors keep tall walls from buckling (docs/derivations/soft-step.md). `lands`:
/// the bodies are so fast that a point may land.
pub(super) fn recycle(
    ctx: &StepContext,
    contact: &mut Contact,
    probe: &Probe,
    (a, b): (&Body, &Body),
    slots: &Slots<'_>,
    lands: bool,
) -> bool {
    // The manifolds of a pair are not adjacent in memory, so those without points are not visited.
    let several = contact.others > 0;
    let mut part = Some(contact);
    while let Some(contact) = part {
        let normal = contact.normal;
        // The normal is rotated back with both bodies, so the anchors need no rotation.
        let n_a = probe.rotation_a.rotate(a.rotation.unrotate(normal));
        let n_b = probe.rotation_b.rotate(b.rotation.unrotate(normal));
        let between = normal.dot(b.center - a.center) - n_b.dot(contact.offset);
        let tilt = n_b - n_a;
        let count = usize::from(contact.count);
        let mut minimum = f32::INFINITY;
        for p in &mut contact.points[..count] {
            p.separation = p.base + (between + tilt.dot(p.r_a));
            minimum = minimum.min(p.separation);
        }
        if count > 0 && !(minimum <= ctx.margin) {
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

/// Records the approach speed of a touching contact's points without impulse, for bodies with these
/// velocities of the center and angular velocities [m/s, rad/s; world]. The far end of a plank that
/// falls over lands in this way.
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

/// Corrects separations for substeps of another length: the depth of a loaded contact then must not
/// count as overlap. Stiffness follows from the substep. As time slowed down, the depth that
/// carried the load became an error and was pushed out, and a stack at rest hopped by its own
/// height. So separations are set as if the contact had been compressed with this step's stiffness.
pub(super) fn keep_load(ctx: &StepContext, contact: &mut Contact, a: &Body, b: &Body) {
    let last_h = if a.is_dynamic() { a.history.last_h } else { b.history.last_h };
    settle(ctx, contact, [a, b]);
    let more = ctx.gave_more(last_h);
    if more == 0.0 || contact.sensor {
        return;
    }
    let both = a.is_dynamic() && b.is_dynamic();
    // Contacts with static bodies have twice the frequency.
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

/// Takes the impulse of the old point that a new point continues: the point of the same feature,
/// else the nearest one that is near. (Features change names when the two faces of a flush contact
/// change roles; without its impulses a loaded contact would yield for a step.)
pub(super) fn inherit(
    old: &mut [Point],
    feature: u32,
    r_a: Vec3,
    last: Quat,
    a: &Body,
    b: &Body,
) -> Option<f32> {
    // In the frame that A had when the old points were made.
    inherit_near(old, feature, last.rotate(a.rotation.unrotate(r_a)), a, b)
}

/// [`inherit`] for a point at `here`, in the frame of the old points [m, from A's center].
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
    // A negative value marks an impulse as taken: impulses are never negative.
    found.map(|i| core::mem::replace(&mut old[i].impulse, -1.0))
}

/// Cosine of the maximum angle between the normals of a load that continues: 0.1 rad.
const SAME_NORMAL: f32 = 0.995;

/// Shares the remaining old impulses of a flat disc among the new points that inherited none:
/// `fresh`, bits. The four deepest places of a rim change with a tilt of a micrometer, and without
/// their impulses a body on the disc would fall. Points of other faces are corners, which have
/// names.
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
