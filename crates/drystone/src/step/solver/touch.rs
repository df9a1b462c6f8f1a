//! One contact that may bounce, out of its block: where it is, how fast it approaches, what it wants and
//! how an impulse acts on its bodies. See [`super::impact`].

use super::integrate::{Aux, three};
use super::rooms::Blocks;
use super::rows::{Extra, Line, Whitening};
use super::tally::ContactTally;
use crate::base::disjoint::Rows;
use crate::base::math::{Vec3, vec3};
use crate::base::wide::{LANES, Lanes, at, put};
use crate::state::bodies::Bodies;

/// Below this a point does not approach [m/s]: a hundred roundings of speeds of 10 m/s.
const STILL: f32 = 1.0e-4;

/// The solver's rows that impacts read and write.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source<'a> {
    pub(super) blocks: &'a Blocks<'a>,
    pub(super) extras: &'a Rows<'a, Extra>,
    pub(super) tallies: Option<&'a Rows<'a, ContactTally>>,
    pub(super) owners: &'a [[u32; LANES]],
    pub(super) lines: &'a Rows<'a, Line>,
    pub(super) aux: &'a Rows<'a, Aux>,
    pub(super) whitening: &'a Rows<'a, Whitening>,
    /// The step's time and a substep's.
    pub(super) dt: f32,
    pub(super) h: f32,
    /// Number of the group's first line; body row of line k + 1.
    pub(super) first_line: usize,
    pub(super) members: &'a [u32],
    pub(super) bodies: &'a Bodies,
}

/// When in the step, and how long.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moment {
    /// Substeps that positions have advanced, of how many.
    pub(super) done: u16,
    pub(super) substeps: u16,
    pub(super) h: f32,
    /// Velocities have the forces of the next substep already.
    pub(super) kicked: bool,
    /// Least speed of a bounce [m/s], and the greatest speed of push-out.
    pub(super) least: f32,
    pub(super) push: f32,
}

/// A contact that can bounce: where it stands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub(super) lines: [u32; 2],
    /// Its row.
    pub(super) contact: u32,
    pub(super) block: u32,
    pub(super) lane: u8,
    /// Its touch, once it has one.
    pub(super) touch: u32,
}

/// Most rounds that hit the same contact of one point, and of several: as many touching bodies can come
/// in to a row. More of them go to boxes that rattle on two edges, where friction and bounce feed each
/// other.
const HITS: [u8; 2] = [8, 3];

/// Rows of a touch, one a lane: the normals of up to four points, friction along two tangents, twist.
const FRICTION: usize = 4;
const ROWS: usize = 7;

/// A contact that can bounce, out of its block once it is looked at.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Touch {
    pub(super) lines: [u32; 2],
    /// Its row.
    pub(super) contact: u32,
    pub(super) block: u32,
    pub(super) lane: u8,
    count: u8,
    /// It was hit in this step, and how often in this substep.
    pub(super) bounced: bool,
    pub(super) hits: u8,
    /// Points that approach and meet within the substep, bits, and the speeds of all.
    pub(super) met: u8,
    pub(super) speed: [f32; 4],
    /// The pass that it was last placed in, counted from 1.
    placed: u32,
    /// One of the bodies is kinematic and moves.
    pub(super) driven: bool,
    /// `answer` is known.
    coupled: bool,
    n: Vec3,
    t: [Vec3; 2],
    alpha: f32,
    beta: f32,
    mu: f32,
    pub(super) e: f32,
    /// Relative acceleration along the normal, and a speed that gravity alone makes in a step.
    fall: f32,
    slow: f32,
    /// Speed that the contact's load makes in a substep.
    load: f32,
    /// How the rows turn A and B, and the speed that kinematic bodies give them: component, row.
    a: [Lanes; 3],
    b: [Lanes; 3],
    drift: Lanes,
    /// Masses that the points' rows feel, 0 where there is no point.
    pub(super) mass: [f32; 4],
    s0: [f32; 4],
    /// Separations now.
    s: [f32; 4],
    /// Impulses of this substep's impacts: normal and friction.
    given: [f32; 4],
    rubbed: [f32; 3],
    /// Inverse of the matrix of friction's rows, as in the block, and the step of what slides.
    mass_t: [f32; 6],
    mass_slide: f32,
    /// Kinetic friction as a part of static friction.
    kinetic: f32,
    /// What an impulse along a row adds to the speeds of all.
    answer: [Lanes; ROWS],
}

/// Speeds of a touch's rows in a blow, and the impulses along them that its bodies did not yet get.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Blow {
    pub(super) speed: Lanes,
    impulse: Lanes,
}

/// The products of rows with a vector.
#[inline(always)]
fn along(rows: &[Lanes; 3], v: Vec3) -> Lanes {
    core::array::from_fn(|l| rows[0][l] * v.x + rows[1][l] * v.y + rows[2][l] * v.z)
}

/// The sum of a row's vectors, each times a factor.
#[inline(always)]
fn combine(rows: &[Lanes; 3], factors: &Lanes) -> Vec3 {
    let sum = |row: &Lanes| {
        let p: Lanes = core::array::from_fn(|l| row[l] * factors[l]);
        ((p[0] + p[4]) + (p[1] + p[5])) + ((p[2] + p[6]) + (p[3] + p[7]))
    };
    vec3(sum(&rows[0]), sum(&rows[1]), sum(&rows[2]))
}

impl Touch {
    /// Not yet looked at.
    pub(super) fn new(entry: &Entry) -> Self {
        let Entry { lines, contact, block, lane, .. } = *entry;
        Self { lines, contact, block, lane, ..Self::default() }
    }

    fn load(&mut self, source: &Source<'_>) {
        let block = source.blocks.read(self.block as usize);
        let extra = source.extras.read(self.block as usize);
        let lane = usize::from(self.lane);
        (self.n, self.t) = (at(&block.n, lane), [at(&block.t1, lane), at(&block.t2, lane)]);
        (self.mu, self.e) = (block.mu[lane], extra.restitution[lane]);
        (self.fall, self.slow) = (extra.fall[lane], extra.slow[lane]);
        (self.mass_t, self.mass_slide) = (block.mass_t.map(|m| m[lane]), block.mass_slide[lane]);
        self.kinetic = if extra.slips { extra.kinetic[lane] } else { 1.0 };
        // Of a contact with a fixed body its rows are not filled.
        let free = self.lines.map(|line| line != 0);
        if free[0] {
            self.alpha = block.alpha[lane];
        }
        if free[1] {
            self.beta = block.beta[lane];
        }
        let mut row = |i: usize, a: &[Lanes; 3], b: &[Lanes; 3], drift: f32| {
            if free[0] {
                put(&mut self.a, i, at(a, lane));
            }
            if free[1] {
                put(&mut self.b, i, at(b, lane));
            }
            self.drift[i] = drift;
            self.driven |= drift != 0.0;
        };
        for i in 0..3 {
            row(FRICTION + i, &block.a_t[i], &block.b_t[i], extra.drift_t[i][lane]);
        }
        let points = block.points.iter().take(usize::from(block.count));
        for (j, p) in points.clone().enumerate() {
            row(j, &p.a, &p.b, extra.drift[j][lane]);
        }
        for ((number, j), p) in (1..).zip(0..).zip(points) {
            // The block has as many as its fullest lane: which that is must not show.
            if p.mass[lane] > 0.0 {
                self.count = number;
            }
            (self.mass[j], self.s0[j]) = (p.mass[lane], p.s0[lane]);
        }
    }

    /// Which of its points approach and meet within the substep, in this pass.
    pub(super) fn look(&mut self, source: &Source<'_>, moment: &Moment, pass: u32) {
        if self.placed == 0 {
            self.load(source);
        }
        if self.placed != pass {
            self.placed = pass;
            self.place(source, f32::from(moment.done) * moment.h);
        }
        self.met = 0;
        if self.hits < HITS[usize::from(self.count > 1)] {
            let [s0, s1, s2, s3, ..] = self.speeds(source);
            self.speed = [s0, s1, s2, s3];
            self.met = self.meets(moment);
        }
    }

    /// Separations and load at the start of a substep.
    fn place(&mut self, source: &Source<'_>, elapsed: f32) {
        let [a, b] = self.lines.map(|line| source.lines.read(line as usize));
        let moved = self.n.dot(three(b.x) * self.beta - three(a.x) * self.alpha);
        let (turned_a, turned_b) = (along(&self.a, three(a.t)), along(&self.b, three(b.t)));
        for j in 0..4 {
            self.s[j] = self.s0[j] + moved + turned_b[j] - turned_a[j] + self.drift[j] * elapsed;
        }
        let block = source.blocks.read(self.block as usize);
        let mut load = 0.0;
        for rows in &block.points[..usize::from(self.count)] {
            load += rows.impulse[usize::from(self.lane)];
        }
        self.load = load * (self.alpha * self.alpha + self.beta * self.beta);
        (self.given, self.rubbed, self.hits) = ([0.0; 4], [0.0; 3], 0);
    }

    /// Speeds of the rows: of points along the normal, negative while they approach.
    #[inline]
    fn speeds(&self, source: &Source<'_>) -> Lanes {
        let [a, b] = self.lines.map(|line| source.lines.read(line as usize));
        let slip = three(b.v) * self.beta - three(a.v) * self.alpha;
        let (u, u1, u2) = (self.n.dot(slip), self.t[0].dot(slip), self.t[1].dot(slip));
        let straight = [u, u, u, u, u1, u2, 0.0, 0.0];
        let (turn_a, turn_b) = (along(&self.a, three(a.w)), along(&self.b, three(b.w)));
        core::array::from_fn(|l| straight[l] + turn_b[l] - turn_a[l] + self.drift[l])
    }

    /// Nothing given yet.
    pub(super) fn blow(&self, source: &Source<'_>) -> Blow {
        Blow { speed: self.speeds(source), impulse: [0.0; LANES] }
    }

    /// The points that approach and meet within the substep: bits.
    #[inline]
    fn meets(&self, moment: &Moment) -> u8 {
        let mut met = 0;
        for j in 0..4 {
            let soon = self.s[j] + self.speed[j] * moment.h < 0.0;
            met |= u8::from(self.mass[j] > 0.0 && self.speed[j] < -STILL && soon) << j;
        }
        if met != 0 {
            let least = self.least(moment);
            for j in 0..4 {
                met &= !(u8::from(self.speed[j] >= -least) << j);
            }
        }
        met
    }

    /// Least speed at which it bounces. What carries a load rests, and its neighbors' push-out and the
    /// weight above it may move it.
    fn least(&self, moment: &Moment) -> f32 {
        let carried = (self.load * f32::from(moment.substeps)).min(moment.push);
        moment.least.max(self.slow).max(STILL) + carried
    }

    /// Speed of a point after the bounce over the one before: its energy at the surface, times e², less
    /// what it has at the place where it is, and what the substeps of this step lose of it.
    pub(super) fn gain(&self, j: usize, w: f32, moment: &Moment) -> f32 {
        // What rests is held against gravity.
        let fall = if self.load > 0.0 { 0.0 } else { self.fall };
        // In every velocity of the substep, of what bounced and was sent back too.
        let kick = if moment.kicked { fall * moment.h } else { 0.0 };
        let lost = if self.bounced { 0.0 } else { (fall * moment.h) * (fall * moment.h) };
        // What came in deep was not seen before; no deeper than it moves in a step.
        let s = self.s[j].max(w * moment.h * f32::from(moment.substeps));
        let height = 2.0 * fall * s;
        let before = (w - kick) * (w - kick) - height + lost * f32::from(moment.done);
        let after = self.e * self.e * before.max(0.0)
            + height
            + lost * f32::from(moment.substeps - moment.done);
        let gain = (kick + after.max(0.0).sqrt()).max(0.0) / -w;
        if s < 0.0 { gain.min(1.0) } else { gain }
    }

    /// Makes known what its rows answer: the products of each with all, whitened.
    pub(super) fn couple(&mut self) {
        if core::mem::replace(&mut self.coupled, true) {
            return;
        }
        let straight = self.alpha * self.alpha + self.beta * self.beta;
        for (i, answer) in self.answer.iter_mut().enumerate() {
            let (of_a, of_b) = (along(&self.a, at(&self.a, i)), along(&self.b, at(&self.b, i)));
            for (l, k) in answer.iter_mut().enumerate() {
                let same = if i < FRICTION { l < FRICTION } else { l == i && l < ROWS - 1 };
                *k = of_a[l] + of_b[l] + if same { straight } else { 0.0 };
            }
        }
    }

    /// An impulse along a row, in the blow alone.
    #[inline]
    fn act(&self, blow: &mut Blow, row: usize, d: f32) {
        blow.impulse[row] += d;
        for (speed, k) in blow.speed.iter_mut().zip(&self.answer[row]) {
            *speed += k * d;
        }
    }

    /// An impulse `d` along the normal at point `j`; gives its work [J].
    #[inline]
    pub(super) fn push(&mut self, blow: &mut Blow, j: usize, d: f32) -> f32 {
        let before = blow.speed[j];
        self.given[j] += d;
        self.act(blow, j, d);
        0.5 * d * (before + blow.speed[j])
    }

    /// Friction and twist in one limit, as in the sweep: that of the whole impulse of the bounce; gives their
    /// work [J].
    pub(super) fn rub(&mut self, blow: &mut Blow) -> f32 {
        let [g1, g2, g3, g4] = self.given;
        let limit = self.mu * (g1 + g2 + g3 + g4);
        if limit <= 0.0 {
            return 0.0;
        }
        let [.., s1, s2, s3, _] = blow.speed;
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
            self.act(blow, FRICTION + i, d);
        }
        let [.., r1, r2, r3, _] = blow.speed;
        0.5 * (d[0] * (s1 + r1) + d[1] * (s2 + r2) + d[2] * (s3 + r3))
    }

    /// Gives the impulses of a blow to the bodies. No later substep repeats them.
    pub(super) fn deliver(&self, blow: &Blow, source: &Source<'_>) {
        let d = &blow.impulse;
        if d.iter().all(|d| *d == 0.0) {
            return;
        }
        if let Some(tallies) = source.tallies {
            let (tally, lane) = (tallies.row(self.block as usize), usize::from(self.lane));
            for j in 0..4 {
                tally.points[j][lane] += d[j];
            }
            for (i, sum) in tally.rub.iter_mut().enumerate() {
                sum[lane] += d[FRICTION + i];
            }
        }
        let normal = (d[0] + d[1]) + (d[2] + d[3]);
        let linear = self.n * normal + (self.t[0] * d[4] + self.t[1] * d[5]);
        let [a, b] = self.lines.map(|line| line as usize);
        if a != 0 {
            let turn = -combine(&self.a, d);
            source.aux.row(a).strike(source.lines.row(a), linear * -self.alpha, turn);
        }
        if b != 0 {
            let turn = combine(&self.b, d);
            source.aux.row(b).strike(source.lines.row(b), linear * self.beta, turn);
        }
    }
}
