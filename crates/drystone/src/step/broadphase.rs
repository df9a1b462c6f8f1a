//! Stage 1: shapes whose box in the tree is new or changed find new pairs, which become contacts.
//!
//! Reads: shapes, bounds, bodies. Writes: contacts (rows), bounds (move list). Runs: queries parallel
//! over moved shapes, rows made serially in the order of the sorted pairs.

use crate::base::jobs::{Executor, collect_ranges, grain};
use crate::base::math::Vec3;
use crate::base::pair_set::pair_key;
use crate::geometry::collide::MAX_PARTS;
use crate::geometry::manifold::PairCache;
use crate::state::bodies::{Bodies, NONE};
use crate::state::bounds::Bounds;
use crate::state::colors::Place;
use crate::state::contacts::Point;
use crate::state::contacts::{Contact, Contacts, Link, Probe};
use crate::state::def::BodyKind;
use crate::state::joints::Joints;
use crate::state::shapes::{ShapeRow, Shapes};

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    found: Vec<Vec<u64>>,
    pairs: Vec<u64>,
}

/// Finds the pairs and makes their contacts.
pub(crate) fn find_pairs(
    bodies: &mut Bodies,
    shapes: &Shapes,
    joints: &Joints,
    contacts: &mut Contacts,
    bounds: &mut Bounds,
    scratch: &mut Scratch,
    jobs: &dyn Executor,
) {
    bounds.tidy(shapes.rows.len());
    let Bounds { fixed, moving, moved, .. } = bounds;
    // Sorted, so that the pairs found do not depend on who moved first.
    moved.sort_unstable();
    moved.dedup();
    {
        let (bodies, contacts, moved) = (&*bodies, &*contacts, &*moved);
        collect_ranges(
            jobs,
            moved.len(),
            grain(jobs, moved.len(), 32),
            &mut scratch.found,
            |range, out| {
                for row in &moved[range] {
                    let shape = shapes.at(*row);
                    let mut meet = |other: u32| {
                        if other != *row
                            && !contacts.has_pair(*row, other)
                            && may_meet(bodies, joints, shape, shapes.at(other))
                        {
                            out.push(pair_key(*row, other));
                        }
                        true
                    };
                    moving.query(&shape.fat, &mut meet);
                    if !shape.fixed {
                        fixed.query(&shape.fat, &mut meet);
                    }
                }
            },
        );
    }
    moved.clear();
    let pairs = &mut scratch.pairs;
    pairs.clear();
    pairs.extend(scratch.found.iter().flatten());
    pairs.sort_unstable();
    pairs.dedup();
    for key in pairs.iter() {
        #[expect(clippy::cast_possible_truncation, reason = "the halves of a pair key")]
        let (a, b) = ((key >> 32) as u32, *key as u32);
        create(a, b, bodies, shapes, contacts);
    }
}

/// True if two shapes whose boxes overlap are to be watched.
fn may_meet(bodies: &Bodies, joints: &Joints, a: &ShapeRow, b: &ShapeRow) -> bool {
    if a.body == b.body || !a.filter.collides_with(b.filter) || (a.sensor && b.sensor) {
        return false;
    }
    let (body_a, body_b) = (bodies.at(a.body), bodies.at(b.body));
    let sensor = a.sensor || b.sensor;
    let static_ = |k: BodyKind| k == BodyKind::Static;
    if sensor {
        return !(static_(body_a.kind) && static_(body_b.kind));
    }
    if !body_a.is_dynamic() && !body_b.is_dynamic() {
        return false;
    }
    !body_a.joints.iter().any(|row| {
        let joint = joints.at(*row);
        !joint.collide_connected && (joint.body_a == b.body || joint.body_b == b.body)
    })
}

fn create(a: u32, b: u32, bodies: &mut Bodies, shapes: &Shapes, contacts: &mut Contacts) {
    // Meshes and half-spaces come first: their manifolds are computed from that side.
    let rank = |s: &ShapeRow| match s.shape.kind() {
        "mesh" => 0,
        "half-space" => 1,
        _ => 2,
    };
    let swap = rank(shapes.at(b)) < rank(shapes.at(a));
    let (a, b) = if swap { (b, a) } else { (a, b) };
    let (shape_a, shape_b) = (shapes.at(a), shapes.at(b));
    // Two meshes, or a mesh and a half-space, never meet: neither is on a dynamic body.
    if rank(shape_b) < 2 {
        return;
    }
    let (ma, mb) = (&shape_a.material, &shape_b.material);
    let sensor = shape_a.sensor || shape_b.sensor;
    let active = bodies.at(shape_a.body).active() || bodies.at(shape_b.body).active();
    let contact = Contact {
        shape_a: a,
        shape_b: b,
        body_a: shape_a.body,
        body_b: shape_b.body,
        links: [Link { previous: NONE, next: NONE }; 2],
        awake_row: NONE,
        place: Place::NOWHERE,
        next_part: NONE,
        first: NONE,
        is_part: false,
        approach: 0.0,
        sensor,
        touching: false,
        recyclable: shape_a.flat && shape_b.flat && !sensor,
        friction: ma.friction_combine.apply(mb.friction_combine, ma.friction, mb.friction),
        restitution: ma.restitution_combine.apply(
            mb.restitution_combine,
            ma.restitution,
            mb.restitution,
        ),
        rolling: (ma.rolling_resistance * shape_a.rolling_radius)
            .max(mb.rolling_resistance * shape_b.rolling_radius),
        normal: Vec3::Y,
        count: 0,
        points: [Point::default(); 4],
        tangent_impulse: Vec3::ZERO,
        twist_impulse: 0.0,
        rolling_impulse: Vec3::ZERO,
        cache: PairCache::default(),
        probe: Probe::default(),
    };
    let parts = if shape_a.is_mesh() { MAX_PARTS } else { 1 };
    let (mut first, mut last) = (NONE, NONE);
    for part in 0..parts {
        let row = contacts.insert(Contact { is_part: part > 0, ..contact.clone() }, bodies);
        if part == 0 {
            first = row;
        } else {
            contacts.at_mut(last).next_part = row;
        }
        contacts.at_mut(row).first = first;
        contacts.set_awake(row, active);
        last = row;
    }
}
