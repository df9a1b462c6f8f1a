//! Panics where something leaves, or is not there yet.

use bevy_drystone::{
    Collider, CollisionStart, DrystonePlugin, InWorld, JointMotor, LinearVelocity, PhysicsJoint,
    PhysicsWorld, RevoluteJoint, RigidBody, RigidBodyDisabled, SphericalJoint,
};
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::observer::On;
use bevy_ecs::prelude::{Commands, Entity};
use bevy_math::Vec3;
use bevy_time::TimeUpdateStrategy;
use bevy_transform::components::Transform;

use crate::game::{Game, HERTZ, near};

/// avian#835: a hinge and both its bodies below one parent, which goes.
#[test]
fn a_parent_of_bodies_and_their_joint_may_go() {
    let mut game = Game::new();
    let parent = game.spawn(Transform::IDENTITY);
    let (a, b) = (game.cube([0.0; 3]), game.cube([2.0, 0.0, 0.0]));
    let hinge = game.spawn(RevoluteJoint::new(a, b).at(Vec3::X));
    for entity in [a, b, hinge] {
        game.insert(entity, ChildOf(parent));
    }
    game.run(8);
    assert_eq!((game.world().counts().dynamic, game.world().counts().joints), (2, 1));
    game.despawn(parent);
    game.run(2);
    assert_eq!((game.world().counts().dynamic, game.world().counts().joints), (0, 0));
    game.check();
}

/// avian#978: a joint whose second end gets its body later.
#[test]
fn a_joint_waits_for_an_end_without_a_body() {
    let mut game = Game::new();
    let a = game.cube([0.0; 3]);
    let b = game.spawn(Transform::from_xyz(2.0, 0.0, 0.0));
    let hinge = game.spawn(RevoluteJoint::new(a, b).at(Vec3::X));
    game.run(1);
    assert!(game.get::<PhysicsJoint>(hinge).joint().is_none());
    game.insert(b, (RigidBody::Dynamic, Collider::cuboid(1.0, 1.0, 1.0)));
    game.run(1);
    assert!(game.get::<PhysicsJoint>(hinge).joint().is_some());
    game.check();
}

/// avian#919: terrain whose collider is made anew in every step, under a body on a joint.
#[test]
fn a_static_collider_may_be_made_anew_in_every_step() {
    let mut game = Game::new();
    let ground =
        game.spawn((Collider::cuboid(20.0, 1.0, 20.0), Transform::from_xyz(0.0, -0.5, 0.0)));
    let (a, b) = (game.cube([0.0, 0.5, 0.0]), game.cube([1.5, 0.5, 0.0]));
    game.spawn(bevy_drystone::DistanceJoint::new(a, b, 1.5));
    for k in 0..64_u8 {
        game.insert(ground, Collider::cuboid(20.0 + f32::from(k), 1.0, 20.0));
        game.run(1);
    }
    // Contacts sink in by at most 5 mm.
    assert!(near(game.place(a).y, 0.5, 0.005) && near(game.place(b).y, 0.5, 0.005));
    game.check();
}

/// avian#946, Cosmos#282: an observer despawns what was hit, in the step of the hit.
#[test]
fn a_hit_may_despawn_the_body_that_was_hit() {
    let mut game = Game::on_ground();
    let targets: Vec<Entity> =
        [0.0_f32, 1.1, 2.2].into_iter().map(|y| game.cube([0.0, 0.5 + y, 0.0])).collect();
    for target in &targets {
        game.app.world_mut().entity_mut(*target).observe(
            |start: On<'_, '_, CollisionStart>, mut commands: Commands<'_, '_>| {
                commands.entity(start.collider1).try_despawn();
            },
        );
    }
    game.run(64);
    assert_eq!(game.world().counts().dynamic, 0, "each touched something");
    game.check();
}

/// avian#950: a ragdoll of nested bodies, touching the ground, goes at once.
#[test]
fn a_hierarchy_of_jointed_bodies_goes_at_once() {
    let mut game = Game::on_ground();
    let top = game.cube([0.0, 0.5, 0.0]);
    let mut above = top;
    for _ in 0..6 {
        let limb = game.cube([1.2, 0.0, 0.0]);
        game.insert(limb, ChildOf(above));
        let joint = game.spawn(
            SphericalJoint::new(above, limb).with_local_anchors(Vec3::X * 0.6, Vec3::X * -0.6),
        );
        game.insert(joint, ChildOf(limb));
        above = limb;
    }
    game.run(64);
    assert_eq!((game.world().counts().dynamic, game.world().counts().joints), (7, 6));
    game.despawn(top);
    game.run(2);
    assert_eq!((game.world().counts().dynamic, game.world().counts().joints), (0, 0));
    game.check();
}

/// avian#1067: a body that was disabled falls on a mesh.
#[test]
fn a_body_that_was_disabled_lands_on_a_mesh() {
    let mut game = Game::new();
    let far = 10.0;
    let corners = [(-far, -far), (-far, far), (far, far), (far, -far)];
    let corners = corners.map(|(x, z)| Vec3::new(x, 0.0, z));
    let floor = Collider::trimesh(&corners, vec![[0, 1, 2], [0, 2, 3]]).expect("two triangles");
    game.spawn(floor);
    let cube = game.cube([0.0, 0.55, 0.0]);
    game.insert(cube, RigidBodyDisabled);
    game.run(32);
    assert!(near(game.place(cube).y, 0.55, 0.0), "it waits");
    game.remove::<RigidBodyDisabled>(cube);
    game.run(64);
    assert!(near(game.place(cube).y, 0.5, 0.005), "{}", game.place(cube));
}

/// avian#707: a transform that is no number is refused by name, and the world goes on.
#[test]
fn a_transform_that_is_no_number_is_refused() {
    let mut game = Game::on_ground();
    let (bad, good) = (game.cube([0.0, 0.5, 0.0]), game.cube([5.0, 3.0, 0.0]));
    let part = game.spawn((Collider::sphere(0.2), ChildOf(bad)));
    game.run(1);
    game.faults();
    game.change::<Transform>(part, |place| place.translation.x = f32::NAN);
    game.change::<Transform>(bad, |place| place.translation.y = f32::NAN);
    game.run(1);
    assert!(!game.faults().is_empty());
    game.run(128);
    assert!(near(game.place(good).y, 0.5, 0.005));
    assert!(game.body(bad).position().is_finite());
    game.check();
}

/// Cosmos#402: the world of bodies goes before they do.
#[test]
fn a_world_may_go_before_its_bodies() {
    let mut game = Game::new();
    let other = game.spawn(PhysicsWorld::default());
    let cubes = [0.0, 3.0].map(|x| game.cube([x, 0.0, 0.0]));
    for cube in cubes {
        game.insert(cube, InWorld(other));
    }
    let motor = JointMotor::Speed { target: 1.0, max_force: 10.0 };
    game.spawn(RevoluteJoint::new(cubes[0], cubes[1]).at(Vec3::X).with_motor(motor));
    game.run(4);
    game.despawn(other);
    game.run(2);
    assert!(game.faults().iter().any(|text| text.contains("InWorld")));
    game.check();
    game.remove::<InWorld>(cubes[0]);
    game.run(2);
    assert_eq!(game.world().counts().dynamic, 1, "it is in the default world now");
    game.check();
}

/// bevy_rapier#285: bodies go while they touch, with interpolation and frames of several steps.
#[test]
fn bodies_go_between_frames_of_several_steps() {
    let mut game = Game::with(DrystonePlugin::default().with_threads(1));
    game.spawn(Collider::half_space(Vec3::Y));
    let frame = core::time::Duration::from_secs_f32(2.5 / HERTZ);
    game.app.insert_resource(TimeUpdateStrategy::ManualDuration(frame));
    let mut cubes: Vec<Entity> = Vec::new();
    for k in 0..40_u8 {
        let cube = game.cube([f32::from(k % 3) * 0.9, 0.6 + 1.1 * f32::from(k % 2), 0.0]);
        game.insert(cube, LinearVelocity(Vec3::NEG_Y * 10.0));
        cubes.push(cube);
        if k % 2 == 1 {
            let gone = cubes.remove(0);
            game.despawn(gone);
        }
        game.app.update();
        game.check();
    }
    assert_eq!(game.world().counts().dynamic, cubes.len());
}
