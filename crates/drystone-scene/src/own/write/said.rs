//! Values that a file says: those that differ from the engine's defaults.

use std::path::Path;

use drystone::{Pose, Quat, Vec3};

use crate::error::SceneError;
use crate::own::document::Layer;
use crate::own::value::{Triple, Turn};

/// A number that is not the default.
pub(super) fn unless(value: f32, default: f32) -> Option<f32> {
    (value.to_bits() != default.to_bits()).then_some(value)
}

/// A vector that is not the default; zeros have signs.
pub(super) fn unless_vec(value: Vec3, default: Vec3) -> Option<Triple> {
    let bits = |v: Vec3| v.to_array().map(f32::to_bits);
    (bits(value) != bits(default)).then(|| value.to_array())
}

/// A turn that is not none.
pub(super) fn unless_turn(value: Quat) -> Option<Turn> {
    let bits = |q: Quat| q.to_array().map(f32::to_bits);
    (bits(value) != bits(Quat::IDENTITY)).then(|| Turn::Quaternion(value.to_array()))
}

/// Any other value that is not the default.
pub(super) fn other<T: PartialEq>(value: T, default: &T) -> Option<T> {
    (value != *default).then_some(value)
}

pub(super) fn refuse(place: &str, problem: impl core::fmt::Display, allowed: &str) -> SceneError {
    SceneError::new(Path::new(""), place, problem, allowed)
}

/// Layers by their numbers.
pub(super) fn layers(bits: u64) -> Vec<Layer> {
    (0..64_u8).filter(|bit| bits >> bit & 1 == 1).map(Layer::Number).collect()
}

/// A pose in its two parts.
pub(super) fn parts(pose: &Pose) -> (Option<Triple>, Option<Turn>) {
    (unless_vec(pose.position, Vec3::ZERO), unless_turn(pose.rotation))
}
