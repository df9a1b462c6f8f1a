//! The table of rows: as text, Markdown, CSV and JSON.

use core::fmt::Write as _;

use serde::{Deserialize, Serialize};

use crate::lab::Lab;
use crate::published;
use crate::row::{Row, Skipped, Unit};
use crate::test::{FAMILIES, Family, WAITING};

/// Results of a run of tests.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Table {
    /// The engine.
    pub engine: String,
    /// Its version.
    pub version: String,
    /// Steps per second.
    pub hz: f64,
    /// Substeps per step; 0 for the engine's own number.
    pub substeps: u32,
    /// Other settings.
    pub set: Vec<String>,
    /// The rows.
    pub rows: Vec<Row>,
    /// Tests that did not run, or not to their end.
    pub skipped: Vec<Skipped>,
}

impl Table {
    /// Starts a table without rows.
    #[must_use]
    pub fn new(lab: &Lab) -> Self {
        Self {
            engine: lab.candidate.name.to_owned(),
            version: lab.candidate.version.clone(),
            hz: lab.protocol.hz,
            substeps: lab.protocol.substeps,
            set: lab.protocol.set.iter().map(|(k, v)| format!("{k}={v}")).collect(),
            rows: Vec::new(),
            skipped: Vec::new(),
        }
    }

    /// True if every row is within its `must` limit and every test ran.
    #[must_use]
    pub fn passes(&self) -> bool {
        self.skipped.is_empty() && self.rows.iter().all(|row| row.passes_must)
    }

    /// One line: `61 rows: 57 pass, 40 of them great, 4 fail`.
    #[must_use]
    pub fn summary(&self) -> String {
        let count = |of: fn(&Row) -> bool| self.rows.iter().filter(|row| of(row)).count();
        let fail = count(|row| !row.passes_must);
        let (all, great) = (self.rows.len(), count(|row| row.passes_great));
        let mut text =
            format!("{all} rows: {} pass, {great} of them great, {fail} fail", all - fail);
        if !self.skipped.is_empty() {
            // Writing to a string cannot fail.
            let _ = write!(text, "; {} tests did not run", self.skipped.len());
        }
        text
    }

    /// The table for a terminal.
    #[must_use]
    pub fn text(&self) -> String {
        let header = ["", "test", "case", "expected", "measured", "error", "must", "great", ""];
        let mut lines = vec![header.map(str::to_owned)];
        let mut last = "";
        for row in &self.rows {
            // The name appears once.
            let (id, name) =
                if row.id == last { ("", "") } else { (row.id.as_str(), row.name.as_str()) };
            last = row.id.as_str();
            lines.push([
                id.to_owned(),
                name.to_owned(),
                row.case.clone(),
                plain(row.expected),
                plain(row.measured),
                shown(row.error, row.unit),
                bound(row.limits.must, row.unit),
                bound(row.limits.great, row.unit),
                verdict(row).to_owned(),
            ]);
        }
        let mut text = aligned(&lines);
        for skipped in &self.skipped {
            let _ =
                writeln!(text, "{}  {}: did not run: {}", skipped.id, skipped.name, skipped.why);
        }
        let _ = writeln!(text, "{}", self.summary());
        text
    }

    /// As comma-separated values with a header line.
    #[must_use]
    pub fn csv(&self) -> String {
        let mut text = "id,name,case,closed_form,expected,measured,error,harder,unit,must,great,passes_must,passes_great\n".to_owned();
        for row in &self.rows {
            let quoted = |s: &str| format!("\"{}\"", s.replace('"', "\"\""));
            let harder = row.harder.map_or(String::new(), |error| error.to_string());
            let _ = writeln!(
                text,
                "{},{},{},{},{},{},{},{harder},{},{},{},{},{}",
                row.id,
                quoted(&row.name),
                quoted(&row.case),
                quoted(&row.closed_form),
                row.expected,
                row.measured,
                row.error,
                row.unit.symbol(),
                row.limits.must,
                row.limits.great,
                row.passes_must,
                row.passes_great
            );
        }
        text
    }

    /// As a Markdown page, by family.
    #[must_use]
    pub fn markdown(&self) -> String {
        let mut text = format!("# Accuracy\n\n{INTRODUCTION}\n\n");
        let substeps = match self.substeps {
            0 => "the engine's own substeps".to_owned(),
            n => format!("{n} substeps"),
        };
        let _ = write!(
            text,
            "{} {}, {} steps a second, {substeps}, sleep off",
            self.engine, self.version, self.hz
        );
        for set in &self.set {
            let _ = write!(text, ", `{set}`");
        }
        let _ = writeln!(text, ". {}.", self.summary());
        for family in FAMILIES {
            self.family(family, &mut text);
        }
        text.push_str(&published::section(&self.rows));
        if !self.skipped.is_empty() {
            text.push_str("\n## Did not run\n\n");
            for skipped in &self.skipped {
                let _ = writeln!(text, "- {} {}: {}", skipped.id, skipped.name, skipped.why);
            }
        }
        text.push_str("\n## Waiting for a part of the engine\n\n");
        for (id, name, why) in WAITING {
            let _ = writeln!(text, "- {id} {name}: {why}");
        }
        text
    }

    fn family(&self, family: &Family, text: &mut String) {
        let of = |row: &&Row| family.tests.iter().any(|test| test.id == row.id);
        let rows: Vec<&Row> = self.rows.iter().filter(of).collect();
        if rows.is_empty() {
            return;
        }
        let _ = write!(text, "\n## {}\n\n{HEADER}", family.title);
        let mut last = "";
        for row in rows {
            let (id, name, form) = if row.id == last {
                ("", "", "")
            } else {
                (row.id.as_str(), row.name.as_str(), row.closed_form.as_str())
            };
            last = row.id.as_str();
            let harder = row
                .harder
                .map_or(String::new(), |error| format!(" (harder: {})", shown(error, row.unit)));
            let _ = writeln!(
                text,
                "| {id} | {name} | {form} | {} | {} | {} | {}{harder} | {} | {} | {} |",
                row.case,
                plain(row.expected),
                plain(row.measured),
                shown(row.error, row.unit),
                bound(row.limits.must, row.unit),
                bound(row.limits.great, row.unit),
                verdict(row)
            );
        }
    }
}

const INTRODUCTION: &str = "\
Simulations whose result is known, and how far off the engine is. Written by `drystone validate --markdown`;
the gate `cargo xtask ci validate` runs the short ones.

*Must* is what the engine promises, *great* what it aims at. Rows with **fail** are known defects. `drystone
validate --only A16` runs one test; [convergence.md](convergence.md) shows how errors fall with the step. Ids A are the acceptance list,
G the solver's list, S the published SimBenchmark tests, SP the boxes of scpeters/benchmark; [what others published](#beside-published-figures) stands below,
and [how rapier and Box3D do](accuracy-peers.md) on a page of its own.";

const HEADER: &str = "\
| id | test | closed form | case | expected | measured | error | must | great | |
|---|---|---|---|---|---|---|---|---|---|
";

const BESIDE: &str = "\
# Accuracy, beside other engines

The tests of [accuracy.md](accuracy.md) on other engines: the error of each. Every engine runs with its own default settings, 60 steps a
second, sleep off. A dash: the test asks for what an engine does not have, or for what its translation leaves out; which, is said below the table. Written by

    cargo run --release --manifest-path bench/Cargo.toml -- validate --engine self,rapier,box3d --short > docs/accuracy-peers.md

| id | test | case | must | great |";

/// A Markdown page of the errors of several engines in the same tests.
#[must_use]
pub fn side_by_side(tables: &[Table]) -> String {
    let mut text = BESIDE.to_owned();
    for table in tables {
        let _ = write!(text, " {} |", table.engine);
    }
    text.push_str("\n|---|---|---|---|---|");
    text.push_str(&"---|".repeat(tables.len()));
    text.push('\n');
    let mut keys: Vec<&Row> = Vec::new();
    for row in tables.iter().flat_map(|table| &table.rows) {
        if !keys.iter().any(|known| known.key() == row.key()) {
            keys.push(row);
        }
    }
    let place = |row: &Row| crate::test::all().position(|test| test.id == row.id);
    keys.sort_by_key(|row| place(row));
    for key in keys {
        let _ = write!(
            text,
            "| {} | {} | {} | {} | {} |",
            key.id,
            key.name,
            key.case,
            bound(key.limits.must, key.unit),
            bound(key.limits.great, key.unit)
        );
        for table in tables {
            let row = table.rows.iter().find(|row| row.key() == key.key());
            let cell = row.map_or("–".to_owned(), |row| {
                format!("{} {}", shown(row.error, row.unit), verdict(row))
            });
            let _ = write!(text, " {} |", cell.trim());
        }
        text.push('\n');
    }
    for table in tables {
        let _ = writeln!(text, "\n{} {}: {}.", table.engine, table.version, table.summary());
        for skipped in &table.skipped {
            let _ = writeln!(text, "- {} did not run: {}", skipped.id, skipped.why);
        }
    }
    text
}

const fn verdict(row: &Row) -> &'static str {
    match (row.passes_must, row.passes_great) {
        (true, true) => "great",
        (true, false) => "pass",
        (false, _) => "**fail**",
    }
}

/// A limit as text; a dash if there is none.
fn bound(limit: f64, unit: Unit) -> String {
    if (0.0..f64::MAX).contains(&limit) { shown(limit, unit) } else { "–".to_owned() }
}

/// An error with its unit; fractions in percent where that reads better.
pub(crate) fn shown(value: f64, unit: Unit) -> String {
    match unit {
        Unit::Part if value == 0.0 || value >= 1.0e-4 => format!("{} %", plain(100.0 * value)),
        Unit::Part | Unit::Count => plain(value),
        _ => format!("{} {}", plain(value), unit.symbol()),
    }
}

/// A number with four significant digits.
pub(crate) fn plain(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        "0".to_owned()
    } else if !(1.0e-3..1.0e5).contains(&size) {
        format!("{value:.2e}")
    } else {
        let decimals = match size {
            s if s >= 1000.0 => 0,
            s if s >= 100.0 => 1,
            s if s >= 10.0 => 2,
            s if s >= 1.0 => 3,
            s if s >= 0.1 => 4,
            _ => 5,
        };
        let text = format!("{value:.decimals$}");
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text
        }
    }
}

/// Columns padded to the width of their widest entry.
pub(crate) fn aligned<const N: usize>(lines: &[[String; N]]) -> String {
    let width = |column: usize| lines.iter().map(|l| l[column].chars().count()).max().unwrap_or(0);
    let widths: [usize; N] = core::array::from_fn(width);
    let mut text = String::new();
    for line in lines {
        let mut row = String::new();
        for (entry, width) in line.iter().zip(widths) {
            let _ = write!(row, "{entry:<width$}  ");
        }
        text.push_str(row.trim_end());
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{Unit, plain, shown};

    #[test]
    fn numbers_keep_four_digits_and_lose_idle_zeros() {
        for (value, text) in [
            (0.0, "0"),
            (2.5, "2.5"),
            (-9.81, "-9.81"),
            (24_034.5, "24034"),
            (0.012_345, "0.01235"),
            (1.0e-6, "1.00e-6"),
            (100.0, "100"),
            (f64::NAN, "NaN"),
        ] {
            assert_eq!(plain(value), text);
        }
        assert_eq!(shown(0.012, Unit::Part), "1.2 %");
        assert_eq!(shown(1.0e-5, Unit::Part), "1.00e-5");
        assert_eq!(shown(0.5, Unit::Meter), "0.5 m");
    }
}
