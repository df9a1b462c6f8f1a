//! Meshes: their hulls, their masses, and the shapes that are fitted to them.

use std::collections::BTreeMap;
use std::rc::Rc;

use drystone::geometry::MassProperties;
use drystone::math::Mat3;
use drystone::{Pose, Quat, Shape, Vec3, vec3};

use super::defaults::View;
use super::model::Model;
use crate::error::SceneError;
use crate::links::Hulls;
use crate::read::mesh::{Triangles, hull_of_points};
use crate::read::volume::Filling;

/// Most numbers of a list of corners.
const MOST: usize = 3_000_000;

/// A mesh.
#[derive(Debug)]
pub(super) struct Mesh {
    pub(super) hull: Shape,
    /// Its mass at a density of 1.
    pub(super) weight: MassProperties,
    /// Approximations that were made of it.
    pub(super) note: Option<String>,
    points: Vec<Vec3>,
}

/// Meshes of all models, each made once.
#[derive(Default)]
pub(super) struct Meshes<'a> {
    /// By what names them, the file and the element's name there.
    made: BTreeMap<(&'a str, &'a str), Result<Rc<Mesh>, String>>,
    files: Hulls,
}

impl<'a> Meshes<'a> {
    /// The mesh that a geom names, or why there is none.
    pub(super) fn named(
        &mut self,
        view: &View<'a>,
        model: &Model<'a>,
    ) -> Result<Result<Rc<Mesh>, String>, SceneError> {
        let Some(name) = view.get("mesh") else {
            if view.get("type") != Some("mesh") {
                return Ok(Err("it names no mesh".to_owned()));
            }
            return Err(view.element().error("it names no mesh", "mesh=\"…\""));
        };
        let Some((&name, asset)) = model.meshes.get_key_value(name) else {
            return Err(view.wrong("mesh", "a mesh of <asset>"));
        };
        let key = (model.root.file(), name);
        if let Some(made) = self.made.get(&key) {
            return Ok(made.clone());
        }
        let asset = model.defaults.view(*asset, None)?;
        let made = match surface(&asset, model, &mut self.files)? {
            Ok(surface) => Mesh::new(surface, &asset)?,
            Err(why) => Err(why),
        };
        let made = made.map(Rc::new).map_err(|why| format!("mesh {name}: {why}"));
        self.made.insert(key, made.clone());
        Ok(made)
    }
}

/// Triangles of a mesh, or why there are none.
fn surface<'a>(
    asset: &View<'a>,
    model: &Model<'a>,
    files: &mut Hulls,
) -> Result<Result<Triangles, String>, SceneError> {
    let scale = asset.vec3("scale")?.unwrap_or(Vec3::splat(1.0));
    let mut surface = if asset.get("vertex").is_some() {
        corners(asset)?
    } else {
        let Some(file) = asset.get("file") else {
            return Ok(Err("it is neither of corners nor of a file".to_owned()));
        };
        match model.mesh_path(file).and_then(|path| files.surface(&path)) {
            Ok(surface) => surface,
            Err(why) => return Ok(Err(format!("{file}: {why}"))),
        }
    };
    let origin = asset.vec3("refpos")?.unwrap_or(Vec3::ZERO);
    let [w, x, y, z] = asset.numbers::<4>("refquat")?.unwrap_or([1.0, 0.0, 0.0, 0.0]);
    let length = (w * w + x * x + y * y + z * z).sqrt();
    if !(length > 1.0e-9 && length.is_finite()) {
        return Err(asset.wrong("refquat", "a quaternion that is not zero"));
    }
    let is_moved = asset.get("refpos").is_some() || asset.get("refquat").is_some();
    let own = Quat::new(x / length, y / length, z / length, w / length);
    for point in &mut surface.points {
        if is_moved {
            *point = own.conjugate().rotate(*point - origin);
        }
        *point = point.mul_each(scale);
    }
    Ok(Ok(surface))
}

/// Corners, and faces if there are some, that the file itself lists.
fn corners(asset: &View<'_>) -> Result<Triangles, SceneError> {
    let numbers = asset.list("vertex", MOST)?;
    if !numbers.len().is_multiple_of(3) {
        return Err(asset.wrong("vertex", "three numbers for each corner"));
    }
    let points: Vec<Vec3> = numbers.chunks_exact(3).map(|c| vec3(c[0], c[1], c[2])).collect();
    let words: Vec<&str> = asset.get("face").unwrap_or_default().split_whitespace().collect();
    let known = |word: &&str| word.parse::<u32>().ok().filter(|i| (*i as usize) < points.len());
    let indices: Vec<u32> = words.iter().filter_map(known).collect();
    if indices.len() != words.len() || !indices.len().is_multiple_of(3) {
        return Err(asset.wrong("face", "three numbers of corners for each face"));
    }
    let triangles = indices.chunks_exact(3).map(|f| [f[0], f[1], f[2]]).collect();
    Ok(Triangles { points, triangles })
}

impl Mesh {
    /// The mesh of a surface with the mass that the asset asks for, or why there is none.
    fn new(surface: Triangles, asset: &View<'_>) -> Result<Result<Self, String>, SceneError> {
        let filling = match asset.get("inertia") {
            // Corners without faces are their hull.
            _ if surface.triangles.is_empty() => None,
            None | Some("legacy") => Some(Filling::Legacy),
            Some("exact") => Some(Filling::Exact),
            Some("shell") => Some(Filling::Shell),
            Some("convex") => None,
            Some(_) => return Err(asset.wrong("inertia", "legacy, exact, convex or shell")),
        };
        let hull = match hull_of_points(&surface.points) {
            Ok(hull) => hull,
            Err(why) => return Ok(Err(why)),
        };
        let whole = MassProperties::of(&hull, 1.0);
        let own = filling.map(|filling| surface.mass(filling));
        // An exact volume of a surface with holes can be anything.
        let note = matches!(own, Some(None))
            .then(|| "a mesh without a volume of its own weighs as its hull".to_owned());
        let weight = own.flatten().unwrap_or(whole);
        Ok(Ok(Self { hull, weight, note, points: surface.points }))
    }

    /// Half sizes and place of a primitive that is fitted to it: the box of equal inertia, or with
    /// `by_box` the box around it along its principal axes; the longest is z. For round shapes x is
    /// the radius and z half the straight part.
    pub(super) fn fitted(&self, kind: &str, by_box: bool) -> (Vec3, Pose) {
        let (moments, turn) = self.weight.inertia.eigen();
        let axes = turn.to_mat3();
        let mut sorted = [(moments.x, axes.x), (moments.y, axes.y), (moments.z, axes.z)];
        sorted.sort_by(|a, b| b.0.total_cmp(&a.0));
        let [(a, x), (b, y), (c, _)] = sorted;
        let turn = Quat::from_mat3(Mat3 { x, y, z: x.cross(y) }).normalized();
        let frame = Pose::new(self.weight.center, turn);
        if by_box {
            return self.around(kind, &frame);
        }
        let half = |sum: f32| 0.5 * (6.0 * sum.max(0.0) / self.weight.mass).sqrt();
        let size = vec3(half(b + c - a), half(a + c - b), half(a + b - c));
        let across = 0.5 * (size.x + size.y);
        let half = match kind {
            "sphere" => Vec3::splat((size.x + size.y + size.z) / 3.0),
            "capsule" => vec3(across, across, (size.z - 0.5 * across).max(0.0)),
            "cylinder" => vec3(across, across, size.z),
            _ => size,
        };
        (half, frame)
    }

    /// A primitive of the size of the box around all corners, as MuJoCo takes it: a ball has its
    /// largest side, other round shapes the larger one across.
    fn around(&self, kind: &str, frame: &Pose) -> (Vec3, Pose) {
        let local = || self.points.iter().map(|p| frame.local_point(*p));
        let first = local().next().unwrap_or(Vec3::ZERO);
        let (low, high) = local().fold((first, first), |(l, h), p| (l.min(p), h.max(p)));
        let (center, half) = ((low + high) * 0.5, (high - low) * 0.5);
        let radius = half.x.max(half.y);
        let half = match kind {
            "sphere" => Vec3::splat(half.max_element()),
            "capsule" => vec3(radius, radius, (half.z - radius).max(0.0)),
            "cylinder" => vec3(radius, radius, half.z),
            _ => half,
        };
        (half, Pose::new(frame.point(center), frame.rotation))
    }
}
