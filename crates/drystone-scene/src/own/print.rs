//! JSON for people: members in the order of their definition, what fits on one line, numbers as
//! short as they can be.

use serde::Serialize;

/// Most characters of a list or object that stands on one line.
const WIDTH: usize = 100;

/// A value of JSON, of a text that serde wrote.
enum Node<'a> {
    /// A number, a text, true or false.
    Leaf(&'a str),
    List(Vec<Node<'a>>),
    Map(Vec<(&'a str, Node<'a>)>),
}

/// The text of a value. Members that are null are left out.
///
/// # Errors
/// The errors of serde; a definition of data has none.
pub(crate) fn pretty(value: &impl Serialize) -> Result<String, serde_json::Error> {
    let text = serde_json::to_string(value)?;
    let mut out = String::with_capacity(text.len() * 5 / 4);
    print(&read(&mut text.as_str()), 0, &mut out);
    out.push('\n');
    Ok(out)
}

/// Takes a value off the front of a text without blanks.
fn read<'a>(rest: &mut &'a str) -> Node<'a> {
    match rest.as_bytes().first() {
        Some(b'[') => {
            let mut items = Vec::new();
            *rest = &rest[1..];
            while !rest.is_empty() && !rest.starts_with(']') {
                items.push(read(rest));
                *rest = rest.strip_prefix(',').unwrap_or(rest);
            }
            *rest = rest.get(1..).unwrap_or("");
            Node::List(items)
        }
        Some(b'{') => {
            let mut members = Vec::new();
            *rest = &rest[1..];
            while !rest.is_empty() && !rest.starts_with('}') {
                let key = leaf(rest);
                *rest = rest.strip_prefix(':').unwrap_or(rest);
                let value = read(rest);
                if !matches!(value, Node::Leaf("null")) {
                    members.push((key, value));
                }
                *rest = rest.strip_prefix(',').unwrap_or(rest);
            }
            *rest = rest.get(1..).unwrap_or("");
            Node::Map(members)
        }
        _ => Node::Leaf(leaf(rest)),
    }
}

/// Takes a text in quotes or a word off the front.
fn leaf<'a>(rest: &mut &'a str) -> &'a str {
    let bytes = rest.as_bytes();
    let mut end = 1;
    if bytes.first() == Some(&b'"') {
        while bytes.get(end).is_some_and(|b| *b != b'"') {
            end += if bytes[end] == b'\\' { 2 } else { 1 };
        }
        end += 1;
    } else {
        while bytes.get(end).is_some_and(|b| !b",]}".contains(b)) {
            end += 1;
        }
    }
    let (word, after) = rest.split_at(end.min(rest.len()));
    *rest = after;
    word
}

fn print(node: &Node<'_>, depth: usize, out: &mut String) {
    let mut line = String::new();
    if short(node, WIDTH.saturating_sub(2 * depth), &mut line) {
        out.push_str(&line);
        return;
    }
    match node {
        Node::List(items) => {
            out.push('[');
            if items.iter().all(is_plain) {
                fill(items, depth + 1, out);
            } else {
                for (i, item) in items.iter().enumerate() {
                    out.push_str(if i > 0 { "," } else { "" });
                    indent(depth + 1, out);
                    print(item, depth + 1, out);
                }
            }
            indent(depth, out);
            out.push(']');
        }
        Node::Map(members) => {
            out.push('{');
            for (i, (key, item)) in members.iter().enumerate() {
                out.push_str(if i > 0 { "," } else { "" });
                indent(depth + 1, out);
                out.push_str(key);
                out.push_str(": ");
                print(item, depth + 1, out);
            }
            indent(depth, out);
            out.push('}');
        }
        Node::Leaf(_) => out.push_str(&line),
    }
}

/// A number or word, or a list of such, as the points of a mesh.
fn is_plain(node: &Node<'_>) -> bool {
    let is_leaf = |node: &Node<'_>| matches!(node, Node::Leaf(_));
    match node {
        Node::List(items) => items.len() <= 12 && items.iter().all(is_leaf),
        node => is_leaf(node),
    }
}

/// Fills lines with short items.
fn fill(items: &[Node<'_>], depth: usize, out: &mut String) {
    let width = WIDTH.saturating_sub(2 * depth);
    let mut used = width;
    let mut word = String::new();
    for (i, item) in items.iter().enumerate() {
        word.clear();
        // Plain values always fit.
        short(item, usize::MAX, &mut word);
        out.push_str(if i > 0 { "," } else { "" });
        if used + word.len() + 2 > width {
            indent(depth, out);
            used = 0;
        } else {
            out.push(' ');
        }
        out.push_str(&word);
        used += word.len() + 2;
    }
}

fn indent(depth: usize, out: &mut String) {
    out.push('\n');
    out.extend(core::iter::repeat_n("  ", depth));
}

/// Writes a value on one line; false as soon as that is longer than `room`. A value that is no list
/// or object always fits.
fn short(node: &Node<'_>, room: usize, out: &mut String) -> bool {
    match node {
        Node::Leaf(word) => {
            out.push_str(&number(word));
            return true;
        }
        Node::List(items) => {
            out.push('[');
            for (i, item) in items.iter().enumerate() {
                out.push_str(if i > 0 { ", " } else { "" });
                if !short(item, room, out) || out.len() > room {
                    return false;
                }
            }
            out.push(']');
        }
        Node::Map(members) => {
            out.push('{');
            for (i, (key, item)) in members.iter().enumerate() {
                out.push_str(if i > 0 { ", " } else { "" });
                out.push_str(key);
                out.push_str(": ");
                if !short(item, room, out) || out.len() > room {
                    return false;
                }
            }
            out.push('}');
        }
    }
    out.len() <= room
}

/// A word as it is to be written: a number that reads back to the same f32, as short as it can be.
fn number(word: &str) -> std::borrow::Cow<'_, str> {
    let Some(whole) = word.strip_suffix(".0") else {
        // Readers take the number for an f64 first. Where that rounds twice to another f32, all
        // digits do.
        let single: Option<f32> = word.parse().ok().filter(|_| word.contains(['.', 'e']));
        let read = |text: &str| serde_json::from_str::<f32>(text).ok().map(f32::to_bits);
        return match single {
            Some(single) if read(word) != Some(single.to_bits()) => {
                f64::from(single).to_string().into()
            }
            _ => word.into(),
        };
    };
    // The sign of zero is lost in whole numbers, and beyond 2^24 not all of them are an f32.
    let is_exact = whole.len() <= 8 && whole != "-0";
    if is_exact { whole.into() } else { word.into() }
}

#[cfg(test)]
mod tests {
    use super::pretty;
    use serde_json::{Value, json};

    #[test]
    fn every_number_reads_back_to_the_same_bits() {
        let mut bits = 1_u32;
        let mut all =
            vec![0.0, -0.0, 0.1, 1.0, -2.5, 1.0e-5, 16_777_216.0, 3.0e9, f32::MIN_POSITIVE];
        for _ in 0..200_000 {
            // A generator with all bits.
            bits = bits.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            all.extend(Some(f32::from_bits(bits)).filter(|value| value.is_finite()));
        }
        let text = pretty(&all).unwrap();
        let back: Vec<f32> = serde_json::from_str(&text).unwrap();
        assert_eq!(back.len(), all.len());
        for (a, b) in all.iter().zip(&back) {
            assert_eq!(a.to_bits(), b.to_bits(), "{a}");
        }
        assert!(text.starts_with("[\n  0, -0.0, 0.1, 1, -2.5,"), "{}", &text[..40]);
        assert!(text.lines().all(|line| line.len() <= 100));
    }

    #[test]
    fn what_fits_stands_on_one_line_and_nulls_are_left_out() {
        let item = json!({"name": "x\\\"]".repeat(20), "n": u64::MAX});
        let value = json!({"a": [1.0, 0.5, []], "b": null, "list": [item, item, {}], "z": "a\"}"});
        let text = pretty(&value).unwrap();
        assert!(text.starts_with("{\n  \"a\": [1, 0.5, []],\n  \"list\": [\n    {\n"), "{text}");
        let mut without = value;
        without.as_object_mut().unwrap().remove("b");
        assert_eq!(serde_json::from_str::<Value>(&text).unwrap()["list"], without["list"]);
        assert_eq!(serde_json::from_str::<Value>(&text).unwrap()["z"], without["z"]);
    }
}
