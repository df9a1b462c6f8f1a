//! A world under construction: its scale, and bodies of every shape.

use core::f32::consts::FRAC_PI_2;

use drystone::{BodyDef, BodyKind, Material, Pose, Quat, Shape, ShapeDef, Vec3, WorldConfig, vec3};

use super::Scene;
use super::floors::{FIRST_BODY, Floor, floor_ops};
use super::measures::support;
use crate::apply;
use crate::op::{BodyPlan, Form, Label, Op, Program, ShapePlan, Style};
use crate::rng::{Rng, mix};

/// One or several shapes of a body.
#[derive(Clone, Debug)]
pub(super) struct Solid {
    pub(super) parts: Vec<(Form, Pose)>,
    /// Rotation of the body.
    pub(super) rotation: Quat,
}

impl Solid {
    pub(super) fn of(shape: Shape) -> Self {
        Self { parts: vec![(Form::Plain(shape), Pose::IDENTITY)], rotation: Quat::IDENTITY }
    }

    pub(super) fn turned(self, rotation: Quat) -> Self {
        Self { rotation, ..self }
    }

    /// Maximum extent from its origin along a direction of the world [m].
    pub(super) fn reach(&self, along: Vec3) -> f32 {
        let reach = |(form, pose): &(Form, Pose)| {
            let shape = apply::shape(form).unwrap_or(Shape::sphere(1.0));
            let d = self.rotation.unrotate(along);
            pose.position.dot(d) + support(&shape, pose.rotation.unrotate(d))
        };
        self.parts.iter().map(reach).fold(f32::MIN, f32::max)
    }

    /// Depth of its lowest point below its origin [m].
    pub(super) fn depth(&self) -> f32 {
        self.reach(-Vec3::Y)
    }
}

/// A world under construction.
#[derive(Clone, Debug)]
pub(super) struct Draw {
    pub(super) rng: Rng,
    pub(super) ops: Vec<Op>,
    pub(super) config: WorldConfig,
    /// Typical length [m].
    pub(super) size: f32,
    /// Acceleration downward [m/s²]; positive.
    pub(super) gravity: f32,
    /// Length of steps [s].
    pub(super) dt: f32,
    pub(super) material: Material,
    pub(super) is_still_time: bool,
    next: Label,
}

impl Draw {
    pub(super) fn new(seed: u64, scene: Scene) -> Self {
        let mut rng = Rng::new(mix(seed ^ 0x0048_554e_5400) ^ scene as u64);
        let size = match rng.weighted(&[5.0, 2.5, 2.5]) {
            0 => rng.scale(0.1, 2.0),
            1 => rng.scale(0.002, 0.1),
            _ => rng.scale(2.0, 100.0),
        };
        let hertz = rng.pick(&[30.0_f32, 60.0, 60.0, 60.0, 120.0, 240.0]);
        let dt = 1.0 / hertz;
        let gravity = if rng.chance(0.6) { 9.81 } else { rng.scale(0.01, 1000.0) };
        // Steps in which bodies fall by several of their own lengths would reveal nothing.
        let gravity = gravity.min(2.0 * size / (dt * dt));
        let restitution = if rng.chance(0.75) { 0.0 } else { rng.between(0.2, 0.8) };
        let friction = rng.pick(&[0.0, 0.3, 0.6, 0.6, 0.6, 1.0]);
        let rolling_resistance = if rng.chance(0.5) { 0.03 } else { 0.0 };
        let material =
            Material { friction, restitution, rolling_resistance, ..Material::default() };
        let config = WorldConfig { gravity: vec3(0.0, -gravity, 0.0), ..WorldConfig::default() };
        Self {
            rng,
            ops: Vec::new(),
            config,
            size,
            gravity,
            dt,
            material,
            is_still_time: false,
            next: FIRST_BODY,
        }
    }

    pub(super) fn finish(self) -> Program {
        Program { style: Style::Ordinary, config: self.config, ops: self.ops }
    }

    /// Approximate time of a fall by a body's own length [s].
    pub(super) fn time(&self) -> f32 {
        (self.size / self.gravity).sqrt()
    }

    /// Approximate speed after such a fall [m/s].
    pub(super) fn speed(&self) -> f32 {
        (self.size * self.gravity).sqrt()
    }

    pub(super) fn label(&mut self) -> Label {
        self.next += 1;
        self.next
    }

    /// Adds a floor of any kind with this half length [m].
    pub(super) fn floor(&mut self, half: f32) -> Floor {
        let floor = self.rng.pick(&Floor::WHOLE);
        self.floor_of(floor, half);
        floor
    }

    pub(super) fn floor_of(&mut self, floor: Floor, half: f32) {
        self.ops.extend(floor_ops(floor, half, self.material));
    }

    /// Adds a body, and returns its label.
    pub(super) fn body(&mut self, solid: &Solid, def: BodyDef) -> Label {
        let label = self.label();
        let density = 1000.0;
        let mut shapes = Vec::new();
        for (form, pose) in &solid.parts {
            let def = ShapeDef { material: self.material, density, ..ShapeDef::sphere(1.0) };
            let def = ShapeDef { pose: *pose, ..def };
            shapes.push(ShapePlan { label: self.label(), form: form.clone(), def });
        }
        let def = BodyDef { rotation: solid.rotation, ..def };
        self.ops.push(Op::AddBody(Box::new(BodyPlan { label, def, shapes, glue: None })));
        label
    }

    /// Adds a dynamic body at rest.
    pub(super) fn put(&mut self, solid: &Solid, position: Vec3) -> Label {
        self.body(solid, BodyDef { position, ..BodyDef::default() })
    }

    /// Adds a kinematic body.
    pub(super) fn carrier(&mut self, solid: &Solid, position: Vec3, v: Vec3, w: Vec3) -> Label {
        let kind = BodyKind::Kinematic;
        let def = BodyDef { kind, position, linear_velocity: v, ..BodyDef::default() };
        self.body(solid, BodyDef { angular_velocity: w, ..def })
    }

    /// Random half extents: about equal, one long, or one short; none below half a millimeter.
    pub(super) fn proportions(&mut self) -> Vec3 {
        const LEAST: f32 = 0.5e-3;
        let s = 0.5 * self.size;
        let near = |rng: &mut Rng| rng.between(0.5, 1.0);
        let h = match self.rng.weighted(&[4.0, 2.0, 1.5]) {
            0 => vec3(near(&mut self.rng), near(&mut self.rng), near(&mut self.rng)) * s,
            1 => {
                let thin = self.rng.scale(0.01, 0.3);
                vec3(1.0, thin, thin * near(&mut self.rng)) * s
            }
            _ => vec3(1.0, self.rng.scale(0.01, 0.3), near(&mut self.rng)) * s,
        };
        h.max(Vec3::splat(LEAST))
    }

    /// A body of any shape; its longest axis is x, its shortest y or z.
    pub(super) fn solid(&mut self) -> Solid {
        let h = self.proportions();
        let along_x = Quat::from_axis_angle(Vec3::Z, -FRAC_PI_2);
        match self.rng.weighted(&[1.5, 3.0, 1.5, 1.5, 1.0, 2.0, 1.0]) {
            0 => Solid::of(Shape::sphere(h.x)),
            1 => Solid::of(Shape::box_half(h)),
            2 => {
                let r = h.y.min(h.x);
                Solid::of(Shape::capsule((h.x - r).max(0.0), r)).turned(along_x)
            }
            // A rod lies on its side; a coin lies on its side or on its face.
            3 if h.x > 2.0 * h.z => Solid::of(Shape::cylinder(h.x, h.y)).turned(along_x),
            3 => Solid::of(Shape::cylinder(h.y, h.x)),
            4 => Solid::of(Shape::cone(h.y.max(0.2 * h.x), h.x)),
            5 => self.hull(h),
            _ => self.compound(h),
        }
    }

    /// A hull of 8 to 40 corners on an ellipsoid.
    fn hull(&mut self, h: Vec3) -> Solid {
        let count = self.rng.from_to(8, 40);
        let points = (0..count).map(|_| h.mul_each(self.rng.direction())).collect();
        let parts = vec![(Form::Hull(points), Pose::IDENTITY)];
        let solid = Solid { parts, rotation: Quat::IDENTITY };
        // Corners that all lie on one side make a very thin hull, or none.
        let is_sound = solid.parts.iter().all(|(form, _)| {
            apply::shape(form)
                .and_then(|shape| super::measures::measures(&shape))
                .is_some_and(|m| m.thin > 0.02 * h.min_element())
        });
        if is_sound { solid } else { Solid::of(Shape::box_half(h)) }
    }

    /// Two boxes, or a rod with two balls.
    fn compound(&mut self, h: Vec3) -> Solid {
        let end = |x: f32| Pose::at(vec3(x, 0.0, 0.0));
        let part = |shape: Shape, pose: Pose| (Form::Plain(shape), pose);
        let parts = if self.rng.chance(0.5) {
            let ball = Shape::sphere(0.4 * h.x);
            let rod = Shape::box_half(vec3(h.x, 0.1 * h.x, 0.1 * h.x));
            vec![part(rod, Pose::IDENTITY), part(ball.clone(), end(h.x)), part(ball, end(-h.x))]
        } else {
            let up = Pose::at(vec3(0.5 * h.x, h.x + 0.2 * h.x, 0.0));
            let lying = Shape::box_half(vec3(h.x, 0.2 * h.x, 0.5 * h.x));
            vec![
                part(lying, Pose::IDENTITY),
                part(Shape::box_half(vec3(0.2 * h.x, h.x, 0.5 * h.x)), up),
            ]
        };
        Solid { parts, rotation: Quat::IDENTITY }
    }

    /// A block of these half extents that stands by itself: a box, a cylinder or a prism.
    pub(super) fn block(&mut self, h: Vec3) -> Solid {
        match self.rng.weighted(&[4.0, 1.0, 1.0]) {
            0 => Solid::of(Shape::box_half(h)),
            1 => Solid::of(Shape::cylinder(h.y, h.x.min(h.z))),
            _ => {
                let sides = self.rng.from_to(4, 12);
                let mut points = Vec::new();
                for i in 0..sides {
                    #[expect(clippy::cast_precision_loss, reason = "at most 12")]
                    let part = i as f32 / sides as f32;
                    let (s, c) = drystone::math::trig::sin_cos(2.0 * core::f32::consts::PI * part);
                    points.push(vec3(h.x * c, h.y, h.z * s));
                    points.push(vec3(h.x * c, -h.y, h.z * s));
                }
                Solid {
                    parts: vec![(Form::Hull(points), Pose::IDENTITY)],
                    rotation: Quat::IDENTITY,
                }
            }
        }
    }

    /// Adds steps for this time, of one length or, in a world with varying steps, of several.
    pub(super) fn run(&mut self, seconds: f32) {
        /// Maximum number of steps of one world; more would take too long.
        const MOST: f32 = 6000.0;
        let steps = (seconds / self.dt).clamp(30.0, MOST);
        if !self.is_still_time && self.rng.chance(0.15) {
            let mut left = steps.min(1200.0);
            while left > 0.0 {
                let part = self.rng.pick(&[1.0, 0.5, 0.1, 0.1, 0.01]);
                let count = self.rng.between(20.0, 200.0);
                self.step(self.dt * part, count);
                left -= count;
            }
        }
        self.step(self.dt, steps);
    }

    fn step(&mut self, dt: f32, count: f32) {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "above 0")]
        self.ops.push(Op::Step(dt, count as u32));
    }

    /// Adds steps until everything that can come to rest has done so.
    pub(super) fn run_to_rest(&mut self) {
        let seconds = (60.0 * self.time()).max(60.0);
        self.run(seconds);
    }
}
