//! Who runs the chunks of a parallel stage: the caller alone, our own team, or the user's threads.

use core::fmt::Debug;
use core::ops::Range;

use super::disjoint::Rows;

/// Runs numbered chunks of work. Bring your own threads by implementing it.
///
/// The result of a step never depends on the executor: chunks write only what is theirs.
pub trait Executor: Send + Sync + Debug {
    /// Number of workers, the caller included; at least 1. Worker numbers are below it.
    fn workers(&self) -> usize;

    /// Calls `task(worker, chunk)` once for every chunk below `chunks`, on any worker in any order,
    /// and returns when all calls have returned. Two calls at one time have different workers.
    fn run(&self, chunks: usize, task: &(dyn Fn(usize, usize) + Sync));

    /// The same, for phases that follow one another over the same items: a worker had better get the same part of the chunks in each,
    /// for what it wrote in the last one is in its own cache. Only the time depends on it.
    fn run_in_shares(&self, chunks: usize, task: &(dyn Fn(usize, usize) + Sync)) {
        self.run(chunks, task);
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

/// Calls `f` with ranges of at least `least` indices below `n` (but the last), a few for each worker, the same ones for the same
/// worker in each phase that has so many.
///
/// Only results that do not depend on where ranges begin may use it: it depends on the workers.
pub(crate) fn for_shares(
    jobs: &dyn Executor,
    n: usize,
    least: usize,
    f: impl Fn(Range<usize>) + Sync,
) {
    let grain = grain(jobs, n, least);
    let chunks = n.div_ceil(grain);
    if chunks <= 1 || jobs.workers() <= 1 {
        if n > 0 {
            f(0..n);
        }
        return;
    }
    jobs.run_in_shares(chunks, &|_, chunk| f(range_of(chunk, grain, n)));
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

/// Like [`for_ranges`], with an output list for each range: `outputs[k]` belongs to range `k`, so
/// that reading the lists in order gives what a serial loop would have given.
pub(crate) fn collect_ranges<T: Send>(
    jobs: &dyn Executor,
    n: usize,
    grain: usize,
    outputs: &mut Vec<Vec<T>>,
    f: impl Fn(Range<usize>, &mut Vec<T>) + Sync,
) {
    let grain = grain.max(1);
    let chunks = n.div_ceil(grain);
    outputs.resize_with(outputs.len().max(chunks), Vec::new);
    for list in outputs.iter_mut() {
        list.clear();
    }
    if jobs.workers() <= 1 {
        for (chunk, list) in outputs.iter_mut().enumerate().take(chunks) {
            f(range_of(chunk, grain, n), list);
        }
        return;
    }
    let rows = Rows::new(outputs.as_mut_slice());
    jobs.run(chunks, &|_, chunk| f(range_of(chunk, grain, n), rows.row(chunk)));
}
