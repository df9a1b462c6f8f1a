//! The definition of a body that breaks when it is hit, and its validation.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::def::DefError;
use super::def::check::{above_zero, within};
use crate::base::double::DVec3;
use crate::base::limits;
use crate::base::random::Random;
use crate::geometry::cells::MAX_SITES;

/// Settings with which a body of one convex shape breaks into pieces when it is hit. It breaks at
/// the end of a step in which an impact exceeds one of the limits. The body is removed, its pieces
/// are added, and [`crate::events::Events::fractures`] reports it. The pieces are the Voronoi cells
/// of random points, denser near the hit. Together they have the body's mass, momentum and angular
/// momentum.
///
/// An impact is the impulse of one other body in a step, through all their contacts. The manual:
/// [breakage](crate::manual::breakage).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Fracture {
    /// Impulse of an impact above which it breaks [N s]; above 0; default infinite: the impulse
    /// does not count.
    pub impulse: f32,
    /// Energy of an impact above which it breaks [J]; above 0; default infinite. It is the kinetic
    /// energy that the impulse would give to the free body at rest. For a body that drops on its
    /// face, it is the kinetic energy at the impact.
    pub energy: f32,
    /// Maximum number of pieces; 2 to 1024; default 12.
    pub pieces: u32,
    /// Edge of the cube with the minimum volume of a piece [m]; above 0; default 0.02. A body with
    /// less than twice that volume does not break.
    pub min_size: f32,
    /// Concentration of the points near the hit. Each point is moved from a uniform position toward
    /// the hit by the product of this many random numbers; 0 (uniform) to 8; default 1.
    pub focus: u32,
    /// Number of generations that break, 1 to 16; default 1: pieces do not break again. The limits
    /// of a piece are proportional to its mass.
    pub generations: u32,
    /// Random seed for the points; any number.
    pub seed: u64,
}

impl Default for Fracture {
    fn default() -> Self {
        Self {
            impulse: f32::INFINITY,
            energy: f32::INFINITY,
            pieces: 12,
            min_size: 0.02,
            focus: 1,
            generations: 1,
            seed: 0,
        }
    }
}

impl Fracture {
    /// Breaks under an impact of more than this impulse [N s].
    #[must_use]
    pub fn by_impulse(impulse: f32) -> Self {
        Self { impulse, ..Self::default() }
    }

    /// Breaks under an impact of more than this energy [J].
    #[must_use]
    pub fn by_energy(energy: f32) -> Self {
        Self { energy, ..Self::default() }
    }

    /// With this maximum number of pieces.
    #[must_use]
    pub fn with_pieces(self, pieces: u32) -> Self {
        Self { pieces, ..self }
    }

    /// With this seed.
    #[must_use]
    pub fn with_seed(self, seed: u64) -> Self {
        Self { seed, ..self }
    }

    /// Checks every field.
    ///
    /// # Errors
    /// The first field that is out of range.
    pub fn validate(&self) -> Result<(), DefError> {
        for (name, value) in [("impulse", self.impulse), ("energy", self.energy)] {
            if value != f32::INFINITY {
                above_zero(name, value)?;
            }
        }
        within("min_size", self.min_size, &limits::LENGTH)?;
        let whole = |name: &str, value: u32, low: u32, high: u32| {
            if (low..=high).contains(&value) {
                return Ok(());
            }
            Err(DefError::new(name, value, &format!("a number from {low} to {high}")))
        };
        whole("pieces", self.pieces, 2, u32::try_from(MAX_SITES).unwrap_or(u32::MAX))?;
        whole("focus", self.focus, 0, 8)?;
        whole("generations", self.generations, 1, 16)
    }

    /// Minimum volume of a piece [m³].
    pub(crate) fn min_volume(&self) -> f64 {
        let size = f64::from(self.min_size);
        size * size * size
    }

    /// The settings of a piece with this fraction of the mass; `None` if pieces do not break again.
    pub(crate) fn of_piece(&self, part: f32, random: &mut Random) -> Option<Self> {
        let (impulse, energy) = (self.impulse * part, self.energy * part);
        let generations = self.generations.checked_sub(1).filter(|n| *n > 0)?;
        let next = Self { impulse, energy, generations, seed: random.next(), ..*self };
        next.validate().is_ok().then_some(next)
    }

    /// Random points near `hit` in the box with these corners [m] for which `inside` is true.
    pub(crate) fn sites(
        &self,
        hit: DVec3,
        [low, high]: [DVec3; 2],
        count: usize,
        random: &mut Random,
        inside: impl Fn(DVec3) -> bool,
    ) -> Vec<DVec3> {
        let near = 0.5 * f64::from(self.min_size);
        let mut sites: Vec<DVec3> = Vec::with_capacity(count);
        // A thin hull fills a small part of its box, and points of too small pieces are refused.
        // There may then be fewer points.
        for _ in 0..64 * count {
            if sites.len() == count {
                break;
            }
            let mut between = |a: f64, b: f64| a + (b - a) * random.unit();
            let far = DVec3 {
                x: between(low.x, high.x),
                y: between(low.y, high.y),
                z: between(low.z, high.z),
            };
            let part = (0..self.focus).fold(1.0, |part, _| part * random.unit());
            let site = hit + (far - hit) * part;
            if inside(far) && sites.iter().all(|s| (*s - site).length() > near) {
                sites.push(site);
            }
        }
        sites
    }
}
