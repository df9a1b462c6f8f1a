//! Joints that go round fast: their islands take substeps in parts.

use drystone::{
    BodyDef, BodyId, JointDef, JointId, JointKind, ShapeDef, Vec3, World, WorldConfig, vec3,
};

const DT: f32 = 1.0 / 60.0;

fn weightless(parts: u16) -> World {
    let mut config = WorldConfig { gravity: Vec3::ZERO, ..WorldConfig::default() };
    config.joint.refine = parts.into();
    World::new(config).unwrap()
}

/// A bar of 1 kg and 1 m that turns about a post at its end, at this height. A rope that is never taut goes from it to a ball: what
/// hangs on one ball joint alone is solved in closed form.
fn add_bar(world: &mut World, height: f32, speed: f32) -> (BodyId, JointId) {
    let post = world.add_body(BodyDef::fixed().with_position([0.0, height, 0.0])).unwrap();
    let mut bar = BodyDef::dynamic()
        .with_position([0.5, height, 0.0])
        .with_shape(ShapeDef::box_full([1.0, 0.05, 0.05]))
        .with_mass(1.0);
    bar.linear_velocity = vec3(0.0, 0.0, -0.5 * speed);
    bar.angular_velocity = vec3(0.0, speed, 0.0);
    let bar = world.add_body(bar).unwrap();
    let joint = JointDef::ball(post, Vec3::ZERO, bar, vec3(-0.5, 0.0, 0.0));
    let joint = world.add_joint(joint).unwrap();
    (add_slack(world, bar, height), joint)
}

/// A ball on a rope from `body` that is never taut: no force, but one island.
fn add_slack(world: &mut World, body: BodyId, height: f32) -> BodyId {
    let ball = BodyDef::dynamic().with_position([0.0, height, 20.0]);
    let ball = world.add_body(ball.with_shape(ShapeDef::sphere(0.1))).unwrap();
    let kind = JointKind::Distance { min: 0.0, max: 1000.0, spring: None };
    world
        .add_joint(JointDef { kind, ..JointDef::ball(body, Vec3::ZERO, ball, Vec3::ZERO) })
        .unwrap();
    ball
}

/// What the joint gives [m] in a second of this turning, at most in its second half.
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

/// What a joint of a quarter of the substep's rate gives under the bar's pull [m].
fn give(speed: f32, parts: u16) -> f32 {
    let omega = 2.0 * core::f32::consts::PI * 0.25 * 480.0 * f32::from(parts);
    0.5 * speed * speed / (omega * omega)
}

#[test]
fn a_fast_bar_is_held_as_the_parts_say() {
    for parts in [1, 2, 4, 8] {
        let mut world = weightless(parts);
        let (_, joint) = add_bar(&mut world, 0.0, 60.0);
        let (gap, give) = (gap(&mut world, joint), give(60.0, parts));
        // Rows that stand still in a substep: the part that is wrong is of the order of its angle, and that angle is
        // 1/8 for one part. Arms that turn to second order only would make it 29 mm, and more with each part.
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
