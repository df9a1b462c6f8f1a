//! What contacts and joints gave over the whole step: for what breaks by a blow. Tables keep the impulses of
//! the last substep, and a blow may have been over by then.
//!
//! Impulses of a substep are summed after its sweep; a relax sweep adds what it changes. Impacts add theirs as they give
//! them. Only blocks with a body that can break are looked at, and joints only while something can.
//!
//! Joints break by force as well: that of the substep of the step in which it was greatest. That is a substep of the world, in
//! whatever parts an island takes it, or a blow would weigh as many times as much on a joint of a small island.

use fearless_simd::dispatch;

use super::Solver;
use super::plan::{DISTANCE, Group};
use super::rows::ContactBlock;
use crate::base::math::{Vec3, bounded, greater, vec3};
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

/// Which sweep left the impulses.
#[derive(Clone, Copy, Debug)]
pub(super) struct When {
    pub(super) is_relax: bool,
    /// It begins, and it ends, a substep of the world.
    begins: bool,
    ends: bool,
}

impl When {
    /// `part` of a step in which each substep is taken in `parts`; a relax sweep at the step's end is of the last one.
    pub(super) fn solved(part: u32, parts: u32) -> Self {
        Self {
            is_relax: false,
            begins: part.is_multiple_of(parts),
            ends: (part + 1).is_multiple_of(parts),
        }
    }

    pub(super) const fn relaxed() -> Self {
        Self { is_relax: true, begins: false, ends: true }
    }
}

/// The sums of a block of joints.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct JointTally {
    /// Force, then torque.
    sum: [Lanes; 6],
    last: [Lanes; 6],
    /// What the sums were as the substep began.
    start: [Lanes; 6],
    /// Greatest of a substep so far, squared: force, torque.
    peak: [Lanes; 2],
}

impl JointTally {
    fn add(&mut self, force: &[Lanes; 3], turn: &[Lanes; 3], when: When) {
        if when.begins {
            self.start = self.sum;
        }
        let now = force.iter().chain(turn);
        for ((now, sum), last) in now.zip(&mut self.sum).zip(&mut self.last) {
            add(sum, last, now, when.is_relax);
        }
        if when.ends {
            for (i, peak) in self.peak.iter_mut().enumerate() {
                for lane in 0..LANES {
                    let of = |k: usize| self.sum[3 * i + k][lane] - self.start[3 * i + k][lane];
                    peak[lane] = greater(vec3(of(0), of(1), of(2)).length_squared(), peak[lane]);
                }
            }
        }
    }

    fn of(&self, lane: usize) -> Totals {
        let [fx, fy, fz, tx, ty, tz] = &self.sum;
        Totals {
            given: [vec3(fx[lane], fy[lane], fz[lane]), vec3(tx[lane], ty[lane], tz[lane])],
            peak: self.peak.map(|peak| peak[lane].sqrt()),
        }
        .bounded()
    }
}

/// The sums of a ball joint of a tree.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct TreeTally {
    sum: Vec3,
    last: Vec3,
    start: Vec3,
    peak: f32,
}

impl TreeTally {
    fn add(&mut self, now: Vec3, when: When) {
        if when.begins {
            self.start = self.sum;
        }
        self.sum += if when.is_relax { now - self.last } else { now };
        self.last = now;
        if when.ends {
            self.peak = greater((self.sum - self.start).length(), self.peak);
        }
    }

    fn totals(&self) -> Totals {
        Totals { given: [self.sum, Vec3::ZERO], peak: [self.peak, 0.0] }.bounded()
    }
}

/// What a joint gave in a step, and the greatest of a substep [N s, N m s].
#[derive(Clone, Copy, Debug)]
struct Totals {
    given: [Vec3; 2],
    peak: [f32; 2],
}

impl Totals {
    /// Squares of what is given overflow before it does.
    fn bounded(self) -> Self {
        Self { given: self.given.map(Vec3::bounded), peak: self.peak.map(bounded) }
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
    /// Room for the sums of a step in which something can break; none in another.
    pub(super) fn make_tallies(&mut self, breakage: bool) {
        let room = |n: usize| if breakage { n } else { 0 };
        self.tallies.resize_with(room(self.plan.contacts.owners.len()), ContactTally::default);
        let none = JointTally::default();
        self.joint_tallies.resize(room(self.plan.joints.owners.len()), none);
        self.six_tallies.resize(room(self.plan.sixdofs.owners.len()), none);
        let none = TreeTally::default();
        self.tree_tallies.resize(room(self.plan.forest.joints.len()), none);
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
                *self.tree_tallies.row(i) = TreeTally::default();
            }
        }
    }

    /// Adds what a sweep left of impulses.
    pub(super) fn add_to_tallies(&self, group: &Group, when: When) {
        if !self.has_tallies {
            return;
        }
        dispatch!(self.ctx.level, _simd => {
            for i in self.plan.contacts.blocks_of(&group.contacts) {
                if self.tallies.read(i).wanted {
                    self.tallies.row(i).add(self.blocks.read(i), when.is_relax);
                }
            }
        });
        for batch in &self.plan.joints.batches[group.joints.clone()] {
            for i in batch.blocks.clone() {
                let is_distance = batch.class == DISTANCE;
                let (block, rest) = (self.joints.read(i), self.joint_rests.read(i));
                let force = if is_distance { &rest.carried } else { &block.impulse };
                self.joint_tallies.row(i).add(force, &[[0.0; LANES]; 3], when);
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
            self.six_tallies.row(i).add(&block.carried, &block.torque, when);
        }
        for tree in self.trees(group) {
            for (i, joint) in self.tree_joints(tree).filter(|(_, joint)| joint.six == NONE) {
                let impulse = self.tree_rows.read(i).impulse.single();
                let now = if joint.is_child_a { -impulse } else { impulse };
                self.tree_tallies.row(i).add(now, when);
            }
        }
    }

    /// Gives the joints their sums; before a joint whose body swings says what it gave.
    pub(super) fn store_tallies(&self, group: &Group) {
        if !self.has_tallies {
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
                give(joint.row, self.tree_tallies.read(i).totals());
            }
        }
    }
}
