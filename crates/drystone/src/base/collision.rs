//! Impulse of one collision of two rigid bodies at one point: exact sticking, sliding with
//! Coulomb's friction, and a guard on energy.
//!
//! n: normal, from A to B; u: velocity of B's point minus that of A's; r: lever arm from a center
//! of mass to the point; K: collision matrix. An impulse j on B (-j on A) changes u to
//! `u' = u + K j`. An approach has `u · n < 0`.
//! References: [Mirtich96], [Guendelman03].

use super::math::{Vec3, vec3};
use super::sym3::Sym3;

/// Motion of the contact point during the collision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImpactKind {
    /// The bodies were not approaching: no impulse.
    Separating,
    /// No sliding is left: the impulse is inside the friction cone.
    Stick,
    /// The surfaces slide on each other: the impulse is on the friction cone, or friction has just
    /// stopped the sliding.
    Slide,
}

/// One body's part of the collision matrix: `1/m - [r]× I⁻¹ [r]×`. The inverse mass is per axis,
/// so that an axis may be locked.
pub(crate) fn mobility(inv_mass: Vec3, inv_inertia: &Sym3, r: Vec3) -> Sym3 {
    let column = |axis: Vec3| inv_inertia.mul(r.cross(axis)).cross(r);
    let (x, y, z) = (column(Vec3::X), column(Vec3::Y), column(Vec3::Z));
    Sym3 {
        xx: inv_mass.x + x.x,
        yy: inv_mass.y + y.y,
        zz: inv_mass.z + z.z,
        xy: y.x,
        xz: z.x,
        yz: z.y,
    }
}

/// Returns the impulse on B. The restitution e requires `u'_n = -e u_n`; it may be negative down to
/// -1, which leaves a part of the approach speed. `friction`: static, kinetic.
pub(crate) fn collide(
    k: &Sym3,
    n: Vec3,
    u: Vec3,
    restitution: f32,
    friction: [f32; 2],
) -> (Vec3, ImpactKind) {
    let u_n = u.dot(n);
    let k_n = k.mul(n);
    let k_nn = k_n.dot(n);
    if !(u_n < 0.0 && k_nn > 0.0) {
        return (Vec3::ZERO, ImpactKind::Separating);
    }
    let target = -restitution * u_n;
    let straight = n * ((target - u_n) / k_nn);
    let [mu_s, mu_k] = friction;
    let sticking = k.inverse().map(|inverse| inverse.mul(n * target - u));
    if let Some(j) = sticking {
        let j_n = j.dot(n);
        if j_n >= 0.0 && (j - n * j_n).length() <= mu_s * j_n {
            return (guarded(k, u, j, straight), ImpactKind::Stick);
        }
    }
    let j = slide(k, n, u, target, mu_k).or_else(|| {
        // No sliding direction, or a denominator that is not positive (a long thin body with high
        // friction): the sticking impulse, clamped to the cone.
        let j = sticking?;
        let j_n = j.dot(n);
        let rub = j - n * j_n;
        let size = rub.length();
        (j_n > 0.0 && size > 0.0).then(|| n * j_n + rub * (mu_k * j_n / size).min(1.0))
    });
    (guarded(k, u, j.unwrap_or(straight), straight), ImpactKind::Slide)
}

/// Returns the impulse on the friction cone, against the sliding; friction at most stops it.
fn slide(k: &Sym3, n: Vec3, u: Vec3, target: f32, mu: f32) -> Option<Vec3> {
    let u_n = u.dot(n);
    let along = (u - n * u_n).try_normalize()?;
    let ray = n - along * mu;
    let k_ray = k.mul(ray);
    let response = n.dot(k_ray);
    let k_n = k.mul(n);
    // A twentieth of the response without friction: below it the impulse has no bound.
    if !(response > 0.05 * n.dot(k_n)) {
        return None;
    }
    let j = ray * ((target - u_n) / response);
    if (u + k.mul(j)).dot(along) >= 0.0 {
        return Some(j);
    }
    // It would reverse the sliding: uses the impulse in the plane of normal and sliding that ends
    // both.
    let (nn, nt, tt) = (n.dot(k_n), along.dot(k_n), along.dot(k.mul(along)));
    let det = nn * tt - nt * nt;
    if !(det > 0.0) {
        return None;
    }
    let (a, b) = (target - u_n, -u.dot(along));
    let (j_n, j_t) = ((tt * a - nt * b) / det, (nn * b - nt * a) / det);
    (j_n > 0.0 && j_t.abs() <= mu * j_n).then(|| n * j_n + along * j_t)
}

/// Limits the impulse to a part that adds no energy. Newton's restitution with friction can add
/// some where normal and tangent are coupled [Kane85]. The work on the bodies is
/// `j · u + ½ j · K j`.
fn guarded(k: &Sym3, u: Vec3, j: Vec3, straight: Vec3) -> Vec3 {
    let (gain, cost) = (j.dot(u), j.dot(k.mul(j)));
    if !j.is_finite() || gain >= 0.0 {
        return straight;
    }
    if gain + 0.5 * cost <= 0.0 { j } else { j * (-2.0 * gain / cost) }
}

/// Change of velocity by an impulse on a body with these inverse masses per axis.
pub(crate) fn push(inv_mass: Vec3, j: Vec3) -> Vec3 {
    vec3(inv_mass.x * j.x, inv_mass.y * j.y, inv_mass.z * j.z)
}
