//! A file that has its name only when it is whole.
//!
//! Bytes go to a partial file in the same folder, which replaces the old file in one move at the
//! end. So at any moment, whatever ends the program, the name stands for the old file or for the
//! new one.
//!
//! The crates `tempfile` (3.27) and `atomic-write-file` (0.3) were considered. Neither follows
//! links, distinguishes pipes from files, or finds the leftovers of a run that was killed. They
//! would save two calls of the standard library.

use std::fs::{self, File};
use std::io::{self, BufWriter, ErrorKind, Seek, Write};
use std::path::{Path, PathBuf};

use super::partial::Partial;

/// Most links that are followed one after the other, as in Linux.
const MOST_LINKS: usize = 40;

/// Bytes that are kept until they are written.
const BUFFER: usize = 1 << 18;

/// How the file came to its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Ending {
    /// In one move.
    Moved,
    /// Copied over the old file when whole, because its folder takes no new file or because it is a
    /// mount of its own. A crash during the copy leaves it cut off.
    Copied,
    /// Byte by byte, because the name stands for a pipe or a device.
    Streamed,
}

/// A file being written, which gets its name by [`WholeFile::finish`] alone; dropped before that,
/// it leaves nothing.
///
/// Links are followed: the file that they lead to is replaced. An old file keeps its permissions,
/// and its owner where the system allows that; other hard links to it keep the old content. A path
/// that is no regular file (a pipe, a device, the target of `/dev/stdout`) is written directly.
#[derive(Debug)]
pub struct WholeFile {
    file: BufWriter<File>,
    /// `None` if bytes are written directly.
    place: Option<Place>,
}

/// Where a file is written, and where it belongs.
#[derive(Debug)]
struct Place {
    partial: Partial,
    target: PathBuf,
    /// The partial file is in the same folder.
    is_beside: bool,
}

impl WholeFile {
    /// Opens a file that is to be called `path`; what has that name stays until the file is whole.
    ///
    /// # Errors
    /// If no such file can be written: the folder is missing or takes no file, the old file is
    /// read-only or a folder.
    pub fn create(path: &Path) -> io::Result<Self> {
        let Some(target) = followed(path)? else {
            let file = File::create(path)?;
            return Ok(Self { file: BufWriter::with_capacity(BUFFER, file), place: None });
        };
        let old = match fs::metadata(&target) {
            Ok(meta) => Some(meta),
            Err(e) if e.kind() == ErrorKind::NotFound => None,
            Err(e) => return Err(e),
        };
        if old.is_some() {
            // A file that could not be written in its place is not replaced either. This changes
            // nothing in it.
            File::options().append(true).open(&target)?;
        }
        let (folder, name) = parts(&target)?;
        let (is_beside, (partial, file)) = match Partial::create(folder, &name) {
            Ok(made) => (true, made),
            Err(e) if old.is_some() && takes_no_file(&e) => {
                (false, Partial::create(&std::env::temp_dir(), &name)?)
            }
            Err(e) => return Err(e),
        };
        if let Some(old) = old {
            keep_owner(&file, &old);
            // Where modes cannot be set the file has those of a new one.
            let _ = file.set_permissions(old.permissions());
        }
        let place = Some(Place { partial, target, is_beside });
        Ok(Self { file: BufWriter::with_capacity(BUFFER, file), place })
    }

    /// Finds out whether [`WholeFile::create`] would succeed. Nothing is left of it and no pipe is
    /// opened, which would be noticed at its other end.
    ///
    /// # Errors
    /// The errors of [`WholeFile::create`].
    pub fn probe(path: &Path) -> io::Result<()> {
        match followed(path)? {
            Some(_) => Self::create(path).map(drop),
            None => Ok(()),
        }
    }

    /// Where the bytes go until the file is whole, for a program that is to write them; nothing for
    /// what is written directly.
    #[must_use]
    pub fn partial(&self) -> Option<&Path> {
        self.place.as_ref().map(|place| place.partial.path())
    }

    /// True if every byte is on its way to a reader at once, as in a pipe.
    #[must_use]
    pub fn is_streamed(&self) -> bool {
        self.place.is_none()
    }

    /// Gives the file its name: all of it is on disk before.
    ///
    /// # Errors
    /// If the disk is full or fails; an old file is as it was then.
    pub fn finish(mut self) -> io::Result<Ending> {
        self.file.flush()?;
        let Some(place) = self.place else { return Ok(Ending::Streamed) };
        let file = self.file.into_inner().map_err(io::IntoInnerError::into_error)?;
        to_disk(&file)?;
        if place.is_beside {
            match place.partial.rename(&place.target) {
                Ok(()) => return Ok(Ending::Moved),
                // A file that is mounted by itself, as containers have it.
                Err(e) if is_mount(&e) => {}
                Err(e) => return Err(e),
            }
        }
        let mut from = file;
        from.rewind()?;
        let mut to = File::options().write(true).truncate(true).open(&place.target)?;
        io::copy(&mut from, &mut to)?;
        to_disk(&to)?;
        Ok(Ending::Copied)
    }
}

impl Write for WholeFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// The file that a path leads to, links followed; nothing if that is to be written directly. It
/// need not exist.
fn followed(path: &Path) -> io::Result<Option<PathBuf>> {
    let mut at = path.to_owned();
    for _ in 0..MOST_LINKS {
        match fs::symlink_metadata(&at) {
            Ok(meta) if meta.is_symlink() => {
                // A link such as /dev/stdout stands for an open file, not for the name of one.
                if stands_for_open_file(&at) {
                    return Ok(None);
                }
                let to = fs::read_link(&at)?;
                at = at.parent().unwrap_or(Path::new("")).join(to);
            }
            Ok(meta) if meta.is_file() => return Ok(Some(at)),
            Ok(meta) if meta.is_dir() => {
                return Err(io::Error::new(ErrorKind::IsADirectory, "it is a directory"));
            }
            Ok(_) => return Ok(None),
            Err(e) if e.kind() == ErrorKind::NotFound => return Ok(Some(at)),
            Err(e) => return Err(e),
        }
    }
    Err(io::Error::other("links lead in a circle"))
}

fn stands_for_open_file(link: &Path) -> bool {
    let full = std::path::absolute(link).unwrap_or_else(|_| link.to_owned());
    full.starts_with("/proc") || (full.starts_with("/dev") && !full.starts_with("/dev/shm"))
}

/// Folder and name of a file; letters of the name that are none are replaced.
fn parts(target: &Path) -> io::Result<(&Path, String)> {
    let name = target.file_name().map(|name| name.to_string_lossy().into_owned());
    let name = name.ok_or_else(|| io::Error::new(ErrorKind::InvalidInput, "it names no file"))?;
    Ok((target.parent().unwrap_or(Path::new("")), name))
}

/// A folder that takes no new file may still have old ones that can be written.
fn takes_no_file(e: &io::Error) -> bool {
    matches!(e.kind(), ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem)
}

fn is_mount(e: &io::Error) -> bool {
    matches!(e.kind(), ErrorKind::ResourceBusy | ErrorKind::CrossesDevices)
}

/// Waits until a file is on disk, so that a full disk has reported its error. Some file systems
/// have no such operation.
fn to_disk(file: &File) -> io::Result<()> {
    match file.sync_all() {
        Err(e) if !matches!(e.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => Err(e),
        _ => Ok(()),
    }
}

/// Gives a file the owner of the old one, which takes the rights of an administrator unless it is
/// the same.
#[cfg(unix)]
fn keep_owner(file: &File, old: &fs::Metadata) {
    use std::os::unix::fs::{MetadataExt, fchown};
    let Ok(own) = file.metadata() else { return };
    if own.uid() != old.uid() || own.gid() != old.gid() {
        // Otherwise the process that writes the file owns it.
        let _ = fchown(file, Some(old.uid()), Some(old.gid()));
    }
}

#[cfg(not(unix))]
fn keep_owner(_file: &File, _old: &fs::Metadata) {}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::io::Write;
    use std::path::Path;

    use super::super::tests::folder;
    use super::{Ending, WholeFile};

    fn write(path: &Path, text: &str) -> std::io::Result<Ending> {
        let mut file = WholeFile::create(path)?;
        file.write_all(text.as_bytes())?;
        file.finish()
    }

    #[test]
    fn the_old_file_stays_until_the_new_one_is_whole() {
        let folder = folder("whole-old");
        let path = folder.join("no extension");
        assert_eq!(write(&path, "old").unwrap(), Ending::Moved);
        let mut file = WholeFile::create(&path).unwrap();
        file.write_all(b"half").unwrap();
        file.flush().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read(file.partial().unwrap()).unwrap(), b"half");
        drop(file);
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(
            fs::read_dir(&folder).unwrap().count(),
            1,
            "a file that was given up leaves nothing"
        );
        write(&path, "new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert!(write(&folder, "").is_err(), "a folder is no file");
        assert!(write(&folder.join("missing/file"), "").is_err());
        fs::remove_dir_all(folder).unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_permissions_kept() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = folder("whole-links");
        fs::create_dir(folder.join("to")).unwrap();
        let path = folder.join("to/file");
        fs::write(&path, "old").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
        symlink("to/file", folder.join("near")).unwrap();
        symlink(folder.join("near"), folder.join("far")).unwrap();
        write(&folder.join("far"), "new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o640);
        assert!(fs::symlink_metadata(folder.join("far")).unwrap().is_symlink());
        // A link to a missing file makes that file.
        symlink("to/later", folder.join("ahead")).unwrap();
        write(&folder.join("ahead"), "later").unwrap();
        assert_eq!(fs::read(folder.join("to/later")).unwrap(), b"later");
        symlink("round", folder.join("round")).unwrap();
        assert!(write(&folder.join("round"), "").is_err());
        assert_eq!(write(Path::new("/dev/null"), "gone").unwrap(), Ending::Streamed);
        fs::remove_dir_all(folder).unwrap();
    }
}
