//! drystone itself.

use std::sync::Arc;
use std::time::{Duration, Instant};

use drystone::threads::{Inline, Team};
use drystone::{Pose, Quat, Vec3};
use drystone_scene::{Load, Running, Scene, SceneBody, Wave};

use crate::engine::{BodyState, Engine, EngineError};
use crate::row::Stages;
use crate::series::StageClock;

/// drystone, with the method and settings of the scene and the machine's best SIMD level.
#[derive(Debug)]
pub struct Own {
    running: Running,
    clock: StageClock,
}

impl Own {
    /// Runs the script's actions and a step; returns the duration of the step alone.
    pub(crate) fn run(&mut self, dt: f32) -> Result<Duration, EngineError> {
        self.running.before_step(dt)?;
        let start = Instant::now();
        self.step(dt);
        Ok(start.elapsed())
    }
}

impl From<drystone_scene::BuildError> for EngineError {
    fn from(e: drystone_scene::BuildError) -> Self {
        Self(e.to_string())
    }
}

impl Engine for Own {
    const NAME: &'static str = "self";

    fn version() -> String {
        env!("CARGO_PKG_VERSION").to_owned()
    }

    fn build(scene: &Scene, threads: usize) -> Result<Self, EngineError> {
        let mut running = scene.build()?;
        if threads > 1 {
            running.world.set_executor(Arc::new(Team::new(threads)));
        } else {
            running.world.set_executor(Arc::new(Inline));
        }
        Ok(Self { running, clock: StageClock::new() })
    }

    fn add(&mut self, body: &SceneBody) -> Result<(), EngineError> {
        Ok(self.running.add(&body.name, body.def.clone())?)
    }

    fn bring(&mut self, wave: &Wave) -> Result<(), EngineError> {
        Ok(self.running.bring(wave)?)
    }

    fn aim(&mut self, body: usize, position: Vec3, dt: f32) -> Result<(), EngineError> {
        let id = self.running.brought().get(body).copied();
        if let Some(mut mover) = id.and_then(|id| self.running.world.body_mut(id)) {
            let pose = Pose::new(position, mover.get().rotation());
            mover.move_to(pose, dt);
        }
        Ok(())
    }

    fn pull(&mut self, load: &Load) -> Result<(), EngineError> {
        let id = self.running.brought().get(load.body).copied();
        let Some(mut body) = id.and_then(|id| self.running.world.body_mut(id)) else {
            return Ok(());
        };
        body.set_lasting_force(load.force);
        body.set_lasting_torque(load.torque);
        Ok(())
    }

    fn push(&mut self, body: usize, force: Vec3, _: f32) -> Result<(), EngineError> {
        let id = self.running.brought().get(body).copied();
        if let Some(mut body) = id.and_then(|id| self.running.world.body_mut(id)) {
            body.add_step_force(force);
        }
        Ok(())
    }

    fn contact_force(&self, body: usize, dt: f32) -> Option<Vec3> {
        let id = *self.running.brought().get(body)?;
        let config = self.running.world.config();
        let substeps = if config.substeps > 0 { config.substeps } else { config.method.substeps() };
        let mut impulse = Vec3::ZERO;
        for contact in self.running.world.contacts() {
            let side = match id {
                _ if contact.body_a() == id => -1.0,
                _ if contact.body_b() == id => 1.0,
                _ => continue,
            };
            let sum: f32 = contact.points().map(|p| p.impulse).sum();
            impulse += contact.normal() * (side * sum);
        }
        // The number of substeps is small, so its f32 is exact.
        Some(impulse * (substeps as f32 / dt))
    }

    fn step(&mut self, dt: f32) {
        let clock = &mut self.clock;
        clock.begin();
        self.running.world.step_observed(dt, &mut |stage| clock.stage(stage.name()));
    }

    fn state(&self, body: usize) -> BodyState {
        let body = self.running.brought().get(body).and_then(|id| self.running.world.body(*id));
        body.map_or_else(nowhere, |b| BodyState {
            pose: b.pose(),
            linear_velocity: b.linear_velocity(),
            angular_velocity: b.angular_velocity(),
        })
    }

    fn simd(&self) -> String {
        self.running.world.simd_level().name().to_owned()
    }

    fn hash(&self) -> Option<u64> {
        Some(self.running.world.state_hash())
    }

    fn restart_clock(&mut self) {
        self.clock = StageClock::new();
    }

    fn stages_ms(&self, steps: u64) -> Option<Stages> {
        Some(self.clock.stages(steps))
    }
}

/// The state of a body that does not exist.
fn nowhere() -> BodyState {
    BodyState {
        pose: Pose { position: Vec3::splat(f32::NAN), rotation: Quat::IDENTITY },
        linear_velocity: Vec3::ZERO,
        angular_velocity: Vec3::ZERO,
    }
}
