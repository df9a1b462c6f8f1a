//! Copies of a world, for example one per step in a game with rollback.

use std::sync::Arc;

use crate::world::World;

impl Clone for World {
    /// A copy that continues with the same bits. It has its own memory, and shares hulls, meshes
    /// and the executor with the original.
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Makes this world a copy of another one and reuses its memory. If this world was as large
    /// before, nothing is allocated. Use it to save and restore states fast: see
    /// `examples/rollback.rs`.
    ///
    /// Memory that is used only within a step is not copied; each world keeps its own.
    fn clone_from(&mut self, from: &Self) {
        if !Arc::ptr_eq(&self.jobs, &from.jobs) {
            self.jobs = Arc::clone(&from.jobs);
        }
        self.level = from.level;
        self.copy_state(from);
    }
}

impl World {
    /// Copies another world's state, but not its executor and SIMD level.
    pub(crate) fn copy_state(&mut self, from: &Self) {
        let Self { tables, scratch, last_h, pending, books, .. } = from;
        self.tables.clone_from(tables);
        self.scratch.start_from(scratch, &mut self.tables);
        self.last_h = *last_h;
        self.pending.clone_from(pending);
        self.books.clone_from(books);
    }
}
