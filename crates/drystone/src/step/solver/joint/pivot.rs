//! Integrates a pendulum: a body that one ball joint holds to a fixed body, and that nothing else
//! touches.
//!
//! It rotates about a fixed point. That is free rotation by the inertia about that point, with
//! kicks by the forces' torque. Every substep is half a kick, a rotation by [`rotate_freely`], and
//! half a kick: symplectic and of second order [Dullweber97].
//!
//! The joint's rows fail if the body spins by more than some tenths of a radian in a substep. They
//! use the inertia, and with it the gyroscopic torque, of the step's start, and rotation vectors of
//! a step do not add. With rows, a top at 300 rad/s precessed at 0.4 to 14 times its rate (A6 in
//! docs/accuracy.md).

use crate::base::double::{DQuat, DVec3};
use crate::base::math::{Vec3, bounded};
use crate::base::quat::Quat;
use crate::base::sym3::Sym3;
use crate::state::bodies::body::Body;
use crate::state::joints::{Joint, JointModel};
use crate::step::context::StepContext;
use crate::step::context::softness::exact_decay;
use crate::step::gyration::{Spin, rotate_freely};
use crate::step::solver::body::integrate::acceleration;
use crate::step::solver::body::state::BodyState;
use crate::step::solver::lent::Solver;

/// A joint whose gap exceeds this part of the body's reach is closed by its rows [1].
const OPEN: f32 = 1.0e-3;

/// A body on one ball joint, and the body that holds it.
struct Pendulum<'a> {
    solver_row: usize,
    body: &'a Body,
    other: &'a Body,
    /// Anchors on both [m, frames of the centers of mass].
    r: Vec3,
    at: Vec3,
    /// 1 if the joint's impulse acts on the body, -1 if on the other one.
    sign: f32,
}

/// A body at the end of a step.
struct Swung {
    state: BodyState,
    /// Mean impulse of the joint on it in a substep [N s].
    impulse: Vec3,
}

impl Solver<'_> {
    /// Moves the body of a joint through the whole step, if it is a pendulum; true if it is one.
    /// No row acts on its solver body then, whose motion does not count: see [`Solver::put_end`].
    pub(crate) fn swing(&self, row: u32) -> bool {
        let Some(Pendulum { solver_row, body, r, other, at, sign }) =
            self.joint(row).and_then(|joint| self.pendulum(joint))
        else {
            return false;
        };
        let pivot = other.center + other.rotation.rotate(at);
        let gap = body.center + body.rotation.rotate(r) - pivot;
        if gap.length() > OPEN * (r.length() + body.extent) {
            return false;
        }
        let Some(end) = swung(self.ctx, body, pivot, r) else { return false };
        self.put_end(solver_row, end.state);
        if let Some(joint) = self.joint_slots.row(row as usize) {
            joint.impulse = (end.impulse * (sign * self.ctx.store_scale())).bounded();
            #[expect(clippy::cast_precision_loss, reason = "at most 256 by 8")]
            let substeps = self.ctx.substeps as f32;
            joint.given = [(end.impulse * (sign * substeps)).bounded(), Vec3::ZERO];
            joint.peak = [bounded(joint.impulse.length()), 0.0];
        }
        true
    }

    /// The body that a ball joint holds, if nothing else acts on it.
    fn pendulum(&self, joint: &Joint) -> Option<Pendulum<'_>> {
        let Joint { body_a, body_b, anchor_a, anchor_b, .. } = *joint;
        let (solver_row, body, r, other, at, sign) = match (
            self.body.solver_row_of[body_a as usize],
            self.body.solver_row_of[body_b as usize],
        ) {
            (0, solver_row @ 1..) => (solver_row as usize, body_b, anchor_b, body_a, anchor_a, 1.0),
            (solver_row @ 1.., 0) => {
                (solver_row as usize, body_a, anchor_a, body_b, anchor_b, -1.0)
            }
            _ => return None,
        };
        let (body, other) = (self.bodies.at(body), self.bodies.at(other));
        let is_pendulum =
            matches!(joint.model, JointModel::Ball) && !other.active() && is_free(body);
        is_pendulum.then_some(Pendulum { solver_row, body, r, other, at, sign })
    }
}

/// True if only one joint acts on the body.
fn is_free(body: &Body) -> bool {
    let locks = &body.inertia.locks;
    body.ties.constraints == 1
        && !body.record.dragged
        && body.ties.joints.len() == 1
        && locks.linear == [false; 3]
        && locks.angular == [false; 3]
        && body.inertia.moments.min_element() > 0.0
}

/// Steps a body whose point `anchor` [frame of the center of mass] stays at `pivot`.
fn swung(ctx: &StepContext, body: &Body, pivot: Vec3, anchor: Vec3) -> Option<Swung> {
    // The inertia about the pivot.
    let (m, r) = (body.inertia.mass, anchor);
    let own = Sym3::rotated_diagonal(body.inertia.principal, body.inertia.moments);
    let inertia = Sym3 {
        xx: own.xx + m * (r.y * r.y + r.z * r.z),
        yy: own.yy + m * (r.z * r.z + r.x * r.x),
        zz: own.zz + m * (r.x * r.x + r.y * r.y),
        xy: own.xy - m * r.x * r.y,
        xz: own.xz - m * r.x * r.z,
        yz: own.yz - m * r.y * r.z,
    };
    let (moments, principal) = inertia.eigen();
    if !(moments.min_element() > 0.0 && moments.is_finite()) {
        return None;
    }
    let mut spin = Spin { rotation: body.rotation, principal, moments };
    let arm_of = |rotation: Quat| DQuat::widened(rotation).rotate(DVec3::from(-anchor));

    // The joint removes velocity that is no rotation about the pivot. The rest must not pass
    // through the inertia: the same rounding in every step would remove or add 1e-7 of the energy
    // each time.
    let arm = arm_of(body.rotation);
    let mut w = DVec3::from(body.w) + DVec3::from(body.history.w_low);
    let off = DVec3::from(body.v) - w.cross(arm);
    w = w + answer(&spin, arm.cross(off) * f64::from(m));
    let start = w.cross(arm);

    let acc = acceleration(ctx, body);
    let (force, torque) =
        (DVec3::from(acc * m), DVec3::from(body.forces.torque + body.forces.step_torque));
    let half = 0.5 * f64::from(ctx.h);
    let mut kick = answer(&spin, torque + arm.cross(force)) * half;
    for _ in 0..ctx.substeps {
        let turned = rotate_freely(&spin, w + kick, ctx.h, ctx.substeps);
        spin.rotation = turned.rotation;
        let arm = arm_of(spin.rotation);
        kick = answer(&spin, torque + arm.cross(force)) * half;
        w = DVec3::from(turned.w) + DVec3::from(turned.w_low) + kick;
    }
    let arm = arm_of(spin.rotation);
    w = w * f64::from(damping(ctx, body, w, arm));
    let v = w.cross(arm);
    #[expect(clippy::cast_precision_loss, reason = "at most 256 substeps")]
    let part = 1.0 / ctx.substeps as f32;
    let impulse = ((v - start).single() - acc * ctx.dt) * (m * part);
    let center = (DVec3::from(pivot) + arm).single();
    let v = v.single();
    let single = w.single();
    let w_low = (w - DVec3::from(single)).single();
    let state = BodyState { center, rotation: spin.rotation, v, w: single, w_low };
    Some(Swung { state, impulse })
}

/// Angular velocity of an angular momentum.
fn answer(spin: &Spin, momentum: DVec3) -> DVec3 {
    let q = DQuat::widened(spin.rotation).times(DQuat::widened(spin.principal)).normalized();
    let (l, m) = (q.unrotate(momentum), DVec3::from(spin.moments));
    q.rotate(DVec3 { x: l.x / m.x, y: l.y / m.y, z: l.z / m.z })
}

/// Factor on the angular velocity by damping in the step. The energy falls at the rate at which
/// linear and angular damping together dissipate it.
#[expect(clippy::cast_possible_truncation, reason = "a mean of two rates")]
fn damping(ctx: &StepContext, body: &Body, w: DVec3, arm: DVec3) -> f32 {
    let (linear, angular) =
        (f64::from(body.forces.linear_damping), f64::from(body.forces.angular_damping));
    if linear + angular <= 0.0 {
        return 1.0;
    }
    let v = w.cross(arm);
    let spin = Sym3::rotated_diagonal(body.rotation * body.inertia.principal, body.inertia.moments)
        .mul(w.single());
    let moving = f64::from(body.inertia.mass) * v.dot(v);
    let turning = w.dot(DVec3::from(spin));
    let all = moving + turning;
    let rate = if all > 0.0 { (linear * moving + angular * turning) / all } else { angular };
    exact_decay(rate as f32, ctx.dt)
}
