//! Finds the hits of an island among its candidates, and groups them into sets linked by bodies.

use crate::base::threads::jobs::{Jobs, for_items, grain};
use crate::state::bodies::NONE;
use crate::step::solver::impact::candidate::{Hit, Moment, Source};
use crate::step::solver::impact::response::Response;
use crate::step::solver::impact::{Impacts, ends_of, index};

/// Number of a lane.
#[expect(clippy::cast_possible_truncation, reason = "below 8")]
pub(super) const fn small(i: usize) -> u8 {
    i as u8
}

/// The first hit in the set of a hit.
pub(super) fn root(hits: &[Hit], of: u32) -> u32 {
    let mut at = of;
    while hits[at as usize].part != at {
        at = hits[at as usize].part;
    }
    at
}

impl Impacts {
    /// Lists the points that approach and meet in this substep, among the evaluated candidates. If
    /// a body has several, those of maximum restitution come first: energy could grow if unequal
    /// ones were reflected together.
    pub(crate) fn find_hits(&mut self, source: &Source<'_>, moment: &Moment, jobs: &Jobs<'_>) {
        let Self {
            ends,
            candidates,
            rows_of,
            responses,
            answered,
            hits,
            looks,
            met_points,
            looked,
            round,
            ..
        } = self;
        hits.clear();
        for (candidate, met) in looks.drain(..).zip(met_points.iter()).filter(|(_, met)| **met != 0)
        {
            let points = (0..4).filter(|point| met >> point & 1 == 1);
            hits.extend(points.map(|point| Hit { candidate, point, ..Hit::default() }));
        }
        let piece = grain(jobs, hits.len(), 32);
        for_items(jobs, hits, piece, |_, hits| {
            for hit in hits {
                candidates[hit.candidate as usize].tell(source, moment, hit);
            }
        });
        if hits.iter().any(|hit| hit.e.to_bits() != hits[0].e.to_bits()) {
            for hit in hits.iter() {
                ends_of(source, hit.solver_rows)
                    .for_each(|end| ends[end].maximum = ends[end].maximum.max(hit.e));
            }
            hits.retain(|hit| {
                let first = ends_of(source, hit.solver_rows).all(|end| ends[end].maximum <= hit.e);
                let round = *round + 1;
                if !first && core::mem::replace(&mut looked[hit.candidate as usize], round) < round
                {
                    looks.push(hit.candidate);
                }
                first
            });
            let left = looks.iter().map(|candidate| rows_of[*candidate as usize]);
            for solver_rows in hits.iter().map(|hit| hit.solver_rows).chain(left) {
                ends_of(source, solver_rows).for_each(|end| ends[end].maximum = 0.0);
            }
        }
        for hit in hits.iter_mut().filter(|hit| hit.response == NONE) {
            let candidate = &mut candidates[hit.candidate as usize];
            if candidate.response == NONE {
                candidate.response = *answered;
                *answered += 1;
                hit.fresh = true;
                source.blocks.row(candidate.block as usize).hit |= 1 << candidate.lane;
            }
            hit.response = candidate.response;
        }
        if responses.len() < *answered as usize {
            responses.resize(*answered as usize, Response::default());
        }
    }

    /// Groups the hits that bodies link into contiguous sets.
    pub(crate) fn link_hits(&mut self, source: &Source<'_>) {
        let Self { ends, hits, parts, spare, places, .. } = self;
        // A set is a tree of hits, in which each parent has a lower number.
        for i in 0..hits.len() {
            let number = index(i);
            hits[i].part = number;
            for end in ends_of(source, hits[i].solver_rows) {
                let last = core::mem::replace(&mut ends[end].hit, number);
                if last != NONE {
                    let (one, other) = (root(hits, last), root(hits, number));
                    hits[one.max(other) as usize].part = one.min(other);
                }
            }
        }
        places.clear();
        places.resize(hits.len(), 0);
        for i in 0..hits.len() {
            let part = hits[hits[i].part as usize].part;
            hits[i].part = part;
            places[part as usize] += 1;
            for end in ends_of(source, hits[i].solver_rows) {
                ends[end].hit = NONE;
            }
        }
        parts.clear();
        let mut first = 0;
        for place in places.iter_mut().filter(|size| **size > 0) {
            parts.push(first as usize);
            first += core::mem::replace(place, first);
        }
        spare.clone_from(hits);
        for hit in spare.iter() {
            let place = &mut places[hit.part as usize];
            hits[*place as usize] = *hit;
            *place += 1;
        }
    }

    /// Evaluates the contacts around bodies that are hit for the first time, to get their approach
    /// speeds before that.
    pub(crate) fn wake_around(&mut self, source: &Source<'_>, moment: &Moment, run: usize) {
        let known = self.looked.len();
        for i in 0..self.hits.len() {
            self.wake(source, self.hits[i].solver_rows, run);
        }
        for candidate in &mut self.candidates[known..self.looked.len()] {
            candidate.look(source, moment, self.pass);
        }
    }
}
