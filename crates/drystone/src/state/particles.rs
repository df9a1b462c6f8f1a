//! Particles: one row each, in a table separate from the bodies. Links between particles are stored
//! in blocks of eight, and attachments connect particles to bodies. Only the particle passes of the
//! solver and the world write velocities and positions.

mod rows;

pub(crate) use self::rows::{
    Attachment, CROWD, LaneKind, Link, LinkBlock, LinkColor, Particle, ParticleLine, Touch,
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
    /// Empty, or one more line than there are slots.
    pub(crate) lines: Vec<ParticleLine>,
    /// Position [m, world] and radius [m], by line.
    pub(crate) x: Vec<[f32; 4]>,
    pub(crate) links: SlotMap<LinkId, Link>,
    pub(crate) colors: Vec<LinkColor>,
    pub(crate) chains: Chains,
    /// True if links or attachments changed since the last search for chains.
    pub(crate) chains_changed: bool,
    /// Number of cloth lines created so far.
    pub(crate) threads: u32,
    pub(crate) attachments: Vec<Attachment>,
    /// Contacts in the order of lines, then of shapes.
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
            lines,
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
        self.lines.clone_from(lines);
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

    pub(crate) fn position(&self, line: u32) -> Vec3 {
        let x = &self.x[line as usize];
        vec3(x[0], x[1], x[2])
    }

    pub(crate) fn at(&self, line: u32) -> &Particle {
        self.rows.at(line - 1).expect("tables name living particles only")
    }

    pub(crate) fn at_mut(&mut self, line: u32) -> &mut Particle {
        self.rows.at_mut(line - 1).expect("tables name living particles only")
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
        let line = id.index() as usize + 1;
        if self.lines.is_empty() {
            grow::push(&mut self.lines, ParticleLine::default());
            grow::push(&mut self.x, [0.0; 4]);
        }
        if self.lines.len() <= line {
            grow::push(&mut self.lines, ParticleLine::default());
            grow::push(&mut self.x, [0.0; 4]);
        }
        self.lines[line] = ParticleLine { v: [v.x, v.y, v.z, inverse_mass], x: [0.0; 4] };
        self.x[line] = [x.x, x.y, x.z, radius];
        self.at_mut(id.index() + 1).strand = id.index() + 1;
        id
    }

    /// Removes a particle that has neither links nor an attachment.
    pub(crate) fn remove(&mut self, id: ParticleId) {
        let line = id.index() + 1;
        // Its links are gone, so it is a strand by itself, or strands will be searched again.
        self.rows.remove(id);
        self.lines[line as usize] = ParticleLine::default();
        self.touches.retain(|t| t.line != line);
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
            let line = number(slot) + 1;
            if self.rows.at(line - 1).is_some() {
                // Earlier particles already have their strand, so this takes one or two iterations.
                self.at_mut(line).strand = self.first_of(line);
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
    fn first_of(&mut self, mut line: u32) -> u32 {
        loop {
            let up = self.at(line).strand;
            if up == line {
                return line;
            }
            let next = self.at(up).strand;
            self.at_mut(line).strand = next;
            line = next;
        }
    }

    /// Takes a particle that was put aside out of its links, chains and attachment, and clears
    /// their impulses.
    pub(crate) fn take_out(&mut self, line: u32) {
        for block in self.colors.iter_mut().flat_map(|color| &mut color.blocks) {
            for lane in 0..LANES {
                if block.row_a[lane] == line || block.row_b[lane] == line {
                    block.impulse[lane] = 0.0;
                    let n = [0.0, 1.0, 0.0];
                    (0..3).for_each(|k| (block.n[k][lane], block.gap[k][lane]) = (n[k], 0.0));
                }
            }
        }
        if let Some(number) = self.at(line).attachment.checked_sub(1) {
            self.attachments[number as usize].impulse = Vec3::ZERO;
        }
        self.touches.retain(|touch| touch.line != line);
        self.chains_changed = true;
    }

    /// Adds a link between the particles of two lines.
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
        for line in [a, b] {
            let particle = self.at_mut(line);
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
        for line in ends {
            let particle = self.at_mut(line);
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
        let at = match self.at(attachment.line).attachment {
            0 => {
                self.attachments.push(attachment);
                number(self.attachments.len())
            }
            old => {
                self.attachments[old as usize - 1] = attachment;
                old
            }
        };
        self.at_mut(attachment.line).attachment = at;
    }

    /// Detaches a particle; false if it was not attached. Later attachments move up and keep their
    /// order.
    pub(crate) fn detach(&mut self, line: u32) -> bool {
        let at = core::mem::take(&mut self.at_mut(line).attachment);
        if at == 0 {
            return false;
        }
        self.chains_changed = true;
        self.attachments.remove(at as usize - 1);
        for i in at as usize - 1..self.attachments.len() {
            let line = self.attachments[i].line;
            self.at_mut(line).attachment -= 1;
        }
        true
    }

    /// Wakes the strand of a frozen particle, or only the particle if it is awake.
    pub(crate) fn wake(&mut self, line: u32) {
        if self.at(line).frozen {
            self.wake_strand(line);
        } else {
            self.wake_one(line);
        }
    }

    /// Wakes the strand of a particle even if the particle is not frozen, because an attached body
    /// may be asleep.
    pub(crate) fn wake_strand(&mut self, line: u32) {
        self.find_strands();
        let strand = self.at(line).strand;
        for particle in self.rows.values_mut().iter_mut().flatten() {
            if particle.strand == strand {
                (particle.frozen, particle.still_time) = (false, 0.0);
            }
        }
    }

    pub(crate) fn wake_one(&mut self, line: u32) {
        let particle = self.at_mut(line);
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
