//! The smallest world that still breaks the same.

use std::time::Duration;

use super::{Scene, program, twins, watch};
use crate::finding::{Finding, Findings, Kind};
use crate::minimize::minimize_by;
use crate::op::Program;
use crate::run::Run;

/// What the world of a seed breaks, its twins too.
#[must_use]
pub fn findings_of(scene: Scene, seed: u64) -> Vec<Finding> {
    judge(&program(scene, seed), true).findings.all
}

/// The smallest program found within a time that breaks what the world of a seed breaks.
#[must_use]
pub fn minimize(scene: Scene, seed: u64, like: &Finding, time: Duration) -> Program {
    let has_twins = like.kind == Kind::Twin;
    minimize_by(program(scene, seed), like, time, &|program| judge(program, has_twins))
}

fn judge(program: &Program, has_twins: bool) -> Run {
    let watched = watch::watch(program, None);
    let mut findings: Findings = watched.findings.clone();
    if has_twins {
        let _ = twins::compare(program, &watched, &mut findings);
    }
    Run {
        done: watched.done,
        refused: watched.refused,
        is_cut: watched.is_cut,
        findings,
        ..Run::default()
    }
}
