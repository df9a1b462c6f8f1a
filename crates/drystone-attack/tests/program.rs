//! Tests of the program: its arguments and its output.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::path::PathBuf;
use std::process::{Command, Output};

fn program(args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_drystone-attack"));
    command.args(args).args(["--root", concat!(env!("CARGO_MANIFEST_DIR"), "/../..")]);
    command.output().unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn folder(name: &str) -> PathBuf {
    std::env::temp_dir().join(format!("drystone-attack-{name}-{}", std::process::id()))
}

#[test]
fn a_seed_runs_again_as_it_ran_before() {
    for seed in ["worlds:12", "files:3", "snapshots:5"] {
        let (first, second) = (program(&["repeat", seed]), program(&["repeat", seed]));
        assert!(matches!(first.status.code(), Some(0 | 1)), "{seed}: {first:?}");
        assert_eq!(said(&first), said(&second));
        assert!(said(&first).contains("tried"), "{}", said(&first));
    }
}

#[test]
fn a_campaign_counts_what_it_tried_and_writes_what_it_found() {
    let out = folder("out");
    let words =
        ["--worlds", "12", "--jobs", "2", "--only", "worlds", "--out", out.to_str().unwrap()];
    let output = program(&words);
    let text = said(&output);
    assert!(text.contains("| worlds | 1") && text.contains("worlds/s"), "{text}");
    let files = std::fs::read_dir(&out).unwrap().count();
    assert_eq!(text.contains("nothing found"), files == 0, "{text}");
    let lines = text.lines().filter(|line| line.contains(" x ") && !line.ends_with("(known)"));
    assert_eq!(output.status.code(), Some(i32::from(lines.count() > 0)), "{text}");
    std::fs::remove_dir_all(&out).unwrap();
}

#[test]
fn what_is_not_understood_is_told_with_the_usage() {
    for args in [&["--seconds", "x"][..], &["--only", "walls"], &["repeat", "x"], &["dance"]] {
        let output = program(args);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{args:?}: {text}");
        assert!(
            text.starts_with("error: ") && text.contains("usage: cargo xtask attack"),
            "{text}"
        );
    }
}

#[test]
fn the_source_of_a_program_has_no_number_that_rust_does_not_read() {
    for seed in 0..40 {
        let output = program(&["source", &format!("worlds:{seed}")]);
        let text = said(&output);
        assert!(text.contains("let mut world = World::new(config).unwrap();"), "{text}");
        assert!(!text.contains(": NaN") && !text.contains(": inf"), "{text}");
    }
}
