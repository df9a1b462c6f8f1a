//! The beginning of a step: physics reads what changed.
//!
//! Queues and change filters list the entities to look at. For each of them the world is brought in
//! line with the components, whatever the order of the changes was: first removals, then new
//! bodies in the order of [`PhysicsOrder`](crate::PhysicsOrder), then changes.

mod hosts;
mod moves;
mod scan;
mod shapes;
mod values;

pub(crate) use self::scan::scan;
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
    AngularDamping, BodyLink, ConstantForce, ConstantTorque, GravityScale, LinearDamping,
    LockedAxes, Mass, MassProperties, PhysicsBody, SleepThreshold,
};
use crate::collider::PhysicsCollider;
use crate::events::PhysicsFault;
use crate::forces::PendingForces;
use crate::fracture::Fracture;
use crate::queue::Pending;
use crate::scene::{BodiesBelow, Scene};
use crate::step::write_sleeping;
use crate::surface::{
    ColliderDensity, CollisionLayers, Friction, HitSpeed, KineticFriction, OneWay, Restitution,
    RollingResistance, SensorSenses, SpinningResistance, SurfaceVelocity,
};
use crate::world::{DefaultPhysicsWorld, Gravity, PhysicsTime, PhysicsWorld};

/// The plugin's records and worlds, for changes.
#[derive(SystemParam)]
pub(crate) struct Records<'w, 's> {
    pub(crate) worlds: Query<'w, 's, &'static mut PhysicsWorld>,
    world_ids: Query<'w, 's, Entity, With<PhysicsWorld>>,
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
    Changed<Fracture>,
)>;

type ColliderChanges = Or<(
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

/// The entities with changed values.
#[derive(SystemParam)]
pub(crate) struct Changes<'w, 's> {
    bodies: Query<'w, 's, Entity, (With<PhysicsBody>, BodyChanges)>,
    colliders: Query<'w, 's, Entity, (With<PhysicsBody>, ColliderChanges)>,
    trees: Query<'w, 's, Entity, (With<BodiesBelow>, Changed<Transform>)>,
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
    /// Entities whose transform has other bits than the plugin last read or wrote.
    pub(crate) placed: Vec<Entity>,
    /// Bodies whose velocities have other bits.
    pub(crate) pushed: Vec<Entity>,
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
    /// Bodies whose sleep a restored world changed.
    pub(super) sleep_writes: Vec<(Entity, bool)>,
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
        sleep_writes: Vec::new(),
        lost_shapes: Vec::new(),
        dt: time.delta_secs() * pace.scale,
    };
    sync.pending.joints = core::mem::take(&mut todo.joints);
    sync.pending.strands = core::mem::take(&mut todo.strands);
    sync.pending.gone_strands = core::mem::take(&mut todo.gone_strands);
    sync.pending.lists = core::mem::take(&mut todo.lists);
    sync.pending.gone_joints = core::mem::take(&mut todo.gone_joints);
    sync.meet_restored(&mut todo);
    sync.remove_gone(&mut todo);
    sync.collect(&todo, &changes);
    sync.unlink_stale();
    let (attached, existing) = sync.sort_out();
    sync.add_hosts(&attached);
    sync.update_hosts(&attached, &existing);
    sync.apply_sleep(&todo.sleepers);
    sync.end_targets();
    sync.set_velocities();
    sync.move_bodies();
    sync.apply_forces(&mut changes.forces);
    sync.mark_ancestors(&mut commands);
    for (entity, is_asleep) in sync.sleep_writes {
        write_sleeping(entity, is_asleep, &mut commands);
    }
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

    /// Looks at everything in worlds that were put back, and removes their bodies whose entities
    /// are gone meanwhile.
    fn meet_restored(&mut self, todo: &mut Pending) {
        for of in self.records.world_ids.iter() {
            let Ok(mut physics) = self.records.worlds.get_mut(of) else { continue };
            if !core::mem::take(&mut physics.is_restored) {
                continue;
            }
            todo.all = true;
            let mut strangers: Vec<BodyId> = Vec::new();
            for body in physics.world.bodies().filter(|body| body.user_data() != 0) {
                let entity = Entity::try_from_bits(body.user_data());
                let record = entity.and_then(|entity| self.records.bodies.get_mut(entity).ok());
                let link = Some(BodyLink { world: of, body: body.id() });
                match (record, entity) {
                    (Some(mut record), Some(entity)) if record.link == link => {
                        if record.asleep != body.is_asleep() {
                            record.asleep = body.is_asleep();
                            self.sleep_writes.push((entity, record.asleep));
                        }
                    }
                    _ => strangers.push(body.id()),
                }
            }
            for body in strangers {
                physics.world.remove_body(body);
            }
        }
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
        self.collect_places(&changes.trees);
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
