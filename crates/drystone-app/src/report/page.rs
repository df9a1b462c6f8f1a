//! Text for people: lines by subject, numbers with their units.

use std::fmt::{Display, Write as _};

/// Lines of text, each with its subject.
#[derive(Debug, Default)]
pub(crate) struct Page {
    /// The lines so far.
    pub(crate) text: String,
    last: String,
}

impl Page {
    /// Adds a line; the subject stands once where lines of the same subject follow each other.
    pub(crate) fn row(&mut self, subject: &str, what: &str) {
        let shown = if subject == self.last { "" } else { subject };
        // Writing to a String cannot fail.
        let _ = writeln!(self.text, "{shown:<13}{what}");
        subject.clone_into(&mut self.last);
    }
}

/// `n thing` or `n things`.
pub(crate) fn count(n: impl Display, thing: &str) -> String {
    let n = n.to_string();
    match thing {
        _ if n == "1" => format!("1 {thing}"),
        "body" => format!("{n} bodies"),
        _ => format!("{n} {thing}s"),
    }
}

/// A number of four digits with its unit and the prefix that suits.
pub(crate) fn si(value: f64, unit: &str) -> String {
    let size = value.abs();
    let (scale, prefix) = match size {
        0.0 => return format!("0 {unit}"),
        s if s >= 1.0e6 => (1.0e-6, "M"),
        s if s >= 1.0e4 => (1.0e-3, "k"),
        s if s >= 0.1 => (1.0, ""),
        s if s >= 1.0e-4 => (1.0e3, "m"),
        s if s >= 1.0e-7 => (1.0e6, "u"),
        _ => return format!("{value:.1e} {unit}"),
    };
    let scaled = value * scale;
    let places = match scaled.abs() {
        s if s >= 1000.0 => 0,
        s if s >= 100.0 => 1,
        s if s >= 10.0 => 2,
        _ => 3,
    };
    format!("{scaled:.places$} {prefix}{unit}")
}

/// A number of bytes.
#[expect(clippy::cast_precision_loss, reason = "shown with two digits")]
pub(crate) fn bytes(n: u64) -> String {
    match n {
        0..10_000 => count(n, "byte"),
        10_000..1_000_000 => format!("{:.0} kB", n as f64 * 1.0e-3),
        _ => format!("{:.1} MB", n as f64 * 1.0e-6),
    }
}

#[cfg(test)]
mod tests {
    use super::{Page, bytes, si};

    #[test]
    fn numbers_are_shown_with_a_prefix() {
        assert_eq!(si(0.0, "m"), "0 m");
        assert_eq!(si(0.001_234_5, "m"), "1.234 mm");
        assert_eq!(si(-12_345.0, "J"), "-12.35 kJ");
        assert_eq!(si(3.0e-6, "m"), "3.000 um");
        assert_eq!(si(f64::NAN, "J"), "NaN J");
        assert_eq!(bytes(1), "1 byte");
        assert_eq!(bytes(1_500_000), "1.5 MB");
    }

    #[test]
    fn a_subject_is_said_once() {
        let mut page = Page::default();
        page.row("note", "one");
        page.row("note", "two");
        assert_eq!(page.text, "note         one\n             two\n");
    }
}
