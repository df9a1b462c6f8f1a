//! Six-axis joints in trees: rows of locked axes, drives and limits. Algebra: tree/sweep.rs.
//!
//! Drives and limits come after the locked axes of all joints, by the laws of
//! joint/six_dof/drive.rs, each through the whole tree. The inverse mass of a drive is the tree's
//! response to a unit impulse of it, computed with the available factors. So the mass at a
//! shoulder's hinge is that of the arm with its whole load.
//!
//! The responses of all to all form a small matrix, on which drives and limits are solved in
//! rounds. n of them cost n + 1 substitutions per step and one per sweep. Angles are held as softly
//! as by a spring on the inertia of the whole tree.

use fearless_simd::{SimdBase, dispatch};

use super::rows::{TreeBody, TreeRow, TreeSweep};
use crate::base::double::{DVec3, greater};
use crate::base::simd::wide::{LANES, Lanes, put, splat};
use crate::state::bodies::NONE;
use crate::step::solver::joint::six_dof::block::SixDofBlock;
use crate::step::solver::joint::six_dof::placed::{AxisState, act};
use crate::step::solver::lent::Solver;
use crate::step::solver::plan::forest::{Tree, TreeJoint};
use crate::step::solver::vec6::{Vec6, curve, dot, halves, mul, shift};

/// Maximum rounds over the drives and limits of a tree in a sweep; they start from the impulses of
/// the last sweep.
const MAX_ROUNDS: usize = 32;

/// Rounds end when no row changes its speed by more than this [m/s; rad/s].
const SETTLED: f64 = 1.0e-6;

/// The vector of one of eight joints.
fn vector(lanes: &[Lanes; 3], lane: usize) -> DVec3 {
    let [x, y, z] = lanes;
    DVec3 { x: f64::from(x[lane]), y: f64::from(y[lane]), z: f64::from(z[lane]) }
}

/// Total impulse of drive, friction and limit.
fn whole(acting: [f32; 3]) -> f64 {
    acting.into_iter().map(f64::from).sum()
}

/// A body of the joint in this sweep.
struct Side<'a> {
    body: &'a TreeBody,
    /// Translation and rotation in the step so far.
    moved: DVec3,
    turn: DVec3,
    /// Lever arm at the step's start, and its displacement since.
    start: DVec3,
    shift: DVec3,
    /// Angular velocity of a kinematic body.
    spin: DVec3,
}

impl<'a> Side<'a> {
    fn new(body: &'a TreeBody, start: DVec3, spin: DVec3, elapsed: f64) -> Self {
        let (x, t) = halves(&body.motion);
        let turn = mul(&body.s, t) + spin * elapsed;
        Self { body, moved: x * body.alpha, turn, start, shift: shift(turn, start), spin }
    }

    fn spins(&self) -> DVec3 {
        mul(&self.body.s, halves(&self.body.u).1) + self.spin
    }

    /// The row of a translation along `u` at the lever arm `r`, and of a rotation about `n`.
    fn along(&self, sign: f64, u: DVec3, r: DVec3) -> Vec6 {
        let (v, w) = (u * (sign * self.body.alpha), mul(&self.body.s, r.cross(u)) * sign);
        [v.x, v.y, v.z, w.x, w.y, w.z]
    }

    fn about(&self, sign: f64, n: DVec3) -> Vec6 {
        let w = mul(&self.body.s, n) * sign;
        [0.0, 0.0, 0.0, w.x, w.y, w.z]
    }
}

impl Solver<'_> {
    /// Compliance of rotations over that of translations [1/m²]. The squared radius of gyration of
    /// a tree is the inertia about its center over its mass.
    pub(crate) fn turn_ease(&self, tree: &Tree) -> f64 {
        let bodies = || {
            tree.bodies.clone().map(|i| {
                let body = self.tree.bodies.read(i);
                let center = self.at_start(self.plan.forest.bodies[i]).center;
                let own = (0..3).fold(0.0, |sum, i| sum + body.s[i].dot(body.s[i]));
                let inertia = if own > 0.0 { 3.0 / own } else { 0.0 };
                (1.0 / (body.alpha * body.alpha), DVec3::from(center), inertia)
            })
        };
        let (mut mass, mut moment) = (0.0, DVec3::ZERO);
        for (m, center, _) in bodies() {
            (mass, moment) = (mass + m, moment + center * m);
        }
        let center = moment * (1.0 / mass);
        let mut inertia = 0.0;
        for (m, at, own) in bodies() {
            let r = at - center;
            inertia += own + m * r.dot(r);
        }
        if inertia > 0.0 { mass / inertia } else { 1.0 }
    }

    /// Prepares the rows of a six-axis joint, with the impulses of the last step.
    pub(crate) fn prepare_tree_six_dof(&self, tree: &TreeJoint, row: &mut TreeRow, ease: f64) {
        *row = TreeRow::default();
        row.six_dof.ease = ease;
        self.form_six_dof(tree, row, None, 0.0);
        let (block, lane) = self.six_dof_of(tree);
        for i in 0..row.all() {
            let axis = row.six_dof.axes[i];
            let acting =
                [&block.lock_or_drive, &block.friction, &block.limit].map(|of| of[axis][lane]);
            row.six_dof.acting[axis] = acting;
            row.lambda[i] = whole(acting);
        }
        row.note_six_dof(tree.is_child_a);
    }

    fn six_dof_of(&self, tree: &TreeJoint) -> (&SixDofBlock, usize) {
        (self.joint.six_dof.read(tree.six_dof as usize / LANES), tree.six_dof as usize % LANES)
    }

    /// Applies the impulses of drives and limits in the last substep to the bodies.
    pub(crate) fn push_scalars(&self, tree: &Tree) {
        for (i, joint) in self.tree_joints(tree) {
            let row = self.tree.rows.read(i);
            for k in row.count..row.all() {
                self.push_row(joint, row, k, row.lambda[k]);
            }
        }
    }

    /// Adds an impulse of one row to the right sides `x` of the bodies.
    fn push_row(&self, joint: &TreeJoint, row: &TreeRow, k: usize, p: f64) {
        let child = self.tree.bodies.row(joint.child as usize);
        for c in 0..6 {
            child.x[c] += row.child[k][c] * p;
        }
        if joint.parent != NONE {
            let parent = self.tree.bodies.row(joint.parent as usize);
            for c in 0..6 {
                parent.x[c] += row.parent[k][c] * p;
            }
        }
    }

    /// Solves the tree for the right sides in the bodies' `x`, with zero gaps.
    fn respond(&self, tree: &Tree) {
        for (i, _) in self.tree_joints(tree) {
            self.tree.rows.row(i).rhs = [0.0; 6];
        }
        self.substitute(tree);
    }

    fn clear(&self, tree: &Tree) {
        for i in tree.bodies.clone() {
            self.tree.bodies.row(i).x = [0.0; 6];
        }
    }

    /// Rate of a row's coordinate at the bodies' velocities `of`.
    fn rate(
        &self,
        joint: &TreeJoint,
        row: &TreeRow,
        k: usize,
        of: impl Fn(&TreeBody) -> &Vec6,
    ) -> f64 {
        let mut rate = dot(&row.child[k], of(self.tree.bodies.read(joint.child as usize)));
        if joint.parent != NONE {
            rate += dot(&row.parent[k], of(self.tree.bodies.read(joint.parent as usize)));
        }
        rate
    }

    /// Solves drives and limits one after another, in rounds, each as if the whole tree held
    /// exactly. The inverse mass of each is the tree's response to its own impulse, and the
    /// response acts on the others. The total impulse then passes through the tree once.
    pub(crate) fn solve_scalars(&self, tree: &Tree, sweep: &TreeSweep) {
        let n = tree.scalars;
        if n == 0 {
            return;
        }
        for i in tree.bodies.clone() {
            let body = self.tree.bodies.row(i);
            body.sum = body.x;
        }
        if !sweep.joints.is_relax && sweep.elapsed == 0.0 {
            self.find_gains(tree);
        }
        for (i, joint) in self.tree_joints(tree) {
            let row = self.tree.rows.row(i);
            for k in row.count..row.all() {
                row.six_dof.start[k] =
                    row.six_dof.speed[k] + self.rate(joint, row, k, |body| &body.start);
                row.six_dof.speed[k] += self.rate(joint, row, k, |body| &body.u)
                    + self.rate(joint, row, k, |body| &body.sum);
                row.six_dof.given[k] = -row.lambda[k];
            }
        }
        let gains = self.tree.gains.slice(tree.gains.clone());
        for _ in 0..MAX_ROUNDS {
            if self.round(tree, gains, sweep) < SETTLED {
                break;
            }
        }
        self.clear(tree);
        for (i, joint) in self.tree_joints(tree) {
            let row = self.tree.rows.row(i);
            for k in row.count..row.all() {
                row.six_dof.given[k] += row.lambda[k];
                self.push_row(joint, row, k, row.six_dof.given[k]);
            }
        }
        self.respond(tree);
        for (i, _) in self.tree_joints(tree) {
            let row = self.tree.rows.row(i);
            for c in 0..row.count {
                row.lambda[c] += row.rhs[c];
            }
        }
        for i in tree.bodies.clone() {
            let body = self.tree.bodies.row(i);
            for c in 0..6 {
                body.x[c] += body.sum[c];
            }
        }
    }

    /// Computes the responses of drives and limits to each other. They are computed at the step's
    /// start and serve the whole step. The impulses of a sweep differ little from those of the last
    /// one, and that difference passes through the tree in its current state.
    fn find_gains(&self, tree: &Tree) {
        let (n, gains) = (tree.scalars, self.tree.gains.slice(tree.gains.clone()));
        let mut of = 0;
        for (i, joint) in self.tree_joints(tree) {
            for k in self.tree.rows.read(i).count..self.tree.rows.read(i).all() {
                self.clear(tree);
                self.push_row(joint, self.tree.rows.read(i), k, 1.0);
                self.respond(tree);
                self.answers(tree, &mut gains[of * n..(of + 1) * n]);
                of += 1;
            }
        }
    }

    /// The rate of each drive and limit at the bodies' `x`.
    fn answers(&self, tree: &Tree, out: &mut [f64]) {
        let mut to = 0;
        for (i, joint) in self.tree_joints(tree) {
            let row = self.tree.rows.read(i);
            for k in row.count..row.all() {
                out[to] = self.rate(joint, row, k, |body| &body.x);
                to += 1;
            }
        }
    }

    /// Solves each drive and limit once; returns the maximum change of a speed.
    fn round(&self, tree: &Tree, gains: &[f64], sweep: &TreeSweep) -> f64 {
        let n = tree.scalars;
        let (mut of, mut greatest) = (0, 0.0);
        for (i, joint) in self.tree_joints(tree) {
            for k in self.tree.rows.read(i).count..self.tree.rows.read(i).all() {
                let gains = &gains[of * n..(of + 1) * n];
                let own = gains[of];
                of += 1;
                let given = self.solve_scalar(joint, self.tree.rows.row(i), k, own, sweep);
                if given == 0.0 {
                    continue;
                }
                greatest = greater((given * own).abs(), greatest);
                let mut to = 0;
                for (i, _) in self.tree_joints(tree) {
                    let row = self.tree.rows.row(i);
                    for k in row.count..row.all() {
                        row.six_dof.speed[k] += gains[to] * given;
                        to += 1;
                    }
                }
            }
        }
        greatest
    }

    /// Solves a drive and limit of inverse mass `give`; returns the change of its impulse.
    #[expect(clippy::cast_possible_truncation, reason = "rounding is what is asked for")]
    fn solve_scalar(
        &self,
        joint: &TreeJoint,
        row: &mut TreeRow,
        k: usize,
        give: f64,
        sweep: &TreeSweep,
    ) -> f64 {
        // For a rotation that the tree excludes completely, the remainder is rounding error.
        let own = dot(&row.child[k], &row.child[k]) + dot(&row.parent[k], &row.parent[k]);
        let give = if give > own * 1.0e-9 { give } else { 0.0 };
        let axis = row.six_dof.axes[k];
        let old = row.six_dof.acting[axis];
        let felt = [give, row.six_dof.place[k], row.six_dof.speed[k], row.six_dof.start[k]]
            .map(|x| x as f32);
        let (block, lane) = self.six_dof_of(joint);
        let new = dispatch!(self.ctx.level, simd => {
            let [k, x, v, start] = felt;
            let felt = AxisState {
                k: splat(simd, k),
                x: splat(simd, x),
                v: splat(simd, v),
                start: splat(simd, start),
            };
            let old = old.map(|p| splat(simd, p));
            act(simd, block, axis, old, felt, &sweep.joints).map(|new| {
                let mut lanes = [0.0; LANES];
                new.store_array(&mut lanes);
                lanes[lane]
            })
        });
        row.six_dof.acting[axis] = new;
        let given = whole(new) - row.lambda[k];
        row.lambda[k] = whole(new);
        given
    }

    /// Builds a joint's rows, matrix and right side, and the stiffness that it adds to its bodies.
    /// Without a sweep, builds the rows alone, at the step's start.
    pub(crate) fn form_six_dof(
        &self,
        joint: &TreeJoint,
        row: &mut TreeRow,
        sweep: Option<&TreeSweep>,
        compliance: f64,
    ) {
        let world = TreeBody::default();
        let child = self.tree.bodies.row(joint.child as usize);
        let mut parent = &world;
        let stiff = sweep.filter(|sweep| !sweep.joints.is_relax);
        if let Some(sweep) = stiff {
            child.stiffen(sweep.h, row.impulse, row.r_child);
        }
        if joint.parent != NONE {
            let body = self.tree.bodies.row(joint.parent as usize);
            if let Some(sweep) = stiff {
                body.stiffen(sweep.h, -row.impulse, row.r_parent);
            }
            parent = body;
        }
        let (a, b) = if joint.is_child_a { (&*child, parent) } else { (parent, &*child) };
        let (block, lane) = self.six_dof_of(joint);
        let elapsed = sweep.map_or(0.0, |sweep| sweep.elapsed);
        let now = Now::new(block, lane, [a, b], elapsed);
        (row.r_child, row.r_parent) =
            if joint.is_child_a { (now.arm_a, now.arm_b) } else { (now.arm_b, now.arm_a) };
        let bend = stiff.map_or(DVec3::ZERO, |sweep| now.bend(sweep.h));
        now.form(block, lane, joint.is_child_a, bend, row);
        let Some(sweep) = sweep else { return };
        row.k = [[0.0; 6]; 6];
        row.closing = [0.0; 2];
        for i in 0..row.count {
            let axis = row.six_dof.axes[i];
            let x = row.six_dof.place[i] - f64::from(block.place[axis][lane]);
            let speed = row.six_dof.speed[i]
                + dot(&row.child[i], &child.u)
                + dot(&row.parent[i], &parent.u);
            let is_motion = axis < 3;
            let fastest =
                if is_motion { sweep.push_speed } else { f64::from(sweep.joints.caps.push(axis)) };
            let rate = sweep.closing_rate(greater(x, -x), fastest, axis);
            row.closing[axis / 3] = greater((x * rate).abs(), row.closing[axis / 3]);
            row.rhs[i] = -(speed + x * rate);
            row.k[i][i] = if is_motion { compliance } else { compliance * row.six_dof.ease };
        }
    }
}

/// A joint in a sweep.
struct Now<'a> {
    a: Side<'a>,
    b: Side<'a>,
    arm_a: DVec3,
    arm_b: DVec3,
    /// Anchor B less anchor A, rotation of B less that of A, velocities of kinematic bodies.
    gap: DVec3,
    turn: DVec3,
    drift: DVec3,
}

impl<'a> Now<'a> {
    fn new(block: &SixDofBlock, lane: usize, [a, b]: [&'a TreeBody; 2], elapsed: f64) -> Self {
        let a = Side::new(a, vector(&block.r_a, lane), vector(&block.spin_a, lane), elapsed);
        let b = Side::new(b, vector(&block.r_b, lane), vector(&block.spin_b, lane), elapsed);
        let drift = vector(&block.drift, lane);
        // Add displacements only: lever arms of meters would round away the gap.
        let moved = b.moved - a.moved + drift * elapsed + (b.shift - a.shift);
        let gap = vector(&block.gap, lane) + moved;
        let (arm_a, arm_b) = (a.start + a.shift + gap, b.start + b.shift);
        let turn = b.turn - a.turn - a.turn.cross(b.turn) * 0.5;
        let drift = drift + b.spin.cross(arm_b) - a.spin.cross(arm_a);
        Self { a, b, arm_a, arm_b, gap, turn, drift }
    }

    /// Contribution of rotation in a substep of `h` to the gap's mean speed.
    fn bend(&self, h: f64) -> DVec3 {
        let Self { a, b, arm_a, arm_b, .. } = self;
        let (wa, wb) = (a.spins(), b.spins());
        let v = |side: &Side<'_>| halves(&side.body.u).0 * side.body.alpha;
        let slip =
            v(b) - v(a) + self.drift + (wb - b.spin).cross(*arm_b) - (wa - a.spin).cross(*arm_a);
        curve(wb, *arm_b, h) - curve(wa, *arm_a, h) - wa.cross(slip) * h
    }

    /// Builds the rows of locked axes, then the rows of driven or limited axes.
    fn form(
        &self,
        block: &SixDofBlock,
        lane: usize,
        is_child_a: bool,
        bend: DVec3,
        row: &mut TreeRow,
    ) {
        let (a, b) = (&self.a, &self.b);
        let mut n = 0;
        for wants_locked in [true, false] {
            for axis in 0..6 {
                let (i, is_motion) = (axis % 3, axis < 3);
                let is_locked = block.locked[axis][lane] > 0.0;
                let acts = block.acts[axis / 3];
                if is_locked != wants_locked || !(is_locked || acts) {
                    continue;
                }
                let start = vector(if is_motion { &block.u[i] } else { &block.n[i] }, lane);
                let now = start + shift(a.turn, start);
                let (on_a, on_b) = if is_motion {
                    let drift = if is_locked { self.drift + bend } else { self.drift };
                    row.six_dof.place[n] = now.dot(self.gap);
                    row.six_dof.speed[n] = now.dot(drift);
                    (a.along(-1.0, now, self.arm_a), b.along(1.0, now, self.arm_b))
                } else {
                    row.six_dof.place[n] = f64::from(block.angles[i][lane]) + start.dot(self.turn);
                    row.six_dof.speed[n] = now.dot(b.spin - a.spin);
                    (a.about(-1.0, now), b.about(1.0, now))
                };
                (row.child[n], row.parent[n]) =
                    if is_child_a { (on_a, on_b) } else { (on_b, on_a) };
                (row.six_dof.axes[n], row.six_dof.along[n]) = (axis, now);
                n += 1;
            }
            if wants_locked {
                row.count = n;
            }
        }
        row.six_dof.scalars = n - row.count;
    }
}

impl TreeRow {
    /// Number of rows including drives and limits.
    pub(crate) fn all(&self) -> usize {
        self.count + self.six_dof.scalars
    }

    /// Stores the total force and torque of the rows' impulses.
    pub(crate) fn note_six_dof(&mut self, is_child_a: bool) {
        let (mut force, mut torque) = (DVec3::ZERO, DVec3::ZERO);
        for i in 0..self.all() {
            let p = self.six_dof.along[i] * self.lambda[i];
            if self.six_dof.axes[i] < 3 {
                force = force + p;
            } else {
                torque = torque + p;
            }
        }
        (self.six_dof.force, self.six_dof.torque) = (force, torque);
        self.impulse = if is_child_a { -force } else { force };
    }

    /// Writes the total force and torque to a block and lane.
    pub(crate) fn put_six_dof(&self, block: &mut SixDofBlock, place: u32) {
        let lane = place as usize % LANES;
        put(&mut block.carried, lane, self.six_dof.force.single());
        put(&mut block.torque, lane, self.six_dof.torque.single());
    }

    /// Writes the impulses to the block and lane of a six-axis joint.
    #[expect(clippy::cast_possible_truncation, reason = "rounding is what is asked for")]
    pub(crate) fn store_six_dof(&self, block: &mut SixDofBlock, place: u32) {
        let (six_dof, lane) = (&self.six_dof, place as usize % LANES);
        for i in 0..self.all() {
            let axis = six_dof.axes[i];
            let is_held = i < self.count;
            let acting =
                if is_held { [self.lambda[i] as f32, 0.0, 0.0] } else { six_dof.acting[axis] };
            block.lock_or_drive[axis][lane] = acting[0];
            block.friction[axis][lane] = acting[1];
            block.limit[axis][lane] = acting[2];
        }
        self.put_six_dof(block, place);
    }
}
