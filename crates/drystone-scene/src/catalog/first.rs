//! The small scenes with an answer one can work out: a fall, a stack, a slope, a cradle.

use drystone::joint::Ball;
use drystone::math::trig;
use drystone::{BodyDef, Material, Quat, ShapeDef, Vec3, vec3};

use super::parameters::{CatalogError, Values};
use super::parts::{add_ground, add_ground_box, box_at, cos_sin, gravity_10, radians, real};
use crate::scene::{Scene, SceneJoint};

pub(super) fn hello(mut scene: Scene, _: &Values) -> Result<Scene, CatalogError> {
    scene.seconds = 5.0;
    add_ground(&mut scene, 0.6);
    let tilt = Quat::from_axis_angle(vec3(1.0, 0.5, 0.2), radians(25.0));
    scene.add("box", box_at(Vec3::splat(0.5), vec3(-1.0, 4.0, 0.0)).with_rotation(tilt));
    let rubber = Material { restitution: 0.6, rolling_resistance: 0.02, ..Material::default() };
    let ball = ShapeDef::sphere(0.4).with_material(rubber);
    scene.add("ball", BodyDef::dynamic().with_position(vec3(1.0, 4.0, 0.0)).with_shape(ball));
    Ok(scene)
}

pub(super) fn stack(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    let (n, ratio) = (values.whole("n"), values.number("top_mass_ratio"));
    let edge = values.number("edge");
    gravity_10(&mut scene);
    scene.seconds = 20.0;
    scene.config.sleep.enabled = false;
    add_ground_box(&mut scene, 20.0, 20.0);
    for i in 0..n {
        let density = if i + 1 == n { 1000.0 * ratio } else { 1000.0 };
        let cube = ShapeDef::box_half(Vec3::splat(0.5 * edge)).with_density(density);
        let position = vec3(0.0, edge * (0.5 + real(i)), 0.0);
        scene.add(format!("cube {i}"), BodyDef::dynamic().with_position(position).with_shape(cube));
    }
    Ok(scene)
}

/// A slope of slope `tan` through the origin and a cube on it, `drop` above it [m].
struct Slope {
    tan: f32,
    friction: f32,
    restitution: f32,
    drop: f32,
}

fn add_slope(scene: &mut Scene, slope: &Slope) {
    let turn = Quat::from_axis_angle(Vec3::Z, trig::atan2(slope.tan, 1.0));
    let surface = Material {
        friction: slope.friction,
        restitution: slope.restitution,
        ..Material::default()
    };
    let ramp = ShapeDef::box_half(vec3(100.0, 1.0, 20.0)).with_material(surface);
    let below = turn.rotate(vec3(0.0, -1.0, 0.0));
    scene.add("ramp", BodyDef::fixed().with_position(below).with_rotation(turn).with_shape(ramp));
    let cube = ShapeDef::box_half(Vec3::splat(0.5)).with_material(surface);
    let above = turn.rotate(vec3(0.0, 0.5 + slope.drop, 0.0));
    scene.add("cube", BodyDef::dynamic().with_position(above).with_rotation(turn).with_shape(cube));
}

pub(super) fn incline(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    gravity_10(&mut scene);
    scene.seconds = 5.0;
    scene.config.sleep.enabled = false;
    let slope = Slope {
        tan: values.number("tan"),
        friction: values.number("mu"),
        restitution: values.number("restitution"),
        drop: values.number("drop"),
    };
    add_slope(&mut scene, &slope);
    Ok(scene)
}

pub(super) fn bouncy_cube_incline(mut scene: Scene, _: &Values) -> Result<Scene, CatalogError> {
    gravity_10(&mut scene);
    scene.seconds = 5.0;
    scene.config.sleep.enabled = false;
    add_slope(&mut scene, &Slope { tan: 0.4, friction: 0.6, restitution: 1.0, drop: 0.0 });
    Ok(scene)
}

pub(super) fn cradle(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    const STRING: f32 = 5.0;
    let (balls, pulled) = (values.whole("balls"), values.whole("pulled"));
    if pulled > balls {
        return Err(CatalogError::Together {
            scene: "cradle",
            problem: format!(
                "`pulled` must be at most the number of balls, {balls} (got {pulled})"
            ),
        });
    }
    gravity_10(&mut scene);
    scene.seconds = 10.0;
    scene.config.sleep.enabled = false;
    let pitch = 1.0 + values.number("gap");
    let middle = 0.5 * real(balls - 1) * pitch;
    let top = 1.0 + STRING;
    let beam = ShapeDef::box_half(vec3(middle + 1.0, 0.1, 0.1));
    scene.add("beam", BodyDef::fixed().with_position(vec3(0.0, top, 0.0)).with_shape(beam));
    let steel = Material { friction: 0.0, restitution: 1.0, ..Material::default() };
    for i in 0..balls {
        let x = pitch * real(i) - middle;
        let angle = if i < pulled { radians(-30.0) } else { 0.0 };
        let (c, s) = cos_sin(angle);
        let ball = BodyDef::dynamic()
            .with_position(vec3(x + STRING * s, top - STRING * c, 0.0))
            .with_rotation(Quat::from_axis_angle(Vec3::Z, angle))
            .with_shape(ShapeDef::sphere(0.5).with_material(steel));
        let body_b = scene.add(format!("ball {i}"), ball);
        let ends = ((0, vec3(x, 0.0, 0.0)), (body_b, vec3(0.0, STRING, 0.0)));
        scene.joints.push(SceneJoint::new(ends.0, ends.1, Ball::new()));
    }
    Ok(scene)
}
