//! A wall of bricks, held by mortar that breaks where a ball hits it.

use bevy_app::{App, Startup, Update};
use bevy_drystone::prelude::*;
use bevy_ecs::prelude::{Commands, Entity, MessageReader, ResMut, Resource};
use bevy_math::Vec3;
use bevy_time::{TimePlugin, TimeUpdateStrategy};
use bevy_transform::components::Transform;
use core::time::Duration;

const WIDTH: usize = 8;
const HEIGHT: usize = 5;

#[derive(Default, Resource)]
struct Broken(usize);

#[expect(clippy::cast_precision_loss, reason = "small whole numbers")]
fn setup(mut commands: Commands<'_, '_>) {
    commands.spawn(Collider::half_space(Vec3::Y));
    let mut bricks: Vec<Entity> = Vec::new();
    let center = |k: usize| {
        let (x, y) = ((k % WIDTH) as f32, (k / WIDTH) as f32);
        Vec3::new(x + 0.5 - 0.5 * WIDTH as f32, y + 0.5, 0.0)
    };
    for k in 0..WIDTH * HEIGHT {
        let place = Transform::from_translation(center(k));
        let brick = (RigidBody::Dynamic, Collider::cuboid(1.0, 1.0, 0.5), place);
        bricks.push(commands.spawn(brick).id());
    }
    let mortar = JointStrength { force: 250_000.0, torque: 120_000.0, ..JointStrength::default() };
    let mut join = |a: usize, b: usize| {
        let between = (center(a) + center(b)) * 0.5;
        commands.spawn((FixedJoint::new(bricks[a], bricks[b]).at(between), mortar));
    };
    for k in 0..WIDTH * HEIGHT {
        if k % WIDTH + 1 < WIDTH {
            join(k, k + 1);
        }
        if k + WIDTH < WIDTH * HEIGHT {
            join(k, k + WIDTH);
        }
    }
}

fn shoot(commands: &mut Commands<'_, '_>) {
    let place = Transform::from_xyz(0.0, 2.5, 6.0);
    let ball = (RigidBody::Dynamic, Collider::sphere(0.4), Mass(400.0), place);
    commands.spawn((ball, LinearVelocity(Vec3::new(0.0, 0.0, -40.0))));
}

fn count(mut breaks: MessageReader<'_, '_, JointBroke>, mut broken: ResMut<'_, Broken>) {
    broken.0 += breaks.read().count();
}

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() {
    let mut app = App::new();
    app.add_plugins((TimePlugin, DrystonePlugin::default()))
        .init_resource::<Broken>()
        .add_systems(Startup, setup)
        .add_systems(Update, count)
        .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_micros(15_625)));
    (0..64).for_each(|_| app.update());
    assert_eq!(app.world().resource::<Broken>().0, 0, "the wall stands by itself");
    shoot(&mut app.world_mut().commands());
    (0..64).for_each(|_| app.update());
    let broken = app.world().resource::<Broken>().0;
    println!("{broken} of {} joints broke", WIDTH * (HEIGHT - 1) + (WIDTH - 1) * HEIGHT);
    assert!(broken > 4 && broken < 60, "a hole, and the rest holds");
}
