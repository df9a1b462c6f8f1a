//! What a surface is made of, how two surfaces combine, and what may collide with what.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::check::within;
use super::def::DefError;
use crate::base::limits;

/// How the coefficients of two surfaces become one. Where two surfaces ask for different rules the
/// one listed later here wins; the order of the last four is that of `KHR_physics_rigid_bodies`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub enum Combine {
    /// √(a b): friction's default.
    #[default]
    GeometricMean,
    /// a b.
    Multiply,
    /// The larger one: restitution's default.
    Maximum,
    /// The smaller one.
    Minimum,
    /// (a + b) / 2.
    Average,
}

impl Combine {
    /// The coefficient of a pair whose sides ask for the rules `self` and `other`.
    #[must_use]
    pub fn apply(self, other: Self, a: f32, b: f32) -> f32 {
        match self.max(other) {
            Self::GeometricMean => (a * b).sqrt(),
            Self::Average => 0.5 * (a + b),
            Self::Minimum => a.min(b),
            Self::Maximum => a.max(b),
            Self::Multiply => a * b,
        }
    }
}

/// A surface.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Material {
    /// Coulomb friction coefficient, at least 0; default 0.6. Of what sticks, and of what slides if
    /// [`kinetic_friction`](Self::kinetic_friction) is not given.
    pub friction: f32,
    /// Friction coefficient of what slides, at least 0; default `None`: the same as
    /// [`friction`](Self::friction). Combined by the same rule; a pair whose kinetic friction would be more
    /// than its static friction has the static one.
    pub kinetic_friction: Option<f32>,
    /// Coefficient of restitution, 0 to 1; default 0.
    pub restitution: f32,
    /// Rolling resistance: the torque against rolling, as a part of normal force times the shape's
    /// radius; at least 0; default 0. Only spheres, capsules, cylinders and cones have a radius. It
    /// acts against any turning of the two against each other, about the normal too.
    pub rolling_resistance: f32,
    /// Spinning resistance: the torque about the contact's normal alone, as a part of normal force times
    /// the shape's radius; at least 0; default 0. Of the shapes that have rolling resistance, on top
    /// of that and of what friction over a flat contact gives; where there is no friction there is none
    /// either. Of two surfaces the larger torque counts, as with rolling.
    pub spinning_resistance: f32,
    /// Rule for friction.
    pub friction_combine: Combine,
    /// Rule for restitution.
    pub restitution_combine: Combine,
}

impl Material {
    /// Checks every field.
    ///
    /// # Errors
    /// The first field that is out of range.
    pub fn validate(&self) -> Result<(), DefError> {
        within("friction", self.friction, &limits::FRICTION)?;
        if let Some(kinetic) = self.kinetic_friction {
            within("kinetic_friction", kinetic, &limits::FRICTION)?;
        }
        within("rolling_resistance", self.rolling_resistance, &limits::RESISTANCE)?;
        within("spinning_resistance", self.spinning_resistance, &limits::RESISTANCE)?;
        within("restitution", self.restitution, &limits::RESTITUTION)
    }
}

impl Default for Material {
    fn default() -> Self {
        Self {
            friction: 0.6,
            kinetic_friction: None,
            restitution: 0.0,
            rolling_resistance: 0.0,
            spinning_resistance: 0.0,
            friction_combine: Combine::GeometricMean,
            restitution_combine: Combine::Maximum,
        }
    }
}

/// Who collides with whom: two shapes collide if each lets the other through its filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Filter {
    /// The layers this shape is in, one bit each; default layer 0.
    pub layers: u64,
    /// It collides only with shapes in one of these layers; all ones (the default): with any shape,
    /// also one in no layer.
    pub mask: u64,
    /// It never collides with shapes in one of these layers; default none.
    pub exclude: u64,
}

impl Default for Filter {
    fn default() -> Self {
        Self { layers: 1, mask: u64::MAX, exclude: 0 }
    }
}

impl Filter {
    /// In these layers, colliding only with shapes in the layers of `mask`.
    #[must_use]
    pub const fn layers(layers: u64, mask: u64) -> Self {
        Self { layers, mask, exclude: 0 }
    }

    const fn admits(self, other: Self) -> bool {
        (self.mask == u64::MAX || self.mask & other.layers != 0) && self.exclude & other.layers == 0
    }

    /// True if shapes with these two filters collide.
    #[must_use]
    pub const fn collides_with(self, other: Self) -> bool {
        self.admits(other) && other.admits(self)
    }
}

/// What surfaces of shapes in some layers do to each other, in place of what their materials make together. Of several rules
/// the first one counts that is of a pair's layers. See [`World::set_surface_rules`](crate::World::set_surface_rules).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct SurfaceRule {
    /// Layers of one shape, a bit each: it is in one of them.
    pub first: u64,
    /// Layers of the other one; which of a pair is which does not matter.
    pub second: u64,
    /// Coulomb friction coefficient, at least 0; `None`: that of the materials.
    pub friction: Option<f32>,
    /// That of what slides; `None`: the same part of the friction as the materials say. At most the friction counts.
    pub kinetic_friction: Option<f32>,
    /// Coefficient of restitution, 0 to 1; `None`: that of the materials.
    pub restitution: Option<f32>,
}

impl SurfaceRule {
    /// A rule that changes nothing yet, for shapes in these layers.
    #[must_use]
    pub const fn between(first: u64, second: u64) -> Self {
        Self { first, second, friction: None, kinetic_friction: None, restitution: None }
    }

    /// # Errors
    /// A coefficient is out of range.
    pub fn validate(&self) -> Result<(), DefError> {
        let check = |name, value: Option<f32>, limit| {
            value.map_or(Ok(()), |value| within(name, value, limit))
        };
        check("friction", self.friction, &limits::FRICTION)?;
        check("kinetic_friction", self.kinetic_friction, &limits::FRICTION)?;
        check("restitution", self.restitution, &limits::RESTITUTION)
    }

    pub(crate) const fn is_of(&self, a: u64, b: u64) -> bool {
        self.first & a != 0 && self.second & b != 0 || self.first & b != 0 && self.second & a != 0
    }
}

#[cfg(test)]
mod tests {
    use super::{Combine, Filter};

    #[test]
    fn the_later_rule_wins_and_all_rules_are_symmetric() {
        assert!((Combine::Average.apply(Combine::Multiply, 0.5, 0.3) - 0.4).abs() < 1e-6);
        assert!((Combine::Maximum.apply(Combine::Minimum, 0.0, 0.8) - 0.0).abs() < 1e-6);
        assert!((Combine::GeometricMean.apply(Combine::Multiply, 0.5, 0.4) - 0.2).abs() < 1e-6);
        for rule in [Combine::GeometricMean, Combine::Average, Combine::Minimum, Combine::Maximum] {
            let (x, y) = (rule.apply(rule, 0.9, 0.4), rule.apply(rule, 0.4, 0.9));
            assert_eq!(x.to_bits(), y.to_bits());
        }
    }

    #[test]
    fn a_filter_needs_both_sides_to_agree() {
        let (one, two) = (Filter::layers(1, 2), Filter::layers(2, u64::MAX));
        assert!(one.collides_with(two) && !one.collides_with(one));
        let picky = Filter { exclude: 1, ..Filter::default() };
        assert!(!picky.collides_with(one) && picky.collides_with(two));
    }
}
