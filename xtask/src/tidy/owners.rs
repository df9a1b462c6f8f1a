//! The access tables in ARCHITECTURE.md, generated from the code. They list the tables that each
//! stage borrows, by its signature, and the files that write each field of a body.

use std::collections::{BTreeMap, BTreeSet};

use super::rust::{Source, block_end, is_word, words};
use super::{Tree, finding, is_test_file};

const PAGE: &str = "ARCHITECTURE.md";
const BEGIN: &str = "<!-- owners:begin, written by `cargo xtask owners` -->";
const END: &str = "<!-- owners:end -->";
const SOURCE: &str = "crates/drystone/src/";
const STEP: &str = "crates/drystone/src/step/";

/// Tables, in the order of their columns.
const TABLES: [&str; 9] = [
    "Bodies",
    "Shapes",
    "Joints",
    "Particles",
    "Contacts",
    "Bounds",
    "Islands",
    "Colors",
    "Events",
];

/// Entry functions of the stages: file and function.
const ENTRIES: [(&str, &[(&str, &str)]); 9] = [
    ("broadphase", &[("broadphase.rs", "find_pairs")]),
    ("narrowphase", &[("narrowphase.rs", "update_manifolds")]),
    ("partition", &[("partition.rs", "apply_changes")]),
    ("particles", &[("particles.rs", "meet_shapes")]),
    ("solver", &[("solver/mod.rs", "solve")]),
    ("finalize", &[("finalize.rs", "advance_poses")]),
    ("sweep", &[("sweep.rs", "stop_fast_bodies"), ("particles/settle.rs", "settle")]),
    ("sleep", &[("sleep.rs", "rest_still_islands")]),
    ("report", &[("report.rs", "report")]),
];

/// Structs that lend several tables at once.
const BUNDLES: [(&str, &str); 3] = [
    ("Sets", "crates/drystone/src/state/sets.rs"),
    ("Input", "crates/drystone/src/step/solver/input.rs"),
    ("Tied", "crates/drystone/src/step/particles/tied.rs"),
];

pub fn check(tree: &Tree) -> Vec<String> {
    let Some(page) = tree.text(PAGE).filter(|page| page.contains(BEGIN)) else {
        return Vec::new();
    };
    match page_with(page, tree) {
        Ok(new) if new == *page => Vec::new(),
        Ok(_) => {
            let what = "its tables of access are not those of the code: run `cargo xtask owners`";
            vec![finding(PAGE, 1, what)]
        }
        Err(why) => vec![finding(PAGE, 1, &why)],
    }
}

/// The page with both tables generated from the code.
pub fn page_with(page: &str, tree: &Tree) -> Result<String, String> {
    let begin = page.find(BEGIN).ok_or("no line `owners:begin`")? + BEGIN.len();
    let end = page.find(END).ok_or("no line `owners:end`")?;
    let tables = format!("\n\n{}\n{}\n", grants(tree)?, writers(tree)?);
    Ok(format!("{}{tables}{}", &page[..begin], &page[end..]))
}

/// Read (R) and write (W) access by stage and table.
fn grants(tree: &Tree) -> Result<String, String> {
    let mut bundles = BTreeMap::new();
    for (name, path) in BUNDLES {
        let code = code(tree, path)?;
        let at = words(&code, "struct")
            .find(|&at| code[at + 6..].trim_start().starts_with(&format!("{name}<")));
        let at = at.ok_or_else(|| format!("{path} has no struct {name}"))?;
        let open = at + code[at..].find('{').ok_or("a struct without fields")?;
        bundles.insert(name, lent(&code[open..block_end(&code, open)], &BTreeMap::new()));
    }
    let mut lines = String::from("| table |");
    ENTRIES.iter().for_each(|(stage, _)| lines += &format!(" {stage} |"));
    lines += &format!("\n|---|{}\n", "---|".repeat(ENTRIES.len()));
    let mut access = Vec::new();
    for (_, entries) in ENTRIES {
        let mut all: BTreeMap<&str, bool> = BTreeMap::new();
        for (file, function) in entries {
            let code = code(tree, &format!("{STEP}{file}"))?;
            let at = words(&code, function).find(|&at| code[..at].ends_with("fn "));
            let at = at.ok_or_else(|| format!("{file} has no fn {function}"))?;
            let open = at + code[at..].find('{').ok_or("a function without a body")?;
            for (table, writes) in lent(&code[at..open], &bundles) {
                *all.entry(table).or_default() |= writes;
            }
        }
        access.push(all);
    }
    for table in TABLES {
        lines += &format!("| {} |", table.to_lowercase());
        for all in &access {
            let cell = all.get(table).map_or("", |writes| if *writes { "W" } else { "R" });
            lines += &format!(" {cell} |");
        }
        lines.push('\n');
    }
    Ok(lines)
}

/// Tables that a text of parameters or fields borrows, and whether mutably.
fn lent<'t>(
    text: &str,
    bundles: &BTreeMap<&str, BTreeMap<&'t str, bool>>,
) -> BTreeMap<&'t str, bool> {
    let mut found: BTreeMap<&str, bool> = BTreeMap::new();
    for table in TABLES {
        for at in words(text, table) {
            let before = text[..at].trim_end();
            // `&mut T` or `&'a mut T`; a longer path is another type.
            if !before.ends_with(':') {
                *found.entry(table).or_default() |= before.ends_with("mut");
            }
        }
    }
    for (name, tables) in bundles {
        if words(text, name).next().is_some() {
            for (table, writes) in tables {
                *found.entry(table).or_default() |= writes;
            }
        }
    }
    found
}

/// Fields of a body, with the parts of the engine whose code assigns them.
fn writers(tree: &Tree) -> Result<String, String> {
    let body = code(tree, "crates/drystone/src/state/bodies/body.rs")?;
    let mut fields = Vec::new();
    for (name, kind) in fields_of(&body, "Body").ok_or("no struct Body")? {
        // A field of a part is `part.field`.
        let part = fields_of(&body, kind).filter(|_| name == kind.to_lowercase());
        match part {
            Some(part) => fields.extend(part.iter().map(|(field, _)| format!("{name}.{field}"))),
            None => fields.push(name.to_owned()),
        }
    }
    let mut rooms: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (path, text) in tree.with_extension("rs") {
        let inner = path.strip_prefix(SOURCE).filter(|_| !is_test_file(path));
        let Some(room) = inner.and_then(room) else { continue };
        let code = Source::new(text).code_without_tests();
        for field in &fields {
            let part = field.split_once('.').map(|(part, _)| part);
            if assigns(&code, field) || part.is_some_and(|part| assigns_whole(&code, part)) {
                rooms.entry(field.clone()).or_default().insert(room.clone());
            }
        }
    }
    let mut by_rooms: BTreeMap<Vec<String>, Vec<String>> = BTreeMap::new();
    for field in fields {
        let of = rooms.remove(&field).unwrap_or_default().into_iter().collect();
        by_rooms.entry(of).or_default().push(field);
    }
    let mut lines = String::from("| fields of a body | written by |\n|---|---|\n");
    for (rooms, fields) in by_rooms {
        let fields: Vec<String> = fields.iter().map(|field| format!("`{field}`")).collect();
        let rooms = if rooms.is_empty() { "when it is made".to_owned() } else { rooms.join(", ") };
        lines += &format!("| {} | {rooms} |\n", fields.join(", "));
    }
    Ok(lines)
}

/// Names and types of the fields of a struct.
fn fields_of<'t>(code: &'t str, name: &str) -> Option<Vec<(&'t str, &'t str)>> {
    let at = code.find(&format!("pub(crate) struct {name} {{"))?;
    let open = at + code[at..].find('{')?;
    let lines = code[open..block_end(code, open)].lines();
    let fields = lines.filter_map(|line| line.trim().strip_prefix("pub(crate) ")?.split_once(": "));
    Some(fields.map(|(name, kind)| (name, kind.trim_end_matches(','))).collect())
}

/// The stage, table or layer of a file in `state`, `step` or `world`.
fn room(inner: &str) -> Option<String> {
    let stem = inner.strip_suffix(".rs")?;
    let mut names = stem.split('/');
    match (names.next()?, names.next()?) {
        ("step", stage) => Some(stage.to_owned()),
        ("state", "bodies") => Some("state/bodies".to_owned()),
        ("state", table) => Some(format!("state/{table}")),
        ("world", _) => Some("world".to_owned()),
        _ => None,
    }
}

/// Calls that change a list.
const CHANGES: [&str; 7] =
    [".push(", ".retain(", ".clear(", ".remove(", ".swap_remove(", ".insert(", ".extend"];

/// Whether code assigns `body.field`, changes it as a list, or borrows it mutably.
fn assigns(code: &str, field: &str) -> bool {
    let name = format!(".{field}");
    code.match_indices(&name).any(|(at, _)| {
        let rest = &code[at + name.len()..];
        if rest.bytes().next().is_some_and(is_word) || !is_body(&code[..at]) {
            return false;
        }
        if CHANGES.iter().any(|call| rest.starts_with(call)) {
            return true;
        }
        let start = code[..at].rfind([';', '{', '}', '\n']).map_or(0, |at| at + 1);
        let lends = code[start..at].contains("&mut ");
        // The left side of the statement continues with other targets of a tuple, indices and
        // fields.
        let end = rest.find([';', '{']).unwrap_or(rest.len());
        let left = rest[..end]
            .trim_start_matches(|c: char| c.is_alphanumeric() || " .,_[]()\n".contains(c));
        lends
            || ["= ", "=\n", "+= ", "-= ", "*= ", "/= ", "|= ", "&= "]
                .iter()
                .any(|op| left.starts_with(op))
    })
}

/// Whether code assigns a whole part of a body, or borrows it mutably.
fn assigns_whole(code: &str, part: &str) -> bool {
    let name = format!("body.{part}");
    code.match_indices(&name).any(|(at, _)| {
        let rest = &code[at + name.len()..];
        let lends = code[..at].ends_with("&mut ");
        rest.starts_with(" = ") || lends && rest.starts_with([';', ',', ')'])
    })
}

/// Whether the text before a field ends with the name of a body.
fn is_body(before: &str) -> bool {
    let word = before.bytes().rev().take_while(|&b| is_word(b)).count();
    match &before[before.len() - word..] {
        "body" | "b" => true,
        "" => {
            before.trim_end().ends_with(')') && {
                let open = before.rfind('(').unwrap_or(0);
                before[..open].ends_with("bodies.at_mut") || before[..open].ends_with(".body")
            }
        }
        _ => false,
    }
}

fn code(tree: &Tree, path: &str) -> Result<String, String> {
    let text = tree.text(path).ok_or_else(|| format!("no file {path}"))?;
    Ok(Source::new(text).code_without_tests())
}
