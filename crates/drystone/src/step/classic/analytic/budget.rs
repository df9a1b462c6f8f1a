//! Limits the work of the analytic method in a step. If rounds, implicit slips and sweeps do not
//! converge, the method stops at the residual that it has then.

use crate::base::double::lesser;

/// Maximum multiplications of a step: some seconds. Piles of 60 bodies take a tenth of that in
/// their worst steps.
const MAX_WORK: f64 = 4.0e9;

/// Multiplications per point in a Newton step, in a function evaluation of its line search, and in
/// a sweep.
pub(crate) const POINT_SOLVE: f64 = 400.0;

pub(crate) const POINT_LOOK: f64 = 60.0;

pub(crate) const POINT_SWEEP: f64 = 120.0;

/// Work of a step, in multiplications. A step has many solves: one for each substep and each
/// alternation of contacts and joints. Each may use an even share of the work that the ones before
/// left.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Budget {
    /// In the step: remaining work, and number of remaining solves.
    left: f64,
    solves: u32,
    /// In this solve: maximum work, and the work so far.
    maximum: f64,
    work: f64,
    points: f64,
}

impl Budget {
    /// Begins a step with this number of solves.
    pub(crate) const fn of_step(solves: u32) -> Self {
        Self { left: MAX_WORK, solves, maximum: 0.0, work: 0.0, points: 0.0 }
    }

    /// Begins the next solve, with this number of points.
    pub(crate) fn begin(&mut self, points: usize) {
        self.left -= lesser(self.work, self.maximum);
        #[expect(clippy::cast_precision_loss, reason = "far below 2^52")]
        let points = points as f64;
        self.maximum = self.left / f64::from(self.solves.max(1));
        (self.solves, self.work, self.points) = (self.solves.saturating_sub(1), 0.0, points);
    }

    /// Counts multiplications, `each` per point plus `more`; false once the limit is exceeded.
    pub(crate) fn allows(&mut self, each: f64, more: f64) -> bool {
        self.work += each * self.points + more;
        self.work <= self.maximum
    }
}

#[cfg(test)]
mod tests {
    use super::{Budget, MAX_WORK};

    /// Work of a step that never converges, with this number of solves.
    fn work_of_a_step(solves: u32, each: f64) -> f64 {
        let mut budget = Budget::of_step(solves);
        let mut work = 0.0;
        for _ in 0..solves {
            budget.begin(10);
            while budget.allows(each, 0.0) {
                work += 10.0 * each;
            }
        }
        work
    }

    #[test]
    fn a_step_has_one_budget_however_many_solves_it_has() {
        let one = 1.0e-3 * MAX_WORK;
        for solves in [1, 2, 20, 256 * 20] {
            let work = work_of_a_step(solves, 0.1 * one);
            assert!(work <= MAX_WORK, "{solves}: {work}");
            // The unused work is less than one Newton step in each solve.
            assert!(work >= MAX_WORK - f64::from(solves) * one, "{solves}: {work}");
        }
    }

    #[test]
    fn what_a_solve_leaves_is_for_those_after_it() {
        let mut budget = Budget::of_step(2);
        budget.begin(1);
        assert!(budget.allows(0.1 * MAX_WORK, 0.0));
        budget.begin(1);
        assert!(budget.allows(0.89 * MAX_WORK, 0.0) && !budget.allows(0.02 * MAX_WORK, 0.0));
    }
}
