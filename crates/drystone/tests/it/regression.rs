//! Bugs that `cargo xtask attack` found, shrunk and described.

use drystone::breakage::{Fatigue, Fracture, JointStrength};
use drystone::joint::{Ball, CouplingDef, Hinge, JointAxis, Universal};
use drystone::{AxisLocks, BodyDef, BodyId, JointDef, JointId, ShapeDef, Vec3, World, WorldConfig};

const DT: f32 = 1.0 / 60.0;

/// Steps a world and a copy that is restored from its snapshot before every step, and compares them
/// after each step.
fn goes_on_from_every_snapshot(
    world: &mut World,
    steps: usize,
    mut each: impl FnMut(&mut World, usize),
) {
    for step in 0..steps {
        each(world, step);
        let mut other = World::restore(&world.snapshot()).unwrap();
        world.step(DT);
        other.step(DT);
        assert_eq!(world.state_hash(), other.state_hash(), "step {step}");
    }
}

/// Two bodies on a hinge, one above the other.
fn pair(world: &mut World, articulated: bool) -> ([BodyId; 2], JointId) {
    let [a, b] = [0.0, 1.0].map(|y| {
        let def =
            BodyDef::dynamic().with_position([0.0, y, 0.0]).with_angular_velocity([1.0, 2.0, 3.0]);
        world.add_body(def.with_shape(ShapeDef::box_half([0.2, 0.4, 0.3]))).unwrap()
    });
    let axes = Hinge::new().six_dof();
    let def = JointDef::new(a, b, axes).at([0.0, 0.5, 0.0]).with_axis(Vec3::X);
    let joint = world.add_joint(def.with_articulated(articulated)).unwrap();
    ([a, b], joint)
}

/// Bodies with locks belong to no tree; the plan must follow.
#[test]
fn a_body_of_a_tree_may_be_locked_while_it_moves() {
    let mut world = World::default();
    let ([a, _], _) = pair(&mut world, true);
    goes_on_from_every_snapshot(&mut world, 20, |world, step| {
        if step == 10 {
            let locks = AxisLocks { linear: [false, true, false], angular: [false; 3] };
            world.body_mut(a).unwrap().set_locks(locks);
        }
    });
}

/// The plan must follow the number of rows of a joint in a tree that was formed by load.
#[test]
fn a_joint_that_carries_much_takes_other_axes_while_it_moves() {
    let mut world = World::default();
    let anchor = world.add_body(BodyDef::fixed().with_position([0.0, 1.5, 0.0])).unwrap();
    let ([a, b], joint) = pair(&mut world, false);
    // Formed by load: the lower body is a thousand times as heavy.
    let def = JointDef::new(anchor, b, Ball::new()).with_anchors([0.0; 3], [0.0, 0.5, 0.0]);
    world.add_joint(def).unwrap();
    world.add_shape(a, ShapeDef::box_half([0.2; 3]).with_density(1.0e6)).unwrap();
    let limited = JointAxis::limited(-1.0, 1.0);
    goes_on_from_every_snapshot(&mut world, 40, |world, step| {
        let to = match step {
            10 => Hinge::of(limited).six_dof(),
            20 => Universal::of(limited, limited).six_dof(),
            30 => Hinge::new().six_dof(),
            _ => return,
        };
        world.joint_mut(joint).unwrap().set_axes(to).unwrap();
    });
}

/// Islands with fast rotation refine their substeps. An island that splits passes its number to
/// only one of its parts.
#[test]
fn an_island_that_tumbles_may_fall_apart() {
    let config = WorldConfig { gravity: Vec3::ZERO, ..WorldConfig::default() };
    let mut world = World::new(config).unwrap();
    let bodies: Vec<BodyId> = [0.0_f32, 1.0, 2.0, 3.0]
        .into_iter()
        .map(|x| {
            let spin = if x < 1.5 { [0.0, 0.0, 40.0] } else { [0.0, 0.0, 0.5] };
            let def = BodyDef::dynamic().with_position([x, 0.0, 0.0]).with_angular_velocity(spin);
            let shape = ShapeDef::box_half([0.45, 0.1, 0.1]);
            world.add_body(def.with_shape(shape)).unwrap()
        })
        .collect();
    let joints: Vec<JointId> = bodies
        .windows(2)
        .map(|pair| {
            let joint = JointDef::new(pair[0], pair[1], Ball::new())
                .with_anchors([0.5, 0.0, 0.0], [-0.5, 0.0, 0.0]);
            world.add_joint(joint).unwrap()
        })
        .collect();
    goes_on_from_every_snapshot(&mut world, 240, |world, step| {
        if step == 30 {
            assert!(world.remove_joint(joints[1]));
        }
    });
}

/// (load over limit)^32 overflows f32.
#[test]
fn a_joint_that_wears_out_at_once_tells_a_finite_damage() {
    let mut world = World::default();
    let anchor = world.add_body(BodyDef::fixed()).unwrap();
    let heavy = BodyDef::dynamic().with_position([0.0, -1.0, 0.0]).with_mass(1.0e6);
    let heavy = world.add_body(heavy.with_shape(ShapeDef::sphere(0.4))).unwrap();
    let fatigue = Fatigue { life: 1.0, exponent: 32, endurance: 0.1 };
    let strength = JointStrength { force: 1.0, fatigue: Some(fatigue), ..JointStrength::default() };
    let def = JointDef::new(anchor, heavy, Ball::new()).with_anchors([0.0; 3], [0.0, 1.0, 0.0]);
    world.add_joint(JointDef { strength: Some(strength), ..def }).unwrap();
    let mut broken = Vec::new();
    for _ in 0..5 {
        world.step(DT);
        broken.extend_from_slice(&world.events().joint_break);
    }
    assert_eq!(broken.len(), 1);
    assert!(broken[0].damage.is_finite() && broken[0].force.is_finite());
}

/// When a body breaks, its joints move to its pieces, and couplings must move with them; otherwise
/// a coupling would span two islands.
#[test]
fn a_coupling_follows_its_joints_to_the_pieces_of_a_body() {
    let mut world = World::default();
    let base = world.add_body(BodyDef::fixed().with_position([0.0, 3.0, 0.0])).unwrap();
    let slab = BodyDef::dynamic().with_position([0.0, 3.0, 0.0]);
    let slab = world.add_body(slab.with_shape(ShapeDef::box_half([1.0, 0.2, 0.2]))).unwrap();
    let wheel = |world: &mut World, x: f32| {
        let def = BodyDef::dynamic().with_position([x, 3.5, 0.0]);
        let wheel = world.add_body(def.with_shape(ShapeDef::sphere(0.2))).unwrap();
        let axes = Hinge::new().six_dof();
        let def = JointDef::new(slab, wheel, axes).at([x, 3.3, 0.0]).with_axis(Vec3::Z);
        world.add_joint(def).unwrap()
    };
    let (left, right) = (wheel(&mut world, -0.8), wheel(&mut world, 0.8));
    world.add_joint(JointDef::new(base, slab, Ball::new())).unwrap();
    let gear = world.add_coupling(CouplingDef::gear(left, right, 2.0)).unwrap();
    let how = Fracture { pieces: 8, ..Fracture::default() };
    goes_on_from_every_snapshot(&mut world, 120, |world, step| {
        if step == 20 {
            let pieces =
                world.body_mut(slab).expect("there").break_at([0.0, 3.2, 0.0], &how).unwrap();
            assert!(pieces.len() > 2 && world.body(slab).is_none());
            let ends = [left, right].map(|id| {
                let joint = world.joint(id).unwrap();
                [joint.body_a(), joint.body_b()]
            });
            let gear = world.joint(gear).unwrap();
            assert!(ends[0].contains(&gear.body_a()) || ends[0].contains(&gear.body_b()));
            assert!(ends[1].contains(&gear.body_a()) || ends[1].contains(&gear.body_b()));
        }
    });
}
