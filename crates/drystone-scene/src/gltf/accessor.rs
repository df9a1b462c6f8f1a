//! Accessors: numbers out of buffers, every index and length checked.

use drystone::Vec3;

use super::document::Document;
use crate::error::SceneError;
use crate::read::json::At;

/// The bytes an accessor spans, and how they are laid out.
struct View<'a> {
    bytes: &'a [u8],
    count: usize,
    stride: usize,
    component: usize,
    normalized: bool,
}

const BYTE: usize = 5120;
const UNSIGNED_BYTE: usize = 5121;
const SHORT: usize = 5122;
const UNSIGNED_SHORT: usize = 5123;
const UNSIGNED_INT: usize = 5125;
const FLOAT: usize = 5126;

const fn component_size(component: usize) -> Option<usize> {
    match component {
        BYTE | UNSIGNED_BYTE => Some(1),
        SHORT | UNSIGNED_SHORT => Some(2),
        UNSIGNED_INT | FLOAT => Some(4),
        _ => None,
    }
}

/// Opens the accessor that `reference` names; its elements have `width` components.
fn view<'a>(
    document: &'a Document,
    reference: &At<'_>,
    kind: &str,
    width: usize,
) -> Result<View<'a>, SceneError> {
    let root = At::root(&document.json);
    let at = &root.entry("accessors", reference)?;
    if let Some(sparse) = at.get("sparse") {
        return Err(sparse.error("is a sparse accessor", "an accessor that is not sparse"));
    }
    let type_ = at.need("type")?;
    if type_.text()? != kind {
        return Err(type_.wrong(&format!("\"{kind}\"")));
    }
    let component_at = at.need("componentType")?;
    let component = component_at.size()?;
    let Some(size) = component_size(component) else {
        return Err(component_at.wrong("5120, 5121, 5122, 5123, 5125 or 5126"));
    };
    let count_at = at.need("count")?;
    let count = count_at.size()?;
    document.work.add(count, &count_at)?;
    let view_at = &root.entry("bufferViews", &at.need("bufferView")?)?;
    let (bytes, length) = window(document, view_at)?;
    let number = |at: &At<'_>, key: &str| at.get(key).map_or(Ok(0), |at| at.size());
    let element = size * width;
    let stride = match view_at.get("byteStride") {
        None => element,
        Some(at) => {
            let stride = at.size()?;
            if !(element..=4096).contains(&stride) {
                return Err(at.wrong(&format!("{element} to 4096")));
            }
            stride
        }
    };
    let offset = number(at, "byteOffset")?;
    let span = count.checked_sub(1).and_then(|n| n.checked_mul(stride)?.checked_add(element));
    let span = if count == 0 { Some(0) } else { span };
    let inside = span.and_then(|span| bytes.get(offset..offset.checked_add(span)?));
    let bytes = inside.ok_or_else(|| {
        let problem = format!("is {count}: {count} elements do not fit");
        count_at.error(problem, &format!("what the buffer view's {length} bytes hold"))
    })?;
    Ok(View { bytes, count, stride, component, normalized: at.flag("normalized")? })
}

/// The part of a buffer that a buffer view is, and its length [bytes].
fn window<'a>(document: &'a Document, view_at: &At<'_>) -> Result<(&'a [u8], usize), SceneError> {
    let buffer = view_at.need("buffer")?.index(document.buffers.len(), "buffers")?;
    let begin = view_at.get("byteOffset").map_or(Ok(0), |at| at.size())?;
    let length = view_at.need("byteLength")?.size()?;
    let whole = document.buffers[buffer].as_slice();
    let bytes =
        begin.checked_add(length).and_then(|end| whole.get(begin..end)).ok_or_else(|| {
            let problem = format!("bytes {begin} to {begin} + {length}");
            view_at.error(problem, &format!("a part of the buffer's {} bytes", whole.len()))
        })?;
    Ok((bytes, length))
}

/// The bytes of the buffer view that `reference` names.
pub(crate) fn bytes<'a>(
    document: &'a Document,
    reference: &At<'_>,
) -> Result<&'a [u8], SceneError> {
    let view_at = At::root(&document.json).entry("bufferViews", reference)?;
    Ok(window(document, &view_at)?.0)
}

/// How many numbers the elements of an accessor have: 3 or 4, as colors may.
pub(crate) fn width_of_colors(
    document: &Document,
    reference: &At<'_>,
) -> Result<(&'static str, usize), SceneError> {
    let type_ = At::root(&document.json).entry("accessors", reference)?.need("type")?;
    match type_.text()? {
        "VEC3" => Ok(("VEC3", 3)),
        "VEC4" => Ok(("VEC4", 4)),
        _ => Err(type_.wrong("\"VEC3\" or \"VEC4\"")),
    }
}

impl View<'_> {
    /// Component `k` of element `i`; in range by construction, 0 otherwise.
    fn number(&self, i: usize, k: usize) -> f32 {
        let size = component_size(self.component).unwrap_or(1);
        let at = i * self.stride + k * size;
        let b = self.bytes.get(at..at + size).unwrap_or(&[0; 4]);
        let scaled = |v: f32, max: f32| if self.normalized { (v / max).max(-1.0) } else { v };
        match self.component {
            BYTE => scaled(f32::from(i8::from_le_bytes([b[0]])), 127.0),
            UNSIGNED_BYTE => scaled(f32::from(b[0]), 255.0),
            SHORT => scaled(f32::from(i16::from_le_bytes([b[0], b[1]])), 32767.0),
            UNSIGNED_SHORT => scaled(f32::from(u16::from_le_bytes([b[0], b[1]])), 65535.0),
            FLOAT => f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
            _ => f32::NAN,
        }
    }

    fn index(&self, i: usize) -> u32 {
        let size = component_size(self.component).unwrap_or(1);
        let at = i * self.stride;
        let b = self.bytes.get(at..at + size).unwrap_or(&[0; 4]);
        match size {
            1 => u32::from(b[0]),
            2 => u32::from(u16::from_le_bytes([b[0], b[1]])),
            _ => u32::from_le_bytes([b[0], b[1], b[2], b[3]]),
        }
    }
}

/// Positions [m]; floats, or integers as KHR_mesh_quantization has them.
pub(crate) fn positions(document: &Document, at: &At<'_>) -> Result<Vec<Vec3>, SceneError> {
    let view = view(document, at, "VEC3", 3)?;
    if view.component == UNSIGNED_INT {
        return Err(
            at.error("names an accessor of 32 bit integers", "floats, or 8 or 16 bit integers")
        );
    }
    let point = |i| Vec3::from([view.number(i, 0), view.number(i, 1), view.number(i, 2)]);
    let points: Vec<Vec3> = (0..view.count).map(point).collect();
    if let Some(i) = points.iter().position(|p| !p.is_finite()) {
        return Err(at.error(format!("vertex {i} is not finite"), "finite coordinates"));
    }
    Ok(points)
}

/// The finite numbers of an accessor whose elements have `width` of them.
pub(crate) fn numbers(
    document: &Document,
    at: &At<'_>,
    kind: &str,
    width: usize,
) -> Result<Vec<f32>, SceneError> {
    let view = view(document, at, kind, width)?;
    let all = (0..view.count).flat_map(|i| (0..width).map(move |k| (i, k)));
    let numbers: Vec<f32> = all.map(|(i, k)| view.number(i, k)).collect();
    if let Some(i) = numbers.iter().position(|n| !n.is_finite()) {
        return Err(at.error(format!("element {} is not finite", i / width), "finite numbers"));
    }
    Ok(numbers)
}

/// Vertex numbers, each below `vertices`.
pub(crate) fn indices(
    document: &Document,
    at: &At<'_>,
    vertices: usize,
) -> Result<Vec<u32>, SceneError> {
    let view = view(document, at, "SCALAR", 1)?;
    if ![UNSIGNED_BYTE, UNSIGNED_SHORT, UNSIGNED_INT].contains(&view.component) {
        return Err(
            at.error("names an accessor that is not of unsigned integers", "unsigned integers")
        );
    }
    let list: Vec<u32> = (0..view.count).map(|i| view.index(i)).collect();
    if let Some(i) = list.iter().position(|&v| v as usize >= vertices) {
        let problem = format!("index {i} names vertex {}", list[i]);
        return Err(at.error(problem, &format!("vertices below {vertices}")));
    }
    Ok(list)
}
