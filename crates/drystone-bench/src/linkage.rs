//! Joints as engines have them that know ball joints and hinges.

use drystone::{JointAxis, JointDrive, JointKind, JointMotion, JointSpring, Pose, SixDof};
use drystone_scene::SceneJoint;

use crate::engine::EngineError;

/// Two bodies held together at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linkage {
    /// Numbers of the bodies in the scene.
    pub bodies: [usize; 2],
    /// The point, and axes of which x is the hinge's or the twist's [frame of each body].
    pub frames: [Pose; 2],
    /// How they may turn.
    pub turn: Turn,
    /// Greatest torque of friction about each axis that is not locked [N m].
    pub friction: f32,
    /// A spring that brings the frames together: undamped frequency [Hz] and damping ratio.
    pub spring: Option<(f32, f32)>,
    /// Whether the two collide.
    pub collide_connected: bool,
}

/// How two bodies on a point may turn against each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Turn {
    /// In every way, or within a cone [rad] and least and greatest twist [rad].
    Ball {
        /// Half the opening of the cone of the x axes.
        cone: Option<f32>,
        /// About x.
        twist: Option<[f32; 2]>,
    },
    /// About x, between these angles [rad].
    Hinge {
        /// Nothing if it turns freely.
        limits: Option<[f32; 2]>,
    },
}

/// What these joints are. A spring is a joint of its own in a scene: one that does nothing else is a part of the
/// joint before it, if that is at the same place.
///
/// # Errors
/// One of them is neither a ball joint nor a hinge, or has limits or drives that not all engines have.
pub fn linkages(joints: &[SceneJoint]) -> Result<Vec<Linkage>, EngineError> {
    let mut made: Vec<Linkage> = Vec::with_capacity(joints.len());
    for joint in joints {
        if joint.strength.is_some() {
            return Err(EngineError("joints that break are not translated".to_owned()));
        }
        let linkage = linkage(joint).ok_or_else(|| {
            let what = "joints other than balls and hinges, some with limits, are not translated";
            EngineError(what.to_owned())
        })?;
        match (linkage, made.last_mut()) {
            (Part::Joint(linkage), _) => made.push(linkage),
            (Part::Spring(spring), Some(last)) if is_at(joint, last) && last.spring.is_none() => {
                last.spring = Some(spring);
            }
            (Part::Spring(_), _) => {
                let what = "a spring without a joint before it is not translated";
                return Err(EngineError(what.to_owned()));
            }
        }
    }
    Ok(made)
}

enum Part {
    Joint(Linkage),
    Spring((f32, f32)),
}

/// Nothing if it is something else.
fn linkage(joint: &SceneJoint) -> Option<Part> {
    let axes = match joint.kind {
        JointKind::Ball => SixDof { angular: [JointAxis::FREE; 3], ..SixDof::FIXED },
        JointKind::SixDof(axes) => axes,
        _ => return None,
    };
    if axes.linear == [JointAxis::FREE; 3] {
        return spring(&axes).map(Part::Spring);
    }
    if axes.linear != [JointAxis::LOCKED; 3] {
        return None;
    }
    let about_x = match axes.angular[0].motion {
        JointMotion::Free => None,
        JointMotion::Limited { min, max, spring: None } => Some([min, max]),
        _ => return None,
    };
    let cone = match axes.cone {
        None => None,
        Some(cone) if cone.spring.is_none() && same(cone.swing[0], cone.swing[1]) => {
            Some(cone.swing[0])
        }
        Some(_) => return None,
    };
    let swings = axes.angular.map(|axis| axis.motion);
    let (turn, free) = match [swings[1], swings[2]] {
        [JointMotion::Free, JointMotion::Free] => (Turn::Ball { cone, twist: about_x }, 3),
        [JointMotion::Locked, JointMotion::Locked] if cone.is_none() => {
            (Turn::Hinge { limits: about_x }, 1)
        }
        _ => return None,
    };
    let friction = axes.angular[0].drive.map_or(0.0, |drive| drive.max_force);
    let expected = (friction > 0.0).then(|| JointDrive::friction(friction));
    if axes.angular[..free].iter().any(|axis| axis.drive != expected) {
        return None;
    }
    Some(Part::Joint(Linkage {
        bodies: [joint.body_a, joint.body_b],
        frames: frames(joint, &axes),
        turn,
        friction,
        spring: None,
        collide_connected: joint.collide_connected,
    }))
}

/// Frequency [Hz] and damping ratio of a joint that does nothing but pull its frames together.
fn spring(axes: &SixDof) -> Option<(f32, f32)> {
    let JointSpring { stiffness, damping, .. } = axes.angular[0].drive?.spring;
    if axes.cone.is_some() || !(stiffness > 0.0 && damping >= 0.0) {
        return None;
    }
    let omega = stiffness.sqrt();
    let found = (omega / core::f32::consts::TAU, 0.5 * damping / omega);
    let law = JointSpring { stiffness, damping, per_mass: true };
    let pulled = JointAxis::driven(JointDrive::servo(0.0, law, f32::INFINITY));
    let rest = [axes.angular[1], axes.angular[2]];
    let all = rest == [pulled; 2] || rest == [JointAxis::FREE; 2];
    (axes.angular[0] == pulled && all).then_some(found)
}

fn frames(joint: &SceneJoint, axes: &SixDof) -> [Pose; 2] {
    [Pose::new(joint.anchor_a, axes.frame_a), Pose::new(joint.anchor_b, axes.frame_b)]
}

/// Whether a spring's joint is where this one is.
fn is_at(joint: &SceneJoint, linkage: &Linkage) -> bool {
    let JointKind::SixDof(axes) = joint.kind else { return false };
    [joint.body_a, joint.body_b] == linkage.bodies && frames(joint, &axes) == linkage.frames
}

const fn same(a: f32, b: f32) -> bool {
    a.to_bits() == b.to_bits()
}

#[cfg(test)]
mod tests {
    use drystone::{JointKind, SixDof};
    use drystone_scene::{Script, named};

    use super::{Turn, linkages};

    #[test]
    fn people_hang_together_by_balls_and_hinges_on_springs() {
        let Script::Waves(waves) = named("rain:rows=1").unwrap().script else { unreachable!() };
        let made = linkages(&waves[0].joints).unwrap();
        // Three people of 13 joints, of which knees and elbows are hinges.
        assert_eq!(made.len(), 39);
        let hinges = made.iter().filter(|l| matches!(l.turn, Turn::Hinge { limits: Some(_) }));
        assert_eq!(hinges.count(), 12);
        for linkage in &made {
            let (hertz, ratio) = linkage.spring.unwrap();
            // A square root and two products of numbers rounded once.
            assert!((hertz - 1.0).abs() < 1.0e-6 && (ratio - 0.7).abs() < 1.0e-6);
            assert!(linkage.friction >= 2.0 && linkage.friction <= 5.0);
            if let Turn::Ball { cone, twist } = linkage.turn {
                assert!(cone.is_some() && twist.is_some_and(|[min, max]| min < max));
            }
        }
    }

    #[test]
    fn what_engines_do_not_have_is_refused() {
        let mut joint = named("joint_grid").unwrap().joints[0].clone();
        let made = linkages(core::slice::from_ref(&joint)).unwrap();
        assert_eq!(made[0].turn, Turn::Ball { cone: None, twist: None });
        joint.kind = JointKind::SixDof(SixDof::FIXED);
        assert!(linkages(&[joint]).is_err());
        let Script::Waves(waves) = named("rain:rows=1").unwrap().script else { unreachable!() };
        // A spring, and no joint before it.
        assert!(linkages(&waves[0].joints[1..2]).is_err());
    }
}
