//! Commands that measure: `bench`, `validate`, `compare`.

use std::fs;

use crate::command::{drystone, text};
use crate::common::folder;
use serde_json::Value;

use crate::running::{fail, json, succeed};

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
    // Free fall is within what it must; in gravity 100,000 times as strong a rounding of the speed
    // is not.
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
