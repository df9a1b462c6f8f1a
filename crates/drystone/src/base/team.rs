//! Our own worker team: a fixed number of threads that claim chunks.
//!
//! Each worker has a list of its own, always the same part of the chunks, so that from step to step it finds what it wrote in its own
//! cache; who is done helps the others from the back. Chunks are claimed one by one, so a worker that sleeps or whose core is
//! taken by another program never holds up a phase: the caller finishes alone. Phases that follow one another are told to
//! the workers at once, as a series: a phase begins for a worker as soon as it sees that all chunks of the one before have returned,
//! which is one cache line from core to core. Workers look out for the next series for some tenths of a millisecond, then park.
#![expect(unsafe_code, reason = "the task's lifetime is erased while its series runs")]

use core::cell::UnsafeCell;
use core::hint::spin_loop;
use core::ops::Range;
use core::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::{JoinHandle, yield_now};

use super::jobs::Executor;

/// Worker, phase, chunk.
type Task = dyn Fn(usize, usize, usize) + Sync;

/// So often a worker looks for the next series before it parks: 0.2 to 0.5 ms of `spin_loop`, longer than the caller is alone within
/// most steps. To be woken takes as long as a serial stage (docs/decisions/027-shares-of-a-phase.md).
const SPINS: u32 = 14_000;

/// So often it looks before it offers the core to others, and again after so many more looks.
const LOOKS: u32 = 2000;
const AGAIN: u32 = 100;

/// So often a phase's end is looked for before the core is offered to others.
const WAITS: u32 = 500;

/// Most phases of a series.
const PHASES: usize = 32;

/// Most chunks of a phase: counts have 15 bits.
const MOST: usize = 0x7fff;

struct Job {
    /// The task of the running series; dangling between series.
    task: *const Task,
    /// Of each phase.
    chunks: [u16; PHASES],
}

/// A number for each phase of a series, [`tagged`], alone on its cache lines.
#[derive(Debug, Default)]
#[repr(align(128))]
struct PerPhase([AtomicU64; PHASES]);

/// The chunks of a list that are not yet claimed, in one word, [`tagged`] at first: the series' epoch in the upper half, then how many
/// were claimed from the back, and how many are left.
#[derive(Clone, Copy, Debug)]
struct Word(u64);

impl Word {
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

/// A series' epoch and a number.
fn tagged(epoch: u32, number: usize) -> u64 {
    u64::from(epoch) << 32 | number as u64
}

/// The two again.
fn untagged(word: u64) -> (u32, usize) {
    ((word >> 32) as u32, (word & 0xffff_ffff) as usize)
}

struct Shared {
    /// The list of each worker, as [`Word`]s.
    claims: Box<[PerPhase]>,
    /// Chunks that have not returned.
    open: PerPhase,
    /// Number of the series and of its phases, [`tagged`].
    series: AtomicU64,
    job: UnsafeCell<Job>,
    parked: AtomicUsize,
    quit: AtomicBool,
    panicked: AtomicBool,
    lock: Mutex<()>,
    wake: Condvar,
}

// SAFETY: `job` is written by the caller between series only (it holds `Team::busy`), and read by a
// worker only while it holds a claimed chunk, before which the series cannot end.
unsafe impl Sync for Shared {}
// SAFETY: the raw task pointer is only followed during its series, see `Sync`.
unsafe impl Send for Shared {}

/// Takes down that a worker's chunks of a phase have returned, even if a task panics, so that the caller never waits for
/// ever.
struct Returned<'a> {
    open: &'a AtomicU64,
    panicked: &'a AtomicBool,
    chunks: u64,
}

impl Drop for Returned<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.panicked.store(true, Ordering::Relaxed);
        }
        if self.chunks > 0 {
            self.open.fetch_sub(self.chunks, Ordering::AcqRel);
        }
    }
}

impl Shared {
    /// Claims and runs chunks of a series, phase by phase, until none is left: those of the worker's own list, then those of
    /// the others. Who comes late finds another series, and leaves.
    fn work(&self, worker: usize, epoch: u32, phases: usize) {
        let n = self.claims.len();
        for phase in 0..phases {
            if phase > 0 && !self.wait(epoch, phase - 1) {
                return;
            }
            let (open, panicked) = (&self.open.0[phase], &self.panicked);
            let mut returned = Returned { open, panicked, chunks: 0 };
            for k in 0..n {
                let list = (worker + k) % n;
                // From the back of the others' lists: what stands at the front they come to soon.
                let back = k > 0;
                while let Some(word) = self.claim(epoch, phase, list, back) {
                    returned.chunks += 1;
                    // SAFETY: this worker holds a claimed chunk, so the job is that of this series.
                    let job = unsafe { &*self.job.get() };
                    // SAFETY: the caller keeps the task alive until every chunk has returned.
                    let task = unsafe { &*job.task };
                    let end = part(job.chunks[phase].into(), n, list).end - word.back();
                    task(worker, phase, if back { end - 1 } else { end - word.left() });
                }
            }
        }
    }

    /// Claims a chunk from one end of a list, if one is left: gives what was there before.
    fn claim(&self, epoch: u32, phase: usize, list: usize, back: bool) -> Option<Word> {
        let claims = &self.claims[list].0[phase];
        let mut seen = Word(claims.load(Ordering::Acquire));
        while seen.left() > 0 && untagged(seen.0).0 == epoch {
            let next = seen.claimed(back).0;
            let (success, failure) = (Ordering::AcqRel, Ordering::Acquire);
            match claims.compare_exchange_weak(seen.0, next, success, failure) {
                Ok(_) => return Some(seen),
                Err(now) => seen = Word(now),
            }
        }
        None
    }

    /// Waits until all chunks of a phase have returned; false if the series is over.
    fn wait(&self, epoch: u32, phase: usize) -> bool {
        let mut looks = 0_u32;
        loop {
            let (now, open) = untagged(self.open.0[phase].load(Ordering::Acquire));
            if now != epoch || open == 0 {
                return now == epoch;
            }
            looks = looks.saturating_add(1);
            // A claimed chunk may wait for this very core: let the others run.
            if looks > WAITS { yield_now() } else { spin_loop() }
        }
    }

    fn serve(&self, worker: usize) {
        let mut last = 0;
        loop {
            let is_idle = |last: u64| {
                self.series.load(Ordering::SeqCst) == last && !self.quit.load(Ordering::SeqCst)
            };
            let mut looks = 0;
            while is_idle(last) && looks < SPINS {
                looks += 1;
                // The caller itself, or another program, may wait for this very core.
                let offer = looks >= LOOKS && looks.is_multiple_of(AGAIN);
                if offer { yield_now() } else { spin_loop() }
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
            last = self.series.load(Ordering::SeqCst);
            let (epoch, phases) = untagged(last);
            self.work(worker, epoch, phases);
        }
    }

    fn wake_all(&self) {
        drop(self.lock.lock().unwrap_or_else(PoisonError::into_inner));
        self.wake.notify_all();
    }
}

/// The chunks of one of so many lists.
fn part(chunks: usize, lists: usize, list: usize) -> Range<usize> {
    (chunks * list).div_ceil(lists)..(chunks * (list + 1)).div_ceil(lists)
}

/// A team of threads that lives as long as the value. When a step is over its workers look out for the next one for up to half a
/// millisecond, offering their cores to others, and then sleep.
pub struct Team {
    shared: Arc<Shared>,
    threads: Vec<JoinHandle<()>>,
    /// Held during a series. A second caller (another world on the same team) works alone.
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
        let nothing: &'static Task = &|_, _, _| {};
        let workers = workers.clamp(1, 256);
        let shared = Arc::new(Shared {
            claims: (0..workers).map(|_| PerPhase::default()).collect(),
            open: PerPhase::default(),
            series: AtomicU64::new(0),
            job: UnsafeCell::new(Job { task: nothing, chunks: [0; PHASES] }),
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
        for first in (0..chunks).step_by(MOST) {
            let n = MOST.min(chunks - first);
            self.series(0..1, &|_| n, &|worker, _, chunk| task(worker, first + chunk));
        }
    }

    fn run_in_series(
        &self,
        phases: usize,
        chunks: &dyn Fn(usize) -> usize,
        task: &(dyn Fn(usize, usize, usize) + Sync),
    ) {
        for first in (0..phases).step_by(PHASES) {
            let range = first..phases.min(first + PHASES);
            if range.clone().all(|phase| chunks(phase) <= MOST) {
                self.series(range, chunks, task);
            } else {
                range.for_each(|phase| self.run(chunks(phase), &|w, chunk| task(w, phase, chunk)));
            }
        }
    }
}

impl Team {
    /// Runs some phases of at most [`MOST`] chunks, at most [`PHASES`] of them.
    fn series(
        &self,
        range: Range<usize>,
        chunks: &dyn Fn(usize) -> usize,
        task: &(dyn Fn(usize, usize, usize) + Sync),
    ) {
        let alone = self.threads.is_empty() || range.clone().all(|phase| chunks(phase) <= 1);
        let guard = if alone { None } else { self.busy.try_lock().ok() };
        let Some(mut epoch) = guard else {
            for phase in range {
                (0..chunks(phase)).for_each(|chunk| task(0, phase, chunk));
            }
            return;
        };
        *epoch = epoch.wrapping_add(1);
        let (first, phases, epoch) = (range.start, range.len(), *epoch);
        let numbered = |worker, phase, chunk| task(worker, first + phase, chunk);
        let numbered: &(dyn Fn(usize, usize, usize) + Sync) = &numbered;
        let shared = &*self.shared;
        // SAFETY: only the lifetime changes; `series` returns after the last use of the pointer.
        let erased = unsafe {
            core::mem::transmute::<&(dyn Fn(usize, usize, usize) + Sync), &'static Task>(numbered)
        };
        // SAFETY: no chunk is claimed between series, so nobody reads the job now.
        let job = unsafe { &mut *shared.job.get() };
        job.task = erased;
        let lists = shared.claims.len();
        for phase in 0..phases {
            let n = chunks(first + phase).min(MOST);
            job.chunks[phase] = u16::try_from(n).expect("at most MOST");
            shared.open.0[phase].store(tagged(epoch, n), Ordering::Relaxed);
            for (list, claims) in shared.claims.iter().enumerate() {
                let left = part(n, lists, list).len();
                claims.0[phase].store(tagged(epoch, left), Ordering::Release);
            }
        }
        shared.series.store(tagged(epoch, phases), Ordering::SeqCst);
        if shared.parked.load(Ordering::SeqCst) > 0 {
            shared.wake_all();
        }
        shared.work(0, epoch, phases);
        shared.wait(epoch, phases - 1);
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
                    team.run_in_series(1, &|_| chunks, &|worker, _, chunk| task(worker, chunk));
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
}
