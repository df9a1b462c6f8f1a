//! Calls that change a world, as data: their arguments and their answers.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::base::id::{BodyId, JointId, LinkId, ParticleId, ShapeId};
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::base::quat::Quat;
use crate::geometry::shape::Shape;
use crate::state::coupling::CouplingDef;
use crate::state::def::axis::Axis;
use crate::state::def::config::WorldConfig;
use crate::state::def::material::{Filter, Material, SurfaceRule};
use crate::state::def::particle_def::{LinkDef, ParticleDef};
use crate::state::def::reports::{ContactReports, Senses};
use crate::state::def::six_dof::{JointAxis, JointDrive, JointMotion, JointSpring, SixDof};
use crate::state::def::{
    AxisLocks, BodyDef, BodyKind, BondStrength, Fracture, JointDef, JointKind, JointStrength,
    MassDef, Pulley, ShapeDef, Spring,
};
use crate::world::particle::strand::{ClothDef, RopeDef, Strand};

/// A call that changes a world, as data: it can be stored, sent, and made by
/// [`World::apply`](crate::World::apply). Its ids are those that the world returned.
///
/// Every call that affects later steps has a variant. The executor and the SIMD level have none
/// because they change no result. The ledger ([`World::begin_ledger`](crate::World::begin_ledger))
/// has none because it only reads.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub enum Call {
    /// [`World::step`](crate::World::step): the length [s].
    Step(f32),
    /// [`World::set_config`](crate::World::set_config).
    SetConfig(Box<WorldConfig>),
    /// [`World::set_gravity`](crate::World::set_gravity) [m/s², world].
    SetGravity(Vec3),
    /// [`World::wake_all`](crate::World::wake_all).
    WakeAll,
    /// [`World::add_body`](crate::World::add_body).
    AddBody(Box<BodyDef>),
    /// [`World::remove_body`](crate::World::remove_body).
    RemoveBody(BodyId),
    /// A call on a body.
    Body(BodyId, BodyCall),
    /// [`World::add_shape`](crate::World::add_shape).
    AddShape(BodyId, Box<ShapeDef>),
    /// [`World::remove_shape`](crate::World::remove_shape).
    RemoveShape(ShapeId),
    /// A call on a shape.
    Shape(ShapeId, ShapeCall),
    /// [`World::add_joint`](crate::World::add_joint).
    AddJoint(Box<JointDef>),
    /// [`World::add_coupling`](crate::World::add_coupling).
    AddCoupling(CouplingDef),
    /// [`World::remove_joint`](crate::World::remove_joint).
    RemoveJoint(JointId),
    /// A call on a joint or coupling.
    Joint(JointId, JointCall),
    /// [`World::add_particle`](crate::World::add_particle).
    AddParticle(Box<ParticleDef>),
    /// [`World::add_rope`](crate::World::add_rope).
    AddRope(Box<RopeDef>),
    /// [`World::add_cloth`](crate::World::add_cloth).
    AddCloth(Box<ClothDef>),
    /// [`World::add_cloud`](crate::World::add_cloud): the points [m, world].
    AddCloud(Vec<Vec3>, Box<ParticleDef>),
    /// [`World::remove_particle`](crate::World::remove_particle).
    RemoveParticle(ParticleId),
    /// A call on a particle.
    Particle(ParticleId, ParticleCall),
    /// [`World::add_link`](crate::World::add_link).
    AddLink(LinkDef),
    /// [`World::remove_link`](crate::World::remove_link).
    RemoveLink(LinkId),
    /// [`LinkMut::set_length`](crate::particle::LinkMut::set_length) [m].
    SetLinkLength(LinkId, f32),
    /// [`BodyMut::break_at`](crate::BodyMut::break_at): point of impact [m, world].
    BreakAt(BodyId, Vec3, Fracture),
    /// [`World::set_bodies_collide`](crate::World::set_bodies_collide).
    SetBodiesCollide(BodyId, BodyId, bool),
    /// [`World::shift_origin`](crate::World::shift_origin) [m, world].
    ShiftOrigin(Vec3),
    /// [`World::set_surface_rules`](crate::World::set_surface_rules).
    SetSurfaceRules(Vec<SurfaceRule>),
    /// [`World::set_surface_between`](crate::World::set_surface_between).
    SetSurfaceBetween(BodyId, BodyId, Option<SurfaceRule>),
}

/// A call on a body, of [`BodyMut`](crate::BodyMut): see [`Call::Body`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub enum BodyCall {
    /// [`BodyMut::wake`](crate::BodyMut::wake).
    Wake,
    /// [`BodyMut::sleep`](crate::BodyMut::sleep).
    Sleep,
    /// [`BodyMut::set_kind`](crate::BodyMut::set_kind).
    SetKind(BodyKind),
    /// [`BodyMut::set_mass`](crate::BodyMut::set_mass).
    SetMass(MassDef),
    /// [`BodyMut::set_enabled`](crate::BodyMut::set_enabled).
    SetEnabled(bool),
    /// [`BodyMut::set_pose`](crate::BodyMut::set_pose) [m, world].
    SetPose(Pose),
    /// [`BodyMut::set_linear_velocity`](crate::BodyMut::set_linear_velocity) [m/s, world].
    SetLinearVelocity(Vec3),
    /// [`BodyMut::set_angular_velocity`](crate::BodyMut::set_angular_velocity) [rad/s, world].
    SetAngularVelocity(Vec3),
    /// [`BodyMut::correct_state`](crate::BodyMut::correct_state): pose [m, world], linear and
    /// angular velocity [m/s, rad/s, world].
    CorrectState(Pose, Vec3, Vec3),
    /// [`BodyMut::move_to`](crate::BodyMut::move_to): pose [m, world], time [s].
    MoveTo(Pose, f32),
    /// [`BodyMut::apply_impulse`](crate::BodyMut::apply_impulse) [N s, world].
    ApplyImpulse(Vec3),
    /// [`BodyMut::apply_impulse_at`](crate::BodyMut::apply_impulse_at) a point [N s, m, world].
    ApplyImpulseAt(Vec3, Vec3),
    /// [`BodyMut::apply_angular_impulse`](crate::BodyMut::apply_angular_impulse) [N m s, world].
    ApplyAngularImpulse(Vec3),
    /// [`BodyMut::add_step_force`](crate::BodyMut::add_step_force) [N, world].
    AddStepForce(Vec3),
    /// [`BodyMut::add_step_force_at`](crate::BodyMut::add_step_force_at) a point [N, m, world].
    AddStepForceAt(Vec3, Vec3),
    /// [`BodyMut::add_step_torque`](crate::BodyMut::add_step_torque) [N m, world].
    AddStepTorque(Vec3),
    /// [`BodyMut::set_lasting_force`](crate::BodyMut::set_lasting_force) [N, world].
    SetLastingForce(Vec3),
    /// [`BodyMut::set_lasting_torque`](crate::BodyMut::set_lasting_torque) [N m, world].
    SetLastingTorque(Vec3),
    /// [`BodyMut::set_gravity_scale`](crate::BodyMut::set_gravity_scale).
    SetGravityScale(f32),
    /// [`BodyMut::set_damping`](crate::BodyMut::set_damping): linear, angular [1/s].
    SetDamping(f32, f32),
    /// [`BodyMut::set_locks`](crate::BodyMut::set_locks).
    SetLocks(AxisLocks),
    /// [`BodyMut::set_can_sleep`](crate::BodyMut::set_can_sleep).
    SetCanSleep(bool),
    /// [`BodyMut::set_sleep_speed`](crate::BodyMut::set_sleep_speed) [m/s].
    SetSleepSpeed(Option<f32>),
    /// [`BodyMut::set_fracture`](crate::BodyMut::set_fracture).
    SetFracture(Option<Fracture>),
    /// [`BodyMut::set_bond_strength`](crate::BodyMut::set_bond_strength).
    SetBondStrength(BondStrength),
    /// [`BodyMut::set_user_data`](crate::BodyMut::set_user_data).
    SetUserData(u64),
}

/// A call on a shape, of [`ShapeMut`](crate::ShapeMut): see [`Call::Shape`].
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub enum ShapeCall {
    /// [`ShapeMut::set_material`](crate::ShapeMut::set_material).
    SetMaterial(Material),
    /// [`ShapeMut::set_surface_velocity`](crate::ShapeMut::set_surface_velocity) [m/s, shape].
    SetSurfaceVelocity(Vec3),
    /// [`ShapeMut::set_surface_spin`](crate::ShapeMut::set_surface_spin) [rad/s, shape].
    SetSurfaceSpin(Vec3),
    /// [`ShapeMut::set_filter`](crate::ShapeMut::set_filter).
    SetFilter(Filter),
    /// [`ShapeMut::set_sensor`](crate::ShapeMut::set_sensor).
    SetSensor(bool),
    /// [`ShapeMut::set_density`](crate::ShapeMut::set_density) [kg/m³].
    SetDensity(f32),
    /// [`ShapeMut::set_local_pose`](crate::ShapeMut::set_local_pose) [m, frame of the body's
    /// origin].
    SetLocalPose(Pose),
    /// [`ShapeMut::set_geometry`](crate::ShapeMut::set_geometry).
    SetGeometry(Shape),
    /// [`ShapeMut::set_enabled`](crate::ShapeMut::set_enabled).
    SetEnabled(bool),
    /// [`ShapeMut::set_reports`](crate::ShapeMut::set_reports).
    SetReports(ContactReports),
    /// [`ShapeMut::set_senses`](crate::ShapeMut::set_senses).
    SetSenses(Senses),
    /// [`ShapeMut::set_hooks`](crate::ShapeMut::set_hooks).
    SetHooks(bool),
    /// [`ShapeMut::set_one_way`](crate::ShapeMut::set_one_way).
    SetOneWay(Option<Vec3>),
    /// [`ShapeMut::set_user_data`](crate::ShapeMut::set_user_data).
    SetUserData(u64),
}

/// A call on a joint or coupling: see [`Call::Joint`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub enum JointCall {
    /// [`JointMut::set_anchors`](crate::JointMut::set_anchors) [m, frame of the body's origin].
    SetAnchors(Vec3, Vec3),
    /// [`JointMut::set_frames`](crate::JointMut::set_frames).
    SetFrames(Quat, Quat),
    /// [`JointMut::set_kind`](crate::JointMut::set_kind).
    SetKind(Box<JointKind>),
    /// [`JointMut::set_lengths`](crate::JointMut::set_lengths) [m].
    SetLengths(f32, f32),
    /// [`JointMut::set_spring`](crate::JointMut::set_spring).
    SetSpring(Option<Spring>),
    /// [`JointMut::set_pulley`](crate::JointMut::set_pulley).
    SetPulley(Pulley),
    /// [`JointMut::set_coupling`](crate::JointMut::set_coupling): ratio and offset.
    SetCoupling(f32, f32),
    /// [`JointMut::set_axes`](crate::JointMut::set_axes).
    SetAxes(Box<SixDof>),
    /// A call on one axis of a joint of six axes; `None`: its one free axis.
    Axis(Option<Axis>, AxisCall),
    /// [`JointMut::set_target_rotation`](crate::JointMut::set_target_rotation): rotation, spring,
    /// maximum torque [N m].
    SetTargetRotation(Quat, JointSpring, f32),
    /// [`JointMut::set_strength`](crate::JointMut::set_strength).
    SetStrength(Option<JointStrength>),
    /// [`JointMut::set_articulated`](crate::JointMut::set_articulated).
    SetArticulated(bool),
    /// [`JointMut::set_collide_connected`](crate::JointMut::set_collide_connected).
    SetCollideConnected(bool),
    /// [`JointMut::set_enabled`](crate::JointMut::set_enabled).
    SetEnabled(bool),
    /// [`JointMut::set_user_data`](crate::JointMut::set_user_data).
    SetUserData(u64),
    /// [`JointMut::wake`](crate::JointMut::wake).
    Wake,
}

/// A call on an axis of a joint, of [`AxisMut`](crate::joint::AxisMut): see [`JointCall::Axis`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub enum AxisCall {
    /// [`AxisMut::set`](crate::joint::AxisMut::set).
    Set(JointAxis),
    /// [`AxisMut::set_motion`](crate::joint::AxisMut::set_motion).
    SetMotion(JointMotion),
    /// [`AxisMut::set_limits`](crate::joint::AxisMut::set_limits) [m; rad].
    SetLimits(f32, f32),
    /// [`AxisMut::set_drive`](crate::joint::AxisMut::set_drive).
    SetDrive(Option<JointDrive>),
    /// [`AxisMut::set_motor`](crate::joint::AxisMut::set_motor): speed [m/s; rad/s], maximum force
    /// [N; N m].
    SetMotor(f32, f32),
    /// [`AxisMut::set_servo`](crate::joint::AxisMut::set_servo): position [m; rad], spring, maximum
    /// force [N; N m].
    SetServo(f32, JointSpring, f32),
    /// [`AxisMut::set_friction`](crate::joint::AxisMut::set_friction) [N; N m].
    SetFriction(f32),
}

/// A call on a particle, of [`ParticleMut`](crate::particle::ParticleMut): see [`Call::Particle`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub enum ParticleCall {
    /// [`ParticleMut::set_position`](crate::particle::ParticleMut::set_position) [m, world].
    SetPosition(Vec3),
    /// [`ParticleMut::set_velocity`](crate::particle::ParticleMut::set_velocity) [m/s, world].
    SetVelocity(Vec3),
    /// [`ParticleMut::apply_impulse`](crate::particle::ParticleMut::apply_impulse) [N s, world].
    ApplyImpulse(Vec3),
    /// [`ParticleMut::set_mass`](crate::particle::ParticleMut::set_mass) [kg].
    SetMass(f32),
    /// [`ParticleMut::set_pinned`](crate::particle::ParticleMut::set_pinned).
    SetPinned(bool),
    /// [`ParticleMut::attach`](crate::particle::ParticleMut::attach): body, point [m, frame of the
    /// body's origin].
    Attach(BodyId, Vec3),
    /// [`ParticleMut::detach`](crate::particle::ParticleMut::detach).
    Detach,
}

/// The answer of a [`Call`].
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub enum Answer {
    /// The call succeeded.
    Done,
    /// The body, shape, joint, particle or link does not exist, or the call had no effect.
    Nothing,
    /// The id of a new body.
    Body(BodyId),
    /// The id of a new shape.
    Shape(ShapeId),
    /// The id of a new joint or coupling.
    Joint(JointId),
    /// The id of a new particle.
    Particle(ParticleId),
    /// The id of a new link.
    Link(LinkId),
    /// The ids of new particles and links.
    Strand(Strand),
    /// The new bodies that are the pieces of a broken body.
    Pieces(Vec<BodyId>),
}
