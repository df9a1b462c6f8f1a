//! Builds the blocks of six-axis joints, runs their sweeps and stores their impulses.

use fearless_simd::{Simd, SimdBase, dispatch};

use super::angles::Angles;
use super::block::SixDofBlock;
use super::kernel;
use crate::base::simd::wide::{
    LANES, Vec3w, Wide, above, bounded, gather4, load, min, prefetch, scatter4, select, splat, sqrt,
};
use crate::base::simd::wide_quat::Quatw;
use crate::base::threads::jobs::{Jobs, for_shares};
use crate::state::bodies::NONE;
use crate::state::joints::{Joint, JointModel};
use crate::state::six_dof::{FAR, Flags, SixDofLaws, SixDofState};
use crate::step::solver::joint::prepare::Raw;
use crate::step::solver::joint::sweep::JointSweep;
use crate::step::solver::lent::Solver;
use crate::step::solver::plan::group::Group;
use crate::step::solver::plan::joint_class::{
    SIX_ANCHORED, SIX_DIRECT, SIX_DOF_ACTS, SIX_DOF_LOCKS,
};
use crate::step::solver_body::{
    Velocity, Whitening, four, load_velocity, read_lanes, store_velocity,
};

/// Content of an idle lane.
static IDLE: (SixDofLaws, SixDofState) = (SixDofLaws::IDLE, SixDofState::IDLE);

/// Identity rotation.
const UNTURNED: [f32; 4] = [0.0, 0.0, 0.0, 1.0];

/// Rows of four numbers in a joint's stored state.
const ROWS: usize = size_of::<SixDofState>() / size_of::<[f32; 4]>();

/// Eight joints as stored in the tables.
struct Gathered<'a> {
    raw: Raw,
    laws: [&'a SixDofLaws; LANES],
    states: [&'a SixDofState; LANES],
    frames: [[&'a [f32; 4]; LANES]; 2],
    flags: Flags,
    /// Velocities and angular velocities of kinematic bodies, if there are any.
    driven: Option<[[[[f32; 4]; LANES]; 2]; 2]>,
}

impl Solver<'_> {
    pub(crate) fn prepare_six_dof(&self, group: &Group, jobs: &Jobs<'_>) {
        self.plan.six_dof.for_blocks(&group.six_dof, jobs, 8, |batch, blocks| {
            dispatch!(self.ctx.level, simd => {
                for i in blocks.clone() {
                    self.prefetch_six_dof(i, blocks.end);
                    self.pack_block(simd, i, batch.class);
                }
            });
        });
    }

    pub(crate) fn sweep_six_dof(&self, group: &Group, sweep: &JointSweep, jobs: &Jobs<'_>) {
        self.plan.six_dof.for_blocks(&group.six_dof, jobs, 4, |batch, blocks| {
            if batch.class & SIX_DIRECT != 0 {
                // Trees solve these.
                return;
            }
            dispatch!(self.ctx.level, simd => {
                for i in blocks {
                    kernel::solve(simd, self.joint.six_dof.row(i), (&self.body.solver_bodies, &self.body.aux), sweep);
                }
            });
        });
    }

    pub(crate) fn store_six_dof(&self, group: &Group, jobs: &Jobs<'_>) {
        let blocks = self.plan.six_dof.blocks_of(&group.six_dof);
        let n = blocks.len();
        for_shares(jobs, n, 32, |part| {
            dispatch!(self.ctx.level, simd => {
                for i in blocks.start + part.start..blocks.start + part.end {
                    self.store_block(simd, i);
                }
            });
        });
    }

    /// Builds a block of this class and applies its impulses to the solver bodies.
    #[inline(always)]
    fn pack_block<S: Simd>(&self, simd: S, block: usize, class: u8) {
        let owners = &self.plan.six_dof.owners[block];
        let block = self.joint.six_dof.row(block);
        block.locks = SIX_DOF_LOCKS.map(|bit| class & bit != 0);
        block.acts = SIX_DOF_ACTS.map(|bit| class & bit != 0);
        block.is_direct = class & SIX_DIRECT != 0;
        block.is_anchored = class & SIX_ANCHORED != 0;
        let joints = self.read_six_dof(owners, block);
        let (alpha, sa) = Whitening::gather(simd, read_lanes(&self.body.whitening, &block.row_a));
        let (beta, sb) = Whitening::gather(simd, read_lanes(&self.body.whitening, &block.row_b));
        alpha.store_array(&mut block.alpha);
        beta.store_array(&mut block.beta);
        sa.store(&mut block.s_a);
        sb.store(&mut block.s_b);
        joints.put_velocities(simd, block);

        let [given_along, given_about] = joints.put_axes(simd, block, self.ctx.impulse_scale);
        joints.put_laws(simd, block, self.ctx.h);
        let (mut force, mut torque) = (Vec3w::zero(simd), Vec3w::zero(simd));
        for i in 0..3 {
            force = force + Vec3w::load(simd, &block.u[i]) * given_along[i];
            torque = torque + Vec3w::load(simd, &block.n[i]) * given_about[i];
        }
        let (ra, rb) = (Vec3w::load(simd, &block.r_a), Vec3w::load(simd, &block.r_b));
        let moment_a = (ra + Vec3w::load(simd, &block.gap)).cross(force) + torque;
        let moment_b = rb.cross(force) + torque;
        force.store(&mut block.carried);
        moment_a.store(&mut block.carried_a);
        moment_b.store(&mut block.carried_b);
        torque.store(&mut block.torque);
        if block.is_direct {
            return;
        }
        let a = load_velocity(simd, &self.body.solver_bodies, &block.row_a);
        let a = Velocity { v: a.v - force * alpha, w: a.w - sa.mul(moment_a) };
        store_velocity(simd, &self.body.solver_bodies, &block.row_a, a);
        let b = load_velocity(simd, &self.body.solver_bodies, &block.row_b);
        let b = Velocity { v: b.v + force * beta, w: b.w + sb.mul(moment_b) };
        store_velocity(simd, &self.body.solver_bodies, &block.row_b, b);
    }

    /// Prefetches the joints of the block after the next one, and the data behind the joints of the
    /// next one. Stops at the last own block, because others may be written meanwhile.
    #[inline(always)]
    fn prefetch_six_dof(&self, block: usize, end: usize) {
        self.prefetch_joints(&self.plan.six_dof, block + 2);
        let next = self.plan.six_dof.owners[..end].get(block + 1);
        for owner in next.into_iter().flatten() {
            if let Some(Joint { model: JointModel::SixDof(six_dof), .. }) = self.joint(*owner) {
                prefetch(&six_dof.laws);
                prefetch(&six_dof.state);
                prefetch(&six_dof.def.frame_a);
                prefetch(&six_dof.def.frame_b);
            }
        }
    }

    /// Reads the joints of a block, their bodies and solver bodies; lanes without a joint stay
    /// idle.
    #[inline(always)]
    fn read_six_dof(&self, owners: &[u32; LANES], block: &mut SixDofBlock) -> Gathered<'_> {
        let mut joints = Gathered {
            raw: Raw::default(),
            laws: [&IDLE.0; LANES],
            states: [&IDLE.1; LANES],
            frames: [[&UNTURNED; LANES]; 2],
            flags: Flags::default(),
            driven: None,
        };
        (block.row_a, block.row_b) = ([0; LANES], [0; LANES]);
        for (lane, row) in owners.iter().enumerate() {
            if let Some(joint) = self.joint(*row)
                && let JointModel::SixDof(six_dof) = &joint.model
            {
                joints.laws[lane] = &six_dof.laws;
                joints.states[lane] = &six_dof.state;
                joints.frames[0][lane] = bytemuck::cast_ref(&six_dof.def.frame_a);
                joints.frames[1][lane] = bytemuck::cast_ref(&six_dof.def.frame_b);
                joints.flags |= six_dof.laws.flags;
                joints.raw.put(0, lane, joint.anchor_a, &self.at_start(joint.body_a));
                joints.raw.put(1, lane, joint.anchor_b, &self.at_start(joint.body_b));
                let solver_rows =
                    [joint.body_a, joint.body_b].map(|row| self.body.solver_row_of[row as usize]);
                [block.row_a[lane], block.row_b[lane]] = solver_rows;
                if solver_rows[0] == 0 || solver_rows[1] == 0 {
                    self.read_driven(joint, lane, &mut joints.driven);
                }
            }
        }
        joints
    }

    #[inline(always)]
    /// Reads the velocities of a joint's kinematic bodies.
    fn read_driven(
        &self,
        joint: &Joint,
        lane: usize,
        driven: &mut Option<[[[[f32; 4]; LANES]; 2]; 2]>,
    ) {
        for (side, row) in [joint.body_a, joint.body_b].into_iter().enumerate() {
            let body = self.bodies.at(row);
            if !body.is_dynamic() && body.active() {
                let [v, w] = driven.get_or_insert_default();
                (v[side][lane], w[side][lane]) = (four(body.v), four(body.w));
            }
        }
    }

    /// Writes the impulses of a block back.
    #[inline(always)]
    fn store_block<S: Simd>(&self, simd: S, block: usize) {
        let owners = &self.plan.six_dof.owners[block];
        let block = self.joint.six_dof.read(block);
        let scale = splat(simd, self.ctx.store_scale());
        let mut columns = [splat(simd, 0.0); 4 * ROWS];
        for i in 0..6 {
            columns[i] = load(simd, &block.lock_or_drive[i]) * scale;
            columns[i + 6] = load(simd, &block.friction[i]) * scale;
            columns[i + 12] = load(simd, &block.limit[i]) * scale;
        }
        for i in 0..3 {
            columns[i + 18] = load(simd, &block.angles[i]);
            columns[i + 21] = load(simd, &block.carried[i]) * scale;
            columns[i + 24] = load(simd, &block.torque[i]) * scale;
        }
        // The rows of a swing rotate from step to step, so impulses are stored along y and z.
        let [c, s] = [load(simd, &block.swing[0]), load(simd, &block.swing[1])];
        for i in [4, 10] {
            let (along, across) = (columns[i], columns[i + 1]);
            columns[i] = c * along - s * across;
            columns[i + 1] = s * along + c * across;
        }
        for numbers in &mut columns {
            *numbers = bounded(simd, *numbers);
        }
        let mut states = [[[0.0; 4]; ROWS]; LANES];
        for row in 0..ROWS {
            let i = 4 * row;
            let rows = scatter4([columns[i], columns[i + 1], columns[i + 2], columns[i + 3]]);
            for lane in 0..LANES {
                rows[lane].store_array(&mut states[lane][row]);
            }
        }
        for (row, state) in owners.iter().zip(states) {
            if *row != NONE
                && let Some(joint) = self.joint_slots.row(*row as usize)
                && let JointModel::SixDof(six_dof) = &mut joint.model
            {
                six_dof.state = bytemuck::cast(state);
            }
        }
    }
}

impl Gathered<'_> {
    #[inline(always)]
    fn put_velocities<S: Simd>(&self, simd: S, block: &mut SixDofBlock) {
        let (mut drift, mut spins) = (Vec3w::zero(simd), [Vec3w::zero(simd); 2]);
        if let Some([v, [a, b]]) = &self.driven {
            drift = Vec3w::of_rows(simd, &v[1]) - Vec3w::of_rows(simd, &v[0]);
            spins = [Vec3w::of_rows(simd, a), Vec3w::of_rows(simd, b)];
        }
        drift.store(&mut block.drift);
        spins[0].store(&mut block.spin_a);
        spins[1].store(&mut block.spin_b);
    }

    /// Fills lever arms, axes, angles, locked axes and impulses. Returns the impulses along each
    /// translation and about each rotation.
    #[inline(always)]
    fn put_axes<S: Simd>(&self, simd: S, block: &mut SixDofBlock, scale: f32) -> [[Wide<S>; 3]; 2] {
        let mut columns = [splat(simd, 0.0); 4 * ROWS];
        let rows: [&[[f32; 4]; ROWS]; LANES] = self.rows();
        for row in 0..ROWS {
            let mut of = [&rows[0][row]; LANES];
            for lane in 1..LANES {
                of[lane] = &rows[lane][row];
            }
            let four = gather4(simd, of);
            for i in 0..4 {
                columns[4 * row + i] = four[i];
            }
        }
        let (mut ra, rb) = (self.raw.arm(simd, 0), self.raw.arm(simd, 1));
        let mut gap = self.raw.between(simd) + (rb - ra);
        let frame_a =
            Quatw::of_rows(simd, &self.raw.turns[0]).after(Quatw::gather(simd, self.frames[0]));
        let frame_b =
            Quatw::of_rows(simd, &self.raw.turns[1]).after(Quatw::gather(simd, self.frames[1]));
        let axes = frame_a.axes(simd);
        let last = [columns[18], columns[19], columns[20]];
        let turns =
            Angles::new(simd, &self.laws, self.flags.turnings, [frame_a, frame_b], axes, last);
        let [c, s] = turns.swing;
        for i in [4, 10] {
            let (y, z) = (columns[i], columns[i + 1]);
            columns[i] = c * y + s * z;
            columns[i + 1] = c * z - s * y;
        }
        let force = Vec3w { x: columns[21], y: columns[22], z: columns[23] };
        let mut given = [splat(simd, 0.0); 6];
        for i in 0..6 {
            let [locked, mut place, carries, friction] = self.law(simd, i, 0);
            if block.is_anchored && i < 3 {
                // As in the kernel, the force stays constant in the world; anchor A is placed at
                // the target of anchor B.
                columns[i] = axes[i].dot(force);
                let displacement = axes[i] * place;
                (ra, gap) = (ra + displacement, gap - displacement);
                place = splat(simd, 0.0);
            }
            locked.store_array(&mut block.locked[i]);
            place.store_array(&mut block.place[i]);
            friction.store_array(&mut block.axes[i].friction);
            // An axis law that no longer exists has no impulse to carry on.
            let scale = carries * splat(simd, scale);
            let [held, rubbed, limit] =
                [columns[i] * scale, columns[i + 6] * scale, columns[i + 12] * scale];
            held.store_array(&mut block.lock_or_drive[i]);
            rubbed.store_array(&mut block.friction[i]);
            limit.store_array(&mut block.limit[i]);
            given[i] = held + rubbed + limit;
        }
        ra.store(&mut block.r_a);
        rb.store(&mut block.r_b);
        gap.store(&mut block.gap);
        for i in 0..3 {
            axes[i].store(&mut block.u[i]);
            turns.rows[i].store(&mut block.n[i]);
            turns.angles[i].store_array(&mut block.angles[i]);
        }
        c.store_array(&mut block.swing[0]);
        s.store_array(&mut block.swing[1]);
        let [x, y, z, a, b, c] = given;
        [[x, y, z], [a, b, c]]
    }

    /// Fills the laws of drives, friction and limits.
    #[inline(always)]
    fn put_laws<S: Simd>(&self, simd: S, block: &mut SixDofBlock, h: f32) {
        let flags = self.flags;
        block.springs = flags.drives | flags.yields != 0;
        let (h, far) = (splat(simd, h), splat(simd, FAR));
        for i in 0..6 {
            let has = |bits: u8| bits >> i & 1 != 0;
            let axis = &mut block.axes[i];
            axis.acts = has(flags.acts);
            axis.drives = has(flags.drives);
            axis.limits = has(flags.limits);
            axis.yields = has(flags.yields);
            if !block.acts[i / 3] {
                continue;
            }
            min(load(simd, &axis.friction) * h, far).store_array(&mut axis.friction);
            let [low, high, hard, maximum] = self.law(simd, i, 1);
            low.store_array(&mut axis.low);
            high.store_array(&mut axis.high);
            hard.store_array(&mut axis.hard);
            min(maximum * h, far).store_array(&mut axis.maximum);
            if axis.drives || axis.yields {
                let [stiffness, damping, per_mass, place] = self.law(simd, i, 2);
                stiffness.store_array(&mut axis.drive.stiffness);
                damping.store_array(&mut axis.drive.damping);
                per_mass.store_array(&mut axis.drive.per_mass);
                place.store_array(&mut axis.drive.place);
                let [stiffness, damping, per_mass, speed] = self.law(simd, i, 3);
                stiffness.store_array(&mut axis.limit.stiffness);
                damping.store_array(&mut axis.limit.damping);
                per_mass.store_array(&mut axis.limit.per_mass);
                speed.store_array(&mut axis.drive.speed);
            }
        }
        if flags.cones {
            self.put_cones(simd, block);
        }
    }

    /// Fills the terms that depend on the direction of the swing: the cone's width there, and the
    /// target of drives.
    #[inline(always)]
    fn put_cones<S: Simd>(&self, simd: S, block: &mut SixDofBlock) {
        let mut of = [&self.laws[0].cone; LANES];
        for lane in 1..LANES {
            of[lane] = &self.laws[lane].cone;
        }
        let [wide, high, cone, _] = gather4(simd, of);
        let [c, s] = [load(simd, &block.swing[0]), load(simd, &block.swing[1])];
        let (p, q) = (c / wide, s / high);
        let reach = splat(simd, 1.0) / sqrt(p * p + q * q);
        let [.., along, across] = &mut block.axes;
        let is_cone = above(cone, splat(simd, 0.5));
        select(is_cone, reach, load(simd, &along.high)).store_array(&mut along.high);
        if along.drives || across.drives {
            for (y, z) in [
                (&mut along.drive.place, &mut across.drive.place),
                (&mut along.drive.speed, &mut across.drive.speed),
            ] {
                let (on_y, on_z) = (load(simd, y), load(simd, z));
                (c * on_y + s * on_z).store_array(y);
                (c * on_z - s * on_y).store_array(z);
            }
        }
    }

    /// Gathers one row of an axis's laws.
    #[inline(always)]
    fn law<S: Simd>(&self, simd: S, axis: usize, row: usize) -> [Wide<S>; 4] {
        let mut of = [&self.laws[0].axes[axis].0[row]; LANES];
        for lane in 1..LANES {
            of[lane] = &self.laws[lane].axes[axis].0[row];
        }
        gather4(simd, of)
    }

    /// The joints' stored states, in rows.
    #[inline(always)]
    fn rows(&self) -> [&[[f32; 4]; ROWS]; LANES] {
        let mut rows: [&[[f32; 4]; ROWS]; LANES] = [bytemuck::cast_ref(self.states[0]); LANES];
        for lane in 1..LANES {
            rows[lane] = bytemuck::cast_ref(self.states[lane]);
        }
        rows
    }
}
