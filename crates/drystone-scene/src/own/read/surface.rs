//! Materials of surfaces.

use drystone::Material;
use drystone::contact::Combine;

use crate::own::document;

pub(super) fn material(material: &document::Material) -> Material {
    let mut made = Material::default();
    made.friction = material.friction.unwrap_or(made.friction);
    made.kinetic_friction = material.kinetic_friction;
    made.restitution = material.restitution.unwrap_or(made.restitution);
    made.rolling_resistance = material.rolling_resistance.unwrap_or(made.rolling_resistance);
    made.spinning_resistance = material.spinning_resistance.unwrap_or(made.spinning_resistance);
    made.friction_combine = material.friction_combine.map_or(made.friction_combine, combine);
    made.restitution_combine =
        material.restitution_combine.map_or(made.restitution_combine, combine);
    made
}

fn combine(rule: document::Combine) -> Combine {
    match rule {
        document::Combine::GeometricMean => Combine::GeometricMean,
        document::Combine::Multiply => Combine::Multiply,
        document::Combine::Maximum => Combine::Maximum,
        document::Combine::Minimum => Combine::Minimum,
        document::Combine::Average => Combine::Average,
    }
}
