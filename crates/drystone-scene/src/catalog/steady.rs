//! Scenes that ask how steady a method is and how true: loads, mass ratios, limits of friction and
//! of balance. Each has an answer that can be worked out.

use drystone::{BodyDef, Material, Quat, ShapeDef, Vec3, vec3};

use super::parameters::{CatalogError, Values};
use super::parts::{GROUND, add_ground, add_ground_box, box_at, gravity_10, hull, radians, real};
use crate::scene::{Load, Scene, Script};

/// Ground of friction 0.6 under 10 m/s², without sleep, so that creep is seen.
fn wakeful(scene: &mut Scene, seconds: f32) {
    gravity_10(scene);
    scene.seconds = seconds;
    scene.config.sleep.enabled = false;
    add_ground_box(scene, 20.0, 20.0);
}

/// A cube of 1 m at this place.
fn cube_at(position: Vec3) -> BodyDef {
    box_at(Vec3::splat(0.5), position)
}

fn heavy_cube_at(position: Vec3, ratio: f32) -> BodyDef {
    let cube = ShapeDef::box_half(Vec3::splat(0.5)).with_density(1000.0 * ratio);
    BodyDef::dynamic().with_position(position).with_shape(cube)
}

pub(super) fn stack_drop(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    let n = values.whole("n");
    wakeful(&mut scene, 20.0);
    for i in 0..n {
        scene.add(format!("cube {i}"), cube_at(vec3(0.0, 0.5 + real(i), 0.0)));
    }
    let position = vec3(0.0, 0.5 + real(n) + values.number("height"), 0.0);
    scene.add("heavy cube", heavy_cube_at(position, values.number("mass_ratio")));
    Ok(scene)
}

pub(super) fn leaning_stack(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    wakeful(&mut scene, 20.0);
    for i in 0..values.whole("n") {
        let position = vec3(values.number("lean") * real(i), 0.5 + real(i), 0.0);
        scene.add(format!("cube {i}"), cube_at(position));
    }
    Ok(scene)
}

pub(super) fn pushed_stack(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    let n = values.whole("n");
    wakeful(&mut scene, 10.0);
    for i in 0..n {
        let speed = if i >= n / 2 { values.number("speed") } else { 0.0 };
        let def = cube_at(vec3(0.0, 0.5 + real(i), 0.0));
        scene.add(format!("cube {i}"), def.with_linear_velocity(vec3(speed, 0.0, 0.0)));
    }
    Ok(scene)
}

pub(super) fn tiny_pyramid(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    let (base, edge) = (values.whole("base"), values.number("edge"));
    wakeful(&mut scene, 20.0);
    for row in 0..base {
        let y = edge * (0.5 + real(row));
        for i in 0..base - row {
            // A tenth of an edge is air between two of a row.
            let x = 1.1 * edge * (real(i) - 0.5 * real(base - row - 1));
            let def = box_at(Vec3::splat(0.5 * edge), vec3(x, y, 0.0));
            scene.add(format!("cube {row}/{i}"), def);
        }
    }
    Ok(scene)
}

/// The blocks of one story: bases across, and walls on both sides that lie over two bases each.
pub(super) fn kapla(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    const BASES: usize = 8;
    scene.hz = 100.0;
    scene.seconds = 60.0;
    scene.config.sleep.enabled = false;
    let friction = values.number("friction");
    add_ground(&mut scene, friction);
    let block = |half: Vec3| {
        let shape = ShapeDef::box_half(half).with_friction(friction);
        BodyDef::dynamic().with_mass(10.0).with_shape(shape)
    };
    let (base, wall) = (block(vec3(0.025, 0.05, 0.125)), block(vec3(0.1, 0.05, 0.025)));
    for floor in 0..values.whole("floors") {
        let (low, high) = (0.05 + 0.2 * real(floor), 0.15 + 0.2 * real(floor));
        for j in 0..BASES {
            let def = base.clone().with_position(vec3(0.2 * real(j), low, 0.0));
            scene.add(format!("base {floor}/{j}"), def);
        }
        let right = [0.1, 0.5, 0.9, 1.3].map(|x| (x, -0.1));
        let left = [0.3, 0.7, 1.1, 0.1, 1.3].map(|x| (x, 0.1));
        for (k, (x, z)) in right.into_iter().chain(left).enumerate() {
            let def = wall.clone().with_position(vec3(x, high, z));
            scene.add(format!("wall {floor}/{k}"), def);
        }
    }
    Ok(scene)
}

/// A plank over a support of 20 cm, with its middle over that.
fn add_plank(scene: &mut Scene) {
    let support = ShapeDef::box_half(vec3(0.1, 0.5, 0.6));
    scene.add("support", BodyDef::fixed().with_position(0.5 * Vec3::Y).with_shape(support));
    scene.add("plank", box_at(vec3(3.0, 0.1, 0.5), vec3(0.0, 1.1, 0.0)));
}

pub(super) fn seesaw(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    wakeful(&mut scene, 10.0);
    add_plank(&mut scene);
    scene.add("left cube", cube_at(vec3(-2.4, 1.7, 0.0)));
    let right = heavy_cube_at(vec3(2.4, 1.7, 0.0), values.number("mass_ratio"));
    scene.add("right cube", right);
    Ok(scene)
}

pub(super) fn catapult(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    wakeful(&mut scene, 6.0);
    add_plank(&mut scene);
    // It takes its end of the plank down before the other one is hit.
    scene.add("stone", box_at(Vec3::splat(0.25), vec3(-2.6, 1.45, 0.0)));
    let position = vec3(2.4, 1.7 + values.number("height"), 0.0);
    scene.add("weight", heavy_cube_at(position, values.number("mass_ratio")));
    Ok(scene)
}

pub(super) fn truck(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    let (n, ratio) = (values.whole("n"), values.number("top_mass_ratio"));
    let velocity = vec3(values.number("speed"), 0.0, 0.0);
    gravity_10(&mut scene);
    scene.seconds = 10.0;
    scene.config.sleep.enabled = false;
    add_ground(&mut scene, 0.6);
    let bed = BodyDef::kinematic().with_position(vec3(0.0, 1.0, 0.0));
    let bed = bed.with_linear_velocity(velocity);
    scene.add("truck", bed.with_shape(ShapeDef::box_half(vec3(4.0, 0.25, 1.5))));
    for i in 0..n {
        let ratio = if i + 1 == n { ratio } else { 1.0 };
        let def = heavy_cube_at(vec3(0.0, 1.75 + real(i), 0.0), ratio);
        scene.add(format!("cube {i}"), def.with_linear_velocity(velocity));
    }
    Ok(scene)
}

/// Steps that the slabs of `pull` have to settle.
const PULL_FROM: u64 = 30;

/// Both slabs with friction 0.6 under 10 m/s²: 6000 N hold the upper one, 6600 N the lower one.
pub(super) fn pull(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    wakeful(&mut scene, 1.0);
    let slab = |y: f32, mass: f32| box_at(vec3(1.0, 0.1, 1.0), vec3(0.0, y, 0.0)).with_mass(mass);
    let lower = scene.add("lower slab", slab(0.1, 100.0));
    let upper = scene.add("upper slab", slab(0.3, 1000.0));
    let (body, limit) = if values.whole("lower") == 1 { (lower, 6600.0) } else { (upper, 6000.0) };
    // They settle first: friction is limited by the load of the contact now, and that is not the
    // weight before the contact has been pressed together.
    let force = vec3(limit * values.number("factor"), 0.0, 0.0);
    let load = Load { body, force, torque: Vec3::ZERO };
    scene.script = Script::Loads { from: PULL_FROM, loads: vec![load] };
    Ok(scene)
}

pub(super) fn conveyor(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    let speed = values.number("speed");
    gravity_10(&mut scene);
    scene.seconds = 10.0;
    add_ground(&mut scene, 0.6);
    // The part of the belt that has not passed yet lies behind.
    let half_length = 20.0 + 5.0 * speed;
    let belt = BodyDef::kinematic().with_position(vec3(-5.0 * speed, 1.0, 0.0));
    let belt = belt.with_linear_velocity(vec3(speed, 0.0, 0.0));
    scene.add("belt", belt.with_shape(ShapeDef::box_half(vec3(half_length, 0.25, 1.0))));
    let n = values.whole("n");
    for i in 0..n {
        let half = vec3(0.3, 0.15 + 0.05 * real(i % 3), 0.3);
        let x = 1.2 * (real(i) - 0.5 * real(n - 1));
        scene.add(format!("parcel {i}"), box_at(half, vec3(x, 1.25 + half.y, 0.0)));
    }
    Ok(scene)
}

pub(super) fn billiards(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    // A ball of 57.15 mm and 170 g.
    const RADIUS: f32 = 0.028_575;
    const DENSITY: f32 = 1739.4;
    scene.seconds = 8.0;
    let cloth = Material { friction: 0.2, restitution: 0.5, ..Material::default() };
    let cushion = Material { friction: 0.2, restitution: 0.8, ..Material::default() };
    let part = |half: Vec3, position: Vec3, material: Material| {
        ShapeDef::box_half(half).with_position(position).with_material(material)
    };
    let (long, wide, high) = (1.27, 0.635, 0.04);
    let table = BodyDef::fixed()
        .with_shape(part(vec3(1.5, 0.1, 0.9), vec3(0.0, -0.1, 0.0), cloth))
        .with_shape(part(vec3(0.1, high, 0.9), vec3(long + 0.1, high, 0.0), cushion))
        .with_shape(part(vec3(0.1, high, 0.9), vec3(-long - 0.1, high, 0.0), cushion))
        .with_shape(part(vec3(1.5, high, 0.1), vec3(0.0, high, wide + 0.1), cushion))
        .with_shape(part(vec3(1.5, high, 0.1), vec3(0.0, high, -wide - 0.1), cushion));
    scene.add("table", table);
    let surface = Material {
        friction: 0.05,
        restitution: 0.95,
        rolling_resistance: 0.01,
        ..Material::default()
    };
    let ball = ShapeDef::sphere(RADIUS).with_density(DENSITY).with_material(surface);
    let ball = BodyDef::dynamic().with_shape(ball);
    let cue = ball.clone().with_position(vec3(-0.635, RADIUS, 0.0));
    scene.add("cue ball", cue.with_linear_velocity(vec3(values.number("speed"), 0.0, 0.0)));
    let pitch = 2.0 * RADIUS + values.number("gap");
    for row in 0..5 {
        for i in 0..=row {
            // √3/2 from row to row.
            let x = 0.635 + 0.866_025_4 * pitch * real(row);
            let z = pitch * (real(i) - 0.5 * real(row));
            scene.add(format!("ball {row}/{i}"), ball.clone().with_position(vec3(x, RADIUS, z)));
        }
    }
    Ok(scene)
}

pub(super) fn tops(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    let n = values.whole("n");
    scene.seconds = 10.0;
    let friction = values.number("friction");
    add_ground(&mut scene, friction);
    let turn = Quat::from_axis_angle(Vec3::Z, radians(values.number("lean")));
    let stem = ShapeDef::capsule(0.06, 0.01).with_position(0.07 * Vec3::Y).with_friction(friction);
    let disc = ShapeDef::cylinder(0.02, 0.1).with_position(0.1 * Vec3::Y).with_friction(friction);
    for i in 0..n {
        // Its origin is the lowest point of the tip.
        let def = BodyDef::dynamic()
            .with_position(vec3(0.5 * (real(i) - 0.5 * real(n - 1)), 0.0, 0.0))
            .with_rotation(turn)
            .with_angular_velocity(turn.rotate(Vec3::Y) * values.number("spin"))
            .with_shape(stem.clone())
            .with_shape(disc.clone());
        scene.add(format!("top {i}"), def);
    }
    Ok(scene)
}

/// The middle line of the arch: y = height − a (cosh(c x / half_width) − 1), a weighted catenary.
/// Its cross section is 10 m square at the foot and 7 m at the crown, linear in the height.
struct Catenary {
    a: f64,
    c: f64,
}

/// Height of the middle line and half its width at the ground [m].
const HEIGHT: f64 = 60.0;
const HALF_WIDTH: f64 = 30.0;

impl Catenary {
    fn new() -> Self {
        // Areas of the sections at foot and crown, 100 and 49 m².
        let ratio = 100.0 / 49.0;
        // cosh c = ratio, by Newton's method.
        let mut c = 1.0;
        for _ in 0..20 {
            let (cosh, sinh) = cosh_sinh(c);
            c -= (cosh - ratio) / sinh;
        }
        Self { a: HEIGHT / (ratio - 1.0), c }
    }

    /// Height and slope at x.
    fn at(&self, x: f64) -> (f64, f64) {
        let (cosh, sinh) = cosh_sinh(self.c * x / HALF_WIDTH);
        (HEIGHT - self.a * (cosh - 1.0), -self.a * self.c / HALF_WIDTH * sinh)
    }

    /// Length of the line from x0 to x1, by Simpson's rule.
    fn length(&self, x0: f64, x1: f64) -> f64 {
        const PARTS: u32 = 64;
        let h = (x1 - x0) / f64::from(PARTS);
        let speed = |i: u32| {
            let (_, slope) = self.at(x0 + h * f64::from(i));
            (1.0 + slope * slope).sqrt()
        };
        let inner: f64 = (1..PARTS).map(|i| if i % 2 == 1 { 4.0 } else { 2.0 } * speed(i)).sum();
        (speed(0) + inner + speed(PARTS)) * h / 3.0
    }

    /// The x that is `length` further along the line than `x0`.
    fn further(&self, x0: f64, length: f64) -> f64 {
        let mut x = x0;
        for _ in 0..20 {
            let (_, slope) = self.at(x);
            x += (length - self.length(x0, x)) / (1.0 + slope * slope).sqrt();
        }
        x
    }
}

/// Both by their series: the same on every machine. For |x| below 2.
fn cosh_sinh(x: f64) -> (f64, f64) {
    let (mut cosh, mut sinh, mut term) = (0.0, 0.0, 1.0);
    for k in 0..30_u32 {
        if k % 2 == 0 {
            cosh += term;
        } else {
            sinh += term;
        }
        term *= x / f64::from(k + 1);
    }
    (cosh, sinh)
}

/// A stone of the arch: its section in the xy plane, inner and outer corner of either end, and its
/// depth along z [m].
struct Stone {
    corners: [[f64; 2]; 4],
    depth: f64,
}

/// Stones of equal length along the middle line, with air between them, as in the arch of
/// [Ferguson21]. All stand apart by `gap` in x, and in y up to the crown.
fn stones(count: usize, gap: f64) -> Vec<Stone> {
    let line = Catenary::new();
    let each = line.length(-HALF_WIDTH, HALF_WIDTH) / count as f64;
    let width = |y: f64| 10.0 + (7.0 - 10.0) * (y / HEIGHT).clamp(0.0, 1.0);
    let mut stones = Vec::new();
    let mut x0 = -HALF_WIDTH;
    let middle = (count / 2) as f64;
    for k in 0..count {
        let x1 = line.further(x0, each);
        let ((y0, slope0), (y1, slope1)) = (line.at(x0), line.at(x1));
        // As wide at both ends as at the lower one; the crown's stone as at its second.
        let depth = if x0 < 0.0 { width(y0) } else { width(y1) };
        let half = |slope: f64| {
            let scale = 0.5 * depth / (1.0 + slope * slope).sqrt();
            [-slope * scale, scale]
        };
        let ([u0, v0], [u1, v1]) = (half(slope0), half(slope1));
        let shift = (k as f64 - middle) * gap;
        let rise = middle * gap - shift.abs();
        let at = |x: f64, y: f64| [x + shift, y + rise];
        stones.push(Stone {
            corners: [
                at(x0 - u0, y0 - v0),
                at(x1 - u1, y1 - v1),
                at(x0 + u0, y0 + v0),
                at(x1 + u1, y1 + v1),
            ],
            depth,
        });
        x0 = x1;
    }
    // The feet are cut level with their inner corner: the outer one moves along the back.
    let flatten = |foot: &mut Stone, [inner, outer, other]: [usize; 3]| {
        let (from, to) = (foot.corners[outer], foot.corners[other]);
        let y = foot.corners[inner][1];
        let x = to[0] + (y - to[1]) * (from[0] - to[0]) / (from[1] - to[1]);
        foot.corners[outer] = [x, y];
    };
    if let Some(first) = stones.first_mut() {
        flatten(first, [0, 2, 3]);
    }
    if let Some(last) = stones.last_mut() {
        flatten(last, [1, 3, 2]);
    }
    let lowest = stones.iter().flat_map(|s| s.corners).map(|c| c[1]).fold(f64::MAX, f64::min);
    for corner in stones.iter_mut().flat_map(|s| &mut s.corners) {
        corner[1] += gap - lowest;
    }
    stones
}

pub(super) fn catenary_arch(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    let count = values.whole("stones");
    if count.is_multiple_of(2) {
        return Err(CatalogError::Together {
            scene: "catenary_arch",
            problem: format!("`stones` must be an odd number (got {count})"),
        });
    }
    scene.hz = 100.0;
    scene.seconds = 20.0;
    scene.config.gravity = vec3(0.0, -9.8, 0.0);
    scene.config.sleep.enabled = false;
    let surface = ShapeDef::half_space(Vec3::Y, 0.0).with_friction(0.5);
    scene.add(GROUND, BodyDef::fixed().with_shape(surface));
    for (i, stone) in stones(count, f64::from(values.number("gap"))).into_iter().enumerate() {
        let mean = |k: usize| 0.25 * stone.corners.iter().map(|c| c[k]).sum::<f64>();
        let (x, y) = (mean(0), mean(1));
        let mut points = Vec::new();
        for c in stone.corners {
            for side in [-0.5, 0.5] {
                points.push(single([c[0] - x, c[1] - y, side * stone.depth]));
            }
        }
        let def = BodyDef::dynamic().with_position(single([x, y, 0.0]));
        let shape = ShapeDef::new(hull(&points)?).with_friction(0.5);
        scene.add(format!("stone {i}"), def.with_shape(shape));
    }
    Ok(scene)
}

#[expect(clippy::cast_possible_truncation, reason = "rounding is what is asked for")]
const fn single([x, y, z]: [f64; 3]) -> Vec3 {
    vec3(x as f32, y as f32, z as f32)
}
