//! What was understood of a file, and what was not.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use drystone::{BodyKind, MassDef, Shape};

use super::LoadedGltf;

/// A text for people: bodies, shapes, settings, and a line for everything that was left out, changed
/// or approximated.
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
