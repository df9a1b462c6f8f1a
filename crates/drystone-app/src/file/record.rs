//! `simulate --record`: a log of a run that can be run again, with the hashes of each step.

use std::path::{Path, PathBuf};

use drystone::StageHashes;
use drystone_scene::Running;
use serde::{Deserialize, Serialize};

use super::chunk;
use super::snapshot::{Recipe, Snapshot};
use crate::output::{Failure, Output};

/// First bytes of such a file.
pub(crate) const KIND: [u8; 8] = *b"drystlog";

/// The first chunk of a log: what was run. A chunk for the start and one for each step follow, then
/// the end.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Header {
    /// How the scene is made.
    pub(crate) recipe: Recipe,
    /// Steps a second.
    pub(crate) hz: f32,
    /// Where the run began, if not where its scene does.
    pub(crate) from: Option<Snapshot>,
}

/// Hashes after a step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct StepHashes {
    /// A hash for each stage, as [`drystone::World::stage_hashes`] gives them.
    pub(crate) stages: StageHashes,
    /// Numbers of the bodies whose hashes differ from those after the step before, with the new
    /// ones.
    pub(crate) bodies: Vec<(u32, u32)>,
}

/// The word that marks the last chunk of a log.
const END: &str = "whole log";

/// The last chunk of a log: nothing is missing.
#[derive(Serialize, Deserialize)]
struct End {
    word: String,
    /// Steps before it.
    steps: u64,
}

/// True if `bytes` are the last chunk of a log of `steps` steps, and nothing else. A step cannot be
/// taken for it: its chunk begins with hashes, where this one has [`END`].
pub(crate) fn is_end(bytes: &[u8], steps: u64) -> bool {
    let mut rest = bytes;
    let end: Option<End> = chunk::take(&mut rest);
    rest.is_empty() && end.is_some_and(|end| end.word == END && end.steps == steps)
}

/// Hashes of all bodies of a run, in the order in which they came.
#[derive(Debug, Default)]
pub(crate) struct BodyHashes {
    hashes: Vec<u32>,
}

impl BodyHashes {
    /// Hashes after the last step.
    pub(crate) fn step(&mut self, running: &Running) -> StepHashes {
        let stages = running.world.stage_hashes();
        let mut bodies = Vec::new();
        for (number, id) in (0_u32..).zip(&running.bodies) {
            // Half of the bits are enough to tell that a body differs; one that is gone has none.
            #[expect(clippy::cast_possible_truncation, reason = "half of the bits")]
            let hash = running.world.body(*id).map_or(0, |body| body.state_hash() as u32);
            if self.hashes.get(number as usize) != Some(&hash) {
                bodies.push((number, hash));
            }
        }
        self.apply(&bodies);
        StepHashes { stages, bodies }
    }

    /// Takes over the changes of a step.
    pub(crate) fn apply(&mut self, bodies: &[(u32, u32)]) {
        for &(number, hash) in bodies {
            // Bodies come in the order of their numbers.
            match self.hashes.get_mut(number as usize) {
                Some(place) => *place = hash,
                None => self.hashes.push(hash),
            }
        }
    }

    /// Numbers of the bodies that differ.
    pub(crate) fn different(&self, other: &Self) -> Vec<usize> {
        let most = self.hashes.len().max(other.hashes.len());
        (0..most).filter(|i| self.hashes.get(*i) != other.hashes.get(*i)).collect()
    }
}

/// A log being written.
#[derive(Debug)]
pub(crate) struct Record {
    output: Output,
    path: PathBuf,
    hashes: BodyHashes,
    /// The start and the steps so far.
    moments: u64,
}

impl Record {
    /// Opens the file and writes the run's header.
    pub(crate) fn create(path: &Path, header: &Header) -> Result<Self, Failure> {
        let mut output = Output::create(path)?;
        output.write(&chunk::title(KIND))?;
        let mut record =
            Self { output, path: path.to_owned(), hashes: BodyHashes::default(), moments: 0 };
        record.put(header)?;
        Ok(record)
    }

    fn put(&mut self, value: &impl Serialize) -> Result<(), Failure> {
        let wrong = |e| Failure::failed(format_args!("{}: {e}", self.path.display()));
        let bytes = chunk::put(value).map_err(wrong)?;
        self.output.write(&bytes)
    }

    /// Adds the start, or a step that was taken.
    pub(crate) fn add(&mut self, running: &Running) -> Result<(), Failure> {
        let step = self.hashes.step(running);
        self.moments += 1;
        self.put(&step)?;
        self.output.end_moment()
    }

    /// Adds the end and gives the file its name; returns the path.
    pub(crate) fn finish(mut self) -> Result<PathBuf, Failure> {
        let steps = self.moments.saturating_sub(1);
        self.put(&End { word: END.to_owned(), steps })?;
        self.output.finish()
    }
}
