//! A bridge of planks between two cliffs carries a box.

use bevy_app::{App, Startup};
use bevy_drystone::prelude::*;
use bevy_ecs::prelude::{Commands, Component, Entity, With};
use bevy_math::Vec3;
use bevy_time::{TimePlugin, TimeUpdateStrategy};
use bevy_transform::components::Transform;
use core::time::Duration;

const PLANKS: u8 = 12;

#[derive(Component)]
struct Load;

fn setup(mut commands: Commands<'_, '_>) {
    let half = 0.5 * f32::from(PLANKS);
    let mut cliff = |side: f32| {
        let place = Transform::from_xyz(side * (half + 2.0), -1.0, 0.0);
        commands.spawn((RigidBody::Static, Collider::cuboid(4.0, 2.0, 4.0), place)).id()
    };
    let ends = [cliff(-1.0), cliff(1.0)];
    let plank = |k: u8| {
        let place = Transform::from_xyz(f32::from(k) + 0.5 - half, -0.05, 0.0);
        (RigidBody::Dynamic, Collider::cuboid(0.9, 0.1, 2.0), ColliderDensity(500.0), place)
    };
    let planks: Vec<Entity> = (0..PLANKS).map(|k| commands.spawn(plank(k)).id()).collect();
    let chain = [&ends[..1], &planks, &ends[1..]].concat();
    for (k, two) in (0_u8..).zip(chain.windows(2)) {
        let at = Vec3::new(f32::from(k) - half, 0.0, 0.0);
        commands.spawn(RevoluteJoint::new(two[0], two[1]).at(at).with_axis(Vec3::Z));
    }
    let load = (Load, RigidBody::Dynamic, Collider::cuboid(0.8, 0.8, 0.8), Mass(200.0));
    commands.spawn((load, Transform::from_xyz(0.0, 1.0, 0.0)));
}

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() {
    let mut app = App::new();
    app.add_plugins((TimePlugin, DrystonePlugin::default())).add_systems(Startup, setup);
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_micros(15_625)));
    (0..256).for_each(|_| app.update());
    let mut load = app.world_mut().query_filtered::<&Transform, With<Load>>();
    let height: f32 = load.iter(app.world()).map(|place| place.translation.y).sum();
    println!("the box lies at {height:.2} m");
    // The planks reach straight from cliff to cliff: their chain cannot sag, and the box lies on it.
    assert!((height - 0.4).abs() < 0.05, "it is carried");
}
