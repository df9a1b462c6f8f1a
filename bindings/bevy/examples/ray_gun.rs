//! A ray gun: rays find targets, and push the first one that they hit.

use bevy_app::{App, Startup};
use bevy_drystone::prelude::*;
use bevy_ecs::prelude::{Commands, Component, Query, With};
use bevy_ecs::system::RunSystemOnce;
use bevy_math::{Dir3, Vec3};
use bevy_time::{TimePlugin, TimeUpdateStrategy};
use bevy_transform::components::Transform;
use core::time::Duration;

#[derive(Component)]
struct Target;

#[derive(Component)]
struct Gunner;

fn setup(mut commands: Commands<'_, '_>) {
    commands.spawn(Collider::half_space(Vec3::Y));
    commands.spawn((
        Gunner,
        RigidBody::Kinematic,
        Collider::capsule(0.3, 1.0),
        Transform::from_xyz(0.0, 1.0, 0.0),
    ));
    for x in [4.0, 6.0, 8.0] {
        let place = Transform::from_xyz(x, 0.5, 0.0);
        commands.spawn((
            Target,
            RigidBody::Dynamic,
            Collider::cuboid(1.0, 1.0, 1.0),
            Mass(10.0),
            place,
        ));
    }
}

/// Shoots from the gunner along x. Returns the distance of the hit [m].
fn shoot(
    gunners: Query<'_, '_, (bevy_ecs::entity::Entity, &Transform), With<Gunner>>,
    query: SpatialQuery<'_, '_>,
    mut targets: Query<'_, '_, Forces, With<Target>>,
) -> Option<f32> {
    let (gunner, place) = gunners.single().ok()?;
    let others = SpatialQueryFilter::from_excluded_entities([gunner]);
    let muzzle = place.translation - Vec3::Y * 0.5;
    let hit = query.cast_ray(muzzle, Dir3::X, 100.0, true, &others)?;
    let mut target = targets.get_mut(hit.entity).ok()?;
    target.apply_linear_impulse_at_point(Vec3::new(0.0, 60.0, 60.0), hit.point);
    Some(hit.distance)
}

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
#[expect(clippy::expect_used, reason = "the systems of the example have valid parameters")]
fn main() {
    let mut app = App::new();
    app.add_plugins((TimePlugin, DrystonePlugin::default())).add_systems(Startup, setup);
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_micros(15_625)));
    (0..8).for_each(|_| app.update());
    let mut distances = Vec::new();
    for _ in 0..4 {
        let hit = app.world_mut().run_system_once(shoot).expect("queries alone");
        distances.push(hit.map(f32::round));
        // The target flies out of the way.
        (0..16).for_each(|_| app.update());
    }
    println!("{distances:?}");
    // The near side of each cube is half a meter before its middle; then there is none.
    assert_eq!(distances, [Some(4.0), Some(6.0), Some(8.0), None]);
}
