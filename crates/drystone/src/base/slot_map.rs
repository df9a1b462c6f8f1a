//! A table of rows at fixed positions, identified by generational ids.

use core::marker::PhantomData;
use core::num::NonZeroU32;

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::grow;
use super::id::RawId;
use super::simd::wide::{prefetch_line, prefetch_lines};

/// Rows of `T` identified by `Id`. A free slot is reused, the last freed first.
#[derive(Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(serialize = "T: Serialize", deserialize = "T: Deserialize<'de>"))
)]
pub(crate) struct SlotMap<Id, T> {
    values: Vec<Option<T>>,
    generations: Vec<NonZeroU32>,
    free: Vec<u32>,
    len: usize,
    #[cfg_attr(feature = "serde", serde(skip))]
    id: PhantomData<fn() -> Id>,
}

impl<Id, T: Clone> Clone for SlotMap<Id, T> {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Copies into the existing lists.
    fn clone_from(&mut self, from: &Self) {
        let Self { values, generations, free, len, id: _ } = from;
        self.values.clone_from(values);
        self.generations.clone_from(generations);
        self.free.clone_from(free);
        self.len = *len;
    }
}

impl<Id, T> Default for SlotMap<Id, T> {
    fn default() -> Self {
        Self {
            values: Vec::new(),
            generations: Vec::new(),
            free: Vec::new(),
            len: 0,
            id: PhantomData,
        }
    }
}

impl<Id, T> SlotMap<Id, T> {
    /// Its parts: slots, their generations, free slots, number of slots in use.
    pub(crate) fn parts(&self) -> (&[Option<T>], &[NonZeroU32], &[u32], usize) {
        (&self.values, &self.generations, &self.free, self.len)
    }
}

impl<Id: From<RawId> + Into<RawId> + Copy, T> SlotMap<Id, T> {
    pub(crate) fn insert(&mut self, value: T) -> Id {
        self.len += 1;
        if let Some(index) = self.free.pop() {
            self.values[index as usize] = Some(value);
            return RawId::new(index, self.generations[index as usize]).into();
        }
        let index = u32::try_from(self.values.len()).expect("fewer than 2^32 rows fit in memory");
        grow::push(&mut self.values, Some(value));
        grow::push(&mut self.generations, NonZeroU32::MIN);
        RawId::new(index, NonZeroU32::MIN).into()
    }

    pub(crate) fn remove(&mut self, id: Id) -> Option<T> {
        let row = self.row(id)?;
        let value = self.values[row as usize].take()?;
        self.len -= 1;
        // A slot that has used all generations is retired: its ids must never recur.
        if let Some(next) = self.generations[row as usize].checked_add(1) {
            self.generations[row as usize] = next;
            self.free.push(row);
        }
        Some(value)
    }

    /// Returns the row of `id`, if its object lives.
    pub(crate) fn row(&self, id: Id) -> Option<u32> {
        let raw: RawId = id.into();
        let generation = self.generations.get(raw.index() as usize)?;
        let lives = *generation == raw.generation() && self.at(raw.index()).is_some();
        lives.then_some(raw.index())
    }

    /// Returns the row in a slot, whatever its generation.
    #[inline]
    pub(crate) fn at(&self, index: u32) -> Option<&T> {
        self.values.get(index as usize)?.as_ref()
    }

    /// Prefetches the first cache lines of a slot. Affects only time.
    #[inline(always)]
    pub(crate) fn prefetch(&self, index: u32, lines: usize) {
        if let Some(slot) = self.values.get(index as usize) {
            prefetch_lines(slot, lines);
        }
    }

    /// Prefetches one cache line of a slot.
    #[inline(always)]
    pub(crate) fn prefetch_line(&self, index: u32, line: usize) {
        if let Some(slot) = self.values.get(index as usize) {
            prefetch_line(slot, line);
        }
    }

    #[inline]
    pub(crate) fn at_mut(&mut self, index: u32) -> Option<&mut T> {
        self.values.get_mut(index as usize)?.as_mut()
    }

    /// Returns the id of the object in a slot.
    pub(crate) fn id_at(&self, index: u32) -> Option<Id> {
        self.at(index)?;
        Some(RawId::new(index, self.generations[index as usize]).into())
    }

    /// Returns the id of a slot that is in use, without checking it.
    #[inline]
    pub(crate) fn id_of(&self, index: u32) -> Id {
        RawId::new(index, self.generations[index as usize]).into()
    }

    pub(crate) const fn len(&self) -> usize {
        self.len
    }

    pub(crate) const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// All slots, for stages that lend rows to workers.
    pub(crate) fn values_mut(&mut self) -> &mut [Option<T>] {
        &mut self.values
    }

    /// Number of slots, free ones included.
    pub(crate) const fn slot_count(&self) -> usize {
        self.values.len()
    }

    /// Iterates over the rows in slot order.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (Id, &T)> {
        (0_u32..).zip(&self.values).zip(&self.generations).filter_map(
            |((index, value), generation)| {
                value.as_ref().map(|v| (RawId::new(index, *generation).into(), v))
            },
        )
    }
}

#[cfg(test)]
mod tests {
    use super::SlotMap;
    use crate::base::id::BodyId;

    #[test]
    fn a_stale_id_finds_nothing_even_when_its_slot_is_reused() {
        let mut map = SlotMap::<BodyId, i32>::default();
        let a = map.insert(1);
        assert_eq!(map.remove(a), Some(1));
        let b = map.insert(2);
        assert_eq!(a.index(), b.index());
        assert_eq!(map.remove(a), None);
        assert_eq!((map.row(a), map.at(b.index()), map.len()), (None, Some(&2), 1));
    }
}
