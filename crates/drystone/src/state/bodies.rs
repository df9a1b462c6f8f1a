//! The table of bodies, one row each. Only the stage `finalize`, later stages and the world write
//! velocities and poses.

pub(crate) mod body;
pub(crate) mod stillness;

use std::collections::{BTreeMap, BTreeSet};

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use self::body::Body;
use self::stillness::Stillness;
use crate::base::copy;
use crate::base::grow;
use crate::base::id::BodyId;
use crate::base::math::Vec3;
use crate::base::slot_map::SlotMap;
use crate::geometry::mass::MassProperties;

/// Marks the absence of a row.
pub(crate) const NONE: u32 = u32::MAX;

/// Force and torque that contacts apply to a body.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Load {
    /// Sum of the forces [N, world], and the sum of their magnitudes.
    pub(crate) force: Vec3,
    pub(crate) size: f32,
    /// Torque about its center of mass [N m, world].
    pub(crate) torque: Vec3,
}

/// Motion counters that prove that two bodies are still apart without reading them. They count
/// whole [`Track::UNIT`]s, so sums wrap without loss over any lifetime of a world.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Track {
    /// Path length: no point of the body has moved farther than its increase. Wraps.
    pub(crate) path: u32,
    /// Speculative distance that this body contributes this step; 0 exactly for bodies that are
    /// static or have never moved.
    pub(crate) ahead: u32,
}

impl Track {
    /// Unit of length: a micrometer [m], times the world's length.
    const UNIT: f32 = 1.0 / 1_048_576.0;
    /// Maximum displacement at once and maximum gap: 256 m, times the world's length. The sum of
    /// two path lengths, the speculative distances and a margin stays below half of the range.
    const MAX: u32 = 1 << 28;

    /// True for a static body, or one that has not yet moved.
    pub(crate) const fn is_static(self) -> bool {
        self.ahead == 0
    }

    /// A distance [m, by the world's length] in units, rounded up, for path lengths; NaN becomes
    /// the maximum.
    #[inline]
    pub(crate) fn at_least(distance: f32) -> u32 {
        let units = distance / Self::UNIT;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in range")]
        if units < 0.99 * Self::MAX as f32 { units.max(0.0) as u32 + 1 } else { Self::MAX }
    }

    /// A distance in units, rounded down, for gaps.
    #[inline]
    pub(crate) fn at_most(distance: f32) -> u32 {
        let units = (distance / Self::UNIT).clamp(0.0, 0.99 * Self::MAX as f32);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in range")]
        let units = units as u32;
        units
    }
}

/// All bodies.
#[derive(Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Bodies {
    pub(crate) rows: SlotMap<BodyId, Body>,
    /// Motion counters of each row.
    pub(crate) tracks: Vec<Track>,
    /// Stillness of each row.
    pub(crate) stillness: Vec<Stillness>,
    /// Rows of the active bodies.
    pub(crate) awake: Vec<u32>,
    /// Loads at the time of freezing, by row; as long as the highest row that ever froze requires.
    frozen_loads: Vec<Load>,
    /// Masses that were given in full, by row. Bodies that are not dynamic have no mass of their
    /// own meanwhile.
    pub(crate) given: BTreeMap<u32, MassProperties>,
    /// Pairs of rows, the lower first, that never collide.
    pub(crate) strangers: BTreeSet<(u32, u32)>,
}

impl Clone for Bodies {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Reuses the existing lists.
    fn clone_from(&mut self, from: &Self) {
        let Self { rows, tracks, stillness, awake, frozen_loads, given, strangers } = from;
        self.rows.clone_from(rows);
        self.tracks.clone_from(tracks);
        self.stillness.clone_from(stillness);
        self.awake.clone_from(awake);
        self.frozen_loads.clone_from(frozen_loads);
        copy::map(&mut self.given, given);
        copy::set(&mut self.strangers, strangers);
    }
}

impl Bodies {
    /// True if two bodies, given by their rows, never collide.
    #[inline]
    pub(crate) fn are_strangers(&self, a: u32, b: u32) -> bool {
        !self.strangers.is_empty() && self.strangers.contains(&(a.min(b), a.max(b)))
    }

    /// Adds a body.
    pub(crate) fn insert(&mut self, body: Body) -> BodyId {
        let id = self.rows.insert(body);
        if self.tracks.len() < self.rows.slot_count() {
            grow::resize(&mut self.tracks, self.rows.slot_count(), Track::default());
            grow::resize(&mut self.stillness, self.rows.slot_count(), Stillness::default());
        }
        self.tracks[id.index() as usize].ahead = 0;
        self.stillness[id.index() as usize] = Stillness::default();
        id
    }

    /// The body in a row that is known to be in use.
    #[inline]
    pub(crate) fn at(&self, row: u32) -> &Body {
        self.rows.at(row).expect("tables name living bodies only")
    }

    #[inline]
    pub(crate) fn at_mut(&mut self, row: u32) -> &mut Body {
        self.rows.at_mut(row).expect("tables name living bodies only")
    }

    /// Load of the contacts on a body when it froze.
    pub(crate) fn frozen_load(&self, row: u32) -> Load {
        self.frozen_loads.get(row as usize).copied().unwrap_or_default()
    }

    pub(crate) fn set_frozen_load(&mut self, row: u32, load: Load) {
        if self.frozen_loads.len() < self.rows.slot_count() {
            self.frozen_loads.resize(self.rows.slot_count(), Load::default());
        }
        self.frozen_loads[row as usize] = load;
    }

    pub(crate) fn id(&self, row: u32) -> BodyId {
        self.rows.id_of(row)
    }
}
