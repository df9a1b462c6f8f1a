//! Hinges, sliders, springs, motors and limits.

use core::f64::consts::{FRAC_PI_2, PI};

use drystone::joint::{Hinge, JointAxis, JointDrive, JointSpring, SixDof, Slider};
use drystone::{BodyDef, ShapeDef, Vec3, vec3};
use drystone_bench::EngineError;
use drystone_scene::Scene;

use crate::lab::{Lab, Moment};
use crate::numeric::{Crossings, D3, narrow, norm, runge_kutta, single, sub, turn, worst};
use crate::row::{Rows, Unit, limits};
use crate::setup::{G, Surface, add_joint, ball, block, empty, weightless};
use crate::test::Test;

pub(crate) const TESTS: &[Test] = &[
    Test::new("A23", "rod on a hinge, 2°, 60 s", "", "T = 2π √(I/(m g d))", rod_pendulum).swept(),
    Test::new(
        "A25",
        "slider with a pendulum let go from horizontal, 5 s",
        "",
        "equations of motion (Runge-Kutta)",
        slider_pendulum,
    )
    .swept(),
    Test::new(
        "A26",
        "slider-crank, 10 turns a second by a motor, 2 s",
        "",
        "x = r cos f + √(l² - r² sin² f)",
        slider_crank,
    ),
    Test::new(
        "A27",
        "body on a damped spring",
        "frequency, damping ratio",
        "eigenvalues of m x'' + c x' + k x = 0, fitted to the path",
        spring_damper,
    ),
    Test::new("A28", "hinge motor", "", "w = τ t/I; speed; stall at m g d sin a = τ", hinge_motor),
    Test::new("A29", "limits under a load", "load", "at the limit", limits_under_load),
];

/// Joint frame whose x axis is the world's z axis.
fn along_z() -> drystone::Quat {
    turn([0.0, 1.0, 0.0], -FRAC_PI_2)
}

/// Angle of the body's x axis in the xy plane, from x [rad].
fn heading(now: &Moment) -> f64 {
    let x = now.direction([1.0, 0.0, 0.0]);
    x[1].atan2(x[0])
}

/// A thin rod of 1 m and 1 kg from the origin, on a hinge about z at the origin, at an angle from
/// x. Also returns its inertia about the hinge.
fn add_rod(scene: &mut Scene, angle: f64, axis: JointAxis) -> Result<(usize, f64), EngineError> {
    let post = scene.add("post", BodyDef::fixed());
    let rod = block(
        [1.0, 0.02, 0.02],
        narrow([0.5 * angle.cos(), 0.5 * angle.sin(), 0.0]),
        Surface::rough(0.5),
    )
    .with_rotation(turn([0.0, 0.0, 1.0], angle))
    .with_mass(1.0);
    let rod = scene.add("rod", rod);
    add_joint(scene, post, rod, [0.0; 3], along_z(), Hinge::of(axis))?;
    Ok((rod, (1.0 + 0.02 * 0.02) / 12.0 + 0.25))
}

fn rod_pendulum(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let mut scene = empty("rod");
    let angle = 2.0_f64.to_radians();
    let (rod, inertia) = add_rod(&mut scene, angle - FRAC_PI_2, JointAxis::FREE)?;
    let mut run = lab.start(scene)?;
    let mut seen = Crossings::default();
    run.until(60.0, |run| seen.read(run.time(), heading(&run.body(rod)) + FRAC_PI_2));
    let exact = 2.0 * PI * (inertia / (G * 0.5)).sqrt() * (1.0 + angle * angle / 16.0);
    rows.relative("T", exact, seen.period(), limits(0.005, 0.001));
    Ok(())
}

/// Rates of a cart of 1 kg and a pendulum with a ball of 1 kg at 1 m that rotates with it. The
/// state has the cart's position, the pendulum's angle from hanging, and their rates.
fn slider_rates([_, a, v, u]: &[f64; 4]) -> [f64; 4] {
    let spin = 0.4 * 0.05 * 0.05;
    let (s, c) = a.sin_cos();
    // 2 x'' + c a'' = s a'²; c x'' + (1 + spin) a'' = -g s.
    let (f, h) = (s * u * u, -G * s);
    let det = 2.0 * (1.0 + spin) - c * c;
    [*v, *u, ((1.0 + spin) * f - c * h) / det, (2.0 * h - c * f) / det]
}

fn slider_pendulum(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let mut scene = empty("slider with a pendulum");
    let post = scene.add("post", BodyDef::fixed());
    let cart = block([0.2; 3], Vec3::ZERO, Surface::rough(0.5)).with_mass(1.0);
    let cart = scene.add("cart", cart);
    let bob = ball(0.05, vec3(1.0, 0.0, 0.0), Surface::rough(0.5)).with_mass(1.0);
    let bob = scene.add("bob", bob);
    let along = drystone::Quat::IDENTITY;
    add_joint(&mut scene, post, cart, [0.0; 3], along, Slider::new())?;
    add_joint(&mut scene, cart, bob, [0.0; 3], along_z(), Hinge::new())?;
    let mut run = lab.start(scene)?;
    let mut x = [0.0, FRAC_PI_2, 0.0, 0.0];
    let (mut sum, mut count) = (0.0, 0.0);
    run.until(5.0, |run| {
        for _ in 0..100 {
            x = runge_kutta(&x, lab.dt() / 100.0, slider_rates);
        }
        let first = [x[0], 0.0, 0.0];
        let second = [x[0] + x[1].sin(), -x[1].cos(), 0.0];
        for (body, exact) in [(cart, first), (bob, second)] {
            let off = norm(sub(run.body(body).center, exact));
            sum += off * off;
            count += 1.0;
        }
    });
    let rms = f64::sqrt(sum / count);
    rows.at_most("path, RMS", rms, Unit::Meter, limits(1.0e-2, 2.0e-3));
    Ok(())
}

fn slider_crank(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let (r, l) = (0.1, 0.3);
    let mut scene = weightless("slider-crank");
    let post = scene.add("post", BodyDef::fixed());
    let part = |length: f64, x: f64| {
        let at = narrow([x + 0.5 * length, 0.0, 0.0]);
        block([length, 0.02, 0.02], at, Surface::rough(0.5)).with_mass(1.0)
    };
    let crank = scene.add("crank", part(r, 0.0));
    let rod = scene.add("rod", part(l, r));
    let slider = block([0.06; 3], narrow([r + l, 0.0, 0.0]), Surface::rough(0.5));
    let slider = scene.add("slider", slider.with_mass(1.0));
    let speed = 20.0 * PI;
    let motor = JointAxis::driven(JointDrive::motor(single(speed), 1.0e4));
    let hinge = Hinge::new();
    add_joint(&mut scene, post, crank, [0.0; 3], along_z(), Hinge::of(motor))?;
    add_joint(&mut scene, crank, rod, [r, 0.0, 0.0], along_z(), hinge)?;
    add_joint(&mut scene, rod, slider, [r + l, 0.0, 0.0], along_z(), hinge)?;
    let slide = Slider::new();
    let along = drystone::Quat::IDENTITY;
    add_joint(&mut scene, post, slider, [r + l, 0.0, 0.0], along, slide)?;
    // The mechanism starts in motion: the slider at its end, the crank's pin at full speed.
    let bodies = &mut scene.bodies;
    let pin = single(r * speed);
    bodies[crank].def.linear_velocity = vec3(0.0, 0.5 * pin, 0.0);
    bodies[crank].def.angular_velocity = vec3(0.0, 0.0, single(speed));
    bodies[rod].def.linear_velocity = vec3(0.0, 0.5 * pin, 0.0);
    bodies[rod].def.angular_velocity = vec3(0.0, 0.0, single(-speed * r / l));
    let mut run = lab.start(scene)?;
    let (mut off, mut turned, mut last) = (0.0, 0.0, 0.0);
    run.until(2.0, |run| {
        let angle = heading(&run.body(crank));
        turned += (angle - last).rem_euclid(2.0 * PI);
        last = angle;
        let exact = r * angle.cos() + (l * l - r * r * angle.sin() * angle.sin()).sqrt();
        let at = run.body(slider).center;
        off = worst(off, norm(sub(at, [exact, 0.0, 0.0])));
    });
    rows.at_most("slider", off, Unit::Meter, limits(2.0e-3, 2.0e-4));
    rows.relative("turns", 20.0, turned / (2.0 * PI), limits(0.005, 0.0005));
    Ok(())
}

/// Angular frequency and decay [1/s] of a path sampled every `dt`, by a least-squares fit of x'' -
/// T x' + D x = 0 to three consecutive samples.
fn fit(path: &[f64], dt: f64) -> (f64, f64) {
    let (mut yy, mut yx, mut xx, mut zy, mut zx) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for w in path.windows(3) {
        let [x, y, z] = [w[0], w[1], w[2]];
        (yy, yx, xx) = (yy + y * y, yx + y * x, xx + x * x);
        (zy, zx) = (zy + z * y, zx + z * x);
    }
    // z = T y - D x.
    let det = yy * xx - yx * yx;
    let (t, d) = ((zy * xx - zx * yx) / det, (zy * yx - zx * yy) / det);
    let decay = -0.5 * d.ln() / dt;
    (((0.5 * t / d.sqrt()).clamp(-1.0, 1.0)).acos() / dt, decay)
}

fn spring_damper(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    for hertz in [1.0, 5.0, 15.0] {
        for ratio in [0.0, 0.1, 0.5, 1.0] {
            let omega = 2.0 * PI * hertz;
            let mut scene = weightless("spring");
            let post = scene.add("post", BodyDef::fixed());
            let body = block([0.2; 3], Vec3::ZERO, Surface::rough(0.5)).with_mass(2.0);
            let body = scene.add("body", body);
            let (k, c) = (2.0 * omega * omega, 2.0 * 2.0 * ratio * omega);
            let spring = JointSpring::new(single(k), single(c));
            let drive = JointDrive::servo(0.1, spring, f32::INFINITY);
            let axes = Slider::of(JointAxis::driven(drive));
            add_joint(&mut scene, post, body, [0.0; 3], drystone::Quat::IDENTITY, axes)?;
            let mut run = lab.start(scene)?;
            let mut path = vec![-0.1];
            let end =
                if ratio > 0.0 { (6.0 / (ratio * omega)).clamp(5.0 * lab.dt(), 5.0) } else { 5.0 };
            run.until(end, |run| path.push(run.body(body).center[0] - 0.1));
            let (frequency, decay) = fit(&path, lab.dt());
            let case = |what: &str| format!("{hertz} Hz, ratio {ratio}, {what}");
            let exact = omega * f64::sqrt(1.0 - ratio * ratio);
            if ratio < 1.0 {
                rows.relative(case("frequency"), exact, frequency, limits(0.01, 0.002));
            }
            if ratio > 0.0 {
                rows.relative(case("decay"), ratio * omega, decay, limits(0.05, 0.01));
            } else {
                // As a fraction of critical damping.
                rows.at_most(case("decay"), (decay / omega).abs(), Unit::Part, limits(0.05, 0.01));
            }
        }
    }
    Ok(())
}

fn hinge_motor(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let near = limits(0.005, 0.0005);
    let mut scene = weightless("motor");
    let motor = JointAxis::driven(JointDrive::motor(4.0, 0.5));
    let (rod, inertia) = add_rod(&mut scene, 0.0, motor)?;
    let mut run = lab.start(scene)?;
    run.until(1.0, |_| {});
    rows.relative("speed after 1 s of torque", 0.5 / inertia, run.body(rod).w[2], near);
    run.until(5.0, |_| {});
    rows.relative("speed reached", 4.0, run.body(rod).w[2], near);
    let mut scene = empty("stall");
    let motor = JointAxis::driven(JointDrive::motor(4.0, 3.0));
    let (rod, _) = add_rod(&mut scene, -FRAC_PI_2, motor)?;
    scene.bodies[rod].def.angular_damping = 2.0;
    let mut run = lab.start(scene)?;
    run.until(20.0, |_| {});
    let exact = (3.0 / (0.5 * G)).asin();
    let angle = heading(&run.body(rod)) + FRAC_PI_2;
    rows.relative("angle of stall", exact, angle, near);
    Ok(())
}

/// Distances from the limit: a rod at a hinge's limit, alone and with a load fixed to its end, and
/// a body at a slider's limit.
fn limits_under_load(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let close = limits(0.5_f64.to_radians(), 0.1_f64.to_radians());
    for (load, mass) in [(0.0, 1.0), (0.0, 100.0), (100.0, 1.0)] {
        let mut scene = empty("hinge limit");
        let axis = JointAxis::limited(single(-30.0_f64.to_radians()), 1.0);
        let (rod, _) = add_rod(&mut scene, 0.0, axis)?;
        scene.bodies[rod].def.mass = drystone::MassDef::Mass(single(mass));
        if load > 0.0 {
            let end: D3 = [1.0, 0.0, 0.0];
            let weight = ball(0.1, narrow(end), Surface::rough(0.5)).with_mass(single(load));
            let weight = scene.add("load", weight);
            let frame = drystone::Quat::IDENTITY;
            add_joint(&mut scene, rod, weight, end, frame, SixDof::FIXED)?;
        }
        let mut run = lab.start(scene)?;
        run.until(4.0, |_| {});
        let angle = heading(&run.body(rod));
        let case = if load > 0.0 {
            format!("hinge, {load} kg fixed to a rod of 1 kg")
        } else {
            format!("hinge, rod of {mass} kg")
        };
        rows.absolute(case, -30.0_f64.to_radians(), angle, Unit::Radian, close);
    }
    for mass in [1.0, 100.0] {
        let mut scene = empty("slider limit");
        let post = scene.add("post", BodyDef::fixed());
        let shape = Surface::rough(0.5).on(ShapeDef::box_full(Vec3::splat(0.4)));
        let body = BodyDef::dynamic().with_shape(shape).with_mass(single(mass));
        let body = scene.add("body", body);
        let axes = Slider::of(JointAxis::limited(-1.0, 0.0));
        // The axis points up, and the anchor is beside the body.
        let up = turn([0.0, 0.0, 1.0], FRAC_PI_2);
        add_joint(&mut scene, post, body, [0.3, 0.0, 0.0], up, axes)?;
        let mut run = lab.start(scene)?;
        run.until(4.0, |_| {});
        let y = run.body(body).center[1];
        let case = format!("slider, {mass} kg");
        rows.absolute(case, -1.0, y, Unit::Meter, limits(3.0e-3, 0.5e-3));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::fit;

    #[test]
    fn the_fit_finds_frequency_and_decay() {
        let path: Vec<f64> = (0..40)
            .map(|i| f64::from(i) / 60.0)
            .map(|t| (-3.0 * t).exp() * (50.0 * t).cos())
            .collect();
        let (frequency, decay) = fit(&path, 1.0 / 60.0);
        assert!((frequency - 50.0).abs() < 1.0e-9 && (decay - 3.0).abs() < 1.0e-9);
    }
}
