//! Scenes whose course can be worked out by hand.

use drystone_scene::{Running, named};

fn run(spec: &str, steps: u32) -> Running {
    let mut running = named(spec).unwrap().build().unwrap();
    for _ in 0..steps {
        running.step(1.0 / 60.0).unwrap();
    }
    running
}

/// Speed of the cube of `incline` after one and after three seconds [m/s].
fn slope_speeds(tan: f32, mu: f32) -> (f32, f32) {
    let mut running = run(&format!("incline:tan={tan},mu={mu}"), 60);
    let speed = |r: &Running| r.world.body(r.bodies[1]).unwrap().linear_velocity().length();
    let first = speed(&running);
    for _ in 0..120 {
        running.step(1.0 / 60.0).unwrap();
    }
    (first, speed(&running))
}

#[test]
fn box_slips_exactly_when_slope_exceeds_friction() {
    for mu in [0.2, 0.5, 0.8] {
        let (early, late) = slope_speeds(0.98 * mu, mu);
        assert!(early < 1.0e-3 && late < 1.0e-3, "mu {mu}: it holds, but {early} {late} m/s");
        for k in [1.02, 1.05, 1.5] {
            let tan = k * mu;
            let cos = 1.0 / (1.0_f32 + tan * tan).sqrt();
            let expected = 10.0 * cos * (tan - mu);
            let (early, late) = slope_speeds(tan, mu);
            let found = 0.5 * (late - early);
            println!("mu {mu} k {k}: {found} {expected} {early}");
            // Rounding of the angle and of 120 steps of speed; a thousandth, like the best peer.
            assert!(
                (found - expected).abs() < 1.0e-3 * expected + 1.0e-4,
                "{mu} {k}: {found} {expected}"
            );
            // Until the contact carries the weight friction is missing: one step of free fall at
            // most.
            assert!((early - expected).abs() < 10.0 / 60.0, "{mu} {k}: {early}");
        }
    }
}

#[test]
fn bouncy_cube_at_rest_on_a_slope_that_holds_it_stays_put() {
    let running = run("bouncy_cube_incline", 300);
    let cube = running.world.body(running.bodies[1]).unwrap();
    let start = named("bouncy_cube_incline").unwrap().bodies[1].def.position;
    assert!((cube.position() - start).length() < 5.0e-3, "{:?}", cube.position() - start);
}

#[test]
fn chain_holds_its_heavy_end() {
    for ratio in [1, 10, 50] {
        let mut running = run(&format!("chain:mass_ratio={ratio}"), 0);
        let mut worst = 0.0_f32;
        for _ in 0..600 {
            running.step(1.0 / 60.0).unwrap();
            worst = running.world.joints().map(|j| j.error()).fold(worst, f32::max);
        }
        println!("chain, ball of {ratio} links: worst joint error {worst} m");
        // Half the radius of a link: no gap can be seen between two of them.
        assert!(worst < 0.03, "ball of {ratio} links: worst joint error {worst} m");
    }
}

/// `pulled` balls come in; as many must leave, and the others stay. The speeds come out right where
/// a ball needs longer than a step from one neighbor to the next.
fn cradle_passes_on(pulled: usize, hz: f32) {
    let mut running = run(&format!("cradle:pulled={pulled}"), 0);
    let rest: Vec<f32> = running.world.joints().map(|j| j.anchor_a().x).collect();
    let mut reach = [0.0_f32; 5];
    // A quarter of the period of a pendulum of 5 m is 1.1 s: the far side is reached after 2.3 s.
    let mut time = 0.0;
    while time < 2.5 {
        running.step(1.0 / hz).unwrap();
        time += 1.0 / hz;
        for (i, farthest) in reach.iter_mut().enumerate() {
            let at = running.world.body(running.bodies[i + 1]).unwrap().position();
            *farthest = farthest.max(at.x - rest[i]);
        }
    }
    println!("cradle of 5, {pulled} pulled, {hz} Hz: reach {reach:?} m");
    for (i, farthest) in reach.iter().enumerate() {
        // Pulled back by 5 sin 30° = 2.5 m: a ball that leaves comes out again to a fiftieth. A
        // ball that stays is moved by the gaps, 0.02 m each.
        let leaves = i >= 5 - pulled;
        let right = if leaves { *farthest > 2.45 } else { *farthest < 0.1 };
        assert!(right, "{pulled} pulled, {hz} Hz: {reach:?}");
    }
}

#[test]
fn as_many_balls_leave_the_cradle_as_came_in() {
    cradle_passes_on(1, 120.0);
    cradle_passes_on(2, 120.0);
}

#[test]
fn as_many_balls_leave_the_cradle_at_sixty_steps_a_second() {
    cradle_passes_on(1, 60.0);
    cradle_passes_on(2, 60.0);
    cradle_passes_on(3, 60.0);
}
