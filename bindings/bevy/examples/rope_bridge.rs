//! A bridge of planks between two cliffs carries a box.

use bevy_app::{App, Startup};
use bevy_drystone::prelude::*;
use bevy_ecs::prelude::{Commands, Component, Entity, With};
use bevy_math::{Quat, Vec3};
use bevy_time::{TimePlugin, TimeUpdateStrategy};
use bevy_transform::components::Transform;
use core::time::Duration;

/// Planks of 1 m over a gap of 11.5 m: the middle hangs at most √(6² - 5.75²) m below the ends.
const PLANKS: u8 = 12;
const HALF_GAP: f32 = 5.75;
const DEPTH: f32 = 1.714;

#[derive(Component)]
struct Load;

/// The hinge after `k` planks [m]: down to the middle along a straight line, and up again.
fn hinge(k: u8) -> Vec3 {
    let part = f32::from(k) / (0.5 * f32::from(PLANKS));
    let down = if part < 1.0 { part } else { 2.0 - part };
    Vec3::new((part - 1.0) * HALF_GAP, -down * DEPTH, 0.0)
}

fn setup(mut commands: Commands<'_, '_>) {
    let mut cliff = |side: f32| {
        let place = Transform::from_xyz(side * (HALF_GAP + 2.0), -1.0, 0.0);
        commands.spawn((RigidBody::Static, Collider::cuboid(4.0, 2.0, 4.0), place)).id()
    };
    let ends = [cliff(-1.0), cliff(1.0)];
    let plank = |k: u8| {
        let (from, to) = (hinge(k), hinge(k + 1));
        let place = Transform {
            translation: (from + to) * 0.5,
            rotation: Quat::from_rotation_arc(Vec3::X, (to - from).normalize()),
            scale: Vec3::ONE,
        };
        (RigidBody::Dynamic, Collider::cuboid(0.9, 0.1, 2.0), ColliderDensity(500.0), place)
    };
    let planks: Vec<Entity> = (0..PLANKS).map(|k| commands.spawn(plank(k)).id()).collect();
    let chain = [&ends[..1], &planks, &ends[1..]].concat();
    for (k, two) in (0_u8..).zip(chain.windows(2)) {
        commands.spawn(RevoluteJoint::new(two[0], two[1]).at(hinge(k)).with_axis(Vec3::Z));
    }
    let load = (Load, RigidBody::Dynamic, Collider::cuboid(0.8, 0.8, 0.8), Mass(200.0));
    commands.spawn((load, Friction::new(1.0), Transform::from_xyz(0.0, -0.5, 0.0)));
}

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() {
    let mut app = App::new();
    app.add_plugins((TimePlugin, DrystonePlugin::default())).add_systems(Startup, setup);
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_micros(15_625)));
    (0..512).for_each(|_| app.update());
    let mut load = app.world_mut().query_filtered::<&Transform, With<Load>>();
    let height: f32 = load.iter(app.world()).map(|place| place.translation.y).sum();
    println!("the box lies at {height:.2} m");
    // It lies on the deepest planks, 0.45 m above their middle. A chain hangs less deep by its own
    // weight than with all of it in the middle: by √(3/8 · 11.5 · 0.5) m as a parabola.
    let depth = 0.45 - height;
    assert!((1.47 - 0.1..=DEPTH + 0.1).contains(&depth), "{depth}");
}
