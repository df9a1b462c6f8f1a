//! The error of a refused definition or call.

use core::fmt::{self, Display};

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::base::math::Vec3;
use crate::geometry::shape::ShapeError;

/// Why a definition or a call was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub enum DefErrorKind {
    /// A number or a word is not allowed: it is not finite, out of range, or unknown.
    Value,
    /// An id refers to nothing in this world: the object was removed, or belongs to another world.
    Missing,
    /// The value is valid by itself but does not suit its use, such as a mesh for a dynamic body.
    Unsuitable,
}

/// The error of a refused definition: the field, its value, and the allowed values. Nothing was
/// changed.
///
/// ```
/// use drystone::{BodyDef, DefErrorKind, World};
///
/// let mut world = World::default();
/// let refused = world.add_body(BodyDef::dynamic().with_position([f32::NAN, 0.0, 0.0]));
/// assert!(refused.is_err_and(|e| e.kind() == DefErrorKind::Value && e.field() == "position"));
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DefError {
    kind: DefErrorKind,
    field: String,
    value: String,
    allowed: String,
}

impl DefError {
    pub(crate) fn new(field: &str, value: impl Display, allowed: &str) -> Self {
        Self {
            kind: DefErrorKind::Value,
            field: field.to_owned(),
            value: value.to_string(),
            allowed: allowed.to_owned(),
        }
    }

    /// The error for an id that refers to nothing in this world.
    pub(crate) fn missing(field: &str, value: impl Display, allowed: &str) -> Self {
        Self { kind: DefErrorKind::Missing, ..Self::new(field, value, allowed) }
    }

    /// The error for a value that does not suit its use.
    pub(crate) fn unsuitable(field: &str, value: impl Display, allowed: &str) -> Self {
        Self { kind: DefErrorKind::Unsuitable, ..Self::new(field, value, allowed) }
    }

    /// The error for a vector.
    pub(crate) fn of_vec(field: &str, value: Vec3, allowed: &str) -> Self {
        Self::new(field, format_args!("({}, {}, {})", value.x, value.y, value.z), allowed)
    }

    /// The same error for a field inside `outer`.
    pub(crate) fn within(mut self, outer: &str) -> Self {
        self.field = format!("{outer}.{}", self.field);
        self
    }

    /// The kind of error, to match on.
    #[must_use]
    pub const fn kind(&self) -> DefErrorKind {
        self.kind
    }

    /// Path of the field, such as `shapes[0].radius`.
    #[must_use]
    pub fn field(&self) -> &str {
        &self.field
    }

    /// The given value.
    #[must_use]
    pub fn value(&self) -> &str {
        &self.value
    }

    /// The allowed values, worded to follow "must be".
    #[must_use]
    pub fn allowed(&self) -> &str {
        &self.allowed
    }
}

impl Display for DefError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`{}` must be {} (got {})", self.field, self.allowed, self.value)
    }
}

impl core::error::Error for DefError {}

impl From<ShapeError> for DefError {
    fn from(e: ShapeError) -> Self {
        Self::new(e.field, e.value, e.allowed)
    }
}
