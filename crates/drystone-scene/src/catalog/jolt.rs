//! Benchmark scenes of Jolt's performance test, with the same bodies. Unless a scene says
//! otherwise: gravity 9.81 m/s², 60 steps a second, density 1000 kg/m³, friction 0.2 and damping
//! 0.05 1/s.

use drystone::math::trig;
use drystone::{BodyDef, Material, ShapeDef, Vec3, vec3};

use super::parameters::{CatalogError, Values};
use super::parts::{GROUND, Lcg, grid_mesh, hull, real};
use crate::scene::Scene;

fn jolt_settings(scene: &mut Scene) {
    scene.seconds = 500.0 / 60.0;
    scene.config.sleep.speed = 0.03;
}

fn damped() -> BodyDef {
    BodyDef { linear_damping: 0.05, angular_damping: 0.05, ..BodyDef::dynamic() }
}

pub(super) fn pyramid(mut scene: Scene, _: &Values) -> Result<Scene, CatalogError> {
    jolt_settings(&mut scene);
    let floor = ShapeDef::box_half(vec3(50.0, 1.0, 50.0)).with_friction(0.2);
    scene.add(GROUND, BodyDef::fixed().with_position(vec3(0.0, -1.0, 0.0)).with_shape(floor));
    let cube = BodyDef { can_sleep: false, ..damped() }
        .with_shape(ShapeDef::box_half(Vec3::ONE).with_friction(0.2));
    for i in 0..15_usize {
        let shift = if i % 2 == 1 { 1.0 } else { 0.0 };
        let across = i / 2..15 - i.div_ceil(2);
        for j in across.clone() {
            for k in across.clone() {
                let (x, z) = (2.0 * real(j) - 15.0 + shift, 2.0 * real(k) - 15.0 + shift);
                let def = cube.clone().with_position(vec3(x, 1.0 + 2.5 * real(i), z));
                scene.add(format!("cube {i}/{j}/{k}"), def);
            }
        }
    }
    Ok(scene)
}

pub(super) fn convex_vs_mesh(mut scene: Scene, _: &Values) -> Result<Scene, CatalogError> {
    jolt_settings(&mut scene);
    let bouncy = Material { friction: 0.5, restitution: 0.6, ..Material::default() };
    let terrain = grid_mesh((100, 100), |i, j| {
        let (x, z) = (i as f32, j as f32);
        let ((sin_x, _), (_, cos_z)) = (trig::sin_cos(0.5 * x), trig::sin_cos(0.5 * z));
        vec3(3.0 * x, 5.0 * sin_x * cos_z, 3.0 * z)
    })?;
    let ground = BodyDef::fixed()
        .with_position(vec3(-150.0, 5.0, -150.0))
        .with_shape(ShapeDef::new(terrain).with_material(bouncy));
    scene.add(GROUND, ground);
    let tent = [Vec3::Y, Vec3::X, -Vec3::X, Vec3::Z, -Vec3::Z];
    let kinds = [
        ("box", ShapeDef::box_half(vec3(0.5, 0.75, 1.0))),
        ("ball", ShapeDef::sphere(0.5)),
        ("capsule", ShapeDef::capsule(0.75, 0.5)),
        ("tent", ShapeDef::new(hull(&tent)?)),
    ];
    for ix in 0..21 {
        for (iy, (kind, shape)) in kinds.iter().enumerate() {
            for iz in 0..21 {
                let (x, z) = (7.5 * (real(ix) - 10.0), 7.5 * (real(iz) - 10.0));
                let def = damped()
                    .with_position(vec3(x, 15.0 + 2.0 * real(iy), z))
                    .with_shape(shape.clone().with_material(bouncy));
                scene.add(format!("{kind} {ix}/{iz}"), def);
            }
        }
    }
    Ok(scene)
}

/// The mesh is a parameter: the original searches for the largest one that it can hold.
pub(super) fn large_mesh(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    jolt_settings(&mut scene);
    let bouncy = Material { friction: 0.5, restitution: 0.6, ..Material::default() };
    let n = values.whole("n");
    let turn = 50.0 / real(n);
    let cells = u32::try_from(n).unwrap_or(u32::MAX);
    let terrain = grid_mesh((cells, cells), |i, j| {
        let (x, z) = (i as f32, j as f32);
        let ((sin_x, _), (_, cos_z)) = (trig::sin_cos(turn * x), trig::sin_cos(turn * z));
        vec3(x, 50.0 * sin_x * cos_z, z)
    })?;
    let middle = -0.5 * real(n);
    let ground = BodyDef::fixed()
        .with_position(vec3(middle, 0.0, middle))
        .with_shape(ShapeDef::new(terrain).with_material(bouncy));
    scene.add(GROUND, ground);
    let shape = ShapeDef::box_half(vec3(0.5, 0.75, 1.0)).with_material(bouncy);
    for ix in 0..21 {
        for iy in 0..10 {
            for iz in 0..21 {
                let (x, z) = (7.5 * (real(ix) - 10.0), 7.5 * (real(iz) - 10.0));
                let def = damped()
                    .with_position(vec3(x, 55.0 + 2.0 * real(iy), z))
                    .with_shape(shape.clone());
                scene.add(format!("box {ix}/{iy}/{iz}"), def);
            }
        }
    }
    Ok(scene)
}

pub(super) fn high_speed(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    jolt_settings(&mut scene);
    let walls = [
        ("floor", vec3(50.0, 0.2, 50.0), vec3(0.0, -50.0, 0.0)),
        ("ceiling", vec3(50.0, 0.2, 50.0), vec3(0.0, 50.0, 0.0)),
        ("left wall", vec3(0.2, 50.0, 50.0), vec3(-50.0, 0.0, 0.0)),
        ("right wall", vec3(0.2, 50.0, 50.0), vec3(50.0, 0.0, 0.0)),
        ("back wall", vec3(50.0, 50.0, 0.2), vec3(0.0, 0.0, -50.0)),
        ("front wall", vec3(50.0, 50.0, 0.2), vec3(0.0, 0.0, 50.0)),
    ];
    for (name, half, position) in walls {
        let wall = ShapeDef::box_half(half).with_friction(1.0).with_restitution(1.0);
        scene.add(name, BodyDef::fixed().with_position(position).with_shape(wall));
    }
    let mut random = Lcg::new(1);
    for i in 0..values.whole("n") {
        let (kind, shapes) = match i % 3 {
            0 => ("ball", vec![ShapeDef::sphere(0.5)]),
            1 => ("box", vec![ShapeDef::box_half(vec3(0.25, 0.5, 0.5))]),
            _ => (
                "angle",
                vec![
                    ShapeDef::capsule(0.5, 0.125).with_position(vec3(0.0, 0.5, 0.0)),
                    ShapeDef::box_half(vec3(0.5, 0.125, 0.125)).with_position(vec3(0.5, 0.0, 0.0)),
                ],
            ),
        };
        let mut coordinate = || random.between(-45.0, 45.0);
        let position = vec3(coordinate(), coordinate(), coordinate());
        let rotation = random.rotation();
        let velocity = random.direction() * 250.0;
        let friction = random.between(0.5, 1.0);
        let restitution = random.between(0.9, 1.0);
        let material = Material { friction, restitution, ..Material::default() };
        let mut def =
            damped().with_position(position).with_rotation(rotation).with_linear_velocity(velocity);
        def.shapes = shapes.into_iter().map(|s| s.with_material(material)).collect();
        scene.add(format!("{kind} {i}"), def);
    }
    Ok(scene)
}
