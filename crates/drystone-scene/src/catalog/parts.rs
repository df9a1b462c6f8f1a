//! Parts of catalog scenes: ground, boxes, shared hulls, meshes of heights, and numbers that look
//! random but are the same everywhere.

use std::sync::Arc;

use drystone::math::trig;
use drystone::{BodyDef, Hull, Mesh, Quat, Shape, ShapeDef, Vec3, vec3};

use super::parameters::CatalogError;
use crate::scene::Scene;

/// The name of the body that things stand on.
pub(super) const GROUND: &str = "ground";

/// A count as a number; exact up to 2^24, which no scene reaches.
pub(super) const fn real(count: usize) -> f32 {
    count as f32
}

/// Degrees as radians.
pub(super) fn radians(degrees: f32) -> f32 {
    degrees * (core::f32::consts::PI / 180.0)
}

/// (cos, sin) of an angle [rad].
pub(super) fn cos_sin(angle: f32) -> (f32, f32) {
    let (s, c) = trig::sin_cos(angle);
    (c, s)
}

/// Gravity as most benchmark scenes of the field have it: 10 m/s².
pub(super) const fn gravity_10(scene: &mut Scene) {
    scene.config.gravity = vec3(0.0, -10.0, 0.0);
}

/// Solid ground below y = 0, without end.
pub(super) fn add_ground(scene: &mut Scene, friction: f32) {
    let surface = ShapeDef::half_space(Vec3::Y, 0.0).with_friction(friction);
    scene.add(GROUND, BodyDef::fixed().with_shape(surface));
}

/// A ground box of these half extents [m], 2 m thick, with its top at y = 0.
pub(super) fn add_ground_box(scene: &mut Scene, half_x: f32, half_z: f32) {
    let shape = ShapeDef::box_half(vec3(half_x, 1.0, half_z));
    scene.add(GROUND, BodyDef::fixed().with_position(vec3(0.0, -1.0, 0.0)).with_shape(shape));
}

/// A moving box of these half extents [m] at this position [m].
pub(super) fn box_at(half_extents: Vec3, position: Vec3) -> BodyDef {
    BodyDef::dynamic().with_position(position).with_shape(ShapeDef::box_half(half_extents))
}

/// A turn about y by this angle [rad].
pub(super) fn yaw(angle: f32) -> Quat {
    Quat::from_axis_angle(Vec3::Y, angle)
}

/// A hull to be shared by many bodies.
pub(super) fn hull(points: &[Vec3]) -> Result<Shape, CatalogError> {
    Ok(Shape::Hull(Arc::new(Hull::from_points(points)?)))
}

/// A mesh of `cells_x` × `cells_z` squares of two triangles; vertex (i, j) is `vertex(i, j)` [m].
/// Seen from above the triangles run counter-clockwise if x grows with i and z with j.
pub(super) fn grid_mesh(
    (cells_x, cells_z): (u32, u32),
    mut vertex: impl FnMut(u32, u32) -> Vec3,
) -> Result<Shape, CatalogError> {
    let mut vertices = Vec::new();
    for j in 0..=cells_z {
        for i in 0..=cells_x {
            vertices.push(vertex(i, j));
        }
    }
    let at = |i: u32, j: u32| j * (cells_x + 1) + i;
    let mut triangles = Vec::new();
    for j in 0..cells_z {
        for i in 0..cells_x {
            triangles.push([at(i, j), at(i, j + 1), at(i + 1, j)]);
            triangles.push([at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)]);
        }
    }
    Ok(Shape::Mesh(Arc::new(Mesh::new(vertices, triangles)?)))
}

/// A linear congruential generator: the numbers are the same on every machine.
#[derive(Clone, Debug)]
pub(super) struct Lcg {
    state: u32,
}

impl Lcg {
    pub(super) const fn new(seed: u32) -> Self {
        Self { state: seed }
    }

    const fn next(&mut self) -> u32 {
        self.state = self.state.wrapping_mul(2_147_001_325).wrapping_add(715_136_305);
        self.state
    }

    /// −0.5 to 0.5 in steps of 1/65535, from the low 16 bits, for the pile of convex hulls of
    /// `convex_pile`.
    pub(super) const fn centered_low(&mut self) -> f32 {
        (self.next() & 0xffff) as f32 / 65535.0 - 0.5
    }

    /// From `low` to `high`, from the high bits, which are the random ones.
    pub(super) const fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * ((self.next() >> 8) as f32 / 16_777_215.0)
    }

    /// Somewhere on the unit sphere, evenly.
    pub(super) fn direction(&mut self) -> Vec3 {
        let z = self.between(-1.0, 1.0);
        let (c, s) = cos_sin(self.between(0.0, core::f32::consts::TAU));
        let r = (1.0 - z * z).max(0.0).sqrt();
        vec3(r * c, r * s, z)
    }

    /// Any rotation, not quite evenly.
    pub(super) fn rotation(&mut self) -> Quat {
        let axis = self.direction();
        Quat::from_axis_angle(axis, self.between(0.0, core::f32::consts::PI))
    }
}
