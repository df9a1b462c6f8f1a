//! Comments: their lines are at most 100 columns wide, and none begins without a subject.

use super::rust::Source;
use super::{Tree, finding};

const MAX_COLUMNS: usize = 100;

/// Beginnings of clauses that stand for a noun which the reader has to guess.
const HEADLESS: [&str; 5] = ["What ", "Of ", "Those ", "Who ", "So many "];

pub fn check(tree: &Tree) -> Vec<String> {
    let mut findings = Vec::new();
    for (path, text) in tree.with_extension("rs") {
        let comments = Source::new(text).comments;
        let mut in_code = false;
        for (at, (line, comment)) in text.lines().zip(comments.lines()).enumerate() {
            let comment = comment.trim();
            let Some(words) = comment.strip_prefix("//") else { continue };
            let words = words.trim_start_matches(['/', '!']).trim_start();
            if words.starts_with("```") {
                in_code = !in_code;
            }
            // Examples are code; links and rows of tables cannot be broken.
            if in_code || words.contains("://") || words.starts_with('|') {
                continue;
            }
            // A comment behind code is as wide as rustfmt lets the code be.
            let whole = line.trim_start().starts_with("//");
            let columns = line.chars().count();
            if whole && columns > MAX_COLUMNS {
                let what = format!("a comment of {columns} columns; {MAX_COLUMNS} are the limit");
                findings.push(finding(path, at + 1, &what));
            }
            if let Some(word) = HEADLESS.iter().find(|word| words.starts_with(*word)) {
                let what = format!("a comment begins with \"{}\": name its subject", word.trim());
                findings.push(finding(path, at + 1, &what));
            }
        }
    }
    findings
}
