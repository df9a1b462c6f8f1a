//! `cargo xtask instructions`: number of instructions of whole runs, counted by callgrind. A count
//! does not depend on other load of the machine, so unlike a time it can be a gate.

use std::path::Path;
use std::process::Command;

use crate::{Outcome, root, run_to_end, write_whole};

/// Allowed relative growth of a count; other versions of the C library differ by less.
const TOLERANCE: f64 = 0.02;

const HEAD: &str = "# Whole runs: scene, steps, millions of instructions (release, one thread, SSE2). \
`cargo xtask instructions` compares; `--bless` rewrites.\n";

#[derive(Clone, Debug, PartialEq)]
struct Row {
    scene: String,
    steps: u32,
    millions: f64,
}

/// Counts the runs of instructions.txt. A larger count than listed fails; `bless` rewrites the
/// list.
pub fn run(bless: bool, binary: &Path) -> Outcome {
    let path = root().join("instructions.txt");
    let text = std::fs::read_to_string(&path).map_err(|e| format!("instructions.txt: {e}"))?;
    let rows = parse(&text)?;
    valgrind()?;
    let mut counted = Vec::new();
    for row in &rows {
        let millions = count(binary, row)?;
        let change = 100.0 * (millions / row.millions - 1.0);
        println!(
            "   {millions:10.1} million  {change:+5.1} %  {} ({} steps)",
            row.scene, row.steps
        );
        counted.push(Row { millions, ..row.clone() });
    }
    if bless {
        return write_whole(&path, &written(&counted));
    }
    verdict(&rows, &counted)
}

fn parse(text: &str) -> Result<Vec<Row>, String> {
    let lines =
        text.lines().enumerate().filter(|(_, l)| !l.trim().is_empty() && !l.starts_with('#'));
    lines
        .map(|(i, line)| {
            let words: Vec<&str> = line.split_whitespace().collect();
            let bad =
                || format!("instructions.txt:{}: `{line}` is not `scene steps millions`", i + 1);
            let [scene, steps, millions] = words.as_slice() else { return Err(bad()) };
            let millions: f64 = millions.parse().map_err(|_| bad())?;
            let steps = steps.parse().map_err(|_| bad())?;
            let positive = millions.is_finite() && millions > 0.0;
            positive.then(|| Row { scene: (*scene).to_owned(), steps, millions }).ok_or_else(bad)
        })
        .collect()
}

fn written(rows: &[Row]) -> String {
    let line = |r: &Row| format!("{} {} {:.1}\n", r.scene, r.steps, r.millions);
    HEAD.to_owned() + &rows.iter().map(line).collect::<String>()
}

fn verdict(before: &[Row], now: &[Row]) -> Outcome {
    let worse = before.iter().zip(now).filter(|(b, n)| n.millions > b.millions * (1.0 + TOLERANCE));
    let lines: Vec<String> = worse
        .map(|(b, n)| format!("  {}: {:.1} million, it was {:.1}", b.scene, n.millions, b.millions))
        .collect();
    if lines.is_empty() {
        return Ok(());
    }
    Err(format!(
        "more instructions than before:\n{}\nIf what they buy is worth it: cargo xtask instructions --bless",
        lines.join("\n")
    ))
}

/// Checks that valgrind works, and installs it otherwise.
fn valgrind() -> Outcome {
    let works =
        || Command::new("valgrind").arg("--version").output().is_ok_and(|o| o.status.success());
    if works() {
        return Ok(());
    }
    println!("   installing valgrind");
    let mut install = Command::new("apt-get");
    let install = install.args(["install", "--yes", "--quiet", "valgrind"]);
    if run_to_end(install).is_ok() && works() {
        return Ok(());
    }
    Err("valgrind is missing; on Debian: apt-get install valgrind (as root)".into())
}

/// Millions of instructions of one run.
fn count(binary: &Path, row: &Row) -> Result<f64, String> {
    let mut command = Command::new("valgrind");
    command.args(["--tool=callgrind", "--callgrind-out-file=/dev/null"]).arg(binary);
    command.args(["simulate", &row.scene, "--steps", &row.steps.to_string()]);
    // Valgrind does not support AVX-512, and the count must not depend on the machine's best level.
    command.args(["--threads", "1", "--simd", "sse2"]);
    let output = command.output().map_err(|e| format!("valgrind: {e}"))?;
    let log = String::from_utf8_lossy(&output.stderr);
    if !output.status.success() {
        return Err(format!("{} under valgrind: {}\n{log}", row.scene, output.status));
    }
    collected(&log).ok_or_else(|| format!("valgrind did not say what it collected:\n{log}"))
}

fn collected(log: &str) -> Option<f64> {
    let count: u32 = {
        let text = log.lines().find_map(|l| l.split_once("Collected :"))?.1;
        // Counted in thousands, so that it fits; the remainder does not matter.
        let count: u64 = text.trim().parse().ok()?;
        u32::try_from(count / 1000).ok()?
    };
    Some(f64::from(count) / 1000.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(millions: f64) -> Row {
        Row { scene: "wall".into(), steps: 60, millions }
    }

    #[test]
    fn growth_beyond_the_tolerance_is_told_and_less_is_welcome() {
        assert!(verdict(&[row(100.0)], &[row(101.9)]).is_ok());
        assert!(verdict(&[row(100.0)], &[row(50.0)]).is_ok());
        let message = verdict(&[row(100.0)], &[row(102.1)]).unwrap_err();
        assert!(message.contains("wall: 102.1 million, it was 100.0"), "{message}");
        assert!(message.contains("--bless"));
    }

    #[test]
    fn what_is_written_is_read_back() {
        let rows = [row(12.5), row(3000.1)];
        assert_eq!(parse(&written(&rows)).unwrap(), rows);
    }

    #[test]
    fn bad_line_is_named() {
        for line in ["wall 60", "wall 60 none", "wall 60 0"] {
            assert!(parse(line).unwrap_err().starts_with("instructions.txt:1: "));
        }
    }

    #[test]
    fn the_count_is_found_in_the_log() {
        let log = "==9== Events    : Ir\n==9== Collected : 1100008834\n==9==\n";
        assert_eq!(collected(log), Some(1100.008));
        assert_eq!(collected("==9== nothing"), None);
    }
}
