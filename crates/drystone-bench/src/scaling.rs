//! What threads gain: a world on one thread and its twin on several, step by step in turn. Whatever else the machine
//! does, and however its clock and its caches are shared, both meet the same of it.

use std::fmt::Write as _;
use std::hint::black_box;
use std::time::{Duration, Instant};

use drystone::threads::{Executor, Inline, Team};

use crate::engine::{Engine, EngineError};
use crate::listing::columns;
use crate::own::Own;
use crate::row::Stages;
use crate::run::Order;
use crate::scenes::times_first_step;
use crate::series::{Series, milliseconds};

/// The loop without memory is timed in every so many steps.
const EVERY: u64 = 4;

/// Its chunks, and the rounds of each: about 0.8 ms on one thread.
const CHUNKS: usize = 16;
const ROUNDS: u32 = 20_000;

/// What several threads gained in a scene.
#[derive(Clone, Debug)]
pub struct Scaling {
    /// What the user calls the scene.
    pub scene: String,
    /// Threads, the caller included.
    pub threads: usize,
    /// Mean time of a step on one thread, and on these [ms].
    pub ms_per_step: [f64; 2],
    /// The same of each stage.
    pub stages_ms: [Stages; 2],
    /// How many times as fast a loop that touches no memory is on these threads: what the machine has to give.
    pub machine: f64,
    /// That of the state at the end, the same of both.
    pub hash: u64,
}

impl Scaling {
    /// How many times as fast a step is as on one thread.
    #[must_use]
    pub fn gain(&self) -> f64 {
        self.ms_per_step[0] / self.ms_per_step[1]
    }
}

/// Runs the scene on one thread and on those of the order, in turn.
///
/// # Errors
/// The scene cannot be run, or the two do not end in the same state.
pub fn scaling(order: &Order<'_>) -> Result<Scaling, EngineError> {
    let dt = order.scene.hz.recip();
    let mut twins = [Own::build(order.scene, 1)?, Own::build(order.scene, order.threads)?];
    let teams: [&dyn Executor; 2] = [&Inline, &Team::new(order.threads)];
    let mut ms = [Series::default(), Series::default()];
    let mut loops = [Series::default(), Series::default()];
    for step in 0..order.steps {
        // Who goes first finds the caches as the other left them.
        let turns = if step % 2 == 0 { [0, 1] } else { [1, 0] };
        for i in turns {
            let spent = twins[i].run(dt)?;
            if step > 0 || times_first_step(order.spec) {
                ms[i].push(milliseconds(spent));
            } else {
                twins[i].restart_clock();
            }
            if step % EVERY == 0 {
                loops[i].push(milliseconds(without_memory(teams[i])));
            }
        }
    }
    let [one, many] = twins.each_ref().map(Engine::hash);
    let Some(hash) = one.filter(|_| one == many) else {
        return Err(EngineError(format!(
            "runs on 1 and {} threads ended in different states",
            order.threads
        )));
    };
    let stages = |i: usize| twins[i].stages_ms(ms[i].len()).unwrap_or_default();
    Ok(Scaling {
        scene: order.spec.to_owned(),
        threads: order.threads,
        ms_per_step: ms.each_ref().map(Series::mean),
        stages_ms: [stages(0), stages(1)],
        machine: loops[0].sum() / loops[1].sum(),
        hash,
    })
}

/// How long a loop takes that has all it needs in registers.
fn without_memory(jobs: &dyn Executor) -> Duration {
    // Who sleeps wakes before the clock runs.
    jobs.run(CHUNKS, &|_, _| turn(ROUNDS / 20));
    let start = Instant::now();
    jobs.run(CHUNKS, &|_, _| turn(ROUNDS));
    start.elapsed()
}

fn turn(rounds: u32) {
    let mut numbers = black_box([2.0_f32; 8]);
    let factor = black_box(0.999_f32);
    for _ in 0..rounds {
        for x in &mut numbers {
            *x = *x * factor + 0.001;
        }
    }
    black_box(numbers);
}

/// A line for each under a line of titles; what each stage of more than a hundredth of a step gained in a line below.
#[must_use]
pub fn scaling_listing(all: &[Scaling]) -> String {
    let titles =
        ["scene", "threads", "ms, 1 thread", "ms", "times faster", "a loop without memory", "hash"];
    let cells = |s: &Scaling| {
        let [one, many] = s.ms_per_step;
        [
            s.scene.clone(),
            s.threads.to_string(),
            format!("{one:.4}"),
            format!("{many:.4}"),
            format!("{:.2}", s.gain()),
            format!("{:.2}", s.machine),
            format!("{:016x}", s.hash),
        ]
    };
    let (lines, indent) = columns(1, titles, all.iter().map(cells));
    let mut text = format!("{}\n", lines[0]);
    for (line, s) in lines[1..].iter().zip(all) {
        let [a, b] = &s.stages_ms;
        let stages: Vec<String> =
            a.0.iter()
                .zip(&b.0)
                .filter(|((_, a), _)| *a > 0.01 * s.ms_per_step[0])
                .map(|((name, a), (_, b))| format!("{name} {:.2}", a / b))
                .collect();
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{line}\n{:>indent$}  {}", "", stages.join(", "));
    }
    text
}

#[cfg(test)]
mod tests {
    use drystone_scene::named;

    use super::{scaling, scaling_listing};
    use crate::run::Order;

    #[test]
    fn twins_are_measured_in_turn_and_end_as_one() {
        // A scene with a script: both follow it.
        let scene = named("large_world:tiles=4").unwrap();
        let order = Order { spec: "large_world:tiles=4", scene: &scene, threads: 2, steps: 12 };
        let found = scaling(&order).unwrap();
        let mut running = scene.build().unwrap();
        for _ in 0..12 {
            running.step(1.0 / 60.0).unwrap();
        }
        assert_eq!(found.hash, running.world.state_hash());
        assert!(found.gain() > 0.0 && found.machine > 0.0 && found.machine < 3.0, "{found:?}");
        let text = scaling_listing(&[found]);
        assert!(text.starts_with("scene ") && text.contains("large_world:tiles=4"), "{text}");
    }
}
