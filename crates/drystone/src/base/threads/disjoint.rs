//! A slice that several workers write at once, each its own rows. No compiler can check that the
//! rows are disjoint. The code that lends rows promises it with [`Apart::promise`], the only
//! `unsafe` outside this folder.
#![expect(unsafe_code, reason = "shared access to rows that the caller keeps apart")]

use core::marker::PhantomData;
use core::ops::{Deref, Range};

#[cfg(debug_assertions)]
use super::stamps;

/// A stage's promise that concurrent chunks use disjoint rows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Apart(());

impl Apart {
    /// Makes the promise. Debug builds check its first part (`base/threads/stamps.rs`).
    ///
    /// # Safety
    /// This must hold for every table lent with it, as long as it is lent. If a chunk takes a row
    /// (`row`, `slice`), no other chunk of that phase takes or reads the row. A reference to a row
    /// has ended before the same row is taken or read again. Parallel stages guarantee this by
    /// giving each chunk its own rows, the solver by coloring (ARCHITECTURE.md, invariant 5).
    pub(crate) const unsafe fn promise() -> Self {
        Self(())
    }
}

/// Rows lent to the workers of one phase, to be read: see [`Rows`].
#[derive(Debug)]
pub(crate) struct ReadRows<'a, T> {
    first: *mut T,
    len: usize,
    /// Whether claims are checked; not for rows that belong to one chunk or one worker.
    #[cfg(debug_assertions)]
    stamped: bool,
    lent: PhantomData<&'a mut [T]>,
}

/// Rows lent to the workers of one phase, to be read and written: see [`Apart::promise`].
///
/// Code that only reads takes [`ReadRows`], to which a reference to rows converts.
#[derive(Debug)]
pub(crate) struct Rows<'a, T>(ReadRows<'a, T>);

// SAFETY: a `Rows` gives out `&mut T` on other threads, which `T: Send` allows, and `&T` where `T:
// Sync`.
unsafe impl<T: Send> Send for ReadRows<'_, T> {}
// SAFETY: as above; the promise at its construction says that no row is taken twice at a time.
unsafe impl<T: Send> Sync for ReadRows<'_, T> {}

// Written by hand: a derive would require `T: Clone` or `T: Copy`.
impl<T> Clone for ReadRows<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for ReadRows<'_, T> {}

impl<T> Clone for Rows<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Rows<'_, T> {}

impl<'a, T> Deref for Rows<'a, T> {
    type Target = ReadRows<'a, T>;

    #[inline(always)]
    fn deref(&self) -> &ReadRows<'a, T> {
        &self.0
    }
}

impl<'a, T> Rows<'a, T> {
    #[inline]
    pub(crate) fn new(items: &'a mut [T], _: Apart) -> Self {
        Self(ReadRows {
            first: items.as_mut_ptr(),
            len: items.len(),
            #[cfg(debug_assertions)]
            stamped: !stamps::is_in_chunk(),
            lent: PhantomData,
        })
    }

    /// One row per worker: successive chunks use the same row.
    pub(crate) fn of_workers(items: &'a mut [T], apart: Apart) -> Self {
        #[cfg(debug_assertions)]
        return Self(ReadRows { stamped: false, ..Self::new(items, apart).0 });
        #[cfg(not(debug_assertions))]
        Self::new(items, apart)
    }

    /// Returns row `i`.
    #[inline(always)]
    #[expect(clippy::mut_from_ref, reason = "who made it promised that rows are kept apart")]
    pub(crate) fn row(&self, i: usize) -> &mut T {
        assert!(i < self.len);
        // SAFETY: `i` is in bounds, checked above.
        let row = unsafe { self.first.add(i) };
        #[cfg(debug_assertions)]
        if self.stamped {
            stamps::claim(row, i);
        }
        // SAFETY: nobody else holds row `i`: promised when `self` was made.
        unsafe { &mut *row }
    }

    /// Returns the rows of `range`.
    #[inline]
    #[expect(clippy::mut_from_ref, reason = "who made it promised that rows are kept apart")]
    pub(crate) fn slice(&self, range: Range<usize>) -> &mut [T] {
        assert!(range.start <= range.end && range.end <= self.len);
        // SAFETY: the range is in bounds, checked above.
        let first = unsafe { self.first.add(range.start) };
        #[cfg(debug_assertions)]
        if self.stamped {
            // Long ranges are only sampled: a full check would take longer than the work on them.
            for i in range.clone().step_by(range.len() / 256 + 1) {
                stamps::claim(self.first.wrapping_add(i), i);
            }
        }
        // SAFETY: nobody else holds these rows: promised when `self` was made.
        unsafe { core::slice::from_raw_parts_mut(first, range.len()) }
    }
}

impl<'a, T> ReadRows<'a, T> {
    /// Returns row `i` for reading: one of the caller's own, or one that nobody writes in this
    /// phase.
    #[inline(always)]
    pub(crate) fn read(&self, i: usize) -> &T
    where
        T: Sync,
    {
        assert!(i < self.len);
        // SAFETY: `i` is in bounds, checked above.
        let row = unsafe { self.first.add(i) };
        #[cfg(debug_assertions)]
        if self.stamped {
            stamps::look(row, i);
        }
        // SAFETY: nobody writes row `i` now: promised when `self` was made.
        unsafe { &*row }
    }

    /// Prefetches the first `lines` cache lines of row `i`, if there is such a row. Affects only
    /// time.
    #[inline(always)]
    pub(crate) fn prefetch(&self, i: usize, lines: usize) {
        (0..lines).for_each(|line| self.prefetch_line(i, line));
    }

    /// Prefetches one cache line of row `i`.
    #[inline(always)]
    pub(crate) fn prefetch_line(&self, i: usize, line: usize) {
        #[cfg(target_arch = "x86_64")]
        {
            use core::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
            let line = self.first.wrapping_add(i).cast::<i8>().wrapping_add(64 * line);
            // SAFETY: a prefetch reads nothing and faults at no address; every x86-64 has SSE.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(line) };
        }
        #[cfg(not(target_arch = "x86_64"))]
        let _ = (i, line);
    }

    /// Returns the row behind row `i`, for prefetching.
    #[inline(always)]
    pub(crate) const fn after(&self, i: usize) -> Next<'a, T> {
        Next { rows: *self, row: i + 1 }
    }
}

/// The next row, if there is one, to be prefetched piece by piece. A core has at most ten to twenty
/// outstanding cache lines, and stalls on more.
#[derive(Debug)]
pub(crate) struct Next<'a, T> {
    rows: ReadRows<'a, T>,
    row: usize,
}

impl<T> Clone for Next<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Next<'_, T> {}

impl<T> Next<'_, T> {
    /// Prefetches some of its cache lines. Affects only time.
    #[inline(always)]
    pub(crate) fn prefetch(&self, lines: Range<usize>) {
        lines.for_each(|line| self.rows.prefetch_line(self.row, line));
    }
}
