//! Joints of glTF files: what they are read into, how they act, what is refused.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test may fail anywhere")]

use std::path::Path;

use drystone::joint::{JointAxis, JointMotion, JointSpring, SixDof};
use drystone::math::trig;
use drystone::{BodyId, JointKind, Vec3, World, vec3};
use drystone_scene::gltf::{self, LoadedGltf, Options};
use drystone_scene::{Running, SceneError};
use serde_json::{Value, json};

/// A post at the origin and a cube of 1 kg and 0.2 m at `at`, held by this joint at the origin.
fn document(joint: Value, at: Value, motion: Value) -> Value {
    let with = |e: Value| json!({"KHR_physics_rigid_bodies": e});
    let away: Vec<f64> = at.as_array().unwrap().iter().map(|v| -v.as_f64().unwrap()).collect();
    json!({
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_implicit_shapes", "KHR_physics_rigid_bodies"],
        "extensions": {
            "KHR_implicit_shapes": {"shapes": [{"type": "box", "box": {"size": [0.2, 0.2, 0.2]}}]},
            "KHR_physics_rigid_bodies": {"physicsJoints": [joint]}
        },
        "scene": 0,
        "scenes": [{"nodes": [0, 3]}],
        "nodes": [
            {"name": "post", "children": [1], "extensions": with(json!({"collider": {"geometry": {"shape": 0}}}))},
            {"extensions": with(json!({"joint": {"connectedNode": 2, "joint": 0}}))},
            {"translation": away},
            {"name": "cube", "children": [2], "translation": at, "extensions": with(
                json!({"motion": motion, "collider": {"geometry": {"shape": 0}}}))}
        ]
    })
}

fn read(value: &Value) -> Result<LoadedGltf, SceneError> {
    gltf::from_slice(value.to_string().as_bytes(), "test", Path::new(""), &Options::default())
}

fn kinds(joint: Value) -> Vec<JointKind> {
    let loaded = read(&document(joint, json!([1, 0, 0]), json!({"mass": 1}))).unwrap();
    assert!(loaded.scene.notes.is_empty(), "{:?}", loaded.scene.notes);
    loaded.scene.joints.iter().map(|j| j.kind).collect()
}

fn axes(joint: Value) -> SixDof {
    match kinds(joint)[..] {
        [JointKind::SixDof(axes)] => axes,
        ref other => panic!("{other:?}"),
    }
}

fn run(value: &Value, seconds: u16) -> (World, Vec<BodyId>) {
    let Running { mut world, bodies, .. } = read(value).unwrap().scene.build().unwrap();
    for _ in 0..seconds * 60 {
        world.step(1.0 / 60.0);
    }
    (world, bodies)
}

const HELD: &str = r#"{"linearAxes": [0, 1, 2], "min": 0, "max": 0}"#;

fn held() -> Value {
    serde_json::from_str(HELD).unwrap()
}

#[test]
fn limits_become_what_the_text_says() {
    assert_eq!(kinds(json!({"limits": [held()]})), [JointKind::Ball]);
    let range = json!({"linearAxes": [0, 1, 2], "min": 0.5, "max": 1.5});
    let distance = JointKind::Distance { min: 0.5, max: 1.5, spring: None };
    assert_eq!(kinds(json!({"limits": [range]})), [distance]);
    let hinge = axes(json!({"limits": [held(),
        {"angularAxes": [1, 2], "min": 0, "max": 0}, {"angularAxes": [0], "min": -0.5, "max": 0.25}]}));
    assert_eq!(hinge.linear, [JointAxis::LOCKED; 3]);
    assert_eq!(
        hinge.angular,
        [JointAxis::limited(-0.5, 0.25), JointAxis::LOCKED, JointAxis::LOCKED]
    );
    // A limit on one side, and a spring where there is no room.
    let soft = axes(json!({"limits": [{"linearAxes": [1], "max": 2},
        {"linearAxes": [2], "min": 0, "max": 0, "stiffness": 50, "damping": 3}]}));
    assert_eq!(soft.linear[1], JointAxis::limited(f32::NEG_INFINITY, 2.0));
    let spring = Some(JointSpring::new(50.0, 3.0));
    assert_eq!(soft.linear[2].motion, JointMotion::Limited { min: 0.0, max: 0.0, spring });
    // A cone about y becomes one about x, in frames that are turned.
    let cone = axes(json!({"limits": [held(), {"angularAxes": [0, 2], "max": 0.7}]}));
    assert_eq!(cone.cone.unwrap().swing.map(f32::to_bits), [0.7_f32.to_bits(); 2]);
    assert!((cone.frame_a.rotate(Vec3::X) - Vec3::Y).length() < 1.0e-6);
    assert!((cone.frame_b.rotate(Vec3::X) - Vec3::Y).length() < 1.0e-6);
}

#[test]
fn what_is_wrong_is_refused_and_named() {
    for (joint, place) in [
        (json!({"limits": [{"linearAxes": [0], "min": 1, "max": 0}]}), "limits[0]"),
        (json!({"limits": [{"linearAxes": [3], "min": 0, "max": 0}]}), "linearAxes[0]"),
        (json!({"limits": [{"linearAxes": [1, 1], "max": 0}]}), "linearAxes[1]"),
        (json!({"limits": [{"linearAxes": [], "max": 0}]}), "linearAxes"),
        (json!({"limits": [{"min": 0, "max": 0}]}), "limits[0]"),
        (json!({"limits": [{"angularAxes": [0], "max": 0, "stiffness": -1}]}), "stiffness"),
        (json!({"limits": [{"linearAxes": [0, 1], "min": -2, "max": -1}]}), "limits[0]"),
        (json!({"drives": [{"type": "linear", "axis": 0, "damping": -1}]}), "damping"),
        (json!({"drives": [{"type": "round", "axis": 0}]}), "type"),
        (json!({"drives": [{"type": "linear", "mode": "fast", "axis": 0}]}), "mode"),
        (json!({"drives": [{"type": "linear", "axis": 0, "maxForce": -1}]}), "maxForce"),
        (json!({"drives": [{"type": "linear"}]}), "drives[0]"),
        (json!({"limits": 7}), "limits"),
    ] {
        let wrong = read(&document(joint, json!([1, 0, 0]), json!({"mass": 1}))).unwrap_err();
        let line = wrong.to_string();
        assert!(line.contains(place), "{line} names {place}");
    }
    let mut far = document(json!({"limits": [held()]}), json!([1, 0, 0]), json!({"mass": 1}));
    far["nodes"][1]["extensions"]["KHR_physics_rigid_bodies"]["joint"]["joint"] = json!(1);
    assert!(read(&far).unwrap_err().to_string().contains("joint"));
}

#[test]
fn joints_that_hold_nothing_are_left_out_with_a_note() {
    let notes = |value: &Value| {
        let scene = read(value).unwrap().scene;
        assert!(scene.joints.is_empty());
        scene.notes.join("\n")
    };
    let fixed = json!({"limits": [held()]});
    let mut same = document(fixed.clone(), json!([1, 0, 0]), json!({"mass": 1}));
    same["nodes"][1]["extensions"]["KHR_physics_rigid_bodies"]["joint"]["connectedNode"] = json!(0);
    assert!(notes(&same).contains("one body"));
    let kinematic = document(fixed, json!([1, 0, 0]), json!({"isKinematic": true}));
    assert!(notes(&kinematic).contains("forces move"));
    let empty = document(json!({"limits": []}), json!([1, 0, 0]), json!({"mass": 1}));
    assert!(notes(&empty).contains("holds nothing"));
}

/// The joint's own node may hang in the air: what it holds is held by the world.
#[test]
fn a_joint_to_no_body_holds_to_the_world() {
    let mut value = document(json!({"limits": [held()]}), json!([1, 0, 0]), json!({"mass": 1}));
    value["nodes"][0].as_object_mut().unwrap().remove("extensions");
    let (world, bodies) = run(&value, 5);
    let cube = bodies.iter().map(|id| world.body(*id).unwrap()).find(|b| b.mass() > 0.0).unwrap();
    assert!((cube.position().length() - 1.0).abs() < 2.0e-3, "{:?}", cube.position());
}

#[test]
fn a_drive_by_force_rests_at_its_stretch_wherever_the_center_of_mass_is() {
    // 2 kg on 100 N/m along y: 19.62/100 m below the target, for any center of mass and mode.
    for mode in ["force", "acceleration"] {
        let (stiffness, damping) = if mode == "force" { (100.0, 20.0) } else { (50.0, 10.0) };
        let drive = json!({"type": "linear", "mode": mode, "axis": 1, "positionTarget": 0.5,
            "stiffness": stiffness, "damping": damping});
        let slider = json!({"drives": [drive], "limits": [
            {"linearAxes": [0, 2], "min": 0, "max": 0}, {"angularAxes": [0, 1, 2], "min": 0, "max": 0}]});
        let motion = json!({"mass": 2, "centerOfMass": [0.4, 0.2, -0.3]});
        let (world, bodies) = run(&document(slider, json!([0, 0, 0]), motion), 10);
        let y = world.body(bodies[1]).unwrap().position().y;
        assert!((y - (0.5 - 9.81 * 2.0 / 100.0)).abs() < 1.0e-3, "{mode}: {y}");
    }
}

#[test]
fn linked_bodies_collide_only_if_they_are_told_to() {
    // A cube that slides down a rail onto the post: through it, or onto it.
    for (collides, low, high) in [(false, -1.01, -0.99), (true, 0.19, 0.201)] {
        let rail = json!({"limits": [{"linearAxes": [0, 2], "min": 0, "max": 0},
            {"linearAxes": [1], "min": -1.0}, {"angularAxes": [0, 1, 2], "min": 0, "max": 0}]});
        let mut value = document(rail, json!([0, 0.5, 0]), json!({"mass": 1}));
        // Both frames at the origin of their bodies.
        value["nodes"][2]["translation"] = json!([0, 0, 0]);
        value["nodes"][1]["extensions"]["KHR_physics_rigid_bodies"]["joint"]["enableCollision"] =
            json!(collides);
        let (world, bodies) = run(&value, 3);
        let at = world.body(bodies[1]).unwrap().position();
        assert!(at.y > low && at.y < high, "{collides}: {at:?}");
        assert!((at - vec3(0.0, at.y, 0.0)).length() < 1.0e-3, "{at:?}");
    }
}

#[test]
fn a_cone_about_any_axis_holds_a_hanging_body() {
    // The cube 1 m beside the post may sink by 0.4 rad about the axis that points at it.
    let cone = json!({"limits": [held(), {"angularAxes": [1, 2], "max": 0.4}]});
    let (world, bodies) = run(&document(cone, json!([1, 0, 0]), json!({"mass": 1})), 10);
    let x = world.body(bodies[1]).unwrap().rotation().rotate(Vec3::X);
    assert!((x.y + trig::sin_cos(0.4).0).abs() < 2.0e-3, "{x:?}");
    // A motor about z turns by its sign: the cube against the post.
    let angular = json!({"type": "angular", "axis": 2, "velocityTarget": 1.0, "damping": 1000.0});
    let motor = json!({"limits": [held(), {"angularAxes": [0, 1], "min": 0, "max": 0}], "drives": [angular]});
    let still = json!({"mass": 1, "gravityFactor": 0});
    let (world, bodies) = run(&document(motor, json!([1, 0, 0]), still), 3);
    let w = world.body(bodies[1]).unwrap().angular_velocity();
    assert!((w - Vec3::Z).length() < 1.0e-3, "{w:?}");
}
