//! Articulations in a world: contacts, free bodies, sleep, snapshots, threads.

use drystone::articulation::{
    Articulation, ArticulationDef, ArticulationId, LinkDef, TreeDef, TreeJoint,
};
use drystone::{BodyDef, ShapeDef, World};

const DT: f32 = 1.0 / 60.0;

fn floor() -> BodyDef {
    BodyDef::fixed()
        .with_shape(ShapeDef::box_half([20.0, 0.5, 20.0]).with_position([0.0, -0.5, 0.0]))
}

/// Inertia of a box with half extents.
fn of_box(mass: f64, [x, y, z]: [f64; 3]) -> [f64; 6] {
    let third = mass / 3.0;
    [third * (y * y + z * z), third * (x * x + z * z), third * (x * x + y * y), 0.0, 0.0, 0.0]
}

/// A table: a floating top of 8 kg on four legs of 0.5 kg, each on a sprung hinge.
fn table() -> ArticulationDef {
    let half = [0.4, 0.05, 0.4];
    let top = LinkDef::floating().with_position([0.0, 0.5, 0.0]).with_mass(
        8.0,
        [0.0; 3],
        of_box(8.0, half),
    );
    let mut links = vec![top];
    let leg_half = [0.03, 0.2, 0.03];
    for (x, z) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
        let hinge = TreeJoint::hinge([0.0, 0.0, 1.0]).with_spring(400.0, 0.0).with_damping(4.0);
        links.push(
            LinkDef::on(0).with_position([0.35 * x, -0.05, 0.35 * z]).with_joint(hinge).with_mass(
                0.5,
                [0.0, -0.2, 0.0],
                of_box(0.5, leg_half),
            ),
        );
    }
    let tree = TreeDef { links, ..TreeDef::default() };
    let mut def = ArticulationDef::new(tree).with_shape(0, ShapeDef::box_half([0.4, 0.05, 0.4]));
    for link in 1..5 {
        let leg = ShapeDef::box_half([0.03, 0.2, 0.03]).with_position([0.0, -0.2, 0.0]);
        def = def.with_shape(link, leg);
    }
    def
}

fn energy(world: &World, id: ArticulationId) -> f64 {
    let model = world.articulation(id).unwrap().model();
    model.kinetic_energy() + model.potential_energy()
}

#[test]
fn a_table_stands_on_its_legs() {
    let mut world = World::default();
    world.add_body(floor()).unwrap();
    let id = world.add_articulation(table()).unwrap();
    let start = energy(&world, id);
    for step in 0..240 {
        world.step(DT);
        let now = energy(&world, id);
        assert!(now <= start + 1.0e-3, "step {step}: {now} J from {start}");
    }
    let table = world.articulation(id).unwrap();
    assert!(table.is_asleep());
    let q = table.q();
    // The legs end 0.45 m below the top's center.
    assert!((q[1] - 0.45).abs() < 0.01, "{}", q[1]);
    assert!(table.v().iter().all(|v| *v == 0.0), "{:?}", table.v());
}

#[test]
fn a_link_that_touches_nothing_moves_as_alone() {
    let tree = table().tree;
    let mut world = World::default();
    let gravity = world.config().gravity.to_array().map(f64::from);
    let mut alone = Articulation::new(&tree, gravity).unwrap();
    let q = alone.q().to_vec();
    let v: Vec<f64> = (0..alone.v().len()).map(|i| 0.3 + 0.1 * i as f64).collect();
    alone.set_state(&q, &v).unwrap();
    let def = ArticulationDef::new(tree).with_state(q, v);
    let id = world.add_articulation(def).unwrap();
    for _ in 0..30 {
        world.step(DT);
        for _ in 0..8 {
            alone.step(f64::from(DT / 8.0)).unwrap();
        }
    }
    let there = world.articulation(id).unwrap();
    assert_eq!(there.q(), alone.q());
    assert_eq!(there.v(), alone.v());
}

#[test]
fn a_box_rests_on_a_table_and_the_table_bears_it() {
    let mut world = World::default();
    world.add_body(floor()).unwrap();
    let id = world.add_articulation(table()).unwrap();
    let cube = BodyDef::dynamic()
        .with_position([0.1, 0.7, 0.0])
        .with_shape(ShapeDef::box_half([0.1, 0.1, 0.1]).with_density(20_000.0));
    let cube = world.add_body(cube).unwrap();
    for _ in 0..300 {
        world.step(DT);
    }
    let table = world.articulation(id).unwrap();
    let at = world.body(cube).unwrap();
    assert!(at.linear_velocity().length() < 1.0e-2);
    assert!((f64::from(at.position().y) - (table.q()[1] + 0.15)).abs() < 0.01);
    assert!(table.q()[1] > 0.4, "{}", table.q()[1]);
}

/// A floating body of one link: a box of 2 kg with these half extents at a height.
fn lone_box(half: [f64; 3], height: f64, shape: ShapeDef) -> ArticulationDef {
    let link = LinkDef::floating().with_position([0.0, height, 0.0]).with_mass(
        2.0,
        [0.0; 3],
        of_box(2.0, half),
    );
    ArticulationDef::new(TreeDef { links: vec![link], ..TreeDef::default() }).with_shape(0, shape)
}

#[test]
fn a_lone_link_slides_as_far_as_friction_lets_it() {
    let mut world = World::default();
    world.add_body(floor()).unwrap();
    let shape = ShapeDef::box_half([0.3, 0.1, 0.3]);
    let friction = f64::from(shape.material.friction);
    let mut def = lone_box([0.3, 0.1, 0.3], 0.1, shape);
    def.v = Some(vec![2.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let id = world.add_articulation(def).unwrap();
    for _ in 0..120 {
        world.step(DT);
    }
    let sled = world.articulation(id).unwrap();
    // v²/(2 μ g), and up to v times a substep for when friction begins.
    let way = 4.0 / (2.0 * friction * 9.81);
    let (x, rest) = (sled.q()[0], sled.v()[0]);
    assert!((x - way).abs() < 2.0 / 480.0 + 0.01 * way, "{x} m for {way} m, {rest} m/s");
    assert!(rest.abs() < 1.0e-4, "{rest}");
}

#[test]
fn a_lone_link_bounces_as_a_body_does() {
    let mut world = World::default();
    world.add_body(floor().with_shape(ShapeDef::box_half([1.0, 0.1, 1.0]))).unwrap();
    let ball = || ShapeDef::sphere(0.2).with_restitution(0.8);
    let id = world.add_articulation(lone_box([0.2, 0.2, 0.2], 1.5, ball())).unwrap();
    let body = BodyDef::dynamic().with_position([5.0, 1.5, 0.0]).with_shape(ball());
    let body = world.add_body(body).unwrap();
    let mut highest = [0.0_f64; 2];
    let mut has_hit = [false; 2];
    for _ in 0..90 {
        world.step(DT);
        let heights = [
            world.articulation(id).unwrap().q()[1],
            f64::from(world.body(body).unwrap().position().y),
        ];
        for i in 0..2 {
            has_hit[i] |= heights[i] < 0.4;
            if has_hit[i] {
                highest[i] = highest[i].max(heights[i]);
            }
        }
    }
    // The link falls 1.2 m to the upper face at 0.1 m, so to 0.3 m; it rises by e² of that.
    let rise = 0.64 * 1.2;
    assert!((highest[0] - 0.3 - rise).abs() < 0.03 * rise, "{highest:?}");
}

#[test]
fn a_blow_between_an_articulation_and_a_body_keeps_momentum_and_gives_no_energy() {
    use drystone::WorldConfig;
    let mut world =
        World::new(WorldConfig { gravity: drystone::Vec3::ZERO, ..WorldConfig::default() })
            .unwrap();
    let id = world.add_articulation(table()).unwrap();
    let ball = BodyDef::dynamic()
        .with_position([-1.5, 0.28, 0.33])
        .with_linear_velocity([6.0, 0.0, 0.0])
        .with_shape(ShapeDef::sphere(0.1).with_density(1000.0));
    let ball = world.add_body(ball).unwrap();
    let sums = |world: &World| {
        let model = world.articulation(id).unwrap().model();
        let body = world.body(ball).unwrap();
        let mass = f64::from(body.mass());
        let v = body.linear_velocity().to_array().map(f64::from);
        let linear: [f64; 3] = std::array::from_fn(|i| model.momentum()[1][i] + mass * v[i]);
        let energy =
            model.kinetic_energy() + model.potential_energy() + f64::from(body.kinetic_energy());
        (linear, energy)
    };
    let (momentum, start) = sums(&world);
    let mut hit = false;
    for step in 0..90 {
        world.step(DT);
        let (now, energy) = sums(&world);
        hit |= energy < 0.99 * start;
        for i in 0..3 {
            let off = (now[i] - momentum[i]).abs();
            assert!(off < 1.0e-4 * momentum[0], "step {step}: {now:?} from {momentum:?}");
        }
        assert!(energy < start * 1.001, "step {step}: {energy} J from {start} J");
    }
    assert!(hit);
}

/// A pile: a table falls onto another, and boxes onto both.
fn busy_world() -> (World, Vec<ArticulationId>) {
    let mut world = World::default();
    world.add_body(floor()).unwrap();
    let mut ids = Vec::new();
    for i in 0..3 {
        let mut def = table();
        def.tree.links[0].position[1] += 0.7 * f64::from(i);
        def.tree.links[0].position[0] += 0.05 * f64::from(i);
        ids.push(world.add_articulation(def).unwrap());
    }
    for i in 0..12_u8 {
        let at =
            [0.1 * f32::from(i % 3) - 0.1, 2.4 + 0.3 * f32::from(i / 3), 0.07 * f32::from(i % 4)];
        let body = BodyDef::dynamic().with_position(at).with_shape(ShapeDef::box_half([0.08; 3]));
        world.add_body(body).unwrap();
    }
    (world, ids)
}

fn bits(world: &World, ids: &[ArticulationId]) -> Vec<u64> {
    let mut bits = vec![world.state_hash()];
    for id in ids {
        let of = world.articulation(*id).unwrap();
        bits.extend(of.q().iter().chain(of.v()).map(|x| x.to_bits()));
    }
    bits
}

#[test]
fn threads_and_simd_levels_change_no_bit_of_an_articulation() {
    let (mut one, ids) = busy_world();
    let mut others: Vec<World> = [2, 4].map(|n| busy_world().0.with_threads(n)).into();
    for level in drystone::threads::SimdLevel::available() {
        let mut other = busy_world().0;
        other.set_simd_level(level);
        others.push(other);
    }
    for step in 0..150 {
        one.step(DT);
        let expected = bits(&one, &ids);
        for other in &mut others {
            other.step(DT);
            assert_eq!(bits(other, &ids), expected, "step {step}");
        }
    }
    assert!(one.bodies().all(|body| body.position().is_finite()));
}

#[test]
fn a_saved_world_with_articulations_goes_on_with_the_same_bits() {
    let (mut world, ids) = busy_world();
    for _ in 0..40 {
        world.step(DT);
    }
    let mut restored = World::restore(&world.snapshot()).unwrap();
    let mut copy = world.clone();
    for step in 0..60 {
        world.step(DT);
        restored.step(DT);
        copy.step(DT);
        assert_eq!(bits(&world, &ids), bits(&restored, &ids), "step {step}");
        assert_eq!(bits(&world, &ids), bits(&copy, &ids), "step {step}");
    }
}

#[test]
fn an_impulse_on_a_link_moves_the_tree_by_its_inertia() {
    use drystone::WorldConfig;
    // A hinged rod of 1 kg, 1 m long: an impulse of 1 N s at its end changes its rate by
    // 1 N s · 1 m / (1/3 kg m²) = 3 rad/s.
    let mut world =
        World::new(WorldConfig { gravity: drystone::Vec3::ZERO, ..WorldConfig::default() })
            .unwrap();
    let rod = LinkDef::default().with_joint(TreeJoint::hinge([0.0, 0.0, 1.0])).with_mass(
        1.0,
        [0.5, 0.0, 0.0],
        [0.0, 1.0 / 12.0, 1.0 / 12.0, 0.0, 0.0, 0.0],
    );
    let def = ArticulationDef::new(TreeDef { links: vec![rod], ..TreeDef::default() });
    let id = world.add_articulation(def).unwrap();
    let body = world.articulation(id).unwrap().body(0).unwrap();
    world.body_mut(body).unwrap().apply_impulse_at([0.0, 1.0, 0.0], [1.0, 0.0, 0.0]);
    world.step(DT);
    let rate = world.articulation(id).unwrap().v()[0];
    assert!((rate - 3.0).abs() < 1.0e-5, "{rate}");
}

#[test]
fn what_does_not_suit_a_link_is_refused() {
    use drystone::method::Method;
    use drystone::{BodyKind, MassDef, Pose, WorldConfig};
    let mut world = World::default();
    let id = world.add_articulation(table()).unwrap();
    let body = world.articulation(id).unwrap().body(1).unwrap();
    let before = world.state_hash();
    let mut leg = world.body_mut(body).unwrap();
    assert!(leg.set_kind(BodyKind::Static).is_err());
    assert!(leg.set_mass(MassDef::Mass(3.0)).is_err());
    leg.set_pose(Pose::default());
    assert_eq!(world.state_hash(), before);
    world.step(DT);
    assert_eq!(world.events().faults.len(), 1);
    let classic = WorldConfig { method: Method::guendelman(), ..world.config().clone() };
    assert!(world.set_config(classic.clone()).is_err());
    assert!(World::new(classic).unwrap().add_articulation(table()).is_err());
    let mut wrong = table();
    wrong.shapes[0].0 = 9;
    assert!(world.add_articulation(wrong).is_err());
    assert_eq!(world.articulations().count(), 1);
}

#[test]
fn links_are_free_without_one_of_them_and_go_with_their_articulation() {
    let mut world = World::default();
    let id = world.add_articulation(table()).unwrap();
    let bodies: Vec<_> = world.articulation(id).unwrap().bodies().collect();
    assert_eq!(world.bodies().count(), 5);
    let mut other = world.clone();
    assert!(world.remove_articulation(id));
    assert_eq!((world.bodies().count(), world.joints().count()), (0, 0));
    assert!(other.remove_body(bodies[2]));
    assert!(other.articulation(id).is_none());
    assert_eq!((other.bodies().count(), other.joints().count()), (4, 0));
    for _ in 0..30 {
        other.step(DT);
    }
    assert!(other.body(bodies[1]).unwrap().linear_velocity().y < -4.0);
}

#[test]
fn a_state_that_is_set_moves_the_bodies() {
    let mut world = World::default();
    world.add_body(floor()).unwrap();
    let id = world.add_articulation(table()).unwrap();
    for _ in 0..200 {
        world.step(DT);
    }
    let mut articulation = world.articulation_mut(id).unwrap();
    let mut q = articulation.get().q().to_vec();
    q[1] = 3.0;
    let v = vec![0.0; 10];
    articulation.set_state(&q, &v).unwrap();
    assert!(articulation.set_state(&q[1..], &v).is_err());
    let body = articulation.get().body(0).unwrap();
    assert!((world.body(body).unwrap().position().y - 3.0).abs() < 1.0e-6);
    world.step(DT);
    assert!(!world.articulation(id).unwrap().is_asleep());
    assert!(world.body(body).unwrap().linear_velocity().y < -0.1);
}

#[test]
fn the_audit_has_the_energy_of_the_tree() {
    let mut def = table();
    for link in &mut def.tree.links[1..] {
        link.joints[0].armature = 0.02;
    }
    let count = 10_u8;
    let q = Articulation::new(&def.tree, [0.0; 3]).unwrap().q().to_vec();
    def = def.with_state(q, (0..count).map(|i| 0.2 * f64::from(i)).collect::<Vec<_>>());
    let mut world = World::default();
    let id = world.add_articulation(def).unwrap();
    for _ in 0..10 {
        world.step(DT);
    }
    let (audit, model) = (world.audit().energy.total(), energy(&world, id));
    // Poses and velocities of bodies have 24 binary digits.
    let kinetic = world.articulation(id).unwrap().model().kinetic_energy();
    assert!((audit - model).abs() < 1.0e-5 * (kinetic + model.abs()), "{audit} J, {model} J");
}

#[test]
fn a_state_beyond_all_numbers_is_a_fault_and_comes_back() {
    let mut world = World::default();
    world.add_body(floor()).unwrap();
    let id = world.add_articulation(table()).unwrap();
    let start = world.articulation(id).unwrap().q().to_vec();
    for fast in [1.0e7, 1.0e9, 1.0e11] {
        let mut table = world.articulation_mut(id).unwrap();
        assert!(table.set_state(&start, &[f64::NAN; 10]).is_err());
        assert!(table.set_forces(&[f64::INFINITY; 10]).is_err());
        table.set_state(&start, &[fast; 10]).unwrap();
        table.set_forces(&[1.0e12; 10]).unwrap();
        let mut faults = 0;
        for _ in 0..5 {
            world.step(DT);
            faults += world.events().faults.len();
        }
        assert!(faults > 0, "{fast}");
        assert!(world.bodies().all(|body| body.position().is_finite()));
        let mut table = world.articulation_mut(id).unwrap();
        table.set_forces(&[0.0; 10]).unwrap();
        table.set_state(&start, &[0.0; 10]).unwrap();
        for _ in 0..240 {
            world.step(DT);
        }
        let q = world.articulation(id).unwrap().q();
        assert!((q[1] - 0.45).abs() < 0.01, "{fast}: {q:?}");
    }
}

#[test]
fn links_can_be_disabled_split_and_removed_in_contact() {
    let (mut world, ids) = busy_world();
    for _ in 0..60 {
        world.step(DT);
    }
    let body = world.articulation(ids[0]).unwrap().body(2).unwrap();
    world.body_mut(body).unwrap().set_enabled(false);
    for _ in 0..20 {
        world.step(DT);
    }
    assert!(
        world
            .articulation(ids[0])
            .unwrap()
            .bodies()
            .all(|of| !world.body(of).unwrap().is_enabled())
    );
    world.body_mut(body).unwrap().set_enabled(true);
    for _ in 0..20 {
        world.step(DT);
    }
    let joint = world.body(body).unwrap().joints().next().unwrap();
    assert!(world.remove_joint(joint));
    assert!(world.articulation(ids[0]).is_none());
    assert!(world.remove_articulation(ids[2]));
    for _ in 0..60 {
        world.step(DT);
        assert!(world.events().faults.is_empty());
    }
    let restored = World::restore(&world.snapshot()).unwrap();
    assert_eq!(restored.state_hash(), world.state_hash());
    assert!(world.bodies().all(|body| body.position().y > -0.2));
}

#[test]
fn a_world_with_articulations_may_move_its_origin() {
    let mut here = World::default();
    here.add_body(floor()).unwrap();
    let id = here.add_articulation(table()).unwrap();
    let mut there = here.clone();
    there.shift_origin([-64.0, 0.0, 32.0]).unwrap();
    for _ in 0..120 {
        here.step(DT);
        there.step(DT);
    }
    let [a, b] = [&here, &there].map(|world| world.articulation(id).unwrap().q().to_vec());
    // Positions 64 m from the origin have steps of 8e-6 m.
    for (i, by) in [64.0, 0.0, -32.0].into_iter().enumerate() {
        assert!((a[i] + by - b[i]).abs() < 1.0e-3, "{a:?} {b:?}");
    }
}
