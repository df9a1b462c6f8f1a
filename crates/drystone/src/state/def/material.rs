//! Surface materials, the combination of two surfaces, and collision filters.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::DefError;
use super::check::within;
use crate::base::limits;

/// Rule that combines the coefficients of two surfaces. If the surfaces have different rules, the
/// one listed later here is used. The order of the last four is that of `KHR_physics_rigid_bodies`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub enum Combine {
    /// √(a b): the default for friction.
    #[default]
    GeometricMean,
    /// a b.
    Multiply,
    /// The maximum: the default for restitution.
    Maximum,
    /// The minimum.
    Minimum,
    /// (a + b) / 2.
    Average,
}

impl Combine {
    /// The coefficient of a pair whose surfaces have the rules `self` and `other`.
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
///
/// The manual: [materials](crate::manual::materials).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Material {
    /// Coulomb friction coefficient, at least 0; default 0.6. It is the static coefficient, and
    /// also the kinetic one unless [`kinetic_friction`](Self::kinetic_friction) is given.
    pub friction: f32,
    /// Kinetic friction coefficient, at least 0; default `None`: the same as
    /// [`friction`](Self::friction). It is combined by the same rule. If the kinetic friction of a
    /// pair exceeds its static friction, the static one is used.
    pub kinetic_friction: Option<f32>,
    /// Coefficient of restitution, 0 to 1; default 0.
    pub restitution: f32,
    /// Rolling resistance: the maximum torque against rolling, as a fraction of normal force times
    /// the shape's radius; at least 0; default 0. Only spheres, capsules, cylinders and cones have
    /// a radius. It acts against any relative rotation, including rotation about the normal. The
    /// larger torque of two surfaces is used.
    pub rolling_resistance: f32,
    /// Spinning resistance: the maximum torque about the contact normal, as a fraction of normal
    /// force times the shape's radius; at least 0; default 0. It applies to shapes that can have
    /// rolling resistance, in addition to that and to the friction torque of a flat contact.
    /// Without friction there is no spinning resistance. The larger torque of two surfaces is used.
    pub spinning_resistance: f32,
    /// Combination rule for friction.
    pub friction_combine: Combine,
    /// Combination rule for restitution.
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

/// Collision filter: two shapes collide if each passes the filter of the other.
///
/// The manual: [shapes](crate::manual::shapes).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Filter {
    /// The layers of this shape, one bit each; default layer 0.
    pub layers: u64,
    /// It collides only with shapes in one of these layers; default all ones: any shape, including
    /// one in no layer.
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
    /// A filter for a shape in `layers` that collides only with shapes in the layers of `mask`.
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

/// Compliance of a contact, as a damped spring at each of its points: rubber, foam, a mattress.
///
/// The stiffness follows from the frequency: `k = m (2πf)²` with the effective mass m of the point.
/// A ball on a soft surface therefore sinks in by `g / (2πf)²`, whatever its mass: 62 mm at 2 Hz. A
/// body that falls on it is thrown back, damped by the damping ratio and by the method. Bodies that
/// overlap at the start are thrown back too: the push speed of the world's contacts does not limit
/// them. The methods `soft-step` and `soft-step-relax` support it. With the classic methods, and
/// for particles, all contacts are rigid.
///
/// ```
/// use drystone::contact::ContactSoftness;
///
/// let mattress = ContactSoftness { hertz: 2.0, damping_ratio: 0.3 };
/// assert!(mattress.validate().is_ok());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct ContactSoftness {
    /// Stiffness as a frequency [Hz], 1e-6 to 1e6; the same against static bodies. The maximum in
    /// effect is a quarter of the substep rate: 120 Hz at 60 steps of 8 substeps per second.
    pub hertz: f32,
    /// Damping ratio, 0 to 1e6; from 1 on nothing oscillates.
    pub damping_ratio: f32,
}

impl ContactSoftness {
    /// # Errors
    /// A number is out of range.
    pub fn validate(&self) -> Result<(), DefError> {
        within("softness.hertz", self.hertz, &limits::SPRING_FREQUENCY)?;
        within("softness.damping_ratio", self.damping_ratio, &limits::DAMPING_RATIO)
    }
}

/// Surface properties between shapes in some layers, which override those from their materials. The
/// first rule that matches the layers of a pair is used: see
/// [`World::set_surface_rules`](crate::World::set_surface_rules). A rule for two bodies takes
/// precedence: see [`World::set_surface_between`](crate::World::set_surface_between).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct SurfaceRule {
    /// Layers of one shape, one bit each; it must be in one of them. All ones: any shape, including
    /// one in no layer.
    pub first: u64,
    /// Layers of the other shape. The order of the two shapes does not matter.
    pub second: u64,
    /// Coulomb friction coefficient, at least 0; `None`: from the materials.
    pub friction: Option<f32>,
    /// Kinetic friction coefficient; `None`: the same ratio to static friction as from the
    /// materials. It is limited to the static friction.
    pub kinetic_friction: Option<f32>,
    /// Coefficient of restitution, 0 to 1; `None`: from the materials.
    pub restitution: Option<f32>,
    /// Softness of their contacts; `None`: from [`ContactConfig`](crate::config::ContactConfig).
    pub softness: Option<ContactSoftness>,
}

impl SurfaceRule {
    /// An empty rule for shapes in any layers.
    pub const ANY: Self = Self::between(u64::MAX, u64::MAX);

    /// An empty rule for shapes in these layers.
    #[must_use]
    pub const fn between(first: u64, second: u64) -> Self {
        Self {
            first,
            second,
            friction: None,
            kinetic_friction: None,
            restitution: None,
            softness: None,
        }
    }

    /// # Errors
    /// A coefficient is out of range.
    pub fn validate(&self) -> Result<(), DefError> {
        let check = |name, value: Option<f32>, limit| {
            value.map_or(Ok(()), |value| within(name, value, limit))
        };
        check("friction", self.friction, &limits::FRICTION)?;
        check("kinetic_friction", self.kinetic_friction, &limits::FRICTION)?;
        check("restitution", self.restitution, &limits::RESTITUTION)?;
        self.softness.as_ref().map_or(Ok(()), ContactSoftness::validate)
    }

    pub(crate) const fn is_of(&self, a: u64, b: u64) -> bool {
        const fn holds(layers: u64, of: u64) -> bool {
            layers == u64::MAX || layers & of != 0
        }
        holds(self.first, a) && holds(self.second, b)
            || holds(self.first, b) && holds(self.second, a)
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
