//! Steps of constant length under frames of any length, and the interpolated poses between them.

use drystone::{BodyDef, BodyId, Clock, Pose, Quat, ShapeDef, World, WorldConfig, vec3};

const STEP: f32 = 1.0 / 60.0;

fn flying() -> (World, BodyId) {
    let config = WorldConfig { gravity: vec3(0.0, 0.0, 0.0), ..WorldConfig::default() };
    let mut world = World::new(config).unwrap();
    let ball = BodyDef::dynamic().with_shape(ShapeDef::sphere(0.5));
    let ball = ball.with_linear_velocity([6.0, 0.0, 0.0]).with_angular_velocity([0.0, 0.0, 3.0]);
    let id = world.add_body(ball).unwrap();
    (world, id)
}

#[test]
fn what_is_drawn_moves_evenly_one_step_behind() {
    for frame in [1.0 / 30.0, 1.0 / 59.0, 1.0 / 60.0, 1.0 / 144.0_f32, 1.0 / 1000.0] {
        let (mut world, id) = flying();
        let mut clock = Clock::new(STEP).unwrap();
        let mut time = 0.0_f32;
        while time < 1.0 {
            clock.advance(&mut world, frame, |_| {});
            time += frame;
            let at = clock.pose(&world, id).unwrap();
            let drawn = 6.0 * (time - STEP).max(0.0);
            // Before the first step there is no interval to interpolate.
            if time > 2.0 * STEP {
                let off = (at.position.x - drawn).abs();
                // Rounding of sums over a thousand frames, at 6 m/s.
                assert!(off < 1.0e-3, "{frame}: {off} m off {drawn}");
                let turned = 3.0 * (time - STEP);
                let expected = Quat::from_axis_angle([0.0, 0.0, 1.0], turned);
                let off = (at.rotation * expected.conjugate()).angle();
                assert!(off < 1.0e-3, "{frame}: {off} rad off");
            }
        }
    }
}

#[test]
fn the_world_does_not_depend_on_the_frames() {
    let run = |frames: &[f32]| {
        let (mut world, _) = flying();
        let mut clock = Clock::new(STEP).unwrap();
        let mut steps = 0;
        for frame in frames.iter().cycle() {
            if steps >= 60 {
                break;
            }
            clock.advance(&mut world, *frame, |world| {
                if steps < 60 {
                    steps += 1;
                } else {
                    let _ = world;
                }
            });
        }
        (world, steps)
    };
    let mut hashes = Vec::new();
    for frames in [vec![STEP], vec![0.003], vec![0.001, 0.02, 0.004]] {
        let (mut world, _) = run(&frames);
        // A frame may take several steps: all worlds run to the same step.
        while world.body(world.bodies().next().unwrap().id()).unwrap().position().x < 9.0 {
            world.step(STEP);
        }
        hashes.push(world.state_hash());
    }
    assert!(hashes.iter().all(|hash| *hash == hashes[0]));
}

#[test]
fn late_frames_slow_motion_and_bad_times_are_taken() {
    let (mut world, _) = flying();
    let mut clock = Clock::new(STEP).unwrap();
    assert_eq!(clock.advance(&mut world, 1.0, |_| {}), 8, "no more than the most");
    assert!(clock.part() < 1.0);
    assert_eq!(clock.advance(&mut world, 0.0, |_| {}), 0, "what was too late is let go");
    clock.set_most_steps(0);
    assert_eq!(clock.advance(&mut world, 1.0, |_| {}), 1);
    clock.set_most_steps(100);
    clock.set_scale(0.25);
    let steps: u32 = (0..240).map(|_| clock.advance(&mut world, STEP, |_| {})).sum();
    assert!((59..=61).contains(&steps), "{steps}");
    for bad in [f32::NAN, f32::INFINITY, -1.0] {
        assert_eq!(clock.advance(&mut world, bad, |_| {}), 0);
        clock.set_scale(bad);
        assert_eq!(clock.advance(&mut world, 1.0, |_| {}), 0);
        clock.set_scale(1.0);
        assert!(Clock::new(bad).is_err());
    }
}

#[test]
fn a_teleport_is_drawn_where_it_ends() {
    let (mut world, id) = flying();
    let mut clock = Clock::new(STEP).unwrap();
    clock.advance(&mut world, 2.5 * STEP, |_| {});
    let there = Pose::at([50.0, 1.0, 0.0]);
    world.body_mut(id).unwrap().set_pose(there);
    assert_eq!(clock.pose(&world, id), Some(there));
    world.remove_body(id);
    assert_eq!(clock.pose(&world, id), None);
}
