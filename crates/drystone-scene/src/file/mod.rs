//! Files on disk: written whole or not at all, and read no further than a limit.

mod limit;
mod partial;
mod whole;

pub use self::limit::{Kind, read, read_any};
pub use self::partial::remove_unfinished;
pub use self::whole::{Ending, WholeFile};

pub(crate) use self::limit::{open, rest};

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::PathBuf;

    /// An empty folder of this name for a test.
    pub(super) fn folder(name: &str) -> PathBuf {
        let path = std::env::temp_dir().join(format!("drystone-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        path
    }
}
