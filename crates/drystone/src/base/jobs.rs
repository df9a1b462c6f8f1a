//! Who runs the chunks of a parallel stage: the caller alone, our own team, or the user's threads.

use core::fmt::Debug;
use core::ops::Range;

use super::disjoint::Rows;

/// Runs numbered chunks of work. Bring your own threads by implementing it.
///
/// The result of a step never depends on the executor: chunks write only what is theirs.
pub trait Executor: Send + Sync + Debug {
    /// Number of workers, the caller included; at least 1 (with 0 the caller does all the work). Worker numbers are below it.
    fn workers(&self) -> usize;

    /// Calls `task(worker, chunk)` once for every chunk below `chunks`, on any worker in any order,
    /// and returns when all calls have returned. Two calls at one time have different workers. A worker had better get the same
    /// part of the chunks each time, for what it wrote in the last step is in its own cache. Only the time depends on it.
    fn run(&self, chunks: usize, task: &(dyn Fn(usize, usize) + Sync));

    /// Phases that follow one another over the same items: calls `task(worker, phase, chunk)` once for every chunk below
    /// `chunks(phase)`, and those of a phase when all calls of the one before have returned.
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
}

/// The caller does all the work: no threads, no atomics.
#[derive(Clone, Copy, Debug, Default)]
pub struct Inline;

impl Executor for Inline {
    fn workers(&self) -> usize {
        1
    }

    fn run(&self, chunks: usize, task: &(dyn Fn(usize, usize) + Sync)) {
        for chunk in 0..chunks {
            task(0, chunk);
        }
    }
}

/// The bounds of chunk `chunk` when `n` items are cut into pieces of `grain`.
fn range_of(chunk: usize, grain: usize, n: usize) -> Range<usize> {
    chunk * grain..((chunk + 1) * grain).min(n)
}

/// A piece size of at least `least` that gives every worker a few pieces to claim.
///
/// Only results that do not depend on where pieces begin may use it: it depends on the workers.
pub(crate) fn grain(jobs: &dyn Executor, n: usize, least: usize) -> usize {
    n.div_ceil(jobs.workers() * 4).max(least)
}

/// The same for items of which one may be a hundred times the work of another: more and smaller pieces, so that no worker
/// has a last one that takes long.
pub(crate) fn fine_grain(jobs: &dyn Executor, n: usize, least: usize) -> usize {
    n.div_ceil(jobs.workers() * 16).max(least)
}

/// Calls `f` with every range of at most `grain` indices below `n`.
pub(crate) fn for_ranges(
    jobs: &dyn Executor,
    n: usize,
    grain: usize,
    f: impl Fn(Range<usize>) + Sync,
) {
    let chunks = n.div_ceil(grain.max(1));
    if chunks <= 1 || jobs.workers() <= 1 {
        if n > 0 {
            f(0..n);
        }
        return;
    }
    jobs.run(chunks, &|_, chunk| f(range_of(chunk, grain, n)));
}

/// Calls `f` with ranges of about `least` indices below `n` or more, a few for each worker, the same ones for the same
/// worker in each phase that has so many.
///
/// Only results that do not depend on where ranges begin may use it: it depends on the workers.
pub(crate) fn for_shares(
    jobs: &dyn Executor,
    n: usize,
    least: usize,
    f: impl Fn(Range<usize>) + Sync,
) {
    for_series(jobs, 1, |_| n, least, |_, range| f(range));
}

/// Phases like that one after the other, phase k over `items(k)` indices: `f(k, range)`.
pub(crate) fn for_series(
    jobs: &dyn Executor,
    phases: usize,
    items: impl Fn(usize) -> usize + Sync,
    least: usize,
    f: impl Fn(usize, Range<usize>) + Sync,
) {
    let workers = jobs.workers();
    if workers <= 1 {
        for phase in (0..phases).filter(|phase| items(*phase) > 0) {
            f(phase, 0..items(phase));
        }
        return;
    }
    let chunks = |phase| shares(items(phase), least, workers);
    jobs.run_in_series(phases, &chunks, &|_, phase, chunk| {
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
pub(crate) fn for_each(jobs: &dyn Executor, n: usize, f: impl Fn(usize, usize) + Sync) {
    if n <= 1 || jobs.workers() <= 1 {
        for i in 0..n {
            f(0, i);
        }
        return;
    }
    jobs.run(n, &f);
}

/// Calls each task, and `f(index)` for every index below `n`, side by side.
pub(crate) fn side_by_side(
    jobs: &dyn Executor,
    tasks: &mut [&mut (dyn FnMut() + Send)],
    n: usize,
    f: impl Fn(usize) + Sync,
) {
    let count = tasks.len();
    let tasks = Rows::new(tasks);
    for_each(jobs, count + n, |_, k| match k.checked_sub(count) {
        None => tasks.row(k)(),
        Some(index) => f(index),
    });
}

/// Calls `f(first index, items)` with every run of at most `grain` items.
pub(crate) fn for_items<T: Send>(
    jobs: &dyn Executor,
    items: &mut [T],
    grain: usize,
    f: impl Fn(usize, &mut [T]) + Sync,
) {
    let n = items.len();
    let chunks = n.div_ceil(grain.max(1));
    if chunks <= 1 || jobs.workers() <= 1 {
        if n > 0 {
            f(0, items);
        }
        return;
    }
    let rows = Rows::new(items);
    jobs.run(chunks, &|_, chunk| {
        let range = range_of(chunk, grain, n);
        f(range.start, rows.slice(range.clone()));
    });
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

/// Like [`for_ranges`], with an output for each range: `outputs[k]` belongs to range `k`, so
/// that reading the lists in order gives what a serial loop would have given. Calls `f(worker, range, output)`.
pub(crate) fn collect_ranges<O: Output>(
    jobs: &dyn Executor,
    n: usize,
    grain: usize,
    outputs: &mut Vec<O>,
    f: impl Fn(usize, Range<usize>, &mut O) + Sync,
) {
    let grain = grain.max(1);
    let chunks = n.div_ceil(grain);
    outputs.resize_with(outputs.len().max(chunks), O::default);
    for list in outputs.iter_mut() {
        list.clear();
    }
    if jobs.workers() <= 1 {
        for (chunk, list) in outputs.iter_mut().enumerate().take(chunks) {
            f(0, range_of(chunk, grain, n), list);
        }
        return;
    }
    let rows = Rows::new(outputs.as_mut_slice());
    jobs.run(chunks, &|worker, chunk| f(worker, range_of(chunk, grain, n), rows.row(chunk)));
}
