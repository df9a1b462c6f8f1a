//! An articulation of a world, for reading and for changes.

use crate::base::id::{ArticulationId, BodyId};
use crate::reduced::{Articulation, TreeDef, TreeError, TreeStepConfig};
use crate::state::articulations::ArticulationRow;
use crate::state::tables::Tables;
use crate::world::World;

/// An articulation of a world, read-only.
#[derive(Clone, Copy, Debug)]
pub struct ArticulationRef<'w> {
    tables: &'w Tables,
    row: &'w ArticulationRow,
    id: ArticulationId,
}

impl<'w> ArticulationRef<'w> {
    pub(super) const fn new(
        tables: &'w Tables,
        row: &'w ArticulationRow,
        id: ArticulationId,
    ) -> Self {
        Self { tables, row, id }
    }

    /// Its id.
    #[must_use]
    pub const fn id(&self) -> ArticulationId {
        self.id
    }

    /// The tree with its present state: coordinates, kinematics, Jacobians, dynamics.
    #[must_use]
    pub const fn model(&self) -> &'w Articulation {
        &self.row.model
    }

    /// Its definition, without shapes.
    #[must_use]
    pub const fn tree(&self) -> &'w TreeDef {
        &self.row.def
    }

    /// Coordinates \[m, rad, unit quaternions\].
    #[must_use]
    pub fn q(&self) -> &'w [f64] {
        self.row.model.q()
    }

    /// Velocities \[m/s, rad/s\].
    #[must_use]
    pub fn v(&self) -> &'w [f64] {
        self.row.model.v()
    }

    /// Number of links.
    #[must_use]
    pub const fn link_count(&self) -> usize {
        self.row.model.link_count()
    }

    /// The body of a link.
    #[must_use]
    pub fn body(&self, link: usize) -> Option<BodyId> {
        Some(self.tables.bodies.id(*self.row.bodies.get(link)?))
    }

    /// The bodies of all links, in their order.
    pub fn bodies(&self) -> impl Iterator<Item = BodyId> + use<'w> {
        let bodies = &self.tables.bodies;
        self.row.bodies.iter().map(|row| bodies.id(*row))
    }

    /// Whether it sleeps.
    #[must_use]
    pub fn is_asleep(&self) -> bool {
        self.row.bodies.iter().any(|row| self.tables.bodies.at(*row).sleeps())
    }
}

/// An articulation of a world for changes.
#[derive(Debug)]
pub struct ArticulationMut<'w> {
    world: &'w mut World,
    row: u32,
    id: ArticulationId,
}

impl<'w> ArticulationMut<'w> {
    pub(super) const fn new(world: &'w mut World, row: u32, id: ArticulationId) -> Self {
        Self { world, row, id }
    }

    /// The articulation, read-only.
    #[must_use]
    pub fn get(&self) -> ArticulationRef<'_> {
        self.world.articulation(self.id).expect("what is borrowed is not removed")
    }

    fn model(&mut self) -> &mut Articulation {
        let rows = &mut self.world.tables.articulations.rows;
        &mut rows.at_mut(self.row).expect("what is borrowed is not removed").model
    }

    /// Wakes it.
    pub fn wake(&mut self) {
        for body in self.world.bodies_of_articulation(self.row) {
            self.world.sets().wake(body);
        }
    }

    /// Sets coordinates \[m, rad, quaternions of any length\] and velocities \[m/s, rad/s\]. Moves
    /// its bodies and wakes them. An articulation that a fault took out of the world comes back.
    ///
    /// # Errors
    /// A wrong number of values, one that is not finite or beyond 1e12, or a quaternion of length
    /// 0. Nothing is changed then.
    pub fn set_state(&mut self, q: &[f64], v: &[f64]) -> Result<(), TreeError> {
        self.model().set_state(q, v)?;
        self.world.place_links(self.row);
        self.wake();
        Ok(())
    }

    /// Sets the generalized forces \[N m, N\] that act in all following steps; 0 at first. Wakes
    /// it if they change.
    ///
    /// # Errors
    /// A wrong number of values, or one that is not finite or beyond 1e12.
    pub fn set_forces(&mut self, tau: &[f64]) -> Result<(), TreeError> {
        let same = self.model().tau == tau;
        self.model().set_forces(tau)?;
        if !same {
            self.wake();
        }
        Ok(())
    }

    /// Sets the tuning of the step; numbers out of range count as the nearest in it.
    pub fn set_config(&mut self, config: TreeStepConfig) {
        self.model().set_config(config);
    }
}
