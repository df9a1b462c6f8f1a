//! Bodies on shapes that lie side by side.

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

/// What slides, and how high its center is then.
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
                    // What a body does that falls by less than the rest offset, 5e-5 m.
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
fn a_rolling_ball_does_not_feel_the_seams() {
    for one_body in [true, false] {
        let mut world = World::default();
        floor(&mut world, tiles(0.6), one_body);
        let v = vec3(5.0, 0.0, 1.1);
        let id = add(&mut world, surface(Shape::sphere(0.3), 0.6), vec3(-9.3, 0.3, -2.13), v);
        let w = vec3(v.z, 0.0, -v.x) * (1.0 / 0.3);
        world.body_mut(id).unwrap().set_angular_velocity(w).unwrap();
        for _ in 0..180 {
            world.step(DT);
            let up = world.body(id).unwrap().linear_velocity().y;
            assert!(up.abs() < 0.01, "{up}");
        }
        let now = world.body(id).unwrap().linear_velocity();
        assert!((now - v).length() < 1e-2 * v.length(), "{now:?}");
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
fn steps_and_walls_still_stop() {
    for one_body in [true, false] {
        for rise in [0.02, 0.1, 2.0] {
            for (shape, rotation, height) in movers() {
                for speed in [1.0, 5.0, 20.0] {
                    let mut world = World::default();
                    let mut tiles = tiles(0.0);
                    // Between tiles, flush with their sides and as deep as they are.
                    for tile in &mut tiles {
                        let at = tile.pose.position;
                        if at.x > 3.0 {
                            let half = 0.5 * (1.0 + rise);
                            *tile = surface(Shape::box_half([0.5, half, 0.5]), 0.0)
                                .with_position(vec3(at.x, half - 1.0, at.z));
                        }
                    }
                    floor(&mut world, tiles, one_body);
                    let flat = matches!(shape, Shape::Box { .. }) || rotation == Quat::IDENTITY;
                    let round = matches!(shape, Shape::Sphere { .. });
                    let shape =
                        surface(shape.clone(), 0.0).with_pose(Pose::new(Vec3::ZERO, rotation));
                    let v = vec3(speed, 0.0, 0.0);
                    let id = add(&mut world, shape, vec3(1.3, height, 0.13), v);
                    let mut most = 0.0_f32;
                    for _ in 0..120 {
                        world.step(DT);
                        most = most.max(world.audit().penetration.max);
                    }
                    let x = world.body(id).unwrap().position().x;
                    // Upright sides stop; round ones stop at what is higher than their middle.
                    if rise > 1.0 || (flat && !round && speed < 2.0) {
                        assert!(x < 3.0, "{rise} {rotation:?} {height} {speed}: {x}");
                    }
                    assert!(most < 0.02, "{rise} {rotation:?} {height} {speed}: {most}");
                }
            }
        }
    }
}
