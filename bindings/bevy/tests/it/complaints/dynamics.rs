//! Joints, friction, sleep, and seams between shapes.

use bevy_drystone::{
    Collider, DistanceJoint, Friction, Gravity, KineticFriction, LinearDamping, LinearVelocity,
    Mass, RevoluteJoint, RigidBody,
};
use bevy_ecs::prelude::Entity;
use bevy_math::{Quat, Vec3};
use bevy_transform::components::Transform;

use crate::game::{Game, HERTZ, near};

/// The angle by which a body is turned about z [rad].
fn angle(game: &Game, body: Entity) -> f32 {
    let turn = game.get::<Transform>(body).rotation;
    2.0 * drystone::math::trig::atan2(turn.z, turn.w)
}

/// avian#886: a pinball flipper of 71 mm and 1 g or less, with limits of its angle.
#[test]
fn a_light_flipper_stays_within_its_limits() {
    for mass in [0.01, 0.001, 0.0001] {
        let mut game = Game::new();
        let wall = game.spawn(RigidBody::Static);
        let blade = Collider::cuboid(0.071, 0.018, 0.018);
        let at = Transform::from_xyz(0.0355, 0.0, 0.0);
        let flipper = game.spawn((RigidBody::Dynamic, blade, Mass(mass), at));
        let hinge = RevoluteJoint::new(wall, flipper).at(Vec3::ZERO).with_axis(Vec3::Z);
        game.spawn(hinge.with_angle_limits(-0.5, 0.5));
        for _ in 0..256 {
            game.run(1);
            let now = angle(&game, flipper);
            // At rest on the stop. Before, a step at the speed of the fall is within the limit.
            assert!(now > -0.55 && now < 0.05, "{mass} kg: {now}");
        }
        // A stop gives way by at most the angle of 5 mm at its end.
        assert!(near(angle(&game, flipper), -0.5, 0.005 / 0.071), "{}", angle(&game, flipper));
    }
}

/// avian#553: a chain of ten, damped so that it comes to rest, on its angle limits. They hold the
/// weight below them, and give way by no more than it over their stiffness.
#[test]
fn gravity_does_not_break_the_limits_of_a_chain() {
    let mut game = Game::new();
    let mut above = game.spawn(RigidBody::Kinematic);
    let mut links = Vec::new();
    for k in 1..=10_u8 {
        let at = Transform::from_xyz(f32::from(k), 0.0, 0.0);
        let beam = Collider::cuboid(0.8, 0.2, 0.2);
        let link = game.spawn((RigidBody::Dynamic, beam, LinearDamping(2.0), at));
        let pin = Vec3::X * (f32::from(k) - 0.5);
        let hinge = RevoluteJoint::new(above, link).at(pin).with_axis(Vec3::Z);
        game.spawn(hinge.with_angle_limits(-0.2, 0.2));
        links.push(link);
        above = link;
    }
    game.run(640);
    let mut before = 0.0;
    for (k, link) in links.iter().enumerate() {
        let now = angle(&game, *link);
        let bend = (now - before).abs();
        before = now;
        let give = load(&game, &links, k) / stiffness(&game, *link);
        assert!(bend < 0.2 + give && give < 0.2, "joint {k}: {bend}, give {give}");
    }
}

/// The torque of the links from number `k` on about the pin before them [N m].
fn load(game: &Game, links: &[Entity], k: usize) -> f32 {
    let turn = game.get::<Transform>(links[k]).rotation;
    let pin = (game.place(links[k]) - turn * Vec3::X * 0.5).x;
    let torque = |link: &Entity| game.body(*link).mass() * 9.81 * (game.place(*link).x - pin);
    links[k..].iter().map(torque).sum::<f32>().abs()
}

/// The least stiffness of a stop between two links [N m/rad]: a frequency of 0.15 per substep, with
/// at least 4 substeps, of the two moments of inertia in series.
fn stiffness(game: &Game, link: Entity) -> f32 {
    let turns = core::f32::consts::TAU * 0.15 * HERTZ * 4.0;
    let moment = game.body(link).mass() * (0.8_f32.powi(2) + 0.2_f32.powi(2)) / 12.0;
    0.5 * moment * turns * turns
}

/// avian#875: two bodies farther apart than a joint allows come nearer, and stay on their sides.
#[test]
fn a_stretched_joint_pulls_bodies_together_without_a_swap() {
    let mut game = Game::new();
    game.app.insert_resource(Gravity::ZERO);
    let [a, b] = [[-5.0, 1.0, 0.0], [5.0, -1.0, 0.0]].map(|at| {
        let place = Transform::from_translation(Vec3::from_array(at));
        game.spawn((RigidBody::Dynamic, Collider::sphere(0.5), place))
    });
    game.spawn(DistanceJoint::new(a, b, 4.0).with_limits(2.0, 4.0));
    for _ in 0..256 {
        game.run(1);
        let (left, right) = (game.place(a), game.place(b));
        assert!(left.x < 0.0 && left.y > 0.0 && right.x > 0.0 && right.y < 0.0, "{left} {right}");
    }
    let apart = (game.place(a) - game.place(b)).length();
    assert!((1.99..=4.01).contains(&apart), "{apart}");
}

/// avian#853: terrain that is made anew lower wakes what slept on it.
#[test]
fn changed_terrain_wakes_what_slept_on_it() {
    let mut game = Game::new();
    let ground = game.spawn(Collider::cuboid(10.0, 2.0, 10.0));
    let cubes = [1.5, 2.5].map(|y| game.cube([0.0, y, 0.0]));
    game.run(256);
    assert!(cubes.iter().all(|cube| game.body(*cube).is_asleep()));
    game.insert(ground, Collider::cuboid(10.0, 1.0, 10.0));
    game.run(128);
    // Half a meter lower; contacts sink in by at most 5 mm each.
    assert!(near(game.place(cubes[0]).y, 1.0, 0.005), "{}", game.place(cubes[0]));
    assert!(near(game.place(cubes[1]).y, 2.0, 0.01), "{}", game.place(cubes[1]));
}

/// avian#543: on a slope of tan 0.45, a static friction of 0.6 holds a box; once it moves, the
/// kinetic one of 0.2 lets it slide on.
#[test]
fn static_friction_holds_and_kinetic_friction_lets_slide() {
    let slope = 0.45_f32.atan();
    let turn = Quat::from_rotation_z(-slope);
    let mut game = Game::new();
    let surface = (Friction::new(0.6), KineticFriction(0.2));
    game.spawn((Collider::half_space(turn * Vec3::Y), surface));
    let [still, pushed] = [0.0, 5.0].map(|z| {
        let place = Transform {
            translation: turn * Vec3::new(0.0, 0.5, 0.0),
            rotation: turn,
            ..Transform::IDENTITY
        };
        let place = place.with_translation(place.translation + Vec3::Z * z);
        game.spawn((RigidBody::Dynamic, Collider::cuboid(1.0, 1.0, 1.0), place, surface))
    });
    game.change::<LinearVelocity>(pushed, |v| v.0 = turn * Vec3::X);
    game.run(64);
    let speed = game.get::<LinearVelocity>(pushed).0.length();
    let (sin, cos) = drystone::math::trig::sin_cos(slope);
    // 1 m/s, and g (sin - 0.2 cos) for 1 s; the first step may still stick: g dt of it.
    let slides = 1.0 + 9.81 * (sin - 0.2 * cos);
    assert!(near(speed, slides, 9.81 / HERTZ + 0.01 * slides), "{speed} {slides}");
    assert!(game.get::<LinearVelocity>(still).0.length() < 0.01);
}

/// A box that slides over seams without friction keeps its height and its speed.
fn slides_evenly(game: &mut Game) {
    let place = Transform::from_xyz(-8.0, 0.5, 0.13);
    let bundle = (RigidBody::Dynamic, Collider::cuboid(1.0, 1.0, 1.0), place, Friction::ZERO);
    let cube = game.spawn((bundle, LinearVelocity(Vec3::X * 5.0)));
    game.run(16);
    for _ in 0..160 {
        game.run(1);
        let (at, speed) = (game.place(cube), game.get::<LinearVelocity>(cube).0);
        // Contacts sink in by at most 5 mm; a bump would lift the box, or slow it.
        assert!(near(at.y, 0.5, 0.005), "{at}");
        assert!(near(speed.x, 5.0, 0.005) && near(speed.y, 0.0, 0.05), "at {at}: {speed}");
    }
}

/// avian#612: separate boxes side by side make smooth ground.
#[test]
fn seams_between_tiles_do_not_bump() {
    let mut game = Game::new();
    for x in -10..10_i8 {
        for z in -2..3_i8 {
            let place = Transform::from_xyz(f32::from(x), -0.5, f32::from(z));
            game.spawn((Collider::cuboid(1.0, 1.0, 1.0), place, Friction::ZERO));
        }
    }
    slides_evenly(&mut game);
}

/// avian#705: the inner edges of a mesh make smooth ground.
#[test]
fn inner_edges_of_a_mesh_do_not_bump() {
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    for x in -10..=10_i8 {
        points.extend((-2..=2_i8).map(|z| Vec3::new(f32::from(x), 0.0, f32::from(z))));
    }
    for x in 0..20_u32 {
        for z in 0..4 {
            let k = 5 * x + z;
            triangles.extend([[k, k + 1, k + 6], [k, k + 6, k + 5]]);
        }
    }
    let mut game = Game::new();
    game.spawn((Collider::trimesh(&points, triangles).expect("a grid"), Friction::ZERO));
    slides_evenly(&mut game);
}
