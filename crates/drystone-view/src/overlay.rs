//! What is drawn over bodies to show what the engine knows of them.

use drystone::{Aabb, BodyId, BodyKind, Vec3, World};
use drystone_render::{Color, Drawing, body_color};

/// What is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "switches that do not depend on each other")]
pub struct Overlays {
    /// Points and normals of contacts, longer where they carry more.
    pub contacts: bool,
    /// Joints: from the middle of each body to its anchor.
    pub joints: bool,
    /// Boxes around shapes.
    pub bounds: bool,
    /// Bodies that sleep are dim.
    pub sleeping: bool,
    /// Each island has a color of its own.
    pub islands: bool,
}

const CONTACT: Color = [214, 40, 57, 255];
const JOINT: Color = [33, 94, 168, 255];
const APART: Color = [255, 140, 0, 255];
const BOUNDS: Color = [60, 110, 60, 150];

/// Adds lines for what is shown; `scale` is the size of what is framed [m].
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
            add_cross(drawing, a, 0.008 * scale, JOINT);
        }
    }
    if overlays.contacts {
        add_contacts(drawing, world, scale);
    }
}

fn add_contacts(drawing: &mut Drawing, world: &World, scale: f32) {
    let impulses = || world.contacts().flat_map(|c| c.points().collect::<Vec<_>>());
    let most = impulses().map(|p| p.impulse).fold(1.0e-9, f32::max);
    for contact in world.contacts() {
        for point in contact.points() {
            let part = (point.impulse / most).clamp(0.0, 1.0).sqrt();
            let up = contact.normal() * (scale * (0.01 + 0.09 * part));
            drawing.add_line(point.position, point.position - up, 1.5, CONTACT);
            add_cross(drawing, point.position, 0.005 * scale, CONTACT);
        }
    }
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

/// A color for each body's slot, equal within an island: dynamic bodies that contacts with points or
/// joints connect.
#[must_use]
pub fn island_colors(world: &World) -> Vec<Color> {
    let slot = |id: BodyId| id.index() as usize;
    let count = world.bodies().map(|b| slot(b.id()) + 1).max().unwrap_or(0);
    let dynamic = |id: BodyId| world.body(id).is_some_and(|b| b.kind() == BodyKind::Dynamic);
    let mut root: Vec<usize> = (0..count).collect();
    let contacts = world.contacts().map(|c| (c.body_a(), c.body_b()));
    let joints = world.joints().map(|j| (j.body_a(), j.body_b()));
    for (a, b) in contacts.chain(joints).filter(|(a, b)| dynamic(*a) && dynamic(*b)) {
        let (a, b) = (find(&mut root, slot(a)), find(&mut root, slot(b)));
        // The lower slot leads, so that an island keeps its color as it grows at its end.
        root[a.max(b)] = a.min(b);
    }
    let mut colors = vec![[0; 4]; count];
    for body in world.bodies() {
        let leader = u32::try_from(find(&mut root, slot(body.id()))).unwrap_or(0);
        colors[slot(body.id())] = body_color(body.kind(), leader);
    }
    colors
}

fn find(root: &mut [usize], mut at: usize) -> usize {
    while root[at] != at {
        root[at] = root[root[at]];
        at = root[at];
    }
    at
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
