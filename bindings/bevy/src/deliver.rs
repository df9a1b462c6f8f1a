//! The delivery of events after a step.

use bevy_ecs::entity::Entity;
use bevy_ecs::event::Event;
use bevy_ecs::message::MessageWriter;
use bevy_ecs::system::{Commands, Query, ResMut, SystemParam};
use bevy_ecs::world::World;
use drystone::events::{ContactEvent, FaultKind, FractureEvent};
use drystone::{BodyId, ShapeId};

use crate::collider::PhysicsCollider;
use crate::convert::from_vec;
use crate::events::{
    CollidingEntities, CollisionEnd, CollisionHit, CollisionStart, JointBroke, PhysicsFault,
    SensorEnter, SensorExit,
};
use crate::fracture::Cracked;
use crate::joint::PhysicsJoint;
use crate::queue::Pending;
use crate::world::PhysicsWorld;

/// Lists and writers of events.
#[derive(SystemParam)]
pub(crate) struct Delivery<'w, 's> {
    colliders: Query<'w, 's, &'static PhysicsCollider>,
    joints: Query<'w, 's, &'static mut PhysicsJoint>,
    lists: Query<'w, 's, &'static mut CollidingEntities>,
    starts: MessageWriter<'w, CollisionStart>,
    ends: MessageWriter<'w, CollisionEnd>,
    hits: MessageWriter<'w, CollisionHit>,
    enters: MessageWriter<'w, SensorEnter>,
    exits: MessageWriter<'w, SensorExit>,
    breaks: MessageWriter<'w, JointBroke>,
    faults: MessageWriter<'w, PhysicsFault>,
}

/// Events for observers, of all worlds.
#[derive(Debug, Default)]
struct Told {
    starts: Vec<CollisionStart>,
    ends: Vec<CollisionEnd>,
    hits: Vec<CollisionHit>,
    enters: Vec<SensorEnter>,
    exits: Vec<SensorExit>,
    breaks: Vec<JointBroke>,
}

/// The entities of a touch: first collider, second collider, first body, second body.
type Touch = [Entity; 4];

/// The system that delivers the events of the step.
pub(crate) fn deliver(
    mut worlds: Query<'_, '_, (Entity, &mut PhysicsWorld)>,
    mut delivery: Delivery<'_, '_>,
    mut pending: ResMut<'_, Pending>,
    mut commands: Commands<'_, '_>,
) {
    let (mut told, mut cracked) = (Told::default(), Vec::new());
    for (of, mut physics) in &mut worlds {
        if physics.world.step_count() == physics.delivered {
            continue;
        }
        physics.gone.sort_unstable_by_key(|gone| gone.shape);
        delivery.touches(of, &mut physics, &mut told);
        delivery.hits(of, &physics, &mut told);
        delivery.sensors(of, &physics, &mut told);
        delivery.breaks(&mut physics, &mut told);
        cracked.extend(delivery.cracks(of, &physics));
        delivery.faults(of, &physics);
        physics.gone.clear();
        physics.delivered = physics.world.step_count();
    }
    for entity in core::mem::take(&mut pending.lists) {
        delivery.fill(entity, &worlds);
    }
    told.write(&mut delivery);
    told.queue(&mut commands);
    for crack in cracked {
        commands.queue(move |world: &mut World| crack.apply(world));
    }
}

impl Delivery<'_, '_> {
    /// The collider and the body of a shape, which may have been removed meanwhile.
    fn ends(
        &self,
        of: Entity,
        physics: &PhysicsWorld,
        shape: ShapeId,
        body: BodyId,
    ) -> Option<(Entity, Entity)> {
        if let Ok(place) = physics.gone.binary_search_by_key(&shape, |gone| gone.shape) {
            let gone = physics.gone[place];
            return Some((gone.collider, gone.body));
        }
        let collider = Entity::try_from_bits(physics.world.shape(shape)?.user_data())?;
        let owner = physics.entity_of(body)?;
        // Shapes that the user added to the world have numbers of their own.
        let record = self.colliders.get(collider).ok()?;
        (record.owner == Some(owner) && record.world == Some(of)).then_some((collider, owner))
    }

    fn touch(&self, of: Entity, physics: &PhysicsWorld, event: &ContactEvent) -> Option<Touch> {
        let (collider1, body1) = self.ends(of, physics, event.shape_a, event.body_a)?;
        let (collider2, body2) = self.ends(of, physics, event.shape_b, event.body_b)?;
        Some([collider1, collider2, body1, body2])
    }

    /// Begins and ends. A pair of colliders with several shapes touches while any two of their
    /// shapes do.
    ///
    /// A shape that was replaced ends its old touch before the new one begins; a touch that began
    /// and ended within the step begins first.
    fn touches(&mut self, of: Entity, physics: &mut PhysicsWorld, told: &mut Told) {
        let events = physics.world.events();
        let begun = |end: &ContactEvent| {
            let is_same =
                |e: &ContactEvent| (e.shape_a, e.shape_b).cmp(&(end.shape_a, end.shape_b));
            events.contact_begin.binary_search_by(is_same).is_ok()
        };
        let (late, early): (Vec<_>, Vec<_>) = events.contact_end.iter().partition(|e| begun(e));
        let touch = |event: &ContactEvent| self.touch(of, physics, event);
        let early: Vec<Touch> = early.into_iter().filter_map(touch).collect();
        let starts: Vec<Touch> = events.contact_begin.iter().filter_map(touch).collect();
        let late: Vec<Touch> = late.into_iter().filter_map(touch).collect();
        for touch in early {
            self.end(physics, touch, told);
        }
        for touch in starts {
            self.start(physics, touch, told);
        }
        for touch in late {
            self.end(physics, touch, told);
        }
    }

    fn start(&mut self, physics: &mut PhysicsWorld, touch: Touch, told: &mut Told) {
        let [collider1, collider2, body1, body2] = touch;
        let has_several =
            |entity: Entity| self.colliders.get(entity).is_ok_and(|c| c.shapes.len() > 1);
        if has_several(collider1) || has_several(collider2) {
            let count = physics.touching.entry(pair(collider1, collider2)).or_insert(0);
            *count += 1;
            if *count > 1 {
                return;
            }
        }
        told.starts.push(CollisionStart { collider1, collider2, body1, body2 });
        self.list(collider1, |list| list.add(collider2));
        self.list(collider2, |list| list.add(collider1));
    }

    fn end(&mut self, physics: &mut PhysicsWorld, touch: Touch, told: &mut Told) {
        let [collider1, collider2, body1, body2] = touch;
        let pair = pair(collider1, collider2);
        if let Some(count) = physics.touching.get_mut(&pair) {
            *count -= 1;
            if *count > 0 {
                return;
            }
            physics.touching.remove(&pair);
        }
        told.ends.push(CollisionEnd { collider1, collider2, body1, body2 });
        self.list(collider1, |list| list.remove(collider2));
        self.list(collider2, |list| list.remove(collider1));
    }

    fn list(&mut self, entity: Entity, change: impl FnOnce(&mut CollidingEntities)) {
        if let Ok(mut list) = self.lists.get_mut(entity) {
            change(&mut list);
        }
    }

    fn hits(&self, of: Entity, physics: &PhysicsWorld, told: &mut Told) {
        for hit in &physics.world.events().hits {
            let first = self.ends(of, physics, hit.shape_a, hit.body_a);
            let second = self.ends(of, physics, hit.shape_b, hit.body_b);
            let Some(((collider1, body1), (collider2, body2))) = first.zip(second) else {
                continue;
            };
            told.hits.push(CollisionHit {
                collider1,
                collider2,
                body1,
                body2,
                point: from_vec(hit.point),
                normal: from_vec(hit.normal),
                speed: hit.speed,
                impulse: hit.impulse,
            });
        }
    }

    fn sensors(&mut self, of: Entity, physics: &PhysicsWorld, told: &mut Told) {
        let events = physics.world.events();
        for exit in &events.sensor_exit {
            let own = self.ends(of, physics, exit.sensor, exit.sensor_body);
            let other = self.ends(of, physics, exit.visitor, exit.visitor_body);
            let Some(((sensor, sensor_body), (visitor, visitor_body))) = own.zip(other) else {
                continue;
            };
            told.exits.push(SensorExit { sensor, visitor, sensor_body, visitor_body });
            self.list(sensor, |list| list.remove(visitor));
        }
        for enter in &events.sensor_enter {
            let own = self.ends(of, physics, enter.sensor, enter.sensor_body);
            let other = self.ends(of, physics, enter.visitor, enter.visitor_body);
            let Some(((sensor, sensor_body), (visitor, visitor_body))) = own.zip(other) else {
                continue;
            };
            told.enters.push(SensorEnter { sensor, visitor, sensor_body, visitor_body });
            self.list(sensor, |list| list.add(visitor));
        }
    }

    fn breaks(&mut self, physics: &mut PhysicsWorld, told: &mut Told) {
        for broken in &physics.world.events().joint_break {
            let known = physics.joints.get_mut(broken.joint.index() as usize);
            let Some(joint) = known.and_then(Option::take).filter(|(id, _)| *id == broken.joint)
            else {
                continue;
            };
            let (_, joint) = joint;
            let Ok(mut record) = self.joints.get_mut(joint) else { continue };
            (record.link, record.is_broken) = (None, true);
            let ends = [broken.body_a, broken.body_b].map(|body| physics.world.body(body));
            let entity = |body: drystone::BodyRef<'_>| Entity::try_from_bits(body.user_data());
            let [body1, body2] = ends.map(|body| body.and_then(entity));
            let Some((body1, body2)) = body1.zip(body2) else { continue };
            told.breaks.push(JointBroke {
                joint,
                body1,
                body2,
                force: broken.force,
                torque: broken.torque,
                impulse: broken.impulse,
            });
        }
    }

    /// The fractures of the step. A piece has the number of the body that broke.
    fn cracks(&self, of: Entity, physics: &PhysicsWorld) -> Vec<Cracked> {
        let events = physics.world.events();
        let crack = |event: &FractureEvent| {
            let pieces = events.pieces_of(event).to_vec();
            let entity = physics.entity_of(*pieces.first()?)?;
            Some(Cracked { world: of, entity, pieces, point: event.point })
        };
        events.fractures.iter().filter_map(crack).collect()
    }

    fn faults(&mut self, of: Entity, physics: &PhysicsWorld) {
        for fault in &physics.world.events().faults {
            let body = fault.body.and_then(|body| physics.entity_of(body));
            let joint = fault.joint.and_then(|joint| physics.world.joint(joint));
            let joint = joint.and_then(|joint| Entity::try_from_bits(joint.user_data()));
            let text = match fault.kind {
                FaultKind::Refused(call) => {
                    format!("`{}` was refused: a number is out of range", call.name())
                }
                kind => format!("step {}: {kind:?}", fault.step),
            };
            let entity = body.or(joint);
            PhysicsFault { world: of, entity, text }.report(&mut self.faults);
        }
    }

    /// Fills a list that was inserted late with the touches of now.
    fn fill(&mut self, entity: Entity, worlds: &Query<'_, '_, (Entity, &mut PhysicsWorld)>) {
        let Ok(record) = self.colliders.get(entity) else { return };
        let Some(Ok((of, physics))) = record.world.map(|world| worlds.get(world)) else { return };
        let world = &physics.world;
        let mut others = Vec::new();
        for shape in record.shapes.iter().filter_map(|shape| world.shape(*shape)) {
            for contact in shape.contacts() {
                // A contact that only might touch has points but no impulse.
                if contact.points().any(|point| point.impulse > 0.0) {
                    let is_first = contact.shape_a() == shape.id();
                    others.push(if is_first {
                        (contact.shape_b(), contact.body_b())
                    } else {
                        (contact.shape_a(), contact.body_a())
                    });
                }
            }
            let body = |id| world.shape(id).map(|shape| (id, shape.body()));
            others.extend(shape.sensor_overlaps().filter_map(body));
        }
        let ends = |(shape, body)| self.ends(of, physics, shape, body);
        let entities: Vec<Entity> =
            others.into_iter().filter_map(ends).map(|(collider, _)| collider).collect();
        self.list(entity, |list| entities.into_iter().for_each(|entity| list.add(entity)));
    }
}

/// A pair of colliders in either order.
fn pair(a: Entity, b: Entity) -> (Entity, Entity) {
    (a.min(b), a.max(b))
}

impl Told {
    fn write(&self, delivery: &mut Delivery<'_, '_>) {
        delivery.starts.write_batch(self.starts.iter().copied());
        delivery.ends.write_batch(self.ends.iter().copied());
        delivery.hits.write_batch(self.hits.iter().copied());
        delivery.enters.write_batch(self.enters.iter().copied());
        delivery.exits.write_batch(self.exits.iter().copied());
        delivery.breaks.write_batch(self.breaks.iter().copied());
    }

    /// Triggers the events for observers, where there are any.
    fn queue(self, commands: &mut Commands<'_, '_>) {
        let Self { starts, ends, hits, enters, exits, breaks } = self;
        if starts.is_empty()
            && ends.is_empty()
            && hits.is_empty()
            && enters.is_empty()
            && exits.is_empty()
            && breaks.is_empty()
        {
            return;
        }
        commands.queue(move |world: &mut World| {
            trigger(world, ends, |e| CollisionEnd {
                collider1: e.collider2,
                collider2: e.collider1,
                body1: e.body2,
                body2: e.body1,
            });
            trigger(world, starts, |e| CollisionStart {
                collider1: e.collider2,
                collider2: e.collider1,
                body1: e.body2,
                body2: e.body1,
            });
            trigger(world, hits, |e| CollisionHit {
                collider1: e.collider2,
                collider2: e.collider1,
                body1: e.body2,
                body2: e.body1,
                normal: -e.normal,
                ..e
            });
            trigger_once(world, exits);
            trigger_once(world, enters);
            trigger_once(world, breaks);
        });
    }
}

fn is_observed<E: Event>(world: &World) -> bool {
    let key = world.event_key::<E>();
    key.is_some_and(|key| world.observers().try_get_observers(key).is_some())
}

/// Triggers events for both of their entities.
fn trigger<E>(world: &mut World, events: Vec<E>, other: impl Fn(E) -> E)
where
    E: Copy + for<'a> Event<Trigger<'a>: Default>,
{
    if is_observed::<E>(world) {
        for event in events {
            world.trigger(event);
            world.trigger(other(event));
        }
    }
}

fn trigger_once<E>(world: &mut World, events: Vec<E>)
where
    E: for<'a> Event<Trigger<'a>: Default>,
{
    if is_observed::<E>(world) {
        for event in events {
            world.trigger(event);
        }
    }
}
