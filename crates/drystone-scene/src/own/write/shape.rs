//! Shapes and surfaces.

use drystone::{Hull, Shape, Vec3};

use super::said::{layers, other, refuse, unless, unless_vec};
use crate::error::SceneError;
use crate::own::document::{
    Box, Capsule, Combine, Cone, Cylinder, Filter, Geometry, HalfSpace, Hull as HullOf, Material,
    Mesh, Sphere,
};
use crate::own::saved_hull::SavedHull;

/// All of a material as bits.
pub(super) fn material_key(material: &drystone::Material) -> [u32; 9] {
    [
        material.friction.to_bits(),
        u32::from(material.kinetic_friction.is_some()),
        material.kinetic_friction.unwrap_or(0.0).to_bits(),
        material.restitution.to_bits(),
        material.rolling_resistance.to_bits(),
        material.spinning_resistance.to_bits(),
        material.friction_combine as u32,
        material.restitution_combine as u32,
        0,
    ]
}

pub(super) fn material(material: &drystone::Material) -> Material {
    let default = drystone::Material::default();
    let rule = |rule: drystone::contact::Combine| match rule {
        drystone::contact::Combine::GeometricMean => Combine::GeometricMean,
        drystone::contact::Combine::Multiply => Combine::Multiply,
        drystone::contact::Combine::Maximum => Combine::Maximum,
        drystone::contact::Combine::Minimum => Combine::Minimum,
        drystone::contact::Combine::Average => Combine::Average,
    };
    Material {
        friction: unless(material.friction, default.friction),
        kinetic_friction: material.kinetic_friction,
        restitution: unless(material.restitution, default.restitution),
        rolling_resistance: unless(material.rolling_resistance, 0.0),
        spinning_resistance: unless(material.spinning_resistance, 0.0),
        friction_combine: other(material.friction_combine, &default.friction_combine).map(rule),
        restitution_combine: other(material.restitution_combine, &default.restitution_combine)
            .map(rule),
    }
}

/// The filter, if it is not the default.
pub(super) fn filter(filter: drystone::Filter) -> Option<Filter> {
    let default = drystone::Filter::default();
    (filter != default).then(|| Filter {
        layers: other(filter.layers, &default.layers).map(layers),
        mask: other(filter.mask, &default.mask).map(layers),
        exclude: other(filter.exclude, &default.exclude).map(layers),
    })
}

/// The geometry of a shape.
pub(super) fn geometry(shape: &Shape) -> Result<Geometry, SceneError> {
    Ok(match shape {
        Shape::Sphere { radius } => Geometry::Sphere(Sphere { radius: *radius }),
        Shape::Capsule { half_height, radius } => {
            Geometry::Capsule(Capsule { half_height: *half_height, radius: *radius })
        }
        Shape::Box { half_extents } => Geometry::Box(Box { half_extents: half_extents.to_array() }),
        Shape::Cylinder { half_height, radius } => {
            Geometry::Cylinder(Cylinder { half_height: *half_height, radius: *radius })
        }
        Shape::Cone { half_height, radius_bottom, radius_top } => Geometry::Cone(Cone {
            half_height: *half_height,
            radius_bottom: *radius_bottom,
            radius_top: unless(*radius_top, 0.0),
        }),
        Shape::HalfSpace { normal, offset } => Geometry::HalfSpace(HalfSpace {
            normal: unless_vec(*normal, Vec3::Y),
            offset: unless(*offset, 0.0),
        }),
        Shape::Hull(found) => Geometry::Hull(hull(found)?),
        Shape::Mesh(mesh) => Geometry::Mesh(Mesh {
            vertices: Some(mesh.vertices().iter().map(|v| v.to_array()).collect()),
            triangles: Some(mesh.triangles().to_vec()),
            ..Mesh::default()
        }),
        _ => return Err(refuse("shapes", format!("a {} has no name in it", shape.kind()), "")),
    })
}

/// A hull: its corners, and its faces too where the corners alone would not give the same bits.
fn hull(hull: &Hull) -> Result<HullOf, SceneError> {
    let points: Vec<[f32; 3]> = hull.vertices().iter().map(|v| v.to_array()).collect();
    let saved = |hull: &Hull| {
        let value = serde_json::to_value(hull).and_then(serde_json::from_value::<SavedHull>);
        value.map_err(|e| refuse("hull", e, ""))
    };
    let own = saved(hull)?;
    if own.cuboid.is_some() {
        return Err(refuse("hull", "it is a box of the engine's own", "a box"));
    }
    let again = Hull::from_points(hull.vertices()).ok().map(|hull| saved(&hull)).transpose()?;
    let is_same = again.is_some_and(|again| again.has_bits_of(&own));
    if is_same {
        return Ok(HullOf { points: Some(points), ..HullOf::default() });
    }
    let planes = own.planes.iter().map(|plane| {
        let [x, y, z] = plane.normal.to_array();
        [x, y, z, plane.offset]
    });
    let (planes, faces) = (Some(planes.collect()), Some(own.faces.clone()));
    Ok(HullOf { points: Some(points), faces, planes, ..HullOf::default() })
}
