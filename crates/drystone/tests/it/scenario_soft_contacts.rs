//! Contacts that yield like springs, and restitution by rules or hooks.

use core::f64::consts::TAU;
use std::sync::Arc;

use drystone::contact::{ContactHooks, ContactSoftness, HookedContact, SurfaceRule};
use drystone::joint::Fixed;
use drystone::threads::Team;
use drystone::{BodyDef, BodyId, JointDef, Pose, Quat, ShapeDef, Vec3, World, WorldConfig};

use crate::floors::square;

const G: f64 = 9.81;
const DT: f32 = 1.0 / 60.0;
/// A substep [s].
const H: f64 = 1.0 / 480.0;
/// Distance between bodies at rest [m].
const REST: f64 = 5.0e-5;

fn awake_world() -> World {
    let mut config = WorldConfig::default();
    config.sleep.enabled = false;
    World::new(config).unwrap()
}

fn soft(hertz: f32, damping_ratio: f32) -> SurfaceRule {
    let softness = Some(ContactSoftness { hertz, damping_ratio });
    SurfaceRule { softness, ..SurfaceRule::ANY }
}

fn floor(world: &mut World) -> BodyId {
    let floor = ShapeDef::half_space(Vec3::Y, 0.0);
    world.add_body(BodyDef::fixed().with_shape(floor)).unwrap()
}

/// Adds a body with its center at this height [m].
fn body(world: &mut World, shape: ShapeDef, y: f64) -> BodyId {
    #[expect(clippy::cast_possible_truncation, reason = "a place")]
    let body = BodyDef::dynamic().with_position([0.0, y as f32, 0.0]);
    world.add_body(body.with_shape(shape)).unwrap()
}

fn height(world: &World, id: BodyId) -> f64 {
    f64::from(world.body(id).unwrap().position().y)
}

/// A ball on a spring of frequency `hertz` that acts below height 0, integrated per substep by the
/// implicit Euler method, as a soft contact is [Catto11]. The spring acts in a substep in which the
/// ball reaches it.
struct Sprung {
    omega: f64,
    zeta: f64,
    /// Height over the surface [m], speed [m/s].
    y: f64,
    v: f64,
}

impl Sprung {
    fn new(hertz: f32, zeta: f32, y: f64) -> Self {
        Self { omega: TAU * f64::from(hertz), zeta: f64::from(zeta), y, v: 0.0 }
    }

    fn step(&mut self) {
        for _ in 0..8 {
            let free = self.v - G * H;
            let wh = self.omega * H;
            let held = (free - self.omega * wh * self.y) / (1.0 + 2.0 * self.zeta * wh + wh * wh);
            self.v = if self.y + free * H < 0.0 { held.max(free) } else { free };
            self.y += self.v * H;
        }
    }
}

#[test]
fn what_lies_on_a_spring_sinks_in_by_its_weight_over_its_stiffness() {
    // A cube's four points carry a quarter each, and a corner is pushed as by a quarter of the
    // mass: g / (2πf)² again.
    for shape in [ShapeDef::sphere(0.5), ShapeDef::box_half([0.5; 3])] {
        for hertz in [1.0, 2.0, 8.0] {
            let mut world = awake_world();
            let floor = floor(&mut world);
            let sag = G / (TAU * f64::from(hertz)).powi(2);
            let id = body(&mut world, shape.clone(), 0.5);
            world.set_surface_between(id, floor, Some(soft(hertz, 1.0))).unwrap();
            (0..600).for_each(|_| world.step(DT));
            let found = 0.5 + REST - height(&world, id);
            // Critically damped: after ten seconds e^-62 of the displacement remains. Positions are
            // accurate to 6e-8.
            assert!((found - sag).abs() < 1.0e-3 * sag, "{hertz} Hz: {found} m, not {sag}");
        }
    }
}

#[test]
fn a_spring_swings_and_is_damped_as_its_ratio_says() {
    for (hertz, zeta) in [(1.5, 0.0), (2.0, 0.1), (3.0, 0.3), (4.0, 0.7), (40.0, 0.05)] {
        let mut world = awake_world();
        let floor = floor(&mut world);
        let id = body(&mut world, ShapeDef::sphere(0.5), 0.5 + REST);
        world.set_surface_between(floor, id, Some(soft(hertz, zeta))).unwrap();
        let mut known = Sprung::new(hertz, zeta, 0.0);
        let mut far = 0.0_f64;
        for _ in 0..180 {
            world.step(DT);
            known.step();
            far = far.max((height(&world, id) - 0.5 - REST - known.y).abs());
        }
        // 1440 substeps of rounding at a height of 0.5 m, amplified to the swing.
        let rounding = 1440.0 * 0.5 * f64::from(f32::EPSILON);
        assert!(far < rounding, "{hertz} Hz, {zeta}: {far} m off");
    }
}

#[test]
fn what_falls_on_a_spring_is_thrown_back() {
    let (hertz, drop) = (3.0, 1.0);
    let mut world = awake_world();
    let floor = floor(&mut world);
    let id = body(&mut world, ShapeDef::sphere(0.5), 0.5 + REST + drop);
    world.set_surface_between(floor, id, Some(soft(hertz, 0.0))).unwrap();
    let mut known = Sprung::new(hertz, 0.0, drop);
    let (mut deepest, mut again) = (0.0_f64, 0.0_f64);
    for step in 0..90 {
        world.step(DT);
        known.step();
        let y = height(&world, id) - 0.5 - REST;
        // Flight is exact. With the Euler method the ball lags by g h t / 2, and again by the error
        // of its take-off speed.
        assert!((y - known.y).abs() < G * H * 1.5, "step {step}: {y}, not {}", known.y);
        deepest = deepest.min(y);
        again = if y > 0.0 && deepest < 0.0 { again.max(y) } else { again };
    }
    // The method itself damps by e^(-π ω h) in half a swing.
    let part = (-0.5 * TAU * TAU * f64::from(hertz) * H).exp();
    assert!(again > 0.9 * part * drop && again < drop, "{again} m, {part}");
}

/// Joints bound the energy that impulses add to their island; the energy that a spring returns does
/// not count.
#[test]
fn what_joints_hold_together_is_thrown_back_too() {
    let (hertz, drop) = (3.0, 1.0);
    let mut world = awake_world();
    let floor = floor(&mut world);
    let y = 0.5 + REST + drop;
    let [a, b] = [-0.6, 0.6].map(|x| {
        let id = body(&mut world, ShapeDef::sphere(0.5), y);
        let pose = Pose { position: Vec3::X * x + Vec3::Y * 1.5, rotation: Quat::IDENTITY };
        world.body_mut(id).unwrap().set_pose(pose);
        world.set_surface_between(floor, id, Some(soft(hertz, 0.0))).unwrap();
        id
    });
    let middle = JointDef::new(a, b, Fixed::new()).with_anchors([0.6, 0.0, 0.0], [-0.6, 0.0, 0.0]);
    world.add_joint(middle).unwrap();
    let (mut lowest, mut again) = (y, 0.0_f64);
    for _ in 0..90 {
        world.step(DT);
        let y = height(&world, a) - 0.5 - REST;
        lowest = lowest.min(y);
        again = if y > 0.0 && lowest < 0.0 { again.max(y) } else { again };
    }
    let part = (-0.5 * TAU * TAU * f64::from(hertz) * H).exp();
    assert!(again > 0.9 * part * drop && again < drop, "{again} m, {part}");
}

#[test]
fn two_bodies_bounce_by_their_own_restitution() {
    for (e, on_mesh) in [(0.5, false), (0.8, false), (0.8, true)] {
        let mut world = awake_world();
        let shape = if on_mesh { square(5.0) } else { ShapeDef::half_space(Vec3::Y, 0.0) };
        let floor = world.add_body(BodyDef::fixed().with_shape(shape)).unwrap();
        let id = body(&mut world, ShapeDef::sphere(0.25), 1.25);
        #[expect(clippy::cast_possible_truncation, reason = "a ratio")]
        let bouncy = SurfaceRule { restitution: Some(e as f32), ..SurfaceRule::ANY };
        world.set_surface_between(id, floor, Some(bouncy)).unwrap();
        assert_eq!(world.surface_between(floor, id), Some(bouncy));
        let mut most = 0.0_f64;
        for _ in 0..60 {
            world.step(DT);
            let v = f64::from(world.body(id).unwrap().linear_velocity().y);
            if v > 0.0 {
                most = most.max(height(&world, id) - 0.25 + 0.5 * v * v / G);
            }
        }
        // Relative to 1 m: the detection distance of half a substep at 4.4 m/s, and the loss of
        // substeps in a fall: g h v.
        assert!((most - e * e).abs() < 0.01, "{e}: {most} m");
    }
}

/// By the number of the other shape: 1 is soft, 2 bounces, 3 is disabled.
struct Bed;

impl ContactHooks for Bed {
    fn contact(&self, contact: &mut HookedContact<'_>) {
        match contact.user_data_a() | contact.user_data_b() {
            1 => {
                let before = contact.softness();
                contact.set_softness(Some(ContactSoftness { hertz: f32::NAN, damping_ratio: 0.0 }));
                assert_eq!(contact.softness(), before);
                contact.set_softness(soft(3.0, 0.2).softness);
            }
            2 => {
                contact.set_restitution(f32::NAN);
                contact.set_restitution(0.7);
            }
            3 => contact.drop_contact(),
            _ => {}
        }
    }
}

fn hooked(shape: ShapeDef, user_data: u64) -> ShapeDef {
    ShapeDef { user_data, ..shape.with_hooks() }
}

#[test]
fn hooks_soften_and_bounce_as_rules_do() {
    let bouncy = SurfaceRule { restitution: Some(0.7), ..SurfaceRule::ANY };
    for (number, rule) in [(1, soft(3.0, 0.2)), (2, bouncy)] {
        for shape in [ShapeDef::sphere(0.25), ShapeDef::box_half([0.25; 3])] {
            for ground in [ShapeDef::half_space(Vec3::Y, 0.0), square(5.0)] {
                let run = |by_hooks: bool| {
                    let mut world = awake_world();
                    let floor = BodyDef::fixed().with_shape(ground.clone());
                    let floor = world.add_body(floor).unwrap();
                    // The hooks run for both, because results are not cached between steps.
                    let number = if by_hooks { number } else { 0 };
                    let id = body(&mut world, hooked(shape.clone(), number), 0.8);
                    if !by_hooks {
                        world.set_surface_between(floor, id, Some(rule)).unwrap();
                    }
                    (0..120).for_each(|_| world.step_with(DT, &Bed));
                    (world.body(id).unwrap().pose(), world.body(id).unwrap().linear_velocity())
                };
                assert_eq!(run(true), run(false), "{number}");
            }
        }
    }
}

#[test]
fn soft_and_bouncy_piles_are_the_same_on_any_number_of_threads_and_from_a_snapshot() {
    let make = |threads: usize| {
        let mut world = World::default().with_executor(Arc::new(Team::with_threads(threads)));
        floor(&mut world);
        let mut last = None;
        for i in 0..120_u16 {
            let [x, y, z] = [i % 6, i / 36, i / 6 % 6].map(f32::from);
            let shape = hooked(ShapeDef::box_half([0.25; 3]), u64::from(i % 5));
            let body = BodyDef::dynamic().with_position([0.51 * x, 0.3 + 0.6 * y, 0.51 * z]);
            let id = world.add_body(body.with_shape(shape)).unwrap();
            if let Some(last) = last
                && i % 7 == 0
            {
                world.set_surface_between(last, id, Some(soft(6.0, 0.5))).unwrap();
            }
            last = Some(id);
        }
        world
    };
    let run = |world: &mut World| {
        (0..70).for_each(|_| world.step_with(DT, &Bed));
        (world.state_hash(), world.events().clone())
    };
    let one = run(&mut make(1));
    for threads in [2, 4] {
        assert_eq!(run(&mut make(threads)), one);
    }
    let mut world = make(2);
    (0..40).for_each(|_| world.step_with(DT, &Bed));
    let mut again = World::restore(&world.snapshot()).unwrap();
    for world in [&mut world, &mut again] {
        (40..70).for_each(|_| world.step_with(DT, &Bed));
        assert_eq!((world.state_hash(), world.events().clone()), one);
    }
}

#[test]
fn a_shot_flies_through_what_hooks_drop() {
    // A fixed wall, a wall of triangles, a dynamic box, and a box that approaches.
    let thin = || ShapeDef::box_half([0.05, 2.0, 2.0]);
    let targets = [
        BodyDef::fixed().with_shape(thin()),
        BodyDef::fixed()
            .with_rotation(Quat::from_axis_angle(Vec3::Z, 1.57))
            .with_shape(square(2.0)),
        BodyDef::dynamic().with_shape(thin()),
        BodyDef::dynamic().with_linear_velocity([-80.0, 0.0, 0.0]).with_shape(thin()),
    ];
    for (which, target) in targets.into_iter().enumerate() {
        for (number, passes) in [(0, false), (3, true)] {
            for shape in [ShapeDef::sphere(0.05), ShapeDef::capsule(0.4, 0.05)] {
                let mut world = World::default();
                world.set_gravity(Vec3::ZERO);
                let target = world.add_body(target.clone()).unwrap();
                let shot = BodyDef::dynamic()
                    .with_position([-3.0, 0.0, 0.0])
                    .with_linear_velocity([200.0, 0.0, 0.0])
                    .with_angular_velocity([0.0, 0.0, 3.0])
                    .with_shape(hooked(shape, number));
                let shot = world.add_body(shot).unwrap();
                (0..3).for_each(|_| world.step_with(DT, &Bed));
                let at = |id: BodyId| world.body(id).unwrap().position().x;
                assert_eq!(at(shot) > at(target), passes, "target {which}: {} m", at(shot));
                let speed = world.body(shot).unwrap().linear_velocity().x;
                assert_eq!(speed > 199.9, passes, "target {which}: {speed} m/s");
            }
        }
    }
}
