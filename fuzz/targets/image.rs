//! PNG and JPEG images in a glTF file, read for pictures.

#![no_main]

use std::path::Path;

use drystone_scene::gltf::{self, AutoColliders, Options};
use libfuzzer_sys::fuzz_target;

/// A triangle with a texture; the image is the rest of the binary part.
const JSON: &str = r#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":TOTAL}],
"bufferViews":[{"buffer":0,"byteLength":60},{"buffer":0,"byteOffset":60,"byteLength":SIZE}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},
{"bufferView":0,"byteOffset":36,"componentType":5126,"count":3,"type":"VEC2"}],
"images":[{"bufferView":1,"mimeType":"image/png"}],"textures":[{"source":0}],
"materials":[{"pbrMetallicRoughness":{"baseColorTexture":{"index":0}}}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"material":0}]}],
"nodes":[{"mesh":0}],"scenes":[{"nodes":[0]}],"scene":0}"#;

fuzz_target!(|image: &[u8]| {
    let mut points = Vec::new();
    for v in [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0] {
        points.extend(v.to_le_bytes());
    }
    points.extend(image);
    let total = points.len().next_multiple_of(4);
    points.resize(total, 0);
    let json = JSON.replace("TOTAL", &total.to_string()).replace("SIZE", &image.len().to_string());
    let mut json = json.into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let word = |n: usize| u32::try_from(n).unwrap_or(u32::MAX).to_le_bytes();
    let mut file = b"glTF\x02\0\0\0".to_vec();
    file.extend(word(12 + 8 + json.len() + 8 + total));
    file.extend(word(json.len()));
    file.extend(b"JSON");
    file.extend(json);
    file.extend(word(total));
    file.extend(b"BIN\0");
    file.extend(points);
    let options = Options { auto_colliders: Some(AutoColliders::Box), ..Options::default() };
    if let Ok(mut loaded) = gltf::from_slice(&file, "fuzz", Path::new(""), &options) {
        loaded.read_visuals();
    }
});
