//! A joint, changed while it lives: what it holds, by what measures, and whether it acts. Single axes: see `joint_axis.rs`.

use super::World;
use super::joint::JointRef;
use crate::base::id::JointId;
use crate::base::math::Vec3;
use crate::base::quat::Quat;
use crate::state::axis::Axis;
use crate::state::coupling::{CouplingDef, check_axis};
use crate::state::def::{DefError, JointKind, Pulley, Spring, position, unit};
use crate::state::joints::{Joint, Link, Switch};
use crate::state::sixdof::{JointDrive, JointSpring, SixDof};

/// A joint, to change. Each setter checks its numbers and wakes the bodies. An error leaves everything as it was.
///
/// The setters that name no axis are for joints with one free axis, such as hinges and sliders. [`Self::axis`] has those of
/// any other axis.
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
    pub(super) world: &'w mut World,
    pub(super) row: u32,
    id: JointId,
}

impl<'w> JointMut<'w> {
    pub(super) fn new(world: &'w mut World, id: JointId) -> Option<Self> {
        let row = world.tables.joints.rows.row(id)?;
        Some(Self { world, row, id })
    }

    /// The joint, to read.
    #[must_use]
    pub fn get(&self) -> JointRef<'_> {
        let h = self.world.last_h;
        JointRef::new(&self.world.tables, self.id, h).expect("what is borrowed is not removed")
    }

    pub(super) fn joint(&self) -> &Joint {
        self.world.tables.joints.at(self.row)
    }

    /// Wakes its bodies, with the islands they are in.
    pub fn wake(&mut self) {
        self.world.wake_bodies_of(self.row);
    }

    /// Fastens it elsewhere on its bodies, at these anchors [m, each in the frame of its body's origin]. An error that this
    /// makes is closed as any is: put the bodies in their places where nothing is to move.
    ///
    /// # Errors
    /// A number is not finite or too large; a coupling, which has no anchors.
    pub fn set_anchors(
        &mut self,
        anchor_a: impl Into<Vec3>,
        anchor_b: impl Into<Vec3>,
    ) -> Result<(), DefError> {
        let (anchor_a, anchor_b) = (anchor_a.into(), anchor_b.into());
        position("anchor_a", anchor_a)?;
        position("anchor_b", anchor_b)?;
        if let Link::Coupling(_) = self.joint().link {
            return Err(self.other_kind("a joint with anchors"));
        }
        let bodies = &self.world.tables.bodies;
        let rows = [self.joint().body_a, self.joint().body_b];
        let [a, b] = rows.map(|row| bodies.at(row).local_center);
        self.change(|joint| (joint.anchor_a, joint.anchor_b) = (anchor_a - a, anchor_b - b));
        Ok(())
    }

    /// Turns the axes of a joint of six axes on its bodies [each in the frame of its body].
    ///
    /// With a drive to a pose ([`crate::joint::Servo`]) the first frame and anchor are the target.
    ///
    /// # Errors
    /// A rotation is not a unit quaternion; a joint of another kind.
    pub fn set_frames(&mut self, frame_a: Quat, frame_b: Quat) -> Result<(), DefError> {
        let six = self.six()?;
        unit("frame_a", frame_a)?;
        unit("frame_b", frame_b)?;
        self.put_six(SixDof { frame_a, frame_b, ..six })
    }

    /// Changes all axes of a joint of six axes and its cone. Its frames stay: those of `axes` are not read.
    ///
    /// # Errors
    /// The first field that is out of range; a joint of another kind; an axis that becomes locked, or comes behind a
    /// cone, while a coupling names it.
    pub fn set_axes(&mut self, axes: impl Into<SixDof>) -> Result<(), DefError> {
        let SixDof { frame_a, frame_b, .. } = self.six()?;
        self.put_six(SixDof { frame_a, frame_b, ..axes.into() })
    }

    /// Makes another joint of it, between the same bodies at the same anchors: a hinge that jams and becomes fixed, a rod that
    /// becomes a spring. From one joint of six axes to another its frames stay, as with [`Self::set_axes`]; from any other kind
    /// to one of six axes they are those of `kind`, by default the axes of each body.
    ///
    /// # Errors
    /// A number that is out of range; a coupling, before or after; an axis that becomes locked, or comes behind a cone, or is
    /// there no longer, while a coupling names it.
    pub fn set_kind(&mut self, kind: impl Into<JointKind>) -> Result<(), DefError> {
        let kind = kind.into();
        let to_coupling = matches!(kind, JointKind::Coupling(_));
        if to_coupling || matches!(self.joint().link, Link::Coupling(_)) {
            let value = if to_coupling { kind.name() } else { self.joint().link.kind().name() };
            return Err(DefError::unsuitable("kind", value, "a kind other than a coupling"));
        }
        match (kind, &self.joint().link) {
            (JointKind::SixDof(axes), Link::Six(_)) => return self.set_axes(axes),
            (_, Link::Six(_)) if self.world.couplings_of(self.id).next().is_some() => {
                let allowed = "a joint of six axes, because a coupling refers to it";
                return Err(DefError::unsuitable("kind", kind.name(), allowed));
            }
            _ => kind.validate()?,
        }
        self.change(|joint| {
            joint.link = Link::new(kind);
            joint.forget();
        });
        Ok(())
    }

    /// See [`Self::set_target_rotation`].
    pub(super) fn try_set_target_rotation(
        &mut self,
        rotation: Quat,
        spring: JointSpring,
        max_torque: f32,
    ) -> Result<(), DefError> {
        unit("rotation", rotation)?;
        let mut six = self.six()?;
        let Some(targets) = six.swing_twist(rotation.normalized()) else {
            return Err(self.other_kind("a joint with three free turns"));
        };
        for (axis, target) in six.angular.iter_mut().zip(targets) {
            axis.drive = Some(JointDrive::servo(target, spring, max_torque));
        }
        self.put_six(six)
    }

    /// See [`Self::set_lengths`].
    pub(super) fn try_set_lengths(&mut self, min: f32, max: f32) -> Result<(), DefError> {
        let Link::Distance { spring, .. } = self.joint().link else {
            return Err(self.other_kind("a distance joint"));
        };
        self.put_distance(JointKind::Distance { min, max, spring })
    }

    /// Gives a distance joint, a rope or a spring another spring, or none.
    ///
    /// # Errors
    /// A number that is out of range; a joint of another kind.
    pub fn set_spring(&mut self, spring: Option<Spring>) -> Result<(), DefError> {
        let Link::Distance { min, max, .. } = self.joint().link else {
            return Err(self.other_kind("a distance joint"));
        };
        self.put_distance(JointKind::Distance { min, max, spring })
    }

    fn put_distance(&mut self, kind: JointKind) -> Result<(), DefError> {
        kind.validate()?;
        self.change(|joint| joint.link = Link::new(kind));
        Ok(())
    }

    /// Gives a pulley another rope or other points.
    ///
    /// # Errors
    /// A number that is out of range; a joint of another kind.
    pub fn set_pulley(&mut self, pulley: Pulley) -> Result<(), DefError> {
        JointKind::Pulley(pulley).validate()?;
        let Link::Pulley(_) = self.joint().link else { return Err(self.other_kind("a pulley")) };
        self.change(|joint| joint.link = Link::new(JointKind::Pulley(pulley)));
        Ok(())
    }

    /// Gives a coupling another ratio and offset, as in [`CouplingDef`].
    ///
    /// # Errors
    /// A number that is out of range; a joint of another kind.
    pub fn set_coupling(&mut self, ratio: f32, offset: f32) -> Result<(), DefError> {
        let Link::Coupling(coupling) = &self.joint().link else {
            return Err(self.other_kind("a coupling"));
        };
        let def = CouplingDef { ratio, offset, ..coupling.def };
        def.validate()?;
        self.change(|joint| {
            if let Link::Coupling(coupling) = &mut joint.link {
                coupling.def = def;
            }
        });
        Ok(())
    }

    /// Solves it at once with the tree of joints that it belongs to, or one by one: see [`crate::JointDef::articulated`].
    /// Nothing for a coupling.
    pub fn set_articulated(&mut self, articulated: bool) {
        if self.joint().articulated != articulated
            && !matches!(self.joint().link, Link::Coupling(_))
        {
            self.change(|joint| joint.articulated = articulated);
        }
    }

    /// Lets its bodies collide with each other or not. Touches that may not be any longer end.
    pub fn set_collide_connected(&mut self, collide: bool) {
        let joint = self.world.tables.joints.at_mut(self.row);
        let (a, b) = (joint.body_a, joint.body_b);
        if core::mem::replace(&mut joint.collide_connected, collide) == collide {
            return;
        }
        self.wake();
        self.world.end_forbidden(a);
        // They look for pairs again.
        for body in [a, b] {
            self.world.refresh_bounds(body);
        }
    }

    /// Switches it off or on. One that is off holds nothing, drives nothing and cannot break, nor do couplings of it act; it
    /// is kept, can be changed, and lets its bodies collide or not as before.
    pub fn set_enabled(&mut self, enabled: bool) {
        let (row, id) = (self.row, self.id);
        let joint = self.world.tables.joints.at_mut(row);
        if joint.is_on() == enabled {
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
    pub(super) fn six(&self) -> Result<SixDof, DefError> {
        match &self.joint().link {
            Link::Six(six) => Ok(six.def),
            _ => Err(self.other_kind("a joint of six axes")),
        }
    }

    pub(super) fn put_six(&mut self, axes: SixDof) -> Result<(), DefError> {
        axes.validate()?;
        let tables = &self.world.tables;
        for coupling in self.world.couplings_of(self.id) {
            let Link::Coupling(coupling) = &tables.joints.at(coupling).link else { continue };
            let def = &coupling.def;
            for (joint, axis) in [(def.joint_a, def.axis_a), (def.joint_b, def.axis_b)] {
                if joint == self.id {
                    let name = format!("{}, which a coupling names,", axis.path());
                    check_axis(&name, &axes, axis)?;
                }
            }
        }
        let tables = &mut self.world.tables;
        let Link::Six(six) = &mut tables.joints.at_mut(self.row).link else { return Ok(()) };
        // Which blocks a joint is in goes by the one, how many rows a tree has by the other.
        let changed =
            six.def.parts() != axes.parts() || six.def.scalar_count() != axes.scalar_count();
        six.set(axes);
        tables.colors.bodies_changed |= changed;
        self.wake();
        Ok(())
    }

    pub(super) fn other_kind(&self, allowed: &str) -> DefError {
        DefError::unsuitable("joint", self.joint().link.kind().name(), allowed)
    }

    /// The one free axis of a joint that has one.
    pub(super) fn only_axis(&self) -> Result<Axis, DefError> {
        let only = self.get().only_axis();
        only.ok_or_else(|| self.other_kind("a joint with one free axis, such as a hinge or slider"))
    }

    fn change(&mut self, change: impl FnOnce(&mut Joint)) {
        change(self.world.tables.joints.at_mut(self.row));
        self.world.tables.colors.bodies_changed = true;
        self.wake();
    }
}
