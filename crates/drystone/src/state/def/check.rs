//! Checks of the user's values. Each error gives the field, its value and the allowed values.

use super::DefError;
use crate::base::limits;
use crate::base::limits::Limit;
use crate::base::math::Vec3;
use crate::base::quat::Quat;

pub(crate) fn finite_vec(field: &str, v: Vec3) -> Result<(), DefError> {
    if v.is_finite() {
        return Ok(());
    }
    Err(DefError::of_vec(field, v, "finite numbers"))
}

/// Checks that a number is in its range.
pub(crate) fn within(field: &str, value: f32, limit: &Limit) -> Result<(), DefError> {
    if limit.admits(value) { Ok(()) } else { Err(DefError::new(field, value, limit.allowed)) }
}

/// Checks that all components are in a range.
pub(crate) fn all_within(field: &str, v: Vec3, limit: &Limit) -> Result<(), DefError> {
    if limit.admits(v.x) && limit.admits(v.y) && limit.admits(v.z) {
        return Ok(());
    }
    Err(DefError::of_vec(field, v, limit.allowed))
}

pub(crate) fn position(field: &str, v: Vec3) -> Result<(), DefError> {
    all_within(field, v, &limits::POSITION)
}

pub(crate) fn velocity(field: &str, v: Vec3) -> Result<(), DefError> {
    all_within(field, v, &limits::SPEED)
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

/// Checks and normalizes a rotation. A small deviation from unit length is accepted; a large one is
/// an error.
pub(crate) fn unit(field: &str, q: Quat) -> Result<(), DefError> {
    if q.is_unit() {
        return Ok(());
    }
    let value = format!("({}, {}, {}, {})", q.x, q.y, q.z, q.w);
    Err(DefError::new(field, value, "a unit quaternion"))
}
