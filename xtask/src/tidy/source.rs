//! Source files: where `unsafe` is allowed, maximum length, and an issue for every note for later.

use super::rust::{Source, words};
use super::{Tree, finding, is_test_file, line_of};

/// The only folder with unsafe code. A test binary may also have it: a counting allocator needs it.
const UNSAFE: &str = "crates/drystone/src/base/";
/// The one unsafe expression elsewhere in the engine: the promise that borrowed rows are disjoint.
const PROMISE: &str = "unsafe { Apart::promise() }";
const ENGINE: &str = "crates/drystone/src/";
const NOTES: [&str; 2] = [concat!("TO", "DO"), concat!("FIX", "ME")];

pub fn check(tree: &Tree) -> Vec<String> {
    let mut findings = Vec::new();
    for (path, text) in tree.with_extension("rs") {
        let source = Source::new(text);
        let ours = path.starts_with("crates/") || path.starts_with("xtask/");
        if ours && !path.starts_with(UNSAFE) && !path.contains("/tests/") {
            let promises =
                |at: usize| path.starts_with(ENGINE) && source.code[at..].starts_with(PROMISE);
            for at in words(&source.code, "unsafe").filter(|at| !promises(*at)) {
                let what = format!("`unsafe` outside {UNSAFE}");
                findings.push(finding(path, line_of(text, at), &what));
            }
        }
        let tests: usize = source.unit_tests().into_iter().map(|r| text[r].lines().count()).sum();
        let lines = text.lines().count() - tests.min(text.lines().count());
        let most = max_lines(path);
        if path.starts_with("crates/") && !is_test_file(path) && lines > most {
            let what = format!("{lines} lines without tests; {most} are the limit");
            findings.push(finding(path, 1, &what));
        }
        for note in NOTES {
            for at in words(&source.comments, note) {
                if !has_issue(&source.comments[at + note.len()..]) {
                    findings.push(finding(
                        path,
                        line_of(text, at),
                        &format!("{note} without (#n)"),
                    ));
                }
            }
        }
    }
    findings
}

/// Maximum number of lines in a file, without its unit tests.
fn max_lines(path: &str) -> usize {
    if path.starts_with(ENGINE) && !path.ends_with("_tests.rs") { 500 } else { 600 }
}

/// Whether `(#12)` follows immediately.
fn has_issue(rest: &str) -> bool {
    let number = rest.strip_prefix("(#").and_then(|rest| rest.split_once(')'));
    number.is_some_and(|(number, _)| number.parse::<u32>().is_ok())
}
