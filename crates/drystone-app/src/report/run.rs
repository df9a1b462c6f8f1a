//! The report of a run: as JSON for programs, as text for people.

use std::path::PathBuf;

use drystone::World;
use drystone_scene::{Running, Scene};
use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

use super::audit::AuditReport;
use super::measure::{Measure, lines_of};
use super::page::{Page, bytes, count, si};
use crate::file::events::{Names, fault_word};
use crate::output::{Failure, one_line};

/// A run that has ended.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Run<'a> {
    /// The scene as the user wrote it.
    pub(crate) source: &'a str,
    /// The scene.
    pub(crate) scene: &'a Scene,
    /// Its world at the end.
    pub(crate) running: &'a Running,
    /// Steps a second.
    pub(crate) hz: f32,
    /// Worker threads.
    pub(crate) threads: usize,
    /// Steps that an earlier run had made, which this one went on from.
    pub(crate) from: u64,
    /// Steps made.
    pub(crate) steps: u64,
    /// Time simulated [s].
    pub(crate) seconds: f64,
    /// Steps that were requested; more than were made after Ctrl-C.
    pub(crate) asked: u64,
    /// Measurements.
    pub(crate) measure: &'a Measure,
    /// Whether the text has the audit too.
    pub(crate) audit: bool,
}

/// The report; its fields are those of the JSON file.
#[derive(Debug, Serialize)]
pub(crate) struct Report {
    scene: String,
    method: &'static str,
    hz: f32,
    substeps: u32,
    threads: usize,
    simd: &'static str,
    steps: u64,
    /// Steps made before, in a run that goes on from a snapshot.
    #[serde(skip_serializing_if = "Option::is_none")]
    from_step: Option<u64>,
    bodies: Bodies,
    shapes: usize,
    joints: usize,
    wall_ms: WallTime,
    #[serde(serialize_with = "in_order")]
    stages_ms: Vec<(&'static str, f64)>,
    contacts: Contacts,
    energy: Energies,
    /// Change of the sum of momentum over the run [kg m/s], by gravity and static bodies too.
    momentum_drift: f32,
    penetration: Penetration,
    joint_error: JointError,
    /// Only for scenes that have any.
    #[serde(skip_serializing_if = "Option::is_none")]
    particles: Option<Particles>,
    asleep_end: usize,
    /// How right the world is at the end.
    audit: AuditReport,
    hash: String,
    hashes: Vec<(u64, String)>,
    faults: Vec<FaultLine>,
    ignored: Vec<String>,
}

/// Bodies at the end, by kind.
#[derive(Debug, Serialize)]
struct Bodies {
    r#static: usize,
    kinematic: usize,
    dynamic: usize,
}

/// Time of the steps themselves, without outputs and measurements [ms].
#[derive(Debug, Serialize)]
struct WallTime {
    total: f64,
    step_mean: f64,
    step_median: f64,
    step_p99: f64,
}

/// Pairs of shapes with contact points.
#[derive(Debug, Serialize)]
struct Contacts {
    mean: f64,
    max: usize,
}

/// Energy [J]; potential energy is against the world's origin.
#[derive(Debug, Serialize)]
struct Energies {
    kinetic_start: f64,
    kinetic_end: f64,
    potential_start: f64,
    potential_end: f64,
    total_max: f64,
}

/// Deepest overlap [m]: over all steps, the 99th percentile over steps of the deepest of each step,
/// and after the last step.
#[derive(Debug, Serialize)]
struct Penetration {
    max: f64,
    p99: f64,
    end_max: f64,
}

/// Largest joint error [m]: over all steps, and the 99th percentile over steps.
#[derive(Debug, Serialize)]
struct JointError {
    max: f64,
    p99: f64,
}

/// Particles at the end, and what was measured of them.
#[derive(Debug, Serialize)]
struct Particles {
    count: usize,
    links: usize,
    asleep: usize,
    torn: usize,
    /// Deepest in a shape [m]: of all steps (above 2,000 particles of every 60th), and the last of
    /// those.
    penetration_max: f64,
    penetration_end: f64,
    /// Length error of a rod or thread [m]: the largest over all steps, and at the end.
    link_error_max: f64,
    link_error_end: f64,
}

impl Particles {
    fn of(measure: &Measure, world: &World) -> Option<Self> {
        let counts = world.counts();
        (counts.particles > 0).then(|| Self {
            count: counts.particles,
            links: counts.links,
            asleep: counts.particles_asleep,
            torn: measure.tears,
            penetration_max: measure.particle_penetration.max(),
            penetration_end: measure.particle_penetration.last(),
            link_error_max: measure.link_error.max(),
            link_error_end: measure.link_error.last(),
        })
    }

    fn rows(&self, page: &mut Page) {
        let Self { count: n, links, asleep, torn, .. } = self;
        let what = format!(
            "{}, {asleep} asleep; {}, {torn} torn",
            count(*n, "particle"),
            count(*links, "link")
        );
        page.row("particles", &what);
        let (max, end) = (si(self.penetration_max, "m"), si(self.penetration_end, "m"));
        let mut what = format!("penetration max {max}, at the end {end}");
        if *links > 0 {
            let (max, end) = (si(self.link_error_max, "m"), si(self.link_error_end, "m"));
            what += &format!("; link error max {max}, at the end {end}");
        }
        page.row("particles", &what);
    }
}

#[derive(Debug, Serialize)]
struct FaultLine {
    step: u64,
    body: Option<String>,
    kind: &'static str,
}

/// A map in the order of the list: stages stand in the order in which they run.
fn in_order<S: Serializer>(stages: &[(&str, f64)], to: S) -> Result<S::Ok, S::Error> {
    let mut map = to.serialize_map(Some(stages.len()))?;
    for (name, mean) in stages {
        map.serialize_entry(name, mean)?;
    }
    map.end()
}

impl Report {
    /// The report of a run whose stages took these mean times [ms].
    pub(crate) fn new(run: &Run<'_>, stages_ms: Vec<(&'static str, f64)>) -> Self {
        let (measure, world) = (run.measure, &run.running.world);
        let (config, counts) = (world.config(), world.counts());
        let method = &config.method;
        let mut names = Names::default();
        names.learn(&run.running.bodies, &run.running.names);
        let faults = measure.faults.iter().map(|fault| FaultLine {
            step: fault.step,
            body: fault.body.map(|id| names.of(id)),
            kind: fault_word(fault.kind),
        });
        Self {
            scene: run.source.to_owned(),
            method: method.name(),
            hz: run.hz,
            substeps: if config.substeps == 0 { method.substeps() } else { config.substeps },
            threads: run.threads,
            simd: world.simd_level().name(),
            steps: run.steps,
            from_step: (run.from > 0).then_some(run.from),
            bodies: Bodies {
                r#static: counts.fixed,
                kinematic: counts.kinematic,
                dynamic: counts.dynamic,
            },
            shapes: counts.shapes,
            joints: counts.joints,
            wall_ms: WallTime {
                total: measure.step_ms.sum(),
                step_mean: measure.step_ms.mean(),
                step_median: measure.step_ms.percentile(50),
                step_p99: measure.step_ms.percentile(99),
            },
            stages_ms,
            contacts: Contacts { mean: measure.contacts.mean(), max: measure.contacts_max },
            energy: Energies {
                kinetic_start: measure.energy_start.kinetic,
                kinetic_end: measure.energy_end.kinetic,
                potential_start: measure.energy_start.potential,
                potential_end: measure.energy_end.potential,
                total_max: measure.energy_max,
            },
            momentum_drift: measure.momentum_drift(world),
            penetration: Penetration {
                max: measure.penetration.max(),
                p99: measure.penetration.percentile(99),
                end_max: measure.penetration.last(),
            },
            joint_error: JointError {
                max: measure.joint_error.max(),
                p99: measure.joint_error.percentile(99),
            },
            particles: Particles::of(measure, world),
            asleep_end: counts.asleep,
            audit: AuditReport::of(world, &names),
            hash: hex(world.state_hash()),
            hashes: measure.hashes.iter().map(|&(step, hash)| (step, hex(hash))).collect(),
            faults: faults.collect(),
            ignored: lines_of(&run.scene.notes),
        }
    }

    /// As the JSON file.
    pub(crate) fn json(&self) -> Result<Vec<u8>, Failure> {
        let mut text = serde_json::to_vec_pretty(self).map_err(Failure::failed)?;
        text.push(b'\n');
        Ok(text)
    }

    /// For people: a line a subject, the subjects in a column.
    pub(crate) fn text(&self, run: &Run<'_>, written: &[PathBuf]) -> String {
        let mut page = Page::default();
        page.row("scene", &one_line(&format!("{} - {}", self.scene, run.scene.summary)));
        let Bodies { r#static, kinematic, dynamic } = self.bodies;
        page.row(
            "bodies",
            &format!(
                "{dynamic} dynamic, {kinematic} kinematic, {} static; {}, {}",
                r#static,
                count(self.shapes, "shape"),
                count(self.joints, "joint")
            ),
        );
        page.row(
            "method",
            &format!(
                "{}, {} at {} Hz; {}, {}",
                self.method,
                count(self.substeps, "substep"),
                self.hz,
                count(self.threads, "thread"),
                self.simd
            ),
        );
        self.text_of_times(run, &mut page);
        page.row("contacts", &format!("mean {:.0}, max {}", self.contacts.mean, self.contacts.max));
        let e = &self.energy;
        page.row(
            "energy",
            &format!(
                "kinetic {} -> {}, potential {} -> {}",
                si(e.kinetic_start, "J"),
                si(e.kinetic_end, "J"),
                si(e.potential_start, "J"),
                si(e.potential_end, "J")
            ),
        );
        let p = &self.penetration;
        page.row(
            "penetration",
            &format!(
                "max {}, p99 {}, at the end {}",
                si(p.max, "m"),
                si(p.p99, "m"),
                si(p.end_max, "m")
            ),
        );
        if self.joints > 0 {
            let j = &self.joint_error;
            page.row("joint error", &format!("max {}, p99 {}", si(j.max, "m"), si(j.p99, "m")));
        }
        if let Some(particles) = &self.particles {
            particles.rows(&mut page);
        }
        page.row("asleep", &format!("{} of {dynamic} dynamic bodies", self.asleep_end));
        if run.audit {
            self.audit.rows(&mut page);
        }
        page.row("hash", &self.hash);
        for fault in &self.faults {
            let body = fault.body.as_deref().unwrap_or("-");
            page.row("fault", &one_line(&format!("step {}, {body}: {}", fault.step, fault.kind)));
        }
        for note in &self.ignored {
            page.row("note", note);
        }
        for path in written {
            let size = std::fs::metadata(path).map_or(0, |m| m.len());
            page.row("written", &one_line(&format!("{} ({})", path.display(), bytes(size))));
        }
        page.text
    }

    fn text_of_times(&self, run: &Run<'_>, page: &mut Page) {
        let simulated = run.seconds;
        let stopped = if run.steps < run.asked {
            format!(", stopped before the {} asked for", run.asked)
        } else {
            String::new()
        };
        let after = self.from_step.map_or(String::new(), |from| format!(" after {from} before"));
        page.row("steps", &format!("{} = {simulated:.3} s{after}{stopped}", self.steps));
        let t = &self.wall_ms;
        let factor = if t.total > 0.0 {
            format!("; {:.1} times real time", simulated * 1000.0 / t.total)
        } else {
            String::new()
        };
        page.row(
            "ms a step",
            &format!(
                "mean {:.3}, median {:.3}, p99 {:.3}{factor}",
                t.step_mean, t.step_median, t.step_p99
            ),
        );
        if !self.stages_ms.is_empty() {
            let stages: Vec<String> =
                self.stages_ms.iter().map(|(name, mean)| format!("{name} {mean:.3}")).collect();
            page.row("", &stages.join(", "));
        }
    }
}

fn hex(hash: u64) -> String {
    format!("{hash:016x}")
}
