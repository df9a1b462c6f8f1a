//! A world's audit, checked against physics.

use drystone::audit::{Audit, AwakeCause, ConstraintId, Ledger};
use drystone::joint::{Ball, Spring};
use drystone::{
    BodyDef, BodyId, JointDef, JointKind, Pose, Quat, ShapeDef, Vec3, World, WorldConfig, vec3,
};

const DT: f32 = 1.0 / 60.0;
const G: f32 = 9.81;

fn floating() -> World {
    World::new(WorldConfig { gravity: Vec3::ZERO, ..WorldConfig::default() }).unwrap()
}

fn with_ground(friction: f32) -> World {
    let mut world = World::default();
    let ground = ShapeDef::half_space(Vec3::Y, 0.0).with_friction(friction);
    world.add_body(BodyDef::fixed().with_shape(ground)).unwrap();
    world
}

fn cube_at(position: Vec3) -> BodyDef {
    BodyDef::dynamic().with_position(position).with_shape(ShapeDef::box_half([0.5; 3]))
}

fn ball_at(position: Vec3) -> BodyDef {
    BodyDef::dynamic().with_position(position).with_shape(ShapeDef::sphere(0.5))
}

fn run(world: &mut World, steps: u32) {
    for _ in 0..steps {
        world.step(DT);
    }
}

fn ledger(world: &World) -> Ledger {
    world.audit().ledger.unwrap()
}

/// Relative error.
fn off(value: f64, from: f64) -> f64 {
    (value / from - 1.0).abs()
}

#[test]
fn a_flight_and_an_elastic_bounce_keep_the_sum() {
    let mut world = World::default();
    let ground = ShapeDef::half_space(Vec3::Y, 0.0).with_restitution(1.0);
    world.add_body(BodyDef::fixed().with_shape(ground)).unwrap();
    let mut ball = ball_at(vec3(0.0, 3.0, 0.0)).with_linear_velocity([1.0, 0.0, 0.0]);
    ball.shapes[0].material.friction = 0.0;
    world.add_body(ball).unwrap();
    world.begin_ledger();
    run(&mut world, 40);
    let flight = ledger(&world);
    // The parabola is exact up to 40 roundings of a speed up to 7 m/s and a height of 3 m.
    assert!(flight.dissipated.abs() < 40.0 * 1.2e-7 * flight.start.total(), "{flight:?}");
    assert!(flight.now.linear > 0.5 * flight.start.potential, "it fell");
    run(&mut world, 40);
    let bounced = ledger(&world);
    // The time of impact within a substep of 1/480 s is unknown. Gravity changes the 7 m/s by 2
    // cm/s in that time, 0.3 %, and the energy by twice as much.
    assert!(bounced.dissipated.abs() < 0.006 * flight.now.kinetic(), "{bounced:?}");
}

#[test]
fn what_a_force_does_over_its_way_is_motion_and_heat() {
    // A cube of 1000 kg on ground with friction 0.5, pulled with 6 kN: 4905 N of it are friction.
    let mut world = with_ground(0.5);
    let mut def = cube_at(vec3(0.0, 0.5, 0.0));
    def.shapes[0].material.friction = 0.5;
    let cube = world.add_body(def).unwrap();
    run(&mut world, 30);
    world.begin_ledger();
    let from = world.body(cube).unwrap().position().x;
    // The force acts at ground height, so that the cube does not tip.
    let force = 6000.0;
    for _ in 0..120 {
        let at = world.body(cube).unwrap().position();
        let mut body = world.body_mut(cube).unwrap();
        body.add_step_force_at([force, 0.0, 0.0], [at.x, 0.0, at.z]);
        world.step(DT);
    }
    let way = f64::from(world.body(cube).unwrap().position().x - from);
    let l = ledger(&world);
    assert!(off(l.forces, f64::from(force) * way) < 1.0e-4, "{l:?}");
    // A substep moves with the speed after it: over 960 substeps the displacement is too long by
    // half a substep.
    assert!(off(l.dissipated, 4905.0 * way) < 1.0 / 960.0, "{l:?}");
    assert!(off(l.now.kinetic(), (f64::from(force) - 4905.0) * way) < 2.0 / 960.0, "{l:?}");
}

#[test]
fn a_torque_over_its_turn_is_spin() {
    let mut world = floating();
    let ball = world.add_body(ball_at(Vec3::ZERO)).unwrap();
    world.body_mut(ball).unwrap().set_lasting_torque([0.0, 20.0, 0.0]);
    world.begin_ledger();
    run(&mut world, 120);
    let l = ledger(&world);
    // The rotation of a step uses the speed after it: half a step's gain too much, 1/240 in total.
    assert!(l.now.angular > 1.0 && off(l.forces, l.now.angular) < 1.1 / 120.0, "{l:?}");
}

#[test]
fn what_the_user_does_between_steps_is_booked() {
    let mut world = World::default();
    let cube = world.add_body(cube_at(vec3(0.0, 5.0, 0.0))).unwrap();
    world.begin_ledger();
    // 1000 kg at 2 m/s, 3 m up.
    let mut body = world.body_mut(cube).unwrap();
    body.apply_impulse([2000.0, 0.0, 0.0]);
    body.set_pose(Pose::at([0.0, 8.0, 0.0]));
    let l = ledger(&world);
    assert!(off(l.impulses, 2000.0) < 1.0e-6 && off(l.changes, 3000.0 * f64::from(G)) < 1.0e-6);
    assert!(l.dissipated.abs() < 1.0e-6 * l.now.total(), "{l:?}");
    // The same after steps, and after the removal of a body.
    run(&mut world, 10);
    let l = ledger(&world);
    assert!(off(l.impulses, 2000.0) < 1.0e-6 && off(l.changes, 3000.0 * f64::from(G)) < 1.0e-6);
    world.remove_body(cube);
    let closed = world.end_ledger().unwrap();
    assert!(closed.now.total().abs() <= 0.0, "nothing is left");
    assert!(closed.dissipated.abs() < 1.0e-5 * closed.start.total(), "{closed:?}");
    assert!(world.audit().ledger.is_none() && world.end_ledger().is_none());
}

#[test]
fn a_belt_gives_half_of_its_work_to_the_box_and_half_to_heat() {
    let mut world = World::default();
    let mut belt = BodyDef::kinematic().with_position([0.0, -0.5, 0.0]);
    belt = belt.with_linear_velocity([3.0, 0.0, 0.0]);
    belt = belt.with_shape(ShapeDef::box_half([20.0, 0.5, 2.0]).with_friction(0.5));
    world.add_body(belt).unwrap();
    // Flat, so that it does not rock when the belt accelerates it.
    let mut def = BodyDef::dynamic().with_position([0.0, 0.1, 0.0]);
    def = def.with_shape(ShapeDef::box_half([0.5, 0.1, 0.5]).with_friction(0.5));
    let parcel = world.add_body(def).unwrap();
    let mass = f64::from(world.body(parcel).unwrap().mass());
    world.begin_ledger();
    run(&mut world, 120);
    assert!((world.body(parcel).unwrap().linear_velocity().x - 3.0).abs() < 1.0e-3);
    let (l, work) = (ledger(&world), mass * 9.0);
    // Friction μ m g over 0.61 s. The step in which sliding ends is accounted as if all of it were
    // like its end: one of 37 steps at most.
    assert!(off(l.kinematic, work) < 1.0 / 37.0, "{l:?}");
    assert!(off(l.dissipated, 0.5 * work) < 2.0 / 37.0, "{l:?}");
}

#[test]
fn a_spring_holds_half_k_x_squared() {
    let mut world = floating();
    let spring = Spring { rest_length: 1.0, hertz: 0.5, damping_ratio: 0.0 };
    let [a, b] = [0.0, 1.5].map(|x| world.add_body(ball_at(vec3(x, 0.0, 0.0))).unwrap());
    let def = JointDef {
        kind: JointKind::Distance { min: 0.0, max: 100.0, spring: Some(spring) },
        ..JointDef::new(a, b, Ball::new())
    };
    world.add_joint(def).unwrap();
    // Two equal masses: k = (m/2) ω², x = 0.5 m.
    let mass = f64::from(world.body(a).unwrap().mass());
    let omega = core::f64::consts::PI;
    let expected = 0.5 * (0.5 * mass * omega * omega) * 0.25;
    let start = world.audit().energy;
    assert!(off(start.elastic, expected) < 1.0e-6, "{start:?} {expected}");
    // A quarter of its period of 2 s later all energy is kinetic. The implicit spring loses ω h of
    // it per radian, (π/2) ω h = 1 % at h = 1/480 s.
    world.begin_ledger();
    run(&mut world, 30);
    let l = ledger(&world);
    assert!(l.now.elastic < 0.01 * expected, "{l:?}");
    assert!(l.dissipated > 0.0 && l.dissipated < 0.012 * expected, "{l:?}");
}

#[test]
fn a_free_collision_keeps_both_momenta_and_loses_energy() {
    let mut world = floating();
    let far = vec3(30.0, -20.0, 10.0);
    let tilt = Quat::from_axis_angle(vec3(1.0, 2.0, 0.5).normalize_or(Vec3::X), 0.7);
    let flying = cube_at(far).with_rotation(tilt).with_linear_velocity([3.0, 0.3, 0.0]);
    world.add_body(flying.with_angular_velocity([1.0, -2.0, 0.5])).unwrap();
    world.add_body(cube_at(far + vec3(2.5, 0.4, 0.2))).unwrap();
    let Audit { momentum: before, energy: at_first, .. } = world.audit();
    run(&mut world, 120);
    let Audit { momentum: after, energy: at_last, .. } = world.audit();
    assert!(at_last.total() < 0.95 * at_first.total(), "they met");
    // Each substep of the collision rounds 3 m/s in f32, at random.
    let linear = (after.linear - before.linear).length() / before.linear.length();
    assert!(linear < 1.0e-5, "{linear}");
    // The impulse, at most the one that stops both bodies, acts at the lever arms of the step's
    // start. Within the step they separate by up to 3 m/s / 60 Hz = 5 cm.
    let own = (after.about_center - before.about_center).length();
    assert!(own < 1500.0 * 0.05, "{own}");
    // About the origin there is also the orbital part: L₀ = C × P + L.
    for m in [before, after] {
        let sum = m.center_of_mass.cross(m.linear) + m.about_center;
        assert!((sum - m.about_origin).length() < 1.0e-5 * m.about_origin.length(), "{m:?}");
    }
}

/// A cube after two seconds on a slope of this tangent.
fn on_slope(tan: f32, friction: f32) -> World {
    let mut world = World::default();
    let cos = 1.0 / (1.0 + tan * tan).sqrt();
    let normal = vec3(-tan * cos, cos, 0.0);
    let slope = ShapeDef::half_space(normal, 0.0).with_friction(friction);
    world.add_body(BodyDef::fixed().with_shape(slope)).unwrap();
    let mut slab = BodyDef::dynamic().with_position(normal * 0.1);
    slab = slab.with_rotation(Quat::from_arc(Vec3::Y, normal));
    slab = slab.with_shape(ShapeDef::box_half([0.5, 0.1, 0.5]).with_friction(friction));
    slab.can_sleep = false;
    world.add_body(slab).unwrap();
    run(&mut world, 120);
    world
}

#[test]
fn the_cone_is_used_as_far_as_the_slope_asks() {
    // Sliding: full use of friction, within a few roundings of the disc's root and quotient.
    let sliding = on_slope(0.5, 0.3).audit().cone.unwrap();
    assert!((sliding.ratio - 1.0).abs() < 8.0 * f32::EPSILON, "{sliding:?}");
    // At rest: the ratio of the slope to the friction coefficient.
    let resting = on_slope(0.2, 0.8).audit().cone.unwrap();
    assert!((resting.ratio - 0.25).abs() < 1.0e-3, "{resting:?}");
}

#[test]
fn an_overlap_is_told_as_it_is_after_the_step() {
    // The cube is pushed out of a depth of 10 mm: in each step the depth is that of the final
    // poses.
    let mut world = with_ground(0.6);
    let cube = world.add_body(cube_at(vec3(0.0, 0.49, 0.0))).unwrap();
    let mut depth = 0.01;
    let mut steps = 0;
    while depth > 1.0e-4 {
        world.step(DT);
        steps += 1;
        depth = 0.5 - world.body(cube).unwrap().position().y;
        let p = world.audit().penetration;
        if depth <= 0.0 {
            break;
        }
        assert_eq!(p.points, 4);
        // Rounding of the anchors in f32.
        assert!((p.max - depth).abs() < 1.0e-6, "{p:?} {depth}");
        assert!(p.mean <= p.max && p.p99 <= p.max && p.max - p.mean < 1.0e-5, "{p:?}");
        assert_eq!(p.at.unwrap().body_b, cube);
        let worst = world.worst_constraint().unwrap();
        assert_eq!(worst.id, ConstraintId::Contact(p.at.unwrap()));
        assert_eq!(worst.error.to_bits(), p.max.to_bits());
        assert_eq!(world.audit().worst, Some(worst));
    }
    assert!(steps > 1);
    // A ball that spins by half a radian per step: its surface stays in place.
    let mut world = with_ground(0.0);
    let ball = ball_at(vec3(0.0, 0.49, 0.0)).with_angular_velocity([0.0, 0.0, 30.0]);
    let ball = world.add_body(ball).unwrap();
    for _ in 0..10 {
        world.step(DT);
        let depth = 0.5 - world.body(ball).unwrap().position().y;
        let p = world.audit().penetration;
        assert!((p.max - depth.max(0.0)).abs() < 1.0e-6, "{p:?} {depth}");
    }
}

#[test]
fn the_worst_joint_is_named() {
    let mut world = floating();
    let ids = [0.0, 2.0, 4.0].map(|x| world.add_body(ball_at(vec3(x, 0.0, 0.0))).unwrap());
    let joint = |a: BodyId, b: BodyId, gap: f32| {
        JointDef::new(a, b, Ball::new()).with_anchors([1.0 - gap, 0.0, 0.0], [-1.0, 0.0, 0.0])
    };
    world.add_joint(joint(ids[0], ids[1], 0.01)).unwrap();
    let bad = world.add_joint(joint(ids[1], ids[2], 0.03)).unwrap();
    let audit = world.audit();
    assert_eq!(audit.joints.linear_joint, Some(bad));
    assert!((audit.joints.linear - 0.03).abs() < 1.0e-6);
    assert_eq!((audit.joints.angular, audit.joints.angular_joint), (0.0, None));
    assert_eq!(audit.worst.unwrap().id, ConstraintId::Joint(bad));
}

#[test]
fn what_a_contact_leaves_unsolved_is_measured() {
    let mut world = with_ground(0.6);
    let cube = world.add_body(cube_at(vec3(0.0, 0.5, 0.0))).unwrap();
    run(&mut world, 20);
    let rest = world.audit().residual;
    // The relax sweep solves one cube's points to the rounding of 1 m/s; they rest 0.05 mm apart,
    // each under a quarter of the weight.
    assert!(rest.relative < 1.0e-4 && rest.gap <= 0.25 * 5.1e-5, "{rest:?}");
    assert!(rest.pull <= 0.0);
    // As if the solver had allowed an approach at 1 m/s: 1/(9.81/60) of a step's gravity impulse.
    world.body_mut(cube).unwrap().set_linear_velocity([0.0, -1.0, 0.0]);
    let bad = world.audit().residual;
    assert!((bad.speed - 1.0).abs() < 1.0e-5 && (bad.relative * G * DT - 1.0).abs() < 1.0e-4);
    assert_eq!(bad.at.unwrap().body_b, cube);
}

#[test]
fn a_body_that_leaves_the_numbers_is_named() {
    let mut world = World::default();
    let wild = world.add_body(cube_at(vec3(0.0, 5.0, 0.0))).unwrap();
    world.add_body(cube_at(vec3(5.0, 5.0, 0.0))).unwrap();
    let mass = world.body(wild).unwrap().mass();
    world.body_mut(wild).unwrap().add_step_force([9.0e9 * mass, 9.0e9 * mass, 0.0]);
    world.step(DT);
    assert_eq!(world.audit().non_finite, [wild]);
    assert_eq!(world.why_awake(wild).unwrap().cause, AwakeCause::Faulted);
}

#[test]
fn an_audit_of_nothing_is_nothing() {
    let audit = World::default().audit();
    assert_eq!(audit, Audit::default());
    assert_eq!(World::default().worst_constraint(), None);
}

#[test]
fn an_audit_changes_nothing() {
    let build = || {
        let mut world = with_ground(0.5);
        for i in 0..5_u8 {
            world
                .add_body(cube_at(vec3(0.1 * f32::from(i), 0.6 + 1.1 * f32::from(i), 0.0)))
                .unwrap();
        }
        world
    };
    let (mut plain, mut watched) = (build(), build());
    watched.begin_ledger();
    for _ in 0..60 {
        plain.step(DT);
        watched.step(DT);
        let _ = watched.audit();
    }
    assert_eq!(plain.state_hash(), watched.state_hash());
}

/// Two boxes, a plank across both, and a ball on the plank; returns boxes, plank, ball.
fn plank_and_ball(world: &mut World, speed: f32) -> [BodyId; 4] {
    let boxes = [-2.0, 2.0].map(|x| world.add_body(cube_at(vec3(x, 0.5, 0.0))).unwrap());
    let plank = BodyDef::dynamic().with_position([0.0, 1.1, 0.0]);
    let plank = world.add_body(plank.with_shape(ShapeDef::box_half([4.0, 0.1, 0.5]))).unwrap();
    let ball = ball_at(vec3(-1.0, 1.7, 0.0)).with_linear_velocity([speed, 0.0, 0.0]);
    let ball = world.add_body(ball.with_angular_velocity([0.0, 0.0, -2.0 * speed])).unwrap();
    [boxes[0], boxes[1], plank, ball]
}

#[test]
fn why_awake_names_the_body_that_rolls_and_the_way_to_it() {
    let mut world = with_ground(0.6);
    let [left, right, plank, ball] = plank_and_ball(&mut world, 0.5);
    run(&mut world, 90);
    for asked in [left, right] {
        let why = world.why_awake(asked).unwrap();
        let AwakeCause::TooFast { speed, limit, driven_by } = why.cause else { panic!("{why:?}") };
        assert_eq!((why.body, why.path), (ball, vec![asked, plank, ball]));
        // It rolls: its top is twice as fast as its center.
        assert!((speed - 1.0).abs() < 0.05 && (limit - 0.05).abs() < 1.0e-6, "{speed}");
        assert_eq!(driven_by, None);
    }
    assert_eq!(world.why_awake(ball).unwrap().path, [ball]);
}

#[test]
fn why_awake_follows_an_island_into_sleep() {
    let mut world = with_ground(0.6);
    let [left, ..] = plank_and_ball(&mut world, 0.0);
    run(&mut world, 10);
    let mut last = f32::INFINITY;
    let mut steps = 0_u16;
    loop {
        let why = world.why_awake(left).unwrap();
        match why.cause {
            AwakeCause::Waiting { seconds_left } => {
                // The island sleeps when its last body may; all bodies are at rest.
                assert!(seconds_left < last, "{seconds_left} {last}");
                last = seconds_left;
            }
            AwakeCause::Asleep => break,
            other => panic!("{other:?}"),
        }
        world.step(DT);
        steps += 1;
    }
    // 0.5 s less the 10 steps, rounded up to whole steps.
    assert!((20..=21).contains(&steps), "{steps}");
}

#[test]
fn why_awake_knows_the_other_reasons() {
    let mut world = World::default();
    let ground = BodyDef::fixed().with_shape(ShapeDef::half_space(Vec3::Y, 0.0));
    let ground = world.add_body(ground).unwrap();
    let below = world.add_body(cube_at(vec3(0.0, 0.5, 0.0))).unwrap();
    let restless = BodyDef { can_sleep: false, ..cube_at(vec3(0.0, 1.5, 0.0)) };
    let restless = world.add_body(restless).unwrap();
    // A belt moves a box some distance away.
    let belt = BodyDef::kinematic().with_position([10.0, -0.5, 0.0]);
    let belt = belt.with_linear_velocity([0.0, 0.0, 0.3]);
    let belt = world.add_body(belt.with_shape(ShapeDef::box_half([2.0, 0.6, 5.0]))).unwrap();
    let parcel = world.add_body(cube_at(vec3(10.0, 0.6, 0.0))).unwrap();
    let idle = world.add_body(BodyDef::kinematic().with_position([0.0, 50.0, 0.0])).unwrap();
    run(&mut world, 120);
    let cause = |world: &World, id| world.why_awake(id).unwrap().cause;
    assert_eq!(cause(&world, ground), AwakeCause::Static);
    assert_eq!(cause(&world, idle), AwakeCause::Idle);
    let why = world.why_awake(below).unwrap();
    assert_eq!((why.cause, why.body), (AwakeCause::CannotSleep, restless));
    assert_eq!(why.path, [below, restless]);
    assert!(
        matches!(cause(&world, belt), AwakeCause::Driven { speed } if (speed - 0.3).abs() < 1e-6)
    );
    let AwakeCause::TooFast { driven_by, .. } = cause(&world, parcel) else { panic!("it moves") };
    assert_eq!(driven_by, Some(belt));

    let mut config = world.config().clone();
    config.sleep.enabled = false;
    world.set_config(config).unwrap();
    assert_eq!(cause(&world, below), AwakeCause::SleepDisabled);
    world.remove_body(below);
    assert!(world.why_awake(below).is_none());
}

#[test]
fn why_awake_tells_of_an_island_that_is_not_taken_apart_yet() {
    // Three pairs of cubes are separated at once. A step checks only one island for splits, so two
    // islands must wait when all have been still for long enough.
    let mut world = with_ground(0.6);
    let mut pairs = Vec::new();
    for x in [0.0, 10.0, 20.0] {
        pairs.push([0.5, 1.5].map(|y| world.add_body(cube_at(vec3(x, y, 0.0))).unwrap()));
    }
    run(&mut world, 20);
    for ([_, upper], x) in pairs.iter().zip([5.0, 15.0, 25.0]) {
        world.body_mut(*upper).unwrap().set_pose(Pose::at([x, 0.5, 0.0]));
    }
    let mut waited = 0;
    let cause = |world: &World, id| world.why_awake(id).unwrap().cause;
    for _ in 0..60 {
        world.step(DT);
        let waits = |p: &&[BodyId; 2]| matches!(cause(&world, p[0]), AwakeCause::NotSplit { .. });
        waited = waited.max(pairs.iter().filter(waits).count());
    }
    assert_eq!(waited, 2);
    for id in pairs.iter().flatten() {
        assert_eq!(cause(&world, *id), AwakeCause::Asleep);
    }
}
