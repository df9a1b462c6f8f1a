//! Many small islands of different contacts. Their distribution into the workers' groups, and the
//! contacts that share a block, must not affect the result.

use std::sync::Arc;

use drystone::threads::Team;
use drystone::{BodyDef, Material, Mesh, Shape, ShapeDef, Vec3, World, WorldConfig, vec3};

const DT: f32 = 1.0 / 60.0;

/// Material number `i`: bouncing, rolling, spinning, slippery in motion, or plain.
fn material(i: u32) -> Material {
    let plain = Material::default();
    match i % 5 {
        0 | 4 => Material { restitution: 0.6, ..plain },
        1 => Material { restitution: 0.9, rolling_resistance: 0.05, ..plain },
        2 => Material { kinetic_friction: Some(0.2), ..plain },
        3 => Material { spinning_resistance: 0.02, restitution: 0.3, ..plain },
        _ => plain,
    }
}

/// Triangle waves, 1 m wide.
fn waves(cells: u32) -> Shape {
    let height = |i: u32, j: u32| if (i + j).is_multiple_of(2) { 0.0 } else { 0.3 };
    let mut vertices: Vec<Vec3> = Vec::new();
    for j in 0..=cells {
        for i in 0..=cells {
            vertices.push(vec3(i as f32, height(i, j), j as f32));
        }
    }
    let at = |i: u32, j: u32| j * (cells + 1) + i;
    let mut triangles = Vec::new();
    for j in 0..cells {
        for i in 0..cells {
            triangles.push([at(i, j), at(i, j + 1), at(i + 1, j)]);
            triangles.push([at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)]);
        }
    }
    Shape::Mesh(Arc::new(Mesh::new(vertices, triangles).unwrap()))
}

/// 16 × 16 columns of five bodies that fall fast, half of them onto a mesh and half onto a floor
/// with a belt.
fn heaps(workers: usize) -> World {
    let mut world = World::default().with_executor(Arc::new(Team::with_threads(workers)));
    let bouncy = Material { restitution: 0.6, ..Material::default() };
    let mesh = ShapeDef::new(waves(60)).with_material(bouncy);
    world.add_body(BodyDef::fixed().with_shape(mesh)).unwrap();
    let floor = ShapeDef::box_half([30.0, 1.0, 30.0]).with_surface_velocity([0.5, 0.0, 0.0]);
    let floor = floor.with_position([-31.0, -1.0, 30.0]);
    world.add_body(BodyDef::fixed().with_shape(floor)).unwrap();
    for heap in 0..256_u32 {
        let (i, j) = (heap % 16, heap / 16);
        let at = vec3(3.6 * i as f32 - 27.0, 0.0, 3.6 * j as f32 + 2.0);
        for k in 0..5_u32 {
            let shape = match (heap + 3 * k) % 7 {
                0 | 1 => ShapeDef::sphere(0.4),
                2 => ShapeDef::capsule(0.3, 0.3),
                3 => ShapeDef::cylinder(0.3, 0.35),
                _ => ShapeDef::box_half([0.35, 0.3, 0.4]),
            };
            let tilt = 0.13 * ((heap + k) % 11) as f32;
            let body = BodyDef::dynamic()
                .with_position(at + vec3(0.1 * (k % 2) as f32, 0.9 + 0.8 * k as f32, 0.07))
                .with_angular_velocity([tilt, 0.5 - tilt, 1.0])
                .with_linear_velocity([0.0, -15.0 - tilt, 0.3])
                .with_shape(shape.with_material(material(heap / 3 + k)));
            world.add_body(body).unwrap();
        }
    }
    world
}

/// Takes a step in each world; all must have the same bits after it, and report the same.
fn step_alike(worlds: &mut [World], step: u32) {
    for world in &mut *worlds {
        world.step(DT);
    }
    let hashes: Vec<u64> = worlds.iter().map(World::state_hash).collect();
    assert!(hashes.iter().all(|hash| *hash == hashes[0]), "step {step}: {hashes:x?}");
    let events = worlds[0].events();
    assert!(worlds.iter().all(|world| world.events() == events), "step {step}");
}

#[test]
fn how_islands_are_grouped_does_not_show() {
    let mut worlds: Vec<World> = [1, 2, 4].map(heaps).into();
    for step in 0..40 {
        step_alike(&mut worlds, step);
    }
    // Enough contacts that one worker's groups differ from those of two, which take at least 600
    // contacts of two bodies.
    let contacts = worlds[0].counts().contacts;
    assert!(contacts > 800, "{contacts}");
}

/// Balls and boxes side by side that fly at their middle and bounce. They are one island shared by
/// all workers, in which most bodies are hit, many at once, at one point and at four.
fn crush(workers: usize) -> World {
    let config = WorldConfig { gravity: Vec3::ZERO, ..WorldConfig::default() };
    let mut world =
        World::new(config).unwrap().with_executor(Arc::new(Team::with_threads(workers)));
    for i in 0..512_u32 {
        let at = vec3((i % 8) as f32, (i / 8 % 8) as f32, (i / 64) as f32) - Vec3::ONE * 3.5;
        let shape = match i % 3 {
            0 => ShapeDef::sphere(0.5),
            _ => ShapeDef::box_half([0.49, 0.5, 0.48]),
        };
        let body = BodyDef::dynamic()
            .with_position(at * 1.002)
            .with_linear_velocity(at * -(2.0 + 0.1 * (i % 7) as f32))
            .with_shape(shape.with_material(material(i)));
        world.add_body(body).unwrap();
    }
    world
}

#[test]
fn how_many_workers_share_an_island_does_not_show() {
    let mut worlds: Vec<World> = [1, 2, 3, 4].map(crush).into();
    let (mut contacts, mut hits) = (0, 0);
    for step in 0..30 {
        step_alike(&mut worlds, step);
        contacts = worlds[0].counts().contacts.max(contacts);
        hits += worlds[0].events().hits.len();
    }
    // Workers share an island from 1,024 contact ends on.
    assert!(contacts > 1000 && hits > 500, "{contacts} contacts, {hits} hits");
}
