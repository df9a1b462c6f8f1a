//! Rays and shape casts as components, asked again after every step.

use bevy_ecs::component::Component;
use bevy_ecs::entity::Entity;
use bevy_ecs::system::Query;
use bevy_math::{Dir3, Quat, Vec3};

use crate::collider::Collider;
use crate::convert::{Placement, from_quat, from_vec, times, to_quat, to_vec};
use crate::query::{RayHitData, ShapeHitData, SpatialQuery, SpatialQueryFilter};
use crate::scene::Scene;

/// A ray in the frame of its entity. After every step [`RayHits`] has what it meets, as seen from
/// where the entity then is. The scale of the entity moves the origin, but does not stretch the
/// ray.
#[derive(Clone, Component, Debug, PartialEq)]
#[require(RayHits, bevy_transform::components::Transform)]
pub struct RayCaster {
    /// Whether it is asked; default true. A ray that is not asked has no hits.
    pub enabled: bool,
    /// Origin [m, frame of the entity].
    pub origin: Vec3,
    /// Direction [frame of the entity].
    pub direction: Dir3,
    /// Length [m], above 0; default: as far as the engine's numbers go.
    pub max_distance: f32,
    /// Maximum number of hits, of which the nearest are listed; default all.
    pub max_hits: usize,
    /// Whether a ray that starts in a collider hits it at once; default true.
    pub solid: bool,
    /// Whether it passes the collider and body of its own entity; default true.
    pub ignore_self: bool,
    /// The colliders that it sees.
    pub filter: SpatialQueryFilter,
}

impl RayCaster {
    /// A ray from this origin [m] in this direction [frame of the entity].
    #[must_use]
    pub fn new(origin: Vec3, direction: Dir3) -> Self {
        Self {
            enabled: true,
            origin,
            direction,
            max_distance: f32::MAX,
            max_hits: usize::MAX,
            solid: true,
            ignore_self: true,
            filter: SpatialQueryFilter::default(),
        }
    }

    /// With this length [m].
    #[must_use]
    pub fn with_max_distance(self, max_distance: f32) -> Self {
        Self { max_distance, ..self }
    }

    /// With at most this many hits.
    #[must_use]
    pub fn with_max_hits(self, max_hits: usize) -> Self {
        Self { max_hits, ..self }
    }

    /// Sees only these colliders.
    #[must_use]
    pub fn with_query_filter(self, filter: SpatialQueryFilter) -> Self {
        Self { filter, ..self }
    }
}

/// The hits of a [`RayCaster`] after the last step, nearest first. It counts as changed only when
/// it differs.
#[derive(Clone, Component, Debug, Default, PartialEq)]
pub struct RayHits(pub Vec<RayHitData>);

/// A convex collider that is cast in the frame of its entity. After every step [`ShapeHits`] has
/// the first hit. The scale of the entity moves the origin, but does not change the shape.
#[derive(Clone, Component, Debug)]
#[require(ShapeHits, bevy_transform::components::Transform)]
pub struct ShapeCaster {
    /// Whether it is asked; default true. A cast that is not asked has no hit.
    pub enabled: bool,
    /// The shape. Of a compound only the first part is cast.
    pub shape: Collider,
    /// Origin [m, frame of the entity].
    pub origin: Vec3,
    /// Rotation of the shape [frame of the entity].
    pub rotation: Quat,
    /// Direction [frame of the entity].
    pub direction: Dir3,
    /// Length [m], above 0; default: as far as the engine's numbers go.
    pub max_distance: f32,
    /// Whether it passes the collider and body of its own entity; default true.
    pub ignore_self: bool,
    /// The colliders that it sees.
    pub filter: SpatialQueryFilter,
}

impl ShapeCaster {
    /// A shape at this origin [m] with this rotation, cast in this direction [frame of the entity].
    #[must_use]
    pub fn new(shape: Collider, origin: Vec3, rotation: Quat, direction: Dir3) -> Self {
        Self {
            enabled: true,
            shape,
            origin,
            rotation,
            direction,
            max_distance: f32::MAX,
            ignore_self: true,
            filter: SpatialQueryFilter::default(),
        }
    }

    /// With this length [m].
    #[must_use]
    pub fn with_max_distance(self, max_distance: f32) -> Self {
        Self { max_distance, ..self }
    }

    /// Sees only these colliders.
    #[must_use]
    pub fn with_query_filter(self, filter: SpatialQueryFilter) -> Self {
        Self { filter, ..self }
    }
}

/// The first hit of a [`ShapeCaster`] after the last step; `None`: it meets nothing. It counts as
/// changed only when it differs.
#[derive(Clone, Component, Copy, Debug, Default, PartialEq)]
pub struct ShapeHits(pub Option<ShapeHitData>);

/// The filter of a caster.
fn seen(filter: &SpatialQueryFilter, ignores: bool, owner: Entity) -> SpatialQueryFilter {
    let filter = filter.clone();
    if ignores { filter.with_excluded_entities([owner]) } else { filter }
}

/// The origin [m, world] and the direction of a caster; `None` where they are no numbers.
fn aim(place: &Placement, origin: Vec3, direction: Dir3) -> Option<(Vec3, Dir3)> {
    let at = place.pose.point(times(place.scale, to_vec(origin)));
    let way = Dir3::new(from_vec(place.pose.rotation.rotate(to_vec(*direction)))).ok()?;
    at.is_finite().then_some((from_vec(at), way))
}

/// The system that asks all casters, after the poses of a step are written.
pub(crate) fn cast(
    scene: Scene<'_, '_>,
    query: SpatialQuery<'_, '_>,
    mut rays: Query<'_, '_, (Entity, &RayCaster, &mut RayHits)>,
    mut shapes: Query<'_, '_, (Entity, &ShapeCaster, &mut ShapeHits)>,
) {
    for (entity, ray, mut hits) in &mut rays {
        let aim = aim(&scene.place(entity), ray.origin, ray.direction);
        let found = aim.filter(|_| ray.enabled).map(|(from, way)| {
            let filter = seen(&ray.filter, ray.ignore_self, scene.owner(entity));
            query.ray_hits(from, way, ray.max_distance, ray.max_hits, ray.solid, &filter)
        });
        let found = found.unwrap_or_default();
        if hits.0 != found {
            hits.0 = found;
        }
    }
    for (entity, caster, mut hit) in &mut shapes {
        let place = scene.place(entity);
        let aim = aim(&place, caster.origin, caster.direction);
        let found = aim.filter(|_| caster.enabled).and_then(|(from, way)| {
            let filter = seen(&caster.filter, caster.ignore_self, scene.owner(entity));
            let turn = from_quat(place.pose.rotation * to_quat(caster.rotation));
            query.cast_shape(&caster.shape, from, turn, way, caster.max_distance, &filter)
        });
        if hit.0 != found {
            hit.0 = found;
        }
    }
}
