//! How fast the errors of constraints are closed: caps in speed, whatever the error and the length of a substep.
//!
//! A spring's bias is its rate times the error. Joints that cannot be met, or were made far from where they meet, would
//! throw their bodies: an error of 100 m was closed at 700 m/s.

use fearless_simd::Simd;

use crate::base::simd::wide::{Wide, max, min, splat};

/// Greatest speed at which what is open closes [m/s; rad/s]. An angle that jumps, where a swing passes through
/// 180 degrees, must not throw bodies; 0.75 rad/s left limbs of a heap of people beyond their limits, which a load
/// of 4,000 rad/s² then held there.
const PUSH: [f32; 2] = [3.0, 9.0];

/// A wide gap closes faster than others may: by half in a tenth of a second [1/s].
const FASTER: f32 = 7.0;

/// But no faster than by this [m/s; rad/s]. A body of half a meter then moves by a part of its size in a substep, so
/// that its rows still mean what they say.
const MOST: f32 = 10.0;

/// Greatest speed at which links and attachments of particles close [m/s], beside [`FASTER`]. Ropes that snap taut close
/// their links at 3 m/s.
const PARTICLES: f32 = 10.0;

/// See [`Caps::least`]; whitened, of a length of 1 m.
const LEAST: f32 = 1.0e-15;

/// Shortest substep that softness follows [s]. What is as stiff as a substep bears grows without a bound as steps get
/// short, and then turns errors of micrometers into velocities.
pub(crate) const SHORTEST: f32 = 5.0e-5;

/// The same of links and attachments of particles, which are never refined. At rest the errors of a rope are 1e-5 m; what
/// closes them is then no faster than what gravity gives in a step of 1/60 s.
pub(crate) const SHORTEST_OF_PARTICLES: f32 = 1.0e-4;

/// The caps by the lengths of a world: those of angles are the same in all.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Caps {
    push: [f32; 2],
    most: [f32; 2],
    particles: f32,
    /// Velocities below this never show: see the kernel of joints of six axes.
    pub(crate) least: f32,
}

impl Caps {
    /// `length` is that of a typical body [m].
    pub(crate) fn new(length: f32) -> Self {
        let [motion, turn] = PUSH;
        Self {
            push: [motion * length, turn],
            most: [MOST * length, MOST],
            particles: PARTICLES * length,
            least: LEAST * length,
        }
    }

    /// See [`PUSH`]; of an axis.
    #[inline(always)]
    pub(crate) const fn push(&self, axis: usize) -> f32 {
        self.push[axis / 3]
    }

    /// How fast what is open by this may close on an axis, beyond what any may.
    pub(crate) fn beyond(&self, size: f64, axis: usize) -> f64 {
        (f64::from(FASTER) * size).min(f64::from(self.most[axis / 3]))
    }

    /// How fast an error of this size may close, if any may at `any`.
    #[inline(always)]
    fn fastest<S: Simd>(&self, simd: S, size: Wide<S>, any: f32) -> Wide<S> {
        let size = max(size, -size);
        splat(simd, any) + min(size * splat(simd, FASTER), splat(simd, self.most[0]))
    }

    /// At what speed an axis that is open by `gap` closes: by `rate` [1/s], but no faster than at [`PUSH`] and what
    /// [`FASTER`] allows besides, each axis by itself. (A ball that a floor stopped while the one on its joint went on for
    /// 0.16 m was thrown up at 15 m/s: what closes a joint presses a body on what bears it, and that pushes both.)
    #[inline(always)]
    pub(crate) fn closing<S: Simd>(&self, simd: S, gap: Wide<S>, rate: Wide<S>) -> Wide<S> {
        let most = self.fastest(simd, gap, self.push[0]);
        min(max(gap * rate, -most), most)
    }

    /// The same of a link between particles that is too long by `error`, which would close at `speed`.
    #[inline(always)]
    pub(crate) fn closing_link<S: Simd>(&self, simd: S, speed: Wide<S>, error: Wide<S>) -> Wide<S> {
        let most = self.fastest_link(simd, error);
        min(max(speed, -most), most)
    }

    /// The greatest speed of that.
    #[inline(always)]
    pub(crate) fn fastest_link<S: Simd>(&self, simd: S, error: Wide<S>) -> Wide<S> {
        self.fastest(simd, error, self.particles)
    }

    /// The same of a row of a joint that would close at `speed`.
    pub(crate) fn closing_axis(&self, speed: f32, error: f32, axis: usize) -> f32 {
        let most = self.push[axis / 3] + (FASTER * error.abs()).min(self.most[axis / 3]);
        speed.clamp(-most, most)
    }

    /// The same of one row: of a coupling, a pulley, an attachment. `is_turn`: the error is an angle.
    pub(crate) fn closing_row(&self, speed: f32, error: f32, is_turn: bool) -> f32 {
        let most = self.fastest_row(error, is_turn);
        speed.clamp(-most, most)
    }

    /// The greatest speed of that.
    pub(crate) fn fastest_row(&self, error: f32, is_turn: bool) -> f32 {
        let (any, most) = if is_turn { (PARTICLES, MOST) } else { (self.particles, self.most[0]) };
        any + (FASTER * error.abs()).min(most)
    }
}
