//! Executors that violate their contract, and user code that panics. No safe code can corrupt
//! memory, hang a step, change its result, or leave a world that cannot continue.

use std::any::Any;
use std::collections::BTreeSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Barrier, Mutex};
use std::time::Duration;

use drystone::joint::Ball;
use drystone::particle::ClothDef;
use drystone::threads::{Executor, Inline, Team};
use drystone::{BodyDef, JointDef, ShapeDef, Stage, Vec3, World};

const DT: f32 = 1.0 / 60.0;

type Task<'a> = &'a (dyn Fn(usize, usize) + Sync);

/// An executor with a custom way to run the chunks of a phase; counts the phases.
struct Liar<W, R> {
    workers: W,
    run: R,
    phase: AtomicUsize,
}

impl<W, R> std::fmt::Debug for Liar<W, R> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Liar")
    }
}

impl<W, R> Executor for Liar<W, R>
where
    W: Fn(usize) -> usize + Send + Sync,
    R: Fn(usize, usize, Task<'_>) + Send + Sync,
{
    fn workers(&self) -> usize {
        (self.workers)(self.phase.load(Ordering::Relaxed))
    }

    fn run(&self, chunks: usize, task: Task<'_>) {
        (self.run)(self.phase.fetch_add(1, Ordering::Relaxed), chunks, task);
    }

    /// Runs all phases in one call.
    fn run_in_series(
        &self,
        phases: usize,
        chunks: &dyn Fn(usize) -> usize,
        task: &(dyn Fn(usize, usize, usize) + Sync),
    ) {
        let counts: Vec<usize> = (0..phases).map(chunks).collect();
        std::thread::scope(|scope| {
            for (phase, n) in counts.into_iter().enumerate() {
                scope.spawn(move || (0..n).for_each(|chunk| task(phase % 4, phase, chunk)));
            }
        });
    }
}

/// An executor that reports a number of workers for each phase, and runs (phase, chunks, task) with
/// a function.
fn liar(
    workers: impl Fn(usize) -> usize + Send + Sync + 'static,
    run: impl Fn(usize, usize, Task<'_>) + Send + Sync + 'static,
) -> Arc<dyn Executor> {
    Arc::new(Liar { workers, run, phase: AtomicUsize::new(0) })
}

/// Runs every chunk on every one of some threads.
fn on_threads(threads: usize, chunks: usize, task: Task<'_>) {
    let go = Barrier::new(threads);
    std::thread::scope(|scope| {
        for worker in 0..threads {
            let go = &go;
            scope.spawn(move || {
                go.wait();
                (0..chunks).for_each(|chunk| task(worker % 4, chunk));
            });
        }
    });
}

fn in_order(chunks: usize, task: Task<'_>) {
    (0..chunks).for_each(|chunk| task(0, chunk));
}

/// Bodies that overlap slightly, so that most push each other from the first step; a rope of hinged
/// rods, and a cloth above.
fn pile() -> World {
    let mut world = World::default();
    world
        .add_body(BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0)))
        .unwrap();
    for i in 0..150_u8 {
        let [x, y, z] = [i % 6, i / 30, i / 6 % 5].map(|k| 0.95 * f32::from(k));
        let shape = if i % 2 == 0 { ShapeDef::box_half([0.5; 3]) } else { ShapeDef::sphere(0.5) };
        world
            .add_body(BodyDef::dynamic().with_position([x, y + 0.5, z]).with_shape(shape))
            .unwrap();
    }
    let mut last = None;
    for i in 0..8_u8 {
        let x = -2.0 - f32::from(i);
        let rod = BodyDef::dynamic()
            .with_position([x, 3.0, 0.0])
            .with_shape(ShapeDef::box_half([0.45, 0.1, 0.1]));
        let rod = world.add_body(rod).unwrap();
        if let Some(last) = last {
            world
                .add_joint(
                    JointDef::new(last, rod, Ball::new())
                        .with_anchors([-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]),
                )
                .unwrap();
        }
        last = Some(rod);
    }
    let cloth = ClothDef::new([0.0, 5.3, 0.0], [Vec3::X * 5.0, Vec3::Z * 4.0], [18, 16]);
    world.add_cloth(cloth).unwrap();
    world
}

/// Hashes after each of `steps` steps, by the calling thread alone.
fn hashes(steps: usize) -> Vec<u64> {
    let mut world = pile();
    (0..steps)
        .map(|_| {
            world.step(DT);
            world.state_hash()
        })
        .collect()
}

/// Checks that the world is intact: it steps, saves and loads, and continues like the restored one.
fn goes_on(world: &mut World) {
    world.set_executor(Arc::new(Inline));
    let mut other = World::restore(&world.snapshot()).unwrap();
    for _ in 0..5 {
        world.step(DT);
        other.step(DT);
        assert_eq!(world.state_hash(), other.state_hash());
    }
    drop(world.clone());
}

fn check(name: &str, executor: Arc<dyn Executor>, expected: &[u64]) {
    let mut world = pile().with_executor(executor);
    for (step, expected) in expected.iter().enumerate() {
        world.step(DT);
        assert_eq!(world.state_hash(), *expected, "{name}, step {step}");
    }
    goes_on(&mut world);
}

#[test]
fn an_executor_that_lies_changes_nothing() {
    let expected = hashes(6);
    let four = |_| 4;
    let all: [(&str, Arc<dyn Executor>); 18] = [
        ("chunks on four threads", liar(four, |_, n, task| on_threads(4, n, task))),
        ("more threads than workers", liar(|_| 2, |_, n, task| on_threads(7, n, task))),
        ("nothing", liar(four, |_, _, _| {})),
        ("half", liar(four, |_, n, task| in_order(n / 2, task))),
        ("all twice", liar(four, |_, n, task| (0..2).for_each(|_| in_order(n, task)))),
        (
            "each twice",
            liar(four, |_, n, task| {
                (0..n).for_each(|chunk| (0..2).for_each(|worker| task(worker, chunk)));
            }),
        ),
        ("backwards", liar(four, |_, n, task| (0..n).rev().for_each(|chunk| task(3, chunk)))),
        (
            "out of range",
            liar(four, |_, n, task| {
                in_order(n + 3, task);
                task(0, usize::MAX);
            }),
        ),
        (
            "workers out of range",
            liar(four, |_, n, task| {
                (0..n).for_each(|chunk| task(usize::MAX - chunk, chunk));
            }),
        ),
        ("no workers", liar(|_| 0, |_, n, task| in_order(n, task))),
        ("no workers, and nothing", liar(|_| 0, |_, _, _| {})),
        ("a million workers", liar(|_| 1_000_000, |_, n, task| in_order(n, task))),
        ("2^62 workers", liar(|_| 1 << 62, |_, n, task| in_order(n, task))),
        ("all workers there are", liar(|_| usize::MAX, |_, n, task| on_threads(2, n, task))),
        (
            "other workers each time",
            liar(|phase| [1, 7, 2, 16, 3, 0][phase % 6], |_, n, task| in_order(n, task)),
        ),
        (
            "one worker for two threads",
            liar(four, |_, n, task| {
                std::thread::scope(|scope| {
                    scope.spawn(|| (0..n).step_by(2).for_each(|chunk| task(0, chunk)));
                    (1..n).step_by(2).for_each(|chunk| task(0, chunk));
                });
            }),
        ),
        (
            "a chunk while it runs",
            liar(four, |_, n, task| {
                std::thread::scope(|scope| {
                    for chunk in 0..n {
                        scope.spawn(move || task(1, chunk));
                        task(1, chunk);
                    }
                });
            }),
        ),
        ("a team of its own", {
            let team = Team::with_threads(3);
            liar(move |_| team.workers(), {
                let team = Team::with_threads(4);
                move |_, n, task| team.run(n, task)
            })
        }),
    ];
    for (name, executor) in all {
        check(name, executor, &expected);
    }
}

/// A single phase in which two threads run each chunk at once was enough for a double free.
#[test]
fn a_phase_that_runs_twice_at_once_changes_nothing() {
    let expected = hashes(4);
    for first in (0..97).step_by(3) {
        let doubled = liar(
            |_| 4,
            move |phase, n, task| {
                if phase % 97 == first { on_threads(2, n, task) } else { in_order(n, task) }
            },
        );
        check(&format!("phase {first}"), doubled, &expected);
    }
}

fn message(payload: &(dyn Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| payload.downcast_ref().cloned()).unwrap()
}

#[test]
fn a_step_whose_executor_panics_is_done_to_its_end() {
    let expected = hashes(6);
    for first in [0, 1, 5, 20, 60, 100] {
        for threads in [1, 3] {
            let run = move |phase, n, task: Task<'_>| {
                if phase == first {
                    in_order(n / 2, task);
                    std::panic::panic_any("a user's code");
                }
                if threads == 1 { in_order(n, task) } else { on_threads(threads, n, task) }
            };
            let mut world = pile().with_executor(liar(|_| 4, run));
            let mut panics = 0;
            for expected in &expected {
                let outcome = catch_unwind(AssertUnwindSafe(|| world.step(DT)));
                if let Err(payload) = outcome {
                    assert_eq!(message(&*payload), "a user's code");
                    panics += 1;
                }
                assert_eq!(world.state_hash(), *expected);
            }
            assert_eq!(panics, 1);
            goes_on(&mut world);
        }
    }
}

#[test]
fn a_step_whose_observer_panics_is_done_to_its_end() {
    let expected = hashes(1 + Stage::ALL.len());
    for team in [1, 3] {
        let mut world = pile().with_executor(Arc::new(Team::with_threads(team)));
        for (stage, expected) in Stage::ALL.iter().copied().zip(&expected) {
            let mut seen = Vec::new();
            let outcome = catch_unwind(AssertUnwindSafe(|| {
                world.step_observed(DT, &mut |done| {
                    seen.push(done);
                    assert!(done != stage, "an observer");
                });
            }));
            assert_eq!(message(&*outcome.unwrap_err()), "an observer");
            assert_eq!(seen, Stage::ALL[..seen.len()]);
            assert_eq!((seen.last(), world.state_hash()), (Some(&stage), *expected));
        }
        world.step(DT);
        assert_eq!(Some(&world.state_hash()), expected.last());
        goes_on(&mut world);
    }
}

/// Number of workers that take part in a phase whose chunks wait for each other.
fn present(team: &Team) -> usize {
    let workers = team.workers();
    let (all_here, seen) = (Barrier::new(workers), Mutex::new(BTreeSet::new()));
    // No worker can get a second chunk before all have one.
    team.run(workers, &|worker, _| {
        all_here.wait();
        seen.lock().unwrap().insert(worker);
    });
    seen.into_inner().unwrap().len()
}

#[test]
fn a_team_works_on_with_all_its_workers_after_a_panic() {
    for in_series in [false, true] {
        for bad in [0, 1, 3] {
            let team = Team::with_threads(4);
            for _ in 0..20 {
                // The data that the task borrows is freed on return; a worker still running it
                // would read other numbers.
                let numbers = vec![7_usize; 100];
                let late = AtomicBool::new(false);
                let all_here = Barrier::new(4);
                let task = |worker: usize, chunk: usize| {
                    if chunk < 4 {
                        all_here.wait();
                    }
                    assert!(worker != bad, "worker {bad}");
                    std::thread::sleep(Duration::from_micros(200));
                    late.fetch_or(numbers.iter().any(|k| *k != 7), Ordering::Relaxed);
                };
                let payload = catch_unwind(AssertUnwindSafe(|| {
                    if in_series {
                        team.run_in_series(3, &|_| 4, &|w, phase, c| task(w, c + 4 * phase));
                    } else {
                        team.run(4, &task);
                    }
                }))
                .unwrap_err();
                assert_eq!(message(&*payload), format!("worker {bad}"));
                assert!(!late.load(Ordering::Relaxed));
            }
            assert_eq!((team.workers(), present(&team)), (4, 4));
        }
    }
}

#[test]
fn what_every_chunk_panics_with_comes_to_the_caller_once() {
    let team = Team::with_threads(3);
    for round in 0..50_usize {
        let outcome = catch_unwind(AssertUnwindSafe(|| {
            team.run(64, &|_, _| std::panic::panic_any(round));
        }));
        assert_eq!(outcome.unwrap_err().downcast_ref(), Some(&round));
    }
    // The executor's count of chunks is user code too.
    let outcome = catch_unwind(AssertUnwindSafe(|| {
        team.run_in_series(
            3,
            &|phase| if phase == 2 { std::panic::panic_any(1) } else { 9 },
            &|_, _, _| {},
        );
    }));
    assert!(outcome.is_err());
    assert_eq!(present(&team), 3);
}

#[test]
fn teams_within_teams_and_two_callers_work() {
    let team = Team::with_threads(3);
    let (count, panics) = (AtomicUsize::new(0), AtomicUsize::new(0));
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                for round in 0..100 {
                    team.run(8, &|_, _| {
                        team.run(8, &|_, _| {
                            count.fetch_add(1, Ordering::Relaxed);
                        });
                    });
                    let bad = catch_unwind(AssertUnwindSafe(|| {
                        team.run(8, &|_, chunk| assert!(chunk != round % 8, "round {round}"));
                    }));
                    let text = message(&*bad.unwrap_err());
                    panics.fetch_add(
                        usize::from(text == format!("round {round}")),
                        Ordering::Relaxed,
                    );
                }
            });
        }
    });
    assert_eq!((count.into_inner(), panics.into_inner()), (2 * 100 * 64, 200));
    assert_eq!(present(&team), 3);
}

#[test]
fn more_threads_than_cores_give_the_same_bits() {
    let expected = hashes(3);
    check("256 threads", Arc::new(Team::with_threads(256)), &expected);
}

#[test]
fn a_world_is_the_same_while_threads_of_the_program_join_and_leave() {
    let expected = hashes(20);
    let team = Arc::new(Team::hosted(4));
    let mut world = pile().with_executor(team.clone());
    for expected in expected.chunks(4) {
        let leave = AtomicBool::new(false);
        std::thread::scope(|scope| {
            // One thread more than there are seats.
            (0..4).for_each(|_| drop(scope.spawn(|| team.join(&leave))));
            for hash in expected {
                world.step(DT);
                assert_eq!(world.state_hash(), *hash);
            }
            team.release(&leave);
        });
    }
}

/// A forked process has one thread: its team's workers do not exist.
#[cfg(target_os = "linux")]
mod fork {
    #![expect(unsafe_code, reason = "a fork is a system call")]

    use super::{Arc, AtomicBool, DT, Duration, Team, World, hashes, pile};

    unsafe extern "C" {
        fn fork() -> i32;
        fn waitpid(process: i32, status: *mut i32, options: i32) -> i32;
        fn kill(process: i32, signal: i32) -> i32;
        fn _exit(status: i32) -> !;
    }

    /// Runs in the child: 0 if everything works.
    fn child(mut world: World, expected: u64) -> i32 {
        world.step(DT);
        let same = world.state_hash() == expected;
        // Drops the world, and its team with it.
        drop(world);
        i32::from(!same)
    }

    #[test]
    fn a_fork_works_alone_and_ends() {
        let expected = hashes(3);
        // Workers that spin for the next series, and workers that sleep; the same for threads that
        // joined.
        for (pause, is_hosted) in [(0, false), (20, false), (0, true), (20, true)] {
            let team = Arc::new(if is_hosted { Team::hosted(4) } else { Team::with_threads(4) });
            let leave = Arc::new(AtomicBool::new(false));
            let guests: Vec<_> = (0..if is_hosted { 2 } else { 0 })
                .map(|_| {
                    let (team, leave) = (Arc::clone(&team), Arc::clone(&leave));
                    std::thread::spawn(move || team.join(&leave))
                })
                .collect();
            let mut world = pile().with_executor(team.clone());
            world.step(DT);
            world.step(DT);
            std::thread::sleep(Duration::from_millis(pause));
            // SAFETY: the child only computes and allocates, which glibc supports, and leaves by
            // `_exit`.
            let process = unsafe { fork() };
            if process == 0 {
                let status = child(world, expected[2]);
                // SAFETY: ends this process; no buffer needs flushing.
                unsafe { _exit(status) };
            }
            let mut status = -1;
            for _ in 0..1000 {
                // SAFETY: `status` is valid; 1 is WNOHANG.
                if unsafe { waitpid(process, &raw mut status, 1) } != 0 {
                    break;
                }
                std::thread::sleep(Duration::from_millis(10));
            }
            if status == -1 {
                // SAFETY: kills a child that hangs; 9 is SIGKILL.
                unsafe { kill(process, 9) };
            }
            assert_eq!(status, 0, "exit status of the child, -1 if it hung");
            world.step(DT);
            assert_eq!(world.state_hash(), expected[2]);
            team.release(&leave);
            assert!(guests.into_iter().all(|guest| guest.join().unwrap()));
        }
    }
}
