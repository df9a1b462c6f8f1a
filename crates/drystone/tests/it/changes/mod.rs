//! Changes in every state: awake, asleep, in contact, on joints, in a breakable body, and saved
//! right after. Masses and events are correct, and a resting body does not jump. The run continues
//! with the same bits from a snapshot and with more threads.
#![expect(clippy::float_cmp, reason = "what is told is what was set, bit by bit")]

mod bodies;
mod calls;
mod joints;
mod particles;
mod shapes;
mod touches;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use drystone::breakage::{BondStrength, Fracture, Glue};
use drystone::joint::Ball;
use drystone::threads::Team;
use drystone::{
    BodyDef, BodyId, BodyKind, DefError, JointDef, ShapeDef, ShapeId, Vec3, World, vec3,
};

use crate::floors::{FLOORS, Floor, ground};

const DT: f32 = 1.0 / 60.0;
const GRAVITY: f32 = 9.81;

/// Maximum speed that a change may give a resting body: the speed gravity adds in one of eight
/// substeps [m/s].
const JOLT: f32 = GRAVITY * DT / 8.0;

/// A static floor with its top at height 0, for bodies of this size [m].
fn floor(world: &mut World, floor: Floor, size: f32) -> BodyId {
    ground(world, floor, [40.0 * size, size])
}

/// A floor and a stack of cubes.
struct Stack {
    world: World,
    floor: BodyId,
    cubes: Vec<BodyId>,
}

impl Stack {
    /// A stack of `count` cubes with edges of this size [m], at rest; `kind` is that of the lowest.
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
        // Half a second of rest would put them to sleep.
        stack.steps(20);
        stack
    }

    fn steps(&mut self, count: u32) {
        for _ in 0..count {
            self.world.step(DT);
        }
    }

    /// Runs until all sleep.
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

    /// Steps and asserts that no cube gets faster than gravity in one substep, or leaves its place
    /// by more than `way` [m].
    fn stands(&mut self, of: &str, count: u32, way: f32) {
        self.is_no_faster(of, count, way, JOLT);
    }

    /// As `stands`, with a given maximum speed [m/s].
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

    /// Maximum speed of cubes whose contacts adapt to new loads [m/s]: a substep passes a load on
    /// by one contact.
    fn speed_of_new_loads(&self) -> f32 {
        JOLT * self.cubes.len() as f32
    }
}

/// Touching pairs, according to the events.
#[derive(Clone, Default)]
struct Touches {
    contacts: BTreeSet<[ShapeId; 2]>,
    visits: BTreeMap<[ShapeId; 2], i32>,
}

impl Touches {
    /// Applies the events of a step: an end must belong to an existing touch, and a begin to a new
    /// one.
    fn follow(&mut self, world: &World, of: &str) {
        let events = world.events();
        let sorted = |a: ShapeId, b: ShapeId| [a.min(b), a.max(b)];
        for e in &events.contact_end {
            assert!(self.contacts.remove(&sorted(e.shape_a, e.shape_b)), "{of}: {e:?} never began");
        }
        for e in &events.contact_begin {
            assert!(self.contacts.insert(sorted(e.shape_a, e.shape_b)), "{of}: {e:?} began twice");
        }
        // A visitor may enter and leave in one step, or leave because of a change and enter again.
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

/// A world with an object to change.
struct Scene {
    name: &'static str,
    world: World,
    /// That object, and its first shape.
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

/// Cubes of 1 m stacked on a floor; the second one is returned.
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

/// A ball on a swinging chain of balls under the ceiling; the second ball is returned.
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

/// Three glued cubes on a floor, with a ball on top.
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

/// A brittle cube on a floor, under another cube.
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

/// A lift that rises under a cube.
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

/// Scenes with bodies in all states. After 20 steps they are awake; after 400 everything that can
/// sleep is asleep.
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

/// A change. A refused change stays refused, and has no effect.
type Change = fn(&mut World, BodyId, ShapeId) -> Result<(), DefError>;

/// A change that may capture values.
type Making<'a> = dyn Fn(&mut World, BodyId, ShapeId) -> Result<(), DefError> + 'a;

/// A name, and changes separated by one step each.
type Changes<'a> = (&'a str, &'a [Change]);

/// Makes each change in each scene: see [`each_in_all_states`].
fn in_all_states(changes: &[Changes<'_>]) {
    for (name, changes) in changes {
        let changes: Vec<&Making<'_>> =
            changes.iter().map(|change| change as &Making<'_>).collect();
        each_in_all_states(name, &changes);
    }
}

/// Makes changes with a step between them in each scene. Tables stay consistent. A snapshot taken
/// right after, or in any later step, continues with the same bits, as do three threads. Events of
/// touches pair up.
fn each_in_all_states(name: &str, changes: &[&Making<'_>]) {
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
        let Scene { world, touches, .. } = &mut scene;
        goes_on(&of, world, |world| touches.follow(world, &of));
    }
}

/// Runs a world for 100 steps and checks that snapshots and three threads give the same bits.
fn goes_on(of: &str, world: &mut World, mut after: impl FnMut(&World)) {
    let restored = |world: &World| {
        World::restore(&world.snapshot()).map_err(|e| format!("{of}: {e}")).unwrap()
    };
    let mut twin = restored(world);
    let mut threads = world.clone().with_executor(Arc::new(Team::with_threads(3)));
    for step in 0..100 {
        for world in [&mut *world, &mut twin, &mut threads] {
            world.step(DT);
        }
        assert_eq!(world.state_hash(), twin.state_hash(), "{of}: step {step}, restored");
        assert_eq!(world.events(), twin.events(), "{of}: step {step}, restored");
        assert_eq!(world.state_hash(), threads.state_hash(), "{of}: step {step}, threads");
        assert_eq!(world.events(), threads.events(), "{of}: step {step}, threads");
        after(world);
        if step < 3 || step % 20 == 0 {
            twin = restored(world);
        }
    }
    let audit = world.audit();
    assert!(audit.non_finite.is_empty(), "{of}: {audit:?}");
}

/// The first shape of a body.
fn shape_of(world: &World, body: BodyId) -> ShapeId {
    world.body(body).unwrap().shapes().next().unwrap()
}
