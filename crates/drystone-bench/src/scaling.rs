//! The speedup of threads. A world on one thread and its twin on several alternate step by step, so
//! that other load, the clock rate and shared caches affect both alike.

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

/// Interval, in steps, at which the loop without memory access is timed.
const EVERY: u64 = 4;

/// Number of chunks of that loop, and rounds per chunk: about 0.8 ms on one thread.
const CHUNKS: usize = 16;
const ROUNDS: u32 = 20_000;

/// The speedup of several threads in a scene.
#[derive(Clone, Debug)]
pub struct Scaling {
    /// The scene's name as the user wrote it.
    pub scene: String,
    /// Number of threads, including the caller.
    pub threads: usize,
    /// Mean time of a step on one thread, and on several [ms].
    pub ms_per_step: [f64; 2],
    /// Mean times of each stage on one thread, and on several.
    pub stages_ms: [Stages; 2],
    /// Speedup of a loop without memory access on these threads: the limit of the machine.
    pub machine: f64,
    /// Hash of the final state, which is the same for both.
    pub hash: u64,
}

impl Scaling {
    /// Speedup of a step over one thread.
    #[must_use]
    pub fn gain(&self) -> f64 {
        self.ms_per_step[0] / self.ms_per_step[1]
    }
}

/// Runs the scene on one thread and on the order's threads, alternating.
///
/// # Errors
/// Fails if the scene cannot be run, or the two final states differ.
pub fn scaling(order: &Order<'_>) -> Result<Scaling, EngineError> {
    let dt = order.scene.hz.recip();
    let mut twins = [Own::build(order.scene, 1)?, Own::build(order.scene, order.threads)?];
    let teams: [&dyn Executor; 2] = [&Inline, &Team::new(order.threads)];
    let mut ms = [Series::default(), Series::default()];
    let mut loops = [Series::default(), Series::default()];
    for step in 0..order.steps {
        // The twins take turns to go first, because the second finds the caches as the first left
        // them.
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

/// Duration of a loop that needs only registers.
fn without_memory(jobs: &dyn Executor) -> Duration {
    // Wakes sleeping workers before the clock starts.
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

/// Returns a line for each scene under a line of titles. A second line lists the speedup of each
/// stage that takes more than a hundredth of a step.
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
        // A scene with a script, which both twins follow.
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
