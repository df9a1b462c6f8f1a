//! A marble of 1 cm radius: down a chute of triangles, over a floor of tiles, into 24 dominoes of 2 cm.

use drystone::{BodyDef, BodyId, Mesh, MeshError, Shape, ShapeDef, Vec3, World, trig, vec3};
use std::sync::Arc;

/// A gutter with flanks of 45 degrees: one in four down, a curve, and on level ground.
fn chute() -> Result<Mesh, MeshError> {
    let (mut corners, mut triangles) = (Vec::new(), Vec::new());
    for k in 0..=420_u16 {
        let x = f32::from(k) / 300.0 - 1.0;
        let y = if x < -0.2 { -0.25 * x - 0.025 } else { 0.625 * x.min(0.0) * x.min(0.0) };
        corners.extend([-0.015_f32, 0.0, 0.015].map(|z| vec3(x, y + z.abs(), z)));
        for a in [3 * u32::from(k), 3 * u32::from(k) + 1] {
            triangles.extend([[a, a + 1, a + 3], [a + 1, a + 4, a + 3]]);
        }
    }
    triangles.truncate(4 * 420);
    Mesh::new(corners, triangles)
}

/// How far a body leans [degrees].
fn lean(world: &World, id: BodyId) -> f32 {
    let up = |body: drystone::BodyRef<'_>| body.pose().direction(Vec3::Y).y;
    world.body(id).map_or(f32::NAN, |body| trig::acos(up(body)).to_degrees())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut world = World::default();
    let mesh = ShapeDef::new(Shape::Mesh(Arc::new(chute()?))).with_friction(0.8);
    world.add_body(BodyDef::fixed().with_shape(mesh))?;
    let (radius, root) = (0.01, 2_f32.sqrt());
    let top = radius * (root - 1.0);
    for i in 0..225_u8 {
        let at = [0.31 + 0.02 * f32::from(i / 5), top - 0.005, 0.02 * f32::from(i % 5) - 0.04];
        let tile = ShapeDef::box_half([0.01, 0.005, 0.01]).with_friction(0.8);
        world.add_body(BodyDef::fixed().with_position(at).with_shape(tile))?;
    }
    let mut dominoes = Vec::new();
    for i in 0..24_u8 {
        let at = BodyDef::dynamic().with_position([0.7 + 0.012 * f32::from(i), top + 0.01, 0.0]);
        let shape = ShapeDef::box_half([0.002, 0.01, 0.005]).with_density(600.0);
        dominoes.push(world.add_body(at.with_shape(shape))?);
    }
    (0..180).for_each(|_| world.step(1.0 / 60.0));
    assert!(dominoes.iter().all(|id| lean(&world, *id) < 0.5), "they stand");
    let off = vec3(0.25, 1.0, 0.0).normalize_or(Vec3::Y) * (radius * root);
    let marble = ShapeDef::sphere(radius).with_density(2500.0).with_friction(0.8);
    let marble = BodyDef::dynamic().with_position(vec3(-0.9, 0.2, 0.0) + off).with_shape(marble);
    let marble = world.add_body(marble)?;
    let (mut hop, mut foot) = (0.0_f32, 0.0);
    for _ in 0..720 {
        world.step(1.0 / 60.0);
        let body = world.body(marble).ok_or("no marble")?;
        match body.position() {
            at if at.x < 0.0 => foot = body.linear_velocity().length(),
            at if at.x > 0.47 && at.x < 0.66 => hop = hop.max((at.y - top - radius).abs()),
            _ => {}
        }
    }
    // Rolling in the gutter without sliding, a fifth of 9/5 of the energy... is turning.
    let rolling = (2.0 * 9.81 * (0.2 + off.y - radius * root) / 1.8).sqrt();
    println!(
        "foot of the chute: {foot:.3} m/s, rolling {rolling:.3} m/s; hops {:.3} mm",
        hop * 1e3
    );
    let fallen = dominoes.iter().filter(|id| lean(&world, **id) > 30.0).count();
    println!("{fallen} of 24 dominoes fall");
    assert!(fallen == 24 && hop < 0.001 && (foot - rolling).abs() < 0.1);
    Ok(())
}
