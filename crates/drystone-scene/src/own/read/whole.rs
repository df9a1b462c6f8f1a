//! From the text of a file to a scene, section by section.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use drystone::{BodyKind, Pose};

use super::loading::Loading;
use super::reader::Reader;
use super::visuals::merge;
use crate::error::SceneError;
use crate::gltf::{self, AutoColliders};
use crate::obj;
use crate::own::document::Document;
use crate::own::place::Place;
use crate::own::text::{broken, check_version, too_large};
use crate::read::ending;
use crate::scene::Scene;

/// Texts with more objects are refused: in memory each takes up to a thousand bytes.
const MOST_OBJECTS: usize = 6_000_000;

/// Reads a text whose paths start from `folder`.
pub(super) fn scene_of(
    text: &str,
    name: &str,
    folder: &Path,
    loading: &mut Loading,
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

impl Reader<'_> {
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
            let moving = bodies.iter().filter(|b| b.def.kind == BodyKind::Dynamic).count();
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

    fn visuals(&mut self, place: &Place, file: &str) -> Result<(), SceneError> {
        let path = self.path(place, file)?;
        if !path.is_file() {
            return Err(self.fail(place, format!("there is no file \"{file}\""), "a glTF file"));
        }
        if !self.loading.options.visuals {
            return Ok(());
        }
        // The same nodes are bodies, whatever their meshes become.
        let auto_colliders = Some(AutoColliders::Box);
        let options = gltf::Options { auto_colliders, gravity: None };
        let seen = if ending(&path) == "obj" {
            obj::load(&path, &options).map(|mut loaded| {
                loaded.read_visuals();
                loaded.scene.visuals
            })
        } else {
            gltf::load(&path, &options).map(|mut loaded| {
                loaded.read_visuals();
                loaded.scene.visuals
            })
        };
        let seen = seen.map_err(|e| self.fail(place, e, "a glTF file"))?;
        // Beside those of parts.
        let mut visuals = (*self.scene.visuals).clone();
        merge(&mut visuals, &seen);
        self.scene.visuals = Arc::new(visuals);
        Ok(())
    }
}
