//! Bodies of every kind, grounds, and breakable bodies.

use drystone::breakage::{BondStrength, Fracture};
use drystone::math::Sym3;
use drystone::{AxisLocks, BodyDef, BodyKind, MassDef, Pose, Quat, Shape, ShapeDef, Vec3, vec3};

use super::draw::{Draw, KnownBody};
use crate::op::{BodyPlan, Form, Op, ShapePlan, Style};

impl Draw {
    /// Adds a ground, if any.
    pub(super) fn scenery(&mut self) {
        let form = match self.rng.weighted(&[4.0, 2.0, 2.0, 1.5, 0.7]) {
            0 => Form::Plain(Shape::half_space(Vec3::Y, 0.0)),
            1 => {
                let half = vec3(20.0, 1.0, 20.0);
                Form::Plain(Shape::box_half(half))
            }
            2 => self.terrain(),
            3 => return,
            // A slope.
            _ => {
                let normal = (Vec3::Y + self.rng.vector(0.7)).normalize_or(Vec3::Y);
                Form::Plain(Shape::half_space(normal, 0.0))
            }
        };
        let below = matches!(form, Form::Plain(Shape::Box { .. }));
        let mut plan = self.shape_of(form);
        plan.def.sensor = false;
        let mut def = BodyDef::fixed();
        if below {
            def.position = vec3(0.0, -1.0, 0.0);
        }
        self.add(def, vec![plan], 0.0);
    }

    /// Adds a body that overlaps no other, except in torture.
    pub(super) fn body(&mut self) {
        let (shapes, radius) = self.shapes();
        let position = self.room(radius);
        let mut def = self.body_def(position);
        if self.rng.chance(0.06) && def.kind == BodyKind::Dynamic {
            self.glued(def);
            return;
        }
        if self.rng.chance(0.15) && def.kind == BodyKind::Kinematic {
            // Moving ground.
            let form = self.terrain();
            let plan = self.shape_of(form);
            self.add(def, vec![plan], 0.0);
            return;
        }
        let is_single = shapes.len() == 1 && !shapes[0].def.sensor;
        let can_break =
            is_single && matches!(shapes[0].form, Form::Hull(_) | Form::Plain(Shape::Box { .. }));
        let exact = matches!(def.mass, MassDef::Exact { .. });
        if can_break && !exact && def.kind == BodyKind::Dynamic && self.rng.chance(0.1) {
            def.fracture = Some(self.fracture());
        }
        self.add(def, shapes, radius);
    }

    /// A free position for a ball of this radius [m].
    fn room(&mut self, radius: f32) -> Vec3 {
        if self.style == Style::Torture {
            let half = self.rng.pick(&[0.0, 0.3, 1.0, 3.0]);
            return vec3(0.0, self.rng.between(0.0, 3.0), 0.0) + self.rng.vector(half);
        }
        let mut spread = 3.0 * self.size.max(radius);
        for _ in 0..40 {
            let way = self.rng.vector(spread);
            let position = vec3(way.x, radius + 0.05 + way.y.abs(), way.z);
            let is_free = |b: &KnownBody| {
                b.radius <= 0.0 || (b.position - position).length() > b.radius + radius
            };
            if self.bodies.iter().all(is_free) {
                return position;
            }
            spread *= 1.1;
        }
        let top = self.bodies.iter().fold(0.0_f32, |top, b| top.max(b.position.y + b.radius));
        vec3(0.0, top + radius, 0.0)
    }

    fn body_def(&mut self, position: Vec3) -> BodyDef {
        let kind = match self.rng.weighted(&[8.0, 1.0, 1.0]) {
            0 => BodyKind::Dynamic,
            1 => BodyKind::Static,
            _ => BodyKind::Kinematic,
        };
        let mut def = BodyDef { kind, position, ..BodyDef::default() };
        if self.rng.chance(0.7) {
            def.rotation = self.rng.rotation();
        }
        if self.rng.chance(0.4) {
            def.linear_velocity = self.speed();
        }
        if self.rng.chance(0.3) {
            def.angular_velocity = self.spin();
        }
        def.mass = self.mass();
        if self.rng.chance(0.1) {
            def.gravity_scale = self.rng.pick(&[0.0, -0.5, 0.5, 2.0]);
        }
        if self.rng.chance(0.1) {
            def.linear_damping = self.rng.scale(0.01, 10.0);
            def.angular_damping = self.rng.scale(0.01, 10.0);
        }
        if self.rng.chance(0.08) {
            def.locks = self.locks();
        }
        def.can_sleep = self.rng.chance(0.9);
        if self.rng.chance(0.1) {
            def.sleep_speed = Some(self.rng.scale(0.001, 1.0));
        }
        def.asleep = self.rng.chance(0.04);
        def.enabled = !self.rng.chance(0.02);
        def
    }

    pub(super) fn mass(&mut self) -> MassDef {
        let usual = 1000.0 * self.size * self.size * self.size;
        let reach = if self.style == Style::Torture { 1.0e4 } else { 10.0 };
        let mass = usual * self.rng.scale(1.0 / reach, reach);
        match self.rng.weighted(&[7.0, 2.0, 1.0]) {
            0 => MassDef::FromShapes,
            1 => MassDef::Mass(mass),
            _ => {
                // Moments of a box: a body whose moments violate the triangle inequality is
                // invalid.
                let [a, b, c] = [0; 3].map(|_| self.size * self.rng.between(0.5, 2.0));
                let m = mass / 3.0;
                let d = vec3(m * (b * b + c * c), m * (a * a + c * c), m * (a * a + b * b));
                let inertia = Sym3::rotated_diagonal(self.rng.rotation(), d);
                MassDef::Exact { mass, center: self.offset(0.2), inertia }
            }
        }
    }

    pub(super) fn locks(&mut self) -> AxisLocks {
        if self.rng.chance(0.3) {
            return self.rng.pick(&[AxisLocks::ROTATION, AxisLocks::PLANE_XY, AxisLocks::NONE]);
        }
        let mut some = || [0; 3].map(|_| self.rng.chance(0.3));
        AxisLocks { linear: some(), angular: some() }
    }

    pub(super) fn fracture(&mut self) -> Fracture {
        let limit = 3000.0 * self.size * self.size * self.size * self.rng.scale(0.001, 10.0);
        let how = if self.rng.chance(0.5) {
            Fracture::by_impulse(limit)
        } else {
            Fracture::by_energy(limit)
        };
        Fracture {
            pieces: self.rng.pick(&[2, 3, 4, 6]),
            min_size: 0.2 * self.size,
            focus: self.rng.below_u32(3),
            generations: self.rng.pick(&[1, 1, 2]),
            seed: self.rng.bits(),
            ..how
        }
    }

    /// Adds a wall of boxes that are glued together.
    fn glued(&mut self, mut def: BodyDef) {
        let half = self.size * self.rng.between(0.2, 0.5);
        let (wide, high) = (self.rng.from_to(1, 3), self.rng.from_to(1, 3));
        let mut shapes = Vec::new();
        for k in 0..high {
            for i in 0..wide {
                #[expect(clippy::cast_precision_loss, reason = "at most 3")]
                let position = vec3(2.0 * half * i as f32, 2.0 * half * k as f32, 0.0);
                let def = ShapeDef::box_half(Vec3::splat(half)).with_pose(Pose::at(position));
                let form = Form::Plain(Shape::box_half(Vec3::splat(half)));
                shapes.push(ShapePlan { label: self.label(), form, def });
            }
        }
        if matches!(def.mass, MassDef::Exact { .. }) {
            def.mass = MassDef::FromShapes;
        }
        let strength = BondStrength::both(self.rng.scale(1.0e3, 1.0e7));
        let gap = 0.01 * half;
        let radius = 8.0 * half;
        def.position = self.room(radius);
        let label = self.add(def, shapes, radius);
        if let Some(Op::AddBody(plan)) = self.ops.last_mut() {
            debug_assert_eq!(plan.label, label);
            plan.glue = Some((gap, strength));
        }
    }

    /// Adds a body with these shapes; returns its label.
    pub(super) fn add(&mut self, def: BodyDef, shapes: Vec<ShapePlan>, radius: f32) -> u32 {
        let label = self.label();
        self.bodies.push(KnownBody {
            label,
            position: def.position,
            rotation: def.rotation,
            radius,
            shapes: shapes.iter().map(|s| s.label).collect(),
        });
        self.ops.push(Op::AddBody(Box::new(BodyPlan { label, def, shapes, glue: None })));
        label
    }

    /// Adds a link of a mechanism at this position and rotation.
    pub(super) fn link(&mut self, position: Vec3, rotation: Quat, kind: BodyKind) -> KnownBody {
        let (form, radius) = self.convex();
        let mut plan = self.shape_of(form);
        plan.def.sensor = false;
        let def = BodyDef { kind, position, rotation, ..BodyDef::default() };
        self.add(def, vec![plan], radius);
        self.bodies[self.bodies.len() - 1].clone()
    }
}
