//! Joints and couplings that are added to a world and removed from it.

use crate::base::id::JointId;
use crate::state::bodies::Bodies;
use crate::state::coupling::{CouplingDef, check_axis};
use crate::state::def::axis::Axis;
use crate::state::def::{DefError, JointDef, JointKind};
use crate::state::joints::{Joint, JointModel, Switch};
use crate::world::World;

impl World {
    /// Adds a joint and wakes its bodies. World points and axes are converted to the frames of the
    /// bodies at their current poses.
    ///
    /// # Errors
    /// A body does not exist, neither is dynamic, or a field is out of range; then nothing is
    /// added.
    pub fn add_joint(&mut self, def: JointDef) -> Result<JointId, DefError> {
        let def = self.place_joint(def)?;
        let bodies = &self.tables.bodies;
        let (a, b) = (def.body_a.index(), def.body_b.index());
        if !bodies.at(a).is_dynamic() && !bodies.at(b).is_dynamic() {
            let value = "a body that is not dynamic";
            return Err(DefError::unsuitable(
                "body_b",
                value,
                "a dynamic body, because `body_a` is not one",
            ));
        }
        let joint = Joint {
            anchor_a: def.anchor_a - bodies.at(a).inertia.local_center,
            anchor_b: def.anchor_b - bodies.at(b).inertia.local_center,
            collide_connected: def.collide_connected,
            switch: if def.enabled { Switch::On } else { Switch::Off },
            user_data: def.user_data,
            articulated: def.articulated,
            strength: def.strength,
            ..Joint::new(a, b, JointModel::new(def.kind))
        };
        self.tables.joints.breakable += usize::from(def.strength.is_some());
        if !def.collide_connected {
            self.end_contacts_between(a, b);
        }
        Ok(self.insert_joint(joint))
    }

    /// Adds a coupling of two joints as a joint of its own, and wakes their bodies. The coupling is
    /// removed with either joint.
    ///
    /// # Errors
    /// A joint does not exist or is not of six axes, an axis is locked or part of a cone, or a
    /// field is out of range. Then nothing is added.
    pub fn add_coupling(&mut self, def: CouplingDef) -> Result<JointId, DefError> {
        def.validate()?;
        let joints = &self.tables.joints;
        let find = |name: &str, axis_name: &str, id: JointId, axis: Axis| {
            let joint = joints.rows.row(id).map(|row| joints.at(row));
            match joint.map(|j| (j, &j.model)) {
                Some((joint, JointModel::SixDof(six_dof))) => {
                    check_axis(axis_name, &six_dof.def, axis)?;
                    Ok([joint.body_a, joint.body_b])
                }
                _ => Err(DefError::missing(
                    name,
                    format_args!("JointId {}", id.index()),
                    "a joint of six axes of this world",
                )),
            }
        };
        let [a1, b1] = find("joint_a", "axis_a", def.joint_a, def.axis_a)?;
        let [a2, b2] = find("joint_b", "axis_b", def.joint_b, def.axis_b)?;
        let Some((a, b)) = between(&self.tables.bodies, [a1, b1], [a2, b2]) else {
            return Err(DefError::unsuitable(
                "joint_b",
                "a joint between the same bodies",
                "a joint with at least one other body",
            ));
        };
        let joint = Joint::new(a, b, JointModel::new(JointKind::Coupling(def)));
        Ok(self.insert_joint(joint))
    }

    /// Updates the bodies of a coupling after one of its joints moved to another body, or a body
    /// changed its kind. A coupling that no longer connects two bodies is removed, or kept
    /// unchanged if `stays` is true.
    pub(in crate::world) fn follow_joints(&mut self, row: u32, stays: bool) {
        let joints = &self.tables.joints;
        let Some(id) = joints.rows.id_at(row) else { return };
        let JointModel::Coupling(coupling) = &joints.at(row).model else { return };
        let def = &coupling.def;
        let ends = [def.joint_a, def.joint_b].map(|id| {
            let joint = joints.at(joints.rows.row(id).expect("a coupling goes with its joints"));
            [joint.body_a, joint.body_b]
        });
        let Some((a, b)) = between(&self.tables.bodies, ends[0], ends[1]) else {
            if !stays {
                self.remove_joint(id);
            }
            return;
        };
        self.sets().uncolor_joint(row);
        let tables = &mut self.tables;
        let joint = tables.joints.at_mut(row);
        let old = [joint.body_a, joint.body_b];
        (joint.body_a, joint.body_b) = (a, b);
        for body in old {
            tables.islands.cut(body, &tables.bodies);
            tables.bodies.at_mut(body).ties.joints.retain(|joint| *joint != row);
        }
        for body in [a, b] {
            tables.bodies.at_mut(body).ties.joints.push(row);
        }
        tables.colors.bodies_changed = true;
        self.enter_joint(row);
    }

    /// Wakes the bodies of a joint, and enters it into the solve.
    pub(in crate::world) fn enter_joint(&mut self, row: u32) {
        let (a, b) = (self.tables.joints.at(row).body_a, self.tables.joints.at(row).body_b);
        let mut sets = self.sets();
        sets.wake(a);
        sets.wake(b);
        sets.color_joint(row);
    }

    pub(in crate::world) fn insert_joint(&mut self, joint: Joint) -> JointId {
        let (a, b) = (joint.body_a, joint.body_b);
        let id = self.tables.joints.rows.insert(joint);
        self.tables.bodies.at_mut(a).ties.joints.push(id.index());
        self.tables.bodies.at_mut(b).ties.joints.push(id.index());
        self.enter_joint(id.index());
        id
    }

    /// Rows of the couplings of a joint; some may appear twice.
    pub(in crate::world) fn couplings_of(&self, id: JointId) -> impl Iterator<Item = u32> {
        let tables = &self.tables;
        let joint = tables.joints.rows.row(id).map(|row| tables.joints.at(row));
        let bodies = joint.into_iter().flat_map(|joint| [joint.body_a, joint.body_b]);
        let rows = bodies.flat_map(|body| tables.bodies.at(body).ties.joints.iter().copied());
        rows.filter(move |row| match &tables.joints.at(*row).model {
            JointModel::Coupling(c) => c.def.joint_a == id || c.def.joint_b == id,
            _ => false,
        })
    }

    /// The rows of [`Self::couplings_of`], each once, sorted.
    pub(in crate::world) fn each_coupling_of(&self, id: JointId) -> Vec<u32> {
        let mut rows: Vec<u32> = self.couplings_of(id).collect();
        rows.sort_unstable();
        rows.dedup();
        rows
    }

    /// Wakes the bodies of a joint.
    pub(in crate::world) fn wake_bodies_of(&mut self, joint: u32) {
        let joint = self.tables.joints.at(joint);
        let bodies = [joint.body_a, joint.body_b];
        let mut sets = self.sets();
        bodies.into_iter().for_each(|body| sets.wake(body));
    }

    /// Removes the couplings of a joint that is being removed.
    fn remove_couplings(&mut self, id: JointId) {
        let joints = &self.tables.joints;
        let gone: Vec<JointId> =
            self.couplings_of(id).filter_map(|row| joints.rows.id_at(row)).collect();
        for id in gone {
            self.remove_joint(id);
        }
    }

    fn end_contacts_between(&mut self, a: u32, b: u32) {
        let tables = &self.tables;
        let rows: Vec<u32> = tables
            .contacts
            .of_body(tables.bodies.at(a))
            .map(|(row, _)| row)
            .filter(|row| {
                let c = tables.contacts.at(*row);
                !c.is_part && (c.body_a == b || c.body_b == b)
            })
            .collect();
        for row in rows {
            self.end_contact(row);
        }
    }

    /// Removes a joint and wakes its bodies. Without the joint of a link its whole articulation is
    /// removed, and its links are free bodies. False if there is no such joint.
    pub fn remove_joint(&mut self, id: JointId) -> bool {
        self.remove_couplings(id);
        let Some(row) = self.tables.joints.rows.row(id) else { return false };
        if let JointModel::Link = self.tables.joints.at(row).model {
            self.free_links_of(self.tables.joints.at(row).body_b);
            if self.tables.joints.rows.row(id).is_none() {
                return true;
            }
        }
        let (a, b) = (self.tables.joints.at(row).body_a, self.tables.joints.at(row).body_b);
        let mut sets = self.sets();
        sets.wake(a);
        sets.wake(b);
        sets.uncolor_joint(row);
        let tables = &mut self.tables;
        tables.islands.cut(a, &tables.bodies);
        tables.islands.cut(b, &tables.bodies);
        for body in [a, b] {
            tables.bodies.at_mut(body).ties.joints.retain(|j| *j != row);
        }
        if let Some(joint) = tables.joints.rows.remove(id) {
            tables.joints.breakable -= usize::from(joint.strength.is_some());
        }
        // Shapes that the joint kept from colliding may touch again.
        for body in [a, b] {
            self.refresh_bounds(body);
        }
        true
    }
}

/// The two bodies that a coupling connects: one of each joint, at least one of them dynamic, so
/// that the islands link them.
pub(in crate::world) fn between(
    bodies: &Bodies,
    [a1, b1]: [u32; 2],
    [a2, b2]: [u32; 2],
) -> Option<(u32, u32)> {
    let moves = |row: u32| bodies.at(row).is_dynamic();
    let mut pairs = [(b1, b2), (b1, a2), (a1, b2), (a1, a2)].into_iter().filter(|(a, b)| a != b);
    let both = pairs.clone().find(|(a, b)| moves(*a) && moves(*b));
    both.or_else(|| pairs.find(|(a, b)| moves(*a) || moves(*b)))
}
