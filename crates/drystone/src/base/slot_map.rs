//! A table whose rows keep their place and are named by generational ids.

use core::marker::PhantomData;
use core::num::NonZeroU32;

use super::id::RawId;

#[derive(Clone, Debug)]
struct Slot<T> {
    generation: NonZeroU32,
    value: Option<T>,
}

/// Rows of `T` named by `Id`. A freed slot is reused, last freed first.
#[derive(Clone, Debug)]
pub(crate) struct SlotMap<Id, T> {
    slots: Vec<Slot<T>>,
    free: Vec<u32>,
    len: usize,
    id: PhantomData<fn() -> Id>,
}

impl<Id, T> Default for SlotMap<Id, T> {
    fn default() -> Self {
        Self { slots: Vec::new(), free: Vec::new(), len: 0, id: PhantomData }
    }
}

impl<Id: From<RawId> + Into<RawId> + Copy, T> SlotMap<Id, T> {
    pub(crate) fn insert(&mut self, value: T) -> Id {
        self.len += 1;
        if let Some(index) = self.free.pop() {
            let slot = &mut self.slots[index as usize];
            slot.value = Some(value);
            return RawId::new(index, slot.generation).into();
        }
        let index = u32::try_from(self.slots.len()).expect("fewer than 2^32 rows fit in memory");
        self.slots.push(Slot { generation: NonZeroU32::MIN, value: Some(value) });
        RawId::new(index, NonZeroU32::MIN).into()
    }

    pub(crate) fn remove(&mut self, id: Id) -> Option<T> {
        let raw: RawId = id.into();
        let slot = self.slots.get_mut(raw.index() as usize)?;
        if slot.generation != raw.generation() {
            return None;
        }
        let value = slot.value.take()?;
        self.len -= 1;
        // A slot whose generations are used up is retired: its ids must never come back.
        if let Some(next) = slot.generation.checked_add(1) {
            slot.generation = next;
            self.free.push(raw.index());
        }
        Some(value)
    }

    pub(crate) fn get(&self, id: Id) -> Option<&T> {
        let raw: RawId = id.into();
        let slot = self.slots.get(raw.index() as usize)?;
        if slot.generation == raw.generation() { slot.value.as_ref() } else { None }
    }

    pub(crate) fn get_mut(&mut self, id: Id) -> Option<&mut T> {
        let raw: RawId = id.into();
        let slot = self.slots.get_mut(raw.index() as usize)?;
        if slot.generation == raw.generation() { slot.value.as_mut() } else { None }
    }

    /// The row in a slot, whatever its generation.
    #[inline]
    pub(crate) fn at(&self, index: u32) -> Option<&T> {
        self.slots.get(index as usize)?.value.as_ref()
    }

    #[inline]
    pub(crate) fn at_mut(&mut self, index: u32) -> Option<&mut T> {
        self.slots.get_mut(index as usize)?.value.as_mut()
    }

    /// The id of what lives in a slot.
    pub(crate) fn id_at(&self, index: u32) -> Option<Id> {
        let slot = self.slots.get(index as usize)?;
        slot.value.as_ref()?;
        Some(RawId::new(index, slot.generation).into())
    }

    pub(crate) const fn len(&self) -> usize {
        self.len
    }

    /// Number of slots, free ones included.
    pub(crate) fn slot_count(&self) -> u32 {
        u32::try_from(self.slots.len()).unwrap_or(u32::MAX)
    }

    /// Rows in slot order.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (Id, &T)> {
        (0_u32..).zip(&self.slots).filter_map(|(index, slot)| {
            slot.value.as_ref().map(|v| (RawId::new(index, slot.generation).into(), v))
        })
    }

    pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = (Id, &mut T)> {
        (0_u32..).zip(&mut self.slots).filter_map(|(index, slot)| {
            let generation = slot.generation;
            slot.value.as_mut().map(|v| (RawId::new(index, generation).into(), v))
        })
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
        assert_eq!((map.get(a), map.get(b), map.len()), (None, Some(&2), 1));
    }
}
