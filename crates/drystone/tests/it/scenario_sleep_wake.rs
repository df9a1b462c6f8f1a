//! Sleeping and waking: what moves on, is driven or is pulled does not sleep however slow it is; what rests does, as soon
//! as can be told; and it wakes when something happens to it (docs/decisions/030-what-may-sleep.md).

use std::sync::Arc;

use drystone::audit::AwakeCause;
use drystone::joint::{
    Ball, CouplingDef, Distance, Hinge, JointAxis, JointDrive, JointMotion, JointSpring, Pulley,
    Servo, SixDof, Slider, Spring,
};
use drystone::particle::{LinkDef, LinkKind, ParticleDef};
use drystone::{
    BodyDef, BodyId, BodyKind, JointDef, JointKind, Mesh, Pose, Quat, Shape, ShapeDef, Vec3, World,
    WorldConfig, vec3,
};

use crate::floors::{self, FLOORS, Floor};

const SCALES: [f32; 4] = [0.01, 0.1, 1.0, 100.0];
const RATES: [f32; 3] = [30.0, 60.0, 240.0];

/// Time until sleep of the default configuration [s], and between two looks at a body that is slow.
const SLEEP: f32 = 0.5;
const LOOK: f32 = 0.2;

fn mesh(vertices: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> ShapeDef {
    ShapeDef::new(Shape::Mesh(Arc::new(Mesh::new(vertices, triangles).unwrap())))
}

/// Ground with its surface at the origin.
fn ground(world: &mut World, floor: Floor, size: f32) -> BodyId {
    floors::ground(world, floor, [50.0 * size, size])
}

fn pulled(gravity: Vec3) -> World {
    World::new(WorldConfig { gravity, ..WorldConfig::default() }).unwrap()
}

fn cube(world: &mut World, at: Vec3, side: f32) -> BodyId {
    let shape = ShapeDef::box_half([0.5 * side; 3]);
    world.add_body(BodyDef::dynamic().with_position(at).with_shape(shape)).unwrap()
}

/// Steps in this time.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some thousands")]
fn steps(rate: f32, seconds: f32) -> u32 {
    (seconds * rate).round() as u32
}

fn run(world: &mut World, rate: f32, seconds: f32) {
    (0..steps(rate, seconds)).for_each(|_| world.step(1.0 / rate));
}

/// Gravity of a slope that goes down along x by this angle [degrees], told in its frame.
fn slope(degrees: f32) -> Vec3 {
    Quat::from_axis_angle(Vec3::Z, degrees.to_radians()).rotate(vec3(0.0, -9.81, 0.0))
}

fn at(world: &World, body: BodyId) -> Vec3 {
    world.body(body).unwrap().position()
}

fn sleeps(world: &World, body: BodyId) -> bool {
    world.body(body).unwrap().is_asleep()
}

fn all_sleep(world: &World) -> bool {
    world.bodies().all(|body| body.kind() != BodyKind::Dynamic || body.is_asleep())
}

/// Seconds until all sleep, if that is in this time.
fn until_sleep(world: &mut World, rate: f32, most: f32) -> Option<f32> {
    for step in 1..=steps(rate, most) {
        world.step(1.0 / rate);
        if all_sleep(world) {
            return Some(step as f32 / rate);
        }
    }
    None
}

fn cause(world: &World, body: BodyId) -> AwakeCause {
    world.why_awake(body).unwrap().cause
}

#[test]
fn what_a_slow_lift_or_raft_carries_goes_with_it() {
    for size in SCALES {
        for rate in RATES {
            for speed in [0.045_f32, 0.001] {
                for way in [Vec3::Y, -Vec3::Y, Vec3::X] {
                    let mut world = World::default();
                    let floor = ShapeDef::box_half(vec3(1.0, 0.1, 1.0) * size);
                    let lift = BodyDef::kinematic().with_position([0.0, -0.1 * size, 0.0]);
                    let lift = world.add_body(lift.with_shape(floor)).unwrap();
                    let load = cube(&mut world, vec3(0.0, 0.25, 0.0) * size, 0.5 * size);
                    run(&mut world, rate, 2.0);
                    assert!(sleeps(&world, load), "on a lift that stands");
                    let before = at(&world, load) - at(&world, lift);
                    world.body_mut(lift).unwrap().set_linear_velocity(way * speed);
                    for _ in 0..steps(rate, 4.0) {
                        world.step(1.0 / rate);
                        assert!(!sleeps(&world, load), "size {size}, {rate} Hz, {way:?} {speed}");
                    }
                    // A soft contact gives by less than a millimeter; left behind it would be off by all of the way.
                    let off = (at(&world, load) - at(&world, lift) - before).length();
                    assert!(
                        off < 0.1 * 4.0 * speed + 1.0e-4,
                        "off {off}: {size}, {rate}, {way:?} {speed}"
                    );
                    let why = cause(&world, load);
                    assert_eq!(why, AwakeCause::Carried { by: lift });
                    world.body_mut(lift).unwrap().set_linear_velocity(Vec3::ZERO);
                    run(&mut world, rate, 2.0);
                    assert!(sleeps(&world, load), "on a lift that stands again: {size}, {rate} Hz");
                }
            }
        }
    }
}

#[test]
fn a_slow_door_pushes_what_stands_before_it() {
    for (size, rate) in [(0.1_f32, 60.0_f32), (1.0, 30.0), (1.0, 240.0), (10.0, 60.0)] {
        let mut world = World::default();
        ground(&mut world, Floor::Box, size);
        let leaf = ShapeDef::box_half(vec3(0.1, 0.5, 1.0) * size);
        let door = BodyDef::kinematic().with_position(vec3(-0.355, 0.51, 0.0) * size);
        let door = world.add_body(door.with_shape(leaf)).unwrap();
        let load = cube(&mut world, vec3(0.0, 0.25, 0.0) * size, 0.5 * size);
        run(&mut world, rate, 2.0);
        // A gap of half a hundredth, then as much again.
        let (gap, speed) = (0.005 * size, 0.001 * size);
        world.body_mut(door).unwrap().set_linear_velocity([speed, 0.0, 0.0]);
        run(&mut world, rate, 10.0);
        let moved = at(&world, load).x;
        assert!(
            (moved - (10.0 * speed - gap)).abs() < 0.2 * gap + 1.0e-4,
            "{moved}: {size}, {rate}"
        );
    }
}

#[test]
fn a_slow_turntable_turns_what_stands_on_it() {
    for size in SCALES {
        for speed in [0.04_f32, 2.0e-3] {
            let mut world = World::default();
            let plate = ShapeDef::cylinder(0.1 * size, 2.0 * size);
            let table = BodyDef::kinematic()
                .with_position([0.0, -0.1 * size, 0.0])
                .with_angular_velocity([0.0, speed, 0.0]);
            world.add_body(table.with_shape(plate)).unwrap();
            let load = cube(&mut world, vec3(0.5, 0.25, 0.0) * size, 0.5 * size);
            run(&mut world, 60.0, 10.0);
            let turn = world.body(load).unwrap().rotation().to_rotation_vector().y;
            assert!(
                !sleeps(&world, load) && (turn - 10.0 * speed).abs() < 0.5 * speed,
                "{turn}: {size}"
            );
        }
    }
}

#[test]
fn a_slow_belt_carries_and_what_a_wall_holds_on_it_sleeps() {
    for (size, speed) in [(0.1_f32, 0.04_f32), (1.0, 0.04), (1.0, 0.002), (100.0, 0.002)] {
        for held in [false, true] {
            let mut world = World::default();
            let belt = ShapeDef::box_half(vec3(20.0, 1.0, 20.0) * size);
            let belt = belt.with_position([0.0, -size, 0.0]);
            let belt = ShapeDef { surface_velocity: vec3(speed, 0.0, 0.0), ..belt };
            let belt = world.add_body(BodyDef::fixed().with_shape(belt)).unwrap();
            let load = cube(&mut world, vec3(0.0, 0.25, 0.0) * size, 0.5 * size);
            if held {
                let wall = ShapeDef::box_half(vec3(0.2, 0.5, 1.0) * size);
                let wall =
                    BodyDef::fixed().with_position(vec3(0.45, 0.5, 0.0) * size).with_shape(wall);
                world.add_body(wall).unwrap();
            }
            run(&mut world, 60.0, 10.0);
            if held {
                assert!(sleeps(&world, load), "{size}, {speed}: {:?}", cause(&world, load));
            } else {
                let moved = at(&world, load).x;
                assert!((moved - 10.0 * speed).abs() < 0.5 * speed, "{moved}: {size}, {speed}");
                assert_eq!(cause(&world, load), AwakeCause::OnBelt { of: belt });
            }
        }
    }
}

/// A disc of this radius on a fixed base at the origin, by a joint whose x axis points up.
fn driven(gravity: Vec3, size: f32, axes: SixDof) -> (World, BodyId, drystone::JointId) {
    let mut world = pulled(gravity);
    let base = world.add_body(BodyDef::fixed()).unwrap();
    let disc = ShapeDef::cylinder(0.1 * size, size);
    let disc = world.add_body(BodyDef::dynamic().with_shape(disc)).unwrap();
    let joint = JointDef::new(base, disc, axes).at(Vec3::ZERO).with_axis(Vec3::Y);
    let joint = world.add_joint(joint).unwrap();
    (world, disc, joint)
}

fn coordinates(world: &World, joint: drystone::JointId) -> [f32; 6] {
    let [moved, turned] = world.joint(joint).unwrap().coordinates().unwrap();
    [moved.x, moved.y, moved.z, turned.x, turned.y, turned.z]
}

#[test]
fn no_slow_motor_stops_on_any_axis() {
    let gravity = vec3(0.0, -9.81, 0.0);
    for size in [0.01_f32, 1.0, 100.0] {
        for rate in [30.0_f32, 240.0] {
            // The hour hand of a clock is the slowest.
            for speed in [0.04_f32, 2.0e-3, 1.45e-4] {
                for axis in 0..6 {
                    let goal = if axis < 3 { speed * size } else { speed };
                    let motor = JointAxis::driven(JointDrive::motor(goal, f32::INFINITY));
                    let mut axes = SixDof::FIXED;
                    *axes.linear.iter_mut().chain(&mut axes.angular).nth(axis).unwrap() = motor;
                    let (mut world, disc, joint) = driven(gravity, size, axes);
                    run(&mut world, rate, 5.0);
                    let moved = coordinates(&world, joint)[axis];
                    let off = (moved - 5.0 * goal).abs();
                    let what = format!("axis {axis}, {speed}, size {size}, {rate} Hz");
                    assert!(off < 0.05 * 5.0 * goal && !sleeps(&world, disc), "{moved}: {what}");
                }
            }
        }
    }
}

#[test]
fn weak_motors_slow_servos_and_what_they_drive_by_gears_go_on() {
    for size in [0.01_f32, 1.0, 100.0] {
        let (probe, disc, _) = driven(Vec3::ZERO, size, SixDof::FIXED);
        let inertia = probe.body(disc).unwrap().inertia().yy;
        // Half a thousandth of a radian per second more in each second.
        let weak = JointDrive::motor(100.0, 5.0e-4 * inertia);
        let (mut world, _, joint) =
            driven(Vec3::ZERO, size, Hinge::of(JointAxis::driven(weak)).six_dof());
        run(&mut world, 60.0, 10.0);
        let turn = coordinates(&world, joint)[3];
        assert!((turn - 0.025).abs() < 0.002, "a weak motor, size {size}: {turn}");

        // It closes in by a thousandth of what is left in each second.
        let spring = JointSpring { stiffness: 10.0, damping: 1.0e4, per_mass: true };
        let slow = JointDrive::servo(size, spring, f32::INFINITY);
        let (mut world, disc, joint) =
            driven(Vec3::ZERO, size, Slider::of(JointAxis::driven(slow)).six_dof());
        run(&mut world, 60.0, 10.0);
        let moved = coordinates(&world, joint)[0];
        assert!((moved - 0.01 * size).abs() < 5.0e-4 * size, "a slow servo, size {size}: {moved}");
        // The largest is faster than what counts as slow.
        assert!(size > 10.0 || cause(&world, disc) == AwakeCause::DrivenByJoint { joint });

        let motor = JointAxis::driven(JointDrive::motor(2.0e-3, f32::INFINITY));
        let (mut world, _, joint) = driven(Vec3::ZERO, size, Hinge::of(motor).six_dof());
        let base = world.add_body(BodyDef::fixed()).unwrap();
        let far = vec3(3.0, 0.0, 0.0) * size;
        let disc = ShapeDef::cylinder(0.1 * size, size);
        let disc = world.add_body(BodyDef::dynamic().with_position(far).with_shape(disc)).unwrap();
        let hinge = Hinge::new().six_dof();
        let hinge = JointDef::new(base, disc, hinge).at(far).with_axis(Vec3::Y);
        let hinge = world.add_joint(hinge).unwrap();
        world.add_coupling(CouplingDef::gear(joint, hinge, -1.0)).unwrap();
        run(&mut world, 60.0, 10.0);
        let turn = coordinates(&world, hinge)[3];
        assert!((turn + 0.02).abs() < 1.0e-3, "a gear, size {size}: {turn}");
    }
}

#[test]
fn drives_that_are_blocked_or_have_reached_their_place_let_sleep() {
    for size in [0.1_f32, 1.0, 10.0] {
        for what in ["limit", "wall", "place", "sag", "brake"] {
            let mut world = World::default();
            let base = BodyDef::fixed().with_position([0.0, 3.0 * size, 0.0]);
            let base = world.add_body(base).unwrap();
            let arm = ShapeDef::box_half(vec3(0.5, 0.1, 0.1) * size);
            let arm = BodyDef::dynamic().with_position(vec3(0.5, 3.0, 0.0) * size).with_shape(arm);
            let arm = world.add_body(arm).unwrap();
            let torque = 20.0 * world.body(arm).unwrap().mass() * size;
            let spring = JointSpring::hertz(2.0 / size.sqrt(), 1.0);
            let (drive, max) = match what {
                "limit" => (JointDrive::motor(1.0, torque), 0.5),
                "wall" => (JointDrive::motor(-0.1, torque), f32::INFINITY),
                "place" => (JointDrive::servo(0.3, spring, f32::INFINITY), f32::INFINITY),
                "sag" => (JointDrive::servo(0.0, spring, f32::INFINITY), f32::INFINITY),
                _ => (JointDrive::motor(0.0, torque), f32::INFINITY),
            };
            let motion = JointMotion::Limited { min: -2.0, max, spring: None };
            let axis = JointAxis { motion, drive: Some(drive), friction: 0.0 };
            let hinge = Hinge::of(axis).six_dof();
            let hinge =
                JointDef::new(base, arm, hinge).at(vec3(0.0, 3.0, 0.0) * size).with_axis(Vec3::Z);
            world.add_joint(hinge).unwrap();
            if what == "wall" {
                let wall = ShapeDef::box_half(vec3(0.3, 0.5, 0.5) * size);
                let wall =
                    BodyDef::fixed().with_position(vec3(0.8, 2.0, 0.0) * size).with_shape(wall);
                world.add_body(wall).unwrap();
            }
            let slept = until_sleep(&mut world, 60.0, 15.0);
            assert!(slept.is_some(), "{what}, size {size}: {:?}", cause(&world, arm));
        }
    }
}

#[test]
fn a_spring_sleeps_where_it_balances() {
    for ratio in [0.05_f32, 0.3, 1.0] {
        let mut world = World::default();
        let base = BodyDef::fixed().with_position([0.0, 5.0, 0.0]);
        let base = world.add_body(base).unwrap();
        let load = cube(&mut world, vec3(0.0, 4.0, 0.0), 0.4);
        let spring = Spring { rest_length: 1.0, hertz: 1.5, damping_ratio: ratio };
        let kind = JointKind::Distance { min: 0.0, max: 10.0, spring: Some(spring) };
        let joint = JointDef::new(base, load, Distance::exact(1.0));
        world.add_joint(JointDef { kind, ..joint }).unwrap();
        assert!(until_sleep(&mut world, 60.0, 40.0).is_some(), "{ratio}");
        // g / ω²; it may be off by a thousandth of the cube's extent on its way, and swing as far again.
        let sinks = 9.81 / (2.0 * core::f32::consts::PI * 1.5_f32).powi(2);
        let off = 4.0 - at(&world, load).y - sinks;
        assert!(off.abs() < 2.0e-3 * 0.35 + 1.0e-4, "{ratio}: {off}");
    }
}

#[test]
fn what_falls_or_is_pushed_gently_is_not_stopped() {
    for size in SCALES {
        for rate in RATES {
            for gravity in [0.09_f32, 0.01, 0.001] {
                let mut world = pulled(vec3(0.0, -gravity, 0.0));
                let body = cube(&mut world, Vec3::ZERO, size);
                run(&mut world, rate, 10.0);
                let (fell, far) = (-at(&world, body).y, 50.0 * gravity);
                assert!((fell - far).abs() < 0.01 * far, "{fell} of {far}: {size}, {rate}");
            }
            let mut world = pulled(Vec3::ZERO);
            let shape = ShapeDef::box_half([size; 3]);
            let ship = BodyDef::dynamic().with_mass(1000.0).with_shape(shape);
            let ship = world.add_body(ship).unwrap();
            world.body_mut(ship).unwrap().set_lasting_force([2.0, 0.0, 0.0]);
            world.step(1.0 / rate);
            let why = cause(&world, ship);
            assert!(matches!(why, AwakeCause::Accelerates { .. }), "{why:?}");
            run(&mut world, rate, 10.0);
            let flew = at(&world, ship).x;
            assert!((flew - 0.1).abs() < 0.003, "{flew}: {size}, {rate}");
        }
    }
    // A balloon whose lift is a thousandth less than its weight, and one that hovers.
    for (lift, fell) in [(0.999_f32, 0.49_f32), (1.0, 0.0)] {
        let mut world = World::default();
        let balloon = cube(&mut world, Vec3::ZERO, 1.0);
        let weight = 9.81 * world.body(balloon).unwrap().mass();
        world.body_mut(balloon).unwrap().set_lasting_force([0.0, lift * weight, 0.0]);
        run(&mut world, 60.0, 10.0);
        assert!((-at(&world, balloon).y - fell).abs() < 0.01, "{lift}");
        assert_eq!(sleeps(&world, balloon), fell == 0.0, "{lift}");
    }
}

#[test]
fn what_begins_to_slide_or_roll_or_turns_round_on_a_gentle_slope_goes_on() {
    for size in SCALES {
        for rate in RATES {
            for floor in FLOORS {
                for (ball, degrees, start) in
                    [(true, 0.6_f32, 0.0_f32), (false, 0.4, 0.0), (true, 0.6, -0.06)]
                {
                    let gravity = slope(degrees);
                    let mut world = pulled(gravity);
                    ground(&mut world, floor, 10.0 * size.max(1.0));
                    let shape = if ball {
                        ShapeDef::sphere(0.5 * size)
                    } else {
                        ShapeDef::box_half([0.5 * size; 3]).with_friction(0.0)
                    };
                    let body = BodyDef::dynamic()
                        .with_position([0.0, 0.5 * size, 0.0])
                        .with_linear_velocity([start, 0.0, 0.0])
                        .with_angular_velocity([0.0, 0.0, -start / (0.5 * size)])
                        .with_shape(shape);
                    let body = world.add_body(body).unwrap();
                    run(&mut world, rate, 6.0);
                    let pull = gravity.x * if ball { 5.0 / 7.0 } else { 1.0 };
                    let (way, far) = (at(&world, body).x, 18.0 * pull + 6.0 * start);
                    let what = format!("size {size}, {rate} Hz, {floor:?}, {degrees}, {start}");
                    assert!((way - far).abs() < 0.05 * far, "{way} of {far}: {what}");
                }
            }
        }
    }
}

#[test]
fn a_pole_topples_a_balance_tips_and_a_pulley_runs() {
    for size in [0.1_f32, 1.0, 10.0] {
        for rate in RATES {
            let mut world = World::default();
            let base = world.add_body(BodyDef::fixed()).unwrap();
            let up = Quat::from_axis_angle(-Vec3::Z, 0.2_f32.to_radians()).rotate(Vec3::Y);
            let shape = ShapeDef::box_half(vec3(0.05, 1.0, 0.05) * size);
            let pole = BodyDef::dynamic().with_position(up * size).with_shape(shape);
            let pole = world.add_body(pole.with_rotation(Quat::from_arc(Vec3::Y, up))).unwrap();
            let foot = vec3(0.0, -size, 0.0);
            world
                .add_joint(JointDef::new(base, pole, Ball::new()).with_anchors(Vec3::ZERO, foot))
                .unwrap();
            // 0.2° cosh(t √(3g/4l)) is 1 rad after 6.3 of that unit of time.
            let mut lowest = size;
            for _ in 0..steps(rate, 7.0 / (0.75 * 9.81 / size).sqrt()) {
                world.step(1.0 / rate);
                lowest = lowest.min(at(&world, pole).y);
            }
            assert!(lowest < 0.5 * size, "the pole, {size}, {rate} Hz: {lowest}");

            let mut world = World::default();
            let base = world.add_body(BodyDef::fixed()).unwrap();
            let shape = ShapeDef::box_half(vec3(1.0, 0.05, 0.05) * size);
            let beam = world.add_body(BodyDef::dynamic().with_mass(1.0).with_shape(shape)).unwrap();
            let hinge = Hinge::new().six_dof();
            let hinge = JointDef::new(base, beam, hinge).at(Vec3::ZERO).with_axis(Vec3::Z);
            world.add_joint(hinge).unwrap();
            for (x, mass) in [(-1.0_f32, 10.0), (1.0, 10.1)] {
                let pan =
                    BodyDef::dynamic().with_position(vec3(x, -0.5, 0.0) * size).with_mass(mass);
                let pan = pan.with_shape(ShapeDef::box_half([0.2 * size; 3]));
                let pan = world.add_body(pan).unwrap();
                let [tip, ring] = [vec3(x, 0.0, 0.0), vec3(0.0, 0.5, 0.0)].map(|p| p * size);
                world
                    .add_joint(JointDef::new(beam, pan, Ball::new()).with_anchors(tip, ring))
                    .unwrap();
            }
            run(&mut world, rate, 1.5);
            // 0.1 kg · g · l on 20.1 kg · l² and a third of the beam's: 0.048 m/s² at the tip.
            let (fell, far) =
                (-world.body(beam).unwrap().rotation().rotate(Vec3::X).y * size, 0.054);
            assert!(
                size < 1.0 || (fell - far).abs() < 0.1 * far,
                "the balance, {size}, {rate} Hz: {fell}"
            );
            assert!(!sleeps(&world, beam), "the balance, {size}, {rate} Hz");

            let mut world = World::default();
            let mut side = |x: f32, mass: f32| {
                let body =
                    BodyDef::dynamic().with_position(vec3(x, 0.0, 0.0) * size).with_mass(mass);
                world.add_body(body.with_shape(ShapeDef::box_half([0.2 * size; 3]))).unwrap()
            };
            let [a, b] = [side(-1.0, 100.0), side(1.0, 102.0)];
            let over = [-1.0_f32, 1.0].map(|x| vec3(x, 20.0, 0.0) * size);
            let rope = Pulley::rope(over, 40.0 * size);
            world.add_joint(JointDef::new(a, b, rope)).unwrap();
            run(&mut world, rate, 3.0);
            let (fell, far) = (-at(&world, b).y, 0.5 * 9.81 * 2.0 / 202.0 * 9.0);
            assert!(
                (fell - far).abs() < 0.05 * far,
                "the pulley, {size}, {rate} Hz: {fell} of {far}"
            );
        }
    }
}

#[test]
fn drift_without_forces_is_rest_by_size() {
    // A hundredth of the extent, which is √3 half sides, in ten seconds.
    for size in SCALES {
        let limit = 1.0e-3 * 3.0_f32.sqrt() * 0.5 * size;
        for (part, rests) in [(0.9_f32, true), (1.1, false)] {
            let speed = (part * limit).min(0.045);
            let mut world = pulled(Vec3::ZERO);
            let body = cube(&mut world, Vec3::ZERO, size);
            world.body_mut(body).unwrap().set_linear_velocity([speed, 0.0, 0.0]);
            run(&mut world, 60.0, 2.0);
            assert_eq!(sleeps(&world, body), rests || speed < part * limit, "{size}, {speed}");
        }
    }
    // The world's speed holds, too.
    let mut config = WorldConfig { gravity: Vec3::ZERO, ..WorldConfig::default() };
    config.sleep.speed = 0.01;
    let mut world = World::new(config).unwrap();
    let body = cube(&mut world, Vec3::ZERO, 100.0);
    world.body_mut(body).unwrap().set_linear_velocity([0.02, 0.0, 0.0]);
    run(&mut world, 60.0, 2.0);
    assert_eq!(
        cause(&world, body),
        AwakeCause::TooFast { speed: 0.02, limit: 0.01, driven_by: None }
    );
}

#[test]
fn a_marble_rolls_on() {
    for radius in [0.005_f32, 0.01, 0.05] {
        for floor in FLOORS {
            let (mut world, speed) = (World::default(), 0.02);
            ground(&mut world, floor, 1.0);
            let marble = BodyDef::dynamic()
                .with_position([0.0, radius, 0.0])
                .with_linear_velocity([speed, 0.0, 0.0])
                .with_angular_velocity([0.0, 0.0, -speed / radius])
                .with_shape(ShapeDef::sphere(radius));
            let marble = world.add_body(marble).unwrap();
            run(&mut world, 60.0, 5.0);
            let way = at(&world, marble).x;
            assert!((way - 5.0 * speed).abs() < 0.05 * 5.0 * speed, "{radius}, {floor:?}: {way}");
        }
    }
}

#[test]
fn what_rests_sleeps_as_soon_as_it_can_be_told() {
    for size in SCALES {
        for rate in RATES {
            for floor in [Floor::Box, Floor::Mesh] {
                let mut world = World::default();
                ground(&mut world, floor, size);
                for i in 0..5_u8 {
                    cube(&mut world, vec3(0.0, f32::from(i) + 0.5, 0.0) * size, size);
                }
                // They settle by a part of a millimeter first.
                let slept = until_sleep(&mut world, rate, 2.0);
                let soon = slept.is_some_and(|t| t < SLEEP + 2.0 * LOOK);
                assert!(soon, "{slept:?}: {size}, {rate} Hz, {floor:?}");
            }
        }
    }
}

#[test]
fn sleep_without_a_time_needs_three_steps_and_spares_what_falls() {
    let mut config = WorldConfig::default();
    config.sleep.time = 0.0;
    let mut world = World::new(config).unwrap();
    ground(&mut world, Floor::Box, 1.0);
    let rests = cube(&mut world, vec3(0.0, 0.5, 0.0), 1.0);
    let falls = cube(&mut world, vec3(5.0, 5.0, 0.0), 1.0);
    run(&mut world, 60.0, 0.5);
    assert!(sleeps(&world, rests) && !sleeps(&world, falls));
    assert!(at(&world, falls).y < 4.0);
    run(&mut world, 60.0, 3.0);
    assert!(all_sleep(&world));
}

/// A load 2 m below a holder at 5 m, on a joint of this name; both are sized.
fn hung(kind: BodyKind, joint: &str, size: f32) -> (World, BodyId, BodyId) {
    let mut world = World::default();
    let top = vec3(0.0, 5.0, 0.0) * size;
    let def = if kind == BodyKind::Static { BodyDef::fixed() } else { BodyDef::kinematic() };
    let holder = world.add_body(def.with_position(top)).unwrap();
    let load = cube(&mut world, vec3(0.0, 3.0, 0.0) * size, 0.4 * size);
    let (below, above) = (Vec3::ZERO, vec3(0.0, 2.0, 0.0) * size);
    let six = |axes: SixDof| JointDef::new(holder, load, axes).at(top).with_axis(Vec3::Z);
    let rod =
        JointDef::new(holder, load, Distance::exact(2.0 * size)).with_anchors(below, Vec3::ZERO);
    let def = match joint {
        "rope" => {
            let kind = JointKind::Distance { min: 0.0, max: 2.0 * size, spring: None };
            JointDef { kind, ..rod }
        }
        "rod" => rod,
        "hinge" => six(Hinge::new().six_dof()),
        "fixed" => six(SixDof::FIXED),
        "grab" => six(Servo::grab(JointSpring::hertz(3.0, 1.0), f32::INFINITY).six_dof()),
        "pulley" => {
            let over = [-1.0_f32, 0.0].map(|x| vec3(x, 9.0, 0.0) * size);
            let side = vec3(-1.0, 0.0, 0.0) * size;
            JointDef::new(holder, load, Pulley::rope(over, 10.0 * size))
                .with_anchors(side, Vec3::ZERO)
        }
        _ => JointDef::new(holder, load, Ball::new()).with_anchors(below, above),
    };
    world.add_joint(def).unwrap();
    let mut last = load;
    if joint == "chain" {
        last = cube(&mut world, vec3(0.0, 2.0, 0.0) * size, 0.4 * size);
        let [low, high] = [-0.5_f32, 0.5].map(|y| vec3(0.0, y, 0.0) * size);
        world.add_joint(JointDef::new(load, last, Ball::new()).with_anchors(low, high)).unwrap();
    }
    assert!(until_sleep(&mut world, 60.0, 5.0).is_some(), "{joint}, {size}");
    (world, holder, last)
}

const JOINTS: [&str; 8] = ["rope", "rod", "ball", "hinge", "fixed", "grab", "pulley", "chain"];

#[test]
fn whatever_happens_to_a_holder_wakes_what_hangs_on_it() {
    for size in [0.1_f32, 1.0, 10.0] {
        for joint in JOINTS {
            for kind in [BodyKind::Static, BodyKind::Kinematic] {
                for how in ["pose", "remove", "move_to", "velocity", "spin", "slow"] {
                    if kind == BodyKind::Static && !["pose", "remove"].contains(&how) {
                        continue;
                    }
                    let (mut world, holder, load) = hung(kind, joint, size);
                    let before = at(&world, load);
                    let mut body = world.body_mut(holder).unwrap();
                    let there = Pose::at(vec3(0.3, 5.0, 0.0) * size);
                    match how {
                        "pose" => body.set_pose(there),
                        "move_to" => body.move_to(there, 1.0),
                        "velocity" => body.set_linear_velocity([0.3 * size, 0.0, 0.0]),
                        "slow" => body.set_linear_velocity([1.0e-3 * size, 0.0, 0.0]),
                        "spin" => body.set_angular_velocity([0.0, 0.0, 0.1]),
                        _ => assert!(world.remove_body(holder)),
                    }
                    let what = format!("{joint}, {kind:?}, {how}, size {size}");
                    assert!(!sleeps(&world, load), "{what}");
                    for _ in 0..60 {
                        world.step(1.0 / 60.0);
                        let moves = !["pose", "remove"].contains(&how);
                        assert!(!moves || !sleeps(&world, load), "{what}");
                    }
                    let moved = (at(&world, load) - before).length();
                    let error = world.joints().map(|joint| joint.error()).fold(0.0, f32::max);
                    // A rope over a pulley hardly gets longer by a millimeter aside.
                    let idle = how == "spin" || joint == "pulley";
                    assert!(idle || moved > 0.0, "{what}");
                    // A rod or rope that is pulled gives by a part of a millimeter; a grab by all that it is behind.
                    let taut = joint == "grab" || how == "pose" || error < 5.0e-3 * size;
                    assert!(taut, "{what}: {error} m open");
                }
            }
        }
    }
}

#[test]
fn a_gear_wakes_when_a_holder_of_one_of_its_joints_moves() {
    let mut world = World::default();
    let hinge = Hinge::new().six_dof();
    let mut ends = Vec::new();
    for x in [0.0_f32, 3.0] {
        let place = vec3(x, 0.0, 0.0);
        let holder = world.add_body(BodyDef::kinematic().with_position(place)).unwrap();
        let disc = BodyDef::dynamic().with_position(place).with_shape(ShapeDef::cylinder(0.1, 1.0));
        let disc = world.add_body(disc).unwrap();
        let joint = JointDef::new(holder, disc, hinge).at(place).with_axis(Vec3::Y);
        ends.push((holder, disc, world.add_joint(joint).unwrap()));
    }
    world.add_coupling(CouplingDef::gear(ends[0].2, ends[1].2, -1.0)).unwrap();
    assert!(until_sleep(&mut world, 60.0, 5.0).is_some());
    world.body_mut(ends[0].0).unwrap().set_angular_velocity([0.0, 0.01, 0.0]);
    assert!(ends.iter().all(|(_, disc, _)| !sleeps(&world, *disc)));
    run(&mut world, 60.0, 5.0);
    assert!(ends.iter().all(|(_, disc, _)| !sleeps(&world, *disc)));
}

#[test]
fn a_rope_of_particles_carries_however_slowly_its_holder_moves() {
    for how in ["pose", "fast", "slow", "remove"] {
        let mut world = World::default();
        let holder = BodyDef::kinematic().with_position([0.0, 5.0, 0.0]);
        let holder = world.add_body(holder).unwrap();
        let load = cube(&mut world, vec3(0.0, 3.0, 0.0), 0.4);
        let ends = [5.0_f32, 3.2].map(|y| {
            let particle = ParticleDef::at([0.0, y, 0.0]).with_mass(0.1);
            world.add_particle(particle).unwrap()
        });
        world.add_link(LinkDef::new(ends[0], ends[1], LinkKind::Equal)).unwrap();
        world.particle_mut(ends[0]).expect("there").attach(holder, Vec3::ZERO).unwrap();
        world.particle_mut(ends[1]).expect("there").attach(load, [0.0, 0.2, 0.0]).unwrap();
        assert!(until_sleep(&mut world, 60.0, 20.0).is_some());
        let before = at(&world, load);
        let mut body = world.body_mut(holder).unwrap();
        match how {
            "pose" => body.set_pose(Pose::at([0.3, 5.0, 0.0])),
            "fast" => body.set_linear_velocity([0.3, 0.0, 0.0]),
            "slow" => body.set_linear_velocity([0.0, 2.0e-3, 0.0]),
            _ => assert!(world.remove_body(holder)),
        }
        run(&mut world, 60.0, 5.0);
        let moved = at(&world, load) - before;
        let ok = match how {
            "slow" => (moved.y - 0.01).abs() < 1.0e-3,
            "remove" => moved.y < -10.0,
            _ => moved.length() > 0.1,
        };
        assert!(ok, "{how}: {moved:?}");
    }
}

/// A cube that sleeps at the origin on a half-space, with a wall far away of each kind: static, kinematic.
fn sleeper(size: f32, sensor: bool) -> (World, BodyId, BodyId, [BodyId; 2]) {
    let mut world = World::default();
    let floor = ground(&mut world, Floor::HalfSpace, size);
    let body = cube(&mut world, vec3(0.0, 0.25, 0.0) * size, 0.5 * size);
    let walls = [(BodyDef::fixed(), 90.0_f32), (BodyDef::kinematic(), -90.0)].map(|(def, x)| {
        let place = vec3(x, 1.1, 0.0) * size;
        world.add_body(def.with_position(place).with_shape(wall(size, sensor))).unwrap()
    });
    assert!(until_sleep(&mut world, 60.0, 5.0).is_some());
    (world, floor, body, walls)
}

fn wall(size: f32, sensor: bool) -> ShapeDef {
    let wall = ShapeDef::box_half(vec3(0.3, 1.0, 1.0) * size);
    if sensor { wall.as_sensor() } else { wall }
}

#[test]
fn what_is_put_into_a_sleeper_is_noticed_however_it_comes_there() {
    for size in [0.1_f32, 1.0, 10.0] {
        // The sleeper's side is at -0.25: 15 cm deep; or 5 cm away.
        for x in [-0.4_f32, -0.6] {
            for how in [
                "static",
                "mesh",
                "half-space",
                "kinematic",
                "shape",
                "shape of kinematic",
                "pose",
                "kinematic pose",
            ] {
                let (mut world, floor, body, [fixed, moving]) = sleeper(size, false);
                let place = vec3(x, 1.1, 0.0) * size;
                let face = (x + 0.3) * size;
                match how {
                    "static" => {
                        let def = BodyDef::fixed().with_position(place);
                        world.add_body(def.with_shape(wall(size, false))).unwrap();
                    }
                    "kinematic" => {
                        let def = BodyDef::kinematic().with_position(place);
                        world.add_body(def.with_shape(wall(size, false))).unwrap();
                    }
                    "mesh" => {
                        let corners = [(-1.0, -1.0), (-1.0, 1.0), (2.0, 1.0), (2.0, -1.0)];
                        let corners = corners.map(|(y, z)| vec3(face, y * size, z * size));
                        let sheet = mesh(corners.to_vec(), vec![[0, 2, 1], [0, 3, 2]]);
                        world.add_body(BodyDef::fixed().with_shape(sheet)).unwrap();
                    }
                    "half-space" => {
                        let half = ShapeDef::half_space(Vec3::X, face);
                        world.add_body(BodyDef::fixed().with_shape(half)).unwrap();
                    }
                    "shape" => {
                        let shape = wall(size, false).with_position(place);
                        world.add_shape(floor, shape).unwrap();
                    }
                    "shape of kinematic" => {
                        let shape = wall(size, false).with_position(place - at(&world, moving));
                        world.add_shape(moving, shape).unwrap();
                    }
                    "pose" => world.body_mut(fixed).unwrap().set_pose(Pose::at(place)),
                    _ => world.body_mut(moving).unwrap().set_pose(Pose::at(place)),
                }
                world.step(1.0 / 60.0);
                let touches = x > -0.5;
                let what = format!("{how}, size {size}, touches {touches}");
                assert_eq!(!sleeps(&world, body), touches, "{what}");
                run(&mut world, 60.0, 2.0);
                assert_eq!(at(&world, body).x > 0.1 * size, touches, "{what}");
                assert!(all_sleep(&world) || touches, "{what}");
            }
        }
    }
}

#[test]
fn what_passes_near_a_sleeper_wakes_it_by_touch_alone() {
    for rate in RATES {
        for kind in [BodyKind::Kinematic, BodyKind::Dynamic] {
            // Both within the contact margin of 2 cm.
            for gap in [0.01_f32, -0.005] {
                let mut world = pulled(Vec3::ZERO);
                let shape = ShapeDef::box_half([0.5; 3]);
                let body = BodyDef { asleep: true, ..BodyDef::dynamic().with_shape(shape) };
                let body = world.add_body(body).unwrap();
                let ball = ShapeDef::sphere(0.1);
                let ball = BodyDef { kind, ..BodyDef::dynamic().with_shape(ball) };
                let ball = ball.with_position([-1.0, 0.6 + gap, 0.0]);
                world.add_body(ball.with_linear_velocity([0.3, 0.0, 0.0])).unwrap();
                let mut woke = false;
                for _ in 0..steps(rate, 6.0) {
                    world.step(1.0 / rate);
                    woke |= !sleeps(&world, body);
                }
                assert_eq!(woke, gap < 0.0, "{kind:?}, gap {gap}, {rate} Hz");
            }
        }
    }
}

#[test]
fn what_sleeps_falls_when_what_it_stands_on_goes() {
    for floor in FLOORS {
        for how in ["remove", "remove shape", "pose"] {
            let mut world = World::default();
            let ground = ground(&mut world, floor, 1.0);
            let body = cube(&mut world, vec3(0.0, 0.5, 0.0), 1.0);
            assert!(until_sleep(&mut world, 60.0, 5.0).is_some());
            match how {
                "remove" => assert!(world.remove_body(ground)),
                "remove shape" => {
                    let shape = world.body(ground).unwrap().shapes().next().unwrap();
                    assert!(world.remove_shape(shape));
                }
                _ => {
                    let away = Pose::at([0.0, -50.0, 0.0]);
                    world.body_mut(ground).unwrap().set_pose(away);
                }
            }
            run(&mut world, 60.0, 1.0);
            assert!(at(&world, body).y < -4.0, "{floor:?}, {how}");
        }
    }
}

#[test]
fn bodies_that_are_added_asleep_sleep_on_until_something_is_put_into_them() {
    let mut world = World::default();
    // A wall of a level with its ground, all in one step: nothing has changed since they stood there.
    let ground = ground(&mut world, Floor::Box, 1.0);
    let bricks: Vec<BodyId> = (0..5_u8)
        .map(|i| {
            let brick = BodyDef::dynamic().with_position([0.0, 0.5 + f32::from(i), 0.0]);
            let shape = ShapeDef::box_half([0.5; 3]);
            world.add_body(BodyDef { asleep: true, ..brick.with_shape(shape) }).unwrap()
        })
        .collect();
    run(&mut world, 60.0, 1.0);
    assert!(all_sleep(&world));
    world.add_shape(ground, ShapeDef::box_half([0.3; 3]).with_position([0.7, 0.5, 0.0])).unwrap();
    world.step(1.0 / 60.0);
    assert!(!sleeps(&world, bricks[0]));
}

#[test]
fn sensors_see_what_sleeps_and_what_rests() {
    for zone in [BodyKind::Static, BodyKind::Kinematic, BodyKind::Dynamic] {
        for visitor in ["static", "kinematic", "moving", "awake", "asleep"] {
            for zone_first in [true, false] {
                let mut world = pulled(Vec3::ZERO);
                let add_zone = |world: &mut World| {
                    let def = match zone {
                        BodyKind::Static => BodyDef::fixed(),
                        BodyKind::Kinematic => BodyDef::kinematic(),
                        _ => BodyDef::dynamic().with_mass(1.0),
                    };
                    world
                        .add_body(def.with_shape(ShapeDef::box_half([1.0; 3]).as_sensor()))
                        .unwrap()
                };
                let add_visitor = |world: &mut World| {
                    let def = match visitor {
                        "static" => BodyDef::fixed(),
                        "kinematic" => BodyDef::kinematic(),
                        "moving" => BodyDef::kinematic().with_linear_velocity([1.0e-3, 0.0, 0.0]),
                        "awake" => BodyDef::dynamic(),
                        _ => BodyDef { asleep: true, ..BodyDef::dynamic() },
                    };
                    world.add_body(def.with_shape(ShapeDef::sphere(0.2))).unwrap()
                };
                let (at_zone, at_visitor);
                if zone_first {
                    at_zone = add_zone(&mut world);
                    run(&mut world, 60.0, 1.0);
                    at_visitor = add_visitor(&mut world);
                } else {
                    at_visitor = add_visitor(&mut world);
                    run(&mut world, 60.0, 1.0);
                    at_zone = add_zone(&mut world);
                }
                let count = |world: &mut World| {
                    let (mut enters, mut exits) = (0, 0);
                    for _ in 0..60 {
                        world.step(1.0 / 60.0);
                        enters += world.events().sensor_enter.len();
                        exits += world.events().sensor_exit.len();
                    }
                    (enters, exits)
                };
                let seen = usize::from(zone != BodyKind::Static || visitor != "static");
                let what = format!("{zone:?} sees {visitor}, first {zone_first}");
                assert_eq!(count(&mut world), (seen, 0), "{what}: enters");
                // Away with one, and back; then with the other.
                for moved in [at_zone, at_visitor] {
                    let here = world.body(moved).unwrap().pose();
                    let away = Pose::at([0.0, 50.0, 0.0]);
                    world.body_mut(moved).unwrap().set_pose(away);
                    assert_eq!(count(&mut world), (0, seen), "{what}: leaves");
                    world.body_mut(moved).unwrap().set_pose(here);
                    assert_eq!(count(&mut world), (seen, 0), "{what}: comes back");
                }
                assert!(world.remove_body(at_visitor));
                assert_eq!(count(&mut world), (0, seen), "{what}: is removed");
            }
        }
    }
}

#[test]
fn a_world_restored_while_bodies_are_watched_goes_on_with_the_same_bits() {
    let mut world = World::default();
    ground(&mut world, Floor::Box, 1.0);
    for i in 0..8_u8 {
        let x = f32::from(i) * 1.5;
        cube(&mut world, vec3(x, 0.5 + 0.05 * f32::from(i), 0.0), 1.0);
        let ball =
            BodyDef::dynamic().with_position([x, 3.0, 5.0]).with_shape(ShapeDef::sphere(0.3));
        world.add_body(ball).unwrap();
    }
    for step in 0..180 {
        if step % 7 == 0 {
            let mut twin = World::restore(&world.snapshot()).unwrap();
            let mut other = world.clone();
            for _ in 0..40 {
                other.step(1.0 / 60.0);
                twin.step(1.0 / 60.0);
                assert_eq!(other.state_hash(), twin.state_hash(), "step {step}");
                let awake = |w: &World| w.bodies().filter(|b| b.is_asleep()).count();
                assert_eq!(awake(&other), awake(&twin), "step {step}");
            }
        }
        world.step(1.0 / 60.0);
    }
}
