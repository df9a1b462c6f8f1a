//! Joints that drive a body.

use crate::state::def::drives::Drives;
use crate::state::sets::Sets;
use crate::state::shapes::Shapes;

/// Tables that decide whether a body is driven.
pub(crate) fn drives_of<'a>(
    sets: &'a Sets<'_>,
    shapes: &'a Shapes,
    (spacing, length): (f32, f32),
) -> Drives<'a> {
    let Sets { bodies, joints, contacts, .. } = sets;
    Drives { bodies, shapes, joints, contacts, length, spacing }
}
