//! Impacts: bounces pairs that meet within a substep, before the sweep stops them.
//!
//! Reads: blocks, extras (restitution), motion. Writes: solver bodies (velocity), blocks (which
//! contacts were hit). Runs: over the islands of a group in which a pair arrives in this step, and
//! over the contacts around bodies that take part. In other groups it costs one flag per block. An
//! island with a group of its own runs in parallel over evaluated candidates, over hits, and over
//! sets of hits that bodies link.
//!
//! Invariant: islands and sets do not affect each other, and the hits of a set are solved in the
//! order of their contacts' rows. So neither the grouping nor the number of workers changes the
//! result.
//!
//! Each island runs rounds of reflections [Smith12]. Approaching points that bodies link are
//! stopped together, by impulses that only push, and then get e times the same impulses once more.
//! That keeps energy for e = 1 and never adds any. It treats symmetric problems symmetrically, and
//! an impact travels through a row of touching balls one by one. Friction follows, limited by the
//! impulses of the round. Points that still approach after the last round, or that approach too
//! slowly, are stopped by the sweep.
//!
//! Symbols as in the contact kernel; w = speed of a point along the normal, u = that speed at the
//! surface, kick = the speed that gravity adds in a substep. See docs/derivations/impacts.md.
#![expect(unsafe_code, reason = "promises that rows are kept apart")]

pub(crate) mod candidate;
pub(crate) mod drive;
mod hits;
pub(crate) mod reflect;
pub(crate) mod response;

use fearless_simd::dispatch;

use self::candidate::{Candidate, Entry, Hit, Moment, Source};
use self::reflect::Part;
use self::response::Response;
use super::body::row::Carried;
use super::totals_rows::Bounce;
use crate::base::simd::wide::LANES;
use crate::base::threads::disjoint::{Apart, Rows};
use crate::base::threads::jobs::{Jobs, collect_ranges, for_items, for_ranges, grain};
use crate::state::bodies::NONE;
use crate::step::solver::impact::hits::small;

/// Maximum rounds in a substep: an impact travels through a row of this number of bodies.
const MAX_ROUNDS: u32 = 64;

/// If a round has at least one hit per this number of candidates, all candidates are scanned for
/// hit solver bodies. Otherwise the contacts around each hit solver body are listed.
const FEW: usize = 16;

/// Memory of one group's impacts, kept from step to step.
#[derive(Clone, Debug, Default)]
pub(super) struct Impacts {
    /// Contacts of the group that can bounce.
    entries: Vec<Entry>,
    /// Candidate of each entry, if it has one.
    touch_of: Vec<u32>,
    ends: Vec<End>,
    /// Entries around each solver body, one solver body after another, and their candidates.
    around: Vec<u32>,
    near: Vec<u32>,
    /// Island and entry of each arriving contact in this step.
    arrivals: Vec<(u32, u32)>,
    /// Candidates; only the first `looked.len()` are in use, the rest is left over from earlier
    /// steps.
    candidates: Vec<Candidate>,
    /// Responses of the candidates that were hit; the first `answered` are in use.
    responses: Vec<Response>,
    answered: u32,
    /// Solver bodies of each candidate, stored contiguously, because candidates are far apart in
    /// memory.
    rows_of: Vec<[u32; 2]>,
    /// The next candidate of the same island.
    next: Vec<u32>,
    /// First and last candidate of each island.
    runs: Vec<[u32; 2]>,
    hits: Vec<Hit>,
    /// First hit of each set that bodies link.
    parts: Vec<usize>,
    /// Memory to make the hits of a set contiguous.
    spare: Vec<Hit>,
    places: Vec<u32>,
    /// Candidates that the next round evaluates, and bits of their points that approach and meet in
    /// the substep.
    looks: Vec<u32>,
    met_points: Vec<u8>,
    /// The round in which each candidate was last listed for evaluation; all rounds of the step are
    /// counted from 1.
    looked: Vec<u32>,
    round: u32,
    /// Candidates found for evaluation, one list for each range.
    found: Vec<Vec<u32>>,
    /// Number of the pass.
    pass: u16,
    /// Solver bodies of the candidates; and their carried impulses, while velocities are without
    /// these.
    met: Vec<u32>,
    carried: Vec<Carried>,
    lifted: bool,
}

/// A solver body, as an end of contacts.
#[derive(Clone, Copy, Debug)]
struct End {
    first: u32,
    count: u32,
    /// Its contacts are candidates.
    live: bool,
    /// It belongs to a candidate.
    met: bool,
    /// Maximum restitution of the points that approach it in this round.
    maximum: f32,
    /// The last hit on it while hits are linked.
    hit: u32,
    /// The last round in which it was hit.
    struck: u32,
}

impl End {
    const NEW: Self =
        Self { first: 0, count: 0, live: false, met: false, maximum: 0.0, hit: NONE, struck: 0 };
}

/// Number of a row.
pub(crate) fn index(i: usize) -> u32 {
    u32::try_from(i).expect("fewer than 2^32 contacts")
}

/// The ends among a contact's solver bodies.
pub(crate) fn ends_of(source: &Source<'_>, solver_rows: [u32; 2]) -> impl Iterator<Item = usize> {
    solver_rows
        .into_iter()
        .filter(|solver_row| *solver_row != 0)
        .map(|solver_row| solver_row as usize - source.first_row)
}

impl Impacts {
    /// Number of contacts for which memory is allocated.
    pub(super) fn room(&self) -> usize {
        self.entries.capacity()
    }

    /// Prepares a step: finds the contacts that arrive in it, and those around their bodies.
    pub(super) fn begin(
        &mut self,
        source: &Source<'_>,
        arrives: bool,
        blocks: core::ops::Range<usize>,
        n: usize,
    ) {
        self.runs.clear();
        if !arrives {
            return;
        }
        self.entries.clear();
        self.arrivals.clear();
        self.answered = 0;
        self.rows_of.clear();
        self.looked.clear();
        self.round = 0;
        self.next.clear();
        self.pass = 0;
        self.met.clear();
        self.ends.clear();
        self.ends.resize(n, End::NEW);
        for i in blocks {
            self.enter(source, i);
        }
        self.touch_of.clear();
        self.touch_of.resize(self.entries.len(), NONE);
        let mut first = 0;
        for end in &mut self.ends {
            end.first = first;
            first += core::mem::take(&mut end.count);
        }
        self.around.clear();
        self.around.resize(first as usize, NONE);
        self.near.clear();
        self.near.resize(first as usize, NONE);
        for (number, entry) in (0..).zip(&mut self.entries) {
            for (end, place) in ends_of(source, entry.solver_rows).zip(&mut entry.places) {
                let end = &mut self.ends[end];
                *place = end.first + end.count;
                self.around[*place as usize] = number;
                end.count += 1;
            }
        }
        // Group the arrivals by island.
        self.arrivals.sort_unstable();
        let mut island = NONE;
        for i in 0..self.arrivals.len() {
            let (of, entry) = self.arrivals[i];
            if of != island || self.runs.is_empty() {
                island = of;
                self.runs.push([NONE; 2]);
            }
            for solver_row in self.entries[entry as usize].solver_rows {
                let run = index(self.runs.len() - 1);
                for k in self.liven(source, solver_row) {
                    let of = &mut self.touch_of[self.around[k] as usize];
                    *of = run.min(*of);
                }
            }
        }
        // In the order of the blocks, because lanes of one block are adjacent in memory.
        for entry in 0..self.entries.len() {
            let run = core::mem::replace(&mut self.touch_of[entry], NONE);
            if run != NONE {
                self.add(source, entry, run as usize);
            }
        }
    }

    fn enter(&mut self, source: &Source<'_>, i: usize) {
        let block = source.blocks.read(i);
        for lane in 0..LANES {
            let contact = source.owners[i][lane];
            if contact == NONE || !source.takes_part(i, lane) {
                continue;
            }
            let solver_rows = [block.row_a[lane], block.row_b[lane]];
            let solver_row = solver_rows[0].max(solver_rows[1]);
            // A contact may still name a body that was deactivated.
            if solver_row == 0 {
                continue;
            }
            let number = index(self.entries.len());
            if block.arrives >> lane & 1 == 1 {
                let body = source.members[solver_row as usize - 1];
                self.arrivals.push((source.bodies.at(body).sleep.island, number));
            }
            for end in ends_of(source, solver_rows) {
                self.ends[end].count += 1;
            }
            let (block, lane) = (index(i), small(lane));
            self.entries.push(Entry { solver_rows, block, lane, places: [NONE; 2] });
        }
    }

    /// Makes candidates of all contacts of two bodies.
    fn wake(&mut self, source: &Source<'_>, solver_rows: [u32; 2], run: usize) {
        for solver_body in solver_rows {
            for k in self.liven(source, solver_body) {
                let entry = self.around[k] as usize;
                if self.touch_of[entry] == NONE {
                    self.add(source, entry, run);
                }
            }
        }
    }

    /// Activates a solver body for impacts. Returns the range of its entries in `around`, or an
    /// empty one if it was active.
    fn liven(&mut self, source: &Source<'_>, solver_row: u32) -> core::ops::Range<usize> {
        if solver_row == 0 {
            return 0..0;
        }
        let row = solver_row as usize;
        let end = &mut self.ends[row - source.first_row];
        if core::mem::replace(&mut end.live, true) {
            return 0..0;
        }
        let body = source.bodies.at(source.members[row - 1]);
        source.aux.row(row).calm(source.whitening.read(row), body, source.dt, source.h);
        end.first as usize..(end.first + end.count) as usize
    }

    /// Makes a candidate of an entry.
    fn add(&mut self, source: &Source<'_>, entry: usize, run: usize) {
        let place = self.looked.len();
        let number = index(place);
        self.touch_of[entry] = number;
        let entry = &self.entries[entry];
        for place in entry.places {
            if let Some(near) = self.near.get_mut(place as usize) {
                *near = number;
            }
        }
        for solver_row in entry.solver_rows.into_iter().filter(|solver_row| *solver_row != 0) {
            let row = solver_row as usize;
            let met = &mut self.ends[row - source.first_row].met;
            if !core::mem::replace(met, true) {
                self.met.push(solver_row);
                if self.lifted {
                    let carried = source.aux.read(row).lift(source.solver_bodies.row(row));
                    self.carried.push(carried);
                }
            }
        }
        if place == self.candidates.len() {
            self.candidates.push(Candidate::default());
        }
        self.candidates[place].restart(entry);
        self.rows_of.push(entry.solver_rows);
        self.looked.push(0);
        self.next.push(NONE);
        let [head, tail] = &mut self.runs[run];
        if *tail == NONE {
            *head = number;
        } else {
            self.next[*tail as usize] = number;
        }
        *tail = number;
    }

    /// Solves all impacts of a substep.
    ///
    /// After forces, velocities also contain the impulses carried from the last substep. These are
    /// a guess that the sweep corrects. They may still contain the stop of a body at 250 m/s that
    /// is over. Another contact of the body would reflect that velocity and create energy. So
    /// impacts use velocities without them.
    pub(super) fn collide(&mut self, source: &Source<'_>, moment: &Moment, jobs: &Jobs<'_>) {
        if self.runs.is_empty() {
            return;
        }
        self.lifted = moment.kicked;
        self.carried.clear();
        if self.lifted {
            self.carried.resize(self.met.len(), Carried::default());
            self.for_met(jobs, |row, carried| {
                *carried = source.aux.read(row).lift(source.solver_bodies.row(row));
            });
        }
        self.pass += 1;
        for run in 0..self.runs.len() {
            self.reflect_all(source, moment, run, jobs);
        }
        self.for_met(jobs, |row, carried| {
            source.aux.read(row).put_back(source.solver_bodies.row(row), carried);
        });
        self.lifted = false;
    }

    /// Impulses of each contact that was hit in this step: block, lane, impulses.
    pub(super) fn given(&self) -> impl Iterator<Item = (usize, usize, &Bounce)> {
        let answered = if self.runs.is_empty() { 0 } else { self.answered as usize };
        self.responses[..answered].iter().map(Response::given)
    }

    /// Calls `f` with each candidate's solver body and its carried impulses, if there are any.
    fn for_met(&mut self, jobs: &Jobs<'_>, f: impl Fn(usize, &mut Carried) + Sync) {
        let (met, carried) = (&self.met, &mut self.carried);
        let piece = grain(jobs, carried.len(), 128);
        for_items(jobs, carried, piece, |first, carried| {
            for (solver_row, carried) in met[first..].iter().zip(carried) {
                f(*solver_row as usize, carried);
            }
        });
    }

    /// Runs all rounds of an island.
    fn reflect_all(&mut self, source: &Source<'_>, moment: &Moment, run: usize, jobs: &Jobs<'_>) {
        self.looks.clear();
        let mut at = self.runs[run][0];
        while at != NONE {
            self.looks.push(at);
            at = self.next[at as usize];
        }
        for _ in 0..MAX_ROUNDS {
            self.look(source, moment, jobs);
            self.find_hits(source, moment, jobs);
            if self.hits.is_empty() {
                break;
            }
            self.round += 1;
            self.wake_around(source, moment, run);
            self.link_hits(source);
            self.reflect(source, jobs);
            self.settle(source, jobs);
        }
    }

    /// Evaluates the listed candidates: finds the points that approach.
    fn look(&mut self, source: &Source<'_>, moment: &Moment, jobs: &Jobs<'_>) {
        let Self { candidates, looks, met_points, pass, .. } = self;
        met_points.clear();
        met_points.resize(looks.len(), 0);
        // SAFETY: each index belongs to one range, and no candidate is listed twice.
        let apart = unsafe { Apart::promise() };
        let (candidates, met_points) = (Rows::new(candidates, apart), Rows::new(met_points, apart));
        for_ranges(jobs, looks.len(), grain(jobs, looks.len(), 64), |range| {
            let (looks, met_points) = (&looks[range.clone()], met_points.slice(range));
            for (k, met) in met_points.iter_mut().enumerate() {
                if let Some(next) = looks.get(k + 6) {
                    candidates.prefetch(*next as usize, size_of::<Candidate>() / 64);
                }
                if let Some(next) = looks.get(k + 3) {
                    candidates.read(*next as usize).prefetch(source);
                }
                *met = candidates.row(looks[k] as usize).look(source, moment, *pass);
            }
        });
    }

    /// Reflects all sets of hits; a set contains all hits that bodies link.
    fn reflect(&mut self, source: &Source<'_>, jobs: &Jobs<'_>) {
        let Self { candidates, responses, hits, parts, pass, .. } = self;
        let n = hits.len();
        // SAFETY: each set of hits belongs to one range, and hits that a body or a candidate links
        // are in one set.
        let apart = unsafe { Apart::promise() };
        let candidates = Rows::new(candidates, apart);
        let (responses, hits) = (Rows::new(responses, apart), Rows::new(hits, apart));
        for_ranges(jobs, parts.len(), grain(jobs, parts.len(), 16), |range| {
            let of = |i: usize| hits.slice(parts[i]..parts.get(i + 1).map_or(n, |next| *next));
            // Sort by contact row. The order of candidates is that of blocks, which depends on the
            // number of workers.
            for i in range.clone() {
                of(i).sort_unstable_by_key(|hit| (hit.contact, hit.point));
            }
            dispatch!(source.level, simd => {
                for i in range {
                    let hits = of(i);
                    for of_one in hits.chunk_by(|one, next| one.candidate == next.candidate) {
                        candidates.row(of_one[0].candidate as usize).hits += 1;
                    }
                    let alone = hits[0].candidate == hits[hits.len() - 1].candidate;
                    let part = Part { simd, source, candidates: &candidates, responses: &responses, hits };
                    if alone {
                        part.reflect::<true>(*pass);
                    } else {
                        part.reflect::<false>(*pass);
                    }
                }
            });
        });
    }

    /// Lists the candidates that the next round evaluates.
    fn settle(&mut self, source: &Source<'_>, jobs: &Jobs<'_>) {
        let many = self.hits.len() * FEW >= self.looked.len();
        for i in 0..self.hits.len() {
            let Hit { candidate, solver_rows, .. } = self.hits[i];
            if i > 0 && self.hits[i - 1].candidate == candidate {
                continue;
            }
            for end in ends_of(source, solver_rows) {
                let End { first, count, struck, .. } = &mut self.ends[end];
                if core::mem::replace(struck, self.round) == self.round || many {
                    continue;
                }
                for number in &self.near[*first as usize..(*first + *count) as usize] {
                    if let Some(looked) = self.looked.get_mut(*number as usize)
                        && core::mem::replace(looked, self.round) < self.round
                    {
                        self.looks.push(*number);
                    }
                }
            }
        }
        if many {
            self.find_struck(source, jobs);
        }
    }

    /// Lists the candidates of solver bodies that were hit in this round.
    fn find_struck(&mut self, source: &Source<'_>, jobs: &Jobs<'_>) {
        let Self { looked, rows_of, ends, found, looks, round, .. } = self;
        let n = looked.len();
        // SAFETY: each number belongs to one range.
        let looked = Rows::new(looked, unsafe { Apart::promise() });
        collect_ranges(jobs, n, grain(jobs, n, 256), found, |range, found| {
            for number in range {
                let is_struck = |end: usize| ends[end].struck == *round;
                if ends_of(source, rows_of[number]).any(is_struck)
                    && core::mem::replace(looked.row(number), *round) < *round
                {
                    found.push(index(number));
                }
            }
        });
        looks.extend(found.iter().flatten());
    }
}
