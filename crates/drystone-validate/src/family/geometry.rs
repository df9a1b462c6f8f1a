//! Shapes: mass, rays, manifolds, seams of meshes, and bullets.

use std::sync::Arc;

use drystone::geometry::MassProperties;
use drystone::{
    BodyDef, Filter, Hull, Mesh, Pose, Shape, ShapeDef, Vec3, World, WorldConfig, vec3,
};
use drystone_bench::EngineError;
use drystone_scene::Scene;

use crate::lab::Lab;
use crate::numeric::{
    D3, Random, add, cross, dot, narrow, norm, rotate, scale, single, sub, turn, unrotate, wide,
    worst,
};
use crate::row::{Rows, Unit, limits};
use crate::setup::{Surface, empty, weightless};
use crate::test::Test;

pub(crate) const TESTS: &[Test] = &[
    Test::new(
        "A39",
        "10,000 bullets of 5 mm, 50 to 900 m/s",
        "slab of 1 cm (great: dynamic), triangle (great: cube of 1000 m/s), field, box of 1 mm, hull",
        "none passes",
        bullets,
    ),
    Test::new(
        "A40",
        "sliding 20 m over seams without friction, 5 m/s",
        "box, capsule, ball; plane of 8192 triangles, uneven grid, top faces of voxels",
        "straight on",
        seams,
    ),
    Test::new(
        "A40b",
        "sliding over boxes side by side of one body without friction, 5 m/s",
        "box, capsule, ball",
        "straight on",
        box_seams,
    ),
    Test::new("A41", "mass of 2000 random hulls", "", "sums over tetrahedra in f64", hull_mass),
    Test::new(
        "A42",
        "60,000 random rays at balls, boxes and hulls",
        "shape",
        "intersection worked out in f64",
        rays,
    ),
    Test::new(
        "A42b",
        "6,000 casts of boxes and hulls at each other, and how far apart they stand",
        "shape",
        "the planes that are between polytopes in f64; closest points and a plane that prove each other",
        super::casts::casts,
    ),
    Test::new(
        "A43",
        "manifolds of 600 random pairs of boxes and of hulls",
        "shape",
        "overlap of the supports along the normal; least over 20,000 directions; points in both",
        manifolds,
    ),
];

pub(super) fn refused(e: impl core::fmt::Display) -> EngineError {
    EngineError(e.to_string())
}

/// A mesh over a square grid of `n` × `n` cells of edge `cell`, with heights from `height`.
fn grid(
    n: u32,
    cell: f64,
    height: impl Fn(f64, f64) -> D3,
    turned: bool,
) -> Result<Mesh, EngineError> {
    let mut vertices = Vec::new();
    let half = 0.5 * f64::from(n) * cell;
    for j in 0..=n {
        for i in 0..=n {
            vertices.push(narrow(height(f64::from(i) * cell - half, f64::from(j) * cell - half)));
        }
    }
    let mut triangles = Vec::new();
    for j in 0..n {
        for i in 0..n {
            let a = j * (n + 1) + i;
            let (b, c, d) = (a + 1, a + n + 1, a + n + 2);
            if turned && (i + j) % 2 == 1 {
                triangles.extend([[a, c, d], [a, d, b]]);
            } else {
                triangles.extend([[a, c, b], [b, c, d]]);
            }
        }
    }
    Mesh::new(vertices, triangles).map_err(refused)
}

/// Number of 2000 bullets that are behind the target at the end.
fn shots(lab: &Lab, target: BodyDef, seed: u64) -> Result<f64, EngineError> {
    let mut random = Random::new(seed);
    let mut scene = weightless("bullets");
    let target = scene.add("target", target);
    for i in 0..2000 {
        let aim = [random.between(-3.0, 3.0), 0.0, random.between(-3.0, 3.0)];
        // Directions up to 60° from the normal.
        let mut way = random.direction();
        way[1] = -way[1].abs().max(0.5 * way[0].hypot(way[2]) / 0.75_f64.sqrt());
        let way = scale(way, 1.0 / norm(way));
        let from = add(aim, scale(way, -random.between(2.0, 8.0)));
        // Bullets do not collide with each other.
        let shape = ShapeDef::sphere(0.005).with_filter(Filter::layers(2, 1));
        let bullet = BodyDef::dynamic()
            .with_position(narrow(from))
            .with_shape(shape)
            .with_linear_velocity(narrow(scale(way, random.between(50.0, 900.0))));
        scene.add(format!("bullet {i}"), bullet);
    }
    let mut run = lab.start(scene)?;
    run.until(0.5, |_| {});
    // Relative to the target's final pose: a dynamic target has been pushed.
    let now = run.body(target);
    let behind = |body: &usize| {
        let local = unrotate(now.state.pose.rotation, sub(run.body(*body).center, now.center));
        // Written so that NaN counts as having passed.
        !(local[1] > -0.1) && *body != target
    };
    Ok(run.dynamic().filter(behind).count() as f64)
}

fn bullets(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let none = limits(0.0, 0.0);
    let plate =
        |half: f64| BodyDef::fixed().with_shape(ShapeDef::box_half(narrow([5.0, half, 5.0])));
    let heavy = ShapeDef::box_half(vec3(5.0, 0.005, 5.0)).with_density(7800.0);
    let dynamic = shots(lab, BodyDef::dynamic().with_shape(heavy), 391)?;
    let slab = (shots(lab, plate(0.005), 391)?, dynamic);
    rows.at_most_harder("slab", slab, Unit::Count, none);
    let corners = vec![vec3(-40.0, 0.0, -20.0), vec3(0.0, 0.0, 40.0), vec3(40.0, 0.0, -20.0)];
    let triangle = Mesh::new(corners, vec![[0, 1, 2]]).map_err(refused)?;
    let solid =
        |mesh: Mesh| BodyDef::fixed().with_shape(ShapeDef::new(Shape::Mesh(Arc::new(mesh))));
    let triangle = (shots(lab, solid(triangle), 392)?, fast_cube(lab)?);
    rows.at_most_harder("triangle", triangle, Unit::Count, none);
    let field = grid(64, 0.16, |x, z| [x, 0.05 * (2.0 * x).sin() * (3.0 * z).cos(), z], false)?;
    rows.at_most("field", shots(lab, solid(field), 393)?, Unit::Count, none);
    rows.at_most("box of 1 mm", shots(lab, plate(0.0005), 394)?, Unit::Count, none);
    let rim = |i: u32| f64::from(i % 12) * core::f64::consts::PI / 6.0;
    let rim: Vec<Vec3> = (0..24)
        .map(|i| {
            narrow([5.0 * rim(i).cos(), if i < 12 { -0.01 } else { 0.01 }, 5.0 * rim(i).sin()])
        })
        .collect();
    let hull = Hull::from_points(&rim).map_err(refused)?;
    let hull = BodyDef::fixed().with_shape(ShapeDef::new(Shape::Hull(Arc::new(hull))));
    rows.at_most("hull", shots(lab, hull, 395)?, Unit::Count, none);
    Ok(())
}

/// A cube of 1 m at 1000 m/s against a wall of two triangles; 1 if it passes through.
fn fast_cube(lab: &Lab) -> Result<f64, EngineError> {
    let mut scene = weightless("wall");
    let wall = grid(1, 20.0, |x, z| [x, 0.0, z], false)?;
    scene.add("wall", BodyDef::fixed().with_shape(ShapeDef::new(Shape::Mesh(Arc::new(wall)))));
    let cube = BodyDef::dynamic()
        .with_position([0.3, 30.0, 0.2])
        .with_shape(ShapeDef::box_half([0.5; 3]))
        .with_linear_velocity([0.0, -1000.0, 0.0]);
    let cube = scene.add("cube", cube);
    let mut run = lab.start(scene)?;
    run.until(0.5, |_| {});
    Ok(if run.body(cube).center[1] > 0.0 { 0.0 } else { 1.0 })
}

/// Final change of the horizontal velocity, as a fraction of the initial one, and the maximum
/// vertical speed [m/s].
fn slide_over(lab: &Lab, ground: BodyDef, body: BodyDef) -> Result<(f64, f64), EngineError> {
    let mut scene: Scene = empty("seams");
    scene.add("ground", ground);
    let body = scene.add("body", body.with_linear_velocity([5.0, 0.0, 0.0]));
    let mut run = lab.start(scene)?;
    let mut bounce = 0.0;
    run.until(4.0, |run| bounce = worst(bounce, run.body(body).v[1].abs()));
    let v = run.body(body).v;
    Ok((norm(sub([v[0], 0.0, v[2]], [5.0, 0.0, 0.0])) / 5.0, bounce))
}

fn seams(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let smooth = Surface::rough(0.0);
    let flat = grid(64, 0.5, |x, z| [x, 0.0, z], false)?;
    // Cells of uneven size and with diagonals both ways.
    let bent = |x: f64, z: f64| [x + 0.1 * (7.0 * z).sin(), 0.0, z + 0.1 * (5.0 * x).sin()];
    let uneven = grid(64, 0.5, bent, true)?;
    let voxels = grid(30, 1.0, |x, z| [x, 0.0, z], false)?;
    for (name, mesh) in [("plane", flat), ("uneven grid", uneven), ("voxels", voxels)] {
        let shape = ShapeDef::new(Shape::Mesh(Arc::new(mesh)));
        slide_all(lab, rows, name, &BodyDef::fixed().with_shape(smooth.on(shape)))?;
    }
    Ok(())
}

fn box_seams(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let mut boxes = BodyDef::fixed();
    for i in 0..30 {
        for j in 0..6 {
            let place = [f64::from(i) - 14.5, -0.5, f64::from(j) - 2.3];
            let shape = Surface::rough(0.0).on(ShapeDef::box_half([0.5; 3]));
            boxes = boxes.with_shape(shape.with_position(narrow(place)));
        }
    }
    slide_all(lab, rows, "boxes", &boxes)
}

fn slide_all(lab: &Lab, rows: &mut Rows, name: &str, ground: &BodyDef) -> Result<(), EngineError> {
    let along = Pose::new(Vec3::ZERO, turn([0.0, 0.0, 1.0], core::f64::consts::FRAC_PI_2));
    let movers = [
        ("box", ShapeDef::box_half([0.4, 0.3, 0.4]), 0.3),
        ("capsule", ShapeDef::capsule(0.3, 0.25).with_pose(along), 0.25),
        ("ball", ShapeDef::sphere(0.3), 0.3),
    ];
    for (mover, shape, height) in &movers {
        let body = BodyDef::dynamic()
            .with_position(narrow([-11.3, *height, 0.13]))
            .with_shape(Surface::rough(0.0).on(shape.clone()));
        let (slower, bounce) = slide_over(lab, ground.clone(), body)?;
        let case = |what: &str| format!("{mover} on {name}, {what}");
        rows.at_most(case("dv"), slower, Unit::Part, limits(0.01, 0.001));
        rows.at_most(case("vy"), bounce, Unit::MeterPerSecond, limits(0.05, 0.01));
    }
    Ok(())
}

/// A convex hull of random points in a random box around a random point.
pub(super) fn random_hull(random: &mut Random, off: f64) -> Option<Hull> {
    let count = crate::numeric::whole(random.between(4.0, 60.0));
    let size = [0; 3].map(|_| random.between(0.1, 1.0));
    let center = scale(random.direction(), off);
    let points: Vec<Vec3> = (0..count)
        .map(|_| narrow(add(center, size.map(|s| s * random.between(-1.0, 1.0)))))
        .collect();
    Hull::from_points(&points).ok()
}

/// Volume, center and inertia about the center of a closed surface of density 1, by tetrahedra from
/// its middle.
fn tetrahedra(hull: &Hull) -> (f64, D3, [f64; 6]) {
    let vertices: Vec<D3> = hull.vertices().iter().map(|v| wide(*v)).collect();
    let middle =
        scale(vertices.iter().fold([0.0; 3], |s, v| add(s, *v)), 1.0 / vertices.len() as f64);
    // Volume, first moments, second moments xx yy zz xy xz yz.
    let mut sums = [0.0; 10];
    for face in 0..hull.face_count() {
        let face = hull.face(face);
        let at = |i: usize| sub(vertices[usize::from(face[i])], middle);
        for i in 2..face.len() {
            let (a, b, c) = (at(0), at(i - 1), at(i));
            let six = dot(a, cross(b, c));
            let sum = add(a, add(b, c));
            sums[0] += six / 6.0;
            for k in 0..3 {
                sums[1 + k] += six / 24.0 * sum[k];
            }
            for (k, (i, j)) in
                [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].into_iter().enumerate()
            {
                let pairs = a[i] * a[j] + b[i] * b[j] + c[i] * c[j] + sum[i] * sum[j];
                sums[4 + k] += six / 120.0 * pairs;
            }
        }
    }
    let volume = sums[0];
    let c = scale([sums[1], sums[2], sums[3]], 1.0 / volume);
    let about = |k: usize, i: usize, j: usize| sums[4 + k] - volume * c[i] * c[j];
    let (xx, yy, zz) = (about(0, 0, 0), about(1, 1, 1), about(2, 2, 2));
    let inertia = [yy + zz, xx + zz, xx + yy, -about(3, 0, 1), -about(4, 0, 2), -about(5, 1, 2)];
    (volume, add(c, middle), inertia)
}

fn hull_mass(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    lab.own("mass of shapes")?;
    let mut random = Random::new(41);
    let (mut mass, mut center, mut inertia) = (0.0, 0.0, 0.0);
    for _ in 0..2000 {
        let Some(hull) = random_hull(&mut random, 1.0) else { continue };
        let (volume, c, i) = tetrahedra(&hull);
        let extent = hull.vertices().iter().map(|v| norm(sub(wide(*v), c))).fold(0.0, f64::max);
        let own = MassProperties::of(&Shape::Hull(Arc::new(hull)), 1.0);
        mass = worst(mass, (f64::from(own.mass) / volume - 1.0).abs());
        center = worst(center, norm(sub(wide(own.center), c)) / extent);
        let o = own.inertia;
        let own = [o.xx, o.yy, o.zz, o.xy, o.xz, o.yz].map(f64::from);
        let largest = i[0].max(i[1]).max(i[2]);
        for k in 0..6 {
            inertia = worst(inertia, (own[k] - i[k]).abs() / largest);
        }
    }
    for (case, error) in [("mass", mass), ("center", center), ("inertia", inertia)] {
        rows.at_most(case, error, Unit::Part, limits(1.0e-4, 1.0e-5));
    }
    Ok(())
}

/// The point where a ray enters a convex body of these planes, as a fraction of its length. Also
/// the margin by which it enters or misses, so that grazing rays can be left out.
fn enter(planes: &[(D3, f64)], from: D3, way: D3) -> (Option<f64>, f64) {
    let (mut first, mut last) = (f64::NEG_INFINITY, 1.0_f64);
    let mut parallel_out = false;
    for (normal, offset) in planes {
        let (height, speed) = (dot(*normal, from) - offset, dot(*normal, way));
        if speed == 0.0 {
            parallel_out |= height > 0.0;
        } else if speed < 0.0 {
            first = first.max(-height / speed);
        } else {
            last = last.min(-height / speed);
        }
    }
    let hit = first <= last && first >= 0.0 && !parallel_out;
    (hit.then_some(first), (last - first).abs())
}

fn rays(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    lab.own("rays")?;
    let mut random = Random::new(42);
    for kind in ["ball", "box", "hull"] {
        let (mut missed, mut off) = (0.0, 0.0);
        for _ in 0..200 {
            let half = [0; 3].map(|_| random.between(0.1, 1.0));
            let (shape, planes) = match kind {
                "ball" => (Shape::sphere(single(half[0])), Vec::new()),
                "box" => {
                    let planes = (0..6).map(|i| {
                        let mut normal = [0.0; 3];
                        normal[i / 2] = if i % 2 == 0 { 1.0 } else { -1.0 };
                        (normal, f64::from(single(half[i / 2])))
                    });
                    (Shape::box_half(narrow(half)), planes.collect())
                }
                _ => {
                    let Some(hull) = random_hull(&mut random, 0.0) else { continue };
                    let plane =
                        |p: &drystone::geometry::Plane| (wide(p.normal), f64::from(p.offset));
                    let planes: Vec<(D3, f64)> = hull.planes().iter().map(plane).collect();
                    (Shape::Hull(Arc::new(hull)), planes)
                }
            };
            let (place, rotation) =
                (scale(random.direction(), random.between(0.0, 3.0)), random.rotation());
            let mut world = World::default();
            let def = BodyDef::fixed().with_position(narrow(place)).with_rotation(rotation);
            let id = world.add_body(def.with_shape(ShapeDef::new(shape))).map_err(refused)?;
            let pose = world.body(id).map_or(Pose::IDENTITY, |b| b.pose());
            let (center, turned) = (wide(pose.position), pose.rotation);
            for _ in 0..100 {
                let from = add(center, scale(random.direction(), random.between(2.0, 5.0)));
                let at = add(center, scale(random.direction(), random.between(0.0, 1.2)));
                let way = scale(sub(at, from), 2.0);
                let (from, way) = (wide(narrow(from)), wide(narrow(way)));
                let local = unrotate(turned, sub(from, center));
                let along = unrotate(turned, way);
                let (exact, margin) = if planes.is_empty() {
                    through_ball(local, along, f64::from(single(half[0])))
                } else {
                    enter(&planes, local, along)
                };
                let hit = world.query().cast_ray(narrow(from), narrow(way), Filter::default());
                let hit = hit.map_err(refused)?;
                match (exact, hit) {
                    (Some(exact), Some(hit)) => {
                        // At an oblique hit, a rounding error of the point is a larger one along
                        // the ray.
                        let slant = dot(wide(hit.normal), way).abs() / norm(way);
                        let miss = (f64::from(hit.fraction) - exact).abs() * norm(way);
                        off = worst(off, miss * slant.max(0.1));
                    }
                    (None, None) => {}
                    // A grazing ray: either answer is right within 1e-4 of the size.
                    _ if margin * norm(way) < 1.0e-2 => {}
                    _ => missed += 1.0,
                }
            }
        }
        rows.at_most(format!("{kind}, misses"), missed, Unit::Count, limits(0.0, 0.0));
        rows.at_most(format!("{kind}, distance"), off, Unit::Meter, limits(1.0e-4, 1.0e-5));
    }
    Ok(())
}

/// As `enter`, for a ball.
fn through_ball(from: D3, way: D3, radius: f64) -> (Option<f64>, f64) {
    let (a, b, c) = (dot(way, way), dot(from, way), dot(from, from) - radius * radius);
    let inside = b * b - a * c;
    let half = inside.abs().sqrt() / a;
    ((inside >= 0.0 && b < 0.0).then(|| -b / a - half), 2.0 * half)
}

/// Vertices of a convex body in the world.
struct Body {
    vertices: Vec<D3>,
}

impl Body {
    /// Maximum extent along a direction.
    fn reach(&self, way: D3) -> f64 {
        self.vertices.iter().map(|v| dot(*v, way)).fold(f64::NEG_INFINITY, f64::max)
    }
}

fn manifolds(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    lab.own("manifolds")?;
    let mut random = Random::new(43);
    let directions: Vec<D3> = (0..20_000).map(|_| random.direction()).collect();
    for kind in ["box", "hull"] {
        let (mut along, mut least, mut outside, mut pairs) = (0.0, 0.0, 0.0, 0.0);
        while pairs < 300.0 {
            let Some(found) = touch(kind == "box", &mut random)? else { continue };
            pairs += 1.0;
            let Touch { a, b, normal, depth, points } = found;
            let overlap = |way: D3| a.reach(way) + b.reach(scale(way, -1.0));
            // Both errors are relative to the size of the bodies, about 1 m.
            along = worst(along, (overlap(normal) - depth).abs());
            let sweep = directions.iter().map(|way| overlap(*way)).fold(f64::INFINITY, f64::min);
            least = worst(least, depth - sweep);
            for (point, separation) in points {
                // Points must lie inside both bodies, or no farther outside than the gap between
                // the surfaces.
                let past_a = dot(point, normal) - a.reach(normal);
                let past_b = -dot(point, normal) - b.reach(scale(normal, -1.0));
                outside = worst(outside, past_a.max(past_b) - separation.max(0.0));
            }
        }
        let l = limits(0.01, 0.001);
        rows.at_most(format!("{kind}, depth along the normal"), along, Unit::Meter, l);
        rows.at_most(format!("{kind}, deeper than the least"), least, Unit::Meter, l);
        rows.at_most(format!("{kind}, points outside"), outside, Unit::Meter, l);
    }
    Ok(())
}

struct Touch {
    a: Body,
    b: Body,
    normal: D3,
    depth: f64,
    points: Vec<(D3, f64)>,
}

/// Two bodies that overlap slightly, and their manifold.
fn touch(boxes: bool, random: &mut Random) -> Result<Option<Touch>, EngineError> {
    let mut config = WorldConfig { gravity: Vec3::ZERO, substeps: 1, ..WorldConfig::default() };
    config.sleep.enabled = false;
    let mut world = World::new(config).map_err(refused)?;
    let (mut ids, mut bodies) = (Vec::new(), Vec::new());
    let way = random.direction();
    for side in [0.0, 1.0] {
        let hull = if boxes {
            let half = [0; 3].map(|_| random.between(0.2, 0.6));
            let corner = |i: u32| {
                let sign = |bit: u32| if i >> bit & 1 == 0 { 1.0 } else { -1.0 };
                narrow([half[0] * sign(0), half[1] * sign(1), half[2] * sign(2)])
            };
            let shape = Shape::box_half(narrow(half));
            ((0..8).map(corner).collect::<Vec<_>>(), shape)
        } else {
            let Some(hull) = random_hull(random, 0.0) else { return Ok(None) };
            (hull.vertices().to_vec(), Shape::Hull(Arc::new(hull)))
        };
        let rotation = random.rotation();
        let turned = |v: &Vec3| rotate(rotation, wide(*v));
        let mut body = Body { vertices: hull.0.iter().map(turned).collect() };
        // The second body is placed to overlap by 1 to 30 mm along one direction; the minimum
        // overlap is smaller.
        let place = if side > 0.0 {
            let first: &Body = &bodies[0];
            let apart = first.reach(way) + body.reach(scale(way, -1.0));
            scale(way, apart - random.between(0.001, 0.03))
        } else {
            [0.0; 3]
        };
        let place = wide(narrow(place));
        for v in &mut body.vertices {
            *v = add(*v, place);
        }
        bodies.push(body);
        let def = BodyDef::dynamic().with_position(narrow(place)).with_rotation(rotation);
        ids.push(world.add_body(def.with_shape(ShapeDef::new(hull.1))).map_err(refused)?);
    }
    world.step(1.0e-6);
    let contact = world.contacts().next();
    let found = contact.map(|contact| {
        let points: Vec<(D3, f64)> =
            contact.points().map(|p| (wide(p.position), f64::from(p.separation))).collect();
        let depth = points.iter().map(|(_, s)| -s).fold(f64::NEG_INFINITY, f64::max);
        (wide(contact.normal()), depth, points, contact.body_a() == ids[0])
    });
    let Some((normal, depth, points, in_order)) = found else { return Ok(None) };
    if depth <= 0.0 {
        return Ok(None);
    }
    let second = bodies.pop();
    let first = bodies.pop();
    let (Some(a), Some(b)) = (if in_order { (first, second) } else { (second, first) }) else {
        return Ok(None);
    };
    Ok(Some(Touch { a, b, normal, depth, points }))
}

#[cfg(test)]
mod tests {
    use drystone::{Hull, vec3};

    use super::{enter, tetrahedra, through_ball};

    #[test]
    fn a_boxs_mass_is_the_known_one() {
        let corners: Vec<_> = (0..8)
            .map(|i| {
                let at = |bit: i32, size: f32| if i >> bit & 1 == 0 { 0.0 } else { size };
                vec3(at(0, 1.0), at(1, 2.0), at(2, 4.0))
            })
            .collect();
        let (volume, center, inertia) = tetrahedra(&Hull::from_points(&corners).unwrap());
        assert!((volume - 8.0).abs() < 1.0e-6);
        for (own, exact) in center.iter().zip([0.5, 1.0, 2.0]) {
            assert!((own - exact).abs() < 1.0e-6);
        }
        // m/12 (b² + c²)
        for (own, exact) in inertia.iter().zip([40.0 / 3.0, 34.0 / 3.0, 10.0 / 3.0, 0.0, 0.0, 0.0])
        {
            assert!((own - exact).abs() < 1.0e-5, "{inertia:?}");
        }
    }

    #[test]
    fn rays_enter_where_they_should() {
        let (hit, _) = through_ball([0.0, 0.0, 5.0], [0.0, 0.0, -8.0], 1.0);
        assert!((hit.unwrap() - 0.5).abs() < 1.0e-12);
        assert!(through_ball([2.0, 0.0, 5.0], [0.0, 0.0, -8.0], 1.0).0.is_none());
        let slab = [([0.0, 0.0, 1.0], 1.0), ([0.0, 0.0, -1.0], 1.0)];
        assert!((enter(&slab, [0.0, 0.0, 5.0], [0.0, 0.0, -8.0]).0.unwrap() - 0.5).abs() < 1.0e-12);
        assert!(enter(&slab, [0.0, 0.0, 5.0], [0.0, 0.0, 8.0]).0.is_none());
    }
}
