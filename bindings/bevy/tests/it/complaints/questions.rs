//! Queries and characters.

use bevy_drystone::{
    CharacterMover, CharacterSettings, Collider, PhysicsTime, RigidBody, SpatialQuery,
    SpatialQueryFilter,
};
use bevy_math::{Dir3, Quat, Vec3};
use bevy_transform::components::Transform;

use crate::game::{Game, HERTZ, near};

/// avian#1011: a ray meets infinite ground at every angle down to a hundredth.
#[test]
fn a_ray_meets_infinite_ground_at_any_angle() {
    let mut game = Game::new();
    game.spawn((Collider::half_space(Vec3::Y), Transform::from_xyz(0.0, -1.0, 0.0)));
    game.run(1);
    for k in 0..360_u16 {
        let about = f32::from(k).to_radians();
        for fall in [0.01_f32, 0.1, 1.0, 10.0] {
            let (sin, cos) = drystone::math::trig::sin_cos(about);
            let way = Vec3::new(cos, -fall, sin);
            let direction = Dir3::new(way).expect("a direction");
            let from = Vec3::new(3.0, 2.0, -7.0);
            let hit = game.ask(move |query: SpatialQuery<'_, '_>| {
                query.cast_ray(from, direction, 1000.0, true, &SpatialQueryFilter::default())
            });
            let distance = 3.0 * way.length() / fall;
            let hit = hit.expect("the ground");
            assert!(near(hit.distance, distance, 1.0e-4 * distance), "{k} {fall}: {hit:?}");
        }
    }
}

/// avian#969: while physics is paused, queries see what the user moves.
#[test]
fn queries_see_moves_while_physics_is_paused() {
    let mut game = Game::on_ground();
    let cube = game.cube([0.0, 5.0, 0.0]);
    game.run(1);
    game.app.world_mut().resource_mut::<PhysicsTime>().paused = true;
    for k in 1..8_u8 {
        let x = 3.0 * f32::from(k);
        game.change::<Transform>(cube, |place| place.translation = Vec3::new(x, 5.0, 0.0));
        game.app.update();
        let hit = game.ask(move |query: SpatialQuery<'_, '_>| {
            let from = Vec3::new(x, 9.0, 0.0);
            query.cast_ray(from, Dir3::NEG_Y, 20.0, true, &SpatialQueryFilter::default())
        });
        let hit = hit.expect("the cube");
        assert_eq!(hit.entity, cube, "at {x}");
        assert!(near(hit.distance, 3.5, 1.0e-5), "{hit:?}");
    }
}

/// Walks a capsule by this velocity [m/s] for 2 s. Returns where it is.
fn walk(game: &mut Game, from: Vec3, velocity: Vec3) -> Vec3 {
    game.run(1);
    let mut at = from;
    for _ in 0..128 {
        at = game.ask(move |mover: CharacterMover<'_, '_>| {
            let (body, settings) = (Collider::capsule(0.3, 1.0), CharacterSettings::default());
            let all = SpatialQueryFilter::default();
            let moved = mover.move_by(&body, at, Quat::IDENTITY, velocity / HERTZ, &settings, &all);
            moved.expect("numbers in range").position
        });
    }
    at
}

/// bevy_rapier#534: a character that walks against a slope of 60° does not rise on it, and climbs
/// one of 30°.
#[test]
fn a_character_climbs_no_slope_above_its_limit() {
    for (degrees, climbs) in [(60.0_f32, false), (30.0, true)] {
        let mut game = Game::on_ground();
        let turn = Quat::from_rotation_z(degrees.to_radians());
        let slab = Collider::cuboid(20.0, 1.0, 6.0);
        let place = Transform {
            rotation: turn,
            translation: turn * Vec3::new(10.0, -0.5, 0.0),
            ..Transform::IDENTITY
        };
        game.spawn((RigidBody::Static, slab, place));
        let at = walk(&mut game, Vec3::new(-2.0, 0.81, 0.0), Vec3::new(2.0, -1.0, 0.0));
        // It stops at the foot, within its step of 0.3 m, or rises by a half of 1 m.
        assert_eq!(at.y > 1.3, climbs, "{degrees}: {at}");
    }
}

/// bevy_rapier#489: a character that walks into a wall at 45° slides along it.
#[test]
fn a_character_slides_along_a_wall() {
    let mut game = Game::on_ground();
    game.spawn((Collider::cuboid(1.0, 4.0, 40.0), Transform::from_xyz(1.5, 2.0, 0.0)));
    let at = walk(&mut game, Vec3::new(0.0, 0.81, 0.0), Vec3::new(2.0, -1.0, 2.0));
    assert!(near(at.x, 0.69, 0.01), "{at}");
    assert!(near(at.z, 4.0, 0.1), "2 m/s along the wall for 2 s: {at}");
}
