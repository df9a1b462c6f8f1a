//! Contacts: one row per pair of shapes whose boxes overlap; a pair with a mesh has several rows,
//! one per manifold. Broadphase creates the rows, narrowphase writes the manifolds, and the solver
//! the impulses.

pub(crate) mod enter;
pub(crate) mod leave;
mod lists;
mod watched;

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

pub(crate) use self::watched::{Probe, Watch, Watched};
use super::bodies::{Bodies, Body, NONE, Track};
use super::colors::Place;
use super::def::BodyKind;
use super::def::material::ContactSoftness;
use crate::base::math::Vec3;
use crate::base::pair_set::{PairSet, pair_key};
use crate::base::quat::Quat;
use crate::base::simd::wide::prefetch_lines;
use crate::base::threads::disjoint::Apart;
use crate::base::threads::pieces::{PieceRows, Pieces};
use crate::base::threads::shared::Shared;
use crate::geometry::manifold::PairCache;

/// A contact point: half a cache line. The first row of four numbers is loaded by the solver.
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[repr(C)]
pub(crate) struct Point {
    /// Vector from A's center of mass to the point [m, world], when the manifold was made. The
    /// vector from B's center is this minus [`Contact::offset`].
    pub(crate) r_a: Vec3,
    /// Current separation [m].
    pub(crate) separation: f32,
    /// Accumulated impulse along the normal in a substep [N s].
    pub(crate) impulse: f32,
    /// Separation minus that of the anchors along the normal, when the manifold was made [m].
    pub(crate) base: f32,
    pub(crate) feature: u32,
    /// One of four numbers stored for the contact: see [`Contact::approach`].
    word: f32,
}

impl Point {
    /// Replaces the point and keeps `word`.
    #[inline]
    pub(crate) fn renew(&mut self, r_a: Vec3, separation: f32, impulse: f32, feature: u32) {
        // The anchors coincide when the manifold is made, so the base is the whole separation.
        let base = separation;
        *self = Self { r_a, separation, impulse, base, feature, word: self.word };
    }

    /// `r_a` together with the separation.
    #[inline(always)]
    pub(crate) fn arm(&self) -> &[f32; 4] {
        let [arm, _]: &[[f32; 4]; 2] = bytemuck::cast_ref(self);
        arm
    }
}

/// A link in a body's list of contacts: contact row × 2 + side. It belongs to the body, because two
/// workers may write the two links of a contact at once.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Link {
    pub(crate) previous: Shared,
    pub(crate) next: Shared,
}

impl Default for Link {
    fn default() -> Self {
        Self { previous: Shared::new(NONE), next: Shared::new(NONE) }
    }
}

/// Additional properties of a contact, one bit each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Traits(u8);

impl Traits {
    /// One of the surfaces moves along its shape.
    pub(crate) const BELT: Self = Self(1);
    /// A rule sets its softness.
    pub(crate) const SOFT: Self = Self(2);
    /// Hooks are called for it, and may set its restitution and softness for a step.
    pub(crate) const HOOKED: Self = Self(4);
    /// Not from the surfaces: it is being separated, because its overlap exceeds the amount that
    /// its load explains.
    pub(crate) const PARTING: Self = Self(8);
    /// Not from the surfaces: it was hit in the last step and does not bounce. The remaining
    /// approach belongs to the same landing.
    pub(crate) const STRUCK: Self = Self(16);
    /// Not from the surfaces: its compression under load was large, and is being removed.
    pub(crate) const SETTLES: Self = Self(32);

    #[must_use]
    pub(crate) const fn with(self, traits: Self, have: bool) -> Self {
        if have { Self(self.0 | traits.0) } else { Self(self.0 & !traits.0) }
    }

    pub(crate) const fn any(self, of: Self) -> bool {
        self.0 & of.0 != 0
    }

    /// Whether its softness may differ from the world's.
    pub(crate) const fn may_soften(self) -> bool {
        self.any(Self(Self::SOFT.0 | Self::HOOKED.0))
    }

    /// The properties that come from the surfaces.
    pub(crate) const fn of_surfaces(self) -> Self {
        Self(self.0 & !(Self::PARTING.0 | Self::STRUCK.0 | Self::SETTLES.0))
    }

    /// True if the surfaces set no additional property.
    pub(crate) const fn is_plain(self) -> bool {
        self.of_surfaces().0 == 0
    }
}

/// A contact. The data that the solver reads come first: one cache line, and half a line per point.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[repr(C, align(64))]
pub(crate) struct Contact {
    /// Normal from A to B [world].
    pub(crate) normal: Vec3,
    pub(crate) friction: f32,
    /// Friction impulse of a substep [N s, world], and the twist impulse about the normal as an
    /// impulse at the contact's radius [N s].
    pub(crate) tangent_impulse: Vec3,
    pub(crate) twist_impulse: f32,
    pub(crate) body_a: u32,
    pub(crate) body_b: u32,
    /// Center of B minus center of A [m, world], when the manifold was made.
    pub(crate) offset: Vec3,
    /// Spinning resistance times radius [m].
    pub(crate) spinning: f32,
    pub(crate) count: u8,
    /// Number of further manifolds of the pair that have points. Only in the first manifold.
    pub(crate) others: u8,
    /// True for a secondary manifold of its pair.
    pub(crate) is_part: bool,
    pub(crate) sensor: bool,
    /// True while its begin was reported and its end was not. Only in the first manifold.
    pub(crate) touching: bool,
    /// True if its manifolds may be recycled.
    pub(crate) recyclable: bool,
    /// True if a flat contact of these shapes is a disc.
    pub(crate) round_patch: bool,
    pub(crate) traits: Traits,
    pub(crate) points: [Point; 4],
    pub(crate) shape_a: u32,
    pub(crate) shape_b: u32,
    /// Rolling resistance times radius [m].
    pub(crate) rolling: f32,
    pub(crate) restitution: f32,
    /// Ratio of kinetic to static friction, at most 1.
    pub(crate) kinetic: f32,
    pub(crate) links: [Link; 2],
    /// Place in the colors; nowhere while it has no points.
    pub(crate) place: Place,
    /// Index of its [`Probe`]. Secondary manifolds have none and store the row of the first
    /// manifold. Atomic: it is written while others borrow the contact.
    pub(crate) probe: Shared,
    /// The next manifold of the same pair (meshes), or [`NONE`].
    pub(crate) next_part: u32,
    /// For mesh pairs: lower bound on the distance of the triangles that got no points when the
    /// manifolds were made [m]. For other pairs: rotation of the pair before a corner without a
    /// point comes down [rad]. Negative: the solver rebuilt the manifold.
    pub(crate) clear: f32,
    pub(crate) cache: PairCache,
}

// These tables dominate the memory of a world with many contacts.
const _: () = assert!(size_of::<Watch>() + size_of::<Probe>() == 64);
const _: () = assert!(size_of::<Option<Contact>>() == 256);
const _: () = assert!(core::mem::offset_of!(Contact, next_part) / 64 == Contact::LISTS_LINE);

impl Contact {
    /// Number of cache lines that the solver reads.
    pub(crate) const SOLVER_LINES: usize = 3;
    /// Cache line with its links and places. The first line tells whether a row is empty.
    pub(crate) const LISTS_LINE: usize = core::mem::offset_of!(Self, links) / 64;
    /// Total number of cache lines.
    pub(crate) const CACHE_LINES: usize = size_of::<Self>() / 64;

    /// The rows that the solver loads: normal and friction, and the friction impulses.
    #[inline(always)]
    pub(crate) const fn rows(&self) -> [[f32; 4]; 2] {
        let (n, p) = (self.normal, self.tangent_impulse);
        [[n.x, n.y, n.z, self.friction], [p.x, p.y, p.z, self.twist_impulse]]
    }

    /// Row of the first manifold of its pair. `row` is the row of this contact.
    #[inline]
    pub(crate) fn first(&self, row: u32) -> u32 {
        if self.is_part { self.probe.get() } else { row }
    }

    /// Rolling impulse of a substep [N m s, world].
    #[inline]
    pub(crate) const fn rolling_impulse(&self) -> Vec3 {
        let [x, y, z, _] = &self.points;
        Vec3 { x: x.word, y: y.word, z: z.word }
    }

    #[inline]
    pub(crate) const fn set_rolling_impulse(&mut self, impulse: Vec3) {
        let [x, y, z, _] = &mut self.points;
        (x.word, y.word, z.word) = (impulse.x, impulse.y, impulse.z);
    }

    /// Multiplies all impulses.
    pub(crate) fn scale_impulses(&mut self, factor: f32) {
        for point in &mut self.points {
            point.impulse *= factor;
        }
        self.tangent_impulse *= factor;
        self.twist_impulse *= factor;
        if self.rolling > 0.0 {
            self.set_rolling_impulse(self.rolling_impulse() * factor);
        }
    }

    /// Part of its compression under load that has been removed [m]: see
    /// `step/narrowphase/settling.rs`. It shares memory with the rolling impulse: the compression
    /// is not removed for contacts with rolling resistance.
    #[inline]
    pub(crate) const fn settled(&self) -> f32 {
        if self.rolling > 0.0 { 0.0 } else { self.points[0].word }
    }

    #[inline]
    pub(crate) const fn set_settled(&mut self, depth: f32) {
        if !(self.rolling > 0.0) {
            self.points[0].word = depth;
        }
    }

    /// Approach speed of the shapes before they touch [m/s]. Like the rolling impulse, it is stored
    /// in the spare word of a point, used or not.
    #[inline]
    pub(crate) const fn approach(&self) -> f32 {
        self.points[3].word
    }

    #[inline]
    pub(crate) const fn set_approach(&mut self, speed: f32) {
        self.points[3].word = speed;
    }

    /// True if the solver rebuilt its manifold at the current poses of the bodies. The poses of its
    /// earlier manifold are then meaningless.
    #[inline]
    pub(crate) fn is_renewed(&self) -> bool {
        self.clear < 0.0
    }

    /// Marks the manifold as rebuilt by the solver.
    pub(crate) fn set_renewed(&mut self) {
        self.clear = -1.0;
    }

    /// True if the contact may reflect an impact within the step.
    #[inline]
    pub(crate) const fn may_bounce(&self) -> bool {
        self.restitution > 0.0 || self.traits.any(Traits::HOOKED)
    }

    /// True if it needs more than normal and friction impulses.
    pub(crate) fn is_special(&self, bodies: &Bodies) -> bool {
        let kinematic = |body: u32| bodies.at(body).kind == BodyKind::Kinematic;
        let surface = self.restitution > 0.0
            || self.rolling > 0.0
            || self.kinetic < 1.0
            || !self.traits.is_plain();
        surface || kinematic(self.body_a) || kinematic(self.body_b)
    }

    /// Vector from B's center of mass to a point [m, world], like `r_a`.
    #[inline(always)]
    pub(crate) fn r_b(&self, p: &Point) -> Vec3 {
        p.r_a - self.offset
    }

    /// The points in use.
    #[inline]
    pub(crate) fn points(&self) -> &[Point] {
        &self.points[..usize::from(self.count)]
    }
}

/// The data that narrowphase writes.
pub(crate) struct Lent<'a> {
    pub(crate) slots: Slots<'a>,
    pub(crate) watches: &'a mut [Watch],
    pub(crate) probes: &'a mut [Probe],
    pub(crate) softened: &'a mut [Softened],
}

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
    pub(crate) fn ask_for_pair(&self, (shape_a, shape_b): (u32, u32)) {
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
        let mut at = body.contacts;
        core::iter::from_fn(move || {
            (at != NONE).then(|| {
                let (row, side) = (at / 2, at & 1);
                at = self.at(row).links[side as usize].next.get();
                (row, side)
            })
        })
    }
}
