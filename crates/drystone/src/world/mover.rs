//! A shape that is moved as a character is: it slides along walls, climbs steps, stays on the ground.

mod walk;

use crate::base::id::{BodyId, ShapeId};
use crate::base::limits;
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::geometry::shape::Shape;
use crate::query::cast::ShapeHit;
use crate::query::filter::QueryFilter;
use crate::query::shape::ShapeRef;
use crate::state::check::{all_within, position, within};
use crate::state::def::{BodyKind, DefError};

use self::walk::Walk;
use super::World;

/// How a character moves through a world: a convex shape, mostly a capsule, that is no body. It slides along what it meets, climbs
/// steps, walks up slopes that are not too steep, slides down those that are, and stays on the ground downhill.
///
/// The defaults fit a person in meters: steps up to 0.3 m, slopes up to 45 degrees, up along y. The manual:
/// [character](crate::manual::character).
///
/// Gravity, jumps and speeds are the program's: it gives the way of each frame. So is what else bodies do to each other:
///
/// * To ride on a lift, add `moved.ground_velocity(&world) * dt` to the position that came out. A query sees the lift where it still
///   is, and the next step moves it.
/// * To push crates, give [`MoverHit::body`] an impulse at [`MoverHit::point`] against the normal: of the mass of the character times
///   `hit.blocked / dt`, or what its strength allows.
/// * [`Self::move_body`] lets a kinematic body follow: it rides and pushes, and other characters meet it.
///
/// One-way surfaces hold it from their front only. A round bottom also walks over edges that are lower than
/// `radius * (1 - cos(max_slope))`, whatever `step` is.
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

/// Something that a [`Mover`] met on its way.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct MoverHit {
    /// The shape that was met.
    pub shape: ShapeId,
    /// Its body.
    pub body: BodyId,
    /// Where [m, world].
    pub point: Vec3,
    /// Outward normal of the surface that was met [world, unit].
    pub normal: Vec3,
    /// How much farther into the surface the way would have led [m]; at least 0. Over the time of the frame it is the speed at which
    /// the mover ran into it.
    pub blocked: f32,
}

/// The outcome of a move: see [`Mover::move_by`]. One that [`Mover::move_into`] fills can be used again, with the memory that it has.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Moved {
    /// Where the shape is now [m, world].
    pub pose: Pose,
    /// Whether it stands on ground that is not too steep. After a way that leads up it never does.
    pub grounded: bool,
    /// The body that it stands on, if it is grounded.
    pub ground: Option<BodyId>,
    /// Where it stands [m, world]; 0 if it is not grounded.
    pub ground_point: Vec3,
    /// Normal of the ground [world, unit]; at an edge that of the face behind it; 0 if it is not grounded.
    pub ground_normal: Vec3,
    /// The surfaces that were in the way, in the order in which they were met; the ground too if the way led into it.
    pub hits: Vec<MoverHit>,
    /// Memory of casts.
    found: Vec<ShapeHit>,
}

impl Moved {
    /// Velocity of the ground where the mover stands on it [m/s, world]; 0 if it is not grounded, or the body is gone.
    #[must_use]
    pub fn ground_velocity(&self, world: &World) -> Vec3 {
        let ground = self.ground.and_then(|ground| world.body(ground));
        ground.map_or(Vec3::ZERO, |ground| ground.velocity_at(self.ground_point))
    }
}

impl Mover {
    /// Moves this convex shape: a capsule, a sphere, a cylinder, a box or a hull.
    #[must_use]
    pub const fn new(shape: Shape) -> Self {
        let max_slope = core::f32::consts::FRAC_PI_4;
        Self { shape, up: Vec3::Y, step: 0.3, max_slope, snap: 0.3, skin: 0.01 }
    }

    /// Climbs edges up to this height [m]; at least 0; default 0.3. Only from the ground, and only onto ground.
    #[must_use]
    pub fn with_step(self, step: f32) -> Self {
        Self { step, ..self }
    }

    /// Walks on ground up to this slope [rad], 0 to π/2; default π/4. Steeper ground is a wall to it, and it slides down there.
    #[must_use]
    pub fn with_max_slope(self, max_slope: f32) -> Self {
        Self { max_slope, ..self }
    }

    /// Follows the ground down by up to this much in a move [m]; at least 0; default 0.3. With 0 it flies off at every edge.
    #[must_use]
    pub fn with_snap(self, snap: f32) -> Self {
        Self { snap, ..self }
    }

    /// Keeps about this distance from what it meets [m]; above 0; default 0.01. It should be above the roundings of coordinates, and far
    /// below the size of the shape.
    #[must_use]
    pub fn with_skin(self, skin: f32) -> Self {
        Self { skin, ..self }
    }

    /// Stands upright along this direction [world, any length]; default y. The shape itself does not turn.
    #[must_use]
    pub fn with_up(self, up: impl Into<Vec3>) -> Self {
        Self { up: up.into(), ..self }
    }

    /// The shape that is moved.
    #[must_use]
    pub const fn shape(&self) -> &Shape {
        &self.shape
    }

    /// Moves from `pose` by `delta` [m, world], as far as the shapes that the filter sees allow. Shapes that it overlaps at the start
    /// push it out. A `delta` that leads up is a jump: it does not stay on the ground then. [`QueryFilter::inside`] does not count.
    ///
    /// The filter should exclude the character's own body.
    ///
    /// # Errors
    /// The shape, the pose, `delta` or a setting of the mover is invalid, the shape is a mesh or a half-space, or the way leads beyond
    /// 1e7 m.
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

    /// [`Self::move_by`] into a result whose memory is used again.
    ///
    /// # Errors
    /// The same as of [`Self::move_by`]; then `moved` is of no use.
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
        // Climbing and the skin add to the way, and so does the way down again.
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

    /// Moves a kinematic body as this shape, by its place now and a velocity [m/s, world], and lets it follow: in the next step of `dt`
    /// [s] it goes there, rides along with the ground, and pushes what is in its way, however heavy. The body itself is not met. Let the
    /// filter see no dynamic bodies, or they stop it before it can push them.
    ///
    /// The result is the place it comes to without the ride, among the bodies as they are now. The body's velocity lasts until it is
    /// moved again or told another one.
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
    /// # Errors
    /// The same as of [`Self::move_by`] and [`crate::BodyMut::move_to`], or there is no such body, or it is not kinematic. Then nothing
    /// is changed.
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

    /// Checks the settings, and gives the direction up as a unit vector.
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
