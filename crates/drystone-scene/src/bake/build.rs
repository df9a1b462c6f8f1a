//! A document for a scene that comes from no file: nodes, meshes, materials, physics.

use drystone::contact::Combine;
use drystone::{BodyDef, BodyKind, Filter, Material, Pose, Quat, Shape, ShapeDef, Vec3, vec3};
use serde_json::{Value, json};

use super::file::{bytes_of, list, place, push};
use super::joints;
use super::physics::{implicit, motion};
use super::solids::{self, Surface};
use crate::gltf::{COMBINE, Document, GEOMETRIC_MEAN, LoadedGltf, STATIC_BODY, read_tree};
use crate::read::json::At;
use crate::read::obj::Object;
use crate::scene::{Scene, SceneBody, SceneJoint};

/// Colors (linear red, green, blue): static, kinematic, trigger, then those of moving bodies by
/// turns.
const COLORS: [[f32; 3]; 9] = [
    [0.32, 0.34, 0.36],
    [0.80, 0.55, 0.10],
    [0.25, 0.65, 0.35],
    [0.78, 0.23, 0.16],
    [0.12, 0.38, 0.62],
    [0.86, 0.62, 0.24],
    [0.20, 0.52, 0.46],
    [0.55, 0.28, 0.48],
    [0.72, 0.68, 0.60],
];
const MOVING: usize = 3;
const PHYSICS: &str = "KHR_physics_rigid_bodies";

/// A document under construction.
struct Build {
    json: Value,
    /// The bytes of buffer `buffer`.
    bytes: Vec<u8>,
    buffer: usize,
    /// Number of the first of [`COLORS`] among the document's materials.
    first_color: usize,
    /// Meshes by shape and color, with their numbers.
    meshes: Vec<(ShapeKey, usize, usize)>,
    implicit: Vec<Value>,
    materials: Vec<Material>,
    filters: Vec<Filter>,
    joints: Vec<Value>,
    /// Some shape has a filter: then each says its own, for a collider without is in no system.
    filtered: bool,
}

/// Two shapes with equal keys look the same.
#[derive(Clone, Debug, PartialEq)]
struct ShapeKey(&'static str, [u32; 3], usize);

fn shape_key(shape: &Shape) -> ShapeKey {
    let (numbers, identity) = match shape {
        Shape::Sphere { radius } => ([*radius, 0.0, 0.0], 0),
        Shape::Capsule { half_height, radius } | Shape::Cylinder { half_height, radius } => {
            ([*half_height, *radius, 0.0], 0)
        }
        Shape::Box { half_extents } => (half_extents.to_array(), 0),
        Shape::Cone { half_height, radius_bottom, radius_top } => {
            ([*half_height, *radius_bottom, *radius_top], 0)
        }
        Shape::Hull(hull) => ([0.0; 3], std::sync::Arc::as_ptr(hull) as usize),
        Shape::Mesh(mesh) => ([0.0; 3], std::sync::Arc::as_ptr(mesh) as usize),
        _ => ([0.0; 3], 0),
    };
    ShapeKey(shape.kind(), numbers.map(f32::to_bits), identity)
}

/// The document of a scene and the node of each of its bodies, then of those that its script
/// brings, then of the pieces.
pub(super) fn document(scene: &Scene, pieces: &[SceneBody]) -> (Document, Vec<usize>) {
    let mut build = Build::new(&scene.name);
    build.json["asset"]["extras"]["gravity"] = json!(scene.config.gravity.to_array());
    let bodies = || scene.bodies.iter().chain(scene.script.joining());
    let mut shapes = bodies().flat_map(|b| &b.def.shapes);
    build.filtered = shapes.any(|s| s.filter != Filter::default());
    let mut nodes: Vec<usize> = bodies().enumerate().map(|(i, b)| build.body(b, i)).collect();
    // Physics that is read back must not have them beside the bodies that they were parts of.
    let physical = list(&mut build.json, "nodes").len();
    for piece in pieces {
        nodes.push(build.body(piece, nodes.len()));
    }
    for node in &mut list(&mut build.json, "nodes")[physical..] {
        if let Some(node) = node.as_object_mut() {
            node.remove("extensions");
        }
    }
    build.json["scenes"][0]["nodes"] = json!(nodes);
    build.finish();
    let buffers = vec![build.bytes];
    (Document { json: build.json, buffers, ..Document::default() }, nodes)
}

/// The document of a scene without what its script brings, with its joints.
pub(super) fn physics(scene: &Scene) -> Document {
    let mut build = Build::new(&scene.name);
    build.json["asset"]["extras"]["gravity"] = json!(scene.config.gravity.to_array());
    let mut shapes = scene.bodies.iter().flat_map(|b| &b.def.shapes);
    build.filtered = shapes.any(|s| s.filter != Filter::default());
    let bodies = scene.bodies.iter().enumerate();
    let nodes: Vec<usize> = bodies.map(|(i, b)| build.body(b, i)).collect();
    for joint in &scene.joints {
        build.joint(joint, &nodes);
    }
    // A scale that is said is read without rounding; that of a turned node without one comes from
    // its matrix.
    for node in list(&mut build.json, "nodes") {
        if node.get("rotation").is_some() {
            node["scale"] = json!([1.0, 1.0, 1.0]);
        }
    }
    let default = Scene::new("", "");
    let times = [("hz", scene.hz, default.hz), ("seconds", scene.seconds, default.seconds)];
    for (key, value, default) in times {
        if value.to_bits() != default.to_bits() {
            build.json["asset"]["extras"]["drystone"][key] = json!(value);
        }
    }
    build.json["scenes"][0]["nodes"] = json!(nodes);
    build.finish();
    Document { json: build.json, buffers: vec![build.bytes], ..Document::default() }
}

/// The color of a shape of body `number`.
fn color(def: &BodyDef, shape: &ShapeDef, number: usize) -> usize {
    match def.kind {
        _ if shape.sensor => 2,
        BodyKind::Static => 0,
        BodyKind::Kinematic => 1,
        BodyKind::Dynamic => MOVING + number % (COLORS.len() - MOVING),
    }
}

/// The document that was read; if it has nothing to look at, with a node for each shape of each
/// body.
pub(super) fn shown(loaded: &LoadedGltf) -> Document {
    let document = &loaded.document;
    let root = At::root(&document.json);
    let nodes = root.list("nodes").unwrap_or_default();
    let Ok(tree) = read_tree(&root) else { return document.clone() };
    if nodes.iter().any(|n| n.get("mesh").is_some()) {
        return document.clone();
    }
    let mut build = Build::on(document.json.clone(), document.buffers.len());
    for (number, (body, &owner)) in loaded.scene.bodies.iter().zip(&loaded.node_of_body).enumerate()
    {
        let scale = tree.nodes[owner].scale;
        for shape in &body.def.shapes {
            let pose = seat(shape);
            let turned = pose.rotation != Quat::IDENTITY;
            let uneven = (scale - Vec3::splat(scale.x)).length() > 1.0e-5;
            if scale.abs().min_element() < 1.0e-6 || (turned && uneven) {
                // The node's own scale would tear the picture apart.
                continue;
            }
            let undo = vec3(1.0 / scale.x, 1.0 / scale.y, 1.0 / scale.z);
            let mesh = build.mesh_of(&shape.shape, color(&body.def, shape, number));
            let mut node = json!({"mesh": mesh});
            place(&mut node, &Pose::new(pose.position.mul_each(undo), pose.rotation));
            if undo != Vec3::ONE {
                node["scale"] = json!(undo.to_array());
            }
            let child = push(&mut build.json, "nodes", node);
            push(&mut list(&mut build.json, "nodes")[owner], "children", json!(child));
        }
    }
    let mut buffers = document.buffers.clone();
    buffers.push(build.bytes);
    Document { json: build.json, buffers, folder: document.folder.clone(), ..Document::default() }
}

/// A document with a node and a mesh for each object of an `.obj` file, and nothing else.
pub(super) fn objects(name: &str, objects: &[Object]) -> Document {
    let mut build = Build::new(name);
    let mut nodes = Vec::new();
    for (i, object) in objects.iter().enumerate() {
        let surface = Surface {
            points: object.surface.points.clone(),
            normals: Vec::new(),
            triangles: object.surface.triangles.clone(),
        };
        let mesh = build.mesh(&surface, MOVING + i % (COLORS.len() - MOVING));
        let mut node = json!({"mesh": mesh});
        if !object.name.is_empty() {
            node["name"] = json!(object.name);
        }
        nodes.push(push(&mut build.json, "nodes", node));
    }
    build.json["scenes"][0]["nodes"] = json!(nodes);
    Document { json: build.json, buffers: vec![build.bytes], ..Document::default() }
}

impl Build {
    /// A document with an empty scene and the materials.
    fn new(name: &str) -> Self {
        let json = json!({
            "asset": {"version": "2.0", "generator": "drystone", "extras": {"name": name}},
            "scene": 0, "scenes": [{"nodes": []}],
        });
        Self::on(json, 0)
    }

    /// Adds to a document that has `buffers` buffers.
    fn on(json: Value, buffers: usize) -> Self {
        let mut build = Self {
            json,
            bytes: Vec::new(),
            buffer: buffers,
            first_color: 0,
            meshes: Vec::new(),
            implicit: Vec::new(),
            materials: Vec::new(),
            filters: Vec::new(),
            joints: Vec::new(),
            filtered: false,
        };
        build.first_color = list(&mut build.json, "materials").len();
        for (i, rgb) in COLORS.iter().enumerate() {
            let [r, g, b] = *rgb;
            let (alpha, mode) = if i == 2 { (0.3, "BLEND") } else { (1.0, "OPAQUE") };
            let color = json!({
                "pbrMetallicRoughness": {
                    "baseColorFactor": [r, g, b, alpha], "metallicFactor": 0.0, "roughnessFactor": 0.7,
                },
                "alphaMode": mode, "doubleSided": i == 0,
            });
            push(&mut build.json, "materials", color);
        }
        build
    }

    /// The node of a body with all below it.
    fn body(&mut self, body: &SceneBody, number: usize) -> usize {
        let def = &body.def;
        let mut node = json!({"name": body.name});
        place(&mut node, &Pose::new(def.position, def.rotation));
        let mut physics = json!({});
        if def.kind != BodyKind::Static {
            physics["motion"] = motion(def);
        }
        let mut children = Vec::new();
        let single = def.shapes.len() == 1;
        for shape in &def.shapes {
            let pose = seat(shape);
            if single && pose == Pose::IDENTITY {
                self.shape(&mut node, &mut physics, shape, color(def, shape, number));
                continue;
            }
            let mut child = json!({});
            place(&mut child, &pose);
            let mut own = json!({});
            self.shape(&mut child, &mut own, shape, color(def, shape, number));
            child["extensions"] = json!({PHYSICS: own});
            children.push(push(&mut self.json, "nodes", child));
        }
        if !children.is_empty() {
            if def.kind == BodyKind::Static {
                node["extras"] = json!({STATIC_BODY: true});
            }
            node["children"] = json!(children);
        }
        if physics.as_object().is_some_and(|p| !p.is_empty()) {
            node["extensions"] = json!({PHYSICS: physics});
        }
        push(&mut self.json, "nodes", node)
    }

    /// The two nodes of a joint, below the nodes of its bodies.
    fn joint(&mut self, joint: &SceneJoint, nodes: &[usize]) {
        let written = joints::written(&joint.kind);
        let ends = nodes.get(joint.body_a).zip(nodes.get(joint.body_b));
        let (Some(description), Some((&a, &b))) = (written.description, ends) else { return };
        let found = self.joints.iter().position(|known| *known == description);
        let index = found.unwrap_or(self.joints.len());
        if found.is_none() {
            self.joints.push(description);
        }
        let [frame_a, frame_b] = written.frames;
        let other = joints::end(&Pose::new(joint.anchor_b, frame_b));
        let other = push(&mut self.json, "nodes", other);
        let mut own = joints::end(&Pose::new(joint.anchor_a, frame_a));
        if !joint.name.is_empty() {
            own["name"] = json!(joint.name);
        }
        let mut said = json!({"connectedNode": other, "joint": index});
        if joint.collide_connected {
            said["enableCollision"] = json!(true);
        }
        own["extensions"] = json!({PHYSICS: {"joint": said}});
        let own = push(&mut self.json, "nodes", own);
        for (body, end) in [(a, own), (b, other)] {
            let node = &mut list(&mut self.json, "nodes")[body];
            push(node, "children", json!(end));
        }
    }

    /// Mesh and collider of one shape.
    fn shape(&mut self, node: &mut Value, physics: &mut Value, shape: &ShapeDef, color: usize) {
        let mesh = self.mesh_of(&shape.shape, color);
        node["mesh"] = json!(mesh);
        let geometry = match implicit(&shape.shape) {
            Some(description) => {
                let found = self.implicit.iter().position(|s| *s == description);
                let index = found.unwrap_or(self.implicit.len());
                if found.is_none() {
                    self.implicit.push(description);
                }
                json!({"shape": index})
            }
            None => json!({"mesh": mesh, "convexHull": matches!(shape.shape, Shape::Hull(_))}),
        };
        let mut part = json!({"geometry": geometry});
        if self.filtered {
            part["collisionFilter"] = json!(index_of(&mut self.filters, shape.filter));
        }
        if shape.sensor {
            physics["trigger"] = part;
        } else {
            part["physicsMaterial"] = json!(index_of(&mut self.materials, shape.material));
            physics["collider"] = part;
        }
    }

    /// The mesh that shows a shape in a color.
    fn mesh_of(&mut self, shape: &Shape, color: usize) -> usize {
        let key = shape_key(shape);
        if let Some((_, _, mesh)) = self.meshes.iter().find(|(k, c, _)| *k == key && *c == color) {
            return *mesh;
        }
        let mesh = self.mesh(&solids::of(shape), color);
        self.meshes.push((key, color, mesh));
        mesh
    }

    fn mesh(&mut self, surface: &Surface, color: usize) -> usize {
        let numbers =
            |v: &[Vec3]| bytes_of(&v.iter().flat_map(|p| p.to_array()).collect::<Vec<_>>());
        let low = surface.points.iter().fold(Vec3::splat(f32::MAX), |l, p| l.min(*p));
        let high = surface.points.iter().fold(Vec3::splat(f32::MIN), |h, p| h.max(*p));
        let view = self.view(&numbers(&surface.points), 34962);
        let count = surface.points.len();
        let position = json!({
            "bufferView": view, "componentType": 5126, "count": count, "type": "VEC3",
            "min": low.to_array(), "max": high.to_array(),
        });
        let position = push(&mut self.json, "accessors", position);
        let mut attributes = json!({"POSITION": position});
        if !surface.normals.is_empty() {
            let view = self.view(&numbers(&surface.normals), 34962);
            let normal =
                json!({"bufferView": view, "componentType": 5126, "count": count, "type": "VEC3"});
            attributes["NORMAL"] = json!(push(&mut self.json, "accessors", normal));
        }
        let corners: Vec<u32> = surface.triangles.iter().flatten().copied().collect();
        // 65535 itself would be a restart of the strip.
        let short = count < 65535;
        let bytes: Vec<u8> = if short {
            corners.iter().flat_map(|&c| u16::try_from(c).unwrap_or(0).to_le_bytes()).collect()
        } else {
            corners.iter().flat_map(|c| c.to_le_bytes()).collect()
        };
        let view = self.view(&bytes, 34963);
        let component = if short { 5123 } else { 5125 };
        let index = json!({"bufferView": view, "componentType": component, "count": corners.len(), "type": "SCALAR"});
        let index = push(&mut self.json, "accessors", index);
        let primitive = json!({"attributes": attributes, "indices": index, "material": self.first_color + color});
        push(&mut self.json, "meshes", json!({"primitives": [primitive]}))
    }

    fn view(&mut self, bytes: &[u8], target: u32) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let view = json!({
            "buffer": self.buffer, "byteOffset": self.bytes.len(), "byteLength": bytes.len(), "target": target,
        });
        self.bytes.extend_from_slice(bytes);
        push(&mut self.json, "bufferViews", view)
    }

    /// The parts of the extensions that stand at the top of the document.
    fn finish(&mut self) {
        let rule = |c: Combine| match c {
            Combine::Multiply => "multiply",
            Combine::Maximum => "maximum",
            Combine::Minimum => "minimum",
            Combine::Average | Combine::GeometricMean => "average",
        };
        let materials = self.materials.iter().map(|m| {
            let mut material = json!({
                "staticFriction": m.friction,
                "dynamicFriction": m.kinetic_friction.unwrap_or(m.friction),
                "restitution": m.restitution,
                "frictionCombine": rule(m.friction_combine),
                "restitutionCombine": rule(m.restitution_combine),
            });
            // The extension has no such rule; this crate's reader recognizes it by this mark.
            let rules = [(COMBINE[0], m.friction_combine), (COMBINE[1], m.restitution_combine)];
            for (key, _) in rules.iter().filter(|(_, rule)| *rule == Combine::GeometricMean) {
                material["extras"][*key] = json!(GEOMETRIC_MEAN);
            }
            material
        });
        let names = |bits: u64| -> Vec<String> {
            (0..64).filter(|b| bits >> b & 1 == 1).map(|b| format!("layer{b}")).collect()
        };
        let filters = self.filters.iter().map(|f| {
            let mut filter = json!({});
            if f.layers != 0 {
                filter["collisionSystems"] = json!(names(f.layers));
            }
            if f.exclude != 0 && f.mask == u64::MAX {
                filter["notCollideWithSystems"] = json!(names(f.exclude));
            } else if f.mask != u64::MAX {
                filter["collideWithSystems"] = json!(names(f.mask & !f.exclude));
            }
            filter
        });
        let (materials, filters): (Vec<Value>, Vec<Value>) =
            (materials.collect(), filters.collect());
        let mut physics = json!({});
        if !materials.is_empty() {
            physics["physicsMaterials"] = json!(materials);
        }
        if !filters.is_empty() {
            physics["collisionFilters"] = json!(filters);
        }
        if !self.joints.is_empty() {
            physics["physicsJoints"] = json!(self.joints);
        }
        let mut used = vec![PHYSICS];
        let mut extensions = json!({PHYSICS: physics});
        if !self.implicit.is_empty() {
            used.push("KHR_implicit_shapes");
            extensions["KHR_implicit_shapes"] = json!({"shapes": self.implicit});
        }
        self.json["extensions"] = extensions;
        self.json["extensionsUsed"] = json!(used);
    }
}

fn index_of<T: PartialEq>(list: &mut Vec<T>, item: T) -> usize {
    if let Some(i) = list.iter().position(|x| *x == item) {
        return i;
    }
    list.push(item);
    list.len() - 1
}

/// Where the picture of a shape stands: a half-space's square is turned to its normal.
fn seat(shape: &ShapeDef) -> Pose {
    match shape.shape {
        Shape::HalfSpace { normal, offset } => {
            shape.pose.compose(&Pose::new(normal * offset, Quat::from_arc(Vec3::Y, normal)))
        }
        _ => shape.pose,
    }
}
