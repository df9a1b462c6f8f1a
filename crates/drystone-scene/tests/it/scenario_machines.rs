//! A mattress, a vehicle, gears, a pulley and limp people: bodies on joints of six axes.

use std::sync::Arc;

use drystone::Vec3;
use drystone::threads::Team;
use drystone_scene::{Running, named};

fn start(spec: &str, threads: usize) -> Running {
    let mut running = named(spec).unwrap().build().unwrap();
    if threads > 1 {
        running.world.set_executor(Arc::new(Team::new(threads)));
    }
    running
}

fn position(running: &Running, name: &str) -> Vec3 {
    let number = running.names.iter().position(|n| n == name).unwrap();
    running.world.body(running.bodies[number]).unwrap().position()
}

#[test]
fn mattress_bends_carries_balls_and_comes_to_rest() {
    let mut running = start("mattress", 1);
    let energy = |running: &Running| {
        let e = running.world.audit().energy;
        e.linear + e.angular + e.potential + e.elastic
    };
    let (first, mut most) = (energy(&running), f64::MIN);
    // The mattress does not sleep while it swings on its springs, however slowly.
    for _ in 0..1200 {
        running.step(1.0 / 60.0).unwrap();
        most = most.max(energy(&running));
    }
    let audit = running.world.audit();
    let middle = position(&running, "block 5/3").y;
    println!("energy {first} most {most}, middle {middle}, {} J", audit.energy.kinetic());
    // Springs give back no more than they got. Velocities stand half a substep before positions,
    // which is g h/2 times the momentum of all that falls: 84 kg at 6 m/s.
    assert!(most < first + 84.0 * 6.0 * 9.81 / 960.0, "{first} {most}");
    assert!(audit.energy.kinetic() < 0.05, "{}", audit.energy.kinetic());
    // It lay at 0.9 m and sags between its beams, but not to the ground.
    assert!(middle > 0.6 && middle < 0.89, "{middle}");
    assert!(audit.non_finite.is_empty());
}

#[test]
fn gears_turn_by_their_radii_and_lift_the_rack() {
    let mut running = start("gears", 1);
    let mut worst = 0.0_f32;
    for _ in 0..300 {
        running.step(1.0 / 60.0).unwrap();
        for id in &running.couplings {
            let joint = running.world.joint(*id).unwrap();
            worst = worst.max(joint.error().max(joint.angular_error()));
        }
    }
    // The rim of the first wheel goes 2 rad/s of 0.2 m, and so do all others and the rack. The
    // motor's 200 N m have 4 N m of load, so it is at speed at once.
    let rise = position(&running, "rack").y - 2.0;
    assert!((rise / 2.0 - 1.0).abs() < 0.02, "{rise} m");
    // A motor holds a wheel far harder than its coupling does; that must not make the rack tremble.
    let rack = running.names.iter().position(|n| n == "rack").unwrap();
    let (mut least, mut most) = (f32::MAX, f32::MIN);
    for _ in 0..120 {
        running.step(1.0 / 60.0).unwrap();
        let speed = running.world.body(running.bodies[rack]).unwrap().linear_velocity().y;
        (least, most) = (least.min(speed), most.max(speed));
    }
    println!("rack {rise} m, {least} to {most} m/s, worst {worst} rad or m");
    assert!((least / 0.4 - 1.0).abs() < 0.02 && (most / 0.4 - 1.0).abs() < 0.02, "{least} {most}");
    // The load's 196 N are up to 79 N m at a wheel of 0.4 m. Couplings give way by load × inverse
    // masses ÷ (2πf)², here of at most 1/0.1 + (0.4/0.2)²/0.1 with f = 72 Hz.
    let give = 79.0 * 50.0 / (452.0_f32 * 452.0);
    assert!(worst < give, "{worst} {give}");
}

#[test]
fn a_weight_on_two_strands_lifts_a_heavier_load() {
    let mut running = start("pulley", 1);
    // a = g (4 m - 2 M)/(4 m + M) of the weight; it has 2.8 m to fall.
    let fall = 9.81 * (4.0 * 30.0 - 2.0 * 50.0) / (4.0 * 30.0 + 50.0);
    for _ in 0..60 {
        running.step(1.0 / 60.0).unwrap();
    }
    let (weight, load) = (position(&running, "weight").y, position(&running, "load").y);
    assert!(((3.0 - weight) / (0.5 * fall) - 1.0).abs() < 0.02, "{weight} m, {fall} m/s²");
    assert!((2.0 * (load - 0.2) - (3.0 - weight)).abs() < 2.0e-3, "{load} m, {weight} m");
}

#[test]
fn vehicle_reaches_the_speed_of_its_motors_and_gets_over_the_bumps() {
    let mut running = start("vehicle", 1);
    let mut worst = 0.0_f32;
    for _ in 0..180 {
        running.step(1.0 / 60.0).unwrap();
        worst = running.world.joints().map(|j| j.error()).fold(worst, f32::max);
    }
    let at = position(&running, "chassis");
    println!("{at:?} {worst}");
    // 1,000 N m on 1,080 kg and wheels of 0.35 m: 2.6 m/s² at most, until 8 m/s.
    let chassis = running.bodies[running.names.iter().position(|n| n == "chassis").unwrap()];
    let body = running.world.body(chassis).unwrap();
    let (v, up) = (body.linear_velocity(), body.rotation().rotate(Vec3::Y));
    assert!(v.x > 5.0 && v.x < 8.2, "{v:?}");
    assert!(up.y > 0.95, "{up:?}");
    assert!(at.z.abs() < 1.0 && worst < 0.03, "{at:?} {worst}");
}

#[test]
fn people_on_a_heap_stay_whole_and_lie_still_the_same_for_any_threads() {
    let run = |threads| {
        let mut running = start("ragdolls:n=16", threads);
        let mut worst = 0.0_f32;
        for _ in 0..300 {
            running.step(1.0 / 60.0).unwrap();
            worst = running.world.joints().map(|j| j.error()).fold(worst, f32::max);
        }
        let audit = running.world.audit();
        assert!(audit.non_finite.is_empty());
        println!("{worst} {:?} {}", audit.joints, audit.energy.kinetic());
        // They land at 6 m/s, a step's way of 0.1 m; a heap of 16 people of 65 kg.
        assert!(worst < 0.05, "{worst}");
        assert!(audit.joints.linear < 0.005 && audit.joints.angular < 0.1, "{:?}", audit.joints);
        assert!(audit.energy.kinetic() < 2.0, "{}", audit.energy.kinetic());
        running.world.state_hash()
    };
    assert_eq!(run(1), run(3));
}

#[test]
fn people_of_stone_land_as_stones_do() {
    // Drives of 1e6 N m/rad between links of 0.001 kg m²: a thousand times what a substep can
    // follow. The springs hold hundreds of kilojoules when people are made, of which nothing may
    // become motion.
    let mut running = start("ragdolls:n=6,muscles=100000", 1);
    let fall = running.world.potential_energy();
    let (mut most, mut worst) = (0.0_f64, 0.0_f32);
    for _ in 0..360 {
        running.step(1.0 / 60.0).unwrap();
        most = most.max(running.world.kinetic_energy());
        worst = running.world.joints().map(|j| j.error()).fold(worst, f32::max);
    }
    let left = running.world.kinetic_energy();
    println!("fall {fall} J, at most {most} J, joints {worst} m, left {left} J");
    // They have no more motion than their fall gives, and their joints open no farther than those
    // of people on a heap.
    assert!(most < fall, "{most} of {fall}");
    assert!(worst < 0.05, "{worst} m");
    assert!(left < 2.0, "{left} J");
}

#[test]
fn muscles_hold_people_in_their_pose_and_weak_ones_give_way() {
    // The mean turn of joints away from the pose, once a person lies on the ground.
    let bent = |muscles: u32| {
        let mut running = start(&format!("ragdolls:n=1,muscles={muscles}"), 1);
        let mut worst = 0.0_f32;
        for _ in 0..300 {
            running.step(1.0 / 60.0).unwrap();
            worst = running.world.joints().map(|j| j.error()).fold(worst, f32::max);
        }
        assert!(worst < 0.05, "{worst} m");
        let turns = running.world.joints().filter_map(|j| j.coordinates());
        let turns: Vec<f32> = turns.map(|[_, turn]| turn.length()).collect();
        turns.iter().sum::<f32>() / 22.0
    };
    // An arm of 4 kg held out at 0.3 m is 12 N m.
    let (limp, weak, strong) = (bent(0), bent(5), bent(300));
    println!("{limp} {weak} {strong}");
    // A joint bears no more than all 65 kg at a meter, 640 N m, where the spring has 3,000 N m/rad.
    assert!(strong < 640.0 / 3000.0, "{strong}");
    assert!(limp > 2.0 * strong && weak > strong && weak < limp, "{limp} {weak} {strong}");
}
