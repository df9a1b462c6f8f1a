//! Solves a tree of joints directly, by factoring its equations from the leaves to the root
//! [Baraff96].
//!
//! With u the velocities of bodies before any impulse of the tree's joints, and x their change by
//! these impulses,
//!
//! ```text
//! H x - Jᵀ λ = 0        H = 1 + S g S for the rotation of each body
//! J x + Γ λ = -(J u + rate · gap)
//! ```
//!
//! Bodies and joints are the nodes of a tree, so each is eliminated into one neighbor without fill.
//! A joint is eliminated into its parent body after the body below it. That takes a 6 × 6 Cholesky
//! factorization, and one with as many rows as the joint locks axes. A ball joint has 3 rows. A
//! six-axis joint has up to 6, which are in six_dof.rs. Γ is that of a spring on the mass of the
//! whole tree, because the solution needs no softness of its own. Gaps close no faster than
//! contacts push.
//!
//! g is the geometric stiffness of a substep. A body pulled at its ends by F is turned back as by a
//! spring of F r. Light links under a heavy load then swing faster than substeps can follow. The
//! inertia h² F r against these joints' impulses keeps every frequency below 1/h. It is small next
//! to the inertia of the load on the joint, (ω h)² of it [Andrews17].
//!
//! The solve uses double precision, because masses in a chain that differ by a factor of a thousand
//! and more cancel. See docs/decisions/017-direct-joint-trees.md.

use super::rows::{TreeBody, TreeRow, TreeSweep, put_ball};
use crate::base::double::DVec3;
use crate::base::math::Vec3;
use crate::base::simd::wide::LANES;
use crate::base::sym3::Sym3;
use crate::base::threads::jobs::{Jobs, for_ranges};
use crate::state::bodies::NONE;
use crate::step::solver::joint::sweep::JointSweep;
use crate::step::solver::lent::Solver;
use crate::step::solver::plan::forest::{Tree, TreeJoint};
use crate::step::solver::plan::group::Group;
use crate::step::solver::vec6::{
    Vec6, backward, curve, dot, factor, forward, halves, mul, push, shift, wide,
};

/// Factor on the compliance in a relax sweep.
const RELAX: f64 = 0.01;

/// Calls with the number of rows of a joint as a constant for ball joints, the most frequent kind,
/// so that their loops have a known length.
macro_rules! of_rows {
    ($count:expr, $n:ident => $call:expr) => {
        match $count {
            3 => {
                let $n = 3;
                $call
            }
            $n => $call,
        }
    };
}

impl Solver<'_> {
    pub(crate) fn trees<'a>(&'a self, group: &'a Group) -> impl Iterator<Item = &'a Tree> {
        let forest = &self.plan.forest;
        forest.order[group.trees.clone()].iter().map(|tree| &forest.trees[*tree as usize])
    }

    pub(crate) fn tree_joints(
        &self,
        tree: &Tree,
    ) -> impl DoubleEndedIterator<Item = (usize, &TreeJoint)> {
        let joints = &self.plan.forest.joints;
        tree.joints.clone().zip(&joints[tree.joints.clone()])
    }

    /// Builds the rows of a group's trees and applies their impulses to the solver bodies.
    pub(crate) fn prepare_trees(&self, group: &Group) {
        for tree in self.trees(group) {
            for i in tree.bodies.clone() {
                let solver_row = self.body.solver_row_of[self.plan.forest.bodies[i] as usize];
                let whitening = self.body.whitening.read(solver_row as usize);
                let Sym3 { xx, yy, zz, xy, xz, yz } = whitening.s();
                let row = |x, y, z| DVec3::from(Vec3 { x, y, z });
                *self.tree.bodies.row(i) = TreeBody {
                    solver_row,
                    alpha: f64::from(whitening.alpha()),
                    s: [row(xx, xy, xz), row(xy, yy, yz), row(xz, yz, zz)],
                    ..TreeBody::default()
                };
            }
            // Ball joints lock no rotation.
            let has_six_dof = self.tree_joints(tree).any(|(_, joint)| joint.six_dof != NONE);
            let ease = if has_six_dof { self.turn_ease(tree) } else { 0.0 };
            for (i, joint) in self.tree_joints(tree) {
                if joint.six_dof == NONE {
                    self.prepare_tree_joint(joint, i);
                } else {
                    self.prepare_tree_six_dof(joint, self.tree.rows.row(i), ease);
                }
            }
            self.warm_start(tree);
        }
    }

    fn prepare_tree_joint(&self, tree: &TreeJoint, i: usize) {
        let Some(joint) = self.joint_slots.read(tree.row as usize) else { return };
        let (a, b) = (self.at_start(joint.body_a), self.at_start(joint.body_b));
        let (ra, rb) = (a.rotation.rotate(joint.anchor_a), b.rotation.rotate(joint.anchor_b));
        let gap = (b.center - a.center) + (rb - ra);
        let moves = |row: u32, r: Vec3| {
            let body = self.bodies.at(row);
            if !body.is_dynamic() && body.active() { body.velocity_at(r) } else { Vec3::ZERO }
        };
        let drift = moves(joint.body_b, rb) - moves(joint.body_a, ra);
        let impulse = joint.impulse * self.ctx.impulse_scale;
        let (sign, child, parent) = if tree.is_child_a { (-1.0, ra, rb) } else { (1.0, rb, ra) };
        let impulse = DVec3::from(impulse * sign);
        let body = self.tree.bodies.read(tree.child as usize);
        let mut row = TreeRow {
            count: 3,
            r_child: DVec3::from(child),
            r_parent: DVec3::from(parent),
            gap: DVec3::from(gap * sign),
            drift: DVec3::from(drift * sign),
            lambda: [impulse.x, impulse.y, impulse.z, 0.0, 0.0, 0.0],
            impulse,
            ..TreeRow::default()
        };
        put_ball(&mut row.child, 1.0, body, row.r_child);
        if tree.parent != NONE {
            let body = self.tree.bodies.read(tree.parent as usize);
            put_ball(&mut row.parent, -1.0, body, row.r_parent);
        }
        *self.tree.rows.row(i) = row;
    }

    /// Applies the impulses of the last step along the current rows.
    fn warm_start(&self, tree: &Tree) {
        let h = f64::from(self.ctx.h);
        for (i, joint) in self.tree_joints(tree) {
            let row = self.tree.rows.read(i);
            let child = self.tree.bodies.row(joint.child as usize);
            child.stiffen(h, row.impulse, row.r_child);
            push(&mut child.x, &row.child, &row.lambda, row.all());
            if joint.parent != NONE {
                let parent = self.tree.bodies.row(joint.parent as usize);
                parent.stiffen(h, -row.impulse, row.r_parent);
                push(&mut parent.x, &row.parent, &row.lambda, row.all());
            }
        }
        for i in tree.bodies.clone() {
            let body = self.tree.bodies.row(i);
            let x = body.x;
            body.begin();
            body.x = x;
            factor(&mut body.h, 6);
            forward(&body.h, &mut body.x, 6);
            backward(&body.h, &mut body.x, 6);
            let solver_body = self.body.solver_bodies.read(body.solver_row as usize);
            body.u = wide(solver_body.v, solver_body.w);
            self.put_velocity(body);
        }
    }

    /// Writes the velocities, including the change by joints, to the solver body.
    #[expect(clippy::cast_possible_truncation, reason = "rounding is what is asked for")]
    fn put_velocity(&self, body: &mut TreeBody) {
        let solver_body = self.body.solver_bodies.row(body.solver_row as usize);
        for i in 0..3 {
            solver_body.v[i] = (body.u[i] + body.x[i]) as f32;
            solver_body.w[i] = (body.u[3 + i] + body.x[3 + i]) as f32;
        }
        body.carried = body.x;
    }

    /// Solves the trees of a group.
    pub(crate) fn sweep_trees(&self, group: &Group, joints: &JointSweep, jobs: &Jobs<'_>) {
        let soft = self.ctx.soft_tree;
        // Without bias, a remaining compliance is needed for joints that contradict each other.
        let (rate, part) = if joints.is_relax { (0.0, RELAX) } else { (soft.rate, 1.0) };
        let sweep = TreeSweep {
            h: f64::from(self.ctx.h),
            rate: f64::from(rate),
            compliance: part * f64::from(soft.compliance),
            // Rows at the current positions. At a substep of 1/60 s and 1000:1, rows at the middle
            // of the substep's motion, as single joints use, made a chain fly apart.
            elapsed: f64::from(joints.elapsed + joints.back),
            push_speed: f64::from(self.ctx.push_speed),
            joints: JointSweep { hardest: self.ctx.hardest_in_trees, ..*joints },
        };
        let forest = &self.plan.forest;
        let order = &forest.order[group.trees.clone()];
        for_ranges(jobs, order.len(), 1, |part| {
            for tree in &order[part] {
                self.sweep_tree(&forest.trees[*tree as usize], &sweep);
            }
        });
    }

    fn sweep_tree(&self, tree: &Tree, sweep: &TreeSweep) {
        let mut mass = 0.0;
        for i in tree.bodies.clone() {
            let body = self.tree.bodies.row(i);
            mass += 1.0 / (body.alpha * body.alpha);
            let solver_body = self.body.solver_bodies.read(body.solver_row as usize);
            let (v, x) = (wide(solver_body.v, solver_body.w), wide(solver_body.x, solver_body.t));
            let [start_v, start_w] = self.body.aux.read(body.solver_row as usize).start();
            (body.motion, body.start) = (x, wide(start_v, start_w));
            for c in 0..6 {
                body.u[c] = if sweep.joints.is_relax { v[c] } else { v[c] - body.carried[c] };
            }
            if !sweep.joints.is_relax {
                body.turning = 0.0;
            }
        }
        let compliance = sweep.compliance * tree.slack / mass;
        for (i, joint) in self.tree_joints(tree) {
            let row = self.tree.rows.row(i);
            if joint.six_dof == NONE {
                self.form_rows(joint, row, sweep, compliance);
            } else {
                self.form_six_dof(joint, row, Some(sweep), compliance);
            }
        }
        for i in tree.bodies.clone() {
            self.tree.bodies.row(i).begin();
        }
        if !sweep.joints.is_relax {
            self.push_scalars(tree);
        }
        self.factor_tree(tree);
        self.substitute(tree);
        for (i, _) in self.tree_joints(tree) {
            let row = self.tree.rows.row(i);
            for c in 0..row.count {
                row.lambda[c] =
                    if sweep.joints.is_relax { row.lambda[c] + row.rhs[c] } else { row.rhs[c] };
            }
        }
        self.solve_scalars(tree, sweep);
        for (i, joint) in self.tree_joints(tree) {
            let row = self.tree.rows.row(i);
            if joint.six_dof == NONE {
                let [x, y, z, ..] = row.lambda;
                row.impulse = DVec3 { x, y, z };
            } else {
                row.note_six_dof(joint.is_child_a);
            }
        }
        for i in tree.bodies.clone() {
            let body = self.tree.bodies.row(i);
            let before = body.carried;
            self.put_velocity(body);
            if sweep.joints.is_relax {
                for c in 0..6 {
                    body.carried[c] += before[c];
                }
            }
        }
    }

    /// Scales the impulses of a tree by `part`.
    pub(crate) fn restrain_tree(&self, tree: &Tree, part: f64) {
        // NaN stays NaN under multiplication, so a factor of 0 needs its own case.
        let is_some = part > 0.0;
        let taken = |six_dof: &Vec6| if is_some { six_dof.map(|p| p * part) } else { [0.0; 6] };
        for i in tree.bodies.clone() {
            let body = self.tree.bodies.row(i);
            body.carried = taken(&body.carried);
        }
        for i in tree.joints.clone() {
            let row = self.tree.rows.row(i);
            row.lambda = taken(&row.lambda);
            row.impulse = if is_some { row.impulse * part } else { DVec3::ZERO };
            row.six_dof.restrain(part);
        }
    }

    /// Eliminates joints and bodies from the leaves to the root.
    fn factor_tree(&self, tree: &Tree) {
        for (i, joint) in self.tree_joints(tree) {
            let (row, body) = (self.tree.rows.row(i), self.tree.bodies.row(joint.child as usize));
            if joint.parent == NONE {
                of_rows!(row.count, n => {
                    row.factor(None, n);
                    body.take(row, n);
                });
            } else {
                factor(&mut body.h, 6);
                let parent = self.tree.bodies.row(joint.parent as usize);
                of_rows!(row.count, n => {
                    row.factor(Some(body), n);
                    parent.take(row, n);
                });
            }
        }
        factor(&mut self.tree.bodies.row(tree.bodies.end - 1).h, 6);
    }

    /// Solves for the right sides in the bodies' `x` and the joints' `rhs`: these become changes of
    /// velocity and impulses.
    pub(crate) fn substitute(&self, tree: &Tree) {
        for (i, joint) in self.tree_joints(tree) {
            let (row, body) = (self.tree.rows.row(i), self.tree.bodies.row(joint.child as usize));
            let mut below = None;
            let mut into = &mut body.x;
            if joint.parent != NONE {
                forward(&body.h, &mut body.x, 6);
                below = Some(&body.x);
                into = &mut self.tree.bodies.row(joint.parent as usize).x;
            }
            of_rows!(row.count, n => {
                row.reduce(below, n);
                push(into, &row.w, &row.rhs, n);
            });
        }
        let root = self.tree.bodies.row(tree.bodies.end - 1);
        forward(&root.h, &mut root.x, 6);
        backward(&root.h, &mut root.x, 6);
        for (i, joint) in self.tree_joints(tree).rev() {
            let (row, body) = (self.tree.rows.row(i), self.tree.bodies.row(joint.child as usize));
            if joint.parent == NONE {
                of_rows!(row.count, n => row.solve(true, &body.x, n));
                continue;
            }
            let x = &self.tree.bodies.read(joint.parent as usize).x;
            of_rows!(row.count, n => row.solve(false, x, n));
            // At this point the body's x is still H^-1/2 of its right side.
            let mut more = [0.0; 6];
            push(&mut more, &row.child, &row.rhs, row.count);
            forward(&body.h, &mut more, 6);
            for c in 0..6 {
                body.x[c] += more[c];
            }
            backward(&body.h, &mut body.x, 6);
        }
    }

    /// Builds a joint's rows, matrix and right side, and the stiffness that it adds to its bodies.
    fn form_rows(&self, joint: &TreeJoint, row: &mut TreeRow, sweep: &TreeSweep, compliance: f64) {
        let child = self.tree.bodies.row(joint.child as usize);
        let (x, t) = halves(&child.motion);
        let moved = shift(mul(&child.s, t), row.r_child);
        let r = row.r_child + moved;
        let mut gap = row.gap + row.drift * sweep.elapsed + x * child.alpha + moved;
        put_ball(&mut row.child, 1.0, child, r);
        let u = &child.u;
        let mut speed = row.drift
            + DVec3 {
                x: dot(&row.child[0], u),
                y: dot(&row.child[1], u),
                z: dot(&row.child[2], u),
            };
        if !sweep.joints.is_relax {
            speed = speed + curve(mul(&child.s, halves(&child.u).1), r, sweep.h);
            child.stiffen(sweep.h, row.impulse, r);
        }
        if joint.parent != NONE {
            let parent = self.tree.bodies.row(joint.parent as usize);
            let (x, t) = halves(&parent.motion);
            let moved = shift(mul(&parent.s, t), row.r_parent);
            let r = row.r_parent + moved;
            gap = gap - x * parent.alpha - moved;
            put_ball(&mut row.parent, -1.0, parent, r);
            let u = &parent.u;
            speed = speed
                + DVec3 {
                    x: dot(&row.parent[0], u),
                    y: dot(&row.parent[1], u),
                    z: dot(&row.parent[2], u),
                };
            if !sweep.joints.is_relax {
                speed = speed - curve(mul(&parent.s, halves(&parent.u).1), r, sweep.h);
                parent.stiffen(sweep.h, -row.impulse, r);
            }
        }
        let rate = sweep.closing_rate(gap.length(), sweep.push_speed, 0);
        row.closing = [gap.length() * rate, 0.0];
        let wanted = -(speed + gap * rate);
        row.rhs = [wanted.x, wanted.y, wanted.z, 0.0, 0.0, 0.0];
        for i in 0..3 {
            row.k[i] = [0.0; 6];
            row.k[i][i] = compliance;
        }
    }

    /// Writes the impulses of a group's trees back; those of six-axis joints go to their blocks.
    pub(crate) fn store_trees(&self, group: &Group) {
        for tree in self.trees(group) {
            for (i, joint) in self.tree_joints(tree) {
                let Some(to) = self.joint_slots.row(joint.row as usize) else { continue };
                let row = self.tree.rows.read(i);
                if joint.six_dof != NONE {
                    row.store_six_dof(
                        self.joint.six_dof.row(joint.six_dof as usize / LANES),
                        joint.six_dof,
                    );
                } else {
                    let impulse = (row.impulse.single() * self.ctx.store_scale()).bounded();
                    to.impulse = if joint.is_child_a { -impulse } else { impulse };
                }
            }
        }
    }
}
