//! Gears, racks, screws and mimicking sliders against closed forms.

use std::sync::Arc;

use drystone::joint::{
    Ball, CouplingDef, Cylindrical, Hinge, JointAxis, JointDrive, Pulley, Slider,
};
use drystone::math::Sym3;
use drystone::threads::{SimdLevel, Team};
use drystone::{
    Axis, AxisLocks, BodyDef, BodyId, JointDef, JointId, MassDef, Quat, ShapeDef, Vec3, World,
    WorldConfig, vec3,
};

const DT: f32 = 1.0 / 60.0;

/// Angular frequency of a coupling in soft-step [rad/s]: an eighth of the substeps' frequency.
const OMEGA: f32 = 2.0 * core::f32::consts::PI * 0.125 * 480.0;

/// Moment of inertia of a wheel about its axis [kg m²].
const WHEEL: f32 = 0.02;

fn weightless() -> World {
    World::new(WorldConfig { gravity: Vec3::ZERO, ..WorldConfig::default() }).unwrap()
}

fn wheel(world: &mut World, x: f32) -> BodyId {
    let inertia = Sym3::diagonal(vec3(0.01, 0.01, WHEEL));
    let def = BodyDef {
        mass: MassDef::Exact { mass: 2.0, center: Vec3::ZERO, inertia },
        ..BodyDef::dynamic()
    };
    world.add_body(def.with_position([x, 0.0, 0.0])).unwrap()
}

/// A hinge about the world's z through the body's center.
fn hinge(world: &mut World, base: BodyId, body: BodyId, axis: JointAxis) -> JointId {
    let at = world.body(body).unwrap().position();
    let def = JointDef::new(base, body, Hinge::of(axis).six_dof()).at(at).with_axis(Vec3::Z);
    world.add_joint(def).unwrap()
}

fn turn(world: &World, joint: JointId) -> f32 {
    world.joint(joint).unwrap().coordinates().unwrap()[1].x
}

fn way(world: &World, joint: JointId) -> f32 {
    world.joint(joint).unwrap().coordinates().unwrap()[0].x
}

/// A motor on one wheel, a brake on the other, and gears between.
fn gears(ratio: f32) -> (World, [JointId; 3]) {
    let mut world = weightless();
    let base = world.add_body(BodyDef::fixed()).unwrap();
    let (a, b) = (wheel(&mut world, 0.0), wheel(&mut world, 1.0));
    let motor = JointAxis::driven(JointDrive::motor(12.0, 2.0));
    let brake = JointAxis::FREE.with_friction(0.3);
    let first = hinge(&mut world, base, a, motor);
    let second = hinge(&mut world, base, b, brake);
    let coupling = world.add_coupling(CouplingDef::gear(first, second, ratio)).unwrap();
    (world, [first, second, coupling])
}

#[test]
fn gears_keep_their_ratio_for_ten_seconds_under_load() {
    for ratio in [-2.0_f32, 0.5, 3.0] {
        let (mut world, [first, second, coupling]) = gears(ratio);
        let (mut off, mut most) = (0.0_f32, 0.0_f32);
        for _ in 0..600 {
            world.step(DT);
            let joint = world.joint(coupling).unwrap();
            off = off.max(joint.angular_error());
            most = most.max(joint.coupling_force().unwrap().abs());
        }
        // The motor's torque less the brake's through the gears accelerates both wheels; then the
        // speed is held.
        let rate = (2.0 - 0.3 * ratio.abs()) / (WHEEL * (1.0 + ratio * ratio));
        let exact = 12.0 * 10.0 - 12.0 * 12.0 / (2.0 * rate);
        assert!((turn(&world, first) / exact - 1.0).abs() < 1.0e-3, "{}", turn(&world, first));
        // The coupling's own error agrees with the angles, up to the rounding of hundreds of
        // radians.
        let gap = turn(&world, second) - ratio * turn(&world, first);
        assert!(gap.abs() < off + 4.0 * f32::EPSILON * 120.0 * ratio.abs().max(1.0), "{gap}");
        // A joint yields by load × inverse mass ÷ (2πf)², and by twice that if the load is sudden.
        // Angles within a turn are accurate to rounding.
        let give = (1.0 + ratio * ratio) / WHEEL / (OMEGA * OMEGA);
        let rounding = 4.0 * f32::EPSILON * core::f32::consts::PI * ratio.abs().max(1.0);
        println!("{ratio}: {off} rad off, {most} N m, gives {} rad", most * give);
        assert!(off < 2.0 * most * give + rounding, "{ratio}: {off}");
        // The brake's torque passes through the gears.
        let force = world.joint(coupling).unwrap().coupling_force().unwrap();
        assert!((force.abs() - 0.3).abs() < 0.003, "{ratio}: {force} N m");
    }
}

#[test]
fn a_rack_moves_its_load_as_the_torque_says() {
    let mut world = weightless();
    let base = world.add_body(BodyDef::fixed()).unwrap();
    let pinion = wheel(&mut world, 0.0);
    // A motor that never reaches its speed is a constant torque.
    let torque = JointAxis::driven(JointDrive::motor(1.0e4, 0.5));
    let hinge = hinge(&mut world, base, pinion, torque);
    let rack = BodyDef::dynamic().with_position([0.0, 0.1, 0.0]);
    let rack =
        world.add_body(rack.with_shape(ShapeDef::box_half([0.5, 0.02, 0.02])).with_mass(3.0));
    let rack = rack.unwrap();
    let slider = Slider::new().six_dof();
    let slider = JointDef::new(base, rack, slider).at([0.0, 0.1, 0.0]).with_axis(Vec3::X);
    let slider = world.add_joint(slider).unwrap();
    let radius = 0.1;
    world.add_coupling(CouplingDef::rack(hinge, slider, radius)).unwrap();
    for _ in 0..120 {
        world.step(DT);
    }
    // a = τ r / (I + m r²), from rest. Semi-implicit steps of 1/480 s over 2 s are exact in speed,
    // and the displacement is longer by h/t = 1e-3.
    let a = 0.5 * radius / (WHEEL + 3.0 * radius * radius);
    let speed = world.body(rack).unwrap().linear_velocity().x;
    assert!((speed / (2.0 * a) - 1.0).abs() < 2.0e-3, "{speed} m/s, {} m/s", 2.0 * a);
    let x = way(&world, slider);
    assert!((x / (2.0 * a) - 1.0).abs() < 3.0e-3, "{x} m, {} m", 2.0 * a);
    assert!((x - radius * turn(&world, hinge)).abs() < 1.0e-4);
}

#[test]
fn fingers_on_a_moving_hand_follow_each_other_and_keep_momentum() {
    let mut world = weightless();
    let block = |world: &mut World, at: Vec3, mass: f32| {
        let def = BodyDef::dynamic().with_position(at).with_mass(mass);
        world.add_body(def.with_shape(ShapeDef::box_half([0.05; 3]))).unwrap()
    };
    let hand = block(&mut world, Vec3::ZERO, 2.0);
    let fingers = [1.0_f32, -1.0].map(|y| block(&mut world, vec3(0.0, 0.2 * y, 0.2), 0.3));
    let sliders = [1.0_f32, -1.0].map(|y| {
        let finger = fingers[usize::from(y < 0.0)];
        let axes = Slider::of(JointAxis::limited(-1.0, 1.0)).six_dof();
        let at = world.body(finger).unwrap().position();
        let def = JointDef::new(hand, finger, axes).at(at).with_axis(vec3(0.0, y, 0.0));
        world.add_joint(def).unwrap()
    });
    let [joint_a, joint_b] = sliders;
    let def = CouplingDef {
        joint_a,
        axis_a: Axis::X,
        joint_b,
        axis_b: Axis::X,
        ratio: 1.0,
        offset: 0.02,
    };
    world.add_coupling(def).unwrap();
    for _ in 0..60 {
        world.step(DT);
    }
    // An initial error of 2 cm disappears quickly.
    assert!((way(&world, joint_b) - way(&world, joint_a) - 0.02).abs() < 1.0e-4);
    world.body_mut(fingers[0]).unwrap().apply_impulse([0.0, 0.15, 0.0]);
    let start = world.momentum();
    let mut off = 0.0_f32;
    for _ in 0..60 {
        world.step(DT);
        off = off.max((way(&world, joint_b) - way(&world, joint_a) - 0.02).abs());
    }
    // A momentum of a quarter kg m/s is kept to the rounding of 480 substeps.
    let drift = (world.momentum() - start).length();
    println!("fingers {off} m off, momentum {drift} kg m/s off");
    assert!(drift < 480.0 * f32::EPSILON * 0.25, "{drift}");
    // 0.15 N s on 0.3 kg: the first slider moves alone until both sliders have reacted, a substep
    // each.
    assert!(off < 2.0 * 0.5 * DT / 8.0, "{off}");
    assert!(way(&world, joint_a) > 0.05, "they have moved: {}", way(&world, joint_a));
}

#[test]
fn a_nut_runs_down_its_screw_as_its_pitch_says() {
    let mut world = World::default();
    let base = world.add_body(BodyDef::fixed()).unwrap();
    let inertia = Sym3::diagonal(Vec3::splat(0.05));
    let nut = BodyDef {
        mass: MassDef::Exact { mass: 2.0, center: Vec3::ZERO, inertia },
        ..BodyDef::dynamic()
    };
    let nut = world.add_body(nut).unwrap();
    let axes = Cylindrical::new().six_dof();
    let def = JointDef::new(base, nut, axes).at(Vec3::ZERO).with_axis(Vec3::Y);
    let joint_a = world.add_joint(def).unwrap();
    // y = p θ: m p² θ'' + I θ'' = -m g p.
    let pitch = 0.1;
    let def = CouplingDef {
        joint_a,
        axis_a: Axis::TurnX,
        joint_b: joint_a,
        axis_b: Axis::X,
        ratio: pitch,
        offset: 0.0,
    };
    world.add_coupling(def).unwrap();
    for _ in 0..60 {
        world.step(DT);
    }
    let a = 2.0 * 9.81 * pitch * pitch / (2.0 * pitch * pitch + 0.05);
    let speed = world.body(nut).unwrap().linear_velocity().y;
    assert!((speed / -a - 1.0).abs() < 2.0e-3, "{speed} m/s, {a} m/s²");
}

#[test]
fn what_is_wrong_is_refused_and_named() {
    let mut world = weightless();
    let base = world.add_body(BodyDef::fixed()).unwrap();
    let (a, b) = (wheel(&mut world, 0.0), wheel(&mut world, 1.0));
    let first = hinge(&mut world, base, a, JointAxis::FREE);
    let second = hinge(&mut world, base, b, JointAxis::FREE);
    let ball = world.add_joint(JointDef::new(a, b, Ball::new())).unwrap();
    let good = CouplingDef::gear(first, second, 2.0);
    for (def, field) in [
        (CouplingDef { ratio: 0.0, ..good }, "ratio"),
        (CouplingDef { ratio: f32::NAN, ..good }, "ratio"),
        (CouplingDef { ratio: 1.0e9, ..good }, "ratio"),
        (CouplingDef { offset: f32::INFINITY, ..good }, "offset"),
        (CouplingDef { axis_a: Axis::X, ..good }, "axis_a"),
        (CouplingDef { axis_b: Axis::X, ..good }, "axis_b"),
        (CouplingDef { joint_b: first, ..good }, "axis_b"),
        (CouplingDef { joint_a: ball, ..good }, "joint_a"),
    ] {
        let e = world.add_coupling(def).unwrap_err();
        assert_eq!(e.field(), field, "{e}");
    }
    let coupling = world.add_coupling(good).unwrap();
    assert_eq!(world.joints().count(), 4);
    assert!(world.joint(first).unwrap().coupling_force().is_none());
    let kind = world.joint(coupling).unwrap().kind();
    let again = JointDef { kind, ..JointDef::new(a, b, Ball::new()) };
    assert_eq!(world.add_joint(again).unwrap_err().field(), "kind");
    // The coupling disappears with either of its joints.
    assert!(world.remove_joint(second));
    assert!(world.joint(coupling).is_none());
    assert_eq!(world.joints().count(), 2);
    assert!(world.add_coupling(good).is_err());
    world.step(DT);
}

#[test]
fn coupled_bodies_sleep_and_wake_together() {
    let (mut world, [first, second, _]) = gears(2.0);
    world.joint_mut(first).unwrap().set_drive(None).unwrap();
    for _ in 0..300 {
        world.step(DT);
    }
    let [a, b] = [first, second].map(|j| world.joint(j).unwrap().body_b());
    assert!(world.body(a).unwrap().is_asleep() && world.body(b).unwrap().is_asleep());
    world.joint_mut(first).unwrap().set_drive(Some(JointDrive::motor(5.0, 2.0))).unwrap();
    for _ in 0..60 {
        world.step(DT);
    }
    let spin = world.body(b).unwrap().angular_velocity().z;
    assert!((spin - 10.0).abs() < 0.1, "{spin}");
}

#[test]
fn couplings_have_the_same_bits_for_any_threads_and_width() {
    let run = |threads: usize, level: SimdLevel| {
        let mut world = World::default();
        world.set_executor(Arc::new(Team::new(threads)));
        world.set_simd_level(level);
        let base = world.add_body(BodyDef::fixed()).unwrap();
        let mut last: Option<JointId> = None;
        for i in 0..40_u8 {
            let x = f32::from(i);
            let locks = AxisLocks::NONE;
            let def = BodyDef { locks, ..BodyDef::dynamic() }.with_position([x, 0.0, 0.0]);
            let def = def.with_rotation(Quat::from_axis_angle(Vec3::Z, 0.1 * x));
            let bar = ShapeDef::box_half([0.2, 0.1, 0.1]).with_position([0.1, 0.0, 0.0]);
            let bar = world.add_body(def.with_shape(bar)).unwrap();
            let joint = hinge(&mut world, base, bar, JointAxis::FREE);
            if let Some(last) = last {
                world.add_coupling(CouplingDef::gear(last, joint, -1.1)).unwrap();
            }
            last = if i % 8 == 7 { None } else { Some(joint) };
        }
        for _ in 0..60 {
            world.step(DT);
        }
        world.state_hash()
    };
    let expected = run(1, SimdLevel::best());
    for level in SimdLevel::available() {
        for threads in [1, 3] {
            assert_eq!(run(threads, level), expected, "{threads} threads, {}", level.name());
        }
    }
}

/// Two bodies of these masses on a rope over two points 2 m above them.
fn atwood(masses: [f32; 2], pulley: impl Fn(Pulley) -> Pulley) -> (World, [BodyId; 2], JointId) {
    let mut world = World::default();
    let bodies = [0, 1].map(|i| {
        let at = vec3(f32::from(u8::try_from(i).unwrap()), 0.0, 0.0);
        let def = BodyDef::dynamic().with_position(at).with_mass(masses[i]);
        world.add_body(def.with_shape(ShapeDef::box_half([0.1; 3]))).unwrap()
    });
    let rope = Pulley::rope([vec3(0.0, 2.1, 0.0), vec3(1.0, 2.1, 0.0)], 4.0);
    let anchor = vec3(0.0, 0.1, 0.0);
    let def = JointDef::new(bodies[0], bodies[1], pulley(rope)).with_anchors(anchor, anchor);
    let joint = world.add_joint(def).unwrap();
    (world, bodies, joint)
}

#[test]
fn atwoods_machine_falls_as_its_masses_say() {
    // a_a = g (m_a r² - r m_b)/(m_a r² + m_b), which for r = 1 is g (m_a - m_b)/(m_a + m_b); T =
    // m_a (g - a_a).
    for (a, b, ratio) in [
        (3.0_f32, 1.0_f32, 1.0_f32),
        (1.0, 3.0, 1.0),
        (2.0, 2.0, 1.0),
        (1.0, 3.0, 2.0),
        (1.0, 50.0, 1.0),
    ] {
        let (mut world, bodies, joint) =
            atwood([a, b], |rope| Pulley { ratio, length: 2.0 + 2.0 * ratio, ..rope });
        let square = a * ratio * ratio;
        let exact = 9.81 * (square - ratio * b) / (square + b);
        let tension = a * (9.81 - exact);
        let mut worst = 0.0_f32;
        for _ in 0..30 {
            world.step(DT);
            worst = worst.max(world.joint(joint).unwrap().error());
        }
        let speed = |i: usize| -world.body(bodies[i]).unwrap().linear_velocity().y;
        let told = world.joint(joint).unwrap().tension().unwrap();
        // A rope yields as joints do, by T (1/m_a + r²/m_b)/(2πf)², and by twice that at first. Its
        // speed of yielding is that over a few substeps.
        let give = tension * (1.0 / a + ratio * ratio / b) / (OMEGA * OMEGA);
        println!(
            "{a} {b} {ratio}: {} m/s of {}, tension {told} N of {tension}, {worst} m of {give} m",
            speed(0),
            0.5 * exact
        );
        assert!((speed(0) - 0.5 * exact).abs() < 5.0e-3 * 9.81 * 0.5, "{} m/s", speed(0));
        assert!((speed(0) + ratio * speed(1)).abs() < 480.0 * give, "{} {}", speed(0), speed(1));
        assert!((told / tension - 1.0).abs() < 0.02, "{told} N, {tension} N");
        assert!(worst < 2.0 * give + 1.0e-6, "{worst} m");
    }
}

#[test]
fn a_slack_rope_pulls_nothing_until_it_is_taut() {
    let (mut world, bodies, joint) = atwood([1.0, 1.0], |rope| Pulley { length: 5.0, ..rope });
    // Both fall freely by half a meter each, 0.319 s, and then hang still.
    for _ in 0..18 {
        world.step(DT);
        assert!(world.joint(joint).unwrap().tension().unwrap().abs() < 1.0e-6);
    }
    let speed = world.body(bodies[0]).unwrap().linear_velocity().y;
    assert!((speed + 9.81 * 0.3).abs() < 1.0e-3, "{speed}");
    for _ in 0..120 {
        world.step(DT);
    }
    for body in bodies {
        let b = world.body(body).unwrap();
        assert!(b.linear_velocity().length() < 1.0e-2 && (b.position().y + 0.5).abs() < 1.0e-2);
    }
    let told = world.joint(joint).unwrap().tension().unwrap();
    assert!((told - 9.81).abs() < 0.05, "{told} N");
}

#[test]
fn wrong_pulleys_are_refused_and_named() {
    let (mut world, [a, b], _) = atwood([1.0, 1.0], |rope| rope);
    let good = Pulley::rope([Vec3::ZERO; 2], 1.0);
    for (pulley, field) in [
        (Pulley { ratio: 0.0, ..good }, "pulley.ratio"),
        (Pulley { ratio: f32::NAN, ..good }, "pulley.ratio"),
        (Pulley { ratio: -1.0, ..good }, "pulley.ratio"),
        (Pulley { length: 0.0, ..good }, "pulley.length"),
        (Pulley { length: f32::INFINITY, ..good }, "pulley.length"),
        (Pulley { points: [Vec3::ZERO, vec3(0.0, f32::NAN, 0.0)], ..good }, "pulley.points[1]"),
    ] {
        let e = world.add_joint(JointDef::new(a, b, pulley)).unwrap_err();
        assert_eq!(e.field(), field, "{e}");
    }
    let own = JointDef::new(a, a, good);
    assert_eq!(world.add_joint(own).unwrap_err().field(), "body_b");
    let posts = [0, 1].map(|_| world.add_body(BodyDef::fixed()).unwrap());
    let fixed = JointDef::new(posts[0], posts[1], good);
    assert_eq!(world.add_joint(fixed).unwrap_err().field(), "body_b");
    // An anchor at its pulley point has no direction; this is not a fault.
    let at = world.body(a).unwrap().position();
    let short = Pulley::rope([at, Vec3::ZERO], 0.1);
    world.add_joint(JointDef::new(a, b, short)).unwrap();
    for _ in 0..60 {
        world.step(DT);
        assert!(world.events().faults.is_empty());
    }
}
