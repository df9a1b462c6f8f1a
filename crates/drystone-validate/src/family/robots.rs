//! Robots: momentum and energy of many bodies on joints.
//!
//! The tests of SimBenchmark with ANYmal in its current description: 30.5 kg instead of 33.9 kg.
//! Links connected by fixed joints are one body.

use std::path::Path;

use drystone::joint::JointMotion;
use drystone::{BodyKind, Filter, JointKind, Shape, Vec3, vec3};
use drystone_bench::EngineError;
use drystone_scene::{Scene, urdf};

use crate::lab::Lab;
use crate::numeric::{dot, sub, wide};
use crate::row::{Rows, Unit, limits};
use crate::setup::{G, Surface, ball};
use crate::test::Test;

pub(crate) const TESTS: &[Test] = &[
    Test::new("S5", "a ball hits ANYmal, 10 s", "", "momentum stays 50 kg m/s", momentum),
    Test::new(
        "S6",
        "ANYmal thrown up by twice its weight for 1 s, then 2 s free",
        "",
        "energy stays what it was when the force ended",
        energy,
    ),
];

/// Initial height of the robot [m].
const HEIGHT: f32 = 2.0;

/// ANYmal in the air, with joints without limits; its parts do not collide with each other.
fn anymal() -> Result<Scene, EngineError> {
    let options = urdf::Options { base: urdf::Base::Floating, ground: None };
    let text = include_str!("../../data/anymal.urdf");
    let scene = urdf::from_text(text, Path::new(""), &options);
    let mut scene = scene.map_err(|e| EngineError(e.to_string()))?;
    for body in &mut scene.bodies {
        body.def.position.z += HEIGHT;
        for shape in &mut body.def.shapes {
            shape.filter = Filter::layers(1, 2);
            shape.material.friction = 0.0;
        }
    }
    for joint in &mut scene.joints {
        if let JointKind::SixDof(six) = &mut joint.kind {
            for axis in &mut six.angular {
                if matches!(axis.motion, JointMotion::Limited { .. }) {
                    axis.motion = JointMotion::Free;
                }
            }
        }
    }
    Ok(scene)
}

/// Removes the joints that only keep links from colliding: they hold nothing, and nothing collides
/// without them.
fn without_ties(mut scene: Scene) -> Scene {
    scene.joints.retain(|j| matches!(j.kind, JointKind::SixDof(_)));
    scene
}

fn momentum(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let mut scene = without_ties(anymal()?);
    scene.config.gravity = Vec3::ZERO;
    let mut thrown = ball(0.2, vec3(0.0, -5.0, HEIGHT), Surface::rough(0.0)).with_mass(10.0);
    thrown.linear_velocity = vec3(0.0, 5.0, 0.0);
    thrown.shapes[0].filter = Filter::layers(2, 1);
    let ball = scene.add("ball", thrown);
    let mut run = lab.start(scene)?;
    let exact = run.momentum();
    let (mut sum, mut count) = (0.0, 0.0);
    run.until(10.0, |run| {
        let off = sub(run.momentum(), exact);
        sum += dot(off, off);
        count += 1.0;
    });
    if run.body(ball).v[1] > 4.9 {
        return Err(EngineError("the ball has missed".to_owned()));
    }
    let unit = Unit::SquareMomentum;
    rows.at_most("mean square of its error", sum / count, unit, limits(1.0e-6, 1.0e-8));
    Ok(())
}

fn energy(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    let mut scene = without_ties(anymal()?);
    for body in &mut scene.bodies {
        body.def.shapes.retain(|s| matches!(s.shape, Shape::HalfSpace { .. }));
    }
    let base = scene.bodies.iter().position(|b| b.def.kind == BodyKind::Dynamic);
    let base = base.ok_or_else(|| EngineError("it has no base".to_owned()))?;
    let mut run = lab.start(scene)?;
    let mass: f64 = run.dynamic().map(|body| run.matter(body).mass).sum();
    let force = wide(vec3(0.0, 0.0, 1.0)).map(|x| 2.0 * mass * G * x);
    let force = crate::numeric::narrow(force);
    let steps = crate::numeric::whole(1.0 / lab.dt());
    for _ in 0..steps {
        run.push(base, force)?;
        run.step();
    }
    let exact = run.energy();
    let (mut sum, mut count) = (0.0, 0.0);
    run.until(3.0, |run| {
        let off = run.energy() - exact;
        sum += off * off;
        count += 1.0;
    });
    let off = f64::sqrt(sum / count) / exact;
    rows.at_most("RMS of its error, per energy", off, Unit::Part, limits(2.0e-3, 1.0e-4));
    Ok(())
}
