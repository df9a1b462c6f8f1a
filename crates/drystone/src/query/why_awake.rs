//! Why a body is awake: the main cause that keeps its island from sleeping, and the path to it.

use core::fmt;
use std::collections::VecDeque;

use crate::base::id::{BodyId, JointId};
use crate::base::math::{Vec3, bounded};
use crate::state::bodies::stillness::{
    StillnessRule, Verdict, drift_speed, free_acceleration, is_free,
};
use crate::state::bodies::{Bodies, NONE};
use crate::state::def::BodyKind;
use crate::state::def::drives::{Driver, Drives};
use crate::state::tables::Tables;

/// Cause that keeps a body awake, or the reason why there is none.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum AwakeCause {
    /// It is asleep.
    Asleep,
    /// It is static: neither awake nor asleep.
    Static,
    /// It is kinematic and at rest: the step computes nothing for it.
    Idle,
    /// It is kinematic and moves.
    Driven {
        /// Maximum speed of its points [m/s].
        speed: f32,
    },
    /// It is out of the simulation because its state became infinite or NaN.
    Faulted,
    /// It is disabled.
    Disabled,
    /// The world's configuration turns sleep off.
    SleepDisabled,
    /// The user disabled sleep for the body.
    CannotSleep,
    /// The body is too fast.
    TooFast {
        /// Maximum speed of its points [m/s].
        speed: f32,
        /// Speed below which it counts as still [m/s].
        limit: f32,
        /// A moving kinematic body that touches it or is joined to it, if there is one.
        driven_by: Option<BodyId>,
    },
    /// The body is slow, but a force acts on it that its supports do not balance: it falls, starts
    /// to move or tips over.
    Accelerates {
        /// Maximum acceleration of its points [m/s²], over a part of the sleep time.
        acceleration: f32,
        /// Acceleration up to which it counts as still [m/s²].
        limit: f32,
    },
    /// The body is slow, but a moving kinematic body touches it or is joined to it.
    Carried {
        /// The kinematic body.
        by: BodyId,
    },
    /// The body is slow, but touches a surface with a surface velocity.
    OnBelt {
        /// The body of that surface.
        of: BodyId,
    },
    /// The body is slow, but its load pressed it together with another one, and the two still move
    /// apart.
    Settles {
        /// The other body.
        with: BodyId,
    },
    /// The body is slow, but a drive or a spring of a joint has not come to rest.
    DrivenByJoint {
        /// That joint.
        joint: JointId,
    },
    /// The body is still, but has not been still for long enough.
    Waiting {
        /// Time left [s].
        seconds_left: f32,
    },
    /// All bodies connected to it could sleep, but its island also holds bodies that were connected
    /// to it until recently. The island is not yet split.
    NotSplit {
        /// Steps until the engine checks the island for a split, if nothing changes; other islands
        /// may go first.
        steps_left: u64,
    },
}

/// Why a body is awake, see [`crate::World::why_awake`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct WhyAwake {
    /// The cause that keeps it awake.
    pub cause: AwakeCause,
    /// The body that has this cause: the body of the query, or another one of its island.
    pub body: BodyId,
    /// Path from the body of the query to `body`, both included, each touching or joined to the
    /// next. It has one body if they are the same.
    pub path: Vec<BodyId>,
}

impl fmt::Display for AwakeCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Asleep => f.write_str("it is asleep"),
            Self::Static => f.write_str("it is static"),
            Self::Idle => f.write_str("it is kinematic and at rest"),
            Self::Driven { speed } => write!(f, "it is kinematic and moves at {speed} m/s"),
            Self::Faulted => f.write_str("its state became infinite or NaN"),
            Self::Disabled => f.write_str("it is disabled"),
            Self::SleepDisabled => f.write_str("sleep is turned off in the configuration"),
            Self::CannotSleep => f.write_str("it was told not to sleep"),
            Self::TooFast { speed, limit, driven_by } => {
                write!(f, "it moves at {speed} m/s, still is below {limit} m/s")?;
                match driven_by {
                    Some(_) => f.write_str("; a kinematic body moves it"),
                    None => Ok(()),
                }
            }
            Self::Accelerates { acceleration, limit } => {
                write!(f, "it is accelerated by {acceleration} m/s², still is up to {limit} m/s²")
            }
            Self::Carried { .. } => f.write_str("a kinematic body that moves touches or holds it"),
            Self::OnBelt { .. } => f.write_str("the surface moves that it touches"),
            Self::Settles { .. } => {
                f.write_str("its load pressed it together with what it touches")
            }
            Self::DrivenByJoint { .. } => {
                f.write_str("a drive or a spring of its joint has not come to rest")
            }
            Self::Waiting { seconds_left } => {
                write!(f, "it is still, and may sleep in {seconds_left} s")
            }
            Self::NotSplit { steps_left } => {
                write!(f, "its island is not taken apart yet, at the soonest in {steps_left} steps")
            }
        }
    }
}

/// Why the body in a row is awake.
pub(crate) fn why_awake(tables: &Tables, row: u32) -> WhyAwake {
    let Tables { config, bodies, .. } = tables;
    let body = bodies.at(row);
    let about_itself = |cause| {
        let id = bodies.id(row);
        WhyAwake { cause, body: id, path: vec![id] }
    };
    match body.kind {
        _ if body.record.disabled => return about_itself(AwakeCause::Disabled),
        BodyKind::Static => return about_itself(AwakeCause::Static),
        _ if body.record.faulted => return about_itself(AwakeCause::Faulted),
        BodyKind::Kinematic if body.active() => {
            let speed = bounded(body.greatest_speed(tables.config.length_scale));
            return about_itself(AwakeCause::Driven { speed });
        }
        BodyKind::Kinematic => return about_itself(AwakeCause::Idle),
        BodyKind::Dynamic if !body.active() => return about_itself(AwakeCause::Asleep),
        BodyKind::Dynamic => {}
    }
    if !(config.sleep.enabled && config.method.sleeps()) {
        return about_itself(AwakeCause::SleepDisabled);
    }
    let found = reach_all(tables, row);
    // The cause that lasts longest matters most. The order is: a cause without end; one of at least
    // the whole sleep time; a cause that takes effect after the sleep time; the remaining sleep
    // time. Of equal causes, the one fewest steps along the path wins.
    let mut culprit: Option<(usize, f32)> = None;
    for (place, (other, _)) in found.iter().enumerate() {
        let left = time_left(tables, *other);
        if left > 0.0 && culprit.is_none_or(|(_, maximum)| left > maximum) {
            culprit = Some((place, left));
        }
    }
    let lasts = culprit.is_some_and(|(_, left)| left >= f32::MAX);
    let hidden = || {
        let causes = found.iter().map(|(other, _)| lasting_cause(tables, *other));
        causes.enumerate().find_map(|(place, cause)| Some((place, cause?)))
    };
    let (place, cause) = match (if lasts { None } else { hidden() }, culprit) {
        (Some(found), _) => found,
        (None, Some((place, left))) => (place, own_cause(tables, found[place].0, left)),
        (None, None) => {
            return about_itself(match tables.islands.rows.get(body.sleep.island as usize) {
                Some(island) if island.len as usize > found.len() => {
                    let steps_left = island.wait_until.saturating_sub(tables.steps);
                    AwakeCause::NotSplit { steps_left }
                }
                // It falls asleep in the next step.
                _ => AwakeCause::Waiting { seconds_left: 0.0 },
            });
        }
    };
    let mut path = Vec::new();
    let mut at = place;
    loop {
        path.push(bodies.id(found[at].0));
        if at == 0 {
            break;
        }
        at = found[at].1;
    }
    path.reverse();
    WhyAwake { cause, body: bodies.id(found[place].0), path }
}

/// Returns the cause of a body that is too fast, or that stays awake for this time [s].
fn own_cause(tables: &Tables, row: u32, left: f32) -> AwakeCause {
    let body = tables.bodies.at(row);
    if !body.can_sleep {
        return AwakeCause::CannotSleep;
    }
    let (speed, limit) =
        (bounded(body.greatest_speed(tables.config.length_scale)), still_speed(tables, row));
    if speed < body.still_speed(tables.config.sleep_speed())
        && let Some(cause) = lasting_cause(tables, row)
    {
        return cause;
    }
    if speed < limit {
        return AwakeCause::Waiting { seconds_left: left };
    }
    AwakeCause::TooFast { speed, limit, driven_by: driver(tables, row) }
}

/// Speed below which a body is slow [m/s].
fn still_speed(tables: &Tables, row: u32) -> f32 {
    let body = tables.bodies.at(row);
    let limit = body.still_speed(tables.config.sleep_speed());
    if is_free(body) { limit.min(drift_speed(body, tables.config.length_scale)) } else { limit }
}

/// Returns the cause that keeps a slow body awake for as long as it lasts.
fn lasting_cause(tables: &Tables, row: u32) -> Option<AwakeCause> {
    let Tables { config, bodies, shapes, joints, contacts, .. } = tables;
    let (body, known) = (bodies.at(row), &bodies.stillness[row as usize]);
    if is_free(body) {
        let acceleration = bounded(free_acceleration(config.gravity, body, config.length_scale));
        if acceleration > 0.0 {
            return Some(AwakeCause::Accelerates { acceleration, limit: 0.0 });
        }
    }
    let spacing = StillnessRule::spacing_of(config.sleep.time);
    let length = config.length_scale;
    let drives = Drives { bodies, shapes, joints, contacts, length, spacing };
    match drives.driver(row) {
        Some(Driver::Body(by)) => return Some(AwakeCause::Carried { by: bodies.id(by) }),
        Some(Driver::Load(with)) => return Some(AwakeCause::Settles { with: bodies.id(with) }),
        Some(Driver::Belt(of)) => return Some(AwakeCause::OnBelt { of: bodies.id(of) }),
        Some(Driver::Joint(joint)) => {
            let joint = joints.rows.id_of(joint);
            return Some(AwakeCause::DrivenByJoint { joint });
        }
        None => {}
    }
    match known.verdict {
        Verdict::Rests => None,
        Verdict::Sways(acceleration, limit) => {
            let acceleration = bounded(acceleration);
            Some(AwakeCause::Accelerates { acceleration, limit: bounded(limit) })
        }
        Verdict::Creeps(speed, limit) => {
            let (speed, limit) = (bounded(speed), bounded(limit));
            Some(AwakeCause::TooFast { speed, limit, driven_by: None })
        }
    }
}

/// Minimum time for which a body will keep its island awake [s].
fn time_left(tables: &Tables, row: u32) -> f32 {
    let (body, sleep) = (tables.bodies.at(row), &tables.config.sleep);
    if !body.can_sleep {
        return f32::INFINITY;
    }
    // A moving body starts its sleep time when it is still: later than any body that is still
    // already.
    if body.greatest_speed(tables.config.length_scale) >= still_speed(tables, row) {
        return f32::MAX;
    }
    (sleep.time - body.sleep.still_time).max(0.0)
}

/// Returns all dynamic bodies that are connected to one, nearest first, each with the index in this
/// list of the body that led to it. Neighbors are in the order of the bodies' contacts and joints.
fn reach_all(tables: &Tables, row: u32) -> Vec<(u32, usize)> {
    let bodies = &tables.bodies;
    let mut seen = vec![false; bodies.rows.slot_count()];
    let mut found = vec![(row, 0)];
    let mut queue = VecDeque::from([0]);
    seen[row as usize] = true;
    while let Some(place) = queue.pop_front() {
        for_neighbors(tables, found[place].0, |other| {
            // A body that sleeps close by does not touch this one.
            let (body, seen) = (bodies.at(other), &mut seen[other as usize]);
            if body.is_dynamic() && body.active() && !core::mem::replace(seen, true) {
                queue.push_back(found.len());
                found.push((other, place));
            }
        });
    }
    found
}

/// Returns the first moving kinematic body that touches a body or is joined to it.
fn driver(tables: &Tables, row: u32) -> Option<BodyId> {
    let mut found = NONE;
    for_neighbors(tables, row, |other| {
        let body = tables.bodies.at(other);
        let moves = body.v != Vec3::ZERO || body.w != Vec3::ZERO;
        if found == NONE && body.kind == BodyKind::Kinematic && moves {
            found = other;
        }
    });
    (found != NONE).then(|| tables.bodies.id(found))
}

/// Calls `meet` for every body that touches one or is joined to it; maybe several times for the
/// same body.
fn for_neighbors(tables: &Tables, row: u32, mut meet: impl FnMut(u32)) {
    let bodies: &Bodies = &tables.bodies;
    for (contact, side) in tables.contacts.of_body(bodies.at(row)) {
        let c = tables.contacts.at(contact);
        if c.count > 0 && !c.sensor {
            meet(if side == 0 { c.body_b } else { c.body_a });
        }
    }
    for joint in &bodies.at(row).ties.joints {
        let joint = tables.joints.at(*joint);
        if joint.is_on() {
            meet(if joint.body_a == row { joint.body_b } else { joint.body_a });
        }
    }
}
