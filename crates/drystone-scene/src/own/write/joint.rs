//! Joints. One of six axes is written by its name where it has one.

use drystone::joint::{JointAxis, JointDrive, JointMotion, JointSpring, SixDof};
use drystone::{Axis, JointKind, Quat, Vec3};

use super::names::Names;
use super::said::{other, refuse, unless, unless_turn, unless_vec};
use crate::error::SceneError;
use crate::own::document::{
    self, AxisName, Ball, Cone6, ConeTwist, Cylindrical, Distance, Drive, Fatigue, Fixed, Joint,
    JointStrength, LengthSpring, Motor, Planar, Pulley, RopeJoint, SixAxes, Spring, Universal,
};
use crate::own::value::Bound;
use crate::scene::SceneJoint;

pub(super) const fn axis_name(axis: Axis) -> AxisName {
    match axis {
        Axis::X => AxisName::X,
        Axis::Y => AxisName::Y,
        Axis::Z => AxisName::Z,
        Axis::TurnX => AxisName::TurnX,
        Axis::TurnY => AxisName::TurnY,
        Axis::TurnZ => AxisName::TurnZ,
    }
}

impl Names {
    pub(super) fn joint(&self, joint: &SceneJoint) -> Result<Joint, SceneError> {
        let is_pulley = matches!(joint.kind, JointKind::Pulley(_));
        let most = |value: f32| value.is_finite().then_some(value);
        let mut made = Joint {
            name: (!joint.name.is_empty()).then(|| joint.name.clone()),
            body_a: self.body(joint.body_a),
            body_b: self.body(joint.body_b),
            anchor_a: unless_vec(joint.anchor_a, Vec3::ZERO),
            anchor_b: unless_vec(joint.anchor_b, Vec3::ZERO),
            collide_connected: other(joint.collide_connected, &is_pulley),
            strength: joint.strength.map(|s| JointStrength {
                force: most(s.force),
                torque: most(s.torque),
                impulse: most(s.impulse),
                fatigue: s.fatigue.map(|f| Fatigue {
                    life: f.life,
                    exponent: f.exponent,
                    endurance: f.endurance,
                }),
            }),
            articulated: other(joint.articulated, &false),
            enabled: other(joint.enabled, &true),
            user_data: other(joint.user_data, &0),
            ..Joint::default()
        };
        match &joint.kind {
            JointKind::Ball => made.ball = Some(Ball::default()),
            JointKind::Distance { min, max, spring } => {
                let spring = spring.map(|s| LengthSpring {
                    rest_length: s.rest_length,
                    hertz: s.hertz,
                    damping_ratio: s.damping_ratio,
                });
                if min.to_bits() == 0 && spring.is_none() {
                    made.rope = Some(RopeJoint { length: *max });
                } else {
                    made.distance = Some(Distance { min: *min, max: *max, spring });
                }
            }
            JointKind::Pulley(pulley) => {
                made.pulley = Some(Pulley {
                    points: pulley.points.map(Vec3::to_array),
                    length: pulley.length,
                    ratio: unless(pulley.ratio, 1.0),
                    is_rigid: other(pulley.is_rigid, &false),
                });
            }
            JointKind::SixDof(axes) => {
                made.frame_a = unless_turn(axes.frame_a);
                made.frame_b = unless_turn(axes.frame_b);
                six(&mut made, axes);
            }
            kind => {
                let problem = format!("{kind:?} has no name in it");
                return Err(refuse("joints", problem, "a joint of docs/format.md"));
            }
        }
        Ok(made)
    }
}

/// By the name that fits.
fn six(joint: &mut Joint, axes: &SixDof) {
    let (locked, free) = (JointAxis::LOCKED, JointAxis::FREE);
    let bare = SixDof { frame_a: Quat::IDENTITY, frame_b: Quat::IDENTITY, ..*axes };
    let [x, y, z] = axes.linear;
    let [a, b, c] = axes.angular;
    let fits = |linear: [JointAxis; 3], angular: [JointAxis; 3]| {
        let other = SixDof { linear, angular, ..SixDof::FIXED };
        bare == other
    };
    let some = |def: JointAxis| (def != free).then(|| axis(&def));
    let rigid = [locked; 3];
    if fits(rigid, rigid) {
        joint.fixed = Some(Fixed::default());
    } else if fits(rigid, [a, locked, locked]) {
        joint.hinge = Some(axis(&a));
    } else if fits([x, locked, locked], rigid) {
        joint.slider = Some(axis(&x));
    } else if fits([x, locked, locked], [a, locked, locked]) {
        joint.cylindrical = Some(Cylindrical { along: some(x), about: some(a) });
    } else if fits(rigid, [a, b, locked]) {
        joint.universal = Some(Universal { x: some(a), y: some(b) });
    } else if fits([locked, y, z], [a, locked, locked]) {
        joint.planar = Some(Planar { y: some(y), z: some(z), turn: some(a) });
    } else if let Some(cone) = axes.cone
        && [x, y, z] == rigid
        && b == c
        && b == free.with_friction(b.friction)
        && b.friction.is_finite()
    {
        joint.cone_twist = Some(ConeTwist {
            swing: cone.swing,
            spring: cone.spring.as_ref().map(spring),
            friction: unless(b.friction, 0.0),
            twist: some(a),
        });
    } else {
        let some = |def: JointAxis| (def != locked).then(|| axis(&def));
        joint.six_dof = Some(SixAxes {
            x: some(x),
            y: some(y),
            z: some(z),
            turn_x: some(a),
            turn_y: some(b),
            turn_z: some(c),
            cone: axes
                .cone
                .map(|cone| Cone6 { swing: cone.swing, spring: cone.spring.as_ref().map(spring) }),
        });
    }
}

fn axis(axis: &JointAxis) -> document::Axis {
    let mut made = document::Axis::default();
    match &axis.motion {
        JointMotion::Free => {}
        JointMotion::Locked => made.locked = Some(true),
        JointMotion::Limited { min, max, spring: soft } => {
            made.limits = Some([Bound(*min), Bound(*max)]);
            made.limit_spring = soft.as_ref().map(spring);
        }
    }
    if let Some(drive) = axis.drive {
        let motor = JointDrive::motor(drive.velocity, drive.max_force);
        if drive == motor && drive.position.to_bits() == 0 {
            let max_force = Bound(drive.max_force);
            made.motor = Some(Motor { speed: drive.velocity, max_force });
        } else {
            made.drive = Some(Drive {
                position: unless(drive.position, 0.0),
                velocity: unless(drive.velocity, 0.0),
                spring: spring(&drive.spring),
                max_force: drive.max_force.is_finite().then_some(Bound(drive.max_force)),
            });
        }
    }
    made.friction = unless(axis.friction, 0.0).map(Bound);
    made
}

fn spring(spring: &JointSpring) -> Spring {
    Spring {
        stiffness: Some(spring.stiffness),
        damping: Some(Bound(spring.damping)),
        per_mass: other(spring.per_mass, &false),
        ..Spring::default()
    }
}
