//! The tables of RESULTS.md, from the rows that were kept.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::Path;

use crate::results::{self, Kept};
use crate::workers::root;
use crate::{write_out, write_whole};

const BEGIN: &str = "<!-- bench:begin -->";
const END: &str = "<!-- bench:end -->";
const OWN: &str = "self";

/// Writes the tables into `page`, by default RESULTS.md.
pub(crate) fn write(page: Option<&Path>) -> Result<(), String> {
    let machines = results::read_all()?;
    if machines.is_empty() {
        return Err("there are no rows under bench/results; measure first".to_owned());
    }
    let mut text = String::new();
    for (machine, rows) in &machines {
        text.push_str(&tables(machine, rows));
    }
    if page == Some(Path::new("-")) {
        return write_out(&text);
    }
    let results = root().join("bench/RESULTS.md");
    let page = page.unwrap_or(&results);
    let old = std::fs::read_to_string(page)
        .map_err(|e| format!("{}: cannot be read: {e}", page.display()))?;
    let new = between_markers(&old, &text).ok_or_else(|| {
        format!("{}: lacks the lines {BEGIN} and {END}, in this order", page.display())
    })?;
    write_whole(page, &new)
}

/// The page with `text` between the two marker lines.
fn between_markers(page: &str, text: &str) -> Option<String> {
    let (head, rest) = page.split_once(BEGIN)?;
    let (_, tail) = rest.split_once(END)?;
    Some(format!("{head}{BEGIN}\n\n{text}{END}{tail}"))
}

/// For each scene and number of threads, the rows of the last call that measured drystone on it.
/// Only rows that were measured side by side are compared.
fn side_by_side(rows: &[Kept]) -> Vec<&Kept> {
    let mut last: BTreeMap<(&str, usize), &str> = BTreeMap::new();
    for kept in rows.iter().filter(|kept| kept.row.engine == OWN) {
        let time = last.entry((&kept.row.scene, kept.row.threads)).or_insert(&kept.time);
        *time = (*time).max(&kept.time);
    }
    let is_last = |kept: &&Kept| {
        last.get(&(kept.row.scene.as_str(), kept.row.threads)) == Some(&kept.time.as_str())
    };
    rows.iter().filter(is_last).collect()
}

/// The rows of one machine by scene, engine and threads, with scenes in order of appearance.
struct Side<'a> {
    scenes: Vec<&'a str>,
    engines: Vec<&'a str>,
    threads: Vec<usize>,
    rows: BTreeMap<(&'a str, &'a str, usize), &'a Kept>,
}

impl<'a> Side<'a> {
    fn new(rows: &'a [Kept]) -> Self {
        let mut side = Self {
            scenes: Vec::new(),
            engines: vec![OWN],
            threads: Vec::new(),
            rows: BTreeMap::new(),
        };
        for kept in side_by_side(rows) {
            let (scene, engine) = (kept.row.scene.as_str(), kept.row.engine.as_str());
            if !side.scenes.contains(&scene) {
                side.scenes.push(scene);
            }
            if !side.engines.contains(&engine) {
                side.engines.push(engine);
            }
            if !side.threads.contains(&kept.row.threads) {
                side.threads.push(kept.row.threads);
            }
            side.rows.insert((scene, engine, kept.row.threads), kept);
        }
        side.threads.sort_unstable();
        side
    }

    fn row(&self, scene: &'a str, engine: &'a str, threads: usize) -> Option<&'a Kept> {
        self.rows.get(&(scene, engine, threads)).copied()
    }

    fn ms(&self, scene: &'a str, engine: &'a str, threads: usize) -> Option<f64> {
        self.row(scene, engine, threads).map(|kept| kept.row.ms_per_step.median)
    }

    /// Speedup of drystone over the fastest peer.
    fn ratio(&self, scene: &'a str, threads: usize) -> Option<f64> {
        let own = self.ms(scene, OWN, threads).filter(|ms| *ms > 0.0)?;
        let peers = self.engines.iter().filter(|engine| **engine != OWN);
        let best = peers.filter_map(|engine| self.ms(scene, engine, threads)).reduce(f64::min)?;
        Some(best / own)
    }
}

fn tables(machine: &str, rows: &[Kept]) -> String {
    let side = Side::new(rows);
    let commits: BTreeSet<&str> = side.rows.values().map(|kept| kept.commit.as_str()).collect();
    let versions: BTreeSet<String> = side
        .rows
        .values()
        .map(|kept| format!("{} {}", kept.row.engine, kept.row.version))
        .collect();
    let days: BTreeSet<&str> =
        side.rows.values().filter_map(|kept| kept.time.split('T').next()).collect();
    let list = |set: BTreeSet<&str>| set.into_iter().collect::<Vec<_>>().join(", ");
    // Writing to a String cannot fail, here and below.
    let mut text = String::new();
    let versions = list(versions.iter().map(String::as_str).collect());
    let _ =
        writeln!(text, "**{machine}**, {}, commit {}; {versions}.\n", list(days), list(commits));
    text.push_str(&times(&side));
    text.push('\n');
    text.push_str(&quality(&side));
    text.push('\n');
    text
}

fn heading(titles: &[String]) -> String {
    let rule = titles.iter().enumerate().map(|(i, _)| if i == 0 { "---" } else { "---:" });
    format!("| {} |\n| {} |\n", titles.join(" | "), rule.collect::<Vec<_>>().join(" | "))
}

/// Milliseconds per step by engine and threads, and the speedup over the fastest peer.
fn times(side: &Side<'_>) -> String {
    let mut titles = vec!["ms a step".to_owned()];
    for threads in &side.threads {
        let unit = if *threads == 1 { "1 thread".to_owned() } else { format!("{threads} threads") };
        titles.extend(side.engines.iter().map(|engine| format!("{engine}, {unit}")));
        titles.push("times faster".to_owned());
    }
    let mut text = heading(&titles);
    let mut ratios: Vec<Vec<f64>> = vec![Vec::new(); side.threads.len()];
    for scene in &side.scenes {
        let mut cells = vec![(*scene).to_owned()];
        for (threads, ratios) in side.threads.iter().zip(&mut ratios) {
            let ms = |engine: &&str| side.ms(scene, engine, *threads).map_or_else(dash, figure);
            cells.extend(side.engines.iter().map(ms));
            let ratio = side.ratio(scene, *threads);
            ratios.extend(ratio);
            cells.push(ratio.map_or_else(dash, |ratio| format!("{ratio:.2}")));
        }
        let _ = writeln!(text, "| {} |", cells.join(" | "));
    }
    let mut cells = vec!["geometric mean".to_owned()];
    for ratios in &ratios {
        cells.extend(side.engines.iter().map(|_| String::new()));
        cells.push(geometric_mean(ratios).map_or_else(dash, |mean| format!("**{mean:.2}**")));
    }
    let _ = writeln!(text, "| {} |", cells.join(" | "));
    text
}

/// Maximum overlap, joint error, and whether the scene stands, by engine, for the smallest number
/// of threads.
fn quality(side: &Side<'_>) -> String {
    let mut titles = vec!["deepest overlap [mm]; joint error [mm]; stands".to_owned()];
    titles.extend(side.engines.iter().map(|engine| (*engine).to_owned()));
    let mut text = heading(&titles);
    for scene in &side.scenes {
        let mut cells = vec![(*scene).to_owned()];
        for engine in &side.engines {
            let kept = side.threads.iter().find_map(|threads| side.row(scene, engine, *threads));
            cells.push(kept.map_or_else(dash, |kept| {
                let row = &kept.row;
                let mut cell = figure(1000.0 * row.max_penetration);
                if let Some(error) = row.max_joint_error {
                    let _ = write!(cell, "; {}", figure(1000.0 * error));
                }
                if let Some(stands) = row.stands {
                    cell.push_str(if stands { "; yes" } else { "; **no**" });
                }
                if row.lost > 0 {
                    let _ = write!(cell, "; {} lost", row.lost);
                }
                cell
            }));
        }
        let _ = writeln!(text, "| {} |", cells.join(" | "));
    }
    text
}

fn dash() -> String {
    "–".to_owned()
}

/// A number with three significant digits.
fn figure(value: f64) -> String {
    match value {
        v if v >= 99.5 => format!("{v:.0}"),
        v if v >= 9.95 => format!("{v:.1}"),
        v if v >= 0.995 => format!("{v:.2}"),
        v => format!("{v:.3}"),
    }
}

#[expect(clippy::cast_precision_loss, reason = "a count of scenes")]
fn geometric_mean(ratios: &[f64]) -> Option<f64> {
    let sum: f64 = ratios.iter().map(|ratio| ratio.ln()).sum();
    (!ratios.is_empty()).then(|| (sum / ratios.len() as f64).exp())
}

#[cfg(test)]
mod tests {
    use super::{Kept, between_markers, tables};
    use crate::results::tests::row;

    fn kept(time: &str, scene: &str, engine: &str, threads: usize, ms: f64) -> Kept {
        let (time, commit) = (time.to_owned(), "abc".to_owned());
        Kept { time, commit, row: row(scene, engine, threads, ms) }
    }

    #[test]
    fn only_rows_of_the_last_call_are_compared_and_the_fastest_peer_counts() {
        let rows = [
            kept("2026-01-01T", "washer", "self", 1, 9.0),
            kept("2026-01-01T", "washer", "rapier", 1, 0.1),
            kept("2026-01-02T", "washer", "self", 1, 2.0),
            kept("2026-01-02T", "washer", "rapier", 1, 8.0),
            kept("2026-01-02T", "washer", "box3d", 1, 10.0),
            kept("2026-01-02T", "stack", "self", 1, 1.0),
            kept("2026-01-02T", "stack", "box3d", 1, 9.0),
            // Without drystone beside it, there is no comparison.
            kept("2026-01-03T", "washer", "rapier", 1, 1.0),
        ];
        let text = tables("m", &rows);
        assert!(text.contains("| washer | 2.00 | 8.00 | 10.0 | 4.00 |"), "{text}");
        assert!(text.contains("| stack | 1.00 | – | 9.00 | 9.00 |"), "{text}");
        // √(4 · 9)
        assert!(text.contains("| geometric mean |  |  |  | **6.00** |"), "{text}");
        assert!(text.contains("| stack | 12.3; yes | – | 12.3; yes |"), "{text}");
    }

    #[test]
    fn a_page_keeps_all_but_what_is_between_the_markers() {
        let page = "a\n<!-- bench:begin -->\nold\n<!-- bench:end -->\nb\n";
        let new = between_markers(page, "new\n").unwrap();
        assert_eq!(new, "a\n<!-- bench:begin -->\n\nnew\n<!-- bench:end -->\nb\n");
        assert_eq!(between_markers(&new, "new\n").unwrap(), new);
        assert!(between_markers("no markers", "x").is_none());
    }
}
