//! The shapes a user can give to a body.

use std::sync::Arc;

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::hull::Hull;
use super::mesh::Mesh;
use crate::base::limits;
use crate::base::math::Vec3;

/// A shape in its own frame: centered on the origin; round shapes have their axis along y.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub enum Shape {
    /// A ball.
    Sphere {
        /// Radius [m], above 0.
        radius: f32,
    },
    /// A cylinder along y with half balls on its ends.
    Capsule {
        /// Half the length between the centers of the end balls [m], at least 0.
        half_height: f32,
        /// Radius [m], above 0.
        radius: f32,
    },
    /// A box.
    Box {
        /// Half the edge lengths [m], each above 0.
        half_extents: Vec3,
    },
    /// A cylinder along y.
    Cylinder {
        /// Half the height [m], above 0.
        half_height: f32,
        /// Radius [m], above 0.
        radius: f32,
    },
    /// A cone along y, truncated where both radii are above 0. The origin is at half height.
    Cone {
        /// Half the height [m], above 0.
        half_height: f32,
        /// Radius at y = -half_height [m], at least 0.
        radius_bottom: f32,
        /// Radius at y = +half_height [m], at least 0; one of the radii above 0.
        radius_top: f32,
    },
    /// A convex hull.
    Hull(Arc<Hull>),
    /// All points `p` with `normal · p <= offset`: infinite solid ground. Static bodies only.
    HalfSpace {
        /// Unit normal of the surface, pointing out of the solid [local].
        normal: Vec3,
        /// Distance of the surface from the origin along the normal [m].
        offset: f32,
    },
    /// A triangle mesh; both sides of a triangle are solid. Static and kinematic bodies only.
    Mesh(Arc<Mesh>),
}

/// An invalid number of a shape: the field, its value, and the allowed range.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeError {
    /// Name of the field.
    pub field: &'static str,
    /// Its value.
    pub value: f32,
    /// The allowed values, worded to follow "must be".
    pub allowed: &'static str,
}

impl core::fmt::Display for ShapeError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "`{}` must be {} (got {})", self.field, self.allowed, self.value)
    }
}

impl core::error::Error for ShapeError {}

fn positive(field: &'static str, value: f32) -> Result<(), ShapeError> {
    if limits::LENGTH.admits(value) {
        Ok(())
    } else {
        Err(ShapeError { field, value, allowed: limits::LENGTH.allowed })
    }
}

fn not_negative(field: &'static str, value: f32) -> Result<(), ShapeError> {
    if (0.0..=limits::LENGTH.maximum).contains(&value) {
        Ok(())
    } else {
        Err(ShapeError { field, value, allowed: "a length from 0 to 1e7 m" })
    }
}

impl Shape {
    /// A ball of this radius [m].
    #[must_use]
    pub const fn sphere(radius: f32) -> Self {
        Self::Sphere { radius }
    }

    /// A capsule along y from half the length between the ball centers [m] and the radius [m].
    #[must_use]
    pub const fn capsule(half_height: f32, radius: f32) -> Self {
        Self::Capsule { half_height, radius }
    }

    /// A box of these half extents [m].
    #[must_use]
    pub fn box_half(half_extents: impl Into<Vec3>) -> Self {
        Self::Box { half_extents: half_extents.into() }
    }

    /// A box of these edge lengths [m].
    #[must_use]
    pub fn box_full(extents: impl Into<Vec3>) -> Self {
        Self::Box { half_extents: extents.into() * 0.5 }
    }

    /// A cylinder along y of this half height [m] and radius [m].
    #[must_use]
    pub const fn cylinder(half_height: f32, radius: f32) -> Self {
        Self::Cylinder { half_height, radius }
    }

    /// A pointed cone along y: base of this radius [m] at −half_height, tip at +half_height [m].
    #[must_use]
    pub const fn cone(half_height: f32, radius: f32) -> Self {
        Self::Cone { half_height, radius_bottom: radius, radius_top: 0.0 }
    }

    /// The half-space below a plane, see [`Shape::HalfSpace`]; the normal is normalized.
    #[must_use]
    pub fn half_space(normal: impl Into<Vec3>, offset: f32) -> Self {
        Self::HalfSpace { normal: normal.into().normalize_or(Vec3::ZERO), offset }
    }

    /// Name of the kind, in one word.
    #[must_use]
    pub const fn kind(&self) -> &'static str {
        match self {
            Self::Sphere { .. } => "sphere",
            Self::Capsule { .. } => "capsule",
            Self::Box { .. } => "box",
            Self::Cylinder { .. } => "cylinder",
            Self::Cone { .. } => "cone",
            Self::Hull(_) => "hull",
            Self::HalfSpace { .. } => "half-space",
            Self::Mesh(_) => "mesh",
        }
    }

    /// Returns true if all faces are flat; manifolds of flat shapes may be recycled.
    pub(crate) const fn is_flat(&self) -> bool {
        matches!(self, Self::Box { .. } | Self::Hull(_) | Self::Mesh(_) | Self::HalfSpace { .. })
    }

    /// Validates every number.
    ///
    /// # Errors
    /// The first field that is out of range.
    pub fn validate(&self) -> Result<(), ShapeError> {
        match *self {
            Self::Sphere { radius } => positive("radius", radius),
            Self::Capsule { half_height, radius } => {
                not_negative("half_height", half_height)?;
                positive("radius", radius)
            }
            Self::Box { half_extents } => {
                positive("half_extents.x", half_extents.x)?;
                positive("half_extents.y", half_extents.y)?;
                positive("half_extents.z", half_extents.z)
            }
            Self::Cylinder { half_height, radius } => {
                positive("half_height", half_height)?;
                positive("radius", radius)
            }
            Self::Cone { half_height, radius_bottom, radius_top } => {
                positive("half_height", half_height)?;
                not_negative("radius_bottom", radius_bottom)?;
                not_negative("radius_top", radius_top)?;
                positive("radius", radius_bottom.max(radius_top))
            }
            Self::HalfSpace { normal, offset } => {
                let length = normal.length();
                if !((length - 1.0).abs() < 1.0e-3) {
                    return Err(ShapeError {
                        field: "normal",
                        value: length,
                        allowed: "a vector of length 1",
                    });
                }
                if !limits::POSITION.admits(offset) {
                    let allowed = "a number within ±1e7 m";
                    return Err(ShapeError { field: "offset", value: offset, allowed });
                }
                Ok(())
            }
            Self::Hull(_) | Self::Mesh(_) => Ok(()),
        }
    }
}
