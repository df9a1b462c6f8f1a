//! Scenes whose course can be worked out by hand.

use drystone_scene::{Running, named};

fn run(spec: &str, seconds: f32) -> Running {
    let mut running = named(spec).unwrap().build().unwrap();
    let mut time = 0.0;
    while time < seconds {
        running.step(1.0 / 60.0).unwrap();
        time += 1.0 / 60.0;
    }
    running
}

/// Speed of the cube of `incline` after a second [m/s].
fn slope_speed(tan: f32, mu: f32) -> f32 {
    let running = run(&format!("incline:tan={tan},mu={mu}"), 1.0);
    running.world.body(running.bodies[1]).unwrap().linear_velocity().length()
}

#[test]
fn box_slips_exactly_when_slope_exceeds_friction() {
    for mu in [0.2, 0.5, 0.8] {
        assert!(slope_speed(0.98 * mu, mu) < 1.0e-3, "mu {mu}: holds");
        for k in [1.05, 1.5] {
            let tan = k * mu;
            let cos = 1.0 / (1.0_f32 + tan * tan).sqrt();
            let expected = 10.0 * cos * (tan - mu);
            let found = slope_speed(tan, mu);
            // A hundredth, and what one substep more or less of a second makes: 1/480.
            assert!(
                (found - expected).abs() < 0.0125 * expected + 2.0e-3,
                "{mu} {k}: {found} {expected}"
            );
        }
    }
}

#[test]
fn bouncy_cube_at_rest_on_a_slope_that_holds_it_stays_put() {
    let running = run("bouncy_cube_incline", 5.0);
    let cube = running.world.body(running.bodies[1]).unwrap();
    let start = named("bouncy_cube_incline").unwrap().bodies[1].def.position;
    assert!((cube.position() - start).length() < 5.0e-3, "{:?}", cube.position() - start);
}

#[test]
fn chain_holds_its_heavy_end() {
    let mut running = named("chain").unwrap().build().unwrap();
    let mut worst = 0.0_f32;
    for _ in 0..600 {
        running.step(1.0 / 60.0).unwrap();
        worst = running.world.joints().map(|j| j.error()).fold(worst, f32::max);
    }
    // 70 kg-links of a 10 m pendulum let go from the level: the string carries three weights.
    assert!(worst < 0.05, "worst joint error {worst} m");
}

#[test]
fn as_many_balls_leave_the_cradle_as_came_in() {
    for pulled in [1, 2] {
        let mut running = named(&format!("cradle:pulled={pulled}")).unwrap().build().unwrap();
        let rest: Vec<f32> = (1..=5).map(|i| 1.02 * (i as f32 - 3.0)).collect();
        let mut reach = [0.0_f32; 5];
        // A quarter of a pendulum's period of 5 m is 1.1 s: the far side is reached after 2.2 s.
        for _ in 0..150 {
            running.step(1.0 / 60.0).unwrap();
            for (i, farthest) in reach.iter_mut().enumerate() {
                let at = running.world.body(running.bodies[i + 1]).unwrap().position();
                *farthest = farthest.max(at.x - rest[i]);
            }
        }
        println!("cradle pulled={pulled}: reach {reach:?}");
        // Pulled back by 5 sin 30° = 2.5 m; nine tenths of that come out at the other end.
        for (i, farthest) in reach.iter().enumerate() {
            let leaves = i >= 5 - pulled;
            let gap = 0.02 * 5.0 + 0.1;
            assert!(
                if leaves { *farthest > 2.25 } else { *farthest < gap + 0.25 },
                "{pulled}: {reach:?}"
            );
        }
    }
}
