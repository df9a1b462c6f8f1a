//! Named joints: the freedoms of each, the signs of its coordinates, its motors and limits, and its
//! placement by points of the world.

use drystone::joint::{
    Ball, ConeTwist, Cylindrical, Distance, Fixed, Hinge, JointAxis, JointDrive, JointSpring,
    Planar, Pulley, Rope, Servo, SixDof, Slider, Spring, Universal, Wheel,
};
use drystone::{
    Axis, BodyDef, BodyId, JointDef, JointId, JointKind, Pose, Quat, ShapeDef, Vec3, World,
    WorldConfig, vec3,
};

const DT: f32 = 1.0 / 60.0;
const SUBSTEP: f32 = DT / 8.0;
const G: f32 = 9.81;

fn world(gravity: f32) -> World {
    let gravity = vec3(0.0, -gravity, 0.0);
    World::new(WorldConfig { gravity, ..WorldConfig::default() }).unwrap()
}

/// A rotation about a generic axis.
fn tilt(k: f32) -> Quat {
    Quat::from_axis_angle(vec3(1.0, -2.0, 0.5 + k).normalize_or(Vec3::X), 0.7 + k)
}

/// A post and a ball of 1 kg and 0.1 kg m² about any axis, both at generic rotations.
fn post_and_ball(world: &mut World, at: Vec3) -> [BodyId; 2] {
    let post = BodyDef::fixed().with_position([3.0, -1.0, 2.0]).with_rotation(tilt(0.0));
    let ball = BodyDef::dynamic().with_position(at).with_rotation(tilt(1.0));
    // 2/5 m r² is 0.1 kg m².
    let ball = ball.with_shape(ShapeDef::sphere(0.5)).with_mass(1.0);
    [world.add_body(post).unwrap(), world.add_body(ball).unwrap()]
}

fn steps(world: &mut World, count: u32) {
    for _ in 0..count {
        world.step(DT);
    }
}

fn turn_of(world: &World, joint: JointId) -> f32 {
    world.joint(joint).unwrap().angle().unwrap()
}

/// The axes of the joint in the world.
fn frame() -> Quat {
    Quat::from_axis_angle(vec3(2.0, 1.0, -1.0).normalize_or(Vec3::X), 1.1)
}

/// Displacement and rotation of a body along and about these axes, from its poses alone.
fn went(from: Pose, to: Pose, axes: Quat) -> [f32; 6] {
    let moved = axes.unrotate(to.position - from.position);
    let turn = (to.rotation * from.rotation.conjugate()).to_rotation_vector();
    let turned = axes.unrotate(turn);
    [moved.x, moved.y, moved.z, turned.x, turned.y, turned.z]
}

/// Every name, and the axes that it leaves free.
fn names() -> Vec<(&'static str, JointKind, &'static [Axis])> {
    use Axis::{TurnX, TurnY, TurnZ, X, Y, Z};
    let loose = JointSpring::new(0.0, 0.0);
    vec![
        ("ball", Ball::new().into(), &[TurnX, TurnY, TurnZ]),
        ("ball that rubs", Ball::new().with_friction(1.0e-6).into(), &[TurnX, TurnY, TurnZ]),
        ("cone-twist", ConeTwist::new(0.5, 0.7).into(), &[TurnX, TurnY, TurnZ]),
        ("cone of a ball", Ball::new().with_cone(0.5).into(), &[TurnX, TurnY, TurnZ]),
        ("hinge", Hinge::new().into(), &[TurnX]),
        ("slider", Slider::new().into(), &[X]),
        ("cylinder", Cylindrical::new().into(), &[X, TurnX]),
        ("universal", Universal::new().into(), &[TurnX, TurnY]),
        ("planar", Planar::new().into(), &[Y, Z, TurnX]),
        ("fixed", Fixed::new().into(), &[]),
        ("axle", Wheel::rigid().into(), &[TurnY]),
        ("wheel", Wheel::new(loose).into(), &[X, TurnY]),
        (
            "steered wheel",
            Wheel::new(loose).with_steering(0.0, loose, 0.0).into(),
            &[X, TurnX, TurnY],
        ),
        ("hand", Servo::grab(loose, 0.0).into(), Axis::ALL),
    ]
}

#[test]
fn each_name_leaves_exactly_its_freedoms() {
    let (speed, count) = (0.4, 30);
    for (name, kind, free) in names() {
        for axis in Axis::ALL {
            let mut world = world(0.0);
            let at = vec3(1.0, 2.0, -0.5);
            let [post, ball] = post_and_ball(&mut world, at);
            let def = JointDef::new(post, ball, kind).at(at).with_rotation(frame());
            world.add_joint(def).unwrap();
            let unit = [Vec3::X, Vec3::Y, Vec3::Z][axis.index() % 3];
            let push = frame().rotate(unit) * speed;
            let mut body = world.body_mut(ball).unwrap();
            if axis.is_turn() {
                body.set_angular_velocity(push);
            } else {
                body.set_linear_velocity(push);
            }
            let before = world.body(ball).unwrap().pose();
            steps(&mut world, count);
            let went = went(before, world.body(ball).unwrap().pose(), frame());
            let way = speed * DT * 30.0;
            let what = format!("{name}, {axis}: {went:?}");
            if free.contains(axis) {
                assert!((went[axis.index()] / way - 1.0).abs() < 0.01, "{what}");
            } else {
                // A locked axis takes the impulse in the first substep, and recovers the delay.
                assert!(went.iter().all(|x| x.abs() < speed * SUBSTEP), "{what}");
            }
        }
    }
}

#[test]
fn a_rod_holds_both_ways_a_rope_one_way_and_a_spring_neither() {
    let kinds: [(&str, JointKind, [bool; 2]); 4] = [
        ("rod", Distance::exact(1.0).into(), [true, true]),
        ("rope", Rope::new(1.0).into(), [false, true]),
        ("strut", Distance::between(1.0, 9.0).into(), [true, false]),
        ("spring", Spring::new(1.0, 1.0e-3, 0.0).into(), [false, false]),
    ];
    for (name, kind, holds) in kinds {
        for (speed, holds) in [-0.4, 0.4].into_iter().zip(holds) {
            let mut world = world(0.0);
            let (at, away) = (vec3(1.0, 2.0, -0.5), frame().rotate(Vec3::X));
            let [post, ball] = post_and_ball(&mut world, at + away);
            let def = JointDef::new(post, ball, kind).between(at, at + away);
            let joint = world.add_joint(def).unwrap();
            assert!((world.joint(joint).unwrap().length() - 1.0).abs() < 1.0e-6);
            world.body_mut(ball).unwrap().set_linear_velocity(away * speed);
            steps(&mut world, 30);
            let moved = world.joint(joint).unwrap().length() - 1.0;
            let free = speed * DT * 30.0;
            let what = format!("{name} at {speed} m/s: {moved} m");
            if holds {
                // It takes the impulse in the first substep. A one-sided joint lets the body
                // return.
                assert!(moved * speed.signum() < 0.4 * SUBSTEP, "{what}");
                assert!(name != "rod" || moved.abs() < 0.4 * SUBSTEP, "{what}");
            } else {
                assert!((moved / free - 1.0).abs() < 0.01, "{what}");
            }
        }
    }
}

#[test]
fn numbers_count_by_the_right_hand_from_the_first_body() {
    let axis = frame().rotate(Vec3::X);
    for (along, about) in [(0.2, 0.3), (-0.15, -1.2)] {
        let mut world = world(0.0);
        let at = vec3(1.0, 2.0, -0.5);
        let a = BodyDef::kinematic().with_position([3.0, -1.0, 2.0]).with_rotation(tilt(0.0));
        let a = world.add_body(a).unwrap();
        let [_, b] = post_and_ball(&mut world, at);
        let def = JointDef::new(a, b, Cylindrical::new()).at(at).with_axis(axis);
        let joint = world.add_joint(def).unwrap();
        let read = |world: &World| {
            let joint = world.joint(joint).unwrap();
            let (slide, turn) = (joint.slider().unwrap(), joint.hinge().unwrap());
            assert_eq!((slide.axis(), turn.axis()), (Axis::X, Axis::TurnX));
            assert!((slide.direction() - axis).length() < 1.0e-5);
            [slide.position(), turn.position(), slide.speed(), turn.speed()]
        };
        assert!(read(&world).iter().all(|x| x.abs() < 1.0e-5));
        let pose = world.body(b).unwrap().pose();
        let turn = Quat::from_axis_angle(axis, about) * pose.rotation;
        let mut body = world.body_mut(b).unwrap();
        body.set_pose(Pose::new(pose.position + axis * along, turn));
        body.set_linear_velocity(axis * 0.7);
        body.set_angular_velocity(axis * 2.0);
        world.body_mut(a).unwrap().set_linear_velocity(axis * 0.5);
        world.body_mut(a).unwrap().set_angular_velocity(axis * 3.5);
        let expected = [along, about, 0.2, -1.5];
        for (is, should) in read(&world).into_iter().zip(expected) {
            // A few products of numbers up to 5 in f32.
            assert!((is - should).abs() < 5.0e-6, "{is}, {should}");
        }
    }
}

#[test]
fn angles_of_a_hinge_count_turns_both_ways() {
    for speed in [3.0, -3.0] {
        let mut world = world(0.0);
        let [post, ball] = post_and_ball(&mut world, Vec3::ZERO);
        let def = JointDef::new(post, ball, Hinge::new().with_motor(speed, 1.0e6));
        let joint = world.add_joint(def.at(Vec3::ZERO).with_axis(Vec3::Z)).unwrap();
        steps(&mut world, 300);
        // The motor reaches its speed in the first substep.
        let turn = turn_of(&world, joint);
        assert!((turn - 5.0 * speed).abs() < 3.0 * SUBSTEP * 2.0, "{turn} rad");
        let w = world.body(ball).unwrap().angular_velocity().z;
        assert!((w - speed).abs() < 1.0e-3, "{w} rad/s");
    }
}

#[test]
fn motors_lead_to_the_limit_of_their_sign() {
    for (speed, end) in [(2.0, 0.9), (-2.0, -0.4)] {
        let mut world = world(0.0);
        let [post, ball] = post_and_ball(&mut world, Vec3::ZERO);
        let hinge = Hinge::new().with_limits(-0.4, 0.9).with_motor(speed, 10.0);
        let hinge = JointDef::new(post, ball, hinge).at(Vec3::ZERO).with_rotation(frame());
        let hinge = world.add_joint(hinge).unwrap();
        let [post, ball] = post_and_ball(&mut world, vec3(0.0, 9.0, 0.0));
        let slider = Slider::new().with_limits(-0.4, 0.9).with_motor(speed, 10.0);
        let slider = JointDef::new(post, ball, slider).at(Vec3::Y * 9.0).with_rotation(frame());
        let slider = world.add_joint(slider).unwrap();
        steps(&mut world, 120);
        // A hard stop yields by force over (2π · 60 Hz)²: 10 N on 1 kg by 0.07 mm, 10 N m on 0.1 kg
        // m² by 0.7 mrad.
        let turn = world.joint(hinge).unwrap().hinge().unwrap();
        assert!((turn.position() - end).abs() < 1.0e-3, "{} rad", turn.position());
        assert_eq!(turn.limits(), Some((-0.4, 0.9)));
        // The motor pushes against the stop with its maximum torque, and the stop holds it.
        assert!((turn.drive_force() - 10.0 * speed.signum()).abs() < 1.0e-3);
        assert!(turn.force().abs() < 1.0e-2, "{}", turn.force());
        let slide = world.joint(slider).unwrap().slider().unwrap();
        assert!((slide.position() - end).abs() < 1.0e-3, "{} m", slide.position());
        assert!((slide.drive_force() - 10.0 * speed.signum()).abs() < 1.0e-3);
    }
}

#[test]
fn a_motor_tells_what_it_bears_and_gives_no_more_than_it_may() {
    // A lift of 1 kg: 12 N raise it, 8 N do not.
    for (most, rises) in [(12.0, true), (8.0, false)] {
        let mut world = world(G);
        let [post, ball] = post_and_ball(&mut world, Vec3::ZERO);
        let lift = Slider::new().with_motor(0.5, most);
        let def = JointDef::new(post, ball, lift).at(Vec3::ZERO).with_axis(Vec3::Y);
        let joint = world.add_joint(def).unwrap();
        steps(&mut world, 60);
        let slide = world.joint(joint).unwrap().slider().unwrap();
        let (speed, force) = (slide.speed(), slide.drive_force());
        if rises {
            assert!((speed - 0.5).abs() < 1.0e-3, "{speed} m/s");
            assert!((force / G - 1.0).abs() < 1.0e-3, "{force} N");
        } else {
            assert!((speed / (most - G) - 1.0).abs() < 1.0e-2, "{speed} m/s");
            assert!((force / most - 1.0).abs() < 1.0e-3, "{force} N");
        }
    }
    // An arm that its brake holds level: 1 kg, 0.8 m out along x, gives a negative torque about z.
    let mut world = world(G);
    let [post, ball] = post_and_ball(&mut world, vec3(0.8, 0.0, 0.0));
    let def = JointDef::new(post, ball, Hinge::new().with_motor(0.0, 100.0));
    let joint = world.add_joint(def.at(Vec3::ZERO).with_axis(Vec3::Z)).unwrap();
    steps(&mut world, 30);
    let turn = world.joint(joint).unwrap().hinge().unwrap();
    for torque in [turn.drive_force(), turn.force()] {
        assert!((torque / (0.8 * G) - 1.0).abs() < 2.0e-3, "{torque} N m");
    }
}

#[test]
fn friction_holds_what_is_less_than_it_and_slows_what_is_more() {
    for (friction, falls) in [(10.0, 0.0), (5.0, G - 5.0)] {
        let mut world = world(G);
        let [post, ball] = post_and_ball(&mut world, Vec3::ZERO);
        let rail = Slider::new().with_friction(friction);
        let def = JointDef::new(post, ball, rail).at(Vec3::ZERO).with_axis(Vec3::Y);
        let joint = world.add_joint(def).unwrap();
        steps(&mut world, 60);
        let speed = world.joint(joint).unwrap().slider().unwrap().speed();
        assert!((speed + falls).abs() < 0.01 * G, "{speed} m/s");
    }
}

#[test]
fn what_is_changed_by_name_follows_at_once_and_keeps_its_frames() {
    let mut world = world(0.0);
    let [post, ball] = post_and_ball(&mut world, Vec3::ZERO);
    let def = JointDef::new(post, ball, Hinge::new().with_limits(0.0, 1.9));
    let joint = world.add_joint(def.at([0.5, 0.0, 0.0]).with_rotation(frame())).unwrap();
    let mut door = world.joint_mut(joint).unwrap();
    door.set_servo(0.96, JointSpring::hertz(4.0, 1.0), 1.0e4);
    steps(&mut world, 240);
    assert!((turn_of(&world, joint) - 0.96).abs() < 1.0e-3);
    // Open by 55°: new limits, drives and axes do not rotate it back.
    let mut door = world.joint_mut(joint).unwrap();
    door.set_drive(None).unwrap();
    door.set_limits(0.0, 1.5).unwrap();
    door.set_friction(0.1).unwrap();
    door.set_axes(Hinge::new().with_limits(-0.1, 1.2)).unwrap();
    steps(&mut world, 10);
    let at = turn_of(&world, joint);
    assert!((at - 0.96).abs() < 2.0e-3, "{at} rad");
    let mut door = world.joint_mut(joint).unwrap();
    door.set_motor(-1.0, 50.0);
    let drive = door.hinge().unwrap().get().drive();
    assert_eq!(drive, Some(JointDrive::motor(-1.0, 50.0)));
    steps(&mut world, 30);
    // Half a second at 1 rad/s.
    assert!((turn_of(&world, joint) - (at - 0.5)).abs() < 5.0e-3);
    let six = |world: &World| match world.joint(joint).unwrap().kind() {
        JointKind::SixDof(six) => six,
        other => panic!("{other:?}"),
    };
    let SixDof { frame_a, frame_b, .. } = six(&world);
    let (turned_a, turned_b) = (frame_a * tilt(0.2), frame_b * tilt(0.2));
    world.joint_mut(joint).unwrap().set_frames(turned_a, turned_b).unwrap();
    assert!((six(&world).frame_b.conjugate() * turned_b.normalized()).angle() < 1.0e-3);
}

#[test]
fn wheels_steer_spring_and_roll_toward_axle_times_up() {
    let mut world = world(G);
    let up = Vec3::Y;
    world
        .add_body(
            BodyDef::fixed()
                .with_shape(ShapeDef::box_half([50.0, 1.0, 50.0]))
                .with_position([0.0, -1.0, 0.0]),
        )
        .unwrap();
    let chassis = BodyDef::dynamic().with_position([0.0, 0.6, 0.0]).with_mass(100.0);
    let chassis = world.add_body(chassis.with_shape(ShapeDef::box_half([1.0, 0.1, 0.4]))).unwrap();
    let spring = JointSpring::for_load(2.0, 0.7, 25.0);
    let steer = JointSpring::hertz(8.0, 1.0);
    let mut wheels = Vec::new();
    for x in [-0.8, 0.8] {
        for z in [-0.6, 0.6] {
            let at = vec3(x, 0.3, z);
            let wheel = BodyDef::dynamic().with_position(at).with_mass(10.0);
            let wheel = wheel.with_shape(ShapeDef::sphere(0.3).with_friction(1.0));
            let wheel = world.add_body(wheel).unwrap();
            let joint = Wheel::new(spring).with_travel(-0.3, 0.3).with_motor(10.0, 20.0);
            let joint = if x > 0.0 { joint.with_steering(0.0, steer, 500.0) } else { joint };
            // It faces x and up is y, so that -z is left.
            let def = JointDef::new(chassis, wheel, joint).at(at).with_axes(up, -Vec3::Z);
            wheels.push(world.add_joint(def).unwrap());
        }
    }
    steps(&mut world, 240);
    let body = world.body(chassis).unwrap();
    let v = body.linear_velocity();
    // 10 rad/s on wheels of 0.3 m.
    assert!((v.x - 3.0).abs() < 0.05 && v.z.abs() < 0.05, "{v:?}");
    for wheel in &wheels {
        let wheel = world.joint(*wheel).unwrap();
        // Each spring carries a quarter of the chassis: it is compressed by g/(2π · 2 Hz)² = 62 mm.
        let sag = wheel.slider().unwrap().position();
        assert!((sag - 0.0621).abs() < 0.01, "{sag} m");
        assert!((wheel.axis(Axis::TurnY).unwrap().speed() - 10.0).abs() < 0.2);
    }
    for wheel in &wheels[2..] {
        assert!(world.joint(*wheel).unwrap().hinge().is_none(), "it has two turns");
        let mut joint = world.joint_mut(*wheel).unwrap();
        joint.axis(Axis::TurnX).unwrap().set_servo(0.3, steer, 500.0);
    }
    steps(&mut world, 60);
    for wheel in &wheels[2..] {
        let angle = world.joint(*wheel).unwrap().axis(Axis::TurnX).unwrap().position();
        assert!((angle - 0.3).abs() < 0.05, "{angle} rad");
    }
    // A positive rotation about up leads from x to -z, left.
    let turns = world.body(chassis).unwrap().angular_velocity().y;
    assert!(turns > 0.2, "{turns} rad/s");
}

#[test]
fn springs_hang_where_their_stiffness_says() {
    let mut world = world(G);
    let [post, ball] = post_and_ball(&mut world, vec3(0.0, -1.0, 0.0));
    let spring = Spring::with_stiffness(1.0, 100.0, 8.0, 1.0);
    let def = JointDef::new(post, ball, spring).between(Vec3::ZERO, vec3(0.0, -1.0, 0.0));
    let hung = world.add_joint(def).unwrap();
    let [post, ball] = post_and_ball(&mut world, vec3(5.0, 0.0, 0.0));
    let law = JointSpring::for_load(1.5, 0.5, 1.0);
    let rail = Slider::new().with_servo(0.0, law, f32::INFINITY);
    let def = JointDef::new(post, ball, rail).at([5.0, 0.0, 0.0]).with_axis(Vec3::Y);
    let stood = world.add_joint(def).unwrap();
    steps(&mut world, 600);
    let joint = world.joint(hung).unwrap();
    // m g / k, less the tolerance of sleep: it rests below 5 cm/s, which at 10 rad/s is within half
    // a millimeter here.
    assert!((joint.length() - (1.0 + G / 100.0)).abs() < 1.0e-3, "{} m", joint.length());
    assert!((joint.tension().unwrap() / G - 1.0).abs() < 5.0e-3, "{:?} N", joint.tension());
    let omega = 2.0 * core::f32::consts::PI * 1.5;
    let sag = world.joint(stood).unwrap().slider().unwrap().position();
    assert!((sag + G / (omega * omega)).abs() < 1.0e-3, "{sag} m");
}

#[test]
fn muscles_turn_a_joint_to_a_pose_and_soft_joints_come_back() {
    let target = Quat::from_axis_angle(vec3(1.0, 2.0, -1.0).normalize_or(Vec3::X), 0.6);
    let spring = JointSpring::hertz(4.0, 1.0);
    let kinds: [JointKind; 3] = [
        ConeTwist::new(1.2, 1.2).into(),
        Ball::new().with_friction(1.0e-6).into(),
        Servo::new(spring, f32::INFINITY, f32::INFINITY).into(),
    ];
    for kind in kinds {
        let mut world = world(0.0);
        let [post, ball] = post_and_ball(&mut world, Vec3::ZERO);
        let def = JointDef::new(post, ball, kind).at(Vec3::ZERO).with_rotation(frame());
        let joint = world.add_joint(def).unwrap();
        let before = world.body(ball).unwrap().rotation();
        let mut muscle = world.joint_mut(joint).unwrap();
        muscle.set_target_rotation(target, spring, f32::INFINITY);
        steps(&mut world, 300);
        let turned = world.body(ball).unwrap().rotation() * before.conjugate();
        // The target is given in the frame of the joint.
        let off = frame().conjugate() * turned * frame() * target.conjugate();
        assert!(off.angle() < 5.0e-3, "{kind:?}: {} rad", off.angle());
    }
    let mut world = world(0.0);
    let [post, ball] = post_and_ball(&mut world, Vec3::ZERO);
    let def = JointDef::new(post, ball, Fixed::soft(JointSpring::hertz(3.0, 1.0))).at(Vec3::ZERO);
    world.add_joint(def).unwrap();
    let before = world.body(ball).unwrap().pose();
    let mut body = world.body_mut(ball).unwrap();
    body.set_linear_velocity([1.0, 0.5, 0.0]);
    body.set_angular_velocity([0.0, 1.0, 2.0]);
    steps(&mut world, 4);
    let far = went(before, world.body(ball).unwrap().pose(), Quat::IDENTITY);
    // Critically damped: v t e^(-ωt). The spring's step has first-order accuracy in ωh.
    let (omega, t) = (2.0 * core::f32::consts::PI * 3.0, 4.0 * DT);
    // ωt is 0.4 π.
    let way = t * 0.284_61;
    for (far, speed) in far.into_iter().zip([1.0, 0.5, 0.0, 0.0, 1.0, 2.0]) {
        assert!((far - speed * way).abs() < (speed + 1.0e-3) * way * omega * SUBSTEP, "{far}");
    }
    steps(&mut world, 300);
    let back = went(before, world.body(ball).unwrap().pose(), Quat::IDENTITY);
    assert!(back.iter().all(|x| x.abs() < 2.0e-3), "{back:?}");
}

#[test]
fn points_of_the_world_are_places_of_bodies() {
    for (name, kind, _) in names() {
        let at = vec3(1.0, 2.0, -0.5);
        let (x, y) = (frame().rotate(Vec3::X), frame().rotate(Vec3::Y));
        let mut first = world(G);
        let [post, ball] = post_and_ball(&mut first, at + vec3(0.2, 0.1, 0.0));
        let mut second = first.clone();
        // Axes of any length, with y not quite perpendicular to x.
        let told = JointDef::new(post, ball, kind).at(at).with_axes(x * 3.0, y * 0.1 + x);
        let joint = first.add_joint(told).unwrap();
        let seen = first.joint(joint).unwrap();
        // A few products of coordinates up to 4 in f32.
        assert!((seen.anchor_a() - at).length() < 2.0e-6, "{name}");
        assert!((seen.anchor_b() - at).length() < 2.0e-6, "{name}");
        if let Some(axis) = seen.axis(Axis::X) {
            assert!((axis.direction() - x).length() < 2.0e-6, "{name}");
            assert!((seen.axis(Axis::Y).unwrap().direction() - y).length() < 2.0e-6, "{name}");
            for axis in Axis::ALL {
                assert!(seen.axis(*axis).unwrap().position().abs() < 2.0e-6, "{name}, {axis}");
            }
        }
        // Frames computed by hand, as in engines without joints by points of the world.
        let local = |body: BodyId| {
            let body = second.body(body).unwrap();
            let anchor = body.rotation().unrotate(at - body.position());
            (anchor, (body.rotation().conjugate() * frame()).normalized())
        };
        let ((anchor_a, frame_a), (anchor_b, frame_b)) = (local(post), local(ball));
        let by_hand = JointDef::new(post, ball, kind).with_frames(frame_a, frame_b);
        let by_hand = second.add_joint(by_hand.with_anchors(anchor_a, anchor_b)).unwrap();
        steps(&mut first, 60);
        steps(&mut second, 60);
        let [p, q] = [&first, &second].map(|world| world.body(ball).unwrap().pose());
        let apart = went(p, q, Quat::IDENTITY);
        // The two differ by the rounding of their frames.
        assert!(apart.iter().all(|x| x.abs() < 1.0e-4), "{name}: {apart:?}");
        // The definition that the joint returns makes the same joint.
        let def = second.joint(by_hand).unwrap().to_def().unwrap();
        assert!(!def.world_anchors && def.world_axes.is_none());
        assert!((def.anchor_b - anchor_b).length() < 1.0e-6);
        let again = second.add_joint(def).unwrap();
        assert_eq!(second.joint(again).unwrap().kind(), def.kind, "{name}");
    }
}

#[test]
fn what_is_placed_before_is_the_same_as_what_is_placed_when_added() {
    let mut first = world(G);
    let [post, ball] = post_and_ball(&mut first, vec3(0.3, 0.2, 0.1));
    let mut second = first.clone();
    let def = JointDef::new(post, ball, Hinge::new()).at(Vec3::X).with_axis([1.0, 1.0, 0.0]);
    first.add_joint(def).unwrap();
    let placed = second.place_joint(def).unwrap();
    assert_eq!(second.place_joint(placed).unwrap(), placed);
    second.add_joint(placed).unwrap();
    assert!(first.snapshot() == second.snapshot());
}

#[test]
fn bodies_of_a_pulley_collide_and_others_do_not_unless_told() {
    let mut world = world(G);
    let [post, ball] = post_and_ball(&mut world, Vec3::ZERO);
    let rope = Pulley::rope([vec3(0.0, 3.0, 0.0), vec3(3.0, 3.0, 0.0)], 9.0);
    assert!(JointDef::new(post, ball, rope).collide_connected);
    let def = JointDef::new(post, ball, Rope::new(3.0));
    assert!(!def.collide_connected);
    assert!(def.with_collide_connected(true).collide_connected);
    let joint = world.add_joint(def.with_user_data(7)).unwrap();
    assert_eq!(world.joint(joint).unwrap().user_data(), 7);
    assert!(world.body(ball).unwrap().joints().eq([joint]));
    assert_eq!(world.joints().count(), 1);
}

#[test]
fn numbers_that_no_joint_can_have_are_named() {
    let nan = f32::NAN;
    let bad = JointSpring::new(-1.0, 0.0);
    let of = |name: &'static str, kind: JointKind| (name, kind);
    let refused = [
        of("angular[0].friction", Ball::new().with_friction(-1.0).into()),
        of("angular[0].friction", Ball::new().with_friction(nan).into()),
        of("angular[0].max", Hinge::new().with_limits(1.0, -1.0).into()),
        of("angular[0].min", Hinge::new().with_limits(nan, 1.0).into()),
        of("angular[0].drive.velocity", Hinge::new().with_motor(nan, 1.0).into()),
        of("angular[0].drive.max_force", Hinge::new().with_motor(1.0, -1.0).into()),
        of("angular[0].spring.stiffness", Hinge::new().with_soft_limits(0.0, 1.0, bad).into()),
        of("linear[0].drive.position", Slider::new().with_servo(nan, bad, 1.0).into()),
        of("linear[0].drive.stiffness", Slider::new().with_servo(0.0, bad, 1.0).into()),
        of("linear[0].friction", Slider::new().with_friction(nan).into()),
        of("linear[0].max", Cylindrical::of(JointAxis::limited(0.0, nan), JointAxis::FREE).into()),
        of("angular[1].max", Universal::of(JointAxis::FREE, JointAxis::limited(2.0, 1.0)).into()),
        of("cone[1].swing", ConeTwist::new(0.5, 0.0).into()),
        of("angular[0].max", ConeTwist::new(0.5, 0.5).with_twist(1.0, 0.0).into()),
        of("angular[0].friction", ConeTwist::new(0.5, 0.5).with_friction(nan).into()),
        of("cone.spring.stiffness", ConeTwist::new(0.5, 0.5).with_soft_cone(bad).into()),
        of("linear[0].drive.stiffness", Fixed::soft(bad).into()),
        of("linear[0].drive.stiffness", Servo::grab(bad, 1.0).into()),
        of("linear[0].drive.max_force", Servo::grab(JointSpring::new(1.0, 0.0), nan).into()),
        of("linear[0].drive.stiffness", Wheel::new(bad).into()),
        of("linear[0].max", Wheel::new(JointSpring::new(1.0, 0.0)).with_travel(1.0, 0.0).into()),
        of("angular[1].drive.velocity", Wheel::rigid().with_motor(f32::INFINITY, 1.0).into()),
        of("angular[0].drive.position", Wheel::rigid().with_steering(nan, bad, 1.0).into()),
        of("max", Rope::new(-1.0).into()),
        of("max", Distance::between(2.0, 1.0).into()),
        of("min", Distance::exact(nan).into()),
        of("spring.hertz", Spring::new(1.0, 0.0, 0.1).into()),
        of("spring.hertz", Spring::with_stiffness(1.0, -5.0, 0.0, 1.0).into()),
        of("spring.damping_ratio", Spring::with_stiffness(1.0, 5.0, nan, 1.0).into()),
    ];
    let mut world = world(G);
    let [post, ball] = post_and_ball(&mut world, Vec3::ZERO);
    for (field, kind) in refused {
        let error = world.add_joint(JointDef::new(post, ball, kind)).unwrap_err();
        assert_eq!(error.field(), field, "{error}");
    }
    let hinge = JointDef::new(post, ball, Hinge::new());
    for (field, def) in [
        ("anchor_a", hinge.at([nan, 0.0, 0.0])),
        ("anchor_b", hinge.between(Vec3::ZERO, [0.0, 1.0e9, 0.0])),
        ("anchor_b", hinge.with_anchors(Vec3::ZERO, [f32::INFINITY, 0.0, 0.0])),
        ("world_axes.x", hinge.at(Vec3::ZERO).with_axis(Vec3::ZERO)),
        ("world_axes.x", hinge.at(Vec3::ZERO).with_axis([nan, 0.0, 0.0])),
        ("world_axes.y", hinge.at(Vec3::ZERO).with_axes(Vec3::X, Vec3::X * 2.0)),
        ("world_axes", hinge.at(Vec3::ZERO).with_rotation(Quat::new(1.0, 1.0, 0.0, 0.0))),
        ("frame_a", hinge.with_frames(Quat::new(0.0, 0.0, 0.0, 0.0), Quat::IDENTITY)),
        ("body_b", JointDef { body_b: post, ..hinge }),
    ] {
        let error = world.add_joint(def).unwrap_err();
        assert_eq!(error.field(), field, "{error}");
    }
    assert_eq!(world.joints().count(), 0);
    // The frame of a far body may be unable to represent a near point.
    let far = BodyDef::fixed().with_position([-9.0e6, 0.0, 0.0]);
    let far = world.add_body(far).unwrap();
    let error = world.add_joint(JointDef::new(far, ball, Ball::new()).at([9.0e6, 0.0, 0.0]));
    assert_eq!(error.unwrap_err().field(), "anchor_a");
}
