//! This crate's worker team: a fixed number of threads that claim chunks.
//!
//! Each worker has its own list, always the same part of the chunks, so that it finds the data of
//! the last step in its own cache. A worker that has finished its list helps the others from the
//! back. Chunks are claimed one by one. A worker that sleeps, or whose core runs another program,
//! therefore never delays a phase: the caller finishes alone.
//!
//! Successive phases are published to the workers at once, as a series. A worker starts a phase as
//! soon as it sees that all chunks of the previous phase have returned, which takes one cache line
//! from core to core. Workers poll for the next series for some tenths of a millisecond, then park.
//!
//! A team may have no threads of its own, but seats for threads of the program ([`Team::join`]).
//! Each such thread takes a unique number, and keeps it until it has returned all chunks that it
//! claimed.
//!
//! A panic of a task never unwinds out of a series. The remaining chunks are claimed and skipped,
//! and the caller resumes the panic when all have returned. The data that a task borrows therefore
//! lives as long as a worker can call it, and threads survive. `cargo xtask model` runs the
//! protocol through many schedules.
#![expect(unsafe_code, reason = "the task's lifetime is erased while its series runs")]

mod word;

use core::cell::UnsafeCell;
use core::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::{PoisonError, TryLockError};

use self::word::{Payload, PerPhase, Word, part, tagged, this_process, untagged};
use super::jobs::{Executor, known};
use super::sync::{
    Arc, AtomicBool, AtomicU64, AtomicUsize, Builder, Condvar, JoinHandle, Mutex, MutexGuard,
    Ordering, spin_loop, yield_now,
};

/// A task: called with worker, phase, chunk.
type Task = dyn Fn(usize, usize, usize) + Sync;

/// Number of polls for the next series before a worker parks: 0.2 to 0.5 ms of `spin_loop`, longer
/// than the caller is alone within most steps. A wake-up takes as long as a serial stage
/// (docs/decisions/027-shares-of-a-phase.md).
const SPINS: u32 = if cfg!(drystone_model) { 2 } else { 14_000 };

/// Number of polls before the first yield of the core, and between two later yields.
const LOOKS: u32 = 2000;
const AGAIN: u32 = 100;

/// Number of polls for a phase's end before the core is yielded.
const WAITS: u32 = if cfg!(drystone_model) { 0 } else { 500 };

/// Maximum number of phases of a series.
pub(crate) const PHASES: usize = 32;

/// Maximum number of chunks of a phase: counts have 15 bits.
const MAX: usize = 0x7fff;

struct Job {
    /// The task of the running series; dangling between series.
    task: *const Task,
    /// Number of chunks of each phase.
    chunks: [u16; PHASES],
}

struct Shared {
    /// The list of each worker, as [`Word`]s.
    claims: Box<[PerPhase]>,
    /// Number of chunks of each phase that have not returned.
    open: PerPhase,
    /// Whether a thread acts as each worker. Worker 0 is the caller and has no seat.
    seats: Box<[AtomicBool]>,
    /// Number of the program's threads that have joined.
    guests: AtomicUsize,
    /// Epoch of the series and number of its phases, [`tagged`].
    series: AtomicU64,
    job: UnsafeCell<Job>,
    parked: AtomicUsize,
    quit: AtomicBool,
    /// A task of the running series panicked: chunks are claimed but not run.
    panicked: AtomicBool,
    /// Payload of the first panic.
    payload: Mutex<Option<Payload>>,
    lock: Mutex<()>,
    wake: Condvar,
}

// SAFETY: the caller writes `job` only between series (it holds `Team::busy`). A worker reads it
// only while it holds a claimed chunk, and the series does not end before that chunk returns.
unsafe impl Sync for Shared {}
// SAFETY: the raw task pointer is dereferenced only during its series, see `Sync`.
unsafe impl Send for Shared {}

impl Shared {
    /// Claims and runs chunks of a series, phase by phase, until none is left: first the worker's
    /// own list, then the others'. A worker that arrives late finds another series, and returns.
    /// Never unwinds.
    fn work(&self, worker: usize, epoch: u32, phases: usize) {
        for phase in 0..phases {
            if phase > 0 && !self.wait(epoch, phase - 1) {
                return;
            }
            let mut claimed = 0;
            let mut run = || self.run_chunks(worker, epoch, phase, &mut claimed);
            // After a panic of a task, runs again to claim the remaining chunks.
            while let Err(payload) = catch_unwind(AssertUnwindSafe(&mut run)) {
                self.keep(payload);
            }
            if claimed > 0 {
                self.open.0[phase].fetch_sub(claimed, Ordering::AcqRel);
            }
        }
    }

    /// Claims and runs the chunks of one phase. Counts its claims in `claimed`.
    fn run_chunks(&self, worker: usize, epoch: u32, phase: usize, claimed: &mut u64) {
        let n = self.claims.len();
        for k in 0..n {
            let list = (worker + k) % n;
            // Takes other lists from the back: their owners reach the front soon.
            let back = k > 0;
            while let Some(word) = self.claim(epoch, phase, list, back) {
                *claimed += 1;
                if self.panicked.load(Ordering::Relaxed) {
                    continue;
                }
                // SAFETY: this worker holds a claimed chunk, so the job is the one of this series.
                let job = unsafe { &*self.job.get() };
                // SAFETY: `series` keeps the task alive until every claimed chunk has returned.
                let task = unsafe { &*job.task };
                let end = part(job.chunks[phase].into(), n, list).end - word.back();
                task(worker, phase, if back { end - 1 } else { end - word.left() });
            }
        }
    }

    /// Stores the payload of a task's panic for the caller, if it is the first.
    fn keep(&self, payload: Payload) {
        self.panicked.store(true, Ordering::Relaxed);
        let mut first = self.payload.lock().unwrap_or_else(PoisonError::into_inner);
        if first.is_none() {
            *first = Some(payload);
        } else {
            // Dropping it could panic again, where nothing catches it.
            core::mem::forget(payload);
        }
    }

    /// Claims a chunk from one end of a list, if one is left; returns the word before the claim.
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

    /// Waits until all chunks of a phase have returned; returns false if the series is over.
    fn wait(&self, epoch: u32, phase: usize) -> bool {
        let mut looks = 0_u32;
        loop {
            let (now, open) = untagged(self.open.0[phase].load(Ordering::Acquire));
            if now != epoch || open == 0 {
                return now == epoch;
            }
            looks = looks.saturating_add(1);
            // A claimed chunk may need this core: lets other threads run.
            if looks > WAITS { yield_now() } else { spin_loop() }
        }
    }

    /// Works until the team ends, or until `leave` is true. Never unwinds.
    fn serve(&self, worker: usize, leave: Option<&AtomicBool>) {
        let mut last = 0;
        let is_over = || {
            self.quit.load(Ordering::SeqCst)
                || leave.is_some_and(|leave| leave.load(Ordering::SeqCst))
        };
        loop {
            let is_idle = |last: u64| self.series.load(Ordering::SeqCst) == last && !is_over();
            let mut looks = 0;
            while is_idle(last) && looks < SPINS {
                looks += 1;
                // The caller, or another program, may need this core.
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
            if is_over() {
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

/// A team of threads that lives as long as the value. After a step its workers poll for the next
/// one for up to half a millisecond, while they yield their cores to others, and then sleep. The
/// manual: [threads and determinism](crate::manual::threads_and_determinism).
pub struct Team {
    shared: Arc<Shared>,
    threads: Vec<JoinHandle<()>>,
    /// Whether all workers except the caller are threads that join.
    is_hosted: bool,
    /// Id of the process with the threads, the team's own and those that joined; a fork has none of
    /// them. It is 0 until there are threads.
    process: AtomicUsize,
    /// Locked during a series. A second caller (another world on the same team) works alone.
    busy: Mutex<u32>,
}

impl core::fmt::Debug for Team {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Team").field("workers", &self.workers()).finish_non_exhaustive()
    }
}

impl Team {
    /// A team of `workers`, the caller included. It starts `workers - 1` threads, fewer if the
    /// system refuses. 0 counts as 1. The number is limited to the machine's cores: more threads
    /// only take cores from threads that hold a chunk.
    #[must_use]
    pub fn new(workers: usize) -> Self {
        let cores = std::thread::available_parallelism().map_or(workers, usize::from);
        Self::with_threads(workers.min(cores))
    }

    /// Like [`Self::new`], but also with more workers than the machine has cores, up to 256: for
    /// tests that need every interleaving.
    #[must_use]
    pub fn with_threads(workers: usize) -> Self {
        let shared = Self::shared(workers);
        let threads: Vec<_> = (1..shared.seats.len())
            .map_while(|worker| {
                let shared = Arc::clone(&shared);
                let name = format!("drystone-{worker}");
                Builder::new().name(name).spawn(move || shared.serve(worker, None)).ok()
            })
            .collect();
        // A target without threads may have no processes either.
        let process = if threads.is_empty() { 0 } else { this_process() };
        for seat in &shared.seats[1..=threads.len()] {
            seat.store(true, Ordering::SeqCst);
        }
        let (process, is_hosted) = (AtomicUsize::new(process), false);
        Self { shared, threads, is_hosted, process, busy: Mutex::new(0) }
    }

    /// A team that starts no threads, with up to `workers` workers, the caller included, 1 to 256.
    /// It is for hosts that have their own threads and lend them with [`Self::join`], for a step or
    /// permanently. Threads that have joined help; without any the caller works alone. The result
    /// of a step is the same.
    ///
    /// ```
    /// use std::sync::Arc;
    /// use std::sync::atomic::AtomicBool;
    ///
    /// use drystone::World;
    /// use drystone::threads::Team;
    ///
    /// let team = Arc::new(Team::hosted(4));
    /// let mut world = World::default().with_executor(team.clone());
    /// let leave = AtomicBool::new(false);
    /// std::thread::scope(|scope| {
    ///     // Here threads of a pool of the host would do something else before and after.
    ///     for _ in 0..3 {
    ///         scope.spawn(|| team.join(&leave));
    ///     }
    ///     world.step(1.0 / 60.0);
    ///     team.release(&leave);
    /// });
    /// ```
    #[must_use]
    pub fn hosted(workers: usize) -> Self {
        let (shared, threads) = (Self::shared(workers), Vec::new());
        let (process, is_hosted) = (AtomicUsize::new(0), true);
        Self { shared, threads, is_hosted, process, busy: Mutex::new(0) }
    }

    /// Lends the calling thread to the team. It does the team's work until `leave` is true, which
    /// [`Self::release`] sets. It returns at once if `leave` is already true. It returns false at
    /// once if the team has no free seat.
    ///
    /// While there is no work the thread polls for up to half a millisecond, while it yields its
    /// core to others, and then sleeps. A panic of a task resumes in the caller, never here.
    ///
    /// The thread that steps a world does not join: it is a worker already. A thread that is never
    /// released never returns.
    pub fn join(&self, leave: &AtomicBool) -> bool {
        let shared = &*self.shared;
        let take = |seat: &&AtomicBool| {
            seat.compare_exchange(false, true, Ordering::SeqCst, Ordering::SeqCst).is_ok()
        };
        // The first seat belongs to the caller. A team with its own threads has no free seat.
        let mut seats = shared.seats.iter().enumerate().take(self.workers()).skip(1);
        let Some((worker, seat)) = seats.find(|(_, seat)| take(seat)) else { return false };
        self.process.store(this_process(), Ordering::SeqCst);
        shared.guests.fetch_add(1, Ordering::SeqCst);
        shared.serve(worker, Some(leave));
        shared.guests.fetch_sub(1, Ordering::SeqCst);
        seat.store(false, Ordering::SeqCst);
        true
    }

    /// Sets `leave` to true, and releases the threads that [joined](Self::join) with it: each first
    /// finishes the chunks that it holds.
    pub fn release(&self, leave: &AtomicBool) {
        leave.store(true, Ordering::SeqCst);
        self.shared.wake_all();
    }

    fn shared(workers: usize) -> Arc<Shared> {
        let nothing: &'static Task = &|_, _, _| {};
        let workers = workers.clamp(1, 256);
        Arc::new(Shared {
            claims: (0..workers).map(|_| PerPhase::default()).collect(),
            open: PerPhase::default(),
            seats: (0..workers).map(|_| AtomicBool::new(false)).collect(),
            guests: AtomicUsize::new(0),
            series: AtomicU64::new(0),
            job: UnsafeCell::new(Job { task: nothing, chunks: [0; PHASES] }),
            parked: AtomicUsize::new(0),
            quit: AtomicBool::new(false),
            panicked: AtomicBool::new(false),
            payload: Mutex::new(None),
            lock: Mutex::new(()),
            wake: Condvar::new(),
        })
    }

    /// Returns whether no thread helps, neither the team's own nor the program's; makes no system
    /// call.
    fn is_alone(&self) -> bool {
        self.threads.is_empty() && self.shared.guests.load(Ordering::SeqCst) == 0
    }

    /// Returns whether the threads belong to this process, as opposed to a fork of theirs. It makes
    /// a system call (0.1 µs).
    fn has_threads(&self) -> bool {
        !self.is_alone() && self.process.load(Ordering::SeqCst) == this_process()
    }
}

impl Executor for Team {
    fn known(&self, _: known::Ask) -> known::Known<'_> {
        known::Known::Team(self)
    }

    fn workers(&self) -> usize {
        // A hosted team reports the maximum number of threads that may join.
        if self.is_hosted { self.shared.seats.len() } else { self.threads.len() + 1 }
    }

    fn run(&self, chunks: usize, task: &(dyn Fn(usize, usize) + Sync)) {
        for first in (0..chunks).step_by(MAX) {
            let n = MAX.min(chunks - first);
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
            if range.clone().all(|phase| chunks(phase) <= MAX) {
                self.series(range, chunks, task);
            } else {
                range.for_each(|phase| self.run(chunks(phase), &|w, chunk| task(w, phase, chunk)));
            }
        }
    }
}

impl Team {
    /// Runs at most [`PHASES`] phases of at most [`MAX`] chunks each.
    fn series(
        &self,
        range: Range<usize>,
        chunks: &dyn Fn(usize) -> usize,
        task: &(dyn Fn(usize, usize, usize) + Sync),
    ) {
        let (first, phases) = (range.start, range.len());
        // Calls `chunks` once per phase: the caller's function may return another value the next
        // time.
        let mut counts = [0_u16; PHASES];
        for (count, phase) in counts.iter_mut().zip(range) {
            *count = u16::try_from(chunks(phase).min(MAX)).expect("at most MAX");
        }
        let counts = &counts[..phases];
        let alone = self.is_alone() || counts.iter().all(|n| *n <= 1);
        let guard = if alone { None } else { self.begin() };
        let Some(mut guard) = guard else {
            for (phase, n) in counts.iter().enumerate() {
                (0..usize::from(*n)).for_each(|chunk| task(0, first + phase, chunk));
            }
            return;
        };
        *guard = guard.wrapping_add(1);
        let epoch = *guard;
        let numbered = |worker, phase, chunk| task(worker, first + phase, chunk);
        self.publish(epoch, counts, &numbered);
        let shared = &*self.shared;
        if shared.parked.load(Ordering::SeqCst) > 0 && self.has_threads() {
            shared.wake_all();
        }
        // Nothing unwinds between `publish` and the return of all chunks: `work` catches panics of
        // tasks.
        shared.work(0, epoch, phases);
        shared.wait(epoch, phases - 1);
        if shared.panicked.load(Ordering::Relaxed) {
            shared.panicked.store(false, Ordering::Relaxed);
            let first = shared.payload.lock().unwrap_or_else(PoisonError::into_inner).take();
            drop(guard);
            resume_unwind(first.expect("it is kept when a task panics"));
        }
    }

    /// Acquires the right to run a series, unless one is running; the guard holds the last epoch.
    fn begin(&self) -> Option<MutexGuard<'_, u32>> {
        match self.busy.try_lock() {
            Ok(guard) => Some(guard),
            Err(TryLockError::Poisoned(error)) => Some(error.into_inner()),
            Err(TryLockError::WouldBlock) => None,
        }
    }

    /// Publishes a series to the workers. The task must live until all its chunks have returned.
    fn publish(&self, epoch: u32, counts: &[u16], task: &(dyn Fn(usize, usize, usize) + Sync)) {
        let shared = &*self.shared;
        // SAFETY: only the lifetime changes; `series` returns after the last use of the pointer.
        let erased = unsafe {
            core::mem::transmute::<&(dyn Fn(usize, usize, usize) + Sync), &'static Task>(task)
        };
        {
            // SAFETY: the caller has exclusive access to the job: no chunk is claimed between
            // series, nor before the words below are written.
            let job = unsafe { &mut *shared.job.get() };
            job.task = erased;
            job.chunks[..counts.len()].copy_from_slice(counts);
        }
        let lists = shared.claims.len();
        for (phase, n) in counts.iter().enumerate() {
            let n = usize::from(*n);
            shared.open.0[phase].store(tagged(epoch, n), Ordering::Relaxed);
            for (list, claims) in shared.claims.iter().enumerate() {
                let left = part(n, lists, list).len();
                claims.0[phase].store(tagged(epoch, left), Ordering::Release);
            }
        }
        shared.series.store(tagged(epoch, counts.len()), Ordering::SeqCst);
    }
}

impl Drop for Team {
    fn drop(&mut self) {
        if !self.has_threads() {
            // In a fork the threads do not exist: joining them would never return.
            core::mem::forget(core::mem::take(&mut self.threads));
            return;
        }
        self.shared.quit.store(true, Ordering::SeqCst);
        self.shared.wake_all();
        for thread in self.threads.drain(..) {
            // Workers catch the panics of tasks.
            let _ = thread.join();
        }
    }
}

#[cfg(all(test, drystone_model))]
mod model;

#[cfg(all(test, not(drystone_model)))]
mod tests;
