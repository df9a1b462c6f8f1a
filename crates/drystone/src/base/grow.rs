//! Lists that grow by an eighth instead of doubling: the large tables, whose unused half would be half
//! of what a world takes. And lists that give back what a burst filled, such as the first step of a world.

/// Lists may keep this much room whatever they need.
const LEAST: usize = 512;
/// How often a list is looked at before it gives room back.
const PERIOD: u32 = 64;

/// Adds a value.
#[inline]
pub(crate) fn push<T>(list: &mut Vec<T>, value: T) {
    make_room(list, 1);
    list.push(value);
}

/// Makes room for `more` values.
#[inline]
pub(crate) fn make_room<T>(list: &mut Vec<T>, more: usize) {
    if list.capacity() - list.len() < more {
        list.reserve_exact(more.max(list.len() / 8).max(8));
    }
}

/// Makes a list this long, with copies of a value at its end.
pub(crate) fn resize<T: Clone>(list: &mut Vec<T>, len: usize, value: T) {
    make_room(list, len.saturating_sub(list.len()));
    list.resize(len, value);
}

/// Makes a list at least this long, with zeros at its end. They are memory that nothing touches, as long as nobody does.
pub(crate) fn zeros(list: &mut Vec<u32>, len: usize) {
    if list.len() < len {
        // A longer list that is written to would touch all of it.
        let mut longer = vec![0; len + len / 8];
        longer[..list.len()].copy_from_slice(list);
        *list = longer;
    }
}

/// Watches how much of their room lists need that are filled anew in each step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Slack {
    most: usize,
    looks: u32,
}

impl Slack {
    /// Takes down that a list was as long as this; now and then tells what capacity is enough.
    pub(crate) fn look(&mut self, len: usize) -> Option<usize> {
        self.most = self.most.max(len);
        self.looks += 1;
        if self.looks < PERIOD {
            return None;
        }
        let enough = LEAST.max(2 * self.most);
        *self = Self::default();
        Some(enough)
    }
}

#[cfg(test)]
mod tests {
    use super::{LEAST, PERIOD, Slack};

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
        assert!((0..PERIOD).filter_map(|_| slack.look(3)).all(|enough| enough == LEAST));
    }
}
