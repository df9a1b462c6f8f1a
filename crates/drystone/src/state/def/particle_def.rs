//! Definitions of particles and their links, and their validation.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::DefError;
use super::check::{above_zero, at_least_zero, position, velocity, within};
use super::material::{Filter, Material};
use crate::base::id::ParticleId;
use crate::base::limits;
use crate::base::math::Vec3;

/// A point mass.
///
/// It has no shape and does not rotate. Its radius is the distance that its center keeps from the
/// shapes of bodies. Particles do not collide with each other. The manual:
/// [particles](crate::manual::particles).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct ParticleDef {
    /// Position [m, world]; default the origin.
    pub position: Vec3,
    /// Velocity [m/s, world]; default 0.
    pub velocity: Vec3,
    /// Mass [kg], 1e-9 to 1e9; default 0.01. A pinned particle counts as infinitely heavy.
    pub mass: f32,
    /// Distance that its center keeps from shapes [m], 1e-4 to 1e3; default 0.01.
    pub radius: f32,
    /// Whether it moves only at its own velocity, which only the user changes; default false.
    pub pinned: bool,
    /// Factor by which gravity acts on it; finite; default 1.
    pub gravity_scale: f32,
    /// Rate c at which its velocity decays [1/s]; at least 0; default 0. A substep multiplies the
    /// velocity by `1 / (1 + c h)`.
    pub damping: f32,
    /// Its surface. Only friction and restitution are used.
    pub material: Material,
    /// Its collision filter.
    pub filter: Filter,
}

impl Default for ParticleDef {
    fn default() -> Self {
        Self {
            position: Vec3::ZERO,
            velocity: Vec3::ZERO,
            mass: 0.01,
            radius: 0.01,
            pinned: false,
            gravity_scale: 1.0,
            damping: 0.0,
            material: Material::default(),
            filter: Filter::default(),
        }
    }
}

impl ParticleDef {
    /// A particle at a point [m, world].
    #[must_use]
    pub fn at(position: impl Into<Vec3>) -> Self {
        Self { position: position.into(), ..Self::default() }
    }

    /// With this mass [kg].
    #[must_use]
    pub fn with_mass(self, mass: f32) -> Self {
        Self { mass, ..self }
    }

    /// With this velocity [m/s, world].
    #[must_use]
    pub fn with_velocity(self, velocity: impl Into<Vec3>) -> Self {
        Self { velocity: velocity.into(), ..self }
    }

    /// With this radius [m].
    #[must_use]
    pub fn with_radius(self, radius: f32) -> Self {
        Self { radius, ..self }
    }

    /// Pinned at its position.
    #[must_use]
    pub fn pinned(self) -> Self {
        Self { pinned: true, ..self }
    }

    /// Checks every field.
    ///
    /// # Errors
    /// The first field that is out of range.
    pub fn validate(&self) -> Result<(), DefError> {
        position("position", self.position)?;
        velocity("velocity", self.velocity)?;
        check_mass(self.mass)?;
        if !(1.0e-4..=1.0e3).contains(&self.radius) {
            return Err(DefError::new("radius", self.radius, "a length from 1e-4 to 1e3 m"));
        }
        within("gravity_scale", self.gravity_scale, &limits::GRAVITY_SCALE)?;
        within("damping", self.damping, &limits::DAMPING)?;
        self.material.validate().map_err(|e| e.within("material"))
    }
}

/// Checks a mass. The inverse of an allowed mass, and the product of four of these, are normal
/// numbers.
pub(crate) fn check_mass(mass: f32) -> Result<(), DefError> {
    within("mass", mass, &limits::PARTICLE_MASS)
}

/// The law of a spring between two particles.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub enum LinkSpring {
    /// Stiffness and damping as rates.
    Rate {
        /// Force per stretch [N/m]; at least 0.
        stiffness: f32,
        /// Force per speed of lengthening [N s/m]; at least 0.
        damping: f32,
    },
    /// Frequency and damping ratio of the two masses on it: k = (2πf)² μ, c = 2ζ · 2πf μ, where 1/μ
    /// = 1/m_a + 1/m_b.
    Frequency {
        /// Undamped frequency [Hz]; at least 0.
        hertz: f32,
        /// Damping ratio; at least 0; 1 is critical.
        damping_ratio: f32,
    },
}

/// The kind of a link.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub enum LinkKind {
    /// A rod: the distance equals the length.
    Equal,
    /// A thread, which can go slack: the distance is at most the length.
    AtMost,
    /// A damped spring with this rest length, integrated implicitly.
    Spring(LinkSpring),
}

/// A distance constraint between two particles.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct LinkDef {
    /// First particle.
    pub a: ParticleId,
    /// Second particle; different from the first.
    pub b: ParticleId,
    /// Its kind.
    pub kind: LinkKind,
    /// Its length [m], 1e-5 to 1e7; `None` (the default): the distance when it is added.
    pub length: Option<f32>,
    /// Stretch, as a fraction of its length, above which it tears; above 0; default `None`: never.
    pub tear_strain: Option<f32>,
    /// Tension above which it tears [N]; above 0; default `None`: never.
    pub tear_force: Option<f32>,
}

impl LinkDef {
    /// A link of this kind, with the distance of its particles when it is added as its length.
    #[must_use]
    pub const fn new(a: ParticleId, b: ParticleId, kind: LinkKind) -> Self {
        Self { a, b, kind, length: None, tear_strain: None, tear_force: None }
    }

    /// With this length [m].
    #[must_use]
    pub const fn with_length(self, length: f32) -> Self {
        Self { length: Some(length), ..self }
    }

    pub(crate) fn validate(&self) -> Result<(), DefError> {
        if let Some(length) = self.length {
            check_length(length)?;
        }
        if let LinkKind::Spring(spring) = self.kind {
            check_spring(&spring)?;
        }
        for (field, value) in [("tear_strain", self.tear_strain), ("tear_force", self.tear_force)] {
            if let Some(value) = value {
                above_zero(field, value)?;
            }
        }
        Ok(())
    }
}

pub(crate) fn check_length(length: f32) -> Result<(), DefError> {
    within("length", length, &limits::LENGTH)
}

/// Maximum stiffness [N/m] and damping [N s/m] of a link. Products of larger values with masses and
/// times would not be normal numbers.
pub(crate) const MAX_RATE: f32 = 1.0e9;

pub(crate) fn check_spring(spring: &LinkSpring) -> Result<(), DefError> {
    let within = |field: &str, value: f32, maximum: f32| {
        at_least_zero(field, value)?;
        if value <= maximum {
            return Ok(());
        }
        Err(DefError::new(field, value, "at most 1e9, or 1e5 for a frequency"))
    };
    match *spring {
        LinkSpring::Rate { stiffness, damping } => {
            within("stiffness", stiffness, MAX_RATE)?;
            within("damping", damping, MAX_RATE)
        }
        LinkSpring::Frequency { hertz, damping_ratio } => {
            within("hertz", hertz, 1.0e5)?;
            within("damping_ratio", damping_ratio, 1.0e5)
        }
    }
}
