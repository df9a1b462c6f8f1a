//! The mass of bodies whose file gives none.

use drystone::ShapeDef;
use drystone::geometry::MassProperties;

/// Mass properties of all solid shapes together, about their common center [body].
pub(crate) fn mass_of(shapes: &[ShapeDef]) -> MassProperties {
    let solid = shapes.iter().filter(|s| !s.sensor);
    let parts: Vec<_> = solid.map(|s| (s.pose, MassProperties::of(&s.shape, s.density))).collect();
    MassProperties::combine(&parts)
}
