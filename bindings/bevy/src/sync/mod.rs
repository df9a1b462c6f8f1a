//! The beginning of a step: physics reads what changed.
//!
//! Queues and change filters list the entities to look at. For each of them the world is brought in
//! line with the components, whatever the order of the changes was: first removals, then new
//! bodies in the order of [`PhysicsOrder`](crate::PhysicsOrder), then changes.

mod hosts;
mod moves;
mod shapes;
mod values;

use bevy_ecs::change_detection::DetectChanges;
use bevy_ecs::entity::Entity;
use bevy_ecs::message::MessageWriter;
use bevy_ecs::query::{Changed, Or, With};
use bevy_ecs::resource::Resource;
use bevy_ecs::system::{Commands, Query, Res, ResMut, SystemParam};
use bevy_time::Time;
use bevy_transform::components::Transform;
use drystone::BodyId;

use crate::body::{
    AngularDamping, AngularVelocity, ConstantForce, ConstantTorque, GravityScale, LinearDamping,
    LinearVelocity, LockedAxes, Mass, MassProperties, PhysicsBody, SleepThreshold,
};
use crate::collider::{Collider, PhysicsCollider};
use crate::events::PhysicsFault;
use crate::forces::PendingForces;
use crate::queue::Pending;
use crate::scene::{BodiesBelow, Scene};
use crate::surface::{
    ColliderDensity, CollisionLayers, Friction, HitSpeed, KineticFriction, OneWay, Restitution,
    RollingResistance, SensorSenses, SpinningResistance, SurfaceVelocity,
};
use crate::world::{DefaultPhysicsWorld, Gravity, PhysicsTime, PhysicsWorld};

/// The plugin's records and worlds, for changes.
#[derive(SystemParam)]
pub(crate) struct Records<'w, 's> {
    pub(crate) worlds: Query<'w, 's, &'static mut PhysicsWorld>,
    pub(crate) bodies: Query<'w, 's, &'static mut PhysicsBody>,
    pub(crate) colliders: Query<'w, 's, &'static mut PhysicsCollider>,
    pub(crate) faults: MessageWriter<'w, PhysicsFault>,
}

type BodyChanges = Or<(
    Changed<Mass>,
    Changed<MassProperties>,
    Changed<LinearDamping>,
    Changed<AngularDamping>,
    Changed<GravityScale>,
    Changed<LockedAxes>,
    Changed<ConstantForce>,
    Changed<ConstantTorque>,
    Changed<SleepThreshold>,
)>;

type ColliderChanges = Or<(
    Changed<Collider>,
    Changed<Friction>,
    Changed<KineticFriction>,
    Changed<RollingResistance>,
    Changed<SpinningResistance>,
    Changed<Restitution>,
    Changed<ColliderDensity>,
    Changed<CollisionLayers>,
    Changed<HitSpeed>,
    Changed<SurfaceVelocity>,
    Changed<OneWay>,
    Changed<SensorSenses>,
)>;

type VelocityChanges = Or<(Changed<LinearVelocity>, Changed<AngularVelocity>)>;

/// The entities with changed values.
#[derive(SystemParam)]
pub(crate) struct Changes<'w, 's> {
    bodies: Query<'w, 's, Entity, (With<PhysicsBody>, BodyChanges)>,
    colliders: Query<'w, 's, Entity, (With<PhysicsBody>, ColliderChanges)>,
    places: Query<'w, 's, Entity, (With<PhysicsBody>, Changed<Transform>)>,
    trees: Query<'w, 's, Entity, (With<BodiesBelow>, Changed<Transform>)>,
    velocities: Query<'w, 's, Entity, (With<PhysicsBody>, VelocityChanges)>,
    pub(super) forces: Query<'w, 's, (Entity, &'static mut PendingForces), Changed<PendingForces>>,
    every: Query<'w, 's, Entity, With<PhysicsBody>>,
}

/// State of the plugin between steps.
#[derive(Debug, Default, Resource)]
pub(crate) struct SyncState {
    round: u64,
    /// Kinematic bodies whose velocity of the last step came from a target.
    targets: Vec<Entity>,
    /// Bodies whose transform must be written after the step although they may not move in it,
    /// since an ancestor moved.
    pub(crate) rewrite: Vec<Entity>,
    /// Bodies that the last step moved; they are shown between two poses.
    pub(crate) moving: Vec<Entity>,
    /// Whether bodies were added in this round, so that waiting joints may find their ends.
    pub(crate) has_new_bodies: bool,
    /// Whether a world came or went.
    pub(crate) has_other_worlds: bool,
}

/// The work of one round.
pub(crate) struct Sync<'a, 'w, 's, 'v, 't> {
    pub(super) scene: &'a Scene<'w, 's>,
    pub(super) records: &'a mut Records<'v, 't>,
    pub(super) pending: &'a mut Pending,
    pub(super) state: &'a mut SyncState,
    /// Entities to look at, each once.
    pub(super) dirty: Vec<Entity>,
    /// Bodies that were moved, and whether an ancestor moved rather than the body itself.
    pub(super) moved: Vec<(Entity, bool)>,
    /// Entities whose bodies were added in this round, sorted.
    pub(super) added: Vec<Entity>,
    /// Bodies that lost a shape, by the entity of their world.
    pub(super) lost_shapes: Vec<(Entity, BodyId)>,
    /// Length of the step [s].
    pub(super) dt: f32,
}

/// The system that reads all changes.
pub(crate) fn read_changes(
    scene: Scene<'_, '_>,
    mut records: Records<'_, '_>,
    mut changes: Changes<'_, '_>,
    mut pending: ResMut<'_, Pending>,
    mut state: ResMut<'_, SyncState>,
    (time, pace): (Res<'_, Time>, Res<'_, PhysicsTime>),
    (gravity, default): (Option<Res<'_, Gravity>>, Res<'_, DefaultPhysicsWorld>),
    mut commands: Commands<'_, '_>,
) {
    if let Some(gravity) = gravity
        && let Ok(mut physics) = records.worlds.get_mut(default.0)
        && physics.world.config().gravity != crate::convert::to_vec(gravity.0)
        && (gravity.is_changed() || physics.world.step_count() == 0)
    {
        physics.world.set_gravity(crate::convert::to_vec(gravity.0));
    }
    let mut todo = core::mem::take(&mut *pending);
    state.round += 1;
    (state.has_new_bodies, state.has_other_worlds) = (false, todo.all);
    state.rewrite.clear();
    let mut sync = Sync {
        scene: &scene,
        records: &mut records,
        pending: &mut pending,
        state: &mut state,
        dirty: Vec::new(),
        moved: Vec::new(),
        added: Vec::new(),
        lost_shapes: Vec::new(),
        dt: time.delta_secs() * pace.scale,
    };
    sync.pending.joints = core::mem::take(&mut todo.joints);
    sync.pending.strands = core::mem::take(&mut todo.strands);
    sync.pending.gone_strands = core::mem::take(&mut todo.gone_strands);
    sync.pending.lists = core::mem::take(&mut todo.lists);
    sync.pending.gone_joints = core::mem::take(&mut todo.gone_joints);
    sync.remove_gone(&mut todo);
    sync.collect(&todo, &changes);
    sync.unlink_stale();
    let (attached, existing) = sync.sort_out();
    sync.add_hosts(&attached);
    sync.update_hosts(&attached, &existing);
    sync.end_targets();
    let velocities: Vec<Entity> = changes.velocities.iter().collect();
    sync.set_velocities(velocities);
    sync.move_bodies();
    sync.apply_forces(&mut changes.forces);
    sync.mark_ancestors(&mut commands);
}

impl Sync<'_, '_, '_, '_, '_> {
    /// Adds an entity to those to look at.
    pub(super) fn mark(&mut self, entity: Entity) {
        if let Ok(mut record) = self.records.bodies.get_mut(entity)
            && record.round != self.state.round
        {
            record.round = self.state.round;
            self.dirty.push(entity);
        }
    }

    /// Reports a refused value or call.
    pub(super) fn fault(&mut self, world: Entity, entity: Option<Entity>, text: String) {
        PhysicsFault { world, entity, text }.report(&mut self.records.faults);
    }

    /// Removes bodies and shapes whose entities lost their records, in the order of ids.
    fn remove_gone(&mut self, todo: &mut Pending) {
        todo.gone_bodies.sort_unstable();
        for (world, body) in todo.gone_bodies.drain(..) {
            self.remove_body(world, body);
        }
        todo.gone_shapes.sort_unstable();
        for (world, shape) in todo.gone_shapes.drain(..) {
            self.remove_shape(world, shape);
        }
    }

    /// Lists the entities to look at.
    fn collect(&mut self, todo: &Pending, changes: &Changes<'_, '_>) {
        if todo.all {
            changes.every.iter().for_each(|entity| self.mark(entity));
        }
        todo.dirty.iter().for_each(|entity| self.mark(*entity));
        for entity in &todo.trees {
            self.mark_tree(*entity);
        }
        changes.bodies.iter().for_each(|entity| self.mark(entity));
        changes.colliders.iter().for_each(|entity| self.mark(entity));
        self.collect_places(&changes.places, &changes.trees);
    }

    /// Marks an entity and everything below it.
    fn mark_tree(&mut self, entity: Entity) {
        self.mark(entity);
        self.moved.push((entity, true));
        let scene = self.scene;
        scene.each_below(entity, |entity| {
            self.mark(entity);
            self.moved.push((entity, true));
        });
    }

    /// Marks the ancestors of new bodies and colliders, so that their moves are noticed.
    fn mark_ancestors(&mut self, commands: &mut Commands<'_, '_>) {
        let mut above: Vec<Entity> = Vec::new();
        for entity in &self.dirty {
            let unmarked = |above: &Entity| !self.scene.below.get(*above).unwrap_or(true);
            above.extend(self.scene.ancestors(*entity).filter(unmarked));
        }
        above.sort_unstable();
        above.dedup();
        for entity in above {
            commands.entity(entity).try_insert(BodiesBelow);
        }
    }
}
