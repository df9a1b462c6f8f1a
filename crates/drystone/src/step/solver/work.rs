//! Work of an island's impulses in a sweep, and the maximum that is allowed.

use crate::base::double::{DVec3, greater, lesser};

/// A sum of magnitudes in integer units. It is the same in any order, so the order within a color
/// does not affect the result.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sum(i128);

impl Sum {
    #[expect(clippy::cast_possible_truncation, reason = "what is too large is as large as can be")]
    pub(super) fn add(&mut self, units: f64) {
        self.0 = self.0.saturating_add(units.abs() as i128);
    }

    #[expect(clippy::cast_precision_loss, reason = "a sum of f32")]
    pub(super) fn get(self) -> f64 {
        self.0 as f64
    }
}

/// Units in the work of an island. Smaller amounts do not matter, and 2⁶⁷ times that work is the
/// range.
pub(super) const UNITS: f64 = (1_u64 << 60) as f64;

/// Work and energy of an island in a sweep.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Bound {
    /// Work of its impulses, and energy before them [J].
    pub(super) work: f64,
    pub(super) energy: f64,
    /// Energy that the island may always have: that of a fall for one step [J].
    pub(super) floor: f64,
    /// The work exceeds ripple and floor, so the work of drives and closing gaps is summed.
    pub(super) is_over: bool,
    /// Mass [kg], momentum, and moment of inertia [kg m²], summed over all bodies; the sums of m x
    /// and m x².
    pub(super) mass: f64,
    pub(super) first: DVec3,
    pub(super) second: f64,
    pub(super) momentum: DVec3,
    pub(super) inertia: f64,
    /// u·d and d·d.
    pub(super) along: f64,
    pub(super) square: f64,
    /// Units of the sums per joule.
    pub(super) units: f64,
    /// Upper bound of the work of drives, springs and kinematic motion.
    pub(super) driven: Sum,
    /// Upper bound of the work of closing gaps, and their maximum speeds [m/s, rad/s].
    pub(super) closed: Sum,
    pub(super) fastest: [f64; 2],
    /// Factor on the impulses.
    pub(super) part: f64,
    /// The island is not checked again in this step: see [`super::bound`].
    pub(super) is_quiet: bool,
}

impl Bound {
    pub(super) fn drive(&mut self, impulse: impl Into<f64>, speed: f64) {
        self.driven.add(impulse.into() * speed * self.units);
    }

    /// Adds the work of a spring's impulse. `off` is the spring's deflection; the speeds are those
    /// of its axis before the impulse and in the mean. The work is at most the force times the
    /// displacement of a substep, and at most the energy that the spring stores anywhere in the
    /// substep. `stiffness` is absolute; `square` is the squared frequency where stiffness counts
    /// per effective mass, which is at most `maximum`. No spring counts as faster than a substep.
    pub(super) fn release(
        &mut self,
        impulse: f64,
        [before, mean]: [f64; 2],
        (stiffness, square, maximum): (f64, f64, f64),
        (off, inv_h): (f64, f64),
    ) {
        if impulse == 0.0 {
            return;
        }
        let stiffness = lesser(stiffness + square * maximum, inv_h * inv_h * maximum);
        let off = off.abs() + before / inv_h;
        let force = stiffness * off;
        let work = lesser(lesser(impulse.abs(), force / inv_h) * mean, 0.5 * force * off);
        self.driven.add(work * self.units);
    }

    /// Trace of the moment of inertia about the center of mass, of all bodies together [kg m²].
    pub(super) fn whole_inertia(&self) -> f64 {
        let spread = self.second - self.first.dot(self.first) / self.mass;
        self.inertia + greater(spread, 0.0)
    }

    /// Adds the work of an impulse that closes a gap at `speed`; `kind` is 0 for translation, 1 for
    /// rotation. A row without an impulse closes nothing: the limit in its lane may be left over
    /// from another joint.
    pub(super) fn close(&mut self, impulse: f64, speed: f64, kind: usize) {
        if impulse == 0.0 {
            return;
        }
        self.closed.add(impulse * speed * self.units);
        self.fastest[kind] = greater(speed.abs(), self.fastest[kind]);
    }

    /// The factor on the impulses at which they do the allowed work.
    pub(super) fn part(&self, ripple: f64) -> f64 {
        // Closing gaps may accelerate bodies up to the closing speed, relative to their center of
        // mass, and no more.
        let momentum = self.momentum;
        let own = self.energy - 0.5 * momentum.dot(momentum) / self.mass;
        let [v, w] = self.fastest;
        let reach = 0.5 * (self.mass * v * v + self.inertia * w * w);
        let [driven, closed] = [self.driven, self.closed].map(|sum| sum.get() / self.units);
        let closed = lesser(closed, greater(reach - own, 0.0));
        // Impulses that did many times the possible work are wrong, and so are the work estimates
        // based on them.
        let can = driven + closed;
        let can = can * lesser(can / self.work, 1.0);
        let allowed = greater(ripple * self.energy + can, self.floor - self.energy);
        let Self { along, square, .. } = *self;
        let part = ((along * along + 2.0 * square * allowed).sqrt() - along) / square;
        if part.is_finite() { lesser(part, 1.0) } else { 0.0 }
    }
}
