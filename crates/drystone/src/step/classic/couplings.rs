//! Couplings and pulleys in the classic methods. They use the rows of the default method with unit
//! mass and inertia; the motion of a kinematic body is in its mover.

use super::rows::Mover;
use crate::base::collision::push;
use crate::base::id::JointId;
use crate::base::math::Vec3;
use crate::base::sym3::Sym3;
use crate::state::bodies::Bodies;
use crate::state::joints::{Joint, Joints};
use crate::step::context::caps::Caps;
use crate::step::solver::joint::coupling_row::{Part, Source, Start};

/// Part of an error that is removed in a substep.
const BAUMGARTE: f32 = 0.2;

/// A coupling or pulley.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coupled {
    source: Source,
    /// Constraint error at the step's start; for a rope, less its length [m or rad].
    c: f32,
    /// The row only pulls.
    is_slack: bool,
    /// Impulse of this substep; for a rope at most 0.
    pub(crate) impulse: f32,
}

impl Coupled {
    /// `None` for other joints.
    pub(crate) fn new(
        joint: &Joint,
        joints: &Joints,
        bodies: &Bodies,
        row_of: &[u32],
    ) -> Option<Self> {
        let look = |id: JointId| Some(joints.at(joints.rows.row(id)?));
        let one = Sym3::diagonal(Vec3::ONE);
        let mass = |body: u32| (row_of[body as usize] as usize, 1.0, one);
        let start = Start::new(joint, look, bodies, mass)?;
        Some(Self { source: start.source, c: start.c, is_slack: start.is_slack, impulse: 0.0 })
    }

    /// Solves the row once.
    pub(crate) fn solve(&mut self, h: f32, caps: &Caps, movers: &mut [Mover]) {
        // Elapsed time is 0, because the movers already contain the motion of kinematic bodies.
        let now = self.source.now(self.c, |row| [movers[row].x, movers[row].t], 0.0);
        let (mut k, mut speed) = (0.0, 0.0);
        for Part { solver_row, v, w } in &now.parts {
            let mover = &movers[*solver_row];
            let (along, about) = (push(mover.inv_mass, *v), mover.turns_by(*w));
            k += if mover.frozen { 0.0 } else { v.dot(along) + w.dot(about) };
            speed += v.dot(mover.v) + w.dot(mover.w);
        }
        if !(k > 0.0) {
            return;
        }
        // A slack rope lets its ends separate until it is taut.
        let is_open = self.is_slack && now.c < 0.0;
        let closing = if is_open {
            1.0 / h * now.c
        } else {
            caps.closing_row(BAUMGARTE / h * now.c, now.c, self.source.is_turn())
        };
        let new = self.impulse - (speed + closing) / k;
        let new = if self.is_slack { new.min(0.0) } else { new };
        let d = new - self.impulse;
        if !d.is_finite() {
            return;
        }
        self.impulse = new;
        for Part { solver_row, v, w } in &now.parts {
            let mover = &mut movers[*solver_row];
            mover.take(Vec3::ZERO, *v * d);
            mover.take_turn(*w * d);
        }
    }
}
