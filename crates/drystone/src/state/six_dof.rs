//! Runtime data of joints of six axes.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::def::six_dof::{JointAxis, JointMotion, JointSpring, SixDof};
use crate::base::math::Vec3;
use crate::base::quat::Quat;
use crate::base::trig::atan2;

/// Stands for no limit.
pub(crate) const FAR: f32 = 1.0e30;

/// Stiffness that is rigid for any substep.
pub(crate) const STIFF: f32 = 1.0e20;

/// Below this sine the direction of a swing is noise.
pub(crate) const NO_SWING: f32 = 0.5e-6;

/// Minimum squared half-length of the sum of the two x axes. Opposite axes have no twist, and near
/// that it changes arbitrarily fast.
pub(crate) const MIN_TWIST: f32 = 0.2;

/// A joint of six axes.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(from = "(SixDof, SixDofState)", into = "(SixDof, SixDofState)")
)]
pub(crate) struct SixDofJoint {
    pub(crate) def: SixDof,
    pub(crate) laws: SixDofLaws,
    pub(crate) state: SixDofState,
}

/// State of a joint of six axes between steps, written by the solver; packed into rows of four
/// numbers.
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[repr(C)]
pub(crate) struct SixDofState {
    /// Impulses of a substep for each axis: lock or drive, friction, limit [N s; N m s].
    pub(crate) lock_or_drive: [f32; 6],
    pub(crate) friction: [f32; 6],
    pub(crate) limit: [f32; 6],
    /// Angles in the last solve [rad].
    pub(crate) angles: [f32; 3],
    /// Impulses of a substep on body B at its anchor [N s; N m s, world].
    pub(crate) force: Vec3,
    pub(crate) torque: Vec3,
    /// Padding of the last row.
    padding: f32,
}

impl SixDofState {
    /// The state before the first solve.
    pub(crate) const IDLE: Self = Self {
        lock_or_drive: [0.0; 6],
        friction: [0.0; 6],
        limit: [0.0; 6],
        angles: [0.0; 3],
        force: Vec3::ZERO,
        torque: Vec3::ZERO,
        padding: 0.0,
    };

    pub(crate) fn is_finite(&self) -> bool {
        let Self { lock_or_drive, friction, limit, angles, force, torque, .. } = self;
        let impulses = [lock_or_drive, friction, limit].into_iter().flatten();
        let numbers = impulses.chain(angles).all(|x| x.is_finite());
        numbers && force.is_finite() && torque.is_finite()
    }

    pub(crate) fn scale_impulses(&mut self, factor: f32) {
        let Self { lock_or_drive, friction, limit, force, torque, .. } = self;
        for impulse in [lock_or_drive, friction, limit].into_iter().flatten() {
            *impulse *= factor;
        }
        (*force, *torque) = (*force * factor, *torque * factor);
    }
}

/// The rotations that a joint allows, which determine the definition of its angles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Turning {
    /// No rotation.
    Still,
    /// Rotation about this axis.
    Hinge(usize),
    /// Rotation about all axes except this one.
    Universal(usize),
    /// A twist about x and a swing.
    Swing,
}

impl SixDof {
    pub(crate) fn turning(&self) -> Turning {
        let is_held = |i: usize| self.angular[i].motion == JointMotion::Locked;
        if self.cone.is_some() {
            return Turning::Swing;
        }
        match [0, 1, 2].map(is_held) {
            [true, true, true] => Turning::Still,
            [false, true, true] => Turning::Hinge(0),
            [true, false, true] => Turning::Hinge(1),
            [true, true, false] => Turning::Hinge(2),
            [true, false, false] => Turning::Universal(0),
            [false, true, false] => Turning::Universal(1),
            [false, false, true] => Turning::Universal(2),
            [false, false, false] => Turning::Swing,
        }
    }
}

/// The solver's view of a joint's definition, as rows of four numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SixDofLaws {
    pub(crate) axes: [AxisLaw; 6],
    /// Maximum swings about y and z, 1 if they are limited together, 0.
    pub(crate) cone: [f32; 4],
    /// 1 at the axis of a hinge, or at the locked axis of a universal joint; and the type: see
    /// [`SixDofLaws::HINGE`].
    pub(crate) turning: [f32; 4],
    pub(crate) flags: Flags,
}

/// Properties of the axes of one or several joints: one bit per axis.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Flags {
    /// The axis is active; it has a drive; a limit; a limit with a spring.
    pub(crate) acts: u8,
    pub(crate) drives: u8,
    pub(crate) limits: u8,
    pub(crate) yields: u8,
    /// Bits of the last numbers of [`SixDofLaws::turning`], and whether there are cones.
    pub(crate) turnings: u8,
    pub(crate) cones: bool,
}

impl core::ops::BitOrAssign for Flags {
    fn bitor_assign(&mut self, o: Self) {
        self.acts |= o.acts;
        self.drives |= o.drives;
        self.limits |= o.limits;
        self.yields |= o.yields;
        self.turnings |= o.turnings;
        self.cones |= o.cones;
    }
}

/// The laws of an axis.
///
/// 0. 1 if it is locked, the locked coordinate, 1 if its impulses are warm-started, its friction
///    [N; N m];
/// 1. minimum and maximum coordinate, 1 if these are as stiff as the joint, maximum force of its
///    drive [N; N m];
/// 2. for the drive: stiffness and damping, 1 if these are per mass, and the target coordinate;
/// 3. for the limit: the same three; and the drive's target speed.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct AxisLaw(pub(crate) [[f32; 4]; 4]);

impl AxisLaw {
    fn new(axis: &JointAxis) -> Self {
        let held = axis.locked_at();
        let carries = held.is_some() || axis.is_scalar();
        let one = |yes: bool| if yes { 1.0 } else { 0.0 };
        let hold = [one(held.is_some()), held.unwrap_or(0.0), one(carries), axis.friction];
        let (low, high, spring) = match axis.motion {
            JointMotion::Limited { min, max, spring } => (min.max(-FAR), max.min(FAR), spring),
            JointMotion::Free | JointMotion::Locked => (-FAR, FAR, None),
        };
        let numbers = |spring: Option<JointSpring>, last: f32| {
            let spring = spring.unwrap_or(JointSpring::new(0.0, 0.0));
            // Infinite damping stands for a motor.
            let (stiffness, damping) = (spring.stiffness.min(STIFF), spring.damping.min(STIFF));
            [stiffness, damping, one(spring.per_mass), last]
        };
        let drive = axis.drive;
        Self([
            hold,
            [low, high, one(spring.is_none()), drive.map_or(0.0, |d| d.max_force)],
            numbers(drive.map(|d| d.spring), drive.map_or(0.0, |d| d.position)),
            numbers(spring, drive.map_or(0.0, |d| d.velocity)),
        ])
    }
}

impl SixDofLaws {
    /// The laws of an idle lane.
    pub(crate) const IDLE: Self = Self {
        axes: [AxisLaw([[0.0; 4]; 4]); 6],
        cone: [1.0, 1.0, 0.0, 0.0],
        turning: [0.0; 4],
        flags: Flags { acts: 0, drives: 0, limits: 0, yields: 0, turnings: 0, cones: false },
    };

    /// Last number of [`Self::turning`], and its bit in [`Flags::turnings`].
    pub(crate) const HINGE: u8 = 1;
    pub(crate) const UNIVERSAL: u8 = 2;
    pub(crate) const SWING: u8 = 4;

    pub(crate) fn new(def: &SixDof) -> Self {
        // The swing is along y at first; the solver updates targets and the cone's width.
        let acting = def.acting([1.0, 0.0]);
        let mut laws = Self { axes: acting.each_ref().map(AxisLaw::new), ..Self::IDLE };
        for (i, axis) in acting.iter().enumerate().filter(|(_, axis)| axis.locked_at().is_none()) {
            let bit = |yes: bool| if yes { 1 << i } else { 0 };
            laws.flags.acts |= bit(axis.is_scalar());
            laws.flags.drives |= bit(axis.drive.is_some());
            if let JointMotion::Limited { spring, .. } = axis.motion {
                laws.flags.limits |= bit(true);
                laws.flags.yields |= bit(spring.is_some());
            }
        }
        if let Some(cone) = &def.cone {
            laws.cone = [cone.swing[0], cone.swing[1], 1.0, 0.0];
            laws.flags.cones = true;
        }
        let (axis, kind) = match def.turning() {
            Turning::Still => (3, 0),
            Turning::Hinge(axis) => (axis, Self::HINGE),
            Turning::Universal(axis) => (axis, Self::UNIVERSAL),
            Turning::Swing => (3, Self::SWING),
        };
        laws.turning[axis] = 1.0;
        laws.turning[3] = f32::from(kind);
        laws.flags.turnings = kind;
        laws
    }
}

impl SixDofJoint {
    pub(crate) fn new(def: SixDof) -> Self {
        let (frame_a, frame_b) = (def.frame_a.normalized(), def.frame_b.normalized());
        let def = SixDof { frame_a, frame_b, ..def };
        Self { def, laws: SixDofLaws::new(&def), state: SixDofState::default() }
    }

    /// The same joint with other axes.
    pub(crate) fn set(&mut self, def: SixDof) {
        *self = Self { state: self.state, ..Self::new(def) };
    }

    /// The rotations between bodies with these rotations.
    pub(crate) fn joint_angles(&self, a: Quat, b: Quat) -> JointAngles {
        self.def.joint_angles(a * self.def.frame_a, b * self.def.frame_b, self.state.angles)
    }
}

/// The saved form. The laws follow from the definition, whose frames have unit length.
impl From<(SixDof, SixDofState)> for SixDofJoint {
    fn from((def, state): (SixDof, SixDofState)) -> Self {
        Self { def, laws: SixDofLaws::new(&def), state }
    }
}

impl From<SixDofJoint> for (SixDof, SixDofState) {
    fn from(six_dof: SixDofJoint) -> Self {
        (six_dof.def, six_dof.state)
    }
}

/// Axes of relative rotation, and the angles about them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointAngles {
    /// Rows [world]: their products with the relative angular velocity are the rates of the angles.
    pub(crate) rows: [Vec3; 3],
    pub(crate) angles: [f32; 3],
    /// With a cone, the y and z components of the swing's direction; the rows are along it and
    /// across it.
    pub(crate) swing: [f32; 2],
}

impl SixDof {
    /// The angles of a joint with three free rotations, for this rotation of the second frame in
    /// the first: the twist about x, y and z of the swing [rad]. `None` for other joints.
    pub(crate) fn swing_twist(&self, rotation: Quat) -> Option<[f32; 3]> {
        if self.turning() != Turning::Swing {
            return None;
        }
        let free = Self { angular: [JointAxis::FREE; 3], cone: None, ..*self };
        Some(free.joint_angles(Quat::IDENTITY, rotation, [0.0; 3]).angles)
    }

    /// The angles and their rows, for these rotations of the joint's frames. The angle of a single
    /// free axis continues from `last`. (For eight joints at a time:
    /// step/solver/joint/six_dof/angles.rs.)
    pub(crate) fn joint_angles(&self, frame_a: Quat, frame_b: Quat, last: [f32; 3]) -> JointAngles {
        let (a, b) = (frame_a.to_mat3(), frame_b.to_mat3());
        let (a, b) = ([a.x, a.y, a.z], [b.x, b.y, b.z]);
        let q = frame_a.conjugate() * frame_b;
        let q = if q.w < 0.0 { Quat::new(-q.x, -q.y, -q.z, -q.w) } else { q };
        let swing = [1.0, 0.0];
        match self.turning() {
            Turning::Still => {
                JointAngles { rows: a, angles: [2.0 * q.x, 2.0 * q.y, 2.0 * q.z], swing }
            }
            Turning::Hinge(i) => {
                let off = a[i].cross(b[i]);
                let mut angles = [off.dot(a[0]), off.dot(a[1]), off.dot(a[2])];
                let turn = 2.0 * core::f32::consts::PI;
                let angle = 2.0 * atan2([q.x, q.y, q.z][i], q.w);
                angles[i] = angle + turn * ((last[i] - angle) / turn).round();
                JointAngles { rows: a, angles, swing }
            }
            Turning::Universal(k) => {
                let (i, j) = [(1, 2), (0, 2), (0, 1)][k];
                // i × j is k or -k.
                let sign = if k == 1 { -1.0 } else { 1.0 };
                let (mut rows, mut angles) = (a, [0.0; 3]);
                rows[j] = b[j];
                rows[k] = a[i].cross(b[j]).normalize_or(a[k]) * sign;
                angles[k] = -sign * a[i].dot(b[j]);
                angles[i] = atan2(sign * b[j].dot(a[k]), b[j].dot(a[j]));
                angles[j] = atan2(sign * a[i].dot(b[k]), a[i].dot(b[i]));
                JointAngles { rows, angles, swing }
            }
            Turning::Swing => {
                // q is a swing after a twist: half the twist has the cosine w / r and the sine x /
                // r.
                let r = (q.w * q.w + q.x * q.x).sqrt();
                let (c, s) = if r > 0.0 { (q.w / r, q.x / r) } else { (1.0, 0.0) };
                let (y, z) = (q.y * c - q.z * s, q.y * s + q.z * c);
                let sine = (y * y + z * z).sqrt();
                let (twist, size) = (2.0 * atan2(q.x, q.w), 2.0 * atan2(sine, r));
                let middle = a[0] + b[0];
                let close = 0.5 * middle.length_squared();
                let row = middle * (1.0 / close.max(MIN_TWIST));
                let [y, z] = if sine > NO_SWING { [y / sine, z / sine] } else { [1.0, 0.0] };
                if self.cone.is_none() {
                    let angles = [twist, y * size, z * size];
                    return JointAngles { rows: [row, a[1], a[2]], angles, swing };
                }
                let rows = [row, a[1] * y + a[2] * z, a[2] * y - a[1] * z];
                JointAngles { rows, angles: [twist, size, 0.0], swing: [y, z] }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Quat, Vec3};
    use crate::state::def::named::Hinge;
    use crate::state::def::six_dof::{JointAxis, SixDof};

    /// Compares finite differences of the angles with the rates from the rows.
    fn rates_agree(def: &SixDof, at: Quat, directions: &[Vec3], tolerance: f32) {
        let a = Quat::from_axis_angle([1.0, 2.0, -1.0], 0.7);
        let b = a * at;
        let here = def.joint_angles(a, b, [0.0; 3]);
        for direction in directions {
            let step = 2.0e-3;
            let direction = a.rotate(*direction);
            let there = def.joint_angles(a, b.turned_by(direction * step), [0.0; 3]);
            let before = def.joint_angles(a, b.turned_by(direction * -step), [0.0; 3]);
            for i in 0..3 {
                let rate = (there.angles[i] - before.angles[i]) / (2.0 * step);
                let said = here.rows[i].dot(direction);
                assert!((rate - said).abs() < tolerance, "{i} of {at:?}: {rate} {said}");
            }
        }
    }

    #[test]
    fn rows_are_the_rates_of_the_angles() {
        let all = [Vec3::X, Vec3::Y, Vec3::Z];
        // Differences of f32 angles: 2 · 6e-8 · 3 / 4e-3 = 1e-4.
        rates_agree(&SixDof::FIXED, Quat::IDENTITY, &all, 1.0e-3);
        for angle in [-2.0, 0.0, 0.4, 3.0] {
            let hinge = Hinge::new().six_dof();
            rates_agree(&hinge, Quat::from_axis_angle(Vec3::X, angle), &all, 1.0e-3);
            for k in 0..3 {
                let mut angular = [JointAxis::FREE; 3];
                angular[k] = JointAxis::LOCKED;
                let universal = SixDof { angular, ..SixDof::FIXED };
                let (i, j) = [(1, 2), (0, 2), (0, 1)][k];
                let first = Quat::from_axis_angle(all[i], angle);
                let at = first * Quat::from_axis_angle(all[j], 0.3);
                rates_agree(&universal, at, &[all[i], at.rotate(all[j])], 1.0e-3);
            }
        }
        let ball = SixDof { angular: [JointAxis::FREE; 3], ..SixDof::FIXED };
        rates_agree(&ball, Quat::from_axis_angle(Vec3::X, 0.8), &[Vec3::X], 1.0e-3);
    }
}
