//! What is in the way of a capsule, as a character would ask: rays, moving shapes, and what is nearest.

use drystone::{BodyDef, DefError, Filter, Pose, Shape, ShapeDef, World};

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() -> Result<(), DefError> {
    let mut world = World::default();
    world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0)))?;
    let wall = BodyDef::fixed().with_position([3.0, 1.0, 0.0]);
    let wall = world.add_body(wall.with_shape(ShapeDef::box_half([0.1, 1.0, 2.0])))?;

    let (query, all) = (world.query(), Filter::default());
    // A capsule of 1.8 m that stands a millimeter over the ground, and wants to go 5 m to the right.
    let (capsule, stands) = (Shape::capsule(0.6, 0.3), Pose::at([0.0, 0.901, 0.0]));
    let wish = [5.0, 0.0, 0.0];
    if let Some(hit) = query.cast_shape(&capsule, stands, wish, all)? {
        println!("it comes {:.3} m far", 5.0 * hit.fraction);
        println!("there is {:?}, whose normal is {:?}", hit.body, hit.normal);
        assert_eq!(hit.body, wall);
    }

    // What is nearest to its head.
    let head = Pose::at([2.0, 1.5, 0.0]);
    if let Some(near) = query.nearest_shape(&Shape::sphere(0.3), head, 1.0, all)? {
        println!("the wall is {:.3} m from its head, at {:?}", near.distance, near.point);
    }

    // And what it sees.
    if let Some(hit) = query.cast_ray([0.0, 1.6, 0.0], [10.0, -1.0, 0.0], all)? {
        println!("it sees {:?} at {:?}", hit.body, hit.point);
    }
    Ok(())
}
