//! Particles: one row each, in a table separate from the bodies. Links between particles are stored
//! in blocks of eight, and attachments connect particles to bodies. Only the particle passes of the
//! solver and the world write velocities and positions.

mod rows;

pub(crate) use self::rows::{
    Attachment, CROWD, LaneKind, Link, LinkBlock, LinkColor, Particle, ParticleState, Touch,
};

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::chains::{self, Chains};
use super::def::particle_def::{LinkKind, LinkSpring};
use crate::base::grow;
use crate::base::id::{LinkId, ParticleId};
use crate::base::math::{Vec3, vec3};
use crate::base::simd::wide::LANES;
use crate::base::slot_map::SlotMap;

/// All particles. Line `slot + 1` belongs to the particle in `slot`.
#[derive(Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Particles {
    pub(crate) rows: SlotMap<ParticleId, Particle>,
    /// Empty, or one more row than there are slots.
    pub(crate) states: Vec<ParticleState>,
    /// Position [m, world] and radius [m], by solver row.
    pub(crate) x: Vec<[f32; 4]>,
    pub(crate) links: SlotMap<LinkId, Link>,
    pub(crate) colors: Vec<LinkColor>,
    pub(crate) chains: Chains,
    /// True if links or attachments changed since the last search for chains.
    pub(crate) chains_changed: bool,
    /// Number of cloth lines created so far.
    pub(crate) threads: u32,
    pub(crate) attachments: Vec<Attachment>,
    /// Contacts in the order of rows, then of shapes.
    pub(crate) touches: Vec<Touch>,
    /// True if some link can tear.
    pub(crate) can_tear: bool,
    /// Length of the substeps of the particles' last step [s]; 0 before the first.
    pub(crate) last_h: f32,
    /// True if links changed since the last search for strands.
    pub(crate) strands_changed: bool,
    /// Change count of the tree of fixed shapes at which `room` was valid.
    pub(crate) fixed_seen: u64,
}

impl Clone for Particles {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Reuses the existing lists.
    fn clone_from(&mut self, from: &Self) {
        let Self {
            rows,
            states,
            x,
            links,
            colors,
            chains,
            attachments,
            touches,
            chains_changed,
            threads,
            can_tear,
            last_h,
            strands_changed,
            fixed_seen,
        } = from;
        self.rows.clone_from(rows);
        self.states.clone_from(states);
        self.x.clone_from(x);
        self.links.clone_from(links);
        self.colors.clone_from(colors);
        self.chains.clone_from(chains);
        self.attachments.clone_from(attachments);
        self.touches.clone_from(touches);
        self.chains_changed = *chains_changed;
        self.threads = *threads;
        self.can_tear = *can_tear;
        self.last_h = *last_h;
        self.strands_changed = *strands_changed;
        self.fixed_seen = *fixed_seen;
    }
}

impl Particles {
    pub(crate) const fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    pub(crate) fn position(&self, solver_row: u32) -> Vec3 {
        let x = &self.x[solver_row as usize];
        vec3(x[0], x[1], x[2])
    }

    pub(crate) fn at(&self, solver_row: u32) -> &Particle {
        self.rows.at(solver_row - 1).expect("tables name living particles only")
    }

    pub(crate) fn at_mut(&mut self, solver_row: u32) -> &mut Particle {
        self.rows.at_mut(solver_row - 1).expect("tables name living particles only")
    }

    /// Adds a particle.
    pub(crate) fn insert(
        &mut self,
        particle: Particle,
        x: Vec3,
        v: Vec3,
        radius: f32,
    ) -> ParticleId {
        let inverse_mass = if particle.pinned { 0.0 } else { 1.0 / particle.mass };
        let id = self.rows.insert(particle);
        let solver_row = id.index() as usize + 1;
        if self.states.is_empty() {
            grow::push(&mut self.states, ParticleState::default());
            grow::push(&mut self.x, [0.0; 4]);
        }
        if self.states.len() <= solver_row {
            grow::push(&mut self.states, ParticleState::default());
            grow::push(&mut self.x, [0.0; 4]);
        }
        self.states[solver_row] = ParticleState { v: [v.x, v.y, v.z, inverse_mass], x: [0.0; 4] };
        self.x[solver_row] = [x.x, x.y, x.z, radius];
        self.at_mut(id.index() + 1).strand = id.index() + 1;
        id
    }

    /// Removes a particle that has neither links nor an attachment.
    pub(crate) fn remove(&mut self, id: ParticleId) {
        let solver_row = id.index() + 1;
        // Its links are gone, so it is a strand by itself, or strands will be searched again.
        self.rows.remove(id);
        self.states[solver_row as usize] = ParticleState::default();
        self.touches.retain(|t| t.solver_row != solver_row);
    }

    /// Searches again for particles connected by links, if links changed.
    pub(crate) fn find_strands(&mut self) {
        if !core::mem::take(&mut self.strands_changed) {
            return;
        }
        for (slot, row) in (0_u32..).zip(self.rows.values_mut()) {
            if let Some(p) = row {
                p.strand = slot + 1;
            }
        }
        for color in 0..self.colors.len() {
            for block in 0..self.colors[color].blocks.len() {
                for lane in 0..LANES {
                    let b = &self.colors[color].blocks[block];
                    let (x, y) = (b.row_a[lane], b.row_b[lane]);
                    if x != 0 {
                        let (x, y) = (self.first_of(x), self.first_of(y));
                        self.at_mut(x.max(y)).strand = x.min(y);
                    }
                }
            }
        }
        for slot in 0..self.rows.slot_count() {
            let solver_row = number(slot) + 1;
            if self.rows.at(solver_row - 1).is_some() {
                // Earlier particles already have their strand, so this takes one or two iterations.
                self.at_mut(solver_row).strand = self.first_of(solver_row);
            }
        }
    }

    /// Searches again for chains of links, if links or attachments changed.
    pub(crate) fn find_chains(&mut self) {
        if core::mem::take(&mut self.chains_changed) {
            chains::find(self);
        }
    }

    /// The end of the chain of `strand` values during the search for strands.
    fn first_of(&mut self, mut solver_row: u32) -> u32 {
        loop {
            let up = self.at(solver_row).strand;
            if up == solver_row {
                return solver_row;
            }
            let next = self.at(up).strand;
            self.at_mut(solver_row).strand = next;
            solver_row = next;
        }
    }

    /// Takes a particle that was put aside out of its links, chains and attachment, and clears
    /// their impulses.
    pub(crate) fn take_out(&mut self, solver_row: u32) {
        for block in self.colors.iter_mut().flat_map(|color| &mut color.blocks) {
            for lane in 0..LANES {
                if block.row_a[lane] == solver_row || block.row_b[lane] == solver_row {
                    block.impulse[lane] = 0.0;
                    let n = [0.0, 1.0, 0.0];
                    (0..3).for_each(|k| (block.n[k][lane], block.gap[k][lane]) = (n[k], 0.0));
                }
            }
        }
        if let Some(number) = self.at(solver_row).attachment.checked_sub(1) {
            self.attachments[number as usize].impulse = Vec3::ZERO;
        }
        self.touches.retain(|touch| touch.solver_row != solver_row);
        self.chains_changed = true;
    }

    /// Adds a link between two particles.
    pub(crate) fn insert_link(
        &mut self,
        [a, b]: [u32; 2],
        kind: LinkKind,
        length: f32,
        [tear_strain, tear_force]: [f32; 2],
        thread: u32,
    ) -> LinkId {
        let used = self.at(a).colors | self.at(b).colors;
        let color = ((!used).trailing_zeros() as usize).min(CROWD);
        let bit = if color < CROWD { 1 << color } else { 0 };
        for solver_row in [a, b] {
            let particle = self.at_mut(solver_row);
            particle.colors |= bit;
            particle.links += 1;
        }
        self.strands_changed = true;
        self.chains_changed = true;
        if self.colors.len() <= color {
            self.colors.resize_with(color + 1, LinkColor::default);
        }
        let (block, lane) = self.colors[color].take_lane(color == CROWD);
        let (lane_kind, stiffness, damping) = match kind {
            LinkKind::Equal => (LaneKind::Equal, 0.0, 0.0),
            LinkKind::AtMost => (LaneKind::AtMost, 0.0, 0.0),
            LinkKind::Spring(LinkSpring::Rate { stiffness, damping }) => {
                (LaneKind::Rate, stiffness, damping)
            }
            LinkKind::Spring(LinkSpring::Frequency { hertz, damping_ratio }) => {
                (LaneKind::Frequency, hertz, damping_ratio)
            }
        };
        let (to, l) = (&mut self.colors[color].blocks[block as usize], usize::from(lane));
        (to.row_a[l], to.row_b[l], to.length[l]) = (a, b, length);
        (to.stiffness[l], to.damping[l]) = (stiffness, damping);
        (to.impulse[l], to.kinds[l]) = (0.0, lane_kind);
        self.can_tear |= tear_strain.is_finite() || tear_force.is_finite();
        let color = u32::try_from(color).expect("64 colors");
        self.links.insert(Link { color, block, lane, tear_strain, tear_force, thread })
    }

    /// Removes a link.
    pub(crate) fn remove_link(&mut self, id: LinkId) -> bool {
        let Some(link) = self.links.remove(id) else { return false };
        let lane = usize::from(link.lane);
        let color = &mut self.colors[link.color as usize];
        let block = &mut color.blocks[link.block as usize];
        let ends = [block.row_a[lane], block.row_b[lane]];
        (block.row_a[lane], block.row_b[lane]) = (0, 0);
        (block.impulse[lane], block.kinds[lane]) = (0.0, LaneKind::Idle);
        color.free.push((link.block, link.lane));
        self.strands_changed = true;
        self.chains_changed = true;
        let bit = if (link.color as usize) < CROWD { 1_u64 << link.color } else { 0 };
        for solver_row in ends {
            let particle = self.at_mut(solver_row);
            particle.colors &= !bit;
            particle.links -= 1;
        }
        true
    }

    pub(crate) fn block_of(&self, link: &Link) -> (&LinkBlock, usize) {
        let block = &self.colors[link.color as usize].blocks[link.block as usize];
        (block, usize::from(link.lane))
    }

    /// Attaches a particle to a point of a body.
    pub(crate) fn attach(&mut self, attachment: Attachment) {
        self.chains_changed = true;
        let at = match self.at(attachment.solver_row).attachment {
            0 => {
                self.attachments.push(attachment);
                number(self.attachments.len())
            }
            old => {
                self.attachments[old as usize - 1] = attachment;
                old
            }
        };
        self.at_mut(attachment.solver_row).attachment = at;
    }

    /// Detaches a particle; false if it was not attached. Later attachments move up and keep their
    /// order.
    pub(crate) fn detach(&mut self, solver_row: u32) -> bool {
        let at = core::mem::take(&mut self.at_mut(solver_row).attachment);
        if at == 0 {
            return false;
        }
        self.chains_changed = true;
        self.attachments.remove(at as usize - 1);
        for i in at as usize - 1..self.attachments.len() {
            let solver_row = self.attachments[i].solver_row;
            self.at_mut(solver_row).attachment -= 1;
        }
        true
    }

    /// Wakes the strand of a frozen particle, or only the particle if it is awake.
    pub(crate) fn wake(&mut self, solver_row: u32) {
        if self.at(solver_row).frozen {
            self.wake_strand(solver_row);
        } else {
            self.wake_one(solver_row);
        }
    }

    /// Wakes the strand of a particle even if the particle is not frozen, because an attached body
    /// may be asleep.
    pub(crate) fn wake_strand(&mut self, solver_row: u32) {
        self.find_strands();
        let strand = self.at(solver_row).strand;
        for particle in self.rows.values_mut().iter_mut().flatten() {
            if particle.strand == strand {
                (particle.frozen, particle.still_time) = (false, 0.0);
            }
        }
    }

    pub(crate) fn wake_one(&mut self, solver_row: u32) {
        let particle = self.at_mut(solver_row);
        (particle.frozen, particle.still_time) = (false, 0.0);
    }

    /// Wakes all particles, and invalidates their knowledge of nearby shapes.
    pub(crate) fn wake_all(&mut self) {
        for particle in self.rows.values_mut().iter_mut().flatten() {
            (particle.frozen, particle.still_time, particle.room) = (false, 0.0, 0.0);
        }
    }
}

fn number(n: usize) -> u32 {
    u32::try_from(n).expect("fewer than 2^32 particles")
}
