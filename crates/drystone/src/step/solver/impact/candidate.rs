//! A contact that may bounce, copied from its block: computes which of its points approach and
//! meet, and their speed after the impact. See [`super::impact`].

use fearless_simd::Level;

use crate::base::math::Vec3;
use crate::base::simd::wide::{LANES, at};
use crate::base::threads::disjoint::{ReadRows, Rows};
use crate::state::bodies::{Bodies, NONE};
use crate::step::solver::body::row::Aux;
use crate::step::solver::contact::arena::Blocks;
use crate::step::solver::contact::block::Extra;
use crate::step::solver_body::{SolverBody, Whitening, three};

/// Speed below which a point does not approach [m/s]: a hundred rounding errors of speeds of 10
/// m/s.
pub(crate) const STILL: f32 = 1.0e-4;

/// The solver's rows that impacts read and write.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Source<'a> {
    pub(crate) level: Level,
    pub(crate) blocks: &'a Blocks<'a>,
    pub(crate) extras: Option<&'a ReadRows<'a, Extra>>,
    pub(crate) owners: &'a [[u32; LANES]],
    pub(crate) solver_bodies: &'a Rows<'a, SolverBody>,
    pub(crate) aux: &'a Rows<'a, Aux>,
    pub(crate) whitening: &'a ReadRows<'a, Whitening>,
    /// Acceleration of each solver body [m/s²].
    pub(crate) acceleration: &'a ReadRows<'a, Vec3>,
    /// Duration of the step and of a substep.
    pub(crate) dt: f32,
    pub(crate) h: f32,
    /// Number of the group's first solver body; body row of solver body k + 1.
    pub(crate) first_row: usize,
    pub(crate) members: &'a [u32],
    pub(crate) bodies: &'a Bodies,
}

impl Source<'_> {
    /// The optional data of a block.
    #[inline]
    pub(crate) fn extra(&self, block: usize) -> Option<&Extra> {
        self.extras.map(|extras| extras.read(block))
    }

    /// True if impacts reflect or stop a lane. A contact without bounce that has its own spring
    /// softness, or a body on a joint, is left to the sweep.
    pub(crate) fn takes_part(&self, block: usize, lane: usize) -> bool {
        if self.restitution(block, lane) > 0.0 {
            return true;
        }
        let rows = self.blocks.read(block);
        let ends =
            [rows.row_a[lane], rows.row_b[lane]].into_iter().filter(|solver_row| *solver_row != 0);
        let mut bodies =
            ends.map(|solver_row| self.bodies.at(self.members[solver_row as usize - 1]));
        !self.extra(block).is_some_and(|extra| extra.softens && extra.soft_mass[lane] > 0.0)
            && bodies.all(|body| body.ties.joints.is_empty())
    }

    /// Coefficient of restitution of a lane.
    #[inline]
    fn restitution(&self, block: usize, lane: usize) -> f32 {
        self.extra(block).map_or(0.0, |extra| extra.restitution[lane])
    }
}

/// Time in the step, and thresholds of impacts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moment {
    /// Substeps by which positions have advanced, and the number of substeps.
    pub(crate) done: u16,
    pub(crate) substeps: u16,
    pub(crate) h: f32,
    /// Velocities already contain the forces of the next substep.
    pub(crate) kicked: bool,
    /// Minimum speed of a bounce [m/s], and maximum speed of push-out.
    pub(crate) minimum: f32,
    pub(crate) push: f32,
    /// Minimum speed of an impact at a contact that does not bounce [m/s].
    pub(crate) impact_speed: f32,
    /// See [`STILL`].
    pub(crate) still: f32,
}

/// One approaching point.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Hit {
    pub(crate) candidate: u32,
    pub(crate) solver_rows: [u32; 2],
    /// Index of the candidate's response, if it has one, and whether this hit is the first to use
    /// it.
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
    /// Approach speed that remains at a contact without bounce: it closes the gap to the surface
    /// [m/s].
    pub(crate) keeps: f32,
    /// Number of the first hit in the set: hits linked by bodies form one set.
    pub(crate) part: u32,
}

/// Place of a contact that can bounce.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    pub(crate) solver_rows: [u32; 2],
    pub(crate) block: u32,
    pub(crate) lane: u8,
    /// Places in the lists of contacts around its solver bodies; [`NONE`] for a missing solver
    /// body.
    pub(crate) places: [u32; 2],
}

/// Maximum rounds that hit the same contact, with one point and with several. A row of up to this
/// number of touching bodies can arrive at it. More rounds would serve only boxes that rattle on
/// two edges, where friction and bounce feed each other.
const HITS: [u8; 2] = [8, 3];

/// Maximum rounds that hit the same contact if it does not bounce. Such an impact alternates
/// between a body and its support, and loses a part in each round.
const HITS_WITHOUT_BOUNCE: u8 = 24;

/// A contact that can bounce, copied from its block at the first evaluation. An evaluation reads
/// three cache lines.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct Candidate {
    pub(crate) solver_rows: [u32; 2],
    pub(crate) block: u32,
    pub(crate) lane: u8,
    /// Bits of its points.
    points: u8,
    /// Number of hits in this substep.
    pub(crate) hits: u8,
    max_hits: u8,
    /// Speeds of all points along the normal at the last evaluation.
    speed: [f32; 4],
    /// Speeds before any impact of this pass.
    before: [f32; 4],
    /// Separations at the step's start, and now.
    s0: [f32; 4],
    s: [f32; 4],
    /// Angular rows of the points for A and B: component, point.
    pub(crate) a: [[f32; 4]; 3],
    pub(crate) b: [[f32; 4]; 3],
    pub(crate) n: Vec3,
    pub(crate) alpha: f32,
    pub(crate) beta: f32,
    /// Its response, after it was hit in this step.
    pub(crate) response: u32,
    /// Minimum speed at which it bounces without a load.
    minimum: f32,
    /// Minimum speed after an impact without bounce, for closing the rest of the gap: twice the
    /// speed that forces add in a substep.
    follows: f32,
    /// The last pass in which its separations were computed, counted from 1.
    placed: u16,
    /// A kinematic body gives its points speed.
    drifts: bool,
    bounces: bool,
    /// Bits of the points that meet before any impact of this pass; all points of a contact that
    /// bounces.
    own: u8,
}

/// The products of four points' rows with a vector.
#[inline(always)]
fn along(rows: &[[f32; 4]; 3], v: Vec3) -> [f32; 4] {
    core::array::from_fn(|l| rows[0][l] * v.x + rows[1][l] * v.y + rows[2][l] * v.z)
}

impl Candidate {
    /// Reuses the memory for another contact, whose data [`Self::load`] fills at the first
    /// evaluation.
    pub(crate) fn restart(&mut self, entry: &Entry) {
        let Entry { solver_rows, block, lane, .. } = *entry;
        (self.solver_rows, self.block, self.lane, self.placed) = (solver_rows, block, lane, 0);
    }

    fn load(&mut self, source: &Source<'_>, moment: &Moment) {
        let Self { solver_rows, block, lane, .. } = *self;
        *self = Self { solver_rows, block, lane, response: NONE, ..Self::default() };
        let block = source.blocks.read(self.block as usize);
        let lane = usize::from(self.lane);
        self.n = at(&block.n, lane);
        // In a contact with a fixed body, that body's rows are not filled.
        let [of_a, of_b] = self.solver_rows.map(|solver_row| solver_row != 0);
        if of_a {
            self.alpha = block.alpha[lane];
        }
        if of_b {
            self.beta = block.beta[lane];
        }
        let points = block.points.iter().take(usize::from(block.count));
        for (j, p) in points.enumerate() {
            // The block has the point count of its fullest lane, which must not affect this
            // contact.
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
        self.max_hits =
            if self.bounces { HITS[usize::from(self.points > 1)] } else { HITS_WITHOUT_BOUNCE };
        let minimum = if self.bounces {
            moment.minimum.max(extra.map_or(0.0, |extra| extra.slow[lane]))
        } else {
            let along =
                |solver_row: u32| self.n.dot(*source.acceleration.read(solver_row as usize)).abs();
            let along = along(self.solver_rows[0]).max(along(self.solver_rows[1]));
            self.follows = (2.0 * along * moment.h).max(moment.still);
            moment.impact_speed.max(along * source.dt)
        };
        self.minimum = minimum.max(moment.still);
    }

    /// Speeds of the points along the normal that kinematic bodies cause.
    fn drift(&self, source: &Source<'_>) -> [f32; 4] {
        let extra = if self.drifts { source.extra(self.block as usize) } else { None };
        let Some(extra) = extra else { return [0.0; 4] };
        extra.drift.map(|drift| drift[usize::from(self.lane)])
    }

    /// Prefetches the solver bodies for an evaluation.
    #[inline]
    pub(crate) fn prefetch(&self, source: &Source<'_>) {
        self.solver_rows
            .into_iter()
            .for_each(|solver_row| source.solver_bodies.prefetch(solver_row as usize, 1));
    }

    /// Bits of the points that approach and meet within the substep, in this pass.
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
        if self.hits >= self.max_hits {
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

    /// Bits of the points that only surrounding impacts press: contacts of bodies that rest on a
    /// body that is hit.
    fn pressed(&self, moment: &Moment) -> u8 {
        let mut pressed = 0;
        for j in 0..4 {
            pressed |= u8::from(self.speed[j] + self.keeps(moment, j) < -self.follows) << j;
        }
        pressed & self.points & !self.own
    }

    /// Approach speed that remains at a point after a hit: the speed that closes its gap. If only
    /// surrounding impacts press the point, it is at least the speed before them, which belongs to
    /// its load.
    fn keeps(&self, moment: &Moment, j: usize) -> f32 {
        let kept = self.kept(moment, j);
        if self.own >> j & 1 == 1 { kept } else { kept.max(-self.before[j]) }
    }

    /// Computes the separations at the start of a substep.
    fn place(&mut self, source: &Source<'_>, elapsed: f32) {
        let [a, b] =
            self.solver_rows.map(|solver_row| source.solver_bodies.read(solver_row as usize));
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
        let [a, b] =
            self.solver_rows.map(|solver_row| source.solver_bodies.read(solver_row as usize));
        let u = self.n.dot(three(b.v) * self.beta - three(a.v) * self.alpha);
        let (turn_a, turn_b) = (along(&self.a, three(a.w)), along(&self.b, three(b.w)));
        let drift = self.drift(source);
        core::array::from_fn(|l| u + turn_b[l] - turn_a[l] + drift[l])
    }

    /// Bits of the points that approach and meet within the substep, faster than a resting contact.
    /// In a contact without bounce: points whose approach exceeds the gap's closing speed by that
    /// of an impact.
    #[inline]
    fn meets(&self, source: &Source<'_>, moment: &Moment) -> u8 {
        let faster = |minimum: f32| {
            let mut met = 0;
            for j in 0..4 {
                let is_hit = if self.bounces {
                    self.speed[j] < -minimum && self.s[j] + self.speed[j] * moment.h < 0.0
                } else {
                    self.speed[j] + self.kept(moment, j) < -minimum
                };
                met |= u8::from(is_hit) << j;
            }
            met & self.points
        };
        let is_first = self.bounces || self.response == NONE;
        let minimum = if is_first { self.minimum } else { self.follows };
        if faster(minimum) == 0 {
            return 0;
        }
        // A contact under load is at rest, and push-out of its neighbors and the weight above may
        // move it.
        let carried = (self.carried(source) * f32::from(moment.substeps)).min(moment.push);
        faster(minimum + carried)
    }

    /// Approach speed that closes the gap of a point in the substep [m/s].
    fn kept(&self, moment: &Moment, j: usize) -> f32 {
        self.s[j].max(0.0) / moment.h
    }

    /// Speed that the contact's load causes in a substep.
    fn carried(&self, source: &Source<'_>) -> f32 {
        let block = source.blocks.read(self.block as usize);
        let mut load = 0.0;
        for rows in &block.points[..(u8::BITS - self.points.leading_zeros()) as usize] {
            load += rows.impulse[usize::from(self.lane)];
        }
        load * (self.alpha * self.alpha + self.beta * self.beta)
    }

    /// Fills the data of a hit at one of the points.
    pub(crate) fn tell(&self, source: &Source<'_>, moment: &Moment, hit: &mut Hit) {
        let (block, lane) = (self.block as usize, usize::from(self.lane));
        let point = usize::from(hit.point);
        (hit.solver_rows, hit.response) = (self.solver_rows, self.response);
        hit.contact = source.owners[block][lane];
        hit.e = source.restitution(block, lane);
        hit.speed = self.speed[point];
        if hit.e > 0.0 {
            hit.gain = self.gain(source, moment, hit.e, point);
        } else {
            hit.keeps = self.keeps(moment, point);
        }
    }

    /// Speed of a point after the bounce over that before. Its energy at the surface is multiplied
    /// by e². Subtracted are the potential energy at its present height and the energy that the
    /// substeps of this step lose.
    fn gain(&self, source: &Source<'_>, moment: &Moment, e: f32, j: usize) -> f32 {
        let w = self.speed[j];
        let lane = usize::from(self.lane);
        let fall = source.extra(self.block as usize).map_or(0.0, |extra| extra.fall[lane]);
        // A resting contact is supported against gravity.
        let fall = if self.carried(source) > 0.0 { 0.0 } else { fall };
        // The kick is in every velocity of the substep, also for points that bounced and were
        // reflected again.
        let kick = if moment.kicked { fall * moment.h } else { 0.0 };
        let bounced = self.response != NONE;
        let lost = if bounced { 0.0 } else { (fall * moment.h) * (fall * moment.h) };
        // Deep overlaps were not detected in time: limit the depth to the displacement of a step.
        let s = self.s[j].max(w * moment.h * f32::from(moment.substeps));
        let height = 2.0 * fall * s;
        let before = (w - kick) * (w - kick) - height + lost * f32::from(moment.done);
        let after =
            e * e * before.max(0.0) + height + lost * f32::from(moment.substeps - moment.done);
        let gain = (kick + after.max(0.0).sqrt()).max(0.0) / -w;
        if s < 0.0 { gain.min(1.0) } else { gain }
    }
}
