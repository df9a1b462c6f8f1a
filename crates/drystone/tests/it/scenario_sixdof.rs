//! Six-axis joints against closed forms.

use std::sync::Arc;

use drystone::joint::{
    ConeTwist, Cylindrical, Hinge, JointAxis, JointDrive, JointMotion, JointSpring, Servo, SixDof,
    Slider, Universal,
};
use drystone::math::trig;
use drystone::method::Method;
use drystone::threads::{SimdLevel, Team};
use drystone::{
    BodyDef, BodyId, JointDef, JointId, JointKind, Quat, ShapeDef, Vec3, World, WorldConfig, vec3,
};

const DT: f32 = 1.0 / 60.0;
const H: f32 = DT / 8.0;
const PI: f32 = core::f32::consts::PI;

fn within(gravity: Vec3) -> World {
    World::new(WorldConfig { gravity, ..WorldConfig::default() }).unwrap()
}

/// A fixed body, and a bar of 1 kg with its left end at the origin, 1 m long along x and 0.1 m
/// thick.
fn bar(world: &mut World) -> [BodyId; 2] {
    let post = world.add_body(BodyDef::fixed()).unwrap();
    let bar = BodyDef::dynamic()
        .with_position([0.5, 0.0, 0.0])
        .with_shape(ShapeDef::box_full([1.0, 0.1, 0.1]))
        .with_mass(1.0);
    let bar = BodyDef { can_sleep: false, ..bar };
    [post, world.add_body(bar).unwrap()]
}

/// Inertia of the bar about z at its end and at its center [kg m²].
const END: f32 = (1.0 + 0.01) / 12.0 + 0.25;
const CENTER: f32 = (1.0 + 0.01) / 12.0;

fn add(world: &mut World, [a, b]: [BodyId; 2], at: Vec3, axis: Vec3, axes: SixDof) -> JointId {
    let def = JointDef::new(a, b, axes).at(at).with_axis(axis);
    world.add_joint(def).unwrap()
}

fn coordinates(world: &World, joint: JointId) -> [Vec3; 2] {
    world.joint(joint).unwrap().coordinates().unwrap()
}

#[test]
fn a_joint_that_held_nothing_holds_when_it_is_told_to() {
    let mut world = within(vec3(0.0, -9.81, 0.0));
    let ids = bar(&mut world);
    let free =
        SixDof { linear: [JointAxis::FREE; 3], angular: [JointAxis::FREE; 3], ..SixDof::FIXED };
    let joint = add(&mut world, ids, Vec3::ZERO, Vec3::X, free);
    for _ in 0..6 {
        world.step(DT);
    }
    // Falling: g t²/2, 0.05 m.
    let fallen = coordinates(&world, joint)[0].length();
    assert!((fallen - 0.5 * 9.81 * 0.01).abs() < 0.01, "{fallen}");
    let JointKind::SixDof(axes) = world.joint(joint).unwrap().kind() else { panic!("six axes") };
    let SixDof { linear, angular, .. } = SixDof::FIXED;
    world.joint_mut(joint).unwrap().set_axes(SixDof { linear, angular, ..axes }).unwrap();
    for _ in 0..120 {
        world.step(DT);
    }
    // Joints close errors by half in a tenth of a second: to rounding in two seconds.
    let [gap, turn] = coordinates(&world, joint);
    assert!(gap.length() < 1.0e-3 && turn.length() < 1.0e-3, "{gap:?} {turn:?}");
}

#[test]
fn a_bar_on_a_hinge_swings_with_the_period_of_a_physical_pendulum() {
    let mut world = within(vec3(9.81, 0.0, 0.0));
    let ids = bar(&mut world);
    // Gravity is along x, so that the bar hangs; it starts at a small speed.
    let joint = add(&mut world, ids, Vec3::ZERO, Vec3::Z, Hinge::new().six_dof());
    let omega = (9.81 * 0.5 / END).sqrt();
    let amplitude = 0.05;
    let mut body = world.body_mut(ids[1]).unwrap();
    body.set_angular_velocity(vec3(0.0, 0.0, amplitude * omega));
    body.set_linear_velocity(vec3(0.0, 0.5 * amplitude * omega, 0.0));
    let (mut last, mut crossings) = (0.0, Vec::new());
    let mut top = 0.0_f32;
    for step in 1..=1800_u16 {
        world.step(DT);
        let angle = coordinates(&world, joint)[1].x;
        if last < 0.0 && angle >= 0.0 {
            crossings.push(f32::from(step) - angle / (angle - last));
        }
        if step > 1500 {
            top = top.max(angle);
        }
        last = angle;
    }
    let n = crossings.len() - 1;
    #[expect(clippy::cast_precision_loss, reason = "a handful")]
    let period = (crossings[n] - crossings[0]) / n as f32 * DT;
    let ideal = 2.0 * PI / omega * (1.0 + amplitude * amplitude / 16.0);
    println!("period {period}, ideal {ideal}, top {top}");
    // Symplectic Euler: (ω h)² / 24, here 3e-6. A crossing is located within (ω dt)²/8 of a step,
    // twice in n periods. f32 rounding of positions of 0.5 m against displacements of 4 mm per
    // step: 1e-5.
    assert!((period / ideal - 1.0).abs() < 2.0e-4, "{period} {ideal}");
    assert!((top / amplitude - 1.0).abs() < 0.01, "{top}");
}

#[test]
fn a_slider_falls_along_its_slope_as_a_body_does() {
    let mut world = within(vec3(0.0, -9.81, 0.0));
    let [post, bar] = bar(&mut world);
    let (s, c) = trig::sin_cos(0.5);
    let (at, axis) = (vec3(0.5, 0.0, 0.0), vec3(c, -s, 0.0));
    let stop = Slider::of(JointAxis::limited(f32::NEG_INFINITY, 5.0)).six_dof();
    let joint = add(&mut world, [post, bar], at, axis, stop);
    let mut steps = 0.0;
    for _ in 0..60 {
        world.step(DT);
        steps += DT;
        let x = coordinates(&world, joint)[0];
        let ideal = 0.5 * 9.81 * s * steps * steps;
        // Symplectic Euler is a h t / 2 ahead.
        let ahead = 0.5 * 9.81 * s * H * steps;
        assert!((x.x - ideal - ahead).abs() < 1.0e-4 * (1.0 + ideal), "{x:?} {ideal}");
        assert!(x.y.abs() < 1.0e-3 && x.z.abs() < 1.0e-4, "{x:?}");
    }
    for _ in 0..120 {
        world.step(DT);
    }
    let [x, turn] = coordinates(&world, joint);
    let force = world.joint(joint).unwrap().force();
    println!("{x:?} {turn:?} {force:?}");
    // At the stop it carries the whole weight, and yields by its softness: load / (m ω²), ω = 2 π
    // 120.
    assert!((x.x - 5.0).abs() < 1.0e-4, "{x:?}");
    // Positions of 4.4 m are accurate to 2.4e-7 m, which the stop's m ω² turns into 0.14 N.
    assert!((force - vec3(0.0, 9.81, 0.0)).length() < 0.14, "{force:?}");
    assert!(turn.length() < 1.0e-4, "{turn:?}");
}

#[test]
fn a_hinge_stops_at_its_limit() {
    let mut world = within(vec3(0.0, -9.81, 0.0));
    let ids = bar(&mut world);
    let axes = Hinge::of(JointAxis::limited(-0.5, 0.2)).six_dof();
    let joint = add(&mut world, ids, Vec3::ZERO, Vec3::Z, axes);
    let mut least = 0.0_f32;
    for _ in 0..240 {
        world.step(DT);
        least = least.min(coordinates(&world, joint)[1].x);
    }
    let rest = coordinates(&world, joint)[1].x;
    let joint = world.joint(joint).unwrap();
    let (force, torque) = (joint.force(), joint.torque());
    println!("least {least}, rest {rest}, {force:?} {torque:?}");
    let moment = 9.81 * 0.5 * trig::sin_cos(0.5).1;
    assert!((torque - vec3(0.0, 0.0, moment)).length() < 0.01 * moment, "{torque:?}");
    assert!((force - vec3(0.0, 9.81, 0.0)).length() < 0.05, "{force:?}");
    // The limit acts ahead of time, so that the only overshoot is the rotation by the residual
    // speed of a substep's sweep. At rest it yields by torque / (I ω²).
    let sag = moment / (END * (2.0 * PI * 72.0) * (2.0 * PI * 72.0));
    assert!(rest > -0.5 - 4.0 * sag && rest < -0.4999, "{rest} {sag}");
    let speed = (2.0 * moment / END).sqrt();
    assert!(least > -0.5 - speed * H, "{least}");
}

#[test]
fn a_beam_of_two_bodies_carries_its_moment() {
    let mut world = within(vec3(0.0, -9.81, 0.0));
    let [post, first] = bar(&mut world);
    let second = BodyDef::dynamic()
        .with_position([1.5, 0.0, 0.0])
        .with_shape(ShapeDef::box_full([1.0, 0.1, 0.1]))
        .with_mass(1.0);
    let second = world.add_body(BodyDef { can_sleep: false, ..second }).unwrap();
    let root = add(&mut world, [post, first], Vec3::ZERO, Vec3::X, SixDof::FIXED);
    let middle = add(&mut world, [first, second], Vec3::X, Vec3::X, SixDof::FIXED);
    for _ in 0..300 {
        world.step(DT);
    }
    let read = |id| {
        let joint = world.joint(id).unwrap();
        (joint.force(), joint.torque())
    };
    let (root, middle) = (read(root), read(middle));
    let sag = world.body(second).unwrap().position().y;
    println!("root {root:?} middle {middle:?} sag {sag}");
    let near = |x: Vec3, y: Vec3, part: f32| (x - y).length() < part * y.length();
    assert!(near(root.0, vec3(0.0, 2.0 * 9.81, 0.0), 0.005), "{root:?}");
    assert!(near(root.1, vec3(0.0, 0.0, 2.0 * 9.81), 0.005), "{root:?}");
    assert!(near(middle.0, vec3(0.0, 9.81, 0.0), 0.005), "{middle:?}");
    assert!(near(middle.1, vec3(0.0, 0.0, 0.5 * 9.81), 0.005), "{middle:?}");
    // Each joint is a spring of 72 Hz on its load: an angle of M / (K⁻¹ ω²), with K⁻¹ at least the
    // inertia of one bar about its center. Twice that bound, for the residual of the sweeps.
    let omega = 2.0 * PI * 72.0;
    let most = 2.0 * (2.0 * 9.81 * 1.5 + 0.5 * 9.81 * 0.5) / (CENTER * omega * omega);
    assert!(sag < 0.0 && sag > -most, "{sag} {most}");
}

#[test]
fn a_motor_accelerates_by_its_torque_and_holds_its_speed() {
    let mut world = within(Vec3::ZERO);
    let ids = bar(&mut world);
    let motor = JointAxis::driven(JointDrive::motor(3.0, 0.5));
    let joint = add(&mut world, ids, Vec3::ZERO, Vec3::Z, Hinge::of(motor).six_dof());
    for _ in 0..60 {
        world.step(DT);
    }
    let w = world.body(ids[1]).unwrap().angular_velocity().z;
    let ideal = 0.5 / END;
    println!("{w} {ideal}");
    assert!((w / ideal - 1.0).abs() < 2.0e-3, "{w} {ideal}");
    let torque = world.joint(joint).unwrap().torque().z;
    assert!((torque - 0.5).abs() < 1.0e-4, "{torque:?}");
    for _ in 0..300 {
        world.step(DT);
    }
    let w = world.body(ids[1]).unwrap().angular_velocity().z;
    assert!((w - 3.0).abs() < 1.0e-3, "{w}");
    // Angles continue to count over full turns.
    assert!(coordinates(&world, joint)[1].x > 2.0 * PI);
    // With a target speed of 0 it is a brake: 0.5 N m against 3 rad/s takes 3 I / 0.5 s.
    world.joint_mut(joint).unwrap().set_drive(Some(JointDrive::motor(0.0, 0.5))).unwrap();
    for _ in 0..60 {
        world.step(DT);
    }
    let w = world.body(ids[1]).unwrap().angular_velocity().z;
    assert!((w - (3.0 - 0.5 / END)).abs() < 5.0e-3, "{w}");
    world.joint_mut(joint).unwrap().set_drive(None).unwrap();
    for _ in 0..60 {
        world.step(DT);
    }
    let free = world.body(ids[1]).unwrap().angular_velocity().z;
    assert!((w - free).abs() < 5.0e-3, "{w} {free}");
}

#[test]
fn springs_swing_with_the_frequency_of_their_stiffness_and_servos_arrive() {
    // 1 kg on 40 N/m, and on a spring of the same frequency given in Hz.
    let omega = 40.0_f32.sqrt();
    for spring in [JointSpring::new(40.0, 0.0), JointSpring::hertz(omega / (2.0 * PI), 0.0)] {
        let mut world = within(Vec3::ZERO);
        let ids = bar(&mut world);
        let drive = JointDrive::servo(0.1, spring, f32::INFINITY);
        let axes = Slider::of(JointAxis::driven(drive)).six_dof();
        let joint = add(&mut world, ids, vec3(0.5, 0.0, 0.0), Vec3::X, axes);
        let (mut last, mut crossings) = (0.0, Vec::new());
        for step in 1..=600_u16 {
            world.step(DT);
            let x = coordinates(&world, joint)[0].x - 0.1;
            if last < 0.0 && x >= 0.0 {
                crossings.push(f32::from(step) - x / (x - last));
            }
            last = x;
        }
        let n = crossings.len() - 1;
        #[expect(clippy::cast_precision_loss, reason = "a handful")]
        let period = (crossings[n] - crossings[0]) / n as f32 * DT;
        println!("{period} {}", 2.0 * PI / omega);
        // Located within (ω dt)²/8 of a step, in 10 periods.
        assert!((period * omega / (2.0 * PI) - 1.0).abs() < 1.0e-4, "{period}");
    }
    let mut world = within(vec3(0.0, -9.81, 0.0));
    let ids = bar(&mut world);
    let spring = JointSpring::new(200.0, 40.0);
    let drive = JointDrive::servo(0.7, spring, f32::INFINITY);
    let axes = Hinge::of(JointAxis::driven(drive)).six_dof();
    let joint = add(&mut world, ids, Vec3::ZERO, Vec3::Z, axes);
    for _ in 0..600 {
        world.step(DT);
    }
    let angle = coordinates(&world, joint)[1].x;
    // It rests where 200 (0.7 - angle) equals the weight's moment.
    let balance = 200.0 * (0.7 - angle) - 9.81 * 0.5 * trig::sin_cos(angle).1;
    println!("{angle} {balance}");
    assert!(balance.abs() < 0.02, "{angle}");
}

#[test]
fn a_soft_limit_rests_where_its_spring_carries_the_weight() {
    let mut world = within(vec3(0.0, -9.81, 0.0));
    let ids = bar(&mut world);
    let spring = Some(JointSpring::new(500.0, 30.0));
    let axis = JointAxis {
        motion: JointMotion::Limited { min: -1.0, max: 1.0, spring },
        ..JointAxis::FREE
    };
    let joint = add(&mut world, ids, vec3(0.5, 0.0, 0.0), Vec3::Y, Slider::of(axis).six_dof());
    for _ in 0..600 {
        world.step(DT);
    }
    let y = coordinates(&world, joint)[0].x;
    assert!((y + 1.0 + 9.81 / 500.0).abs() < 1.0e-4, "{y}");
}

/// Kinetic energy and energy of springs.
fn energy(world: &World) -> f64 {
    let e = world.audit().energy;
    e.linear + e.angular + e.elastic
}

#[test]
fn a_spring_per_mass_is_one_on_the_whole_mass_wherever_its_anchor_is() {
    // A slider held 2 m beside the bar, which must not rotate: 1 kg on 40 N/m all the same. Then
    // about an axis that is not a principal one, with the inertia about it at the anchor.
    let omega = 40.0_f32.sqrt();
    let spring = JointSpring::hertz(omega / (2.0 * PI), 0.0);
    let drive = JointAxis::driven(JointDrive::servo(0.1, spring, f32::INFINITY));
    let slider = (Slider::of(drive).six_dof(), vec3(0.3, 0.9, 0.5), 0);
    let hinge = (Hinge::of(drive).six_dof(), vec3(1.0, 1.0, 1.0), 1);
    for (axes, axis, which) in [slider, hinge] {
        let mut world = within(Vec3::ZERO);
        let ids = bar(&mut world);
        let joint = add(&mut world, ids, vec3(0.5, 0.5, 2.0), axis, axes);
        let start = energy(&world);
        let (mut last, mut crossings, mut seen) = (0.0, Vec::new(), [0.0_f64; 2]);
        for step in 1..=600_u16 {
            world.step(DT);
            let x = coordinates(&world, joint)[which].x - 0.1;
            if last < 0.0 && x >= 0.0 {
                crossings.push(f32::from(step) - x / (x - last));
            }
            last = x;
            let second = if step <= 60 { &mut seen[0] } else { &mut seen[1] };
            if step <= 60 || step > 540 {
                *second = second.max(energy(&world) / start);
            }
        }
        let n = crossings.len() - 1;
        #[expect(clippy::cast_precision_loss, reason = "a handful")]
        let period = (crossings[n] - crossings[0]) / n as f32 * DT;
        println!("{period} {}", 2.0 * PI / omega);
        assert!((period * omega / (2.0 * PI) - 1.0).abs() < 1.0e-3, "{which}: {period}");
        // Velocities are half a substep ahead of positions: ω h / 2 of the energy oscillates. From
        // the first second to the last it is constant.
        let [first, end] = seen;
        println!("energy {first} {end}");
        assert!((first - 1.0).abs() < f64::from(omega * H), "{which}: {first}");
        assert!((end - first).abs() < 0.02, "{which}: {first} {end}");
    }
}

#[test]
fn damped_springs_decay_as_they_should_at_any_frequency() {
    for hertz in [1.0, 4.0, 15.0] {
        for ratio in [0.0, 0.05, 0.3] {
            let mut world = within(vec3(0.0, -9.81, 0.0));
            let ids = bar(&mut world);
            let spring = JointSpring::hertz(hertz, ratio);
            let axes =
                Slider::of(JointAxis::driven(JointDrive::servo(0.0, spring, 1.0e9))).six_dof();
            let joint = add(&mut world, ids, vec3(0.5, 0.0, 0.0), Vec3::Y, axes);
            // It starts without the stretch by its weight, and swings about that.
            let omega = 2.0 * PI * hertz;
            let rest = -9.81 / (omega * omega);
            let mut most = 0.0_f32;
            let damped = omega * (1.0 - ratio * ratio).sqrt();
            for step in 1..=120_u16 {
                world.step(DT);
                let x = coordinates(&world, joint)[0].x;
                let t = f32::from(step) * DT;
                let (s, c) = trig::sin_cos(damped * t);
                let decay = (-f64::from(ratio * omega * t)).exp();
                #[expect(clippy::cast_possible_truncation, reason = "at most 1")]
                let exact = rest - rest * decay as f32 * (c + ratio * omega / damped * s);
                most = most.max((x - exact).abs() / rest.abs());
            }
            println!("{hertz} {ratio} {most}");
            // Gravity acts at the start of a substep: half a substep of the swing.
            assert!(most < 0.6 * omega * H + 1.0e-3, "{hertz} {ratio}: {most}");
        }
    }
}

#[test]
fn a_cone_holds_the_swing_in_every_direction() {
    for (i, way) in [[1.0, 0.0], [0.0, 1.0], [0.6, 0.8], [-0.8, 0.6]].into_iter().enumerate() {
        let mut world = within(Vec3::ZERO);
        let ids = bar(&mut world);
        let axes = ConeTwist::of(JointAxis::limited(-0.2, 0.2), 0.6, 0.3).six_dof();
        let joint = add(&mut world, ids, Vec3::ZERO, Vec3::X, axes);
        // Torque about y and z together, and about x.
        let torque = vec3(0.5, 2.0 * way[0], 2.0 * way[1]);
        let mut most = 0.0_f32;
        for _ in 0..240 {
            let mut body = world.body_mut(ids[1]).unwrap();
            body.add_step_torque(torque);
            world.step(DT);
            most = most.max(world.joint(joint).unwrap().angular_error());
        }
        let [_, turns] = coordinates(&world, joint);
        println!("{i}: {turns:?} off {most}");
        // The limit is recomputed in each step while the swing continues: at most a step's rotation
        // beyond, at the speed that the torque gives over the whole cone, √(2 τ φ / I).
        let speed = (2.0_f32 * 2.0 * 0.6 / END).sqrt();
        assert!(most < speed * DT, "{i}: {most}");
        // It comes to rest on the rim, and at the limit of twist, which yields by τ / (I ω²).
        let rest = world.joint(joint).unwrap().angular_error();
        let sag = 0.5 / (0.02 / 12.0 * (2.0 * PI * 72.0) * (2.0 * PI * 72.0));
        assert!(rest < 2.0 * sag, "{i}: {rest} {sag}");
        assert!((turns.x - 0.2).abs() < 2.0 * sag, "{i}: {turns:?}");
        let (y, z) = (turns.y / 0.6, turns.z / 0.3);
        assert!(y * y + z * z > 0.98, "{i}: {turns:?}");
    }
}

#[test]
fn a_servo_takes_a_body_to_a_pose_and_no_harder_than_it_may() {
    let mut world = within(Vec3::ZERO);
    let ids = bar(&mut world);
    let spring = JointSpring::hertz(2.0, 1.0);
    let pose = Quat::from_axis_angle([0.0, 1.0, 0.0], 1.0);
    let servo = SixDof { frame_b: pose.conjugate(), ..Servo::new(spring, 5.0, 1.0).six_dof() };
    let def = JointDef::new(ids[0], ids[1], servo).with_anchors(vec3(3.0, 1.0, 0.0), Vec3::ZERO);
    let joint = world.add_joint(def).unwrap();
    world.step(DT);
    let read = world.joint(joint).unwrap();
    // Each axis separately.
    let most = [read.force().abs().max_element(), read.torque().abs().max_element()];
    assert!(most[0] < 5.0 * 1.0001 && most[0] > 4.99, "{most:?}");
    for _ in 0..600 {
        world.step(DT);
    }
    let body = world.body(ids[1]).unwrap();
    assert!((body.position() - vec3(3.0, 1.0, 0.0)).length() < 1.0e-4, "{:?}", body.position());
    let off = (pose.conjugate() * body.rotation()).to_rotation_vector();
    assert!(off.length() < 1.0e-3, "{off:?}");
}

/// A row of bars on joints of every kind, rotating and held by a kinematic body.
fn menagerie(level: SimdLevel, threads: usize) -> World {
    let mut world = World::default();
    world.set_simd_level(level);
    if threads > 1 {
        world.set_executor(Arc::new(Team::new(threads)));
    }
    let spin =
        BodyDef::kinematic().with_position([-1.0, 0.0, 0.0]).with_angular_velocity([0.0, 1.0, 0.3]);
    let mut last = world.add_body(spin).unwrap();
    let servo = JointDrive::servo(0.4, JointSpring::hertz(3.0, 0.7), 100.0);
    let kinds = [
        SixDof::FIXED,
        Hinge::of(JointAxis::limited(-0.3, 0.6).with_drive(JointDrive::motor(2.0, 3.0))).six_dof(),
        Slider::of(JointAxis::limited(-0.1, 0.1)).six_dof(),
        Cylindrical::of(JointAxis::limited(-0.1, 0.2).with_drive(servo), JointAxis::FREE).six_dof(),
        Universal::of(JointAxis::limited(-0.5, 0.5), JointAxis::FREE).six_dof(),
        ConeTwist::of(JointAxis::limited(-0.3, 0.3), 0.5, 0.3).six_dof(),
        Hinge::new().six_dof(),
    ];
    for (i, axes) in (0_u16..).zip((0..40).map(|i| kinds[i % kinds.len()])) {
        let x = f32::from(i) * 0.5;
        let def = BodyDef::dynamic()
            .with_position([x, 0.0, 0.0])
            .with_shape(ShapeDef::box_full([0.4, 0.1, 0.1]));
        let body = world.add_body(def).unwrap();
        let axis = [Vec3::X, Vec3::Y, Vec3::Z][usize::from(i) % 3];
        add(&mut world, [last, body], vec3(x - 0.25, 0.0, 0.0), axis, axes);
        last = if i % 10 == 9 { world.add_body(BodyDef::fixed()).unwrap() } else { body };
    }
    world
}

#[test]
fn every_kind_gives_the_same_bits_for_any_threads_and_width() {
    let run = |level, threads| {
        let mut world = menagerie(level, threads);
        for _ in 0..120 {
            world.step(DT);
        }
        assert!(world.audit().non_finite.is_empty());
        let worst = world.joints().map(|j| j.error()).fold(0.0, f32::max);
        (world.state_hash(), worst)
    };
    let reference = run(SimdLevel::best(), 1);
    println!("error {}", reference.1);
    for level in SimdLevel::available() {
        for threads in [1, 3] {
            assert_eq!(run(level, threads), reference, "{} {threads}", level.name());
        }
    }
}

/// A bar on a spring with friction swings in half periods about the balance of the two. Every swing
/// ends 2 F / k nearer, and it stops where the spring is weaker than friction.
#[test]
fn friction_beside_a_spring_takes_as_much_from_every_swing() {
    const K: f32 = 10.0;
    const F: f32 = 0.2;
    for articulated in [false, true] {
        for (start, swings) in [(0.21, 5), (0.015, 0)] {
            let mut world = within(Vec3::ZERO);
            let [post, bar] = bar(&mut world);
            let spring = JointDrive::servo(start, JointSpring::new(K, 0.0), f32::INFINITY);
            let axes = Slider::of(JointAxis::driven(spring).with_friction(F)).six_dof();
            let def = JointDef::new(post, bar, axes).at(Vec3::ZERO).with_axis(Vec3::X);
            let joint = world.add_joint(JointDef { articulated, ..def }).unwrap();
            let mut ends = vec![-start];
            let mut way = 1.0;
            let mut last = -start;
            for _ in 0..600 {
                world.step(DT);
                let x = coordinates(&world, joint)[0].x - start;
                // A bar at rest may tremble in its last bits.
                if (x - last) * way < -1.0e-6 {
                    ends.push(last);
                    way = -way;
                }
                last = x;
            }
            if swings > 0 {
                ends.push(last);
            } else {
                assert!((last + start).abs() < 1.0e-6, "{articulated} {last}");
            }
            println!("{articulated}: {ends:?}");
            assert_eq!(ends.len(), swings + 1, "{ends:?}");
            // Each end is located within half a step: a dt² / 8 short, for two ends. The same again
            // for the substep in which the bar turns back, which friction affects completely.
            let within = (K * start + F) * DT * DT / 2.0;
            for pair in ends.windows(2) {
                let nearer = pair[0].abs() - pair[1].abs();
                assert!((nearer - 2.0 * F / K).abs() < within, "{articulated} {nearer} {ends:?}");
            }
        }
    }
}

#[test]
fn joints_that_make_no_sense_are_refused() {
    let mut world = World::default();
    let [post, bar] = bar(&mut world);
    let other = world.add_body(BodyDef::fixed()).unwrap();
    let field = |def| world.clone().add_joint(def).unwrap_err().field().to_owned();
    let six = |axes| JointDef::new(post, bar, axes);
    let nan = Quat::new(f32::NAN, 0.0, 0.0, 1.0);
    assert_eq!(field(six(SixDof { frame_a: nan, ..SixDof::FIXED })), "frame_a");
    let back = JointAxis::limited(1.0, 0.0);
    assert_eq!(field(six(Hinge::of(back).six_dof())), "angular[0].max");
    let nan = JointAxis::limited(f32::NAN, 0.0);
    assert_eq!(field(six(Slider::of(nan).six_dof())), "linear[0].min");
    let servo = JointDrive::servo(0.0, JointSpring::new(-1.0, 0.0), 1.0);
    let refused = field(six(Slider::of(JointAxis::driven(servo)).six_dof()));
    assert_eq!(refused, "linear[0].drive.stiffness");
    let motor = JointAxis::driven(JointDrive::motor(1.0, f32::NAN));
    assert_eq!(field(six(Slider::of(motor).six_dof())), "linear[0].drive.max_force");
    let rough = JointAxis::FREE.with_friction(-1.0);
    assert_eq!(field(six(Hinge::of(rough).six_dof())), "angular[0].friction");
    let cone = ConeTwist::new(0.5, 0.5).six_dof();
    let angular = [JointAxis::FREE, rough.with_friction(1.0), JointAxis::FREE];
    assert_eq!(field(six(SixDof { angular, ..cone })), "angular[2].friction");
    let itself = JointDef { body_b: post, ..six(SixDof::FIXED) };
    assert_eq!(field(itself), "body_b");
    assert_eq!(field(JointDef { body_b: other, ..six(SixDof::FIXED) }), "body_b");
    for axis in [Vec3::ZERO, vec3(f32::NAN, 0.0, 0.0)] {
        let refused = world
            .place_joint(JointDef::new(post, bar, SixDof::FIXED).at(Vec3::ZERO).with_axis(axis));
        assert_eq!(refused.unwrap_err().field(), "world_axes.x");
    }
}

#[test]
fn every_method_holds_them() {
    for name in Method::NAMES {
        let mut world = within(vec3(0.0, -9.81, 0.0));
        let method = Method::named(name).unwrap();
        world = World::new(WorldConfig { method, ..world.config().clone() }).unwrap();
        let ids = bar(&mut world);
        let axes = Hinge::of(JointAxis::limited(-0.5, 0.2)).six_dof();
        let joint = add(&mut world, ids, Vec3::ZERO, Vec3::Z, axes);
        for _ in 0..240 {
            world.step(DT);
        }
        let [gap, turns] = coordinates(&world, joint);
        println!("{name}: {gap:?} {turns:?}");
        // The coarsest methods take one step of 1/60 s, in which a weight falls 2.7 mm. They remove
        // a fifth of an error per step and solve each row separately: the fall of some steps.
        assert!(gap.length() < 0.05, "{name}: {gap:?}");
        assert!((turns.x + 0.5).abs() < 0.1, "{name}: {turns:?}");
    }
}

/// A friction of 6 N m holds a weight of 4.9 N m, one of 4 N m does not.
#[test]
fn every_method_holds_by_friction() {
    for name in Method::NAMES {
        for (friction, holds) in [(6.0, true), (4.0, false)] {
            let gravity = vec3(0.0, -9.81, 0.0);
            let method = Method::named(name).unwrap();
            let mut world =
                World::new(WorldConfig { gravity, method, ..WorldConfig::default() }).unwrap();
            let ids = bar(&mut world);
            let axes = Hinge::of(JointAxis::FREE.with_friction(friction)).six_dof();
            let joint = add(&mut world, ids, Vec3::ZERO, Vec3::Z, axes);
            for _ in 0..30 {
                world.step(DT);
            }
            let [_, turns] = coordinates(&world, joint);
            println!("{name}: {turns:?}");
            // Falling freely against 4 N m it rotates by 0.9 N m / END · 0.25 s² / 2 = 0.34 rad.
            // The coarsest method solves rows separately, so that the joint's own sweeps leave some
            // rotation: see above.
            assert_eq!(turns.x.abs() < 0.05, holds, "{name} {friction}: {turns:?}");
        }
    }
}
