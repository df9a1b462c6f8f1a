//! The loads on the bonds of a glued body, computed from the impulses on its pieces.
//!
//! Pieces are rigid and bonds are elastic. In the moving body, each piece must have the
//! acceleration that the rigid motion of the whole gives it. The *lack* of a piece is the impulse
//! that it needs for that beyond the impulses on it. Its bonds supply the lack. If the bonds form
//! no loop, this determines their loads. Otherwise they share the load by stiffness, as in a rigid
//! body–spring model [Kawai78]: the displacements `u` of the pieces solve `K u = -lack`. The solver
//! is conjugate gradients [Hestenes52], preconditioned with the diagonal of K. This is the
//! quasi-static view of real-time fracture [Mueller01]: there are no waves, and an impact acts on
//! the whole body at once.
//!
//! Symbols: n points from the first piece of a bond to the second; ρ leads from a piece's center to
//! the face; d is the relative displacement at the face, φ the relative rotation. k_n and k_s are
//! the stiffness along and across n, k_b and k_t those of bending and twisting. A face counts as a
//! square of the same area A: second moment A²/12, section modulus A^1.5/6 in bending and 0.208
//! A^1.5 in twisting [Young11].

use crate::base::double::DVec3;
use crate::base::math::bounded;
use crate::state::breakage::{GlueBond, Glued};

/// Ratio of the shear modulus to Young's modulus, at a Poisson ratio of 1/4.
const SHEAR: f64 = 0.4;

/// Section moduli of a square of unit area.
const BEND_MODULUS: f64 = 1.0 / 6.0;
const TWIST_MODULUS: f64 = 0.208;

/// The solve ends when the residual falls below `TOLERANCE` of the lack, or below `ROUNDING` of the
/// initial residual.
const TOLERANCE: f64 = 1.0e-4;
const ROUNDING: f64 = 1.0e-9;

/// The loads of the previous step are reused if no bond carries more than `LIGHT` of its strength,
/// and no lack has changed much. The change must be below `ALIKE` of the lack and of the impulses
/// on the piece. A body at rest then costs little more than one without bonds.
const LIGHT: f32 = 0.5;
const ALIKE: f64 = 0.02;

/// Overloaded bonds whose load is at least this fraction of the maximum break at once. Then the
/// loads of the other bonds are computed again, at most `MAX_ROUNDS` times in a step.
const WITH_THE_WORST: f64 = 0.5;
const MAX_ROUNDS: usize = 8;

type Mat = [[f64; 3]; 3];

/// A piece as a rigid body.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Lump {
    pub(super) mass: f64,
    /// Center of mass, and inertia about it [body frame].
    pub(super) center: DVec3,
    pub(super) inertia: Mat,
    /// Impulse on it, and the moment about its center.
    pub(super) force: DVec3,
    pub(super) torque: DVec3,
}

/// A bond as a spring.
#[derive(Clone, Copy, Debug, Default)]
struct Spring {
    pieces: [usize; 2],
    arms: [DVec3; 2],
    n: DVec3,
    /// Stiffness along and across n, in bending and twisting. All 0: the bond is broken.
    along: f64,
    across: f64,
    bend: f64,
    twist: f64,
}

/// Displacement and rotation, or force and moment.
#[derive(Clone, Copy, Debug, Default)]
struct Pair {
    x: DVec3,
    t: DVec3,
}

/// Memory that is reused in every step.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    pub(super) lumps: Vec<Lump>,
    springs: Vec<Spring>,
    /// The part of each piece. Pieces connected by bonds have the same number.
    pub(super) part: Vec<usize>,
    lack: Vec<Pair>,
    u: Vec<Pair>,
    r: Vec<Pair>,
    p: Vec<Pair>,
    kp: Vec<Pair>,
    diagonal: Vec<Pair>,
    /// Broken bonds: index, tension and shear [Pa], load.
    pub(super) broken: Vec<(usize, f32, f32, f64)>,
}

fn times(m: &Mat, v: DVec3) -> DVec3 {
    let row = |r: &[f64; 3]| r[0] * v.x + r[1] * v.y + r[2] * v.z;
    DVec3 { x: row(&m[0]), y: row(&m[1]), z: row(&m[2]) }
}

/// Adds m (r·r 1 - r rᵀ).
fn add_point(m: &mut Mat, r: DVec3, mass: f64) {
    let v = [r.x, r.y, r.z];
    let square = r.dot(r);
    for i in 0..3 {
        for j in 0..3 {
            let one = if i == j { square } else { 0.0 };
            m[i][j] += mass * (one - v[i] * v[j]);
        }
    }
}

/// m⁻¹ v; zero if m has no inverse.
fn solve3(m: &Mat, v: DVec3) -> DVec3 {
    let column = |i: usize| DVec3 { x: m[0][i], y: m[1][i], z: m[2][i] };
    let (a, b, c) = (column(0), column(1), column(2));
    let det = a.cross(b).dot(c);
    if det.abs() <= 0.0 {
        return DVec3::ZERO;
    }
    let x = v.cross(b).dot(c) / det;
    let y = a.cross(v).dot(c) / det;
    DVec3 { x, y, z: a.cross(b).dot(v) / det }
}

impl Spring {
    fn new(bond: &GlueBond, lumps: &[Lump]) -> Self {
        let at = DVec3::from(bond.point);
        let [a, b] = bond.pieces.map(|p| lumps[p].center);
        let area = f64::from(bond.area);
        let n = DVec3::from(bond.normal);
        // The stiffness is that of a rod of the pieces' material between their centers. The rod is
        // at least a tenth as long as the face is wide.
        let length = (b - a).length();
        let minimum = 0.1 * area.sqrt();
        let along = area / if length > minimum { length } else { minimum };
        let bend = along * area / 12.0;
        Self {
            pieces: bond.pieces,
            arms: [at - a, at - b],
            n,
            along,
            across: SHEAR * along,
            bend,
            twist: 2.0 * SHEAR * bend,
        }
    }

    const fn is_whole(&self) -> bool {
        self.along > 0.0
    }

    const fn cut(&mut self) {
        (self.along, self.across, self.bend, self.twist) = (0.0, 0.0, 0.0, 0.0);
    }

    /// Force and moment on the first piece at the face, from the displacements of the pieces.
    fn pull(&self, u: &[Pair]) -> Pair {
        let [a, b] = self.pieces.map(|p| u[p]);
        let d = (b.x + b.t.cross(self.arms[1])) - (a.x + a.t.cross(self.arms[0]));
        let turn = b.t - a.t;
        let n = self.n;
        let (stretch, wring) = (n * n.dot(d), n * n.dot(turn));
        Pair {
            x: stretch * self.along + (d - stretch) * self.across,
            t: (turn - wring) * self.bend + wring * self.twist,
        }
    }

    /// Adds K u of this bond.
    fn add(&self, u: &[Pair], ku: &mut [Pair]) {
        let pull = self.pull(u);
        for (side, sign) in [(0, -1.0), (1, 1.0)] {
            let to = &mut ku[self.pieces[side]];
            to.x = to.x + pull.x * sign;
            to.t = to.t + (self.arms[side].cross(pull.x) + pull.t) * sign;
        }
    }

    /// Adds the diagonal of K of this bond.
    fn add_diagonal(&self, diagonal: &mut [Pair]) {
        let one = |x: f64, y: f64, z: f64| DVec3 { x, y, z };
        let axes = [one(1.0, 0.0, 0.0), one(0.0, 1.0, 0.0), one(0.0, 0.0, 1.0)];
        for side in 0..2 {
            let mut gain = [0.0; 6];
            for (i, e) in axes.into_iter().enumerate() {
                let stiff = |v: DVec3, along: f64, across: f64| {
                    let m = self.n.dot(v);
                    m * m * along + (v.dot(v) - m * m) * across
                };
                let moved = e.cross(self.arms[side]);
                gain[i] = stiff(e, self.along, self.across);
                gain[i + 3] =
                    stiff(moved, self.along, self.across) + stiff(e, self.twist, self.bend);
            }
            let to = &mut diagonal[self.pieces[side]];
            to.x = to.x + one(gain[0], gain[1], gain[2]);
            to.t = to.t + one(gain[3], gain[4], gain[5]);
        }
    }
}

impl Pair {
    const fn of(&[x, y, z, a, b, c]: &[f64; 6]) -> Self {
        Self { x: DVec3 { x, y, z }, t: DVec3 { x: a, y: b, z: c } }
    }

    const fn numbers(&self) -> [f64; 6] {
        [self.x.x, self.x.y, self.x.z, self.t.x, self.t.y, self.t.z]
    }

    fn dot(&self, o: &Self) -> f64 {
        self.x.dot(o.x) + self.t.dot(o.t)
    }

    fn plus(&self, o: &Self, s: f64) -> Self {
        Self { x: self.x + o.x * s, t: self.t + o.t * s }
    }

    /// Divides each number by that of `d`; 0 where there is no stiffness.
    fn over(&self, d: &Self) -> Self {
        let part = |a: f64, b: f64| if b > 0.0 { a / b } else { 0.0 };
        let each =
            |a: DVec3, b: DVec3| DVec3 { x: part(a.x, b.x), y: part(a.y, b.y), z: part(a.z, b.z) };
        Self { x: each(self.x, d.x), t: each(self.t, d.t) }
    }
}

fn dot(a: &[Pair], b: &[Pair]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(b)).fold(0.0, |sum, x| sum + x)
}

impl Scratch {
    /// Finds the overloaded bonds, from the impulses on the pieces in a step of `dt` [s] and the
    /// angular velocity of the body [rad/s, body]. Writes the loads of the bonds, `broken`, and
    /// `part`.
    pub(super) fn find_broken(&mut self, glued: &mut Glued, spin: DVec3, dt: f64) {
        let n = self.lumps.len();
        self.springs.clear();
        self.springs.extend(glued.bonds.iter().map(|b| Spring::new(b, &self.lumps)));
        self.u.clear();
        self.u.resize(n, Pair::default());
        for (u, give) in self.u.iter_mut().zip(&glued.give) {
            *u = Pair::of(give);
        }
        self.broken.clear();
        self.find_parts();
        self.find_lack(spin, dt);
        if self.is_as_before(glued) {
            return;
        }
        for _ in 0..MAX_ROUNDS {
            self.find_parts();
            self.find_lack(spin, dt);
            self.solve();
            if !self.cut_worst(glued, dt) {
                break;
            }
        }
        self.find_parts();
        glued.give.clear();
        glued.give.extend(self.u.iter().map(Pair::numbers));
        // Non-finite impulses break no bond. If a lack or a displacement is not finite, nothing is
        // kept for the next step.
        let first = glued.lack.iter().flatten().all(|x| x.is_finite());
        if !(first && dot(&self.u, &self.u).is_finite()) {
            glued.give.clear();
            glued.lack.clear();
        }
    }

    /// True if the loads of the previous step can be reused. Otherwise stores the current lack.
    fn is_as_before(&self, glued: &mut Glued) -> bool {
        let is_known = glued.lack.len() == self.lack.len() && self.part.iter().all(|p| *p == 0);
        let is_light = glued.bonds.iter().all(|b| b.load < LIGHT);
        let alike = |((lack, lump), old): ((&Pair, &Lump), &[f64; 6])| {
            let [[xx, _, _], [_, yy, _], [_, _, zz]] = lump.inertia;
            let reach = (0.5 * (xx + yy + zz) / lump.mass).sqrt();
            let size = |p: &Pair| p.x.length() * reach + p.t.length();
            let (old, impact) = (Pair::of(old), Pair { x: lump.force, t: lump.torque });
            size(&lack.plus(&old, -1.0)) <= ALIKE * (size(&old) + size(&impact))
        };
        let now = || self.lack.iter().zip(&self.lumps);
        if is_known && is_light && now().zip(&glued.lack).all(alike) {
            return true;
        }
        glued.lack.clear();
        glued.lack.extend(self.lack.iter().map(Pair::numbers));
        false
    }

    fn find_parts(&mut self) {
        self.part.clear();
        self.part.extend(0..self.lumps.len());
        for spring in self.springs.iter().filter(|s| s.is_whole()) {
            let [a, b] = spring.pieces.map(|p| crate::state::glue::root(&mut self.part, p));
            self.part[a.max(b)] = a.min(b);
        }
        // The number of a part is the index of its first piece, which comes before the others.
        for i in 0..self.part.len() {
            self.part[i] = self.part[self.part[i]];
        }
    }

    /// Computes the lack of each piece relative to the rigid motion of its part.
    fn find_lack(&mut self, spin: DVec3, dt: f64) {
        self.lack.clear();
        self.lack.resize(self.lumps.len(), Pair::default());
        for first in 0..self.lumps.len() {
            if self.part[first] != first {
                continue;
            }
            let of = |i: &usize| self.part[*i] == first;
            let members = || (first..self.lumps.len()).filter(of);
            let (mut mass, mut sum) = (0.0, DVec3::ZERO);
            for l in members().map(|i| &self.lumps[i]) {
                mass += l.mass;
                sum = sum + l.center * l.mass;
            }
            let center = sum * (1.0 / mass);
            let mut inertia = Mat::default();
            let (mut force, mut torque) = (DVec3::ZERO, DVec3::ZERO);
            for l in members().map(|i| &self.lumps[i]) {
                let arm = l.center - center;
                for i in 0..3 {
                    for j in 0..3 {
                        inertia[i][j] += l.inertia[i][j];
                    }
                }
                add_point(&mut inertia, arm, l.mass);
                force = force + l.force;
                torque = torque + l.torque + arm.cross(l.force);
            }
            let push = force * (1.0 / mass);
            let twist = solve3(&inertia, torque - spin.cross(times(&inertia, spin)) * dt);
            for i in members() {
                let l = &self.lumps[i];
                let arm = l.center - center;
                let kick = push + twist.cross(arm) + spin.cross(spin.cross(arm)) * dt;
                let turn = times(&l.inertia, twist) + spin.cross(times(&l.inertia, spin)) * dt;
                self.lack[i] = Pair { x: kick * l.mass - l.force, t: turn - l.torque };
            }
        }
    }

    /// Solves `K u = -lack`, starting from the previous `u`.
    fn solve(&mut self) {
        let n = self.lumps.len();
        let Self { springs, lack, u, r, p, kp, diagonal, .. } = self;
        let multiply = |x: &[Pair], kx: &mut Vec<Pair>| {
            kx.clear();
            kx.resize(n, Pair::default());
            for spring in springs.iter() {
                spring.add(x, kx);
            }
        };
        diagonal.clear();
        diagonal.resize(n, Pair::default());
        for spring in springs.iter() {
            spring.add_diagonal(diagonal);
        }
        let weigh = |r: &[Pair]| {
            let each = r.iter().zip(diagonal.iter()).map(|(r, d)| r.dot(&r.over(d)));
            each.fold(0.0, |sum, x| sum + x)
        };
        multiply(u, kp);
        r.clear();
        let none = Pair::default();
        let left = |(lack, ku): (&Pair, &Pair)| none.plus(lack, -1.0).plus(ku, -1.0);
        r.extend(lack.iter().zip(kp.iter()).map(left));
        p.clear();
        p.extend(r.iter().zip(diagonal.iter()).map(|(r, d)| r.over(d)));
        let mut size = weigh(r);
        // A residual below this is rounding: there is no better solution.
        let minimum = TOLERANCE * TOLERANCE * weigh(lack) + ROUNDING * ROUNDING * size;
        // Without rounding, one iteration per unknown suffices.
        for _ in 0..12 * n + 20 {
            if size <= minimum {
                break;
            }
            multiply(p, kp);
            let work = dot(p, kp);
            if work <= 0.0 {
                break;
            }
            let step = size / work;
            for i in 0..n {
                u[i] = u[i].plus(&p[i], step);
                r[i] = r[i].plus(&kp[i], -step);
            }
            let now = weigh(r);
            let back = now / size;
            size = now;
            for i in 0..n {
                p[i] = r[i].over(&diagonal[i]).plus(&p[i], back);
            }
        }
    }

    /// Writes the loads and breaks the overloaded bonds. Returns false if there are none.
    fn cut_worst(&mut self, glued: &mut Glued, dt: f64) -> bool {
        let mut worst = 0.0;
        for (spring, bond) in self.springs.iter().zip(&mut glued.bonds) {
            if spring.is_whole() {
                let (_, _, load) = stress(spring, bond, &self.u, dt);
                worst = crate::base::double::greater(worst, load);
                #[expect(clippy::cast_possible_truncation, reason = "to be shown")]
                let shown = load as f32;
                bond.load = bounded(shown);
            }
        }
        if worst < 1.0 {
            return false;
        }
        let minimum = crate::base::double::greater(1.0, WITH_THE_WORST * worst);
        for (i, (spring, bond)) in self.springs.iter_mut().zip(&glued.bonds).enumerate() {
            if !spring.is_whole() {
                continue;
            }
            let (tension, shear, load) = stress(spring, bond, &self.u, dt);
            if load >= minimum {
                spring.cut();
                self.broken.push((i, tension, shear, load));
            }
        }
        true
    }
}

/// Tension and shear of a bond [Pa], and the maximum of both ratios to the strength.
fn stress(spring: &Spring, bond: &GlueBond, u: &[Pair], dt: f64) -> (f32, f32, f64) {
    let pull = spring.pull(u);
    let area = f64::from(bond.area);
    let modulus = area * area.sqrt();
    let (n, per_time) = (spring.n, 1.0 / dt);
    let (straight, wring) = (n.dot(pull.x), n.dot(pull.t));
    let along = (pull.x - n * straight).length();
    let bend = (pull.t - n * wring).length();
    let tension = straight / area + bend / (BEND_MODULUS * modulus);
    let tension = if tension > 0.0 { tension * per_time } else { 0.0 };
    let shear = (along / area + wring.abs() / (TWIST_MODULUS * modulus)) * per_time;
    let part = |stress: f64, limit: f32| stress / f64::from(limit);
    let load = crate::base::double::greater(
        part(tension, bond.strength.tension),
        part(shear, bond.strength.shear),
    );
    #[expect(clippy::cast_possible_truncation, reason = "to be shown")]
    let (tension, shear) = (tension as f32, shear as f32);
    (bounded(tension), bounded(shear), load)
}
