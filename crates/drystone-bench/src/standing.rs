//! Decides whether a scene that should stand still does, by one criterion for every engine, from
//! poses alone.
//!
//! A body has fallen if it moved sideways by more than its own radius (of its shapes about its
//! origin) or turned by more than 30 degrees. It has also fallen if it came down by more than its
//! radius plus a tenth of its height over the lowest body. That tenth leaves room for sag;
//! penetration measures the softness of contacts.

use drystone::{BodyKind, Shape, ShapeDef, Vec3};
use drystone_scene::{Scene, SceneBody};

use crate::engine::BodyState;

/// Scenes that should stand. The number is the fraction of a body's height over the lowest body
/// that is air at the start, through which the body drops.
const STANDING: [(&str, f32); 14] = [
    ("stack", 0.0),
    ("pyramid", 0.0),
    ("large_pyramid", 0.0),
    ("many_pyramids", 0.0),
    ("wall", 0.0),
    ("tower", 0.0),
    ("jenga", 0.0),
    ("plank_tower", 0.0),
    ("arch", 0.0),
    ("card_house", 0.0),
    ("tiny_pyramid", 0.0),
    ("kapla", 0.0),
    ("catenary_arch", 0.0),
    // Levels 2 m high are dropped 2.5 m apart.
    ("jolt_pyramid", 0.2),
];

/// Cosine of half of 30 degrees: a quaternion holds the cosine of the half angle.
const COS_HALF_TURN: f32 = 0.965_925_8;

/// Fraction of a body's height that it may sag.
const SAG: f32 = 0.1;

/// Whether the scene stands, with these bodies in these final states. `None` if the scene is not
/// meant to stand, or if something is thrown in it.
#[must_use]
pub fn stands(
    spec: &str,
    scene: &Scene,
    bodies: &[&SceneBody],
    states: &[BodyState],
) -> Option<bool> {
    let name = spec.split(':').next().unwrap_or_default().trim();
    let (_, air) = STANDING.iter().find(|(known, _)| *known == name)?;
    if scene.bodies.iter().any(|b| b.def.linear_velocity != Vec3::ZERO) {
        return None;
    }
    still_stands(scene.config.gravity, bodies, states, *air)
}

/// Whether bodies that should stand do, with these final states under this gravity [m/s²]. `air` is
/// the fraction of a body's height over the lowest body through which it drops at the start. `None`
/// without gravity.
#[must_use]
pub fn still_stands(
    gravity: Vec3,
    bodies: &[&SceneBody],
    states: &[BodyState],
    air: f32,
) -> Option<bool> {
    let up = -gravity.try_normalize()?;
    let moving = || bodies.iter().filter(|b| b.def.kind == BodyKind::Dynamic);
    let lowest = moving().map(|b| b.def.position.dot(up)).fold(f32::INFINITY, f32::min);
    let fallen = bodies.iter().zip(states).any(|(body, state)| {
        let start = body.def.position;
        let moved = state.pose.position - start;
        let rise = moved.dot(up);
        let sideways = (moved - up * rise).length();
        let height = start.dot(up) - lowest;
        let drop = -rise - air * height;
        let (q, q0) = (state.pose.rotation, body.def.rotation);
        let cosine = (q.x * q0.x + q.y * q0.y + q.z * q0.z + q.w * q0.w).abs();
        let radius = body.def.shapes.iter().map(reach).fold(0.0, f32::max);
        let upright = sideways <= radius && drop <= radius + SAG * height;
        // Written so that a body with a NaN state has fallen.
        body.def.kind == BodyKind::Dynamic && !(upright && cosine >= COS_HALF_TURN)
    });
    Some(!fallen)
}

/// Maximum distance of a shape's points from its body's origin [m].
fn reach(def: &ShapeDef) -> f32 {
    let own = match &def.shape {
        Shape::Sphere { radius } => *radius,
        Shape::Capsule { half_height, radius } => half_height + radius,
        Shape::Box { half_extents } => half_extents.length(),
        Shape::Hull(hull) => hull.vertices().iter().map(|v| v.length()).fold(0.0, f32::max),
        Shape::Cylinder { half_height, radius } => half_height.hypot(*radius),
        Shape::Cone { half_height, radius_bottom, radius_top } => {
            half_height.hypot(radius_bottom.max(*radius_top))
        }
        _ => 0.0,
    };
    own + def.pose.position.length()
}

#[cfg(test)]
mod tests {
    use drystone::{Pose, Quat, Vec3, vec3};
    use drystone_scene::{Scene, SceneBody, named};

    use super::stands;
    use crate::engine::BodyState;

    /// Whether the scene stands after `change` was applied to the state of its last body.
    fn after(spec: &str, change: impl Fn(&mut Pose)) -> Option<bool> {
        let scene: Scene = named(spec).unwrap();
        let bodies: Vec<&SceneBody> = scene.bodies.iter().collect();
        let state = |b: &SceneBody| BodyState {
            pose: Pose::new(b.def.position, b.def.rotation),
            linear_velocity: Vec3::ZERO,
            angular_velocity: Vec3::ZERO,
        };
        let mut states: Vec<BodyState> = bodies.iter().map(|b| state(b)).collect();
        change(&mut states.last_mut().unwrap().pose);
        stands(spec, &scene, &bodies, &states)
    }

    #[test]
    fn sag_and_small_shifts_stand_and_falls_do_not() {
        let spec = "stack:n=10";
        let moved = |by: Vec3| after(spec, |pose| pose.position += by);
        assert_eq!(moved(Vec3::ZERO), Some(true));
        assert_eq!(moved(vec3(0.0, -0.5, 0.0)), Some(true));
        // Its radius is 0.87 m and its height 9 m, so 1.77 m is the limit.
        assert_eq!(moved(vec3(0.0, -1.7, 0.0)), Some(true));
        assert_eq!(moved(vec3(0.0, -1.8, 0.0)), Some(false));
        assert_eq!(moved(vec3(0.9, 0.0, 0.0)), Some(false));
        assert_eq!(moved(Vec3::splat(f32::NAN)), Some(false));
        let turned =
            |angle: f32| after(spec, |pose| pose.rotation = Quat::from_axis_angle(Vec3::Z, angle));
        assert_eq!((turned(0.5), turned(0.55)), (Some(true), Some(false)));
    }

    #[test]
    fn levels_that_are_dropped_may_come_down_and_other_scenes_are_not_judged() {
        let top = 2.5 * 14.0;
        let down = |by: f32| after("jolt_pyramid", move |pose| pose.position.y -= by);
        assert_eq!(down(0.2 * top), Some(true));
        assert_eq!(down(0.2 * top + 1.8 + 0.1 * top), Some(false));
        assert_eq!(after("washer", |_| {}), None);
        assert_eq!(after("wall", |_| {}), Some(true));
        assert_eq!(after("wall:ball=1", |_| {}), None);
    }
}
