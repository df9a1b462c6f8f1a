//! Which format a `.json` file has.

use std::path::Path;

use serde::Deserialize;
use serde::de::IgnoredAny;

use super::text::broken;
use crate::error::SceneError;
use crate::read::{UTF8, text};

/// The format of a `.json` file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum JsonKind {
    /// A scene of this format: it has a member `drystone`.
    Own,
    /// A scene of Rigid-IPC: it has a member `rigid_body_problem`.
    RigidIpc,
}

/// The format of a `.json` file, by its members.
///
/// # Errors
/// A line that names the file, what is wrong and what is allowed.
pub fn kind_of(path: &Path) -> Result<JsonKind, SceneError> {
    let text = text(path, UTF8)?;
    kind_of_text(&text).map_err(|e| e.in_file(path))
}

pub(super) fn kind_of_text(text: &str) -> Result<JsonKind, SceneError> {
    /// The members that distinguish the formats.
    #[derive(Deserialize)]
    struct Head {
        drystone: Option<IgnoredAny>,
        rigid_body_problem: Option<IgnoredAny>,
    }
    let fail = |place: &str, problem: &str, allowed: &str| {
        SceneError::new(Path::new(""), place, problem, allowed)
    };
    let head: Head = serde_json::from_str(text).map_err(|e| broken(text, &e, ""))?;
    match head {
        Head { drystone: Some(_), .. } => Ok(JsonKind::Own),
        Head { rigid_body_problem: Some(_), .. } => Ok(JsonKind::RigidIpc),
        Head { .. } => Err(fail(
            "",
            "it has the mark of no known format",
            "\"drystone\": 1 at its top, or a \"rigid_body_problem\" of Rigid-IPC",
        )),
    }
}
