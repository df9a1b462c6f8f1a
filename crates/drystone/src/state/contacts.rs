//! Contacts: one row a pair of shapes whose boxes overlap; a pair with a mesh has several rows, one a
//! manifold. Rows are made by broadphase, manifolds written by narrowphase, impulses by the solver.

use super::bodies::{Bodies, Body, NONE};
use super::colors::Place;
use crate::base::grow;
use crate::base::math::Vec3;
use crate::base::pair_set::{PairSet, pair_key};
use crate::base::quat::Quat;
use crate::base::wide::prefetch_lines;
use crate::geometry::manifold::PairCache;

/// A point of a contact: half a cache line, a row of four numbers as the solver loads it first.
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct Point {
    /// From A's center of mass to the point [m, world], as it was when the manifold was made. That from
    /// B's is this less [`Contact::offset`].
    pub(crate) r_a: Vec3,
    /// Separation now [m].
    pub(crate) separation: f32,
    /// Accumulated impulse along the normal in a substep [N s].
    pub(crate) impulse: f32,
    /// Separation less that of the anchors along the normal, when the manifold was made [m].
    pub(crate) base: f32,
    pub(crate) feature: u32,
    /// A number of the contact, which has four of these: see [`Contact::approach`].
    word: f32,
}

impl Point {
    /// A new point in its place.
    #[inline]
    pub(crate) fn renew(&mut self, r_a: Vec3, separation: f32, impulse: f32, feature: u32) {
        // The anchors are one point when the manifold is made, so all of the separation is the base.
        let base = separation;
        *self = Self { r_a, separation, impulse, base, feature, word: self.word };
    }

    /// `r_a` with the separation.
    #[inline(always)]
    pub(crate) fn arm(&self) -> &[f32; 4] {
        let [arm, _]: &[[f32; 4]; 2] = bytemuck::cast_ref(self);
        arm
    }
}

/// What tells whether a pair must be tested again: the motion of its two bodies when the manifold was
/// made. One cache line a contact and these in a row, so that the many pairs that only come near each
/// other cost little.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(64))]
pub(crate) struct Probe {
    /// The contact.
    pub(crate) row: u32,
    pub(crate) body_a: u32,
    pub(crate) body_b: u32,
    /// How far apart the shapes were then, at least [m]; 0 if the pair has points or that is not
    /// known; infinite for a part that its first manifold takes care of.
    pub(crate) gap: f32,
    /// Center of B less that of A [m, world].
    pub(crate) offset: Vec3,
    pub(crate) rotation_a: Quat,
    pub(crate) rotation_b: Quat,
    /// The contact has restitution: within a step an impact can send one body into the other.
    pub(crate) bounces: bool,
}

impl Probe {
    /// Counts motion from here on; the gap is not known.
    #[inline]
    pub(crate) fn restart(&mut self, a: &Body, b: &Body) {
        self.gap = 0.0;
        self.offset = b.center - a.center;
        (self.rotation_a, self.rotation_b) = (a.rotation, b.rotation);
    }
}

/// A link in a body's list of contacts: contact row × 2 + side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Link {
    pub(crate) previous: u32,
    pub(crate) next: u32,
}

/// A contact. What the solver reads of it stands first, a cache line and half of one for each point.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct Contact {
    /// From A to B [world].
    pub(crate) normal: Vec3,
    pub(crate) friction: f32,
    /// Friction impulse of a substep [N s, world], twist about the normal as an impulse at the contact's
    /// reach [N s].
    pub(crate) tangent_impulse: Vec3,
    pub(crate) twist_impulse: f32,
    pub(crate) body_a: u32,
    pub(crate) body_b: u32,
    /// Center of B less that of A [m, world] when the manifold was made.
    pub(crate) offset: Vec3,
    /// Spinning resistance times radius [m].
    pub(crate) spinning: f32,
    pub(crate) count: u8,
    /// How many more manifolds of the pair have points. Of the first part only.
    pub(crate) others: u8,
    /// It is not the first manifold of its pair.
    pub(crate) is_part: bool,
    pub(crate) sensor: bool,
    /// Its begin was reported and its end not yet. Of the first part only.
    pub(crate) touching: bool,
    /// Manifolds may be recycled.
    pub(crate) recyclable: bool,
    /// A flat contact of these shapes is a disc.
    pub(crate) round_patch: bool,
    /// One of the surfaces moves over its shape.
    pub(crate) belt: bool,
    pub(crate) points: [Point; 4],
    pub(crate) shape_a: u32,
    pub(crate) shape_b: u32,
    /// Rolling resistance times radius [m].
    pub(crate) rolling: f32,
    pub(crate) restitution: f32,
    /// Kinetic friction as a part of static friction, at most 1.
    pub(crate) kinetic: f32,
    pub(crate) links: [Link; 2],
    /// Where it stands among the colors; nowhere while it has no points.
    pub(crate) place: Place,
    /// Where its [`Probe`] stands; of a part that is not the first, which has none, the row of the first.
    pub(crate) probe: u32,
    /// The next manifold of the same pair (meshes), or [`NONE`].
    pub(crate) next_part: u32,
    /// Of pairs with a mesh: how far was looked for points when the manifolds were made [m].
    pub(crate) looked: f32,
    pub(crate) cache: PairCache,
}

// A table of these is what a world of many contacts takes.
const _: () = assert!(size_of::<Option<Contact>>() == 256);

impl Contact {
    /// Cache lines that the solver reads.
    pub(crate) const SOLVER_LINES: usize = 3;
    /// All of them.
    pub(crate) const CACHE_LINES: usize = size_of::<Self>() / 64;

    /// Normal and friction; friction's impulses: the rows that the solver loads.
    #[inline(always)]
    pub(crate) const fn rows(&self) -> [[f32; 4]; 2] {
        let (n, p) = (self.normal, self.tangent_impulse);
        [[n.x, n.y, n.z, self.friction], [p.x, p.y, p.z, self.twist_impulse]]
    }

    /// The first manifold of its pair: itself, unless it is another part. `row` is its own.
    #[inline]
    pub(crate) const fn first(&self, row: u32) -> u32 {
        if self.is_part { self.probe } else { row }
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
        self.set_rolling_impulse(self.rolling_impulse() * factor);
    }

    /// Speed at which the shapes approach each other before they touch [m/s]. Like the rolling impulse it
    /// has the room that points leave in their cache lines, in use or not.
    #[inline]
    pub(crate) const fn approach(&self) -> f32 {
        self.points[3].word
    }

    #[inline]
    pub(crate) const fn set_approach(&mut self, speed: f32) {
        self.points[3].word = speed;
    }

    /// From B's center of mass to a point of it [m, world], as `r_a` is.
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

/// All contacts.
#[derive(Clone, Debug, Default)]
pub(crate) struct Contacts {
    rows: Vec<Option<Contact>>,
    free: Vec<u32>,
    pairs: PairSet,
    /// Of each contact, of pairs with several parts of the first only. Those with an active body come first.
    probes: Vec<Probe>,
    /// How many of them have an active body.
    awake: usize,
}

impl Contacts {
    #[inline]
    pub(crate) fn at(&self, row: u32) -> &Contact {
        self.rows[row as usize].as_ref().expect("tables name living contacts only")
    }

    #[inline]
    pub(crate) fn at_mut(&mut self, row: u32) -> &mut Contact {
        self.rows[row as usize].as_mut().expect("tables name living contacts only")
    }

    /// Asks for the first cache lines of a contact; one tells the bodies, four the shapes too.
    #[inline]
    pub(crate) fn prefetch(&self, row: u32, lines: usize) {
        if let Some(slot) = self.rows.get(row as usize) {
            prefetch_lines(slot, lines);
        }
    }

    /// All rows, empty ones too; for stages that lend rows to workers.
    pub(crate) fn slots_mut(&mut self) -> (&mut [Option<Contact>], &mut [Probe]) {
        (&mut self.rows, &mut self.probes[..self.awake])
    }

    /// Bodies of each pair that is awake.
    pub(crate) fn awake_pairs(&self) -> impl Iterator<Item = [u32; 2]> {
        self.probes[..self.awake].iter().map(|probe| [probe.body_a, probe.body_b])
    }

    /// Rows in order.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (u32, &Contact)> {
        (0_u32..).zip(&self.rows).filter_map(|(i, c)| c.as_ref().map(|c| (i, c)))
    }

    pub(crate) fn has_pair(&self, shape_a: u32, shape_b: u32) -> bool {
        self.pairs.contains(pair_key(shape_a, shape_b))
    }

    /// Adds a row, see [`Self::enter`].
    pub(crate) fn insert(&mut self, contact: Contact, bodies: &mut Bodies) -> u32 {
        let row = self.take_row();
        self.rows[row as usize] = Some(contact);
        self.enter(row, bodies);
        row
    }

    /// Makes room for `n` more at once: growing step by step would copy the table several times.
    pub(crate) fn make_room(&mut self, n: usize) {
        grow::make_room(&mut self.rows, n.saturating_sub(self.free.len()));
    }

    /// An empty row, to be filled and then entered.
    pub(crate) fn take_row(&mut self) -> u32 {
        self.free.pop().unwrap_or_else(|| {
            grow::push(&mut self.rows, None);
            u32::try_from(self.rows.len() - 1).expect("fewer than 2^31 contacts fit in memory")
        })
    }

    /// Links a filled row into its bodies' lists; its links are set here and it gets a probe, not awake.
    pub(crate) fn enter(&mut self, row: u32, bodies: &mut Bodies) {
        let place = u32::try_from(self.probes.len()).expect("fewer than 2^31 contacts");
        let contact = self.at_mut(row);
        let sides @ [body_a, body_b] = [contact.body_a, contact.body_b];
        let (is_part, key) = (contact.is_part, pair_key(contact.shape_a, contact.shape_b));
        if !is_part {
            contact.probe = place;
            grow::push(&mut self.probes, Probe { row, body_a, body_b, ..Probe::default() });
        }
        for (side, body) in (0_u32..).zip(sides) {
            let body = bodies.at_mut(body);
            let me = row * 2 + side;
            let next = core::mem::replace(&mut body.contacts, me);
            self.at_mut(row).links[side as usize] = Link { previous: NONE, next };
            if next != NONE {
                // The two sides of one contact are on different bodies, so `next` is another row.
                self.at_mut(next / 2).links[(next & 1) as usize].previous = me;
            }
        }
        if !is_part {
            self.pairs.insert(key);
        }
    }

    /// Takes a row out of the lists; it must be in no color. Gives its bodies.
    pub(crate) fn remove(&mut self, row: u32, bodies: &mut Bodies) -> [u32; 2] {
        self.set_awake(row, false);
        let contact = self.at(row);
        if !contact.is_part {
            let place = contact.probe;
            self.probes.swap_remove(place as usize);
            self.place_probe(place);
        }
        let contact = self.at(row);
        let (links, sides) = (contact.links, [contact.body_a, contact.body_b]);
        let key = pair_key(contact.shape_a, contact.shape_b);
        if !contact.is_part {
            self.pairs.remove(key);
        }
        self.rows[row as usize] = None;
        for side in 0..2_usize {
            let Link { previous, next } = links[side];
            if previous == NONE {
                bodies.at_mut(sides[side]).contacts = next;
            } else {
                self.at_mut(previous / 2).links[(previous & 1) as usize].next = next;
            }
            if next != NONE {
                self.at_mut(next / 2).links[(next & 1) as usize].previous = previous;
            }
        }
        self.free.push(row);
        sides
    }

    /// Moves a contact's probe to those that are awake or away from them. Other parts than the first have
    /// none.
    pub(crate) fn set_awake(&mut self, row: u32, awake: bool) {
        let contact = self.at(row);
        let (place, bounces) = (contact.probe as usize, contact.restitution > 0.0);
        if contact.is_part || awake == (place < self.awake) {
            return;
        }
        // The first that is not awake, or the last that is: the border runs on its other side then.
        let border = if awake { self.awake } else { self.awake - 1 };
        self.awake = if awake { border + 1 } else { border };
        self.probes[place].bounces = bounces;
        self.probes.swap(place, border);
        for moved in [place, border] {
            self.place_probe(u32::try_from(moved).expect("fewer than 2^31 contacts"));
        }
    }

    /// Tells the contact of the probe at `place` that it stands there.
    fn place_probe(&mut self, place: u32) {
        if let Some(probe) = self.probes.get(place as usize) {
            let row = probe.row;
            self.at_mut(row).probe = place;
        }
    }

    /// Rotations of the bodies when the contact's manifold was made: of parts that of the first one's.
    pub(crate) fn rotations_of(&self, row: u32) -> [Quat; 2] {
        let first = self.at(row).first(row);
        let probe = &self.probes[self.at(first).probe as usize];
        [probe.rotation_a, probe.rotation_b]
    }

    /// The center of mass of one of a contact's bodies was put elsewhere, `shift` [m, body]: anchors are
    /// told from there now, and stay where they are.
    pub(crate) fn shift_center(&mut self, row: u32, side: u32, shift: Vec3) {
        // Of parts, the reference is that of the first one.
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
            let place = contact.probe as usize;
            self.probes[place].offset += by;
        }
    }

    /// The contacts of a body: (row, side it is on).
    pub(crate) fn of_body(&self, body: &Body) -> impl Iterator<Item = (u32, u32)> {
        let mut at = body.contacts;
        core::iter::from_fn(move || {
            (at != NONE).then(|| {
                let (row, side) = (at / 2, at & 1);
                at = self.at(row).links[side as usize].next;
                (row, side)
            })
        })
    }
}
