//! Searches for the smallest world that fails in the same way.

use std::time::Duration;

use super::floors::FIRST_BODY;
use super::measures::measures;
use super::watch::Watched;
use super::{Scene, program, twins, watch};
use crate::apply;
use crate::finding::{Finding, Findings, Kind};
use crate::minimize::minimize_by;
use crate::op::{BodyPlan, Form, Op, Program};
use crate::run::Run;

/// Findings in the world of a seed and its twins.
#[must_use]
pub fn findings_of(scene: Scene, seed: u64) -> Vec<Finding> {
    let program = program(scene, seed);
    judge(&program, watch::watch(&program, None), true).findings.all
}

/// The smallest program found within a time that fails like the world of a seed.
#[must_use]
pub fn minimize(scene: Scene, seed: u64, like: &Finding, time: Duration) -> Program {
    let whole = program(scene, seed);
    let has_twins = like.kind == Kind::Twin;
    let sound = Sound::of(&whole);
    minimize_by(whole, like, time, &|program| {
        let watched = watch::watch(program, None);
        if sound.holds(program, &watched) {
            judge(program, watched, has_twins)
        } else {
            Run { done: watched.done, ..Run::default() }
        }
    })
}

fn judge(program: &Program, watched: Watched, has_twins: bool) -> Run {
    let mut findings: Findings = watched.findings.clone();
    if has_twins {
        let _ = twins::compare(program, &watched, &mut findings);
    }
    let Watched { done, refused, is_cut, .. } = watched;
    Run { done, refused, is_cut, findings, ..Run::default() }
}

/// Properties that a world must keep while it shrinks, so that its finding still violates physics.
/// A world with overlapping bodies, or with long steps, fails for other reasons.
#[derive(Debug)]
struct Sound {
    /// Maximum length of its steps [s].
    longest: f32,
    shortest: f32,
    is_overlapped: bool,
    /// Bodies of the floor, as `Debug` text.
    floor: Vec<String>,
}

/// Minimum thickness of a hull relative to its length; a thinner one is a splinter.
const SPLINTER: f32 = 0.02;

impl Sound {
    fn of(program: &Program) -> Self {
        let is_overlapped = watch::watch(program, None).is_overlapped;
        let shortest = lengths(program).fold(f32::INFINITY, f32::min);
        let longest = lengths(program).fold(0.0, f32::max);
        Self { longest, shortest, is_overlapped, floor: floor_of(program).collect() }
    }

    fn holds(&self, program: &Program, watched: &Watched) -> bool {
        let plain = 1.0 / 60.0;
        let range = self.shortest.min(plain)..=self.longest.max(plain);
        let is_short = lengths(program).all(|dt| range.contains(&dt));
        let is_apart = !watched.is_overlapped || self.is_overlapped;
        is_short
            && is_apart
            && floor_of(program).all(|body| self.floor.contains(&body))
            && !program.ops.iter().any(|op| matches!(op, Op::AddBody(plan) if is_splinter(plan)))
    }
}

fn lengths(program: &Program) -> impl Iterator<Item = f32> {
    let steps = program.ops.iter();
    steps.filter_map(|op| if let Op::Step(dt, _) = op { Some(*dt) } else { None })
}

fn floor_of(program: &Program) -> impl Iterator<Item = String> {
    program.ops.iter().filter_map(|op| match op {
        Op::AddBody(plan) if plan.label < FIRST_BODY => Some(format!("{plan:?}")),
        _ => None,
    })
}

fn is_splinter(plan: &BodyPlan) -> bool {
    let hulls = plan.shapes.iter().filter(|shape| matches!(shape.form, Form::Hull(_)));
    let measured = hulls.filter_map(|shape| measures(&apply::shape(&shape.form)?));
    measured.into_iter().any(|m| m.thin < SPLINTER * m.large)
}
