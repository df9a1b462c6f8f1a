//! The order of the stages: the calls in step/mod.rs, and the list in ARCHITECTURE.md.

use super::rust::{Source, block_end, is_word, words};
use super::{Tree, finding, line_of};

const STEP: &str = "crates/drystone/src/step/mod.rs";
const PAGE: &str = "ARCHITECTURE.md";
/// The stages that `fn step` calls. The world itself runs the last one.
const STAGES: [&str; 9] = [
    "broadphase",
    "narrowphase",
    "partition",
    "particles",
    "solver",
    "finalize",
    "sweep",
    "sleep",
    "report",
];
const LAST: &str = "breakage";

pub fn check(tree: &Tree) -> Vec<String> {
    let called = tree.text(STEP).ok_or("no such file").and_then(calls);
    let listed = tree.text(PAGE).ok_or("no such file").and_then(list);
    let (called, listed) = match (called, listed) {
        (Ok(called), Ok(listed)) => (called, listed),
        (called, listed) => {
            let errors = [(STEP, called.err()), (PAGE, listed.err())].into_iter();
            let errors = errors.filter_map(|(path, error)| Some(finding(path, 1, error?)));
            return errors.collect();
        }
    };
    let mut findings = Vec::new();
    for stage in STAGES {
        for (path, found) in [(STEP, &called), (PAGE, &listed)] {
            if found.iter().all(|(_, name)| name != stage) {
                findings.push(finding(path, 1, &format!("the stage `{stage}` is missing")));
            }
        }
    }
    if findings.is_empty() {
        let order =
            |list: &[(usize, String)]| list.iter().map(|(_, s)| s.clone()).collect::<Vec<_>>();
        let (mut calls, page) = (order(&called), order(&listed));
        calls.push(LAST.to_owned());
        if calls != page {
            let line = called.first().map_or(1, |(line, _)| *line);
            let what = format!("calls {}, but {PAGE} lists {}", calls.join(", "), page.join(", "));
            findings.push(finding(STEP, line, &what));
        }
    }
    findings
}

/// Line and stage of the calls in `fn step`; consecutive calls of one stage count once.
fn calls(text: &str) -> Result<Vec<(usize, String)>, &'static str> {
    let code = Source::new(text).code_without_tests();
    let start = words(&code, "pub(crate) fn step").next().ok_or("no `pub(crate) fn step`")?;
    let open = code[start..].find('{').ok_or("`fn step` has no body")? + start;
    let body = &code[..block_end(&code, open)];
    let mut found: Vec<(usize, &str)> = Vec::new();
    for stage in STAGES {
        for at in words(body, stage).filter(|&at| at > open && is_call(&body[at + stage.len()..])) {
            found.push((at, stage));
        }
    }
    found.sort_unstable();
    found.dedup_by_key(|(_, stage)| *stage);
    Ok(found.into_iter().map(|(at, stage)| (line_of(text, at), stage.to_owned())).collect())
}

/// Whether `::name(` follows.
fn is_call(rest: &str) -> bool {
    let name =
        rest.strip_prefix("::").map(|name| name.trim_start_matches(|c: char| is_word_char(c)));
    name.is_some_and(|after| after.starts_with('('))
}

fn is_word_char(c: char) -> bool {
    u8::try_from(c).is_ok_and(is_word)
}

/// Line and stage of the numbered items under "## The step".
fn list(text: &str) -> Result<Vec<(usize, String)>, &'static str> {
    let mut lines = text.lines().enumerate();
    lines.find(|(_, line)| line.trim_end() == "## The step").ok_or("no heading `## The step`")?;
    let section = lines.take_while(|(_, line)| !line.starts_with("## "));
    let items = section.filter_map(|(at, line)| {
        let (number, rest) = line.split_once(". ")?;
        number.parse::<u32>().ok()?;
        let rest = rest.trim_start_matches(['*', '`']);
        let end = rest.find(|c: char| !is_word_char(c)).unwrap_or(rest.len());
        Some((at + 1, rest[..end].to_owned()))
    });
    Ok(items.collect())
}
