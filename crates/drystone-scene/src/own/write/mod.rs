//! From a scene to a file. What is as the engine has it by default is left out.

mod body;
mod joint;
mod strand;
mod world;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use drystone::contact::ContactSoftness;
use drystone::{Pose, Quat, Shape, Vec3};

use super::document::{
    Coupling, Document, Frame, Layer, Material, Softness, SurfaceBetween, SurfaceRule,
};
use super::value::{Or, Ref, Triple, Turn};
use crate::error::SceneError;
use crate::scene::{Scene, SceneBody};

/// A number that is not the default.
fn unless(value: f32, default: f32) -> Option<f32> {
    (value.to_bits() != default.to_bits()).then_some(value)
}

/// A vector that is not the default; zeros have signs.
fn unless_vec(value: Vec3, default: Vec3) -> Option<Triple> {
    let bits = |v: Vec3| v.to_array().map(f32::to_bits);
    (bits(value) != bits(default)).then(|| value.to_array())
}

/// A turn that is not none.
fn unless_turn(value: Quat) -> Option<Turn> {
    let bits = |q: Quat| q.to_array().map(f32::to_bits);
    (bits(value) != bits(Quat::IDENTITY)).then(|| Turn::Quaternion(value.to_array()))
}

/// Any other value that is not the default.
fn other<T: PartialEq>(value: T, default: &T) -> Option<T> {
    (value != *default).then_some(value)
}

fn refuse(place: &str, problem: impl core::fmt::Display, allowed: &str) -> SceneError {
    SceneError::new(Path::new(""), place, problem, allowed)
}

/// Layers by their numbers.
fn layers(bits: u64) -> Vec<Layer> {
    (0..64_u8).filter(|bit| bits >> bit & 1 == 1).map(Layer::Number).collect()
}

/// What is named in the file, so that it stands there once.
#[derive(Default)]
struct Names {
    /// Geometry that several shapes share, by its address.
    shapes: BTreeMap<usize, String>,
    /// Materials that several shapes have, by their bits.
    materials: BTreeMap<[u32; 9], String>,
    /// Names of bodies, by their numbers.
    bodies: Vec<String>,
}

/// The address of what shapes can share.
fn address(shape: &Shape) -> Option<usize> {
    match shape {
        Shape::Hull(hull) => Some(Arc::as_ptr(hull).cast::<()>() as usize),
        Shape::Mesh(mesh) => Some(Arc::as_ptr(mesh).cast::<()>() as usize),
        _ => None,
    }
}

impl Names {
    /// A reference to a body.
    fn body(&self, number: usize) -> Ref {
        self.bodies.get(number).map_or(Ref::Number(number), |name| Ref::Name(name.clone()))
    }

    /// Names what stands in a scene more than once; fills the tables of the file.
    fn of(scene: &Scene, document: &mut Document) -> Result<Self, SceneError> {
        let mut names = Self::default();
        let mut taken = BTreeMap::new();
        for SceneBody { name, .. } in scene.bodies.iter().chain(scene.script.joining()) {
            if taken.insert(name.as_str(), ()).is_some() {
                let problem = format!("two bodies are called '{name}'");
                return Err(refuse("bodies", problem, "a name of its own for each body"));
            }
            names.bodies.push(name.clone());
        }
        let mut uses: BTreeMap<usize, (usize, &Shape)> = BTreeMap::new();
        let mut order = Vec::new();
        let mut surfaces: BTreeMap<[u32; 9], usize> = BTreeMap::new();
        let mut kinds = Vec::new();
        for body in scene.bodies.iter().chain(scene.script.joining()) {
            for shape in &body.def.shapes {
                if let Some(address) = address(&shape.shape) {
                    let entry = uses.entry(address).or_insert((0, &shape.shape));
                    entry.0 += 1;
                    if entry.0 == 1 {
                        order.push(address);
                    }
                }
                let key = body::material_key(&shape.material);
                let count = surfaces.entry(key).or_default();
                *count += 1;
                if *count == 1 {
                    kinds.push((key, shape.material));
                }
            }
        }
        for address in order {
            let shared = uses.get(&address).filter(|(count, _)| *count > 1);
            let Some((_, shape)) = shared else { continue };
            let name = format!("{} {}", shape.kind(), names.shapes.len() + 1);
            document.shapes.0.push((name.clone(), body::geometry(shape)?));
            names.shapes.insert(address, name);
        }
        let plain = body::material_key(&drystone::Material::default());
        for (key, material) in kinds {
            if key == plain || surfaces.get(&key).is_none_or(|count| *count < 2) {
                continue;
            }
            let name = format!("material {}", names.materials.len() + 1);
            document.materials.0.push((name.clone(), body::material(&material)));
            names.materials.insert(key, name);
        }
        Ok(names)
    }

    fn material(&self, material: &drystone::Material) -> Option<Or<Material>> {
        let key = body::material_key(material);
        if key == body::material_key(&drystone::Material::default()) {
            return None;
        }
        Some(match self.materials.get(&key) {
            Some(name) => Or::Name(name.clone()),
            None => Or::Here(body::material(material)),
        })
    }
}

/// A scene as a file.
///
/// # Errors
/// What no file can say.
pub(super) fn document(scene: &Scene) -> Result<Document, SceneError> {
    let default = Scene::new("", "");
    let mut document = Document {
        drystone: super::VERSION,
        name: Some(scene.name.clone()),
        summary: (!scene.summary.is_empty()).then(|| scene.summary.clone()),
        hz: unless(scene.hz, default.hz),
        seconds: unless(scene.seconds, default.seconds),
        world: world::world(&scene.config),
        ..Document::default()
    };
    let names = Names::of(scene, &mut document)?;
    for body in &scene.bodies {
        document.bodies.push(names.write_body(body)?);
    }
    for joint in &scene.joints {
        document.joints.push(names.joint(joint)?);
    }
    for coupling in &scene.couplings {
        let joint = |number: usize| {
            let name = scene.joints.get(number).map(|joint| joint.name.clone());
            match name.filter(|name| !name.is_empty()) {
                Some(name) => Ref::Name(name),
                None => Ref::Number(number),
            }
        };
        document.couplings.push(Coupling {
            joint_a: joint(coupling.joint_a),
            axis_a: joint::axis_name(coupling.axis_a),
            joint_b: joint(coupling.joint_b),
            axis_b: joint::axis_name(coupling.axis_b),
            ratio: coupling.ratio,
            offset: unless(coupling.offset, 0.0),
        });
    }
    for strand in &scene.strands {
        document.strands.push(names.strand(strand)?);
    }
    for frame in &scene.frames {
        document.frames.push(Frame {
            name: frame.name.clone(),
            body: names.body(frame.body),
            position: unless_vec(frame.pose.position, Vec3::ZERO),
            rotation: unless_turn(frame.pose.rotation),
            center: unless_vec(frame.center, frame.pose.position),
        });
    }
    document.never_collide =
        scene.never_collide.iter().map(|pair| pair.map(|body| names.body(body))).collect();
    for rule in &scene.surface_rules {
        document.surface_rules.push(SurfaceRule {
            first: layers(rule.first),
            second: layers(rule.second),
            friction: rule.friction,
            kinetic_friction: rule.kinetic_friction,
            restitution: rule.restitution,
            softness: rule.softness.map(softness_of),
        });
    }
    for (bodies, rule) in &scene.surfaces_between {
        document.surfaces_between.push(SurfaceBetween {
            bodies: bodies.map(|body| names.body(body)),
            friction: rule.friction,
            kinetic_friction: rule.kinetic_friction,
            restitution: rule.restitution,
            softness: rule.softness.map(softness_of),
        });
    }
    document.script = names.script(&scene.script)?;
    Ok(document)
}

const fn softness_of(softness: ContactSoftness) -> Softness {
    Softness { hertz: softness.hertz, damping_ratio: softness.damping_ratio }
}

/// A pose in its two parts.
fn parts(pose: &Pose) -> (Option<Triple>, Option<Turn>) {
    (unless_vec(pose.position, Vec3::ZERO), unless_turn(pose.rotation))
}
