//! Colliders: the geometry of shapes as a component.

use core::error::Error;
use core::fmt;
use std::sync::Arc;

use bevy_ecs::component::Component;
use bevy_ecs::entity::Entity;
use bevy_ecs::reflect::ReflectComponent;
use bevy_math::{Quat, Vec3};
use bevy_reflect::Reflect;
use bevy_transform::components::Transform;
use drystone::{Hull, Mesh, Pose, Shape, ShapeId};

use crate::body::PhysicsBody;
use crate::convert::{to_quat, to_vec};
use crate::queue::{collider_gone, look_again};

/// The geometry of a collider, in the frame of its entity. Round shapes have their axis along y.
///
/// It belongs to the body of its own entity, or else to that of its nearest ancestor with a
/// [`RigidBody`](crate::RigidBody). Without such an ancestor it is static. The scale of the entity
/// and its ancestors scales it.
///
/// Insert another value to change it. Sizes out of range are refused with a
/// [`PhysicsFault`](crate::PhysicsFault) when it enters the world.
#[derive(Clone, Component, Debug, Reflect)]
#[component(immutable, on_insert = look_again, on_remove = look_again)]
#[require(PhysicsCollider, PhysicsBody, Transform)]
#[reflect(opaque)]
#[reflect(Component)]
pub struct Collider {
    pub(crate) parts: Arc<[Part]>,
}

/// A shape of a collider, at a pose in the collider's frame.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    pub(crate) pose: Pose,
    pub(crate) shape: Shape,
}

/// Why points or triangles make no collider.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ColliderError(String);

impl fmt::Display for ColliderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl Error for ColliderError {}

impl Collider {
    /// A collider of this shape of the engine.
    #[must_use]
    pub fn from_shape(shape: Shape) -> Self {
        Self { parts: Arc::new([Part { pose: Pose::IDENTITY, shape }]) }
    }

    /// A ball of this radius [m].
    #[must_use]
    pub fn sphere(radius: f32) -> Self {
        Self::from_shape(Shape::sphere(radius))
    }

    /// A box of these full lengths [m].
    #[must_use]
    pub fn cuboid(x_length: f32, y_length: f32, z_length: f32) -> Self {
        Self::from_shape(Shape::box_full([x_length, y_length, z_length]))
    }

    /// A capsule of this radius and this length between the centers of its balls [m].
    #[must_use]
    pub fn capsule(radius: f32, length: f32) -> Self {
        Self::from_shape(Shape::capsule(0.5 * length, radius))
    }

    /// A cylinder of this radius and height [m].
    #[must_use]
    pub fn cylinder(radius: f32, height: f32) -> Self {
        Self::from_shape(Shape::cylinder(0.5 * height, radius))
    }

    /// A cone of this base radius and height [m], tip up, with the origin at half its height.
    #[must_use]
    pub fn cone(radius: f32, height: f32) -> Self {
        Self::from_shape(Shape::cone(0.5 * height, radius))
    }

    /// Infinite solid ground below the plane through the origin with this outward normal [any
    /// length]. For static bodies.
    #[must_use]
    pub fn half_space(outward_normal: Vec3) -> Self {
        Self::from_shape(Shape::half_space(to_vec(outward_normal), 0.0))
    }

    /// The convex hull of points [m].
    ///
    /// # Errors
    /// The points are not finite, too many, or span no volume.
    pub fn convex_hull(points: &[Vec3]) -> Result<Self, ColliderError> {
        let points: Vec<drystone::Vec3> = points.iter().copied().map(to_vec).collect();
        let hull = Hull::from_points(&points).map_err(|e| ColliderError(e.to_string()))?;
        Ok(Self::from_shape(Shape::Hull(Arc::new(hull))))
    }

    /// A mesh of triangles with these vertices [m], solid on both sides. For static and kinematic
    /// bodies.
    ///
    /// # Errors
    /// A number is not finite, a vertex does not exist, or no triangle has an area.
    pub fn trimesh(vertices: &[Vec3], triangles: Vec<[u32; 3]>) -> Result<Self, ColliderError> {
        let vertices = vertices.iter().copied().map(to_vec).collect();
        let mesh = Mesh::new(vertices, triangles).map_err(|e| ColliderError(e.to_string()))?;
        Ok(Self::from_shape(Shape::Mesh(Arc::new(mesh))))
    }

    /// Several colliders as one, each at its position [m] and rotation.
    #[must_use]
    pub fn compound(parts: impl IntoIterator<Item = (Vec3, Quat, Self)>) -> Self {
        let placed = parts.into_iter().flat_map(|(position, rotation, collider)| {
            let outer = Pose { position: to_vec(position), rotation: to_quat(rotation) };
            let place = move |part: &Part| Part { pose: outer.compose(&part.pose), ..part.clone() };
            collider.parts.iter().map(place).collect::<Vec<_>>()
        });
        Self { parts: placed.collect() }
    }

    /// Its shapes in the engine's form, with their poses [m, frame of the collider].
    pub fn shapes(&self) -> impl Iterator<Item = (Pose, &Shape)> {
        self.parts.iter().map(|part| (part.pose, &part.shape))
    }
}

impl From<Shape> for Collider {
    fn from(shape: Shape) -> Self {
        Self::from_shape(shape)
    }
}

/// The shapes of a collider in its world, kept by the plugin.
#[derive(Component, Debug, Default)]
#[component(on_remove = collider_gone, clone_behavior = Ignore)]
pub struct PhysicsCollider {
    /// The entity of the world.
    pub(crate) world: Option<Entity>,
    /// The entity of the body.
    pub(crate) owner: Option<Entity>,
    pub(crate) shapes: Vec<ShapeId>,
    /// The geometry and scale from which the shapes were made.
    pub(crate) made_of: Option<(Collider, drystone::Vec3)>,
}

impl PhysicsCollider {
    /// Its shapes; several for a compound. Empty before the first step after it was spawned, and
    /// for a collider that was refused.
    #[must_use]
    pub fn shapes(&self) -> &[ShapeId] {
        &self.shapes
    }

    /// The entity of the body that it belongs to.
    #[must_use]
    pub const fn body(&self) -> Option<Entity> {
        self.owner
    }
}
