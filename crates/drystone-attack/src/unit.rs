//! A unit of work: one seed of one subject, and its result.

use std::path::PathBuf;

use crate::finding::Findings;
use crate::hunt::{self, Scene};
use crate::op::Style;
use crate::run::{Conditions, run};
use crate::{commands, files, generate, snapshots, soak, variants};

/// Target of an attack.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Subject {
    /// Worlds and programs of calls.
    Worlds,
    /// Files of scenes.
    Files,
    /// Snapshots of worlds.
    Snapshots,
    /// Command lines, recordings and snapshots of runs.
    Commands,
    /// A world that adds and removes the same number of objects for a long time.
    Soak,
    /// Small worlds of one kind, checked against physics.
    Scene(Scene),
}

impl Subject {
    /// All subjects of the attack.
    pub const ALL: [Self; 5] =
        [Self::Worlds, Self::Files, Self::Snapshots, Self::Commands, Self::Soak];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Worlds => "worlds",
            Self::Files => "files",
            Self::Snapshots => "snapshots",
            Self::Commands => "commands",
            Self::Soak => "soak",
            Self::Scene(scene) => scene.name(),
        }
    }

    /// The subject of this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let hunted = Scene::ALL.into_iter().map(Self::Scene);
        Self::ALL.into_iter().chain(hunted).find(|subject| subject.name() == name)
    }

    /// Its share of the time.
    #[must_use]
    pub const fn weight(self) -> f64 {
        match self {
            Self::Worlds => 70.0,
            Self::Files => 12.0,
            Self::Snapshots => 9.0,
            Self::Commands => 6.0,
            Self::Soak => 3.0,
            Self::Scene(_) => 1.0,
        }
    }

    /// Number of units of this subject in a campaign of this many worlds, roughly by its share of
    /// the time. `kinds` kinds of scenes share the worlds evenly.
    #[must_use]
    pub fn units_of(self, worlds: u64, kinds: usize) -> u64 {
        match self {
            Self::Worlds | Self::Snapshots => worlds,
            Self::Files => worlds.saturating_mul(3),
            Self::Commands => worlds.div_ceil(6),
            Self::Soak => worlds.div_ceil(4000),
            Self::Scene(_) => worlds.div_ceil(kinds.max(1) as u64),
        }
    }

    /// Processor time after which a unit counts as hanging [s].
    #[must_use]
    pub const fn limit(self) -> f64 {
        match self {
            Self::Worlds | Self::Snapshots => 20.0,
            Self::Files | Self::Soak => 40.0,
            // It only waits for the command, which has its own limit.
            Self::Commands => 60.0,
            // A world and its twins, each at most some seconds.
            Self::Scene(_) => 200.0,
        }
    }
}

/// Paths of files and programs.
#[derive(Clone, Debug)]
pub struct Places {
    /// The repository.
    pub root: PathBuf,
    /// A folder for the worker's own files.
    pub scratch: PathBuf,
    /// The command `drystone`.
    pub command: Option<PathBuf>,
    /// Whether faults and wild speeds of ordinary worlds are findings.
    pub strict: bool,
}

/// Result of a unit.
#[derive(Clone, Debug, Default)]
pub struct Unit {
    /// Number of worlds, files, snapshots or command lines.
    pub tried: u64,
    /// Number of steps.
    pub steps: u64,
    /// Number of refused operations, files, snapshots or command lines.
    pub refused: u64,
    /// Style of a world.
    pub style: Option<Style>,
    /// Number of faults.
    pub faults: u64,
    /// Whether a body became too fast.
    pub is_wild: bool,
    /// Whether it was ended early because it was slow.
    pub is_cut: bool,
    /// Whether something broke.
    pub failed: bool,
    /// Failures.
    pub findings: Findings,
    /// Damaged files, or damaged snapshots that broke something: name and bytes.
    pub inputs: Vec<(String, Vec<u8>)>,
}

/// Runs a unit.
#[must_use]
pub fn run_unit(subject: Subject, seed: u64, places: &Places) -> Unit {
    match subject {
        Subject::Worlds => world(seed, places.strict),
        Subject::Files => files::attack(seed, places),
        Subject::Snapshots => snapshots::attack(seed),
        Subject::Commands => commands::attack(seed, places),
        Subject::Soak => soak::attack(seed),
        Subject::Scene(scene) => hunt::run_unit(scene, seed),
    }
}

/// One world in this many is run again under other conditions, which must not change the result.
const VARIANTS_OF: u64 = 2;

fn world(seed: u64, strict: bool) -> Unit {
    let program = match crate::run::guarded(|| generate::program(seed)) {
        Ok(program) => program,
        Err(panic) => {
            let mut unit = Unit { tried: 1, ..Unit::default() };
            unit.findings.add(crate::finding::Kind::Panic, panic.place, panic.message, 0);
            return unit;
        }
    };
    let base = run(&program, &Conditions { strict, ..Conditions::BASE });
    let mut unit = Unit {
        tried: 1,
        steps: base.hashes.len() as u64,
        refused: u64::from(base.refused),
        style: Some(program.style),
        faults: u64::from(base.faults),
        is_wild: base.is_wild,
        is_cut: base.is_cut,
        failed: false,
        findings: base.findings.clone(),
        inputs: Vec::new(),
    };
    if seed.is_multiple_of(VARIANTS_OF) {
        unit.steps += variants::compare(&program, &base, &mut unit.findings) as u64;
    }
    unit
}
