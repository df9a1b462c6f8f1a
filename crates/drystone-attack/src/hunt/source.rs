//! Writes a world of the hunt as the source of a test.

use super::Scene;
use super::facts::Facts;
use crate::finding::{Finding, Kind};
use crate::op::Program;
use crate::source;

/// The source of a test that runs the program and asserts that the finding does not occur.
#[must_use]
pub fn test(program: &Program, scene: Scene, seed: u64, finding: &Finding) -> String {
    let facts = Facts::of(program);
    let name = format!("{}_{}_{seed}", scene.name(), finding.kind.name().replace('-', "_"));
    let checks = checks(finding, &facts);
    source::test_with(program, &name, &checks, finding)
}

/// Lines for a test: before the first step, after each step, after the last.
fn checks(finding: &Finding, facts: &Facts) -> source::Checks {
    let lines = |text: &[&str]| text.iter().map(|line| (*line).to_owned()).collect::<Vec<_>>();
    let mut checks = source::Checks::default();
    match finding.kind {
        Kind::Energy if facts.is_closed() => {
            checks.before = lines(&[
                "world.begin_ledger();",
                "let (mut lost, mut kinetic) = (0.0_f64, 0.0_f64);",
            ]);
            checks.each = lines(&[
                "let ledger = world.audit().ledger.unwrap();",
                "kinetic = kinetic.max(ledger.now.kinetic());",
                "// What is lost must not come back, but for a part of what moved.",
                "assert!(lost - ledger.dissipated <= 0.03 * kinetic, \"{ledger:?}\");",
                "lost = lost.max(ledger.dissipated);",
            ]);
        }
        Kind::Momentum => {
            checks.before = lines(&["let start = world.audit().momentum;"]);
            checks.end = lines(&[
                "let end = world.audit().momentum;",
                "let (p, l) = (end.linear - start.linear, end.about_center - start.about_center);",
                "assert!(p.length() <= 1.0e-3 * start.linear.length(), \"{p:?} of {start:?}\");",
                "assert!(l.length() <= 1.0e-2 * start.about_center.length(), \"{l:?} of {start:?}\");",
            ]);
        }
        Kind::Through | Kind::Overlap => {
            checks.end = lines(&[
                "let deepest = world.audit().penetration;",
                "assert!(deepest.max < 1.0e-2, \"{deepest:?}\"); // A part of the thinner body.",
                "for body in world.bodies() {",
                "println!(\"{:?}\", body.position()); // Which of them is where it cannot have come?",
                "}",
            ]);
        }
        Kind::Gap => {
            checks.end = lines(&["assert!(world.joints().all(|j| j.error() < 1.0e-2));"]);
        }
        Kind::Balance | Kind::Stalled => {
            checks.end = lines(&["assert!(world.bodies().all(|b| !b.is_asleep()));"]);
        }
        Kind::Missed => {
            checks.before = lines(&["let mut told = 0;"]);
            checks.each =
                lines(&["told += world.events().hits.len() + world.events().sensor_enter.len();"]);
            checks.end = lines(&["assert!(told > 0);"]);
        }
        Kind::Restless => {
            checks.end = lines(&["assert_eq!(world.counts().asleep, world.counts().dynamic);"]);
        }
        Kind::Glide => {
            for (label, made) in facts.movers() {
                let v = made.linear_velocity;
                checks.names.push(label);
                checks.each.push(format!(
                    "let off = world.body(b{label}).unwrap().linear_velocity() - vec3({:?}, {:?}, {:?});",
                    v.x, v.y, v.z
                ));
                let allowed = 0.02 * v.length();
                checks.each.push(format!("assert!(off.length() < {allowed:?}, \"{{off:?}}\");"));
            }
        }
        Kind::Fallen | Kind::Bounce => {
            for (label, made) in facts.movers() {
                let at = made.position;
                checks.names.push(label);
                let still = finding.kind == Kind::Fallen;
                let what = if still { ".length()" } else { ".y" };
                checks.each.push(format!(
                    "let off = world.body(b{label}).unwrap().position() - vec3({:?}, {:?}, {:?});",
                    at.x, at.y, at.z
                ));
                let allowed = 0.05 * (made.up + made.down);
                checks.each.push(format!("assert!(off{what} < {allowed:?}, \"{{off:?}}\");"));
            }
        }
        _ => {
            checks.end = lines(&["// What is said above must not be so: assert it here."]);
        }
    }
    checks
}
