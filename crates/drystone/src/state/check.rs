//! Checks of what a user passes: each names the field, its value and what is allowed.

use super::def::DefError;
use crate::base::math::Vec3;
use crate::base::quat::Quat;

pub(crate) fn finite(field: &str, value: f32) -> Result<(), DefError> {
    if value.is_finite() { Ok(()) } else { Err(DefError::new(field, value, "a finite number")) }
}

pub(crate) fn finite_vec(field: &str, v: Vec3) -> Result<(), DefError> {
    if v.is_finite() {
        return Ok(());
    }
    Err(DefError::new(field, format!("({}, {}, {})", v.x, v.y, v.z), "finite numbers"))
}

fn bounded(field: &str, v: Vec3, limit: f32, allowed: &str) -> Result<(), DefError> {
    finite_vec(field, v)?;
    if v.abs().max_element() <= limit {
        return Ok(());
    }
    Err(DefError::new(field, format!("({}, {}, {})", v.x, v.y, v.z), allowed))
}

pub(crate) fn position(field: &str, v: Vec3) -> Result<(), DefError> {
    bounded(field, v, 1.0e7, "numbers up to 1e7 m")
}

pub(crate) fn velocity(field: &str, v: Vec3) -> Result<(), DefError> {
    bounded(field, v, 1.0e6, "numbers up to 1e6")
}

pub(crate) fn at_least_zero(field: &str, value: f32) -> Result<(), DefError> {
    if value >= 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(DefError::new(field, value, "a finite number of at least 0"))
}

pub(crate) fn above_zero(field: &str, value: f32) -> Result<(), DefError> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(DefError::new(field, value, "a finite number above 0"))
}

/// A rotation given by the user may be a little off unit length; far off is a mistake.
pub(crate) fn unit(field: &str, q: Quat) -> Result<(), DefError> {
    let n = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
    if (0.9..1.1).contains(&n) {
        return Ok(());
    }
    let value = format!("({}, {}, {}, {})", q.x, q.y, q.z, q.w);
    Err(DefError::new(field, value, "a unit quaternion"))
}
