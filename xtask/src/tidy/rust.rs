//! A minimal Rust lexer that separates code from comments, strings and unit tests.

use std::ops::Range;

/// A source text split into three texts of the same length and line structure; foreign parts are
/// blank.
pub struct Source {
    pub code: String,
    pub comments: String,
    pub strings: String,
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Code,
    Comment,
    String,
}

impl Source {
    pub fn new(text: &str) -> Self {
        let kinds = kinds(text.as_bytes());
        let only = |kind: Kind| {
            let keep = |at: usize, c: char| if kinds[at] == kind || c == '\n' { c } else { ' ' };
            // Blanks are as long as the character they replace, so that offsets agree.
            let blank = |at: usize, c: char| match keep(at, c) {
                ' ' => " ".repeat(c.len_utf8()),
                c => c.to_string(),
            };
            text.char_indices().map(|(at, c)| blank(at, c)).collect()
        };
        let (comments, strings) = (only(Kind::Comment), only(Kind::String));
        Self { code: only(Kind::Code), comments, strings }
    }

    /// The byte ranges of items under `#[cfg(test)]`.
    pub fn unit_tests(&self) -> Vec<Range<usize>> {
        let mut ranges = Vec::new();
        let mut from = 0;
        while let Some(at) = self.code[from..].find("#[cfg(test)]") {
            let start = from + at;
            let end = self.item_end(start + "#[cfg(test)]".len());
            ranges.push(start..end);
            from = end;
        }
        ranges
    }

    /// The code with unit tests blanked.
    pub fn code_without_tests(&self) -> String {
        let mut code = self.code.clone().into_bytes();
        for range in self.unit_tests() {
            for byte in &mut code[range] {
                *byte = if *byte == b'\n' { b'\n' } else { b' ' };
            }
        }
        String::from_utf8(code).unwrap_or_default()
    }

    /// The end of the item that starts at `from`: its semicolon, or its closing brace.
    fn item_end(&self, from: usize) -> usize {
        match self.code[from..].find([';', '{']) {
            Some(at) if self.code[from + at..].starts_with('{') => block_end(&self.code, from + at),
            Some(at) => from + at + 1,
            None => self.code.len(),
        }
    }
}

/// The end of the block whose `{` is at `open`.
pub fn block_end(code: &str, open: usize) -> usize {
    let mut depth = 0;
    for (at, byte) in code.bytes().enumerate().skip(open) {
        match byte {
            b'{' => depth += 1,
            b'}' if depth == 1 => return at + 1,
            b'}' => depth -= 1,
            _ => {}
        }
    }
    code.len()
}

/// Whether the byte can occur in an identifier.
pub fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_'
}

/// Offsets at which `word` occurs as a whole word.
pub fn words<'a>(text: &'a str, word: &'a str) -> impl Iterator<Item = usize> + 'a {
    text.match_indices(word).map(|(at, _)| at).filter(move |&at| {
        let before = at.checked_sub(1).map(|i| text.as_bytes()[i]);
        let after = text.as_bytes().get(at + word.len()).copied();
        !before.is_some_and(is_word) && !after.is_some_and(is_word)
    })
}

fn kinds(text: &[u8]) -> Vec<Kind> {
    let mut kinds = vec![Kind::Code; text.len()];
    let mut at = 0;
    while at < text.len() {
        let (kind, end) = token(text, at);
        kinds[at..end].fill(kind);
        at = end;
    }
    kinds
}

/// The kind and the end of the token at `at`.
fn token(text: &[u8], at: usize) -> (Kind, usize) {
    let rest = &text[at..];
    let end_of = |pattern: &[u8], from: usize| {
        let found = text[from..].windows(pattern.len()).position(|window| window == pattern);
        found.map_or(text.len(), |i| from + i + pattern.len())
    };
    if rest.starts_with(b"//") {
        let length = rest.iter().position(|&byte| byte == b'\n').unwrap_or(rest.len());
        return (Kind::Comment, at + length);
    }
    if rest.starts_with(b"/*") {
        return (Kind::Comment, block_comment_end(text, at));
    }
    if rest[0] == b'"' {
        return (Kind::String, string_end(text, at));
    }
    if is_word(rest[0]) {
        let word = rest.iter().take_while(|&&byte| is_word(byte)).count();
        let hashes = rest[word..].iter().take_while(|&&byte| byte == b'#').count();
        let raw = matches!(&rest[..word], b"r" | b"br" | b"cr");
        if raw && rest.get(word + hashes) == Some(&b'"') {
            let close = [b"\"".as_slice(), &b"#".repeat(hashes)].concat();
            return (Kind::String, end_of(&close, at + word + hashes + 1));
        }
        return (Kind::Code, at + word);
    }
    // A character, unless it is a lifetime: 'x' and '\…' have a closing quote, 'a has none.
    if rest[0] == b'\'' {
        let character = match rest.get(1) {
            Some(b'\\') => Some(end_of(b"'", at + 3)),
            Some(&lead) => {
                let length = if lead.is_ascii() { 1 } else { lead.leading_ones() as usize };
                (rest.get(1 + length) == Some(&b'\'')).then_some(at + length + 2)
            }
            None => None,
        };
        return (Kind::Code, character.unwrap_or(at + 1).min(text.len()));
    }
    (Kind::Code, at + 1)
}

fn string_end(text: &[u8], open: usize) -> usize {
    let mut at = open + 1;
    while at < text.len() && text[at] != b'"' {
        at += if text[at] == b'\\' { 2 } else { 1 };
    }
    (at + 1).min(text.len())
}

fn block_comment_end(text: &[u8], open: usize) -> usize {
    let (mut at, mut depth) = (open, 0);
    while at < text.len() {
        if text[at..].starts_with(b"/*") {
            (at, depth) = (at + 2, depth + 1);
        } else if text[at..].starts_with(b"*/") {
            (at, depth) = (at + 2, depth - 1);
            if depth == 0 {
                return at;
            }
        } else {
            at += 1;
        }
    }
    text.len()
}
