//! Scenes: built-in ones, files, and texts.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use drystone_scene::{Scene, gltf, mjcf, obj, own, rigid_ipc, urdf};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::errors::{bad, scene as scene_error, unbuildable, unreadable};

const ENDINGS: &str = ".json, .gltf, .glb, .obj, .urdf or .xml (MJCF)";

/// A scene: bodies, joints and settings, from which worlds are made.
#[pyclass(name = "Scene", module = "drystone", frozen)]
pub(crate) struct PyScene {
    pub(crate) scene: Arc<Scene>,
    /// The file or the built-in name, for messages.
    pub(crate) source: String,
}

#[pymethods]
impl PyScene {
    /// Reads a file (.json, .gltf, .glb, .obj, .urdf, .xml), or makes a built-in scene such as
    /// 'tower' or 'wall:ball=1'. A text with an ending or a folder is a file.
    ///
    /// `strict` refuses a file of which anything was left out, changed or approximated (`notes`).
    /// `base` ('auto', 'fixed', 'floating') and `ground` (height [m]) are for .urdf files;
    /// `auto_colliders` ('hull', 'mesh', 'box') for glTF and .obj files without physics.
    #[staticmethod]
    #[pyo3(signature = (source, *, strict=false, base=None, ground=None, auto_colliders=None))]
    fn load(
        py: Python<'_>,
        source: PathBuf,
        strict: bool,
        base: Option<&str>,
        ground: Option<f32>,
        auto_colliders: Option<&str>,
    ) -> PyResult<Self> {
        let reading = Reading::new(base, ground, auto_colliders)?;
        py.detach(|| load(&source, &reading)).and_then(|scene| scene.checked(strict))
    }

    /// Reads a text of drystone's own format (JSON), of MJCF or of URDF. Paths in it start from
    /// `folder`.
    #[staticmethod]
    #[pyo3(signature = (text, *, folder=None, strict=false, base=None, ground=None))]
    fn from_string(
        py: Python<'_>,
        text: &str,
        folder: Option<PathBuf>,
        strict: bool,
        base: Option<&str>,
        ground: Option<f32>,
    ) -> PyResult<Self> {
        let reading = Reading::new(base, ground, None)?;
        let folder = folder.unwrap_or_default();
        py.detach(|| from_text(text, &folder, &reading)).and_then(|scene| scene.checked(strict))
    }

    /// The names of the built-in scenes.
    #[staticmethod]
    fn names() -> Vec<&'static str> {
        drystone_scene::catalog().iter().map(|entry| entry.name).collect()
    }

    /// Its name.
    #[getter]
    fn name(&self) -> &str {
        &self.scene.name
    }

    /// Its summary, in a line.
    #[getter]
    fn summary(&self) -> &str {
        &self.scene.summary
    }

    /// Parts of a file that were left out, changed or approximated, a line each.
    #[getter]
    fn notes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, &self.scene.notes)
    }

    /// Steps a second that it is made for.
    #[getter]
    fn hz(&self) -> f32 {
        self.scene.hz
    }

    /// Its length of a step [s]: 1 / hz.
    #[getter]
    pub(crate) fn dt(&self) -> f32 {
        1.0 / self.scene.hz
    }

    /// How long it is worth simulating [s].
    #[getter]
    fn seconds(&self) -> f32 {
        self.scene.seconds
    }

    /// Names of its bodies, in their order.
    #[getter]
    fn body_names<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.scene.bodies.iter().map(|body| &body.name))
    }

    /// The scene in drystone's own format (JSON); read again, it is the same, bit by bit.
    fn to_json(&self) -> PyResult<String> {
        own::to_text(&self.scene).map_err(|e| unreadable(&e))
    }

    /// Writes the scene as a file of drystone's own format.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        own::save(&path, &self.scene, None).map(|_| ()).map_err(|e| unreadable(&e))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (String, String))> {
        let make = py.get_type::<Self>().getattr("_from_pickle")?;
        Ok((make, (self.to_json()?, self.source.clone())))
    }

    #[staticmethod]
    fn _from_pickle(text: &str, source: String) -> PyResult<Self> {
        let scene = own::from_text(text, "", Path::new("")).map_err(|e| unreadable(&e))?;
        Ok(Self { scene: Arc::new(scene), source })
    }

    fn __repr__(&self) -> String {
        let Scene { name, bodies, joints, .. } = &*self.scene;
        format!("<Scene '{name}': {} bodies, {} joints>", bodies.len(), joints.len())
    }
}

impl PyScene {
    fn new(scene: Scene, source: &Path) -> Self {
        Self { scene: Arc::new(scene), source: source.display().to_string() }
    }

    fn checked(self, strict: bool) -> PyResult<Self> {
        if let (true, [first, rest @ ..]) = (strict, self.scene.notes.as_slice()) {
            let more =
                if rest.is_empty() { String::new() } else { format!(" (and {} more)", rest.len()) };
            let problem = format!("{first}{more}");
            let allowed = "a file that is read in full, as strict=True demands";
            let file = if self.source.is_empty() { "the text" } else { self.source.as_str() };
            let text = format!("{file}: {problem}, expected {allowed}");
            return Err(scene_error(&text, &self.source, "", &problem, allowed));
        }
        // An error of the engine shows here, and not at the first world.
        match self.scene.build() {
            Ok(_) => Ok(self),
            Err(e) => Err(unbuildable(&self.source, &e)),
        }
    }
}

/// Settings that only some formats have.
struct Reading {
    base: Option<urdf::Base>,
    ground: Option<f32>,
    auto_colliders: Option<gltf::AutoColliders>,
}

impl Reading {
    fn new(base: Option<&str>, ground: Option<f32>, colliders: Option<&str>) -> PyResult<Self> {
        let base = match base {
            None => None,
            Some("auto") => Some(urdf::Base::Auto),
            Some("fixed") => Some(urdf::Base::Fixed),
            Some("floating") => Some(urdf::Base::Floating),
            Some(other) => return Err(bad("base", other, "one of auto, fixed, floating")),
        };
        let auto_colliders = match colliders {
            None => None,
            Some("hull") => Some(gltf::AutoColliders::Hull),
            Some("mesh") => Some(gltf::AutoColliders::Mesh),
            Some("box") => Some(gltf::AutoColliders::Box),
            Some(other) => return Err(bad("auto_colliders", other, "one of hull, mesh, box")),
        };
        if ground.is_some_and(|height| !height.is_finite()) {
            return Err(bad("ground", "a number that is not finite", "a height"));
        }
        Ok(Self { base, ground, auto_colliders })
    }

    /// Refuses settings that files with this ending do not have.
    fn suits(&self, ending: &str) -> PyResult<()> {
        if ending != "urdf" && (self.base.is_some() || self.ground.is_some()) {
            return Err(bad("base", "`base` or `ground`", "given for .urdf files alone"));
        }
        if !["gltf", "glb", "obj"].contains(&ending) && self.auto_colliders.is_some() {
            let allowed = "given for .gltf, .glb and .obj files alone";
            return Err(bad("auto_colliders", "a kind of collider", allowed));
        }
        Ok(())
    }

    fn robot(&self) -> urdf::Options {
        urdf::Options { base: self.base.unwrap_or(urdf::Base::Auto), ground: self.ground }
    }
}

fn load(source: &Path, reading: &Reading) -> PyResult<PyScene> {
    let text = source.display().to_string();
    let ending = source.extension().and_then(|end| end.to_str()).unwrap_or("").to_lowercase();
    let is_file = source.components().count() > 1
        || ["json", "gltf", "glb", "obj", "urdf", "xml"].contains(&ending.as_str());
    if !is_file {
        let scene = drystone_scene::named(&text)
            .map_err(|e| scene_error(&e.to_string(), &text, "", &e.to_string(), ""))?;
        reading.suits("")?;
        return Ok(PyScene::new(scene, source));
    }
    reading.suits(&ending)?;
    let options = gltf::Options { auto_colliders: reading.auto_colliders, gravity: None };
    let read = match ending.as_str() {
        "obj" => obj::load(source, &options).map(|loaded| loaded.scene),
        "gltf" | "glb" => gltf::load(source, &options).map(|loaded| loaded.scene),
        "urdf" => urdf::load(source, &reading.robot()),
        "xml" => mjcf::load(source),
        "json" => own::kind_of(source).and_then(|kind| match kind {
            own::JsonKind::RigidIpc => rigid_ipc::load(source),
            _ => own::load(source, &own::Options::default()),
        }),
        _ => {
            let problem = "its name has no known ending";
            let error = format!("{text}: {problem}, expected {ENDINGS}");
            return Err(scene_error(&error, &text, "", problem, ENDINGS));
        }
    };
    read.map(|scene| PyScene::new(scene, source)).map_err(|e| unreadable(&e))
}

fn from_text(text: &str, folder: &Path, reading: &Reading) -> PyResult<PyScene> {
    let start = text.trim_start();
    let is_xml = start.starts_with('<');
    let is_robot = is_xml && start.contains("<robot");
    reading.suits(if is_robot { "urdf" } else { "" })?;
    let read = if is_robot {
        urdf::from_text(text, folder, &reading.robot())
    } else if is_xml {
        mjcf::from_text(text, folder)
    } else {
        own::from_text(text, "scene", folder)
    };
    let scene = read.map_err(|e| unreadable(&e))?;
    Ok(PyScene { scene: Arc::new(scene), source: String::new() })
}

/// A scene from an argument: a `Scene`, or anything that `Scene.load` takes.
pub(crate) fn scene_of(value: &Bound<'_, PyAny>) -> PyResult<(Arc<Scene>, String)> {
    if let Ok(scene) = value.cast::<PyScene>() {
        let scene = scene.get();
        return Ok((Arc::clone(&scene.scene), scene.source.clone()));
    }
    let allowed = "a Scene, a path or the name of a built-in scene";
    let path: PathBuf =
        value.extract().map_err(|_| crate::arrays::wrong_type("scene", value, allowed))?;
    let loaded = value.py().detach(|| load(&path, &Reading::new(None, None, None)?))?;
    let loaded = loaded.checked(false)?;
    Ok((loaded.scene, loaded.source))
}
