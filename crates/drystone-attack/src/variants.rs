//! Runs the same program under conditions that must not change the result: threads, SIMD levels,
//! snapshots, clones.

use crate::finding::{Findings, Kind};
use crate::op::Program;
use crate::run::{Conditions, Run, run};

/// Steps between two restarts from a snapshot.
pub const RESTORE_EVERY: u32 = 5;

/// Steps between two excursions that are rolled back.
pub const BACK_EVERY: u32 = 3;

/// Conditions to compare with the base, and their names.
#[must_use]
pub fn of(program: &Program) -> [(&'static str, Conditions); 5] {
    let base = Conditions { look: false, ..Conditions::BASE };
    let middle = Some(program.steps() / 2);
    [
        ("2 threads", Conditions { threads: 2, ..base }),
        (
            "4 threads, the lowest SIMD level, a clone",
            Conditions { threads: 4, level: usize::MAX, clone_at: middle, ..base },
        ),
        // Restarts are frequent: data that a world prepares for its next steps must equal the data
        // that a restored world recomputes.
        (
            "goes on from snapshots",
            Conditions { restore_every: Some(RESTORE_EVERY), level: 1, ..base },
        ),
        (
            "goes back to what it kept",
            Conditions { back_every: Some(BACK_EVERY), threads: 2, ..base },
        ),
        ("is called by data", Conditions { written: true, ..base }),
    ]
}

/// Runs a program under each condition, and compares it with its base run; returns the number of
/// steps.
pub fn compare(program: &Program, base: &Run, findings: &mut Findings) -> usize {
    let mut steps = 0;
    for (name, conditions) in of(program) {
        let other = run(program, &conditions);
        steps += other.hashes.len();
        for finding in other.findings.all.clone() {
            findings.add(finding.kind, finding.what, finding.detail, finding.step);
        }
        if let Some(at) = first_difference(base, &other) {
            let step = u32::try_from(at + 1).unwrap_or(u32::MAX);
            findings.add(Kind::HashDiffers, name, format!("from step {step} on"), step);
        }
    }
    steps
}

/// Number of the first step, from 0, after which two runs differ.
fn first_difference(a: &Run, b: &Run) -> Option<usize> {
    let different = a.hashes.iter().zip(&b.hashes).position(|(a, b)| a != b);
    let is_whole = !a.is_cut && !b.is_cut && a.findings.all.is_empty() && b.findings.all.is_empty();
    let (short, long) = (a.hashes.len().min(b.hashes.len()), a.hashes.len().max(b.hashes.len()));
    different.or_else(|| (is_whole && short < long).then_some(short))
}
