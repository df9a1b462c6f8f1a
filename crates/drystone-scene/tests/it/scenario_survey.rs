//! The examples of the surveys do what one can work out.

use drystone::Vec3;
use drystone_scene::{Running, named};

/// The scene after its own length; with the last of its bodies.
fn ran(spec: &str) -> (Running, usize) {
    let scene = named(spec).unwrap();
    let mut running = scene.build().unwrap();
    let mut time = 0.0;
    while time < scene.seconds {
        running.step(1.0 / scene.hz).unwrap();
        time += 1.0 / scene.hz;
    }
    let last = running.bodies.len() - 1;
    (running, last)
}

fn place(running: &Running, body: usize) -> Vec3 {
    running.world.body(running.bodies[body]).unwrap().position()
}

#[test]
fn a_book_falls_exactly_if_more_than_half_of_it_is_over_the_edge() {
    for (overhang, falls) in [(0.3, false), (0.48, false), (0.52, true), (0.7, true)] {
        let (running, book) = ran(&format!("book:overhang={overhang}"));
        let y = place(&running, book).y;
        assert_eq!(y < 0.5, falls, "{overhang}: {y} m");
    }
}

#[test]
fn a_box_on_a_tilted_table_slides_beyond_friction_and_tips_beyond_its_width_over_height() {
    for (spec, slides, tips) in [
        ("tan=0.5,mu=0.52,height=1", false, false),
        ("tan=0.5,mu=0.48,height=1", true, false),
        // Width over height is 0.5 at a height of 2 m.
        ("tan=0.5,mu=0.9,height=1.9", false, false),
        ("tan=0.5,mu=0.9,height=2.1", true, true),
    ] {
        let spec = format!("tilted_table:{spec}");
        let start = named(&spec).unwrap().build().unwrap();
        let (running, body) = ran(&spec);
        let moved = (place(&running, body) - place(&start, body)).length();
        let up = |running: &Running| {
            running.world.body(running.bodies[body]).unwrap().rotation().rotate(Vec3::Y)
        };
        let turned = up(&running).dot(up(&start)) < 0.9;
        // 0.02 of a difference in friction is a way of 0.8 m in 3 s.
        assert_eq!((moved > 0.05, turned), (slides, tips), "{spec}: {moved} m");
    }
}

#[test]
fn a_sliding_ball_rolls_with_five_sevenths_of_its_speed() {
    let (running, ball) = ran("ball_roll");
    let body = running.world.body(running.bodies[ball]).unwrap();
    let v = body.linear_velocity().x;
    // The step in which it begins to roll is a part of h of the slide: mu g dt = 0.05 m/s at most.
    assert!((v - 5.0).abs() < 0.05, "{v}");
    assert!((v + 0.5 * body.angular_velocity().z).abs() < 1.0e-3, "it slides");
}

#[test]
fn a_super_ball_with_backspin_comes_back() {
    let scene = named("super_ball").unwrap();
    let mut running = scene.build().unwrap();
    let mut sides = Vec::new();
    for _ in 0..180 {
        running.step(1.0 / scene.hz).unwrap();
        let v = running.world.body(running.bodies[1]).unwrap().linear_velocity().x;
        if sides.last() != Some(&(v > 0.0)) {
            sides.push(v > 0.0);
        }
    }
    assert!(sides.len() >= 2, "{sides:?}");
}
