//! What contacts and joints gave over the whole step: for what breaks by a blow. Tables keep the impulses of
//! the last substep, and a blow may have been over by then.
//!
//! Impulses of a substep are summed after its sweep; a relax sweep adds what it changes. Impacts add theirs as they give
//! them. Only blocks with a body that can break are looked at, and joints only while something can.

use fearless_simd::dispatch;

use super::Solver;
use super::plan::{DISTANCE, Group};
use super::rows::ContactBlock;
use crate::base::math::{Vec3, vec3};
use crate::base::wide::{LANES, Lanes};
use crate::state::bodies::{Bodies, NONE};
use crate::state::contacts::Contact;

/// Adds the impulses that a sweep left: all of them, or what a relax sweep changed.
fn add(sum: &mut Lanes, last: &mut Lanes, now: &Lanes, is_relax: bool) {
    for lane in 0..LANES {
        sum[lane] += if is_relax { now[lane] - last[lane] } else { now[lane] };
    }
    *last = *now;
}

/// The sums of a block of contacts.
#[derive(Clone, Debug, Default)]
pub(crate) struct ContactTally {
    /// One of its contacts has a body that can break.
    pub(super) wanted: bool,
    /// Along the normal at each point [N s].
    pub(super) points: [Lanes; 4],
    /// Friction along t1 and t2 [N s].
    pub(super) rub: [Lanes; 2],
    /// What was there after the last sweep.
    last: [Lanes; 6],
}

impl ContactTally {
    fn begin(&mut self, wanted: bool) {
        self.wanted = wanted;
        if wanted {
            *self = Self { wanted, ..Self::default() };
        }
    }

    fn add(&mut self, block: &ContactBlock, is_relax: bool) {
        let of_points = block.points.iter().map(|p| &p.impulse).zip(&mut self.points);
        let count = usize::from(block.count.clamp(1, 4));
        let rubs = block.friction[..2].iter().zip(&mut self.rub);
        for ((now, sum), last) in of_points.take(count).chain(rubs).zip(&mut self.last) {
            add(sum, last, now, is_relax);
        }
    }
}

/// The sums of a block of joints.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct JointTally {
    /// Force, then torque.
    sum: [Lanes; 6],
    last: [Lanes; 6],
}

impl JointTally {
    fn add(&mut self, force: &[Lanes; 3], turn: &[Lanes; 3], is_relax: bool) {
        let now = force.iter().chain(turn);
        for ((now, sum), last) in now.zip(&mut self.sum).zip(&mut self.last) {
            add(sum, last, now, is_relax);
        }
    }

    pub(super) fn of(&self, lane: usize) -> [Vec3; 2] {
        let [fx, fy, fz, tx, ty, tz] = &self.sum;
        [vec3(fx[lane], fy[lane], fz[lane]), vec3(tx[lane], ty[lane], tz[lane])]
    }
}

/// What a contact gave in a step: along its normal at each of its points, and friction [N s, world], on B.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Given {
    pub(crate) contact: u32,
    pub(crate) points: [f32; 4],
    pub(crate) rub: Vec3,
}

impl super::Scratch {
    /// Room for the sums of a step in which something can break; none in another. Those of trees are force and
    /// torque, then what was there after the last sweep.
    pub(super) fn make_tallies(&mut self, breakage: bool) {
        let room = |n: usize| if breakage { n } else { 0 };
        self.tallies.resize_with(room(self.plan.contacts.owners.len()), ContactTally::default);
        let none = JointTally::default();
        self.joint_tallies.resize(room(self.plan.joints.owners.len()), none);
        self.six_tallies.resize(room(self.plan.sixdofs.owners.len()), none);
        self.tree_tallies.resize(room(self.plan.forest.joints.len()), [Vec3::ZERO; 2]);
    }

    /// What contacts with bodies that can break gave in the last step; in no order. `None` after a step of a
    /// classic method, which knows no more than the contacts' own impulses.
    pub(crate) fn given(&self) -> Option<impl Iterator<Item = Given>> {
        if self.tallies.is_empty() {
            return None;
        }
        let blocks = self.tallies.iter().zip(&self.blocks).zip(&self.plan.contacts.owners);
        Some(blocks.filter(|((tally, _), _)| tally.wanted).flat_map(|((tally, block), owners)| {
            let owned = owners.iter().enumerate().filter(|(_, row)| **row != u32::MAX);
            owned.map(move |(lane, row)| {
                let along = |t: &[Lanes; 3]| vec3(t[0][lane], t[1][lane], t[2][lane]);
                let rub = along(&block.t1) * tally.rub[0][lane];
                Given {
                    contact: *row,
                    points: tally.points.map(|p| p[lane]),
                    rub: rub + along(&block.t2) * tally.rub[1][lane],
                }
            })
        }))
    }
}

impl Solver<'_> {
    fn breaks(bodies: &Bodies, contact: &Contact) -> bool {
        bodies.at(contact.body_a).breaks || bodies.at(contact.body_b).breaks
    }

    /// Empties the sums of a group.
    pub(super) fn begin_tallies(&self, group: &Group) {
        if !self.has_tallies {
            return;
        }
        for i in self.plan.contacts.blocks_of(&group.contacts) {
            let owners = self.plan.contacts.owners[i].iter().filter(|row| **row != u32::MAX);
            let mut contacts = owners.filter_map(|row| self.contacts.read(*row as usize).as_ref());
            self.tallies.row(i).begin(contacts.any(|c| Self::breaks(self.bodies, c)));
        }
        for i in self.plan.joints.blocks_of(&group.joints) {
            *self.joint_tallies.row(i) = JointTally::default();
        }
        for i in self.plan.sixdofs.blocks_of(&group.sixdofs) {
            *self.six_tallies.row(i) = JointTally::default();
        }
        for tree in self.trees(group) {
            for (i, _) in self.tree_joints(tree) {
                *self.tree_tallies.row(i) = [Vec3::ZERO; 2];
            }
        }
    }

    /// Adds what a sweep left of impulses.
    pub(super) fn add_to_tallies(&self, group: &Group, is_relax: bool) {
        if !self.has_tallies {
            return;
        }
        dispatch!(self.ctx.level, _simd => {
            for i in self.plan.contacts.blocks_of(&group.contacts) {
                if self.tallies.read(i).wanted {
                    self.tallies.row(i).add(self.blocks.read(i), is_relax);
                }
            }
        });
        for batch in &self.plan.joints.batches[group.joints.clone()] {
            for i in batch.blocks.clone() {
                let block = self.joints.read(i);
                let is_distance = batch.class == DISTANCE;
                let force = if is_distance { &block.carried } else { &block.impulse };
                self.joint_tallies.row(i).add(force, &[[0.0; LANES]; 3], is_relax);
            }
        }
        for tree in self.trees(group) {
            for (i, joint) in self.tree_joints(tree).filter(|(_, joint)| joint.six != NONE) {
                let block = self.sixdofs.row(joint.six as usize / LANES);
                self.tree_rows.read(i).put_six(block, joint.six);
            }
        }
        for i in self.plan.sixdofs.blocks_of(&group.sixdofs) {
            let block = self.sixdofs.read(i);
            self.six_tallies.row(i).add(&block.carried, &block.torque, is_relax);
        }
        for tree in self.trees(group) {
            for (i, joint) in self.tree_joints(tree).filter(|(_, joint)| joint.six == NONE) {
                let impulse = self.tree_rows.read(i).impulse.single();
                let now = if joint.is_child_a { -impulse } else { impulse };
                let [sum, last] = self.tree_tallies.row(i);
                *sum += if is_relax { now - *last } else { now };
                *last = now;
            }
        }
    }

    /// Gives the joints their sums; before a joint whose body swings says what it gave.
    pub(super) fn store_tallies(&self, group: &Group) {
        if !self.has_tallies {
            return;
        }
        let give = |row: u32, given: [Vec3; 2]| {
            if row != u32::MAX
                && let Some(joint) = self.joint_slots.row(row as usize)
            {
                joint.given = given;
            }
        };
        let joints = &self.plan.joints;
        for i in joints.blocks_of(&group.joints) {
            for (lane, row) in joints.owners[i].iter().enumerate() {
                give(*row, self.joint_tallies.read(i).of(lane));
            }
        }
        let sixdofs = &self.plan.sixdofs;
        for i in sixdofs.blocks_of(&group.sixdofs) {
            for (lane, row) in sixdofs.owners[i].iter().enumerate() {
                give(*row, self.six_tallies.read(i).of(lane));
            }
        }
        for tree in self.trees(group) {
            for (i, joint) in self.tree_joints(tree).filter(|(_, joint)| joint.six == NONE) {
                give(joint.row, [self.tree_tallies.read(i)[0], Vec3::ZERO]);
            }
        }
    }
}
