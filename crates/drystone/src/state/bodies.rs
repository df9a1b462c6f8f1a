//! The table of bodies, one row each. Only the stage `finalize`, later stages and the world write
//! velocities and poses.

use core::mem::take;
use std::collections::{BTreeMap, BTreeSet};

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};
use smallvec::SmallVec;

use super::def::{AxisLocks, BodyKind, MassDef};
use super::stillness::Stillness;
use crate::base::copy;
use crate::base::grow;
use crate::base::id::BodyId;
use crate::base::math::{Vec3, vec3};
use crate::base::pose::Pose;
use crate::base::quat::Quat;
use crate::base::slot_map::SlotMap;
use crate::base::sym3::Sym3;
use crate::geometry::mass::MassProperties;

/// Marks the absence of a row.
pub(crate) const NONE: u32 = u32::MAX;

/// How finely an island subdivides the world's substeps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) enum Fineness {
    /// No subdivision.
    #[default]
    Whole,
    /// Subdivided by [`crate::config::InertiaConfig::refine`]: the load on some body is near the
    /// maximum that can be carried.
    Loaded,
    /// Subdivided by [`crate::config::JointConfig::refine`]: it has joints, and they turn fast.
    Jointed,
    /// Refined like `Jointed`: it has joints, and a body was hit. Impact impulses must not
    /// warm-start the next step, so they are rescaled then.
    Struck,
    /// Fast-turning joints without contacts: subdivided, and each of the world's substeps is a
    /// round of its own.
    Tumbling,
}

impl Fineness {
    /// All values.
    pub(crate) const ALL: [Self; 5] =
        [Self::Whole, Self::Loaded, Self::Jointed, Self::Struck, Self::Tumbling];
}

/// Source of a body's mass: as in [`MassDef`], without values that the body stores itself.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[repr(u8)]
pub(crate) enum MassSource {
    Shapes,
    /// The mass [kg] was given.
    Mass(f32),
    /// Mass, center and inertia were given.
    Exact,
}

impl From<MassDef> for MassSource {
    fn from(def: MassDef) -> Self {
        match def {
            MassDef::FromShapes => Self::Shapes,
            MassDef::Mass(mass) => Self::Mass(mass),
            MassDef::Exact { .. } => Self::Exact,
        }
    }
}

/// Rows of a body's shapes or joints. Most bodies have few, which need no memory of their own.
pub(crate) type Few = SmallVec<[u32; 4]>;

/// A body. The first cache line has the fields that every stage reads, and the niche that
/// `Option<Body>` uses for `None`. The compiler takes the first field with the most invalid bit
/// patterns. That is [`Self::can_sleep`] as long as no field has more than a `bool`: no `Vec`, no
/// enum larger than a byte.
#[derive(Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[repr(C, align(64))]
pub(crate) struct Body {
    pub(crate) kind: BodyKind,
    pub(crate) can_sleep: bool,
    /// The body takes no part in steps, and is in no tree: it is faulted, disabled or both.
    pub(crate) out: bool,
    /// The body is so fast that its boxes serve for one step only. Finalize makes them anew, so the
    /// body searches for pairs in every step.
    pub(crate) flies: bool,
    /// Index in [`Bodies::awake`], or [`NONE`].
    pub(crate) awake_row: u32,
    /// Center of mass [m, world].
    pub(crate) center: Vec3,
    pub(crate) rotation: Quat,
    /// Velocity of the center of mass [m/s, world].
    pub(crate) v: Vec3,
    /// Angular velocity [rad/s, world].
    pub(crate) w: Vec3,
    /// Maximum distance of its points from the center of mass [m].
    pub(crate) extent: f32,

    /// Particles hold it or touch it in this step, so it has a solver body.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) dragged: bool,
    /// Center of mass [m, frame of the origin].
    pub(crate) local_center: Vec3,
    /// Mass [kg]; 0 for static and kinematic bodies.
    pub(crate) mass: f32,
    pub(crate) mass_source: MassSource,
    /// Principal moments of inertia [kg m²]; 0 along an axis that cannot turn.
    pub(crate) moments: Vec3,
    /// Principal axes [body].
    pub(crate) principal: Quat,
    /// Rounding remainder of the angular velocity in free flight [rad/s, world]: below the last
    /// digits of `w`. It is 0 as soon as anything but free rotation acts.
    pub(crate) w_rest: Vec3,
    pub(crate) locks: AxisLocks,

    pub(crate) gravity_scale: f32,
    pub(crate) linear_damping: f32,
    pub(crate) angular_damping: f32,
    /// Force and torque of this step; cleared after it [N, N m, world].
    pub(crate) step_force: Vec3,
    pub(crate) step_torque: Vec3,
    /// Lasting force and torque, kept until changed [N, N m, world].
    pub(crate) force: Vec3,
    pub(crate) torque: Vec3,

    /// Rows of its shapes.
    pub(crate) shapes: Few,
    /// Rows of its joints.
    pub(crate) joints: Few,
    /// First entry in its list of contacts: contact row × 2 + side.
    pub(crate) contacts: u32,
    /// Number of constraints (contacts with points, joints) that act on it; 0 is free flight.
    pub(crate) constraints: u32,

    /// Its island, and its neighbors in the list of the island's bodies.
    pub(crate) island: u32,
    pub(crate) island_previous: u32,
    pub(crate) island_next: u32,
    /// Factor of its mass and inertia in the last step. It follows from `load`, the force that
    /// squeezes the body from both sides [N].
    pub(crate) inertia_factor: f32,
    /// Subdivision of its island in the last step.
    pub(crate) fineness: Fineness,
    pub(crate) load: f32,
    /// Length of the substeps of the last step in which it was awake [s]; 0 before the first. The
    /// compression of its contacts depends on it.
    pub(crate) last_h: f32,
    /// Time for which it has been still [s].
    pub(crate) still_time: f32,
    /// Speed below which it is still [m/s]; negative: the world's.
    pub(crate) sleep_speed: f32,
    /// Half the minimum thickness of its shapes [m]: it may move that far in a step without a
    /// sweep.
    pub(crate) inner: f32,
    /// Distance that any point may move before a shape may leave its box in the tree [m]; 0:
    /// unknown.
    pub(crate) room: f32,
    /// Level in the contact graph: minimum number of contacts between it and a body that cannot be
    /// pushed, which has level 0. An unsupported body has [`NONE`].
    pub(crate) level: u32,
    /// It is glued together or fractures, so its contacts sum up their impulses.
    pub(crate) breaks: bool,
    /// It came from a fracture.
    pub(crate) is_piece: bool,
    /// None of its shapes reaches around its center of mass.
    pub(crate) hollow: bool,
    /// Its state became non-finite, and the user has set no new one.
    pub(crate) faulted: bool,
    /// The user disabled it.
    pub(crate) disabled: bool,
    pub(crate) user_data: u64,
}

impl Clone for Body {
    fn clone(&self) -> Self {
        Self { shapes: self.shapes.clone(), joints: self.joints.clone(), ..*self }
    }

    /// Reuses the existing lists.
    fn clone_from(&mut self, from: &Self) {
        let (mut shapes, mut joints) = (take(&mut self.shapes), take(&mut self.joints));
        shapes.clone_from(&from.shapes);
        joints.clone_from(&from.joints);
        *self = Self { shapes, joints, ..*from };
    }
}

const _: () = assert!(core::mem::offset_of!(Body, extent) == 60);
const _: () = assert!(size_of::<Option<Body>>() == 320);

impl Body {
    /// Pose of the origin.
    pub(crate) fn pose(&self) -> Pose {
        Pose {
            position: self.center - self.rotation.rotate(self.local_center),
            rotation: self.rotation,
        }
    }

    /// Moves the origin to `pose`.
    pub(crate) fn set_pose(&mut self, pose: &Pose) {
        self.rotation = pose.rotation;
        self.center = pose.point(self.local_center);
    }

    /// True if it moves in this step: awake and dynamic, or kinematic with a velocity.
    #[inline]
    pub(crate) const fn active(&self) -> bool {
        self.awake_row != NONE
    }

    #[inline]
    pub(crate) fn is_dynamic(&self) -> bool {
        self.kind == BodyKind::Dynamic
    }

    /// True if it is dynamic and not active: it sleeps, or was set aside.
    #[inline]
    pub(crate) fn sleeps(&self) -> bool {
        self.is_dynamic() && !self.active()
    }

    /// Upper bound on the speed of its points [m/s]; `length` is that of a typical body [m].
    #[inline]
    pub(crate) fn greatest_speed(&self, length: f32) -> f32 {
        // A body without shapes has no extent, but may spin.
        let reach = if self.extent > 0.0 { self.extent } else { length };
        self.v.length() + self.w.length() * reach
    }

    /// Speed below which it is still [m/s]; `speed` is the world's.
    #[inline]
    pub(crate) const fn still_speed(&self, speed: f32) -> f32 {
        if self.sleep_speed >= 0.0 { self.sleep_speed } else { speed }
    }

    /// Change of its angular velocity [rad/s, world] by an angular impulse [N m s, world], subject
    /// to its locks.
    pub(crate) fn turn_by(&self, impulse: Vec3) -> Vec3 {
        let m = self.moments;
        let inverse = |i: f32| if i > 0.0 { 1.0 / i } else { 0.0 };
        let d = vec3(inverse(m.x), inverse(m.y), inverse(m.z));
        let mut dw = Sym3::rotated_diagonal(self.rotation * self.principal, d).mul(impulse);
        for i in 0..3 {
            if self.locks.angular[i] {
                dw[i] = 0.0;
            }
        }
        dw
    }

    /// Velocity of the point at `r` from the center of mass [m/s, world].
    #[inline]
    pub(crate) fn velocity_at(&self, r: Vec3) -> Vec3 {
        self.v + self.w.cross(r)
    }
}

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
    pub(crate) way: u32,
    /// Speculative distance that this body contributes this step; 0 exactly for bodies that are
    /// static or have never moved.
    pub(crate) ahead: u32,
}

impl Track {
    /// Unit of length: a micrometer [m], times the world's length.
    const UNIT: f32 = 1.0 / 1_048_576.0;
    /// Maximum displacement at once and maximum gap: 256 m, times the world's length. The sum of
    /// two path lengths, the speculative distances and a margin stays below half of the range.
    const MOST: u32 = 1 << 28;

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
        if units < 0.99 * Self::MOST as f32 { units.max(0.0) as u32 + 1 } else { Self::MOST }
    }

    /// A distance in units, rounded down, for gaps.
    #[inline]
    pub(crate) fn at_most(distance: f32) -> u32 {
        let units = (distance / Self::UNIT).clamp(0.0, 0.99 * Self::MOST as f32);
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
