//! Makes executors of users keep the contract of [`Executor`] in any case. A chunk runs once,
//! chunks that run at the same time have different workers, and all have run when a phase ends. The
//! memory safety of the stages depends on this, and a safe trait cannot require it
//! (docs/decisions/028-executors-that-lie.md).

use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};

use super::jobs::{Executor, Jobs};
use super::jobs::{known::Ask, known::Known};

/// Payload of a panic in user code.
type Payload = Box<dyn Any + Send>;

/// Maximum number of workers that a user's executor may report.
const MAX: usize = 256;

/// A worker's number, reserved while a chunk runs. It has cache lines of its own.
#[derive(Debug, Default)]
#[repr(align(128))]
struct Slot(AtomicBool);

/// Claims on chunks and on workers' numbers. A world keeps it, so that a warm step allocates
/// nothing.
#[derive(Debug, Default)]
pub(crate) struct Claims(Mutex<Book>);

#[derive(Debug, Default)]
struct Book {
    /// Round in which each chunk was last claimed.
    rounds: Vec<AtomicU32>,
    /// Number of the running phase; never 0.
    round: u32,
    slots: Vec<Slot>,
    /// Payload if the executor panicked in this step: the caller then does the remaining work.
    panic: Option<Payload>,
}

// A copy of a world has its own chunks.
impl Clone for Claims {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl Claims {
    /// Takes the payload of the executor's panic, if there was one.
    pub(crate) fn take_panic(&mut self) -> Option<Payload> {
        self.0.get_mut().unwrap_or_else(PoisonError::into_inner).panic.take()
    }

    /// Returns the book, unless a phase is running.
    fn open(&self) -> Option<MutexGuard<'_, Book>> {
        match self.0.try_lock() {
            Ok(book) => Some(book),
            Err(TryLockError::Poisoned(error)) => Some(error.into_inner()),
            Err(TryLockError::WouldBlock) => None,
        }
    }
}

impl Book {
    /// Prepares a phase in which no chunk is claimed yet.
    fn begin(&mut self, chunks: usize, workers: usize) {
        if self.rounds.len() < chunks {
            self.rounds.resize_with(chunks, AtomicU32::default);
        }
        if self.slots.len() < workers {
            self.slots.resize_with(workers, Slot::default);
        }
        self.round = self.round.wrapping_add(1);
        if self.round == 0 {
            self.rounds.iter_mut().for_each(|last| *last.get_mut() = 0);
            self.round = 1;
        }
    }
}

/// A reserved worker's number.
struct Claimed<'a> {
    slot: &'a Slot,
    worker: usize,
}

impl<'a> Claimed<'a> {
    /// Reserves a free number, `wanted` if possible; returns `None` if more chunks run than there
    /// are workers.
    fn take(slots: &'a [Slot], wanted: usize) -> Option<Self> {
        let n = slots.len();
        (0..n).map(|k| (wanted % n + k) % n).find_map(|worker| {
            let slot = &slots[worker];
            let is_free = !slot.0.load(Ordering::Relaxed) && !slot.0.swap(true, Ordering::Acquire);
            // Constructed only if the number is free: its drop would release another holder's
            // number.
            is_free.then(|| Self { slot, worker })
        })
    }
}

impl Drop for Claimed<'_> {
    fn drop(&mut self) {
        self.slot.0.store(false, Ordering::Release);
    }
}

/// A user's executor for the duration of a step.
#[derive(Debug)]
pub(crate) struct Checked<'a> {
    executor: &'a dyn Executor,
    workers: usize,
    claims: &'a Claims,
}

impl<'a> Checked<'a> {
    pub(crate) fn new(executor: &'a dyn Executor, claims: &'a Claims) -> Self {
        Self { executor, workers: executor.workers().clamp(1, MAX), claims }
    }

    pub(crate) const fn workers(&self) -> usize {
        self.workers
    }

    /// Returns the executor for the stages: this crate's own directly, others checked.
    pub(crate) fn jobs(&self) -> Jobs<'_> {
        match self.executor.known(Ask::new()) {
            Known::Inline => Jobs::Inline,
            Known::Team(team) => Jobs::Team(team),
            Known::No => Jobs::Checked(self),
        }
    }

    /// Calls `task(worker, chunk)` once for every chunk. The caller runs the chunks that the
    /// executor leaves, or all remaining ones after it panics.
    pub(crate) fn run(&self, chunks: usize, task: &(dyn Fn(usize, usize) + Sync)) {
        let book = if chunks > 1 { self.claims.open() } else { None };
        let Some(mut book) = book.filter(|book| book.panic.is_none()) else {
            (0..chunks).for_each(|chunk| task(0, chunk));
            return;
        };
        book.begin(chunks, self.workers);
        let round = book.round;
        let (rounds, slots) = (&book.rounds[..chunks], &book.slots[..self.workers]);
        let (broken, first) = (AtomicBool::new(false), Mutex::new(None));
        let once = |worker: usize, chunk: usize| {
            let Some(last) = rounds.get(chunk) else { return };
            if last.load(Ordering::Relaxed) == round {
                return;
            }
            let Some(claimed) = Claimed::take(slots, worker) else { return };
            if last.swap(round, Ordering::AcqRel) == round || broken.load(Ordering::Relaxed) {
                return;
            }
            // The executor never sees a panic of a task, since it could swallow it.
            if let Err(payload) = catch_unwind(AssertUnwindSafe(|| task(claimed.worker, chunk))) {
                broken.store(true, Ordering::Relaxed);
                first.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(payload);
            }
        };
        let ran = catch_unwind(AssertUnwindSafe(|| self.executor.run(chunks, &once)));
        if let Some(payload) = first.into_inner().unwrap_or_else(PoisonError::into_inner) {
            resume_unwind(payload);
        }
        // No more calls of `once` happen: it lives no longer than the borrow that `run` received.
        for (chunk, last) in rounds.iter().enumerate() {
            if last.load(Ordering::Relaxed) != round {
                task(0, chunk);
            }
        }
        book.panic = ran.err();
    }
}

#[cfg(test)]
mod tests {
    use core::sync::atomic::{AtomicUsize, Ordering};
    use std::panic::{AssertUnwindSafe, catch_unwind};
    use std::sync::Barrier;

    use super::{Checked, Claimed, Claims, Slot};
    use crate::base::threads::jobs::Executor;
    use crate::base::threads::team::Team;

    /// Runs every chunk on five threads at once, as worker 0.
    #[derive(Debug)]
    struct AllAtOnce;

    impl Executor for AllAtOnce {
        fn workers(&self) -> usize {
            3
        }

        fn run(&self, chunks: usize, task: &(dyn Fn(usize, usize) + Sync)) {
            let go = Barrier::new(5);
            std::thread::scope(|scope| {
                for _ in 0..5 {
                    scope.spawn(|| {
                        go.wait();
                        (0..chunks + 2).for_each(|chunk| task(0, chunk));
                    });
                }
            });
        }
    }

    #[test]
    fn a_number_that_is_held_stays_held() {
        let slots: [Slot; 3] = Default::default();
        let claimed = [2, 2, usize::MAX].map(|wanted| Claimed::take(&slots, wanted).unwrap());
        assert_eq!(claimed.each_ref().map(|claimed| claimed.worker), [2, 0, 1]);
        // A failed reservation releases nothing.
        assert!((0..9).all(|wanted| Claimed::take(&slots, wanted).is_none()));
        drop(claimed);
        assert!(Claimed::take(&slots, 1).is_some_and(|claimed| claimed.worker == 1));
    }

    #[test]
    fn chunks_run_once_and_no_worker_twice_at_a_time() {
        let claims = Claims::default();
        let team = Team::with_threads(4);
        for executor in [&AllAtOnce as &dyn Executor, &team] {
            let checked = Checked::new(executor, &claims);
            for round in 0..200 {
                let counts: Vec<AtomicUsize> =
                    (0..2 + round % 50).map(|_| AtomicUsize::new(0)).collect();
                let busy: Vec<AtomicUsize> = (0..4).map(|_| AtomicUsize::new(0)).collect();
                checked.run(counts.len(), &|worker, chunk| {
                    assert!(worker < checked.workers());
                    assert_eq!(busy[worker].fetch_add(1, Ordering::SeqCst), 0);
                    counts[chunk].fetch_add(1, Ordering::SeqCst);
                    busy[worker].fetch_sub(1, Ordering::SeqCst);
                });
                assert!(counts.iter().all(|n| n.load(Ordering::SeqCst) == 1));
            }
        }
    }

    #[test]
    fn a_panic_of_a_chunk_comes_to_the_caller_whatever_the_executor_does() {
        let claims = Claims::default();
        let checked = Checked::new(&AllAtOnce, &claims);
        for bad in 0..8 {
            let run = || checked.run(8, &|_, chunk| assert!(chunk != bad, "chunk {bad}"));
            let text = catch_unwind(AssertUnwindSafe(run)).unwrap_err();
            assert_eq!(text.downcast_ref(), Some(&format!("chunk {bad}")));
        }
        // Round numbers wrap: no chunk counts as claimed by mistake.
        claims.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner).round = u32::MAX - 3;
        for _ in 0..8 {
            let count = AtomicUsize::new(0);
            checked.run(8, &|_, _| {
                count.fetch_add(1, Ordering::SeqCst);
            });
            assert_eq!(count.into_inner(), 8);
        }
    }
}
