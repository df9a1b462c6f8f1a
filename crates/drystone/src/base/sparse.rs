//! A number for some rows of a table.

use super::grow;
use super::threads::disjoint::{Apart, Rows};

/// A number for each row of a table where most rows have none, given as [`u32::MAX`]. The memory of
/// these rows stays untouched, so a world of a million bodies of which a hundred move need not wait
/// for it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sparse {
    /// Complements of the numbers, so that zeroed memory means none.
    inverted: Vec<u32>,
}

impl Sparse {
    /// Extends the list to the rows of a table.
    pub(crate) fn cover(&mut self, rows: usize) {
        grow::zeros(&mut self.inverted, rows);
    }

    /// The number of a row.
    #[inline]
    pub(crate) fn get(&self, row: u32) -> u32 {
        !self.inverted[row as usize]
    }

    /// Sets the number of a row; returns the previous one.
    #[inline]
    pub(crate) fn set(&mut self, row: u32, number: u32) -> u32 {
        !core::mem::replace(&mut self.inverted[row as usize], !number)
    }

    /// Lends all numbers to workers.
    pub(crate) fn lend(&mut self, apart: Apart) -> SparseRows<'_> {
        SparseRows { inverted: Rows::new(&mut self.inverted, apart) }
    }
}

/// The numbers of all rows; no two workers of one phase use the same row.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SparseRows<'a> {
    inverted: Rows<'a, u32>,
}

impl SparseRows<'_> {
    /// The number of a row.
    #[inline]
    pub(crate) fn get(&self, row: u32) -> u32 {
        !*self.inverted.read(row as usize)
    }

    /// Sets the number of a row.
    #[inline]
    pub(crate) fn set(&self, row: u32, number: u32) {
        *self.inverted.row(row as usize) = !number;
    }
}

#[cfg(test)]
mod tests {
    use super::Sparse;

    const NOTHING: u32 = u32::MAX;

    #[test]
    fn rows_keep_their_numbers_when_there_are_more() {
        let mut sparse = Sparse::default();
        sparse.cover(10);
        assert_eq!((sparse.get(9), sparse.set(9, 7), sparse.set(9, 0)), (NOTHING, NOTHING, 7));
        sparse.cover(1000);
        assert_eq!((sparse.get(9), sparse.get(10), sparse.get(999)), (0, NOTHING, NOTHING));
        assert_eq!((sparse.set(9, NOTHING), sparse.get(9)), (0, NOTHING));
    }
}
