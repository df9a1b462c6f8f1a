//! Joints for engines that have only ball joints and hinges.

use drystone::joint::{JointAxis, JointDrive, JointMotion, JointSpring, SixDof};
use drystone::{JointKind, Pose};
use drystone_scene::SceneJoint;

use crate::engine::EngineError;

/// A joint that holds two bodies together at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linkage {
    /// Numbers of the bodies in the scene.
    pub bodies: [usize; 2],
    /// The point, and axes of which x is the axis of the hinge or of twist [frame of each body].
    pub frames: [Pose; 2],
    /// Allowed relative rotation.
    pub turn: Turn,
    /// Maximum friction torque about each axis that is not locked [N m].
    pub friction: f32,
    /// A spring that brings the frames together: undamped frequency [Hz] and damping ratio.
    pub spring: Option<(f32, f32)>,
    /// Whether the two collide.
    pub collide_connected: bool,
}

/// Allowed relative rotation of two bodies at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Turn {
    /// About all axes, with an optional cone [rad] and minimum and maximum twist [rad].
    Ball {
        /// Maximum swing of the x axis about y and about z.
        cone: Option<[f32; 2]>,
        /// Range about x.
        twist: Option<[f32; 2]>,
    },
    /// About x, between these angles [rad].
    Hinge {
        /// `None` if it turns freely.
        limits: Option<[f32; 2]>,
    },
}

/// Converts these joints.
///
/// # Errors
/// Fails if one of them is neither a ball joint nor a hinge, or has limits or drives that some
/// engine lacks.
pub fn linkages(joints: &[SceneJoint]) -> Result<Vec<Linkage>, EngineError> {
    let made = joints.iter().map(|joint| {
        if joint.strength.is_some() {
            return Err(EngineError("joints that break are not translated".to_owned()));
        }
        linkage(joint).ok_or_else(|| {
            let what = "joints other than balls and hinges, some with limits and springs, are not \
                        translated";
            EngineError(what.to_owned())
        })
    });
    made.collect()
}

/// The linkage of a joint, or `None` for other joints.
fn linkage(joint: &SceneJoint) -> Option<Linkage> {
    let axes = match joint.kind {
        JointKind::Ball => SixDof { angular: [JointAxis::FREE; 3], ..SixDof::FIXED },
        JointKind::SixDof(axes) => axes,
        _ => return None,
    };
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
        Some(cone) if cone.spring.is_none() => Some(cone.swing),
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
    let JointAxis { drive, friction, .. } = axes.angular[0];
    let acted = |axis: &JointAxis| axis.drive == drive && same(axis.friction, friction);
    if !axes.angular[..free].iter().all(acted) {
        return None;
    }
    let spring = match drive {
        None => None,
        Some(drive) => Some(spring(&drive)?),
    };
    let [anchor_a, anchor_b] = [joint.anchor_a, joint.anchor_b];
    Some(Linkage {
        bodies: [joint.body_a, joint.body_b],
        frames: [Pose::new(anchor_a, axes.frame_a), Pose::new(anchor_b, axes.frame_b)],
        turn,
        friction,
        spring,
        collide_connected: joint.collide_connected,
    })
}

/// Frequency [Hz] and damping ratio of a drive that is a pure spring between its frames.
fn spring(drive: &JointDrive) -> Option<(f32, f32)> {
    let JointSpring { stiffness, damping, .. } = drive.spring;
    if !(stiffness > 0.0 && damping >= 0.0) {
        return None;
    }
    let omega = stiffness.sqrt();
    let law = JointSpring { stiffness, damping, per_mass: true };
    let pulls = *drive == JointDrive::servo(0.0, law, f32::INFINITY);
    pulls.then(|| (omega / core::f32::consts::TAU, 0.5 * damping / omega))
}

const fn same(a: f32, b: f32) -> bool {
    a.to_bits() == b.to_bits()
}

#[cfg(test)]
mod tests {
    use drystone::JointKind;
    use drystone::joint::{JointDrive, SixDof};
    use drystone_scene::{Script, named};

    use super::{Turn, linkages};

    #[test]
    fn people_hang_together_by_balls_and_hinges_on_springs() {
        let Script::Waves(waves) = named("rain:rows=1").unwrap().script else { unreachable!() };
        let made = linkages(&waves[0].joints).unwrap();
        // Three ragdolls of 13 joints, of which knees and elbows are hinges.
        assert_eq!(made.len(), 39);
        let hinges = made.iter().filter(|l| matches!(l.turn, Turn::Hinge { limits: Some(_) }));
        assert_eq!(hinges.count(), 12);
        for linkage in &made {
            let (hertz, ratio) = linkage.spring.unwrap();
            // Tolerance: a square root and two products of numbers rounded once.
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
        let Script::Waves(mut waves) = named("rain:rows=1").unwrap().script else { unreachable!() };
        assert!(linkages(&waves[0].joints).is_ok());
        let JointKind::SixDof(axes) = &mut waves[0].joints[0].kind else { unreachable!() };
        // A brake instead of a spring, the same about all axes, as the other engines require.
        for axis in &mut axes.angular {
            axis.drive = Some(JointDrive::motor(0.0, 1.0));
        }
        assert!(linkages(&waves[0].joints).is_err());
    }
}
