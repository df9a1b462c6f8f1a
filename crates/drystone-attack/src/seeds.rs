//! Small files in formats that the test data lacks, and functions for lengths and checksums of
//! formats.

use std::io;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// Writes them into a folder; returns for each the file to damage and the file to load.
///
/// # Errors
/// Fails if a file cannot be written.
pub fn write(folder: &Path) -> io::Result<Vec<(String, String)>> {
    let png = png();
    let jpeg = STANDARD.decode(JPEG).unwrap_or_default();
    let put = |name: &str, bytes: &[u8]| std::fs::write(folder.join(name), bytes);
    put("image.png", &png)?;
    put("image.jpg", &jpeg)?;
    put("binary.stl", &binary_stl())?;
    put("text.stl", text_stl().as_bytes())?;
    put("part.obj", PART.as_bytes())?;
    put("inside.gltf", shown(&data("image/png", &png), &data("image/jpeg", &jpeg)).as_bytes())?;
    put("beside.gltf", shown("image.png", "image.jpg").as_bytes())?;
    put("robot.urdf", robot("binary.stl", "part.obj").as_bytes())?;
    put("robot-text.urdf", robot("text.stl", "part.obj").as_bytes())?;
    put("model.xml", MODEL.as_bytes())?;
    put("whole.json", OWN.as_bytes())?;
    put("part.json", PART_OF_OWN.as_bytes())?;
    let pairs = [
        ("inside.gltf", "inside.gltf"),
        ("image.png", "beside.gltf"),
        ("image.jpg", "beside.gltf"),
        ("binary.stl", "robot.urdf"),
        ("part.obj", "robot.urdf"),
        ("text.stl", "robot-text.urdf"),
        ("binary.stl", "model.xml"),
        ("whole.json", "whole.json"),
        ("part.json", "whole.json"),
        ("binary.stl", "whole.json"),
        ("robot.urdf", "whole.json"),
    ];
    Ok(pairs.map(|(a, b)| (a.to_owned(), b.to_owned())).to_vec())
}

fn data(kind: &str, bytes: &[u8]) -> String {
    format!("data:{kind};base64,{}", STANDARD.encode(bytes))
}

/// A small PNG image.
fn png() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 4, 4);
    encoder.set_color(png::ColorType::Rgba);
    let points: Vec<u8> = (0..64_u8).map(|i| i.wrapping_mul(37)).collect();
    let written = encoder.write_header().and_then(|mut w| w.write_image_data(&points));
    debug_assert!(written.is_ok(), "a list takes all bytes");
    bytes
}

/// 8 × 8 pixels of one gray.
const JPEG: &str = "/9j/4AAQSkZJRgABAQEASABIAAD/2wBDAAEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQH/wAALCAAIAAgBAREA/8QAFAABAAAAAAAAAAAAAAAAAAAACf/EABQQAQAAAAAAAAAAAAAAAAAAAAD/2gAIAQEAAD8AVN//2Q==";

/// glTF: a textured square on a falling body.
fn shown(first: &str, second: &str) -> String {
    let mut bytes: Vec<u8> = Vec::new();
    let mut put = |numbers: &[f32]| bytes.extend(numbers.iter().flat_map(|x| x.to_le_bytes()));
    put(&[-1.0, -1.0, 0.0, 1.0, -1.0, 0.0, 1.0, 1.0, 0.0, -1.0, 1.0, 0.0]);
    put(&[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
    bytes.extend([0, 1, 2, 0, 2, 3]);
    let buffer = data("application/octet-stream", &bytes);
    format!(
        r#"{{"asset": {{"version": "2.0"}},
"extensionsUsed": ["KHR_implicit_shapes", "KHR_physics_rigid_bodies"],
"extensions": {{"KHR_implicit_shapes": {{"shapes": [{{"type": "box", "box": {{"size": [2.0, 2.0, 0.2]}}}}]}}}},
"scene": 0, "scenes": [{{"nodes": [0, 1]}}],
"nodes": [
 {{"mesh": 0, "translation": [0, 3, 0], "extensions": {{"KHR_physics_rigid_bodies": {{
  "motion": {{"mass": 2.0}}, "collider": {{"geometry": {{"shape": 0}}}}}}}}}},
 {{"mesh": 0, "rotation": [-0.7071068, 0, 0, 0.7071068], "extensions": {{"KHR_physics_rigid_bodies": {{
  "collider": {{"geometry": {{"mesh": 0}}}}}}}}}}],
"meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0, "TEXCOORD_0": 1}}, "indices": 2, "material": 0}}]}}],
"materials": [{{"pbrMetallicRoughness": {{"baseColorTexture": {{"index": 0}}, "metallicFactor": 0.5,
  "metallicRoughnessTexture": {{"index": 1}}}}, "emissiveFactor": [0.1, 0.2, 0.3], "doubleSided": true}}],
"textures": [{{"source": 0, "sampler": 0}}, {{"source": 1}}],
"samplers": [{{"wrapS": 33071, "wrapT": 33648}}],
"images": [{{"uri": "{first}"}}, {{"uri": "{second}"}}],
"buffers": [{{"byteLength": {length}, "uri": "{buffer}"}}],
"bufferViews": [{{"buffer": 0, "byteLength": 48}}, {{"buffer": 0, "byteOffset": 48, "byteLength": 32}},
 {{"buffer": 0, "byteOffset": 80, "byteLength": 6}}],
"accessors": [
 {{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, -1, 0], "max": [1, 1, 0]}},
 {{"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"}},
 {{"bufferView": 2, "componentType": 5121, "count": 6, "type": "SCALAR"}}]}}"#,
        length = bytes.len()
    )
}

/// Corners and faces of a tetrahedron.
const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [0.2, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, 0.2]];
const FACES: [[usize; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

fn binary_stl() -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend(4_u32.to_le_bytes());
    for face in FACES {
        bytes.extend([0; 12]);
        for corner in face {
            bytes.extend(CORNERS[corner].iter().flat_map(|x| x.to_le_bytes()));
        }
        bytes.extend([0; 2]);
    }
    bytes
}

fn text_stl() -> String {
    let mut text = "solid part\n".to_owned();
    for face in FACES {
        text.push_str(" facet normal 0 0 0\n  outer loop\n");
        for corner in face {
            let [x, y, z] = CORNERS[corner];
            text.push_str(&format!("   vertex {x} {y} {z}\n"));
        }
        text.push_str("  endloop\n endfacet\n");
    }
    text.push_str("endsolid part\n");
    text
}

const PART: &str = "o part\nv 0 0 0\nv 0.2 0 0\nv 0 0.2 0\nv 0 0 0.2\nvt 0 0\nvn 0 0 1\n\
f 1/1/1 3/1/1 2/1/1\nf 1 2 4\nf 2 3 4\nf -2 -4 -1\n";

/// A robot of two links and a joint, with shapes in separate files.
fn robot(first: &str, second: &str) -> String {
    format!(
        r#"<robot name="pair">
 <link name="base">
  <inertial><mass value="2"/><origin xyz="0 0 0.1"/><inertia ixx="0.02" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><origin xyz="0 0 0.05" rpy="0 0 0.3"/><geometry><mesh filename="{first}" scale="1 1 1"/></geometry></collision>
 </link>
 <link name="arm">
  <inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><geometry><mesh filename="{second}"/></geometry></collision>
  <collision><origin xyz="0.3 0 0"/><geometry><cylinder radius="0.05" length="0.4"/></geometry></collision>
 </link>
 <joint name="shoulder" type="revolute">
  <parent link="base"/><child link="arm"/><origin xyz="0 0 0.3" rpy="0 1.57 0"/><axis xyz="0 1 0"/>
  <limit lower="-1.5" upper="1.5" effort="20" velocity="3"/><dynamics damping="0.1" friction="0.05"/>
 </joint>
</robot>
"#
    )
}

/// A MuJoCo model with a mesh, joints of several kinds, a coupling, a tendon and motors.
const MODEL: &str = r#"<mujoco model="small">
 <compiler angle="radian"/>
 <option timestep="0.005" gravity="0 0 -9.81"/>
 <default><geom friction="0.8 0.005 0.0001" density="900"/><joint damping="0.1" armature="0.01"/></default>
 <asset><mesh name="part" file="binary.stl" scale="1 1 1"/></asset>
 <worldbody>
  <geom name="floor" type="plane" size="5 5 0.1"/>
  <body name="trunk" pos="0 0 1">
   <freejoint/>
   <geom type="capsule" fromto="0 0 0 0 0 0.4" size="0.1"/>
   <site name="top" pos="0 0 0.4"/>
   <body name="arm" pos="0.2 0 0.4" euler="0 0.3 0">
    <joint name="elbow" type="hinge" axis="0 1 0" range="-1 1" limited="true" stiffness="1"/>
    <geom type="mesh" mesh="part"/>
    <body name="hand" pos="0.3 0 0">
     <joint name="reach" type="slide" axis="1 0 0" range="0 0.2" limited="true"/>
     <geom type="box" size="0.05 0.05 0.05"/>
     <site name="tip" pos="0.05 0 0"/>
    </body>
   </body>
   <body name="ball" pos="-0.3 0 0.2"><joint type="ball"/><geom type="ellipsoid" size="0.1 0.1 0.1"/></body>
  </body>
 </worldbody>
 <tendon><spatial name="cable" range="0 2" limited="true"><site site="top"/><site site="tip"/></spatial></tendon>
 <equality><joint joint1="elbow" joint2="reach" polycoef="0 2 0 0 0"/></equality>
 <actuator><motor joint="elbow" gear="2"/><position joint="reach" kp="50"/></actuator>
</mujoco>
"#;

/// A scene in drystone's format with most kinds of objects, meshes in files, and other scenes as
/// parts.
const OWN: &str = r#"{"drystone": 1, "hz": 60, "seconds": 1,
"world": {"gravity": [0, -9.81, 0], "method": {"name": "soft-step", "shock": "off"}, "contact": {"margin": 0.01}, "sleep": {"time": 0.4}},
"layers": ["default", "ghosts"],
"materials": {"rubber": {"friction": 0.9, "restitution": 0.5, "friction_combine": "average"}},
"shapes": {"gem": {"hull": {"points": [[0.1, 0, 0], [-0.1, 0, 0], [0, 0.2, 0], [0, 0, 0.1], [0, -0.1, -0.1]]}}, "stone": {"hull": {"file": "text.stl", "scale": [1, 2, 1]}}},
"bodies": [
 {"name": "ground", "kind": "static", "shapes": [{"half_space": {"normal": [0, 1, 0], "offset": 0}}, {"mesh": {"file": "binary.stl"}, "position": [3, 0, 0]}]},
 {"name": "box", "position": [0, 1, 0], "rotation": {"axis": [0, 0, 1], "degrees": 20}, "mass": 2, "linear_damping": 0.1, "locks": ["turn_y"],
  "shapes": [{"box": {"half_extents": [0.2, 0.3, 0.4]}, "density": 500, "material": "rubber", "filter": {"layers": ["default", 7], "exclude": ["ghosts"]}}]},
 {"name": "pieces", "position": [1, 1, 0], "shapes": [{"hulls": {"file": "part.obj"}}, {"shape": "gem", "position": [0, 0.2, 0]}]},
 {"name": "beam", "position": [0, 3, 0], "glue": {"strength": {"tension": 200000, "shear": "inf"}},
  "shapes": [{"box": {"half_extents": [0.5, 0.1, 0.1]}, "position": [-0.5, 0, 0]}, {"box": {"half_extents": [0.5, 0.1, 0.1]}, "position": [0.5, 0, 0]}]},
 {"name": "pane", "position": [2, 2, 0], "fracture": {"impulse": 3, "pieces": 5, "seed": 7}, "shapes": [{"box": {"half_extents": [0.3, 0.3, 0.05]}, "reports": {"forces": true}}]},
 {"name": "wheel", "position": [0, 1, 2], "mass": {"mass": 1, "center": [0, 0, 0], "inertia": [0.1, 0.2, 0.1, 0, 0, 0]}, "shapes": [{"cylinder": {"half_height": 0.1, "radius": 0.3}, "surface_spin": [0, 1, 0]}]},
 {"name": "lift", "kind": "kinematic", "position": [-2, 0, 0], "linear_velocity": [0, 1, 0], "shapes": [{"capsule": {"half_height": 0.2, "radius": 0.1}, "one_way": [0, 1, 0]}, {"cone": {"half_height": 0.2, "radius_bottom": 0.1}, "sensor": true}]}],
"parts": [{"file": "part.json", "name": "left", "position": [5, 0, 0]}, {"file": "robot.urdf", "name": "robot", "position": [0, 0, 6], "rotation": [-0.7071068, 0, 0, 0.7071068], "base": "floating"}],
"joints": [
 {"name": "hinge", "body_a": "ground", "body_b": "box", "at": [0, 1.3, 0], "axis": [0, 0, 1], "hinge": {"limits": [-1, 1], "motor": {"speed": 1, "max_force": 20}}, "strength": {"force": 500}},
 {"name": "rail", "body_a": "ground", "body_b": "pieces", "at": [1, 1, 0], "axes": [[1, 0, 0], [0, 1, 0]], "slider": {"drive": {"position": 0.2, "spring": {"hertz": 2}}, "friction": 1}},
 {"body_a": "box", "body_b": "wheel", "anchor_a": [0, 0, 0.4], "six_dof": {"turn_x": {}, "turn_y": {"limits": [-1, "inf"]}, "x": {"limits": [-0.1, 0.1], "limit_spring": {"stiffness": 50, "damping": 1}}}},
 {"body_a": "lift", "body_b": "pane", "between": [[-2, 0, 0], [2, 2, 0]], "spring": {"rest_length": 3, "hertz": 1, "damping_ratio": 0.2}}],
"couplings": [{"joint_a": "hinge", "axis_a": "turn_x", "joint_b": "rail", "axis_b": "x", "ratio": 0.5, "offset": 0}],
"strands": [{"name": "rope", "rope": {"from": [0, 3, 3], "to": [1, 3, 3], "links": 8, "pinned": [true, false]}, "holds": [{"particle": 8, "body": "wheel", "point": [0, 0.1, 0]}]},
 {"cloth": {"corner": [0, 2, 4], "sides": [[1, 0, 0], [0, 0, 1]], "squares": [3, 4], "bend": "none", "tear_force": 30}, "pins": [0, 3]},
 {"cloud": {"points": [[0, 1, 8], [0.1, 1, 8]]}, "links": [{"a": 0, "b": 1, "kind": {"spring": {"stiffness": 10, "damping": 1}}}]}],
"frames": [{"name": "eye", "body": "box", "position": [0, 0.1, 0]}],
"never_collide": [["box", "left/ball"], [1, 2]],
"surface_rules": [{"first": ["ghosts"], "second": [0, 7], "friction": 0.1}],
"script": {"waves": [{"step": 3, "bodies": [{"name": "late", "position": [0, 5, 0], "shapes": [{"sphere": {"radius": 0.1}}]}], "joints": [{"body_a": "late", "body_b": "box", "rope": {"length": 9}}]},
 {"step": 9, "removed": {"first": "pane", "count": 2}}]}}
"#;

/// A part of that scene.
const PART_OF_OWN: &str = r#"{"drystone": 1, "bodies": [
 {"name": "ball", "position": [0, 1, 0], "shapes": [{"sphere": {"radius": 0.3}}]},
 {"name": "post", "kind": "static", "shapes": [{"box": {"half_extents": [0.1, 1, 0.1]}}]}],
"joints": [{"name": "pivot", "body_a": "post", "body_b": "ball", "at": [0, 1, 0], "ball": {"friction": 0.1}}],
"script": {"loads": {"from": 2, "loads": [{"body": "ball", "force": [1, 0, 0]}]}}}
"#;

/// A binary glTF file with this JSON.
#[must_use]
pub fn binary(json: &[u8]) -> Vec<u8> {
    let mut text = json.to_vec();
    text.resize(json.len().next_multiple_of(4), b' ');
    let length = |n: usize| u32::try_from(n).unwrap_or(u32::MAX).to_le_bytes();
    let head = [&b"glTF"[..], &2_u32.to_le_bytes(), &length(text.len() + 20)].concat();
    [&head[..], &length(text.len()), b"JSON", &text].concat()
}

/// The JSON of a binary glTF file with one chunk.
#[must_use]
pub fn text_of(bytes: &[u8]) -> &[u8] {
    bytes.get(20..).unwrap_or_default()
}

/// Corrects the checksums of the chunks of a PNG, as far as their lengths are consistent.
pub fn mend_png(bytes: &mut [u8]) {
    let mut at = 8;
    while let Some(length) = bytes.get(at..).and_then(|rest| rest.first_chunk::<4>()) {
        let end =
            usize::try_from(u32::from_be_bytes(*length)).ok().and_then(|n| (at + 8).checked_add(n));
        let Some(end) = end.filter(|end| *end + 4 <= bytes.len()) else { return };
        let sum = crc32fast::hash(&bytes[at + 4..end]);
        bytes[end..end + 4].copy_from_slice(&sum.to_be_bytes());
        at = end + 4;
    }
}

#[cfg(test)]
mod tests {
    use super::{binary, mend_png, png, text_of};

    #[test]
    fn lengths_and_checksums_are_those_of_the_formats() {
        let file = binary(b"{}");
        assert_eq!((file.len(), text_of(&file)), (24, &b"{}  "[..]));
        let image = png();
        let mut again = image.clone();
        mend_png(&mut again);
        assert_eq!(image, again);
        again[20] ^= 1;
        mend_png(&mut again);
        assert_ne!(image, again);
    }
}
