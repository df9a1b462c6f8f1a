//! Work of an island's impulses in a sweep, and how much of it may be.

use crate::base::double::{DVec3, greater, lesser};

/// A sum of sizes in whole parts of a unit, the same in any order: that of constraints within a color is not to show.
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

/// Units in the work of an island: what is less does not matter to it, and 2⁶⁷ times as much is enough for all.
pub(super) const UNITS: f64 = (1_u64 << 60) as f64;

/// An island in a sweep.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Bound {
    /// Work of its impulses and energy before them [J].
    pub(super) work: f64,
    pub(super) energy: f64,
    /// Energy that it may have in any case: that of what has fallen for a step [J].
    pub(super) floor: f64,
    /// It was more than the ripple and the floor allow: what else allows it is summed up.
    pub(super) is_over: bool,
    /// Mass [kg], momentum, and moment of inertia [kg m²], the sum of all bodies'; the sums of m x and m x².
    pub(super) mass: f64,
    pub(super) first: DVec3,
    pub(super) second: f64,
    pub(super) momentum: DVec3,
    pub(super) inertia: f64,
    /// u·d and d·d.
    pub(super) along: f64,
    pub(super) square: f64,
    /// Units of the sums in a joule.
    pub(super) units: f64,
    /// Work of drives, springs and what moves by itself, at most.
    pub(super) driven: Sum,
    /// Work of what closes gaps, at most, and its greatest speeds [m/s, rad/s].
    pub(super) closed: Sum,
    pub(super) fastest: [f64; 2],
    /// What the impulses are multiplied by.
    pub(super) part: f64,
    /// It is not asked any more in this step: see [`super::bound`].
    pub(super) is_quiet: bool,
}

impl Bound {
    pub(super) fn drive(&mut self, impulse: impl Into<f64>, speed: f64) {
        self.driven.add(impulse.into() * speed * self.units);
    }

    /// An impulse of a spring that is off its place by `off`, on an axis of these speeds, before it and in the mean. It does no more
    /// work than its force does on the way of a substep, nor than it holds, wherever in the substep that is. `stiffness` counts by
    /// itself; `square` is that of its frequency, if it counts per effective mass, which is no more than `most`. No spring is taken
    /// for faster than a substep.
    pub(super) fn release(
        &mut self,
        impulse: f64,
        [before, mean]: [f64; 2],
        (stiffness, square, most): (f64, f64, f64),
        (off, inv_h): (f64, f64),
    ) {
        if impulse == 0.0 {
            return;
        }
        let stiffness = lesser(stiffness + square * most, inv_h * inv_h * most);
        let off = off.abs() + before / inv_h;
        let force = stiffness * off;
        let work = lesser(lesser(impulse.abs(), force / inv_h) * mean, 0.5 * force * off);
        self.driven.add(work * self.units);
    }

    /// The moment of inertia about its center, of all axes together [kg m²].
    pub(super) fn whole_inertia(&self) -> f64 {
        let spread = self.second - self.first.dot(self.first) / self.mass;
        self.inertia + greater(spread, 0.0)
    }

    /// An impulse of a row that closes at this speed; `kind` 0 of motions, 1 of turns. A row that gave none closes nothing:
    /// what its lane has of a limit may be that of another joint, before.
    pub(super) fn close(&mut self, impulse: f64, speed: f64, kind: usize) {
        if impulse == 0.0 {
            return;
        }
        self.closed.add(impulse * speed * self.units);
        self.fastest[kind] = greater(speed.abs(), self.fastest[kind]);
    }

    /// The part of the impulses that does the work that is allowed.
    pub(super) fn part(&self, ripple: f64) -> f64 {
        // What closes gaps may bring bodies to its speed, in the frame of their center, and no farther.
        let momentum = self.momentum;
        let own = self.energy - 0.5 * momentum.dot(momentum) / self.mass;
        let [v, w] = self.fastest;
        let reach = 0.5 * (self.mass * v * v + self.inertia * w * w);
        let [driven, closed] = [self.driven, self.closed].map(|sum| sum.get() / self.units);
        let closed = lesser(closed, greater(reach - own, 0.0));
        // Where impulses did many times the work that they can have done they are wrong, and so is what is asked of each.
        let can = driven + closed;
        let can = can * lesser(can / self.work, 1.0);
        let allowed = greater(ripple * self.energy + can, self.floor - self.energy);
        let Self { along, square, .. } = *self;
        let part = ((along * along + 2.0 * square * allowed).sqrt() - along) / square;
        if part.is_finite() { lesser(part, 1.0) } else { 0.0 }
    }
}
