//! A shape as the user sees it.

use super::World;
use crate::base::aabb::Aabb;
use crate::base::id::{BodyId, ShapeId};
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::geometry::shape::Shape;
use crate::state::def::{DefError, velocity};
use crate::state::material::{Filter, Material};
use crate::state::reports::{ContactReports, PackedReports, Senses};
use crate::state::shapes::{PairSurface, ShapeRow};
use crate::state::tables::Tables;

/// A shape of a body, to read.
#[derive(Clone, Copy, Debug)]
pub struct ShapeRef<'w> {
    tables: &'w Tables,
    row: &'w ShapeRow,
    id: ShapeId,
}

impl<'w> ShapeRef<'w> {
    pub(super) fn new(tables: &'w Tables, id: ShapeId) -> Option<Self> {
        let row = tables.shapes.rows.row(id)?;
        Some(Self { tables, row: tables.shapes.at(row), id })
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

    /// False if it was taken out of the world: see [`ShapeMut::set_enabled`].
    #[must_use]
    pub const fn is_enabled(&self) -> bool {
        self.row.enabled
    }

    /// The direction of its front, if it holds from one side only [frame of the shape; unit].
    #[must_use]
    pub fn one_way(&self) -> Option<Vec3> {
        self.tables.shapes.one_way.get(&self.id.index()).copied()
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

/// A shape of a body, to change.
#[derive(Debug)]
pub struct ShapeMut<'w> {
    pub(super) world: &'w mut World,
    pub(super) row: u32,
    id: ShapeId,
}

impl<'w> ShapeMut<'w> {
    pub(super) fn new(world: &'w mut World, id: ShapeId) -> Option<Self> {
        let row = world.tables.shapes.rows.row(id)?;
        Some(Self { world, row, id })
    }

    /// The shape, to read.
    #[must_use]
    pub fn get(&self) -> ShapeRef<'_> {
        let tables = &self.world.tables;
        ShapeRef { tables, row: tables.shapes.at(self.row), id: self.id }
    }

    /// Sets the user's number.
    pub fn set_user_data(&mut self, data: u64) {
        self.world.tables.shapes.at_mut(self.row).user_data = data;
    }

    /// Lets its contacts give other events, from the next step on. A touch that was reported to begin, and no longer may be,
    /// ends without a report.
    ///
    /// # Errors
    /// The speed is out of range; then nothing is changed.
    pub fn set_reports(&mut self, reports: ContactReports) -> Result<(), DefError> {
        reports.validate()?;
        self.world.tables.shapes.set_reports(self.row, self.packed(&reports, self.get().senses()));
        Ok(())
    }

    /// Gives it another surface, from the next step on; what it touches wakes.
    ///
    /// # Errors
    /// A field is out of range; then nothing is changed.
    pub fn set_material(&mut self, surface: Material) -> Result<(), DefError> {
        surface.validate()?;
        self.world.tables.shapes.at_mut(self.row).material = surface;
        self.refresh_contacts();
        Ok(())
    }

    /// Lets its surface move over it, as a conveyor belt does [m/s, frame of the shape]; what it
    /// touches wakes.
    ///
    /// # Errors
    /// A number is not finite or too large; then nothing is changed.
    pub fn set_surface_velocity(&mut self, v: impl Into<Vec3>) -> Result<(), DefError> {
        let v = v.into();
        velocity("surface_velocity", v)?;
        self.world.tables.shapes.at_mut(self.row).surface_velocity = v;
        self.refresh_contacts();
        Ok(())
    }

    /// Lets its surface turn over it, about its origin [rad/s, frame of the shape]; what it touches
    /// wakes.
    ///
    /// # Errors
    /// A number is not finite or too large; then nothing is changed.
    pub fn set_surface_spin(&mut self, spin: impl Into<Vec3>) -> Result<(), DefError> {
        let spin = spin.into();
        velocity("surface_spin", spin)?;
        self.world.tables.shapes.at_mut(self.row).surface_spin = spin;
        self.refresh_contacts();
        Ok(())
    }

    pub(super) fn packed(&self, reports: &ContactReports, senses: Senses) -> PackedReports {
        let is_one_way = self.world.tables.shapes.at(self.row).reports.is_one_way();
        PackedReports::new(reports, senses).with_one_way(is_one_way)
    }

    /// Rows of its contacts, those of all parts.
    pub(super) fn contacts(&self) -> Vec<u32> {
        let tables = &self.world.tables;
        let body = tables.shapes.at(self.row).body;
        let of_shape = |row: &u32| {
            let c = tables.contacts.at(*row);
            c.shape_a == self.row || c.shape_b == self.row
        };
        let rows = tables.contacts.of_body(tables.bodies.at(body)).map(|(row, _)| row);
        rows.filter(of_shape).collect()
    }

    /// The pairs it is in take over its surface; it and what it touches wake.
    pub(super) fn refresh_contacts(&mut self) {
        let body = self.world.tables.shapes.at(self.row).body;
        let rows = self.contacts();
        self.world.sets().wake(body);
        for row in rows {
            let tables = &self.world.tables;
            let c = tables.contacts.at(row);
            let (shape_a, shape_b) = (tables.shapes.at(c.shape_a), tables.shapes.at(c.shape_b));
            let surface = PairSurface::of(shape_a, shape_b, &tables.shapes.rules);
            let other = if c.body_a == body { c.body_b } else { c.body_a };
            let mut sets = self.world.sets();
            sets.set_surface(row, &surface);
            sets.wake(other);
        }
    }
}
