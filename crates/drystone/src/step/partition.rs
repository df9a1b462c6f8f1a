//! Stage 3: contacts that gained or lost points enter or leave the colors and islands; sleepers that
//! were met wake; ends are reported.
//!
//! Reads: bodies. Writes: colors, islands, sets, contacts (rows), events, bodies (levels). Runs: serially, over
//! changes only; levels in parallel, color after color.

use core::sync::atomic::{AtomicBool, Ordering};

use super::narrowphase::{Change, Scratch};
use crate::base::disjoint::Rows;
use crate::base::jobs::{Executor, for_ranges, grain};
use crate::base::sparse::Sparse;
use crate::state::bodies::Bodies;
use crate::state::bodies::NONE;
use crate::state::contacts::Contact;
use crate::state::events::{ContactEvent, Events, SensorEvent};
use crate::state::sets::Sets;
use crate::state::shapes::Shapes;

/// So many changes ahead the contact is asked for.
const AHEAD: usize = 6;

/// Applies the changes that narrowphase listed.
pub(crate) fn apply_touch_changes(scratch: &Scratch, shapes: &Shapes, sets: &mut Sets<'_>) {
    let changes = || scratch.changes().filter(|c| matches!(c, Change::Apart(_) | Change::Count(_)));
    let mut soon = changes().skip(AHEAD);
    for change in changes() {
        if let Some(Change::Apart(row) | Change::Count(row)) = soon.next() {
            sets.contacts.prefetch(row, Contact::CACHE_LINES);
        }
        match change {
            Change::Apart(row) => {
                if sets.islands.wake_alone {
                    wake_held(row, sets);
                }
                end_contact(row, shapes, sets);
            }
            Change::Count(row) => recount(row, shapes, sets),
            Change::Made(_) | Change::Carries(_) | Change::Closes(_) => {}
        }
    }
}

/// Memory kept from step to step: the levels to be.
#[derive(Clone, Debug, Default)]
pub(crate) struct Levels {
    next: Sparse,
}

/// Levels are for who looks at the world, so they may lag: a relaxation reads every contact.
const RELAX_EVERY: u64 = 4;

/// One Jacobi relaxation of the levels of the contact graph, level = 1 + the least level of a touching
/// neighbor: converges in as many calls as the graph is deep, and costs nothing while nothing changes.
/// What is written of bodies that are not awake is never read.
pub(crate) fn relax_levels(
    step: u64,
    sets: &mut Sets<'_>,
    scratch: &mut Levels,
    jobs: &dyn Executor,
) {
    let Sets { bodies, contacts, colors, .. } = sets;
    scratch.next.cover(bodies.rows.slot_count());
    if !step.is_multiple_of(RELAX_EVERY) || !core::mem::take(&mut colors.levels_dirty) {
        return;
    }
    let next = scratch.next.lend();
    let n = bodies.awake.len();
    for_ranges(jobs, n, grain(jobs, n, 1024), |range| {
        bodies.awake[range].iter().for_each(|row| next.set(*row, NONE));
    });
    // Of a color's contacts no two have the same dynamic body.
    for coloring in [&colors.contacts, &colors.contacts_fixed] {
        for color in &coloring.colors {
            let members = &color.members;
            for_ranges(jobs, members.len(), grain(jobs, members.len(), 128), |range| {
                for k in range {
                    if let Some(soon) = members.get(k + AHEAD) {
                        contacts.prefetch(*soon, 1);
                    }
                    let c = contacts.at(members[k]);
                    let ends = [c.body_a, c.body_b];
                    let [a, b] = ends.map(|row| bodies.at(row));
                    for (row, body, other) in [(ends[0], a, b), (ends[1], b, a)] {
                        if body.is_dynamic() {
                            next.set(row, next.get(row).min(other.level.saturating_add(1)));
                        }
                    }
                }
            });
        }
    }
    // A body above all that is held would count up for ever when its ground is taken away.
    let most = u32::try_from(n).unwrap_or(NONE);
    let changed = AtomicBool::new(false);
    let (awake, rows) = (&bodies.awake, Rows::new(bodies.rows.values_mut()));
    for_ranges(jobs, n, grain(jobs, n, 256), |range| {
        let mut any = false;
        for row in &awake[range] {
            if let Some(body) = rows.row(*row as usize)
                && body.is_dynamic()
            {
                let level = next.get(*row);
                let level = if level > most { NONE } else { level };
                any |= level != body.level;
                body.level = level;
            }
        }
        if any {
            changed.store(true, Ordering::Relaxed);
        }
    });
    colors.levels_dirty = changed.into_inner();
}

/// Wakes a frozen body that this contact held in the last step: what held it went so fast that there is no step
/// in which the load shows that it is gone.
fn wake_held(first: u32, sets: &mut Sets<'_>) {
    let mut row = first;
    while row != NONE {
        let c = sets.contacts.at(row);
        let (held, bodies) = (c.count > 0 && !c.sensor, [c.body_a, c.body_b]);
        row = c.next_part;
        for body in bodies {
            if held && sets.bodies.at(body).is_dynamic() && !sets.bodies.at(body).active() {
                sets.wake(body);
            }
        }
    }
}

/// Removes a contact with all its parts; reports the end if it was touching.
pub(crate) fn end_contact(first: u32, shapes: &Shapes, sets: &mut Sets<'_>) {
    report_end(first, shapes, sets);
    let mut row = first;
    while row != NONE {
        let next = sets.contacts.at(row).next_part;
        sets.remove_contact(row);
        row = next;
    }
}

fn report_end(first: u32, shapes: &Shapes, sets: &mut Sets<'_>) {
    let c = sets.contacts.at_mut(first);
    if core::mem::take(&mut c.touching) {
        let c = sets.contacts.at(first);
        push(c, false, shapes, sets.bodies, sets.events);
    }
}

/// Sets or clears the touch of a pair on all its parts.
fn set_touching(first: u32, touching: bool, sets: &mut Sets<'_>) {
    let mut row = first;
    while row != NONE {
        let c = sets.contacts.at_mut(row);
        c.touching = touching;
        row = c.next_part;
    }
}

fn recount(row: u32, shapes: &Shapes, sets: &mut Sets<'_>) {
    let c = sets.contacts.at(row);
    let (first, count, sensor) = (c.first(row), c.count, c.sensor);
    if sensor {
        let touching = count > 0;
        if c.touching != touching {
            sets.contacts.at_mut(row).touching = touching;
            push(sets.contacts.at(row), touching, shapes, sets.bodies, sets.events);
        }
        return;
    }
    if count == 0 {
        if !c.place.is_somewhere() && !c.touching {
            // It had points for a moment only: it was a ghost.
            return;
        }
        let (a, b) = (c.body_a, c.body_b);
        sets.uncolor_contact(row);
        sets.islands.cut(a, sets.bodies);
        sets.islands.cut(b, sets.bodies);
        let mut left = 0;
        let mut part = first;
        while part != NONE {
            let c = sets.contacts.at(part);
            left += u32::from(c.count);
            part = c.next_part;
        }
        if left == 0 {
            report_end(first, shapes, sets);
            set_touching(first, false, sets);
        }
        return;
    }
    if c.place.is_somewhere() {
        sets.mark_dirty(row);
        return;
    }
    let (a, b) = (c.body_a, c.body_b);
    // Among bodies that freeze one by one a gentle touch wakes nothing: the load that comes with it may.
    let speed = |body: u32| sets.bodies.at(body).greatest_speed();
    let gentle = sets.islands.wake_alone && speed(a) + speed(b) < sets.islands.gentle_speed;
    if !gentle {
        sets.wake(a);
        sets.wake(b);
    }
    sets.color_contact(row);
}

/// Reports contacts that the solver found pressed together for the first time, and hits.
pub(crate) fn report_begun(
    begun: impl Iterator<Item = u32>,
    hit_speed: f32,
    shapes: &Shapes,
    sets: &mut Sets<'_>,
) {
    for row in begun {
        let c = sets.contacts.at(row);
        if c.touching {
            continue;
        }
        let first = c.first(row);
        if c.approach() > hit_speed {
            let body = sets.bodies.at(c.body_a);
            let deepest = c.points().iter().min_by(|p, q| p.separation.total_cmp(&q.separation));
            let hit = crate::state::events::HitEvent {
                shape_a: shapes.id(c.shape_a),
                shape_b: shapes.id(c.shape_b),
                body_a: sets.bodies.id(c.body_a),
                body_b: sets.bodies.id(c.body_b),
                point: body.center + deepest.map(|p| p.r_a).unwrap_or_default(),
                normal: c.normal,
                speed: c.approach(),
            };
            sets.events.hits.push(hit);
        }
        push(sets.contacts.at(first), true, shapes, sets.bodies, sets.events);
        set_touching(first, true, sets);
    }
}

fn push(c: &Contact, begin: bool, shapes: &Shapes, bodies: &Bodies, events: &mut Events) {
    let (shape_a, shape_b) = (shapes.id(c.shape_a), shapes.id(c.shape_b));
    let (body_a, body_b) = (bodies.id(c.body_a), bodies.id(c.body_b));
    if c.sensor {
        let event = if shapes.at(c.shape_a).sensor {
            SensorEvent {
                sensor: shape_a,
                visitor: shape_b,
                sensor_body: body_a,
                visitor_body: body_b,
            }
        } else {
            SensorEvent {
                sensor: shape_b,
                visitor: shape_a,
                sensor_body: body_b,
                visitor_body: body_a,
            }
        };
        if begin { events.sensor_enter.push(event) } else { events.sensor_exit.push(event) }
    } else {
        let event = ContactEvent { shape_a, shape_b, body_a, body_b };
        if begin { events.contact_begin.push(event) } else { events.contact_end.push(event) }
    }
}
