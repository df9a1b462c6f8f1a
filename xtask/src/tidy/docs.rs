//! Checks that references in texts exist: reference keys, pages under docs/, links, the README's
//! example.

use std::collections::BTreeSet;

use super::rust::Source;
use super::{Tree, finding, is_test_file, line_of};

const REFERENCES: &str = "docs/references.md";
const MARKER: &str = "<!-- hello -->";

pub fn check(tree: &Tree) -> Vec<String> {
    let mut findings = Vec::new();
    let mut keys = BTreeSet::new();
    for (at, line) in tree.text(REFERENCES).unwrap_or_default().lines().enumerate() {
        let entry = line.trim_start_matches(['-', '*', '|', ' ']);
        if let Some((_, key)) = reference_keys(entry).into_iter().find(|(at, _)| *at == 0)
            && !keys.insert(key)
        {
            findings.push(finding(REFERENCES, at + 1, &format!("{key} is there twice")));
        }
    }
    let (rust, pages) = (tree.with_extension("rs"), tree.with_extension("md"));
    let rust = rust.map(|(path, text)| (path, Source::new(text)));
    let mut texts: Vec<(&str, String)> = Vec::new();
    for (path, source) in rust {
        if !is_test_file(path) {
            doc_paths(tree, path, &source.strings, &mut findings);
        }
        texts.push((path, source.comments));
    }
    texts.extend(pages.map(|(path, text)| (path, text.to_owned())));
    for (path, text) in &texts {
        for (at, key) in reference_keys(text) {
            if !keys.contains(key) {
                let what = format!("{key} is not in {REFERENCES}");
                findings.push(finding(path, line_of(text, at), &what));
            }
        }
        doc_paths(tree, path, text, &mut findings);
        if path.ends_with(".md") {
            links(tree, path, text, &mut findings);
        }
    }
    findings.extend(hello(tree));
    findings
}

/// Whether a text has the form of a reference key: a capital, more letters, two digits.
pub fn is_reference_key(text: &str) -> bool {
    let name = text.trim_end_matches(|c: char| c.is_ascii_digit());
    name.len() >= 2
        && text.len() == name.len() + 2
        && name.starts_with(|c: char| c.is_ascii_uppercase())
        && name.chars().all(|c| c.is_ascii_alphabetic())
}

/// Keys in brackets, with their offsets.
fn reference_keys(text: &str) -> Vec<(usize, &str)> {
    let open = text.match_indices('[').map(|(at, _)| at);
    open.filter_map(|at| {
        let end = at + text[at..].find(']')?;
        is_reference_key(&text[at + 1..end]).then(|| (at, &text[at..=end]))
    })
    .collect()
}

/// Checks that every mentioned `docs/….md`, from the root or by `../`, is a file, and every
/// `manual/….md` of the engine.
fn doc_paths(tree: &Tree, path: &str, text: &str, findings: &mut Vec<String>) {
    let is_path = |c: char| c.is_ascii_alphanumeric() || "_-./".contains(c);
    let mut from = 0;
    for part in text.split_inclusive(|c: char| !is_path(c)) {
        let mention = part.trim_end_matches(|c: char| !is_path(c)).trim_end_matches('.');
        let target = mention.trim_start_matches(['.', '/']);
        let ours = ["docs/", "manual/"].iter().any(|folder| target.starts_with(folder));
        let found = || tree.has(target) || tree.has(&format!("crates/drystone/{target}"));
        if ours && target.ends_with(".md") && !found() {
            findings.push(finding(path, line_of(text, from), &format!("no page {target}")));
        }
        from += part.len();
    }
}

/// Checks that a page's links to files of the project resolve, relative to the page's folder.
fn links(tree: &Tree, path: &str, text: &str, findings: &mut Vec<String>) {
    let inline = text.match_indices("](").filter_map(|(at, _)| {
        let length = text[at..].find(')')?;
        Some((at, &text[at + 2..at + length]))
    });
    // `[label]: target`, on a line of its own.
    let defined = text.match_indices("]: ").filter_map(|(at, _)| {
        let start = text[..at].rfind('\n').map_or(0, |end| end + 1);
        let end = text[at..].find('\n').map_or(text.len(), |length| at + length);
        text[start..].starts_with('[').then(|| (at, text[at + 3..end].trim_end()))
    });
    for (at, target) in inline.chain(defined) {
        let target = target.split('#').next().unwrap_or_default();
        if target.is_empty() || target.contains("://") || target.starts_with("mailto:") {
            continue;
        }
        let mut parts: Vec<&str> = path.split('/').collect();
        parts.pop();
        for part in target.split('/') {
            match part {
                "." => {}
                ".." => drop(parts.pop()),
                part => parts.push(part),
            }
        }
        if !tree.has(&parts.join("/")) {
            let what = format!("the link to {target} leads nowhere");
            findings.push(finding(path, line_of(text, at), &what));
        }
    }
}

/// Checks that the README's first example is also the crate's: the block after the marker is in the
/// crate's page.
fn hello(tree: &Tree) -> Option<String> {
    let readme = tree.text("README.md")?;
    let start = readme.find(MARKER)?;
    let block = readme[start..].split("```").nth(1)?;
    let block: Vec<&str> = block.lines().skip(1).map(str::trim_end).collect();
    let face = tree.text("crates/drystone/src/lib.rs").unwrap_or_default();
    let page = face.lines().filter_map(|line| line.strip_prefix("//!"));
    let page = page.map(|line| line.strip_prefix(' ').unwrap_or(line).trim_end());
    // Lines that rustdoc hides, `# …`, are not visible to a reader.
    let page: Vec<&str> = page.filter(|line| *line != "#" && !line.starts_with("# ")).collect();
    let same = !block.is_empty() && page.windows(block.len()).any(|window| window == block);
    let what = "the example after the marker is not the one in crates/drystone/src/lib.rs";
    (!same).then(|| finding("README.md", line_of(readme, start), what))
}
