//! Times of the parts of a physics frame: reading changes, the step, writing what moved.
//!
//! `cargo bench -p bevy_drystone` prints the median of the frames, in milliseconds, with the hash
//! of the world at the end.

use core::time::Duration;
use std::time::Instant;

use bevy_app::{App, FixedPostUpdate};
use bevy_drystone::DefaultPhysicsWorld;
use bevy_drystone::prelude::*;
use bevy_ecs::prelude::{IntoScheduleConfigs, ResMut, Resource};
use bevy_math::Vec3;
use bevy_time::{TimePlugin, TimeUpdateStrategy};
use bevy_transform::components::Transform;

/// Moments within a frame.
#[derive(Default, Resource)]
struct Marks(Vec<Instant>);

fn mark(mut marks: ResMut<'_, Marks>) {
    marks.0.push(Instant::now());
}

fn game(threads: usize) -> App {
    let mut app = App::new();
    let plugin = DrystonePlugin::default().with_threads(threads).without_interpolation();
    app.add_plugins((TimePlugin, plugin))
        .init_resource::<Marks>()
        .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_micros(15_625)))
        .add_systems(
            FixedPostUpdate,
            (
                mark.in_set(PhysicsSystems::First),
                mark.after(PhysicsSystems::Prepare).before(PhysicsSystems::StepSimulation),
                mark.after(PhysicsSystems::StepSimulation).before(PhysicsSystems::Writeback),
                mark.in_set(PhysicsSystems::Last),
            ),
        );
    app
}

#[expect(clippy::cast_precision_loss, reason = "small whole numbers")]
fn grid(app: &mut App, count: usize, gap: f32) {
    let side = (1..).find(|n| n * n >= count).unwrap_or(1);
    for k in 0..count {
        let place = Transform::from_xyz((k % side) as f32 * gap, 0.5, (k / side) as f32 * gap);
        app.world_mut().spawn((RigidBody::Dynamic, Collider::cuboid(1.0, 1.0, 1.0), place));
    }
}

fn hash(app: &App) -> u64 {
    let world = app.world().resource::<DefaultPhysicsWorld>().0;
    app.world().get::<PhysicsWorld>(world).map_or(0, |physics| physics.world().state_hash())
}

#[expect(clippy::print_stdout, reason = "a benchmark shows its numbers")]
fn measure(name: &str, app: &mut App, frames: usize) {
    let mut parts: [Vec<f64>; 4] = Default::default();
    for _ in 0..frames {
        app.world_mut().resource_mut::<Marks>().0.clear();
        let start = Instant::now();
        app.update();
        let whole = start.elapsed();
        let marks = &app.world().resource::<Marks>().0;
        if let [a, b, c, d] = marks[..] {
            for (part, time) in parts.iter_mut().zip([b - a, c - b, d - c, whole]) {
                part.push(1000.0 * time.as_secs_f64());
            }
        }
    }
    let [read, step, write, whole] = parts.map(|mut part| {
        part.sort_by(f64::total_cmp);
        part.get(part.len() / 2).copied().unwrap_or(f64::NAN)
    });
    println!(
        "{name:24} read {read:8.4}  step {step:8.4}  write {write:8.4}  frame {whole:8.4}  {:016x}",
        hash(app)
    );
}

#[expect(clippy::print_stdout, reason = "a benchmark shows its numbers")]
fn main() {
    let mut asleep = game(1);
    asleep.world_mut().spawn(Collider::half_space(Vec3::Y));
    grid(&mut asleep, 10_000, 2.0);
    (0..200).for_each(|_| asleep.update());
    measure("10,000 asleep", &mut asleep, 400);

    let mut moving = game(1);
    grid(&mut moving, 10_000, 2.0);
    (0..10).for_each(|_| moving.update());
    measure("10,000 moving", &mut moving, 100);

    let mut many = game(1);
    many.update();
    let start = Instant::now();
    grid(&mut many, 100_000, 2.0);
    let spawned = start.elapsed();
    many.world_mut().resource_mut::<Marks>().0.clear();
    let start = Instant::now();
    many.update();
    let (frame, marks) = (start.elapsed(), &many.world().resource::<Marks>().0);
    let read = marks[1] - marks[0];
    println!("100,000 spawned: {spawned:.2?} in Bevy, {read:.2?} to read, {frame:.2?} the frame");

    let mut fixed = game(1);
    for k in 0..100_u8 {
        for l in 0..100_u8 {
            for m in 0..10_u8 {
                let at = [k, l, m].map(|n| 2.0 * f32::from(n));
                fixed
                    .world_mut()
                    .spawn((Collider::sphere(0.5), Transform::from_xyz(at[0], at[1], at[2])));
            }
        }
    }
    (0..10).for_each(|_| fixed.update());
    measure("100,000 static", &mut fixed, 100);
}
