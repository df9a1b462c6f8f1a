//! Accumulates the impulses of contacts and joints over the substeps of a step.

use super::contact::block::ContactBlock;
use crate::base::math::{Vec3, bounded, greater, vec3};
use crate::base::simd::wide::{LANES, Lanes};
use crate::state::bodies::Bodies;
use crate::state::contacts::Contact;
use crate::state::shapes::Shapes;

/// Adds the impulses after a sweep: all of them, or the change by a relax sweep.
pub(crate) fn add(sum: &mut Lanes, last: &mut Lanes, now: &Lanes, is_relax: bool) {
    for lane in 0..LANES {
        sum[lane] += if is_relax { now[lane] - last[lane] } else { now[lane] };
    }
    *last = *now;
}

/// Contacts of a block whose impulses are summed: one byte for each lane, 0 for none. Bits 0 to 3
/// are points that bore no load at the step's start and approach as fast as a hit; see [`NEW`],
/// [`REQUESTED`], [`LANDED`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Watch(pub(super) [u8; LANES]);

impl Watch {
    /// Nothing is summed.
    pub(crate) const NONE: Self = Self([0; LANES]);

    /// True if sums of some lane are kept.
    pub(super) fn is_asked(&self) -> bool {
        *self != Self::NONE
    }
}

/// The points of a lane of a [`Watch`].
pub(crate) const POINTS: u8 = 0x0f;

/// The pair did not touch before.
pub(crate) const NEW: u8 = 0x10;

/// A body of the contact can break, or a shape reports forces.
pub(crate) const REQUESTED: u8 = 0x20;

/// Points of bits 0 to 3, or any point of a new contact, were pressed in the step.
pub(crate) const LANDED: u8 = 0x40;

/// The contact is rebuilt within the step and may land at other points then, so it is summed from
/// the start.
pub(crate) const TURNS: u8 = 0x80;

/// The sums of a block of contacts.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ContactTally {
    /// Along the normal at each point [N s].
    pub(crate) points: [Lanes; 4],
    /// Total impulse on B, friction included [N s, world].
    pub(crate) push: [Lanes; 3],
}

/// Maximum impulse of a substep, for each point and for their total [N s]; at the step's end as
/// forces [N].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Peaks(pub(super) [Lanes; 5]);

impl ContactTally {
    /// Adds the impulses of impacts to a lane.
    pub(crate) fn add_bounce(&mut self, lane: usize, bounce: &Bounce) {
        for (sum, p) in self.points.iter_mut().zip(bounce.points) {
            sum[lane] += p;
        }
        for (sum, p) in self.push.iter_mut().zip(bounce.push.to_array()) {
            sum[lane] += p;
        }
    }

    /// Adds the block's impulses `times` 1; with -1 removes them before a sweep that changes them.
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
    /// Adds the impulses of impacts to a lane.
    pub(crate) fn add_bounce(&mut self, lane: usize, bounce: &Bounce) {
        let [p, q, r, s] = bounce.points;
        for (peak, p) in self.0.iter_mut().zip([p, q, r, s, p + q + r + s]) {
            peak[lane] += p;
        }
    }

    /// Updates the peaks with the block's impulses of a substep.
    #[inline(always)]
    pub(super) fn note(&mut self, block: &ContactBlock) {
        let count = usize::from(block.count.clamp(1, 4));
        let [peaks @ .., maximum] = &mut self.0;
        let mut total = [0.0; LANES];
        for (peak, point) in peaks.iter_mut().zip(&block.points).take(count) {
            for lane in 0..LANES {
                peak[lane] = greater(point.impulse[lane], peak[lane]);
                total[lane] += point.impulse[lane];
            }
        }
        for lane in 0..LANES {
            maximum[lane] = greater(total[lane], maximum[lane]);
        }
    }
}

/// Impulses from bounces of a contact, outside of sweeps [N s; `push`: world, on B].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Bounce {
    pub(crate) points: [f32; 4],
    pub(crate) push: Vec3,
}

/// The sweep after which impulses are added.
#[derive(Clone, Copy, Debug)]
pub(crate) struct When {
    pub(crate) is_relax: bool,
    /// The sweep is in the first, or the last, part of a substep of the world.
    begins: bool,
    ends: bool,
}

impl When {
    /// `part` of a step that subdivides each substep into `parts`. A relax sweep at the step's end
    /// belongs to the last one.
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
    /// Sums at the start of the substep.
    start: [Lanes; 6],
    /// Maximum of a substep so far, squared: force, torque.
    peak: [Lanes; 2],
}

impl JointTally {
    pub(crate) fn add(&mut self, force: &[Lanes; 3], turn: &[Lanes; 3], when: When) {
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

    pub(crate) fn of(&self, lane: usize) -> Totals {
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
    pub(crate) fn add(&mut self, now: Vec3, when: When) {
        if when.begins {
            self.start = self.sum;
        }
        self.sum += if when.is_relax { now - self.last } else { now };
        self.last = now;
        if when.ends {
            self.peak = greater((self.sum - self.start).length(), self.peak);
        }
    }

    pub(crate) fn totals(&self) -> Totals {
        Totals { given: [self.sum, Vec3::ZERO], peak: [self.peak, 0.0] }.bounded()
    }
}

/// Total impulse of a joint in a step, and the maximum of a substep [N s, N m s].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Totals {
    pub(crate) given: [Vec3; 2],
    pub(crate) peak: [f32; 2],
}

impl Totals {
    /// Clamps the totals, because squares of impulses overflow before the impulses do.
    fn bounded(self) -> Self {
        Self { given: self.given.map(Vec3::bounded), peak: self.peak.map(bounded) }
    }
}

/// Impulses of a contact in a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactTotals {
    pub(crate) contact: u32,
    /// Along the normal at each point [N s]. A contact that was rebuilt within the step may have
    /// fewer points now.
    pub(crate) points: [f32; 4],
    /// Total impulse on B, friction included [N s, world].
    pub(crate) push: Vec3,
    /// Maximum force of a substep, for each point and for their total [N].
    pub(crate) peaks: [f32; 5],
    /// Bits of the points that were pressed for the first time or bore no load before; 0 if there
    /// are none. [`Contact::approach`] has their approach speed.
    pub(crate) landed: u8,
    /// A body of the contact can break, or a shape reports forces.
    pub(crate) asked: bool,
}

/// Selects the contacts whose impulses are summed in a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SumRequests<'a> {
    pub(crate) bodies: &'a Bodies,
    pub(crate) shapes: &'a Shapes,
    /// Some body or joint can break.
    pub(crate) breakage: bool,
}

impl SumRequests<'_> {
    /// True if some contact may need sums.
    pub(super) const fn any(&self) -> bool {
        self.breakage || self.shapes.report_forces > 0
    }

    /// True if a body of the contact can break or a shape reports forces.
    pub(crate) fn include(&self, contact: &Contact) -> bool {
        let breaks = |row: u32| self.bodies.at(row).record.breaks;
        let reports = |row: u32| self.shapes.at(row).reports.forces;
        self.breakage && (breaks(contact.body_a) || breaks(contact.body_b))
            || self.shapes.report_forces > 0
                && (reports(contact.shape_a) || reports(contact.shape_b))
    }
}

/// The points of a lane that landed.
pub(crate) const fn landed(watch: u8) -> u8 {
    match (watch & LANDED != 0, watch & NEW != 0) {
        (false, _) => 0,
        (true, false) => watch & POINTS,
        (true, true) => POINTS,
    }
}
