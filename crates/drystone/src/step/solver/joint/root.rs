//! The root S of the inverse inertia of eight bodies, and the rows S (r × e) of a lever arm r.
//! There are two versions: for any bodies, and for bodies with the same inertia about every axis
//! (balls and cubes), which takes a third less work.

use fearless_simd::Simd;

use super::block::{JointBlock, JointExtra};
use crate::base::simd::wide::{Sym3w, Vec3w, Wide, load};

/// S of eight bodies, and the operations that kernels need.
pub(crate) trait Root<S: Simd>: Copy {
    /// Cache lines of [`JointExtra`] that a sweep reads.
    const REST_LINES: usize;
    /// S of the bodies A and B of a block.
    fn pair(simd: S, block: &JointBlock, extra: &JointExtra) -> [Self; 2];
    fn mul(self, v: Vec3w<S>) -> Vec3w<S>;
    /// The rows S (r × x), S (r × y), S (r × z) along the world's axes.
    type Rows: RootRows<S>;
    fn rows(self, r: Vec3w<S>) -> Self::Rows;
}

/// Three rows along the world's axes.
pub(crate) trait RootRows<S: Simd> {
    /// `k` plus the products of the rows.
    fn add_products(&self, k: Sym3w<S>) -> Sym3w<S>;
    /// The products of the rows and `w`.
    fn dot(&self, w: Vec3w<S>) -> Vec3w<S>;
    /// `w` plus the rows times the components of `d`.
    fn add(&self, w: Vec3w<S>, d: Vec3w<S>) -> Vec3w<S>;
    /// `w` minus the rows times the components of `d`.
    fn take(&self, w: Vec3w<S>, d: Vec3w<S>) -> Vec3w<S>;
}

impl<S: Simd> Root<S> for Sym3w<S> {
    const REST_LINES: usize = core::mem::offset_of!(JointExtra, drift) / 64;
    type Rows = [Vec3w<S>; 3];
    #[inline(always)]
    fn pair(simd: S, _: &JointBlock, extra: &JointExtra) -> [Self; 2] {
        [Self::load(simd, &extra.s_a), Self::load(simd, &extra.s_b)]
    }
    #[inline(always)]
    fn mul(self, v: Vec3w<S>) -> Vec3w<S> {
        self.mul(v)
    }
    #[inline(always)]
    fn rows(self, r: Vec3w<S>) -> [Vec3w<S>; 3] {
        axes(self, r)
    }
}

impl<S: Simd> RootRows<S> for [Vec3w<S>; 3] {
    #[inline(always)]
    fn add_products(&self, k: Sym3w<S>) -> Sym3w<S> {
        let [x, y, z] = self;
        Sym3w {
            xx: k.xx + x.dot(*x),
            yy: k.yy + y.dot(*y),
            zz: k.zz + z.dot(*z),
            xy: k.xy + x.dot(*y),
            xz: k.xz + x.dot(*z),
            yz: k.yz + y.dot(*z),
        }
    }
    #[inline(always)]
    fn dot(&self, w: Vec3w<S>) -> Vec3w<S> {
        Vec3w { x: self[0].dot(w), y: self[1].dot(w), z: self[2].dot(w) }
    }
    #[inline(always)]
    fn add(&self, w: Vec3w<S>, d: Vec3w<S>) -> Vec3w<S> {
        w + self[0] * d.x + self[1] * d.y + self[2] * d.z
    }
    #[inline(always)]
    fn take(&self, w: Vec3w<S>, d: Vec3w<S>) -> Vec3w<S> {
        w - self[0] * d.x - self[1] * d.y - self[2] * d.z
    }
}

/// S of bodies with the same inertia about every axis. It does the operations of the general
/// version in the same order, without the zeros. The bits are the same, so results do not depend on
/// the bodies that share a block.
#[derive(Clone, Copy)]
pub(crate) struct Roundw<S: Simd>(Wide<S>);

/// S r of such bodies.
pub(crate) struct RoundRows<S: Simd>(Vec3w<S>);

impl<S: Simd> Root<S> for Roundw<S> {
    const REST_LINES: usize = 0;
    type Rows = RoundRows<S>;
    #[inline(always)]
    fn pair(simd: S, block: &JointBlock, _: &JointExtra) -> [Self; 2] {
        let [a, b] = &block.round;
        [Self(load(simd, a)), Self(load(simd, b))]
    }
    #[inline(always)]
    fn mul(self, v: Vec3w<S>) -> Vec3w<S> {
        v * self.0
    }
    #[inline(always)]
    fn rows(self, r: Vec3w<S>) -> RoundRows<S> {
        RoundRows(r * self.0)
    }
}

impl<S: Simd> RootRows<S> for RoundRows<S> {
    #[inline(always)]
    fn add_products(&self, k: Sym3w<S>) -> Sym3w<S> {
        let Vec3w { x, y, z } = self.0;
        let (xx, yy, zz) = (x * x, y * y, z * z);
        Sym3w {
            xx: k.xx + (zz + yy),
            yy: k.yy + (zz + xx),
            zz: k.zz + (yy + xx),
            xy: k.xy - y * x,
            xz: k.xz - z * x,
            yz: k.yz - z * y,
        }
    }
    #[inline(always)]
    fn dot(&self, w: Vec3w<S>) -> Vec3w<S> {
        let Vec3w { x, y, z } = self.0;
        Vec3w { x: z * w.y - y * w.z, y: x * w.z - z * w.x, z: y * w.x - x * w.y }
    }
    #[inline(always)]
    fn add(&self, w: Vec3w<S>, d: Vec3w<S>) -> Vec3w<S> {
        let Vec3w { x, y, z } = self.0;
        Vec3w { x: w.x - z * d.y + y * d.z, y: w.y + z * d.x - x * d.z, z: w.z - y * d.x + x * d.y }
    }
    #[inline(always)]
    fn take(&self, w: Vec3w<S>, d: Vec3w<S>) -> Vec3w<S> {
        let Vec3w { x, y, z } = self.0;
        Vec3w { x: w.x + z * d.y - y * d.z, y: w.y - z * d.x + x * d.z, z: w.z + y * d.x - x * d.y }
    }
}

/// The rows S (r × x), S (r × y), S (r × z) along the world's axes; r × x = (0, z, -y), and so on.
#[inline(always)]
pub(crate) fn axes<S: Simd>(s: Sym3w<S>, r: Vec3w<S>) -> [Vec3w<S>; 3] {
    [
        Vec3w {
            x: s.xy * r.z - s.xz * r.y,
            y: s.yy * r.z - s.yz * r.y,
            z: s.yz * r.z - s.zz * r.y,
        },
        Vec3w {
            x: s.xz * r.x - s.xx * r.z,
            y: s.yz * r.x - s.xy * r.z,
            z: s.zz * r.x - s.xz * r.z,
        },
        Vec3w {
            x: s.xx * r.y - s.xy * r.x,
            y: s.xy * r.y - s.yy * r.x,
            z: s.xz * r.y - s.yz * r.x,
        },
    ]
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Simd, dispatch};

    use super::{JointBlock, JointExtra, Root, RootRows, Roundw, Sym3w, Vec3w};
    use crate::base::random::Random;
    use crate::base::simd::wide::{LANES, Lanes, SimdLevel};

    /// Results of all operations that a kernel uses.
    fn answers<S: Simd, R: Root<S>>(
        simd: S,
        s: &[Lanes; 6],
        [r, w, d]: &[[Lanes; 3]; 3],
    ) -> Vec<u32> {
        let [r, w, d] = [r, w, d].map(|v| Vec3w::load(simd, v));
        let block = JointBlock { round: [s[0]; 2], ..JointBlock::default() };
        let extra = JointExtra { s_a: *s, s_b: *s, ..JointExtra::default() };
        let [root, _] = R::pair(simd, &block, &extra);
        let rows = root.rows(r);
        let mut out = [[[0.0; LANES]; 3]; 6];
        root.mul(w).store(&mut out[0]);
        rows.dot(w).store(&mut out[1]);
        rows.add(w, d).store(&mut out[2]);
        rows.take(w, d).store(&mut out[3]);
        let none = Vec3w::zero(simd).x;
        let k = Sym3w { xx: d.x, yy: d.y, zz: d.z, xy: none, xz: none, yz: none };
        let k = rows.add_products(k);
        Vec3w { x: k.xx, y: k.yy, z: k.zz }.store(&mut out[4]);
        Vec3w { x: k.xy, y: k.xz, z: k.yz }.store(&mut out[5]);
        out.into_iter().flatten().flatten().map(f32::to_bits).collect()
    }

    #[test]
    fn round_bodies_have_the_bits_of_any_others() {
        let mut random = Random::new(3);
        for _ in 0..500 {
            #[expect(clippy::cast_possible_truncation, reason = "any number will do")]
            let mut lanes = || [(); LANES].map(|()| (4.0 * random.unit() - 2.0) as f32);
            let s = lanes().map(f32::abs);
            let zero = [0.0; LANES];
            let s = [s, s, s, zero, zero, zero];
            let vectors = [(); 3].map(|()| [(); 3].map(|()| lanes()));
            dispatch!(SimdLevel::best().0, simd => {
                let round = answers::<_, Roundw<_>>(simd, &s, &vectors);
                assert!(round == answers::<_, Sym3w<_>>(simd, &s, &vectors));
                assert!(Sym3w::load(simd, &s).is_round(simd));
            });
            let mut other = s;
            other[4][3] = 1.0e-7;
            dispatch!(SimdLevel::best().0, simd => {
                assert!(!Sym3w::load(simd, &other).is_round(simd));
            });
        }
    }
}
