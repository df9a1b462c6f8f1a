//! Contacts: one row per pair of shapes whose boxes overlap; a pair with a mesh has several rows,
//! one per manifold. Broadphase creates the rows, narrowphase writes the manifolds, and the solver
//! the impulses.

pub(crate) mod enter;
pub(crate) mod leave;
mod lists;
mod watched;
mod contact;

pub(crate) use self::contact::{Contact, ListLink, Point, Traits};

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

pub(crate) use self::watched::{Probe, Watch, Watched};
use super::bodies::body::Body;
use super::bodies::{Bodies, NONE, Track};
use super::def::material::ContactSoftness;
use crate::base::math::Vec3;
use crate::base::pair_set::{PairSet, pair_key};
use crate::base::quat::Quat;
use crate::base::simd::wide::prefetch_lines;
use crate::base::threads::disjoint::Apart;
use crate::base::threads::pieces::{PieceRows, Pieces, ReadPieceRows};
use crate::geometry::manifold::PairCache;

// These tables dominate the memory of a world with many contacts.
const _: () = assert!(size_of::<Watch>() + size_of::<Probe>() == 64);
const _: () = assert!(size_of::<Option<Contact>>() == 256);
const _: () = assert!(core::mem::offset_of!(Contact, next_part) / 64 == Contact::LISTS_LINE);

/// The data that narrowphase writes.
pub(crate) struct Lent<'a> {
    pub(crate) slots: Slots<'a>,
    pub(crate) watches: &'a mut [Watch],
    pub(crate) probes: &'a mut [Probe],
    pub(crate) softened: &'a mut [Softened],
}

/// Contact rows as lent to workers that only read them.
pub(crate) type ReadSlots<'a> = ReadPieceRows<'a, Option<Contact>>;

/// All rows of the table, for writing by several workers.
pub(crate) type Slots<'a> = PieceRows<'a, Option<Contact>>;

/// All rows, in which only [`Shared`] numbers change.
type Table = Pieces<Option<Contact>>;

/// All contacts.
#[derive(Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Contacts {
    rows: Pieces<Option<Contact>>,
    free: Vec<u32>,
    /// Derived from the rows.
    #[cfg_attr(feature = "serde", serde(skip))]
    pairs: PairSet,
    watched: Watched,
    /// New contacts of bodies that are not active. They are tested once, in the step in which they
    /// are created.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) asked: Vec<u32>,
    /// By rows: the softness that hooks kept or set in this step. Meaningless for contacts without
    /// hooks; empty in a step without hooks.
    #[cfg_attr(feature = "serde", serde(skip))]
    softened: Vec<Softened>,
}

/// The softness of a contact with hooks.
pub(crate) type Softened = Option<ContactSoftness>;

impl Clone for Contacts {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Reuses the existing lists.
    fn clone_from(&mut self, from: &Self) {
        // Results of hooks are valid only within a step.
        let Self { rows, free, pairs, watched, asked, softened: _ } = from;
        self.rows.clone_from(rows);
        self.free.clone_from(free);
        self.pairs.clone_from(pairs);
        self.watched.clone_from(watched);
        self.asked.clone_from(asked);
    }
}

impl Contacts {
    #[inline]
    pub(crate) fn at(&self, row: u32) -> &Contact {
        self.get(row).expect("tables name living contacts only")
    }

    #[inline]
    pub(crate) fn at_mut(&mut self, row: u32) -> &mut Contact {
        self.rows
            .get_mut(row as usize)
            .and_then(Option::as_mut)
            .expect("tables name living contacts only")
    }

    /// The contact in a row, if there is one.
    pub(crate) fn get(&self, row: u32) -> Option<&Contact> {
        self.rows.get(row as usize)?.as_ref()
    }

    /// Number of rows, free rows, watches, number of probes, and number of watches with an active
    /// body.
    pub(crate) fn parts(&self) -> (usize, &[u32], &[Watch], usize, usize) {
        let Watched { watches, probes, awake } = &self.watched;
        (self.rows.len(), &self.free, watches, probes.len(), *awake)
    }

    /// Rebuilds the set of pairs from the rows; false if two rows have the same pair.
    pub(crate) fn find_pairs(&mut self) -> bool {
        let mut pairs = PairSet::default();
        let firsts = self.iter().filter(|(_, c)| !c.is_part);
        let all = firsts.map(|(_, c)| pair_key(c.shape_a, c.shape_b)).all(|key| pairs.insert(key));
        self.pairs = pairs;
        all
    }

    /// Prefetches the first cache lines of a contact; one contains the bodies, four also the
    /// shapes.
    #[inline]
    pub(crate) fn prefetch(&self, row: u32, lines: usize) {
        if let Some(slot) = self.rows.get(row as usize) {
            prefetch_lines(slot, lines);
        }
    }

    /// Prefetches the entry that tells whether a pair has a contact. Affects only time, like the
    /// prefetches below.
    #[inline]
    pub(crate) fn prefetch_pair(&self, (shape_a, shape_b): (u32, u32)) {
        self.pairs.prefetch(pair_key(shape_a, shape_b));
    }

    /// All rows, including empty ones, for stages whose workers write rows.
    pub(crate) fn slots_mut(&mut self, apart: Apart) -> Slots<'_> {
        self.rows.lend(apart)
    }

    /// The same for the solver, with the softness from hooks.
    pub(crate) fn solved_mut(&mut self, apart: Apart) -> (Slots<'_>, &[Softened]) {
        (self.rows.lend(apart), &self.softened)
    }

    /// The same with the watches and probes.
    pub(crate) fn watched_mut(&mut self, apart: Apart) -> Lent<'_> {
        let Watched { watches, probes, awake } = &mut self.watched;
        let (watches, probes) = (&mut watches[..*awake], &mut probes[..*awake]);
        let softened = &mut self.softened;
        Lent { slots: self.rows.lend(apart), watches, probes, softened }
    }

    /// Allocates memory for the results of hooks in this step, if there are any hooks.
    pub(crate) fn begin_hooks(&mut self, are_asked: bool) {
        self.softened.clear();
        self.softened.resize(if are_asked { self.rows.len() } else { 0 }, None);
    }

    /// Watches of all awake pairs.
    pub(crate) fn awake_watches(&self) -> &[Watch] {
        &self.watched.watches[..self.watched.awake]
    }

    /// Bodies of each awake pair.
    pub(crate) fn awake_pairs(&self) -> impl Iterator<Item = [u32; 2]> {
        self.awake_watches().iter().map(|watch| [watch.body_a, watch.body_b])
    }

    /// Rows in order.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (u32, &Contact)> {
        (0_u32..).zip(self.rows.iter()).filter_map(|(i, c)| c.as_ref().map(|c| (i, c)))
    }

    pub(crate) fn has_pair(&self, shape_a: u32, shape_b: u32) -> bool {
        self.pairs.contains(pair_key(shape_a, shape_b))
    }

    /// Reserves space for `n` more contacts at once. Growing step by step would copy the table
    /// several times.
    pub(crate) fn make_room(&mut self, n: usize) {
        self.rows.make_room(n.saturating_sub(self.free.len()));
    }

    /// Takes an empty row, which must be filled and then entered.
    pub(crate) fn take_row(&mut self) -> u32 {
        self.free.pop().unwrap_or_else(|| {
            self.rows.push_default();
            u32::try_from(self.rows.len() - 1).expect("fewer than 2^31 contacts fit in memory")
        })
    }

    /// Moves the watch of a contact into or out of the awake part. Secondary manifolds have no
    /// watch.
    pub(crate) fn set_awake(&mut self, row: u32, awake: bool) {
        let contact = self.at(row);
        if !contact.is_part {
            let place = contact.probe.get() as usize;
            self.watched.set_awake(place, awake, &self.rows);
        }
    }

    /// Ends the single test of new contacts whose bodies are not active. Contacts whose bodies
    /// became active are unchanged.
    pub(crate) fn end_asking(&mut self, bodies: &Bodies) {
        let mut asked = core::mem::take(&mut self.asked);
        for row in asked.drain(..) {
            let is_active = |c: &Contact| [c.body_a, c.body_b].map(|body| bodies.at(body).active());
            if self.get(row).is_some_and(|c| is_active(c) == [false; 2]) {
                self.set_awake(row, false);
            }
        }
        self.asked = asked;
    }

    /// Updates the watch after the restitution of the contact changed.
    pub(crate) fn follow_restitution(&mut self, row: u32) {
        let contact = self.at(row);
        if !contact.is_part {
            let (place, bounces) = (contact.probe.get() as usize, contact.may_bounce());
            self.watched.watches[place].set_bounces(bounces);
        }
    }

    /// Forgets the gap of a contact after one of its bodies was moved by a call.
    pub(crate) fn forget_gap(&mut self, row: u32, tracks: &[Track]) {
        let contact = self.at(row);
        if !contact.is_part {
            let place = contact.probe.get() as usize;
            self.watched.watches[place].close(tracks);
        }
    }

    /// Forgets all gaps after the unit of displacements and gaps changed.
    pub(crate) fn forget_gaps(&mut self, tracks: &[Track]) {
        self.watched.watches.iter_mut().for_each(|watch| watch.close(tracks));
    }

    /// Invalidates the manifolds of a contact after one of its shapes was replaced or moved on its
    /// body. The points stay because they store impulses.
    pub(crate) fn forget_manifolds(&mut self, row: u32, tracks: &[Track]) {
        self.forget_gap(row, tracks);
        let first = self.at_mut(row);
        first.set_renewed();
        let place = first.probe.get() as usize;
        let mut at = row;
        while at != NONE {
            let contact = self.at_mut(at);
            contact.cache = PairCache::default();
            at = contact.next_part;
        }
        self.watched.probes[place].gap = 0.0;
    }

    /// Rotations of the bodies when the contact's manifold was made. Secondary manifolds use those
    /// of the first.
    pub(crate) fn rotations_of(&self, row: u32) -> [Quat; 2] {
        let first = self.at(row).first(row);
        let probe = &self.watched.probes[self.at(first).probe.get() as usize];
        [probe.rotation_a, probe.rotation_b]
    }

    /// Adjusts the anchors after the center of mass of one of the bodies moved on the body by
    /// `shift` [m, body]. The anchors stay in place and are measured from the new center.
    pub(crate) fn shift_center(&mut self, row: u32, side: u32, shift: Vec3) {
        // Secondary manifolds use the reference of the first.
        let moved = self.rotations_of(row)[side as usize].rotate(shift);
        let contact = self.at_mut(row);
        if side == 0 {
            for p in &mut contact.points {
                p.r_a -= moved;
            }
        }
        let by = if side == 0 { -moved } else { moved };
        contact.offset += by;
        if !contact.is_part {
            let place = contact.probe.get() as usize;
            self.watched.probes[place].offset += by;
        }
    }

    /// The contacts of a body: (row, side of the body).
    pub(crate) fn of_body(&self, body: &Body) -> impl Iterator<Item = (u32, u32)> {
        let mut at = body.ties.contacts;
        core::iter::from_fn(move || {
            (at != NONE).then(|| {
                let (row, side) = (at / 2, at & 1);
                at = self.at(row).links[side as usize].next.get();
                (row, side)
            })
        })
    }
}
