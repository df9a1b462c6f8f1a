//! Measurements of a run. They are taken between steps, outside the timed part, and always in full:
//! a report says the same whatever else was asked for.

use std::time::{Duration, Instant};

use drystone::{Fault, Vec3, World};

use crate::output::one_line;

/// Hashes are kept every so many steps.
const HASH_EVERY: u64 = 60;

/// Values of each step, for maximum, mean and percentiles.
#[derive(Clone, Debug, Default)]
pub(crate) struct Series {
    values: Vec<f64>,
}

impl Series {
    /// One more value.
    pub(crate) fn push(&mut self, value: f64) {
        self.values.push(value);
    }

    /// Their sum.
    pub(crate) fn sum(&self) -> f64 {
        self.values.iter().sum()
    }

    /// Their mean; 0 if there is none.
    pub(crate) fn mean(&self) -> f64 {
        if self.values.is_empty() { 0.0 } else { self.sum() / count_as_f64(self.values.len()) }
    }

    /// The largest; 0 if there is none.
    pub(crate) fn max(&self) -> f64 {
        self.values.iter().copied().reduce(f64::max).unwrap_or(0.0)
    }

    /// The last; 0 if there is none.
    pub(crate) fn last(&self) -> f64 {
        self.values.last().copied().unwrap_or(0.0)
    }

    /// The smallest value that at least `percent` in a hundred do not exceed; 0 if there is none.
    pub(crate) fn percentile(&self, percent: usize) -> f64 {
        let mut sorted = self.values.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        let rank = (sorted.len() * percent).div_ceil(100);
        sorted.get(rank.saturating_sub(1)).copied().unwrap_or(0.0)
    }
}

/// A count as a number to divide by.
#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^52")]
pub(crate) const fn count_as_f64(n: usize) -> f64 {
    n as f64
}

/// Takes the time of the stages of a step: the engine has no clock.
#[derive(Debug)]
pub(crate) struct StageClock {
    totals: Vec<(&'static str, Duration)>,
    last: Instant,
}

impl StageClock {
    /// Nothing measured yet.
    pub(crate) fn new() -> Self {
        Self { totals: Vec::new(), last: Instant::now() }
    }

    /// A step begins.
    pub(crate) fn begin(&mut self) {
        self.last = Instant::now();
    }

    /// A stage has ended.
    pub(crate) fn stage(&mut self, name: &'static str) {
        let now = Instant::now();
        let spent = now - self.last;
        self.last = now;
        match self.totals.iter_mut().find(|(known, _)| *known == name) {
            Some((_, total)) => *total += spent,
            None => self.totals.push((name, spent)),
        }
    }

    /// Mean time of each stage over `steps` steps [ms], in the order of the step.
    pub(crate) fn means(&self, steps: u64) -> Vec<(&'static str, f64)> {
        let steps = count_as_f64(usize::try_from(steps.max(1)).unwrap_or(usize::MAX));
        self.totals.iter().map(|&(name, total)| (name, milliseconds(total) / steps)).collect()
    }
}

/// A duration in milliseconds.
pub(crate) const fn milliseconds(duration: Duration) -> f64 {
    duration.as_secs_f64() * 1000.0
}

/// Mechanical energy [J].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Energy {
    /// Of motion.
    pub(crate) kinetic: f64,
    /// In the field of gravity, against the world's origin.
    pub(crate) potential: f64,
}

impl Energy {
    fn of(world: &World) -> Self {
        Self { kinetic: world.kinetic_energy(), potential: world.potential_energy() }
    }

    /// Both together.
    pub(crate) fn total(self) -> f64 {
        self.kinetic + self.potential
    }
}

/// What is measured of a run.
#[derive(Debug)]
pub(crate) struct Measure {
    /// Time of each step [ms].
    pub(crate) step_ms: Series,
    /// Pairs of shapes with contact points after each step.
    pub(crate) contacts: Series,
    /// The most of them after a step.
    pub(crate) contacts_max: usize,
    /// Deepest overlap after each step [m].
    pub(crate) penetration: Series,
    /// Largest joint error after each step [m].
    pub(crate) joint_error: Series,
    /// Energy at the start.
    pub(crate) energy_start: Energy,
    /// Energy after the last step.
    pub(crate) energy_end: Energy,
    /// Largest sum of kinetic and potential energy, the start included [J].
    pub(crate) energy_max: f64,
    momentum_start: Vec3,
    /// Step and state hash, every 60 steps.
    pub(crate) hashes: Vec<(u64, u64)>,
    /// What went wrong.
    pub(crate) faults: Vec<Fault>,
}

impl Measure {
    /// Of a run that starts from `world`.
    pub(crate) fn new(world: &World) -> Self {
        let energy = Energy::of(world);
        Self {
            step_ms: Series::default(),
            contacts: Series::default(),
            contacts_max: 0,
            penetration: Series::default(),
            joint_error: Series::default(),
            energy_start: energy,
            energy_end: energy,
            energy_max: energy.total(),
            momentum_start: world.momentum(),
            hashes: Vec::new(),
            faults: Vec::new(),
        }
    }

    /// Adds the state after step `step`, which took `spent`.
    pub(crate) fn add(&mut self, step: u64, spent: Duration, world: &World) {
        self.step_ms.push(milliseconds(spent));
        let (mut touching, mut deepest) = (0_usize, 0.0_f32);
        for contact in world.contacts() {
            touching += 1;
            deepest = contact.points().fold(deepest, |d, p| d.max(-p.separation));
        }
        self.contacts.push(count_as_f64(touching));
        self.contacts_max = self.contacts_max.max(touching);
        self.penetration.push(f64::from(deepest));
        let error = world.joints().fold(0.0_f32, |e, joint| e.max(joint.error()));
        self.joint_error.push(f64::from(error));
        self.energy_end = Energy::of(world);
        self.energy_max = self.energy_max.max(self.energy_end.total());
        if step.is_multiple_of(HASH_EVERY) {
            self.hashes.push((step, world.state_hash()));
        }
        self.faults.extend_from_slice(&world.events().faults);
    }

    /// How much the sum of momentum has changed since the start [kg m/s]. Gravity and static bodies
    /// change it too; where there is neither it should stay 0.
    pub(crate) fn momentum_drift(&self, world: &World) -> f32 {
        (world.momentum() - self.momentum_start).length()
    }
}

/// Notes of a scene, each in one line.
pub(crate) fn lines_of(notes: &[String]) -> Vec<String> {
    notes.iter().map(|note| one_line(note)).collect()
}

#[cfg(test)]
mod tests {
    use super::Series;

    #[test]
    fn percentiles_are_values_of_the_series() {
        let mut s = Series::default();
        assert!(s.percentile(50) == 0.0 && s.max() == 0.0 && s.mean() == 0.0);
        for i in 1..=100 {
            s.push(f64::from(101 - i));
        }
        assert_eq!((s.percentile(50), s.percentile(99), s.percentile(100)), (50.0, 99.0, 100.0));
        assert_eq!((s.max(), s.mean(), s.last()), (100.0, 50.5, 1.0));
    }
}
