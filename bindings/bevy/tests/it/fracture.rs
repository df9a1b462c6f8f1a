//! Bodies that break, and bodies of the engine that get entities.

use bevy_drystone::{
    Collider, Fracture, Fractured, Friction, Gravity, LinearVelocity, Mass, MassProperties,
    PhysicsBody, PhysicsCollider, PhysicsWorld, RigidBody,
};
use bevy_ecs::hierarchy::ChildOf;
use bevy_math::Vec3;
use bevy_transform::components::Transform;
use drystone::{BodyDef, ShapeDef};

use crate::game::{Game, near};

/// A ball of 5 kg at 10 m/s breaks a pane. The pieces are entities with bodies, their mass is that
/// of the pane, and they go on like bodies that were spawned.
#[test]
fn a_pane_breaks_into_entities() {
    let mut game = Game::new();
    game.app.insert_resource(Gravity::ZERO);
    let glass = (Fracture::by_impulse(5.0).with_pieces(8), Friction::new(0.3));
    let pane = game.spawn((RigidBody::Dynamic, Collider::cuboid(1.0, 1.0, 0.1), glass));
    let ball = (RigidBody::Dynamic, Collider::sphere(0.2), Mass(5.0));
    let ball = (ball, Transform::from_xyz(0.0, 0.0, 0.5), LinearVelocity(Vec3::Z * -10.0));
    game.spawn(ball);
    game.run(1);
    let mass = game.body(pane).mass();
    let mut broken = Vec::new();
    for _ in 0..20 {
        game.run(1);
        broken.extend(game.messages::<Fractured>());
        game.check();
    }
    assert_eq!(broken.len(), 1);
    assert_eq!(broken[0].entity, pane);
    let pieces = broken[0].pieces.clone();
    assert!(pieces.len() > 1 && pieces.len() <= 8);
    let sum: f32 = pieces.iter().map(|piece| game.body(*piece).mass()).sum();
    assert!(near(sum / mass, 1.0, 1e-4), "{sum} of {mass}");
    assert!(game.get::<PhysicsBody>(pane).body().is_none());
    for piece in &pieces {
        assert!(near(game.get::<Friction>(*piece).coefficient, 0.3, 0.0));
        assert_eq!(game.get::<PhysicsCollider>(*piece).body(), Some(*piece));
        let gap =
            drystone::Vec3::from(game.place(*piece).to_array()) - game.body(*piece).position();
        assert!(gap.length() < 1e-6);
    }
    game.despawn(pieces[0]);
    game.insert(pieces[1], RigidBody::Static);
    game.run(2);
    game.check();
    assert_eq!(game.world().counts().dynamic, pieces.len() - 1);
    assert!(game.faults().is_empty());
}

#[test]
fn a_body_that_cannot_break_says_so() {
    let mut game = Game::new();
    game.spawn((RigidBody::Dynamic, Collider::sphere(0.5), Fracture::by_energy(1.0)));
    game.run(1);
    assert_eq!(game.faults().len(), 1);
    assert_eq!(game.world().counts().dynamic, 1);
}

/// A body of two shapes of the engine gets an entity and two children, without a change of its
/// motion.
#[test]
fn bodies_of_the_engine_can_be_adopted() {
    let mut game = Game::new();
    let of = game.default_world();
    let (left, right) = (ShapeDef::sphere(0.5), ShapeDef::box_full([1.0, 2.0, 3.0]));
    let left = left.with_position([-1.0, 0.0, 0.0]).with_friction(0.1);
    let right = right.with_position([1.0, 0.0, 0.0]).with_density(50.0);
    let mut added = None;
    game.change::<PhysicsWorld>(of, |physics| {
        let def = BodyDef::dynamic().with_shape(left).with_shape(right).with_damping(0.1, 0.2);
        added = physics.world_mut().add_body(def.with_linear_velocity([1.0, 2.0, 3.0])).ok();
    });
    let added = added.expect("a body");
    let mut twin = game.world().clone();
    let entity = PhysicsWorld::adopt(game.app.world_mut(), of, added).expect("an entity");
    assert!(PhysicsWorld::adopt(game.app.world_mut(), of, added).is_none(), "only once");
    game.run(32);
    twin.set_gravity([0.0, -9.81, 0.0]);
    (0..32).for_each(|_| twin.step(1.0 / 64.0));
    assert_eq!(game.world().state_hash(), twin.state_hash());
    game.check();
    let children = game.app.world_mut().query::<(&ChildOf, &PhysicsCollider)>();
    let mut children = children;
    let count = children.iter(game.app.world()).filter(|(of, _)| of.parent() == entity).count();
    assert_eq!(count, 2);
    // Its components are the user's now.
    game.insert(entity, MassProperties::new(9.0, Vec3::ZERO, Vec3::ONE));
    game.run(1);
    assert!(near(game.body(entity).mass(), 9.0, 1e-5));
    game.despawn(entity);
    game.run(1);
    assert_eq!(game.world().counts().shapes, 0);
}
