//! A marble of 1 cm rolls down a chute of triangles, over a floor of tiles, into 24 dominoes.

use drystone::{BodyDef, Mesh, Shape, ShapeDef, Vec3, World, math::trig, vec3};

/// A gutter with sides at 45 degrees: a slope of one in four, a curve, and a level end.
fn chute() -> Result<Mesh, drystone::geometry::MeshError> {
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

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut world = World::default();
    let mesh = ShapeDef::new(Shape::Mesh(std::sync::Arc::new(chute()?))).with_friction(0.8);
    world.add_body(BodyDef::fixed().with_shape(mesh))?;
    let (radius, top) = (0.01, 0.01 * (2_f32.sqrt() - 1.0));
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
    let leans = |world: &World, degrees: f32| {
        let up = |id| world.body(id).map_or(f32::NAN, |body| body.pose().direction(Vec3::Y).y);
        dominoes.iter().filter(|id| trig::acos(up(**id)).to_degrees() > degrees).count()
    };
    assert_eq!(leans(&world, 0.5), 0, "they stand");
    let off = vec3(0.25, 1.0, 0.0).normalize_or(Vec3::Y) * (top + radius);
    let marble = ShapeDef::sphere(radius).with_density(2500.0).with_friction(0.8);
    let marble = BodyDef::dynamic().with_position(vec3(-0.9, 0.2, 0.0) + off).with_shape(marble);
    let marble = world.add_body(marble)?;
    let (mut hop, mut foot) = (0.0_f32, 0.0);
    for _ in 0..720 {
        world.step(1.0 / 60.0);
        let body = world.body(marble).ok_or("no marble")?;
        let (at, speed) = (body.position(), body.linear_velocity().length());
        foot = if at.x < 0.0 { speed } else { foot };
        hop = hop.max(if (0.47..0.66).contains(&at.x) { (at.y - top - radius).abs() } else { 0.0 });
    }
    let rolling = (2.0 * 9.81 * (0.2 + off.y - top - radius) / 1.8).sqrt();
    println!("{foot:.3} m/s at the foot, {rolling:.3} without sliding; hop {:.3} mm", hop * 1e3);
    assert!(hop < 0.001 && (foot - rolling).abs() < 0.1);
    assert_eq!(leans(&world, 30.0), 24, "all dominoes fall");
    Ok(())
}
