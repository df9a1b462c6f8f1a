//! A sleeping body wakes when an event affects its holder, its support, or its interior; sensors
//! report it.

use drystone::joint::{Ball, CouplingDef, Distance, Hinge, JointSpring, Pulley, Servo, SixDof};
use drystone::particle::{LinkDef, LinkKind, ParticleDef};
use drystone::{BodyDef, BodyId, BodyKind, JointDef, JointKind, Pose, ShapeDef, Vec3, World, vec3};

use super::{RATES, all_sleep, at, cube, ground, mesh, pulled, run, sleeps, steps, until_sleep};
use crate::floors::{FLOORS, Floor};

/// A load 2 m below a holder at 5 m, on a joint of this name; both scale with `size`.
fn hung(kind: BodyKind, joint: &str, size: f32) -> (World, BodyId, BodyId) {
    let mut world = World::default();
    let top = vec3(0.0, 5.0, 0.0) * size;
    let def = if kind == BodyKind::Static { BodyDef::fixed() } else { BodyDef::kinematic() };
    let holder = world.add_body(def.with_position(top)).unwrap();
    let load = cube(&mut world, vec3(0.0, 3.0, 0.0) * size, 0.4 * size);
    let (below, above) = (Vec3::ZERO, vec3(0.0, 2.0, 0.0) * size);
    let six = |axes: SixDof| JointDef::new(holder, load, axes).at(top).with_axis(Vec3::Z);
    let rod =
        JointDef::new(holder, load, Distance::exact(2.0 * size)).with_anchors(below, Vec3::ZERO);
    let def = match joint {
        "rope" => {
            let kind = JointKind::Distance { min: 0.0, max: 2.0 * size, spring: None };
            JointDef { kind, ..rod }
        }
        "rod" => rod,
        "hinge" => six(Hinge::new().six_dof()),
        "fixed" => six(SixDof::FIXED),
        "grab" => six(Servo::grab(JointSpring::hertz(3.0, 1.0), f32::INFINITY).six_dof()),
        "pulley" => {
            let over = [-1.0_f32, 0.0].map(|x| vec3(x, 9.0, 0.0) * size);
            let side = vec3(-1.0, 0.0, 0.0) * size;
            JointDef::new(holder, load, Pulley::rope(over, 10.0 * size))
                .with_anchors(side, Vec3::ZERO)
        }
        _ => JointDef::new(holder, load, Ball::new()).with_anchors(below, above),
    };
    world.add_joint(def).unwrap();
    let mut last = load;
    if joint == "chain" {
        last = cube(&mut world, vec3(0.0, 2.0, 0.0) * size, 0.4 * size);
        let [low, high] = [-0.5_f32, 0.5].map(|y| vec3(0.0, y, 0.0) * size);
        world.add_joint(JointDef::new(load, last, Ball::new()).with_anchors(low, high)).unwrap();
    }
    assert!(until_sleep(&mut world, 60.0, 5.0).is_some(), "{joint}, {size}");
    (world, holder, last)
}

const JOINTS: [&str; 8] = ["rope", "rod", "ball", "hinge", "fixed", "grab", "pulley", "chain"];

#[test]
fn whatever_happens_to_a_holder_wakes_what_hangs_on_it() {
    for size in [0.1_f32, 1.0, 10.0] {
        for joint in JOINTS {
            for kind in [BodyKind::Static, BodyKind::Kinematic] {
                for how in ["pose", "remove", "move_to", "velocity", "spin", "slow"] {
                    if kind == BodyKind::Static && !["pose", "remove"].contains(&how) {
                        continue;
                    }
                    let (mut world, holder, load) = hung(kind, joint, size);
                    let before = at(&world, load);
                    let mut body = world.body_mut(holder).unwrap();
                    let there = Pose::at(vec3(0.3, 5.0, 0.0) * size);
                    match how {
                        "pose" => body.set_pose(there),
                        "move_to" => body.move_to(there, 1.0),
                        "velocity" => body.set_linear_velocity([0.3 * size, 0.0, 0.0]),
                        "slow" => body.set_linear_velocity([1.0e-3 * size, 0.0, 0.0]),
                        "spin" => body.set_angular_velocity([0.0, 0.0, 0.1]),
                        _ => assert!(world.remove_body(holder)),
                    }
                    let what = format!("{joint}, {kind:?}, {how}, size {size}");
                    assert!(!sleeps(&world, load), "{what}");
                    for _ in 0..60 {
                        world.step(1.0 / 60.0);
                        let moves = !["pose", "remove"].contains(&how);
                        assert!(!moves || !sleeps(&world, load), "{what}");
                    }
                    let moved = (at(&world, load) - before).length();
                    let error = world.joints().map(|joint| joint.error()).fold(0.0, f32::max);
                    // A rope over a pulley hardly lengthens for a millimeter sideways.
                    let idle = how == "spin" || joint == "pulley";
                    assert!(idle || moved > 0.0, "{what}");
                    // A rod or rope under tension yields by a fraction of a millimeter; a grab by
                    // its whole lag.
                    let taut = joint == "grab" || how == "pose" || error < 5.0e-3 * size;
                    assert!(taut, "{what}: {error} m open");
                }
            }
        }
    }
}

#[test]
fn a_gear_wakes_when_a_holder_of_one_of_its_joints_moves() {
    let mut world = World::default();
    let hinge = Hinge::new().six_dof();
    let mut ends = Vec::new();
    for x in [0.0_f32, 3.0] {
        let place = vec3(x, 0.0, 0.0);
        let holder = world.add_body(BodyDef::kinematic().with_position(place)).unwrap();
        let disc = BodyDef::dynamic().with_position(place).with_shape(ShapeDef::cylinder(0.1, 1.0));
        let disc = world.add_body(disc).unwrap();
        let joint = JointDef::new(holder, disc, hinge).at(place).with_axis(Vec3::Y);
        ends.push((holder, disc, world.add_joint(joint).unwrap()));
    }
    world.add_coupling(CouplingDef::gear(ends[0].2, ends[1].2, -1.0)).unwrap();
    assert!(until_sleep(&mut world, 60.0, 5.0).is_some());
    world.body_mut(ends[0].0).unwrap().set_angular_velocity([0.0, 0.01, 0.0]);
    assert!(ends.iter().all(|(_, disc, _)| !sleeps(&world, *disc)));
    run(&mut world, 60.0, 5.0);
    assert!(ends.iter().all(|(_, disc, _)| !sleeps(&world, *disc)));
}

#[test]
fn a_rope_of_particles_carries_however_slowly_its_holder_moves() {
    for how in ["pose", "fast", "slow", "remove"] {
        let mut world = World::default();
        let holder = BodyDef::kinematic().with_position([0.0, 5.0, 0.0]);
        let holder = world.add_body(holder).unwrap();
        let load = cube(&mut world, vec3(0.0, 3.0, 0.0), 0.4);
        let ends = [5.0_f32, 3.2].map(|y| {
            let particle = ParticleDef::at([0.0, y, 0.0]).with_mass(0.1);
            world.add_particle(particle).unwrap()
        });
        world.add_link(LinkDef::new(ends[0], ends[1], LinkKind::Equal)).unwrap();
        world.particle_mut(ends[0]).expect("there").attach(holder, Vec3::ZERO).unwrap();
        world.particle_mut(ends[1]).expect("there").attach(load, [0.0, 0.2, 0.0]).unwrap();
        assert!(until_sleep(&mut world, 60.0, 20.0).is_some());
        let before = at(&world, load);
        let mut body = world.body_mut(holder).unwrap();
        match how {
            "pose" => body.set_pose(Pose::at([0.3, 5.0, 0.0])),
            "fast" => body.set_linear_velocity([0.3, 0.0, 0.0]),
            "slow" => body.set_linear_velocity([0.0, 2.0e-3, 0.0]),
            _ => assert!(world.remove_body(holder)),
        }
        run(&mut world, 60.0, 5.0);
        let moved = at(&world, load) - before;
        let ok = match how {
            "slow" => (moved.y - 0.01).abs() < 1.0e-3,
            "remove" => moved.y < -10.0,
            _ => moved.length() > 0.1,
        };
        assert!(ok, "{how}: {moved:?}");
    }
}

/// A sleeping cube at the origin on a half-space, with a distant wall of each kind: static,
/// kinematic.
fn sleeper(size: f32, sensor: bool) -> (World, BodyId, BodyId, [BodyId; 2]) {
    let mut world = World::default();
    let floor = ground(&mut world, Floor::HalfSpace, size);
    let body = cube(&mut world, vec3(0.0, 0.25, 0.0) * size, 0.5 * size);
    let walls = [(BodyDef::fixed(), 90.0_f32), (BodyDef::kinematic(), -90.0)].map(|(def, x)| {
        let place = vec3(x, 1.1, 0.0) * size;
        world.add_body(def.with_position(place).with_shape(wall(size, sensor))).unwrap()
    });
    assert!(until_sleep(&mut world, 60.0, 5.0).is_some());
    (world, floor, body, walls)
}

fn wall(size: f32, sensor: bool) -> ShapeDef {
    let wall = ShapeDef::box_half(vec3(0.3, 1.0, 1.0) * size);
    if sensor { wall.as_sensor() } else { wall }
}

#[test]
fn what_is_put_into_a_sleeper_is_noticed_however_it_comes_there() {
    for size in [0.1_f32, 1.0, 10.0] {
        // The sleeper's side is at -0.25, so the wall is 15 cm deep, or 5 cm away.
        for x in [-0.4_f32, -0.6] {
            for how in [
                "static",
                "mesh",
                "half-space",
                "kinematic",
                "shape",
                "shape of kinematic",
                "pose",
                "kinematic pose",
            ] {
                let (mut world, floor, body, [fixed, moving]) = sleeper(size, false);
                let place = vec3(x, 1.1, 0.0) * size;
                let face = (x + 0.3) * size;
                match how {
                    "static" => {
                        let def = BodyDef::fixed().with_position(place);
                        world.add_body(def.with_shape(wall(size, false))).unwrap();
                    }
                    "kinematic" => {
                        let def = BodyDef::kinematic().with_position(place);
                        world.add_body(def.with_shape(wall(size, false))).unwrap();
                    }
                    "mesh" => {
                        let corners = [(-1.0, -1.0), (-1.0, 1.0), (2.0, 1.0), (2.0, -1.0)];
                        let corners = corners.map(|(y, z)| vec3(face, y * size, z * size));
                        let sheet = mesh(corners.to_vec(), vec![[0, 2, 1], [0, 3, 2]]);
                        world.add_body(BodyDef::fixed().with_shape(sheet)).unwrap();
                    }
                    "half-space" => {
                        let half = ShapeDef::half_space(Vec3::X, face);
                        world.add_body(BodyDef::fixed().with_shape(half)).unwrap();
                    }
                    "shape" => {
                        let shape = wall(size, false).with_position(place);
                        world.add_shape(floor, shape).unwrap();
                    }
                    "shape of kinematic" => {
                        let shape = wall(size, false).with_position(place - at(&world, moving));
                        world.add_shape(moving, shape).unwrap();
                    }
                    "pose" => world.body_mut(fixed).unwrap().set_pose(Pose::at(place)),
                    _ => world.body_mut(moving).unwrap().set_pose(Pose::at(place)),
                }
                world.step(1.0 / 60.0);
                let touches = x > -0.5;
                let what = format!("{how}, size {size}, touches {touches}");
                assert_eq!(!sleeps(&world, body), touches, "{what}");
                run(&mut world, 60.0, 2.0);
                assert_eq!(at(&world, body).x > 0.1 * size, touches, "{what}");
                assert!(all_sleep(&world) || touches, "{what}");
            }
        }
    }
}

#[test]
fn what_passes_near_a_sleeper_wakes_it_by_touch_alone() {
    for rate in RATES {
        for kind in [BodyKind::Kinematic, BodyKind::Dynamic] {
            // Both within the contact margin of 2 cm.
            for gap in [0.01_f32, -0.005] {
                let mut world = pulled(Vec3::ZERO);
                let shape = ShapeDef::box_half([0.5; 3]);
                let body = BodyDef { asleep: true, ..BodyDef::dynamic().with_shape(shape) };
                let body = world.add_body(body).unwrap();
                let ball = ShapeDef::sphere(0.1);
                let ball = BodyDef { kind, ..BodyDef::dynamic().with_shape(ball) };
                let ball = ball.with_position([-1.0, 0.6 + gap, 0.0]);
                world.add_body(ball.with_linear_velocity([0.3, 0.0, 0.0])).unwrap();
                let mut woke = false;
                for _ in 0..steps(rate, 6.0) {
                    world.step(1.0 / rate);
                    woke |= !sleeps(&world, body);
                }
                assert_eq!(woke, gap < 0.0, "{kind:?}, gap {gap}, {rate} Hz");
            }
        }
    }
}

#[test]
fn what_sleeps_falls_when_what_it_stands_on_goes() {
    for floor in FLOORS {
        for how in ["remove", "remove shape", "pose"] {
            let mut world = World::default();
            let ground = ground(&mut world, floor, 1.0);
            let body = cube(&mut world, vec3(0.0, 0.5, 0.0), 1.0);
            assert!(until_sleep(&mut world, 60.0, 5.0).is_some());
            match how {
                "remove" => assert!(world.remove_body(ground)),
                "remove shape" => {
                    let shape = world.body(ground).unwrap().shapes().next().unwrap();
                    assert!(world.remove_shape(shape));
                }
                _ => {
                    let away = Pose::at([0.0, -50.0, 0.0]);
                    world.body_mut(ground).unwrap().set_pose(away);
                }
            }
            run(&mut world, 60.0, 1.0);
            assert!(at(&world, body).y < -4.0, "{floor:?}, {how}");
        }
    }
}

#[test]
fn bodies_that_are_added_asleep_sleep_on_until_something_is_put_into_them() {
    let mut world = World::default();
    // A wall of a level is added asleep with its ground, all in one step, so nothing wakes it.
    let ground = ground(&mut world, Floor::Box, 1.0);
    let bricks: Vec<BodyId> = (0..5_u8)
        .map(|i| {
            let brick = BodyDef::dynamic().with_position([0.0, 0.5 + f32::from(i), 0.0]);
            let shape = ShapeDef::box_half([0.5; 3]);
            world.add_body(BodyDef { asleep: true, ..brick.with_shape(shape) }).unwrap()
        })
        .collect();
    run(&mut world, 60.0, 1.0);
    assert!(all_sleep(&world));
    world.add_shape(ground, ShapeDef::box_half([0.3; 3]).with_position([0.7, 0.5, 0.0])).unwrap();
    world.step(1.0 / 60.0);
    assert!(!sleeps(&world, bricks[0]));
}

#[test]
fn sensors_see_what_sleeps_and_what_rests() {
    for zone in [BodyKind::Static, BodyKind::Kinematic, BodyKind::Dynamic] {
        for visitor in ["static", "kinematic", "moving", "awake", "asleep"] {
            for zone_first in [true, false] {
                let mut world = pulled(Vec3::ZERO);
                let add_zone = |world: &mut World| {
                    let def = match zone {
                        BodyKind::Static => BodyDef::fixed(),
                        BodyKind::Kinematic => BodyDef::kinematic(),
                        _ => BodyDef::dynamic().with_mass(1.0),
                    };
                    world
                        .add_body(def.with_shape(ShapeDef::box_half([1.0; 3]).as_sensor()))
                        .unwrap()
                };
                let add_visitor = |world: &mut World| {
                    let def = match visitor {
                        "static" => BodyDef::fixed(),
                        "kinematic" => BodyDef::kinematic(),
                        "moving" => BodyDef::kinematic().with_linear_velocity([1.0e-3, 0.0, 0.0]),
                        "awake" => BodyDef::dynamic(),
                        _ => BodyDef { asleep: true, ..BodyDef::dynamic() },
                    };
                    world.add_body(def.with_shape(ShapeDef::sphere(0.2))).unwrap()
                };
                let (at_zone, at_visitor);
                if zone_first {
                    at_zone = add_zone(&mut world);
                    run(&mut world, 60.0, 1.0);
                    at_visitor = add_visitor(&mut world);
                } else {
                    at_visitor = add_visitor(&mut world);
                    run(&mut world, 60.0, 1.0);
                    at_zone = add_zone(&mut world);
                }
                let count = |world: &mut World| {
                    let (mut enters, mut exits) = (0, 0);
                    for _ in 0..60 {
                        world.step(1.0 / 60.0);
                        enters += world.events().sensor_enter.len();
                        exits += world.events().sensor_exit.len();
                    }
                    (enters, exits)
                };
                let seen = usize::from(zone != BodyKind::Static || visitor != "static");
                let what = format!("{zone:?} sees {visitor}, first {zone_first}");
                assert_eq!(count(&mut world), (seen, 0), "{what}: enters");
                // Moves one away and back, then the other.
                for moved in [at_zone, at_visitor] {
                    let here = world.body(moved).unwrap().pose();
                    let away = Pose::at([0.0, 50.0, 0.0]);
                    world.body_mut(moved).unwrap().set_pose(away);
                    assert_eq!(count(&mut world), (0, seen), "{what}: leaves");
                    world.body_mut(moved).unwrap().set_pose(here);
                    assert_eq!(count(&mut world), (seen, 0), "{what}: comes back");
                }
                assert!(world.remove_body(at_visitor));
                assert_eq!(count(&mut world), (0, seen), "{what}: is removed");
            }
        }
    }
}
