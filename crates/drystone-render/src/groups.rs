//! Groups of connected things, from the pairs that connect them.

/// Groups of numbered things; the lowest number of each group is its leader.
#[derive(Clone, Debug)]
pub struct Groups {
    /// Parent of each thing within its group; the leader is its own parent.
    above: Vec<usize>,
}

impl Groups {
    /// Makes `count` groups of one thing each.
    #[must_use]
    pub fn new(count: usize) -> Self {
        Self { above: (0..count).collect() }
    }

    /// Merges the groups of two things.
    ///
    /// # Panics
    /// If one of them is not below the count.
    pub fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.leader(a), self.leader(b));
        self.above[a.max(b)] = a.min(b);
    }

    /// The lowest number of the thing's group.
    ///
    /// # Panics
    /// If it is not below the count.
    pub fn leader(&mut self, mut of: usize) -> usize {
        while self.above[of] != of {
            // Path halving: later lookups are shorter.
            self.above[of] = self.above[self.above[of]];
            of = self.above[of];
        }
        of
    }
}

#[cfg(test)]
mod tests {
    use super::Groups;

    #[test]
    fn the_lowest_leads_whatever_joins_them() {
        let mut groups = Groups::new(6);
        for (a, b) in [(5, 3), (1, 4), (4, 5)] {
            groups.join(a, b);
        }
        assert_eq!((0..6).map(|i| groups.leader(i)).collect::<Vec<_>>(), [0, 1, 2, 1, 1, 1]);
    }
}
