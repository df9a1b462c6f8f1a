//! The team on system threads: every chunk once, phases in order, with any helpers.

use super::{Executor, Team};
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

#[test]
fn every_chunk_runs_exactly_once_for_any_number_of_workers() {
    for workers in [1, 2, 3, 8] {
        let team = Team::with_threads(workers);
        for round in 0..300 {
            let chunks = 1 + round % 37;
            let counts: Vec<AtomicU32> = (0..chunks).map(|_| AtomicU32::new(0)).collect();
            let task = |worker, chunk: usize| {
                assert!(worker < team.workers());
                counts[chunk].fetch_add(1, Ordering::Relaxed);
            };
            if round % 2 == 0 {
                team.run(chunks, &task);
            } else {
                team.run_in_series(1, &|_| chunks, &|worker, _, chunk| task(worker, chunk));
            }
            assert!(counts.iter().all(|c| c.load(Ordering::Relaxed) == 1));
        }
    }
}

#[test]
fn threads_of_the_program_come_and_go_while_it_works() {
    let team = Team::hosted(4);
    assert_eq!(team.workers(), 4);
    let over = AtomicBool::new(true);
    assert!(team.join(&over), "who is told to leave returns at once");
    let busy: Vec<AtomicU32> = (0..4).map(|_| AtomicU32::new(0)).collect();
    let run = |chunks: usize| {
        let counts: Vec<AtomicU32> = (0..chunks).map(|_| AtomicU32::new(0)).collect();
        team.run_in_series(2, &|_| chunks, &|worker, _, chunk| {
            assert_eq!(busy[worker].fetch_add(1, Ordering::SeqCst), 0, "two are one worker");
            counts[chunk].fetch_add(1, Ordering::Relaxed);
            busy[worker].fetch_sub(1, Ordering::SeqCst);
        });
        assert!(counts.iter().all(|c| c.load(Ordering::Relaxed) == 2));
    };
    run(9);
    for round in 0..20 {
        let leave = AtomicBool::new(false);
        std::thread::scope(|scope| {
            let threads: Vec<_> = (0..5).map(|_| scope.spawn(|| team.join(&leave))).collect();
            (0..30).for_each(|k| run(1 + (k + round) % 13));
            team.release(&leave);
            run(5);
            let joined = threads.into_iter().map(|t| t.join().unwrap());
            assert!(joined.filter(|joined| *joined).count() >= 3);
        });
    }
}

#[test]
fn a_team_with_threads_has_no_seat_for_others() {
    let leave = AtomicBool::new(false);
    assert!(!Team::with_threads(3).join(&leave) && !Team::hosted(1).join(&leave));
}

#[test]
fn more_chunks_than_a_word_counts_run_exactly_once() {
    let team = Team::with_threads(3);
    let counts: Vec<AtomicU32> = (0..70_001).map(|_| AtomicU32::new(0)).collect();
    for round in 1..=2 {
        let task = |_, chunk: usize| {
            counts[chunk].fetch_add(1, Ordering::Relaxed);
        };
        if round == 1 {
            team.run(counts.len(), &task);
        } else {
            team.run_in_series(1, &|_| counts.len(), &|worker, _, chunk| task(worker, chunk));
        }
        assert!(counts.iter().all(|c| c.load(Ordering::Relaxed) == round));
    }
}

#[test]
fn a_phase_of_a_series_begins_when_the_one_before_has_ended() {
    for workers in [2, 3, 8] {
        let team = Team::with_threads(workers);
        for round in 0..50 {
            // More phases than a series has, some without chunks, some with one.
            let chunks = |phase: usize| (phase * 7 + round) % 11;
            let phases = 45 + round % 40;
            let done: Vec<AtomicU32> = (0..phases).map(|_| AtomicU32::new(0)).collect();
            team.run_in_series(phases, &chunks, &|worker, phase, chunk| {
                assert!(worker < workers && chunk < chunks(phase));
                let before = phase.checked_sub(1);
                let ended = before.is_none_or(|k| is_all(&done[k], chunks(k)));
                assert!(ended, "phase {phase} of {phases}");
                done[phase].fetch_add(1, Ordering::Relaxed);
            });
            assert!((0..phases).all(|k| is_all(&done[k], chunks(k))));
        }
    }
}

fn is_all(count: &AtomicU32, chunks: usize) -> bool {
    count.load(Ordering::Relaxed) as usize == chunks
}

#[test]
fn a_team_used_by_two_callers_at_once_serves_both() {
    let team = Team::with_threads(3);
    let total = AtomicU32::new(0);
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                for _ in 0..500 {
                    team.run(7, &|_, _| {
                        total.fetch_add(1, Ordering::Relaxed);
                    });
                }
            });
        }
    });
    assert_eq!(total.load(Ordering::Relaxed), 7000);
}
