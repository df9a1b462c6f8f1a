//! Scenes that are opened, and the notes on their files.

use std::sync::Arc;

use drystone_scene::Running;

/// A scene that was opened.
#[derive(Debug)]
pub struct Opened {
    /// Its name, for the window's title.
    pub name: String,
    /// The scene at its beginning.
    pub running: Running,
    /// Steps a second.
    pub hz: f32,
    /// Parts of its file that were left out, a line each.
    pub notes: Vec<String>,
}

/// Opens a scene: a name of the catalog, or a path. An error is a line for the user.
pub type Opener = Box<dyn FnMut(&str) -> Result<Opened, String> + Send>;

/// Notes on a file that are shown.
pub(super) const MOST_NOTES: usize = 30;
/// Letters of a line that is shown.
pub(super) const MOST_LETTERS: usize = 400;

/// The first notes on a file, each short enough for a window. A file may have any number of faults.
pub(super) fn shown_notes(notes: Vec<String>) -> Arc<[String]> {
    let more = notes.len().saturating_sub(MOST_NOTES);
    let mut shown: Vec<String> = notes.into_iter().take(MOST_NOTES).map(shortened).collect();
    if more > 0 {
        shown.push(format!("and {more} more: `drystone info` lists them"));
    }
    shown.into()
}

/// A text without its end if it is long.
pub(super) fn shortened(text: String) -> String {
    match text.char_indices().nth(MOST_LETTERS) {
        Some((end, _)) => format!("{} …", &text[..end]),
        None => text,
    }
}
