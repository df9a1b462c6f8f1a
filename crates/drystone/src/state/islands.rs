//! Islands: dynamic bodies connected by contacts or joints. They are kept between steps. Two
//! islands merge when a connection is made. An island is split when one of its bodies is ready to
//! sleep, or when cuts left too few connections to hold it together. The bodies are chained in
//! their rows, so that merging and splitting allocate nothing.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::bodies::body::Body;
use super::bodies::{Bodies, NONE};
use crate::base::grow;

/// Bodies that sleep and wake together.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Island {
    /// First and last of its bodies; [`NONE`] while the row is free.
    pub(crate) first: u32,
    last: u32,
    pub(crate) len: u32,
    /// True if connections were cut since it was last known to be connected.
    pub(crate) cut: bool,
    /// True if it is in [`Islands::loose`].
    listed: bool,
    /// Number of ends of connections that were cut since the remaining connections were last
    /// counted; saturating.
    cuts: u16,
    /// It is not searched before this step: see [`Islands::split_again`].
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
            at = body.sleep.next;
            Some(body)
        })
    }

    /// True if the recent cuts have as many ends as it has bodies.
    pub(crate) fn was_cut_often(&self) -> bool {
        self.len > 1 && u32::from(self.cuts) >= self.len.min(u32::from(u16::MAX))
    }

    /// True if its bodies have too few connections for a single island.
    fn is_apart(&self, bodies: &Bodies) -> bool {
        // Connecting n bodies takes at least n - 1 connections, each with two ends. Connections to
        // immovable bodies are counted too.
        let needed = 2 * u64::from(self.len.saturating_sub(1));
        let mut ends = 0;
        self.bodies(bodies).all(|body| {
            ends += u64::from(body.ties.constraints);
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
    /// Islands with many cut connections: at least as many cut ends as bodies. Counting the
    /// remaining connections then costs no more than the cuts did. An entry may be outdated, if its
    /// row now holds another island.
    loose: Vec<u32>,
    /// True if bodies freeze one by one, so that a woken body wakes alone and not with its island.
    pub(crate) wake_alone: bool,
    /// In that mode, a contact below this speed wakes nothing [m/s].
    pub(crate) gentle_speed: f32,
    /// Length of a typical body in this step [m].
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) length: f32,
    /// Number of dissolved islands. It tells a reader that islands may have changed: bodies of one
    /// may now be in several, with new numbers.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) dissolved: u64,
    /// Reused memory for the list of an island: see [`Self::members`].
    #[cfg_attr(feature = "serde", serde(skip))]
    spare: Vec<u32>,
}

impl Clone for Islands {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Reuses the existing lists.
    fn clone_from(&mut self, from: &Self) {
        let Self { rows, free, loose, wake_alone, gentle_speed, length, .. } = from;
        self.rows.clone_from(rows);
        self.free.clone_from(free);
        self.loose.clone_from(loose);
        self.wake_alone = *wake_alone;
        (self.gentle_speed, self.length) = (*gentle_speed, *length);
        self.dissolved = from.dissolved;
    }
}

impl Islands {
    /// True if a contact of these bodies is solved while it has points. A body that touches a
    /// sleeping body wakes it before the solve. If bodies wake alone, a sleeping body is immovable
    /// instead.
    pub(crate) fn solves(&self, a: &Body, b: &Body) -> bool {
        let moves = |body: &Body| body.active() && body.is_dynamic();
        (moves(a) || moves(b)) && (self.wake_alone || !(a.sleeps() || b.sleeps()))
    }

    /// Free rows.
    pub(in crate::state) fn free(&self) -> &[u32] {
        &self.free
    }

    /// True if every island in `loose` exists.
    pub(in crate::state) fn knows_loose(&self) -> bool {
        self.loose.iter().all(|island| (*island as usize) < self.rows.len())
    }

    /// A list of an island's bodies, for callers that change islands meanwhile. Return it with
    /// [`Self::give_back`].
    pub(crate) fn members(&mut self, island: u32, bodies: &Bodies) -> Vec<u32> {
        let mut list = core::mem::take(&mut self.spare);
        list.clear();
        let mut at = self.rows[island as usize].first;
        while at != NONE {
            list.push(at);
            at = bodies.at(at).sleep.next;
        }
        list
    }

    /// Takes back the list from [`Self::members`].
    pub(crate) fn give_back(&mut self, list: Vec<u32>) {
        self.spare = list;
    }

    /// Creates an island of one body.
    pub(crate) fn create(&mut self, body: u32, bodies: &mut Bodies) -> u32 {
        let island = self.free.pop().unwrap_or_else(|| {
            grow::push(&mut self.rows, Island::FREE);
            u32::try_from(self.rows.len() - 1).expect("fewer islands than bodies")
        });
        self.push(island, body, bodies);
        island
    }

    /// Appends a body that is in no island to an island.
    pub(crate) fn push(&mut self, island: u32, body: u32, bodies: &mut Bodies) {
        let row = &mut self.rows[island as usize];
        let b = bodies.at_mut(body);
        (b.sleep.island, b.sleep.previous, b.sleep.next) = (island, row.last, NONE);
        if row.last == NONE {
            row.first = body;
        } else {
            bodies.at_mut(row.last).sleep.next = body;
        }
        row.last = body;
        row.len += 1;
    }

    /// Empties an island and frees its row. Its bodies are in no island until they are added to
    /// one.
    pub(crate) fn dissolve(&mut self, island: u32) {
        self.free.push(island);
        self.dissolved += 1;
        self.rows[island as usize] = Island::FREE;
    }

    /// Merges the islands of two dynamic bodies.
    pub(crate) fn link(&mut self, a: u32, b: u32, bodies: &mut Bodies) {
        let (mut keep, mut give) = (bodies.at(a).sleep.island, bodies.at(b).sleep.island);
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
            body.sleep.island = keep;
            at = body.sleep.next;
        }
        let island = &mut self.rows[keep as usize];
        bodies.at_mut(island.last).sleep.next = given.first;
        bodies.at_mut(given.first).sleep.previous = island.last;
        island.last = given.last;
        island.len += given.len;
        island.cut |= given.cut;
        island.cuts = island.cuts.saturating_add(given.cuts);
        self.dissolve(give);
        self.list_if_loose(keep);
    }

    /// Delays the next search for components by one step per 128 bodies. A large island with some
    /// still bodies has cut connections in every step, and would otherwise be searched in every
    /// step.
    pub(crate) fn split_again(&mut self, island: u32, step: u64) {
        let row = &mut self.rows[island as usize];
        row.wait_until = step + u64::from(row.len / 128);
    }

    /// Records a cut connection of this body.
    pub(crate) fn cut(&mut self, body: u32, bodies: &Bodies) {
        let island = bodies.at(body).sleep.island;
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

    /// Takes an island from the list of frequently cut ones, if it can no longer be connected;
    /// `None` at the end of the list.
    pub(crate) fn next_loose(&mut self, bodies: &Bodies) -> Option<u32> {
        loop {
            let island = self.loose.pop()?;
            let row = &mut self.rows[island as usize];
            let often = row.listed && row.was_cut_often();
            row.listed = false;
            // Connections are counted only for awake bodies; an island is awake as a whole or not
            // at all.
            let counted = !self.wake_alone && row.first != NONE && bodies.at(row.first).active();
            if often && counted {
                row.cuts = 0;
                if row.is_apart(bodies) {
                    return Some(island);
                }
            }
        }
    }

    /// Removes a body from its island.
    pub(crate) fn remove(&mut self, body: u32, bodies: &mut Bodies) {
        let b = bodies.at_mut(body);
        let (island, previous, next) = (b.sleep.island, b.sleep.previous, b.sleep.next);
        if island == NONE {
            return;
        }
        (b.sleep.island, b.sleep.previous, b.sleep.next) = (NONE, NONE, NONE);
        let row = &mut self.rows[island as usize];
        if previous == NONE {
            row.first = next;
        } else {
            bodies.at_mut(previous).sleep.next = next;
        }
        if next == NONE {
            row.last = previous;
        } else {
            bodies.at_mut(next).sleep.previous = previous;
        }
        row.len -= 1;
        row.cut = true;
        if row.len == 0 {
            self.dissolve(island);
        }
    }
}
