//! Definitions of particles and their links, and how they are checked.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::check::{above_zero, at_least_zero, position, velocity, within};
use super::def::DefError;
use super::material::{Filter, Material};
use crate::base::id::ParticleId;
use crate::base::limits;
use crate::base::math::Vec3;

/// A point mass.
///
/// It has no shape and does not turn. Its radius is how far its center keeps from the shapes of bodies;
/// particles do not collide with each other. The manual: [particles](crate::manual::particles).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct ParticleDef {
    /// Where it is [m, world]; default the origin.
    pub position: Vec3,
    /// Its velocity [m/s, world]; default 0.
    pub velocity: Vec3,
    /// Mass [kg]; above 0; default 0.01. One that is pinned counts as infinitely heavy while it is.
    pub mass: f32,
    /// How far its center keeps from shapes [m]; 1e-4 to 1e3; default 0.01.
    pub radius: f32,
    /// Nothing moves it but its own velocity, which only the user changes; default false.
    pub pinned: bool,
    /// Factor to the world's gravity; finite; default 1.
    pub gravity_scale: f32,
    /// Rate at which its velocity decays [1/s]; at least 0; default 0. A substep takes the part
    /// `1 / (1 + c h)` of it.
    pub damping: f32,
    /// Its surface. Friction and restitution are read.
    pub material: Material,
    /// Which shapes it collides with.
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

    /// The same with this mass [kg].
    #[must_use]
    pub fn with_mass(self, mass: f32) -> Self {
        Self { mass, ..self }
    }

    /// The same with this velocity [m/s, world].
    #[must_use]
    pub fn with_velocity(self, velocity: impl Into<Vec3>) -> Self {
        Self { velocity: velocity.into(), ..self }
    }

    /// The same with this radius [m].
    #[must_use]
    pub fn with_radius(self, radius: f32) -> Self {
        Self { radius, ..self }
    }

    /// The same, pinned where it is.
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

/// Masses whose inverse, and products of four of which, are normal numbers.
pub(crate) fn check_mass(mass: f32) -> Result<(), DefError> {
    within("mass", mass, &limits::PARTICLE_MASS)
}

/// How stiff a spring between two particles is.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub enum LinkSpring {
    /// Force by length and by speed.
    Rate {
        /// Force for each meter of stretch [N/m]; at least 0.
        stiffness: f32,
        /// Force for each m/s of lengthening [N s/m]; at least 0.
        damping: f32,
    },
    /// What two such masses swing with: k = (2πf)² μ, c = 2ζ · 2πf μ, where 1/μ = 1/m_a + 1/m_b.
    Frequency {
        /// Undamped frequency [Hz]; at least 0.
        hertz: f32,
        /// Damping ratio; at least 0; 1 is critical.
        damping_ratio: f32,
    },
}

/// What a link does.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub enum LinkKind {
    /// The distance is this length: a rod.
    Equal,
    /// The distance is at most this length: a thread, which can go slack.
    AtMost,
    /// The distance is drawn to this length by a damped spring, integrated implicitly.
    Spring(LinkSpring),
}

/// A distance constraint between two particles.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct LinkDef {
    /// First particle.
    pub a: ParticleId,
    /// Second particle, another one.
    pub b: ParticleId,
    /// What it does.
    pub kind: LinkKind,
    /// Its length [m]; 1e-5 to 1e7; `None` (the default): the distance when it is added.
    pub length: Option<f32>,
    /// Tears when it is stretched by more than this part of its length; above 0; default `None`: never.
    pub tear_strain: Option<f32>,
    /// Tears when it pulls harder than this [N]; above 0; default `None`: never.
    pub tear_force: Option<f32>,
}

impl LinkDef {
    /// A link of this kind, as long as its particles are apart when it is added.
    #[must_use]
    pub const fn new(a: ParticleId, b: ParticleId, kind: LinkKind) -> Self {
        Self { a, b, kind, length: None, tear_strain: None, tear_force: None }
    }

    /// The same with this length [m].
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

/// The greatest stiffness [N/m] and damping [N s/m] of a link: beyond it their products with masses and times are no
/// normal numbers.
pub(crate) const MOST_RATE: f32 = 1.0e9;

pub(crate) fn check_spring(spring: &LinkSpring) -> Result<(), DefError> {
    let within = |field: &str, value: f32, most: f32| {
        at_least_zero(field, value)?;
        if value <= most {
            return Ok(());
        }
        Err(DefError::new(field, value, "at most 1e9, or 1e5 for a frequency"))
    };
    match *spring {
        LinkSpring::Rate { stiffness, damping } => {
            within("stiffness", stiffness, MOST_RATE)?;
            within("damping", damping, MOST_RATE)
        }
        LinkSpring::Frequency { hertz, damping_ratio } => {
            within("hertz", hertz, 1.0e5)?;
            within("damping_ratio", damping_ratio, 1.0e5)
        }
    }
}
