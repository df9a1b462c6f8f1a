//! How much of a file is read.

use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

use crate::error::SceneError;

/// The kind of a file, which sets how large it may be.
///
/// | kind | files | bytes |
/// |---|---|---:|
/// | `Document` | `.gltf`, `.glb`, each buffer beside them | 2 GB |
/// | `Surface` | `.obj` as a scene | 1 GB |
/// | `Text` | `.urdf`, `.xml` (MJCF) and what it includes, `.json` (own format, Rigid-IPC) | 200 MB |
/// | `Mesh` | `.obj`, `.stl` that a robot names | 200 MB |
/// | `Image` | `.png`, `.jpg` beside a glTF file | 200 MB |
/// | `Run` | snapshots and logs of the command | 4 GB |
/// | `List` | lists of known failures | 16 MB |
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Kind {
    /// A glTF file, or a buffer of one.
    Document,
    /// A mesh that is the scene.
    Surface,
    /// A scene in XML, or in JSON that is not glTF.
    Text,
    /// A mesh that a scene names.
    Mesh,
    /// An image of a material.
    Image,
    /// A snapshot or a log.
    Run,
    /// A list that a person keeps.
    List,
}

impl Kind {
    /// The bytes of the largest file that is read.
    #[must_use]
    pub const fn most(self) -> u64 {
        match self {
            Self::Document => 2_000_000_000,
            Self::Surface => 1_000_000_000,
            Self::Text | Self::Mesh | Self::Image => 200_000_000,
            Self::Run => 4_000_000_000,
            Self::List => 16_000_000,
        }
    }

    /// The limit in words.
    const fn allowed(self) -> &'static str {
        match self {
            Self::Document => "up to 2 GB",
            Self::Surface => "up to 1 GB",
            Self::Text | Self::Mesh | Self::Image => "up to 200 MB",
            Self::Run => "up to 4 GB",
            Self::List => "up to 16 MB",
        }
    }
}

/// All of a regular file.
///
/// # Errors
/// If it cannot be read, is no regular file, is empty, or is larger than its kind may be.
pub fn read(path: &Path, kind: Kind) -> Result<Vec<u8>, SceneError> {
    rest(open(path, kind)?, Vec::new(), path, kind)
}

/// All of a file, which may be a pipe and may be empty. Its beginning must be `head`, for which no
/// more is read of one that has another.
///
/// # Errors
/// If it cannot be read, or is larger than its kind may be. If a file begins otherwise, the bytes
/// read so far are returned.
pub fn read_any(path: &Path, kind: Kind, head: &[u8]) -> Result<Vec<u8>, SceneError> {
    let io = |e: std::io::Error| cannot(path, &e);
    let mut file = File::open(path).map_err(io)?;
    let mut bytes = Vec::new();
    file.by_ref().take(head.len() as u64).read_to_end(&mut bytes).map_err(io)?;
    if bytes != head {
        return Ok(bytes);
    }
    rest(file, bytes, path, kind)
}

/// Opens a regular file that is neither empty nor larger than its kind may be.
pub(crate) fn open(path: &Path, kind: Kind) -> Result<File, SceneError> {
    let fail = |problem: &str, allowed: &str| SceneError::new(path, "", problem, allowed);
    let io = |e: std::io::Error| fail(&e.to_string(), "a file that can be read");
    // Before it is opened: to open a pipe may wait for ever.
    let meta = fs::metadata(path).map_err(io)?;
    if meta.is_dir() {
        return Err(fail("it is a directory", "a file"));
    }
    if !meta.is_file() {
        return Err(fail("it is not a regular file", "a file"));
    }
    if meta.len() == 0 {
        return Err(fail("it is empty", "a file with a scene"));
    }
    if meta.len() > kind.most() {
        return Err(fail(&format!("it has {} bytes", meta.len()), kind.allowed()));
    }
    File::open(path).map_err(io)
}

/// Appends the rest of a file to `bytes`.
pub(crate) fn rest(
    file: File,
    mut bytes: Vec<u8>,
    path: &Path,
    kind: Kind,
) -> Result<Vec<u8>, SceneError> {
    // It may have grown since it was opened, or be of a kind without a size.
    let most = kind.most();
    let room = (most + 1).saturating_sub(bytes.len() as u64);
    file.take(room).read_to_end(&mut bytes).map_err(|e| cannot(path, &e))?;
    if bytes.len() as u64 > most {
        let problem = format!("it has more than {most} bytes");
        return Err(SceneError::new(path, "", problem, kind.allowed()));
    }
    Ok(bytes)
}

fn cannot(path: &Path, e: &std::io::Error) -> SceneError {
    SceneError::new(path, "", format!("cannot be read: {e}"), "")
}
