//! Six-axis joints in the classic methods: solves single rows in sequence, with impulses that are
//! kept within a substep only. Springs are evaluated at the substep's end.

use super::rows::Mover;
use crate::base::math::Vec3;
use crate::state::bodies::body::Body;
use crate::state::def::six_dof::{JointAxis, JointMotion, JointSpring};
use crate::state::six_dof::SixDofJoint;
use crate::step::context::caps::Caps;

/// Part of an error that is removed in a substep.
const BAUMGARTE: f32 = 0.2;

/// The axes of a joint at the step's start.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axes {
    along: [Vec3; 3],
    about: [Vec3; 3],
    /// Angles, including full turns.
    pub(crate) angles: [f32; 3],
    axes: [JointAxis; 6],
    /// Impulse of each axis in this substep: drive, friction, limit.
    given: [[f32; 3]; 6],
    /// Impulse on B at its anchor, in this substep.
    pub(crate) force: Vec3,
    pub(crate) torque: Vec3,
}

impl Axes {
    pub(crate) fn new(six_dof: &SixDofJoint, a: &Body, b: &Body) -> Self {
        let axes = (a.rotation * six_dof.def.frame_a).to_mat3();
        let turns = six_dof.joint_angles(a.rotation, b.rotation);
        Self {
            along: [axes.x, axes.y, axes.z],
            about: turns.rows,
            angles: turns.angles,
            axes: six_dof.def.acting(turns.swing),
            given: [[0.0; 3]; 6],
            force: Vec3::ZERO,
            torque: Vec3::ZERO,
        }
    }

    /// Resets the impulses before a substep.
    pub(crate) fn begin(&mut self) {
        self.given = [[0.0; 3]; 6];
        (self.force, self.torque) = (Vec3::ZERO, Vec3::ZERO);
    }

    /// Solves the joint once, at the current anchors and gap.
    pub(crate) fn solve(
        &mut self,
        [row_a, row_b]: [u32; 2],
        [r_a, r_b, gap]: [Vec3; 3],
        (h, caps): (f32, &Caps),
        movers: &mut [Mover],
    ) {
        let arm_a = r_a + gap;
        let (t_a, t_b) = (movers[row_a as usize].t, movers[row_b as usize].t);
        let turn = t_b - t_a - t_a.cross(t_b) * 0.5;
        for i in 0..6 {
            let axis = self.axes[i];
            if axis.locked_at().is_none() && !axis.is_scalar() {
                continue;
            }
            let (a, b) = (&movers[row_a as usize], &movers[row_b as usize]);
            let (row, x, u, k) = if i < 3 {
                let n = self.along[i];
                let row = n + t_a.cross(n) + t_a.cross(t_a.cross(n)) * 0.5;
                let u = row.dot(b.v + b.w.cross(r_b) - a.v - a.w.cross(arm_a));
                let k = row.dot(a.mobility(arm_a).plus(b.mobility(r_b)).mul(row));
                (row, row.dot(gap), u, k)
            } else {
                let n = self.about[i - 3];
                let row = n + t_a.cross(n) + t_a.cross(t_a.cross(n)) * 0.5;
                let k = a.turns_by(row).dot(row) + b.turns_by(row).dot(row);
                (row, self.angles[i - 3] + n.dot(turn), row.dot(b.w - a.w), k)
            };
            if !(k > 0.0) {
                continue;
            }
            let capped = |speed: f32, error: f32| caps.closing_axis(speed, error, i);
            let j = pushed(&axis, &mut self.given[i], [x, u, k, h], capped);
            if !j.is_finite() {
                continue;
            }
            let p = row * j;
            if i < 3 {
                self.force += p;
                movers[row_a as usize].take(arm_a, -p);
                movers[row_b as usize].take(r_b, p);
            } else {
                self.torque += p;
                movers[row_a as usize].take_turn(-p);
                movers[row_b as usize].take_turn(p);
            }
        }
    }
}

/// The impulse of an axis at the coordinate `x`, speed `u` and inverse mass `k`. `capped` limits
/// the speed at which an error closes.
fn pushed(
    axis: &JointAxis,
    given: &mut [f32; 3],
    [x, u, k, h]: [f32; 4],
    capped: impl Fn(f32, f32) -> f32,
) -> f32 {
    if let Some(place) = axis.locked_at() {
        let error = x - place;
        return -(u + capped(error * BAUMGARTE / h, error)) / k;
    }
    let mut sum = 0.0;
    if let Some(drive) = axis.drive {
        let error = x - drive.position;
        let new = given[0] + sprung(&drive.spring, error, u, drive.velocity, k, h, given[0]);
        let maximum = drive.max_force * h;
        let new = new.clamp(-maximum, maximum);
        sum += new - given[0];
        given[0] = new;
    }
    if axis.friction > 0.0 {
        let maximum = axis.friction * h;
        let new = (given[1] - (u + k * sum) / k).clamp(-maximum, maximum);
        sum += new - given[1];
        given[1] = new;
    }
    if let JointMotion::Limited { min, max, spring } = axis.motion {
        let u = u + k * sum;
        let (low, sign) = if x - min < max - x { (x - min, 1.0) } else { (max - x, -1.0) };
        let new = match spring {
            Some(spring) if low < 0.0 => {
                let d = sprung(&spring, sign * low, u, 0.0, k, h, given[2]);
                sign * (sign * (given[2] + d)).max(0.0)
            }
            Some(_) => 0.0,
            None => {
                let closing =
                    if low > 0.0 { 1.0 / h * low } else { capped(BAUMGARTE / h * low, low) };
                sign * (sign * given[2] - (sign * u + closing) / k).max(0.0)
            }
        };
        sum += new - given[2];
        given[2] = new;
    }
    sum
}

/// Impulse of a spring, λ + h (stiffness (error + h u) + damping (u - speed)) = 0, where u is the
/// speed after it.
fn sprung(spring: &JointSpring, error: f32, u: f32, speed: f32, k: f32, h: f32, old: f32) -> f32 {
    if spring.damping == f32::INFINITY {
        return (speed - u) / k;
    }
    let mass = if spring.per_mass { 1.0 / k } else { 1.0 };
    let (stiff, damp) = (spring.stiffness * mass, spring.damping * mass);
    let force = stiff * (error + h * u) + damp * (u - speed);
    -(old + h * force) / (1.0 + h * k * (damp + h * stiff))
}
