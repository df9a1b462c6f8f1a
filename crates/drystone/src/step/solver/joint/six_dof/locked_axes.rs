//! Two bodies on a six-axis joint, its rows, and its locked axes as one system, in lanes. Symbols:
//! kernel.rs.

use fearless_simd::Simd;

use super::block::SixDofBlock;
use crate::base::simd::wide::{
    Sym3w, Vec3w, Wide, above, inverse_or_zero, load, max, min, select, splat,
};
use crate::step::solver::joint::sweep::JointSweep;
use crate::step::solver_body::Velocity;

/// Rows of an axis at both bodies: u and n, and S (r × u) or S n.
#[derive(Clone, Copy)]
pub(crate) struct Row<S: Simd> {
    pub(crate) n: Vec3w<S>,
    pub(crate) a: Vec3w<S>,
    pub(crate) b: Vec3w<S>,
}

impl<S: Simd> Row<S> {
    /// The row of a translation along `u` at these lever arms.
    #[inline(always)]
    pub(crate) fn along(u: Vec3w<S>, arms: [Vec3w<S>; 2], [sa, sb]: [&Sym3w<S>; 2]) -> Self {
        Self { n: u, a: sa.mul(arms[0].cross(u)), b: sb.mul(arms[1].cross(u)) }
    }

    /// The row of a rotation about `n`.
    #[inline(always)]
    pub(crate) fn about(n: Vec3w<S>, [sa, sb]: [&Sym3w<S>; 2]) -> Self {
        Self { n, a: sa.mul(n), b: sb.mul(n) }
    }

    #[inline(always)]
    pub(crate) fn masked(self, m: Wide<S>) -> Self {
        Self { n: self.n * m, a: self.a * m, b: self.b * m }
    }

    #[inline(always)]
    pub(crate) fn coupling(&self, o: &Self) -> Wide<S> {
        self.a.dot(o.a) + self.b.dot(o.b)
    }
}

/// Both bodies, as the sweep changes them.
pub(crate) struct Pair<S: Simd> {
    pub(crate) alpha: Wide<S>,
    pub(crate) beta: Wide<S>,
    pub(crate) sa: Sym3w<S>,
    pub(crate) sb: Sym3w<S>,
    pub(crate) va: Velocity<S>,
    pub(crate) vb: Velocity<S>,
    /// Relative velocities of kinematic bodies.
    pub(crate) drift: Vec3w<S>,
    pub(crate) spin: Vec3w<S>,
    /// Contribution of a rotation within the substep to the gap's mean speed.
    pub(crate) bend: Vec3w<S>,
    pub(crate) arm_a: Vec3w<S>,
    pub(crate) arm_b: Vec3w<S>,
    /// Impulses of this sweep: linear, and about anchor B.
    pub(crate) force: Vec3w<S>,
    pub(crate) torque: Vec3w<S>,
}

impl<S: Simd> Pair<S> {
    #[inline(always)]
    pub(crate) fn speed_along(&self, row: &Row<S>, [a, b]: [&Velocity<S>; 2]) -> Wide<S> {
        row.n.dot(b.v * self.beta - a.v * self.alpha + self.drift) + row.b.dot(b.w) - row.a.dot(a.w)
    }

    #[inline(always)]
    pub(crate) fn speed_about(&self, row: &Row<S>, [a, b]: [&Velocity<S>; 2]) -> Wide<S> {
        row.n.dot(self.spin) + row.b.dot(b.w) - row.a.dot(a.w)
    }

    #[inline(always)]
    pub(crate) fn push_along(&mut self, row: &Row<S>, d: Wide<S>) {
        let p = row.n * d;
        self.va.v = self.va.v - p * self.alpha;
        self.vb.v = self.vb.v + p * self.beta;
        self.push_along_unseen(row, d);
    }

    /// Applies only the angular part, for rotation rows that are solved next, which do not read
    /// linear velocities.
    #[inline(always)]
    fn push_along_unseen(&mut self, row: &Row<S>, d: Wide<S>) {
        self.force = self.force + row.n * d;
        self.spin_by(row, d);
    }

    #[inline(always)]
    pub(crate) fn push_about(&mut self, row: &Row<S>, d: Wide<S>) {
        self.torque = self.torque + row.n * d;
        self.spin_by(row, d);
    }

    /// Adds the effect of a row's impulse to the angular velocities.
    #[inline(always)]
    fn spin_by(&mut self, row: &Row<S>, d: Wide<S>) {
        self.va.w = self.va.w - row.a * d;
        self.vb.w = self.vb.w + row.b * d;
    }
}

/// The inverse of a positive semidefinite matrix, by L D Lᵀ. An axis without inverse mass of its
/// own (a body whose rotation is locked) is left out.
#[inline(always)]
pub(crate) fn inverse<S: Simd>(simd: S, m: &Sym3w<S>) -> Sym3w<S> {
    let part = splat(simd, 1.0e-6);
    let zero = splat(simd, 0.0);
    let ix = inverse_or_zero(simd, m.xx);
    let (lx, mx) = (m.xy * ix, m.xz * ix);
    let dy = m.yy - m.xy * lx;
    let iy = select(above(dy, m.yy * part), inverse_or_zero(simd, dy), zero);
    let ly = (m.yz - m.xz * lx) * iy;
    let dz = m.zz - m.xz * mx - ly * ly * dy;
    let iz = select(above(dz, m.zz * part), inverse_or_zero(simd, dz), zero);
    // L⁻¹ has -lx, w, -ly below its ones.
    let w = lx * ly - mx;
    Sym3w {
        xx: ix + lx * lx * iy + w * w * iz,
        xy: -(lx * iy) - w * ly * iz,
        xz: w * iz,
        yy: iy + ly * ly * iz,
        yz: -(ly * iz),
        zz: iz,
    }
}

/// A Schur complement: `a` less the products of two sets of columns that make a symmetric matrix.
#[inline(always)]
pub(crate) fn less<S: Simd>(a: &Sym3w<S>, c: &[Vec3w<S>; 3], lc: &[Vec3w<S>; 3]) -> Sym3w<S> {
    Sym3w {
        xx: a.xx - c[0].dot(lc[0]),
        yy: a.yy - c[1].dot(lc[1]),
        zz: a.zz - c[2].dot(lc[2]),
        xy: a.xy - c[0].dot(lc[1]),
        xz: a.xz - c[0].dot(lc[2]),
        yz: a.yz - c[1].dot(lc[2]),
    }
}

/// The matrix of three rows, plus `own` on its diagonal.
#[inline(always)]
pub(crate) fn matrix<S: Simd>(r: &[Row<S>; 3], own: [Wide<S>; 3]) -> Sym3w<S> {
    Sym3w {
        xx: own[0] + r[0].coupling(&r[0]),
        yy: own[1] + r[1].coupling(&r[1]),
        zz: own[2] + r[2].coupling(&r[2]),
        xy: r[0].coupling(&r[1]),
        xz: r[0].coupling(&r[2]),
        yz: r[1].coupling(&r[2]),
    }
}

/// Couplings of a row to three others.
#[inline(always)]
pub(crate) fn couplings<S: Simd>(rows: &[Row<S>; 3], row: &Row<S>) -> Vec3w<S> {
    Vec3w { x: rows[0].coupling(row), y: rows[1].coupling(row), z: rows[2].coupling(row) }
}

/// The locked axes of a joint as one system. If no joint of the block locks a translation, or a
/// rotation (`TURNS`), that part is left out.
pub(crate) struct LockedAxes<S: Simd, const TURNS: bool> {
    /// Some translation is locked.
    motions: bool,
    /// Placeholder for a part that is left out.
    none: Vec3w<S>,
    pub(crate) along: [Row<S>; 3],
    about: [Row<S>; 3],
    /// L⁻¹, columns of C and of L⁻¹ C, (A - Cᵀ L⁻¹ C)⁻¹.
    l: Sym3w<S>,
    c: [Vec3w<S>; 3],
    lc: [Vec3w<S>; 3],
    a: Sym3w<S>,
}

impl<S: Simd, const TURNS: bool> LockedAxes<S, TURNS> {
    /// The rows alone, before inversion.
    #[inline(always)]
    pub(crate) fn of(
        simd: S,
        along: &[Row<S>; 3],
        about: &[Row<S>; 3],
        locked: &[Wide<S>; 6],
        motions: bool,
    ) -> Self {
        let zero = splat(simd, 0.0);
        let [l0, l1, l2, k0, k1, k2] = *locked;
        let along = [along[0].masked(l0), along[1].masked(l1), along[2].masked(l2)];
        let about = [about[0].masked(k0), about[1].masked(k1), about[2].masked(k2)];
        let none = Vec3w::zero(simd);
        let nothing = Sym3w { xx: zero, yy: zero, zz: zero, xy: zero, xz: zero, yz: zero };
        let (l, a, c, lc) = (nothing, nothing, [none; 3], [none; 3]);
        Self { motions, none, along, about, l, c, lc, a }
    }

    /// Computes the inverse matrix. (In place: a kernel's structs are kilobytes, and were copied.)
    #[inline(always)]
    pub(crate) fn invert(&mut self, simd: S, locked: &[Wide<S>; 6], linear: Wide<S>) {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let [l0, l1, l2, k0, k1, k2] = *locked;
        if self.motions {
            // Axes that are not locked have ones on the diagonal.
            let own = [
                select(above(l0, zero), linear, one),
                select(above(l1, zero), linear, one),
                select(above(l2, zero), linear, one),
            ];
            self.l = inverse(simd, &matrix(&self.along, own));
        }
        if !TURNS {
            return;
        }
        let mut a = matrix(&self.about, [one - k0, one - k1, one - k2]);
        if self.motions {
            let c = [
                couplings(&self.along, &self.about[0]),
                couplings(&self.along, &self.about[1]),
                couplings(&self.along, &self.about[2]),
            ];
            let lc = [self.l.mul(c[0]), self.l.mul(c[1]), self.l.mul(c[2])];
            a = less(&a, &c, &lc);
            (self.c, self.lc) = (c, lc);
        }
        self.a = inverse(simd, &a);
    }

    /// Impulses of the locked axes that change their speeds by these amounts.
    #[inline(always)]
    fn impulses(&self, along: Vec3w<S>, about: Vec3w<S>) -> [Vec3w<S>; 2] {
        if !TURNS {
            return [self.l.mul(along), about];
        }
        if !self.motions {
            return [along, self.a.mul(about)];
        }
        let first = self.l.mul(along);
        let extra = Vec3w {
            x: about.x - self.c[0].dot(first),
            y: about.y - self.c[1].dot(first),
            z: about.z - self.c[2].dot(first),
        };
        let mu = self.a.mul(extra);
        [first - self.lc[0] * mu.x - self.lc[1] * mu.y - self.lc[2] * mu.z, mu]
    }

    /// Inverse mass of a row without the linear part, and the impulses that keep the locked axes in
    /// place under a unit impulse of the row.
    #[inline(always)]
    pub(crate) fn behind(&self, row: &Row<S>) -> (Wide<S>, [Vec3w<S>; 2]) {
        let kl = if self.motions { couplings(&self.along, row) } else { self.none };
        let ka = if TURNS { couplings(&self.about, row) } else { self.none };
        let back = self.impulses(kl, ka);
        let mut k = row.coupling(row);
        if self.motions {
            k -= kl.dot(back[0]);
        }
        if TURNS {
            k -= ka.dot(back[1]);
        }
        (k, back)
    }

    /// Applies the response of the locked axes to an impulse `d` of a rotation or (`MOTION`) a
    /// translation.
    #[inline(always)]
    pub(crate) fn answer<const MOTION: bool>(
        &self,
        q: &mut Pair<S>,
        d: Wide<S>,
        [along, about]: &[Vec3w<S>; 2],
        given: &mut [Wide<S>; 6],
    ) {
        if self.motions {
            let p = [-(along.x * d), -(along.y * d), -(along.z * d)];
            for i in 0..3 {
                given[i] += p[i];
                if MOTION {
                    q.push_along(&self.along[i], p[i]);
                } else {
                    q.push_along_unseen(&self.along[i], p[i]);
                }
            }
        }
        if TURNS {
            let p = [-(about.x * d), -(about.y * d), -(about.z * d)];
            for i in 0..3 {
                given[i + 3] += p[i];
                q.push_about(&self.about[i], p[i]);
            }
        }
    }

    /// Solves the locked axes. Softness applies to loads only: `loads` are their impulses without
    /// the response to drives and limits. (These make torques, under which a small inertia would
    /// yield by a tenth of a spring's step.)
    #[inline(always)]
    pub(crate) fn solve(
        &self,
        simd: S,
        block: &SixDofBlock,
        q: &mut Pair<S>,
        x: &[Wide<S>; 6],
        loads: &[Wide<S>; 6],
        sweep: &JointSweep,
    ) -> [Wide<S>; 6] {
        let softness = &sweep.softness;
        let mass = splat(simd, softness.mass);
        let (rate, leak) = (splat(simd, softness.rate), splat(simd, softness.impulse));
        let parts = [self.motions, TURNS];
        let mut miss = [splat(simd, 0.0); 6];
        for i in 0..6 {
            if !parts[i / 3] {
                continue;
            }
            let locked = load(simd, &block.locked[i]);
            let off = (x[i] - load(simd, &block.place[i])) * locked;
            let speed = if i < 3 {
                q.speed_along(&self.along[i], [&q.va, &q.vb]) + self.along[i].n.dot(q.bend)
            } else {
                q.speed_about(&self.about[i - 3], [&q.va, &q.vb])
            };
            let maximum = splat(simd, sweep.caps.push(i));
            miss[i] = mass * speed + max(min(rate * off, maximum), -maximum);
        }
        let [along, about] = self.impulses(
            Vec3w { x: miss[0], y: miss[1], z: miss[2] },
            Vec3w { x: miss[3], y: miss[4], z: miss[5] },
        );
        let solved = [along.x, along.y, along.z, about.x, about.y, about.z];
        let mut given = [splat(simd, 0.0); 6];
        for i in 0..6 {
            if !parts[i / 3] {
                continue;
            }
            let locked = load(simd, &block.locked[i]);
            let d = -(solved[i] + leak * loads[i]) * locked;
            given[i] = d;
            if i < 3 {
                q.push_along(&self.along[i], d);
            } else {
                q.push_about(&self.about[i - 3], d);
            }
        }
        given
    }
}
