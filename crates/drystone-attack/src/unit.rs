//! A unit of work: one seed of one subject, and what it came to.

use std::path::PathBuf;

use crate::finding::Findings;
use crate::hunt::{self, Scene};
use crate::op::Style;
use crate::run::{Conditions, run};
use crate::{commands, files, generate, snapshots, soak, variants};

/// What is attacked.
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
    /// A world in which as much goes as comes, for long.
    Soak,
    /// Small worlds of one kind, held against physics.
    Scene(Scene),
}

impl Subject {
    /// All of the attack.
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

    /// Its part of the time.
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

    /// The number of units of this subject in a campaign of this many worlds, about by its part of the time. `kinds` kinds of scenes
    /// share the worlds evenly.
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

    /// A unit that has worked for longer and has not ended is taken for hanging [s].
    #[must_use]
    pub const fn limit(self) -> f64 {
        match self {
            Self::Worlds | Self::Snapshots => 20.0,
            Self::Files | Self::Soak => 40.0,
            // It only waits for the command, and knows when to end.
            Self::Commands => 60.0,
            // A world and its twins, each of at most some seconds.
            Self::Scene(_) => 200.0,
        }
    }
}

/// Where things are.
#[derive(Clone, Debug)]
pub struct Places {
    /// The repository.
    pub root: PathBuf,
    /// A folder of the worker's own, to write into.
    pub scratch: PathBuf,
    /// The command `drystone`.
    pub command: Option<PathBuf>,
    /// Whether faults and wild speeds of ordinary worlds are findings.
    pub strict: bool,
}

/// What a unit came to.
#[derive(Clone, Debug, Default)]
pub struct Unit {
    /// Worlds, files, snapshots or command lines.
    pub tried: u64,
    /// Steps of worlds.
    pub steps: u64,
    /// What was refused: operations, files, snapshots, command lines.
    pub refused: u64,
    /// Style of a world.
    pub style: Option<Style>,
    /// Whether it had faults, and how many.
    pub faults: u64,
    /// Whether a body became too fast.
    pub is_wild: bool,
    /// Whether it was ended early for its slowness.
    pub is_cut: bool,
    /// Whether something broke.
    pub failed: bool,
    /// What broke.
    pub findings: Findings,
    /// Damaged files, of snapshots those that broke something: name and bytes.
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

/// One world in two is run again under conditions that must not matter.
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
