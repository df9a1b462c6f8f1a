//! Bodies on adjacent shapes.

use std::sync::Arc;

use drystone::threads::Team;
use drystone::{BodyDef, BodyId, Material, Pose, Quat, Shape, ShapeDef, Vec3, World, vec3};

const DT: f32 = 1.0 / 60.0;

fn surface(shape: Shape, friction: f32) -> ShapeDef {
    ShapeDef::new(shape).with_material(Material { friction, ..Material::default() })
}

/// Boxes of 1 m side by side, tops at y = 0, over x in [-12, 12] and z in [-6, 6].
fn tiles(friction: f32) -> Vec<ShapeDef> {
    let mut out = Vec::new();
    for i in -12_i16..12 {
        for k in -6_i16..6 {
            let at = vec3(f32::from(i) + 0.5, -0.5, f32::from(k) + 0.5);
            out.push(surface(Shape::box_half([0.5; 3]), friction).with_position(at));
        }
    }
    out
}

/// All tiles as one box.
fn whole(friction: f32) -> ShapeDef {
    surface(Shape::box_half([12.0, 0.5, 6.0]), friction).with_position(vec3(0.0, -0.5, 0.0))
}

#[derive(Clone, Copy, Debug)]
enum Ground {
    /// Several shapes of one body.
    Tiles,
    TileBodies,
    /// One box.
    One,
}

fn add_ground(world: &mut World, ground: Ground, friction: f32) {
    match ground {
        Ground::Tiles => floor(world, tiles(friction), true),
        Ground::TileBodies => floor(world, tiles(friction), false),
        Ground::One => floor(world, vec![whole(friction)], true),
    }
}

/// A ground of tiles: shapes of one body, or a body for each.
fn floor(world: &mut World, tiles: Vec<ShapeDef>, one_body: bool) {
    if one_body {
        let ground = tiles.into_iter().fold(BodyDef::fixed(), BodyDef::with_shape);
        world.add_body(ground).unwrap();
    } else {
        for tile in tiles {
            world.add_body(BodyDef::fixed().with_shape(tile)).unwrap();
        }
    }
}

/// Extent of the largest sliding body, the box [m].
const EXTENT: f32 = 0.65;

/// Shape, rotation and center height of each sliding body.
fn movers() -> [(Shape, Quat, f32); 5] {
    let lying = Quat::from_axis_angle(Vec3::Z, core::f32::consts::FRAC_PI_2);
    let standing = Quat::IDENTITY;
    [
        (Shape::box_half([0.4, 0.3, 0.4]), standing, 0.3),
        (Shape::sphere(0.3), standing, 0.3),
        (Shape::capsule(0.3, 0.25), lying, 0.25),
        (Shape::cylinder(0.3, 0.4), standing, 0.3),
        (Shape::cylinder(0.3, 0.4), lying, 0.4),
    ]
}

fn add(world: &mut World, shape: ShapeDef, at: Vec3, v: Vec3) -> BodyId {
    let def = BodyDef::dynamic().with_position(at).with_linear_velocity(v).with_shape(shape);
    world.add_body(def).unwrap()
}

#[test]
fn seams_of_flush_boxes_neither_brake_nor_lift_what_slides_over_them() {
    for one_body in [true, false] {
        for (shape, rotation, height) in movers() {
            for v in [vec3(5.0, 0.0, 0.0), vec3(5.0, 0.0, 1.7), vec3(0.4, 0.0, -0.3)] {
                let mut world = World::default();
                floor(&mut world, tiles(0.0), one_body);
                let shape = surface(shape.clone(), 0.0).with_pose(Pose::new(Vec3::ZERO, rotation));
                let id = add(&mut world, shape, vec3(-9.3, height, -2.13), v);
                for _ in 0..180 {
                    world.step(DT);
                    // Motion of a body that falls by less than the rest offset, 5e-5 m.
                    let up = world.body(id).unwrap().linear_velocity().y;
                    assert!(up.abs() < 0.01, "{rotation:?} {height} {v:?}: {up}");
                }
                let now = world.body(id).unwrap().linear_velocity();
                assert!(
                    (now - v).length() < 2e-3 * v.length(),
                    "{rotation:?} {height} {v:?} {now:?}"
                );
            }
        }
    }
}

#[test]
fn what_carries_may_be_a_body_that_moves() {
    let mut world = World::default();
    world
        .add_body(
            BodyDef::fixed()
                .with_shape(ShapeDef::box_half([40.0, 0.5, 40.0]))
                .with_position([0.0, -1.5, 0.0]),
        )
        .unwrap();
    let raft = tiles(0.0).into_iter().fold(BodyDef::dynamic(), BodyDef::with_shape);
    world.add_body(raft).unwrap();
    let v = vec3(5.0, 0.0, 0.0);
    let id =
        add(&mut world, surface(Shape::box_half([0.4, 0.3, 0.4]), 0.0), vec3(-9.3, 0.3, 0.13), v);
    for _ in 0..180 {
        world.step(DT);
    }
    let now = world.body(id).unwrap().linear_velocity();
    assert!((now - v).length() < 0.01, "{now:?}");
}

#[test]
fn what_rolls_over_seams_rolls_as_on_one_box() {
    let along = |angle: f32| Quat::from_axis_angle(Vec3::Y, angle);
    let lying = Quat::from_axis_angle(Vec3::X, core::f32::consts::FRAC_PI_2);
    let cases = [
        (Shape::sphere(0.3), 0.3),
        (Shape::capsule(0.3, 0.25), 0.25),
        (Shape::cylinder(0.3, 0.4), 0.4),
    ];
    for ground in [Ground::Tiles, Ground::TileBodies, Ground::One] {
        for (shape, radius) in &cases {
            for angle in [0.0, 0.3] {
                let mut world = World::default();
                add_ground(&mut world, ground, 0.6);
                // The axis is perpendicular to the motion.
                let v = along(angle).rotate(vec3(5.0, 0.0, 0.0));
                let w = along(angle).rotate(vec3(0.0, 0.0, -5.0 / radius));
                let shape = surface(shape.clone(), 0.6).with_pose(Pose::new(Vec3::ZERO, lying));
                let id = world
                    .add_body(
                        BodyDef::dynamic()
                            .with_position(vec3(-9.3, *radius, 2.87))
                            .with_rotation(along(angle))
                            .with_linear_velocity(v)
                            .with_angular_velocity(w)
                            .with_shape(shape),
                    )
                    .unwrap();
                for _ in 0..180 {
                    world.step(DT);
                    let up = world.body(id).unwrap().linear_velocity().y;
                    assert!(up.abs() < 0.01, "{ground:?} {radius} {angle}: {up}");
                }
                let now = world.body(id).unwrap().linear_velocity();
                // A ghost collision at a seam took 0.1 to 1 m/s each time.
                let lost = (now - v).length();
                assert!(lost < 1e-2 * v.length(), "{ground:?} {radius} {angle}: {now:?}");
            }
        }
    }
}

#[test]
fn a_box_on_the_corner_of_four_tiles_rests_and_slides_as_on_one() {
    for ground in [Ground::Tiles, Ground::TileBodies, Ground::One] {
        let mut world = World::default();
        add_ground(&mut world, ground, 0.6);
        let cube = surface(Shape::box_half([0.3; 3]), 0.6);
        let id = add(&mut world, cube.clone(), vec3(0.0, 0.5, 0.0), Vec3::ZERO);
        for _ in 0..180 {
            world.step(DT);
        }
        let body = world.body(id).unwrap();
        // It rests by the rest offset, and sinks by at most g / (2 pi f)^2 in each of its four soft
        // points.
        assert!((body.position() - vec3(0.0, 0.3, 0.0)).length() < 1e-3, "{ground:?}");
        assert!(body.is_asleep(), "{ground:?}");
        // Finally pushed along the diagonal of tiles, over three more corners.
        let mut world = World::default();
        add_ground(&mut world, ground, 0.0);
        let v = vec3(3.0, 0.0, 3.0);
        let cube = cube.with_friction(0.0);
        let id = add(&mut world, cube, vec3(-4.0, 0.3, -4.0), v);
        for _ in 0..120 {
            world.step(DT);
            let up = world.body(id).unwrap().linear_velocity().y;
            assert!(up.abs() < 0.01, "{ground:?}: {up}");
        }
        let now = world.body(id).unwrap().linear_velocity();
        assert!((now - v).length() < 2e-3 * v.length(), "{ground:?}: {now:?}");
    }
}

#[test]
fn a_raft_that_is_moved_carries_as_one_box() {
    for spin in [0.0, 0.4] {
        let mut world = World::default();
        let raft = BodyDef::kinematic()
            .with_linear_velocity(vec3(-2.0, 0.5, 0.0))
            .with_angular_velocity(vec3(0.0, spin, 0.0));
        world.add_body(tiles(0.0).into_iter().fold(raft, BodyDef::with_shape)).unwrap();
        let v = vec3(3.0, 0.5, 0.0);
        let cube = surface(Shape::box_half([0.4, 0.3, 0.4]), 0.0);
        let id = add(&mut world, cube, vec3(-3.3, 0.3, 0.13), v);
        for _ in 0..90 {
            world.step(DT);
        }
        let now = world.body(id).unwrap().linear_velocity();
        assert!((now - v).length() < 2e-3 * v.length(), "{spin}: {now:?}");
    }
}

/// The final position of a body, and the maximum overlap on the way less the error of one step. The
/// rows of a contact are frozen over a step and leave out `r |w dt|²/2`
/// (docs/derivations/soft-step.md). A point that was not approaching penetrates by the change of
/// its velocity in the meantime.
fn run_into(
    ground: Vec<ShapeDef>,
    one_body: bool,
    shape: ShapeDef,
    at: Vec3,
    v: Vec3,
) -> (Vec3, f32) {
    let mut world = World::default();
    floor(&mut world, ground, one_body);
    let id = add(&mut world, shape, at, v);
    let (mut most, mut explained) = (0.0_f32, 0.0_f32);
    let (mut v, mut w) = (v, Vec3::ZERO);
    for _ in 0..120 {
        world.step(DT);
        let body = world.body(id).unwrap();
        let angle = body.angular_velocity().length() * DT;
        let changed =
            (body.linear_velocity() - v).length() + (body.angular_velocity() - w).length() * EXTENT;
        explained = explained.max(0.5 * angle * angle * EXTENT + changed * DT);
        (v, w) = (body.linear_velocity(), body.angular_velocity());
        most = most.max(world.audit().penetration.max - explained);
    }
    (world.body(id).unwrap().position(), most)
}

#[test]
fn steps_and_walls_still_stop() {
    for rise in [0.02, 0.1, 2.0] {
        for (shape, rotation, height) in movers() {
            for speed in [1.0, 5.0, 20.0] {
                // Between tiles, flush with their sides and as deep as they are.
                let mut cut = tiles(0.0);
                let half = 0.5 * (1.0 + rise);
                for tile in &mut cut {
                    let at = tile.pose.position;
                    if at.x > 3.0 {
                        *tile = surface(Shape::box_half([0.5, half, 0.5]), 0.0)
                            .with_position(vec3(at.x, half - 1.0, at.z));
                    }
                }
                let flat = matches!(shape, Shape::Box { .. }) || rotation == Quat::IDENTITY;
                let round = matches!(shape, Shape::Sphere { .. });
                let shape = surface(shape.clone(), 0.0).with_pose(Pose::new(Vec3::ZERO, rotation));
                let (at, v) = (vec3(1.3, height, 0.13), vec3(speed, 0.0, 0.0));
                for one_body in [true, false] {
                    let (end, most) = run_into(cut.clone(), one_body, shape.clone(), at, v);
                    let case = format!("{rise} {rotation:?} {height} {speed} {one_body}");
                    // Upright sides stop; round ones stop at obstacles higher than their middle.
                    if rise > 1.0 || (flat && !round && speed < 2.0) {
                        assert!(end.x < 3.0, "{case}: {end:?}");
                    }
                    assert!(end.y > 0.0 || end.x > 12.0, "{case}: {end:?}");
                    // Bodies in soft contacts sink by less under some times their weight.
                    assert!(most < 1e-3, "{case}: {most}");
                }
            }
        }
    }
}

#[test]
fn a_step_between_large_slabs_is_a_step() {
    // The far end of a slab must not widen the tolerance for flush shapes.
    let slab = |x: f32, top: f32| {
        surface(Shape::box_half([50.0, 0.5, 50.0]), 0.0).with_position(vec3(x, top - 0.5, 0.0))
    };
    let cube = surface(Shape::box_half([0.25; 3]), 0.0);
    for (rise, stops) in [(0.05, true), (0.01, true), (0.0, false)] {
        let ground = vec![slab(-50.0, 0.0), slab(50.0, rise)];
        let (end, _) =
            run_into(ground, false, cube.clone(), vec3(-1.0, 0.25, 0.3), vec3(2.0, 0.0, 0.0));
        assert_eq!(end.x < 0.0, stops, "{rise}: {end:?}");
    }
}

#[test]
fn what_lands_askew_beside_a_seam_can_be_pushed_over_it() {
    for one_body in [true, false] {
        for gap in [0.0, 0.001, 0.004] {
            let mut world = World::default();
            floor(&mut world, tiles(0.0), one_body);
            let cube = surface(Shape::box_half([0.3; 3]), 0.0);
            let def = BodyDef::dynamic()
                .with_position(vec3(0.7 - gap, 0.31, 0.51))
                .with_angular_velocity(vec3(0.0, 0.0, -0.2))
                .with_shape(cube);
            let id = world.add_body(def).unwrap();
            for _ in 0..30 {
                world.step(DT);
            }
            let from = world.body(id).unwrap().position().x;
            let mass = world.body(id).unwrap().mass();
            for _ in 0..60 {
                world.body_mut(id).unwrap().add_step_force(vec3(mass, 0.0, 0.0));
                world.step(DT);
            }
            let moved = world.body(id).unwrap().position().x - from;
            // 1 m/s² for a second, from rest or nearly so.
            assert!((moved - 0.5).abs() < 0.05, "{one_body} {gap}: {moved}");
        }
    }
}

#[test]
fn what_tips_over_a_seam_comes_down_on_the_next_tile() {
    for one_body in [true, false] {
        for edge in [-0.3_f32, -0.2, -0.05, 0.0] {
            for w in [0.2, 1.0, 3.0] {
                let mut most = [0.0_f32; 2];
                for (cut, most) in [true, false].into_iter().zip(&mut most) {
                    let mut world = World::default();
                    let tiles = if cut { tiles(0.6) } else { vec![whole(0.6)] };
                    floor(&mut world, tiles, one_body);
                    // Its right edge is `edge` past the seam at x = 0.
                    let def = BodyDef::dynamic()
                        .with_position(vec3(edge - 0.2, 1.0, 0.13))
                        .with_angular_velocity(vec3(0.0, 0.0, -w))
                        .with_shape(surface(Shape::box_half([0.2, 1.0, 0.2]), 0.6));
                    world.add_body(def).unwrap();
                    for _ in 0..240 {
                        world.step(DT);
                        *most = most.max(world.audit().penetration.max);
                    }
                }
                // On one box the maximum overlap of the same body is 0.9 mm.
                assert!(most[0] < most[1] + 1e-3, "{one_body} {edge} {w}: {most:?}");
            }
        }
    }
}

#[test]
fn seams_are_the_same_for_any_number_of_threads() {
    let run = |threads: usize| {
        let mut world = World::default().with_executor(Arc::new(Team::with_threads(threads)));
        floor(&mut world, tiles(0.3), false);
        for i in 0_u8..12 {
            for k in 0_u8..6 {
                let (x, z) = (f32::from(i), f32::from(k));
                let cube = surface(Shape::box_half([0.3; 3]), 0.3);
                let v = vec3(2.0 - 0.3 * z, 0.0, 1.0 - 0.2 * x);
                add(&mut world, cube, vec3(1.5 * x - 9.0, 0.3, 1.5 * z - 4.0), v);
            }
        }
        (0..120).map(|_| world.step(DT)).for_each(drop);
        world.state_hash()
    };
    let one = run(1);
    for threads in [2, 3, 7] {
        assert_eq!(run(threads), one, "{threads}");
    }
}
