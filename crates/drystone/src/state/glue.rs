//! The definition of glued shapes and its validation.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::def::check::{above_zero, finite_vec, position};
use super::def::{DefError, ShapeDef};
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::geometry::flush::flush;
use crate::geometry::solid::{Core, Solid};

/// The strength of glue. Stress is force over area, computed from the average force over a step. An
/// impact shorter than a step counts as if it lasted the whole step.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct BondStrength {
    /// Maximum tension across the face, including that of bending [Pa]; above 0; may be infinite.
    /// Compression breaks no bond.
    pub tension: f32,
    /// Maximum shear along the face, including that of twisting [Pa]; above 0; may be infinite.
    pub shear: f32,
}

/// Glue on a face shared by two shapes of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Bond {
    /// The two shapes, as indices into [`crate::BodyDef::shapes`].
    pub shapes: [usize; 2],
    /// Center of the face [m, body].
    pub point: Vec3,
    /// Normal from the first shape to the second [body]; any length.
    pub normal: Vec3,
    /// Area of the face [m²]; above 0.
    pub area: f32,
    /// The stress at which it breaks.
    pub strength: BondStrength,
}

/// Bonds between the shapes of a body. A bond breaks when its stress exceeds its strength. Parts
/// that are no longer connected by bonds become separate bodies.
///
/// The part with the largest mass stays the original body, with its id; the others are new bodies.
/// Shapes keep their ids, materials, filters and user data. New bodies inherit the body's gravity
/// scale, damping, axis locks, sleep settings and user data, and the velocity of their matter. They
/// have no lasting forces.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Glue {
    /// The bonds. They must connect all shapes except sensors.
    pub bonds: Vec<Bond>,
}

/// Maximum number of pieces of a glued body. The stress in its bonds is solved for in steps in
/// which its load changes.
const MAX_PIECES: usize = 4096;

impl Glue {
    /// Creates a bond on each face that two of these shapes share. The shapes must be boxes or
    /// hulls with parallel faces that are at most `gap` apart [m] and overlap each other at most as
    /// deep. The faces must overlap by more than a thousandth of the smaller one.
    ///
    /// # Errors
    /// A shape or the strength is out of range.
    pub fn touching(
        shapes: &[ShapeDef],
        gap: f32,
        strength: BondStrength,
    ) -> Result<Self, DefError> {
        strength.validate()?;
        above_zero("gap", gap)?;
        let mut placed: Vec<(usize, Solid, Pose)> = Vec::new();
        for (i, shape) in shapes.iter().enumerate() {
            shape.validate().map_err(|e| e.within(&format!("shapes[{i}]")))?;
            if !shape.sensor {
                let rotation = shape.pose.rotation.normalized();
                placed.push((i, Solid::of(&shape.shape), Pose { rotation, ..shape.pose }));
            }
        }
        let mut bonds = Vec::new();
        for (k, (i, a, at)) in placed.iter().enumerate() {
            let near = a.aabb(at).grown(gap);
            for (j, b, to) in &placed[k + 1..] {
                let (Core::Hull(hull_a), Core::Hull(hull_b)) = (&a.core, &b.core) else { continue };
                if a.radius > 0.0 || b.radius > 0.0 || !near.overlaps(&b.aabb(to)) {
                    continue;
                }
                let minimum = 1.0e-3 * face_area(a).min(face_area(b));
                if let Some(face) = flush((hull_a, at), (hull_b, to), gap)
                    && face.area > minimum
                {
                    bonds.push(Bond {
                        shapes: [*i, *j],
                        point: face.point,
                        normal: face.normal,
                        area: face.area,
                        strength,
                    });
                }
            }
        }
        Ok(Self { bonds })
    }

    /// Checks every field against the shapes of the body.
    ///
    /// # Errors
    /// The first field that is out of range; a shape without a bond; shapes that are not all
    /// connected.
    pub fn validate(&self, shapes: &[ShapeDef]) -> Result<(), DefError> {
        if shapes.len() > MAX_PIECES {
            return Err(DefError::new("shapes", shapes.len(), "at most 4096 in number"));
        }
        let mut part: Vec<usize> = (0..shapes.len()).collect();
        for (i, bond) in self.bonds.iter().enumerate() {
            let outer = format!("bonds[{i}]");
            bond.validate(shapes).map_err(|e| e.within(&outer))?;
            let [a, b] = bond.shapes.map(|s| root(&mut part, s));
            part[a.max(b)] = a.min(b);
        }
        let mut first = None;
        for (i, shape) in shapes.iter().enumerate() {
            if shape.sensor {
                continue;
            }
            let own = root(&mut part, i);
            if *first.get_or_insert(own) != own {
                let value = format!("bonds that do not reach shape {i} from the first one");
                return Err(DefError::unsuitable(
                    "bonds",
                    value,
                    "bonds that hold all shapes together",
                ));
            }
        }
        Ok(())
    }
}

impl Bond {
    fn validate(&self, shapes: &[ShapeDef]) -> Result<(), DefError> {
        for (side, shape) in self.shapes.into_iter().enumerate() {
            let name = format!("shapes[{side}]");
            let Some(def) = shapes.get(shape) else {
                let allowed = format!("the index of a shape, below {}", shapes.len());
                return Err(DefError::unsuitable(&name, shape, &allowed));
            };
            if def.sensor {
                return Err(DefError::unsuitable(&name, shape, "a shape that is not a sensor"));
            }
        }
        if self.shapes[0] == self.shapes[1] {
            return Err(DefError::unsuitable(
                "shapes[1]",
                self.shapes[1],
                "a shape other than shapes[0]",
            ));
        }
        position("point", self.point)?;
        finite_vec("normal", self.normal)?;
        if self.normal.try_normalize().is_none() {
            return Err(DefError::new("normal", "zero", "a direction of nonzero length"));
        }
        above_zero("area", self.area)?;
        self.strength.validate().map_err(|e| e.within("strength"))
    }
}

impl BondStrength {
    /// A strength with this limit for both tension and shear [Pa].
    #[must_use]
    pub const fn both(stress: f32) -> Self {
        Self { tension: stress, shear: stress }
    }

    pub(crate) fn validate(&self) -> Result<(), DefError> {
        for (name, value) in [("tension", self.tension), ("shear", self.shear)] {
            if value != f32::INFINITY {
                above_zero(name, value)?;
            }
        }
        Ok(())
    }
}

/// The first element of the part of `i`. Parts are chains of decreasing indices.
pub(crate) fn root(part: &mut [usize], mut i: usize) -> usize {
    while part[i] != i {
        part[i] = part[part[i]];
        i = part[i];
    }
    i
}

/// The smallest side of the box around a solid [m²].
fn face_area(solid: &Solid) -> f32 {
    let h = solid.aabb(&Pose::IDENTITY).half_extents();
    4.0 * (h.x * h.y).min(h.x * h.z).min(h.y * h.z)
}
