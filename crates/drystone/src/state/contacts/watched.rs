//! Watches of contacts: small rows. Those with an active body come first.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::{Contact, Table};
use crate::base::math::Vec3;
use crate::base::quat::Quat;
use crate::base::simd::wide::prefetch;
use crate::state::bodies::Track;
use crate::state::bodies::body::Body;

/// Decides whether a pair may be near enough to test, from the possible motion of its bodies. It is
/// small and contiguous: in a heap most pairs can be skipped in most steps, and their watches are
/// then the only data read.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Watch {
    /// The contact's row × 4, + 2 if it has several manifolds, + 1 if it has restitution. With
    /// restitution, an impact can send one body into the other within a step.
    row: u32,
    pub(crate) body_a: u32,
    pub(crate) body_b: u32,
    /// The pair cannot touch until the path lengths of both bodies sum to this: see [`Track`]. It
    /// wraps like they do.
    limit: u32,
}

impl Watch {
    const BOUNCES: u32 = 1;
    const HAS_PARTS: u32 = 2;

    /// A watch for a contact whose shapes may be anywhere.
    pub(super) fn new(row: u32, [body_a, body_b]: [u32; 2], has_parts: bool) -> Self {
        Self { row: row * 4 + u32::from(has_parts) * Self::HAS_PARTS, body_a, body_b, limit: 0 }
    }

    /// Row of the contact.
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

    /// True if one of the shapes is a mesh.
    #[inline]
    pub(crate) const fn has_parts(&self) -> bool {
        self.row & Self::HAS_PARTS != 0
    }

    /// Marks the distance of the shapes as unknown, so that the pair is tested.
    #[inline]
    pub(crate) fn close(&mut self, tracks: &[Track]) {
        let path = |body: u32| tracks[body as usize].path;
        self.limit = path(self.body_a).wrapping_add(path(self.body_b));
    }

    /// Sets the current minimum distance of the shapes [m].
    #[inline]
    pub(crate) fn open(&mut self, gap: f32, tracks: &[Track]) {
        self.close(tracks);
        self.limit = self.limit.wrapping_add(Track::at_most(gap));
    }

    /// True if the pair cannot come closer than `margin` (in [`Track`]'s units) in this step.
    #[inline]
    pub(crate) fn waits(&self, margin: u32, tracks: &[Track]) -> bool {
        let (a, b) = (tracks[self.body_a as usize], tracks[self.body_b as usize]);
        self.is_farther_than(margin + a.ahead + b.ahead, [a, b])
    }

    /// True if the bodies may have met, given the lengths of their paths.
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
        let left = self.limit.wrapping_sub(a.path.wrapping_add(b.path));
        // Wrapped negative numbers are in the upper half.
        left > distance && left < 1 << 31
    }
}

/// Decides more precisely whether a pair must be tested again: the relative pose of its bodies when
/// the manifold was made.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[repr(C, align(16))]
pub(crate) struct Probe {
    /// Lower bound on the distance of the shapes at that time [m]; 0 if the pair has points or the
    /// distance is not known. Infinite for a secondary manifold, for which the first one is tested.
    pub(crate) gap: f32,
    /// Center of B minus center of A [m, world].
    pub(crate) offset: Vec3,
    pub(crate) rotation_a: Quat,
    pub(crate) rotation_b: Quat,
}

impl Probe {
    /// Restarts the measurement of motion at the current poses, with this distance of the shapes
    /// [m], 0 if it is not known.
    #[inline]
    pub(crate) fn restart(&mut self, gap: f32, a: &Body, b: &Body) {
        self.gap = gap;
        self.offset = b.center - a.center;
        (self.rotation_a, self.rotation_b) = (a.rotation, b.rotation);
    }
}

/// Watches and probes of all contacts, one per pair. Those with an active body come first.
#[derive(Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Watched {
    pub(crate) watches: Vec<Watch>,
    /// Probes in the same order.
    pub(crate) probes: Vec<Probe>,
    /// Number of watches with an active body.
    pub(crate) awake: usize,
}

impl Clone for Watched {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Reuses the existing lists.
    fn clone_from(&mut self, from: &Self) {
        let Self { watches, probes, awake } = from;
        self.watches.clone_from(watches);
        self.probes.clone_from(probes);
        self.awake = *awake;
    }
}

impl Watched {
    /// Moves the entry at `place` into or out of the awake part. Returns its new place.
    pub(super) fn set_awake(&mut self, place: usize, awake: bool, table: &Table) -> usize {
        if awake == (place < self.awake) {
            return place;
        }
        // The first entry that is not awake, or the last awake one. The boundary then moves to its
        // other side.
        let border = if awake { self.awake } else { self.awake - 1 };
        self.awake = if awake { border + 1 } else { border };
        self.watches.swap(place, border);
        self.probes.swap(place, border);
        self.tell(place, table);
        self.tell(border, table);
        border
    }

    /// Prefetches the entries that [`Self::remove`] will write for a contact, `ahead` contacts
    /// before.
    pub(super) fn prefetch(&self, row: u32, ahead: usize, table: &Table) {
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

    /// Removes the entry at `place`.
    pub(super) fn remove(&mut self, place: usize, table: &Table) {
        let place = self.set_awake(place, false, table);
        self.watches.swap_remove(place);
        self.probes.swap_remove(place);
        self.tell(place, table);
    }

    /// Stores the index `place` in the contact that is watched there, if there is one.
    pub(super) fn tell(&self, place: usize, table: &Table) {
        if let Some(watch) = self.watches.get(place)
            && let Some(contact) = table.read(watch.row() as usize)
        {
            contact.probe.set(u32::try_from(place).expect("fewer than 2^30 contacts"));
        }
    }
}
