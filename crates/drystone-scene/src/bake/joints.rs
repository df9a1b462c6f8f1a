//! Joints as `KHR_physics_rigid_bodies` has them: limits and drives between two nodes.
//!
//! Each end is a node of its own below the node of its body, at the joint's anchor, turned as its
//! frame.

use drystone::joint::{JointAxis, JointMotion, JointSpring, SixDof};
use drystone::{JointKind, Pose, Quat};
use serde_json::{Map, Value, json};

use super::file::place;

/// Damping that stands for an infinite one, which JSON has no number for: all the force that a
/// drive has.
const RIGID: f32 = 1.0e30;

/// A joint of a scene as a file describes it.
#[derive(Clone, Debug, Default)]
pub(super) struct Written {
    /// The description, for `physicsJoints`; none for a kind that the format does not have.
    pub(super) description: Option<Value>,
    /// Frames of both ends [frames of the bodies].
    pub(super) frames: [Quat; 2],
    /// Features of the joint that the format cannot express.
    pub(super) unsaid: Vec<&'static str>,
}

/// Describes a joint in the terms of the format.
pub(super) fn written(kind: &JointKind) -> Written {
    let mut out = Written::default();
    match kind {
        JointKind::Ball => {
            out.description = Some(json!({"limits": [hold("linearAxes", &[0, 1, 2])]}));
        }
        JointKind::Distance { min, max, spring } => {
            if spring.is_some() {
                out.unsaid.push("the spring of a distance joint");
            }
            let limit = json!({"linearAxes": [0, 1, 2], "min": min, "max": max});
            out.description = Some(json!({"limits": [limit]}));
        }
        JointKind::SixDof(six) => {
            out.frames = [six.frame_a, six.frame_b];
            let description = six_dof(six, &mut out.unsaid);
            out.description = Some(description);
        }
        JointKind::Pulley(_) => out.unsaid.push("a pulley"),
        _ => out.unsaid.push("a joint of another kind"),
    }
    out
}

fn hold(axes: &str, which: &[usize]) -> Value {
    let mut limit = Map::new();
    limit.insert(axes.to_owned(), json!(which));
    limit.insert("min".to_owned(), json!(0.0));
    limit.insert("max".to_owned(), json!(0.0));
    Value::Object(limit)
}

fn six_dof(six: &SixDof, unsaid: &mut Vec<&'static str>) -> Value {
    let (mut limits, mut drives) = (Vec::new(), Vec::new());
    let kinds = [("linearAxes", "linear", &six.linear), ("angularAxes", "angular", &six.angular)];
    for (axes, kind, list) in kinds {
        let locked: Vec<usize> =
            (0..3).filter(|i| list[*i].motion == JointMotion::Locked).collect();
        if !locked.is_empty() {
            limits.push(hold(axes, &locked));
        }
        for (i, axis) in list.iter().enumerate() {
            if let JointMotion::Limited { min, max, spring } = &axis.motion {
                limits.push(limit(axes, &[i], (*min, *max), spring.as_ref(), unsaid));
            }
            drives.extend(drive(kind, i, axis));
            if axis.friction > 0.0 {
                unsaid.push("dry friction of a joint");
            }
        }
    }
    if let Some(cone) = &six.cone {
        let [y, z] = cone.swing;
        let spring = cone.spring.as_ref();
        if y.to_bits() == z.to_bits() {
            limits.push(limit("angularAxes", &[1, 2], (0.0, y), spring, unsaid));
        } else {
            unsaid.push("a cone that is wider one way: each swing is limited by itself");
            limits.push(limit("angularAxes", &[1], (-y, y), spring, unsaid));
            limits.push(limit("angularAxes", &[2], (-z, z), spring, unsaid));
        }
    }
    let mut out = json!({});
    for (key, list) in [("limits", limits), ("drives", drives)] {
        if !list.is_empty() {
            out[key] = Value::Array(list);
        }
    }
    out
}

fn limit(
    axes: &str,
    which: &[usize],
    (min, max): (f32, f32),
    spring: Option<&JointSpring>,
    unsaid: &mut Vec<&'static str>,
) -> Value {
    let mut limit = Map::new();
    limit.insert(axes.to_owned(), json!(which));
    for (key, bound) in [("min", min), ("max", max)] {
        if bound.is_finite() {
            limit.insert(key.to_owned(), json!(bound));
        }
    }
    if let Some(spring) = spring {
        if spring.per_mass {
            unsaid.push("a limit that is soft by the mass of its bodies: its numbers are by force");
        }
        limit.insert("stiffness".to_owned(), json!(spring.stiffness));
        limit.insert("damping".to_owned(), json!(spring.damping.min(RIGID)));
    }
    Value::Object(limit)
}

fn drive(kind: &str, axis: usize, def: &JointAxis) -> Option<Value> {
    let drive = def.drive.filter(|_| def.motion != JointMotion::Locked)?;
    let mode = if drive.spring.per_mass { "acceleration" } else { "force" };
    let mut out = json!({
        "type": kind, "mode": mode, "axis": axis,
        "positionTarget": drive.position, "velocityTarget": drive.velocity,
        "stiffness": drive.spring.stiffness, "damping": drive.spring.damping.min(RIGID),
    });
    if drive.max_force.is_finite() {
        out["maxForce"] = json!(drive.max_force);
    }
    Some(out)
}

/// The node of one end.
pub(super) fn end(pose: &Pose) -> Value {
    let mut node = json!({});
    place(&mut node, pose);
    node
}
