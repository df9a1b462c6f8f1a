//! A step of a tree: half a step of motion, velocities at the middle, half a step of motion.
//!
//! Symbols: q, v coordinates and velocities, M mass matrix, c bias, τ given forces, θ weight of the
//! step's end (see `factor`), P generalized impulses without bias, E energy, H momentum.
//!
//! ```text
//! q½ = q + h/2 v
//! (M(q½) + θ h d + θ² h² k) (v⁺ − v) = h (τ − c(q½, (v + v⁺)/2) − d v − k (q + θ h v − rest)) + Jᵀλ
//! q⁺ = q½ + h/2 v⁺
//! ```
//!
//! Velocity products stand at the middle velocity, by fixed-point iterations; so the step is
//! of second order and symmetric. Then two conserved quantities are restored. The momentum of a
//! floating tree is the one before plus its impulses: the base's motion is corrected. Kinetic plus
//! gravity energy is the one before plus the work of P: the internal motion is scaled.
//! `docs/decisions/043-reduced-coordinates.md` has the numbers.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::conserve::{Before, Goal, about};
use super::number::Number;
use super::spatial::Spatial;
use super::tree::Tree;
use super::work::{Buffers, TreeWork};

/// Tuning of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct TreeStepConfig {
    /// Iterations over velocity products and rows, 1 to 16; default 3.
    pub iterations: usize,
    /// Sweeps over the rows in each iteration, 1 to 1000; default 10.
    pub sweeps: usize,
    /// Speed at which limits and closures that start violated close \[rad/s or m/s\]; default 1.
    pub recovery_speed: f64,
    /// Whether closing a violated limit or closure costs kinetic energy: then even this work gives
    /// a passive tree no energy, but a tree without inner motion closes no limit. Default false.
    pub pays_recovery: bool,
    /// Whether a step keeps the energy that the forces leave; default true.
    pub keep_energy: bool,
    /// Whether a step of a floating tree keeps its momentum; default true.
    pub keep_momentum: bool,
    /// Largest turn of a link in a substep \[rad\]; faster trees take more substeps. Default 0.25.
    pub substep_turn: f64,
    /// Largest number of substeps, 1 to 256; default 16.
    pub substeps: usize,
}

impl Default for TreeStepConfig {
    fn default() -> Self {
        Self {
            iterations: 3,
            sweeps: 10,
            recovery_speed: 1.0,
            pays_recovery: false,
            keep_energy: true,
            keep_momentum: true,
            substep_turn: 0.25,
            substeps: 16,
        }
    }
}

/// Changes of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TreeStepReport<N> {
    /// Work against gravity and springs with which violated limits and closures were closed [J].
    pub(crate) recovery_work: N,
}

/// The state of a tree: coordinates and velocities.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct TreeState<N> {
    /// Coordinates \[m, rad, and unit quaternions\].
    pub(crate) q: Vec<N>,
    /// Velocities \[m/s, rad/s\].
    pub(crate) v: Vec<N>,
}

impl<N: Number> TreeState<N> {
    /// The tree at rest at its reference coordinates.
    #[must_use]
    pub(crate) fn new(tree: &Tree<N>) -> Self {
        Self { q: tree.reference().to_vec(), v: vec![N::zero(); tree.v_count()] }
    }
}

impl<N: Number> Tree<N> {
    /// Advances the state by `h` \[s\] under generalized forces `tau` \[N m or N\].
    ///
    /// Does nothing if a slice has the wrong length, or if `h` is not above 0 and finite.
    pub(crate) fn step(
        &self,
        state: &mut TreeState<N>,
        tau: &[N],
        h: f64,
        config: &TreeStepConfig,
        work: &mut TreeWork<N>,
    ) -> TreeStepReport<N> {
        let mut report = TreeStepReport { recovery_work: N::zero() };
        let sizes = state.q.len() == self.q_count
            && state.v.len() == self.dofs.len()
            && tau.len() == self.dofs.len();
        if !(sizes && h > 0.0 && h.is_finite()) {
            return report;
        }
        // Lanes take their own numbers of substeps: a lane that is done keeps its state.
        let count = self.substeps(state, h, config, work);
        let mut maximum = 1;
        while maximum < config.substeps
            && N::splat(f64::from(u32::try_from(maximum).unwrap_or(u32::MAX))).any_less(count)
        {
            maximum += 1;
        }
        let step = N::splat(h) / count;
        for index in 0..maximum {
            if maximum == 1 {
                let done = self.substep(state, tau, step, config, work);
                report.recovery_work = report.recovery_work + done;
                continue;
            }
            let at = N::splat(f64::from(u32::try_from(index).unwrap_or(u32::MAX)));
            let before = state.clone();
            let done = self.substep(state, tau, step, config, work);
            let keep = |new: N, old: N| at.if_less(count, new, old);
            for (new, old) in state.q.iter_mut().zip(before.q) {
                *new = keep(*new, old);
            }
            for (new, old) in state.v.iter_mut().zip(before.v) {
                *new = keep(*new, old);
            }
            report.recovery_work = report.recovery_work + keep(done, N::zero());
        }
        report
    }

    /// Number of substeps in which no link turns by more than `substep_turn`, in each lane.
    fn substeps(
        &self,
        state: &TreeState<N>,
        h: f64,
        config: &TreeStepConfig,
        work: &mut TreeWork<N>,
    ) -> N {
        self.place(&state.q, work);
        self.move_links(&state.v, work);
        let fastest = work.velocity.iter().fold(N::zero(), |maximum, velocity| {
            maximum.greater(velocity.angular.dot(velocity.angular))
        });
        let wanted = fastest.sqrt() * N::splat(h / config.substep_turn.max(1.0e-6));
        let limit = N::splat(f64::from(u32::try_from(config.substeps.clamp(1, 256)).unwrap_or(1)));
        let wanted = wanted.lesser(limit - N::splat(0.5));
        (wanted + N::splat(0.5)).round().greater(N::one()).lesser(limit)
    }

    fn substep(
        &self,
        state: &mut TreeState<N>,
        tau: &[N],
        h: N,
        config: &TreeStepConfig,
        work: &mut TreeWork<N>,
    ) -> N {
        let before = self.begin(state, tau, h, config, work);
        self.end(state, tau, h, config, work, &before)
    }

    /// Moves to the middle of a substep, and finds the velocities at its end without contacts,
    /// into `work.buffers.v`.
    pub(crate) fn begin(
        &self,
        state: &mut TreeState<N>,
        tau: &[N],
        h: N,
        config: &TreeStepConfig,
        work: &mut TreeWork<N>,
    ) -> Before<N> {
        let mut buffers = core::mem::replace(&mut work.buffers, Buffers::empty());
        let half = h * N::splat(0.5);
        self.place(&state.q, work);
        self.move_links(&state.v, work);
        let before = self.conserved(&state.v, work);
        buffers.v_start.copy_from_slice(&state.v);
        buffers.q_start.copy_from_slice(&state.q);
        self.spring_forces(&state.q, &mut buffers.spring);
        self.advance(&mut state.q, &state.v, half);
        self.place(&state.q, work);
        self.fill_mass_matrix(work);
        self.factor_step(work, h);
        self.find_velocities(state, tau, h, config, work, &mut buffers);
        work.buffers = buffers;
        before
    }

    /// Moves from the middle of a substep to its end, at the velocities in `work.buffers.v`, and
    /// restores momentum and energy. Gives the work of closing gaps [J].
    pub(crate) fn end(
        &self,
        state: &mut TreeState<N>,
        tau: &[N],
        h: N,
        config: &TreeStepConfig,
        work: &mut TreeWork<N>,
        before: &Before<N>,
    ) -> N {
        let mut buffers = core::mem::replace(&mut work.buffers, Buffers::empty());
        let half = h * N::splat(0.5);
        let momentum = self.sum_impulses(tau, h, work, &mut buffers);
        // Gravity acts at the center of mass halfway of its fall, where the placed links have it up
        // to the square of the step.
        let (mass, placed) = self.center_of_mass(work);
        let arm = if self.conserves_momentum() {
            before.center + before.momentum.linear * (half / mass) - work.origin
        } else {
            placed - work.origin
        };
        let weight = self.gravity * mass;
        let gravity = Spatial { angular: arm.cross(weight), linear: weight };
        // Momentum about the middle's reference point, plus impulses there.
        let momentum = about(before.momentum, work.origin - before.origin) + gravity * h + momentum;
        let origin = work.origin;
        // Where a spring or damper is stiff, the end's velocity weighs more: u = v + 2θ (v⁺ − v).
        for dof in 0..self.dofs.len() {
            let start = buffers.v_start[dof];
            let change = buffers.v[dof] - start;
            let theta = work.theta[dof];
            buffers.change[dof] = start + (theta + theta) * change;
            // Never more than the force does on the displacement, nor than its kinetic energy.
            let mean = (start + start + change) * N::splat(0.5);
            let weighted = start + theta * change;
            let (p, q) = (buffers.impulse[dof] * mean, buffers.impulse[dof] * weighted);
            buffers.v_middle[dof] = p.lesser(q);
        }
        let done = buffers.v_middle.iter().fold(N::zero(), |sum, &part| sum + part);
        let others = self.work_without_springs(tau, h, work, &mut buffers);
        let springs = self.spring_energy(&buffers.q_start);
        self.advance(&mut state.q, &buffers.change, half);
        state.v.copy_from_slice(&buffers.v);
        self.place(&state.q, work);
        let (mut lifted, mut recovered) = self.recover(state, h, config, work, &mut buffers);
        if config.pays_recovery {
            (lifted, recovered) = (N::zero(), N::zero());
        }
        // Springs of balls do not follow their rotation exactly: their energy is the judge.
        let whole = before.energy + springs + others;
        let left = whole + recovered - self.spring_energy(&state.q);
        let mut goal = Goal {
            energy: (before.energy + done + lifted).lesser(left),
            momentum,
            origin,
            center: before.center,
            linear: (before.momentum.linear + momentum.linear) * half,
            whole,
        };
        // A tree in contact must stay where it touches: only its velocities are corrected.
        if !work.has_contacts {
            self.track(state, &goal, config, work);
        }
        if config.keep_energy && !work.has_contacts {
            self.align(state, &goal, N::one(), config, work);
            let held = self.hold_back(state, &goal, h, config, work, &mut buffers);
            // A motion that was shortened has stretched springs less, and has not closed gaps.
            let rest = goal.whole - self.spring_energy(&state.q);
            goal.energy = N::zero().if_less(held, rest, goal.energy);
            if N::zero().any_less(held) {
                self.align(state, &goal, held, config, work);
            }
            recovered = N::zero().if_less(held, N::zero(), recovered);
        }
        self.restore(state, &goal, config, work);
        work.buffers = buffers;
        recovered
    }

    /// The most work that given forces, damping and rows can have done, on the mean or the weighted
    /// displacement. Damping and rigid rows do no positive work, whatever the sweeps have left.
    fn work_without_springs(
        &self,
        tau: &[N],
        h: N,
        work: &TreeWork<N>,
        buffers: &mut Buffers<N>,
    ) -> N {
        let half = N::splat(0.5);
        let mut sum = N::zero();
        for dof in 0..self.dofs.len() {
            let start = buffers.v_start[dof];
            let mean = half * (start + buffers.v[dof]);
            let weighted = half * (start + buffers.change[dof]);
            let force = tau[dof] - self.dofs[dof].damping * weighted;
            sum = sum + h * (force * mean).lesser(force * weighted);
            buffers.row[dof] = mean;
        }
        if work.rows.rows.is_empty() && !work.has_contacts {
            return sum;
        }
        self.whiten_velocity(work, &buffers.row, &mut buffers.whitened);
        if work.has_contacts {
            let touched = work.contact_impulse.iter().zip(&buffers.whitened);
            sum = touched.fold(sum, |sum, (&impulse, &y)| sum + impulse * y);
        }
        let (rigid, soft) = work.rows.work(&buffers.whitened);
        for dof in 0..self.dofs.len() {
            buffers.row[dof] = half * (buffers.v_start[dof] + buffers.change[dof]);
        }
        self.whiten_velocity(work, &buffers.row, &mut buffers.whitened);
        let (weighted, _) = work.rows.work(&buffers.whitened);
        sum + rigid.lesser(weighted).lesser(N::zero()) + soft
    }
}
