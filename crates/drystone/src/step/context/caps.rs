//! Maximum speeds at which constraint errors close, whatever the error and the length of a substep.
//!
//! A spring's bias is its rate times the error. Joints that cannot be met, or were made far from
//! where they meet, would throw their bodies: an error of 100 m was closed at 700 m/s.

use fearless_simd::Simd;

use crate::base::simd::wide::{Wide, max, min, splat};

/// Maximum speed at which a gap closes [m/s; rad/s]. An angle that jumps, where a swing passes
/// through 180 degrees, must not throw bodies. With 0.75 rad/s, limbs in a heap of people stayed
/// beyond their limits, and a load of 4,000 rad/s² then held them there.
const PUSH: [f32; 2] = [3.0, 9.0];

/// Additional closing speed of a wide gap: half of it in a tenth of a second [1/s].
const FASTER: f32 = 7.0;

/// Maximum of that additional speed [m/s; rad/s]. A body of half a meter then moves by a part of
/// its size in a substep, so its rows remain valid.
const MAX: f32 = 10.0;

/// Maximum speed at which links and attachments of particles close [m/s], beside [`FASTER`]. Ropes
/// that snap taut close their links at 3 m/s.
const PARTICLES: f32 = 10.0;

/// See [`Caps::minimum`]; whitened, for a length of 1 m.
const MIN: f32 = 1.0e-15;

/// Shortest substep that softness follows [s]. The maximum stable stiffness grows without bound as
/// steps get short, and then turns errors of micrometers into velocities.
pub(crate) const SHORTEST: f32 = 5.0e-5;

/// Shortest substep that links and attachments of particles follow [s]; they are never refined. The
/// errors of a rope at rest are 1e-5 m; at this length they close no faster than the speed that
/// gravity gives in a step of 1/60 s.
pub(crate) const SHORTEST_OF_PARTICLES: f32 = 1.0e-4;

/// The caps, scaled by a world's length. Caps on angular speeds are the same in all worlds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Caps {
    push: [f32; 2],
    maximum: [f32; 2],
    particles: f32,
    /// Velocities below this have no visible effect: see the kernel of six-axis joints.
    pub(crate) minimum: f32,
}

impl Caps {
    /// `length`: that of a typical body [m].
    pub(crate) fn new(length: f32) -> Self {
        let [motion, turn] = PUSH;
        Self {
            push: [motion * length, turn],
            maximum: [MAX * length, MAX],
            particles: PARTICLES * length,
            minimum: MIN * length,
        }
    }

    /// See [`PUSH`]; for axis 0 to 5.
    #[inline(always)]
    pub(crate) const fn push(&self, axis: usize) -> f32 {
        self.push[axis / 3]
    }

    /// Additional closing speed of a gap of this size on an axis, see [`FASTER`].
    pub(crate) fn beyond(&self, size: f64, axis: usize) -> f64 {
        (f64::from(FASTER) * size).min(f64::from(self.maximum[axis / 3]))
    }

    /// Maximum closing speed of an error of this size, where `any` is the maximum for small errors.
    #[inline(always)]
    fn fastest<S: Simd>(&self, simd: S, size: Wide<S>, any: f32) -> Wide<S> {
        let size = max(size, -size);
        splat(simd, any) + min(size * splat(simd, FASTER), splat(simd, self.maximum[0]))
    }

    /// Closing speed of an axis with this `gap`: by `rate` [1/s], clamped to [`PUSH`] plus the part
    /// of [`FASTER`], for each axis by itself. (A floor stopped a ball while the ball on its joint
    /// continued for 0.16 m; the first was thrown up at 15 m/s. Closing a joint presses a body on
    /// its support, and that pushes both.)
    #[inline(always)]
    pub(crate) fn closing<S: Simd>(&self, simd: S, gap: Wide<S>, rate: Wide<S>) -> Wide<S> {
        let maximum = self.fastest(simd, gap, self.push[0]);
        min(max(gap * rate, -maximum), maximum)
    }

    /// Closing speed of a link between particles that is too long by `error`, and whose spring
    /// would close it at `speed`.
    #[inline(always)]
    pub(crate) fn closing_link<S: Simd>(&self, simd: S, speed: Wide<S>, error: Wide<S>) -> Wide<S> {
        let maximum = self.fastest_link(simd, error);
        min(max(speed, -maximum), maximum)
    }

    /// Maximum closing speed of a link.
    #[inline(always)]
    pub(crate) fn fastest_link<S: Simd>(&self, simd: S, error: Wide<S>) -> Wide<S> {
        self.fastest(simd, error, self.particles)
    }

    /// Closing speed of a joint's row whose spring would close it at `speed`.
    pub(crate) fn closing_axis(&self, speed: f32, error: f32, axis: usize) -> f32 {
        let maximum = self.push[axis / 3] + (FASTER * error.abs()).min(self.maximum[axis / 3]);
        speed.clamp(-maximum, maximum)
    }

    /// Closing speed of a single row: a coupling, a pulley, an attachment. `is_turn`: the error is
    /// an angle.
    pub(crate) fn closing_row(&self, speed: f32, error: f32, is_turn: bool) -> f32 {
        let maximum = self.fastest_row(error, is_turn);
        speed.clamp(-maximum, maximum)
    }

    /// Maximum closing speed of a single row.
    pub(crate) fn fastest_row(&self, error: f32, is_turn: bool) -> f32 {
        let (any, maximum) =
            if is_turn { (PARTICLES, MAX) } else { (self.particles, self.maximum[0]) };
        any + (FASTER * error.abs()).min(maximum)
    }
}
