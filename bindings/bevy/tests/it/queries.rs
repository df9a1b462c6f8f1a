//! Spatial queries.

use bevy_drystone::{
    Collider, CollisionLayers, InWorld, PhysicsWorld, RigidBody, Sensor, SpatialQuery,
    SpatialQueryFilter,
};
use bevy_ecs::hierarchy::ChildOf;
use bevy_math::{Dir3, Quat, Vec3};
use bevy_transform::components::Transform;

use crate::game::{Game, near};

fn at(x: f32) -> Transform {
    Transform::from_xyz(x, 0.0, 0.0)
}

/// Balls of 1 m at 2, 4 and 6 m along x.
#[test]
fn rays_find_colliders_in_order_and_by_filter() {
    let mut game = Game::new();
    let first = game.spawn((Collider::sphere(0.5), at(2.0), CollisionLayers::new(1, 1)));
    let sensor = game.spawn((Collider::sphere(0.5), at(4.0), Sensor));
    let last = game.spawn((Collider::sphere(0.5), at(6.0), CollisionLayers::new(2, 1)));
    game.run(1);
    let all = SpatialQueryFilter::default();
    let cast = |game: &mut Game, filter: SpatialQueryFilter| {
        game.ask(move |query: SpatialQuery<'_, '_>| {
            query.cast_ray(Vec3::ZERO, Dir3::X, f32::MAX, true, &filter)
        })
    };
    let hit = cast(&mut game, all.clone()).expect("the first ball");
    // The distance is a fraction of 1e9 m, with two roundings.
    assert!(hit.entity == first && near(hit.distance, 1.5, 1e-6), "{hit:?}");
    assert!((hit.normal + Vec3::X).length() < 1e-6 && (hit.point - Vec3::X * 1.5).length() < 1e-6);
    let without = SpatialQueryFilter::from_excluded_entities([first]);
    assert_eq!(cast(&mut game, without.clone()).map(|hit| hit.entity), Some(last));
    let with_sensors = without.with_sensors();
    assert_eq!(cast(&mut game, with_sensors).map(|hit| hit.entity), Some(sensor));
    let by_layer = SpatialQueryFilter::from_mask(2);
    assert_eq!(cast(&mut game, by_layer).map(|hit| hit.entity), Some(last));
    let hits = game.ask(move |query: SpatialQuery<'_, '_>| {
        query.ray_hits(Vec3::ZERO, Dir3::X, 100.0, 9, true, &all.clone().with_sensors())
    });
    assert_eq!(hits.iter().map(|hit| hit.entity).collect::<Vec<_>>(), [first, sensor, last]);
}

#[test]
fn a_predicate_and_an_excluded_body_hide_colliders() {
    let mut game = Game::new();
    let body = game.spawn((RigidBody::Static, at(0.0)));
    let near_one = game.spawn((Collider::sphere(0.5), at(2.0), ChildOf(body)));
    let far = game.spawn((Collider::sphere(0.5), at(4.0)));
    game.run(1);
    let found = game.ask(move |query: SpatialQuery<'_, '_>| {
        let all = SpatialQueryFilter::default();
        let one = query
            .cast_ray_predicate(Vec3::ZERO, Dir3::X, 9.0, true, &all, &|entity| entity != near_one);
        let others = SpatialQueryFilter::from_excluded_entities([body]);
        [one, query.cast_ray(Vec3::ZERO, Dir3::X, 9.0, true, &others)]
            .map(|hit| hit.map(|h| h.entity))
    });
    assert_eq!(found, [Some(far), Some(far)]);
}

#[test]
fn shapes_points_and_boxes_find_what_they_overlap() {
    let mut game = Game::new();
    let ball = game.spawn((Collider::sphere(0.5), at(2.0)));
    let cube = game.spawn((Collider::cuboid(1.0, 1.0, 1.0), at(3.0)));
    game.run(1);
    game.ask(move |query: SpatialQuery<'_, '_>| {
        let all = SpatialQueryFilter::default();
        let probe = Collider::sphere(0.25);
        let hit = query
            .cast_shape(&probe, Vec3::ZERO, Quat::IDENTITY, Dir3::X, 10.0, &all)
            .expect("the ball");
        assert!(hit.entity == ball && near(hit.distance, 1.25, 1e-4), "{hit:?}");
        let place = Vec3::X * 2.4;
        assert_eq!(query.shape_intersections(&probe, place, Quat::IDENTITY, &all), [ball, cube]);
        assert_eq!(query.point_intersections(Vec3::X * 3.2, &all), [cube]);
        let (low, high) = (Vec3::new(2.8, -1.0, -1.0), Vec3::new(9.0, 1.0, 1.0));
        assert_eq!(query.aabb_intersections(low, high, &all), [cube]);
        let near_point = query.project_point(Vec3::Y * 0.0, 9.0, &all).expect("near");
        assert!(near_point.entity == ball && near(near_point.point.x, 1.5, 1e-4));
        assert!(query.project_point(Vec3::X * 3.1, 9.0, &all).is_some_and(|p| p.is_inside));
        assert!(query.project_point(Vec3::ZERO, 1.0, &all).is_none());
        // Numbers that are none find nothing.
        assert!(query.cast_ray(Vec3::NAN, Dir3::X, 9.0, true, &all).is_none());
        assert!(query.point_intersections(Vec3::INFINITY, &all).is_empty());
    });
}

#[test]
fn a_query_sees_the_world_that_it_names() {
    let mut game = Game::new();
    let other = game.spawn(PhysicsWorld::default());
    let there = game.spawn((Collider::sphere(0.5), at(2.0), InWorld(other)));
    game.run(1);
    let find = |game: &mut Game, filter: SpatialQueryFilter| {
        game.ask(move |query: SpatialQuery<'_, '_>| {
            query.point_intersections(Vec3::X * 2.0, &filter)
        })
    };
    assert!(find(&mut game, SpatialQueryFilter::default()).is_empty());
    assert_eq!(find(&mut game, SpatialQueryFilter::default().in_world(other)), [there]);
    assert!(find(&mut game, SpatialQueryFilter::default().in_world(there)).is_empty());
}
