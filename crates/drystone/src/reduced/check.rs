//! Checks of definitions: each error names the place of the first wrong value.

use super::def::{LinkDef, RowSoftness, TreeDef, TreeError, TreeJoint, TreeJointKind};

/// Largest magnitude of a length, mass or other number of a definition.
const MAX: f64 = 1.0e12;

/// Checks everything but the inertia of joints, which needs the tree.
pub(super) fn check(def: &TreeDef) -> Result<(), TreeError> {
    if def.links.is_empty() {
        return Err(TreeError::new("links", "none", "at least one link"));
    }
    for (i, link) in def.links.iter().enumerate() {
        check_link(i, link)?;
    }
    for (i, coupling) in def.couplings.iter().enumerate() {
        let place = format!("couplings[{i}]");
        let joints = [Some(coupling.follower), coupling.leader];
        for joint in joints.into_iter().flatten() {
            has_axis(def, joint, &place)?;
        }
        if coupling.leader == Some(coupling.follower) {
            return Err(TreeError::new(place, "itself", "a leader that is another joint"));
        }
        numbers(&format!("{place}.polynomial"), &coupling.polynomial, -MAX)?;
        soft(&place, coupling.softness)?;
    }
    for (i, tendon) in def.tendons.iter().enumerate() {
        let place = format!("tendons[{i}]");
        for (joint, weight) in &tendon.terms {
            has_axis(def, *joint, &place)?;
            numbers(&format!("{place}.terms"), &[*weight], -MAX)?;
        }
        range(&place, tendon.range)?;
        numbers(&format!("{place}.rest"), &[tendon.rest], -MAX)?;
        let forces = [tendon.stiffness, tendon.damping, tendon.friction];
        numbers(&format!("{place}: stiffness, damping or friction"), &forces, 0.0)?;
    }
    for (i, closure) in def.loops.iter().enumerate() {
        let place = format!("loops[{i}]");
        for link in [Some(closure.link_a), closure.link_b].into_iter().flatten() {
            if link >= def.links.len() {
                return Err(TreeError::new(place, link, "the index of a link"));
            }
        }
        if closure.link_b == Some(closure.link_a) {
            return Err(TreeError::new(place, closure.link_a, "two different links"));
        }
        numbers(&format!("{place}.point_a"), &closure.point_a, -MAX)?;
        numbers(&format!("{place}.point_b"), &closure.point_b, -MAX)?;
        if let Some(q) = closure.rotation {
            quaternion(&format!("{place}.rotation"), q)?;
        }
        soft(&place, closure.softness)?;
    }
    Ok(())
}

fn check_link(i: usize, link: &LinkDef) -> Result<(), TreeError> {
    let at = |field: &str| format!("links[{i}].{field}");
    match link.parent {
        Some(parent) if parent >= i => {
            let allowed = "a link before this one: a tree has no cycle";
            return Err(TreeError::new(at("parent"), parent, allowed));
        }
        None if i > 0 => {
            let allowed = "the index of a link; only the first stands on the world";
            return Err(TreeError::new(at("parent"), "none", allowed));
        }
        _ => {}
    }
    numbers(&at("position"), &link.position, -MAX)?;
    quaternion(&at("rotation"), link.rotation)?;
    numbers(&at("mass"), &[link.mass], 0.0)?;
    numbers(&at("center"), &link.center, -MAX)?;
    numbers(&at("inertia"), &link.inertia, -MAX)?;
    if factor(link.inertia).is_none() {
        let allowed = "an inertia without negative moments";
        return Err(TreeError::new(at("inertia"), format!("{:?}", link.inertia), allowed));
    }
    for (j, joint) in link.joints.iter().enumerate() {
        check_joint(&at(&format!("joints[{j}]")), i, link, joint)?;
    }
    Ok(())
}

fn check_joint(
    place: &str,
    link_index: usize,
    link: &LinkDef,
    joint: &TreeJoint,
) -> Result<(), TreeError> {
    let at = |field: &str| format!("{place}.{field}");
    let ball = joint.kind == TreeJointKind::Ball;
    let free = joint.kind == TreeJointKind::Free;
    if free && (link_index > 0 || link.joints.len() > 1) {
        let allowed = "a free joint alone on the first link";
        return Err(TreeError::new(at("kind"), "Free", allowed));
    }
    numbers(&at("anchor"), &joint.anchor, -MAX)?;
    numbers(&at("axis"), &joint.axis, -MAX)?;
    let length = joint.axis.iter().map(|x| x * x).sum::<f64>();
    if !(ball || free || length > 1.0e-24) {
        return Err(TreeError::new(at("axis"), format!("{:?}", joint.axis), "a length above 0"));
    }
    numbers(&at("reference"), &[joint.reference], -MAX)?;
    numbers(&at("rest"), &[joint.rest], -MAX)?;
    numbers(&at("armature"), &[joint.armature], 0.0)?;
    numbers(&at("damping"), &[joint.damping], 0.0)?;
    numbers(&at("stiffness"), &[joint.stiffness], 0.0)?;
    numbers(&at("friction"), &[joint.friction], 0.0)?;
    range(place, joint.range)?;
    if free && (joint.range.is_some() || joint.stiffness > 0.0) {
        return Err(TreeError::new(place, "a range or spring", "neither on a free joint"));
    }
    if ball && joint.range.is_some_and(|[low, _]| low != 0.0) {
        return Err(TreeError::new(at("range"), "another lowest angle", "0 for a ball"));
    }
    Ok(())
}

/// Checks that all values are finite, at least `minimum`, and not too large.
fn numbers(place: &str, values: &[f64], minimum: f64) -> Result<(), TreeError> {
    for value in values {
        if !(*value >= minimum && *value <= MAX) {
            let allowed = format!("{minimum:e} to {MAX:e}");
            return Err(TreeError::new(place, value, &allowed));
        }
    }
    Ok(())
}

fn quaternion(place: &str, q: [f64; 4]) -> Result<(), TreeError> {
    numbers(place, &q, -MAX)?;
    if !(q.iter().map(|x| x * x).sum::<f64>() > 1.0e-12) {
        return Err(TreeError::new(place, format!("{q:?}"), "a length above 0"));
    }
    Ok(())
}

fn range(place: &str, range: Option<[f64; 2]>) -> Result<(), TreeError> {
    let Some([low, high]) = range else { return Ok(()) };
    numbers(&format!("{place}.range"), &[low, high], -MAX)?;
    if low > high {
        let allowed = "a lowest value that is not above the highest";
        return Err(TreeError::new(format!("{place}.range"), format!("{low} to {high}"), allowed));
    }
    Ok(())
}

fn soft(place: &str, softness: RowSoftness) -> Result<(), TreeError> {
    if let RowSoftness::Spring { frequency, ratio } = softness {
        numbers(&format!("{place}.softness.frequency"), &[frequency], 1.0e-6)?;
        numbers(&format!("{place}.softness.ratio"), &[ratio], 0.0)?;
    }
    Ok(())
}

fn has_axis(def: &TreeDef, (link, index): (usize, usize), place: &str) -> Result<(), TreeError> {
    let joint = def.links.get(link).and_then(|link| link.joints.get(index));
    let axial = joint
        .is_some_and(|joint| matches!(joint.kind, TreeJointKind::Hinge | TreeJointKind::Slide));
    if axial {
        return Ok(());
    }
    let allowed = "link and index of a hinge or slide";
    Err(TreeError::new(place, format!("link {link}, joint {index}"), allowed))
}

/// Columns g of a lower triangular matrix with the sum of `g gᵀ` equal to the inertia, or `None`
/// if a moment is negative.
pub(super) fn factor(inertia: [f64; 6]) -> Option<[[f64; 3]; 3]> {
    let [xx, yy, zz, xy, xz, yz] = inertia;
    let scale = xx.abs() + yy.abs() + zz.abs();
    let mut m = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
    let mut columns = [[0.0; 3]; 3];
    for k in 0..3 {
        let pivot = m[k][k];
        // Moments of flat links are 0 up to the digits of a file.
        if pivot < -1.0e-9 * scale {
            return None;
        }
        if pivot <= 1.0e-15 * scale {
            if (k + 1..3).any(|i| m[i][k].abs() > 1.0e-6 * scale) {
                return None;
            }
            continue;
        }
        let root = pivot.sqrt();
        for i in k..3 {
            columns[k][i] = m[i][k] / root;
        }
        for i in k + 1..3 {
            for j in k + 1..3 {
                m[i][j] -= columns[k][i] * columns[k][j];
            }
        }
    }
    Some(columns)
}
