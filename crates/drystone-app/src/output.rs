//! All that leaves the program: files, stdout, the line on stderr when something cannot be done. And what comes back.

use std::fmt::Display;
use std::fs::File;
use std::io::{self, BufWriter, ErrorKind, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

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

    /// The command line asks for something that makes no sense: status 2.
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

/// Messages may quote a file, and a file may hold anything: line ends and control characters become
/// spaces, so that a failure stays one line and leaves the terminal alone.
pub(crate) fn one_line(text: &str) -> String {
    let clean: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    clean.trim().to_owned()
}

/// Tells why a command was given up, in one line on stderr.
pub(crate) fn complain(failure: &Failure) {
    // Nobody is left to be told if this fails.
    let _ = writeln!(io::stderr().lock(), "error: {}", failure.message);
}

/// A bar that counts to `count`, if somebody looks at stderr; `template` says what stands on its line.
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
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::failed(format_args!("stdout: cannot be written: {e}")))
        }
        _ => Ok(()),
    }
}

/// A file being written; failures name it.
#[derive(Debug)]
pub(crate) struct Output {
    path: PathBuf,
    file: BufWriter<File>,
}

impl Output {
    /// Opens the file for writing; what was in it is lost.
    pub(crate) fn create(path: &Path) -> Result<Self, Failure> {
        let file = File::create(path).map_err(|e| refused(path, &e))?;
        Ok(Self { path: path.to_owned(), file: BufWriter::with_capacity(1 << 18, file) })
    }

    /// Adds bytes.
    pub(crate) fn write(&mut self, bytes: &[u8]) -> Result<(), Failure> {
        self.file.write_all(bytes).map_err(|e| refused(&self.path, &e))
    }

    /// Writes out what is buffered; returns the path.
    pub(crate) fn finish(mut self) -> Result<PathBuf, Failure> {
        self.file.flush().map_err(|e| refused(&self.path, &e))?;
        Ok(self.path)
    }
}

/// All of a file.
pub(crate) fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    std::fs::read(path)
        .map_err(|e| Failure::failed(format_args!("{}: cannot be read: {e}", path.display())))
}

/// Finds out now whether a file can be written later, without losing what is in it.
pub(crate) fn probe(path: &Path) -> Result<(), Failure> {
    let fresh = !path.exists();
    if !(fresh || path.is_file() || path.is_dir()) {
        // To open a pipe would be noticed at its other end.
        return Ok(());
    }
    File::options().append(true).create(true).open(path).map_err(|e| refused(path, &e))?;
    if fresh {
        // It only was a probe; if it cannot be removed an empty file stays until it is written.
        let _ = std::fs::remove_file(path);
    }
    Ok(())
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
