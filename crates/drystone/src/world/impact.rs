//! A single collision of two bodies at one point. It needs no world.

use crate::base::collision::{ImpactKind, collide, mobility};
use crate::base::math::Vec3;
use crate::base::sym3::Sym3;
use crate::state::def::DefError;

/// One of the two colliding bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpactBody {
    /// Mass [kg]; 0: immovable.
    pub mass: f32,
    /// Inertia about the center of mass [kg m², world]. An inertia in the body's frame must be
    /// rotated with the body, `R I Rᵀ` ([`Sym3::rotated_diagonal`]). Zero: the body cannot rotate.
    pub inertia: Sym3,
    /// Velocity of the center of mass [m/s, world].
    pub linear_velocity: Vec3,
    /// Angular velocity [rad/s, world].
    pub angular_velocity: Vec3,
    /// Vector from the center of mass to the contact point [m, world].
    pub arm: Vec3,
}

impl ImpactBody {
    /// An immovable body at rest.
    pub const FIXED: Self = Self {
        mass: 0.0,
        inertia: Sym3::ZERO,
        linear_velocity: Vec3::ZERO,
        angular_velocity: Vec3::ZERO,
        arm: Vec3::ZERO,
    };

    /// Velocity of its contact point [m/s, world].
    #[must_use]
    pub fn point_velocity(&self) -> Vec3 {
        self.linear_velocity + self.angular_velocity.cross(self.arm)
    }

    fn check(&self, side: &str) -> Result<(Vec3, Sym3), DefError> {
        let wrong = |field: &str, value: &dyn core::fmt::Debug, allowed: &str| {
            DefError::new(field, format!("{value:?}"), allowed).within(side)
        };
        if !(self.mass >= 0.0 && self.mass.is_finite()) {
            return Err(wrong("mass", &self.mass, "a finite number of at least 0"));
        }
        for (field, v) in [
            ("linear_velocity", self.linear_velocity),
            ("angular_velocity", self.angular_velocity),
            ("arm", self.arm),
        ] {
            if !v.is_finite() {
                return Err(wrong(field, &v, "finite numbers"));
            }
        }
        let inv_mass = if self.mass > 0.0 { 1.0 / self.mass } else { 0.0 };
        if self.inertia == Sym3::ZERO || self.mass == 0.0 {
            return Ok((Vec3::splat(inv_mass), Sym3::ZERO));
        }
        let allowed = "zero or a finite positive definite matrix";
        let positive = self.inertia.is_finite() && self.inertia.eigen().0.min_element() > 0.0;
        match self.inertia.inverse() {
            Some(inverse) if positive && inverse.is_finite() => {
                Ok((Vec3::splat(inv_mass), inverse))
            }
            _ => Err(wrong("inertia", &self.inertia, allowed)),
        }
    }
}

/// Surface properties of a collision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpactSurface {
    /// Normal from A to B [world]; any length but zero.
    pub normal: Vec3,
    /// Ratio of the normal speed after to the normal speed before, 0 to 1.
    pub restitution: f32,
    /// Coefficient of static friction; at least 0.
    pub static_friction: f32,
    /// Coefficient of kinetic friction; 0 to `static_friction`.
    pub kinetic_friction: f32,
}

/// The result of a collision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// Impulse on B [N s, world]; A gets the opposite one.
    pub impulse: Vec3,
    /// Whether the surfaces stick or slide.
    pub kind: ImpactKind,
    /// Velocity of A's center of mass after the collision [m/s, world].
    pub linear_velocity_a: Vec3,
    /// Angular velocity of A after the collision [rad/s, world].
    pub angular_velocity_a: Vec3,
    /// Velocity of B's center of mass after the collision [m/s, world].
    pub linear_velocity_b: Vec3,
    /// Angular velocity of B after the collision [rad/s, world].
    pub angular_velocity_b: Vec3,
    /// Change of kinetic energy [J]; at most 0, apart from rounding.
    pub work: f32,
}

/// The collision of two bodies at one point: an instantaneous impulse with restitution (Newton) and
/// friction (Coulomb). It is exact if the surfaces stick, or if they slide without a change of the
/// sliding direction.
///
/// The table compares textbook formulas with the formulas used here, and gives the errors of the
/// former. The textbook formulas are those of a survey of impulse methods ("Realtime Rigid Body
/// Simulation Using Impulses", 2006, section 3.1). n points from 1 (A) to 2 (B), `u = v_2 + ω_2 ×
/// r_2 - v_1 - ω_1 × r_1`:
///
/// | printed | wrong because | here |
/// |---|---|---|
/// | `v_1 += j/m_1`, `v_2 -= j/m_2` with `j_n = -(1+ε)(u·n)/k_n` clamped to at least 0 | an approach has `u·n < 0`, so `j_n > 0` drives body 1 into body 2; with n reversed, approaching bodies get no impulse | `v_2 += j/m_2`, `v_1 -= j/m_1` |
/// | `j_t = -(u·t)(ε+1)/k_n` | uses the effective mass of the normal; `k_t` is defined and not used | `1/k_t`; where both act at once, the matrix K below |
/// | the factor `ε+1` in `j_t` | friction would reverse the slide by ε | no restitution along the surface |
/// | `t = ((n × u) × n)/‖u‖` | not a unit vector unless u lies in the surface: friction is too small by up to the square of the sine of the angle of u to n | `t = u_t/‖u_t‖`, `u_t = u - (u·n) n`; none for `u_t = 0` |
/// | `ω_1 += (r_1 × j) I_1⁻¹` | a row times a matrix in an unspecified frame | `ω += R I⁻¹ Rᵀ (r × j)` |
/// | `k_n` with `I⁻¹(r × n) × r` | ambiguous | `1/m_1 + 1/m_2 + Σ (r × n)·I⁻¹(r × n)` |
/// | normal and tangent one after the other | rotation couples them | both at once with `K = Σ 1/m - [r]× I⁻¹ [r]×`, `u' = u + K j` |
/// | one μ | sticking and sliding friction differ | static and kinetic friction |
/// | (nothing) | Newton's ε with friction can add energy (Kane) | j is scaled so that `j·u + ½ j·K j ≤ 0` |
///
/// The steps:
///
/// 1. *Stick*: `j = K⁻¹(-ε u_n n - u)`; the result if it lies in the cone `‖j_t‖ ≤ μ_s j_n`.
/// 2. *Slide*: `j = j_n (n - μ_k T)`, `T = u_t/‖u_t‖`, `j_n = -(1+ε) u_n / (n·K(n - μ_k T))`.
///    Friction stops a slide and does not reverse it. If the denominator is not positive
///    (Painlevé's rod), the sticking impulse is projected onto the cone.
/// 3. *Energy*: the impulse is scaled down if it would add energy.
///
/// ```
/// use drystone::{Vec3, vec3};
/// use drystone::impact::{ImpactBody, ImpactSurface, impact};
/// use drystone::math::Sym3;
///
/// let ball = |x: f32, speed: f32| ImpactBody {
///     mass: 2.0,
///     inertia: Sym3::diagonal(Vec3::splat(0.2)),
///     linear_velocity: vec3(speed, 0.0, 0.0),
///     angular_velocity: Vec3::ZERO,
///     arm: vec3(x, 0.0, 0.0),
/// };
/// let surface =
///     ImpactSurface { normal: Vec3::X, restitution: 1.0, static_friction: 0.3, kinetic_friction: 0.3 };
/// let after = impact(&ball(0.5, 3.0), &ball(-0.5, 0.0), &surface).unwrap();
/// assert_eq!(after.linear_velocity_a, Vec3::ZERO);
/// assert_eq!(after.linear_velocity_b, vec3(3.0, 0.0, 0.0));
/// ```
///
/// # Errors
/// The first number that is out of range.
pub fn impact(a: &ImpactBody, b: &ImpactBody, surface: &ImpactSurface) -> Result<Impact, DefError> {
    let (inv_mass_a, inv_inertia_a) = a.check("a")?;
    let (inv_mass_b, inv_inertia_b) = b.check("b")?;
    let Some(n) = surface.normal.try_normalize() else {
        let value = format!("{:?}", surface.normal);
        return Err(DefError::new("normal", value, "a finite vector other than zero"));
    };
    let e = surface.restitution;
    if !(0.0..=1.0).contains(&e) {
        return Err(DefError::new("restitution", e, "a number from 0 to 1"));
    }
    let (mu_s, mu_k) = (surface.static_friction, surface.kinetic_friction);
    if !(mu_s >= 0.0 && mu_s.is_finite()) {
        return Err(DefError::new("static_friction", mu_s, "a finite number of at least 0"));
    }
    if !(0.0..=mu_s).contains(&mu_k) {
        return Err(DefError::new(
            "kinetic_friction",
            mu_k,
            "a number from 0 to the static friction",
        ));
    }
    let u = b.point_velocity() - a.point_velocity();
    let k = mobility(inv_mass_a, &inv_inertia_a, a.arm).plus(mobility(
        inv_mass_b,
        &inv_inertia_b,
        b.arm,
    ));
    let (j, kind) = collide(&k, n, u, e, [mu_s, mu_k]);
    let work = j.dot(u + k.mul(j) * 0.5);
    if !(j.is_finite() && work.is_finite()) {
        return Err(DefError::new(
            "a, b",
            "too large or too small",
            "such that the impulse is finite",
        ));
    }
    Ok(Impact {
        impulse: j,
        kind,
        linear_velocity_a: a.linear_velocity - j * inv_mass_a.x,
        angular_velocity_a: a.angular_velocity - inv_inertia_a.mul(a.arm.cross(j)),
        linear_velocity_b: b.linear_velocity + j * inv_mass_b.x,
        angular_velocity_b: b.angular_velocity + inv_inertia_b.mul(b.arm.cross(j)),
        work,
    })
}

#[cfg(test)]
mod tests {
    use super::{Impact, ImpactBody, ImpactKind, ImpactSurface, impact};
    use crate::base::math::{Vec3, vec3};
    use crate::base::sym3::Sym3;

    fn surface(restitution: f32, friction: f32) -> ImpactSurface {
        ImpactSurface {
            normal: Vec3::Y,
            restitution,
            static_friction: friction,
            kinetic_friction: friction,
        }
    }

    /// A uniform rod of 1 kg and 1 m whose lower end meets the ground. `tilt`: sine and cosine of
    /// its angle to the ground.
    fn rod((sine, cosine): (f32, f32), velocity: Vec3) -> ImpactBody {
        let axis = vec3(cosine, sine, 0.0);
        // I = m/12 (1 - a aᵀ), plus a small moment about the axis itself.
        let i = 1.0 / 12.0;
        let inertia = Sym3 {
            xx: i * (1.0 - axis.x * axis.x) + 1.0e-4,
            yy: i * (1.0 - axis.y * axis.y) + 1.0e-4,
            zz: i,
            xy: -i * axis.x * axis.y,
            xz: 0.0,
            yz: 0.0,
        };
        ImpactBody {
            mass: 1.0,
            inertia,
            linear_velocity: velocity,
            angular_velocity: Vec3::ZERO,
            arm: axis * -0.5,
        }
    }

    fn energy(b: &ImpactBody, v: Vec3, w: Vec3) -> f32 {
        0.5 * (b.mass * v.length_squared() + w.dot(b.inertia.mul(w)))
    }

    fn check_laws(a: &ImpactBody, b: &ImpactBody, s: &ImpactSurface) -> Impact {
        let r = impact(a, b, s).unwrap();
        let n = s.normal;
        let before = energy(a, a.linear_velocity, a.angular_velocity)
            + energy(b, b.linear_velocity, b.angular_velocity);
        let after = energy(a, r.linear_velocity_a, r.angular_velocity_a)
            + energy(b, r.linear_velocity_b, r.angular_velocity_b);
        // Rounding of products of numbers of this size.
        let slack = 1.0e-5 * (before + 1.0);
        assert!(after <= before + slack, "energy {before} to {after}");
        assert!((after - before - r.work).abs() <= slack, "work {}", r.work);
        let j_n = r.impulse.dot(n);
        let j_t = (r.impulse - n * j_n).length();
        assert!(j_n >= 0.0 && j_t <= s.static_friction * j_n * 1.0001 + 1e-6, "{j_t} of {j_n}");
        r
    }

    #[test]
    fn two_masses_on_a_line_leave_as_momentum_and_restitution_say() {
        for (m_a, m_b) in [(1.0, 1.0), (1.0, 1.0e4), (1.0e3, 1.0), (2.0, 3.0)] {
            for e in [0.0, 0.3, 0.7, 1.0] {
                let side = |mass: f32, v: f32| ImpactBody {
                    mass,
                    linear_velocity: vec3(0.0, v, 0.0),
                    ..ImpactBody::FIXED
                };
                let (v_a, v_b) = (2.0, -3.0);
                let r = check_laws(&side(m_a, v_a), &side(m_b, v_b), &surface(e, 0.5));
                let mean = (m_a * v_a + m_b * v_b) / (m_a + m_b);
                let want_a = mean - e * m_b * (v_a - v_b) / (m_a + m_b);
                let want_b = mean + e * m_a * (v_a - v_b) / (m_a + m_b);
                assert!((r.linear_velocity_a.y - want_a).abs() < 1e-5, "{m_a} {m_b} {e}");
                assert!((r.linear_velocity_b.y - want_b).abs() < 1e-5, "{m_a} {m_b} {e}");
            }
        }
    }

    #[test]
    fn a_ball_that_slides_over_the_ground_sticks_exactly_above_the_critical_friction() {
        // For a solid ball K_t = 7/2 /m and K_n = 1/m, so it sticks if v_t ≤ 7/2 μ (1 + e) v_n.
        let (e, v_n) = (0.5, 2.0);
        let ball = |v_t: f32| ImpactBody {
            mass: 1.0,
            inertia: Sym3::diagonal(Vec3::splat(0.4 * 0.25)),
            linear_velocity: vec3(v_t, -v_n, 0.0),
            angular_velocity: Vec3::ZERO,
            arm: vec3(0.0, -0.5, 0.0),
        };
        let mu = 0.2;
        let limit = 3.5 * mu * (1.0 + e) * v_n;
        let slow = check_laws(&ImpactBody::FIXED, &ball(0.999 * limit), &surface(e, mu));
        let fast = check_laws(&ImpactBody::FIXED, &ball(1.001 * limit), &surface(e, mu));
        assert_eq!((slow.kind, fast.kind), (ImpactKind::Stick, ImpactKind::Slide));
        // A sticking ball rolls: v + ω × r = 0 along the surface; 5/7 of the speed is left.
        assert!((slow.linear_velocity_b.x - 5.0 / 7.0 * 0.999 * limit).abs() < 1e-5);
        assert!((fast.linear_velocity_b.x - (1.001 * limit - mu * (1.0 + e) * v_n)).abs() < 1e-5);
        assert!((slow.linear_velocity_b.y - e * v_n).abs() < 1e-5);
    }

    #[test]
    fn no_oblique_impact_of_a_rod_adds_energy_not_even_kanes() {
        // Half-angle tangents avoid trigonometry.
        for half in [0.1_f32, 0.3, 0.6, 0.9, 1.3, 2.0, 3.0] {
            let tilt =
                (2.0 * half / (1.0 + half * half), (1.0 - half * half) / (1.0 + half * half));
            for friction in [0.0, 0.5, 1.0, 2.0, 5.0] {
                for speed in [-10.0, -1.0, 0.0, 0.1, 2.0, 30.0] {
                    for e in [0.0, 0.5, 1.0] {
                        let b = rod(tilt, vec3(speed, -1.0, 0.2));
                        check_laws(&ImpactBody::FIXED, &b, &surface(e, friction));
                    }
                }
            }
        }
    }

    #[test]
    fn the_printed_formula_drives_approaching_bodies_together_and_the_corrected_one_apart() {
        let side = |v: f32| ImpactBody {
            mass: 1.0,
            linear_velocity: vec3(0.0, v, 0.0),
            ..ImpactBody::FIXED
        };
        let (a, b, s) = (side(1.0), side(-1.0), surface(0.0, 0.0));
        let approach = |v_a: f32, v_b: f32| v_a - v_b;
        // The printed formula: j_n = -(1 + e) u_n / k_n, v_1 + j/m_1, v_2 - j/m_2.
        let u_n = -2.0;
        let j = -(1.0 + s.restitution) * u_n / 2.0;
        assert!(approach(1.0 + j, -1.0 - j) > approach(1.0, -1.0));
        let r = impact(&a, &b, &s).unwrap();
        assert!(approach(r.linear_velocity_a.y, r.linear_velocity_b.y).abs() < 1e-6);
    }

    #[test]
    fn what_parts_gets_nothing_and_bad_numbers_are_refused_by_name() {
        let b = rod((0.6, 0.8), vec3(0.0, 1.0, 0.0));
        let r = impact(&ImpactBody::FIXED, &b, &surface(1.0, 0.5)).unwrap();
        assert_eq!((r.kind, r.impulse), (ImpactKind::Separating, Vec3::ZERO));
        let fixed = ImpactBody::FIXED;
        let field = |a: ImpactBody, b: ImpactBody, s: ImpactSurface| {
            impact(&a, &b, &s).unwrap_err().field().to_owned()
        };
        let s = surface(0.5, 0.5);
        assert_eq!(field(fixed, ImpactBody { mass: -1.0, ..b }, s), "b.mass");
        assert_eq!(field(ImpactBody { mass: f32::NAN, ..b }, b, s), "a.mass");
        let flat = Sym3::diagonal(vec3(1.0, 0.0, 1.0));
        assert_eq!(field(fixed, ImpactBody { inertia: flat, ..b }, s), "b.inertia");
        let lost = vec3(0.0, f32::INFINITY, 0.0);
        assert_eq!(field(fixed, ImpactBody { linear_velocity: lost, ..b }, s), "b.linear_velocity");
        assert_eq!(field(fixed, b, ImpactSurface { normal: Vec3::ZERO, ..s }), "normal");
        assert_eq!(field(fixed, b, ImpactSurface { restitution: 1.5, ..s }), "restitution");
        assert_eq!(
            field(fixed, b, ImpactSurface { kinetic_friction: 0.6, ..s }),
            "kinetic_friction"
        );
    }
}
