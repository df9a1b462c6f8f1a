//! Names that the source of a test needs.

use std::collections::BTreeSet;

/// What the source needs.
pub(crate) fn imports(text: &str) -> String {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    let words: BTreeSet<&str> = text.split(|c| !is_part(c)).collect();
    let named: Vec<&str> = NAMES.iter().copied().filter(|name| words.contains(name)).collect();
    let mut lines = String::new();
    if words.contains("BTreeSet") {
        lines.push_str("use std::collections::BTreeSet;\n");
    }
    if words.contains("Arc") {
        lines.push_str("use std::sync::Arc;\n");
    }
    lines.push('\n');
    for name in JOINTS.iter().filter(|name| words.contains(*name)) {
        lines.push_str(&format!("use drystone::joint::{name};\n"));
    }
    lines + &format!("use drystone::{{{}}};\n", named.join(", "))
}

/// Public names of joints that a test may need.
const JOINTS: [&str; 2] = ["Pulley", "Spring"];

/// Public names that a test may need.
const NAMES: [&str; 53] = [
    "Aabb",
    "Axis",
    "AxisLocks",
    "BodyDef",
    "BodyId",
    "BodyKind",
    "BondStrength",
    "ClothDef",
    "Combine",
    "ContactReports",
    "CouplingDef",
    "Fatigue",
    "Filter",
    "Fracture",
    "Glue",
    "Hull",
    "ImpactBody",
    "ImpactSurface",
    "JointAxis",
    "JointCone",
    "JointDef",
    "JointDrive",
    "JointKind",
    "JointMotion",
    "JointSpring",
    "JointStrength",
    "LinkDef",
    "LinkKind",
    "LinkSpring",
    "MassDef",
    "Material",
    "Mesh",
    "Method",
    "Motion",
    "ParticleDef",
    "Pose",
    "Quat",
    "RopeDef",
    "Senses",
    "Shape",
    "ShapeDef",
    "ShapeId",
    "SimdLevel",
    "SixDof",
    "Strand",
    "Sym3",
    "Team",
    "Vec3",
    "World",
    "WorldConfig",
    "impact",
    "vec3",
    "BodyMut",
];
