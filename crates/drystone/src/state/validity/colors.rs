//! Rebuilds and checks colors: each constraint stores its own color, from which the lists are
//! built.

use super::{Check, holds};
use crate::state::sets::dynamic_of;
use crate::state::tables::Tables;

/// Limit on the index of a color, above the number of constraints on one body in any world. Larger
/// indices would take memory.
const MAX_COLORS: u32 = 1 << 20;

/// Fills the colors. Constraints of one color must share no dynamic body, and each body's count of
/// constraints must be correct.
pub(crate) fn find_colors(tables: &mut Tables) -> Check {
    let Tables { bodies, joints, contacts, colors, .. } = tables;
    let mut constraints = vec![0_u32; bodies.rows.slot_count()];
    let of_joints =
        joints.rows.iter().map(|(id, j)| (true, id.index(), [j.body_a, j.body_b], j.place));
    let of_contacts = contacts.iter().map(|(row, c)| (false, row, [c.body_a, c.body_b], c.place));
    let mut all: Vec<_> = of_joints.chain(of_contacts).filter(|(.., p)| p.is_somewhere()).collect();
    // The order within a color affects the classic methods with level or random order.
    all.sort_by_key(|(.., place)| (place.color, place.row));
    for (is_joint, row, [a, b], place) in &all {
        let (dynamic, n) = dynamic_of(bodies, *a, *b);
        let dynamic = &dynamic[..n];
        let coloring = match (is_joint, n) {
            (true, 2) => &mut colors.joints,
            (true, 1) => &mut colors.joints_fixed,
            (false, 2) => &mut colors.contacts,
            (false, 1) => &mut colors.contacts_fixed,
            _ => return Err("a color has what moves no body"),
        };
        holds(place.color < MAX_COLORS, "there are too many colors")?;
        let Some(place) = coloring.insert_at(place.color, *row, dynamic) else {
            return Err("constraints of a color share a body");
        };
        for body in dynamic {
            constraints[*body as usize] += 1;
        }
        if *is_joint {
            joints.at_mut(*row).place = place;
            continue;
        }
        let contact = contacts.at_mut(*row);
        holds(contact.count > 0 && !contact.sensor, "a color has what does not act")?;
        contact.place = place;
        colors.special += usize::from(contact.is_special(bodies));
    }
    let all =
        bodies.rows.iter().all(|(id, b)| constraints[id.index() as usize] == b.ties.constraints);
    holds(all, "a body does not know what acts on it")
}
