//! Stiffness of a world's contacts as springs, and the longest step for which an explicit penalty
//! method stays stable (manual/methods.md).

use crate::base::collision::{mobility, push};
use crate::base::math::{Vec3, vec3};
use crate::base::sym3::Sym3;
use crate::state::bodies::body::Body;
use crate::state::tables::Tables;

/// The stability limit of explicit contact springs.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct PenaltyLimit {
    /// Frequency of the stiffest motion that the current contacts allow [Hz]; the frequency of a
    /// single contact if there are none.
    pub hertz: f32,
    /// Longest substep for which the method stays stable [s].
    pub longest_substep: f32,
}

/// Iterations for the highest frequency. The estimate converges from below, and is off by some
/// percent at most.
const ITERATIONS: u32 = 200;

/// Computes the limit for the springs of the configuration.
pub(crate) fn penalty_limit(tables: &Tables) -> PenaltyLimit {
    let p = tables.config.penalty;
    let omega = 2.0 * core::f32::consts::PI * p.hertz;
    // Squares of frequencies, relative to the frequency of a single point.
    let highest = stiffest(tables).max(1.0).sqrt();
    // Damping grows with the stiffness: k times the frequency means k times the damping ratio.
    let zeta = p.damping_ratio * highest;
    let reach = 2.0 / ((1.0 + zeta * zeta).sqrt() + zeta);
    PenaltyLimit { hertz: p.hertz * highest, longest_substep: reach / (omega * highest) }
}

struct Spring {
    a: u32,
    b: u32,
    r_a: Vec3,
    r_b: Vec3,
    n: Vec3,
    /// Square root of the stiffness for a frequency of 1 rad/s.
    root: f32,
}

/// Largest eigenvalue of √k J M⁻¹ Jᵀ √k with k = 1/K of each point, by power iteration.
fn stiffest(tables: &Tables) -> f32 {
    let body = |row: u32| tables.bodies.at(row);
    let mut springs = Vec::new();
    for (_, c) in tables.contacts.iter().filter(|(_, c)| !c.sensor) {
        let (a, b) = (inverse(body(c.body_a)), inverse(body(c.body_b)));
        for p in c.points() {
            let (n, r_a, r_b) = (c.normal, p.r_a, c.r_b(p));
            let k = mobility(a.0, &a.1, r_a).plus(mobility(b.0, &b.1, r_b));
            let response = n.dot(k.mul(n));
            if response > 0.0 {
                let root = (1.0 / response).sqrt();
                springs.push(Spring { a: c.body_a, b: c.body_b, r_a, r_b, n, root });
            }
        }
    }
    let mut motion = vec![(Vec3::ZERO, Vec3::ZERO); tables.bodies.rows.slot_count()];
    // Any start vector with a component of the highest motion works: irregular signs.
    let mut seed = 1_u32;
    let mut z: Vec<f32> = springs
        .iter()
        .map(|_| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            if seed >> 31 == 0 { 1.0 } else { -0.9 }
        })
        .collect();
    let mut value = 0.0;
    for _ in 0..ITERATIONS {
        let size = z.iter().map(|x| x * x).sum::<f32>().sqrt();
        if !(size > 0.0 && size.is_finite()) {
            return value;
        }
        motion.fill((Vec3::ZERO, Vec3::ZERO));
        for (s, x) in springs.iter().zip(&mut z) {
            *x /= size;
            let j = s.n * (s.root * *x);
            for (row, r, sign) in [(s.a, s.r_a, -1.0), (s.b, s.r_b, 1.0)] {
                let (inv_mass, inv_inertia) = inverse(body(row));
                let (v, w) = &mut motion[row as usize];
                *v += push(inv_mass, j) * sign;
                *w += inv_inertia.mul(r.cross(j)) * sign;
            }
        }
        value = 0.0;
        for (s, x) in springs.iter().zip(&mut z) {
            let at = |row: u32, r: Vec3| motion[row as usize].0 + motion[row as usize].1.cross(r);
            *x = s.root * s.n.dot(at(s.b, s.r_b) - at(s.a, s.r_a));
            value += *x * *x;
        }
        value = value.sqrt();
    }
    value
}

/// Inverse mass and inertia [world], locked axes ignored.
fn inverse(body: &Body) -> (Vec3, Sym3) {
    if !body.is_dynamic() {
        return (Vec3::ZERO, Sym3::ZERO);
    }
    let each = |i: f32| if i > 0.0 { 1.0 / i } else { 0.0 };
    let m = body.inertia.moments;
    let moments = vec3(each(m.x), each(m.y), each(m.z));
    (
        Vec3::splat(1.0 / body.inertia.mass),
        Sym3::rotated_diagonal(body.rotation * body.inertia.principal, moments),
    )
}
