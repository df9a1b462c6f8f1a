//! Sums the impulses of contacts and joints over the whole step, for events and for breakage by
//! impact. The tables keep only the impulses of the last substep, and an impact may be over by
//! then.
//!
//! Impulses of a substep are added after its sweep; a relax sweep adds the change. Impacts add
//! theirs outside of sweeps. Sums are kept for contacts with a reporting shape or a breakable body,
//! and for contacts that may land in this step, whose impulse the hit event reports. Joints are
//! summed only while something can break.
//!
//! Joints also break by force: the maximum over the world's substeps. The world's substeps count
//! even where an island subdivides them. Otherwise the same impact would give a joint of a small
//! island a force that is larger by the number of parts.

use super::contact::store::approach;
use super::lent::Solver;
use super::plan::group::Group;
use super::plan::joint_class::DISTANCE;
use super::totals_rows::{
    ContactTally, ContactTotals, JointTally, LANDED, NEW, POINTS, Peaks, REQUESTED, TURNS, Totals,
    TreeTally, Watch, When, landed,
};
use crate::base::math::{bounded, vec3};
use crate::base::simd::wide::LANES;
use crate::state::bodies::NONE;

impl super::scratch::Scratch {
    /// Impulses in the last step of the contacts that landed or report forces, in no particular
    /// order.
    pub(crate) fn given(&self) -> impl Iterator<Item = ContactTotals> {
        let blocks =
            self.contact.watches.iter().zip(&self.contact.tallies).zip(&self.plan.contacts.owners);
        let watched = blocks.enumerate().filter(|(_, ((watch, _), _))| **watch != Watch::NONE);
        let summed = watched.flat_map(|(i, ((watch, tally), owners))| {
            let peaks = self.contact.peaks.get(i).copied().unwrap_or_default();
            let lanes = (0..LANES).filter(|lane| watch.0[*lane] & (REQUESTED | LANDED) != 0);
            lanes.map(move |lane| {
                let [x, y, z] = tally.push.map(|sum| bounded(sum[lane]));
                ContactTotals {
                    contact: owners[lane],
                    points: tally.points.map(|sum| bounded(sum[lane])),
                    push: vec3(x, y, z),
                    peaks: peaks.0.map(|peak| bounded(peak[lane])),
                    landed: landed(watch.0[lane]),
                    asked: watch.0[lane] & REQUESTED != 0,
                }
            })
        });
        summed.chain(self.classic.given.iter().copied())
    }
}

impl Solver<'_> {
    /// Decides at the step's start which contacts of a block are summed. `turns`: the block is
    /// rebuilt within the step.
    pub(super) fn watch(&self, i: usize, turns: bool) {
        let mut watch = Watch(self.contact.blocks.read(i).landing);
        if self.sum_requests.any() {
            for (lane, row) in self.plan.contacts.owners[i].iter().enumerate() {
                if *row != u32::MAX
                    && let Some(contact) = self.contacts.read(*row as usize)
                    && self.sum_requests.include(contact)
                {
                    watch.0[lane] |= REQUESTED;
                }
            }
        }
        if turns {
            watch.0.iter_mut().for_each(|bits| *bits |= TURNS);
        }
        if watch != Watch::NONE {
            self.begin_tally(i);
            *self.contact.watches.row(i) = watch;
        }
    }

    /// Adds points that may land, after a block was rebuilt within the step.
    pub(super) fn watch_more(&self, i: usize) {
        let more = self.contact.blocks.read(i).landing;
        for (bits, more) in self.contact.watches.row(i).0.iter_mut().zip(more) {
            *bits |= more;
        }
    }

    fn begin_tally(&self, i: usize) {
        *self.contact.tallies.row(i) = ContactTally::default();
        if self.sum_requests.any() {
            *self.contact.peaks.row(i) = Peaks::default();
        }
    }

    /// The sums of a block, if any are kept.
    #[inline(always)]
    pub(super) fn tally(&self, i: usize) -> Option<&mut ContactTally> {
        self.contact.watches.read(i).is_asked().then(|| self.contact.tallies.row(i))
    }

    /// Adds the impulses of a group's impacts to the sums.
    pub(super) fn add_impacts(&self, number: usize) {
        for (block, lane, bounce) in self.impacts.row(number).given() {
            let Some(tally) = self.tally(block) else { continue };
            tally.add_bounce(lane, bounce);
            if self.sum_requests.any() {
                self.contact.peaks.row(block).add_bounce(lane, bounce);
            }
        }
    }

    /// Finishes the sums of a block: converts peak impulses to forces and records the contacts that
    /// landed.
    pub(super) fn end_tally(&self, i: usize) {
        let Some(tally) = self.tally(i) else { return };
        let mut peaks = self.sum_requests.any().then(|| self.contact.peaks.row(i));
        for lane in 0..LANES {
            if let Some(Peaks(peaks)) = &mut peaks {
                for peak in peaks {
                    peak[lane] *= self.ctx.inv_h;
                }
            }
            if self.lands(i, lane, tally) {
                self.contact.watches.row(i).0[lane] |= LANDED;
            }
        }
    }

    /// True if a contact landed; stores the approach speed of one that touched before.
    fn lands(&self, i: usize, lane: usize, tally: &ContactTally) -> bool {
        let watch = self.contact.watches.read(i).0[lane];
        if watch & NEW != 0 {
            return self.contact.begun.read(i) >> lane & 1 == 1;
        }
        let pressed = |j: usize| watch >> j & 1 == 1 && tally.points[j][lane] > 0.0;
        if !(0..4).any(pressed) {
            return false;
        }
        let Some(c) = self.contacts.row(self.plan.contacts.owners[i][lane] as usize) else {
            return false;
        };
        let [a, b] = [c.body_a, c.body_b].map(|row| self.bodies.at(row));
        let speed = approach(c, watch & POINTS, (a, b), (self.ctx, None));
        c.set_approach(speed);
        true
    }

    /// Resets the sums of a group's joints.
    pub(super) fn begin_tallies(&self, group: &Group) {
        if !self.sum_requests.breakage {
            return;
        }
        for i in self.plan.joints.blocks_of(&group.joints) {
            *self.joint.tallies.row(i) = JointTally::default();
        }
        for i in self.plan.six_dof.blocks_of(&group.six_dof) {
            *self.joint.six_dof_tallies.row(i) = JointTally::default();
        }
        for tree in self.trees(group) {
            for (i, _) in self.tree_joints(tree) {
                *self.tree.tallies.row(i) = TreeTally::default();
            }
        }
    }

    /// Adds the joints' impulses after a sweep.
    pub(super) fn add_to_tallies(&self, group: &Group, when: When) {
        if !self.sum_requests.breakage {
            return;
        }
        for batch in &self.plan.joints.batches[group.joints.clone()] {
            for i in batch.blocks.clone() {
                let is_distance = batch.class == DISTANCE;
                let (block, extra) = (self.joint.blocks.read(i), self.joint.extras.read(i));
                let force = if is_distance { &extra.carried } else { &block.impulse };
                self.joint.tallies.row(i).add(force, &[[0.0; LANES]; 3], when);
            }
        }
        for tree in self.trees(group) {
            for (i, joint) in self.tree_joints(tree).filter(|(_, joint)| joint.six_dof != NONE) {
                let block = self.joint.six_dof.row(joint.six_dof as usize / LANES);
                self.tree.rows.read(i).put_six_dof(block, joint.six_dof);
            }
        }
        for i in self.plan.six_dof.blocks_of(&group.six_dof) {
            let block = self.joint.six_dof.read(i);
            self.joint.six_dof_tallies.row(i).add(&block.carried, &block.torque, when);
        }
        for tree in self.trees(group) {
            for (i, joint) in self.tree_joints(tree).filter(|(_, joint)| joint.six_dof == NONE) {
                let impulse = self.tree.rows.read(i).impulse.single();
                let now = if joint.is_child_a { -impulse } else { impulse };
                self.tree.tallies.row(i).add(now, when);
            }
        }
    }

    /// Writes the sums to the joints. A pendulum's joint has its own already.
    pub(super) fn store_tallies(&self, group: &Group) {
        if !self.sum_requests.breakage {
            return;
        }
        let give = |row: u32, totals: Totals| {
            if row != u32::MAX
                && let Some(joint) = self.joint_slots.row(row as usize)
            {
                (joint.given, joint.peak) = (totals.given, totals.peak);
            }
        };
        let joints = &self.plan.joints;
        for i in joints.blocks_of(&group.joints) {
            let block = self.joint.blocks.read(i);
            for (lane, row) in joints.owners[i].iter().enumerate().filter(|l| block.is_solved(l.0))
            {
                give(*row, self.joint.tallies.read(i).of(lane));
            }
        }
        let six_dof = &self.plan.six_dof;
        for i in six_dof.blocks_of(&group.six_dof) {
            for (lane, row) in six_dof.owners[i].iter().enumerate() {
                give(*row, self.joint.six_dof_tallies.read(i).of(lane));
            }
        }
        for tree in self.trees(group) {
            for (i, joint) in self.tree_joints(tree).filter(|(_, joint)| joint.six_dof == NONE) {
                give(joint.row, self.tree.tallies.read(i).totals());
            }
        }
    }
}
