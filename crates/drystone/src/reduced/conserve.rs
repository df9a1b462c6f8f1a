//! Conserved quantities of a step: momentum, center of mass, energy.
//!
//! A step leaves errors of third order in them, and larger ones where light links move faster than
//! it resolves. They are taken out: the base and the center of mass get their momentum and place,
//! the inner motion is scaled to the energy that is left. Where even no inner motion leaves too
//! much energy, a floating tree is turned, and the motion of the step is shortened.

use super::number::Number;
use super::spatial::{Rotation, Spatial, Vector};
use super::step::{TreeState, TreeStepConfig};
use super::tree::Tree;
use super::work::{Buffers, TreeWork};

/// Largest factor by which a step may raise the energy of the inner motion to keep the whole.
const MAX_GAIN: f64 = 1.05;

/// Quantities that a step conserves, at its start.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Before<N> {
    pub(crate) energy: N,
    pub(super) momentum: Spatial<N>,
    pub(super) origin: Vector<N>,
    pub(super) center: Vector<N>,
}

/// Quantities at the end of a step.
pub(super) struct Goal<N> {
    /// Kinetic and gravity energy.
    pub(super) energy: N,
    /// Momentum about `origin`.
    pub(super) momentum: Spatial<N>,
    pub(super) origin: Vector<N>,
    /// Center of mass at the step's start, and mass times its way since.
    pub(super) center: Vector<N>,
    pub(super) linear: Vector<N>,
    /// Kinetic, gravity and spring energy, if the motion is shortened.
    pub(super) whole: N,
}

impl<N: Number> Tree<N> {
    /// Kinetic plus gravity energy, and momentum about the reference point.
    pub(super) fn conserved(&self, v: &[N], work: &TreeWork<N>) -> Before<N> {
        let (kinetic, momentum) = self.motion_sums(v, work);
        Before {
            energy: kinetic + self.gravity_energy(work),
            momentum,
            origin: work.origin,
            center: self.center_of_mass(work).1,
        }
    }

    pub(super) fn conserves_momentum(&self) -> bool {
        self.floats() && !N::zero().any_less(self.dofs[0].armature)
    }

    /// Moves a floating tree so that its center of mass is where its momentum brings it.
    pub(super) fn track(
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

    /// Turns a floating tree about its center of mass to where its locked motion has the energy
    /// that is left: at a given angular momentum, that energy depends on the direction. A lone
    /// body so keeps its energy; a tree at least does not need more than there is. Only lanes
    /// above 0 turn.
    pub(super) fn align(
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
        let (mut lanes, mut last) = (lanes, N::splat(1.0e30));
        let mut old: [N; 7] = core::array::from_fn(|k| state.q[k]);
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
            let minimum = N::splat(8.0 * N::EPSILON) * scale;
            // No direction may have that energy: the last turn that helped stays.
            let worse = last.if_less(size, lanes, zero);
            if zero.any_less(worse) {
                for (now, old) in state.q[..7].iter_mut().zip(old) {
                    *now = zero.if_less(worse, old, *now);
                }
                lanes = zero.if_less(worse, zero, lanes);
                self.place(&state.q, work);
                continue;
            }
            if !minimum.any_less(size) {
                return;
            }
            last = size;
            old = core::array::from_fn(|k| state.q[k]);
            let center = whole.moment * (one / whole.mass);
            let spin = momentum.angular - center.cross(momentum.linear);
            // dE = turn · (ω × L)
            let slope = locked.angular.cross(spin);
            let steep = slope.dot(slope);
            let safe = zero.if_less(steep, steep, one);
            let by = slope * zero.if_less(steep, -(excess / safe), zero);
            let length = by.length();
            let maximum = N::splat(0.1);
            let shrink = maximum.if_less(length, maximum / maximum.greater(length), one);
            let by = by * minimum.if_less(size, shrink, zero);
            let turn = Rotation::from_vector(by);
            let moved = center - turn.rotate(center);
            let turned = turn.times(work.rotation[0]).normalized();
            let changes = zero.if_less(length, one, zero);
            let changes = minimum.if_less(size, changes, zero);
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

    /// Shortens the motion of a step that would need more energy than there is. Gives more than 0
    /// in lanes where it did.
    pub(super) fn hold_back(
        &self,
        state: &mut TreeState<N>,
        goal: &Goal<N>,
        h: N,
        config: &TreeStepConfig,
        work: &mut TreeWork<N>,
        buffers: &mut Buffers<N>,
    ) -> N {
        let half = h * N::splat(0.5);
        let (mut part, mut held) = (N::one(), N::zero());
        for attempt in 0..12 {
            let available = match attempt {
                0 => goal.energy,
                _ => {
                    N::zero().if_less(held, goal.whole - self.spring_energy(&state.q), goal.energy)
                }
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
    pub(super) fn missing(
        &self,
        goal: &Goal<N>,
        available: N,
        config: &TreeStepConfig,
        work: &TreeWork<N>,
    ) -> N {
        let mut need = self.gravity_energy(work);
        if self.conserves_momentum() && config.keep_momentum {
            let momentum = about(goal.momentum, work.origin - goal.origin);
            let locked = self.whole(work).velocity_of(momentum);
            need = need + N::splat(0.5) * locked.dot(momentum);
        }
        let scale = need.abs() + available.abs();
        need - available - N::splat(64.0 * N::EPSILON) * scale
    }

    /// Corrects the velocities so that momentum and energy are those that the impulses leave.
    pub(super) fn restore(
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
        let minimum = N::splat(16.0 * N::EPSILON) * (kinetic + locked_energy) + N::splat(1.0e-30);
        let safe = minimum.if_less(inner, inner, one);
        // Contacts rest only if nothing drives them.
        let most = if work.has_contacts { one } else { N::splat(MAX_GAIN) };
        let ratio = (wanted / safe).greater(zero).lesser(most);
        let scale = minimum.if_less(inner, ratio.sqrt(), one);
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
    pub(super) fn shift_base(&self, state: &mut TreeState<N>, by: Spatial<N>, work: &TreeWork<N>) {
        let turn = work.rotation[0].unrotate(by.angular);
        for k in 0..3 {
            state.v[k] = state.v[k] + by.linear.0[k];
            state.v[k + 3] = state.v[k + 3] + turn.0[k];
        }
    }
}

/// The same momentum about a point that is `shift` from the old one.
pub(super) fn about<N: Number>(momentum: Spatial<N>, shift: Vector<N>) -> Spatial<N> {
    Spatial { angular: momentum.angular - shift.cross(momentum.linear), linear: momentum.linear }
}
