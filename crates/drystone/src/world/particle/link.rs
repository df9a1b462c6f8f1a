//! Links between particles: read, changed, added and removed.

use crate::base::id::{LinkId, ParticleId};
use crate::base::math::bounded;
use crate::query::particles::{link_energy, link_kind};
use crate::state::def::DefError;
use crate::state::def::particle_def::{LinkDef, LinkKind, check_length};
use crate::state::particles::Link;
use crate::state::tables::Tables;
use crate::world::World;

/// A link, read-only.
#[derive(Clone, Copy, Debug)]
pub struct LinkRef<'w> {
    tables: &'w Tables,
    link: &'w Link,
    id: LinkId,
    h: f32,
}

impl LinkRef<'_> {
    /// Its id.
    #[must_use]
    pub const fn id(&self) -> LinkId {
        self.id
    }

    fn ends(&self) -> [u32; 2] {
        let (block, lane) = self.tables.particles.block_of(self.link);
        [block.row_a[lane], block.row_b[lane]]
    }

    /// Its particles.
    #[must_use]
    pub fn particles(&self) -> [ParticleId; 2] {
        let [a, b] = self.ends();
        let id =
            |solver_row: u32| self.tables.particles.rows.id_at(solver_row - 1).expect("ends live");
        [id(a), id(b)]
    }

    /// Its kind.
    #[must_use]
    pub fn kind(&self) -> LinkKind {
        let (block, lane) = self.tables.particles.block_of(self.link);
        link_kind(block, lane)
    }

    /// Its length [m]: the fixed, maximum or rest length, depending on its kind.
    #[must_use]
    pub fn length(&self) -> f32 {
        let (block, lane) = self.tables.particles.block_of(self.link);
        block.length[lane]
    }

    /// Current distance of its particles [m].
    #[must_use]
    pub fn distance(&self) -> f32 {
        let [a, b] = self.ends();
        let particles = &self.tables.particles;
        (particles.position(b) - particles.position(a)).length()
    }

    /// Constraint error [m]: the deviation of a rod from its length, or the excess of a thread. 0
    /// for a spring.
    #[must_use]
    pub fn error(&self) -> f32 {
        let excess = self.distance() - self.length();
        match self.kind() {
            LinkKind::Equal => excess.abs(),
            LinkKind::AtMost => excess.max(0.0),
            LinkKind::Spring(_) => 0.0,
        }
    }

    /// Tension in the last substep [N]; negative if it pushed.
    #[must_use]
    pub fn tension(&self) -> f32 {
        let (block, lane) = self.tables.particles.block_of(self.link);
        if self.h > 0.0 { bounded(-block.impulse[lane] / self.h) } else { 0.0 }
    }

    /// Elastic energy ½ k x² of a spring [J]; 0 for other links.
    #[must_use]
    pub fn elastic_energy(&self) -> f64 {
        link_energy(&self.tables.particles, self.link)
    }
}

impl World {
    /// Adds a link, and wakes its particles.
    ///
    /// # Errors
    /// A particle is not of this world, or both are the same; a field is out of range; no length is
    /// given and the particles are at one point. Then nothing is added.
    pub fn add_link(&mut self, def: LinkDef) -> Result<LinkId, DefError> {
        self.add_link_of(def, 0)
    }

    /// Adds a link that belongs to a line of a cloth; thread 0: to none.
    pub(in crate::world) fn add_link_of(
        &mut self,
        def: LinkDef,
        thread: u32,
    ) -> Result<LinkId, DefError> {
        def.validate()?;
        let particles = &mut self.tables.particles;
        let find = |name: &str, id: ParticleId| {
            let row = particles.rows.row(id);
            row.ok_or_else(|| {
                DefError::missing(
                    name,
                    format_args!("ParticleId {}", id.index()),
                    "a particle of this world",
                )
            })
        };
        let (a, b) = (find("a", def.a)? + 1, find("b", def.b)? + 1);
        if a == b {
            return Err(DefError::unsuitable(
                "b",
                "the same particle",
                "a particle other than `a`",
            ));
        }
        let apart = (particles.position(b) - particles.position(a)).length();
        let length = def.length.unwrap_or(apart);
        check_length(length)?;
        particles.wake(a);
        particles.wake(b);
        let tears = [def.tear_strain, def.tear_force].map(|limit| limit.unwrap_or(f32::INFINITY));
        Ok(particles.insert_link([a, b], def.kind, length, tears, thread))
    }

    /// Removes a link, and wakes its particles. False if there is no such link.
    pub fn remove_link(&mut self, id: LinkId) -> bool {
        let particles = &mut self.tables.particles;
        let Some(row) = particles.links.row(id) else { return false };
        let link = particles.links.at(row).expect("the row of an id lives");
        let (block, lane) = particles.block_of(link);
        let solver_row = block.row_a[lane];
        particles.wake_strand(solver_row);
        particles.remove_link(id)
    }

    /// The link, unless it was removed or torn.
    #[must_use]
    pub fn link(&self, id: LinkId) -> Option<LinkRef<'_>> {
        let tables = &self.tables;
        let link = tables.particles.links.at(tables.particles.links.row(id)?)?;
        Some(LinkRef { tables, link, id, h: tables.particles.last_h })
    }

    /// The link for changes, unless it was removed or torn.
    #[must_use]
    pub fn link_mut(&mut self, id: LinkId) -> Option<LinkMut<'_>> {
        let row = self.tables.particles.links.row(id)?;
        Some(LinkMut { world: self, row, id })
    }

    /// All links in the order of their slots.
    pub fn links(&self) -> impl Iterator<Item = LinkRef<'_>> {
        let (tables, h) = (&self.tables, self.tables.particles.last_h);
        tables.particles.links.iter().map(move |(id, link)| LinkRef { tables, link, id, h })
    }
}

/// A link, for changes.
#[derive(Debug)]
pub struct LinkMut<'w> {
    pub(in crate::world) world: &'w mut World,
    row: u32,
    id: LinkId,
}

impl LinkMut<'_> {
    /// The link, read-only.
    #[must_use]
    pub fn get(&self) -> LinkRef<'_> {
        let tables = &self.world.tables;
        let link = tables.particles.links.at(self.row).expect("the row of an id lives");
        LinkRef { tables, link, id: self.id, h: tables.particles.last_h }
    }

    /// See [`Self::set_length`].
    pub(in crate::world) fn try_set_length(&mut self, length: f32) -> Result<(), DefError> {
        check_length(length)?;
        let particles = &mut self.world.tables.particles;
        let link = *particles.links.at(self.row).expect("the row of an id lives");
        let block = &mut particles.colors[link.color as usize].blocks[link.block as usize];
        let lane = usize::from(link.lane);
        block.length[lane] = length;
        let solver_row = block.row_a[lane];
        particles.wake_strand(solver_row);
        Ok(())
    }
}
