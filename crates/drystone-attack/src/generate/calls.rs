//! Calls between the steps: every public function that changes a world.

use drystone::breakage::BondStrength;
use drystone::contact::{ContactSoftness, SurfaceRule};
use drystone::joint::{SixDof, Spring};
use drystone::{Axis, BodyKind, JointKind, Pose, Vec3, WorldConfig};

use super::draw::{Draw, KnownBody};
use crate::op::{BodyCall, JointCall, Op, ParticleCall, ShapeCall, Style};

impl Draw {
    /// Adds one call of any kind.
    pub(super) fn call(&mut self) {
        match self.rng.weighted(&[8.0, 1.0, 1.5, 2.0, 3.0, 1.5, 1.5, 3.0]) {
            0 => self.body_call(),
            1 => self.shape_call(),
            2 => self.addition(),
            3 => self.removal(),
            4 => self.joint_call(),
            5 => self.particle_call(),
            6 => self.world_call(),
            _ => self.query(),
        }
    }

    fn pose_near(&mut self, body: &KnownBody) -> Pose {
        let position = body.position + self.offset(2.0);
        Pose { position, rotation: self.rng.rotation() }
    }

    fn body_call(&mut self) {
        let Some(body) = self.any_body() else { return };
        let point = body.position + self.offset(1.0);
        let call = match self.rng.below(26) {
            0 => BodyCall::Wake,
            1 => BodyCall::Pose(self.pose_near(&body)),
            2 => BodyCall::LinearVelocity(self.speed()),
            3 => BodyCall::AngularVelocity(self.spin()),
            4 => {
                // At most 10 m/s in ordinary worlds: the displacement is up to 3.5 sizes.
                let is_ordinary = self.style == Style::Ordinary;
                let time =
                    if is_ordinary { (0.35 * self.size).max(1.0 / 60.0) } else { 1.0 / 60.0 };
                BodyCall::MoveTo(self.pose_near(&body), time)
            }
            5 => BodyCall::Impulse(self.push()),
            6 => BodyCall::ImpulseAt(self.push() * 0.1, point),
            7 => BodyCall::AngularImpulse(self.push() * (0.05 * self.size)),
            8 => BodyCall::StepForce(self.push() * 10.0),
            9 => BodyCall::StepForceAt(self.push(), point),
            10 => BodyCall::StepTorque(self.push() * self.size),
            11 => BodyCall::LastingForce(self.push()),
            12 => BodyCall::LastingTorque(self.push() * (0.1 * self.size)),
            13 => BodyCall::GravityScale(self.rng.pick(&[0.0, 1.0, -1.0, 3.0])),
            14 => BodyCall::Damping(self.rng.pick(&[0.0, 1.0, 50.0]), self.rng.pick(&[0.0, 1.0])),
            15 => BodyCall::Locks(self.locks()),
            16 => BodyCall::CanSleep(self.rng.chance(0.5)),
            17 | 18 => {
                let kinds = [BodyKind::Static, BodyKind::Kinematic, BodyKind::Dynamic];
                BodyCall::Kind(self.rng.pick(&kinds))
            }
            19 => BodyCall::Mass(self.mass()),
            20 | 21 => BodyCall::Enabled(self.rng.chance(0.5)),
            22 => BodyCall::Sleep,
            23 => BodyCall::SleepSpeed(self.rng.chance(0.7).then(|| self.rng.scale(0.001, 10.0))),
            24 => BodyCall::Correct(self.pose_near(&body), self.speed(), self.spin()),
            _ => BodyCall::UserData(self.rng.bits()),
        };
        let label = self.any_body_or_piece(&body);
        self.ops.push(Op::Body(label, call));
    }

    fn shape_call(&mut self) {
        let Some(body) = self.any_body() else { return };
        if body.shapes.is_empty() {
            return;
        }
        let shape = self.rng.pick(&body.shapes);
        let call = match self.rng.below(13) {
            0 => ShapeCall::Material(self.material()),
            1 => ShapeCall::SurfaceVelocity(self.speed()),
            2 => ShapeCall::SurfaceSpin(self.spin()),
            3 => ShapeCall::Filter(self.filter()),
            4 => ShapeCall::Sensor(self.rng.chance(0.5)),
            5 => ShapeCall::Density(self.rng.scale(10.0, 8000.0)),
            6 => {
                let position = self.offset(0.3);
                ShapeCall::LocalPose(Pose { position, rotation: self.rng.rotation() })
            }
            7 if self.rng.chance(0.1) => ShapeCall::Geometry(self.terrain()),
            7 | 8 => ShapeCall::Geometry(self.convex().0),
            10 => ShapeCall::Reports(self.reports()),
            11 => ShapeCall::Senses(self.senses()),
            12 => {
                let front = self.rng.chance(0.8).then(|| self.speed());
                ShapeCall::OneWay(front)
            }
            _ => ShapeCall::Enabled(self.rng.chance(0.5)),
        };
        self.ops.push(Op::Shape(shape, call));
    }

    fn addition(&mut self) {
        match self.rng.below(5) {
            0 | 1 => self.body(),
            2 => self.joint_between_any(),
            3 => self.attach(),
            _ => {
                let Some(body) = self.any_body() else { return };
                let (form, _) = self.convex();
                let mut plan = self.shape_of(form);
                plan.def.pose = Pose { position: self.offset(1.0), rotation: self.rng.rotation() };
                let label = plan.label;
                self.ops.push(Op::AddShape(body.label, Box::new(plan)));
                if let Some(known) = self.bodies.iter_mut().find(|b| b.label == body.label) {
                    known.shapes.push(label);
                }
            }
        }
    }

    fn removal(&mut self) {
        let (particles, links) = (self.particles.clone(), self.links.clone());
        match self.rng.below(6) {
            0 => {
                let Some(body) = self.any_body() else { return };
                self.ops.push(Op::RemoveBody(body.label));
            }
            1 => {
                let Some(body) = self.any_body() else { return };
                if !body.shapes.is_empty() {
                    let shape = self.rng.pick(&body.shapes);
                    self.ops.push(Op::RemoveShape(shape));
                }
            }
            2 if !self.joints.is_empty() => {
                let label = self.joints[self.rng.below(self.joints.len())].label;
                self.ops.push(Op::RemoveJoint(label));
            }
            3 if !particles.is_empty() => {
                let particle = self.rng.pick(&particles);
                self.ops.push(Op::RemoveParticle(particle));
            }
            4 if !links.is_empty() => {
                let link = self.rng.pick(&links);
                self.ops.push(Op::RemoveLink(link));
            }
            // A piece of a broken body, if any.
            _ => {
                let piece = crate::op::PIECES + self.rng.below_u32(3);
                self.ops.push(Op::RemoveBody(piece));
            }
        }
    }

    fn joint_call(&mut self) {
        if self.joints.is_empty() {
            return;
        }
        let joint = self.joints[self.rng.below(self.joints.len())].clone();
        match self.rng.below(19) {
            0 => {
                let strength = self.rng.chance(0.7).then(|| self.strength());
                self.ops.push(Op::SetJointStrength(joint.label, strength));
            }
            1 => self.coupling(),
            2 | 3 if joint.is_six => {
                let axes = self.six();
                self.ops.push(Op::SetJointAxes(joint.label, Box::new(axes)));
            }
            6 => self.ops.push(Op::Joint(joint.label, JointCall::Enabled(self.rng.chance(0.5)))),
            7 => {
                let (a, b) = (self.offset(0.5), self.offset(0.5));
                self.ops.push(Op::Joint(joint.label, JointCall::Anchors(a, b)));
            }
            8 => {
                let collide = self.rng.chance(0.5);
                self.ops.push(Op::Joint(joint.label, JointCall::CollideConnected(collide)));
            }
            9 => {
                let min = self.length();
                let max = min + self.length();
                self.ops.push(Op::Joint(joint.label, JointCall::Lengths(min, max)));
            }
            10 => {
                let (ratio, offset) = (self.rng.scale(0.1, 10.0), self.rng.between(-0.5, 0.5));
                self.ops.push(Op::Joint(joint.label, JointCall::Coupling(ratio, offset)));
            }
            12 => {
                let call = JointCall::Frames(self.rng.rotation(), self.rng.rotation());
                self.ops.push(Op::Joint(joint.label, call));
            }
            13 => {
                let (rotation, law) = (self.rng.rotation(), self.spring());
                let call = JointCall::TargetRotation(rotation, law, self.drive_force());
                self.ops.push(Op::Joint(joint.label, call));
            }
            14 => {
                let spring = self.rng.chance(0.7).then(|| {
                    let (hertz, ratio) = (self.rng.scale(0.5, 30.0), self.rng.unit());
                    Spring::new(self.length(), hertz, ratio)
                });
                self.ops.push(Op::Joint(joint.label, JointCall::Spring(spring)));
            }
            15 => {
                let (a, b) = (self.rng.between(-2.0, 2.0), self.rng.between(-2.0, 2.0));
                let call = JointCall::Limits(a.min(b), a.max(b));
                self.ops.push(Op::Joint(joint.label, call));
            }
            16 => {
                let call = JointCall::Motor(self.rng.between(-5.0, 5.0), self.drive_force());
                self.ops.push(Op::Joint(joint.label, call));
            }
            17 => {
                let friction = 0.1 * self.drive_force();
                self.ops.push(Op::Joint(joint.label, JointCall::Friction(friction)));
            }
            18 => {
                let kind = match self.rng.below(4) {
                    0 => JointKind::Ball,
                    1 => JointKind::SixDof(SixDof::FIXED),
                    2 => JointKind::SixDof(self.six()),
                    _ => {
                        let now = self.length();
                        self.distance(now)
                    }
                };
                self.ops.push(Op::Joint(joint.label, JointCall::Kind(Box::new(kind))));
            }
            11 if joint.is_six => {
                let (axis, six) = (self.rng.pick(Axis::ALL), self.six());
                let motion = six.axis(axis).motion;
                self.ops.push(Op::Joint(joint.label, JointCall::Motion(axis, motion)));
            }
            _ if joint.is_six => {
                let axis = self.rng.pick(Axis::ALL);
                let drive = self.rng.chance(0.8).then(|| self.drive(axis.is_turn()));
                self.ops.push(Op::SetJointDrive(joint.label, axis, drive));
            }
            _ => {}
        }
    }

    fn particle_call(&mut self) {
        if self.particles.is_empty() {
            return;
        }
        let particles = self.particles.clone();
        let label = self.rng.pick(&particles);
        let call = match self.rng.below(8) {
            0 => ParticleCall::Position(Vec3::Y * (3.0 * self.size) + self.offset(2.0)),
            1 => ParticleCall::Velocity(self.speed()),
            2 => ParticleCall::Impulse(self.rng.vector(0.5)),
            3 => ParticleCall::Mass(self.rng.scale(0.001, 10.0)),
            4 => ParticleCall::Pinned(self.rng.chance(0.5)),
            5 => {
                self.free_link();
                return;
            }
            6 => {
                self.ops.push(Op::Detach(label));
                return;
            }
            _ => {
                if !self.links.is_empty() {
                    let links = self.links.clone();
                    let (link, length) = (self.rng.pick(&links), self.rng.scale(0.05, 2.0));
                    self.ops.push(Op::SetLinkLength(link, length * self.size));
                }
                return;
            }
        };
        self.ops.push(Op::Particle(label, call));
    }

    fn surface_rule(&mut self) -> SurfaceRule {
        let softness = ContactSoftness {
            hertz: self.rng.scale(0.5, 500.0),
            damping_ratio: self.rng.scale(0.01, 10.0),
        };
        SurfaceRule {
            friction: self.rng.chance(0.5).then(|| self.rng.scale(0.01, 2.0)),
            restitution: self.rng.chance(0.3).then(|| self.rng.scale(0.1, 1.0)),
            softness: self.rng.chance(0.7).then_some(softness),
            ..SurfaceRule::ANY
        }
    }

    fn world_call(&mut self) {
        let body = self.any_body().map_or(0, |b| b.label);
        let op = match self.rng.below(11) {
            0 => {
                let mut config = WorldConfig::default();
                if self.rng.chance(0.5) {
                    config = self.config();
                    if config.method.name() == "analytic" {
                        config.method = drystone::method::Method::soft_step();
                    }
                }
                self.change(&mut config);
                Op::SetConfig(Box::new(config))
            }
            1 => Op::SetGravity(self.rng.vector(10.0)),
            2 => Op::WakeAll,
            3 => Op::BeginLedger,
            4 => Op::EndLedger,
            5 => Op::FractureBody(body, self.offset(1.0), self.fracture()),
            6 => Op::SetFracture(body, self.rng.chance(0.7).then(|| self.fracture())),
            8 => Op::ShiftOrigin(self.rng.vector(300.0)),
            9 => {
                let other = self.any_body().map_or(0, |b| b.label);
                let rule = self.rng.chance(0.8).then(|| self.surface_rule());
                Op::SurfaceBetween(body, other, rule)
            }
            7 => Op::SetBondStrength(body, BondStrength::both(self.rng.scale(1.0e3, 1.0e7))),
            _ => Op::FractureBody(body, Vec3::ZERO, self.fracture()),
        };
        self.ops.push(op);
    }
}
