//! Motion of single bodies against closed forms.

use drystone::math::Sym3;
use drystone::{BodyDef, MassDef, Quat, ShapeDef, Vec3, World, vec3};

const DT: f32 = 1.0 / 60.0;

#[test]
fn a_thrown_body_follows_its_parabola_exactly() {
    let mut world = World::default();
    let def = BodyDef::dynamic().with_shape(ShapeDef::sphere(0.5));
    let id = world.add_body(def.with_linear_velocity([3.0, 10.0, -2.0])).unwrap();
    for _ in 0..120 {
        world.step(DT);
    }
    // Exact up to rounding: 120 additions at up to 6 m, half an ulp (2.4e-7) each.
    let t = 2.0;
    let expected = vec3(3.0 * t, 10.0 * t - 0.5 * 9.81 * t * t, -2.0 * t);
    let error = (world.body(id).unwrap().position() - expected).length();
    assert!(error < 120.0 * 2.4e-7 * 2.0, "{error}");
}

#[test]
fn a_tumbling_body_keeps_its_angular_momentum_and_energy() {
    let mut world = World::default();
    world.set_gravity([0.0; 3]);
    let inertia = Sym3::diagonal(vec3(1.0, 2.0, 3.0));
    let def = BodyDef {
        mass: MassDef::Exact { mass: 1.0, center: Vec3::ZERO, inertia },
        ..BodyDef::dynamic().with_angular_velocity([0.1, 10.0, 0.0])
    };
    let id = world.add_body(def).unwrap();
    let momentum = |world: &World| {
        let b = world.body(id).unwrap();
        b.inertia().mul(b.angular_velocity())
    };
    let (l0, e0) = (momentum(&world), world.kinetic_energy());
    let mut flips = Vec::new();
    let mut side = 1.0;
    for step in 0..1200_u16 {
        world.step(DT);
        let b = world.body(id).unwrap();
        let local = b.rotation().unrotate(b.angular_velocity());
        if local.y * side < 0.0 {
            flips.push(f32::from(step + 1) * DT);
            side = -side;
        }
    }
    // The splitting conserves L; w and q are rounded to f32 once per step: sqrt(1200) * 6e-8 * a
    // few.
    let drift = (momentum(&world) - l0).length() / l0.length();
    assert!(drift < 1e-5, "{drift}");
    // Energy oscillates by (ω h)² = 4e-4 and does not drift.
    assert!((world.kinetic_energy() / e0 - 1.0).abs() < 4e-4);
    // The axis flips at K/p = 1.0377 s and every 2K/p = 2.07546 s (elliptic integral K). Flips are
    // detected at the end of a step, 17 ms. The relative error of the splitting's period is (ω h)²,
    // 8 ms in 20 s. f32 rounding of the energy by 1e-6 shifts a flip by 1.5 ms, 5 ms at random over
    // ten.
    assert_eq!(flips.len(), 10, "{flips:?}");
    for (k, flip) in (0_u8..).zip(&flips) {
        let exact = 1.0377 + 2.07546 * f32::from(k);
        assert!((flip - exact).abs() < 0.03, "{flips:?}");
    }
}

#[test]
fn a_symmetric_top_follows_its_closed_form_however_fast_it_spins() {
    for (spin, steps) in [(5.0, 600_u16), (60.0, 60), (400.0, 5)] {
        let mut world = World::default();
        world.set_gravity([0.0; 3]);
        let inertia = Sym3::diagonal(vec3(1.0, 1.0, 2.0));
        let w = vec3(0.6, 0.0, 0.8) * spin;
        let def = BodyDef {
            mass: MassDef::Exact { mass: 1.0, center: Vec3::ZERO, inertia },
            ..BodyDef::dynamic().with_angular_velocity(w)
        };
        let id = world.add_body(def).unwrap();
        for _ in 0..steps {
            world.step(DT);
        }
        // Moments a, a, c: the body rotates at L/a about its momentum and at L_z (1/c - 1/a) about
        // its axis.
        let (l, t) = (vec3(w.x, 0.0, 2.0 * w.z), f32::from(steps) * DT);
        let about = Quat::from_axis_angle(l.try_normalize().unwrap(), l.length() * t);
        let own = Quat::from_axis_angle(Vec3::Z, l.z * (0.5 - 1.0) * t);
        let (expected, found) = (about * own, world.body(id).unwrap().rotation());
        let numbers = |q: Quat| [q.x, q.y, q.z, q.w];
        let chord = |sign: f32| {
            let pairs = numbers(expected).into_iter().zip(numbers(found));
            pairs.map(|(x, y)| (x - sign * y) * (x - sign * y)).sum::<f32>().sqrt()
        };
        let angle = 2.0 * chord(1.0).min(chord(-1.0));
        // ω is rounded to f32 in every step, by 6e-8 of it at random. sqrt(600) of that, times the
        // angle of 90 rad, is 1.3e-4. The closed form's own angles are rounded to 4e-6.
        assert!(angle < 3.0e-4, "{spin}: {angle}");
    }
}

#[test]
fn bodies_that_fly_side_by_side_collide_as_if_at_rest() {
    let after = |speed: f32| {
        let mut world = World::default();
        world.set_gravity([0.0; 3]);
        let ball = |x: f32, v: f32| {
            BodyDef::dynamic()
                .with_position([x, 0.0, 0.0])
                .with_shape(ShapeDef::sphere(0.5).with_restitution(1.0).with_friction(0.0))
                .with_linear_velocity([v, speed, 0.0])
        };
        let ids = [(-2.0, 3.0), (2.0, -3.0)].map(|(x, v)| world.add_body(ball(x, v)).unwrap());
        for _ in 0..90 {
            world.step(DT);
        }
        ids.map(|id| world.body(id).unwrap().linear_velocity().x)
    };
    for speed in [0.0, 20.0, 250.0] {
        let [left, right] = after(speed);
        // Elastic, equal masses: they exchange velocities. At 250 m/s for 1.5 s positions are
        // rounded to 3e-5 m, which is 2 mm/s in a step.
        assert!((left + 3.0).abs() < 0.02 && (right - 3.0).abs() < 0.02, "{speed}: {left} {right}");
    }
}

#[test]
fn a_ball_bounces_back_to_its_height_times_e_squared() {
    for e in [0.3_f32, 0.5, 0.8, 1.0] {
        let mut world = World::default();
        let floor = ShapeDef::half_space([0.0, 1.0, 0.0], 0.0);
        world.add_body(BodyDef::fixed().with_shape(floor)).unwrap();
        let ball = ShapeDef::sphere(0.5).with_restitution(e);
        let id = world
            .add_body(BodyDef::dynamic().with_position([0.0, 2.5, 0.0]).with_shape(ball))
            .unwrap();
        let (mut up, mut apex) = (false, 0.0_f32);
        for _ in 0..120 {
            world.step(DT);
            let body = world.body(id).unwrap();
            up |= body.linear_velocity().y > 0.1;
            if up {
                apex = apex.max(body.position().y - 0.5);
                if body.linear_velocity().y < 0.0 {
                    break;
                }
            }
        }
        // The apex lies between two steps: g dt²/8 = 0.3 mm; the impact is anywhere in its step.
        let expected = 2.0 * e * e;
        assert!((apex - expected).abs() < 0.02 * expected + 0.01, "e {e}: {apex} not {expected}");
    }
}

#[test]
fn a_ball_rolls_down_a_slope_with_five_sevenths_of_the_slide() {
    let mut world = World::default();
    let slope = 0.3_f32;
    let turn = Quat::from_axis_angle([0.0, 0.0, 1.0], slope);
    let floor = ShapeDef::box_half([100.0, 1.0, 20.0]);
    let normal = turn.rotate(Vec3::Y);
    world
        .add_body(BodyDef::fixed().with_position(-normal).with_rotation(turn).with_shape(floor))
        .unwrap();
    let ball = BodyDef::dynamic().with_position(normal * 0.5).with_shape(ShapeDef::sphere(0.5));
    let id = world.add_body(ball).unwrap();
    for _ in 0..120 {
        world.step(DT);
    }
    let (sin, _) = drystone::math::trig::sin_cos(slope);
    let expected = 5.0 / 7.0 * 9.81 * sin * 2.0;
    let speed = world.body(id).unwrap().linear_velocity().length();
    assert!((speed / expected - 1.0).abs() < 0.01, "{speed} not {expected}");
}

#[test]
fn rolling_resistance_stops_a_ball_and_less_of_it_does_not_hold_it_on_a_slope() {
    let run = |resistance: f32| {
        let mut world = World::default();
        let floor = ShapeDef::half_space([0.0, 1.0, 0.0], 0.0);
        world.add_body(BodyDef::fixed().with_shape(floor)).unwrap();
        let mut ball = ShapeDef::sphere(0.5);
        ball.material.rolling_resistance = resistance;
        let def = BodyDef::dynamic().with_position([0.0, 0.5, 0.0]).with_shape(ball);
        let def = def.with_linear_velocity([2.0, 0.0, 0.0]).with_angular_velocity([0.0, 0.0, -4.0]);
        let id = world.add_body(def).unwrap();
        for _ in 0..300 {
            world.step(DT);
        }
        world.body(id).unwrap().position().x
    };
    // Torque k m g r on a rolling ball: a = (5/7) k g, so it stops after v²/(2 a).
    let expected = 4.0 / (2.0 * 5.0 / 7.0 * 0.1 * 9.81);
    let x = run(0.1);
    assert!((x / expected - 1.0).abs() < 0.03, "{x} not {expected}");
    assert!((run(0.0) - 10.0).abs() < 0.05, "without it the ball rolls on");
}

#[test]
fn a_collision_keeps_momentum_whatever_the_masses() {
    for ratio in [1.0_f32, 10.0, 1000.0] {
        let mut world = World::default();
        world.set_gravity([0.0; 3]);
        let ball = |x: f32, v: f32, mass: f32| {
            BodyDef::dynamic()
                .with_position([x, 0.0, 0.0])
                .with_linear_velocity([v, 0.0, 0.0])
                .with_shape(ShapeDef::sphere(0.5).with_restitution(1.0))
                .with_mass(mass)
        };
        let a = world.add_body(ball(-1.0, 3.0, 1.0)).unwrap();
        let b = world.add_body(ball(1.0, -1.0, ratio)).unwrap();
        for _ in 0..60 {
            world.step(DT);
        }
        let (va, vb) = (
            world.body(a).unwrap().linear_velocity().x,
            world.body(b).unwrap().linear_velocity().x,
        );
        let total = 3.0 - ratio;
        let relative = 4.0;
        // Elastic: the relative velocity is reversed, the total momentum is constant.
        assert!((vb - va - relative).abs() < 1e-3 * relative, "{ratio}: {va} {vb}");
        assert!((va + ratio * vb - total).abs() < 1e-4 * (3.0 + ratio), "{ratio}: {va} {vb}");
    }
}

#[test]
fn damping_decays_exponentially() {
    let mut world = World::default();
    world.set_gravity([0.0; 3]);
    let def = BodyDef {
        linear_damping: 0.5,
        ..BodyDef::dynamic().with_shape(ShapeDef::sphere(0.5)).with_linear_velocity([1.0, 0.0, 0.0])
    };
    let id = world.add_body(def).unwrap();
    for _ in 0..120 {
        world.step(DT);
    }
    let v = world.body(id).unwrap().linear_velocity().x;
    assert!((v - drystone::math::trig::exp(-1.0)).abs() < 1e-4, "{v}");
}

#[test]
fn a_ring_around_a_peg_falls_as_if_nothing_were_there() {
    // Its center of mass is inside the peg all the time, and it is fast for its thickness.
    let mut world = World::default();
    let peg = ShapeDef::capsule(4.0, 0.1);
    world.add_body(BodyDef::fixed().with_shape(peg)).unwrap();
    let mut ring = BodyDef::dynamic().with_position([0.0, 3.0, 0.0]);
    for (x, z) in [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)] {
        let half = if x == 0.0 { [0.5, 0.05, 0.05] } else { [0.05, 0.05, 0.5] };
        ring = ring.with_shape(ShapeDef::box_half(half).with_position([0.5 * x, 0.0, 0.5 * z]));
    }
    let ring = world.add_body(ring).unwrap();
    for step in 1..=60 {
        world.step(1.0 / 60.0);
        let t = step as f32 / 60.0;
        let wanted = 3.0 - 0.5 * 9.81 * t * t;
        // Rounding of 60 sums of numbers up to 10.
        let y = world.body(ring).unwrap().position().y;
        assert!((y - wanted).abs() < 1.0e-4, "{y} m after {t} s, not {wanted}");
    }
}

/// Two balls of 10 cm move by 0.15 m per step, the first along x, the second from `from` in the
/// opposite direction. Returns their distance after that step, and the velocity of the second.
fn after_a_fast_step(from: Vec3) -> (f32, Vec3) {
    let mut world = World::default();
    world.set_gravity([0.0; 3]);
    let mut shoot = |from: Vec3, speed: f32| {
        let ball = BodyDef::dynamic().with_position(from).with_shape(ShapeDef::sphere(0.1));
        world.add_body(ball.with_linear_velocity([speed, 0.0, 0.0])).unwrap()
    };
    let ids = [shoot(Vec3::ZERO, 9.0), shoot(from, -9.0)];
    world.step(DT);
    let [a, b] = ids.map(|id| world.body(id).unwrap());
    ((b.position() - a.position()).length() - 0.2, b.linear_velocity())
}

#[test]
fn bodies_that_fly_at_each_other_are_stopped_at_their_surfaces() {
    // Contacts are detected up to the sum of both sizes.
    for gap in [0.001, 0.05, 0.09, 0.11, 0.15, 0.19] {
        let (apart, velocity) = after_a_fast_step(vec3(0.2 + gap, 0.0, 0.0));
        // An overdamped contact of 30 Hz and ten times the critical damping yields by v / 2ζω in an
        // impact: 5 mm.
        let soft = 18.0 / (2.0 * 10.0 * core::f32::consts::TAU * 30.0);
        assert!(apart.abs() < soft, "{gap}: {apart}");
        assert!(velocity.x > -9.0, "{gap}: {velocity:?}");
    }
}

#[test]
fn a_body_that_passes_another_is_not_deflected() {
    // At a lateral distance of more than the size of one; at less, another body might push it into
    // contact within the step.
    for aside in [0.301, 0.32, 0.35] {
        for ahead in [0.05, 0.1, 0.15, 0.2] {
            let (_, velocity) = after_a_fast_step(vec3(ahead, aside, 0.0));
            assert_eq!(velocity, vec3(-9.0, 0.0, 0.0), "{ahead} {aside}");
        }
    }
}
