//! Movement of a character shape: it slides along walls, climbs steps and stays on the ground.

mod walk;

use crate::base::id::{BodyId, ShapeId};
use crate::base::limits;
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::geometry::shape::Shape;
use crate::query::cast::ShapeHit;
use crate::query::filter::QueryFilter;
use crate::query::shape::ShapeRef;
use crate::state::def::check::{all_within, position, within};
use crate::state::def::{BodyKind, DefError};

use self::walk::Walk;
use super::World;

/// Settings for moving a character through a world. The character is a convex shape, usually a
/// capsule, and not a body. It slides along obstacles, climbs steps and walks up slopes that are
/// not too steep. It slides down steeper slopes, and stays on the ground downhill.
///
/// The defaults suit a person in meters: steps up to 0.3 m, slopes up to 45 degrees, up along y.
/// The manual: [character](crate::manual::character).
///
/// The program handles gravity, jumps and speeds: it passes the displacement of each frame. It also
/// handles other interaction with bodies:
///
/// * To ride on a lift, add `moved.ground_velocity(&world) * dt` to the resulting position. A query
///   sees the lift at its current pose, and the next step moves it.
/// * To push crates, apply an impulse to [`MoverHit::body`] at [`MoverHit::point`] against the
///   normal. Use the mass of the character times `hit.blocked / dt`, or the limit of its strength.
/// * To ride, push and be an obstacle for other characters, let a kinematic body follow with
///   [`Self::move_body`].
///
/// One-way surfaces block the character only from their front. A round bottom also walks over edges
/// lower than `radius * (1 - cos(max_slope))`, whatever `step` is.
///
/// ```
/// use drystone::{BodyDef, DefError, Pose, Shape, ShapeDef, World};
/// use drystone::mover::Mover;
/// use drystone::query::QueryFilter;
///
/// fn main() -> Result<(), DefError> {
///     let mut world = World::default();
///     world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0)))?;
///     let stair = BodyDef::fixed().with_position([1.5, 0.1, 0.0]);
///     world.add_body(stair.with_shape(ShapeDef::box_half([1.0, 0.1, 1.0])))?;
///     let mover = Mover::new(Shape::capsule(0.5, 0.3));
///     let mut pose = Pose::at([0.0, 0.81, 0.0]);
///     for _ in 0..60 {
///         let moved = mover.move_by(&world, pose, [0.02, -0.01, 0.0], QueryFilter::default())?;
///         assert!(moved.grounded);
///         pose = moved.pose;
///     }
///     assert!((pose.position.y - 1.01).abs() < 0.001, "up the stair, a skin above it");
///     Ok(())
/// }
/// ```
#[derive(Clone, Debug)]
pub struct Mover {
    shape: Shape,
    up: Vec3,
    step: f32,
    max_slope: f32,
    snap: f32,
    skin: f32,
}

/// An obstacle that a [`Mover`] met.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct MoverHit {
    /// The shape of the obstacle.
    pub shape: ShapeId,
    /// The body of the shape.
    pub body: BodyId,
    /// Contact point [m, world].
    pub point: Vec3,
    /// Outward normal of the obstacle's surface [world, unit].
    pub normal: Vec3,
    /// Depth by which the blocked displacement would have entered the surface [m], at least 0.
    /// Divided by the time of the frame, it is the speed of the impact.
    pub blocked: f32,
}

/// The outcome of a move: see [`Mover::move_by`]. [`Mover::move_into`] reuses its memory.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Moved {
    /// Pose of the shape after the move [m, world].
    pub pose: Pose,
    /// True if the shape stands on ground that is not too steep. Always false after an upward
    /// displacement.
    pub grounded: bool,
    /// The body under the shape, if it is grounded.
    pub ground: Option<BodyId>,
    /// Point where the shape stands [m, world]; 0 if it is not grounded.
    pub ground_point: Vec3,
    /// Normal of the ground [world, unit]; at an edge, that of the face behind it; 0 if it is not
    /// grounded.
    pub ground_normal: Vec3,
    /// The obstacles met, in order. The ground is included if the displacement led into it.
    pub hits: Vec<MoverHit>,
    /// Reused memory for casts.
    found: Vec<ShapeHit>,
}

impl Moved {
    /// Velocity of the ground under the mover [m/s, world]; 0 if it is not grounded, or the body no
    /// longer exists.
    #[must_use]
    pub fn ground_velocity(&self, world: &World) -> Vec3 {
        let ground = self.ground.and_then(|ground| world.body(ground));
        ground.map_or(Vec3::ZERO, |ground| ground.velocity_at(self.ground_point))
    }
}

impl Mover {
    /// A mover for this convex shape: a capsule, a sphere, a cylinder, a box or a hull.
    #[must_use]
    pub const fn new(shape: Shape) -> Self {
        let max_slope = core::f32::consts::FRAC_PI_4;
        Self { shape, up: Vec3::Y, step: 0.3, max_slope, snap: 0.3, skin: 0.01 }
    }

    /// Sets the maximum height of a step that it climbs [m], at least 0; default 0.3. It climbs
    /// only from ground onto ground.
    #[must_use]
    pub fn with_step(self, step: f32) -> Self {
        Self { step, ..self }
    }

    /// Sets the steepest slope that it walks on [rad], 0 to π/2; default π/4. It treats steeper
    /// ground as a wall, and slides down there.
    #[must_use]
    pub fn with_max_slope(self, max_slope: f32) -> Self {
        Self { max_slope, ..self }
    }

    /// Sets the maximum distance by which it follows the ground down in one move [m], at least 0;
    /// default 0.3. With 0 it leaves the ground at every edge.
    #[must_use]
    pub fn with_snap(self, snap: f32) -> Self {
        Self { snap, ..self }
    }

    /// Sets the approximate distance that it keeps from obstacles [m], above 0; default 0.01. It
    /// should be above the rounding of coordinates, and far below the size of the shape.
    #[must_use]
    pub fn with_skin(self, skin: f32) -> Self {
        Self { skin, ..self }
    }

    /// Sets the upward direction [world, any length]; default y. The shape itself does not turn.
    #[must_use]
    pub fn with_up(self, up: impl Into<Vec3>) -> Self {
        Self { up: up.into(), ..self }
    }

    /// The shape of the character.
    #[must_use]
    pub const fn shape(&self) -> &Shape {
        &self.shape
    }

    /// Moves the shape from `pose` by `delta` [m, world], as far as the shapes that pass the filter
    /// allow. Shapes that overlap it at the start push it out. With an upward `delta`, a jump, it
    /// does not stay on the ground. [`QueryFilter::inside`] is ignored.
    ///
    /// The filter should exclude the character's own body.
    ///
    /// # Errors
    /// The shape, the pose, `delta` or a setting of the mover is invalid, the shape is a mesh or a
    /// half-space, or the displacement leads beyond 1e7 m.
    pub fn move_by<'f>(
        &self,
        world: &World,
        pose: Pose,
        delta: impl Into<Vec3>,
        filter: impl Into<QueryFilter<'f>>,
    ) -> Result<Moved, DefError> {
        let mut moved = Moved::default();
        self.move_into(world, pose, delta, filter, &mut moved)?;
        Ok(moved)
    }

    /// Like [`Self::move_by`], with a result whose memory is reused.
    ///
    /// # Errors
    /// The same errors as those of [`Self::move_by`]; then the content of `moved` is unspecified.
    pub fn move_into<'f>(
        &self,
        world: &World,
        pose: Pose,
        delta: impl Into<Vec3>,
        filter: impl Into<QueryFilter<'f>>,
        moved: &mut Moved,
    ) -> Result<(), DefError> {
        let delta = delta.into();
        let up = self.valid_up()?;
        position("pose.position", pose.position)?;
        all_within("delta", delta, &limits::POSITION)?;
        // Climbing and the skin lengthen the path, and so does the descent.
        let reach = 2.0 * (self.step + self.snap + self.skin);
        position("delta", pose.position.abs() + delta.abs() + Vec3::splat(reach))?;
        let (_, flattest) = crate::base::trig::sin_cos(self.max_slope);
        let walk = Walk {
            world,
            mover: self,
            filter: filter.into(),
            rotation: pose.rotation,
            up,
            flattest: flattest - 1.0e-4,
        };
        walk.all(pose.position, delta, moved)
    }

    /// Moves a kinematic body like this shape, from its current pose by a velocity [m/s, world]. In
    /// the next step of `dt` [s] the body moves there, rides on its ground, and pushes every body
    /// in its way, of any mass. The move ignores the body itself. Let the filter exclude dynamic
    /// bodies; otherwise they stop the body before it can push them.
    ///
    /// The result is the pose without the ride, among the bodies at their current poses. The body's
    /// velocity lasts until the body is moved again or its velocity is set.
    ///
    /// ```
    /// use drystone::{BodyDef, DefError, Shape, ShapeDef, World};
    /// use drystone::mover::Mover;
    /// use drystone::query::{BodyKinds, QueryFilter};
    ///
    /// fn main() -> Result<(), DefError> {
    ///     let mut world = World::default();
    ///     world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0)))?;
    ///     let hero = BodyDef::kinematic().with_position([0.0, 0.81, 0.0]);
    ///     let hero = world.add_body(hero.with_shape(ShapeDef::capsule(0.5, 0.3)))?;
    ///     let mover = Mover::new(Shape::capsule(0.5, 0.3));
    ///     let level = QueryFilter::default().with_kinds(BodyKinds::STATIC | BodyKinds::KINEMATIC);
    ///     for _ in 0..60 {
    ///         mover.move_body(&mut world, hero, [2.0, -0.1, 0.0], 1.0 / 60.0, level)?;
    ///         world.step(1.0 / 60.0);
    ///     }
    ///     assert!(world.body(hero).is_some_and(|hero| (hero.position().x - 2.0).abs() < 1e-3));
    ///     Ok(())
    /// }
    /// ```
    ///
    /// The errors of [`Self::move_by`] and [`crate::BodyMut::move_to`]; or the body does not exist
    /// or is not kinematic. Then nothing is changed.
    pub fn move_body<'f>(
        &self,
        world: &mut World,
        body: BodyId,
        velocity: impl Into<Vec3>,
        dt: f32,
        filter: impl Into<QueryFilter<'f>>,
    ) -> Result<Moved, DefError> {
        within("dt", dt, &limits::TIME_STEP)?;
        let allowed = "a kinematic body of this world";
        let Some(found) = world.body(body) else {
            return Err(DefError::missing(
                "body",
                format_args!("BodyId {}", body.index()),
                allowed,
            ));
        };
        if found.kind() != BodyKind::Kinematic {
            return Err(DefError::unsuitable("body", format!("{:?}", found.kind()), allowed));
        }
        let filter = filter.into();
        let others = |shape: ShapeRef<'_>| {
            shape.body() != body && filter.predicate.is_none_or(|sees| sees(shape))
        };
        let filter = filter.with_predicate(&others);
        let moved = self.move_by(world, found.pose(), velocity.into() * dt, filter)?;
        let ride = moved.ground_velocity(world) * dt;
        let to = Pose { position: moved.pose.position + ride, ..moved.pose };
        if let Some(mut body) = world.body_mut(body) {
            body.try_move_to(to, dt)?;
        }
        Ok(moved)
    }

    /// Checks the settings. Returns the upward direction as a unit vector.
    fn valid_up(&self) -> Result<Vec3, DefError> {
        within("step", self.step, &limits::CONTACT_DISTANCE)?;
        within("snap", self.snap, &limits::CONTACT_DISTANCE)?;
        within("skin", self.skin, &limits::MARGIN)?;
        if !(0.0..=core::f32::consts::FRAC_PI_2).contains(&self.max_slope) {
            return Err(DefError::new("max_slope", self.max_slope, "an angle from 0 to π/2"));
        }
        all_within("up", self.up, &limits::POSITION)?;
        let up = self.up.try_normalize();
        up.ok_or_else(|| DefError::of_vec("up", self.up, "a vector other than 0"))
    }
}
