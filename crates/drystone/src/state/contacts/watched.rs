//! What is watched of contacts: small rows, of which those with an active body come first.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::{Contact, Table};
use crate::base::math::Vec3;
use crate::base::quat::Quat;
use crate::base::wide::prefetch;
use crate::state::bodies::{Body, Track};

/// What tells whether a pair may be near enough to be looked at: how far its bodies may come. Small and in a row, for
/// in a heap most pairs wait in most steps, and this is then all that is read of them.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Watch {
    /// The contact's row × 4, + 2 if it has parts, + 1 if it has restitution: within a step an impact can send one body
    /// into the other.
    row: u32,
    pub(crate) body_a: u32,
    pub(crate) body_b: u32,
    /// What the ways of both together must come to before the pair can touch: see [`Track`]. Goes round as they do.
    limit: u32,
}

impl Watch {
    const BOUNCES: u32 = 1;
    const HAS_PARTS: u32 = 2;

    /// Of a contact whose shapes may be anywhere.
    pub(super) fn new(row: u32, [body_a, body_b]: [u32; 2], has_parts: bool) -> Self {
        Self { row: row * 4 + u32::from(has_parts) * Self::HAS_PARTS, body_a, body_b, limit: 0 }
    }

    /// The contact.
    #[inline]
    pub(crate) const fn row(&self) -> u32 {
        self.row / 4
    }

    #[inline]
    pub(crate) const fn bounces(&self) -> bool {
        self.row & Self::BOUNCES != 0
    }

    pub(super) fn set_bounces(&mut self, bounces: bool) {
        self.row = (self.row & !Self::BOUNCES) | (u32::from(bounces) * Self::BOUNCES);
    }

    /// One of the shapes is a mesh.
    #[inline]
    pub(crate) const fn has_parts(&self) -> bool {
        self.row & Self::HAS_PARTS != 0
    }

    /// How far apart the shapes are is not known: it waits no more.
    #[inline]
    pub(crate) fn close(&mut self, tracks: &[Track]) {
        let way = |body: u32| tracks[body as usize].way;
        self.limit = way(self.body_a).wrapping_add(way(self.body_b));
    }

    /// The shapes are as far apart now, at least [m].
    #[inline]
    pub(crate) fn open(&mut self, gap: f32, tracks: &[Track]) {
        self.close(tracks);
        self.limit = self.limit.wrapping_add(Track::at_most(gap));
    }

    /// True if the pair cannot come as near as `margin` (in [`Track`]'s units) in this step.
    #[inline]
    pub(crate) fn waits(&self, margin: u32, tracks: &[Track]) -> bool {
        let (a, b) = (tracks[self.body_a as usize], tracks[self.body_b as usize]);
        self.is_farther_than(margin + a.ahead + b.ahead, [a, b])
    }

    /// True if the bodies may have come together on the ways that they went.
    #[inline]
    pub(crate) fn may_have_met(&self, tracks: &[Track]) -> bool {
        let (a, b) = (tracks[self.body_a as usize], tracks[self.body_b as usize]);
        !self.is_farther_than(0, [a, b])
    }

    /// True if one of the bodies is static.
    #[inline]
    pub(crate) fn has_static(&self, tracks: &[Track]) -> bool {
        tracks[self.body_a as usize].is_static() || tracks[self.body_b as usize].is_static()
    }

    fn is_farther_than(&self, distance: u32, [a, b]: [Track; 2]) -> bool {
        let left = self.limit.wrapping_sub(a.way.wrapping_add(b.way));
        // The upper half of all numbers are those below 0.
        left > distance && left < 1 << 31
    }
}

/// What tells more closely whether a pair must be tested again: the poses of its two bodies against each other when
/// the manifold was made.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[repr(C, align(16))]
pub(crate) struct Probe {
    /// How far apart the shapes were then, at least [m]; 0 if the pair has points or that is not
    /// known; infinite for a part that its first manifold takes care of.
    pub(crate) gap: f32,
    /// Center of B less that of A [m, world].
    pub(crate) offset: Vec3,
    pub(crate) rotation_a: Quat,
    pub(crate) rotation_b: Quat,
}

impl Probe {
    /// Counts motion from here on, where the shapes are so far apart [m], 0 if that is not known.
    #[inline]
    pub(crate) fn restart(&mut self, gap: f32, a: &Body, b: &Body) {
        self.gap = gap;
        self.offset = b.center - a.center;
        (self.rotation_a, self.rotation_b) = (a.rotation, b.rotation);
    }
}

/// What is watched of each contact, of pairs with several parts of the first only. Those with an active body come first.
#[derive(Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Watched {
    pub(crate) watches: Vec<Watch>,
    /// In the same order.
    pub(crate) probes: Vec<Probe>,
    /// How many of them have an active body.
    pub(crate) awake: usize,
}

impl Clone for Watched {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Into the lists that are there.
    fn clone_from(&mut self, from: &Self) {
        let Self { watches, probes, awake } = from;
        self.watches.clone_from(watches);
        self.probes.clone_from(probes);
        self.awake = *awake;
    }
}

impl Watched {
    /// Moves what stands at `place` to those that are awake or away from them; gives its new place.
    pub(super) fn set_awake(&mut self, place: usize, awake: bool, table: &Table) -> usize {
        if awake == (place < self.awake) {
            return place;
        }
        // The first that is not awake, or the last that is: the border runs on its other side then.
        let border = if awake { self.awake } else { self.awake - 1 };
        self.awake = if awake { border + 1 } else { border };
        self.watches.swap(place, border);
        self.probes.swap(place, border);
        self.tell(place, table);
        self.tell(border, table);
        border
    }

    /// Asks for what [`Self::remove`] will write to for a contact, `ahead` others before.
    pub(super) fn ask_for(&self, row: u32, ahead: usize, table: &Table) {
        let place = table.read(row as usize).as_ref().map_or(0, |c| c.probe.get() as usize);
        if let (Some(watch), Some(probe)) = (self.watches.get(place), self.probes.get(place)) {
            prefetch(watch);
            prefetch(probe);
        }
        for end in [self.awake, self.watches.len()] {
            if let Some(last) = self.watches.get(end.wrapping_sub(ahead + 1)) {
                table.prefetch_line(last.row() as usize, Contact::LISTS_LINE);
            }
        }
    }

    /// Takes out what stands at `place`.
    pub(super) fn remove(&mut self, place: usize, table: &Table) {
        let place = self.set_awake(place, false, table);
        self.watches.swap_remove(place);
        self.probes.swap_remove(place);
        self.tell(place, table);
    }

    /// Tells the contact that is watched at `place`, if any is, that it is there.
    pub(super) fn tell(&self, place: usize, table: &Table) {
        if let Some(watch) = self.watches.get(place)
            && let Some(contact) = table.read(watch.row() as usize)
        {
            contact.probe.set(u32::try_from(place).expect("fewer than 2^30 contacts"));
        }
    }
}
