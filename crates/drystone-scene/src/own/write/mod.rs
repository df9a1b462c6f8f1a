//! From a scene to a file. Values that are the engine's defaults are left out.

mod body;
mod joint;
mod names;
mod said;
mod shape;
mod strand;
mod world;

use drystone::Vec3;
use drystone::contact::ContactSoftness;

use self::names::Names;
use self::said::{layers, unless, unless_turn, unless_vec};
use super::document::{Coupling, Document, Frame, Softness, SurfaceBetween, SurfaceRule};
use super::text::VERSION;
use super::value::Ref;
use crate::error::SceneError;
use crate::scene::Scene;

/// A scene as a file.
///
/// # Errors
/// Scenes that no file can hold.
pub(super) fn document(scene: &Scene) -> Result<Document, SceneError> {
    let default = Scene::new("", "");
    let mut document = Document {
        drystone: VERSION,
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
