//! Bounds the work of joints: closing gaps, drives, springs.

use crate::base::double::{DVec3, greater, lesser};
use crate::base::simd::wide::{LANES, at};
use crate::state::bodies::NONE;
use crate::step::context::caps::Caps;
use crate::step::solver::bound::{Side, speed_of, speeds, vector};
use crate::step::solver::joint::six_dof::block::SixDofBlock;
use crate::step::solver::joint::six_dof::drive::Push;
use crate::step::solver::joint::sweep::JointSweep;
use crate::step::solver::lent::Solver;
use crate::step::solver::plan::group::Group;
use crate::step::solver::plan::joint_class::DISTANCE;
use crate::step::solver::vec6::shift;
use crate::step::solver::work::Bound;

/// Speed at which a gap of a joint axis closes.
fn closing_speed(gap: f64, rate: f32, caps: &Caps, axis: usize) -> f64 {
    speed_of(gap, rate, (caps, caps.push(axis), axis))
}

impl Solver<'_> {
    pub(super) fn ask_joints(&self, group: &Group, sweep: &JointSweep, bounds: &mut [Bound]) {
        let inv_h = f64::from(sweep.inv_h);
        for batch in &self.plan.joints.batches[group.joints.clone()] {
            for i in batch.blocks.clone() {
                let (block, extra) = (self.joint.blocks.read(i), self.joint.extras.read(i));
                for lane in 0..LANES {
                    let ends = [block.row_a[lane], block.row_b[lane]];
                    let Some(bound) = self.over_lane(ends, group, bounds) else { continue };
                    let [a, b] = ends.map(|solver_row| self.side(solver_row));
                    let (ra, rb) = (vector(&block.r_a, lane), vector(&block.r_b, lane));
                    let drift = if batch.fixed { vector(&extra.drift, lane) } else { DVec3::ZERO };
                    let gap = vector(&block.gap, lane)
                        + (b.moved - a.moved)
                        + (shift(b.turn, rb) - shift(a.turn, ra))
                        + drift * f64::from(sweep.elapsed);
                    let impulse = at(&block.impulse, lane);
                    let length = gap.length();
                    if batch.class != DISTANCE {
                        let speed = closing_speed(length, sweep.softness.rate, &sweep.caps, 0);
                        bound.close(f64::from(impulse.length()), speed, 0);
                        bound.drive(impulse.length(), drift.length());
                        continue;
                    }
                    let slip = speeds(|k| {
                        (b.v[k] + b.w[k].cross(rb) - a.v[k] - a.w[k].cross(ra)).length()
                    });
                    let limits = at(&extra.limits, lane);
                    for (p, error) in [
                        (impulse.x, f64::from(limits.x) - length),
                        (impulse.y, length - f64::from(limits.y)),
                    ] {
                        let speed = closing_speed(error.abs(), sweep.softness.rate, &sweep.caps, 0);
                        bound.close(f64::from(p), speed, 0);
                        bound.drive(p, drift.length());
                    }
                    let spring = at(&extra.spring, lane);
                    let square = f64::from(spring.x) * inv_h / f64::from(spring.z);
                    let off = length - f64::from(limits.z);
                    let maximum = 1.0 / (1.0 / a.mass + 1.0 / b.mass);
                    bound.release(f64::from(impulse.z), slip, (0.0, square, maximum), (off, inv_h));
                }
            }
        }
    }

    pub(super) fn ask_six_dof(&self, group: &Group, sweep: &JointSweep, bounds: &mut [Bound]) {
        for i in self.plan.six_dof.blocks_of(&group.six_dof) {
            let block = self.joint.six_dof.read(i);
            if block.is_direct {
                continue;
            }
            for lane in 0..LANES {
                let ends = [block.row_a[lane], block.row_b[lane]];
                let Some(bound) = self.over_lane(ends, group, bounds) else { continue };
                let ends = ends.map(|solver_row| self.side(solver_row));
                let acting = core::array::from_fn(|axis| {
                    [&block.lock_or_drive, &block.friction, &block.limit].map(|of| of[axis][lane])
                });
                ask_six_dof((block, lane), ends, &acting, true, sweep, bound);
            }
        }
    }

    pub(super) fn ask_trees(&self, group: &Group, bounds: &mut [Bound]) {
        for tree in self.trees(group) {
            let solver_row = self.tree_row(tree);
            let Some(bound) = self.over(solver_row, group, bounds) else { continue };
            for (i, joint) in self.tree_joints(tree) {
                let row = self.tree.rows.read(i);
                for (k, p) in row.lambda[..row.count].iter().enumerate() {
                    let kind = if joint.six_dof == NONE { 0 } else { row.six_dof.axis(k) / 3 };
                    bound.close(*p, row.closing[kind], kind);
                }
                let held: f64 = row.lambda[..row.count].iter().map(|p| p.abs()).sum();
                bound.drive(held, row.drift().length());
                if joint.six_dof != NONE {
                    let (block, lane) = (
                        self.joint.six_dof.read(joint.six_dof as usize / LANES),
                        joint.six_dof as usize % LANES,
                    );
                    let ends = [block.row_a[lane], block.row_b[lane]]
                        .map(|solver_row| self.side(solver_row));
                    let (drift, spin) = drifts(block, lane);
                    bound.drive(held, greater(drift, spin));
                    let sweep = JointSweep::solving(self.ctx, 0.0);
                    ask_six_dof((block, lane), ends, row.six_dof.acting(), false, &sweep, bound);
                }
            }
        }
    }
}

/// Speeds that kinematic bodies cause, of translation and of rotation.
pub(super) fn drifts(block: &SixDofBlock, lane: usize) -> (f64, f64) {
    let [spin_a, spin_b] = [&block.spin_a, &block.spin_b].map(|spin| vector(spin, lane));
    let (ra, rb) = (vector(&block.r_a, lane), vector(&block.r_b, lane));
    let own = vector(&block.drift, lane) + spin_b.cross(rb) - spin_a.cross(ra);
    (own.length(), (spin_b - spin_a).length())
}

/// Adds the possible work of the drives, springs and limits of a six-axis joint; with `locks` also
/// of its locked axes.
fn ask_six_dof(
    (block, lane): (&SixDofBlock, usize),
    [a, b]: [Side; 2],
    acting: &[[f32; 3]; 6],
    locks: bool,
    sweep: &JointSweep,
    bound: &mut Bound,
) {
    let (ra, rb) = (vector(&block.r_a, lane), vector(&block.r_b, lane));
    let elapsed = f64::from(sweep.elapsed);
    let gap = vector(&block.gap, lane)
        + (b.moved - a.moved)
        + (shift(b.turn, rb) - shift(a.turn, ra))
        + vector(&block.drift, lane) * elapsed;
    let turn =
        b.turn - a.turn + (vector(&block.spin_b, lane) - vector(&block.spin_a, lane)) * elapsed;
    let (drift, spin) = drifts(block, lane);
    let rate = sweep.softness.rate;
    for axis in 0..6 {
        let (i, kind) = (axis % 3, axis / 3);
        let n = vector(if kind == 0 { &block.u[i] } else { &block.n[i] }, lane);
        let x = if kind == 0 { n.dot(gap) } else { f64::from(block.angles[i][lane]) + n.dot(turn) };
        let [held, friction, limit] = acting[axis];
        let moves = if kind == 0 { drift } else { spin };
        bound.drive(held.abs() + friction.abs() + limit.abs(), moves);
        if block.locked[axis][lane] > 0.0 {
            if locks && !(block.is_anchored && kind == 0) {
                let off = (x - f64::from(block.place[axis][lane])).abs();
                bound.close(f64::from(held), closing_speed(off, rate, &sweep.caps, axis), kind);
            }
            continue;
        }
        let speeds = speeds(|k| {
            if kind == 0 {
                n.dot(b.v[k] + b.w[k].cross(rb) - a.v[k] - a.w[k].cross(ra + gap))
            } else {
                n.dot(b.w[k] - a.w[k])
            }
        });
        let laws = &block.axes[axis];
        // A motor or damper accelerates an axis up to its speed and no farther.
        bound.drive(held, lesser(speeds[1], f64::from(laws.drive.speed[lane].abs())));
        let inv_h = f64::from(sweep.inv_h);
        // Through the locked axes of a joint its two bodies act as one at their lever arms; in a
        // tree, the whole tree does.
        let maximum = match (locks, kind) {
            (true, 0) => 1.0 / (1.0 / a.mass + 1.0 / b.mass),
            (true, _) => lesser(a.inertia_at(ra + gap), b.inertia_at(rb)),
            (false, 0) => bound.mass,
            (false, _) => bound.whole_inertia(),
        };
        let mut release = |push: &Push, impulse: f32, off: f64| {
            let stiffness = f64::from(push.stiffness[lane]);
            let is_per_mass = push.per_mass[lane] > 0.0;
            let [own, square] = if is_per_mass { [0.0, stiffness] } else { [stiffness, 0.0] };
            bound.release(f64::from(impulse), speeds, (own, square, maximum), (off, inv_h));
        };
        let (low, high) = (f64::from(laws.low[lane]), f64::from(laws.high[lane]));
        let error = greater(greater(low - x, x - high), 0.0);
        release(&laws.drive, held, x - f64::from(laws.drive.place[lane]));
        if laws.yields && laws.hard[lane] <= 0.0 {
            release(&laws.limit, limit, error);
        } else {
            bound.close(f64::from(limit), closing_speed(error, rate, &sweep.caps, axis), kind);
        }
    }
    if locks && block.is_anchored {
        let force = f64::from(at(&block.carried, lane).length());
        bound.close(force, closing_speed(gap.length(), rate, &sweep.caps, 0), 0);
        bound.drive(force, drift);
    }
}
