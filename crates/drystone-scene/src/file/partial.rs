//! The file beside another one that holds the bytes until they are whole: `.NAME.partial`.
//!
//! The process that writes it holds a lock on it. The system releases the lock when the process
//! ends, however it ends. So a partial file without a lock is the leftover of a run that was
//! killed, and is removed. A locked file belongs to a run that goes on; the next number is taken
//! then (`.NAME.1.partial`). Locks hold between containers that share a folder, where process
//! numbers mean nothing.

use std::collections::BTreeSet;
use std::fs::{self, File, TryLockError};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Number of runs that may write the same output at once.
const MOST: u32 = 100;

/// Longer names of files are cut, for those of partial files must have room for more [bytes].
const MOST_NAME: usize = 200;

/// Partial files of this process.
static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Removes the partial files of this process. It is for the moment before [`std::process::exit`],
/// which drops nothing: bytes written afterwards are lost.
pub fn remove_unfinished() {
    let mut unfinished = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
    for path in core::mem::take(&mut *unfinished) {
        // One that is not there any more has got its final name.
        let _ = fs::remove_file(path);
    }
}

/// A partial file, locked; removed when dropped.
#[derive(Debug)]
pub(super) struct Partial {
    path: PathBuf,
    /// Holds the lock.
    lock: File,
}

impl Partial {
    /// Makes one for the file `name` in `folder`; the second value writes to it.
    pub(super) fn create(folder: &Path, name: &str) -> io::Result<(Self, File)> {
        let mut end = name.len().min(MOST_NAME);
        while !name.is_char_boundary(end) {
            end -= 1;
        }
        let name = &name[..end];
        let mut number = 0;
        // Another run may take away what was just made and is not locked yet: a few tries a number.
        for _ in 0..4 * MOST {
            let infix = if number == 0 { String::new() } else { format!(".{number}") };
            let path = folder.join(format!(".{name}{infix}.partial"));
            match File::options().read(true).write(true).create_new(true).open(&path) {
                Ok(file) => {
                    if let Some(partial) = Self::take(path, &file)? {
                        return Ok((partial, file));
                    }
                }
                Err(e) if e.kind() == ErrorKind::AlreadyExists => {
                    if number < MOST && !remove_leftover(&path) {
                        number += 1;
                    }
                }
                Err(e) => return Err(e),
            }
        }
        Err(io::Error::new(ErrorKind::AlreadyExists, "too many partial files stand beside it"))
    }

    /// Locks a file that was just made; none if another run took it for a leftover before.
    fn take(path: PathBuf, file: &File) -> io::Result<Option<Self>> {
        match file.try_lock() {
            // Where there are no locks, nobody can take it for a leftover either.
            Ok(()) | Err(TryLockError::Error(_)) => {}
            Err(TryLockError::WouldBlock) => return Ok(None),
        }
        if !is_at(&path, file) {
            return Ok(None);
        }
        let lock = file.try_clone()?;
        UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner).insert(path.clone());
        Ok(Some(Self { path, lock }))
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Gives it its final name, over what has that name.
    pub(super) fn rename(&self, target: &Path) -> io::Result<()> {
        fs::rename(&self.path, target)
    }
}

impl Drop for Partial {
    fn drop(&mut self) {
        let mut unfinished = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
        // Not there if it has got its final name, or was removed because the program ends.
        if unfinished.remove(&self.path) && is_at(&self.path, &self.lock) {
            // If it cannot be removed, the next run finds it as a leftover.
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// Removes a partial file that nobody writes; false if somebody may.
fn remove_leftover(path: &Path) -> bool {
    let Ok(meta) = fs::symlink_metadata(path) else { return true };
    // A link may lead to a file of another program, and opening a pipe may block for ever.
    if !meta.is_file() {
        return false;
    }
    match File::open(path) {
        Ok(file) => {
            file.try_lock().is_ok() && (!is_at(path, &file) || fs::remove_file(path).is_ok())
        }
        Err(e) => e.kind() == ErrorKind::NotFound,
    }
}

/// True if `path` names the open file.
fn is_at(path: &Path, file: &File) -> bool {
    let (Ok(named), Ok(open)) = (fs::symlink_metadata(path), file.metadata()) else {
        return false;
    };
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        named.dev() == open.dev() && named.ino() == open.ino()
    }
    #[cfg(not(unix))]
    {
        named.is_file() && open.is_file()
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::io::Write;
    use std::path::Path;

    use super::super::tests::folder;
    use super::Partial;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<String> =
            entries.map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_leftover_is_taken_away_and_a_file_in_use_is_not() {
        let folder = folder("partial-leftover");
        fs::write(folder.join(".a.csv.partial"), "from a run that was killed").unwrap();
        let (first, mut file) = Partial::create(&folder, "a.csv").unwrap();
        file.write_all(b"one").unwrap();
        assert_eq!(fs::read(first.path()).unwrap(), b"one");
        let (second, _) = Partial::create(&folder, "a.csv").unwrap();
        assert_eq!(names(&folder), [".a.csv.1.partial", ".a.csv.partial"]);
        drop(first);
        assert_eq!(names(&folder), [".a.csv.1.partial"]);
        second.rename(&folder.join("a.csv")).unwrap();
        drop(second);
        assert_eq!(names(&folder), ["a.csv"]);
        fs::remove_dir_all(folder).unwrap();
    }

    #[test]
    fn a_long_name_is_cut_between_letters() {
        let folder = folder("partial-long");
        let (partial, _) = Partial::create(&folder, &"ä".repeat(127)).unwrap();
        assert!(partial.path().exists());
        drop(partial);
        assert!(names(&folder).is_empty());
        fs::remove_dir_all(folder).unwrap();
    }
}
