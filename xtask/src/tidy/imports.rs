//! Imports between the engine's files, and the cycles that they form.
//!
//! A file imports another file if it names an item in it, by `use` or by a path in its code. A path
//! through a file that itself imports the name leads on to the definition. So `use super::Solver`
//! in a child of a module that imports `Solver` is an edge to the file of `Solver`, not to the
//! parent.

use std::collections::{BTreeMap, BTreeSet};

use super::rust::{Source, is_word, words};
use super::{Tree, is_test_file, layers};

const SOURCE: &str = "crates/drystone/src/";

/// A module: the names from the crate's root to it.
pub type Module = Vec<String>;

/// Edges from file to file, by paths in the repository.
pub type Arrows = BTreeMap<String, BTreeSet<String>>;

struct File {
    path: String,
    /// Names that its items define.
    defined: BTreeSet<String>,
    /// Imported names, with their paths.
    imports: Vec<(String, Vec<String>)>,
    /// All paths in the file, in imports and in code.
    paths: Vec<Vec<String>>,
}

/// The edges between the engine's files, without unit tests.
pub fn arrows(tree: &Tree) -> Arrows {
    let mut files: BTreeMap<Module, File> = BTreeMap::new();
    for (path, text) in tree.with_extension("rs") {
        let Some(inner) = path.strip_prefix(SOURCE).filter(|_| !is_test_file(path)) else {
            continue;
        };
        if !inner.ends_with("_tests.rs") {
            files.insert(module_of(inner), file(path, &Source::new(text).code_without_tests()));
        }
    }
    let mut arrows = Arrows::new();
    for (module, file) in &files {
        let to = arrows.entry(file.path.clone()).or_default();
        for path in &file.paths {
            if let Some(target) = target(&files, module, path, 0)
                && target != file.path
            {
                to.insert(target);
            }
        }
    }
    arrows
}

/// Sets of files that import each other in a cycle, in the order of their first file.
pub fn circles(arrows: &Arrows) -> Vec<Vec<String>> {
    let reach: BTreeMap<&str, BTreeSet<&str>> =
        arrows.keys().map(|from| (from.as_str(), reached(arrows, from))).collect();
    let mut circles: Vec<Vec<String>> = Vec::new();
    for from in arrows.keys() {
        if circles.iter().flatten().any(|file| file == from) {
            continue;
        }
        let back = |to: &&&str| reach.get(**to).is_some_and(|set| set.contains(from.as_str()));
        let circle: Vec<String> =
            reach[from.as_str()].iter().filter(back).map(|to| (*to).to_owned()).collect();
        if circle.len() > 1 {
            circles.push(circle);
        }
    }
    circles
}

/// All files that a file imports, directly or indirectly.
fn reached<'a>(arrows: &'a Arrows, from: &str) -> BTreeSet<&'a str> {
    let mut found = BTreeSet::new();
    let mut open: Vec<&str> = arrows[from].iter().map(String::as_str).collect();
    while let Some(file) = open.pop() {
        if found.insert(file) {
            open.extend(arrows.get(file).into_iter().flatten().map(String::as_str));
        }
    }
    found
}

/// The module of a file; the crate's root has no name.
fn module_of(inner: &str) -> Module {
    let names = layers::module_of(inner);
    if names == ["lib"] { Module::new() } else { names.into_iter().map(str::to_owned).collect() }
}

fn file(path: &str, code: &str) -> File {
    let mut imports = Vec::new();
    let mut rest = code.to_owned();
    for at in words(code, "use") {
        let Some(length) = code[at..].find(';') else { continue };
        // `+ use<'a>` in a type imports nothing.
        if code[at + 3..].starts_with('<') {
            continue;
        }
        expand(&[], &code[at + 3..at + length], &mut imports);
        rest.replace_range(at..at + length, &" ".repeat(length));
    }
    let mut paths: Vec<Vec<String>> = imports.iter().map(|(_, path)| path.clone()).collect();
    paths.extend(code_paths(&rest));
    File { path: path.to_owned(), defined: defined(code), imports, paths }
}

/// The paths of an import tree, each with the name that it is imported under.
fn expand(head: &[String], tree: &str, found: &mut Vec<(String, Vec<String>)>) {
    let tree = tree.trim();
    let names = |text: &str| -> Vec<String> {
        text.split("::").map(str::trim).filter(|s| !s.is_empty()).map(str::to_owned).collect()
    };
    let Some(open) = tree.find('{') else {
        let (path, alias) = tree.split_once(" as ").unwrap_or((tree, ""));
        let mut path = [head, &names(path)].concat();
        if path.last().is_some_and(|last| last == "self") {
            path.pop();
        }
        if let Some(last) = path.last().cloned() {
            let alias = alias.trim();
            found.push((if alias.is_empty() { last } else { alias.to_owned() }, path));
        }
        return;
    };
    let head = [head, &names(&tree[..open])].concat();
    let close = tree.rfind('}').unwrap_or(tree.len());
    let (mut depth, mut start) = (0, open + 1);
    for (at, byte) in tree.bytes().enumerate().take(close).skip(open + 1) {
        match byte {
            b'{' => depth += 1,
            b'}' => depth -= 1,
            b',' if depth == 0 => {
                expand(&head, &tree[start..at], found);
                start = at + 1;
            }
            _ => {}
        }
    }
    expand(&head, &tree[start..close], found);
}

/// Paths of at least two names in code.
fn code_paths(code: &str) -> Vec<Vec<String>> {
    let is_path = |byte: u8| is_word(byte) || byte == b':';
    code.split(|c: char| !u8::try_from(c).is_ok_and(is_path))
        .filter(|part| part.contains("::") && !part.starts_with(':'))
        .map(|part| {
            part.split("::").take_while(|name| !name.is_empty()).map(str::to_owned).collect()
        })
        .collect()
}

/// Names of the items in a file.
fn defined(code: &str) -> BTreeSet<String> {
    const KINDS: [&str; 9] =
        ["struct", "enum", "fn", "const", "static", "type", "trait", "union", "macro_rules!"];
    let mut found = BTreeSet::new();
    for kind in KINDS {
        for (at, _) in code.match_indices(kind) {
            let rest = code[at + kind.len()..].trim_start();
            let end = rest.bytes().take_while(|&b| is_word(b)).count();
            if end > 0 {
                found.insert(rest[..end].to_owned());
            }
        }
    }
    found
}

/// The file that defines the last name of a path.
fn target(
    files: &BTreeMap<Module, File>,
    from: &Module,
    path: &[String],
    depth: usize,
) -> Option<String> {
    let first = path.first()?;
    let up = path.iter().take_while(|name| *name == "super").count();
    let (mut module, rest) = match first.as_str() {
        "crate" => (Module::new(), &path[1..]),
        "self" => (from.clone(), &path[1..]),
        "super" => (from[..from.len().checked_sub(up)?].to_vec(), &path[up..]),
        name => {
            let import = &files.get(from)?.imports;
            let child = [from.as_slice(), &[name.to_owned()]].concat();
            if let Some((_, whole)) = import.iter().find(|(alias, _)| alias == name) {
                // The file imports this name itself, so the path continues from there.
                let whole = [whole, &path[1..]].concat();
                let roots = ["crate", "self", "super"];
                let ours = whole.first().is_some_and(|root| roots.contains(&root.as_str()));
                return if ours { target(files, from, &whole, depth) } else { None };
            } else if files.contains_key(&child) {
                (from.clone(), path)
            } else {
                return None;
            }
        }
    };
    let mut rest = rest.iter();
    let mut name = rest.next();
    while let Some(next) = name {
        let child = [module.as_slice(), std::slice::from_ref(next)].concat();
        if !files.contains_key(&child) {
            break;
        }
        module = child;
        name = rest.next();
    }
    let file = files.get(&module)?;
    let Some(name) = name else { return Some(file.path.clone()) };
    let through = file.imports.iter().find(|(alias, _)| alias == name);
    match through {
        Some((_, path)) if !file.defined.contains(name) && depth < 8 => {
            target(files, &module, path, depth + 1).or_else(|| Some(file.path.clone()))
        }
        _ => Some(file.path.clone()),
    }
}
