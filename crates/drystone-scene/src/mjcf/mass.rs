//! Masses of geoms, and what the compiler's settings make of masses.

use core::f32::consts::PI;

use drystone::geometry::MassProperties;
use drystone::math::{Sym3, trig};
use drystone::{Vec3, vec3};

use super::model::Masses;

/// The mass of a primitive at a density of 1 [its frame], of its volume or of a skin. For round
/// shapes x is the radius and z half the straight part, along z. `None`: it has no mass.
pub(super) fn of_primitive(kind: &str, half: Vec3, is_skin: bool) -> Option<MassProperties> {
    let (mass, moments) = match (kind, is_skin) {
        ("sphere", _) => sphere(half.x, is_skin),
        ("capsule", _) => capsule(half.x, half.z, is_skin),
        ("cylinder", _) => cylinder(half.x, half.z, is_skin),
        ("box", false) => {
            let m = 8.0 * half.x * half.y * half.z;
            (m, of_squares(half.mul_each(half)) * (m / 3.0))
        }
        ("box", true) => box_skin(half),
        ("ellipsoid", false) => {
            let m = 4.0 / 3.0 * PI * half.x * half.y * half.z;
            (m, of_squares(half.mul_each(half)) * (m / 5.0))
        }
        _ => ellipsoid_skin(half),
    };
    let own = MassProperties { mass, center: Vec3::ZERO, inertia: Sym3::diagonal(moments) };
    (mass > 0.0).then_some(own)
}

/// Sums of the other two.
fn of_squares(s: Vec3) -> Vec3 {
    vec3(s.y + s.z, s.x + s.z, s.x + s.y)
}

fn sphere(r: f32, is_skin: bool) -> (f32, Vec3) {
    let (m, factor) =
        if is_skin { (4.0 * PI * r * r, 2.0 / 3.0) } else { (4.0 / 3.0 * PI * r * r * r, 0.4) };
    (m, Vec3::splat(factor * m * r * r))
}

/// Two halves of a sphere at the ends of a rod or tube. The center of a half is 3r/8 from its flat
/// side, that of its skin r/2.
fn capsule(r: f32, h: f32, is_skin: bool) -> (f32, Vec3) {
    let (ends, about) = sphere(r, is_skin);
    let (rod, rod_along, rod_across, off) = if is_skin {
        let m = 4.0 * PI * r * h;
        (m, m * r * r, m * (0.5 * r * r + h * h / 3.0), 0.5 * r)
    } else {
        let m = 2.0 * PI * r * r * h;
        (m, 0.5 * m * r * r, m * (0.25 * r * r + h * h / 3.0), 0.375 * r)
    };
    let across = rod_across + about.x + ends * h * (h + 2.0 * off);
    (rod + ends, vec3(across, across, rod_along + about.z))
}

fn cylinder(r: f32, h: f32, is_skin: bool) -> (f32, Vec3) {
    let (square, long) = (r * r, h * h);
    if is_skin {
        let (tube, lids) = (4.0 * PI * r * h, 2.0 * PI * square);
        let across = tube * (0.5 * square + long / 3.0) + lids * (0.25 * square + long);
        return (tube + lids, vec3(across, across, tube * square + 0.5 * lids * square));
    }
    let m = 2.0 * PI * square * h;
    let across = m * (0.25 * square + long / 3.0);
    (m, vec3(across, across, 0.5 * m * square))
}

/// Two faces of each direction, which have their own place along their normal.
fn box_skin(half: Vec3) -> (f32, Vec3) {
    let sides = half.to_array();
    let (mut mass, mut squares) = (0.0, [0.0; 3]);
    for normal in 0..3 {
        let (a, b) = (sides[(normal + 1) % 3], sides[(normal + 2) % 3]);
        let m = 8.0 * a * b;
        mass += m;
        for (k, square) in squares.iter_mut().enumerate() {
            *square += m * sides[k] * sides[k] * if k == normal { 1.0 } else { 1.0 / 3.0 };
        }
    }
    (mass, of_squares(Vec3::from(squares)))
}

/// A skin of even thickness, as the limit of the difference of two ellipsoids whose half axes
/// differ by it. Its area is Thomsen's formula with p = 1.6075, exact to 1.1 %.
fn ellipsoid_skin(half: Vec3) -> (f32, Vec3) {
    const POWER: f32 = 1.6075;
    let Vec3 { x: a, y: b, z: c } = half;
    let power = |x: f32, p: f32| trig::exp(p * natural_log(x));
    let mean = (power(a * b, POWER) + power(b * c, POWER) + power(c * a, POWER)) / 3.0;
    let area = 4.0 * PI * power(mean, 1.0 / POWER);
    // Derivatives by the thickness of a b c and of a³ b c, which its moments are made of.
    let volume = a * b + b * c + c * a;
    let squares = [(a, b, c), (b, a, c), (c, a, b)]
        .map(|(x, y, z)| (3.0 * x * x * y * z + x * x * x * (y + z)) / (5.0 * volume));
    (area, of_squares(Vec3::from(squares)) * area)
}

/// The natural logarithm by the engine's exponential function, with Newton's steps.
fn natural_log(x: f32) -> f32 {
    let mut y = 0.0_f32;
    for _ in 0..60 {
        let e = trig::exp(y);
        y += (2.0 * (x - e) / (x + e)).clamp(-2.0, 2.0);
    }
    y
}

/// Least masses and moments, and moments that no body can have.
pub(super) fn bound(own: &mut MassProperties, masses: &Masses) {
    let [least_mass, least_moment] = masses.least;
    own.mass = own.mass.max(least_mass);
    if !(least_moment > 0.0 || masses.balance) {
        return;
    }
    let (moments, turn) = own.inertia.eigen();
    let mut raised = moments.max(Vec3::splat(least_moment));
    let sum = raised.x + raised.y + raised.z;
    if masses.balance && 2.0 * raised.max_element() > sum * (1.0 + 1.0e-6) {
        raised = Vec3::splat(sum / 3.0);
    }
    if raised != moments {
        own.inertia = Sym3::rotated_diagonal(turn, raised);
    }
}

/// Scales all masses so that they are `total` together.
pub(super) fn scale<'m>(masses: impl Iterator<Item = &'m mut MassProperties>, total: f32) {
    let all: Vec<&mut MassProperties> = masses.collect();
    let sum: f64 = all.iter().map(|m| f64::from(m.mass)).sum();
    #[expect(clippy::cast_possible_truncation, reason = "the engine's numbers have 32 bits")]
    let factor = (f64::from(total) / sum) as f32;
    if !(factor.is_finite() && factor > 0.0) {
        return;
    }
    for own in all {
        own.mass *= factor;
        own.inertia = own.inertia.scaled(factor);
    }
}
