//! Which things belong together, from what joins two of them.

/// Groups of numbered things, each led by its lowest number.
#[derive(Clone, Debug)]
pub struct Groups {
    /// Each names another of its group, up to the leader, which names itself.
    above: Vec<usize>,
}

impl Groups {
    /// So many things, each alone.
    #[must_use]
    pub fn new(count: usize) -> Self {
        Self { above: (0..count).collect() }
    }

    /// Makes one group of those of two things.
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
            // Half of the way is shorter for the next one.
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
