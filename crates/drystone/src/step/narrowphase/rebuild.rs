//! Convex pairs: decides whether a manifold is recycled, and stores a new one in its contact.

pub(crate) use super::keep::share_lost;

use super::change::Change;
use super::keep::inherit;
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::base::quat::Quat;
use crate::geometry::manifold::Manifold;
use crate::state::bodies::Track;
use crate::state::bodies::body::Body;
use crate::state::contacts::{Contact, Probe, Watch};
use crate::state::def::BodyKind;
use crate::step::context::StepContext;

/// Minimum speed of a contact that closes fast: this part of the thinner body's half thickness in a
/// substep.
const CLOSES: f32 = 0.03;

/// Minimum rotation in a step of a pair whose rows are made anew within it [rad]. The separation of
/// a point at a lever r, linear over the step, is then off by half a percent of r.
pub(crate) const RENEWED_ROTATION: f32 = 0.1;

/// A pair that is tested.
pub(crate) struct Look<'a> {
    /// Row of the contact.
    pub(crate) row: u32,
    /// Speculative distance [m], if it was computed.
    pub(crate) reach: Option<f32>,
    pub(crate) watch: &'a mut Watch,
    pub(crate) probe: &'a mut Probe,
    pub(crate) tracks: &'a [Track],
    /// See [`StepContext::per_track`].
    pub(crate) per_track: f32,
    /// The bodies are so fast that a point of the contact may land, as a hit.
    pub(crate) lands: bool,
}

impl Look<'_> {
    /// Stores the present distance of the shapes [m], 0 if unknown, and takes the present poses as
    /// the reference for motion.
    pub(crate) fn restart(&mut self, gap: f32, a: &Body, b: &Body) {
        self.probe.restart(gap, a, b);
        self.open(gap);
    }

    /// Stores a lower bound on the present distance of the shapes [m].
    pub(crate) fn open(&mut self, gap: f32) {
        self.watch.open(gap * self.per_track, self.tracks);
    }
}

/// Twice the chord of two unit quaternions. It equals the angle between the rotations if that is
/// small, and is at least the chord that a point at unit distance travels.
pub(crate) fn chord(q: &Quat, q0: &Quat) -> f32 {
    let d = [q.x - q0.x, q.y - q0.y, q.z - q0.z, q.w - q0.w];
    2.0 * (d[0] * d[0] + d[1] * d[1] + d[2] * d[2] + d[3] * d[3]).sqrt()
}

/// True if the manifold may be recycled. The bodies have hardly moved since it was made, against
/// each other or in the world, and no corner without a point can touch in this step, in which they
/// turn by `turn` [rad].
pub(crate) fn may_recycle(
    ctx: &StepContext,
    contact: &Contact,
    r: &Probe,
    (a, b): (&Body, &Body),
    turn: f32,
) -> bool {
    if contact.count == 0 || contact.is_renewed() {
        return false;
    }
    let size = |body: &Body| if body.is_dynamic() { body.extent } else { 0.0 };
    let shift = ((b.center - a.center) - r.offset).length();
    let (turn_a, turn_b) = (chord(&a.rotation, &r.rotation_a), chord(&b.rotation, &r.rotation_b));
    if turn_a + turn_b + turn > contact.clear {
        return false;
    }
    let turns = turn_a * size(a) + turn_b * size(b);
    // A moving partner with infinite mass (kinematic) turns the normal with it: only tiny turns are
    // allowed.
    let carried = |body: &Body| !body.is_dynamic() && body.active() && body.w != Vec3::ZERO;
    // At most a quarter of the smaller body's size: a distance that is far for a pebble is near for
    // a rock.
    let limit = |body: &Body| if body.is_dynamic() { 0.25 * body.extent } else { f32::INFINITY };
    let limit = ctx.recycle_distance.min(limit(a)).min(limit(b));
    // Corners that were far when a tilted box landed on an edge must not be missed.
    let limit = if contact.count < 3 { 0.2 * limit } else { limit };
    shift + turns < limit && !carried(a) && !carried(b)
}

/// Stores a new manifold in its contact, and lists the changes. `last`: rotation of A when the last
/// manifold was made.
pub(crate) fn rebuild(
    ctx: &StepContext,
    (row, contact): (u32, &mut Contact),
    manifold: &Manifold,
    (pose_a, last): (&Pose, Quat),
    [a, b]: [&Body; 2],
    out: &mut Vec<Change>,
) {
    let before = contact.count;
    let mut old = contact.points;
    let normal = pose_a.direction(manifold.normal);
    #[expect(clippy::cast_possible_truncation, reason = "at most four points")]
    let count = manifold.count as u8;
    contact.count = count;
    // For a look-ahead manifold, arms and offset are those of B's future place.
    let shift = pose_a.direction(manifold.shift);
    let offset = b.center - a.center + shift;
    contact.offset = offset;
    if count == 0 {
        contact.tangent_impulse = Vec3::ZERO;
        contact.set_rolling_impulse(Vec3::ZERO);
        contact.twist_impulse = 0.0;
        if before != 0 {
            out.push(Change::Count(row));
        }
        return;
    }
    let normal_before = core::mem::replace(&mut contact.normal, normal);
    // Arms from A's center in the frame of A's shape keep their precision far from the origin.
    let origin = pose_a.position - a.center;
    let (mut approach, mut fresh) = (0.0_f32, 0);
    let old = &mut old[..usize::from(before)];
    for (i, (new, made)) in contact.points.iter_mut().zip(manifold.points()).enumerate() {
        let r_a = pose_a.direction(made.position) + origin;
        let r_b = r_a - offset;
        let inherited = inherit(old, made.feature, r_a, last, a, b);
        fresh |= u8::from(inherited.is_none()) << i;
        let impulse = inherited.unwrap_or(0.0);
        new.renew(r_a, made.separation, impulse, made.feature);
        new.base += normal.dot(shift);
        // In a touching pair only points without impulse land: see `note_landing`.
        if !contact.touching || !(impulse > 0.0) {
            approach = approach.max(-normal.dot(b.velocity_at(r_b) - a.velocity_at(r_a)));
        }
    }
    share_lost(old, (normal_before, fresh), contact);
    if before != count {
        let sleeps = |body: &Body| !body.active() && body.kind != BodyKind::Static;
        if ctx.wakes_alone
            && !contact.place.is_somewhere()
            && !contact.sensor
            && (sleeps(a) || sleeps(b))
        {
            out.push(Change::Meets(row));
        }
        out.push(Change::Count(row));
    }
    contact.set_approach(approach);
    if contact.touching {
        return;
    }
    let thickness = |body: &Body| if body.is_dynamic() { body.inner } else { f32::INFINITY };
    if !contact.sensor && approach * ctx.h > CLOSES * thickness(a).min(thickness(b)) {
        out.push(Change::Closes(row));
    }
}
