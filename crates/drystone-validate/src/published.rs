//! Published results of the same tests, in the units of our rows: SimBenchmark (leggedrobotics,
//! 2018). Its figures are mean squares in joules; our rows are their roots relative to the energy.

use core::fmt::Write as _;

use crate::row::Row;
use crate::table::shown;

/// Published errors of other engines in one of our rows.
struct Published {
    /// Id of the row's test.
    id: &'static str,
    case: &'static str,
    /// Length of the step they used [ms].
    step: f64,
    /// Engine and error.
    errors: &'static [(&'static str, f64)],
}

const PUBLISHED: &[Published] = &[
    Published {
        id: "S1",
        case: "y",
        step: 1.0,
        errors: &[
            ("Bullet", 4.9e-9),
            ("ODE", 7.7e-9),
            ("RaiSim", 4.1e-7),
            ("MuJoCo", 3.2e-3),
            ("DART", 0.43),
        ],
    },
    Published {
        id: "S1",
        case: "(0.5, 0.866)",
        step: 1.0,
        errors: &[
            ("Bullet", 5.7e-9),
            ("RaiSim", 4.1e-7),
            ("MuJoCo", 2.7e-3),
            ("ODE", 3.1),
            ("DART", 3.1),
        ],
    },
    // Relative to 24034.5 J.
    Published {
        id: "A17",
        case: "E, root mean square",
        step: 4.0,
        errors: &[("RaiSim", 9.1e-5), ("ODE", 2.3e-3), ("DART", 0.045), ("Bullet", 0.046)],
    },
    Published {
        id: "S3",
        case: "mean of sums",
        step: 4.0,
        errors: &[
            ("RaiSim", 2.1e-3),
            ("ODE", 2.1e-3),
            ("MuJoCo", 0.37),
            ("Bullet", 5.8),
            ("DART", 9.3e3),
        ],
    },
    // Relative to 34454.3 J.
    Published {
        id: "S4",
        case: "E, root mean square",
        step: 4.0,
        errors: &[("RaiSim", 4.7e-4), ("ODE", 1.2e-3), ("Bullet", 0.027), ("DART", 0.075)],
    },
    Published {
        id: "S5",
        case: "mean square of its error",
        step: 4.0,
        errors: &[
            ("ODE", 5.4e-28),
            ("MuJoCo, Runge-Kutta", 3.5e-7),
            ("RaiSim", 9.1e-4),
            ("Bullet", 4.3e-3),
            ("MuJoCo, Euler", 0.013),
            ("DART", 150.0),
        ],
    },
    // Relative to 3933 J: 33.947 kg accelerated upward at 1 g for 1 s from 2 m.
    Published {
        id: "S6",
        case: "RMS of its error, per energy",
        step: 4.0,
        errors: &[
            ("MuJoCo, Runge-Kutta", 5.4e-11),
            ("RaiSim", 1.2e-4),
            ("MuJoCo, Euler", 1.9e-3),
            ("Bullet", 1.9e-3),
            ("ODE", 2.0e-3),
            ("DART", 5.0e-3),
        ],
    },
];

const HEADER: &str = "
## Beside published figures

SimBenchmark published errors of other engines in these tests, of 2018, at steps of 1 ms (S1) and 4 ms; the rows here are of the steps said
above, which take their substeps each. *Behind* are we where an engine's error is smaller.

| id | case | here | published | behind |
|---|---|---|---|---|
";

/// The ring of Kapla bricks has no error, but a time.
const KAPLA: &str = "
The ring of Kapla bricks (A38b; how it is laid is ours) must stand for 600 s. Published, at 10 ms with 1000 iterations, it falls after 548 s or stands in RaiSim (with and
without correction of errors), falls after 551 or 1.5 s in Bullet, 65 or 1.2 s in ODE, 2 to 33 s in MuJoCo, and 0.2 s in DART (100 iterations).
";

/// The rows with published results beside ours, as a section of the Markdown page.
pub(crate) fn section(rows: &[Row]) -> String {
    let mut text = String::new();
    for published in PUBLISHED {
        let is = |row: &&Row| row.id == published.id && row.case == published.case;
        let Some(row) = rows.iter().find(is) else { continue };
        if text.is_empty() {
            text.push_str(HEADER);
        }
        let theirs = published.errors.iter();
        let theirs: Vec<String> =
            theirs.map(|(engine, error)| format!("{engine} {}", shown(*error, row.unit))).collect();
        let better = published.errors.iter().filter(|(_, error)| *error < row.error);
        let better: Vec<&str> = better.map(|(engine, _)| *engine).collect();
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} ms: {} | {} |",
            row.id,
            row.case,
            shown(row.error, row.unit),
            published.step,
            theirs.join(", "),
            if better.is_empty() { "–".to_owned() } else { better.join(", ") }
        );
    }
    if rows.iter().any(|row| row.id == "A38b") {
        text.push_str(KAPLA);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{PUBLISHED, section};
    use crate::row::{Rows, Unit, limits};

    #[test]
    fn published_figures_are_of_tests_that_there_are() {
        for published in PUBLISHED {
            assert!(crate::all().any(|test| test.id == published.id), "{}", published.id);
        }
    }

    #[test]
    fn who_was_more_exact_is_named() {
        let mut rows = Rows::new("S4", "", "");
        rows.at_most("E, root mean square", 1.0e-3, Unit::Part, limits(0.01, 0.001));
        let text = section(&rows.list);
        assert!(text.contains("| 0.1 % | 4 ms: RaiSim 0.047 %, ODE 0.12 %"), "{text}");
        assert!(text.contains("| RaiSim |\n"), "{text}");
        assert_eq!(section(&[]), "");
    }
}
