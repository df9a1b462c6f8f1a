//! Robots and scenes of MuJoCo.

use std::fs;

use crate::command::{drystone, text};
use crate::common::folder;

use crate::running::{fail, json, succeed};

/// An arm of two links on a base; a hand is fixed to the second.
const ROBOT: &str = r#"<robot name="arm">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0.5 0 0"/><mass value="1"/><inertia ixx="0.01" iyy="0.1" izz="0.1"/></inertial></link>
  <link name="hand"><inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1"/></inertial>
    <collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/></joint>
  <joint name="wrist" type="fixed"><parent link="upper"/><child link="hand"/><origin xyz="1 0 0"/></joint>
</robot>"#;

#[test]
fn a_robot_runs_and_its_trace_names_every_link() {
    let folder = folder("robot");
    fs::write(folder.join("arm.urdf"), ROBOT).unwrap();
    let run = ["simulate", "arm.urdf", "--steps", "30", "--trace", "t.csv", "--report", "r.json"];
    succeed(&folder, &run);
    let trace = fs::read_to_string(folder.join("t.csv")).unwrap();
    let last: Vec<Vec<&str>> =
        trace.lines().filter(|l| l.starts_with("30,")).map(|l| l.split(',').collect()).collect();
    let names: Vec<&str> = last.iter().map(|row| row[2]).collect();
    assert_eq!(names, ["base", "upper", "hand"]);
    let number = |row: usize, column: usize| last[row][column].parse::<f64>().unwrap();
    // The hand's center is 1 m from the axis; the way of both together is that of 0.75 m.
    let ratio = number(2, 10).hypot(number(2, 12)) / number(1, 10).hypot(number(1, 12));
    assert!((ratio - 1.0 / 0.75).abs() < 1.0e-3, "{ratio}");
    let reach = number(2, 3).hypot(number(2, 5));
    assert!((reach - 1.0).abs() < 1.0e-3 && number(2, 5) < -0.1, "{reach}");
    let report = json(&folder.join("r.json"));
    assert_eq!(report["bodies"]["dynamic"], 1);
    assert!(report["joint_error"]["max"].as_f64().unwrap() < 1.0e-3);
    let ground = succeed(&folder, &["info", "arm.urdf", "--base", "fixed", "--ground=-2"]);
    assert!(ground.contains("ground: static, 1 half-space"), "{ground}");
    assert!(
        succeed(&folder, &["bench", "--scene", "arm.urdf", "--steps", "10"]).contains("arm.urdf")
    );
    let compared = [
        "compare",
        "arm.urdf",
        "--with",
        "soft-step",
        "--with",
        "soft-step-relax",
        "--steps",
        "10",
    ];
    assert!(succeed(&folder, &compared).contains("soft-step-relax"));
    succeed(&folder, &["simulate", "arm.urdf", "--steps", "10", "--bake", "arm.glb"]);
    for usage in ["info hello --ground", "info hello --base fixed", "info arm.urdf --base loose"] {
        let output = drystone(&folder, &usage.split_whitespace().collect::<Vec<_>>());
        assert_eq!(output.status.code(), Some(2), "{usage}: {}", text(&output.stderr));
    }
}

#[test]
fn broken_robots_and_scenes_of_mujoco_are_refused_in_one_line() {
    let folder = folder("broken_xml");
    for (name, content, part) in [
        ("a.urdf", "<robot><link name=\"a\">", "line 1: broken XML"),
        ("b.urdf", "<robot/>", "it has no link"),
        ("c.xml", "<mujoco><worldbody><body/></mujoco>", "line 1: broken XML"),
        ("d.xml", "<robot/>", "the outermost element is <robot>, expected <mujoco>"),
        ("e.xml", "", "it is empty"),
        (
            "f.xml",
            "<mujoco><worldbody><body><joint axis=\"0 0 nan\"/></body></worldbody></mujoco>",
            "nan",
        ),
    ] {
        fs::write(folder.join(name), content).unwrap();
        for command in ["info", "simulate"] {
            let line = fail(&folder, &[command, name]);
            assert!(line.contains(name) && line.contains(part), "{line}");
        }
    }
    fs::write(folder.join("bytes.urdf"), [0xff, 0xfe, 0x00]).unwrap();
    assert!(fail(&folder, &["info", "bytes.urdf"]).contains("not UTF-8"));
}
