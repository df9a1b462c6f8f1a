//! Stage 8: islands whose bodies have all been still for long enough fall asleep.
//!
//! Reads: bodies (timers), contacts, joints. Writes: islands (splits), sets, events. Runs: serially
//! over awake bodies; one island a step is split.

use crate::state::bodies::{Bodies, NONE};
use crate::state::config::SleepConfig;
use crate::state::contacts::Contacts;
use crate::state::def::BodyKind;
use crate::state::joints::Joints;
use crate::state::sets::Sets;

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    /// Of each island: the least still time of its bodies, and the greatest.
    times: Vec<(f32, f32)>,
}

/// Puts still islands to sleep, and splits one that may come apart.
pub(crate) fn rest_still_islands(config: &SleepConfig, sets: &mut Sets<'_>, scratch: &mut Scratch) {
    let idle: Vec<u32> = sets
        .bodies
        .awake
        .iter()
        .copied()
        .filter(|row| {
            let b = sets.bodies.at(*row);
            b.kind == BodyKind::Kinematic
                && b.v.length_squared() == 0.0
                && b.w.length_squared() == 0.0
        })
        .collect();
    if !idle.is_empty() {
        sets.rest(&idle);
    }
    if !config.enabled {
        return;
    }
    let times = &mut scratch.times;
    times.clear();
    times.resize(sets.islands.rows.len(), (f32::INFINITY, 0.0));
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
    // The island to split: it was cut, and some body of it could sleep if it were alone. The one
    // that has waited longest; the lowest number among equals.
    let mut split = None;
    for island in 0..times.len() {
        let (least, most) = times[island];
        if least.is_infinite() {
            continue;
        }
        let number = u32::try_from(island).expect("fewer islands than bodies");
        if sets.islands.rows[island].cut {
            if most >= config.time && split.is_none_or(|(_, best)| most > best) {
                split = Some((number, most));
            }
        } else if least >= config.time {
            let members = sets.islands.rows[island].bodies.clone();
            sets.rest(&members);
        }
    }
    if let Some((island, _)) = split {
        split_island(island, sets);
    }
}

/// Replaces an island by its connected components.
fn split_island(island: u32, sets: &mut Sets<'_>) {
    let members = sets.islands.dissolve(island);
    for m in &members {
        sets.bodies.at_mut(*m).island = NONE;
    }
    for start in &members {
        if sets.bodies.at(*start).island != NONE {
            continue;
        }
        let component = sets.islands.create(Vec::new(), sets.bodies);
        let mut found = vec![*start];
        sets.bodies.at_mut(*start).island = component;
        let mut next = 0;
        while let Some(&body) = found.get(next) {
            next += 1;
            for other in neighbors(body, sets.bodies, sets.contacts, sets.joints) {
                let o = sets.bodies.at_mut(other);
                if o.is_dynamic() && o.island == NONE {
                    o.island = component;
                    found.push(other);
                }
            }
        }
        sets.islands.rows[component as usize].bodies = found;
    }
}

/// Bodies connected to one by a contact with points or by a joint.
fn neighbors(body: u32, bodies: &Bodies, contacts: &Contacts, joints: &Joints) -> Vec<u32> {
    let mut all: Vec<u32> = contacts
        .of_body(bodies, body)
        .map(|(row, side)| (contacts.at(row), side))
        .filter(|(c, _)| c.count > 0 && !c.sensor)
        .map(|(c, side)| if side == 0 { c.body_b } else { c.body_a })
        .collect();
    all.extend(bodies.at(body).joints.iter().map(|row| {
        let joint = joints.at(*row);
        if joint.body_a == body { joint.body_b } else { joint.body_a }
    }));
    all
}
