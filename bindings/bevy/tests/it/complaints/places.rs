//! Places, scales and what is shown.

use bevy_app::Update;
use bevy_drystone::{
    Collider, DrystonePlugin, Gravity, LinearVelocity, PhysicsCollider, RigidBody, Sensor,
};
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::prelude::{Component, Entity, Query, With, Without};
use bevy_math::{Quat, Vec3};
use bevy_time::TimeUpdateStrategy;
use bevy_transform::components::Transform;

use crate::game::{Game, HERTZ, near};

/// The place of the first shape of a collider in the world.
fn shape_at(game: &Game, collider: Entity) -> Vec3 {
    let shape = game.get::<PhysicsCollider>(collider).shapes()[0];
    let place = game.world().shape(shape).expect("its shape").pose().position;
    Vec3::new(place.x, place.y, place.z)
}

/// avian#741: a collider that is inserted later, below turned and scaled parents, is where its
/// entity is, whatever the moment.
#[test]
fn a_collider_that_comes_late_is_where_its_entity_is() {
    for wait in 0..4 {
        let mut game = Game::new();
        let turn = Quat::from_xyzw(
            0.0,
            core::f32::consts::FRAC_1_SQRT_2,
            0.0,
            core::f32::consts::FRAC_1_SQRT_2,
        );
        let top = game.spawn(Transform {
            translation: Vec3::new(3.0, 0.0, 0.0),
            rotation: turn,
            scale: Vec3::splat(2.0),
        });
        let mesh = game.spawn((Transform::from_xyz(1.0, 0.5, 0.0), ChildOf(top)));
        game.run(wait);
        game.insert(mesh, (RigidBody::Static, Collider::cuboid(1.0, 1.0, 1.0)));
        game.run(3);
        // A quarter about y takes x to -z; the parent doubles the offset. Three roundings.
        let error = shape_at(&game, mesh) - Vec3::new(3.0, 1.0, -2.0);
        assert!(error.length() < 9.0 * f32::EPSILON, "after {wait} steps: {error}");
        assert_eq!(game.place(mesh), Vec3::new(1.0, 0.5, 0.0), "its transform is the user's");
    }
}

/// avian#562: the parts of a compound are at their offsets, from the first step on.
#[test]
fn parts_of_a_compound_are_at_their_offsets() {
    let mut game = Game::new();
    let part = (Vec3::Y * 19.0, Quat::IDENTITY, Collider::capsule(1.2, 1.2));
    let body = game.spawn((RigidBody::Kinematic, Collider::compound([part])));
    for _ in 0..8 {
        game.run(1);
        assert_eq!(shape_at(&game, body), Vec3::Y * 19.0);
    }
}

/// bevy_rapier#188: in a fast fall, the transform and the shape have the same bits after each step.
#[test]
fn entity_and_shape_agree_in_a_fast_fall() {
    let mut game = Game::new();
    game.app.insert_resource(Gravity(Vec3::NEG_Y * 1000.0));
    let ball = game.spawn((RigidBody::Dynamic, Collider::sphere(0.5)));
    for _ in 0..64 {
        game.run(1);
        assert_eq!(shape_at(&game, ball), game.place(ball));
    }
    assert!(game.place(ball).y < -400.0, "half of 1000 m/s² for 1 s");
}

/// bevy_rapier#292: a sensor below a model turns with it.
#[test]
fn a_sensor_follows_the_rotation_of_its_parent() {
    let mut game = Game::new();
    let model = game.spawn(Transform::from_scale(Vec3::splat(0.5)));
    let blade = Collider::cuboid(0.75, 0.75, 0.25);
    let at = Transform::from_xyz(0.0, 0.75, 0.8);
    let blade = game.spawn((Sensor, blade, at, ChildOf(model)));
    game.run(1);
    game.change::<Transform>(model, |place| place.rotation = Quat::from_xyzw(0.0, 1.0, 0.0, 0.0));
    game.run(1);
    let error = shape_at(&game, blade) - Vec3::new(0.0, 0.375, -0.4);
    assert!(error.length() < 4.0 * f32::EPSILON, "{error}");
}

/// avian#851: another collider on a scaled entity is scaled too.
#[test]
fn another_collider_keeps_the_scale() {
    let mut game = Game::new();
    let place = Transform::from_scale(Vec3::splat(2.0));
    let body = game.spawn((RigidBody::Dynamic, Collider::cuboid(1.0, 1.0, 1.0), place));
    game.run(1);
    game.insert(body, Collider::cuboid(1.0, 1.0, 2.0));
    game.run(1);
    // 2 m by 2 m by 4 m of 1000 kg/m³.
    assert!(near(game.body(body).mass(), 16_000.0, 0.1), "{}", game.body(body).mass());
}

/// avian#479, bevy_rapier#243: under a large scale, colliders of children are apart by the scaled
/// offset, and the center of mass lies between them.
#[test]
fn a_large_scale_moves_children_and_the_center_of_mass() {
    let mut game = Game::new();
    let body = game.spawn((RigidBody::Kinematic, Transform::from_scale(Vec3::splat(10.0))));
    let cube = || Collider::cuboid(1.0, 1.0, 1.0);
    game.spawn((cube(), ChildOf(body)));
    let far = game.spawn((cube(), Transform::from_xyz(2.0, 0.0, 0.0), ChildOf(body)));
    game.run(1);
    assert_eq!(shape_at(&game, far), Vec3::X * 20.0);
    game.app.insert_resource(Gravity::ZERO);
    game.insert(body, RigidBody::Dynamic);
    game.run(1);
    let center = game.body(body).center_of_mass();
    assert!(near(center.x, 10.0, 40.0 * f32::EPSILON), "{center:?}");
}

#[derive(Component)]
struct Eye;

/// The distances that a body at 1 m a step is shown to move in frames of this many steps, and
/// whether a camera that follows it in `Update` is where it is.
fn shown(steps_a_frame: f32) -> (Vec<f32>, bool) {
    let mut game = Game::with(DrystonePlugin::default().with_threads(1));
    game.app.insert_resource(Gravity::ZERO);
    let speed = LinearVelocity(Vec3::X * HERTZ);
    let body = game.spawn((RigidBody::Dynamic, Collider::sphere(0.5), speed));
    let eye = game.spawn((Eye, Transform::IDENTITY));
    let follow =
        |bodies: Query<'_, '_, &Transform, With<RigidBody>>,
         mut eyes: Query<'_, '_, &mut Transform, (With<Eye>, Without<RigidBody>)>| {
            for (body, mut eye) in bodies.iter().zip(&mut eyes) {
                eye.translation = body.translation;
            }
        };
    game.app.add_systems(Update, follow);
    let frame = core::time::Duration::from_secs_f32(steps_a_frame / HERTZ);
    game.app.insert_resource(TimeUpdateStrategy::ManualDuration(frame));
    (0..8).for_each(|_| game.app.update());
    let (mut last, mut ways, mut follows) = (game.place(body).x, Vec::new(), true);
    for _ in 0..32 {
        game.app.update();
        let now = game.place(body).x;
        ways.push(now - last);
        last = now;
        follows &= game.place(eye).x.to_bits() == now.to_bits();
    }
    (ways, follows)
}

/// bevy_rapier#464, #638, avian#673: with frames shorter and longer than steps, also with several
/// steps a frame, a body is shown to move evenly.
#[test]
fn motion_is_shown_evenly_at_any_frame_rate() {
    for steps in [0.375_f32, 0.75, 1.25, 2.5] {
        let (ways, _) = shown(steps);
        // Places of up to 100 m have 2^-17 m of rounding, and the clock counts whole nanoseconds:
        // 64 of them are 4 µm at 64 m/s.
        let even = |way: &f32| near(*way, steps, 1.0e-4);
        assert!(ways.iter().all(even), "{steps}: {ways:?}");
    }
}

/// avian#211: a camera that follows in `Update` is where the body is shown, in every frame.
#[test]
fn a_camera_that_follows_in_update_does_not_lag() {
    for steps in [0.375_f32, 0.75, 1.25, 2.5] {
        assert!(shown(steps).1, "{steps}");
    }
}
