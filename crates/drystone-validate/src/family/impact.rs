//! Impacts: restitution, momentum and energy.

use core::f64::consts::FRAC_PI_4;

use drystone::{BodyDef, ShapeDef, Vec3, vec3};
use drystone_bench::EngineError;
use drystone_scene::Scene;

use crate::lab::{Lab, Run};
use crate::numeric::{D3, FirstApex, Random, add, narrow, norm, scale, single, sub, turn, worst};
use crate::row::{Limits, Rows, Unit, limits};
use crate::setup::{G, Surface, add_floor, ball, block, empty, weightless};
use crate::test::Test;

pub(crate) const TESTS: &[Test] = &[
    Test::new("A16", "ball dropped from 2 m: first apex", "e", "e² h", first_bounce).swept(),
    Test::new("A17", "SimBenchmark bouncing (S2): 49 balls, e 1, 20 s", "", "E constant", bouncing)
        .swept(),
    Test::new(
        "A18",
        "collision along a line, 5 m/s",
        "mass ratio, e",
        "v1' = v1 − (1 + e) m2/(m1 + m2) v, v2' = (1 + e) m1/(m1 + m2) v",
        along_a_line,
    ),
    Test::new(
        "A19",
        "Newton's cradle: 5 balls, gaps of 1 mm, e 1",
        "",
        "the last ball takes all of v, the others stay",
        cradle,
    ),
    Test::new(
        "A20",
        "ball thrown at the floor at an angle",
        "sliding and sticking, e",
        "dvt = −µ (1 + e) vn; vt' = 5/7 vt",
        oblique,
    ),
    Test::new(
        "A21",
        "200 mixed bodies without gravity, friction, e 0.3, 60 s",
        "",
        "p and L constant, E never grows",
        swarm,
    ),
    Test::new(
        "S4",
        "SimBenchmark elastic 666: 216 balls, e 1, 10 s",
        "",
        "E constant",
        elastic_666,
    )
    .swept(),
    Test::new("G5", "ball that bounces, 5 times; e 1 for 20 s", "e", "e^(2 n) h", table).swept(),
    Test::new(
        "G6",
        "box of e 1 dropped flat, on an edge, on a corner, 10 s",
        "pose",
        "never above the drop height",
        dropped_box,
    ),
    Test::new(
        "G7",
        "Newton's cradle with several balls moving",
        "balls",
        "as many go out at v as came in",
        cradles,
    ),
    Test::new(
        "G24",
        "500 bodies in a closed box without gravity, 10 s",
        "",
        "p and L of bodies and box constant",
        closed_box,
    ),
    Test::new(
        "G25",
        "energy of a heap that falls together, e 0",
        "",
        "E never grows",
        falling_heap,
    ),
    Test::new(
        "G27",
        "rod that strikes the floor at an angle (Kane), e 1, µ 0.5",
        "angle",
        "E does not grow",
        kane_rod,
    ),
    Test::new(
        "G29",
        "elastic gas: 216 balls in a closed box without gravity, e 1, 20 s",
        "",
        "E constant",
        gas,
    ),
];

fn drop(lab: &Lab, e: f64, height: f64) -> Result<(Run, usize), EngineError> {
    let mut scene = empty("drop");
    add_floor(&mut scene, Surface { mu: 0.5, e });
    let def = ball(0.5, narrow([0.0, height + 0.5, 0.0]), Surface { mu: 0.5, e });
    let body = scene.add("ball", def);
    Ok((lab.start(scene)?, body))
}

fn first_bounce(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    for e in [0.0, 0.25, 0.5, 0.75, 0.9, 1.0] {
        let (mut run, body) = drop(lab, e, 2.0)?;
        let mut apex = FirstApex::default();
        run.until(2.2, |run| apex.read(run.body(body).center[1] - 0.5));
        // A ball that does not leave the ground has its apex there.
        let resting = run.body(body).center[1] - 0.5;
        let measured = apex.apex().unwrap_or(resting);
        let expected = e * e * 2.0;
        let error = (measured - expected).abs() / 2.0;
        let case = format!("e {e}");
        rows.error(case, (expected, measured), error, Unit::Part, limits(0.03, 0.005));
    }
    Ok(())
}

/// Tracks the energy of all bodies relative to the start. Returns the root mean square of the
/// difference, the maximum excess and the maximum loss, all as fractions.
fn follow_energy(run: &mut Run, seconds: f64) -> [f64; 3] {
    let e0 = run.energy();
    let (mut sum, mut count, mut above, mut below) = (0.0, 0.0, 0.0, 0.0);
    run.until(seconds, |run| {
        let off = run.energy() / e0 - 1.0;
        sum += off * off;
        count += 1.0;
        above = worst(above, off);
        below = worst(below, -off);
    });
    [(sum / count).sqrt(), above, below]
}

fn bouncing(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let mut scene = empty("bouncing");
    add_floor(&mut scene, Surface::bouncy(1.0));
    for i in 0..49 {
        let place = [2.0 * f64::from(i % 7), 5.0, 2.0 * f64::from(i / 7)];
        let def = ball(0.1, narrow(place), Surface::bouncy(1.0)).with_mass(10.0);
        scene.add(format!("ball {i}"), def);
    }
    let [rms, above, _] = follow_energy(&mut lab.start(scene)?, 20.0);
    rows.at_most("E, root mean square", rms, Unit::Part, limits(0.01, 0.001));
    rows.at_most("E, excess", above, Unit::Part, limits(0.001, 0.001));
    Ok(())
}

/// Two balls. The first, of density 1000, flies at 5 m/s at the second, which is `ratio` times as
/// heavy.
fn collide(lab: &Lab, ratio: f64, e: f64) -> Result<[f64; 3], EngineError> {
    let mut scene = weightless("line");
    let surface = Surface { mu: 0.5, e };
    let shape = |density: f64| surface.on(ShapeDef::sphere(0.5)).with_density(single(density));
    let striker = BodyDef::dynamic().with_shape(shape(1000.0));
    let first = striker.with_position([-1.7, 0.0, 0.0]).with_linear_velocity([5.0, 0.0, 0.0]);
    let first = scene.add("first", first);
    let second = scene.add("second", BodyDef::dynamic().with_shape(shape(1000.0 * ratio)));
    let mut run = lab.start(scene)?;
    let p0 = run.momentum();
    run.until(1.0, |_| {});
    let p = norm(sub(run.momentum(), p0)) / norm(p0);
    Ok([run.body(first).v[0], run.body(second).v[0], p])
}

/// The exact speeds after the impact.
fn after_collision(ratio: f64, e: f64, v: f64) -> [f64; 2] {
    let impulse = (1.0 + e) * ratio / (1.0 + ratio) * v;
    [v - impulse, impulse / ratio]
}

fn along_a_line(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    for ratio in [1.0, 0.1, 10.0, 0.001, 1000.0] {
        for e in [0.0, 0.5, 1.0] {
            let [v1, v2, p] = collide(lab, ratio, e)?;
            let [exact1, exact2] = after_collision(ratio, e, 5.0);
            // Errors of both speeds, relative to the impact speed.
            let (off1, off2) = ((v1 - exact1).abs() / 5.0, (v2 - exact2).abs() / 5.0);
            let worse = if off1 >= off2 { (exact1, v1) } else { (exact2, v2) };
            let case = |what: &str| format!("1:{ratio}, e {e}, {what}");
            rows.error(case("v"), worse, worst(off1, off2), Unit::Part, limits(0.01, 0.001));
            rows.at_most(case("p"), p, Unit::Part, limits(1.0e-5, 1.0e-5));
        }
    }
    Ok(())
}

/// Final speeds of a line of balls. The first `moving` balls arrive at 3 m/s from 0.5 m away.
fn line_of_balls(lab: &Lab, balls: usize, moving: usize) -> Result<Vec<f64>, EngineError> {
    let mut scene = weightless("cradle");
    let pitch = 1.001;
    for i in 0..balls {
        let gap = if i < moving { -0.5 } else { 0.0 };
        let place = narrow([pitch * i as f64 + gap, 0.0, 0.0]);
        let v = if i < moving { 3.0 } else { 0.0 };
        let def = ball(0.5, place, Surface::bouncy(1.0)).with_linear_velocity([v, 0.0, 0.0]);
        scene.add(format!("ball {i}"), def);
    }
    let mut run = lab.start(scene)?;
    run.until(1.0, |_| {});
    Ok((0..balls).map(|body| run.body(body).v[0] / 3.0).collect())
}

fn cradle(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let v = line_of_balls(lab, 5, 1)?;
    rows.absolute("last ball", 1.0, v[4], Unit::Part, limits(0.03, 0.005));
    let rest = v[..4].iter().map(|v| v.abs()).fold(0.0, worst);
    rows.at_most("others", rest, Unit::Part, limits(0.03, 0.005));
    Ok(())
}

fn cradles(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    for moving in 1..=3 {
        let v = line_of_balls(lab, 5, moving)?;
        let off = |(i, v): (usize, &f64)| (v - if i >= 5 - moving { 1.0 } else { 0.0 }).abs();
        let error = v.iter().enumerate().map(off).fold(0.0, worst);
        let case = format!("{moving} of 5");
        rows.error(case, (1.0, 1.0 - error), error, Unit::Part, limits(0.02, 0.02));
    }
    Ok(())
}

/// Velocity of a ball after it hits the floor without gravity, at 5 m/s along the normal and `vt`
/// tangentially.
fn strike(lab: &Lab, vt: f64, mu: f64, e: f64) -> Result<[f64; 2], EngineError> {
    let surface = Surface { mu, e };
    let mut scene = weightless("oblique");
    add_floor(&mut scene, surface);
    let def = ball(0.5, vec3(0.0, 1.2, 0.0), surface).with_linear_velocity([single(vt), -5.0, 0.0]);
    let body = scene.add("ball", def);
    let mut run = lab.start(scene)?;
    run.until(0.5, |_| {});
    let now = run.body(body);
    Ok([now.v[0], now.v[1]])
}

fn oblique(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let l = limits(0.02, 0.005);
    for e in [0.0, 0.5, 1.0] {
        // It slides throughout, because µ (1 + e) vn < 2/7 vt.
        let [v, _] = strike(lab, 5.0, 0.1, e)?;
        rows.relative(format!("sliding, e {e}, dvt"), -0.1 * (1.0 + e) * 5.0, v - 5.0, l);
        let [v, up] = strike(lab, 5.0, 1.0, e)?;
        rows.relative(format!("sticking, e {e}, vt"), 5.0 / 7.0 * 5.0, v, l);
        rows.error(
            format!("sticking, e {e}, vn"),
            (e * 5.0, up),
            (up - e * 5.0).abs() / 5.0,
            Unit::Part,
            l,
        );
    }
    Ok(())
}

/// A ball, a box or a capsule, in turn by `i`, at a random orientation.
pub(super) fn mixed(
    i: usize,
    random: &mut Random,
    size: f64,
    place: D3,
    surface: Surface,
) -> BodyDef {
    let shape = match i % 3 {
        0 => ShapeDef::sphere(single(size)),
        1 => ShapeDef::box_half(narrow([size, 0.7 * size, 0.5 * size])),
        _ => ShapeDef::capsule(single(0.6 * size), single(0.5 * size)),
    };
    let body = BodyDef::dynamic().with_position(narrow(place)).with_shape(surface.on(shape));
    body.with_rotation(random.rotation())
}

/// Drifts of the conserved quantities in a run of bodies without external forces.
fn closed_drifts(run: &mut Run, seconds: f64) -> [f64; 3] {
    let (p0, l0) = (run.momentum(), run.angular_momentum());
    let size = run.momentum_scale();
    let spins: f64 = run.dynamic().map(|body| norm(run.body(body).angular_momentum())).sum();
    let (mut p, mut l, mut grown, mut least) = (0.0, 0.0, 0.0, run.energy());
    run.until(seconds, |run| {
        p = worst(p, norm(sub(run.momentum(), p0)) / size);
        l = worst(l, norm(sub(run.angular_momentum(), l0)) / spins);
        let energy = run.energy();
        grown = worst(grown, energy / least - 1.0);
        least = least.min(energy);
    });
    [p, l, grown]
}

fn swarm(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let (mut random, surface) = (Random::new(21), Surface { mu: 0.5, e: 0.3 });
    let mut scene = weightless("swarm");
    for i in 0..200 {
        let cell = [i % 6, i / 6 % 6, i / 36].map(|n| 1.3 * (n as f64 - 2.5));
        let size = random.between(0.2, 0.45);
        let v = add(scale(cell, -0.5), scale(random.direction(), random.between(0.0, 1.0)));
        let w = scale(random.direction(), random.between(0.0, 3.0));
        let def = mixed(i, &mut random, size, cell, surface)
            .with_linear_velocity(narrow(v))
            .with_angular_velocity(narrow(w));
        scene.add(format!("body {i}"), def);
    }
    let [p, l, grown] = closed_drifts(&mut lab.start(scene)?, 60.0);
    rows.at_most("p", p, Unit::Part, limits(1.0e-5, 1.0e-6));
    rows.at_most("L", l, Unit::Part, limits(1.0e-2, 1.0e-3));
    rows.at_most("E, growth", grown, Unit::Part, limits(1.0e-3, 0.0));
    Ok(())
}

/// The 6 × 6 × 6 balls of SimBenchmark, with the lowest layer at height `first`.
pub(super) fn add_666(scene: &mut Scene, first: f64, e: f64) {
    add_floor(scene, Surface::bouncy(e));
    let mut random = Random::new(42);
    for i in 0..216 {
        let cell = [i % 6, i / 36, i / 6 % 6].map(|n| 0.21 * f64::from(n));
        let place = add(cell, [0.0, first, 0.0]).map(|x| x + random.between(0.0, 0.001));
        let def = ball(0.1, narrow(place), Surface::bouncy(e)).with_mass(10.0);
        scene.add(format!("ball {i}"), def);
    }
}

fn elastic_666(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let mut scene = empty("elastic 666");
    add_666(&mut scene, 1.101, 1.0);
    let [rms, above, _] = follow_energy(&mut lab.start(scene)?, 10.0);
    rows.at_most("E, root mean square", rms, Unit::Part, limits(0.01, 0.001));
    rows.at_most("E, excess", above, Unit::Part, limits(0.002, 0.002));
    Ok(())
}

fn table(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    const NEAR: Limits = limits(0.03, 0.005);
    for e in [0.3, 0.5, 0.8] {
        // rapier #974: the bounce height is e² of the drop height, so 0.09, 0.25 and 0.64 of it.
        let (mut run, body) = drop(lab, e, 4.0)?;
        let (mut apexes, mut apex) = (Vec::new(), FirstApex::default());
        run.until(8.0, |run| {
            apex.read(run.body(body).center[1] - 0.5);
            if let Some(height) = apex.apex() {
                apexes.push(height);
                apex = FirstApex::default();
            }
        });
        for n in 0..3 {
            // Up to the last bounce faster than 1 m/s: slower contacts need not bounce.
            let height = 4.0 * e.powi(2 * (n + 1));
            if (2.0 * G * height).sqrt() / e < 1.0 {
                break;
            }
            let measured = apexes.get(n.unsigned_abs() as usize).copied().unwrap_or(f64::NAN);
            let error = (measured - height).abs() / 4.0;
            rows.error(
                format!("e {e}, apex {}", n + 1),
                (height, measured),
                error,
                Unit::Part,
                NEAR,
            );
        }
    }
    let (mut run, body) = drop(lab, 1.0, 4.0)?;
    let mut highest = 0.0;
    run.until(20.0, |run| highest = worst(highest, run.body(body).center[1] - 0.5));
    rows.at_most("e 1, above the start", highest / 4.0 - 1.0, Unit::Part, limits(1.0e-3, 1.0e-3));
    Ok(())
}

fn dropped_box(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let edge = turn([0.0, 0.0, 1.0], FRAC_PI_4);
    let corner = edge * turn([1.0, 0.0, 0.0], 0.615_479_709);
    for (case, rotation) in
        [("flat", turn([0.0, 0.0, 1.0], 0.0)), ("edge", edge), ("corner", corner)]
    {
        let mut scene = empty("box");
        add_floor(&mut scene, Surface { mu: 0.5, e: 1.0 });
        let cube = block([1.0; 3], vec3(0.0, 3.0, 0.0), Surface { mu: 0.5, e: 1.0 });
        let cube = scene.add("cube", cube.with_rotation(rotation));
        let mut run = lab.start(scene)?;
        let mut highest = 0.0;
        run.until(10.0, |run| highest = worst(highest, run.body(cube).center[1]));
        // Relative to the height from which its center fell; a thousandth, as for balls.
        let above = (highest - 3.0) / 2.5;
        rows.error(case, (3.0, highest), above, Unit::Part, limits(1.0e-3, 1.0e-3));
    }
    Ok(())
}

/// Six walls that are one dynamic body, so that no external force acts.
fn add_crate(scene: &mut Scene, half: f64, surface: Surface, kind: BodyDef) -> usize {
    let thick = 1.0;
    let mut body = kind;
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let mut extents = [half + 2.0 * thick; 3];
            extents[axis] = thick;
            let mut place = [0.0; 3];
            place[axis] = side * (half + thick);
            let wall = surface.on(ShapeDef::box_half(narrow(extents))).with_density(100.0);
            body = body.with_shape(wall.with_position(narrow(place)));
        }
    }
    scene.add("crate", body)
}

fn closed_box(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let (mut random, surface) = (Random::new(24), Surface { mu: 0.5, e: 0.3 });
    let mut scene = weightless("closed box");
    add_crate(&mut scene, 4.0, surface, BodyDef::dynamic());
    for i in 0..500 {
        let cell = [i % 8, i / 8 % 8, i / 64].map(|n| 0.9 * (n as f64 - 3.5));
        let size = random.between(0.15, 0.3);
        let v = scale(random.direction(), random.between(0.0, 5.0));
        let def = mixed(i, &mut random, size, cell, surface).with_linear_velocity(narrow(v));
        scene.add(format!("body {i}"), def);
    }
    let [p, l, grown] = closed_drifts(&mut lab.start(scene)?, 10.0);
    rows.at_most("p", p, Unit::Part, limits(1.0e-5, 1.0e-5));
    rows.at_most("L", l, Unit::Part, limits(1.0e-5, 1.0e-5));
    rows.at_most("E, growth", grown, Unit::Part, limits(1.0e-3, 1.0e-3));
    Ok(())
}

fn falling_heap(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let (mut random, surface) = (Random::new(25), Surface::rough(0.5));
    let mut scene = empty("heap");
    add_floor(&mut scene, surface);
    for i in 0..100 {
        let cell = [i % 4, i / 16, i / 4 % 4].map(|n| 1.1 * n as f64);
        let place = add(cell, [0.0, 1.0, 0.0]);
        let size = random.between(0.25, 0.5);
        scene.add(format!("body {i}"), mixed(i, &mut random, size, place, surface));
    }
    let mut run = lab.start(scene)?;
    let (start, mut least, mut grown) = (run.energy(), run.energy(), 0.0);
    run.until(10.0, |run| {
        let energy = run.energy();
        // Relative to the initial energy, because little energy is left at the end.
        grown = worst(grown, (energy - least) / start);
        least = least.min(energy);
    });
    rows.at_most("E, growth", grown, Unit::Part, limits(1.0e-3, 1.0e-3));
    Ok(())
}

fn kane_rod(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    for degrees in [20.0_f64, 45.0, 70.0] {
        let surface = Surface { mu: 0.5, e: 1.0 };
        let mut scene = weightless("rod");
        add_floor(&mut scene, surface);
        let shape = surface.on(ShapeDef::capsule(0.5, 0.02));
        let rod = BodyDef::dynamic()
            .with_position([0.0, 1.0, 0.0])
            .with_rotation(turn([0.0, 0.0, 1.0], degrees.to_radians()))
            .with_shape(shape)
            .with_linear_velocity([3.0, -4.0, 0.0]);
        scene.add("rod", rod);
        let [_, above, _] = follow_energy(&mut lab.start(scene)?, 1.0);
        let case = format!("{degrees}°");
        rows.at_most(case, above, Unit::Part, limits(1.0e-3, 0.0));
    }
    Ok(())
}

fn gas(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let (mut random, half, radius) = (Random::new(29), 3.0, 0.05);
    let mut scene = weightless("gas");
    let crate_body = BodyDef::fixed().with_position(Vec3::ZERO);
    add_crate(&mut scene, half, Surface::bouncy(1.0), crate_body);
    for i in 0..216 {
        let cell = [i % 6, i / 6 % 6, i / 36].map(|n| 0.9 * (f64::from(n) - 2.5));
        let v = scale(random.direction(), random.between(3.0, 6.0));
        let def = ball(radius, narrow(cell), Surface::bouncy(1.0)).with_mass(1.0);
        scene.add(format!("ball {i}"), def.with_linear_velocity(narrow(v)));
    }
    let mut run = lab.start(scene)?;
    let [rms, above, _] = follow_energy(&mut run, 20.0);
    rows.at_most("E, root mean square", rms, Unit::Part, limits(0.01, 0.001));
    rows.at_most("E, excess", above, Unit::Part, limits(0.002, 0.002));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::after_collision;

    #[test]
    fn a_collision_keeps_momentum_and_restitution() {
        for (ratio, e) in [(1.0, 0.5), (10.0, 0.0), (0.001, 1.0)] {
            let [v1, v2] = after_collision(ratio, e, 5.0);
            assert!((v1 + ratio * v2 - 5.0).abs() < 1.0e-12);
            assert!((v2 - v1 - e * 5.0).abs() < 1.0e-12);
        }
    }
}
