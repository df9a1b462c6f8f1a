//! Scenes of bodies without joints.

use drystone::{BodyDef, Quat, Shape, ShapeDef, Vec3, vec3};

use super::draw::{Draw, Solid};
use super::floors::Floor;
use crate::op::{BodyCall, Form, Op, ShapePlan};

impl Draw {
    pub(super) fn throws(&mut self) {
        let v = self.speed() * self.rng.scale(0.3, 8.0);
        let (time, size) = (self.time(), self.size);
        // The sliding distance on friction of 0.3, and a margin.
        let way = v * time + 2.0 * v * v / self.gravity;
        self.floor(20.0 * size + way.min(1000.0 * size));
        let count = self.rng.from_to(1, 3);
        for i in 0_u8..3 {
            if usize::from(i) >= count {
                break;
            }
            let solid = self.solid();
            let solid = if self.rng.chance(0.6) { self.turned(solid) } else { solid };
            let height = solid.depth() + size * self.rng.between(0.05, 2.0);
            let position = vec3(-2.0 * size, height, 3.0 * size * f32::from(i));
            let down = self.rng.between(-0.5, 0.3);
            let linear_velocity = vec3(1.0, down, self.rng.between(-0.3, 0.3)) * v;
            let spin = (2.0 * v / size * self.rng.unit()).min(0.5 / self.dt);
            let angular_velocity = self.rng.direction() * spin;
            let def = BodyDef { position, linear_velocity, angular_velocity, ..BodyDef::default() };
            self.body(&solid, def);
        }
        self.run_to_rest();
    }

    fn turned(&mut self, solid: Solid) -> Solid {
        let rotation = self.rng.rotation() * solid.rotation;
        solid.turned(rotation)
    }

    pub(super) fn spins(&mut self) {
        self.floor(30.0 * self.size);
        let solid = self.solid();
        let solid = if self.rng.chance(0.3) { self.turned(solid) } else { solid };
        let spin = (self.rng.scale(1.0, 16.0) / self.time()).min(0.5 / self.dt);
        let axis = self.rng.pick(&[Vec3::X, Vec3::Y, Vec3::Z, vec3(0.1, 1.0, 0.05)]);
        let height = solid.depth() + self.size * self.rng.pick(&[0.0, 0.01, 0.3]);
        let position = vec3(0.1 * self.size, height, 0.2 * self.size);
        let angular_velocity = axis.normalize_or(Vec3::Y) * spin;
        self.body(&solid, BodyDef { position, angular_velocity, ..BodyDef::default() });
        self.run_to_rest();
    }

    pub(super) fn drops(&mut self) {
        self.is_still_time = self.rng.chance(0.5);
        let size = self.size;
        self.floor(30.0 * size);
        let count = self.rng.from_to(1, 2);
        let is_flat = self.rng.chance(0.6);
        for i in 0..count {
            let at = vec3(0.1 * size, 0.0, if i == 0 { 0.15 * size } else { 4.0 * size });
            let mut ground = 0.0;
            let solid = if is_flat {
                let h = self.proportions();
                let under = self.block(vec3(h.x, h.x, h.x));
                if self.rng.chance(0.35) {
                    self.put(&under, at + vec3(0.0, h.x, 0.0));
                    ground = 2.0 * h.x;
                }
                self.block(h)
            } else {
                let solid = self.solid();
                self.turned(solid)
            };
            let height = ground + solid.depth() + size * self.rng.scale(0.1, 8.0);
            self.put(&solid, at + vec3(0.0, height, 0.0));
        }
        self.run_to_rest();
    }

    pub(super) fn stacks(&mut self) {
        self.material.friction = self.material.friction.max(0.3);
        self.material.restitution = 0.0;
        self.floor(30.0 * self.size);
        let count = self.rng.from_to(2, 8);
        let is_even = self.rng.chance(0.6);
        let mut h = self.block_size();
        let mut top = 0.0;
        for _ in 0..count {
            if !is_even {
                h = self.block_size();
            }
            let block = self.block(h);
            let off = 0.1 * h.x.min(h.z);
            let (x, z) = (self.rng.between(-off, off), self.rng.between(-off, off));
            self.put(&block, vec3(0.1 * self.size + x, top + h.y, 0.2 * self.size + z));
            top += 2.0 * h.y;
        }
        self.run_to_rest();
    }

    /// Half extents of a block for a stack: a cube, or a card.
    fn block_size(&mut self) -> Vec3 {
        let s = 0.5 * self.size;
        let flat = if self.rng.chance(0.6) { 1.0 } else { self.rng.scale(0.02, 0.5) };
        vec3(s, (s * flat * self.rng.between(0.8, 1.0)).max(0.2e-3), s)
    }

    pub(super) fn slides(&mut self) {
        let floor = self.rng.pick(&Floor::WHOLE);
        self.slide_over(floor);
    }

    pub(super) fn rows(&mut self) {
        let floor = self.rng.pick(&Floor::ROWS);
        self.slide_over(floor);
    }

    fn slide_over(&mut self, floor: Floor) {
        self.material.restitution = 0.0;
        if self.rng.chance(0.5) {
            self.material.friction = 0.0;
        }
        let v = self.speed() * self.rng.scale(0.2, 6.0);
        let half = 12.0 * self.size;
        self.floor_of(floor, half);
        let s = 0.5 * self.size;
        let solid = if self.rng.chance(0.3) {
            Solid::of(Shape::sphere(s))
        } else {
            // Flat enough that friction tips nothing over.
            let h = vec3(s, s * self.rng.scale(0.1, 0.5), s * self.rng.between(0.5, 1.0));
            self.block(h)
        };
        let solid = if self.rng.chance(0.5) {
            solid.turned(Quat::from_axis_angle(Vec3::Y, self.rng.between(0.0, 1.5)))
        } else {
            solid
        };
        // From before the seam at x = 0 across it.
        let position = vec3(-1.7 * self.size, solid.depth(), 0.13 * self.size);
        let linear_velocity = vec3(v, 0.0, 0.0);
        self.body(&solid, BodyDef { position, linear_velocity, ..BodyDef::default() });
        let seconds = if self.material.friction > 0.0 { 60.0 } else { 2.0 * half / v };
        self.run(seconds);
    }

    pub(super) fn sleepers(&mut self) {
        self.material.friction = self.material.friction.max(0.3);
        self.material.restitution = 0.0;
        let size = self.size;
        let floor = self.floor(40.0 * size);
        let count = self.rng.from_to(1, 4);
        let h = Vec3::splat(0.5 * size);
        let mut labels = Vec::new();
        for i in 0_u8..4 {
            if usize::from(i) < count {
                let block = self.block(h);
                let at = vec3(0.1 * size, h.y * (2.0 * f32::from(i) + 1.0), 0.2 * size);
                labels.push(self.put(&block, at));
            }
        }
        self.is_still_time = true;
        self.run((20.0 * self.time()).max(2.0));
        let target = self.rng.pick(&labels);
        let at = vec3(0.1 * size, h.y, 0.2 * size);
        let ball = Solid::of(Shape::sphere(0.3 * size));
        let v = self.speed() * self.rng.scale(0.5, 8.0);
        match self.rng.below(5) {
            0 => {
                let position = at + vec3(-3.0 * size, 0.0, 0.0);
                let linear_velocity = vec3(v, 0.0, 0.0);
                self.body(&ball, BodyDef { position, linear_velocity, ..BodyDef::default() });
            }
            1 => {
                // A wall placed half into sleeping bodies, as a player might build it.
                let wall = Solid::of(Shape::box_half(h));
                let position = at + vec3(0.4 * size, 0.0, 0.0);
                let def = BodyDef { position, ..BodyDef::fixed() };
                self.body(&wall, def);
            }
            2 => {
                // The lowest block is removed.
                self.ops.push(Op::RemoveBody(labels[0]));
            }
            3 if floor == Floor::Kinematic => {
                let sink = vec3(0.0, -0.02 * self.speed(), 0.0);
                self.ops.push(Op::Body(1, BodyCall::LinearVelocity(sink)));
            }
            _ => {
                let push = vec3(1.0, 0.3, 0.0) * (v * 1000.0 * size * size * size);
                self.ops.push(Op::Body(target, BodyCall::Impulse(push)));
            }
        }
        self.run_to_rest();
    }

    pub(super) fn shots(&mut self) {
        self.config.gravity = Vec3::ZERO;
        self.material.restitution = 0.0;
        self.is_still_time = true;
        let (size, dt) = (self.size, self.dt);
        let ball = Solid::of(Shape::sphere(size * self.rng.scale(0.02, 0.2)));
        // The speed is some thicknesses of its target per step.
        let thick = size * self.rng.scale(0.02, 0.3);
        let v = thick * self.rng.scale(1.0, 16.0) / dt;
        let at = vec3(0.0, 0.05 * size, 0.07 * size);
        match self.rng.below(4) {
            0 => {
                let plate = Solid::of(Shape::box_half(vec3(0.5 * thick, size, size)));
                self.put(&plate, Vec3::ZERO);
            }
            1 => {
                let plate = Solid::of(Shape::box_half(vec3(0.5 * thick, size, size)));
                self.carrier(&plate, Vec3::ZERO, Vec3::ZERO, Vec3::ZERO);
            }
            2 => {
                let plate = Solid::of(Shape::box_half(vec3(0.5 * thick, size, size)));
                let toward = vec3(-v, 0.0, 0.0);
                self.carrier(&plate, vec3(2.3 * size, 0.0, 0.0), toward, Vec3::ZERO);
            }
            _ => {
                let position = vec3(3.0 * size, 0.05 * size, 0.07 * size);
                let linear_velocity = vec3(-v, 0.0, 0.0);
                self.body(&ball, BodyDef { position, linear_velocity, ..BodyDef::default() });
            }
        }
        let start = self.rng.between(-2.0, -1.5);
        let position = at + vec3(start * size, 0.0, 0.0);
        let linear_velocity = vec3(v, 0.0, 0.0);
        self.body(&ball, BodyDef { position, linear_velocity, ..BodyDef::default() });
        self.run(8.0 * size / v + 30.0 * dt);
    }

    pub(super) fn gates(&mut self) {
        self.is_still_time = true;
        let size = self.size;
        let solid = self.solid();
        let v = size * self.rng.scale(0.02, 4.0) / self.dt;
        let thick = size * self.rng.scale(0.1, 4.0);
        let half = vec3(0.5 * thick, 4.0 * size, 4.0 * size);
        let label = self.label();
        let def = ShapeDef { sensor: true, ..ShapeDef::sphere(1.0) };
        let form = Form::Plain(Shape::box_half(half));
        let shapes = vec![ShapePlan { label: self.label(), form, def }];
        let position = vec3(2.0 * size + thick, 0.0, 0.0);
        let def = BodyDef { position, ..BodyDef::fixed() };
        let plan = crate::op::BodyPlan { label, def, shapes, glue: None };
        self.ops.push(Op::AddBody(Box::new(plan)));
        self.config.gravity = Vec3::ZERO;
        let start = self.rng.between(-1.0, 0.0);
        let position = vec3(start * size, 0.3 * size, 0.2 * size);
        let linear_velocity = vec3(v, 0.0, 0.0);
        let angular_velocity = self.rng.direction() * (0.1 / self.dt * self.rng.unit());
        let def = BodyDef { position, linear_velocity, angular_velocity, ..BodyDef::default() };
        self.body(&solid, def);
        self.run((8.0 * size + 2.0 * thick) / v);
    }

    pub(super) fn drifts(&mut self) {
        self.config.gravity = Vec3::ZERO;
        let size = self.size;
        let count = self.rng.from_to(1, 5);
        let v = size * self.rng.scale(0.02, 8.0);
        for i in 0_u8..5 {
            if usize::from(i) >= count {
                break;
            }
            let solid = self.solid();
            let solid = self.turned(solid);
            let position =
                vec3(2.0 * f32::from(i) - 4.0, 0.0, 0.0) * size + self.rng.vector(0.2 * size);
            let linear_velocity = -position * (v / size * 0.3) + self.rng.vector(0.3 * v);
            let spin = (v / size).min(0.3 / self.dt);
            let angular_velocity = self.rng.direction() * spin;
            let def = BodyDef { position, linear_velocity, angular_velocity, ..BodyDef::default() };
            self.body(&solid, def);
        }
        self.run(20.0);
    }

    pub(super) fn spawns(&mut self) {
        self.material.restitution = 0.0;
        if self.rng.chance(0.5) {
            self.config.gravity = Vec3::ZERO;
        } else {
            self.floor(60.0 * self.size);
        }
        let h = self.proportions();
        let block = self.block(h);
        let count = self.rng.from_to(2, 8);
        for _ in 0..count {
            let off = self.rng.vector(0.02 * self.size);
            self.put(&block, vec3(0.0, block.depth() + 0.1 * self.size, 0.0) + off);
        }
        self.run((10.0 * self.time()).clamp(2.0, 20.0));
    }
}
