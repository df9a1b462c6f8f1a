//! Numbers in f64: vectors, roots, integrals and fits for the closed forms and the measurements.

use drystone::{Quat, Vec3};

/// A vector.
pub(crate) type D3 = [f64; 3];

/// Converts a vector of the engine to f64.
#[must_use]
pub(crate) fn wide(v: Vec3) -> D3 {
    [f64::from(v.x), f64::from(v.y), f64::from(v.z)]
}

/// Rounds a number to the engine's precision.
#[must_use]
#[expect(clippy::cast_possible_truncation, reason = "the nearest f32 is what is wanted")]
pub(crate) const fn single(x: f64) -> f32 {
    x as f32
}

/// Rounds a vector to the engine's precision.
#[must_use]
pub(crate) const fn narrow(v: D3) -> Vec3 {
    drystone::vec3(single(v[0]), single(v[1]), single(v[2]))
}

/// Rounds a number that is an integer up to rounding, such as a number of steps.
#[must_use]
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the range")]
pub(crate) fn whole(x: f64) -> u64 {
    x.round().clamp(0.0, 1.0e15) as u64
}

/// a + b.
#[must_use]
pub(crate) fn add(a: D3, b: D3) -> D3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// a − b.
#[must_use]
pub(crate) fn sub(a: D3, b: D3) -> D3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// a s.
#[must_use]
pub(crate) fn scale(a: D3, s: f64) -> D3 {
    [a[0] * s, a[1] * s, a[2] * s]
}

/// a · b.
#[must_use]
pub(crate) fn dot(a: D3, b: D3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a × b.
#[must_use]
pub(crate) fn cross(a: D3, b: D3) -> D3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// |a|.
#[must_use]
pub(crate) fn norm(a: D3) -> f64 {
    dot(a, a).sqrt()
}

/// The larger of two errors; NaN counts as the largest.
#[must_use]
pub(crate) fn worst(a: f64, b: f64) -> f64 {
    if a.is_nan() || b <= a { a } else { b }
}

/// `v` rotated by `q`, which is normalized but not otherwise rounded.
#[must_use]
pub(crate) fn rotate(q: Quat, v: D3) -> D3 {
    let u = [f64::from(q.x), f64::from(q.y), f64::from(q.z)];
    let s = f64::from(q.w);
    let n = dot(u, u) + s * s;
    let turned = add(
        add(scale(u, 2.0 * dot(u, v)), scale(v, s * s - dot(u, u))),
        scale(cross(u, v), 2.0 * s),
    );
    scale(turned, 1.0 / n)
}

/// `v` rotated by the inverse of `q`.
#[must_use]
pub(crate) fn unrotate(q: Quat, v: D3) -> D3 {
    rotate(Quat::new(-q.x, -q.y, -q.z, q.w), v)
}

/// The rotation by `angle` [rad] about a unit `axis`, computed in f64.
#[must_use]
pub(crate) fn turn(axis: D3, angle: f64) -> Quat {
    let (s, c) = (0.5 * angle).sin_cos();
    Quat::new(single(axis[0] * s), single(axis[1] * s), single(axis[2] * s), single(c))
}

/// The angle between two rotations [rad].
#[must_use]
pub(crate) fn angle_between(p: Quat, q: Quat) -> f64 {
    // The vector part of p⁻¹ q: unlike the scalar part it resolves small angles.
    let (a, b) = (
        [f64::from(p.x), f64::from(p.y), f64::from(p.z)],
        [f64::from(q.x), f64::from(q.y), f64::from(q.z)],
    );
    let (s, t) = (f64::from(p.w), f64::from(q.w));
    let v = sub(sub(scale(b, s), scale(a, t)), cross(a, b));
    2.0 * norm(v).atan2((s * t + dot(a, b)).abs())
}

/// Complete elliptic integral of the first kind K(m), parameter m = k², by the arithmetic-geometric
/// mean.
#[must_use]
pub(crate) fn elliptic_k(m: f64) -> f64 {
    let (mut a, mut b) = (1.0_f64, (1.0 - m).sqrt());
    for _ in 0..40 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    core::f64::consts::FRAC_PI_2 / a
}

/// The root of `f` between `low` and `high`, where `f` changes sign, by bisection.
pub(crate) fn root(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let rising = f(high) > 0.0;
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if (f(middle) > 0.0) == rising {
            high = middle;
        } else {
            low = middle;
        }
    }
    0.5 * (low + high)
}

/// One step of the classical Runge-Kutta method of order 4.
pub(crate) fn runge_kutta<const N: usize>(
    x: &[f64; N],
    h: f64,
    f: impl Fn(&[f64; N]) -> [f64; N],
) -> [f64; N] {
    let along = |k: &[f64; N], s: f64| core::array::from_fn(|i| x[i] + s * k[i]);
    let k1 = f(x);
    let k2 = f(&along(&k1, 0.5 * h));
    let k3 = f(&along(&k2, 0.5 * h));
    let k4 = f(&along(&k3, h));
    core::array::from_fn(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]))
}

/// Collects the zero crossings of a value that is sampled at step ends.
#[derive(Clone, Debug, Default)]
pub(crate) struct Crossings {
    last: Option<(f64, f64)>,
    /// Times of the crossings, interpolated linearly between two samples, and whether the value
    /// rose.
    pub(crate) times: Vec<(f64, bool)>,
}

impl Crossings {
    /// Adds a sample.
    pub(crate) fn read(&mut self, time: f64, value: f64) {
        if let Some((t, v)) = self.last
            && v != 0.0
            && (v < 0.0) != (value < 0.0)
        {
            self.times.push((t + (time - t) * v / (v - value), value > v));
        }
        self.last = Some((time, value));
    }

    /// Mean time between rising crossings; NaN if there are fewer than two.
    #[must_use]
    pub(crate) fn period(&self) -> f64 {
        let rises: Vec<f64> = self.times.iter().filter(|(_, up)| *up).map(|(t, _)| *t).collect();
        match rises[..] {
            [first, .., last] => (last - first) / (rises.len() - 1) as f64,
            _ => f64::NAN,
        }
    }
}

/// Tracks a height and keeps its first maximum after it has fallen, the apex of the first bounce. A
/// parabola through the three nearest samples interpolates it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FirstApex {
    last: [f64; 2],
    count: u64,
    fell: bool,
    rose: bool,
    apex: Option<f64>,
}

impl FirstApex {
    /// Adds a sample of the height.
    pub(crate) fn read(&mut self, y: f64) {
        let [a, b] = self.last;
        if self.count >= 2 && self.apex.is_none() {
            self.fell |= b < a;
            self.rose |= self.fell && y > b;
            if self.rose && b >= a && y < b {
                let curve = a - 2.0 * b + y;
                let slope = y - a;
                self.apex = Some(b - slope * slope / (8.0 * curve));
            }
        }
        self.last = [b, y];
        self.count += 1;
    }

    /// The apex, if there was one.
    #[must_use]
    pub(crate) const fn apex(&self) -> Option<f64> {
        self.apex
    }
}

/// Tracks a slip speed that falls linearly, and extrapolates the time when it reaches zero.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SlipEnd {
    readings: [(f64, f64); 2],
    count: u64,
}

impl SlipEnd {
    /// Adds a sample while there is slip. The first sample is kept apart from the last, so that the
    /// line is as long as the slip lasts.
    pub(crate) fn read(&mut self, time: f64, slip: f64) {
        let at = usize::from(self.count > 0);
        self.readings[at] = (time, slip);
        self.count += 1;
    }

    /// Time when the line through the first and the last sample reaches zero; NaN with fewer than
    /// two.
    #[must_use]
    pub(crate) fn time(&self) -> f64 {
        let [(t, s), (u, r)] = self.readings;
        if self.count < 2 { f64::NAN } else { t + (u - t) * s / (s - r) }
    }
}

/// A small random number generator (`xorshift64*`), which gives the same scene on every machine.
#[derive(Clone, Debug)]
pub(crate) struct Random(u64);

impl Random {
    /// Starts from a nonzero seed.
    #[must_use]
    pub(crate) const fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// A uniform random number from 0 to 1.
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        let bits = self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11;
        bits as f64 / 9_007_199_254_740_992.0
    }

    /// A uniform random number from `low` to `high`.
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// A random direction.
    pub(crate) fn direction(&mut self) -> D3 {
        loop {
            let v = [0; 3].map(|_| self.between(-1.0, 1.0));
            let n = norm(v);
            if n > 0.1 && n <= 1.0 {
                return scale(v, 1.0 / n);
            }
        }
    }

    /// A random rotation.
    pub(crate) fn rotation(&mut self) -> Quat {
        let axis = self.direction();
        turn(axis, self.between(0.0, core::f64::consts::TAU))
    }
}

#[cfg(test)]
mod tests {
    use core::f64::consts::{FRAC_PI_2, PI};

    use super::{
        Crossings, FirstApex, Quat, Random, SlipEnd, angle_between, elliptic_k, norm, root, rotate,
        runge_kutta, sub, turn, unrotate,
    };

    #[test]
    fn the_elliptic_integral_gives_the_known_periods_of_a_pendulum() {
        // T / T0 = 2 K / π, the table of pendulum amplitudes in degrees.
        for (degrees, ratio) in
            [(5.0, 1.000_476), (45.0, 1.039_973), (90.0, 1.180_341), (170.0, 2.439_363)]
        {
            let k = (f64::to_radians(degrees) * 0.5).sin();
            assert!((elliptic_k(k * k) * 2.0 / PI - ratio).abs() < 1.0e-6, "{degrees}");
        }
        assert!((elliptic_k(0.0) - FRAC_PI_2).abs() < 1.0e-15);
    }

    #[test]
    fn rotations_agree_with_a_quarter_turn_and_undo_each_other() {
        let q = turn([0.0, 0.0, 1.0], FRAC_PI_2);
        assert!(norm(sub(rotate(q, [1.0, 0.0, 0.0]), [0.0, 1.0, 0.0])) < 1.0e-7);
        assert!(norm(sub(unrotate(q, rotate(q, [1.0, 2.0, 3.0])), [1.0, 2.0, 3.0])) < 1.0e-12);
        assert!((angle_between(Quat::IDENTITY, q) - FRAC_PI_2).abs() < 1.0e-7);
        assert!(
            (angle_between(q, turn([0.0, 0.0, 1.0], FRAC_PI_2 + 1.0e-3)) - 1.0e-3).abs() < 2.0e-7
        );
    }

    #[test]
    fn runge_kutta_follows_a_circle_and_bisection_finds_its_root() {
        let mut x = [1.0, 0.0];
        for _ in 0..1000 {
            x = runge_kutta(&x, 1.0e-3, |x| [x[1], -x[0]]);
        }
        assert!((x[0] - 1.0_f64.cos()).abs() < 1.0e-12);
        assert!((root(1.0, 2.0, f64::cos) - FRAC_PI_2).abs() < 1.0e-12);
    }

    #[test]
    fn readings_find_periods_apexes_and_the_end_of_slip() {
        let (mut crossings, mut apex, mut slip) =
            (Crossings::default(), FirstApex::default(), SlipEnd::default());
        for i in 0..600 {
            let t = f64::from(i) / 60.0;
            crossings.read(t, (2.0 * PI * t / 1.7).cos());
            // A ball falls from 1 m, bounces at the time √(2/10), and rises to 0.25 m.
            let fall = t - 0.2_f64.sqrt();
            let up = 5.0_f64.sqrt();
            apex.read(if fall < 0.0 { 1.0 - 5.0 * t * t } else { up * fall - 5.0 * fall * fall });
            if 2.0 - 3.0 * t > 0.0 {
                slip.read(t, 2.0 - 3.0 * t);
            }
        }
        assert!((crossings.period() - 1.7).abs() < 1.0e-4);
        assert!((apex.apex().unwrap() - 0.25).abs() < 1.0e-9);
        assert!((slip.time() - 2.0 / 3.0).abs() < 1.0e-9);
    }

    #[test]
    fn random_numbers_fill_their_range_evenly() {
        let mut random = Random::new(7);
        let mean = (0..10_000).map(|_| random.between(2.0, 4.0)).sum::<f64>() / 10_000.0;
        // Standard error of the mean of 10,000: 2 / √12 / 100 = 0.006.
        assert!((mean - 3.0).abs() < 0.024, "{mean}");
        assert!((norm(random.direction()) - 1.0).abs() < 1.0e-12);
    }
}
