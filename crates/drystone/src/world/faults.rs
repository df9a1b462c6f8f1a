//! Bodies and particles that are disabled, or put aside because their state became non-finite, are
//! fully out of the world. They touch nothing, their joints, links and attachments do not act, and
//! they are left out of sums. A faulted one comes back when it gets a pose or a velocity, a
//! disabled one when it is enabled.

use super::World;
use crate::base::math::Vec3;
use crate::state::bodies::body::Subdivision;
use crate::state::events::{Fault, FaultKind};

impl World {
    /// Takes the bodies that the last step put aside out of the world, and wakes bodies that
    /// touched them or were joined to them.
    pub(super) fn take_out_faulted(&mut self) {
        let is_bad = |fault: &&Fault| fault.kind == FaultKind::NotFinite;
        if !self.tables.events.faults.iter().any(|fault| is_bad(&fault)) {
            return;
        }
        let bad = self.tables.events.faults.iter().filter(is_bad);
        let bodies: Vec<u32> =
            bad.filter_map(|fault| self.tables.bodies.rows.row(fault.body?)).collect();
        for row in bodies {
            self.take_out(row);
        }
        // A joint of bodies that stayed may have become non-finite together with the joints solved
        // with it.
        for joint in self.tables.joints.rows.values_mut().iter_mut().flatten() {
            if !joint.is_finite() {
                joint.forget();
            }
        }
    }

    /// Removes the contacts, joints and boxes of a body, which is no longer awake, from the world.
    pub(super) fn take_out(&mut self, row: u32) {
        self.end_contacts_of(row, None);
        let joints: Vec<u32> = self.tables.bodies.at(row).ties.joints.to_vec();
        for joint in joints {
            self.take_out_joint(joint);
        }
        let tables = &mut self.tables;
        for attachment in
            tables.particles.attachments.iter_mut().filter(|attachment| attachment.body == row)
        {
            attachment.impulse = Vec3::ZERO;
        }
        let body = tables.bodies.at_mut(row);
        (body.forces.step_force, body.forces.step_torque) = (Vec3::ZERO, Vec3::ZERO);
        (body.history.w_low, body.history.load, body.history.inertia_factor) =
            (Vec3::ZERO, 0.0, 1.0);
        (body.sleep.still_time, body.room, body.history.subdivision) =
            (0.0, 0.0, Subdivision::Whole);
        for i in 0..tables.bodies.at(row).ties.shapes.len() {
            let shape = tables.bodies.at(row).ties.shapes[i];
            tables.bounds.remove(shape, &tables.shapes);
        }
    }

    /// Takes a joint that no longer acts out of the colors, with its couplings. Clears their
    /// impulses and wakes its bodies.
    pub(super) fn take_out_joint(&mut self, row: u32) {
        let (a, b) = (self.tables.joints.at(row).body_a, self.tables.joints.at(row).body_b);
        let id = self.tables.joints.rows.id_at(row);
        let couplings: Vec<u32> = id.into_iter().flat_map(|id| self.couplings_of(id)).collect();
        for row in couplings.into_iter().chain([row]) {
            self.sets().uncolor_joint(row);
            self.tables.joints.at_mut(row).forget();
        }
        self.tables.islands.cut(a, &self.tables.bodies);
        self.tables.islands.cut(b, &self.tables.bodies);
        self.wake_bodies_of(row);
    }

    /// Brings back a body that was put aside and got a pose or a velocity.
    pub(super) fn bring_back(&mut self, row: u32) {
        let body = self.tables.bodies.at_mut(row);
        if core::mem::replace(&mut body.record.faulted, false) && !body.record.disabled {
            self.put_in(row);
        }
    }

    /// Puts a body that was out back into the world, with its shapes and joints.
    pub(super) fn put_in(&mut self, row: u32) {
        self.tables.bodies.at_mut(row).out = false;
        for i in 0..self.tables.bodies.at(row).ties.shapes.len() {
            self.enter_bounds(self.tables.bodies.at(row).ties.shapes[i]);
        }
        let others: Vec<u32> = self.tables.bodies.at(row).ties.joints.to_vec();
        for joint in others {
            self.enter_joint(joint);
        }
    }
}
