//! Bodies that freeze one by one: only while they rest.

use drystone::method::{Method, MethodOptions, Rest};
use drystone::{BodyDef, BodyId, ShapeDef, Vec3, World, WorldConfig, vec3};

const DT: f32 = 1.0 / 60.0;

fn world_of(method: &str) -> World {
    let options = MethodOptions { rest: Rest::Freeze, ..MethodOptions::default() };
    let method = Method::named(method).unwrap().with_options(options).unwrap();
    let mut world = World::new(WorldConfig { method, ..WorldConfig::default() }).unwrap();
    let ground = ShapeDef::box_half([50.0, 0.5, 50.0]);
    world.add_body(BodyDef::fixed().with_position([0.0, -0.5, 0.0]).with_shape(ground)).unwrap();
    world
}

fn cube(world: &mut World, at: impl Into<Vec3>) -> BodyId {
    let shape = ShapeDef::box_half([0.5; 3]);
    world.add_body(BodyDef::dynamic().with_position(at).with_shape(shape)).unwrap()
}

fn run(world: &mut World, steps: u32) {
    (0..steps).for_each(|_| world.step(DT));
}

fn awake(world: &World, bodies: &[BodyId]) -> usize {
    bodies.iter().filter(|b| !world.body(**b).unwrap().is_asleep()).count()
}

fn at(world: &World, body: BodyId) -> Vec3 {
    world.body(body).unwrap().position()
}

#[test]
fn a_column_freezes_and_falls_when_its_lowest_cube_is_taken_away() {
    for method in ["soft-step", "guendelman", "sequential-impulses"] {
        let mut world = world_of(method);
        let cubes: Vec<BodyId> =
            (0..5).map(|i| cube(&mut world, [0.0, 0.5 + i as f32, 0.0])).collect();
        run(&mut world, 240);
        assert_eq!(awake(&world, &cubes), 0, "{method}");
        assert!(world.remove_body(cubes[0]));
        // They wake one after the other, each at the latest when its support begins to fall: one
        // cube per step.
        run(&mut world, 15);
        assert_eq!(awake(&world, &cubes[1..]), 4, "{method}");
        run(&mut world, 240);
        for (i, cube) in cubes[1..].iter().enumerate() {
            let off = (at(&world, *cube) - vec3(0.0, 0.5 + i as f32, 0.0)).length();
            assert!(off < 0.05, "{method}: cube {i} is {off} m off its new place");
        }
    }
}

#[test]
fn nothing_floats_when_its_support_is_pulled_out_below_it() {
    // A plank on two cubes, one of which is carried away. No body is removed, and the plank must
    // wake.
    let mut world = world_of("soft-step");
    let feet = [-1.5_f32, 1.5].map(|x| cube(&mut world, [x, 0.5, 0.0]));
    let plank = ShapeDef::box_half([2.0, 0.1, 0.5]);
    let plank = BodyDef::dynamic().with_position([0.0, 1.1, 0.0]).with_shape(plank);
    let plank = world.add_body(plank).unwrap();
    run(&mut world, 180);
    assert_eq!(awake(&world, &[feet[0], feet[1], plank]), 0);
    let mut foot = world.body_mut(feet[1]).unwrap();
    foot.set_linear_velocity([12.0, 0.0, 0.0]);
    run(&mut world, 180);
    let tip = world.body(plank).unwrap().rotation().rotate(Vec3::X).y;
    assert!(tip < -0.1 || at(&world, plank).y < 0.5, "{tip}, {:?}", at(&world, plank));
}

#[test]
fn nothing_floats_when_its_support_is_gone_within_a_step() {
    // Without friction the plank carries the same load in the step in which its foot moves five
    // meters. In the next step no contact is left that could report the change.
    let mut world = world_of("soft-step");
    let smooth = |half: [f32; 3]| ShapeDef::box_half(half).with_friction(0.0);
    let mut add = |at: [f32; 3], half: [f32; 3]| {
        let def = BodyDef::dynamic().with_position(at).with_shape(smooth(half));
        world.add_body(def).unwrap()
    };
    let feet = [-1.5_f32, 1.5].map(|x| add([x, 0.5, 0.0], [0.5; 3]));
    let plank = add([0.0, 1.1, 0.0], [2.0, 0.1, 0.5]);
    run(&mut world, 180);
    assert_eq!(awake(&world, &[feet[0], feet[1], plank]), 0);
    let mut foot = world.body_mut(feet[1]).unwrap();
    foot.set_linear_velocity([300.0, 0.0, 0.0]);
    run(&mut world, 120);
    let tip = world.body(plank).unwrap().rotation().rotate(Vec3::X).y;
    assert!(tip < -0.1 || at(&world, plank).y < 0.5, "{tip}, {:?}", at(&world, plank));
}

#[test]
fn a_throw_does_not_freeze_at_its_top() {
    for speed in [0.5_f32, 3.0, 6.0] {
        let mut world = world_of("soft-step");
        let shape = ShapeDef::sphere(0.25);
        let def = BodyDef::dynamic()
            .with_position([0.0, 5.0, 0.0])
            .with_linear_velocity([0.0, speed, 0.0]);
        let ball = world.add_body(def.with_shape(shape)).unwrap();
        for step in 1..=50 {
            world.step(DT);
            let t = step as f32 * DT;
            let wanted = 5.0 + speed * t - 0.5 * 9.81 * t * t;
            assert!(!world.body(ball).unwrap().is_asleep());
            // Rounding of 50 sums of numbers up to 8.
            assert!((at(&world, ball).y - wanted).abs() < 1.0e-4);
        }
    }
}

#[test]
fn a_hit_wakes_with_the_real_mass() {
    let mut world = world_of("soft-step");
    let smooth = |shape: ShapeDef| ShapeDef { ..shape }.with_friction(0.0);
    let target = smooth(ShapeDef::box_half([0.5; 3]));
    let target = BodyDef::dynamic().with_position([0.0, 0.5, 0.0]).with_shape(target);
    let target = world.add_body(target).unwrap();
    run(&mut world, 120);
    assert_eq!(awake(&world, &[target]), 0);
    // The same mass at 6 m/s, plastic: both continue at half the speed.
    let bullet = smooth(ShapeDef::box_half([0.5; 3]));
    let def =
        BodyDef::dynamic().with_position([-3.0, 0.5, 0.0]).with_linear_velocity([6.0, 0.0, 0.0]);
    let bullet = world.add_body(def.with_shape(bullet)).unwrap();
    run(&mut world, 60);
    for body in [target, bullet] {
        let v = world.body(body).unwrap().linear_velocity().x;
        assert!((v - 3.0).abs() < 0.03, "{v}");
    }
}

#[test]
fn what_lies_below_stays_frozen_while_something_light_moves_on_it() {
    let mut world = world_of("soft-step");
    let table = ShapeDef::box_half([8.0, 0.5, 2.0]);
    let table = BodyDef::dynamic().with_position([0.0, 0.5, 0.0]).with_shape(table);
    let table = world.add_body(table).unwrap();
    run(&mut world, 120);
    let ball = ShapeDef::sphere(0.3);
    let def = BodyDef::dynamic()
        .with_position([-6.0, 1.3, 0.0])
        .with_linear_velocity([2.0, 0.0, 0.0])
        .with_angular_velocity([0.0, 0.0, -2.0 / 0.3]);
    let ball = world.add_body(def.with_shape(ball)).unwrap();
    // The touch itself wakes the table for half a second.
    run(&mut world, 90);
    for _ in 0..120 {
        world.step(DT);
        assert_eq!((awake(&world, &[table]), awake(&world, &[ball])), (0, 1));
    }
    assert!(at(&world, ball).x > 0.0);
}

#[test]
fn a_load_wakes_what_carries_it_and_an_island_that_rests_sleeps_whole() {
    let mut world = world_of("soft-step");
    let low = cube(&mut world, [0.0, 0.5, 0.0]);
    run(&mut world, 120);
    assert_eq!(awake(&world, &[low]), 0);
    let high = cube(&mut world, [0.0, 1.5, 0.0]);
    run(&mut world, 6);
    assert_eq!(awake(&world, &[low, high]), 2);
    run(&mut world, 120);
    assert_eq!(awake(&world, &[low, high]), 0);
    // After removal the lower cube is awake for a while, and rests again.
    assert!(world.remove_body(high));
    run(&mut world, 120);
    assert_eq!(awake(&world, &[low]), 0);
    assert!((at(&world, low).y - 0.5).abs() < 1.0e-3);
}
