//! Joints of every kind, initially closed, except in torture.

use core::f32::consts::PI;

use drystone::breakage::{Fatigue, JointStrength};
use drystone::joint::{
    ConeTwist, Cylindrical, Fixed, Hinge, JointAxis, JointDrive, JointMotion, JointSpring, Planar,
    Pulley, Servo, SixDof, Slider, Spring, Universal, Wheel,
};
use drystone::{Axis, BodyKind, JointKind, Vec3, vec3};

use super::draw::{Draw, KnownBody, KnownJoint};
use crate::op::{CouplingPlan, JointPlan, Op, Place, Style};

impl Draw {
    /// Adds a chain or a tree of bodies, each joined to an earlier one.
    pub(super) fn mechanism(&mut self) {
        let count = self.rng.from_to(2, 5);
        let is_articulated = self.rng.chance(0.4);
        let is_chain = self.rng.chance(0.6);
        let root = match self.rng.below(3) {
            0 => BodyKind::Static,
            1 => BodyKind::Dynamic,
            _ => BodyKind::Kinematic,
        };
        let height = 4.0 * self.size + self.rng.between(0.0, 8.0) * self.size;
        let start = vec3(-3.0 * self.size, height, 0.0) + self.offset(2.0);
        let rotation = self.rng.rotation();
        let mut links = vec![self.link(start, rotation, root)];
        let along = self.rng.direction();
        for _ in 0..count {
            let last = links.len() - 1;
            let to = if is_chain { last } else { self.rng.below(links.len()) };
            let a = links[to].clone();
            let away = if is_chain { along } else { self.rng.direction() };
            let rotation = self.rng.rotation();
            let b = self.link(Vec3::ZERO, rotation, BodyKind::Dynamic);
            let meet = a.position + away * a.radius;
            let position = meet + away * b.radius;
            let b = self.put_last(position, b);
            self.joint(&a, &b, meet, is_articulated);
            links.push(b);
        }
    }

    /// Moves the body that was added last.
    fn put_last(&mut self, position: Vec3, mut body: KnownBody) -> KnownBody {
        if let Some(Op::AddBody(plan)) = self.ops.last_mut() {
            plan.def.position = position;
        }
        body.position = position;
        if let Some(last) = self.bodies.last_mut() {
            last.position = position;
        }
        body
    }

    /// Adds a joint between two existing bodies, at a point between them.
    pub(super) fn joint_between_any(&mut self) {
        let (Some(a), Some(b)) = (self.any_body(), self.any_body()) else { return };
        if a.label == b.label {
            return;
        }
        let meet = (a.position + b.position) * 0.5;
        let is_articulated = self.rng.chance(0.3);
        self.joint(&a, &b, meet, is_articulated);
    }

    fn joint(&mut self, a: &KnownBody, b: &KnownBody, meet: Vec3, articulated: bool) {
        let local = |body: &KnownBody, p: Vec3| body.rotation.unrotate(p - body.position);
        let mut anchors = [local(a, meet), local(b, meet)];
        if self.style == Style::Torture && self.rng.chance(0.5) {
            let half = self.rng.pick(&[0.1, 1.0, 10.0]);
            anchors = [self.rng.vector(half), self.rng.vector(half)];
        }
        let label = self.label();
        let mut place = Place::Anchors(anchors[0], anchors[1]);
        let mut known = KnownJoint { label, free_axes: Vec::new(), is_six: false };
        let kind = match self.rng.weighted(&[2.5, 2.5, 5.0, 0.7]) {
            0 => JointKind::Ball,
            1 => {
                anchors = [Vec3::ZERO, anchors[1] * 0.5];
                place = Place::Anchors(anchors[0], anchors[1]);
                let [p, q] = [a.position, b.position + b.rotation.rotate(anchors[1])];
                self.distance((p - q).length())
            }
            2 => {
                if self.style != Style::Torture || self.rng.chance(0.5) {
                    place = Place::Along(meet, self.rng.direction());
                }
                let axes = self.six();
                known.is_six = true;
                known.free_axes = free_axes(&axes);
                JointKind::SixDof(axes)
            }
            _ => {
                let points = [a, b].map(|body| body.position + vec3(0.0, 5.0, 0.0));
                let lengths = [5.0 - anchors[0].y, 5.0 - anchors[1].y];
                anchors = [Vec3::ZERO; 2];
                place = Place::Anchors(anchors[0], anchors[1]);
                let ratio = self.rng.pick(&[0.5, 1.0, 1.0, 2.0]);
                let length = if self.style == Style::Torture {
                    lengths[0].abs() + 0.1
                } else {
                    5.0 + 5.0 * ratio
                };
                let is_rigid = self.rng.chance(0.3);
                JointKind::Pulley(Pulley { points, length, ratio, is_rigid })
            }
        };
        let strength = if self.rng.chance(0.12) { Some(self.strength()) } else { None };
        let collide_connected = self.rng.chance(0.15);
        let bodies = [a.label, b.label];
        let enabled = !self.rng.chance(0.02);
        let plan = JointPlan {
            label,
            bodies,
            place,
            kind,
            collide_connected,
            strength,
            articulated,
            enabled,
        };
        self.ops.push(Op::AddJoint(Box::new(plan)));
        self.joints.push(known);
    }

    pub(super) fn distance(&mut self, now: f32) -> JointKind {
        let now = if self.style == Style::Torture { now * self.rng.scale(0.1, 10.0) } else { now };
        match self.rng.below(4) {
            0 => JointKind::Distance { min: now, max: now, spring: None },
            1 => JointKind::Distance { min: 0.0, max: now, spring: None },
            2 => JointKind::Distance { min: 0.5 * now, max: 1.5 * now, spring: None },
            _ => {
                let rest_length = now * self.rng.between(0.7, 1.3);
                let (hertz, damping_ratio) =
                    (self.rng.scale(0.5, 30.0), self.rng.pick(&[0.0, 0.2, 1.0, 2.0]));
                let spring = Some(Spring { rest_length, hertz, damping_ratio });
                JointKind::Distance { min: 0.0, max: 10.0 * now, spring }
            }
        }
    }

    pub(super) fn strength(&mut self) -> JointStrength {
        let force = 3.0e4 * self.size * self.size * self.size * self.rng.scale(0.01, 30.0);
        let mut strength = JointStrength { force, ..JointStrength::default() };
        if self.rng.chance(0.5) {
            strength.torque = force * self.size;
        }
        if self.rng.chance(0.3) {
            strength.impulse = 0.05 * force;
        }
        if self.rng.chance(0.3) {
            let (life, endurance) = (self.rng.scale(0.1, 10.0), self.rng.between(0.0, 0.8));
            let exponent = self.rng.pick(&[1, 3, 10, 32]);
            strength.fatigue = Some(Fatigue { life, exponent, endurance });
        }
        strength
    }

    /// Random axes of a six-axis joint, in all forms.
    pub(super) fn six(&mut self) -> SixDof {
        let spring = self.spring();
        let force = self.drive_force();
        let torque = force * self.size;
        match self.rng.below(13) {
            0 | 1 => Hinge::of(self.axis(true)).six_dof(),
            2 => Slider::of(self.axis(false)).six_dof(),
            3 => Cylindrical::of(self.axis(false), self.axis(true)).six_dof(),
            4 => Universal::of(self.axis(true), self.axis(true)).six_dof(),
            5 => Planar::new().six_dof(),
            6 => {
                let twist = self.axis(true);
                let joint =
                    ConeTwist::of(twist, self.rng.between(0.1, 1.5), self.rng.between(0.1, 1.5));
                let joint =
                    if self.rng.chance(0.3) { joint.with_soft_cone(self.spring()) } else { joint };
                joint.six_dof()
            }
            7 => Servo::new(spring, force, torque).six_dof(),
            8 => Servo::grab(spring, force).six_dof(),
            9 => {
                let max = 0.3 * self.size;
                let wheel = Wheel::new(spring).with_travel(-max, max);
                let wheel = Wheel { spin: self.axis(true), ..wheel };
                if self.rng.chance(0.5) { wheel } else { wheel.with_steering(0.3, spring, torque) }
                    .six_dof()
            }
            10 if self.rng.chance(0.5) => Fixed::soft(spring).six_dof(),
            10 => SixDof::FIXED,
            11 => SixDof { angular: [JointAxis::FREE; 3], ..SixDof::FIXED },
            _ => {
                let mut some = |turns: bool| {
                    [0; 3].map(|_| {
                        if self.rng.chance(0.5) { JointAxis::LOCKED } else { self.axis(turns) }
                    })
                };
                SixDof { linear: some(false), angular: some(true), ..SixDof::FIXED }
            }
        }
    }

    pub(super) fn drive_force(&mut self) -> f32 {
        if self.rng.chance(0.15) {
            return f32::INFINITY;
        }
        1.0e4 * self.size * self.size * self.size * self.rng.scale(0.01, 10.0)
    }

    pub(super) fn spring(&mut self) -> JointSpring {
        if self.rng.chance(0.6) {
            return JointSpring::hertz(
                self.rng.scale(0.5, 20.0),
                self.rng.pick(&[0.0, 0.3, 1.0, 2.0]),
            );
        }
        let mass = 1000.0 * self.size * self.size * self.size;
        let stiffness = mass * self.rng.scale(1.0, 1.0e4);
        JointSpring::new(stiffness, self.rng.between(0.0, 0.2) * stiffness)
    }

    fn axis(&mut self, turns: bool) -> JointAxis {
        let reach = if turns { PI } else { 2.0 * self.size };
        let mut axis = JointAxis::FREE;
        if self.rng.chance(0.4) {
            let (min, max) = (-reach * self.rng.unit(), reach * self.rng.unit());
            let spring = if self.rng.chance(0.3) { Some(self.spring()) } else { None };
            axis.motion = JointMotion::Limited { min, max, spring };
        }
        if self.rng.chance(0.35) {
            axis.drive = Some(self.drive(turns));
        }
        if self.rng.chance(0.2) {
            axis.friction = 0.1 * self.drive_force();
        }
        axis
    }

    pub(super) fn drive(&mut self, turns: bool) -> JointDrive {
        let reach = if turns { PI } else { self.size };
        let max_force = self.drive_force();
        if self.rng.chance(0.5) {
            return JointDrive::motor(self.rng.between(-3.0, 3.0) * reach, max_force);
        }
        let spring = self.spring();
        JointDrive::servo(self.rng.between(-reach, reach), spring, max_force)
    }

    /// Adds couplings between joints with suitable axes.
    pub(super) fn couplings(&mut self) {
        if !self.rng.chance(0.3) {
            return;
        }
        self.coupling();
    }

    pub(super) fn coupling(&mut self) {
        let some: Vec<KnownJoint> =
            self.joints.iter().filter(|j| !j.free_axes.is_empty()).cloned().collect();
        if some.is_empty() {
            return;
        }
        let (a, b) = (&some[self.rng.below(some.len())], &some[self.rng.below(some.len())]);
        let axes = [self.rng.pick(&a.free_axes), self.rng.pick(&b.free_axes)];
        let label = self.label();
        let ratio = self.rng.pick(&[-1.0, 1.0, 0.5, -2.0, 0.1, 10.0]);
        let joints = [a.label, b.label];
        self.ops.push(Op::AddCoupling(CouplingPlan { label, joints, axes, ratio, offset: 0.0 }));
        self.joints.push(KnownJoint { label, free_axes: Vec::new(), is_six: false });
    }
}

fn free_axes(six: &SixDof) -> Vec<Axis> {
    if six.cone.is_some() {
        return Vec::new();
    }
    let is_free = |axis: &Axis| six.axis(*axis).motion != JointMotion::Locked;
    Axis::ALL.iter().copied().filter(is_free).collect()
}
