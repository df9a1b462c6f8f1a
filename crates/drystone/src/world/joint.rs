//! Public access to a joint.

pub(crate) mod axis;
pub(crate) mod change;
pub(crate) mod add;

use crate::base::id::{BodyId, JointId};
use crate::base::math::{Vec3, bounded};
use crate::state::def::axis::Axis;
use crate::state::def::check::position;
use crate::state::def::six_dof::{JointMotion, SixDof};
use crate::state::def::{DefError, JointDef, JointKind, JointStrength};
use crate::state::joints::{Joint, JointModel};
use crate::state::tables::Tables;

use self::axis::AxisRef;
use super::World;

/// A joint, read-only: its kind, place and loads. [`AxisRef`] gives the values of one axis.
#[derive(Clone, Copy, Debug)]
pub struct JointRef<'w> {
    pub(super) tables: &'w Tables,
    pub(super) joint: &'w Joint,
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

    /// Its kind and settings.
    #[must_use]
    pub fn kind(&self) -> JointKind {
        self.joint.model.kind()
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

    /// Its anchor on the first body [m, world].
    #[must_use]
    pub fn anchor_a(&self) -> Vec3 {
        let body = self.tables.bodies.at(self.joint.body_a);
        body.center + body.rotation.rotate(self.joint.anchor_a)
    }

    /// Its anchor on the second body [m, world].
    #[must_use]
    pub fn anchor_b(&self) -> Vec3 {
        let body = self.tables.bodies.at(self.joint.body_b);
        body.center + body.rotation.rotate(self.joint.anchor_b)
    }

    /// Its anchors [m, each in the frame of its body's origin]; meaningless for a coupling.
    #[must_use]
    pub fn local_anchors(&self) -> [Vec3; 2] {
        let center = |row: u32| self.tables.bodies.at(row).inertia.local_center;
        let joint = self.joint;
        [joint.anchor_a + center(joint.body_a), joint.anchor_b + center(joint.body_b)]
    }

    /// Whether its bodies collide with each other.
    #[must_use]
    pub const fn collide_connected(&self) -> bool {
        self.joint.collide_connected
    }

    /// False if it is disabled: see [`super::JointMut::set_enabled`].
    #[must_use]
    pub fn is_enabled(&self) -> bool {
        self.joint.is_on()
    }

    /// True if it acts on nothing now: it is disabled, one of its bodies is out of the world, or
    /// none is dynamic.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        self.joint.is_idle(&self.tables.bodies)
    }

    /// The user's number.
    #[must_use]
    pub const fn user_data(&self) -> u64 {
        self.joint.user_data
    }

    /// The load at which it breaks; `None`: it never breaks.
    #[must_use]
    pub const fn strength(&self) -> Option<JointStrength> {
        self.joint.strength
    }

    /// Accumulated fatigue damage, 0 (new) to 1 (breaks).
    #[must_use]
    pub const fn damage(&self) -> f32 {
        self.joint.damage
    }

    /// Force of the joint on its second body in the last substep [N, world]. It acts at the second
    /// anchor. The first body gets the opposite force, except for a pulley, where the tension pulls
    /// it toward its own point. Zero before the first step.
    ///
    /// For a body with a damping of c [1/s], the fraction c × substep of its weight is missing from
    /// this force. Damping acts over a whole substep and reduces the velocity that gravity adds,
    /// and the joint acts afterwards.
    #[must_use]
    pub fn force(&self) -> Vec3 {
        let impulse = match &self.joint.model {
            JointModel::Ball => self.joint.impulse,
            JointModel::Distance { .. } => {
                let p = self.joint.impulse;
                (self.anchor_b() - self.anchor_a()).normalize_or(Vec3::Y) * (p.x - p.y + p.z)
            }
            JointModel::SixDof(six_dof) => six_dof.state.force,
            JointModel::Pulley(pulley) => {
                let [_, point] = pulley.points;
                let along = (self.anchor_b() - point).normalize_or(Vec3::Y);
                along * (pulley.ratio * self.joint.impulse.x)
            }
            JointModel::Coupling(_) | JointModel::Link => Vec3::ZERO,
        };
        self.per_time(impulse)
    }

    /// Torque of the joint on its second body about the second anchor, in the last substep [N m,
    /// world]. The first body gets the opposite. Zero for ball and distance joints.
    #[must_use]
    pub fn torque(&self) -> Vec3 {
        match &self.joint.model {
            JointModel::SixDof(six_dof) => self.per_time(six_dof.state.torque),
            _ => Vec3::ZERO,
        }
    }

    pub(super) fn per_time(&self, impulse: Vec3) -> Vec3 {
        if self.h > 0.0 { (impulse * (1.0 / self.h)).bounded() } else { Vec3::ZERO }
    }

    /// Tension of a rope, a rod, a spring or a pulley in the last substep [N]; negative under
    /// compression. `None` for other joints.
    #[must_use]
    pub fn tension(&self) -> Option<f32> {
        let p = self.joint.impulse;
        let push = match self.joint.model {
            JointModel::Pulley(_) => p.x,
            JointModel::Distance { .. } => p.x - p.y + p.z,
            _ => return None,
        };
        Some(-self.per_time(Vec3::X * push).x)
    }

    /// Force of a coupling along the driven coordinate, in the last substep [N; N m]. The driving
    /// coordinate gets -ratio times this force. `None` for other joints.
    #[must_use]
    pub fn coupling_force(&self) -> Option<f32> {
        let JointModel::Coupling(coupling) = &self.joint.model else { return None };
        Some(if self.h > 0.0 { bounded(coupling.impulse / self.h) } else { 0.0 })
    }

    /// Deviation of the driven coordinate of a coupling from its target: a length [m] and an angle
    /// [rad], one of them 0. `None` for other joints.
    fn coupling_error(&self) -> Option<[f32; 2]> {
        let JointModel::Coupling(coupling) = &self.joint.model else { return None };
        let error = coupling.error(&self.tables.joints, &self.tables.bodies).abs();
        Some(if coupling.def.axis_b.is_turn() { [0.0, error] } else { [error, 0.0] })
    }

    /// One of its axes; `None` if it is not a joint of six axes.
    #[must_use]
    pub fn axis(&self, axis: Axis) -> Option<AxisRef<'w>> {
        AxisRef::new(*self, axis)
    }

    /// The one free rotation axis of a hinge, a cylinder or a wheel without steering. `None` if it
    /// has none or several.
    #[must_use]
    pub fn hinge(&self) -> Option<AxisRef<'w>> {
        let mut turns = self.free_axes().filter(|axis| axis.is_turn());
        let only = turns.next()?;
        if turns.next().is_some() { None } else { self.axis(only) }
    }

    /// The one free translation axis of a slider, a cylinder or a wheel with a spring. `None` if it
    /// has none or several.
    #[must_use]
    pub fn slider(&self) -> Option<AxisRef<'w>> {
        let mut motions = self.free_axes().filter(|axis| !axis.is_turn());
        let only = motions.next()?;
        if motions.next().is_some() { None } else { self.axis(only) }
    }

    /// Angle of the one free rotation of a hinge [rad], with full turns counted: see
    /// [`Self::hinge`].
    #[must_use]
    pub fn angle(&self) -> Option<f32> {
        self.hinge().map(|turn| turn.position())
    }

    /// Distance of its anchors [m]: the length of a rope, a spring or a rod.
    #[must_use]
    pub fn length(&self) -> f32 {
        (self.anchor_b() - self.anchor_a()).length()
    }

    /// The free axis, if there is exactly one.
    pub(super) fn only_axis(&self) -> Option<Axis> {
        let mut axes = self.free_axes();
        let only = axes.next()?;
        axes.next().is_none().then_some(only)
    }

    /// The axes of a joint of six axes that are not locked.
    fn free_axes(&self) -> impl Iterator<Item = Axis> {
        let six_dof = if let JointModel::SixDof(six_dof) = &self.joint.model {
            Some(&six_dof.def)
        } else {
            None
        };
        let is_free = move |axis: &Axis| {
            six_dof.is_some_and(|six_dof| six_dof.axis(*axis).motion != JointMotion::Locked)
        };
        Axis::ALL.iter().copied().filter(is_free)
    }

    /// A definition that creates the same joint between the same bodies at the same anchors. `None`
    /// for a coupling, whose definition [`Self::kind`] gives.
    #[must_use]
    pub fn to_def(&self) -> Option<JointDef> {
        if let JointModel::Coupling(_) = self.joint.model {
            return None;
        }
        let [anchor_a, anchor_b] = self.local_anchors();
        let def = JointDef::new(self.body_a(), self.body_b(), self.kind());
        Some(JointDef {
            collide_connected: self.joint.collide_connected,
            strength: self.joint.strength,
            articulated: self.joint.articulated,
            enabled: self.is_enabled(),
            user_data: self.joint.user_data,
            ..def.with_anchors(anchor_a, anchor_b)
        })
    }

    /// Coordinates of a joint of six axes, as defined by [`SixDof`]: those of the second frame in
    /// the first, along x, y, z [m, frame of the joint on the first body] and about them [rad].
    /// `None` for other joints.
    #[must_use]
    pub fn coordinates(&self) -> Option<[Vec3; 2]> {
        let JointModel::SixDof(six_dof) = &self.joint.model else { return None };
        let bodies = &self.tables.bodies;
        let (a, b) = (bodies.at(self.joint.body_a), bodies.at(self.joint.body_b));
        let turns = six_dof.joint_angles(a.rotation, b.rotation);
        let gap = (a.rotation * six_dof.def.frame_a).unrotate(self.anchor_b() - self.anchor_a());
        let mut angles = turns.angles;
        if six_dof.def.cone.is_some() {
            let ([c, s], swing) = (turns.swing, turns.angles[1]);
            (angles[1], angles[2]) = (c * swing, s * swing);
        }
        Some([gap, Vec3::from(angles)])
    }

    /// Constraint error [m], depending on the kind of joint:
    ///
    /// * ball joint: the gap of the anchors
    /// * distance: the excess over its limits
    /// * six axes: the excess over the limits of the linear axes
    /// * coupling: the deviation of a coupled slider from its target
    /// * pulley: the excess of the path over the rope
    #[must_use]
    pub fn error(&self) -> f32 {
        if let Some([length, _]) = self.coupling_error() {
            return length;
        }
        self.joint.error(&self.tables.bodies)
    }

    /// Angular constraint error [rad]: the excess over the limits of the angular axes of a joint of
    /// six axes, or the deviation of a coupled hinge from its target angle. 0 for other joints.
    #[must_use]
    pub fn angular_error(&self) -> f32 {
        if let Some([_, angle]) = self.coupling_error() {
            return angle;
        }
        self.joint.angular_error(&self.tables.bodies)
    }
}

impl World {
    /// The same joint with its anchors and axes in the frames of its bodies, at their current
    /// poses. [`Self::add_joint`] converts world points and axes in this way.
    ///
    /// # Errors
    /// A field is out of range, or a body is not a body of this world.
    pub fn place_joint(&self, def: JointDef) -> Result<JointDef, DefError> {
        def.validate()?;
        let find = |name: &str, id: BodyId| {
            let body = self.body(id);
            body.ok_or_else(|| {
                DefError::missing(
                    name,
                    format_args!("BodyId {}", id.index()),
                    "a body of this world",
                )
            })
        };
        let (a, b) = (find("body_a", def.body_a)?, find("body_b", def.body_b)?);
        let mut placed = JointDef { world_anchors: false, world_axes: None, ..def };
        if let (Some(axes), JointKind::SixDof(six_dof)) = (&def.world_axes, def.kind) {
            let frame = axes.rotation()?;
            let [frame_a, frame_b] =
                [a, b].map(|body| (body.rotation().conjugate() * frame).normalized());
            placed.kind = JointKind::SixDof(SixDof { frame_a, frame_b, ..six_dof });
        }
        if def.world_anchors {
            let ends = [(a, def.anchor_a), (b, def.anchor_b)];
            let [at_a, at_b] =
                ends.map(|(body, point)| body.rotation().unrotate(point - body.position()));
            (placed.anchor_a, placed.anchor_b) = (at_a, at_b);
            position("anchor_a", at_a)?;
            position("anchor_b", at_b)?;
        }
        Ok(placed)
    }
}
