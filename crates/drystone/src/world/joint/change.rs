//! Changes of a living joint: its kind, its settings, and whether it acts. For single axes see
//! `joint_axis.rs`.

use super::JointRef;
use crate::base::id::JointId;
use crate::base::math::Vec3;
use crate::base::quat::Quat;
use crate::state::coupling::{CouplingDef, check_axis};
use crate::state::def::axis::Axis;
use crate::state::def::six_dof::{JointDrive, JointSpring, SixDof};
use crate::state::def::{DefError, JointKind, Pulley, Spring, position, unit};
use crate::state::joints::{Joint, JointModel, Switch};
use crate::world::World;

/// A joint for changes. Each setter checks its numbers and wakes the bodies. After an error
/// everything is unchanged.
///
/// Setters without an axis argument are for joints with one free axis, such as hinges and sliders.
/// [`Self::axis`] gives the setters of any other axis.
///
/// ```
/// use drystone::joint::Hinge;
/// use drystone::{BodyDef, JointDef, ShapeDef, World};
///
/// # fn main() -> Result<(), drystone::DefError> {
/// let mut world = World::default();
/// let wall = world.add_body(BodyDef::fixed())?;
/// let fan = world.add_body(BodyDef::dynamic().with_shape(ShapeDef::sphere(0.5)))?;
/// let axle = JointDef::new(wall, fan, Hinge::new()).at([0.0; 3]).with_axis([0.0, 0.0, 1.0]);
/// let axle = world.add_joint(axle)?;
/// if let Some(mut joint) = world.joint_mut(axle) {
///     joint.set_motor(2.0, 1.0e5);
/// }
/// world.step(1.0 / 60.0);
/// let spin = world.body(fan).map(|fan| fan.angular_velocity().z);
/// assert!(spin.is_some_and(|spin| (spin - 2.0).abs() < 1.0e-3));
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct JointMut<'w> {
    pub(crate) world: &'w mut World,
    pub(crate) row: u32,
    id: JointId,
}

impl<'w> JointMut<'w> {
    pub(crate) fn new(world: &'w mut World, id: JointId) -> Option<Self> {
        let row = world.tables.joints.rows.row(id)?;
        Some(Self { world, row, id })
    }

    /// The joint, read-only.
    #[must_use]
    pub fn get(&self) -> JointRef<'_> {
        let h = self.world.last_h;
        JointRef::new(&self.world.tables, self.id, h).expect("what is borrowed is not removed")
    }

    pub(crate) fn joint(&self) -> &Joint {
        self.world.tables.joints.at(self.row)
    }

    /// Wakes the bodies of the joint and their islands.
    pub fn wake(&mut self) {
        self.world.wake_bodies_of(self.row);
    }

    /// Moves the anchors of the joint on its bodies [m, each in the frame of its body's origin].
    /// The solver closes any gap that this causes. Move the bodies first if nothing should move in
    /// the next step.
    ///
    /// # Errors
    /// A number is not finite or too large, or the joint is a coupling, which has no anchors.
    pub fn set_anchors(
        &mut self,
        anchor_a: impl Into<Vec3>,
        anchor_b: impl Into<Vec3>,
    ) -> Result<(), DefError> {
        let (anchor_a, anchor_b) = (anchor_a.into(), anchor_b.into());
        position("anchor_a", anchor_a)?;
        position("anchor_b", anchor_b)?;
        if let JointModel::Coupling(_) | JointModel::Link = self.joint().model {
            return Err(self.other_kind("a joint with anchors"));
        }
        let bodies = &self.world.tables.bodies;
        let rows = [self.joint().body_a, self.joint().body_b];
        let [a, b] = rows.map(|row| bodies.at(row).inertia.local_center);
        self.change(|joint| (joint.anchor_a, joint.anchor_b) = (anchor_a - a, anchor_b - b));
        Ok(())
    }

    /// Sets the frames of a joint of six axes on its bodies [each in the frame of its body].
    ///
    /// With a drive to a pose ([`crate::joint::Servo`]) the first frame and anchor are the target.
    ///
    /// # Errors
    /// A rotation is not a unit quaternion, or the joint has another kind.
    pub fn set_frames(&mut self, frame_a: Quat, frame_b: Quat) -> Result<(), DefError> {
        let six_dof = self.six_dof()?;
        unit("frame_a", frame_a)?;
        unit("frame_b", frame_b)?;
        self.put_six_dof(SixDof { frame_a, frame_b, ..six_dof })
    }

    /// Replaces all axes of a joint of six axes and its cone. The joint keeps its frames; the
    /// frames of `axes` are ignored.
    ///
    /// # Errors
    /// The first field that is out of range; a joint of another kind; an axis of a coupling that
    /// would become locked or part of a cone.
    pub fn set_axes(&mut self, axes: impl Into<SixDof>) -> Result<(), DefError> {
        let SixDof { frame_a, frame_b, .. } = self.six_dof()?;
        self.put_six_dof(SixDof { frame_a, frame_b, ..axes.into() })
    }

    /// Changes the kind of the joint between the same bodies at the same anchors. Examples: a hinge
    /// that jams becomes fixed, a rod becomes a spring. From one joint of six axes to another the
    /// frames stay, as with [`Self::set_axes`]. From any other kind to one of six axes the frames
    /// are those of `kind`, by default the axes of each body.
    ///
    /// # Errors
    /// A number is out of range; the old or the new kind is a coupling; an axis of a coupling would
    /// become locked, part of a cone, or be gone.
    pub fn set_kind(&mut self, kind: impl Into<JointKind>) -> Result<(), DefError> {
        let kind = kind.into();
        let to_other = matches!(kind, JointKind::Coupling(_) | JointKind::Link);
        if to_other || matches!(self.joint().model, JointModel::Coupling(_) | JointModel::Link) {
            let value = if to_other { kind.name() } else { self.joint().model.kind().name() };
            let allowed = "a kind other than a coupling or a link";
            return Err(DefError::unsuitable("kind", value, allowed));
        }
        match (kind, &self.joint().model) {
            (JointKind::SixDof(axes), JointModel::SixDof(_)) => return self.set_axes(axes),
            (_, JointModel::SixDof(_)) if self.world.couplings_of(self.id).next().is_some() => {
                let allowed = "a joint of six axes, because a coupling refers to it";
                return Err(DefError::unsuitable("kind", kind.name(), allowed));
            }
            _ => kind.validate()?,
        }
        self.change(|joint| {
            joint.model = JointModel::new(kind);
            joint.forget();
        });
        Ok(())
    }

    /// See [`Self::set_target_rotation`].
    pub(crate) fn try_set_target_rotation(
        &mut self,
        rotation: Quat,
        spring: JointSpring,
        max_torque: f32,
    ) -> Result<(), DefError> {
        unit("rotation", rotation)?;
        let mut six_dof = self.six_dof()?;
        let Some(targets) = six_dof.swing_twist(rotation.normalized()) else {
            return Err(self.other_kind("a joint with three free turns"));
        };
        for (axis, target) in six_dof.angular.iter_mut().zip(targets) {
            axis.drive = Some(JointDrive::servo(target, spring, max_torque));
        }
        self.put_six_dof(six_dof)
    }

    /// See [`Self::set_lengths`].
    pub(crate) fn try_set_lengths(&mut self, min: f32, max: f32) -> Result<(), DefError> {
        let JointModel::Distance { spring, .. } = self.joint().model else {
            return Err(self.other_kind("a distance joint"));
        };
        self.put_distance(JointKind::Distance { min, max, spring })
    }

    /// Sets or removes the spring of a distance joint or a rope.
    ///
    /// # Errors
    /// A number is out of range, or the joint has another kind.
    pub fn set_spring(&mut self, spring: Option<Spring>) -> Result<(), DefError> {
        let JointModel::Distance { min, max, .. } = self.joint().model else {
            return Err(self.other_kind("a distance joint"));
        };
        self.put_distance(JointKind::Distance { min, max, spring })
    }

    fn put_distance(&mut self, kind: JointKind) -> Result<(), DefError> {
        kind.validate()?;
        self.change(|joint| joint.model = JointModel::new(kind));
        Ok(())
    }

    /// Sets the rope and the points of a pulley.
    ///
    /// # Errors
    /// A number is out of range, or the joint has another kind.
    pub fn set_pulley(&mut self, pulley: Pulley) -> Result<(), DefError> {
        JointKind::Pulley(pulley).validate()?;
        let JointModel::Pulley(_) = self.joint().model else {
            return Err(self.other_kind("a pulley"));
        };
        self.change(|joint| joint.model = JointModel::new(JointKind::Pulley(pulley)));
        Ok(())
    }

    /// Sets the ratio and offset of a coupling, as in [`CouplingDef`].
    ///
    /// # Errors
    /// A number is out of range, or the joint has another kind.
    pub fn set_coupling(&mut self, ratio: f32, offset: f32) -> Result<(), DefError> {
        let JointModel::Coupling(coupling) = &self.joint().model else {
            return Err(self.other_kind("a coupling"));
        };
        let def = CouplingDef { ratio, offset, ..coupling.def };
        def.validate()?;
        self.change(|joint| {
            if let JointModel::Coupling(coupling) = &mut joint.model {
                coupling.def = def;
            }
        });
        Ok(())
    }

    /// Selects whether the joint is solved together with the tree of joints that it belongs to, or
    /// by itself: see [`crate::JointDef::articulated`]. No effect on couplings.
    pub fn set_articulated(&mut self, articulated: bool) {
        if self.joint().articulated != articulated
            && !matches!(self.joint().model, JointModel::Coupling(_))
        {
            self.change(|joint| joint.articulated = articulated);
        }
    }

    /// Sets whether the joined bodies collide with each other. Contacts that are no longer allowed
    /// end.
    pub fn set_collide_connected(&mut self, collide: bool) {
        let joint = self.world.tables.joints.at_mut(self.row);
        let (a, b) = (joint.body_a, joint.body_b);
        if core::mem::replace(&mut joint.collide_connected, collide) == collide {
            return;
        }
        self.wake();
        self.world.end_forbidden(a);
        // Both bodies search for pairs again.
        for body in [a, b] {
            self.world.refresh_bounds(body);
        }
    }

    /// Enables or disables the joint. A disabled joint holds and drives nothing and cannot break,
    /// and its couplings do not act. It keeps its settings, can be changed, and filters collisions
    /// between its bodies as before. Nothing happens to a link of an articulation.
    pub fn set_enabled(&mut self, enabled: bool) {
        let (row, id) = (self.row, self.id);
        let joint = self.world.tables.joints.at_mut(row);
        if joint.is_on() == enabled || matches!(joint.model, JointModel::Link) {
            return;
        }
        joint.switch = if enabled { Switch::On } else { Switch::Off };
        if !enabled {
            self.world.take_out_joint(row);
            return;
        }
        for row in self.world.each_coupling_of(id).into_iter().chain([row]) {
            self.world.enter_joint(row);
        }
    }

    /// Sets the user's number.
    pub fn set_user_data(&mut self, data: u64) {
        self.world.tables.joints.at_mut(self.row).user_data = data;
    }

    /// The axes of a joint of six axes.
    pub(crate) fn six_dof(&self) -> Result<SixDof, DefError> {
        match &self.joint().model {
            JointModel::SixDof(six_dof) => Ok(six_dof.def),
            _ => Err(self.other_kind("a joint of six axes")),
        }
    }

    pub(crate) fn put_six_dof(&mut self, axes: SixDof) -> Result<(), DefError> {
        axes.validate()?;
        let tables = &self.world.tables;
        for coupling in self.world.couplings_of(self.id) {
            let JointModel::Coupling(coupling) = &tables.joints.at(coupling).model else {
                continue;
            };
            let def = &coupling.def;
            for (joint, axis) in [(def.joint_a, def.axis_a), (def.joint_b, def.axis_b)] {
                if joint == self.id {
                    let name = format!("{}, which a coupling names,", axis.path());
                    check_axis(&name, &axes, axis)?;
                }
            }
        }
        let tables = &mut self.world.tables;
        let JointModel::SixDof(six_dof) = &mut tables.joints.at_mut(self.row).model else {
            return Ok(());
        };
        // `parts` determines the blocks of a joint, `scalar_count` the number of rows of a tree.
        let changed = six_dof.def.parts() != axes.parts()
            || six_dof.def.scalar_count() != axes.scalar_count();
        six_dof.set(axes);
        tables.colors.bodies_changed |= changed;
        self.wake();
        Ok(())
    }

    pub(crate) fn other_kind(&self, allowed: &str) -> DefError {
        DefError::unsuitable("joint", self.joint().model.kind().name(), allowed)
    }

    /// The one free axis of a joint that has exactly one.
    pub(crate) fn only_axis(&self) -> Result<Axis, DefError> {
        let only = self.get().only_axis();
        only.ok_or_else(|| self.other_kind("a joint with one free axis, such as a hinge or slider"))
    }

    fn change(&mut self, change: impl FnOnce(&mut Joint)) {
        change(self.world.tables.joints.at_mut(self.row));
        self.world.tables.colors.bodies_changed = true;
        self.wake();
    }
}
