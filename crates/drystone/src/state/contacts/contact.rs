//! A contact: one manifold of a pair of shapes.

use crate::base::math::Vec3;
use crate::base::threads::shared::Shared;
use crate::geometry::manifold::PairCache;
use crate::state::bodies::{Bodies, NONE};
use crate::state::colors::Place;
use crate::state::def::BodyKind;
#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

/// A contact point: half a cache line. The first row of four numbers is loaded by the solver.
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[repr(C)]
pub(crate) struct Point {
    /// Vector from A's center of mass to the point [m, world], when the manifold was made. The
    /// vector from B's center is this minus [`Contact::offset`].
    pub(crate) r_a: Vec3,
    /// Current separation [m].
    pub(crate) separation: f32,
    /// Accumulated impulse along the normal in a substep [N s].
    pub(crate) impulse: f32,
    /// Separation minus that of the anchors along the normal, when the manifold was made [m].
    pub(crate) base: f32,
    pub(crate) feature: u32,
    /// One of four numbers stored for the contact: see [`Contact::approach`].
    word: f32,
}

impl Point {
    /// Replaces the point and keeps `word`.
    #[inline]
    pub(crate) fn renew(&mut self, r_a: Vec3, separation: f32, impulse: f32, feature: u32) {
        // The anchors coincide when the manifold is made, so the base is the whole separation.
        let base = separation;
        *self = Self { r_a, separation, impulse, base, feature, word: self.word };
    }

    /// `r_a` together with the separation.
    #[inline(always)]
    pub(crate) fn arm(&self) -> &[f32; 4] {
        let [arm, _]: &[[f32; 4]; 2] = bytemuck::cast_ref(self);
        arm
    }
}

/// A link in a body's list of contacts: contact row × 2 + side. It belongs to the body, because two
/// workers may write the two links of a contact at once.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct ListLink {
    pub(crate) previous: Shared,
    pub(crate) next: Shared,
}

impl Default for ListLink {
    fn default() -> Self {
        Self { previous: Shared::new(NONE), next: Shared::new(NONE) }
    }
}

/// Additional properties of a contact, one bit each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Traits(u8);

impl Traits {
    /// One of the surfaces moves along its shape.
    pub(crate) const BELT: Self = Self(1);
    /// A rule sets its softness.
    pub(crate) const SOFT: Self = Self(2);
    /// Hooks are called for it, and may set its restitution and softness for a step.
    pub(crate) const HOOKED: Self = Self(4);
    /// Not from the surfaces: it is being separated, because its overlap exceeds the amount that
    /// its load explains.
    pub(crate) const PARTING: Self = Self(8);
    /// Not from the surfaces: it was hit in the last step and does not bounce. The remaining
    /// approach belongs to the same landing.
    pub(crate) const STRUCK: Self = Self(16);
    /// Not from the surfaces: its compression under load was large, and is being removed.
    pub(crate) const SETTLES: Self = Self(32);

    #[must_use]
    pub(crate) const fn with(self, traits: Self, have: bool) -> Self {
        if have { Self(self.0 | traits.0) } else { Self(self.0 & !traits.0) }
    }

    pub(crate) const fn any(self, of: Self) -> bool {
        self.0 & of.0 != 0
    }

    /// Whether its softness may differ from the world's.
    pub(crate) const fn may_soften(self) -> bool {
        self.any(Self(Self::SOFT.0 | Self::HOOKED.0))
    }

    /// The properties that come from the surfaces.
    pub(crate) const fn of_surfaces(self) -> Self {
        Self(self.0 & !(Self::PARTING.0 | Self::STRUCK.0 | Self::SETTLES.0))
    }

    /// True if the surfaces set no additional property.
    pub(crate) const fn is_plain(self) -> bool {
        self.of_surfaces().0 == 0
    }
}

/// A contact. The data that the solver reads come first: one cache line, and half a line per point.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[repr(C, align(64))]
pub(crate) struct Contact {
    /// Normal from A to B [world].
    pub(crate) normal: Vec3,
    pub(crate) friction: f32,
    /// Friction impulse of a substep [N s, world], and the twist impulse about the normal as an
    /// impulse at the contact's radius [N s].
    pub(crate) tangent_impulse: Vec3,
    pub(crate) twist_impulse: f32,
    pub(crate) body_a: u32,
    pub(crate) body_b: u32,
    /// Center of B minus center of A [m, world], when the manifold was made.
    pub(crate) offset: Vec3,
    /// Spinning resistance times radius [m].
    pub(crate) spinning: f32,
    pub(crate) count: u8,
    /// Number of further manifolds of the pair that have points. Only in the first manifold.
    pub(crate) others: u8,
    /// True for a secondary manifold of its pair.
    pub(crate) is_part: bool,
    pub(crate) sensor: bool,
    /// True while its begin was reported and its end was not. Only in the first manifold.
    pub(crate) touching: bool,
    /// True if its manifolds may be recycled.
    pub(crate) recyclable: bool,
    /// True if a flat contact of these shapes is a disc.
    pub(crate) round_patch: bool,
    pub(crate) traits: Traits,
    pub(crate) points: [Point; 4],
    pub(crate) shape_a: u32,
    pub(crate) shape_b: u32,
    /// Rolling resistance times radius [m].
    pub(crate) rolling: f32,
    pub(crate) restitution: f32,
    /// Ratio of kinetic to static friction, at most 1.
    pub(crate) kinetic: f32,
    pub(crate) links: [ListLink; 2],
    /// Place in the colors; nowhere while it has no points.
    pub(crate) place: Place,
    /// Index of its [`Probe`]. Secondary manifolds have none and store the row of the first
    /// manifold. Atomic: it is written while others borrow the contact.
    pub(crate) probe: Shared,
    /// The next manifold of the same pair (meshes), or [`NONE`].
    pub(crate) next_part: u32,
    /// For mesh pairs: lower bound on the distance of the triangles that got no points when the
    /// manifolds were made [m]. For other pairs: rotation of the pair before a corner without a
    /// point comes down [rad]. Negative: the solver rebuilt the manifold.
    pub(crate) clear: f32,
    pub(crate) cache: PairCache,
}

impl Contact {
    /// Number of cache lines that the solver reads.
    pub(crate) const SOLVER_LINES: usize = 3;
    /// Cache line with its links and places. The first line tells whether a row is empty.
    pub(crate) const LISTS_LINE: usize = core::mem::offset_of!(Self, links) / 64;
    /// Total number of cache lines.
    pub(crate) const CACHE_LINES: usize = size_of::<Self>() / 64;

    /// The rows that the solver loads: normal and friction, and the friction impulses.
    #[inline(always)]
    pub(crate) const fn rows(&self) -> [[f32; 4]; 2] {
        let (n, p) = (self.normal, self.tangent_impulse);
        [[n.x, n.y, n.z, self.friction], [p.x, p.y, p.z, self.twist_impulse]]
    }

    /// Row of the first manifold of its pair. `row` is the row of this contact.
    #[inline]
    pub(crate) fn first(&self, row: u32) -> u32 {
        if self.is_part { self.probe.get() } else { row }
    }

    /// Rolling impulse of a substep [N m s, world].
    #[inline]
    pub(crate) const fn rolling_impulse(&self) -> Vec3 {
        let [x, y, z, _] = &self.points;
        Vec3 { x: x.word, y: y.word, z: z.word }
    }

    #[inline]
    pub(crate) const fn set_rolling_impulse(&mut self, impulse: Vec3) {
        let [x, y, z, _] = &mut self.points;
        (x.word, y.word, z.word) = (impulse.x, impulse.y, impulse.z);
    }

    /// Multiplies all impulses.
    pub(crate) fn scale_impulses(&mut self, factor: f32) {
        for point in &mut self.points {
            point.impulse *= factor;
        }
        self.tangent_impulse *= factor;
        self.twist_impulse *= factor;
        if self.rolling > 0.0 {
            self.set_rolling_impulse(self.rolling_impulse() * factor);
        }
    }

    /// Part of its compression under load that has been removed [m]: see
    /// `step/narrowphase/settling.rs`. It shares memory with the rolling impulse: the compression
    /// is not removed for contacts with rolling resistance.
    #[inline]
    pub(crate) const fn settled(&self) -> f32 {
        if self.rolling > 0.0 { 0.0 } else { self.points[0].word }
    }

    #[inline]
    pub(crate) const fn set_settled(&mut self, depth: f32) {
        if !(self.rolling > 0.0) {
            self.points[0].word = depth;
        }
    }

    /// Approach speed of the shapes before they touch [m/s]. Like the rolling impulse, it is stored
    /// in the spare word of a point, used or not.
    #[inline]
    pub(crate) const fn approach(&self) -> f32 {
        self.points[3].word
    }

    #[inline]
    pub(crate) const fn set_approach(&mut self, speed: f32) {
        self.points[3].word = speed;
    }

    /// True if the solver rebuilt its manifold at the current poses of the bodies. The poses of its
    /// earlier manifold are then meaningless.
    #[inline]
    pub(crate) fn is_renewed(&self) -> bool {
        self.clear < 0.0
    }

    /// Marks the manifold as rebuilt by the solver.
    pub(crate) fn set_renewed(&mut self) {
        self.clear = -1.0;
    }

    /// True if the contact may reflect an impact within the step.
    #[inline]
    pub(crate) const fn may_bounce(&self) -> bool {
        self.restitution > 0.0 || self.traits.any(Traits::HOOKED)
    }

    /// True if it needs more than normal and friction impulses.
    pub(crate) fn is_special(&self, bodies: &Bodies) -> bool {
        let kinematic = |body: u32| bodies.at(body).kind == BodyKind::Kinematic;
        let surface = self.restitution > 0.0
            || self.rolling > 0.0
            || self.kinetic < 1.0
            || !self.traits.is_plain();
        surface || kinematic(self.body_a) || kinematic(self.body_b)
    }

    /// Vector from B's center of mass to a point [m, world], like `r_a`.
    #[inline(always)]
    pub(crate) fn r_b(&self, p: &Point) -> Vec3 {
        p.r_a - self.offset
    }

    /// The points in use.
    #[inline]
    pub(crate) fn points(&self) -> &[Point] {
        &self.points[..usize::from(self.count)]
    }
}
