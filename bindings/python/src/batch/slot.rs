//! One world of a batch.

use std::sync::Arc;

use drystone::World;
use drystone::threads::Inline;
use drystone_scene::{BuildError, Running, Scene, Script};

/// One world of a batch, and the rest of its scene that runs.
pub(super) struct Slot {
    pub(super) world: World,
    /// The running scene, with an empty world in place of the world.
    pub(super) rest: Running,
    /// Whether the rest changes as the world goes on: a script acts, or bodies break.
    is_live: bool,
}

impl Slot {
    pub(super) fn new(scene: &Scene, mut run: Running) -> Self {
        let breaks = scene.bodies.iter().any(|b| b.def.fracture.is_some() || b.def.glue.is_some());
        let is_live = breaks || !matches!(scene.script, Script::None);
        let mut world = core::mem::take(&mut run.world);
        world.set_executor(Arc::new(Inline));
        Self { world, rest: run, is_live }
    }

    /// Advances by `steps` of `dt` [s].
    pub(super) fn advance(&mut self, dt: f32, steps: u64) -> Result<(), BuildError> {
        if !self.is_live {
            (0..steps).for_each(|_| self.world.step(dt));
            return Ok(());
        }
        core::mem::swap(&mut self.world, &mut self.rest.world);
        let done = (0..steps).try_for_each(|_| self.rest.step(dt));
        core::mem::swap(&mut self.world, &mut self.rest.world);
        done
    }

    /// The scene that runs, with its world.
    pub(super) fn running(&self) -> Running {
        let mut run = self.rest.clone();
        run.world = self.world.clone();
        run
    }

    /// Takes over the state of another run of the scene.
    pub(super) fn take(&mut self, run: &Running) {
        self.world.clone_from(&run.world);
        self.world.set_executor(Arc::new(Inline));
        let mut rest = run.clone();
        rest.world = World::default();
        self.rest = rest;
    }
}

impl Clone for Slot {
    fn clone(&self) -> Self {
        Self { world: self.world.clone(), rest: self.rest.clone(), is_live: self.is_live }
    }

    /// Reuses the memory of the world.
    fn clone_from(&mut self, from: &Self) {
        self.world.clone_from(&from.world);
        if from.is_live {
            self.rest = from.rest.clone();
        }
        self.is_live = from.is_live;
    }
}
