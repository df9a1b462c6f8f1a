//! Loads contacts from the tables into lanes, before their rows are built.

use fearless_simd::Simd;

use crate::base::bit_set::BitSet;
use crate::base::math::Vec3;
use crate::base::simd::wide::{LANES, Lanes, Vec3w, Wide, gather_rows, gather4, load, put};
use crate::base::threads::disjoint::ReadRows;
use crate::state::bodies::Bodies;
use crate::state::contacts::{Contact, ReadSlots, Softened, Traits};
use crate::state::shapes::Shapes;
use crate::step::context::StepContext;
use crate::step::narrowphase;
use crate::step::solver::totals_rows::NEW;
use crate::step::solver_body::Whitening;

/// Mean distance from the middle of a disc over its radius.
const DISC: f32 = 2.0 / 3.0;

/// Mean distance from the middle of a square over half its diagonal: (√2 + ln(1 + √2)) / (3 √2).
pub(crate) const SQUARE: f32 = 0.541_075_1;

/// Bits of the points of a touching pair that bear no load and approach as fast as a hit; [`NEW`]
/// for a pair that does not touch yet.
#[inline(always)]
pub(crate) fn landing(c: &Contact, source: &Source<'_>) -> u8 {
    if !c.touching {
        return NEW;
    }
    if c.traits.any(Traits::STRUCK) {
        return 0;
    }
    // If some shapes have their own hit speeds, any speed may count.
    let minimum = if source.shapes.give_hit_speed > 0 { 0.0 } else { source.ctx.hit_speed };
    if !(c.approach() > minimum) {
        return 0;
    }
    let bare = c.points().iter().map(|p| u8::from(!(p.impulse > 0.0)));
    bare.enumerate().fold(0, |bits, (j, bare)| bits | bare << j)
}

/// The tables that packing reads.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Source<'a> {
    pub(crate) ctx: &'a StepContext,
    pub(crate) bodies: &'a Bodies,
    /// Solver body of each body row; 0 for bodies that cannot be pushed.
    pub(crate) solver_row_of: &'a [u32],
    pub(crate) whitening: &'a ReadRows<'a, Whitening>,
    /// Acceleration of each solver body [m/s²].
    pub(crate) acceleration: &'a ReadRows<'a, Vec3>,
    pub(crate) contacts: &'a ReadSlots<'a>,
    pub(crate) softened: &'a [Softened],
    pub(crate) shapes: &'a Shapes,
    /// Some overlap may be corrected by displacement.
    pub(crate) parts: bool,
    /// Some contact that does not bounce may get an impact.
    pub(crate) may_impact: bool,
    /// Rows are rebuilt within the step. An overlap that becomes deep within it is corrected from
    /// the next step on.
    pub(crate) is_renewed: bool,
    /// `Some` if the bodies of some contact rotate together: the bodies whose contacts are rebuilt
    /// within the step, which need no corotation.
    pub(crate) turning: Option<&'a BitSet>,
}

impl Source<'_> {
    /// For contacts of links: their trees turn the rows.
    pub(crate) fn for_links(&self) -> Self {
        Self { turning: None, may_impact: false, ..*self }
    }
}

/// Lanes of a block before its rows are built. Idle lanes repeat the first contact without a body,
/// a point or an impulse.
pub(crate) struct Raw<'a> {
    pub(crate) contacts: [&'a Contact; LANES],
    pub(crate) row_a: [u32; LANES],
    pub(crate) row_b: [u32; LANES],
    /// -1 where only B can be pushed and it is the contact's A: its rows change sign.
    pub(crate) sign: Lanes,
    pub(crate) count: Lanes,
    /// Mean distance from the middle over the area enclosed by the points, relative to that of the
    /// points.
    pub(crate) patch: Lanes,
    /// See [`ContactBlock::landing`].
    pub(crate) landing: [u8; LANES],
    /// Reach of the spinning resistance times the friction coefficient [m], and whether any lane
    /// has one.
    pub(crate) spinning: Lanes,
    pub(crate) spins: bool,
    /// Half the rotation of each body in the step, where the bodies rotate together [rad, world].
    pub(crate) turns: Option<[[Lanes; 3]; 2]>,
    /// Some contact is under overlap correction.
    pub(crate) parts: bool,
    /// Part of each contact's yield that has been taken back [m].
    pub(crate) settled: Lanes,
}

impl<'a> Raw<'a> {
    #[inline(always)]
    pub(crate) fn load<const FIXED: bool>(
        source: &Source<'a>,
        owners: &[u32; LANES],
    ) -> Option<Self> {
        let first = source.contacts.read(owners[0] as usize).as_ref()?;
        let mut raw = Self {
            contacts: [first; LANES],
            row_a: [0; LANES],
            row_b: [0; LANES],
            sign: [1.0; LANES],
            count: [0.0; LANES],
            patch: [SQUARE; LANES],
            landing: [0; LANES],
            spinning: [0.0; LANES],
            spins: false,
            turns: None,
            parts: false,
            settled: [0.0; LANES],
        };
        for lane in 0..LANES {
            if owners[lane] == u32::MAX {
                continue;
            }
            let Some(c) = source.contacts.read(owners[lane] as usize) else { continue };
            let (a, b) =
                (source.solver_row_of[c.body_a as usize], source.solver_row_of[c.body_b as usize]);
            raw.contacts[lane] = c;
            raw.count[lane] = f32::from(c.count);
            raw.landing[lane] = landing(c, source);
            raw.parts |= c.traits.any(Traits::PARTING);
            raw.settled[lane] = c.settled();
            if c.round_patch {
                raw.patch[lane] = DISC;
            }
            if c.spinning > 0.0 {
                raw.spinning[lane] = c.spinning;
                raw.spins = true;
            }
            if !FIXED && let Some(turning) = source.turning {
                raw.note_corotation(source, turning, lane);
            }
            if FIXED {
                raw.sign[lane] = if b == 0 { -1.0 } else { 1.0 };
                raw.row_b[lane] = a.max(b);
            } else {
                (raw.row_a[lane], raw.row_b[lane]) = (a, b);
            }
        }
        Some(raw)
    }

    /// Records the rotation of a contact's bodies if they rotate together and its rows are built
    /// once for the whole step.
    #[inline(never)]
    fn note_corotation(&mut self, source: &Source<'_>, turning: &BitSet, lane: usize) {
        let c = self.contacts[lane];
        let bodies = [c.body_a, c.body_b];
        if bodies.iter().any(|row| turning.contains(*row)) {
            return;
        }
        let ends = bodies.map(|row| source.bodies.at(row));
        if !narrowphase::turning::corotates(source.ctx, c, ends) {
            return;
        }
        let turns = self.turns.get_or_insert([[[0.0; LANES]; 3]; 2]);
        for (turn, body) in turns.iter_mut().zip(ends) {
            put(turn, lane, body.w * (0.5 * source.ctx.dt));
        }
    }

    /// Normals and friction coefficients; friction impulses and twist.
    #[inline(always)]
    pub(crate) fn common<S: Simd>(&self, simd: S) -> [[Wide<S>; 4]; 2] {
        let (mut normal, mut tangent) = ([[0.0; 4]; LANES], [[0.0; 4]; LANES]);
        for lane in 0..LANES {
            [normal[lane], tangent[lane]] = self.contacts[lane].rows();
        }
        [gather_rows(simd, &normal), gather_rows(simd, &tangent)]
    }

    /// Centers of B less those of A when the manifolds were made.
    #[inline(always)]
    pub(crate) fn offset<S: Simd>(&self, simd: S) -> Vec3w<S> {
        let mut lanes = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            let offset = self.contacts[lane].offset;
            (lanes[0][lane], lanes[1][lane], lanes[2][lane]) = (offset.x, offset.y, offset.z);
        }
        Vec3w::load(simd, &lanes)
    }

    /// Lever arm of A with the separation, and the impulse, of point `j`.
    #[inline(always)]
    pub(crate) fn point<S: Simd>(&self, simd: S, j: usize) -> ([Wide<S>; 4], Wide<S>) {
        let mut arm = [&[0.0; 4]; LANES];
        let mut impulse = [0.0; LANES];
        for lane in 0..LANES {
            let point = &self.contacts[lane].points[j];
            arm[lane] = point.arm();
            impulse[lane] = point.impulse;
        }
        (gather4(simd, arm), load(simd, &impulse))
    }
}
