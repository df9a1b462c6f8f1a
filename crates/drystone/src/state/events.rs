//! Events of the last step, in lists of a defined order.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::base::id::{BodyId, JointId, LinkId, ParticleId, ShapeId};
use crate::base::math::Vec3;

/// Two shapes began or ceased to touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct ContactEvent {
    /// First shape.
    pub shape_a: ShapeId,
    /// Second shape.
    pub shape_b: ShapeId,
    /// Body of the first shape.
    pub body_a: BodyId,
    /// Body of the second shape.
    pub body_b: BodyId,
}

/// Two shapes met at speed: they began to touch, or points landed that carried no impulse before.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct HitEvent {
    /// First shape.
    pub shape_a: ShapeId,
    /// Second shape.
    pub shape_b: ShapeId,
    /// Body of the first shape.
    pub body_a: BodyId,
    /// Body of the second shape.
    pub body_b: BodyId,
    /// Position [m, world]: in the middle between the surfaces as they were at the start of the
    /// step, so it is off the surface by up to half of their approach in the step.
    pub point: Vec3,
    /// Contact normal from A to B [world].
    pub normal: Vec3,
    /// Speed along the normal before the hit [m/s], of the fastest point; above 0.
    pub speed: f32,
    /// Impulse along the normals of the pair in the step of the hit [N s]. A part of it may follow
    /// in the next step, since the solver spreads an impact over a stack.
    pub impulse: f32,
}

/// Impulse and force between a pair of touching shapes in the step. See
/// [`ContactReports::forces`](crate::events::ContactReports::forces).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct ContactForce {
    /// First shape.
    pub shape_a: ShapeId,
    /// Second shape.
    pub shape_b: ShapeId,
    /// Body of the first shape.
    pub body_a: BodyId,
    /// Body of the second shape.
    pub body_b: BodyId,
    /// Impulse of the whole step on B, friction included [N s, world]; A got the opposite.
    pub impulse: Vec3,
    /// Part of the impulse along the normals, summed over the points [N s]; at least 0.
    pub normal_impulse: f32,
    /// Mean force of the step on B, friction included [N, world]: the impulse divided by the step.
    pub force: Vec3,
    /// Maximum force along the normal, as the mean over a substep [N]. For a mesh it is the sum
    /// over the pair's manifolds, whose maxima may be in different substeps. Shorter substeps show
    /// a higher peak of the same impact.
    pub greatest_force: f32,
    /// First of its points in [`Events::force_points`], and their number.
    pub(crate) points: [u32; 2],
}

impl ContactForce {
    /// Mean force of the step on this body [N, world]; 0 for a body outside the pair.
    #[must_use]
    pub fn force_on(&self, body: BodyId) -> Vec3 {
        let sign =
            f32::from(u8::from(self.body_b == body)) - f32::from(u8::from(self.body_a == body));
        self.force * sign
    }
}

/// A point of a [`ContactForce`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct ForcePoint {
    /// Position [m, world].
    pub position: Vec3,
    /// Contact normal from A to B [world].
    pub normal: Vec3,
    /// Impulse of the whole step along the normal [N s]; at least 0.
    pub impulse: f32,
    /// Maximum force along the normal, as the mean over a substep [N].
    pub greatest_force: f32,
}

/// A shape entered or left a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct SensorEvent {
    /// The sensor.
    pub sensor: ShapeId,
    /// The other shape.
    pub visitor: ShapeId,
    /// Body of the sensor.
    pub sensor_body: BodyId,
    /// Body of the other shape.
    pub visitor_body: BodyId,
}

/// A joint exceeded its strength, and was removed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct JointBreak {
    /// Its id, stale now.
    pub joint: JointId,
    /// Its first body.
    pub body_a: BodyId,
    /// Its second body.
    pub body_b: BodyId,
    /// The limit that it exceeded; if there were several, the first of them.
    pub limit: JointLimit,
    /// Force on the joint [N].
    pub force: f32,
    /// Torque [N m].
    pub torque: f32,
    /// Impulse of the step [N s].
    pub impulse: f32,
    /// Accumulated fatigue; at 1 the joint breaks.
    pub damage: f32,
}

/// The limit at which a joint broke.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub enum JointLimit {
    /// Maximum force.
    Force,
    /// Maximum torque.
    Torque,
    /// Maximum impulse in a step.
    Impulse,
    /// Fatigue.
    Fatigue,
}

/// A bond of a glued body broke.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct BondBreak {
    /// The body, by the id it had before.
    pub body: BodyId,
    /// The two shapes that it held together.
    pub shapes: [ShapeId; 2],
    /// Position of the bond [m, world].
    pub point: Vec3,
    /// Tension, including that of bending [Pa]; 0 under pressure.
    pub tension: f32,
    /// Shear, including that of twisting [Pa].
    pub shear: f32,
}

/// Cause of a fracture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub enum FractureCause {
    /// Its bonds broke: the body continues as the largest part, and the pieces are the others.
    Glue,
    /// The impulse of an impact was too large. The body was removed.
    Impulse,
    /// The energy of an impact was too large. The body was removed.
    Energy,
}

/// A body came apart.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct FractureEvent {
    /// The body; its id is stale now unless glue broke.
    pub body: BodyId,
    /// Cause of the fracture.
    pub cause: FractureCause,
    /// Position of the impact [m, world]; for glue: of the bond with the highest stress for its
    /// strength.
    pub point: Vec3,
    /// Impulse [N s] or energy [J] of the impact; for glue: stress over strength, 1 or more.
    pub value: f32,
    /// The limit that was exceeded; 1 for glue.
    pub limit: f32,
    /// First of its pieces in [`Events::pieces`], and their number.
    pub(crate) pieces: [u32; 2],
}

/// A link between two particles was stretched too far or pulled too hard, and was removed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct LinkTear {
    /// Its id, stale now.
    pub link: LinkId,
    /// Its first particle.
    pub a: ParticleId,
    /// Its second particle.
    pub b: ParticleId,
    /// Pull in the last substep [N]; below 0: it pushed.
    pub force: f32,
    /// Elongation, as a part of its length.
    pub strain: f32,
}

/// Kind of a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub enum FaultKind {
    /// The state of a body or a particle became infinite or NaN: it was put back to its last good
    /// pose, stopped, and takes no further part until the user sets its pose or velocity.
    NotFinite,
    /// The time step was not a finite number above 0: nothing was stepped.
    BadTimeStep,
    /// A value passed to this call before the step was not finite, out of range or unsuitable. The
    /// call changed nothing.
    Refused(FrameCall),
}

/// A call that a game makes in each frame, and that returns nothing: see [`FaultKind::Refused`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub enum FrameCall {
    /// [`BodyMut::set_pose`](crate::BodyMut::set_pose).
    SetPose,
    /// [`BodyMut::set_linear_velocity`](crate::BodyMut::set_linear_velocity).
    SetLinearVelocity,
    /// [`BodyMut::set_angular_velocity`](crate::BodyMut::set_angular_velocity).
    SetAngularVelocity,
    /// [`BodyMut::move_to`](crate::BodyMut::move_to).
    MoveTo,
    /// [`BodyMut::apply_impulse`](crate::BodyMut::apply_impulse).
    ApplyImpulse,
    /// [`BodyMut::apply_impulse_at`](crate::BodyMut::apply_impulse_at).
    ApplyImpulseAt,
    /// [`BodyMut::apply_angular_impulse`](crate::BodyMut::apply_angular_impulse).
    ApplyAngularImpulse,
    /// [`BodyMut::add_step_force`](crate::BodyMut::add_step_force).
    AddStepForce,
    /// [`BodyMut::add_step_force_at`](crate::BodyMut::add_step_force_at).
    AddStepForceAt,
    /// [`BodyMut::add_step_torque`](crate::BodyMut::add_step_torque).
    AddStepTorque,
    /// [`BodyMut::set_lasting_force`](crate::BodyMut::set_lasting_force).
    SetLastingForce,
    /// [`BodyMut::set_lasting_torque`](crate::BodyMut::set_lasting_torque).
    SetLastingTorque,
    /// [`BodyMut::set_gravity_scale`](crate::BodyMut::set_gravity_scale).
    SetGravityScale,
    /// [`BodyMut::set_damping`](crate::BodyMut::set_damping).
    SetDamping,
    /// [`ShapeMut::set_surface_velocity`](crate::ShapeMut::set_surface_velocity).
    SetSurfaceVelocity,
    /// [`ShapeMut::set_surface_spin`](crate::ShapeMut::set_surface_spin).
    SetSurfaceSpin,
    /// [`JointMut::set_motor`](crate::JointMut::set_motor), or its variant for one axis.
    SetMotor,
    /// [`JointMut::set_servo`](crate::JointMut::set_servo), or its variant for one axis.
    SetServo,
    /// [`JointMut::set_target_rotation`](crate::JointMut::set_target_rotation).
    SetTargetRotation,
    /// [`JointMut::set_lengths`](crate::JointMut::set_lengths).
    SetLengths,
    /// [`ParticleMut::set_position`](crate::particle::ParticleMut::set_position).
    SetParticlePosition,
    /// [`ParticleMut::set_velocity`](crate::particle::ParticleMut::set_velocity).
    SetParticleVelocity,
    /// [`ParticleMut::apply_impulse`](crate::particle::ParticleMut::apply_impulse).
    ApplyParticleImpulse,
    /// [`LinkMut::set_length`](crate::particle::LinkMut::set_length).
    SetLinkLength,
    /// [`World::set_gravity`](crate::World::set_gravity).
    SetGravity,
}

impl FrameCall {
    /// The call's name, such as `BodyMut::apply_impulse`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::SetPose => "BodyMut::set_pose",
            Self::SetLinearVelocity => "BodyMut::set_linear_velocity",
            Self::SetAngularVelocity => "BodyMut::set_angular_velocity",
            Self::MoveTo => "BodyMut::move_to",
            Self::ApplyImpulse => "BodyMut::apply_impulse",
            Self::ApplyImpulseAt => "BodyMut::apply_impulse_at",
            Self::ApplyAngularImpulse => "BodyMut::apply_angular_impulse",
            Self::AddStepForce => "BodyMut::add_step_force",
            Self::AddStepForceAt => "BodyMut::add_step_force_at",
            Self::AddStepTorque => "BodyMut::add_step_torque",
            Self::SetLastingForce => "BodyMut::set_lasting_force",
            Self::SetLastingTorque => "BodyMut::set_lasting_torque",
            Self::SetGravityScale => "BodyMut::set_gravity_scale",
            Self::SetDamping => "BodyMut::set_damping",
            Self::SetSurfaceVelocity => "ShapeMut::set_surface_velocity",
            Self::SetSurfaceSpin => "ShapeMut::set_surface_spin",
            Self::SetMotor => "JointMut::set_motor",
            Self::SetServo => "JointMut::set_servo",
            Self::SetTargetRotation => "JointMut::set_target_rotation",
            Self::SetLengths => "JointMut::set_lengths",
            Self::SetParticlePosition => "ParticleMut::set_position",
            Self::SetParticleVelocity => "ParticleMut::set_velocity",
            Self::ApplyParticleImpulse => "ParticleMut::apply_impulse",
            Self::SetLinkLength => "LinkMut::set_length",
            Self::SetGravity => "World::set_gravity",
        }
    }
}

/// A refused call, or a failure in a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct Fault {
    /// The body that it concerns, if any; for a call on a shape, its body.
    pub body: Option<BodyId>,
    /// The joint that it concerns, if any.
    pub joint: Option<JointId>,
    /// The particle that it concerns, if any; for a call on a link, its first one.
    pub particle: Option<ParticleId>,
    /// Kind of the fault.
    pub kind: FaultKind,
    /// Number of the step; the first is 1.
    pub step: u64,
}

/// Events of the last step; cleared when the next begins. Each list has a fixed order, the same for
/// any number of threads. The manual: [events](crate::manual::events).
#[derive(Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct Events {
    /// Shapes that began to touch: one pushed the other for the first time, if only in a part of
    /// the step. By the ids of both shapes.
    pub contact_begin: Vec<ContactEvent>,
    /// Shapes that ceased to touch, also by the removal of one. By the ids of both shapes.
    pub contact_end: Vec<ContactEvent>,
    /// Pairs that landed faster than their hit speed, see
    /// [`ContactReports`](crate::events::ContactReports): the shapes began to touch, or a part
    /// without impulse landed. One for each pair, by the ids of both shapes. A body that would pass
    /// another within the step is stopped there, and hits it in the next step.
    pub hits: Vec<HitEvent>,
    /// Impulses and forces of pairs with a shape that reports forces, by the ids of both shapes.
    /// Sleeping pairs have no entry.
    pub contact_forces: Vec<ContactForce>,
    /// Points of the contact forces, in the same order: see [`Self::points_of`].
    pub force_points: Vec<ForcePoint>,
    /// Shapes that entered a sensor, by sensor, then visitor.
    pub sensor_enter: Vec<SensorEvent>,
    /// Shapes that left a sensor, by sensor, then visitor.
    pub sensor_exit: Vec<SensorEvent>,
    /// Bodies that fell asleep, by id.
    pub sleep: Vec<BodyId>,
    /// Bodies that woke, by id.
    pub wake: Vec<BodyId>,
    /// Joints that broke and were removed, by joint.
    pub joint_break: Vec<JointBreak>,
    /// Links between particles that tore and were removed, by id.
    pub link_tear: Vec<LinkTear>,
    /// Particles whose attachment ended because its body was removed, by id.
    pub detached: Vec<ParticleId>,
    /// Bonds of glued bodies that broke, by body, then in the order in which they broke.
    pub bond_break: Vec<BondBreak>,
    /// Bodies that broke apart, by body; their pieces: [`Self::pieces_of`].
    pub fractures: Vec<FractureEvent>,
    /// New bodies made by fractures, in the order of `fractures`.
    pub pieces: Vec<BodyId>,
    /// Faults: refused calls in call order, then bodies, then particles, by id.
    pub faults: Vec<Fault>,
}

impl Clone for Events {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Reuses the existing lists.
    fn clone_from(&mut self, from: &Self) {
        let Self {
            contact_begin,
            contact_end,
            hits,
            contact_forces,
            force_points,
            sensor_enter,
            sensor_exit,
            sleep,
            wake,
            joint_break,
            link_tear,
            detached,
            bond_break,
            fractures,
            pieces,
            faults,
        } = from;
        self.contact_begin.clone_from(contact_begin);
        self.contact_end.clone_from(contact_end);
        self.hits.clone_from(hits);
        self.contact_forces.clone_from(contact_forces);
        self.force_points.clone_from(force_points);
        self.sensor_enter.clone_from(sensor_enter);
        self.sensor_exit.clone_from(sensor_exit);
        self.sleep.clone_from(sleep);
        self.wake.clone_from(wake);
        self.joint_break.clone_from(joint_break);
        self.link_tear.clone_from(link_tear);
        self.detached.clone_from(detached);
        self.bond_break.clone_from(bond_break);
        self.fractures.clone_from(fractures);
        self.pieces.clone_from(pieces);
        self.faults.clone_from(faults);
    }
}

impl Events {
    /// The new bodies that a body broke into, in the order in which they were made.
    #[must_use]
    pub fn pieces_of(&self, event: &FractureEvent) -> &[BodyId] {
        let [first, count] = event.pieces.map(|n| n as usize);
        self.pieces.get(first..first + count).unwrap_or_default()
    }

    /// The points of a pair, 1 to 4 for each of its manifolds; only pairs with a mesh have several.
    /// If a pair turns so far that its contacts are rebuilt within the step, some points may be
    /// missing; the impulse of the pair still includes them.
    #[must_use]
    pub fn points_of(&self, pair: &ContactForce) -> &[ForcePoint] {
        let [first, count] = pair.points.map(|n| n as usize);
        self.force_points.get(first..first + count).unwrap_or_default()
    }

    /// Mean force of the step by contacts on a body [N, world], over the pairs that report forces.
    /// For a body at rest on contacts alone it is the opposite of its weight.
    #[must_use]
    pub fn contact_force_on(&self, body: BodyId) -> Vec3 {
        self.contact_forces.iter().fold(Vec3::ZERO, |sum, pair| sum + pair.force_on(body))
    }

    /// Merges repeated wake and sleep calls between steps: keeps each body's net change, or no
    /// entry if there is none.
    pub(crate) fn settle_sleep(&mut self) {
        let Self { sleep, wake, .. } = self;
        if sleep.is_empty() {
            return;
        }
        sleep.sort_unstable();
        wake.sort_unstable();
        let count = |list: &[BodyId], body: BodyId| list.iter().filter(|b| **b == body).count();
        let all = sleep.clone();
        sleep.dedup();
        sleep.retain(|body| count(&all, *body) > count(wake, *body));
        let mut once = wake.clone();
        once.dedup();
        once.retain(|body| count(wake, *body) > count(&all, *body));
        *wake = once;
    }

    pub(crate) fn clear(&mut self) {
        self.contact_begin.clear();
        self.contact_end.clear();
        self.hits.clear();
        self.contact_forces.clear();
        self.force_points.clear();
        self.sensor_enter.clear();
        self.sensor_exit.clear();
        self.sleep.clear();
        self.wake.clear();
        self.joint_break.clear();
        self.link_tear.clear();
        self.detached.clear();
        self.bond_break.clear();
        self.fractures.clear();
        self.pieces.clear();
        self.faults.clear();
    }
}
