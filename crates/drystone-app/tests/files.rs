//! Files that the command leaves on disk, however it ends: they are whole or not there.

#![cfg(unix)]
#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod common;

use std::fs::{self, File};
use std::io::{Read, Write};
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::Duration;

use serde_json::Value;

/// An empty folder for one test.
fn folder(name: &str) -> PathBuf {
    common::folder(&format!("files/{name}"))
}

/// The command in `folder`, with arguments separated by spaces.
fn command(folder: &Path, args: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_drystone"));
    command.args(args.split_whitespace()).current_dir(folder);
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
    command
}

fn run(folder: &Path, args: &str) -> Output {
    command(folder, args).output().unwrap()
}

fn succeed(folder: &Path, args: &str) {
    let output = run(folder, args);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!((output.status.code(), &*said), (Some(0), ""), "{args}");
}

/// Runs the command, which must fail with status 1 and one line; returns the line.
fn fail(output: &Output) -> String {
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.starts_with("error: ") && said.lines().count() == 1, "{said}");
    said
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> =
        entries.map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// Waits until a file is there, which the command makes.
fn wait_for(path: &Path, child: &mut Child) {
    for _ in 0..2000 {
        if path.exists() {
            return;
        }
        assert!(child.try_wait().unwrap().is_none(), "it ended before it made {}", path.display());
        sleep(Duration::from_millis(5));
    }
    let _ = child.kill();
    assert!(path.exists(), "{} was never made", path.display());
}

fn interrupt(child: &Child) {
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
}

/// All that a run writes without graphics.
const OUTPUTS: &str = "--trace t.csv --events e.jsonl --record r.log --snapshot s.run \
                       --bake b.glb --report p.json --threads 1";
const FILES: [&str; 6] = ["b.glb", "e.jsonl", "p.json", "r.log", "s.run", "t.csv"];

#[test]
fn a_run_that_is_killed_leaves_old_files_or_new_ones_and_never_a_part() {
    let folder = folder("killed");
    let read = || FILES.map(|name| fs::read(folder.join(name)).unwrap());
    succeed(&folder, &format!("simulate wall:ball=1 --steps 120 {OUTPUTS}"));
    let new = read();
    succeed(&folder, &format!("simulate hello --steps 20 {OUTPUTS}"));
    let old = read();
    // From the first millisecond to beyond the end of the run.
    for k in 0..30_u64 {
        let mut child = command(&folder, &format!("simulate wall:ball=1 --steps 120 {OUTPUTS}"))
            .spawn()
            .unwrap();
        sleep(Duration::from_millis(k * k / 2));
        child.kill().unwrap();
        child.wait().unwrap();
        for (i, bytes) in read().iter().enumerate() {
            if FILES[i] == "p.json" {
                // It has times, so no two are the same.
                assert!(serde_json::from_slice::<Value>(bytes).is_ok(), "round {k}");
            } else {
                assert!(*bytes == old[i] || *bytes == new[i], "round {k}: {}", FILES[i]);
            }
        }
    }
    succeed(&folder, &format!("simulate wall:ball=1 --steps 120 {OUTPUTS}"));
    assert_eq!(names(&folder), FILES, "the next run takes what killed ones left");
    assert!(read()[5] == new[5]);
}

#[test]
fn a_full_disk_is_told_and_leaves_the_old_files() {
    let folder = folder("full");
    succeed(&folder, &format!("simulate hello --steps 5 {OUTPUTS}"));
    let old = FILES.map(|name| fs::read(folder.join(name)).unwrap());
    let flags = [
        ("--trace t.csv", "t.csv"),
        ("--events e.jsonl", "e.jsonl"),
        ("--record r.log", "r.log"),
        ("--snapshot s.run", "s.run"),
        ("--bake b.glb", "b.glb"),
        ("--report p.json", "p.json"),
    ];
    let program = env!("CARGO_BIN_EXE_drystone");
    for (flag, name) in flags {
        // Files of at most one block, and no signal beyond that: a write fails as on a full disk.
        let line = format!(
            "ulimit -f 1; trap '' XFSZ; exec {program} simulate wall:ball=1 --steps 200 {flag}"
        );
        let mut shell = Command::new("sh");
        shell.args(["-c", &line]).current_dir(&folder).stdout(Stdio::null());
        let said = fail(&shell.output().unwrap());
        assert!(said.starts_with(&format!("error: {name}: cannot be written: ")), "{said}");
        if name != "b.glb" {
            let line = format!("simulate hello --steps 5 {flag}").replace(name, "/dev/full");
            let said = fail(&run(&folder, &line));
            assert!(said.starts_with("error: /dev/full: cannot be written: "), "{said}");
        }
    }
    assert_eq!(names(&folder), FILES, "nothing is left beside them");
    assert!(FILES.iter().zip(&old).all(|(name, old)| fs::read(folder.join(name)).unwrap() == *old));
}

#[test]
fn a_full_file_system_is_told_and_leaves_the_old_files() {
    let folder = folder("tmpfs");
    let program = env!("CARGO_BIN_EXE_drystone");
    // In a namespace of its own, so that the mount goes with it.
    let line = format!(
        "mount -t tmpfs -o size=200k tmpfs . && cd \"$PWD\" && echo old > t.csv || exit 77; \
         {program} simulate wall:ball=1 --steps 200 --trace t.csv; \
         test $? = 1 && test \"$(cat t.csv)\" = old && test \"$(ls -A)\" = t.csv || exit 78"
    );
    let output =
        Command::new("unshare").args(["-m", "sh", "-c", &line]).current_dir(&folder).output();
    let Some(output) = output.ok().filter(|o| ![Some(77), Some(1)].contains(&o.status.code()))
    else {
        eprintln!("SKIPPED: nothing can be mounted here");
        return;
    };
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        output.status.success(),
        "the old file is gone, or something is left beside it: {said}"
    );
    assert!(said.contains("t.csv: cannot be written: No space left"), "{said}");
}

#[test]
fn ctrl_c_ends_a_run_early_with_whole_files() {
    let folder = folder("interrupted");
    let mut child =
        command(&folder, &format!("simulate wall:ball=1 --seconds 1e6 {OUTPUTS}")).spawn().unwrap();
    wait_for(&folder.join(".p.json.partial"), &mut child);
    sleep(Duration::from_millis(100));
    interrupt(&child);
    assert_eq!(child.wait().unwrap().code(), Some(0));
    assert_eq!(names(&folder), FILES);
    let report: Value = serde_json::from_slice(&fs::read(folder.join("p.json")).unwrap()).unwrap();
    let events = fs::read_to_string(folder.join("e.jsonl")).unwrap();
    let last: Value = serde_json::from_str(events.lines().last().unwrap()).unwrap();
    assert_eq!((&last["type"], &last["step"]), (&Value::from("end"), &report["steps"]));
    assert_eq!(last["lines"], events.lines().count() - 1);
    let replayed = command(&folder, "replay r.log").stdout(Stdio::piped()).output().unwrap();
    let said = String::from_utf8_lossy(&replayed.stdout).into_owned();
    assert!(
        said.contains(&format!("{} steps", report["steps"])) && !said.contains("cut"),
        "{said}"
    );
    succeed(&folder, "simulate --resume s.run --steps 1");
}

#[test]
fn ctrl_c_at_any_moment_leaves_no_file_emptied_and_none_beside() {
    let folder = folder("early");
    succeed(&folder, &format!("simulate hello --steps 5 {OUTPUTS}"));
    for k in 0..12 {
        let line = format!("simulate wall:ball=1 --seconds 1e6 {OUTPUTS}");
        let mut child = command(&folder, &line).spawn().unwrap();
        sleep(Duration::from_millis(k));
        interrupt(&child);
        child.wait().unwrap();
        assert_eq!(names(&folder), FILES, "round {k}");
        assert!(FILES.iter().all(|name| fs::metadata(folder.join(name)).unwrap().len() > 0));
    }
}

#[test]
fn ctrl_c_ends_a_comparison_and_leaves_the_old_file() {
    let folder = folder("compared");
    fs::write(folder.join("j.json"), "old").unwrap();
    let line = "compare stack:n=20 --seconds 1e6 --json j.json";
    let mut child = command(&folder, line).spawn().unwrap();
    wait_for(&folder.join(".j.json.partial"), &mut child);
    interrupt(&child);
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert_eq!(names(&folder), ["j.json"]);
    assert_eq!(fs::read(folder.join("j.json")).unwrap(), b"old");
}

#[test]
fn links_permissions_and_pipes_are_what_they_were() {
    let folder = folder("kinds");
    fs::create_dir(folder.join("to")).unwrap();
    fs::write(folder.join("to/t"), "old").unwrap();
    fs::set_permissions(folder.join("to/t"), fs::Permissions::from_mode(0o600)).unwrap();
    symlink("to/t", folder.join("t")).unwrap();
    succeed(&folder, "simulate hello --steps 2 --trace t");
    let trace = fs::read_to_string(folder.join("to/t")).unwrap();
    assert!(trace.starts_with("step,time,body"));
    assert!(fs::symlink_metadata(folder.join("t")).unwrap().is_symlink());
    assert_eq!(fs::metadata(folder.join("to/t")).unwrap().permissions().mode() & 0o777, 0o600);
    assert_eq!(names(&folder.join("to")), ["t"]);

    assert!(Command::new("mkfifo").arg(folder.join("pipe")).status().unwrap().success());
    let mut child = command(&folder, "simulate hello --steps 2 --trace pipe").spawn().unwrap();
    let mut through = String::new();
    File::open(folder.join("pipe")).unwrap().read_to_string(&mut through).unwrap();
    assert!(child.wait().unwrap().success());
    assert_eq!(through, trace);

    let output = command(&folder, "simulate hello --steps 2 --trace /dev/stdout")
        .stdout(Stdio::piped())
        .output()
        .unwrap();
    assert!(String::from_utf8_lossy(&output.stdout).starts_with(&trace));
}

#[test]
fn an_old_file_in_a_folder_that_takes_no_new_one_is_written_over_with_a_warning() {
    let folder = folder("closed");
    let inner = folder.join("inner");
    fs::create_dir(&inner).unwrap();
    fs::write(inner.join("t.csv"), "old").unwrap();
    fs::set_permissions(&inner, fs::Permissions::from_mode(0o555)).unwrap();
    if File::create(inner.join("probe")).is_ok() {
        eprintln!("SKIPPED: an administrator may write everywhere");
        return;
    }
    let output = run(&folder, "simulate hello --steps 2 --trace inner/t.csv");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && said.starts_with("warning: inner/t.csv: "), "{said}");
    assert!(fs::read_to_string(inner.join("t.csv")).unwrap().starts_with("step,time"));
    assert!(
        fail(&run(&folder, "simulate hello --trace inner/new.csv")).contains("cannot be written")
    );
    fs::set_permissions(&inner, fs::Permissions::from_mode(0o755)).unwrap();
}

#[test]
fn readers_stop_at_what_is_not_theirs_and_take_pipes() {
    let folder = folder("read");
    let zero = fail(&run(&folder, "replay /dev/zero"));
    assert!(zero.contains("/dev/zero: is no log"), "{zero}");
    assert!(fail(&run(&folder, "simulate --resume /dev/zero")).contains("is no snapshot"));
    assert!(fail(&run(&folder, "validate --known /dev/zero")).contains("up to 16 MB"));
    succeed(&folder, "simulate hello --steps 3 --snapshot s.run");
    let mut child = command(&folder, "simulate --resume /dev/stdin --steps 1")
        .stdin(Stdio::piped())
        .spawn()
        .unwrap();
    let bytes = fs::read(folder.join("s.run")).unwrap();
    child.stdin.take().unwrap().write_all(&bytes).unwrap();
    assert!(child.wait().unwrap().success());
}

#[cfg(target_os = "linux")]
#[test]
fn help_that_cannot_be_printed_is_a_failure() {
    let folder = folder("help");
    for args in ["--help", "--version", "scenes"] {
        let full = File::options().write(true).open("/dev/full").unwrap();
        let output = command(&folder, args).stdout(full).output().unwrap();
        assert!(fail(&output).contains("stdout: cannot be written"));
    }
}
