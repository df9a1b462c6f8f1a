//! A driven or pulled body does not sleep, however slowly it moves; a blocked body does, or one
//! that has arrived or is in balance.

use drystone::audit::AwakeCause;
use drystone::joint::{
    CouplingDef, Distance, Hinge, JointAxis, JointDrive, JointMotion, JointSpring, SixDof, Slider,
    Spring,
};
use drystone::{BodyDef, BodyId, JointDef, JointKind, ShapeDef, Vec3, World, vec3};

use super::{at, cause, cube, pulled, run, sleeps, until_sleep};

/// A disc of this radius on a fixed base at the origin, on a joint whose x axis points up.
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
        // It accelerates by half a thousandth of a radian per second each second.
        let weak = JointDrive::motor(100.0, 5.0e-4 * inertia);
        let (mut world, _, joint) =
            driven(Vec3::ZERO, size, Hinge::of(JointAxis::driven(weak)).six_dof());
        run(&mut world, 60.0, 10.0);
        let turn = coordinates(&world, joint)[3];
        assert!((turn - 0.025).abs() < 0.002, "a weak motor, size {size}: {turn}");

        // It approaches by a thousandth of the remaining distance each second.
        let spring = JointSpring { stiffness: 10.0, damping: 1.0e4, per_mass: true };
        let slow = JointDrive::servo(size, spring, f32::INFINITY);
        let (mut world, disc, joint) =
            driven(Vec3::ZERO, size, Slider::of(JointAxis::driven(slow)).six_dof());
        run(&mut world, 60.0, 10.0);
        let moved = coordinates(&world, joint)[0];
        assert!((moved - 0.01 * size).abs() < 5.0e-4 * size, "a slow servo, size {size}: {moved}");
        // The largest disc is faster than the sleep threshold.
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
        // g / ω²; it may deviate by a thousandth of the cube's extent on its way, and swing as far
        // again.
        let sinks = 9.81 / (2.0 * core::f32::consts::PI * 1.5_f32).powi(2);
        let off = 4.0 - at(&world, load).y - sinks;
        assert!(off.abs() < 2.0e-3 * 0.35 + 1.0e-4, "{ratio}: {off}");
    }
}
