//! A lamp swings on a chain of eight links. A shot at one link cuts the chain, and the lamp falls.

use drystone::{BodyDef, JointDef, ShapeDef, Vec3, World, joint::Ball, query::QueryFilter};

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut world = World::default();
    world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0)))?;
    let (mut bodies, mut joints) = (vec![world.add_body(BodyDef::fixed())?], Vec::new());
    for i in 0..9_u8 {
        let (top, link) = (4.0 - 0.1 * f32::from(i), ShapeDef::capsule(0.035, 0.012));
        let lamp = (0.2, ShapeDef::cylinder(0.2, 0.15).with_density(530.0));
        let (half, shape) = if i < 8 { (0.05, link.with_density(7800.0)) } else { lamp };
        let part = BodyDef::dynamic().with_position([0.0, top - half, 0.0]).with_shape(shape);
        bodies.push(world.add_body(part)?);
        let [.., above, part] = bodies[..] else { continue };
        joints.push(world.add_joint(JointDef::new(above, part, Ball::new()).at([0.0, top, 0.0]))?);
    }
    (0..180).for_each(|_| world.step(1.0 / 60.0));
    let weight: f32 = bodies.iter().filter_map(|b| world.body(*b)).map(|b| 9.81 * b.mass()).sum();
    let force = world.joint(joints[0]).ok_or("no joint")?.force().y;
    world.body_mut(bodies[9]).ok_or("no lamp")?.apply_impulse([7.5, 0.0, 0.0]);
    let mut xs = vec![0.0; 600];
    for x in &mut xs {
        world.step(1.0 / 60.0);
        *x = world.body(bodies[9]).ok_or("no lamp")?.position().x;
    }
    let passes: Vec<usize> = (1..600).filter(|k| xs[k - 1] < 0.0 && xs[*k] >= 0.0).collect();
    let period = (passes[passes.len() - 1] - passes[0]) as f32 / 60.0 / (passes.len() - 1) as f32;
    println!("the top joint bears {force:.2} N of {weight:.2} N; a swing takes {period:.3} s");
    assert!((force - weight).abs() < 0.02 * weight && (1.9..2.15).contains(&period));
    let from = world.body(bodies[5]).ok_or("no link")?.position() + Vec3::Z * 5.0;
    let hit = world.query().cast_ray(from, Vec3::Z * -10.0, QueryFilter::default())?;
    let hit = hit.filter(|hit| hit.body == bodies[5]).ok_or("the shot misses")?;
    world.remove_joint(joints[4]);
    world.body_mut(hit.body).ok_or("no link")?.apply_impulse_at([0.0, 0.0, -0.5], hit.point);
    let v = world.body(bodies[9]).ok_or("no lamp")?.linear_velocity() * 0.5;
    let free = world.body(bodies[9]).ok_or("no lamp")?.position().y + v.y - 0.125 * 9.81;
    (0..30).for_each(|_| world.step(1.0 / 60.0));
    let y = |w: &World, id| w.body(id).map_or(f32::NAN, |body| body.position().y);
    assert!((y(&world, bodies[9]) - free).abs() < 0.05, "it falls freely");
    (0..240).for_each(|_| world.step(1.0 / 60.0));
    assert!(y(&world, bodies[9]) < 0.25 && y(&world, bodies[1]) > 3.9);
    Ok(())
}
