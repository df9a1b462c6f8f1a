//! One contact that may bounce, out of its block: where it is, how fast it approaches, what it wants and
//! how an impulse acts on its bodies. See [`super::impact`].

use super::integrate::Aux;
use super::rooms::Blocks;
use super::rows::{Extra, Line, Whitening};
use super::tally::ContactTally;
use crate::base::disjoint::Rows;
use crate::base::math::{Vec3, vec3};
use crate::base::wide::{LANES, Lanes};
use crate::state::bodies::{Bodies, NONE};

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
    pub(super) block: u32,
    pub(super) lane: u8,
    pub(super) taken: bool,
}

#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PointRow {
    pub(super) a: Vec3,
    pub(super) b: Vec3,
    pub(super) mass: f32,
    pub(super) s0: f32,
    pub(super) drift: f32,
    /// Separation now.
    pub(super) s: f32,
    /// Impulse of this substep's impacts.
    pub(super) given: f32,
}

/// A contact that can bounce, out of its block.
#[derive(Clone, Copy, Debug)]
pub(super) struct Touch {
    pub(super) lines: [u32; 2],
    pub(super) block: u32,
    pub(super) lane: u8,
    pub(super) count: u8,
    /// The next touch of the island.
    pub(super) next: u32,
    /// When it was last looked at.
    pub(super) seen: u32,
    /// It was hit in this step, and how often in this substep.
    pub(super) bounced: bool,
    pub(super) hits: u8,
    /// One of the bodies is kinematic and moves.
    pub(super) driven: bool,
    pub(super) n: Vec3,
    pub(super) alpha: f32,
    pub(super) beta: f32,
    pub(super) mu: f32,
    pub(super) e: f32,
    /// Relative acceleration along the normal, and a speed that gravity alone makes in a step.
    pub(super) fall: f32,
    pub(super) slow: f32,
    /// Speed that the contact's load makes in a substep.
    pub(super) load: f32,
    pub(super) points: [PointRow; 4],
    pub(super) t: [Vec3; 2],
    pub(super) a_t: [Vec3; 3],
    pub(super) b_t: [Vec3; 3],
    /// Inverse of the matrix of friction's rows, as in the block, and the step of what slides.
    pub(super) mass_t: [f32; 6],
    pub(super) mass_slide: f32,
    /// Kinetic friction as a part of static friction.
    pub(super) kinetic: f32,
    pub(super) drift_t: [f32; 3],
    pub(super) rubbed: [f32; 3],
}

#[inline(always)]
fn lane3(lanes: &[Lanes; 3], lane: usize) -> Vec3 {
    vec3(lanes[0][lane], lanes[1][lane], lanes[2][lane])
}

#[inline(always)]
fn three(v: &[f32; 4]) -> Vec3 {
    vec3(v[0], v[1], v[2])
}

impl Touch {
    pub(super) fn load(source: &Source<'_>, entry: &Entry) -> Self {
        let block = source.blocks.read(entry.block as usize);
        let extra = source.extras.read(entry.block as usize);
        let lane = usize::from(entry.lane);
        // Of a contact with a fixed body the rows of A are not filled.
        let free = entry.lines[0] != 0;
        let of_a = |lanes: &[Lanes; 3]| if free { lane3(lanes, lane) } else { Vec3::ZERO };
        let mut touch = Self {
            lines: entry.lines,
            block: entry.block,
            lane: entry.lane,
            count: 0,
            next: NONE,
            seen: 0,
            bounced: false,
            hits: 0,
            driven: false,
            n: lane3(&block.n, lane),
            alpha: if free { block.alpha[lane] } else { 0.0 },
            beta: block.beta[lane],
            mu: block.mu[lane],
            e: extra.restitution[lane],
            fall: extra.fall[lane],
            slow: extra.slow[lane],
            load: 0.0,
            points: [PointRow::default(); 4],
            t: [lane3(&block.t1, lane), lane3(&block.t2, lane)],
            a_t: [of_a(&block.a_t[0]), of_a(&block.a_t[1]), of_a(&block.a_t[2])],
            b_t: [
                lane3(&block.b_t[0], lane),
                lane3(&block.b_t[1], lane),
                lane3(&block.b_t[2], lane),
            ],
            mass_t: [0.0; 6],
            mass_slide: block.mass_slide[lane],
            kinetic: if extra.slips { extra.kinetic[lane] } else { 1.0 },
            drift_t: [0.0; 3],
            rubbed: [0.0; 3],
        };
        for i in 0..6 {
            touch.mass_t[i] = block.mass_t[i][lane];
        }
        for i in 0..3 {
            touch.drift_t[i] = extra.drift_t[i][lane];
            touch.driven |= touch.drift_t[i] != 0.0;
        }
        let points = block.points.iter().take(usize::from(block.count));
        for ((number, j), p) in (1..).zip(0..).zip(points) {
            // The block has as many as its fullest lane: which that is must not show.
            if p.mass[lane] > 0.0 {
                touch.count = number;
            }
            touch.points[j] = PointRow {
                a: of_a(&p.a),
                b: lane3(&p.b, lane),
                mass: p.mass[lane],
                s0: p.s0[lane],
                drift: extra.drift[j][lane],
                s: 0.0,
                given: 0.0,
            };
            touch.driven |= touch.points[j].drift != 0.0;
        }
        touch
    }

    /// Separations and load at the start of a substep.
    pub(super) fn place(&mut self, source: &Source<'_>, elapsed: f32) {
        let [a, b] = self.lines.map(|line| source.lines.read(line as usize));
        let moved = self.n.dot(three(&b.x) * self.beta - three(&a.x) * self.alpha);
        let (ta, tb) = (three(&a.t), three(&b.t));
        let block = source.blocks.read(self.block as usize);
        let mut load = 0.0;
        for (p, rows) in self.points[..usize::from(self.count)].iter_mut().zip(&block.points) {
            p.s = p.s0 + moved + p.b.dot(tb) - p.a.dot(ta) + p.drift * elapsed;
            p.given = 0.0;
            load += rows.impulse[usize::from(self.lane)];
        }
        self.load = load * (self.alpha * self.alpha + self.beta * self.beta);
        self.rubbed = [0.0; 3];
        (self.seen, self.hits) = (0, 0);
    }

    /// Speed of point `j` along the normal, negative while it approaches.
    #[inline]
    pub(super) fn speed(&self, j: usize, lines: &Rows<'_, Line>) -> f32 {
        let [a, b] = self.lines.map(|line| lines.read(line as usize));
        let p = &self.points[j];
        let u = self.n.dot(three(&b.v) * self.beta - three(&a.v) * self.alpha);
        u + p.b.dot(three(&b.w)) - p.a.dot(three(&a.w)) + p.drift
    }

    /// Least speed at which it bounces. What carries a load rests, and its neighbors' push-out and the
    /// weight above it may move it.
    pub(super) fn least(&self, moment: &Moment) -> f32 {
        let carried = (self.load * f32::from(moment.substeps)).min(moment.push);
        moment.least.max(self.slow).max(STILL) + carried
    }

    /// Speed of a point after the bounce over the one before: its energy at the surface, times e², less
    /// what it has at the place where it is, and what the substeps of this step lose of it.
    pub(super) fn gain(&self, j: usize, w: f32, moment: &Moment) -> f32 {
        // What rests is held against gravity.
        let fall = if self.load > 0.0 { 0.0 } else { self.fall };
        let p = &self.points[j];
        // In every velocity of the substep, of what bounced and was sent back too.
        let kick = if moment.kicked { fall * moment.h } else { 0.0 };
        let lost = if self.bounced { 0.0 } else { (fall * moment.h) * (fall * moment.h) };
        // What came in deep was not seen before; no deeper than it moves in a step.
        let s = p.s.max(w * moment.h * f32::from(moment.substeps));
        let height = 2.0 * fall * s;
        let before = (w - kick) * (w - kick) - height + lost * f32::from(moment.done);
        let after = self.e * self.e * before.max(0.0)
            + height
            + lost * f32::from(moment.substeps - moment.done);
        let gain = (kick + after.max(0.0).sqrt()).max(0.0) / -w;
        if s < 0.0 { gain.min(1.0) } else { gain }
    }

    /// An impulse `d` along the normal at point `j`; gives its work [J].
    pub(super) fn push(&mut self, j: usize, d: f32, source: &Source<'_>) -> f32 {
        let p = &mut self.points[j];
        p.given += d;
        let (a, b) = (p.a, p.b);
        if let Some(tallies) = source.tallies {
            tallies.row(self.block as usize).points[j][usize::from(self.lane)] += d;
        }
        self.apply(self.n * d, a * d, b * d, source)
    }

    /// A linear impulse, and what turns A and B; gives its work [J]. No later substep repeats it.
    fn apply(&self, linear: Vec3, turn_a: Vec3, turn_b: Vec3, source: &Source<'_>) -> f32 {
        let [a, b] = self.lines.map(|line| line as usize);
        let mut work = 0.0;
        if a != 0 {
            work += source.aux.row(a).strike(source.lines.row(a), linear * -self.alpha, -turn_a);
        }
        if b != 0 {
            work += source.aux.row(b).strike(source.lines.row(b), linear * self.beta, turn_b);
        }
        work
    }

    /// Friction and twist in one limit, as in the sweep: that of the whole impulse of the bounce; gives their
    /// work [J].
    pub(super) fn rub(&mut self, source: &Source<'_>) -> f32 {
        let mut limit = 0.0;
        for p in &self.points[..usize::from(self.count)] {
            limit += self.mu * p.given;
        }
        if limit <= 0.0 {
            return 0.0;
        }
        let [a, b] = self.lines.map(|line| source.lines.read(line as usize));
        let slip = three(&b.v) * self.beta - three(&a.v) * self.alpha;
        let (wa, wb) = (three(&a.w), three(&b.w));
        let turn = |i: usize| self.b_t[i].dot(wb) - self.a_t[i].dot(wa) + self.drift_t[i];
        let s1 = self.t[0].dot(slip) + turn(0);
        let s2 = self.t[1].dot(slip) + turn(1);
        let s3 = turn(2);
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
        let (d1, d2, d3) = (g1 - f1, g2 - f2, g3 - f3);
        self.rubbed = [g1, g2, g3];
        if let Some(tallies) = source.tallies {
            for (sum, d) in tallies.row(self.block as usize).rub.iter_mut().zip([d1, d2]) {
                sum[usize::from(self.lane)] += d;
            }
        }
        let turn = |rows: &[Vec3; 3]| rows[0] * d1 + rows[1] * d2 + rows[2] * d3;
        let linear = self.t[0] * d1 + self.t[1] * d2;
        self.apply(linear, turn(&self.a_t), turn(&self.b_t), source)
    }
}
