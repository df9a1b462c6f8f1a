//! Bodies: one row each. Velocity and pose are written by the solver's finish and by the world only.

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

/// No row.
pub(crate) const NONE: u32 = u32::MAX;

/// In what parts an island takes the world's substeps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) enum Fineness {
    /// Whole.
    #[default]
    Whole,
    /// In those of [`crate::config::InertiaConfig::refine`]: what it carries squeezes it as far as can be carried.
    Loaded,
    /// In those of [`crate::config::JointConfig::refine`]: it has joints, and they go round fast.
    Jointed,
    /// In the same: it has joints, and is hit. The impulses that it keeps are taken back in the next step, those of a blow.
    Struck,
    /// Of those that go round fast, what touches nothing: in parts, and each of the world's substeps is a round of its own.
    Tumbling,
}

impl Fineness {
    /// All there are.
    pub(crate) const ALL: [Self; 5] =
        [Self::Whole, Self::Loaded, Self::Jointed, Self::Struck, Self::Tumbling];
}

/// Where a body's mass came from: as [`MassDef`] says, but for what the body itself knows.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[repr(u8)]
pub(crate) enum MassSource {
    Shapes,
    /// Its mass [kg] was given.
    Mass(f32),
    /// All was given.
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

/// Rows of a body's shapes or joints. Most bodies have a few, which need no memory of their own.
pub(crate) type Few = SmallVec<[u32; 4]>;

/// A body. What every stage reads stands in the first cache line, and what tells an empty slot of the table: the
/// compiler takes the values that one of its fields cannot have for that, of the first field with the most of them.
/// That is [`Self::can_sleep`] as long as none has more than a `bool`: no `Vec`, no enum larger than a byte.
#[derive(Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[repr(C, align(64))]
pub(crate) struct Body {
    pub(crate) kind: BodyKind,
    pub(crate) can_sleep: bool,
    /// It takes no part in steps, and is in no tree: it is faulted, disabled or both.
    pub(crate) out: bool,
    /// So fast that its boxes serve for one step: finalize makes them anew, so it looks for pairs in every
    /// step.
    pub(crate) flies: bool,
    /// Place in [`Bodies::awake`], or [`NONE`].
    pub(crate) awake_row: u32,
    /// Center of mass [m, world].
    pub(crate) center: Vec3,
    pub(crate) rotation: Quat,
    /// Velocity of the center of mass [m/s, world].
    pub(crate) v: Vec3,
    /// Angular velocity [rad/s, world].
    pub(crate) w: Vec3,
    /// Greatest distance of a point of it from the center of mass [m].
    pub(crate) extent: f32,

    /// Particles hold it or touch it in this step: it has a line in the solver.
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
    /// What rounding in free flight took from the angular velocity [rad/s, world]: below the last digits of
    /// `w`, and 0 as soon as anything but free rotation has a part in it.
    pub(crate) w_rest: Vec3,
    pub(crate) locks: AxisLocks,

    pub(crate) gravity_scale: f32,
    pub(crate) linear_damping: f32,
    pub(crate) angular_damping: f32,
    /// Cleared after each step [N, N m, world].
    pub(crate) step_force: Vec3,
    pub(crate) step_torque: Vec3,
    /// Kept until changed [N, N m, world].
    pub(crate) force: Vec3,
    pub(crate) torque: Vec3,

    /// Rows of its shapes.
    pub(crate) shapes: Few,
    /// Rows of its joints.
    pub(crate) joints: Few,
    /// First of its contacts: contact row × 2 + side.
    pub(crate) contacts: u32,
    /// Constraints (contacts with points, joints) that act on it; 0 is free flight.
    pub(crate) constraints: u32,

    /// Its island, and its neighbors in the chain of the island's bodies.
    pub(crate) island: u32,
    pub(crate) island_previous: u32,
    pub(crate) island_next: u32,
    /// What the solver multiplied its mass and inertia by in the last step, and the load from which that
    /// follows: the force that squeezes it from both sides [N].
    pub(crate) inertia_factor: f32,
    /// In what parts its island took the last step's substeps.
    pub(crate) fineness: Fineness,
    pub(crate) load: f32,
    /// Length of the substeps of the last step that it was awake in [s]; 0 before the first: what its contacts give follows that.
    pub(crate) last_h: f32,
    /// How long it has been still [s].
    pub(crate) still_time: f32,
    /// Speed below which it is still [m/s]; negative: the world's.
    pub(crate) sleep_speed: f32,
    /// Half of the least thickness of its shapes [m]: what it may move in a step without a check.
    pub(crate) inner: f32,
    /// How far a point of it may yet move before a shape may leave its box in the tree [m]; 0: unknown.
    pub(crate) room: f32,
    /// Level in the contact graph: contacts between it and what cannot be pushed, at least. That is 0;
    /// a body that nothing holds has [`NONE`].
    pub(crate) level: u32,
    /// It is glued together or fractures: contacts sum up what they give it.
    pub(crate) breaks: bool,
    /// It came from a fracture.
    pub(crate) is_piece: bool,
    /// None of its shapes reaches around its center of mass.
    pub(crate) hollow: bool,
    /// Its state became non-finite, and it got no new one yet.
    pub(crate) faulted: bool,
    /// The user took it out of the world.
    pub(crate) disabled: bool,
    pub(crate) user_data: u64,
}

impl Clone for Body {
    fn clone(&self) -> Self {
        Self { shapes: self.shapes.clone(), joints: self.joints.clone(), ..*self }
    }

    /// Into the lists that are there.
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

    /// Puts the origin at `pose`.
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

    /// True if it is dynamic and not active: it sleeps, or was put aside.
    #[inline]
    pub(crate) fn sleeps(&self) -> bool {
        self.is_dynamic() && !self.active()
    }

    /// No point of it moves faster [m/s].
    #[inline]
    pub(crate) fn greatest_speed(&self) -> f32 {
        // A body without shapes has no extent, but may well spin.
        let reach = if self.extent > 0.0 { self.extent } else { 1.0 };
        self.v.length() + self.w.length() * reach
    }

    /// Below this speed it is still [m/s]; `speed` is the world's.
    #[inline]
    pub(crate) const fn still_speed(&self, speed: f32) -> f32 {
        if self.sleep_speed >= 0.0 { self.sleep_speed } else { speed }
    }

    /// How an angular impulse [N m s, world] changes its angular velocity [rad/s, world], as far as its locks allow.
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

/// What contacts do to a body.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Load {
    /// Sum of the forces [N, world], and of their sizes.
    pub(crate) force: Vec3,
    pub(crate) size: f32,
    /// About its center of mass [N m, world].
    pub(crate) torque: Vec3,
}

/// What tells that two bodies are still apart without a look at them: how far they have come and may come, in
/// whole [`Track::UNIT`]s, so that sums go round without a loss however long a world lives.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Track {
    /// No point of the body has come farther than what this grew by; goes round.
    pub(crate) way: u32,
    /// How far contacts are looked for in this step on its account; 0 of what is static, never of what is awake.
    pub(crate) ahead: u32,
}

impl Track {
    /// A micrometer [m].
    const UNIT: f32 = 1.0 / 1_048_576.0;
    /// Farther than this a body never comes at once, nor is a gap ever wider: 256 m. Sums of two ways, what lies ahead
    /// and a margin stay below half of all numbers.
    const MOST: u32 = 1 << 28;

    /// It is that of a static body, or of one that has not yet moved.
    pub(crate) const fn is_static(self) -> bool {
        self.ahead == 0
    }

    /// A distance [m] in units, no less than it is, for ways; what is no number is the greatest.
    #[inline]
    pub(crate) fn at_least(distance: f32) -> u32 {
        let units = distance / Self::UNIT;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in range")]
        if units < 0.99 * Self::MOST as f32 { units.max(0.0) as u32 + 1 } else { Self::MOST }
    }

    /// And no more than it is, for gaps.
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
    /// Of each row.
    pub(crate) tracks: Vec<Track>,
    /// Of each row.
    pub(crate) stillness: Vec<Stillness>,
    /// Rows of the active bodies.
    pub(crate) awake: Vec<u32>,
    /// Of each row when it froze; as far as bodies ever did.
    frozen_loads: Vec<Load>,
    /// By rows: masses that were given in full. Bodies that are not dynamic have none of their own meanwhile.
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

    /// Into the lists that are there.
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
    /// True of two bodies, by their rows, that never collide.
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

    /// What the contacts did to a body when it froze.
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
