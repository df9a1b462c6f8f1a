//! Rows that are kept: `results/<machine>/rows.csv`, one line per row, appended.

use std::fs::{self, File};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::thread::available_parallelism;
use std::time::{SystemTime, UNIX_EPOCH};

use drystone_bench::{MsPerStep, Row, Stages};

use crate::workers::{bench_folder, root};

const HEADER: [&str; 20] = [
    "time",
    "commit",
    "scene",
    "engine",
    "version",
    "threads",
    "simd",
    "steps",
    "bodies",
    "runs",
    "ms_min",
    "ms_median",
    "ms_p99",
    "hash",
    "max_penetration",
    "max_joint_error",
    "stands",
    "lost",
    "stages_ms",
    "rust",
];

/// A row that was kept.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Kept {
    /// Time when measuring ended, UTC; the same for all rows of one call.
    pub(crate) time: String,
    /// Commit of drystone.
    pub(crate) commit: String,
    /// The row.
    pub(crate) row: Row,
}

fn folder() -> PathBuf {
    bench_folder().join("results")
}

/// Appends rows to the file of this machine; returns its path.
pub(crate) fn append(rows: &[Row]) -> Result<PathBuf, String> {
    let folder = folder().join(machine());
    let path = folder.join("rows.csv");
    let failed = |e: std::io::Error| format!("{}: cannot be written: {e}", path.display());
    fs::create_dir_all(&folder).map_err(failed)?;
    let fresh = !path.exists();
    let mut file = File::options().append(true).create(true).open(&path).map_err(failed)?;
    let mut text = String::new();
    if fresh {
        text.push_str(&HEADER.join(","));
        text.push('\n');
    }
    let (time, commit) = (now(), commit());
    let rust = said("rustc", &["--version"]).unwrap_or_default();
    for row in rows {
        text.push_str(&line(&time, &commit, &rust, row));
        text.push('\n');
    }
    file.write_all(text.as_bytes()).map_err(failed)?;
    Ok(path)
}

/// All rows that were kept, by machine.
pub(crate) fn read_all() -> Result<Vec<(String, Vec<Kept>)>, String> {
    let mut machines = Vec::new();
    let Ok(entries) = fs::read_dir(folder()) else { return Ok(machines) };
    for entry in entries.flatten() {
        let path = entry.path().join("rows.csv");
        if path.is_file() {
            let text = fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
            machines.push((entry.file_name().to_string_lossy().into_owned(), read(&path, &text)?));
        }
    }
    machines.sort_by(|a, b| a.0.cmp(&b.0));
    Ok(machines)
}

fn read(path: &Path, text: &str) -> Result<Vec<Kept>, String> {
    let mut lines = text.lines().enumerate();
    let header = lines.next().map(|(_, line)| line);
    if header != Some(HEADER.join(",").as_str()) {
        return Err(format!("{}:1: is not the line of titles that is written", path.display()));
    }
    let bad = |i: usize| format!("{}:{}: is not a row", path.display(), i + 1);
    lines.map(|(i, line)| kept(&cells(line)).ok_or_else(|| bad(i))).collect()
}

fn line(time: &str, commit: &str, rust: &str, row: &Row) -> String {
    let ms = row.ms_per_step;
    let stages = row.stages_ms.as_ref().map_or_else(String::new, |stages| {
        let entry = |(name, ms): &(String, f64)| format!("{name}={ms:.5}");
        stages.0.iter().map(entry).collect::<Vec<_>>().join(";")
    });
    let cells: [String; 20] = [
        time.to_owned(),
        commit.to_owned(),
        row.scene.clone(),
        row.engine.clone(),
        row.version.clone(),
        row.threads.to_string(),
        row.simd.clone(),
        row.steps.to_string(),
        row.bodies.to_string(),
        row.runs.to_string(),
        format!("{:.5}", ms.min),
        format!("{:.5}", ms.median),
        format!("{:.5}", ms.p99),
        row.hash.clone(),
        row.max_penetration.to_string(),
        row.max_joint_error.map_or_else(String::new, |e| e.to_string()),
        row.stands.map_or_else(String::new, |stands| stands.to_string()),
        row.lost.to_string(),
        stages,
        rust.to_owned(),
    ];
    cells.map(|cell| quoted(&cell)).join(",")
}

fn quoted(cell: &str) -> String {
    if cell.contains([',', '"', '\n']) {
        format!("\"{}\"", cell.replace('"', "\"\""))
    } else {
        cell.to_owned()
    }
}

/// The cells of a line, without their quotes.
fn cells(line: &str) -> Vec<String> {
    let mut cells = vec![String::new()];
    let mut inside = false;
    let mut letters = line.chars().peekable();
    while let Some(letter) = letters.next() {
        match letter {
            '"' if inside && letters.peek() == Some(&'"') => {
                letters.next();
                if let Some(cell) = cells.last_mut() {
                    cell.push('"');
                }
            }
            '"' => inside = !inside,
            ',' if !inside => cells.push(String::new()),
            other => {
                if let Some(cell) = cells.last_mut() {
                    cell.push(other);
                }
            }
        }
    }
    cells
}

fn kept(cells: &[String]) -> Option<Kept> {
    let cell = |title: &str| {
        let column = HEADER.iter().position(|known| *known == title)?;
        cells.get(column).map(String::as_str)
    };
    let number = |title: &str| cell(title)?.parse::<f64>().ok();
    let stage = |entry: &str| {
        let (name, ms) = entry.split_once('=')?;
        Some((name.to_owned(), ms.parse().ok()?))
    };
    let stages: Option<Vec<(String, f64)>> =
        cell("stages_ms")?.split(';').filter(|entry| !entry.is_empty()).map(stage).collect();
    let row = Row {
        scene: cell("scene")?.to_owned(),
        engine: cell("engine")?.to_owned(),
        version: cell("version")?.to_owned(),
        threads: cell("threads")?.parse().ok()?,
        simd: cell("simd")?.to_owned(),
        steps: cell("steps")?.parse().ok()?,
        bodies: cell("bodies")?.parse().ok()?,
        ms_per_step: MsPerStep {
            min: number("ms_min")?,
            median: number("ms_median")?,
            p99: number("ms_p99")?,
        },
        hash: cell("hash")?.to_owned(),
        max_penetration: number("max_penetration")?,
        stands: match cell("stands")? {
            "" => None,
            text => Some(text.parse().ok()?),
        },
        max_joint_error: match cell("max_joint_error")? {
            "" => None,
            text => Some(text.parse().ok()?),
        },
        lost: cell("lost")?.parse().ok()?,
        runs: cell("runs")?.parse().ok()?,
        stages_ms: stages.filter(|stages| !stages.is_empty()).map(Stages),
    };
    Some(Kept { time: cell("time")?.to_owned(), commit: cell("commit")?.to_owned(), row })
}

/// A name for this machine: its processor and its number of cores.
fn machine() -> String {
    let info = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let cores = available_parallelism().map_or(1, std::num::NonZero::get);
    machine_in(&info, cores)
}

/// The name of the machine described by `/proc/cpuinfo`.
fn machine_in(info: &str, cores: usize) -> String {
    let said = |name: &str| {
        let mut lines = info.lines().filter_map(|line| line.split_once(':'));
        lines.find(|(key, _)| key.trim() == name).map(|(_, value)| value.trim())
    };
    let model = said("model name").unwrap_or(std::env::consts::ARCH);
    match [said("cpu family"), said("model")] {
        // A virtual machine may report only a brand that has had five generations.
        [Some(family), Some(number)] if !model.contains(|c: char| c.is_ascii_digit()) => {
            machine_name(&format!("{model} family {family} model {number}"), cores)
        }
        _ => machine_name(model, cores),
    }
}

/// The model in lower case, letters and digits with `-` between words, without uninformative words.
fn machine_name(model: &str, cores: usize) -> String {
    let model = model.to_lowercase();
    let before_clock = model.split('@').next().unwrap_or_default();
    let clean = before_clock.replace("(r)", " ").replace("(tm)", " ");
    let words = clean.split(|c: char| !c.is_ascii_alphanumeric());
    let words = words.filter(|word| !["", "cpu", "processor", "with"].contains(word));
    let mut name: Vec<&str> = words.take(6).collect();
    let cores = format!("{cores}c");
    name.push(&cores);
    name.join("-")
}

fn commit() -> String {
    let commit = said("git", &["rev-parse", "--short=10", "HEAD"]).unwrap_or_default();
    let changes = said("git", &["status", "--porcelain", "--untracked-files=no"]);
    let changed = changes.is_some_and(|list| !list.is_empty());
    if changed { format!("{commit}+changes") } else { commit }
}

/// The output of a program, run in the root of the repository.
fn said(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).current_dir(root()).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}

fn now() -> String {
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
    utc(seconds)
}

/// Seconds since 1970 as `YYYY-MM-DDThh:mm:ssZ`.
fn utc(seconds: u64) -> String {
    let is_leap = |year: u64| {
        year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400))
    };
    let (mut days, second) = (seconds / 86_400, seconds % 86_400);
    let mut year = 1970;
    loop {
        let length = if is_leap(year) { 366 } else { 365 };
        if days < length {
            break;
        }
        days -= length;
        year += 1;
    }
    let february = if is_leap(year) { 29 } else { 28 };
    let mut month = 1;
    for length in [31, february, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31] {
        if days < length {
            break;
        }
        days -= length;
        month += 1;
    }
    let (hour, minute, second) = (second / 3600, second / 60 % 60, second % 60);
    format!("{year}-{month:02}-{:02}T{hour:02}:{minute:02}:{second:02}Z", days + 1)
}

#[cfg(test)]
pub(crate) mod tests {
    use std::path::Path;

    use drystone_bench::{MsPerStep, Row, Stages};

    use super::{HEADER, Kept, cells, line, machine_in, machine_name, read, utc};

    pub(crate) fn row(scene: &str, engine: &str, threads: usize, ms: f64) -> Row {
        Row {
            scene: scene.to_owned(),
            engine: engine.to_owned(),
            version: "1.2 (a \"b\", c)".to_owned(),
            threads,
            simd: "avx2".to_owned(),
            steps: 10,
            bodies: 11,
            ms_per_step: MsPerStep { min: ms, median: ms, p99: 2.0 * ms },
            hash: "00ff".to_owned(),
            max_penetration: 0.0123,
            stands: Some(true),
            max_joint_error: None,
            lost: 0,
            runs: 5,
            stages_ms: Some(Stages(vec![("a".to_owned(), 0.5), ("b".to_owned(), 1.25)])),
        }
    }

    #[test]
    fn rows_are_read_back_as_they_were_written() {
        let one = row("stack:n=30,top_mass_ratio=100", "self", 1, 1.5);
        let two = Row {
            stands: None,
            max_joint_error: Some(0.25),
            stages_ms: None,
            ..row("washer", "rapier", 2, 3.0)
        };
        let (first, second) = (line("t", "c", "rustc 1", &one), line("t", "c", "", &two));
        let text = format!("{}\n{first}\n{second}\n", HEADER.join(","));
        let kept = |row: Row| Kept { time: "t".to_owned(), commit: "c".to_owned(), row };
        assert_eq!(read(Path::new("x"), &text).unwrap(), [kept(one), kept(two)]);
        let broken = text.replace("0.0123", "deep");
        assert!(read(Path::new("x"), &broken).unwrap_err().starts_with("x:2:"));
        assert!(read(Path::new("x"), "a,b\n").unwrap_err().starts_with("x:1:"));
        assert_eq!(cells("a,,\"b,\"\"c\""), ["a", "", "b,\"c"]);
    }

    #[test]
    fn machines_have_plain_names() {
        assert_eq!(machine_name(" AMD EPYC 9B45", 2), "amd-epyc-9b45-2c");
        let intel = "Intel(R) Xeon(R) CPU E5-2680 v4 @ 2.40GHz";
        assert_eq!(machine_name(intel, 28), "intel-xeon-e5-2680-v4-28c");
        let info = "processor\t: 0\ncpu family\t: 26\nmodel\t\t: 2\nmodel name\t: ";
        assert_eq!(machine_in(&format!("{info}AMD EPYC\n"), 2), "amd-epyc-family-26-model-2-2c");
        assert_eq!(machine_in(&format!("{info}AMD EPYC 9B45\n"), 2), "amd-epyc-9b45-2c");
        assert_eq!(machine_in("", 4), machine_name(std::env::consts::ARCH, 4));
        let long = "AMD Ryzen 9 7950X 16-Core Processor with Radeon Graphics";
        assert_eq!(machine_name(long, 32), "amd-ryzen-9-7950x-16-core-32c");
    }

    #[test]
    fn dates_are_those_of_the_calendar() {
        assert_eq!(utc(0), "1970-01-01T00:00:00Z");
        assert_eq!(utc(951_782_399), "2000-02-28T23:59:59Z");
        assert_eq!(utc(951_782_400), "2000-02-29T00:00:00Z");
        assert_eq!(utc(1_795_219_200), "2026-11-21T00:00:00Z");
    }
}
