//! Our own worker team: a fixed number of threads that claim chunks.
//!
//! Chunks are claimed one by one from the front of a list, so a worker that sleeps or whose core is taken by another program never
//! holds up a phase: the caller finishes alone. Or each worker has a list of its own, always the same part of the chunks, and who
//! is done helps the others from the back. Workers spin for some microseconds between phases, then park.
#![expect(unsafe_code, reason = "the task's lifetime is erased while its phase runs")]

use core::cell::UnsafeCell;
use core::hint::spin_loop;
use core::ops::Range;
use core::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, AtomicUsize, Ordering};
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
    /// Lists that the chunks are in, those of the first workers.
    lists: usize,
}

/// A list's [`Word`], alone on its cache lines.
#[derive(Debug, Default)]
#[repr(align(128))]
struct Claims(AtomicU64);

/// Most chunks of a phase: counts have 15 bits.
const MOST: usize = 0x7fff;

/// The chunks of a list that are not yet claimed, in one word: the phase's epoch in the upper half, then whether all take from the
/// front, how many were claimed from the back, and how many are left.
#[derive(Clone, Copy, Debug)]
struct Word(u64);

impl Word {
    const COMMON: u64 = 1 << 31;

    fn new(epoch: u32, is_common: bool, left: usize) -> Self {
        Self(u64::from(epoch) << 32 | if is_common { Self::COMMON } else { 0 } | left as u64)
    }

    fn is_common(self) -> bool {
        self.0 & Self::COMMON != 0
    }

    fn left(self) -> usize {
        usize::try_from(self.0 & 0xffff).unwrap_or(0)
    }

    fn back(self) -> usize {
        usize::try_from(self.0 >> 16 & 0x7fff).unwrap_or(0)
    }

    /// With the next chunk from one end claimed.
    fn claimed(self, back: bool) -> Self {
        Self(self.0 - 1 + if back { 1 << 16 } else { 0 })
    }
}

struct Shared {
    /// One list for each worker.
    claims: Box<[Claims]>,
    /// Number of the phase.
    epoch: AtomicU32,
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
    /// Claims and runs chunks until none is left: those of the worker's own list, then those of the others.
    fn work(&self, worker: usize) {
        let n = self.claims.len();
        for k in 0..n {
            let list = (worker + k) % n;
            while let Some((word, back)) = self.claim(list, k > 0) {
                let _done = Done(self);
                // SAFETY: this worker holds a claimed chunk, so the job is that of this phase.
                let job = unsafe { &*self.job.get() };
                // SAFETY: the caller of `run` keeps the task alive until every chunk is done.
                let task = unsafe { &*job.task };
                let end = part(job.chunks, job.lists, list).end - word.back();
                task(worker, if back { end - 1 } else { end - word.left() });
            }
        }
    }

    /// Claims a chunk of a list, if one is left: what was there before, and whether it is the one at the back.
    fn claim(&self, list: usize, is_others: bool) -> Option<(Word, bool)> {
        let claims = &self.claims[list].0;
        let mut seen = Word(claims.load(Ordering::Acquire));
        while seen.left() > 0 {
            let back = is_others && !seen.is_common();
            let next = seen.claimed(back).0;
            let (success, failure) = (Ordering::AcqRel, Ordering::Acquire);
            match claims.compare_exchange_weak(seen.0, next, success, failure) {
                Ok(_) => return Some((seen, back)),
                Err(now) => seen = Word(now),
            }
        }
        None
    }

    fn serve(&self, worker: usize) {
        let mut last = 0;
        loop {
            let is_idle = |last: u32| {
                self.epoch.load(Ordering::SeqCst) == last && !self.quit.load(Ordering::SeqCst)
            };
            let mut spins = 0;
            while is_idle(last) && spins < SPINS {
                spin_loop();
                spins += 1;
            }
            if is_idle(last) {
                self.parked.fetch_add(1, Ordering::SeqCst);
                let mut guard = self.lock.lock().unwrap_or_else(PoisonError::into_inner);
                while is_idle(last) {
                    guard = self.wake.wait(guard).unwrap_or_else(PoisonError::into_inner);
                }
                drop(guard);
                self.parked.fetch_sub(1, Ordering::SeqCst);
            }
            if self.quit.load(Ordering::SeqCst) {
                return;
            }
            last = self.epoch.load(Ordering::SeqCst);
            self.work(worker);
        }
    }

    fn wake_all(&self) {
        drop(self.lock.lock().unwrap_or_else(PoisonError::into_inner));
        self.wake.notify_all();
    }
}

/// The chunks of one of so many lists.
fn part(chunks: usize, lists: usize, list: usize) -> Range<usize> {
    chunks * list / lists..chunks * (list + 1) / lists
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
        let workers = workers.clamp(1, 256);
        let shared = Arc::new(Shared {
            claims: (0..workers).map(|_| Claims::default()).collect(),
            epoch: AtomicU32::new(0),
            job: UnsafeCell::new(Job { task: nothing, chunks: 0, lists: 1 }),
            done: AtomicUsize::new(0),
            parked: AtomicUsize::new(0),
            quit: AtomicBool::new(false),
            panicked: AtomicBool::new(false),
            lock: Mutex::new(()),
            wake: Condvar::new(),
        });
        let threads = (1..workers)
            .map_while(|worker| {
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
        self.phases(chunks, 1, task);
    }

    fn run_in_shares(&self, chunks: usize, task: &(dyn Fn(usize, usize) + Sync)) {
        self.phases(chunks, self.shared.claims.len(), task);
    }
}

impl Team {
    /// Runs the chunks, a phase for as many as it can count.
    fn phases(&self, chunks: usize, lists: usize, task: &(dyn Fn(usize, usize) + Sync)) {
        let alone = chunks <= 1 || self.threads.is_empty();
        let guard = if alone { None } else { self.busy.try_lock().ok() };
        let Some(mut epoch) = guard else {
            for chunk in 0..chunks {
                task(0, chunk);
            }
            return;
        };
        for first in (0..chunks).step_by(MOST) {
            *epoch = epoch.wrapping_add(1);
            let n = MOST.min(chunks - first);
            self.phase(*epoch, n, lists, &|worker, chunk| task(worker, first + chunk));
        }
    }

    /// Runs a phase, of a caller that holds [`Self::busy`].
    fn phase(&self, epoch: u32, chunks: usize, lists: usize, task: &(dyn Fn(usize, usize) + Sync)) {
        let shared = &*self.shared;
        // SAFETY: only the lifetime changes; `phase` returns after the last use of the pointer.
        let erased =
            unsafe { core::mem::transmute::<&(dyn Fn(usize, usize) + Sync), &'static Task>(task) };
        // SAFETY: no chunk is claimed between phases, so nobody reads the job now.
        let job = unsafe { &mut *shared.job.get() };
        *job = Job { task: erased, chunks, lists };
        shared.done.store(0, Ordering::Relaxed);
        for (list, claims) in shared.claims.iter().enumerate() {
            let n = if list < lists { part(chunks, lists, list).len() } else { 0 };
            claims.0.store(Word::new(epoch, lists == 1, n).0, Ordering::Release);
        }
        shared.epoch.store(epoch, Ordering::SeqCst);
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
                let task = |worker, chunk: usize| {
                    assert!(worker < team.workers());
                    counts[chunk].fetch_add(1, Ordering::Relaxed);
                };
                if round % 2 == 0 {
                    team.run(chunks, &task);
                } else {
                    team.run_in_shares(chunks, &task);
                }
                assert!(counts.iter().all(|c| c.load(Ordering::Relaxed) == 1));
            }
        }
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
                team.run_in_shares(counts.len(), &task);
            }
            assert!(counts.iter().all(|c| c.load(Ordering::Relaxed) == round));
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
