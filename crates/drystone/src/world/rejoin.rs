//! What a joint holds and by what measures, changed while it lives. Its axes and drives: see `joint.rs`.

use super::World;
use crate::base::id::JointId;
use crate::base::math::Vec3;
use crate::state::coupling::CouplingDef;
use crate::state::def::{DefError, JointKind, Pulley, Spring, position};
use crate::state::joints::{Joint, Link, Switch};
use crate::state::sixdof::JointMotion;

impl World {
    /// Fastens a joint elsewhere on its bodies, at these anchors [m, each in the frame of its body's origin], and wakes them.
    /// An error that this makes is closed as any is: put the bodies in their places where nothing is to move. The frames of
    /// a joint of six axes are changed with its axes ([`Self::set_joint_axes`]). False if there is no such joint.
    ///
    /// # Errors
    /// A number is not finite or too large; a coupling, which has no anchors. Then nothing is changed.
    pub fn set_joint_anchors(
        &mut self,
        id: JointId,
        anchor_a: impl Into<Vec3>,
        anchor_b: impl Into<Vec3>,
    ) -> Result<bool, DefError> {
        let (anchor_a, anchor_b) = (anchor_a.into(), anchor_b.into());
        position("anchor_a", anchor_a)?;
        position("anchor_b", anchor_b)?;
        let Some(row) = self.tables.joints.rows.row(id) else { return Ok(false) };
        let bodies = &self.tables.bodies;
        let joint = self.tables.joints.at(row);
        let [a, b] = [joint.body_a, joint.body_b].map(|row| bodies.at(row).local_center);
        self.change_joint(id, |joint| {
            if let Link::Coupling(_) = joint.link {
                return Err(DefError::new("joint", id.index(), "a joint with anchors"));
            }
            (joint.anchor_a, joint.anchor_b) = (anchor_a - a, anchor_b - b);
            Ok(())
        })
    }

    /// Changes the lengths of a distance joint [m] and its spring, and wakes its bodies. False if there is no such joint.
    ///
    /// # Errors
    /// A length that is not from 0 to 1e9 m, a greatest one below the least, a number of the spring that is out of range;
    /// a joint of another kind. Then nothing is changed.
    pub fn set_joint_lengths(
        &mut self,
        id: JointId,
        [min, max]: [f32; 2],
        spring: Option<Spring>,
    ) -> Result<bool, DefError> {
        let kind = JointKind::Distance { min, max, spring };
        kind.validate()?;
        self.change_joint(id, |joint| match joint.link {
            Link::Distance { .. } => {
                joint.link = Link::new(kind);
                Ok(())
            }
            _ => Err(DefError::new("joint", id.index(), "a distance joint")),
        })
    }

    /// Gives a pulley another rope or other points, and wakes its bodies. False if there is no such joint.
    ///
    /// # Errors
    /// A number that is out of range; a joint of another kind. Then nothing is changed.
    pub fn set_joint_pulley(&mut self, id: JointId, pulley: Pulley) -> Result<bool, DefError> {
        JointKind::Pulley(pulley).validate()?;
        self.change_joint(id, |joint| match &mut joint.link {
            Link::Pulley(now) => {
                **now = pulley;
                Ok(())
            }
            _ => Err(DefError::new("joint", id.index(), "a pulley")),
        })
    }

    /// Gives a coupling another ratio and offset, as in [`CouplingDef`], and wakes its bodies. False if there is no such
    /// joint.
    ///
    /// # Errors
    /// A number that is out of range; a joint of another kind. Then nothing is changed.
    pub fn set_coupling(&mut self, id: JointId, ratio: f32, offset: f32) -> Result<bool, DefError> {
        self.change_joint(id, |joint| {
            let Link::Coupling(coupling) = &mut joint.link else {
                return Err(DefError::new("joint", id.index(), "a coupling"));
            };
            let def = CouplingDef { ratio, offset, ..coupling.def };
            def.validate()?;
            coupling.def = def;
            Ok(())
        })
    }

    /// Changes how far one axis of a joint of six axes lets its bodies move, and wakes them: axes 0 to 2 are motions along x,
    /// y, z [m], 3 to 5 turns about them [rad]. Its drive and friction stay. False if there is no such joint.
    ///
    /// # Errors
    /// A limit that is out of range; an axis above 5, or one that becomes locked while a coupling names it; a joint of another
    /// kind. Then nothing is changed.
    pub fn set_joint_motion(
        &mut self,
        id: JointId,
        axis: usize,
        motion: JointMotion,
    ) -> Result<bool, DefError> {
        self.change_axis(id, axis, |axis| axis.motion = motion)
    }

    /// Lets the bodies of a joint collide with each other or not; they wake. Touches that may not be any longer end. False
    /// if there is no such joint.
    pub fn set_joint_collide_connected(&mut self, id: JointId, collide: bool) -> bool {
        let Some(row) = self.tables.joints.rows.row(id) else { return false };
        let joint = self.tables.joints.at_mut(row);
        let (a, b) = (joint.body_a, joint.body_b);
        if core::mem::replace(&mut joint.collide_connected, collide) == collide {
            return true;
        }
        self.wake_bodies_of(row);
        self.end_forbidden(a);
        // They look for pairs again.
        for body in [a, b] {
            self.refresh_bounds(body);
        }
        true
    }

    /// Switches a joint off or on. One that is off holds nothing, drives nothing and cannot break, nor do couplings of it
    /// act; it is kept, can be changed, and lets its bodies collide or not as before. Its bodies wake. False if there is no
    /// such joint.
    pub fn set_joint_enabled(&mut self, id: JointId, enabled: bool) -> bool {
        let Some(row) = self.tables.joints.rows.row(id) else { return false };
        let joint = self.tables.joints.at_mut(row);
        if joint.is_on() == enabled {
            return true;
        }
        joint.switch = if enabled { Switch::On } else { Switch::Off };
        if !enabled {
            self.take_out_joint(row);
            return true;
        }
        for row in self.each_coupling_of(id).into_iter().chain([row]) {
            self.enter_joint(row);
        }
        true
    }

    /// Sets the user's number of a joint. False if there is no such joint.
    pub fn set_joint_user_data(&mut self, id: JointId, data: u64) -> bool {
        let Some(row) = self.tables.joints.rows.row(id) else { return false };
        self.tables.joints.at_mut(row).user_data = data;
        true
    }

    /// Changes a joint, and wakes its bodies. False if there is no such joint.
    fn change_joint(
        &mut self,
        id: JointId,
        change: impl FnOnce(&mut Joint) -> Result<(), DefError>,
    ) -> Result<bool, DefError> {
        let Some(row) = self.tables.joints.rows.row(id) else { return Ok(false) };
        let joint = self.tables.joints.at_mut(row);
        change(joint)?;
        self.tables.colors.bodies_changed = true;
        self.wake_bodies_of(row);
        Ok(true)
    }
}
