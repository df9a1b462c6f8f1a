//! Copies of a world: what a game that goes back in time keeps of each step.

use std::sync::Arc;

use super::World;

impl Clone for World {
    /// A world that goes on with the same bits. It has memory of its own, and shares with the first one hulls, meshes and the
    /// executor.
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Makes this world a copy of another one in the memory that it has: nothing is allocated if it was as large before. That
    /// is the fast way to keep a state and to go back to it: see `examples/rollback.rs`.
    ///
    /// What steps need only while they run is not copied, so each of the two worlds keeps what it has of that.
    fn clone_from(&mut self, from: &Self) {
        if !Arc::ptr_eq(&self.jobs, &from.jobs) {
            self.jobs = Arc::clone(&from.jobs);
        }
        self.level = from.level;
        self.copy_state(from);
    }
}

impl World {
    /// Becomes a copy of another world but for what does its steps.
    pub(super) fn copy_state(&mut self, from: &Self) {
        let Self { tables, scratch, last_h, pending, books, .. } = from;
        self.tables.clone_from(tables);
        self.scratch.start_from(scratch, &mut self.tables);
        self.last_h = *last_h;
        self.pending.clone_from(pending);
        self.books.clone_from(books);
    }
}
