//! A shift of the origin has no effect: the same world continues around it.

use std::sync::Arc;

use drystone::events::Events;
use drystone::joint::{Ball, Hinge};
use drystone::journal::{Answer, Call};
use drystone::particle::RopeDef;
use drystone::query::QueryFilter;
use drystone::{BodyDef, BodyId, Clock, JointDef, Mesh, Shape, ShapeDef, Vec3, World, vec3};

const DT: f32 = 1.0 / 60.0;

/// Position of the scene. Between 1024 m and 2048 m all coordinates have a last digit of 2⁻¹³ m. A
/// shift by a multiple of that which stays in this range is never rounded.
const FAR: Vec3 = Vec3::splat(1500.0);
const ORIGIN: Vec3 = vec3(128.0, -64.0, 192.5);

fn add(world: &mut World, at: [f32; 3], body: BodyDef, shape: ShapeDef) -> BodyId {
    world.add_body(body.with_position(FAR + Vec3::from(at)).with_shape(shape)).unwrap()
}

/// All kinds of objects: a pile on a mesh, ragdoll joints, a pulley, a lift, a rope that holds a
/// box, a sensor, fast balls.
fn scene() -> World {
    let mut world = World::default();
    let vertices = (0..49_u8).map(|i| {
        let height = 0.1 * f32::from(i % 5);
        vec3(2.0 * f32::from(i % 7) - 6.0, height, 2.0 * f32::from(i / 7) - 6.0)
    });
    let cells = (0..6_u32).flat_map(|j| (0..6_u32).map(move |i| 7 * j + i));
    let triangles = cells.flat_map(|k| [[k, k + 7, k + 1], [k + 1, k + 7, k + 8]]).collect();
    let mesh = Mesh::new(vertices.collect(), triangles).unwrap();
    let mesh = ShapeDef::new(Shape::Mesh(Arc::new(mesh)));
    let ground = add(&mut world, [0.0; 3], BodyDef::fixed(), mesh);
    for i in 0..20_u8 {
        let k = f32::from(i);
        let shape = match i % 4 {
            0 => ShapeDef::box_half([0.3, 0.2, 0.25]),
            1 => ShapeDef::sphere(0.25).with_restitution(0.5),
            2 => ShapeDef::capsule(0.2, 0.15),
            _ => ShapeDef::cylinder(0.2, 0.2),
        };
        add(
            &mut world,
            [0.3 * (k % 3.0), 1.0 + 0.5 * k, 0.2 * (k % 2.0)],
            BodyDef::dynamic(),
            shape,
        );
    }
    let rod = || ShapeDef::capsule(0.3, 0.1);
    let mut before = ground;
    for i in 0..4_u8 {
        let at = [4.0, 5.0 - 0.8 * f32::from(i), 0.0];
        let next = add(&mut world, at, BodyDef::dynamic(), rod());
        let anchor = if i == 0 { vec3(4.0, 5.4, 0.0) } else { vec3(0.0, -0.4, 0.0) };
        let def = if i % 2 == 0 {
            JointDef::new(before, next, Ball::new())
        } else {
            JointDef::new(before, next, Hinge::new().with_limits(-0.5, 0.5))
        };
        world.add_joint(def.with_anchors(anchor, [0.0, 0.4, 0.0])).unwrap();
        before = next;
    }
    let load = |world: &mut World, x: f32, half: f32| {
        add(world, [x, 3.0, 4.0], BodyDef::dynamic(), ShapeDef::box_half([half; 3]))
    };
    let (a, b) = (load(&mut world, -3.0, 0.3), load(&mut world, -1.0, 0.25));
    let points = [FAR + vec3(-3.0, 6.0, 4.0), FAR + vec3(-1.0, 6.0, 4.0)];
    let pulley = drystone::joint::Pulley::rope(points, 6.0);
    world.add_joint(JointDef::new(a, b, pulley)).unwrap();
    let lift = BodyDef::kinematic().with_linear_velocity([0.0, 0.25, 0.1]);
    add(&mut world, [-5.0, 1.0, 0.0], lift, ShapeDef::box_half([0.5, 0.1, 0.5]));
    add(&mut world, [-5.0, 1.4, 0.0], BodyDef::dynamic(), ShapeDef::box_half([0.2; 3]));
    let rope = RopeDef::between(FAR + vec3(4.0, 4.0, 4.0), FAR + vec3(6.0, 4.0, 4.0), 12);
    let rope = world.add_rope(RopeDef { pinned: [true, false], ..rope }).unwrap();
    let held = add(&mut world, [6.0, 4.0, 4.0], BodyDef::dynamic(), ShapeDef::box_half([0.2; 3]));
    let end = *rope.particles.last().unwrap();
    world.particle_mut(end).unwrap().attach(held, Vec3::ZERO).unwrap();
    let gate = ShapeDef::box_half([3.0, 0.3, 3.0]).as_sensor();
    add(&mut world, [0.0, 2.0, 0.0], BodyDef::fixed(), gate);
    for i in 0..3_u8 {
        let shot = BodyDef::dynamic().with_linear_velocity([50.0 + 20.0 * f32::from(i), 1.0, 0.0]);
        add(&mut world, [-6.0, 1.0 + f32::from(i), 1.0], shot, ShapeDef::sphere(0.1));
    }
    world
}

/// State of all moving bodies and particles, relative to `origin`.
fn state(world: &World, origin: Vec3) -> Vec<[Vec3; 4]> {
    let bodies = world.bodies().map(|body| {
        let q = body.rotation();
        let at = body.center_of_mass() - origin;
        [at, body.linear_velocity(), vec3(q.x, q.y, q.z), body.angular_velocity()]
    });
    let particles =
        world.particles().map(|p| [p.position() - origin, p.velocity(), Vec3::ZERO, Vec3::ZERO]);
    bodies.chain(particles).collect()
}

fn told_from(events: &Events, origin: Vec3) -> Events {
    let mut events = events.clone();
    events.hits.iter_mut().for_each(|hit| hit.point -= origin);
    events
}

#[test]
fn a_world_goes_on_with_the_same_bits_around_another_origin() {
    for start in [0, 1, 30, 90] {
        let mut world = scene();
        (0..start).for_each(|_| world.step(DT));
        let mut other = world.clone();
        other.shift_origin(ORIGIN).unwrap();
        assert_eq!(state(&world, ORIGIN), state(&other, Vec3::ZERO), "moved after {start}");
        assert_eq!(told_from(world.events(), ORIGIN), *other.events());
        assert!(World::restore(&other.snapshot()).is_ok());
        for step in 0..150 {
            world.step(DT);
            other.step(DT);
            let (one, two) = (state(&world, ORIGIN), state(&other, Vec3::ZERO));
            let off = one.iter().zip(&two).position(|(a, b)| a != b);
            let at = off.unwrap_or(0);
            assert_eq!(off, None, "after {start}, step {step}: {:?} {:?}", one[at], two[at]);
            assert_eq!(told_from(world.events(), ORIGIN), *other.events(), "{start}, {step}");
        }
    }
}

/// A stack at an odd position.
fn stack() -> (World, Vec<BodyId>) {
    let mut world = World::default();
    let at = vec3(3001.37, 20.13, -777.7);
    let floor = BodyDef::fixed().with_position(at - Vec3::Y);
    world.add_body(floor.with_shape(ShapeDef::box_half([5.0, 1.0, 5.0]))).unwrap();
    let boxes = (0..8_u8).map(|i| {
        let body = BodyDef::dynamic().with_position(at + Vec3::Y * (0.5 + f32::from(i)));
        world.add_body(body.with_shape(ShapeDef::box_half([0.5; 3]))).unwrap()
    });
    let boxes = boxes.collect();
    (world, boxes)
}

#[test]
fn what_stands_gets_no_jolt_by_rounding() {
    let (mut world, boxes) = stack();
    (0..20).for_each(|_| world.step(DT));
    let origin = vec3(2998.123, 17.9, -780.01);
    let before: Vec<Vec3> = boxes.iter().map(|id| world.body(*id).unwrap().position()).collect();
    world.shift_origin(origin).unwrap();
    assert_eq!(world.contacts().count(), 8);
    for (id, before) in boxes.iter().zip(before) {
        // Nearer to the origin there are more digits, so the difference is exact.
        assert_eq!(world.body(*id).unwrap().position(), before - origin);
    }
    for _ in 0..60 {
        world.step(DT);
        let events = world.events();
        assert!(events.contact_begin.is_empty() && events.contact_end.is_empty());
        for id in &boxes {
            let speed = world.body(*id).unwrap().linear_velocity().length();
            // Less than the speed gravity adds in a substep.
            assert!(speed < 9.81 * DT / 8.0, "{speed} m/s");
        }
    }
}

#[test]
fn what_sleeps_sleeps_on() {
    let (mut world, boxes) = stack();
    (0..300).for_each(|_| world.step(DT));
    assert!(boxes.iter().all(|id| world.body(*id).unwrap().is_asleep()));
    world.shift_origin([3001.0, 20.0, -778.0]).unwrap();
    let placed = |world: &World| -> Vec<Vec3> {
        boxes.iter().map(|id| world.body(*id).unwrap().position()).collect()
    };
    let there = placed(&world);
    for _ in 0..60 {
        world.step(DT);
        assert_eq!(*world.events(), Events::default());
    }
    assert_eq!(placed(&world), there);
    assert_eq!(world.moved_bodies().count(), 0);
    // Rays find it there.
    let hit = world.query().cast_ray(
        [there[0].x, 30.0, there[0].z],
        [0.0, -60.0, 0.0],
        QueryFilter::default(),
    );
    let hit = hit.unwrap().unwrap();
    assert!((hit.point.y - there[7].y - 0.5).abs() < 1.0e-4, "{hit:?}");
}

#[test]
fn pictures_between_two_steps_go_on() {
    let mut world = World::default();
    let ball = BodyDef::dynamic().with_position([1000.3, 1200.7, 5.1]);
    let ball = ball.with_linear_velocity([7.0, 0.0, 3.0]).with_shape(ShapeDef::sphere(0.5));
    let ball = world.add_body(ball).unwrap();
    let mut clock = Clock::new(DT).unwrap();
    clock.advance(&mut world, 3.4 * DT, |_| {});
    let drawn = clock.pose(&world, ball).unwrap().position;
    let origin = vec3(1000.1, 1200.3, 4.7);
    clock.shift_origin(&mut world, origin).unwrap();
    let now = clock.pose(&world, ball).unwrap().position;
    // Within a rounding of 1200 m.
    assert!((now + origin - drawn).length() < 2.0e-4, "{now:?} {drawn:?}");
    assert_ne!(now, world.body(ball).unwrap().position(), "it is drawn where it is");
}

#[test]
fn it_is_a_call_as_others_and_refuses_what_is_no_place() {
    let (mut world, boxes) = stack();
    let before = world.state_hash();
    for bad in [vec3(f32::NAN, 0.0, 0.0), vec3(0.0, 1.0e8, 0.0), vec3(0.0, 0.0, f32::INFINITY)] {
        let error = world.shift_origin(bad).unwrap_err().to_string();
        assert!(error.contains("origin"), "{error}");
    }
    world.shift_origin(Vec3::ZERO).unwrap();
    assert_eq!(world.state_hash(), before);
    let mut other = world.clone();
    assert_eq!(world.apply(&Call::ShiftOrigin(ORIGIN)), Ok(Answer::Done));
    other.shift_origin(ORIGIN).unwrap();
    assert_eq!(world.state_hash(), other.state_hash());
    // To the limits of the world and back.
    for far in [1.0e7, -1.0e7] {
        // Until an object would be out of range.
        let far = [far; 3];
        let times = (0..300).find(|_| {
            world.step(DT);
            world.shift_origin(far).is_err()
        });
        assert!(times.is_some());
        assert!(boxes.iter().all(|id| world.body(*id).is_some()));
        assert!(World::restore(&world.snapshot()).is_ok());
    }
}
