//! Stage 8: islands whose bodies have all been still for long enough fall asleep.
//!
//! Reads: bodies (timers), contacts, joints. Writes: islands (splits), sets, events. Runs: serially
//! over awake bodies, and only when one of them was still for long enough; one island a step is split.
//! Where bodies freeze one by one, those touched by awake ones are looked at in every step.

pub(crate) mod freeze;

use super::context::StepContext;
use super::finalize::Note;
use crate::state::bodies::NONE;
use crate::state::config::SleepConfig;
use crate::state::sets::Sets;

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    /// Of each island with an awake body: the least still time of its bodies, and the greatest.
    times: Vec<(f32, f32)>,
    /// Islands that may rest or be split; kinematic bodies that do not move.
    rows: Vec<u32>,
    freeze: freeze::Scratch,
}

/// Puts still islands to sleep, and splits one that may come apart. `notes` are finalize's: only when one
/// tells of a body that was still for long enough are islands looked at.
pub(crate) fn rest_still_islands(
    ctx: &StepContext,
    config: &SleepConfig,
    notes: impl Iterator<Item = Note>,
    step: u64,
    sets: &mut Sets<'_>,
    scratch: &mut Scratch,
) {
    let Scratch { times, rows, freeze } = scratch;
    let mut still = false;
    rows.clear();
    for note in notes {
        match note {
            Note::Idle(row) => rows.push(row),
            Note::Still => still = true,
            _ => {}
        }
    }
    if !rows.is_empty() {
        sets.rest(rows);
    }
    if config.enabled && sets.islands.wake_alone {
        freeze::thaw(ctx, config, sets, freeze);
        if still {
            freeze::freeze(ctx, config, sets, freeze);
        }
    }
    if !still || !config.enabled {
        return;
    }
    rate_islands(sets, times);
    // In the order of their numbers.
    rows.clear();
    for row in &sets.bodies.awake {
        let island = sets.bodies.at(*row).island;
        if let Some((least, most)) = times.get_mut(island as usize)
            && *most >= config.time
            && (*least >= config.time || sets.islands.rows[island as usize].cut)
            && sets.islands.rows[island as usize].wait_until <= step
        {
            // Listed once.
            *least = f32::NEG_INFINITY;
            *most = -*most;
            rows.push(island);
        }
    }
    rows.sort_unstable();
    // The island to split: it was cut, and some body of it could sleep if it were alone. The one
    // that has waited longest; the lowest number among equals.
    let mut split = None;
    for &island in rows.iter() {
        let waited = -times[island as usize].1;
        if sets.islands.rows[island as usize].cut {
            if split.is_none_or(|(_, best)| waited > best) {
                split = Some((island, waited));
            }
        } else {
            let members = sets.islands.members(island, sets.bodies);
            if sets.islands.wake_alone {
                freeze::note_loads(ctx, &members, sets);
            }
            sets.rest(&members);
            sets.islands.give_back(members);
        }
    }
    if let Some((island, _)) = split {
        split_island(island, step, sets);
    }
}

/// Least and greatest still time of each island with an awake body.
fn rate_islands(sets: &Sets<'_>, times: &mut Vec<(f32, f32)>) {
    if times.len() < sets.islands.rows.len() {
        times.resize(sets.islands.rows.len(), (f32::INFINITY, 0.0));
    }
    let island_of = |row: &u32| sets.bodies.at(*row).island;
    for island in sets.bodies.awake.iter().map(island_of).filter(|i| *i != NONE) {
        times[island as usize] = (f32::INFINITY, 0.0);
    }
    for row in &sets.bodies.awake {
        let body = sets.bodies.at(*row);
        if body.island == NONE {
            continue;
        }
        let still = if body.can_sleep { body.still_time } else { 0.0 };
        let (least, most) = &mut times[body.island as usize];
        *least = least.min(still);
        *most = most.max(still);
    }
}

/// Replaces an island by its connected components.
fn split_island(island: u32, step: u64, sets: &mut Sets<'_>) {
    let members = sets.islands.members(island, sets.bodies);
    sets.islands.dissolve(island);
    for m in &members {
        sets.bodies.at_mut(*m).island = NONE;
    }
    for start in &members {
        if sets.bodies.at(*start).island != NONE {
            continue;
        }
        let component = sets.islands.create(*start, sets.bodies);
        let mut body = *start;
        while body != NONE {
            let mut at = sets.bodies.at(body).contacts;
            while at != NONE {
                let c = sets.contacts.at(at / 2);
                let other = if at & 1 == 0 { c.body_b } else { c.body_a };
                at = c.links[(at & 1) as usize].next;
                if c.count > 0 && !c.sensor {
                    join(component, other, sets);
                }
            }
            for i in 0..sets.bodies.at(body).joints.len() {
                let joint = sets.joints.at(sets.bodies.at(body).joints[i]);
                let other = if joint.body_a == body { joint.body_b } else { joint.body_a };
                join(component, other, sets);
            }
            body = sets.bodies.at(body).island_next;
        }
        sets.islands.split_again(component, step);
    }
    sets.islands.give_back(members);
}

/// Enters a body that is in no island yet.
fn join(component: u32, body: u32, sets: &mut Sets<'_>) {
    let row = sets.bodies.at(body);
    if row.is_dynamic() && row.island == NONE {
        sets.islands.push(component, body, sets.bodies);
    }
}
