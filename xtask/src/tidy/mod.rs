//! `cargo xtask tidy`: conventions that a compiler cannot check. Every check is a pure function of
//! a [`Tree`].

mod comments;
mod docs;
mod examples;
mod house;
mod imports;
mod layers;
mod owners;
mod rust;
mod source;
mod stages;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::process::Command;

pub use docs::is_reference_key;

use crate::{Outcome, root};

/// The files of the project that git does not ignore: path from the root, with `/`, and text. Files
/// that are not text have an empty text, so that links to them resolve.
struct Tree {
    files: BTreeMap<String, String>,
}

impl Tree {
    fn read() -> Result<Self, String> {
        let mut git = Command::new("git");
        git.args(["ls-files", "--cached", "--others", "--exclude-standard", "-z"]);
        let output = git.current_dir(root()).output().map_err(|e| format!("git ls-files: {e}"))?;
        if !output.status.success() {
            return Err(format!("git ls-files: {}", String::from_utf8_lossy(&output.stderr)));
        }
        let names = String::from_utf8_lossy(&output.stdout).into_owned();
        let paths =
            names.split('\0').filter(|name| !name.is_empty() && root().join(name).is_file());
        let text = |path: &str| std::fs::read_to_string(root().join(path)).unwrap_or_default();
        Ok(Self { files: paths.map(|path| (path.to_owned(), text(path))).collect() })
    }

    fn text(&self, path: &str) -> Option<&str> {
        self.files.get(path).map(String::as_str)
    }

    /// Whether the path is a file, or a folder that contains one.
    fn has(&self, path: &str) -> bool {
        let folder = format!("{}/", path.trim_end_matches('/'));
        self.files.contains_key(path) || self.files.keys().any(|file| file.starts_with(&folder))
    }

    /// Files whose name ends with `.extension`.
    fn with_extension(&self, extension: &str) -> impl Iterator<Item = (&str, &str)> {
        let ending = format!(".{extension}");
        let files = self.files.iter().filter(move |(path, _)| path.ends_with(&ending));
        files.map(|(path, text)| (path.as_str(), text.as_str()))
    }
}

/// One finding, printed as `path:line: what`.
fn finding(path: &str, line: usize, what: &str) -> String {
    format!("{path}:{line}: {what}")
}

/// The line number of a byte offset, from 1.
fn line_of(text: &str, offset: usize) -> usize {
    text.as_bytes()[..offset].iter().filter(|&&byte| byte == b'\n').count() + 1
}

/// Whether a file consists only of tests.
fn is_test_file(path: &str) -> bool {
    path.contains("/tests/") || path.ends_with("/tests.rs")
}

fn check(tree: &Tree) -> Vec<String> {
    [
        layers::check(tree),
        stages::check(tree),
        docs::check(tree),
        source::check(tree),
        comments::check(tree),
        examples::check(tree),
        house::check(tree),
        owners::check(tree),
    ]
    .concat()
}

/// Writes the access tables into ARCHITECTURE.md.
pub fn write_owners() -> Outcome {
    let tree = Tree::read()?;
    let path = "ARCHITECTURE.md";
    let page = owners::page_with(tree.text(path).ok_or("no ARCHITECTURE.md")?, &tree)?;
    std::fs::write(root().join(path), page).map_err(|e| format!("{path}: {e}"))
}

pub fn run() -> Outcome {
    let findings = check(&Tree::read()?);
    if findings.is_empty() { Ok(()) } else { Err(findings.join("\n")) }
}
