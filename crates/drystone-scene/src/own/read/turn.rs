//! The scene of a part, renamed and turned.

use std::sync::Arc;

use drystone::{AxisLocks, BodyDef, JointKind, Pose, Quat};

use crate::scene::{Scene, SceneBody, SceneJoint, SceneStrand, StrandDef};

/// Prefixes all names.
pub(super) fn rename(scene: &mut Scene, prefix: &str) {
    let named = |name: &mut String| *name = format!("{prefix}/{name}");
    scene.bodies.iter_mut().for_each(|body| named(&mut body.name));
    scene.strands.iter_mut().for_each(|strand| named(&mut strand.name));
    scene.frames.iter_mut().for_each(|frame| named(&mut frame.name));
    for joint in scene.joints.iter_mut().filter(|joint| !joint.name.is_empty()) {
        named(&mut joint.name);
    }
}

/// Brings a scene to a pose; how many bodies have locked axes, which do not turn with it.
pub(super) fn turn(scene: &mut Scene, pose: &Pose) -> usize {
    if *pose == Pose::IDENTITY {
        return 0;
    }
    for body in &mut scene.bodies {
        turn_body(&mut body.def, pose);
    }
    for SceneJoint { kind, .. } in &mut scene.joints {
        if let JointKind::Pulley(pulley) = kind {
            pulley.points = pulley.points.map(|point| pose.point(point));
        }
    }
    for SceneStrand { def, .. } in &mut scene.strands {
        match def {
            StrandDef::Rope(rope) => {
                (rope.from, rope.to) = (pose.point(rope.from), pose.point(rope.to));
                rope.particle.velocity = pose.direction(rope.particle.velocity);
            }
            StrandDef::Cloth(cloth) => {
                cloth.corner = pose.point(cloth.corner);
                cloth.sides = cloth.sides.map(|side| pose.direction(side));
                cloth.particle.velocity = pose.direction(cloth.particle.velocity);
            }
            StrandDef::Cloud(points, particle) => {
                points.iter_mut().for_each(|point| *point = pose.point(*point));
                particle.velocity = pose.direction(particle.velocity);
            }
        }
    }
    if !scene.visuals.scenery.is_empty() {
        let visuals = Arc::make_mut(&mut scene.visuals);
        visuals.scenery.iter_mut().for_each(|placed| placed.pose = pose.compose(&placed.pose));
    }
    let is_turned = pose.rotation != Quat::IDENTITY;
    let locked = |body: &&SceneBody| body.def.locks != AxisLocks::NONE;
    if is_turned { scene.bodies.iter().filter(locked).count() } else { 0 }
}

fn turn_body(def: &mut BodyDef, pose: &Pose) {
    let seat = pose.compose(&Pose::new(def.position, def.rotation));
    (def.position, def.rotation) = (seat.position, seat.rotation.normalized());
    def.linear_velocity = pose.direction(def.linear_velocity);
    def.angular_velocity = pose.direction(def.angular_velocity);
}
