//! The list of known failures: rows that fail today, each with its error. With it a gate passes,
//! catches rows that get worse, and reports rows that were fixed.

use core::fmt::Write as _;

use crate::table::Table;

/// Allowed factor on the listed error, because any change of a run's bits changes its errors
/// slightly.
const SLACK: f64 = 1.1;

/// Known failures.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Known {
    /// Name of a row or test, and its error.
    entries: Vec<(String, f64)>,
}

/// A line of the list cannot be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KnownError {
    line: usize,
}

impl core::fmt::Display for KnownError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "line {}: expected an error and a row, such as `0.05  A16 e 0.5`", self.line)
    }
}

impl core::error::Error for KnownError {}

/// Differences between a table and the list of known failures.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Comparison {
    /// Failures that are not listed, or worse than listed, one line each.
    pub worse: Vec<String>,
    /// Listed rows that now pass, one line each.
    pub mended: Vec<String>,
}

impl Known {
    /// Parses the list. Each line has an error and the name of a row; `#` begins a comment.
    ///
    /// # Errors
    /// Returns the first line that is neither.
    pub fn parse(text: &str) -> Result<Self, KnownError> {
        let mut known = Self::default();
        for (number, line) in text.lines().enumerate() {
            let line = line.trim();
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let parts = line.split_once(char::is_whitespace);
            let entry = parts.and_then(|(e, row)| Some((row.trim().to_owned(), e.parse().ok()?)));
            known.entries.push(entry.ok_or(KnownError { line: number + 1 })?);
        }
        Ok(known)
    }

    /// The list of failures in a table.
    #[must_use]
    pub fn of(table: &Table) -> String {
        let mut text = String::new();
        for row in table.rows.iter().filter(|row| !row.passes_must) {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{:.4e}  {}", row.error, row.key());
        }
        for skipped in &table.skipped {
            let _ = writeln!(text, "inf  {}", skipped.id);
        }
        text
    }

    fn error(&self, key: &str) -> Option<f64> {
        self.entries.iter().find(|(row, _)| row == key).map(|(_, error)| *error)
    }

    /// Compares a table with this list.
    #[must_use]
    pub fn compare(&self, table: &Table) -> Comparison {
        let mut found = Comparison::default();
        for row in &table.rows {
            let (key, listed) = (row.key(), self.error(&row.key()));
            match listed {
                Some(error) if row.passes_must => {
                    found.mended.push(format!("{key}: {:.4e}, listed {error:.4e}", row.error));
                }
                // A listed NaN stands for any error.
                Some(error) if error.is_nan() || row.error <= SLACK * error => {}
                Some(error) => {
                    found.worse.push(format!("{key}: {:.4e}, listed {error:.4e}", row.error));
                }
                None if !row.passes_must => {
                    let must = row.limits.must;
                    found.worse.push(format!("{key}: {:.4e}, must be {must:.4e}", row.error));
                }
                None => {}
            }
        }
        for skipped in &table.skipped {
            if self.error(&skipped.id).is_none() {
                found.worse.push(format!("{} did not run: {}", skipped.id, skipped.why));
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::Known;
    use crate::row::{Rows, Skipped, Unit, limits};
    use crate::table::Table;

    fn table(errors: &[(&str, f64)]) -> Table {
        let mut rows = Rows::new("A0", "a test", "");
        for (case, error) in errors {
            rows.at_most(*case, *error, Unit::Meter, limits(1.0, 0.1));
        }
        Table {
            engine: String::new(),
            version: String::new(),
            hz: 60.0,
            substeps: 0,
            set: Vec::new(),
            rows: rows.list,
            skipped: Vec::new(),
        }
    }

    #[test]
    fn a_list_of_what_fails_passes_its_own_table_and_no_worse_one() {
        let now = table(&[("good", 0.5), ("bad", 2.0), ("lost", f64::NAN)]);
        let list = Known::of(&now);
        let known = Known::parse(&list).unwrap();
        assert_eq!(known.compare(&now), super::Comparison::default(), "{list}");
        let worse = known.compare(&table(&[("good", 0.9), ("bad", 2.3), ("lost", 3.0)]));
        assert_eq!((worse.worse.len(), worse.mended.len()), (1, 0), "{worse:?}");
        let fresh = known.compare(&table(&[("good", 1.2), ("bad", 2.0), ("lost", 3.0)]));
        assert_eq!((fresh.worse.len(), fresh.mended.len()), (1, 0), "{fresh:?}");
        // A number that became NaN is worse.
        let gone = known.compare(&table(&[("good", 0.5), ("bad", f64::NAN)]));
        assert_eq!((gone.worse.len(), gone.mended.len()), (1, 0), "{gone:?}");
        let mended = known.compare(&table(&[("good", 0.5), ("bad", 0.9)]));
        assert_eq!((mended.worse.len(), mended.mended.len()), (0, 1), "{mended:?}");
    }

    #[test]
    fn a_test_that_does_not_run_is_worse_unless_listed() {
        let mut now = table(&[]);
        now.skipped.push(Skipped {
            id: "A9".to_owned(),
            name: String::new(),
            why: "no reason".to_owned(),
        });
        assert_eq!(Known::default().compare(&now).worse.len(), 1);
        assert!(Known::parse(&Known::of(&now)).unwrap().compare(&now).worse.is_empty());
    }

    #[test]
    fn comments_are_passed_over_and_other_lines_are_refused() {
        let known = Known::parse("# why\n\n0.5   A1 v, w\n").unwrap();
        assert_eq!(known.error("A1 v, w"), Some(0.5));
        assert!(Known::parse("0.5 A1\nA2 v\n").unwrap_err().to_string().starts_with("line 2"));
    }
}
