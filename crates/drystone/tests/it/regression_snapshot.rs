//! A world made by calls can be saved after every step, and a restored one continues with the same
//! bits and events.

use drystone::audit::AwakeCause;
use drystone::breakage::{Bond, BondStrength, Glue};
use drystone::config::SleepConfig;
use drystone::joint::Ball;
use drystone::method::{Method, MethodOptions, Rest};
use drystone::{BodyDef, BodyId, JointDef, ShapeDef, Vec3, World, WorldConfig, vec3};

/// Radius of the rolling ball [m].
const RADIUS: f32 = 0.1;

/// Steps a world, and beside it a copy restored from its snapshot before each step.
fn step_and_restore(world: &mut World, dt: f32, step: usize) {
    let other = World::restore(&world.snapshot());
    assert!(other.is_ok(), "before step {step}: {}", other.unwrap_err());
    let mut other = other.unwrap();
    world.step(dt);
    other.step(dt);
    assert_eq!(world.state_hash(), other.state_hash(), "step {step}");
    assert_eq!(world.events(), other.events(), "step {step}");
}

/// A world of slow bodies: one rests, one rolls at 2 cm/s, one hangs and sways, one drifts.
fn slow_things(rest: Rest, time: f32) -> (World, BodyId) {
    let options = MethodOptions { rest, ..MethodOptions::default() };
    let method = Method::named("soft-step").unwrap().with_options(options).unwrap();
    let sleep = SleepConfig { time, ..WorldConfig::default().sleep };
    let mut world = World::new(WorldConfig { method, sleep, ..WorldConfig::default() }).unwrap();
    let floor = ShapeDef::half_space([0.0, 1.0, 0.0], 0.0);
    let ground = world.add_body(BodyDef::fixed().with_shape(floor)).unwrap();
    let at = |x: f32, y: f32| BodyDef::dynamic().with_position([x, y, 0.0]);
    world.add_body(at(-2.0, 0.5).with_shape(ShapeDef::box_half([0.5; 3]))).unwrap();
    let speed = 0.02;
    let ball = at(0.0, RADIUS).with_linear_velocity([0.0, 0.0, speed]).with_angular_velocity([
        speed / RADIUS,
        0.0,
        0.0,
    ]);
    let ball = world.add_body(ball.with_shape(ShapeDef::sphere(RADIUS))).unwrap();
    let bob = at(2.0, 2.0).with_linear_velocity([0.01, 0.0, 0.0]);
    let bob = world.add_body(bob.with_shape(ShapeDef::sphere(0.2))).unwrap();
    world
        .add_joint(
            JointDef::new(ground, bob, Ball::new()).with_anchors([2.0, 6.0, 0.0], [0.0, 4.0, 0.0]),
        )
        .unwrap();
    let mut drifting = at(4.0, 3.0).with_linear_velocity([0.0, 2.0e-4, 0.0]);
    drifting.gravity_scale = 0.0;
    world.add_body(drifting.with_shape(ShapeDef::sphere(0.3))).unwrap();
    (world, ball)
}

/// The rest of bodies is tracked by marks in time, and a long step moves their clock. Marks must
/// move with it, because speeds are displacements over the times between marks.
#[test]
fn what_is_slow_can_be_saved_and_is_judged_by_its_speed_whatever_the_lengths_of_steps() {
    let (short, shorter) = (1.0 / 60.0, 1.0 / 240.0);
    let hitches: [&[f32]; 6] = [
        &[],
        &[0.5],
        &[1.0],
        &[short, 0.3, shorter, 0.3],
        &[0.25, shorter, shorter, 0.25, short, 0.5],
        &[0.05, 0.1, 0.2, 0.4, 0.8],
    ];
    for (k, hitch) in hitches.into_iter().enumerate() {
        for rest in [Rest::Own, Rest::Freeze] {
            for time in [0.0, 0.1, 0.5] {
                let (mut world, ball) = slow_things(rest, time);
                let (mut judged, mut greatest) = (0, 0.0_f32);
                // It rolls first: a long first step would count as slow time, and the ball would
                // sleep.
                let lengths = [short; 40].into_iter().chain(hitch.iter().copied());
                let lengths = lengths.cycle().take(200);
                for (step, dt) in lengths.enumerate() {
                    let before = world.body(ball).unwrap().position();
                    step_and_restore(&mut world, dt, step);
                    let body = world.body(ball).unwrap();
                    let way = (body.position() - before).length() / dt;
                    let speed = body.linear_velocity().length().max(way);
                    greatest = greatest.max(speed + body.angular_velocity().length() * RADIUS);
                    if let Some(AwakeCause::TooFast { speed, .. }) =
                        world.why_awake(ball).map(|w| w.cause)
                    {
                        judged += 1;
                        // A mean speed cannot exceed the actual speeds. Marks are rounded to 1e-7
                        // of a meter or two, and are some hundredths of a second apart: 1e-4 of the
                        // speed.
                        let name = format!("hitch {k}, {rest:?}, {time} s, step {step}");
                        assert!(speed <= 1.001 * greatest, "{name}: {speed} of {greatest} m/s");
                    }
                }
                assert!(judged > 20 || time < 0.5, "hitch {k}: {judged}");
            }
        }
    }
}

/// A body that freezes alone and thaws under a new load has marks from before it froze.
#[test]
fn what_thaws_can_be_saved() {
    for time in [0.1, 0.5] {
        let (mut world, _) = slow_things(Rest::Freeze, time);
        let cube = ShapeDef::box_half([0.4; 3]);
        for step in 0..400 {
            if step % 50 == 49 {
                // It lands off the middle of the box, or on an earlier cube: loads and balances
                // change.
                let at = vec3(-2.2 + 0.004 * step as f32 % 0.5, 3.0, 0.1);
                let def = BodyDef::dynamic().with_position(at);
                world.add_body(def.with_shape(cube.clone())).unwrap();
            }
            step_and_restore(&mut world, 1.0 / 60.0, step);
        }
    }
}

/// A row of cubes that rotates about its middle; each bond is ten times as strong as the previous
/// one.
fn turning_row(area: Option<f32>) -> World {
    let config = WorldConfig { gravity: Vec3::ZERO, ..WorldConfig::default() };
    let mut world = World::new(config).unwrap();
    let at = |i: usize| vec3(i as f32 - 5.5, 0.0, 0.0);
    let cube = |i| ShapeDef::box_half([0.5; 3]).with_position(at(i)).with_density(1.0e10);
    let shapes: Vec<ShapeDef> = (0..12).map(cube).collect();
    let mut stress = 1.0e-37;
    let bonds = (0..11).map(|i| {
        stress *= 10.0;
        Bond {
            shapes: [i, i + 1],
            point: at(i) + vec3(0.5, 0.0, 0.0),
            normal: Vec3::X,
            area: area.unwrap_or(1.0),
            strength: BondStrength::both(stress),
        }
    });
    let glue = Glue { bonds: bonds.collect() };
    let def = BodyDef::dynamic().with_angular_velocity([0.0, 100.0, 0.0]);
    world.add_body(BodyDef { shapes, glue: Some(glue), ..def }).unwrap();
    world
}

/// Stress over strength may overflow f32: for bonds that broke, and for bonds that a step has not
/// reached yet.
#[test]
fn bonds_that_bear_far_too_much_can_be_saved_and_tell_numbers() {
    for area in [None, Some(1.0e-30)] {
        let mut world = turning_row(area);
        let mut broken = 0;
        for step in 0..3 {
            step_and_restore(&mut world, 1.0 / 60.0, step);
            for b in &world.events().bond_break {
                assert!(b.tension.is_finite() && b.shear.is_finite(), "{b:?}");
            }
            broken += world.events().bond_break.len();
        }
        assert_eq!(broken, 11);
    }
}
