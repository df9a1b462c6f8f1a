//! The accuracy table: simulations with a known answer. Each has an error that it must not exceed,
//! and a smaller target. `drystone validate` runs them on drystone; the workspace `bench/` runs the
//! same tests on its peers.
//!
//! A test builds a scene as data, runs it in a [`Lab`] under a [`Protocol`], and writes [`Row`]s.
//! It uses an engine only through [`Subject`]. The tests are in `family`, one file per family.

mod family;
mod known;
mod lab;
mod numeric;
mod published;
mod row;
mod setup;
mod sweep;
mod table;
mod test;

pub use drystone_bench::EngineError;
pub use known::{Comparison, Known, KnownError};
pub use lab::{Candidate, Lab, Matter, Moment, Protocol, Run, Subject};
pub use row::{Limits, Row, Rows, Skipped, Unit, limits};
pub use sweep::{Sweep, sweep};
pub use table::{Table, side_by_side};
pub use test::{Cost, FAMILIES, Family, Test, WAITING, all};

/// The tests with these ids, in any case and order; all tests if there are no ids.
///
/// # Errors
/// Returns a message with the unknown id and the known ids.
pub fn select(ids: &[String]) -> Result<Vec<&'static Test>, String> {
    for id in ids {
        let is = |known: &str| known.eq_ignore_ascii_case(id);
        if let Some((id, name, why)) = WAITING.iter().find(|(known, ..)| is(known)) {
            return Err(format!("{id} ({name}) waits for {why}"));
        }
        if !all().any(|test| is(test.id)) {
            let known: Vec<&str> = all().map(|test| test.id).collect();
            return Err(format!("no test '{id}'; there are {}", known.join(", ")));
        }
    }
    let wanted =
        |test: &&Test| ids.is_empty() || ids.iter().any(|id| id.eq_ignore_ascii_case(test.id));
    Ok(all().filter(wanted).collect())
}

/// Runs tests one after the other, and calls `before` before each.
pub fn run(lab: &Lab, tests: &[&'static Test], mut before: impl FnMut(&Test)) -> Table {
    let mut table = Table::new(lab);
    for test in tests {
        if lab.protocol.short && test.cost == Cost::Long {
            continue;
        }
        before(test);
        let mut rows = Rows::new(test.id, test.name, test.closed_form);
        if let Err(why) = (test.run)(lab, &mut rows) {
            table.skipped.push(Skipped {
                id: test.id.to_owned(),
                name: test.name.to_owned(),
                why: why.to_string(),
            });
        }
        table.rows.append(&mut rows.list);
    }
    table
}
