//! Overlaps are pushed out, and what was pushed out keeps no speed of it.

use drystone::{AxisLocks, BodyDef, BodyId, ShapeDef, Vec3, World, WorldConfig, vec3};

/// Lengths of the scenes over those of boxes of a meter: none must be special.
const SIZES: [f32; 3] = [0.1, 1.0, 10.0];
const RATES: [u8; 3] = [30, 60, 120];

fn weightless() -> World {
    World::new(WorldConfig { gravity: Vec3::ZERO, ..WorldConfig::default() }).unwrap()
}

fn fastest(world: &World) -> f32 {
    world.bodies().map(|b| b.linear_velocity().length()).fold(0.0, f32::max)
}

fn speed(world: &World, body: BodyId) -> f32 {
    world.body(body).unwrap().linear_velocity().length()
}

/// A crate, a ball or a capsule lies in a wall or a crate twice its size, by a part of its own size.
fn each_overlap(mut check: impl FnMut(World, BodyId, f32, f32, &str)) {
    for (size, rate) in SIZES.into_iter().flat_map(|size| RATES.map(|rate| (size, rate))) {
        let r = 0.3 * size;
        let shapes = [
            ShapeDef::box_half([r, 2.0 * r, r]),
            ShapeDef::sphere(r),
            ShapeDef::capsule(1.5 * r, r),
        ];
        for (shape, is_fixed) in shapes.iter().flat_map(|shape| [(shape, true), (shape, false)]) {
            for depth in [0.01, 0.1, 0.45] {
                let mut world = weightless();
                let wall = if is_fixed { BodyDef::fixed() } else { BodyDef::dynamic() };
                let wall = wall.with_position([size, 0.0, 0.0]);
                world.add_body(wall.with_shape(ShapeDef::box_half([size; 3]))).unwrap();
                let mut body = BodyDef::dynamic().with_position([depth * size - r, 0.0, 0.0]);
                // How it is pushed is then no matter of the lever.
                body.locks = AxisLocks::ROTATION;
                let body = world.add_body(body.with_shape(shape.clone())).unwrap();
                let what = format!("{depth} of {size} m, {rate} Hz, fixed {is_fixed}");
                check(world, body, 1.0 / f32::from(rate), r, &what);
            }
        }
    }
}

#[test]
fn what_is_pushed_out_of_an_overlap_does_not_go_on() {
    each_overlap(|mut world, body, dt, r, what| {
        let most = world.config().contact.push_speed;
        let gap = |world: &World| {
            let wall = world.bodies().next().unwrap().position().x;
            // The wall's near side is as far from its middle as the world is from the wall at the start.
            wall - world.body(body).unwrap().position().x
        };
        let mut steps = 0;
        while dt * f32::from(steps) < 4.0_f32 {
            world.step(dt);
            steps += 1_u16;
            assert!(speed(&world, body) <= most, "{what}: {} m/s", speed(&world, body));
        }
        let before = gap(&world);
        for _ in 0..60 {
            world.step(dt);
        }
        // A push that went on would part them by another r; this is a hundredth of what was the least before.
        assert!(gap(&world) - before < 0.01 * r.max(0.25), "{what}: {} m", gap(&world) - before);
    });
}

#[test]
fn what_is_deep_in_a_wall_comes_out() {
    each_overlap(|mut world, body, dt, r, what| {
        let wall = world.bodies().next().unwrap().position().x;
        let needed = wall + r;
        // By half in 0.06 s down to what speeds push out, 4 cm at 0.25 m/s at most, then by a twentieth of a second for
        // each part of e, to a tenth of a millimeter.
        let mut time = 0.0;
        while time < 3.0 {
            world.step(dt);
            time += dt;
        }
        let wall = world.bodies().next().unwrap().position().x;
        let is = wall - world.body(body).unwrap().position().x;
        // What creeps more slowly than a sleeper may is left.
        assert!(is > needed - 0.01, "{what}: {is} of {needed}");
    });
}

#[test]
fn many_bodies_in_one_place_are_not_thrown() {
    for (size, rate) in SIZES.into_iter().flat_map(|size| RATES.map(|rate| (size, rate))) {
        for shape in [ShapeDef::box_half([0.5 * size; 3]), ShapeDef::sphere(0.5 * size)] {
            for count in [2_u8, 5, 20] {
                let mut world = weightless();
                for _ in 0..count {
                    world.add_body(BodyDef::dynamic().with_shape(shape.clone())).unwrap();
                }
                let most = world.config().contact.push_speed;
                for _ in 0..5 * u32::from(rate) {
                    world.step(1.0 / f32::from(rate));
                    // In a row each pair parts at no more than the greatest speed; the middle stays.
                    let now = fastest(&world);
                    let most = 0.5 * f32::from(count) * most;
                    assert!(now < most, "{count} of {size} m at {rate} Hz: {now} m/s");
                }
            }
        }
    }
}

#[test]
fn a_stack_that_was_made_too_dense_is_not_thrown_off_its_ground() {
    for (size, rate) in SIZES.into_iter().flat_map(|size| RATES.map(|rate| (size, rate))) {
        for count in [2_u8, 3, 6] {
            let mut world = World::default();
            let ground = ShapeDef::half_space([0.0, 1.0, 0.0], 0.0);
            world.add_body(BodyDef::fixed().with_shape(ground)).unwrap();
            let crates: Vec<BodyId> = (0..count)
                .map(|i| {
                    // Each is in the one below it by half.
                    let at = vec3(0.0, (0.5 + 0.5 * f32::from(i)) * size, 0.0);
                    let shape = ShapeDef::box_half([0.5 * size; 3]);
                    world.add_body(BodyDef::dynamic().with_position(at).with_shape(shape)).unwrap()
                })
                .collect();
            let top = crates[crates.len() - 1];
            for _ in 0..10 * u32::from(rate) {
                world.step(1.0 / f32::from(rate));
                let height = world.body(top).unwrap().position().y;
                // Where it stands at last, and what the greatest speed of push-out of each pair below lifts: n² v²/2g.
                let thrown = f32::from(count) * world.config().contact.push_speed;
                let most = (f32::from(count) - 0.5) * size + thrown * thrown / (2.0 * 9.81);
                assert!(
                    height < most + 1.0e-3 * size,
                    "{count} of {size} m at {rate} Hz: {height}"
                );
            }
        }
    }
}
