//! Structures that stand keep standing; bodies that fall come to rest.

use drystone::{BodyKind, Vec3};
use drystone_scene::{Running, named};

/// Where each dynamic body is, by number.
fn places(running: &Running) -> Vec<(usize, Vec3)> {
    let bodies = running.bodies.iter().enumerate();
    bodies
        .filter_map(|(i, id)| running.world.body(*id).map(|b| (i, b)))
        .filter(|(_, b)| b.kind() == BodyKind::Dynamic)
        .map(|(i, b)| (i, b.center_of_mass()))
        .collect()
}

fn run(running: &mut Running, hz: f32, steps: u32) {
    for _ in 0..steps {
        running.step(1.0 / hz).unwrap();
        assert!(running.world.events().faults.is_empty());
    }
}

/// How far the farthest moved body went down and aside [m], with its name.
fn farthest(running: &Running, from: &[(usize, Vec3)]) -> (f32, f32, String) {
    let mut worst = (0.0, 0.0, String::new());
    for ((i, from), (_, to)) in from.iter().zip(places(running)) {
        let moved = to - *from;
        let aside = (moved.x * moved.x + moved.z * moved.z).sqrt();
        if aside.max(moved.y.abs()) > f32::max(worst.0, worst.1) {
            worst.2.clone_from(&running.names[*i]);
        }
        worst = (worst.0.max(moved.y.abs()), worst.1.max(aside), worst.2);
    }
    worst
}

/// Runs for 20 s. No body may have moved up or down by more than `sag` [m] or aside by more than
/// `drift` [m], and hardly at all in the second half of that time.
fn stands(spec: &str, sag: f32, drift: f32) {
    let scene = named(spec).unwrap();
    let mut running = scene.build().unwrap();
    let start = places(&running);
    run(&mut running, scene.hz, 600);
    let half_way = places(&running);
    run(&mut running, scene.hz, 600);
    let (down, aside, who) = farthest(&running, &start);
    let creep = farthest(&running, &half_way);
    let overlap = deepest(&running);
    println!("{spec}: sag {down:.4}, drift {aside:.4}, overlap {overlap:.5}, creep {creep:?} m");
    assert!(down <= sag && aside <= drift, "{spec}: {who} moved {down} m down, {aside} m aside");
    assert!(creep.0.max(creep.1) <= CREEP, "{spec}: still moving after 10 s: {creep:?}");
}

/// The deepest overlap of all contacts [m].
fn deepest(running: &Running) -> f32 {
    let points = running
        .world
        .contacts()
        .flat_map(|c| c.points().map(|p| -p.separation).collect::<Vec<_>>());
    points.fold(0.0, f32::max)
}

/// The most that n levels may sink if each may overlap the one below by the engine's allowance of 5
/// mm at the most loaded place, half of it on average.
fn allowed_sag(levels: u16) -> f32 {
    0.0025 * f32::from(levels)
}

/// A body may settle aside by a hundredth of its size, about 1 m; more is not standing.
const DRIFT: f32 = 0.01;

/// A tenth of a millimeter a second is less than anyone sees [m in 10 s].
const CREEP: f32 = 0.001;

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

/// The most that the cards of a house may move aside [m]. A foot stands 3 cm from the end of the
/// flat card under it, and that card may move along by as much. A card that falls moves by its
/// height, 36 cm.
const CARD_DRIFT: f32 = 0.06;

// Each level leans on two thin edges a side: four contacts to sink in instead of one.

#[test]
fn card_house_of_three_levels_stands() {
    stands("card_house:levels=3", allowed_sag(4 * 3), CARD_DRIFT);
}

#[test]
fn card_house_stands() {
    stands("card_house:levels=5", allowed_sag(4 * 5), CARD_DRIFT);
    stands("card_house:levels=5,thickness=0.01", allowed_sag(4 * 5), CARD_DRIFT);
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
        let mut running = scene.build().unwrap();
        run(&mut running, scene.hz, 300);
        let top = *running.bodies.last().unwrap();
        let (from, to) =
            (scene.bodies.last().unwrap().def.position, running.world.body(top).unwrap());
        assert!(to.position().y < 0.5 * from.y, "{spec}: the top is at {:?}", to.position());
    }
}

#[test]
fn the_last_domino_falls() {
    let scene = named("domino:n=40").unwrap();
    let mut running = scene.build().unwrap();
    run(&mut running, scene.hz, 480);
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
    // A contact under N equal bodies gives by 2 g N / ω², 0.17 mm each at 54 Hz. For some twelve
    // layers, and five times as much where a body is wedged in, that is 10 mm.
    assert!(deepest(&running) < 0.010, "overlap {}", deepest(&running));
}

/// Kinetic energy and that in the gravity field [J], and how much of the latter the sweep may give
/// in a step. It takes bodies back along their way, by no more than that and a body's size, 1 m.
fn energy(running: &Running) -> (f64, f64) {
    let gravity = 9.81;
    let (mut sum, mut lifted) = (0.0, 0.0);
    for b in running.world.bodies().filter(|b| b.kind() == BodyKind::Dynamic) {
        let weight = f64::from(b.mass()) * gravity;
        sum += f64::from(b.kinetic_energy()) + weight * f64::from(b.center_of_mass().y);
        lifted += weight * (f64::from(b.linear_velocity().length()) / 60.0 + 1.0);
    }
    (sum, lifted)
}

#[test]
fn fast_bodies_stay_in_a_room_of_thin_walls_and_impacts_give_them_no_energy() {
    let scene = named("high_speed:n=1200").unwrap();
    let mut running = scene.build().unwrap();
    let (mut before, mut lifted) = energy(&running);
    for step in 0..300 {
        run(&mut running, 60.0, 1);
        for (i, at) in places(&running) {
            // The walls' inner sides are at 49.8 m, their middle at 50.
            assert!(at.abs().max_element() < 50.0, "{} at {at:?}, step {step}", running.names[i]);
        }
        // Against 1e10 J. The lift is a thousandth of it at the start, and less as bodies become
        // slower. Push-out lifts by less: its speed is far below that of a body that was deep.
        // Rounding is a ten millionth.
        let (now, next) = energy(&running);
        assert!(now < before * (1.0 + 1.0e-6) + lifted, "step {step}: {before} J to {now} J");
        (before, lifted) = (now, next);
    }
    println!("{before} J left");
}
