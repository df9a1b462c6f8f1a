//! Operations on a world, as data: they can be generated from a seed, run, shrunk and written as
//! source.
//!
//! Objects are named by labels, not by ids: a label stays the same when other operations of the
//! program are removed. An operation on an object that was refused, or that no operation made, does
//! nothing.

use drystone::breakage::{BondStrength, Fracture, JointStrength};
use drystone::contact::SurfaceRule;
use drystone::events::{ContactReports, Senses};
use drystone::geometry::Aabb;
use drystone::impact::{ImpactBody, ImpactSurface};
use drystone::joint::{JointDrive, JointMotion, JointSpring, SixDof, Spring};
use drystone::particle::{ClothDef, LinkKind, ParticleDef, RopeDef};
use drystone::{
    Axis, AxisLocks, BodyDef, BodyKind, Filter, JointKind, MassDef, Material, Pose, Quat, Shape,
    ShapeDef, Vec3, WorldConfig,
};

/// Name of an object within a program.
pub type Label = u32;

/// First label of pieces of broken bodies, which are numbered in order of appearance.
pub const PIECES: Label = 1_000_000;

/// Geometry of a shape.
#[derive(Clone, Debug)]
pub enum Form {
    /// A shape that consists of numbers only.
    Plain(Shape),
    /// The hull of these points.
    Hull(Vec<Vec3>),
    /// A mesh.
    Mesh(Vec<Vec3>, Vec<[u32; 3]>),
}

/// Definition of a shape.
#[derive(Clone, Debug)]
pub struct ShapePlan {
    /// Label of the shape.
    pub label: Label,
    /// Geometry of the shape.
    pub form: Form,
    /// All other fields; its own shape is ignored.
    pub def: ShapeDef,
}

/// Definition of a body.
#[derive(Clone, Debug)]
pub struct BodyPlan {
    /// Label of the body.
    pub label: Label,
    /// All fields except the shapes.
    pub def: BodyDef,
    /// Its shapes.
    pub shapes: Vec<ShapePlan>,
    /// Glue on all shared faces of shapes: maximum gap [m] and strength.
    pub glue: Option<(f32, BondStrength)>,
}

/// Position of a joint.
#[derive(Clone, Copy, Debug)]
pub enum Place {
    /// At an anchor of each body [m, frame of the body].
    Anchors(Vec3, Vec3),
    /// At a point of the world, along an axis there [m, world]; for six-axis joints only.
    Along(Vec3, Vec3),
}

/// Definition of a joint.
#[derive(Clone, Debug)]
pub struct JointPlan {
    /// Label of the joint.
    pub label: Label,
    /// Its bodies.
    pub bodies: [Label; 2],
    /// Its position.
    pub place: Place,
    /// Its kind.
    pub kind: JointKind,
    /// Whether its bodies collide.
    pub collide_connected: bool,
    /// Its breaking strength.
    pub strength: Option<JointStrength>,
    /// Whether its tree is solved directly.
    pub articulated: bool,
    /// Whether it is enabled from the start.
    pub enabled: bool,
}

/// Definition of a coupling.
#[derive(Clone, Copy, Debug)]
pub struct CouplingPlan {
    /// Label of the coupling.
    pub label: Label,
    /// The joints.
    pub joints: [Label; 2],
    /// Their axes.
    pub axes: [Axis; 2],
    /// See [`drystone::joint::CouplingDef::ratio`].
    pub ratio: f32,
    /// See [`drystone::joint::CouplingDef::offset`].
    pub offset: f32,
}

/// Definition of a link.
#[derive(Clone, Copy, Debug)]
pub struct LinkPlan {
    /// Label of the link.
    pub label: Label,
    /// Its particles.
    pub ends: [Label; 2],
    /// Its kind.
    pub kind: LinkKind,
    /// Its length.
    pub length: Option<f32>,
    /// See [`drystone::particle::LinkDef::tear_strain`].
    pub tear_strain: Option<f32>,
    /// See [`drystone::particle::LinkDef::tear_force`].
    pub tear_force: Option<f32>,
}

/// A call of [`drystone::BodyMut`].
#[derive(Clone, Debug)]
pub enum BodyCall {
    /// `wake`.
    Wake,
    /// `set_pose`.
    Pose(Pose),
    /// `set_linear_velocity`.
    LinearVelocity(Vec3),
    /// `set_angular_velocity`.
    AngularVelocity(Vec3),
    /// `move_to`.
    MoveTo(Pose, f32),
    /// `apply_impulse`.
    Impulse(Vec3),
    /// `apply_impulse_at`.
    ImpulseAt(Vec3, Vec3),
    /// `apply_angular_impulse`.
    AngularImpulse(Vec3),
    /// `add_step_force`.
    StepForce(Vec3),
    /// `add_step_force_at`.
    StepForceAt(Vec3, Vec3),
    /// `add_step_torque`.
    StepTorque(Vec3),
    /// `set_lasting_force`.
    LastingForce(Vec3),
    /// `set_lasting_torque`.
    LastingTorque(Vec3),
    /// `set_gravity_scale`.
    GravityScale(f32),
    /// `set_damping`.
    Damping(f32, f32),
    /// `set_locks`.
    Locks(AxisLocks),
    /// `set_can_sleep`.
    CanSleep(bool),
    /// `set_user_data`.
    UserData(u64),
    /// `set_kind`.
    Kind(BodyKind),
    /// `set_mass`.
    Mass(MassDef),
    /// `set_enabled`.
    Enabled(bool),
    /// `sleep`.
    Sleep,
    /// `set_sleep_speed`.
    SleepSpeed(Option<f32>),
    /// `correct_state`.
    Correct(Pose, Vec3, Vec3),
}

/// A call of [`drystone::ShapeMut`].
#[derive(Clone, Debug)]
pub enum ShapeCall {
    /// `set_material`.
    Material(Material),
    /// `set_surface_velocity`.
    SurfaceVelocity(Vec3),
    /// `set_surface_spin`.
    SurfaceSpin(Vec3),
    /// `set_filter`.
    Filter(Filter),
    /// `set_sensor`.
    Sensor(bool),
    /// `set_density`.
    Density(f32),
    /// `set_local_pose`.
    LocalPose(Pose),
    /// `set_geometry`.
    Geometry(Form),
    /// `set_enabled`.
    Enabled(bool),
    /// `set_reports`.
    Reports(ContactReports),
    /// `set_senses`.
    Senses(Senses),
    /// `set_one_way`.
    OneWay(Option<Vec3>),
}

/// A change of a joint or a coupling.
#[derive(Clone, Debug)]
pub enum JointCall {
    /// `set_anchors`.
    Anchors(Vec3, Vec3),
    /// `set_frames`.
    Frames(Quat, Quat),
    /// `set_kind`.
    Kind(Box<JointKind>),
    /// `set_lengths`.
    Lengths(f32, f32),
    /// `set_spring`.
    Spring(Option<Spring>),
    /// `set_motion` of an axis.
    Motion(Axis, JointMotion),
    /// `set_limits`.
    Limits(f32, f32),
    /// `set_motor`.
    Motor(f32, f32),
    /// `set_friction`.
    Friction(f32),
    /// `set_target_rotation`.
    TargetRotation(Quat, JointSpring, f32),
    /// `set_coupling`.
    Coupling(f32, f32),
    /// `set_collide_connected`.
    CollideConnected(bool),
    /// `set_enabled`.
    Enabled(bool),
}

/// A call of [`drystone::particle::ParticleMut`].
#[derive(Clone, Debug)]
pub enum ParticleCall {
    /// `set_position`.
    Position(Vec3),
    /// `set_velocity`.
    Velocity(Vec3),
    /// `apply_impulse`.
    Impulse(Vec3),
    /// `set_mass`.
    Mass(f32),
    /// `set_pinned`.
    Pinned(bool),
}

/// A call of [`drystone::query::Query`].
#[derive(Clone, Debug)]
pub enum QueryCall {
    /// `cast_ray`.
    Ray(Vec3, Vec3, Filter),
    /// `overlap_bounds`.
    OverlapBounds(Aabb, Filter),
    /// `overlap_point`.
    OverlapPoint(Vec3, Filter),
    /// `overlap_shape`.
    OverlapShape(Form, Pose, Filter),
    /// `cast_shape`, with a displacement and a rotation.
    CastShape(Form, Pose, [Vec3; 2], Filter),
    /// `nearest_shape`.
    Nearest(Form, Pose, f32, Filter),
    /// Two shapes without a world: `Shape::closest_points` within a distance.
    Pair(Box<[(Form, Pose); 2]>, f32),
}

/// One operation of a program.
#[derive(Clone, Debug)]
pub enum Op {
    /// `add_body`.
    AddBody(Box<BodyPlan>),
    /// `add_shape`, to this body.
    AddShape(Label, Box<ShapePlan>),
    /// `remove_body`.
    RemoveBody(Label),
    /// `remove_shape`.
    RemoveShape(Label),
    /// `add_joint`.
    AddJoint(Box<JointPlan>),
    /// `remove_joint`.
    RemoveJoint(Label),
    /// `add_coupling`.
    AddCoupling(CouplingPlan),
    /// `set_axes` of a joint.
    SetJointAxes(Label, Box<SixDof>),
    /// `set_drive` of an axis of a joint.
    SetJointDrive(Label, Axis, Option<JointDrive>),
    /// `set_strength` of a joint.
    SetJointStrength(Label, Option<JointStrength>),
    /// A call on a joint.
    Joint(Label, JointCall),
    /// `add_particle`.
    AddParticle(Label, Box<ParticleDef>),
    /// `add_rope`; labels of its first particle and first link, the others follow.
    AddRope(Label, Label, Box<RopeDef>),
    /// `add_cloth`; labels as for a rope.
    AddCloth(Label, Label, Box<ClothDef>),
    /// `add_cloud`; label of its first particle.
    AddCloud(Label, Vec<Vec3>, Box<ParticleDef>),
    /// `remove_particle`.
    RemoveParticle(Label),
    /// `add_link`.
    AddLink(LinkPlan),
    /// `remove_link`.
    RemoveLink(Label),
    /// `LinkMut::set_length`.
    SetLinkLength(Label, f32),
    /// `ParticleMut::attach`, to a point of a body.
    Attach(Label, Label, Vec3),
    /// `detach_particle`.
    Detach(Label),
    /// A call on a body.
    Body(Label, BodyCall),
    /// A call on a shape.
    Shape(Label, ShapeCall),
    /// A call on a particle.
    Particle(Label, ParticleCall),
    /// `BodyMut::break_at`.
    FractureBody(Label, Vec3, Fracture),
    /// `BodyMut::set_fracture`.
    SetFracture(Label, Option<Fracture>),
    /// `BodyMut::set_bond_strength`.
    SetBondStrength(Label, BondStrength),
    /// `set_config`.
    SetConfig(Box<WorldConfig>),
    /// `set_gravity`.
    SetGravity(Vec3),
    /// `shift_origin`.
    ShiftOrigin(Vec3),
    /// `set_surface_between`.
    SurfaceBetween(Label, Label, Option<SurfaceRule>),
    /// `wake_all`.
    WakeAll,
    /// `begin_ledger`.
    BeginLedger,
    /// `end_ledger`.
    EndLedger,
    /// A query.
    Query(QueryCall),
    /// [`drystone::impact::impact`].
    Impact(Box<[ImpactBody; 2]>, ImpactSurface),
    /// Steps of this length [s], and their number.
    Step(f32, u32),
}

/// Style of the numbers in a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Style {
    /// 0.1 to 10 m, plausible masses, initially closed joints.
    Ordinary,
    /// Sizes of 0.01 to 100 m in one world.
    Wide,
    /// An ordinary world with some numbers at the bounds of their fields or beyond.
    Edge,
    /// Overlaps, unsatisfiable joints, extreme mass ratios.
    Torture,
}

impl Style {
    /// All styles.
    pub const ALL: [Self; 4] = [Self::Ordinary, Self::Wide, Self::Edge, Self::Torture];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ordinary => "ordinary",
            Self::Wide => "wide",
            Self::Edge => "edge",
            Self::Torture => "torture",
        }
    }
}

/// A world and the operations on it.
#[derive(Clone, Debug)]
pub struct Program {
    /// Style of its numbers.
    pub style: Style,
    /// Initial configuration.
    pub config: WorldConfig,
    /// Operations, in order.
    pub ops: Vec<Op>,
}

impl Program {
    /// Total number of steps.
    #[must_use]
    pub fn steps(&self) -> u32 {
        let steps = |op: &Op| if let Op::Step(_, count) = op { *count } else { 0 };
        self.ops.iter().map(steps).sum()
    }
}
