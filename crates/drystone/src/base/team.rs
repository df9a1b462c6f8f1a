//! Our own worker team: a fixed number of threads that claim chunks.
//!
//! A chunk is claimed from one word (epoch, chunks left), so a worker that sleeps or whose core is
//! taken by another program never holds up a phase: the caller finishes alone. Workers spin for some
//! microseconds between phases, then park.
#![expect(unsafe_code, reason = "the task's lifetime is erased while its phase runs")]

use core::cell::UnsafeCell;
use core::hint::spin_loop;
use core::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::{JoinHandle, yield_now};

use super::jobs::Executor;

type Task = dyn Fn(usize, usize) + Sync;

/// About 20 µs of `spin_loop` before a worker parks.
const SPINS: u32 = 2000;

struct Job {
    /// The task of the running phase; dangling between phases.
    task: *const Task,
    chunks: usize,
}

struct Shared {
    /// Epoch in the upper half, chunks not yet claimed in the lower.
    claim: AtomicU64,
    job: UnsafeCell<Job>,
    /// Chunks of this phase that have returned.
    done: AtomicUsize,
    parked: AtomicUsize,
    quit: AtomicBool,
    panicked: AtomicBool,
    lock: Mutex<()>,
    wake: Condvar,
}

// SAFETY: `job` is written by the caller between phases only (it holds `Team::busy`), and read by a
// worker only while it holds a claimed chunk, before which the phase cannot end.
unsafe impl Sync for Shared {}
// SAFETY: the raw task pointer is only followed during its phase, see `Sync`.
unsafe impl Send for Shared {}

/// Counts a chunk as done even if its task panics, so that the caller never waits for ever.
struct Done<'a>(&'a Shared);

impl Drop for Done<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.panicked.store(true, Ordering::Relaxed);
        }
        self.0.done.fetch_add(1, Ordering::Release);
    }
}

impl Shared {
    /// Claims and runs chunks until none is left.
    fn work(&self, worker: usize) {
        let mut seen = self.claim.load(Ordering::Acquire);
        while seen & 0xffff_ffff != 0 {
            match self.claim.compare_exchange_weak(
                seen,
                seen - 1,
                Ordering::AcqRel,
                Ordering::Acquire,
            ) {
                Ok(_) => {
                    let _done = Done(self);
                    // SAFETY: this worker holds a claimed chunk, so the job is that of this phase.
                    let job = unsafe { &*self.job.get() };
                    // SAFETY: the caller of `run` keeps the task alive until every chunk is done.
                    let task = unsafe { &*job.task };
                    let left = usize::try_from(seen & 0xffff_ffff).unwrap_or(1);
                    task(worker, job.chunks - left);
                    seen = self.claim.load(Ordering::Acquire);
                }
                Err(now) => seen = now,
            }
        }
    }

    fn has_work(&self) -> bool {
        self.claim.load(Ordering::SeqCst) & 0xffff_ffff != 0
    }

    fn serve(&self, worker: usize) {
        loop {
            let mut spins = 0;
            while !self.has_work() && spins < SPINS && !self.quit.load(Ordering::Relaxed) {
                spin_loop();
                spins += 1;
            }
            if self.quit.load(Ordering::SeqCst) {
                return;
            }
            if self.has_work() {
                self.work(worker);
                continue;
            }
            self.parked.fetch_add(1, Ordering::SeqCst);
            let mut guard = self.lock.lock().unwrap_or_else(PoisonError::into_inner);
            while !self.has_work() && !self.quit.load(Ordering::SeqCst) {
                guard = self.wake.wait(guard).unwrap_or_else(PoisonError::into_inner);
            }
            drop(guard);
            self.parked.fetch_sub(1, Ordering::SeqCst);
        }
    }

    fn wake_all(&self) {
        drop(self.lock.lock().unwrap_or_else(PoisonError::into_inner));
        self.wake.notify_all();
    }
}

/// A team of threads that lives as long as the value.
pub struct Team {
    shared: Arc<Shared>,
    threads: Vec<JoinHandle<()>>,
    /// Held during a phase. A second caller (another world on the same team) works alone.
    busy: Mutex<u32>,
}

impl core::fmt::Debug for Team {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Team").field("workers", &self.workers()).finish_non_exhaustive()
    }
}

impl Team {
    /// A team of `workers`, the caller included: `workers - 1` threads are started, fewer if the
    /// system refuses. 0 counts as 1, more than the machine can run at once as that: threads beyond
    /// only take the cores from those that hold a chunk.
    #[must_use]
    pub fn new(workers: usize) -> Self {
        let cores = std::thread::available_parallelism().map_or(workers, usize::from);
        Self::with_threads(workers.min(cores))
    }

    /// As [`Self::new`], but also with more workers than the machine has cores, up to 256: for tests
    /// that want every interleaving.
    #[must_use]
    pub fn with_threads(workers: usize) -> Self {
        let nothing: &'static Task = &|_, _| {};
        let shared = Arc::new(Shared {
            claim: AtomicU64::new(0),
            job: UnsafeCell::new(Job { task: nothing, chunks: 0 }),
            done: AtomicUsize::new(0),
            parked: AtomicUsize::new(0),
            quit: AtomicBool::new(false),
            panicked: AtomicBool::new(false),
            lock: Mutex::new(()),
            wake: Condvar::new(),
        });
        let threads = (1..workers.clamp(1, 256))
            .filter_map(|worker| {
                let shared = Arc::clone(&shared);
                std::thread::Builder::new()
                    .name(format!("drystone-{worker}"))
                    .spawn(move || shared.serve(worker))
                    .ok()
            })
            .collect();
        Self { shared, threads, busy: Mutex::new(0) }
    }
}

impl Executor for Team {
    fn workers(&self) -> usize {
        self.threads.len() + 1
    }

    fn run(&self, chunks: usize, task: &(dyn Fn(usize, usize) + Sync)) {
        let alone = chunks <= 1 || self.threads.is_empty() || u32::try_from(chunks).is_err();
        let guard = if alone { None } else { self.busy.try_lock().ok() };
        let Some(mut epoch) = guard else {
            for chunk in 0..chunks {
                task(0, chunk);
            }
            return;
        };
        let shared = &*self.shared;
        // SAFETY: only the lifetime changes; `run` returns after the last use of the pointer.
        let erased =
            unsafe { core::mem::transmute::<&(dyn Fn(usize, usize) + Sync), &'static Task>(task) };
        // SAFETY: no chunk is claimed between phases, so nobody reads the job now.
        let job = unsafe { &mut *shared.job.get() };
        *job = Job { task: erased, chunks };
        shared.done.store(0, Ordering::Relaxed);
        *epoch = epoch.wrapping_add(1);
        shared.claim.store((u64::from(*epoch) << 32) | chunks as u64, Ordering::SeqCst);
        if shared.parked.load(Ordering::SeqCst) > 0 {
            shared.wake_all();
        }
        shared.work(0);
        let mut spins = 0_u32;
        while shared.done.load(Ordering::Acquire) < chunks {
            spins += 1;
            // A claimed chunk may wait for this very core: let the others run.
            if spins > 500 { yield_now() } else { spin_loop() }
        }
        assert!(!shared.panicked.load(Ordering::Relaxed), "a worker's task panicked");
    }
}

impl Drop for Team {
    fn drop(&mut self) {
        self.shared.quit.store(true, Ordering::SeqCst);
        self.shared.wake_all();
        for thread in self.threads.drain(..) {
            // A worker that panicked was reported by `run` already.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Executor, Team};
    use core::sync::atomic::{AtomicU32, Ordering};

    #[test]
    fn every_chunk_runs_exactly_once_for_any_number_of_workers() {
        for workers in [1, 2, 3, 8] {
            let team = Team::with_threads(workers);
            for round in 0..300 {
                let chunks = 1 + round % 37;
                let counts: Vec<AtomicU32> = (0..chunks).map(|_| AtomicU32::new(0)).collect();
                team.run(chunks, &|worker, chunk| {
                    assert!(worker < team.workers());
                    counts[chunk].fetch_add(1, Ordering::Relaxed);
                });
                assert!(counts.iter().all(|c| c.load(Ordering::Relaxed) == 1));
            }
        }
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
}
