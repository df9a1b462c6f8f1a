//! Masses and moments of inertia, as exact as files have them.

use drystone::Vec3;
use drystone::geometry::MassProperties;
use drystone::math::Sym3;

use super::element::origin;
use crate::error::SceneError;
use crate::read::xml::Element;

/// A moment below zero by no more than this part of the largest is rounded wrongly: numbers of two
/// digits are off by up to half a percent each.
const ROUNDING: f32 = 0.01;

/// A moment below zero by no more than that of a point a tenth of a micrometer off is a rounded 0
/// [m²].
const TINY: f32 = 1.0e-14;

/// A moment may be this part above the sum of the other two, by the same rounding.
const TRIANGLE: f32 = 1.0 + ROUNDING;

/// The mass of an `<inertial>` [frame of the link], with a note on what is repaired or odd.
pub(super) fn read(element: &Element<'_>) -> Result<(MassProperties, Option<String>), SceneError> {
    let at = origin(element)?;
    let Some(mass) = element.child("mass") else {
        return Err(element.error("it has no <mass>", "one with a value"));
    };
    mass.need("value")?;
    let mass = mass.at_least_zero("value")?.unwrap_or(0.0);
    let (mut inertia, mut note) = match element.child("inertia") {
        Some(inertia) => moments(&inertia, mass)?,
        None => (Sym3::default(), None),
    };
    if mass <= 0.0 && inertia != Sym3::default() {
        // PyBullet takes it the same way.
        note = Some("its mass is 0, so its inertia counts for nothing".to_owned());
        inertia = Sym3::default();
    }
    // A part by itself, turned into the link's axes.
    let own = MassProperties { mass, center: Vec3::ZERO, inertia };
    let whole = if mass > 0.0 {
        MassProperties::combine(&[(at, own)])
    } else {
        MassProperties { center: at.position, ..own }
    };
    Ok((whole, note))
}

/// The matrix of an `<inertia>` [frame of the inertial].
fn moments(element: &Element<'_>, mass: f32) -> Result<(Sym3, Option<String>), SceneError> {
    let part = |name: &str| Ok::<f32, SceneError>(element.number(name)?.unwrap_or(0.0));
    let mut diagonal = [part("ixx")?, part("iyy")?, part("izz")?];
    let largest = diagonal.iter().fold(0.0_f32, |most, x| most.max(*x));
    let mut notes: Vec<String> = Vec::new();
    for (moment, name) in diagonal.iter_mut().zip(["ixx", "iyy", "izz"]) {
        if *moment < 0.0 {
            if *moment < -(ROUNDING * largest).max(TINY * mass) {
                return Err(element.wrong(name, "a number of at least 0"));
            }
            notes.push(format!("its {name} of {moment} is taken as 0"));
            *moment = 0.0;
        }
    }
    let [xx, yy, zz] = diagonal;
    let given = Sym3 { xx, yy, zz, xy: part("ixy")?, xz: part("ixz")?, yz: part("iyz")? };
    let (principal, turn) = given.eigen();
    if principal.abs().max_element() < TINY * mass {
        return Ok((Sym3::default(), None));
    }
    let mut inertia = given;
    let (least, most) = (principal.min_element(), principal.max_element());
    if least < 0.0 && least >= -ROUNDING * most {
        inertia = Sym3::rotated_diagonal(turn, principal.max(Vec3::ZERO));
        // Below a millionth it is the rounding of the computation, not of the file.
        if least < -1.0e-6 * most {
            notes.push(format!("its principal moment of {least} kg m2 is taken as 0"));
        }
    }
    let sum = principal.x + principal.y + principal.z;
    if least >= 0.0 && most > TRIANGLE * (sum - most) {
        let Vec3 { x, y, z } = principal;
        notes.push(format!(
            "no body has its principal moments of {x}, {y} and {z} kg m2, of which one is above the \
             sum of the others: taken as given"
        ));
    }
    let note = (!notes.is_empty()).then(|| notes.join(", "));
    Ok((inertia, note))
}

/// The moment of a ball of 1 cm with this mass [kg; kg m²], for a mass without any inertia.
pub(super) fn of_ball(mass: f32) -> f32 {
    0.4 * mass * 1.0e-4
}
