//! The stage `particles`: finds contacts of particles, and moves particles that are tied neither to
//! others nor to moving bodies.
//!
//! Reads: bodies, shapes, bounds. Writes: particles; wakes bodies that particles touch or hold.
//! Runs: in parallel over particles; results are merged in the order of their rows. Links,
//! attachments and contacts with moving bodies are solved in the solver's substeps (`pace`,
//! `links`, `chain`, `points`, `rows`), and [`settle`](settle::settle) ends their step. Invariants:
//! a color of links touches a particle once; every other particle is written by its own chunk only.
//! References: manual/particles.md, [Jakobsen01], [Macklin19].
#![expect(unsafe_code, reason = "promises that rows are kept apart")]

pub(crate) mod chain;
pub(crate) mod meet;
mod fly;
pub(crate) mod links;
pub(crate) mod pace;
mod points;
pub(crate) mod rows;
pub(crate) mod settle;
pub(crate) mod scratch;
pub(crate) mod tied;

use self::meet::{Around, Near, moves};
use self::scratch::{Found, Scratch};
use super::context::StepContext;
use crate::base::threads::disjoint::{Apart, Rows};
use crate::base::threads::jobs::{Jobs, collect_ranges, grain};
use crate::state::bodies::Bodies;
use crate::state::bounds::Bounds;
use crate::state::particles::{ParticleState, Particles};
use crate::state::sets::Sets;
use crate::state::shapes::Shapes;

/// Finds contacts of particles, moves free particles, and wakes touched bodies.
pub(crate) fn meet_shapes(
    ctx: &StepContext,
    particles: &mut Particles,
    shapes: &Shapes,
    bounds: &Bounds,
    sets: &mut Sets<'_>,
    scratch: &mut Scratch,
    jobs: &Jobs<'_>,
) {
    let s = scratch;
    s.tied.clear();
    s.meetings.clear();
    s.faults.clear();
    for row in s.pace.dragged.drain(..) {
        // Marks of the last step; bodies that are still dragged are marked again below.
        match sets.bodies.rows.at_mut(row) {
            Some(body) => {
                body.record.dragged = false;
                s.pace.released.push(row);
            }
            // Its solver body must be removed with it.
            None => sets.colors.bodies_changed = true,
        }
    }
    if particles.is_empty() {
        release(sets, s);
        return;
    }
    particles.find_strands();
    particles.find_chains();
    if particles.fixed_seen != bounds.fixed_changes {
        particles.fixed_seen = bounds.fixed_changes;
        particles.wake_all();
    }
    thaw(particles, sets.bodies, bounds, shapes, ctx, s, jobs);
    for i in 0..particles.attachments.len() {
        let held = particles.attachments[i];
        let particle = particles.at(held.solver_row);
        // A still particle lets the body sleep, and then freezes.
        let moving = moves(particle) && particle.still_time <= 0.0;
        if moving && sets.bodies.at(held.body).is_dynamic() {
            sets.wake(held.body);
        }
    }
    search(ctx, particles, shapes, bounds, sets.bodies, s, jobs);
    // An awake body pushes: particles at rest on it are searched again, as for moving bodies.
    let mut woke = false;
    for list in &s.found {
        for found in list {
            if let Found::Wakes(row) = found
                && !sets.bodies.at(*row).active()
            {
                sets.wake(*row);
                woke = true;
            }
        }
    }
    gather(s);
    if woke {
        for meeting in &mut s.meetings {
            meeting.pushes =
                sets.bodies.at(meeting.body).active() && sets.bodies.at(meeting.body).is_dynamic();
        }
    }
    mark_dragged(particles, sets, s);
    release(sets, s);
}

/// Wakes frozen strands that an awake body touches or holds.
fn thaw(
    particles: &mut Particles,
    bodies: &Bodies,
    bounds: &Bounds,
    shapes: &Shapes,
    ctx: &StepContext,
    s: &mut Scratch,
    jobs: &Jobs<'_>,
) {
    s.thawed.clear();
    if bodies.awake.is_empty() {
        return;
    }
    let around = Around { ctx, bodies, shapes, bounds, x: &particles.x };
    let rows = &particles.rows;
    let n = rows.slot_count();
    collect_ranges(jobs, n, grain(jobs, n, 256), &mut s.found, |range, out| {
        for slot in range {
            let solver_row = number(slot) + 1;
            if let Some(particle) = rows.at(solver_row - 1)
                && particle.frozen
                && around.is_disturbed(solver_row, particle)
            {
                out.push(Found::Thaws(solver_row));
            }
        }
    });
    s.thawed.extend(s.found.iter().flatten().filter_map(|found| match found {
        Found::Thaws(solver_row) => Some(*solver_row),
        _ => None,
    }));
    for held in &particles.attachments {
        if particles.at(held.solver_row).frozen && bodies.at(held.body).active() {
            s.thawed.push(held.solver_row);
        }
    }
    for solver_row in &s.thawed {
        if particles.at(*solver_row).frozen {
            particles.wake(*solver_row);
        }
    }
}

/// Searches around every moving particle, and moves the free ones for the whole step.
fn search(
    ctx: &StepContext,
    particles: &mut Particles,
    shapes: &Shapes,
    bounds: &Bounds,
    bodies: &Bodies,
    s: &mut Scratch,
    jobs: &Jobs<'_>,
) {
    let attachments = &particles.attachments;
    // SAFETY: each slot is in one range, and lines and places are those of the slot.
    let apart = unsafe { Apart::promise() };
    let states = Rows::new(&mut particles.states, apart);
    let n = particles.rows.slot_count();
    let rows = Rows::new(particles.rows.values_mut(), apart);
    let x = Rows::new(&mut particles.x, apart);
    let around = Around { ctx, bodies, shapes, bounds, x: &[] };
    collect_ranges(jobs, n, grain(jobs, n, 256), &mut s.found, |range, out| {
        let mut near = Near::default();
        for slot in range {
            let Some(particle) = rows.row(slot) else { continue };
            let number = number(slot) + 1;
            let state = states.row(slot + 1);
            state.x = if particle.faulted { ParticleState::OUT } else { [0.0; 4] };
            if particle.frozen || particle.faulted {
                continue;
            }
            let place = x.row(slot + 1);
            let held = particle.attachment.checked_sub(1).map(|i| attachments[i as usize].body);
            let path = fly::path(ctx, particle, state);
            around.look(number, place, particle, path.displacement, held, &mut near);
            let free = particle.links == 0 && held.is_none();
            let pushes = near.meetings().iter().any(|m| m.pushes || (m.asleep && !m.rests));
            if free && !pushes {
                if !fly::fly(ctx, particle, state, place, &path, &near, &around) {
                    out.push(Found::Fault(number));
                }
                continue;
            }
            state.x[3] = 1.0;
            out.push(Found::Tied(number));
            for meeting in near.meetings() {
                out.push(Found::Meets(*meeting));
                if meeting.asleep && !meeting.rests {
                    out.push(Found::Wakes(meeting.body));
                }
            }
        }
    });
}

fn gather(s: &mut Scratch) {
    for found in s.found.iter().flatten() {
        match found {
            Found::Tied(solver_row) => s.tied.push(*solver_row),
            Found::Meets(meeting) => s.meetings.push(*meeting),
            Found::Fault(solver_row) => s.faults.push(*solver_row),
            Found::Wakes(_) | Found::Thaws(_) => {}
        }
    }
}

/// Marks bodies that particles push: they need a row in the solver.
fn mark_dragged(particles: &Particles, sets: &mut Sets<'_>, s: &mut Scratch) {
    let met = s.meetings.iter().filter(|m| m.pushes).map(|m| m.body);
    let held = particles.attachments.iter().filter(|a| !particles.at(a.solver_row).frozen);
    for row in met.chain(held.map(|a| a.body)) {
        let body = sets.bodies.at_mut(row);
        if body.is_dynamic() && body.active() && !body.record.dragged {
            body.record.dragged = true;
            s.pace.dragged.push(row);
            // It may have had no row in the solver.
            sets.colors.bodies_changed |=
                body.ties.constraints == 0 && s.pace.released.binary_search(&row).is_err();
        }
    }
    s.pace.dragged.sort_unstable();
}

/// Releases bodies that are no longer dragged: without other constraints they lose their row in the
/// solver.
fn release(sets: &mut Sets<'_>, s: &mut Scratch) {
    for row in s.pace.released.drain(..) {
        if let Some(body) = sets.bodies.rows.at(row) {
            sets.colors.bodies_changed |= !body.record.dragged && body.ties.constraints == 0;
        }
    }
}

fn number(n: usize) -> u32 {
    u32::try_from(n).expect("fewer than 2^32 particles")
}
