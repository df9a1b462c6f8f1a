//! From a file to a scene.

mod body;
mod joint;
mod part;
mod shape;
mod strand;
mod text;
mod world;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use drystone::contact::{ContactSoftness, SurfaceRule};
use drystone::{DefError, Filter, Material, Pose, Quat, Shape, Vec3};

pub(super) use self::shape::SavedHull;
pub(super) use self::text::broken;
use self::text::{check_version, too_large};

use super::document::{self, Document, Layer, Softness};
use super::place::Place;
use super::value::{Or, Ref, Triple, Turn};
use crate::error::SceneError;
use crate::scene::{Scene, SceneCoupling, SceneFrame};

/// How a file is read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Options {
    /// Reads what the glTF file looks like that [`Scene::visuals`] are to come from.
    pub visuals: bool,
}

impl Options {
    /// Reads what bodies look like, too.
    #[must_use]
    pub const fn with_visuals() -> Self {
        Self { visuals: true }
    }
}

/// Texts with more objects are refused: in memory each takes up to a thousand bytes.
const MOST_OBJECTS: usize = 6_000_000;

pub(super) fn load(path: &Path, options: &Options) -> Result<Scene, SceneError> {
    part::Loading::new(*options).load(path)
}

pub(super) fn from_text(
    text: &str,
    name: &str,
    folder: &Path,
    options: &Options,
) -> Result<Scene, SceneError> {
    scene_of(text, name, folder, &mut part::Loading::new(*options))
}

/// Reads a text whose paths start from `folder`.
fn scene_of(
    text: &str,
    name: &str,
    folder: &Path,
    loading: &mut part::Loading,
) -> Result<Scene, SceneError> {
    check_version(text)?;
    let objects = text.bytes().filter(|b| *b == b'{').count();
    if objects > MOST_OBJECTS {
        let problem = format!("it has more than {MOST_OBJECTS} objects");
        return Err(SceneError::new(Path::new(""), "", problem, "fewer objects in the JSON"));
    }
    if let Some(at) = too_large(text) {
        let line = text[..at].bytes().filter(|b| *b == b'\n').count() + 1;
        let column = text[..at].chars().rev().take_while(|c| *c != '\n').count() + 1;
        let place = format!("line {line} column {column}");
        let problem = "a number is too large for single precision";
        return Err(SceneError::new(Path::new(""), &place, problem, "numbers up to 3.4e38"));
    }
    let mut json = serde_json::Deserializer::from_str(text);
    let document: Document = serde_path_to_error::deserialize(&mut json)
        .map_err(|e| broken(text, e.inner(), &e.path().to_string()))?;
    json.end().map_err(|e| broken(text, &e, ""))?;
    let reader = Reader {
        text,
        folder,
        loading,
        layers: Vec::new(),
        materials: BTreeMap::new(),
        shapes: BTreeMap::new(),
        names: BTreeMap::new(),
        joints: BTreeMap::new(),
        seats: Vec::new(),
        scene: Scene::new(name, "read from a file"),
    };
    reader.scene(&document)
}

/// A file being read.
struct Reader<'a> {
    text: &'a str,
    folder: &'a Path,
    loading: &'a mut part::Loading,
    layers: Vec<String>,
    materials: BTreeMap<String, Material>,
    /// One each, but several where a mesh is taken apart.
    shapes: BTreeMap<String, Vec<Shape>>,
    /// Numbers of bodies.
    names: BTreeMap<String, usize>,
    /// Numbers of joints.
    joints: BTreeMap<String, usize>,
    /// Where bodies are at the start, by their numbers.
    seats: Vec<Pose>,
    scene: Scene,
}

impl Reader<'_> {
    /// An error at a place.
    fn fail(&self, place: &Place, problem: impl core::fmt::Display, allowed: &str) -> SceneError {
        let (line, column) = place.find(self.text);
        let shown = place.to_string();
        let colon = if shown.is_empty() { "" } else { ": " };
        let place = format!("line {line} column {column}{colon}{shown}");
        SceneError::new(Path::new(""), &place, problem, allowed)
    }

    /// What the engine says of a definition at a place.
    fn refused(&self, place: &Place, e: &DefError) -> SceneError {
        self.fail(&place.field(e.field()), format!("is {}", e.value()), e.allowed())
    }

    fn scene(mut self, document: &Document) -> Result<Scene, SceneError> {
        let root = Place::default();
        self.head(document)?;
        for (name, geometry) in &document.shapes.0 {
            let shapes = self.geometry(&root.key("shapes").key(name), geometry)?;
            self.shapes.insert(name.clone(), shapes);
        }
        for (i, body) in document.bodies.iter().enumerate() {
            let place = root.nth("bodies", i);
            let body = self.body(&place, body)?;
            self.learn(&place, &body.name, Pose::new(body.def.position, body.def.rotation))?;
            self.scene.bodies.push(body);
        }
        let mut parts = Vec::with_capacity(document.parts.len());
        for (i, part) in document.parts.iter().enumerate() {
            let place = root.nth("parts", i);
            let first = self.scene.bodies.len();
            let scene = self.part(&place, part)?;
            for body in &scene.bodies {
                self.learn(&place, &body.name, Pose::new(body.def.position, body.def.rotation))?;
            }
            self.scene.bodies.extend(scene.bodies.iter().cloned());
            parts.push((first, scene));
        }
        for (i, joint) in document.joints.iter().enumerate() {
            let place = root.nth("joints", i);
            let joint = self.joint(&place, joint)?;
            self.learn_joint(&place, &joint.name, self.scene.joints.len())?;
            self.scene.joints.push(joint);
        }
        for (i, (first, scene)) in parts.into_iter().enumerate() {
            self.join(&root.nth("parts", i), first, scene)?;
        }
        self.couplings(document)?;
        self.frames(document)?;
        for (i, strand) in document.strands.iter().enumerate() {
            let strand = self.strand(&root.nth("strands", i), strand)?;
            self.scene.strands.push(strand);
        }
        self.check_strands()?;
        self.rules(document)?;
        if let Some(script) = &document.script {
            self.scene.script = self.script(&root.key("script"), script)?;
        }
        if let Some(file) = &document.visuals {
            self.visuals(&root.key("visuals"), file)?;
        }
        if document.summary.is_none() {
            let bodies = &self.scene.bodies;
            let moving =
                bodies.iter().filter(|b| b.def.kind == drystone::BodyKind::Dynamic).count();
            self.scene.summary = format!("{moving} moving bodies of {}", bodies.len());
        }
        Ok(self.scene)
    }

    /// All that stands at the top and is no list of things.
    fn head(&mut self, document: &Document) -> Result<(), SceneError> {
        let root = Place::default();
        if let Some(name) = &document.name {
            self.scene.name.clone_from(name);
        }
        if let Some(summary) = &document.summary {
            self.scene.summary.clone_from(summary);
        }
        if let Some(hz) = document.hz {
            if !(1.0e-3..=1.0e6).contains(&hz) {
                return Err(self.fail(&root.key("hz"), format!("is {hz}"), "0.001 to 1e6"));
            }
            self.scene.hz = hz;
        }
        if let Some(seconds) = document.seconds {
            if !(0.0..=1.0e9).contains(&seconds) {
                let place = root.key("seconds");
                return Err(self.fail(&place, format!("is {seconds}"), "0 to 1e9 [s]"));
            }
            self.scene.seconds = seconds;
        }
        if let Some(world) = &document.world {
            self.world(&root.key("world"), world)?;
        }
        if document.layers.len() > 64 {
            let problem = format!("has {} names", document.layers.len());
            return Err(self.fail(&root.key("layers"), problem, "at most 64 layers"));
        }
        for (i, name) in document.layers.iter().enumerate() {
            if document.layers[..i].contains(name) {
                let problem = format!("the layer \"{name}\" is there twice");
                return Err(self.fail(&root.nth("layers", i), problem, "each name once"));
            }
        }
        self.layers.clone_from(&document.layers);
        for (name, material) in &document.materials.0 {
            let made = self.material(&root.key("materials").key(name), material)?;
            self.materials.insert(name.clone(), made);
        }
        Ok(())
    }

    /// Takes in a body with its name and place.
    fn learn(&mut self, place: &Place, name: &str, seat: Pose) -> Result<(), SceneError> {
        if self.names.insert(name.to_owned(), self.seats.len()).is_some() {
            let problem = format!("another body is called \"{name}\" too");
            return Err(self.fail(&place.key("name"), problem, "a name of its own"));
        }
        self.seats.push(seat);
        Ok(())
    }

    fn learn_joint(&mut self, place: &Place, name: &str, number: usize) -> Result<(), SceneError> {
        if !name.is_empty() && self.joints.insert(name.to_owned(), number).is_some() {
            let problem = format!("another joint is called \"{name}\" too");
            return Err(self.fail(&place.key("name"), problem, "a name of its own"));
        }
        Ok(())
    }

    /// The number of a body.
    fn body_number(&self, place: &Place, body: &Ref) -> Result<usize, SceneError> {
        self.number(place, body, &self.names, (self.seats.len(), "bodies"))
    }

    fn joint_number(&self, place: &Place, joint: &Ref) -> Result<usize, SceneError> {
        self.number(place, joint, &self.joints, (self.scene.joints.len(), "joints"))
    }

    fn number(
        &self,
        place: &Place,
        which: &Ref,
        names: &BTreeMap<String, usize>,
        (count, what): (usize, &str),
    ) -> Result<usize, SceneError> {
        match which {
            Ref::Name(name) => names.get(name).copied().ok_or_else(|| {
                let all = known(names.keys());
                self.fail(place, format!("is \"{name}\", which none of the {what} is"), &all)
            }),
            Ref::Number(n) if *n < count => Ok(*n),
            Ref::Number(n) => {
                let allowed = match count {
                    0 => format!("none: there are no {what}"),
                    _ => format!("0 to {} ({what})", count - 1),
                };
                Err(self.fail(place, format!("is {n}"), &allowed))
            }
        }
    }

    fn layers(&self, place: &Place, layers: &[Layer]) -> Result<u64, SceneError> {
        let mut bits = 0;
        for (i, layer) in layers.iter().enumerate() {
            let number = match layer {
                Layer::Number(n) => usize::from(*n),
                Layer::Name(name) => {
                    self.layers.iter().position(|known| known == name).ok_or_else(|| {
                        let problem = format!("is \"{name}\", which no layer is called");
                        self.fail(&place.item(i), problem, &known(self.layers.iter()))
                    })?
                }
            };
            bits |= 1 << number;
        }
        Ok(bits)
    }

    fn filter(&self, place: &Place, filter: &document::Filter) -> Result<Filter, SceneError> {
        let mut made = Filter::default();
        if let Some(layers) = &filter.layers {
            made.layers = self.layers(&place.key("layers"), layers)?;
        }
        if let Some(mask) = &filter.mask {
            made.mask = self.layers(&place.key("mask"), mask)?;
        }
        if let Some(exclude) = &filter.exclude {
            made.exclude = self.layers(&place.key("exclude"), exclude)?;
        }
        Ok(made)
    }

    /// A rotation; one by four numbers is taken as it is, and checked with what it is of.
    fn turn(&self, place: &Place, turn: Turn) -> Result<Quat, SceneError> {
        match turn {
            Turn::Quaternion(q) => {
                let quat = Quat::from(q);
                let square: f32 = q.iter().map(|v| v * v).sum();
                if (0.9..1.1).contains(&square) {
                    return Ok(quat);
                }
                let value = format!("is [{}, {}, {}, {}]", q[0], q[1], q[2], q[3]);
                Err(self.fail(place, value, "a unit quaternion [x, y, z, w]"))
            }
            Turn::About(about) => {
                let axis = self.direction(&place.key("axis"), about.axis)?;
                let angle = about.degrees * (core::f32::consts::PI / 180.0);
                Ok(Quat::from_axis_angle(axis, angle))
            }
        }
    }

    /// A direction of any length but none.
    fn direction(&self, place: &Place, v: Triple) -> Result<Vec3, SceneError> {
        Vec3::from(v).try_normalize().ok_or_else(|| {
            let value = format!("is [{}, {}, {}]", v[0], v[1], v[2]);
            self.fail(place, value, "a direction of some length")
        })
    }

    /// A pose from its two parts, each of which may be left out.
    fn pose(
        &self,
        place: &Place,
        position: Option<Triple>,
        rotation: Option<Turn>,
    ) -> Result<Pose, SceneError> {
        let rotation = match rotation {
            Some(turn) => self.turn(&place.key("rotation"), turn)?,
            None => Quat::IDENTITY,
        };
        Ok(Pose::new(position.map_or(Vec3::ZERO, Vec3::from), rotation))
    }

    fn material(
        &self,
        place: &Place,
        material: &document::Material,
    ) -> Result<Material, SceneError> {
        let made = shape::material(material);
        made.validate().map_err(|e| self.refused(place, &e))?;
        Ok(made)
    }

    fn material_of(
        &self,
        place: &Place,
        material: &Or<document::Material>,
    ) -> Result<Material, SceneError> {
        match material {
            Or::Here(material) => self.material(place, material),
            Or::Name(name) => self.materials.get(name).copied().ok_or_else(|| {
                let problem = format!("is \"{name}\", which no material is called");
                self.fail(place, problem, &known(self.materials.keys()))
            }),
        }
    }

    fn couplings(&mut self, document: &Document) -> Result<(), SceneError> {
        let mut made = Vec::with_capacity(document.couplings.len());
        for (i, coupling) in document.couplings.iter().enumerate() {
            let place = Place::default().nth("couplings", i);
            made.push(SceneCoupling {
                joint_a: self.joint_number(&place.key("joint_a"), &coupling.joint_a)?,
                axis_a: joint::axis_of(coupling.axis_a),
                joint_b: self.joint_number(&place.key("joint_b"), &coupling.joint_b)?,
                axis_b: joint::axis_of(coupling.axis_b),
                ratio: coupling.ratio,
                offset: coupling.offset.unwrap_or(0.0),
            });
        }
        // Those of parts are there already.
        made.append(&mut self.scene.couplings);
        self.scene.couplings = made;
        Ok(())
    }

    fn frames(&mut self, document: &Document) -> Result<(), SceneError> {
        let mut made = Vec::with_capacity(document.frames.len());
        let mut taken: Vec<&str> = self.scene.frames.iter().map(|f| f.name.as_str()).collect();
        for (i, frame) in document.frames.iter().enumerate() {
            let place = Place::default().nth("frames", i);
            if self.names.contains_key(&frame.name) || taken.contains(&frame.name.as_str()) {
                let problem = format!("another body or frame is called \"{}\" too", frame.name);
                return Err(self.fail(&place.key("name"), problem, "a name of its own"));
            }
            taken.push(&frame.name);
            let pose = self.pose(&place, frame.position, frame.rotation)?;
            made.push(SceneFrame {
                name: frame.name.clone(),
                body: self.body_number(&place.key("body"), &frame.body)?,
                pose,
                center: frame.center.map_or(pose.position, Vec3::from),
            });
        }
        made.append(&mut self.scene.frames);
        self.scene.frames = made;
        Ok(())
    }

    fn rules(&mut self, document: &Document) -> Result<(), SceneError> {
        for (i, pair) in document.never_collide.iter().enumerate() {
            let place = Place::default().nth("never_collide", i);
            let a = self.body_number(&place.item(0), &pair[0])?;
            let b = self.body_number(&place.item(1), &pair[1])?;
            self.scene.never_collide.push([a, b]);
        }
        for (i, rule) in document.surfaces_between.iter().enumerate() {
            let place = Place::default().nth("surfaces_between", i);
            let bodies = place.key("bodies");
            let a = self.body_number(&bodies.item(0), &rule.bodies[0])?;
            let b = self.body_number(&bodies.item(1), &rule.bodies[1])?;
            if a == b {
                let problem = "both are the same body".to_owned();
                return Err(self.fail(&bodies, problem, "two bodies"));
            }
            let made = SurfaceRule {
                friction: rule.friction,
                kinetic_friction: rule.kinetic_friction,
                restitution: rule.restitution,
                softness: rule.softness.map(softness_of),
                ..SurfaceRule::ANY
            };
            made.validate().map_err(|e| self.refused(&place, &e))?;
            self.scene.surfaces_between.push(([a, b], made));
        }
        let mut rules = Vec::with_capacity(document.surface_rules.len());
        for (i, rule) in document.surface_rules.iter().enumerate() {
            let place = Place::default().nth("surface_rules", i);
            let made = SurfaceRule {
                first: self.layers(&place.key("first"), &rule.first)?,
                second: self.layers(&place.key("second"), &rule.second)?,
                friction: rule.friction,
                kinetic_friction: rule.kinetic_friction,
                restitution: rule.restitution,
                softness: rule.softness.map(softness_of),
            };
            made.validate().map_err(|e| self.refused(&place, &e))?;
            rules.push(made);
        }
        rules.append(&mut self.scene.surface_rules);
        if rules.len() > 256 {
            let problem = format!("there are {}", rules.len());
            return Err(self.fail(&Place::default().key("surface_rules"), problem, "at most 256"));
        }
        self.scene.surface_rules = rules;
        Ok(())
    }

    /// A file that this one names, whose path is relative to it.
    fn path(&self, place: &Place, file: &str) -> Result<PathBuf, SceneError> {
        let relative = Path::new(file);
        let is_up = |c: &std::path::Component<'_>| matches!(c, std::path::Component::ParentDir);
        let is_near = relative.components().filter(is_up).count() <= 8;
        if file.is_empty() || file.contains('\0') || file.contains("://") || !relative.is_relative()
        {
            return Err(self.fail(place, format!("is \"{file}\""), "a path relative to this file"));
        }
        if !is_near {
            let allowed = "a path of a file near this one";
            return Err(self.fail(place, format!("is \"{file}\""), allowed));
        }
        Ok(self.folder.join(relative))
    }

    fn visuals(&mut self, place: &Place, file: &str) -> Result<(), SceneError> {
        let path = self.path(place, file)?;
        if !path.is_file() {
            return Err(self.fail(place, format!("there is no file \"{file}\""), "a glTF file"));
        }
        if !self.loading.options.visuals {
            return Ok(());
        }
        // The same nodes are bodies, whatever their meshes become.
        let auto_colliders = Some(crate::gltf::AutoColliders::Box);
        let options = crate::gltf::Options { auto_colliders, gravity: None };
        let is_obj = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("obj"));
        let load = if is_obj { crate::obj::load } else { crate::gltf::load };
        let mut loaded = load(&path, &options).map_err(|e| self.fail(place, e, "a glTF file"))?;
        loaded.read_visuals();
        // Beside those of parts.
        let mut visuals = (*self.scene.visuals).clone();
        part::merge(&mut visuals, &loaded.scene.visuals);
        self.scene.visuals = Arc::new(visuals);
        Ok(())
    }
}

/// What is known, for errors.
fn known<'a>(names: impl ExactSizeIterator<Item = &'a String>) -> String {
    let count = names.len();
    if count == 0 {
        return "none: none is named".to_owned();
    }
    let shown: Vec<String> = names.take(12).map(|name| format!("\"{name}\"")).collect();
    let more = if count > 12 { format!(" and {} more", count - 12) } else { String::new() };
    format!("{}{more}", shown.join(", "))
}

const fn softness_of(softness: Softness) -> ContactSoftness {
    ContactSoftness { hertz: softness.hertz, damping_ratio: softness.damping_ratio }
}
