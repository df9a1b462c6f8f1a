//! Limits of joints of six axes: arcs for turns, bars for ways, and where the joint is between them.

use core::f32::consts::TAU;

use drystone::{JointKind, JointMotion, JointRef, Pose, Quat, SixDof, Vec3, World, trig};
use drystone_render::{Color, Drawing};

const LIMIT: Color = [190, 30, 120, 255];
const PLACE: Color = [20, 130, 160, 255];

/// Parts of an arc for a whole turn.
const PARTS: f32 = 48.0;

/// Adds lines for the limits of all joints; `size` is the radius of an arc [m].
pub(crate) fn add(drawing: &mut Drawing, world: &World, size: f32) {
    for joint in world.joints() {
        let JointKind::SixDof(axes) = joint.kind() else { continue };
        if let Some(frame) = frame(world, &joint, &axes) {
            add_bars(drawing, &joint, &axes, &frame, size);
            add_arcs(drawing, world, &joint, &axes, &frame, size);
        }
    }
}

/// The joint's frame on its first body [world].
fn frame(world: &World, joint: &JointRef<'_>, axes: &SixDof) -> Option<Pose> {
    let body = world.body(joint.body_a())?;
    let frame = Pose::new(joint.anchor_a(), body.pose().rotation * axes.frame_a);
    frame.is_finite().then_some(frame)
}

/// A bar from the least to the greatest place along each axis, a tick where the second body is.
fn add_bars(drawing: &mut Drawing, joint: &JointRef<'_>, axes: &SixDof, frame: &Pose, size: f32) {
    let gap = joint.coordinates().map_or(Vec3::ZERO, |[gap, _]| gap);
    for (i, axis) in axes.linear.iter().enumerate() {
        let JointMotion::Limited { min, max, .. } = axis.motion else { continue };
        let (along, across) = (unit(i), unit((i + 1) % 3));
        // Without an end it goes on to some way beyond where it is.
        let far = 2.0 * size;
        let (low, high) = (min.max(gap[i].min(max) - far), max.min(gap[i].max(min) + far));
        let at = |x: f32, side: f32| frame.point(along * x + across * (side * size));
        drawing.add_line(at(low, 0.0), at(high, 0.0), 2.5, LIMIT);
        for end in [min, max].into_iter().filter(|end| end.is_finite()) {
            drawing.add_line(at(end, -0.35), at(end, 0.35), 2.5, LIMIT);
        }
        drawing.add_line(at(gap[i], -0.2), at(gap[i], 0.2), 3.0, PLACE);
    }
}

/// An arc from the least to the greatest angle about each axis, and the angle that is; the rim of a cone.
fn add_arcs(
    drawing: &mut Drawing,
    world: &World,
    joint: &JointRef<'_>,
    axes: &SixDof,
    frame: &Pose,
    size: f32,
) {
    let angles = joint.coordinates().map_or(Vec3::ZERO, |[_, angles]| angles);
    let free: Vec<usize> =
        (0..3).filter(|&i| axes.angular[i].motion != JointMotion::Locked).collect();
    for (i, axis) in axes.angular.iter().enumerate() {
        let JointMotion::Limited { min, max, .. } = axis.motion else { continue };
        // Of two axes the second one stays with the second body.
        let with_b = free.len() == 2 && axes.cone.is_none() && free[1] == i;
        let body_b = world.body(joint.body_b()).filter(|_| with_b);
        let own = body_b.map(|b| Pose::new(frame.position, b.pose().rotation * axes.frame_b));
        let own = own.unwrap_or(*frame);
        // Turned about x is y; turned about y or z is x, the axis that swings.
        let arm = if i == 0 { Vec3::Y } else { Vec3::X };
        // Seen from the second body what turns is the first one: the other way.
        let sign = if with_b { -1.0 } else { 1.0 };
        let at = |angle: f32| {
            let turn = Quat::from_axis_angle(unit(i), sign * angle);
            own.point(turn.rotate(arm) * size)
        };
        let angle = angles[i];
        let low = min.max(angle.min(max) - 0.5 * TAU);
        let high = max.min(angle.max(min) + 0.5 * TAU).min(low + TAU);
        add_arc(drawing, low, high, at);
        for end in [min, max].into_iter().filter(|end| end.is_finite()) {
            drawing.add_line(own.position, at(end), 1.5, LIMIT);
        }
        drawing.add_line(own.position, at(angle), 3.0, PLACE);
    }
    let Some(cone) = axes.cone else { return };
    // The swing is a rotation vector across x, and its limit an ellipse.
    let swung = |y: f32, z: f32| {
        let vector = Vec3::from([0.0, y, z]);
        frame.point(Quat::from_rotation_vector(vector).rotate(Vec3::X) * size)
    };
    let rim = |t: f32| {
        let (s, c) = trig::sin_cos(t);
        swung(c * cone.swing[0], s * cone.swing[1])
    };
    add_arc(drawing, 0.0, TAU, rim);
    for quarter in 0..4_u8 {
        drawing.add_line(frame.position, rim(0.25 * TAU * f32::from(quarter)), 1.0, LIMIT);
    }
    drawing.add_line(frame.position, swung(angles.y, angles.z), 3.0, PLACE);
}

/// A line along what `at` gives for angles from `low` to `high` [rad].
fn add_arc(drawing: &mut Drawing, low: f32, high: f32, at: impl Fn(f32) -> Vec3) {
    if !(high > low) {
        return;
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to 97")]
    let parts = ((high - low).min(2.0 * TAU) / TAU * PARTS).ceil().max(1.0) as u16;
    let angle = |part: u16| low + (high - low) * (f32::from(part) / f32::from(parts));
    for part in 0..parts {
        drawing.add_line(at(angle(part)), at(angle(part + 1)), 2.0, LIMIT);
    }
}

fn unit(axis: usize) -> Vec3 {
    [Vec3::X, Vec3::Y, Vec3::Z][axis]
}
