//! Queries of worlds as a system parameter.

use bevy_ecs::entity::Entity;
use bevy_ecs::system::{Query, Res, SystemParam};
use bevy_math::{Dir3, Quat, Vec3};
use drystone::query::{BodyKinds, Inside, QueryFilter};
use drystone::{BodyId, DefError, Filter, Pose, Shape, ShapeId, ShapeRef, World, limits};

use crate::collider::{Collider, PhysicsCollider};
use crate::convert::{from_vec, to_quat, to_vec};
use crate::world::{DefaultPhysicsWorld, PhysicsWorld};

/// Rays, shape casts, overlaps and nearest points.
///
/// Queries see the world as the last step left it: entities that were spawned or moved since are
/// seen from the next step on. A query with a number out of range finds nothing, and logs a
/// warning that names the number.
#[derive(Debug, SystemParam)]
pub struct SpatialQuery<'w, 's> {
    worlds: Query<'w, 's, &'static PhysicsWorld>,
    colliders: Query<'w, 's, &'static PhysicsCollider>,
    default: Res<'w, DefaultPhysicsWorld>,
}

/// Selects the colliders that a query sees; by default all but sensors, in the default world.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SpatialQueryFilter {
    /// The query sees colliders in one of these layers; `None`: in all.
    pub mask: Option<u64>,
    /// Colliders, and bodies with all their colliders, that the query does not see.
    pub excluded_entities: Vec<Entity>,
    /// Whether it sees sensors; default false.
    pub sees_sensors: bool,
    /// The kinds of bodies whose colliders it sees; default all.
    pub kinds: BodyKinds,
    /// The entity of the world; `None`: the default one.
    pub world: Option<Entity>,
}

impl SpatialQueryFilter {
    /// Sees only colliders in one of these layers.
    #[must_use]
    pub fn from_mask(mask: u64) -> Self {
        Self { mask: Some(mask), ..Self::default() }
    }

    /// Does not see these colliders and bodies.
    #[must_use]
    pub fn from_excluded_entities(entities: impl IntoIterator<Item = Entity>) -> Self {
        Self::default().with_excluded_entities(entities)
    }

    /// Sees only colliders in one of these layers.
    #[must_use]
    pub fn with_mask(self, mask: u64) -> Self {
        Self { mask: Some(mask), ..self }
    }

    /// Does not see these colliders and bodies either.
    #[must_use]
    pub fn with_excluded_entities(mut self, entities: impl IntoIterator<Item = Entity>) -> Self {
        self.excluded_entities.extend(entities);
        self
    }

    /// Sees sensors too.
    #[must_use]
    pub fn with_sensors(self) -> Self {
        Self { sees_sensors: true, ..self }
    }

    /// Sees only the colliders of bodies of these kinds.
    #[must_use]
    pub fn with_kinds(self, kinds: BodyKinds) -> Self {
        Self { kinds, ..self }
    }

    /// In the world of this entity.
    #[must_use]
    pub fn in_world(self, world: Entity) -> Self {
        Self { world: Some(world), ..self }
    }
}

/// A hit of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHitData {
    /// The collider; [`Entity::PLACEHOLDER`] for a shape that was added to the world without one.
    pub entity: Entity,
    /// The body of the collider.
    pub body: BodyId,
    /// Distance from the origin of the ray [m].
    pub distance: f32,
    /// Point of the hit [m, world].
    pub point: Vec3,
    /// Outward normal of the surface [world].
    pub normal: Vec3,
}

/// A hit of a moving shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeHitData {
    /// The collider that was hit; [`Entity::PLACEHOLDER`] for a shape without one.
    pub entity: Entity,
    /// The body of the collider.
    pub body: BodyId,
    /// Distance that the shape moved until the hit [m].
    pub distance: f32,
    /// Contact point [m, world].
    pub point: Vec3,
    /// Outward normal of the surface that was hit [world].
    pub normal: Vec3,
    /// Whether the shapes overlap at the start.
    pub is_inside: bool,
}

/// The point of a collider nearest to another point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// The collider; [`Entity::PLACEHOLDER`] for a shape without one.
    pub entity: Entity,
    /// Its nearest point [m, world].
    pub point: Vec3,
    /// Whether the given point is inside the collider.
    pub is_inside: bool,
}

/// Radius of the ball that stands for a point [m].
const POINT: f32 = 1.0e-5;

impl SpatialQuery<'_, '_> {
    /// The first collider that a ray meets. `solid`: whether a ray that starts in a collider hits
    /// it at once; otherwise it hits the far side from within.
    #[must_use]
    pub fn cast_ray(
        &self,
        origin: Vec3,
        direction: Dir3,
        max_distance: f32,
        solid: bool,
        filter: &SpatialQueryFilter,
    ) -> Option<RayHitData> {
        self.cast_ray_predicate(origin, direction, max_distance, solid, filter, &|_| true)
    }

    /// The first collider that a ray meets and for which `predicate` is true.
    #[must_use]
    pub fn cast_ray_predicate(
        &self,
        origin: Vec3,
        direction: Dir3,
        max_distance: f32,
        solid: bool,
        filter: &SpatialQueryFilter,
        predicate: &(dyn Fn(Entity) -> bool + Sync),
    ) -> Option<RayHitData> {
        let way = reach(max_distance);
        self.ask(filter, predicate, inside(solid), |world, filter| {
            let delta = to_vec(*direction) * way;
            let hit = world.query().cast_ray(to_vec(origin), delta, filter)?;
            Ok(hit.map(|hit| self.ray_hit(world, &hit, way)))
        })?
    }

    /// All colliders that a ray meets, nearest first, at most `max_hits`.
    #[must_use]
    pub fn ray_hits(
        &self,
        origin: Vec3,
        direction: Dir3,
        max_distance: f32,
        max_hits: usize,
        solid: bool,
        filter: &SpatialQueryFilter,
    ) -> Vec<RayHitData> {
        let way = reach(max_distance);
        let found = self.ask(filter, &|_| true, inside(solid), |world, filter| {
            let mut hits = Vec::new();
            let delta = to_vec(*direction) * way;
            world.query().cast_ray_all(to_vec(origin), delta, filter, &mut hits)?;
            let hits = hits.iter().take(max_hits);
            Ok(hits.map(|hit| self.ray_hit(world, hit, way)).collect())
        });
        found.unwrap_or_default()
    }

    /// The first collider that a moving convex collider meets. Of a compound only the first part
    /// moves.
    #[must_use]
    pub fn cast_shape(
        &self,
        collider: &Collider,
        origin: Vec3,
        rotation: Quat,
        direction: Dir3,
        max_distance: f32,
        filter: &SpatialQueryFilter,
    ) -> Option<ShapeHitData> {
        let way = reach(max_distance);
        let (shape, pose) = placed(collider, origin, rotation)?;
        self.ask(filter, &|_| true, Inside::Solid, |world, filter| {
            let delta = to_vec(*direction) * way;
            let hit = world.query().cast_shape(shape, pose, delta, filter)?;
            Ok(hit.map(|hit| ShapeHitData {
                entity: self.entity(world, hit.shape),
                body: hit.body,
                distance: hit.fraction * way,
                point: from_vec(hit.point),
                normal: from_vec(hit.normal),
                is_inside: hit.inside,
            }))
        })?
    }

    /// The colliders that overlap a convex collider, each once, in the order of the world. Of a
    /// compound only the first part counts.
    #[must_use]
    pub fn shape_intersections(
        &self,
        collider: &Collider,
        position: Vec3,
        rotation: Quat,
        filter: &SpatialQueryFilter,
    ) -> Vec<Entity> {
        let Some((shape, pose)) = placed(collider, position, rotation) else { return Vec::new() };
        self.overlaps(filter, |world, filter| world.query().overlap_shape(shape, pose, filter))
    }

    /// The colliders that contain a point [m, world], each once, in the order of the world.
    #[must_use]
    pub fn point_intersections(&self, point: Vec3, filter: &SpatialQueryFilter) -> Vec<Entity> {
        self.overlaps(filter, |world, filter| world.query().overlap_point(to_vec(point), filter))
    }

    /// The colliders whose bounding boxes overlap a box [m, world], each once, in the order of the
    /// world.
    #[must_use]
    pub fn aabb_intersections(
        &self,
        min: Vec3,
        max: Vec3,
        filter: &SpatialQueryFilter,
    ) -> Vec<Entity> {
        let bounds = drystone::geometry::Aabb::new(to_vec(min), to_vec(max));
        self.overlaps(filter, |world, filter| world.query().overlap_bounds(bounds, filter))
    }

    /// The point of the nearest collider, at most `max_distance` away.
    #[must_use]
    pub fn project_point(
        &self,
        point: Vec3,
        max_distance: f32,
        filter: &SpatialQueryFilter,
    ) -> Option<Projection> {
        self.ask(filter, &|_| true, Inside::Solid, |world, filter| {
            let (ball, pose) = (Shape::sphere(POINT), Pose::at(to_vec(point)));
            let near = world.query().nearest_shape(&ball, pose, reach(max_distance), filter)?;
            Ok(near.map(|near| Projection {
                entity: self.entity(world, near.shape),
                point: from_vec(near.point),
                is_inside: near.distance < 0.0,
            }))
        })?
    }

    fn overlaps(
        &self,
        filter: &SpatialQueryFilter,
        find: impl FnOnce(&World, QueryFilter<'_>) -> Result<Vec<ShapeId>, DefError>,
    ) -> Vec<Entity> {
        let found = self.ask(filter, &|_| true, Inside::Solid, |world, filter| {
            let mut entities: Vec<Entity> = Vec::new();
            for shape in find(world, filter)? {
                let entity = self.entity(world, shape);
                if !entities.contains(&entity) {
                    entities.push(entity);
                }
            }
            Ok(entities)
        });
        found.unwrap_or_default()
    }

    /// Runs a query in the world of a filter. An error is logged.
    pub(crate) fn ask<T>(
        &self,
        filter: &SpatialQueryFilter,
        predicate: &(dyn Fn(Entity) -> bool + Sync),
        inside: Inside,
        query: impl FnOnce(&World, QueryFilter<'_>) -> Result<T, DefError>,
    ) -> Option<T> {
        let of = filter.world.unwrap_or(self.default.0);
        let Ok(physics) = self.worlds.get(of) else {
            log::warn!("a query needs the entity of a PhysicsWorld (got {of})");
            return None;
        };
        let world = &physics.world;
        let body = |shape: &ShapeRef<'_>| physics.entity_of(shape.body());
        let is_seen = |shape: ShapeRef<'_>| {
            let entity = Entity::try_from_bits(shape.user_data()).unwrap_or(Entity::PLACEHOLDER);
            let excluded = &filter.excluded_entities;
            let is_excluded = !excluded.is_empty()
                && (excluded.contains(&entity)
                    || body(&shape).is_some_and(|body| excluded.contains(&body)));
            let is_in = filter.mask.is_none_or(|mask| shape.filter().layers & mask != 0);
            is_in && !is_excluded && predicate(entity)
        };
        // The mask is tested above: a collider's own filters do not count for a query.
        let seen = QueryFilter {
            filter: None::<Filter>,
            kinds: filter.kinds,
            sensors: filter.sees_sensors,
            predicate: Some(&is_seen),
            inside,
            ..QueryFilter::default()
        };
        match query(world, seen) {
            Ok(found) => Some(found),
            Err(error) => {
                log::warn!("a query was refused: {error}");
                None
            }
        }
    }

    fn ray_hit(&self, world: &World, hit: &drystone::query::RayHit, way: f32) -> RayHitData {
        RayHitData {
            entity: self.entity(world, hit.shape),
            body: hit.body,
            distance: hit.fraction * way,
            point: from_vec(hit.point),
            normal: from_vec(hit.normal),
        }
    }

    /// The collider of a shape.
    pub(crate) fn entity(&self, world: &World, shape: ShapeId) -> Entity {
        let entity = world.shape(shape).and_then(|found| Entity::try_from_bits(found.user_data()));
        // Shapes that the user added to the world have numbers of their own.
        let is_own = |entity: &Entity| {
            self.colliders.get(*entity).is_ok_and(|record| record.shapes.contains(&shape))
        };
        entity.filter(is_own).unwrap_or(Entity::PLACEHOLDER)
    }
}

/// The engine's maximum for queries without an end.
fn reach(distance: f32) -> f32 {
    distance.min(limits::DISPLACEMENT.maximum)
}

const fn inside(solid: bool) -> Inside {
    if solid { Inside::Solid } else { Inside::Hollow }
}

/// The first shape of a collider at a place.
fn placed(collider: &Collider, position: Vec3, rotation: Quat) -> Option<(&Shape, Pose)> {
    let outer = Pose { position: to_vec(position), rotation: to_quat(rotation) };
    let (inner, shape) = collider.shapes().next()?;
    Some((shape, outer.compose(&inner)))
}
