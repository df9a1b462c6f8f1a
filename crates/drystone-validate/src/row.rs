//! A row of the table: the case, the expected and measured values, and the verdicts.

use serde::{Deserialize, Serialize};

/// The allowed error and the target error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// Maximum error; a larger one is a failure.
    pub must: f64,
    /// Target error.
    pub great: f64,
}

/// Limits of an error: allowed and target.
#[must_use]
pub const fn limits(must: f64, great: f64) -> Limits {
    Limits { must, great }
}

/// Unit of an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Unit {
    /// Fraction of the expected value, or of another reference that the test names.
    #[serde(rename = "relative")]
    Part,
    /// Meters.
    #[serde(rename = "m")]
    Meter,
    /// Square meters.
    #[serde(rename = "m²")]
    SquareMeter,
    /// Seconds.
    #[serde(rename = "s")]
    Second,
    /// Radians.
    #[serde(rename = "rad")]
    Radian,
    /// Radians per second.
    #[serde(rename = "rad/s")]
    RadianPerSecond,
    /// Meters per second.
    #[serde(rename = "m/s")]
    MeterPerSecond,
    /// Square of a speed.
    #[serde(rename = "m²/s²")]
    SquareSpeed,
    /// Square of a momentum.
    #[serde(rename = "kg²m²/s²")]
    SquareMomentum,
    /// Number of failures.
    #[serde(rename = "count")]
    Count,
}

impl Unit {
    /// The unit's symbol after a number.
    #[must_use]
    pub const fn symbol(self) -> &'static str {
        match self {
            Self::Part | Self::Count => "",
            Self::Meter => "m",
            Self::SquareMeter => "m²",
            Self::Second => "s",
            Self::Radian => "rad",
            Self::RadianPerSecond => "rad/s",
            Self::MeterPerSecond => "m/s",
            Self::SquareSpeed => "m²/s²",
            Self::SquareMomentum => "kg²m²/s²",
        }
    }
}

/// A row.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Id of its test, `A16`.
    pub id: String,
    /// Name of its test.
    pub name: String,
    /// The variant: `e 0.5, apex`. With the id it names the row.
    pub case: String,
    /// The closed form, in words.
    pub closed_form: String,
    /// The exact value.
    #[serde(with = "number")]
    pub expected: f64,
    /// The measured value.
    #[serde(with = "number")]
    pub measured: f64,
    /// The difference, as the test measures it.
    #[serde(with = "number")]
    pub error: f64,
    /// The error of a harder run, if `great` applies to one.
    #[serde(default, with = "harder")]
    pub harder: Option<f64>,
    /// Unit of the error.
    pub unit: Unit,
    /// Limits of the error.
    pub limits: Limits,
    /// Whether the error is within `must`.
    pub passes_must: bool,
    /// Whether the error is within `must`, and that of the harder run, if any, or else the error
    /// itself, within `great`.
    pub passes_great: bool,
}

impl Row {
    /// Its unique name among all rows.
    #[must_use]
    pub fn key(&self) -> String {
        format!("{} {}", self.id, self.case)
    }
}

/// A test that did not run, and why.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Skipped {
    /// Its id.
    pub id: String,
    /// Its name.
    pub name: String,
    /// The reason.
    pub why: String,
}

/// Collects the rows of a test.
#[derive(Debug)]
pub struct Rows {
    id: &'static str,
    name: &'static str,
    closed_form: &'static str,
    /// The rows so far.
    pub list: Vec<Row>,
}

impl Rows {
    /// Starts an empty list.
    #[must_use]
    pub const fn new(id: &'static str, name: &'static str, closed_form: &'static str) -> Self {
        Self { id, name, closed_form, list: Vec::new() }
    }

    /// Adds a row whose error is relative to the expected value.
    pub fn relative(&mut self, case: impl Into<String>, expected: f64, measured: f64, l: Limits) {
        let error = ((measured - expected) / expected).abs();
        self.push(case.into(), [expected, measured, error], Unit::Part, l, None);
    }

    /// Adds a row whose error is the difference, in a unit.
    pub fn absolute(
        &mut self,
        case: impl Into<String>,
        expected: f64,
        measured: f64,
        unit: Unit,
        l: Limits,
    ) {
        let error = (measured - expected).abs();
        self.push(case.into(), [expected, measured, error], unit, l, None);
    }

    /// Adds a row about a value that should be zero and must not exceed the limits.
    pub fn at_most(&mut self, case: impl Into<String>, measured: f64, unit: Unit, l: Limits) {
        self.push(case.into(), [0.0, measured, measured], unit, l, None);
    }

    /// As `at_most`, but `great` applies to a harder run.
    pub fn at_most_harder(
        &mut self,
        case: impl Into<String>,
        (measured, harder): (f64, f64),
        unit: Unit,
        l: Limits,
    ) {
        self.push(case.into(), [0.0, measured, measured], unit, l, Some(harder));
    }

    /// Adds a row whose error the test computed itself.
    pub fn error(
        &mut self,
        case: impl Into<String>,
        (expected, measured): (f64, f64),
        error: f64,
        unit: Unit,
        l: Limits,
    ) {
        self.push(case.into(), [expected, measured, error], unit, l, None);
    }

    /// Adds a row about a condition, for the run of `must` and for the harder one.
    pub fn holds(&mut self, case: impl Into<String>, must: bool, great: bool) {
        let count = |yes: bool| if yes { 0.0 } else { 1.0 };
        let numbers = [1.0, 1.0 - count(must), count(must)];
        self.push(case.into(), numbers, Unit::Count, limits(0.0, 0.0), Some(count(great)));
    }

    fn push(
        &mut self,
        case: String,
        [expected, measured, error]: [f64; 3],
        unit: Unit,
        limits: Limits,
        harder: Option<f64>,
    ) {
        // Written so that NaN fails.
        let passes_must = error <= limits.must;
        let passes_great = passes_must && harder.unwrap_or(error) <= limits.great;
        self.list.push(Row {
            id: self.id.to_owned(),
            name: self.name.to_owned(),
            case,
            closed_form: self.closed_form.to_owned(),
            expected,
            measured,
            error,
            harder,
            unit,
            limits,
            passes_must,
            passes_great,
        });
    }
}

/// JSON has no NaN and no infinity, so they are written as text.
mod number {
    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    #[derive(Deserialize)]
    #[serde(untagged)]
    pub(super) enum Either {
        Number(f64),
        Text(String),
    }

    impl Either {
        pub(super) fn number<E: Error>(self) -> Result<f64, E> {
            match self {
                Self::Number(x) => Ok(x),
                Self::Text(text) => text.parse().map_err(E::custom),
            }
        }
    }

    pub(super) fn serialize<S: Serializer>(x: &f64, to: S) -> Result<S::Ok, S::Error> {
        if x.is_finite() { to.serialize_f64(*x) } else { to.serialize_str(&x.to_string()) }
    }

    pub(super) fn deserialize<'d, D: Deserializer<'d>>(from: D) -> Result<f64, D::Error> {
        Either::deserialize(from)?.number()
    }
}

mod harder {
    use serde::{Deserialize, Deserializer, Serializer};

    use super::number::{self, Either};

    pub(super) fn serialize<S: Serializer>(x: &Option<f64>, to: S) -> Result<S::Ok, S::Error> {
        match x {
            Some(x) => number::serialize(x, to),
            None => to.serialize_none(),
        }
    }

    pub(super) fn deserialize<'d, D: Deserializer<'d>>(from: D) -> Result<Option<f64>, D::Error> {
        Option::<Either>::deserialize(from)?.map(Either::number).transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::{Rows, Unit, limits};

    fn rows() -> Rows {
        Rows::new("A0", "a test", "x = 2")
    }

    fn verdicts(rows: &Rows) -> Vec<(bool, bool)> {
        rows.list.iter().map(|row| (row.passes_must, row.passes_great)).collect()
    }

    #[test]
    fn a_wrong_value_fails_and_a_right_one_passes() {
        let mut rows = rows();
        for measured in [2.0, 2.01, 1.99, 2.03, 1.97, -2.0, 0.0] {
            rows.relative("", 2.0, measured, limits(0.01, 0.001));
        }
        let wrong = (false, false);
        let fair = (true, false);
        assert_eq!(verdicts(&rows)[..3], [(true, true), fair, fair]);
        assert_eq!(verdicts(&rows)[3..], [wrong; 4]);
    }

    #[test]
    fn the_sign_of_the_expected_value_does_not_hide_an_error() {
        let mut rows = rows();
        rows.relative("", -2.0, -3.0, limits(0.01, 0.001));
        rows.absolute("", -2.0, -3.0, Unit::Meter, limits(0.5, 0.1));
        rows.absolute("", 0.0, -0.4, Unit::Meter, limits(0.5, 0.4));
        assert_eq!(verdicts(&rows), [(false, false), (false, false), (true, true)]);
    }

    #[test]
    fn what_is_no_number_fails_every_kind_of_row() {
        let mut rows = rows();
        let l = limits(f64::INFINITY, f64::INFINITY);
        rows.relative("", 2.0, f64::NAN, l);
        rows.relative("", 0.0, 0.0, l);
        rows.absolute("", f64::NAN, 1.0, Unit::Meter, l);
        rows.at_most("", f64::NAN, Unit::Meter, l);
        rows.at_most_harder("", (f64::NAN, 0.0), Unit::Meter, l);
        rows.error("", (0.0, 0.0), f64::NAN, Unit::Part, l);
        assert_eq!(verdicts(&rows), [(false, false); 6]);
        rows.at_most_harder("", (0.0, f64::NAN), Unit::Meter, l);
        assert_eq!(verdicts(&rows)[6], (true, false));
    }

    #[test]
    fn rows_read_back_as_they_were_written_numbers_or_not() {
        let mut rows = rows();
        let l = limits(1.0, 0.5);
        rows.at_most_harder("a", (0.7, f64::INFINITY), Unit::Meter, l);
        rows.at_most("b", 0.1 + 0.2, Unit::SquareMeter, l);
        let text = serde_json::to_string(&rows.list).unwrap();
        assert_eq!(serde_json::from_str::<Vec<super::Row>>(&text).unwrap(), rows.list);
        rows.at_most("c", f64::NAN, Unit::Part, l);
        let text = serde_json::to_string(&rows.list[2]).unwrap();
        assert!(serde_json::from_str::<super::Row>(&text).unwrap().error.is_nan());
    }

    #[test]
    fn a_harder_run_decides_about_great_alone() {
        let mut rows = rows();
        rows.at_most_harder("", (0.1, 5.0), Unit::Meter, limits(1.0, 1.0));
        rows.at_most_harder("", (5.0, 0.1), Unit::Meter, limits(1.0, 1.0));
        rows.holds("", true, false);
        rows.holds("", false, true);
        rows.holds("", true, true);
        let expected = [(true, false), (false, false), (true, false), (false, false), (true, true)];
        assert_eq!(verdicts(&rows), expected);
    }
}
