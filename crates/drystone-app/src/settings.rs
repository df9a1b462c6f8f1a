//! The settings of the command line for a world, and for the workers that step it.

use std::sync::Arc;
use std::thread::available_parallelism;

use drystone::method::Method;
use drystone::threads::{Executor, Inline, SimdLevel, Team};
use drystone::{Vec3, World, WorldConfig};

use crate::cli::{Length, Settings, Workers};
use crate::output::Failure;

/// Most worker threads that the command line allows.
const MOST_THREADS: usize = 256;

impl Settings {
    /// The gravity that is said [m/s²]; nothing where the scene's own holds. All settings are
    /// checked here, before any scene is read: no scene makes them right or wrong.
    pub(crate) fn gravity(&self) -> Result<Option<Vec3>, Failure> {
        let mut config = WorldConfig::default();
        self.apply(&mut config)?;
        Ok(said_gravity(&self.set, &config))
    }

    /// Changes the settings that are given.
    pub(crate) fn apply(&self, config: &mut WorldConfig) -> Result<(), Failure> {
        if let Some(method) = self.method.as_deref().and_then(Method::named) {
            config.method = method;
        }
        if let Some(substeps) = self.substeps {
            config.substeps = substeps;
        }
        set_all(config, &self.set)
    }
}

/// Changes what `--set` says.
pub(crate) fn set_all(config: &mut WorldConfig, pairs: &[(String, String)]) -> Result<(), Failure> {
    for (key, value) in pairs {
        config
            .set(key, value)
            .map_err(|e| Failure::usage(format_args!("--set {key}={value}: {e}")))?;
    }
    Ok(())
}

/// Gravity [m/s²] of a configuration that all of `--set` changed, if one of them is gravity.
pub(crate) fn said_gravity(pairs: &[(String, String)], config: &WorldConfig) -> Option<Vec3> {
    pairs.iter().any(|(key, _)| key == "gravity").then_some(config.gravity)
}

impl Length {
    /// Number of steps at `hz` steps a second; a scene's own length is `seconds` [s].
    pub(crate) fn steps(&self, seconds: f32, hz: f32) -> u64 {
        let seconds = self.seconds.unwrap_or_else(|| f64::from(seconds));
        self.steps.unwrap_or_else(|| steps_of(seconds, hz))
    }
}

/// Number of steps in `seconds`, to the nearest.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in range: 0 to 1e15")]
fn steps_of(seconds: f64, hz: f32) -> u64 {
    (seconds * f64::from(hz)).round() as u64
}

/// Time after `step` steps [s].
#[expect(clippy::cast_precision_loss, reason = "steps are far below 2^52")]
pub(crate) fn time_of(step: u64, hz: f32) -> f64 {
    step as f64 / f64::from(hz)
}

/// The number of the machine's cores less `spared`, at least one.
pub(crate) fn cores_but(spared: usize) -> usize {
    available_parallelism().map_or(1, |n| n.get().saturating_sub(spared).clamp(1, MOST_THREADS))
}

/// `threads` workers, the caller included.
pub(crate) fn executor(threads: usize) -> Arc<dyn Executor> {
    if threads > 1 { Arc::new(Team::new(threads)) } else { Arc::new(Inline) }
}

impl Workers {
    /// Has a world stepped so; returns the number of threads.
    pub(crate) fn equip(&self, world: &mut World) -> usize {
        let threads = self.threads.map_or_else(|| cores_but(0), usize::from);
        world.set_executor(executor(threads));
        if let Some(level) = self.simd.as_deref().and_then(SimdLevel::named) {
            world.set_simd_level(level);
        }
        threads
    }
}
