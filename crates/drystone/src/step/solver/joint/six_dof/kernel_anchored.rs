//! The kernel of six-axis joints that hold two anchors together (hinges, cones, universal and fixed
//! joints): solves eight at a time.
//!
//! Symbols and warm start are those of kernel.rs. No translation is free, so the kernel needs no
//! translation axes: the force stays constant in the world. The solve runs in the space of speeds,
//! s of the anchors (world) and y about the rotation axes, without reading the bodies:
//!
//! ```text
//! | L   C |      L over the translations, A over the rotations
//! | Cᵀ  A |      E = A - Cᵀ L⁻¹ C
//! ```
//!
//! The rotations have the inverse mass E, while L⁻¹ C is the response of the anchors. Locked
//! rotations are solved first, with D, the inverse of their part of E; the other rotations have E -
//! E D E. (This takes half the instructions of rows that push bodies.)

use fearless_simd::{Simd, SimdBase};

use super::block::SixDofBlock;
use super::locked_axes::{Row, couplings, inverse, less, matrix};
use super::placed::{AxisState, LockedImpulses, Placed, act};
use crate::base::simd::wide::{Sym3w, Vec3w, Wide, above, load, max, min, select, splat};
use crate::step::solver::joint::root::axes;
use crate::step::solver::joint::sweep::{JointSweep, bend};

/// Responses of two anchors and three rotations to impulses.
struct Responses<S: Simd> {
    /// L⁻¹.
    l: Sym3w<S>,
    /// Columns of C, and of L⁻¹ C.
    c: [Vec3w<S>; 3],
    lc: [Vec3w<S>; 3],
    /// A, and the inverse mass of rotations through all locked axes.
    a: Sym3w<S>,
    e: Sym3w<S>,
    /// D and D E, and the response at the anchors.
    d: Sym3w<S>,
    de: [Vec3w<S>; 3],
    back: [Vec3w<S>; 3],
}

/// The columns of a symmetric matrix.
#[inline(always)]
fn columns<S: Simd>(m: &Sym3w<S>) -> [Vec3w<S>; 3] {
    [
        Vec3w { x: m.xx, y: m.xy, z: m.xz },
        Vec3w { x: m.xy, y: m.yy, z: m.yz },
        Vec3w { x: m.xz, y: m.yz, z: m.zz },
    ]
}

/// Keeps a vector's components where the marks are 1.
#[inline(always)]
fn only<S: Simd>(v: Vec3w<S>, [x, y, z]: &[Wide<S>; 3]) -> Vec3w<S> {
    Vec3w { x: v.x * *x, y: v.y * *y, z: v.z * *z }
}

/// Columns times the components of a vector.
#[inline(always)]
fn combined<S: Simd>(columns: &[Vec3w<S>; 3], v: Vec3w<S>) -> Vec3w<S> {
    columns[0] * v.x + columns[1] * v.y + columns[2] * v.z
}

/// Speed at which a gap closes.
#[inline(always)]
fn closing<S: Simd>(open: Wide<S>, rate: Wide<S>, maximum: Wide<S>) -> Wide<S> {
    max(min(rate * open, maximum), -maximum)
}

impl<S: Simd> Responses<S> {
    #[inline(always)]
    fn new<const TURNS: bool>(
        simd: S,
        at: &Placed<S>,
        about: &[Row<S>; 3],
        locked: &[Wide<S>; 3],
    ) -> Self {
        let none = Vec3w::zero(simd);
        let ([ax, ay, az], [bx, by, bz]) = (axes(at.sa, at.arm_a), axes(at.sb, at.arm_b));
        let along = [
            Row { n: none, a: ax, b: bx },
            Row { n: none, a: ay, b: by },
            Row { n: none, a: az, b: bz },
        ];
        let linear = at.alpha * at.alpha + at.beta * at.beta;
        let l = inverse(simd, &matrix(&along, [linear; 3]));
        let c = [
            couplings(&along, &about[0]),
            couplings(&along, &about[1]),
            couplings(&along, &about[2]),
        ];
        let lc = [l.mul(c[0]), l.mul(c[1]), l.mul(c[2])];
        let a = matrix(about, [splat(simd, 0.0); 3]);
        let e = less(&a, &c, &lc);
        if !TURNS {
            return Self { l, c, lc, a, e, d: e, de: [none; 3], back: lc };
        }
        let one = splat(simd, 1.0);
        let [k0, k1, k2] = *locked;
        let d = inverse(
            simd,
            &Sym3w {
                xx: select(above(k0, splat(simd, 0.0)), e.xx, one),
                yy: select(above(k1, splat(simd, 0.0)), e.yy, one),
                zz: select(above(k2, splat(simd, 0.0)), e.zz, one),
                xy: e.xy * (k0 * k1),
                xz: e.xz * (k0 * k2),
                yz: e.yz * (k1 * k2),
            },
        );
        let [e0, e1, e2] = columns(&e);
        let de = [
            only(d.mul(only(e0, locked)), locked),
            only(d.mul(only(e1, locked)), locked),
            only(d.mul(only(e2, locked)), locked),
        ];
        let back = [
            lc[0] - combined(&lc, de[0]),
            lc[1] - combined(&lc, de[1]),
            lc[2] - combined(&lc, de[2]),
        ];
        // Only between rotations that are not locked: locked ones get no further impulse.
        let (f0, f1, f2) = (one - k0, one - k1, one - k2);
        let extra = less(&e, &[e0, e1, e2], &de);
        let e = Sym3w {
            xx: extra.xx * f0,
            yy: extra.yy * f1,
            zz: extra.zz * f2,
            xy: extra.xy * (f0 * f1),
            xz: extra.xz * (f0 * f2),
            yz: extra.yz * (f1 * f2),
        };
        Self { l, c, lc, a, e, d, de, back }
    }
}

/// Solves one block once. `TURNS`: some joint of the block locks a rotation.
#[inline(always)]
pub(crate) fn solve<S: Simd, const TURNS: bool>(
    simd: S,
    block: &mut SixDofBlock,
    at: &Placed<S>,
    sweep: &JointSweep,
) -> LockedImpulses<S> {
    let zero = splat(simd, 0.0);
    let softness = &sweep.softness;
    let (mass, rate) = (splat(simd, softness.mass), splat(simd, softness.rate));
    let leak = splat(simd, softness.impulse);
    let [(n0, x0), (n1, x1), (n2, x2)] =
        [at.about(simd, block, 0), at.about(simd, block, 1), at.about(simd, block, 2)];
    let (about, x) = ([n0, n1, n2], [x0, x1, x2]);
    let [_, _, _, k0, k1, k2] = &block.locked;
    let locked = [load(simd, k0), load(simd, k1), load(simd, k2)];
    let answers = Responses::new::<TURNS>(simd, at, &about, &locked);

    // The warm start: impulses whose rows rotated are mapped to the current rows.
    let p = Vec3w::load(simd, &block.carried);
    let pushes = [block.pushes(simd, 3), block.pushes(simd, 4), block.pushes(simd, 5)];
    let t = about[0].n * pushes[0] + about[1].n * pushes[1] + about[2].n * pushes[2];
    let mut slip = at.slip();
    let [wa, wb] = at.spins();
    let mut spin = wb - wa;
    if !sweep.is_relax {
        let h = splat(simd, 1.0) / splat(simd, sweep.inv_h);
        let curve = bend(simd, [wa, wb], [at.arm_a, at.arm_b], h);
        let more_a = at.arm_a.cross(p) + t - Vec3w::load(simd, &block.carried_a);
        let more_b = at.arm_b.cross(p) + t - Vec3w::load(simd, &block.carried_b);
        let turn_a = at.sa.mul(at.sa.mul(more_a));
        let turn_b = at.sb.mul(at.sb.mul(more_b));
        slip = slip + (turn_b.cross(at.arm_b) + turn_a.cross(at.arm_a)) + curve;
        spin = spin + (turn_b + turn_a);
    }
    let mut y = [about[0].n.dot(spin), about[1].n.dot(spin), about[2].n.dot(spin)];

    // All locked axes.
    let maximum = splat(simd, sweep.caps.push(0));
    let miss = Vec3w {
        x: mass * slip.x + closing(at.gap.x, rate, maximum),
        y: mass * slip.y + closing(at.gap.y, rate, maximum),
        z: mass * slip.z + closing(at.gap.z, rate, maximum),
    };
    let mut load_along = p;
    let mut first = answers.l.mul(miss);
    let mut given = Vec3w::zero(simd);
    if TURNS {
        let (mut turns, mut load_about) = ([zero; 3], [zero; 3]);
        let maximum = splat(simd, sweep.caps.push(3));
        for i in 0..3 {
            let off = x[i] - load(simd, &block.place[i + 3]);
            let missed = mass * y[i] + closing(off, rate, maximum);
            turns[i] = (missed - answers.c[i].dot(first)) * locked[i];
            load_about[i] = load(simd, &block.lock_or_drive[i + 3]) * locked[i];
        }
        for i in 0..3 {
            let free = pushes[i] * (splat(simd, 1.0) - locked[i]);
            load_along = load_along + answers.back[i] * free;
            let de = answers.de[i];
            load_about[0] += de.x * free;
            load_about[1] += de.y * free;
            load_about[2] += de.z * free;
        }
        let [x, y, z] = turns;
        let mu = answers.d.mul(Vec3w { x, y, z });
        first = first - combined(&answers.lc, mu);
        given = Vec3w {
            x: -(mu.x + leak * load_about[0]) * locked[0],
            y: -(mu.y + leak * load_about[1]) * locked[1],
            z: -(mu.z + leak * load_about[2]) * locked[2],
        };
    } else {
        for i in 0..3 {
            load_along = load_along + answers.back[i] * pushes[i];
        }
    }
    let mut force = -(first + load_along * leak);

    // The effect of these on drives and limits, one after another.
    let by_turns = columns(&answers.a);
    for i in 0..3 {
        y[i] += answers.c[i].dot(force);
        if TURNS {
            y[i] += by_turns[i].dot(given);
        }
    }
    let start = {
        let (a, b) = (at.sa.mul(at.start_a.w), at.sb.mul(at.start_b.w));
        (b + at.spin_b) - (a + at.spin_a)
    };
    let (own, felt) = (columns(&answers.a), columns(&answers.e));
    let own = [own[0].x, own[1].y, own[2].z];
    let mut more = [zero; 3];
    for i in 0..3 {
        if !block.acts_on(i + 3) {
            continue;
        }
        let Vec3w { x: e0, y: e1, z: e2 } = felt[i];
        let e = [e0, e1, e2];
        // For a rotation that the locked axes exclude completely, the remainder is rounding error.
        let minimum = own[i] * splat(simd, 1.0e-5);
        let k = select(above(e[i], minimum), e[i], zero);
        let felt = AxisState { k, x: x[i], v: y[i], start: about[i].n.dot(start) };
        let old = [
            load(simd, &block.lock_or_drive[i + 3]),
            load(simd, &block.friction[i + 3]),
            load(simd, &block.limit[i + 3]),
        ];
        let new = act(simd, block, i + 3, old, felt, sweep);
        new[0].store_array(&mut block.lock_or_drive[i + 3]);
        new[1].store_array(&mut block.friction[i + 3]);
        new[2].store_array(&mut block.limit[i + 3]);
        let d = (new[0] - old[0]) + (new[1] - old[1]) + (new[2] - old[2]);
        more[i] = d;
        force = force - answers.back[i] * d;
        if TURNS {
            given = given - answers.de[i] * d;
        }
        for j in i + 1..3 {
            y[j] += e[j] * d;
        }
    }
    if TURNS {
        let locks = [given.x, given.y, given.z];
        for i in 0..3 {
            (load(simd, &block.lock_or_drive[i + 3]) + locks[i])
                .store_array(&mut block.lock_or_drive[i + 3]);
            more[i] += locks[i];
        }
    }
    let [m0, m1, m2] = more;
    let torque = about[0].n * m0 + about[1].n * m1 + about[2].n * m2;
    LockedImpulses { old: [p, t], new: [force, torque] }
}
