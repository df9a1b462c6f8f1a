//! Hashes of the state of a world. Equal runs give equal hashes, and different hashes locate a
//! difference.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::base::hash::StateHash;
use crate::state::bodies::body::Body;
use crate::state::joints::JointModel;
use crate::step::Stage;
use crate::world::World;

/// Adds pose and velocity to the hash.
pub(crate) fn feed_state(hash: &mut StateHash, body: &Body) {
    hash.vector(body.center);
    hash.floats(&body.rotation.to_array());
    hash.vector(body.v);
    hash.vector(body.w);
}

/// A hash for each stage of a step: see [`World::stage_hashes`].
///
/// ```
/// use drystone::{BodyDef, ShapeDef, Stage, World};
///
/// # fn main() -> Result<(), drystone::DefError> {
/// let mut world = World::default();
/// let ball = world.add_body(BodyDef::dynamic().with_shape(ShapeDef::sphere(0.5)))?;
/// let mut other = world.clone();
/// if let Some(mut ball) = other.body_mut(ball) {
///     ball.apply_impulse([1.0, 0.0, 0.0]);
/// }
/// world.step(1.0 / 60.0);
/// other.step(1.0 / 60.0);
/// let (ours, theirs) = (world.stage_hashes(), other.stage_hashes());
/// assert_eq!(ours.first_difference(&theirs), Some(Stage::Finalize));
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct StageHashes(Vec<u64>);

impl StageHashes {
    /// The stages in order, with their hashes.
    pub fn iter(&self) -> impl Iterator<Item = (Stage, u64)> {
        Stage::ALL.iter().copied().zip(self.0.iter().copied())
    }

    /// Changes the hash of this stage.
    #[cfg(test)]
    pub(crate) fn change(&mut self, stage: Stage) {
        if let Some(place) = Stage::ALL.iter().position(|s| *s == stage) {
            self.0[place] ^= 1;
        }
    }

    /// The first stage whose results in the tables differ from those in `other`.
    #[must_use]
    pub fn first_difference(&self, other: &Self) -> Option<Stage> {
        let pairs = || self.iter().zip(other.iter());
        let differs = |of: Stage| pairs().any(|(a, b)| a.0 == of && a.1 != b.1);
        let first = pairs().find(|(a, b)| a.1 != b.1).map(|(a, _)| a.0);
        // Bodies that fall asleep leave the colors; in that case nothing else differs.
        let moved = [Stage::Particles, Stage::Solver, Stage::Finalize].into_iter().any(differs);
        if first == Some(Stage::Partition) && differs(Stage::Sleep) && !moved {
            return Some(Stage::Sleep);
        }
        first
    }
}

impl World {
    /// A 64-bit hash of the bits of pose and velocity of every body in slot order, then of every
    /// particle.
    #[must_use]
    pub fn state_hash(&self) -> u64 {
        let mut hash = StateHash::default();
        for (id, body) in self.tables.bodies.rows.iter() {
            hash.word(id.index());
            feed_state(&mut hash, body);
        }
        self.feed_points(&mut hash);
        hash.finish()
    }

    /// A hash for each stage of the last step, in the order of [`Stage::ALL`], of the data that the
    /// stage left in the tables. Two runs first diverged in the first stage whose hashes differ.
    /// Each hash covers data that only its stage writes: pairs of shapes, manifolds, colors,
    /// particles, impulses, poses, events, and sleep states. Poses are written by two stages,
    /// [`Stage::Finalize`] and [`Stage::Sweep`]. Bodies that fall asleep leave the colors, so a
    /// difference in only [`Stage::Partition`] and [`Stage::Sleep`] is one of sleep.
    #[must_use]
    pub fn stage_hashes(&self) -> StageHashes {
        let of = |stage: &Stage| {
            let mut hash = StateHash::default();
            match *stage {
                Stage::Broadphase => self.feed_pairs(&mut hash),
                Stage::Narrowphase => self.feed_manifolds(&mut hash),
                Stage::Partition => self.feed_colors(&mut hash),
                Stage::Particles => self.feed_particles(&mut hash),
                Stage::Solver => self.feed_impulses(&mut hash),
                Stage::Finalize | Stage::Sweep => self.feed_poses(&mut hash),
                Stage::Sleep => self.feed_sleep(&mut hash),
                Stage::Report => self.feed_events(&mut hash),
                Stage::Breakage => self.feed_breaks(&mut hash),
            }
            hash.finish()
        };
        StageHashes(Stage::ALL.iter().map(of).collect())
    }

    fn feed_points(&self, hash: &mut StateHash) {
        for (slot, x, v) in self.tables.particles.words() {
            hash.word(slot);
            hash.vector(x);
            hash.vector(v);
        }
    }

    fn feed_pairs(&self, hash: &mut StateHash) {
        for (row, c) in self.tables.contacts.iter() {
            hash.words(&[row, c.shape_a, c.shape_b]);
        }
    }

    fn feed_manifolds(&self, hash: &mut StateHash) {
        for (row, c) in self.tables.contacts.iter() {
            hash.words(&[row, u32::from(c.count)]);
            if c.count > 0 {
                hash.vector(c.normal);
                hash.vector(c.offset);
            }
            for p in c.points() {
                hash.vector(p.r_a);
                hash.word(p.base.to_bits());
                hash.word(p.feature);
            }
        }
    }

    fn feed_colors(&self, hash: &mut StateHash) {
        let contacts = self.tables.contacts.iter().map(|(row, c)| (row, c.place.color));
        let joints = self.tables.joints.rows.iter().map(|(id, j)| (id.index(), j.place.color));
        for (row, color) in contacts.chain(joints) {
            hash.words(&[row, color]);
        }
    }

    fn feed_particles(&self, hash: &mut StateHash) {
        self.feed_points(hash);
        for block in self.tables.particles.colors.iter().flat_map(|color| &color.blocks) {
            hash.floats(&block.impulse);
        }
    }

    fn feed_impulses(&self, hash: &mut StateHash) {
        for (_, c) in self.tables.contacts.iter().filter(|(_, c)| c.count > 0) {
            c.points().iter().for_each(|p| hash.word(p.impulse.to_bits()));
            hash.vector(c.tangent_impulse);
            hash.vector(c.rolling_impulse());
            hash.word(c.twist_impulse.to_bits());
        }
        for (_, articulation) in self.tables.articulations.rows.iter() {
            for number in articulation.model.q().iter().chain(articulation.model.v()) {
                let bits = number.to_bits();
                #[expect(clippy::cast_possible_truncation, reason = "both halves")]
                hash.words(&[bits as u32, (bits >> 32) as u32]);
            }
        }
        for (_, joint) in self.tables.joints.rows.iter() {
            hash.vector(joint.impulse);
            match &joint.model {
                JointModel::SixDof(six_dof) => hash.words(bytemuck::cast_slice(&[six_dof.state])),
                JointModel::Coupling(coupling) => hash.word(coupling.impulse.to_bits()),
                JointModel::Ball
                | JointModel::Distance { .. }
                | JointModel::Pulley(_)
                | JointModel::Link => {}
            }
        }
    }

    fn feed_poses(&self, hash: &mut StateHash) {
        for (id, body) in self.tables.bodies.rows.iter() {
            hash.word(id.index());
            hash.vector(body.center);
            hash.floats(&body.rotation.to_array());
        }
    }

    fn feed_events(&self, hash: &mut StateHash) {
        let e = &self.tables.events;
        let touches = e.contact_begin.iter().chain(&e.contact_end).map(|t| [t.shape_a, t.shape_b]);
        let visits = e.sensor_enter.iter().chain(&e.sensor_exit).map(|v| [v.sensor, v.visitor]);
        touches.chain(visits).flatten().for_each(|shape| hash.word(shape.index()));
        e.hits.iter().for_each(|hit| hash.vector(hit.point));
        e.sleep.iter().chain(&e.wake).for_each(|body| hash.word(body.index()));
        let counts = [e.contact_begin.len(), e.sensor_enter.len(), e.hits.len(), e.faults.len()];
        counts.into_iter().chain([e.link_tear.len()]).for_each(|n| hash.count(n));
    }

    fn feed_breaks(&self, hash: &mut StateHash) {
        let e = &self.tables.events;
        e.joint_break.iter().for_each(|broken| hash.word(broken.joint.index()));
        e.pieces.iter().for_each(|body| hash.word(body.index()));
        [e.bond_break.len(), e.fractures.len()].into_iter().for_each(|n| hash.count(n));
    }

    fn feed_sleep(&self, hash: &mut StateHash) {
        for (id, body) in self.tables.bodies.rows.iter() {
            hash.words(&[id.index(), body.sleep.island, u32::from(body.active())]);
            hash.word(body.sleep.still_time.to_bits());
            hash.vector(body.v);
            hash.vector(body.w);
        }
    }
}
