//! Chooses the bodies whose contacts are rebuilt within the step, and how often
//! (`contact/renew.rs`).

use super::refine::subdivision_of;
use crate::base::bit_set::BitSet;
use crate::state::bodies::Bodies;
use crate::state::bodies::body::{Body, Subdivision};
use crate::state::contacts::Contacts;
use crate::state::shapes::Shapes;
use crate::step::narrowphase;

/// Half the minimum thickness of a ball over its extent, less rounding.
const ROUND: f32 = 0.98;

/// Angle per step above which contacts are rebuilt in each substep; for other turning bodies they
/// are rebuilt in the middle of the step [rad]. At this angle a corner descends by a fortieth of
/// its lever arm before it gets a contact point.
const OFTEN_TURN: f32 = 0.05;

/// Bodies whose contacts are rebuilt within the step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Turning {
    pub(crate) bodies: BitSet,
    /// Bodies among these whose contacts are rebuilt in each substep.
    pub(crate) often: BitSet,
    rows: Vec<u32>,
    /// Their solver bodies, in order.
    pub(crate) solver_rows: Vec<u32>,
    /// There are some in this step, or were in the last one.
    pub(crate) changed: bool,
    /// Bodies with contacts that are ghosts of seams.
    seamed: Vec<u32>,
}

impl Turning {
    /// Chooses the bodies whose contacts are rebuilt within the step: those that turn far, and
    /// those about to be hit. (A thin body turns far in the step of the impact.) Balls are left
    /// out: a ball's contact has the same lever arm at any rotation. A body that flies by more than
    /// its size in a step keeps the rows that stop it.
    pub(crate) fn choose(
        &mut self,
        subdivision: &[Subdivision],
        bodies: &Bodies,
        contacts: &Contacts,
        shapes: &Shapes,
        (found, dt): (&narrowphase::scratch::Scratch, f32),
    ) {
        let had_any = !self.rows.is_empty();
        self.bodies.remove_all(&self.rows);
        self.often.remove_all(&self.rows);
        self.rows.clear();
        self.seamed.clear();
        let may = |body: &Body| {
            body.is_dynamic()
                && body.active()
                && body.ties.joints.is_empty()
                && !body.record.is_link
                && !body.record.dragged
                && body.inner < ROUND * body.extent
                && body.v.length() * dt < body.extent
                && subdivision_of(body.sleep.island, subdivision) != Subdivision::Tumbling
        };
        let ends = |row: u32| [contacts.at(row).body_a, contacts.at(row).body_b];
        self.seamed.extend(found.ghosts().flat_map(ends));
        self.seamed.sort_unstable();
        let seamed = &self.seamed;
        // A mesh is one contact partner. Among tiles, hidden faces have no points that could be
        // rebuilt.
        let is_over_several = |body: &Body| {
            let stands = |(row, side): &(u32, u32)| {
                let c = contacts.at(*row);
                let other = if *side == 0 { c.body_b } else { c.body_a };
                !c.is_part && !c.sensor && !bodies.at(other).is_dynamic()
            };
            contacts.of_body(body).filter(stands).count() > 1
        };
        for (row, hit) in
            found.turning().map(|row| (row, false)).chain(found.closing().map(|row| (row, true)))
        {
            let c = contacts.at(row);
            if c.count == 0 || (hit && shapes.at(c.shape_a).is_mesh()) {
                continue;
            }
            let ends = [c.body_a, c.body_b].map(|row| (row, bodies.at(row)));
            let fastest = ends.map(|(_, body)| body.w.length()).into_iter().fold(0.0, f32::max);
            for (row, body) in ends {
                // A body that crosses a seam keeps its contacts, whose ghosts are already known.
                if !self.bodies.contains(row)
                    && may(body)
                    && seamed.binary_search(&row).is_err()
                    && (hit || body.w.length() >= 0.5 * fastest)
                    && !is_over_several(body)
                {
                    self.bodies.insert(row);
                    self.rows.push(row);
                }
                let turns_far = hit || body.w.length() * dt > OFTEN_TURN;
                if turns_far && self.bodies.contains(row) {
                    self.often.insert(row);
                }
            }
        }
        self.changed = had_any || !self.rows.is_empty();
    }

    /// Finds their solver bodies.
    pub(crate) fn place(&mut self, solver_row_of: &[u32]) {
        self.solver_rows.clear();
        let solver_rows = self.rows.iter().map(|row| solver_row_of[*row as usize]);
        self.solver_rows.extend(solver_rows.filter(|solver_row| *solver_row != 0));
        self.solver_rows.sort_unstable();
    }
}
