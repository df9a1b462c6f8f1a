//! Rows of particles, links and attachments.

use crate::base::grow;
use crate::base::math::{Vec3, vec3};
use crate::base::simd::wide::{LANES, Lanes};
use crate::state::def::material::{Filter, Material};
#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

/// Data of a particle that are read at most once per step.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Particle {
    pub(crate) mass: f32,
    pub(crate) gravity_scale: f32,
    pub(crate) damping: f32,
    /// Distance from `x` within which fixed shapes need no test [m]; 0: unknown.
    pub(crate) room: f32,
    /// Time for which it has been still [s].
    pub(crate) still_time: f32,
    pub(crate) pinned: bool,
    /// It is at rest and left out of steps until something wakes it.
    pub(crate) frozen: bool,
    /// Its state became non-finite; it is left out of steps.
    pub(crate) faulted: bool,
    /// Number of links that end at it.
    pub(crate) links: u32,
    /// Minimum line of its strand, the set of particles that are connected by links. Valid unless
    /// [`Particles::strands_changed`].
    pub(crate) strand: u32,
    /// Index of its attachment + 1, or 0.
    pub(crate) attachment: u32,
    pub(crate) material: Material,
    pub(crate) filter: Filter,
    /// Colors of its links, one bit each.
    pub(crate) colors: u64,
}

/// Data of a particle that the passes of substeps read and write. Line 0 belongs to no particle;
/// idle lanes refer to it.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[repr(C, align(32))]
pub(crate) struct ParticleState {
    /// Velocity [m/s, world], and 1/mass [1/kg], 0 if it is pinned.
    pub(crate) v: [f32; 4],
    /// Displacement since the step's start [m], and 1 if it moves in this step; -1 if it was put
    /// aside: its links do not act.
    pub(crate) x: [f32; 4],
}

impl ParticleState {
    /// Displacement of a particle that was put aside.
    pub(crate) const OUT: [f32; 4] = [0.0, 0.0, 0.0, -1.0];

    pub(crate) const fn velocity(&self) -> Vec3 {
        vec3(self.v[0], self.v[1], self.v[2])
    }

    pub(crate) const fn displacement(&self) -> Vec3 {
        vec3(self.x[0], self.x[1], self.x[2])
    }

    pub(crate) const fn inverse_mass(&self) -> f32 {
        self.v[3]
    }

    pub(crate) const fn set_velocity(&mut self, v: Vec3) {
        self.v = [v.x, v.y, v.z, self.v[3]];
    }
}

/// Eight links. Lengths, limits and impulses live between steps; the rest is set when a step
/// begins.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[repr(C, align(64))]
pub(crate) struct LinkBlock {
    /// Lines of the particles; 0 for an idle lane.
    pub(crate) row_a: [u32; LANES],
    pub(crate) row_b: [u32; LANES],
    pub(crate) length: Lanes,
    /// For springs: stiffness [N/m] and damping [N s/m], or frequency [Hz] and damping ratio.
    pub(crate) stiffness: Lanes,
    pub(crate) damping: Lanes,
    /// Impulse of a substep along `n` on B [N s]; negative: it pulls.
    pub(crate) impulse: Lanes,
    /// Position of B minus position of A at the step's start [m].
    pub(crate) gap: [Lanes; 3],
    /// Unit vector from A to B, along which `impulse` was applied.
    pub(crate) n: [Lanes; 3],
    /// Effective mass [kg]; 0 if neither particle moves.
    pub(crate) mass: Lanes,
    /// Impulse per m/s, impulse per m, and fraction of the impulse that is released.
    pub(crate) gain: Lanes,
    pub(crate) rate: Lanes,
    pub(crate) leak: Lanes,
    /// Effective mass in sweeps without bias: 0 for springs.
    pub(crate) rigid: Lanes,
    /// 1 if it can go slack.
    pub(crate) slack: Lanes,
    pub(crate) kinds: [LaneKind; LANES],
    /// True if the link is solved with its chain.
    pub(crate) chained: [bool; LANES],
}

/// The kind of link in a lane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) enum LaneKind {
    #[default]
    Idle,
    Equal,
    AtMost,
    Rate,
    Frequency,
}

impl Default for LinkBlock {
    fn default() -> Self {
        let zero = [0.0; LANES];
        Self {
            row_a: [0; LANES],
            row_b: [0; LANES],
            length: zero,
            stiffness: zero,
            damping: zero,
            impulse: zero,
            gap: [zero; 3],
            n: [zero, [1.0; LANES], zero],
            mass: zero,
            gain: zero,
            rate: zero,
            leak: zero,
            rigid: zero,
            slack: zero,
            kinds: [LaneKind::Idle; LANES],
            chained: [false; LANES],
        }
    }
}

/// A link: its place in the blocks, and its tear limits.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Link {
    pub(crate) color: u32,
    pub(crate) block: u32,
    pub(crate) lane: u8,
    /// Tear limits; infinite: never.
    pub(crate) tear_strain: f32,
    pub(crate) tear_force: f32,
    /// Number of the cloth line to which it belongs; 0: none.
    pub(crate) thread: u32,
}

impl Link {
    pub(crate) const fn can_tear(&self) -> bool {
        self.tear_strain.is_finite() || self.tear_force.is_finite()
    }
}

/// Links that share no particle, except in the last color, [`CROWD`].
#[derive(Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct LinkColor {
    pub(crate) blocks: Vec<LinkBlock>,
    /// Lanes of removed links, the last removed first.
    pub(crate) free: Vec<(u32, u8)>,
    /// Number of used lanes in the last block.
    filled: usize,
}

impl Clone for LinkColor {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Reuses the existing lists.
    fn clone_from(&mut self, from: &Self) {
        let Self { blocks, free, filled } = from;
        self.blocks.clone_from(blocks);
        self.free.clone_from(free);
        self.filled = *filled;
    }
}

/// Number of colors. Links without a free color (at a particle with more than 63 links) are in the
/// last one, whose links are solved one after the other.
pub(crate) const COLORS: usize = 64;

pub(crate) const CROWD: usize = COLORS - 1;

/// An attachment of a particle to a point of a body.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Attachment {
    /// Line of the particle.
    pub(crate) solver_row: u32,
    pub(crate) body: u32,
    /// Anchor [m, frame of the body's center of mass].
    pub(crate) anchor: Vec3,
    /// Impulse on the particle in a substep [N s, world].
    pub(crate) impulse: Vec3,
}

/// A contact in the last step of a particle that is solved with substeps.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Touch {
    pub(crate) solver_row: u32,
    pub(crate) shape: u32,
    /// Impulse of a substep on the particle, along the normal and along the surface [N s].
    pub(crate) press: f32,
    pub(crate) rub: Vec3,
}

impl LinkColor {
    /// True if every lane is in use, free or not yet used.
    pub(in crate::state) fn is_valid(&self) -> bool {
        let lanes = self.blocks.iter().flat_map(|block| block.kinds);
        let idle = lanes.filter(|kind| *kind == LaneKind::Idle).count();
        let mut free = self.free.clone();
        free.sort_unstable();
        free.dedup();
        let is_idle = |(block, lane): &(u32, u8)| {
            let block = self.blocks.get(*block as usize);
            block.and_then(|b| b.kinds.get(usize::from(*lane))) == Some(&LaneKind::Idle)
        };
        self.filled <= LANES
            && free.len() <= idle
            && free.len() == self.free.len()
            && free.iter().all(is_idle)
    }

    /// Takes a lane for one more link. Each link of the crowd gets its own block.
    pub(crate) fn take_lane(&mut self, alone: bool) -> (u32, u8) {
        if let Some(lane) = self.free.pop() {
            return lane;
        }
        if self.blocks.is_empty() || alone || self.filled == LANES {
            grow::push(&mut self.blocks, LinkBlock::default());
            self.filled = 0;
        }
        let block = u32::try_from(self.blocks.len() - 1).expect("fewer than 2^32 links");
        let lane = u8::try_from(self.filled).expect("eight lanes");
        self.filled += 1;
        (block, lane)
    }
}
