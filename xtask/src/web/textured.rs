//! A glTF file for dropping on the page. It has textured bodies: one with holes, one transparent,
//! one with a broken image.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

/// PNG of 2 × 2 pixels: red, green; blue, white.
const QUARTERS: &str = "iVBORw0KGgoAAAANSUhEUgAAAAIAAAACCAYAAABytg0kAAAAG0lEQVR42mM4ISLyX2SByH8GEY0T/+/cufMfAEUsCU26NBOzAAAAAElFTkSuQmCC";
/// PNG of 2 × 2 pixels: yellow, transparent; transparent, yellow.
const HOLES: &str = "iVBORw0KGgoAAAANSUhEUgAAAAIAAAACCAYAAABytg0kAAAAFElEQVR42mN4dkLkPxAzMIAIEAcAVRcJB68SllwAAAAASUVORK5CYII=";
/// The first bytes of a PNG.
const BROKEN: &str = "iVBORw0KGgo=";

/// Position and half extents of a body [m], its material number, and whether it moves.
type Cuboid = ([f32; 3], [f32; 3], usize, bool);

const CUBOIDS: [Cuboid; 5] = [
    // The ground.
    ([0.0, -0.1, 0.0], [3.0, 0.1, 3.0], 4, false),
    ([-1.1, 0.6, 0.0], [0.6, 0.6, 0.6], 0, true),
    ([0.4, 0.8, 0.6], [0.6, 0.8, 0.08], 1, true),
    ([1.7, 0.8, 0.6], [0.5, 0.8, 0.08], 2, true),
    ([1.0, 0.4, -1.2], [0.4, 0.4, 0.4], 3, true),
];

/// The bytes of the file.
pub(super) fn file() -> Vec<u8> {
    let uri = |png: &str| json!({ "uri": format!("data:image/png;base64,{png}") });
    let images = [QUARTERS, HOLES, BROKEN].map(uri);
    let textures = [0, 1, 2].map(|image| json!({ "source": image, "sampler": 0 }));
    let mut file = json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": ["KHR_implicit_shapes", "KHR_physics_rigid_bodies"],
        "images": images,
        "samplers": [{ "magFilter": 9728 }],
        "textures": textures,
        "materials": [
            material(Some(0), [1.0; 4], "OPAQUE"),
            material(Some(1), [1.0; 4], "MASK"),
            material(None, [0.9, 0.0, 0.9, 0.5], "BLEND"),
            material(Some(2), [0.9, 0.5, 0.1, 1.0], "OPAQUE"),
            material(None, [0.5, 0.5, 0.5, 1.0], "OPAQUE"),
        ],
        "scene": 0,
    });
    let mut bytes = Vec::new();
    let (mut views, mut accessors) = (Vec::new(), Vec::new());
    let mut add = |numbers: &[f32], kind: &str, width: usize| {
        let start = bytes.len();
        bytes.extend(numbers.iter().flat_map(|x| x.to_le_bytes()));
        views.push(json!({ "buffer": 0, "byteOffset": start, "byteLength": bytes.len() - start }));
        accessors.push(json!({
            "bufferView": views.len() - 1, "componentType": 5126, "count": numbers.len() / width, "type": kind
        }));
        accessors.len() - 1
    };
    let [normals, coordinates] = [(1, "VEC3", 3), (2, "VEC2", 2)]
        .map(|(part, kind, width)| add(&corners([1.0; 3])[part], kind, width));
    let (mut meshes, mut shapes, mut nodes) = (Vec::new(), Vec::new(), Vec::new());
    for (number, (at, half, material, moves)) in CUBOIDS.iter().enumerate() {
        let places = add(&corners(*half)[0], "VEC3", 3);
        meshes.push(json!({ "primitives": [{
            "attributes": { "POSITION": places, "NORMAL": normals, "TEXCOORD_0": coordinates },
            "material": material,
        }] }));
        shapes.push(json!({ "type": "box", "box": { "size": half.map(|x| 2.0 * x) } }));
        let mut physics = json!({ "collider": { "geometry": { "shape": number } } });
        if *moves {
            physics["motion"] = json!({});
        }
        nodes.push(json!({
            "name": format!("cuboid {number}"), "mesh": number, "translation": at,
            "extensions": { "KHR_physics_rigid_bodies": physics },
        }));
    }
    file["buffers"] = json!([{
        "byteLength": bytes.len(), "uri": format!("data:application/octet-stream;base64,{}", STANDARD.encode(&bytes))
    }]);
    file["extensions"] =
        json!({ "KHR_implicit_shapes": { "shapes": shapes }, "KHR_physics_rigid_bodies": {} });
    file["scenes"] = json!([{ "nodes": (0..nodes.len()).collect::<Vec<_>>() }]);
    for (key, list) in
        [("bufferViews", views), ("accessors", accessors), ("meshes", meshes), ("nodes", nodes)]
    {
        file[key] = Value::Array(list);
    }
    file.to_string().into_bytes()
}

fn material(texture: Option<usize>, color: [f32; 4], alpha: &str) -> Value {
    let mut pbr = json!({ "baseColorFactor": color, "metallicFactor": 0, "roughnessFactor": 0.8 });
    if let Some(texture) = texture {
        pbr["baseColorTexture"] = json!({ "index": texture });
    }
    json!({ "pbrMetallicRoughness": pbr, "alphaMode": alpha, "doubleSided": alpha != "OPAQUE" })
}

/// Corners of the twelve triangles of a cuboid: positions, normals, texture coordinates.
fn corners(half: [f32; 3]) -> [Vec<f32>; 3] {
    let [mut places, mut normals, mut coordinates] = [const { Vec::new() }; 3];
    for face in 0..6 {
        let (axis, side) = (face / 2, if face % 2 == 0 { 1.0_f32 } else { -1.0 });
        // Directions across and up, so that across × up is the normal.
        let (across, up) = ((axis + 1) % 3, (axis + 2) % 3);
        for (s, t) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        {
            let (mut place, mut normal) = ([0.0; 3], [0.0; 3]);
            normal[axis] = side;
            place[axis] = side * half[axis];
            place[across] = s * side * half[across];
            place[up] = t * half[up];
            places.extend(place);
            normals.extend(normal);
            coordinates.extend([0.5 + 0.5 * s, 0.5 - 0.5 * t]);
        }
    }
    [places, normals, coordinates]
}
