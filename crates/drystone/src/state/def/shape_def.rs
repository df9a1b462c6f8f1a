//! The definition of a shape.

use std::sync::Arc;

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::body_def::BodyKind;
use super::check::{finite_vec, position, unit, velocity, within};
use super::error::DefError;
use super::material::{Filter, Material};
use super::reports::{ContactReports, Senses};
use crate::base::limits;
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::base::quat::Quat;
use crate::geometry::hull::Hull;
use crate::geometry::mesh::Mesh;
use crate::geometry::shape::Shape;

/// A shape of a body.
///
/// The manual: [shapes](crate::manual::shapes).
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct ShapeDef {
    /// The geometry.
    pub shape: Shape,
    /// Its pose [body].
    pub pose: Pose,
    /// Density [kg/m³]; at least 0 (0: no mass); default 1000.
    pub density: f32,
    /// Its surface.
    pub material: Material,
    /// Its collision filter.
    pub filter: Filter,
    /// Whether it is a sensor, which reports overlaps, touches nothing and has no mass. Default
    /// false. A sensor detects the shapes of all other bodies, moving, at rest or asleep. It
    /// detects other sensors, and from a static body static shapes, only if [`Self::senses`] says
    /// so.
    pub sensor: bool,
    /// Additional objects that it detects as a sensor.
    pub senses: Senses,
    /// Velocity of the surface along the shape, as of a conveyor belt [m/s, frame of the shape];
    /// default 0. Friction drags bodies on it along, up to this velocity relative to the body. Only
    /// the component along the surface acts.
    pub surface_velocity: Vec3,
    /// Angular velocity of the surface about the shape's origin, for rotating belts [rad/s, frame
    /// of the shape]. It adds to `surface_velocity`; default 0.
    pub surface_spin: Vec3,
    /// Direction of the front of a one-way surface [frame of the shape, any length]. The surface
    /// blocks only shapes that come from the front. Other shapes pass until they no longer overlap
    /// it. Default `None`: it blocks from all sides.
    pub one_way: Option<Vec3>,
    /// Whether [`ContactHooks`](crate::contact::ContactHooks) are called for its contacts; default
    /// false.
    pub hooks: bool,
    /// The events that its contacts report.
    pub reports: ContactReports,
    /// Whether it is in the world from the start; default true. See
    /// [`ShapeMut::set_enabled`](crate::ShapeMut::set_enabled).
    pub enabled: bool,
    /// A number for the user.
    pub user_data: u64,
}

impl ShapeDef {
    /// A shape at the body's origin with default material.
    #[must_use]
    pub fn new(shape: Shape) -> Self {
        Self {
            shape,
            pose: Pose::IDENTITY,
            density: 1000.0,
            material: Material::default(),
            filter: Filter::default(),
            sensor: false,
            senses: Senses::default(),
            surface_velocity: Vec3::ZERO,
            surface_spin: Vec3::ZERO,
            one_way: None,
            hooks: false,
            reports: ContactReports::default(),
            enabled: true,
            user_data: 0,
        }
    }

    /// A convex hull, made by [`Hull::from_points`].
    #[must_use]
    pub fn hull(hull: impl Into<Arc<Hull>>) -> Self {
        Self::new(Shape::Hull(hull.into()))
    }

    /// A triangle mesh, made by [`Mesh::new`], on a static or kinematic body.
    #[must_use]
    pub fn mesh(mesh: impl Into<Arc<Mesh>>) -> Self {
        Self::new(Shape::Mesh(mesh.into()))
    }

    /// A ball of this radius [m].
    #[must_use]
    pub fn sphere(radius: f32) -> Self {
        Self::new(Shape::sphere(radius))
    }

    /// A capsule along y: half the distance of the ball centers [m], and radius [m].
    #[must_use]
    pub fn capsule(half_height: f32, radius: f32) -> Self {
        Self::new(Shape::capsule(half_height, radius))
    }

    /// A box of these half extents [m].
    #[must_use]
    pub fn box_half(half_extents: impl Into<Vec3>) -> Self {
        Self::new(Shape::box_half(half_extents))
    }

    /// A box of these edge lengths [m].
    #[must_use]
    pub fn box_full(extents: impl Into<Vec3>) -> Self {
        Self::new(Shape::box_full(extents))
    }

    /// A cylinder along y of this half height and radius [m].
    #[must_use]
    pub fn cylinder(half_height: f32, radius: f32) -> Self {
        Self::new(Shape::cylinder(half_height, radius))
    }

    /// A cone along y of this half height and base radius [m], tip up, origin at half height.
    #[must_use]
    pub fn cone(half_height: f32, radius: f32) -> Self {
        Self::new(Shape::cone(half_height, radius))
    }

    /// The half space below the plane `normal · p = offset` [m].
    #[must_use]
    pub fn half_space(normal: impl Into<Vec3>, offset: f32) -> Self {
        Self::new(Shape::half_space(normal, offset))
    }

    /// With this pose in the body's frame.
    #[must_use]
    pub fn with_pose(self, pose: Pose) -> Self {
        Self { pose, ..self }
    }

    /// With this position in the body's frame [m].
    #[must_use]
    pub fn with_position(mut self, position: impl Into<Vec3>) -> Self {
        self.pose.position = position.into();
        self
    }

    /// With this rotation in the body's frame; normalized if it is close to unit length.
    #[must_use]
    pub fn with_rotation(mut self, rotation: impl Into<Quat>) -> Self {
        self.pose.rotation = rotation.into();
        self
    }

    /// Out of the world until [`ShapeMut::set_enabled`](crate::ShapeMut::set_enabled) enables it.
    /// It counts for the mass meanwhile.
    #[must_use]
    pub fn starts_disabled(self) -> Self {
        Self { enabled: false, ..self }
    }

    /// With this number for the user.
    #[must_use]
    pub fn with_user_data(self, user_data: u64) -> Self {
        Self { user_data, ..self }
    }

    /// With this density [kg/m³].
    #[must_use]
    pub fn with_density(self, density: f32) -> Self {
        Self { density, ..self }
    }

    /// With this surface.
    #[must_use]
    pub fn with_material(self, material: Material) -> Self {
        Self { material, ..self }
    }

    /// With this friction coefficient.
    #[must_use]
    pub fn with_friction(mut self, friction: f32) -> Self {
        self.material.friction = friction;
        self
    }

    /// With this coefficient of restitution.
    #[must_use]
    pub fn with_restitution(mut self, restitution: f32) -> Self {
        self.material.restitution = restitution;
        self
    }

    /// With this velocity of the surface along the shape [m/s, frame of the shape].
    #[must_use]
    pub fn with_surface_velocity(self, velocity: impl Into<Vec3>) -> Self {
        Self { surface_velocity: velocity.into(), ..self }
    }

    /// With this angular velocity of the surface about the shape's origin [rad/s, frame of the
    /// shape].
    #[must_use]
    pub fn with_surface_spin(self, spin: impl Into<Vec3>) -> Self {
        Self { surface_spin: spin.into(), ..self }
    }

    /// With this filter.
    #[must_use]
    pub fn with_filter(self, filter: Filter) -> Self {
        Self { filter, ..self }
    }

    /// Makes it a one-way surface with its front in this direction [frame of the shape, any
    /// length]. A platform that can be entered by a jump from below has its front above:
    ///
    /// ```
    /// use drystone::{ShapeDef, Vec3};
    ///
    /// let platform = ShapeDef::box_half([2.0, 0.1, 1.0]).with_one_way(Vec3::Y);
    /// # let _ = platform;
    /// ```
    #[must_use]
    pub fn with_one_way(self, front: impl Into<Vec3>) -> Self {
        Self { one_way: Some(front.into()), ..self }
    }

    /// With calls of [`ContactHooks`](crate::contact::ContactHooks) for its contacts.
    #[must_use]
    pub fn with_hooks(self) -> Self {
        Self { hooks: true, ..self }
    }

    /// With these additional objects that it detects as a sensor.
    #[must_use]
    pub fn with_senses(self, senses: Senses) -> Self {
        Self { senses, ..self }
    }

    /// With these events of its contacts.
    #[must_use]
    pub fn with_reports(self, reports: ContactReports) -> Self {
        Self { reports, ..self }
    }

    /// As a sensor.
    #[must_use]
    pub fn as_sensor(self) -> Self {
        Self { sensor: true, ..self }
    }

    /// Checks every field.
    ///
    /// # Errors
    /// The first field that is out of range.
    pub fn validate(&self) -> Result<(), DefError> {
        check_shape(&self.shape)?;
        position("pose.position", self.pose.position)?;
        unit("pose.rotation", self.pose.rotation)?;
        within("density", self.density, &limits::DENSITY)?;
        velocity("surface_velocity", self.surface_velocity)?;
        velocity("surface_spin", self.surface_spin)?;
        if let Some(front) = self.one_way {
            check_front(front)?;
        }
        self.reports.validate()?;
        self.material.validate().map_err(|e| e.within("material"))
    }
}

/// Checks and normalizes the direction of a one-way front.
pub(crate) fn check_front(front: Vec3) -> Result<Vec3, DefError> {
    finite_vec("one_way", front)?;
    let unit = front.try_normalize();
    unit.ok_or_else(|| DefError::of_vec("one_way", front, "a direction of nonzero length"))
}

/// Checks the geometry of a shape.
pub(crate) fn check_shape(shape: &Shape) -> Result<(), DefError> {
    shape.validate()?;
    match shape {
        Shape::HalfSpace { normal, .. } if *normal == Vec3::ZERO => {
            Err(DefError::new("normal", "zero", "a direction of nonzero length"))
        }
        _ => Ok(()),
    }
}

/// Refuses geometry that a body of this kind cannot have.
pub(crate) fn shape_suits(kind: BodyKind, shape: &Shape) -> Result<(), DefError> {
    match (kind, shape) {
        (BodyKind::Static, _) | (BodyKind::Kinematic, Shape::Mesh(_)) => Ok(()),
        (_, Shape::HalfSpace { .. }) => {
            Err(DefError::unsuitable("shape", "half-space", "a half-space on a static body"))
        }
        (_, Shape::Mesh(_)) => Err(DefError::unsuitable(
            "shape",
            "mesh",
            "a mesh on a static or kinematic body; decompose it into hulls for a dynamic one",
        )),
        _ => Ok(()),
    }
}
