//! Our own worker team: a fixed number of threads that claim chunks.
//!
//! Each worker has a list of its own, always the same part of the chunks, so that from step to step it finds what it wrote in its own
//! cache; who is done helps the others from the back. Chunks are claimed one by one, so a worker that sleeps or whose core is
//! taken by another program never holds up a phase: the caller finishes alone. Phases that follow one another are told to
//! the workers at once, as a series: a phase begins for a worker as soon as it sees that all chunks of the one before have returned,
//! which is one cache line from core to core. Workers look out for the next series for some tenths of a millisecond, then park.
//!
//! A team may have no threads of its own, and seats for those of the program instead ([`Team::join`]): each takes a number that no
//! other has, and keeps it until it has returned all that it claimed.
//!
//! A task that panics never unwinds out of a series: the chunks that are left are claimed and skipped, and the caller goes on with the
//! panic when all have returned. So what a task borrows is there as long as a worker can call it, and threads live on. The protocol is
//! run through many schedules by `cargo xtask model`.
#![expect(unsafe_code, reason = "the task's lifetime is erased while its series runs")]

use core::cell::UnsafeCell;
use core::ops::Range;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::{PoisonError, TryLockError};

use super::jobs::{Executor, known};
use super::sync::{
    Arc, AtomicBool, AtomicU64, AtomicUsize, Builder, Condvar, JoinHandle, Mutex, MutexGuard,
    Ordering, spin_loop, yield_now,
};

/// Worker, phase, chunk.
type Task = dyn Fn(usize, usize, usize) + Sync;

/// What a task panicked with.
type Payload = Box<dyn Any + Send>;

/// So often a worker looks for the next series before it parks: 0.2 to 0.5 ms of `spin_loop`, longer than the caller is alone within
/// most steps. To be woken takes as long as a serial stage (docs/decisions/027-shares-of-a-phase.md).
const SPINS: u32 = if cfg!(drystone_model) { 2 } else { 14_000 };

/// So often it looks before it offers the core to others, and again after so many more looks.
const LOOKS: u32 = 2000;
const AGAIN: u32 = 100;

/// So often a phase's end is looked for before the core is offered to others.
const WAITS: u32 = if cfg!(drystone_model) { 0 } else { 500 };

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

/// A series' epoch and a number. Epochs come again after 2³² series (eight days of them without a break). A worker that slept
/// just so long does no harm: a claim succeeds only for the word that is there now, which the running series wrote when its job stood.
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
    /// By workers: some thread is it. The caller, worker 0, needs none.
    seats: Box<[AtomicBool]>,
    /// Threads of the program that have joined.
    guests: AtomicUsize,
    /// Number of the series and of its phases, [`tagged`].
    series: AtomicU64,
    job: UnsafeCell<Job>,
    parked: AtomicUsize,
    quit: AtomicBool,
    /// A task of the running series panicked: chunks are claimed but not run.
    panicked: AtomicBool,
    /// With what it did, the first of them.
    payload: Mutex<Option<Payload>>,
    lock: Mutex<()>,
    wake: Condvar,
}

// SAFETY: `job` is written by the caller between series only (it holds `Team::busy`), and read by a
// worker only while it holds a claimed chunk, before whose return the series does not end.
unsafe impl Sync for Shared {}
// SAFETY: the raw task pointer is only followed during its series, see `Sync`.
unsafe impl Send for Shared {}

impl Shared {
    /// Claims and runs chunks of a series, phase by phase, until none is left: those of the worker's own list, then those of
    /// the others. Who comes late finds another series, and leaves. Never unwinds.
    fn work(&self, worker: usize, epoch: u32, phases: usize) {
        for phase in 0..phases {
            if phase > 0 && !self.wait(epoch, phase - 1) {
                return;
            }
            let mut claimed = 0;
            let mut run = || self.run_chunks(worker, epoch, phase, &mut claimed);
            // Once more, to claim what is left, if a task panicked.
            while let Err(payload) = catch_unwind(AssertUnwindSafe(&mut run)) {
                self.keep(payload);
            }
            if claimed > 0 {
                self.open.0[phase].fetch_sub(claimed, Ordering::AcqRel);
            }
        }
    }

    /// Those of a phase. Counts what it claims.
    fn run_chunks(&self, worker: usize, epoch: u32, phase: usize, claimed: &mut u64) {
        let n = self.claims.len();
        for k in 0..n {
            let list = (worker + k) % n;
            // From the back of the others' lists: what stands at the front they come to soon.
            let back = k > 0;
            while let Some(word) = self.claim(epoch, phase, list, back) {
                *claimed += 1;
                if self.panicked.load(Ordering::Relaxed) {
                    continue;
                }
                // SAFETY: this worker holds a claimed chunk, so the job is that of this series.
                let job = unsafe { &*self.job.get() };
                // SAFETY: `series` keeps the task alive until every claimed chunk has returned.
                let task = unsafe { &*job.task };
                let end = part(job.chunks[phase].into(), n, list).end - word.back();
                task(worker, phase, if back { end - 1 } else { end - word.left() });
            }
        }
    }

    /// Keeps what a task panicked with, if it is the first, for the caller.
    fn keep(&self, payload: Payload) {
        self.panicked.store(true, Ordering::Relaxed);
        let mut first = self.payload.lock().unwrap_or_else(PoisonError::into_inner);
        if first.is_none() {
            *first = Some(payload);
        } else {
            // To drop it could panic again, here where nobody catches it.
            core::mem::forget(payload);
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

    /// Works until the team ends, or until it is told to `leave`. Never unwinds.
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

/// The chunks of one of so many lists.
fn part(chunks: usize, lists: usize, list: usize) -> Range<usize> {
    (chunks * list).div_ceil(lists)..(chunks * (list + 1)).div_ceil(lists)
}

/// A team of threads that lives as long as the value. When a step is over its workers look out for the next one for up to half a
/// millisecond, offering their cores to others, and then sleep. The manual:
/// [threads and determinism](crate::manual::threads_and_determinism).
pub struct Team {
    shared: Arc<Shared>,
    threads: Vec<JoinHandle<()>>,
    /// Its workers but the caller are threads that join.
    is_hosted: bool,
    /// Of the process that has the threads, the team's own and those that joined: a fork of it has none. 0 until there are some.
    process: AtomicUsize,
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
        let shared = Self::shared(workers);
        let threads: Vec<_> = (1..shared.seats.len())
            .map_while(|worker| {
                let shared = Arc::clone(&shared);
                let name = format!("drystone-{worker}");
                Builder::new().name(name).spawn(move || shared.serve(worker, None)).ok()
            })
            .collect();
        // Where there are no threads there may be no processes either.
        let process = if threads.is_empty() { 0 } else { this_process() };
        for seat in &shared.seats[1..=threads.len()] {
            seat.store(true, Ordering::SeqCst);
        }
        let (process, is_hosted) = (AtomicUsize::new(process), false);
        Self { shared, threads, is_hosted, process, busy: Mutex::new(0) }
    }

    /// A team that starts no threads: of up to `workers`, the caller included, 1 to 256, for hosts that have threads of their own
    /// and lend them by [`Self::join`], for a step or for good. Whoever has joined helps; without anybody the caller works alone.
    /// The result of a step is the same.
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

    /// Lends the calling thread to the team: it works on whatever the team is given, until `leave` is true, which
    /// [`Self::release`] makes it. It returns at once if that is so already, or if there are as many workers as the team is of;
    /// then the answer is false. While there is nothing to do it looks out for work for up to half a millisecond, offering its core
    /// to others, and then sleeps. What a task panics with goes on in the caller, never here.
    ///
    /// The caller, who steps a world, does not join: it is a worker by itself. A thread that never is released never returns.
    pub fn join(&self, leave: &AtomicBool) -> bool {
        let shared = &*self.shared;
        let take = |seat: &&AtomicBool| {
            seat.compare_exchange(false, true, Ordering::SeqCst, Ordering::SeqCst).is_ok()
        };
        // The caller's is the first. Of a team that has threads none is free.
        let mut seats = shared.seats.iter().enumerate().take(self.workers()).skip(1);
        let Some((worker, seat)) = seats.find(|(_, seat)| take(seat)) else { return false };
        self.process.store(this_process(), Ordering::SeqCst);
        shared.guests.fetch_add(1, Ordering::SeqCst);
        shared.serve(worker, Some(leave));
        shared.guests.fetch_sub(1, Ordering::SeqCst);
        seat.store(false, Ordering::SeqCst);
        true
    }

    /// Makes `leave` true, and lets the threads go that [joined](Self::join) with it: each ends the chunks that it holds first.
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

    /// No thread of its own or of the program's helps: of a team that has none nothing is asked.
    fn is_alone(&self) -> bool {
        self.threads.is_empty() && self.shared.guests.load(Ordering::SeqCst) == 0
    }

    /// The threads are there: they are of this process, which is no fork of the one that has them. Asks the system (0.1 µs).
    fn has_threads(&self) -> bool {
        !self.is_alone() && self.process.load(Ordering::SeqCst) == this_process()
    }
}

/// The number of this process.
fn this_process() -> usize {
    // There they have none, and asking would panic.
    if cfg!(target_family = "wasm") { 0 } else { std::process::id() as usize }
}

impl Executor for Team {
    fn known(&self, _: known::Ask) -> known::Known<'_> {
        known::Known::Team(self)
    }

    fn workers(&self) -> usize {
        // Of a team that threads join, as many as may.
        if self.is_hosted { self.shared.seats.len() } else { self.threads.len() + 1 }
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
        let (first, phases) = (range.start, range.len());
        // Asked for once: what the caller gives is also the caller's to change.
        let mut counts = [0_u16; PHASES];
        for (count, phase) in counts.iter_mut().zip(range) {
            *count = u16::try_from(chunks(phase).min(MOST)).expect("at most MOST");
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
        // From `publish` on until all chunks have returned nothing unwinds: `work` catches what tasks panic with.
        shared.work(0, epoch, phases);
        shared.wait(epoch, phases - 1);
        if shared.panicked.load(Ordering::Relaxed) {
            shared.panicked.store(false, Ordering::Relaxed);
            let first = shared.payload.lock().unwrap_or_else(PoisonError::into_inner).take();
            drop(guard);
            resume_unwind(first.expect("it is kept when a task panics"));
        }
    }

    /// The right to run a series, unless one runs: the number of the last one.
    fn begin(&self) -> Option<MutexGuard<'_, u32>> {
        match self.busy.try_lock() {
            Ok(guard) => Some(guard),
            Err(TryLockError::Poisoned(error)) => Some(error.into_inner()),
            Err(TryLockError::WouldBlock) => None,
        }
    }

    /// Tells the workers of a series. It stays where it is until all its chunks have returned.
    fn publish(&self, epoch: u32, counts: &[u16], task: &(dyn Fn(usize, usize, usize) + Sync)) {
        let shared = &*self.shared;
        // SAFETY: only the lifetime changes; `series` returns after the last use of the pointer.
        let erased = unsafe {
            core::mem::transmute::<&(dyn Fn(usize, usize, usize) + Sync), &'static Task>(task)
        };
        {
            // SAFETY: the caller is alone with the job: no chunk is claimed between series, nor before the words below are written.
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
            // Of a fork: who would wait for them would wait for ever.
            core::mem::forget(core::mem::take(&mut self.threads));
            return;
        }
        self.shared.quit.store(true, Ordering::SeqCst);
        self.shared.wake_all();
        for thread in self.threads.drain(..) {
            // Workers catch what tasks panic with.
            let _ = thread.join();
        }
    }
}

#[cfg(all(test, drystone_model))]
mod model;

#[cfg(all(test, not(drystone_model)))]
mod tests;
