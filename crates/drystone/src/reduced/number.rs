//! Numbers of the tree algorithms: one `f32` or `f64`, or several of them side by side.
//!
//! All code of this module is written once, over [`Number`]. A lane goes through the same
//! operations in the same order as a lone number, and lanes never mix. So a tree in a lane has the
//! same bits as the tree alone. Branches that depend on values are selections lane by lane.

use core::fmt::Debug;
use core::ops::{Add, Div, Mul, Neg, Sub};

/// A number, or one number per lane. All operations are those of IEEE 754, lane by lane.
pub(crate) trait Number:
    Copy
    + Debug
    + PartialEq
    + Send
    + Sync
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + 'static
{
    /// Distance from 1 to the next larger number.
    const EPSILON: f64;
    /// π/2 in three parts; the first two have so few digits that small multiples are exact.
    const HALF_PI: [f64; 3];
    /// Number of terms of the series for sine and cosine.
    const TERMS: usize;
    /// Adding and subtracting this number rounds to an integer.
    const ROUNDER: f64;

    /// The same number in every lane, rounded to this precision.
    fn splat(value: f64) -> Self;
    /// The number of a lane; the lane must exist.
    fn lane(self, lane: usize) -> f64;
    /// This with one lane replaced.
    #[must_use]
    #[cfg_attr(not(test), expect(dead_code, reason = "the solver will take worlds in lanes"))]
    fn with_lane(self, lane: usize, value: f64) -> Self;
    /// Square root.
    #[must_use]
    fn sqrt(self) -> Self;
    /// In each lane: `then` if `self < bound`, else `otherwise`.
    #[must_use]
    fn if_less(self, bound: Self, then: Self, otherwise: Self) -> Self;
    /// Whether `self < bound` in any lane.
    fn any_less(self, bound: Self) -> bool;
    /// Whether all lanes have the same bits.
    fn same_bits(self, other: Self) -> bool;
    /// Angle of the point (x, y) with `self` as y [rad], −π to π.
    #[must_use]
    fn atan2(self, x: Self) -> Self;

    /// Zero in every lane.
    #[must_use]
    #[inline(always)]
    fn zero() -> Self {
        Self::splat(0.0)
    }

    /// One in every lane.
    #[must_use]
    #[inline(always)]
    fn one() -> Self {
        Self::splat(1.0)
    }

    /// The larger number in each lane; `other` if they do not compare.
    #[must_use]
    #[inline(always)]
    fn greater(self, other: Self) -> Self {
        other.if_less(self, self, other)
    }

    /// The smaller number in each lane; `other` if they do not compare.
    #[must_use]
    #[inline(always)]
    fn lesser(self, other: Self) -> Self {
        self.if_less(other, self, other)
    }

    /// Absolute value.
    #[must_use]
    #[inline(always)]
    fn abs(self) -> Self {
        self.if_less(Self::zero(), -self, self)
    }

    /// The nearest integer; for magnitudes below a quarter of [`Number::ROUNDER`].
    #[must_use]
    #[inline(always)]
    fn round(self) -> Self {
        let rounder = Self::splat(Self::ROUNDER);
        (self + rounder) - rounder
    }

    /// Sine and cosine of `self` [rad]. Exact to the last digits below 10⁴ rad.
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let k = (self * Self::splat(core::f64::consts::FRAC_2_PI)).round();
        let [p, q, r] = Self::HALF_PI.map(Self::splat);
        let x = ((self - k * p) - k * q) - k * r;
        let x2 = x * x;
        let (mut s, mut c) = (Self::zero(), Self::zero());
        for term in (0..Self::TERMS).rev() {
            s = s * x2 + Self::splat(SINE[term]);
            c = c * x2 + Self::splat(COSINE[term]);
        }
        let s = s * x;
        // The quarter of the circle is -2 to 2.
        let quarter = k - Self::splat(4.0) * (k * Self::splat(0.25)).round();
        let magnitude = quarter.abs();
        let (one, half) = (Self::one(), Self::splat(0.5));
        let odd = (magnitude - one).abs();
        let (sin, cos) = (odd.if_less(half, c, s), odd.if_less(half, s, c));
        let far = Self::splat(1.5);
        let sin = quarter.if_less(-half, -sin, far.if_less(quarter, -sin, sin));
        let cos = quarter.if_less(-far, -cos, half.if_less(quarter, -cos, cos));
        (sin, cos)
    }
}

/// (−1)ⁿ / (2n + 1)!
const SINE: [f64; 10] = series(1.0, 2.0);
/// (−1)ⁿ / (2n)!
const COSINE: [f64; 10] = series(1.0, 1.0);

/// The series 1, −1/(a(a+1)), 1/(a(a+1)(a+2)(a+3)) … with a = `second`.
const fn series(first: f64, second: f64) -> [f64; 10] {
    let mut terms = [first; 10];
    let mut factor = second;
    let mut n = 1;
    while n < 10 {
        terms[n] = -terms[n - 1] / (factor * (factor + 1.0));
        factor += 2.0;
        n += 1;
    }
    terms
}

impl Number for f64 {
    const EPSILON: f64 = f64::EPSILON;
    // 33 and 33 bits of π/2, and the rest.
    const HALF_PI: [f64; 3] =
        [1.570_796_326_734_125_6, 6.077_100_506_303_966e-11, 2.022_266_248_795_950_6e-21];
    const TERMS: usize = 10;
    // 1.5 · 2⁵²
    const ROUNDER: f64 = 6_755_399_441_055_744.0;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn lane(self, _lane: usize) -> f64 {
        self
    }
    #[inline(always)]
    fn with_lane(self, _lane: usize, value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }
    #[inline(always)]
    fn if_less(self, bound: Self, then: Self, otherwise: Self) -> Self {
        if self < bound { then } else { otherwise }
    }
    #[inline(always)]
    fn any_less(self, bound: Self) -> bool {
        self < bound
    }
    #[inline(always)]
    fn same_bits(self, other: Self) -> bool {
        self.to_bits() == other.to_bits()
    }
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        libm::atan2(self, x)
    }
}

impl Number for f32 {
    const EPSILON: f64 = 1.192_092_895_507_812_5e-7;
    // 8 and 11 bits of π/2, and the rest.
    const HALF_PI: [f64; 3] = [1.570_312_5, 4.837_512_969_970_703e-4, 7.549_789_954_891_88e-8];
    const TERMS: usize = 6;
    // 1.5 · 2²³
    const ROUNDER: f64 = 12_582_912.0;

    #[inline(always)]
    #[expect(clippy::cast_possible_truncation, reason = "rounding is the purpose")]
    fn splat(value: f64) -> Self {
        value as f32
    }
    #[inline(always)]
    fn lane(self, _lane: usize) -> f64 {
        f64::from(self)
    }
    #[inline(always)]
    fn with_lane(self, _lane: usize, value: f64) -> Self {
        Self::splat(value)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }
    #[inline(always)]
    fn if_less(self, bound: Self, then: Self, otherwise: Self) -> Self {
        if self < bound { then } else { otherwise }
    }
    #[inline(always)]
    fn any_less(self, bound: Self) -> bool {
        self < bound
    }
    #[inline(always)]
    fn same_bits(self, other: Self) -> bool {
        self.to_bits() == other.to_bits()
    }
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        libm::atan2f(self, x)
    }
}

/// `L` numbers side by side. The compiler makes vector instructions of the loops.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(align(32))]
pub(crate) struct Lanes<T, const L: usize>(pub(crate) [T; L]);

impl<T: Number, const L: usize> Lanes<T, L> {
    #[inline(always)]
    fn each(self, other: Self, operation: impl Fn(T, T) -> T) -> Self {
        let mut out = self;
        for lane in 0..L {
            out.0[lane] = operation(self.0[lane], other.0[lane]);
        }
        out
    }
}

impl<T: Number, const L: usize> Add for Lanes<T, L> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.each(other, |a, b| a + b)
    }
}

impl<T: Number, const L: usize> Sub for Lanes<T, L> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.each(other, |a, b| a - b)
    }
}

impl<T: Number, const L: usize> Mul for Lanes<T, L> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.each(other, |a, b| a * b)
    }
}

impl<T: Number, const L: usize> Div for Lanes<T, L> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.each(other, |a, b| a / b)
    }
}

impl<T: Number, const L: usize> Neg for Lanes<T, L> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|a| -a))
    }
}

impl<T: Number, const L: usize> Number for Lanes<T, L> {
    const EPSILON: f64 = T::EPSILON;
    const HALF_PI: [f64; 3] = T::HALF_PI;
    const TERMS: usize = T::TERMS;
    const ROUNDER: f64 = T::ROUNDER;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self([T::splat(value); L])
    }
    #[inline(always)]
    fn lane(self, lane: usize) -> f64 {
        self.0[lane].lane(0)
    }
    #[inline(always)]
    fn with_lane(mut self, lane: usize, value: f64) -> Self {
        self.0[lane] = T::splat(value);
        self
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(T::sqrt))
    }
    #[inline(always)]
    fn if_less(self, bound: Self, then: Self, otherwise: Self) -> Self {
        let mut out = otherwise;
        for lane in 0..L {
            out.0[lane] = self.0[lane].if_less(bound.0[lane], then.0[lane], otherwise.0[lane]);
        }
        out
    }
    #[inline(always)]
    fn any_less(self, bound: Self) -> bool {
        let mut any = false;
        for lane in 0..L {
            any |= self.0[lane].any_less(bound.0[lane]);
        }
        any
    }
    #[inline(always)]
    fn same_bits(self, other: Self) -> bool {
        self.0.iter().zip(other.0).all(|(a, b)| a.same_bits(b))
    }
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        self.each(x, T::atan2)
    }
}

#[cfg(test)]
mod tests {
    use super::{Lanes, Number};

    #[test]
    fn sine_and_cosine_are_exact_to_their_last_digits() {
        for i in -4000..4000 {
            let x = f64::from(i) * 0.0123 + 1.0e-3;
            let (s, c) = x.sin_cos();
            let (a, b) = Number::sin_cos(x);
            assert!((s - a).abs() < 4.0e-16 && (c - b).abs() < 4.0e-16, "{x}: {a} {b}");
            let y = f32::splat(x);
            let (a, b) = Number::sin_cos(y);
            let (s, c) = f64::from(y).sin_cos();
            let error = (f64::from(a) - s).abs().max((f64::from(b) - c).abs());
            assert!(error < 2.0e-7, "{x}: {error}");
        }
    }

    #[test]
    fn lane_has_the_bits_of_a_lone_number() {
        let x = Lanes::<f64, 4>([0.3, -7.7, 1.0e3, -0.0]);
        let (s, c) = x.sin_cos();
        for lane in 0..4 {
            let (a, b) = Number::sin_cos(x.0[lane]);
            assert_eq!((a.to_bits(), b.to_bits()), (s.0[lane].to_bits(), c.0[lane].to_bits()));
        }
    }
}
