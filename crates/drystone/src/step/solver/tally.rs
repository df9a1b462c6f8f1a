//! What contacts and joints gave over the whole step: for events, and for what breaks by a blow. Tables keep the impulses of
//! the last substep, and a blow may have been over by then.
//!
//! Impulses of a substep are summed after its sweep; a relax sweep adds what it changes. Impacts give theirs outside of
//! sweeps. Summed are contacts that a user or a body that can break asks for, and those that may land in this step, whose
//! impulse is told with the hit; joints only while something can break.
//!
//! Joints break by force as well: that of the substep of the step in which it was greatest. That is a substep of the world, in
//! whatever parts an island takes it, or a blow would weigh as many times as much on a joint of a small island.

use super::Solver;
use super::plan::{DISTANCE, Group};
use super::rows::ContactBlock;
use super::unpack::approach;
use crate::base::grow;
use crate::base::math::{Vec3, bounded, greater, vec3};
use crate::base::wide::{LANES, Lanes};
use crate::state::bodies::{Bodies, NONE};
use crate::state::contacts::Contact;
use crate::state::shapes::Shapes;

/// Adds the impulses that a sweep left: all of them, or what a relax sweep changed.
fn add(sum: &mut Lanes, last: &mut Lanes, now: &Lanes, is_relax: bool) {
    for lane in 0..LANES {
        sum[lane] += if is_relax { now[lane] - last[lane] } else { now[lane] };
    }
    *last = *now;
}

/// Contacts of a block whose impulses are summed: a byte for each lane, 0 for none. Bits 0 to 3 are points that bore nothing
/// when the step began and arrive as fast as a hit; see [`NEW`], [`ASKED`], [`LANDED`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Watch([u8; LANES]);

impl Watch {
    /// Nothing is summed.
    const NONE: Self = Self([0; LANES]);

    /// True if sums of some lane are kept.
    pub(super) fn is_asked(&self) -> bool {
        *self != Self::NONE
    }
}

/// The points of a lane of a [`Watch`].
pub(super) const POINTS: u8 = 0x0f;

/// The pair did not touch before.
pub(super) const NEW: u8 = 0x10;

/// A body of the contact can break, or a shape reports forces.
const ASKED: u8 = 0x20;

/// Points of bits 0 to 3, or any of a new contact, were pressed in the step.
const LANDED: u8 = 0x40;

/// It is made anew within the step, and other points of it may land then: it is summed from the start.
const TURNS: u8 = 0x80;

/// The sums of a block of contacts.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ContactTally {
    /// Along the normal at each point [N s].
    points: [Lanes; 4],
    /// All on B, friction included [N s, world].
    push: [Lanes; 3],
}

/// Greatest impulse of a substep, of each point and of all together [N s]; at the step's end as forces [N].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Peaks([Lanes; 5]);

impl ContactTally {
    /// Adds what impacts gave to a lane.
    fn add_bounce(&mut self, lane: usize, bounce: &Bounce) {
        for (sum, p) in self.points.iter_mut().zip(bounce.points) {
            sum[lane] += p;
        }
        for (sum, p) in self.push.iter_mut().zip(bounce.push.to_array()) {
            sum[lane] += p;
        }
    }

    /// Adds the block's impulses, `times` 1, or takes them away again, before a sweep that changes them, by -1.
    #[inline(always)]
    pub(super) fn add(&mut self, block: &ContactBlock, times: f32) {
        let count = usize::from(block.count.clamp(1, 4));
        let mut total = [0.0; LANES];
        for (sum, point) in self.points.iter_mut().zip(&block.points).take(count) {
            for lane in 0..LANES {
                sum[lane] += times * point.impulse[lane];
                total[lane] += point.impulse[lane];
            }
        }
        let [f1, f2, _] = &block.friction;
        for (i, sum) in self.push.iter_mut().enumerate() {
            let (n, t1, t2) = (&block.n[i], &block.t1[i], &block.t2[i]);
            for lane in 0..LANES {
                let rub = t1[lane] * f1[lane] + t2[lane] * f2[lane];
                sum[lane] += times * (n[lane] * total[lane] + rub);
            }
        }
    }
}

impl Peaks {
    /// Adds what impacts gave to a lane.
    fn add_bounce(&mut self, lane: usize, bounce: &Bounce) {
        let [p, q, r, s] = bounce.points;
        for (peak, p) in self.0.iter_mut().zip([p, q, r, s, p + q + r + s]) {
            peak[lane] += p;
        }
    }

    /// Notes what the block gave in a substep.
    #[inline(always)]
    pub(super) fn note(&mut self, block: &ContactBlock) {
        let count = usize::from(block.count.clamp(1, 4));
        let [peaks @ .., most] = &mut self.0;
        let mut total = [0.0; LANES];
        for (peak, point) in peaks.iter_mut().zip(&block.points).take(count) {
            for lane in 0..LANES {
                peak[lane] = greater(point.impulse[lane], peak[lane]);
                total[lane] += point.impulse[lane];
            }
        }
        for lane in 0..LANES {
            most[lane] = greater(total[lane], most[lane]);
        }
    }
}

/// The impulses that bounces of a contact gave, outside of sweeps [N s; all of it: world, on B].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Bounce {
    pub(super) points: [f32; 4],
    pub(super) push: Vec3,
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

/// What a contact gave in a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Given {
    pub(crate) contact: u32,
    /// Along its normal at each of its points [N s]. A contact that was made anew within the step may have fewer points now.
    pub(crate) points: [f32; 4],
    /// All on B, friction included [N s, world].
    pub(crate) push: Vec3,
    /// Greatest force of a substep, of each point and of all together [N].
    pub(crate) peaks: [f32; 5],
    /// Points, bits, that were pressed for the first time or bore nothing before; [`Contact::approach`] tells how fast they
    /// came. 0 if none did.
    pub(crate) landed: u8,
    /// A body of it can break, or a shape reports forces.
    pub(crate) asked: bool,
}

/// Whose impulses are asked for in a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Askers<'a> {
    pub(super) bodies: &'a Bodies,
    pub(super) shapes: &'a Shapes,
    /// Some body or joint can break.
    pub(super) breakage: bool,
}

impl Askers<'_> {
    /// False if nobody asks for any.
    pub(super) const fn any(&self) -> bool {
        self.breakage || self.shapes.report_forces > 0
    }

    /// Whether a contact's are asked for.
    pub(super) fn ask_for(&self, contact: &Contact) -> bool {
        let breaks = |row: u32| self.bodies.at(row).breaks;
        let reports = |row: u32| self.shapes.at(row).reports.forces;
        self.breakage && (breaks(contact.body_a) || breaks(contact.body_b))
            || self.shapes.report_forces > 0
                && (reports(contact.shape_a) || reports(contact.shape_b))
    }
}

/// The points of a lane that landed.
const fn landed(watch: u8) -> u8 {
    match (watch & LANDED != 0, watch & NEW != 0) {
        (false, _) => 0,
        (true, false) => watch & POINTS,
        (true, true) => POINTS,
    }
}

impl super::Scratch {
    /// Room for the sums of a step; for those of joints only if something can break.
    pub(super) fn make_tallies(&mut self, (breakage, asks): (bool, bool)) {
        let blocks = self.plan.contacts.owners.len();
        self.watches.clear();
        self.watches.resize(blocks, Watch::NONE);
        if self.tallies.len() < blocks {
            grow::resize(&mut self.tallies, blocks, ContactTally::default());
        }
        self.peaks.resize(if asks { blocks } else { 0 }, Peaks::default());
        let room = |n: usize| if breakage { n } else { 0 };
        let none = JointTally::default();
        self.joint_tallies.resize(room(self.plan.joints.owners.len()), none);
        self.six_tallies.resize(room(self.plan.sixdofs.owners.len()), none);
        let none = TreeTally::default();
        self.tree_tallies.resize(room(self.plan.forest.joints.len()), none);
    }

    /// What the contacts gave in the last step that landed or are asked for; in no order.
    pub(crate) fn given(&self) -> impl Iterator<Item = Given> {
        let blocks = self.watches.iter().zip(&self.tallies).zip(&self.plan.contacts.owners);
        let watched = blocks.enumerate().filter(|(_, ((watch, _), _))| **watch != Watch::NONE);
        let summed = watched.flat_map(|(i, ((watch, tally), owners))| {
            let peaks = self.peaks.get(i).copied().unwrap_or_default();
            let lanes = (0..LANES).filter(|lane| watch.0[*lane] & (ASKED | LANDED) != 0);
            lanes.map(move |lane| {
                let [x, y, z] = tally.push.map(|sum| bounded(sum[lane]));
                Given {
                    contact: owners[lane],
                    points: tally.points.map(|sum| bounded(sum[lane])),
                    push: vec3(x, y, z),
                    peaks: peaks.0.map(|peak| bounded(peak[lane])),
                    landed: landed(watch.0[lane]),
                    asked: watch.0[lane] & ASKED != 0,
                }
            })
        });
        summed.chain(self.classic.given.iter().copied())
    }
}

impl Solver<'_> {
    /// Decides which contacts of a block are summed, as the step begins. `turns`: they are made anew within the step.
    pub(super) fn watch(&self, i: usize, turns: bool) {
        let mut watch = Watch(self.blocks.read(i).landing);
        if self.askers.any() {
            for (lane, row) in self.plan.contacts.owners[i].iter().enumerate() {
                if *row != u32::MAX
                    && let Some(contact) = self.contacts.read(*row as usize)
                    && self.askers.ask_for(contact)
                {
                    watch.0[lane] |= ASKED;
                }
            }
        }
        if turns {
            watch.0.iter_mut().for_each(|bits| *bits |= TURNS);
        }
        if watch != Watch::NONE {
            self.begin_tally(i);
            *self.watches.row(i) = watch;
        }
    }

    /// Notes what may land besides, of a block that was made anew within the step.
    pub(super) fn watch_more(&self, i: usize) {
        let more = self.blocks.read(i).landing;
        for (bits, more) in self.watches.row(i).0.iter_mut().zip(more) {
            *bits |= more;
        }
    }

    fn begin_tally(&self, i: usize) {
        *self.tallies.row(i) = ContactTally::default();
        if self.askers.any() {
            *self.peaks.row(i) = Peaks::default();
        }
    }

    /// The sums of a block, if there are any.
    #[inline(always)]
    pub(super) fn tally(&self, i: usize) -> Option<&mut ContactTally> {
        self.watches.read(i).is_asked().then(|| self.tallies.row(i))
    }

    /// Impulses of a group's impacts come to the sums.
    pub(super) fn add_impacts(&self, number: usize) {
        for (block, lane, bounce) in self.impacts.row(number).given() {
            let Some(tally) = self.tally(block) else { continue };
            tally.add_bounce(lane, bounce);
            if self.askers.any() {
                self.peaks.row(block).add_bounce(lane, bounce);
            }
        }
    }

    /// Ends the sums of a block: peaks become forces, and it is known what landed.
    pub(super) fn end_tally(&self, i: usize) {
        let Some(tally) = self.tally(i) else { return };
        let mut peaks = self.askers.any().then(|| self.peaks.row(i));
        for lane in 0..LANES {
            if let Some(Peaks(peaks)) = &mut peaks {
                for peak in peaks {
                    peak[lane] *= self.ctx.inv_h;
                }
            }
            if self.lands(i, lane, tally) {
                self.watches.row(i).0[lane] |= LANDED;
            }
        }
    }

    /// Whether a contact landed; one that touched before is told the speed.
    fn lands(&self, i: usize, lane: usize, tally: &ContactTally) -> bool {
        let watch = self.watches.read(i).0[lane];
        if watch & NEW != 0 {
            return self.begun.read(i) >> lane & 1 == 1;
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

    /// Empties the sums of a group's joints.
    pub(super) fn begin_tallies(&self, group: &Group) {
        if !self.askers.breakage {
            return;
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

    /// Adds what a sweep left of the joints' impulses.
    pub(super) fn add_to_tallies(&self, group: &Group, when: When) {
        if !self.askers.breakage {
            return;
        }
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
        if !self.askers.breakage {
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
