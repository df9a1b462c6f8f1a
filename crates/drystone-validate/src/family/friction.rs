//! Dry friction: sticking, sliding, stopping distance and isotropy.

use drystone::{BodyDef, ShapeDef, vec3};
use drystone_bench::EngineError;

use crate::lab::{Lab, Run};
use crate::numeric::{D3, SlipEnd, dot, narrow, norm, scale, single, sub, worst};
use crate::row::{Limits, Rows, Unit, limits};
use crate::setup::{G, Slope, Surface, add_floor, block, empty};
use crate::test::Test;

pub(crate) const TESTS: &[Test] = &[
    Test::new(
        "A8",
        "block on a slope at the angle of friction, 10 s",
        "friction, slope 2 % (great: 0.5 %) below and above",
        "sticks if tan < µ, else slides g t²/2 (sin − µ cos)",
        stick_or_slide,
    ),
    Test::new("A9", "sliding down 30°, µ 0.3, 2 s", "", "a = g (sin − µ cos)", sliding).swept(),
    Test::new("A10", "stopping distance, µ 0.5", "v0", "v0²/(2 µ g)", stopping).swept(),
    Test::new(
        "A11",
        "stopping distance in all directions, 5 m/s, µ 0.5",
        "72 headings",
        "the same for all",
        isotropy,
    ),
    Test::new(
        "A15",
        "disc that spins flat, µ 0.3",
        "",
        "torque = 2/3 µ N R under uniform pressure",
        spinning_disc,
    ),
    Test::new(
        "A32",
        "block on a turntable, r 2 m, 10 s",
        "friction, speed 3 % (great: 1 %) below and above",
        "slips at w = √(µ g / r)",
        turntable,
    ),
    Test::new("A33", "block dropped on a moving belt", "friction, speed", "t = v/(µ g)", belt)
        .swept(),
    Test::new(
        "G2",
        "block on a slope of 0.5, µ 0.50 and 0.49, 10 s",
        "friction",
        "at rest sticks, moving keeps its speed; slides",
        high_school,
    ),
    Test::new(
        "G4",
        "stopping on a slope",
        "slope, friction",
        "v0²/(2 g (µ cos − sin))",
        stopping_on_slope,
    )
    .swept(),
    Test::new(
        "G14",
        "square box that spins flat, µ 0.3",
        "",
        "torque = 0.3826 µ m g L under uniform pressure",
        spinning_box,
    ),
    Test::new(
        "G15",
        "disc that slides and spins, µ 0.3",
        "v/(w R) at the start",
        "both stop together",
        slide_and_spin,
    ),
    Test::new(
        "G19",
        "box pushed at its center, µ 0.4",
        "height 3 % (great: 1 %) below and above",
        "tips if µ > w/(2 z), else slides",
        push_or_tip,
    ),
];

/// A block of 1 m at rest on a slope.
fn on_slope(lab: &Lab, tan: f64, mu: f64) -> Result<(Run, usize, Slope), EngineError> {
    let slope = Slope { angle: tan.atan() };
    let surface = Surface::rough(mu);
    let mut scene = empty("slope");
    slope.add(&mut scene, surface);
    let cube = block([1.0; 3], slope.place(0.0, 0.5, 0.0), surface).with_rotation(slope.turn());
    let cube = scene.add("cube", cube);
    Ok((lab.start(scene)?, cube, slope))
}

/// Distance down a slope after `seconds` [m].
fn creep(lab: &Lab, tan: f64, mu: f64, seconds: f64) -> Result<f64, EngineError> {
    let (mut run, cube, slope) = on_slope(lab, tan, mu)?;
    let start = run.body(cube).center;
    run.until(seconds, |_| {});
    Ok(dot(sub(run.body(cube).center, start), slope.down()))
}

/// Speed down the slope after `seconds` [m/s].
fn slip_speed(lab: &Lab, tan: f64, mu: f64, seconds: f64) -> Result<f64, EngineError> {
    let (mut run, cube, slope) = on_slope(lab, tan, mu)?;
    run.until(seconds, |_| {});
    Ok(dot(run.body(cube).v, slope.down()))
}

/// Distance down the slope if tan = µ, where the weight equals the maximum friction. The closed
/// form holds for a block at rest: any speed would be kept for ever. The block therefore comes to
/// rest under a push up the slope. The push is a tenth of its weight for 1 s, and fades to zero
/// within another second.
fn creep_at_limit(lab: &Lab, mu: f64, seconds: f64) -> Result<f64, EngineError> {
    let (mut run, cube, slope) = on_slope(lab, mu, mu)?;
    let weight = run.matter(cube).mass * G;
    while run.time() < 2.0 {
        let push = 0.1 * weight * (2.0 - run.time()).min(1.0);
        run.push(cube, narrow(scale(slope.down(), -push)))?;
        run.step();
    }
    let start = run.body(cube).center;
    run.until(2.0 + seconds, |_| {});
    Ok(dot(sub(run.body(cube).center, start), slope.down()))
}

/// Exact sliding distance [m].
fn slide(tan: f64, mu: f64, t: f64) -> f64 {
    let angle = tan.atan();
    0.5 * G * (angle.sin() - mu * angle.cos()) * t * t
}

fn stick_or_slide(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    const STILL: Limits = limits(1.0e-3, 1.0e-3);
    for tenths in 2..=10 {
        let mu = f64::from(tenths) / 10.0;
        let [held, held_harder] = [0.98, 0.995].map(|part| creep(lab, part * mu, mu, 10.0));
        let crept = (held?.abs(), held_harder?.abs());
        rows.at_most_harder(format!("µ {mu}, sticks"), crept, Unit::Meter, STILL);
        // A block slides if it moves at least half the exact distance.
        let slides = |part: f64| {
            let tan = part * mu;
            Ok::<_, EngineError>(creep(lab, tan, mu, 10.0)? >= 0.5 * slide(tan, mu, 10.0))
        };
        rows.holds(format!("µ {mu}, slides"), slides(1.02)?, slides(1.005)?);
    }
    Ok(())
}

fn high_school(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let crept = creep_at_limit(lab, 0.5, 10.0)?.abs();
    rows.at_most("µ 0.50, sticks", crept, Unit::Meter, limits(1.0e-3, 1.0e-3));
    // A block placed without contact force, as here, slips while the contact force builds up, and
    // keeps that speed. At exactly the limit, friction and gravity cancel. 0.1 mm/s in 9 s is 1e-6
    // g.
    let [early, late] = [1.0, 10.0].map(|seconds| slip_speed(lab, 0.5, 0.5, seconds));
    let change = (late? - early?).abs();
    let even = limits(1.0e-4, 1.0e-5);
    rows.at_most("µ 0.50, put down: change of speed", change, Unit::MeterPerSecond, even);
    let slid = creep(lab, 0.5, 0.49, 10.0)? >= 0.5 * slide(0.5, 0.49, 10.0);
    rows.holds("µ 0.49, slides", slid, slid);
    Ok(())
}

fn sliding(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let slope = Slope::degrees(30.0);
    let surface = Surface::rough(0.3);
    let mut scene = empty("sliding");
    slope.add(&mut scene, surface);
    let cube = block([1.0; 3], slope.place(0.0, 0.5, 0.0), surface).with_rotation(slope.turn());
    let cube = scene.add("cube", cube);
    let mut run = lab.start(scene)?;
    let start = run.body(cube).center;
    run.until(2.0, |_| {});
    let (t, now) = (run.time(), run.body(cube));
    let a = G * (slope.angle.sin() - 0.3 * slope.angle.cos());
    rows.relative("v", a * t, dot(now.v, slope.down()), limits(0.01, 0.002));
    let x = dot(sub(now.center, start), slope.down());
    rows.relative("x", 0.5 * a * t * t, x, limits(0.02, 0.002));
    Ok(())
}

/// Distances that cubes thrown along `headings` [rad] slide, each from its own start [m].
fn stops(lab: &Lab, headings: &[f64], v0: f64, mu: f64) -> Result<Vec<f64>, EngineError> {
    let surface = Surface::rough(mu);
    let mut scene = empty("stopping");
    add_floor(&mut scene, surface);
    let mut bodies = Vec::new();
    for heading in headings {
        let way = [heading.cos(), 0.0, heading.sin()];
        // Outward from a circle with room for 72 cubes.
        let place = scale(way, 40.0);
        let cube = block([1.0; 3], narrow([place[0], 0.5, place[2]]), surface);
        let cube = cube.with_linear_velocity(narrow(scale(way, v0)));
        bodies.push(scene.add(format!("cube {}", bodies.len()), cube));
    }
    let mut run = lab.start(scene)?;
    let start: Vec<D3> = bodies.iter().map(|cube| run.body(*cube).center).collect();
    run.until(2.0 + v0 / (mu * G), |_| {});
    Ok(bodies
        .iter()
        .zip(start)
        .map(|(cube, from)| norm(sub(run.body(*cube).center, from)))
        .collect())
}

fn stopping(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    for v0 in [2.0, 5.0, 10.0] {
        let expected = v0 * v0 / (2.0 * 0.5 * G);
        let measured = stops(lab, &[0.0], v0, 0.5)?[0];
        rows.relative(format!("v0 {v0} m/s"), expected, measured, limits(0.01, 0.003));
    }
    Ok(())
}

fn isotropy(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let headings: Vec<f64> = (0..72).map(|i| f64::to_radians(5.0 * f64::from(i))).collect();
    let stops = stops(lab, &headings, 5.0, 0.5)?;
    let mean = stops.iter().sum::<f64>() / stops.len() as f64;
    let least = stops.iter().copied().fold(f64::INFINITY, f64::min);
    let most = stops.iter().copied().fold(0.0, f64::max);
    let spread = (most - least) / mean;
    rows.error("spread", (mean, mean), spread, Unit::Part, limits(0.01, 0.001));
    Ok(())
}

/// Angular deceleration of a flat body that spins about the vertical axis, over the first 0.5 s.
fn spin_down(lab: &Lab, shape: ShapeDef, half_height: f64) -> Result<f64, EngineError> {
    let surface = Surface::rough(0.3);
    let mut scene = empty("spinning");
    add_floor(&mut scene, surface);
    let body = BodyDef::dynamic()
        .with_position(vec3(0.0, single(half_height), 0.0))
        .with_shape(surface.on(shape))
        .with_angular_velocity([0.0, 10.0, 0.0]);
    let body = scene.add("body", body);
    let mut run = lab.start(scene)?;
    run.until(0.5, |_| {});
    Ok((10.0 - run.body(body).w[1]) / run.time())
}

/// Torque as a fraction of µ N R: 0.6 to 1 is allowed, two thirds is ideal.
fn torque_row(rows: &mut Rows, uniform: f64, measured: f64) {
    let (least, most) = (0.6 / (2.0 / 3.0) * uniform, 1.0 / (2.0 / 3.0) * uniform);
    let inside = (least..=most).contains(&measured);
    // The error is measured for `great`; outside the allowed band any error is a failure.
    let error = (measured / uniform - 1.0).abs();
    let must = if inside { f64::MAX } else { -1.0 };
    rows.error("torque", (uniform, measured), error, Unit::Part, limits(must, 0.05));
}

fn spinning_disc(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let (radius, half_height) = (0.5, 0.05);
    let shape = ShapeDef::cylinder(single(half_height), single(radius));
    let alpha = spin_down(lab, shape, half_height)?;
    // Torque over µ N R, with N = m g and I = m R²/2.
    torque_row(rows, 2.0 / 3.0, alpha * 0.5 * radius / (0.3 * G));
    Ok(())
}

fn spinning_box(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let (edge, half_height) = (1.0, 0.05);
    let shape = ShapeDef::box_full(narrow([edge, 2.0 * half_height, edge]));
    let alpha = spin_down(lab, shape, half_height)?;
    // Torque over µ m g L, with I = m L²/6.
    torque_row(rows, 0.3826, alpha * edge / 6.0 / (0.3 * G));
    Ok(())
}

/// The list of tests gives no limit here. The two stops must lie within 5 % of the duration of the
/// motion, because `great` is 5 % for the torque of a spinning disc.
fn slide_and_spin(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    for ratio in [0.2, 1.0, 3.0] {
        let surface = Surface::rough(0.3);
        let (radius, spin) = (0.5, 8.0);
        let mut scene = empty("slide and spin");
        add_floor(&mut scene, surface);
        let shape = surface.on(ShapeDef::cylinder(0.02, single(radius)));
        let disc = BodyDef::dynamic()
            .with_position([0.0, 0.02, 0.0])
            .with_shape(shape)
            .with_linear_velocity(narrow([ratio * spin * radius, 0.0, 0.0]))
            .with_angular_velocity(narrow([0.0, spin, 0.0]));
        let disc = scene.add("disc", disc);
        let mut run = lab.start(scene)?;
        let (mut slid, mut spun) = (f64::NAN, f64::NAN);
        run.until(10.0, |run| {
            let now = run.body(disc);
            // Threshold: a hundredth of the initial speed.
            if norm(now.v) > 0.01 * ratio * spin * radius {
                slid = run.time();
            }
            if now.w[1].abs() > 0.01 * spin {
                spun = run.time();
            }
        });
        let error = (slid - spun).abs() / slid.max(spun);
        rows.error(format!("v/(w R) {ratio}"), (spun, slid), error, Unit::Part, limits(0.05, 0.02));
    }
    Ok(())
}

/// Maximum distance from the center of a block on a turntable in 10 s [m]. The table turns at
/// `part` of the speed at which the block slips.
fn radius_after(lab: &Lab, mu: f64, part: f64) -> Result<f64, EngineError> {
    let (r, surface) = (2.0, Surface::rough(mu));
    let w = part * (mu * G / r).sqrt();
    let mut scene = empty("turntable");
    let table = surface.on(ShapeDef::box_full([8.0, 0.5, 8.0]));
    let table = BodyDef::kinematic()
        .with_position([0.0, -0.25, 0.0])
        .with_shape(table)
        .with_angular_velocity(narrow([0.0, w, 0.0]));
    scene.add("table", table);
    let cube = block([0.5, 0.3, 0.5], vec3(single(r), 0.15, 0.0), surface)
        .with_linear_velocity(narrow([0.0, 0.0, -w * r]))
        .with_angular_velocity(narrow([0.0, w, 0.0]));
    let cube = scene.add("cube", cube);
    let mut run = lab.start(scene)?;
    let mut farthest = 0.0_f64;
    run.until(10.0, |run| {
        let p = run.body(cube).center;
        farthest = worst(farthest, p[0].hypot(p[2]));
    });
    Ok(farthest)
}

fn turntable(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    for mu in [0.3, 0.6, 1.0] {
        // A block is held if it stays within 1 cm of its place. At 1 % above the limit speed, 2 %
        // of µ g pushes it outward: many meters in 10 s.
        let moved = |part| Ok::<_, EngineError>(radius_after(lab, mu, part)? - 2.0);
        let outward = (moved(0.97)?, moved(0.99)?);
        rows.at_most_harder(format!("µ {mu}, holds"), outward, Unit::Meter, limits(0.01, 0.01));
        let slips = |part| Ok::<_, EngineError>(radius_after(lab, mu, part)? > 2.1);
        rows.holds(format!("µ {mu}, slips"), slips(1.03)?, slips(1.01)?);
    }
    Ok(())
}

fn belt(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    for (mu, v) in [(0.2, 1.0), (0.3, 2.0), (0.6, 4.0)] {
        let surface = Surface::rough(mu);
        let mut scene = empty("belt");
        let belt = surface.on(ShapeDef::box_full([60.0, 0.5, 4.0]));
        let belt = BodyDef::kinematic()
            .with_position([0.0, -0.25, 0.0])
            .with_shape(belt)
            .with_linear_velocity(narrow([v, 0.0, 0.0]));
        scene.add("belt", belt);
        let cube = scene.add("cube", block([1.0, 0.5, 1.0], vec3(0.0, 0.25, 0.0), surface));
        let mut run = lab.start(scene)?;
        let mut slip = SlipEnd::default();
        run.until(2.0 * v / (mu * G), |run| {
            let left = v - run.body(cube).v[0];
            if left > 0.02 * v {
                slip.read(run.time(), left);
            }
        });
        let case = format!("µ {mu}, {v} m/s");
        rows.relative(case, v / (mu * G), slip.time(), limits(0.02, 0.005));
    }
    Ok(())
}

fn stopping_on_slope(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    for (degrees, mu) in [(10.0, 0.4), (20.0, 0.6), (-10.0, 0.3)] {
        // A negative angle means that the block is thrown uphill.
        let slope = Slope::degrees(f64::abs(degrees));
        let uphill = f64::signum(degrees);
        let surface = Surface::rough(mu);
        let mut scene = empty("stopping on a slope");
        slope.add(&mut scene, surface);
        let v0 = 5.0;
        let cube = block([1.0, 0.5, 1.0], slope.place(0.0, 0.25, 0.0), surface)
            .with_rotation(slope.turn())
            .with_linear_velocity(narrow(scale(slope.down(), v0 * uphill)));
        let cube = scene.add("cube", cube);
        let mut run = lab.start(scene)?;
        let start = run.body(cube).center;
        run.until(10.0, |_| {});
        let slowing = mu * slope.angle.cos() - uphill * slope.angle.sin();
        let expected = v0 * v0 / (2.0 * G * slowing);
        let measured = norm(sub(run.body(cube).center, start));
        let case = format!("{degrees}°, µ {mu}");
        rows.relative(case, expected, measured, limits(0.01, 0.003));
    }
    Ok(())
}

/// Final tilt [rad] of a box 1 m wide that is pushed at height `z` for 4 s, with a tenth more force
/// than friction holds.
fn pushed(lab: &Lab, z: f64) -> Result<f64, EngineError> {
    let (mu, surface) = (0.4, Surface::rough(0.4));
    let mut scene = empty("push");
    add_floor(&mut scene, surface);
    let body = scene.add("box", block([1.0, 2.0 * z, 1.0], narrow([0.0, z, 0.0]), surface));
    let mut run = lab.start(scene)?;
    let force = 1.1 * mu * run.matter(body).mass * G;
    while run.time() < 4.0 {
        run.push(body, narrow([force, 0.0, 0.0]))?;
        run.step();
    }
    Ok(run.body(body).direction([0.0, 1.0, 0.0])[1].clamp(-1.0, 1.0).acos())
}

fn push_or_tip(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let z = 1.0 / (2.0 * 0.4);
    // A box that slides stays upright; a box that tips has an edge far off the ground.
    let slides = |part: f64| Ok::<_, EngineError>(pushed(lab, part * z)? < 0.02);
    let tips = |part: f64| Ok::<_, EngineError>(pushed(lab, part * z)? > 0.2);
    rows.holds("slides", slides(0.97)?, slides(0.99)?);
    rows.holds("tips", tips(1.03)?, tips(1.01)?);
    Ok(())
}
