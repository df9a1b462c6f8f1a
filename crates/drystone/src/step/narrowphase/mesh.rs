//! Pairs of a mesh and a convex shape: updates their several manifolds, each in a row of its own.

use super::change::Change;
use super::gate::{Admitted, Gate};
use super::keep::{keep_load, recycle};
use super::meeting::STRAIGHT;
use super::motion::Motion;
use super::rebuild::{Look, RENEWED_ROTATION, rebuild};
use super::seams;
use super::turning::{list_for_solver, turn_ahead};
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::base::threads::disjoint::Rows;
use crate::geometry::collide::{MAX_PARTS, MeshScratch, Reach, collide_mesh};
use crate::geometry::manifold::Manifold;
use crate::geometry::mesh::Mesh;
use crate::geometry::room::room_to_turn;
use crate::geometry::solid::Core;
use crate::state::bodies::NONE;
use crate::state::bodies::body::Body;
use crate::state::contacts::{Contact, ReadSlots, Slots, Softened};
use crate::state::shapes::ShapeRow;
use crate::step::context::StepContext;

/// Minimum cosine of the angle between an old manifold's normal and that of the new one that
/// continues it. Manifolds change places when another becomes the deepest, and would start without
/// their impulses.
const SAME_PART: f32 = 0.9;

/// Minimum turn in a step by which a hull rolls rather than only slides [rad].
const ROLLS: f32 = 1.0e-3;

/// Updates all manifolds of a pair whose first is `contact`.
pub(super) fn update(
    ctx: &StepContext,
    mesh: &Mesh,
    (a, shape_a): (&Body, &ShapeRow),
    (b, shape_b): (&Body, &ShapeRow),
    motion: &Motion,
    (contact, look, gate): (&mut Contact, &mut Look<'_>, Option<&Gate<'_>>),
    (slots, softened): (&Slots<'_>, &Rows<'_, Softened>),
    out: &mut Vec<Change>,
    scratch: &mut MeshScratch,
) {
    // A shape need not search beyond its own size: a fast body is stopped at the surface.
    let ahead = 1.1 * ctx.dt * motion.speed;
    let margin = if contact.sensor { 0.0 } else { ctx.margin.max(ahead.min(2.0 * motion.radius)) };
    // A contact without points gets them when it may come within half the distance at which points
    // are made, or that near in this step: most bodies that hover over a surface move along it.
    let turn = turn_ahead(ctx, (a, shape_a), (b, shape_b));
    // Rotation about the normal lowers no other corner.
    let w = b.w - a.w;
    let about = if contact.count > 0 { contact.normal.dot(w) } else { 0.0 };
    let tilt = turn.min(1.1 * ctx.dt * (w - contact.normal * about).length());
    let near = margin.min((0.5 * ctx.margin).max(ahead + ctx.fall));
    let gap = look.probe.gap;
    if contact.count == 0 && gap > near && motion.since < gap - near {
        look.open(gap - motion.since);
        return;
    }
    if !shape_a.fat.overlaps(&shape_b.fat) {
        out.push(Change::Apart(look.row));
        return;
    }
    if contact.recyclable
        && may_recycle(ctx, contact, (a, shape_b, slots), motion, [ahead, tilt])
        && recycle(ctx, contact, look.probe, (a, b), slots, look.lands)
    {
        if turn > RENEWED_ROTATION && !contact.sensor {
            out.push(Change::Turns(look.row));
        }
        keep_loads(ctx, contact, (a, b), slots);
        list_parts(ctx, (look.row, contact), [a, b], slots, out);
        return;
    }
    let pose_a = shape_a.placed(a);
    let b_in_a = pose_a.relative(&shape_b.placed(b));
    let reach = if contact.sensor {
        Reach::still(0.0).in_lengths(ctx.length)
    } else {
        let displacement =
            pose_a.local_direction(b.rotation.rotate(motion.velocity) * (1.1 * ctx.dt));
        let length = displacement.length();
        let maximum = 2.0 * motion.radius;
        Reach {
            margin,
            rest: margin.min(ctx.margin + 1.1 * ctx.dt * motion.spin),
            corners: ahead > 2.0 * ctx.margin,
            displacement: if length > maximum {
                displacement * (maximum / length)
            } else {
                displacement
            },
            is_straight: motion.spin <= STRAIGHT * motion.velocity.length(),
            // Room for some steps' displacement, if the two are apart and may skip tests.
            room: if contact.count > 0 {
                0.0
            } else {
                (4.0 * ahead + 2.0 * ctx.margin).min(maximum)
            },
            ..Reach::still(margin).in_lengths(ctx.length)
        }
    };
    let mut made = [Manifold::default(); MAX_PARTS];
    let solid = &shape_b.solid;
    let mut count = collide_mesh(ctx.level, mesh, solid, &b_in_a, &reach, scratch, &mut made);
    let mut admitted = [None; MAX_PARTS];
    if let Some(gate) = gate {
        count = retain(&mut made, &mut admitted, count, |m| gate.admit(ctx, m, &pose_a));
    }
    let last = if contact.is_renewed() { a.rotation } else { look.probe.rotation_a };
    look.restart(if count == 0 { made[0].gap } else { 0.0 }, a, b);
    contact.offset = look.probe.offset;
    contact.clear = margin.max(made[0].gap);
    // A sliding hull does not turn, and its manifold is kept.
    let comes_down = |m: &Manifold| tilt > room_to_turn(m, [&shape_a.solid, solid], &b_in_a);
    let rolls = tilt > ROLLS && made[..count].iter().any(comes_down);
    if count > 0 && (turn > RENEWED_ROTATION || rolls) && !contact.sensor {
        out.push(Change::Turns(look.row));
    }
    if count <= 1 && contact.others == 0 {
        let idle = count == 0 && contact.count == 0;
        let manifold = if count == 0 { Manifold::default() } else { made[0] };
        if let Some(admitted) = &admitted[0] {
            admitted.tell(look.row, contact, softened);
        }
        if !idle {
            rebuild(ctx, (look.row, contact), &manifold, (&pose_a, last), [a, b], out);
            keep_load(ctx, contact, a, b);
        }
        list_parts(ctx, (look.row, contact), [a, b], slots, out);
        return;
    }
    let order = continue_parts(contact, &made[..count], &pose_a, slots);
    contact.others = order[1..].iter().fold(0, |n, k| n + u8::from(k.is_some()));
    let mut part = Some((look.row, contact));
    let mut slot = 0;
    while let Some((row, contact)) = part {
        let manifold = order[slot].map_or(Manifold::default(), |k| made[k]);
        if let Some(admitted) = order[slot].and_then(|k| admitted[k]) {
            admitted.tell(row, contact, softened);
        }
        // Empty rows that stay empty need no writing.
        let idle = manifold.count == 0 && contact.count == 0;
        if !idle {
            rebuild(ctx, (row, contact), &manifold, (&pose_a, last), [a, b], out);
            keep_load(ctx, contact, a, b);
        }
        if contact.count > 0 && !contact.sensor {
            list_part(ctx, (row, contact), [a, b], out);
        }
        slot += 1;
        part = next(contact, slots);
    }
}

/// [`keep_load`] for all manifolds of a pair.
fn keep_loads(ctx: &StepContext, first: &mut Contact, (a, b): (&Body, &Body), slots: &Slots<'_>) {
    keep_load(ctx, first, a, b);
    let mut part = if first.others > 0 { next(first, slots) } else { None };
    while let Some((_, contact)) = part {
        keep_load(ctx, contact, a, b);
        part = next(contact, slots);
    }
}

/// Lists the manifolds with points, of a pair whose first manifold is `first`.
fn list_parts(
    ctx: &StepContext,
    (row, first): (u32, &Contact),
    bodies: [&Body; 2],
    slots: &ReadSlots<'_>,
    out: &mut Vec<Change>,
) {
    if first.sensor || first.count == 0 {
        return;
    }
    list_part(ctx, (row, first), bodies, out);
    let mut part = if first.others > 0 { read_next(first, slots) } else { None };
    while let Some((row, contact)) = part {
        if contact.count > 0 {
            list_part(ctx, (row, contact), bodies, out);
        }
        part = read_next(contact, slots);
    }
}

fn list_part(
    ctx: &StepContext,
    (row, contact): (u32, &Contact),
    bodies: [&Body; 2],
    out: &mut Vec<Change>,
) {
    out.push(seams::of_mesh(row, contact));
    list_for_solver(ctx, (row, contact), bodies, out);
}

/// The next manifold of a pair, with its row.
fn next<'a>(contact: &Contact, slots: &'a Slots<'_>) -> Option<(u32, &'a mut Contact)> {
    let row = contact.next_part;
    (row != NONE).then(|| slots.row(row as usize).as_mut().map(|c| (row, c))).flatten()
}

/// The next manifold of a pair, with its row, for reading.
fn read_next<'a>(contact: &Contact, slots: &'a ReadSlots<'_>) -> Option<(u32, &'a Contact)> {
    let row = contact.next_part;
    (row != NONE).then(|| slots.read(row as usize).as_ref().map(|c| (row, c))).flatten()
}

/// True if the shape has hardly moved since the manifolds were made.
fn may_recycle(
    ctx: &StepContext,
    contact: &Contact,
    (a, shape, slots): (&Body, &ShapeRow, &ReadSlots<'_>),
    motion: &Motion,
    [ahead, turn]: [f32; 2],
) -> bool {
    if contact.count == 0
        || contact.is_renewed()
        || (!a.is_dynamic() && a.active() && a.w != Vec3::ZERO)
    {
        return false;
    }
    let limit = ctx.recycle_distance.min(0.25 * motion.radius);
    let mut points = contact.count;
    let mut part = if contact.others > 0 { read_next(contact, slots) } else { None };
    while let Some((_, contact)) = part {
        points += contact.count;
        part = read_next(contact, slots);
    }
    // All triangles without points are farther away than the shape moves in this step. Otherwise a
    // fast shape must be tested again, and corners that were far when a tilted box landed on an
    // edge must not be missed.
    let seen = motion.since + ahead < contact.clear;
    // Other corners of a rolling hull may be nearly as low as those with points.
    let rolls = turn > ROLLS && matches!(&shape.solid.core, Core::Hull(h) if h.cuboid.is_none());
    let limit = if points < 3 && !seen { 0.2 * limit } else { limit };
    let limit = if rolls { limit.min(0.002 * motion.radius) } else { limit };
    motion.since < limit && (seen || ahead < 0.5 * ctx.margin)
}

/// Assigns the new manifolds to rows: each to the row of the old manifold with nearly the same
/// normal, so that it finds its impulses there; the others to the remaining rows. The first row is
/// never left empty.
fn continue_parts(
    contact: &Contact,
    made: &[Manifold],
    pose_a: &Pose,
    slots: &ReadSlots<'_>,
) -> [Option<usize>; MAX_PARTS] {
    let mut old = [None; MAX_PARTS];
    old[0] = (contact.count > 0).then_some(contact.normal);
    let mut part = read_next(contact, slots);
    for normal in &mut old[1..] {
        let Some((_, contact)) = part else { break };
        *normal = (contact.count > 0).then_some(contact.normal);
        part = read_next(contact, slots);
    }
    let mut order = [None; MAX_PARTS];
    let mut left = [false; MAX_PARTS];
    for (k, manifold) in made.iter().enumerate() {
        let normal = pose_a.direction(manifold.normal);
        let mut best = None;
        let mut maximum = SAME_PART;
        for slot in 0..MAX_PARTS {
            if order[slot].is_none()
                && let Some(before) = old[slot]
                && normal.dot(before) > maximum
            {
                (best, maximum) = (Some(slot), normal.dot(before));
            }
        }
        match best {
            Some(slot) => order[slot] = Some(k),
            None => left[k] = true,
        }
    }
    for k in 0..made.len() {
        if left[k]
            && let Some(slot) = order.iter().position(Option::is_none)
        {
            order[slot] = Some(k);
        }
    }
    if order[0].is_none()
        && let Some(slot) = order.iter().position(Option::is_some)
    {
        order.swap(0, slot);
    }
    order
}

/// Keeps the admitted ones of the first `count` manifolds, in their order, with their surface
/// properties; returns their number.
fn retain(
    made: &mut [Manifold; MAX_PARTS],
    admitted: &mut [Option<Admitted>; MAX_PARTS],
    count: usize,
    admit: impl Fn(&Manifold) -> Option<Admitted>,
) -> usize {
    let mut kept = 0;
    for i in 0..count {
        if let Some(surface) = admit(&made[i]) {
            made.swap(i, kept);
            admitted[kept] = Some(surface);
            kept += 1;
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use fearless_simd::dispatch;

    use crate::base::math::{Vec3, vec3};
    use crate::base::quat::Quat;
    use crate::base::random::Random;
    use crate::base::simd::wide::{LANES, SimdLevel};
    use crate::base::trig;
    use crate::geometry::collide::{MAX_PARTS, MeshScratch, Reach, collide_mesh};
    use crate::geometry::manifold::Manifold;
    use crate::geometry::mesh::Mesh;
    use crate::geometry::shape::Shape;
    use crate::geometry::solid::Core;
    use crate::state::bodies::body::Body;
    use crate::state::contacts::Probe;
    use crate::state::def::{BodyDef, ShapeDef};
    use crate::step::narrowphase::motion::{Motions, Pairs};
    use crate::world::World;

    const DT: f32 = 1.0 / 60.0;

    /// A hilly sheet of 20 m by 20 m.
    fn hills() -> Shape {
        let (mut corners, mut triangles) = (Vec::new(), Vec::new());
        let at = |i: u8| 0.5 * f32::from(i) - 10.0;
        for i in 0..=40 {
            for k in 0..=40 {
                let (x, z) = (at(i), at(k));
                let (wave, _) = trig::sin_cos(0.3 * x * z);
                corners.push(vec3(x, 0.02 * (x * x + z * z) + 0.2 * wave, z));
            }
        }
        for i in 0..40_u32 {
            for k in 0..40_u32 {
                let a = i * 41 + k;
                triangles.extend([[a, a + 1, a + 41], [a + 1, a + 42, a + 41]]);
            }
        }
        Shape::Mesh(Arc::new(Mesh::new(corners, triangles).unwrap()))
    }

    /// Long compounds of prisms and single ones over hills, at any angle, fast and slow.
    fn avalanche(random: &mut Random) -> World {
        #[expect(clippy::cast_possible_truncation, reason = "any number will do")]
        let mut between =
            |minimum: f32, maximum: f32| minimum + (maximum - minimum) * random.unit() as f32;
        let mut world = World::default();
        world.add_body(BodyDef::fixed().with_shape(ShapeDef::new(hills()))).unwrap();
        for i in 0..40_u8 {
            let turn = vec3(between(-3.0, 3.0), between(-3.0, 3.0), between(-3.0, 3.0));
            let at = vec3(between(-6.0, 6.0), between(2.5, 6.0), between(-6.0, 6.0));
            let w = vec3(between(-1.0, 1.0), between(-1.0, 1.0), between(-1.0, 1.0));
            let mut body = BodyDef::dynamic()
                .with_position(at)
                .with_rotation(Quat::from_rotation_vector(turn))
                .with_angular_velocity(w * if i % 4 == 0 { 20.0 } else { 2.0 });
            for part in 0..=i % 3 {
                let prism = ShapeDef::new(Shape::cylinder(0.4, 0.2)).with_density(500.0);
                let block = ShapeDef::box_half(vec3(0.2, 0.4, 0.15));
                let shape = if i % 2 == 0 { prism } else { block };
                body = body.with_shape(shape.with_position(vec3(0.0, 0.8 * f32::from(part), 0.0)));
            }
            world.add_body(body).unwrap();
        }
        world
    }

    /// Position of a point of B's frame in the frame of A.
    fn seen(point: Vec3, [a, b]: [Quat; 2], apart: Vec3) -> Vec3 {
        a.unrotate(apart + b.rotate(point))
    }

    #[test]
    fn motion_is_that_of_the_farthest_corner() {
        let mut random = Random::new(3);
        let mut world = avalanche(&mut random);
        let (mut reached, mut lane) = (0, 0);
        let (mut pairs, mut motions) = (Pairs::default(), Motions::default());
        for _ in 0..20 {
            let mut then = world.clone();
            for _ in 0..3 {
                world.step(DT);
            }
            let (then, now) = (&then.tables_mut().bodies, world.tables_mut());
            for (_, shape) in now.shapes.rows.iter().filter(|(_, s)| !s.is_mesh()) {
                let b: &Body = now.bodies.at(shape.body);
                // A mesh that turns and drifts.
                let mut a = now.bodies.at(0).clone();
                a.rotation = Quat::from_rotation_vector(vec3(0.1, 0.5, -0.3));
                (a.center, a.v, a.w) = (vec3(0.3, 0.1, 0.0), Vec3::X, vec3(0.0, 0.5, 1.0));
                let b_then = then.at(shape.body);
                let probe = Probe {
                    gap: 0.0,
                    offset: b_then.center,
                    rotation_a: Quat::IDENTITY,
                    rotation_b: b_then.rotation,
                };
                pairs.fill(lane, &probe, &a, b, shape);
                dispatch!(SimdLevel::best().0, simd => pairs.find(simd, &mut motions));
                let motion = motions.at(lane);
                lane = (lane + 1) % LANES;
                let core = shape.solid.core_box();
                let (mut moved, mut speed, mut spin) = (0.0_f32, 0.0_f32, 0.0_f32);
                for k in 0..8_u8 {
                    let side = |axis: u8| if k >> axis & 1 == 0 { -1.0 } else { 1.0 };
                    let half = core.half_extents();
                    let arm = vec3(side(0) * half.x, side(1) * half.y, side(2) * half.z);
                    let p = shape.centered.point(core.center() + arm);
                    let here = seen(p, [a.rotation, b.rotation], b.center - a.center);
                    let there = seen(p, [probe.rotation_a, probe.rotation_b], probe.offset);
                    moved = moved.max((here - there).length());
                    let arm = b.rotation.rotate(p);
                    let against = a.velocity_at(b.center + arm - a.center);
                    speed = speed.max((b.velocity_at(arm) - against).length());
                    let arm = b.rotation.rotate(p - shape.centered.point(core.center()));
                    spin = spin.max((b.w - a.w).cross(arm).length());
                }
                // Some roundings of numbers of 10 m and 50 m/s.
                assert!((motion.since - moved).abs() < 1.0e-5, "{} {moved}", motion.since);
                assert!((motion.spin - spin).abs() < 1.0e-4, "{} {spin}", motion.spin);
                assert!(motion.speed > speed - 1.0e-4, "{} {speed}", motion.speed);
                reached += 1;
            }
        }
        assert!(reached > 1000, "{reached}");
    }

    #[test]
    fn what_is_in_a_mesh_was_seen_before_it_came_in() {
        let mut random = Random::new(11);
        let mut world = avalanche(&mut random);
        let level = SimdLevel::best().0;
        let mut scratch = MeshScratch::default();
        let (mut inside, mut waited) = (0, 0);
        let mut unseen = Vec::new();
        for step in 0..240 {
            world.step(DT);
            let mut new = Vec::new();
            let mut now = world.clone();
            let tables = now.tables_mut();
            let (bodies, shapes) = (&tables.bodies, &tables.shapes);
            let contacts = &tables.contacts;
            for watch in contacts.awake_watches() {
                let contact = contacts.at(watch.row());
                let (x, y) = (shapes.at(contact.shape_a), shapes.at(contact.shape_b));
                let Core::Mesh(mesh) = &x.solid.core else { continue };
                let (a, b) = (bodies.at(watch.body_a), bodies.at(watch.body_b));
                let b_in_a = x.placed(a).relative(&y.placed(b));
                let mut made = [Manifold::default(); MAX_PARTS];
                let still = Reach::still(0.0);
                let solid = &y.solid;
                let n = collide_mesh(level, mesh, solid, &b_in_a, &still, &mut scratch, &mut made);
                let points = made[..n].iter().flat_map(Manifold::points);
                let depth = -points.map(|p| p.separation).fold(0.0, f32::min);
                let deep = depth > 1.0e-3;
                // Points pushed in by an impact at another end within a step are found in the next
                // step.
                if deep && contact.count == 0 {
                    let displacement = DT * (b.v.length() + b.w.length() * b.extent);
                    assert!(
                        depth < displacement,
                        "step {step}, shape {}: {depth} m",
                        contact.shape_b
                    );
                    assert!(
                        !unseen.contains(&watch.row()),
                        "step {step}, shape {}",
                        contact.shape_b
                    );
                    new.push(watch.row());
                }
                inside += usize::from(deep);
                waited += usize::from(contact.count == 0);
            }
            unseen = new;
        }
        assert!(inside > 200 && waited > 2000, "{inside} {waited}");
    }
}
