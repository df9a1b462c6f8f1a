//! Definitions of trees, and their checks.

use core::fmt::{Display, Formatter};

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

/// The kind of a joint, with the coordinates that it adds to `q` and `v`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub enum TreeJointKind {
    /// Rotation about an axis: an angle \[rad\]; one number in `q`, one in `v`.
    Hinge,
    /// Displacement along an axis \[m\]; one number in `q`, one in `v`.
    Slide,
    /// Rotation about a point: a unit quaternion (real part first), four numbers in `q`; angular
    /// velocity \[rad/s, link\], three in `v`.
    Ball,
    /// No restriction, of the first link only: position \[m, world\] and unit quaternion, seven
    /// numbers in `q`; velocity of the link's origin \[m/s, world\] and angular velocity
    /// \[rad/s, link\], six in `v`.
    Free,
}

/// A joint of a link. A link may have several: they act in their order, as if massless links were
/// between them. Three hinges on one link are three exact angles.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct TreeJoint {
    /// Kind of the joint.
    pub kind: TreeJointKind,
    /// A point that the joint does not move \[m, link\]; default 0.
    pub anchor: [f64; 3],
    /// Axis of a hinge or slide \[link\], of any length; default z.
    pub axis: [f64; 3],
    /// Coordinate at which the link has its defined pose \[rad or m\]; default 0.
    pub reference: f64,
    /// Lowest and highest coordinate \[rad or m\]; of a ball 0 and the largest angle. Default none.
    pub range: Option<[f64; 2]>,
    /// Inertia of a rotor that turns with the joint \[kg m² or kg\], at least 0; default 0.
    pub armature: f64,
    /// Force against the velocity \[N m s/rad or N s/m\], at least 0; default 0.
    pub damping: f64,
    /// Spring \[N m/rad or N/m\], at least 0; default 0.
    pub stiffness: f64,
    /// Coordinate at which the spring is relaxed \[rad or m\]; default 0. A ball's spring is
    /// relaxed at no rotation.
    pub rest: f64,
    /// Largest force of dry friction \[N m or N\], at least 0; default 0.
    pub friction: f64,
}

impl TreeJoint {
    /// A joint of this kind, with default values.
    #[must_use]
    pub const fn new(kind: TreeJointKind) -> Self {
        Self {
            kind,
            anchor: [0.0; 3],
            axis: [0.0, 0.0, 1.0],
            reference: 0.0,
            range: None,
            armature: 0.0,
            damping: 0.0,
            stiffness: 0.0,
            rest: 0.0,
            friction: 0.0,
        }
    }

    /// A hinge about `axis` \[link\].
    #[must_use]
    pub const fn hinge(axis: [f64; 3]) -> Self {
        Self { axis, ..Self::new(TreeJointKind::Hinge) }
    }

    /// A slide along `axis` \[link\].
    #[must_use]
    pub const fn slide(axis: [f64; 3]) -> Self {
        Self { axis, ..Self::new(TreeJointKind::Slide) }
    }

    /// A ball joint.
    #[must_use]
    pub const fn ball() -> Self {
        Self::new(TreeJointKind::Ball)
    }

    /// A free joint, for a floating first link.
    #[must_use]
    pub const fn free() -> Self {
        Self::new(TreeJointKind::Free)
    }

    /// Motion in the plane of two axes \[link\]: slides along them, then a hinge about the
    /// normal.
    #[must_use]
    pub fn planar(x: [f64; 3], y: [f64; 3]) -> Vec<Self> {
        let ([a, b, c], [d, e, f]) = (x, y);
        let normal = [b * f - c * e, c * d - a * f, a * e - b * d];
        vec![Self::slide(x), Self::slide(y), Self::hinge(normal)]
    }

    /// With the anchor \[m, link\].
    #[must_use]
    pub const fn with_anchor(self, anchor: [f64; 3]) -> Self {
        Self { anchor, ..self }
    }

    /// With limits \[rad or m\].
    #[must_use]
    pub const fn with_range(self, lowest: f64, highest: f64) -> Self {
        Self { range: Some([lowest, highest]), ..self }
    }

    /// With a rotor's inertia \[kg m² or kg\].
    #[must_use]
    pub const fn with_armature(self, armature: f64) -> Self {
        Self { armature, ..self }
    }

    /// With damping \[N m s/rad or N s/m\].
    #[must_use]
    pub const fn with_damping(self, damping: f64) -> Self {
        Self { damping, ..self }
    }

    /// With a spring \[N m/rad or N/m\] that is relaxed at `rest` \[rad or m\].
    #[must_use]
    pub const fn with_spring(self, stiffness: f64, rest: f64) -> Self {
        Self { stiffness, rest, ..self }
    }

    /// With dry friction \[N m or N\].
    #[must_use]
    pub const fn with_friction(self, friction: f64) -> Self {
        Self { friction, ..self }
    }
}

/// A link: a rigid body and the joints that connect it to its parent.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct LinkDef {
    /// Index of the parent, which comes before this link; `None` for the first link, whose parent
    /// is the world.
    pub parent: Option<usize>,
    /// Origin of the link at its joints' references \[m, parent\]; default 0.
    pub position: [f64; 3],
    /// Rotation of the link at its joints' references, a quaternion of any length, real part first
    /// \[parent\]; default none.
    pub rotation: [f64; 4],
    /// Joints from the parent to this link, in order; none fixes the link to its parent.
    pub joints: Vec<TreeJoint>,
    /// Mass \[kg\], at least 0; default 1.
    pub mass: f64,
    /// Center of mass \[m, link\]; default 0.
    pub center: [f64; 3],
    /// Inertia about the center of mass: xx, yy, zz, xy, xz, yz \[kg m², link\]; default that of a
    /// ball with a radius of 0.1 m.
    pub inertia: [f64; 6],
}

impl Default for LinkDef {
    fn default() -> Self {
        Self {
            parent: None,
            position: [0.0; 3],
            rotation: [1.0, 0.0, 0.0, 0.0],
            joints: Vec::new(),
            mass: 1.0,
            center: [0.0; 3],
            inertia: [0.004, 0.004, 0.004, 0.0, 0.0, 0.0],
        }
    }
}

impl LinkDef {
    /// A first link that floats freely.
    #[must_use]
    pub fn floating() -> Self {
        Self { joints: vec![TreeJoint::free()], ..Self::default() }
    }

    /// A link on the link `parent`, or on the world.
    #[must_use]
    pub fn on(parent: impl Into<Option<usize>>) -> Self {
        Self { parent: parent.into(), ..Self::default() }
    }

    /// With the origin at `position` \[m, parent\].
    #[must_use]
    pub const fn with_position(mut self, position: [f64; 3]) -> Self {
        self.position = position;
        self
    }

    /// With one more joint, after the others.
    #[must_use]
    pub fn with_joint(mut self, joint: TreeJoint) -> Self {
        self.joints.push(joint);
        self
    }

    /// With mass \[kg\], center of mass \[m, link\] and inertia about it (xx, yy, zz, xy, xz, yz)
    /// \[kg m², link\].
    #[must_use]
    pub const fn with_mass(mut self, mass: f64, center: [f64; 3], inertia: [f64; 6]) -> Self {
        self.mass = mass;
        self.center = center;
        self.inertia = inertia;
        self
    }
}

/// Stiffness of a constraint.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub enum RowSoftness {
    /// It holds exactly, as far as the sweeps converge.
    Rigid,
    /// A damped spring on the mass that the constraint moves.
    Spring {
        /// Frequency without damping \[Hz\], above 0.
        frequency: f64,
        /// Damping ratio, at least 0; 1 is critical.
        ratio: f64,
    },
}

/// A joint that follows another: its coordinate, less its reference, is a polynomial of the
/// leader's, less the leader's reference.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct TreeCoupling {
    /// Link and index of the joint that follows: a hinge or slide.
    pub follower: (usize, usize),
    /// Link and index of the joint that leads; `None` holds the follower at `polynomial[0]`.
    pub leader: Option<(usize, usize)>,
    /// Coefficients of the powers 0 to 4.
    pub polynomial: [f64; 5],
    /// Stiffness.
    pub softness: RowSoftness,
}

/// A tendon over joints: its length is a weighted sum of coordinates. By default it has no term and
/// no force.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct TreeTendon {
    /// Link and index of hinges and slides, with their weights.
    pub terms: Vec<((usize, usize), f64)>,
    /// Lowest and highest length, if limited.
    pub range: Option<[f64; 2]>,
    /// Spring, force over length, at least 0.
    pub stiffness: f64,
    /// Force over velocity, at least 0.
    pub damping: f64,
    /// Length at which the spring is relaxed.
    pub rest: f64,
    /// Largest force of dry friction, at least 0.
    pub friction: f64,
}

/// A closure of a loop: a point, or a whole frame, of two links stays together.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct TreeLoop {
    /// First link.
    pub link_a: usize,
    /// Second link; `None` is the world.
    pub link_b: Option<usize>,
    /// Point of the first link \[m, link a\].
    pub point_a: [f64; 3],
    /// Point of the second link \[m, link b\].
    pub point_b: [f64; 3],
    /// Rotation of link b in link a that is kept, a quaternion, real part first; `None` lets the
    /// links turn about the point.
    pub rotation: Option<[f64; 4]>,
    /// Stiffness.
    pub softness: RowSoftness,
}

impl TreeLoop {
    /// Holds a point of a link \[m, link a\] at a point of another, or of the world.
    #[must_use]
    pub const fn pin(
        link_a: usize,
        point_a: [f64; 3],
        link_b: Option<usize>,
        point_b: [f64; 3],
    ) -> Self {
        Self { link_a, link_b, point_a, point_b, rotation: None, softness: RowSoftness::Rigid }
    }

    /// Also holds the rotation of link b in link a.
    #[must_use]
    pub const fn with_rotation(mut self, rotation: [f64; 4]) -> Self {
        self.rotation = Some(rotation);
        self
    }
}

/// A tree of links, and what else its joints obey.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct TreeDef {
    /// Links; parents come before their children. Only the first has no parent.
    pub links: Vec<LinkDef>,
    /// Joints that follow others.
    pub couplings: Vec<TreeCoupling>,
    /// Tendons over joints.
    pub tendons: Vec<TreeTendon>,
    /// Closures of loops.
    pub loops: Vec<TreeLoop>,
}

/// The error of a refused definition or of a refused state: the place, the value, and the allowed
/// values.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TreeError {
    place: String,
    value: String,
    allowed: String,
}

impl TreeError {
    pub(super) fn new(place: impl Display, value: impl Display, allowed: &str) -> Self {
        Self { place: place.to_string(), value: value.to_string(), allowed: allowed.to_owned() }
    }

    /// The value, and the allowed values.
    pub(crate) fn told(&self) -> [&str; 2] {
        [&self.value, &self.allowed]
    }

    /// The field with its link, such as `links[2].mass`.
    #[must_use]
    pub fn place(&self) -> &str {
        &self.place
    }
}

impl Display for TreeError {
    fn fmt(&self, f: &mut Formatter<'_>) -> core::fmt::Result {
        write!(f, "{}: {}, allowed is {}", self.place, self.value, self.allowed)
    }
}

impl core::error::Error for TreeError {}
