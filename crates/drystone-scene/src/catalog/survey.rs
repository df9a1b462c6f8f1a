//! The examples of the surveys of impulse methods: a book, a tilted table, balls that roll and
//! bounce, a tumbling box, an hourglass [Schmidl04], rings on pegs [Guendelman03].

use drystone::math::trig;
use drystone::{BodyDef, Material, Pose, Quat, ShapeDef, Vec3, vec3};

use super::parameters::{CatalogError, Values};
use super::parts::{Lcg, add_ground, add_ground_box, cos_sin, grid_mesh, radians, real};
use crate::scene::Scene;

pub(super) fn book(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    scene.seconds = 5.0;
    scene.config.sleep.enabled = false;
    add_ground(&mut scene, 0.6);
    let table = ShapeDef::box_half(vec3(0.6, 0.02, 0.4));
    scene.add("table", BodyDef::fixed().with_position(vec3(0.0, 0.73, 0.0)).with_shape(table));
    // 20 by 3 by 15 cm, over the edge at x = 0.6.
    let half = vec3(0.1, 0.015, 0.075);
    let x = 0.6 + 2.0 * half.x * (values.number("overhang") - 0.5);
    let cover = ShapeDef::box_half(half).with_density(700.0);
    let book = BodyDef::dynamic().with_position(vec3(x, 0.75 + half.y, 0.0)).with_shape(cover);
    scene.add("book", book);
    Ok(scene)
}

pub(super) fn tilted_table(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    scene.seconds = 3.0;
    scene.config.sleep.enabled = false;
    let turn = Quat::from_axis_angle(Vec3::Z, trig::atan2(values.number("tan"), 1.0));
    let (mu, height) = (values.number("mu"), values.number("height"));
    let table = ShapeDef::box_half(vec3(30.0, 1.0, 5.0)).with_friction(mu);
    let below = turn.rotate(vec3(0.0, -1.0, 0.0));
    let def = BodyDef::fixed().with_position(below).with_rotation(turn).with_shape(table);
    scene.add("table", def);
    let shape = ShapeDef::box_half(vec3(0.5, 0.5 * height, 0.5)).with_friction(mu);
    let above = turn.rotate(vec3(0.0, 0.5 * height, 0.0));
    let def = BodyDef::dynamic().with_position(above).with_rotation(turn).with_shape(shape);
    scene.add("box", def);
    Ok(scene)
}

pub(super) fn ball_roll(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    scene.seconds = 5.0;
    scene.config.sleep.enabled = false;
    let mu = values.number("mu");
    add_ground(&mut scene, mu);
    let ball = ShapeDef::sphere(0.5).with_friction(mu);
    let def = BodyDef::dynamic().with_position(vec3(0.0, 0.5, 0.0)).with_linear_velocity(vec3(
        values.number("speed"),
        0.0,
        0.0,
    ));
    scene.add("ball", def.with_shape(ball));
    Ok(scene)
}

pub(super) fn super_ball(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    scene.seconds = 5.0;
    scene.config.sleep.enabled = false;
    let rubber = Material {
        friction: 2.0,
        restitution: values.number("restitution"),
        ..Material::default()
    };
    let ground = ShapeDef::half_space(Vec3::Y, 0.0).with_material(rubber);
    scene.add("ground", BodyDef::fixed().with_shape(ground));
    let def = BodyDef::dynamic()
        .with_position(vec3(0.0, 1.5, 0.0))
        .with_linear_velocity(vec3(values.number("speed"), 0.0, 0.0))
        .with_angular_velocity(vec3(0.0, 0.0, values.number("spin")));
    scene.add("ball", def.with_shape(ShapeDef::sphere(0.1).with_material(rubber)));
    Ok(scene)
}

pub(super) fn tumble(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    /// The hill falls from x = 0 to this [m].
    const LENGTH: f32 = 40.0;
    scene.seconds = 12.0;
    let hill = grid_mesh((80, 20), |i, j| {
        let (x, z) = (0.75 * i as f32 - 10.0, j as f32 - 10.0);
        let (_, wave) = cos_sin(1.3 * x);
        let (_, across) = cos_sin(0.7 * z + 0.4 * x);
        let down = x.clamp(0.0, LENGTH);
        vec3(x, -0.5 * down + 0.15 * wave + 0.15 * across, z)
    })?;
    let stony = Material { friction: 0.7, restitution: 0.3, ..Material::default() };
    let hill = ShapeDef::new(hill).with_material(stony);
    scene.add("hill", BodyDef::fixed().with_shape(hill));
    let mut random = Lcg::new(7);
    for i in 0..values.whole("boxes") {
        let half = vec3(0.5, 0.35, 0.25);
        let at = vec3(1.0 + 1.5 * real(i % 4), 2.0 + real(i / 4), random.between(-4.0, 4.0));
        let def = BodyDef::dynamic()
            .with_position(at)
            .with_rotation(random.rotation())
            .with_linear_velocity(vec3(2.0, 0.0, 0.0))
            .with_shape(ShapeDef::box_half(half).with_material(stony));
        scene.add(format!("box {i}"), def);
    }
    Ok(scene)
}

/// Walls of a square shaft of this half width inside from `low` to `high` [m].
fn add_shaft(scene: &mut Scene, name: &str, inside: f32, (low, high): (f32, f32)) {
    const HALF: f32 = 0.25;
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    for (side, x, z) in
        [("left", -1.0, 0.0), ("right", 1.0, 0.0), ("back", 0.0, -1.0), ("front", 0.0, 1.0)]
    {
        let off = inside + HALF;
        let wide = |along: f32| if along == 0.0 { inside + 2.0 * HALF } else { HALF };
        let wall = ShapeDef::box_half(vec3(wide(x), half, wide(z))).with_friction(0.3);
        let at = vec3(off * x, middle, off * z);
        scene.add(format!("{name} {side}"), BodyDef::fixed().with_position(at).with_shape(wall));
    }
}

pub(super) fn hourglass(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    /// Edge of a cube, half widths of the glass and of its neck, height of the neck, half thickness
    /// of the funnel [m].
    const EDGE: f32 = 0.25;
    const GLASS: f32 = 1.75;
    const NECK: f32 = 0.6;
    const LOW: f32 = 3.4;
    const HALF: f32 = 0.2;
    scene.seconds = 30.0;
    add_ground_box(&mut scene, 6.0, 6.0);
    let n = values.whole("cubes");
    let layers = n.div_ceil(121);
    let top = LOW + (GLASS - NECK);
    add_shaft(&mut scene, "lower", GLASS, (0.0, LOW));
    add_shaft(&mut scene, "upper", GLASS, (LOW, top + 0.3 * real(layers) + 1.0));
    // Four planks that lean by 45 degrees from the neck to the glass.
    let length = (GLASS - NECK) * core::f32::consts::SQRT_2;
    let normal = core::f32::consts::FRAC_1_SQRT_2;
    for (i, side) in (0_u8..).zip(["right", "back", "left", "front"]) {
        let around = Quat::from_axis_angle(Vec3::Y, radians(90.0 * f32::from(i)));
        let lean = Quat::from_axis_angle(Vec3::Z, radians(45.0));
        let middle = vec3(0.5 * (GLASS + NECK), LOW + 0.5 * (GLASS - NECK), 0.0);
        let below = vec3(normal, -normal, 0.0) * HALF;
        let plank = ShapeDef::box_half(vec3(0.5 * length, HALF, GLASS)).with_friction(0.3);
        let def = BodyDef::fixed()
            .with_position(around.rotate(middle + below))
            .with_rotation(around * lean)
            .with_shape(plank);
        scene.add(format!("funnel {side}"), def);
    }
    for i in 0..n {
        let (x, z, y) = (i % 11, i / 11 % 11, i / 121);
        let at = vec3(0.29 * (real(x) - 5.0), top + 0.3 * (real(y) + 0.5), 0.29 * (real(z) - 5.0));
        let cube = ShapeDef::box_half(Vec3::splat(0.5 * EDGE)).with_friction(0.3);
        scene.add(format!("cube {i}"), BodyDef::dynamic().with_position(at).with_shape(cube));
    }
    Ok(scene)
}

pub(super) fn rings(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    /// Pegs along a side, their distance, radius and height; radii of a ring and of its tube [m].
    const SIDE: usize = 5;
    const PITCH: f32 = 1.6;
    const PEG: f32 = 0.1;
    const TALL: f32 = 2.5;
    const RING: f32 = 0.45;
    const TUBE: f32 = 0.1;
    /// Straight pieces of a ring.
    const PIECES: u8 = 8;
    scene.seconds = 15.0;
    add_ground_box(&mut scene, 10.0, 10.0);
    let place = |i: usize| PITCH * (real(i) - 0.5 * real(SIDE - 1));
    for i in 0..SIDE * SIDE {
        let peg = ShapeDef::capsule(0.5 * TALL, PEG).with_friction(0.3);
        let at = vec3(place(i % SIDE), 0.5 * TALL, place(i / SIDE));
        scene.add(format!("peg {i}"), BodyDef::fixed().with_position(at).with_shape(peg));
    }
    let mut random = Lcg::new(3);
    for i in 0..values.whole("rings") {
        let peg = i % (SIDE * SIDE);
        let near = |random: &mut Lcg| random.between(-0.3, 0.3);
        let at = vec3(
            place(peg % SIDE) + near(&mut random),
            TALL + 1.0 + 0.6 * real(i / (SIDE * SIDE)),
            place(peg / SIDE) + near(&mut random),
        );
        let tilt = Quat::from_axis_angle(random.direction(), random.between(0.0, 0.4));
        let mut def = BodyDef::dynamic().with_position(at).with_rotation(tilt);
        for piece in 0..PIECES {
            let angle = 2.0 * core::f32::consts::PI * f32::from(piece) / f32::from(PIECES);
            let (c, s) = cos_sin(angle);
            // A capsule lies along y: along the ring it is turned to (-s, 0, c).
            let pose =
                Pose::new(vec3(RING * c, 0.0, RING * s), Quat::from_arc(Vec3::Y, vec3(-s, 0.0, c)));
            // Half a side of the regular polygon around the circle.
            let half = RING * 0.414;
            def = def.with_shape(ShapeDef::capsule(half, TUBE).with_friction(0.3).with_pose(pose));
        }
        scene.add(format!("ring {i}"), def);
    }
    Ok(scene)
}
