//! The sweep: the same tests at several steps, and the order in which their errors fall.

use core::fmt::Write as _;

use crate::lab::Lab;
use crate::row::Row;
use crate::table::{Table, aligned, shown};
use crate::test::Test;

/// Substeps at 60 steps a second.
const SUBSTEPS: [u32; 4] = [1, 2, 4, 8];
/// Steps a second, of the method's own substeps.
const RATES: [f64; 3] = [30.0, 60.0, 120.0];

/// Tables of a sweep.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// By substeps: 1, 2, 4, 8.
    pub substeps: Vec<Table>,
    /// By rate: 30, 60, 120 Hz.
    pub rates: Vec<Table>,
}

/// Runs tests, those of them that sweep, at all settings.
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

/// The order of convergence between the first and the last error, with the step `ratio` times as short: 1 if
/// the error falls with the step, 2 with its square.
#[must_use]
pub(crate) fn order(first: f64, last: f64, ratio: f64) -> f64 {
    (first / last).ln() / ratio.ln()
}

impl Sweep {
    /// As text: an error a setting, and the order over the whole range.
    #[must_use]
    pub fn text(&self) -> String {
        let names = SUBSTEPS.map(|n| format!("{n} substeps"));
        let mut text = listing(&self.substeps, &names, 8.0);
        let names = RATES.map(|hz| format!("{hz} Hz"));
        let _ = write!(text, "\n{}", listing(&self.rates, &names, 4.0));
        text
    }
}

fn listing<const N: usize>(tables: &[Table], names: &[String; N], ratio: f64) -> String {
    let mut lines: Vec<[String; 8]> = Vec::new();
    let pad = |mut cells: Vec<String>| {
        let order = cells.pop().unwrap_or_default();
        cells.resize(7, String::new());
        cells.push(order);
        core::array::from_fn(|i| cells[i].clone())
    };
    let mut head = vec![String::new(), "case".to_owned()];
    head.extend(names.iter().cloned());
    head.push("order".to_owned());
    lines.push(pad(head));
    let Some(first) = tables.first() else { return String::new() };
    for row in &first.rows {
        let errors: Vec<Option<&Row>> = tables
            .iter()
            .map(|table| table.rows.iter().find(|other| other.key() == row.key()))
            .collect();
        let mut cells = vec![row.id.clone(), row.case.clone()];
        cells.extend(
            errors.iter().map(|row| row.map_or("–".to_owned(), |r| shown(r.error, r.unit))),
        );
        let last = errors.last().copied().flatten().map_or(f64::NAN, |row| row.error);
        cells.push(format!("{:.1}", order(row.error, last, ratio)));
        lines.push(pad(cells));
    }
    aligned(&lines)
}

#[cfg(test)]
mod tests {
    use super::order;

    #[test]
    fn the_order_is_the_power_of_the_step() {
        assert!((order(8.0, 1.0, 8.0) - 1.0).abs() < 1.0e-12);
        assert!((order(16.0, 1.0, 4.0) - 2.0).abs() < 1.0e-12);
        assert!(order(1.0, 1.0, 4.0).abs() < 1.0e-12);
    }
}
