//! A moving body does not sleep, however slowly it is carried, falls, slides or rolls.

use drystone::audit::AwakeCause;
use drystone::joint::{Ball, Hinge, Pulley};
use drystone::{BodyDef, JointDef, Quat, ShapeDef, Vec3, World, vec3};

use super::{RATES, SCALES, at, cause, cube, ground, pulled, run, sleeps, slope, steps};
use crate::floors::{FLOORS, Floor};

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
                    // A soft contact yields by less than a millimeter; a load left behind would be
                    // off by the whole displacement.
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
        // A gap of half a hundredth, then the same distance again.
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
