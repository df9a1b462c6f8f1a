//! The manual: every exported name of the engine appears in an example, every page is a chapter,
//! and its links also resolve in the reference.

use std::collections::BTreeSet;

use super::rust::{Source, is_word};
use super::{Tree, finding, is_test_file, line_of};

const FACE: &str = "crates/drystone/src/lib.rs";
const SOURCE: &str = "crates/drystone/src/";
const EXAMPLES: &str = "crates/drystone/examples/";
const MANUAL: &str = "crates/drystone/manual/";
const CHAPTERS: &str = "crates/drystone/src/manual.rs";
const LINKS: &str = "crates/drystone/manual/links.txt";

pub fn check(tree: &Tree) -> Vec<String> {
    let Some(face) = tree.text(FACE) else { return Vec::new() };
    let seen = example_words(tree);
    let code = Source::new(face).code_without_tests();
    let mut findings = Vec::new();
    let mut look = |path: &str, text: &str, names: Vec<(usize, &str)>| {
        for (at, name) in names.into_iter().filter(|(_, name)| !seen.contains(*name)) {
            let what = format!("`{name}` stands in no example: add it to a chapter of {MANUAL}");
            findings.push(finding(path, line_of(text, at), &what));
        }
    };
    look(FACE, face, exported(&code));
    // Modules that are public files of their own.
    for module in code.lines().filter_map(|line| line.strip_prefix("pub mod ")?.strip_suffix(';')) {
        let path = format!("{SOURCE}{module}/mod.rs");
        if let Some(text) = tree.text(&path) {
            look(&path, text, exported(&Source::new(text).code_without_tests()));
        }
    }
    findings.extend(pages(tree));
    findings
}

/// Checks that every page of the manual is a chapter, and that the labels of its links are also
/// defined in the reference.
fn pages(tree: &Tree) -> Vec<String> {
    let mut findings = Vec::new();
    let chapters = tree.text(CHAPTERS).unwrap_or_default();
    let links = tree.text(LINKS).unwrap_or_default();
    for (path, text) in tree.with_extension("md") {
        let Some(page) = path.strip_prefix(MANUAL) else { continue };
        if !chapters.contains(&format!("manual/{page}\"")) {
            findings.push(finding(path, 1, &format!("the page is no chapter of {CHAPTERS}")));
        }
        for (at, line) in text.lines().enumerate().filter(|(_, line)| line.starts_with('[')) {
            if let Some((label, _)) = line.split_once("]: ")
                && !links.contains(&format!("\n{label}]: "))
            {
                let what = format!("the label {label}] is not in {LINKS}");
                findings.push(finding(path, at + 1, &what));
            }
        }
    }
    findings
}

/// Names that the code exports at its top level or in its modules, with their offsets: re-exports
/// and public items.
fn exported(code: &str) -> Vec<(usize, &str)> {
    let mut names = Vec::new();
    for (at, _) in code.match_indices("pub ") {
        let rest = &code[at + "pub ".len()..];
        if let Some(list) = rest.strip_prefix("use ") {
            let list = &list[..list.find(';').unwrap_or(list.len())];
            let from = list.find('{').map_or(0, |open| open + 1);
            for name in list[from..].trim_end_matches(['}', ' ', '\n']).split(',') {
                let name = name.trim().rsplit("::").next().unwrap_or_default();
                names.extend((!name.is_empty()).then_some((at, name)));
            }
            continue;
        }
        let item = ["mod ", "struct ", "enum ", "trait ", "fn ", "type "]
            .into_iter()
            .find_map(|word| rest.strip_prefix(word));
        let starts_line = at == 0 || code.as_bytes()[at - 1] == b'\n';
        if let Some(item) = item.filter(|_| starts_line) {
            let length = item.bytes().take_while(|&byte| is_word(byte)).count();
            // The manual shows other names, not its own.
            names.extend((&item[..length] != "manual").then_some((at, &item[..length])));
        }
    }
    names
}

/// All words in the code of examples: the files of `examples/`, and code blocks in the manual and
/// in doc comments.
fn example_words(tree: &Tree) -> BTreeSet<String> {
    let mut words = BTreeSet::new();
    let mut take = |code: &str| {
        let code = Source::new(code).code;
        let parts = code.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_'));
        words.extend(parts.filter(|part| !part.is_empty()).map(str::to_owned));
    };
    for (path, text) in tree.with_extension("rs").filter(|(path, _)| !is_test_file(path)) {
        if path.starts_with(EXAMPLES) {
            take(text);
        } else if path.starts_with(SOURCE) {
            let comment = |line| {
                let line = str::trim_start(line);
                line.strip_prefix("///").or_else(|| line.strip_prefix("//!"))
            };
            let page: Vec<&str> = text.lines().filter_map(comment).collect();
            take(&code_blocks(&page.join("\n")));
        }
    }
    for (_, page) in tree.with_extension("md").filter(|(path, _)| path.starts_with(MANUAL)) {
        take(&code_blocks(page));
    }
    words
}

/// The code blocks of a page that rustdoc runs.
fn code_blocks(page: &str) -> String {
    let (mut code, mut block) = (String::new(), None);
    for line in page.lines() {
        if let Some(language) = line.trim_start().strip_prefix("```") {
            let runs = matches!(language.trim(), "" | "rust" | "no_run");
            block = if block.is_some() { None } else { Some(runs) };
        } else if block == Some(true) {
            let line = line.trim_start();
            code.push_str(line.strip_prefix("# ").unwrap_or(line));
            code.push('\n');
        }
    }
    code
}
