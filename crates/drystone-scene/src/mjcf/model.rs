//! The files of a scene, and each as a model: its sections, settings, default classes and assets.

use std::cell::Cell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use drystone::{Pose, Quat, Vec3};
use roxmltree::Document;

use super::defaults::{Defaults, View};
use crate::error::SceneError;
use crate::read::xml::{self, Element};

/// More files than this are refused.
const MAX_FILES: usize = 64;

/// Most files that include each other, one in the other.
const MAX_INCLUDES: usize = 16;

/// Largest size of all files together [bytes].
const MAX_BYTES: usize = 400_000_000;

/// More elements than this are not looked at, those of included files and of copies each time: a
/// file of a few lines can have billions of them.
const MAX_SEEN: usize = 4_000_000;

/// All files that the first one names, and those they name.
pub(super) struct Files {
    folder: PathBuf,
    /// Name, empty for the first, and text.
    pub(super) texts: Vec<(String, String)>,
}

impl Files {
    /// Reads them all; a file that is not there is an error.
    pub(super) fn read(text: &str, folder: &Path) -> Result<Self, SceneError> {
        let mut texts = vec![(String::new(), text.to_owned())];
        let mut bytes = text.len();
        let mut next = 0;
        while next < texts.len() {
            let (name, text) = texts[next].clone();
            let document = xml::parse(&text)
                .map_err(|e| if name.is_empty() { e } else { e.in_place(&name) })?;
            for node in document
                .descendants()
                .filter(|n| ["include", "model"].contains(&n.tag_name().name()))
            {
                let Some(file) = node.attribute("file") else { continue };
                if texts.iter().any(|(known, _)| known == file) {
                    continue;
                }
                let line = document.text_pos_at(node.range().start).row;
                let place = format!("{name} line {line}");
                let fail = |problem: String, allowed: &str| {
                    SceneError::new(Path::new(""), place.trim(), problem, allowed)
                };
                let path = Path::new(file);
                if file.is_empty()
                    || path.is_absolute()
                    || file.contains("://")
                    || file.contains('\0')
                {
                    return Err(fail(format!("file=\"{file}\""), "a path relative to the file"));
                }
                if texts.len() >= MAX_FILES {
                    return Err(fail("it names too many files".to_owned(), "64 in all"));
                }
                let text = xml::file(&folder.join(path))
                    .map_err(|e| fail(format!("{file}: {}", e.problem()), e.allowed()))?;
                bytes += text.len();
                if bytes > MAX_BYTES {
                    return Err(fail(
                        format!("with {file} the files are too large"),
                        "400 MB in all",
                    ));
                }
                texts.push((file.to_owned(), text));
            }
            next += 1;
        }
        Ok(Self { folder: folder.to_path_buf(), texts })
    }

    /// The models, the one of the requested file first.
    pub(super) fn models<'a>(
        &'a self,
        documents: &'a [Document<'a>],
    ) -> Result<Vec<Model<'a>>, SceneError> {
        let roots: BTreeMap<&str, Element<'a>> = self
            .texts
            .iter()
            .zip(documents)
            .map(|((name, _), d)| (name.as_str(), Element::outermost(d, name)))
            .collect();
        let mut models = Vec::new();
        let mut number_of: BTreeMap<&str, usize> = BTreeMap::new();
        let mut queue = vec![""];
        let seen = Rc::new(Cell::new(0));
        while let Some(file) = queue.pop() {
            if number_of.contains_key(file) {
                continue;
            }
            let Some(root) = roots.get(file) else { continue };
            if root.tag() != "mujoco" {
                let problem = format!("the outermost element is <{}>", root.tag());
                return Err(root.error(problem, "<mujoco>"));
            }
            let model = Model::new(*root, &roots, &self.folder, &seen)?;
            number_of.insert(file, models.len());
            queue.extend(model.attachable.values().copied());
            models.push(model);
        }
        for model in &mut models {
            for (name, file) in &model.attachable {
                if let Some(number) = number_of.get(file) {
                    model.models.insert(name, *number);
                }
            }
        }
        Ok(models)
    }
}

/// How numbers of a file are meant.
#[derive(Clone, Copy, Debug)]
pub(super) struct Settings<'a> {
    pub(super) degrees: bool,
    /// Axes of Euler angles; capital: fixed ones.
    eulerseq: [u8; 3],
    /// Limits hold where a range is given.
    pub(super) autolimits: bool,
    /// `true`: `<inertial>` counts for nothing; `false`: shapes have no mass.
    pub(super) inertia_from_geoms: Option<bool>,
    pub(super) masses: Masses,
    mesh_folder: &'a str,
    /// Folders in the names of mesh files are ignored.
    strip_path: bool,
}

/// How masses of a file are changed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Masses {
    /// First and last group of the geoms that have a mass.
    pub(super) groups: [f32; 2],
    /// Least mass of a body [kg], and least principal moment [kg m²].
    pub(super) least: [f32; 2],
    /// Moments of which one is more than the other two together become their mean.
    pub(super) balance: bool,
    /// Mass of all bodies [kg], if above 0.
    pub(super) total: f32,
    /// A shape that is fitted to a mesh gets its box along the axes, not that of its inertia.
    pub(super) fit_box: bool,
}

/// A file as a model.
pub(super) struct Model<'a> {
    pub(super) name: &'a str,
    pub(super) root: Element<'a>,
    /// The outermost elements by their tags, those of included files among them.
    sections: BTreeMap<&'a str, Vec<Element<'a>>>,
    /// Elements that were looked at in all models, those of included files and of copies each time.
    seen: Rc<Cell<usize>>,
    files: BTreeMap<&'a str, Element<'a>>,
    pub(super) defaults: Defaults<'a>,
    pub(super) settings: Settings<'a>,
    /// Meshes by name.
    pub(super) meshes: BTreeMap<&'a str, Element<'a>>,
    /// Files of models that can be attached, by name.
    attachable: BTreeMap<&'a str, &'a str>,
    /// Numbers of those models.
    pub(super) models: BTreeMap<&'a str, usize>,
    folder: PathBuf,
}

impl<'a> Model<'a> {
    fn new(
        root: Element<'a>,
        files: &BTreeMap<&'a str, Element<'a>>,
        folder: &Path,
        seen: &Rc<Cell<usize>>,
    ) -> Result<Self, SceneError> {
        let mut model = Self {
            name: root.get("model").unwrap_or("scene"),
            root,
            sections: BTreeMap::new(),
            seen: Rc::clone(seen),
            files: files.clone(),
            defaults: Defaults::default(),
            settings: Settings {
                degrees: true,
                eulerseq: *b"xyz",
                autolimits: true,
                inertia_from_geoms: None,
                masses: Masses {
                    groups: [0.0, 5.0],
                    least: [0.0; 2],
                    balance: false,
                    total: -1.0,
                    fit_box: false,
                },
                mesh_folder: "",
                strip_path: false,
            },
            meshes: BTreeMap::new(),
            attachable: BTreeMap::new(),
            models: BTreeMap::new(),
            folder: folder.to_path_buf(),
        };
        for section in model.children(&root)? {
            model.sections.entry(section.tag()).or_default().push(section);
        }
        for compiler in model.sections("compiler").collect::<Vec<_>>() {
            model.set(&compiler)?;
        }
        let mut defaults = Defaults::default();
        for section in model.sections("default") {
            defaults.add(&section, |element| model.children(element))?;
        }
        model.defaults = defaults;
        for assets in model.sections("asset").collect::<Vec<_>>() {
            for asset in model.children(&assets)? {
                let file = asset.get("file");
                let stem = |f: &'a str| Path::new(f).file_stem().and_then(|s| s.to_str());
                let own = || match (asset.tag(), file.and_then(|f| files.get(f))) {
                    // A model without a name here goes by its own.
                    ("model", Some(root)) => root.get("model"),
                    _ => None,
                };
                let name = asset.get("name").or_else(own).or_else(|| file.and_then(stem));
                let Some(name) = name else { continue };
                match asset.tag() {
                    "mesh" => drop(model.meshes.insert(name, asset)),
                    "model" => {
                        let file = asset.need("file")?;
                        model.attachable.insert(name, file);
                    }
                    _ => {}
                }
            }
        }
        Ok(model)
    }

    /// The outermost elements of its file and of those it includes.
    pub(super) fn documents(&self) -> Vec<Element<'a>> {
        let mut out = vec![self.root];
        let mut next = 0;
        while next < out.len() {
            let mut stack = vec![out[next]];
            while let Some(element) = stack.pop() {
                let file = if element.tag() == "include" { element.get("file") } else { None };
                let included = file.and_then(|f| self.files.get(f));
                if let Some(root) = included.filter(|root| !out.contains(root)) {
                    out.push(*root);
                }
                stack.extend(element.children());
            }
            next += 1;
        }
        out
    }

    /// The sections called `tag`.
    pub(super) fn sections(&self, tag: &'static str) -> impl Iterator<Item = Element<'a>> + '_ {
        self.sections.get(tag).into_iter().flatten().copied()
    }

    /// Tags of all sections, and how many there are of each.
    pub(super) fn tags(&self) -> impl Iterator<Item = (&'a str, usize)> + '_ {
        self.sections.iter().map(|(tag, sections)| (*tag, sections.len()))
    }

    /// The elements inside one, with those of included files in the places of their `include`.
    pub(super) fn children(&self, of: &Element<'a>) -> Result<Vec<Element<'a>>, SceneError> {
        let mut out = Vec::new();
        self.gather(of, 0, &mut out)?;
        Ok(out)
    }

    /// Counts an element that is looked at.
    fn see(&self, element: &Element<'a>) -> Result<(), SceneError> {
        self.seen.set(self.seen.get() + 1);
        if self.seen.get() <= MAX_SEEN {
            return Ok(());
        }
        let problem =
            format!("with includes and copies the scene has more than {MAX_SEEN} elements here");
        Err(element.error(problem, "fewer"))
    }

    fn gather(
        &self,
        of: &Element<'a>,
        depth: usize,
        out: &mut Vec<Element<'a>>,
    ) -> Result<(), SceneError> {
        self.see(of)?;
        for child in of.children() {
            self.see(&child)?;
            if child.tag() != "include" {
                out.push(child);
                continue;
            }
            let file = child.need("file")?;
            if depth >= MAX_INCLUDES {
                return Err(child.error("files include each other without end", "16 deep"));
            }
            if let Some(root) = self.files.get(file) {
                self.gather(root, depth + 1, out)?;
            }
        }
        Ok(())
    }

    fn set(&mut self, compiler: &Element<'a>) -> Result<(), SceneError> {
        let flag = |name: &str| match compiler.get(name) {
            None => Ok(None),
            Some("true") => Ok(Some(true)),
            Some("false") => Ok(Some(false)),
            Some(_) => Err(compiler.wrong(name, "true or false")),
        };
        let settings = &mut self.settings;
        match compiler.get("angle") {
            None => {}
            Some("degree") => settings.degrees = true,
            Some("radian") => settings.degrees = false,
            Some(_) => return Err(compiler.wrong("angle", "degree or radian")),
        }
        if let Some(sequence) = compiler.get("eulerseq") {
            let axes: Option<[u8; 3]> = sequence.as_bytes().try_into().ok();
            let is_axis = |b: &u8| b"xyzXYZ".contains(b);
            match axes.filter(|a| a.iter().all(is_axis)) {
                Some(axes) => settings.eulerseq = axes,
                None => return Err(compiler.wrong("eulerseq", "three of xyzXYZ")),
            }
        }
        settings.autolimits = flag("autolimits")?.unwrap_or(settings.autolimits);
        if compiler.get("inertiafromgeom") != Some("auto") {
            settings.inertia_from_geoms = flag("inertiafromgeom")?.or(settings.inertia_from_geoms);
        }
        settings.strip_path = flag("strippath")?.unwrap_or(settings.strip_path);
        let masses = &mut settings.masses;
        masses.balance = flag("balanceinertia")?.unwrap_or(masses.balance);
        masses.fit_box = flag("fitaabb")?.unwrap_or(masses.fit_box);
        masses.groups = compiler.numbers("inertiagrouprange")?.unwrap_or(masses.groups);
        masses.total = compiler.number("settotalmass")?.unwrap_or(masses.total);
        for (least, name) in masses.least.iter_mut().zip(["boundmass", "boundinertia"]) {
            *least = compiler.at_least_zero(name)?.unwrap_or(*least);
        }
        let folder = compiler.get("meshdir").or_else(|| compiler.get("assetdir"));
        settings.mesh_folder = folder.unwrap_or(settings.mesh_folder);
        Ok(())
    }

    /// The path of a mesh file.
    pub(super) fn mesh_path(&self, file: &str) -> Result<PathBuf, String> {
        let file = file.strip_prefix("file://").unwrap_or(file).replace('\\', "/");
        let mut path = Path::new(file.as_str());
        if self.settings.strip_path {
            path = path.file_name().map_or(path, Path::new);
        }
        if file.contains("://") || file.contains('\0') {
            return Err("only files of this machine are read".to_owned());
        }
        let folder = self.settings.mesh_folder.replace('\\', "/");
        let path = Path::new(folder.as_str()).join(path);
        Ok(self.folder.join(path))
    }

    /// An angle of the file in radians.
    pub(super) fn radians(&self, angle: f32) -> f32 {
        if self.settings.degrees { angle.to_radians() } else { angle }
    }

    /// The place of an element in the frame around it.
    pub(super) fn pose(&self, view: &View<'a>) -> Result<Pose, SceneError> {
        let position = view.vec3("pos")?.unwrap_or(Vec3::ZERO);
        Ok(Pose::new(position, self.rotation(view)?))
    }

    fn rotation(&self, view: &View<'a>) -> Result<Quat, SceneError> {
        let Some((name, at)) = view.first(&["quat", "axisangle", "xyaxes", "zaxis", "euler"])
        else {
            return Ok(Quat::IDENTITY);
        };
        let zero = || at.wrong(name, "a direction that is not zero");
        match name {
            "quat" => {
                let Some([w, x, y, z]) = at.numbers::<4>(name)? else { return Ok(Quat::IDENTITY) };
                let size = (w * w + x * x + y * y + z * z).sqrt();
                if !(size > 1.0e-9 && size.is_finite()) {
                    return Err(at.wrong(name, "a quaternion that is not zero"));
                }
                Ok(Quat::new(x / size, y / size, z / size, w / size).normalized())
            }
            "axisangle" => {
                let [x, y, z, angle] = at.numbers::<4>(name)?.unwrap_or_default();
                let axis = Vec3::from([x, y, z]).try_normalize().ok_or_else(zero)?;
                Ok(Quat::from_axis_angle(axis, self.radians(angle)))
            }
            "xyaxes" => {
                let [a, b, c, d, e, f] = at.numbers::<6>(name)?.unwrap_or_default();
                let x = Vec3::from([a, b, c]).try_normalize().ok_or_else(zero)?;
                let y = Vec3::from([d, e, f]);
                let y = (y - x * x.dot(y)).try_normalize().ok_or_else(zero)?;
                Ok(Quat::from_mat3(drystone::math::Mat3 { x, y, z: x.cross(y) }))
            }
            "zaxis" => {
                let z = at.vec3(name)?.and_then(Vec3::try_normalize).ok_or_else(zero)?;
                Ok(Quat::from_arc(Vec3::Z, z))
            }
            _ => Ok(self.euler(at.numbers::<3>(name)?.unwrap_or_default())),
        }
    }

    /// A rotation by three angles, about the axes of the file's sequence.
    pub(super) fn euler(&self, angles: [f32; 3]) -> Quat {
        let mut out = Quat::IDENTITY;
        for (axis, angle) in self.settings.eulerseq.into_iter().zip(angles) {
            let about = match axis.to_ascii_lowercase() {
                b'x' => Vec3::X,
                b'y' => Vec3::Y,
                _ => Vec3::Z,
            };
            let turn = Quat::from_axis_angle(about, self.radians(angle));
            // Small: about the axes as turned so far. Capital: about those of the parent.
            out = if axis.is_ascii_lowercase() { out * turn } else { turn * out };
        }
        out.normalized()
    }
}
