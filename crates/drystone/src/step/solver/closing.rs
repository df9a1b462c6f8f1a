//! How fast the errors of constraints are closed: caps in speed, whatever the error and the length of a substep.
//!
//! A spring's bias is its rate times the error. Joints that cannot be met, or were made far from where they meet, would
//! throw their bodies: an error of 100 m was closed at 700 m/s.

use fearless_simd::Simd;

use crate::base::wide::{Wide, max, min, splat};

/// Greatest speed at which what is open closes [m/s; rad/s]. An angle that jumps, where a swing passes through
/// 180 degrees, must not throw bodies; 0.75 rad/s left limbs of a heap of people beyond their limits, which a load
/// of 4,000 rad/s² then held there.
const PUSH: [f32; 2] = [3.0, 9.0];

/// See [`PUSH`]; of an axis.
pub(crate) const fn push(axis: usize) -> f32 {
    PUSH[axis / 3]
}

/// A wide gap closes faster than others may: by half in a tenth of a second [1/s].
const FASTER: f32 = 7.0;

/// But no faster than by this [m/s; rad/s]. A body of half a meter then moves by a part of its size in a substep, so
/// that its rows still mean what they say.
const MOST: f32 = 10.0;

/// Greatest speed at which links and attachments of particles close [m/s], beside [`FASTER`]. Ropes that snap taut close
/// their links at 3 m/s.
const PARTICLES: f32 = 10.0;

/// Shortest substep that softness follows [s]. What is as stiff as a substep bears grows without a bound as steps get
/// short, and then turns errors of micrometers into velocities.
pub(crate) const SHORTEST: f32 = 5.0e-5;

/// The same of links and attachments of particles, which are never refined. At rest the errors of a rope are 1e-5 m; what
/// closes them is then no faster than what gravity gives in a step of 1/60 s.
pub(crate) const SHORTEST_OF_PARTICLES: f32 = 1.0e-4;

/// How fast a gap of this size may close, beyond what any may.
pub(crate) fn beyond(size: f64) -> f64 {
    (f64::from(FASTER) * size).min(f64::from(MOST))
}

/// How fast an error of this size may close, if any may at `any`.
#[inline(always)]
fn fastest<S: Simd>(simd: S, size: Wide<S>, any: f32) -> Wide<S> {
    let size = max(size, -size);
    splat(simd, any) + min(size * splat(simd, FASTER), splat(simd, MOST))
}

/// At what speed an axis that is open by `gap` closes: by `rate` [1/s], but no faster than at [`push`] and what
/// [`FASTER`] allows besides, each axis by itself. (A ball that a floor stopped while the one on its joint went on for
/// 0.16 m was thrown up at 15 m/s: what closes a joint presses a body on what bears it, and that pushes both.)
#[inline(always)]
pub(super) fn closing<S: Simd>(simd: S, gap: Wide<S>, rate: Wide<S>) -> Wide<S> {
    let most = fastest(simd, gap, push(0));
    min(max(gap * rate, -most), most)
}

/// The same of a link between particles that is too long by `error`, which would close at `speed`.
#[inline(always)]
pub(crate) fn closing_link<S: Simd>(simd: S, speed: Wide<S>, error: Wide<S>) -> Wide<S> {
    let most = fastest_link(simd, error);
    min(max(speed, -most), most)
}

/// The greatest speed of that.
#[inline(always)]
pub(crate) fn fastest_link<S: Simd>(simd: S, error: Wide<S>) -> Wide<S> {
    fastest(simd, error, PARTICLES)
}

/// The same of one row: of a coupling, a pulley, an attachment.
pub(crate) fn closing_row(speed: f32, error: f32) -> f32 {
    let most = PARTICLES + (FASTER * error.abs()).min(MOST);
    speed.clamp(-most, most)
}
