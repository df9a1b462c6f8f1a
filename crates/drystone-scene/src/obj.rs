//! Wavefront `.obj` files as scenes: each object is a body.

use std::io::Read;
use std::path::Path;
use std::sync::Arc;

use drystone::{BodyDef, Pose, ShapeDef, Vec3};

use crate::error::SceneError;
use crate::file::{self, Kind};
use crate::gltf::Options;
use crate::read::auto::{self, Candidate};
use crate::read::look::{self, Room};
use crate::read::mesh::Triangles;
use crate::read::obj::{Object, objects};
use crate::read::{names, stem};
use crate::scene::{Scene, SceneBody};
use crate::visual::{PlacedMesh, VisualMesh, VisualVertex, Visuals};

/// A file as read.
#[derive(Clone, Debug)]
pub struct LoadedObj {
    /// Its bodies and settings.
    pub scene: Scene,
    /// The object of each body, as its number in the file.
    pub object_of_body: Vec<usize>,
    /// Its objects, in the order of the file.
    pub(crate) objects: Vec<Object>,
}

/// Points and corners that are looked at; more are refused.
const MOST_ELEMENTS: usize = 200_000_000;

/// Reads the objects (`o`, `g`) of a file as bodies. [`Options::auto_colliders`] says what their
/// shapes are.
///
/// # Errors
/// A line that names the file, the line in it, what is wrong and what is allowed.
pub fn load(path: &Path, options: &Options) -> Result<LoadedObj, SceneError> {
    let mut file = file::open(path, Kind::Surface)?;
    let mut bytes = Vec::new();
    let io = |e: std::io::Error| SceneError::new(path, "", e, "a file that can be read");
    file.by_ref().take(4096).read_to_end(&mut bytes).map_err(io)?;
    if bytes.contains(&0) {
        return Err(not_text().in_file(path));
    }
    let bytes = file::rest(file, bytes, path, Kind::Surface)?;
    interpret(&bytes, &stem(path), options).map_err(|e| e.in_file(path))
}

/// Reads a scene from the bytes of an `.obj` file called `name`, as [`load`] does.
///
/// # Errors
/// A line that names the line in the file, what is wrong and what is allowed.
pub fn from_slice(bytes: &[u8], name: &str, options: &Options) -> Result<LoadedObj, SceneError> {
    interpret(bytes, name, options).map_err(|e| e.in_file(Path::new(name)))
}

/// The error of a film of a file called `name`: no object moves.
#[must_use]
pub fn no_film(name: &str) -> SceneError {
    error("it has no animation of nodes", "a film: keys for nodes over time")
        .in_file(Path::new(name))
}

fn error(problem: impl core::fmt::Display, allowed: &str) -> SceneError {
    SceneError::new(Path::new(""), "", problem, allowed)
}

fn not_text() -> SceneError {
    error("it is not text", "a Wavefront .obj file")
}

fn interpret(bytes: &[u8], name: &str, options: &Options) -> Result<LoadedObj, SceneError> {
    if bytes.contains(&0) {
        return Err(not_text());
    }
    let objects = objects(&String::from_utf8_lossy(bytes))?;
    if objects.is_empty() {
        return Err(error("it has no face", "lines f with at least 3 corners"));
    }
    let mut scene = Scene::new(name, "");
    scene.config.gravity = options.gravity.unwrap_or(scene.config.gravity);
    let Some(how) = options.auto_colliders else {
        let allowed = "physics in the file, or --auto-colliders hull|mesh|box";
        return Err(error("it has no physics to simulate", allowed));
    };
    check_size(&objects, if how == auto::AutoColliders::Box { 1 } else { 2 })?;
    let up = (-scene.config.gravity).normalize_or(Vec3::Y);
    let candidates: Vec<Candidate> =
        objects.iter().map(|o| Candidate::new(&placed(o), Pose::IDENTITY, up)).collect();
    let kinds = auto::kinds(&candidates);
    let mut object_of_body = Vec::new();
    let mut defs = Vec::new();
    for (number, (candidate, kind)) in candidates.into_iter().zip(kinds).enumerate() {
        let name = called(&objects, number);
        let made = match how.solid(kind) {
            None => candidate.bounds.map(|shape| vec![shape]),
            Some(solid) => placed(&objects[number])
                .shapes(solid, &name, &mut scene.notes)
                .map(|shapes| shapes.into_iter().map(ShapeDef::new).collect())
                .map_err(|e| e.problem),
        };
        match made {
            Ok(shapes) => {
                let user_data = number as u64;
                defs.push(BodyDef { user_data, ..auto::body(kind, Pose::IDENTITY, shapes) });
                object_of_body.push(number);
            }
            // Decoration without volume is common in such files; it is no reason to refuse them.
            Err(why) => scene.notes.push(format!("{name}: left out: {why}")),
        }
    }
    if defs.is_empty() {
        return Err(error("it has no body", "at least one object with a volume"));
    }
    scene.summary = auto::summary(defs.iter());
    let names = names::unique(&object_of_body, |number| called(&objects, number));
    for (name, def) in names.into_iter().zip(defs) {
        def.validate().map_err(|e| {
            let problem = format!("{} of its body is {}", e.field(), e.value());
            SceneError::new(Path::new(""), &format!("object {name}"), problem, e.allowed())
        })?;
        scene.bodies.push(SceneBody { name, def });
    }
    Ok(LoadedObj { scene, object_of_body, objects })
}

/// Refuses a file of which more is looked at than there is time for. Each of `passes` looks at all.
fn check_size(objects: &[Object], passes: usize) -> Result<(), SceneError> {
    let size = |o: &Object| o.surface.points.len() + 3 * o.surface.triangles.len();
    if passes * objects.iter().map(size).sum::<usize>() <= MOST_ELEMENTS {
        return Ok(());
    }
    let problem = format!("more than {MOST_ELEMENTS} vertices and corners are read");
    Err(error(problem, "fewer or simpler objects"))
}

/// The name of an object: its own, or `#number`.
fn called(objects: &[Object], number: usize) -> String {
    match objects[number].name.as_str() {
        "" => format!("#{number}"),
        name => name.to_owned(),
    }
}

/// The triangles of an object in the world, where no coordinate is -0.
fn placed(object: &Object) -> Triangles {
    let mut surface = object.surface.clone();
    surface.points.iter_mut().for_each(|p| *p += Vec3::ZERO);
    surface
}

impl LoadedObj {
    /// Takes the objects into [`Scene::visuals`] as meshes without materials; a note says which are
    /// left out. They have no part in the simulation.
    pub fn read_visuals(&mut self) {
        let mut visuals = Visuals::default();
        let mut room = Room::default();
        for (number, object) in self.objects.iter().enumerate() {
            let mesh = match drawn(object, &mut room) {
                Ok(mesh) => mesh,
                Err(why) => {
                    let name = called(&self.objects, number);
                    self.scene.notes.push(format!("{name}: not drawn: it {why}"));
                    continue;
                }
            };
            let placed = PlacedMesh { mesh: visuals.meshes.len(), pose: Pose::IDENTITY };
            visuals.meshes.push(mesh);
            // Numbers of objects rise with those of bodies.
            if self.object_of_body.binary_search(&number).is_ok() {
                visuals.worn.entry(number as u64).or_default().push(placed);
            } else {
                visuals.scenery.push(placed);
            }
        }
        self.scene.visuals = Arc::new(visuals);
    }
}

/// The mesh that shows an object, if there is room for it.
fn drawn(object: &Object, room: &mut Room) -> Result<VisualMesh, String> {
    let corners = 3 * object.surface.triangles.len();
    let refused = |problem: String| format!("{problem}, expected {}", look::ALLOWED);
    // Before it takes memory.
    room.check(look::size(object.surface.points.len(), corners)).map_err(refused)?;
    room.check(corners).map_err(refused)?;
    let Triangles { points, triangles } = placed(object);
    let vertex = |p: &Vec3| VisualVertex {
        place: p.to_array(),
        normal: [0.0; 3],
        uv: [0.0; 2],
        color: [1.0; 4],
    };
    let vertices: Vec<VisualVertex> = points.iter().map(vertex).collect();
    let mesh = look::flat(&vertices, &triangles, None);
    room.add(&mesh);
    Ok(mesh)
}
