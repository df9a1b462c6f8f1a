//! Parts of a program in a separate process, used to shrink programs that hang or kill the process.

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::finding::{Finding, Kind};
use crate::generate;
use crate::op::{Op, Program};
use crate::run::{Conditions, run};
use crate::variants;

/// Time after which a part counts as hanging; programs are small by then.
const LIMIT: Duration = Duration::from_secs(8);

/// The program of a seed, reduced to some of its operations. `keep` lists them by number, and steps
/// with a count: `0,3,7x12`.
#[must_use]
pub fn part(seed: u64, keep: &str) -> Program {
    let program = generate::program(seed);
    if keep == "all" {
        return program;
    }
    let mut ops = Vec::new();
    for word in keep.split(',') {
        let (number, count) = word.split_once('x').unwrap_or((word, ""));
        let Some(op) = number.parse::<usize>().ok().and_then(|n| program.ops.get(n)) else {
            continue;
        };
        ops.push(match (op, count.parse()) {
            (Op::Step(dt, _), Ok(count)) => Op::Step(*dt, count),
            _ => op.clone(),
        });
    }
    Program { ops, ..program }
}

/// Runs a part of a program, also under other conditions; called in the separate process.
pub fn probe(seed: u64, keep: &str, trace: Option<fn(&str)>) {
    let program = part(seed, keep);
    let base = run(&program, &Conditions { trace, ..Conditions::BASE });
    let mut findings = base.findings.clone();
    let _ = variants::compare(&program, &base, &mut findings);
}

/// How the process of a part fails, if it does.
fn end_of(seed: u64, keep: &[String]) -> Option<Kind> {
    let program = std::env::current_exe().ok()?;
    let mut command = Command::new(program);
    command.args(["probe", &seed.to_string(), &keep.join(",")]);
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let mut child = command.spawn().ok()?;
    let start = Instant::now();
    loop {
        match child.try_wait().ok()? {
            Some(status) => return (!status.success()).then_some(Kind::Crash),
            None if start.elapsed() > LIMIT => {
                let _ = child.kill();
                let _ = child.wait();
                return Some(Kind::Hang);
            }
            None => std::thread::sleep(Duration::from_millis(2)),
        }
    }
}

/// The smallest part found within a time whose process hangs or crashes like the whole; `None` if
/// it ends normally.
#[must_use]
pub fn minimize(seed: u64, time: Duration) -> Option<(Program, Finding)> {
    let end = Instant::now() + time;
    let whole = generate::program(seed);
    let word = |(i, op): (usize, &Op)| match op {
        Op::Step(_, count) => format!("{i}x{count}"),
        _ => i.to_string(),
    };
    let mut keep: Vec<String> = whole.ops.iter().enumerate().map(word).collect();
    let kind = end_of(seed, &keep)?;
    let mut size = keep.len();
    while size > 0 {
        let mut at = 0;
        while at < keep.len() && Instant::now() < end {
            let mut next = keep.clone();
            next.drain(at..(at + size).min(keep.len()));
            if end_of(seed, &next) == Some(kind) {
                keep = next;
            } else {
                at += size;
            }
        }
        size /= 2;
    }
    for i in 0..keep.len() {
        while Instant::now() < end {
            let Some((number, count)) = keep[i].split_once('x') else { break };
            let Ok(count) = count.parse::<u32>() else { break };
            let mut next = keep.clone();
            next[i] = format!("{number}x{}", count / 2);
            if count < 2 || end_of(seed, &next) != Some(kind) {
                break;
            }
            keep = next;
        }
    }
    let what = format!("operations {}", keep.join(","));
    let finding = Finding { kind, what, detail: String::new(), step: 0 };
    Some((part(seed, &keep.join(",")), finding))
}

#[cfg(test)]
mod tests {
    use super::part;
    use crate::op::Op;

    #[test]
    fn parts_are_named_by_numbers_and_counts() {
        let whole = part(3, "all");
        let step = whole.ops.iter().position(|op| matches!(op, Op::Step(..))).unwrap();
        let small = part(3, &format!("0,{step}x2"));
        assert_eq!(small.ops.len(), 2);
        assert!(matches!(small.ops[1], Op::Step(_, 2)));
    }
}
