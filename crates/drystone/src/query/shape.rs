//! A read-only view of a shape, for users and for the predicates of queries.

use crate::base::aabb::Aabb;
use crate::base::id::{BodyId, ShapeId};
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::geometry::shape::Shape;
use crate::state::def::material::{Filter, Material};
use crate::state::def::reports::{ContactReports, Senses};
use crate::state::shapes::ShapeRow;
use crate::state::tables::Tables;

/// A read-only view of a shape of a body.
#[derive(Clone, Copy, Debug)]
pub struct ShapeRef<'w> {
    tables: &'w Tables,
    row: &'w ShapeRow,
    id: ShapeId,
}

impl<'w> ShapeRef<'w> {
    pub(crate) fn new(tables: &'w Tables, id: ShapeId) -> Option<Self> {
        Some(Self::at(tables, tables.shapes.rows.row(id)?))
    }

    /// The shape of a row.
    pub(crate) fn at(tables: &'w Tables, row: u32) -> Self {
        Self { tables, row: tables.shapes.at(row), id: tables.shapes.id(row) }
    }

    pub(crate) const fn tables(&self) -> &'w Tables {
        self.tables
    }

    /// Id of the shape.
    #[must_use]
    pub const fn id(&self) -> ShapeId {
        self.id
    }

    /// Body of the shape.
    #[must_use]
    pub fn body(&self) -> BodyId {
        self.tables.bodies.id(self.row.body)
    }

    /// The shape.
    #[must_use]
    pub const fn shape(&self) -> &'w Shape {
        &self.row.shape
    }

    /// Pose of the shape [m, frame of the body's origin].
    #[must_use]
    pub const fn local_pose(&self) -> Pose {
        self.row.local
    }

    /// Pose of the shape [m, world].
    #[must_use]
    pub fn pose(&self) -> Pose {
        self.tables.bodies.at(self.row.body).pose().compose(&self.row.local)
    }

    /// Smallest bounding box of the shape [m, world]; infinite for a half-space.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.row.solid.aabb(&self.pose())
    }

    /// Density [kg/m³].
    #[must_use]
    pub const fn density(&self) -> f32 {
        self.row.density
    }

    /// Material of the surface.
    #[must_use]
    pub const fn material(&self) -> Material {
        self.row.material
    }

    /// Linear velocity of the surface over the shape [m/s, frame of the shape].
    #[must_use]
    pub const fn surface_velocity(&self) -> Vec3 {
        self.row.surface_velocity
    }

    /// Angular velocity of the surface over the shape, about its origin
    /// [rad/s, frame of the shape].
    #[must_use]
    pub const fn surface_spin(&self) -> Vec3 {
        self.row.surface_spin
    }

    /// Collision filter.
    #[must_use]
    pub const fn filter(&self) -> Filter {
        self.row.filter
    }

    /// Whether the shape is a sensor.
    #[must_use]
    pub const fn is_sensor(&self) -> bool {
        self.row.sensor
    }

    /// Whether the shape is in the world: see
    /// [`ShapeMut::set_enabled`](crate::ShapeMut::set_enabled).
    #[must_use]
    pub const fn is_enabled(&self) -> bool {
        self.row.enabled
    }

    /// Direction of the front, if the shape collides from one side only [frame of the shape; unit].
    #[must_use]
    pub fn one_way(&self) -> Option<Vec3> {
        self.tables.shapes.one_way.get(&self.id.index()).copied()
    }

    /// Whether the engine calls [`ContactHooks`](crate::contact::ContactHooks) for its contacts.
    #[must_use]
    pub const fn has_hooks(&self) -> bool {
        self.row.reports.has_hooks()
    }

    /// Extra shapes that it detects as a sensor: static ones, other sensors.
    #[must_use]
    pub const fn senses(&self) -> Senses {
        self.row.reports.senses()
    }

    /// Events that its contacts report.
    #[must_use]
    pub fn reports(&self) -> ContactReports {
        self.row.reports.unpacked()
    }

    /// Number for the user's own use.
    #[must_use]
    pub const fn user_data(&self) -> u64 {
        self.row.user_data
    }
}
