//! Joints.

use drystone::breakage::{Fatigue, JointStrength};
use drystone::joint::{
    Ball, Fixed, JointAxis, JointCone, JointDrive, JointMotion, JointSpring, Planar, Servo, SixDof,
    Universal, Wheel,
};
use drystone::math::Mat3;
use drystone::{Axis, BodyId, JointDef, JointKind, Pose, Quat, Vec3};

use super::reader::Reader;
use crate::error::SceneError;
use crate::own::document::{self, AxisName};
use crate::own::place::Place;
use crate::own::value::Bound;
use crate::scene::SceneJoint;

const KINDS: &str = "one of ball, cone_twist, hinge, slider, cylindrical, universal, planar, fixed, \
                     wheel, servo, distance, rope, spring, pulley, six_dof";

pub(super) const fn axis_of(name: AxisName) -> Axis {
    match name {
        AxisName::X => Axis::X,
        AxisName::Y => Axis::Y,
        AxisName::Z => Axis::Z,
        AxisName::TurnX => Axis::TurnX,
        AxisName::TurnY => Axis::TurnY,
        AxisName::TurnZ => Axis::TurnZ,
    }
}

/// The members of a joint that give its kind.
fn keys(joint: &document::Joint) -> impl Iterator<Item = &'static str> {
    let all = [
        (joint.ball.is_some(), "ball"),
        (joint.cone_twist.is_some(), "cone_twist"),
        (joint.hinge.is_some(), "hinge"),
        (joint.slider.is_some(), "slider"),
        (joint.cylindrical.is_some(), "cylindrical"),
        (joint.universal.is_some(), "universal"),
        (joint.planar.is_some(), "planar"),
        (joint.fixed.is_some(), "fixed"),
        (joint.wheel.is_some(), "wheel"),
        (joint.servo.is_some(), "servo"),
        (joint.distance.is_some(), "distance"),
        (joint.rope.is_some(), "rope"),
        (joint.spring.is_some(), "spring"),
        (joint.pulley.is_some(), "pulley"),
        (joint.six_dof.is_some(), "six_dof"),
    ];
    all.into_iter().filter(|(is_there, _)| *is_there).map(|(_, name)| name)
}

impl Reader<'_> {
    pub(super) fn joint(
        &mut self,
        place: &Place,
        joint: &document::Joint,
    ) -> Result<SceneJoint, SceneError> {
        let body_a = self.body_number(&place.key("body_a"), &joint.body_a)?;
        let body_b = self.body_number(&place.key("body_b"), &joint.body_b)?;
        let said: Vec<&str> = keys(joint).collect();
        let [key] = said[..] else {
            let problem = match said.len() {
                0 => "it has no kind".to_owned(),
                _ => format!("it is {}", said.join(" and ")),
            };
            return Err(self.fail(place, problem, KINDS));
        };
        let at = place.key(key);
        let kind = self.kind(&at, joint)?;
        let ([anchor_a, anchor_b], frames) = self.seat(place, joint, [body_a, body_b])?;
        let kind = match kind {
            JointKind::SixDof(six) => {
                let [frame_a, frame_b] = frames;
                JointKind::SixDof(SixDof { frame_a, frame_b, ..six })
            }
            other => other,
        };
        let made = SceneJoint {
            name: joint.name.clone().unwrap_or_default(),
            collide_connected: joint
                .collide_connected
                .unwrap_or(matches!(kind, JointKind::Pulley(_))),
            strength: joint.strength.as_ref().map(strength),
            articulated: joint.articulated.unwrap_or(false),
            enabled: joint.enabled.unwrap_or(true),
            user_data: joint.user_data.unwrap_or(0),
            ..SceneJoint::new((body_a, anchor_a), (body_b, anchor_b), kind)
        };
        self.check(place, &at, &made)?;
        Ok(made)
    }

    /// The engine's own check.
    fn check(&self, place: &Place, kind: &Place, joint: &SceneJoint) -> Result<(), SceneError> {
        // Any two ids: whether they are there is no part of the check.
        let ids = [1_u64 << 32, (1 << 32) | 1].map(BodyId::from_bits);
        let [Some(a), Some(b)] = ids else { return Ok(()) };
        let b = if joint.body_a == joint.body_b { a } else { b };
        let def = JointDef { strength: joint.strength, ..JointDef::new(a, b, joint.kind) }
            .with_anchors(joint.anchor_a, joint.anchor_b);
        def.validate().map_err(|e| {
            let field = e.field();
            let of_joint = ["anchor", "body", "strength", "frame"];
            if of_joint.iter().any(|own| field.starts_with(own)) {
                return self.refused(place, &e);
            }
            let (value, allowed) = (format!("{field} is {}", e.value()), e.allowed());
            // The engine names axes of its six, not those of the joint's kind in the file.
            let inner = kind.field(field.trim_start_matches("pulley."));
            let is_there = inner.find(self.text) != kind.find(self.text);
            if is_there {
                return self.fail(&inner, format!("is {}", e.value()), allowed);
            }
            self.fail(kind, value, allowed)
        })
    }

    /// Anchors and frames on both bodies.
    fn seat(
        &self,
        place: &Place,
        joint: &document::Joint,
        bodies: [usize; 2],
    ) -> Result<([Vec3; 2], [Quat; 2]), SceneError> {
        let poses = bodies.map(|body| self.seats[body]);
        let poses = poses.map(|p| Pose { rotation: p.rotation.normalized(), ..p });
        let anchors = [joint.anchor_a, joint.anchor_b];
        let world = match (joint.at, joint.between) {
            (Some(_), Some(_)) => {
                return Err(self.fail(
                    &place.key("between"),
                    "there is at beside it",
                    "one of them",
                ));
            }
            (Some(at), None) => Some([at; 2]),
            (None, between) => between,
        };
        let anchors = match world {
            Some(_) if anchors.iter().any(Option::is_some) => {
                let allowed = "points of the world, or anchors on the bodies";
                return Err(self.fail(place, "it is placed in two ways", allowed));
            }
            Some(points) => {
                let [a, b] = points.map(Vec3::from);
                [poses[0].local_point(a), poses[1].local_point(b)]
            }
            None => anchors.map(|anchor| anchor.map_or(Vec3::ZERO, Vec3::from)),
        };
        let turned = self.world_axes(place, joint)?;
        let own = [(joint.frame_a, "frame_a"), (joint.frame_b, "frame_b")];
        let is_own = own.iter().any(|(frame, _)| frame.is_some());
        let turned = match turned {
            Some(_) if is_own => {
                let allowed = "axes of the world, or frames on the bodies";
                return Err(self.fail(place, "its axes are given in two ways", allowed));
            }
            // Placed in the world, it holds the bodies as they lie.
            None if world.is_some() && !is_own => Some(Quat::IDENTITY),
            turned => turned,
        };
        let frames = match turned {
            Some(turned) => poses.map(|p| (p.rotation.conjugate() * turned).normalized()),
            None => {
                let mut frames = [Quat::IDENTITY; 2];
                for (slot, (frame, key)) in frames.iter_mut().zip(own) {
                    if let Some(frame) = frame {
                        *slot = self.turn(&place.key(key), frame)?;
                    }
                }
                frames
            }
        };
        Ok((anchors, frames))
    }

    /// Its axes in the world, if they are given there.
    fn world_axes(
        &self,
        place: &Place,
        joint: &document::Joint,
    ) -> Result<Option<Quat>, SceneError> {
        let told = [joint.axis.is_some(), joint.axes.is_some(), joint.rotation.is_some()];
        if told.iter().filter(|is_told| **is_told).count() > 1 {
            let allowed = "one of axis, axes, rotation";
            return Err(self.fail(place, "its axes are given in two ways", allowed));
        }
        if let Some(axis) = joint.axis {
            let x = self.direction(&place.key("axis"), axis)?;
            return Ok(Some(Quat::from_arc(Vec3::X, x)));
        }
        if let Some([x, y]) = joint.axes {
            let at = place.key("axes");
            let (x, y) = (self.direction(&at.item(0), x)?, self.direction(&at.item(1), y)?);
            let z = x.cross(y);
            // Below this sine the plane of both is rounding of f32.
            if !(z.length() > 1.0e-5) {
                return Err(self.fail(&at, "both have one direction", "two directions"));
            }
            let z = z.normalize_or(Vec3::Z);
            return Ok(Some(Quat::from_mat3(Mat3 { x, y: z.cross(x), z })));
        }
        match joint.rotation {
            Some(turn) => {
                self.turn(&place.key("rotation"), turn).map(|turn| Some(turn.normalized()))
            }
            None => Ok(None),
        }
    }

    fn kind(&self, place: &Place, joint: &document::Joint) -> Result<JointKind, SceneError> {
        let axis = |key: &str, axis: &Option<document::Axis>, otherwise: JointAxis| {
            let at = place.key(key);
            axis.as_ref().map_or(Ok(otherwise), |axis| self.axis(&at, axis))
        };
        let spring = |key: &str, spring: &Option<document::Spring>| {
            spring.as_ref().map(|spring| self.spring(&place.key(key), spring)).transpose()
        };
        let (free, locked) = (JointAxis::FREE, JointAxis::LOCKED);
        if let Some(ball) = &joint.ball {
            return Ok(Ball::new().with_friction(ball.friction.unwrap_or(0.0)).into());
        }
        if let Some(cone) = &joint.cone_twist {
            let swing = JointAxis::FREE.with_friction(cone.friction.unwrap_or(0.0));
            let twist = axis("twist", &cone.twist, free)?;
            let limit = JointCone { swing: cone.swing, spring: spring("spring", &cone.spring)? };
            let angular = [twist, swing, swing];
            return Ok(JointKind::SixDof(SixDof { angular, cone: Some(limit), ..SixDof::FIXED }));
        }
        if let Some(hinge) = &joint.hinge {
            let angular = [self.axis(place, hinge)?, locked, locked];
            return Ok(JointKind::SixDof(SixDof { angular, ..SixDof::FIXED }));
        }
        if let Some(slider) = &joint.slider {
            let linear = [self.axis(place, slider)?, locked, locked];
            return Ok(JointKind::SixDof(SixDof { linear, ..SixDof::FIXED }));
        }
        if let Some(both) = &joint.cylindrical {
            let linear = [axis("along", &both.along, free)?, locked, locked];
            let angular = [axis("about", &both.about, free)?, locked, locked];
            return Ok(JointKind::SixDof(SixDof { linear, angular, ..SixDof::FIXED }));
        }
        if let Some(cross) = &joint.universal {
            let (x, y) = (axis("x", &cross.x, free)?, axis("y", &cross.y, free)?);
            return Ok(Universal::of(x, y).into());
        }
        if let Some(plane) = &joint.planar {
            let (y, z) = (axis("y", &plane.y, free)?, axis("z", &plane.z, free)?);
            return Ok(Planar { y, z, turn: axis("turn", &plane.turn, free)? }.into());
        }
        if let Some(fixed) = &joint.fixed {
            let (linear, angular) =
                (spring("linear", &fixed.linear)?, spring("angular", &fixed.angular)?);
            return Ok(Fixed { linear, angular }.into());
        }
        if let Some(wheel) = &joint.wheel {
            return self.wheel(place, wheel);
        }
        if let Some(servo) = &joint.servo {
            let most = |bound: Option<Bound>| bound.map_or(f32::INFINITY, |v| v.0);
            return Ok(Servo {
                linear: self.spring(&place.key("linear"), &servo.linear)?,
                angular: spring("angular", &servo.angular)?,
                max_force: most(servo.max_force),
                max_torque: most(servo.max_torque),
            }
            .into());
        }
        self.length_or_six(place, joint)
    }

    fn length_or_six(
        &self,
        place: &Place,
        joint: &document::Joint,
    ) -> Result<JointKind, SceneError> {
        let spring = |s: &document::LengthSpring| {
            drystone::joint::Spring::new(s.rest_length, s.hertz, s.damping_ratio)
        };
        if let Some(d) = &joint.distance {
            let spring = d.spring.as_ref().map(spring);
            return Ok(JointKind::Distance { min: d.min, max: d.max, spring });
        }
        if let Some(rope) = &joint.rope {
            return Ok(drystone::joint::Rope::new(rope.length).into());
        }
        if let Some(s) = &joint.spring {
            return Ok(spring(s).into());
        }
        if let Some(p) = &joint.pulley {
            return Ok(JointKind::Pulley(drystone::joint::Pulley {
                ratio: p.ratio.unwrap_or(1.0),
                is_rigid: p.is_rigid.unwrap_or(false),
                ..drystone::joint::Pulley::rope(p.points, p.length)
            }));
        }
        let Some(six) = &joint.six_dof else {
            return Err(self.fail(place, "it has no kind", KINDS));
        };
        let axis = |key: &str, axis: &Option<document::Axis>| {
            let at = place.key(key);
            axis.as_ref().map_or(Ok(JointAxis::LOCKED), |axis| self.axis(&at, axis))
        };
        let cone = match &six.cone {
            Some(cone) => {
                let at = place.key("cone").key("spring");
                let spring = cone.spring.as_ref().map(|s| self.spring(&at, s)).transpose()?;
                Some(JointCone { swing: cone.swing, spring })
            }
            None => None,
        };
        Ok(JointKind::SixDof(SixDof {
            linear: [axis("x", &six.x)?, axis("y", &six.y)?, axis("z", &six.z)?],
            angular: [
                axis("turn_x", &six.turn_x)?,
                axis("turn_y", &six.turn_y)?,
                axis("turn_z", &six.turn_z)?,
            ],
            cone,
            ..SixDof::FIXED
        }))
    }

    fn wheel(&self, place: &Place, wheel: &document::Wheel) -> Result<JointKind, SceneError> {
        let mut made = match &wheel.suspension {
            Some(spring) => Wheel::new(self.spring(&place.key("suspension"), spring)?),
            None => Wheel::rigid(),
        };
        if let Some([min, max]) = wheel.travel {
            if wheel.suspension.is_none() {
                let allowed = "a suspension beside it";
                return Err(self.fail(&place.key("travel"), "there is no spring", allowed));
            }
            made = made.with_travel(min.0, max.0);
        }
        if let Some(spin) = &wheel.spin {
            made.spin = self.axis(&place.key("spin"), spin)?;
        }
        if let Some(steering) = &wheel.steering {
            made.steering = self.axis(&place.key("steering"), steering)?;
        }
        Ok(made.into())
    }

    fn axis(&self, place: &Place, axis: &document::Axis) -> Result<JointAxis, SceneError> {
        let is_locked = axis.locked.unwrap_or(false);
        let motion = match axis.limits {
            Some(_) if is_locked => {
                let allowed = "a locked axis, or limits";
                return Err(self.fail(&place.key("limits"), "the axis is locked", allowed));
            }
            Some([min, max]) => {
                if !(max.0 >= min.0) {
                    let problem = format!("is [{}, {}]", min.0, max.0);
                    let allowed = "the least coordinate, then the greatest";
                    return Err(self.fail(&place.key("limits"), problem, allowed));
                }
                let at = place.key("limit_spring");
                let spring = axis.limit_spring.as_ref().map(|s| self.spring(&at, s)).transpose()?;
                JointMotion::Limited { min: min.0, max: max.0, spring }
            }
            None if axis.limit_spring.is_some() => {
                let at = place.key("limit_spring");
                return Err(self.fail(&at, "there are no limits", "limits beside it"));
            }
            None if is_locked => JointMotion::Locked,
            None => JointMotion::Free,
        };
        let drive = match (&axis.motor, &axis.drive) {
            (Some(_), Some(_)) => {
                return Err(self.fail(&place.key("drive"), "there is a motor too", "one of them"));
            }
            (Some(motor), None) => Some(JointDrive::motor(motor.speed, motor.max_force.0)),
            (None, Some(drive)) => Some(JointDrive {
                position: drive.position.unwrap_or(0.0),
                velocity: drive.velocity.unwrap_or(0.0),
                spring: self.spring(&place.key("drive").key("spring"), &drive.spring)?,
                max_force: drive.max_force.map_or(f32::INFINITY, |v| v.0),
            }),
            (None, None) => None,
        };
        Ok(JointAxis { motion, drive, friction: axis.friction.map_or(0.0, |v| v.0) })
    }

    fn spring(&self, place: &Place, spring: &document::Spring) -> Result<JointSpring, SceneError> {
        let document::Spring { stiffness, damping, per_mass, hertz, damping_ratio } = spring;
        let by_force = stiffness.is_some() || damping.is_some() || per_mass.is_some();
        match (hertz, damping_ratio) {
            (None, None) if by_force => Ok(JointSpring {
                stiffness: stiffness.unwrap_or(0.0),
                damping: damping.map_or(0.0, |v| v.0),
                per_mass: per_mass.unwrap_or(false),
            }),
            (Some(hertz), ratio) if !by_force => {
                Ok(JointSpring::hertz(*hertz, ratio.unwrap_or(1.0)))
            }
            _ => {
                let allowed = "stiffness and damping, or hertz and damping_ratio";
                Err(self.fail(place, "it is not one law", allowed))
            }
        }
    }
}

fn strength(strength: &document::JointStrength) -> JointStrength {
    let most = |value: Option<f32>| value.unwrap_or(f32::INFINITY);
    JointStrength {
        force: most(strength.force),
        torque: most(strength.torque),
        impulse: most(strength.impulse),
        fatigue: strength.fatigue.as_ref().map(|f| Fatigue {
            life: f.life,
            exponent: f.exponent,
            endurance: f.endurance,
        }),
    }
}
