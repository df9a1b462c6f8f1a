//! Builds the blocks of ball and distance joints, runs their sweeps and stores their impulses.

use fearless_simd::{Simd, SimdBase, dispatch};

use super::ball_distance;
use super::ball_distance::Ahead;
use super::block::{JointBlock, JointExtra};
use super::root::Roundw;
use super::sweep::JointSweep;
use crate::base::math::{Vec3, vec3};
use crate::base::simd::wide::{LANES, Sym3w, Vec3w, at, put};
use crate::base::simd::wide_quat::Quatw;
use crate::base::threads::jobs::{Jobs, for_shares};
use crate::state::bodies::NONE;
use crate::state::joints::{Joint, JointModel};
use crate::step::context::softness::Softness;
use crate::step::solver::body::state::BodyState;
use crate::step::solver::lent::Solver;
use crate::step::solver::plan::group::Group;
use crate::step::solver::plan::joint_class::DISTANCE;
use crate::step::solver::plan::layout::{Batch, Layout};
use crate::step::solver_body::{Whitening, four, load_velocity, read_lanes, store_velocity};

impl Solver<'_> {
    pub(crate) fn prepare_joints(&self, group: &Group, jobs: &Jobs<'_>) {
        self.plan.joints.for_blocks(&group.joints, jobs, 8, |batch, blocks| {
            dispatch!(self.ctx.level, simd => {
                for i in blocks {
                    self.prefetch_joints(&self.plan.joints, i + 1);
                    self.pack_joints(simd, i, batch);
                }
            });
        });
        self.prepare_six_dof(group, jobs);
    }

    pub(crate) fn sweep_joints(&self, group: &Group, sweep: &JointSweep, jobs: &Jobs<'_>) {
        self.plan.joints.for_blocks(&group.joints, jobs, 8, |batch, blocks| {
            dispatch!(self.ctx.level, simd => {
                for i in blocks {
                    let (block, extra) = (self.joint.blocks.row(i), self.joint.extras.row(i));
                    let next = Ahead { block: self.joint.blocks.after(i), extra: self.joint.extras.after(i) };
                    if block.is_empty() {
                        continue;
                    }
                    let (fixed, solver_bodies) = (batch.fixed, &self.body.solver_bodies);
                    if batch.class == DISTANCE {
                        ball_distance::solve_distance(simd, (block, extra), next, fixed, solver_bodies, sweep);
                    } else if block.is_round() {
                        ball_distance::solve_ball::<_, Roundw<_>>(simd, (block, extra), next, fixed, solver_bodies, sweep);
                    } else {
                        ball_distance::solve_ball::<_, Sym3w<_>>(simd, (block, extra), next, fixed, solver_bodies, sweep);
                    }
                }
            });
        });
    }

    /// Builds a block of joints and applies their impulses to the solver bodies.
    #[inline(always)]
    fn pack_joints<S: Simd>(&self, simd: S, i: usize, batch: &Batch) {
        let owners = &self.plan.joints.owners[i];
        let (block, extra) = (self.joint.blocks.row(i), self.joint.extras.row(i));
        let (mut raw, mut impulses) = (Raw::default(), [[0.0; 4]; LANES]);
        self.read_joints(owners, block, &mut raw, &mut impulses);
        let (ra, rb) = (raw.arm(simd, 0), raw.arm(simd, 1));
        let impulse = Vec3w::of_rows(simd, &impulses);
        let gap = raw.between(simd) + (rb - ra);
        ra.store(&mut block.r_a);
        rb.store(&mut block.r_b);
        gap.store(&mut block.gap);
        impulse.store(&mut block.impulse);
        let (alpha, sa) = Whitening::gather(simd, read_lanes(&self.body.whitening, &block.row_a));
        let (beta, sb) = Whitening::gather(simd, read_lanes(&self.body.whitening, &block.row_b));
        alpha.store_array(&mut block.alpha);
        beta.store_array(&mut block.beta);
        // Distances have no separate kernel for bodies with scalar inertia.
        if batch.class != DISTANCE && sa.is_round(simd) && sb.is_round(simd) {
            sa.xx.store_array(&mut block.round[0]);
            sb.xx.store_array(&mut block.round[1]);
        } else {
            block.round[0][0] = -1.0;
            sa.store(&mut extra.s_a);
            sb.store(&mut extra.s_b);
        }
        if batch.fixed {
            self.fill_drift(owners, extra);
        }
        // The linear impulse: along the gap for a distance, in world axes for a ball.
        let linear = if batch.class == DISTANCE {
            self.fill_distances(owners, block, extra);
            Vec3w::load(simd, &extra.carried)
        } else {
            impulse
        };
        let (da, db) = (ra.cross(linear), rb.cross(linear));
        da.store(&mut block.carried_a);
        db.store(&mut block.carried_b);
        let mut a = load_velocity(simd, &self.body.solver_bodies, &block.row_a);
        (a.v, a.w) = (a.v - linear * alpha, a.w - sa.mul(da));
        store_velocity(simd, &self.body.solver_bodies, &block.row_a, a);
        let mut b = load_velocity(simd, &self.body.solver_bodies, &block.row_b);
        (b.v, b.w) = (b.v + linear * beta, b.w + sb.mul(db));
        store_velocity(simd, &self.body.solver_bodies, &block.row_b, b);
    }

    /// Prefetches the joints of a block, if there is such a block.
    #[inline(always)]
    pub(crate) fn prefetch_joints(&self, of: &Layout, block: usize) {
        for &owner in of.owners.get(block).into_iter().flatten() {
            if owner != NONE {
                self.joint_slots.prefetch(owner as usize, size_of::<Joint>() / 64);
            }
        }
    }

    /// The joint in a row; none for [`NONE`].
    #[inline(always)]
    pub(crate) fn joint(&self, row: u32) -> Option<&Joint> {
        if row == NONE { None } else { self.joint_slots.read(row as usize).as_ref() }
    }

    /// Reads the joints of a block, their bodies' states, impulses and solver bodies. Lanes without
    /// a joint stay 0, and so do those of pendulums: their motion is complete.
    fn read_joints(
        &self,
        owners: &[u32; LANES],
        block: &mut JointBlock,
        raw: &mut Raw,
        impulses: &mut [[f32; 4]; LANES],
    ) {
        for (lane, row) in owners.iter().enumerate() {
            let solver_rows = if self.swing(*row) {
                [0; 2]
            } else if let Some(joint) = self.joint(*row) {
                raw.put(0, lane, joint.anchor_a, &self.at_start(joint.body_a));
                raw.put(1, lane, joint.anchor_b, &self.at_start(joint.body_b));
                impulses[lane] = four(joint.impulse * self.ctx.impulse_scale);
                [
                    self.body.solver_row_of[joint.body_a as usize],
                    self.body.solver_row_of[joint.body_b as usize],
                ]
            } else {
                [0; 2]
            };
            [block.row_a[lane], block.row_b[lane]] = solver_rows;
        }
    }

    /// Records the speed at which kinematic bodies move the anchors apart.
    fn fill_drift(&self, owners: &[u32; LANES], extra: &mut JointExtra) {
        let speed = |row: u32, anchor: Vec3| {
            let body = self.bodies.at(row);
            let moves = !body.is_dynamic() && body.active();
            let arm = || self.at_start(row).rotation.rotate(anchor);
            if moves { body.velocity_at(arm()) } else { Vec3::ZERO }
        };
        for (lane, row) in owners.iter().enumerate() {
            let joint = self.joint(*row);
            let drift = joint
                .map_or(Vec3::ZERO, |j| speed(j.body_b, j.anchor_b) - speed(j.body_a, j.anchor_a));
            put(&mut extra.drift, lane, drift);
        }
    }

    /// Fills limits, spring and linear impulse of distances.
    fn fill_distances(&self, owners: &[u32; LANES], block: &JointBlock, extra: &mut JointExtra) {
        for (lane, row) in owners.iter().enumerate() {
            let joint = self.joint(*row);
            let (mut limits, mut soft, mut linear) = (Vec3::ZERO, Vec3::ZERO, Vec3::ZERO);
            if let Some(Joint { model: JointModel::Distance { min, max, spring }, .. }) = joint {
                let [gap, impulse] = [at(&block.gap, lane), at(&block.impulse, lane)];
                limits = vec3(*min, *max, spring.map_or(0.0, |s| s.rest_length));
                soft = spring.map_or(Vec3::ZERO, |s| {
                    let soft = Softness::new(s.hertz, s.damping_ratio, self.ctx.h);
                    vec3(soft.rate, soft.mass, soft.impulse)
                });
                linear = gap.normalize_or(Vec3::Y) * (impulse.x - impulse.y + impulse.z);
            }
            put(&mut extra.limits, lane, limits);
            put(&mut extra.spring, lane, soft);
            put(&mut extra.carried, lane, linear);
        }
    }

    /// Writes the impulses of ball and distance joints back.
    pub(crate) fn store_joints(&self, group: &Group, jobs: &Jobs<'_>) {
        let blocks = self.plan.joints.blocks_of(&group.joints);
        for_shares(jobs, blocks.len(), 32, |part| {
            for i in blocks.start + part.start..blocks.start + part.end {
                self.prefetch_joints(&self.plan.joints, i + 1);
                self.store_one(i);
            }
        });
    }

    fn store_one(&self, block: usize) {
        let owners = &self.plan.joints.owners[block];
        let block = self.joint.blocks.read(block);
        for (lane, row) in owners.iter().enumerate() {
            if *row != NONE
                && block.is_solved(lane)
                && let Some(joint) = self.joint_slots.row(*row as usize)
            {
                joint.impulse = (at(&block.impulse, lane) * self.ctx.store_scale()).bounded();
            }
        }
    }
}

/// Eight joints and their bodies A and B, one row each.
#[derive(Default)]
pub(crate) struct Raw {
    centers: [[[f32; 4]; LANES]; 2],
    pub(crate) turns: [[[f32; 4]; LANES]; 2],
    anchors: [[[f32; 4]; LANES]; 2],
}

impl Raw {
    #[inline(always)]
    pub(crate) fn put(&mut self, side: usize, lane: usize, anchor: Vec3, body: &BodyState) {
        self.centers[side][lane] = four(body.center);
        self.turns[side][lane] = bytemuck::cast(body.rotation);
        self.anchors[side][lane] = four(anchor);
    }

    /// Lever arms from the centers of bodies A (`side` 0) or B (1) to the anchors [m, world].
    #[inline(always)]
    pub(crate) fn arm<S: Simd>(&self, simd: S, side: usize) -> Vec3w<S> {
        let anchor = Vec3w::of_rows(simd, &self.anchors[side]);
        Quatw::of_rows(simd, &self.turns[side]).rotate(simd, anchor)
    }

    /// Centers of B less those of A [m].
    #[inline(always)]
    pub(crate) fn between<S: Simd>(&self, simd: S) -> Vec3w<S> {
        let [a, b] = &self.centers;
        Vec3w::of_rows(simd, b) - Vec3w::of_rows(simd, a)
    }
}
