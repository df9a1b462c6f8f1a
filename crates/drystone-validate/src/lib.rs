//! The accuracy table: simulations with a known answer, each with the error that it must not exceed and the
//! one that is aimed at. `drystone validate` runs them on drystone; the workspace `bench/` runs the same
//! tests on its peers.
//!
//! A test builds a scene as data, lets a [`Lab`] run it under a [`Protocol`], and writes [`Row`]s. It knows an
//! engine only through [`Subject`]. The tests stand in `family`, a file a family.

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

/// The tests of these ids, case and order of no matter; all for none.
///
/// # Errors
/// An id that is not known, with those that are.
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

/// Runs tests one after the other; `before` is told of each.
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
