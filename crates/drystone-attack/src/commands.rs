//! Command lines of the program `drystone`, and damaged recordings and snapshots of runs.

use std::ffi::OsString;
use std::io::Read;
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use crate::damage;
use crate::finding::{Findings, Kind};
use crate::rng::Rng;
use crate::unit::{Places, Unit};

/// Time after which a command counts as hanging.
const LIMIT: Duration = Duration::from_secs(100);

/// Scenes of few bodies, with fast steps.
const SCENES: [&str; 12] = [
    "stack",
    "cradle",
    "rope",
    "cloth",
    "arch",
    "wall",
    "pyramid:base=4",
    "stack:n=3",
    "card_house",
    "jenga",
    "hail",
    "bridge",
];

/// Runs one command line.
#[must_use]
pub fn attack(seed: u64, places: &Places) -> Unit {
    let mut unit = Unit::default();
    let Some(command) = &places.command else { return unit };
    let mut rng = Rng::new(seed ^ 0x00c0_33a4);
    if std::fs::create_dir_all(&places.scratch).is_err() {
        return unit;
    }
    if rng.chance(0.35) {
        saved_runs(command, places, &mut rng, &mut unit);
    } else {
        let args = arguments(&mut rng);
        check(command, &args, &places.scratch, &mut unit);
    }
    unit
}

/// Makes a recording and a snapshot of a run, and damages both.
fn saved_runs(command: &Path, places: &Places, rng: &mut Rng, unit: &mut Unit) {
    let scene = rng.pick(&["stack:n=3", "rope", "cradle"]);
    let args = ["simulate", scene, "--steps", "4", "--record", "a.rec", "--snapshot", "a.run"];
    let args: Vec<OsString> = args.into_iter().map(OsString::from).collect();
    check(command, &args, &places.scratch, unit);
    for _ in 0..4 {
        let (name, args): (_, &[&str]) = if rng.chance(0.5) {
            ("a.rec", &["replay", "b"])
        } else {
            ("a.run", &["simulate", "--resume", "b", "--steps", "3"])
        };
        let Ok(mut bytes) = std::fs::read(places.scratch.join(name)) else { return };
        damage_chunks(&mut bytes, rng);
        if std::fs::write(places.scratch.join("b"), bytes).is_err() {
            return;
        }
        let args: Vec<OsString> = args.iter().map(OsString::from).collect();
        check(command, &args, &places.scratch, unit);
    }
}

/// Size of the title of a file in the program's format, and of the head of each chunk (length and
/// checksum).
const TITLE: usize = 12;
const HEAD: usize = 12;

/// Damages the bytes, or one of the chunks and then corrects its checksum.
fn damage_chunks(bytes: &mut Vec<u8>, rng: &mut Rng) {
    if rng.chance(0.4) || bytes.len() < TITLE {
        damage::bytes(bytes, rng);
        return;
    }
    let mut chunks = Vec::new();
    let mut rest = &bytes[TITLE..];
    while let Some((length, after)) = rest.split_first_chunk::<8>() {
        let length = usize::try_from(u64::from_le_bytes(*length)).unwrap_or(0);
        let Some(data) = after.get(HEAD - 8..HEAD - 8 + length) else { break };
        chunks.push(data.to_vec());
        rest = &after[HEAD - 8 + length..];
    }
    if chunks.is_empty() {
        return;
    }
    let at = if rng.chance(0.7) { 0 } else { rng.below(chunks.len()) };
    damage::bytes(&mut chunks[at], rng);
    if rng.chance(0.1) {
        let copy = chunks[rng.below(chunks.len())].clone();
        chunks.push(copy);
    }
    bytes.truncate(TITLE);
    for chunk in chunks {
        bytes.extend((chunk.len() as u64).to_le_bytes());
        bytes.extend(crc32fast::hash(&chunk).to_le_bytes());
        bytes.extend(chunk);
    }
}

/// Values for options, valid and invalid.
const VALUES: [&str; 40] = [
    "0",
    "1",
    "2",
    "-1",
    "60",
    "1e-3",
    "1e6",
    "1e7",
    "nan",
    "inf",
    "-inf",
    "",
    " ",
    "x",
    "ä",
    "0x10",
    "1,2",
    "1,2,3",
    "gravity=0,-1,0",
    "gravity=",
    "=",
    "sleep.enabled=false",
    "contact.hertz=nan",
    "method=verlet",
    "substeps=257",
    "sse2",
    "avx512",
    "soft-step",
    "penalty",
    "analytic",
    "a.csv",
    "a.json",
    "a.glb",
    "a.svg",
    "/dev/null",
    "/dev/full",
    "/nonexistent/a.csv",
    ".",
    "99999999999999999999",
    "--help",
];

/// A valid command line with some of its words changed.
fn arguments(rng: &mut Rng) -> Vec<OsString> {
    let scene = rng.pick(&SCENES).to_owned();
    let mut args: Vec<String> = match rng.below(7) {
        0 => vec![rng.pick(&["scenes", "methods", "--version", "--help", "help"]).to_owned()],
        1 => vec!["info".to_owned(), scene],
        3 => {
            let out = rng.pick(&["a.json", "a.glb", "a.gltf", "a.obj", "/dev/full"]).to_owned();
            vec!["convert".to_owned(), scene, out]
        }
        // It also compares with `analytic`, which is slow with many contacts.
        2 => [
            "compare",
            rng.pick(&["stack:n=3", "cradle", "rope"]),
            "--steps",
            "2",
            "--with",
            "soft-step",
            "--with",
            "naive",
        ]
        .map(str::to_owned)
        .to_vec(),
        _ => ["simulate", &scene, "--steps", "3"].map(str::to_owned).to_vec(),
    };
    let options = [
        "--hz",
        "--substeps",
        "--method",
        "--set",
        "--threads",
        "--simd",
        "--trace",
        "--every",
        "--events",
        "--bake",
        "--report",
        "--snapshot",
        "--resume",
        "--record",
        "--audit",
        "--auto-colliders",
        "--base",
        "--ground",
        "--seconds",
        "--json",
        "--csv",
        "--svg",
        "--with",
        "--stands",
        "--render",
        "--quiet",
    ];
    for _ in 0..rng.below(4) {
        args.push(rng.pick(&options).to_owned());
        if rng.chance(0.85) {
            args.push(rng.pick(&VALUES).to_owned());
        }
    }
    let mut args: Vec<OsString> = args.into_iter().map(OsString::from).collect();
    while rng.chance(0.4) {
        let at = rng.below(args.len());
        match rng.below(5) {
            0 => {
                args.remove(at);
            }
            1 => {
                let copy = args[at].clone();
                args.insert(at, copy);
            }
            2 => args[at] = OsString::from(rng.pick(&VALUES)),
            3 => args[at] = strange(rng),
            _ => {
                let other = rng.below(args.len());
                args.swap(at, other);
            }
        }
        if args.is_empty() {
            break;
        }
    }
    // The default length of a scene, all benchmarks, or a window would take far too long.
    let long = ["view", "bench", "validate"];
    args.retain(|arg| long.iter().all(|word| arg != word));
    // A run of that length would not be a hang.
    for i in 1..args.len() {
        let is_length = ["--steps", "--seconds"].iter().any(|name| args[i - 1] == *name);
        let number = args[i].to_str().and_then(|word| word.parse::<f64>().ok());
        if is_length && number.is_some_and(|n| n > 20.0) {
            args[i] = OsString::from("3");
        }
    }
    let is_run = args.iter().any(|a| a == "simulate" || a == "compare");
    if is_run && !args.iter().any(|a| a == "--steps" || a == "--seconds") {
        args.extend(["--steps", "2"].map(OsString::from));
    }
    args
}

/// Words that nobody types.
fn strange(rng: &mut Rng) -> OsString {
    match rng.below(4) {
        0 => OsString::from("a".repeat(10_000)),
        1 => OsString::from("\u{1b}[31m\n\t"),
        2 => OsString::from(crate::generate::extreme_number(rng).to_string()),
        _ => not_text(),
    }
}

#[cfg(unix)]
fn not_text() -> OsString {
    use std::os::unix::ffi::OsStringExt;
    OsString::from_vec(vec![b'a', 0xff, 0xfe, b'b'])
}

#[cfg(not(unix))]
fn not_text() -> OsString {
    OsString::from("\u{fffd}")
}

/// Runs a command line and checks its output.
fn check(command: &Path, args: &[OsString], folder: &Path, unit: &mut Unit) {
    unit.tried += 1;
    let shown: Vec<String> =
        args.iter().map(|a| a.to_string_lossy().chars().take(60).collect()).collect();
    let shown = format!("drystone {}", shown.join(" "));
    let Some((status, text)) = output(command, args, folder) else {
        unit.findings.add(Kind::Hang, "the command does not end", shown, 0);
        return;
    };
    let Some(status) = status else { return };
    judge(status, &text, &shown, unit);
}

fn judge(status: ExitStatus, text: &str, shown: &str, unit: &mut Unit) {
    let findings: &mut Findings = &mut unit.findings;
    let said: String = text.chars().take(400).collect();
    let detail = format!("{shown}: {said}");
    if text.contains("panicked at") {
        let place = text.split("panicked at ").nth(1).and_then(|rest| rest.lines().next());
        findings.add(Kind::Panic, format!("the command: {}", place.unwrap_or("")), detail, 0);
        return;
    }
    let errors = text.lines().filter(|line| line.trim_start().starts_with("error:")).count();
    match status.code() {
        None => findings.add(Kind::Crash, "the command", detail, 0),
        // Status 3: the run finished and reported a fault.
        Some(0 | 3) if errors == 0 => {}
        Some(0 | 3) => findings.add(Kind::Command, "an error, and yet done", detail, 0),
        Some(1 | 2) if errors == 1 => unit.refused += 1,
        // Without arguments the command prints its usage.
        Some(2) if errors == 0 && text.contains("Usage: drystone <COMMAND>") => unit.refused += 1,
        Some(1 | 2) => {
            findings.add(Kind::Command, format!("{errors} lines of errors"), detail, 0);
        }
        Some(code) => findings.add(Kind::Command, format!("exit status {code}"), detail, 0),
    }
}

/// Its exit status, if it could be started, and its error output; `None` if it did not end.
fn output(
    command: &Path,
    args: &[OsString],
    folder: &Path,
) -> Option<(Option<ExitStatus>, String)> {
    let child = Command::new(command)
        .args(args)
        .current_dir(folder)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn();
    // A word that the system cannot pass, such as one with a zero byte, is skipped.
    let Ok(mut child) = child else { return Some((None, String::new())) };
    let stream = child.stderr.take();
    let reader = std::thread::spawn(move || {
        let mut bytes = Vec::new();
        if let Some(mut stream) = stream {
            let _ = stream.read_to_end(&mut bytes);
        }
        String::from_utf8_lossy(&bytes).into_owned()
    });
    let start = Instant::now();
    let mut pause = Duration::from_millis(1);
    loop {
        match child.try_wait() {
            Ok(Some(status)) => return Some((Some(status), reader.join().unwrap_or_default())),
            Ok(None) if start.elapsed() < LIMIT => std::thread::sleep(pause),
            _ => {
                let _ = child.kill();
                let _ = child.wait();
                return None;
            }
        }
        pause = (pause * 2).min(Duration::from_millis(50));
    }
}
