//! Sweeps over the contacts of links: points one by one, then friction and twist together.
//!
//! The laws are those of the contact kernel (`contact/kernel.rs`), contact by contact. A row's
//! response is that of the whole tree.

use super::group::{LinkContact, LinkRow, TreeGroup};
use super::motion::impulse_mut;
use super::rows::Jacobian;
use crate::step::solver::contact::block::{ContactBlock, Extra};
use crate::step::solver::lent::Solver;

/// Parameters of a sweep over the contacts of links.
#[derive(Clone, Copy, Debug)]
pub(super) struct LinkSweep {
    pub(super) inv_h: f64,
    /// The sweep ends the step: nothing bounces, and springs keep their push.
    pub(super) relaxes: bool,
    /// Time of the step that positions have advanced [s].
    pub(super) elapsed: f64,
}

/// Law of a point: λ loses `min(target + leak λ + gain v, λ)`.
#[derive(Clone, Copy, Debug)]
struct Law {
    target: f64,
    leak: f64,
    gain: f64,
}

impl Solver<'_> {
    /// One sweep over all contacts of links.
    pub(super) fn sweep_links(&self, trees: &mut TreeGroup, sweep: &LinkSweep) {
        for index in 0..trees.contacts.len() {
            let contact = trees.contacts[index];
            let block = self.contact.blocks.row(contact.block);
            let extra = self.contact.has_extras.then(|| self.contact.extras.read(contact.block));
            let pressed = self.sweep_points(trees, &contact, block, extra, sweep);
            if pressed > 0.0 {
                block.pressed |= 1 << contact.lane;
            }
            self.sweep_tangents(trees, &contact, block, extra, (pressed, sweep.elapsed));
        }
    }

    /// Velocity along row `k` of a contact, without drift.
    fn speed(
        &self,
        trees: &TreeGroup,
        contact: &LinkContact,
        jacobian: &Jacobian,
        k: usize,
    ) -> f64 {
        let mut speed = trees.velocity(&trees.rows[contact.first + k], &trees.y);
        for (end, row) in contact.bodies.iter().enumerate() {
            if *row != 0 {
                let body = self.body.solver_bodies.read(*row as usize);
                speed += jacobian.along(end, body.v, body.w);
            }
        }
        speed
    }

    /// Applies an impulse on row `k` of a contact.
    pub(super) fn push_link(
        &self,
        trees: &mut TreeGroup,
        contact: &LinkContact,
        jacobian: &Jacobian,
        (k, impulse): (usize, f64),
    ) {
        if impulse == 0.0 {
            return;
        }
        let row = trees.rows[contact.first + k];
        TreeGroup::push(&trees.sparse, &row, impulse, &mut trees.y);
        for (end, row) in contact.bodies.iter().enumerate() {
            if *row != 0 {
                jacobian.push(end, impulse, self.body.solver_bodies.row(*row as usize));
            }
        }
    }

    /// Solves the points of a contact; gives the sum of their impulses.
    #[expect(clippy::cast_possible_truncation, reason = "blocks have this precision")]
    fn sweep_points(
        &self,
        trees: &mut TreeGroup,
        contact: &LinkContact,
        block: &mut ContactBlock,
        extra: Option<&Extra>,
        sweep: &LinkSweep,
    ) -> f64 {
        let lane = contact.lane;
        let mut sum = 0.0;
        for k in 0..contact.count {
            let jacobian = Jacobian::of(block, lane, k, contact.count);
            let mut speed = self.speed(trees, contact, &jacobian, k);
            let mut s = contact.separation[k];
            if let Some(extra) = extra.filter(|extra| extra.drifts) {
                let drift = f64::from(extra.drift[k][lane]);
                speed += drift;
                s += drift * sweep.elapsed;
            }
            let row = &trees.rows[contact.first + k];
            let law = law_of(contact, k, (row, s, speed), extra, sweep);
            let impulse = f64::from(block.points[k].impulse[lane]);
            let q = law.target + law.leak * impulse;
            let new = (impulse - (q + law.gain * speed).min(impulse)).max(0.0);
            // The block's rounding is part of the law: what it stores is what acts.
            let stored = new as f32;
            block.points[k].impulse[lane] = stored;
            let change = f64::from(stored) - impulse;
            self.push_link(trees, contact, &jacobian, (k, change));
            sum += f64::from(stored);
        }
        sum
    }

    /// Solves friction along both tangents and twist, as [`rub`] does.
    ///
    /// [`rub`]: crate::step::solver::contact::kernel
    #[expect(clippy::cast_possible_truncation, reason = "blocks have this precision")]
    fn sweep_tangents(
        &self,
        trees: &mut TreeGroup,
        contact: &LinkContact,
        block: &mut ContactBlock,
        extra: Option<&Extra>,
        (pressed, elapsed): (f64, f64),
    ) {
        let lane = contact.lane;
        let limit = f64::from(block.mu[lane]) * pressed;
        let old = [0, 1, 2].map(|t| f64::from(block.friction[t][lane]));
        if limit == 0.0 && old.iter().all(|x| *x == 0.0) {
            return;
        }
        let jacobians: [Jacobian; 3] =
            core::array::from_fn(|t| Jacobian::of(block, lane, contact.count + t, contact.count));
        let mut s: [f64; 3] =
            core::array::from_fn(|t| self.speed(trees, contact, &jacobians[t], contact.count + t));
        let mut kinetic = limit;
        if let Some(extra) = extra {
            if extra.drifts {
                for t in 0..2 {
                    let rate = f64::from(extra.drift_rate[t][lane]);
                    s[t] += f64::from(extra.drift_t[t][lane]) + rate * elapsed;
                }
                s[2] += f64::from(extra.drift_t[2][lane]);
            }
            if extra.slips {
                kinetic = limit * f64::from(extra.kinetic[lane]);
            }
        }
        let [m11, m12, m22, m13, m23, m33] = contact.mass_t;
        let mut new = [
            old[0] - (m11 * s[0] + m12 * s[1] + m13 * s[2]),
            old[1] - (m12 * s[0] + m22 * s[1] + m23 * s[2]),
            old[2] - (m13 * s[0] + m23 * s[1] + m33 * s[2]),
        ];
        let square = |v: &[f64; 3]| v.iter().map(|x| x * x).sum::<f64>();
        if square(&new) > limit * limit {
            new = core::array::from_fn(|t| old[t] - contact.mass_slide * s[t]);
            let size = square(&new);
            if size > kinetic * kinetic {
                let back = kinetic / size.sqrt();
                new = new.map(|x| x * back);
            }
        }
        for t in 0..3 {
            let stored = new[t] as f32;
            block.friction[t][lane] = stored;
            let change = f64::from(stored) - old[t];
            self.push_link(trees, contact, &jacobians[t], (contact.count + t, change));
        }
    }

    /// Speeds after a bounce of the points that arrive in this substep.
    pub(super) fn find_bounces(&self, trees: &mut TreeGroup) {
        for index in 0..trees.contacts.len() {
            let mut contact = trees.contacts[index];
            contact.bounce = [0.0; 4];
            if self.contact.has_extras {
                let block = self.contact.blocks.read(contact.block);
                let extra = self.contact.extras.read(contact.block);
                let restitution = f64::from(extra.restitution[contact.lane]);
                if extra.bounces && restitution > 0.0 {
                    let minimum =
                        f64::from(self.ctx.restitution_speed.max(extra.slow[contact.lane]));
                    for k in 0..contact.count {
                        let jacobian = Jacobian::of(block, contact.lane, k, contact.count);
                        let speed = self.arrival(trees, &contact, &jacobian, k);
                        let meets = contact.separation[k] + speed * f64::from(self.ctx.h) < 0.0;
                        if meets && speed < -minimum {
                            contact.bounce[k] = -restitution * speed;
                        }
                    }
                }
            }
            trees.contacts[index] = contact;
        }
    }

    /// Velocity along a point's row before any impulse of this substep.
    fn arrival(
        &self,
        trees: &TreeGroup,
        contact: &LinkContact,
        jacobian: &Jacobian,
        k: usize,
    ) -> f64 {
        let mut speed = trees.velocity(&trees.rows[contact.first + k], &trees.y_start);
        for (end, row) in contact.bodies.iter().enumerate() {
            if *row != 0 {
                let [v, w] = self.body.aux.read(*row as usize).before();
                speed += jacobian.along(end, v, w);
            }
        }
        speed
    }

    /// Takes the impulses of bounces out of what the next substep starts from: an impact does not
    /// repeat.
    pub(super) fn end_bounces(&self, trees: &TreeGroup) {
        for contact in trees.contacts.iter().filter(|contact| contact.bounces()) {
            let (block, lane) = (self.contact.blocks.row(contact.block), contact.lane);
            block.hit |= 1 << lane;
            for k in 0..contact.count + 3 {
                let jacobian = Jacobian::of(block, lane, k, contact.count);
                let taken = core::mem::take(impulse_mut(block, lane, k, contact.count));
                for (end, row) in contact.bodies.iter().enumerate() {
                    if *row != 0 {
                        let mut change = Default::default();
                        jacobian.push(end, f64::from(taken), &mut change);
                        let aux = self.body.aux.row(*row as usize);
                        aux.begin_later(&change.v, 1.0, &change.w, 1.0);
                    }
                }
            }
        }
    }
}

/// The law of a point with this row, separation [m] and speed [m/s].
fn law_of(
    contact: &LinkContact,
    k: usize,
    (row, s, speed): (&LinkRow, f64, f64),
    extra: Option<&Extra>,
    sweep: &LinkSweep,
) -> Law {
    let mass = row.mass;
    let inv_h = sweep.inv_h;
    let rigid = Law { target: 0.0, leak: 0.0, gain: mass };
    if contact.bounce[k] > 0.0 && !sweep.relaxes {
        return Law { target: -mass * contact.bounce[k], ..rigid };
    }
    let own = extra.filter(|extra| extra.softens && extra.soft_mass[contact.lane] > 0.0);
    if let Some(extra) = own {
        if sweep.relaxes {
            // Nothing changes: see `soften` in the contact kernel.
            return Law { gain: 0.0, ..rigid };
        }
        if s * inv_h + speed > 0.0 {
            return Law { target: mass * s * inv_h, ..rigid };
        }
        return Law {
            target: f64::from(extra.soft_rate[contact.lane]) * mass * s,
            leak: f64::from(extra.soft_impulse[contact.lane]),
            gain: mass * f64::from(extra.soft_mass[contact.lane]),
        };
    }
    // Overlaps are closed by displacement (`overlaps.rs`). A push-out by velocity between links
    // that their joints hold together would drive the tree forever.
    Law { target: mass * s.max(0.0) * inv_h, ..rigid }
}
