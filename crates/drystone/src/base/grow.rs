//! Lists that grow by an eighth instead of doubling, for the large tables: their unused half would
//! be half of a world's memory. Also lists that free memory which a burst filled, such as the first
//! step of a world.

/// Capacity that a list always keeps.
const MIN: usize = 512;
/// Number of observations between two decisions to free memory.
const PERIOD: u32 = 64;

/// Appends a value.
#[inline]
pub(crate) fn push<T>(list: &mut Vec<T>, value: T) {
    make_room(list, 1);
    list.push(value);
}

/// Reserves space for `more` values.
#[inline]
pub(crate) fn make_room<T>(list: &mut Vec<T>, more: usize) {
    if list.capacity() - list.len() < more {
        list.reserve_exact(more.max(list.len() / 8).max(8));
    }
}

/// Resizes a list to this length, with copies of a value at its end.
pub(crate) fn resize<T: Clone>(list: &mut Vec<T>, len: usize, value: T) {
    make_room(list, len.saturating_sub(list.len()));
    list.resize(len, value);
}

/// Extends a list to at least this length with zeros. The new memory stays untouched until someone
/// writes to it.
pub(crate) fn zeros(list: &mut Vec<u32>, len: usize) {
    if list.len() < len {
        // Growing the list in place would write to all of it.
        let mut longer = vec![0; len + len / 8];
        longer[..list.len()].copy_from_slice(list);
        *list = longer;
    }
}

/// Tracks the capacity needed by lists that each step fills anew.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Slack {
    maximum: usize,
    looks: u32,
}

impl Slack {
    /// Records the length of a list; once per period returns the capacity that is enough.
    pub(crate) fn look(&mut self, len: usize) -> Option<usize> {
        self.maximum = self.maximum.max(len);
        self.looks += 1;
        if self.looks < PERIOD {
            return None;
        }
        let enough = MIN.max(2 * self.maximum);
        *self = Self::default();
        Some(enough)
    }
}

#[cfg(test)]
mod tests {
    use super::{MIN, PERIOD, Slack};

    #[test]
    fn room_is_given_back_when_no_step_of_a_period_needed_it() {
        let mut slack = Slack::default();
        let mut list = vec![0_u8; 100_000];
        let mut rooms = Vec::new();
        for step in 0..3 * PERIOD {
            let used = if step == 0 { 100_000 } else { 700 };
            list.truncate(used);
            if let Some(enough) = slack.look(used) {
                list.shrink_to(enough);
                rooms.push(list.capacity());
            }
        }
        assert_eq!(rooms[0], 100_000, "it was needed in this period");
        assert!(rooms[1..].iter().all(|r| (1400..2800).contains(r)), "{rooms:?}");
        assert!((0..PERIOD).filter_map(|_| slack.look(3)).all(|enough| enough == MIN));
    }
}
