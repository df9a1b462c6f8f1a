//! The stage `report`: turns the findings of the step into events, each list in a fixed order.
//!
//! Stages record findings where they occur; this file turns all of them into events, once, after
//! the last stage that has findings. Only joints, bonds and bodies that break are reported where
//! they are removed from the world. Order of the lists: begins and ends of touches, hits and forces
//! by the ids of their shapes; sensor events by sensor, then visitor; bodies that woke or fell
//! asleep by id, each once; torn links by id; faults: refused calls in call order, then bodies,
//! then particles, by id.
//!
//! Reads: contacts, shapes, bodies, findings of the stages. Writes: contacts (touching), events.
//! Runs: serially.

use super::context::StepContext;
use super::notes::Note;
use super::solver::totals_rows::ContactTotals;
use super::touches::{contact_event, reports_touch};
use super::{finalize, particles, partition, solver, sweep};
use crate::base::math::Vec3;
use crate::state::bodies::{Bodies, NONE};
use crate::state::contacts::{Contact, Contacts};
use crate::state::events::{ContactForce, Events, Fault, FaultKind, ForcePoint, HitEvent};
use crate::state::particles::Particles;
use crate::state::sets::Sets;
use crate::state::shapes::Shapes;

/// Prefetch distance, in contacts.
const PREFETCH: usize = 6;

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    asked: Vec<ContactTotals>,
}

/// Stages whose findings become events.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Found<'a> {
    pub(crate) partition: &'a partition::Scratch,
    pub(crate) particles: &'a particles::scratch::Scratch,
    pub(crate) solver: &'a solver::scratch::Scratch,
    pub(crate) finalize: &'a finalize::Scratch,
    pub(crate) sweep: &'a sweep::Scratch,
}

/// Reports the step with this number; the first step is 1.
pub(crate) fn report(
    ctx: &StepContext,
    step: u64,
    found: Found<'_>,
    shapes: &Shapes,
    particles: &Particles,
    sets: &mut Sets<'_>,
    scratch: &mut Scratch,
) {
    let Sets { bodies, contacts, events, .. } = sets;
    found.partition.touches().for_each(|touches| touches.report(events));
    report_begun(found.solver.begun(), shapes, bodies, contacts, events);
    events.sensor_enter.extend_from_slice(found.sweep.crossed());
    events.sensor_exit.extend_from_slice(found.sweep.crossed());
    let given = found.solver.given();
    report_given(given, (ctx.dt, ctx.hit_speed), shapes, bodies, contacts, events, scratch);
    events.link_tear.extend_from_slice(found.particles.torn());
    report_faults(step, found, bodies, particles, events);
    sort(events);
}

/// Sorts every list that was not found in its order.
fn sort(events: &mut Events) {
    events.contact_begin.sort_unstable_by_key(|e| (e.shape_a, e.shape_b));
    events.contact_end.sort_unstable_by_key(|e| (e.shape_a, e.shape_b));
    events.sensor_enter.sort_unstable_by_key(|e| (e.sensor, e.visitor));
    events.sensor_exit.sort_unstable_by_key(|e| (e.sensor, e.visitor));
    for bodies in [&mut events.wake, &mut events.sleep] {
        bodies.sort_unstable();
        bodies.dedup();
    }
    events.link_tear.sort_unstable_by_key(|e| e.link);
    events.detached.sort_unstable();
}

/// Reports faults of bodies and particles.
fn report_faults(
    step: u64,
    found: Found<'_>,
    bodies: &Bodies,
    particles: &Particles,
    events: &mut Events,
) {
    let calls = events.faults.len();
    let fault = Fault { body: None, joint: None, particle: None, kind: FaultKind::NotFinite, step };
    for note in found.finalize.notes() {
        if let Note::Fault(row) = note {
            events.faults.push(Fault { body: Some(bodies.id(row)), ..fault });
        }
    }
    events.faults[calls..].sort_unstable_by_key(|fault| fault.body);
    for line in found.particles.faults() {
        events.faults.push(Fault { particle: particles.rows.id_at(line - 1), ..fault });
    }
}

/// Reports contacts that bore an impulse for the first time, and marks them as touching.
fn report_begun(
    begun: impl Iterator<Item = u32> + Clone,
    shapes: &Shapes,
    bodies: &Bodies,
    contacts: &mut Contacts,
    events: &mut Events,
) {
    let mut soon = begun.clone().skip(PREFETCH);
    for row in begun {
        if let Some(soon) = soon.next() {
            contacts.prefetch(soon, Contact::CACHE_LINES);
        }
        let first = contacts.at(row).first(row);
        let c = contacts.at(first);
        if !c.touching {
            if reports_touch(c, shapes) {
                events.contact_begin.push(contact_event(c, shapes, bodies));
            }
            set_touching(first, contacts);
        }
    }
}

/// Sets `touching` of a pair on all its manifolds.
fn set_touching(first: u32, contacts: &mut Contacts) {
    let mut row = first;
    while row != NONE {
        let c = contacts.at_mut(row);
        c.touching = true;
        row = c.next_part;
    }
}

/// Reports hits, and the forces of pairs whose shapes request them. `dt`: length of the step [s].
fn report_given(
    given: impl Iterator<Item = ContactTotals>,
    (dt, hit_speed): (f32, f32),
    shapes: &Shapes,
    bodies: &Bodies,
    contacts: &Contacts,
    events: &mut Events,
    scratch: &mut Scratch,
) {
    scratch.asked.clear();
    for given in given {
        // Contacts of bodies that were set aside in this step are gone.
        let Some(c) = contacts.get(given.contact) else { continue };
        let [a, b] = [c.shape_a, c.shape_b].map(|row| shapes.at(row).reports);
        let fast = |minimum: f32| c.approach() > minimum;
        if given.landed != 0 && a.hit_speed_with(b, hit_speed).is_some_and(fast) {
            events.hits.push(hit(c, &given, shapes, bodies));
        }
        if given.asked && (a.forces || b.forces) {
            scratch.asked.push(given);
        }
    }
    merge_hits(&mut events.hits);
    let pair = |given: &ContactTotals| {
        let c = contacts.at(given.contact);
        (shapes.id(c.shape_a), shapes.id(c.shape_b), given.contact)
    };
    scratch.asked.sort_unstable_by_key(pair);
    for given in &scratch.asked {
        report_forces(given, dt, shapes, bodies, contacts, events);
    }
}

fn hit(c: &Contact, given: &ContactTotals, shapes: &Shapes, bodies: &Bodies) -> HitEvent {
    let points = c.points().iter().zip(&given.points).enumerate();
    // Among points that landed, the one with the greatest impulse; among equal impulses, the
    // deepest.
    let place = points.max_by(|(i, (p, pressed)), (j, (q, other))| {
        let landed = |k: usize| given.landed >> k & 1;
        let deeper = || q.separation.total_cmp(&p.separation);
        landed(*i).cmp(&landed(*j)).then(pressed.total_cmp(other)).then_with(deeper)
    });
    HitEvent {
        shape_a: shapes.id(c.shape_a),
        shape_b: shapes.id(c.shape_b),
        body_a: bodies.id(c.body_a),
        body_b: bodies.id(c.body_b),
        point: bodies.at(c.body_a).center + place.map(|(_, (p, _))| p.r_a).unwrap_or_default(),
        normal: c.normal,
        speed: c.approach(),
        impulse: total(given),
    }
}

/// Impulse along the normal [N s].
fn total(given: &ContactTotals) -> f32 {
    given.points.iter().sum()
}

/// Merges the hits of a pair with several manifolds: the fastest hit stands for all, with the sum
/// of the impulses.
fn merge_hits(hits: &mut Vec<HitEvent>) {
    let pair = |e: &HitEvent| (e.shape_a, e.shape_b);
    // The order is total to the last bit: hits arrive in an order that depends on the number of
    // workers, and sums depend on their order.
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

/// Adds a manifold to the list of forces, and merges it into the last entry if the pair is the
/// same.
fn report_forces(
    given: &ContactTotals,
    dt: f32,
    shapes: &Shapes,
    bodies: &Bodies,
    contacts: &Contacts,
    events: &mut Events,
) {
    let c = contacts.at(given.contact);
    let (shape_a, shape_b) = (shapes.id(c.shape_a), shapes.id(c.shape_b));
    let normal_impulse = total(given);
    let center = bodies.at(c.body_a).center;
    let Events { contact_forces, force_points, .. } = events;
    let is_mine = |last: &ContactForce| (last.shape_a, last.shape_b) == (shape_a, shape_b);
    if !contact_forces.last().is_some_and(is_mine) {
        contact_forces.push(ContactForce {
            shape_a,
            shape_b,
            body_a: bodies.id(c.body_a),
            body_b: bodies.id(c.body_b),
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
