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

use super::gather::Moment;
use super::number::Number;
use super::spatial::{Rotation, Spatial, Vector};
use super::tree::Tree;
use super::work::TreeWork;

/// Tuning of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
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
pub struct TreeStepReport<N> {
    /// Work against gravity with which violated limits and closures were closed \[J\]. It is the
    /// only energy that a passive tree can gain.
    pub recovery_work: N,
}

/// The state of a tree: coordinates and velocities.
#[derive(Clone, Debug, PartialEq)]
pub struct TreeState<N> {
    /// Coordinates \[m, rad, and unit quaternions\].
    pub q: Vec<N>,
    /// Velocities \[m/s, rad/s\].
    pub v: Vec<N>,
}

impl<N: Number> TreeState<N> {
    /// The tree at rest at its reference coordinates.
    #[must_use]
    pub fn new(tree: &Tree<N>) -> Self {
        Self { q: tree.reference().to_vec(), v: vec![N::zero(); tree.v_count()] }
    }
}

/// Quantities that a step conserves, at its start.
struct Before<N> {
    energy: N,
    momentum: Spatial<N>,
    origin: Vector<N>,
    center: Vector<N>,
}

/// Quantities at the end of a step.
struct Goal<N> {
    /// Kinetic and gravity energy.
    energy: N,
    /// Momentum about `origin`.
    momentum: Spatial<N>,
    origin: Vector<N>,
    /// Center of mass at the step's start, and mass times its way since.
    center: Vector<N>,
    linear: Vector<N>,
    /// Kinetic, gravity and spring energy, if the motion is shortened.
    whole: N,
}

impl<N: Number> Tree<N> {
    /// Advances the state by `h` \[s\] under generalized forces `tau` \[N m or N\].
    ///
    /// Does nothing if a slice has the wrong length, or if `h` is not above 0 and finite.
    pub fn step(
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
        if !sizes || !(h > 0.0 && h.is_finite()) {
            return report;
        }
        // Lanes take their own numbers of substeps: a lane that is done keeps its state.
        let count = self.substeps(state, h, config, work);
        let mut most = 1;
        while most < config.substeps && N::splat(f64::from(u32::try_from(most).unwrap_or(u32::MAX))).any_less(count) {
            most += 1;
        }
        let step = N::splat(h) / count;
        for index in 0..most {
            if most == 1 {
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
        let fastest = work.velocity.iter().fold(N::zero(), |most, velocity| {
            most.greater(velocity.angular.dot(velocity.angular))
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
        let mut buffers = core::mem::replace(&mut work.buffers, super::work::Buffers::empty());
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
        let momentum =
            about(before.momentum, work.origin - before.origin) + gravity * h + momentum;
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
        let mut excess = N::zero();
        if !work.rows.rows.is_empty() {
            for dof in 0..self.dofs.len() {
                buffers.row[dof] = (buffers.v_start[dof] + buffers.v[dof]) * N::splat(0.5);
            }
            self.whiten_velocity(work, &buffers.row, &mut buffers.whitened);
            excess = work.rows.rigid_work(&buffers.whitened).greater(N::zero());
        }
        let done = done - excess;
        let others = self.work_without_springs(h, work, &buffers) - excess;
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
        self.track(state, &goal, config, work);
        if config.keep_energy {
            self.align(state, &goal, N::one(), config, work);
            let held = self.hold_back(state, &goal, h, config, work, &mut buffers);
            if N::zero().any_less(held) {
                self.align(state, &goal, held, config, work);
            }
            // A motion that was shortened has stretched springs less, and has not closed gaps.
            let rest = goal.whole - self.spring_energy(&state.q);
            goal.energy = N::zero().if_less(held, rest, goal.energy);
            recovered = N::zero().if_less(held, N::zero(), recovered);
        }
        self.restore(state, &goal, config, work);
        work.buffers = buffers;
        recovered
    }

    /// Work of all forces but springs, on the shorter of the step's two displacements.
    fn work_without_springs(
        &self,
        h: N,
        work: &TreeWork<N>,
        buffers: &super::work::Buffers<N>,
    ) -> N {
        let half = N::splat(0.5);
        let mut sum = N::zero();
        for dof in 0..self.dofs.len() {
            let start = buffers.v_start[dof];
            let change = buffers.v[dof] - start;
            let weighted = start + work.theta[dof] * change;
            let stretch = work.theta[dof] * h * self.dofs[dof].stiffness * weighted;
            let other = buffers.impulse[dof] - h * (buffers.spring[dof] - stretch);
            sum = sum + (other * (start + half * change)).lesser(other * weighted);
        }
        sum
    }

    /// Moves a floating tree so that its center of mass is where its momentum brings it.
    fn track(
        &self,
        state: &mut TreeState<N>,
        goal: &Goal<N>,
        config: &TreeStepConfig,
        work: &mut TreeWork<N>,
    ) {
        if !(self.conserves_momentum() && config.keep_momentum) {
            return;
        }
        let (mass, center) = self.center_of_mass(work);
        let shift = goal.center + goal.linear * (N::one() / mass) - center;
        for k in 0..3 {
            state.q[k] = state.q[k] + shift.0[k];
        }
        work.origin = work.origin + shift;
        work.placed.copy_from_slice(&state.q);
    }

    fn conserves_momentum(&self) -> bool {
        self.floats() && !N::zero().any_less(self.dofs[0].armature)
    }

    /// Turns a floating tree about its center of mass to where its locked motion has the energy that
    /// is left: at a given angular momentum, that energy depends on the direction. A lone body so
    /// keeps its energy; a tree at least does not need more than there is. Only lanes above 0 turn.
    fn align(
        &self,
        state: &mut TreeState<N>,
        goal: &Goal<N>,
        lanes: N,
        config: &TreeStepConfig,
        work: &mut TreeWork<N>,
    ) {
        if !(self.conserves_momentum() && config.keep_momentum) {
            return;
        }
        let (zero, one, half) = (N::zero(), N::one(), N::splat(0.5));
        let alone = self.dofs.len() == 6;
        // Newton's method on an energy that is nearly quadratic in the turn.
        for _ in 0..12 {
            let momentum = about(goal.momentum, work.origin - goal.origin);
            let whole = self.whole(work);
            let locked = whole.velocity_of(momentum);
            let need = self.gravity_energy(work) + half * locked.dot(momentum);
            let scale = need.abs() + goal.energy.abs();
            let excess = need - goal.energy;
            let size = if alone { excess.abs() } else { excess };
            let size = zero.if_less(lanes, size, zero);
            let least = N::splat(8.0 * N::EPSILON) * scale;
            if !least.any_less(size) {
                return;
            }
            let center = whole.moment * (one / whole.mass);
            let spin = momentum.angular - center.cross(momentum.linear);
            // dE = turn · (ω × L)
            let slope = locked.angular.cross(spin);
            let steep = slope.dot(slope);
            let safe = zero.if_less(steep, steep, one);
            let by = slope * zero.if_less(steep, -(excess / safe), zero);
            let length = by.length();
            let most = N::splat(0.1);
            let shrink = most.if_less(length, most / most.greater(length), one);
            let by = by * least.if_less(size, shrink, zero);
            let turn = Rotation::from_vector(by);
            let moved = center - turn.rotate(center);
            let turned = turn.times(work.rotation[0]).normalized();
            let changes = zero.if_less(length, one, zero);
            let changes = least.if_less(size, changes, zero);
            for k in 0..3 {
                let shifted = state.q[k] + moved.0[k];
                state.q[k] = zero.if_less(changes, shifted, state.q[k]);
            }
            for k in 0..4 {
                state.q[3 + k] = zero.if_less(changes, turned.0[k], state.q[3 + k]);
            }
            // The base moves with the turn; the rates of its joints stay.
            self.place(&state.q, work);
        }
    }

    /// Shortens the motion of a step that would need more energy than there is. Gives more than 0 in
    /// lanes where it did.
    fn hold_back(
        &self,
        state: &mut TreeState<N>,
        goal: &Goal<N>,
        h: N,
        config: &TreeStepConfig,
        work: &mut TreeWork<N>,
        buffers: &mut super::work::Buffers<N>,
    ) -> N {
        let half = h * N::splat(0.5);
        let (mut part, mut held) = (N::one(), N::zero());
        for attempt in 0..12 {
            let available = match attempt {
                0 => goal.energy,
                _ => N::zero().if_less(
                    held,
                    goal.whole - self.spring_energy(&state.q),
                    goal.energy,
                ),
            };
            let missing = self.missing(goal, available, config, work);
            if !N::zero().any_less(missing) {
                break;
            }
            held = held.greater(missing);
            part = part * N::splat(0.5);
            buffers.q.copy_from_slice(&buffers.q_start);
            self.advance(&mut buffers.q, &buffers.v_start, half * part);
            self.advance(&mut buffers.q, &buffers.change, half * part);
            for (old, &new) in state.q.iter_mut().zip(&buffers.q) {
                *old = N::zero().if_less(missing, new, *old);
            }
            self.place(&state.q, work);
            self.track(state, goal, config, work);
        }
        held
    }

    /// Energy that the placed tree needs beyond the available: more than 0 if it cannot be there.
    fn missing(&self, goal: &Goal<N>, available: N, config: &TreeStepConfig, work: &TreeWork<N>) -> N {
        let mut need = self.gravity_energy(work);
        if self.conserves_momentum() && config.keep_momentum {
            let momentum = about(goal.momentum, work.origin - goal.origin);
            let locked = self.whole(work).velocity_of(momentum);
            need = need + N::splat(0.5) * locked.dot(momentum);
        }
        let scale = need.abs() + available.abs();
        need - available - N::splat(64.0 * N::EPSILON) * scale
    }

    /// Kinetic plus gravity energy, and momentum about the reference point.
    fn conserved(&self, v: &[N], work: &TreeWork<N>) -> Before<N> {
        let (kinetic, momentum) = self.motion_sums(v, work);
        Before {
            energy: kinetic + self.gravity_energy(work),
            momentum,
            origin: work.origin,
            center: self.center_of_mass(work).1,
        }
    }

    /// Factors for a step that may differ from lane to lane.
    fn factor_step(&self, work: &mut TreeWork<N>, h: N) {
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
    fn find_velocities(
        &self,
        state: &TreeState<N>,
        tau: &[N],
        h: N,
        config: &TreeStepConfig,
        work: &mut TreeWork<N>,
        buffers: &mut super::work::Buffers<N>,
    ) {
        let half = N::splat(0.5);
        let dofs = self.dofs.len();
        let has_rows = self.may_have_rows();
        work.rows.clear();
        buffers.v_middle.copy_from_slice(&state.v);
        let mut most = N::zero();
        for iteration in 0..config.iterations.clamp(1, 16) {
            self.move_links(&buffers.v_middle, work);
            self.bias(work);
            if iteration == 0 {
                most = self.largest_change(state, tau, h, work, buffers);
            }
            self.find_change(state, tau, h, most, work, buffers);
            for dof in 0..dofs {
                buffers.v[dof] = state.v[dof] + buffers.change[dof];
            }
            if has_rows {
                if iteration == 0 {
                    let moment =
                        Moment { q: &state.q, v: &state.v, v_free: &buffers.v, h };
                    self.gather(&moment, work, &mut buffers.row);
                }
                if !work.rows.rows.is_empty() {
                    self.whiten_velocity(work, &buffers.v, &mut buffers.whitened);
                    work.rows.apply(&mut buffers.whitened);
                    for _ in 0..config.sweeps.clamp(1, 1000) {
                        work.rows.sweep(&mut buffers.whitened);
                    }
                    buffers.row.copy_from_slice(&buffers.v);
                    let present = work.rows.rows.iter().fold(N::zero(), |sum, row| {
                        sum.greater(row.impulse.abs())
                    });
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

    /// Change of the velocities without rows, into `buffers.change`. Its norm is at most `most`.
    fn find_change(
        &self,
        state: &TreeState<N>,
        tau: &[N],
        h: N,
        most: N,
        work: &mut TreeWork<N>,
        buffers: &mut super::work::Buffers<N>,
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
        let limit = most * most;
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
    fn largest_change(
        &self,
        state: &TreeState<N>,
        tau: &[N],
        h: N,
        work: &mut TreeWork<N>,
        buffers: &mut super::work::Buffers<N>,
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
    fn sum_impulses(
        &self,
        tau: &[N],
        h: N,
        work: &TreeWork<N>,
        buffers: &mut super::work::Buffers<N>,
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
        if !work.rows.rows.is_empty() {
            // Jᵀλ = Lᵀ √D Σ w λ.
            buffers.row.fill(N::zero());
            work.rows.apply(&mut buffers.row);
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
    fn recover(
        &self,
        state: &mut TreeState<N>,
        h: N,
        config: &TreeStepConfig,
        work: &mut TreeWork<N>,
        buffers: &mut super::work::Buffers<N>,
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

    /// Corrects the velocities so that momentum and energy are those that the impulses leave.
    fn restore(
        &self,
        state: &mut TreeState<N>,
        goal: &Goal<N>,
        config: &TreeStepConfig,
        work: &mut TreeWork<N>,
    ) {
        let (zero, one) = (N::zero(), N::one());
        let floating = self.conserves_momentum();
        let momentum = about(goal.momentum, work.origin - goal.origin);
        let energy = goal.energy;
        if !(config.keep_energy || floating && config.keep_momentum) {
            return;
        }
        self.move_links(&state.v, work);
        let mut locked = Spatial::zero();
        let mut locked_energy = zero;
        let half = N::splat(0.5);
        let (mut kinetic, now) = self.motion_sums(&state.v, work);
        if floating {
            let whole = self.whole(work);
            let goal = if config.keep_momentum { momentum } else { now };
            locked = whole.velocity_of(goal);
            locked_energy = half * locked.dot(goal);
            if config.keep_momentum {
                let correction = whole.velocity_of(goal - now);
                kinetic = kinetic + correction.dot(now) + half * correction.dot(goal - now);
                self.shift_base(state, correction, work);
            }
        }
        if !config.keep_energy {
            return;
        }
        let inner = kinetic - locked_energy;
        let wanted = energy - self.gravity_energy(work) - locked_energy;
        // Below this the inner motion is rounding.
        let least = N::splat(16.0 * N::EPSILON) * (kinetic + locked_energy) + N::splat(1.0e-30);
        let safe = least.if_less(inner, inner, one);
        let ratio = (wanted / safe).greater(zero).lesser(N::splat(MOST_GAIN));
        let scale = least.if_less(inner, ratio.sqrt(), one);
        let base = if floating { 6 } else { 0 };
        for rate in &mut state.v[base..] {
            *rate = *rate * scale;
        }
        if floating {
            let w = work.rotation[0];
            let v = Spatial {
                angular: w.rotate(Vector([state.v[3], state.v[4], state.v[5]])),
                linear: Vector([state.v[0], state.v[1], state.v[2]]),
            };
            let correction = (v - locked) * (scale - one);
            self.shift_base(state, correction, work);
        }
    }

    /// Adds a motion to that of the floating first link.
    fn shift_base(&self, state: &mut TreeState<N>, by: Spatial<N>, work: &TreeWork<N>) {
        let turn = work.rotation[0].unrotate(by.angular);
        for k in 0..3 {
            state.v[k] = state.v[k] + by.linear.0[k];
            state.v[k + 3] = state.v[k + 3] + turn.0[k];
        }
    }
}

/// Largest factor by which a step may raise the energy of the inner motion to keep the whole.
const MOST_GAIN: f64 = 1.05;

/// The same momentum about a point that is `shift` from the old one.
fn about<N: Number>(momentum: Spatial<N>, shift: Vector<N>) -> Spatial<N> {
    Spatial {
        angular: momentum.angular - shift.cross(momentum.linear),
        linear: momentum.linear,
    }
}
