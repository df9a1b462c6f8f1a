//! A JSON document with its buffers, and how it is read from a file; nothing of it is trusted.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use base64::Engine;
use serde_json::Value;

use crate::error::SceneError;
use crate::file::{self, Kind};
use crate::read::json::{self, At};

/// Buffers that have more bytes together are refused.
const MAX_BUFFERS: usize = 4_000_000_000;

/// A glTF document in memory.
#[derive(Clone, Debug, Default)]
pub struct Document {
    /// The JSON part.
    pub json: Value,
    /// The bytes of each buffer of the JSON part.
    pub buffers: Vec<Vec<u8>>,
    /// The folder that relative URIs start from.
    pub folder: PathBuf,
    /// Number of elements read so far.
    pub(crate) work: Work,
}

/// Elements of accessors and nodes that may be read of a document, those read again counted again:
/// a small file can name the same ones without end.
const MOST_ELEMENTS: u64 = 200_000_000;

/// Number of elements that were read of a document.
#[derive(Debug, Default)]
pub(crate) struct Work(AtomicU64);

impl Work {
    /// Counts `elements` more, which `at` names.
    ///
    /// # Errors
    /// If they are too many in all.
    pub(crate) fn add(&self, elements: usize, at: &At<'_>) -> Result<(), SceneError> {
        let before = self.0.fetch_add(elements as u64, Ordering::Relaxed);
        if before.saturating_add(elements as u64) <= MOST_ELEMENTS {
            return Ok(());
        }
        let problem =
            format!("with it more than {MOST_ELEMENTS} vertices, indices and keys are read");
        Err(at.error(problem, "fewer or simpler meshes"))
    }
}

impl Clone for Work {
    fn clone(&self) -> Self {
        Self(AtomicU64::new(self.0.load(Ordering::Relaxed)))
    }
}

/// Reads a `.gltf` or `.glb` file and all its buffers. The content says which of the two it is.
pub(crate) fn open(path: &Path) -> Result<Document, SceneError> {
    let mut file = file::open(path, Kind::Document)?;
    let io = |e: std::io::Error| SceneError::new(path, "", e, "a file that can be read");
    let mut bytes = Vec::new();
    file.by_ref().take(4096).read_to_end(&mut bytes).map_err(io)?;
    let is_glb = bytes.starts_with(b"glTF");
    if !is_glb && json_text(&bytes).first() != Some(&b'{') {
        let allowed = "a glTF file: JSON text that begins with {, or binary glTF";
        return Err(SceneError::new(path, "", "it is not a glTF file", allowed));
    }
    let bytes = file::rest(file, bytes, path, Kind::Document)?;
    let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
    parse(&bytes, folder).map_err(|e| e.in_file(path))
}

/// A document from the bytes of a file whose relative URIs start from `folder`.
pub(crate) fn parse(bytes: &[u8], folder: PathBuf) -> Result<Document, SceneError> {
    let (text, chunk) =
        if bytes.starts_with(b"glTF") { split_glb(bytes)? } else { (json_text(bytes), None) };
    let nowhere =
        |problem: String, allowed: &str| SceneError::new(Path::new(""), "", problem, allowed);
    let json = json::parse(text)?;
    if !json.is_object() {
        return Err(nowhere("the JSON is not an object".to_owned(), "a glTF object"));
    }
    let root = At::root(&json);
    let version = root.need("asset")?.need("version")?;
    if !version.text()?.starts_with("2.") {
        return Err(version.wrong("glTF 2.x"));
    }
    let mut buffers: Vec<Vec<u8>> = Vec::new();
    let mut room = MAX_BUFFERS;
    for (i, at) in root.list("buffers")?.into_iter().enumerate() {
        let bytes = buffer(&at, if i == 0 { chunk } else { None }, &folder)?;
        // Many buffers may name the same file.
        room = room
            .checked_sub(bytes.len())
            .ok_or_else(|| at.error("with it the buffers are too large", "4 GB in all buffers"))?;
        buffers.push(bytes);
    }
    Ok(Document { json, buffers, folder, work: Work::default() })
}

/// The text without a byte order mark and leading white space.
fn json_text(bytes: &[u8]) -> &[u8] {
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    bytes.trim_ascii_start()
}

/// The JSON and BIN chunks of a binary file.
fn split_glb(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), SceneError> {
    let fail = |place: &str, problem: String, allowed: &str| {
        Err(SceneError::new(Path::new(""), place, problem, allowed))
    };
    let word = |at: usize| {
        let b = bytes.get(at..at + 4)?;
        Some(u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
    };
    if word(4) != Some(2) {
        let problem = word(4).map_or("it is cut short".to_owned(), |v| format!("is {v}"));
        return fail("header.version", problem, "2");
    }
    let mut json = None;
    let mut binary = None;
    let mut at = 12;
    while let (Some(length), Some(kind)) = (word(at), word(at + 4)) {
        let begin = at + 8;
        let end = begin.saturating_add(length as usize);
        let Some(chunk) = bytes.get(begin..end) else {
            let problem = format!("has {length} bytes, the file ends before that");
            return fail(&format!("chunk at byte {at}"), problem, "a whole chunk");
        };
        match kind {
            0x4E4F_534A if json.is_none() => json = Some(chunk),
            0x004E_4942 if binary.is_none() => binary = Some(chunk),
            _ => {}
        }
        at = end.next_multiple_of(4);
    }
    match json {
        Some(text) => Ok((text, binary)),
        None => fail("", "it has no JSON chunk".to_owned(), "binary glTF 2.0"),
    }
}

/// The bytes of one buffer.
fn buffer(at: &At<'_>, chunk: Option<&[u8]>, folder: &Path) -> Result<Vec<u8>, SceneError> {
    let length = at.need("byteLength")?;
    let wanted = length.size()?;
    let bytes = match at.get("uri") {
        Some(uri) => resource(&uri, folder, Kind::Document)?,
        None => match chunk {
            Some(chunk) => chunk.to_vec(),
            None => {
                return Err(at.error("it has no uri and there is no BIN chunk", "one of the two"));
            }
        },
    };
    if bytes.len() < wanted {
        let problem = format!("is {wanted}, but the buffer has {} bytes", bytes.len());
        return Err(length.error(problem, "the length of the buffer"));
    }
    let mut bytes = bytes;
    bytes.truncate(wanted);
    Ok(bytes)
}

/// The bytes that a URI names: base64 data, or a file. The path of a file is relative to the
/// document's folder. It may lead out of that folder, as the format allows
/// (`../textures/wood.png`).
pub(crate) fn resource(at: &At<'_>, folder: &Path, kind: Kind) -> Result<Vec<u8>, SceneError> {
    let uri = at.text()?;
    if let Some(data) = uri.strip_prefix("data:") {
        let Some((head, text)) = data.split_once(',') else {
            return Err(at.error("has no data", "data:…;base64,…"));
        };
        if !head.ends_with(";base64") {
            return Err(at.error("is not base64", "data:…;base64,…"));
        }
        // Standard alphabet, with or without padding at the end.
        let text = text.trim_end_matches('=');
        return base64::engine::general_purpose::STANDARD_NO_PAD
            .decode(text)
            .map_err(|e| at.error(format!("broken base64: {e}"), "base64 data"));
    }
    let name = percent_decoded(uri);
    let relative = Path::new(&name);
    if name.contains("://") || relative.is_absolute() || name.contains('\0') {
        return Err(at.wrong("a data URI or a path relative to the file"));
    }
    if cfg!(target_arch = "wasm32") {
        return Err(
            at.wrong("a data URI, or a .glb file: a page in a browser reads no file beside it")
        );
    }
    let path = folder.join(relative);
    file::read(&path, kind).map_err(|e| at.error(e, ""))
}

fn percent_decoded(uri: &str) -> String {
    let mut out = Vec::with_capacity(uri.len());
    let bytes = uri.as_bytes();
    let digit = |b: Option<&u8>| b.and_then(|&b| char::from(b).to_digit(16));
    let mut i = 0;
    while i < bytes.len() {
        match (bytes[i], digit(bytes.get(i + 1)), digit(bytes.get(i + 2))) {
            (b'%', Some(high), Some(low)) => {
                out.push(u8::try_from(high * 16 + low).unwrap_or(b'?'));
                i += 3;
            }
            (b, _, _) => {
                out.push(b);
                i += 1;
            }
        }
    }
    String::from_utf8_lossy(&out).into_owned()
}
