//! Joints of the classic methods: rows with a velocity bias, swept between the contacts.

use super::couplings::Coupled;
use super::rows::Mover;
use super::six_dof::Axes;
use crate::base::math::Vec3;
use crate::base::sym3::Sym3;
use crate::state::def::JointKind;
use crate::step::context::caps::Caps;
use crate::step::context::softness::Softness;

/// Part of a joint's error that is removed in a substep.
const BAUMGARTE: f32 = 0.2;

/// A joint.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointRow {
    /// Row in the table of joints.
    pub(crate) row: u32,
    pub(crate) a: u32,
    pub(crate) b: u32,
    pub(crate) r_a: Vec3,
    pub(crate) r_b: Vec3,
    /// From A's anchor to B's at the step's start [m].
    pub(crate) gap: Vec3,
    pub(crate) kind: JointKind,
    /// For six-axis joints.
    pub(crate) axes: Option<Axes>,
    pub(crate) coupled: Option<Coupled>,
    /// Impulse, as in [`crate::state::joints::Joint::impulse`].
    pub(crate) impulse: Vec3,
}

impl JointRow {
    /// Solves the joint once.
    pub(crate) fn solve(&mut self, h: f32, caps: &Caps, movers: &mut [Mover]) {
        if let Some(coupled) = &mut self.coupled {
            coupled.solve(h, caps, movers);
            self.impulse.x = coupled.impulse;
            return;
        }
        let (a, b) = (&movers[self.a as usize], &movers[self.b as usize]);
        let turned = |t: Vec3, r: Vec3| {
            let once = t.cross(r);
            r + once + t.cross(once) * 0.5
        };
        let (r_a, r_b) = (turned(a.t, self.r_a), turned(b.t, self.r_b));
        let gap = self.gap + b.x - a.x + (r_b - self.r_b) - (r_a - self.r_a);
        if let Some(axes) = &mut self.axes {
            axes.solve([self.a, self.b], [r_a, r_b, gap], (h, caps), movers);
            return;
        }
        let u = b.v + b.w.cross(r_b) - a.v - a.w.cross(r_a);
        let k = a.mobility(r_a).plus(b.mobility(r_b));
        let j = match self.kind {
            JointKind::Ball => {
                let Some(inverse) = k.inverse() else { return };
                // Limit the speed: a gap of several meters, after a body was repositioned, would
                // throw the bodies.
                let (rate, size) = (BAUMGARTE / h, gap.length());
                let fastest = caps.closing_axis(rate * size, size, 0);
                let rate = if rate * size > fastest { fastest / size } else { rate };
                let j = -inverse.mul(u + gap * rate);
                self.impulse += j;
                j
            }
            JointKind::Distance { min, max, spring } => {
                let Some(along) = gap.try_normalize() else { return };
                let length = gap.length();
                along * self.solve_distance(&k, along, u, (h, caps), [min, max], length, spring)
            }
            // Solved above, by `axes` and `coupled`.
            JointKind::SixDof(_)
            | JointKind::Coupling(_)
            | JointKind::Pulley(_)
            | JointKind::Link => return,
        };
        if j.is_finite() {
            movers[self.a as usize].take(r_a, -j);
            movers[self.b as usize].take(r_b, j);
        }
    }

    fn solve_distance(
        &mut self,
        k: &Sym3,
        along: Vec3,
        u: Vec3,
        (h, caps): (f32, &Caps),
        [min, max]: [f32; 2],
        length: f32,
        spring: Option<crate::state::def::joint_def::Spring>,
    ) -> f32 {
        let response = along.dot(k.mul(along));
        if !(response > 0.0) {
            return 0.0;
        }
        let mut speed = u.dot(along);
        let mut sum = 0.0;
        if let Some(spring) = spring {
            let soft = Softness::new(spring.hertz, spring.damping_ratio, h);
            let error = length - spring.rest_length;
            let j =
                -(soft.mass * speed + soft.rate * error) / response - soft.impulse * self.impulse.z;
            self.impulse.z += j;
            speed += j * response;
            sum += j;
        }
        // The distance may approach each limit within its gap.
        for (part, error, sign) in [(0, length - min, 1.0), (1, max - length, -1.0)] {
            let closing = if error > 0.0 {
                1.0 / h * error
            } else {
                caps.closing_axis(BAUMGARTE / h * error, error, 0)
            };
            let old = self.impulse[part];
            let new = (old - (sign * speed + closing) / response).max(0.0);
            self.impulse[part] = new;
            speed += sign * (new - old) * response;
            sum += sign * (new - old);
        }
        sum
    }

    /// Applies the impulses of the last step, if the method stores them.
    pub(crate) fn warm_start(&self, movers: &mut [Mover]) {
        if !matches!(self.kind, JointKind::Ball | JointKind::Distance { .. }) {
            return;
        }
        let j = self.linear();
        movers[self.a as usize].take(self.r_a, -j);
        movers[self.b as usize].take(self.r_b, j);
    }

    /// The impulse of a ball or distance joint on B.
    pub(crate) fn linear(&self) -> Vec3 {
        match self.kind {
            JointKind::Distance { .. } => {
                let i = self.impulse;
                self.gap.normalize_or(Vec3::Y) * (i.x - i.y + i.z)
            }
            JointKind::Ball => self.impulse,
            JointKind::SixDof(_)
            | JointKind::Coupling(_)
            | JointKind::Pulley(_)
            | JointKind::Link => Vec3::ZERO,
        }
    }
}
