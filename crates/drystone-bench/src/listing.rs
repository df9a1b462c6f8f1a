//! Rows as text, for people.

use std::fmt::Write as _;

use crate::row::Row;

/// A line for each row under a line of titles; times of stages, where there are some, in a line below.
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
    let table: Vec<[String; 10]> =
        std::iter::once(TITLES.map(str::to_owned)).chain(rows.iter().map(cells)).collect();
    let width = |column: usize| table.iter().map(|r| r[column].chars().count()).max().unwrap_or(0);
    let widths: [usize; 10] = std::array::from_fn(width);
    let mut text = String::new();
    for (i, line) in table.iter().enumerate() {
        let mut out = String::new();
        for (column, cell) in line.iter().enumerate() {
            let width = widths[column];
            // Writing to a String cannot fail. Names stand left, numbers right.
            let _ = match column {
                0 | 1 => write!(out, "{cell:<width$}  "),
                _ => write!(out, "{cell:>width$}  "),
            };
        }
        text.push_str(out.trim_end());
        text.push('\n');
        let row = i.checked_sub(1).map(|i| &rows[i]);
        if let Some(stages) = row.and_then(|row| row.stages_ms.as_ref()) {
            let stages: Vec<String> =
                stages.0.iter().map(|(name, ms)| format!("{name} {ms:.3}")).collect();
            let _ = writeln!(text, "{:>width$}  {}", "", stages.join(", "), width = widths[0]);
        }
    }
    text
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
