//! Bodies held together by joints.

use drystone::joint::Ball;
use drystone::{BodyDef, Filter, Quat, ShapeDef, Vec3, vec3};

use super::breaking::{Held, add_bonded_wall};
use super::masonry::add_wall;
use super::parameters::{CatalogError, Values};
use super::parts::{add_ground, box_at, cos_sin, radians, real};
use crate::scene::{Scene, SceneJoint};

/// A straight chain that hangs from a fixed block, with a ball at its end.
struct Chain {
    /// Where it is held [m].
    top: Vec3,
    /// Its angle from hanging down, towards +z for a positive one [rad].
    angle: f32,
    /// Number of links, each half a meter long.
    links: usize,
    /// Radius of the ball [m].
    ball_radius: f32,
    /// Mass of the ball [kg].
    ball_mass: f32,
}

/// Length of a link [m].
const LINK: f32 = 0.5;
/// Mass of a link [kg].
const LINK_MASS: f32 = 1.0;

fn add_chain(scene: &mut Scene, chain: &Chain) {
    let turn = Quat::from_axis_angle(Vec3::X, -chain.angle);
    let down = turn.rotate(-Vec3::Y);
    // Links that swing back must not hit the body they hang from.
    let block = ShapeDef::box_half(Vec3::splat(0.2)).with_filter(Filter::layers(0, 0));
    let mut above = scene.add("hook", BodyDef::fixed().with_position(chain.top).with_shape(block));
    let mut anchor = Vec3::ZERO;
    for i in 0..chain.links {
        let link = BodyDef::dynamic()
            .with_position(chain.top + down * (LINK * (real(i) + 0.5)))
            .with_rotation(turn)
            .with_mass(LINK_MASS)
            .with_shape(ShapeDef::capsule(0.5 * LINK - 0.06, 0.06));
        let this = scene.add(format!("link {i}"), link);
        let up = vec3(0.0, 0.5 * LINK, 0.0);
        scene.joints.push(SceneJoint::new((above, anchor), (this, up), Ball::new()));
        (above, anchor) = (this, -up);
    }
    let reach = LINK * real(chain.links) + chain.ball_radius;
    let ball = BodyDef::dynamic()
        .with_position(chain.top + down * reach)
        .with_rotation(turn)
        .with_mass(chain.ball_mass)
        .with_shape(ShapeDef::sphere(chain.ball_radius));
    let this = scene.add("ball", ball);
    scene.joints.push(SceneJoint::new(
        (above, anchor),
        (this, vec3(0.0, chain.ball_radius, 0.0)),
        Ball::new(),
    ));
}

pub(super) fn chain(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    let links = values.whole("links");
    let chain = Chain {
        top: vec3(0.0, LINK * real(links) + 2.0, 0.0),
        angle: radians(60.0),
        links,
        ball_radius: 0.5,
        ball_mass: LINK_MASS * values.number("mass_ratio"),
    };
    add_chain(&mut scene, &chain);
    Ok(scene)
}

pub(super) fn wrecking_ball(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    add_ground(&mut scene, 0.6);
    let mut ball_mass = 500.0;
    match values.whole("bond") {
        0 => add_wall(&mut scene, 12, 16),
        bond => {
            let held = if bond == 1 { Held::Glue } else { Held::Joints };
            add_bonded_wall(&mut scene, (10, 10), held)?;
            ball_mass = 3000.0;
        }
    }
    // Held above the wall: at its lowest the middle of the ball passes at 1.3 m.
    let links = 12;
    let ball_radius = 0.6;
    let top = vec3(0.0, LINK * real(links) + ball_radius + 1.3, 0.9);
    let angle = radians(70.0);
    add_chain(&mut scene, &Chain { top, angle, links, ball_radius, ball_mass });
    Ok(scene)
}

pub(super) fn bridge(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    let planks = values.whole("planks");
    // The joints between planks lie on an arc of 60 degrees, so that the bridge starts slack.
    let (half, pitch) = (vec3(0.19, 0.04, 0.8), 0.4);
    let step = radians(60.0) / real(planks);
    let (_, half_sine) = cos_sin(0.5 * step);
    let radius = 0.5 * pitch / half_sine;
    let (end_cos, end_sin) = cos_sin(radians(30.0));
    let height = 2.0 + radius * (1.0 - end_cos);
    let center = vec3(0.0, height + radius * end_cos, 0.0);
    add_ground(&mut scene, 0.6);
    let post = |x: f32| {
        let half = vec3(0.5, 0.5 * height, 1.0);
        let body = BodyDef::fixed().with_position(vec3(x, half.y, 0.0));
        body.with_shape(ShapeDef::box_half(half))
    };
    let end = radius * end_sin;
    let left = scene.add("left post", post(-end - 0.5));
    let right = scene.add("right post", post(end + 0.5));
    let sides = [-half.z, half.z];
    let join = |a: (usize, Vec3), b: (usize, Vec3), scene: &mut Scene| {
        for z in sides {
            let side = vec3(0.0, 0.0, z);
            scene.joints.push(SceneJoint::new((a.0, a.1 + side), (b.0, b.1 + side), Ball::new()));
        }
    };
    let mut previous = (left, vec3(0.5, 0.5 * height, 0.0));
    let rope = vec3(0.5 * pitch, 0.0, 0.0);
    // The middle of a chord is nearer to the center of the arc than its ends.
    let (half_cos, _) = cos_sin(0.5 * step);
    for i in 0..planks {
        let angle = step * (real(i) + 0.5) - radians(30.0);
        let (c, s) = cos_sin(angle);
        let def = box_at(half, center + vec3(s, -c, 0.0) * (radius * half_cos))
            .with_rotation(Quat::from_axis_angle(Vec3::Z, angle));
        let this = scene.add(format!("plank {i}"), def);
        join(previous, (this, -rope), &mut scene);
        previous = (this, rope);
    }
    join(previous, (right, vec3(-0.5, 0.5 * height, 0.0)), &mut scene);
    for i in 0..8 {
        let x = 0.15 * end * (real(i) - 3.5);
        let position = vec3(x, height + 1.5 + 0.3 * real(i), 0.0);
        let shape =
            if i % 2 == 0 { ShapeDef::box_half(Vec3::splat(0.25)) } else { ShapeDef::sphere(0.3) };
        let def = BodyDef::dynamic().with_position(position).with_shape(shape.with_density(200.0));
        scene.add(format!("load {i}"), def);
    }
    Ok(scene)
}
