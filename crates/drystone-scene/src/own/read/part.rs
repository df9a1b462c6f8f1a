//! Files that a file names as parts: scenes of any format, each at its place in the scene.

use std::path::Path;
use std::sync::Arc;

use drystone::{Pose, WorldConfig};

use super::loading::Loading;
use super::reader::Reader;
use super::turn::{rename, turn};
use super::visuals::merge;
use super::whole::scene_of;
use crate::error::SceneError;
use crate::own::document::{self, AutoColliders, Base};
use crate::own::kind::{JsonKind, kind_of_text};
use crate::own::place::Place;
use crate::read::{UTF8, ending, stem, text};
use crate::scene::{Scene, Script};
use crate::visual::Visuals;
use crate::{gltf, mjcf, obj, rigid_ipc, urdf};

/// Files within files, and files in all.
const MOST_DEEP: usize = 16;
const MOST_FILES: usize = 1000;

/// Bodies and joints of all parts together.
const MOST_THINGS: usize = 4_000_000;

impl Loading {
    /// Reads a file of this format.
    pub(super) fn load(&mut self, path: &Path) -> Result<Scene, SceneError> {
        let text = text(path, UTF8)?;
        self.stack.push(path.canonicalize().unwrap_or_else(|_| path.to_owned()));
        let name = stem(path);
        let name = name.strip_suffix(".drystone").unwrap_or(&name).to_owned();
        let folder = path.parent().unwrap_or(Path::new(""));
        let read = scene_of(&text, &name, folder, self);
        self.stack.pop();
        read.map_err(|e| e.in_file(path))
    }

    /// Reads the scene of a part.
    fn scene(&mut self, path: &Path, part: &document::Part) -> Result<Scene, SceneError> {
        let ending = ending(path);
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
            "obj" => {
                let mut loaded = obj::load(path, &options)?;
                if self.options.visuals {
                    loaded.read_visuals();
                }
                Ok(self.numbered(loaded.scene))
            }
            "gltf" | "glb" => {
                let mut loaded = gltf::load(path, &options)?;
                if self.options.visuals {
                    loaded.read_visuals();
                }
                Ok(self.numbered(loaded.scene))
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
                let text = text(path, UTF8)?;
                match kind_of_text(&text).map_err(|e| e.in_file(path))? {
                    JsonKind::Own => self.load(path),
                    JsonKind::RigidIpc => rigid_ipc::load(path),
                }
            }
            _ => fail(
                "its name has no known ending",
                "a .json, .gltf, .glb, .obj, .urdf or .xml (MJCF) file",
            ),
        }
    }

    /// The scene with numbers of nodes that no other file of the scene has.
    fn numbered(&self, mut scene: Scene) -> Scene {
        let number = (self.files as u64) << 32;
        let of = |node: u64| number | node;
        for body in &mut scene.bodies {
            body.def.user_data = of(body.def.user_data);
        }
        let worn = scene.visuals.worn.iter();
        let worn = worn.map(|(node, meshes)| (of(*node), meshes.clone())).collect();
        let visuals = Visuals { worn, ..(*scene.visuals).clone() };
        Scene { visuals: Arc::new(visuals), ..scene }
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
}
