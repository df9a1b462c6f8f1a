//! The cost of a ray: the closest hit, any hit, and a batch, among 4096 bodies and on a mesh,
//! beside parry, with which rapier casts its rays. `cargo bench -p drystone --bench query_cost`
//! prints one line a scene: nanoseconds a ray, the minimum of five runs.

#![expect(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a benchmark tells its numbers, and ends where it cannot"
)]

use std::sync::Arc;
use std::time::Instant;

use drystone::query::{QueryFilter, RayQuery};
use drystone::threads::Team;
use drystone::{BodyDef, Mesh, Pose, Shape, ShapeDef, Vec3, World, vec3};
use parry3d::math::{Pose as PeerPose, Vector};
use parry3d::partitioning::{Bvh, BvhBuildStrategy};
use parry3d::query::Ray;
use parry3d::shape::SharedShape;

const RAYS: usize = 40_000;

/// Numbers from -1 to 1.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        f32::from(u16::try_from(self.0 >> 48).unwrap()) / 32768.0 - 1.0
    }

    fn vector(&mut self) -> Vec3 {
        vec3(self.next(), self.next(), self.next())
    }
}

fn peer(v: Vec3) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

/// Waves from -1 to 1 of a wavelength of 4.
fn hills(x: f32) -> f32 {
    let part = x - 4.0 * (0.25 * x).round();
    1.0 - part.abs()
}

/// The same shapes for both.
#[derive(Default)]
struct Scene {
    world: World,
    peers: Vec<(PeerPose, SharedShape)>,
}

impl Scene {
    fn add(&mut self, body: BodyDef, shape: Shape, theirs: SharedShape) {
        let Pose { position, rotation: q } = Pose::new(body.position, body.rotation);
        let turn = parry3d::math::Rotation::from_xyzw(q.x, q.y, q.z, q.w);
        self.world.add_body(body.with_shape(ShapeDef::new(shape))).unwrap();
        self.peers.push((PeerPose::from_parts(peer(position), turn), theirs));
    }

    /// Boxes, balls and capsules, 1.6 m apart.
    fn bodies(numbers: &mut Numbers) -> Self {
        let mut scene = Self::default();
        for n in 0..4096_u16 {
            let cell = vec3(f32::from(n % 16), f32::from(n / 16 % 16), f32::from(n / 256));
            let at = (cell - Vec3::splat(7.5)) * 1.6 + numbers.vector() * 0.3;
            let turn = drystone::Quat::from_rotation_vector(numbers.vector() * 2.0);
            let body = BodyDef::dynamic().with_position(at).with_rotation(turn);
            let (shape, theirs) = match n % 3 {
                0 => (Shape::box_half([0.5, 0.3, 0.4]), SharedShape::cuboid(0.5, 0.3, 0.4)),
                1 => (Shape::sphere(0.4), SharedShape::ball(0.4)),
                _ => (Shape::capsule(0.3, 0.25), SharedShape::capsule_y(0.3, 0.25)),
            };
            scene.add(body, shape, theirs);
        }
        scene.world.step(1.0e-6);
        scene
    }

    /// A hilly ground of 131,072 triangles, 24 m wide.
    fn mesh(numbers: &mut Numbers) -> Self {
        const SIDE: u16 = 257;
        let mut vertices = Vec::new();
        let mut triangles = Vec::new();
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
        let theirs = vertices.iter().map(|v| peer(*v)).collect();
        let theirs = SharedShape::trimesh(theirs, triangles.clone()).unwrap();
        let mesh = Shape::Mesh(Arc::new(Mesh::new(vertices, triangles).unwrap()));
        let mut scene = Self::default();
        scene.add(BodyDef::fixed(), mesh, theirs);
        scene.world.step(1.0e-6);
        scene
    }
}

/// The least time of five runs a ray [ns], and the sum of what `cast` gives.
fn time(cast: &mut dyn FnMut() -> f64) -> (f64, f64) {
    let (mut least, mut sum) = (f64::INFINITY, 0.0);
    for _ in 0..5 {
        let start = Instant::now();
        sum = cast();
        least = least.min(start.elapsed().as_secs_f64());
    }
    (least * 1.0e9 / f64::from(u32::try_from(RAYS).unwrap()), sum)
}

fn measure(name: &str, scene: Scene, rays: &[RayQuery]) {
    let Scene { world, peers } = scene;
    let boxes = peers.iter().map(|(pose, shape)| shape.compute_aabb(pose)).enumerate();
    let tree = Bvh::from_iter(BvhBuildStrategy::Binned, boxes);
    let (query, all) = (world.query(), QueryFilter::default());
    let (own, sum) = time(&mut || {
        let cast = |ray: &RayQuery| query.cast_ray(ray.origin, ray.delta, all).unwrap();
        rays.iter().map(|ray| cast(ray).map_or(1.0, |hit| f64::from(hit.fraction))).sum()
    });
    let (any, _) = time(&mut || {
        let cast = |ray: &RayQuery| query.cast_ray_any(ray.origin, ray.delta, all).unwrap();
        rays.iter().map(|ray| f64::from(u8::from(cast(ray)))).sum()
    });
    let two = world.clone().with_executor(Arc::new(Team::with_threads(2)));
    let mut hits = Vec::new();
    let (batch, _) = time(&mut || {
        two.query().cast_rays(rays, all, &mut hits).unwrap();
        0.0
    });
    let (theirs, peer_sum) = time(&mut || {
        let cast = |ray: &RayQuery| {
            let ray = Ray::new(peer(ray.origin), peer(ray.delta));
            tree.cast_ray(&ray, 1.0, |leaf, best| {
                let (pose, shape) = &peers[leaf as usize];
                shape.cast_ray_and_get_normal(pose, &ray, best, true).map(|h| h.time_of_impact)
            })
        };
        rays.iter().map(|ray| cast(ray).map_or(1.0, |(_, t)| f64::from(t))).sum()
    });
    let off = (sum - peer_sum).abs() / sum;
    println!(
        "{name}: closest {own:.0} ns, any {any:.0} ns, batch on 2 threads {batch:.0} ns; parry closest {theirs:.0} ns \
         (mean hits differ by {off:.1e})"
    );
}

fn main() {
    let mut numbers = Numbers(12345);
    let through =
        |numbers: &mut Numbers| RayQuery::new(numbers.vector() * 14.0, numbers.vector() * 14.0);
    let rays: Vec<RayQuery> = (0..RAYS).map(|_| through(&mut numbers)).collect();
    measure("4096 bodies", Scene::bodies(&mut numbers), &rays);
    let down = |numbers: &mut Numbers| {
        let at = numbers.vector();
        RayQuery::new(vec3(at.x * 8.0, 4.0, at.z * 8.0), numbers.vector() * 4.0 - Vec3::Y * 8.0)
    };
    let rays: Vec<RayQuery> = (0..RAYS).map(|_| down(&mut numbers)).collect();
    measure("mesh of 131,072 triangles", Scene::mesh(&mut numbers), &rays);
}
