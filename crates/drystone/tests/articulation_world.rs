//! Articulations in a world: contacts, free bodies, sleep, snapshots, threads.

use drystone::articulation::{
    Articulation, ArticulationDef, ArticulationId, LinkDef, TreeDef, TreeJoint,
};
use drystone::{BodyDef, ShapeDef, World};

const DT: f32 = 1.0 / 60.0;

fn floor() -> BodyDef {
    BodyDef::fixed().with_shape(ShapeDef::box_half([20.0, 0.5, 20.0]).with_position([0.0, -0.5, 0.0]))
}

/// Inertia of a box with half extents.
fn of_box(mass: f64, [x, y, z]: [f64; 3]) -> [f64; 6] {
    let third = mass / 3.0;
    [third * (y * y + z * z), third * (x * x + z * z), third * (x * x + y * y), 0.0, 0.0, 0.0]
}

/// A table: a floating top of 8 kg on four legs of 0.5 kg, each on a sprung hinge.
fn table() -> ArticulationDef {
    let half = [0.4, 0.05, 0.4];
    let top = LinkDef::floating()
        .with_position([0.0, 0.5, 0.0])
        .with_mass(8.0, [0.0; 3], of_box(8.0, half));
    let mut links = vec![top];
    let leg_half = [0.03, 0.2, 0.03];
    for (x, z) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
        let hinge = TreeJoint::hinge([0.0, 0.0, 1.0]).with_spring(400.0, 0.0).with_damping(4.0);
        links.push(
            LinkDef::on(0)
                .with_position([0.35 * x, -0.05, 0.35 * z])
                .with_joint(hinge)
                .with_mass(0.5, [0.0, -0.2, 0.0], of_box(0.5, leg_half)),
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
    eprintln!("q {:?}\nv {:?} asleep {}", table.q(), table.v(), table.is_asleep());
    let q = table.q();
    // The legs end 0.45 m below the top's center.
    assert!((q[1] - 0.45).abs() < 0.01, "{}", q[1]);
    assert!(table.v().iter().all(|v| v.abs() < 1.0e-3), "{:?}", table.v());
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
    eprintln!("table {:?}\nv {:?}", table.q(), table.v());
    eprintln!("cube {:?} v {:?}", at.position(), at.linear_velocity());
    assert!(at.linear_velocity().length() < 1.0e-2);
    assert!((f64::from(at.position().y) - (table.q()[1] + 0.15)).abs() < 0.01);
    assert!(table.q()[1] > 0.4, "{}", table.q()[1]);
}
