//! A world in another unit of length is the same world. Lengths scaled by a power of two, which is
//! exact in floating point, give the same motion times that factor, bit for bit. An internal
//! tolerance that does not scale would change the bits.

use std::sync::Arc;

use drystone::joint::{
    Ball, ConeTwist, CouplingDef, Distance, Fixed, Hinge, JointSpring, Rope, Servo, Slider, Spring,
    Wheel,
};
use drystone::method::Method;
use drystone::particle::{ClothDef, ParticleDef, RopeDef};
use drystone::{
    AxisLocks, BodyDef, BodyId, Hull, JointDef, JointKind, Mesh, Quat, Shape, ShapeDef, Vec3,
    World, WorldConfig, vec3,
};

const DT: f32 = 1.0 / 60.0;

/// A world whose lengths are scaled from those of its scene.
struct Scaled {
    world: World,
    s: f32,
}

impl Scaled {
    fn new(s: f32, method: &str) -> Self {
        let mut config = WorldConfig { length_scale: s, ..WorldConfig::default() };
        config.gravity *= s;
        config.method = Method::named(method).unwrap();
        Self { world: World::new(config).unwrap(), s }
    }

    fn at(&self, x: f32, y: f32, z: f32) -> Vec3 {
        vec3(x, y, z) * self.s
    }

    fn boxed(&self, x: f32, y: f32, z: f32) -> ShapeDef {
        ShapeDef::box_half(self.at(x, y, z))
    }

    fn ball(&self, r: f32) -> ShapeDef {
        ShapeDef::sphere(r * self.s)
    }

    /// Adds a body with the mass of the scene.
    fn add(&mut self, body: BodyDef, shape: ShapeDef) -> BodyId {
        let shape = ShapeDef { density: shape.density / self.s.powi(3), ..shape };
        self.world.add_body(body.with_shape(shape)).unwrap()
    }

    fn floor(&mut self) -> BodyId {
        let shape = self.boxed(20.0, 1.0, 20.0);
        let at = self.at(0.0, -1.0, 0.0);
        self.add(BodyDef::fixed().with_position(at), shape)
    }

    fn joint(&mut self, a: BodyId, b: BodyId, kind: impl Into<JointKind>, [p, q]: [Vec3; 2]) {
        let def = JointDef::new(a, b, kind.into()).with_anchors(p * self.s, q * self.s);
        self.world.add_joint(def).unwrap();
    }

    /// State of all moving bodies and particles, in the scene's lengths.
    fn state(&self) -> Vec<[Vec3; 4]> {
        let back = 1.0 / self.s;
        let bodies = self.world.bodies().map(|body| {
            let q = body.rotation();
            let turn = vec3(q.x, q.y, q.z);
            [body.position() * back, body.linear_velocity() * back, turn, body.angular_velocity()]
        });
        let particles = self.world.particles().map(|particle| {
            [particle.position() * back, particle.velocity() * back, Vec3::ZERO, Vec3::ZERO]
        });
        // Subnormal numbers have fewer digits, depending on the unit.
        let part = |x: f32| if x.abs() < 1.0e-30 { 0.0 } else { x };
        let normal = |v: Vec3| vec3(part(v.x), part(v.y), part(v.z));
        bodies.chain(particles).map(|all| all.map(normal)).collect()
    }
}

type Build = fn(&mut Scaled);

fn pile(w: &mut Scaled) {
    w.floor();
    tumble(w, 0.3);
}

/// All kinds of convex shapes, stacked.
fn tumble(w: &mut Scaled, above: f32) {
    let s = w.s;
    let tip = [[0.3, -0.2, 0.1], [-0.3, -0.2, 0.2], [0.0, -0.2, -0.3], [0.1, 0.4, 0.0]];
    let hull = Hull::from_points(&tip.map(|p| Vec3::from(p) * s)).unwrap();
    let hull = Arc::new(hull);
    for i in 0..24_u8 {
        let k = f32::from(i);
        let shape = match i % 6 {
            0 => w.boxed(0.3, 0.2, 0.25),
            1 => w.ball(0.25),
            2 => ShapeDef::capsule(0.2 * s, 0.15 * s),
            3 => ShapeDef::cylinder(0.2 * s, 0.2 * s),
            4 => ShapeDef::cone(0.25 * s, 0.2 * s),
            _ => ShapeDef::new(Shape::Hull(Arc::clone(&hull))),
        };
        let shape = if i % 4 == 1 { shape.with_restitution(0.6) } else { shape };
        let at = w.at(0.3 * (k % 3.0), above + 0.6 * k, 0.2 * (k % 4.0));
        let turn = Quat::from_axis_angle(vec3(0.6, 0.8, 0.0), 0.7 * k);
        w.add(BodyDef::dynamic().with_position(at).with_rotation(turn), shape);
    }
}

fn stack(w: &mut Scaled) {
    w.floor();
    for i in 0..12_u8 {
        let at = w.at(0.0, 0.5 + f32::from(i), 0.0);
        let shape = w.boxed(0.5, 0.5, 0.5);
        w.add(BodyDef::dynamic().with_position(at), shape);
    }
    let at = w.at(0.2, 13.0, 0.1);
    let shape = w.boxed(0.9, 0.9, 0.9).with_density(20_000.0);
    w.add(BodyDef::dynamic().with_position(at), shape);
}

fn on_mesh(w: &mut Scaled) {
    let mut vertices = Vec::new();
    for i in 0..121_u8 {
        let (x, z) = (f32::from(i % 11) - 5.0, f32::from(i / 11) - 5.0);
        let (wave, other) = (f32::from(i % 11 * 7 % 5), f32::from(i % 3));
        vertices.push(w.at(x, 0.1 * wave - 0.05 * other, z));
    }
    let cells = (0..10_u32).flat_map(|j| (0..10_u32).map(move |i| 11 * j + i));
    let triangles = cells.flat_map(|k| [[k, k + 11, k + 1], [k + 1, k + 11, k + 12]]).collect();
    let mesh = Shape::Mesh(Arc::new(Mesh::new(vertices, triangles).unwrap()));
    w.add(BodyDef::fixed(), ShapeDef::new(mesh));
    tumble(w, 1.0);
}

fn joints(w: &mut Scaled) {
    let floor = w.floor();
    let s = w.s;
    let (force, torque) = (s, s * s);
    let x = Vec3::X;
    let spring = JointSpring::hertz(3.0, 0.5);
    let kinds: [JointKind; 9] = [
        Ball::new().into(),
        Hinge::new().with_limits(-0.6, 0.4).into(),
        Hinge::new().with_motor(3.0, 40.0 * torque).into(),
        Slider::new().with_limits(-0.2 * s, 0.3 * s).into(),
        Slider::new().with_servo(0.2 * s, spring, 500.0 * force).into(),
        Servo::new(spring, 2000.0 * force, 500.0 * torque).into(),
        Distance::between(0.1 * s, 0.5 * s).into(),
        Rope::new(0.6 * s).into(),
        Spring::new(0.4 * s, 2.0, 0.3).into(),
    ];
    for (k, kind) in kinds.into_iter().enumerate() {
        let z = k as f32 - 4.0;
        let mut before = floor;
        let mut anchor = vec3(0.0, 4.0, z);
        for i in 0..4_u8 {
            let at = w.at(0.5 + f32::from(i), 3.0, z);
            let shape = w.boxed(0.3, 0.1, 0.1);
            let next = w.add(BodyDef::dynamic().with_position(at), shape);
            w.joint(before, next, kind, [anchor, -0.5 * x]);
            (before, anchor) = (next, 0.5 * x);
        }
    }
    // A gear, and a driven wheel.
    let axle = |w: &mut Scaled, at: Vec3| {
        let shape = w.ball(0.3);
        let body = w.add(BodyDef::dynamic().with_position(at * w.s), shape);
        let def = JointDef::new(floor, body, Hinge::new());
        w.world.add_joint(def.with_anchors((at + Vec3::Y) * w.s, Vec3::ZERO)).unwrap()
    };
    let (a, b) = (axle(w, vec3(8.0, 3.0, 0.0)), axle(w, vec3(8.0, 3.0, 1.0)));
    w.world.add_coupling(CouplingDef::gear(a, b, 2.0)).unwrap();
    let at = w.at(-4.0, 1.0, 0.0);
    let shape = w.boxed(0.8, 0.2, 0.5);
    let car = w.add(BodyDef::dynamic().with_position(at), shape);
    for side in [-1.0, 1.0] {
        let at = w.at(-4.0, 0.6, 0.7 * side);
        let shape = w.ball(0.3);
        let wheel = w.add(BodyDef::dynamic().with_position(at), shape);
        let kind = Wheel::new(JointSpring::hertz(4.0, 0.7)).with_motor(5.0, 300.0 * torque);
        w.joint(car, wheel, kind, [vec3(0.0, -0.4, 0.7 * side), Vec3::ZERO]);
    }
}

/// Limbs on cones that fall, and fast bodies that hit them.
fn ragdolls(w: &mut Scaled) {
    w.floor();
    for k in 0..3_u8 {
        let x = f32::from(k) * 1.5;
        let at = w.at(x, 2.0, 0.0);
        let shape = w.boxed(0.2, 0.35, 0.15);
        let chest = w.add(BodyDef::dynamic().with_position(at), shape);
        for (side, up) in [(-1.0, 1.0), (1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)] {
            let mut before = chest;
            let mut anchor = vec3(0.25 * side, 0.3 * up, 0.0);
            for part in 0..2_u8 {
                let shape = ShapeDef::capsule(0.15 * w.s, 0.07 * w.s);
                let at = w.at(x + 0.25 * side, 2.0 + 0.3 * up + 0.2 + 0.4 * f32::from(part), 0.0);
                let next = w.add(BodyDef::dynamic().with_position(at), shape);
                let below = vec3(0.0, -0.2, 0.0);
                if part == 0 {
                    let cone =
                        ConeTwist::new(0.6, 0.8).with_twist(-0.3, 0.3).with_friction(w.s * w.s);
                    w.joint(before, next, cone, [anchor, below]);
                } else {
                    w.joint(before, next, Hinge::new().with_limits(-0.1, 1.5), [anchor, below]);
                }
                (before, anchor) = (next, vec3(0.0, 0.2, 0.0));
            }
        }
        let at = w.at(x, 1.8, 4.0);
        let shot = BodyDef::dynamic().with_position(at).with_linear_velocity(w.at(0.0, 0.0, -60.0));
        let shape = w.ball(0.1);
        w.add(shot, shape);
    }
}

/// Bodies that fly fast, roll, are carried, are sensed, spin, are locked or have no shape.
fn others(w: &mut Scaled) {
    w.floor();
    let at = w.at(5.0, 2.0, 0.0);
    let thin = w.boxed(0.02, 2.0, 2.0);
    w.add(BodyDef::fixed().with_position(at), thin.clone());
    let at = w.at(8.0, 2.0, 0.0);
    w.add(BodyDef::dynamic().with_position(at), thin);
    for k in 0..6_u8 {
        let at = w.at(-2.0, 0.5 + 0.5 * f32::from(k), 0.1);
        let speed = w.at(100.0 + 60.0 * f32::from(k), 0.0, 0.0);
        let shape = if k % 2 == 0 { w.ball(0.1) } else { w.boxed(0.3, 0.05, 0.05) };
        let shot = BodyDef::dynamic().with_position(at).with_linear_velocity(speed);
        w.add(shot.with_angular_velocity([3.0, 40.0, 1.0]), shape.with_restitution(0.3));
    }
    let at = w.at(-4.0, 1.0, 0.0);
    let lift = BodyDef::kinematic().with_position(at).with_linear_velocity(w.at(0.0, 0.5, 0.2));
    let shape = w.boxed(1.0, 0.1, 1.0);
    w.add(lift.with_angular_velocity([0.0, 0.7, 0.0]), shape);
    let at = w.at(-4.0, 1.4, 0.0);
    let shape = w.boxed(0.2, 0.2, 0.2);
    w.add(BodyDef::dynamic().with_position(at), shape);
    let at = w.at(-8.0, 0.5, 0.0);
    let mut belt = w.boxed(2.0, 0.1, 1.0);
    belt.surface_velocity = w.at(0.5, 0.0, 0.0);
    w.add(BodyDef::fixed().with_position(at), belt);
    let at = w.at(-9.0, 0.9, 0.0);
    let shape = w.boxed(0.2, 0.2, 0.2);
    w.add(BodyDef::dynamic().with_position(at), shape);
    let at = w.at(0.0, 1.0, 5.0);
    let shape = w.boxed(3.0, 0.5, 0.5).as_sensor();
    w.add(BodyDef::fixed().with_position(at), shape);
    for k in 0..3_u8 {
        let at = w.at(f32::from(k), 3.0, 5.0);
        let mut shape = w.ball(0.2);
        (shape.material.rolling_resistance, shape.material.spinning_resistance) = (0.02, 0.1);
        let body = BodyDef::dynamic().with_position(at).with_linear_velocity(w.at(1.0, 0.0, 2.0));
        w.add(body.with_angular_velocity([0.0, 10.0, 0.0]), shape);
    }
    let at = w.at(0.0, 1.0, -5.0);
    let mut body = BodyDef::dynamic().with_position(at);
    body.locks = AxisLocks { angular: [true; 3], ..AxisLocks::default() };
    let shape = w.boxed(0.3, 0.4, 0.3);
    w.add(body, shape);
}

fn soft_things(w: &mut Scaled) {
    let floor = w.floor();
    let s = w.s;
    let particle = ParticleDef { radius: 0.02 * s, mass: 0.1, ..ParticleDef::default() };
    let rope = RopeDef {
        pinned: [true, false],
        particle,
        ..RopeDef::between(w.at(0.0, 3.0, 0.0), w.at(3.0, 3.0, 0.0), 20)
    };
    let rope = w.world.add_rope(rope).unwrap();
    let at = w.at(3.0, 3.0, 0.0);
    let shape = w.boxed(0.2, 0.2, 0.2);
    let load = w.add(BodyDef::dynamic().with_position(at), shape);
    let held = *rope.particles.last().unwrap();
    w.world.particle_mut(held).unwrap().attach(load, Vec3::ZERO).unwrap();
    let mut cloth =
        ClothDef::new(w.at(-3.0, 1.0, 3.0), [w.at(2.0, 0.0, 0.0), w.at(0.0, 0.0, 2.0)], [10, 10]);
    cloth.particle = particle;
    w.world.add_cloth(cloth).unwrap();
    let at = w.at(-2.0, 0.3, 4.0);
    let shape = w.ball(0.3);
    w.add(BodyDef::dynamic().with_position(at), shape);
    let points: Vec<Vec3> = (0..30_u8)
        .map(|k| {
            let k = f32::from(k);
            w.at(0.1 * (k % 5.0), 2.0 + 0.3 * k, 6.0)
        })
        .collect();
    w.world.add_cloud(points, particle).unwrap();
    let at = w.at(6.0, 2.0, 0.0);
    let shape = w.boxed(0.3, 0.3, 0.3);
    let hung = w.add(BodyDef::dynamic().with_position(at), shape);
    w.joint(floor, hung, Fixed::new(), [vec3(6.0, 3.0, 0.0), Vec3::ZERO]);
}

fn run(build: Build, s: f32, method: &str, steps: usize) -> Vec<(Vec<[Vec3; 4]>, [usize; 6])> {
    let mut w = Scaled::new(s, method);
    build(&mut w);
    (0..steps)
        .map(|_| {
            w.world.step(DT);
            let e = w.world.events();
            let counts = [
                e.contact_begin.len(),
                e.contact_end.len(),
                e.hits.len(),
                e.sensor_enter.len(),
                e.sleep.len(),
                e.faults.len(),
            ];
            (w.state(), counts)
        })
        .collect()
}

fn is_the_same(name: &str, build: Build, method: &str, steps: usize) {
    let one = run(build, 1.0, method, steps);
    for s in [0.03125, 64.0] {
        let other = run(build, s, method, steps);
        for (step, (one, other)) in one.iter().zip(&other).enumerate() {
            let off = one.0.iter().zip(&other.0).position(|(a, b)| a != b);
            assert_eq!(
                off,
                None,
                "{name}, {method}, times {s}: step {step}: {:?} {:?}",
                one.0[off.unwrap_or(0)],
                other.0[off.unwrap_or(0)]
            );
            assert_eq!(one.1, other.1, "{name}, {method}, times {s}: events of step {step}");
        }
    }
}

#[test]
fn piles_and_stacks_move_alike_in_any_unit_of_length() {
    is_the_same("pile", pile, "soft-step", 240);
    is_the_same("stack", stack, "soft-step", 240);
}

#[test]
fn what_falls_on_a_mesh_moves_alike_in_any_unit_of_length() {
    is_the_same("mesh", on_mesh, "soft-step", 240);
}

#[test]
fn joints_move_alike_in_any_unit_of_length() {
    is_the_same("joints", joints, "soft-step", 180);
    is_the_same("ragdolls", ragdolls, "soft-step", 180);
}

#[test]
fn fast_driven_and_seen_things_move_alike_in_any_unit_of_length() {
    is_the_same("others", others, "soft-step", 240);
}

#[test]
fn particles_move_alike_in_any_unit_of_length() {
    is_the_same("soft things", soft_things, "soft-step", 180);
}

#[test]
fn all_methods_move_alike_in_any_unit_of_length() {
    for method in Method::NAMES {
        is_the_same("pile", pile, method, 60);
    }
}
