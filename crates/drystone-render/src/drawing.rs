//! The content of a picture of a world: placed forms, rods, lines. Independent of the graphics
//! device.

use std::borrow::Cow;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use drystone::geometry::Aabb;
use drystone::particle::{LinkKind, LinkRef};
use drystone::{BodyKind, BodyRef, JointKind, Pose, Quat, Shape, ShapeRef, Vec3, World};
use drystone_scene::visual::{PlacedMesh, Visuals};

use crate::color::{Color, DUST, GROUND, ROD, THREAD, body_color};
use crate::form::{Fit, Form};
use crate::framing::Subject;
use crate::sheet::Sheets;

/// Edges of boxes look rounded.
const BEVEL: u32 = 1;
/// A grid on the surface.
const GRID: u32 = 2;
/// Drawn as asleep.
const DIM: u32 = 4;
/// Drawn as picked.
const HIGHLIGHT: u32 = 8;
/// The color carries information: it replaces the color of a material.
const TINT: u32 = 16;

/// A level static plate counts as floor, which has a grid, if its half edges are at least this
/// fraction of the subject's radius.
const FLOOR: f32 = 0.5;
/// An upright plate counts as a wall, which must not hide moving bodies, from this fraction on.
const WALL: f32 = 0.2;
/// Half the edge of the square that stands for a half-space, in radii of the subject.
const HORIZON: f32 = 400.0;

/// Color of the outline that replaces a wall in front of moving bodies.
const OUTLINE: Color = [70, 74, 80, 120];

/// A placed form.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Instance {
    /// Origin [m, relative to the drawing's origin].
    pub(crate) position: [f32; 3],
    /// Half the distance between a capsule's ends [m].
    pub(crate) end: f32,
    pub(crate) rotation: [f32; 4],
    pub(crate) scale: [f32; 3],
    pub(crate) color: Color,
    pub(crate) finish: u32,
}

/// A line drawn over everything else.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Line {
    /// Start [m, relative to the drawing's origin].
    pub(crate) a: [f32; 3],
    /// Width [px].
    pub(crate) width: f32,
    /// End [m, relative to the drawing's origin].
    pub(crate) b: [f32; 3],
    pub(crate) color: Color,
}

/// All instances of a form.
#[derive(Clone, Debug)]
pub(crate) struct Batch {
    pub(crate) form: Form,
    pub(crate) instances: Vec<Instance>,
}

/// Options for how bodies look.
#[derive(Clone, Copy, Debug, Default)]
pub struct Look<'a> {
    /// Draws sleeping bodies dim.
    pub dim_asleep: bool,
    /// The body to draw as picked.
    pub picked: Option<drystone::BodyId>,
    /// Colors of bodies by slot; a body without an entry has its default color.
    pub colors: Option<&'a [Color]>,
    /// Poses to draw bodies at instead of their own, by slot: for pictures between two steps.
    pub poses: Option<&'a [Pose]>,
    /// Visuals of bodies and surroundings, if a file has them.
    pub visuals: Option<&'a Arc<Visuals>>,
    /// Draws collision shapes in addition to visuals.
    pub colliders: bool,
}

/// The content of a picture of a world.
#[derive(Clone, Debug)]
pub struct Drawing {
    /// Positions are relative to this point [m, world], because f32 is coarse far from the world's
    /// origin.
    pub(crate) origin: Vec3,
    /// Direction against gravity, unit.
    pub(crate) up: Vec3,
    /// Radius of the subject [m].
    pub(crate) radius: f32,
    /// Middle of the subject [m, world].
    pub(crate) middle: Vec3,
    pub(crate) batches: Vec<Batch>,
    pub(crate) lines: Vec<Line>,
    /// Large thin upright static boxes; not drawn where they would hide moving bodies.
    pub(crate) walls: Vec<Instance>,
    /// The box around everything that moves [m, relative to the origin].
    pub(crate) core: Aabb,
}

/// Gathers the content of one picture after another, and keeps the parts that do not change between
/// them.
#[derive(Debug, Default)]
pub struct Gatherer {
    sheets: Sheets,
}

impl Gatherer {
    /// Returns the same as [`Drawing::of`]; each call may be given another world.
    #[must_use]
    pub fn gather(&mut self, world: &World, subject: &Subject, look: &Look<'_>) -> Drawing {
        Drawing::gather(world, subject, look, &mut self.sheets)
    }
}

impl Drawing {
    /// The content of a picture of a world in its current state; `subject` is the subject of the
    /// picture. Sensors are not drawn. A [`Gatherer`] is faster for many pictures.
    #[must_use]
    pub fn of(world: &World, subject: &Subject, look: &Look<'_>) -> Self {
        Gatherer::default().gather(world, subject, look)
    }

    fn gather(world: &World, subject: &Subject, look: &Look<'_>, sheets: &mut Sheets) -> Self {
        let middle = subject.bounds.center();
        let mut drawing = Self {
            origin: middle,
            up: subject.up,
            radius: subject.radius(),
            middle,
            batches: Vec::new(),
            lines: Vec::new(),
            walls: Vec::new(),
            core: Aabb::new(subject.core.min - middle, subject.core.max - middle),
        };
        let mut batches = Batches::default();
        let visuals = look.visuals.filter(|v| !v.is_empty() && !look.colliders);
        let dress = visuals.map(|visuals| Dress::new(world, visuals));
        if let Some(visuals) = visuals {
            let (color, seat) = (body_color(BodyKind::Static, 0), Pose::IDENTITY);
            drawing.add_meshes(&mut batches, visuals, &visuals.scenery, &seat, (color, 0));
        }
        for body in world.bodies().filter(|b| b.pose().is_finite()) {
            if let Some(dress) = &dress {
                let worn = dress.visuals.of(body.user_data());
                let (color, finish) = body_look(&body, look);
                let pose = pose_of(&body, look);
                drawing.add_meshes(&mut batches, dress.visuals, worn, &pose, (color, finish));
                if !worn.is_empty() || dress.hides(&body) {
                    continue;
                }
            }
            for shape in body.shapes().filter_map(|id| world.shape(id)) {
                if !shape.is_sensor() {
                    drawing.add(&mut batches, &body, &shape, look);
                }
            }
        }
        for joint in world.joints().filter(|_| dress.is_none()) {
            let (a, b) = (joint.anchor_a(), joint.anchor_b());
            if matches!(joint.kind(), JointKind::Distance { .. }) {
                drawing.add_rod(&mut batches, a, b);
            }
            for (id, anchor) in [(joint.body_a(), a), (joint.body_b(), b)] {
                // A joint outside a body's shapes holds it by a rod.
                if let Some(body) = world.body(id).filter(|body| is_beside(world, body, anchor)) {
                    drawing.add_rod(&mut batches, body.center_of_mass(), anchor);
                }
            }
        }
        drawing.add_particles(&mut batches, world, sheets);
        drawing.batches = batches.list;
        drawing
    }

    /// Draws cloths as surfaces, other particles as balls, and rods and threads between them.
    /// Springs are drawn only where no other link is.
    fn add_particles(&self, batches: &mut Batches, world: &World, sheets: &mut Sheets) {
        if world.particles().next().is_none() {
            return;
        }
        sheets.look(world, self.origin);
        let is_spring = |link: &LinkRef<'_>| matches!(link.kind(), LinkKind::Spring(_));
        for link in world.links() {
            let ends = link.particles();
            if is_spring(&link) && ends.iter().all(|end| sheets.is_threaded(*end))
                || sheets.cover_thread(ends)
            {
                continue;
            }
            let [Some(a), Some(b)] = ends.map(|end| world.particle(end)) else { continue };
            let thick = 0.6 * a.radius().min(b.radius());
            self.add_cylinder(batches, [a.position(), b.position()], thick, THREAD);
        }
        let bare = world.particles().filter(|p| p.position().is_finite() && !sheets.cover(p.id()));
        for particle in bare {
            let fit = Fit { scale: Vec3::splat(particle.radius()), end: 0.0 };
            let pose = Pose::at(particle.position());
            let color = if particle.link_count() > 0 { THREAD } else { DUST };
            batches.push(Form::Sphere, self.instance(&pose, fit, color, 0));
        }
        for (first, sheet) in sheets.surfaces() {
            let fit = Fit { scale: Vec3::splat(1.0), end: 0.0 };
            let color = body_color(BodyKind::Dynamic, first);
            let instance = self.instance(&Pose::at(self.origin), fit, color, 0);
            batches.push(Form::Sheet(Arc::new(sheet)), instance);
        }
    }

    /// Meshes of a file at a pose.
    fn add_meshes(
        &self,
        batches: &mut Batches,
        visuals: &Arc<Visuals>,
        meshes: &[PlacedMesh],
        seat: &Pose,
        (color, finish): (Color, u32),
    ) {
        for placed in meshes {
            let fit = Fit { scale: Vec3::ONE, end: 0.0 };
            let instance = self.instance(&seat.compose(&placed.pose), fit, color, finish);
            batches.push(Form::Visual(Arc::clone(visuals), placed.mesh), instance);
        }
    }

    /// Adds a line `width` wide [px] from `a` to `b` [m, world], drawn over all bodies.
    pub fn add_line(&mut self, a: Vec3, b: Vec3, width: f32, color: Color) {
        let (a, b) = ((a - self.origin).to_array(), (b - self.origin).to_array());
        self.lines.push(Line { a, width, b, color });
    }

    fn add(
        &mut self,
        batches: &mut Batches,
        body: &BodyRef<'_>,
        shape: &ShapeRef<'_>,
        look: &Look<'_>,
    ) {
        let (form, mut fit) = Form::of(shape.shape());
        let (mut color, mut finish) = body_look(body, look);
        let mut pose = match look.poses {
            Some(_) => pose_of(body, look).compose(&shape.local_pose()),
            None => shape.pose(),
        };
        match shape.shape() {
            Shape::HalfSpace { normal, offset } => {
                (pose, fit) = self.square(&pose, *normal, *offset);
                (color, finish) = (GROUND, finish | GRID);
            }
            Shape::Box { half_extents } => {
                let fixed = body.kind() == BodyKind::Static;
                let level = self.is_level(&pose, *half_extents);
                finish |= if fixed && level && self.is_plate(*half_extents, FLOOR) {
                    GRID
                } else {
                    BEVEL
                };
                if fixed && !level && self.is_plate(*half_extents, WALL) {
                    self.walls.push(self.instance(&pose, fit, color, finish));
                    return;
                }
            }
            _ => {}
        }
        batches.push(form, self.instance(&pose, fit, color, finish));
    }

    /// Whether a box is thin and long in both other directions, at least `part` of the subject's
    /// radius.
    fn is_plate(&self, half: Vec3, part: f32) -> bool {
        let long = (0..3).filter(|&axis| half[axis] > part * self.radius).count();
        long >= 2 && half.min_element() < 0.25 * (half.x + half.y + half.z - half.max_element())
    }

    /// Whether a box lies flat rather than stands: its shortest edge is the most upright one.
    fn is_level(&self, pose: &Pose, half: Vec3) -> bool {
        let up = pose.local_direction(self.up).abs();
        let shortest = (0..3).min_by(|&i, &j| half[i].total_cmp(&half[j])).unwrap_or(1);
        up[shortest] > 0.5
    }

    /// The drawing for a camera at `eye`: walls that hide moving bodies become outlines.
    pub(crate) fn seen_from(&self, eye: Vec3) -> Cow<'_, Self> {
        if self.walls.is_empty() {
            return Cow::Borrowed(self);
        }
        let mut drawing = self.clone();
        let eye = eye - self.origin;
        let (hiding, standing): (Vec<_>, Vec<_>) =
            self.walls.iter().copied().partition(|wall| hides(wall, eye, &self.core));
        for wall in hiding {
            drawing.lines.extend(outline(&wall));
        }
        drawing.batches.push(Batch { form: Form::Box, instances: standing });
        Cow::Owned(drawing)
    }

    fn instance(&self, pose: &Pose, fit: Fit, color: Color, finish: u32) -> Instance {
        Instance {
            position: (pose.position - self.origin).to_array(),
            end: fit.end,
            rotation: pose.rotation.to_array(),
            scale: fit.scale.to_array(),
            color,
            finish,
        }
    }

    /// The square that stands for a half-space, under the middle of the picture. It moves by whole
    /// cells, so that the grid stays in place.
    fn square(&self, pose: &Pose, normal: Vec3, offset: f32) -> (Pose, Fit) {
        let turned = Pose::new(normal * offset, Quat::from_arc(Vec3::Y, normal));
        let plane = pose.compose(&turned);
        let under = plane.local_point(self.middle);
        let step = 10.0 * self.cell();
        let whole = |x: f32| (x / step).round() * step;
        let at = plane.point(Vec3::from([whole(under.x), 0.0, whole(under.z)]));
        let side = HORIZON * self.radius;
        let fit = Fit { scale: Vec3::from([side, 1.0, side]), end: 0.0 };
        (Pose::new(at, plane.rotation), fit)
    }

    /// Width of a grid cell [m]: a power of ten, a tenth of the subject's radius to all of it.
    pub(crate) fn cell(&self) -> f32 {
        let mut cell = 1.0e-3;
        while cell < 0.12 * self.radius && cell < 1.0e6 {
            cell *= 10.0;
        }
        cell
    }

    /// Adds a rod or rope between two points [m, world]. Its radius is limited by its length, so
    /// that a short rod is no disc in a large scene.
    fn add_rod(&self, batches: &mut Batches, a: Vec3, b: Vec3) {
        let thick = (0.004 * self.radius).min(0.1 * (b - a).length());
        self.add_cylinder(batches, [a, b], thick, ROD);
    }

    fn add_cylinder(&self, batches: &mut Batches, [a, b]: [Vec3; 2], thick: f32, color: Color) {
        let along = b - a;
        let Some(direction) = along.try_normalize().filter(|_| a.is_finite() && b.is_finite())
        else {
            return;
        };
        let pose = Pose::new((a + b) * 0.5, Quat::from_arc(Vec3::Y, direction));
        let scale = Vec3::from([thick, 0.5 * along.length(), thick]);
        let fit = Fit { scale, end: 0.0 };
        batches.push(Form::Cylinder, self.instance(&pose, fit, color, 0));
    }
}

/// The visuals of a file, which replace collision shapes.
struct Dress<'a> {
    visuals: &'a Arc<Visuals>,
    /// The file shows static bodies, so those without visuals are meant to be invisible.
    surroundings: bool,
}

impl<'a> Dress<'a> {
    fn new(world: &World, visuals: &'a Arc<Visuals>) -> Self {
        let shown =
            |b: BodyRef<'_>| b.kind() == BodyKind::Static && !visuals.of(b.user_data()).is_empty();
        let surroundings = !visuals.scenery.is_empty() || world.bodies().any(shown);
        Self { visuals, surroundings }
    }

    /// Whether to leave out a body without meshes.
    fn hides(&self, body: &BodyRef<'_>) -> bool {
        self.surroundings && body.kind() == BodyKind::Static
    }
}

/// Color and finish of a body.
fn body_look(body: &BodyRef<'_>, look: &Look<'_>) -> (Color, u32) {
    let mut finish = 0;
    let mut color = body_color(body.kind(), body.id().index());
    if let Some(own) = look.colors.and_then(|c| c.get(body.id().index() as usize)) {
        (color, finish) = (*own, TINT);
    }
    if look.dim_asleep && body.is_asleep() {
        finish |= DIM;
    }
    if look.picked == Some(body.id()) {
        finish |= HIGHLIGHT;
    }
    (color, finish)
}

/// The pose a body is drawn at.
fn pose_of(body: &BodyRef<'_>, look: &Look<'_>) -> Pose {
    let between = look.poses.and_then(|p| p.get(body.id().index() as usize));
    between.copied().unwrap_or_else(|| body.pose())
}

/// Whether a point is outside all shapes of a dynamic body.
fn is_beside(world: &World, body: &BodyRef<'_>, place: Vec3) -> bool {
    let mut shapes = body.shapes().filter_map(|id| world.shape(id));
    let holds = |shape: ShapeRef<'_>| {
        let bounds = shape.bounds();
        let margin = 0.2 * bounds.half_extents().max_element();
        bounds.grown(margin).contains(&Aabb::new(place, place))
    };
    body.kind() == BodyKind::Dynamic && !shapes.any(holds)
}

/// Whether a wall hides a ninth of a box or more from the eye.
fn hides(wall: &Instance, eye: Vec3, core: &Aabb) -> bool {
    let pose = Pose::new(wall.position, Quat::from(wall.rotation));
    let half = Vec3::from(wall.scale);
    let box_of_wall = Aabb::new(-half, half);
    let from = pose.local_point(eye);
    let parts = [-0.8, 0.0, 0.8];
    let mut hidden = 0;
    for (x, y, z) in (0..27).map(|i| (parts[i / 9], parts[i / 3 % 3], parts[i % 3])) {
        let place = core.center() + core.half_extents().mul_each(Vec3::from([x, y, z]));
        let to = pose.local_point(place) - from;
        let inverse = Vec3::from(to.to_array().map(|d| if d == 0.0 { 1.0e30 } else { 1.0 / d }));
        hidden += u32::from(box_of_wall.meets_ray(from, inverse, 1.0));
    }
    hidden >= 3
}

/// The edges of a box.
fn outline(wall: &Instance) -> impl Iterator<Item = Line> + use<> {
    let pose = Pose::new(wall.position, Quat::from(wall.rotation));
    let half = Vec3::from(wall.scale);
    let corner =
        move |x: f32, y: f32, z: f32| pose.point(half.mul_each(Vec3::from([x, y, z]))).to_array();
    let signs = [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)];
    signs.into_iter().flat_map(move |(s, t)| {
        [
            (corner(-1.0, s, t), corner(1.0, s, t)),
            (corner(s, -1.0, t), corner(s, 1.0, t)),
            (corner(s, t, -1.0), corner(s, t, 1.0)),
        ]
        .map(|(a, b)| Line { a, width: 1.0, b, color: OUTLINE })
    })
}

/// Batches in the order in which their forms first appeared.
#[derive(Debug, Default)]
struct Batches {
    list: Vec<Batch>,
    number: std::collections::BTreeMap<[usize; 3], usize>,
    /// Key and number of the last batch: bodies often come in rows of one form.
    last: Option<([usize; 3], usize)>,
}

impl Batches {
    fn push(&mut self, form: Form, instance: Instance) {
        let key = form.key();
        let number = match self.last {
            Some((last, number)) if last == key => number,
            _ => *self.number.entry(key).or_insert_with(|| {
                self.list.push(Batch { form, instances: Vec::new() });
                self.list.len() - 1
            }),
        };
        self.last = Some((key, number));
        self.list[number].instances.push(instance);
    }
}

#[cfg(test)]
mod tests {
    use drystone::joint::Ball;
    use drystone::{BodyDef, JointDef, ShapeDef, Vec3, World, vec3};

    use super::{Drawing, GRID, Look, ROD, Subject};

    #[test]
    fn equal_forms_are_one_batch_and_ground_has_a_grid() {
        let mut world = World::default();
        let mut add = |def: BodyDef, shape| world.add_body(def.with_shape(shape)).unwrap();
        add(BodyDef::fixed(), ShapeDef::half_space([0.0, 1.0, 0.0], 0.0));
        for i in 1..4_u8 {
            let at = BodyDef::dynamic().with_position([0.0, f32::from(i), 0.0]);
            add(at.clone(), ShapeDef::sphere(0.1 * f32::from(i)));
            add(at, ShapeDef::capsule(0.1, 0.1));
        }
        let drawing = Drawing::of(&world, &Subject::of(&world), &Look::default());
        let counts: Vec<usize> = drawing.batches.iter().map(|b| b.instances.len()).collect();
        assert_eq!(counts, [1, 3, 3]);
        assert_eq!(drawing.batches[0].instances[0].finish, GRID);
    }

    #[test]
    fn the_wall_before_the_eye_is_an_outline_and_the_one_behind_stands() {
        let mut world = World::default();
        let mut add = |def: BodyDef, half, at: [f32; 3]| {
            world.add_body(def.with_position(at).with_shape(ShapeDef::box_half(half))).unwrap();
        };
        add(BodyDef::dynamic(), [1.0; 3], [0.0; 3]);
        for z in [-2.0, 2.0] {
            add(BodyDef::fixed(), [2.0, 2.0, 0.1], [0.0, 0.0, z]);
        }
        let drawing = Drawing::of(&world, &Subject::of(&world), &Look::default());
        assert_eq!(drawing.walls.len(), 2);
        let seen = drawing.seen_from(vec3(1.0, 2.0, 20.0));
        assert_eq!((seen.batches.len(), seen.lines.len()), (2, 12));
        assert!(seen.batches[1].instances[0].position[2] < 0.0);
    }

    /// Two balls 200 m apart. One hangs from a joint 0.3 m beside its middle.
    #[test]
    fn a_short_rod_in_a_large_scene_is_no_disc() {
        let mut world = World::default();
        let mut add = |x: f32| {
            let ball = BodyDef::dynamic().with_shape(ShapeDef::sphere(0.1));
            world.add_body(ball.with_position([x, 0.0, 0.0])).unwrap()
        };
        let (ball, _) = (add(0.0), add(200.0));
        let ground = world.add_body(BodyDef::fixed()).unwrap();
        let beside = vec3(0.0, 0.3, 0.0);
        world
            .add_joint(JointDef::new(ground, ball, Ball::new()).with_anchors(beside, beside))
            .unwrap();
        let drawing = Drawing::of(&world, &Subject::of(&world), &Look::default());
        let mut all = drawing.batches.iter().flat_map(|batch| &batch.instances);
        let rod = all.find(|instance| instance.color == ROD).unwrap();
        let [thick, half, _] = rod.scale;
        assert!((half - 0.15).abs() < 1.0e-6 && thick < 0.2 * half + 1.0e-6, "{thick} by {half}");
        assert!(Vec3::from(rod.scale).is_finite());
    }
}
