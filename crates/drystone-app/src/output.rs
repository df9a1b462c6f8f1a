//! All that leaves the program: files, stdout, the line on stderr when something cannot be done.
//! And what comes back.

use std::fmt::Display;
use std::io::{self, ErrorKind, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use drystone_scene::file::{self, Ending, WholeFile};
use indicatif::{ProgressBar, ProgressStyle};

/// Why a command was given up.
#[derive(Debug)]
pub(crate) struct Failure {
    status: u8,
    message: String,
}

impl Failure {
    /// The input cannot be read or is invalid, or an output cannot be written: status 1.
    pub(crate) fn failed(message: impl Display) -> Self {
        Self { status: 1, message: one_line(&message.to_string()) }
    }

    /// The command line makes no sense: status 2.
    pub(crate) fn usage(message: impl Display) -> Self {
        Self { status: 2, message: one_line(&message.to_string()) }
    }

    /// The exit status that says so.
    pub(crate) fn code(&self) -> ExitCode {
        ExitCode::from(self.status)
    }
}

impl Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.message)
    }
}

/// The result of a command: its exit status, or why it failed.
pub(crate) type Outcome = Result<ExitCode, Failure>;

/// Messages may quote a file, and a file may hold anything: line ends and control characters become
/// spaces, so that a failure stays one line and leaves the terminal alone.
pub(crate) fn one_line(text: &str) -> String {
    let clean: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    clean.trim().to_owned()
}

/// Tells why a command was given up, in one line on stderr.
pub(crate) fn complain(failure: &Failure) {
    // There is nowhere to report a failure of stderr.
    let _ = writeln!(io::stderr().lock(), "error: {}", failure.message);
}

/// A bar that counts to `count`, if somebody looks at stderr; `template` says what stands on its
/// line.
pub(crate) fn progress(count: u64, template: &str) -> ProgressBar {
    if !io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(count);
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    bar
}

/// Writes to stdout. A reader that has gone (`drystone scenes | head -1`) is no failure.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    printed(out.write_all(text.as_bytes()).and_then(|()| out.flush()))
}

/// The result of a write to stdout: no failure if the reader has gone.
pub(crate) fn printed(written: io::Result<()>) -> Result<(), Failure> {
    match written {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::failed(format_args!("stdout: cannot be written: {e}")))
        }
        _ => Ok(()),
    }
}

/// A file being written, which has its name when it is whole; failures name it.
#[derive(Debug)]
pub(crate) struct Output {
    path: PathBuf,
    file: WholeFile,
}

impl Output {
    /// Opens the file for writing; what was in it stays until the new one is whole.
    pub(crate) fn create(path: &Path) -> Result<Self, Failure> {
        let file = WholeFile::create(path).map_err(|e| refused(path, &e))?;
        Ok(Self { path: path.to_owned(), file })
    }

    /// Adds bytes.
    pub(crate) fn write(&mut self, bytes: &[u8]) -> Result<(), Failure> {
        self.file.write_all(bytes).map_err(|e| refused(&self.path, &e))
    }

    /// A moment of the run is complete: a program at the other end of a pipe gets it now.
    pub(crate) fn end_moment(&mut self) -> Result<(), Failure> {
        if self.file.is_streamed() {
            self.file.flush().map_err(|e| refused(&self.path, &e))?;
        }
        Ok(())
    }

    /// Where another program is to write the bytes.
    #[cfg(feature = "render")]
    pub(crate) fn place(&self) -> &Path {
        self.file.partial().unwrap_or(&self.path)
    }

    /// Gives the file its name; returns the path.
    pub(crate) fn finish(self) -> Result<PathBuf, Failure> {
        let Self { path, file } = self;
        let ending = file.finish().map_err(|e| refused(&path, &e))?;
        warn_of(ending, &path);
        Ok(path)
    }
}

/// Tells on stderr if a file was not put in its place in one move.
pub(crate) fn warn_of(ending: Ending, path: &Path) {
    if ending == Ending::Copied {
        let shown = path.display();
        let what = "its folder takes no new file, so the old one was written over";
        let risk = "a crash in that moment would have cut it off";
        // There is nowhere to report a failure of stderr.
        let _ = writeln!(io::stderr().lock(), "warning: {shown}: {what}; {risk}");
    }
}

/// All of a file of this program's own, which begins with `kind`; only the beginning of another.
pub(crate) fn read(path: &Path, kind: [u8; 8]) -> Result<Vec<u8>, Failure> {
    file::read_any(path, file::Kind::Run, &kind).map_err(Failure::failed)
}

/// True if the path ends in one of these extensions, in any case.
pub(crate) fn has_extension(path: &Path, extensions: &[&str]) -> bool {
    path.extension().is_some_and(|e| extensions.iter().any(|known| e.eq_ignore_ascii_case(known)))
}

/// Finds out now whether a file can be written later; nothing is left of that.
pub(crate) fn probe(path: &Path) -> Result<(), Failure> {
    WholeFile::probe(path).map_err(|e| refused(path, &e))
}

/// Becomes true on Ctrl-C; a second Ctrl-C ends the program at once, without the files that are not
/// whole.
pub(crate) fn stop_on_interrupt() -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    let shared = Arc::clone(&stop);
    // Without a handler Ctrl-C ends the program as it would any other.
    let _ = ctrlc::set_handler(move || {
        if shared.swap(true, Ordering::Relaxed) {
            leave();
        }
    });
    stop
}

/// Lets Ctrl-C end the program at once, without the files that are not whole.
pub(crate) fn leave_on_interrupt() {
    let _ = ctrlc::set_handler(|| leave());
}

/// As if the signal had ended the program.
fn leave() -> ! {
    file::remove_unfinished();
    std::process::exit(130)
}

fn refused(path: &Path, e: &io::Error) -> Failure {
    Failure::failed(format_args!("{}: cannot be written: {e}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::one_line;

    #[test]
    fn a_message_stays_one_line_whatever_it_quotes() {
        assert_eq!(one_line("a\nb\r\nc\u{1b}[31m\n"), "a b  c [31m");
    }
}
