//! Rows of a tree: limits, dry friction, couplings, tendons, loop closures, contact points.
//!
//! Gaps are those of the placed coordinates, the middle of the step; the position pass carries them
//! to its end.

use super::def::{RowSoftness, TreeJointKind, TreeLoop, TreeTendon};
use super::kinematics::ball_turn;
use super::number::Number;
use super::row::{Bound, Segment};
use super::spatial::{Rotation, Spatial, Vector};
use super::tree::Tree;
use super::work::TreeWork;

/// Distance within which a limit gets its row [rad or m], beyond the motion of a step.
const NEAR: f64 = 0.02;

/// State from which rows are made: coordinates in the middle of the step, velocities at its start,
/// velocities at its end without rows, and the step.
pub(super) struct Moment<'a, N> {
    pub(super) q: &'a [N],
    pub(super) v: &'a [N],
    pub(super) v_free: &'a [N],
    pub(super) h: N,
}

impl<N: Number> Tree<N> {
    /// Whether the tree can have rows at all.
    pub(super) fn may_have_rows(&self) -> bool {
        !(self.couplings.is_empty() && self.tendons.is_empty() && self.loops.is_empty())
            || self.joints.iter().any(|joint| joint.limited)
            || self.dofs.iter().any(|dof| dof.has_friction)
    }

    /// Makes the rows of the tree; after the factor.
    pub(super) fn gather(&self, moment: &Moment<'_, N>, work: &mut TreeWork<N>, row: &mut [N]) {
        work.rows.clear();
        for (dof, data) in self.dofs.iter().enumerate().filter(|(_, dof)| dof.has_friction) {
            row.fill(N::zero());
            row[dof] = N::one();
            self.add_row(row, Bound::Box(data.friction * moment.h), work);
        }
        for coupling in &self.couplings {
            row.fill(N::zero());
            let follower = &self.joints[coupling.follower];
            let x = coupling.leader.map_or_else(N::zero, |leader| {
                moment.q[self.joints[leader].q] - self.joints[leader].reference
            });
            let (mut value, mut slope) = (N::zero(), N::zero());
            for &c in coupling.polynomial.iter().rev() {
                slope = slope * x + value;
                value = value * x + c;
            }
            row[follower.dof] = N::one();
            if let Some(leader) = coupling.leader {
                row[self.joints[leader].dof] = -slope;
            }
            let gap = moment.q[follower.q] - follower.reference - value;
            self.add_equal(row, gap, coupling.softness, moment, work);
        }
        for tendon in &self.tendons {
            self.add_tendon(tendon, moment, work, row);
        }
        for closure in &self.loops {
            self.add_loop(closure, moment, work, row);
        }
        // Limits come last: a sweep ends with them, so they hold best.
        for index in 0..self.joints.len() {
            if self.joints[index].limited {
                self.add_limits(index, moment, work, row);
            }
        }
    }

    /// Whitens a row over the tree and adds it.
    fn add_row(&self, row: &mut [N], bound: Bound<N>, work: &mut TreeWork<N>) -> usize {
        self.whiten_row(work, row);
        let segment = work.rows.segment(0, row);
        work.rows.add([segment, Segment::default()], bound);
        work.rows.rows.len() - 1
    }

    /// w = D^-½ L^-ᵀ Jᵀ.
    pub(super) fn whiten_row(&self, work: &TreeWork<N>, row: &mut [N]) {
        self.solve_upper(work, row);
        for (value, &root) in row.iter_mut().zip(&work.root_inverse) {
            *value = *value * root;
        }
    }

    /// Adds a row that holds an error at 0, rigidly or as a spring.
    fn add_equal(
        &self,
        row: &mut [N],
        gap: N,
        softness: RowSoftness,
        moment: &Moment<'_, N>,
        work: &mut TreeWork<N>,
    ) {
        let speed = dot(row, moment.v);
        let index = self.add_row(row, Bound::None, work);
        let row = &mut work.rows.rows[index];
        match softness {
            RowSoftness::Rigid => {
                row.gap = gap;
                row.corrects = true;
            }
            RowSoftness::Spring { frequency, ratio } => {
                let start = gap - speed * moment.h * N::splat(0.5);
                row.oscillate(frequency, ratio, start, moment.h);
            }
        }
    }

    /// Adds a row that keeps a gap open, if it is near in any lane.
    fn add_limit(&self, row: &mut [N], gap: N, moment: &Moment<'_, N>, work: &mut TreeWork<N>) {
        let motion = dot(row, moment.v).abs() + dot(row, moment.v_free).abs();
        let reach = motion * moment.h + N::splat(NEAR);
        if !gap.any_less(reach) {
            return;
        }
        let present = gap.if_less(reach, N::one(), N::zero());
        let index = self.add_row(row, Bound::Push(present), work);
        let row = &mut work.rows.rows[index];
        row.gap = gap;
        row.corrects = true;
        // An open gap halves within the rest of the step at most, so no limit is passed.
        row.target = -(gap.greater(N::zero()) / moment.h);
    }

    fn add_limits(
        &self,
        index: usize,
        moment: &Moment<'_, N>,
        work: &mut TreeWork<N>,
        row: &mut [N],
    ) {
        let joint = &self.joints[index];
        if joint.kind == TreeJointKind::Ball {
            let turn = ball_turn(joint, moment.q);
            let angle = turn.length();
            let safe = N::splat(1.0e-9).if_less(angle, angle, N::one());
            row.fill(N::zero());
            for k in 0..3 {
                row[joint.dof + k] = -(turn.0[k] / safe);
            }
            self.add_limit(row, joint.range[1] - angle, moment, work);
            return;
        }
        let q = moment.q[joint.q];
        for (sign, gap) in [(N::one(), q - joint.range[0]), (-N::one(), joint.range[1] - q)] {
            row.fill(N::zero());
            row[joint.dof] = sign;
            self.add_limit(row, gap, moment, work);
        }
    }

    fn add_tendon(
        &self,
        tendon: &TreeTendon,
        moment: &Moment<'_, N>,
        work: &mut TreeWork<N>,
        row: &mut [N],
    ) {
        let mut length = N::zero();
        let mut fill = |row: &mut [N], sign: f64| {
            length = N::zero();
            row.fill(N::zero());
            for ((link, joint), weight) in &tendon.terms {
                let joint = &self.joints[self.links[*link].joints.start + joint];
                length = length + moment.q[joint.q] * N::splat(*weight);
                row[joint.dof] = row[joint.dof] + N::splat(sign * weight);
            }
            length
        };
        let length = fill(row, 1.0);
        if tendon.stiffness > 0.0 || tendon.damping > 0.0 {
            let gap = length - N::splat(tendon.rest);
            let start = gap - dot(row, moment.v) * moment.h * N::splat(0.5);
            let index = self.add_row(row, Bound::None, work);
            let (k, d) = (N::splat(tendon.stiffness), N::splat(tendon.damping));
            work.rows.rows[index].spring(k, d, start, moment.h);
        }
        if tendon.friction > 0.0 {
            fill(row, 1.0);
            self.add_row(row, Bound::Box(N::splat(tendon.friction) * moment.h), work);
        }
        if let Some([low, high]) = tendon.range {
            fill(row, 1.0);
            self.add_limit(row, length - N::splat(low), moment, work);
            fill(row, -1.0);
            self.add_limit(row, N::splat(high) - length, moment, work);
        }
    }

    fn add_loop(
        &self,
        closure: &TreeLoop,
        moment: &Moment<'_, N>,
        work: &mut TreeWork<N>,
        row: &mut [N],
    ) {
        let place = |link: Option<usize>, point: [f64; 3], work: &TreeWork<N>| {
            let point = Vector::splat(point);
            match link {
                None => (point - work.origin, Rotation::identity()),
                Some(link) => {
                    let turn = work.rotation[link];
                    (work.position[link] + turn.rotate(point), turn)
                }
            }
        };
        let (a, turn_a) = place(Some(closure.link_a), closure.point_a, work);
        let (b, turn_b) = place(closure.link_b, closure.point_b, work);
        let points = [(Some(closure.link_a), a, -N::one()), (closure.link_b, b, N::one())];
        let error = b - a;
        for axis in 0..3 {
            row.fill(N::zero());
            for (link, point, sign) in points {
                self.fill_direction(link, point, unit(axis) * sign, work, row);
            }
            self.add_equal(row, error.0[axis], closure.softness, moment, work);
        }
        let Some(kept) = closure.rotation else { return };
        let kept = turn_a.times(Rotation::splat(kept).normalized());
        let error = turn_b.times(kept.inverse()).vector();
        for axis in 0..3 {
            row.fill(N::zero());
            for (link, _, sign) in points {
                for &dof in link.map_or(&[][..], |link| self.path_of(link)) {
                    row[dof] = row[dof] + work.axis[dof].angular.0[axis] * sign;
                }
            }
            self.add_equal(row, error.0[axis], closure.softness, moment, work);
        }
    }

    /// Adds to a row the velocity of a point [m, world axes, from the reference point] of a link
    /// along a direction.
    pub(super) fn fill_direction(
        &self,
        link: Option<usize>,
        point: Vector<N>,
        direction: Vector<N>,
        work: &TreeWork<N>,
        row: &mut [N],
    ) {
        let Some(link) = link else { return };
        let force = Spatial { angular: point.cross(direction), linear: direction };
        for &dof in self.path_of(link) {
            row[dof] = row[dof] + work.axis[dof].dot(force);
        }
    }
}

fn unit<N: Number>(axis: usize) -> Vector<N> {
    let mut v = Vector::zero();
    v.0[axis] = N::one();
    v
}

fn dot<N: Number>(a: &[N], b: &[N]) -> N {
    a.iter().zip(b).fold(N::zero(), |sum, (&a, &b)| sum + a * b)
}
