//! How much work the analytic method may do in a substep. Where rounds, slips as unknowns and sweeps circle without an end in
//! sight, it gives up with the residual that it has then.

/// Multiplications of a substep after which it gives up: some seconds. Piles of 60 bodies take a tenth of that in their
/// worst steps.
const MOST_WORK: f64 = 4.0e9;

/// Multiplications for a point in a step of Newton's method with its line search, and in a sweep.
pub(super) const POINT_SOLVE: f64 = 400.0;
pub(super) const POINT_SWEEP: f64 = 120.0;

/// What a substep has done, in multiplications.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Budget {
    points: f64,
    work: f64,
}

impl Budget {
    /// Nothing yet, of so many points.
    pub(super) const fn of(points: usize) -> Self {
        #[expect(clippy::cast_precision_loss, reason = "far below 2^52")]
        let points = points as f64;
        Self { points, work: 0.0 }
    }

    /// Counts multiplications for each point, and others; false when it is to give up.
    pub(super) fn allows(&mut self, each: f64, more: f64) -> bool {
        self.work += each * self.points + more;
        self.work <= MOST_WORK
    }
}
