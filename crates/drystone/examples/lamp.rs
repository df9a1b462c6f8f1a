//! A lamp swings on a chain of eight links. A shot at one link cuts the chain, and the lamp falls.

use drystone::joint::Ball;
use drystone::{BodyDef, JointDef, QueryFilter, ShapeDef, Vec3, World};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut world = World::default();
    world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0)))?;
    let (mut bodies, mut joints) = (vec![world.add_body(BodyDef::fixed())?], Vec::new());
    for i in 0..9_u8 {
        let (top, link) = (4.0 - 0.1 * f32::from(i), ShapeDef::capsule(0.035, 0.012));
        let lamp = (0.2, ShapeDef::cylinder(0.2, 0.15).with_density(530.0));
        let (half, shape) = if i < 8 { (0.05, link.with_density(7800.0)) } else { lamp };
        let part = BodyDef::dynamic().with_position([0.0, top - half, 0.0]).with_shape(shape);
        let (above, part) = (bodies[usize::from(i)], world.add_body(part)?);
        joints.push(world.add_joint(JointDef::new(above, part, Ball::new()).at([0.0, top, 0.0]))?);
        bodies.push(part);
    }
    (0..180).for_each(|_| world.step(1.0 / 60.0));
    let weight: f32 = bodies.iter().filter_map(|b| world.body(*b)).map(|b| 9.81 * b.mass()).sum();
    let force = world.joint(joints[0]).ok_or("no joint")?.force().y;
    println!("the top joint bears {force:.2} N of {weight:.2} N");
    assert!((force - weight).abs() < 0.02 * weight);

    world.body_mut(bodies[9]).ok_or("no lamp")?.apply_impulse([7.5, 0.0, 0.0])?;
    let (mut passes, mut before) = (Vec::new(), 0.0);
    for k in 0..600_u16 {
        world.step(1.0 / 60.0);
        let x = world.body(bodies[9]).ok_or("no lamp")?.position().x;
        passes.extend((before < 0.0 && x >= 0.0).then(|| f32::from(k) / 60.0));
        before = x;
    }
    let period = (passes[passes.len() - 1] - passes[0]) / (passes.len() - 1) as f32;
    println!("it swings in {period:.3} s");
    assert!((1.9..2.15).contains(&period));

    let from = world.body(bodies[5]).ok_or("no link")?.position() + Vec3::Z * 5.0;
    let hit = world.query().cast_ray(from, Vec3::Z * -10.0, QueryFilter::default())?;
    let hit = hit.filter(|hit| hit.body == bodies[5]).ok_or("the shot misses")?;
    world.remove_joint(joints[4]);
    world.body_mut(hit.body).ok_or("no link")?.apply_impulse_at([0.0, 0.0, -0.5], hit.point)?;
    let lamp = world.body(bodies[9]).ok_or("no lamp")?;
    let (y, v) = (lamp.position().y, lamp.linear_velocity().y);
    (0..30).for_each(|_| world.step(1.0 / 60.0));
    let fell = y - world.body(bodies[9]).ok_or("no lamp")?.position().y;
    println!("it falls {fell:.3} m in half a second");
    assert!((fell - (0.125 * 9.81 - 0.5 * v)).abs() < 0.05);
    (0..240).for_each(|_| world.step(1.0 / 60.0));
    let [link, lamp] = [bodies[1], bodies[9]].map(|id| world.body(id).map(|b| b.position().y));
    assert!(lamp.is_some_and(|y| y < 0.25) && link.is_some_and(|y| y > 3.9));
    Ok(())
}
