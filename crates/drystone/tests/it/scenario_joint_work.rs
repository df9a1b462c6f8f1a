//! Joints must not add energy, and bodies on them must come to rest.

use std::f32::consts::FRAC_PI_2;
use std::sync::Arc;

use drystone::joint::{
    Ball, ConeTwist, CouplingDef, Distance, Hinge, JointAxis, JointDrive, JointSpring, SixDof,
};
use drystone::math::Mat3;
use drystone::{
    Axis, BodyDef, BodyId, JointDef, Mesh, Quat, Shape, ShapeDef, Vec3, World, WorldConfig, vec3,
};

const G: f32 = 9.81;

fn floor(world: &mut World) {
    let ground = ShapeDef::half_space([0.0, 1.0, 0.0], 0.0).with_friction(1.0);
    world.add_body(BodyDef::fixed().with_shape(ground)).unwrap();
}

/// A world with gravity rotated by an angle [rad], so that its floor is a slope.
fn slope(angle: f32) -> World {
    let down = Quat::from_axis_angle(Vec3::Z, angle).rotate(-Vec3::Y);
    let config = WorldConfig { gravity: down * G, ..WorldConfig::default() };
    let mut world = World::new(config).unwrap();
    floor(&mut world);
    world
}

fn energy(world: &World) -> f64 {
    world.kinetic_energy() + world.potential_energy()
}

/// Steps per second, and scale of lengths.
const SCALES: [(f32, f32); 4] = [(60.0, 1.0), (60.0, 0.1), (60.0, 10.0), (120.0, 1.0)];

/// A ball on a chain of light links, released from the horizontal.
fn whip(links: u8, ratio: f32, hinges: bool, (hertz, size): (f32, f32)) -> f64 {
    let mut world = World::default();
    let mut last = world.add_body(BodyDef::fixed()).unwrap();
    let along = Quat::from_arc(Vec3::Y, Vec3::X);
    let join = |world: &mut World, a: BodyId, b: BodyId, x: f32, ends: [f32; 2]| {
        let def = if hinges {
            let axes = Hinge::new().six_dof();
            JointDef::new(a, b, axes).at([x, 0.0, 0.0]).with_axis(Vec3::Z)
        } else {
            JointDef::new(a, b, Ball::new()).with_anchors([0.0, ends[0], 0.0], [0.0, ends[1], 0.0])
        };
        world.add_joint(def).unwrap();
    };
    let mass = size * size * size;
    for i in 0..links {
        let x = 0.4 * size * f32::from(i);
        let link = BodyDef::dynamic().with_position([x + 0.2 * size, 0.0, 0.0]);
        let link = link.with_rotation(along).with_mass(mass);
        let link = link.with_shape(ShapeDef::capsule(0.15 * size, 0.04 * size));
        let link = world.add_body(link).unwrap();
        let from = if i == 0 { 0.0 } else { 0.2 * size };
        join(&mut world, last, link, x, [from, -0.2 * size]);
        last = link;
    }
    let end = 0.4 * size * f32::from(links);
    let ball = BodyDef::dynamic().with_position([end + 0.3 * size, 0.0, 0.0]);
    let ball = ball.with_rotation(along).with_mass(ratio * mass);
    let ball = world.add_body(ball.with_shape(ShapeDef::sphere(0.3 * size))).unwrap();
    join(&mut world, last, ball, end, [0.2 * size, -0.3 * size]);
    let start = energy(&world);
    let drop = f64::from(G * ratio * mass * (end + 0.3 * size));
    let mut most = 0.0_f64;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "hundreds")]
    for _ in 0..(10.0 * hertz) as u32 {
        world.step(1.0 / hertz);
        most = most.max((energy(&world) - start) / drop);
    }
    most
}

/// Velocities are half a substep ahead of positions. The reported energy has an error of up to m g
/// v h/2: for a drop of a meter 0.5 % of the fallen energy.
#[test]
fn a_heavy_weight_on_a_light_chain_makes_no_energy() {
    for at in SCALES {
        for (links, ratio) in [(5, 100.0), (10, 20.0), (10, 50.0)] {
            for hinges in [false, true] {
                let gained = whip(links, ratio, hinges, at);
                assert!(
                    gained < 0.01,
                    "{links} links, 1:{ratio}, hinges {hinges}, {at:?}: {gained}"
                );
            }
        }
    }
}

/// A table top with four legs that are fixed to it.
fn table(mass: f32, leg: f32, angle: f32, (hertz, size): (f32, f32)) {
    let mut world = slope(angle);
    let volume = size * size * size;
    let top = BodyDef::dynamic().with_position([0.0, 1.05 * size, 0.0]).with_mass(mass * volume);
    let plate = ShapeDef::box_half([size, 0.05 * size, 0.6 * size]);
    let top = world.add_body(top.with_shape(plate)).unwrap();
    for (x, z) in [(0.9, 0.5), (0.9, -0.5), (-0.9, 0.5), (-0.9, -0.5)] {
        let (x, z) = (x * size, z * size);
        let def = BodyDef::dynamic().with_position([x, 0.5 * size, z]).with_mass(leg * volume);
        let post = ShapeDef::box_half([0.05 * size, 0.5 * size, 0.05 * size]).with_friction(1.0);
        let leg = world.add_body(def.with_shape(post)).unwrap();
        let joint = JointDef::new(top, leg, SixDof::FIXED).at([x, size, z]);
        world.add_joint(joint).unwrap();
    }
    rests(
        &mut world,
        top,
        (hertz, size),
        &format!("{mass}:{leg} at {angle} rad, {hertz} Hz, {size} m"),
    );
}

/// Runs five seconds: in place from the third second on, and asleep at the end. Times for bodies
/// larger than a meter grow as the root of their size.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "hundreds")]
fn rests(world: &mut World, body: BodyId, (hertz, size): (f32, f32), what: &str) {
    let mut place = Vec3::ZERO;
    let second = hertz * size.max(1.0).sqrt();
    for step in 0..(5.0 * second) as u32 {
        world.step(1.0 / hertz);
        if step == (2.0 * second) as u32 {
            place = world.body(body).unwrap().position();
        }
    }
    let body = world.body(body).unwrap();
    // A joint's compliance may settle by a millimeter per meter.
    assert!((body.position() - place).length() < 1.0e-3 * size, "{what} wanders");
    assert!(body.is_asleep(), "{what} is awake");
}

#[test]
fn a_table_stands_on_its_legs_whatever_they_weigh() {
    for at in SCALES {
        for (mass, leg) in [(60.0, 20.0), (200.0, 20.0), (1200.0, 20.0), (10.0, 40.0)] {
            table(mass, leg, 0.0, at);
        }
        table(1200.0, 20.0, 0.17, at);
    }
}

/// A car of a ton with locked brakes.
fn car(wheel: f32, springs: bool, angle: f32, (hertz, size): (f32, f32)) {
    let mut world = slope(angle);
    let mass = size * size * size;
    let hull = ShapeDef::box_half([1.9 * size, 0.3 * size, 0.8 * size]);
    let def = BodyDef::dynamic().with_position([0.0, 0.75 * size, 0.0]).with_mass(1000.0 * mass);
    let car = world.add_body(def.with_shape(hull)).unwrap();
    let lay = Quat::from_axis_angle([1.0, 0.0, 0.0], FRAC_PI_2);
    let frame = Quat::from_mat3(Mat3 {
        x: vec3(0.0, 1.0, 0.0),
        y: vec3(0.0, 0.0, 1.0),
        z: vec3(1.0, 0.0, 0.0),
    });
    for (x, z) in [(1.3, -0.8), (1.3, 0.8), (-1.3, -0.8), (-1.3, 0.8)] {
        let at = [x * size, 0.33 * size, z * size];
        let tire = ShapeDef::cylinder(0.1 * size, 0.33 * size).with_friction(1.0);
        let def = BodyDef::dynamic().with_position(at).with_rotation(lay).with_mass(wheel * mass);
        let wheel = world.add_body(def.with_shape(tire)).unwrap();
        let spring = JointSpring::new(30_000.0 * size * size, 3_000.0 * size * size);
        let drive = JointDrive::servo(-0.1 * size, spring, f32::INFINITY);
        let lift = JointAxis::limited(-0.2 * size, 0.1 * size).with_drive(drive);
        let lift = if springs { lift } else { JointAxis::LOCKED };
        let brake = JointAxis::driven(JointDrive::motor(0.0, 3000.0 * mass * size));
        let axes = SixDof {
            linear: [lift, JointAxis::LOCKED, JointAxis::LOCKED],
            angular: [JointAxis::LOCKED, brake, JointAxis::LOCKED],
            ..SixDof::FIXED
        };
        let joint = JointDef::new(car, wheel, axes).at(at).with_rotation(frame);
        world.add_joint(joint).unwrap();
    }
    let what =
        format!("wheels of {wheel} kg, springs {springs}, {angle} rad, {hertz} Hz, {size} m");
    rests(&mut world, car, (hertz, size), &what);
}

#[test]
fn a_car_with_its_brakes_locked_stays_where_it_is() {
    for at in SCALES {
        for springs in [false, true] {
            for angle in [0.0, 0.17] {
                car(20.0, springs, angle, at);
            }
        }
        car(100.0, true, 0.17, at);
    }
}

/// Pairs on a hinge, released at random above the ground.
#[test]
fn a_pair_on_a_hinge_that_hits_the_ground_gains_no_energy() {
    let mut state = 99_u64;
    let mut random = |low: f32, high: f32| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        #[expect(clippy::cast_precision_loss, reason = "24 bits")]
        let unit = (state >> 40) as f32 / 16_777_216.0;
        low + (high - low) * unit
    };
    for drop in 0..120_u16 {
        let (size, articulated) = ([1.0_f32, 0.3, 5.0][usize::from(drop % 3)], drop % 2 == 0);
        let mut world = slope(0.0);
        let mut three =
            |half: f32| vec3(random(-half, half), random(-half, half), random(-half, half));
        let rate = size.sqrt();
        let (v, w) = (three(8.0) * rate, three(10.0) * (1.0 / rate));
        let axis = three(1.0);
        let rotation = Quat::from_axis_angle(axis, 3.0 * axis.x);
        let arm = rotation.rotate(vec3(size, 0.0, 0.0));
        let mut add = |offset: Vec3, shape: ShapeDef| {
            let def = BodyDef::dynamic().with_position(vec3(0.0, 1.5 * size, 0.0) + offset);
            let def = def.with_rotation(rotation).with_linear_velocity(v + w.cross(offset));
            world.add_body(def.with_angular_velocity(w).with_shape(shape)).unwrap()
        };
        let a = add(Vec3::ZERO, ShapeDef::box_half(vec3(0.2, 0.15, 0.1) * size));
        let b = add(arm, ShapeDef::sphere(0.3 * size));
        let hinge = Hinge::of(JointAxis::limited(-1.0, 1.0)).six_dof();
        let ends = [vec3(0.5 * size, 0.0, 0.0), vec3(-0.5 * size, 0.0, 0.0)];
        let def = JointDef::new(a, b, hinge).with_anchors(ends[0], ends[1]);
        world.add_joint(def.with_articulated(articulated)).unwrap();
        let start = energy(&world);
        for _ in 0..120 {
            world.step(1.0 / 60.0);
            // The reported energy has an error of half a substep, m g v h/2: less than 2 % for a
            // fall by its size at 8 m/s.
            assert!(energy(&world) < 1.05 * start, "drop {drop}: {} of {start}", energy(&world));
        }
    }
}

/// A gap closes at no more than 3 m/s and by half in a tenth of a second, 13 m/s at most, in the
/// frame of the pair's center. The pair also falls by 3 m.
#[test]
fn a_joint_made_far_off_closes_at_a_bounded_speed_with_bounded_power() {
    for gap in [0.5, 2.0, 10.0, 100.0, 1000.0] {
        for kind in 0..4 {
            let mut world = slope(0.0);
            let mut ball = |at: [f32; 3]| {
                let def = BodyDef::dynamic().with_position(at);
                world.add_body(def.with_shape(ShapeDef::sphere(0.5))).unwrap()
            };
            let (a, b) = (ball([0.0, 3.0, 0.0]), ball([gap + 1.0, 3.3, 0.2]));
            let (at_a, at_b) = ([0.5, 0.0, 0.0], [-0.5, 0.0, 0.0]);
            let hinge = Hinge::new().six_dof();
            let def = match kind {
                0 => JointDef::new(a, b, Ball::new()).with_anchors(at_a, at_b),
                1 => JointDef::new(a, b, Distance::exact(1.0)),
                2 => JointDef::new(a, b, hinge).with_anchors(at_a, at_b),
                _ => {
                    JointDef::new(a, b, Ball::new()).with_anchors(at_a, at_b).with_articulated(true)
                }
            };
            world.add_joint(def).unwrap();
            let mass: f64 =
                world.bodies().map(|body| f64::from(body.mass())).filter(|m| m.is_finite()).sum();
            let most = energy(&world) + 0.5 * mass * 13.0 * 13.0;
            for _ in 0..300 {
                world.step(1.0 / 60.0);
                assert!(energy(&world) < most, "{gap} m, kind {kind}: {} J", energy(&world));
                let fastest = world.bodies().map(|body| body.linear_velocity().length());
                assert!(fastest.fold(0.0, f32::max) < 21.0, "{gap} m, kind {kind}");
            }
        }
    }
}

/// Ground of a ragdoll of ten parts.
#[derive(Clone, Copy, Debug)]
enum Ground {
    Plane,
    Box,
    Mesh,
}

fn add_ground(world: &mut World, ground: Ground, size: f32) {
    let half = 20.0 * size;
    let (shape, y) = match ground {
        Ground::Plane => (ShapeDef::half_space([0.0, 1.0, 0.0], 0.0), 0.0),
        Ground::Box => (ShapeDef::box_half([half, size, half]), -size),
        Ground::Mesh => {
            let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
            let corners = corners.map(|(x, z)| vec3(x * half, 0.0, z * half));
            let mesh = Mesh::new(corners.to_vec(), vec![[0, 2, 1], [0, 3, 2]]).unwrap();
            (ShapeDef::new(Shape::Mesh(Arc::new(mesh))), 0.0)
        }
    };
    let def = BodyDef::fixed().with_position([0.0, y, 0.0]);
    world.add_body(def.with_shape(shape.with_friction(1.0))).unwrap();
}

/// Adds a ragdoll of ten parts, upright at a height, with slight joint friction.
fn add_person(world: &mut World, up: f32, size: f32) -> Vec<BodyId> {
    let mut all = Vec::new();
    let mut add = |x: f32, y: f32, shape: ShapeDef| {
        let def = BodyDef::dynamic().with_position([x * size, (up + y) * size, 0.0]);
        let id = world.add_body(def.with_shape(shape)).unwrap();
        all.push(id);
        id
    };
    let cuboid = |x: f32, y: f32, z: f32| ShapeDef::box_half([x * size, y * size, z * size]);
    let torso = add(0.0, 0.3, cuboid(0.2, 0.3, 0.12));
    let head = add(0.0, 0.78, ShapeDef::sphere(0.14 * size));
    let mut joints = vec![(torso, head, [0.0, 0.62])];
    for side in [-1.0_f32, 1.0] {
        let arm = add(0.4 * side, 0.52, cuboid(0.16, 0.05, 0.05));
        let hand = add(0.74 * side, 0.52, cuboid(0.16, 0.045, 0.045));
        let thigh = add(0.12 * side, -0.25, ShapeDef::capsule(0.15 * size, 0.07 * size));
        let shin = add(0.12 * side, -0.68, ShapeDef::capsule(0.15 * size, 0.06 * size));
        joints.extend([
            (torso, arm, [0.22 * side, 0.52]),
            (arm, hand, [0.57 * side, 0.52]),
            (torso, thigh, [0.12 * side, -0.02]),
            (thigh, shin, [0.12 * side, -0.47]),
        ]);
    }
    for (a, b, [x, y]) in joints {
        let mut axes = ConeTwist::of(JointAxis::limited(-0.5, 0.5), 0.9, 0.9).six_dof();
        // A fortieth of the torque of a horizontal arm, 4 N m at 1 m.
        axes.angular.iter_mut().for_each(|axis| axis.friction = 0.1 * size.powi(4));
        let at = [x * size, (up + y) * size, 0.0];
        let down = Quat::from_arc(Vec3::X, -Vec3::Y);
        let joint = JointDef::new(a, b, axes).at(at).with_rotation(down);
        world.add_joint(joint).unwrap();
    }
    all
}

/// Joints without friction would swing for ever, and joints must not shake limbs that lie on other
/// limbs.
#[test]
fn people_that_fall_come_to_rest() {
    let variants = [
        (30.0, 1.0, Ground::Plane),
        (60.0, 1.0, Ground::Plane),
        (60.0, 1.0, Ground::Box),
        (60.0, 1.0, Ground::Mesh),
        (60.0, 0.1, Ground::Plane),
        (60.0, 10.0, Ground::Box),
        (120.0, 1.0, Ground::Mesh),
    ];
    for (hertz, size, ground) in variants {
        for up in [1.0, 1.3, 1.7] {
            let mut world = World::default();
            add_ground(&mut world, ground, size);
            let all = add_person(&mut world, up, size);
            // Durations of falls grow as the root of lengths.
            let mut left = 20.0 * hertz * size.sqrt().max(1.0);
            let asleep = |world: &World| all.iter().all(|id| world.body(*id).unwrap().is_asleep());
            while left > 0.0 && !asleep(&world) {
                world.step(1.0 / hertz);
                left -= 1.0;
            }
            assert!(asleep(&world), "{hertz} Hz, {size} m, {ground:?}, from {up} m");
        }
    }
}

/// A screw is driven into its stop: a slider of 5 cm that a coupling moves with the rotation, which
/// a motor drives.
#[test]
fn a_motor_against_a_stop_makes_no_more_than_its_work() {
    for (hertz, size) in SCALES {
        let mut world = World::default();
        let mut add = |x: f32, shape: ShapeDef| {
            let def = BodyDef::dynamic().with_position([x, 0.0, 0.0]);
            world.add_body(def.with_shape(shape)).unwrap()
        };
        let nut = add(0.0, ShapeDef::box_half([0.06 * size, 0.05 * size, 0.08 * size]));
        let block = add(0.3 * size, ShapeDef::box_half([0.2 * size, 0.27 * size, 0.3 * size]));
        let torque = 100.0 * size.powi(4);
        let spring = JointSpring::new(7.0 * size.powi(2), 0.0);
        let slide = JointAxis::limited(0.0, 0.05 * size);
        let axes = SixDof {
            linear: [
                JointAxis::LOCKED,
                slide.with_drive(JointDrive::servo(0.0, spring, f32::INFINITY)),
                JointAxis::LOCKED,
            ],
            angular: [
                JointAxis::driven(JointDrive::motor(-1.0, torque)),
                JointAxis::LOCKED,
                JointAxis::LOCKED,
            ],
            ..SixDof::FIXED
        };
        let at = [0.0, 0.02 * size, 0.03 * size];
        let joint = JointDef::new(nut, block, axes).at(at);
        let joint = world.add_joint(joint).unwrap();
        let coupling = CouplingDef {
            joint_a: joint,
            axis_a: Axis::TurnX,
            joint_b: joint,
            axis_b: Axis::Y,
            ratio: size,
            offset: 0.0,
        };
        world.add_coupling(coupling).unwrap();
        let start = energy(&world);
        for step in 0..240_u16 {
            world.step(1.0 / hertz);
            // The motor's torque times its displacement at 1 rad/s. The energy also lags by half a
            // substep of a fall: m g v h/2.
            let seconds = f64::from(step + 1) / f64::from(hertz);
            let fall = 300.0 * size.powi(3) * 9.81 * 9.81 / (16.0 * hertz);
            let most = start + f64::from(torque + fall) * seconds;
            assert!(energy(&world) < most, "{hertz} Hz, {size} m, step {step}: {most}");
        }
    }
}
