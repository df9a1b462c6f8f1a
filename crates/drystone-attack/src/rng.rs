//! Random numbers that are the same on every machine: the whole attack follows from a 64-bit seed.

use drystone::{Quat, Vec3, vec3};

/// The random number generator splitmix64: a counter and a mixer.
#[derive(Clone, Debug)]
pub struct Rng(u64);

impl Rng {
    /// Starts from a seed; adjacent seeds give unrelated sequences.
    #[must_use]
    pub const fn new(seed: u64) -> Self {
        Self(mix(seed ^ 0x6a09_e667_f3bc_c908))
    }

    /// 64 random bits.
    pub const fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        mix(self.0)
    }

    /// An integer below `n`; 0 if `n` is 0.
    pub fn below(&mut self, n: usize) -> usize {
        let n = n.max(1) as u64;
        // The high half of a product of two 32-bit numbers; its bias is at most n / 2^32.
        usize::try_from(((self.bits() >> 32) * n) >> 32).unwrap_or(0)
    }

    /// As `below`, for 32 bits.
    pub fn below_u32(&mut self, n: u32) -> u32 {
        u32::try_from(self.below(n as usize)).unwrap_or(0)
    }

    /// An integer from `a` to `b`, both included.
    pub fn from_to(&mut self, a: usize, b: usize) -> usize {
        a + self.below(b - a + 1)
    }

    /// A number from 0 to 1, without 1.
    pub fn unit(&mut self) -> f32 {
        #[expect(clippy::cast_precision_loss, reason = "24 bits are exact")]
        let part = (self.bits() >> 40) as f32;
        part / 16_777_216.0
    }

    /// True with this probability.
    pub fn chance(&mut self, p: f32) -> bool {
        self.unit() < p
    }

    /// A uniform number between two numbers.
    pub fn between(&mut self, a: f32, b: f32) -> f32 {
        a + (b - a) * self.unit()
    }

    /// A number between two positive numbers, uniform in the logarithm.
    pub fn scale(&mut self, a: f32, b: f32) -> f32 {
        let mut doublings = 0;
        let mut x = a;
        while x < b {
            x *= 2.0;
            doublings += 1;
        }
        let mut x = a * (1.0 + self.unit());
        for _ in 0..self.below(doublings) {
            x *= 2.0;
        }
        x.min(b)
    }

    /// A random element.
    pub fn pick<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())]
    }

    /// A random index, with probabilities in proportion to these weights.
    pub fn weighted(&mut self, weights: &[f32]) -> usize {
        let mut left = self.unit() * weights.iter().sum::<f32>();
        for (i, weight) in weights.iter().enumerate() {
            left -= weight;
            if left < 0.0 {
                return i;
            }
        }
        weights.len() - 1
    }

    /// A vector with components between -half and half.
    pub fn vector(&mut self, half: f32) -> Vec3 {
        let mut one = || self.between(-half, half);
        vec3(one(), one(), one())
    }

    /// A random unit vector.
    pub fn direction(&mut self) -> Vec3 {
        self.vector(1.0).normalize_or(Vec3::Y)
    }

    /// A random rotation; in 30 % of cases about an axis of the world, as in most scenes.
    pub fn rotation(&mut self) -> Quat {
        if self.chance(0.3) {
            let axis = self.pick(&[Vec3::X, Vec3::Y, Vec3::Z]);
            let angle = self.pick(&[0.0, core::f32::consts::FRAC_PI_2, core::f32::consts::PI]);
            return Quat::from_axis_angle(axis, angle);
        }
        let v = self.vector(2.0);
        Quat::from_rotation_vector(v)
    }
}

/// The mixer of splitmix64: each input bit affects half of the output bits.
#[must_use]
pub const fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::Rng;

    #[test]
    fn numbers_stay_within_their_bounds_and_repeat() {
        let (mut a, mut b) = (Rng::new(7), Rng::new(7));
        for _ in 0..1000 {
            assert_eq!(a.bits(), b.bits());
            let x = a.scale(0.01, 100.0);
            assert!((0.01..=100.0).contains(&x), "{x}");
            assert!(a.below(3) < 3 && (0.0..1.0).contains(&a.unit()));
            b = a.clone();
        }
    }
}
