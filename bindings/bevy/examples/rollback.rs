//! A client predicts, learns of an input that it missed, goes back and steps again. It then has the
//! bits of the server.

use bevy_app::{App, Startup};
use bevy_drystone::DefaultPhysicsWorld;
use bevy_drystone::prelude::*;
use bevy_ecs::prelude::{Commands, Entity, With};
use bevy_math::Vec3;
use bevy_time::{TimePlugin, TimeUpdateStrategy};
use bevy_transform::components::Transform;
use core::time::Duration;

/// The components of a moment.
type State = (Entity, Transform, LinearVelocity, AngularVelocity);

fn setup(mut commands: Commands<'_, '_>) {
    commands.spawn(Collider::half_space(Vec3::Y));
    for k in 0..100_u8 {
        let [x, y, z] = [k % 5, k / 25, k / 5 % 5].map(f32::from);
        let place = Transform::from_xyz(1.01 * x, 0.6 + 1.1 * y, 1.01 * z);
        let cube = (RigidBody::Dynamic, Collider::cuboid(1.0, 1.0, 1.0), place);
        commands.spawn((cube, PhysicsOrder(u64::from(k))));
    }
}

fn machine() -> App {
    let mut app = App::new();
    let plugin = DrystonePlugin::default().without_interpolation();
    app.add_plugins((TimePlugin, plugin)).add_systems(Startup, setup);
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_micros(15_625)));
    app
}

fn run(app: &mut App, frames: u32) {
    (0..frames).for_each(|_| app.update());
}

/// The input: the first cube gets a speed.
fn kick(app: &mut App) {
    let mut cubes = app.world_mut().query::<(&PhysicsOrder, &mut LinearVelocity)>();
    for (order, mut speed) in cubes.iter_mut(app.world_mut()) {
        if *order == PhysicsOrder(0) {
            speed.0 = Vec3::new(20.0, 5.0, 20.0);
        }
    }
}

fn world(app: &mut App) -> Option<bevy_ecs::world::Mut<'_, PhysicsWorld>> {
    let world = app.world().resource::<DefaultPhysicsWorld>().0;
    app.world_mut().get_mut::<PhysicsWorld>(world)
}

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
#[expect(clippy::expect_used, reason = "the plugin keeps a default world")]
fn main() {
    let (mut server, mut client) = (machine(), machine());
    run(&mut server, 60);
    run(&mut client, 60);
    let saved = world(&mut client).expect("a world").world().clone();
    let mut moving = client
        .world_mut()
        .query_filtered::<(Entity, &Transform, &LinearVelocity, &AngularVelocity), With<RigidBody>>(
        );
    let states: Vec<State> =
        moving.iter(client.world()).map(|(e, t, v, w)| (e, *t, *v, *w)).collect();
    kick(&mut server);
    run(&mut server, 40);
    run(&mut client, 30);
    let hash = |app: &mut App| world(app).expect("a world").world().state_hash();
    println!("server {:016x}, client's guess {:016x}", hash(&mut server), hash(&mut client));
    world(&mut client).expect("a world").restore(&saved);
    for (entity, place, linear, angular) in states {
        client.world_mut().entity_mut(entity).insert((place, linear, angular));
    }
    kick(&mut client);
    run(&mut client, 40);
    println!("after the rollback {:016x}", hash(&mut client));
    assert_eq!(hash(&mut server), hash(&mut client));
}
