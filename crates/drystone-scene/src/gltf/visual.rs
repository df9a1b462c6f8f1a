//! The visible meshes of a document's nodes, on the bodies they belong to or where they stand.
//! Meshes that cannot be shown are noted and left out.

use std::collections::{BTreeMap, BTreeSet};

use drystone::math::Mat3;
use drystone::{Pose, Vec3};

use super::accessor;
use super::document::Document;
use super::geometry::stretch;
use super::material::{Mapping, Materials};
use super::mesh::corners;
use super::nodes::{self, Tree};
use super::physics::EXTENSION;
use crate::error::SceneError;
use crate::read::json::At;
use crate::read::look::{self, Room};
use crate::transform::Affine;
use crate::visual::{PlacedMesh, VisualMesh, VisualVertex, Visuals};

/// A primitive of a mesh as it is stretched: numbers of both, bits of the linear map.
type Key = (usize, usize, [u32; 9]);

struct Reader<'a> {
    document: &'a Document,
    materials: Materials<'a>,
    meshes: Vec<VisualMesh>,
    /// Number of the mesh that was made of a primitive; none if it is left out.
    made: BTreeMap<Key, Option<usize>>,
    room: Room,
    /// Meshes stand for collision shapes and have their colors.
    plain: bool,
    notes: Vec<String>,
}

/// Returns the visuals, and notes on those that are left out; `bodies` are the nodes of the bodies,
/// which are their user data.
pub(super) fn read(document: &Document, bodies: &[usize]) -> (Visuals, Vec<String>) {
    let (materials, meshes) = (Materials::new(document), Vec::new());
    let (made, notes) = (BTreeMap::new(), Vec::new());
    let root = At::root(&document.json);
    let generator = root.dig(&["asset", "generator"]);
    let plain = generator.is_some_and(|g| g.text().is_ok_and(|name| name == "drystone"));
    let mut reader =
        Reader { document, materials, meshes, made, room: Room::default(), plain, notes };
    let mut visuals = Visuals::default();
    if let Err(e) = reader.nodes(bodies, &mut visuals) {
        reader.notes.push(format!("{e}: what it shows is left out"));
    }
    visuals.meshes = reader.meshes;
    visuals.materials = reader.materials.list;
    visuals.images = reader.materials.images;
    (visuals, reader.notes)
}

impl Reader<'_> {
    fn nodes(&mut self, bodies: &[usize], visuals: &mut Visuals) -> Result<(), SceneError> {
        let root = At::root(&self.document.json);
        let tree = nodes::read(&root)?;
        let list = root.list("nodes")?;
        let late = late(self.document).unwrap_or_default();
        let mut owner: Vec<Option<usize>> = vec![None; tree.nodes.len()];
        for &body in bodies {
            owner[body] = Some(body);
        }
        let mut hidden = vec![false; tree.nodes.len()];
        for &node in &tree.order {
            let parent = tree.nodes[node].parent;
            owner[node] = owner[node].or_else(|| parent.and_then(|p| owner[p]));
            let visible = list[node].dig(&["extensions", "KHR_node_visibility", "visible"]);
            hidden[node] = parent.is_some_and(|p| hidden[p])
                || visible.is_some_and(|v| v.bool().is_ok_and(|v| !v))
                // A body that comes late is there when it comes.
                || (late.contains(&node) && owner[node].is_none());
            let Some(mesh) = list[node].get("mesh") else { continue };
            let of_shape = self.plain && list[node].dig(&["extensions", EXTENSION]).is_some();
            if hidden[node] || !tree.nodes[node].in_scene || of_shape {
                continue;
            }
            let seat = owner[node].map_or(Pose::IDENTITY, |body| tree.nodes[body].pose);
            let own = owner[node] == Some(node);
            let pose = if own { Pose::IDENTITY } else { seat.relative(&tree.nodes[node].pose) };
            let meshes = self.mesh(&mesh, &tree, node).unwrap_or_else(|e| {
                self.notes.push(format!("{}: not drawn: {e}", tree.name(node)));
                Vec::new()
            });
            let placed = meshes.into_iter().map(|mesh| PlacedMesh { mesh, pose });
            match owner[node] {
                Some(body) => visuals.worn.entry(body as u64).or_default().extend(placed),
                None => visuals.scenery.extend(placed),
            }
        }
        visuals.worn.retain(|_, worn| !worn.is_empty());
        Ok(())
    }

    /// The numbers of the meshes of a node.
    fn mesh(&mut self, mesh: &At<'_>, tree: &Tree, node: usize) -> Result<Vec<usize>, SceneError> {
        let number = mesh.size()?;
        let at = At::root(&self.document.json).entry("meshes", mesh)?;
        let l = stretch(&tree.nodes[node]).linear;
        let [x, y, z] = [l.x, l.y, l.z].map(|column| Vec3::from(column.to_array().map(rounded)));
        let map = Affine { linear: Mat3 { x, y, z }, translation: Vec3::ZERO };
        let bits = [x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y, z.z].map(f32::to_bits);
        let mut numbers = Vec::new();
        for (part, primitive) in at.need("primitives")?.items()?.iter().enumerate() {
            let key = (number, part, bits);
            let known = self.made.get(&key).copied();
            let made = known.unwrap_or_else(|| {
                let made = self.primitive(primitive, &map).unwrap_or_else(|e| {
                    self.notes.push(format!("{}: not drawn: {e}", tree.name(node)));
                    None
                });
                self.made.insert(key, made);
                made
            });
            numbers.extend(made);
        }
        Ok(numbers)
    }

    /// The number of the mesh made of a primitive; none if it has no triangles.
    fn primitive(&mut self, at: &At<'_>, map: &Affine) -> Result<Option<usize>, SceneError> {
        for compressed in ["KHR_draco_mesh_compression", "EXT_meshopt_compression"] {
            if let Some(e) = at.dig(&["extensions", compressed]) {
                return Err(e.error("it is compressed", "a mesh without compression"));
            }
        }
        let mode = at.get("mode").map_or(Ok(4), |m| m.size())?;
        if !(4..=6).contains(&mode) {
            self.notes.push(format!("{}: points and lines are not drawn", at.place()));
            return Ok(None);
        }
        let attributes = at.need("attributes")?;
        let position = attributes.need("POSITION")?;
        let points = accessor::positions(self.document, &position)?;
        let count = points.len();
        let list = match at.get("indices") {
            Some(i) => accessor::indices(self.document, &i, count)?,
            None => (0..u32::try_from(count).unwrap_or(0)).collect(),
        };
        // Before it takes memory.
        self.check_room(at, look::size(count, list.len()))?;
        let (material, mapping) = self.material(at);
        let mut vertices: Vec<VisualVertex> = points
            .iter()
            .map(|p| {
                let place = map.point(*p).to_array();
                VisualVertex { place, normal: [0.0; 3], uv: [0.0; 2], color: [1.0; 4] }
            })
            .collect();
        if let Some(i) = vertices.iter().position(|v| !Vec3::from(v.place).is_finite()) {
            return Err(position.error(format!("vertex {i} is out of bounds"), "finite places"));
        }
        if let Some(mapping) = mapping {
            self.coordinates(&attributes, &mapping, &mut vertices);
        }
        self.colors(&attributes, &mut vertices);
        let mirrored = determinant(&map.linear) < 0.0;
        let turned = |t: [usize; 3]| if mirrored { [t[0], t[2], t[1]] } else { t };
        let triangles: Vec<[u32; 3]> =
            corners(mode, list.len()).map(|t| turned(t).map(|i| list[i])).collect();
        if triangles.is_empty() {
            return Ok(None);
        }
        let smooth = self.normals(&attributes, map, &mut vertices);
        let mesh = if smooth {
            let indices = triangles.into_iter().flatten().collect();
            VisualMesh { vertices, indices, material }
        } else {
            self.check_room(at, 3 * triangles.len())?;
            look::flat(&vertices, &triangles, material)
        };
        self.room.add(&mesh);
        self.meshes.push(mesh);
        Ok(Some(self.meshes.len() - 1))
    }

    /// Refuses a primitive for whose vertices there is no room.
    fn check_room(&self, at: &At<'_>, more: usize) -> Result<(), SceneError> {
        self.room.check(more).map_err(|problem| at.error(problem, look::ALLOWED))
    }

    /// The material of a primitive; none if it has none that can be read.
    fn material(&mut self, at: &At<'_>) -> (Option<usize>, Option<Mapping>) {
        let Some(reference) = at.get("material").filter(|_| !self.plain) else {
            return (None, None);
        };
        match self.materials.get(&reference, &mut self.notes) {
            Ok((number, mapping)) => (Some(number), mapping),
            Err(e) => {
                self.notes.push(format!("{e}: drawn without a material"));
                (None, None)
            }
        }
    }

    /// The numbers of an attribute, one element a vertex; none if they are missing or, which is
    /// noted, broken.
    fn numbers(
        &mut self,
        attributes: &At<'_>,
        name: &str,
        kind: Option<(&'static str, usize)>,
        count: usize,
    ) -> Option<(usize, Vec<f32>)> {
        let at = attributes.get(name)?;
        let read = || {
            let (kind, width) = match kind {
                Some(kind) => kind,
                None => accessor::width_of_colors(self.document, &at)?,
            };
            let numbers = accessor::numbers(self.document, &at, kind, width)?;
            if numbers.len() != width * count {
                let problem = format!("has {} elements", numbers.len() / width);
                return Err(at.error(problem, &format!("{count}, one a vertex")));
            }
            Ok((width, numbers))
        };
        let read: Result<_, SceneError> = read();
        read.map_err(|e| self.notes.push(format!("{e}: drawn without it"))).ok()
    }

    fn coordinates(
        &mut self,
        attributes: &At<'_>,
        mapping: &Mapping,
        vertices: &mut [VisualVertex],
    ) {
        let name = format!("TEXCOORD_{}", mapping.set);
        if attributes.get(&name).is_none() {
            self.notes.push(format!(
                "{}: \"{name}\" is missing, its textures show one point",
                attributes.place()
            ));
        }
        let count = vertices.len();
        let Some((_, all)) = self.numbers(attributes, &name, Some(("VEC2", 2)), count) else {
            return;
        };
        for (vertex, uv) in vertices.iter_mut().zip(all.chunks_exact(2)) {
            vertex.uv = mapping.apply([uv[0], uv[1]]);
        }
    }

    fn colors(&mut self, attributes: &At<'_>, vertices: &mut [VisualVertex]) {
        let count = vertices.len();
        let Some((width, all)) = self.numbers(attributes, "COLOR_0", None, count) else { return };
        for (vertex, color) in vertices.iter_mut().zip(all.chunks_exact(width)) {
            for (to, from) in vertex.color.iter_mut().zip(color) {
                *to = from.clamp(0.0, 1.0);
            }
        }
    }

    /// Gives the vertices the normals of the file; false if there are none.
    fn normals(
        &mut self,
        attributes: &At<'_>,
        map: &Affine,
        vertices: &mut [VisualVertex],
    ) -> bool {
        let count = vertices.len();
        let Some((_, all)) = self.numbers(attributes, "NORMAL", Some(("VEC3", 3)), count) else {
            return false;
        };
        let turned = cofactors(&map.linear);
        for (vertex, n) in vertices.iter_mut().zip(all.chunks_exact(3)) {
            let normal = turned * Vec3::from([n[0], n[1], n[2]]);
            vertex.normal = normal.normalize_or(Vec3::Y).to_array();
        }
        true
    }
}

/// A number to 16 bits of its fraction: turned nodes of one size have sizes that differ by their
/// rounding, and share their meshes all the same.
fn rounded(x: f32) -> f32 {
    f32::from_bits(((x + 0.0).to_bits() + 0x80) & !0xFF)
}

fn determinant(m: &Mat3) -> f32 {
    m.x.dot(m.y.cross(m.z))
}

/// The map of normals where `m` maps the points of a surface; they point outward even if `m`
/// mirrors.
fn cofactors(m: &Mat3) -> Mat3 {
    let sign = if determinant(m) < 0.0 { -1.0 } else { 1.0 };
    // Brought to a size about 1: that of small maps would be lost.
    let size = m.x.length().max(m.y.length()).max(m.z.length()).max(1.0e-30);
    let (x, y, z) = (m.x / size, m.y / size, m.z / size);
    Mat3 { x: y.cross(z) * sign, y: z.cross(x) * sign, z: x.cross(y) * sign }
}

/// Nodes that an animation gives a size only later.
fn late(document: &Document) -> Result<BTreeSet<usize>, SceneError> {
    let root = At::root(&document.json);
    let nodes = root.list("nodes")?.len();
    let mut late = BTreeSet::new();
    for animation in root.list("animations")? {
        for channel in animation.list("channels")? {
            let target = channel.need("target")?;
            let Some(node) = target.get("node") else { continue };
            if target.need("path")?.text()? != "scale" {
                continue;
            }
            let sampler = animation.entry("samplers", &channel.need("sampler")?)?;
            let output = sampler.need("output")?;
            let sizes = accessor::numbers(document, &output, "VEC3", 3)?;
            if sizes.iter().take(3).all(|x| x.abs() <= 0.0) {
                late.insert(node.index(nodes, "nodes")?);
            }
        }
    }
    Ok(late)
}
