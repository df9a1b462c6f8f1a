//! Contacts as damped springs, whose forces follow from the state at the substep's start.
//!
//! A point of effective mass m has the stiffness k = m ω² and the damping c = 2 m ζ ω. Symplectic
//! Euler keeps one such point stable while h ω < 2 (√(1 + ζ²) - ζ). Several points on a body, and
//! bodies on top of each other, are stiffer together (manual/methods.md).

use super::rows::{Mover, Pair};
use super::sequence::Sequence;
use crate::base::collision::push;
use crate::base::math::Vec3;

/// The springs of all contacts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Springs {
    pub(crate) h: f32,
    /// Angular frequency [rad/s].
    pub(crate) omega: f32,
    pub(crate) damping_ratio: f32,
}

/// Adds the forces of a substep. All forces are computed before any of them acts, so their order
/// does not matter.
pub(crate) fn push_apart(
    springs: &Springs,
    sequence: &Sequence,
    movers: &mut [Mover],
    pairs: &mut [Pair],
    change: &mut Vec<(Vec3, Vec3)>,
) {
    change.clear();
    change.resize(movers.len(), (Vec3::ZERO, Vec3::ZERO));
    let Springs { h, omega, damping_ratio } = *springs;
    for row in &sequence.pairs {
        let pair = &mut pairs[*row as usize];
        for i in 0..pair.points().len() {
            let p = pair.points[i];
            let n = pair.normal;
            let s = pair.separation(&p, movers);
            let k = pair.matrix(&p, movers);
            let response = n.dot(k.mul(n));
            (pair.points[i].press, pair.points[i].rub) = (0.0, Vec3::ZERO);
            if !(s < 0.0 && response > 0.0) {
                continue;
            }
            let u = pair.slip(&p, movers);
            let force = -(omega * omega * s + 2.0 * damping_ratio * omega * u.dot(n)) / response;
            let press = (h * force).max(0.0);
            let slide = u - n * u.dot(n);
            let mut rub = Vec3::ZERO;
            if let Some(along) = slide.try_normalize() {
                // All points of the pair act at the same time, so each gets a share of the impulse
                // that would stop it alone.
                let share = 0.5 / f32::from(pair.count.max(1));
                let needed = share * slide.length() / along.dot(k.mul(along));
                rub = along * -needed.min(pair.friction[1] * press);
            }
            (pair.points[i].press, pair.points[i].rub) = (press, rub);
            pair.pressed |= press > 0.0;
            let j = n * press + rub;
            for (body, r, sign) in [(pair.a, p.r_a, -1.0), (pair.b, p.r_b, 1.0)] {
                let mover = &movers[body as usize];
                let (v, w) = &mut change[body as usize];
                *v += push(mover.inv_mass, j) * sign;
                *w += mover.inv_inertia.mul(r.cross(j)) * sign;
            }
        }
        let total = pair.points().iter().map(|p| p.press).sum();
        pair.resist_rolling(total, movers);
    }
    for (mover, (v, w)) in movers.iter_mut().zip(change) {
        mover.v += *v;
        mover.w += *w;
        mover.pushed |= *v != Vec3::ZERO || *w != Vec3::ZERO;
    }
}
