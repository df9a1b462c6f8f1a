//! A bound on the energy that a sweep's impulses add to an island with joints.
//!
//! Joints and contacts without bias never add energy: each visit is a projection. The warm start
//! can: it applies the impulses of the last substep along rows that have turned since. After an
//! impact these are the impulses of the impact, and one sweep takes back only a part of them.
//!
//! In a substep the impulses d do the work u·d + d·d/2 on the velocities u (whitened, so that all
//! masses are one). Every island with joints is checked. The work may not exceed the work that
//! drives, springs, kinematic motion and the closing of gaps can do. If it does, all impulses of
//! the island are scaled by the factor s at which the work equals that bound:
//!
//! ```text
//! s u·d + s² d·d/2 = allowed        s = (-u·d + √((u·d)² + 2 d·d allowed)) / d·d
//! ```
//!
//! All impulses get the same factor, so momentum is conserved and no impulse leaves its limits. The
//! warm start of the next substep is scaled too, so rows that feed each other cannot build up
//! hidden impulses. See docs/decisions/031-work-of-joints.md.

mod contacts;
mod joints;

use super::joint::sweep::JointSweep;
use super::lent::Solver;
use super::plan::forest::Tree;
use super::plan::group::{Group, number};
use super::plan::layout::Layout;
use super::work::{Bound, UNITS};
use crate::base::double::{DVec3, greater, lesser};
use crate::base::math::Vec3;
use crate::base::simd::wide::{LANES, Lanes, at};
use crate::state::bodies::body::Subdivision;
use crate::state::def::method::Pass;
use crate::step::context::caps::Caps;
use crate::step::solver_body::three;

/// Part of an island's energy that its impulses may add in a second without further checks [1/s]. A
/// soft joint that turns with its load at θ' stores (θ'/ω)² of the motion's energy. It returns that
/// at no more than θ' times the stored amount: this rate at 22 rad/s and 72 Hz.
const RIPPLE: f64 = 0.05;

/// Rows that turn by less than this in a step [rad] count as unchanged, and a body that moves by
/// less than this part of its size causes no impact. The impulses of the last substep are then as
/// good as those of this one.
const QUIET: f32 = 0.02;

/// One body of a constraint.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Side {
    /// Mass [kg] and maximum moment of inertia [kg m²].
    mass: f64,
    moment: f64,
    /// Translation and rotation since the step's start.
    moved: DVec3,
    turn: DVec3,
    /// Velocity and angular velocity before and after this substep's impulses.
    v: [DVec3; 2],
    w: [DVec3; 2],
}

impl Side {
    /// A body that cannot be pushed.
    const FIXED: Self = Self {
        mass: f64::INFINITY,
        moment: f64::INFINITY,
        moved: DVec3::ZERO,
        turn: DVec3::ZERO,
        v: [DVec3::ZERO; 2],
        w: [DVec3::ZERO; 2],
    };

    /// Upper bound of the moment of inertia about the end of the lever arm `r`.
    fn inertia_at(&self, r: DVec3) -> f64 {
        if self.mass < f64::INFINITY { self.moment + self.mass * r.dot(r) } else { f64::INFINITY }
    }
}

/// Magnitude of a quantity before the impulses, and the mean of its magnitudes before and after.
pub(crate) fn speeds(of: impl Fn(usize) -> f64) -> [f64; 2] {
    let [before, after] = [of(0).abs(), of(1).abs()];
    [before, 0.5 * (before + after)]
}

pub(crate) fn vector(lanes: &[Lanes; 3], lane: usize) -> DVec3 {
    DVec3::from(at(lanes, lane))
}

/// Speed at which a gap closes on `axis`, where any gap may close at `any`.
pub(crate) fn speed_of(gap: f64, rate: f32, (caps, any, axis): (&Caps, f32, usize)) -> f64 {
    lesser(f64::from(rate) * gap, f64::from(any) + caps.beyond(gap, axis))
}

impl Solver<'_> {
    /// Limits the work of a sweep's impulses, island by island.
    pub(super) fn bound(&self, group: &Group, pass: Pass, substep: u32) {
        let solves = matches!(pass, Pass::Solve { .. });
        // Tumbling islands are not checked. They have no contacts and get new rows in each round,
        // so neither impacts nor turned rows do work. But soft joints at 100 rad/s return the
        // energy that they store.
        let is_asked = group.subdivision != Subdivision::Tumbling;
        if !is_asked || group.bins.is_empty() || !(solves || pass == Pass::Relax) {
            return;
        }
        let is_first = solves && substep == 0;
        let ripple = RIPPLE * f64::from(self.ctx.h);
        let steps = f64::from(self.ctx.substeps);
        let bounds = self.joint.bounds.slice(group.bins.clone());
        if is_first {
            self.find_quiet(group, bounds);
        } else if bounds.iter().all(|bound| bound.is_quiet) {
            return;
        }
        for bound in bounds.iter_mut() {
            *bound = Bound { is_quiet: bound.is_quiet, ..Bound::default() };
        }
        for i in self.bin_rows(group) {
            let bin = self.plan.bins.of_row[i];
            if bounds[bin as usize - group.bins.start].is_quiet && !is_first {
                continue;
            }
            let aux = self.body.aux.read(i);
            let [v, w] = aux.before();
            let solver_body = self.body.solver_bodies.read(i);
            let (mut work, mut energy) = (0.0, 0.0);
            for c in 0..4 {
                work += (solver_body.v[c] - v[c]) * (solver_body.v[c] + v[c]);
                work += (solver_body.w[c] - w[c]) * (solver_body.w[c] + w[c]);
                energy += v[c] * v[c] + w[c] * w[c];
            }
            let bound = &mut bounds[bin as usize - group.bins.start];
            bound.work += 0.5 * f64::from(work);
            bound.energy += 0.5 * f64::from(energy);
            bound.floor += 0.5 * f64::from(aux.kick()) * steps * steps;
        }
        let mut any = false;
        for bound in bounds.iter_mut() {
            // NaN counts as over the bound, too.
            let maximum = greater(ripple * bound.energy, bound.floor - bound.energy);
            bound.is_over = !(bound.work <= maximum);
            bound.is_quiet &= !bound.is_over;
            bound.units = UNITS / bound.work;
            any |= bound.is_over;
        }
        if any {
            self.restrain(group, substep, ripple, bounds);
        }
    }

    /// Finds the islands in which all bodies are slow and which no moving surface drives.
    fn find_quiet(&self, group: &Group, bounds: &mut [Bound]) {
        bounds.iter_mut().for_each(|bound| bound.is_quiet = true);
        let at = |solver_row: usize| {
            self.plan.bins.of_row[solver_row].wrapping_sub(number(group.bins.start))
        };
        for i in self.bin_rows(group) {
            let body = self.bodies.at(self.plan.members[i - 1]);
            let maximum = QUIET / self.ctx.dt;
            let is_slow = body.w.length() < maximum && body.v.length() < maximum * body.extent;
            bounds[at(i) as usize].is_quiet &= is_slow;
        }
        if !self.contact.has_extras {
            return;
        }
        // A moving surface drives through contacts with a body that has no solver body.
        let batches = &self.plan.contacts.batches[group.contacts.clone()];
        for i in batches.iter().filter(|batch| batch.fixed).flat_map(|b| b.blocks.clone()) {
            let (block, extra) = (self.contact.blocks.read(i), self.contact.extras.read(i));
            for lane in 0..LANES {
                let solver_row = block.row_b[lane];
                let mut drifts = extra.drift.iter().chain(&extra.drift_t);
                if solver_row != 0
                    && drifts.any(|drift| drift[lane] != 0.0)
                    && let Some(bound) = bounds.get_mut(at(solver_row as usize) as usize)
                {
                    bound.is_quiet = false;
                }
            }
        }
    }

    fn restrain(&self, group: &Group, substep: u32, ripple: f64, bounds: &mut [Bound]) {
        self.weigh_islands(group, bounds);
        #[expect(clippy::cast_precision_loss, reason = "at most 256")]
        let elapsed = substep as f32 * self.ctx.h;
        let sweep = JointSweep::solving(self.ctx, elapsed);
        self.ask_contacts(group, elapsed, bounds);
        self.ask_joints(group, &sweep, bounds);
        self.ask_six_dof(group, &sweep, bounds);
        self.ask_trees(group, bounds);
        for i in group.couplings.clone() {
            let row = self.joint.couplings.read(i);
            let Some(bound) = row
                .solver_rows()
                .next()
                .and_then(|solver_row| self.over(solver_row, group, bounds))
            else {
                continue;
            };
            let [impulse, closing, drift] = row.pushed(&self.body.solver_bodies, &sweep);
            bound.drive(impulse, f64::from(drift));
            bound.close(f64::from(impulse), f64::from(closing), 0);
        }
        for bound in bounds.iter_mut().filter(|bound| bound.is_over) {
            bound.part = bound.part(ripple);
        }
        self.take_part(group, bounds);
    }

    /// Solver bodies of the islands that have joints.
    fn bin_rows(&self, group: &Group) -> impl Iterator<Item = usize> {
        self.plan.bins.solver_rows[group.bin_rows.clone()]
            .iter()
            .map(|solver_row| *solver_row as usize)
    }

    /// The bound of a solver body's island, if the island is over it.
    fn over<'b>(
        &self,
        solver_row: usize,
        group: &Group,
        bounds: &'b mut [Bound],
    ) -> Option<&'b mut Bound> {
        let bin = self.plan.bins.of_row[solver_row];
        let bound = bounds.get_mut((bin as usize).wrapping_sub(group.bins.start))?;
        bound.is_over.then_some(bound)
    }

    /// The bound of the island of a lane, if the island is over it.
    fn over_lane<'b>(
        &self,
        solver_rows: [u32; 2],
        group: &Group,
        bounds: &'b mut [Bound],
    ) -> Option<&'b mut Bound> {
        let solver_row = if solver_rows[1] == 0 { solver_rows[0] } else { solver_rows[1] };
        if solver_row == 0 { None } else { self.over(solver_row as usize, group, bounds) }
    }

    /// Sums mass, momentum and products of impulses of the islands over their bound. Islands with a
    /// body dragged by particles are exempt.
    fn weigh_islands(&self, group: &Group, bounds: &mut [Bound]) {
        for i in self.bin_rows(group) {
            let Some(bound) = self.over(i, group, bounds) else { continue };
            if self.bodies.at(self.plan.members[i - 1]).record.dragged {
                bound.is_over = false;
                continue;
            }
            let whitening = self.body.whitening.read(i);
            let alpha = f64::from(whitening.alpha());
            let mass = 1.0 / (alpha * alpha);
            let s = whitening.s();
            // The trace of I is at least 9 over the trace of its inverse.
            let inverse = f64::from(s.mul(Vec3::X).length_squared())
                + f64::from(s.mul(Vec3::Y).length_squared())
                + f64::from(s.mul(Vec3::Z).length_squared());
            let [v, w] = self.body.aux.read(i).before();
            let solver_body = self.body.solver_bodies.read(i);
            let place = DVec3::from(self.at_start(self.plan.members[i - 1]).center);
            bound.mass += mass;
            bound.first = bound.first + place * mass;
            bound.second += place.dot(place) * mass;
            bound.inertia += if inverse > 0.0 { 3.0 / inverse } else { 0.0 };
            bound.momentum = bound.momentum + DVec3::from(three(v)) * (1.0 / alpha);
            for (was, is) in [(v, solver_body.v), (w, solver_body.w)] {
                for c in 0..3 {
                    let (was, d) = (f64::from(was[c]), f64::from(is[c]) - f64::from(was[c]));
                    bound.along += was * d;
                    bound.square += d * d;
                }
            }
        }
    }

    fn side(&self, solver_row: u32) -> Side {
        if solver_row == 0 {
            return Side::FIXED;
        }
        let i = solver_row as usize;
        let moments = self.bodies.at(self.plan.members[i - 1]).inertia.moments;
        let turns = moments.max_element() > 0.0;
        let (solver_body, whitening) =
            (self.body.solver_bodies.read(i), self.body.whitening.read(i));
        let (alpha, s) = (whitening.alpha(), whitening.s());
        let [v, w] = self.body.aux.read(i).before();
        let motion = |v: [f32; 4]| DVec3::from(three(v) * alpha);
        let turn = |w: [f32; 4]| DVec3::from(s.mul(three(w)));
        Side {
            mass: f64::from(1.0 / (alpha * alpha)),
            moment: if turns { f64::from(moments.max_element()) } else { f64::INFINITY },
            moved: motion(solver_body.x),
            turn: turn(solver_body.t),
            v: [motion(v), motion(solver_body.v)],
            w: [turn(w), turn(solver_body.w)],
        }
    }

    fn tree_row(&self, tree: &Tree) -> usize {
        self.tree.bodies.read(tree.bodies.start).solver_row as usize
    }

    /// Scales all impulses of the islands over their bound by their factors.
    #[expect(clippy::cast_possible_truncation, reason = "a factor")]
    fn take_part(&self, group: &Group, bounds: &mut [Bound]) {
        for i in self.bin_rows(group) {
            let Some(bound) = self.over(i, group, bounds) else { continue };
            let (part, solver_body) = (bound.part as f32, self.body.solver_bodies.row(i));
            let [v, w] = self.body.aux.read(i).before();
            if part > 0.0 {
                for c in 0..4 {
                    solver_body.v[c] = v[c] + (solver_body.v[c] - v[c]) * part;
                    solver_body.w[c] = w[c] + (solver_body.w[c] - w[c]) * part;
                }
            } else {
                (solver_body.v, solver_body.w) = (v, w);
            }
        }
        for batch in &self.plan.contacts.batches[group.contacts.clone()] {
            for i in batch.blocks.clone() {
                let block = self.contact.blocks.row(i);
                for lane in 0..LANES {
                    let a = if batch.fixed { 0 } else { block.row_a[lane] };
                    let ends = [a, block.row_b[lane]];
                    let Some(bound) = self.over_lane(ends, group, bounds) else { continue };
                    let part = bound.part as f32;
                    let points = usize::from(block.count);
                    block.points[..points]
                        .iter_mut()
                        .for_each(|p| take(&mut p.impulse, lane, part));
                    block.friction.iter_mut().for_each(|p| take(p, lane, part));
                    if self.contact.has_extras {
                        let rolls = &mut self.contact.extras.row(i).rolling_impulse;
                        rolls.iter_mut().for_each(|p| take(p, lane, part));
                    }
                }
            }
        }
        self.take_part_of_joints(group, bounds);
    }

    #[expect(clippy::cast_possible_truncation, reason = "a factor")]
    fn take_part_of_joints(&self, group: &Group, bounds: &mut [Bound]) {
        let blocks = |of: &Layout, batches: &core::ops::Range<usize>| of.blocks_of(batches);
        for i in blocks(&self.plan.joints, &group.joints) {
            let (block, extra) = (self.joint.blocks.row(i), self.joint.extras.row(i));
            for lane in 0..LANES {
                let ends = [block.row_a[lane], block.row_b[lane]];
                let Some(bound) = self.over_lane(ends, group, bounds) else { continue };
                let part = bound.part as f32;
                for of in [
                    &mut block.impulse,
                    &mut block.carried_a,
                    &mut block.carried_b,
                    &mut extra.carried,
                ] {
                    of.iter_mut().for_each(|p| take(p, lane, part));
                }
            }
        }
        for i in blocks(&self.plan.six_dof, &group.six_dof) {
            let block = self.joint.six_dof.row(i);
            for lane in 0..LANES {
                let ends = [block.row_a[lane], block.row_b[lane]];
                let Some(bound) = self.over_lane(ends, group, bounds) else { continue };
                let part = bound.part as f32;
                for of in [&mut block.lock_or_drive, &mut block.friction, &mut block.limit] {
                    of.iter_mut().for_each(|p| take(p, lane, part));
                }
                for of in [
                    &mut block.carried,
                    &mut block.carried_a,
                    &mut block.carried_b,
                    &mut block.torque,
                ] {
                    of.iter_mut().for_each(|p| take(p, lane, part));
                }
            }
        }
        for tree in self.trees(group) {
            let solver_row = self.tree_row(tree);
            if let Some(bound) = self.over(solver_row, group, bounds) {
                self.restrain_tree(tree, bound.part);
            }
        }
        for i in group.couplings.clone() {
            let row = self.joint.couplings.row(i);
            let solver_row = row.solver_rows().next();
            if let Some(bound) =
                solver_row.and_then(|solver_row| self.over(solver_row, group, bounds))
            {
                row.restrain(bound.part as f32);
            }
        }
    }
}

/// Scales a lane's number by `part`; a result that is not finite becomes 0.
fn take(lanes: &mut Lanes, lane: usize, part: f32) {
    let new = lanes[lane] * part;
    lanes[lane] = if new.is_finite() { new } else { 0.0 };
}
