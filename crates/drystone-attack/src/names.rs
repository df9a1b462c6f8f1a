//! Imports for the source of a test.

use std::collections::BTreeSet;

/// The imports that the source needs.
pub(crate) fn imports(text: &str) -> String {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    let words: BTreeSet<&str> = text.split(|c| !is_part(c)).collect();
    let mut lines = String::new();
    if words.contains("BTreeSet") {
        lines.push_str("use std::collections::BTreeSet;\n");
    }
    if words.contains("Arc") {
        lines.push_str("use std::sync::Arc;\n");
    }
    lines.push('\n');
    for (module, names) in NAMES {
        let named: Vec<&str> = names.iter().copied().filter(|name| words.contains(name)).collect();
        let module = if module.is_empty() { String::new() } else { format!("{module}::") };
        match named[..] {
            [] => {}
            [name] => lines.push_str(&format!("use drystone::{module}{name};\n")),
            _ => lines.push_str(&format!("use drystone::{module}{{{}}};\n", named.join(", "))),
        }
    }
    lines
}

/// Public names that a test may need, by module; the root is last.
const NAMES: [(&str, &[&str]); 12] = [
    ("breakage", &["BondStrength", "Fatigue", "Fracture", "Glue", "JointStrength"]),
    ("contact", &["Combine"]),
    ("events", &["ContactReports", "Senses"]),
    ("geometry", &["Aabb"]),
    ("impact", &["ImpactBody", "ImpactSurface", "impact"]),
    (
        "joint",
        &[
            "CouplingDef",
            "JointAxis",
            "JointCone",
            "JointDrive",
            "JointMotion",
            "JointSpring",
            "Pulley",
            "SixDof",
            "Spring",
        ],
    ),
    ("math", &["Sym3"]),
    ("method", &["Method"]),
    (
        "particle",
        &["ClothDef", "LinkDef", "LinkKind", "LinkSpring", "ParticleDef", "RopeDef", "Strand"],
    ),
    ("query", &["Motion"]),
    ("threads", &["SimdLevel", "Team"]),
    (
        "",
        &[
            "Axis",
            "AxisLocks",
            "BodyDef",
            "BodyId",
            "BodyKind",
            "BodyMut",
            "Filter",
            "Hull",
            "JointDef",
            "JointKind",
            "MassDef",
            "Material",
            "Mesh",
            "Pose",
            "Quat",
            "Shape",
            "ShapeDef",
            "ShapeId",
            "Vec3",
            "World",
            "WorldConfig",
            "vec3",
        ],
    ),
];
