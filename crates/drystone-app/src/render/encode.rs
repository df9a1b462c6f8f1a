//! Pictures as files: PNG, numbered PNGs, GIF, and films by ffmpeg.

use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use drystone_render::Picture;

use crate::output::{Failure, Output, has_extension, probe};

/// The kind of output of `--render`, by the file's name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// One PNG.
    Still,
    /// A PNG a frame: the name has a number such as `%04d`.
    Frames,
    /// An animated GIF.
    Gif,
    /// A film that ffmpeg makes.
    Film,
}

/// Endings of files that ffmpeg writes.
const FILMS: [&str; 4] = ["mp4", "webm", "mkv", "mov"];

impl Kind {
    /// The kind of a file by its name; none if it is not known.
    pub(crate) fn of(path: &Path) -> Option<Self> {
        if has_extension(path, &["png"]) {
            let name = path.file_name()?.to_str().unwrap_or_default();
            match (name.matches('%').count(), pattern(name)) {
                (0, _) => Some(Self::Still),
                (1, Some(_)) => Some(Self::Frames),
                _ => None,
            }
        } else if has_extension(path, &["gif"]) {
            Some(Self::Gif)
        } else {
            has_extension(path, &FILMS).then_some(Self::Film)
        }
    }

    /// Size of the pictures unless the user says it [px].
    pub(crate) const fn usual_size(self) -> (u32, u32) {
        match self {
            Self::Gif => (640, 360),
            _ => (1280, 720),
        }
    }

    /// Frames a second unless the user says it. A GIF counts in hundredths of a second.
    pub(crate) const fn usual_fps(self) -> f64 {
        match self {
            Self::Gif => 25.0,
            _ => 30.0,
        }
    }
}

/// Where in a name the number goes, and how many digits it has at least.
fn pattern(name: &str) -> Option<(usize, usize, usize)> {
    let start = name.find('%')?;
    let digits = name[start + 1..].find('d')?;
    let width = &name[start + 1..start + 1 + digits];
    let width = if width.is_empty() { 1 } else { width.parse().ok().filter(|w| *w < 20)? };
    Some((start, start + digits + 2, width))
}

/// Takes the frames of a film.
pub(crate) struct Encoder {
    path: PathBuf,
    way: Way,
}

enum Way {
    Frames {
        next: u64,
    },
    /// `shown` are the colors of the last frame.
    Gif {
        encoder: Box<gif::Encoder<Vec<u8>>>,
        file: Output,
        delay: u16,
        shown: Vec<u8>,
    },
    /// It writes where the file is until it is whole.
    Ffmpeg {
        child: Child,
        file: Output,
    },
}

impl Encoder {
    /// Opens the file for frames of this size [px], `fps` a second.
    pub(crate) fn create(
        path: &Path,
        kind: Kind,
        (width, height): (u32, u32),
        fps: f64,
    ) -> Result<Self, Failure> {
        let failed = |e: &dyn std::fmt::Display| broken(path, e);
        let way = match kind {
            Kind::Still | Kind::Frames => {
                probe(&numbered(path, 1))?;
                Way::Frames { next: 1 }
            }
            Kind::Gif => {
                let side = |n: u32| {
                    u16::try_from(n).map_err(|_| failed(&"a GIF has at most 65535 points a side"))
                };
                let (width, height) = (side(width)?, side(height)?);
                let mut encoder =
                    gif::Encoder::new(Vec::new(), width, height, &[]).map_err(|e| failed(&e))?;
                encoder.set_repeat(gif::Repeat::Infinite).map_err(|e| failed(&e))?;
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "clamped"
                )]
                let delay = (100.0 / fps).round().clamp(2.0, 60_000.0) as u16;
                let file = Output::create(path)?;
                Way::Gif { encoder: Box::new(encoder), file, delay, shown: Vec::new() }
            }
            Kind::Film => {
                let file = Output::create(path)?;
                Way::Ffmpeg { child: ffmpeg(path, file.place(), (width, height), fps)?, file }
            }
        };
        Ok(Self { path: path.to_owned(), way })
    }

    /// Adds a frame.
    pub(crate) fn add(&mut self, picture: Picture) -> Result<(), Failure> {
        match &mut self.way {
            Way::Frames { next } => {
                let path = numbered(&self.path, *next);
                *next += 1;
                write_png(&path, &picture)
            }
            Way::Gif { encoder, file, delay, shown } => {
                let mut frame = changed(&picture, shown);
                frame.delay = *delay;
                encoder.write_frame(&frame).map_err(|e| broken(&self.path, &e))?;
                *shown = picture.rgba;
                file.write(encoder.get_ref())?;
                encoder.get_mut().clear();
                Ok(())
            }
            Way::Ffmpeg { child, .. } => {
                let sent = child.stdin.as_mut().map(|pipe| pipe.write_all(&picture.rgba));
                match sent {
                    Some(Ok(())) => Ok(()),
                    _ => Err(complaint(&self.path, child)),
                }
            }
        }
    }

    /// Finishes the file.
    pub(crate) fn finish(self) -> Result<(), Failure> {
        match self.way {
            Way::Frames { .. } => Ok(()),
            Way::Gif { encoder, mut file, .. } => {
                let rest = encoder.into_inner().map_err(|e| broken(&self.path, &e))?;
                file.write(&rest)?;
                file.finish().map(|_| ())
            }
            Way::Ffmpeg { mut child, file } => {
                drop(child.stdin.take());
                match child.wait() {
                    Ok(status) if status.success() => file.finish().map(|_| ()),
                    _ => Err(complaint(&self.path, &mut child)),
                }
            }
        }
    }
}

/// The difference of a picture to the one `shown` before, which is empty at first. It is the
/// rectangle around the points that differ, and in it only these points.
fn changed(picture: &Picture, shown: &[u8]) -> gif::Frame<'static> {
    let (width, height) = (picture.width as usize, picture.height as usize);
    let point = |x: usize, y: usize| {
        let at = 4 * (y * width + x);
        let own = &picture.rgba[at..at + 4];
        if shown.get(at..at + 4) == Some(own) { [0; 4] } else { [own[0], own[1], own[2], 255] }
    };
    let differs = |x: usize, y: usize| point(x, y)[3] != 0;
    let rows = || (0..height).filter(|&y| (0..width).any(|x| differs(x, y)));
    let columns = || (0..width).filter(|&x| (0..height).any(|y| differs(x, y)));
    // Where nothing changes it is a point that does not: a frame cannot be empty.
    let span = |first: Option<usize>, last: Option<usize>| {
        let first = first.unwrap_or(0);
        first..last.unwrap_or(first) + 1
    };
    let (x, y) =
        (span(columns().next(), columns().next_back()), span(rows().next(), rows().next_back()));
    let mut rgba: Vec<u8> =
        y.clone().flat_map(|y| x.clone().flat_map(move |x| point(x, y))).collect();
    let side = |n: usize| u16::try_from(n).unwrap_or(u16::MAX);
    let mut frame = gif::Frame::from_rgba_speed(side(x.len()), side(y.len()), &mut rgba, 10);
    (frame.left, frame.top) = (side(x.start), side(y.start));
    frame
}

fn broken(path: &Path, e: &dyn std::fmt::Display) -> Failure {
    Failure::failed(format_args!("{}: cannot be written: {e}", path.display()))
}

/// The path with its number put in.
fn numbered(path: &Path, number: u64) -> PathBuf {
    let name = path.file_name().and_then(|n| n.to_str()).unwrap_or_default();
    match pattern(name) {
        Some((start, end, width)) => {
            path.with_file_name(format!("{}{number:0width$}{}", &name[..start], &name[end..]))
        }
        None => path.to_owned(),
    }
}

/// Writes a picture as a PNG file.
pub(crate) fn write_png(path: &Path, picture: &Picture) -> Result<(), Failure> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, picture.width, picture.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.set_compression(png::Compression::High);
    // Pictures are opaque: a quarter of the bytes says nothing.
    let rgb: Vec<u8> = picture.rgba.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect();
    let written = encoder.write_header().and_then(|mut w| {
        w.write_image_data(&rgb)?;
        w.finish()
    });
    written.map_err(|e| broken(path, &e))?;
    let mut file = Output::create(path)?;
    file.write(&bytes)?;
    file.finish().map(|_| ())
}

/// Starts ffmpeg, which takes pictures from its input and writes to `place` in the format that
/// `path` names.
fn ffmpeg(
    path: &Path,
    place: &Path,
    (width, height): (u32, u32),
    fps: f64,
) -> Result<Child, Failure> {
    let webm = has_extension(path, &["webm"]);
    let formats = [("mkv", "matroska"), ("webm", "webm"), ("mov", "mov")];
    let format = formats.iter().find(|(ending, _)| has_extension(path, &[ending]));
    let codec: &[&str] = if webm {
        &["-c:v", "libvpx-vp9", "-crf", "30", "-b:v", "0", "-deadline", "good", "-cpu-used", "5"]
    } else {
        &["-c:v", "libx264", "-crf", "18", "-preset", "medium", "-movflags", "+faststart"]
    };
    let mut command = Command::new("ffmpeg");
    command
        .args(["-hide_banner", "-loglevel", "error", "-nostdin", "-y"])
        .args(["-f", "rawvideo", "-pix_fmt", "rgba", "-s", &format!("{width}x{height}")])
        .args(["-r", &format!("{fps}"), "-i", "pipe:0", "-an"])
        .args(codec)
        // Most players know only this format; it needs even sides.
        .args(["-vf", "crop=trunc(iw/2)*2:trunc(ih/2)*2", "-pix_fmt", "yuv420p"])
        .args(["-fflags", "+bitexact", "-flags:v", "+bitexact"])
        .args(["-f", format.map_or("mp4", |(_, name)| name)])
        .arg(Path::new(".").join(place));
    // Ctrl-C in a terminal reaches all of a group; it would end the film before the last picture is
    // in it.
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
    command.spawn().map_err(|e| {
        let shown = path.display();
        if e.kind() == ErrorKind::NotFound {
            Failure::failed(format_args!(
                "{shown}: films are made by ffmpeg, which is not installed (Debian and Ubuntu: `apt-get \
                 install ffmpeg`); without it the name must end in .gif, or numbered \
                 pictures such as frame-%04d.png"
            ))
        } else {
            Failure::failed(format_args!("{shown}: ffmpeg cannot be started: {e}"))
        }
    })
}

/// Why ffmpeg gave up.
fn complaint(path: &Path, child: &mut Child) -> Failure {
    drop(child.stdin.take());
    let mut said = String::new();
    if let Some(stderr) = child.stderr.as_mut() {
        // If it cannot be read, the message leaves it out.
        let _ = stderr.take(4096).read_to_string(&mut said);
    }
    let _ = child.wait();
    let said = said.trim();
    let said = if said.is_empty() { "it said nothing" } else { said };
    Failure::failed(format_args!("{}: ffmpeg gave up: {said}", path.display()))
}

#[cfg(test)]
mod tests {
    use std::path::{Path, PathBuf};

    use super::{Kind, Picture, changed, numbered};

    #[test]
    fn a_frame_holds_what_changed() {
        let picture = |rgba: [u8; 24]| Picture { width: 3, height: 2, rgba: rgba.to_vec() };
        let mut rgba = [255; 24];
        let first = changed(&picture(rgba), &[]);
        assert_eq!((first.left, first.top, first.width, first.height), (0, 0, 3, 2));
        let shown = rgba;
        rgba[16] = 7;
        let next = changed(&picture(rgba), &shown);
        assert_eq!((next.left, next.top, next.width, next.height), (1, 1, 1, 1));
        let none = changed(&picture(rgba), &rgba);
        assert_eq!((none.width, none.height), (1, 1));
        assert_eq!(none.transparent, Some(none.buffer[0]));
    }

    #[test]
    fn names_tell_what_is_made() {
        let kind = |name: &str| Kind::of(Path::new(name));
        assert_eq!(kind("a.png"), Some(Kind::Still));
        assert_eq!(kind("a-%04d.PNG"), Some(Kind::Frames));
        assert_eq!(kind("a%d.png"), Some(Kind::Frames));
        assert_eq!(kind("a.gif"), Some(Kind::Gif));
        assert_eq!(kind("a.webm"), Some(Kind::Film));
        for bad in ["a", "a.jpg", "a%s.png", "a%d%d.png", "a%99d.png", "100%.png"] {
            assert_eq!(kind(bad), None, "{bad}");
        }
        assert_eq!(numbered(Path::new("x/f-%03d.png"), 7), PathBuf::from("x/f-007.png"));
        assert_eq!(numbered(Path::new("f%d.png"), 1234), PathBuf::from("f1234.png"));
    }
}
