//! Springs and dampers along or about an axis of a joint, in lanes.

use fearless_simd::Simd;

use crate::base::simd::wide::{Lanes, Wide, above, load, max, min, select, splat};
use crate::state::six_dof::STIFF;

/// Damping above this makes a damper a motor, which holds its speed under any load [N s/m; N m
/// s/rad].
const MOTOR: f32 = 0.5 * STIFF;

/// Spring and damper of an axis.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C)]
pub(crate) struct Push {
    pub(crate) stiffness: Lanes,
    pub(crate) damping: Lanes,
    /// 1 where both count per effective mass.
    pub(crate) per_mass: Lanes,
    pub(crate) place: Lanes,
    pub(crate) speed: Lanes,
}

/// The impulse of a spring in a substep: λ' = gain λ - (rate · error + gain v + bias) / K.
pub(crate) struct Law<S: Simd> {
    pub(crate) gain: Wide<S>,
    pub(crate) rate: Wide<S>,
    pub(crate) bias: Wide<S>,
}

impl Push {
    /// Coefficients of the spring on the inverse mass `k`; `gained` is the speed that all other
    /// forces add in the substep.
    ///
    /// A spring slower than a substep swings as the exact one does: v' = (1 - B) v - A x has the
    /// eigenvalues exp(z h), approximated as (12 + 6 z + z²)/(12 - 6 z + z²). It comes to rest
    /// where the exact one does. A faster spring, or a motor, is evaluated at the end of the
    /// substep, which damps it. One stiffer than `hardest`, or of more than one radian per substep,
    /// is limited to that, with stiffness and damping in their proportion. See
    /// docs/derivations/joints.md.
    #[inline(always)]
    pub(crate) fn law<S: Simd>(
        &self,
        simd: S,
        k: Wide<S>,
        gained: Wide<S>,
        [inv_h, hardest]: [Wide<S>; 2],
    ) -> Law<S> {
        let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
        let (n6, n12, n72, n144) =
            (splat(simd, 6.0), splat(simd, 12.0), splat(simd, 72.0), splat(simd, 144.0));
        let h = one / inv_h;
        let per_mass = load(simd, &self.per_mass);
        let m = select(above(per_mass, zero), one, k) * h;
        let damping = load(simd, &self.damping);
        let c = damping * m;
        let p = load(simd, &self.stiffness) * m * h;
        let part = min(one, min(hardest / max(c + p, one), one / max(p, one)));
        let part = select(above(splat(simd, MOTOR), damping), part, one);
        let (c, p) = (c * part, p * part);
        let w = one / (one + c + p);
        let fast = Law {
            gain: (c + p) * w,
            rate: p * w * inv_h,
            bias: -(c * w * load(simd, &self.speed)),
        };
        let is_fast = above(max(c, p), one);
        // The squared damping of a motor has a subnormal reciprocal, which takes processors a
        // hundred times as long.
        let (c, p) = (min(c, one), min(p, one));
        let q = one / (n144 + n72 * c + n12 * (c * c + p) + n6 * p * c + p * p);
        let slow = Law {
            gain: n12 * c * (n12 + p) * q,
            rate: n144 * p * q * inv_h,
            bias: (n12 * p + p * p + n12 * c * c - n72 * c - n6 * p * c) * q * gained
                - n144 * c * q * load(simd, &self.speed),
        };
        Law {
            gain: select(is_fast, fast.gain, slow.gain),
            rate: select(is_fast, fast.rate, slow.rate),
            bias: select(is_fast, fast.bias, slow.bias),
        }
    }
}

impl<S: Simd> Law<S> {
    #[inline(always)]
    pub(crate) fn impulse(
        &self,
        inverse: Wide<S>,
        v: Wide<S>,
        error: Wide<S>,
        old: Wide<S>,
    ) -> Wide<S> {
        self.gain * old - (self.rate * error + self.gain * v + self.bias) * inverse
    }
}
