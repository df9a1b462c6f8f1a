//! Joint springs rest where their loads determine, whatever else holds or pushes their bodies.

use drystone::joint::{Hinge, JointAxis, JointDrive, JointMotion, JointSpring, Slider, Wheel};
use drystone::math::trig;
use drystone::{
    Axis, BodyDef, BodyId, JointDef, JointId, ShapeDef, Vec3, World, WorldConfig, vec3,
};

const DT: f32 = 1.0 / 60.0;
const G: f32 = 9.81;
const STIFFNESS: f32 = 30_000.0;

fn world(method: &str) -> World {
    let mut config = WorldConfig::default();
    config.set("method", method).unwrap();
    // A sleeping spring keeps the length at which it fell asleep.
    config.sleep.enabled = false;
    World::new(config).unwrap()
}

fn ground(world: &mut World) -> BodyId {
    let plane = ShapeDef::half_space(Vec3::Y, 0.0);
    world.add_body(BodyDef::fixed().with_shape(plane)).unwrap()
}

fn spring(damping: f32) -> JointAxis {
    let law = JointSpring::new(STIFFNESS, damping);
    JointAxis::FREE.with_drive(JointDrive::servo(0.0, law, f32::INFINITY))
}

fn along(world: &World, joint: JointId, axis: Axis) -> f32 {
    world.joint(joint).unwrap().axis(axis).unwrap().position()
}

/// Damps the motion for 20 s: at least to exp(-c t/2m) of the start.
fn settle(world: &mut World) {
    for _ in 0..1200 {
        world.step(DT);
    }
}

/// A box on a spring above a ball on the ground, guided by a rail: the ground holds the ball, and
/// the spring carries the box.
#[test]
fn a_spring_over_a_wheel_bears_what_stands_on_it() {
    let right = 250.0 * G / STIFFNESS;
    for method in ["soft-step", "soft-step-relax"] {
        for damping in [300.0, 1000.0, 3000.0, 10_000.0] {
            for mass in [5.0, 20.0, 100.0, 250.0] {
                // Stiffer than a sweep can hold, c h K = 8.5 with the four substeps of the second
                // method: such a spring yields more (docs/derivations/joints.md).
                if damping * (1.0 / mass + 1.0 / 250.0) / 240.0 > 4.0 {
                    continue;
                }
                let mut world = world(method);
                let ground = ground(&mut world);
                let top = BodyDef::dynamic().with_position([0.0, 1.0, 0.0]).with_mass(250.0);
                let top = world.add_body(top.with_shape(ShapeDef::box_half([0.2; 3]))).unwrap();
                let wheel = BodyDef::dynamic().with_position([0.0, 0.3, 0.0]).with_mass(mass);
                let wheel = world.add_body(wheel.with_shape(ShapeDef::sphere(0.3))).unwrap();
                let kind = Slider::of(spring(damping));
                let def = JointDef::new(wheel, top, kind).at([0.0, 0.3, 0.0]).with_axis(Vec3::Y);
                let joint = world.add_joint(def).unwrap();
                let rail = JointDef::new(ground, top, Slider::of(JointAxis::FREE));
                world.add_joint(rail.at([0.0, 1.0, 0.0]).with_axis(Vec3::Y)).unwrap();
                settle(&mut world);
                let sinks = -along(&world, joint, Axis::X);
                let case = format!("{method}, {damping} N s/m, {mass} kg: {sinks}, right {right}");
                println!("{case}");
                assert!((sinks / right - 1.0).abs() < 1.0e-3, "{case}");
            }
        }
    }
}

/// A chain of masses on springs: each spring carries all weights below it.
#[test]
fn springs_in_a_row_bear_the_weights_below_them() {
    for damping in [300.0, 1000.0, 3000.0] {
        let mut world = world("soft-step");
        let mut last = world.add_body(BodyDef::fixed()).unwrap();
        let masses = [20.0, 5.0, 80.0];
        let mut joints = Vec::new();
        for (i, mass) in (1_u8..).zip(masses) {
            let at = vec3(0.0, -f32::from(i), 0.0);
            let shape = ShapeDef::box_half([0.1; 3]);
            let body = BodyDef::dynamic().with_position(at).with_mass(mass).with_shape(shape);
            let body = world.add_body(body).unwrap();
            let def = JointDef::new(last, body, Slider::of(spring(damping))).at(at);
            joints.push(world.add_joint(def.with_axis(Vec3::Y)).unwrap());
            last = body;
        }
        settle(&mut world);
        for (i, joint) in joints.into_iter().enumerate() {
            let right = masses[i..].iter().sum::<f32>() * G / STIFFNESS;
            let sinks = -along(&world, joint, Axis::X);
            println!("{damping} N s/m, spring {i}: {sinks}, right {right}");
            assert!((sinks / right - 1.0).abs() < 1.0e-3, "{damping} {i}: {sinks} {right}");
        }
    }
}

/// A load on an arm with a sprung hinge, on a light post that stands on the ground.
#[test]
fn a_spring_of_a_hinge_on_a_light_post_turns_by_its_load() {
    let (mass, arm, stiffness) = (20.0, 0.5, 2000.0);
    for damping in [20.0, 100.0, 400.0] {
        let mut world = world("soft-step");
        ground(&mut world);
        let post = BodyDef::dynamic().with_position([0.0, 0.5, 0.0]).with_mass(2.0);
        let foot = ShapeDef::box_half([1.0, 0.5, 0.5]).with_friction(1.0);
        let post = world.add_body(post.with_shape(foot)).unwrap();
        let load = BodyDef::dynamic().with_position([arm, 1.5, 0.0]).with_mass(mass);
        let load = world.add_body(load.with_shape(ShapeDef::sphere(0.1))).unwrap();
        let law = JointSpring::new(stiffness, damping);
        let drive = JointDrive::servo(0.0, law, f32::INFINITY);
        let kind = Hinge::of(JointAxis::FREE.with_drive(drive));
        let def = JointDef::new(post, load, kind).at([0.0, 1.5, 0.0]).with_axis(Vec3::Z);
        let joint = world.add_joint(def).unwrap();
        settle(&mut world);
        let turned = -along(&world, joint, Axis::TurnX);
        // k θ = m g l cos θ, by iteration.
        let mut right = 0.0_f32;
        for _ in 0..20 {
            right = mass * G * arm * trig::sin_cos(right).1 / stiffness;
        }
        println!("{damping} N m s: {turned}, right {right}");
        assert!((turned / right - 1.0).abs() < 2.0e-3, "{damping}: {turned} {right}");
    }
}

/// Four wheels under a car: the suspension and its sprung stops.
#[test]
fn a_car_stands_as_high_as_its_springs_say() {
    for stop in [false, true] {
        let mut world = world("soft-step");
        ground(&mut world);
        let car = BodyDef::dynamic().with_position([0.0, 0.75, 0.0]).with_mass(1000.0);
        let car = world.add_body(car.with_shape(ShapeDef::box_half([1.9, 0.2, 0.8]))).unwrap();
        let law = JointSpring::new(STIFFNESS, 3000.0);
        let mut joints = Vec::new();
        for (x, z) in [(1.3, -0.8), (1.3, 0.8), (-1.3, -0.8), (-1.3, 0.8)] {
            let wheel = BodyDef::dynamic().with_position([x, 0.33, z]).with_mass(20.0);
            let wheel = world.add_body(wheel.with_shape(ShapeDef::sphere(0.33))).unwrap();
            let def = JointDef::new(car, wheel, Wheel::new(law)).at([x, 0.33, z]);
            let joint = world.add_joint(def.with_axes(Vec3::Y, -Vec3::Z)).unwrap();
            if stop {
                // The same spring, as a limit of zero range.
                let motion = JointMotion::Limited { min: 0.0, max: 0.0, spring: Some(law) };
                let mut joint = world.joint_mut(joint).unwrap();
                joint.axis(Axis::X).unwrap().set(JointAxis { motion, ..JointAxis::FREE }).unwrap();
            }
            joints.push(joint);
        }
        settle(&mut world);
        let right = 250.0 * G / STIFFNESS;
        for joint in joints {
            let sinks = along(&world, joint, Axis::X);
            println!("stop {stop}: {sinks}, right {right}");
            assert!((sinks.abs() / right - 1.0).abs() < 1.0e-3, "{stop}: {sinks} {right}");
        }
    }
}
