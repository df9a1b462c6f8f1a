//! Places in a file: the path of a field, and the line and column where its value stands.

use core::fmt::{self, Display};

/// A step of a path.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Step {
    Key(String),
    Item(usize),
}

/// The path of a field, such as `bodies[3].shapes[0].box.half_extents`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Place(Vec<Step>);

impl Place {
    /// The member `key` of this.
    pub(crate) fn key(&self, key: &str) -> Self {
        let mut steps = self.0.clone();
        steps.push(Step::Key(key.to_owned()));
        Self(steps)
    }

    /// Item `number` of this.
    pub(crate) fn item(&self, number: usize) -> Self {
        let mut steps = self.0.clone();
        steps.push(Step::Item(number));
        Self(steps)
    }

    /// Item `number` of the list `key`.
    pub(crate) fn nth(&self, key: &str, number: usize) -> Self {
        self.key(key).item(number)
    }

    /// The field that the engine calls `path`, such as `shapes[0].radius`.
    pub(crate) fn field(&self, path: &str) -> Self {
        let mut place = self.clone();
        for part in path.split('.') {
            let mut words = part.split('[');
            if let Some(key) = words.next().filter(|key| !key.is_empty()) {
                place = place.key(key);
            }
            for number in words {
                match number.trim_end_matches(']').parse() {
                    Ok(number) => place = place.item(number),
                    Err(_) => place = place.key(number),
                }
            }
        }
        place
    }

    /// Line and column of its value in a text of JSON, counted from 1; of the closest thing around
    /// it if it is not there.
    pub(crate) fn find(&self, text: &str) -> (usize, usize) {
        let mut scan = Scan { bytes: text.as_bytes(), at: 0 };
        for step in &self.0 {
            let before = scan.at;
            let found = match step {
                Step::Key(key) => scan.enter_member(key),
                Step::Item(number) => scan.enter_item(*number),
            };
            if found.is_none() {
                scan.at = before;
                break;
            }
        }
        scan.blanks();
        let before = &text.as_bytes()[..scan.at.min(text.len())];
        let line = before.iter().filter(|b| **b == b'\n').count() + 1;
        let start = before.iter().rposition(|b| *b == b'\n').map_or(0, |i| i + 1);
        let column = String::from_utf8_lossy(&before[start..]).chars().count() + 1;
        (line, column)
    }
}

impl Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, step) in self.0.iter().enumerate() {
            match step {
                Step::Key(key) if i == 0 => write!(f, "{key}")?,
                Step::Key(key) => write!(f, ".{key}")?,
                Step::Item(number) => write!(f, "[{number}]")?,
            }
        }
        Ok(())
    }
}

/// A walk over a text that is known to be JSON; it ends where that turns out not to be so.
struct Scan<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Scan<'_> {
    fn blanks(&mut self) {
        while self.bytes.get(self.at).is_some_and(u8::is_ascii_whitespace) {
            self.at += 1;
        }
    }

    fn take(&mut self, byte: u8) -> Option<()> {
        self.blanks();
        (self.bytes.get(self.at) == Some(&byte)).then(|| self.at += 1)
    }

    /// A text in quotes, as it stands.
    fn text(&mut self) -> Option<&[u8]> {
        self.take(b'"')?;
        let from = self.at - 1;
        while *self.bytes.get(self.at)? != b'"' {
            self.at += if self.bytes[self.at] == b'\\' { 2 } else { 1 };
        }
        self.at += 1;
        self.bytes.get(from..self.at)
    }

    /// Steps over a value.
    fn value(&mut self) -> Option<()> {
        let mut depth = 0_usize;
        loop {
            self.blanks();
            match self.bytes.get(self.at)? {
                b'"' => {
                    self.text()?;
                }
                b'{' | b'[' => {
                    depth += 1;
                    self.at += 1;
                }
                b'}' | b']' => {
                    depth = depth.checked_sub(1)?;
                    self.at += 1;
                }
                b',' | b':' => self.at += 1,
                _ => {
                    let is_end = |b: &u8| b",:]} \n\r\t".contains(b);
                    while self.bytes.get(self.at).is_some_and(|b| !is_end(b)) {
                        self.at += 1;
                    }
                }
            }
            if depth == 0 {
                return Some(());
            }
        }
    }

    /// Goes to the value of the last member of this name, as serde reads it.
    fn enter_member(&mut self, key: &str) -> Option<()> {
        self.take(b'{')?;
        loop {
            let name: String = serde_json::from_slice(self.text()?).ok()?;
            self.take(b':')?;
            if name == key {
                return Some(());
            }
            self.value()?;
            self.take(b',')?;
        }
    }

    fn enter_item(&mut self, number: usize) -> Option<()> {
        self.take(b'[')?;
        for _ in 0..number {
            self.value()?;
            self.take(b',')?;
        }
        self.blanks();
        (self.bytes.get(self.at) != Some(&b']')).then_some(())
    }
}

#[cfg(test)]
mod tests {
    use super::Place;

    #[test]
    fn a_path_leads_to_the_line_and_column_of_its_value() {
        let text = "{\n \"a\": [1, {\"b\\\"[\": \"]\", \"c\": 3}],\n \"d\": true}";
        let root = Place::default();
        let table = [
            (root.clone(), (1, 1), ""),
            (root.nth("a", 0), (2, 8), "a[0]"),
            (root.nth("a", 1), (2, 11), "a[1]"),
            (root.nth("a", 1).key("c"), (2, 30), "a[1].c"),
            (root.key("d"), (3, 7), "d"),
            // If a thing is not there, the thing around it.
            (root.nth("a", 2), (2, 7), "a[2]"),
            (root.key("d").key("e"), (3, 7), "d.e"),
            (root.field("a[1].c"), (2, 30), "a[1].c"),
        ];
        for (place, found, shown) in table {
            assert_eq!(place.find(text), found, "{shown}");
            assert_eq!(place.to_string(), shown);
        }
    }

    #[test]
    fn text_that_is_cut_off_ends_the_search() {
        let text = r#"{"a": {"b": [1, "x\"#;
        for end in 0..text.len() {
            let _ = Place::default().key("a").nth("b", 7).find(&text[..end]);
        }
    }
}
