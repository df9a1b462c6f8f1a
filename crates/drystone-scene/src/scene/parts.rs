//! The things that a scene lists: bodies, joints, couplings, frames and strands.

use drystone::articulation::TreeDef;
use drystone::breakage::JointStrength;
use drystone::joint::{JointAxis, SixDof};
use drystone::particle::{ClothDef, LinkKind, ParticleDef, RopeDef};
use drystone::{Axis, BodyDef, JointKind, Pose, Quat, Vec3};

/// A body of a scene.
#[derive(Clone, Debug)]
pub struct SceneBody {
    /// The scene's own name for it, in traces and reports; unique in its scene.
    pub name: String,
    /// The body with its shapes.
    pub def: BodyDef,
}

/// A joint of a scene.
#[derive(Clone, Debug)]
pub struct SceneJoint {
    /// The scene's own name for it; may be empty.
    pub name: String,
    /// Number of the first body in [`Scene::bodies`](super::Scene::bodies).
    pub body_a: usize,
    /// Number of the second body.
    pub body_b: usize,
    /// Anchor on the first body [m, its frame].
    pub anchor_a: Vec3,
    /// Anchor on the second body [m, its frame].
    pub anchor_b: Vec3,
    /// Its kind.
    pub kind: JointKind,
    /// Whether the two bodies collide.
    pub collide_connected: bool,
    /// The load it can bear; `None`: any load.
    pub strength: Option<JointStrength>,
    /// Whether the whole tree of joints is solved at once: see [`drystone::JointDef::articulated`].
    pub articulated: bool,
    /// Whether it acts from the start: see [`drystone::JointDef::enabled`].
    pub enabled: bool,
    /// Any number of the user's.
    pub user_data: u64,
}

/// Holds `coordinate b = ratio · coordinate a + offset` between two joints of six axes of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneCoupling {
    /// Number of the joint that is followed, in [`Scene::joints`](super::Scene::joints).
    pub joint_a: usize,
    /// Its axis.
    pub axis_a: Axis,
    /// Number of the joint that follows.
    pub joint_b: usize,
    /// Its axis.
    pub axis_b: Axis,
    /// How far b goes for each unit of a; not 0.
    pub ratio: f32,
    /// Where b is with a at 0 [m or rad].
    pub offset: f32,
}

/// A named place on a body, such as a link of a robot that is held fast on another.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneFrame {
    /// Its name, in traces; unique among bodies and frames of its scene.
    pub name: String,
    /// Number of the body in [`Scene::bodies`](super::Scene::bodies).
    pub body: usize,
    /// Where it is [frame of the body].
    pub pose: Pose,
    /// The point whose velocity is its own: the center of mass of the link it names [m, frame of
    /// the body].
    pub center: Vec3,
}

/// A particle of a strand that a body holds.
#[derive(Clone, Copy, Debug)]
pub struct SceneHold {
    /// Number of the particle in its strand.
    pub particle: usize,
    /// Number of the body in [`Scene::bodies`](super::Scene::bodies).
    pub body: usize,
    /// Where [m, frame of the body].
    pub point: Vec3,
}

/// A link between two particles of a strand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneLink {
    /// Number of the first particle in its strand.
    pub a: usize,
    /// Number of the second one.
    pub b: usize,
    /// Its kind.
    pub kind: LinkKind,
    /// Its length [m]; `None`: the distance of its particles.
    pub length: Option<f32>,
    /// See [`drystone::particle::LinkDef::tear_strain`].
    pub tear_strain: Option<f32>,
    /// See [`drystone::particle::LinkDef::tear_force`].
    pub tear_force: Option<f32>,
}

/// The kind of a strand.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum StrandDef {
    /// A rope.
    Rope(RopeDef),
    /// A cloth.
    Cloth(ClothDef),
    /// A particle at each of these points [m, world].
    Cloud(Vec<Vec3>, ParticleDef),
}

/// Particles of a scene. Only drystone has them: engines beside it are given the bodies alone.
#[derive(Clone, Debug)]
pub struct SceneStrand {
    /// The scene's own name for it.
    pub name: String,
    /// Its kind.
    pub def: StrandDef,
    /// Links between its particles, beside its own.
    pub links: Vec<SceneLink>,
    /// Numbers of its particles that are pinned where they are.
    pub pins: Vec<usize>,
    /// Its particles that bodies hold.
    pub holds: Vec<SceneHold>,
}

impl SceneStrand {
    /// A strand that nothing pins or holds.
    #[must_use]
    pub fn new(name: impl Into<String>, def: StrandDef) -> Self {
        let (pins, holds) = (Vec::new(), Vec::new());
        Self { name: name.into(), def, links: Vec::new(), pins, holds }
    }
}

impl SceneJoint {
    /// Whether it only keeps its bodies from colliding.
    #[must_use]
    pub fn holds_nothing(&self) -> bool {
        let is_free = |axes: &[JointAxis; 3]| axes.iter().all(|axis| *axis == JointAxis::FREE);
        match &self.kind {
            JointKind::SixDof(six) => {
                is_free(&six.linear) && is_free(&six.angular) && six.cone.is_none()
            }
            _ => false,
        }
    }

    /// A joint of two bodies, each with its number and anchor [m, its frame]: they do not collide,
    /// and it bears anything.
    #[must_use]
    pub fn new(a: (usize, Vec3), b: (usize, Vec3), kind: impl Into<JointKind>) -> Self {
        Self {
            name: String::new(),
            body_a: a.0,
            body_b: b.0,
            anchor_a: a.1,
            anchor_b: b.1,
            kind: kind.into(),
            collide_connected: false,
            strength: None,
            articulated: false,
            enabled: true,
            user_data: 0,
        }
    }

    /// A joint of six axes at a point, of bodies that stand so, with these frames [world].
    #[must_use]
    pub fn at(
        ends: [(usize, Pose); 2],
        point: Vec3,
        frames: [Quat; 2],
        axes: impl Into<SixDof>,
    ) -> Self {
        let [(a, at_a), (b, at_b)] = ends;
        let in_frame = |at: Pose, frame: Quat| (at.rotation.conjugate() * frame).normalized();
        let (frame_a, frame_b) = (in_frame(at_a, frames[0]), in_frame(at_b, frames[1]));
        let kind = JointKind::SixDof(SixDof { frame_a, frame_b, ..axes.into() });
        Self::new((a, at_a.local_point(point)), (b, at_b.local_point(point)), kind)
    }
}

/// A tree of bodies that may be an articulation.
#[derive(Clone, Debug, Default)]
pub struct SceneTree {
    /// Numbers of its bodies, in the order of its links.
    pub bodies: Vec<usize>,
    /// Its links and joints.
    pub def: TreeDef,
    /// Numbers of the joints that it replaces.
    pub joints: Vec<usize>,
    /// Numbers of the bodies between joints, which it does not need.
    pub between: Vec<usize>,
}
