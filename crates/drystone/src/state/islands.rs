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
}

impl Islands {
    /// A new island of these bodies.
    pub(crate) fn create(&mut self, members: Vec<u32>, bodies: &mut Bodies) -> u32 {
        let island = self.free.pop().unwrap_or_else(|| {
            self.rows.push(Island::default());
            u32::try_from(self.rows.len() - 1).expect("fewer islands than bodies")
        });
        for b in &members {
            bodies.at_mut(*b).island = island;
        }
        self.rows[island as usize] = Island { bodies: members, cut: false };
        island
    }

    /// Empties an island and frees its row; its bodies are in none until they are put into one.
    pub(crate) fn dissolve(&mut self, island: u32) -> Vec<u32> {
        self.free.push(island);
        core::mem::take(&mut self.rows[island as usize]).bodies
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
        let moved = self.dissolve(give);
        for body in &moved {
            bodies.at_mut(*body).island = keep;
        }
        let island = &mut self.rows[keep as usize];
        island.bodies.extend(moved);
        island.cut |= cut;
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
