//! Public access to a shape for changes.

use super::World;
use crate::base::id::ShapeId;
use crate::base::math::Vec3;
use crate::query::shape::ShapeRef;
use crate::state::def::material::Material;
use crate::state::def::reports::{ContactReports, PackedReports, Senses};
use crate::state::def::{DefError, velocity};

/// A shape of a body, for changes.
#[derive(Debug)]
pub struct ShapeMut<'w> {
    pub(super) world: &'w mut World,
    pub(super) row: u32,
}

impl<'w> ShapeMut<'w> {
    pub(super) fn new(world: &'w mut World, id: ShapeId) -> Option<Self> {
        let row = world.tables.shapes.rows.row(id)?;
        Some(Self { world, row })
    }

    /// The shape, read-only.
    #[must_use]
    pub fn get(&self) -> ShapeRef<'_> {
        ShapeRef::at(&self.world.tables, self.row)
    }

    /// Sets the user's number.
    pub fn set_user_data(&mut self, data: u64) {
        self.world.tables.shapes.at_mut(self.row).user_data = data;
    }

    /// Sets the events that its contacts report, from the next step on. An active contact is
    /// reported with that step: as ended if contacts are no longer reported, as begun if they are
    /// reported now.
    ///
    /// # Errors
    /// The speed is out of range; then nothing is changed.
    pub fn set_reports(&mut self, reports: ContactReports) -> Result<(), DefError> {
        reports.validate()?;
        let before = self.get().reports();
        self.world.tables.shapes.set_reports(self.row, self.packed(&reports, self.get().senses()));
        if before.touches != reports.touches {
            self.world.turn_touches(self.row);
        }
        Ok(())
    }

    /// Sets its surface, from the next step on. Touching bodies wake.
    ///
    /// # Errors
    /// A field is out of range; then nothing is changed.
    pub fn set_material(&mut self, surface: Material) -> Result<(), DefError> {
        surface.validate()?;
        self.world.tables.shapes.at_mut(self.row).material = surface;
        self.refresh_contacts();
        Ok(())
    }

    /// See [`Self::set_surface_velocity`].
    pub(super) fn try_set_surface_velocity(&mut self, v: impl Into<Vec3>) -> Result<(), DefError> {
        let v = v.into();
        velocity("surface_velocity", v)?;
        self.world.tables.shapes.at_mut(self.row).surface_velocity = v;
        self.refresh_contacts();
        Ok(())
    }

    /// See [`Self::set_surface_spin`].
    pub(super) fn try_set_surface_spin(&mut self, spin: impl Into<Vec3>) -> Result<(), DefError> {
        let spin = spin.into();
        velocity("surface_spin", spin)?;
        self.world.tables.shapes.at_mut(self.row).surface_spin = spin;
        self.refresh_contacts();
        Ok(())
    }

    pub(super) fn packed(&self, reports: &ContactReports, senses: Senses) -> PackedReports {
        let before = self.world.tables.shapes.at(self.row).reports;
        let packed = PackedReports::new(reports, senses).with_one_way(before.is_one_way());
        packed.with_hooks(before.has_hooks())
    }

    /// Rows of its contacts, including secondary manifolds.
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

    /// Updates the surface of its contacts. Its body and touching bodies wake.
    pub(super) fn refresh_contacts(&mut self) {
        let body = self.world.tables.shapes.at(self.row).body;
        let rows = self.contacts();
        self.world.sets().wake(body);
        for row in rows {
            let tables = &self.world.tables;
            let c = tables.contacts.at(row);
            let surface = tables.shapes.surface_of(c.shape_a, c.shape_b);
            let other = if c.body_a == body { c.body_b } else { c.body_a };
            let mut sets = self.world.sets();
            sets.set_surface(row, &surface);
            sets.wake(other);
        }
    }
}
