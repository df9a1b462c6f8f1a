//! Who runs the chunks of a parallel stage: the caller alone, our own team, or the user's threads. And how a stage shares out its
//! work: where chunks are ranges of a slice, each is given its own.
#![expect(unsafe_code, reason = "lends each chunk its own items")]

use core::fmt::Debug;
use core::ops::Range;

use super::checked::Checked;
use super::disjoint::{Apart, Rows};
use super::stamps;
use super::team::Team;

/// Runs numbered chunks of work. Bring your own threads by implementing it.
///
/// The result of a step never depends on the executor: chunks write only what is theirs. A step does not rely on what is said here
/// either. It asks once how many workers there are (and believes in 1 to 256), ignores a chunk that was run before or does not
/// exist, gives out the workers' numbers itself, and has the caller run what is left when `run` returns. If `run` panics, the
/// caller does the rest of the step, and the panic goes on when it is over. That takes some 30 ns a chunk, which a
/// [`Team`](crate::threads::Team) is spared.
pub trait Executor: Send + Sync + Debug {
    /// Number of workers, the caller included; at least 1 (with 0 the caller does all the work). Worker numbers are below it.
    fn workers(&self) -> usize;

    /// Calls `task(worker, chunk)` once for every chunk below `chunks`, on any worker in any order,
    /// and returns when all calls have returned. Two calls at one time have different workers. A worker had better get the same
    /// part of the chunks each time, for what it wrote in the last step is in its own cache. Only the time depends on it.
    fn run(&self, chunks: usize, task: &(dyn Fn(usize, usize) + Sync));

    /// Phases that follow one another over the same items: calls `task(worker, phase, chunk)` once for every chunk below
    /// `chunks(phase)`, and those of a phase when all calls of the one before have returned. A step calls it of a
    /// [`Team`](crate::threads::Team) only; of other executors it calls [`Self::run`] for each phase.
    fn run_in_series(
        &self,
        phases: usize,
        chunks: &dyn Fn(usize) -> usize,
        task: &(dyn Fn(usize, usize, usize) + Sync),
    ) {
        for phase in 0..phases {
            self.run(chunks(phase), &|worker, chunk| task(worker, phase, chunk));
        }
    }

    /// Which of this crate's own executors it is, whose contract is known to hold. Its types have no name outside: nobody else can
    /// answer.
    #[doc(hidden)]
    fn known(&self, _: known::Ask) -> known::Known<'_> {
        known::Known::No
    }
}

/// How a step tells this crate's own executors from others.
pub(crate) mod known {
    use super::Team;

    /// Only this crate asks.
    #[derive(Debug)]
    pub struct Ask(());

    impl Ask {
        pub(crate) const fn new() -> Self {
            Self(())
        }
    }

    /// The answer.
    #[derive(Debug)]
    pub enum Known<'a> {
        /// [`super::Inline`].
        Inline,
        /// A team.
        Team(&'a Team),
        /// Another executor.
        No,
    }
}

/// The caller does all the work: no threads, no atomics.
#[derive(Clone, Copy, Debug, Default)]
pub struct Inline;

impl Executor for Inline {
    fn known(&self, _: known::Ask) -> known::Known<'_> {
        known::Known::Inline
    }

    fn workers(&self) -> usize {
        1
    }

    fn run(&self, chunks: usize, task: &(dyn Fn(usize, usize) + Sync)) {
        for chunk in 0..chunks {
            task(0, chunk);
        }
    }
}

/// Who does the work of a step: always somebody who keeps the contract of [`Executor`].
#[derive(Clone, Copy, Debug)]
pub(crate) enum Jobs<'a> {
    /// The caller alone.
    Inline,
    /// Our own threads.
    Team(&'a Team),
    /// Threads of a user.
    Checked(&'a Checked<'a>),
}

impl Jobs<'_> {
    /// At least 1.
    pub(crate) fn workers(&self) -> usize {
        match self {
            Self::Inline => 1,
            Self::Team(team) => team.workers(),
            Self::Checked(checked) => checked.workers(),
        }
    }

    /// As [`Executor::run`].
    fn run(&self, chunks: usize, task: impl Fn(usize, usize) + Sync) {
        let phase = stamps::phases(1);
        let task = |worker, chunk| stamps::within(phase, chunk, || task(worker, chunk));
        match self {
            Self::Inline => (0..chunks).for_each(|chunk| task(0, chunk)),
            Self::Team(team) => team.run(chunks, &task),
            Self::Checked(checked) => checked.run(chunks, &task),
        }
    }

    /// As [`Executor::run_in_series`].
    fn run_in_series(
        &self,
        phases: usize,
        chunks: impl Fn(usize) -> usize,
        task: impl Fn(usize, usize, usize) + Sync,
    ) {
        let first = stamps::phases(phases);
        let task = |worker, phase, chunk| {
            stamps::within(first + phase as u64, chunk, || task(worker, phase, chunk));
        };
        if let Self::Team(team) = self {
            team.run_in_series(phases, &chunks, &task);
            return;
        }
        for phase in 0..phases {
            match self {
                Self::Checked(checked) => {
                    checked.run(chunks(phase), &|worker, chunk| task(worker, phase, chunk));
                }
                _ => (0..chunks(phase)).for_each(|chunk| task(0, phase, chunk)),
            }
        }
    }

    /// The caller is alone, and need not cut its work in pieces; debug builds do, to compare what they take.
    #[inline]
    fn is_alone(&self) -> bool {
        self.workers() <= 1 && stamps::is_in_chunk()
    }
}

/// The bounds of chunk `chunk` when `n` items are cut into pieces of `grain`.
fn range_of(chunk: usize, grain: usize, n: usize) -> Range<usize> {
    chunk * grain..((chunk + 1) * grain).min(n)
}

/// A piece size of at least `least` that gives every worker a few pieces to claim.
///
/// Only results that do not depend on where pieces begin may use it: it depends on the workers.
pub(crate) fn grain(jobs: &Jobs<'_>, n: usize, least: usize) -> usize {
    n.div_ceil(jobs.workers() * 4).max(least)
}

/// The same for items of which one may be a hundred times the work of another: more and smaller pieces, so that no worker
/// has a last one that takes long.
pub(crate) fn fine_grain(jobs: &Jobs<'_>, n: usize, least: usize) -> usize {
    n.div_ceil(jobs.workers() * 16).max(least)
}

/// Calls `f` with every range of at most `grain` indices below `n`.
pub(crate) fn for_ranges(jobs: &Jobs<'_>, n: usize, grain: usize, f: impl Fn(Range<usize>) + Sync) {
    let chunks = n.div_ceil(grain.max(1));
    if chunks <= 1 || jobs.is_alone() {
        if n > 0 {
            f(0..n);
        }
        return;
    }
    jobs.run(chunks, |_, chunk| f(range_of(chunk, grain, n)));
}

/// Calls `f` with ranges of about `least` indices below `n` or more, a few for each worker, the same ones for the same
/// worker in each phase that has so many.
///
/// Only results that do not depend on where ranges begin may use it: it depends on the workers.
pub(crate) fn for_shares(jobs: &Jobs<'_>, n: usize, least: usize, f: impl Fn(Range<usize>) + Sync) {
    for_series(jobs, 1, |_| n, least, |_, range| f(range));
}

/// Phases like that one after the other, phase k over `items(k)` indices: `f(k, range)`.
pub(crate) fn for_series(
    jobs: &Jobs<'_>,
    phases: usize,
    items: impl Fn(usize) -> usize + Sync,
    least: usize,
    f: impl Fn(usize, Range<usize>) + Sync,
) {
    if jobs.is_alone() {
        for phase in (0..phases).filter(|phase| items(*phase) > 0) {
            f(phase, 0..items(phase));
        }
        return;
    }
    let workers = jobs.workers();
    let chunks = |phase| shares(items(phase), least, workers);
    jobs.run_in_series(phases, chunks, |_, phase, chunk| {
        let (n, chunks) = (items(phase), chunks(phase));
        f(phase, n * chunk / chunks..n * (chunk + 1) / chunks);
    });
}

/// In how many pieces `n` items are shared out: as many for each worker if there is enough for all.
fn shares(n: usize, least: usize, workers: usize) -> usize {
    let pieces = n.div_ceil(least.max(1)).min(8 * workers);
    if pieces < workers { pieces } else { pieces.next_multiple_of(workers).min(n) }
}

/// Calls `f(worker, index)` for every index below `n`, each a chunk of its own.
pub(crate) fn for_each(jobs: &Jobs<'_>, n: usize, f: impl Fn(usize, usize) + Sync) {
    if n <= 1 || jobs.is_alone() {
        for i in 0..n {
            f(0, i);
        }
        return;
    }
    jobs.run(n, f);
}

/// Calls each task, and `f(index)` for every index below `n`, side by side.
pub(crate) fn side_by_side(
    jobs: &Jobs<'_>,
    tasks: &mut [&mut (dyn FnMut() + Send)],
    n: usize,
    f: impl Fn(usize) + Sync,
) {
    let count = tasks.len();
    // SAFETY: each task is of one chunk, and `Jobs` runs a chunk once.
    let tasks = Rows::new(tasks, unsafe { Apart::promise() });
    for_each(jobs, count + n, |_, k| match k.checked_sub(count) {
        None => tasks.row(k)(),
        Some(index) => f(index),
    });
}

/// Calls `f(first index, items)` with every run of at most `grain` items.
pub(crate) fn for_items<T: Send>(
    jobs: &Jobs<'_>,
    items: &mut [T],
    grain: usize,
    f: impl Fn(usize, &mut [T]) + Sync,
) {
    let n = items.len();
    let chunks = n.div_ceil(grain.max(1));
    if chunks <= 1 || jobs.is_alone() {
        if n > 0 {
            f(0, items);
        }
        return;
    }
    // SAFETY: the ranges of chunks are apart, and `Jobs` runs a chunk once.
    let rows = Rows::new(items, unsafe { Apart::promise() });
    jobs.run(chunks, |_, chunk| {
        let range = range_of(chunk, grain, n);
        f(range.start, rows.slice(range.clone()));
    });
}

/// Calls `f(k, items)` with the k-th run of `size` items, each a chunk of its own; the last may be shorter.
pub(crate) fn for_runs<T: Send>(
    jobs: &Jobs<'_>,
    items: &mut [T],
    size: usize,
    f: impl Fn(usize, &mut [T]) + Sync,
) {
    let (n, size) = (items.len(), size.max(1));
    // SAFETY: the ranges of chunks are apart, and `Jobs` runs a chunk once.
    let rows = Rows::new(items, unsafe { Apart::promise() });
    for_each(jobs, n.div_ceil(size), |_, k| f(k, rows.slice(range_of(k, size, n))));
}

/// What is found in a range of indices; kept, emptied, for the next time.
pub(crate) trait Output: Default + Send {
    fn clear(&mut self);
}

impl<T: Send> Output for Vec<T> {
    fn clear(&mut self) {
        self.clear();
    }
}

/// Empties all outputs, of which there are at least `n` then.
fn empty<O: Output>(outputs: &mut Vec<O>, n: usize) {
    outputs.resize_with(outputs.len().max(n), O::default);
    for list in outputs {
        list.clear();
    }
}

/// Like [`for_ranges`], with an output for each range: `outputs[k]` belongs to range `k`, so
/// that reading the lists in order gives what a serial loop would have given. Calls `f(range, output)`.
pub(crate) fn collect_ranges<O: Output>(
    jobs: &Jobs<'_>,
    n: usize,
    grain: usize,
    outputs: &mut Vec<O>,
    f: impl Fn(Range<usize>, &mut O) + Sync,
) {
    let grain = grain.max(1);
    let chunks = n.div_ceil(grain);
    empty(outputs, chunks);
    for_runs(jobs, &mut outputs[..chunks], 1, |chunk, list| {
        f(range_of(chunk, grain, n), &mut list[0]);
    });
}

/// The same, with what each worker has of its own: `f(own, range, output)`.
pub(crate) fn collect_ranges_with<W: Default + Send, O: Output>(
    jobs: &Jobs<'_>,
    n: usize,
    grain: usize,
    workers: &mut Vec<W>,
    outputs: &mut Vec<O>,
    f: impl Fn(&mut W, Range<usize>, &mut O) + Sync,
) {
    let grain = grain.max(1);
    let chunks = n.div_ceil(grain);
    empty(outputs, chunks);
    // SAFETY: each output is of one chunk, and `Jobs` runs a chunk once.
    let lists = Rows::new(outputs.as_mut_slice(), unsafe { Apart::promise() });
    for_each_with(jobs, chunks, workers, |own, chunk| {
        f(own, range_of(chunk, grain, n), lists.row(chunk));
    });
}

/// As [`for_each`], with what each worker has of its own: `f(own, index)`.
pub(crate) fn for_each_with<W: Default + Send>(
    jobs: &Jobs<'_>,
    n: usize,
    workers: &mut Vec<W>,
    f: impl Fn(&mut W, usize) + Sync,
) {
    workers.resize_with(workers.len().max(jobs.workers()), W::default);
    for_each_in_room(jobs, n, workers, 1, |own, index| f(&mut own[0], index));
}

/// As [`for_each`], with `size` items for each worker, of which there must be as many: `f(room, index)`.
pub(crate) fn for_each_in_room<T: Send>(
    jobs: &Jobs<'_>,
    n: usize,
    rooms: &mut [T],
    size: usize,
    f: impl Fn(&mut [T], usize) + Sync,
) {
    // SAFETY: `Jobs` gives chunks that run at one time different workers.
    let rooms = Rows::of_workers(rooms, unsafe { Apart::promise() });
    for_each(jobs, n, |worker, index| f(rooms.slice(worker * size..(worker + 1) * size), index));
}
