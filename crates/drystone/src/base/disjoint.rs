//! A slice that several workers write at once, each its own rows. That they keep apart no compiler can see: who lends rows says so with
//! [`Apart::promise`], the one `unsafe` that stands outside of this folder.
#![expect(unsafe_code, reason = "shared access to rows that the caller keeps apart")]

use core::marker::PhantomData;
use core::ops::Range;

#[cfg(debug_assertions)]
use super::stamps;

/// The word of a stage that what it lends is kept apart.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Apart(());

impl Apart {
    /// Gives it. Debug builds check the first part of it (`base/stamps.rs`).
    ///
    /// # Safety
    /// Of every table that is lent with it, as long as it is lent: a row that a chunk takes (`row`, `slice`) no other chunk of that phase
    /// takes or reads; and who has taken a row has let go of it before that row is taken or read again. Parallel stages hold that
    /// by giving each chunk its own rows, the solver by coloring (ARCHITECTURE.md, invariant 5).
    pub(crate) const unsafe fn promise() -> Self {
        Self(())
    }
}

/// Rows lent to the workers of one phase: see [`Apart::promise`].
#[derive(Debug)]
pub(crate) struct Rows<'a, T> {
    first: *mut T,
    len: usize,
    /// Claims are compared: not those of rows that are a chunk's or a worker's own.
    #[cfg(debug_assertions)]
    stamped: bool,
    lent: PhantomData<&'a mut [T]>,
}

// SAFETY: a `Rows` gives out `&mut T` on other threads, which `T: Send` allows, and `&T` where `T: Sync`.
unsafe impl<T: Send> Send for Rows<'_, T> {}
// SAFETY: as above; that no row is taken by two at a time was promised when it was made.
unsafe impl<T: Send> Sync for Rows<'_, T> {}

// By hand: a derive would ask that `T` can be copied too.
impl<T> Clone for Rows<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Rows<'_, T> {}

impl<'a, T> Rows<'a, T> {
    #[inline]
    pub(crate) fn new(items: &'a mut [T], _: Apart) -> Self {
        Self {
            first: items.as_mut_ptr(),
            len: items.len(),
            #[cfg(debug_assertions)]
            stamped: !stamps::is_in_chunk(),
            lent: PhantomData,
        }
    }

    /// One row for each worker: chunk after chunk takes the same.
    pub(super) fn of_workers(items: &'a mut [T], apart: Apart) -> Self {
        #[cfg(debug_assertions)]
        return Self { stamped: false, ..Self::new(items, apart) };
        #[cfg(not(debug_assertions))]
        Self::new(items, apart)
    }

    /// Row `i`.
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

    /// Row `i`, to read: one of the caller's own, or one that nobody writes in this phase.
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

    /// Asks for the first `lines` cache lines of row `i`, which will be needed soon, if there is such a
    /// row. Changes nothing but time.
    #[inline(always)]
    pub(crate) fn prefetch(&self, i: usize, lines: usize) {
        (0..lines).for_each(|line| self.prefetch_line(i, line));
    }

    /// And for one of them.
    #[inline(always)]
    pub(crate) fn prefetch_line(&self, i: usize, line: usize) {
        #[cfg(target_arch = "x86_64")]
        {
            use core::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
            let line = self.first.wrapping_add(i).cast::<i8>().wrapping_add(64 * line);
            // SAFETY: a prefetch reads nothing and faults at no address; SSE is there on every x86-64.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(line) };
        }
        #[cfg(not(target_arch = "x86_64"))]
        let _ = (i, line);
    }

    /// What stands behind row `i`.
    #[inline(always)]
    pub(crate) const fn after(&self, i: usize) -> Next<'a, T> {
        Next { rows: *self, row: i + 1 }
    }

    /// Rows `range`.
    #[inline]
    #[expect(clippy::mut_from_ref, reason = "who made it promised that rows are kept apart")]
    pub(crate) fn slice(&self, range: Range<usize>) -> &mut [T] {
        assert!(range.start <= range.end && range.end <= self.len);
        // SAFETY: the range is in bounds, checked above.
        let first = unsafe { self.first.add(range.start) };
        #[cfg(debug_assertions)]
        if self.stamped {
            // Of long ones not all: it would take longer than what is done with them.
            for i in range.clone().step_by(range.len() / 256 + 1) {
                stamps::claim(self.first.wrapping_add(i), i);
            }
        }
        // SAFETY: nobody else holds these rows: promised when `self` was made.
        unsafe { core::slice::from_raw_parts_mut(first, range.len()) }
    }
}

/// The row that is seen to next, if there is one, to be asked for piece by piece: a core waits for no more than ten to
/// twenty cache lines at a time, and stands still with more until they are there.
#[derive(Debug)]
pub(crate) struct Next<'a, T> {
    rows: Rows<'a, T>,
    row: usize,
}

impl<T> Clone for Next<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for Next<'_, T> {}

impl<T> Next<'_, T> {
    /// Asks for some of its cache lines. Changes nothing but time.
    #[inline(always)]
    pub(crate) fn ask(&self, lines: Range<usize>) {
        lines.for_each(|line| self.rows.prefetch_line(self.row, line));
    }
}
