//! Shapes and motion as the extensions with physics have them.

use drystone::{BodyDef, BodyKind, MassDef, Pose, Shape, Vec3};
use serde_json::{Value, json};

use crate::mass::mass_of;

/// The shape as `KHR_implicit_shapes` has it; None for hulls and meshes.
pub(super) fn implicit(shape: &Shape) -> Option<Value> {
    let cylinder = |half: f32, bottom: f32, top: f32| {
        let inner = json!({"height": 2.0 * half, "radiusBottom": bottom, "radiusTop": top});
        json!({"type": "cylinder", "cylinder": inner})
    };
    Some(match shape {
        Shape::Sphere { radius } => json!({"type": "sphere", "sphere": {"radius": radius}}),
        Shape::Box { half_extents } => {
            json!({"type": "box", "box": {"size": (*half_extents * 2.0).to_array()}})
        }
        Shape::Capsule { half_height, radius } if *half_height <= 0.0 => {
            json!({"type": "sphere", "sphere": {"radius": radius}})
        }
        Shape::Capsule { half_height, radius } => {
            let inner =
                json!({"height": 2.0 * half_height, "radiusBottom": radius, "radiusTop": radius});
            json!({"type": "capsule", "capsule": inner})
        }
        Shape::Cylinder { half_height, radius } => cylinder(*half_height, *radius, *radius),
        Shape::Cone { half_height, radius_bottom, radius_top } => {
            cylinder(*half_height, *radius_bottom, *radius_top)
        }
        Shape::HalfSpace { .. } => json!({"type": "plane", "plane": {}}),
        _ => return None,
    })
}

/// Motion properties of a body; velocities in the node's frame.
pub(super) fn motion(def: &BodyDef) -> Value {
    let mut motion = json!({});
    let pose = Pose::new(def.position, def.rotation);
    let velocities =
        [("linearVelocity", def.linear_velocity), ("angularVelocity", def.angular_velocity)];
    for (key, v) in velocities {
        if v != Vec3::ZERO {
            motion[key] = json!(pose.local_direction(v).to_array());
        }
    }
    if def.kind == BodyKind::Kinematic {
        motion["isKinematic"] = json!(true);
        return motion;
    }
    if (def.gravity_scale - 1.0).abs() > 0.0 {
        motion["gravityFactor"] = json!(def.gravity_scale);
    }
    let exact = match def.mass {
        MassDef::Mass(mass) => {
            motion["mass"] = json!(mass);
            return motion;
        }
        // A reader assumes this by itself, so no numbers are written.
        MassDef::FromShapes
            if def.shapes.iter().all(|s| s.sensor || (s.density - 1000.0).abs() <= 0.0) =>
        {
            return motion;
        }
        MassDef::FromShapes => {
            let own = mass_of(&def.shapes);
            (own.mass, own.center, own.inertia)
        }
        MassDef::Exact { mass, center, inertia } => (mass, center, inertia),
    };
    let (mass, center, inertia) = exact;
    let (moments, axes) = inertia.eigen();
    motion["mass"] = json!(mass);
    motion["centerOfMass"] = json!(center.to_array());
    motion["inertiaDiagonal"] = json!(moments.max(Vec3::ZERO).to_array());
    motion["inertiaOrientation"] = json!(axes.to_array());
    motion
}
