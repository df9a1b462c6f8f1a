//! Rotation of free bodies: momentum, energy, and the frequencies of precession and flips.

use core::f64::consts::TAU;

use drystone::math::Sym3;
use drystone::{BodyDef, MassDef, Vec3, vec3};
use drystone_bench::EngineError;

use super::flight::{PLACE, boxes_body};
use crate::lab::{Lab, Run};
use crate::numeric::{
    Crossings, D3, add, angle_between, elliptic_k, narrow, norm, scale, single, sub, turn, wide,
    worst,
};
use crate::row::{Rows, Unit, limits};
use crate::setup::{add_ball_joint, empty, weightless};
use crate::test::Test;

pub(crate) const TESTS: &[Test] = &[
    Test::new("A3", "spin about a principal axis, 10 s", "axis", "w constant, angle = w t", spin),
    Test::new(
        "A4",
        "tumbling box, 10 s",
        "",
        "L and rotational energy constant; w_y changes its sign at 1.166, 4.194, 7.223 s",
        tumble,
    )
    .swept(),
    Test::new(
        "A5",
        "free precession of a disc tilted by 20°",
        "spin",
        "rate in its own axes (I3 − I1)/I1 w3",
        precession,
    )
    .swept(),
    Test::new(
        "A6",
        "heavy top on a ball joint, 300 rad/s",
        "tilt of the axis",
        "I1' cos(t) P² − I3 w3 P + m g r = 0, slow root",
        heavy_top,
    ),
    Test::new(
        "SP1",
        "boxes benchmark of scpeters, simple, 10 s",
        "",
        "p = v t; L and E constant",
        boxes_simple,
    ),
    Test::new(
        "SP2",
        "boxes benchmark of scpeters, complex, 10 s",
        "",
        "parabola; L and E constant",
        boxes_complex,
    )
    .swept(),
    Test::new(
        "G9",
        "Dzhanibekov effect, I = (1, 2, 3), 20 s",
        "w0",
        "w2 changes its sign at K/p, then every 2 K/p",
        dzhanibekov,
    )
    .swept(),
    Test::new("G10", "free spin, 20 rad/s, 60 s", "axis", "L and E constant", free_spin),
];

/// Drifts of a freely rotating body.
struct Drifts {
    momentum: f64,
    rotational: f64,
    total: f64,
    flips: Vec<f64>,
}

/// Runs the first body of a scene and tracks the conserved quantities.
fn follow(run: &mut Run, seconds: f64) -> Drifts {
    let start = run.body(0);
    let (l0, e0, total0) = (start.spin(), start.rotational_energy(), run.energy());
    let mut drifts = Drifts { momentum: 0.0, rotational: 0.0, total: 0.0, flips: Vec::new() };
    let mut side = Crossings::default();
    side.read(0.0, start.w_body()[1]);
    run.until(seconds, |run| {
        let now = run.body(0);
        drifts.momentum = worst(drifts.momentum, norm(sub(now.spin(), l0)) / norm(l0));
        drifts.rotational = worst(drifts.rotational, (now.rotational_energy() / e0 - 1.0).abs());
        drifts.total = worst(drifts.total, (run.energy() / total0 - 1.0).abs());
        side.read(run.time(), now.w_body()[1]);
    });
    drifts.flips = side.times.iter().map(|(time, _)| *time).collect();
    drifts
}

fn spin(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    for (name, axis) in [("x", [1.0, 0.0, 0.0]), ("y", [0.0, 1.0, 0.0]), ("z", [0.0, 0.0, 1.0])] {
        let mut scene = weightless("spin");
        scene.add("box", boxes_body([-0.9, 0.4, 0.1], scale(axis, 0.5)));
        let mut run = lab.start(scene)?;
        let (mut speed, mut angle) = (0.0, 0.0);
        run.until(10.0, |run| {
            let now = run.body(0);
            speed = worst(speed, norm(sub(now.w, scale(axis, 0.5))));
            let exact = turn(axis, 0.5 * run.time());
            angle = worst(angle, angle_between(now.state.pose.rotation, exact));
        });
        let case = |what: &str| format!("{name}, {what}");
        rows.at_most(case("w"), speed, Unit::RadianPerSecond, limits(1.0e-5, 1.0e-6));
        rows.at_most(case("angle"), angle, Unit::Radian, limits(1.0e-3, 1.0e-4));
    }
    Ok(())
}

fn tumble(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let mut scene = weightless("tumble");
    scene.add("box", boxes_body([0.0; 3], [0.1, 5.0, 0.1]));
    let drifts = follow(&mut lab.start(scene)?, 10.0);
    rows.at_most("L", drifts.momentum, Unit::Part, limits(1.0e-2, 1.0e-4));
    rows.at_most("E", drifts.rotational, Unit::Part, limits(1.0e-2, 1.0e-3));
    flip_rows(rows, "", &[1.166, 4.1944, 7.2229], &drifts.flips);
    Ok(())
}

/// Number and times of the sign changes.
fn flip_rows(rows: &mut Rows, case: &str, expected: &[f64], flips: &[f64]) {
    let counts = (expected.len() as f64, flips.len() as f64);
    let off = (counts.0 - counts.1).abs();
    rows.error(format!("{case}flips"), counts, off, Unit::Count, limits(0.0, 0.0));
    for (i, expected) in expected.iter().enumerate() {
        let measured = flips.get(i).copied().unwrap_or(f64::NAN);
        let case = format!("{case}flip {}", i + 1);
        rows.absolute(case, *expected, measured, Unit::Second, limits(0.1, 0.01));
    }
}

fn precession(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let (r, h) = (0.5, 0.1);
    for w in [1.0, 5.0, 20.0] {
        let mut scene = weightless("precession");
        let tilt = 20.0_f64.to_radians();
        let velocity = [w * tilt.sin(), w * tilt.cos(), 0.0];
        let disc = drystone::ShapeDef::cylinder(single(0.5 * h), single(r));
        scene.add(
            "disc",
            BodyDef::dynamic().with_shape(disc).with_angular_velocity(narrow(velocity)),
        );
        let mut run = lab.start(scene)?;
        let (axial, across) = (0.5 * r * r, 0.25 * r * r + h * h / 12.0);
        let rate = (axial - across) / across * velocity[1];
        let (mut angle, mut last) = (0.0, 0.0_f64);
        run.until(10.0, |run| {
            let b = run.body(0).w_body();
            // From x to −z is a positive rotation about y; w rotates that way in the body's axes if
            // I3 > I1.
            let now = (-b[2]).atan2(b[0]);
            angle += near_zero(now - last);
            last = now;
        });
        rows.relative(format!("w {w} rad/s"), rate, angle / run.time(), limits(0.01, 0.001));
    }
    Ok(())
}

/// Wraps an angle to −π to π.
fn near_zero(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

fn heavy_top(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    // A disc of about 1 kg whose center is 0.1 m from the joint.
    let (radius, height, arm, spin) = (0.1, 0.02, 0.1, 300.0);
    for degrees in [20.0_f64, 45.0, 70.0] {
        let t = degrees.to_radians();
        let axial = 0.5 * radius * radius;
        let across = 0.25 * radius * radius + height * height / 12.0 + arm * arm;
        let weight = crate::setup::G * arm;
        let (a, b) = (across * t.cos(), axial * spin);
        let precession = 2.0 * weight / (b + (b * b - 4.0 * a * weight).sqrt());
        let axis = [t.sin(), t.cos(), 0.0];
        // The spin is the total rate along the axis, so the component that precession adds is
        // subtracted.
        let w = add(scale(axis, spin - precession * t.cos()), [0.0, precession, 0.0]);
        let center = scale(axis, arm);
        let mut scene = empty("heavy top");
        let disc = drystone::ShapeDef::cylinder(single(0.5 * height), single(radius));
        let top = BodyDef::dynamic()
            .with_position(narrow(center))
            .with_rotation(turn([0.0, 0.0, 1.0], -t))
            .with_shape(disc.with_density(1600.0))
            .with_linear_velocity(narrow(crate::numeric::cross([0.0, precession, 0.0], center)))
            .with_angular_velocity(narrow(w));
        let top = scene.add("top", top);
        let post = scene.add("post", BodyDef::fixed());
        add_ball_joint(&mut scene, post, top, [0.0; 3])?;
        let mut run = lab.start(scene)?;
        let (mut angle, mut last) = (0.0, 0.0_f64);
        run.until(5.0, |run| {
            let axis = run.body(top).direction([0.0, 1.0, 0.0]);
            let now = (-axis[2]).atan2(axis[0]);
            angle += near_zero(now - last);
            last = now;
        });
        let case = format!("tilt {degrees}°");
        rows.relative(case, precession, angle / run.time(), limits(0.03, 0.01));
    }
    Ok(())
}

fn boxes_simple(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let v = [-0.9, 0.4, 0.1];
    let mut scene = weightless("boxes, simple");
    scene.add("box", boxes_body(v, [0.5, 0.0, 0.0]));
    let mut run = lab.start(scene)?;
    let drifts = follow(&mut run, 10.0);
    let exact = scale(wide(narrow(v)), run.time());
    let place = norm(sub(run.body(0).center, exact));
    rows.at_most("L", drifts.momentum, Unit::Part, limits(1.0e-2, 1.0e-4));
    rows.at_most("E", drifts.total, Unit::Part, limits(1.0e-2, 1.0e-3));
    rows.at_most("place", place, Unit::Meter, PLACE);
    Ok(())
}

/// Errors of ODE, Bullet, Simbody and DART at steps of 1 ms: in L 1.3e-2, 1.2e-2, 6.4e-3 and 2.2;
/// in E 1.2e-2, 1.4e-2, 6.2e-3 and 3.8e-2; in position 49, 49, 25 and 49 mm.
fn boxes_complex(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let v = [-2.0, 2.0, 8.0];
    let mut scene = empty("boxes, complex");
    scene.config.gravity = vec3(0.0, 0.0, -9.8);
    scene.add("box", boxes_body(v, [0.1, 5.0, 0.1]));
    let mut run = lab.start(scene)?;
    let drifts = follow(&mut run, 10.0);
    let t = run.time();
    let exact = add(scale(v, t), scale(run.gravity(), 0.5 * t * t));
    let place = norm(sub(run.body(0).center, exact));
    rows.at_most("L", drifts.momentum, Unit::Part, limits(1.0e-2, 1.0e-4));
    rows.at_most("E", drifts.total, Unit::Part, limits(1.0e-2, 1.0e-3));
    rows.at_most("place", place, Unit::Meter, PLACE);
    Ok(())
}

/// Time of the first sign change and time between two, for moments I1 < I2 < I3 and w mostly along
/// axis 2.
pub(crate) fn flip_times([i1, i2, i3]: D3, w: D3) -> (f64, f64) {
    let squares = [i1 * w[0] * w[0], i2 * w[1] * w[1], i3 * w[2] * w[2]];
    let twice_t = squares[0] + squares[1] + squares[2];
    let l2 = i1 * squares[0] + i2 * squares[1] + i3 * squares[2];
    // The formula assumes L² < 2 T I2; otherwise the first and third axis are swapped.
    let (i1, i3) = if l2 < twice_t * i2 { (i1, i3) } else { (i3, i1) };
    let p2 = (i2 - i1) * (twice_t * i3 - l2) / (i1 * i2 * i3);
    let m = (i3 - i2) * (l2 - twice_t * i1) / ((i2 - i1) * (twice_t * i3 - l2));
    let k = elliptic_k(m) / p2.sqrt();
    (k, 2.0 * k)
}

fn dzhanibekov(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    for (case, w) in
        [("w0 (0.01, 5, 0): ", [0.01, 5.0, 0.0]), ("w0 (0.1, 10, 0): ", [0.1, 10.0, 0.0])]
    {
        let mut scene = weightless("Dzhanibekov");
        let inertia = Sym3::diagonal(vec3(1.0, 2.0, 3.0));
        let mass = MassDef::Exact { mass: 1.0, center: Vec3::ZERO, inertia };
        let body = BodyDef { mass, ..BodyDef::dynamic().with_angular_velocity(narrow(w)) };
        scene.add("body", body);
        let drifts = follow(&mut lab.start(scene)?, 20.0);
        let (first, between) = flip_times([1.0, 2.0, 3.0], wide(narrow(w)));
        let times = (0..12).map(|i| first + between * f64::from(i));
        let expected: Vec<f64> = times.filter(|time| *time < 20.0).collect();
        flip_rows(rows, case, &expected, &drifts.flips);
    }
    Ok(())
}

fn free_spin(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let axes = [("x", [1.0, 0.0, 0.0]), ("z", [0.0, 0.0, 1.0]), ("(1, 2, 2)/3", [1.0, 2.0, 2.0])];
    for (case, axis) in axes {
        let mut scene = weightless("free spin");
        scene.add("box", boxes_body([0.0; 3], scale(axis, 20.0 / norm(axis))));
        let drifts = follow(&mut lab.start(scene)?, 60.0);
        rows.at_most(format!("{case}, E"), drifts.rotational, Unit::Part, limits(1.0e-4, 1.0e-4));
        rows.at_most(format!("{case}, L"), drifts.momentum, Unit::Part, limits(1.0e-5, 1.0e-5));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use core::f64::consts::PI;

    use super::{flip_times, near_zero};
    use crate::numeric::runge_kutta;

    #[test]
    fn flips_are_where_eulers_equations_have_them() {
        for (i, w, published) in [
            ([1.0, 2.0, 3.0], [0.01, 5.0, 0.0], Some((2.633, 5.26606))),
            ([1.0, 2.0, 3.0], [0.1, 10.0, 0.0], Some((1.0377, 2.07546))),
            ([1.0, 2.0, 3.0], [0.0, 5.0, 0.2], None),
        ] {
            let (first, between) = flip_times(i, w);
            if let Some((a, b)) = published {
                assert!((first - a).abs() < 1.0e-3 && (between - b).abs() < 1.0e-4);
            }
            let (mut x, h, mut t, mut crossed) = (w, 1.0e-4, 0.0, Vec::new());
            while crossed.len() < 2 {
                let next = runge_kutta(&x, h, |w| {
                    [
                        (i[1] - i[2]) / i[0] * w[1] * w[2],
                        (i[2] - i[0]) / i[1] * w[2] * w[0],
                        (i[0] - i[1]) / i[2] * w[0] * w[1],
                    ]
                });
                if x[1] * next[1] < 0.0 {
                    crossed.push(t + h * x[1] / (x[1] - next[1]));
                }
                (x, t) = (next, t + h);
            }
            assert!((crossed[0] - first).abs() < 1.0e-6, "{crossed:?} {first}");
            assert!((crossed[1] - crossed[0] - between).abs() < 1.0e-6, "{crossed:?} {between}");
        }
    }

    #[test]
    fn angles_are_unwound() {
        assert!((near_zero(1.5 * PI) + 0.5 * PI).abs() < 1.0e-12);
        assert!((near_zero(-1.5 * PI) - 0.5 * PI).abs() < 1.0e-12);
    }
}
