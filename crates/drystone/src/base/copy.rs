//! Copies into existing tables, without new memory.

use std::collections::{BTreeMap, BTreeSet};

/// Makes `to` equal to `from`. Allocates only for keys that are new in `to`.
pub(crate) fn map<K: Copy + Ord, V: Clone>(to: &mut BTreeMap<K, V>, from: &BTreeMap<K, V>) {
    to.retain(|key, _| from.contains_key(key));
    for (key, value) in from {
        match to.get_mut(key) {
            Some(there) => there.clone_from(value),
            None => {
                to.insert(*key, value.clone());
            }
        }
    }
}

/// Makes a set equal to another.
pub(crate) fn set<K: Copy + Ord>(to: &mut BTreeSet<K>, from: &BTreeSet<K>) {
    to.retain(|key| from.contains(key));
    to.extend(from);
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::map;

    #[test]
    fn a_map_becomes_the_other_whatever_it_had() {
        let maps = [vec![], vec![(1, 2)], vec![(1, 3), (4, 5)], vec![(0, 9), (4, 6), (7, 7)]];
        let maps = maps.map(|pairs| pairs.into_iter().collect::<BTreeMap<_, _>>());
        for to in &maps {
            for from in &maps {
                let mut copy = to.clone();
                map(&mut copy, from);
                assert_eq!(copy, *from);
            }
        }
    }
}
