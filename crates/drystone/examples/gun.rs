//! A hitscan gun: it ignores its owner, lists all its hits, and shoots through glass.

use drystone::{BodyDef, Filter, Mesh, Shape, ShapeDef, World, query::QueryFilter, vec3};
use std::sync::Arc;

const BODY: u64 = 1;
const GLASS: u64 = 2;

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut world = World::default();
    let mut put = |x: f32, half: [f32; 3], layers: u64| {
        let shape = ShapeDef::box_half(half).with_filter(Filter::layers(layers, u64::MAX));
        world.add_body(BodyDef::dynamic().with_position([x, 1.5, 0.0]).with_shape(shape))
    };
    let torso = put(0.0, [0.2, 0.4, 0.2], BODY)?;
    let arm = put(0.4, [0.2, 0.05, 0.05], BODY)?;
    let pane = put(3.0, [0.005, 1.0, 1.0], GLASS)?;
    let foe = put(5.0, [0.3, 0.9, 0.3], BODY)?;
    let twin = put(5.6, [0.3, 0.9, 0.3], BODY)?;
    let corners = [[0.0, -2.0], [3.0, -2.0], [3.0, 2.0], [0.0, 2.0]];
    let corners = corners.map(|[y, z]| vec3(8.0, y, z)).to_vec();
    let wall = Mesh::new(corners, vec![[0, 1, 2], [0, 2, 3]])?;
    let wall = ShapeDef::new(Shape::Mesh(Arc::new(wall)));
    let wall = world.add_body(BodyDef::fixed().with_shape(wall))?;
    // The muzzle is inside the owner's torso, and the arm is in front of it.
    let (owner, muzzle, aim) = ([torso, arm], vec3(0.0, 1.5, 0.0), vec3(100.0, 0.0, 0.0));
    let others = QueryFilter::default().without(&owner);
    let mut hits = Vec::new();
    world.query().cast_ray_all(muzzle, aim, others, &mut hits)?;
    assert!(hits.iter().map(|hit| hit.body).eq([pane, foe, twin, wall]));
    for (hit, want) in hits.iter().zip([2.995, 4.7, 5.3, 8.0]) {
        println!("{:.4} m, normal {:?}", 100.0 * hit.fraction, hit.normal);
        assert!((100.0 * hit.fraction - want).abs() < 1e-3);
    }
    // Both sides count: with layer 0 alone, the ray would miss shapes whose masks lack it.
    let no_glass = Filter { layers: u64::MAX, exclude: GLASS, ..Filter::default() };
    let hit = world.query().cast_ray(muzzle, aim, others.with_filter(no_glass))?;
    assert_eq!(hit.map(|hit| hit.body), Some(foe));
    let shy = ShapeDef::sphere(0.3).with_filter(Filter::layers(BODY, !1));
    let shy = world.add_body(BodyDef::fixed().with_position([2.0, 1.5, 0.0]).with_shape(shy))?;
    let hit = world.query().cast_ray(muzzle, aim, others.with_filter(no_glass))?;
    assert_eq!(hit.map(|hit| hit.body), Some(shy));
    Ok(())
}
