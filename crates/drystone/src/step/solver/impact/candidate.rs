//! One contact that may bounce, out of its block: where it is, how fast it approaches and what it wants. See
//! [`super::impact`].

use fearless_simd::Level;

use crate::base::math::Vec3;
use crate::base::simd::wide::{LANES, at};
use crate::base::threads::disjoint::Rows;
use crate::state::bodies::{Bodies, NONE};
use crate::step::solver::body::row::Aux;
use crate::step::solver::contact::arena::Blocks;
use crate::step::solver::contact::block::Extra;
use crate::step::solver_body::{SolverBody, Whitening, three};

/// Below this a point does not approach [m/s]: a hundred roundings of speeds of 10 m/s.
pub(crate) const STILL: f32 = 1.0e-4;

/// The solver's rows that impacts read and write.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Source<'a> {
    pub(crate) level: Level,
    pub(crate) blocks: &'a Blocks<'a>,
    pub(crate) extras: Option<&'a Rows<'a, Extra>>,
    pub(crate) owners: &'a [[u32; LANES]],
    pub(crate) lines: &'a Rows<'a, SolverBody>,
    pub(crate) aux: &'a Rows<'a, Aux>,
    pub(crate) whitening: &'a Rows<'a, Whitening>,
    /// Acceleration of each line [m/s²].
    pub(crate) acceleration: &'a Rows<'a, Vec3>,
    /// The step's time and a substep's.
    pub(crate) dt: f32,
    pub(crate) h: f32,
    /// Number of the group's first line; body row of line k + 1.
    pub(crate) first_line: usize,
    pub(crate) members: &'a [u32],
    pub(crate) bodies: &'a Bodies,
}

impl Source<'_> {
    /// What few contacts have, of a block.
    #[inline]
    pub(crate) fn extra(&self, block: usize) -> Option<&Extra> {
        self.extras.map(|extras| extras.read(block))
    }

    /// True if impacts reflect or stop a lane. What does not bounce and is a spring of its own, or on a joint, is left to the sweep.
    pub(crate) fn takes_part(&self, block: usize, lane: usize) -> bool {
        if self.restitution(block, lane) > 0.0 {
            return true;
        }
        let rows = self.blocks.read(block);
        let ends = [rows.row_a[lane], rows.row_b[lane]].into_iter().filter(|line| *line != 0);
        let mut bodies = ends.map(|line| self.bodies.at(self.members[line as usize - 1]));
        !self.extra(block).is_some_and(|extra| extra.softens && extra.soft_mass[lane] > 0.0)
            && bodies.all(|body| body.joints.is_empty())
    }

    /// Coefficient of restitution of a lane.
    #[inline]
    fn restitution(&self, block: usize, lane: usize) -> f32 {
        self.extra(block).map_or(0.0, |extra| extra.restitution[lane])
    }
}

/// When in the step, and how long.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moment {
    /// Substeps that positions have advanced, of how many.
    pub(crate) done: u16,
    pub(crate) substeps: u16,
    pub(crate) h: f32,
    /// Velocities have the forces of the next substep already.
    pub(crate) kicked: bool,
    /// Least speed of a bounce [m/s], and the greatest speed of push-out.
    pub(crate) least: f32,
    pub(crate) push: f32,
    /// Least speed of a blow at a contact that does not bounce [m/s].
    pub(crate) blow: f32,
    /// See [`STILL`].
    pub(crate) still: f32,
}

/// One point that approaches.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Hit {
    pub(crate) candidate: u32,
    pub(crate) lines: [u32; 2],
    /// Once the candidate has one, and whether this hit is the first for which it has.
    pub(crate) response: u32,
    pub(crate) fresh: bool,
    /// Row of the contact.
    pub(crate) contact: u32,
    pub(crate) point: u8,
    pub(crate) e: f32,
    /// Speed after over speed before.
    pub(crate) gain: f32,
    pub(crate) speed: f32,
    pub(crate) impulse: f32,
    /// Approach that stays, of what does not bounce: it comes as far as the surface [m/s].
    pub(crate) keeps: f32,
    /// Hits that bodies link have the same: the number of the first of them.
    pub(crate) part: u32,
}

/// A contact that can bounce: where it stands.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    pub(crate) lines: [u32; 2],
    pub(crate) block: u32,
    pub(crate) lane: u8,
    /// Where it stands among the contacts around its lines; of one that is none there is no place.
    pub(crate) places: [u32; 2],
}

/// Most rounds that hit the same contact of one point, and of several: as many touching bodies can come
/// in to a row. More of them go to boxes that rattle on two edges, where friction and bounce feed each
/// other.
const HITS: [u8; 2] = [8, 3];

/// Most rounds that hit the same contact if it does not bounce: a blow takes turns between a body and what it rests on, and loses a part
/// in each.
const BLOWS: u8 = 24;

/// A contact that can bounce, out of its block once it is looked at: what a look reads, in three cache lines.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct Candidate {
    pub(crate) lines: [u32; 2],
    pub(crate) block: u32,
    pub(crate) lane: u8,
    /// Its points, bits.
    points: u8,
    /// How often it was hit in this substep.
    pub(crate) hits: u8,
    most_hits: u8,
    /// Speeds of all points along the normal when it was last looked at.
    speed: [f32; 4],
    /// The same before any impact of this pass.
    before: [f32; 4],
    /// Separations at the step's start, and now.
    s0: [f32; 4],
    s: [f32; 4],
    /// How the points' rows turn A and B: component, point.
    pub(crate) a: [[f32; 4]; 3],
    pub(crate) b: [[f32; 4]; 3],
    pub(crate) n: Vec3,
    pub(crate) alpha: f32,
    pub(crate) beta: f32,
    /// Its response, once it was hit in this step.
    pub(crate) response: u32,
    /// Least speed at which it bounces without a load.
    least: f32,
    /// The same after a blow that it does not bounce off, for what was left of the gap: twice what forces give in a substep.
    follows: f32,
    /// The pass that it was last placed in, counted from 1.
    placed: u16,
    /// A kinematic body gives its points speed.
    drifts: bool,
    bounces: bool,
    /// Its points that meet before any impact of this pass, and all of one that bounces: bits.
    own: u8,
}

/// The products of four points' rows with a vector.
#[inline(always)]
fn along(rows: &[[f32; 4]; 3], v: Vec3) -> [f32; 4] {
    core::array::from_fn(|l| rows[0][l] * v.x + rows[1][l] * v.y + rows[2][l] * v.z)
}

impl Candidate {
    /// Becomes that of a contact that is not yet looked at: what is left of another one goes with [`Self::load`].
    pub(crate) fn restart(&mut self, entry: &Entry) {
        let Entry { lines, block, lane, .. } = *entry;
        (self.lines, self.block, self.lane, self.placed) = (lines, block, lane, 0);
    }

    fn load(&mut self, source: &Source<'_>, moment: &Moment) {
        let Self { lines, block, lane, .. } = *self;
        *self = Self { lines, block, lane, response: NONE, ..Self::default() };
        let block = source.blocks.read(self.block as usize);
        let lane = usize::from(self.lane);
        self.n = at(&block.n, lane);
        // Of a contact with a fixed body its rows are not filled.
        let [of_a, of_b] = self.lines.map(|line| line != 0);
        if of_a {
            self.alpha = block.alpha[lane];
        }
        if of_b {
            self.beta = block.beta[lane];
        }
        let points = block.points.iter().take(usize::from(block.count));
        for (j, p) in points.enumerate() {
            // The block has as many as its fullest lane: which that is must not show.
            self.points |= u8::from(p.mass[lane] > 0.0) << j;
            self.s0[j] = p.s0[lane];
            for i in 0..3 {
                if of_a {
                    self.a[i][j] = p.a[i][lane];
                }
                if of_b {
                    self.b[i][j] = p.b[i][lane];
                }
            }
        }
        let extra = source.extra(self.block as usize);
        self.drifts = extra.is_some_and(|extra| extra.drifts);
        self.bounces = source.restitution(self.block as usize, lane) > 0.0;
        self.most_hits = if self.bounces { HITS[usize::from(self.points > 1)] } else { BLOWS };
        let least = if self.bounces {
            moment.least.max(extra.map_or(0.0, |extra| extra.slow[lane]))
        } else {
            let along = |line: u32| self.n.dot(*source.acceleration.read(line as usize)).abs();
            let along = along(self.lines[0]).max(along(self.lines[1]));
            self.follows = (2.0 * along * moment.h).max(moment.still);
            moment.blow.max(along * source.dt)
        };
        self.least = least.max(moment.still);
    }

    /// Speeds of the points along the normal that come from kinematic bodies.
    fn drift(&self, source: &Source<'_>) -> [f32; 4] {
        let extra = if self.drifts { source.extra(self.block as usize) } else { None };
        let Some(extra) = extra else { return [0.0; 4] };
        extra.drift.map(|drift| drift[usize::from(self.lane)])
    }

    /// Asks for the lines that a look reads.
    #[inline]
    pub(crate) fn ask(&self, source: &Source<'_>) {
        self.lines.into_iter().for_each(|line| source.lines.prefetch(line as usize, 1));
    }

    /// Which of its points approach and meet within the substep, in this pass: bits.
    pub(crate) fn look(&mut self, source: &Source<'_>, moment: &Moment, pass: u16) -> u8 {
        let is_new = || source.blocks.read(self.block as usize).is_renewed;
        if self.placed == 0 || (self.placed != pass && is_new()) {
            self.load(source, moment);
        }
        let is_first = self.placed != pass;
        if is_first {
            self.placed = pass;
            self.place(source, f32::from(moment.done) * moment.h);
        }
        if self.hits >= self.most_hits {
            return 0;
        }
        self.speed = self.speeds(source);
        let met = self.meets(source, moment);
        if is_first {
            self.before = self.speed;
            self.own = if self.bounces { self.points } else { met };
            return met;
        }
        (met & self.own) | self.pressed(moment)
    }

    /// Points that only impacts around them press, bits: what rests on something that is hit.
    fn pressed(&self, moment: &Moment) -> u8 {
        let mut pressed = 0;
        for j in 0..4 {
            pressed |= u8::from(self.speed[j] + self.keeps(moment, j) < -self.follows) << j;
        }
        pressed & self.points & !self.own
    }

    /// Approach that a hit leaves to a point: what closes its gap, and what it had before if only impacts around it press it. That is
    /// its load's.
    fn keeps(&self, moment: &Moment, j: usize) -> f32 {
        let kept = self.kept(moment, j);
        if self.own >> j & 1 == 1 { kept } else { kept.max(-self.before[j]) }
    }

    /// Separations at the start of a substep.
    fn place(&mut self, source: &Source<'_>, elapsed: f32) {
        let [a, b] = self.lines.map(|line| source.lines.read(line as usize));
        let moved = self.n.dot(three(b.x) * self.beta - three(a.x) * self.alpha);
        let (turned_a, turned_b) = (along(&self.a, three(a.t)), along(&self.b, three(b.t)));
        let drift = self.drift(source);
        for j in 0..4 {
            self.s[j] = self.s0[j] + moved + turned_b[j] - turned_a[j] + drift[j] * elapsed;
        }
        self.hits = 0;
    }

    /// Speeds of the points along the normal, negative while they approach.
    #[inline]
    fn speeds(&self, source: &Source<'_>) -> [f32; 4] {
        let [a, b] = self.lines.map(|line| source.lines.read(line as usize));
        let u = self.n.dot(three(b.v) * self.beta - three(a.v) * self.alpha);
        let (turn_a, turn_b) = (along(&self.a, three(a.w)), along(&self.b, three(b.w)));
        let drift = self.drift(source);
        core::array::from_fn(|l| u + turn_b[l] - turn_a[l] + drift[l])
    }

    /// The points that approach and meet within the substep, faster than what rests: bits. Of what does not bounce, those that
    /// approach faster by a blow than brings them to the surface.
    #[inline]
    fn meets(&self, source: &Source<'_>, moment: &Moment) -> u8 {
        let faster = |least: f32| {
            let mut met = 0;
            for j in 0..4 {
                let is_hit = if self.bounces {
                    self.speed[j] < -least && self.s[j] + self.speed[j] * moment.h < 0.0
                } else {
                    self.speed[j] + self.kept(moment, j) < -least
                };
                met |= u8::from(is_hit) << j;
            }
            met & self.points
        };
        let is_first = self.bounces || self.response == NONE;
        let least = if is_first { self.least } else { self.follows };
        if faster(least) == 0 {
            return 0;
        }
        // What carries a load rests, and its neighbors' push-out and the weight above it may move it.
        let carried = (self.carried(source) * f32::from(moment.substeps)).min(moment.push);
        faster(least + carried)
    }

    /// Approach that closes the gap of a point in the substep [m/s].
    fn kept(&self, moment: &Moment, j: usize) -> f32 {
        self.s[j].max(0.0) / moment.h
    }

    /// Speed that the contact's load makes in a substep.
    fn carried(&self, source: &Source<'_>) -> f32 {
        let block = source.blocks.read(self.block as usize);
        let mut load = 0.0;
        for rows in &block.points[..(u8::BITS - self.points.leading_zeros()) as usize] {
            load += rows.impulse[usize::from(self.lane)];
        }
        load * (self.alpha * self.alpha + self.beta * self.beta)
    }

    /// Fills in what a hit of one of its points needs.
    pub(crate) fn tell(&self, source: &Source<'_>, moment: &Moment, hit: &mut Hit) {
        let (block, lane) = (self.block as usize, usize::from(self.lane));
        let point = usize::from(hit.point);
        (hit.lines, hit.response) = (self.lines, self.response);
        hit.contact = source.owners[block][lane];
        hit.e = source.restitution(block, lane);
        hit.speed = self.speed[point];
        if hit.e > 0.0 {
            hit.gain = self.gain(source, moment, hit.e, point);
        } else {
            hit.keeps = self.keeps(moment, point);
        }
    }

    /// Speed of a point after the bounce over the one before: its energy at the surface, times e², less
    /// what it has at the place where it is, and what the substeps of this step lose of it.
    fn gain(&self, source: &Source<'_>, moment: &Moment, e: f32, j: usize) -> f32 {
        let w = self.speed[j];
        let lane = usize::from(self.lane);
        let fall = source.extra(self.block as usize).map_or(0.0, |extra| extra.fall[lane]);
        // What rests is held against gravity.
        let fall = if self.carried(source) > 0.0 { 0.0 } else { fall };
        // In every velocity of the substep, of what bounced and was sent back too.
        let kick = if moment.kicked { fall * moment.h } else { 0.0 };
        let bounced = self.response != NONE;
        let lost = if bounced { 0.0 } else { (fall * moment.h) * (fall * moment.h) };
        // What came in deep was not seen before; no deeper than it moves in a step.
        let s = self.s[j].max(w * moment.h * f32::from(moment.substeps));
        let height = 2.0 * fall * s;
        let before = (w - kick) * (w - kick) - height + lost * f32::from(moment.done);
        let after =
            e * e * before.max(0.0) + height + lost * f32::from(moment.substeps - moment.done);
        let gain = (kick + after.max(0.0).sqrt()).max(0.0) / -w;
        if s < 0.0 { gain.min(1.0) } else { gain }
    }
}
