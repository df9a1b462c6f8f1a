//! A document under construction with one buffer, and its two file forms.

use std::io::Write;
use std::path::Path;

use base64::Engine;
use drystone::{Pose, Quat, Vec3};
use serde_json::{Map, Value, json};

use crate::error::SceneError;
use crate::file::{Ending, Kind, WholeFile};
use crate::gltf::{Document, resource};
use crate::read::json::At;

/// A document with all its bytes in one buffer.
#[derive(Clone, Debug)]
pub(crate) struct Output {
    pub(crate) json: Value,
    bytes: Vec<u8>,
}

/// The list `key` of an object, made if it is missing.
pub(crate) fn list<'a>(object: &'a mut Value, key: &str) -> &'a mut Vec<Value> {
    if !object.is_object() {
        *object = Value::Object(Map::new());
    }
    let slot = &mut object[key];
    if !slot.is_array() {
        *slot = json!([]);
    }
    slot.as_array_mut().expect("made above")
}

/// Writes a pose into a node, without the parts that change nothing.
pub(super) fn place(node: &mut Value, pose: &Pose) {
    if pose.position != Vec3::ZERO {
        node["translation"] = json!(pose.position.to_array());
    }
    if pose.rotation != Quat::IDENTITY {
        node["rotation"] = json!(pose.rotation.normalized().to_array());
    }
}

impl Output {
    /// A copy of a document: its buffers joined, pictures beside it taken in.
    pub(crate) fn of(document: &Document) -> Result<Self, SceneError> {
        let mut out = Self { json: document.json.clone(), bytes: Vec::new() };
        let starts: Vec<usize> = document.buffers.iter().map(|b| out.append(b)).collect();
        if out.json.get("bufferViews").is_some() {
            for view in list(&mut out.json, "bufferViews") {
                move_view(view, &starts);
                if let Some(extensions) = view.get_mut("extensions").and_then(Value::as_object_mut)
                {
                    extensions.values_mut().for_each(|e| move_view(e, &starts));
                }
            }
        }
        out.take_in_pictures(document)?;
        Ok(out)
    }

    /// Pictures in files of their own become part of the buffer; one that cannot be read stays a
    /// reference.
    fn take_in_pictures(&mut self, document: &Document) -> Result<(), SceneError> {
        for (i, at) in At::root(&document.json).list("images")?.iter().enumerate() {
            let Some(uri) = at.get("uri") else { continue };
            let name = uri.text()?.to_ascii_lowercase();
            if name.starts_with("data:") {
                continue;
            }
            let kind = name.rsplit('.').next().unwrap_or("");
            let mime = match kind {
                "png" => "image/png",
                "jpg" | "jpeg" => "image/jpeg",
                "webp" => "image/webp",
                "ktx2" => "image/ktx2",
                _ => continue,
            };
            let Ok(bytes) = resource(&uri, &document.folder, Kind::Image) else { continue };
            let view = self.view(&bytes, None);
            let image = &mut list(&mut self.json, "images")[i];
            if let Some(object) = image.as_object_mut() {
                object.remove("uri");
                object.insert("bufferView".to_owned(), json!(view));
                object.insert("mimeType".to_owned(), json!(mime));
            }
        }
        Ok(())
    }

    /// Appends bytes at the next multiple of 4; gives the place.
    fn append(&mut self, bytes: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let at = self.bytes.len();
        self.bytes.extend_from_slice(bytes);
        at
    }

    /// Adds a buffer view; gives its number.
    pub(crate) fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        let at = self.append(bytes);
        let mut view = json!({"buffer": 0, "byteOffset": at, "byteLength": bytes.len()});
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        push(&mut self.json, "bufferViews", view)
    }

    /// Adds an accessor; gives its number.
    pub(crate) fn accessor(&mut self, accessor: Value) -> usize {
        push(&mut self.json, "accessors", accessor)
    }

    /// Writes the file.
    pub(crate) fn write(mut self, path: &Path) -> Result<Ending, SceneError> {
        let text = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gltf"));
        let mut buffers = Vec::new();
        if !self.bytes.is_empty() {
            let mut buffer = json!({"byteLength": self.bytes.len()});
            if text {
                let data = base64::engine::general_purpose::STANDARD.encode(&self.bytes);
                buffer["uri"] = json!(format!("data:application/octet-stream;base64,{data}"));
            }
            buffers.push(buffer);
        }
        if let Some(root) = self.json.as_object_mut() {
            root.remove("buffers");
            if !buffers.is_empty() {
                root.insert("buffers".to_owned(), Value::Array(buffers));
            }
        }
        let json = self.json.to_string();
        let bytes = if text { json.into_bytes() } else { glb(path, json, self.bytes)? };
        let written = WholeFile::create(path).and_then(|mut file| {
            file.write_all(&bytes)?;
            file.finish()
        });
        written.map_err(|e| SceneError::new(path, "", format!("cannot be written: {e}"), ""))
    }
}

/// Adds `item` to the list `key` of `object`; gives its number.
pub(crate) fn push(object: &mut Value, key: &str, item: Value) -> usize {
    let list = list(object, key);
    list.push(item);
    list.len() - 1
}

/// Points a view of one of several buffers at its place in the joint one.
fn move_view(view: &mut Value, starts: &[usize]) {
    let number = |v: &Value, key: &str| {
        v.get(key).and_then(Value::as_u64).and_then(|n| usize::try_from(n).ok())
    };
    let Some(start) = number(view, "buffer").and_then(|b| starts.get(b)) else { return };
    let offset = number(view, "byteOffset").unwrap_or(0);
    view["buffer"] = json!(0);
    view["byteOffset"] = json!(offset + start);
}

fn glb(path: &Path, json: String, mut binary: Vec<u8>) -> Result<Vec<u8>, SceneError> {
    let mut text = json.into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    binary.resize(binary.len().next_multiple_of(4), 0);
    let total = 12 + 8 + text.len() + if binary.is_empty() { 0 } else { 8 + binary.len() };
    let word = |n: usize| {
        u32::try_from(n).map(u32::to_le_bytes).map_err(|_| {
            SceneError::new(path, "", format!("it would have {n} bytes"), "up to 4 GB in a .glb")
        })
    };
    let mut out = Vec::with_capacity(total);
    out.extend_from_slice(b"glTF");
    out.extend_from_slice(&2_u32.to_le_bytes());
    out.extend_from_slice(&word(total)?);
    out.extend_from_slice(&word(text.len())?);
    out.extend_from_slice(b"JSON");
    out.extend_from_slice(&text);
    if !binary.is_empty() {
        out.extend_from_slice(&word(binary.len())?);
        out.extend_from_slice(b"BIN\0");
        out.extend_from_slice(&binary);
    }
    Ok(out)
}

/// Numbers as bytes.
pub(crate) fn bytes_of(numbers: &[f32]) -> Vec<u8> {
    numbers.iter().flat_map(|v| v.to_le_bytes()).collect()
}
