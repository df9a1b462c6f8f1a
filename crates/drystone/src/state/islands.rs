//! Islands: dynamic bodies connected by contacts or joints. Kept from step to step: merged when a
//! connection is made, split only when one of them wants to sleep.

use super::bodies::{Bodies, NONE};

/// Bodies that sleep and wake together.
#[derive(Clone, Debug, Default)]
pub(crate) struct Island {
    pub(crate) bodies: Vec<u32>,
    /// Connections were cut since it was last known to be connected.
    pub(crate) cut: bool,
}

/// All islands; every dynamic body is in one.
#[derive(Clone, Debug, Default)]
pub(crate) struct Islands {
    pub(crate) rows: Vec<Island>,
    free: Vec<u32>,
    /// Memory for a copy of an island's list, see [`Self::members`].
    spare: Vec<u32>,
}

impl Islands {
    /// A copy of an island's list, for who changes islands on the way; to be given back.
    pub(crate) fn members(&mut self, island: u32) -> Vec<u32> {
        let mut copy = core::mem::take(&mut self.spare);
        copy.clear();
        copy.extend_from_slice(&self.rows[island as usize].bodies);
        copy
    }

    /// Takes back what [`Self::members`] lent.
    pub(crate) fn give_back(&mut self, copy: Vec<u32>) {
        self.spare = copy;
    }

    /// A new island of these bodies.
    pub(crate) fn create(&mut self, members: &[u32], bodies: &mut Bodies) -> u32 {
        let island = self.free.pop().unwrap_or_else(|| {
            self.rows.push(Island::default());
            u32::try_from(self.rows.len() - 1).expect("fewer islands than bodies")
        });
        for b in members {
            bodies.at_mut(*b).island = island;
        }
        let row = &mut self.rows[island as usize];
        row.bodies.extend_from_slice(members);
        row.cut = false;
        island
    }

    /// Empties an island and frees its row; its bodies are in none until they are put into one.
    /// Its list keeps its memory.
    pub(crate) fn dissolve(&mut self, island: u32) {
        self.free.push(island);
        self.rows[island as usize].bodies.clear();
    }

    /// Connects the islands of two dynamic bodies.
    pub(crate) fn link(&mut self, a: u32, b: u32, bodies: &mut Bodies) {
        let (mut keep, mut give) = (bodies.at(a).island, bodies.at(b).island);
        if keep == give || keep == NONE || give == NONE {
            return;
        }
        let size = |i: u32| self.rows[i as usize].bodies.len();
        if (size(give), keep) > (size(keep), give) {
            core::mem::swap(&mut keep, &mut give);
        }
        let cut = self.rows[give as usize].cut;
        let mut moved = core::mem::take(&mut self.rows[give as usize].bodies);
        for body in &moved {
            bodies.at_mut(*body).island = keep;
        }
        let island = &mut self.rows[keep as usize];
        island.bodies.append(&mut moved);
        island.cut |= cut;
        self.rows[give as usize].bodies = moved;
        self.dissolve(give);
    }

    /// A connection of this body was cut.
    pub(crate) fn cut(&mut self, body: u32, bodies: &Bodies) {
        let island = bodies.at(body).island;
        if island != NONE {
            self.rows[island as usize].cut = true;
        }
    }

    /// Takes a body out.
    pub(crate) fn remove(&mut self, body: u32, bodies: &mut Bodies) {
        let island = bodies.at(body).island;
        if island == NONE {
            return;
        }
        bodies.at_mut(body).island = NONE;
        let row = &mut self.rows[island as usize];
        row.bodies.retain(|b| *b != body);
        row.cut = true;
        if row.bodies.is_empty() {
            self.dissolve(island);
        }
    }
}
