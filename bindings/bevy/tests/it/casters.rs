//! Rays and shape casts as components.

use bevy_drystone::{Collider, Gravity, RayCaster, RayHits, RigidBody, ShapeCaster, ShapeHits};
use bevy_ecs::hierarchy::ChildOf;
use bevy_math::{Dir3, Quat, Vec3};
use bevy_transform::components::Transform;

use crate::game::{Game, near};

/// A kinematic tower turns by a quarter about y; its gun, a child, then aims at another wall.
#[test]
fn a_ray_goes_along_with_its_entity() {
    let mut game = Game::new();
    let walls = [Vec3::X * 5.0, Vec3::NEG_Z * 8.0]
        .map(|at| game.spawn((Collider::cuboid(1.0, 1.0, 1.0), Transform::from_translation(at))));
    let tower = game.spawn((RigidBody::Kinematic, Collider::cuboid(2.0, 2.0, 2.0)));
    let gun = RayCaster::new(Vec3::ZERO, Dir3::X).with_max_distance(20.0);
    let gun = game.spawn((gun, Transform::from_xyz(0.5, 0.0, 0.0), ChildOf(tower)));
    game.run(1);
    let hits = &game.get::<RayHits>(gun).0;
    assert_eq!(hits.iter().map(|hit| hit.entity).collect::<Vec<_>>(), [walls[0]]);
    // From 0.5 m to 4.5 m; a fraction of 20 m.
    assert!(near(hits[0].distance, 4.0, 40.0 * f32::EPSILON), "{hits:?}");
    let half = core::f32::consts::FRAC_1_SQRT_2;
    game.change::<Transform>(tower, |place| place.rotation = Quat::from_xyzw(0.0, half, 0.0, half));
    game.run(1);
    let hits = &game.get::<RayHits>(gun).0;
    assert_eq!(hits.iter().map(|hit| hit.entity).collect::<Vec<_>>(), [walls[1]]);
    game.change::<RayCaster>(gun, |ray| ray.ignore_self = false);
    game.run(1);
    let hits = &game.get::<RayHits>(gun).0;
    assert_eq!(hits.iter().map(|hit| hit.entity).collect::<Vec<_>>(), [tower, walls[1]]);
    game.change::<RayCaster>(gun, |ray| ray.enabled = false);
    game.run(1);
    assert!(game.get::<RayHits>(gun).0.is_empty());
}

/// A ball of 0.5 m that is cast down from a body at 3 m meets the ground after 2.5 m.
#[test]
fn a_shape_is_cast_from_where_its_entity_is() {
    let mut game = Game::on_ground();
    game.app.insert_resource(Gravity::ZERO);
    let body = game.cube([0.0, 3.0, 0.0]);
    let foot = ShapeCaster::new(Collider::sphere(0.5), Vec3::ZERO, Quat::IDENTITY, Dir3::NEG_Y);
    game.insert(body, foot.with_max_distance(4.0));
    game.run(1);
    let hit = game.get::<ShapeHits>(body).0.expect("the ground");
    // Some roundings of a fraction of 4 m.
    assert!(near(hit.distance, 2.5, 8.0 * 4.0 * f32::EPSILON), "{hit:?}");
    assert!(near(hit.normal.y, 1.0, 4.0 * f32::EPSILON), "{hit:?}");
    game.change::<Transform>(body, |place| place.translation.y = 9.0);
    game.run(1);
    assert_eq!(game.get::<ShapeHits>(body).0, None);
}
