//! Links and the joints that hold them.

use drystone::geometry::MassProperties;
use drystone::joint::{JointDrive, JointSpring};
use drystone::{Pose, ShapeDef, Vec3};

use crate::read::xml::Element;

/// A link.
#[derive(Clone, Debug)]
pub(crate) struct Link<'a> {
    pub(crate) name: String,
    /// The element of the file that describes it.
    pub(crate) element: Element<'a>,
    /// Number of the link it hangs on, which is a lower one; `None` for the first.
    pub(crate) parent: Option<usize>,
    /// Where it is with its joints at rest [frame of the parent, or world].
    pub(crate) pose: Pose,
    pub(crate) hold: Hold,
    pub(crate) weight: Weight,
    /// Its shapes [its frame].
    pub(crate) shapes: Vec<ShapeDef>,
    /// Why the first of its shapes that are left out is.
    pub(crate) left_out: Option<String>,
    pub(crate) gravity_scale: f32,
}

/// The hold of a link on its parent.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Hold {
    /// It is the world itself, or held by it.
    World,
    /// Nothing lets it move.
    Fast,
    /// Nothing holds it.
    Free,
    /// It is moved by the user alone.
    Kinematic,
    /// These joints, one after the other from the parent on.
    Joints(Vec<Dof>),
}

/// The mass of a link, as far as the file gives it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Weight {
    /// All of it [frame of the link].
    Given(MassProperties),
    /// The file gives none: it weighs nothing, if the body it is part of has a mass.
    Unsaid,
}

/// A way to move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Way {
    /// About the axis.
    Hinge,
    /// Along the axis.
    Slide,
    /// About any axis.
    Ball,
    /// Across the axis and about it.
    Planar,
}

/// One joint of a link.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Dof {
    pub(crate) name: String,
    pub(crate) way: Way,
    /// Unit [frame of the link].
    pub(crate) axis: Vec3,
    /// A point of the axis [m, frame of the link].
    pub(crate) anchor: Vec3,
    /// Least and greatest coordinate, 0 at rest [m; rad].
    pub(crate) range: Option<[f32; 2]>,
    /// Spring and damper: its rest coordinate, stiffness and damping; all 0 without.
    pub(crate) spring: [f32; 3],
    /// Greatest force of dry friction [N; N m].
    pub(crate) friction: f32,
    /// Inertia of a rotor that turns with it [kg m²; kg]. Only reduced coordinates have it.
    pub(crate) armature: f32,
    /// The coordinate at rest as the file counts it, 0 unless the file gives another [m; rad].
    pub(crate) reference: f32,
}

impl Dof {
    /// A joint that moves freely.
    pub(crate) fn new(name: &str, way: Way, axis: Vec3, anchor: Vec3) -> Self {
        let name = name.to_owned();
        Self {
            name,
            way,
            axis,
            anchor,
            range: None,
            spring: [0.0; 3],
            friction: 0.0,
            armature: 0.0,
            reference: 0.0,
        }
    }

    /// Its spring and damper, for a coordinate that counts along `sign` times its own.
    pub(super) fn drive(&self, sign: f32) -> Option<JointDrive> {
        let [rest, stiffness, damping] = self.spring;
        let spring = JointSpring::new(stiffness, damping);
        let is_sprung = stiffness > 0.0 || damping > 0.0;
        is_sprung.then(|| JointDrive::servo(sign * rest, spring, f32::INFINITY))
    }
}
