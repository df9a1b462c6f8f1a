//! Ground that several files of tests stand on.

use std::sync::Arc;

use drystone::{Mesh, Shape, ShapeDef, vec3};

/// A level square of two triangles at y = 0, with sides of twice this length [m].
pub(crate) fn square(half: f32) -> ShapeDef {
    let corner = |x: f32, z: f32| vec3(x, 0.0, z) * half;
    let corners = vec![corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)];
    let mesh = Mesh::new(corners, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
    ShapeDef::new(Shape::Mesh(Arc::new(mesh)))
}
