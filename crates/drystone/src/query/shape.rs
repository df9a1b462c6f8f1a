//! A shape as it is read, by users and by the predicates of queries.

use crate::base::aabb::Aabb;
use crate::base::id::{BodyId, ShapeId};
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::geometry::shape::Shape;
use crate::state::material::{Filter, Material};
use crate::state::reports::{ContactReports, Senses};
use crate::state::shapes::ShapeRow;
use crate::state::tables::Tables;

/// A shape of a body, to read.
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

    /// The shape in a row.
    pub(crate) fn at(tables: &'w Tables, row: u32) -> Self {
        Self { tables, row: tables.shapes.at(row), id: tables.shapes.id(row) }
    }

    pub(crate) const fn tables(&self) -> &'w Tables {
        self.tables
    }

    /// Its id.
    #[must_use]
    pub const fn id(&self) -> ShapeId {
        self.id
    }

    /// The body it is on.
    #[must_use]
    pub fn body(&self) -> BodyId {
        self.tables.bodies.id(self.row.body)
    }

    /// The shape.
    #[must_use]
    pub const fn shape(&self) -> &'w Shape {
        &self.row.shape
    }

    /// Where it sits [m, frame of the body's origin].
    #[must_use]
    pub const fn local_pose(&self) -> Pose {
        self.row.local
    }

    /// Where it is [m, world].
    #[must_use]
    pub fn pose(&self) -> Pose {
        self.tables.bodies.at(self.row.body).pose().compose(&self.row.local)
    }

    /// The smallest box around it [m, world]; without end for a half-space.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.row.solid.aabb(&self.pose())
    }

    /// Its density [kg/m³].
    #[must_use]
    pub const fn density(&self) -> f32 {
        self.row.density
    }

    /// Its surface.
    #[must_use]
    pub const fn material(&self) -> Material {
        self.row.material
    }

    /// How its surface moves over it [m/s, frame of the shape].
    #[must_use]
    pub const fn surface_velocity(&self) -> Vec3 {
        self.row.surface_velocity
    }

    /// How its surface turns over it, about its origin [rad/s, frame of the shape].
    #[must_use]
    pub const fn surface_spin(&self) -> Vec3 {
        self.row.surface_spin
    }

    /// What it collides with.
    #[must_use]
    pub const fn filter(&self) -> Filter {
        self.row.filter
    }

    /// Whether it is a sensor.
    #[must_use]
    pub const fn is_sensor(&self) -> bool {
        self.row.sensor
    }

    /// False if it was taken out of the world: see [`ShapeMut::set_enabled`](crate::ShapeMut::set_enabled).
    #[must_use]
    pub const fn is_enabled(&self) -> bool {
        self.row.enabled
    }

    /// The direction of its front, if it holds from one side only [frame of the shape; unit].
    #[must_use]
    pub fn one_way(&self) -> Option<Vec3> {
        self.tables.shapes.one_way.get(&self.id.index()).copied()
    }

    /// Whether [`ContactHooks`](crate::contact::ContactHooks) are asked for its contacts.
    #[must_use]
    pub const fn has_hooks(&self) -> bool {
        self.row.reports.has_hooks()
    }

    /// What it sees besides, as a sensor.
    #[must_use]
    pub const fn senses(&self) -> Senses {
        self.row.reports.senses()
    }

    /// Which events its contacts give.
    #[must_use]
    pub fn reports(&self) -> ContactReports {
        self.row.reports.unpacked()
    }

    /// The user's number.
    #[must_use]
    pub const fn user_data(&self) -> u64 {
        self.row.user_data
    }
}
