//! Whether tables that come from outside hold together: every row that is named lives, every list says the same as
//! the rows it is a list of, constraints of one color share no body. Stages trust all this without a look.

use core::num::NonZeroU32;

use super::bodies::{Bodies, NONE};
use super::breakage::Breakage;
use super::chains::ChainBlock;
use super::colors::{Coloring, Place};
use super::contacts::{Contact, Contacts};
use super::coupling::check_axis;
use super::def::{BodyKind, shape_suits};
use super::islands::Islands;
use super::joints::{Joints, Link};
use super::particle_def::{check_length, check_mass};
use super::particles::{CROWD, LaneKind, LinkColor, Particles};
use super::shapes::Shapes;
use super::tables::Tables;
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::base::quat::Quat;
use crate::base::slot_map::SlotMap;
use crate::base::wide::LANES;

/// What does not hold together, in words.
pub(crate) type Unsound = &'static str;

type Check = Result<(), Unsound>;

fn holds(sound: bool, what: Unsound) -> Check {
    if sound { Ok(()) } else { Err(what) }
}

fn at_least_zero(numbers: &[f32]) -> bool {
    numbers.iter().all(|x| *x >= 0.0 && x.is_finite())
}

/// Lies where a world reaches.
fn is_near(v: Vec3) -> bool {
    v.abs().max_element() <= 1.0e12
}

fn is_unit(q: Quat) -> bool {
    (0.9..1.1).contains(&(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w))
}

fn is_pose(pose: &Pose) -> bool {
    is_near(pose.position) && is_unit(pose.rotation)
}

/// Which rows were seen.
struct Seen(Vec<bool>);

impl Seen {
    fn none_of(count: usize) -> Self {
        Self(vec![false; count])
    }

    /// Takes down a row; false if there is no such row, or it was seen before.
    fn is_new(&mut self, row: u32) -> bool {
        let place = self.0.get_mut(row as usize);
        place.is_some_and(|seen| !core::mem::replace(seen, true))
    }
}

impl<Id, T> SlotMap<Id, T> {
    fn check(&self) -> Check {
        let (values, generations, free, len) = self.parts();
        holds(values.len() == generations.len(), "rows have not one generation each")?;
        holds(values.iter().flatten().count() == len, "a count of rows is wrong")?;
        let mut seen = Seen::none_of(values.len());
        for row in free {
            let is_free = seen.is_new(*row) && values[*row as usize].is_none();
            holds(is_free, "a free row is not free")?;
        }
        let used_up = values.len() - len - free.len();
        let last = generations.iter().filter(|g| **g == NonZeroU32::MAX).count();
        holds(used_up <= last, "a row is neither free nor in use")
    }
}

impl Tables {
    /// # Errors
    /// The first thing that does not hold together.
    pub(crate) fn check(&self) -> Check {
        self.config.validate().map_err(|_| "the configuration is out of range")?;
        // They count on.
        let far = self.steps.max(self.bounds.fixed_changes).max(u64::from(self.particles.threads) << 32);
        holds(far < 1 << 62, "a count is at its end")?;
        self.bodies.rows.check()?;
        self.shapes.rows.check()?;
        self.joints.rows.check()?;
        check_bodies(&self.bodies)?;
        check_shapes(&self.shapes, &self.bodies)?;
        check_joints(&self.joints, &self.bodies)?;
        check_contacts(&self.contacts, &self.bodies, &self.shapes)?;
        check_islands(&self.islands, &self.bodies)?;
        self.check_colors()?;
        self.check_bounds()?;
        check_particles(&self.particles, &self.bodies, &self.shapes)?;
        check_breakage(&self.breakage, &self.bodies, &self.shapes)
    }

    /// The color of each constraint is of its kind, holds it where it says, and holds its dynamic bodies once.
    fn check_colors(&self) -> Check {
        let Self { bodies, joints, contacts, colors, .. } = self;
        let mut constraints = vec![0_u32; bodies.rows.slot_count()];
        let joint = |row| joints.rows.at(row).map(|j| ([j.body_a, j.body_b], j.place));
        let contact = |row| {
            let c = contacts.get(row).filter(|c| c.count > 0 && !c.sensor)?;
            Some(([c.body_a, c.body_b], c.place))
        };
        let mut check = |coloring: &Coloring, of: &dyn Fn(u32) -> Option<([u32; 2], Place)>, n| {
            check_coloring(coloring, bodies, n, of, &mut constraints)
        };
        check(&colors.joints, &joint, 2)?;
        check(&colors.joints_fixed, &joint, 1)?;
        check(&colors.contacts, &contact, 2)?;
        check(&colors.contacts_fixed, &contact, 1)?;
        let in_colors = colors.joints.len() + colors.joints_fixed.len();
        let placed = joints.rows.iter().filter(|(_, j)| j.place.is_somewhere()).count();
        holds(in_colors == placed, "a joint has a color that does not hold it")?;
        let in_colors = colors.contacts.len() + colors.contacts_fixed.len();
        let placed = || contacts.iter().filter(|(_, c)| c.place.is_somewhere());
        holds(in_colors == placed().count(), "a contact has a color that does not hold it")?;
        let special = placed().filter(|(_, c)| c.is_special(bodies)).count();
        holds(special == colors.special, "a count of contacts is wrong")?;
        let all = bodies.rows.iter().all(|(id, b)| constraints[id.index() as usize] == b.constraints);
        holds(all, "a body does not know what acts on it")
    }

    /// The trees hold every shape where it says, and nothing else.
    fn check_bounds(&self) -> Check {
        let Self { shapes, bounds, .. } = self;
        for (tree, fixed) in [(&bounds.fixed, true), (&bounds.moving, false)] {
            holds(tree.is_sound(), "a tree of boxes is broken")?;
            let is_right = |row: u32| shapes.rows.at(row).is_some_and(|s| s.fixed == fixed);
            holds(tree.items().all(is_right), "a tree has a box of no shape")?;
            let count = shapes.rows.iter().filter(|(_, s)| s.fixed == fixed).count();
            holds(tree.len() == count, "a shape is in no tree")?;
        }
        Ok(())
    }
}

fn check_bodies(bodies: &Bodies) -> Check {
    let slots = bodies.rows.slot_count();
    holds(bodies.tracks.len() == slots, "bodies have not one track each")?;
    let mut seen = Seen::none_of(slots);
    for (place, row) in (0..).zip(&bodies.awake) {
        let body = bodies.rows.at(*row);
        let is_right = body.is_some_and(|b| b.awake_row == place && b.kind != BodyKind::Static && !b.faulted);
        holds(seen.is_new(*row) && is_right, "a body that is awake is not")?;
    }
    let active = bodies.rows.iter().filter(|(_, b)| b.active()).count();
    holds(active == bodies.awake.len(), "a body that is awake is not listed")?;
    for (_, b) in bodies.rows.iter() {
        let placed = is_near(b.center) && is_unit(b.rotation) && is_near(b.local_center);
        holds(placed, "a body is nowhere")?;
        holds(is_near(b.v) && is_near(b.w), "a body is too fast")?;
        let moments = [b.moments.x, b.moments.y, b.moments.z];
        let has_mass = at_least_zero(&[b.mass]) && at_least_zero(&moments) && is_unit(b.principal);
        holds(has_mass && (b.mass > 0.0) == b.is_dynamic(), "a body has no mass that can be")?;
        let numbers = [b.extent, b.still_time, b.linear_damping, b.angular_damping, b.load];
        let sizes = at_least_zero(&numbers) && b.inner >= 0.0 && b.gravity_scale.is_finite();
        holds(sizes && b.inertia_factor.is_finite(), "a number of a body is out of range")?;
    }
    Ok(())
}

fn check_shapes(shapes: &Shapes, bodies: &Bodies) -> Check {
    let mut seen = Seen::none_of(shapes.rows.slot_count());
    for (id, body) in bodies.rows.iter() {
        for row in &body.shapes {
            let shape = shapes.rows.at(*row).filter(|s| s.body == id.index());
            let Some(shape) = shape.filter(|_| seen.is_new(*row)) else {
                return Err("a body names a shape that is not its own");
            };
            shape_suits(body.kind, &shape.shape).map_err(|_| "a body has a shape that it cannot have")?;
            let fixed = body.kind == BodyKind::Static;
            holds(shape.fixed == fixed, "a shape is in the wrong tree")?;
        }
    }
    for (id, s) in shapes.rows.iter() {
        holds(seen.0[id.index() as usize], "a shape is of no body")?;
        s.shape.validate().map_err(|_| "a shape is out of range")?;
        s.material.validate().map_err(|_| "a material is out of range")?;
        holds(is_pose(&s.centered) && is_pose(&s.local), "a shape is nowhere")?;
        let runs = is_near(s.surface_velocity) && is_near(s.surface_spin);
        holds(runs && at_least_zero(&[s.density, s.rolling_radius]), "a number of a shape is out of range")?;
        holds(!s.flat || s.shape.is_flat(), "a shape is not as flat as it says")?;
    }
    Ok(())
}

fn check_joints(joints: &Joints, bodies: &Bodies) -> Check {
    let mut named = vec![0_u32; joints.rows.slot_count()];
    for (id, body) in bodies.rows.iter() {
        for row in &body.joints {
            let of = |body| joints.rows.at(*row).is_some_and(|j| j.body_a == body || j.body_b == body);
            holds(of(id.index()), "a body names a joint that is not its own")?;
            named[*row as usize] += 1;
        }
    }
    for (id, joint) in joints.rows.iter() {
        let [a, b] = [joint.body_a, joint.body_b].map(|row| bodies.rows.at(row));
        let moves = a.zip(b).is_some_and(|(a, b)| a.is_dynamic() || b.is_dynamic());
        let twice = named[id.index() as usize] == 2 && joint.body_a != joint.body_b;
        holds(moves && twice, "a joint is not between two bodies")?;
        holds(is_near(joint.anchor_a) && is_near(joint.anchor_b), "a joint is nowhere")?;
        joint.link.kind().validate().map_err(|_| "a joint is out of range")?;
        if let Some(strength) = &joint.strength {
            strength.validate().map_err(|_| "the strength of a joint is out of range")?;
        }
        if let Link::Coupling(coupling) = &joint.link {
            let def = &coupling.def;
            for (id, axis) in [(def.joint_a, def.axis_a), (def.joint_b, def.axis_b)] {
                let other = joints.rows.row(id).map(|row| &joints.at(row).link);
                let Some(Link::Six(six)) = other else { return Err("a coupling is of no joint") };
                check_axis("", six, axis).map_err(|_| "a coupling is of an axis that is held")?;
            }
        }
    }
    let breakable = joints.rows.iter().filter(|(_, j)| j.strength.is_some()).count();
    holds(breakable == joints.breakable, "a count of joints is wrong")
}

fn check_contacts(contacts: &Contacts, bodies: &Bodies, shapes: &Shapes) -> Check {
    let (slots, free, watches, probes, awake) = contacts.parts();
    holds(slots <= 1 << 30 && watches.len() == probes && awake <= probes, "contacts are watched in part")?;
    let mut seen = Seen::none_of(slots);
    for row in free {
        holds(seen.is_new(*row) && contacts.get(*row).is_none(), "a free contact is not free")?;
    }
    let living = contacts.iter().count();
    holds(living + free.len() == slots, "a contact is neither free nor in use")?;
    for (place, watch) in (0..).zip(watches) {
        let c = contacts.get(watch.row()).filter(|c| !c.is_part && c.probe == place);
        let is_right = c.is_some_and(|c| {
            [c.body_a, c.body_b] == [watch.body_a, watch.body_b] && watch.bounces() == (c.restitution > 0.0)
        });
        holds(is_right, "a contact is not the one that is watched")?;
    }
    let mut parts = 0;
    for (row, c) in contacts.iter() {
        check_contact(c, bodies, shapes)?;
        if c.is_part {
            continue;
        }
        let is_watched = watches.get(c.probe as usize).is_some_and(|w| w.row() == row);
        holds(is_watched, "a contact is not watched")?;
        let moves = [c.body_a, c.body_b].iter().any(|body| bodies.at(*body).active());
        holds(moves == ((c.probe as usize) < awake), "a contact sleeps where its bodies do not")?;
        let (mut at, mut with_points) = (c.next_part, 0);
        while at != NONE {
            let part = contacts.get(at).filter(|p| p.is_part && p.probe == row);
            let Some(part) = part else { return Err("a manifold is not of its contact") };
            let same = [part.shape_a, part.shape_b] == [c.shape_a, c.shape_b];
            holds(same && part.sensor == c.sensor, "a manifold is not of its contact")?;
            (at, with_points) = (part.next_part, with_points + usize::from(part.count > 0));
            parts += 1;
            // A ring would never end.
            holds(parts <= living, "manifolds go round")?;
        }
        holds(with_points == usize::from(c.others), "a contact miscounts its manifolds")?;
    }
    holds(watches.len() + parts == living, "a manifold is of no contact")?;
    check_lists(contacts, bodies, living)
}

fn check_contact(c: &Contact, bodies: &Bodies, shapes: &Shapes) -> Check {
    let of = |shape: u32, body: u32| shapes.rows.at(shape).filter(|s| s.body == body);
    let (Some(a), Some(b)) = (of(c.shape_a, c.body_a), of(c.shape_b, c.body_b)) else {
        return Err("a contact is not of its bodies");
    };
    let moves = bodies.at(c.body_a).kind != BodyKind::Static || bodies.at(c.body_b).kind != BodyKind::Static;
    holds(c.body_a != c.body_b && moves, "a contact is not between two bodies")?;
    let meshes = usize::from(a.is_mesh()) + usize::from(b.is_mesh());
    holds(meshes == 1 || !c.is_part && c.next_part == NONE && meshes == 0, "a contact has too many manifolds")?;
    holds(c.sensor == (a.sensor || b.sensor), "a contact is not the sensor's")?;
    let surface = [c.friction, c.kinetic, c.restitution, c.rolling, c.spinning];
    holds(at_least_zero(&surface), "a surface is out of range")?;
    holds(usize::from(c.count) <= c.points.len(), "a contact has too many points")?;
    holds(!c.recyclable || a.flat && b.flat, "a contact is not as flat as it says")
}

/// Each contact is once in the list of each of its bodies.
fn check_lists(contacts: &Contacts, bodies: &Bodies, living: usize) -> Check {
    let mut listed = 0;
    for (id, body) in bodies.rows.iter() {
        let (mut at, mut previous) = (body.contacts, NONE);
        while at != NONE {
            let Some(c) = contacts.get(at / 2) else { return Err("a body names a contact that is gone") };
            let side = (at & 1) as usize;
            let own = [c.body_a, c.body_b][side] == id.index();
            holds(own && c.links[side].previous == previous, "a body names a contact that is not its own")?;
            (previous, at) = (at, c.links[side].next);
            listed += 1;
            holds(listed <= 2 * living, "a list of contacts goes round")?;
        }
    }
    holds(listed == 2 * living, "a contact is in no list")
}

fn check_islands(islands: &Islands, bodies: &Bodies) -> Check {
    let mut seen = Seen::none_of(bodies.rows.slot_count());
    let mut members = 0;
    for (number, island) in (0..).zip(&islands.rows) {
        let (mut at, mut previous, mut len) = (island.first, NONE, 0);
        while at != NONE {
            let body = bodies.rows.at(at).filter(|b| b.is_dynamic() && b.island == number);
            let Some(body) = body.filter(|b| b.island_previous == previous && seen.is_new(at)) else {
                return Err("a body is not of its island");
            };
            (previous, at, len) = (at, body.island_next, len + 1);
        }
        holds(previous == island.last() && len == island.len, "an island miscounts its bodies")?;
        members += len as usize;
    }
    let dynamic = bodies.rows.iter().filter(|(_, b)| b.is_dynamic() || b.island != NONE).count();
    holds(dynamic == members, "a body is of no island")?;
    let mut seen = Seen::none_of(islands.rows.len());
    let is_free = |row: &u32| seen.is_new(*row) && islands.rows[*row as usize].len == 0;
    holds(islands.free().iter().all(is_free), "a free island is not free")?;
    let empty = islands.rows.iter().filter(|i| i.len == 0).count();
    holds(empty == islands.free().len(), "an island is empty")
}

fn check_coloring(
    coloring: &Coloring,
    bodies: &Bodies,
    dynamic: usize,
    constraint: &dyn Fn(u32) -> Option<([u32; 2], Place)>,
    constraints: &mut [u32],
) -> Check {
    for (number, color) in (0..).zip(&coloring.colors) {
        let mut seen = Seen::none_of(bodies.rows.slot_count());
        for (row, member) in (0..).zip(&color.members) {
            let Some((ends, place)) = constraint(*member) else {
                return Err("a color has what does not act");
            };
            holds(place == Place { color: number, row }, "a color has what is elsewhere")?;
            let moving = ends.into_iter().filter(|body| bodies.at(*body).is_dynamic());
            holds(moving.clone().count() == dynamic, "a color has what is of another kind")?;
            for body in moving {
                let held = seen.is_new(body) && color.holds(body);
                holds(held, "constraints of a color share a body")?;
                constraints[body as usize] += 1;
            }
        }
        let all = seen.0.iter().filter(|seen| **seen).count();
        holds(color.count() == all, "a color has bodies of no constraint")?;
    }
    Ok(())
}

fn check_particles(particles: &Particles, bodies: &Bodies, shapes: &Shapes) -> Check {
    let Particles { rows, lines, x, links, colors, attachments, touches, .. } = particles;
    rows.check()?;
    links.check()?;
    let slots = rows.slot_count();
    let fits = lines.len() == x.len() && lines.len() == if slots == 0 { 0 } else { slots + 1 };
    holds(fits, "particles have not one line each")?;
    let lives = |line: u32| line > 0 && rows.at(line - 1).is_some();
    for (id, p) in rows.iter() {
        let line = id.index() + 1;
        let (at, [.., radius]) = (particles.position(line), x[line as usize]);
        holds(is_near(at) && (1.0e-4..=1.0e3).contains(&radius), "a particle is nowhere")?;
        check_mass(p.mass).map_err(|_| "a particle has no mass that can be")?;
        p.material.validate().map_err(|_| "a material is out of range")?;
        let own = &lines[line as usize];
        let inverse = if p.pinned { 0.0 } else { 1.0 / p.mass };
        holds(own.inverse_mass() == inverse && is_near(own.velocity()), "a particle is too fast")?;
        holds(at_least_zero(&[p.damping, p.still_time]), "a number of a particle is out of range")?;
        // Where they are found anew they all lead to the first one.
        holds(lives(p.strand) && p.strand <= line, "a particle is of no strand")?;
        let held = p.attachment == 0
            || attachments.get(p.attachment as usize - 1).is_some_and(|a| a.line == line);
        holds(held, "a particle is not held where it says")?;
    }
    for (number, a) in (1..).zip(attachments) {
        let own = lives(a.line) && particles.at(a.line).attachment == number;
        let body = bodies.rows.at(a.body).is_some() && is_near(a.anchor);
        holds(own && body, "an attachment is of nothing")?;
    }
    let touches = touches.iter().all(|t| lives(t.line) && shapes.rows.at(t.shape).is_some());
    holds(touches, "a particle touches what is gone")?;
    holds(colors.len() <= CROWD + 1, "links have too many colors")?;
    let mut ends = vec![0_u32; lines.len()];
    let mut count = 0;
    for (number, color) in colors.iter().enumerate() {
        count += check_links(color, number, particles, &mut ends)?;
    }
    holds(count == links.len(), "a link is nowhere")?;
    let mut taken: Vec<Seen> = colors.iter().map(|c| Seen::none_of(c.blocks.len() * LANES)).collect();
    for (_, link) in links.iter() {
        let lane = link.block.checked_mul(8).and_then(|n| n.checked_add(u32::from(link.lane)));
        let color = taken.get_mut(link.color as usize).zip(lane.filter(|_| link.lane < 8));
        holds(color.is_some_and(|(seen, lane)| seen.is_new(lane)), "a link is nowhere")?;
        let (block, lane) = particles.block_of(link);
        holds(block.kinds[lane] != LaneKind::Idle, "a link is nowhere")?;
    }
    for (id, p) in rows.iter() {
        holds(ends[id.index() as usize + 1] == p.links, "a particle miscounts its links")?;
    }
    check_chains(particles, &taken)
}

/// The links of a color, and how many there are.
fn check_links(
    color: &LinkColor,
    number: usize,
    particles: &Particles,
    ends: &mut [u32],
) -> Result<usize, Unsound> {
    let mut seen = Seen::none_of(particles.lines.len());
    let mut count = 0;
    for block in &color.blocks {
        for lane in 0..LANES {
            let both = [block.row_a[lane], block.row_b[lane]];
            if block.kinds[lane] == LaneKind::Idle {
                holds(both == [0, 0], "a link that is none has ends")?;
                continue;
            }
            count += 1;
            let lives = |line: u32| line > 0 && particles.rows.at(line - 1).is_some();
            holds(both.iter().all(|line| lives(*line)) && both[0] != both[1], "a link has no ends")?;
            check_length(block.length[lane]).map_err(|_| "a link has no length that can be")?;
            let spring = [block.stiffness[lane], block.damping[lane]];
            holds(at_least_zero(&spring), "a link is out of range")?;
            for line in both {
                ends[line as usize] += 1;
                let alone = number == CROWD
                    || seen.is_new(line) && particles.at(line).colors >> number & 1 == 1;
                holds(alone, "links of a color share a particle")?;
            }
        }
    }
    holds(color.is_sound(), "lanes of links are miscounted")?;
    Ok(count)
}

/// Chains that will be found anew may be of what is gone; they are dropped without a look.
fn check_chains(particles: &Particles, taken: &[Seen]) -> Check {
    if particles.chains_changed {
        return Ok(());
    }
    let chains = &particles.chains;
    holds(chains.colors.len() <= CROWD + 1, "chains have too many colors")?;
    for color in chains.colors.iter().chain([&chains.held]) {
        let mut seen = Seen::none_of(particles.lines.len());
        for block in color {
            let free = core::ptr::eq(color, &raw const chains.held);
            check_chain(block, particles, taken, (!free).then_some(&mut seen))?;
        }
    }
    Ok(())
}

fn check_chain(
    block: &ChainBlock,
    particles: &Particles,
    taken: &[Seen],
    mut seen: Option<&mut Seen>,
) -> Check {
    holds(block.rows.len() == block.spots.len() + 1, "a chain is cut")?;
    let holds_any = block.holds.iter().flatten();
    let held = holds_any.clone().all(|n| (*n as usize) < particles.attachments.len());
    holds(held, "a chain is held by nothing")?;
    for lane in 0..LANES {
        let mut last = 0;
        for (row, spots) in block.spots.iter().enumerate() {
            let (line, next) = (block.rows[row].line[lane], block.rows[row + 1].line[lane]);
            let Some(spot) = spots[lane] else {
                holds(line == last, "a chain has an end in its middle")?;
                last = 0;
                continue;
            };
            let Some(color) = taken.get(spot.color as usize) else {
                return Err("a chain is of no link");
            };
            let place = spot.block as usize * LANES + usize::from(spot.lane);
            let lives = usize::from(spot.lane) < LANES && color.0.get(place) == Some(&true);
            holds(lives, "a chain is of no link")?;
            let links = &particles.colors[spot.color as usize].blocks[spot.block as usize];
            let lane = usize::from(spot.lane);
            let (a, b) = (links.row_a[lane], links.row_b[lane]);
            let ends = if spot.turned { [b, a] } else { [a, b] };
            holds(ends == [line, next] && links.chained[lane], "a chain is not of its links")?;
            let alone = seen.as_mut().is_none_or(|seen| seen.is_new(line));
            holds(alone, "chains of a color share a particle")?;
            last = next;
        }
        let end = block.rows[block.spots.len()].line[lane];
        holds(end == last, "a chain has an end in its middle")?;
        let alone = last == 0 || seen.as_mut().is_none_or(|seen| seen.is_new(last));
        holds(alone, "chains of a color share a particle")?;
    }
    Ok(())
}

fn check_breakage(breakage: &Breakage, bodies: &Bodies, shapes: &Shapes) -> Check {
    let Breakage { glued, fractures, pieces } = breakage;
    let breaks = |row: u32| bodies.rows.at(row).is_some_and(|b| b.breaks && b.is_dynamic());
    for (row, glue) in glued {
        let own = |shape: &u32| shapes.rows.at(*shape).is_some_and(|s| s.body == *row);
        holds(breaks(*row) && glue.pieces.iter().all(own), "glue holds what is not there")?;
        let count = glue.pieces.len();
        let bond = |b: &super::breakage::GlueBond| {
            let placed = is_near(b.point) && is_near(b.normal) && at_least_zero(&[b.area]);
            b.pieces.iter().all(|p| *p < count) && placed && b.strength.validate().is_ok()
        };
        holds(glue.bonds.iter().all(bond), "a bond holds what is not there")?;
        let known = |list: &Vec<_>| list.is_empty() || list.len() == count;
        holds(known(&glue.give) && known(&glue.lack), "glue is solved in part")?;
    }
    for (row, fracture) in fractures {
        fracture.validate().map_err(|_| "a fracture is out of range")?;
        holds(breaks(*row), "a fracture is of no body")?;
    }
    let count = bodies.rows.iter().filter(|(_, b)| b.is_piece).count();
    holds(count == *pieces, "a count of pieces is wrong")
}
