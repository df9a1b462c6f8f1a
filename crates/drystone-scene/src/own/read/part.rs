//! Files that a file names: scenes that become parts of it, and meshes.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use drystone::{AxisLocks, BodyDef, JointKind, Pose, Quat, Shape, Vec3, WorldConfig};

use super::{Options, Reader, scene_of};
use crate::error::SceneError;
use crate::file::{self, Kind};
use crate::gltf::mesh::Triangles;
use crate::own::document::{self, AutoColliders, Base};
use crate::own::place::Place;
use crate::own::{JsonKind, kind_of_text, text_of};
use crate::scene::{Scene, SceneJoint, SceneStrand, Script, StrandDef};
use crate::visual::Visuals;
use crate::{gltf, mjcf, obj, rigid_ipc, stl, urdf};

/// Files within files, and files in all.
const MOST_DEEP: usize = 16;
const MOST_FILES: usize = 1000;

/// Bodies and joints of all parts together.
const MOST_THINGS: usize = 4_000_000;

/// More of mesh files is not read for one scene, however often it names them [bytes].
const MOST_BYTES: u64 = 2_000_000_000;

/// Corners and triangles of the meshes of all shapes together.
const MOST_CORNERS: usize = 100_000_000;

/// What is read for one scene.
pub(super) struct Loading {
    pub(super) options: Options,
    /// The files that are being read, each named by the one before it.
    stack: Vec<PathBuf>,
    files: usize,
    things: usize,
    bytes: u64,
    meshes: BTreeMap<PathBuf, Triangles>,
    /// By file, what it becomes, and bits of the scale.
    shapes: BTreeMap<(PathBuf, As, [u32; 3]), Vec<Shape>>,
    /// Corners of meshes that were looked at so far.
    corners: usize,
    /// Particles of ropes and cloths so far.
    pub(super) particles: usize,
}

/// What a mesh file becomes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum As {
    Hull,
    Mesh,
    Hulls,
}

impl Loading {
    pub(super) const fn new(options: Options) -> Self {
        Self {
            options,
            stack: Vec::new(),
            files: 0,
            things: 0,
            bytes: 0,
            meshes: BTreeMap::new(),
            shapes: BTreeMap::new(),
            corners: 0,
            particles: 0,
        }
    }

    /// Reads a file of this format.
    pub(super) fn load(&mut self, path: &Path) -> Result<Scene, SceneError> {
        let text = text_of(path)?;
        self.stack.push(path.canonicalize().unwrap_or_else(|_| path.to_owned()));
        let name = path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned());
        let name = name.strip_suffix(".drystone").unwrap_or(&name).to_owned();
        let folder = path.parent().unwrap_or(Path::new(""));
        let read = scene_of(&text, &name, folder, self);
        self.stack.pop();
        read.map_err(|e| e.in_file(path))
    }

    /// Reads the scene of a part.
    fn scene(&mut self, path: &Path, part: &document::Part) -> Result<Scene, SceneError> {
        let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        let ending = ending.unwrap_or_default();
        let auto_colliders = part.auto_colliders.map(|kind| match kind {
            AutoColliders::Hull => gltf::AutoColliders::Hull,
            AutoColliders::Mesh => gltf::AutoColliders::Mesh,
            AutoColliders::Box => gltf::AutoColliders::Box,
        });
        let fail = |problem: &str, allowed: &str| Err(SceneError::new(path, "", problem, allowed));
        if part.base.is_some() && ending != "urdf" {
            return fail("it is no .urdf file", "a base for .urdf files alone");
        }
        if auto_colliders.is_some() && !["gltf", "glb", "obj"].contains(&ending.as_str()) {
            let allowed = "auto_colliders for .gltf, .glb and .obj files alone";
            return fail("it is no file without physics", allowed);
        }
        let options = gltf::Options { auto_colliders, gravity: None };
        match ending.as_str() {
            "gltf" | "glb" | "obj" => {
                let mut loaded = if ending == "obj" {
                    obj::load(path, &options)?
                } else {
                    gltf::load(path, &options)?
                };
                if self.options.visuals {
                    loaded.read_visuals();
                }
                // The numbers of nodes are nobody's but this file's.
                let number = (self.files as u64) << 32;
                let of = |node: u64| number | node;
                for body in &mut loaded.scene.bodies {
                    body.def.user_data = of(body.def.user_data);
                }
                let worn = &loaded.scene.visuals.worn;
                let worn = worn.iter().map(|(node, meshes)| (of(*node), meshes.clone())).collect();
                let visuals = Visuals { worn, ..(*loaded.scene.visuals).clone() };
                Ok(Scene { visuals: Arc::new(visuals), ..loaded.scene })
            }
            "urdf" => {
                let base = match part.base {
                    None | Some(Base::Auto) => urdf::Base::Auto,
                    Some(Base::Fixed) => urdf::Base::Fixed,
                    Some(Base::Floating) => urdf::Base::Floating,
                };
                urdf::load(path, &urdf::Options { base, ground: None })
            }
            "xml" => mjcf::load(path),
            "json" => {
                let text = text_of(path)?;
                match kind_of_text(&text).map_err(|e| e.in_file(path))? {
                    JsonKind::Own => self.load(path),
                    JsonKind::RigidIpc => rigid_ipc::load(path),
                }
            }
            _ => fail(
                "its name tells no known format",
                "a .json, .gltf, .glb, .obj, .urdf or .xml (MJCF) file",
            ),
        }
    }
}

impl Reader<'_> {
    /// The scene of a part, where it is to be, with its names.
    pub(super) fn part(
        &mut self,
        place: &Place,
        part: &document::Part,
    ) -> Result<Scene, SceneError> {
        if part.name.is_empty() {
            return Err(self.fail(&place.key("name"), "is empty", "a name"));
        }
        let pose = self.pose(place, part.position, part.rotation)?;
        if !pose.is_finite() {
            return Err(self.fail(&place.key("position"), "is not finite", "finite numbers"));
        }
        let pose = Pose { rotation: pose.rotation.normalized(), ..pose };
        let at = place.key("file");
        let path = self.path(&at, &part.file)?;
        let real = path.canonicalize().unwrap_or_else(|_| path.clone());
        if self.loading.stack.contains(&real) {
            let problem = format!("{} is a part of itself", part.file);
            return Err(self.fail(&at, problem, "files that do not name each other in a circle"));
        }
        self.loading.files += 1;
        if self.loading.stack.len() > MOST_DEEP || self.loading.files > MOST_FILES {
            let allowed = format!("files up to {MOST_DEEP} deep, {MOST_FILES} in all");
            return Err(self.fail(&at, "it names too many files", &allowed));
        }
        let mut scene = self.loading.scene(&path, part).map_err(|e| self.fail(&at, e, ""))?;
        self.loading.things += scene.bodies.len() + scene.joints.len();
        if self.loading.things > MOST_THINGS {
            let allowed = format!("up to {MOST_THINGS} bodies and joints of parts");
            return Err(self.fail(&at, "its parts are too large", &allowed));
        }
        rename(&mut scene, &part.name);
        let turned = turn(&mut scene, &pose);
        let mut notes = core::mem::take(&mut scene.notes);
        if turned > 0 {
            notes.push(format!("{turned} bodies have locked axes, which stay those of the world"));
        }
        if !matches!(scene.script, Script::None) {
            notes.push("its script is left out".to_owned());
        }
        let config = WorldConfig { gravity: scene.config.gravity, ..WorldConfig::default() };
        if scene.config != config {
            notes.push("settings of its world are left out".to_owned());
        }
        let (own, g) = (pose.direction(scene.config.gravity), self.scene.config.gravity);
        // Beyond the rounding of a turn.
        if (own - g).length() > 1.0e-5 * g.length() {
            notes.push(format!("gravity is ({}, {}, {}), not its own", g.x, g.y, g.z));
        }
        let notes = notes.into_iter().map(|note| format!("{}: {note}", part.name));
        self.scene.notes.extend(notes);
        Ok(scene)
    }

    /// Takes in all of a part but its bodies, of which the first has this number.
    pub(super) fn join(
        &mut self,
        place: &Place,
        first: usize,
        scene: Scene,
    ) -> Result<(), SceneError> {
        let Scene { joints, couplings, strands, frames, never_collide, .. } = scene;
        let first_joint = self.scene.joints.len();
        for mut joint in joints {
            joint.body_a += first;
            joint.body_b += first;
            self.learn_joint(place, &joint.name, self.scene.joints.len())?;
            self.scene.joints.push(joint);
        }
        for mut coupling in couplings {
            coupling.joint_a += first_joint;
            coupling.joint_b += first_joint;
            self.scene.couplings.push(coupling);
        }
        for mut strand in strands {
            strand.holds.iter_mut().for_each(|hold| hold.body += first);
            self.scene.strands.push(strand);
        }
        for mut frame in frames {
            frame.body += first;
            self.scene.frames.push(frame);
        }
        for pair in never_collide {
            self.scene.never_collide.push(pair.map(|body| body + first));
        }
        let between = scene.surfaces_between.into_iter();
        let moved = between.map(|(pair, rule)| (pair.map(|body| body + first), rule));
        self.scene.surfaces_between.extend(moved);
        self.scene.surface_rules.extend(scene.surface_rules);
        let more = scene.visuals;
        if !more.is_empty() {
            let mut visuals = (*self.scene.visuals).clone();
            merge(&mut visuals, &more);
            self.scene.visuals = Arc::new(visuals);
        }
        Ok(())
    }

    /// Shapes of a mesh file, which are made once and shared.
    pub(super) fn shapes_of_file(
        &mut self,
        place: &Place,
        what: As,
        file: &str,
        scale: Option<[f32; 3]>,
    ) -> Result<Vec<Shape>, SceneError> {
        let at = place.key("file");
        let path = self.path(&at, file)?;
        let scale = scale.map_or(Vec3::ONE, Vec3::from);
        let key = (path.clone(), what, scale.to_array().map(f32::to_bits));
        if let Some(shapes) = self.loading.shapes.get(&key) {
            return Ok(shapes.clone());
        }
        if !self.loading.meshes.contains_key(&path) {
            let made = self.triangles(&path).map_err(|e| self.fail(&at, e, ""))?;
            self.loading.meshes.insert(path.clone(), made);
        }
        let mut surface = self.loading.meshes.get(&path).cloned().unwrap_or_default();
        surface.points.iter_mut().for_each(|point| *point = point.mul_each(scale));
        self.loading.corners += surface.points.len() + surface.triangles.len();
        if self.loading.corners > MOST_CORNERS {
            let problem = format!("brings all meshes to more than {MOST_CORNERS} corners");
            return Err(self.fail(&at, problem, "fewer or simpler meshes"));
        }
        // The place of its errors is not that of a glTF file.
        let nowhere = serde_json::Value::Null;
        let nowhere = gltf::At::root(&nowhere);
        let made = match what {
            As::Hull => surface.hull(&nowhere).map(|hull| vec![hull]),
            As::Mesh => surface.mesh(&nowhere).map(|mesh| vec![mesh]),
            As::Hulls => surface.hulls(&nowhere).map(|(shapes, note)| {
                self.scene.notes.push(format!("{at}: its mesh is {note}"));
                shapes
            }),
        };
        let made = made.map_err(|e| self.fail(&at, e.problem(), e.allowed()))?;
        self.loading.shapes.insert(key, made.clone());
        Ok(made)
    }

    fn triangles(&mut self, path: &Path) -> Result<Triangles, String> {
        let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        let ending = ending.unwrap_or_default();
        if ending != "obj" && ending != "stl" {
            return Err(format!("a .{ending} file is not read, .obj and .stl are"));
        }
        if self.loading.bytes > MOST_BYTES {
            return Err(format!("meshes of {MOST_BYTES} bytes were read before it, no more are"));
        }
        let bytes = file::read(path, Kind::Mesh).map_err(|e| e.to_string())?;
        self.loading.bytes += bytes.len() as u64;
        if ending == "obj" {
            return obj::surface(&String::from_utf8_lossy(&bytes)).map_err(|e| e.to_string());
        }
        let points = stl::corners(&bytes)?;
        let count = u32::try_from(points.len() / 3).map_err(|_| "it is too large".to_owned())?;
        let triangles = (0..count).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        Ok(Triangles { points, triangles })
    }
}

/// Prefixes all names.
fn rename(scene: &mut Scene, prefix: &str) {
    let named = |name: &mut String| *name = format!("{prefix}/{name}");
    scene.bodies.iter_mut().for_each(|body| named(&mut body.name));
    scene.strands.iter_mut().for_each(|strand| named(&mut strand.name));
    scene.frames.iter_mut().for_each(|frame| named(&mut frame.name));
    for joint in scene.joints.iter_mut().filter(|joint| !joint.name.is_empty()) {
        named(&mut joint.name);
    }
}

/// Brings a scene to a pose; how many bodies have locked axes, which do not turn with it.
fn turn(scene: &mut Scene, pose: &Pose) -> usize {
    if *pose == Pose::IDENTITY {
        return 0;
    }
    for body in &mut scene.bodies {
        turn_body(&mut body.def, pose);
    }
    for SceneJoint { kind, .. } in &mut scene.joints {
        if let JointKind::Pulley(pulley) = kind {
            pulley.points = pulley.points.map(|point| pose.point(point));
        }
    }
    for SceneStrand { def, .. } in &mut scene.strands {
        match def {
            StrandDef::Rope(rope) => {
                (rope.from, rope.to) = (pose.point(rope.from), pose.point(rope.to));
                rope.particle.velocity = pose.direction(rope.particle.velocity);
            }
            StrandDef::Cloth(cloth) => {
                cloth.corner = pose.point(cloth.corner);
                cloth.sides = cloth.sides.map(|side| pose.direction(side));
                cloth.particle.velocity = pose.direction(cloth.particle.velocity);
            }
            StrandDef::Cloud(points, particle) => {
                points.iter_mut().for_each(|point| *point = pose.point(*point));
                particle.velocity = pose.direction(particle.velocity);
            }
        }
    }
    if !scene.visuals.scenery.is_empty() {
        let visuals = Arc::make_mut(&mut scene.visuals);
        visuals.scenery.iter_mut().for_each(|placed| placed.pose = pose.compose(&placed.pose));
    }
    let is_turned = pose.rotation != Quat::IDENTITY;
    let locked = |body: &&crate::scene::SceneBody| body.def.locks != AxisLocks::NONE;
    if is_turned { scene.bodies.iter().filter(locked).count() } else { 0 }
}

fn turn_body(def: &mut BodyDef, pose: &Pose) {
    let seat = pose.compose(&Pose::new(def.position, def.rotation));
    (def.position, def.rotation) = (seat.position, seat.rotation.normalized());
    def.linear_velocity = pose.direction(def.linear_velocity);
    def.angular_velocity = pose.direction(def.angular_velocity);
}

/// Adds what another scene looks like.
pub(super) fn merge(visuals: &mut Visuals, more: &Visuals) {
    let (meshes, materials, images) =
        (visuals.meshes.len(), visuals.materials.len(), visuals.images.len());
    for material in &more.materials {
        let mut material = material.clone();
        let textures = [
            &mut material.base_texture,
            &mut material.surface_texture,
            &mut material.normal_texture,
            &mut material.occlusion_texture,
            &mut material.emissive_texture,
        ];
        textures.into_iter().flatten().for_each(|texture| texture.image += images);
        visuals.materials.push(material);
    }
    for mesh in &more.meshes {
        let mut mesh = mesh.clone();
        mesh.material = mesh.material.map(|material| material + materials);
        visuals.meshes.push(mesh);
    }
    visuals.images.extend(more.images.iter().cloned());
    let placed = |placed: &crate::visual::PlacedMesh| crate::visual::PlacedMesh {
        mesh: placed.mesh + meshes,
        ..*placed
    };
    for (key, worn) in &more.worn {
        visuals.worn.entry(*key).or_default().extend(worn.iter().map(placed));
    }
    visuals.scenery.extend(more.scenery.iter().map(placed));
}
