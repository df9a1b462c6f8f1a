//! A table that grows piece by piece. Its rows never move, so growth costs no more when the table
//! is large. (A collapsing heap creates ten times as many contacts within a second. As one list
//! that grows by an eighth they were copied seventeen times.)
#![expect(unsafe_code, reason = "shared access to rows that the caller keeps apart")]

use core::cell::UnsafeCell;
use core::ops::Deref;

#[cfg(feature = "serde")]
use serde::ser::SerializeSeq;
#[cfg(feature = "serde")]
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::disjoint::Apart;
#[cfg(debug_assertions)]
use super::stamps;
use crate::base::simd::wide::{prefetch_line, prefetch_lines};

/// Number of rows of a piece. The first piece is shorter while the table is.
const PIECE: usize = 1024;

/// Rows in pieces. An unused row has the default value.
#[derive(Debug, Default)]
pub(crate) struct Pieces<T> {
    pieces: Vec<Box<[UnsafeCell<T>]>>,
    len: usize,
}

// SAFETY: `&Pieces` gives out `&T` only, and no `PieceRows` exists at the same time: it borrows the
// table mutably.
unsafe impl<T: Sync> Sync for Pieces<T> {}

/// Rows own nothing, so a copy of their bits is a valid copy. They are copied as plain memory,
/// since they are most of a world's copy. (Row by row took half as long again.)
impl<T: Clone + Default> Clone for Pieces<T> {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Copies into the existing pieces; surplus pieces stay.
    fn clone_from(&mut self, from: &Self) {
        const { assert!(!core::mem::needs_drop::<T>(), "rows that own something are cloned one by one") };
        for row in from.len..self.len {
            if let Some(row) = self.get_mut(row) {
                *row = T::default();
            }
        }
        self.make_room(from.len.saturating_sub(self.len));
        self.len = from.len;
        let mut left = from.len;
        for (piece, from) in self.pieces.iter_mut().zip(&from.pieces) {
            let n = left.min(from.len());
            let (from, to) = (&from[..n], &mut piece[..n]);
            // SAFETY: two slices of `n` rows, disjoint since one is borrowed mutably. Rows can be
            // cloned and own nothing, so their bits are independent values. Nobody writes to `from`
            // while it is borrowed: see `Sync`.
            unsafe { core::ptr::copy_nonoverlapping(from.as_ptr(), to.as_mut_ptr(), n) };
            left -= n;
        }
    }
}

/// Serializes a list of the rows.
#[cfg(feature = "serde")]
impl<T: Default + Serialize> Serialize for Pieces<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut list = serializer.serialize_seq(Some(self.len))?;
        self.iter().try_for_each(|row| list.serialize_element(row))?;
        list.end()
    }
}

#[cfg(feature = "serde")]
impl<'de, T: Default + Deserialize<'de>> Deserialize<'de> for Pieces<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let rows = Vec::<T>::deserialize(deserializer)?;
        let mut table = Self::default();
        table.make_room(rows.len());
        for (i, row) in rows.into_iter().enumerate() {
            table.push_default();
            if let Some(place) = table.get_mut(i) {
                *place = row;
            }
        }
        Ok(table)
    }
}

impl<T: Default> Pieces<T> {
    pub(crate) const fn len(&self) -> usize {
        self.len
    }

    #[inline]
    pub(crate) fn get(&self, i: usize) -> Option<&T> {
        let cell = self.pieces.get(i / PIECE)?.get(i % PIECE)?;
        // SAFETY: nobody writes while `self` is borrowed: see `Sync`.
        Some(unsafe { &*cell.get() })
    }

    #[inline]
    pub(crate) fn get_mut(&mut self, i: usize) -> Option<&mut T> {
        Some(self.pieces.get_mut(i / PIECE)?.get_mut(i % PIECE)?.get_mut())
    }

    /// Iterates over the rows in order.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &T> {
        (0..self.len).filter_map(|i| self.get(i))
    }

    /// Appends a default row.
    pub(crate) fn push_default(&mut self) {
        self.make_room(1);
        self.len += 1;
    }

    /// Reserves space for `more` rows.
    pub(crate) fn make_room(&mut self, more: usize) {
        let needed = self.len + more;
        let empty = |n: usize| (0..n).map(|_| UnsafeCell::default());
        match self.pieces.first_mut() {
            None if needed > 0 => {
                self.pieces.push(empty(needed.clamp(8, PIECE)).collect());
            }
            Some(first) if first.len() < needed.min(PIECE) => {
                let room = needed.max(2 * first.len()).min(PIECE);
                let rows = core::mem::take(first).into_vec();
                let new = empty(room - rows.len());
                *first = rows.into_iter().chain(new).collect();
            }
            _ => {}
        }
        while self.pieces.len() * PIECE < needed && needed > PIECE {
            self.pieces.push(empty(PIECE).collect());
        }
    }

    /// Returns row `i`, which must exist.
    #[inline(always)]
    pub(crate) fn read(&self, i: usize) -> &T {
        // SAFETY: nobody writes while `self` is borrowed: see `Sync`.
        unsafe { &*self.pieces[i / PIECE][i % PIECE].get() }
    }

    /// Prefetches the first cache line and one other of row `i`, if there is such a row. Affects
    /// only time.
    #[inline(always)]
    pub(crate) fn prefetch_line(&self, i: usize, line: usize) {
        if let Some(cell) = self.pieces.get(i / PIECE).and_then(|piece| piece.get(i % PIECE)) {
            prefetch_line(cell, 0);
            prefetch_line(cell, line);
        }
    }

    /// Lends the rows to the workers of a phase.
    pub(crate) fn lend(&mut self, _: Apart) -> PieceRows<'_, T> {
        PieceRows(ReadPieceRows {
            pieces: &self.pieces,
            #[cfg(debug_assertions)]
            stamped: !stamps::is_in_chunk(),
        })
    }
}

/// Like [`ReadRows`](super::disjoint::ReadRows), for a table in pieces.
#[derive(Debug)]
pub(crate) struct ReadPieceRows<'a, T> {
    pieces: &'a [Box<[UnsafeCell<T>]>],
    #[cfg(debug_assertions)]
    stamped: bool,
}

/// Like [`Rows`](super::disjoint::Rows), for a table in pieces: see [`Apart::promise`].
#[derive(Debug)]
pub(crate) struct PieceRows<'a, T>(ReadPieceRows<'a, T>);

// SAFETY: a `PieceRows` gives out `&mut T` on other threads, which `T: Send` allows, and `&T` where
// `T: Sync`.
unsafe impl<T: Send> Send for ReadPieceRows<'_, T> {}
// SAFETY: as above; the promise at its construction says that no row is taken twice at a time.
unsafe impl<T: Send> Sync for ReadPieceRows<'_, T> {}

// Written by hand: a derive would require `T: Clone` or `T: Copy`.
impl<T> Clone for ReadPieceRows<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for ReadPieceRows<'_, T> {}

impl<T> Clone for PieceRows<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for PieceRows<'_, T> {}

impl<'a, T> Deref for PieceRows<'a, T> {
    type Target = ReadPieceRows<'a, T>;

    #[inline(always)]
    fn deref(&self) -> &ReadPieceRows<'a, T> {
        &self.0
    }
}

impl<T> PieceRows<'_, T> {
    /// Returns row `i`.
    #[inline(always)]
    #[expect(clippy::mut_from_ref, reason = "who made it promised that rows are kept apart")]
    pub(crate) fn row(&self, i: usize) -> &mut T {
        let cell = &self.pieces[i / PIECE][i % PIECE];
        #[cfg(debug_assertions)]
        if self.stamped {
            stamps::claim(cell.get(), i);
        }
        // SAFETY: nobody else holds row `i`: promised when `self` was made.
        unsafe { &mut *cell.get() }
    }
}

impl<T> ReadPieceRows<'_, T> {
    /// Returns row `i` for reading: one of the caller's own, or one that nobody writes in this
    /// phase.
    #[inline(always)]
    pub(crate) fn read(&self, i: usize) -> &T
    where
        T: Sync,
    {
        let cell = &self.pieces[i / PIECE][i % PIECE];
        #[cfg(debug_assertions)]
        if self.stamped {
            stamps::look(cell.get(), i);
        }
        // SAFETY: nobody writes row `i` now: promised when `self` was made.
        unsafe { &*cell.get() }
    }

    /// Prefetches the first `lines` cache lines of row `i`, if there is such a row. Affects only
    /// time.
    #[inline(always)]
    pub(crate) fn prefetch(&self, i: usize, lines: usize) {
        if let Some(cell) = self.pieces.get(i / PIECE).and_then(|piece| piece.get(i % PIECE)) {
            prefetch_lines(cell, lines);
        }
    }

    /// Prefetches the first cache line, which shows whether the row is empty, and one other.
    #[inline(always)]
    pub(crate) fn prefetch_line(&self, i: usize, line: usize) {
        if let Some(cell) = self.pieces.get(i / PIECE).and_then(|piece| piece.get(i % PIECE)) {
            prefetch_line(cell, 0);
            prefetch_line(cell, line);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{PIECE, Pieces};
    use crate::base::threads::disjoint::Apart;
    use crate::base::threads::jobs::{Jobs, for_ranges};
    use crate::base::threads::team::Team;

    #[test]
    fn rows_stay_where_they_are_and_keep_what_they_have() {
        let mut table = Pieces::<usize>::default();
        assert!(table.get(0).is_none());
        for i in 0..5 * PIECE / 2 {
            table.push_default();
            *table.get_mut(i).unwrap() = i;
        }
        let place = std::ptr::from_ref(table.get(PIECE - 1).unwrap());
        let copy = table.clone();
        let mut other = copy.clone();
        for rows in [7, PIECE, 3 * PIECE] {
            // The surplus rows are empty again, wherever they were.
            let mut small = Pieces::default();
            (0..rows).for_each(|_| small.push_default());
            other.clone_from(&small);
            assert_eq!(other.len(), rows);
            (rows..5 * PIECE / 2).for_each(|_| other.push_default());
            assert!(other.iter().all(|row| *row == 0), "{rows}");
            other.clone_from(&copy);
            assert!(other.iter().copied().eq(0..copy.len()), "{rows}");
        }
        table.make_room(10 * PIECE);
        assert_eq!(std::ptr::from_ref(table.get(PIECE - 1).unwrap()), place);
        assert_eq!(table.len(), 5 * PIECE / 2);
        assert!(table.iter().copied().eq(0..table.len()));
        assert!(copy.iter().copied().eq(0..table.len()));
        assert!(table.get(13 * PIECE).is_none());
    }

    #[test]
    fn a_small_table_is_small() {
        let mut table = Pieces::<u64>::default();
        table.make_room(0);
        assert!(table.pieces.is_empty());
        for n in 1..=100 {
            table.push_default();
            let room: usize = table.pieces.iter().map(|piece| piece.len()).sum();
            assert!(room >= n && room <= (2 * n).max(8), "{n}: {room}");
        }
    }

    #[test]
    fn workers_write_rows_of_their_own() {
        let n = 3 * PIECE + 7;
        let mut table = Pieces::<usize>::default();
        table.make_room(n);
        (0..n).for_each(|_| table.push_default());
        // SAFETY: each row belongs to one range.
        let rows = table.lend(unsafe { Apart::promise() });
        for_ranges(&Jobs::Team(&Team::new(2)), n, 100, |range| {
            for i in range {
                rows.prefetch(i + 64, 1);
                *rows.row(i) = 2 * i;
                assert_eq!(*rows.read(i), 2 * i);
            }
        });
        assert!(table.iter().copied().eq((0..n).map(|i| 2 * i)));
    }
}
