//! Memory of a world: a warm step allocates nothing, and a body with its contacts is small. This is
//! a separate binary because it counts every allocation of the stepping thread.
#![expect(unsafe_code, reason = "a global allocator is an unsafe trait")]
#![expect(clippy::unwrap_used, reason = "helpers of tests outside test functions")]

use core::cell::Cell;
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::Arc;

use drystone::contact::{ContactHooks, HookedContact};
use drystone::draw::{DebugColor, DebugDraw, DebugDrawOptions};
use drystone::threads::Executor;
use drystone::{BodyDef, BodyId, ShapeDef, Vec3, World, WorldConfig};

thread_local! {
    static CALLS: Cell<u64> = const { Cell::new(0) };
    static BYTES: Cell<i64> = const { Cell::new(0) };
}

struct Counting;

fn count(calls: u64, bytes: i64) {
    CALLS.set(CALLS.get() + calls);
    BYTES.set(BYTES.get() + bytes);
}

fn signed(size: usize) -> i64 {
    i64::try_from(size).unwrap_or(i64::MAX)
}

// SAFETY: forwards all calls to the system's allocator; counting allocates nothing.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(1, signed(layout.size()));
        // SAFETY: the caller upholds the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        count(0, -signed(layout.size()));
        // SAFETY: the caller upholds the contract of `dealloc`.
        unsafe { System.dealloc(at, layout) }
    }

    unsafe fn realloc(&self, at: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count(1, signed(size) - signed(layout.size()));
        // SAFETY: the caller upholds the contract of `realloc`.
        unsafe { System.realloc(at, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const DT: f32 = 1.0 / 60.0;

fn steps(world: &mut World, n: u32) {
    for _ in 0..n {
        world.step(DT);
    }
}

/// Number of allocations in `n` steps.
fn calls_of(world: &mut World, n: u32) -> u64 {
    let before = CALLS.get();
    steps(world, n);
    CALLS.get() - before
}

fn world(sleep: bool) -> World {
    let mut config = WorldConfig::default();
    config.sleep.enabled = sleep;
    World::new(config).unwrap()
}

fn fixed_box(world: &mut World, half: [f32; 3], at: [f32; 3]) {
    let def = BodyDef::fixed().with_position(at).with_shape(ShapeDef::box_half(half));
    world.add_body(def).unwrap();
}

/// A flat pyramid of unit cubes.
fn pyramid(world: &mut World, base: u32) {
    fixed_box(world, [400.0, 1.0, 400.0], [0.0, -1.0, 0.0]);
    pyramid_at(world, base, 0.0);
}

fn pyramid_at(world: &mut World, base: u32, z: f32) {
    for row in 0..base {
        for k in 0..base - row {
            let x = (0.5 * row as f32) + k as f32 - 0.5 * base as f32;
            let at = [x, row as f32 + 0.5, z];
            let cube = BodyDef::dynamic().with_position(at);
            world.add_body(cube.with_shape(ShapeDef::box_half([0.5; 3]))).unwrap();
        }
    }
}

/// Boxes, balls and capsules over a tray of four walls.
fn pile(world: &mut World, n: u32) -> Vec<BodyId> {
    fixed_box(world, [8.0, 1.0, 8.0], [0.0, -1.0, 0.0]);
    for (half, at) in [
        ([1.0, 20.0, 8.0], [5.0, 20.0, 0.0]),
        ([1.0, 20.0, 8.0], [-5.0, 20.0, 0.0]),
        ([8.0, 20.0, 1.0], [0.0, 20.0, 5.0]),
        ([8.0, 20.0, 1.0], [0.0, 20.0, -5.0]),
    ] {
        fixed_box(world, half, at);
    }
    (0..n)
        .map(|i| {
            let (x, y, z) = (i % 6, i / 36, (i / 6) % 6);
            let at = [x as f32 * 1.2 - 3.0, 1.0 + y as f32 * 1.2, z as f32 * 1.2 - 3.0];
            let shape = match i % 3 {
                0 => ShapeDef::box_half([0.3, 0.4, 0.5]),
                1 => ShapeDef::sphere(0.45),
                _ => ShapeDef::capsule(0.3, 0.3),
            };
            world.add_body(BodyDef::dynamic().with_position(at).with_shape(shape)).unwrap()
        })
        .collect()
}

#[test]
fn a_settled_world_allocates_nothing() {
    let mut world = world(false);
    pyramid(&mut world, 30);
    // By then lists filled by the first step have released unneeded memory.
    steps(&mut world, 140);
    assert_eq!(calls_of(&mut world, 100), 0);
}

/// Counts lines.
struct Lines(usize);

impl DebugDraw for Lines {
    fn line(&mut self, _: Vec3, _: Vec3, _: DebugColor) {
        self.0 += 1;
    }

    fn point(&mut self, _: Vec3, _: DebugColor) {}
}

#[test]
fn drawing_a_world_and_another_origin_allocate_nothing() {
    let mut world = world(false);
    pyramid(&mut world, 10);
    steps(&mut world, 10);
    let options = DebugDrawOptions {
        axes: true,
        bounds: true,
        velocities: true,
        ..DebugDrawOptions::default()
    };
    let (mut lines, before) = (Lines(0), CALLS.get());
    world.debug_draw(&mut lines, &options);
    world.shift_origin([1.0, 2.0, 3.0]).unwrap();
    assert_eq!(CALLS.get() - before, 0);
    assert!(lines.0 > 55 * 24, "{}", lines.0);
}

/// Hooks that change nothing.
struct Asked;

impl ContactHooks for Asked {
    fn contact(&self, contact: &mut HookedContact<'_>) {
        contact.set_softness(contact.softness());
    }
}

#[test]
fn a_step_that_asks_hooks_allocates_nothing() {
    let mut world = world(false);
    fixed_box(&mut world, [10.0, 1.0, 10.0], [0.0, -1.0, 0.0]);
    for i in 0..20_u8 {
        let cube =
            BodyDef::dynamic().with_position([f32::from(i % 4) * 1.1, f32::from(i / 4) + 0.5, 0.0]);
        world.add_body(cube.with_shape(ShapeDef::box_half([0.5; 3]).with_hooks())).unwrap();
    }
    for _ in 0..140 {
        world.step_with(1.0 / 60.0, &Asked);
    }
    let before = CALLS.get();
    for _ in 0..100 {
        world.step_with(1.0 / 60.0, &Asked);
    }
    assert_eq!(CALLS.get() - before, 0);
}

/// An executor with four threads of the user.
#[derive(Debug)]
struct InTurn;

impl Executor for InTurn {
    fn workers(&self) -> usize {
        4
    }

    fn run(&self, chunks: usize, task: &(dyn Fn(usize, usize) + Sync)) {
        (0..chunks).for_each(|chunk| task(chunk % 4, chunk));
    }
}

#[test]
fn a_step_on_threads_of_a_user_allocates_nothing() {
    let mut world = world(false).with_executor(Arc::new(InTurn));
    pyramid(&mut world, 20);
    steps(&mut world, 140);
    assert_eq!(calls_of(&mut world, 100), 0);
}

/// Lists still grow when a scene reaches a new maximum, but ever more rarely: in two of three
/// series of a hundred steps, fewer than one step in ten allocates. An allocation in every step, or
/// whenever a contact begins or ends, would show in most steps of all series.
fn grows_rarely(steps_of_100: &[usize]) -> bool {
    3 * steps_of_100.iter().filter(|n| **n < 10).count() >= 2 * steps_of_100.len()
}

/// Number of steps in a hundred that allocate.
fn steps_that_allocate(world: &mut World) -> usize {
    (0..100).filter(|_| calls_of(world, 1) > 0).count()
}

#[test]
fn a_stirred_pile_allocates_nothing() {
    let mut world = world(false);
    pile(&mut world, 200);
    let arm = ShapeDef::box_half([3.8, 0.4, 0.3]);
    let arm = BodyDef { kind: drystone::BodyKind::Kinematic, ..BodyDef::dynamic() }
        .with_position([0.0, 1.0, 0.0])
        .with_angular_velocity([0.0, 3.0, 0.0])
        .with_shape(arm);
    world.add_body(arm).unwrap();
    steps(&mut world, 1200);
    let changes = |w: &World| w.events().contact_begin.len() + w.events().contact_end.len();
    let mut changed = 0;
    for _ in 0..60 {
        world.step(DT);
        changed += changes(&world);
    }
    assert!(changed > 60, "the pile is stirred: {changed}");
    let steps: Vec<usize> = (0..6).map(|_| steps_that_allocate(&mut world)).collect();
    assert!(grows_rarely(&steps), "{steps:?}");
}

/// A bowl of triangles, each smaller than the bodies that roll in it; gravity rotates.
#[test]
fn bodies_that_roll_over_a_mesh_allocate_nothing() {
    let mut world = world(false);
    let (n, mut vertices, mut triangles) = (40_u32, Vec::new(), Vec::new());
    for i in 0..=n {
        for k in 0..=n {
            let (x, z) = (0.3 * i as f32 - 6.0, 0.3 * k as f32 - 6.0);
            vertices.push(drystone::vec3(x, 0.1 * (x * x + z * z), z));
        }
    }
    for i in 0..n {
        for k in 0..n {
            let a = i * (n + 1) + k;
            triangles.extend([[a, a + 1, a + n + 1], [a + 1, a + n + 2, a + n + 1]]);
        }
    }
    let mesh = drystone::Mesh::new(vertices, triangles).unwrap();
    let mesh = drystone::Shape::Mesh(Arc::new(mesh));
    world.add_body(BodyDef::fixed().with_shape(ShapeDef::new(mesh))).unwrap();
    for i in 0..16_u32 {
        let shape = match i % 4 {
            0 => ShapeDef::box_half([0.3, 0.4, 0.5]),
            1 => ShapeDef::sphere(0.45),
            2 => ShapeDef::capsule(0.3, 0.3),
            _ => ShapeDef::new(drystone::Shape::cylinder(0.3, 0.4)),
        };
        let at = [1.3 * (i % 4) as f32 - 2.0, 3.0, 1.3 * (i / 4) as f32 - 2.0];
        world.add_body(BodyDef::dynamic().with_position(at).with_shape(shape)).unwrap();
    }
    let mut swing = |steps: u32| {
        let mut allocating = 0;
        for i in 0..steps {
            let side = [[2.0, 0.0], [0.0, 2.0], [-2.0, 0.0], [0.0, -2.0]][(i / 25 % 4) as usize];
            world.set_gravity([side[0], -9.81, side[1]]);
            allocating += usize::from(calls_of(&mut world, 1) > 0);
        }
        allocating
    };
    swing(600);
    let steps: Vec<usize> = (0..6).map(|_| swing(100)).collect();
    assert!(grows_rarely(&steps), "{steps:?}");
}

/// A cloth and dust on loose boxes that an arm stirs, and ropes that hold others; links
/// occasionally tear.
#[test]
fn particles_allocate_nothing() {
    let mut world = world(true);
    let bodies = pile(&mut world, 40);
    let arm = ShapeDef::box_half([3.8, 0.4, 0.3]);
    let arm = BodyDef { kind: drystone::BodyKind::Kinematic, ..BodyDef::dynamic() }
        .with_position([0.0, 1.0, 0.0])
        .with_angular_velocity([0.0, 2.0, 0.0])
        .with_shape(arm);
    world.add_body(arm).unwrap();
    let sides = [drystone::vec3(4.0, 0.0, 0.0), drystone::vec3(0.0, 0.0, 4.0)];
    let mut cloth = drystone::particle::ClothDef::new([-2.0, 5.0, -2.0], sides, [20, 20]);
    cloth.tear_strain = Some(0.5);
    world.add_cloth(cloth).unwrap();
    for (i, body) in (0_u16..).zip(bodies.iter().take(6)) {
        let x = f32::from(i) - 3.0;
        let mut rope = drystone::particle::RopeDef::between([x, 6.0, 0.0], [x, 3.0, 0.0], 10);
        rope.pinned = [true, false];
        let rope = world.add_rope(rope).unwrap();
        world.particle_mut(rope.particles[10]).expect("there").attach(*body, [0.0; 3]).unwrap();
    }
    let points = (0..2000_u16).map(|i| {
        let (x, z) = (f32::from(i % 40), f32::from(i / 40));
        drystone::vec3(0.18 * x - 3.5, 6.0, 0.14 * z - 3.5)
    });
    world.add_cloud(points, drystone::particle::ParticleDef::default()).unwrap();
    steps(&mut world, 1200);
    let steps: Vec<usize> = (0..6).map(|_| steps_that_allocate(&mut world)).collect();
    assert!(grows_rarely(&steps), "{steps:?}");
}

#[test]
fn falling_asleep_and_waking_allocate_nothing() {
    let mut world = world(true);
    let bodies = pile(&mut world, 100);
    let mut slept = 0;
    let mut cycle = |world: &mut World| {
        for body in bodies.iter().step_by(7) {
            world.body_mut(*body).unwrap().set_linear_velocity([0.0, 3.0, 0.0]);
        }
        let mut calls = 0;
        for _ in 0..900 {
            calls += calls_of(world, 1);
            slept += world.events().sleep.len();
        }
        calls
    };
    for _ in 0..3 {
        cycle(&mut world);
    }
    let calls: Vec<u64> = (0..4).map(|_| cycle(&mut world)).collect();
    assert!(slept > 4 * bodies.len(), "the pile sleeps: {slept}");
    assert!(calls.iter().filter(|n| **n == 0).count() >= 2, "{calls:?}");
}

/// A standing glued wall, a spinning glued rod, and breakable cubes: loads are computed in every
/// step.
#[test]
fn what_can_break_and_does_not_allocates_nothing() {
    let mut world = world(false);
    pyramid(&mut world, 10);
    let mut glued = |shapes: Vec<ShapeDef>, at: [f32; 3], spin: f32| {
        let glue = drystone::breakage::Glue::touching(
            &shapes,
            1e-3,
            drystone::breakage::BondStrength::both(1.0e9),
        );
        let def = BodyDef { shapes, ..BodyDef::dynamic() }.with_glue(glue.unwrap());
        let def = def.with_position(at).with_angular_velocity([0.0, spin, 0.0]);
        world
            .add_body(BodyDef { gravity_scale: if spin > 0.0 { 0.0 } else { 1.0 }, ..def })
            .unwrap()
    };
    let brick =
        |i: u32, k: u32| ShapeDef::box_full([1.0; 3]).with_position([i as f32, k as f32, 0.0]);
    let wall = (0..36).map(|n| brick(n % 6, n / 6)).collect();
    glued(wall, [0.0, 0.5, 20.0], 0.0);
    glued((0..5).map(|i| brick(i, 0)).collect(), [0.0, 30.0, 0.0], 3.0);
    for i in 0..4_u32 {
        let cube = BodyDef::dynamic().with_position([20.0, 0.5 + i as f32, 0.0]);
        let how = drystone::breakage::Fracture::by_energy(1.0e9);
        let shape = ShapeDef::box_full([1.0; 3]);
        world.add_body(cube.with_shape(shape).with_fracture(how)).unwrap();
    }
    steps(&mut world, 60);
    assert_eq!(calls_of(&mut world, 100), 0);
    assert!(world.bodies().flat_map(|b| b.bonds()).any(|b| b.load > 0.0));
}

/// A pile that an arm stirs, ragdolls of capsules, a rope, a glued wall: one of each object with
/// its own lists.
fn varied() -> World {
    let mut world = world(true);
    let bodies = pile(&mut world, 120);
    let arm = ShapeDef::box_half([3.8, 0.4, 0.3]);
    let arm = BodyDef::kinematic().with_angular_velocity([0.0, 3.0, 0.0]).with_shape(arm);
    world.add_body(arm.with_position([0.0, 1.0, 0.0])).unwrap();
    let mut last = bodies[0];
    for i in 0..6_u32 {
        let at = BodyDef::dynamic().with_position([20.0 + i as f32, 5.0, 0.0]);
        let link = world.add_body(at.with_shape(ShapeDef::capsule(0.3, 0.1))).unwrap();
        let hinge = drystone::joint::Hinge::new().with_limits(-1.0, 1.0);
        let def = drystone::JointDef::new(last, link, hinge).at([19.5 + i as f32, 5.0, 0.0]);
        let def = def.with_axis([0.0, 0.0, 1.0]);
        if i > 0 {
            world.add_joint(def).unwrap();
        }
        last = link;
    }
    let rope = drystone::particle::RopeDef::between([25.0, 5.0, 0.0], [28.0, 5.0, 0.0], 8);
    let rope = world.add_rope(rope).unwrap();
    world.particle_mut(rope.particles[0]).expect("there").attach(last, [0.0; 3]).unwrap();
    let brick = |i: u32| ShapeDef::box_full([1.0; 3]).with_position([i as f32, 0.0, 0.0]);
    let shapes: Vec<ShapeDef> = (0..6).map(brick).collect();
    let glue = drystone::breakage::Glue::touching(
        &shapes,
        1e-3,
        drystone::breakage::BondStrength::both(1.0e9),
    );
    let def = BodyDef { shapes, ..BodyDef::dynamic() }.with_glue(glue.unwrap());
    world.add_body(def.with_position([0.0, 30.0, 0.0])).unwrap();
    fixed_box(&mut world, [100.0, 1.0, 10.0], [100.0, -1.0, 0.0]);
    steps(&mut world, 240);
    world
}

/// Eight frames forward and back to the first of them, repeatedly, like a game that gets remote
/// input late.
#[test]
fn keeping_states_and_going_back_to_them_allocates_nothing() {
    let mut world = varied();
    let mut kept = vec![World::default(); 8];
    let mut calls = Vec::new();
    for _ in 0..4 {
        let mut all = 0;
        for save in &mut kept {
            let before = CALLS.get();
            save.clone_from(&world);
            all += CALLS.get() - before;
            world.step(DT);
        }
        let before = CALLS.get();
        world.clone_from(&kept[0]);
        all += CALLS.get() - before;
        // The next step rebuilds its plan, in the memory of the previous plan.
        all += calls_of(&mut world, 1);
        world.clone_from(&kept[0]);
        calls.push(all);
    }
    assert!(calls[0] > 0, "the first copies take their memory: {calls:?}");
    assert_eq!(calls[1..], [0; 3], "{calls:?}");
}

/// For objects with a list in each row (six-axis joints, bodies of many shapes) the small world has
/// the same number.
#[test]
fn a_copy_of_a_smaller_world_keeps_its_room_for_the_larger_one() {
    let mut large = varied();
    let small = large.clone();
    pile(&mut large, 500);
    steps(&mut large, 30);
    let mut copy = World::default();
    // Some lists of the small world are longer, such as those of touches that began in the last
    // step. The first copy also allocates levels of trees that remain unused.
    for world in [&large, &small, &large] {
        copy.clone_from(world);
    }
    let before = CALLS.get();
    for _ in 0..3 {
        copy.clone_from(&small);
        copy.clone_from(&large);
    }
    assert_eq!(CALLS.get() - before, 0);
    assert_eq!(copy.state_hash(), large.state_hash());
}

#[test]
fn queries_into_warm_lists_allocate_nothing() {
    let mut world = world(false);
    pile(&mut world, 300);
    steps(&mut world, 60);
    let (ball, filter) = (drystone::Shape::sphere(0.7), drystone::query::QueryFilter::default());
    let rays: Vec<_> = (0..100_u8)
        .map(|k| {
            drystone::query::RayQuery::new([f32::from(k) * 0.1 - 5.0, 9.0, 0.0], [0.0, -9.0, 1.0])
        })
        .collect();
    let (mut hits, mut all, mut near, mut overlaps) = (vec![], vec![], vec![], vec![]);
    let mut ask = || {
        let (query, at) = (world.query(), drystone::Pose::at([0.0, 1.0, 0.0]));
        query.cast_rays(&rays, filter, &mut hits).unwrap();
        query.cast_ray_all([-9.0, 0.7, 0.0], [18.0, 0.0, 0.0], filter, &mut all).unwrap();
        query.cast_shape(&ball, at, [3.0, 0.0, 0.0], filter).unwrap();
        query.nearest_all(&ball, at, 0.5, filter, &mut near).unwrap();
        query.overlap_shape_into(&ball, at, filter, &mut overlaps).unwrap();
        hits.iter().flatten().count() + all.len() + near.len() + overlaps.len()
    };
    assert!(ask() > 20);
    let before = CALLS.get();
    ask();
    assert_eq!(CALLS.get() - before, 0);
}

/// The goal is two kilobytes. A body meets it in a pile and in a field of small pyramids, where the
/// solver's blocks are those of a worker's largest group. In one large pyramid it takes more: its
/// 2.9 contacts take 0.75 KB, the solver's blocks 1.06, bodies 0.32, shapes 0.26, lines 0.21,
/// probes 0.19. The rest is spare capacity of lists, the set of pairs and the trees. Marks that
/// track rest from the start of a motion take another 0.2 KB per body, which exceeds the goal
/// (docs/decisions/030-what-may-sleep.md). Sums of contact impulses in a step take another 0.08.
/// The limits are the current values plus a hundredth.
#[test]
fn a_body_with_its_contacts_takes_as_little_as_it_did() {
    let mut made = Vec::new();
    for (scene, most) in [("pyramid", 3700), ("pile", 2320), ("small pyramids", 2545)] {
        let before = BYTES.get();
        let mut world = world(false);
        if scene == "pyramid" {
            pyramid(&mut world, 60);
        } else if scene == "pile" {
            pile(&mut world, 1000);
        } else {
            fixed_box(&mut world, [400.0, 1.0, 500.0], [0.0, -1.0, 0.0]);
            (0..182).for_each(|i| pyramid_at(&mut world, 10, 5.0 * (i as f32 - 91.0)));
        }
        // A second after the last impact its memory is released.
        steps(&mut world, 480);
        let counts = world.counts();
        let bytes = (BYTES.get() - before) / i64::try_from(counts.dynamic).unwrap();
        made.push((scene, bytes, counts.contacts, most));
    }
    println!("bytes a body, contacts, limit: {made:?}");
    assert!(made.iter().all(|(_, bytes, _, most)| bytes <= most), "bytes a body: {made:?}");
}
