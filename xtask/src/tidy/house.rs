//! Structure of the engine: number of files per folder, and no circular imports in the step.

use std::collections::BTreeMap;

use super::imports::{arrows, circles};
use super::{Tree, finding};

const ENGINE: &str = "crates/drystone/src/";
const STEP: &str = "crates/drystone/src/step/";
/// Maximum number of files in a folder.
const MAX_FILES: usize = 20;
/// Maximum number of files in an import cycle.
const MAX_CIRCLE: usize = 3;

pub fn check(tree: &Tree) -> Vec<String> {
    [folders(tree), step(tree)].concat()
}

fn folders(tree: &Tree) -> Vec<String> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    for (path, _) in tree.with_extension("rs").filter(|(path, _)| path.starts_with(ENGINE)) {
        let folder = path.rsplit_once('/').map_or("", |(folder, _)| folder);
        *counts.entry(folder).or_default() += 1;
    }
    let many = counts.into_iter().filter(|(_, files)| *files > MAX_FILES);
    many.map(|(folder, files)| {
        finding(folder, 1, &format!("{files} files in a folder; {MAX_FILES} are the limit"))
    })
    .collect()
}

/// Checks that no import cycle in the step is large or spans two folders.
fn step(tree: &Tree) -> Vec<String> {
    let inside = |circle: &Vec<String>| circle.iter().any(|file| file.starts_with(STEP));
    let circles = circles(&arrows(tree)).into_iter().filter(inside);
    circles
        .filter_map(|circle| {
            let room = room_of(&circle[0]);
            let names: Vec<&str> = circle.iter().map(|f| f.trim_start_matches(STEP)).collect();
            let names = names.join(", ");
            let what = if circle.len() > MAX_CIRCLE {
                format!("{} files import each other in a circle: {names}", circle.len())
            } else if circle.iter().any(|file| room_of(file) != room) {
                format!("a circle of imports over folders: {names}")
            } else {
                return None;
            };
            Some(finding(&circle[0], 1, &what))
        })
        .collect()
}

/// A folder, together with the file of the same name beside it.
fn room_of(path: &str) -> String {
    let inner = path.strip_prefix(STEP).unwrap_or(path);
    let stem = inner.strip_suffix(".rs").unwrap_or(inner);
    stem.split_once('/').map_or(stem, |(room, _)| room).to_owned()
}
