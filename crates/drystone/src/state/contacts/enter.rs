//! Enters new contacts into the tables. Allocation of rows and places is serial; filling is
//! parallel. The result equals that of serial insertion.
#![expect(unsafe_code, reason = "promises that rows are kept apart")]

use super::lists::{Links, Owners, prefetch_heads};
use super::{Contact, Contacts, Probe, Table, Watch};
use crate::base::grow;
use crate::base::threads::disjoint::{Apart, Rows};
use crate::base::threads::jobs::{Jobs, for_each, for_ranges, grain};
use crate::base::threads::shared::Shared;
use crate::geometry::collide::MAX_PARTS;
use crate::state::bodies::body::Body;
use crate::state::bodies::{Bodies, NONE, Track};

/// Prefetch distance, in contacts.
const PREFETCH: usize = 4;

/// Minimum number of contacts for parallel work.
const MIN: usize = 64;

/// A new contact, from the detection of its pair until it is in all lists.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Newcomer {
    pub(crate) row: u32,
    pub(crate) bodies: [u32; 2],
    /// One of its bodies is active.
    pub(crate) awake: bool,
    /// No body is active, and the contact is tested once.
    pub(crate) asked: bool,
    /// The pair has a mesh, and thus further manifolds.
    pub(crate) has_parts: bool,
    parts: [u32; MAX_PARTS - 1],
    /// Index of its watch and its probe.
    place: u32,
}

impl Newcomer {
    /// Rows of all manifolds, including the first.
    fn rows(&self) -> impl Iterator<Item = u32> {
        let parts = if self.has_parts { self.parts.as_slice() } else { &[] };
        core::iter::once(self.row).chain(parts.iter().copied())
    }
}

impl Contacts {
    /// Takes a row for each of `n` new contacts.
    pub(crate) fn take_rows(&mut self, n: usize, new: &mut Vec<Newcomer>) {
        self.make_room(n);
        new.clear();
        new.extend((0..n).map(|_| Newcomer { row: self.take_row(), ..Newcomer::default() }));
    }

    /// Enters contacts whose rows are filled; `keys` are the keys of their pairs, which are not in
    /// the table yet.
    pub(crate) fn enter(
        &mut self,
        keys: &[u64],
        new: &mut [Newcomer],
        bodies: &mut Bodies,
        jobs: &Jobs<'_>,
    ) {
        self.make_places(new, jobs);
        let parts = new.iter().filter(|n| n.has_parts).count() * (MAX_PARTS - 1);
        self.make_room(parts);
        for n in new.iter_mut().filter(|n| n.has_parts) {
            n.parts = core::array::from_fn(|_| self.take_row());
        }
        self.fill(new, &bodies.tracks, jobs);
        self.link(new, bodies, jobs);
        self.pairs.insert_new(keys, jobs);
    }

    /// Assigns each new contact its index in the watches. Awake ones go behind the other awake
    /// ones.
    fn make_places(&mut self, new: &mut [Newcomer], jobs: &Jobs<'_>) {
        let active = new.iter().filter(|n| n.awake).count();
        let Self { rows, watched, .. } = self;
        let (first, len) = (watched.awake, watched.watches.len());
        let asleep = len - first;
        grow::resize(&mut watched.watches, len + new.len(), Watch::default());
        grow::resize(&mut watched.probes, len + new.len(), Probe::default());
        // Sleeping watches shift back to make room.
        let (moved, to) = (asleep.min(active), first + asleep.max(active));
        watched.watches.copy_within(first..first + moved, to);
        watched.probes.copy_within(first..first + moved, to);
        watched.awake += active;
        let (table, watched) = (&*rows, &*watched);
        for_ranges(jobs, moved, grain(jobs, moved, MIN), |range| {
            range.for_each(|i| watched.tell(to + i, table));
        });
        let mut next = [number(first + asleep + active), number(first)];
        for n in new {
            let next = &mut next[usize::from(n.awake)];
            n.place = *next;
            *next += 1;
        }
    }

    /// Creates the watches and secondary manifolds, and stores their indices in the contacts.
    fn fill(&mut self, new: &[Newcomer], tracks: &[Track], jobs: &Jobs<'_>) {
        let Self { rows, watched, .. } = self;
        // SAFETY: each new contact has its own rows and places.
        let apart = unsafe { Apart::promise() };
        let slots = rows.lend(apart);
        let watches = Rows::new(&mut watched.watches, apart);
        let probes = Rows::new(&mut watched.probes, apart);
        for_ranges(jobs, new.len(), grain(jobs, new.len(), MIN), |range| {
            for n in &new[range] {
                let Some(contact) = slots.row(n.row as usize) else { continue };
                contact.probe.set(n.place);
                let watch = watches.row(n.place as usize);
                *watch = Watch::new(n.row, n.bodies, n.has_parts);
                watch.set_bounces(contact.may_bounce());
                watch.close(tracks);
                *probes.row(n.place as usize) = Probe::default();
                if !n.has_parts {
                    continue;
                }
                contact.next_part = n.parts[0];
                for (k, row) in n.parts.iter().enumerate() {
                    // Only the first manifold has the probe and begins the chain.
                    let next_part = n.parts.get(k + 1).copied().unwrap_or(NONE);
                    let first = contact.clone();
                    let part =
                        Contact { is_part: true, probe: Shared::new(n.row), next_part, ..first };
                    *slots.row(*row as usize) = Some(part);
                }
            }
        });
    }

    /// Inserts the contacts at the heads of their bodies' lists. Every owner of lists walks over
    /// all contacts.
    fn link(&mut self, new: &[Newcomer], bodies: &mut Bodies, jobs: &Jobs<'_>) {
        let table = &self.rows;
        // SAFETY: each body's list has a single owner.
        let bodies = Rows::new(bodies.rows.values_mut(), unsafe { Apart::promise() });
        let owners = Owners::of(new.len(), jobs);
        for_each(jobs, owners.len(), |_, owner| {
            link(new, table, bodies, |body| owners.owns(owner, body));
        });
    }
}

fn link(
    new: &[Newcomer],
    table: &Table,
    bodies: Rows<'_, Option<Body>>,
    owns: impl Fn(u32) -> bool,
) {
    let links = Links(table);
    for (k, n) in new.iter().enumerate() {
        if let Some(soon) = new.get(k + 2 * PREFETCH) {
            prefetch_heads(bodies, soon.bodies, &owns);
        }
        if let Some(soon) = new.get(k + PREFETCH) {
            for body in soon.bodies.into_iter().filter(|body| owns(*body)) {
                let first = bodies.read(body as usize).as_ref().map_or(NONE, |b| b.ties.contacts);
                table.prefetch_line(first as usize / 2, Contact::LISTS_LINE);
            }
        }
        for (side, body) in (0..).zip(n.bodies) {
            if !owns(body) {
                continue;
            }
            let Some(body) = bodies.row(body as usize) else { continue };
            for row in n.rows() {
                let me = row * 2 + side;
                let next = core::mem::replace(&mut body.ties.contacts, me);
                if let Some(link) = links.at(me) {
                    link.next.set(next);
                }
                if let Some(link) = links.at(next) {
                    link.previous.set(me);
                }
            }
        }
    }
}

fn number(place: usize) -> u32 {
    u32::try_from(place).expect("fewer than 2^31 contacts")
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use crate::base::threads::team::Team;
    use crate::geometry::mesh::Mesh;
    use crate::geometry::shape::Shape;
    use crate::state::def::{BodyDef, ShapeDef};
    use crate::state::tables::Tables;
    use crate::world::World;

    /// A grid of triangles with sleeping balls on it. An equal number of balls falls down at once
    /// between and above them.
    fn shower(workers: usize) -> World {
        let mut world = World::default().with_executor(Arc::new(Team::with_threads(workers)));
        let vertices = (0..441_u16).map(|i| [f32::from(i % 21), 0.0, f32::from(i / 21)].into());
        let at = (0..20).flat_map(|j| (0..20).map(move |i| 21 * j + i));
        let triangles = at.flat_map(|k| [[k, k + 21, k + 1], [k + 1, k + 21, k + 22]]);
        let mesh = Mesh::new(vertices.collect(), triangles.collect()).unwrap();
        let ground = ShapeDef::new(Shape::Mesh(Arc::new(mesh)));
        world.add_body(BodyDef::fixed().with_shape(ground)).unwrap();
        for i in 0..800_u16 {
            let [x, z] = [i % 40, i / 40].map(|k| 0.5 * f32::from(k) + 0.2);
            let ball = BodyDef::dynamic().with_shape(ShapeDef::sphere(0.2));
            let sleeper = ball.clone().with_position([x, 0.2, z]);
            world.add_body(BodyDef { asleep: true, ..sleeper }).unwrap();
            let fall = [0.0, -20.0 - f32::from(i % 7), 0.0];
            let above = ball.with_position([x + 0.25, 1.4 + 0.1 * f32::from(i % 5), z]);
            world.add_body(above.with_linear_velocity(fall)).unwrap();
        }
        world
    }

    /// The order of all tables: watches, manifolds, contact lists of bodies, and their islands.
    fn order(tables: &Tables) -> Vec<Vec<u32>> {
        let contacts = &tables.contacts;
        let (rows, free, watches, probes, awake) = contacts.parts();
        assert_eq!((watches.len(), rows), (probes, contacts.iter().count() + free.len()));
        let watched = watches[..awake].iter().map(|w| w.row());
        let parts = contacts.iter().flat_map(|(row, c)| [row, c.probe.get(), c.next_part]);
        let mut all = vec![free.to_vec(), watched.collect(), parts.collect()];
        for (_, body) in tables.bodies.rows.iter() {
            let list = contacts.of_body(body).flat_map(|(row, side)| [row, side]);
            let island = [body.sleep.island, body.sleep.next, body.ties.constraints];
            all.push(list.chain(island).chain([body.sleep.still_time.to_bits()]).collect());
        }
        all
    }

    #[test]
    fn contacts_stand_in_the_same_places_however_many_workers_see_to_them() {
        let mut worlds = [1, 2, 3, 4].map(shower);
        let (mut come, mut gone, mut before) = (0, 0, 0);
        for step in 0..60 {
            let orders = worlds.each_mut().map(|world| {
                world.step(1.0 / 60.0);
                // Restoring a snapshot checks the tables.
                #[cfg(feature = "snapshot")]
                World::restore(&world.snapshot()).unwrap();
                order(world.tables_mut())
            });
            assert!(orders.iter().all(|order| *order == orders[0]), "step {step}");
            let contacts = worlds[0].counts().contacts;
            come = come.max(contacts.saturating_sub(before));
            gone = gone.max(before.saturating_sub(contacts));
            before = contacts;
        }
        // From 64 and 128 contacts on the work is parallel.
        assert!(come > 500 && gone > 200, "{come} and {gone} contacts came and went in a step");
    }
}
