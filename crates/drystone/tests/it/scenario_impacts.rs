//! Impacts against closed forms: heights, energy, momentum, friction, and impacts through several
//! bodies.

use drystone::joint::Ball;
use drystone::{BodyDef, BodyId, JointDef, Material, Quat, ShapeDef, Vec3, World, vec3};

const DT: f32 = 1.0 / 60.0;
const G: f32 = 9.81;

fn material(restitution: f32, friction: f32) -> Material {
    Material { restitution, friction, ..Material::default() }
}

/// A world with a floor at y = 0.
fn floored(of: Material) -> World {
    let mut world = World::default();
    let floor = ShapeDef::half_space([0.0, 1.0, 0.0], 0.0).with_material(of);
    world.add_body(BodyDef::fixed().with_shape(floor)).unwrap();
    world
}

fn weightless() -> World {
    let mut world = World::default();
    world.set_gravity([0.0; 3]);
    world
}

/// Height of the center of a ball of radius 0.1 when it meets the floor: contacts keep a gap of
/// 5e-5 m.
const LOW: f32 = 0.1 + 5.0e-5;

fn ball(world: &mut World, at: Vec3, v: Vec3, radius: f32, of: Material) -> BodyId {
    let shape = ShapeDef::sphere(radius).with_material(of);
    world
        .add_body(BodyDef {
            can_sleep: false,
            ..BodyDef::dynamic().with_position(at).with_linear_velocity(v).with_shape(shape)
        })
        .unwrap()
}

fn velocity(world: &World, id: BodyId) -> Vec3 {
    world.body(id).unwrap().linear_velocity()
}

/// Energy over weight of a body whose center is at `low` in its lowest position: the height it can
/// reach.
fn height(world: &World, id: BodyId, low: f32) -> f32 {
    let body = world.body(id).unwrap();
    body.position().y - low + body.linear_velocity().length_squared() / (2.0 * G)
}

/// Kinetic and potential energy of all bodies [J].
fn energy(world: &World) -> f64 {
    world.kinetic_energy() + world.potential_energy()
}

#[test]
fn a_ball_rises_to_its_height_times_e_squared_from_any_height() {
    for e in [0.25_f32, 0.5, 0.75, 0.9, 1.0] {
        for drop in [0.05_f32, 0.1, 0.3, 1.0, 2.0, 5.0, 10.0] {
            let mut world = floored(material(e, 0.0));
            let id =
                ball(&mut world, vec3(0.0, LOW + drop, 0.0), Vec3::ZERO, 0.1, material(e, 0.0));
            let mut apex = None;
            for _ in 0..120 {
                world.step(DT);
                if velocity(&world, id).y > 0.0 {
                    apex = Some(height(&world, id, LOW));
                    break;
                }
            }
            // Exact up to rounding: up to 90 steps at 14 m/s and 10 m, half an ulp (4.8e-7) each,
            // and once more in the energy.
            let error = (apex.unwrap() / (e * e * drop) - 1.0).abs();
            assert!(error < 2.0e-5, "e {e}, drop {drop}: {error}");
        }
    }
}

#[test]
fn an_elastic_ball_bounces_for_ever() {
    for drop in [0.05_f32, 0.3, 5.0] {
        let mut world = floored(material(1.0, 0.0));
        let id = ball(&mut world, vec3(0.0, LOW + drop, 0.0), Vec3::ZERO, 0.1, material(1.0, 0.0));
        let (mut squares, mut most, mut bounces, mut down) = (0.0, 0.0_f32, 0_u8, true);
        for _ in 0..1200 {
            world.step(DT);
            let error = height(&world, id, LOW) / drop - 1.0;
            squares += error * error;
            most = most.max(error);
            let v = velocity(&world, id).y;
            bounces += u8::from(down && v > 0.0);
            down = v <= 0.0;
        }
        // 1,200 steps and up to 100 bounces, each rounded to 1e-6 of the speed.
        assert!((squares / 1200.0_f32).sqrt() < 1.0e-4 && most < 1.0e-4, "{drop}: {most}");
        // The duration of a bounce is 2 sqrt(2 H/g).
        let expected = 20.0 / (8.0 * drop / G).sqrt();
        assert!((f32::from(bounces) - expected).abs() < 1.5, "{drop}: {bounces} not {expected}");
    }
}

#[test]
fn elastic_bodies_at_rest_stay_at_rest() {
    for (count, edge) in [(1_u8, 1.0_f32), (10, 1.0), (5, 0.1)] {
        let mut world = floored(material(1.0, 0.5));
        let mut ids = Vec::new();
        for i in 0..count {
            let y = edge * (0.5 + f32::from(i));
            let shape =
                ShapeDef::box_half(Vec3::splat(0.5 * edge)).with_material(material(1.0, 0.5));
            let mut def = BodyDef::dynamic().with_position([0.0, y, 0.0]).with_shape(shape);
            def.can_sleep = false;
            ids.push(world.add_body(def).unwrap());
        }
        let mut fastest = 0.0_f32;
        for step in 0..600 {
            world.step(DT);
            if step > 60 {
                for id in &ids {
                    fastest = fastest.max(velocity(&world, *id).length());
                }
            }
        }
        // A bounce would be faster than the speed gravity adds in a step, 0.16 m/s. A stack of ten
        // settles softly, over seconds, by 0.17 mm for each cube above a contact.
        assert!(fastest < 2.0e-3, "{count} cubes of {edge}: {fastest}");
    }
}

#[test]
fn a_spinning_super_ball_never_gains_energy() {
    let mut world = floored(material(1.0, 1.0));
    let lid = ShapeDef::half_space([0.0, -1.0, 0.0], -3.0).with_material(material(1.0, 1.0));
    world.add_body(BodyDef::fixed().with_shape(lid)).unwrap();
    for x in [-1.0, 1.0] {
        let wall = ShapeDef::half_space([x, 0.0, 0.0], -1.0).with_material(material(1.0, 1.0));
        world.add_body(BodyDef::fixed().with_shape(wall)).unwrap();
    }
    let id = ball(&mut world, vec3(0.0, 1.0, 0.0), vec3(6.0, -8.0, 1.0), 0.2, material(1.0, 1.0));
    world.body_mut(id).unwrap().set_angular_velocity([3.0, 0.0, -20.0]);
    let start = energy(&world);
    let mut least = start;
    let (mut growth, mut turns, mut last) = (0.0_f64, 0, 3.0_f32);
    for _ in 0..1200 {
        world.step(DT);
        let now = energy(&world);
        growth = growth.max(now / least - 1.0);
        least = least.min(now);
        let x = velocity(&world, id).x;
        turns += i32::from(x * last < 0.0);
        last = x;
    }
    // f32 keeps a step's energy to 1e-6.
    assert!(growth < 1.0e-5, "{growth}");
    assert!(turns > 10, "{turns}");
}

#[test]
fn elastic_cubes_on_edges_and_corners_never_gain_energy() {
    let corner = [1.0, 0.0, -1.0];
    // Flat, on an edge, on a corner, oblique, nearly flat.
    let turns = [
        (corner, 0.0_f32),
        ([1.0, 0.0, 0.0], core::f32::consts::FRAC_PI_4),
        (corner, 0.955_317),
        (corner, 0.3),
        (corner, 0.02),
    ];
    for friction in [0.0, 0.5, 1.0] {
        for (axis, angle) in turns {
            for drop in [1.0_f32, 5.0] {
                let mut world = floored(material(1.0, friction));
                let turn = Quat::from_axis_angle(axis, angle);
                let shape =
                    ShapeDef::box_half(Vec3::splat(0.5)).with_material(material(1.0, friction));
                let def = BodyDef::dynamic().with_position([0.0, drop, 0.0]).with_rotation(turn);
                world.add_body(def.with_shape(shape)).unwrap();
                let (start, mut most, mut last) = (energy(&world), 0.0_f64, 0.0);
                for _ in 0..600 {
                    world.step(DT);
                    last = energy(&world) / start;
                    most = most.max(last - 1.0);
                }
                // A round is solved to 1e-5 of the speed; a dozen impacts.
                assert!(most < 2.0e-4, "mu {friction}, turned {angle}, from {drop}: {most}");
                if friction == 0.0 {
                    // Rows are those of the step's start: the error is the square of the rotation
                    // in a step.
                    assert!(last > 0.98, "turned {angle}, from {drop}: {last}");
                }
            }
        }
    }
}

#[test]
fn an_elastic_cube_that_falls_flat_bounces_back_flat() {
    for friction in [0.0, 0.5, 1.0] {
        let mut world = floored(material(1.0, friction));
        let shape = ShapeDef::box_half(Vec3::splat(0.5)).with_material(material(1.0, friction));
        let def = BodyDef::dynamic().with_position([0.0, 2.5, 0.0]).with_shape(shape);
        let id = world.add_body(def).unwrap();
        for _ in 0..300 {
            world.step(DT);
        }
        // Each of 4 impacts is solved to 1e-5, and a spin grows by a small factor between impacts.
        let end = height(&world, id, 0.5) / 2.0;
        assert!((end - 1.0).abs() < 1.0e-3, "mu {friction}: {end}");
    }
}

/// Velocities after `incoming` balls at `speed` hit the rest of a row of five, `gap` apart, without
/// gravity.
fn row(incoming: u8, gap: f32, speed: f32) -> Vec<f32> {
    let mut world = weightless();
    let mut ids = Vec::new();
    for i in 0..5_u8 {
        let strikes = i < incoming;
        let x = (1.0 + gap) * f32::from(i) - if strikes { 0.5 } else { 0.0 };
        let v = if strikes { speed } else { 0.0 };
        ids.push(ball(&mut world, vec3(x, 0.0, 0.0), vec3(v, 0.0, 0.0), 0.5, material(1.0, 0.0)));
    }
    for _ in 0..60 {
        world.step(DT);
    }
    ids.iter().map(|id| velocity(&world, *id).x).collect()
}

#[test]
fn as_many_balls_leave_a_row_as_came_in() {
    for gap in [0.0, 0.001, 0.02] {
        for incoming in 1..=4 {
            for speed in [1.0_f32, 3.0, 10.0] {
                let v = row(incoming, gap, speed);
                for (i, v) in (0..).zip(&v) {
                    let expected = if i >= 5 - incoming { speed } else { 0.0 };
                    // Touching balls overlap by the contact gap, 5e-5 m, and are pushed out at 20
                    // /s or less.
                    let error = (v - expected).abs();
                    assert!(error < 2.0e-3 + 1.0e-6 * speed, "{incoming} in, gap {gap}: {v}");
                }
            }
        }
    }
}

#[test]
fn a_cradle_of_touching_balls_sends_out_what_came_in() {
    for pulled in 1..=3_u8 {
        let mut world = World::default();
        let beam = world.add_body(BodyDef::fixed().with_position([0.0, 2.0, 0.0])).unwrap();
        let mut ids = Vec::new();
        let angle = 0.5_f32;
        for i in 0..5_u8 {
            let turn =
                Quat::from_axis_angle([0.0, 0.0, 1.0], if i < pulled { -angle } else { 0.0 });
            let at = vec3(0.2 * f32::from(i), 2.0, 0.0) + turn.rotate(vec3(0.0, -1.5, 0.0));
            let shape = ShapeDef::sphere(0.1).with_material(material(1.0, 0.0));
            let def = BodyDef { can_sleep: false, ..BodyDef::dynamic() };
            let def = def.with_position(at).with_rotation(turn).with_shape(shape);
            let id = world.add_body(def).unwrap();
            let joint = JointDef::new(beam, id, Ball::new())
                .with_anchors([0.2 * f32::from(i), 0.0, 0.0], [0.0, 1.5, 0.0]);
            world.add_joint(joint).unwrap();
            ids.push(id);
        }
        let mut reach = [0.0_f32; 5];
        for _ in 0..110 {
            world.step(DT);
            for (i, id) in (0_u8..).zip(&ids) {
                let x = world.body(*id).unwrap().position().x - 0.2 * f32::from(i);
                reach[usize::from(i)] = reach[usize::from(i)].max(x);
            }
        }
        let out = 1.5 * 0.479_426;
        for (i, farthest) in (0..).zip(reach) {
            // The apex lies between two steps: half a step from it the ball is w² dt²/8 = 2e-4 of
            // its height lower. Balls at rest are pushed out of 5e-5 m at 1 mm/s, for up to a
            // second.
            let right = if i >= 5 - pulled { farthest / out > 0.995 } else { farthest < 0.004 };
            assert!(right, "{pulled} pulled: {reach:?}");
        }
    }
}

#[test]
fn a_ball_into_two_that_touch_parts_them_alike() {
    // Elastic, all three at once: the ball returns at -v/5, the two leave at 2 sqrt(3) v/5.
    let mut world = weightless();
    let of = material(1.0, 0.0);
    let side = 0.5 * 3.0_f32.sqrt();
    let cue = ball(&mut world, vec3(-1.0e-4, 0.0, 0.0), vec3(2.0, 0.0, 0.0), 0.5, of);
    let left = ball(&mut world, vec3(side, 0.5, 0.0), Vec3::ZERO, 0.5, of);
    let right = ball(&mut world, vec3(side, -0.5, 0.0), Vec3::ZERO, 0.5, of);
    for _ in 0..60 {
        world.step(DT);
    }
    let [c, l, r] = [cue, left, right].map(|id| velocity(&world, id));
    assert!((c.x + 0.4).abs() < 1e-3 && c.y.abs() < 1e-4);
    assert!((l.x - r.x).abs() < 1e-4 && (l.y + r.y).abs() < 1e-4);
    assert!((l.length() - 0.8 * 3.0_f32.sqrt()).abs() < 1e-3);
}

#[test]
fn a_break_of_fifteen_keeps_energy_and_momentum() {
    let run = || {
        let mut world = weightless();
        let of = material(1.0, 0.0);
        let mut ids = vec![ball(&mut world, vec3(-0.5, 0.0, 0.0), vec3(8.0, 0.0, 0.0), 0.03, of)];
        for row in 0..5_u8 {
            for i in 0..=row {
                let x = 0.06 * 0.75_f32.sqrt() * f32::from(row);
                let y = 0.06 * (f32::from(i) - 0.5 * f32::from(row));
                ids.push(ball(&mut world, vec3(x, y, 0.0), Vec3::ZERO, 0.03, of));
            }
        }
        let start = world.kinetic_energy();
        for _ in 0..60 {
            world.step(DT);
        }
        let v: Vec<Vec3> = ids.iter().map(|id| velocity(&world, *id)).collect();
        (v, world.kinetic_energy() / start)
    };
    let (v, kept) = run();
    let total = v.iter().fold(Vec3::ZERO, |sum, v| sum + *v);
    assert!((kept - 1.0).abs() < 1.0e-4, "{kept}");
    // Each pair's impulses are opposite up to rounding.
    assert!((total - vec3(8.0, 0.0, 0.0)).length() < 8.0e-6);
    assert_eq!(run().0, v);
}

#[test]
fn two_balls_part_by_the_law_of_restitution_whatever_the_masses() {
    for ratio in [1.0_f32, 10.0, 1000.0] {
        for e in [0.5_f32, 1.0] {
            let mut world = weightless();
            let mut add = |x: f32, v: f32, m: f32| {
                let shape = ShapeDef::sphere(0.5).with_material(material(e, 0.0));
                let def = BodyDef::dynamic().with_position([x, 0.0, 0.0]).with_shape(shape);
                world.add_body(def.with_mass(m).with_linear_velocity([v, 0.0, 0.0])).unwrap()
            };
            let (a, b) = (add(-1.0, 3.0, 1.0), add(1.0, -1.0, ratio));
            for _ in 0..60 {
                world.step(DT);
            }
            let (va, vb) = (velocity(&world, a).x, velocity(&world, b).x);
            let total = 3.0 - ratio;
            assert!((vb - va - 4.0 * e).abs() < 1.0e-5, "{ratio}, e {e}: {va} {vb}");
            let error = (va + ratio * vb - total).abs() / (3.0 + ratio);
            assert!(error < 1.0e-6, "{ratio}, e {e}: {error}");
        }
    }
}

#[test]
fn an_oblique_impact_rubs_by_the_impulse_of_the_whole_bounce() {
    for e in [0.5_f32, 1.0] {
        for (mu, vt) in [(0.1_f32, 5.0_f32), (0.5, 2.0), (1.0, 4.0)] {
            let mut world = weightless();
            let floor = ShapeDef::half_space([0.0, 1.0, 0.0], 0.0).with_material(material(e, mu));
            world.add_body(BodyDef::fixed().with_shape(floor)).unwrap();
            let id =
                ball(&mut world, vec3(0.0, 1.0, 0.0), vec3(vt, -4.0, 0.0), 0.25, material(e, mu));
            for _ in 0..30 {
                world.step(DT);
            }
            let v = velocity(&world, id);
            let slides = 3.5 * mu * (1.0 + e) * 4.0 < vt;
            let expected = if slides { vt - mu * (1.0 + e) * 4.0 } else { 5.0 / 7.0 * vt };
            // Friction's lever arm is longer by the contact gap of 5e-5 m: 2e-4 of the radius.
            assert!((v.x / expected - 1.0).abs() < 5.0e-4, "{v:?} not {expected}");
            assert!((v.y - 4.0 * e).abs() < 1.0e-5);
        }
    }
}

#[test]
fn two_hundred_elastic_balls_keep_their_energy() {
    let mut world = floored(material(1.0, 0.0));
    for x in [-1.0_f32, 1.0] {
        for n in [vec3(x, 0.0, 0.0), vec3(0.0, 0.0, x)] {
            let wall = ShapeDef::half_space(n, -1.0).with_material(material(1.0, 0.0));
            world.add_body(BodyDef::fixed().with_shape(wall)).unwrap();
        }
    }
    let mut seed = 42_u32;
    let mut random = || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (seed >> 8) as f32 / 16_777_216.0 * 0.001
    };
    for i in 0..216_u16 {
        let grid = [i % 6, i / 6 % 6, i / 36].map(|k| 0.21 * f32::from(k));
        let at = vec3(
            grid[0] - 0.525 + random(),
            1.101 + grid[1] + random(),
            grid[2] - 0.525 + random(),
        );
        ball(&mut world, at, Vec3::ZERO, 0.1, material(1.0, 0.0));
    }
    let start = energy(&world);
    for step in 1..=600_u16 {
        world.step(DT);
        // No energy is gained. Each substep of an impact loses a² h²/2 per kilogram, of an initial
        // 17 J. If all balls collided in all steps, they would lose 0.6 % per second (in fact four
        // in ten do). Two slow balls that a fast one hits in the same step may miss each other's
        // impact. They overlap for a moment, and pushing them out costs up to a hundredth.
        let now = energy(&world) / start;
        let lost = 0.01 + 0.006 * f64::from(step) / 60.0;
        assert!((1.0 - lost..1.001).contains(&now), "{now}");
    }
}
