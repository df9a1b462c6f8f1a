//! Particles: rope, cloth, dust.

use drystone::particle::{ClothDef, ParticleDef, RopeDef};
use drystone::{BodyDef, Shape, ShapeDef, Vec3, vec3};

use super::parameters::{CatalogError, Values};
use super::parts::{Lcg, add_ground, box_at, real};
use crate::scene::{Scene, SceneHold, SceneStrand, StrandDef};

/// Mass of a meter of rope [kg].
const ROPE_MASS: f32 = 0.5;

pub(super) fn rope(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    let (links, length) = (values.whole("links"), values.number("length"));
    let ball_radius = 0.1;
    let top = vec3(0.0, length + 1.0, 0.0);
    add_ground(&mut scene, 0.6);
    // The rope falls against a bar, and the rest of it swings round the bar.
    let bar = ShapeDef::capsule(0.5, 0.05);
    let across = drystone::Quat::from_axis_angle(Vec3::X, 0.5 * core::f32::consts::PI);
    let bar_at = top + vec3(0.02, -0.5 * length, 0.0);
    scene.add("bar", BodyDef::fixed().with_position(bar_at).with_rotation(across).with_shape(bar));
    let end = top + vec3(length, 0.0, 0.0);
    let ball = BodyDef::dynamic()
        .with_position(end + vec3(ball_radius, 0.0, 0.0))
        .with_mass(values.number("ball"))
        .with_shape(ShapeDef::sphere(ball_radius));
    let ball = scene.add("ball", ball);
    let mut def = RopeDef::between(top, end, links);
    def.mass = ROPE_MASS * length;
    def.pinned = [true, false];
    let hold = SceneHold { particle: links, body: ball, point: vec3(-ball_radius, 0.0, 0.0) };
    let strand = SceneStrand::new("rope", StrandDef::Rope(def));
    scene.strands.push(SceneStrand { holds: vec![hold], ..strand });
    Ok(scene)
}

/// Side of the cloth [m].
const CLOTH: f32 = 3.0;

pub(super) fn cloth(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    let (n, hangs) = (values.whole("n"), values.whole("hang") == 1);
    let tear = values.number("tear");
    add_ground(&mut scene, 0.6);
    let half = 0.5 * CLOTH;
    let (corner, sides, pins) = if hangs {
        // By its upper corners; a ball is thrown into it.
        let corner = vec3(-half, CLOTH + 1.0, 0.0);
        let ball = BodyDef::dynamic()
            .with_position(vec3(0.0, 2.5, 3.0))
            .with_linear_velocity(vec3(0.0, 2.0, -6.0))
            .with_mass(1.0)
            .with_shape(ShapeDef::sphere(0.3));
        scene.add("ball", ball);
        (corner, [Vec3::X * CLOTH, Vec3::Y * -CLOTH], vec![0, n])
    } else {
        let ball = BodyDef::fixed().with_position(vec3(0.0, 1.2, 0.0));
        scene.add("ball", ball.with_shape(ShapeDef::sphere(0.8)));
        (vec3(-half, 2.3, -half), [Vec3::X * CLOTH, Vec3::Z * CLOTH], Vec::new())
    };
    let mut def = ClothDef::new(corner, sides, [n, n]);
    def.tear_force = (tear > 0.0).then_some(tear);
    let strand = SceneStrand::new("cloth", StrandDef::Cloth(def));
    scene.strands.push(SceneStrand { pins, ..strand });
    Ok(scene)
}

/// Points at random in a box [m], each with this radius [m].
fn add_cloud(scene: &mut Scene, n: usize, (low, high): (Vec3, Vec3), radius: f32) {
    let mut random = Lcg::new(11);
    let mut points = Vec::with_capacity(n);
    for _ in 0..n {
        let x = random.between(low.x, high.x);
        let y = random.between(low.y, high.y);
        points.push(vec3(x, y, random.between(low.z, high.z)));
    }
    let def = ParticleDef { radius, mass: 1.0e-3, ..ParticleDef::default() };
    scene.strands.push(SceneStrand::new("dust", StrandDef::Cloud(points, def)));
}

pub(super) fn dust(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    add_ground(&mut scene, 0.5);
    let shapes = [
        ShapeDef::sphere(1.5),
        ShapeDef::box_half(vec3(1.2, 0.8, 1.2)),
        ShapeDef::cylinder(0.8, 1.2),
        ShapeDef::new(Shape::cone(1.0, 1.3)),
        ShapeDef::capsule(0.8, 0.7),
    ];
    for (i, shape) in shapes.into_iter().enumerate() {
        let x = 3.2 * (real(i) - 2.0);
        let place = BodyDef::fixed().with_position(vec3(x, 0.9, 0.0));
        scene.add(format!("stone {i}"), place.with_shape(shape));
    }
    let (low, high) = (vec3(-8.0, 3.0, -3.0), vec3(8.0, 6.0, 3.0));
    add_cloud(&mut scene, values.whole("n"), (low, high), 0.01);
    scene.seconds = 5.0;
    Ok(scene)
}

pub(super) fn hail(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    let (n, bodies) = (values.whole("n"), values.whole("bodies"));
    add_ground(&mut scene, 0.6);
    let side = (1..).find(|k| k * k * 4 >= bodies).unwrap_or(1);
    let half = 0.35 * real(side);
    for i in 0..bodies {
        let (layer, place) = (i / (side * side), i % (side * side));
        let middle = 0.5 * real(side - 1);
        let at = vec3(
            0.7 * (real(place % side) - middle),
            0.25 + 0.5 * real(layer),
            0.7 * (real(place / side) - middle),
        );
        scene.add(format!("cube {i}"), box_at(Vec3::splat(0.25), at));
    }
    let (low, high) = (vec3(-half, 3.0, -half), vec3(half, 8.0, half));
    add_cloud(&mut scene, n, (low, high), 0.02);
    scene.seconds = 5.0;
    Ok(scene)
}
