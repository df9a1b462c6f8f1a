//! Lines and colors over bodies that show the engine's data.

use drystone::contact::ContactRef;
use drystone::draw::{DebugColor, DebugDraw, DebugDrawOptions};
use drystone::geometry::Aabb;
use drystone::{BodyId, BodyKind, JointKind, Vec3, World};
use drystone_render::{Color, Drawing, Groups, body_color};

/// The overlays that are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "switches that do not depend on each other")]
pub struct Overlays {
    /// Points and normals of contacts, longer where they carry more.
    pub contacts: bool,
    /// Friction at contacts, in the same measure.
    pub friction: bool,
    /// Contacts in the colors in which they are solved.
    pub colors: bool,
    /// Centers of mass.
    pub centers: bool,
    /// Where each body's middle will be in a tenth of a second.
    pub velocities: bool,
    /// Joints: from the middle of each body to its anchor, and limits of lengths.
    pub joints: bool,
    /// Limits of joints of six axes: arcs for turns, bars for ways, and where the joint is.
    pub limits: bool,
    /// Boxes around shapes.
    pub bounds: bool,
    /// Collision shapes, also of bodies that a file gives another look.
    pub colliders: bool,
    /// Bodies that sleep are dim.
    pub sleeping: bool,
    /// The meaning of a body's color.
    pub tint: Tint,
}

/// The meaning of a body's color.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tint {
    /// Only which one it is.
    #[default]
    Own,
    /// Its island.
    Island,
    /// How far it is from what stands fast, over those it lies on: blue to red.
    Level,
}

const CONTACT: Color = [214, 40, 57, 255];
const JOINT: Color = [33, 94, 168, 255];
const APART: Color = [255, 140, 0, 255];
const BOUNDS: Color = [60, 110, 60, 150];
const FRICTION: Color = [120, 60, 180, 255];
const CENTER: Color = [20, 20, 20, 255];
const VELOCITY: Color = [30, 140, 60, 255];

/// Adds the lines of the overlays; `scale` is the size of the subject [m].
pub fn add(drawing: &mut Drawing, world: &World, overlays: Overlays, scale: f32) {
    if overlays.bounds {
        for shape in world.bodies().flat_map(|b| b.shapes().collect::<Vec<_>>()) {
            if let Some(shape) = world.shape(shape) {
                add_box(drawing, &shape.bounds());
            }
        }
    }
    if overlays.joints {
        for joint in world.joints() {
            let (a, b) = (joint.anchor_a(), joint.anchor_b());
            for (id, anchor) in [(joint.body_a(), a), (joint.body_b(), b)] {
                let body = world.body(id).filter(|b| b.kind() != BodyKind::Static);
                if let Some(body) = body {
                    drawing.add_line(body.center_of_mass(), anchor, 2.0, JOINT);
                }
            }
            drawing.add_line(a, b, 3.0, APART);
            if let JointKind::Distance { min, max, .. } = joint.kind() {
                let along = (b - a).normalize_or(Vec3::Y);
                for length in [min, max].into_iter().filter(|l| l.is_finite()) {
                    add_cross(drawing, a + along * length, 0.012 * scale, APART);
                }
            }
            add_cross(drawing, a, 0.008 * scale, JOINT);
        }
    }
    if overlays.limits {
        let size = 0.06 * scale / world.config().length_scale;
        let limits = DebugDrawOptions { limits: true, size, ..DebugDrawOptions::NOTHING };
        world.debug_draw(&mut Lines(drawing), &limits);
    }
    if overlays.contacts || overlays.friction || overlays.colors {
        add_contacts(drawing, world, overlays, scale);
    }
    for body in world.bodies().filter(|b| b.kind() != BodyKind::Static) {
        let at = body.center_of_mass();
        if overlays.centers {
            add_cross(drawing, at, 0.01 * scale, CENTER);
        }
        if overlays.velocities && body.linear_velocity().length() > 1.0e-3 {
            drawing.add_line(at, at + body.linear_velocity() * 0.1, 2.0, VELOCITY);
        }
    }
}

/// The engine's own lines.
struct Lines<'a>(&'a mut Drawing);

impl DebugDraw for Lines<'_> {
    fn line(&mut self, a: Vec3, b: Vec3, color: DebugColor) {
        self.0.add_line(a, b, 2.0, [color.red, color.green, color.blue, 255]);
    }

    /// Ends of lengths: they have crosses with the joints.
    fn point(&mut self, _: Vec3, _: DebugColor) {}
}

fn add_contacts(drawing: &mut Drawing, world: &World, overlays: Overlays, scale: f32) {
    let sum = |c: &ContactRef<'_>| c.points().map(|p| p.impulse).fold(0.0, f32::max);
    let most = world.contacts().map(|c| sum(&c)).fold(1.0e-9, f32::max);
    let length = |impulse: f32| scale * 0.09 * (impulse / most).clamp(0.0, 1.0).sqrt();
    for contact in world.contacts() {
        let own = if overlays.colors { color_of(contact.color()) } else { CONTACT };
        let count = contact.points().count();
        let mut middle = Vec3::ZERO;
        for point in contact.points() {
            middle += point.position / count as f32;
            if overlays.contacts || overlays.colors {
                let up = contact.normal() * (0.01 * scale + length(point.impulse));
                drawing.add_line(point.position, point.position - up, 1.5, own);
                add_cross(drawing, point.position, 0.005 * scale, own);
            }
        }
        let friction = contact.friction_impulse();
        if let Some(along) = friction.try_normalize().filter(|_| overlays.friction) {
            drawing.add_line(middle, middle + along * length(friction.length()), 2.5, FRICTION);
        }
    }
}

/// A color for each number; grey for what has none.
fn color_of(number: Option<u32>) -> Color {
    number.map_or([120, 120, 120, 255], |n| {
        let [r, g, b, _] = body_color(BodyKind::Dynamic, n);
        // Darker than bodies, so that lines stand out.
        [r / 4 * 3, g / 4 * 3, b / 4 * 3, 255]
    })
}

fn add_cross(drawing: &mut Drawing, at: Vec3, half: f32, color: Color) {
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        drawing.add_line(at - axis * half, at + axis * half, 2.0, color);
    }
}

fn add_box(drawing: &mut Drawing, bounds: &Aabb) {
    let (center, half) = (bounds.center(), bounds.half_extents());
    if !center.is_finite() || !(half.max_element() < 1.0e5) {
        return;
    }
    let corner = |x: f32, y: f32, z: f32| center + half.mul_each(Vec3::from([x, y, z]));
    for (s, t) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
        drawing.add_line(corner(-1.0, s, t), corner(1.0, s, t), 1.0, BOUNDS);
        drawing.add_line(corner(s, -1.0, t), corner(s, 1.0, t), 1.0, BOUNDS);
        drawing.add_line(corner(s, t, -1.0), corner(s, t, 1.0), 1.0, BOUNDS);
    }
}

/// A color for each body's slot; none if bodies have their own.
#[must_use]
pub fn body_colors(world: &World, tint: Tint) -> Option<Vec<Color>> {
    match tint {
        Tint::Own => None,
        Tint::Island => Some(island_colors(world)),
        Tint::Level => Some(level_colors(world)),
    }
}

fn level_colors(world: &World) -> Vec<Color> {
    let most = world.bodies().filter_map(|b| b.support_level()).max().unwrap_or(1).max(1);
    let mut colors = Vec::new();
    for body in world.bodies() {
        let slot = body.id().index() as usize;
        if slot >= colors.len() {
            colors.resize(slot + 1, [0; 4]);
        }
        colors[slot] = match body.support_level() {
            _ if body.kind() != BodyKind::Dynamic => body_color(body.kind(), 0),
            Some(level) => {
                let part = u64::from(level) * 180 / u64::from(most);
                let part = u8::try_from(part).unwrap_or(180);
                [40 + part, 110, 220 - part, 255]
            }
            None => [150, 150, 150, 255],
        };
    }
    colors
}

/// A color for each body's slot, equal within an island: dynamic bodies that contacts with points
/// or joints connect.
fn island_colors(world: &World) -> Vec<Color> {
    let slot = |id: BodyId| id.index() as usize;
    let count = world.bodies().map(|b| slot(b.id()) + 1).max().unwrap_or(0);
    let dynamic = |id: BodyId| world.body(id).is_some_and(|b| b.kind() == BodyKind::Dynamic);
    // The lowest slot leads, so that an island keeps its color as it grows at its end.
    let mut islands = Groups::new(count);
    let contacts = world.contacts().map(|c| (c.body_a(), c.body_b()));
    let joints = world.joints().map(|j| (j.body_a(), j.body_b()));
    for (a, b) in contacts.chain(joints).filter(|(a, b)| dynamic(*a) && dynamic(*b)) {
        islands.join(slot(a), slot(b));
    }
    let mut colors = vec![[0; 4]; count];
    for body in world.bodies() {
        let leader = u32::try_from(islands.leader(slot(body.id()))).unwrap_or(0);
        colors[slot(body.id())] = body_color(body.kind(), leader);
    }
    colors
}

#[cfg(test)]
mod tests {
    use super::island_colors;

    #[test]
    fn bodies_of_an_island_share_a_color() {
        let mut running = drystone_scene::named("stack:n=3").unwrap().build().unwrap();
        let colors = |r: &drystone_scene::Running| {
            let all = island_colors(&r.world);
            let dynamic = |b: &drystone::BodyRef<'_>| b.kind() == drystone::BodyKind::Dynamic;
            let slots = r.world.bodies().filter(dynamic).map(|b| b.id().index() as usize);
            slots.map(|s| all[s]).collect::<std::collections::BTreeSet<_>>().len()
        };
        assert_eq!(colors(&running), 3, "nothing touches before the first step");
        for _ in 0..30 {
            running.step(1.0 / 60.0).unwrap();
        }
        assert_eq!(colors(&running), 1);
    }
}
