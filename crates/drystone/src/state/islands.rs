//! Islands: dynamic bodies connected by contacts or joints. Kept from step to step: merged when a
//! connection is made, split when one of them wants to sleep, or when so many were cut that too few are
//! left to hold it together. Their bodies are chained in the bodies' rows, so that merging and splitting
//! take no memory.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::bodies::{Bodies, Body, NONE};
use crate::base::grow;

/// Bodies that sleep and wake together.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Island {
    /// First and last of its bodies; [`NONE`] while the row is free.
    pub(crate) first: u32,
    last: u32,
    pub(crate) len: u32,
    /// Connections were cut since it was last known to be connected.
    pub(crate) cut: bool,
    /// Is in [`Islands::loose`].
    listed: bool,
    /// Ends of connections that were cut since what is left was last counted, as far as this counts.
    cuts: u16,
    /// It is not looked through before this step, see [`Islands::split_again`].
    pub(crate) wait_until: u64,
}

impl Island {
    const FREE: Self =
        Self { first: NONE, last: NONE, len: 0, cut: false, listed: false, cuts: 0, wait_until: 0 };

    pub(in crate::state) const fn last(&self) -> u32 {
        self.last
    }

    /// Its bodies, in the order of their chain.
    pub(crate) fn bodies<'b>(
        &self,
        bodies: &'b Bodies,
    ) -> impl Iterator<Item = &'b Body> + use<'b> {
        let mut at = self.first;
        core::iter::from_fn(move || {
            let body = (at != NONE).then(|| bodies.at(at))?;
            at = body.island_next;
            Some(body)
        })
    }

    /// Its last cuts have as many ends as it has bodies.
    pub(crate) fn was_cut_often(&self) -> bool {
        self.len > 1 && u32::from(self.cuts) >= self.len.min(u32::from(u16::MAX))
    }

    /// Its bodies have so few connections that it cannot be one still.
    fn is_apart(&self, bodies: &Bodies) -> bool {
        // n bodies are held together by n - 1 connections at least, each of which has two ends. Those to
        // what cannot be pushed are counted as well.
        let needed = 2 * u64::from(self.len.saturating_sub(1));
        let mut ends = 0;
        self.bodies(bodies).all(|body| {
            ends += u64::from(body.constraints);
            ends < needed
        })
    }
}

/// All islands; every dynamic body is in one.
#[derive(Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Islands {
    pub(crate) rows: Vec<Island>,
    free: Vec<u32>,
    /// Islands of whose connections many were cut: no fewer ends than there are bodies, so that to count what is
    /// left costs no more than the cuts did. Some may be another by now.
    loose: Vec<u32>,
    /// A body that is woken wakes alone, not with its island: bodies freeze one by one.
    pub(crate) wake_alone: bool,
    /// Then a touch below this speed wakes nothing [m/s].
    pub(crate) gentle_speed: f32,
    /// How many islands were dissolved: bodies of one may be of several now that have its number and others.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) dissolved: u64,
    /// Memory for the list of an island, see [`Self::members`].
    #[cfg_attr(feature = "serde", serde(skip))]
    spare: Vec<u32>,
}

impl Clone for Islands {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Into the lists that are there.
    fn clone_from(&mut self, from: &Self) {
        let Self { rows, free, loose, wake_alone, gentle_speed, dissolved, spare: _ } = from;
        self.rows.clone_from(rows);
        self.free.clone_from(free);
        self.loose.clone_from(loose);
        self.wake_alone = *wake_alone;
        self.gentle_speed = *gentle_speed;
        self.dissolved = *dissolved;
    }
}

impl Islands {
    /// True if a contact of these bodies is solved while it has points. One that sleeps is met by what touches it, and
    /// then it is awake; where bodies wake alone it is immovable meanwhile.
    pub(crate) fn solves(&self, a: &Body, b: &Body) -> bool {
        let moves = |body: &Body| body.active() && body.is_dynamic();
        (moves(a) || moves(b)) && (self.wake_alone || !(a.sleeps() || b.sleeps()))
    }

    /// Rows that are free.
    pub(in crate::state) fn free(&self) -> &[u32] {
        &self.free
    }

    /// Every island that was cut often is there.
    pub(in crate::state) fn knows_loose(&self) -> bool {
        self.loose.iter().all(|island| (*island as usize) < self.rows.len())
    }

    /// A list of an island's bodies, for who changes islands on the way; to be given back.
    pub(crate) fn members(&mut self, island: u32, bodies: &Bodies) -> Vec<u32> {
        let mut list = core::mem::take(&mut self.spare);
        list.clear();
        let mut at = self.rows[island as usize].first;
        while at != NONE {
            list.push(at);
            at = bodies.at(at).island_next;
        }
        list
    }

    /// Takes back what [`Self::members`] lent.
    pub(crate) fn give_back(&mut self, list: Vec<u32>) {
        self.spare = list;
    }

    /// A new island of one body.
    pub(crate) fn create(&mut self, body: u32, bodies: &mut Bodies) -> u32 {
        let island = self.free.pop().unwrap_or_else(|| {
            grow::push(&mut self.rows, Island::FREE);
            u32::try_from(self.rows.len() - 1).expect("fewer islands than bodies")
        });
        self.push(island, body, bodies);
        island
    }

    /// Puts a body that is in no island behind the others of one.
    pub(crate) fn push(&mut self, island: u32, body: u32, bodies: &mut Bodies) {
        let row = &mut self.rows[island as usize];
        let b = bodies.at_mut(body);
        (b.island, b.island_previous, b.island_next) = (island, row.last, NONE);
        if row.last == NONE {
            row.first = body;
        } else {
            bodies.at_mut(row.last).island_next = body;
        }
        row.last = body;
        row.len += 1;
    }

    /// Empties an island and frees its row; its bodies are in none until they are put into one.
    pub(crate) fn dissolve(&mut self, island: u32) {
        self.free.push(island);
        self.dissolved += 1;
        self.rows[island as usize] = Island::FREE;
    }

    /// Connects the islands of two dynamic bodies.
    pub(crate) fn link(&mut self, a: u32, b: u32, bodies: &mut Bodies) {
        let (mut keep, mut give) = (bodies.at(a).island, bodies.at(b).island);
        if keep == give || keep == NONE || give == NONE {
            return;
        }
        let size = |i: u32| self.rows[i as usize].len;
        if (size(give), keep) > (size(keep), give) {
            core::mem::swap(&mut keep, &mut give);
        }
        let given = self.rows[give as usize];
        let mut at = given.first;
        while at != NONE {
            let body = bodies.at_mut(at);
            body.island = keep;
            at = body.island_next;
        }
        let island = &mut self.rows[keep as usize];
        bodies.at_mut(island.last).island_next = given.first;
        bodies.at_mut(given.first).island_previous = island.last;
        island.last = given.last;
        island.len += given.len;
        island.cut |= given.cut;
        island.cuts = island.cuts.saturating_add(given.cuts);
        self.dissolve(give);
        self.list_if_loose(keep);
    }

    /// Puts off the next search for components until as many steps have gone by as the island has
    /// hundreds of bodies: a large one with some still bodies would be searched in every step, for its
    /// connections are cut in every step.
    pub(crate) fn split_again(&mut self, island: u32, step: u64) {
        let row = &mut self.rows[island as usize];
        row.wait_until = step + u64::from(row.len / 128);
    }

    /// A connection of this body was cut.
    pub(crate) fn cut(&mut self, body: u32, bodies: &Bodies) {
        let island = bodies.at(body).island;
        if island == NONE {
            return;
        }
        let row = &mut self.rows[island as usize];
        row.cut = true;
        row.cuts = row.cuts.saturating_add(1);
        self.list_if_loose(island);
    }

    fn list_if_loose(&mut self, island: u32) {
        let row = &mut self.rows[island as usize];
        if row.was_cut_often() && !row.listed {
            row.listed = true;
            self.loose.push(island);
        }
    }

    /// Takes one out of the list of those that were cut often; `None` at its end.
    pub(crate) fn next_loose(&mut self, bodies: &Bodies) -> Option<u32> {
        loop {
            let island = self.loose.pop()?;
            let row = &mut self.rows[island as usize];
            let often = row.listed && row.was_cut_often();
            row.listed = false;
            // Only of what is awake the connections are counted, and that is all of an island or none.
            let counted = !self.wake_alone && row.first != NONE && bodies.at(row.first).active();
            if often && counted {
                row.cuts = 0;
                if row.is_apart(bodies) {
                    return Some(island);
                }
            }
        }
    }

    /// Takes a body out.
    pub(crate) fn remove(&mut self, body: u32, bodies: &mut Bodies) {
        let b = bodies.at_mut(body);
        let (island, previous, next) = (b.island, b.island_previous, b.island_next);
        if island == NONE {
            return;
        }
        (b.island, b.island_previous, b.island_next) = (NONE, NONE, NONE);
        let row = &mut self.rows[island as usize];
        if previous == NONE {
            row.first = next;
        } else {
            bodies.at_mut(previous).island_next = next;
        }
        if next == NONE {
            row.last = previous;
        } else {
            bodies.at_mut(next).island_previous = previous;
        }
        row.len -= 1;
        row.cut = true;
        if row.len == 0 {
            self.dissolve(island);
        }
    }
}
