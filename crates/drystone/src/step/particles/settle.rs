//! Ends the step of tied particles: displacements become positions, particles that passed through a
//! static shape are put back. Then timers, faults and tears follow, and particles at rest freeze.
#![expect(unsafe_code, reason = "promises that rows are kept apart")]

use super::fly::{is_computable, put_aside};
use super::meet::{Around, moves};
use super::scratch::Scratch as Stage;
use crate::base::math::{Vec3, vec3};
use crate::base::threads::disjoint::{Apart, Rows};
use crate::base::threads::jobs::{Jobs, collect_ranges, grain};
use crate::state::bodies::Bodies;
use crate::state::bounds::Bounds;
use crate::state::def::config::SleepConfig;
use crate::state::events::LinkTear;
use crate::state::particles::{LaneKind, Particles};
use crate::state::shapes::Shapes;
use crate::step::context::StepContext;

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    /// Lines that became non-finite.
    faults: Vec<Vec<u32>>,
    /// Minimum still time of each strand, by the line that names it.
    still: Vec<f32>,
    /// Links that tore in the last step.
    pub(crate) torn: Vec<LinkTear>,
    /// Strands that hang on a moving body.
    carried: Vec<u32>,
}

/// Ends the step of all particles. `h`: the length of their substeps [s].
pub(crate) fn settle(
    ctx: &StepContext,
    h: f32,
    particles: &mut Particles,
    bodies: &mut Bodies,
    shapes: &Shapes,
    bounds: &Bounds,
    stage: &mut Stage,
    jobs: &Jobs<'_>,
) {
    stage.settle.torn.clear();
    if particles.is_empty() {
        return;
    }
    let sleep = &ctx.sleep;
    advance(ctx, particles, bodies, (shapes, bounds), stage, jobs);
    stage.faults.extend(stage.settle.faults.iter().flatten());
    stage.faults.sort_unstable();
    for solver_row in &stage.faults {
        particles.take_out(*solver_row);
    }
    keep_awake(ctx, sleep, particles, bodies, stage);
    tear(particles, h, &mut stage.settle.torn);
    freeze(ctx, sleep, particles, bodies, stage);
    particles.last_h = h;
}

/// Adds displacements to positions.
fn advance(
    ctx: &StepContext,
    particles: &mut Particles,
    bodies: &Bodies,
    (shapes, bounds): (&Shapes, &Bounds),
    stage: &mut Stage,
    jobs: &Jobs<'_>,
) {
    let tied = &stage.tied;
    let Particles { rows, states, x, attachments, .. } = particles;
    // SAFETY: tied particles are all different, and each has a line and a place.
    let apart = unsafe { Apart::promise() };
    let (rows, states) = (Rows::new(rows.values_mut(), apart), Rows::new(states, apart));
    let x = Rows::new(x, apart);
    let around = Around { ctx, bodies, shapes, bounds, x: &[] };
    let minimum = grain(jobs, tied.len(), 256);
    collect_ranges(jobs, tied.len(), minimum, &mut stage.settle.faults, |range, out| {
        for solver_row in &tied[range] {
            let Some(particle) = rows.row(*solver_row as usize - 1) else { continue };
            let (row, place) = (states.row(*solver_row as usize), x.row(*solver_row as usize));
            let from = vec3(place[0], place[1], place[2]);
            let mut displacement = row.displacement();
            let far = displacement.length();
            particle.room -= far;
            if row.inverse_mass() > 0.0 && far > 0.5 * place[3] && particle.room <= 0.0 {
                let held = particle.attachment.checked_sub(1);
                let held = held.map(|i| attachments[i as usize].body);
                if let Some((part, n)) = around.crossing(from, displacement, particle, held) {
                    displacement = displacement * part + n * (0.5 * place[3]);
                    let v = row.velocity();
                    row.set_velocity(v - n * v.dot(n).min(0.0));
                }
            }
            let end = from + displacement;
            if !is_computable(end, row.velocity()) {
                put_aside(particle, row);
                out.push(*solver_row);
                continue;
            }
            *place = [end.x, end.y, end.z, place[3]];
        }
    });
}

/// Updates the timers of all moving particles. Bodies attached to particles in motion are not still
/// either, nor are those that hang on a moving strand, however slow.
fn keep_awake(
    ctx: &StepContext,
    sleep: &SleepConfig,
    particles: &mut Particles,
    bodies: &mut Bodies,
    stage: &mut Stage,
) {
    let dt = ctx.dt;
    let carried = &mut stage.settle.carried;
    carried.clear();
    let Particles { rows, states, .. } = particles;
    for (row, state) in rows.values_mut().iter_mut().zip(&mut states[1..]) {
        let Some(particle) = row else { continue };
        if particle.faulted {
            // Its neighbor may have become non-finite in this step, and an infinite value times an
            // inverse mass of 0 is NaN.
            state.set_velocity(Vec3::ZERO);
        }
        if moves(particle) {
            let still = state.velocity().length() < sleep.speed;
            particle.still_time = if still { particle.still_time + dt } else { 0.0 };
            if state.inverse_mass() <= 0.0 && state.velocity() != Vec3::ZERO {
                carried.push(particle.strand);
            }
        }
    }
    let met = stage.meetings.iter().filter(|m| m.pushes && m.separation <= ctx.margin);
    let held = particles.attachments.iter().map(|a| (a.solver_row, a.body));
    for held in &particles.attachments {
        let body = bodies.at(held.body);
        if body.active() && !body.is_dynamic() {
            carried.push(particles.at(held.solver_row).strand);
        }
    }
    carried.sort_unstable();
    for (solver_row, body) in met.map(|m| (m.solver_row, m.body)).chain(held) {
        let particle = particles.at(solver_row);
        let is_carried = || carried.binary_search(&particle.strand).is_ok();
        if moves(particle) && (particle.still_time < sleep.time || is_carried()) {
            let body = bodies.at_mut(body);
            body.sleep.still_time = if body.is_dynamic() { 0.0 } else { body.sleep.still_time };
        }
    }
}

/// Removes links that were stretched too far or pulled too hard, in the order of their slots.
fn tear(particles: &mut Particles, h: f32, torn: &mut Vec<LinkTear>) {
    if !particles.can_tear {
        return;
    }
    for (id, link) in particles.links.iter() {
        if !link.can_tear() {
            continue;
        }
        let (block, lane) = particles.block_of(link);
        let (a, b) = (block.row_a[lane], block.row_b[lane]);
        let distance = (particles.position(b) - particles.position(a)).length();
        let strain = distance / block.length[lane] - 1.0;
        let force = -block.impulse[lane] / h;
        debug_assert!(block.kinds[lane] != LaneKind::Idle, "links stand in lanes of theirs");
        if strain > link.tear_strain || force > link.tear_force {
            let id_of = |solver_row: u32| particles.rows.id_at(solver_row - 1).expect("ends live");
            torn.push(LinkTear { link: id, a: id_of(a), b: id_of(b), force, strain });
        }
    }
    for tear in torn.iter() {
        particles.remove_link(tear.link);
    }
}

/// Freezes strands that were still for long enough and that no awake body touches.
fn freeze(
    ctx: &StepContext,
    sleep: &SleepConfig,
    particles: &mut Particles,
    bodies: &Bodies,
    stage: &mut Stage,
) {
    if !sleep.enabled {
        return;
    }
    particles.find_strands();
    let still = &mut stage.settle.still;
    still.clear();
    still.resize(particles.states.len(), f32::INFINITY);
    let mut any = false;
    for (id, particle) in particles.rows.iter() {
        let state = &particles.states[id.index() as usize + 1];
        if moves(particle) {
            let minimum = &mut still[particle.strand as usize];
            let moved = state.inverse_mass() <= 0.0 && state.velocity() != Vec3::ZERO;
            *minimum = minimum.min(if moved { 0.0 } else { particle.still_time });
            any |= particle.still_time >= sleep.time;
        }
    }
    if !any {
        return;
    }
    let met = stage.meetings.iter().filter(|m| m.separation <= ctx.margin);
    let held = particles.attachments.iter().map(|a| (a.solver_row, a.body));
    for (solver_row, body) in met.map(|m| (m.solver_row, m.body)).chain(held) {
        if bodies.at(body).active() {
            still[particles.at(solver_row).strand as usize] = 0.0;
        }
    }
    let Particles { rows, states, .. } = particles;
    for (row, state) in rows.values_mut().iter_mut().zip(&mut states[1..]) {
        if let Some(particle) = row
            && moves(particle)
            && still[particle.strand as usize] >= sleep.time
        {
            particle.frozen = true;
            state.set_velocity(Vec3::ZERO);
        }
    }
}
