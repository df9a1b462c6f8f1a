//! Execution of the chunks of a parallel stage: by the caller alone, by this crate's team, or by
//! the user's threads. Also functions that share out work: where chunks are ranges of a slice, each
//! chunk gets its own range.
#![expect(unsafe_code, reason = "lends each chunk its own items")]

use core::fmt::Debug;
use core::ops::Range;

use super::checked::Checked;
use super::disjoint::{Apart, Rows};
use super::stamps;
use super::team::Team;

/// Runs numbered chunks of work. Implement it to use your own threads.
///
/// The result of a step never depends on the executor: each chunk writes only its own data. A step
/// does not rely on this contract either. It reads the number of workers once (and accepts 1 to
/// 256), and assigns the workers' numbers itself. It ignores a chunk that ran before or does not
/// exist, and has the caller run the remaining chunks when `run` returns. If `run` panics, the
/// caller does the rest of the step, and the panic resumes afterwards. These checks take some 30 ns
/// per chunk; a [`Team`](crate::threads::Team) runs without them.
pub trait Executor: Send + Sync + Debug {
    /// Number of workers, the caller included; at least 1 (with 0 the caller does all the work).
    /// Worker numbers are below it.
    fn workers(&self) -> usize;

    /// Calls `task(worker, chunk)` once for every chunk below `chunks`, on any worker in any order,
    /// and returns when all calls have returned. Two concurrent calls have different workers. For
    /// cache locality, give a worker the same part of the chunks on every call: it then finds the
    /// data of the last step in its own cache. This affects only time.
    fn run(&self, chunks: usize, task: &(dyn Fn(usize, usize) + Sync));

    /// Runs phases that follow one another over the same items. Calls `task(worker, phase, chunk)`
    /// once for every chunk below `chunks(phase)`. The calls of a phase start when all calls of the
    /// previous phase have returned. A step uses this only with a [`Team`](crate::threads::Team);
    /// for other executors it calls [`Self::run`] for each phase.
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

    /// Identifies this crate's own executors, whose contract is guaranteed. Its types cannot be
    /// named outside this crate, so no other executor can claim to be one.
    #[doc(hidden)]
    fn known(&self, _: known::Ask) -> known::Known<'_> {
        known::Known::No
    }
}

/// Distinguishes this crate's own executors from others.
pub(crate) mod known {
    use super::Team;

    /// A token that only this crate can create.
    #[derive(Debug)]
    pub struct Ask(());

    impl Ask {
        pub(crate) const fn new() -> Self {
            Self(())
        }
    }

    /// The kind of an executor.
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

/// The executor of a step: always one that keeps the contract of [`Executor`].
#[derive(Clone, Copy, Debug)]
pub(crate) enum Jobs<'a> {
    /// The caller alone.
    Inline,
    /// The threads of a team.
    Team(&'a Team),
    /// The threads of a user.
    Checked(&'a Checked<'a>),
}

impl Jobs<'_> {
    /// Number of workers, at least 1.
    pub(crate) fn workers(&self) -> usize {
        match self {
            Self::Inline => 1,
            Self::Team(team) => team.workers(),
            Self::Checked(checked) => checked.workers(),
        }
    }

    /// Like [`Executor::run`].
    fn run(&self, chunks: usize, task: impl Fn(usize, usize) + Sync) {
        let phase = stamps::phases(1);
        let task = |worker, chunk| stamps::within(phase, chunk, || task(worker, chunk));
        match self {
            Self::Inline => (0..chunks).for_each(|chunk| task(0, chunk)),
            Self::Team(team) => team.run(chunks, &task),
            Self::Checked(checked) => checked.run(chunks, &task),
        }
    }

    /// Like [`Executor::run_in_series`].
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

    /// Returns whether the caller is alone and need not split its work; debug builds split it, to
    /// check the claims of chunks.
    #[inline]
    fn is_alone(&self) -> bool {
        self.workers() <= 1 && stamps::is_in_chunk()
    }
}

/// Range of chunk `chunk` when `n` items are split into pieces of `grain`.
fn range_of(chunk: usize, grain: usize, n: usize) -> Range<usize> {
    chunk * grain..((chunk + 1) * grain).min(n)
}

/// Returns a piece size of at least `minimum` that gives every worker a few pieces to claim.
///
/// Use it only if the result does not depend on the piece boundaries: these depend on the workers.
pub(crate) fn grain(jobs: &Jobs<'_>, n: usize, minimum: usize) -> usize {
    n.div_ceil(jobs.workers() * 4).max(minimum)
}

/// Like [`grain`], for items whose work may differ by a factor of a hundred: more and smaller
/// pieces, so that no worker has a long last piece.
pub(crate) fn fine_grain(jobs: &Jobs<'_>, n: usize, minimum: usize) -> usize {
    n.div_ceil(jobs.workers() * 16).max(minimum)
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

/// Calls `f` with ranges of about `minimum` indices below `n` or more, a few per worker. A worker
/// gets the same ranges in each phase with the same `n`.
///
/// Use it only if the result does not depend on the range boundaries: these depend on the workers.
pub(crate) fn for_shares(
    jobs: &Jobs<'_>,
    n: usize,
    minimum: usize,
    f: impl Fn(Range<usize>) + Sync,
) {
    for_series(jobs, 1, |_| n, minimum, |_, range| f(range));
}

/// Runs phases as in [`for_shares`], one after the other; phase k covers `items(k)` indices. Calls
/// `f(k, range)`.
pub(crate) fn for_series(
    jobs: &Jobs<'_>,
    phases: usize,
    items: impl Fn(usize) -> usize + Sync,
    minimum: usize,
    f: impl Fn(usize, Range<usize>) + Sync,
) {
    if jobs.is_alone() {
        for phase in (0..phases).filter(|phase| items(*phase) > 0) {
            f(phase, 0..items(phase));
        }
        return;
    }
    let workers = jobs.workers();
    let chunks = |phase| shares(items(phase), minimum, workers);
    jobs.run_in_series(phases, chunks, |_, phase, chunk| {
        let (n, chunks) = (items(phase), chunks(phase));
        f(phase, n * chunk / chunks..n * (chunk + 1) / chunks);
    });
}

/// Number of pieces for `n` items: the same for each worker if there are enough items.
fn shares(n: usize, minimum: usize, workers: usize) -> usize {
    let pieces = n.div_ceil(minimum.max(1)).min(8 * workers);
    if pieces < workers { pieces } else { pieces.next_multiple_of(workers).min(n) }
}

/// Calls `f(worker, index)` for every index below `n`, one chunk per index.
pub(crate) fn for_each(jobs: &Jobs<'_>, n: usize, f: impl Fn(usize, usize) + Sync) {
    if n <= 1 || jobs.is_alone() {
        for i in 0..n {
            f(0, i);
        }
        return;
    }
    jobs.run(n, f);
}

/// Calls each task, and `f(index)` for every index below `n`, in parallel.
pub(crate) fn side_by_side(
    jobs: &Jobs<'_>,
    tasks: &mut [&mut (dyn FnMut() + Send)],
    n: usize,
    f: impl Fn(usize) + Sync,
) {
    let count = tasks.len();
    // SAFETY: each task belongs to one chunk, and `Jobs` runs a chunk once.
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
    // SAFETY: the ranges of chunks are disjoint, and `Jobs` runs a chunk once.
    let rows = Rows::new(items, unsafe { Apart::promise() });
    jobs.run(chunks, |_, chunk| {
        let range = range_of(chunk, grain, n);
        f(range.start, rows.slice(range.clone()));
    });
}

/// Calls `f(k, items)` with the k-th run of `size` items, one chunk per run; the last may be
/// shorter.
pub(crate) fn for_runs<T: Send>(
    jobs: &Jobs<'_>,
    items: &mut [T],
    size: usize,
    f: impl Fn(usize, &mut [T]) + Sync,
) {
    let (n, size) = (items.len(), size.max(1));
    // SAFETY: the ranges of chunks are disjoint, and `Jobs` runs a chunk once.
    let rows = Rows::new(items, unsafe { Apart::promise() });
    for_each(jobs, n.div_ceil(size), |_, k| f(k, rows.slice(range_of(k, size, n))));
}

/// Output of a range of indices; cleared and reused the next time.
pub(crate) trait Output: Default + Send {
    fn clear(&mut self);
}

impl<T: Send> Output for Vec<T> {
    fn clear(&mut self) {
        self.clear();
    }
}

/// Clears all outputs and extends the list to at least `n`.
fn empty<O: Output>(outputs: &mut Vec<O>, n: usize) {
    outputs.resize_with(outputs.len().max(n), O::default);
    for list in outputs {
        list.clear();
    }
}

/// Like [`for_ranges`], with an output for each range. `outputs[k]` belongs to range `k`, so the
/// lists in order equal the output of a serial loop. Calls `f(range, output)`.
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

/// Like [`collect_ranges`], with each worker's own data: `f(own, range, output)`.
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
    // SAFETY: each output belongs to one chunk, and `Jobs` runs a chunk once.
    let lists = Rows::new(outputs.as_mut_slice(), unsafe { Apart::promise() });
    for_each_with(jobs, chunks, workers, |own, chunk| {
        f(own, range_of(chunk, grain, n), lists.row(chunk));
    });
}

/// Like [`for_each`], with each worker's own data: `f(own, index)`.
pub(crate) fn for_each_with<W: Default + Send>(
    jobs: &Jobs<'_>,
    n: usize,
    workers: &mut Vec<W>,
    f: impl Fn(&mut W, usize) + Sync,
) {
    workers.resize_with(workers.len().max(jobs.workers()), W::default);
    for_each_in_buffer(jobs, n, workers, 1, |own, index| f(&mut own[0], index));
}

/// Like [`for_each`], with `size` items of `buffers` for each worker: `f(buffer, index)`.
pub(crate) fn for_each_in_buffer<T: Send>(
    jobs: &Jobs<'_>,
    n: usize,
    buffers: &mut [T],
    size: usize,
    f: impl Fn(&mut [T], usize) + Sync,
) {
    // SAFETY: `Jobs` gives concurrent chunks different workers.
    let buffers = Rows::of_workers(buffers, unsafe { Apart::promise() });
    for_each(jobs, n, |worker, index| f(buffers.slice(worker * size..(worker + 1) * size), index));
}
