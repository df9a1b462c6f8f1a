//! Joints that rotate fast, or are hit: their islands refine their substeps.

use drystone::joint::Ball;
use drystone::{
    BodyDef, BodyId, JointDef, JointId, JointKind, ShapeDef, Vec3, World, WorldConfig, vec3,
};

const DT: f32 = 1.0 / 60.0;

/// A world without gravity, whose small islands of fast joints refine substeps by this number of
/// parts.
pub(super) fn weightless(parts: u16) -> World {
    let mut config = WorldConfig { gravity: Vec3::ZERO, ..WorldConfig::default() };
    config.joint.refine = parts.into();
    World::new(config).unwrap()
}

/// A bar of 1 kg and 1 m that rotates about a post at its end, at this height. A rope that is never
/// taut connects it to a ball: a body on one ball joint alone would be solved in closed form.
fn add_bar(world: &mut World, height: f32, speed: f32) -> (BodyId, JointId) {
    let post = world.add_body(BodyDef::fixed().with_position([0.0, height, 0.0])).unwrap();
    let mut bar = BodyDef::dynamic()
        .with_position([0.5, height, 0.0])
        .with_shape(ShapeDef::box_full([1.0, 0.05, 0.05]))
        .with_mass(1.0);
    bar.linear_velocity = vec3(0.0, 0.0, -0.5 * speed);
    bar.angular_velocity = vec3(0.0, speed, 0.0);
    let bar = world.add_body(bar).unwrap();
    let joint =
        JointDef::new(post, bar, Ball::new()).with_anchors(Vec3::ZERO, vec3(-0.5, 0.0, 0.0));
    let joint = world.add_joint(joint).unwrap();
    (add_slack(world, bar, height), joint)
}

/// A ball on a never taut rope from `body`: no force, but one island.
fn add_slack(world: &mut World, body: BodyId, height: f32) -> BodyId {
    let ball = BodyDef::dynamic().with_position([0.0, height, 20.0]);
    let ball = world.add_body(ball.with_shape(ShapeDef::sphere(0.1))).unwrap();
    let kind = JointKind::Distance { min: 0.0, max: 1000.0, spring: None };
    world.add_joint(JointDef { kind, ..JointDef::new(body, ball, Ball::new()) }).unwrap();
    ball
}

/// Maximum gap of the joint in the second half of one second of this rotation [m].
fn gap(world: &mut World, joint: JointId) -> f32 {
    let mut most = 0.0_f32;
    for step in 0..60 {
        world.step(DT);
        if step >= 30 {
            most = most.max(world.joint(joint).unwrap().error());
        }
    }
    most
}

/// Gap of a joint of 0.15 of the substep rate under the bar's force [m].
fn give(speed: f32, parts: u16) -> f32 {
    let omega = 2.0 * core::f32::consts::PI * 0.15 * 480.0 * f32::from(parts);
    0.5 * speed * speed / (omega * omega)
}

#[test]
fn a_fast_bar_is_held_as_the_parts_say() {
    for parts in [1, 2, 4, 8] {
        let mut world = weightless(parts);
        let (_, joint) = add_bar(&mut world, 0.0, 60.0);
        let (gap, give) = (gap(&mut world, joint), give(60.0, parts));
        // Rows are constant in a substep: the relative error is of the order of its angle, which is
        // 1/8 for one part. Lever arms that rotate to second order only would make it 29 mm, and
        // more with each part.
        let turn = 60.0 * DT / 8.0 / f32::from(parts);
        assert!((gap / give - 1.0).abs() < 3.0 * turn + 0.02, "{parts}: {gap}, {give}");
    }
}

#[test]
fn what_is_slow_keeps_its_bits() {
    let end = |parts: u16| {
        let mut world = weightless(parts);
        let [fast, slow] =
            [(0.0, 60.0), (10.0, 20.0)].map(|(height, speed)| add_bar(&mut world, height, speed).1);
        (0..60).for_each(|_| world.step(DT));
        [fast, slow].map(|id| world.joint(id).unwrap().error())
    };
    let ([fast, slow], [fine, same]) = (end(1), end(4));
    assert!(fine < 0.1 * fast, "{fine}, {fast}");
    assert_eq!(slow.to_bits(), same.to_bits());
}

#[test]
fn a_large_island_is_not_solved_finely_for_one_limb() {
    for others in [62_u8, 64] {
        let mut world = weightless(4);
        let (mut last, joint) = add_bar(&mut world, 0.0, 60.0);
        for i in 0..others {
            last = add_slack(&mut world, last, f32::from(i) + 1.0);
        }
        let gap = gap(&mut world, joint);
        let [whole, parts] = [1, 4].map(|parts| give(60.0, parts));
        if others == 62 {
            assert!(gap < 1.5 * parts, "{gap}");
        } else {
            assert!(gap > 0.5 * whole, "{gap}");
        }
    }
}

/// Gap of the joint of two balls, one above the other [m], in the step of impact. The lower one
/// hits the floor at this speed, an eighth of a step after the step's start.
fn give_of_a_hit(speed: f32, parts: u16, others: u8) -> f32 {
    let mut world = weightless(parts);
    world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space(Vec3::Y, 0.0))).unwrap();
    let ball = |height: f32| {
        let mut ball = BodyDef::dynamic()
            .with_position([0.0, height, 0.0])
            .with_shape(ShapeDef::sphere(0.1))
            .with_mass(1.0);
        ball.linear_velocity = vec3(0.0, -speed, 0.0);
        ball
    };
    let low = 0.1 + speed * DT / 8.0;
    let [a, b] = [low, low + 0.3].map(|height| world.add_body(ball(height)).unwrap());
    let joint =
        JointDef::new(a, b, Ball::new()).with_anchors(vec3(0.0, 0.15, 0.0), vec3(0.0, -0.15, 0.0));
    let joint = world.add_joint(joint).unwrap();
    let mut last = b;
    for i in 0..others {
        last = add_slack(&mut world, last, f32::from(i) + 10.0);
    }
    world.step(DT);
    world.joint(joint).unwrap().error()
}

#[test]
fn a_blow_on_joints_is_solved_in_parts() {
    // The upper ball continues for a substep before the joint holds it, v h = 42 mm, and six
    // substeps remain to close that, each by a fraction: 42 mm 0.7^6 = 5 mm for a fraction of 0.3.
    // With refinement it continues for a quarter of that, and 27 substeps remain.
    let [whole, fine] = [1, 4].map(|parts| give_of_a_hit(20.0, parts, 0));
    assert!(whole > 3.0e-3, "{whole}");
    assert!(fine < 0.25 * whole, "{fine}, {whole}");
}

#[test]
fn a_gentle_touch_and_a_large_island_are_not_solved_in_parts() {
    // 2 mm per substep, where 3 mm are three hundredths of the radius.
    for (speed, others) in [(1.0, 0), (20.0, 64)] {
        let [whole, fine] = [1, 4].map(|parts| give_of_a_hit(speed, parts, others));
        assert!(whole > 0.0 && whole.to_bits() == fine.to_bits(), "{speed}: {whole}, {fine}");
    }
}

/// Rebound speed of a ball of 1 kg that hits a held block of 2 kg at 5 m/s, at this many hundredths
/// of a step [m/s].
fn speed_after_a_hit(hundredths: u8, parts: u16) -> f32 {
    let mut world = weightless(parts);
    let post = world.add_body(BodyDef::fixed()).unwrap();
    let block = BodyDef::dynamic().with_shape(ShapeDef::box_half([0.5; 3])).with_mass(2.0);
    let block = world.add_body(block).unwrap();
    world.add_joint(JointDef::new(post, block, Ball::new())).unwrap();
    let gap = 5.0 * DT * f32::from(hundredths) / 100.0;
    let mut ball = BodyDef::dynamic()
        .with_position([0.6 + gap, 0.0, 0.0])
        .with_shape(ShapeDef::sphere(0.1))
        .with_mass(1.0);
    ball.linear_velocity = vec3(-5.0, 0.0, 0.0);
    let ball = world.add_body(ball).unwrap();
    (0..10).for_each(|_| world.step(DT));
    world.body(ball).unwrap().linear_velocity().x
}

#[test]
fn a_blow_of_a_steps_last_part_counts_once() {
    // Impulses are stored for whole substeps, four times those of the last part. An impact in that
    // part would return the ball at up to (4 - 1) 5 m/s times 1 kg over the mass of both. It should
    // not rebound at all; a joint that yields returns some speed. With refinement it yields less,
    // so at any time of impact the ball is slower than in whole substeps.
    let fastest = |parts| {
        (0..100).step_by(3).map(|at| speed_after_a_hit(at, parts)).fold(f32::NEG_INFINITY, f32::max)
    };
    let [whole, fine] = [1, 4].map(fastest);
    assert!(fine < whole && whole < 2.5, "{fine}, {whole}");
}

#[test]
fn parts_out_of_range_are_refused() {
    for parts in [0_u32, 9] {
        let mut config = WorldConfig::default();
        config.joint.refine = parts;
        let error = World::new(config).unwrap_err();
        assert!(error.to_string().contains("joint.refine"), "{error}");
        let mut config = WorldConfig::default();
        assert!(config.set("joint.refine", &parts.to_string()).is_err());
        assert_eq!(config.joint.refine, 4);
    }
}
