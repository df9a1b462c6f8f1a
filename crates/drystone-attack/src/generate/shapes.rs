//! Shapes of every kind.

use drystone::{Pose, Shape, ShapeDef, Vec3, vec3};

use super::draw::Draw;
use crate::op::{Form, ShapePlan};

impl Draw {
    /// A random convex shape, and the radius of a ball about its origin that contains it [m].
    pub(super) fn convex(&mut self) -> (Form, f32) {
        let [a, b, c] = [self.length(), self.length(), self.length()];
        match self.rng.weighted(&[2.0, 1.5, 3.0, 1.0, 1.0, 1.5]) {
            0 => (Form::Plain(Shape::sphere(a)), a),
            1 => (Form::Plain(Shape::capsule(a, b)), a + b),
            2 => {
                let half = vec3(a, b, c);
                (Form::Plain(Shape::box_half(half)), half.length())
            }
            3 => (Form::Plain(Shape::cylinder(a, b)), vec3(a, b, 0.0).length()),
            4 => {
                let top = self.rng.pick(&[0.0, 0.5 * b, b]);
                let shape = Shape::Cone { half_height: a, radius_bottom: b, radius_top: top };
                (Form::Plain(shape), vec3(a, b, 0.0).length())
            }
            _ => self.hull(a),
        }
    }

    fn hull(&mut self, size: f32) -> (Form, f32) {
        let count = self.rng.from_to(4, 14);
        let is_round = self.rng.chance(0.5);
        let mut point = |_| {
            let p = self.rng.vector(1.0);
            let p = if is_round { p.normalize_or(Vec3::Y) } else { p };
            p * size
        };
        let mut points: Vec<Vec3> = (0..count).map(&mut point).collect();
        if self.rng.chance(0.1) {
            // Duplicate and collinear points, as exporters write them.
            let (first, second) = (points[0], points[1]);
            points.extend([first, (first + second) * 0.5]);
        }
        (Form::Hull(points), 1.8 * size)
    }

    /// A ground: points of a grid with some bumps.
    pub(super) fn terrain(&mut self) -> Form {
        let n = self.rng.from_to(1, 5);
        let side = 4.0 * self.size.max(0.5);
        let rough = if self.rng.chance(0.5) { 0.0 } else { 0.3 * self.size };
        let mut points = Vec::new();
        for k in 0..=n {
            for i in 0..=n {
                #[expect(clippy::cast_precision_loss, reason = "at most 5")]
                let at = |i: usize| side * (i as f32 - 0.5 * n as f32);
                points.push(vec3(at(i), self.rng.between(-rough, rough), at(k)));
            }
        }
        let at = |i: usize, k: usize| u32::try_from(k * (n + 1) + i).unwrap_or(0);
        let mut triangles = Vec::new();
        for k in 0..n {
            for i in 0..n {
                triangles.push([at(i, k), at(i, k + 1), at(i + 1, k)]);
                triangles.push([at(i + 1, k), at(i, k + 1), at(i + 1, k + 1)]);
            }
        }
        Form::Mesh(points, triangles)
    }

    /// A shape from a form, with a random surface and other properties.
    pub(super) fn shape_of(&mut self, form: Form) -> ShapePlan {
        let mut def = ShapeDef::sphere(1.0);
        def.material = self.material();
        def.filter = self.filter();
        if self.rng.chance(0.3) {
            def.density = self.rng.scale(100.0, 8000.0);
        }
        if self.style == crate::op::Style::Torture && self.rng.chance(0.3) {
            def.density = self.rng.scale(1.0e-2, 1.0e6);
        }
        if self.rng.chance(0.07) {
            def.surface_velocity = self.speed();
        }
        if self.rng.chance(0.04) {
            def.surface_spin = self.spin();
        }
        def.sensor = self.rng.chance(0.06);
        def.reports = if self.rng.chance(0.1) { self.reports() } else { def.reports };
        def.senses = if self.rng.chance(0.1) { self.senses() } else { def.senses };
        def.hooks = self.rng.chance(0.05);
        def.enabled = !self.rng.chance(0.02);
        def.one_way = self.rng.chance(0.05).then(|| self.speed());
        ShapePlan { label: self.label(), form, def }
    }

    /// Random shapes of a body, and the radius of a ball about its origin.
    pub(super) fn shapes(&mut self) -> (Vec<ShapePlan>, f32) {
        let count = if self.rng.chance(0.8) { 1 } else { self.rng.from_to(2, 4) };
        let mut shapes = Vec::new();
        let mut radius = 0.0_f32;
        for i in 0..count {
            let (form, own) = self.convex();
            let mut plan = self.shape_of(form);
            let mut away = 0.0;
            if i > 0 || self.rng.chance(0.1) {
                let position = self.rng.direction() * (0.7 * own);
                plan.def.pose = Pose { position, rotation: self.rng.rotation() };
                away = position.length();
            }
            radius = radius.max(away + own);
            shapes.push(plan);
        }
        (shapes, radius)
    }
}
