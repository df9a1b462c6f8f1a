//! Limits of joints of six axes: arcs for turns, bars for ways, and where the joint is between them.

use core::f32::consts::TAU;

use drystone::geometry::Aabb;
use drystone::joint::{JointMotion, SixDof};
use drystone::math::trig;
use drystone::{BodyKind, BodyRef, JointKind, JointRef, Pose, Quat, Vec3, World};
use drystone_render::{Color, Drawing};

const LIMIT: Color = [190, 30, 120, 255];
const PLACE: Color = [20, 130, 160, 255];

/// Parts of an arc for a whole turn.
const PARTS: f32 = 48.0;

/// A line [m, world], its width [px] and color.
type Segment = (Vec3, Vec3, f32, Color);

/// Adds lines for the limits of all joints; `size` is the radius of the largest arc [m].
pub(crate) fn add(drawing: &mut Drawing, world: &World, size: f32) {
    let mut lines = Vec::new();
    for joint in world.joints() {
        add_joint(&mut lines, world, &joint, fitting(world, &joint, size));
    }
    for (a, b, width, color) in lines {
        drawing.add_line(a, b, width, color);
    }
}

/// A radius at which arcs of neighbors, such as those of a spine, stay apart: no more than most of the smaller body's, and not so
/// small that nothing is seen [m].
fn fitting(world: &World, joint: &JointRef<'_>, most: f32) -> f32 {
    let bodies = [joint.body_a(), joint.body_b()].into_iter().filter_map(|id| world.body(id));
    let radius = |body: BodyRef<'_>| {
        let shapes = body.shapes().filter_map(|id| world.shape(id));
        let bounds = shapes.fold(Aabb::EMPTY, |all, shape| all.union(&shape.bounds()));
        bounds.half_extents().max_element()
    };
    let dynamic = bodies.filter(|body| body.kind() == BodyKind::Dynamic);
    let least = dynamic.map(radius).filter(|r| *r > 0.0).fold(f32::INFINITY, f32::min);
    (0.7 * least).max(0.25 * most).min(most)
}

fn add_joint(lines: &mut Vec<Segment>, world: &World, joint: &JointRef<'_>, size: f32) {
    let JointKind::SixDof(axes) = joint.kind() else { return };
    if let Some(frame) = frame(world, joint, &axes) {
        add_bars(lines, joint, &axes, &frame, size);
        add_arcs(lines, world, joint, &axes, &frame, size);
    }
}

/// The joint's frame on its first body [world].
fn frame(world: &World, joint: &JointRef<'_>, axes: &SixDof) -> Option<Pose> {
    let body = world.body(joint.body_a())?;
    let frame = Pose::new(joint.anchor_a(), body.pose().rotation * axes.frame_a);
    frame.is_finite().then_some(frame)
}

/// A bar from the least to the greatest place along each axis, a tick where the second body is.
fn add_bars(
    lines: &mut Vec<Segment>,
    joint: &JointRef<'_>,
    axes: &SixDof,
    frame: &Pose,
    size: f32,
) {
    let gap = joint.coordinates().map_or(Vec3::ZERO, |[gap, _]| gap);
    for (i, axis) in axes.linear.iter().enumerate() {
        let JointMotion::Limited { min, max, .. } = axis.motion else { continue };
        let (along, across) = (unit(i), unit((i + 1) % 3));
        // Without an end it goes on to some way beyond where it is.
        let far = 2.0 * size;
        let (low, high) = (min.max(gap[i].min(max) - far), max.min(gap[i].max(min) + far));
        let at = |x: f32, side: f32| frame.point(along * x + across * (side * size));
        lines.push((at(low, 0.0), at(high, 0.0), 2.5, LIMIT));
        for end in [min, max].into_iter().filter(|end| end.is_finite()) {
            lines.push((at(end, -0.35), at(end, 0.35), 2.5, LIMIT));
        }
        lines.push((at(gap[i], -0.2), at(gap[i], 0.2), 3.0, PLACE));
    }
}

/// An arc from the least to the greatest angle about each axis, and the angle that is; the rim of a cone.
fn add_arcs(
    lines: &mut Vec<Segment>,
    world: &World,
    joint: &JointRef<'_>,
    axes: &SixDof,
    frame: &Pose,
    size: f32,
) {
    let angles = joint.coordinates().map_or(Vec3::ZERO, |[_, angles]| angles);
    let free: Vec<usize> = (0..3).filter(|&i| moves(axes.angular[i].motion)).collect();
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
        add_arc(lines, low, high, at);
        for end in [min, max].into_iter().filter(|end| end.is_finite()) {
            lines.push((own.position, at(end), 1.5, LIMIT));
        }
        lines.push((own.position, at(angle), 3.0, PLACE));
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
    add_arc(lines, 0.0, TAU, rim);
    for quarter in 0..4_u8 {
        lines.push((frame.position, rim(0.25 * TAU * f32::from(quarter)), 1.0, LIMIT));
    }
    lines.push((frame.position, swung(angles.y, angles.z), 3.0, PLACE));
}

/// Whether an axis is not held at one place.
fn moves(motion: JointMotion) -> bool {
    match motion {
        JointMotion::Free => true,
        JointMotion::Locked => false,
        JointMotion::Limited { min, max, spring } => spring.is_some() || min < max,
    }
}

/// A line along what `at` gives for angles from `low` to `high` [rad].
fn add_arc(lines: &mut Vec<Segment>, low: f32, high: f32, at: impl Fn(f32) -> Vec3) {
    if !(high > low) {
        return;
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to 97")]
    let parts = ((high - low).min(2.0 * TAU) / TAU * PARTS).ceil().max(1.0) as u16;
    let angle = |part: u16| low + (high - low) * (f32::from(part) / f32::from(parts));
    for part in 0..parts {
        lines.push((at(angle(part)), at(angle(part + 1)), 2.0, LIMIT));
    }
}

fn unit(axis: usize) -> Vec3 {
    [Vec3::X, Vec3::Y, Vec3::Z][axis]
}

#[cfg(test)]
mod tests {
    use core::f32::consts::FRAC_PI_2;

    use drystone::joint::{ConeTwist, Hinge, JointAxis, JointCone, SixDof, Slider, Universal};
    use drystone::{BodyDef, JointDef, Quat, ShapeDef, Vec3, World, vec3};

    use super::{LIMIT, PLACE, Segment, add_joint};

    /// Two bodies at one place, the second one turned, and the lines of their joint.
    fn lines(axes: SixDof, turn: Quat, at: Vec3) -> Vec<Segment> {
        let mut world = World::default();
        let ball = || ShapeDef::sphere(0.1);
        let a = world.add_body(BodyDef::fixed().with_shape(ball())).unwrap();
        let b = BodyDef::dynamic().with_position(at).with_rotation(turn).with_shape(ball());
        let b = world.add_body(b).unwrap();
        let joint = world.add_joint(JointDef::new(a, b, axes)).unwrap();
        let mut lines = Vec::new();
        add_joint(&mut lines, &world, &world.joint(joint).unwrap(), 1.0);
        lines
    }

    /// Where the marks of what is end.
    fn places(lines: &[Segment]) -> Vec<Vec3> {
        lines.iter().filter(|line| line.3 == PLACE).map(|line| line.1).collect()
    }

    fn near(a: Vec3, b: Vec3) -> bool {
        // Sums of some products of numbers about 1.
        (a - b).length() < 1.0e-5
    }

    #[test]
    fn the_mark_of_a_hinge_is_where_the_second_body_points() {
        let turn = Quat::from_axis_angle(Vec3::X, 0.7);
        let axes = Hinge::of(JointAxis::limited(-FRAC_PI_2, FRAC_PI_2)).six_dof();
        let lines = lines(axes, turn, Vec3::ZERO);
        assert_eq!(places(&lines).len(), 1);
        assert!(near(places(&lines)[0], turn.rotate(Vec3::Y)), "{:?}", places(&lines));
        // The arc goes from −z to z over y.
        let ends =
            |end: Vec3| lines.iter().any(|l| l.3 == LIMIT && (near(l.0, end) || near(l.1, end)));
        assert!(ends(-Vec3::Z) && ends(Vec3::Z) && ends(Vec3::Y));
        assert!(!ends(-Vec3::Y));
    }

    #[test]
    fn both_marks_of_a_universal_joint_are_on_its_cross() {
        // x about the first body's x, then y about the second one's y.
        let first = Quat::from_axis_angle(Vec3::X, 0.4);
        let turn = first * Quat::from_axis_angle(Vec3::Y, 0.6);
        let free = JointAxis::limited(-1.0, 1.0);
        let lines = lines(Universal::of(free, free).six_dof(), turn, Vec3::ZERO);
        let marks = places(&lines);
        assert_eq!(marks.len(), 2);
        // The cross between both bodies: y stays with the second one, x with the first.
        assert!(near(marks[0], turn.rotate(Vec3::Y)), "{marks:?}");
        assert!(near(marks[1], Vec3::X), "{marks:?}");
    }

    #[test]
    fn a_slider_has_a_bar_with_its_ends_and_an_open_one_goes_on() {
        let axes = Slider::of(JointAxis::limited(-0.5, 2.0)).six_dof();
        let at = vec3(1.0, 0.0, 0.0);
        let bar = lines(axes, Quat::IDENTITY, at);
        assert!(near(bar[0].0, vec3(-0.5, 0.0, 0.0)) && near(bar[0].1, vec3(2.0, 0.0, 0.0)));
        let mark = bar.iter().find(|line| line.3 == PLACE).unwrap();
        assert!(near((mark.0 + mark.1) * 0.5, at));
        let open = Slider::of(JointAxis::limited(-0.5, f32::INFINITY)).six_dof();
        let open = lines(open, Quat::IDENTITY, at);
        assert!(near(open[0].1, vec3(3.0, 0.0, 0.0)), "two radii beyond where it is");
        assert_eq!(open.len() + 1, bar.len(), "no tick at infinity");
    }

    #[test]
    fn a_cone_has_a_rim_through_its_widest_swings() {
        let cone = JointCone { swing: [0.5, 1.0], spring: None };
        let twist = JointAxis::limited(-0.1, 0.1);
        let axes = SixDof { cone: Some(cone), ..ConeTwist::of(twist, 0.5, 1.0).six_dof() };
        let turn = Quat::from_axis_angle(Vec3::Z, 0.3);
        let lines = lines(axes, turn, Vec3::ZERO);
        let rim = Quat::from_axis_angle(Vec3::Z, 1.0).rotate(Vec3::X);
        assert!(lines.iter().any(|line| line.3 == LIMIT && near(line.1, rim)));
        assert!(near(*places(&lines).last().unwrap(), turn.rotate(Vec3::X)));
    }
}
