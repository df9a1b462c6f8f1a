//! Free flight: gravity alone.

use drystone::BodyDef;
use drystone_bench::EngineError;

use crate::lab::Lab;
use crate::numeric::{D3, add, narrow, norm, scale, sub, wide, worst};
use crate::row::{Limits, Rows, Unit, limits};
use crate::setup::{Surface, ball, block, empty};
use crate::test::Test;

pub(crate) const TESTS: &[Test] = &[
    Test::new("A1", "free fall, 10 s", "", "v = −g t, y = y0 − g t²/2", free_fall).swept(),
    Test::new(
        "A2",
        "projectile, 10 s",
        "with and without spin",
        "p = p0 + v0 t + g t²/2",
        projectile,
    )
    .swept(),
];

/// The position may be off by the lag of a semi-implicit step at 240 Hz, g h t / 2, and 1 % more.
/// Only a second-order step reaches the `great` limit.
pub(super) const PLACE: Limits = limits(0.206, 0.005);

fn free_fall(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let mut scene = empty("free fall");
    scene.add("ball", ball(0.5, drystone::Vec3::ZERO, Surface::rough(0.5)));
    let mut run = lab.start(scene)?;
    run.until(10.0, |_| {});
    let (t, g) = (run.time(), -run.gravity()[1]);
    let now = run.body(0);
    rows.absolute("v", -g * t, now.v[1], Unit::MeterPerSecond, limits(2.0e-4, 2.0e-4));
    rows.absolute("y", -0.5 * g * t * t, now.center[1], Unit::Meter, PLACE);
    Ok(())
}

fn projectile(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    for (case, w) in [("no spin", [0.0; 3]), ("w (0.1, 5, 0.1)", [0.1, 5.0, 0.1])] {
        let v0 = [-2.0, 2.0, 8.0];
        let error = flight(lab, v0, w, [0.0, 0.0, -9.8])?;
        rows.at_most(case, error, Unit::Meter, PLACE);
    }
    Ok(())
}

/// The box of the scpeters benchmark, 10 kg.
pub(super) fn boxes_body(v: D3, w: D3) -> BodyDef {
    block([0.1, 0.4, 0.9], drystone::Vec3::ZERO, Surface::rough(0.5))
        .with_mass(10.0)
        .with_linear_velocity(narrow(v))
        .with_angular_velocity(narrow(w))
}

/// Maximum distance from the exact parabola in 10 s [m].
fn flight(lab: &Lab, v0: D3, w0: D3, g: D3) -> Result<f64, EngineError> {
    let mut scene = empty("projectile");
    scene.config.gravity = narrow(g);
    scene.add("box", boxes_body(v0, w0));
    let mut run = lab.start(scene)?;
    let g = run.gravity();
    let v0 = wide(narrow(v0));
    let mut error = 0.0;
    run.until(10.0, |run| {
        let t = run.time();
        let exact = add(scale(v0, t), scale(g, 0.5 * t * t));
        error = worst(error, norm(sub(run.body(0).center, exact)));
    });
    Ok(error)
}
