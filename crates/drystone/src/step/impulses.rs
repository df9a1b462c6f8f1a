//! Part of the stage `sensor`: what contacts gave in the step becomes hits and forces.

use super::solver::totals_rows::Given;
use crate::base::math::Vec3;
use crate::state::contacts::Contact;
use crate::state::events::{ContactForce, Events, ForcePoint, HitEvent};
use crate::state::sets::Sets;
use crate::state::shapes::Shapes;

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    asked: Vec<Given>,
}

/// Reports hits, and the forces of pairs that are asked for them. `dt`: of the step [s].
pub(crate) fn report_given(
    given: impl Iterator<Item = Given>,
    (dt, hit_speed): (f32, f32),
    shapes: &Shapes,
    sets: &mut Sets<'_>,
    scratch: &mut Scratch,
) {
    scratch.asked.clear();
    for given in given {
        // Contacts of what was put aside in this step are gone.
        let Some(c) = sets.contacts.get(given.contact) else { continue };
        let [a, b] = [c.shape_a, c.shape_b].map(|row| shapes.at(row).reports);
        let fast = |least: f32| c.approach() > least;
        if given.landed != 0 && a.hit_speed_with(b, hit_speed).is_some_and(fast) {
            let hit = hit(c, &given, shapes, sets);
            sets.events.hits.push(hit);
        }
        if given.asked && (a.forces || b.forces) {
            scratch.asked.push(given);
        }
    }
    merge_hits(&mut sets.events.hits);
    let pair = |given: &Given| {
        let c = sets.contacts.at(given.contact);
        (shapes.id(c.shape_a), shapes.id(c.shape_b), given.contact)
    };
    scratch.asked.sort_unstable_by_key(pair);
    for given in &scratch.asked {
        report_forces(given, dt, shapes, sets);
    }
}

fn hit(c: &Contact, given: &Given, shapes: &Shapes, sets: &Sets<'_>) -> HitEvent {
    let points = c.points().iter().zip(&given.points).enumerate();
    // Of those that landed the one that was pressed most; of those that were pressed alike the deepest.
    let place = points.max_by(|(i, (p, pressed)), (j, (q, other))| {
        let landed = |k: usize| given.landed >> k & 1;
        let deeper = || q.separation.total_cmp(&p.separation);
        landed(*i).cmp(&landed(*j)).then(pressed.total_cmp(other)).then_with(deeper)
    });
    HitEvent {
        shape_a: shapes.id(c.shape_a),
        shape_b: shapes.id(c.shape_b),
        body_a: sets.bodies.id(c.body_a),
        body_b: sets.bodies.id(c.body_b),
        point: sets.bodies.at(c.body_a).center + place.map(|(_, (p, _))| p.r_a).unwrap_or_default(),
        normal: c.normal,
        speed: c.approach(),
        impulse: total(given),
    }
}

/// Impulse along the normal [N s].
fn total(given: &Given) -> f32 {
    given.points.iter().sum()
}

/// Of a pair with several manifolds that were hit the fastest stands for all, with the impulse of all.
fn merge_hits(hits: &mut Vec<HitEvent>) {
    let pair = |e: &HitEvent| (e.shape_a, e.shape_b);
    // To the last bit, since they come in an order that goes by the number of workers, and sums by their order.
    let bits = |e: &HitEvent| {
        let Vec3 { x, y, z } = e.point;
        [x, y, z, e.impulse].map(f32::to_bits)
    };
    hits.sort_unstable_by(|e, f| {
        let place = pair(e).cmp(&pair(f));
        place.then_with(|| f.speed.total_cmp(&e.speed)).then_with(|| bits(e).cmp(&bits(f)))
    });
    hits.dedup_by(|next, first| {
        let same = pair(next) == pair(first);
        if same {
            first.impulse += next.impulse;
        }
        same
    });
}

/// Adds a manifold to the list of forces, whose last pair may be its own.
fn report_forces(given: &Given, dt: f32, shapes: &Shapes, sets: &mut Sets<'_>) {
    let c = sets.contacts.at(given.contact);
    let (shape_a, shape_b) = (shapes.id(c.shape_a), shapes.id(c.shape_b));
    let normal_impulse = total(given);
    let center = sets.bodies.at(c.body_a).center;
    let Events { contact_forces, force_points, .. } = &mut *sets.events;
    let is_mine = |last: &ContactForce| (last.shape_a, last.shape_b) == (shape_a, shape_b);
    if !contact_forces.last().is_some_and(is_mine) {
        contact_forces.push(ContactForce {
            shape_a,
            shape_b,
            body_a: sets.bodies.id(c.body_a),
            body_b: sets.bodies.id(c.body_b),
            impulse: Vec3::ZERO,
            normal_impulse: 0.0,
            force: Vec3::ZERO,
            greatest_force: 0.0,
            points: [u32::try_from(force_points.len()).unwrap_or(u32::MAX), 0],
        });
    }
    if let Some(pair) = contact_forces.last_mut() {
        pair.impulse = (pair.impulse + given.push).bounded();
        pair.normal_impulse += normal_impulse;
        pair.force = (pair.impulse / dt).bounded();
        pair.greatest_force += given.peaks[4];
        pair.points[1] += u32::from(c.count.min(4));
    }
    for ((p, impulse), greatest_force) in c.points().iter().zip(given.points).zip(given.peaks) {
        let position = center + p.r_a;
        force_points.push(ForcePoint { position, normal: c.normal, impulse, greatest_force });
    }
}
