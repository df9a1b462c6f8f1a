//! The cost of ray casts, ball casts and ball overlaps in drystone and its peers, on the same
//! scenes.

use std::fmt::Write as _;
use std::sync::Arc;
use std::time::Instant;

use drystone::query::QueryFilter;
use drystone::{BodyDef, Mesh, Pose, Quat, Shape, ShapeDef, Vec3, World, vec3};
#[cfg(any(feature = "rapier", feature = "box3d"))]
use drystone_bench::Engine;
use drystone_bench::EngineError;
use drystone_scene::{Scene, SceneBody};

const ASKED: u32 = 20_000;

/// An engine under test. Fractions are 1 if nothing is hit.
pub(crate) trait Asked {
    /// The fraction of the displacement at which a ray hits the first shape.
    fn ray(&self, origin: Vec3, delta: Vec3) -> f32;
    /// The same fraction for a ball of this radius [m].
    fn cast(&self, radius: f32, origin: Vec3, delta: Vec3) -> f32;
    /// Number of shapes that a ball overlaps.
    fn overlap(&self, radius: f32, center: Vec3) -> u32;
}

impl Asked for World {
    fn ray(&self, origin: Vec3, delta: Vec3) -> f32 {
        let hit = self.query().cast_ray(origin, delta, QueryFilter::default());
        hit.ok().flatten().map_or(1.0, |hit| hit.fraction)
    }

    fn cast(&self, radius: f32, origin: Vec3, delta: Vec3) -> f32 {
        let ball = Shape::sphere(radius);
        let hit = self.query().cast_shape(&ball, Pose::at(origin), delta, QueryFilter::default());
        hit.ok().flatten().map_or(1.0, |hit| hit.fraction)
    }

    fn overlap(&self, radius: f32, center: Vec3) -> u32 {
        let ball = Shape::sphere(radius);
        let found = self.query().overlap_shape(&ball, Pose::at(center), QueryFilter::default());
        found.map_or(0, |found| u32::try_from(found.len()).unwrap_or(u32::MAX))
    }
}

/// Random numbers from -1 to 1.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        let bits = u16::try_from(self.0 >> 48).unwrap_or(0);
        f32::from(bits) / 32768.0 - 1.0
    }

    fn vector(&mut self) -> Vec3 {
        vec3(self.next(), self.next(), self.next())
    }
}

fn add(scene: &mut Scene, body: BodyDef, shape: Shape) {
    let def = body.with_shape(ShapeDef::new(shape));
    scene.bodies.push(SceneBody { name: String::new(), def });
}

/// Boxes, balls and capsules at 1.6 m spacing; a quarter of them are static.
fn bodies(numbers: &mut Numbers) -> Scene {
    let mut scene = Scene::new("bodies", "");
    scene.config.gravity = Vec3::ZERO;
    for n in 0..4096_u16 {
        let cell = vec3(f32::from(n % 16), f32::from(n / 16 % 16), f32::from(n / 256));
        let at = (cell - Vec3::splat(7.5)) * 1.6 + numbers.vector() * 0.3;
        let turn = Quat::from_rotation_vector(numbers.vector() * 2.0);
        let body = if n % 4 == 3 { BodyDef::fixed() } else { BodyDef::dynamic() };
        let shape = match n % 3 {
            0 => Shape::box_half([0.5, 0.3, 0.4]),
            1 => Shape::sphere(0.4),
            _ => Shape::capsule(0.3, 0.25),
        };
        add(&mut scene, body.with_position(at).with_rotation(turn), shape);
    }
    scene
}

/// Triangle waves from -1 to 1 with a wavelength of 4.
fn hills(x: f32) -> f32 {
    let part = x - 4.0 * (0.25 * x).round();
    1.0 - part.abs()
}

/// Hilly ground of 131,072 triangles, 24 m wide.
fn ground(numbers: &mut Numbers) -> Result<Scene, EngineError> {
    const SIDE: u16 = 257;
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for i in 0..SIDE {
        for k in 0..SIDE {
            let [x, z] = [i, k].map(|n| (f32::from(n) / 128.0 - 1.0) * 12.0);
            vertices.push(vec3(x, hills(x * 0.7) + hills(z * 0.9) + 0.05 * numbers.next(), z));
            if i > 0 && k > 0 {
                let at = |i: u16, k: u16| u32::from(i) * u32::from(SIDE) + u32::from(k);
                let [a, b, c, d] = [at(i - 1, k - 1), at(i - 1, k), at(i, k), at(i, k - 1)];
                triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
    let mesh = Mesh::new(vertices, triangles).map_err(|e| EngineError(e.to_string()))?;
    let mut scene = Scene::new("ground", "");
    add(&mut scene, BodyDef::fixed(), Shape::Mesh(Arc::new(mesh)));
    Ok(scene)
}

/// The queries of a scene: displacements of rays and casts, which begin outside all shapes; centers
/// of balls; radii of both [m].
struct Questions {
    ways: Vec<(Vec3, Vec3)>,
    places: Vec<Vec3>,
    radii: [f32; 2],
}

impl Questions {
    /// Queries through the bodies, from a sphere around all of them.
    fn through(numbers: &mut Numbers) -> Self {
        let way = |numbers: &mut Numbers| {
            let from = numbers.vector().normalize_or(Vec3::X) * 25.0;
            (from, (numbers.vector() * 12.0 - from) * 1.8)
        };
        let ways = (0..ASKED).map(|_| way(numbers)).collect();
        let places = (0..ASKED).map(|_| numbers.vector() * 12.0).collect();
        Self { ways, places, radii: [0.3, 1.0] }
    }

    /// Queries down onto the ground, and near it.
    fn down(numbers: &mut Numbers) -> Self {
        let place =
            |numbers: &mut Numbers, y: f32| vec3(8.0 * numbers.next(), y, 8.0 * numbers.next());
        let way =
            |numbers: &mut Numbers| (place(numbers, 4.0), numbers.vector() * 4.0 - Vec3::Y * 8.0);
        let ways = (0..ASKED).map(|_| way(numbers)).collect();
        let places = (0..ASKED).map(|_| place(numbers, 0.0) + Vec3::Y * numbers.next()).collect();
        Self { ways, places, radii: [0.3, 0.3] }
    }

    /// The minimum time of five rounds per query [ns], and the mean answer, for rays, casts and
    /// overlaps.
    fn ask(&self, engine: &dyn Asked) -> [(f64, f64); 3] {
        let Self { ways, places, radii: [cast, overlap] } = self;
        [
            time(|| ways.iter().map(|(o, d)| f64::from(engine.ray(*o, *d))).sum()),
            time(|| ways.iter().map(|(o, d)| f64::from(engine.cast(*cast, *o, *d))).sum()),
            time(|| places.iter().map(|at| f64::from(engine.overlap(*overlap, *at))).sum()),
        ]
    }
}

fn time(mut ask: impl FnMut() -> f64) -> (f64, f64) {
    let (mut least, mut sum) = (f64::INFINITY, 0.0);
    for _ in 0..5 {
        let start = Instant::now();
        sum = ask();
        least = least.min(start.elapsed().as_secs_f64());
    }
    (least * 1.0e9 / f64::from(ASKED), sum / f64::from(ASKED))
}

/// A table of all built-in engines; the mean answers are in brackets.
pub(crate) fn table() -> Result<String, EngineError> {
    let mut numbers = Numbers(12345);
    let scenes = [
        ("4,096 bodies, a quarter static", bodies(&mut numbers), Questions::through(&mut numbers)),
        ("mesh of 131,072 triangles", ground(&mut numbers)?, Questions::down(&mut numbers)),
    ];
    let mut text = "| scene | engine | ray | cast of a ball | overlap with a ball |\n\
                    |---|---|---|---|---|\n"
        .to_owned();
    for (name, scene, questions) in scenes {
        let mut row = |engine: &str, asked: &dyn Asked| {
            let [ray, cast, overlap] =
                questions.ask(asked).map(|(ns, mean)| format!("{ns:.0} ns ({mean:.4})"));
            writeln!(text, "| {name} | {engine} | {ray} | {cast} | {overlap} |")
                .map_err(|e| EngineError(e.to_string()))
        };
        let mut own = scene.build().map_err(|e| EngineError(e.to_string()))?.world;
        own.step(1.0e-6);
        row("drystone", &own)?;
        #[cfg(feature = "rapier")]
        {
            let mut peer = crate::rapier::Rapier::build(&scene, 1)?;
            peer.step(1.0e-6);
            row("rapier", &peer)?;
        }
        #[cfg(feature = "box3d")]
        {
            let mut peer = crate::box3d::Box3d::build(&scene, 1)?;
            peer.step(1.0e-6);
            row("Box3D", &peer)?;
        }
    }
    Ok(text)
}
