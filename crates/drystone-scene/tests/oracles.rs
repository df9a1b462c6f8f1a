//! Each sample file is simulated and must do what its `asset.extras.expect` says.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test may fail anywhere")]

use std::fs;
use std::path::Path;

use drystone::{BodyId, Quat, Vec3, World};
use drystone_scene::gltf::{self, LoadedGltf, Options};
use serde_json::{Value, json};

const HZ: f32 = 60.0;

struct Run {
    world: World,
    ids: Vec<BodyId>,
    loaded: LoadedGltf,
    /// Poses of every body at every step, the start included.
    path: Vec<Vec<(Vec3, Quat)>>,
    events: Vec<&'static str>,
    /// The greatest gap of a joint so far [m].
    gap: f32,
    /// Energy of the whole world at every step [J].
    energy: Vec<f64>,
}

impl Run {
    fn of(loaded: LoadedGltf) -> Self {
        let drystone_scene::Running { world, bodies: ids, .. } = loaded.scene.build().unwrap();
        let (path, events) = (Vec::new(), Vec::new());
        let mut run = Self { world, ids, loaded, path, events, gap: 0.0, energy: Vec::new() };
        run.note();
        run
    }

    fn note(&mut self) {
        let pose = |id: &BodyId| {
            let body = self.world.body(*id).unwrap();
            (body.position(), body.rotation())
        };
        self.path.push(self.ids.iter().map(pose).collect());
        self.gap = self.world.joints().fold(self.gap, |gap, joint| gap.max(joint.error()));
        let e = self.world.audit().energy;
        self.energy.push(e.linear + e.angular + e.potential);
        self.events.extend(self.world.events().sensor_enter.iter().map(|_| "enter"));
        self.events.extend(self.world.events().sensor_exit.iter().map(|_| "exit"));
    }

    fn seconds(&mut self, seconds: f32) {
        let steps = (seconds * HZ).round();
        let mut step = 0.0;
        while step < steps {
            self.world.step(1.0 / HZ);
            self.note();
            step += 1.0;
        }
    }

    fn body(&self, name: &str) -> usize {
        self.loaded.scene.bodies.iter().position(|b| b.name == name).unwrap()
    }

    /// The value that the oracle files call `name`, of a body.
    fn quantity(&self, b: usize, name: &str) -> f32 {
        let body = self.world.body(self.ids[b]).unwrap();
        let (p, v, w) = (body.position(), body.linear_velocity(), body.angular_velocity());
        let (start, turn) = self.path[0][b];
        let turned = (body.rotation() * turn.conjugate()).angle().to_degrees();
        match name {
            "x" => p.x,
            "y" => p.y,
            "z" => p.z,
            "vx" => v.x,
            "wz" => w.z,
            "abs_wx" => w.x.abs(),
            "travel" => (p - start).length(),
            "speed" => v.length(),
            "angle_deg" => body.rotation().angle().to_degrees(),
            "angle_change_deg" => turned,
            other => panic!("the test does not know {other}"),
        }
    }
}

/// The first highest point after the first lowest one.
fn first_apex(heights: impl Iterator<Item = f32>) -> f32 {
    let mut low = f32::MAX;
    let mut high = f32::MIN;
    for y in heights {
        if high > f32::MIN {
            if y < high {
                return high;
            }
            high = y;
        } else if y > low + 1e-4 {
            high = y;
        }
        low = low.min(y);
    }
    if high > f32::MIN { high } else { low }
}

#[expect(clippy::cast_possible_truncation, reason = "numbers of a test file")]
fn number(v: &Value) -> f32 {
    v.as_f64().unwrap() as f32
}

fn check(name: &str, failures: &mut Vec<String>) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/gltf-khr-own").join(name);
    let json: Value = serde_json::from_slice(&fs::read(&path).unwrap()).unwrap();
    let expect = json["asset"]["extras"]["expect"].as_object().unwrap();
    let mut run = Run::of(gltf::load(&path, &Options::default()).unwrap());
    let seconds = expect.get("after_s").or(expect.get("over_s"));
    run.seconds(seconds.map_or(3.0, number));
    let mut range = |what: &str, is: f32, low: f32, high: f32| {
        let line = format!("{name}: {what} is {is}, expected {low} to {high}");
        if !(low..=high).contains(&is) {
            failures.push(line);
        }
    };
    for (key, value) in expect {
        match key.as_str() {
            "after_s" | "over_s" | "note" | "exact_count" => {}
            "anchor_gap_max" => range("gap", run.gap, 0.0, number(value)),
            "energy_rel_max" => {
                // Against its energy above its lowest place, 1 m under the anchor, when let go at
                // rest.
                let whole = f64::from(run.world.body(run.ids[1]).unwrap().mass() * 9.81);
                let change = |e: &f64| ((e - run.energy[0]) / whole).abs();
                let most = run.energy.iter().map(change).fold(0.0, f64::max);
                #[expect(clippy::cast_possible_truncation, reason = "a part of 1")]
                range("energy", most as f32, 0.0, number(value));
            }
            "off_axis_deg_max" => {
                // The sine: less than the angle, by a part in 80,000 at half a degree.
                let off = |(_, q): &(Vec3, Quat)| q.rotate(Vec3::Z).cross(Vec3::Z).length();
                let most = run.path.iter().map(|f| off(&f[1]).to_degrees()).fold(0.0, f32::max);
                range("angle off the axis", most, 0.0, number(value));
            }
            "events" => {
                let wanted: Vec<&str> =
                    value.as_array().unwrap().iter().map(|e| e.as_str().unwrap()).collect();
                let right = f32::from(u8::from(run.events == wanted));
                range(
                    &format!("events are {:?}, that they are right", run.events),
                    right,
                    1.0,
                    1.0,
                );
            }
            "first_apex_centre_y" => {
                for (body, limits) in value.as_object().unwrap() {
                    let b = run.body(body);
                    let apex = first_apex(run.path.iter().map(|f| f[b].0.y));
                    let low = number(&limits[0]);
                    range(&format!("{body} apex"), apex, low, number(&limits[1]));
                }
            }
            body => {
                let b = run.body(body);
                for (quantity, limits) in value.as_object().unwrap() {
                    if quantity == "note" {
                        continue;
                    }
                    let what = format!("{body}.{quantity}");
                    match quantity.as_str() {
                        "position_tol" | "angle_tol_deg" => continue,
                        "position" => {
                            let wanted = [0, 1, 2].map(|i| number(&limits[i]));
                            let off = (run.path.last().unwrap()[b].0 - Vec3::from(wanted)).length();
                            range(&what, off, 0.0, number(&value["position_tol"]));
                            let turned = run.quantity(b, "angle_deg");
                            range("angle", turned, 0.0, number(&value["angle_tol_deg"]));
                            continue;
                        }
                        "x_tol" => {
                            range(&what, run.quantity(b, "x").abs(), 0.0, number(limits));
                            continue;
                        }
                        _ => {}
                    }
                    match quantity.strip_suffix("_max") {
                        Some(q) => range(&what, run.quantity(b, q), f32::MIN, number(limits)),
                        None => range(
                            &what,
                            run.quantity(b, quantity),
                            number(&limits[0]),
                            number(&limits[1]),
                        ),
                    }
                }
            }
        }
    }
    if name.starts_with("trigger") {
        // y = 3 - g t² / 2: the trigger changes nothing.
        let b = run.body("body");
        range("fall", run.quantity(b, "y"), 3.0 - 4.905 * 9.0 - 0.01, 3.0 - 4.905 * 9.0 + 0.01);
    }
}

#[test]
fn samples_do_what_they_say() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/gltf-khr-own");
    let mut names: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().file_name().to_str().unwrap().to_owned())
        .filter(|n| n.ends_with(".gltf"))
        .collect();
    names.sort();
    assert_eq!(names.len(), 21);
    let mut failures = Vec::new();
    for name in &names {
        check(name, &mut failures);
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// Vertices and triangles of a box as the buffer of a document.
fn box_mesh(half: [f32; 3]) -> Value {
    use base64::Engine as _;
    let mut bytes = Vec::new();
    for i in 0..8_u8 {
        for (bit, h) in half.iter().enumerate() {
            let sign = if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
            bytes.extend((sign * h).to_le_bytes());
        }
    }
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    for [a, b, c, d] in quads {
        for i in [a, b, c, a, c, d] {
            bytes.extend(u16::to_le_bytes(i));
        }
    }
    let data = base64::engine::general_purpose::STANDARD.encode(&bytes);
    json!({"byteLength": bytes.len(), "uri": format!("data:application/octet-stream;base64,{data}")})
}

#[test]
fn each_kind_of_body_rests_on_each_kind_of_ground() {
    let shapes = json!([
        {"type": "sphere", "sphere": {"radius": 0.5}},
        {"type": "box", "box": {"size": [1, 1, 1]}},
        {"type": "capsule", "capsule": {"height": 1, "radiusTop": 0.5, "radiusBottom": 0.5}},
        {"type": "cylinder", "cylinder": {"height": 1, "radiusTop": 0.5, "radiusBottom": 0.5}},
        {"type": "box", "box": {"size": [10, 1, 10]}},
        {"type": "plane", "plane": {}},
        {"type": "cylinder", "cylinder": {"height": 1, "radiusTop": 5, "radiusBottom": 5}},
        {"type": "sphere", "sphere": {"radius": 200}},
        {"type": "capsule", "capsule": {"height": 50, "radiusTop": 100, "radiusBottom": 100}},
    ]);
    let h = core::f32::consts::FRAC_1_SQRT_2;
    let lying = json!([0, 0, h, h]);
    let upright = json!([0, 0, 0, 1]);
    let shape = |i: usize| json!({"shape": i});
    let movers = [
        ("sphere", shape(0), &upright),
        ("box", shape(1), &upright),
        ("capsule", shape(2), &lying),
        ("cylinder", shape(3), &upright),
        ("hull", json!({"mesh": 0, "convexHull": true}), &upright),
        ("mesh", json!({"mesh": 0}), &upright),
    ];
    let grounds = [
        ("box", shape(4), &upright, -0.5),
        ("plane", shape(5), &upright, 0.0),
        ("cylinder", shape(6), &upright, -0.5),
        ("hull", json!({"mesh": 1, "convexHull": true}), &upright, -0.5),
        ("mesh", json!({"mesh": 1}), &upright, -0.5),
        ("sphere", shape(7), &upright, -200.0),
        ("capsule", shape(8), &lying, -100.0),
    ];
    let view = |buffer: usize| {
        [
            json!({"buffer": buffer, "byteOffset": 0, "byteLength": 96}),
            json!({"buffer": buffer, "byteOffset": 96, "byteLength": 72}),
        ]
    };
    let accessors = |view: usize| {
        [
            json!({"bufferView": view, "componentType": 5126, "count": 8, "type": "VEC3"}),
            json!({"bufferView": view + 1, "componentType": 5123, "count": 36, "type": "SCALAR"}),
        ]
    };
    let mesh =
        |i: usize| json!({"primitives": [{"attributes": {"POSITION": i}, "indices": i + 1}]});
    let views = [view(0), view(1)].concat();
    let all = [accessors(0), accessors(2)].concat();
    let mut failures = Vec::new();
    for (ground, geometry, turn, y) in &grounds {
        for (mover, moving, tilt) in &movers {
            let value = json!({
                "asset": {"version": "2.0"},
                "extensions": {"KHR_implicit_shapes": {"shapes": shapes}},
                "buffers": [box_mesh([0.5; 3]), box_mesh([5.0, 0.5, 5.0])],
                "bufferViews": views,
                "accessors": all,
                "meshes": [mesh(0), mesh(2)],
                "nodes": [
                    {"translation": [0, y, 0], "rotation": turn,
                     "extensions": {"KHR_physics_rigid_bodies": {"collider": {"geometry": geometry}}}},
                    {"name": "body", "translation": [0, 0.7, 0], "rotation": tilt,
                     "extensions": {"KHR_physics_rigid_bodies":
                         {"motion": {"mass": 2}, "collider": {"geometry": moving}}}},
                ],
            });
            let bytes = value.to_string().into_bytes();
            let loaded =
                gltf::from_slice(&bytes, "rest", Path::new(""), &Options::default()).unwrap();
            let mut run = Run::of(loaded);
            run.seconds(3.0);
            let (y, speed) = (run.quantity(1, "y"), run.quantity(1, "speed"));
            if !(0.49..=0.51).contains(&y) || speed > 0.02 {
                failures.push(format!("{mover} on {ground}: y {y}, speed {speed}"));
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
