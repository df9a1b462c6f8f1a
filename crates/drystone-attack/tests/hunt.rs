//! Tests of the hunt as a program: its arguments and its output.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::process::{Command, Output};

fn program(args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_drystone-attack"));
    command.arg("hunt").args(args);
    command.args(["--root", concat!(env!("CARGO_MANIFEST_DIR"), "/../..")]);
    command.output().unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[test]
fn a_world_runs_again_as_it_ran_before() {
    for seed in ["drops:12", "chains:3", "gates:5"] {
        let (first, second) = (program(&["repeat", seed]), program(&["repeat", seed]));
        assert!(matches!(first.status.code(), Some(0 | 1)), "{seed}: {first:?}");
        assert_eq!(said(&first), said(&second));
        assert!(said(&first).contains("tried 1"), "{}", said(&first));
    }
}

#[test]
fn a_counted_campaign_is_of_the_same_worlds_however_many_work() {
    let table = |jobs: &str| {
        let name = format!("drystone-hunt-{jobs}-{}", std::process::id());
        let out = std::env::temp_dir().join(name);
        let words = ["--worlds", "12", "--only", "gates,shots", "--jobs", jobs, "--out"];
        let output = program(&[&words[..], &[out.to_str().unwrap()]].concat());
        std::fs::remove_dir_all(&out).unwrap();
        let text = said(&output);
        assert!(text.contains("| gates | 6 |") && text.contains("| shots | 6 |"), "{text}");
        text.lines().filter(|line| line.starts_with("| ")).map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(table("1"), table("2"));
}

#[test]
fn what_is_not_understood_is_told_with_the_usage() {
    for args in [&["--only", "walls"][..], &["repeat", "x"], &["minimize", "worlds:3"], &["dance"]]
    {
        let output = program(args);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{args:?}: {text}");
        assert!(text.contains("usage: cargo xtask hunt"), "{text}");
    }
}
