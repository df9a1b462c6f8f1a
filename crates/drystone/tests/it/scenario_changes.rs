//! What can be changed while it lives, whatever state it is in: awake, asleep, in contact, on joints, in a body that
//! breaks, saved right after. Masses and events are right, nothing jumps that stands, and all goes on with the same bits from a
//! snapshot and with more threads.
#![expect(clippy::float_cmp, reason = "what is told is what was set, bit by bit")]

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use drystone::breakage::{BondStrength, Fracture, Glue};
use drystone::joint::{
    Ball, CouplingDef, Distance, Hinge, JointAxis, JointDrive, JointMotion, Pulley, SixDof, Spring,
};
use drystone::journal::{Call, JointCall};
use drystone::math::Sym3;
use drystone::particle::RopeDef;
use drystone::threads::Team;
use drystone::{
    Axis, BodyDef, BodyId, BodyKind, DefError, Filter, JointDef, JointId, JointKind, JointMut,
    MassDef, Mesh, Pose, Shape, ShapeDef, ShapeId, Vec3, World, vec3,
};

use crate::floors::square;

const DT: f32 = 1.0 / 60.0;
const GRAVITY: f32 = 9.81;

/// What gravity gives in one of eight substeps: what stands may not get faster by a change [m/s].
const JOLT: f32 = GRAVITY * DT / 8.0;

/// What a stack stands on.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Floor {
    HalfSpace,
    Box,
    Mesh,
}

const FLOORS: [Floor; 3] = [Floor::HalfSpace, Floor::Box, Floor::Mesh];

/// A static floor whose top is at height 0, for things of this size [m].
fn floor(world: &mut World, floor: Floor, size: f32) -> BodyId {
    let reach = 40.0 * size;
    let shape = match floor {
        Floor::HalfSpace => ShapeDef::half_space(Vec3::Y, 0.0),
        Floor::Box => ShapeDef::box_half([reach, size, reach]).with_position([0.0, -size, 0.0]),
        Floor::Mesh => square(reach),
    };
    world.add_body(BodyDef::fixed().with_shape(shape)).unwrap()
}

/// A floor and cubes on each other.
struct Stack {
    world: World,
    floor: BodyId,
    cubes: Vec<BodyId>,
}

impl Stack {
    /// So many cubes with edges of this size [m], at rest; the kind is that of the lowest.
    fn new(under: Floor, size: f32, kind: BodyKind) -> Self {
        let mut world = World::default();
        let floor = floor(&mut world, under, size);
        let cubes = (0..5_u8).map(|i| {
            let height = (f32::from(i) + 0.5) * size;
            let kind = if i == 0 { kind } else { BodyKind::Dynamic };
            let cube = BodyDef { kind, ..BodyDef::dynamic().with_position([0.0, height, 0.0]) };
            world.add_body(cube.with_shape(ShapeDef::box_half([0.5 * size; 3]))).unwrap()
        });
        let cubes = cubes.collect();
        let mut stack = Self { world, floor, cubes };
        // Half a second of rest would be sleep.
        stack.steps(20);
        stack
    }

    fn steps(&mut self, count: u32) {
        for _ in 0..count {
            self.world.step(DT);
        }
    }

    /// Until all sleep.
    fn asleep(mut self) -> Self {
        let sleeps = |world: &World| world.counts().asleep == world.counts().dynamic;
        let mut left = 600;
        while left > 0 && !sleeps(&self.world) {
            self.world.step(DT);
            left -= 1;
        }
        assert!(sleeps(&self.world));
        self
    }

    fn places(&self) -> Vec<Vec3> {
        self.cubes.iter().map(|id| self.world.body(*id).unwrap().position()).collect()
    }

    /// Steps on, and asserts that no cube gets faster than by a substep of gravity, or leaves its place by more than `way` [m].
    fn stands(&mut self, of: &str, count: u32, way: f32) {
        self.is_no_faster(of, count, way, JOLT);
    }

    /// The same, with a greatest speed [m/s].
    fn is_no_faster(&mut self, of: &str, count: u32, way: f32, limit: f32) {
        let places = self.places();
        for step in 0..count {
            self.world.step(DT);
            for (i, id) in self.cubes.iter().enumerate() {
                let body = self.world.body(*id).unwrap();
                let speed = body.linear_velocity().length();
                assert!(speed < limit, "{of}: cube {i} moves at {speed} m/s in step {step}");
                let off = (body.position() - places[i]).length();
                assert!(off < way, "{of}: cube {i} is {off} m off in step {step}");
            }
        }
    }

    /// How fast cubes of these masses [kg] get that are put on each other anew, as their contacts take up the load [m/s]; no less
    /// than by a substep of gravity.
    fn speed_anew(under: Floor, size: f32, masses: &[f32]) -> f32 {
        let mut world = World::default();
        floor(&mut world, under, size);
        for (i, mass) in (0_u8..).zip(masses) {
            let cube = BodyDef::dynamic().with_position([0.0, (f32::from(i) + 0.5) * size, 0.0]);
            let cube = cube.with_shape(ShapeDef::box_half([0.5 * size; 3])).with_mass(*mass);
            world.add_body(cube).unwrap();
        }
        let mut greatest = JOLT;
        for _ in 0..60 {
            world.step(DT);
            let speeds = world.bodies().map(|body| body.linear_velocity().length());
            greatest = speeds.fold(greatest, f32::max);
        }
        greatest
    }
}

/// Which pairs touch, by the events.
#[derive(Clone, Default)]
struct Touches {
    contacts: BTreeSet<[ShapeId; 2]>,
    visits: BTreeMap<[ShapeId; 2], i32>,
}

impl Touches {
    /// Follows the events of a step: each end is of a touch that began, each begin of one that did not yet.
    fn follow(&mut self, world: &World, of: &str) {
        let events = world.events();
        let sorted = |a: ShapeId, b: ShapeId| [a.min(b), a.max(b)];
        for e in &events.contact_end {
            assert!(self.contacts.remove(&sorted(e.shape_a, e.shape_b)), "{of}: {e:?} never began");
        }
        for e in &events.contact_begin {
            assert!(self.contacts.insert(sorted(e.shape_a, e.shape_b)), "{of}: {e:?} began twice");
        }
        // In one step a visitor may come and go, or go by a change and come again.
        for e in &events.sensor_enter {
            *self.visits.entry([e.sensor, e.visitor]).or_default() += 1;
        }
        for e in &events.sensor_exit {
            *self.visits.entry([e.sensor, e.visitor]).or_default() -= 1;
        }
        let paired = self.visits.values().all(|count| (0..=1).contains(count));
        assert!(paired, "{of}: {:?} {:?}", events.sensor_enter, events.sensor_exit);
    }
}

/// A world in which something is to be changed.
struct Scene {
    name: &'static str,
    world: World,
    /// That something, and its first shape.
    body: BodyId,
    shape: ShapeId,
    touches: Touches,
}

impl Scene {
    fn new(name: &'static str, mut world: World, body: BodyId, steps: u32) -> Self {
        let shape = world.body(body).unwrap().shapes().next().unwrap();
        let mut touches = Touches::default();
        for _ in 0..steps {
            world.step(DT);
            touches.follow(&world, name);
        }
        Self { name, world, body, shape, touches }
    }
}

/// Cubes of 1 m on each other on a floor; the second is named.
fn stack_of_cubes(under: Floor) -> (World, BodyId) {
    let mut world = World::default();
    floor(&mut world, under, 1.0);
    let cubes = (0..4_u8).map(|i| {
        let cube = BodyDef::dynamic().with_position([0.0, f32::from(i) + 0.5, 0.0]);
        world.add_body(cube.with_shape(ShapeDef::box_half([0.5; 3]))).unwrap()
    });
    let cubes: Vec<BodyId> = cubes.collect();
    (world, cubes[1])
}

/// A ball on a chain of balls under the ceiling, that swings; the second is named.
fn chain() -> (World, BodyId) {
    let mut world = World::default();
    let ceiling = BodyDef::fixed().with_position([0.0, 6.0, 0.0]);
    let ceiling = world.add_body(ceiling.with_shape(ShapeDef::box_half([1.0, 0.2, 1.0]))).unwrap();
    let (mut last, mut named) = (ceiling, ceiling);
    for i in 1..=3_u8 {
        let at = vec3(0.6 * f32::from(i), 6.0 - 0.8 * f32::from(i), 0.0);
        let ball = BodyDef::dynamic().with_position(at).with_shape(ShapeDef::sphere(0.3));
        let ball = world.add_body(ball).unwrap();
        world
            .add_joint(
                JointDef::new(last, ball, Ball::new()).with_anchors([0.0; 3], [-0.6, 0.8, 0.0]),
            )
            .unwrap();
        last = ball;
        named = if i == 2 { ball } else { named };
    }
    (world, named)
}

/// Three cubes glued together on a floor, with a ball on them.
fn glued() -> (World, BodyId) {
    let mut world = World::default();
    floor(&mut world, Floor::Box, 1.0);
    let at = |i: u8| vec3(f32::from(i) - 1.0, 0.0, 0.0);
    let shapes: Vec<ShapeDef> =
        (0..3).map(|i| ShapeDef::box_half([0.5; 3]).with_position(at(i))).collect();
    let glue = Glue::touching(&shapes, 1.0e-3, BondStrength::both(1.0e6)).unwrap();
    let rod = BodyDef { shapes, ..BodyDef::dynamic().with_position([0.0, 0.5, 0.0]) };
    let rod = world.add_body(rod.with_glue(glue)).unwrap();
    let ball = BodyDef::dynamic().with_position([0.2, 1.3, 0.0]);
    world.add_body(ball.with_shape(ShapeDef::sphere(0.3))).unwrap();
    (world, rod)
}

/// A brittle cube on a floor, under another.
fn brittle() -> (World, BodyId) {
    let mut world = World::default();
    floor(&mut world, Floor::HalfSpace, 1.0);
    let cube = |y: f32| {
        BodyDef::dynamic().with_position([0.0, y, 0.0]).with_shape(ShapeDef::box_half([0.5; 3]))
    };
    let brittle = cube(0.5).with_fracture(Fracture::by_impulse(1.0e4).with_pieces(4));
    let brittle = world.add_body(brittle).unwrap();
    world.add_body(cube(1.5)).unwrap();
    (world, brittle)
}

/// A static step under two cubes, in a sensor.
fn step_in_sensor() -> (World, BodyId) {
    let mut world = World::default();
    floor(&mut world, Floor::HalfSpace, 1.0);
    let step = BodyDef::fixed().with_position([0.0, 0.25, 0.0]);
    let step = world.add_body(step.with_shape(ShapeDef::box_half([2.0, 0.25, 1.0]))).unwrap();
    for x in [-0.8, 0.8] {
        let cube = BodyDef::dynamic().with_position([x, 1.0, 0.0]);
        world.add_body(cube.with_shape(ShapeDef::box_half([0.5; 3]))).unwrap();
    }
    let around = ShapeDef::box_half([3.0, 3.0, 3.0]).as_sensor();
    world.add_body(BodyDef::kinematic().with_shape(around)).unwrap();
    (world, step)
}

/// A lift that goes up under a cube.
fn lift() -> (World, BodyId) {
    let mut world = World::default();
    floor(&mut world, Floor::HalfSpace, 1.0);
    let lift = BodyDef::kinematic()
        .with_position([0.0, 0.5, 0.0])
        .with_linear_velocity([0.0, 0.5, 0.0])
        .with_shape(ShapeDef::box_half([1.0, 0.2, 1.0]));
    let lift = world.add_body(lift).unwrap();
    let cube = BodyDef::dynamic().with_position([0.0, 1.2, 0.0]);
    world.add_body(cube.with_shape(ShapeDef::box_half([0.5; 3]))).unwrap();
    (world, lift)
}

/// Scenes with things in all states; those of 20 steps are awake, those of 400 asleep where anything can sleep.
fn scenes() -> Vec<Scene> {
    let mut scenes = Vec::new();
    for (under, name) in FLOORS.into_iter().zip(["half-space", "box", "mesh"]) {
        let (world, body) = stack_of_cubes(under);
        scenes.push(Scene::new(name, world, body, 20));
    }
    let (world, body) = stack_of_cubes(Floor::Box);
    scenes.push(Scene::new("asleep", world, body, 400));
    for (name, (world, body), steps) in [
        ("chain", chain(), 20),
        ("glued", glued(), 20),
        ("glued asleep", glued(), 400),
        ("brittle", brittle(), 20),
        ("step in sensor", step_in_sensor(), 20),
        ("step in sensor asleep", step_in_sensor(), 400),
        ("lift", lift(), 20),
    ] {
        scenes.push(Scene::new(name, world, body, steps));
    }
    scenes
}

/// A change; what is refused is refused for good, and changes nothing.
type Change = fn(&mut World, BodyId, ShapeId) -> Result<(), DefError>;

/// A name, and changes with a step between them.
type Changes<'a> = (&'a str, &'a [Change]);

/// Each change in each scene: tables are sound, a snapshot taken right after, or in any later step, goes on with the same bits, so do
/// three threads, and events of touches pair up.
fn in_all_states(changes: &[Changes<'_>]) {
    let team: Arc<Team> = Arc::new(Team::with_threads(3));
    for (name, changes) in changes {
        for mut scene in scenes() {
            let of = format!("{name} in {}", scene.name);
            for (i, change) in changes.iter().enumerate() {
                if i > 0 {
                    scene.world.step(DT);
                    scene.touches.follow(&scene.world, &of);
                }
                let before = scene.world.snapshot();
                if change(&mut scene.world, scene.body, scene.shape).is_err() {
                    let now = scene.world.snapshot();
                    assert!(now == before, "{of}: refused, and all the same changed");
                }
            }
            let mut world = scene.world;
            let restored = |world: &World| {
                World::restore(&world.snapshot()).map_err(|e| format!("{of}: {e}")).unwrap()
            };
            let mut twin = restored(&world);
            let mut threads = world.clone().with_executor(team.clone());
            for step in 0..100 {
                for world in [&mut world, &mut twin, &mut threads] {
                    world.step(DT);
                }
                assert_eq!(world.state_hash(), twin.state_hash(), "{of}: step {step}, restored");
                assert_eq!(world.events(), twin.events(), "{of}: step {step}, restored");
                assert_eq!(world.state_hash(), threads.state_hash(), "{of}: step {step}, threads");
                assert_eq!(world.events(), threads.events(), "{of}: step {step}, threads");
                scene.touches.follow(&world, &of);
                if step < 3 || step % 20 == 0 {
                    twin = restored(&world);
                }
            }
            let audit = world.audit();
            assert!(audit.non_finite.is_empty(), "{of}: {audit:?}");
        }
    }
}

#[test]
fn bodies_change_in_any_state() {
    in_all_states(&[
        ("static", &[|w, b, _| w.body_mut(b).unwrap().set_kind(BodyKind::Static)]),
        ("kinematic", &[|w, b, _| w.body_mut(b).unwrap().set_kind(BodyKind::Kinematic)]),
        ("dynamic", &[|w, b, _| w.body_mut(b).unwrap().set_kind(BodyKind::Dynamic)]),
        (
            "static, then dynamic",
            &[
                |w, b, _| w.body_mut(b).unwrap().set_kind(BodyKind::Static),
                |w, b, _| w.body_mut(b).unwrap().set_kind(BodyKind::Dynamic),
            ],
        ),
        (
            "static and dynamic at once",
            &[|w, b, _| {
                w.body_mut(b).unwrap().set_kind(BodyKind::Static)?;
                w.body_mut(b).unwrap().set_kind(BodyKind::Dynamic)
            }],
        ),
        ("heavy", &[|w, b, _| w.body_mut(b).unwrap().set_mass(MassDef::Mass(1.0e5))]),
        ("light", &[|w, b, _| w.body_mut(b).unwrap().set_mass(MassDef::Mass(10.0))]),
        (
            "mass given in full",
            &[|w, b, _| {
                let inertia = Sym3::diagonal(vec3(100.0, 200.0, 150.0));
                let center = vec3(0.1, -0.2, 0.0);
                w.body_mut(b).unwrap().set_mass(MassDef::Exact { mass: 500.0, center, inertia })
            }],
        ),
        (
            "disabled",
            &[|w, b, _| {
                w.body_mut(b).unwrap().set_enabled(false);
                Ok(())
            }],
        ),
        (
            "disabled and back",
            &[|w, b, _| {
                w.body_mut(b).unwrap().set_enabled(false);
                w.body_mut(b).unwrap().set_enabled(true);
                Ok(())
            }],
        ),
        (
            "disabled, of another kind",
            &[|w, b, _| {
                w.body_mut(b).unwrap().set_enabled(false);
                w.body_mut(b).unwrap().set_kind(BodyKind::Kinematic)
            }],
        ),
        (
            "put to sleep",
            &[|w, b, _| {
                w.body_mut(b).unwrap().sleep();
                Ok(())
            }],
        ),
        (
            "corrected",
            &[|w, b, _| {
                let pose = w.body(b).unwrap().pose();
                let pose = Pose { position: pose.position + Vec3::X * 0.01, ..pose };
                w.body_mut(b).unwrap().correct_state(pose, [0.1, 0.0, 0.0], [0.0; 3]).map(|_| ())
            }],
        ),
        ("sleep speed", &[|w, b, _| w.body_mut(b).unwrap().set_sleep_speed(Some(0.5))]),
    ]);
}

#[test]
fn a_static_body_made_dynamic_carries_on_what_stands_on_it() {
    for under in FLOORS {
        for size in [0.05, 1.0, 20.0] {
            for sleeps in [false, true] {
                let mut stack = Stack::new(under, size, BodyKind::Static);
                stack = if sleeps { stack.asleep() } else { stack };
                let of = format!("{under:?}, {size} m, sleeps: {sleeps}");
                let mut body = stack.world.body_mut(stack.cubes[0]).unwrap();
                body.set_kind(BodyKind::Dynamic).unwrap();
                let mass = stack.world.body(stack.cubes[0]).unwrap().mass();
                assert_eq!(mass, stack.world.body(stack.cubes[1]).unwrap().mass(), "{of}");
                assert_eq!(stack.world.counts().asleep, 0, "{of}");
                // The contact with the floor is new, and takes up the load as one of a new stack does.
                let limit = Stack::speed_anew(under, size, &[mass; 5]);
                stack.is_no_faster(&of, 60, 0.01 * size, limit);
                // It touches the floor now, and no other touch ended.
                assert!(stack.world.contacts().any(|c| c.body_a() == stack.floor), "{of}");
            }
        }
    }
}

#[test]
fn a_dynamic_body_made_static_keeps_what_leans_on_it() {
    for under in FLOORS {
        for kind in [BodyKind::Static, BodyKind::Kinematic] {
            let mut stack = Stack::new(under, 1.0, BodyKind::Dynamic);
            let id = stack.cubes[2];
            stack.world.body_mut(id).unwrap().set_kind(kind).unwrap();
            assert_eq!(stack.world.body(id).unwrap().mass(), 0.0);
            let of = format!("{under:?}, {kind:?}");
            for _ in 0..3 {
                stack.world.step(DT);
                let events = stack.world.events();
                assert!(events.contact_end.is_empty() && events.contact_begin.is_empty(), "{of}");
            }
            stack.stands(&of, 60, 0.01);
            // What was under it can go.
            assert!(stack.world.remove_body(stack.cubes[0]));
            assert!(stack.world.remove_body(stack.cubes[1]));
            stack.cubes.drain(..2);
            stack.stands(&of, 60, 0.01);
            // And it falls with the others when it is dynamic again.
            stack.world.body_mut(id).unwrap().set_kind(BodyKind::Dynamic).unwrap();
            let before = stack.places();
            stack.steps(20);
            // Half g t² of 20 steps of 8 substeps each, and a substep more.
            let fall = 0.5 * GRAVITY * (20.0 * DT) * (20.0 * DT + DT / 8.0);
            for (a, b) in before.iter().zip(stack.places()) {
                assert!((a.y - b.y - fall).abs() < 0.02, "{of}: {} m, not {fall}", a.y - b.y);
            }
        }
    }
}

#[test]
fn a_floor_disabled_under_a_sleeping_stack_lets_it_fall_and_carries_again() {
    for under in FLOORS {
        let mut stack = Stack::new(under, 1.0, BodyKind::Dynamic).asleep();
        let before = stack.places();
        stack.world.body_mut(stack.floor).unwrap().set_enabled(false);
        assert!(!stack.world.body(stack.floor).unwrap().is_enabled());
        let hit =
            stack.world.query().cast_ray([5.0, 1.0, 0.0], [0.0, -9.0, 0.0], Filter::default());
        assert_eq!(hit.unwrap(), None);
        stack.world.step(DT);
        let events = stack.world.events();
        assert_eq!(events.wake, stack.cubes);
        assert_eq!(events.contact_end.len(), 1, "{under:?}");
        stack.steps(19);
        let fall = 0.5 * GRAVITY * (20.0 * DT) * (20.0 * DT + DT / 8.0);
        for (a, b) in before.iter().zip(stack.places()) {
            assert!((a.y - b.y - fall).abs() < 0.02, "{under:?}: {} m, not {fall}", a.y - b.y);
        }
        let low = stack.places()[0].y;
        for id in &stack.cubes {
            let pose = stack.world.body(*id).unwrap().pose();
            let pose = Pose { position: pose.position + Vec3::Y * (0.5 - low), ..pose };
            let mut body = stack.world.body_mut(*id).unwrap();
            body.correct_state(pose, [0.0; 3], [0.0; 3]).unwrap();
        }
        stack.world.body_mut(stack.floor).unwrap().set_enabled(true);
        stack.steps(3);
        stack.stands("enabled again", 60, 0.01);
    }
}

#[test]
fn what_is_disabled_stays_as_it_is_and_goes_on_when_it_is_enabled() {
    let mut world = World::default();
    let ball = BodyDef::dynamic()
        .with_position([0.0, 5.0, 0.0])
        .with_linear_velocity([2.0, 1.0, 0.0])
        .with_shape(ShapeDef::sphere(0.5));
    let ball = world.add_body(ball).unwrap();
    let wall = BodyDef::dynamic().with_position([0.0, 5.0, 0.0]);
    world.set_gravity([0.0; 3]);
    world.step(DT);
    let (pose, energy) = (world.body(ball).unwrap().pose(), world.kinetic_energy());
    world.body_mut(ball).unwrap().set_enabled(false);
    assert_eq!(world.kinetic_energy(), 0.0);
    assert_eq!(world.audit().momentum.mass, 0.0);
    // Something else may stand in its place meanwhile.
    let wall = world.add_body(wall.with_shape(ShapeDef::box_half([1.0; 3]))).unwrap();
    for _ in 0..30 {
        world.step(DT);
        assert!(world.events().contact_begin.is_empty() && world.events().wake.is_empty());
    }
    let body = world.body(ball).unwrap();
    assert_eq!((body.pose(), body.linear_velocity()), (pose, vec3(2.0, 1.0, 0.0)));
    assert!(!body.is_asleep() && !body.is_enabled() && !body.is_faulted());
    assert_eq!(world.body(wall).unwrap().linear_velocity(), Vec3::ZERO);
    // Forces are for what is in the world.
    world.body_mut(ball).unwrap().apply_impulse([1.0, 0.0, 0.0]);
    assert!(world.remove_body(wall));
    world.body_mut(ball).unwrap().set_enabled(true);
    assert_eq!(world.kinetic_energy(), energy);
    world.step(DT);
    assert!(world.events().wake.is_empty());
    let way = world.body(ball).unwrap().position() - pose.position;
    assert!((way - vec3(2.0, 1.0, 0.0) * DT).length() < 1.0e-5, "{way:?}");
}

#[test]
fn joints_of_what_is_disabled_are_idle_until_it_is_enabled() {
    let (mut world, middle) = chain();
    let bodies: Vec<BodyId> = world.bodies().map(|b| b.id()).collect();
    let (first, last) = (bodies[1], bodies[3]);
    for _ in 0..30 {
        world.step(DT);
    }
    world.body_mut(middle).unwrap().set_enabled(false);
    let place = world.body(last).unwrap().position();
    for _ in 0..20 {
        world.step(DT);
    }
    // The lowest falls freely, the first still hangs.
    let fallen = place.y - world.body(last).unwrap().position().y;
    let start = world.body(last).unwrap().linear_velocity().y;
    assert!(fallen > 0.3 && start < -GRAVITY * 18.0 * DT, "{fallen} m, {start} m/s");
    let held = |world: &World, of: BodyId| {
        let errors = world.joints().filter(|j| j.body_b() == of).map(|j| j.error());
        errors.fold(0.0, f32::max)
    };
    assert!(held(&world, first) < 0.01);
    world.body_mut(middle).unwrap().set_enabled(true);
    for _ in 0..300 {
        world.step(DT);
    }
    assert!([first, middle, last].iter().all(|id| held(&world, *id) < 0.01));
}

#[test]
fn ropes_fall_from_what_is_disabled_and_are_held_again() {
    for kind in [BodyKind::Static, BodyKind::Kinematic] {
        let mut world = World::default();
        floor(&mut world, Floor::Box, 1.0);
        let post = BodyDef { kind, ..BodyDef::default() }.with_position([0.0, 5.0, 0.0]);
        let post = world.add_body(post.with_shape(ShapeDef::sphere(0.1))).unwrap();
        let rope = world.add_rope(RopeDef::between([0.0, 5.0, 0.0], [0.0, 3.0, 0.0], 4)).unwrap();
        let top = rope.particles[0];
        assert!(world.particle_mut(top).expect("there").attach(post, [0.0; 3]).is_ok());
        let height = |world: &World| world.particle(top).unwrap().position().y;
        // Until it sleeps, whatever is next.
        let rest = |world: &mut World| (0..600).for_each(|_| world.step(DT));
        rest(&mut world);
        assert!(height(&world) > 4.9, "{kind:?}");
        world.body_mut(post).unwrap().set_enabled(false);
        rest(&mut world);
        assert!(height(&world) < 0.5, "{kind:?}: {} m", height(&world));
        assert!(world.particle(top).unwrap().is_asleep());
        world.body_mut(post).unwrap().set_enabled(true);
        rest(&mut world);
        assert!(height(&world) > 4.9, "{kind:?}: {} m", height(&world));
    }
}

#[test]
fn what_is_put_to_sleep_by_hand_sleeps_in_the_air_until_it_is_woken() {
    let mut world = World::default();
    let ball =
        |y: f32| BodyDef::dynamic().with_position([0.0, y, 0.0]).with_shape(ShapeDef::sphere(0.5));
    let (a, b) = (world.add_body(ball(5.0)).unwrap(), world.add_body(ball(9.0)).unwrap());
    for _ in 0..10 {
        world.step(DT);
    }
    world.body_mut(a).unwrap().set_can_sleep(false);
    world.body_mut(a).unwrap().sleep();
    let place = world.body(a).unwrap().position();
    assert!(world.body(a).unwrap().is_asleep());
    assert_eq!(world.body(a).unwrap().linear_velocity(), Vec3::ZERO);
    world.step(DT);
    assert_eq!(world.events().sleep, [a]);
    // In turn, and what comes of it is what is told.
    world.body_mut(a).unwrap().wake();
    world.body_mut(a).unwrap().sleep();
    world.step(DT);
    assert!(world.events().sleep.is_empty() && world.events().wake.is_empty());
    let mut woken = None;
    for step in 0..120 {
        assert!(woken.is_some() || world.body(a).unwrap().position() == place);
        world.step(DT);
        if world.events().wake == [a] {
            woken = woken.or(Some(step));
        }
    }
    // The other one is 3 m above, and falls already.
    assert!(woken.is_some_and(|step| step > 20 && step < 60), "{woken:?}");
    assert!(world.body(b).unwrap().position().y < 5.0);
}

#[test]
fn sleep_by_hand_is_that_of_all_that_is_connected_and_of_nothing_else() {
    let mut stack = Stack::new(Floor::Box, 1.0, BodyKind::Dynamic);
    let far = BodyDef::dynamic().with_position([8.0, 0.5, 0.0]);
    let far = stack.world.add_body(far.with_shape(ShapeDef::box_half([0.5; 3]))).unwrap();
    stack.steps(5);
    stack.world.body_mut(stack.cubes[3]).unwrap().sleep();
    stack.world.step(DT);
    let cubes: BTreeSet<BodyId> = stack.cubes.iter().copied().collect();
    let asleep = stack.world.bodies().filter(|b| b.is_asleep()).map(|b| b.id());
    assert_eq!(asleep.collect::<BTreeSet<_>>(), cubes);
    assert_eq!(stack.world.events().sleep.iter().copied().collect::<BTreeSet<_>>(), cubes);
    assert!(!stack.world.body(far).unwrap().is_asleep());
    stack.stands("asleep by hand", 10, 1.0e-6);
    stack.world.body_mut(stack.cubes[0]).unwrap().wake();
    stack.stands("woken", 30, 0.01);
}

#[test]
fn masses_change_under_load_and_come_back() {
    // What is much heavier is below, as stacks of which it is above sag by their solver.
    let all = [0.1, 10.0].into_iter().flat_map(|factor| [0, 2, 4].map(|cube| (factor, cube)));
    for (factor, cube) in all.chain([(1.0e3, 0), (1.0e-3, 4)]) {
        for under in FLOORS {
            let mut stack = Stack::new(under, 1.0, BodyKind::Dynamic);
            let id = stack.cubes[cube];
            let before = stack.world.body(id).unwrap();
            let (mass, inertia) = (before.mass(), before.inertia());
            let mut body = stack.world.body_mut(id).unwrap();
            body.set_mass(MassDef::Mass(factor * mass)).unwrap();
            let now = body.get();
            assert_eq!(now.mass(), factor * mass);
            let ratio = now.inertia().xx / inertia.xx;
            assert!((ratio / factor - 1.0).abs() < 1.0e-5, "{ratio}");
            let of = format!("{factor} times cube {cube} on {under:?}");
            let mut masses = [mass; 5];
            masses[cube] *= factor;
            let limit = Stack::speed_anew(under, 1.0, &masses);
            stack.is_no_faster(&of, 60, 0.05, limit);
            let mut body = stack.world.body_mut(id).unwrap();
            body.set_mass(MassDef::FromShapes).unwrap();
            assert_eq!(body.get().mass(), mass);
            assert_eq!(body.get().mass_def(), MassDef::FromShapes);
            stack.is_no_faster(&of, 60, 0.05, limit);
        }
    }
}

#[test]
fn a_mass_given_in_full_survives_other_kinds_and_keeps_the_motion_of_every_point() {
    let mut world = World::default();
    world.set_gravity([0.0; 3]);
    let rod = BodyDef::dynamic()
        .with_linear_velocity([1.0, 0.0, 0.0])
        .with_angular_velocity([0.0, 0.0, 2.0])
        .with_shape(ShapeDef::box_half([1.0, 0.1, 0.1]));
    let rod = world.add_body(rod).unwrap();
    let tip = world.body(rod).unwrap().velocity_at([1.0, 0.0, 0.0]);
    let inertia = Sym3::diagonal(vec3(1.0, 2.0, 3.0));
    let exact = MassDef::Exact { mass: 7.0, center: vec3(0.5, 0.0, 0.0), inertia };
    world.body_mut(rod).unwrap().set_mass(exact).unwrap();
    let body = world.body(rod).unwrap();
    assert!((body.velocity_at([1.0, 0.0, 0.0]) - tip).length() < 1.0e-6);
    assert_eq!((body.mass(), body.position()), (7.0, Vec3::ZERO));
    assert_eq!(body.center_of_mass(), vec3(0.5, 0.0, 0.0));
    let moments = body.inertia();
    for kind in [BodyKind::Static, BodyKind::Kinematic, BodyKind::Dynamic] {
        world.body_mut(rod).unwrap().set_kind(kind).unwrap();
        assert_eq!(world.body(rod).unwrap().mass_def(), exact);
        world = World::restore(&world.snapshot()).unwrap();
    }
    assert_eq!(
        (world.body(rod).unwrap().mass(), world.body(rod).unwrap().inertia()),
        (7.0, moments)
    );
}

#[test]
fn a_correction_that_changes_nothing_wakes_nothing() {
    let mut stack = Stack::new(Floor::Box, 1.0, BodyKind::Dynamic).asleep();
    let (hash, bytes) = (stack.world.state_hash(), stack.world.snapshot());
    let states = |world: &World| -> Vec<_> {
        let all = world.bodies();
        all.map(|b| (b.id(), b.pose(), b.linear_velocity(), b.angular_velocity())).collect()
    };
    for (id, pose, v, w) in states(&stack.world) {
        let mut body = stack.world.body_mut(id).unwrap();
        assert!(!body.correct_state(pose, v, w).unwrap());
    }
    assert!(stack.world.snapshot() == bytes);
    stack.world.step(DT);
    assert_eq!(stack.world.state_hash(), hash);
    // Awake and flying, the same.
    let mut body = stack.world.body_mut(stack.cubes[4]).unwrap();
    body.apply_impulse([3000.0, 5000.0, 0.0]);
    body.apply_angular_impulse([100.0, 50.0, 20.0]);
    stack.steps(10);
    let mut twin = stack.world.clone();
    for (id, pose, v, w) in states(&stack.world) {
        assert!(!twin.body_mut(id).unwrap().correct_state(pose, v, w).unwrap());
    }
    twin.step(DT);
    stack.world.step(DT);
    assert_eq!(twin.state_hash(), stack.world.state_hash());
    // A difference is taken, and wakes.
    let mut stack = Stack::new(Floor::Box, 1.0, BodyKind::Dynamic).asleep();
    let (id, pose, v, w) = states(&stack.world)[5];
    let pose = Pose { position: pose.position + Vec3::Y * 1.0e-3, ..pose };
    assert!(stack.world.body_mut(id).unwrap().correct_state(pose, v, w).unwrap());
    assert_eq!(stack.world.counts().asleep, 0);
    assert_eq!(stack.world.body(id).unwrap().pose(), pose);
}

#[test]
fn what_breaks_breaks_only_while_it_is_dynamic() {
    let strike = |world: &mut World, at: [f32; 3], velocity: [f32; 3]| {
        let rock = BodyDef::dynamic().with_position(at).with_linear_velocity(velocity);
        let rock = rock.with_shape(ShapeDef::sphere(0.5).with_density(2.0e4));
        let rock = world.add_body(rock).unwrap();
        let mut pieces = 0;
        for _ in 0..30 {
            world.step(DT);
            pieces += world.events().pieces.len();
        }
        world.remove_body(rock);
        pieces
    };
    for (scene, at, velocity) in [
        (glued as fn() -> (World, BodyId), [1.2, 4.0, 0.0], [0.0, -60.0, 0.0]),
        (brittle, [4.0, 0.6, 0.0], [-60.0, 0.0, 0.0]),
    ] {
        let (mut world, body) = scene();
        for _ in 0..40 {
            world.step(DT);
        }
        for kind in [BodyKind::Static, BodyKind::Kinematic] {
            world.body_mut(body).unwrap().set_kind(kind).unwrap();
            assert_eq!(strike(&mut world, at, velocity), 0, "{kind:?}");
            world = World::restore(&world.snapshot()).unwrap();
        }
        world.body_mut(body).unwrap().set_kind(BodyKind::Dynamic).unwrap();
        if world.body(body).unwrap().fracture().is_some() {
            // What is out of the world brings no pieces into it.
            world.body_mut(body).unwrap().set_enabled(false);
            let refused =
                world.body_mut(body).expect("there").break_at(at, &Fracture::by_impulse(1.0));
            assert_eq!(refused.unwrap_err().field(), "body");
            world.body_mut(body).unwrap().set_enabled(true);
        }
        assert!(strike(&mut world, at, velocity) > 0, "{at:?}");
    }
}

#[test]
fn joints_between_what_cannot_move_are_idle_until_something_can() {
    let (mut world, middle) = chain();
    let bodies: Vec<BodyId> = world.bodies().map(|b| b.id()).collect();
    for _ in 0..30 {
        world.step(DT);
    }
    for id in &bodies[1..] {
        world.body_mut(*id).unwrap().set_kind(BodyKind::Static).unwrap();
    }
    let hash = world.state_hash();
    for _ in 0..10 {
        world.step(DT);
    }
    assert_eq!(world.state_hash(), hash);
    world = World::restore(&world.snapshot()).unwrap();
    for id in &bodies[1..] {
        world.body_mut(*id).unwrap().set_kind(BodyKind::Dynamic).unwrap();
    }
    for _ in 0..100 {
        world.step(DT);
    }
    assert_ne!(world.state_hash(), hash);
    assert!(world.joints().all(|joint| joint.error() < 0.01));
    assert_eq!(world.body(middle).unwrap().joints().count(), 2);
}

#[test]
fn what_no_body_can_be_is_refused_by_name() {
    let mut world = World::default();
    let ground = floor(&mut world, Floor::HalfSpace, 1.0);
    let hills = floor(&mut world, Floor::Mesh, 1.0);
    let empty = world.add_body(BodyDef::fixed()).unwrap();
    let cube = world.add_body(BodyDef::dynamic().with_shape(ShapeDef::box_half([0.5; 3]))).unwrap();
    let before = world.snapshot();
    let field = |result: Result<(), DefError>| result.unwrap_err().field().to_owned();
    let mut kind = |id: BodyId, kind: BodyKind| field(world.body_mut(id).unwrap().set_kind(kind));
    assert_eq!(kind(ground, BodyKind::Kinematic), "shape");
    assert_eq!(kind(ground, BodyKind::Dynamic), "shape");
    assert_eq!(kind(hills, BodyKind::Dynamic), "shape");
    assert_eq!(kind(empty, BodyKind::Dynamic), "mass");
    let mut body = world.body_mut(cube).unwrap();
    assert_eq!(field(body.set_mass(MassDef::Mass(-1.0))), "mass");
    assert_eq!(field(body.set_mass(MassDef::Mass(f32::NAN))), "mass");
    assert_eq!(field(body.set_sleep_speed(Some(-1.0))), "sleep_speed");
    let pose = Pose::at([f32::NAN, 0.0, 0.0]);
    let corrected = body.correct_state(pose, [0.0; 3], [0.0; 3]).map(|_| ());
    assert_eq!(field(corrected), "position");
    let corrected = body.correct_state(Pose::IDENTITY, [0.0; 3], [f32::INFINITY; 3]).map(|_| ());
    assert_eq!(field(corrected), "angular_velocity");
    assert!(world.snapshot() == before);
    world.body_mut(hills).unwrap().set_kind(BodyKind::Kinematic).unwrap();
}

#[test]
fn shapes_meet_others_in_any_state() {
    in_all_states(&[
        (
            "meets nothing",
            &[|w, _, s| {
                w.shape_mut(s).unwrap().set_filter(Filter {
                    layers: 1,
                    mask: 0,
                    ..Filter::default()
                });
                Ok(())
            }],
        ),
        (
            "meets nothing and all again",
            &[|w, _, s| {
                w.shape_mut(s).unwrap().set_filter(Filter {
                    layers: 1,
                    mask: 0,
                    ..Filter::default()
                });
                w.shape_mut(s).unwrap().set_filter(Filter::default());
                Ok(())
            }],
        ),
        ("sensor", &[|w, _, s| w.shape_mut(s).unwrap().set_sensor(true)]),
        (
            "sensor and back",
            &[
                |w, _, s| w.shape_mut(s).unwrap().set_sensor(true),
                |w, _, s| w.shape_mut(s).unwrap().set_sensor(false),
            ],
        ),
    ]);
}

#[test]
fn shapes_get_another_mass_place_and_form_in_any_state() {
    in_all_states(&[
        ("light", &[|w, _, s| w.shape_mut(s).unwrap().set_density(30.0)]),
        ("heavy", &[|w, _, s| w.shape_mut(s).unwrap().set_density(3.0e4)]),
        ("without density", &[|w, _, s| w.shape_mut(s).unwrap().set_density(0.0)]),
        ("moved", &[|w, _, s| w.shape_mut(s).unwrap().set_local_pose(Pose::at([0.3, 0.1, 0.0]))]),
        (
            "moved far",
            &[|w, _, s| w.shape_mut(s).unwrap().set_local_pose(Pose::at([9.0, 0.0, 0.0]))],
        ),
        ("ball", &[|w, _, s| w.shape_mut(s).unwrap().set_geometry(Shape::sphere(0.5))]),
        ("small", &[|w, _, s| w.shape_mut(s).unwrap().set_geometry(Shape::box_half([0.2; 3]))]),
        ("large", &[|w, _, s| w.shape_mut(s).unwrap().set_geometry(Shape::box_half([0.6; 3]))]),
        (
            "half-space",
            &[|w, _, s| w.shape_mut(s).unwrap().set_geometry(Shape::half_space(Vec3::Y, 0.25))],
        ),
        (
            "mesh and back",
            &[
                |w, _, s| {
                    let corners = vec![
                        [-2.0, 0.2, -2.0],
                        [-2.0, 0.2, 2.0],
                        [2.0, 0.3, 2.0],
                        [2.0, 0.3, -2.0],
                    ];
                    let corners = corners.into_iter().map(Vec3::from).collect();
                    let mesh = Mesh::new(corners, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
                    w.shape_mut(s).unwrap().set_geometry(Shape::Mesh(Arc::new(mesh)))
                },
                |w, _, s| w.shape_mut(s).unwrap().set_geometry(Shape::cylinder(0.3, 1.0)),
            ],
        ),
        (
            "disabled",
            &[|w, _, s| {
                w.shape_mut(s).unwrap().set_enabled(false);
                Ok(())
            }],
        ),
        (
            "disabled and back",
            &[
                |w, _, s| {
                    w.shape_mut(s).unwrap().set_enabled(false);
                    Ok(())
                },
                |w, _, s| {
                    w.shape_mut(s).unwrap().set_enabled(true);
                    Ok(())
                },
            ],
        ),
        (
            "disabled, with its body",
            &[
                |w, b, s| {
                    w.shape_mut(s).unwrap().set_enabled(false);
                    w.body_mut(b).unwrap().set_enabled(false);
                    Ok(())
                },
                |w, _, s| w.shape_mut(s).unwrap().set_geometry(Shape::box_half([0.4; 3])),
                |w, b, _| {
                    w.body_mut(b).unwrap().set_enabled(true);
                    Ok(())
                },
            ],
        ),
        (
            "disabled, of a body of another kind",
            &[
                |w, b, s| {
                    w.shape_mut(s).unwrap().set_enabled(false);
                    let kind = w.body(b).unwrap().kind();
                    let other =
                        if kind == BodyKind::Static { BodyKind::Dynamic } else { BodyKind::Static };
                    w.body_mut(b).unwrap().set_kind(other)
                },
                |w, _, s| {
                    w.shape_mut(s).unwrap().set_enabled(true);
                    Ok(())
                },
            ],
        ),
        (
            "more and fewer shapes",
            &[|w, b, s| {
                w.add_shape(b, ShapeDef::sphere(0.3).with_position([0.9, 0.0, 0.0]))?;
                w.remove_shape(s);
                Ok(())
            }],
        ),
        (
            "user data",
            &[|w, _, s| {
                w.shape_mut(s).unwrap().set_user_data(7);
                assert_eq!(w.shape(s).unwrap().user_data(), 7);
                Ok(())
            }],
        ),
    ]);
}

/// The first shape of a body.
fn shape_of(world: &World, body: BodyId) -> ShapeId {
    world.body(body).unwrap().shapes().next().unwrap()
}

#[test]
fn a_shape_given_the_form_and_place_it_has_ends_no_touch_and_moves_nothing() {
    for under in FLOORS {
        for cube in [0, 2] {
            for sleeps in [false, true] {
                let mut stack = Stack::new(under, 1.0, BodyKind::Dynamic);
                stack = if sleeps { stack.asleep() } else { stack };
                let shape = shape_of(&stack.world, stack.cubes[cube]);
                let mut shape = stack.world.shape_mut(shape).unwrap();
                shape.set_geometry(Shape::box_half([0.5; 3])).unwrap();
                shape.set_local_pose(Pose::IDENTITY).unwrap();
                shape.set_density(1000.0).unwrap();
                for _ in 0..3 {
                    stack.world.step(DT);
                    let events = stack.world.events();
                    let touches = (&events.contact_begin, &events.contact_end);
                    assert_eq!(touches, (&vec![], &vec![]), "{under:?}, cube {cube}");
                }
                stack.stands(&format!("{under:?}, cube {cube}, sleeps: {sleeps}"), 40, 0.01);
            }
        }
    }
}

#[test]
fn densities_and_filters_that_come_back_move_nothing_that_stands() {
    for under in FLOORS {
        let mut stack = Stack::new(under, 1.0, BodyKind::Dynamic);
        let mut masses = [1000.0; 5];
        for (cube, density) in [(1, 100.0), (3, 5000.0)] {
            let shape = shape_of(&stack.world, stack.cubes[cube]);
            let before = stack.world.body(stack.cubes[cube]).unwrap().mass();
            stack.world.shape_mut(shape).unwrap().set_density(density).unwrap();
            let now = stack.world.body(stack.cubes[cube]).unwrap().mass();
            assert!((now / before - density / 1000.0).abs() < 1.0e-5, "{now} kg");
            masses[cube] = now;
            let limit = Stack::speed_anew(under, 1.0, &masses);
            let of = format!("{under:?}, cube {cube} of {density} kg/m³");
            stack.is_no_faster(&of, 40, 0.02, limit);
        }
        let shape = shape_of(&stack.world, stack.floor);
        let nothing = Filter { layers: 1, mask: 0, ..Filter::default() };
        stack.world.shape_mut(shape).unwrap().set_filter(nothing);
        assert_eq!(stack.world.shape(shape).unwrap().filter(), nothing);
        stack.world.shape_mut(shape).unwrap().set_filter(Filter::default());
        stack.stands(&format!("{under:?}, filter"), 40, 0.02);
    }
}

#[test]
fn a_density_moves_the_center_of_mass_and_no_shape() {
    let mut world = World::default();
    world.set_gravity([0.0; 3]);
    let part = |x: f32| ShapeDef::box_half([0.5; 3]).with_position([x, 0.0, 0.0]);
    let dumbbell = BodyDef::dynamic()
        .with_position([3.0, 4.0, 5.0])
        .with_angular_velocity([0.0, 0.0, 3.0])
        .with_shape(part(-1.0))
        .with_shape(part(1.0));
    let dumbbell = world.add_body(dumbbell).unwrap();
    let shapes: Vec<ShapeId> = world.body(dumbbell).unwrap().shapes().collect();
    let places = |world: &World| -> Vec<Vec3> {
        shapes.iter().map(|s| world.shape(*s).unwrap().pose().position).collect()
    };
    let before = places(&world);
    let tip = world.body(dumbbell).unwrap().velocity_at([5.0, 4.0, 5.0]);
    world.shape_mut(shapes[1]).unwrap().set_density(3000.0).unwrap();
    let body = world.body(dumbbell).unwrap();
    assert_eq!(body.mass(), 4000.0);
    assert!((body.center_of_mass() - vec3(3.5, 4.0, 5.0)).length() < 1.0e-6);
    assert!((body.velocity_at([5.0, 4.0, 5.0]) - tip).length() < 1.0e-5);
    // Two cubes of 1 and 3 t, 1.5 and 0.5 m from the center.
    let across = 4000.0 / 6.0 + 1000.0 * 2.25 + 3000.0 * 0.25;
    assert!((body.inertia().zz / across - 1.0).abs() < 1.0e-5);
    for (a, b) in before.iter().zip(places(&world)) {
        assert!((*a - b).length() < 1.0e-6);
    }
}

#[test]
fn what_carries_no_longer_lets_fall_what_sleeps_on_it() {
    type Let = fn(&mut World, ShapeId);
    let ways: [(&str, Let); 5] = [
        ("filter", |w, s| {
            let nothing = Filter { layers: 1, mask: 0, ..Filter::default() };
            w.shape_mut(s).unwrap().set_filter(nothing);
        }),
        ("sensor", |w, s| w.shape_mut(s).unwrap().set_sensor(true).unwrap()),
        ("disabled", |w, s| w.shape_mut(s).unwrap().set_enabled(false)),
        ("moved", |w, s| {
            w.shape_mut(s).unwrap().set_local_pose(Pose::at([0.0, -20.0, 0.0])).unwrap();
        }),
        ("another form", |w, s| {
            w.shape_mut(s).unwrap().set_geometry(Shape::half_space(Vec3::Y, -20.0)).unwrap();
        }),
    ];
    for under in FLOORS {
        for (name, way) in ways {
            let mut stack = Stack::new(under, 1.0, BodyKind::Dynamic).asleep();
            let before = stack.places();
            let shape = shape_of(&stack.world, stack.floor);
            way(&mut stack.world, shape);
            let of = format!("{under:?}, {name}");
            let (mut ends, mut entered) = (0, 0);
            for _ in 0..20 {
                stack.world.step(DT);
                ends += stack.world.events().contact_end.len();
                entered += stack.world.events().sensor_enter.len();
            }
            assert_eq!((ends, entered), (1, usize::from(name == "sensor")), "{of}");
            let fall = 0.5 * GRAVITY * (20.0 * DT) * (20.0 * DT + DT / 8.0);
            for (a, b) in before.iter().zip(stack.places()) {
                assert!((a.y - b.y - fall).abs() < 0.02, "{of}: {} m, not {fall}", a.y - b.y);
            }
        }
    }
}

#[test]
fn a_sensor_that_is_moved_sees_what_sleeps_where_it_comes_to() {
    for kind in [BodyKind::Static, BodyKind::Kinematic] {
        let mut stack = Stack::new(Floor::Box, 1.0, BodyKind::Dynamic).asleep();
        let gate = BodyDef { kind, ..BodyDef::default() }.with_position([20.0, 2.0, 0.0]);
        let gate = gate.with_shape(ShapeDef::box_half([1.0, 0.2, 1.0]).as_sensor());
        let gate = stack.world.add_body(gate).unwrap();
        let shape = shape_of(&stack.world, gate);
        stack.steps(2);
        assert!(stack.world.events().sensor_enter.is_empty());
        let mut moved = stack.world.shape_mut(shape).unwrap();
        moved.set_local_pose(Pose::at([-20.0, 0.4, 0.0])).unwrap();
        stack.world.step(DT);
        let seen: Vec<BodyId> =
            stack.world.events().sensor_enter.iter().map(|e| e.visitor_body).collect();
        assert_eq!(seen, [stack.cubes[2]], "{kind:?}");
        let mut moved = stack.world.shape_mut(shape).unwrap();
        moved.set_geometry(Shape::box_half([1.0, 1.2, 1.0])).unwrap();
        stack.world.step(DT);
        assert_eq!(stack.world.events().sensor_enter.len(), 2, "{kind:?}");
        stack.world.shape_mut(shape).unwrap().set_enabled(false);
        stack.world.step(DT);
        assert_eq!(stack.world.events().sensor_exit.len(), 3, "{kind:?}");
    }
}

#[test]
fn what_is_disabled_is_found_by_no_query_and_stops_nothing_fast() {
    for bullet_is_out in [false, true] {
        let mut world = World::default();
        world.set_gravity([0.0; 3]);
        let wall = BodyDef::fixed().with_position([5.0, 0.0, 0.0]);
        let wall = world.add_body(wall.with_shape(ShapeDef::box_half([0.05, 2.0, 2.0]))).unwrap();
        let bullet = BodyDef::dynamic().with_linear_velocity([400.0, 0.0, 0.0]);
        let bullet = world.add_body(bullet.with_shape(ShapeDef::box_half([0.1; 3]))).unwrap();
        let out = shape_of(&world, if bullet_is_out { bullet } else { wall });
        let mass = world.body(bullet).unwrap().mass();
        world.shape_mut(out).unwrap().set_enabled(false);
        assert!(!world.shape(out).unwrap().is_enabled());
        assert_eq!(world.body(bullet).unwrap().mass(), mass);
        let query = world.query();
        let from = if bullet_is_out { vec3(-1.0, 0.0, 0.0) } else { vec3(4.0, 0.0, 0.0) };
        assert_eq!(query.cast_ray(from, Vec3::X * 2.0, Filter::default()).unwrap(), None);
        assert!(query.overlap_point(from + Vec3::X, Filter::default()).unwrap().is_empty());
        for _ in 0..3 {
            world.step(DT);
            assert!(world.events().contact_begin.is_empty());
        }
        let way = world.body(bullet).unwrap().position().x;
        assert!((way - 20.0).abs() < 1.0e-3, "{way} m");
        world.shape_mut(out).unwrap().set_enabled(true);
        let hit = world.query().cast_ray([20.0, 0.0, -3.0], [0.0, 0.0, 6.0], Filter::default());
        assert_eq!(hit.unwrap().map(|hit| hit.body), Some(bullet));
    }
}

#[test]
fn what_no_shape_can_be_is_refused_by_name() {
    let field = |result: Result<(), DefError>| result.unwrap_err().field().to_owned();
    let mut world = World::default();
    let cube = world.add_body(BodyDef::dynamic().with_shape(ShapeDef::box_half([0.5; 3]))).unwrap();
    let cube = shape_of(&world, cube);
    let before = world.snapshot();
    let mut shape = world.shape_mut(cube).unwrap();
    assert_eq!(field(shape.set_density(-1.0)), "density");
    assert_eq!(field(shape.set_density(f32::NAN)), "density");
    assert_eq!(field(shape.set_density(0.0)), "mass");
    assert_eq!(field(shape.set_local_pose(Pose::at([f32::INFINITY; 3]))), "pose.position");
    assert_eq!(field(shape.set_geometry(Shape::sphere(-1.0))), "radius");
    assert_eq!(field(shape.set_geometry(Shape::half_space(Vec3::Y, 0.0))), "shape");
    assert_eq!(field(shape.set_geometry(Shape::sphere(1.0e-12))), "radius");
    assert!(world.snapshot() == before);
    let (mut world, body) = glued();
    let piece = shape_of(&world, body);
    let before = world.snapshot();
    let mut shape = world.shape_mut(piece).unwrap();
    assert_eq!(field(shape.set_geometry(Shape::sphere(0.5))), "shape");
    assert_eq!(field(shape.set_local_pose(Pose::IDENTITY)), "shape");
    assert_eq!(field(shape.set_density(0.0)), "density");
    assert!(world.snapshot() == before);
    world.shape_mut(piece).unwrap().set_density(2000.0).unwrap();
    let (mut world, body) = brittle();
    let whole = shape_of(&world, body);
    let mut shape = world.shape_mut(whole).unwrap();
    assert_eq!(field(shape.set_geometry(Shape::sphere(0.5))), "shape");
    shape.set_geometry(Shape::box_half([0.4, 0.5, 0.4])).unwrap();
}

/// One joint of each kind and a gear, all of things that hang from a beam.
struct Machine {
    world: World,
    beam: BodyId,
    ball: JointId,
    rope: JointId,
    hinges: [JointId; 2],
    gear: JointId,
    pulley: JointId,
}

impl Machine {
    fn new() -> Self {
        let mut world = World::default();
        let beam = BodyDef::fixed().with_position([0.0, 10.0, 0.0]);
        let beam = world.add_body(beam.with_shape(ShapeDef::box_half([9.0, 0.1, 0.1]))).unwrap();
        let weight = |world: &mut World, x: f32| {
            let cube = BodyDef::dynamic().with_position([x, 8.0, 0.0]);
            world.add_body(cube.with_shape(ShapeDef::box_half([0.3; 3]))).unwrap()
        };
        let a = weight(&mut world, -8.0);
        let ball =
            JointDef::new(beam, a, Ball::new()).with_anchors([-8.0, -0.5, 0.0], [0.0, 1.5, 0.0]);
        let ball = world.add_joint(ball).unwrap();
        let b = weight(&mut world, -5.0);
        let rope = JointDef::new(beam, b, Distance::exact(1.7))
            .with_anchors([-5.0, 0.0, 0.0], [0.0, 0.3, 0.0]);
        let kind = JointKind::Distance { min: 0.0, max: 1.7, spring: None };
        let rope = world.add_joint(JointDef { kind, user_data: 5, ..rope }).unwrap();
        let hinges = [-2.0, 0.0].map(|x| {
            let arm = weight(&mut world, x);
            let axes = Hinge::new().six_dof();
            let def = JointDef::new(beam, arm, axes).at([x, 9.5, 0.0]).with_axis(Vec3::Z);
            world.add_joint(def).unwrap()
        });
        let gear = world.add_coupling(CouplingDef::gear(hinges[0], hinges[1], 1.0)).unwrap();
        let (c, d) = (weight(&mut world, 3.0), weight(&mut world, 6.0));
        let over = Pulley::rope([vec3(3.0, 9.5, 0.0), vec3(6.0, 9.5, 0.0)], 2.4);
        let top = [0.0, 0.3, 0.0];
        let pulley = world.add_joint(JointDef::new(c, d, over).with_anchors(top, top)).unwrap();
        for _ in 0..20 {
            world.step(DT);
        }
        Self { world, beam, ball, rope, hinges, gear, pulley }
    }

    fn all(&self) -> [JointId; 6] {
        [self.ball, self.rope, self.hinges[0], self.hinges[1], self.gear, self.pulley]
    }

    fn steps(&mut self, count: u32) {
        for _ in 0..count {
            self.world.step(DT);
        }
    }

    /// The body that hangs on a joint.
    fn hung(&self, joint: JointId) -> BodyId {
        self.world.joint(joint).unwrap().body_b()
    }
}

#[test]
fn joints_change_in_any_state() {
    type Change = fn(&mut Machine) -> Result<(), DefError>;
    let changes: [(&str, Change); 14] = [
        ("ball's anchors", |m| {
            m.world.joint_mut(m.ball).unwrap().set_anchors([-8.0, 0.0, 0.0], [0.0, 2.0, 0.0])
        }),
        ("pulley's anchors", |m| {
            m.world.joint_mut(m.pulley).unwrap().set_anchors([0.1, 0.3, 0.0], [0.0; 3])
        }),
        ("lengths", |m| {
            m.world.joint_mut(m.rope).unwrap().set_lengths(0.5, 0.9);
            Ok(())
        }),
        ("spring", |m| {
            let spring = Spring { rest_length: 1.0, hertz: 2.0, damping_ratio: 0.5 };
            m.world.joint_mut(m.rope).unwrap().set_spring(Some(spring))?;
            m.world.joint_mut(m.rope).unwrap().set_lengths(0.0, 5.0);
            Ok(())
        }),
        ("rope", |m| {
            let points = [vec3(3.0, 9.7, 0.0), vec3(6.0, 9.0, 0.0)];
            m.world.joint_mut(m.pulley).unwrap().set_pulley(Pulley::rope(points, 2.0))
        }),
        ("gear", |m| m.world.joint_mut(m.gear).unwrap().set_coupling(-2.0, 0.1)),
        ("motion", |m| {
            let motion = JointMotion::Limited { min: 0.2, max: 0.5, spring: None };
            m.world.joint_mut(m.hinges[0]).unwrap().set_motion(motion)
        }),
        ("slides too", |m| {
            let mut joint = m.world.joint_mut(m.hinges[1]).unwrap();
            joint.axis(Axis::X).unwrap().set_motion(JointMotion::Free)
        }),
        ("collide", |m| {
            m.world.joint_mut(m.ball).unwrap().set_collide_connected(true);
            Ok(())
        }),
        ("off", |m| {
            m.all().into_iter().for_each(|id| m.world.joint_mut(id).unwrap().set_enabled(false));
            Ok(())
        }),
        ("one hinge off", |m| {
            m.world.joint_mut(m.hinges[0]).unwrap().set_enabled(false);
            Ok(())
        }),
        ("off and on", |m| {
            let all = m.all();
            all.into_iter().for_each(|id| m.world.joint_mut(id).unwrap().set_enabled(false));
            m.world.step(DT);
            all.into_iter().for_each(|id| m.world.joint_mut(id).unwrap().set_enabled(true));
            Ok(())
        }),
        ("one body static, one out", |m| {
            let (a, b) = (m.hung(m.hinges[0]), m.hung(m.pulley));
            m.world.body_mut(a).unwrap().set_kind(BodyKind::Static)?;
            m.world.body_mut(b).unwrap().set_enabled(false);
            Ok(())
        }),
        ("number", |m| {
            m.world.joint_mut(m.gear).unwrap().set_user_data(9);
            Ok(())
        }),
    ];
    let team: Arc<Team> = Arc::new(Team::with_threads(3));
    for (name, change) in changes {
        for rests in [0, 1200] {
            let mut machine = Machine::new();
            for hinge in machine.hinges {
                let id = machine.hung(hinge);
                machine.world.body_mut(id).unwrap().set_damping(0.5, 0.5);
            }
            machine.steps(rests);
            change(&mut machine).unwrap_or_else(|e| panic!("{name}: {e}"));
            let mut world = machine.world;
            let mut twin = World::restore(&world.snapshot()).unwrap();
            let mut threads = world.clone().with_executor(team.clone());
            for step in 0..100 {
                for world in [&mut world, &mut twin, &mut threads] {
                    world.step(DT);
                }
                assert_eq!(world.state_hash(), twin.state_hash(), "{name}: step {step}, restored");
                assert_eq!(
                    world.state_hash(),
                    threads.state_hash(),
                    "{name}: step {step}, threads"
                );
                if step % 10 == 0 {
                    twin = World::restore(&world.snapshot()).unwrap();
                }
            }
            assert!(world.audit().non_finite.is_empty(), "{name}");
        }
    }
}

#[test]
fn lengths_and_anchors_lead_where_they_say_and_the_same_ones_move_nothing() {
    let mut machine = Machine::new();
    machine.steps(60);
    let mut twin = machine.world.clone();
    let [a, b] = twin.joint(machine.ball).unwrap().local_anchors();
    assert!((a - vec3(-8.0, -0.5, 0.0)).length() < 1.0e-6 && (b - Vec3::Y * 1.5).length() < 1.0e-6);
    twin.joint_mut(machine.ball).unwrap().set_anchors(a, b).unwrap();
    twin.joint_mut(machine.rope).unwrap().set_lengths(0.0, 1.7);
    for id in machine.all() {
        assert!(!twin.joint(id).unwrap().is_idle());
    }
    for step in 0..60 {
        twin.step(DT);
        for body in twin.bodies() {
            let speed = body.linear_velocity().length();
            let hangs = machine.hinges.iter().all(|id| machine.hung(*id) != body.id());
            let hangs = hangs && machine.hung(machine.pulley) != body.id();
            assert!(!hangs || speed < 10.0 * JOLT, "{:?}: {speed} m/s in step {step}", body.id());
        }
    }
    let weight = machine.hung(machine.rope);
    machine.world.joint_mut(machine.rope).unwrap().set_lengths(0.0, 0.7);
    machine
        .world
        .joint_mut(machine.ball)
        .unwrap()
        .set_anchors([-7.5, -0.5, 0.0], [0.0, 1.0, 0.0])
        .unwrap();
    machine.steps(600);
    let errors = machine.world.audit().joints;
    assert!(errors.linear < 5.0e-3, "{errors:?}");
    // The top of the cube is 0.7 m under the beam's middle.
    let y = machine.world.body(weight).unwrap().position().y;
    assert!((y - (10.0 - 0.7 - 0.3)).abs() < 0.05, "{y} m");
}

#[test]
fn a_joint_that_is_off_does_nothing_and_takes_over_again() {
    let mut machine = Machine::new();
    let id = machine.hung(machine.ball);
    machine.steps(300);
    machine.world.joint_mut(machine.ball).unwrap().set_enabled(false);
    let joint = machine.world.joint(machine.ball).unwrap();
    assert!(!joint.is_enabled() && joint.is_idle() && joint.force() == Vec3::ZERO);
    let before = machine.world.body(id).unwrap().position().y;
    machine.steps(20);
    let fall = before - machine.world.body(id).unwrap().position().y;
    let expected = 0.5 * GRAVITY * (20.0 * DT) * (20.0 * DT + DT / 8.0);
    assert!((fall - expected).abs() < 0.02, "{fall} m");
    // Its error is nobody's meanwhile.
    assert!(machine.world.audit().joints.linear < 0.05);
    machine.world.joint_mut(machine.ball).unwrap().set_enabled(true);
    machine.steps(300);
    assert!(machine.world.joint(machine.ball).unwrap().error() < 5.0e-3);
    assert_eq!(machine.world.joint(machine.rope).unwrap().user_data(), 5);
}

#[test]
fn a_motor_that_is_off_lets_its_body_sleep_and_on_wakes_it() {
    let mut machine = Machine::new();
    let pole = machine.beam;
    let wheel = BodyDef::dynamic().with_position([0.0, 3.0, 0.0]).with_shape(ShapeDef::sphere(0.5));
    let wheel = BodyDef { gravity_scale: 0.0, angular_damping: 5.0, ..wheel };
    let wheel = machine.world.add_body(wheel).unwrap();
    let spin = Hinge::of(JointAxis::driven(JointDrive::motor(2.0, 1.0e6))).six_dof();
    let def = JointDef::new(pole, wheel, spin).at([0.0, 3.0, 0.0]).with_axis(Vec3::Z);
    let hinge = machine.world.add_joint(def).unwrap();
    machine.steps(200);
    let speed = |world: &World| world.body(wheel).unwrap().angular_velocity().z;
    assert!((speed(&machine.world) - 2.0).abs() < 0.01);
    machine.world.joint_mut(hinge).unwrap().set_enabled(false);
    machine.steps(200);
    assert!(machine.world.body(wheel).unwrap().is_asleep());
    machine.world.joint_mut(hinge).unwrap().set_enabled(true);
    assert!(!machine.world.body(wheel).unwrap().is_asleep());
    machine.steps(20);
    assert!((speed(&machine.world) - 2.0).abs() < 0.01);
}

#[test]
fn bodies_of_a_joint_begin_and_cease_to_collide() {
    let mut stack = Stack::new(Floor::Box, 1.0, BodyKind::Dynamic);
    let [a, b] = [stack.cubes[3], stack.cubes[4]];
    let axes = SixDof::FIXED;
    let def = JointDef::new(a, b, axes).at(stack.places()[4]).with_axis(Vec3::X);
    let joint = stack.world.add_joint(JointDef { collide_connected: true, ..def }).unwrap();
    stack.steps(20);
    assert!(stack.world.joint(joint).unwrap().collide_connected());
    let touch =
        |world: &World| world.contacts().filter(|c| [c.body_a(), c.body_b()] == [a, b]).count();
    assert_eq!(touch(&stack.world), 1);
    stack.world.joint_mut(joint).unwrap().set_collide_connected(false);
    stack.world.step(DT);
    assert_eq!((touch(&stack.world), stack.world.events().contact_end.len()), (0, 1));
    stack.stands("held by the joint", 20, 0.01);
    stack.world.joint_mut(joint).unwrap().set_collide_connected(true);
    stack.stands("held by both", 20, 0.01);
    assert_eq!(touch(&stack.world), 1);
}

#[test]
fn what_no_joint_can_be_is_refused_by_name() {
    let mut machine = Machine::new();
    let before = machine.world.snapshot();
    let Machine { world, beam, ball, rope, hinges, gear, pulley } = &mut machine;
    // On a copy: what is refused of a call of each frame is a fault of the next step.
    let lengths = |world: &World, id: JointId, min: f32, max: f32| {
        let call = Call::Joint(id, JointCall::SetLengths(min, max));
        world.clone().apply(&call).unwrap_err().field().to_owned()
    };
    assert_eq!(lengths(world, *rope, 2.0, 1.0), "max");
    assert_eq!(lengths(world, *rope, -1.0, 1.0), "min");
    assert_eq!(lengths(world, *ball, 0.0, 1.0), "joint");
    let mut set = |id: JointId, change: &dyn Fn(JointMut<'_>) -> Result<(), DefError>| {
        change(world.joint_mut(id).unwrap()).unwrap_err().field().to_owned()
    };
    assert_eq!(set(*ball, &|mut j| j.set_anchors([f32::NAN; 3], [0.0; 3])), "anchor_a");
    assert_eq!(set(*gear, &|mut j| j.set_anchors([0.0; 3], [0.0; 3])), "joint");
    let points = [Vec3::ZERO; 2];
    assert_eq!(set(*ball, &|mut j| j.set_pulley(Pulley::rope(points, 1.0))), "joint");
    let rope_of_no_length = Pulley::rope(points, f32::NAN);
    assert_eq!(set(*pulley, &|mut j| j.set_pulley(rope_of_no_length)), "pulley.length");
    assert_eq!(set(*rope, &|mut j| j.set_coupling(1.0, 0.0)), "joint");
    assert_eq!(set(*rope, &|mut j| j.set_limits(0.0, 1.0)), "joint");
    let lock = set(hinges[0], &|mut j| j.set_motion(JointMotion::Locked));
    assert!(lock.contains("coupling"), "{lock}");
    assert!(world.joint_mut(*ball).unwrap().axis(Axis::X).is_none());
    assert!(world.snapshot() == before);
    let gone = *ball;
    assert!(world.remove_joint(gone));
    assert!(world.joint_mut(gone).is_none() && world.joint(gone).is_none());
    assert!(world.body(*beam).is_some());
}
