//! A run: every step is timed, poses are copied after some steps, and judged after the last.

use std::ops::Range;
use std::time::Instant;

use drystone::BodyKind;
use drystone_scene::{Scene, SceneBody, SceneJoint, ScriptAction};

use crate::check::Checker;
use crate::engine::{BodyState, Engine, EngineError, hash_states};
use crate::own::Own;
use crate::row::{MsPerStep, Row};
use crate::scenes::times_first_step;
use crate::series::{Series, milliseconds};
use crate::standing::stands;

/// Number of times poses are copied, evenly over the run, including after the last step.
const SAMPLES: u64 = 8;

/// A run to be measured.
#[derive(Clone, Copy, Debug)]
pub struct Order<'a> {
    /// The scene's name as the user wrote it.
    pub spec: &'a str,
    /// The scene.
    pub scene: &'a Scene,
    /// Number of threads, including the caller.
    pub threads: usize,
    /// Number of steps; at least 2.
    pub steps: u64,
}

/// Numbers of the moving bodies that exist.
#[derive(Debug, Default)]
struct Movers {
    numbers: Vec<usize>,
    /// Number of bodies added so far, and number of those removed.
    bodies: usize,
    gone: usize,
}

/// The moving bodies after a step, and their states.
#[derive(Debug)]
struct Sample {
    numbers: Vec<usize>,
    states: Vec<BodyState>,
}

impl Movers {
    fn add(&mut self, body: &SceneBody) {
        if body.def.kind != BodyKind::Static {
            self.numbers.push(self.bodies);
        }
        self.bodies += 1;
    }

    fn remove(&mut self, leaving: &Range<usize>) {
        self.numbers.retain(|number| !leaving.contains(number));
        self.gone += leaving.len();
    }

    fn sample<E: Engine>(&self, engine: &E) -> Sample {
        let states = self.numbers.iter().map(|&number| engine.state(number)).collect();
        Sample { numbers: self.numbers.clone(), states }
    }
}

/// Runs the scene once with this engine.
///
/// # Errors
/// Fails if the engine cannot run the scene.
pub fn measure<E: Engine>(order: &Order<'_>) -> Result<Row, EngineError> {
    let scene = order.scene;
    let dt = scene.hz.recip();
    let breaks = scene.bodies.iter().any(|b| b.def.glue.is_some() || b.def.fracture.is_some());
    if breaks && E::NAME != Own::NAME {
        return Err(EngineError("bodies that break are not translated".to_owned()));
    }
    let mut engine = E::build(scene, order.threads)?;
    let mut movers = Movers::default();
    scene.bodies.iter().for_each(|body| movers.add(body));
    let mut added: Vec<&SceneBody> = Vec::new();
    let mut joined: Vec<&SceneJoint> = Vec::new();
    let mut samples: Vec<Sample> = Vec::new();
    let mut ms = Series::default();
    for step in 0..order.steps {
        match scene.script.action(step) {
            // A film needs no physics.
            ScriptAction::None | ScriptAction::Film(_) => {}
            ScriptAction::Aim { body, position } => engine.aim(body, position, dt)?,
            ScriptAction::Loads(loads) => loads.iter().try_for_each(|load| engine.pull(load))?,
            ScriptAction::Add(body) => {
                engine.add(body)?;
                movers.add(body);
                added.push(body);
            }
            ScriptAction::Wave(wave) => {
                engine.bring(wave)?;
                movers.remove(&wave.removed);
                for body in &wave.bodies {
                    movers.add(body);
                    added.push(body);
                }
                joined.extend(&wave.joints);
            }
        }
        let start = Instant::now();
        engine.step(dt);
        let spent = start.elapsed();
        if step > 0 || times_first_step(order.spec) {
            ms.push(milliseconds(spent));
        } else {
            engine.restart_clock();
        }
        if is_sample(step + 1, order.steps) {
            samples.push(movers.sample(&engine));
        }
    }

    let mut checker = Checker::new(scene)?;
    for body in added {
        checker.add(body)?;
    }
    joined.into_iter().for_each(|joint| checker.join(joint));
    for sample in &samples {
        checker.look(&sample.numbers, &sample.states);
    }
    let end = samples.last().map_or(&[][..], |sample| sample.states.as_slice());
    let bodies: Vec<&SceneBody> =
        movers.numbers.iter().filter_map(|&number| checker.body(number)).collect();
    Ok(Row {
        scene: order.spec.to_owned(),
        engine: E::NAME.to_owned(),
        version: E::version(),
        threads: order.threads,
        simd: engine.simd(),
        steps: order.steps,
        bodies: movers.bodies - movers.gone,
        ms_per_step: MsPerStep { min: ms.mean(), median: ms.mean(), p99: ms.percentile(99) },
        hash: format!("{:016x}", engine.hash().unwrap_or_else(|| hash_states(end))),
        max_penetration: checker.max_penetration(),
        stands: stands(order.spec, scene, &bodies, end),
        max_joint_error: checker.max_joint_error(),
        lost: end.iter().filter(|state| !state.is_finite()).count(),
        runs: 1,
        stages_ms: engine.stages_ms(ms.len()),
    })
}

/// Whether poses are copied after `done` of `steps` steps.
const fn is_sample(done: u64, steps: u64) -> bool {
    // The number of samples due increases at this step.
    done * SAMPLES / steps > (done - 1) * SAMPLES / steps
}

#[cfg(test)]
mod tests {
    use drystone_scene::named;

    use super::{Order, SAMPLES, is_sample, measure};
    use crate::own::Own;

    #[test]
    fn samples_are_spread_evenly_and_include_the_last_step() {
        for steps in [2, 7, 8, 100, 499, 500] {
            let at: Vec<u64> = (1..=steps).filter(|&done| is_sample(done, steps)).collect();
            assert_eq!(at.len() as u64, SAMPLES.min(steps), "{steps}");
            assert_eq!(at.last(), Some(&steps));
        }
    }

    #[test]
    fn a_row_tells_of_the_run_and_threads_do_not_change_it() {
        let scene = named("stack:n=3").unwrap();
        let run = |threads| {
            let order = Order { spec: "stack:n=3", scene: &scene, threads, steps: 30 };
            measure::<Own>(&order).unwrap()
        };
        let (one, two) = (run(1), run(2));
        assert_eq!((one.bodies, one.steps, one.stands), (4, 30, Some(true)));
        assert_eq!(one.hash, two.hash);
        // The hash equals that of `drystone simulate` for the world after 30 steps.
        let mut running = scene.build().unwrap();
        for _ in 0..30 {
            running.step(1.0 / 60.0).unwrap();
        }
        assert_eq!(one.hash, format!("{:016x}", running.world.state_hash()));
        assert!(one.stages_ms.is_some_and(|s| s.0.len() == drystone::Stage::ALL.len()));
        assert!(one.ms_per_step.min > 0.0 && one.ms_per_step.p99 >= one.ms_per_step.median);
    }

    #[test]
    fn scripts_run_as_in_the_scene() {
        for (spec, steps) in [("large_world:tiles=4", 12), ("junkyard", 3), ("rain:rows=1", 20)] {
            let scene = named(spec).unwrap();
            let order = Order { spec, scene: &scene, threads: 1, steps };
            let row = measure::<Own>(&order).unwrap();
            let mut running = scene.build().unwrap();
            for _ in 0..steps {
                running.step(1.0 / 60.0).unwrap();
            }
            assert_eq!(row.bodies, running.world.bodies().count(), "{spec}");
            assert_eq!(row.hash, format!("{:016x}", running.world.state_hash()), "{spec}");
        }
    }
}
