//! Limits of joints of six axes: arcs for rotations, bars for translations, and marks for the
//! current coordinates.

use core::f32::consts::TAU;

use super::{DebugColor, Pen};
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::base::quat::Quat;
use crate::base::trig::sin_cos;
use crate::state::def::six_dof::{JointMotion, SixDof};
use crate::world::joint::JointRef;

const LIMIT: DebugColor = DebugColor::LIMIT;
const PLACE: DebugColor = DebugColor::PLACE;

/// Segments of an arc for a whole turn.
const PARTS: f32 = 48.0;

/// A joint whose limits are drawn.
struct Drawn<'a> {
    joint: &'a JointRef<'a>,
    axes: &'a SixDof,
    /// The joint's frames on its bodies [world].
    frames: [Pose; 2],
    /// Radius of arcs [m].
    size: f32,
}

impl Pen<'_> {
    pub(super) fn limits(&mut self, joint: &JointRef<'_>, axes: &SixDof) {
        let rows = [joint.body_a(), joint.body_b()].map(|id| self.tables.bodies.rows.row(id));
        let [Some(a), Some(b)] = rows else { return };
        let [a, b] = [a, b].map(|row| self.tables.bodies.at(row));
        let at = joint.anchor_a();
        let frames = [a.rotation * axes.frame_a, b.rotation * axes.frame_b];
        let frames = frames.map(|rotation| Pose { position: at, rotation });
        // The size keeps the arcs of neighbors apart, as in a spine, and every arc large enough to
        // see.
        let sizes = [a, b].into_iter().filter(|body| body.is_dynamic() && body.extent > 0.0);
        let minimum = sizes.map(|body| body.extent).fold(f32::INFINITY, f32::min);
        let size = (0.7 * minimum).max(0.25 * self.size).min(self.size);
        let drawn = Drawn { joint, axes, frames, size };
        self.bars(&drawn);
        self.arcs(&drawn);
    }

    /// Draws a bar from the minimum to the maximum along each axis, and a tick at the second body.
    fn bars(&mut self, &Drawn { joint, axes, frames: [frame, _], size }: &Drawn<'_>) {
        let gap = joint.coordinates().map_or(Vec3::ZERO, |[gap, _]| gap);
        for (i, axis) in axes.linear.iter().enumerate() {
            let JointMotion::Limited { min, max, .. } = axis.motion else { continue };
            let (along, across) = (unit(i), unit((i + 1) % 3));
            // Where a limit is missing, the bar ends some distance beyond the current coordinate.
            let far = 2.0 * size;
            let (low, high) = (min.max(gap[i].min(max) - far), max.min(gap[i].max(min) + far));
            let at = |x: f32, side: f32| frame.point(along * x + across * (side * size));
            self.line(at(low, 0.0), at(high, 0.0), LIMIT);
            for end in [min, max].into_iter().filter(|end| end.is_finite()) {
                self.line(at(end, -0.35), at(end, 0.35), LIMIT);
            }
            self.line(at(gap[i], -0.2), at(gap[i], 0.2), PLACE);
        }
    }

    /// Draws an arc from the minimum to the maximum angle about each axis, a mark at the current
    /// angle, and the rim of a cone.
    fn arcs(&mut self, &Drawn { joint, axes, frames: [frame, second], size }: &Drawn<'_>) {
        let angles = joint.coordinates().map_or(Vec3::ZERO, |[_, angles]| angles);
        let is_free = |i: usize| moves(axes.angular[i].motion);
        let free = (0..3).filter(|i| is_free(*i)).count();
        for (i, axis) in axes.angular.iter().enumerate() {
            let JointMotion::Limited { min, max, .. } = axis.motion else { continue };
            // With two free axes the second one is fixed to the second body.
            let is_second = free == 2 && is_free(i) && (0..i).any(is_free);
            let with_b = is_second && axes.cone.is_none();
            let own = if with_b { second } else { frame };
            // A rotation about x is shown by y; a rotation about y or z is shown by x, the axis
            // that swings.
            let arm = if i == 0 { Vec3::Y } else { Vec3::X };
            // Seen from the second body, the first body turns, with the opposite sign.
            let sign = if with_b { -1.0 } else { 1.0 };
            let at = |angle: f32| {
                let turn = Quat::from_axis_angle(unit(i), sign * angle);
                own.point(turn.rotate(arm) * size)
            };
            let angle = angles[i];
            let low = min.max(angle.min(max) - 0.5 * TAU);
            let high = max.min(angle.max(min) + 0.5 * TAU).min(low + TAU);
            self.limit_arc(low, high, at);
            for end in [min, max].into_iter().filter(|end| end.is_finite()) {
                self.line(own.position, at(end), LIMIT);
            }
            self.line(own.position, at(angle), PLACE);
        }
        let Some(cone) = axes.cone else { return };
        // The swing is a rotation vector perpendicular to x. Its limit is an ellipse.
        let swung = |y: f32, z: f32| {
            let vector = Vec3::from([0.0, y, z]);
            frame.point(Quat::from_rotation_vector(vector).rotate(Vec3::X) * size)
        };
        let rim = |t: f32| {
            let (s, c) = sin_cos(t);
            swung(c * cone.swing[0], s * cone.swing[1])
        };
        self.limit_arc(0.0, TAU, rim);
        for quarter in 0..4_u8 {
            self.line(frame.position, rim(0.25 * TAU * f32::from(quarter)), LIMIT);
        }
        self.line(frame.position, swung(angles.y, angles.z), PLACE);
    }

    /// Draws a line through `at(angle)` for angles from `low` to `high` [rad].
    fn limit_arc(&mut self, low: f32, high: f32, at: impl Fn(f32) -> Vec3) {
        if !(high > low) {
            return;
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to 97")]
        let parts = ((high - low).min(2.0 * TAU) / TAU * PARTS).ceil().max(1.0) as u16;
        let angle = |part: u16| low + (high - low) * (f32::from(part) / f32::from(parts));
        for part in 0..parts {
            self.line(at(angle(part)), at(angle(part + 1)), LIMIT);
        }
    }
}

/// True if the axis is not locked.
fn moves(motion: JointMotion) -> bool {
    match motion {
        JointMotion::Free => true,
        JointMotion::Locked => false,
        JointMotion::Limited { min, max, spring } => spring.is_some() || min < max,
    }
}

fn unit(axis: usize) -> Vec3 {
    [Vec3::X, Vec3::Y, Vec3::Z][axis]
}

#[cfg(test)]
mod tests {
    use core::f32::consts::FRAC_PI_2;

    use super::{LIMIT, PLACE};
    use crate::base::math::{Vec3, vec3};
    use crate::base::quat::Quat;
    use crate::state::def::named::{ConeTwist, Hinge, Slider, Universal};
    use crate::state::def::six_dof::{JointAxis, JointCone, SixDof};
    use crate::state::def::{BodyDef, JointDef, ShapeDef};
    use crate::world::World;
    use crate::world::draw::{DebugColor, DebugDraw, DebugDrawOptions};

    type Segment = (Vec3, Vec3, DebugColor);

    struct Lines(Vec<Segment>);

    impl DebugDraw for Lines {
        fn line(&mut self, a: Vec3, b: Vec3, color: DebugColor) {
            self.0.push((a, b, color));
        }

        fn point(&mut self, _: Vec3, _: DebugColor) {}
    }

    /// Lines of a joint between two bodies at one place, the second one turned by `turn`.
    fn lines(axes: SixDof, turn: Quat, at: Vec3) -> Vec<Segment> {
        let mut world = World::default();
        // This radius gives arcs the radius 1.
        let ball = || ShapeDef::sphere(2.0);
        let a = world.add_body(BodyDef::fixed().with_shape(ball())).unwrap();
        let b = BodyDef::dynamic().with_position(at).with_rotation(turn).with_shape(ball());
        let b = world.add_body(b).unwrap();
        world.add_joint(JointDef::new(a, b, axes)).unwrap();
        let mut lines = Lines(Vec::new());
        let options = DebugDrawOptions { limits: true, size: 1.0, ..DebugDrawOptions::NOTHING };
        world.debug_draw(&mut lines, &options);
        lines.0
    }

    /// End points of the marks of current coordinates.
    fn places(lines: &[Segment]) -> Vec<Vec3> {
        lines.iter().filter(|line| line.2 == PLACE).map(|line| line.1).collect()
    }

    fn near(a: Vec3, b: Vec3) -> bool {
        // Rounding of sums of a few products of numbers near 1.
        (a - b).length() < 1.0e-5
    }

    #[test]
    fn the_mark_of_a_hinge_is_where_the_second_body_points() {
        let turn = Quat::from_axis_angle(Vec3::X, 0.7);
        let axes = Hinge::of(JointAxis::limited(-FRAC_PI_2, FRAC_PI_2)).six_dof();
        let lines = lines(axes, turn, Vec3::ZERO);
        assert_eq!(places(&lines).len(), 1);
        assert!(near(places(&lines)[0], turn.rotate(Vec3::Y)), "{:?}", places(&lines));
        // The arc leads from −z to z through y.
        let ends =
            |end: Vec3| lines.iter().any(|l| l.2 == LIMIT && (near(l.0, end) || near(l.1, end)));
        assert!(ends(-Vec3::Z) && ends(Vec3::Z) && ends(Vec3::Y));
        assert!(!ends(-Vec3::Y));
    }

    #[test]
    fn both_marks_of_a_universal_joint_are_on_its_cross() {
        // Rotation about the first body's x, then about the second body's y.
        let first = Quat::from_axis_angle(Vec3::X, 0.4);
        let turn = first * Quat::from_axis_angle(Vec3::Y, 0.6);
        let free = JointAxis::limited(-1.0, 1.0);
        let lines = lines(Universal::of(free, free).six_dof(), turn, Vec3::ZERO);
        let marks = places(&lines);
        assert_eq!(marks.len(), 2);
        // The cross between both bodies: its y is fixed to the second body, its x to the first.
        assert!(near(marks[0], turn.rotate(Vec3::Y)), "{marks:?}");
        assert!(near(marks[1], Vec3::X), "{marks:?}");
    }

    #[test]
    fn a_slider_has_a_bar_with_its_ends_and_an_open_one_goes_on() {
        let axes = Slider::of(JointAxis::limited(-0.5, 2.0)).six_dof();
        let at = vec3(1.0, 0.0, 0.0);
        let bar = lines(axes, Quat::IDENTITY, at);
        assert!(near(bar[0].0, vec3(-0.5, 0.0, 0.0)) && near(bar[0].1, vec3(2.0, 0.0, 0.0)));
        let mark = bar.iter().find(|line| line.2 == PLACE).unwrap();
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
        assert!(lines.iter().any(|line| line.2 == LIMIT && near(line.1, rim)));
        assert!(near(*places(&lines).last().unwrap(), turn.rotate(Vec3::X)));
    }
}
