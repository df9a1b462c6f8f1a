//! Films: a baked motion is played as it was.
#![expect(clippy::unwrap_used, reason = "a test may fail anywhere")]

use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use drystone::{BodyDef, BodyKind, Pose, ShapeDef};
use drystone_scene::bake::{self, Motion};
use drystone_scene::gltf::{self, Options};
use drystone_scene::{Running, Scene, SceneBody, Script};

const DT: f32 = 1.0 / 60.0;

/// Bakes the first steps of a scene; returns the file and where bodies were at each time.
fn baked(scene: &Scene, steps: u16) -> (PathBuf, Motion) {
    let mut running = scene.build().unwrap();
    let all = match &scene.script {
        Script::Drop { bodies, .. } => scene.bodies.len() + bodies.len(),
        _ => scene.bodies.len(),
    };
    let mut motion = Motion { poses: vec![Vec::new(); all], ..Motion::default() };
    for step in 0..=steps {
        motion.times.push(f32::from(step) * DT);
        for (number, pose) in poses(&running).into_iter().enumerate() {
            motion.poses[number].push(pose);
        }
        running.step(DT).unwrap();
    }
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("film-{}.glb", scene.name));
    bake::write_scene(&path, scene, &[], &motion).unwrap();
    (path, motion)
}

fn poses(running: &Running) -> Vec<Pose> {
    running.bodies.iter().map(|id| running.world.body(*id).unwrap().pose()).collect()
}

/// Errors that baking allows of a motion [m] and [1], and as much again for numbers of 32 bits.
fn same(a: &Pose, b: &Pose) -> bool {
    let turned = a.rotation.to_mat3().transpose() * b.rotation.to_mat3();
    let off = [turned.x.y, turned.x.z, turned.y.z].map(f32::abs);
    (a.position - b.position).length() < 2.0e-4 && off.iter().all(|x| *x < 2.0 * 1.75e-4)
}

#[test]
fn a_baked_motion_is_played_as_it_was() {
    for scene in ["wall:ball=1", "wrecking_ball", "hello"] {
        let (path, motion) = baked(&drystone_scene::named(scene).unwrap(), 60);
        let loaded = gltf::load(&path, &Options::default()).unwrap();
        let says = |scene: &Scene| scene.notes.iter().any(|note| note.contains("animations"));
        assert!(says(&loaded.scene), "physics does not play them");
        let scene = gltf::film(loaded).unwrap();
        assert!(!says(&scene), "{:?}", scene.notes);
        assert!((scene.seconds - 1.0).abs() < 1.0e-6);
        assert!(scene.bodies.iter().all(|b| b.def.kind != BodyKind::Dynamic));
        let mut running = scene.build().unwrap();
        assert_eq!(running.film_seconds(), Some(scene.seconds));
        for step in 0..=60 {
            for (number, pose) in poses(&running).iter().enumerate() {
                let was = &motion.poses[number][step];
                assert!(
                    same(pose, was),
                    "{}, step {step}: {pose:?} {was:?}",
                    running.names[number]
                );
            }
            running.step(DT).unwrap();
        }
        assert_eq!(running.world.counts().contacts, 0);
    }
}

#[test]
fn bodies_that_come_later_join_the_film_later() {
    let mut rain = drystone_scene::named("hello").unwrap();
    let drop = |i: u8| {
        let def = BodyDef::dynamic().with_position([2.0, 1.0 + f32::from(i), 0.0]);
        let def = def.with_shape(ShapeDef::sphere(0.2));
        SceneBody { name: format!("drop {i}"), def }
    };
    rain.script = Script::Drop { every: 7, bodies: (0..20).map(drop).collect() };
    let (path, motion) = baked(&rain, 60);
    let scene = gltf::film(gltf::load(&path, &Options::default()).unwrap()).unwrap();
    let mut running = scene.build().unwrap();
    let first = running.bodies.len();
    for _ in 0..60 {
        running.step(DT).unwrap();
    }
    let last = poses(&running);
    let there = motion.poses.iter().filter(|p| !p.is_empty()).count();
    // Before steps 7, 14, … 56.
    assert_eq!((last.len(), there), (first + 8, first + 8));
    for (number, pose) in last.iter().enumerate() {
        let ends = motion.poses.iter().any(|p| p.last().is_some_and(|was| same(pose, was)));
        assert!(ends, "{} ends where no body was", running.names[number]);
    }
}

#[test]
fn pieces_of_a_body_come_when_it_goes() {
    let scene = drystone_scene::named("hello").unwrap();
    let (count, piece) = (scene.bodies.len(), BodyDef::dynamic().with_shape(ShapeDef::sphere(0.1)));
    let pieces = [SceneBody { name: "piece".to_owned(), def: piece }];
    let still = |n: usize| vec![Pose::at(drystone::vec3(0.0, 2.0, 0.0)); n];
    let times = (0..=10_u8).map(|step| f32::from(step) * DT).collect();
    let mut motion = Motion { times, poses: vec![still(11); count], gone: vec![0; count] };
    // The last body is there for the first six times, the piece for the other five.
    motion.poses[count - 1].truncate(6);
    motion.gone[count - 1] = 5;
    motion.poses.push(still(5));
    motion.gone.push(0);
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("film-pieces.glb");
    bake::write_scene(&path, &scene, &pieces, &motion).unwrap();
    let mut loaded = gltf::load(&path, &Options::default()).unwrap();
    loaded.read_visuals();
    assert!(loaded.scene.visuals.is_empty(), "in physics there is no piece");
    let film = gltf::film(loaded).unwrap();
    let mut running = film.build().unwrap();
    let there = |running: &Running| {
        let bodies = running.world.bodies();
        let pieces = bodies.filter(|b| !running.visuals.of(b.user_data()).is_empty()).count();
        (running.world.bodies().count() - pieces, pieces)
    };
    for step in 0..=10 {
        let expected = if step < 6 { (count, 0) } else { (count - 1, 1) };
        assert_eq!(there(&running), expected, "step {step}");
        running.step(DT).unwrap();
    }
}

#[test]
fn curves_steps_and_what_is_wrong_with_them() {
    let film = |interpolation: &str, output: &str| {
        // Times 0 and 1; then the points (0, 0, 0) and (8, 0, 0), and zeros.
        let mut numbers = [0.0_f32; 20];
        (numbers[1], numbers[5]) = (1.0, 8.0);
        let bytes: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
        let data = STANDARD.encode(&bytes);
        let text = format!(
            r#"{{"asset": {{"version": "2.0"}}, "nodes": [{{"extensions": {{"KHR_physics_rigid_bodies":
            {{"motion": {{}}, "collider": {{"geometry": {{"shape": 0}}}}}}}}}}],
            "extensionsUsed": ["KHR_physics_rigid_bodies", "KHR_implicit_shapes"],
            "extensions": {{"KHR_implicit_shapes": {{"shapes": [{{"type": "sphere", "sphere": {{"radius": 0.5}}}}]}}}},
            "buffers": [{{"byteLength": 80, "uri": "data:;base64,{data}"}}],
            "bufferViews": [{{"buffer": 0, "byteLength": 80}}],
            "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 2, "type": "SCALAR"}},
              {{"bufferView": 0, "byteOffset": 8, "componentType": 5126, "count": 2, "type": "VEC3"}},
              {{"bufferView": 0, "byteOffset": 8, "componentType": 5126, "count": 6, "type": "VEC3"}}],
            "animations": [{{"samplers": [{{"input": 0, "output": {output}, "interpolation": "{interpolation}"}}],
              "channels": [{{"sampler": 0, "target": {{"node": 0, "path": "translation"}}}}]}}]}}"#
        );
        let loaded = gltf::from_slice(text.as_bytes(), "a", Path::new(""), &Options::default());
        gltf::film(loaded.unwrap()).map_err(|e| e.to_string())
    };
    let height = |scene: &Scene, time: f32| match &scene.script {
        Script::Film(film) => film.pose(0, time).position.x,
        _ => panic!("no film"),
    };
    let linear = film("LINEAR", "1").unwrap();
    assert!((height(&linear, 0.25) - 2.0).abs() < 1.0e-6 && height(&linear, 9.0) > 7.99);
    let step = film("STEP", "1").unwrap();
    assert!(height(&step, 0.99).abs() < 1.0e-6 && height(&step, 1.0) > 7.99);
    // The first key is (8, 0, 0) between slopes of 0, the second one 0: halfway is the mean.
    let cubic = film("CUBICSPLINE", "2").unwrap();
    assert!(
        (height(&cubic, 0.0) - 8.0).abs() < 1.0e-6 && (height(&cubic, 0.5) - 4.0).abs() < 1.0e-5
    );
    assert!(film("LINEAR", "2").unwrap_err().contains("a value for each time"));
    assert!(film("SMOOTH", "1").unwrap_err().contains("SMOOTH"));
    let none = gltf::from_slice(
        br#"{"asset": {"version": "2.0"}, "nodes": [{"extensions": {"KHR_physics_rigid_bodies":
            {"collider": {"geometry": {"shape": 0}}}}}],
            "extensionsUsed": ["KHR_physics_rigid_bodies"],
            "extensions": {"KHR_implicit_shapes": {"shapes": [{"type": "sphere"}]}}}"#,
        "still.gltf",
        Path::new(""),
        &Options::default(),
    );
    assert!(gltf::film(none.unwrap()).unwrap_err().to_string().contains("still.gltf"));
}
