//! `drystone-attack`, run by `cargo xtask attack`: see `docs/attack.md`.

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use drystone_attack::campaign::{self, Options, worker};
use drystone_attack::finding::Finding;
use drystone_attack::hunt::{self, Scene};
use drystone_attack::unit::{Places, Subject, run_unit};
use drystone_attack::{minimize, probe, source};

const USAGE: &str =
    "usage: cargo xtask attack [OPTIONS]            search for what breaks, for a minute
       cargo xtask attack repeat SEED          run one seed again and tell what breaks
       cargo xtask attack minimize SEED        shrink it, and write it as a test

usage: cargo xtask hunt [OPTIONS]              search small worlds for motion that no physics has
       cargo xtask hunt repeat SEED            run one world again and tell what is wrong; --trace writes its way
       cargo xtask hunt minimize SEED          shrink it, and write it as a test

SEED is one that a finding names, such as worlds:17, or throws:17 of the hunt.

  --seconds N, --minutes N, --hours N   how long
  --worlds N      so many worlds and what goes with them of the rest, always the same, without a limit of time
  --seed N        another campaign; 0 if not given
  --only LIST     some of worlds, files, snapshots, commands, soak; of the hunt some kinds of scenes
  --jobs N        processes at a time; all cores if not given
  --trace         repeat writes each operation before it is done
  --strict        faults and speeds over 1000 m/s of ordinary worlds are findings too
  --command PATH  the program drystone; command lines are left out without it
  --root PATH     the repository
  --out PATH      where findings are written; target/attack if not given";

/// Arguments of the command line.
#[derive(Debug)]
struct Arguments {
    words: Vec<String>,
    /// Whether each operation is printed before it is applied.
    is_traced: bool,
    options: Options,
}

fn main() -> ExitCode {
    let outcome = parse(std::env::args().skip(1)).and_then(|arguments| act(&arguments));
    match outcome {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(message) => {
            let _ = writeln!(std::io::stderr(), "error: {message}\n\n{USAGE}");
            ExitCode::from(2)
        }
    }
}

fn parse(args: impl Iterator<Item = String>) -> Result<Arguments, String> {
    let root = PathBuf::from(".");
    let jobs = std::thread::available_parallelism().map_or(1, usize::from);
    let scratch = std::env::temp_dir().join(format!("drystone-attack-{}", std::process::id()));
    let places = Places { root, scratch, command: None, strict: false };
    let mut options = Options {
        time: Duration::from_secs(60),
        worlds: None,
        seed: 0,
        only: Subject::ALL.to_vec(),
        jobs,
        out: PathBuf::new(),
        places,
    };
    let mut words = Vec::new();
    let (mut is_limited, mut is_traced) = (false, false);
    let mut args = args.peekable();
    if args.peek().is_some_and(|word| word == "hunt") {
        options.only = Scene::ALL.into_iter().map(Subject::Scene).collect();
    }
    while let Some(arg) = args.next() {
        if !arg.starts_with("--") {
            words.push(arg);
            continue;
        }
        if arg == "--trace" {
            is_traced = true;
            continue;
        }
        if arg == "--strict" {
            options.places.strict = true;
            continue;
        }
        let value = args.next().ok_or_else(|| format!("{arg} needs a value"))?;
        let wrong = || format!("{arg} {value}: not understood");
        let number = || value.parse::<u64>().map_err(|_| wrong());
        let time = |unit: f64| match value.parse::<f64>() {
            Ok(n) if n > 0.0 && n < 1.0e6 => Ok(Duration::from_secs_f64(n * unit)),
            _ => Err(wrong()),
        };
        match arg.as_str() {
            "--seconds" => (options.time, is_limited) = (time(1.0)?, true),
            "--minutes" => (options.time, is_limited) = (time(60.0)?, true),
            "--hours" => (options.time, is_limited) = (time(3600.0)?, true),
            "--worlds" => options.worlds = Some(number()?),
            "--seed" => options.seed = number()?,
            "--jobs" => options.jobs = usize::try_from(number()?).map_err(|_| wrong())?,
            "--only" => {
                let named = value.split(',').map(|name| Subject::named(name).ok_or_else(wrong));
                options.only = named.collect::<Result<_, _>>()?;
            }
            "--root" => options.places.root = absolute(&value),
            "--scratch" => options.places.scratch = absolute(&value),
            "--command" => options.places.command = Some(absolute(&value)),
            "--out" => options.out = absolute(&value),
            _ => return Err(format!("unknown option {arg}")),
        }
    }
    if options.out.as_os_str().is_empty() {
        let hunts = words.first().is_some_and(|word| word == "hunt");
        let folder = if hunts { "target/hunt" } else { "target/attack" };
        options.out = options.places.root.join(folder);
    }
    if options.places.command.is_none() {
        options.only.retain(|subject| *subject != Subject::Commands);
    }
    if options.worlds.is_some() && !is_limited {
        options.time = Duration::from_secs(30 * 24 * 3600);
    }
    Ok(Arguments { words, is_traced, options })
}

fn absolute(path: &str) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| PathBuf::from(path))
}

/// Runs the command; returns false if something broke.
fn act(arguments: &Arguments) -> Result<bool, String> {
    let words: Vec<&str> = arguments.words.iter().map(String::as_str).collect();
    let options = &arguments.options;
    match words.as_slice() {
        [] | ["hunt"] => {
            let report = campaign::run(options);
            let _ = std::fs::remove_dir_all(&options.places.scratch);
            let report = report?;
            say(&report.table());
            Ok(!report.has_findings())
        }
        ["worker", subject, numbers @ ..] => {
            let subject = Subject::named(subject).ok_or("no such subject")?;
            let numbers: Vec<u64> = numbers.iter().filter_map(|n| n.parse().ok()).collect();
            let numbers = numbers.try_into().map_err(|_| "five numbers".to_owned())?;
            worker(subject, numbers, &options.places).map_err(|e| e.to_string())?;
            Ok(true)
        }
        ["repeat", seed] | ["hunt", "repeat", seed] => {
            let (subject, seed) = parse_seed(seed)?;
            if let (true, Subject::Scene(scene)) = (arguments.is_traced, subject) {
                hunt::trace(scene, seed, say);
            }
            if arguments.is_traced && subject == Subject::Worlds {
                probe::probe(seed, "all", Some(say));
            }
            let findings = repeat(subject, seed, options)?;
            Ok(findings.is_empty())
        }
        ["hunt", "minimize", seed] => {
            let (Subject::Scene(scene), seed) = parse_seed(seed)? else {
                return Err("only worlds of the hunt can be shrunk so".to_owned());
            };
            shrink_scene(scene, seed, options)
        }
        ["minimize", seed] => {
            let (Subject::Worlds, seed) = parse_seed(seed)? else {
                return Err("only worlds can be shrunk".to_owned());
            };
            // Tries a separate process first, because the program may hang or crash.
            if let Some((small, finding)) = probe::minimize(seed, options.time) {
                return written(&source::test(&small, seed, Some(&finding)), seed, 0, options);
            }
            shrink(seed, options)
        }
        ["probe", seed, keep] => {
            let (_, seed) = parse_seed(seed)?;
            probe::probe(seed, keep, arguments.is_traced.then_some(say as fn(&str)));
            Ok(true)
        }
        ["source", seed] => {
            let (_, seed) = parse_seed(seed)?;
            say(&source::test(&drystone_attack::generate::program(seed), seed, None));
            Ok(true)
        }
        _ => Err("no such command".to_owned()),
    }
}

/// Parses `worlds:17`, or 17 alone.
fn parse_seed(text: &str) -> Result<(Subject, u64), String> {
    let (subject, seed) = text.split_once(':').unwrap_or(("worlds", text));
    let subject = Subject::named(subject).ok_or_else(|| format!("{subject}: no such subject"))?;
    Ok((subject, seed.parse().map_err(|_| format!("{seed}: no seed"))?))
}

fn repeat(subject: Subject, seed: u64, options: &Options) -> Result<Vec<Finding>, String> {
    let unit = run_unit(subject, seed, &options.places);
    let _ = std::fs::remove_dir_all(&options.places.scratch);
    if let Some(style) = unit.style {
        say(&format!("style {}", style.name()));
    }
    say(&format!(
        "tried {}, steps {}, refused {}, faults {}, over 1000 m/s: {}, ended early: {}",
        unit.tried, unit.steps, unit.refused, unit.faults, unit.is_wild, unit.is_cut
    ));
    for finding in &unit.findings.all {
        say(&format!(
            "{}: {} (step {})\n    {}",
            finding.kind.name(),
            finding.what,
            finding.step,
            finding.detail
        ));
    }
    if unit.findings.all.is_empty() {
        say("nothing breaks");
    }
    for (name, bytes) in &unit.inputs {
        std::fs::create_dir_all(&options.out).map_err(|e| e.to_string())?;
        let path = options.out.join(format!("{seed}-{name}"));
        std::fs::write(&path, bytes).map_err(|e| format!("{}: {e}", path.display()))?;
        say(&format!("written to {}", path.display()));
    }
    Ok(unit.findings.all)
}

/// Shrinks a program for each of its findings, and writes a test for each.
fn shrink(seed: u64, options: &Options) -> Result<bool, String> {
    let findings = minimize::findings_of(seed, options.places.strict);
    if findings.is_empty() {
        say("nothing breaks");
        return Ok(true);
    }
    for (number, finding) in findings.iter().enumerate() {
        let small = minimize::minimize(seed, finding, options.places.strict, options.time);
        written(&source::test(&small, seed, Some(finding)), seed, number, options)?;
    }
    Ok(false)
}

/// As `shrink`, for a world of the hunt and the first finding of each kind.
fn shrink_scene(scene: Scene, seed: u64, options: &Options) -> Result<bool, String> {
    let mut findings = hunt::findings_of(scene, seed);
    if findings.is_empty() {
        say("nothing breaks");
        return Ok(true);
    }
    findings.dedup_by_key(|finding| finding.kind);
    for (number, finding) in findings.iter().enumerate() {
        let small = hunt::minimize(scene, seed, finding, options.time);
        written(&hunt::test(&small, scene, seed, finding), seed, number, options)?;
    }
    Ok(false)
}

/// Writes a test beside the findings, and prints its path.
fn written(text: &str, seed: u64, number: usize, options: &Options) -> Result<bool, String> {
    std::fs::create_dir_all(&options.out).map_err(|e| e.to_string())?;
    let path = options.out.join(format!("test-{seed}-{number}.rs"));
    std::fs::write(&path, text).map_err(|e| format!("{}: {e}", path.display()))?;
    say(&format!("{text}\n// written to {}\n", path.display()));
    Ok(false)
}

fn say(text: &str) {
    let _ = writeln!(std::io::stdout(), "{text}");
}
