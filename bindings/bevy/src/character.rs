//! Characters: a shape that walks, climbs steps and slides along walls.

use bevy_ecs::entity::Entity;
use bevy_ecs::system::SystemParam;
use bevy_math::{Quat, Vec3};
use drystone::mover::{Moved, Mover};
use drystone::query::Inside;
use drystone::{Pose, World};

use crate::collider::Collider;
use crate::convert::{from_vec, to_quat, to_vec};
use crate::query::{SpatialQuery, SpatialQueryFilter};

/// Moves the shape of a character among the colliders of the last step.
///
/// The character itself is an entity with a kinematic body: write the result to its `Transform`,
/// which is its target, plus the way of the ground, so that it rides on lifts:
///
/// ```
/// use bevy_drystone::{CharacterMover, CharacterSettings, Collider, SpatialQueryFilter};
/// use bevy_ecs::prelude::{Component, Entity, Query, Res};
/// use bevy_math::Vec3;
/// use bevy_time::Time;
/// use bevy_transform::components::Transform;
///
/// #[derive(Component)]
/// struct Walk(Vec3);
///
/// fn walk(
///     mover: CharacterMover,
///     mut heroes: Query<(Entity, &mut Transform, &Collider, &Walk)>,
///     time: Res<Time>,
/// ) {
///     let (dt, settings) = (time.delta_secs(), CharacterSettings::default());
///     for (hero, mut place, collider, walk) in &mut heroes {
///         let others = SpatialQueryFilter::from_excluded_entities([hero]);
///         let (at, turn) = (place.translation, place.rotation);
///         let moved = mover.move_by(collider, at, turn, walk.0 * dt, &settings, &others);
///         if let Some(moved) = moved {
///             place.translation = moved.position + moved.ground_velocity * dt;
///         }
///     }
/// }
/// ```
#[derive(Debug, SystemParam)]
pub struct CharacterMover<'w, 's> {
    query: SpatialQuery<'w, 's>,
}

/// How a character moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CharacterSettings {
    /// Height of the steps that it climbs [m], at least 0; default 0.3.
    pub step: f32,
    /// Slope of the steepest ground on which it stands [rad], 0 to π/2; default π/4 (45°).
    pub max_slope: f32,
    /// Depth to which it stays on ground that falls away under it [m], at least 0; default 0.3.
    pub snap: f32,
    /// Distance that it keeps from other shapes [m], at least 0; default 0.01.
    pub skin: f32,
    /// Upward direction [world, any length]; default y.
    pub up: Vec3,
}

impl Default for CharacterSettings {
    fn default() -> Self {
        let max_slope = core::f32::consts::FRAC_PI_4;
        Self { step: 0.3, max_slope, snap: 0.3, skin: 0.01, up: Vec3::Y }
    }
}

/// An obstacle that a character met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CharacterHit {
    /// The collider; [`Entity::PLACEHOLDER`] for a shape without one.
    pub entity: Entity,
    /// Contact point [m, world].
    pub point: Vec3,
    /// Outward normal of the obstacle [world].
    pub normal: Vec3,
    /// Depth by which the blocked way would have entered the obstacle [m].
    pub blocked: f32,
}

/// The outcome of a move.
#[derive(Clone, Debug, PartialEq)]
pub struct CharacterMove {
    /// Position of the shape [m, world].
    pub position: Vec3,
    /// Whether it stands on ground that is not too steep.
    pub is_grounded: bool,
    /// The entity of the body under it, if it stands on one.
    pub ground: Option<Entity>,
    /// Normal of the ground [world]; 0 in the air.
    pub ground_normal: Vec3,
    /// Velocity of the ground [m/s, world]; 0 in the air.
    pub ground_velocity: Vec3,
    /// The obstacles met, in order.
    pub hits: Vec<CharacterHit>,
}

impl CharacterMover<'_, '_> {
    /// Moves a convex collider by `delta` [m, world], as far as other colliders allow. Of a
    /// compound only the first part moves. A filter that hides dynamic bodies lets the character's
    /// body push them.
    ///
    /// `None` if a number is out of range: a warning in the log names it.
    #[must_use]
    pub fn move_by(
        &self,
        collider: &Collider,
        position: Vec3,
        rotation: Quat,
        delta: Vec3,
        settings: &CharacterSettings,
        filter: &SpatialQueryFilter,
    ) -> Option<CharacterMove> {
        let (inner, shape) = collider.shapes().next()?;
        let outer = Pose { position: to_vec(position), rotation: to_quat(rotation) };
        let mover = Mover::new(shape.clone())
            .with_step(settings.step)
            .with_max_slope(settings.max_slope)
            .with_snap(settings.snap)
            .with_skin(settings.skin)
            .with_up(to_vec(settings.up));
        self.query.ask(filter, &|_| true, Inside::Solid, |world, filter| {
            let start = outer.compose(&inner);
            let moved = mover.move_by(world, start, to_vec(delta), filter)?;
            let way = moved.pose.position - start.position;
            Ok(self.outcome(world, outer.position + way, &moved))
        })
    }

    fn outcome(&self, world: &World, position: drystone::Vec3, moved: &Moved) -> CharacterMove {
        let ground = moved.ground.and_then(|body| world.body(body));
        let hits = moved.hits.iter().map(|hit| CharacterHit {
            entity: self.query.entity(world, hit.shape),
            point: from_vec(hit.point),
            normal: from_vec(hit.normal),
            blocked: hit.blocked,
        });
        CharacterMove {
            position: from_vec(position),
            is_grounded: moved.grounded,
            ground: ground.and_then(|body| Entity::try_from_bits(body.user_data())),
            ground_normal: from_vec(moved.ground_normal),
            ground_velocity: from_vec(moved.ground_velocity(world)),
            hits: hits.collect(),
        }
    }
}
