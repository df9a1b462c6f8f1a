//! Queries of a character with a capsule: rays, moving shapes, and the nearest shape.

use drystone::query::{BodyKinds, Motion, QueryFilter};
use drystone::{BodyDef, DefError, Pose, Shape, ShapeDef, World};

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() -> Result<(), DefError> {
    let mut world = World::default();
    world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0)))?;
    let wall = BodyDef::fixed().with_position([3.0, 1.0, 0.0]);
    let wall = world.add_body(wall.with_shape(ShapeDef::box_half([0.1, 1.0, 2.0])))?;
    let (capsule, stands) = (Shape::capsule(0.6, 0.3), Pose::at([0.0, 0.901, 0.0]));
    let hero = BodyDef::kinematic().with_position(stands.position);
    let hero = world.add_body(hero.with_shape(ShapeDef::new(capsule.clone())))?;

    // The capsule, 1 mm above the ground, moves 5 m to the right; the query ignores the capsule
    // itself.
    let me = [hero];
    let (query, others) = (world.query(), QueryFilter::default().without(&me));
    if let Some(hit) = query.cast_shape(&capsule, stands, [5.0, 0.0, 0.0], others)? {
        println!("it comes {:.3} m far", 5.0 * hit.fraction);
        println!("there is {:?}, whose normal is {:?}", hit.body, hit.normal);
        assert_eq!(hit.body, wall);
    }

    // The angle by which the plank on its shoulder can turn before it hits the wall.
    let (plank, shoulder) = (Shape::box_half([0.1, 0.05, 1.5]), Pose::at([2.0, 1.5, 0.0]));
    let turn = Motion::default().with_turn([0.0, core::f32::consts::FRAC_PI_2, 0.0]);
    let still = others.with_kinds(BodyKinds::STATIC);
    if let Some(hit) = query.cast_shape(&plank, shoulder, turn, still)? {
        println!("the plank turns by {:.1} degrees", 90.0 * hit.fraction);
    }

    // The shape nearest to its head.
    let head = Pose::at([2.0, 1.5, 0.0]);
    if let Some(near) = query.nearest_shape(&Shape::sphere(0.3), head, 1.0, others)? {
        println!("the wall is {:.3} m from its head, at {:?}", near.distance, near.point);
    }

    // All shapes on a bullet's path, in order.
    let mut hits = Vec::new();
    query.cast_ray_all([0.0, 1.6, 0.0], [10.0, -1.0, 0.0], others, &mut hits)?;
    for hit in &hits {
        println!("the bullet meets {:?} at {:?}", hit.body, hit.point);
    }
    Ok(())
}
