//! Programs made at random: entities and world agree after each step, whatever the program does.

use bevy_drystone::{
    AngularVelocity, Collider, ColliderDisabled, FixedJoint, Friction, InWorld, LinearVelocity,
    Mass, PhysicsBody, PhysicsCollider, PhysicsWorld, RigidBody, RigidBodyDisabled, RopeJoint,
    Sensor, Sleeping,
};
use bevy_ecs::hierarchy::ChildOf;
use bevy_ecs::prelude::Entity;
use bevy_math::{Quat, Vec3};
use bevy_transform::components::Transform;
use drystone::{BodyKind, Shape};

use crate::game::Game;

/// A generator of numbers [Steele14].
struct Dice(u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        usize::try_from(self.next() % n as u64).expect("below a small number")
    }

    /// A number from -`most` to `most`.
    fn number(&mut self, most: f32) -> f32 {
        let whole = u16::try_from(self.next() % 2001).expect("below 2001");
        (f32::from(whole) / 1000.0 - 1.0) * most
    }

    fn point(&mut self, most: f32) -> Vec3 {
        Vec3::new(self.number(most), self.number(most), self.number(most))
    }

    fn pick(&mut self, list: &[Entity]) -> Option<Entity> {
        (!list.is_empty()).then(|| list[self.below(list.len())])
    }

    fn collider(&mut self) -> Collider {
        let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        match self.below(9) {
            0 => Collider::cuboid(1.0, 0.5, 0.8),
            1 => Collider::capsule(0.3, 0.6),
            2 => Collider::cylinder(0.4, 0.7),
            3 => Collider::cone(0.5, 1.0),
            4 => Collider::half_space(Vec3::Y),
            5 => Collider::convex_hull(&corners).expect("a tetrahedron"),
            6 => Collider::trimesh(&corners, vec![[0, 1, 2], [1, 2, 3]]).expect("triangles"),
            7 => Collider::compound(
                [-1.0, 1.0].map(|x| (Vec3::X * x, Quat::IDENTITY, Collider::sphere(0.4))),
            ),
            _ => Collider::sphere(0.5),
        }
    }

    fn kind(&mut self) -> RigidBody {
        [RigidBody::Dynamic, RigidBody::Static, RigidBody::Kinematic][self.below(3)]
    }

    fn place(&mut self) -> Transform {
        let turn = Quat::from_xyzw(self.number(1.0), self.number(1.0), self.number(1.0), 1.1);
        Transform {
            translation: self.point(8.0),
            rotation: turn.normalize(),
            scale: Vec3::splat([1.0, 1.0, 1.0, 0.5, 2.0][self.below(5)]),
        }
    }
}

/// A program and the entities that it made.
struct Program {
    game: Game,
    dice: Dice,
    all: Vec<Entity>,
    joints: Vec<Entity>,
    worlds: Vec<Entity>,
    /// The seed and the step, for failures.
    at: (u64, usize),
    faults: Vec<String>,
}

impl Program {
    fn new(seed: u64) -> Self {
        let mut game = Game::new();
        let second = game.spawn(PhysicsWorld::default());
        let worlds = vec![second];
        Self {
            game,
            dice: Dice(seed),
            all: Vec::new(),
            joints: Vec::new(),
            worlds,
            at: (seed, 0),
            faults: Vec::new(),
        }
    }

    fn ancestors(&self, entity: Entity) -> Vec<Entity> {
        let parent = |e: &Entity| self.game.app.world().get::<ChildOf>(*e).map(ChildOf::parent);
        core::iter::successors(Some(entity), parent).collect()
    }

    fn spawn(&mut self) {
        let place = self.dice.place();
        let entity = match self.dice.below(4) {
            0 => self.game.spawn((self.dice.collider(), place)),
            1 => self.game.spawn((self.dice.kind(), place)),
            2 => self.game.spawn(place),
            _ => self.game.spawn((self.dice.kind(), self.dice.collider(), place)),
        };
        self.all.push(entity);
    }

    fn act(&mut self) {
        let action = self.dice.below(24);
        let Some(e) = self.dice.pick(&self.all).filter(|_| action > 3) else {
            return self.spawn();
        };
        let has_transform = self.game.app.world().get::<Transform>(e).is_some();
        let game = &mut self.game;
        match action {
            4 | 5 => {
                game.despawn(e);
                let world = self.game.app.world();
                self.all.retain(|e| world.get_entity(*e).is_ok());
            }
            6 => game.insert(e, self.dice.kind()),
            7 => game.remove::<RigidBody>(e),
            8 => game.insert(e, self.dice.collider()),
            9 => game.remove::<Collider>(e),
            10 | 11 => {
                let parent = self.dice.pick(&self.all).expect("at least one");
                if !self.ancestors(parent).contains(&e) {
                    self.game.insert(e, ChildOf(parent));
                }
            }
            12 => game.remove::<ChildOf>(e),
            13 | 14 if has_transform => {
                let place = self.dice.place();
                game.change::<Transform>(e, |now| *now = place);
            }
            15 if has_transform => {
                let scale = self.dice.point(2.0);
                game.change::<Transform>(e, |now| now.scale = scale);
            }
            16 => game.insert(e, (LinearVelocity(self.dice.point(5.0)), AngularVelocity(Vec3::Y))),
            17 => match self.dice.below(4) {
                0 => game.insert(e, Sensor),
                1 => game.remove::<Sensor>(e),
                2 => game.insert(e, ColliderDisabled),
                _ => game.remove::<ColliderDisabled>(e),
            },
            18 => match self.dice.below(4) {
                0 => game.insert(e, RigidBodyDisabled),
                1 => game.remove::<RigidBodyDisabled>(e),
                2 => game.insert(e, Sleeping),
                _ => game.remove::<Sleeping>(e),
            },
            19 => {
                let other = self.dice.pick(&self.all).expect("at least one");
                let joint = if self.dice.below(2) == 0 {
                    game.spawn(FixedJoint::new(e, other).at(Vec3::ZERO))
                } else {
                    game.spawn(RopeJoint::new(e, other, 3.0))
                };
                self.joints.push(joint);
            }
            20 => {
                if let Some(joint) = self.dice.pick(&self.joints) {
                    game.despawn(joint);
                    self.joints.retain(|other| *other != joint);
                }
            }
            21 => match self.dice.pick(&self.worlds).filter(|_| self.dice.below(2) == 0) {
                Some(world) => game.insert(e, InWorld(world)),
                None => game.remove::<InWorld>(e),
            },
            22 => match self.dice.below(4) {
                0 => game.insert(e, Mass(self.dice.number(2.0))),
                1 => game.remove::<Mass>(e),
                2 => game.insert(e, Friction::new(self.dice.number(2.0))),
                _ => game.remove::<Friction>(e),
            },
            _ => {
                // A world goes, and another comes.
                if self.dice.below(40) == 0 {
                    let gone = self.worlds.remove(0);
                    game.despawn(gone);
                    let next = self.game.spawn(PhysicsWorld::default());
                    self.worlds.push(next);
                }
            }
        }
    }

    /// Compares the engine with a picture of it that is made from the components alone.
    fn check(&mut self) {
        self.game.check();
        let world = self.game.app.world();
        let mut known = 0;
        for e in &self.all {
            let up = self.ancestors(*e);
            let has_body = |e: &&Entity| world.get::<RigidBody>(**e).is_some();
            let owner = up.iter().find(has_body).unwrap_or(e);
            let kind = world.get::<RigidBody>(*e).copied();
            let is_alone = world.get::<Collider>(*e).is_some() && owner == e;
            let kind = kind.or(is_alone.then_some(RigidBody::Static));
            let record = world.get::<PhysicsBody>(*e);
            let link = record.and_then(|record| record.world().zip(record.body()));
            let Some(kind) = kind else {
                assert!(link.is_none(), "{e} has a body but no component of one");
                continue;
            };
            // A body with a refused mass or in a lost world has none.
            let Some((of, id)) = link else { continue };
            known += 1;
            let physics = world.get::<PhysicsWorld>(of).expect("its world");
            let body = physics.world().body(id).expect("its body");
            let wanted = match kind {
                RigidBody::Dynamic => BodyKind::Dynamic,
                RigidBody::Static => BodyKind::Static,
                RigidBody::Kinematic => BodyKind::Kinematic,
            };
            assert!(body.kind() == wanted || self.is_refused(*e), "{e}: {:?}", body.kind());
            if up.len() == 1 && wanted != BodyKind::Kinematic && !self.is_refused(*e) {
                let place = world.get::<Transform>(*e).expect("a transform").translation;
                // The engine stores the center of mass: where colliders move it, the origin is
                // rounded anew, by a few last digits of coordinates below 32 m.
                let gap = drystone::Vec3::from(place.to_array()) - body.position();
                assert!(gap.length() < 8.0 * 32.0 * f32::EPSILON, "{e}: {gap:?}");
            }
        }
        assert!(known > 0 || self.all.len() < 8, "some bodies must be there");
        for e in &self.all {
            self.check_collider(*e);
        }
        for joint in &self.joints {
            let id = world.get::<bevy_drystone::PhysicsJoint>(*joint).and_then(|j| j.joint());
            let is_there = |physics: &PhysicsWorld| {
                id.is_some_and(|id| {
                    physics
                        .world()
                        .joint(id)
                        .is_some_and(|found| found.user_data() == joint.to_bits())
                })
            };
            let worlds = self.worlds.iter().copied().chain([self.game.default_world()]);
            let found = worlds.filter_map(|w| world.get::<PhysicsWorld>(w)).any(is_there);
            assert_eq!(found, id.is_some(), "a joint that is not there");
        }
    }

    /// Whether the numbers of an entity are refused: a mass below 0.
    fn is_refused(&self, e: Entity) -> bool {
        self.game.app.world().get::<Mass>(e).is_some_and(|mass| mass.0 <= 0.0)
    }

    /// A collider's shapes are on the body of its nearest ancestor with one, all or none.
    fn check_collider(&self, e: Entity) {
        let world = self.game.app.world();
        let Some(record) = world.get::<PhysicsCollider>(e) else { return };
        let Some(collider) = world.get::<Collider>(e) else {
            assert!(record.shapes().is_empty(), "{e} has shapes but no collider");
            return;
        };
        let up = self.ancestors(e);
        let has_body = |e: &&Entity| world.get::<RigidBody>(**e).is_some();
        let owner = *up.iter().find(has_body).unwrap_or(&e);
        let count = record.shapes().len();
        if count == 0 {
            let body = world.get::<PhysicsBody>(owner).and_then(PhysicsBody::body);
            let told = || {
                let kind = world.get::<RigidBody>(owner);
                let scales = up.iter().map(|e| world.get::<Transform>(*e).map(|place| place.scale));
                let scales: Vec<_> = scales.collect();
                format!(
                    "{:?}: {e} of {owner} has no shape: {collider:?} {kind:?} {scales:?} {:?}",
                    self.at,
                    self.faults.iter().rev().take(30).collect::<Vec<_>>()
                )
            };
            let is_fine = body.is_none() || self.may_be_refused(e, owner, collider);
            assert!(is_fine, "{}", told());
            return;
        }
        assert_eq!(record.body(), Some(owner), "{e} is on another body");
        assert_eq!(count, collider.shapes().count());
        let host = world.get::<PhysicsBody>(owner).expect("a record");
        let physics = world.get::<PhysicsWorld>(host.world().expect("its world")).expect("a world");
        for shape in record.shapes() {
            let shape = physics.world().shape(*shape).expect("its shape");
            assert_eq!(Some(shape.body()), host.body());
            assert_eq!(shape.user_data(), e.to_bits());
        }
    }

    /// Meshes and half-spaces do not suit every kind; frictions below 0 and scales of nearly 0 are
    /// refused.
    fn may_be_refused(&self, e: Entity, owner: Entity, collider: &Collider) -> bool {
        let world = self.game.app.world();
        let kind = world.get::<RigidBody>(owner).copied().unwrap_or(RigidBody::Static);
        let is_flat = collider
            .shapes()
            .any(|(_, shape)| matches!(shape, Shape::Mesh(_) | Shape::HalfSpace { .. }));
        let is_bad =
            |e: Entity| world.get::<Friction>(e).is_some_and(|friction| friction.coefficient < 0.0);
        let scaled = |e: &Entity| {
            world.get::<Transform>(*e).is_some_and(|place| place.scale.abs().min_element() < 0.3)
        };
        (is_flat && kind != RigidBody::Static)
            || is_bad(e)
            || is_bad(owner)
            || self.is_refused(owner)
            || self.ancestors(e).iter().any(scaled)
    }
}

fn run(seed: u64, steps: usize) {
    let mut program = Program::new(seed);
    for step in 0..steps {
        program.at = (seed, step);
        for _ in 0..program.dice.below(7) {
            program.act();
        }
        program.game.run(1);
        let faults = program.game.faults();
        program.faults.extend(faults.into_iter().map(|fault| format!("{step}: {fault}")));
        program.check();
        if program.all.len() > 60 {
            for e in program.all.split_off(30) {
                if program.game.app.world().get_entity(e).is_ok() {
                    program.game.despawn(e);
                }
            }
            let world = program.game.app.world();
            program.all.retain(|e| world.get_entity(*e).is_ok());
        }
    }
    for e in core::mem::take(&mut program.all) {
        if program.game.app.world().get_entity(e).is_ok() {
            program.game.despawn(e);
        }
    }
    program.game.run(1);
    program.game.check();
    let counts = program.game.world().counts();
    assert_eq!((counts.fixed, counts.kinematic, counts.dynamic, counts.joints), (0, 0, 0, 0));
}

#[test]
fn random_programs_leave_entities_and_world_in_agreement() {
    let steps = std::env::var("DRYSTONE_BEVY_STEPS").ok().and_then(|n| n.parse().ok());
    for seed in 0..16 {
        run(seed, steps.unwrap_or(200));
    }
}
