//! Sleeping and waking (docs/decisions/030-what-may-sleep.md). A body that moves on, is driven or
//! is pulled does not sleep, however slow it is. A body at rest sleeps as soon as rest is
//! detectable, and wakes when an event affects it.

mod driven;
mod moves_on;
mod rests;
mod wakes;

use std::sync::Arc;

use drystone::audit::AwakeCause;
use drystone::{
    BodyDef, BodyId, BodyKind, Mesh, Quat, Shape, ShapeDef, Vec3, World, WorldConfig, vec3,
};

use crate::floors::{self, Floor};

const SCALES: [f32; 4] = [0.01, 0.1, 1.0, 100.0];
const RATES: [f32; 3] = [30.0, 60.0, 240.0];

/// Time until sleep in the default configuration [s], and between two checks of a slow body.
const SLEEP: f32 = 0.5;
const LOOK: f32 = 0.2;

fn mesh(vertices: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> ShapeDef {
    ShapeDef::new(Shape::Mesh(Arc::new(Mesh::new(vertices, triangles).unwrap())))
}

/// Ground with its surface at the origin.
fn ground(world: &mut World, floor: Floor, size: f32) -> BodyId {
    floors::ground(world, floor, [50.0 * size, size])
}

fn pulled(gravity: Vec3) -> World {
    World::new(WorldConfig { gravity, ..WorldConfig::default() }).unwrap()
}

fn cube(world: &mut World, at: Vec3, side: f32) -> BodyId {
    let shape = ShapeDef::box_half([0.5 * side; 3]);
    world.add_body(BodyDef::dynamic().with_position(at).with_shape(shape)).unwrap()
}

/// Number of steps in this time.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some thousands")]
fn steps(rate: f32, seconds: f32) -> u32 {
    (seconds * rate).round() as u32
}

fn run(world: &mut World, rate: f32, seconds: f32) {
    (0..steps(rate, seconds)).for_each(|_| world.step(1.0 / rate));
}

/// Gravity on a slope that descends along x at this angle [degrees], in the slope's frame.
fn slope(degrees: f32) -> Vec3 {
    Quat::from_axis_angle(Vec3::Z, degrees.to_radians()).rotate(vec3(0.0, -9.81, 0.0))
}

fn at(world: &World, body: BodyId) -> Vec3 {
    world.body(body).unwrap().position()
}

fn sleeps(world: &World, body: BodyId) -> bool {
    world.body(body).unwrap().is_asleep()
}

fn all_sleep(world: &World) -> bool {
    world.bodies().all(|body| body.kind() != BodyKind::Dynamic || body.is_asleep())
}

/// Seconds until all sleep, if within this time.
fn until_sleep(world: &mut World, rate: f32, most: f32) -> Option<f32> {
    for step in 1..=steps(rate, most) {
        world.step(1.0 / rate);
        if all_sleep(world) {
            return Some(step as f32 / rate);
        }
    }
    None
}

fn cause(world: &World, body: BodyId) -> AwakeCause {
    world.why_awake(body).unwrap().cause
}
