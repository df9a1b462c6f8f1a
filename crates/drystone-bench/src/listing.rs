//! Rows as text for a terminal.

use std::fmt::Write as _;

use crate::row::Row;

/// Returns a line for each row under a line of titles. Times of stages, if any, follow on a line of
/// their own.
#[must_use]
pub fn listing(rows: &[Row]) -> String {
    const TITLES: [&str; 10] = [
        "scene", "engine", "threads", "ms/step", "min", "p99", "deepest", "stands", "hash",
        "bodies",
    ];
    let cells = |row: &Row| {
        let ms = row.ms_per_step;
        let stands = row.stands.map_or("-", |stands| if stands { "yes" } else { "NO" });
        [
            row.scene.clone(),
            row.engine.clone(),
            row.threads.to_string(),
            format!("{:.4}", ms.median),
            format!("{:.4}", ms.min),
            format!("{:.4}", ms.p99),
            format!("{:.2} mm", 1000.0 * row.max_penetration),
            stands.to_owned(),
            row.hash.clone(),
            row.bodies.to_string(),
        ]
    };
    let (lines, indent) = columns(2, TITLES, rows.iter().map(cells));
    let mut text = String::new();
    for (i, line) in lines.iter().enumerate() {
        text.push_str(line);
        text.push('\n');
        let row = i.checked_sub(1).map(|i| &rows[i]);
        if let Some(stages) = row.and_then(|row| row.stages_ms.as_ref()) {
            let stages: Vec<String> =
                stages.0.iter().map(|(name, ms)| format!("{name} {ms:.3}")).collect();
            // Writing to a String cannot fail.
            let _ = writeln!(text, "{:>indent$}  {}", "", stages.join(", "));
        }
    }
    text
}

/// Lines of a table, its titles first, and the width of its first column. The first `names` columns
/// are aligned left, numbers right.
pub(crate) fn columns<const N: usize>(
    names: usize,
    titles: [&str; N],
    rows: impl Iterator<Item = [String; N]>,
) -> (Vec<String>, usize) {
    let table: Vec<[String; N]> = std::iter::once(titles.map(str::to_owned)).chain(rows).collect();
    let width = |column: usize| table.iter().map(|r| r[column].chars().count()).max().unwrap_or(0);
    let widths: [usize; N] = std::array::from_fn(width);
    let line = |cells: &[String; N]| {
        let mut out = String::new();
        for (column, cell) in cells.iter().enumerate() {
            let width = widths[column];
            // Writing to a String cannot fail.
            let _ = if column < names {
                write!(out, "{cell:<width$}  ")
            } else {
                write!(out, "{cell:>width$}  ")
            };
        }
        out.truncate(out.trim_end().len());
        out
    };
    (table.iter().map(line).collect(), widths[0])
}

#[cfg(test)]
mod tests {
    use super::listing;
    use crate::row::tests::row;

    #[test]
    fn every_row_has_its_line() {
        let text = listing(&[row("self", 1, 0.5), row("rapier", 12, 1.0)]);
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[0].starts_with("scene  engine"), "{text}");
        assert!(lines[1].contains("self") && lines[1].contains("1.00 mm"), "{text}");
        assert!(lines[2].trim_start().starts_with("solver 0.500, a 0.250"), "{text}");
        assert!(lines[3].contains("rapier") && lines[3].contains("yes"), "{text}");
    }
}
