//! Every landing is reported once, with its speed.

use drystone::{BodyDef, Quat, ShapeDef, Vec3, World, WorldConfig, vec3};

use crate::floors::square;

const G: f32 = 9.81;

/// A world whose lengths, gravity and hit speed are `scale` times as large, with a floor whose top
/// is at y = 0.
fn floored(floor: &str, scale: f32) -> World {
    let gravity = vec3(0.0, -G, 0.0) * scale;
    let mut config = WorldConfig { gravity, ..WorldConfig::default() };
    config.contact.hit_speed = scale;
    let mut world = World::new(config).unwrap();
    let shape = match floor {
        "plane" => ShapeDef::half_space(Vec3::Y, 0.0),
        "box" => ShapeDef::box_half(vec3(5.0, 1.0, 5.0) * scale)
            .with_position(vec3(0.0, -1.0, 0.0) * scale),
        "ball" => ShapeDef::sphere(2.0 * scale).with_position(vec3(0.0, -2.0, 0.0) * scale),
        _ => square(5.0 * scale),
    };
    world.add_body(BodyDef::fixed().with_shape(shape)).unwrap();
    world
}

#[test]
fn every_landing_has_one_hit_with_its_speed_and_a_begin_that_is_no_later() {
    for (scale, rate) in
        [0.1, 1.0, 100.0].into_iter().flat_map(|s| [30.0_f32, 60.0, 120.0].map(|r| (s, r)))
    {
        for floor in ["plane", "box", "mesh", "ball"] {
            for (name, shape, low) in [
                ("ball", ShapeDef::sphere(0.25 * scale), 0.25),
                ("capsule", ShapeDef::capsule(0.3 * scale, 0.2 * scale), 0.5),
                ("box", ShapeDef::box_half(Vec3::splat(0.25 * scale)), 0.25),
            ] {
                for k in 0..12_u8 {
                    let height = 0.3 + 0.057 * f32::from(k) * f32::from(k);
                    let mut world = floored(floor, scale);
                    let body =
                        BodyDef::dynamic().with_position(vec3(0.0, height + low, 0.0) * scale);
                    world.add_body(body.with_shape(shape.clone())).unwrap();
                    let of = format!("{name} from {height} m on {floor}, {rate} Hz, x{scale}");
                    let (mut begins, mut hits) = (0, 0);
                    let mut time = 0.0;
                    while time < 2.5 {
                        world.step(1.0 / rate);
                        time += 1.0 / rate;
                        begins += world.events().contact_begin.len();
                        for hit in &world.events().hits {
                            let speed = (2.0 * G * height).sqrt();
                            // The solver's substeps, 8 per step, resolve speed in steps of G h, and
                            // lag by half of one.
                            let off = (hit.speed / scale - speed).abs();
                            assert!(off <= G / rate / 8.0, "{of}: {off} m/s off {speed}");
                            hits += 1;
                        }
                        assert!(begins >= hits, "{of}: a hit before the begin");
                    }
                    assert_eq!((begins, hits), (1, 1), "{of}");
                }
            }
        }
    }
}

#[test]
fn a_ball_without_weight_hits_a_wall_from_any_part_of_a_step() {
    for (radius, speed) in
        [0.005, 0.05, 0.5].into_iter().flat_map(|r| [2.0, 5.0, 20.0, 100.0].map(|s| (r, s)))
    {
        for (rate, restitution) in
            [30.0_f32, 60.0, 120.0].into_iter().flat_map(|r| [0.0, 0.5].map(|e| (r, e)))
        {
            for k in 0..20_u8 {
                let mut world =
                    World::new(WorldConfig { gravity: Vec3::ZERO, ..WorldConfig::default() })
                        .unwrap();
                let wall = ShapeDef::box_half([0.25, 3.0, 3.0]).with_position([0.25, 0.0, 0.0]);
                world.add_body(BodyDef::fixed().with_shape(wall)).unwrap();
                let way = 0.1 + speed / rate * 0.103 * f32::from(k);
                let ball = BodyDef::dynamic()
                    .with_position([-radius - way, 0.0, 0.0])
                    .with_linear_velocity([speed, 0.0, 0.0])
                    .with_shape(ShapeDef::sphere(radius).with_restitution(restitution));
                world.add_body(ball).unwrap();
                let (mut begins, mut hits) = (0, Vec::new());
                let steps = way * rate / speed;
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "small"
                )]
                for _ in 0..steps as u32 + 10 {
                    world.step(1.0 / rate);
                    begins += world.events().contact_begin.len();
                    hits.extend(world.events().hits.iter().map(|hit| hit.speed));
                }
                let of =
                    format!("{radius} m at {speed} m/s from {way} m, {rate} Hz, e = {restitution}");
                assert_eq!((begins, hits.len()), (1, 1), "{of}");
                assert!((hits[0] - speed).abs() < 1.0e-5 * speed, "{of}: {} m/s", hits[0]);
            }
        }
    }
}

#[test]
fn balls_hit_balls() {
    for k in 0..40_u8 {
        let mut world =
            World::new(WorldConfig { gravity: Vec3::ZERO, ..WorldConfig::default() }).unwrap();
        let ball = |x: f32, v: f32| {
            let ball =
                BodyDef::dynamic().with_position([x, 0.0, 0.0]).with_shape(ShapeDef::sphere(0.2));
            ball.with_linear_velocity([v, 0.0, 0.0])
        };
        world.add_body(ball(0.0, -0.3)).unwrap();
        world.add_body(ball(-1.0 - 0.0137 * f32::from(k), 5.0)).unwrap();
        let hits: Vec<f32> = (0..40)
            .flat_map(|_| {
                world.step(1.0 / 60.0);
                world.events().hits.iter().map(|hit| hit.speed).collect::<Vec<_>>()
            })
            .collect();
        assert_eq!(hits.len(), 1, "{k}: {hits:?}");
        assert!((hits[0] - 5.3).abs() < 1.0e-4, "{k}: {hits:?}");
    }
}

#[test]
fn what_lies_hits_nothing() {
    let mut world = World::default();
    let floor = ShapeDef::half_space(Vec3::Y, 0.0);
    world.add_body(BodyDef::fixed().with_shape(floor)).unwrap();
    for i in 0..8_u8 {
        // Stacked cubes, and lying sticks and cylinders, with a tiny gap.
        let at = f32::from(i / 2) + 0.001 * f32::from(i);
        let shape =
            if i % 2 == 0 { ShapeDef::box_half([0.5; 3]) } else { ShapeDef::cylinder(0.5, 0.4) };
        let turn = Quat::from_axis_angle(Vec3::Y, 0.3 * f32::from(i));
        let body = BodyDef::dynamic().with_position([3.0 * f32::from(i % 2), 0.5 + at, 0.0]);
        world.add_body(body.with_rotation(turn).with_shape(shape)).unwrap();
    }
    for step in 0..240 {
        world.step(1.0 / 60.0);
        assert!(world.events().hits.is_empty(), "step {step}: {:?}", world.events().hits);
    }
}
