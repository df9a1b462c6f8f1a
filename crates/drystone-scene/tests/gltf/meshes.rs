//! Files without physics: bodies are made of their meshes.

use std::fs;

use drystone::{BodyDef, BodyKind, Hull, Mesh, Shape, ShapeDef, Vec3, vec3};
use drystone_scene::Scene;
use drystone_scene::bake::{self, Motion};
use drystone_scene::gltf::{AutoColliders, Options};
use serde_json::Value;

use crate::documents::{next, read, scratch};
use crate::motion::{assert_poses, flight};

/// An L of two boxes as one mesh of a node without physics, and a floor.
fn decoration() -> Value {
    let mut scene = Scene::new("l", "");
    let quad = |v: &mut Vec<Vec3>, t: &mut Vec<[u32; 3]>, c: Vec3, h: Vec3| {
        let base = u32::try_from(v.len()).unwrap();
        let hull = Hull::from_points(
            &(0..8_u8)
                .map(|i| {
                    let s = |b: u8| if i >> b & 1 == 1 { 1.0 } else { -1.0 };
                    c + vec3(s(0), s(1), s(2)).mul_each(h)
                })
                .collect::<Vec<_>>(),
        )
        .unwrap();
        v.extend(hull.vertices());
        for f in 0..hull.planes().len() {
            let l: Vec<u32> = hull.face(f).iter().map(|&i| base + u32::from(i)).collect();
            for k in 1..l.len() - 1 {
                t.push([l[0], l[k], l[k + 1]]);
            }
        }
    };
    let (mut v, mut t) = (Vec::new(), Vec::new());
    quad(&mut v, &mut t, vec3(1.0, 0.25, 0.0), vec3(1.0, 0.25, 0.5));
    quad(&mut v, &mut t, vec3(0.25, 1.25, 0.0), vec3(0.25, 0.75, 0.5));
    let mesh = Shape::Mesh(std::sync::Arc::new(Mesh::new(v, t).unwrap()));
    scene.add(
        "floor",
        BodyDef::fixed()
            .with_position([0.0, -2.0, 0.0])
            .with_shape(ShapeDef::box_half([5.0, 0.5, 5.0])),
    );
    scene.add("l", BodyDef::fixed().with_shape(ShapeDef::new(mesh)));
    let path = scratch("decoration").join("l.gltf");
    let still = Motion { poses: vec![vec![]; 2], ..Motion::default() };
    bake::write_scene(&path, &scene, &[], &still).unwrap();
    let mut value: Value = serde_json::from_slice(&fs::read(path).unwrap()).unwrap();
    let object = value.as_object_mut().unwrap();
    object.remove("extensions");
    object.remove("extensionsUsed");
    for node in object["nodes"].as_array_mut().unwrap() {
        node.as_object_mut().unwrap().remove("extensions");
    }
    value
}

#[test]
fn files_without_physics_get_bodies_on_request() {
    let value = decoration();
    let e = read(&value, &Options::default()).unwrap_err();
    assert!(e.to_string().contains("--auto-colliders"), "{e}");
    for (how, kind) in
        [(AutoColliders::Hull, "hull"), (AutoColliders::Box, "box"), (AutoColliders::Mesh, "hull")]
    {
        let l = read(&value, &Options { auto_colliders: Some(how), ..Options::default() }).unwrap();
        assert_eq!(l.scene.bodies[0].def.kind, BodyKind::Static);
        let body = &l.scene.bodies[1];
        assert_eq!((body.def.kind, body.name.as_str()), (BodyKind::Dynamic, "l"));
        assert_eq!(body.def.shapes[0].shape.kind(), kind);
        if how == AutoColliders::Mesh {
            let parts = body.def.shapes.len();
            assert!((2..8).contains(&parts), "an L is a few convex parts, not {parts}");
            // No part may fill the notch.
            let notch = vec3(1.2, 1.2, 0.0);
            for part in &body.def.shapes {
                let Shape::Hull(h) = &part.shape else { panic!("a hull") };
                assert!(h.planes().iter().any(|p| p.distance(notch) > 0.2));
            }
        }
    }
}

#[test]
fn an_obj_file_gives_a_body_for_each_object() {
    let folder = scratch("obj");
    let mut text = String::new();
    let cube = |text: &mut String, name: &str, y: f32, h: f32| {
        text.push_str(&format!("o {name}\n"));
        for i in 0..8_u8 {
            let s = |b: u8| if i >> b & 1 == 1 { h } else { -h };
            text.push_str(&format!("v {} {} {}\n", s(0), y + s(1), s(2)));
        }
        for f in [
            "-8 -6 -5 -7",
            "-4 -3 -1 -2",
            "-8 -7 -3 -4",
            "-6 -2 -1 -5",
            "-8 -4 -2 -6",
            "-7 -5 -1 -3",
        ] {
            text.push_str(&format!("f {f}\n"));
        }
    };
    cube(&mut text, "floor", -5.0, 4.0);
    cube(&mut text, "crate", 2.0, 0.5);
    let path = folder.join("two.obj");
    fs::write(&path, text).unwrap();
    let options = |how| Options { auto_colliders: Some(how), ..Options::default() };
    let l = drystone_scene::obj::load(&path, &options(AutoColliders::Hull)).unwrap();
    let words: Vec<_> = l
        .scene
        .bodies
        .iter()
        .map(|b| (b.name.as_str(), b.def.kind, b.def.shapes[0].shape.kind()))
        .collect();
    assert_eq!(words, [("floor", BodyKind::Static, "mesh"), ("crate", BodyKind::Dynamic, "hull")]);
    let e = drystone_scene::obj::load(&path, &Options::default()).unwrap_err().to_string();
    assert!(e.contains("--auto-colliders") && !e.contains("KHR"), "{e}");
    let motion = flight(&l.scene, 20);
    let out = folder.join("two.glb");
    bake::write_objects(&out, &l, &motion).unwrap();
    assert_poses(&out, &l.object_of_body, &motion);
}

#[test]
fn triangle_soups_on_moving_bodies_never_panic() {
    let mut state = 3;
    let folder = scratch("soup");
    let path = folder.join("soup.obj");
    for round in 0..8 {
        let mut number =
            |wide: usize| f32::from(u8::try_from(next(&mut state) % wide).unwrap()) / 8.0;
        // Few different coordinates: plenty of flat, equal and zero-area triangles; sizes from mm
        // to km.
        let wide = [3, 9, 64][round % 3];
        let size = [1e-3, 1.0, 1e3, 1e6][round % 4];
        let mut text = String::new();
        for _ in 0..30 {
            let v = vec3(number(wide), number(wide), number(wide)) * size;
            text.push_str(&format!("v {} {} {}\n", v.x, v.y, v.z));
        }
        for _ in 0..4 + 5 * round {
            let mut corner = || 1 + next(&mut state) % 30;
            text.push_str(&format!("f {} {} {}\n", corner(), corner(), corner()));
        }
        fs::write(&path, text).unwrap();
        let options = Options { auto_colliders: Some(AutoColliders::Mesh), ..Options::default() };
        if let Ok(l) = drystone_scene::obj::load(&path, &options) {
            assert!(l.scene.bodies.iter().all(|b| b.def.validate().is_ok()));
        }
    }
}
