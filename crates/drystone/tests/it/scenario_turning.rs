//! Bodies that rotate far in a step while touching, bodies smaller than the contact margin, and
//! bodies at rest while steps change their length: docs/decisions/033-rows-made-anew.md.

use std::sync::Arc;

use drystone::{BodyDef, BodyId, Hull, Mesh, Quat, Shape, ShapeDef, Vec3, World, vec3};

/// A sequence of random numbers from 0 to 1.
struct Numbers(u32);

impl Numbers {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        #[expect(clippy::cast_precision_loss, reason = "24 bits")]
        let number = (self.0 >> 8) as f32;
        number / 16_777_216.0
    }

    fn vector(&mut self) -> Vec3 {
        vec3(self.next() - 0.5, self.next() - 0.5, self.next() - 0.5)
    }
}

/// Ground at height 0 with this half width.
fn floor(kind: &str, half: f32) -> BodyDef {
    let shape = match kind {
        "half-space" => ShapeDef::half_space([0.0, 1.0, 0.0], 0.0),
        "box" => ShapeDef::box_half([half, half, half]).with_position([0.0, -half, 0.0]),
        _ => {
            let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
            let corners = corners.map(|[x, z]| vec3(x * half, 0.0, z * half)).to_vec();
            let mesh = Mesh::new(corners, vec![[0, 2, 1], [0, 3, 2]]).unwrap();
            ShapeDef::new(Shape::Mesh(Arc::new(mesh)))
        }
    };
    BodyDef::fixed().with_shape(shape.with_friction(0.5))
}

const FLOORS: [&str; 3] = ["half-space", "box", "mesh"];

fn energy(world: &World) -> f64 {
    world.kinetic_energy() + world.potential_energy()
}

#[test]
fn sticks_and_coins_that_are_thrown_make_no_energy() {
    let mut numbers = Numbers(7);
    for scale in [0.05_f32, 1.0, 10.0] {
        let l = 0.5 * scale;
        let shapes = [
            ShapeDef::capsule(l, 0.04 * l),
            ShapeDef::box_half([0.04 * l, l, 0.06 * l]),
            ShapeDef::cylinder(l, 0.06 * l),
            ShapeDef::cylinder(0.03 * l, 0.5 * l),
        ];
        for kind in FLOORS {
            for shape in &shapes {
                let mut world = World::default();
                world.add_body(floor(kind, 60.0 * scale)).unwrap();
                let speed = (2.0 + 6.0 * numbers.next()) * scale.sqrt();
                let body = BodyDef::dynamic()
                    .with_position([0.0, 1.3 * l, 0.0])
                    .with_rotation(Quat::from_rotation_vector(numbers.vector() * 6.0))
                    .with_linear_velocity(numbers.vector() * speed)
                    .with_angular_velocity(numbers.vector() * (10.0 / scale.sqrt()))
                    .with_shape(shape.clone().with_friction(0.5));
                let body = world.add_body(body).unwrap();
                let start = energy(&world);
                let weight = f64::from(world.body(body).unwrap().mass() * 9.81);
                for _ in 0..240 {
                    world.step(1.0 / 60.0);
                    // A contact may lift the body by a fiftieth of its length.
                    let most = start + weight * f64::from(0.02 * l);
                    assert!(
                        energy(&world) <= most,
                        "{kind}, {scale}: {} of {start}",
                        energy(&world)
                    );
                }
                let low = world.body(body).unwrap().position().y;
                assert!(low > 0.0, "{kind}, {scale}: through the floor, {low}");
            }
        }
    }
}

/// Height of the lowest corner of a body with these corners [m].
fn lowest(world: &World, body: BodyId, corners: &[Vec3]) -> f32 {
    let pose = world.body(body).unwrap().pose();
    corners.iter().map(|p| pose.point(*p).y).fold(f32::MAX, f32::min)
}

#[test]
fn hulls_of_many_corners_that_roll_sink_nowhere() {
    let mut numbers = Numbers(1);
    for (number, kind) in FLOORS.iter().cycle().take(24).enumerate() {
        let flat = if number % 2 == 0 { 0.05 } else { 0.25 };
        let mut corners = Vec::new();
        while corners.len() < 24 {
            let p = numbers.vector() * 2.0;
            let length = p.length();
            if length > 0.1 && length < 1.0 {
                corners.push(vec3(flat * p.x, 0.5 * p.y, 0.5 * p.z) * (1.0 / length));
            }
        }
        let hull = Shape::Hull(Arc::new(Hull::from_points(&corners).unwrap()));
        let low = corners.iter().map(|p| p.y).fold(f32::MAX, f32::min);
        let mut world = World::default();
        world.add_body(floor(kind, 30.0)).unwrap();
        let body = BodyDef::dynamic().with_position([0.0, 0.3 - low, 0.0]).with_mass(1.0);
        let body = world.add_body(body.with_shape(ShapeDef::new(hull))).unwrap();
        for step in 0..300 {
            world.step(1.0 / 60.0);
            // One hundredth of its size; a corner arrives at up to 2.4 m/s, or 5 mm per substep. A
            // body that only rocks gets new points in the middle of the step, after half the
            // rotation.
            let least = if step < 240 { -0.01 } else { -0.005 };
            let low = lowest(&world, body, &corners);
            assert!(low > least, "hull {number} on {kind}, step {step}: {low}");
        }
    }
}

#[test]
fn cubes_thinner_than_the_margin_stand_on_each_other() {
    for side in [0.005_f32, 0.01, 0.018] {
        for kind in FLOORS {
            let mut world = World::default();
            world.add_body(floor(kind, 1.0)).unwrap();
            let cubes = [0.5, 1.5, 2.5].map(|height| {
                let cube = BodyDef::dynamic().with_position([0.0, height * side, 0.0]);
                world.add_body(cube.with_shape(ShapeDef::box_half([0.5 * side; 3]))).unwrap()
            });
            for _ in 0..300 {
                world.step(1.0 / 60.0);
            }
            // Contacts of 54 and 108 Hz yield by g/ω² and g/4ω² for each cube above: 0.09 and 0.02
            // mm, in total 0.4 mm at the top.
            for (cube, height) in cubes.into_iter().zip([0.5, 1.5, 2.5]) {
                let y = world.body(cube).unwrap().position().y;
                let least = height * side - 0.0005_f32.min(0.3 * side);
                assert!(y > least && y < (height + 0.2) * side, "{side} on {kind}: {y}");
            }
        }
    }
}

#[test]
fn what_rests_stays_at_rest_as_time_slows_down_and_goes_on() {
    for kind in FLOORS {
        let mut world = World::default();
        world.add_body(floor(kind, 30.0)).unwrap();
        let boxes = [0.5, 1.5, 2.5, 3.5, 4.5].map(|y| {
            let body = BodyDef { can_sleep: false, ..BodyDef::dynamic() };
            let shape = ShapeDef::box_half([0.5; 3]);
            world.add_body(body.with_position([0.0, y, 0.0]).with_shape(shape)).unwrap()
        });
        for _ in 0..120 {
            world.step(1.0 / 60.0);
        }
        let rest = boxes.map(|body| world.body(body).unwrap().position().y);
        for slower in [1.0_f32, 10.0, 100.0, 10.0, 1.0, 2.0, 0.5, 1.0] {
            for _ in 0..60 {
                world.step(1.0 / 60.0 / slower);
            }
            for (body, rest) in boxes.into_iter().zip(rest) {
                let body = world.body(body).unwrap();
                let (y, v) = (body.position().y, body.linear_velocity().length());
                // The stack yields by 1.3 mm in total under its weight, and each of its contacts
                // rests within 0.05 mm.
                let most = 0.0013 + 5.0 * 5.0e-5;
                assert!((y - rest).abs() < most, "{kind}, {slower} times slower: {y} for {rest}");
                assert!(v < 0.02, "{kind}, {slower} times slower: {v} m/s");
            }
        }
    }
}
