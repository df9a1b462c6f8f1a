//! Changes of constraints since the last plan.

use crate::state::colors::{Coloring, Colors};

/// True if a joint was added or removed since the last call, or if a constrained body fell asleep,
/// woke or was deactivated.
pub(super) fn take_joint_changes(colors: &mut Colors) -> bool {
    let changed = core::mem::take(&mut colors.bodies_changed);
    take_dirty([&mut colors.joints, &mut colors.joints_fixed]) || changed
}

/// True if a constraint was added, removed or changed its number of points since the last call.
pub(super) fn take_dirty(all: [&mut Coloring; 2]) -> bool {
    let mut changed = false;
    for color in all.into_iter().flat_map(|coloring| &mut coloring.colors) {
        changed |= core::mem::take(&mut color.dirty);
    }
    changed
}
