//! The stage `broadphase`: finds new pairs of shapes around every shape whose box in the tree is
//! new or changed, and makes their contacts.
//!
//! Reads: shapes, bounds, bodies. Writes: contacts (rows), bounds (move list). Runs: queries in
//! parallel over moved shapes. Contacts are made and entered in parallel too; the result is that of
//! a serial run in the order of the sorted pairs.
#![expect(unsafe_code, reason = "promises that rows are kept apart")]

use core::ops::Range;

use super::context::StepContext;
use super::reach::speculative_margin;
use crate::base::bit_set::BitSet;
use crate::base::grow::Slack;
use crate::base::math::Vec3;
use crate::base::pair_set::pair_key;
use crate::base::threads::disjoint::Apart;
use crate::base::threads::jobs::{Jobs, collect_ranges, for_items, grain};
use crate::base::threads::shared::Shared;
use crate::geometry::manifold::PairCache;
use crate::geometry::rtree::RTree;
use crate::geometry::solid::Core;
use crate::state::bodies::body::Body;
use crate::state::bodies::{Bodies, NONE};
use crate::state::bounds::Bounds;
use crate::state::colors::Place;
use crate::state::contacts::enter::Newcomer;
use crate::state::contacts::{Contact, Contacts, Point};
use crate::state::def::BodyKind;
use crate::state::joints::Joints;
use crate::state::shapes::{ShapeRow, Shapes};

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    found: Vec<Vec<u64>>,
    /// Rows that search for pairs, as a set.
    looks: BitSet,
    /// New or moved rows, for steps in which other rows search for them.
    fresh: Fresh,
    pairs: Vec<u64>,
    /// New contacts, one for each pair.
    new: Vec<Newcomer>,
    slack: Slack,
}

/// Finds the pairs and makes their contacts.
pub(crate) fn find_pairs(
    ctx: &StepContext,
    bodies: &mut Bodies,
    shapes: &Shapes,
    joints: &Joints,
    contacts: &mut Contacts,
    bounds: &mut Bounds,
    scratch: &mut Scratch,
    jobs: &Jobs<'_>,
) {
    bounds.tidy(jobs);
    let Bounds { fixed, moving, moved, placed, .. } = bounds;
    let Scratch { found, pairs, new, looks, fresh, slack } = scratch;
    // Drop rows that were removed again, and reused rows that stand for another shape.
    moved.retain(|row| {
        let is_there = moving.leaf(*row) != NONE;
        if is_there {
            looks.insert(*row);
        }
        is_there
    });
    placed.retain(|row| fixed.leaf(*row) != NONE);
    // A world's ground may be a million new boxes at once, with few moving shapes. Querying around
    // all moving shapes is then less work.
    let many_placed = placed.len() > moving.len();
    fresh.clear();
    if many_placed {
        fresh.keep(moved);
        moved.clear();
        moved.extend(moving.items());
        moved.iter().for_each(|row| looks.insert(*row));
    }
    // Each row once, in tree order, so that neighbors visit the same blocks; the pairs are sorted
    // again, so the order has no effect. The tree lists its items in that order: filtering them is
    // less work than sorting many rows.
    if 8 * moved.len() > moving.len() {
        moved.clear();
        moved.extend(moving.items().filter(|row| looks.contains(*row)));
    } else {
        moved.sort_unstable_by_key(|row| (moving.leaf(*row), *row));
        moved.dedup();
    }
    let finder = Finder { ctx, bodies, shapes, joints, contacts, looks };
    // Pairs of two static shapes exist only if a sensor detects static shapes.
    let sees_fixed = shapes.see_statics > 0;
    let few_placed = if many_placed && !sees_fixed { &[] } else { placed.as_slice() };
    let around_placed: &[&RTree] = match (many_placed, sees_fixed) {
        (true, _) => &[fixed],
        (false, true) => &[moving, fixed],
        (false, false) => &[moving],
    };
    // If most rows search, the tree is queried against itself, eight boxes at a time and each pair
    // once.
    let blocks = if 2 * moved.len() > moving.len() { moving.blocks() } else { 0 };
    let trees: &[&RTree] = if blocks > 0 { &[fixed] } else { &[moving, fixed] };
    let asking = moved.len() + few_placed.len();
    // A block is much more work than a query of the static tree, so each block is combined with
    // some queries.
    let n = if blocks > 0 { blocks } else { asking };
    collect_ranges(jobs, n, grain(jobs, n, 32), found, |range, out| {
        let mut queue = Queue::default();
        for i in share(&range, n, asking) {
            if let Some(soon) = moved.get(i + PREFETCH) {
                shapes.rows.prefetch(*soon, 1);
            }
            if let Some(row) = moved.get(i) {
                finder.find(*row, trees, &mut queue, out);
            } else {
                finder.find(few_placed[i - moved.len()], around_placed, &mut queue, out);
            }
        }
        if blocks > 0 {
            range.for_each(|i| moving.pairs_of(i, |a, b| finder.meet(a, b, &mut queue, out)));
        }
        queue.pairs.iter().for_each(|pair| finder.list(*pair, out));
    });
    pairs.clear();
    pairs.extend(found.iter().flatten());
    if let Some(enough) = slack.look(pairs.len()) {
        pairs.shrink_to(enough);
        new.shrink_to(enough);
        found.iter_mut().for_each(|list| list.shrink_to(enough));
    }
    pairs.sort_unstable();
    pairs.dedup();
    let is_fresh = |row: u32| if many_placed { fresh.contains(row) } else { looks.contains(row) };
    create_all(pairs, new, is_fresh, bodies, shapes, contacts, jobs);
    looks.remove_all(moved);
    moved.clear();
    placed.clear();
}

/// A set of rows with a list for clearing it.
#[derive(Clone, Debug, Default)]
struct Fresh {
    set: BitSet,
    rows: Vec<u32>,
}

impl Fresh {
    fn keep(&mut self, rows: &[u32]) {
        self.rows.extend_from_slice(rows);
        rows.iter().for_each(|row| self.set.insert(*row));
    }

    fn contains(&self, row: u32) -> bool {
        self.set.contains(row)
    }

    fn clear(&mut self) {
        self.set.remove_all(&self.rows);
        self.rows.clear();
    }
}

/// The part of `all` items that belongs to a range of `n`.
fn share(range: &Range<usize>, n: usize, all: usize) -> Range<usize> {
    // The products do not fit where addresses have 32 bits.
    #[expect(clippy::cast_possible_truncation, reason = "at most `all`")]
    let part = |i: usize| (i as u64 * all as u64 / n as u64) as usize;
    part(range.start)..part(range.end)
}

/// Ring buffer that delays the lookup of overlapping pairs. The set of known pairs is accessed at
/// random, so each pair's entry is prefetched while it waits.
#[derive(Default)]
struct Queue {
    /// Pairs in the ring; an empty entry is a row with itself.
    pairs: [(u32, u32); Self::LEN],
    /// Index of the oldest entry.
    next: usize,
}

impl Queue {
    const LEN: usize = 16;

    /// Adds a pair; returns the oldest.
    fn turn(&mut self, pair: (u32, u32)) -> (u32, u32) {
        let oldest = core::mem::replace(&mut self.pairs[self.next], pair);
        self.next = (self.next + 1) % Self::LEN;
        oldest
    }
}

/// Inputs of the search for pairs.
struct Finder<'a> {
    ctx: &'a StepContext,
    bodies: &'a Bodies,
    shapes: &'a Shapes,
    joints: &'a Joints,
    contacts: &'a Contacts,
    looks: &'a BitSet,
}

impl Finder<'_> {
    /// Lists the new pairs of a shape.
    fn find(&self, row: u32, trees: &[&RTree], queue: &mut Queue, out: &mut Vec<u64>) {
        let shape = self.shapes.at(row);
        for tree in trees {
            tree.query(&shape.fat, |other| {
                // If both rows search, one of them lists the pair.
                let twice = other <= row && (other == row || self.looks.contains(other));
                if !twice {
                    self.add((row, other), queue, out);
                }
                true
            });
        }
    }

    /// Lists a pair of the moving tree if either row searches for pairs.
    fn meet(&self, a: u32, b: u32, queue: &mut Queue, out: &mut Vec<u64>) {
        if self.looks.contains(a) || self.looks.contains(b) {
            self.add((a, b), queue, out);
        }
    }

    /// Queues an overlapping pair, and checks the pair that leaves the queue.
    #[inline]
    fn add(&self, pair: (u32, u32), queue: &mut Queue, out: &mut Vec<u64>) {
        self.contacts.prefetch_pair(pair);
        self.list(queue.turn(pair), out);
    }

    /// Lists an overlapping pair if it is new and may meet.
    fn list(&self, (a, b): (u32, u32), out: &mut Vec<u64>) {
        // Most pairs are in the set already, which needs no access to the shapes.
        if a == b || self.contacts.has_pair(a, b) {
            return;
        }
        let [first, second] = [a, b].map(|row| self.shapes.at(row));
        if first.body != second.body
            && !self.pass(first, second)
            && may_meet(self.bodies, self.joints, first, second)
        {
            out.push(pair_key(a, b));
        }
    }

    /// True for a pair with a flying body, which will be queried again in the next step, if the
    /// bodies are farther apart than this step's speculative distance.
    fn pass(&self, a: &ShapeRow, b: &ShapeRow) -> bool {
        let bounces = a.material.restitution.max(b.material.restitution) > 0.0;
        let (a, b) = (self.bodies.at(a.body), self.bodies.at(b.body));
        let again = |body: &Body| body.flies && body.active();
        if !(again(a) || again(b)) || !a.is_dynamic() || !b.is_dynamic() {
            return false;
        }
        let maximum = a.extent + b.extent + speculative_margin(self.ctx, a, b, bounces);
        // The factor covers rounding, and the remainder by which a shape may exceed its extent.
        (b.center - a.center).length() > 1.001 * maximum
    }
}

/// True if two shapes with overlapping boxes become a contact.
pub(crate) fn may_meet(bodies: &Bodies, joints: &Joints, a: &ShapeRow, b: &ShapeRow) -> bool {
    // Two meshes, or a mesh and a half-space, never meet.
    if a.body == b.body
        || (rank(a) < 2 && rank(b) < 2)
        || !a.filter.collides_with(b.filter)
        || !(a.enabled && b.enabled)
    {
        return false;
    }
    let (body_a, body_b) = (bodies.at(a.body), bodies.at(b.body));
    if a.sensor || b.sensor {
        let fixed = body_a.kind == BodyKind::Static && body_b.kind == BodyKind::Static;
        return a.sees(b, fixed) || b.sees(a, fixed);
    }
    if !body_a.is_dynamic() && !body_b.is_dynamic() {
        return false;
    }
    if bodies.are_strangers(a.body, b.body) {
        return false;
    }
    // A joint is in the lists of both its bodies; search the shorter one.
    let swap = body_b.ties.joints.len() < body_a.ties.joints.len();
    let (body, other) = if swap { (body_b, a.body) } else { (body_a, b.body) };
    !body.ties.joints.iter().any(|row| {
        let joint = joints.at(*row);
        !joint.collide_connected && (joint.body_a == other || joint.body_b == other)
    })
}

/// Prefetch distance, in shapes.
const PREFETCH: usize = 8;

/// Makes the contacts of the new pairs.
fn create_all(
    pairs: &[u64],
    new: &mut Vec<Newcomer>,
    is_fresh: impl Fn(u32) -> bool + Sync,
    bodies: &mut Bodies,
    shapes: &Shapes,
    contacts: &mut Contacts,
    jobs: &Jobs<'_>,
) {
    contacts.take_rows(pairs.len(), new);
    // SAFETY: each new contact has a row of its own.
    let slots = contacts.slots_mut(unsafe { Apart::promise() });
    for_items(jobs, new, grain(jobs, pairs.len(), 64), |first, new| {
        for (key, n) in pairs[first..].iter().zip(new) {
            #[expect(clippy::cast_possible_truncation, reason = "the halves of a pair key")]
            let contact = contact_of((key >> 32) as u32, *key as u32, shapes);
            n.bodies = [contact.body_a, contact.body_b];
            n.asked = is_asked(bodies, &contact, &is_fresh);
            n.awake = n.asked || n.bodies.iter().any(|body| bodies.at(*body).active());
            n.has_parts = shapes.at(contact.shape_a).is_mesh();
            *slots.row(n.row as usize) = Some(contact);
        }
    });
    contacts.enter(pairs, new, bodies, jobs);
    contacts.asked.extend(new.iter().filter(|n| n.asked).map(|n| n.row));
}

/// True for a new contact between inactive bodies that needs a test all the same: a sensor detects
/// sleeping bodies, and placing a static shape in a sleeping body wakes it. A body that was added
/// asleep stays asleep.
fn is_asked(bodies: &Bodies, c: &Contact, is_fresh: impl Fn(u32) -> bool) -> bool {
    let (a, b) = (bodies.at(c.body_a), bodies.at(c.body_b));
    if a.active() || b.active() {
        return false;
    }
    let was_added = |body: &Body, shape: u32| body.sleep.still_time <= 0.0 && is_fresh(shape);
    let is_met = |body: &Body, shape: u32, other: &Body| {
        body.is_dynamic() && !other.is_dynamic() && !was_added(body, shape)
    };
    c.sensor || is_met(a, c.shape_a, b) || is_met(b, c.shape_b, a)
}

/// Rank of a shape in a pair. Meshes and half-spaces come first, since their manifolds are computed
/// from that side.
pub(crate) const fn rank(shape: &ShapeRow) -> u8 {
    match shape.solid.core {
        Core::Mesh(_) => 0,
        Core::HalfSpace { .. } => 1,
        _ => 2,
    }
}

fn contact_of(a: u32, b: u32, shapes: &Shapes) -> Contact {
    let swap = rank(shapes.at(b)) < rank(shapes.at(a));
    let (a, b) = if swap { (b, a) } else { (a, b) };
    let (shape_a, shape_b) = (shapes.at(a), shapes.at(b));
    let surface = shapes.surface_of(a, b);
    let sensor = shape_a.sensor || shape_b.sensor;
    Contact {
        shape_a: a,
        shape_b: b,
        body_a: shape_a.body,
        body_b: shape_b.body,
        links: Default::default(),
        probe: Shared::new(NONE),
        place: Place::NOWHERE,
        next_part: NONE,
        clear: 0.0,
        is_part: false,
        sensor,
        touching: false,
        recyclable: ShapeRow::are_recyclable(shape_a, shape_b),
        friction: surface.friction,
        kinetic: surface.kinetic,
        restitution: surface.restitution,
        rolling: surface.rolling,
        spinning: surface.spinning,
        round_patch: surface.round_patch,
        traits: surface.traits,
        normal: Vec3::Y,
        count: 0,
        others: 0,
        points: [Point::default(); 4],
        tangent_impulse: Vec3::ZERO,
        twist_impulse: 0.0,
        cache: PairCache::default(),
        offset: Vec3::ZERO,
    }
}

#[cfg(test)]
mod tests {
    use super::{Scratch, find_pairs, may_meet, share};
    use crate::base::math::{Vec3, vec3};
    use crate::base::simd::wide::SimdLevel;
    use crate::base::threads::jobs::Jobs;
    use crate::state::def::config::WorldConfig;
    use crate::state::def::{BodyDef, ShapeDef};
    use crate::step::context::StepContext;
    use crate::step::reach::speculative_margin;
    use crate::world::World;

    const DT: f32 = 1.0 / 60.0;

    #[test]
    fn ranges_share_all_items_evenly_and_each_once() {
        for (n, all) in [(1_usize, 0), (7, 7), (10, 3), (3, 10), (125_000, 1_000_000)] {
            let mut end = 0;
            for start in (0..n).step_by(n.div_ceil(8)) {
                let part = share(&(start..(start + n.div_ceil(8)).min(n)), n, all);
                assert_eq!(part.start, end);
                assert!(part.len() <= (all * n.div_ceil(8)).div_ceil(n) + 1, "{n} {all} {part:?}");
                end = part.end;
            }
            assert_eq!(end, all);
        }
    }

    struct Random(u32);

    impl Random {
        fn signed(&mut self) -> f32 {
            self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (self.0 >> 8) as f32 / 8_388_608.0 - 1.0
        }

        fn direction(&mut self) -> Vec3 {
            let v = vec3(self.signed(), self.signed(), self.signed());
            v.try_normalize().unwrap_or(Vec3::X)
        }
    }

    /// A room of 6 m with bodies of all speeds, up to 250 m/s, which hit each other and the walls
    /// and slow down there.
    fn room(random: &mut Random) -> World {
        let mut world = World::default();
        for side in [Vec3::X, Vec3::Y, Vec3::Z].into_iter().flat_map(|n| [n, -n]) {
            let wall = ShapeDef::half_space(side, -3.0);
            world.add_body(BodyDef::fixed().with_shape(wall)).unwrap();
        }
        for i in 0..60_u8 {
            let place = vec3(random.signed(), random.signed(), random.signed()) * 2.5;
            let speed = [250.0, 60.0, 20.0, 1.0][usize::from(i % 4)];
            let restitution = if i % 3 == 0 { 0.9 } else { 0.0 };
            let mut def = BodyDef::dynamic()
                .with_position(place)
                .with_linear_velocity(random.direction() * speed)
                .with_angular_velocity(random.direction() * (0.2 * speed));
            def.shapes = match i % 5 {
                0 | 1 => vec![ShapeDef::sphere(0.1)],
                2 | 3 => vec![ShapeDef::box_half(vec3(0.05, 0.1, 0.2))],
                _ => vec![
                    ShapeDef::capsule(0.15, 0.05).with_position(vec3(0.0, 0.15, 0.0)),
                    ShapeDef::sphere(0.08).with_position(vec3(0.2, 0.0, 0.0)),
                ],
            };
            def.shapes = def.shapes.into_iter().map(|s| s.with_restitution(restitution)).collect();
            world.add_body(def).unwrap();
        }
        world
    }

    #[test]
    fn what_comes_into_reach_is_watched_however_fast_it_flies() {
        let mut random = Random(5);
        let mut world = room(&mut random);
        let ctx = StepContext::new(&WorldConfig::default(), DT, DT, SimdLevel::best().0);
        let (mut passed, mut watched) = (0, 0);
        for _ in 0..120 {
            let mut now = world.clone();
            let tables = now.tables_mut();
            let (bodies, shapes) = (&mut tables.bodies, &tables.shapes);
            let (contacts, bounds) = (&mut tables.contacts, &mut tables.bounds);
            let mut scratch = Scratch::default();
            find_pairs(
                &ctx,
                bodies,
                shapes,
                &tables.joints,
                contacts,
                bounds,
                &mut scratch,
                &Jobs::Inline,
            );
            let rows: Vec<u32> = (0..200).filter(|row| shapes.rows.at(*row).is_some()).collect();
            for (i, row) in rows.iter().enumerate() {
                for other in &rows[i + 1..] {
                    let (x, y) = (shapes.at(*row), shapes.at(*other));
                    if !x.fat.overlaps(&y.fat) || !may_meet(bodies, &tables.joints, x, y) {
                        continue;
                    }
                    let (a, b) = (bodies.at(x.body), bodies.at(y.body));
                    let apart = (b.center - a.center).length() - a.extent - b.extent;
                    let bounces = x.material.restitution.max(y.material.restitution) > 0.0;
                    let both = a.is_dynamic() && b.is_dynamic();
                    if tables.contacts.has_pair(*row, *other) {
                        watched += 1;
                    } else {
                        assert!(both && apart > speculative_margin(&ctx, a, b, bounces), "{apart}");
                        passed += 1;
                    }
                }
            }
            world.step(DT);
        }
        assert!(passed > 20 && watched > 1000, "{passed} {watched}");
    }
}
