//! Commands, and the pictures after them.

use drystone::{BodyKind, Quat, Vec3, vec3};
use drystone_scene::Running;
use drystone_scene::bake::{self, Motion};
use drystone_scene::gltf;

use super::opened::{MOST_LETTERS, MOST_NOTES, shown_notes};
use super::{Command, Deed, Opened, Simulation};
use crate::side::mix;

/// Opens scenes of the catalog.
pub(crate) fn open(name: &str) -> Result<Opened, String> {
    let scene = drystone_scene::named(name).map_err(|e| e.to_string())?;
    let running = scene.build().map_err(|e| e.to_string())?;
    Ok(opened(name, running))
}

fn opened(name: &str, running: Running) -> Opened {
    Opened { name: name.to_owned(), running, hz: 60.0, notes: Vec::new() }
}

pub(crate) fn simulation(scene: &str) -> Simulation {
    Simulation::new(open(scene).unwrap(), Box::new(open), false)
}

#[test]
fn a_body_that_is_held_follows_the_mouse_and_stays_there() {
    let mut s = simulation("stack:n=1");
    let top = |s: &Simulation| {
        let world = &s.history().now().world;
        world.bodies().filter(|b| b.kind() == BodyKind::Dynamic).map(|b| b.position()).last()
    };
    let at = top(&s).unwrap();
    s.obey(Command::Grab(at + vec3(0.0, 0.0, 10.0), -Vec3::Z, 0));
    assert!(s.grabs.1);
    s.obey(Command::Drag(at + vec3(2.0, 3.0, 10.0), -Vec3::Z));
    for _ in 0..240 {
        s.obey(Command::Step);
    }
    let held = s.shown().held.unwrap();
    assert!((held.0 - held.1).length() < 0.05, "{held:?}");
    s.obey(Command::Release);
    for _ in 0..240 {
        s.obey(Command::Step);
    }
    assert!((top(&s).unwrap().y - at.y).abs() < 0.1, "it fell back to the ground");
}

#[test]
fn what_cannot_be_held_is_not() {
    let mut s = simulation("stack:n=1");
    s.obey(Command::Grab(vec3(0.0, 50.0, 0.0), Vec3::Y, 0));
    assert_eq!(s.grabs, (1, false));
    s.obey(Command::Grab(vec3(30.0, 5.0, 0.0), -Vec3::Y, 0));
    assert_eq!(s.grabs, (2, false), "the ground is static");
    s.obey(Command::Drag(Vec3::splat(f32::NAN), Vec3::X));
    s.obey(Command::Shoot(Vec3::splat(f32::NAN), Vec3::X, true));
    s.obey(Command::Step);
    assert_eq!(s.shown().step, 1);
}

#[test]
fn time_can_be_turned_back() {
    let mut s = simulation("stack:n=2");
    for _ in 0..20 {
        s.obey(Command::Step);
    }
    s.obey(Command::Seek(19));
    let shown = s.shown();
    assert_eq!((shown.step, shown.furthest, shown.playing), (19, 20, false));
    s.obey(Command::Seek(u64::MAX));
    assert_eq!(s.shown().step, 620);
}

#[test]
fn two_sides_with_the_same_settings_are_the_same_and_with_others_differ() {
    let mut s = simulation("stack:n=3");
    s.obey(Command::Seek(10));
    s.obey(Command::Split(true));
    s.obey(Command::Shoot(vec3(0.0, 1.5, 8.0), -Vec3::Z, true));
    for _ in 0..30 {
        s.obey(Command::Step);
    }
    let hashes = |s: &mut Simulation| -> Vec<_> {
        s.shown().views.iter().map(|view| view.hash.unwrap()).collect()
    };
    let same = hashes(&mut s);
    assert_eq!((same.len(), same[0]), (2, same[1]));
    s.obey(Command::Seek(20));
    let mut config = s.shown().views[1].config.clone();
    config.method = drystone::method::Method::soft_step_relax();
    s.obey(Command::Config(1, Box::new(config)));
    s.obey(Command::Seek(40));
    let other = hashes(&mut s);
    assert_eq!(other[0], same[0], "the first side is as it was");
    assert_ne!(other[0], other[1]);
    s.obey(Command::Split(false));
    assert_eq!(s.shown().views.len(), 1);
}

#[test]
fn a_film_stops_at_its_end_and_begins_again() {
    let scene = drystone_scene::named("hello").unwrap();
    let mut running = scene.build().unwrap();
    let mut motion = Motion { poses: vec![Vec::new(); running.bodies.len()], ..Motion::default() };
    for step in 0..=30_u8 {
        motion.times.push(f32::from(step) / 60.0);
        for (number, id) in running.bodies.iter().enumerate() {
            motion.poses[number].push(running.world.body(*id).unwrap().pose());
        }
        running.step(1.0 / 60.0).unwrap();
    }
    let path = std::env::temp_dir().join(format!("drystone-film-{}.glb", std::process::id()));
    bake::write_scene(&path, &scene, &[], &motion).unwrap();
    let film = gltf::film(gltf::load(&path, &gltf::Options::default()).unwrap()).unwrap();
    std::fs::remove_file(path).unwrap();
    let opened = opened("film", film.build().unwrap());
    let mut s = Simulation::new(opened, Box::new(open), false);
    s.obey(Command::Seek(1000));
    let shown = s.shown();
    assert_eq!((shown.step, shown.film), (30, Some(30)));
    let low = |s: &Simulation| {
        let bodies = s.history().now().world.bodies();
        bodies.map(|b| b.position().y).fold(f32::MIN, f32::max)
    };
    let end = low(&s);
    s.obey(Command::Step);
    assert_eq!(s.shown().step, 0);
    assert!(low(&s) > end + 0.5, "the ball is up again");
}

#[test]
fn what_is_picked_can_be_deleted_doubled_and_frozen() {
    let mut s = simulation("stack:n=2");
    let bodies = |s: &Simulation| s.history().now().world.bodies().count();
    let before = bodies(&s);
    s.obey(Command::Act(Deed::Remove));
    assert_eq!(bodies(&s), before, "nothing is picked");
    let toward = |s: &mut Simulation| {
        s.obey(Command::Pick(vec3(0.0, 1.5, 10.0), -Vec3::Z, 0));
        s.shown().picked.map(|p| p.title)
    };
    assert!(toward(&mut s).is_some_and(|title| title.contains("cube 1")));
    s.obey(Command::Act(Deed::Duplicate));
    assert_eq!(bodies(&s), before + 1);
    s.obey(Command::Act(Deed::Freeze));
    let body = s.picked.unwrap();
    assert!(s.history().now().world.body(body).unwrap().locks().any());
    s.obey(Command::Act(Deed::Remove));
    assert_eq!((bodies(&s), s.shown().picked.is_none()), (before, true));
}

#[test]
fn what_cannot_be_opened_leaves_the_scene_and_says_why() {
    let mut s = simulation("stack:n=2");
    s.obey(Command::Step);
    s.obey(Command::Open("nonsense".to_owned()));
    let shown = s.shown();
    assert_eq!((shown.name.as_str(), shown.step, shown.scene), ("stack:n=2", 1, 0));
    assert!(shown.message.unwrap().contains("nonsense"));
    s.obey(Command::Open("hello".to_owned()));
    let shown = s.shown();
    assert_eq!((shown.name.as_str(), shown.step, shown.scene), ("hello", 0, 1));
    assert!(shown.message.is_none());
    s.open = Box::new(|_| panic!("a loader's defect"));
    s.obey(Command::Open("hello".to_owned()));
    assert!(s.shown().message.unwrap().contains("the loader failed"));
}

#[test]
fn notes_on_a_file_go_with_it_and_are_no_longer_than_a_window() {
    let mut s = simulation("hello");
    assert!(s.shown().notes.is_empty());
    s.open = Box::new(|name| {
        let mut opened = open("hello")?;
        opened.notes = vec!["é".repeat(10_000); name.len()];
        Ok(opened)
    });
    s.obey(Command::Open("ab".to_owned()));
    let notes = s.shown().notes;
    assert_eq!(notes.len(), 2);
    assert_eq!(notes[0].chars().count(), MOST_LETTERS + 2, "{}", notes[0]);
    s.open = Box::new(open);
    s.obey(Command::Open("nonsense".to_owned()));
    assert_eq!(s.shown().notes.len(), 2, "the scene stays, and what is known of it");
    s.obey(Command::Open("hello".to_owned()));
    assert!(s.shown().notes.is_empty());
    let many = shown_notes(vec!["no".to_owned(); 1_000_000]);
    assert_eq!(many.len(), MOST_NOTES + 1);
    assert!(many[MOST_NOTES].contains(&(1_000_000 - MOST_NOTES).to_string()));
}

#[test]
fn between_two_steps_bodies_are_between_their_places() {
    let mut s = simulation("hello");
    s.obey(Command::Speed(0.1));
    s.obey(Command::Seek(20));
    s.playing = true;
    s.step();
    let side = &s.sides[0];
    let world = &side.history.now().world;
    let ball = world.bodies().find(|b| b.kind() == BodyKind::Dynamic).unwrap();
    let slot = ball.id().index() as usize;
    let before = side.before[slot].unwrap().1;
    let half = side.poses(0.5)[slot];
    let middle = (before.position + ball.position()) * 0.5;
    assert!((half.position - middle).length() < 1.0e-6);
    assert!(before.position.y > half.position.y && half.position.y > ball.position().y);
    let turned = drystone::Pose::new(Vec3::ZERO, Quat::from_axis_angle(Vec3::Y, 1.0));
    let half = mix(&drystone::Pose::IDENTITY, &turned, 0.5);
    assert!((half.rotation.angle() - 0.5).abs() < 1.0e-6);
}
