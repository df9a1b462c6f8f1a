//! Scenes with joints, and with driven or carried bodies.

use core::f32::consts::FRAC_PI_2;

use drystone::joint::{
    ConeTwist, Hinge, JointAxis, JointDrive, JointMotion, JointSpring, SixDof, Slider,
};
use drystone::{Axis, BodyDef, JointKind, MassDef, Pose, Quat, Shape, Vec3, vec3};

use super::draw::{Draw, Solid};
use crate::op::{BodyCall, JointPlan, Label, Op, Place};

/// Size of the smallest assembly [m]: its parts are a twentieth as thick, and none is below 1 mm.
const LEAST: f32 = 0.02;

/// A body with joints.
#[derive(Clone, Copy, Debug)]
struct Part {
    label: Label,
    position: Vec3,
    rotation: Quat,
}

impl Part {
    /// A point of the world in the body's frame.
    fn local(&self, p: Vec3) -> Vec3 {
        self.rotation.unrotate(p - self.position)
    }
}

impl Draw {
    fn part(&mut self, solid: &Solid, position: Vec3, mass: f32) -> Part {
        let def = BodyDef { position, mass: MassDef::Mass(mass), ..BodyDef::default() };
        Part { label: self.body(solid, def), position, rotation: solid.rotation }
    }

    /// Adds a fixed body without a shape.
    fn holder(&mut self, position: Vec3) -> Part {
        let none = Solid { parts: Vec::new(), rotation: Quat::IDENTITY };
        let label = self.body(&none, BodyDef { position, ..BodyDef::fixed() });
        Part { label, position, rotation: Quat::IDENTITY }
    }

    fn join(&mut self, bodies: [Label; 2], place: Place, kind: JointKind) {
        let label = self.label();
        self.ops.push(Op::AddJoint(Box::new(JointPlan {
            label,
            bodies,
            place,
            kind,
            collide_connected: false,
            strength: None,
            articulated: false,
            enabled: true,
        })));
    }

    fn ball(&mut self, a: Part, b: Part, at: Vec3) {
        let place = Place::Anchors(a.local(at), b.local(at));
        self.join([a.label, b.label], place, JointKind::Ball);
    }

    fn six(&mut self, a: Part, b: Part, at: Vec3, axis: Vec3, axes: impl Into<JointKind>) {
        self.join([a.label, b.label], Place::Along(at, axis), axes.into());
    }

    /// The mass of a body of typical size [kg].
    fn mass(&self) -> f32 {
        300.0 * self.size * self.size * self.size
    }

    pub(super) fn assemblies(&mut self) {
        self.size = self.size.max(LEAST);
        self.material.restitution = 0.0;
        self.material.friction = self.material.friction.max(0.6);
        self.floor(60.0 * self.size);
        match self.rng.below(4) {
            0 | 1 => self.table(),
            2 => {
                // A motor brakes its wheels.
                let brake = JointDrive::motor(0.0, 100.0 * self.mass() * self.gravity * self.size);
                self.car(JointAxis::driven(brake));
            }
            _ => self.door(),
        }
        self.run_to_rest();
    }

    /// Adds a table top with legs that are fixed to it.
    fn table(&mut self) {
        let s = self.size;
        let legs = self.rng.pick(&[1_u8, 3, 4, 4]);
        let mass = self.mass();
        let leg_mass = mass / self.rng.scale(1.0, 60.0);
        let lift = if self.rng.chance(0.3) { 0.2 * s } else { 0.0 };
        let top_at = vec3(0.1 * s, 1.05 * s + lift, 0.2 * s);
        let top = self.part(&Solid::of(Shape::box_half(vec3(s, 0.05 * s, 0.6 * s))), top_at, mass);
        for i in 0..legs {
            let (x, z) = match (legs, i) {
                (1, _) => (0.0, 0.0),
                (3, 2) => (0.9, 0.0),
                (3, _) => (-0.9, f32::from(i) - 0.5),
                _ => (if i < 2 { 0.9 } else { -0.9 }, f32::from(i % 2) - 0.5),
            };
            let wide = if legs == 1 { 0.4 } else { 0.05 };
            let leg = Solid::of(Shape::box_half(vec3(wide * s, 0.5 * s, wide * s)));
            let at = top_at + vec3(x * s, -0.55 * s, z * s);
            let leg = self.part(&leg, at, leg_mass);
            self.six(top, leg, at + vec3(0.0, 0.5 * s, 0.0), Vec3::Y, SixDof::FIXED);
        }
    }

    /// Adds a chassis on four wheels.
    fn car(&mut self, spin: JointAxis) {
        let s = self.size;
        let mass = self.mass();
        let wheel_mass = mass / self.rng.scale(4.0, 60.0);
        let is_sprung = self.rng.chance(0.5);
        let r = 0.25 * s;
        let is_round = self.rng.chance(0.3);
        let at = vec3(0.1 * s, r + 0.1 * s, 0.2 * s);
        let body = self.part(&Solid::of(Shape::box_half(vec3(s, 0.15 * s, 0.4 * s))), at, mass);
        for (x, z) in [(0.7, 0.5), (0.7, -0.5), (-0.7, 0.5), (-0.7, -0.5)] {
            let wheel = if is_round { Shape::sphere(r) } else { Shape::cylinder(0.08 * s, r) };
            let wheel = Solid::of(wheel).turned(Quat::from_axis_angle(Vec3::X, FRAC_PI_2));
            let place = vec3(at.x + x * s, r, at.z + z * s);
            let wheel = self.part(&wheel, place, wheel_mass);
            let axes = if is_sprung {
                let hertz = 3.0 * (9.81 / self.gravity).sqrt().recip().min(4.0);
                let reach = 0.1 * s;
                let motion = JointMotion::Limited { min: -reach, max: reach, spring: None };
                let spring = JointSpring::hertz(hertz, 0.7);
                let drive = Some(JointDrive::servo(0.0, spring, f32::INFINITY));
                let suspension = JointAxis { motion, drive, friction: 0.0 };
                // The axle is x, and up is y.
                Hinge::of(spin).six_dof().with_axis(Axis::Y, suspension)
            } else {
                Hinge::of(spin).six_dof()
            };
            self.six(body, wheel, place, Vec3::Z, axes);
        }
    }

    /// Adds a plate that swings on a hinge, and stops at its limit.
    fn door(&mut self) {
        let s = self.size;
        let holder = self.holder(vec3(0.0, 1.2 * s, 0.0));
        let mass = self.mass();
        let at = vec3(0.5 * s, 1.2 * s, 0.0);
        let plate = Solid::of(Shape::box_half(vec3(0.5 * s, s, 0.05 * s)));
        let plate = self.part(&plate, at, mass);
        let friction = 0.05 * mass * self.gravity * s;
        let axis = self.rng.pick(&[Vec3::Y, Vec3::Z, Vec3::X]);
        let hinge = JointAxis::limited(-1.0, 1.0).with_friction(friction);
        self.six(holder, plate, holder.position, axis, Hinge::of(hinge).six_dof());
        let push = vec3(0.0, 0.2, 1.0) * (mass * self.speed() * self.rng.scale(0.1, 2.0));
        self.ops.push(Op::Body(plate.label, BodyCall::Impulse(push)));
    }

    pub(super) fn ragdolls(&mut self) {
        self.size = self.size.max(LEAST);
        self.material.restitution = 0.0;
        self.material.friction = self.material.friction.max(0.6);
        self.material.rolling_resistance = 0.03;
        let s = self.size;
        self.floor(60.0 * s);
        let up = s * self.rng.between(1.0, 2.0);
        let mass = 0.05 * self.mass();
        let thick = self.rng.between(0.7, 1.3);
        let box_of =
            |x: f32, y: f32, z: f32| Solid::of(Shape::box_half(vec3(x, y * thick, z * thick) * s));
        let at = |x: f32, y: f32| vec3(0.1 * s + x * s, up + y * s, 0.2 * s);
        let torso = self.part(&box_of(0.2, 0.3, 0.12), at(0.0, 0.3), 4.0 * mass);
        let head = self.part(&Solid::of(Shape::sphere(0.14 * s)), at(0.0, 0.78), mass);
        let mut joints = vec![(torso, head, at(0.0, 0.62))];
        let has_legs = self.rng.chance(0.8);
        for side in [-1.0_f32, 1.0] {
            let upper = self.part(&box_of(0.16, 0.05, 0.05), at(0.4 * side, 0.52), mass);
            let lower = self.part(&box_of(0.16, 0.045, 0.045), at(0.74 * side, 0.52), mass);
            joints.push((torso, upper, at(0.22 * side, 0.52)));
            joints.push((upper, lower, at(0.57 * side, 0.52)));
            if has_legs {
                let limb = |r: f32| Solid::of(Shape::capsule(0.15 * s, r * s));
                let thigh = self.part(&limb(0.07), at(0.12 * side, -0.25), mass);
                let shin = self.part(&limb(0.06), at(0.12 * side, -0.68), mass);
                joints.push((torso, thigh, at(0.12 * side, -0.02)));
                joints.push((thigh, shin, at(0.12 * side, -0.47)));
            }
        }
        for (a, b, place) in joints {
            let axes = ConeTwist::of(JointAxis::limited(-0.5, 0.5), 0.9, 0.9).six_dof();
            self.six(a, b, place, -Vec3::Y, axes);
        }
        self.run_to_rest();
    }

    pub(super) fn motors(&mut self) {
        self.size = self.size.max(LEAST);
        self.material.restitution = 0.0;
        self.material.friction = 1.0;
        let s = self.size;
        let strong = 100.0 * self.mass() * (self.gravity + s) * s;
        let slow_or_fast = self.rng.scale(0.004, 8.0);
        match self.rng.below(3) {
            0 => {
                // A disc on an axle that is vertical or horizontal.
                let holder = self.holder(vec3(0.0, 2.0 * s, 0.0));
                let axis = self.rng.pick(&[Vec3::Y, Vec3::X]);
                let disc =
                    Solid::of(Shape::cylinder(0.1 * s, s)).turned(Quat::from_arc(Vec3::Y, axis));
                let mass = self.mass();
                let disc = self.part(&disc, holder.position, mass);
                let motor = JointAxis::driven(JointDrive::motor(slow_or_fast, strong));
                self.six(holder, disc, holder.position, axis, Hinge::of(motor).six_dof());
            }
            1 => {
                let holder = self.holder(vec3(0.0, 2.0 * s, 0.0));
                let mass = self.mass();
                let slide = Solid::of(Shape::box_half(Vec3::splat(0.2 * s)));
                let slide = self.part(&slide, holder.position, mass);
                let v = slow_or_fast * s;
                let force = 100.0 * mass * (self.gravity + v);
                let motor = JointAxis::driven(JointDrive::motor(v, force));
                let axis = self.rng.pick(&[Vec3::Y, Vec3::X]);
                self.six(holder, slide, holder.position, axis, Slider::of(motor).six_dof());
            }
            _ => {
                // A driven car.
                self.floor(60.0 * s);
                let torque = 0.1 * self.mass() * self.gravity * s;
                self.car(JointAxis::driven(JointDrive::motor(-slow_or_fast.min(4.0), torque)));
            }
        }
        self.run(20.0);
    }

    pub(super) fn chains(&mut self) {
        self.size = self.size.max(LEAST);
        let s = self.size;
        let count = self.rng.from_to(1, 8);
        let weight = self.rng.scale(1.0, 128.0);
        let is_hinged = self.rng.chance(0.3);
        let direction = self.rng.pick(&[Vec3::X, vec3(0.0, -1.0, 0.0), vec3(0.8, -0.6, 0.0)]);
        let turn = Quat::from_arc(Vec3::Y, direction);
        let mass = self.mass() * 0.003;
        let half = 0.2 * s;
        let mut last = self.holder(Vec3::ZERO);
        let mut end = Vec3::ZERO;
        for _ in 0..count {
            let link = Solid::of(Shape::capsule(0.75 * half, 0.2 * half)).turned(turn);
            let link = self.part(&link, end + direction * half, mass);
            self.link(last, link, end, is_hinged);
            end += direction * (2.0 * half);
            last = link;
        }
        let r = 0.3 * s;
        let ball = self.part(&Solid::of(Shape::sphere(r)), end + direction * r, mass * weight);
        self.link(last, ball, end, is_hinged);
        if self.rng.chance(0.3) {
            let push = vec3(0.5, 0.0, 1.0) * (mass * weight * self.speed());
            self.ops.push(Op::Body(ball.label, BodyCall::Impulse(push)));
        }
        let seconds = (40.0 * self.time()).clamp(5.0, 40.0);
        self.run(seconds);
    }

    fn link(&mut self, a: Part, b: Part, at: Vec3, is_hinged: bool) {
        if is_hinged {
            self.six(a, b, at, Vec3::Z, Hinge::new().six_dof());
        } else {
            self.ball(a, b, at);
        }
    }

    pub(super) fn carriers(&mut self) {
        self.size = self.size.max(LEAST);
        self.material.restitution = 0.0;
        self.material.friction = self.material.friction.max(0.6);
        let s = self.size;
        // From a hundredth of the falling speed up to all of it.
        let v = self.speed() * self.rng.scale(0.005, 1.0);
        let h = Vec3::splat(0.3 * s);
        let load = self.block(h);
        let plate = Solid::of(Shape::box_half(vec3(2.0 * s, 0.1 * s, 2.0 * s)));
        let under = vec3(0.0, -0.1 * s, 0.0);
        let up = vec3(0.1 * s, h.y, 0.2 * s);
        match self.rng.below(6) {
            0 => {
                // A descending lift must never be faster than a body that falls on it.
                let lift = vec3(0.0, if self.rng.chance(0.5) { v } else { -v }, 0.0);
                self.carrier(&plate, under, lift, Vec3::ZERO);
                self.put(&load, up);
            }
            1 => {
                self.carrier(&plate, under, vec3(v, 0.0, 0.0), Vec3::ZERO);
                self.put(&load, up);
            }
            2 => {
                // Half of the friction must hold a body at this distance from the middle, a third
                // of the plate's half width.
                let most = (0.5 * self.material.friction * self.gravity / s).sqrt();
                let w = vec3(0.0, (v / s).min(most), 0.0);
                self.carrier(&plate, under, Vec3::ZERO, w);
                self.put(&load, up + vec3(0.6 * s, 0.0, 0.0));
            }
            3 => {
                self.floor(60.0 * s);
                let door = Solid::of(Shape::box_half(vec3(0.1 * s, s, s)));
                let at = vec3(-0.5 * s, 1.05 * s, 0.2 * s);
                self.carrier(&door, at, vec3(v, 0.0, 0.0), Vec3::ZERO);
                self.put(&load, up);
            }
            4 => {
                let half = 200.0 * s;
                let belt = Solid::of(Shape::box_half(vec3(half, 0.1 * s, 2.0 * s)));
                self.body(&belt, BodyDef { position: under, ..BodyDef::fixed() });
                if let Some(Op::AddBody(plan)) = self.ops.last_mut() {
                    plan.shapes.iter_mut().for_each(|p| p.def.surface_velocity = vec3(v, 0.0, 0.0));
                }
                self.put(&load, up);
            }
            _ => {
                // A crane: a moving holder with a suspended load.
                let none = Solid { parts: Vec::new(), rotation: Quat::IDENTITY };
                let position = vec3(0.0, 3.0 * s, 0.0);
                let is_put = self.rng.chance(0.3);
                let label = if is_put {
                    self.holder(position).label
                } else {
                    self.carrier(&none, position, Vec3::ZERO, Vec3::ZERO)
                };
                let holder = Part { label, position, rotation: Quat::IDENTITY };
                let mass = self.mass();
                let hook = self.part(&load, vec3(0.0, 2.0 * s, 0.0), mass);
                self.ball(holder, hook, holder.position);
                self.is_still_time = true;
                self.run(2.0);
                let call = if is_put {
                    BodyCall::Pose(Pose::at(position + vec3(0.5 * s, 0.0, 0.0)))
                } else {
                    BodyCall::LinearVelocity(vec3(v, 0.0, 0.0))
                };
                self.ops.push(Op::Body(label, call));
            }
        }
        let seconds = (100.0 * s / v).clamp(3.0, 20.0);
        self.run(seconds);
    }
}
