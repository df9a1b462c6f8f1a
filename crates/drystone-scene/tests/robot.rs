//! The description of robots against the numbers of MuJoCo's compiler, which
//! `data/robots/mujoco/compile.py` wrote.
#![expect(clippy::unwrap_used, reason = "a test may fail anywhere")]

use std::fs;
use std::path::{Path, PathBuf};

use drystone_scene::mjcf;
use drystone_scene::robot::{
    Dynamics, Joint, JointType, Law, Object, Robot, Sensor, Stage, Transmission,
};
use serde_json::Value;

#[expect(dead_code, reason = "what scenes need is not for descriptions")]
mod damage;

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/robots/mujoco").join(name)
}

/// A description, and what MuJoCo's compiler made of the file.
fn both(name: &str) -> (Robot, Value) {
    let robot = mjcf::describe(&data(&format!("{name}.xml"))).unwrap();
    let text = fs::read_to_string(data(&format!("{name}.json"))).unwrap();
    (robot, serde_json::from_str(&text).unwrap())
}

/// Whether numbers are those of the file to the rounding of single precision, over a sum of angles.
fn assert_close(own: &[f32], theirs: &Value, what: &str) {
    let theirs: Vec<f64> = match theirs {
        Value::Array(list) => list.iter().map(|x| x.as_f64().unwrap()).collect(),
        Value::Null => Vec::new(),
        one => vec![one.as_f64().unwrap()],
    };
    assert_eq!(own.len(), theirs.len(), "{what}: {own:?}, {theirs:?}");
    for (own, their) in own.iter().zip(&theirs) {
        let off = (f64::from(*own) - their).abs();
        assert!(off <= 1.0e-6 * their.abs().max(1.0), "{what}: {own} {their}");
    }
}

fn assert_range(own: Option<[f32; 2]>, theirs: &Value, what: &str) {
    assert_close(own.as_ref().map_or(&[], |r| r.as_slice()), theirs, what);
}

fn name(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}

fn list(value: &Value) -> &[Value] {
    value.as_array().unwrap()
}

fn check_joint(own: &Joint, their: &Value) {
    let what = format!("joint {}", own.name);
    let kind = match own.kind {
        JointType::Free => "free",
        JointType::Ball => "ball",
        JointType::Slide => "slide",
        JointType::Hinge => "hinge",
    };
    assert_eq!((own.name.as_str(), kind), (name(&their["name"]), name(&their["kind"])));
    assert!(their["link"].is_null() || own.link == name(&their["link"]), "{what}: {}", own.link);
    assert_eq!([own.q, own.v].map(|n| n as u64), ["q", "v"].map(|n| their[n].as_u64().unwrap()));
    assert_close(&own.anchor.to_array(), &their["anchor"], &what);
    if matches!(own.kind, JointType::Slide | JointType::Hinge) {
        assert_close(&own.axis.to_array(), &their["axis"], &what);
        assert_close(&[own.reference], &their["reference"], &what);
        assert_close(&[own.spring_reference], &their["spring_reference"], &what);
    }
    assert_range(own.range, &their["range"], &what);
    assert_range(own.force_range, &their["force_range"], &what);
    assert_eq!(own.gravity_by_actuators, their["gravity_by_actuators"].as_bool().unwrap());
    // The compiler makes these of a time constant and the mass.
    if own.spring_damper.is_none() {
        assert_close(&own.stiffness, &their["stiffness"], &what);
        assert_close(&own.damping, &their["damping"], &what);
    }
    assert_close(&[own.armature], &their["armature"], &what);
    assert_close(&[own.friction], &their["friction"], &what);
    assert_close(&[own.margin], &their["margin"], &what);
}

fn check_tendons(robot: &Robot, theirs: &[Value]) {
    assert_eq!(robot.tendons.len(), theirs.len());
    for (own, their) in robot.tendons.iter().zip(theirs) {
        let what = format!("tendon {}", own.name);
        assert_eq!(own.name, name(&their["name"]));
        let path: Vec<(&str, &str, &str, f32)> = own
            .path
            .iter()
            .map(|stage| match stage {
                Stage::Joint(i, by) => ("joint", robot.joints[*i].name.as_str(), "", *by),
                Stage::Site(i) => ("site", robot.sites[*i].name.as_str(), "", 0.0),
                Stage::Geom(geom, side) => (
                    "sphere",
                    geom.as_str(),
                    side.map_or("", |s| robot.sites[s].name.as_str()),
                    0.0,
                ),
                Stage::Pulley(by) => ("pulley", "", "", *by),
            })
            .collect();
        let expected = list(&their["path"]);
        assert_eq!(path.len(), expected.len(), "{what}");
        for (own, their) in path.iter().zip(expected) {
            // A tendon wraps around a sphere or a cylinder there.
            let kind = name(&their[0]).replace("cylinder", "sphere");
            assert_eq!((own.0, own.1, own.2), (kind.as_str(), name(&their[1]), name(&their[2])));
            assert_close(&[own.3], &their[3], &what);
        }
        assert_range(own.range, &their["range"], &what);
        assert_close(&own.stiffness, &their["stiffness"], &what);
        assert_close(&own.damping, &their["damping"], &what);
        assert_close(&[own.friction], &their["friction"], &what);
        assert_close(&[own.armature], &their["armature"], &what);
        // Without one the compiler gives the tendon's length.
        if own.spring_length.is_some() {
            assert_range(own.spring_length, &their["spring_length"], &what);
        }
    }
}

/// The kind of a transmission, what it is at, and the second site.
fn transmission(robot: &Robot, of: &Transmission) -> (&'static str, String, String) {
    let site = |i: usize| robot.sites[i].name.clone();
    match of {
        Transmission::Joint { joint, in_parent } => {
            let kind = if *in_parent { "jointinparent" } else { "joint" };
            (kind, robot.joints[*joint].name.clone(), String::new())
        }
        Transmission::Tendon(i) => ("tendon", robot.tendons[*i].name.clone(), String::new()),
        Transmission::Site { site: at, reference } => {
            ("site", site(*at), reference.map_or_else(String::new, site))
        }
        Transmission::Crank { crank, slider, .. } => ("slidercrank", site(*crank), site(*slider)),
        Transmission::Link(link) => ("body", link.clone(), String::new()),
    }
}

fn law(of: Law) -> &'static str {
    match of {
        Law::None => "none",
        Law::Fixed => "fixed",
        Law::Affine => "affine",
        Law::Muscle => "muscle",
        Law::User => "user",
    }
}

fn check_actuators(robot: &Robot, theirs: &[Value]) {
    assert_eq!(robot.actuators.len(), theirs.len());
    for (own, their) in robot.actuators.iter().zip(theirs) {
        let what = format!("actuator {}", own.name);
        assert_eq!(own.name, name(&their["name"]));
        let (kind, at, second) = transmission(robot, &own.transmission);
        let expected = &their["transmission"];
        assert_eq!([kind, &at, &second], [0, 1, 2].map(|i| name(&expected[i])), "{what}");
        if let Transmission::Crank { length, .. } = own.transmission {
            assert_close(&[length], &their["crank_length"], &what);
        }
        assert_close(&own.gear, &their["gear"], &what);
        assert_range(own.control_range, &their["control_range"], &what);
        assert_range(own.force_range, &their["force_range"], &what);
        assert_range(own.activation_range, &their["activation_range"], &what);
        // Without one the compiler searches for it.
        if let Some(range) = own.length_range {
            assert_close(&range, &their["length_range"], &what);
        }
        let dynamics = match own.dynamics {
            Dynamics::None => "none",
            Dynamics::Integrator => "integrator",
            Dynamics::Filter => "filter",
            Dynamics::FilterExact => "filterexact",
            Dynamics::Muscle => "muscle",
            Dynamics::User => "user",
        };
        let kinds = [dynamics, law(own.gain), law(own.bias)];
        assert_eq!(kinds, ["dynamics", "gain", "bias"].map(|n| name(&their[n])), "{what}");
        assert_close(&own.dynamics_numbers, &their["dynamics_numbers"], &what);
        assert_close(&own.gain_numbers, &their["gain_numbers"], &what);
        let mut bias = their["bias_numbers"].clone();
        if own.damping_ratio.is_some() {
            // The compiler makes it of the mass.
            assert!(bias[2].as_f64().unwrap() < 0.0, "{what}");
            bias[2] = 0.0.into();
        }
        assert_close(&own.bias_numbers, &bias, &what);
        assert_eq!(own.acts_early, their["acts_early"].as_bool().unwrap(), "{what}");
        assert_close(&[own.armature], &their["armature"], &what);
        assert_close(&own.damping, &their["damping"], &what);
    }
}

fn object(robot: &Robot, of: Option<&Object>) -> (String, String) {
    let (kind, name) = match of {
        None => ("", String::new()),
        Some(Object::Joint(i)) => ("joint", robot.joints[*i].name.clone()),
        Some(Object::Tendon(i)) => ("tendon", robot.tendons[*i].name.clone()),
        Some(Object::Actuator(i)) => ("actuator", robot.actuators[*i].name.clone()),
        Some(Object::Site(i)) => ("site", robot.sites[*i].name.clone()),
        Some(Object::Link { name, inertial: true }) => ("body", name.clone()),
        Some(Object::Link { name, inertial: false }) => ("xbody", name.clone()),
        Some(Object::Geom(name)) => ("geom", name.clone()),
        Some(Object::Other(kind, name)) => (kind.as_str(), name.clone()),
    };
    (kind.to_owned(), name)
}

fn check_sensor(robot: &Robot, own: &Sensor, their: &Value) {
    assert_eq!(own.name, name(&their["name"]));
    // Two are called otherwise there.
    let kind = match own.kind.as_str() {
        "jointactuatorfrc" => "jointactfrc",
        "tendonactuatorfrc" => "tendonactfrc",
        "distance" => "geomdist",
        other => other,
    };
    assert_eq!(kind, name(&their["kind"]));
    for (of, at) in [(&own.object, "object"), (&own.reference, "reference")] {
        let (kind, of) = object(robot, of.as_ref());
        assert_eq!(
            (kind.as_str(), of.as_str()),
            (name(&their[at][0]), name(&their[at][1])),
            "{own:?}"
        );
    }
    assert_eq!(own.size.unwrap() as u64, their["size"].as_u64().unwrap(), "{own:?}");
    assert_close(
        &[own.cutoff, own.noise],
        &Value::from(vec![their["cutoff"].clone(), their["noise"].clone()]),
        "sensor",
    );
}

fn check(name_of_file: &str) -> Robot {
    let (robot, theirs) = both(name_of_file);
    assert!(robot.left_out.is_empty(), "{:?}", robot.left_out);
    let joints = list(&theirs["joints"]);
    assert_eq!(robot.joints.len(), joints.len());
    robot.joints.iter().zip(joints).for_each(|(own, their)| check_joint(own, their));
    assert_close(&robot.start, &theirs["start"], "start");
    check_tendons(&robot, list(&theirs["tendons"]));
    check_actuators(&robot, list(&theirs["actuators"]));
    let sensors = list(&theirs["sensors"]);
    assert_eq!(robot.sensors.len(), sensors.len());
    robot.sensors.iter().zip(sensors).for_each(|(own, their)| check_sensor(&robot, own, their));
    let keys = list(&theirs["keyframes"]);
    assert_eq!(robot.keyframes.len(), keys.len());
    for (own, their) in robot.keyframes.iter().zip(keys) {
        assert_eq!(own.name, name(&their["name"]));
        assert_close(&[own.time], &their["time"], "time");
        assert_close(&own.q, &their["q"], "q");
        assert_close(&own.v, &their["v"], "v");
        assert_close(&own.activations, &their["act"], "activations");
        assert_close(&own.controls, &their["ctrl"], "controls");
        let at: Vec<f32> = own.mocap.iter().flat_map(|p| p.position.to_array()).collect();
        assert_close(&at, &their["mocap_positions"], "mocap");
        let turns = own.mocap.iter().map(|p| p.rotation);
        let turns: Vec<f32> = turns.flat_map(|r| [r.w, r.x, r.y, r.z]).collect();
        assert_close(&turns, &their["mocap_rotations"], "mocap");
    }
    robot
}

#[test]
fn a_robot_of_every_kind_of_actuator_is_what_mujoco_compiles() {
    let robot = check("described");
    assert_eq!((robot.velocities(), robot.activations()), (13, 8));
    assert_eq!(robot.readings(), Some(47));
    assert_eq!(
        robot.actuators.iter().find(|a| a.name == "p_ratio").unwrap().damping_ratio,
        Some(0.9)
    );
    assert_eq!(robot.joints.last().unwrap().spring_damper, Some([0.1, 0.7]));
}

#[test]
fn every_short_form_in_every_class_is_what_mujoco_compiles() {
    assert_eq!(check("short_forms").actuators.len(), 164);
}

#[test]
fn attached_models_and_copies_are_what_mujoco_compiles() {
    let robot = check("attached");
    // Sites are those of the file, in their frames.
    let top = robot.sites.iter().find(|s| s.name == "top").unwrap();
    assert!((top.pose.position - drystone::vec3(0.0, 1.0, 1.0)).length() < 1.0e-6);
    let touch = robot.sites.iter().find(|s| s.name == "r_touch").unwrap();
    assert_eq!(touch.link, "r_finger");
    assert!((touch.pose.direction(drystone::Vec3::Z) + drystone::Vec3::X).length() < 1.0e-6);
}

#[test]
fn what_is_wrong_or_not_read_is_said_in_one_line() {
    let read = |inside: &str| {
        let body = "<worldbody><body name=\"b\"><joint name=\"j\" range=\"-1 1\"/><geom size=\".1\"/></body></worldbody>";
        mjcf::describe_text(&format!("<mujoco>{body}{inside}</mujoco>"), Path::new(""))
    };
    for (inside, part) in [
        ("<actuator><motor joint=\"k\"/></actuator>", "there is no joint 'k'"),
        ("<actuator><motor/></actuator>", "it pulls at nothing"),
        ("<actuator><motor site=\"s\"/></actuator>", "there is no site 's'"),
        ("<actuator><motor joint=\"j\" gear=\"x\"/></actuator>", "gear=\"x\""),
        ("<actuator><motor joint=\"j\" ctrllimited=\"1\"/></actuator>", "ctrllimited=\"1\""),
        ("<actuator><general joint=\"j\" gaintype=\"none\"/></actuator>", "gaintype=\"none\""),
        ("<actuator><general joint=\"j\" dyntype=\"x\"/></actuator>", "dyntype=\"x\""),
        ("<actuator><position joint=\"j\" kv=\"1\" dampratio=\"1\"/></actuator>", "one of them"),
        ("<actuator><position body=\"b\" inheritrange=\"1\"/></actuator>", "what has none"),
        (
            "<tendon><fixed><joint joint=\"k\" coef=\"1\"/></fixed></tendon>",
            "there is no joint 'k'",
        ),
        ("<tendon><fixed><wheel/></fixed></tendon>", "no such part"),
        ("<sensor><jointpos joint=\"k\"/></sensor>", "there is no joint 'k'"),
        ("<sensor><actuatorfrc actuator=\"a\"/></sensor>", "there is no actuator 'a'"),
        ("<sensor><gyro site=\"s\" cutoff=\"-\"/></sensor>", "there is no site 's'"),
        ("<keyframe><key qpos=\"1 2\"/></keyframe>", "qpos has 2 numbers, expected 1"),
        ("<keyframe><key ctrl=\"1\"/></keyframe>", "ctrl has 1 numbers, expected 0"),
    ] {
        let e = read(inside).unwrap_err().to_string();
        assert!(e.contains(part) && e.contains("line 1") && !e.contains('\n'), "{inside}: {e}");
    }
    for (inside, part) in [
        (
            "<actuator><dcmotor name=\"d\" joint=\"j\"/></actuator>",
            "<dcmotor name=\"d\">: actuators of this",
        ),
        ("<sensor><plugin plugin=\"p\"/></sensor>", "<plugin>: plugins are not read: left out"),
    ] {
        let robot = read(inside).unwrap();
        assert!(
            robot.left_out.len() == 1 && robot.left_out[0].contains(part),
            "{:?}",
            robot.left_out
        );
    }
}

#[test]
fn copies_of_copies_end() {
    let copies = "<replicate count=\"400\"><body name=\"b\"><joint name=\"j\"/><geom size=\".1\"/></body></replicate>";
    let motors = "<motor joint=\"j\"/>".repeat(600);
    let text =
        format!("<mujoco><worldbody>{copies}</worldbody><actuator>{motors}</actuator></mujoco>");
    let e = mjcf::describe_text(&text, Path::new("")).unwrap_err().to_string();
    assert!(e.contains("more than 200000 tendons, actuators or sensors"), "{e}");
}

#[test]
fn damaged_descriptions_never_panic() {
    let texts: Vec<String> = ["described.xml", "attached.xml", "short_forms.xml"]
        .iter()
        .map(|name| fs::read_to_string(data(name)).unwrap())
        .collect();
    let (mut good, mut bad) = (0, 0);
    damage::each(&texts, 600, |text| match mjcf::describe_text(text, &data("")) {
        Ok(robot) => {
            good += 1;
            assert!(robot.keyframes.iter().all(|key| key.q.len() == robot.start.len()));
        }
        Err(e) => {
            bad += 1;
            let line = e.to_string();
            assert!(!line.contains('\n') && line.len() < 1500, "{line}");
        }
    });
    assert!(good > 30 && bad > 30, "{good} read, {bad} refused");
}
