//! Rebuilds the contact of two bodies from their states within a step.

use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::geometry::collide::MAX_PARTS;
use crate::geometry::manifold::Manifold;
use crate::state::bodies::body::Body;
use crate::state::contacts::Contact;
use crate::state::shapes::ShapeRow;
use crate::step::context::StepContext;
use crate::step::narrowphase::keep::{inherit_near, note_landing, share_lost};
use crate::step::solver::body::state::BodyState;

/// A pair whose contact is rebuilt.
pub(super) struct Pair<'a> {
    pub(crate) ctx: &'a StepContext,
    pub(crate) bodies: [&'a Body; 2],
    pub(crate) states: [BodyState; 2],
    pub(crate) shapes: [&'a ShapeRow; 2],
}

impl Pair<'_> {
    /// Poses of shape A in the world, and of shape B in the frame of A.
    pub(crate) fn poses(&self) -> (Pose, Pose) {
        let [a, b] = [0, 1].map(|i| {
            let BodyState { center, rotation, .. } = self.states[i];
            Pose { position: center, rotation }.compose(&self.shapes[i].centered)
        });
        (a, a.relative(&b))
    }

    /// Speculative distance of the pair: the distance by which the two may approach in a step. An
    /// impact may send them in any direction within a substep.
    pub(crate) fn reach(&self) -> f32 {
        let [a, b] = &self.states;
        let [extent_a, extent_b] = self.bodies.map(|body| body.extent);
        let spin = |state: &BodyState, body: &Body, extent: f32| {
            if body.is_dynamic() { state.w.length() * extent } else { 0.0 }
        };
        let turning = spin(a, self.bodies[0], extent_a) + spin(b, self.bodies[1], extent_b);
        let size = |body: &Body| if body.is_dynamic() { body.extent } else { f32::INFINITY };
        let maximum = size(self.bodies[0]).min(size(self.bodies[1]));
        let displacement = 1.1 * self.ctx.dt * ((b.v - a.v).length() + turning);
        self.ctx.margin.max(displacement.min(maximum))
    }

    /// Replaces the manifold of a contact. An empty one leaves a contact out of reach, because
    /// active contacts are not removed within a step.
    pub(crate) fn renew(&self, contact: &mut Contact, manifold: &Manifold) {
        let (pose_a, _) = self.poses();
        let [a, b] = &self.states;
        let mut old = contact.points;
        let before = usize::from(contact.count);
        contact.set_renewed();
        if manifold.count == 0 {
            contact.offset = b.center - a.center;
            let Some(first) = contact.points.first_mut() else { return };
            let apart = 2.0 * self.reach();
            first.renew(first.r_a, apart, 0.0, first.feature);
            contact.count = 1;
            contact.tangent_impulse = Vec3::ZERO;
            contact.twist_impulse = 0.0;
            contact.set_rolling_impulse(Vec3::ZERO);
            return;
        }
        let normal = pose_a.direction(manifold.normal);
        if contact.normal.dot(normal) < 0.0 {
            self.move_on(contact);
            return;
        }
        let normal_before = core::mem::replace(&mut contact.normal, normal);
        contact.offset = b.center - a.center;
        #[expect(clippy::cast_possible_truncation, reason = "at most four points")]
        let count = manifold.count as u8;
        contact.count = count;
        let origin = pose_a.position - a.center;
        let [body_a, body_b] = self.bodies;
        let (old, mut fresh) = (&mut old[..before], 0);
        for (i, (new, made)) in contact.points.iter_mut().zip(manifold.points()).enumerate() {
            let r_a = pose_a.direction(made.position) + origin;
            let inherited = inherit_near(old, made.feature, r_a, body_a, body_b);
            fresh |= u8::from(inherited.is_none()) << i;
            new.renew(r_a, made.separation, inherited.unwrap_or(0.0), made.feature);
        }
        share_lost(old, (normal_before, fresh), contact);
        if contact.touching {
            let velocities = [a, b].map(|state| [state.v, state.w]);
            note_landing(contact, velocities);
        }
    }
}

impl Pair<'_> {
    /// Keeps the manifold of a body so deep in a thin one that it would be pushed out on the other
    /// side. Its points move with the bodies' motion in the last substep.
    fn move_on(&self, contact: &mut Contact) {
        let [a, b] = &self.states;
        let (normal, offset, count) = (contact.normal, contact.offset, usize::from(contact.count));
        for p in &mut contact.points[..count] {
            let speed = (b.v + b.w.cross(p.r_a - offset)) - (a.v + a.w.cross(p.r_a));
            let moved = normal.dot(speed) * self.ctx.h;
            p.base += moved;
            p.separation += moved;
        }
    }
}

/// Index of the unused manifold whose normal is nearest to `normal`.
pub(super) fn nearest(
    made: &[Manifold],
    left: &[bool; MAX_PARTS],
    pose_a: &Pose,
    normal: Vec3,
) -> Option<usize> {
    let mut best = None;
    let mut maximum = f32::NEG_INFINITY;
    for (k, manifold) in made.iter().enumerate().filter(|(k, _)| left[*k]) {
        let along = pose_a.direction(manifold.normal).dot(normal);
        if along > maximum {
            (best, maximum) = (Some(k), along);
        }
    }
    best
}
