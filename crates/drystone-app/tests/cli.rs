//! The command as its users meet it: exit statuses, messages, files.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod command;
mod common;

use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use command::{drystone, text};
use common::folder;

/// A box above a floor; parts in capitals are replaced to make it wrong.
const SCENE: &str = r#"{
  "asset": {"version": "2.0"},
  "extensionsUsed": ["KHR_implicit_shapes", "KHR_physics_rigid_bodies"],
  REQUIRED
  "extensions": {"KHR_implicit_shapes": {"shapes": [
    {"type": "box", "box": {"size": [40.0, 1.0, 40.0]}},
    {"type": "box", "box": {"size": [1.0, 1.0, 1.0]}}
  ]}},
  "buffers": [{"byteLength": 36,
    "uri": "data:application/octet-stream;base64,POINTS"}],
  "bufferViews": [{"buffer": 0, "byteLength": 36}],
  "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
    "min": [0, 0, 0], "max": [1, 1, 0]}],
  "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 0}]}],
  "nodes": [
    {"name": "floor", "translation": [0, -0.5, 0],
      "extensions": {"KHR_physics_rigid_bodies": {"collider": {"geometry": {"shape": 0}}}}},
    {"name": "a \"box\", falling", "translation": [0, HEIGHT, 0], "extensions":
      {"KHR_physics_rigid_bodies": {"motion": {"mass": MASS}, "collider": {"geometry": GEOMETRY}}}}
  ],
  "scene": 0, "scenes": [{"nodes": [0, 1]}]
}"#;

/// Three points in the plane z = 0.
const POINTS: &str = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";

/// [`SCENE`] with some of its parts replaced.
fn scene_with(changes: &[(&str, &str)]) -> String {
    let mut text = SCENE.replace("POINTS", POINTS);
    for &(part, value) in changes {
        text = text.replace(part, value);
    }
    for (part, value) in
        [("REQUIRED", ""), ("HEIGHT", "1.0"), ("MASS", "1.0"), ("GEOMETRY", r#"{"shape": 1}"#)]
    {
        text = text.replace(part, value);
    }
    text
}

/// Runs the command, which must succeed; returns what it printed.
fn succeed(folder: &Path, args: &[&str]) -> String {
    let output = drystone(folder, args);
    assert_eq!(output.status.code(), Some(0), "{args:?}: {}", text(&output.stderr));
    assert_eq!(text(&output.stderr), "", "{args:?}: nothing but errors belongs on stderr");
    text(&output.stdout)
}

/// Runs the command, which must fail with status 1 and one line; returns the line.
fn fail(folder: &Path, args: &[&str]) -> String {
    let start = Instant::now();
    let output = drystone(folder, args);
    let line = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{args:?}: {line}");
    assert!(line.starts_with("error: ") && line.ends_with('\n'), "{args:?}: {line}");
    assert_eq!(line.lines().count(), 1, "{args:?}: {line}");
    assert!(line.len() < 1000, "{args:?}: {line}");
    assert_eq!(text(&output.stdout), "", "{args:?}");
    assert!(start.elapsed() < Duration::from_secs(5), "{args:?} took {:?}", start.elapsed());
    line
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

#[test]
fn wrong_usage_exits_with_two() {
    let folder = folder("usage");
    for args in [
        "",
        "fly",
        "simulate",
        "simulate hello --hz 0",
        "simulate hello --hz nan",
        "simulate hello --seconds -1",
        "simulate hello --seconds 1 --steps 1",
        "simulate hello --every 0",
        "simulate hello --threads 0",
        "simulate hello --threads 1000",
        "simulate hello --substeps 0",
        "simulate hello --method magic",
        "simulate hello --set gravity",
        "simulate hello --set contact.magic=1",
        "simulate hello --set gravity=1,2",
        "simulate hello --bake out.obj",
        "simulate hello --trace a --report a",
        "simulate hello --auto-colliders hull",
        "simulate hello extra",
        "simulate hello --snapshot",
        "simulate hello --record a --trace a",
        "replay",
        "info",
    ] {
        let output = drystone(&folder, &args.split_whitespace().collect::<Vec<_>>());
        assert_eq!(output.status.code(), Some(2), "{args}: {}", text(&output.stderr));
        assert!(!output.stderr.is_empty(), "{args}");
    }
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 0, "wrong usage must leave no file");
}

#[test]
fn scenes_that_cannot_be_read_are_refused_in_one_line() {
    let folder = folder("unreadable");
    fs::create_dir(folder.join("directory.gltf")).unwrap();
    let write = |name: &str, content: &str| fs::write(folder.join(name), content).unwrap();
    write("empty.gltf", "");
    write("empty.glb", "");
    write("broken.gltf", "{\"asset\": {\"version\": \"2.0\"}, \"nodes\": [");
    write("text.glb", "this is no scene\nat all\n");
    write("array.gltf", "[]");
    write("unknown.step", "x");
    write("nan.gltf", &scene_with(&[("HEIGHT", "NaN")]));
    write("infinite.gltf", &scene_with(&[("HEIGHT", "1e999")]));
    write("large.gltf", &scene_with(&[("HEIGHT", "1e300")]));
    write("mass.gltf", &scene_with(&[("MASS", "-1.0")]));
    write("shape.gltf", &scene_with(&[("GEOMETRY", r#"{"shape": 7}"#)]));
    write("hull.gltf", &scene_with(&[("GEOMETRY", r#"{"mesh": 0, "convexHull": true}"#)]));
    write("required.gltf", &scene_with(&[("REQUIRED", r#""extensionsRequired": ["EXT_magic"],"#)]));
    for name in [
        "missing.gltf",
        "missing.glb",
        "no/such/folder.gltf",
        "directory.gltf",
        ".",
        "empty.gltf",
        "empty.glb",
        "broken.gltf",
        "text.glb",
        "array.gltf",
        "unknown.step",
        "nan.gltf",
        "infinite.gltf",
        "large.gltf",
        "mass.gltf",
        "shape.gltf",
        "hull.gltf",
        "required.gltf",
    ] {
        for command in ["simulate", "info"] {
            let line = fail(&folder, &[command, name]);
            assert!(line.contains(name), "{name}: {line}");
        }
    }
    assert!(fail(&folder, &["simulate", "mass.gltf"]).contains("mass"));
    assert!(fail(&folder, &["simulate", "required.gltf"]).contains("EXT_magic"));
}

#[test]
fn a_gigabyte_of_zeros_is_refused_at_once() {
    let folder = folder("zeros");
    for name in ["zeros.glb", "zeros.gltf"] {
        File::create(folder.join(name)).unwrap().set_len(1 << 30).unwrap();
        assert!(fail(&folder, &["simulate", name]).contains(name));
    }
}

#[test]
fn unknown_scenes_and_parameters_are_refused_in_one_line() {
    let folder = folder("unknown");
    for scene in ["nosuch", "pyramid:magic=1", "pyramid:base", "pyramid:base=x", "pyramid:base=-1"]
    {
        fail(&folder, &["simulate", scene]);
    }
}

#[test]
fn outputs_that_cannot_be_written_are_found_before_the_run() {
    let folder = folder("unwritable");
    for flag in ["--trace", "--events", "--report", "--bake"] {
        let start = Instant::now();
        let line = fail(&folder, &["simulate", "hello", "--steps", "100000000", flag, "no/x.glb"]);
        assert!(line.contains("x.glb"), "{line}");
        assert!(start.elapsed() < Duration::from_secs(5));
    }
    fs::create_dir(folder.join("folder.glb")).unwrap();
    fail(&folder, &["simulate", "hello", "--bake", "folder.glb"]);
}

#[test]
fn the_scene_itself_is_not_overwritten() {
    let folder = folder("overwrite");
    let content = scene_with(&[]);
    fs::write(folder.join("in.gltf"), &content).unwrap();
    let output = drystone(&folder, &["simulate", "in.gltf", "--bake", "./in.gltf"]);
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(fs::read_to_string(folder.join("in.gltf")).unwrap(), content);
}

#[test]
fn the_hash_depends_neither_on_outputs_nor_on_threads() {
    let folder = folder("hash");
    let run = |name: &str, more: &[&str]| {
        let report = format!("{name}.json");
        let mut args = vec!["simulate", "pyramid:base=6", "--steps", "130", "--report", &report];
        args.extend_from_slice(more);
        succeed(&folder, &args);
        json(&folder.join(&report))
    };
    let plain = run("plain", &["--threads", "1"]);
    let outputs = ["--trace", "t.csv", "--events", "e.jsonl", "--bake", "b.glb", "--threads", "1"];
    for other in [run("outputs", &outputs), run("threads", &["--threads", "2"])] {
        for key in
            ["hash", "hashes", "contacts", "energy", "penetration", "momentum_drift", "asleep_end"]
        {
            assert_eq!(plain[key], other[key], "{key}");
        }
    }
    assert!(fs::metadata(folder.join("b.glb")).unwrap().len() > 100);
    let steps: Vec<u64> =
        plain["hashes"].as_array().unwrap().iter().map(|row| row[0].as_u64().unwrap()).collect();
    assert_eq!(steps, [60, 120]);
}

#[test]
fn the_report_has_every_key() {
    let folder = folder("report");
    let page = succeed(
        &folder,
        &["simulate", "hello", "--seconds", "0.5", "--hz", "120", "--report", "r.json"],
    );
    let report = json(&folder.join("r.json"));
    for pointer in [
        "/scene",
        "/method",
        "/hz",
        "/substeps",
        "/threads",
        "/simd",
        "/steps",
        "/bodies/static",
        "/bodies/kinematic",
        "/bodies/dynamic",
        "/shapes",
        "/joints",
        "/wall_ms/total",
        "/wall_ms/step_mean",
        "/wall_ms/step_median",
        "/wall_ms/step_p99",
        "/stages_ms",
        "/contacts/mean",
        "/contacts/max",
        "/energy/kinetic_start",
        "/energy/kinetic_end",
        "/energy/potential_start",
        "/energy/potential_end",
        "/energy/total_max",
        "/momentum_drift",
        "/penetration/max",
        "/penetration/p99",
        "/penetration/end_max",
        "/joint_error/max",
        "/joint_error/p99",
        "/asleep_end",
        "/audit/energy/elastic",
        "/audit/momentum/about_center",
        "/audit/penetration/p99",
        "/audit/joints/linear",
        "/audit/residual/relative",
        "/audit/non_finite",
        "/audit/awake",
        "/hash",
        "/hashes",
        "/faults",
        "/ignored",
    ] {
        let value = report.pointer(pointer);
        assert!(value.is_some_and(|v| !v.is_null()), "{pointer} is missing: {report}");
    }
    assert_eq!(
        (report["steps"].as_u64(), report["method"].as_str()),
        (Some(60), Some("soft-step"))
    );
    let hash = report["hash"].as_str().unwrap();
    assert!(hash.len() == 16 && hash.chars().all(|c| c.is_ascii_hexdigit()), "{hash}");
    assert!(page.contains(hash), "the page must show the hash:\n{page}");
    assert!(report["stages_ms"].as_object().unwrap().len() > 1);
}

#[test]
fn an_audit_says_what_is_awake_and_where_the_energy_went() {
    let folder = folder("audit");
    fs::write(folder.join("in.gltf"), scene_with(&[])).unwrap();
    let simulate = |flags: &[&str]| {
        let args = ["simulate", "in.gltf", "--steps", "10", "--report", "r.json"];
        let page = succeed(&folder, &[&args, flags].concat());
        (page, json(&folder.join("r.json")))
    };
    let (plain, without) = simulate(&[]);
    let (page, with) = simulate(&["--audit"]);
    assert_eq!(with["hash"], without["hash"], "an audit changes nothing");
    assert!(without["audit"]["ledger"].is_null() && !plain.contains("residual"), "{plain}");
    let ledger = &with["audit"]["ledger"];
    assert_eq!(ledger["steps"].as_u64(), Some(10));
    // A free fall: nothing comes in and nothing is lost.
    let value = |key: &str| ledger[key].as_f64().unwrap();
    assert!((value("start") - value("now")).abs() < 1.0e-5 * value("start"), "{ledger}");
    assert!(page.contains("'a \"box\", falling': it moves at"), "{page}");
    for subject in ["audit ", "ledger ", "momentum ", "spin ", "overlap ", "residual ", "awake "] {
        assert!(page.lines().any(|line| line.starts_with(subject)), "{subject} is missing: {page}");
    }
    let awake = &with["audit"]["awake"][0];
    assert_eq!(awake["path"], serde_json::json!(["a \"box\", falling"]));
}

#[test]
fn the_trace_has_a_row_for_every_body_and_kept_step() {
    let folder = folder("trace");
    fs::write(folder.join("in.gltf"), scene_with(&[])).unwrap();
    succeed(&folder, &["simulate", "in.gltf", "--steps", "10", "--trace", "t.csv", "--every", "4"]);
    let trace = fs::read_to_string(folder.join("t.csv")).unwrap();
    let mut lines = trace.lines();
    assert_eq!(lines.next(), Some("step,time,body,px,py,pz,qx,qy,qz,qw,vx,vy,vz,wx,wy,wz,asleep"));
    let mut kept = Vec::new();
    for line in lines.filter(|line| line.contains("box")) {
        let (head, rest) = line.split_once("\"a \"\"box\"\", falling\",").unwrap();
        let step: u64 = head.split(',').next().unwrap().parse().unwrap();
        let numbers: Vec<f32> = rest.split(',').map(|x| x.parse().unwrap()).collect();
        assert_eq!(numbers.len(), 14, "{line}");
        kept.push((step, numbers[1]));
    }
    assert_eq!(kept.iter().map(|k| k.0).collect::<Vec<_>>(), [0, 4, 8]);
    assert!((kept[0].1 - 1.0).abs() < 1.0e-6, "it starts where the file puts it");
    assert!(kept[1].1 < kept[0].1, "it falls");
    assert_eq!(trace.lines().count(), 1 + 3 * 2, "the floor has its rows too");
}

#[test]
fn events_are_json_lines() {
    let folder = folder("events");
    fs::write(folder.join("in.gltf"), scene_with(&[("HEIGHT", "2.0")])).unwrap();
    succeed(&folder, &["simulate", "in.gltf", "--seconds", "4", "--events", "e.jsonl"]);
    let file = fs::read_to_string(folder.join("e.jsonl")).unwrap();
    let events: Vec<Value> = file.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let first = |kind: &str| events.iter().find(|e| e["type"] == kind);
    let begin = first("contact_begin").expect("it lands");
    for key in ["step", "time", "body_a", "body_b"] {
        assert!(!begin[key].is_null(), "{begin}");
    }
    let names = [&begin["body_a"], &begin["body_b"]];
    assert!(names.iter().any(|n| *n == "floor"), "{begin}");
    assert!(names.iter().any(|n| *n == "a \"box\", falling"), "{begin}");
    let hit = first("hit").expect("it lands at 5 m/s");
    let speed = hit["speed"].as_f64().unwrap();
    assert!((4.5..6.0).contains(&speed), "sqrt(2 g 1.5 m) = 5.4 m/s: {hit}");
    assert_eq!(hit["point"].as_array().unwrap().len(), 3);
    assert_eq!(first("sleep").expect("it comes to rest")["body"], "a \"box\", falling");
}

#[test]
fn lists_and_help_are_printed() {
    let folder = folder("lists");
    let scenes = succeed(&folder, &["scenes"]);
    for name in ["hello", "pyramid", "stack"] {
        assert!(scenes.lines().any(|line| line.starts_with(name)), "{name}:\n{scenes}");
    }
    assert!(succeed(&folder, &["methods"]).contains("(default)"));
    assert!(succeed(&folder, &["--version"]).starts_with("drystone "));
    assert!(succeed(&folder, &["simulate", "--help"]).contains("Exit status"));
    fs::write(folder.join("in.gltf"), scene_with(&[])).unwrap();
    let info = succeed(&folder, &["info", "in.gltf"]);
    assert!(info.contains("1 dynamic, 1 static") && info.contains("2 box"), "{info}");
}

#[test]
fn no_step_at_all_is_a_run_too() {
    let folder = folder("none");
    succeed(&folder, &["simulate", "hello", "--steps", "0", "--trace", "t.csv", "--bake", "b.glb"]);
    assert!(fs::read_to_string(folder.join("t.csv")).unwrap().lines().count() > 1);
}

#[test]
fn bodies_that_join_late_are_traced_and_baked() {
    let folder = folder("joining");
    let out = ["--steps", "40", "--trace", "t.csv", "--bake", "b.glb"];
    succeed(&folder, &[&["simulate", "large_world:tiles=10"], &out[..]].concat());
    let trace = fs::read_to_string(folder.join("t.csv")).unwrap();
    let rows = |step: &str| trace.lines().filter(|l| l.starts_with(&format!("{step},"))).count();
    assert!(rows("0") < rows("40"), "{} rows, then {}", rows("0"), rows("40"));
}

#[test]
fn what_stands_still_is_seen_in_a_baked_file() {
    let folder = folder("still");
    succeed(&folder, &["simulate", "hello", "--steps", "5", "--bake", "b.glb"]);
    let read = |bytes: &[u8], film: bool| {
        let options = drystone_scene::gltf::Options::default();
        let loaded =
            drystone_scene::gltf::from_slice(bytes, "b.glb", Path::new(""), &options).unwrap();
        if film { drystone_scene::gltf::film(loaded).unwrap() } else { loaded.scene }
    };
    let bytes = fs::read(folder.join("b.glb")).unwrap();
    // What a film brings later than at its beginning is none of its bodies.
    let (film, scene) = (read(&bytes, true), read(&bytes, false));
    assert!(scene.bodies.len() >= 3, "a ground and two that fall");
    assert_eq!(film.bodies.len(), scene.bodies.len());
}

#[cfg(unix)]
#[test]
fn a_reader_that_has_gone_is_no_failure() {
    let folder = folder("pipe");
    let mut child = Command::new(env!("CARGO_BIN_EXE_drystone"))
        .arg("scenes")
        .current_dir(&folder)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), text(&output.stderr)), (Some(0), String::new()));
}

#[test]
fn bench_writes_rows_whose_hash_is_that_of_simulate() {
    let folder = folder("bench");
    let args = "bench --scene stack:n=4,top_mass_ratio=10,hello --threads 1,2 --steps 30 --runs 2 \
                --json rows.json";
    let shown = succeed(&folder, &args.split_whitespace().collect::<Vec<_>>());
    assert!(shown.starts_with("scene ") && shown.contains("solver"), "{shown}");
    let rows = json(&folder.join("rows.json"));
    let rows = rows.as_array().unwrap();
    assert_eq!(rows.len(), 4);
    for row in rows {
        let scene = row["scene"].as_str().unwrap();
        let simulate = ["simulate", scene, "--steps", "30", "--report", "report.json"];
        succeed(&folder, &simulate);
        let report = json(&folder.join("report.json"));
        assert_eq!(row["hash"], report["hash"], "{scene}");
        assert_eq!(row["engine"], "self");
        assert_eq!((&row["steps"], &row["runs"]), (&30.into(), &2.into()));
        assert_eq!(row["stands"].as_bool(), scene.starts_with("stack").then_some(true));
        let ms = &row["ms_per_step"];
        let [min, median, p99] = ["min", "median", "p99"].map(|key| ms[key].as_f64().unwrap());
        assert!(min > 0.0 && min <= median && median <= p99, "{ms}");
        assert!(row["stages_ms"]["solver"].as_f64().unwrap() > 0.0);
        assert!(row["max_penetration"].as_f64().unwrap() < 0.02, "{scene}");
    }
    // To stdout there are the rows alone.
    let rows = succeed(
        &folder,
        &["bench", "--scene", "hello", "--steps", "2", "--runs", "1", "--json", "-"],
    );
    let rows: Value = serde_json::from_str(&rows).unwrap();
    assert_eq!(rows.as_array().unwrap().len(), 2);
}

#[test]
fn bench_tells_what_threads_gain() {
    let folder = folder("bench_scaling");
    let args = ["bench", "--scene", "stack:n=4", "--scaling", "--threads", "2,3", "--steps", "9"];
    let shown = succeed(&folder, &args);
    succeed(&folder, &["simulate", "stack:n=4", "--steps", "9", "--report", "report.json"]);
    let hash = json(&folder.join("report.json"))["hash"].as_str().unwrap().to_owned();
    assert_eq!(shown.matches(&hash).count(), 2, "{shown}");
    let line = fail(&folder, &["bench", "--scaling", "--threads", "1"]);
    assert!(line.contains("above 1"), "{line}");
    let args = ["bench", "--scaling", "--json", "rows.json"];
    assert_eq!(drystone(&folder, &args).status.code(), Some(2));
}

#[test]
fn bench_refuses_what_it_cannot_measure() {
    let folder = folder("bench_refused");
    let line = fail(&folder, &["bench", "--scene", "stak"]);
    assert!(line.contains("stak") && line.contains("stack"), "{line}");
    let line = fail(&folder, &["bench", "--scene", "stack:n=0"]);
    assert!(line.contains("stack:n=0") && line.contains("1 to 10000"), "{line}");
    let line = fail(&folder, &["bench", "--scene", "hello,"]);
    assert!(line.contains("no name"), "{line}");
    let line = fail(&folder, &["bench", "--scene", "hello", "--json", "no/such/rows.json"]);
    assert!(line.contains("no/such/rows.json"), "{line}");
    for args in [["bench", "--steps", "1"], ["bench", "--runs", "0"], ["bench", "--threads", "0"]] {
        assert_eq!(drystone(&folder, &args).status.code(), Some(2), "{args:?}");
    }
}

#[test]
fn validate_prints_its_table_and_its_exit_status_is_the_verdict() {
    // Free fall is within what it must; in gravity 100,000 times as strong a rounding of the speed is not.
    let here = folder("validate");
    let drystone = |args: &[&str]| drystone(&here, args);
    let good = drystone(&["validate", "--only", "A1,a2"]);
    assert_eq!(good.status.code(), Some(0), "{}", text(&good.stderr));
    assert!(text(&good.stdout).contains("4 rows: 4 pass"), "{}", text(&good.stdout));
    let bad = drystone(&["validate", "--only", "A1", "--set", "gravity=0,-1e6,0"]);
    assert_eq!(bad.status.code(), Some(1), "{}", text(&bad.stdout));
    assert!(text(&bad.stdout).contains("fail"), "{}", text(&bad.stdout));
    for (flag, sign) in
        [("--json", "\"passes_must\": true"), ("--csv", "A1,\"free fall"), ("--markdown", "| A1 |")]
    {
        let out = drystone(&["validate", "--only", "A1", flag]);
        assert!(out.status.success() && text(&out.stdout).contains(sign), "{flag}");
    }
    for usage in [
        &["validate", "--only", "A999"][..],
        &["validate", "--only", "A44b"],
        &["validate", "--set", "gravity=x"],
        &["validate", "--json", "--csv"],
        &["validate", "--sweep", "--csv"],
    ] {
        assert_eq!(drystone(usage).status.code(), Some(2), "{usage:?}");
    }
}

#[test]
fn compare_writes_a_row_a_run_with_the_hash_of_simulate_and_says_what_does_not_go_together() {
    let folder = folder("compare");
    let args = "compare stack:n=3 --steps 30 --with soft-step --with guendelman \
                --with sequential-impulses:method.sweeps=4,method.persistence=off \
                --with penalty:penalty.hertz=500 --json a.json --csv a.csv --svg a.svg --png a.png";
    let shown = succeed(&folder, &args.split_whitespace().collect::<Vec<_>>());
    assert!(shown.contains("limit of stability"), "{shown}");
    let whole = json(&folder.join("a.json"));
    let runs = whole["runs"].as_array().unwrap();
    assert_eq!(runs.len(), 4);
    for (run, method) in runs.iter().zip(["soft-step", "guendelman"]) {
        let simulate =
            ["simulate", "stack:n=3", "--steps", "30", "--method", method, "--report", "r.json"];
        succeed(&folder, &simulate);
        assert_eq!(run["hash"], json(&folder.join("r.json"))["hash"], "{method}");
        assert_eq!(run["stands"], true);
    }
    assert_eq!(runs[0]["sweeps"].as_f64(), Some(9.0));
    assert_eq!(runs[2]["sweeps"].as_f64(), Some(4.0));
    assert_eq!(fs::read_to_string(folder.join("a.csv")).unwrap().lines().count(), 5);
    assert!(fs::read_to_string(folder.join("a.svg")).unwrap().contains("polyline"));
    assert!(fs::read(folder.join("a.png")).unwrap().starts_with(b"\x89PNG"));
    for (with, says) in [
        ("magic", "guendelman"),
        ("soft-step:method.order=levels", "eight at a time"),
        ("verlet:method.overlap=relax", "projection"),
        ("naive:method.persistence=on", "not accumulated"),
        ("naive:sweeps", "KEY=VALUE"),
    ] {
        let output = drystone(&folder, &["compare", "stack", "--with", with]);
        let line = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{with}: {line}");
        assert!(line.contains(says) && line.lines().count() == 1, "{with}: {line}");
    }
}

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

#[test]
fn pieces_of_what_breaks_have_names_rows_and_nodes_from_when_they_come() {
    let folder = folder("fracture");
    let args = [
        "simulate",
        "fracture:pieces=10",
        "--seconds",
        "2.5",
        "--bake",
        "f.glb",
        "--trace",
        "t.csv",
    ];
    succeed(&folder, &[&args[..], &["--events", "e.jsonl", "--threads", "2"]].concat());

    // Who broke when, into what.
    let lines = fs::read_to_string(folder.join("e.jsonl")).unwrap();
    let events: Vec<Value> = lines.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    let broken: Vec<&Value> = events.iter().filter(|e| e["type"] == "fracture").collect();
    for body in ["block", "rock", "pane"] {
        assert!(broken.iter().any(|e| e["body"] == body), "{body}: {broken:?}");
    }
    let mut rows = std::collections::BTreeMap::<String, Vec<u64>>::new();
    for row in fs::read_to_string(folder.join("t.csv")).unwrap().lines().skip(1) {
        let mut cells = row.split(',');
        let (step, _, body) = (cells.next().unwrap(), cells.next(), cells.next().unwrap());
        rows.entry(body.to_owned()).or_default().push(step.parse().unwrap());
    }
    for event in &broken {
        assert!(event["value"].as_f64() > event["limit"].as_f64(), "{event}");
        let step = event["step"].as_u64().unwrap();
        let own = &rows[event["body"].as_str().unwrap()];
        assert_eq!(own.last(), Some(&(step - 1)), "{event}");
        let pieces = event["pieces"].as_array().unwrap();
        assert!(pieces.len() > 1, "{event}");
        for piece in pieces {
            let name = piece.as_str().unwrap();
            assert!(name.contains(" piece "), "{name}");
            assert_eq!(rows[name].first(), Some(&step), "{name}");
        }
    }

    // The baked file: each piece is a node without size at first, the whole body one without size at last.
    let file = fs::read(folder.join("f.glb")).unwrap();
    let length = u32::from_le_bytes(file[12..16].try_into().unwrap()) as usize;
    let json: Value = serde_json::from_slice(&file[20..20 + length]).unwrap();
    let binary = &file[20 + length + 8..];
    let animation = &json["animations"][0];
    let number = |of: &Value| usize::try_from(of.as_u64().unwrap_or(0)).unwrap();
    let scales_of = |name: &str| -> Vec<f32> {
        let nodes = json["nodes"].as_array().unwrap();
        let node = nodes.iter().position(|n| n["name"] == name).unwrap_or_else(|| panic!("{name}"));
        let mut channels = animation["channels"].as_array().unwrap().iter();
        let channel = channels
            .find(|c| c["target"]["node"] == node && c["target"]["path"] == "scale")
            .unwrap_or_else(|| panic!("{name}"));
        let sampler = &animation["samplers"][number(&channel["sampler"])];
        assert_eq!(sampler["interpolation"], "STEP");
        let accessor = &json["accessors"][number(&sampler["output"])];
        let view = &json["bufferViews"][number(&accessor["bufferView"])];
        let from = number(&view["byteOffset"]) + number(&accessor["byteOffset"]);
        let bytes = &binary[from..from + 12 * number(&accessor["count"])];
        bytes.chunks_exact(12).map(|b| f32::from_le_bytes(b[..4].try_into().unwrap())).collect()
    };
    for event in &broken {
        for piece in event["pieces"].as_array().unwrap() {
            let scales = scales_of(piece.as_str().unwrap());
            assert!(scales[0].abs() < 1e-9 && (scales[1] - 1.0).abs() < 1e-6, "{scales:?}");
        }
    }
    let pane = scales_of("pane");
    assert!((pane[0] - 1.0).abs() < 1e-6 && pane[1].abs() < 1e-9, "{pane:?}");
    // Read back as physics, there are the bodies of the scene and no pieces.
    let info = succeed(&folder, &["info", "f.glb"]);
    assert!(info.contains("4 dynamic"), "{info}");
}

#[test]
fn a_glued_wall_loses_bricks_and_goes_on_under_its_name() {
    let folder = folder("glued");
    let args = ["simulate", "wrecking_ball:bond=1", "--seconds", "3", "--bake", "w.glb"];
    succeed(
        &folder,
        &[&args[..], &["--trace", "t.csv", "--events", "e.jsonl", "--every", "20"]].concat(),
    );
    let lines = fs::read_to_string(folder.join("e.jsonl")).unwrap();
    assert!(lines.contains("\"type\":\"bond_break\""), "{lines}");
    assert!(lines.contains("\"cause\":\"glue\""), "{lines}");
    let trace = fs::read_to_string(folder.join("t.csv")).unwrap();
    assert!(trace.contains(",wall piece 1,"));
    assert!(trace.lines().last().is_some_and(|l| l.starts_with("180,")), "to the end");
    assert!(trace.lines().any(|l| l.starts_with("180,3.0,wall,")), "the largest part is the wall");
}

/// The lines of a trace from a step on, below the header.
fn lines_from(trace: &Path, step: u64) -> Vec<String> {
    let text = fs::read_to_string(trace).unwrap();
    let is_later = |line: &&str| {
        let number = line.split(',').next().and_then(|n| n.parse::<u64>().ok());
        number.is_some_and(|n| n >= step)
    };
    text.lines().filter(is_later).map(str::to_owned).collect()
}

#[test]
fn a_run_goes_on_from_its_snapshot_as_if_it_had_not_been_interrupted() {
    let folder = folder("snapshot");
    fs::write(folder.join("box.gltf"), scene_with(&[])).unwrap();
    let run = |args: &str| succeed(&folder, &args.split(' ').collect::<Vec<_>>());
    for scene in ["wrecking_ball", "box.gltf"] {
        run(&format!("simulate {scene} --steps 90 --trace whole.csv --report whole.json"));
        run(&format!("simulate {scene} --steps 60 --snapshot at60.run --threads 1"));
        let told =
            run("simulate --resume at60.run --steps 30 --trace rest.csv --report rest.json \
             --snapshot at60.run --threads 2");
        assert!(told.contains("after 60 before"), "{told}");
        assert_eq!(
            lines_from(&folder.join("rest.csv"), 0),
            lines_from(&folder.join("whole.csv"), 60),
            "{scene}"
        );
        let [whole, rest] = ["whole.json", "rest.json"].map(|name| json(&folder.join(name)));
        assert_eq!(whole["hash"], rest["hash"], "{scene}");
        assert_eq!((rest["steps"].as_u64(), rest["from_step"].as_u64()), (Some(30), Some(60)));
        // The snapshot was replaced by one of step 90.
        let told =
            run(&format!("simulate --resume at60.run {scene} --steps 0 --set gravity=0,0,0"));
        assert!(told.contains("after 90 before"), "{told}");
    }

    let snapshot = fs::read(folder.join("at60.run")).unwrap();
    fs::write(folder.join("cut.run"), &snapshot[..snapshot.len() / 2]).unwrap();
    let mut changed = snapshot.clone();
    changed[snapshot.len() / 2] ^= 16;
    fs::write(folder.join("changed.run"), changed).unwrap();
    fs::write(folder.join("at60.json"), "{}").unwrap();
    for (args, why) in [
        ("cut.run", "cut off or changed"),
        ("changed.run", "cut off or changed"),
        ("at60.json", "is no snapshot"),
        ("missing.run", "cannot be read"),
        ("at60.run pyramid", "of another scene than pyramid"),
    ] {
        let line =
            fail(&folder, &format!("simulate --resume {args}").split(' ').collect::<Vec<_>>());
        assert!(line.contains(why), "{line}");
    }
    fs::remove_file(folder.join("box.gltf")).unwrap();
    let line = fail(&folder, &["simulate", "--resume", "at60.run"]);
    assert!(line.contains("box.gltf: no such file"), "{line}");
}

#[test]
fn a_journal_that_a_program_wrote_is_replayed() {
    use drystone::journal::{Call, Journal};
    use drystone::{BodyDef, ShapeDef, World};
    let folder = folder("journal");
    let mut world = World::default();
    let mut journal = Journal::begin(&world);
    let ball = BodyDef::dynamic().with_shape(ShapeDef::sphere(0.5));
    journal.call(&mut world, Call::AddBody(Box::new(ball))).unwrap();
    for _ in 0..3 {
        journal.call(&mut world, Call::Step(1.0 / 60.0)).unwrap();
    }
    let bytes = journal.to_bytes();
    fs::write(folder.join("ball.journal"), &bytes).unwrap();
    let told = succeed(&folder, &["replay", "ball.journal", "--threads", "2"]);
    assert!(told.contains("4 calls made again, 3 steps of them, every bit the same"), "{told}");
    fs::write(folder.join("cut.journal"), &bytes[..bytes.len() - 1]).unwrap();
    let line = fail(&folder, &["replay", "cut.journal"]);
    assert!(line.contains("cut.journal: the journal was cut off or changed"), "{line}");
}

#[test]
fn a_recorded_run_is_replayed_and_told_where_it_goes_another_way() {
    let folder = folder("record");
    let run = |args: &str| succeed(&folder, &args.split(' ').collect::<Vec<_>>());
    run("simulate wall:ball=1 --steps 40 --record run.log --threads 1");
    let told = run("replay run.log --threads 2");
    assert!(told.contains("40 steps run again, every bit the same"), "{told}");
    // From a snapshot, with other settings.
    run("simulate wall:ball=1 --steps 20 --snapshot at20.run");
    run("simulate --resume at20.run --steps 20 --set gravity=1,0,0 --record later.log");
    assert!(run("replay later.log").contains("20 steps run again"));

    // The same start, but another mass: it shows where the box meets the floor.
    fs::write(folder.join("box.gltf"), scene_with(&[])).unwrap();
    run("simulate box.gltf --steps 60 --record box.log");
    assert!(run("replay box.log").contains("60 steps run again"));
    fs::write(folder.join("box.gltf"), scene_with(&[("MASS", "2.0")])).unwrap();
    let line = fail(&folder, &["replay", "box.log"]);
    assert!(line.contains("stage solver") && line.contains("'a \"box\", falling'"), "{line}");
    fs::write(folder.join("box.gltf"), scene_with(&[("HEIGHT", "1.5")])).unwrap();
    let line = fail(&folder, &["replay", "box.log"]);
    assert!(line.contains("before the first step"), "{line}");

    let log = fs::read(folder.join("run.log")).unwrap();
    assert!(!told.contains("cut off"), "{told}");
    // The end, with its head of 12 bytes, tells of 40 steps.
    let end = 12 + 1 + "whole log".len() + 1;
    for (cut, steps) in [(3, 40), (end, 40), (end + 3, 39)] {
        fs::write(folder.join("cut.log"), &log[..log.len() - cut]).unwrap();
        let told = run("replay cut.log");
        assert!(told.contains(&format!("{steps} steps run again, every bit the same")), "{told}");
        assert!(told.contains("the log is cut off there"), "{told}");
    }
    fs::write(folder.join("short.log"), &log[..40]).unwrap();
    assert!(fail(&folder, &["replay", "short.log"]).contains("cut off or changed"));
    assert!(fail(&folder, &["replay", "at20.run"]).contains("is no log"));
}
