//! What stands keeps standing, what falls comes to rest.

use drystone::{BodyKind, Vec3};
use drystone_scene::{Running, Scene, named};

/// Where each dynamic body is, by number.
fn places(running: &Running) -> Vec<(usize, Vec3)> {
    let bodies = running.bodies.iter().enumerate();
    bodies
        .filter_map(|(i, id)| running.world.body(*id).map(|b| (i, b)))
        .filter(|(_, b)| b.kind() == BodyKind::Dynamic)
        .map(|(i, b)| (i, b.position()))
        .collect()
}

fn run(scene: &Scene, seconds: f32) -> Running {
    let mut running = scene.build().unwrap();
    let mut time = 0.0;
    while time < seconds {
        running.step(1.0 / scene.hz).unwrap();
        assert!(running.world.events().faults.is_empty(), "{}", scene.name);
        time += 1.0 / scene.hz;
    }
    running
}

/// Runs for 20 s; no body may have sunk more than `sag` [m] or moved sideways more than `drift` [m].
fn stands(spec: &str, sag: f32, drift: f32) {
    let scene = named(spec).unwrap();
    let start = places(&scene.build().unwrap());
    let running = run(&scene, 20.0);
    let mut worst = (0.0_f32, 0.0_f32);
    for ((i, from), (_, to)) in start.iter().zip(places(&running)) {
        let moved = to - *from;
        let aside = (moved.x * moved.x + moved.z * moved.z).sqrt();
        worst = (worst.0.max(-moved.y), worst.1.max(aside));
        assert!(
            -moved.y <= sag && moved.y <= 0.01 && aside <= drift,
            "{spec}: {} moved by {moved:?}",
            running.names[*i]
        );
    }
    let overlap = deepest(&running);
    println!("{spec}: sag {:.4} m, drift {:.4} m, overlap {overlap:.5} m", worst.0, worst.1);
}

/// The deepest overlap of all contacts [m].
fn deepest(running: &Running) -> f32 {
    let points = running
        .world
        .contacts()
        .flat_map(|c| c.points().map(|p| -p.separation).collect::<Vec<_>>());
    points.fold(0.0, f32::max)
}

/// What n levels may sink if every one of them may overlap the one below by the engine's allowance
/// of 5 mm at the most loaded place, half of it on average.
fn allowed_sag(levels: u16) -> f32 {
    0.0025 * f32::from(levels)
}

/// A body may creep by a hundredth of its size in 20 s; more is not standing.
const DRIFT: f32 = 0.01;

#[test]
fn ten_boxes_stand_for_twenty_seconds() {
    stands("stack:n=10", allowed_sag(10), DRIFT);
}

#[test]
fn pyramid_of_base_20_stands() {
    stands("pyramid:base=20", allowed_sag(20), DRIFT);
}

#[test]
fn wall_stands() {
    stands("wall", allowed_sag(15), DRIFT);
}

#[test]
fn card_house_stands() {
    // Each level leans on two thin edges a side: four contacts to sink in instead of one.
    stands("card_house:levels=5", allowed_sag(4 * 5), DRIFT);
}

#[test]
fn tower_jenga_and_plank_tower_stand() {
    stands("tower", allowed_sag(20), DRIFT);
    stands("jenga", allowed_sag(18), DRIFT);
    stands("plank_tower", allowed_sag(12), DRIFT);
}

#[test]
fn arch_of_25_stones_stands() {
    // The stones press on each other around the ring; the crown sinks by all of their overlaps.
    stands("arch:stones=25", allowed_sag(25), 0.05);
}

#[test]
fn leaning_and_undermined_towers_fall() {
    for spec in ["falling_tower", "tower_minus_base"] {
        let scene = named(spec).unwrap();
        let running = run(&scene, 5.0);
        let top = *running.bodies.last().unwrap();
        let (from, to) =
            (scene.bodies.last().unwrap().def.position, running.world.body(top).unwrap());
        assert!(to.position().y < 0.5 * from.y, "{spec}: the top is at {:?}", to.position());
    }
}

#[test]
fn the_last_domino_falls() {
    let scene = named("domino:n=40").unwrap();
    let running = run(&scene, 8.0);
    for (i, at) in places(&running) {
        // Upright it is 0.24 m high; leaning on the next one it is below two thirds of that.
        assert!(at.y < 0.16, "{} is still at {at:?}", running.names[i]);
    }
}

#[test]
fn pile_of_500_comes_to_rest_and_sleeps_within_ten_seconds_of_the_last_impact() {
    let scene = named("pile:n=500").unwrap();
    let mut running = scene.build().unwrap();
    let (mut last_impact, mut step) = (0_u32, 0_u32);
    loop {
        running.step(1.0 / scene.hz).unwrap();
        step += 1;
        let events = running.world.events();
        assert!(events.faults.is_empty());
        // 1 m/s is a fall of 5 cm: what topples within the pile is slower.
        if events.hits.iter().any(|h| h.speed > 1.0) {
            last_impact = step;
        }
        let dynamic = || running.world.bodies().filter(|b| b.kind() == BodyKind::Dynamic);
        let awake = dynamic().filter(|b| !b.is_asleep()).count();
        if awake == 0 {
            break;
        }
        assert!(
            step <= last_impact + 600,
            "{awake} of 500 are awake 10 s after the last impact at step {last_impact}"
        );
    }
    println!("pile: last impact at step {last_impact}, asleep at step {step}");
    // Nothing left the tray.
    for (i, at) in places(&running) {
        assert!(at.y > 0.0 && at.x.abs() < 4.0 && at.z.abs() < 4.0, "{}: {at:?}", running.names[i]);
    }
    assert!(deepest(&running) < 0.005, "overlap {}", deepest(&running));
}
