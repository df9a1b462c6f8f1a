//! The one error of reading and writing scenes.

use core::fmt::{self, Display};
use std::path::Path;

/// A scene could not be read or written: which file, where in it, what is wrong, what is allowed.
/// Shown as one line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneError {
    file: String,
    place: String,
    problem: String,
    allowed: String,
}

impl SceneError {
    /// An error at `place` (empty: the file as a whole); `allowed` may be empty too.
    #[must_use]
    pub fn new(file: &Path, place: &str, problem: impl Display, allowed: &str) -> Self {
        let file = file.display().to_string();
        let (place, allowed) = (place.to_owned(), allowed.to_owned());
        Self { file, place, problem: problem.to_string(), allowed }
    }

    /// The file.
    #[must_use]
    pub fn file(&self) -> &str {
        &self.file
    }

    /// The place in the file, such as `nodes[3].scale`; empty for the file as a whole.
    #[must_use]
    pub fn place(&self) -> &str {
        &self.place
    }

    /// The problem.
    #[must_use]
    pub fn problem(&self) -> &str {
        &self.problem
    }

    /// The values that would have been right; may be empty.
    #[must_use]
    pub fn allowed(&self) -> &str {
        &self.allowed
    }

    /// The same error, found in a file that the requested file names.
    pub(crate) fn in_place(mut self, file: &str) -> Self {
        self.place = format!("{file} {}", self.place).trim_end().to_owned();
        self
    }

    /// The same error with its file set; errors made deep inside do not know it.
    pub(crate) fn in_file(mut self, file: &Path) -> Self {
        self.file = file.display().to_string();
        self
    }
}

/// `text` in one line of at most `limit` characters.
fn line(text: &str, limit: usize) -> String {
    let mut out: String =
        text.chars().map(|c| if c.is_control() { ' ' } else { c }).take(limit).collect();
    if text.chars().nth(limit).is_some() {
        out.push('…');
    }
    out
}

impl Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // A note on a file does not name it.
        for (text, limit) in [(&self.file, 300), (&self.place, 200)] {
            if !text.is_empty() {
                write!(f, "{}: ", line(text, limit))?;
            }
        }
        write!(f, "{}", line(&self.problem, 300))?;
        if !self.allowed.is_empty() {
            write!(f, ", expected {}", line(&self.allowed, 500))?;
        }
        Ok(())
    }
}

impl core::error::Error for SceneError {}
