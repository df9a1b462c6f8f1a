//! The plugin and its schedule.

use bevy_app::{
    App, FixedFirst, FixedPostUpdate, Plugin, RunFixedMainLoop, RunFixedMainLoopSystems,
};
use bevy_ecs::intern::Interned;
use bevy_ecs::prelude::{
    Commands, Entity, IntoScheduleConfigs, Query, Res, ResMut, Resource, SystemSet, With,
};
use bevy_ecs::schedule::ScheduleLabel;
use drystone::World;

use crate::caster::cast;
use crate::deliver::deliver;
use crate::events::{
    CollisionEnd, CollisionHit, CollisionStart, JointBroke, PhysicsFault, SensorEnter, SensorExit,
};
use crate::fracture::Fractured;
use crate::joint::read_joints;
use crate::queue::{Pending, note_orphan, note_parent};
use crate::register::register_types;
use crate::step::{show_between, show_true, step_worlds, write_back};
use crate::strand::{read_strands, write_strands};
use crate::sync::{SyncState, read_changes, scan};
use crate::world::{DefaultPhysicsWorld, Gravity, PhysicsTime, PhysicsWorld};

/// Adds physics to an app.
///
/// By default it runs in `FixedPostUpdate`, with the length of the fixed step, on all cores, and
/// shows bodies between their last two poses.
#[derive(Clone, Copy, Debug)]
pub struct DrystonePlugin {
    schedule: Interned<dyn ScheduleLabel>,
    threads: usize,
    interpolates: bool,
}

impl Default for DrystonePlugin {
    fn default() -> Self {
        Self { schedule: FixedPostUpdate.intern(), threads: 0, interpolates: true }
    }
}

impl DrystonePlugin {
    /// Physics in another schedule, without interpolation. A step has the length of that schedule's
    /// `Time`.
    #[must_use]
    pub fn in_schedule(schedule: impl ScheduleLabel) -> Self {
        Self { schedule: schedule.intern(), interpolates: false, ..Self::default() }
    }

    /// With this number of threads for the default world, including the caller's; 0, the default:
    /// as many as the machine has cores. The results do not depend on it.
    #[must_use]
    pub fn with_threads(self, threads: usize) -> Self {
        Self { threads, ..self }
    }

    /// Shows bodies where the last step left them.
    #[must_use]
    pub fn without_interpolation(self) -> Self {
        Self { interpolates: false, ..self }
    }
}

/// The parts of a step, in this order.
#[derive(Clone, Copy, Debug, Eq, Hash, PartialEq, SystemSet)]
pub enum PhysicsSystems {
    /// Empty, for systems that run before physics.
    First,
    /// Physics reads what changed.
    Prepare,
    /// All worlds advance by a step.
    StepSimulation,
    /// Physics writes what moved, and delivers events.
    Writeback,
    /// Empty, for systems that run after physics.
    Last,
}

/// Number of threads of a default world that must be made again.
#[derive(Debug, Resource)]
struct Threads(usize);

impl Plugin for DrystonePlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Pending>()
            .init_resource::<SyncState>()
            .init_resource::<Gravity>()
            .init_resource::<PhysicsTime>()
            .insert_resource(Threads(self.threads))
            .add_message::<CollisionStart>()
            .add_message::<CollisionEnd>()
            .add_message::<CollisionHit>()
            .add_message::<SensorEnter>()
            .add_message::<SensorExit>()
            .add_message::<JointBroke>()
            .add_message::<Fractured>()
            .add_message::<PhysicsFault>()
            .add_observer(note_parent)
            .add_observer(note_orphan);
        register_types(app);
        let world = PhysicsWorld::new(World::default().with_threads(self.threads));
        let world = app.world_mut().spawn(world).id();
        app.insert_resource(DefaultPhysicsWorld(world));
        // Entities may have been spawned before.
        app.world_mut().resource_mut::<Pending>().all = true;
        let order = (
            PhysicsSystems::First,
            PhysicsSystems::Prepare,
            PhysicsSystems::StepSimulation,
            PhysicsSystems::Writeback,
            PhysicsSystems::Last,
        );
        app.configure_sets(self.schedule, order.chain()).add_systems(
            self.schedule,
            (
                (keep_default_world, scan, read_changes, read_joints, read_strands)
                    .chain()
                    .in_set(PhysicsSystems::Prepare),
                step_worlds.in_set(PhysicsSystems::StepSimulation),
                (write_back, write_strands, deliver, cast)
                    .chain()
                    .in_set(PhysicsSystems::Writeback),
            ),
        );
        if self.interpolates {
            let after = RunFixedMainLoopSystems::AfterFixedMainLoop;
            app.add_systems(FixedFirst, show_true)
                .add_systems(RunFixedMainLoop, show_between.in_set(after));
        }
    }
}

/// Makes the default world again if it was despawned.
fn keep_default_world(
    worlds: Query<'_, '_, Entity, With<PhysicsWorld>>,
    mut default: ResMut<'_, DefaultPhysicsWorld>,
    threads: Res<'_, Threads>,
    mut commands: Commands<'_, '_>,
) {
    if !worlds.contains(default.0) {
        let world = PhysicsWorld::new(World::default().with_threads(threads.0));
        default.0 = commands.spawn(world).id();
    }
}
