//! Scenes of Rigid-IPC: JSON with a list of bodies, each a mesh beside the file or in a folder
//! `meshes` above it [Ferguson21].
//!
//! Read: gravity, friction, restitution, time step and length. For each body: mesh (or `vertices`
//! and `faces`), position, rotation, scale or dimensions, velocities, density, fixed directions,
//! type, group, lasting force and torque. Convex meshes become hulls. Others stay meshes if they
//! stand, and are decomposed if they move. Sheets that move get a thickness. Settings of the
//! format's solver have no use here and are listed in the notes.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

use drystone::{AxisLocks, BodyDef, BodyKind, Filter, Material, Quat, Shape, ShapeDef, Vec3, vec3};

use crate::error::SceneError;
use crate::read::json::{self, At};
use crate::read::mesh::{NoSolid, Triangles};
use crate::read::{UTF8, obj, stem, text};
use crate::scene::{Load, Scene, Script};

/// Part of its smaller side that a sheet which moves is thick.
const THICKNESS: f32 = 0.01;

/// Corners and triangles of the meshes of all bodies together; a scene with more is refused.
const MOST_CORNERS: usize = 100_000_000;

/// Bodies of one group do not collide with each other; each group takes a layer.
const MOST_GROUPS: usize = 62;

/// Reads a `.json` file.
///
/// # Errors
/// A line that names the file, the place in it, what is wrong and what is allowed.
pub fn load(path: &Path) -> Result<Scene, SceneError> {
    let text = text(path, UTF8)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    from_text(&text, &stem(path), folder).map_err(|e| e.in_file(path))
}

/// Reads a scene called `name` from the text of a `.json` file that stands in `folder`.
///
/// # Errors
/// A line that names the place in the file, what is wrong and what is allowed.
pub fn from_text(text: &str, name: &str, folder: &Path) -> Result<Scene, SceneError> {
    let value = json::parse(text.as_bytes())?;
    let root = At::root(&value).object()?;
    let problem = root.need("rigid_body_problem")?.object()?;
    let mut reader = Reader {
        folder,
        meshes: BTreeMap::new(),
        files: BTreeMap::new(),
        corners: 0,
        groups: Vec::new(),
    };
    let mut scene = Scene::new(name, "");
    scene.config.gravity = problem.vec3_or("gravity", Vec3::ZERO)?;
    // The format has no sleep, and a body that barely slides begins more slowly than one that
    // sleeps.
    scene.config.sleep.enabled = false;
    if let Some(step) = root.get("timestep") {
        let hz = 1.0 / step.above_zero()?;
        if !(1.0..=1.0e5).contains(&hz) {
            return Err(step.wrong("0.00001 to 1 [s]"));
        }
        scene.hz = hz;
    }
    if let Some(seconds) = root.get("max_time") {
        scene.seconds = seconds.above_zero()?;
        if scene.seconds > 1.0e9 {
            return Err(seconds.wrong("up to 1e9 [s]"));
        }
    }
    let material = material(&problem)?;
    let mut loads = Vec::new();
    let bodies = problem.need("rigid_bodies")?.items()?;
    for (i, at) in bodies.iter().enumerate() {
        let (def, load) = reader.body(at, material, &mut scene.notes)?;
        loads.extend(load.map(|(force, torque)| Load { body: i, force, torque }));
        scene.add(format!("#{i}"), def);
    }
    if !loads.is_empty() {
        scene.script = Script::Loads { from: 0, loads };
    }
    ignored(&root, &problem, &bodies, &mut scene.notes);
    let moving = scene.bodies.iter().filter(|b| b.def.kind == BodyKind::Dynamic).count();
    scene.summary = format!("{moving} moving bodies of {}", scene.bodies.len());
    Ok(scene)
}

/// The surface of all bodies.
fn material(problem: &At<'_>) -> Result<Material, SceneError> {
    let friction = problem.get("coefficient_friction").map_or(Ok(0.0), |f| f.at_least_zero())?;
    let restitution = match problem.get("coefficient_restitution") {
        None => 0.0,
        // -1: the file leaves impacts to its own solver, which takes their energy.
        Some(e) => match e.f32()? {
            v if v < 0.0 => 0.0,
            v if v <= 1.0 => v,
            _ => return Err(e.wrong("a number up to 1, or -1")),
        },
    };
    Ok(Material { friction, restitution, ..Material::default() })
}

/// Keys of the file, of its problem and of its bodies that are read. Others are noted; a key that
/// begins with # is a remark.
const ROOT: [&str; 5] = ["scene_type", "rigid_body_problem", "timestep", "max_time", "name"];
const PROBLEM: [&str; 4] =
    ["gravity", "coefficient_friction", "coefficient_restitution", "rigid_bodies"];
const BODY: [&str; 16] = [
    "mesh",
    "vertices",
    "faces",
    "edges",
    "position",
    "rotation",
    "scale",
    "dimensions",
    "linear_velocity",
    "angular_velocity",
    "density",
    "is_dof_fixed",
    "type",
    "group_id",
    "force",
    "torque",
];

fn ignored(root: &At<'_>, problem: &At<'_>, bodies: &[At<'_>], notes: &mut Vec<String>) {
    let mut count = |all: &mut dyn Iterator<Item = &At<'_>>, known: &[&str], place: &str| {
        let mut unknown: BTreeMap<String, usize> = BTreeMap::new();
        for key in all.flat_map(At::keys) {
            if !known.contains(&key) && !key.starts_with('#') {
                *unknown.entry(key.to_owned()).or_default() += 1;
            }
        }
        for (key, n) in unknown {
            let often = if n > 1 { format!(", {n} times") } else { String::new() };
            notes.push(format!("{place}{key}: not used{often}"));
        }
    };
    count(&mut core::iter::once(root), &ROOT, "");
    count(&mut core::iter::once(problem), &PROBLEM, "rigid_body_problem.");
    count(&mut bodies.iter(), &BODY, "rigid_bodies[].");
}

/// A mesh at a scale, for what moves or for what stands.
type Key = (String, [u32; 3], bool);

struct Reader<'a> {
    folder: &'a Path,
    meshes: BTreeMap<Key, Vec<ShapeDef>>,
    /// Mesh files as they are.
    files: BTreeMap<String, Triangles>,
    /// Corners of meshes that were looked at so far.
    corners: usize,
    groups: Vec<i64>,
}

/// A lasting force [N] and torque [N m].
type Push = (Vec3, Vec3);

impl Reader<'_> {
    fn body(
        &mut self,
        at: &At<'_>,
        material: Material,
        notes: &mut Vec<String>,
    ) -> Result<(BodyDef, Option<Push>), SceneError> {
        let fixed = fixed(at)?;
        let kind = match at.get("type") {
            _ if fixed == [true; 6] => BodyKind::Static,
            None => BodyKind::Dynamic,
            Some(kind) => match kind.text()? {
                "static" => BodyKind::Static,
                "kinematic" => BodyKind::Kinematic,
                "dynamic" => BodyKind::Dynamic,
                _ => return Err(kind.wrong("\"static\", \"kinematic\" or \"dynamic\"")),
            },
        };
        let density = at.get("density").map_or(Ok(1000.0), |d| d.above_zero())?;
        let filter = self.filter(at, notes)?;
        let mut shapes = self.shapes(at, kind == BodyKind::Dynamic, notes)?;
        for shape in &mut shapes {
            *shape = shape.clone().with_material(material).with_density(density);
            shape.filter = filter;
        }
        let degrees = |key: &str| -> Result<Vec3, SceneError> {
            Ok(at.vec3_or(key, Vec3::ZERO)? * (core::f32::consts::PI / 180.0))
        };
        let turn = degrees("rotation")?;
        // About the body's own x, then y, then z as they were.
        let rotation = Quat::from_axis_angle(Vec3::Z, turn.z)
            * Quat::from_axis_angle(Vec3::Y, turn.y)
            * Quat::from_axis_angle(Vec3::X, turn.x);
        let mut def = BodyDef { kind, shapes, ..BodyDef::dynamic() };
        (def.position, def.rotation) = (at.vec3_or("position", Vec3::ZERO)?, rotation);
        let (force, mut torque) = (at.vec3_or("force", Vec3::ZERO)?, Vec3::ZERO);
        if kind != BodyKind::Static {
            let (v, w) = (at.vec3_or("linear_velocity", Vec3::ZERO)?, degrees("angular_velocity")?);
            (def.linear_velocity, def.angular_velocity) = (v, w);
            // As the format has it, in degrees too.
            torque = degrees("torque")?;
        }
        if kind == BodyKind::Dynamic {
            let [x, y, z, a, b, c] = fixed;
            def.locks = AxisLocks { linear: [x, y, z], angular: [a, b, c] };
        }
        let pushed = kind == BodyKind::Dynamic && (force != Vec3::ZERO || torque != Vec3::ZERO);
        Ok((def, pushed.then_some((force, torque))))
    }

    fn filter(&mut self, at: &At<'_>, notes: &mut Vec<String>) -> Result<Filter, SceneError> {
        let Some(group) = at.get("group_id") else { return Ok(Filter::default()) };
        #[expect(clippy::cast_possible_truncation, reason = "names of groups")]
        let number = group.f32()? as i64;
        if number < 0 {
            return Ok(Filter::default());
        }
        let place = self.groups.iter().position(|g| *g == number).unwrap_or_else(|| {
            if self.groups.len() < MOST_GROUPS {
                self.groups.push(number);
                return self.groups.len() - 1;
            }
            MOST_GROUPS
        });
        if place >= MOST_GROUPS {
            notes.push(format!("{}: groups beyond {MOST_GROUPS} collide", group.place()));
            return Ok(Filter::default());
        }
        let layer = 2 << place;
        Ok(Filter { layers: 1 | layer, exclude: layer, ..Filter::default() })
    }

    fn shapes(
        &mut self,
        at: &At<'_>,
        moves: bool,
        notes: &mut Vec<String>,
    ) -> Result<Vec<ShapeDef>, SceneError> {
        let mesh = at.get("mesh").unwrap_or_else(|| at.clone());
        let file = if at.get("mesh").is_some() { mesh.text()? } else { "" };
        let mut triangles = if file.is_empty() { inline(at)? } else { self.read(file, &mesh)? };
        self.corners += triangles.points.len() + triangles.triangles.len();
        if self.corners > MOST_CORNERS {
            let problem = format!("brings all meshes to more than {MOST_CORNERS} corners");
            return Err(mesh.error(problem, "fewer bodies or simpler meshes"));
        }
        let scale = scale(at, &triangles)?;
        let key = (file.to_owned(), scale.to_array().map(f32::to_bits), moves);
        if !file.is_empty()
            && let Some(shapes) = self.meshes.get(&key)
        {
            return Ok(shapes.clone());
        }
        for point in &mut triangles.points {
            *point = point.mul_each(scale);
        }
        let shapes = collider(triangles, &mesh, moves, notes)?;
        self.meshes.insert(key, shapes.clone());
        Ok(shapes)
    }

    fn read(&mut self, file: &str, at: &At<'_>) -> Result<Triangles, SceneError> {
        if let Some(known) = self.files.get(file) {
            return Ok(known.clone());
        }
        let path = self.find(file).ok_or_else(|| {
            let allowed = "an .obj file beside the scene or in a folder meshes above it";
            at.error(format!("there is no file \"{file}\""), allowed)
        })?;
        let inner = |e: SceneError| at.error(format!("{file}: {} {}", e.place(), e.problem()), "");
        let text = text(&path, UTF8).map_err(inner)?;
        let triangles = obj::surface(&text).map_err(inner)?;
        self.files.insert(file.to_owned(), triangles.clone());
        Ok(triangles)
    }

    /// A mesh file beside the scene, or in a folder `meshes` beside or above it.
    fn find(&self, file: &str) -> Option<PathBuf> {
        let relative = Path::new(file);
        let plain = |c: Component<'_>| matches!(c, Component::Normal(_) | Component::CurDir);
        if relative.extension().is_none_or(|e| !e.eq_ignore_ascii_case("obj"))
            || !relative.components().all(plain)
        {
            return None;
        }
        let folder = self.folder.canonicalize().unwrap_or_else(|_| self.folder.to_owned());
        let above = folder.ancestors().map(|f| f.join("meshes").join(relative));
        core::iter::once(folder.join(relative)).chain(above).find(|path| path.is_file())
    }
}

/// Six directions, or one word for all.
fn fixed(at: &At<'_>) -> Result<[bool; 6], SceneError> {
    let Some(fixed) = at.get("is_dof_fixed") else { return Ok([false; 6]) };
    if let Ok(all) = fixed.bool() {
        return Ok([all; 6]);
    }
    let wrong = || fixed.wrong("true, false, or a list of 6 of them");
    let items = fixed.items().map_err(|_| wrong())?;
    if items.len() != 6 {
        return Err(wrong());
    }
    let mut out = [false; 6];
    for (o, item) in out.iter_mut().zip(&items) {
        *o = item.bool()?;
    }
    Ok(out)
}

/// Vertices and faces in the file itself.
fn inline(at: &At<'_>) -> Result<Triangles, SceneError> {
    let mut triangles = Triangles::default();
    for vertex in at.list("vertices")? {
        triangles.points.push(vertex.vec3()?);
    }
    if triangles.points.is_empty() {
        return Err(at.error("it has no shape", "a mesh, or vertices and faces"));
    }
    for face in at.list("faces")? {
        let corners = face.items()?;
        let [a, b, c] = corners.as_slice() else { return Err(face.wrong("a list of 3")) };
        let mut triangle = [0; 3];
        for (t, corner) in triangle.iter_mut().zip([a, b, c]) {
            let i = corner.index(triangles.points.len(), "vertices")?;
            *t = u32::try_from(i).map_err(|_| corner.wrong("below 2³²"))?;
        }
        triangles.triangles.push(triangle);
    }
    Ok(triangles)
}

fn bounds(points: &[Vec3]) -> (Vec3, Vec3) {
    let first = points.first().copied().unwrap_or(Vec3::ZERO);
    points.iter().fold((first, first), |(low, high), p| (low.min(*p), high.max(*p)))
}

/// How the mesh is stretched about its origin: by `dimensions`, which its box is to have, or by
/// `scale`.
fn scale(at: &At<'_>, triangles: &Triangles) -> Result<Vec3, SceneError> {
    if let Some(dimensions) = at.get("dimensions") {
        let (low, high) = bounds(&triangles.points);
        let (wanted, size) = (dimensions.vec3()?, high - low);
        // A sheet has no thickness to stretch.
        let ratio = |wanted: f32, size: f32| if size > 0.0 { wanted / size } else { 1.0 };
        return Ok(vec3(ratio(wanted.x, size.x), ratio(wanted.y, size.y), ratio(wanted.z, size.z)));
    }
    match at.get("scale") {
        None => Ok(Vec3::ONE),
        Some(scale) => match scale.f32() {
            Ok(all) => Ok(Vec3::splat(all)),
            Err(_) => scale.vec3().map_err(|_| scale.wrong("a number or a list of 3 numbers")),
        },
    }
}

/// The shapes of a mesh on a body that moves or stands.
fn collider(
    triangles: Triangles,
    at: &At<'_>,
    moves: bool,
    notes: &mut Vec<String>,
) -> Result<Vec<ShapeDef>, SceneError> {
    let refused = |e: NoSolid| at.error(e.problem, e.allowed);
    if let Some(hull) = triangles.convex() {
        return Ok(vec![ShapeDef::new(hull)]);
    }
    if !moves {
        return Ok(vec![ShapeDef::new(triangles.mesh().map_err(refused)?)]);
    }
    let (low, high) = bounds(&triangles.points);
    let size = (high - low).to_array();
    let flat =
        (0..3).filter(|i| size[*i] <= 1.0e-6 * (high - low).max_element()).collect::<Vec<_>>();
    if let [axis] = flat.as_slice() {
        let (b, c) = (size[(axis + 1) % 3], size[(axis + 2) % 3]);
        let thickness = THICKNESS * b.min(c);
        let mut half = size.map(|s| 0.5 * s);
        half[*axis] = 0.5 * thickness;
        notes.push(format!("{}: a sheet, taken as a plate {thickness} m thick", at.place()));
        let shape = Shape::box_half(half);
        shape.validate().map_err(|e| at.error(e, "a sheet with an area"))?;
        return Ok(vec![ShapeDef::new(shape).with_position((low + high) * 0.5)]);
    }
    let (shapes, note) = triangles.hulls().map_err(refused)?;
    notes.push(format!("{}: its mesh is {note}", at.place()));
    Ok(shapes.into_iter().map(ShapeDef::new).collect())
}
