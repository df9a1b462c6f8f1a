//! A text before it is a scene: its version, its numbers, and the errors of serde.

use std::path::Path;

use serde::Deserialize;

use super::place::Place;
use crate::error::SceneError;

/// The version of the format that is written. It is the only one that is read.
pub const VERSION: u32 = 1;

/// An error of serde in the terms of other errors; `path` is where serde was.
pub(super) fn broken(text: &str, e: &serde_json::Error, path: &str) -> SceneError {
    let full = e.to_string();
    let said = full.rfind(" at line ").map_or(full.as_str(), |end| &full[..end]);
    let (problem, allowed) = match e.classify() {
        serde_json::error::Category::Data => match said.split_once(", expected ") {
            Some((problem, allowed)) => (found(problem), wanted(allowed)),
            None => (said.to_owned(), String::new()),
        },
        // All of it was read as JSON before: another value stands where serde expects the name of a
        // variant.
        _ if !path.is_empty() => {
            ("is of another kind".to_owned(), "a word, or an object with one member".to_owned())
        }
        _ => (format!("broken JSON: {said}"), "JSON as RFC 8259 has it".to_owned()),
    };
    let line = e.line().max(1);
    // Columns of serde count bytes.
    let bytes = text.lines().nth(line - 1).unwrap_or("").as_bytes();
    let before = &bytes[..e.column().saturating_sub(1).min(bytes.len())];
    let column = String::from_utf8_lossy(before).chars().count() + 1;
    let mut place = format!("line {line} column {column}");
    if !path.is_empty() && path != "." {
        place = format!("{place}: {path}");
    }
    SceneError::new(Path::new(""), &place, problem, &allowed)
}

/// The value that serde found, in the words of JSON.
fn found(problem: &str) -> String {
    if let Some(length) = problem.strip_prefix("invalid length ") {
        return format!("is a list of {length}");
    }
    let kinds = ["invalid type: ", "invalid value: "];
    let Some(what) = kinds.iter().find_map(|kind| problem.strip_prefix(kind)) else {
        return problem.to_owned();
    };
    let what = match what {
        "map" => "an object",
        "sequence" => "a list",
        what => {
            // Serde names the kind of a value before it.
            let kinds = ["integer ", "floating point ", "boolean ", "string "];
            kinds.iter().find_map(|kind| what.strip_prefix(kind)).unwrap_or(what)
        }
    };
    format!("is {}", what.trim_matches('`'))
}

/// The value that serde expected, in the words of JSON.
fn wanted(allowed: &str) -> String {
    let words = match allowed {
        "f32" => "a number",
        "u8" | "u16" | "u32" | "u64" | "usize" => "a whole number of at least 0",
        "a boolean" => "true or false",
        "a string" => "a text",
        "a sequence" => "a list",
        "a map" => "an object",
        _ if allowed.starts_with("struct ") => "an object",
        _ => return allowed.replace("an array of length", "a list of"),
    };
    words.to_owned()
}

/// Where the first number of a text of JSON stands that would be infinite as an f32.
pub(super) fn too_large(text: &str) -> Option<usize> {
    let bytes = text.as_bytes();
    let (mut at, mut is_text) = (0, false);
    while let Some(byte) = bytes.get(at) {
        match byte {
            b'\\' if is_text => at += 1,
            b'"' => is_text = !is_text,
            b'0'..=b'9' if !is_text => {
                let is_part = |b: &&u8| b"0123456789.eE+-".contains(b);
                let length = bytes[at..].iter().take_while(is_part).count();
                let number = &text[at..at + length];
                // Shorter ones have no room for it.
                let may_be = length > 38 || number.contains(['e', 'E']);
                if may_be && number.parse::<f32>().is_ok_and(f32::is_infinite) {
                    return Some(at);
                }
                at += length - 1;
            }
            _ => {}
        }
        at += 1;
    }
    None
}

/// Before anything else of a text is read, for what else is in it depends on the version.
pub(super) fn check_version(text: &str) -> Result<(), SceneError> {
    /// The version alone.
    #[derive(Deserialize)]
    struct Head {
        drystone: Option<u64>,
    }
    let head: Head = serde_json::from_str(text).map_err(|e| broken(text, &e, ""))?;
    let found = match head.drystone {
        Some(version) if version == u64::from(VERSION) => return Ok(()),
        Some(version) => format!("is {version}"),
        None => "the version is missing".to_owned(),
    };
    let (line, column) = Place::default().key("drystone").find(text);
    let place = format!("line {line} column {column}: drystone");
    Err(SceneError::new(Path::new(""), &place, found, "1, the version of the format"))
}
