//! A world as lines, for a host with its own renderer: here an SVG picture, seen from the side and
//! above.

use std::fmt::Write as _;

use drystone::draw::{DebugColor, DebugDraw, DebugDrawOptions};
use drystone::joint::Hinge;
use drystone::{BodyDef, JointDef, ShapeDef, Vec3, World, WorldConfig};

/// Lines of a picture, in pixels.
#[derive(Default)]
struct Picture(String);

/// The position of a world point in the picture, without perspective.
fn pixel(p: Vec3) -> (f32, f32) {
    (320.0 + 80.0 * (p.x - 0.5 * p.z), 360.0 - 80.0 * (p.y + 0.3 * p.z))
}

impl DebugDraw for Picture {
    fn line(&mut self, a: Vec3, b: Vec3, color: DebugColor) {
        let DebugColor { red, green, blue, .. } = color;
        let ((x1, y1), (x2, y2)) = (pixel(a), pixel(b));
        let stroke = format!("stroke='#{red:02x}{green:02x}{blue:02x}'");
        // Writing to a string cannot fail.
        let _ = writeln!(
            self.0,
            "<line x1='{x1:.1}' y1='{y1:.1}' x2='{x2:.1}' y2='{y2:.1}' {stroke}/>"
        );
    }

    fn point(&mut self, at: Vec3, color: DebugColor) {
        for way in [Vec3::X, Vec3::Y] {
            self.line(at - way * 0.02, at + way * 0.02, color);
        }
    }
}

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() -> Result<(), Box<dyn core::error::Error>> {
    let mut world = World::new(WorldConfig::default())?;
    let floor = BodyDef::fixed().with_position([0.0, -0.1, 0.0]);
    let floor = world.add_body(floor.with_shape(ShapeDef::box_half([3.0, 0.1, 1.0])))?;
    for k in 0..4_u8 {
        let at = [-1.0, 0.25 + 0.5 * f32::from(k), 0.0];
        world.add_body(
            BodyDef::dynamic().with_position(at).with_shape(ShapeDef::box_half([0.25; 3])),
        )?;
    }
    let gate = BodyDef::dynamic().with_position([1.5, 1.0, 0.0]);
    let gate = world.add_body(gate.with_shape(ShapeDef::box_half([0.5, 0.8, 0.05])))?;
    let hinge = JointDef::new(floor, gate, Hinge::new().with_limits(-1.2, 1.2));
    world.add_joint(hinge.at([1.0, 1.0, 0.0]).with_axis([0.0, 1.0, 0.0]))?;
    world.body_mut(gate).ok_or("the gate")?.set_angular_velocity([0.0, 1.0, 0.0]);
    (0..30).for_each(|_| world.step(1.0 / 60.0));

    let mut picture = Picture::default();
    world.debug_draw(&mut picture, &DebugDrawOptions { axes: true, ..DebugDrawOptions::default() });
    let lines = picture.0.lines().count();
    let svg = format!(
        "<svg xmlns='http://www.w3.org/2000/svg' width='640' height='400'>\n{}</svg>\n",
        picture.0
    );
    let path = std::env::temp_dir().join("drystone_debug_lines.svg");
    std::fs::write(&path, svg)?;
    println!("{lines} lines in {}", path.display());
    assert!(lines > 100);
    Ok(())
}
