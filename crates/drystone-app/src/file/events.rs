//! The event file: each line is one JSON object, an event of a step. The last line has the number
//! of lines before it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use drystone::events::{ContactEvent, Events, FaultKind, FractureCause, JointLimit};
use drystone::particle::ParticleId;
use drystone::{BodyId, Vec3};
use serde::Serialize;

use crate::output::{Failure, Output};

/// The names of bodies by their ids.
#[derive(Debug, Default)]
pub(crate) struct Names {
    of: BTreeMap<BodyId, String>,
}

impl Names {
    /// Learns the names of bodies that have joined; `bodies` and `names` go together.
    pub(crate) fn learn(&mut self, bodies: &[BodyId], names: &[String]) {
        for (&id, name) in bodies.iter().zip(names).skip(self.of.len()) {
            self.of.insert(id, name.clone());
        }
    }

    /// The name of a body; `#slot` if the scene has none for it.
    pub(crate) fn of(&self, id: BodyId) -> String {
        self.of.get(&id).map_or_else(|| format!("#{}", id.index()), Clone::clone)
    }
}

/// The word for a kind of fault.
pub(crate) const fn fault_word(kind: FaultKind) -> &'static str {
    match kind {
        FaultKind::NotFinite => "not_finite",
        FaultKind::BadTimeStep => "bad_time_step",
        FaultKind::Refused(_) => "refused",
        _ => "other",
    }
}

/// A line of the file: what happened, when, and what besides.
#[derive(Serialize)]
struct Line<T> {
    step: u64,
    time: f64,
    r#type: &'static str,
    #[serde(flatten)]
    what: T,
}

#[derive(Serialize)]
struct Pair {
    body_a: String,
    body_b: String,
}

#[derive(Serialize)]
struct Hit {
    body_a: String,
    body_b: String,
    point: [f32; 3],
    normal: [f32; 3],
    speed: f32,
    impulse: f32,
}

#[derive(Serialize)]
struct Visit {
    sensor: String,
    visitor: String,
}

#[derive(Serialize)]
struct Joint {
    joint: u32,
    body_a: String,
    body_b: String,
    limit: &'static str,
    force: f32,
    torque: f32,
    impulse: f32,
    damage: f32,
}

#[derive(Serialize)]
struct Bond {
    body: String,
    point: [f32; 3],
    tension: f32,
    shear: f32,
}

#[derive(Serialize)]
struct Broken {
    body: String,
    cause: &'static str,
    value: f32,
    limit: f32,
    point: [f32; 3],
    pieces: Vec<String>,
}

/// The word for what broke a joint.
const fn limit_word(limit: JointLimit) -> &'static str {
    match limit {
        JointLimit::Force => "force",
        JointLimit::Torque => "torque",
        JointLimit::Impulse => "impulse",
        JointLimit::Fatigue => "fatigue",
        _ => "other",
    }
}

/// The word for why a body came apart.
const fn cause_word(cause: FractureCause) -> &'static str {
    match cause {
        FractureCause::Glue => "glue",
        FractureCause::Impulse => "impulse",
        FractureCause::Energy => "energy",
        _ => "other",
    }
}

#[derive(Serialize)]
struct Body {
    body: String,
}

#[derive(Serialize)]
struct Tear {
    link: u32,
    a: u32,
    b: u32,
    force: f32,
    strain: f32,
}

#[derive(Serialize)]
struct Particle {
    particle: u32,
}

#[derive(Serialize)]
struct Fault {
    body: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    particle: Option<u32>,
    kind: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    call: Option<&'static str>,
}

/// The members that the last line adds to step, time and type.
#[derive(Serialize)]
struct End {
    /// Lines before this one.
    lines: u64,
}

/// An event file being written.
#[derive(Debug)]
pub(crate) struct EventLog {
    output: Output,
    lines: u64,
}

impl EventLog {
    /// Opens the file.
    pub(crate) fn create(path: &Path) -> Result<Self, Failure> {
        Ok(Self { output: Output::create(path)?, lines: 0 })
    }

    /// Adds the events of step `step`, which ended at `time` [s].
    pub(crate) fn add(
        &mut self,
        step: u64,
        time: f64,
        events: &Events,
        names: &Names,
    ) -> Result<(), Failure> {
        let pair =
            |e: &ContactEvent| Pair { body_a: names.of(e.body_a), body_b: names.of(e.body_b) };
        for e in &events.contact_begin {
            self.line(step, time, "contact_begin", pair(e))?;
        }
        for e in &events.contact_end {
            self.line(step, time, "contact_end", pair(e))?;
        }
        for e in &events.hits {
            let what = Hit {
                body_a: names.of(e.body_a),
                body_b: names.of(e.body_b),
                point: Vec3::to_array(e.point),
                normal: Vec3::to_array(e.normal),
                speed: e.speed,
                impulse: e.impulse,
            };
            self.line(step, time, "hit", what)?;
        }
        for (word, list) in
            [("sensor_enter", &events.sensor_enter), ("sensor_exit", &events.sensor_exit)]
        {
            for e in list {
                let what =
                    Visit { sensor: names.of(e.sensor_body), visitor: names.of(e.visitor_body) };
                self.line(step, time, word, what)?;
            }
        }
        for e in &events.joint_break {
            let what = Joint {
                joint: e.joint.index(),
                body_a: names.of(e.body_a),
                body_b: names.of(e.body_b),
                limit: limit_word(e.limit),
                force: e.force,
                torque: e.torque,
                impulse: e.impulse,
                damage: e.damage,
            };
            self.line(step, time, "joint_break", what)?;
        }
        for e in &events.bond_break {
            let what = Bond {
                body: names.of(e.body),
                point: Vec3::to_array(e.point),
                tension: e.tension,
                shear: e.shear,
            };
            self.line(step, time, "bond_break", what)?;
        }
        for e in &events.fractures {
            let what = Broken {
                body: names.of(e.body),
                cause: cause_word(e.cause),
                value: e.value,
                limit: e.limit,
                point: Vec3::to_array(e.point),
                pieces: events.pieces_of(e).iter().map(|id| names.of(*id)).collect(),
            };
            self.line(step, time, "fracture", what)?;
        }
        for (word, list) in [("sleep", &events.sleep), ("wake", &events.wake)] {
            for &id in list {
                self.line(step, time, word, Body { body: names.of(id) })?;
            }
        }
        for e in &events.link_tear {
            let (a, b) = (e.a.index(), e.b.index());
            let what = Tear { link: e.link.index(), a, b, force: e.force, strain: e.strain };
            self.line(step, time, "link_tear", what)?;
        }
        for e in &events.detached {
            self.line(step, time, "detached", Particle { particle: e.index() })?;
        }
        for e in &events.faults {
            let body = e.body.map(|id| names.of(id));
            let particle = e.particle.map(ParticleId::index);
            let call = match e.kind {
                FaultKind::Refused(call) => Some(call.name()),
                _ => None,
            };
            let what = Fault { body, particle, kind: fault_word(e.kind), call };
            self.line(step, time, "fault", what)?;
        }
        self.output.end_moment()
    }

    fn line<T: Serialize>(
        &mut self,
        step: u64,
        time: f64,
        word: &'static str,
        what: T,
    ) -> Result<(), Failure> {
        let line = Line { step, time, r#type: word, what };
        let mut text = serde_json::to_vec(&line).map_err(Failure::failed)?;
        text.push(b'\n');
        self.lines += 1;
        self.output.write(&text)
    }

    /// Adds the last line and gives the file its name; returns the path. `step` is the last step of
    /// the run, and `time` [s] is when it ended.
    pub(crate) fn finish(mut self, step: u64, time: f64) -> Result<PathBuf, Failure> {
        let lines = self.lines;
        self.line(step, time, "end", End { lines })?;
        self.output.finish()
    }
}
