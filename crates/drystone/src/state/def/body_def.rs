//! The definition of a body.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::check::{at_least_zero, position, unit, velocity, within};
use super::error::DefError;
use super::shape_def::{ShapeDef, shape_suits};
use crate::base::limits;
use crate::base::math::Vec3;
use crate::base::quat::Quat;
use crate::base::sym3::Sym3;
use crate::geometry::shape::Shape;
use crate::state::fracture::Fracture;
use crate::state::glue::Glue;

/// The cause of a body's motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub enum BodyKind {
    /// It never moves.
    Static,
    /// It moves at its velocity, which only the user changes. It pushes other bodies and is never
    /// pushed.
    Kinematic,
    /// Forces, contacts and joints move it.
    #[default]
    Dynamic,
}

/// The source of a dynamic body's mass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub enum MassDef {
    /// Its shapes and their densities.
    #[default]
    FromShapes,
    /// This mass [kg, above 0]; center and inertia in proportion to the shapes.
    Mass(f32),
    /// An exact mass, center and inertia, independent of the shapes.
    Exact {
        /// Mass [kg]; above 0.
        mass: f32,
        /// Center of mass [m, body].
        center: Vec3,
        /// Inertia about the center of mass [kg m², body axes]; positive, or 0 along a principal
        /// axis to lock rotation about it.
        inertia: Sym3,
    },
}

impl MassDef {
    /// Checks every number.
    pub(crate) fn validate(&self) -> Result<(), DefError> {
        match *self {
            Self::FromShapes => Ok(()),
            Self::Mass(mass) => within("mass", mass, &limits::MASS),
            Self::Exact { mass, center, inertia } => {
                within("mass", mass, &limits::MASS)?;
                position("center", center)?;
                let (d, _) = inertia.eigen();
                let tolerance = -1.0e-5 * d.max_element();
                if inertia.is_finite() && d.min_element() >= tolerance && d.max_element() >= 0.0 {
                    return Ok(());
                }
                let value = format!("{inertia:?}");
                Err(DefError::new("inertia", value, "a positive semidefinite matrix"))
            }
        }
    }
}

/// Axes along or about which a body cannot move [world].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct AxisLocks {
    /// Locked translations along x, y, z.
    pub linear: [bool; 3],
    /// Locked rotations about x, y, z.
    pub angular: [bool; 3],
}

impl AxisLocks {
    /// No locks.
    pub const NONE: Self = Self { linear: [false; 3], angular: [false; 3] };
    /// All rotations locked.
    pub const ROTATION: Self = Self { linear: [false; 3], angular: [true; 3] };
    /// Motion in the xy plane only.
    pub const PLANE_XY: Self = Self { linear: [false, false, true], angular: [true, true, false] };

    /// True if any axis is locked.
    #[must_use]
    pub fn any(self) -> bool {
        self != Self::NONE
    }
}

/// The definition of a body with its shapes.
///
/// The manual: [bodies](crate::manual::bodies).
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct BodyDef {
    /// Kind; default dynamic.
    pub kind: BodyKind,
    /// Position of its origin [m, world]; default 0.
    pub position: Vec3,
    /// Rotation, unit; default identity.
    pub rotation: Quat,
    /// Velocity of the center of mass [m/s, world].
    pub linear_velocity: Vec3,
    /// Angular velocity [rad/s, world].
    pub angular_velocity: Vec3,
    /// Mass, center and inertia (dynamic bodies); default from the shapes.
    pub mass: MassDef,
    /// Factor by which gravity acts on it, -1000 to 1000; default 1.
    pub gravity_scale: f32,
    /// Rate at which the linear velocity decays [1/s]; at least 0; default 0.
    pub linear_damping: f32,
    /// Rate at which the angular velocity decays [1/s]; at least 0; default 0.
    pub angular_damping: f32,
    /// Axes along or about which it cannot move; default none.
    pub locks: AxisLocks,
    /// Whether it may fall asleep; default true.
    pub can_sleep: bool,
    /// Speed below which it is slow [m/s], at least 0; default `None`: the world's `sleep.speed`.
    /// For the other conditions of sleep see [`crate::config::SleepConfig`].
    pub sleep_speed: Option<f32>,
    /// Whether it sleeps from the start; default false.
    pub asleep: bool,
    /// Whether it is in the world from the start; default true. See
    /// [`BodyMut::set_enabled`](crate::BodyMut::set_enabled).
    pub enabled: bool,
    /// Its shapes; several make a compound.
    pub shapes: Vec<ShapeDef>,
    /// Bonds between its shapes, which break under stress (dynamic bodies without an exact mass);
    /// default `None`: the shapes never come apart.
    pub glue: Option<Glue>,
    /// Fracture into pieces when hit (dynamic bodies of one box or hull without an exact mass);
    /// default `None`: never.
    pub fracture: Option<Fracture>,
    /// A number for the user.
    pub user_data: u64,
}

impl Default for BodyDef {
    fn default() -> Self {
        Self {
            kind: BodyKind::Dynamic,
            position: Vec3::ZERO,
            rotation: Quat::IDENTITY,
            linear_velocity: Vec3::ZERO,
            angular_velocity: Vec3::ZERO,
            mass: MassDef::FromShapes,
            gravity_scale: 1.0,
            linear_damping: 0.0,
            angular_damping: 0.0,
            locks: AxisLocks::NONE,
            can_sleep: true,
            sleep_speed: None,
            asleep: false,
            enabled: true,
            shapes: Vec::new(),
            glue: None,
            fracture: None,
            user_data: 0,
        }
    }
}

impl BodyDef {
    /// A dynamic body.
    #[must_use]
    pub fn dynamic() -> Self {
        Self::default()
    }

    /// A body that never moves: [`BodyKind::Static`].
    #[must_use]
    pub fn fixed() -> Self {
        Self { kind: BodyKind::Static, ..Self::default() }
    }

    /// A body moved only by its velocity: [`BodyKind::Kinematic`].
    #[must_use]
    pub fn kinematic() -> Self {
        Self { kind: BodyKind::Kinematic, ..Self::default() }
    }

    /// At this position [m, world].
    #[must_use]
    pub fn with_position(self, position: impl Into<Vec3>) -> Self {
        Self { position: position.into(), ..self }
    }

    /// With this rotation; normalized if it is close to unit length.
    #[must_use]
    pub fn with_rotation(self, rotation: impl Into<Quat>) -> Self {
        Self { rotation: rotation.into(), ..self }
    }

    /// With this velocity [m/s, world].
    #[must_use]
    pub fn with_linear_velocity(self, velocity: impl Into<Vec3>) -> Self {
        Self { linear_velocity: velocity.into(), ..self }
    }

    /// With this angular velocity [rad/s, world].
    #[must_use]
    pub fn with_angular_velocity(self, velocity: impl Into<Vec3>) -> Self {
        Self { angular_velocity: velocity.into(), ..self }
    }

    /// With one more shape.
    #[must_use]
    pub fn with_shape(mut self, shape: ShapeDef) -> Self {
        self.shapes.push(shape);
        self
    }

    /// With more shapes.
    #[must_use]
    pub fn with_shapes(mut self, shapes: impl IntoIterator<Item = ShapeDef>) -> Self {
        self.shapes.extend(shapes);
        self
    }

    /// With this mass [kg] in place of the mass from densities.
    #[must_use]
    pub fn with_mass(self, mass: f32) -> Self {
        Self { mass: MassDef::Mass(mass), ..self }
    }

    /// With this mass [kg], center of mass [m, body] and inertia about it [kg m², body axes].
    #[must_use]
    pub fn with_mass_properties(self, mass: f32, center: impl Into<Vec3>, inertia: Sym3) -> Self {
        let center = center.into();
        Self { mass: MassDef::Exact { mass, center, inertia }, ..self }
    }

    /// With this gravity factor: 0 floats, 1 falls.
    #[must_use]
    pub fn with_gravity_scale(self, scale: f32) -> Self {
        Self { gravity_scale: scale, ..self }
    }

    /// With these decay rates of linear and angular velocity [1/s].
    #[must_use]
    pub fn with_damping(self, linear: f32, angular: f32) -> Self {
        Self { linear_damping: linear, angular_damping: angular, ..self }
    }

    /// With these locked axes.
    #[must_use]
    pub fn with_locks(self, locks: AxisLocks) -> Self {
        Self { locks, ..self }
    }

    /// With this sleep speed [m/s] in place of the world's.
    #[must_use]
    pub fn with_sleep_speed(self, speed: f32) -> Self {
        Self { sleep_speed: Some(speed), ..self }
    }

    /// Never falling asleep.
    #[must_use]
    pub fn never_asleep(self) -> Self {
        Self { can_sleep: false, ..self }
    }

    /// Asleep from the start.
    #[must_use]
    pub fn starts_asleep(self) -> Self {
        Self { asleep: true, ..self }
    }

    /// Out of the world until [`BodyMut::set_enabled`](crate::BodyMut::set_enabled) enables it.
    #[must_use]
    pub fn starts_disabled(self) -> Self {
        Self { enabled: false, ..self }
    }

    /// With this number for the user.
    #[must_use]
    pub fn with_user_data(self, user_data: u64) -> Self {
        Self { user_data, ..self }
    }

    /// With these bonds between its shapes.
    #[must_use]
    pub fn with_glue(self, glue: Glue) -> Self {
        Self { glue: Some(glue), ..self }
    }

    /// With these fracture settings for hits.
    #[must_use]
    pub fn with_fracture(self, fracture: Fracture) -> Self {
        Self { fracture: Some(fracture), ..self }
    }

    /// Checks every field, including those of the shapes.
    ///
    /// # Errors
    /// The first field that is out of range.
    pub fn validate(&self) -> Result<(), DefError> {
        position("position", self.position)?;
        unit("rotation", self.rotation)?;
        velocity("linear_velocity", self.linear_velocity)?;
        velocity("angular_velocity", self.angular_velocity)?;
        within("gravity_scale", self.gravity_scale, &limits::GRAVITY_SCALE)?;
        within("linear_damping", self.linear_damping, &limits::DAMPING)?;
        within("angular_damping", self.angular_damping, &limits::DAMPING)?;
        if let Some(speed) = self.sleep_speed {
            at_least_zero("sleep_speed", speed)?;
        }
        self.mass.validate()?;
        for (i, shape) in self.shapes.iter().enumerate() {
            let outer = format!("shapes[{i}]");
            shape.validate().map_err(|e| e.within(&outer))?;
            shape_suits(self.kind, &shape.shape).map_err(|e| e.within(&outer))?;
        }
        if let Some(glue) = &self.glue {
            glue.validate(&self.shapes).map_err(|e| e.within("glue"))?;
            self.can_break().map_err(|e| e.within("glue"))?;
        }
        if let Some(fracture) = &self.fracture {
            fracture.validate().map_err(|e| e.within("fracture"))?;
            self.can_break().map_err(|e| e.within("fracture"))?;
            let mut solid = self.shapes.iter().filter(|s| !s.sensor);
            let fits = matches!(
                (solid.next().map(|s| &s.shape), solid.next()),
                (Some(Shape::Box { .. } | Shape::Hull(_)), None)
            );
            if self.glue.is_some() || !fits {
                let allowed = "given to a body of one box or hull without glue";
                let shapes = format!("{} shapes", self.shapes.len());
                return Err(DefError::unsuitable("fracture", shapes, allowed));
            }
        }
        Ok(())
    }

    /// Checks that it may break: only a dynamic body has a mass, and the mass must be distributed
    /// over its shapes.
    fn can_break(&self) -> Result<(), DefError> {
        if self.kind != BodyKind::Dynamic {
            return Err(DefError::unsuitable("body", format!("{:?}", self.kind), "a dynamic body"));
        }
        if let MassDef::Exact { .. } = self.mass {
            let allowed = "computed from the shapes, or their total";
            return Err(DefError::unsuitable("mass", "an exact mass", allowed));
        }
        if let Some(i) = self.shapes.iter().position(|s| !s.sensor && !(s.density > 0.0)) {
            let value = format!("0 of shape {i}");
            return Err(DefError::unsuitable(
                "density",
                value,
                "above 0, because each piece has a mass",
            ));
        }
        Ok(())
    }
}
