//! Common parts of scenes: floors, slopes, cubes and balls.

use drystone::joint::{Ball, SixDof};
use drystone::{BodyDef, JointKind, Quat, ShapeDef, Vec3};
use drystone_bench::EngineError;
use drystone_scene::{Scene, SceneJoint};

use crate::numeric::{D3, add, narrow, rotate, scale, single, turn};

/// Standard gravity of the tests [m/s²], in the engine's precision.
pub(crate) const G: f64 = 9.81_f32 as f64;

/// Properties of a surface: friction, restitution.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Surface {
    /// Coefficient of friction.
    pub(crate) mu: f64,
    /// Coefficient of restitution.
    pub(crate) e: f64,
}

impl Surface {
    /// A surface without bounce.
    #[must_use]
    pub(crate) const fn rough(mu: f64) -> Self {
        Self { mu, e: 0.0 }
    }

    /// A surface without friction.
    #[must_use]
    pub(crate) const fn bouncy(e: f64) -> Self {
        Self { mu: 0.0, e }
    }

    /// A shape with this surface.
    #[must_use]
    pub(crate) fn on(self, shape: ShapeDef) -> ShapeDef {
        shape.with_friction(single(self.mu)).with_restitution(single(self.e))
    }
}

/// An empty scene.
#[must_use]
pub(crate) fn empty(name: &str) -> Scene {
    Scene::new(name, "")
}

/// An empty scene without gravity.
#[must_use]
pub(crate) fn weightless(name: &str) -> Scene {
    let mut scene = empty(name);
    scene.config.gravity = Vec3::ZERO;
    scene
}

/// Flat ground at height 0.
pub(crate) fn add_floor(scene: &mut Scene, surface: Surface) -> usize {
    let ground = surface.on(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0));
    scene.add("ground", BodyDef::fixed().with_shape(ground))
}

/// A slope through the origin that falls toward +x.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Slope {
    /// Its angle [rad].
    pub(crate) angle: f64,
}

impl Slope {
    /// The slope of this angle [degrees].
    #[must_use]
    pub(crate) fn degrees(angle: f64) -> Self {
        Self { angle: angle.to_radians() }
    }

    /// The normal, out of the ground.
    #[must_use]
    pub(crate) fn normal(self) -> D3 {
        [self.angle.sin(), self.angle.cos(), 0.0]
    }

    /// The direction down the slope.
    #[must_use]
    pub(crate) fn down(self) -> D3 {
        [self.angle.cos(), -self.angle.sin(), 0.0]
    }

    /// The rotation from upright to perpendicular to the slope.
    #[must_use]
    pub(crate) fn turn(self) -> Quat {
        turn([0.0, 0.0, 1.0], -self.angle)
    }

    /// A point at these distances down the slope, above its surface, and to the side [m].
    #[must_use]
    pub(crate) fn place(self, down: f64, above: f64, side: f64) -> Vec3 {
        let p = add(scale(self.down(), down), scale(self.normal(), above));
        narrow(add(p, [0.0, 0.0, side]))
    }

    /// Adds the ground.
    pub(crate) fn add(self, scene: &mut Scene, surface: Surface) -> usize {
        let ground = surface.on(ShapeDef::half_space(narrow(self.normal()), 0.0));
        scene.add("slope", BodyDef::fixed().with_shape(ground))
    }
}

/// A dynamic box of these edge lengths [m] at a place.
#[must_use]
pub(crate) fn block(extents: D3, position: Vec3, surface: Surface) -> BodyDef {
    let shape = surface.on(ShapeDef::box_full(narrow(extents)));
    BodyDef::dynamic().with_position(position).with_shape(shape)
}

/// A dynamic ball.
#[must_use]
pub(crate) fn ball(radius: f64, position: Vec3, surface: Surface) -> BodyDef {
    let shape = surface.on(ShapeDef::sphere(single(radius)));
    BodyDef::dynamic().with_position(position).with_shape(shape)
}

/// Adds a ball joint at a point of the world, with the bodies at their initial poses.
///
/// # Errors
/// Fails if a body of this number does not exist.
pub(crate) fn add_ball_joint(
    scene: &mut Scene,
    a: usize,
    b: usize,
    point: D3,
) -> Result<(), EngineError> {
    join(scene, [a, b], point, Ball::new())
}

/// Adds a six-axis joint at a point of the world, with the bodies at their initial poses; `frame`
/// has its axes.
///
/// # Errors
/// Fails if a body of this number does not exist.
pub(crate) fn add_joint(
    scene: &mut Scene,
    a: usize,
    b: usize,
    point: D3,
    frame: Quat,
    axes: impl Into<SixDof>,
) -> Result<(), EngineError> {
    let local =
        |number: usize| Ok::<_, EngineError>(body(scene, number)?.rotation.conjugate() * frame);
    let axes = SixDof { frame_a: local(a)?, frame_b: local(b)?, ..axes.into() };
    join(scene, [a, b], point, axes)
}

fn body(scene: &Scene, number: usize) -> Result<&BodyDef, EngineError> {
    let missing = || EngineError(format!("the scene has no body {number}"));
    Ok(&scene.bodies.get(number).ok_or_else(missing)?.def)
}

fn join(
    scene: &mut Scene,
    [a, b]: [usize; 2],
    point: D3,
    kind: impl Into<JointKind>,
) -> Result<(), EngineError> {
    let anchor = |number: usize| {
        let def = body(scene, number)?;
        let from = add(point, scale(crate::numeric::wide(def.position), -1.0));
        Ok::<_, EngineError>(narrow(rotate(def.rotation.conjugate(), from)))
    };
    let (anchor_a, anchor_b) = (anchor(a)?, anchor(b)?);
    scene.joints.push(SceneJoint::new((a, anchor_a), (b, anchor_b), kind));
    Ok(())
}
