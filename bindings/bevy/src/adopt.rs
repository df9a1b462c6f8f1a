//! Entities for bodies that the engine or the user added to a world.

use bevy_ecs::entity::Entity;
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::world::World;
use bevy_transform::components::Transform;
use drystone::contact::Combine;
use drystone::{BodyId, BodyKind, MassDef, Pose, ShapeId, ShapeRef, Vec3};

use crate::body::{
    AngularDamping, AngularVelocity, BodyLink, GravityScale, LinearDamping, LinearVelocity,
    LockedAxes, Mass, MassProperties, PhysicsBody, RigidBody, SleepThreshold, Sleeping,
    SleepingDisabled,
};
use crate::collider::{Collider, PhysicsCollider};
use crate::convert::{from_quat, from_vec};
use crate::surface::{
    CoefficientCombine, ColliderDensity, ColliderDisabled, CollisionLayers, Friction, HitSpeed,
    KineticFriction, OneWay, Restitution, RollingResistance, Sensor, SpinningResistance,
    SurfaceVelocity,
};
use crate::world::{DefaultPhysicsWorld, InWorld, PhysicsWorld};

impl PhysicsWorld {
    /// Gives a body an entity with components that describe it, and an entity for each of its
    /// shapes: a child, or the same one for a single shape at the body's origin. The plugin then
    /// treats it like a body that was spawned. `of`: the entity of the world.
    ///
    /// Use it for bodies from files, or from definitions of the engine. `None` if there is no such
    /// world or body, or if the body has an entity already.
    ///
    /// ```
    /// use bevy_drystone::drystone::{BodyDef, ShapeDef};
    /// use bevy_drystone::{DefaultPhysicsWorld, DrystonePlugin, PhysicsWorld};
    ///
    /// let mut app = bevy_app::App::new();
    /// app.add_plugins((bevy_time::TimePlugin, DrystonePlugin::default()));
    /// let of = app.world().resource::<DefaultPhysicsWorld>().0;
    /// let mut physics = app.world_mut().get_mut::<PhysicsWorld>(of).ok_or("a default world")?;
    /// let ball = BodyDef::dynamic().with_shape(ShapeDef::sphere(0.5));
    /// let ball = physics.world_mut().add_body(ball)?;
    /// let entity = PhysicsWorld::adopt(app.world_mut(), of, ball);
    /// assert!(entity.is_some());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn adopt(world: &mut World, of: Entity, body: BodyId) -> Option<Entity> {
        let known = world.get::<Self>(of)?.entity_of(body);
        let is_linked = |entity: Entity| {
            world.get::<PhysicsBody>(entity).is_some_and(|record| record.body() == Some(body))
        };
        if known.is_some_and(is_linked) {
            return None;
        }
        let entity = world.spawn_empty().id();
        let shapes = describe_body(world, of, body, entity)?;
        for shape in shapes {
            describe_shape(world, of, shape, entity);
        }
        Some(entity)
    }
}

/// Inserts the components of a body. Returns its shapes.
fn describe_body(
    world: &mut World,
    of: Entity,
    body: BodyId,
    entity: Entity,
) -> Option<Vec<ShapeId>> {
    let mut physics = world.get_mut::<PhysicsWorld>(of)?;
    physics.world.body_mut(body)?.set_user_data(entity.to_bits());
    let found = physics.world.body(body)?;
    let kind = match found.kind() {
        BodyKind::Dynamic => RigidBody::Dynamic,
        BodyKind::Static => RigidBody::Static,
        BodyKind::Kinematic => RigidBody::Kinematic,
    };
    let local = transform(&found.pose());
    let (linear, angular) = (from_vec(found.linear_velocity()), from_vec(found.angular_velocity()));
    let record = PhysicsBody {
        link: Some(BodyLink { world: of, body }),
        local,
        before: local,
        linear,
        angular,
        asleep: found.is_asleep(),
        ..PhysicsBody::default()
    };
    let [linear_damping, angular_damping] = found.damping();
    let (mass, gravity, locks) = (found.mass_def(), found.gravity_scale(), found.locks());
    let (can_sleep, threshold) = (found.can_sleep(), found.sleep_speed());
    let is_asleep = found.is_asleep();
    let shapes = found.shapes().collect();
    let mut entity = world.entity_mut(entity);
    // The record comes first, so that the plugin finds the body of the other components.
    entity.insert((record, local, LinearVelocity(linear), AngularVelocity(angular)));
    entity.insert((GravityScale(gravity), LinearDamping(linear_damping)));
    entity.insert(AngularDamping(angular_damping));
    entity.insert(LockedAxes { translation: locks.linear, rotation: locks.angular });
    match mass {
        MassDef::FromShapes => {}
        MassDef::Mass(mass) => {
            entity.insert(Mass(mass));
        }
        MassDef::Exact { mass, center, inertia } => {
            let moments = bevy_math::Vec3::new(inertia.xx, inertia.yy, inertia.zz);
            let products = bevy_math::Vec3::new(inertia.xy, inertia.xz, inertia.yz);
            let center = from_vec(center);
            entity.insert(MassProperties { mass, center, moments, products });
        }
    }
    if is_asleep {
        entity.insert(Sleeping);
    }
    if !can_sleep {
        entity.insert(SleepingDisabled);
    }
    if let Some(speed) = threshold {
        entity.insert(SleepThreshold(speed));
    }
    if world_is_other(entity.world(), of) {
        entity.insert(InWorld(of));
    }
    entity.insert(kind);
    Some(shapes)
}

fn world_is_other(world: &World, of: Entity) -> bool {
    world.get_resource::<DefaultPhysicsWorld>().is_none_or(|default| default.0 != of)
}

/// Inserts the components of a shape into the entity of its body, or into a child.
fn describe_shape(world: &mut World, of: Entity, shape: ShapeId, body: Entity) -> Option<()> {
    let physics = world.get::<PhysicsWorld>(of)?;
    let found = physics.world.shape(shape)?;
    let owner = physics.world.body(found.body())?;
    let is_own = found.local_pose() == Pose::IDENTITY && owner.shapes().count() == 1;
    let place = transform(&found.local_pose());
    let collider = Collider::from_shape(found.shape().clone());
    let record = PhysicsCollider {
        world: Some(of),
        owner: Some(body),
        shapes: vec![shape],
        made_of: Some((collider.clone(), Vec3::ONE)),
    };
    let write = surface(&found);
    let entity = if is_own { body } else { world.spawn((place, ChildOf(body))).id() };
    let mut physics = world.get_mut::<PhysicsWorld>(of)?;
    physics.world.shape_mut(shape)?.set_user_data(entity.to_bits());
    let mut entity = world.entity_mut(entity);
    entity.insert(record);
    write(&mut entity);
    entity.insert(collider);
    Some(())
}

/// A function that inserts the surface of a shape into an entity.
fn surface(shape: &ShapeRef<'_>) -> impl FnOnce(&mut bevy_ecs::world::EntityWorldMut<'_>) + use<> {
    let (material, filter, density) = (shape.material(), shape.filter(), shape.density());
    let (linear, angular) = (shape.surface_velocity(), shape.surface_spin());
    let (one_way, speed) = (shape.one_way(), shape.reports().hit_speed);
    let (is_sensor, is_enabled) = (shape.is_sensor(), shape.is_enabled());
    move |entity| {
        entity.insert((
            Friction {
                coefficient: material.friction,
                combine_rule: rule(material.friction_combine),
            },
            Restitution {
                coefficient: material.restitution,
                combine_rule: rule(material.restitution_combine),
            },
            RollingResistance(material.rolling_resistance),
            SpinningResistance(material.spinning_resistance),
            ColliderDensity(density),
            CollisionLayers { memberships: filter.layers, filters: filter.mask },
        ));
        if let Some(kinetic) = material.kinetic_friction {
            entity.insert(KineticFriction(kinetic));
        }
        if linear != Vec3::ZERO || angular != Vec3::ZERO {
            let (linear, angular) = (from_vec(linear), from_vec(angular));
            entity.insert(SurfaceVelocity { linear, angular });
        }
        if let Some(front) = one_way {
            entity.insert(OneWay(from_vec(front)));
        }
        if let Some(speed) = speed {
            entity.insert(HitSpeed(speed));
        }
        if is_sensor {
            entity.insert(Sensor);
        }
        if !is_enabled {
            entity.insert(ColliderDisabled);
        }
    }
}

fn transform(pose: &Pose) -> Transform {
    Transform {
        translation: from_vec(pose.position),
        rotation: from_quat(pose.rotation),
        scale: bevy_math::Vec3::ONE,
    }
}

const fn rule(rule: Combine) -> CoefficientCombine {
    match rule {
        Combine::GeometricMean => CoefficientCombine::GeometricMean,
        Combine::Multiply => CoefficientCombine::Multiply,
        Combine::Maximum => CoefficientCombine::Max,
        Combine::Minimum => CoefficientCombine::Min,
        Combine::Average => CoefficientCombine::Average,
    }
}
