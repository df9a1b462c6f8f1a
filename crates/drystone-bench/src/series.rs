//! Values per step, and the clock of the stages.

use std::time::{Duration, Instant};

use crate::row::Stages;

/// Values per step, with maximum, mean and percentiles.
#[derive(Clone, Debug, Default)]
pub struct Series {
    values: Vec<f64>,
}

impl Series {
    /// Adds a value.
    pub fn push(&mut self, value: f64) {
        self.values.push(value);
    }

    /// Number of values.
    #[must_use]
    pub fn len(&self) -> u64 {
        self.values.len() as u64
    }

    /// True if there are no values.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Their sum.
    #[must_use]
    pub fn sum(&self) -> f64 {
        self.values.iter().sum()
    }

    /// Their mean; 0 if there are none.
    #[must_use]
    pub fn mean(&self) -> f64 {
        if self.values.is_empty() { 0.0 } else { self.sum() / count_as_f64(self.values.len()) }
    }

    /// The largest value; 0 if there are none.
    #[must_use]
    pub fn max(&self) -> f64 {
        self.values.iter().copied().reduce(f64::max).unwrap_or(0.0)
    }

    /// The last value; 0 if there are none.
    #[must_use]
    pub fn last(&self) -> f64 {
        self.values.last().copied().unwrap_or(0.0)
    }

    /// The smallest value that at least `percent` in a hundred do not exceed; 0 if there are none.
    #[must_use]
    pub fn percentile(&self, percent: usize) -> f64 {
        let mut sorted = self.values.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        let rank = (sorted.len() * percent).div_ceil(100);
        sorted.get(rank.saturating_sub(1)).copied().unwrap_or(0.0)
    }
}

/// Converts a count, for divisions.
#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^52")]
#[must_use]
pub const fn count_as_f64(n: usize) -> f64 {
    n as f64
}

/// Times the stages of a step, because the engine has no clock.
#[derive(Debug)]
pub struct StageClock {
    totals: Vec<(&'static str, Duration)>,
    last: Instant,
}

impl Default for StageClock {
    fn default() -> Self {
        Self::new()
    }
}

impl StageClock {
    /// Makes a clock without measurements.
    #[must_use]
    pub fn new() -> Self {
        Self { totals: Vec::new(), last: Instant::now() }
    }

    /// Begins a step.
    pub fn begin(&mut self) {
        self.last = Instant::now();
    }

    /// Ends a stage.
    pub fn stage(&mut self, name: &'static str) {
        let now = Instant::now();
        self.add(name, now - self.last);
        self.last = now;
    }

    /// Adds the duration of a stage, from any clock.
    pub fn add(&mut self, name: &'static str, spent: Duration) {
        match self.totals.iter_mut().find(|(known, _)| *known == name) {
            Some((_, total)) => *total += spent,
            None => self.totals.push((name, spent)),
        }
    }

    /// Mean time of each stage over `steps` steps [ms], in the order of the step.
    #[must_use]
    pub fn means(&self, steps: u64) -> Vec<(&'static str, f64)> {
        let steps = count_as_f64(usize::try_from(steps.max(1)).unwrap_or(usize::MAX));
        self.totals.iter().map(|&(name, total)| (name, milliseconds(total) / steps)).collect()
    }

    /// The same times, in the form of a row.
    #[must_use]
    pub fn stages(&self, steps: u64) -> Stages {
        Stages(self.means(steps).into_iter().map(|(name, ms)| (name.to_owned(), ms)).collect())
    }
}

/// A duration in milliseconds.
#[must_use]
pub const fn milliseconds(duration: Duration) -> f64 {
    duration.as_secs_f64() * 1000.0
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
        assert_eq!((s.max(), s.mean(), s.last(), s.len()), (100.0, 50.5, 1.0, 100));
    }
}
