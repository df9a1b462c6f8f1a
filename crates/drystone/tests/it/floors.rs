//! Grounds for several test files.

use std::sync::Arc;

use drystone::{BodyDef, BodyId, Mesh, Shape, ShapeDef, Vec3, World, vec3};

/// A level square of two triangles at y = 0, with this half side length [m].
pub(crate) fn square(half: f32) -> ShapeDef {
    let corner = |x: f32, z: f32| vec3(x, 0.0, z) * half;
    let corners = vec![corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)];
    let mesh = Mesh::new(corners, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
    ShapeDef::new(Shape::Mesh(Arc::new(mesh)))
}

/// Kind of ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Floor {
    HalfSpace,
    Box,
    Mesh,
}

pub(crate) const FLOORS: [Floor; 3] = [Floor::HalfSpace, Floor::Box, Floor::Mesh];

/// A static floor with its top at height 0; it extends by `half` to each side and is `thick` [m].
pub(crate) fn ground(world: &mut World, floor: Floor, [half, thick]: [f32; 2]) -> BodyId {
    let shape = match floor {
        Floor::HalfSpace => ShapeDef::half_space(Vec3::Y, 0.0),
        Floor::Box => ShapeDef::box_half([half, thick, half]).with_position([0.0, -thick, 0.0]),
        Floor::Mesh => square(half),
    };
    world.add_body(BodyDef::fixed().with_shape(shape)).unwrap()
}
