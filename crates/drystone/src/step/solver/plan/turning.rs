//! Which bodies have contacts that are made anew within the step, and how often ([`super::renew`]).

use super::refine::fineness_of;
use crate::base::bit_set::BitSet;
use crate::state::bodies::{Bodies, Body, Fineness};
use crate::state::contacts::Contacts;
use crate::state::shapes::Shapes;
use crate::step::narrowphase;

/// Half the least thickness of a ball over its extent, less rounding.
const ROUND: f32 = 0.98;

/// Contacts of what turns farther than this in a step are made anew in each substep, those of other turning bodies in its middle [rad].
/// There a corner comes down by a fortieth of how far out it is before it has a point.
const OFTEN_TURN: f32 = 0.05;

/// Bodies whose contacts are made anew within the step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Turning {
    pub(crate) bodies: BitSet,
    /// Those of them whose contacts are made anew in each substep.
    pub(crate) often: BitSet,
    rows: Vec<u32>,
    /// Their lines, in order.
    pub(crate) lines: Vec<u32>,
    /// There are some now, or were in the last step.
    pub(crate) changed: bool,
    /// Bodies of contacts that are ghosts of seams.
    seamed: Vec<u32>,
}

impl Turning {
    /// Chooses the bodies whose contacts are made anew within the step: those that turn far, and those that are about to be hit,
    /// for what is thin turns far within the step in which it is. A ball touches at the same lever however it turns, and what
    /// flies by more than its size in a step keeps the rows that stop it.
    pub(crate) fn choose(
        &mut self,
        fineness: &[Fineness],
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
                && body.joints.is_empty()
                && !body.dragged
                && body.inner < ROUND * body.extent
                && body.v.length() * dt < body.extent
                && fineness_of(body.island, fineness) != Fineness::Tumbling
        };
        let ends = |row: u32| [contacts.at(row).body_a, contacts.at(row).body_b];
        self.seamed.extend(found.ghosts().flat_map(ends));
        self.seamed.sort_unstable();
        let seamed = &self.seamed;
        // A mesh is seen whole; of tiles, hidden ones have no points that could be made anew.
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
                // What crosses a seam keeps what was found out about it.
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

    /// Finds their lines.
    pub(crate) fn place(&mut self, line_of: &[u32]) {
        self.lines.clear();
        let lines = self.rows.iter().map(|row| line_of[*row as usize]);
        self.lines.extend(lines.filter(|line| *line != 0));
        self.lines.sort_unstable();
    }
}
