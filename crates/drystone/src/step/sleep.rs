//! The stage `sleep`: puts islands to sleep whose bodies have all been still for long enough and
//! that nothing drives (docs/decisions/030-what-may-sleep.md).
//!
//! Reads: bodies (timers), shapes, contacts, joints. Writes: islands (splits), sets, events. Runs:
//! only when an awake body was still for long enough. Timers and bodies of contacts are read in
//! parallel; the rest is serial over islands and contacts. One island a step is split for sleep,
//! and also every island that was cut so often that it must have come apart.
//! Where bodies freeze individually, frozen bodies that touch awake ones are checked in every step.

pub(crate) mod freeze;
pub(crate) mod drives;

use self::drives::drives_of;
use super::context::StepContext;
use super::finalize;
use super::notes::Note;
use crate::base::sparse::Sparse;
use crate::base::threads::jobs::{Jobs, collect_ranges, grain};
use crate::state::bodies::NONE;
use crate::state::islands::Islands;
use crate::state::sets::Sets;
use crate::state::shapes::Shapes;

/// An island with at least this part of all awake bodies is split by union-find over all contacts.
/// A walk from body to body waits for memory at each of them. (For 345 boxes on a mesh among 4,400
/// the walk takes 0.6 ms.)
const LARGE: usize = 32;

/// Prefetch distance, in contacts.
const PREFETCH: usize = 16;

/// Still times of some bodies [s].
#[derive(Clone, Copy, Debug)]
struct Times {
    minimum: f32,
    maximum: f32,
}

impl Times {
    /// Value for an empty set of bodies.
    const NONE: Self = Self { minimum: f32::INFINITY, maximum: 0.0 };

    fn add(&mut self, other: Self) {
        self.minimum = self.minimum.min(other.minimum);
        self.maximum = self.maximum.max(other.maximum);
    }
}

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    rates: Rates,
    /// Islands that may sleep or be split, with the maximum still time of their bodies.
    ripe: Vec<(u32, f32)>,
    /// Kinematic bodies that do not move.
    idle: Vec<u32>,
    roots: Roots,
    freeze: freeze::Scratch,
}

/// Begins a step: sets how bodies wake in it, and by which touches.
pub(crate) fn begin_step(ctx: &StepContext, islands: &mut Islands) {
    islands.wake_alone = ctx.wakes_alone;
    islands.gentle_speed = freeze::rest_speed(ctx, ctx.sleep.speed);
    islands.length = ctx.length;
}

/// Sets non-finite bodies aside, puts still islands to sleep, and splits one island that may come
/// apart. `moved`: the findings of finalize; islands are checked only when some body was still for
/// long enough. `step`: the number of steps before this one.
pub(crate) fn rest_still_islands(
    ctx: &StepContext,
    step: u64,
    moved: &finalize::Scratch,
    shapes: &Shapes,
    sets: &mut Sets<'_>,
    scratch: &mut Scratch,
    jobs: &Jobs<'_>,
) {
    let Scratch { rates, ripe, idle, roots, freeze } = scratch;
    let (config, spacing) = (&ctx.sleep, ctx.stillness().spacing());
    let mut still = false;
    idle.clear();
    for note in moved.notes() {
        match note {
            Note::Idle(row) => idle.push(row),
            Note::Still => still = true,
            Note::Fault(row) => sets.put_aside(row),
        }
    }
    if !idle.is_empty() {
        sets.put_to_sleep(idle);
    }
    while let Some(island) = sets.islands.next_loose(sets.bodies) {
        split_island(island, step, sets);
    }
    if config.enabled && sets.islands.wake_alone {
        freeze::thaw(ctx, config, sets, freeze);
        if still {
            freeze::freeze(ctx, config, (shapes, spacing), sets, freeze);
        }
    }
    if !still || !config.enabled {
        return;
    }
    ripe.clear();
    rates.rate(sets, jobs, |island, Times { minimum, maximum }| {
        let of = &sets.islands.rows[island as usize];
        let is_still = maximum >= config.time && (minimum >= config.time || of.cut);
        if is_still && of.wait_until <= step {
            ripe.push((island, maximum));
        }
    });
    ripe.sort_unstable_by_key(|(island, _)| *island);
    // The island to split was cut, and some body of it could sleep if it were alone. Among those,
    // the one with the longest wait, then the lowest number.
    let mut split = None;
    for &(island, waited) in ripe.iter() {
        if sets.islands.rows[island as usize].cut {
            if split.is_none_or(|(_, best)| waited > best) {
                split = Some((island, waited));
            }
        } else {
            let members = sets.islands.members(island, sets.bodies);
            let drives = drives_of(sets, shapes, (spacing, ctx.length));
            let driven = members.iter().copied().find(|row| drives.driver(*row).is_some());
            if let Some(row) = driven {
                // The island is checked again only when the drive can have stopped.
                sets.bodies.at_mut(row).sleep.still_time = 0.0;
            } else {
                if sets.islands.wake_alone {
                    freeze::note_loads(ctx, &members, sets);
                }
                sets.put_to_sleep(&members);
            }
            sets.islands.give_back(members);
        }
    }
    if let Some((island, _)) = split {
        let len = sets.islands.rows[island as usize].len as usize;
        let known = LARGE * len >= sets.bodies.awake.len() && roots.split(island, step, sets, jobs);
        if !known {
            split_island(island, step, sets);
        }
    }
}

/// Still times of the bodies of islands.
#[derive(Clone, Debug, Default)]
struct Rates {
    /// Still times for runs of consecutive awake bodies of the same island.
    runs: Vec<Vec<(u32, Times)>>,
    /// Still times of each island, while islands are rated; [`Times::NONE`] for others.
    of: Vec<Times>,
}

impl Rates {
    /// Calls `visit` with each island that has an awake body.
    fn rate(&mut self, sets: &Sets<'_>, jobs: &Jobs<'_>, mut visit: impl FnMut(u32, Times)) {
        let (runs, awake) = (&mut self.runs, &sets.bodies.awake);
        collect_ranges(jobs, awake.len(), grain(jobs, awake.len(), 512), runs, |range, out| {
            for row in &awake[range] {
                let body = sets.bodies.at(*row);
                let still = if body.can_sleep { body.sleep.still_time } else { 0.0 };
                let times = Times { minimum: still, maximum: still };
                match out.last_mut() {
                    Some((island, of)) if *island == body.sleep.island => of.add(times),
                    _ => out.push((body.sleep.island, times)),
                }
            }
        });
        if self.of.len() < sets.islands.rows.len() {
            self.of.resize(sets.islands.rows.len(), Times::NONE);
        }
        let in_islands = || runs.iter().flatten().filter(|(island, _)| *island != NONE);
        for (island, times) in in_islands() {
            self.of[*island as usize].add(*times);
        }
        for (island, _) in in_islands() {
            let times = core::mem::replace(&mut self.of[*island as usize], Times::NONE);
            // Each island once.
            if times.minimum < f32::INFINITY {
                visit(*island, times);
            }
        }
    }
}

/// Replaces an island by its connected components.
pub(crate) fn split_island(island: u32, step: u64, sets: &mut Sets<'_>) {
    let members = sets.islands.members(island, sets.bodies);
    sets.islands.dissolve(island);
    for m in &members {
        sets.bodies.at_mut(*m).sleep.island = NONE;
    }
    for start in &members {
        if sets.bodies.at(*start).sleep.island != NONE {
            continue;
        }
        let component = sets.islands.create(*start, sets.bodies);
        let mut body = *start;
        while body != NONE {
            let row = sets.bodies.at(body);
            // An awake body without acting constraints need not read its contacts.
            let alone = row.active() && row.ties.constraints == 0;
            let mut at = if alone { NONE } else { row.ties.contacts };
            while at != NONE {
                let c = sets.contacts.at(at / 2);
                let other = if at & 1 == 0 { c.body_b } else { c.body_a };
                at = c.links[(at & 1) as usize].next.get();
                if c.count > 0 && !c.sensor {
                    join(component, other, sets);
                }
            }
            for i in 0..sets.bodies.at(body).ties.joints.len() {
                let joint = sets.joints.at(sets.bodies.at(body).ties.joints[i]);
                let other = if joint.body_a == body { joint.body_b } else { joint.body_a };
                if joint.is_on() {
                    join(component, other, sets);
                }
            }
            body = sets.bodies.at(body).sleep.next;
        }
        sets.islands.split_again(component, step);
    }
    sets.islands.give_back(members);
}

/// Adds a body without an island.
fn join(component: u32, body: u32, sets: &mut Sets<'_>) {
    let row = sets.bodies.at(body);
    if row.is_dynamic() && row.sleep.island == NONE {
        sets.islands.push(component, body, sets.bodies);
    }
}

/// Union-find over bodies: each refers to another body of its component, up to the root.
#[derive(Clone, Debug, Default)]
struct Roots {
    of: Sparse,
    /// Pairs of bodies that contacts connect.
    ends: Vec<Vec<[u32; 2]>>,
}

impl Roots {
    /// Replaces an island by its components under contacts with points and joints, if there are
    /// several. False if the components are unknown, since some of its bodies may have frozen.
    fn split(&mut self, island: u32, step: u64, sets: &mut Sets<'_>, jobs: &Jobs<'_>) -> bool {
        let members = sets.islands.members(island, sets.bodies);
        let is_one = self.unite_all(&members, sets, jobs) == 1;
        if is_one {
            sets.islands.rows[island as usize].cut = false;
            sets.islands.split_again(island, step);
        } else if !sets.islands.wake_alone {
            sets.islands.dissolve(island);
            members.iter().for_each(|row| sets.bodies.at_mut(*row).sleep.island = NONE);
            for &row in &members {
                // The root is the first body of its component.
                let root = self.root(row);
                if sets.bodies.at(root).sleep.island == NONE {
                    sets.islands.create(root, sets.bodies);
                }
                if row != root {
                    let component = sets.bodies.at(root).sleep.island;
                    sets.islands.push(component, row, sets.bodies);
                }
            }
            for &row in members.iter().filter(|row| self.of.get(**row) == **row) {
                let component = sets.bodies.at(row).sleep.island;
                sets.islands.split_again(component, step);
            }
        }
        for row in &members {
            self.of.set(*row, NONE);
        }
        sets.islands.give_back(members);
        is_one || !sets.islands.wake_alone
    }

    /// Unites these awake bodies by contacts with points and by joints; returns the number of
    /// components.
    fn unite_all(&mut self, members: &[u32], sets: &Sets<'_>, jobs: &Jobs<'_>) -> usize {
        self.of.cover(sets.bodies.rows.slot_count());
        for row in members {
            self.of.set(*row, *row);
        }
        // Constraints without a color have no awake body.
        let mut parts = members.len();
        for row in sets.colors.joints.colors.iter().flat_map(|color| &color.members) {
            let joint = sets.joints.at(*row);
            parts -= usize::from(self.unite(joint.body_a, joint.body_b));
        }
        let mut ends = core::mem::take(&mut self.ends);
        for color in &sets.colors.contacts.colors {
            let rows = &color.members;
            collect_ranges(
                jobs,
                rows.len(),
                grain(jobs, rows.len(), 512),
                &mut ends,
                |range, out| {
                    for i in range {
                        if let Some(next) = rows.get(i + PREFETCH) {
                            sets.contacts.prefetch(*next, 1);
                        }
                        let c = sets.contacts.at(rows[i]);
                        out.push([c.body_a, c.body_b]);
                    }
                },
            );
            for [a, b] in ends.iter().flatten() {
                parts -= usize::from(self.unite(*a, *b));
            }
        }
        self.ends = ends;
        parts
    }

    /// Unites the components of two bodies; true if they were different.
    fn unite(&mut self, a: u32, b: u32) -> bool {
        let (a, b) = (self.root(a), self.root(b));
        if a == b || a == NONE || b == NONE {
            return false;
        }
        // The lower root remains, so the order of the list has no effect.
        self.of.set(a.max(b), a.min(b));
        true
    }

    /// The root of a body's component; [`NONE`] if the body is not a member.
    fn root(&mut self, body: u32) -> u32 {
        let mut at = body;
        while self.of.get(at) != NONE {
            let above = self.of.get(at);
            if above == at {
                return at;
            }
            // Path halving shortens later searches.
            self.of.set(at, self.of.get(above));
            at = above;
        }
        NONE
    }
}

#[cfg(test)]
mod tests {
    use super::{Roots, split_island};
    use crate::base::math::{Vec3, vec3};
    use crate::base::random::Random;
    use crate::base::threads::jobs::Jobs;
    use crate::base::trig::sin_cos;
    use crate::state::bodies::NONE;
    use crate::state::def::joint_def::JointDef;
    use crate::state::def::named::Ball;
    use crate::state::def::{BodyDef, ShapeDef};
    use crate::state::sets::Sets;
    use crate::state::tables::Tables;
    use crate::world::World;

    /// Balls that bounce without loss in a room without gravity. They are so sparse that most touch
    /// no other: of 216 in 512 m³, one on a path of 0.1 m in a step meets another in a hundredth of
    /// the steps.
    fn gas() -> World {
        let mut world = World::default();
        world.set_gravity(Vec3::ZERO);
        for side in [Vec3::X, Vec3::Y, Vec3::Z].into_iter().flat_map(|n| [n, -n]) {
            let wall = ShapeDef::half_space(side, -4.0).with_restitution(1.0);
            world.add_body(BodyDef::fixed().with_shape(wall)).unwrap();
        }
        for i in 0..216_u8 {
            let [x, y, z] = [i % 6, i / 6 % 6, i / 36].map(|k| 1.2 * f32::from(k) - 3.0);
            let (sin, cos) = sin_cos(f32::from(i) * 2.4);
            let ball = ShapeDef::sphere(0.15).with_restitution(1.0).with_friction(0.0);
            let body = BodyDef::dynamic()
                .with_position(vec3(x, y, z))
                .with_linear_velocity(vec3(cos, sin, sin * cos) * 5.0)
                .with_shape(ball);
            world.add_body(body).unwrap();
        }
        world
    }

    #[test]
    fn islands_come_apart_while_all_their_bodies_move() {
        let (mut world, mut met, mut largest) = (gas(), 0, 0);
        for _ in 0..600 {
            world.step(1.0 / 60.0);
            met += world.events().contact_begin.len();
            let tables = world.tables_mut();
            for island in tables.islands.rows.iter().filter(|island| island.len > 1) {
                largest = largest.max(island.len);
                let constraints: u32 =
                    island.bodies(&tables.bodies).map(|body| body.ties.constraints).sum();
                let holds = constraints >= 2 * (island.len - 1);
                assert!(holds || !island.was_cut_often(), "{island:?} has {constraints} ends");
            }
        }
        // Without splits all would end in one island: most touches are with walls, a fifth with
        // others.
        assert!(met > 1000 && largest < 20, "{met} touches, {largest} bodies");
    }

    /// Balls in clumps that touch, and some that fly.
    fn clumps(random: &mut Random) -> World {
        let mut world = World::default();
        world.set_gravity(Vec3::ZERO);
        #[expect(clippy::cast_possible_truncation, reason = "any number will do")]
        let mut side = || (random.unit() as f32 - 0.5) * 8.0;
        for i in 0..160_u8 {
            let at = vec3(side(), side(), side());
            let at = if i % 4 == 0 { at + Vec3::X * 40.0 } else { at };
            let ball = ShapeDef::sphere(0.5);
            let mut body = BodyDef::dynamic().with_position(at).with_shape(ball);
            if i % 5 == 0 {
                // Two bodies connected by a joint only.
                body = body.with_linear_velocity(Vec3::Y * 0.1);
            }
            let body = world.add_body(body).unwrap();
            if i % 5 == 0 {
                let far = BodyDef::dynamic().with_position(at + Vec3::Z * 30.0);
                let far = world.add_body(far.with_shape(ShapeDef::sphere(0.5))).unwrap();
                world
                    .add_joint(
                        JointDef::new(body, far, Ball::new())
                            .with_anchors(Vec3::ZERO, Vec3::Z * -30.0),
                    )
                    .unwrap();
            }
        }
        world
    }

    /// Lowest row in the island of each dynamic body.
    fn parts(tables: &Tables) -> Vec<(u32, u32)> {
        let mut parts = Vec::new();
        for (id, body) in tables.bodies.rows.iter().filter(|(_, body)| body.is_dynamic()) {
            let island = &tables.islands.rows[body.sleep.island as usize];
            let mut rows = Vec::new();
            let mut at = island.first;
            while at != NONE {
                rows.push(at);
                at = tables.bodies.at(at).sleep.next;
            }
            assert_eq!(rows.len(), island.len as usize);
            parts.push((id.index(), rows.into_iter().min().unwrap()));
        }
        parts
    }

    #[test]
    fn a_large_island_comes_apart_as_a_walk_finds_it_connected() {
        let mut random = Random::new(5);
        for _ in 0..10 {
            let mut world = clumps(&mut random);
            world.step(1.0 / 60.0);
            // All in one island, as if the connections had been cut since.
            let tables = world.tables_mut();
            let rows: Vec<u32> = tables.bodies.rows.iter().map(|(id, _)| id.index()).collect();
            for pair in rows.windows(2) {
                tables.islands.link(pair[0], pair[1], &mut tables.bodies);
            }
            let island = tables.bodies.at(rows[0]).sleep.island;
            let split = |roots: Option<&mut Roots>| {
                let mut world = world.clone();
                let tables = world.tables_mut();
                let Tables { bodies, joints, contacts, islands, colors, events, .. } = tables;
                let mut sets = Sets { bodies, joints, contacts, islands, colors, events };
                match roots {
                    Some(roots) => assert!(roots.split(island, 7, &mut sets, &Jobs::Inline)),
                    None => split_island(island, 7, &mut sets),
                }
                parts(tables)
            };
            let mut roots = Roots::default();
            let (walked, known) = (split(None), split(Some(&mut roots)));
            assert_eq!(walked, known);
            // Nothing remains in the table for the next island.
            assert!(rows.iter().all(|row| roots.of.get(*row) == NONE));
            let mut firsts: Vec<u32> = known.iter().map(|(_, first)| *first).collect();
            firsts.sort_unstable();
            firsts.dedup();
            assert!(firsts.len() > 20 && firsts.len() < rows.len() - 40, "{}", firsts.len());
        }
    }
}
