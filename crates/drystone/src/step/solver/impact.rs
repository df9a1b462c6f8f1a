//! Impacts: pairs that meet within a substep bounce before the sweep sees them.
//!
//! Reads: blocks, extras (restitution), motion. Writes: lines (velocity), extras (which contacts were
//! hit). Runs: serial over the islands of a group in which a pair arrives in this step, over contacts
//! around bodies that take part; other groups pay for a look at one flag a block. Invariant: islands
//! do not see each other, so neither grouping nor the number of workers shows.
//!
//! In an island, rounds of reflections [Smith12]: all points that approach are stopped together, by
//! impulses that only push, and then get e times the same impulses once more. That
//! keeps energy for e = 1 and never adds any, treats what is symmetric symmetrically, and sends an
//! impact through a row of touching balls one by one. Friction follows under the impulses of the round.
//! What still approaches after the last round, or too slowly, is left to the sweep, which stops it.
//!
//! Symbols as in the contact kernel; w = speed of a point along the normal, u = that speed at the
//! surface, kick = what gravity adds in a substep. See docs/derivations/impacts.md.

use super::integrate::Aux;
use super::rows::{ContactBlock, Extra, Line, Whitening};
use crate::base::disjoint::Rows;
use crate::base::math::{Vec3, vec3};
use crate::base::wide::{LANES, Lanes};
use crate::state::bodies::{Bodies, NONE};

/// Most rounds in a substep: an impact runs through a row of as many bodies.
const ROUNDS: u32 = 64;

/// Most rounds that hit the same contact of one point, and of several: as many touching bodies can come
/// in to a row. More of them go to boxes that rattle on two edges, where friction and bounce feed each
/// other.
const HITS: [u8; 2] = [8, 3];

/// Most sweeps over the points of one round. One point needs one; two balls side by side come nearer
/// to their common stop by 16 in each.
const SWEEPS: u32 = 24;

/// A round has converged when no impulse changes a speed by more than this part of the greatest one:
/// what it leaves of speed and energy is of that order.
const PRECISION: f32 = 1.0e-5;

/// Below this a point does not approach [m/s]: a hundred roundings of speeds of 10 m/s.
const STILL: f32 = 1.0e-4;

/// The solver's rows that impacts read and write.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source<'a> {
    pub(super) blocks: &'a Rows<'a, ContactBlock>,
    pub(super) extras: &'a Rows<'a, Extra>,
    pub(super) owners: &'a [[u32; LANES]],
    pub(super) lines: &'a Rows<'a, Line>,
    pub(super) aux: &'a Rows<'a, Aux>,
    pub(super) whitening: &'a Rows<'a, Whitening>,
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

/// Memory of one group's impacts, kept from step to step.
#[derive(Clone, Debug, Default)]
pub(super) struct Impacts {
    /// Contacts of the group that can bounce.
    entries: Vec<Entry>,
    ends: Vec<End>,
    /// Entries around each line, line after line.
    around: Vec<u32>,
    /// Island and entry of what arrives in this step.
    arrivals: Vec<(u32, u32)>,
    touches: Vec<Touch>,
    /// First and last touch of each island.
    runs: Vec<[u32; 2]>,
    hits: Vec<Hit>,
    clock: u32,
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    lines: [u32; 2],
    block: u32,
    lane: u8,
    taken: bool,
}

/// A line, as an end of contacts.
#[derive(Clone, Copy, Debug, Default)]
struct End {
    first: u32,
    count: u32,
    /// Its contacts are looked at.
    live: bool,
    /// When an impact last changed its velocity.
    changed: u32,
    /// Greatest restitution of the points that approach it in this round.
    most: f32,
}

/// One point that approaches.
#[derive(Clone, Copy, Debug)]
struct Hit {
    touch: u32,
    point: u8,
    e: f32,
    /// Speed after over speed before.
    gain: f32,
    speed: f32,
    impulse: f32,
    /// No other on its bodies has a greater restitution.
    first: bool,
}

#[derive(Clone, Copy, Debug, Default)]
struct PointRow {
    a: Vec3,
    b: Vec3,
    mass: f32,
    s0: f32,
    lever: f32,
    drift: f32,
    /// Separation now.
    s: f32,
    /// Impulse of this substep's impacts.
    given: f32,
}

/// A contact that can bounce, out of its block.
#[derive(Clone, Copy, Debug)]
struct Touch {
    lines: [u32; 2],
    block: u32,
    lane: u8,
    count: u8,
    /// The next touch of the island.
    next: u32,
    /// When it was last looked at.
    seen: u32,
    /// It was hit in this step, and how often in this substep.
    bounced: bool,
    hits: u8,
    /// One of the bodies is kinematic and moves.
    driven: bool,
    n: Vec3,
    alpha: f32,
    beta: f32,
    mu: f32,
    e: f32,
    /// Relative acceleration along the normal, and a speed that gravity alone makes in a step.
    fall: f32,
    slow: f32,
    /// Speed that the contact's load makes in a substep.
    load: f32,
    points: [PointRow; 4],
    t: [Vec3; 2],
    a_t: [Vec3; 3],
    b_t: [Vec3; 3],
    mass_t: [f32; 4],
    drift_t: [f32; 3],
    rubbed: [f32; 3],
}

#[inline(always)]
fn lane3(lanes: &[Lanes; 3], lane: usize) -> Vec3 {
    vec3(lanes[0][lane], lanes[1][lane], lanes[2][lane])
}

#[inline(always)]
fn three(v: &[f32; 4]) -> Vec3 {
    vec3(v[0], v[1], v[2])
}

/// Number of a row.
fn index(i: usize) -> u32 {
    u32::try_from(i).expect("fewer than 2^32 contacts")
}

/// Number of a lane or a point.
#[expect(clippy::cast_possible_truncation, reason = "below 8")]
const fn small(i: usize) -> u8 {
    i as u8
}

impl Touch {
    fn load(source: &Source<'_>, entry: &Entry) -> Self {
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
            count: block.count.min(4),
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
            mass_t: [0.0; 4],
            drift_t: [0.0; 3],
            rubbed: [0.0; 3],
        };
        for i in 0..4 {
            touch.mass_t[i] = block.mass_t[i][lane];
        }
        for i in 0..3 {
            touch.drift_t[i] = extra.drift_t[i][lane];
            touch.driven |= touch.drift_t[i] != 0.0;
        }
        for j in 0..usize::from(touch.count) {
            let p = &block.points[j];
            touch.points[j] = PointRow {
                a: of_a(&p.a),
                b: lane3(&p.b, lane),
                mass: p.mass[lane],
                s0: p.s0[lane],
                lever: p.lever[lane],
                drift: extra.drift[j][lane],
                s: 0.0,
                given: 0.0,
            };
            touch.driven |= touch.points[j].drift != 0.0;
        }
        touch.meet(source);
        touch
    }

    /// Moves friction to where the bodies will touch: until then its arms end in the middle of the gap.
    fn meet(&mut self, source: &Source<'_>) {
        let mut gap = 0.0;
        for p in &self.points[..usize::from(self.count)] {
            gap += p.s0.max(0.0);
        }
        let half = 0.5 * gap / f32::from(self.count.max(1));
        if half <= 0.0 {
            return;
        }
        // n x t1 = -t2, n x t2 = t1
        let [t1, t2] = self.t;
        let [sa, sb] = self.lines.map(|line| source.whitening.read(line as usize).s());
        if self.lines[0] != 0 {
            self.a_t[0] += sa.mul(t2) * half;
            self.a_t[1] -= sa.mul(t1) * half;
        }
        self.b_t[0] -= sb.mul(t2) * half;
        self.b_t[1] += sb.mul(t1) * half;
        let ([a1, a2, _], [b1, b2, _]) = (self.a_t, self.b_t);
        let linear = self.alpha * self.alpha + self.beta * self.beta;
        let k11 = linear + a1.dot(a1) + b1.dot(b1);
        let k12 = a1.dot(a2) + b1.dot(b2);
        let k22 = linear + a2.dot(a2) + b2.dot(b2);
        let determinant = k11 * k22 - k12 * k12;
        if determinant > 0.0 {
            let inverse = 1.0 / determinant;
            self.mass_t = [k22 * inverse, -(k12 * inverse), k11 * inverse, self.mass_t[3]];
        }
    }

    /// Separations and load at the start of a substep.
    fn place(&mut self, source: &Source<'_>, elapsed: f32) {
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
    fn speed(&self, j: usize, lines: &Rows<'_, Line>) -> f32 {
        let [a, b] = self.lines.map(|line| lines.read(line as usize));
        let p = &self.points[j];
        let u = self.n.dot(three(&b.v) * self.beta - three(&a.v) * self.alpha);
        u + p.b.dot(three(&b.w)) - p.a.dot(three(&a.w)) + p.drift
    }

    /// Least speed at which it bounces. What carries a load rests, and its neighbors' push-out and the
    /// weight above it may move it.
    fn least(&self, moment: &Moment) -> f32 {
        let carried = (self.load * f32::from(moment.substeps)).min(moment.push);
        moment.least.max(self.slow).max(STILL) + carried
    }

    /// Speed of a point after the bounce over the one before: its energy at the surface, times e², less
    /// what it has at the place where it is, and what the substeps of this step lose of it.
    fn gain(&self, j: usize, w: f32, moment: &Moment) -> f32 {
        // What rests is held against gravity.
        let fall = if self.load > 0.0 { 0.0 } else { self.fall };
        let p = &self.points[j];
        let kick = if moment.kicked && p.given == 0.0 { fall * moment.h } else { 0.0 };
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
    fn push(&mut self, j: usize, d: f32, source: &Source<'_>) -> f32 {
        let p = &mut self.points[j];
        p.given += d;
        let (a, b) = (p.a, p.b);
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

    /// Twist, then friction, as in the sweep: limited by the whole impulse of the bounce; gives their work [J].
    fn rub(&mut self, source: &Source<'_>) -> f32 {
        let (mut limit, mut twist_limit) = (0.0, 0.0);
        for p in &self.points[..usize::from(self.count)] {
            limit += self.mu * p.given;
            twist_limit += self.mu * p.lever * p.given;
        }
        if limit <= 0.0 {
            return 0.0;
        }
        let [a, b] = self.lines.map(|line| source.lines.read(line as usize));
        let twist = self.b_t[2].dot(three(&b.w)) - self.a_t[2].dot(three(&a.w)) + self.drift_t[2];
        let new = (self.rubbed[2] - self.mass_t[3] * twist).min(twist_limit).max(-twist_limit);
        let d = new - self.rubbed[2];
        self.rubbed[2] = new;
        let work = self.apply(Vec3::ZERO, self.a_t[2] * d, self.b_t[2] * d, source);

        let [a, b] = self.lines.map(|line| source.lines.read(line as usize));
        let slip = three(&b.v) * self.beta - three(&a.v) * self.alpha;
        let speed = |i: usize| {
            self.t[i].dot(slip) + self.b_t[i].dot(three(&b.w)) - self.a_t[i].dot(three(&a.w))
                + self.drift_t[i]
        };
        let (s1, s2) = (speed(0), speed(1));
        let [m11, m12, m22, _] = self.mass_t;
        let (f1, f2) = (self.rubbed[0], self.rubbed[1]);
        let (mut g1, mut g2) = (f1 - (m11 * s1 + m12 * s2), f2 - (m12 * s1 + m22 * s2));
        let square = g1 * g1 + g2 * g2;
        if square > limit * limit {
            let scale = limit / square.sqrt();
            (g1, g2) = (g1 * scale, g2 * scale);
        }
        let (d1, d2) = (g1 - f1, g2 - f2);
        (self.rubbed[0], self.rubbed[1]) = (g1, g2);
        let turn = |rows: &[Vec3; 3]| rows[0] * d1 + rows[1] * d2;
        let linear = self.t[0] * d1 + self.t[1] * d2;
        work + self.apply(linear, turn(&self.a_t), turn(&self.b_t), source)
    }
}

impl Impacts {
    /// At the step's start: finds what arrives in it, and the contacts around.
    pub(super) fn begin(&mut self, source: &Source<'_>, blocks: core::ops::Range<usize>, n: usize) {
        self.runs.clear();
        if !blocks.clone().any(|i| source.extras.read(i).arrives != 0) {
            return;
        }
        self.entries.clear();
        self.arrivals.clear();
        self.touches.clear();
        self.clock = 0;
        self.ends.clear();
        self.ends.resize(n, End::default());
        for i in blocks {
            let extra = source.extras.read(i);
            if extra.bounces {
                self.enter(source, i, extra);
            }
        }
        let mut first = 0;
        for end in &mut self.ends {
            end.first = first;
            first += core::mem::take(&mut end.count);
        }
        self.around.clear();
        self.around.resize(first as usize, NONE);
        for (number, entry) in (0..).zip(&self.entries) {
            for line in entry.lines {
                if line != 0 {
                    let end = &mut self.ends[line as usize - source.first_line];
                    self.around[(end.first + end.count) as usize] = number;
                    end.count += 1;
                }
            }
        }
        // Islands one after the other, and in each what arrives in the order of the colors.
        self.arrivals.sort_unstable();
        let mut island = NONE;
        for i in 0..self.arrivals.len() {
            let (of, entry) = self.arrivals[i];
            if of != island || self.runs.is_empty() {
                island = of;
                self.runs.push([NONE; 2]);
            }
            let lines = self.entries[entry as usize].lines;
            self.wake(source, lines, self.runs.len() - 1);
        }
    }

    fn enter(&mut self, source: &Source<'_>, i: usize, extra: &Extra) {
        let block = source.blocks.read(i);
        for lane in 0..LANES {
            if source.owners[i][lane] == NONE || !(extra.restitution[lane] > 0.0) {
                continue;
            }
            let lines = [block.row_a[lane], block.row_b[lane]];
            let line = lines[0].max(lines[1]);
            // A body that was put aside may still be named by a contact.
            if line == 0 {
                continue;
            }
            let number = index(self.entries.len());
            if extra.arrives >> lane & 1 == 1 {
                let body = source.members[line as usize - 1];
                self.arrivals.push((source.bodies.at(body).island, number));
            }
            for line in lines {
                if line != 0 {
                    self.ends[line as usize - source.first_line].count += 1;
                }
            }
            let (block, lane) = (index(i), small(lane));
            self.entries.push(Entry { lines, block, lane, taken: false });
        }
    }

    /// Looks at all contacts of two bodies from now on.
    fn wake(&mut self, source: &Source<'_>, lines: [u32; 2], run: usize) {
        for line in lines {
            if line == 0 {
                continue;
            }
            let end = &mut self.ends[line as usize - source.first_line];
            if core::mem::replace(&mut end.live, true) {
                continue;
            }
            for k in end.first..end.first + end.count {
                let entry = &mut self.entries[self.around[k as usize] as usize];
                if core::mem::replace(&mut entry.taken, true) {
                    continue;
                }
                let number = index(self.touches.len());
                self.touches.push(Touch::load(source, entry));
                let [head, tail] = &mut self.runs[run];
                if *tail == NONE {
                    *head = number;
                } else {
                    self.touches[*tail as usize].next = number;
                }
                *tail = number;
            }
        }
    }

    /// All impacts of a substep.
    pub(super) fn collide(&mut self, source: &Source<'_>, moment: &Moment) {
        for run in 0..self.runs.len() {
            let mut placed = NONE;
            for _ in 0..ROUNDS {
                self.clock += 1;
                placed = self.place_from(source, moment, run, placed);
                self.find_hits(source, moment, run);
                if self.hits.is_empty() {
                    break;
                }
                self.reflect(source);
                self.settle(source, run);
            }
        }
    }

    /// Places the touches of a run after `last`; all if that is none. Returns the last one.
    fn place_from(&mut self, source: &Source<'_>, moment: &Moment, run: usize, last: u32) -> u32 {
        let [head, tail] = self.runs[run];
        let mut at = if last == NONE { head } else { self.touches[last as usize].next };
        while at != NONE {
            let touch = &mut self.touches[at as usize];
            touch.place(source, f32::from(moment.done) * moment.h);
            at = touch.next;
        }
        tail
    }

    /// The points that approach and meet in this substep. Of several on a body those of the greatest
    /// restitution are first: with unlike ones reflected together energy could grow.
    fn find_hits(&mut self, source: &Source<'_>, moment: &Moment, run: usize) {
        self.hits.clear();
        let Self { ends, touches, hits, clock, .. } = self;
        let mut at = self.runs[run][0];
        while at != NONE {
            let number = at;
            let touch = &mut touches[at as usize];
            at = touch.next;
            let mut changed = 1;
            for line in touch.lines {
                if line != 0 {
                    changed = changed.max(ends[line as usize - source.first_line].changed);
                }
            }
            if touch.seen >= changed || touch.hits >= HITS[usize::from(touch.count > 1)] {
                continue;
            }
            touch.seen = *clock;
            let least = touch.least(moment);
            for j in 0..usize::from(touch.count) {
                let p = &touch.points[j];
                if p.mass <= 0.0 {
                    continue;
                }
                let speed = touch.speed(j, source.lines);
                if speed < -least && p.s + speed * moment.h < 0.0 {
                    let gain = touch.gain(j, speed, moment);
                    let hit = Hit {
                        touch: number,
                        point: small(j),
                        e: touch.e,
                        gain,
                        speed,
                        impulse: 0.0,
                        first: true,
                    };
                    hits.push(hit);
                    for line in touch.lines {
                        if line != 0 {
                            let end = &mut ends[line as usize - source.first_line];
                            end.most = end.most.max(touch.e);
                        }
                    }
                }
            }
        }
        for hit in hits.iter_mut() {
            let touch = &mut touches[hit.touch as usize];
            for line in touch.lines {
                if line != 0 {
                    hit.first &= ends[line as usize - source.first_line].most <= hit.e;
                }
            }
            if !hit.first {
                touch.seen = 0;
            }
        }
        for hit in hits.iter() {
            for line in touches[hit.touch as usize].lines {
                if line != 0 {
                    ends[line as usize - source.first_line].most = 0.0;
                }
            }
        }
        hits.retain(|hit| hit.first);
    }

    /// Stops all hits together, with friction; then gives their impulses once more, times what they gain,
    /// but no more energy than the stop took [Poisson's hypothesis], and friction again.
    fn reflect(&mut self, source: &Source<'_>) {
        let Self { touches, hits, .. } = self;
        let mut fastest = 0.0_f32;
        for hit in hits.iter() {
            fastest = fastest.max(-hit.speed);
        }
        let mut work = 0.0;
        for _ in 0..SWEEPS {
            let mut change = 0.0_f32;
            for i in 0..hits.len() {
                let last = hits.get(i + 1).is_none_or(|next| next.touch != hits[i].touch);
                let hit = &mut hits[i];
                let (touch, j) = (&mut touches[hit.touch as usize], usize::from(hit.point));
                let mass = touch.points[j].mass;
                let speed = touch.speed(j, source.lines);
                let new = (hit.impulse - mass * speed).max(0.0);
                let d = new - hit.impulse;
                hit.impulse = new;
                work += touch.push(j, d, source);
                change = change.max(d.abs() / mass);
                if last {
                    work += touch.rub(source);
                }
            }
            if change <= PRECISION * fastest {
                break;
            }
        }
        let (mut rate, mut returned, mut driven) = (0.0, 0.0, false);
        for hit in hits.iter() {
            let touch = &touches[hit.touch as usize];
            driven |= touch.driven;
            rate += hit.e * hit.impulse * touch.speed(usize::from(hit.point), source.lines);
        }
        for hit in hits.iter() {
            let touch = &mut touches[hit.touch as usize];
            returned += touch.push(usize::from(hit.point), hit.e * hit.impulse, source);
        }
        // Where friction and normals work on each other, all of the impulse can be too much (Kane).
        // What a kinematic body does is not limited.
        let mut part = 1.0;
        let square = returned - rate;
        if !driven && work + returned > -PRECISION * work && square > 0.0 {
            let root = (rate * rate - 4.0 * square * work).max(0.0).sqrt();
            part = ((root - rate) / (2.0 * square)).clamp(0.0, 1.0);
        }
        for i in 0..hits.len() {
            let last = hits.get(i + 1).is_none_or(|next| next.touch != hits[i].touch);
            let hit = &hits[i];
            let touch = &mut touches[hit.touch as usize];
            touch.push(usize::from(hit.point), hit.impulse * (hit.gain * part - hit.e), source);
            if last {
                touch.rub(source);
            }
        }
    }

    /// What follows from a round: whose speed has changed, and who is looked at.
    fn settle(&mut self, source: &Source<'_>, run: usize) {
        for i in 0..self.hits.len() {
            let number = self.hits[i].touch;
            let touch = &mut self.touches[number as usize];
            let lines = touch.lines;
            for line in lines {
                if line != 0 {
                    let end = &mut self.ends[line as usize - source.first_line];
                    end.changed = self.clock + 1;
                }
            }
            if i > 0 && self.hits[i - 1].touch == number {
                continue;
            }
            touch.bounced = true;
            touch.hits += 1;
            source.extras.row(touch.block as usize).hit |= 1 << touch.lane;
            self.wake(source, lines, run);
        }
    }
}
