//! The engine's layers: a file names only modules of its own layer and of the layers it may use.

use super::rust::{Source, is_word};
use super::{Tree, finding, is_test_file, line_of};

const SOURCE: &str = "crates/drystone/src/";
/// The crate's root and its manual may name anything.
const FACE: [&str; 2] = ["lib", "manual"];

/// Each layer, with the other layers it may use.
const LAYERS: &[(&str, &[&str])] = &[
    ("base", &[]),
    ("geometry", &["base"]),
    ("reduced", &["base"]),
    ("state", &["base", "geometry", "reduced"]),
    ("step", &["base", "geometry", "reduced", "state"]),
    ("query", &["base", "geometry", "state"]),
    ("world", &["base", "geometry", "reduced", "state", "step", "query"]),
];

pub fn check(tree: &Tree) -> Vec<String> {
    let mut findings = Vec::new();
    for (path, text) in tree.with_extension("rs") {
        let Some(inner) = path.strip_prefix(SOURCE).filter(|_| !is_test_file(path)) else {
            continue;
        };
        let module = module_of(inner);
        let Some(own) = module.first().copied().filter(|name| !FACE.contains(name)) else {
            continue;
        };
        let Some((_, allowed)) = LAYERS.iter().find(|(name, _)| *name == own) else {
            findings.push(finding(path, 1, &format!("`{own}` is no layer")));
            continue;
        };
        let code = Source::new(text).code_without_tests();
        for (at, used) in uses(&code, module.len()) {
            let known = LAYERS.iter().any(|(name, _)| *name == used);
            // Only World may name the re-exports of the crate's root.
            let what = match known {
                true if used == own || allowed.contains(&used) => continue,
                true => format!("{own} may not use {used}"),
                false if own == "world" => continue,
                false => format!("`{used}` from the crate's root: name its layer"),
            };
            findings.push(finding(path, line_of(text, at), &what));
        }
    }
    findings
}

/// `step/solver/mod.rs` is the module `step`, `solver`.
pub fn module_of(path: &str) -> Vec<&str> {
    let stem = path.strip_suffix(".rs").unwrap_or(path);
    stem.strip_suffix("/mod").unwrap_or(stem).split('/').collect()
}

/// Names that the code takes from the crate's root, by `crate::` or by enough `super::`, with their
/// offsets.
fn uses(code: &str, depth: usize) -> Vec<(usize, &str)> {
    let mut found = Vec::new();
    for (at, _) in code.match_indices("::") {
        let path = path_before(code, at);
        let supers = path.matches("super").count();
        let whole = path == "crate" || supers > 0 && path.split("::").all(|part| part == "super");
        if whole && (path == "crate" || supers == depth) {
            found.extend(names(code, at + 2));
        }
    }
    found
}

/// The path that ends at `end`: identifiers and `::`.
fn path_before(code: &str, end: usize) -> &str {
    let bytes = code.as_bytes();
    let length = bytes[..end].iter().rev().take_while(|&&b| is_word(b) || b == b':').count();
    &code[end - length..end]
}

/// The first identifiers after `::`: one, or several of a `{…}` group. Macros of the crate do not
/// count.
fn names(code: &str, start: usize) -> Vec<(usize, &str)> {
    let bytes = code.as_bytes();
    let word_at = |at: usize| {
        let length = bytes[at..].iter().take_while(|&&b| is_word(b)).count();
        let is_macro = bytes.get(at + length) == Some(&b'!');
        (length > 0 && !is_macro).then(|| (at, &code[at..at + length]))
    };
    if bytes.get(start) != Some(&b'{') {
        return word_at(start).filter(|(_, word)| *word != "super").into_iter().collect();
    }
    let (mut found, mut depth, mut expecting) = (Vec::new(), 0, false);
    for (at, &byte) in bytes.iter().enumerate().skip(start) {
        match byte {
            b'{' => depth += 1,
            b'}' => depth -= 1,
            _ => {}
        }
        match byte {
            _ if depth == 0 => break,
            b'{' | b',' => expecting = depth == 1,
            _ if expecting && !byte.is_ascii_whitespace() => {
                found.extend(word_at(at).filter(|(_, word)| *word != "self"));
                expecting = false;
            }
            _ => {}
        }
    }
    found
}
