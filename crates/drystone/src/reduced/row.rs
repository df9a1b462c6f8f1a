//! Rows: constraints on the velocities of trees and free bodies, solved by sweeps.
//!
//! A row is J v ≥ target or J v = target, with an impulse λ in bounds. In whitened velocities
//! y = √D L v of a tree with the factor LᵀDL, the row is w = D^-½ L^-ᵀ Jᵀ: it is its own response,
//! because the impulse λ changes y by w λ. A free body is a tree of one link here: its six whitened
//! velocities are √m times its velocity and √I times its angular velocity. So a contact between a
//! tree and another tree, a body or the ground is a row of one or two segments in the same sweep.

use super::number::Number;

/// An impulse that stands for no bound.
const UNBOUNDED: f64 = 1.0e30;

/// A part of a row: a range of whitened velocities, and where its numbers begin.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Segment {
    pub(super) start: usize,
    pub(super) count: usize,
    pub(super) numbers: usize,
}

/// Bounds of a row's impulse.
#[derive(Clone, Copy, Debug)]
pub(super) enum Bound<N> {
    /// Equality.
    None,
    /// The impulse only pushes; in lanes where the second number is 0 the row is absent.
    Push(N),
    /// Between minus and plus this impulse.
    Box(N),
    /// Between minus and plus a coefficient times the impulse of the row with this index.
    #[cfg_attr(not(test), expect(dead_code, reason = "contacts come with the solver"))]
    Friction(usize, N),
}

/// A row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row<N> {
    pub(super) segments: [Segment; 2],
    pub(super) bound: Bound<N>,
    /// Velocity along the row at which it rests.
    pub(super) target: N,
    /// Compliance: the velocity that an impulse of 1 lets through, beyond the response.
    pub(super) compliance: N,
    /// 1/(w·w + compliance).
    pub(super) mass: N,
    pub(super) impulse: N,
    /// Separation or error of the row's coordinate when it was made.
    pub(super) gap: N,
    /// Whether the position pass corrects the gap.
    pub(super) corrects: bool,
    /// Whether it may store energy, as a spring.
    pub(super) soft: bool,
}

/// All rows of a set of trees and bodies.
#[derive(Clone, Debug)]
pub(super) struct Rows<N> {
    pub(super) rows: Vec<Row<N>>,
    pub(super) numbers: Vec<N>,
}

impl<N: Number> Rows<N> {
    pub(super) const fn new() -> Self {
        Self { rows: Vec::new(), numbers: Vec::new() }
    }

    pub(super) fn clear(&mut self) {
        self.rows.clear();
        self.numbers.clear();
    }

    /// Stores the whitened numbers of a segment that starts at the whitened velocity `start`.
    pub(super) fn segment(&mut self, start: usize, numbers: &[N]) -> Segment {
        let at = self.numbers.len();
        self.numbers.extend_from_slice(numbers);
        Segment { start, count: numbers.len(), numbers: at }
    }

    /// Adds a rigid row with the target 0, and gives it for changes.
    pub(super) fn add(&mut self, segments: [Segment; 2], bound: Bound<N>) -> &mut Row<N> {
        let square = segments.iter().fold(N::zero(), |sum, segment| {
            let numbers = &self.numbers[segment.numbers..segment.numbers + segment.count];
            numbers.iter().fold(sum, |sum, &w| sum + w * w)
        });
        let index = self.rows.len();
        self.rows.push(Row {
            segments,
            bound,
            target: N::zero(),
            compliance: N::zero(),
            mass: inverse(square),
            impulse: N::zero(),
            gap: N::zero(),
            corrects: false,
            soft: false,
        });
        &mut self.rows[index]
    }

    /// Velocity along a row.
    #[inline(always)]
    pub(super) fn velocity(&self, row: &Row<N>, y: &[N]) -> N {
        row.segments.iter().fold(N::zero(), |sum, s| {
            let numbers = &self.numbers[s.numbers..s.numbers + s.count];
            let part = &y[s.start..s.start + s.count];
            numbers.iter().zip(part).fold(sum, |sum, (&w, &y)| sum + w * y)
        })
    }

    /// Adds the impulses of all rows to the whitened velocities: the warm start.
    pub(super) fn apply(&self, y: &mut [N]) {
        for row in &self.rows {
            self.push(row, row.impulse, y);
        }
    }

    #[inline(always)]
    fn push(&self, row: &Row<N>, impulse: N, y: &mut [N]) {
        for s in &row.segments {
            let numbers = &self.numbers[s.numbers..s.numbers + s.count];
            for (y, &w) in y[s.start..s.start + s.count].iter_mut().zip(numbers) {
                // A lane without a change keeps its bits, even those of a negative zero.
                let step = w * impulse;
                *y = N::zero().if_less(step.abs(), *y + step, *y);
            }
        }
    }

    /// Work at the whitened velocities `y` of the rows that store no energy, at most 0 but for
    /// sweeps that have not converged; and of the others.
    pub(super) fn work(&self, y: &[N]) -> (N, N) {
        let mut sums = (N::zero(), N::zero());
        for row in &self.rows {
            let part = row.impulse * self.velocity(row, y);
            if row.soft {
                sums.1 = sums.1 + part;
            } else {
                sums.0 = sums.0 + part;
            }
        }
        sums
    }

    /// One sweep of projected Gauss-Seidel over the whitened velocities.
    pub(super) fn sweep(&mut self, y: &mut [N]) {
        for index in 0..self.rows.len() {
            let row = self.rows[index];
            let (low, high) = self.bounds(row.bound);
            let rest = row.target - self.velocity(&row, y) - row.compliance * row.impulse;
            let wanted = row.impulse + row.mass * rest;
            let impulse = wanted.greater(low).lesser(high);
            self.rows[index].impulse = impulse;
            self.push(&row, impulse - row.impulse, y);
        }
    }

    #[inline(always)]
    fn bounds(&self, bound: Bound<N>) -> (N, N) {
        let maximum = N::splat(UNBOUNDED);
        match bound {
            Bound::None => (-maximum, maximum),
            Bound::Push(present) => (N::zero(), present * maximum),
            Bound::Box(high) => (-high, high),
            Bound::Friction(normal, coefficient) => {
                let high = self.rows[normal].impulse * coefficient;
                (-high, high)
            }
        }
    }

    /// Makes of the rows those of a position pass: targets that close the gaps at bounded speed.
    ///
    /// `y` are the velocities after the sweeps, `ahead` the time from the gaps to the step's end,
    /// `h` the step and `speed` the recovery speed. Gives 1 in lanes with something to close.
    pub(super) fn aim_at_gaps(&mut self, y: &[N], ahead: N, h: N, speed: N) -> N {
        let mut any = N::zero();
        let (zero, one) = (N::zero(), N::one());
        for index in 0..self.rows.len() {
            let mut row = self.rows[index];
            row.impulse = zero;
            row.target = zero;
            if row.corrects {
                let gap = row.gap + ahead * self.velocity(&row, y);
                let depth = gap.abs();
                let maximum = (h * (speed + N::splat(10.0) * depth)).lesser(depth);
                let open = zero.if_less(gap, -maximum, maximum);
                let (target, wrong) = match row.bound {
                    Bound::Push(present) => {
                        // An open gap may close, but not beyond.
                        let target = gap.if_less(zero, maximum, -gap);
                        (target, gap.if_less(-N::splat(1.0e-9), present, zero))
                    }
                    _ => (open, N::splat(1.0e-12).if_less(depth, one, zero)),
                };
                row.target = target;
                any = any.greater(wrong);
            } else {
                row.bound = Bound::Box(zero);
            }
            self.rows[index] = row;
        }
        any
    }
}

/// 1/a where a > 0, else 0.
#[inline(always)]
fn inverse<N: Number>(a: N) -> N {
    let safe = N::zero().if_less(a, a, N::one());
    N::zero().if_less(a, N::one() / safe, N::zero())
}

impl<N: Number> Row<N> {
    /// Gives the row a compliance.
    pub(super) fn comply(&mut self, compliance: N) {
        let square = inverse(self.mass);
        self.compliance = compliance;
        self.mass = inverse(square + compliance);
    }

    /// Gives the row a compliance that stores energy.
    pub(super) fn soften(&mut self, compliance: N) {
        self.comply(compliance);
        self.soft = true;
    }

    /// Makes the row a spring k and damper d on the error `gap`, implicit over the step h.
    pub(super) fn spring(&mut self, k: N, d: N, gap: N, h: N) {
        let rate = d + h * k;
        self.soften(inverse(h * rate));
        self.target = -(gap * k * inverse(rate));
    }

    /// Makes the row a spring of a frequency [Hz] and damping ratio on the mass that it moves.
    pub(super) fn oscillate(&mut self, frequency: f64, ratio: f64, gap: N, h: N) {
        let angular = N::splat(core::f64::consts::TAU * frequency);
        let a = N::splat(2.0 * ratio) + h * angular;
        let square = inverse(self.mass);
        self.soften(square * inverse(h * angular * a));
        self.target = -(gap * angular * inverse(a));
    }
}
