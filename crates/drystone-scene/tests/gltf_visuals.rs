//! Visuals of glTF files: meshes, materials, images. Broken ones are noted, and never stop a file
//! from being simulated.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use drystone::{Vec3, vec3};
use drystone_scene::gltf::{self, LoadedGltf, Options};
use drystone_scene::visual::{Alpha, Wrap};
use serde_json::{Value, json};

fn uri(kind: &str, bytes: &[u8]) -> String {
    format!("data:{kind};base64,{}", STANDARD.encode(bytes))
}

/// A PNG of these points, red, green, blue, opacity.
fn png_of(width: u32, height: u32, rgba: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.write_header().unwrap().write_image_data(rgba).unwrap();
    bytes
}

/// A JPEG of 8x8 points of one orange.
const JPEG: &str = include_str!("data/orange.jpg.base64");

/// A square that faces +z, with texture coordinates and colors, on a body.
fn square() -> Value {
    let mut bytes = Vec::new();
    let mut put = |numbers: &[f32]| {
        bytes.extend(numbers.iter().flat_map(|x| x.to_le_bytes()));
    };
    put(&[-1.0, -1.0, 0.0, 1.0, -1.0, 0.0, 1.0, 1.0, 0.0, -1.0, 1.0, 0.0]);
    put(&[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
    bytes.extend([255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 255]);
    bytes.extend([0, 1, 2, 0, 2, 3]);
    let image = png_of(2, 1, &[255, 0, 0, 255, 0, 0, 255, 128]);
    json!({
        "asset": {"version": "2.0"},
        "scene": 0, "scenes": [{"nodes": [0]}],
        "buffers": [{"byteLength": bytes.len(), "uri": uri("application/octet-stream", &bytes)}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 32},
            {"buffer": 0, "byteOffset": 80, "byteLength": 16},
            {"buffer": 0, "byteOffset": 96, "byteLength": 6},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 2, "componentType": 5121, "normalized": true, "count": 4, "type": "VEC4"},
            {"bufferView": 3, "componentType": 5121, "count": 6, "type": "SCALAR"},
        ],
        "images": [{"uri": uri("image/png", &image)}],
        "samplers": [{"wrapS": 33071, "wrapT": 33648, "magFilter": 9728}],
        "textures": [{"source": 0, "sampler": 0}],
        "materials": [{
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.5, 1.0, 1.0, 1.0], "baseColorTexture": {"index": 0},
                "metallicFactor": 0.25, "roughnessFactor": 0.75,
            },
            "normalTexture": {"index": 0, "scale": 0.5}, "occlusionTexture": {"index": 0, "strength": 0.75},
            "emissiveFactor": [0.0, 0.5, 0.0], "alphaMode": "MASK", "alphaCutoff": 0.25, "doubleSided": true,
        }],
        "meshes": [{"primitives": [{
            "attributes": {"POSITION": 0, "TEXCOORD_0": 1, "COLOR_0": 2}, "indices": 3, "material": 0,
        }]}],
        "nodes": [{"mesh": 0, "extensions": {"KHR_physics_rigid_bodies": {
            "motion": {}, "collider": {"geometry": {"shape": 0}},
        }}}],
        "extensionsUsed": ["KHR_implicit_shapes", "KHR_physics_rigid_bodies"],
        "extensions": {
            "KHR_implicit_shapes": {"shapes": [{"type": "box", "box": {"size": [2, 2, 0.5]}}]},
            "KHR_physics_rigid_bodies": {},
        },
    })
}

/// Adds to a list of the file.
fn push(file: &mut Value, list: &str, item: Value) {
    file[list].as_array_mut().unwrap().push(item);
}

fn read(file: &Value) -> LoadedGltf {
    let bytes = serde_json::to_vec(file).unwrap();
    let mut loaded =
        gltf::from_slice(&bytes, "square.gltf", Path::new(""), &Options::default()).unwrap();
    loaded.read_visuals();
    loaded
}

fn close(a: &[f32], b: &[f32]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1.0e-6)
}

#[test]
fn a_square_is_read_with_all_that_makes_its_look() {
    let loaded = read(&square());
    assert!(loaded.scene.notes.is_empty(), "{:?}", loaded.scene.notes);
    let visuals = &loaded.scene.visuals;
    assert_eq!((visuals.of(0).len(), visuals.scenery.len()), (1, 0));
    let mesh = &visuals.meshes[visuals.of(0)[0].mesh];
    // Without normals each of the two triangles has corners of its own, which face as it does.
    assert_eq!((mesh.vertices.len(), mesh.indices.len()), (6, 6));
    assert!(mesh.vertices.iter().all(|v| close(&v.normal, &[0.0, 0.0, 1.0])));
    assert!(close(&mesh.vertices[1].uv, &[1.0, 1.0]));
    assert!(close(&mesh.vertices[1].color, &[0.0, 1.0, 0.0, 1.0]));
    let material = &visuals.materials[mesh.material.unwrap()];
    assert!(close(&material.base_color, &[0.5, 1.0, 1.0, 1.0]));
    assert!(close(&[material.metallic, material.roughness], &[0.25, 0.75]));
    assert!(close(&material.emissive, &[0.0, 0.5, 0.0]) && material.double_sided);
    assert_eq!(material.alpha, Alpha::Mask(0.25));
    assert!(close(&[material.normal_scale, material.occlusion_strength], &[0.5, 0.75]));
    assert_eq!(material.normal_texture, material.base_texture);
    assert_eq!(material.occlusion_texture, material.base_texture);
    let texture = material.base_texture.unwrap();
    assert_eq!((texture.wrap, texture.nearest), ([Wrap::Clamp, Wrap::Mirror], true));
    let image = &visuals.images[texture.image];
    assert_eq!((image.width, image.height), (2, 1));
    assert_eq!(image.rgba, [255, 0, 0, 255, 0, 0, 255, 128]);
}

#[test]
fn images_are_found_in_buffers_and_beside_the_file_as_jpeg_too() {
    let mut file = square();
    file["images"][0] = json!({"bufferView": 4});
    let png = png_of(1, 1, &[9, 8, 7, 255]);
    push(&mut file, "bufferViews", json!({"buffer": 1, "byteLength": png.len()}));
    push(&mut file, "buffers", json!({"byteLength": png.len(), "uri": uri("a/b", &png)}));
    assert_eq!(read(&file).scene.visuals.images[0].rgba, [9, 8, 7, 255]);

    let folder = std::env::temp_dir().join(format!("drystone-images-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let jpeg = STANDARD.decode(JPEG.trim()).unwrap();
    std::fs::write(folder.join("an orange.jpg"), jpeg).unwrap();
    let mut file = square();
    file["images"][0] = json!({"uri": "an%20orange.jpg"});
    std::fs::write(folder.join("a.gltf"), serde_json::to_vec(&file).unwrap()).unwrap();
    let mut loaded = gltf::load(&folder.join("a.gltf"), &Options::default()).unwrap();
    loaded.read_visuals();
    std::fs::remove_dir_all(&folder).unwrap();
    let image = &loaded.scene.visuals.images[0];
    assert_eq!((image.width, image.height), (8, 8));
    // The color was written as (255, 165, 0); JPEG keeps flat colors to some steps of its finest
    // table.
    let near = |p: &[u8]| p[0] > 249 && p[1].abs_diff(165) < 6 && p[2] < 6 && p[3] == 255;
    assert!(image.rgba.chunks(4).all(near), "{:?}", &image.rgba[..4]);
}

#[test]
fn what_is_broken_is_told_and_left_out() {
    type Break = fn(&mut Value);
    let cut = png_of(64, 64, &[77; 4 * 64 * 64]);
    let cut = uri("image/png", &cut[..cut.len() / 2]);
    let cases: [(&str, Break); 14] = [
        ("occlusionTexture: not drawn: it has texture coordinates of its own", |f| {
            f["materials"][0]["occlusionTexture"]["texCoord"] = json!(1);
        }),
        ("normalTexture.scale", |f| f["materials"][0]["normalTexture"]["scale"] = json!("much")),
        ("neither a PNG nor a JPEG", |f| {
            f["images"][0]["uri"] = json!("data:image/png;base64,AAAA");
        }),
        ("broken base64", |f| f["images"][0]["uri"] = json!("data:image/png;base64,A?")),
        ("no-such.png", |f| f["images"][0]["uri"] = json!("no-such.png")),
        ("bufferView", |f| f["images"][0] = json!({"bufferView": 77})),
        ("textures", |f| {
            f["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = json!(9);
        }),
        ("10497", |f| f["samplers"][0]["wrapS"] = json!(1)),
        ("materials", |f| f["meshes"][0]["primitives"][0]["material"] = json!(4)),
        ("alphaMode", |f| f["materials"][0]["alphaMode"] = json!("SOMETIMES")),
        ("do not fit", |f| f["accessors"][1]["count"] = json!(1000)),
        ("VEC2", |f| f["accessors"][1]["type"] = json!("VEC9")),
        ("one a vertex", |f| f["accessors"][2]["count"] = json!(2)),
        ("not drawn", |f| f["meshes"][0]["primitives"][0]["mode"] = json!(1)),
    ];
    for (says, damage) in cases {
        let mut file = square();
        damage(&mut file);
        let loaded = read(&file);
        let notes = &loaded.scene.notes;
        assert!(notes.iter().any(|note| note.contains(says)), "{says}: {notes:?}");
        assert_eq!(loaded.scene.bodies.len(), 1);
    }
    let mut file = square();
    file["images"][0]["uri"] = json!(cut);
    let loaded = read(&file);
    assert!(loaded.scene.notes[0].contains("broken PNG"), "{:?}", loaded.scene.notes);
    assert!(loaded.scene.visuals.materials[0].base_texture.is_none());
    assert_eq!(loaded.scene.visuals.of(0).len(), 1, "drawn without the image");
}

#[test]
fn meshes_follow_the_body_above_them_and_others_stand() {
    let mut file = square();
    let turned =
        json!([0.0, 0.0, std::f32::consts::FRAC_1_SQRT_2, std::f32::consts::FRAC_1_SQRT_2]);
    file["nodes"][0]["children"] = json!([1]);
    file["nodes"][0]["translation"] = json!([5, 0, 0]);
    push(&mut file, "nodes", json!({"mesh": 0, "translation": [0, 2, 0], "rotation": turned}));
    push(&mut file, "nodes", json!({"mesh": 0, "translation": [0, 0, -4], "scale": [-2, 1, 1]}));
    push(
        &mut file,
        "nodes",
        json!({"mesh": 0, "extensions": {"KHR_node_visibility": {"visible": false}}}),
    );
    file["scenes"][0]["nodes"] = json!([0, 2, 3]);
    let loaded = read(&file);
    let visuals = &loaded.scene.visuals;
    assert_eq!((visuals.of(0).len(), visuals.scenery.len()), (2, 1));
    let below = visuals.of(0)[1].pose;
    assert!((below.position - vec3(0.0, 2.0, 0.0)).length() < 1.0e-6);
    assert!((below.rotation.rotate(Vec3::X) - Vec3::Y).length() < 1.0e-6);
    // The same mesh where it is stretched the same.
    assert_eq!(visuals.of(0)[0].mesh, visuals.of(0)[1].mesh);
    let mirrored = &visuals.meshes[visuals.scenery[0].mesh];
    assert!(mirrored.vertices.iter().all(|v| v.normal[2] > 0.99), "its front stays in front");
    let corner = |i: u32| Vec3::from(mirrored.vertices[i as usize].place);
    let [a, b, c] = [0, 1, 2].map(|i| corner(mirrored.indices[i]));
    assert!((b - a).cross(c - a).z > 0.0 && a.x.abs() > 1.9);
}
