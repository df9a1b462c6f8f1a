//! Response of a contact that is hit: its rows, and the reaction that accumulates impulses before
//! they are applied to its bodies. See [`super::impact`].

use fearless_simd::{Simd, SimdBase};

use super::candidate::{Candidate, Source};
use crate::base::math::{Vec3, vec3};
use crate::base::simd::wide::{LANES, Lanes, Vec3w, Wide, at, load, put, splat};
use crate::step::solver::totals_rows::Bounce;
use crate::step::solver_body::three;

/// Rows of a response, one in each lane: the normals of up to four points, friction along two
/// tangents, twist.
const FRICTION: usize = 4;

const ROWS: usize = 7;

/// A contact that was hit in this step.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct Response {
    solver_rows: [u32; 2],
    block: u32,
    lane: u8,
    /// One of the bodies is a moving kinematic body.
    pub(crate) driven: bool,
    /// All rows are filled.
    loaded: bool,
    /// The pass of the impulses below.
    pass: u16,
    n: Vec3,
    t: [Vec3; 2],
    alpha: f32,
    beta: f32,
    mu: f32,
    /// Kinetic friction as a fraction of static friction.
    kinetic: f32,
    /// Inverse of the matrix of friction's rows, as in the block, and the step size for sliding.
    mass_t: [f32; 6],
    mass_slide: f32,
    /// Effective masses of the points' rows; 0 for missing points.
    pub(crate) mass: [f32; 4],
    /// Impulses of this substep's impacts: normal and friction.
    given: [f32; 4],
    rubbed: [f32; 3],
    /// Angular rows for A and B, and the speed that kinematic bodies cause in the rows: component,
    /// row.
    a: [Lanes; 3],
    b: [Lanes; 3],
    drift: Lanes,
    /// Change of all rows' speeds by a unit impulse along each row.
    answer: [Lanes; ROWS],
    /// Impulses in this step.
    bounce: Bounce,
}

/// Speeds of a response's rows in a reaction, and the impulses along them that are not yet applied
/// to the bodies.
#[derive(Clone, Copy)]
pub(crate) struct Reaction<S: Simd> {
    speeds: Wide<S>,
    impulse: Lanes,
}

impl<S: Simd> Reaction<S> {
    #[inline(always)]
    pub(crate) fn none(simd: S) -> Self {
        Self { speeds: splat(simd, 0.0), impulse: [0.0; LANES] }
    }

    /// Speeds of all rows; those of points are along the normal, negative while they approach.
    #[inline(always)]
    pub(crate) fn speeds(&self) -> Lanes {
        let mut speeds = [0.0; LANES];
        self.speeds.store_array(&mut speeds);
        speeds
    }
}

/// The products of rows with a vector.
#[inline(always)]
fn along<S: Simd>(simd: S, rows: &[Lanes; 3], v: Vec3) -> Wide<S> {
    Vec3w::load(simd, rows).dot(Vec3w::splat(simd, v))
}

/// The sum of a row's vectors, each times a factor.
#[inline(always)]
fn combine<S: Simd>(simd: S, rows: &[Lanes; 3], factors: Wide<S>) -> Vec3 {
    let mut sums = [0.0; 3];
    for (row, sum) in rows.iter().zip(&mut sums) {
        let mut p = [0.0; LANES];
        (load(simd, row) * factors).store_array(&mut p);
        *sum = ((p[0] + p[4]) + (p[1] + p[5])) + ((p[2] + p[6]) + (p[3] + p[7]));
    }
    vec3(sums[0], sums[1], sums[2])
}

impl Response {
    /// Makes a response with the points' rows of a candidate; the other rows are filled later.
    pub(crate) fn new(candidate: &Candidate) -> Self {
        let rows =
            |of: [[f32; 4]; 3]| of.map(|[r1, r2, r3, r4]| [r1, r2, r3, r4, 0.0, 0.0, 0.0, 0.0]);
        let Candidate { solver_rows, block, lane, n, alpha, beta, a, b, .. } = *candidate;
        Self { solver_rows, block, lane, n, alpha, beta, a: rows(a), b: rows(b), ..Self::default() }
    }

    /// Block and lane of its contact, and its impulses in this step.
    pub(crate) fn given(&self) -> (usize, usize, &Bounce) {
        (self.block as usize, usize::from(self.lane), &self.bounce)
    }

    fn load(&mut self, source: &Source<'_>) {
        let block = source.blocks.read(self.block as usize);
        let extra = source.extra(self.block as usize);
        let lane = usize::from(self.lane);
        self.t = [at(&block.t1, lane), at(&block.t2, lane)];
        self.mu = block.mu[lane];
        (self.mass_t, self.mass_slide) = (block.mass_t.map(|m| m[lane]), block.mass_slide[lane]);
        self.kinetic = extra.filter(|extra| extra.slips).map_or(1.0, |extra| extra.kinetic[lane]);
        for i in 0..3 {
            // In a contact with a fixed body, that body's rows are not filled.
            if self.solver_rows[0] != 0 {
                put(&mut self.a, FRICTION + i, at(&block.a_t[i], lane));
            }
            if self.solver_rows[1] != 0 {
                put(&mut self.b, FRICTION + i, at(&block.b_t[i], lane));
            }
            self.drift[FRICTION + i] = extra.map_or(0.0, |extra| extra.drift_t[i][lane]);
        }
        for (j, p) in block.points.iter().take(usize::from(block.count)).enumerate() {
            self.mass[j] = p.mass[lane];
            self.drift[j] = extra.map_or(0.0, |extra| extra.drift[j][lane]);
        }
        self.driven = self.drift.iter().any(|drift| *drift != 0.0);
    }

    /// Computes the whitened products of each row with all others, once. In a new pass, resets the
    /// impulses.
    #[inline(always)]
    pub(crate) fn couple<S: Simd>(&mut self, simd: S, source: &Source<'_>, pass: u16) {
        if core::mem::replace(&mut self.pass, pass) != pass {
            (self.given, self.rubbed) = ([0.0; 4], [0.0; 3]);
        }
        if core::mem::replace(&mut self.loaded, true) {
            return;
        }
        self.load(source);
        let straight = self.alpha * self.alpha + self.beta * self.beta;
        for (i, answer) in self.answer.iter_mut().enumerate() {
            let of_a = along(simd, &self.a, at(&self.a, i));
            let of_b = along(simd, &self.b, at(&self.b, i));
            let same = |l| if i < FRICTION { l < FRICTION } else { l == i && l < ROWS - 1 };
            let straight: Lanes = core::array::from_fn(|l| if same(l) { straight } else { 0.0 });
            (of_a + of_b + load(simd, &straight)).store_array(answer);
        }
    }

    /// Begins a reaction: with the bodies' speeds, and no impulse.
    #[inline(always)]
    pub(crate) fn reaction<S: Simd>(&self, simd: S, source: &Source<'_>) -> Reaction<S> {
        let [a, b] =
            self.solver_rows.map(|solver_row| source.solver_bodies.read(solver_row as usize));
        let slip = three(b.v) * self.beta - three(a.v) * self.alpha;
        let (u, u1, u2) = (self.n.dot(slip), self.t[0].dot(slip), self.t[1].dot(slip));
        let straight = load(simd, &[u, u, u, u, u1, u2, 0.0, 0.0]);
        let (turn_a, turn_b) = (along(simd, &self.a, three(a.w)), along(simd, &self.b, three(b.w)));
        let speeds = straight + turn_b - turn_a + load(simd, &self.drift);
        Reaction { speeds, impulse: [0.0; LANES] }
    }

    /// Applies an impulse along a row, within the reaction only.
    #[inline(always)]
    fn act<S: Simd>(&self, simd: S, reaction: &mut Reaction<S>, row: usize, d: f32) {
        reaction.impulse[row] += d;
        reaction.speeds += load(simd, &self.answer[row]) * splat(simd, d);
    }

    /// Applies an impulse `d` along the normal at point `j`; returns its work [J].
    #[inline(always)]
    pub(crate) fn push<S: Simd>(
        &mut self,
        simd: S,
        reaction: &mut Reaction<S>,
        j: usize,
        d: f32,
    ) -> f32 {
        let before = reaction.speeds()[j];
        self.given[j] += d;
        self.act(simd, reaction, j, d);
        0.5 * d * (before + reaction.speeds()[j])
    }

    /// Applies friction and twist within one limit, as in the sweep: the limit of the bounce's
    /// whole impulse. Returns their work [J].
    #[inline(always)]
    pub(crate) fn rub<S: Simd>(&mut self, simd: S, reaction: &mut Reaction<S>) -> f32 {
        let [g1, g2, g3, g4] = self.given;
        let limit = self.mu * (g1 + g2 + g3 + g4);
        if limit <= 0.0 {
            return 0.0;
        }
        let [.., s1, s2, s3, _] = reaction.speeds();
        let ([m11, m12, m22, m13, m23, m33], [f1, f2, f3]) = (self.mass_t, self.rubbed);
        let mut g1 = f1 - (m11 * s1 + m12 * s2 + m13 * s3);
        let mut g2 = f2 - (m12 * s1 + m22 * s2 + m23 * s3);
        let mut g3 = f3 - (m13 * s1 + m23 * s2 + m33 * s3);
        if g1 * g1 + g2 * g2 + g3 * g3 > limit * limit {
            let step = self.mass_slide;
            (g1, g2, g3) = (f1 - step * s1, f2 - step * s2, f3 - step * s3);
            let (square, kinetic) = (g1 * g1 + g2 * g2 + g3 * g3, self.kinetic * limit);
            if square > kinetic * kinetic {
                let back = kinetic / square.sqrt();
                (g1, g2, g3) = (g1 * back, g2 * back, g3 * back);
            }
        }
        self.rubbed = [g1, g2, g3];
        let d = [g1 - f1, g2 - f2, g3 - f3];
        for (i, d) in d.into_iter().enumerate() {
            self.act(simd, reaction, FRICTION + i, d);
        }
        let [.., r1, r2, r3, _] = reaction.speeds();
        0.5 * (d[0] * (s1 + r1) + d[1] * (s2 + r2) + d[2] * (s3 + r3))
    }

    /// Applies the impulses of a reaction to the bodies. No later substep repeats them.
    #[inline(always)]
    pub(crate) fn deliver<S: Simd>(
        &mut self,
        simd: S,
        reaction: &Reaction<S>,
        source: &Source<'_>,
    ) {
        let d = &reaction.impulse;
        if d.iter().all(|d| *d == 0.0) {
            return;
        }
        let normal = (d[0] + d[1]) + (d[2] + d[3]);
        let linear = self.n * normal + (self.t[0] * d[4] + self.t[1] * d[5]);
        for (sum, d) in self.bounce.points.iter_mut().zip(d) {
            *sum += d;
        }
        self.bounce.push += linear;
        let [a, b] = self.solver_rows.map(|solver_row| solver_row as usize);
        let factors = load(simd, d);
        if a != 0 {
            let turn = -combine(simd, &self.a, factors);
            source.aux.row(a).strike(source.solver_bodies.row(a), linear * -self.alpha, turn);
        }
        if b != 0 {
            let turn = combine(simd, &self.b, factors);
            source.aux.row(b).strike(source.solver_bodies.row(b), linear * self.beta, turn);
        }
    }
}
