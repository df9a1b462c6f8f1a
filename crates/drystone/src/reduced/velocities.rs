//! Velocities at the end of a step: forces, velocity products, rows; and what they did.

use super::gather::Moment;
use super::number::Number;
use super::spatial::{Spatial, Vector};
use super::step::{TreeState, TreeStepConfig};
use super::tree::Tree;
use super::work::{Buffers, TreeWork};

impl<N: Number> Tree<N> {
    /// Factors for a step that may differ from lane to lane.
    pub(super) fn factor_step(&self, work: &mut TreeWork<N>, h: N) {
        let (one, two, quarter) = (N::one(), N::splat(2.0), N::splat(0.25));
        self.factor_with(work, |dof, pivot| {
            let dof = &self.dofs[dof];
            let z = h * (dof.damping + quarter * h * dof.stiffness) / pivot;
            let theta = (one + z) / (two + z);
            let far = theta * h;
            (theta, far * (dof.damping + far * dof.stiffness))
        });
    }

    /// Velocities at the end of the step, into `buffers.v`; those of the middle into `v_middle`.
    pub(super) fn find_velocities(
        &self,
        state: &TreeState<N>,
        tau: &[N],
        h: N,
        config: &TreeStepConfig,
        work: &mut TreeWork<N>,
        buffers: &mut Buffers<N>,
    ) {
        let half = N::splat(0.5);
        let dofs = self.dofs.len();
        let has_rows = self.may_have_rows();
        work.rows.clear();
        buffers.v_middle.copy_from_slice(&state.v);
        let mut maximum = N::zero();
        for iteration in 0..config.iterations.clamp(1, 16) {
            self.move_links(&buffers.v_middle, work);
            self.bias(work);
            if iteration == 0 {
                maximum = self.largest_change(state, tau, h, work, buffers);
            }
            self.find_change(state, tau, h, maximum, work, buffers);
            for dof in 0..dofs {
                buffers.v[dof] = state.v[dof] + buffers.change[dof];
            }
            if has_rows {
                if iteration == 0 {
                    let moment = Moment { q: &state.q, v: &state.v, v_free: &buffers.v, h };
                    self.gather(&moment, work, &mut buffers.row);
                }
                if !work.rows.rows.is_empty() {
                    self.whiten_velocity(work, &buffers.v, &mut buffers.whitened);
                    work.rows.apply(&mut buffers.whitened);
                    for _ in 0..config.sweeps.clamp(1, 1000) {
                        work.rows.sweep(&mut buffers.whitened);
                    }
                    buffers.row.copy_from_slice(&buffers.v);
                    let present = work
                        .rows
                        .rows
                        .iter()
                        .fold(N::zero(), |sum, row| sum.greater(row.impulse.abs()));
                    self.color_velocity(work, &buffers.whitened, &mut buffers.v);
                    // A lane without impulses keeps its bits.
                    for dof in 0..dofs {
                        let free = buffers.row[dof];
                        buffers.v[dof] = N::zero().if_less(present, buffers.v[dof], free);
                    }
                }
            }
            for dof in 0..dofs {
                buffers.v_middle[dof] = half * (state.v[dof] + buffers.v[dof]);
            }
        }
    }

    /// Change of the velocities without rows, into `buffers.change`. Its norm is at most `maximum`.
    pub(super) fn find_change(
        &self,
        state: &TreeState<N>,
        tau: &[N],
        h: N,
        maximum: N,
        work: &mut TreeWork<N>,
        buffers: &mut Buffers<N>,
    ) {
        for dof in 0..self.dofs.len() {
            let data = &self.dofs[dof];
            let ahead = work.theta[dof] * h * data.stiffness + data.damping;
            let force = tau[dof] + buffers.spring[dof] - work.tau[dof];
            buffers.change[dof] = h * (force - ahead * state.v[dof]);
        }
        self.solve_upper(work, &mut buffers.change);
        let mut square = N::zero();
        for (value, &root) in buffers.change.iter_mut().zip(&work.root_inverse) {
            let white = *value * root;
            square = square + white * white;
            *value = white * root;
        }
        let limit = maximum * maximum;
        let safe = limit.if_less(square, square, N::one());
        let scale = limit.if_less(square, (limit / safe).sqrt(), N::one());
        for value in &mut buffers.change {
            *value = *value * scale;
        }
        self.solve_lower(work, &mut buffers.change);
    }

    /// The largest change of the velocities that a step can bring, in the norm of the mass matrix:
    /// free fall, plus given forces and springs, plus twice the velocities. Velocity products above
    /// it mean that the fixed point diverges.
    pub(super) fn largest_change(
        &self,
        state: &TreeState<N>,
        tau: &[N],
        h: N,
        work: &mut TreeWork<N>,
        buffers: &mut Buffers<N>,
    ) -> N {
        for dof in 0..self.dofs.len() {
            let data = &self.dofs[dof];
            let ahead = work.theta[dof] * h * data.stiffness + data.damping;
            let force = tau[dof] + buffers.spring[dof] - ahead * state.v[dof];
            buffers.change[dof] = h * force;
        }
        self.solve_upper(work, &mut buffers.change);
        let forced = buffers
            .change
            .iter()
            .zip(&work.root_inverse)
            .fold(N::zero(), |sum, (&value, &root)| sum + value * root * (value * root));
        let two = N::splat(2.0);
        let moving = (two * self.kinetic_energy(&state.v, work)).sqrt();
        let mass = self.whole(work).mass;
        let falling = h * self.gravity.length() * mass.sqrt();
        forced.sqrt() + two * moving + falling
    }

    /// Generalized impulses P of the step without bias, into `buffers.impulse`. Gives the momentum
    /// that they bring to a floating tree, about the reference point.
    pub(super) fn sum_impulses(
        &self,
        tau: &[N],
        h: N,
        work: &TreeWork<N>,
        buffers: &mut Buffers<N>,
    ) -> Spatial<N> {
        let dofs = self.dofs.len();
        for dof in 0..dofs {
            let data = &self.dofs[dof];
            let theta = work.theta[dof];
            let start = buffers.v_start[dof];
            let weighted = start + theta * (buffers.v[dof] - start);
            let force = tau[dof] + buffers.spring[dof]
                - (data.damping + theta * h * data.stiffness) * weighted;
            buffers.impulse[dof] = h * force;
        }
        if !work.rows.rows.is_empty() || work.has_contacts {
            // Jᵀλ = Lᵀ √D Σ w λ.
            buffers.row.fill(N::zero());
            work.rows.apply(&mut buffers.row);
            if work.has_contacts {
                for (sum, &impulse) in buffers.row.iter_mut().zip(&work.contact_impulse) {
                    *sum = *sum + impulse;
                }
            }
            for dof in 0..dofs {
                let value = buffers.row[dof] * work.root[dof];
                buffers.row[dof] = value;
                for at in self.rows[dof] + 1..self.rows[dof + 1] {
                    let other = self.path[at];
                    buffers.row[other] = buffers.row[other] + work.matrix[at] * value;
                }
            }
            for dof in 0..dofs {
                buffers.impulse[dof] = buffers.impulse[dof] + buffers.row[dof];
            }
        }
        if !self.floats() {
            return Spatial::zero();
        }
        let p = &buffers.impulse;
        Spatial {
            angular: work.rotation[0].rotate(Vector([p[3], p[4], p[5]])),
            linear: Vector([p[0], p[1], p[2]]),
        }
    }

    /// Closes gaps that are left, without leaving a speed. Gives the work against gravity, and with
    /// that against springs.
    pub(super) fn recover(
        &self,
        state: &mut TreeState<N>,
        h: N,
        config: &TreeStepConfig,
        work: &mut TreeWork<N>,
        buffers: &mut Buffers<N>,
    ) -> (N, N) {
        if !work.rows.rows.iter().any(|row| row.corrects) {
            return (N::zero(), N::zero());
        }
        self.whiten_velocity(work, &buffers.change, &mut buffers.whitened);
        let half = h * N::splat(0.5);
        let speed = N::splat(config.recovery_speed.max(0.0));
        let lanes = work.rows.aim_at_gaps(&buffers.whitened, half, h, speed);
        if !N::zero().any_less(lanes) {
            return (N::zero(), N::zero());
        }
        buffers.whitened.fill(N::zero());
        for _ in 0..config.sweeps.clamp(1, 1000) {
            work.rows.sweep(&mut buffers.whitened);
        }
        self.color_velocity(work, &buffers.whitened, &mut buffers.row);
        let potential = self.gravity_energy(work);
        let springs = self.spring_energy(&state.q);
        buffers.q.copy_from_slice(&state.q);
        self.advance(&mut buffers.q, &buffers.row, N::one());
        for (old, &new) in state.q.iter_mut().zip(&buffers.q) {
            *old = N::zero().if_less(lanes, new, *old);
        }
        self.place(&state.q, work);
        let lifted = self.gravity_energy(work) - potential;
        let stretched = self.spring_energy(&state.q) - springs;
        let only = |value: N| N::zero().if_less(lanes, value, N::zero());
        (only(lifted), only(lifted + stretched))
    }
}
