//! Configuration of sleep.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

/// Conditions for sleep. An island of bodies connected by contacts or joints sleeps when every body
/// has been still for `time`, and no body is driven.
///
/// A body is still if it is slow, balanced and not creeping. It is balanced if its supports leave
/// at most a thousandth of the forces on it. It creeps if it moves by more than a tenth of its
/// extent within `time`. A body without contacts and joints is still only if no force acts on it
/// and it drifts by at most a hundredth of its extent in ten seconds. The extent is the distance of
/// the farthest point from the center of mass; for bodies without shapes it is 1 m.
///
/// A body is driven if it touches a moving kinematic body or a moving surface, or is joined to a
/// moving kinematic body. It is also driven if a drive or spring of a joint acts on it, unless that
/// has stalled or has reached its target. [`crate::World::why_awake`] reports the cause that keeps
/// a body awake. The manual: [sleep](crate::manual::sleep).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct SleepConfig {
    /// Whether islands may sleep; default true.
    pub enabled: bool,
    /// Speed below which a body is slow, for its fastest point [m/s], at least 0; default 0.05.
    /// Faster bodies never sleep. Slower bodies sleep if they are also still. With 0 nothing
    /// sleeps. It is multiplied by
    /// [`WorldConfig::length_scale`](crate::WorldConfig::length_scale); a body's own
    /// [`sleep_speed`](crate::BodyDef::sleep_speed) is not.
    pub speed: f32,
    /// Time for which all bodies of an island must be still [s], at least 0; default 0.5. The
    /// minimum in effect is two and a half steps, which are needed to measure an acceleration.
    pub time: f32,
}
