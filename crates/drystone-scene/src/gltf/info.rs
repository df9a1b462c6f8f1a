//! A summary of a file for people, with everything that was not read.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use drystone::joint::{JointMotion, SixDof};
use drystone::{BodyKind, JointKind, MassDef, Shape};

use super::loaded::LoadedGltf;

/// Describes the axes of a joint, those with the same motion together.
fn axes_of(axes: &SixDof) -> String {
    let all = axes.linear.iter().chain(&axes.angular);
    let mut groups: Vec<(String, String)> = Vec::new();
    for (name, axis) in ["x", "y", "z", "turn x", "turn y", "turn z"].into_iter().zip(all) {
        let motion = match axis.motion {
            JointMotion::Locked => "locked".to_owned(),
            JointMotion::Free => "free".to_owned(),
            JointMotion::Limited { min, max, spring } => {
                format!("{} to {}{}", min, max, if spring.is_some() { " (spring)" } else { "" })
            }
        };
        let driven = if axis.drive.is_some() { ", driven" } else { "" };
        let what = motion + driven + if axis.friction > 0.0 { ", with friction" } else { "" };
        match groups.iter_mut().find(|(said, _)| *said == what) {
            Some((_, names)) => names.push_str(&format!(", {name}")),
            None => groups.push((what, name.to_owned())),
        }
    }
    let mut out: Vec<String> =
        groups.iter().map(|(what, names)| format!("{names} {what}")).collect();
    if let Some(cone) = axes.cone {
        out.push(format!("x within a cone of {} by {} rad", cone.swing[0], cone.swing[1]));
    }
    out.join("; ")
}

/// A text for people: bodies, shapes, settings, and a line for everything that was left out,
/// changed or approximated.
#[must_use]
pub fn info(loaded: &LoadedGltf) -> String {
    let scene = &loaded.scene;
    let mut out = String::new();
    let g = scene.config.gravity;
    let count = |kind| scene.bodies.iter().filter(|b| b.def.kind == kind).count();
    // Writing to a String cannot fail.
    let _ = writeln!(out, "{}", scene.name);
    let _ = writeln!(out, "gravity: {} {} {} m/s²", g.x, g.y, g.z);
    let _ = writeln!(
        out,
        "bodies: {} ({} static, {} kinematic, {} dynamic)",
        scene.bodies.len(),
        count(BodyKind::Static),
        count(BodyKind::Kinematic),
        count(BodyKind::Dynamic),
    );
    for body in &scene.bodies {
        let mut kinds: BTreeMap<(&str, bool), usize> = BTreeMap::new();
        for shape in &body.def.shapes {
            *kinds.entry((shape.shape.kind(), shape.sensor)).or_default() += 1;
        }
        let shapes: Vec<String> = kinds
            .iter()
            .map(|((kind, sensor), n)| {
                format!("{n} {kind}{}", if *sensor { " (trigger)" } else { "" })
            })
            .collect();
        let kind = match body.def.kind {
            BodyKind::Static => "static".to_owned(),
            BodyKind::Kinematic => "kinematic".to_owned(),
            BodyKind::Dynamic => match body.def.mass {
                MassDef::FromShapes => "dynamic, mass from its shapes at 1000 kg/m³".to_owned(),
                MassDef::Mass(m) | MassDef::Exact { mass: m, .. } => format!("dynamic, {m} kg"),
            },
        };
        let shapes = if shapes.is_empty() { "no shape".to_owned() } else { shapes.join(", ") };
        let _ = writeln!(out, "  {}: {kind}; {shapes}", body.name);
    }
    if !scene.joints.is_empty() {
        let _ = writeln!(out, "joints: {}", scene.joints.len());
    }
    for joint in &scene.joints {
        let name = |number: usize| scene.bodies.get(number).map_or("?", |b| b.name.as_str());
        let kind = match joint.kind {
            JointKind::Ball => "ball".to_owned(),
            JointKind::Distance { min, max, .. } => format!("distance of {min} to {max} m"),
            JointKind::SixDof(axes) => axes_of(&axes),
            _ => "joint".to_owned(),
        };
        let collide = if joint.collide_connected { "; they collide" } else { "" };
        let (a, b) = (name(joint.body_a), name(joint.body_b));
        let _ = writeln!(out, "  {a} - {b}: {kind}{collide}");
    }
    let triangles: usize = scene
        .bodies
        .iter()
        .flat_map(|b| &b.def.shapes)
        .map(|s| if let Shape::Mesh(m) = &s.shape { m.triangles().len() } else { 0 })
        .sum();
    if triangles > 0 {
        let _ = writeln!(out, "triangles: {triangles}");
    }
    if scene.notes.is_empty() {
        let _ = writeln!(out, "ignored: nothing");
    } else {
        let _ = writeln!(out, "ignored, changed or approximated:");
        for note in &scene.notes {
            let _ = writeln!(out, "  {note}");
        }
    }
    out
}
