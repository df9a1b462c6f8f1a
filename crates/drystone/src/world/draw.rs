//! Lines and points that show a world: shapes, contacts, joints, boxes. For hosts with their own
//! renderer.

mod limits;
mod outline;

use super::World;
use super::joint::JointRef;
use super::view::ContactRef;
use crate::base::aabb::Aabb;
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::state::bodies::body::Body;
use crate::state::def::{BodyKind, JointKind};
use crate::state::shapes::ShapeRow;
use crate::state::tables::Tables;

/// Receiver of debug lines and points: see [`World::debug_draw`].
pub trait DebugDraw {
    /// Draws a line between two points [m, world].
    fn line(&mut self, a: Vec3, b: Vec3, color: DebugColor);

    /// Draws a point [m, world].
    fn point(&mut self, at: Vec3, color: DebugColor);
}

/// A color, sRGB.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct DebugColor {
    /// Red, 0 to 255.
    pub red: u8,
    /// Green, 0 to 255.
    pub green: u8,
    /// Blue, 0 to 255.
    pub blue: u8,
}

impl DebugColor {
    const FIXED: Self = Self::new(120, 120, 120);
    const KINEMATIC: Self = Self::new(50, 110, 200);
    const DYNAMIC: Self = Self::new(220, 130, 30);
    const ASLEEP: Self = Self::new(120, 90, 60);
    const SENSOR: Self = Self::new(40, 160, 90);
    const CONTACT: Self = Self::new(214, 40, 57);
    const FRICTION: Self = Self::new(120, 60, 180);
    const JOINT: Self = Self::new(33, 94, 168);
    const APART: Self = Self::new(255, 140, 0);
    const LIMIT: Self = Self::new(190, 30, 120);
    const PLACE: Self = Self::new(20, 130, 160);
    const BOUNDS: Self = Self::new(60, 110, 60);
    const VELOCITY: Self = Self::new(30, 140, 60);
    const PARTICLE: Self = Self::new(150, 110, 60);

    const fn new(red: u8, green: u8, blue: u8) -> Self {
        Self { red, green, blue }
    }

    /// A color for each number, from a hash.
    #[expect(clippy::cast_possible_truncation, reason = "three bytes of a hash")]
    const fn of(number: u32) -> Self {
        let mixed = (number ^ 0x9e37).wrapping_mul(0x9e37_79b1);
        Self::new(
            60 + ((mixed >> 24) as u8) / 8 * 5,
            60 + ((mixed >> 16) as u8) / 8 * 5,
            60 + ((mixed >> 8) as u8) / 8 * 5,
        )
    }
}

/// Meaning of the color of a shape's outline.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DebugTint {
    /// The state of the body: static, kinematic, awake or asleep; and whether the shape is a
    /// sensor.
    #[default]
    Kind,
    /// The island of the body. Bodies that touch or are joined have one color.
    Island,
}

/// Parts of a world to draw: see [`World::debug_draw`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(clippy::struct_excessive_bools, reason = "switches that do not depend on each other")]
pub struct DebugDrawOptions {
    /// Outlines of shapes. Default true.
    pub shapes: bool,
    /// Axes of bodies, at their centers of mass: red, green and blue. Default false.
    pub axes: bool,
    /// Contact points, and their normal and friction impulses as lines whose length grows with the
    /// impulse. Default true.
    pub contacts: bool,
    /// Joints: lines from each center of mass to its anchor and between the anchors. Default true.
    pub joints: bool,
    /// Limits of joints: arcs for rotations, bars for translations, the rim of a cone, and the
    /// current coordinates. Default true.
    pub limits: bool,
    /// Boxes of the shapes as stored in the trees. Default false.
    pub bounds: bool,
    /// Predicted center of mass in a tenth of a second. Default false.
    pub velocities: bool,
    /// Particles and their links. Default true.
    pub particles: bool,
    /// Meaning of the outline color. Default [`DebugTint::Kind`].
    pub tint: DebugTint,
    /// Length of axes and of the longest normals, and maximum radius of arcs [m]; default 0.2. It
    /// is multiplied by [`WorldConfig::length_scale`](crate::WorldConfig::length_scale). A value
    /// that is negative or not finite counts as 0.
    pub size: f32,
    /// Draws only shapes and particles in this box [m, world]; default `None`: everything.
    pub region: Option<Aabb>,
}

impl Default for DebugDrawOptions {
    fn default() -> Self {
        Self {
            shapes: true,
            contacts: true,
            joints: true,
            limits: true,
            particles: true,
            size: 0.2,
            ..Self::NOTHING
        }
    }
}

impl DebugDrawOptions {
    /// Options that draw nothing.
    pub const NOTHING: Self = Self {
        shapes: false,
        axes: false,
        contacts: false,
        joints: false,
        limits: false,
        bounds: false,
        velocities: false,
        particles: false,
        tint: DebugTint::Kind,
        size: 0.2,
        region: None,
    };
}

impl World {
    /// Draws the current state of the world as lines and points. It stores and allocates nothing,
    /// and costs nothing unless it is called. Objects are drawn in the order of their tables, the
    /// same for any number of threads.
    ///
    /// ```
    /// use drystone::{BodyDef, ShapeDef, Vec3, World};
    /// use drystone::draw::{DebugColor, DebugDraw, DebugDrawOptions};
    ///
    /// #[derive(Default)]
    /// struct Lines(Vec<(Vec3, Vec3)>);
    ///
    /// impl DebugDraw for Lines {
    ///     fn line(&mut self, a: Vec3, b: Vec3, _: DebugColor) {
    ///         self.0.push((a, b));
    ///     }
    ///     fn point(&mut self, at: Vec3, _: DebugColor) {
    ///         self.0.push((at, at));
    ///     }
    /// }
    ///
    /// let mut world = World::default();
    /// world.add_body(BodyDef::dynamic().with_shape(ShapeDef::box_half([1.0, 2.0, 3.0])))?;
    /// let mut lines = Lines::default();
    /// world.debug_draw(&mut lines, &DebugDrawOptions::default());
    /// assert_eq!(lines.0.len(), 12);
    /// # Ok::<(), drystone::DefError>(())
    /// ```
    pub fn debug_draw(&self, to: &mut dyn DebugDraw, options: &DebugDrawOptions) {
        let size = options.size * self.tables.config.length_scale;
        let size = if size.is_finite() { size.max(0.0) } else { 0.0 };
        let mut pen = Pen { to, tables: &self.tables, options, size };
        if options.shapes || options.bounds {
            pen.shapes();
        }
        if options.axes || options.velocities {
            pen.bodies();
        }
        if options.contacts {
            pen.contacts(self);
        }
        if options.joints || options.limits {
            for joint in self.joints() {
                pen.joint(&joint);
            }
        }
        if options.particles {
            pen.particles(self);
        }
    }
}

/// State of one drawing.
struct Pen<'a> {
    to: &'a mut dyn DebugDraw,
    tables: &'a Tables,
    options: &'a DebugDrawOptions,
    /// Size of marks [m].
    size: f32,
}

impl Pen<'_> {
    fn line(&mut self, a: Vec3, b: Vec3, color: DebugColor) {
        if a.is_finite() && b.is_finite() {
            self.to.line(a, b, color);
        }
    }

    fn sees(&self, bounds: &Aabb) -> bool {
        self.options.region.is_none_or(|region| region.overlaps(bounds))
    }

    fn sees_point(&self, at: Vec3) -> bool {
        self.sees(&Aabb::new(at, at))
    }

    fn shapes(&mut self) {
        let tables = self.tables;
        for (_, shape) in tables.shapes.rows.iter() {
            let body = tables.bodies.at(shape.body);
            if !shape.is_in(body) || !self.sees(&shape.fat) {
                continue;
            }
            if self.options.bounds {
                self.bounds(&shape.fat);
            }
            if self.options.shapes {
                let pose = body.pose().compose(&shape.local);
                self.outline(&shape.shape, &pose, color_of(shape, body, self.options.tint));
            }
        }
    }

    fn bounds(&mut self, bounds: &Aabb) {
        let far = self.tables.config.length_scale * 1.0e5;
        if bounds.half_extents().max_element() < far {
            let (center, half) = (bounds.center(), bounds.half_extents());
            self.cuboid(&Pose::at(center), half, DebugColor::BOUNDS);
        }
    }

    fn bodies(&mut self) {
        let tables = self.tables;
        for (_, body) in tables.bodies.rows.iter() {
            if body.out || !self.sees_point(body.center) {
                continue;
            }
            if self.options.axes {
                let colors = [
                    DebugColor::new(220, 50, 50),
                    DebugColor::new(50, 180, 50),
                    DebugColor::new(60, 90, 230),
                ];
                for (axis, color) in [Vec3::X, Vec3::Y, Vec3::Z].into_iter().zip(colors) {
                    let end = body.center + body.rotation.rotate(axis) * self.size;
                    self.line(body.center, end, color);
                }
            }
            if self.options.velocities && body.v != Vec3::ZERO {
                self.line(body.center, body.center + body.v * 0.1, DebugColor::VELOCITY);
            }
        }
    }

    fn contacts(&mut self, world: &World) {
        let of = |c: &ContactRef<'_>| c.points().map(|p| p.impulse).fold(0.0, f32::max);
        let greatest = world.contacts().map(|c| of(&c)).fold(f32::MIN_POSITIVE, f32::max);
        let size = self.size;
        let length = |impulse: f32| size * (impulse / greatest).clamp(0.0, 1.0).sqrt();
        for contact in world.contacts() {
            let (mut middle, mut count) = (Vec3::ZERO, 0.0);
            for point in contact.points() {
                (middle, count) = (middle + point.position, count + 1.0);
                if self.sees_point(point.position) {
                    self.to.point(point.position, DebugColor::CONTACT);
                    let end = 0.1 * size + length(point.impulse);
                    let end = point.position + contact.normal() * end;
                    self.line(point.position, end, DebugColor::CONTACT);
                }
            }
            let middle = middle * (1.0 / count);
            if let Some(along) = contact.friction_impulse().try_normalize()
                && self.sees_point(middle)
            {
                let end = middle + along * length(contact.friction_impulse().length());
                self.line(middle, end, DebugColor::FRICTION);
            }
        }
    }

    fn joint(&mut self, joint: &JointRef<'_>) {
        let (a, b) = (joint.anchor_a(), joint.anchor_b());
        if !joint.is_enabled() || !self.sees(&Aabb::of_points([a, b])) {
            return;
        }
        if self.options.joints {
            for (id, anchor) in [(joint.body_a(), a), (joint.body_b(), b)] {
                let row = self.tables.bodies.rows.row(id);
                let body = row.map(|row| self.tables.bodies.at(row));
                if let Some(body) = body.filter(|body| body.kind != BodyKind::Static) {
                    self.line(body.center, anchor, DebugColor::JOINT);
                }
            }
            self.line(a, b, DebugColor::APART);
        }
        if !self.options.limits {
            return;
        }
        match joint.kind() {
            JointKind::SixDof(axes) => self.limits(joint, &axes),
            JointKind::Distance { min, max, .. } => {
                let along = (b - a).normalize_or(Vec3::Y);
                for length in [min, max].into_iter().filter(|length| length.is_finite()) {
                    self.to.point(a + along * length, DebugColor::LIMIT);
                }
            }
            _ => {}
        }
    }

    fn particles(&mut self, world: &World) {
        for particle in world.particles() {
            if self.sees_point(particle.position()) {
                self.to.point(particle.position(), DebugColor::PARTICLE);
            }
        }
        for link in world.links() {
            let [a, b] = link.particles().map(|id| world.particle(id).map(|p| p.position()));
            if let (Some(a), Some(b)) = (a, b)
                && self.sees(&Aabb::of_points([a, b]))
            {
                self.line(a, b, DebugColor::PARTICLE);
            }
        }
    }
}

fn color_of(shape: &ShapeRow, body: &Body, tint: DebugTint) -> DebugColor {
    match body.kind {
        _ if shape.sensor => DebugColor::SENSOR,
        BodyKind::Static => DebugColor::FIXED,
        BodyKind::Kinematic => DebugColor::KINEMATIC,
        BodyKind::Dynamic if tint == DebugTint::Island => DebugColor::of(body.sleep.island),
        BodyKind::Dynamic if body.active() => DebugColor::DYNAMIC,
        BodyKind::Dynamic => DebugColor::ASLEEP,
    }
}
