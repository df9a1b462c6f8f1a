//! Things built from blocks: they stand, or fall in an interesting way.

use core::f32::consts::PI;

use drystone::math::trig;
use drystone::{BodyDef, Quat, ShapeDef, Vec3, vec3};

use super::parameters::{CatalogError, Values};
use super::parts::{
    add_ground, add_ground_box, box_at, cos_sin, gravity_10, hull, radians, real, yaw,
};
use crate::scene::Scene;

/// Half extents of a brick of the walls [m].
const BRICK: Vec3 = vec3(0.25, 0.1, 0.125);
/// Air between two bricks of a row [m].
const JOINT_GAP: f32 = 0.002;

/// Adds a running-bond wall in the xy plane, centered on x = 0; each second row begins and ends
/// with half a brick.
pub(super) fn add_wall(scene: &mut Scene, width: usize, height: usize) {
    let pitch = 2.0 * BRICK.x + JOINT_GAP;
    let left = -0.5 * pitch * real(width);
    for row in 0..height {
        let y = (2.0 * real(row) + 1.0) * BRICK.y;
        let shifted = row % 2 == 1;
        for i in 0..width + usize::from(shifted) {
            // Its left and right end in half pitches from the left end of the wall.
            let from = if shifted { (2 * i).saturating_sub(1) } else { 2 * i };
            let to = if shifted { (2 * i + 1).min(2 * width) } else { 2 * i + 2 };
            let half_length = 0.5 * (0.5 * pitch * real(to - from) - JOINT_GAP);
            let x = left + 0.25 * pitch * real(from + to);
            let half = vec3(half_length, BRICK.y, BRICK.z);
            scene.add(format!("brick {row}/{i}"), box_at(half, vec3(x, y, 0.0)));
        }
    }
}

pub(super) fn wall(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    let (width, height) = (values.whole("width"), values.whole("height"));
    scene.seconds = 20.0;
    add_ground(&mut scene, 0.6);
    add_wall(&mut scene, width, height);
    if values.whole("ball") == 1 {
        // Thrown so that it meets the middle of the wall after a second, at the height it came
        // from.
        scene.seconds = 6.0;
        let y = (real(height) * BRICK.y).max(0.6);
        let ball = BodyDef::dynamic()
            .with_position(vec3(0.0, y, 12.0))
            .with_linear_velocity(vec3(0.0, 0.5 * 9.81, -12.0))
            .with_shape(ShapeDef::sphere(0.4).with_density(3000.0));
        scene.add("ball", ball);
    }
    Ok(scene)
}

pub(super) fn tower(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    let (layers, bricks) = (values.whole("layers"), values.whole("bricks"));
    scene.seconds = 20.0;
    add_ground(&mut scene, 0.6);
    // The bricks of a ring almost touch at their inner edges.
    let half = vec3(0.3, 0.125, 0.2);
    let inner = 1.02 * half.x / trig::tan(PI / real(bricks));
    for layer in 0..layers {
        let y = (2.0 * real(layer) + 1.0) * half.y;
        for i in 0..bricks {
            let turned = real(i) + if layer % 2 == 1 { 0.5 } else { 0.0 };
            let turn = yaw(2.0 * PI * turned / real(bricks));
            let position = turn.rotate(vec3(0.0, y, inner + half.z));
            scene.add(format!("brick {layer}/{i}"), box_at(half, position).with_rotation(turn));
        }
    }
    Ok(scene)
}

pub(super) fn jenga(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    let pulled = values.whole("pulled") == 1;
    scene.seconds = 20.0;
    add_ground(&mut scene, 0.6);
    let (long, half_height, wide) = (0.375, 0.075, 0.124);
    for layer in 0..values.whole("layers") {
        let y = (2.0 * real(layer) + 1.0) * half_height;
        for i in 0..3 {
            if pulled && i == 1 && layer % 2 == 1 {
                continue;
            }
            let across = 0.25 * (real(i) - 1.0);
            let (half, position) = if layer % 2 == 0 {
                (vec3(long, half_height, wide), vec3(0.0, y, across))
            } else {
                (vec3(wide, half_height, long), vec3(across, y, 0.0))
            };
            scene.add(format!("block {layer}/{i}"), box_at(half, position));
        }
    }
    Ok(scene)
}

pub(super) fn domino(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    let n = values.whole("n");
    scene.seconds = (2.0 + 0.1 * real(n)).min(120.0);
    add_ground(&mut scene, 0.6);
    let half = vec3(0.03, 0.24, 0.12);
    let (spacing, between_turns) = (0.2, 0.8);
    let mut angle: f32 = 0.0;
    for i in 0..n {
        let radius = 1.5 + between_turns / (2.0 * PI) * angle;
        let (c, s) = cos_sin(angle);
        // x of the domino is the way the run goes: at right angles to the radius.
        let turn = yaw(-angle - 0.5 * PI);
        let forward = turn.rotate(Vec3::X);
        let mut def = box_at(half, vec3(radius * c, half.y, radius * s)).with_rotation(turn);
        if i == 0 {
            // Turning about its lower front edge, fast enough to pass over it twice.
            let spin = forward.cross(Vec3::Y) * -2.0;
            let arm = vec3(0.0, half.y, 0.0) - forward * half.x;
            def = def.with_angular_velocity(spin).with_linear_velocity(spin.cross(arm));
        }
        scene.add(format!("domino {i}"), def);
        angle += spacing / radius;
    }
    Ok(scene)
}

pub(super) fn arch(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    let stones = values.whole("stones");
    let (inner, outer, depth) = (2.2, 2.8, 0.5);
    scene.seconds = 20.0;
    add_ground(&mut scene, 0.7);
    // One stone, its middle at the origin and its radial direction along x.
    let middle = 0.5 * (inner + outer);
    let (c, s) = cos_sin(0.5 * PI / real(stones));
    let mut points = Vec::new();
    for z in [-0.5 * depth, 0.5 * depth] {
        for r in [inner, outer] {
            points.push(vec3(r * c - middle, r * s, z));
            points.push(vec3(r * c - middle, -r * s, z));
        }
    }
    let stone = BodyDef::dynamic().with_shape(ShapeDef::new(hull(&points)?).with_friction(0.7));
    for i in 0..stones {
        let angle = PI * (real(i) + 0.5) / real(stones);
        let (c, s) = cos_sin(angle);
        let def = stone
            .clone()
            .with_position(vec3(middle * c, middle * s, 0.0))
            .with_rotation(Quat::from_axis_angle(Vec3::Z, angle));
        scene.add(format!("stone {i}"), def);
    }
    Ok(scene)
}

pub(super) fn card_house(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    let (levels, w) = (values.whole("levels"), 0.5 * values.number("thickness"));
    gravity_10(&mut scene);
    scene.seconds = 20.0;
    scene.config.sleep.enabled = false;
    add_ground_box(&mut scene, 20.0, 20.0);
    let lean = radians(25.0);
    let (c, s) = cos_sin(lean);
    let (tall, deep) = (0.2, 0.1);
    let half_distance = w * c + tall * s;
    let half_rise = tall * c + w * s;
    let card = BodyDef::dynamic().with_shape(ShapeDef::box_half(vec3(w, tall, deep)));
    let flat = BodyDef::dynamic().with_shape(ShapeDef::box_half(vec3(0.199, w, deep)));
    let mut y = half_rise;
    for level in 0..levels {
        let pairs = levels - level;
        let pair_x = |i: usize| 0.4 * (real(i) - 0.5 * real(pairs - 1));
        for i in 0..pairs {
            for (side, sign) in [("left", 1.0), ("right", -1.0)] {
                let def = card
                    .clone()
                    .with_position(vec3(pair_x(i) - sign * half_distance, y, 0.0))
                    .with_rotation(Quat::from_axis_angle(Vec3::Z, -sign * lean));
                scene.add(format!("{side} card {level}/{i}"), def);
            }
        }
        for i in 1..pairs {
            let x = 0.5 * (pair_x(i - 1) + pair_x(i));
            let def = flat.clone().with_position(vec3(x, y + half_rise + w, 0.0));
            scene.add(format!("flat card {level}/{i}"), def);
        }
        y += 2.0 * half_rise + 2.0 * w;
    }
    for body in &mut scene.bodies {
        for shape in &mut body.def.shapes {
            shape.material.friction = 0.7;
        }
    }
    Ok(scene)
}

pub(super) fn plank_tower(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    gravity_10(&mut scene);
    scene.seconds = 20.0;
    scene.config.sleep.enabled = false;
    add_ground_box(&mut scene, 20.0, 20.0);
    for layer in 0..values.whole("layers") {
        let y = 0.05 + 0.1 * real(layer);
        for (side, across) in [("a", -0.4), ("b", 0.4)] {
            let (half, position) = if layer % 2 == 0 {
                (vec3(0.1, 0.05, 0.5), vec3(across, y, 0.0))
            } else {
                (vec3(0.5, 0.05, 0.1), vec3(0.0, y, across))
            };
            scene.add(format!("plank {layer}/{side}"), box_at(half, position));
        }
    }
    Ok(scene)
}

pub(super) fn falling_tower(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    scene.seconds = 8.0;
    add_ground(&mut scene, 0.6);
    for i in 0..values.whole("n") {
        let position = vec3(values.number("overhang") * real(i), 0.5 + real(i), 0.0);
        scene.add(format!("cube {i}"), box_at(Vec3::splat(0.5), position));
    }
    Ok(scene)
}

pub(super) fn tower_minus_base(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    scene.seconds = 8.0;
    add_ground(&mut scene, 0.6);
    for layer in 0..values.whole("layers") {
        let y = 0.25 + 0.5 * real(layer);
        for (side, across) in [("a", -0.26), ("b", 0.26)] {
            if layer == 0 && across < 0.0 {
                continue;
            }
            let (half, position) = if layer % 2 == 0 {
                (vec3(0.25, 0.25, 0.5), vec3(across, y, 0.0))
            } else {
                (vec3(0.5, 0.25, 0.25), vec3(0.0, y, across))
            };
            scene.add(format!("brick {layer}/{side}"), box_at(half, position));
        }
    }
    Ok(scene)
}
