//! `cargo xtask golden`: the hashes of whole runs. They change only on purpose, with a reason.

use std::path::PathBuf;
use std::process::Command;

use crate::{Outcome, WITHOUT_GRAPHICS, cargo, root, run_to_end, target, write_whole};

/// Stands for the hash of a scene in golden.txt until it is blessed.
const PENDING: &str = "pending";

pub struct Options {
    pub release: bool,
    /// The reason for writing new hashes; `None` compares.
    pub bless: Option<String>,
    /// The command, if it is already built.
    pub command: Option<PathBuf>,
}

impl Options {
    pub fn parse(words: &[&str]) -> Result<Self, String> {
        let mut options = Self { release: false, bless: None, command: None };
        let mut words = words.iter();
        while let Some(&word) = words.next() {
            match word {
                "--release" => options.release = true,
                "--bless" => match words.next() {
                    Some(reason) if !reason.starts_with("--") && !reason.trim().is_empty() => {
                        options.bless = Some(reason.trim().to_owned());
                    }
                    _ => {
                        return Err(
                            "--bless needs a reason: what changed, and what a user sees".into()
                        );
                    }
                },
                _ => return Err(format!("golden: unknown option `{word}`")),
            }
        }
        Ok(options)
    }
}

/// One line of golden.txt.
#[derive(Clone, Debug, PartialEq)]
pub struct Golden {
    pub scene: String,
    pub steps: u32,
    pub hash: String,
}

/// The entries of golden.txt.
pub fn listed() -> Result<Vec<Golden>, String> {
    parse(&text()?)
}

/// The entries whose hash changed, with the new hash; `now` has the hashes in the same order.
pub fn differing(goldens: &[Golden], now: &[String]) -> Vec<(Golden, String)> {
    let pairs = goldens.iter().zip(now).filter(|(golden, hash)| golden.hash != **hash);
    pairs.map(|(golden, hash)| (golden.clone(), hash.clone())).collect()
}

/// The log that records changed hashes.
const LOG: &str = "docs/log/0.1.md";

/// Runs the scenes of golden.txt, then compares or blesses.
pub fn run(options: &Options) -> Outcome {
    let text = text()?;
    let goldens = parse(&text)?;
    let mut hashes = Vec::new();
    for golden in &goldens {
        let hash = hash_of_run(golden, options)?;
        println!("   {hash}  {} ({} steps)", golden.scene, golden.steps);
        hashes.push(hash);
    }
    let changes = differing(&goldens, &hashes);
    match &options.bless {
        _ if changes.is_empty() => Ok(()),
        None => Err(complaint(&changes)),
        Some(reason) => {
            let place = root().join(LOG);
            let log = std::fs::read_to_string(&place).map_err(|e| format!("{LOG}: {e}"))?;
            let log = with_behavior_entry(&log, &changes, reason)?;
            write_whole(&path(), &with_hashes(&text, &changes))?;
            write_whole(&place, &log)?;
            println!("   {} blessed", changes.len());
            Ok(())
        }
    }
}

fn path() -> PathBuf {
    root().join("golden.txt")
}

fn text() -> Result<String, String> {
    std::fs::read_to_string(path()).map_err(|e| format!("golden.txt: {e}"))
}

fn parse(text: &str) -> Result<Vec<Golden>, String> {
    let lines = text.lines().enumerate().filter(|(_, line)| is_entry(line));
    lines
        .map(|(i, line)| {
            let words: Vec<&str> = line.split_whitespace().collect();
            let bad = || format!("golden.txt:{}: `{line}` is not `scene steps hash`", i + 1);
            let [scene, steps, hash] = words.as_slice() else { return Err(bad()) };
            let steps = steps.parse().map_err(|_| bad())?;
            Ok(Golden { scene: (*scene).to_owned(), steps, hash: (*hash).to_owned() })
        })
        .collect()
}

fn is_entry(line: &str) -> bool {
    !line.trim().is_empty() && !line.starts_with('#')
}

/// Builds the command if needed, runs the scene and reads the hash from its report.
fn hash_of_run(golden: &Golden, options: &Options) -> Result<String, String> {
    let folder = target().join("golden");
    std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let file = folder.join(golden.scene.replace([':', '=', ','], "_") + ".json");
    let mut command = match &options.command {
        Some(built) => Command::new(built),
        None => built_by_cargo(options.release),
    };
    command.args(["simulate", &golden.scene, "--steps", &golden.steps.to_string()]);
    // One set of hashes for both: the gate runs debug and release.
    let threads = if options.release { "1" } else { "2" };
    command.args(["--threads", threads, "--report"]).arg(&file).stdout(std::process::Stdio::null());
    // Prevents a report of an earlier run from passing for this one.
    drop(std::fs::remove_file(&file));
    run_to_end(&mut command)?;
    let report = std::fs::read_to_string(&file).map_err(|e| format!("{}: {e}", file.display()))?;
    hash_in(&report).ok_or_else(|| format!("{}: no field `hash` of 16 hex digits", file.display()))
}

fn built_by_cargo(release: bool) -> Command {
    let mut command = cargo();
    command.args(["run", "--quiet", "--package", "drystone-app", "--bin", "drystone"]);
    if release {
        command.arg("--release").args(WITHOUT_GRAPHICS);
    }
    command.arg("--");
    command
}

fn hash_in(report: &str) -> Option<String> {
    let report: serde_json::Value = serde_json::from_str(report).ok()?;
    let hash = report.get("hash")?.as_str()?;
    let valid = hash.len() == 16 && hash.chars().all(|c| c.is_ascii_hexdigit());
    valid.then(|| hash.to_owned())
}

fn complaint(changes: &[(Golden, String)]) -> String {
    let mut message = String::from("golden hashes differ:");
    for (golden, hash) in changes {
        let scene = &golden.scene;
        message += &match golden.hash.as_str() {
            PENDING => format!("\n  {scene}: {hash}, none blessed yet"),
            old => format!("\n  {scene}: {hash}, blessed was {old}"),
        };
    }
    message
        + "\nIf this is meant: cargo xtask golden --bless \"what changed, and what a user sees\""
}

/// golden.txt with the new hashes; comments, order and columns are kept.
fn with_hashes(text: &str, changes: &[(Golden, String)]) -> String {
    let mut out = String::new();
    for line in text.lines() {
        let entry = if is_entry(line) { parse(line).unwrap_or_default().pop() } else { None };
        match changes.iter().find(|(golden, _)| Some(golden) == entry.as_ref()) {
            Some((golden, hash)) => {
                let end = line.rfind(&golden.hash).unwrap_or(line.len());
                out += &line[..end];
                out += hash;
            }
            None => out += line,
        }
        out.push('\n');
    }
    out
}

/// The log with the change added under Unreleased, **Behavior**, newest first.
fn with_behavior_entry(
    log: &str,
    changes: &[(Golden, String)],
    reason: &str,
) -> Result<String, String> {
    let mut entry = format!("- {reason}\n");
    for (golden, hash) in changes {
        let Golden { scene, steps, hash: old } = golden;
        entry += &format!("  - `{scene}`, {steps} steps: `{old}` → `{hash}`\n");
    }
    let start =
        log.find("## [Unreleased]").ok_or_else(|| format!("{LOG}: no `## [Unreleased]`"))?;
    let end = log[start + 1..].find("\n## ").map_or(log.len(), |at| start + 1 + at);
    let heading = "### Behavior\n";
    let at = log[start..end]
        .find(heading)
        .ok_or_else(|| format!("{LOG}: no `### Behavior` in Unreleased"))?;
    let (head, tail) = log.split_at(start + at + heading.len());
    let tail = tail.trim_start_matches('\n');
    let gap = if tail.starts_with('-') { "" } else { "\n" };
    Ok(format!("{head}\n{entry}{gap}{tail}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn change() -> Vec<(Golden, String)> {
        let golden = Golden { scene: "wall".into(), steps: 120, hash: PENDING.into() };
        vec![(golden, "00112233445566aa".into())]
    }

    #[test]
    fn bless_writes_the_hash_and_keeps_the_rest() {
        let text = "# scenes\nhello 60 1\nwall   120 pending\n";
        let blessed = with_hashes(text, &change());
        assert_eq!(blessed, "# scenes\nhello 60 1\nwall   120 00112233445566aa\n");
        assert_eq!(parse(&blessed).unwrap().len(), 2);
    }

    #[test]
    fn bless_lands_under_behavior_of_unreleased_only() {
        let log = "# Log\n\n## [Unreleased]\n\n### Behavior\n\n### Performance\n\n## [0.1.0]\n";
        let once = with_behavior_entry(log, &change(), "first").unwrap();
        let twice = with_behavior_entry(&once, &change(), "second").unwrap();
        assert_eq!(
            twice,
            "# Log\n\n## [Unreleased]\n\n### Behavior\n\n\
             - second\n  - `wall`, 120 steps: `pending` → `00112233445566aa`\n\
             - first\n  - `wall`, 120 steps: `pending` → `00112233445566aa`\n\n\
             ### Performance\n\n## [0.1.0]\n"
        );
        let elsewhere = "## [Unreleased]\n\n## [0.1.0]\n\n### Behavior\n";
        assert!(with_behavior_entry(elsewhere, &change(), "why").is_err());
    }

    #[test]
    fn pending_hash_tells_how_to_bless() {
        let message = complaint(&change());
        assert!(message.contains("none blessed yet") && message.contains("--bless"), "{message}");
    }

    #[test]
    fn bless_wants_a_reason() {
        assert!(Options::parse(&["--bless"]).is_err());
        assert!(Options::parse(&["--bless", "--release"]).is_err());
        let options = Options::parse(&["--release", "--bless", "new friction"]).unwrap();
        assert!(options.release && options.bless.as_deref() == Some("new friction"));
    }

    #[test]
    fn hash_is_read_from_the_report() {
        let report = r#"{"hashes": [[60, "aaaaaaaaaaaaaaaa"]], "hash": "0123456789abcdef"}"#;
        assert_eq!(hash_in(report).as_deref(), Some("0123456789abcdef"));
        assert_eq!(hash_in(r#"{"hash": 12}"#), None);
    }

    #[test]
    fn only_what_differs_is_told() {
        let goldens = parse("hello 60 0011\nwall 120 2233").unwrap();
        let now = ["0011".to_owned(), "4455".to_owned()];
        assert_eq!(differing(&goldens, &now), [(goldens[1].clone(), "4455".to_owned())]);
    }

    #[test]
    fn bad_line_is_named() {
        assert_eq!(
            parse("wall many pending").unwrap_err(),
            "golden.txt:1: `wall many pending` is not `scene steps hash`"
        );
    }
}
