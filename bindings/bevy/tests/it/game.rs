//! An app with physics and a clock that advances by one fixed step a frame.

use core::time::Duration;

use bevy_app::{App, FixedUpdate};
use bevy_drystone::{
    Collider, DefaultPhysicsWorld, DrystonePlugin, PhysicsBody, PhysicsFault, PhysicsWorld,
    RigidBody,
};
use bevy_ecs::component::Mutable;
use bevy_ecs::prelude::{Bundle, Component, Entity, IntoSystem, Messages, Query};
use bevy_ecs::system::RunSystemOnce;
use bevy_math::Vec3;
use bevy_time::{Fixed, Time, TimePlugin, TimeUpdateStrategy};
use bevy_transform::components::Transform;

/// Steps a second; a power of two, so that times are exact.
pub(crate) const HERTZ: f32 = 64.0;

/// An app with the plugin.
pub(crate) struct Game {
    pub(crate) app: App,
}

impl Game {
    pub(crate) fn new() -> Self {
        Self::with(DrystonePlugin::default().with_threads(1).without_interpolation())
    }

    pub(crate) fn with(plugin: DrystonePlugin) -> Self {
        let mut app = App::new();
        let frame = Duration::from_secs_f32(1.0 / HERTZ);
        app.add_plugins((TimePlugin, plugin))
            .insert_resource(TimeUpdateStrategy::ManualDuration(frame))
            .insert_resource(Time::<Fixed>::from_duration(frame));
        app.finish();
        app.cleanup();
        Self { app }
    }

    /// With ground below y = 0.
    pub(crate) fn on_ground() -> Self {
        let mut game = Self::new();
        game.spawn(Collider::half_space(Vec3::Y));
        game
    }

    pub(crate) fn spawn(&mut self, bundle: impl Bundle) -> Entity {
        self.app.world_mut().spawn(bundle).id()
    }

    /// A dynamic cube of 1 m at a place.
    pub(crate) fn cube(&mut self, at: [f32; 3]) -> Entity {
        let place = Transform::from_translation(Vec3::from_array(at));
        self.spawn((RigidBody::Dynamic, Collider::cuboid(1.0, 1.0, 1.0), place))
    }

    /// Runs frames until this number of steps was taken.
    pub(crate) fn run(&mut self, steps: u64) {
        let target = self.world().step_count() + steps;
        for _ in 0..2 * steps + 2 {
            if self.world().step_count() == target {
                return;
            }
            self.app.update();
        }
        assert_eq!(self.world().step_count(), target, "each frame takes a step");
    }

    pub(crate) fn default_world(&self) -> Entity {
        self.app.world().resource::<DefaultPhysicsWorld>().0
    }

    pub(crate) fn physics(&self) -> &PhysicsWorld {
        let world = self.default_world();
        self.app.world().get::<PhysicsWorld>(world).expect("a default world")
    }

    /// The engine's default world.
    pub(crate) fn world(&self) -> &drystone::World {
        self.physics().world()
    }

    pub(crate) fn body(&self, entity: Entity) -> drystone::BodyRef<'_> {
        let record = self.get::<PhysicsBody>(entity);
        let world = record.world().expect("in a world");
        let physics = self.app.world().get::<PhysicsWorld>(world).expect("a world");
        physics.world().body(record.body().expect("a body")).expect("in the engine")
    }

    pub(crate) fn get<C: Component>(&self, entity: Entity) -> &C {
        self.app.world().get::<C>(entity).expect("the component")
    }

    pub(crate) fn change<C: Component<Mutability = Mutable>>(
        &mut self,
        entity: Entity,
        change: impl FnOnce(&mut C),
    ) {
        let mut value = self.app.world_mut().get_mut::<C>(entity).expect("the component");
        change(&mut value);
    }

    pub(crate) fn insert(&mut self, entity: Entity, bundle: impl Bundle) {
        self.app.world_mut().entity_mut(entity).insert(bundle);
    }

    pub(crate) fn remove<B: Bundle>(&mut self, entity: Entity) {
        self.app.world_mut().entity_mut(entity).remove::<B>();
    }

    pub(crate) fn despawn(&mut self, entity: Entity) {
        self.app.world_mut().despawn(entity);
    }

    pub(crate) fn place(&self, entity: Entity) -> Vec3 {
        self.get::<Transform>(entity).translation
    }

    /// Runs a system in each fixed step.
    pub(crate) fn each_step<M>(
        &mut self,
        system: impl bevy_ecs::schedule::IntoScheduleConfigs<bevy_ecs::system::ScheduleSystem, M>,
    ) {
        self.app.add_systems(FixedUpdate, system);
    }

    /// Runs a system now.
    pub(crate) fn ask<T: 'static, M>(&mut self, system: impl IntoSystem<(), T, M> + 'static) -> T {
        self.app.world_mut().run_system_once(system).expect("valid parameters")
    }

    /// All messages of a kind since the last call.
    pub(crate) fn messages<T: bevy_ecs::message::Message>(&mut self) -> Vec<T> {
        self.app.world_mut().resource_mut::<Messages<T>>().drain().collect()
    }

    pub(crate) fn faults(&mut self) -> Vec<String> {
        self.messages::<PhysicsFault>().into_iter().map(|fault| fault.text).collect()
    }

    /// Checks that entities and world agree: each body has its entity, each entity its body, and
    /// the transform of each root is the body's pose.
    pub(crate) fn check(&mut self) {
        let linked = self.ask(|bodies: Query<'_, '_, (Entity, &PhysicsBody)>| {
            bodies
                .iter()
                .filter_map(|(e, body)| Some((e, body.world()?, body.body()?)))
                .collect::<Vec<_>>()
        });
        let mut worlds = self.app.world_mut().query::<(Entity, &PhysicsWorld)>();
        let mut bodies = 0;
        for (of, physics) in worlds.iter(self.app.world()) {
            for body in physics.world().bodies() {
                let entity = physics.entity_of(body.id()).expect("a body with an entity");
                assert!(linked.contains(&(entity, of, body.id())), "a leaked body of {entity}");
                bodies += 1;
            }
        }
        assert_eq!(linked.len(), bodies, "an entity with a body that is not there");
    }
}

/// Whether two numbers agree to `tolerance`.
pub(crate) fn near(a: f32, b: f32, tolerance: f32) -> bool {
    (a - b).abs() <= tolerance
}
