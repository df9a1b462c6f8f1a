//! Bodies placed at rest stay in place from the first step on, because their contacts get the loads
//! of the bodies above.

use drystone::math::trig::sin_cos;
use drystone::{BodyDef, BodyId, Quat, ShapeDef, Vec3, World, WorldConfig, vec3};

use crate::floors::{FLOORS, Floor, ground};

const G: f32 = 9.81;

const SIZES: [f32; 4] = [0.02, 0.1, 1.0, 10.0];

const RATES: [f32; 3] = [30.0, 60.0, 120.0];

/// A world with a floor for bodies of this size [m].
fn grounded(floor: Floor, size: f32) -> World {
    let mut world = World::default();
    ground(&mut world, floor, [20.0 * size, size]);
    world
}

fn boxed(world: &mut World, half: Vec3, at: Vec3) -> BodyId {
    let shape = ShapeDef::box_half(half).with_friction(0.6);
    world.add_body(BodyDef::dynamic().with_position(at).with_shape(shape)).unwrap()
}

fn places(world: &World, all: &[BodyId]) -> Vec<Vec3> {
    all.iter().map(|id| world.body(*id).unwrap().position()).collect()
}

/// Maximum displacement of a body [m].
fn farthest(world: &World, all: &[BodyId], from: &[Vec3]) -> f32 {
    let now = places(world, all);
    now.iter().zip(from).map(|(now, from)| (*now - *from).length()).fold(0.0, f32::max)
}

/// Maximum speed of a body [m/s].
fn fastest(world: &World, all: &[BodyId]) -> f32 {
    let speeds = all.iter().map(|id| world.body(*id).unwrap().linear_velocity().length());
    speeds.fold(0.0, f32::max)
}

/// Every floor, size [m] and rate [Hz].
fn cases() -> impl Iterator<Item = (Floor, f32, f32)> {
    FLOORS.into_iter().flat_map(|floor| {
        SIZES.into_iter().flat_map(move |size| RATES.map(|rate| (floor, size, rate)))
    })
}

/// A body that starts in the air gets at least `g dt` at first. Some thousandths of that are errors
/// of the contacts: rounding of a stack's sweeps, and points with uneven loads.
#[test]
fn stacks_do_not_move() {
    for (floor, size, rate) in cases() {
        let mut world = grounded(floor, size);
        let half = Vec3::splat(0.5 * size);
        let up = |i: u8| vec3(0.0, (0.5 + f32::from(i)) * size, 0.0);
        let all: Vec<_> = (0..20).map(|i| boxed(&mut world, half, up(i))).collect();
        let from = places(&world, &all);
        for step in 0..60 {
            world.step(1.0 / rate);
            let fastest = fastest(&world, &all);
            let name = format!("{floor:?}, {size} m, {rate} Hz, step {step}");
            assert!(fastest < 0.1 * G / rate, "{name}: {fastest} m/s");
        }
        let off = farthest(&world, &all, &from);
        // Each contact yields by at most a hundredth of half a cube, or rests within 0.05 mm.
        let most = 20.0 * (0.005 * size).min(5.0e-5) + 1.0e-3 * size;
        assert!(off < most, "{floor:?}, {size} m, {rate} Hz: {off} m off");
    }
}

/// Three planks in each of 18 rows, in alternating directions. The lowest carry 17 rows, and each
/// lies on two or three others.
#[test]
fn a_tower_of_planks_stands_at_any_size_and_rate() {
    for (floor, size, rate) in cases() {
        let mut world = grounded(floor, size);
        let mut all = Vec::new();
        for row in 0..18_u8 {
            for plank in 0..3_u8 {
                let aside = (f32::from(plank) - 1.0) * 0.25 * size;
                let height = (f32::from(row) + 0.5) * 0.15 * size;
                let (at, half) = if row % 2 == 0 {
                    (vec3(0.0, height, aside), vec3(0.375, 0.075, 0.124))
                } else {
                    (vec3(aside, height, 0.0), vec3(0.124, 0.075, 0.375))
                };
                all.push(boxed(&mut world, half * size, at));
            }
        }
        let from = places(&world, &all);
        let mut time = 0.0;
        while time < 4.0 {
            world.step(1.0 / rate);
            time += 1.0 / rate;
        }
        let off = farthest(&world, &all, &from);
        // A twentieth of a plank's length.
        assert!(off < 0.0375 * size, "{floor:?}, {size} m, {rate} Hz: {off} m off");
    }
}

/// Friction acts from the first substep. On a slope within the friction limit nothing slides, and
/// on a steeper one everything slides with `g (sin − µ cos)` and no faster.
#[test]
fn what_is_put_on_a_slope_sticks_or_slides_as_friction_says() {
    for degrees in [5.0_f32, 20.0, 29.0, 33.0, 40.0] {
        for rate in RATES {
            let angle = degrees.to_radians();
            let (sin, cos) = sin_cos(angle);
            let mut world = World::default();
            let normal = vec3(sin, cos, 0.0);
            let down = vec3(cos, -sin, 0.0);
            let floor = ShapeDef::half_space(normal, 0.0).with_friction(0.6);
            world.add_body(BodyDef::fixed().with_shape(floor)).unwrap();
            let shape = ShapeDef::box_half([0.5, 0.25, 0.5]).with_friction(0.6);
            let def = BodyDef::dynamic()
                .with_position(normal * 0.25)
                .with_rotation(Quat::from_axis_angle(Vec3::Z, -angle))
                .with_shape(shape);
            let id = world.add_body(def).unwrap();
            for step in 1..=30_u8 {
                world.step(1.0 / rate);
                let time = f32::from(step) / rate;
                let speed = world.body(id).unwrap().linear_velocity().dot(down);
                let right = (G * (sin - 0.6 * cos)).max(0.0) * time;
                // A tenth of the speed gravity adds in a substep.
                let most = 0.1 * G / rate / 8.0;
                let name = format!("{degrees}°, {rate} Hz, step {step}");
                assert!((speed - right).abs() < most, "{name}: {speed} m/s, not {right}");
            }
        }
    }
}

/// Contacts keep their loads when a support is replaced: nothing falls when the floor under a stack
/// changes.
#[test]
fn a_stack_that_is_set_on_another_floor_does_not_move() {
    for floor in FLOORS {
        let mut world = World::default();
        let old = ground(&mut world, floor, [20.0, 1.0]);
        let up = |i: u8| vec3(0.0, 0.5 + f32::from(i), 0.0);
        let all: Vec<_> = (0..10).map(|i| boxed(&mut world, Vec3::splat(0.5), up(i))).collect();
        (0..30).for_each(|_| world.step(1.0 / 60.0));
        assert!(world.remove_body(old));
        ground(&mut world, floor, [20.0, 1.0]);
        for step in 0..30 {
            world.step(1.0 / 60.0);
            let fastest = fastest(&world, &all);
            // A substep of gravity.
            assert!(fastest < G / 480.0, "{floor:?}, step {step}: {fastest} m/s");
        }
    }
}

/// Without load-adaptive inertia, a loaded body is as easy to push as an unloaded one.
#[test]
fn what_is_put_down_has_its_own_mass_if_it_is_to() {
    let mut config = WorldConfig::default();
    config.inertia.max_factor = 1.0;
    let mut world = World::new(config).unwrap();
    ground(&mut world, Floor::HalfSpace, [20.0, 1.0]);
    let shape = ShapeDef::box_half([0.5; 3]).with_friction(0.0);
    let mut put = |y: f32, mass: f32| {
        let def = BodyDef::dynamic().with_position([0.0, y, 0.0]).with_shape(shape.clone());
        world.add_body(def.with_mass(mass)).unwrap()
    };
    let (low, _) = (put(0.5, 1.0), put(1.5, 200.0));
    world.step(1.0 / 60.0);
    world.body_mut(low).unwrap().apply_impulse([0.1, 0.0, 0.0]);
    world.step(1.0 / 60.0);
    let speed = world.body(low).unwrap().linear_velocity().x;
    assert!((speed - 0.1).abs() < 1.0e-3, "{speed} m/s");
}
