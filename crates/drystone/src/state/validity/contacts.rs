//! Checks of contacts: the rows, the watches, and the lists of bodies.

use super::{Check, Seen, holds, is_direction};
use crate::base::limits;
use crate::state::bodies::{Bodies, NONE};
use crate::state::contacts::{Contact, Contacts, Point, Traits};
use crate::state::def::BodyKind;
use crate::state::shapes::{PairSurface, ShapeRow, Shapes};

pub(crate) fn check_contacts(contacts: &Contacts, bodies: &Bodies, shapes: &Shapes) -> Check {
    let (slots, free, watches, probes, awake) = contacts.parts();
    holds(
        slots <= 1 << 30 && watches.len() == probes && awake <= probes,
        "contacts are watched in part",
    )?;
    let mut seen = Seen::none_of(slots);
    for row in free {
        holds(seen.is_new(*row) && contacts.get(*row).is_none(), "a free contact is not free")?;
    }
    let living = contacts.iter().count();
    holds(living + free.len() == slots, "a contact is neither free nor in use")?;
    for (place, watch) in (0..).zip(watches) {
        let c = contacts.get(watch.row()).filter(|c| !c.is_part && c.probe.get() == place);
        let is_right = c.is_some_and(|c| {
            [c.body_a, c.body_b] == [watch.body_a, watch.body_b]
                && watch.bounces() == c.may_bounce()
                && watch.has_parts() == (c.next_part != NONE)
        });
        holds(is_right, "a contact is not the one that is watched")?;
    }
    let mut parts = 0;
    for (row, c) in contacts.iter() {
        check_contact(c, bodies, shapes)?;
        if c.is_part {
            continue;
        }
        let is_watched = watches.get(c.probe.get() as usize).is_some_and(|w| w.row() == row);
        holds(is_watched, "a contact is not watched")?;
        let moves = [c.body_a, c.body_b].iter().any(|body| bodies.at(*body).active());
        holds(
            moves == ((c.probe.get() as usize) < awake),
            "a contact sleeps where its bodies do not",
        )?;
        let (mut at, mut with_points) = (c.next_part, 0);
        while at != NONE {
            let part = contacts.get(at).filter(|p| p.is_part && p.probe.get() == row);
            let Some(part) = part else { return Err("a manifold is not of its contact") };
            let same = [part.shape_a, part.shape_b] == [c.shape_a, c.shape_b];
            holds(same && part.sensor == c.sensor, "a manifold is not of its contact")?;
            (at, with_points) = (part.next_part, with_points + usize::from(part.count > 0));
            parts += 1;
            // A cycle would never end.
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
    let moves = bodies.at(c.body_a).kind != BodyKind::Static
        || bodies.at(c.body_b).kind != BodyKind::Static
        || a.sees(b, true)
        || b.sees(a, true);
    holds(c.body_a != c.body_b && moves, "a contact is not between two bodies")?;
    let meshes = usize::from(a.is_mesh()) + usize::from(b.is_mesh());
    holds(
        meshes == 1 || !c.is_part && c.next_part == NONE && meshes == 0,
        "a contact has too many manifolds",
    )?;
    holds(c.sensor == (a.sensor || b.sensor), "a contact is not the sensor's")?;
    holds(
        is_surface(c, &shapes.surface_of(c.shape_a, c.shape_b)),
        "a contact has another surface",
    )?;
    holds(usize::from(c.count) <= c.points.len(), "a contact has too many points")?;
    let vectors = [c.tangent_impulse, c.rolling_impulse()];
    let impulses = c.points().iter().map(|p| p.impulse).chain([c.twist_impulse, c.approach()]);
    let finite = impulses.into_iter().all(f32::is_finite) && vectors.iter().all(|v| v.is_finite());
    holds(finite, "a contact has a part that is no number")?;
    // No point is farther from its body's center than two positions are apart.
    let maximum = 4.0 * limits::POSITION_KEPT.maximum;
    let near = |p: &Point| {
        p.r_a.is_below(maximum) && p.separation.abs() <= maximum && p.base.abs() <= maximum
    };
    let placed = c.offset.is_below(maximum) && c.points().iter().all(near);
    holds(placed, "a contact is nowhere")?;
    holds(c.count == 0 || is_direction(c.normal), "a contact has no direction")?;
    let recyclable = ShapeRow::are_recyclable(a, b);
    holds(c.recyclable == recyclable, "a contact is not as flat as it says")
}

/// Whether a contact has the combined surface of its shapes. Values from hooks in the last step may
/// be anything in range.
fn is_surface(c: &Contact, of: &PairSurface) -> bool {
    let same = |x: f32, y: f32| x.to_bits() == y.to_bits();
    let within = |x: f32, maximum: f32| (0.0..=maximum).contains(&x);
    // Two surfaces may use the product of their coefficients.
    let rubs = limits::FRICTION.maximum * limits::FRICTION.maximum;
    let asked = if c.traits.any(Traits::HOOKED) {
        within(c.friction, rubs) && within(c.restitution, limits::RESTITUTION.maximum)
    } else {
        same(c.friction, of.friction) && same(c.restitution, of.restitution)
    };
    asked
        && c.traits.of_surfaces() == of.traits
        && c.round_patch == of.round_patch
        && same(c.kinetic, of.kinetic)
        && same(c.rolling, of.rolling)
        && same(c.spinning, of.spinning)
}

/// Checks that each contact is once in the list of each of its bodies.
fn check_lists(contacts: &Contacts, bodies: &Bodies, living: usize) -> Check {
    let mut listed = 0;
    for (id, body) in bodies.rows.iter() {
        let (mut at, mut previous) = (body.ties.contacts, NONE);
        while at != NONE {
            let Some(c) = contacts.get(at / 2) else {
                return Err("a body names a contact that is gone");
            };
            let side = (at & 1) as usize;
            let own = [c.body_a, c.body_b][side] == id.index();
            holds(
                own && c.links[side].previous.get() == previous,
                "a body names a contact that is not its own",
            )?;
            (previous, at) = (at, c.links[side].next.get());
            listed += 1;
            holds(listed <= 2 * living, "a list of contacts goes round")?;
        }
    }
    holds(listed == 2 * living, "a contact is in no list")
}
