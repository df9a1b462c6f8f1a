//! A ragdoll falls on a box, and its joints hold within their limits.

use bevy_app::{App, Startup};
use bevy_drystone::prelude::*;
use bevy_ecs::prelude::{Commands, Component, Entity, Query};
use bevy_ecs::system::RunSystemOnce;
use bevy_math::Vec3;
use bevy_time::{TimePlugin, TimeUpdateStrategy};
use bevy_transform::components::Transform;
use core::time::Duration;

/// A limb, its parent, and where both are joined [m, place at the start].
#[derive(Component)]
struct Limb {
    parent: Entity,
    joint: Vec3,
    start: Vec3,
    parent_start: Vec3,
}

fn limb(
    commands: &mut Commands<'_, '_>,
    at: Vec3,
    size: Vec3,
    parent: Option<(Entity, Vec3)>,
) -> Entity {
    let collider = Collider::cuboid(size.x, size.y, size.z);
    let place = Transform::from_translation(at);
    let limb = commands.spawn((RigidBody::Dynamic, collider, place)).id();
    if let Some((parent, parent_start)) = parent {
        // At the end of the limb that is nearer to the parent.
        let joint = at + (parent_start - at).clamp(-0.5 * size, 0.5 * size);
        let ball = SphericalJoint::new(parent, limb).at(joint).with_axis(at - joint);
        commands.spawn(ball.with_swing_limit(1.0).with_twist_limits(-0.5, 0.5));
        commands.entity(limb).insert(Limb { parent, joint, start: at, parent_start });
    }
    limb
}

fn setup(mut commands: Commands<'_, '_>) {
    commands.spawn(Collider::half_space(Vec3::Y));
    commands.spawn((Collider::cuboid(1.0, 1.0, 1.0), Transform::from_xyz(0.3, 0.5, 0.0)));
    let chest = Vec3::new(0.0, 3.0, 0.0);
    let body = limb(&mut commands, chest, Vec3::new(0.4, 0.6, 0.2), None);
    limb(&mut commands, chest + Vec3::Y * 0.5, Vec3::splat(0.22), Some((body, chest)));
    for side in [-1.0, 1.0] {
        let long = Vec3::new(0.6, 0.12, 0.12);
        let arm = chest + Vec3::new(0.55 * side, 0.2, 0.0);
        let upper = limb(&mut commands, arm, long, Some((body, chest)));
        limb(&mut commands, arm + Vec3::X * 0.65 * side, long, Some((upper, arm)));
        let high = Vec3::new(0.15, 0.5, 0.15);
        let leg = chest + Vec3::new(0.12 * side, -0.6, 0.0);
        let thigh = limb(&mut commands, leg, high, Some((body, chest)));
        limb(&mut commands, leg - Vec3::Y * 0.55, high, Some((thigh, leg)));
    }
}

/// The largest distance between the two anchors of a joint [m], and the lowest place of a limb.
fn gaps(limbs: Query<'_, '_, (&Transform, &Limb)>, all: Query<'_, '_, &Transform>) -> (f32, f32) {
    let mut worst = (0.0_f32, f32::MAX);
    for (place, limb) in &limbs {
        let Ok(parent) = all.get(limb.parent) else { continue };
        let on_limb = place.transform_point(limb.joint - limb.start);
        let on_parent = parent.transform_point(limb.joint - limb.parent_start);
        worst = (worst.0.max((on_limb - on_parent).length()), worst.1.min(place.translation.y));
    }
    worst
}

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
#[expect(clippy::expect_used, reason = "the systems of the example have valid parameters")]
fn main() {
    let mut app = App::new();
    let plugin = DrystonePlugin::default().without_interpolation();
    app.add_plugins((TimePlugin, plugin)).add_systems(Startup, setup);
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_micros(15_625)));
    (0..320).for_each(|_| app.update());
    let (gap, lowest) = app.world_mut().run_system_once(gaps).expect("queries alone");
    println!(
        "after 5 s: joints are open by {:.2} mm at most, lowest limb at {lowest:.2} m",
        1000.0 * gap
    );
    // Contacts sink in by at most 5 mm, and a limb is 0.12 m thick.
    assert!(gap < 0.005 && lowest > 0.05 && lowest < 0.3);
}
