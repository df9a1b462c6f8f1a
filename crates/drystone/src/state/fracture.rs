//! What a user says of a body that breaks where it is hit, and how it is checked.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::check::{above_zero, within};
use super::def::DefError;
use crate::base::double::DVec3;
use crate::base::limits;
use crate::base::random::Random;
use crate::geometry::cells::MOST_SITES;

/// A body of one convex shape breaks into pieces where it is hit, at the end of the step in which a blow
/// passes one of the limits: it is removed, its pieces are added, and [`crate::events::Events::fractures`] tells of it.
/// The pieces are the Voronoi cells of random points, denser near the hit; together they have the body's
/// mass, momentum and spin.
///
/// A blow is what one other body gave in a step through contacts. The manual: [breakage](crate::manual::breakage).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Fracture {
    /// Greatest impulse of a blow [N s]; above 0; default infinite: the impulse does not count.
    pub impulse: f32,
    /// Greatest energy of a blow [J]; above 0; default infinite. It is what the impulse would give to the body
    /// alone at rest: of one that drops on its face, what it had when it arrived.
    pub energy: f32,
    /// How many pieces it breaks into at most; 2 to 1024; default 12.
    pub pieces: u32,
    /// A piece has at least the volume of a cube of this edge [m]; above 0; default 0.02. Nor does a body
    /// break that has not twice as much.
    pub min_size: f32,
    /// How much denser points are near the hit: each is moved towards it from where it would be by the
    /// product of this many random numbers; 0 (evenly) to 8; default 1.
    pub focus: u32,
    /// How often pieces break again, 1 to 16: 1 (the default): not. The limits of a piece are in proportion to
    /// its mass.
    pub generations: u32,
    /// Chooses the points; any number.
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
    /// Breaks under a blow of more than this impulse [N s].
    #[must_use]
    pub fn by_impulse(impulse: f32) -> Self {
        Self { impulse, ..Self::default() }
    }

    /// Breaks under a blow of more than this energy [J].
    #[must_use]
    pub fn by_energy(energy: f32) -> Self {
        Self { energy, ..Self::default() }
    }

    /// Into at most so many pieces.
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
        whole("pieces", self.pieces, 2, u32::try_from(MOST_SITES).unwrap_or(u32::MAX))?;
        whole("focus", self.focus, 0, 8)?;
        whole("generations", self.generations, 1, 16)
    }

    /// Least volume of a piece [m³].
    pub(crate) fn least_volume(&self) -> f64 {
        let size = f64::from(self.min_size);
        size * size * size
    }

    /// That of a piece with this part of the mass; `None` if pieces do not break again.
    pub(crate) fn of_piece(&self, part: f32, random: &mut Random) -> Option<Self> {
        let (impulse, energy) = (self.impulse * part, self.energy * part);
        let generations = self.generations.checked_sub(1).filter(|n| *n > 0)?;
        let next = Self { impulse, energy, generations, seed: random.next(), ..*self };
        next.validate().is_ok().then_some(next)
    }

    /// Points about `hit` within the box of these corners [m], of those that `inside` lets through.
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
        // A thin hull fills little of its box, and where pieces would be too small points are refused: then
        // there are fewer.
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
            let way = (0..self.focus).fold(1.0, |way, _| way * random.unit());
            let site = hit + (far - hit) * way;
            if inside(far) && sites.iter().all(|s| (*s - site).length() > near) {
                sites.push(site);
            }
        }
        sites
    }
}
