//! The hunt: small worlds from a grammar, checked against general laws of physics. `docs/hunt.md`
//! of the repository describes its use.
//!
//! A world is a [`Program`], as in the attack. Its guarantees (that it must come to rest, that a
//! stack stands) are derived from the program itself, never from the generator. A shrunk program
//! therefore has the guarantees of its new form.

mod assemblies;
mod draw;
mod energy;
mod events;
mod facts;
mod floors;
mod measures;
mod moment;
mod moving;
mod places;
mod rest;
mod scenes;
mod search;
mod source;
mod twins;
mod watch;

use self::draw::Draw;
use crate::op::Program;
use crate::unit::Unit;

pub use self::search::{findings_of, minimize};
pub use self::source::test;

/// Topic of a world of the hunt.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Scene {
    /// Bodies thrown over a floor.
    Throws,
    /// Bodies that spin on a floor.
    Spins,
    /// Bodies that fall.
    Drops,
    /// Bodies on top of each other.
    Stacks,
    /// A sliding body.
    Slides,
    /// A body that slides over bodies placed side by side.
    Rows,
    /// Undriven tables, vehicles and doors.
    Assemblies,
    /// Figures with limbs.
    Ragdolls,
    /// Joints with motors.
    Motors,
    /// Chains with a weight.
    Chains,
    /// Bodies that fall asleep before an event.
    Sleepers,
    /// Lifts, turntables, doors and belts.
    Carriers,
    /// Small fast bodies and their targets.
    Shots,
    /// Bodies that pass sensors.
    Gates,
    /// Bodies without gravity or floor.
    Drifts,
    /// Bodies made in the same place.
    Spawns,
}

impl Scene {
    /// All scenes.
    pub const ALL: [Self; 16] = [
        Self::Throws,
        Self::Spins,
        Self::Drops,
        Self::Stacks,
        Self::Slides,
        Self::Rows,
        Self::Assemblies,
        Self::Ragdolls,
        Self::Motors,
        Self::Chains,
        Self::Sleepers,
        Self::Carriers,
        Self::Shots,
        Self::Gates,
        Self::Drifts,
        Self::Spawns,
    ];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Throws => "throws",
            Self::Spins => "spins",
            Self::Drops => "drops",
            Self::Stacks => "stacks",
            Self::Slides => "slides",
            Self::Rows => "rows",
            Self::Assemblies => "assemblies",
            Self::Ragdolls => "ragdolls",
            Self::Motors => "motors",
            Self::Chains => "chains",
            Self::Sleepers => "sleepers",
            Self::Carriers => "carriers",
            Self::Shots => "shots",
            Self::Gates => "gates",
            Self::Drifts => "drifts",
            Self::Spawns => "spawns",
        }
    }
}

/// The world of a seed.
#[must_use]
pub fn program(scene: Scene, seed: u64) -> Program {
    let mut d = Draw::new(seed, scene);
    match scene {
        Scene::Throws => d.throws(),
        Scene::Spins => d.spins(),
        Scene::Drops => d.drops(),
        Scene::Stacks => d.stacks(),
        Scene::Slides => d.slides(),
        Scene::Rows => d.rows(),
        Scene::Assemblies => d.assemblies(),
        Scene::Ragdolls => d.ragdolls(),
        Scene::Motors => d.motors(),
        Scene::Chains => d.chains(),
        Scene::Sleepers => d.sleepers(),
        Scene::Carriers => d.carriers(),
        Scene::Shots => d.shots(),
        Scene::Gates => d.gates(),
        Scene::Drifts => d.drifts(),
        Scene::Spawns => d.spawns(),
    }
    d.finish()
}

/// Runs one world and its twins.
#[must_use]
pub fn run_unit(scene: Scene, seed: u64) -> Unit {
    let program = match crate::run::guarded(|| program(scene, seed)) {
        Ok(program) => program,
        Err(panic) => {
            let mut unit = Unit { tried: 1, ..Unit::default() };
            unit.findings.add(crate::finding::Kind::Panic, panic.place, panic.message, 0);
            return unit;
        }
    };
    let watched = watch::watch(&program, None);
    let mut unit = Unit {
        tried: 1,
        steps: watched.steps,
        refused: u64::from(watched.refused),
        is_cut: watched.is_cut,
        findings: watched.findings.clone(),
        ..Unit::default()
    };
    unit.steps += twins::compare(&program, &watched, &mut unit.findings);
    unit
}

/// Writes the motion of all bodies of a world and its findings; `say` receives one line at a time.
pub fn trace(scene: Scene, seed: u64, say: fn(&str)) {
    let program = program(scene, seed);
    say(&format!("{:?}", program.config.gravity));
    for op in &program.ops {
        say(&format!("{op:?}"));
    }
    let _ = watch::watch(&program, Some(say));
}

#[cfg(test)]
mod tests {
    use super::{Scene, program, run_unit};
    use crate::op::Op;

    #[test]
    fn a_seed_gives_the_same_world_each_time_and_nothing_of_it_is_refused() {
        for scene in Scene::ALL {
            for seed in 0..12 {
                let (a, b) = (program(scene, seed), program(scene, seed));
                assert_eq!(format!("{a:?}"), format!("{b:?}"));
                let bodies = a.ops.iter().filter(|op| matches!(op, Op::AddBody(_))).count();
                assert!((1..=24).contains(&bodies), "{} {seed}: {bodies} bodies", scene.name());
            }
            let unit = run_unit(scene, 3);
            assert_eq!(unit.refused, 0, "{}", scene.name());
        }
    }
}
