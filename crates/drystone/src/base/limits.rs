//! The allowed ranges of all numbers from the user: one table, used by every check and shown in
//! `manual/units_and_limits.md`.
//!
//! The bounds keep the engine's products of such numbers normal numbers of f32: masses times
//! squared speeds, moments of inertia and their inverses.

/// The range of one kind of number.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Limit {
    /// The quantity that it limits.
    pub quantity: &'static str,
    /// Unit of the quantity.
    pub unit: &'static str,
    /// Minimum value; for signed numbers, the negative of the maximum.
    pub minimum: f32,
    /// Maximum value.
    pub maximum: f32,
    /// Whether 0 is allowed too, below the minimum.
    pub zero: bool,
    /// The range in words, for error messages.
    pub allowed: &'static str,
}

impl Limit {
    const fn range(
        quantity: &'static str,
        unit: &'static str,
        [minimum, maximum]: [f32; 2],
        allowed: &'static str,
    ) -> Self {
        Self { quantity, unit, minimum, maximum, zero: false, allowed }
    }

    const fn signed(
        quantity: &'static str,
        unit: &'static str,
        maximum: f32,
        allowed: &'static str,
    ) -> Self {
        Self::range(quantity, unit, [-maximum, maximum], allowed)
    }

    const fn or_zero(self) -> Self {
        Self { zero: true, ..self }
    }

    /// True if the value is within the range. NaN never is.
    #[must_use]
    pub fn admits(&self, value: f32) -> bool {
        (self.minimum <= value && value <= self.maximum) || (self.zero && value == 0.0)
    }
}

/// Duration of a step.
pub const TIME_STEP: Limit =
    Limit::range("time step", "s", [1.0e-6, 10.0], "a time from 1e-6 to 10 s");
/// Coordinates of positions, anchors, centers of mass, and of shapes in their body's frame.
pub const POSITION: Limit = Limit::signed("position", "m", 1.0e7, "a position within ±1e7 m");
/// Lengths of shapes and of links.
pub const LENGTH: Limit =
    Limit::range("length", "m", [1.0e-5, 1.0e7], "a length from 1e-5 to 1e7 m");
/// Displacements of rays and casts, and the reach of queries.
pub const DISPLACEMENT: Limit =
    Limit::signed("displacement of a query", "m", 1.0e9, "a displacement within ±1e9 m");
/// Rotations of shape casts, as components of a rotation vector.
pub const TURN: Limit =
    Limit::signed("rotation of a cast", "rad", 100.0, "a rotation within ±100 rad");
/// Distances that a joint keeps between its anchors, and rest lengths of its spring.
pub const DISTANCE: Limit =
    Limit::range("distance of a joint", "m", [0.0, 1.0e9], "a length from 0 to 1e9 m");
/// Components of linear and angular velocities.
pub const SPEED: Limit =
    Limit::signed("speed", "m/s, rad/s", 1.0e6, "a speed within ±1e6 m/s or rad/s");
/// Maximum speed at the end of a step; a faster body or particle leaves the simulation.
pub const SPEED_KEPT: Limit =
    Limit::signed("speed that is kept", "m/s, rad/s", 1.0e8, "a speed within ±1e8 m/s or rad/s");
/// Maximum coordinate at the end of a step; a body or particle beyond it leaves the simulation.
pub const POSITION_KEPT: Limit =
    Limit::signed("position that is kept", "m", 1.0e9, "a position within ±1e9 m");
/// Mass of a dynamic body.
pub const MASS: Limit =
    Limit::range("mass of a body", "kg", [1.0e-15, 1.0e15], "a mass from 1e-15 to 1e15 kg");
/// Principal moments of inertia of a dynamic body; 0 locks the rotation.
pub const MOMENT: Limit = Limit::range(
    "moment of inertia",
    "kg m²",
    [1.0e-30, 1.0e30],
    "0 or a moment of inertia from 1e-30 to 1e30 kg m²",
)
.or_zero();
/// Density of a shape; 0 means no mass.
pub const DENSITY: Limit =
    Limit::range("density", "kg/m³", [1.0e-9, 1.0e12], "0 or a density from 1e-9 to 1e12 kg/m³")
        .or_zero();
/// Mass of a particle.
pub const PARTICLE_MASS: Limit =
    Limit::range("mass of a particle", "kg", [1.0e-9, 1.0e9], "a mass from 1e-9 to 1e9 kg");
/// Components of gravity.
pub const GRAVITY: Limit =
    Limit::signed("gravity", "m/s²", 1.0e6, "an acceleration within ±1e6 m/s²");
/// Factor on gravity.
pub const GRAVITY_SCALE: Limit =
    Limit::signed("gravity scale", "1", 1.0e3, "a number from -1000 to 1000");
/// Acceleration of a body by forces: force over mass, torque over moment of inertia.
pub const ACCELERATION: Limit = Limit::signed(
    "acceleration by forces",
    "m/s², rad/s²",
    1.0e10,
    "a load that accelerates the body by up to 1e10 m/s² or rad/s²",
);
/// Decay rates of velocities.
pub const DAMPING: Limit = Limit::range("damping", "1/s", [0.0, 1.0e9], "a rate from 0 to 1e9 1/s");
/// Coefficients of friction, static and kinetic.
pub const FRICTION: Limit = Limit::range("friction", "1", [0.0, 1.0e6], "a number from 0 to 1e6");
/// Coefficients of restitution.
pub const RESTITUTION: Limit = Limit::range("restitution", "1", [0.0, 1.0], "a number from 0 to 1");
/// Coefficients of rolling and spinning resistance.
pub const RESISTANCE: Limit =
    Limit::range("rolling and spinning resistance", "1", [0.0, 1.0e6], "a number from 0 to 1e6");
/// Kinetic energy of a velocity that the user sets: half the mass times the squared speed. Rotation
/// has the same limit by itself.
pub const ENERGY: Limit = Limit::range(
    "kinetic energy of a body that is given",
    "J",
    [0.0, 1.0e33],
    "a velocity that gives the body up to 1e33 J",
);
/// Frequencies of springs and of softness; 0 where it means a default.
pub const FREQUENCY: Limit =
    Limit::range("frequency", "Hz", [0.0, 1.0e6], "a frequency from 0 to 1e6 Hz");
/// Damping ratios.
pub const DAMPING_RATIO: Limit =
    Limit::range("damping ratio", "1", [0.0, 1.0e6], "a number from 0 to 1e6");
/// Target coordinates and speeds of drives, and offsets of couplings.
pub const TARGET: Limit =
    Limit::signed("target of a drive", "m, rad, m/s, rad/s", 1.0e6, "a number within ±1e6");

/// Length of a typical body in the world's unit of length: see
/// [`WorldConfig::length_scale`](crate::WorldConfig::length_scale).
pub const LENGTH_SCALE: Limit =
    Limit::range("length scale", "m", [1.0e-4, 1.0e4], "a length from 1e-4 to 1e4 m");
/// Maximum speed of the push out of an overlap.
pub const PUSH_SPEED: Limit =
    Limit::range("push speed", "m/s", [1.0e-9, 1.0e6], "a speed from 1e-9 to 1e6 m/s");
/// Distances for contacts in the configuration.
pub const CONTACT_DISTANCE: Limit =
    Limit::range("rest offset, recycling distance", "m", [0.0, 1.0e3], "a length from 0 to 1000 m");
/// Search distance for contacts.
pub const MARGIN: Limit =
    Limit::range("contact margin", "m", [1.0e-6, 1.0e3], "a length from 1e-6 to 1000 m");
/// Numbers that are only compared with: speeds of rest, of a hit, of a bounce, time to sleep,
/// ratios of mass.
pub const THRESHOLD: Limit =
    Limit::range("threshold", "any", [0.0, f32::MAX], "a finite number of at least 0");
/// Such a number, above 0.
pub const THRESHOLD_ABOVE_ZERO: Limit = Limit::range(
    "threshold of load",
    "1",
    [f32::MIN_POSITIVE, f32::MAX],
    "a finite number above 0",
);
/// Maximum factor of load-adaptive inertia; 0: the method's default.
pub const INERTIA_FACTOR: Limit = Limit::range(
    "factor of load-adaptive inertia",
    "1",
    [1.0, 64.0],
    "0 (the method's own) or a number from 1 to 64",
)
.or_zero();
/// Frequency of the springs of the penalty methods, and of soft contacts.
pub const SPRING_FREQUENCY: Limit = Limit::range(
    "frequency of penalty springs and soft contacts",
    "Hz",
    [1.0e-6, 1.0e6],
    "a frequency from 1e-6 to 1e6 Hz",
);

/// All ranges, in the order of `manual/units_and_limits.md`.
pub const ALL: &[Limit] = &[
    TIME_STEP,
    POSITION,
    LENGTH,
    DISTANCE,
    DISPLACEMENT,
    TURN,
    SPEED,
    POSITION_KEPT,
    SPEED_KEPT,
    MASS,
    MOMENT,
    DENSITY,
    PARTICLE_MASS,
    GRAVITY,
    GRAVITY_SCALE,
    ACCELERATION,
    ENERGY,
    DAMPING,
    FRICTION,
    RESTITUTION,
    RESISTANCE,
    FREQUENCY,
    DAMPING_RATIO,
    TARGET,
    LENGTH_SCALE,
    PUSH_SPEED,
    CONTACT_DISTANCE,
    MARGIN,
    THRESHOLD,
    THRESHOLD_ABOVE_ZERO,
    INERTIA_FACTOR,
    SPRING_FREQUENCY,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_inside_and_what_is_no_number_is_outside() {
        for limit in ALL {
            assert!(
                limit.admits(limit.minimum) && limit.admits(limit.maximum),
                "{}",
                limit.quantity
            );
            let beyond = f32::from_bits(limit.maximum.to_bits() + 1);
            assert!(
                !limit.admits(beyond) && !limit.admits(f32::NAN) && !limit.admits(f32::INFINITY)
            );
            assert_eq!(limit.admits(0.0), limit.zero || limit.minimum <= 0.0, "{}", limit.quantity);
        }
    }

    /// Checks the promise of the module's text: products of allowed numbers are normal numbers.
    #[test]
    fn products_of_what_is_allowed_are_normal_numbers() {
        for product in [
            MASS.maximum * SPEED_KEPT.maximum * SPEED_KEPT.maximum,
            1.0 / MASS.minimum,
            1.0 / MASS.maximum,
            1.0 / MOMENT.minimum,
            1.0 / MOMENT.maximum,
            POSITION_KEPT.maximum * POSITION_KEPT.maximum * POSITION_KEPT.maximum,
            GRAVITY.maximum * GRAVITY_SCALE.maximum * TIME_STEP.maximum,
            ACCELERATION.maximum * TIME_STEP.maximum,
        ] {
            assert!(product.is_normal(), "{product}");
        }
    }
}
