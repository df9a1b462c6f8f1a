//! Joints that hold two points at a distance: rods, ropes, springs, pulleys.

use crate::base::limits;
use crate::state::def::{JointKind, Pulley, Spring};

/// Keeps the distance of the two anchors fixed, or between two lengths: a rod, optionally with a
/// spring.
///
/// ```
/// use drystone::joint::{Distance, Spring};
///
/// let rod = Distance::exact(0.8);
/// let strut = Distance::between(0.3, 0.5).with_spring(Spring::new(0.5, 3.0, 0.2));
/// # let _ = (rod, strut);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distance {
    /// Minimum distance [m]; at least 0.
    pub min: f32,
    /// Maximum distance [m]; at least `min`.
    pub max: f32,
    /// A spring toward a rest length, between the limits.
    pub spring: Option<Spring>,
}

impl Distance {
    /// A rod of this length [m].
    #[must_use]
    pub const fn exact(length: f32) -> Self {
        Self::between(length, length)
    }

    /// A joint that is free between two lengths [m].
    #[must_use]
    pub const fn between(min: f32, max: f32) -> Self {
        Self { min, max, spring: None }
    }

    /// With a spring between its limits.
    #[must_use]
    pub const fn with_spring(self, spring: Spring) -> Self {
        Self { spring: Some(spring), ..self }
    }
}

impl From<Distance> for JointKind {
    fn from(Distance { min, max, spring }: Distance) -> Self {
        Self::Distance { min, max, spring }
    }
}

/// Limits the distance of the two anchors to a length: a rope, which can go slack.
///
/// ```
/// use drystone::joint::Rope;
/// use drystone::{BodyId, JointDef};
///
/// fn moor(quay: BodyId, boat: BodyId) -> JointDef {
///     JointDef::new(quay, boat, Rope::new(6.0)).between([0.0, 1.0, 0.0], [4.0, 0.5, 0.0])
/// }
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rope {
    /// Its length [m]; at least 0.
    pub length: f32,
}

impl Rope {
    /// A rope of this length [m].
    #[must_use]
    pub const fn new(length: f32) -> Self {
        Self { length }
    }
}

impl From<Rope> for JointKind {
    fn from(rope: Rope) -> Self {
        Self::Distance { min: 0.0, max: rope.length, spring: None }
    }
}

impl From<Spring> for JointKind {
    /// A spring without limits of its length.
    fn from(spring: Spring) -> Self {
        Self::Distance { min: 0.0, max: limits::DISTANCE.maximum, spring: Some(spring) }
    }
}

impl From<Pulley> for JointKind {
    fn from(pulley: Pulley) -> Self {
        Self::Pulley(pulley)
    }
}
