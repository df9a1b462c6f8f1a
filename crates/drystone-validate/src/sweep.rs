//! The sweep: the same tests at several steps, and the order of convergence of their errors.

use core::fmt::Write as _;

use crate::lab::Lab;
use crate::row::Row;
use crate::table::{Table, aligned, shown};
use crate::test::Test;

/// Numbers of substeps at 60 steps per second.
const SUBSTEPS: [u32; 4] = [1, 2, 4, 8];
/// Steps per second, with the method's own number of substeps.
const RATES: [f64; 3] = [30.0, 60.0, 120.0];

/// Tables of a sweep.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// By substeps: 1, 2, 4, 8.
    pub substeps: Vec<Table>,
    /// By rate: 30, 60, 120 Hz.
    pub rates: Vec<Table>,
}

/// Runs the tests that support a sweep at all settings.
pub fn sweep(lab: &Lab, tests: &[&'static Test], mut before: impl FnMut(&Test)) -> Sweep {
    let tests: Vec<&'static Test> = tests.iter().copied().filter(|test| test.sweeps).collect();
    let mut at = |hz: f64, substeps: u32| {
        let protocol = crate::lab::Protocol { hz, substeps, ..lab.protocol.clone() };
        crate::run(&lab.with(protocol), &tests, &mut before)
    };
    Sweep {
        substeps: SUBSTEPS.iter().map(|n| at(60.0, *n)).collect(),
        rates: RATES.iter().map(|hz| at(*hz, lab.protocol.substeps)).collect(),
    }
}

/// The order of convergence between the first and the last error, with a step shorter by the factor
/// `ratio`. It is 1 if the error is proportional to the step, 2 if to its square.
#[must_use]
pub(crate) fn order(first: f64, last: f64, ratio: f64) -> f64 {
    (first / last).ln() / ratio.ln()
}

impl Sweep {
    /// As text: one error per setting, and the order over the whole range.
    #[must_use]
    pub fn text(&self) -> String {
        self.parts().map(|part| aligned(&part.lines)).join("\n")
    }

    /// As a page of Markdown.
    #[must_use]
    pub fn markdown(&self) -> String {
        let mut text = format!("# Convergence\n\n{INTRODUCTION}\n");
        for part in self.parts() {
            let _ = write!(text, "\n## {}\n\n{}\n\n", part.title, part.summary());
            for (number, line) in part.lines.iter().enumerate() {
                // The columns that both tables have, without the unused ones.
                let cells: Vec<&str> = line.iter().map(String::as_str).collect();
                let (used, order) = (&cells[..2 + part.settings], cells[LAST]);
                let _ = writeln!(text, "| {} | {order} |", used.join(" | "));
                if number == 0 {
                    let _ = writeln!(text, "|{}", "---|".repeat(part.settings + 3));
                }
            }
        }
        text
    }

    fn parts(&self) -> [Part; 2] {
        let substeps = SUBSTEPS.map(|n| format!("{n} substeps"));
        let rates = RATES.map(|hz| format!("{hz} Hz"));
        [
            Part::new("Substeps, at 60 steps a second", &self.substeps, &substeps, 8.0),
            Part::new("Steps a second, the engine's own substeps", &self.rates, &rates, 4.0),
        ]
    }
}

const INTRODUCTION: &str = "\
How the errors of [accuracy.md](accuracy.md) fall with the step: tests that are smooth enough to have an order.
Written by `drystone validate --sweep --markdown > docs/convergence.md`.

*Order* is that of the whole range: 1 if the error falls with the step, 2 with its square, 0 if it stays. What is at the
rounding of `f32` already has none, nor has what the engine makes exact whatever the step (bounces, parabolas). Rows
whose closed form has no end in the step, such as what a column sinks, tell by their order how stiff contacts become.";

/// Minimum order that counts as first-order convergence.
const FIRST: f64 = 0.7;
/// Errors below this are rounding only, in any unit.
const ROUNDING: f64 = 1.0e-4;

/// The last column of a listing: the order.
const LAST: usize = 7;

/// A table of a sweep.
struct Part {
    title: &'static str,
    settings: usize,
    lines: Vec<[String; LAST + 1]>,
    /// Order and last error of each row.
    ends: Vec<(f64, f64)>,
}

impl Part {
    fn new<const N: usize>(
        title: &'static str,
        tables: &[Table],
        names: &[String; N],
        ratio: f64,
    ) -> Self {
        let mut part = Self { title, settings: N, lines: Vec::new(), ends: Vec::new() };
        let mut head = vec![String::new(), "case".to_owned()];
        head.extend(names.iter().cloned());
        part.add(head, "order".to_owned());
        for row in tables.first().map_or(&[][..], |table| &table.rows) {
            let errors: Vec<Option<&Row>> = tables
                .iter()
                .map(|table| table.rows.iter().find(|other| other.key() == row.key()))
                .collect();
            let mut cells = vec![row.id.clone(), row.case.clone()];
            cells.extend(
                errors.iter().map(|row| row.map_or("–".to_owned(), |r| shown(r.error, r.unit))),
            );
            let last = errors.last().copied().flatten().map_or(f64::NAN, |row| row.error);
            let order = order(row.error, last, ratio);
            part.ends.push((order, last));
            part.add(cells, format!("{order:.1}"));
        }
        part
    }

    fn add(&mut self, mut cells: Vec<String>, order: String) {
        cells.resize(LAST, String::new());
        cells.push(order);
        self.lines.push(core::array::from_fn(|i| cells[i].clone()));
    }

    /// Number of rows that converge.
    fn summary(&self) -> String {
        let falls = self.ends.iter().filter(|(order, _)| *order >= FIRST).count();
        let tiny = |(order, last): &&(f64, f64)| !(*order >= FIRST) && *last <= ROUNDING;
        let tiny = self.ends.iter().filter(tiny).count();
        let all = self.ends.len();
        format!(
            "Of {all} rows {falls} fall with the step (order {FIRST} and more), {tiny} others end below {ROUNDING:e} in \
             their unit, {} do neither.",
            all - falls - tiny
        )
    }
}

#[cfg(test)]
mod tests {
    use super::{Part, Sweep, order};
    use crate::lab::{Candidate, Lab, Protocol};
    use crate::row::{Rows, limits};
    use crate::table::Table;

    #[test]
    fn the_order_is_the_power_of_the_step() {
        assert!((order(8.0, 1.0, 8.0) - 1.0).abs() < 1.0e-12);
        assert!((order(16.0, 1.0, 4.0) - 2.0).abs() < 1.0e-12);
        assert!(order(1.0, 1.0, 4.0).abs() < 1.0e-12);
    }
    /// Tables with one error each.
    fn tables(errors: &[f64]) -> Vec<Table> {
        let lab = Lab {
            candidate: Candidate::of::<drystone_bench::Own>(),
            protocol: Protocol::default(),
        };
        let table = |error: &f64| {
            let mut table = Table::new(&lab);
            let mut rows = Rows::new("A0", "", "");
            rows.relative("x", 1.0, 1.0 + error, limits(1.0, 1.0));
            table.rows = rows.list;
            table
        };
        errors.iter().map(table).collect()
    }

    #[test]
    fn a_row_converges_ends_at_rounding_or_does_neither() {
        let ends = |errors: &[f64]| {
            let names = ["1 substeps".to_owned(), "8 substeps".to_owned()];
            Part::new("", &tables(errors), &names, 8.0).summary()
        };
        assert!(ends(&[0.8, 0.1]).starts_with("Of 1 rows 1 fall"));
        assert!(
            ends(&[2.0e-5, 1.0e-5]).contains("0 fall")
                && ends(&[2.0e-5, 1.0e-5]).contains("1 others")
        );
        assert!(ends(&[0.5, 0.4]).contains("1 do neither"));
        assert!(ends(&[0.5, f64::NAN]).contains("1 do neither"));
    }

    #[test]
    fn the_page_has_a_column_for_each_setting_and_one_for_the_order() {
        let sweep =
            Sweep { substeps: tables(&[0.8, 0.4, 0.2, 0.1]), rates: tables(&[0.4, 0.2, 0.1]) };
        let page = sweep.markdown();
        assert!(page.contains("| A0 | x | 80 % | 40 % | 20 % | 10 % | 1.0 |\n"), "{page}");
        assert!(page.contains("| A0 | x | 40 % | 20 % | 10 % | 1.0 |\n"), "{page}");
        assert!(page.contains("|---|---|---|---|---|---|---|\n"), "{page}");
    }
}
