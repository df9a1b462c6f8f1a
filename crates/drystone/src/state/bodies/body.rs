//! A body, in parts that belong together.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};
use smallvec::SmallVec;

use super::NONE;
use crate::base::math::{Vec3, vec3};
use crate::base::pose::Pose;
use crate::base::quat::Quat;
use crate::base::sym3::Sym3;
use crate::state::def::{AxisLocks, BodyKind, MassDef};

/// How finely an island subdivides the world's substeps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) enum Subdivision {
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

impl Subdivision {
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

/// A body. The first cache line has its motion, which every stage reads, and the niche that
/// `Option<Body>` uses for `None`. The compiler takes the first field with the most invalid bit
/// patterns. That is [`Self::can_sleep`] as long as no field has more than a `bool`: no `Vec`, no
/// enum larger than a byte. The other parts follow in groups of a cache line, so that a stage loads
/// only the lines that it needs.
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
    /// Index in the list of active bodies, or [`NONE`].
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

    pub(crate) inertia: Inertia,
    /// Half the minimum thickness of its shapes [m]: it may move that far in a step without a
    /// sweep.
    pub(crate) inner: f32,

    pub(crate) forces: Forces,
    /// Distance that any point may move before a shape may leave its box in the tree [m]; 0:
    /// unknown.
    pub(crate) room: f32,

    pub(crate) ties: Ties,
    pub(crate) record: Record,
    pub(crate) sleep: Sleep,
    pub(crate) history: History,
}

/// Mass properties of a body, and the directions in which they count.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Inertia {
    /// Center of mass [m, frame of the origin].
    pub(crate) local_center: Vec3,
    /// Mass [kg]; 0 for static and kinematic bodies.
    pub(crate) mass: f32,
    /// Principal moments of inertia [kg m²]; 0 along an axis that cannot turn.
    pub(crate) moments: Vec3,
    /// Principal axes [body].
    pub(crate) principal: Quat,
    pub(crate) source: MassSource,
    pub(crate) locks: AxisLocks,
    /// None of the body's shapes reaches around its center of mass.
    pub(crate) hollow: bool,
}

/// Accelerations that act on a body besides contacts and joints.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Forces {
    pub(crate) gravity_scale: f32,
    /// Damping rates [1/s].
    pub(crate) linear_damping: f32,
    pub(crate) angular_damping: f32,
    /// Force and torque of this step; cleared after it [N, N m, world].
    pub(crate) step_force: Vec3,
    pub(crate) step_torque: Vec3,
    /// Lasting force and torque, kept until changed [N, N m, world].
    pub(crate) force: Vec3,
    pub(crate) torque: Vec3,
}

/// Rows of other tables that belong to a body.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Ties {
    pub(crate) shapes: Few,
    pub(crate) joints: Few,
    /// First entry in its list of contacts: contact row × 2 + side.
    pub(crate) contacts: u32,
    /// Number of constraints (contacts with points, joints) that act on it; 0 is free flight.
    pub(crate) constraints: u32,
}

/// Properties of a body that change rarely, and that few stages read.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[expect(clippy::struct_excessive_bools, reason = "independent properties")]
pub(crate) struct Record {
    pub(crate) user_data: u64,
    /// Particles hold it or touch it in this step, so it has a solver body.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) dragged: bool,
    /// It is glued together or fractures, so its contacts sum up their impulses.
    pub(crate) breaks: bool,
    /// It came from a fracture.
    pub(crate) is_piece: bool,
    /// It is a moving link of an articulation: its motion follows from coordinates.
    pub(crate) is_link: bool,
    /// Its state became non-finite, and the user has set no new one.
    pub(crate) faulted: bool,
    /// The user disabled it.
    pub(crate) disabled: bool,
}

/// State that decides when a body falls asleep.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Sleep {
    /// Its island, and its neighbors in the list of the island's bodies.
    pub(crate) island: u32,
    pub(crate) previous: u32,
    pub(crate) next: u32,
    /// Time for which it has been still [s].
    pub(crate) still_time: f32,
    /// Speed below which it is still [m/s]; negative: the world's.
    pub(crate) speed: f32,
}

/// State of the last step that the solver needs in the next.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct History {
    /// Rounding remainder of the angular velocity in free flight [rad/s, world]: below the last
    /// digits of `w`. It is 0 as soon as anything but free rotation acts.
    pub(crate) w_low: Vec3,
    /// Factor of its mass and inertia in the last step. It follows from `load`, the force that
    /// squeezes the body from both sides [N].
    pub(crate) inertia_factor: f32,
    pub(crate) load: f32,
    /// Length of the substeps of the last step in which it was awake [s]; 0 before the first. The
    /// compression of its contacts depends on it.
    pub(crate) last_h: f32,
    /// Level in the contact graph: minimum number of contacts between it and a body that cannot be
    /// pushed, which has level 0. An unsupported body has [`NONE`].
    pub(crate) level: u32,
    /// Subdivision of its island in the last step.
    pub(crate) subdivision: Subdivision,
}

impl Ties {
    /// No rows.
    pub(crate) fn none() -> Self {
        Self { shapes: Few::new(), joints: Few::new(), contacts: NONE, constraints: 0 }
    }
}

impl Forces {
    /// Without forces, at the same rates and scale.
    pub(crate) const fn without_forces(self) -> Self {
        let none = Vec3::ZERO;
        Self { step_force: none, step_torque: none, force: none, torque: none, ..self }
    }
}

impl Sleep {
    /// In no island, and not yet still.
    pub(crate) const fn begin(speed: f32) -> Self {
        Self { island: NONE, previous: NONE, next: NONE, still_time: 0.0, speed }
    }
}

impl History {
    /// State of a body that has not been solved yet.
    pub(crate) const fn begin(level: u32) -> Self {
        Self {
            w_low: Vec3::ZERO,
            inertia_factor: 1.0,
            load: 0.0,
            last_h: 0.0,
            level,
            subdivision: Subdivision::Whole,
        }
    }
}

impl Clone for Body {
    fn clone(&self) -> Self {
        Self { ties: self.ties.clone(), ..*self }
    }

    /// Reuses the existing lists.
    fn clone_from(&mut self, from: &Self) {
        let mut ties = core::mem::replace(&mut self.ties, Ties::none());
        ties.shapes.clone_from(&from.ties.shapes);
        ties.joints.clone_from(&from.ties.joints);
        (ties.contacts, ties.constraints) = (from.ties.contacts, from.ties.constraints);
        *self = Self { ties, ..*from };
    }
}

const _: () = assert!(core::mem::offset_of!(Body, extent) == 60);
const _: () = assert!(core::mem::offset_of!(Body, forces) == 128);
const _: () = assert!(core::mem::offset_of!(Body, ties) == 192);
const _: () = assert!(size_of::<Option<Body>>() == 320);

impl Body {
    /// Pose of the origin.
    pub(crate) fn pose(&self) -> Pose {
        Pose {
            position: self.center - self.rotation.rotate(self.inertia.local_center),
            rotation: self.rotation,
        }
    }

    /// Moves the origin to `pose`.
    pub(crate) fn set_pose(&mut self, pose: &Pose) {
        self.rotation = pose.rotation;
        self.center = pose.point(self.inertia.local_center);
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
        if self.sleep.speed >= 0.0 { self.sleep.speed } else { speed }
    }

    /// Change of its angular velocity [rad/s, world] by an angular impulse [N m s, world], subject
    /// to its locks.
    pub(crate) fn turn_by(&self, impulse: Vec3) -> Vec3 {
        let m = self.inertia.moments;
        let inverse = |i: f32| if i > 0.0 { 1.0 / i } else { 0.0 };
        let d = vec3(inverse(m.x), inverse(m.y), inverse(m.z));
        let mut dw = Sym3::rotated_diagonal(self.rotation * self.inertia.principal, d).mul(impulse);
        for i in 0..3 {
            if self.inertia.locks.angular[i] {
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
