//! Lists that grow by an eighth instead of doubling: the large tables, whose unused half would be half
//! of what a world takes.

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
