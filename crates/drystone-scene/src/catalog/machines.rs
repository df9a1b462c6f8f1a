//! Bodies on joints of six axes: a mattress, a vehicle, people.

use drystone::joint::{
    Hinge, JointAxis, JointCone, JointDrive, JointMotion, JointSpring, Pulley, SixDof, Slider,
};
use drystone::math::Mat3;
use drystone::{Axis, BodyDef, Filter, JointKind, Pose, Quat, ShapeDef, Vec3, vec3};

use super::parameters::{CatalogError, Values};
use super::parts::{Lcg, add_ground, box_at, radians, real, yaw};
use super::person::{Flesh, PERSON, Part};
use crate::scene::{Scene, SceneCoupling, SceneJoint};

/// Joins two bodies as they stand by a joint at this point with these axes [world].
fn join(
    scene: &mut Scene,
    bodies: [usize; 2],
    point: Vec3,
    frames: [Quat; 2],
    axes: impl Into<SixDof>,
) {
    let pose = |number: usize| {
        let def = &scene.bodies[number].def;
        Pose::new(def.position, def.rotation)
    };
    let ends = bodies.map(|number| (number, pose(number)));
    scene.joints.push(SceneJoint::at(ends, point, frames, axes));
}

pub(super) fn mattress(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    let (long, wide) = (values.whole("long"), values.whole("wide"));
    let (pitch, half) = (0.25, vec3(0.11, 0.1, 0.11));
    add_ground(&mut scene, 0.6);
    let place = |i: usize, count: usize| pitch * (real(i) - 0.5 * real(count - 1));
    let width = 0.5 * pitch * real(wide);
    for (side, name) in [(-1.0, "left beam"), (1.0, "right beam")] {
        let x = side * 0.4 * pitch * real(long);
        let beam = BodyDef::fixed().with_position(vec3(x, 0.4, 0.0));
        scene.add(name, beam.with_shape(ShapeDef::box_half(vec3(0.15, 0.4, width))));
    }
    // Every block gives way to its neighbors along and about all axes.
    let push = JointSpring::hertz(20.0, 0.3);
    let bend = JointSpring::hertz(values.number("bend"), 0.3);
    let spring = |law| JointAxis::driven(JointDrive::servo(0.0, law, f32::INFINITY));
    let axes = SixDof { linear: [spring(push); 3], angular: [spring(bend); 3], ..SixDof::FIXED };
    let first = scene.bodies.len();
    for i in 0..long {
        for j in 0..wide {
            let at = vec3(place(i, long), 0.9, place(j, wide));
            let mut def = box_at(half, at).with_mass(1.0);
            def.shapes[0].material.friction = 0.6;
            let this = scene.add(format!("block {i}/{j}"), def);
            debug_assert!(this == first + i * wide + j, "blocks come row by row");
            let mut hold = |other: usize, point: Vec3| {
                join(&mut scene, [other, this], point, [Quat::IDENTITY; 2], axes);
            };
            if i > 0 {
                hold(this - wide, at - vec3(0.5 * pitch, 0.0, 0.0));
            }
            if j > 0 {
                hold(this - 1, at - vec3(0.0, 0.0, 0.5 * pitch));
            }
        }
    }
    for (i, x) in [-0.5, 0.0, 0.5].into_iter().enumerate() {
        let at = vec3(x, 1.8 + 0.8 * real(i), 0.1 * real(i));
        let mut shape = ShapeDef::sphere(0.2);
        shape.material.rolling_resistance = 0.1;
        let ball = BodyDef::dynamic().with_position(at).with_shape(shape);
        scene.add(format!("ball {i}"), ball.with_mass(8.0));
    }
    Ok(scene)
}

/// Radius of a wheel [m], and how far the axles are from the middle, along and across.
const WHEEL: f32 = 0.35;
const AXLE: f32 = 1.3;
const TRACK: f32 = 0.85;

pub(super) fn vehicle(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    add_ground(&mut scene, 0.9);
    for i in 0..6 {
        let side = if i % 2 == 0 { 0.9 } else { -0.9 };
        let bump = ShapeDef::box_half(vec3(0.3, 0.1, 0.8)).with_friction(0.9);
        let tilt = Quat::from_axis_angle(Vec3::Z, radians(8.0));
        let at = vec3(8.0 + 3.0 * real(i), -0.03, side);
        scene.add(
            format!("bump {i}"),
            BodyDef::fixed().with_position(at).with_rotation(tilt).with_shape(bump),
        );
    }
    for row in 0..4 {
        for column in 0..6 {
            let at = vec3(34.0, 0.25 + 0.5 * real(row), 0.52 * (real(column) - 2.5));
            let box_def = box_at(Vec3::splat(0.25), at).with_mass(8.0);
            scene.add(format!("box {row}/{column}"), box_def);
        }
    }
    let (mass, wheel_mass) = (1000.0, 20.0);
    let body = box_at(vec3(2.0, 0.3, 0.7), vec3(0.0, 0.75, 0.0)).with_mass(mass);
    let chassis = scene.add("chassis", body);
    // A quarter of the chassis on each spring, at rest where the wheels are now.
    let omega = core::f32::consts::TAU * 1.5;
    let load = 0.25 * mass;
    let spring = JointSpring::new(load * omega * omega, 2.0 * 0.5 * load * omega);
    let sag = 9.81 / (omega * omega);
    let suspension =
        JointAxis::limited(-0.15, 0.15).with_drive(JointDrive::servo(-sag, spring, f32::INFINITY));
    // x of a wheel's frame is its axle, to the right of the way; y is up.
    let axle = yaw(radians(-90.0));
    let speed = values.number("speed") / WHEEL;
    let motor = JointAxis::driven(JointDrive::motor(-speed, 250.0));
    let axes = Hinge::of(motor).six_dof().with_axis(Axis::Y, suspension);
    for (x, way) in [(AXLE, "front"), (-AXLE, "rear")] {
        for (z, side) in [(-TRACK, "left"), (TRACK, "right")] {
            let at = vec3(x, WHEEL, z);
            let tire = ShapeDef::cylinder(0.12, WHEEL).with_friction(0.9);
            let def = BodyDef::dynamic()
                .with_position(at)
                .with_rotation(Quat::from_axis_angle(Vec3::X, radians(90.0)))
                .with_shape(tire)
                .with_mass(wheel_mass);
            let wheel = scene.add(format!("{way} {side} wheel"), def);
            join(&mut scene, [chassis, wheel], at, [axle; 2], axes);
        }
    }
    Ok(scene)
}

/// How thick wheels are, half [m].
const THICK: f32 = 0.05;

/// Wheels of growing size in a row, each driven by the one before, and a rack that the last one
/// lifts.
pub(super) fn gears(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    let (count, load) = (values.whole("n"), values.number("load"));
    let base = scene.add("frame", BodyDef::fixed());
    let along = Quat::from_arc(Vec3::X, Vec3::Z);
    let radius = |i: usize| 0.2 + 0.1 * real(i % 3);
    let mut x = 0.0;
    let pass = |def: BodyDef| BodyDef {
        shapes: def
            .shapes
            .into_iter()
            // Teeth are not shapes here: the wheels hold each other by couplings alone.
            .map(|s| s.with_filter(Filter::layers(1, 0)))
            .collect(),
        ..def
    };
    for i in 0..count {
        let at = vec3(x, 2.0, 0.0);
        let wheel =
            BodyDef::dynamic()
                .with_position(at)
                .with_shape(ShapeDef::cylinder(THICK, radius(i)).with_pose(Pose::new(
                    Vec3::ZERO,
                    Quat::from_axis_angle(Vec3::X, radians(90.0)),
                )))
                .with_shape(ShapeDef::box_half(vec3(0.04, 0.04, 1.5 * THICK)).with_position(vec3(
                    0.7 * radius(i),
                    0.0,
                    0.0,
                )))
                .with_mass(5.0);
        let wheel = scene.add(format!("wheel {i}"), pass(wheel));
        let axis = if i == 0 {
            JointAxis::driven(JointDrive::motor(values.number("speed"), 200.0))
        } else {
            JointAxis::FREE
        };
        join(&mut scene, [base, wheel], at, [along; 2], Hinge::of(axis));
        if i > 0 {
            scene.couplings.push(SceneCoupling {
                joint_a: i - 1,
                axis_a: Axis::TurnX,
                joint_b: i,
                axis_b: Axis::TurnX,
                ratio: -radius(i - 1) / radius(i),
                offset: 0.0,
            });
        }
        x += radius(i) + radius(i + 1);
    }
    // Beside the last wheel, which turns one way or the other: down is where it begins.
    let last = count - 1;
    let side = if last.is_multiple_of(2) { 1.0 } else { -1.0 };
    let end = scene.bodies[last + 1].def.position;
    let at = end + vec3(radius(last) + 0.05, 0.0, 0.0);
    let rack = box_at(vec3(0.05, 1.0, THICK), at).with_mass(load);
    let rack = scene.add("rack", pass(rack));
    let up = Quat::from_arc(Vec3::X, Vec3::Y);
    join(&mut scene, [base, rack], at, [up; 2], Slider::new());
    scene.couplings.push(SceneCoupling {
        joint_a: last,
        axis_a: Axis::TurnX,
        joint_b: count,
        axis_b: Axis::X,
        ratio: radius(last),
        offset: 0.0,
    });
    if let JointKind::SixDof(first) = &mut scene.joints[0].kind
        && let Some(drive) = &mut first.angular[0].drive
    {
        drive.velocity *= side;
    }
    Ok(scene)
}

/// Two boxes on a rope over two points; the second may hang on several strands.
pub(super) fn pulley(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    add_ground(&mut scene, 0.6);
    let (half, high) = (0.2, 6.0);
    let masses = [values.number("mass"), values.number("load")];
    let ratio = values.number("strands");
    let points = [vec3(-1.0, high, 0.0), vec3(1.0, high, 0.0)];
    for (point, side) in points.iter().zip(["left", "right"]) {
        let axle = ShapeDef::cylinder(0.1, 0.15).with_pose(Pose::new(
            vec3(0.0, 0.2, 0.0),
            Quat::from_axis_angle(Vec3::X, radians(90.0)),
        ));
        let wheel = BodyDef::fixed().with_position(*point).with_shape(axle);
        scene.add(format!("{side} wheel"), wheel);
    }
    let heights = [3.0, half];
    let bodies = [0, 1].map(|i| {
        let at = vec3(points[i].x, heights[i], 0.0);
        let name = ["weight", "load"][i];
        scene.add(name, box_at(Vec3::splat(half), at).with_mass(masses[i]))
    });
    let reach = heights.map(|y| high - y - half);
    let rope = Pulley { ratio, ..Pulley::rope(points, reach[0] + ratio * reach[1]) };
    let anchor = vec3(0.0, half, 0.0);
    scene.joints.push(SceneJoint {
        collide_connected: true,
        ..SceneJoint::new((bodies[0], anchor), (bodies[1], anchor), rope)
    });
    Ok(scene)
}

/// Layers for the trunks of people, so that the overlapping parts of one person do not collide.
/// Every 60th person shares a layer.
const TRUNKS: usize = 60;

fn is_trunk(part: &Part) -> bool {
    ["hips", "spine", "clavicle", "neck", "head", "arm 0"].iter().any(|n| part.name.contains(n))
}

/// Springs that hold people in the pose of their table, beside the friction of their sockets. A
/// spring about each axis of a joint pushes by at most `strength` [N m], from a tenth of a radian
/// on. (Springs by frequency would be too weak at hands and feet: these are light, and the whole
/// person may lie on them.)
fn muscles(strength: f32) -> Option<JointDrive> {
    let stiffness = 10.0 * strength;
    let spring = JointSpring::new(stiffness, 0.05 * stiffness);
    (strength > 0.0).then(|| JointDrive::servo(0.0, spring, strength))
}

/// Adds a person who stood at the origin, moved there by `pose`; limp without muscles.
fn add_person(scene: &mut Scene, number: usize, pose: &Pose, muscles: Option<JointDrive>) {
    let first = scene.bodies.len();
    let layer = 2_u64 << (number % TRUNKS);
    for part in &PERSON {
        let at = Pose::new(part.position, Quat::from(part.rotation).normalized());
        let place = Pose::new(pose.point(at.position), (pose.rotation * at.rotation).normalized());
        let mut def =
            BodyDef::dynamic().with_position(place.position).with_rotation(place.rotation);
        def.linear_damping = 0.05;
        def.angular_damping = 0.05;
        for (position, rotation, flesh) in part.flesh {
            let shape = match flesh {
                Flesh::Capsule(half, radius) => ShapeDef::capsule(*half, *radius),
                Flesh::Box(half) => ShapeDef::box_half(*half),
            };
            let pose = Pose::new(*position, Quat::from(*rotation).normalized());
            let own = if is_trunk(part) {
                Filter { layers: layer, exclude: layer, ..Filter::default() }
            } else {
                Filter::default()
            };
            def.shapes.push(ShapeDef { pose, ..shape }.with_friction(0.5).with_filter(own));
        }
        let this = scene.add(format!("{number} {}", part.name), def);
        let Some(socket) = &part.socket else { continue };
        let frames = socket.axes.map(|[twist, plane]| {
            let x = pose.direction(Vec3::from(twist)).normalize_or(Vec3::X);
            let z = pose.direction(Vec3::from(plane));
            let z = (z - x * z.dot(x)).normalize_or(Vec3::Z);
            Quat::from_mat3(Mat3 { x, y: z.cross(x), z }).normalized()
        });
        let axis = |motion| JointAxis { motion, drive: muscles, friction: socket.friction };
        let loose = axis(JointMotion::Free);
        let [min, max] = socket.twist;
        let twist = axis(JointMotion::Limited { min, max, spring: None });
        let axes = SixDof {
            angular: [twist, loose, loose],
            cone: Some(JointCone { swing: socket.swing, spring: None }),
            ..SixDof::FIXED
        };
        let point = pose.point(Vec3::from(socket.at));
        join(scene, [first + socket.parent, this], point, frames, axes);
    }
}

pub(super) fn ragdolls(mut scene: Scene, values: &Values) -> Result<Scene, CatalogError> {
    add_ground(&mut scene, 0.6);
    let mut random = Lcg::new(7);
    let muscles = muscles(values.number("muscles"));
    for i in 0..values.whole("n") {
        // Four by four a layer, every one turned otherwise.
        let (x, z) = (real(i % 4) - 1.5, real(i / 4 % 4) - 1.5);
        let at = vec3(1.2 * x, 1.6 + 1.4 * real(i / 16), 1.2 * z);
        let turn = random.rotation();
        let middle = turn.rotate(vec3(0.0, 0.93, 0.0));
        add_person(&mut scene, i, &Pose::new(at - middle, turn), muscles);
    }
    Ok(scene)
}
