//! Measurements of a run. They are taken between steps, outside the timed part, and always in full:
//! a report does not depend on the other outputs.

use std::time::Duration;

use drystone::events::Fault;
use drystone::{Vec3, World};
use drystone_bench::{Series, count_as_f64, milliseconds};

use crate::output::one_line;

/// Steps between hashes that are kept.
const HASH_EVERY: u64 = 60;

/// Mechanical energy [J].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Energy {
    /// Energy of motion.
    pub(crate) kinetic: f64,
    /// In the field of gravity, against the world's origin.
    pub(crate) potential: f64,
}

impl Energy {
    fn of(world: &World) -> Self {
        Self { kinetic: world.kinetic_energy(), potential: world.potential_energy() }
    }

    /// Both together.
    pub(crate) fn total(self) -> f64 {
        self.kinetic + self.potential
    }
}

/// Measurements of a run.
#[derive(Debug)]
pub(crate) struct Measure {
    /// Time of each step [ms].
    pub(crate) step_ms: Series,
    /// Pairs of shapes with contact points after each step.
    pub(crate) contacts: Series,
    /// The most of them after a step.
    pub(crate) contacts_max: usize,
    /// Deepest overlap after each step [m].
    pub(crate) penetration: Series,
    /// Deepest overlap of a particle with a shape [m], after each step or every 60.
    pub(crate) particle_penetration: Series,
    /// Largest length error of a rod or thread after each step [m].
    pub(crate) link_error: Series,
    /// Links that tore.
    pub(crate) tears: usize,
    /// Largest joint error after each step [m].
    pub(crate) joint_error: Series,
    /// Energy at the start.
    pub(crate) energy_start: Energy,
    /// Energy after the last step.
    pub(crate) energy_end: Energy,
    /// Largest sum of kinetic and potential energy, the start included [J].
    pub(crate) energy_max: f64,
    momentum_start: Vec3,
    /// Step and state hash, every 60 steps.
    pub(crate) hashes: Vec<(u64, u64)>,
    /// Faults of the run.
    pub(crate) faults: Vec<Fault>,
}

impl Measure {
    /// Measurements of a run that starts from `world`.
    pub(crate) fn new(world: &World) -> Self {
        let energy = Energy::of(world);
        Self {
            step_ms: Series::default(),
            contacts: Series::default(),
            contacts_max: 0,
            penetration: Series::default(),
            particle_penetration: Series::default(),
            link_error: Series::default(),
            tears: 0,
            joint_error: Series::default(),
            energy_start: energy,
            energy_end: energy,
            energy_max: energy.total(),
            momentum_start: world.momentum(),
            hashes: Vec::new(),
            faults: Vec::new(),
        }
    }

    /// Adds the state after step `step`, which took `spent`.
    pub(crate) fn add(&mut self, step: u64, spent: Duration, world: &World) {
        self.step_ms.push(milliseconds(spent));
        let (mut touching, mut deepest) = (0_usize, 0.0_f32);
        for contact in world.contacts() {
            touching += 1;
            deepest = contact.points().fold(deepest, |d, p| d.max(-p.separation));
        }
        self.contacts.push(count_as_f64(touching));
        self.contacts_max = self.contacts_max.max(touching);
        // Measured in every step only if there are few particles: each needs a query of the trees.
        if counts_particles(world, step) {
            self.particle_penetration.push(f64::from(world.particle_penetration()));
        }
        let stretch = world.links().fold(0.0_f32, |e, link| e.max(link.error()));
        self.link_error.push(f64::from(stretch));
        self.tears += world.events().link_tear.len();
        self.penetration.push(f64::from(deepest));
        let error = world.joints().fold(0.0_f32, |e, joint| e.max(joint.error()));
        self.joint_error.push(f64::from(error));
        self.energy_end = Energy::of(world);
        self.energy_max = self.energy_max.max(self.energy_end.total());
        if step.is_multiple_of(HASH_EVERY) {
            self.hashes.push((step, world.state_hash()));
        }
        self.faults.extend_from_slice(&world.events().faults);
    }

    /// How much the sum of momentum has changed since the start [kg m/s]. Gravity and static bodies
    /// change it too; where there is neither it should stay 0.
    pub(crate) fn momentum_drift(&self, world: &World) -> f32 {
        (world.momentum() - self.momentum_start).length()
    }
}

/// Whether overlaps of particles are looked for after step `step`.
fn counts_particles(world: &World, step: u64) -> bool {
    let counts = world.counts();
    counts.particles > 0 && (counts.particles <= 2000 || step.is_multiple_of(HASH_EVERY))
}

/// Notes of a scene, each in one line.
pub(crate) fn lines_of(notes: &[String]) -> Vec<String> {
    notes.iter().map(|note| one_line(note)).collect()
}
