//! A car of one body and four rays: springs, engine, steering and handbrake are forces.

use drystone::math::trig;
use drystone::query::QueryFilter;
use drystone::{BodyDef, BodyId, ShapeDef, Vec3, World, vec3};

const MASS: f32 = 1000.0;
const STIFFNESS: f32 = 30_000.0;
/// Distance from the hub to the ground at which the spring carries no load [m].
const REACH: f32 = 0.7;

/// Takes steps with an engine force [N], a steering angle [rad] and the handbrake.
fn drive(world: &mut World, car: BodyId, how: (f32, f32, bool), steps: u32) -> Option<Vec3> {
    let ((engine, steer, brake), own) = (how, [car]);
    for _ in 0..steps {
        for (x, z) in [(1.3, -0.8), (1.3, 0.8), (-1.3, -0.8), (-1.3, 0.8)] {
            let pose = world.body(car)?.pose();
            let (hub, down) = (pose.point(vec3(x, 0.0, z)), pose.direction(-Vec3::Y));
            let seen = QueryFilter::default().without(&own);
            let Some(hit) = world.query().cast_ray(hub, down * REACH, seen).ok()? else { continue };
            let speed = world.body(car)?.velocity_at(hit.point);
            let squeezed = STIFFNESS * REACH * (1.0 - hit.fraction);
            let load = (squeezed - 3000.0 * speed.dot(hit.normal)).max(0.0);
            // The wheel grips sideways, and with the brake also lengthwise. A step removes 0.3 of
            // the slip: removing all of it would overshoot, because the body rotates too.
            let (sin, cos) = trig::sin_cos(if x > 0.0 { steer } else { 0.0 });
            let side = pose.direction(vec3(sin, 0.0, cos));
            let ahead = side.cross(hit.normal) * -1.0;
            let grip = |way: Vec3| way * (-0.3 * MASS / 4.0 * 60.0 * speed.dot(way));
            let push = if x < 0.0 && brake { grip(ahead) } else { ahead * (engine / 4.0) };
            let along = grip(side) + push;
            let along = along * (load / along.length().max(load).max(1e-6));
            world.body_mut(car)?.add_step_force_at(hit.normal * load + along, hit.point);
        }
        world.step(1.0 / 60.0);
    }
    Some(world.body(car)?.position())
}

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut world = World::default();
    world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space(Vec3::Y, 0.0)))?;
    let car = BodyDef::dynamic().with_position([0.0, 0.65, 0.0]).with_mass(MASS);
    let car = world.add_body(car.with_shape(ShapeDef::box_half([1.9, 0.2, 0.8])))?;
    let rests = drive(&mut world, car, (0.0, 0.0, false), 300).ok_or("no car")?;
    println!("its springs sink by {:.2} mm", 1e3 * (REACH - rests.y));
    assert!((REACH - rests.y - MASS * 9.81 / 4.0 / STIFFNESS).abs() < 0.001);
    let ahead = drive(&mut world, car, (4000.0, 0.0, false), 120).ok_or("no car")?;
    assert!((ahead.x - rests.x - 8.0).abs() < 0.2 && ahead.z.abs() < 0.01, "4 m/s² for 2 s");
    drive(&mut world, car, (0.0, 0.1, false), 60).ok_or("no car")?;
    let body = world.body(car).ok_or("no car")?;
    let (yaw, bicycle) = (body.angular_velocity().y, body.linear_velocity().length() * 0.1 / 2.6);
    println!("it turns at {yaw:.2} rad/s, a bicycle would at {bicycle:.2} rad/s");
    assert!((yaw - bicycle).abs() < 0.1 * bicycle);
    let stops = drive(&mut world, car, (0.0, 0.0, true), 240).ok_or("no car")?;
    let holds = drive(&mut world, car, (0.0, 0.0, true), 60).ok_or("no car")?;
    assert!((holds - stops).length() < 0.001, "the handbrake stops it");
    Ok(())
}
