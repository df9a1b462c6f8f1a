//! Fatigue and breakage of overloaded joints.

use crate::base::math::bounded;
use crate::state::def::{DefError, JointStrength};
use crate::state::events::{JointBreak, JointLimit};
use crate::state::joints::{Joint, JointModel};
use crate::world::{JointMut, World};

/// The load of a joint in a step: force [N], torque [N m], impulse [N s].
struct Borne {
    force: f32,
    torque: f32,
    impulse: f32,
}

impl Borne {
    /// The load of a joint. `inv_h`: substeps per second.
    fn by(joint: &Joint, inv_h: f32) -> Self {
        let [force, torque] = match &joint.model {
            JointModel::Ball | JointModel::Distance { .. } | JointModel::SixDof(_) => joint.peak,
            JointModel::Pulley(_) => [joint.impulse.x.abs(), 0.0],
            JointModel::Coupling(_) | JointModel::Link => [0.0; 2],
        };
        let impulse = joint.given[0].length();
        let [force, torque] = [force, torque].map(|impulse| bounded(impulse * inv_h));
        Self { force, torque, impulse: bounded(impulse) }
    }

    /// Adds fatigue damage of one step to the joint. Returns the exceeded limit if it breaks.
    fn wear(&self, joint: &mut Joint, dt: f32) -> Option<JointLimit> {
        let strength = joint.strength?;
        if let Some(fatigue) = strength.fatigue {
            let part = (self.force / strength.force).max(self.torque / strength.torque);
            joint.damage = bounded(joint.damage + fatigue.damage(part, dt));
        }
        if self.force > strength.force {
            Some(JointLimit::Force)
        } else if self.torque > strength.torque {
            Some(JointLimit::Torque)
        } else if self.impulse > strength.impulse {
            Some(JointLimit::Impulse)
        } else {
            (joint.damage >= 1.0).then_some(JointLimit::Fatigue)
        }
    }
}

impl World {
    /// Removes the overloaded joints in the order of their slots. `inv_h`: substeps per second;
    /// `dt`: length of the step [s].
    pub(in crate::world) fn break_joints(&mut self, inv_h: f32, dt: f32) {
        if self.tables.joints.breakable == 0 {
            return;
        }
        let mut broken = core::mem::take(&mut self.tables.events.joint_break);
        let bodies = &self.tables.bodies;
        let slots = u32::try_from(self.tables.joints.rows.slot_count()).unwrap_or(u32::MAX);
        for row in 0..slots {
            let Some(id) = self.tables.joints.rows.id_at(row) else { continue };
            let joint = self.tables.joints.at_mut(row);
            let (a, b) = (bodies.at(joint.body_a), bodies.at(joint.body_b));
            if joint.strength.is_none() || !(a.active() || b.active()) {
                continue;
            }
            let borne = Borne::by(joint, inv_h);
            if let Some(limit) = borne.wear(joint, dt) {
                let (body_a, body_b) = (bodies.id(joint.body_a), bodies.id(joint.body_b));
                let Borne { force, torque, impulse } = borne;
                let damage = joint.damage;
                broken.push(JointBreak {
                    joint: id,
                    body_a,
                    body_b,
                    limit,
                    force,
                    torque,
                    impulse,
                    damage,
                });
            }
        }
        for one in &broken {
            self.remove_joint(one.joint);
        }
        self.tables.events.joint_break = broken;
    }
}

impl JointMut<'_> {
    /// Sets the strength of the joint and resets its fatigue damage to 0. A coupling never breaks.
    ///
    /// # Errors
    /// The first limit that is out of range.
    pub fn set_strength(&mut self, strength: Option<JointStrength>) -> Result<(), DefError> {
        if let Some(strength) = &strength {
            strength.validate().map_err(|e| e.within("strength"))?;
        }
        let joints = &mut self.world.tables.joints;
        let joint = joints.at_mut(self.row);
        let old = core::mem::replace(&mut joint.strength, strength);
        joint.damage = 0.0;
        joints.breakable =
            joints.breakable + usize::from(strength.is_some()) - usize::from(old.is_some());
        Ok(())
    }
}
