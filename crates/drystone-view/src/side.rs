//! One of the runs that are shown: its past, the numbers of its steps, and where bodies are between
//! two of them.

use drystone::contact::ContactRef;
use drystone::{BodyId, Pose, Quat, Stage, WorldCounts};

use drystone_render::Gatherer;
use web_time::Instant;

use crate::history::History;

/// Numbers of a step, for plots.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Time that each of the engine's stages took, in their order [ms].
    pub stages: [f32; Stage::ALL.len()],
    /// Kinetic and potential energy [J].
    pub energy: f64,
    /// Deepest overlap of two bodies [m]; in large worlds that of a few steps ago.
    pub overlap: f32,
}

impl Sample {
    /// Time that the step took [ms].
    #[must_use]
    pub fn step_ms(&self) -> f32 {
        self.stages.iter().sum()
    }
}

/// A run that is shown.
#[derive(Debug)]
pub(crate) struct Side {
    pub(crate) history: History,
    pub(crate) samples: Vec<Sample>,
    /// Poses of bodies before the last step, by their slots; empty if no picture between steps
    /// needs them.
    pub(crate) before: Vec<Option<(BodyId, Pose)>>,
    /// Counted now and then: it takes a look at every contact.
    pub(crate) counts: WorldCounts,
    /// Deepest overlap at the last look [m].
    pub(crate) overlap: f32,
    pub(crate) gatherer: Gatherer,
}

impl Side {
    pub(crate) fn new(history: History) -> Self {
        let counts = history.now().world.counts();
        let (samples, before, gatherer) = (Vec::new(), Vec::new(), Gatherer::default());
        Self { history, samples, before, counts, overlap: 0.0, gatherer }
    }

    /// Whether a look at every contact is due: after each step of a small world, now and then in a
    /// large one.
    pub(crate) const fn is_time_to_look(&self) -> bool {
        self.counts.pairs < 4096 || self.history.step_count().is_multiple_of(8)
    }

    /// A step; `between` says whether there will be pictures between the last two.
    pub(crate) fn step(&mut self, between: bool) -> Result<(), drystone_scene::BuildError> {
        self.before.clear();
        if between {
            for body in self.history.now().world.bodies() {
                let slot = body.id().index() as usize;
                if slot >= self.before.len() {
                    self.before.resize(slot + 1, None);
                }
                self.before[slot] = Some((body.id(), body.pose()));
            }
        }
        let mut stages = [0.0; Stage::ALL.len()];
        let mut last = Instant::now();
        self.history.step(&mut |stage| {
            let now = Instant::now();
            if let Some(number) = Stage::ALL.iter().position(|s| *s == stage) {
                stages[number] = (now - last).as_secs_f32() * 1.0e3;
            }
            last = now;
        })?;
        let world = &self.history.now().world;
        let depth = |c: ContactRef<'_>| c.points().map(|p| -p.separation).fold(0.0, f32::max);
        if self.is_time_to_look() {
            self.overlap = world.contacts().map(depth).fold(0.0, f32::max);
        }
        let overlap = self.overlap;
        let energy = world.kinetic_energy() + world.potential_energy();
        self.samples.push(Sample { stages, energy, overlap });
        Ok(())
    }

    /// Where bodies are at `part` of the last step, by their slots.
    pub(crate) fn poses(&self, part: f32) -> Vec<Pose> {
        let mut poses = Vec::new();
        for body in self.history.now().world.bodies() {
            let (slot, now) = (body.id().index() as usize, body.pose());
            if slot >= poses.len() {
                poses.resize(slot + 1, Pose::IDENTITY);
            }
            poses[slot] = match self.before.get(slot) {
                Some(Some((id, before))) if *id == body.id() => mix(before, &now, part),
                _ => now,
            };
        }
        poses
    }
}

/// The pose at a part of the short way from one to another.
pub(crate) fn mix(from: &Pose, to: &Pose, part: f32) -> Pose {
    let (a, b) = (from.rotation.to_array(), to.rotation.to_array());
    let dot: f32 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
    let sign = if dot < 0.0 { -1.0 } else { 1.0 };
    let [x, y, z, w] = std::array::from_fn(|i| a[i] * (1.0 - part) + b[i] * (sign * part));
    Pose::new(from.position.lerp(to.position, part), Quat::new(x, y, z, w).normalized())
}
