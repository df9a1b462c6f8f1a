//! Box3D's benchmark of people that fall on meshes: 300 people of 14 bones, 100 cells of a floor
//! and a ring.

use core::f32::consts::TAU;
use std::sync::Arc;

use drystone::joint::{Hinge, JointAxis, JointCone, JointDrive, JointSpring, SixDof};
use drystone::{BodyDef, Filter, Material, Mesh, Pose, Quat, Shape, ShapeDef, Vec3, vec3};

use super::parameters::{CatalogError, Values};
use super::parts::{cos_sin, gravity_10, grid_mesh, radians, real};
use crate::scene::{Scene, SceneBody, SceneJoint, Script, Wave};

/// How a bone hangs on another.
#[derive(Clone, Copy, Debug)]
enum Socket {
    /// Greatest swing and twist to either side [degrees]; the twist is about this axis.
    Ball { axis: Vec3, swing: f32, twist: f32 },
    /// A hinge about this axis that bends from 0 to this angle [degrees].
    Hinge { axis: Vec3, bend: f32 },
}

/// A bone of a person who stands on the origin and looks along z, arms down: a capsule.
#[derive(Clone, Copy, Debug)]
struct Bone {
    name: &'static str,
    /// Its ends [m].
    ends: [Vec3; 2],
    /// [m]
    radius: f32,
    /// Number of the bone that it hangs on, where [m], how, and the friction there as a part of 5 N
    /// m.
    parent: usize,
    at: Vec3,
    socket: Option<Socket>,
    friction: f32,
}

const fn bone(name: &'static str, ends: [Vec3; 2], radius: f32) -> Bone {
    Bone { name, ends, radius, parent: 0, at: Vec3::ZERO, socket: None, friction: 1.0 }
}

const fn ball(bone: Bone, parent: usize, at: Vec3, axis: Vec3, swing: f32, twist: f32) -> Bone {
    Bone { parent, at, socket: Some(Socket::Ball { axis, swing, twist }), ..bone }
}

const fn hinge(bone: Bone, parent: usize, at: Vec3, axis: Vec3, bend: f32) -> Bone {
    Bone { parent, at, socket: Some(Socket::Hinge { axis, bend }), ..bone }
}

/// Ends of a bone across the body, and of one along y.
const fn wide(half: f32, y: f32) -> [Vec3; 2] {
    [vec3(-half, y, 0.0), vec3(half, y, 0.0)]
}

const fn tall(x: f32, low: f32, high: f32) -> [Vec3; 2] {
    [vec3(x, low, 0.0), vec3(x, high, 0.0)]
}

const DOWN: Vec3 = vec3(0.0, -1.0, 0.0);
const RIGHT: Vec3 = vec3(-1.0, 0.0, 0.0);

const fn at(x: f32, y: f32) -> Vec3 {
    vec3(x, y, 0.0)
}

/// Human proportions, 1.78 m.
const BONES: [Bone; 14] = [
    bone("pelvis", wide(0.07, 0.95), 0.13),
    ball(bone("spine_01", wide(0.06, 1.08), 0.12), 0, at(0.0, 1.02), Vec3::Y, 15.0, 15.0),
    ball(bone("spine_02", wide(0.06, 1.2), 0.115), 1, at(0.0, 1.14), Vec3::Y, 15.0, 15.0),
    ball(bone("spine_03", wide(0.08, 1.34), 0.13), 2, at(0.0, 1.27), Vec3::Y, 15.0, 15.0),
    Bone {
        friction: 0.8,
        ..ball(bone("neck", tall(0.0, 1.48, 1.52), 0.06), 3, at(0.0, 1.46), Vec3::Y, 25.0, 30.0)
    },
    Bone {
        friction: 0.4,
        ..ball(bone("head", tall(0.0, 1.62, 1.68), 0.1), 4, at(0.0, 1.56), Vec3::Y, 25.0, 40.0)
    },
    ball(bone("thigh_l", tall(0.1, 0.52, 0.88), 0.075), 0, at(0.1, 0.92), DOWN, 50.0, 20.0),
    hinge(bone("calf_l", tall(0.1, 0.1, 0.46), 0.055), 6, at(0.1, 0.49), Vec3::X, 120.0),
    ball(bone("thigh_r", tall(-0.1, 0.52, 0.88), 0.075), 0, at(-0.1, 0.92), DOWN, 50.0, 20.0),
    hinge(bone("calf_r", tall(-0.1, 0.1, 0.46), 0.055), 8, at(-0.1, 0.49), Vec3::X, 120.0),
    ball(bone("upper_arm_l", tall(0.25, 1.17, 1.38), 0.05), 3, at(0.23, 1.42), DOWN, 70.0, 60.0),
    hinge(bone("lower_arm_l", tall(0.25, 0.83, 1.09), 0.04), 10, at(0.25, 1.13), RIGHT, 130.0),
    ball(bone("upper_arm_r", tall(-0.25, 1.17, 1.38), 0.05), 3, at(-0.23, 1.42), DOWN, 70.0, 60.0),
    hinge(bone("lower_arm_r", tall(-0.25, 0.83, 1.09), 0.04), 12, at(-0.25, 1.13), RIGHT, 130.0),
];

/// People in layers of their own, so that thighs and lower spine of one do not collide: as many
/// later the next one shares a layer.
const LAYERS: usize = 30;

/// Adds a person, moved by `shift`, to a wave; `base`: number of its first body.
fn add_person(
    wave: &mut Wave,
    base: usize,
    number: usize,
    prefix: &str,
    shift: Vec3,
    springs: bool,
) {
    let first = base + wave.bodies.len();
    let layer = 2_u64 << (number % LAYERS);
    let mut places = Vec::with_capacity(BONES.len());
    for b in &BONES {
        let [low, high] = b.ends;
        let middle = (low + high) * 0.5;
        let along = high - low;
        let rotation = Quat::from_arc(Vec3::Y, along.normalize_or(Vec3::Y));
        let place = Pose::new(middle + shift, rotation);
        let surface = Material { friction: 0.6, rolling_resistance: 0.2, ..Material::default() };
        let own = if matches!(b.name, "spine_01" | "thigh_l" | "thigh_r") {
            Filter { layers: layer, exclude: layer, ..Filter::default() }
        } else {
            Filter::default()
        };
        let flesh = ShapeDef::capsule(0.5 * along.length(), b.radius);
        let def = BodyDef::dynamic()
            .with_position(place.position)
            .with_rotation(place.rotation)
            .with_shape(flesh.with_material(surface).with_filter(own));
        wave.bodies.push(SceneBody { name: format!("{prefix} {}", b.name), def });
        places.push(place);
    }
    for (i, b) in BONES.iter().enumerate() {
        let Some(socket) = b.socket else { continue };
        let ends = [(first + b.parent, places[b.parent]), (first + i, places[i])];
        let point = b.at + shift;
        let (axes, axis) = axes_of(socket, 5.0 * b.friction, springs);
        let frames = [Quat::from_arc(Vec3::X, axis); 2];
        wave.joints.push(SceneJoint::at(ends, point, frames, axes));
    }
}

/// The motion that a socket allows a bone, and its axis.
fn axes_of(socket: Socket, friction: f32, springs: bool) -> (SixDof, Vec3) {
    let spring = JointDrive::servo(0.0, JointSpring::hertz(1.0, 0.7), f32::INFINITY);
    let drive = springs.then_some(spring);
    let acted = |axis: JointAxis| JointAxis { drive, friction, ..axis };
    match socket {
        Socket::Ball { axis, swing, twist } => {
            let twist = acted(JointAxis::limited(-radians(twist), radians(twist)));
            let angular = [twist, acted(JointAxis::FREE), acted(JointAxis::FREE)];
            let cone = Some(JointCone { swing: [radians(swing); 2], spring: None });
            (SixDof { angular, cone, ..SixDof::FIXED }, axis)
        }
        Socket::Hinge { axis, bend } => {
            (Hinge::of(acted(JointAxis::limited(0.0, radians(bend)))).six_dof(), axis)
        }
    }
}

/// A ring about z of 16 × 16 squares.
fn ring() -> Result<Shape, CatalogError> {
    const SIDES: u32 = 16;
    let (ring, tube) = (3.75, 1.0);
    let mut vertices = Vec::new();
    let mut triangles = Vec::new();
    let number = |i: u32, j: u32| (i % SIDES) * SIDES + j % SIDES;
    for i in 0..SIDES {
        let (cu, su) = cos_sin(TAU * i as f32 / SIDES as f32);
        for j in 0..SIDES {
            let (cv, sv) = cos_sin(TAU * j as f32 / SIDES as f32);
            let r = ring + tube * cv;
            vertices.push(vec3(r * cu, r * su, tube * sv));
            triangles.push([number(i, j), number(i + 1, j), number(i + 1, j + 1)]);
            triangles.push([number(i, j), number(i + 1, j + 1), number(i, j + 1)]);
        }
    }
    Ok(Shape::Mesh(Arc::new(Mesh::new(vertices, triangles)?)))
}

pub(super) fn rain(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    const CELL: f32 = 15.0;
    const STEPS: u64 = 400;
    let (side, springs) = (values.whole("rows"), values.whole("springs") == 1);
    gravity_10(&mut scene);
    scene.seconds = STEPS as f32 / 60.0;
    let edge = -0.5 * CELL * real(side);
    let floor =
        grid_mesh((8, 8), |i, j| vec3(1.875 * (i as f32 - 4.0), 0.0, 1.875 * (j as f32 - 4.0)))?;
    let cell = BodyDef::fixed().with_shape(ShapeDef::new(floor)).with_shape(ShapeDef::new(ring()?));
    let center = |i: usize| edge + CELL * (real(i) + 0.5);
    for i in 0..side {
        for j in 0..side {
            let def = cell.clone().with_position(vec3(center(i), 0.0, center(j)));
            scene.add(format!("cell {i}/{j}"), def);
        }
    }
    let mut waves: Vec<Wave> = Vec::new();
    let mut next = scene.bodies.len();
    let per_column = side * 3 * BONES.len();
    for (count, step) in (0..STEPS).filter(|step| step & 0x2f == 0).enumerate() {
        let column = count % side;
        let removed = match count.checked_sub(side) {
            Some(old) => {
                let from = scene.bodies.len() + old * per_column;
                from..from + per_column
            }
            None => 0..0,
        };
        let mut wave = Wave { step, removed, bodies: Vec::new(), joints: Vec::new() };
        for row in 0..side {
            for k in 0..3 {
                let at = vec3(center(column) + 0.75 * real(k), 20.0, center(row));
                let name = format!("{}/{column}/{row}/{k}", count / side);
                // Told from where the pelvis is.
                let shift = at - vec3(0.0, 0.95, 0.0);
                let number = (count * side + row) * 3 + k;
                add_person(&mut wave, next, number, &name, shift, springs);
            }
        }
        next += wave.bodies.len();
        waves.push(wave);
    }
    scene.script = Script::Waves(waves);
    Ok(scene)
}
