//! A joint as the user sees it.

use crate::base::id::{BodyId, JointId};
use crate::base::math::{Vec3, bounded};
use crate::base::quat::Quat;
use crate::state::check::{finite_vec, position, unit};
use crate::state::coupling::check_axis;
use crate::state::def::{DefError, JointDef, JointKind, JointStrength};
use crate::state::joints::{Joint, Link};
use crate::state::sixdof::{JointAxis, JointDrive, SixDof};
use crate::state::tables::Tables;

use super::World;

/// A joint, to read.
#[derive(Clone, Copy, Debug)]
pub struct JointRef<'w> {
    tables: &'w Tables,
    joint: &'w Joint,
    id: JointId,
    /// Length of the last substep [s]; 0 before the first.
    h: f32,
}

impl<'w> JointRef<'w> {
    pub(super) fn new(tables: &'w Tables, id: JointId, h: f32) -> Option<Self> {
        let row = tables.joints.rows.row(id)?;
        Some(Self { tables, joint: tables.joints.at(row), id, h })
    }

    /// Its id.
    #[must_use]
    pub const fn id(&self) -> JointId {
        self.id
    }

    /// What it does.
    #[must_use]
    pub fn kind(&self) -> JointKind {
        self.joint.link.kind()
    }

    /// Its first body.
    #[must_use]
    pub fn body_a(&self) -> BodyId {
        self.tables.bodies.id(self.joint.body_a)
    }

    /// Its second body.
    #[must_use]
    pub fn body_b(&self) -> BodyId {
        self.tables.bodies.id(self.joint.body_b)
    }

    /// Where its anchor on the first body is [m, world].
    #[must_use]
    pub fn anchor_a(&self) -> Vec3 {
        let body = self.tables.bodies.at(self.joint.body_a);
        body.center + body.rotation.rotate(self.joint.anchor_a)
    }

    /// Where its anchor on the second body is [m, world].
    #[must_use]
    pub fn anchor_b(&self) -> Vec3 {
        let body = self.tables.bodies.at(self.joint.body_b);
        body.center + body.rotation.rotate(self.joint.anchor_b)
    }

    /// Its anchors [m, each in the frame of its body's origin]; of a coupling without meaning.
    #[must_use]
    pub fn local_anchors(&self) -> [Vec3; 2] {
        let center = |row: u32| self.tables.bodies.at(row).local_center;
        let joint = self.joint;
        [joint.anchor_a + center(joint.body_a), joint.anchor_b + center(joint.body_b)]
    }

    /// Whether its bodies collide with each other.
    #[must_use]
    pub const fn collide_connected(&self) -> bool {
        self.joint.collide_connected
    }

    /// False if it was switched off: see [`World::set_joint_enabled`].
    #[must_use]
    pub fn is_enabled(&self) -> bool {
        self.joint.is_on()
    }

    /// True if it acts on nothing now: it is disabled, one of its bodies is out of the world, or none is dynamic.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        self.joint.is_idle(&self.tables.bodies)
    }

    /// The user's number.
    #[must_use]
    pub const fn user_data(&self) -> u64 {
        self.joint.user_data
    }

    /// What it can bear; `None`: anything.
    #[must_use]
    pub const fn strength(&self) -> Option<JointStrength> {
        self.joint.strength
    }

    /// How far it is worn out, 0 (new) to 1, where it breaks.
    #[must_use]
    pub const fn damage(&self) -> f32 {
        self.joint.damage
    }

    /// Force of the joint on its second body, in the last substep [N, world]; the first one gets the
    /// opposite, but of a pulley, the tension toward its own point. It acts at the second anchor. Zero before the first step.
    #[must_use]
    pub fn force(&self) -> Vec3 {
        let impulse = match &self.joint.link {
            Link::Ball => self.joint.impulse,
            Link::Distance { .. } => {
                let p = self.joint.impulse;
                (self.anchor_b() - self.anchor_a()).normalize_or(Vec3::Y) * (p.x - p.y + p.z)
            }
            Link::Six(six) => six.state.force,
            Link::Pulley(pulley) => {
                let [_, point] = pulley.points;
                let along = (self.anchor_b() - point).normalize_or(Vec3::Y);
                along * (pulley.ratio * self.joint.impulse.x)
            }
            Link::Coupling(_) => Vec3::ZERO,
        };
        self.per_time(impulse)
    }

    /// Torque of the joint on its second body about the second anchor, in the last substep [N m, world];
    /// the first one gets the opposite. Zero for balls and distances.
    #[must_use]
    pub fn torque(&self) -> Vec3 {
        match &self.joint.link {
            Link::Six(six) => self.per_time(six.state.torque),
            _ => Vec3::ZERO,
        }
    }

    fn per_time(&self, impulse: Vec3) -> Vec3 {
        if self.h > 0.0 { (impulse * (1.0 / self.h)).bounded() } else { Vec3::ZERO }
    }

    /// Tension of a pulley's rope in the last substep [N]; below 0 where a rigid one is pushed. `None` for
    /// other joints.
    #[must_use]
    pub fn tension(&self) -> Option<f32> {
        let is_pulley = matches!(self.joint.link, Link::Pulley(_));
        is_pulley.then(|| -self.per_time(self.joint.impulse).x)
    }

    /// Force of a coupling along the coordinate that follows, in the last substep [N; N m]; the one that is
    /// followed gets -ratio times as much. `None` for other joints.
    #[must_use]
    pub fn coupling_force(&self) -> Option<f32> {
        let Link::Coupling(coupling) = &self.joint.link else { return None };
        Some(if self.h > 0.0 { bounded(coupling.impulse / self.h) } else { 0.0 })
    }

    /// Of a coupling, how far the coordinate that follows is from where it should be: a length [m] and an angle
    /// [rad], one of them 0.
    fn coupling_error(&self) -> Option<[f32; 2]> {
        let Link::Coupling(coupling) = &self.joint.link else { return None };
        let error = coupling.error(&self.tables.joints, &self.tables.bodies).abs();
        Some(if coupling.def.axis_b > 2 { [0.0, error] } else { [error, 0.0] })
    }

    /// Where the second frame is in the first one of a joint of six axes: along x, y, z [m, frame of the
    /// joint on the first body] and about them [rad], as [`SixDof`] says. `None` for other joints.
    #[must_use]
    pub fn coordinates(&self) -> Option<[Vec3; 2]> {
        let Link::Six(six) = &self.joint.link else { return None };
        let bodies = &self.tables.bodies;
        let (a, b) = (bodies.at(self.joint.body_a), bodies.at(self.joint.body_b));
        let turns = six.turns(a.rotation, b.rotation);
        let gap = (a.rotation * six.def.frame_a).unrotate(self.anchor_b() - self.anchor_a());
        let mut angles = turns.angles;
        if six.def.cone.is_some() {
            let ([c, s], swing) = (turns.swing, turns.angles[1]);
            (angles[1], angles[2]) = (c * swing, s * swing);
        }
        Some([gap, Vec3::from(angles)])
    }

    /// How far it is from what it asks [m]: the gap of a ball joint, the excess of a distance, the excess
    /// over what the motions of a joint of six axes allow, how far a coupled slider is from its place, how much
    /// longer a pulley's way is than its rope.
    #[must_use]
    pub fn error(&self) -> f32 {
        if let Some([length, _]) = self.coupling_error() {
            return length;
        }
        self.joint.error(&self.tables.bodies)
    }

    /// How far the turns of a joint of six axes are from what they are allowed, or a coupled hinge from its angle
    /// [rad]; 0 for other joints.
    #[must_use]
    pub fn angular_error(&self) -> f32 {
        if let Some([_, angle]) = self.coupling_error() {
            return angle;
        }
        self.joint.angular_error(&self.tables.bodies)
    }
}

impl World {
    /// A joint of six axes with both frames at one place of the world, at the current poses: their origin
    /// `anchor` [m, world], their x axis along `axis` [world, any length]. The frames of `axes` are not
    /// read.
    ///
    /// # Errors
    /// A body that is not of this world; an anchor or axis that is not finite; an axis of no length.
    pub fn joint_along(
        &self,
        body_a: BodyId,
        body_b: BodyId,
        anchor: impl Into<Vec3>,
        axis: impl Into<Vec3>,
        axes: SixDof,
    ) -> Result<JointDef, DefError> {
        let axis = axis.into();
        finite_vec("axis", axis)?;
        let Some(x) = axis.try_normalize() else {
            return Err(DefError::new("axis", "zero", "a direction"));
        };
        self.joint_in(body_a, body_b, anchor, Quat::from_arc(Vec3::X, x), axes)
    }

    /// As [`Self::joint_along`], with the axes of the frames given as a rotation [world].
    ///
    /// # Errors
    /// As there.
    pub fn joint_in(
        &self,
        body_a: BodyId,
        body_b: BodyId,
        anchor: impl Into<Vec3>,
        frame: Quat,
        axes: SixDof,
    ) -> Result<JointDef, DefError> {
        let anchor = anchor.into();
        position("anchor", anchor)?;
        unit("frame", frame)?;
        let find = |name: &str, id: BodyId| {
            let body = self.body(id);
            body.ok_or_else(|| DefError::new(name, id.index(), "a body of this world"))
        };
        let (a, b) = (find("body_a", body_a)?, find("body_b", body_b)?);
        let frame = frame.normalized();
        let axes = SixDof {
            frame_a: (a.rotation().conjugate() * frame).normalized(),
            frame_b: (b.rotation().conjugate() * frame).normalized(),
            ..axes
        };
        let [at_a, at_b] = [a, b].map(|body| body.rotation().unrotate(anchor - body.position()));
        Ok(JointDef::six_dof(body_a, at_a, body_b, at_b, axes))
    }

    /// Changes what the axes of a joint of six axes do, its frames with them, and wakes its bodies. False if
    /// there is no such joint.
    ///
    /// # Errors
    /// The first field that is out of range; a joint of another kind; an axis that becomes locked, or comes behind a
    /// cone, while a coupling names it.
    pub fn set_joint_axes(&mut self, id: JointId, axes: SixDof) -> Result<bool, DefError> {
        let Some(row) = self.tables.joints.rows.row(id) else { return Ok(false) };
        axes.validate()?;
        for coupling in self.couplings_of(id) {
            let Link::Coupling(coupling) = &self.tables.joints.at(coupling).link else { continue };
            let def = &coupling.def;
            for (joint, axis) in [(def.joint_a, def.axis_a), (def.joint_b, def.axis_b)] {
                if joint == id {
                    let (list, i) = if axis < 3 { ("linear", axis) } else { ("angular", axis - 3) };
                    check_axis(&format!("{list}[{i}], which a coupling names,"), &axes, axis)?;
                }
            }
        }
        let joint = self.tables.joints.at_mut(row);
        let Link::Six(six) = &mut joint.link else {
            return Err(DefError::new("joint", id.index(), "a joint of six axes"));
        };
        // Which blocks a joint is in goes by the one, how many rows a tree has by the other.
        let changed =
            six.def.parts() != axes.parts() || six.def.scalar_count() != axes.scalar_count();
        six.set(axes);
        self.tables.colors.bodies_changed |= changed;
        self.wake_bodies_of(row);
        Ok(true)
    }

    /// Changes one drive of a joint of six axes, and wakes its bodies: axes 0 to 2 are motions along x, y,
    /// z, 3 to 5 turns about them. False if there is no such joint.
    ///
    /// # Errors
    /// The first field of the drive that is out of range; an axis above 5; a joint of another kind; one with
    /// a cone, of which both swings change at once ([`Self::set_joint_axes`]).
    pub fn set_joint_drive(
        &mut self,
        id: JointId,
        axis: usize,
        drive: Option<JointDrive>,
    ) -> Result<bool, DefError> {
        self.change_axis(id, axis, |axis| axis.drive = drive)
    }

    /// Changes one axis of a joint of six axes, and wakes its bodies. False if there is no such joint.
    pub(super) fn change_axis(
        &mut self,
        id: JointId,
        axis: usize,
        change: impl FnOnce(&mut JointAxis),
    ) -> Result<bool, DefError> {
        let Some(row) = self.tables.joints.rows.row(id) else { return Ok(false) };
        let JointKind::SixDof(mut axes) = self.tables.joints.at(row).link.kind() else {
            return Err(DefError::new("joint", id.index(), "a joint of six axes"));
        };
        let all = axes.linear.iter_mut().chain(&mut axes.angular);
        let Some(to) = all.into_iter().nth(axis) else {
            return Err(DefError::new("axis", axis, "0 to 5"));
        };
        change(to);
        self.set_joint_axes(id, axes)
    }
}
