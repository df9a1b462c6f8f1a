//! Benchmark scenes that Box3D's own benchmark program has, with the same bodies: gravity 10 m/s²,
//! 60 steps a second, density 1000 kg/m³, friction 0.6 where nothing else is said.

use core::f32::consts::TAU;

use drystone::joint::Ball;
use drystone::math::trig;
use drystone::{BodyDef, Filter, Material, ShapeDef, Vec3, vec3};

use super::parameters::{CatalogError, Values};
use super::parts::{
    GROUND, Lcg, add_ground_box, box_at, cos_sin, gravity_10, grid_mesh, hull, radians, real,
};
use crate::scene::{Scene, SceneBody, SceneJoint, Script};

/// Adds a 2D pyramid of touching cubes of half extent 0.5 m whose lowest row has `base` cubes and
/// whose bottom left corner is at (`left`, 0, `z`) [m].
fn add_pyramid(scene: &mut Scene, name: &str, base: usize, (left, z): (f32, f32), cube: &BodyDef) {
    for i in 0..base {
        let y = (2.0 * real(i) + 1.0) * 0.5;
        for j in i..base {
            let x = (real(i) + 1.0) * 0.5 + real(j - i) + left;
            let number = j - i;
            let def = cube.clone().with_position(vec3(x, y, z));
            scene.add(format!("{name}{i}/{number}"), def);
        }
    }
}

fn light_cube() -> BodyDef {
    BodyDef::dynamic().with_shape(ShapeDef::box_half(Vec3::splat(0.5)).with_density(100.0))
}

pub(super) fn pyramid(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    let base = values.whole("base");
    scene.seconds = 20.0;
    let half = (real(base) * 2.0).max(40.0);
    add_ground_box(&mut scene, half, 40.0);
    let cube = BodyDef::dynamic().with_shape(ShapeDef::box_half(Vec3::splat(0.5)));
    add_pyramid(&mut scene, "cube ", base, (-0.5 * real(base), 0.0), &cube);
    Ok(scene)
}

pub(super) fn large_pyramid(mut scene: Scene, _: &Values) -> Result<Scene, CatalogError> {
    gravity_10(&mut scene);
    scene.seconds = 200.0 / 60.0;
    scene.config.sleep.enabled = false;
    add_ground_box(&mut scene, 400.0, 400.0);
    add_pyramid(&mut scene, "cube ", 100, (-50.0, 0.0), &light_cube());
    Ok(scene)
}

pub(super) fn many_pyramids(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    const BASE: usize = 10;
    let side = values.whole("side");
    gravity_10(&mut scene);
    scene.seconds = 100.0 / 60.0;
    let ground = 0.5 * real(side) * real(BASE + 1);
    add_ground_box(&mut scene, ground, ground);
    let cube = BodyDef { can_sleep: false, ..light_cube() };
    for row in 0..side {
        let way = if side > 1 { real(row) * (2.0 * (ground - 1.0) / real(side - 1)) } else { 0.0 };
        let z = -ground + 1.0 + way;
        for column in 0..side {
            let center = -ground + real(column) * real(BASE + 1) + 1.0;
            add_pyramid(&mut scene, &format!("{row}/{column}/"), BASE, (center - 0.5, z), &cube);
        }
    }
    Ok(scene)
}

pub(super) fn convex_pile(mut scene: Scene, _: &Values) -> Result<Scene, CatalogError> {
    gravity_10(&mut scene);
    scene.seconds = 500.0 / 60.0;
    add_ground_box(&mut scene, 250.0, 250.0);
    let mut random = Lcg::new(42);
    let mut points = Vec::new();
    while points.len() < 32 {
        let p = vec3(random.centered_low(), random.centered_low(), random.centered_low());
        if p.length_squared() <= 0.25
            && let Some(direction) = p.try_normalize()
        {
            points.push(direction * 2.0);
        }
    }
    let rock = BodyDef::dynamic().with_shape(ShapeDef::new(hull(&points)?));
    for layer in 0..80 {
        for ix in 0..8 {
            for iz in 0..8 {
                let (x, z) = ((real(ix) - 4.0) * 4.0, (real(iz) - 4.0) * 4.0);
                let def = rock.clone().with_position(vec3(x, 2.0 + 4.0 * real(layer), z));
                scene.add(format!("rock {layer}/{ix}/{iz}"), def);
            }
        }
    }
    Ok(scene)
}

pub(super) fn joint_grid(mut scene: Scene, _: &Values) -> Result<Scene, CatalogError> {
    const SIDE: usize = 100;
    gravity_10(&mut scene);
    scene.seconds = 100.0 / 60.0;
    scene.config.sleep.enabled = false;
    let ball = ShapeDef::sphere(0.4).with_filter(Filter::layers(2, !2));
    let mut join = Vec::new();
    for column in 0..SIDE {
        for row in 0..SIDE {
            let def = if row == 0 { BodyDef::fixed() } else { BodyDef::dynamic() };
            let def =
                def.with_position(vec3(real(column), -real(row), 0.0)).with_shape(ball.clone());
            let this = scene.add(format!("ball {column}/{row}"), def);
            if row > 0 {
                join.push(((this - 1, vec3(0.0, -0.5, 0.0)), (this, vec3(0.0, 0.5, 0.0))));
            }
            // The balls of the top row are fixed.
            if column > 0 && row > 0 {
                join.push(((this - SIDE, vec3(0.5, 0.0, 0.0)), (this, vec3(-0.5, 0.0, 0.0))));
            }
        }
    }
    let joint = |(a, b)| SceneJoint::new(a, b, Ball::new());
    scene.joints = join.into_iter().map(joint).collect();
    Ok(scene)
}

/// The corners of a prism along y with `sides` sides, from `bottom` to `top` [m].
fn prism(sides: usize, radius: f32, bottom: f32, top: f32) -> Vec<Vec3> {
    let corner = |i: usize, y: f32| {
        let (c, s) = cos_sin(TAU * real(i) / real(sides));
        vec3(radius * c, y, radius * s)
    };
    (0..sides).flat_map(|i| [corner(i, bottom), corner(i, top)]).collect()
}

pub(super) fn junkyard(mut scene: Scene, _: &Values) -> Result<Scene, CatalogError> {
    gravity_10(&mut scene);
    scene.seconds = 500.0 / 60.0;
    let mut yard = BodyDef::fixed()
        .with_position(vec3(0.0, -1.0, 0.0))
        .with_shape(ShapeDef::box_half(vec3(120.0, 1.0, 120.0)));
    for side in [50.0, -50.0] {
        let wall = ShapeDef::box_half(vec3(1.0, 8.0, 50.0));
        yard = yard.with_shape(wall.with_position(vec3(side, 8.0, 0.0)));
    }
    for side in [50.0, -50.0] {
        let wall = ShapeDef::box_half(vec3(50.0, 8.0, 1.0));
        yard = yard.with_shape(wall.with_position(vec3(0.0, 8.0, side)));
    }
    scene.add(GROUND, yard);

    let golden_angle = TAU / (0.5 * (1.0 + 5.0_f32.sqrt()));
    let points: Vec<Vec3> = (0..10)
        .map(|i| {
            let z = 1.0 - (2.0 * real(i) + 1.0) / 10.0;
            let r = (1.0 - z * z).sqrt();
            let (c, s) = cos_sin(real(i) * golden_angle);
            vec3(r * c, r * s, z) * 1.5
        })
        .collect();
    let rock = BodyDef::dynamic().with_shape(ShapeDef::new(hull(&points)?));
    for iy in 0..24 {
        for ix in 0..21 {
            for iz in 0..21 {
                let (x, y, z) =
                    (real(ix) * 4.0 - 40.0, real(iy) * 4.0 + 25.0, real(iz) * 4.0 - 40.0);
                scene
                    .add(format!("rock {iy}/{ix}/{iz}"), rock.clone().with_position(vec3(x, y, z)));
            }
        }
    }
    let pillar = ShapeDef::new(hull(&prism(16, 4.0, 0.0, 24.0))?);
    let pusher = BodyDef::kinematic().with_position(vec3(35.0, 0.0, 0.0)).with_shape(pillar);
    let body = scene.add("pusher", pusher);
    scene.script = Script::Orbit { body, center: Vec3::ZERO, radius: 35.0, degrees_per_step: -0.1 };
    Ok(scene)
}

pub(super) fn large_world(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    let side = values.whole("tiles");
    gravity_10(&mut scene);
    scene.seconds = 500.0 / 60.0;
    let origin = -5.0 * real(side);
    let tile = BodyDef::fixed().with_shape(ShapeDef::box_half(vec3(5.0, 0.25, 5.0)));
    let center = |i: usize| origin + 10.0 * (real(i) + 0.5);
    scene.bodies.reserve_exact(side * side);
    for i in 0..side {
        for j in 0..side {
            let def = tile.clone().with_position(vec3(center(i), 0.0, center(j)));
            scene.add(format!("tile {i}/{j}"), def);
        }
    }
    // A 10 × 10 grid over the inner 80 % of the floor; the last of its 100 cells stays empty.
    let cell = |i: usize| 0.8 * origin + (real(i) + 0.5) * (-0.16 * origin);
    let ball = |s: usize| SceneBody {
        name: format!("ball {s}"),
        def: BodyDef::dynamic()
            .with_position(vec3(cell(s % 10), 1.5, cell(s / 10)))
            .with_shape(ShapeDef::sphere(0.5)),
    };
    scene.script = Script::Drop { every: 5, bodies: (0..99).map(ball).collect() };
    Ok(scene)
}

pub(super) fn trees100(scene: Scene, _: &Values) -> Result<Scene, CatalogError> {
    trees(scene, 1)
}

pub(super) fn trees50(scene: Scene, _: &Values) -> Result<Scene, CatalogError> {
    trees(scene, 2)
}

pub(super) fn trees25(scene: Scene, _: &Values) -> Result<Scene, CatalogError> {
    trees(scene, 4)
}

fn trees(mut scene: Scene, cells_per_meter: u16) -> Result<Scene, CatalogError> {
    let cell = 1.0 / f32::from(cells_per_meter);
    gravity_10(&mut scene);
    scene.seconds = 500.0 / 60.0;
    scene.config.sleep.speed = 0.2;
    let scale = u32::from(cells_per_meter);
    let field = grid_mesh((150 * scale, 200 * scale), |i, j| {
        let (x, z) = (cell * i as f32, cell * j as f32);
        let (wave_x, _) = trig::sin_cos(TAU * 0.1 * x);
        let (wave_z, _) = trig::sin_cos(TAU * 0.05 * z);
        vec3(x - 75.0, 0.4 * wave_x * wave_z, z - 100.0)
    })?;
    scene.add(GROUND, BodyDef::fixed().with_shape(ShapeDef::new(field)));

    let bark = Material { friction: 0.9, rolling_resistance: 0.05, ..Material::default() };
    let mut tree = BodyDef::dynamic();
    let (mut radius, mut y) = (0.75_f32, 1.0_f32);
    let (mut volume, mut moment) = (0.0, 0.0);
    for _ in 0..22 {
        let height = 1.5 + 2.0 * radius;
        let bottom = y - radius;
        let log = hull(&prism(6, radius, bottom, bottom + height))?;
        tree = tree.with_shape(ShapeDef::new(log).with_density(1.0).with_material(bark));
        let share = radius * radius * height;
        volume += share;
        moment += share * (bottom + 0.5 * height);
        y += height;
        radius *= 0.95;
    }
    // Each turns about its foot: its center moves by ω × (0, center, 0).
    let center = moment / volume;
    for b in 0..50 {
        let speed = 0.5 * (0.5 + 0.5 * real(b) / 50.0);
        let spin = if b % 2 == 0 { -speed } else { speed };
        let def = tree
            .clone()
            .with_position(vec3(0.0, 1.0, -70.0 + 3.0 * real(b)))
            .with_angular_velocity(vec3(0.0, 0.0, spin))
            .with_linear_velocity(vec3(-spin * center, 0.0, 0.0));
        scene.add(format!("tree {b}"), def);
    }
    Ok(scene)
}

pub(super) fn washer(mut scene: Scene, _: &Values) -> Result<Scene, CatalogError> {
    gravity_10(&mut scene);
    scene.seconds = 1000.0 / 60.0;
    add_ground_box(&mut scene, 60.0, 60.0);
    let segment = |(inner, outer): (f32, f32), from: f32, to: f32| {
        let (u, v) = (cos_sin(radians(from)), cos_sin(radians(to)));
        let corners = [(inner, u), (outer, u), (inner, v), (outer, v)];
        let at = |z: f32| corners.map(|(r, (c, s))| vec3(r * c, r * s, z));
        hull(&[at(-10.0), at(10.0)].concat()).map(ShapeDef::new)
    };
    let mut drum = BodyDef::kinematic()
        .with_position(vec3(0.0, 21.0, 0.0))
        .with_linear_velocity(vec3(0.001, -0.002, 0.0))
        .with_angular_velocity(vec3(0.0, 0.0, radians(25.0)));
    for i in 0..36 {
        let angle = 10.0 * real(i);
        drum = drum.with_shape(segment((16.0, 18.0), angle - 1.0, angle + 11.0)?);
        if i % 9 == 0 {
            drum = drum.with_shape(segment((14.0, 16.0), angle, angle + 10.0)?);
        }
    }
    scene.add("drum", drum);
    for i in 0..20 {
        for j in 0..20 {
            for k in 0..20 {
                let (x, y, z) = (0.8 * real(i) - 8.0, 0.8 * real(j) + 13.0, 0.8 * real(k) - 8.0);
                scene.add(format!("cube {i}/{j}/{k}"), box_at(Vec3::splat(0.2), vec3(x, y, z)));
            }
        }
    }
    Ok(scene)
}
