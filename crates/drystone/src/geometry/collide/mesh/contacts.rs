//! Contacts of single triangles, collected and reduced to a few manifolds.

use fearless_simd::Simd;

use super::MAX_PARTS;
use super::round::point;
use super::select::Members;
use super::triangle::Triangle;
use crate::base::math::{Vec3, greater, lesser};
use crate::geometry::manifold::{BORDER, FeatureId, Manifold, ManifoldPoint};

/// Cosine of 5.1°: contacts whose normals are closer than this share a manifold.
const SAME_NORMAL: f32 = 0.996;

/// Cosine of 1 mrad: a normal closer than this to the face's counts as the face's.
const FACE: f32 = 1.0 - 5.0e-7;

/// Limits of a test that follow from the size of the solid.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Limits {
    /// Maximum separation of a contact point [m].
    pub(super) margin: f32,
    /// Points closer to each other than this are merged [m].
    pub(super) merge: f32,
    /// Another axis must be better than the face's normal by this much [m].
    pub(super) bias: f32,
    /// Maximum distance of a point beside its triangle [m]: seams have no width.
    pub(super) slack: f32,
    /// Expected motion of the solid in this step [m].
    pub(super) displacement: Vec3,
    /// The same if the solid turns little in the step, else zero [m].
    pub(super) straight: Vec3,
    /// Whether corners over a face become contacts even where an edge is nearer.
    pub(super) corners: bool,
    /// A contact this much deeper than the overlap of triangle and solid is wrong [m].
    pub(super) doubt: f32,
}

/// An axis between a triangle and the solid.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    pub(super) normal: Vec3,
    /// Separation along the normal, over the whole triangle and solid [m].
    pub(super) separation: f32,
}

/// The contribution of one triangle: some points with one normal.
#[derive(Clone, Copy, Debug)]
struct Patch {
    axis: Axis,
    /// A normal that needs less depth, that this triangle does not allow, but that another triangle
    /// at the corner may allow.
    refused: Option<Vec3>,
    deepest: f32,
    /// Separation of the deepest point after the expected motion. If there are too many patches,
    /// the ones with the largest values are dropped.
    due: f32,
    corners: [Vec3; 3],
    /// Displacement of the solid after which normal and points hold [m].
    shift: Vec3,
    first: usize,
    end: usize,
}

/// Sort key of a patch, and its number.
#[derive(Clone, Copy, Debug)]
struct Place {
    stands_in: bool,
    due: f32,
    patch: u32,
}

/// The contacts of all triangles, and memory reused from one solid to the next.
#[derive(Clone, Debug, Default)]
pub(super) struct Contacts {
    pub(super) limits: Limits,
    points: Vec<ManifoldPoint>,
    patches: Vec<Patch>,
    order: Vec<Place>,
    members: [Members; MAX_PARTS],
    /// The deepest overlap whose normal no triangle allows.
    spare: Option<Manifold>,
}

impl Contacts {
    /// Starts with another solid.
    pub(super) fn restart(&mut self, limits: Limits) {
        self.limits = limits;
        self.points.clear();
        self.patches.clear();
        self.spare = None;
    }

    /// Adds the points within the margin as the contact of one triangle; returns false if there are
    /// none.
    #[inline(always)]
    pub(super) fn add(
        &mut self,
        triangle: &Triangle,
        axis: Axis,
        points: impl IntoIterator<Item = ManifoldPoint>,
    ) -> bool {
        self.add_instead(triangle, axis, None, points)
    }

    /// Like [`Self::add`], for a contact after the solid has moved by `shift` [m]: the separations
    /// are measured after this motion.
    pub(super) fn add_ahead(
        &mut self,
        triangle: &Triangle,
        axis: Axis,
        shift: Vec3,
        points: impl IntoIterator<Item = ManifoldPoint>,
    ) -> bool {
        let closer = axis.normal.dot(shift);
        let axis = Axis { separation: axis.separation - closer, ..axis };
        let points =
            points.into_iter().map(|p| ManifoldPoint { separation: p.separation - closer, ..p });
        let added = self.add_instead(triangle, axis, None, points);
        if added && let Some(patch) = self.patches.last_mut() {
            patch.shift = shift;
        }
        added
    }

    /// Like [`Self::add`], for a contact that stands in for one along `refused`: it is dropped if
    /// another triangle has that normal.
    #[inline(always)]
    pub(super) fn add_instead(
        &mut self,
        triangle: &Triangle,
        axis: Axis,
        refused: Option<Vec3>,
        points: impl IntoIterator<Item = ManifoldPoint>,
    ) -> bool {
        // A face that lies flush stands in for no other.
        let refused = refused.filter(|normal| normal.dot(axis.normal) <= SAME_NORMAL);
        let is_face = axis.normal.dot(triangle.normal) > FACE;
        let border = if is_face || !triangle.is_border(axis.normal) { 0 } else { BORDER };
        let first = self.points.len();
        let mut deepest = f32::INFINITY;
        for p in points {
            if p.separation <= self.limits.margin && p.position.is_finite() {
                deepest = lesser(deepest, p.separation);
                self.points.push(ManifoldPoint { feature: p.feature & !BORDER | border, ..p });
            }
        }
        let end = self.points.len();
        if end > first {
            self.patches.push(Patch {
                axis,
                refused,
                deepest,
                due: deepest + axis.normal.dot(self.limits.displacement),
                corners: triangle.corners,
                shift: Vec3::ZERO,
                first,
                end,
            });
        }
        end > first
    }

    /// Adds the `corners` of the solid that are over the triangle and apart from it: each must stay
    /// apart, whatever feature is nearer. `separation` covers the whole solid.
    pub(super) fn add_corners(
        &mut self,
        triangle: &Triangle,
        corners: &[Vec3],
        (separation, radius): (f32, f32),
    ) {
        let over = (0_u32..).zip(corners).filter_map(|(i, &corner)| {
            let apart = triangle.height(corner) - radius;
            (apart >= 0.0 && triangle.outside(corner) <= 0.0).then_some((i, corner, apart))
        });
        self.add_vertices(triangle, over, (separation, radius));
    }

    /// Does the same for corners already over the triangle: number, position and distance.
    #[inline(always)]
    pub(super) fn add_vertices(
        &mut self,
        triangle: &Triangle,
        over: impl Iterator<Item = (u32, Vec3, f32)>,
        (separation, radius): (f32, f32),
    ) {
        let normal = triangle.normal;
        let class = direction_class(normal);
        let points =
            over.map(|(i, corner, apart)| point(corner, normal, apart, radius, mix(10, i, class)));
        self.add(triangle, Axis { normal, separation }, points);
    }

    /// Keeps an overlap for the case that no triangle has a proper one. At a saddle the nearest
    /// point may be a corner whose normal is not between any two faces; a contact must still stop
    /// the solid.
    pub(super) fn add_spare(&mut self, normal: Vec3, point: ManifoldPoint) {
        let deeper = |m: &Manifold| point.separation < m.points[0].separation;
        if point.separation < 0.0 && self.spare.as_ref().is_none_or(deeper) {
            let (at, feature) = (point.position, point.feature);
            self.spare = Some(Manifold::single(normal, at, point.separation, feature));
        }
    }

    /// Returns true if the normal of another patch shows that triangle and solid overlap much less
    /// than `patch` says. A triangle only checks its own edges. If it meets the supporting surface
    /// only in a corner, its patch would push the solid out through that surface.
    ///
    /// The supporting patch is less deep, so the least deep patch always stays. Its points must be
    /// as deep as its normal says; otherwise it supports another part of the solid. A patch whose
    /// own points are not deep pushes nothing and stays. For example, a solid that hangs over a
    /// ledge may be far below the patch's plane while a corner is about to land on the patch.
    fn is_carried_by_another(&self, patch: &Patch) -> bool {
        let maximum = patch.axis.separation + self.limits.doubt;
        maximum < 0.0
            && patch.deepest + self.limits.doubt < 0.0
            && self.patches.iter().any(|other| {
                let Axis { normal, separation } = other.axis;
                let reach = |corners: [Vec3; 3]| {
                    corners.map(|c| normal.dot(c)).into_iter().fold(f32::NEG_INFINITY, greater)
                };
                separation > maximum
                    && other.refused.is_none()
                    && other.deepest <= separation + self.limits.doubt
                    && separation + reach(other.corners) - reach(patch.corners) > maximum
            })
    }

    /// Writes the manifolds, the one with the deepest point first.
    #[inline(always)]
    pub(super) fn reduce<S: Simd>(&mut self, simd: S, out: &mut [Manifold; MAX_PARTS]) -> usize {
        if let Some(spare) = self.spare
            && self.patches.iter().all(|p| p.deepest > 0.0)
        {
            out[0] = spare;
            return 1;
        }
        self.sort();
        let mut leads: [Option<&Patch>; MAX_PARTS] = [None; MAX_PARTS];
        let mut members = core::mem::take(&mut self.members);
        let mut proper = 0;
        let mut count = 0;
        for place in &self.order {
            let patch = &self.patches[place.patch as usize];
            let near = |normal: Vec3, n: usize| {
                leads[..n].iter().flatten().position(|lead| {
                    lead.axis.normal.dot(normal) > SAME_NORMAL && lead.shift == patch.shift
                })
            };
            if patch.refused.is_some_and(|normal| near(normal, proper).is_some())
                || self.is_carried_by_another(patch)
            {
                continue;
            }
            let at = match near(patch.axis.normal, count) {
                Some(at) => at,
                None if count < MAX_PARTS => {
                    leads[count] = Some(patch);
                    members[count].clear();
                    count += 1;
                    count - 1
                }
                None => continue,
            };
            if patch.refused.is_none() {
                proper = count;
            }
            for point in &self.points[patch.first..patch.end] {
                members[at].push(point);
            }
        }
        let mut parts: [(f32, usize); MAX_PARTS] = [(f32::INFINITY, MAX_PARTS); MAX_PARTS];
        for at in 0..count {
            parts[at] = (members[at].deepest(simd), at);
        }
        parts.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        for (slot, (deepest, at)) in out.iter_mut().zip(&parts[..count]) {
            if let Some(lead) = leads[*at] {
                *slot = members[*at].select(simd, lead.axis.normal, *deepest, &self.limits);
                slot.shift = lead.shift;
            }
        }
        self.members = members;
        count
    }

    /// Sorts the patches: the most urgent first, and stand-ins last, since the normals they stand
    /// in for are known by then.
    fn sort(&mut self) {
        self.order.clear();
        self.order.extend((0..).zip(&self.patches).map(|(patch, of)| Place {
            stands_in: of.refused.is_some(),
            due: of.due,
            patch,
        }));
        // Equally urgent patches keep their order, which is that of the triangles' numbers.
        self.order.sort_unstable_by(|a, b| {
            a.stands_in.cmp(&b.stands_in).then(a.due.total_cmp(&b.due)).then(a.patch.cmp(&b.patch))
        });
    }
}

/// Hashes three numbers, the features that make a point, to one.
#[inline(always)]
pub(super) fn mix(a: u32, b: u32, c: u32) -> FeatureId {
    let mut h = 0x811c_9dc5_u32;
    for w in [a, b, c] {
        h = (h ^ w).wrapping_mul(0x9e37_79b1).rotate_left(15);
    }
    h ^= h >> 16;
    h = h.wrapping_mul(0x85eb_ca6b);
    h ^ (h >> 13)
}

/// Returns a number for a direction, equal for all triangles of a plane. A vertex that slides over
/// a flat floor keeps its feature from triangle to triangle, and has different ones on floor and
/// wall.
#[inline(always)]
pub(super) fn direction_class(normal: Vec3) -> u32 {
    let class = |x: f32| {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 9")]
        let c = (x * 4.0 + 4.5) as u32;
        c
    };
    class(normal.x) | class(normal.y) << 8 | class(normal.z) << 16
}
