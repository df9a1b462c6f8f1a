//! Definitions: what a user says of a body, a shape or a joint, and how it is checked.

use core::fmt::{self, Display};

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

pub(crate) use super::check::{
    all_within, at_least_zero, finite_vec, position, unit, velocity, within,
};
pub use super::fracture::Fracture;
pub use super::glue::{Bond, BondStrength, Glue};
pub use super::joint_def::{
    Fatigue, JointDef, JointKind, JointStrength, Pulley, Spring, WorldAxes,
};
use super::material::{Filter, Material};
use super::reports::{ContactReports, Senses};
use crate::base::limits;
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::base::quat::Quat;
use crate::base::sym3::Sym3;
use crate::geometry::shape::{Shape, ShapeError};

/// A definition was refused: the field, its value, and what is allowed. Nothing was changed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DefError {
    field: String,
    value: String,
    allowed: String,
}

impl DefError {
    pub(crate) fn new(field: &str, value: impl Display, allowed: &str) -> Self {
        Self { field: field.to_owned(), value: value.to_string(), allowed: allowed.to_owned() }
    }

    /// The same of a vector.
    pub(crate) fn of_vec(field: &str, value: Vec3, allowed: &str) -> Self {
        Self::new(field, format_args!("({}, {}, {})", value.x, value.y, value.z), allowed)
    }

    /// The same error of a field inside `outer`.
    pub(crate) fn within(mut self, outer: &str) -> Self {
        self.field = format!("{outer}.{}", self.field);
        self
    }

    /// Path of the field, such as `shapes[0].radius`.
    #[must_use]
    pub fn field(&self) -> &str {
        &self.field
    }

    /// The value that was given.
    #[must_use]
    pub fn value(&self) -> &str {
        &self.value
    }

    /// What would have been right.
    #[must_use]
    pub fn allowed(&self) -> &str {
        &self.allowed
    }
}

impl Display for DefError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} is {}, allowed is {}", self.field, self.value, self.allowed)
    }
}

impl core::error::Error for DefError {}

impl From<ShapeError> for DefError {
    fn from(e: ShapeError) -> Self {
        Self::new(e.field, e.value, e.allowed)
    }
}

/// What moves a body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub enum BodyKind {
    /// Nothing: it stays where it is put.
    Static,
    /// Its velocity, which only the user changes: it pushes others and is never pushed.
    Kinematic,
    /// Forces, contacts and joints.
    #[default]
    Dynamic,
}

/// Where a dynamic body's mass comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub enum MassDef {
    /// Its shapes and their densities.
    #[default]
    FromShapes,
    /// This mass [kg, above 0]; center and inertia in proportion to the shapes.
    Mass(f32),
    /// Given in full.
    Exact {
        /// Mass [kg]; above 0.
        mass: f32,
        /// Center of mass [m, body].
        center: Vec3,
        /// Inertia about the center of mass [kg m², body axes]; positive, or 0 along a principal axis
        /// to lock rotation about it.
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
    /// No translation along x, y, z.
    pub linear: [bool; 3],
    /// No rotation about x, y, z.
    pub angular: [bool; 3],
}

impl AxisLocks {
    /// Nothing locked.
    pub const NONE: Self = Self { linear: [false; 3], angular: [false; 3] };
    /// No rotation at all.
    pub const ROTATION: Self = Self { linear: [false; 3], angular: [true; 3] };
    /// Motion in the xy plane only.
    pub const PLANE_XY: Self = Self { linear: [false, false, true], angular: [true, true, false] };

    /// True if something is locked.
    #[must_use]
    pub fn any(self) -> bool {
        self != Self::NONE
    }
}

/// A shape of a body.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct ShapeDef {
    /// The shape.
    pub shape: Shape,
    /// Where it sits [body].
    pub pose: Pose,
    /// Density [kg/m³]; at least 0 (0: no mass); default 1000.
    pub density: f32,
    /// Its surface.
    pub material: Material,
    /// What it collides with.
    pub filter: Filter,
    /// A sensor reports what overlaps it and touches nothing; it has no mass. Default false. It sees the shapes of all
    /// bodies but its own, whether they move, rest or sleep, however it or they came there. It sees sensors, and on a static
    /// body static shapes, only if [`Self::senses`] says so.
    pub sensor: bool,
    /// What it sees besides, as a sensor.
    pub senses: Senses,
    /// How its surface moves over it, as a conveyor belt does: what lies on it is dragged along by
    /// friction, up to this velocity relative to the body [m/s, frame of the shape]. Only the part along
    /// the surface acts. Default 0.
    pub surface_velocity: Vec3,
    /// Angular velocity of the surface about the shape's origin, for belts that turn
    /// [rad/s, frame of the shape]; adds to `surface_velocity`; default 0.
    pub surface_spin: Vec3,
    /// It holds only what comes from the front, which is in this direction [frame of the shape, any length]: others pass until
    /// they are out of it. `None`, the default: it holds from all sides.
    pub one_way: Option<Vec3>,
    /// [`ContactHooks`](crate::contact::ContactHooks) are asked for its contacts; default false.
    pub hooks: bool,
    /// Which events its contacts give.
    pub reports: ContactReports,
    /// Any number of the user's.
    pub user_data: u64,
}

impl ShapeDef {
    /// A shape at the body's origin with default material.
    #[must_use]
    pub fn new(shape: Shape) -> Self {
        Self {
            shape,
            pose: Pose::IDENTITY,
            density: 1000.0,
            material: Material::default(),
            filter: Filter::default(),
            sensor: false,
            senses: Senses::default(),
            surface_velocity: Vec3::ZERO,
            surface_spin: Vec3::ZERO,
            one_way: None,
            hooks: false,
            reports: ContactReports::default(),
            user_data: 0,
        }
    }

    /// A ball of this radius [m].
    #[must_use]
    pub fn sphere(radius: f32) -> Self {
        Self::new(Shape::sphere(radius))
    }

    /// A capsule along y: half the distance of the ball centers [m], and radius [m].
    #[must_use]
    pub fn capsule(half_height: f32, radius: f32) -> Self {
        Self::new(Shape::capsule(half_height, radius))
    }

    /// A box of these half extents [m].
    #[must_use]
    pub fn box_half(half_extents: impl Into<Vec3>) -> Self {
        Self::new(Shape::box_half(half_extents))
    }

    /// A box of these edge lengths [m].
    #[must_use]
    pub fn box_full(extents: impl Into<Vec3>) -> Self {
        Self::new(Shape::box_full(extents))
    }

    /// A cylinder along y of this half height and radius [m].
    #[must_use]
    pub fn cylinder(half_height: f32, radius: f32) -> Self {
        Self::new(Shape::cylinder(half_height, radius))
    }

    /// A cone along y of this half height and base radius [m], tip up, origin at half height.
    #[must_use]
    pub fn cone(half_height: f32, radius: f32) -> Self {
        Self::new(Shape::cone(half_height, radius))
    }

    /// The half space below the plane `normal · p = offset` [m].
    #[must_use]
    pub fn half_space(normal: impl Into<Vec3>, offset: f32) -> Self {
        Self::new(Shape::half_space(normal, offset))
    }

    /// At this pose in the body's frame.
    #[must_use]
    pub fn with_pose(self, pose: Pose) -> Self {
        Self { pose, ..self }
    }

    /// At this position in the body's frame [m].
    #[must_use]
    pub fn with_position(mut self, position: impl Into<Vec3>) -> Self {
        self.pose.position = position.into();
        self
    }

    /// With this density [kg/m³].
    #[must_use]
    pub fn with_density(self, density: f32) -> Self {
        Self { density, ..self }
    }

    /// With this surface.
    #[must_use]
    pub fn with_material(self, material: Material) -> Self {
        Self { material, ..self }
    }

    /// With this friction coefficient.
    #[must_use]
    pub fn with_friction(mut self, friction: f32) -> Self {
        self.material.friction = friction;
        self
    }

    /// With this coefficient of restitution.
    #[must_use]
    pub fn with_restitution(mut self, restitution: f32) -> Self {
        self.material.restitution = restitution;
        self
    }

    /// With a surface that moves at this velocity over the shape [m/s, frame of the shape].
    #[must_use]
    pub fn with_surface_velocity(self, velocity: impl Into<Vec3>) -> Self {
        Self { surface_velocity: velocity.into(), ..self }
    }

    /// With a surface that turns over the shape, about its origin [rad/s, frame of the shape].
    #[must_use]
    pub fn with_surface_spin(self, spin: impl Into<Vec3>) -> Self {
        Self { surface_spin: spin.into(), ..self }
    }

    /// With this filter.
    #[must_use]
    pub fn with_filter(self, filter: Filter) -> Self {
        Self { filter, ..self }
    }

    /// Holding only what comes from the front, which is in this direction [frame of the shape, any length]. A platform that can
    /// be jumped on from below has its front above:
    ///
    /// ```
    /// use drystone::{ShapeDef, Vec3};
    ///
    /// let platform = ShapeDef::box_half([2.0, 0.1, 1.0]).with_one_way(Vec3::Y);
    /// # let _ = platform;
    /// ```
    #[must_use]
    pub fn with_one_way(self, front: impl Into<Vec3>) -> Self {
        Self { one_way: Some(front.into()), ..self }
    }

    /// With contacts that [`ContactHooks`](crate::contact::ContactHooks) are asked for.
    #[must_use]
    pub fn with_hooks(self) -> Self {
        Self { hooks: true, ..self }
    }

    /// With these senses, as a sensor.
    #[must_use]
    pub fn with_senses(self, senses: Senses) -> Self {
        Self { senses, ..self }
    }

    /// With these events of its contacts.
    #[must_use]
    pub fn with_reports(self, reports: ContactReports) -> Self {
        Self { reports, ..self }
    }

    /// As a sensor.
    #[must_use]
    pub fn as_sensor(self) -> Self {
        Self { sensor: true, ..self }
    }

    /// Checks every field.
    ///
    /// # Errors
    /// The first field that is out of range.
    pub fn validate(&self) -> Result<(), DefError> {
        check_shape(&self.shape)?;
        position("pose.position", self.pose.position)?;
        unit("pose.rotation", self.pose.rotation)?;
        within("density", self.density, &limits::DENSITY)?;
        velocity("surface_velocity", self.surface_velocity)?;
        velocity("surface_spin", self.surface_spin)?;
        if let Some(front) = self.one_way {
            check_front(front)?;
        }
        self.reports.validate()?;
        self.material.validate().map_err(|e| e.within("material"))
    }
}

/// A direction of a front, of any length but none.
pub(crate) fn check_front(front: Vec3) -> Result<Vec3, DefError> {
    finite_vec("one_way", front)?;
    let unit = front.try_normalize();
    unit.ok_or_else(|| DefError::of_vec("one_way", front, "a direction of some length"))
}

/// A body, with its shapes.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct BodyDef {
    /// What moves it.
    pub kind: BodyKind,
    /// Where its origin is [m, world].
    pub position: Vec3,
    /// How it is turned; unit.
    pub rotation: Quat,
    /// Velocity of the center of mass [m/s, world].
    pub linear_velocity: Vec3,
    /// Angular velocity [rad/s, world].
    pub angular_velocity: Vec3,
    /// Mass, center and inertia (dynamic bodies).
    pub mass: MassDef,
    /// Gravity counts this many times; default 1.
    pub gravity_scale: f32,
    /// Linear velocity decays at this rate [1/s]; at least 0; default 0.
    pub linear_damping: f32,
    /// Angular velocity decays at this rate [1/s]; at least 0; default 0.
    pub angular_damping: f32,
    /// Axes it cannot move along or about.
    pub locks: AxisLocks,
    /// Whether it may fall asleep; default true.
    pub can_sleep: bool,
    /// Speed below which it is slow [m/s], if not the world's `sleep.speed`; at least 0. Whether it may sleep then is
    /// said by [`crate::config::SleepConfig`].
    pub sleep_speed: Option<f32>,
    /// Whether it sleeps from the start; default false.
    pub asleep: bool,
    /// Its shapes; several make a compound.
    pub shapes: Vec<ShapeDef>,
    /// Bonds between its shapes, which come apart under stress (dynamic bodies whose mass is not given in full);
    /// default `None`: shapes never come apart.
    pub glue: Option<Glue>,
    /// Breaks into pieces where it is hit (dynamic bodies of one box or hull whose mass is not given in full);
    /// default `None`: never.
    pub fracture: Option<Fracture>,
    /// Any number of the user's.
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
            shapes: Vec::new(),
            glue: None,
            fracture: None,
            user_data: 0,
        }
    }
}

impl BodyDef {
    /// A body moved by forces.
    #[must_use]
    pub fn dynamic() -> Self {
        Self::default()
    }

    /// A body that never moves.
    #[must_use]
    pub fn fixed() -> Self {
        Self { kind: BodyKind::Static, ..Self::default() }
    }

    /// A body moved by its velocity alone.
    #[must_use]
    pub fn kinematic() -> Self {
        Self { kind: BodyKind::Kinematic, ..Self::default() }
    }

    /// At this position [m, world].
    #[must_use]
    pub fn with_position(self, position: impl Into<Vec3>) -> Self {
        Self { position: position.into(), ..self }
    }

    /// Turned so; normalized if it is close to unit length.
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

    /// With this mass [kg] in place of that from densities.
    #[must_use]
    pub fn with_mass(self, mass: f32) -> Self {
        Self { mass: MassDef::Mass(mass), ..self }
    }

    /// With these bonds between its shapes.
    #[must_use]
    pub fn with_glue(self, glue: Glue) -> Self {
        Self { glue: Some(glue), ..self }
    }

    /// Breaks so where it is hit.
    #[must_use]
    pub fn with_fracture(self, fracture: Fracture) -> Self {
        Self { fracture: Some(fracture), ..self }
    }

    /// Checks every field, those of the shapes too.
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
                let allowed = "a body of one box or hull and no glue";
                let shapes = format!("{} shapes", self.shapes.len());
                return Err(DefError::new("fracture", shapes, allowed));
            }
        }
        Ok(())
    }

    /// Only what has mass can come apart, and how it is spread must be known.
    fn can_break(&self) -> Result<(), DefError> {
        if self.kind != BodyKind::Dynamic {
            return Err(DefError::new("body", format!("{:?}", self.kind), "a dynamic body"));
        }
        if let MassDef::Exact { .. } = self.mass {
            let allowed = "a mass from shapes, or their total";
            return Err(DefError::new("mass", "given in full", allowed));
        }
        if let Some(i) = self.shapes.iter().position(|s| !s.sensor && !(s.density > 0.0)) {
            let value = format!("0 of shape {i}");
            return Err(DefError::new("density", value, "above 0: each piece has a mass"));
        }
        Ok(())
    }
}

/// Checks a shape that a body is to have.
pub(crate) fn check_shape(shape: &Shape) -> Result<(), DefError> {
    shape.validate()?;
    match shape {
        Shape::HalfSpace { normal, .. } if *normal == Vec3::ZERO => {
            Err(DefError::new("normal", "zero", "a direction"))
        }
        _ => Ok(()),
    }
}

/// Refuses shapes that cannot be carried by a body of this kind.
pub(crate) fn shape_suits(kind: BodyKind, shape: &Shape) -> Result<(), DefError> {
    match (kind, shape) {
        (BodyKind::Static, _) | (BodyKind::Kinematic, Shape::Mesh(_)) => Ok(()),
        (_, Shape::HalfSpace { .. }) => {
            Err(DefError::new("shape", "half-space", "a half-space on a static body"))
        }
        (_, Shape::Mesh(_)) => Err(DefError::new(
            "shape",
            "mesh",
            "a mesh on a static or kinematic body; decompose it into hulls for a dynamic one",
        )),
        _ => Ok(()),
    }
}
