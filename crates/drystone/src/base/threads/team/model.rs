//! The team under a model checker, which chooses the next thread after each operation on an atomic
//! or a lock (`cargo xtask model`). The counters of the tasks are plain atomics outside its
//! control.

use core::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

use super::{Executor, Team};
use crate::base::threads::sync;
use crate::base::threads::sync::Arc;

/// Number of schedules of each kind.
const SCHEDULES: usize = 2000;

/// Explores random schedules, and schedules with few switches at random points, which find other
/// errors.
fn explore(run: impl Fn() + Copy + Send + Sync + 'static) {
    shuttle::check_random(run, SCHEDULES);
    shuttle::check_pct(run, SCHEDULES, 3);
}

fn counts(n: usize) -> Vec<AtomicUsize> {
    (0..n).map(|_| AtomicUsize::new(0)).collect()
}

fn all(counts: &[AtomicUsize], expected: usize) -> bool {
    counts.iter().all(|count| count.load(Ordering::SeqCst) == expected)
}

/// Runs a series of phases with these chunks. Each chunk runs once, and after those of the previous
/// phase.
fn run_once(team: &Team, chunks: &[usize]) {
    let done: Vec<_> = chunks.iter().map(|n| counts(*n)).collect();
    let over = AtomicBool::new(false);
    team.run_in_series(chunks.len(), &|phase| chunks[phase], &|_, phase, chunk| {
        assert!(!over.load(Ordering::SeqCst), "a task after its series");
        assert!(phase == 0 || all(&done[phase - 1], 1), "a phase before its time");
        done[phase][chunk].fetch_add(1, Ordering::SeqCst);
    });
    over.store(true, Ordering::SeqCst);
    assert!(done.iter().all(|phase| all(phase, 1)), "a chunk ran never or twice");
}

#[test]
fn chunks_run_once_and_phases_in_order() {
    explore(|| {
        let team = Team::with_threads(3);
        run_once(&team, &[3, 0, 2]);
        run_once(&team, &[2]);
    });
}

#[test]
fn a_panic_leaves_no_task_behind_and_a_team_that_works() {
    explore(|| {
        let team = Team::with_threads(2);
        for bad in [0, 2] {
            let (over, ran) = (AtomicBool::new(false), counts(3));
            let outcome = catch_unwind(AssertUnwindSafe(|| {
                team.run_in_series(2, &|_| 3, &|_, phase, chunk| {
                    assert!(!over.load(Ordering::SeqCst), "a task after its series");
                    assert!(phase == 0, "a phase after a panic");
                    ran[chunk].fetch_add(1, Ordering::SeqCst);
                    if chunk == bad {
                        resume_unwind(Box::new(bad));
                    }
                });
            }));
            over.store(true, Ordering::SeqCst);
            assert_eq!(outcome.unwrap_err().downcast_ref(), Some(&bad));
            assert!(ran.iter().all(|n| n.load(Ordering::SeqCst) <= 1));
        }
        run_once(&team, &[2, 2]);
    });
}

#[test]
fn two_callers_are_both_served() {
    explore(|| {
        let team = Arc::new(Team::with_threads(2));
        let other = Arc::clone(&team);
        let thread = shuttle::thread::spawn(move || run_once(&other, &[2, 2]));
        run_once(&team, &[3]);
        thread.join().unwrap();
        run_once(&team, &[2]);
    });
}

#[test]
fn a_task_may_use_the_team_that_runs_it() {
    explore(|| {
        let team = Team::with_threads(2);
        let ran = counts(2);
        team.run(2, &|_, chunk| {
            run_once(&team, &[2]);
            ran[chunk].fetch_add(1, Ordering::SeqCst);
        });
        assert!(all(&ran, 1));
    });
}

/// Covers workers that poll, that fall asleep, that sleep, and that still leave the last series.
#[test]
fn a_team_ends_whatever_its_workers_do() {
    explore(|| drop(Team::with_threads(3)));
    explore(|| {
        let team = Team::with_threads(2);
        run_once(&team, &[2]);
        drop(team);
    });
    explore(|| {
        let team = Team::with_threads(2);
        run_once(&team, &[2]);
        (0..8).for_each(|_| shuttle::thread::yield_now());
        run_once(&team, &[1, 2]);
    });
}

/// Threads of the program take their seats before, during and after its work, and leave in any
/// state.
#[test]
fn those_who_join_help_and_leave() {
    explore(|| {
        let team = Arc::new(Team::hosted(3));
        let leave = Arc::new(sync::AtomicBool::new(false));
        let threads: Vec<_> = (0..2)
            .map(|_| {
                let (team, leave) = (Arc::clone(&team), Arc::clone(&leave));
                shuttle::thread::spawn(move || assert!(team.join(&leave)))
            })
            .collect();
        run_once(&team, &[3, 0, 2]);
        run_once(&team, &[2]);
        team.release(&leave);
        run_once(&team, &[2]);
        threads.into_iter().for_each(|thread| thread.join().unwrap());
        run_once(&team, &[1, 2]);
    });
}

/// One seat for two threads: one of them gets it, or both one after the other.
#[test]
fn a_seat_is_taken_by_one() {
    explore(|| {
        let team = Arc::new(Team::hosted(2));
        let leave = Arc::new(sync::AtomicBool::new(false));
        let spawn = || {
            let (team, leave) = (Arc::clone(&team), Arc::clone(&leave));
            shuttle::thread::spawn(move || team.join(&leave))
        };
        let threads = [spawn(), spawn()];
        let busy = counts(2);
        team.run(3, &|worker, _| {
            assert_eq!(busy[worker].fetch_add(1, Ordering::SeqCst), 0, "two are one worker");
            busy[worker].fetch_sub(1, Ordering::SeqCst);
        });
        team.release(&leave);
        let joined = threads.map(|thread| thread.join().unwrap());
        assert!(joined.contains(&true));
    });
}
