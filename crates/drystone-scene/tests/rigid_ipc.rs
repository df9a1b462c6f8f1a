//! Scenes of Rigid-IPC: what they are read into, how they move, what is refused and how.
#![expect(clippy::unwrap_used, reason = "a test may fail anywhere")]

use std::fs;
use std::path::{Path, PathBuf};

use drystone::{BodyKind, Shape, Vec3, vec3};
use drystone_scene::{Load, Running, Scene, SceneError, Script, rigid_ipc};

mod running;

use running::run;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/rigid-ipc")
}

fn load(name: &str) -> Scene {
    rigid_ipc::load(&folder().join("fixtures").join(name)).unwrap()
}

/// A problem with these members.
fn read(problem: &str) -> Result<Scene, SceneError> {
    let text = format!("{{\"rigid_body_problem\": {{{problem}}}}}");
    rigid_ipc::from_text(&text, "scene", &folder().join("fixtures"))
}

fn velocity(running: &Running, body: usize) -> Vec3 {
    running.world.body(running.bodies[body]).unwrap().linear_velocity()
}

#[test]
fn what_is_just_too_steep_slides_as_theory_says() {
    let scene = load("friction/slopeTest_highSchoolPhysics_mu=0.49.json");
    assert_eq!((scene.hz, scene.seconds), (40.0, 25.0));
    let mut speeds = Vec::new();
    run(&scene, 4.0, |r| speeds.push(velocity(r, 0).length()));
    // g (sin θ - µ cos θ) at 26.565°. It falls 5 mm at first, so two later moments are compared.
    let a = 9.8 * (0.447_212 - 0.49 * 0.894_428);
    let gained = speeds[159] - speeds[79];
    // A thousandth of the friction is 0.0043 m/s² of 0.0877.
    assert!((gained - 2.0 * a).abs() < 2.0 * 0.0043, "{gained} {a}");
}

#[test]
fn an_arch_of_25_stones_stands() {
    let scene = load("friction/arch-25-stones.json");
    assert_eq!(scene.bodies.len(), 26);
    assert!(scene.bodies[1..].iter().all(|b| b.def.kind == BodyKind::Dynamic));
    let places = |r: &Running| {
        let center = |id: &drystone::BodyId| r.world.body(*id).unwrap().center_of_mass();
        r.bodies.iter().map(center).collect::<Vec<Vec3>>()
    };
    // The file leaves gaps of some centimeters between the stones, 62 m high: in three seconds they
    // close.
    let mut all = Vec::new();
    run(&scene, 8.0, |r| all.push(places(r)));
    let (then, end) = (&all[299], &all[799]);
    assert!(end.iter().any(|p| p.y > 58.0));
    for (i, (from, to)) in then.iter().zip(end).enumerate() {
        // A thousandth of the height in five seconds.
        assert!((*to - *from).length() < 0.062, "stone {i}: {from:?} {to:?}");
    }
}

#[test]
fn links_of_a_chain_hold_each_other() {
    let scene = load("chain/3-links.json");
    let kinds: Vec<BodyKind> = scene.bodies.iter().map(|b| b.def.kind).collect();
    assert_eq!(kinds, [BodyKind::Static, BodyKind::Dynamic, BodyKind::Dynamic]);
    assert!(matches!(scene.bodies[0].def.shapes[0].shape, Shape::Mesh(_)));
    assert!(scene.bodies[1].def.shapes.len() > 4, "a ring that moves is several hulls");
    assert!(scene.notes.iter().any(|n| n.contains("decomposed")), "{:?}", scene.notes);
    // Rings of 1 m, so a link of a chain that is whole is never farther than that from the one
    // before.
    let apart = |r: &Running, i: usize| {
        let at = |i: usize| r.world.body(r.bodies[i]).unwrap().center_of_mass();
        (at(i) - at(i - 1)).length()
    };
    run(&scene, 5.0, |r| assert!(apart(r, 1) < 1.0 && apart(r, 2) < 1.0));
}

#[test]
fn sheets_forces_and_groups_are_read() {
    let scene = load("unit-tests/single-cube.json");
    let plate = &scene.bodies[0].def;
    assert_eq!(plate.locks.linear, [false, true, true]);
    assert_eq!(plate.locks.angular, [true; 3]);
    // 10 m by 10 m, a hundredth of that thick.
    assert!(matches!(plate.shapes[0].shape, Shape::Hull(_) | Shape::Box { .. }));
    let Script::Loads { from: 0, loads } = &scene.script else {
        unreachable!("{:?}", scene.script)
    };
    let force = vec3(-1.0e6, 0.0, 0.0);
    assert_eq!(loads.len(), 4);
    assert_eq!(loads[1], Load { body: 1, force, torque: Vec3::ZERO });
    let filter = |i: usize| scene.bodies[i].def.shapes[0].filter;
    assert!(!filter(0).collides_with(filter(1)) && filter(0).collides_with(filter(4)));
    // The four plates press the cube; none leaves its line.
    let end = run(&scene, 1.0, |_| {});
    let at = |i: usize| end.world.body(end.bodies[i]).unwrap().position();
    assert!(at(0).x < -0.4 && at(1).x > 0.4, "{:?} {:?}", at(0), at(1));
    assert!(at(0).y.abs() < 1.0e-6 && at(2).x.abs() < 1.0e-6);
}

#[test]
fn rotations_go_about_x_then_y_then_z_and_velocities_are_in_degrees() {
    let scene = read(
        r#""coefficient_restitution": -1, "rigid_bodies": [{"mesh": "cube.obj", "rotation": [90, 90, 0],
           "angular_velocity": [0, 180, 0], "scale": [1, 2, 3], "density": 500}]"#,
    )
    .unwrap();
    let def = &scene.bodies[0].def;
    assert_eq!(scene.bodies[0].name, "#0");
    // y goes to z by the turn about x, and on to x by the one about y.
    assert!((def.rotation.rotate(Vec3::Y) - Vec3::X).length() < 1.0e-6);
    assert!((def.angular_velocity.y - core::f32::consts::PI).abs() < 1.0e-6);
    let world = scene.build().unwrap();
    let mass = world.world.body(world.bodies[0]).unwrap().mass();
    assert!((mass - 3000.0).abs() < 0.01, "{mass}");
    let sized =
        read(r#""rigid_bodies": [{"mesh": "cube.obj", "dimensions": [2, 2, 0.5]}]"#).unwrap();
    let world = sized.build().unwrap();
    assert!((world.world.body(world.bodies[0]).unwrap().mass() - 2000.0).abs() < 0.01);
}

#[test]
fn mistakes_are_told_with_their_place() {
    let body = |inside: &str| format!("\"rigid_bodies\": [{{\"mesh\": \"cube.obj\", {inside}}}]");
    for (problem, part) in [
        (String::new(), "\"rigid_bodies\" is missing"),
        ("\"rigid_bodies\": [{}]".to_owned(), "rigid_bodies[0]: it has no shape"),
        ("\"rigid_bodies\": [{\"mesh\": \"lost.obj\"}]".to_owned(), "no file \"lost.obj\""),
        ("\"rigid_bodies\": [{\"mesh\": \"../../../x.obj\"}]".to_owned(), "no file"),
        (body("\"position\": [0, 1]"), "rigid_bodies[0].position: is a list of 2"),
        (body("\"density\": -1"), "density: is -1"),
        (body("\"is_dof_fixed\": [true]"), "true, false, or a list of 6"),
        (body("\"type\": \"soft\""), "\"static\", \"kinematic\" or \"dynamic\""),
        (body("\"scale\": \"big\""), "a number or a list of 3"),
        ("\"coefficient_restitution\": 2, \"rigid_bodies\": []".to_owned(), "up to 1, or -1"),
        ("\"gravity\": [0, 1e99, 0], \"rigid_bodies\": []".to_owned(), "a finite number"),
    ] {
        let e = read(&problem).unwrap_err().to_string();
        assert!(e.contains(part) && !e.contains('\n'), "{problem}: {e}");
    }
    let e = rigid_ipc::from_text("{", "x", Path::new("")).unwrap_err().to_string();
    assert!(e.contains("line 1"), "{e}");
    let e = rigid_ipc::from_text("[]", "x", Path::new("")).unwrap_err().to_string();
    assert!(e.contains("an object"), "{e}");
}

#[test]
fn damaged_files_never_panic() {
    let names = ["friction/turntable-mu=0.5.json", "unit-tests/vertex-vertex.json"];
    let texts = names.map(|name| fs::read_to_string(folder().join("fixtures").join(name)).unwrap());
    let odd = ["", "-1", "1e30", "null", "[]", "{}", "\"x\"", "true", "[1, 2]", "1e-30", "0"];
    let (mut good, mut bad) = (0, 0);
    for text in &texts {
        // Every number and word, one after the other, is replaced by something else.
        let is_value = |c: char| c.is_ascii_alphanumeric() || "-.+".contains(c);
        let mut at = 0;
        while let Some(begin) = text[at..].find(is_value).map(|i| i + at) {
            let end = text[begin..].find(|c| !is_value(c)).map_or(text.len(), |i| i + begin);
            at = end;
            for word in odd {
                let damaged = format!("{}{word}{}", &text[..begin], &text[end..]);
                match rigid_ipc::from_text(&damaged, "x", &folder().join("fixtures/friction")) {
                    Ok(scene) => {
                        good += 1;
                        // A force that no body bears is refused when it is to act.
                        if let Ok(mut running) = scene.build()
                            && let Err(e) = running.step(1.0 / 60.0)
                        {
                            assert!(!e.to_string().contains('\n'), "{e}");
                        }
                    }
                    Err(e) => {
                        bad += 1;
                        assert!(!e.to_string().contains('\n'), "{e}");
                    }
                }
            }
        }
    }
    assert!(good > 100 && bad > 100, "{good} {bad}");
}
