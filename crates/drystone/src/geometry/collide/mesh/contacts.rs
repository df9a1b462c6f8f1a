//! Contacts of single triangles, collected and reduced to a few manifolds.

use fearless_simd::Simd;

use super::MAX_PARTS;
use super::round::point;
use super::select::Members;
use super::triangle::Triangle;
use crate::base::math::{Vec3, greater, lesser};
use crate::geometry::manifold::{BORDER, FeatureId, Manifold, ManifoldPoint};

/// Cosine of 5.1°: contacts whose normals are nearer than this share a manifold.
const SAME_NORMAL: f32 = 0.996;

/// Cosine of 1 mrad: a normal nearer than this to that of the face is the face's.
const FACE: f32 = 1.0 - 5.0e-7;

/// Limits of a test that follow from the size of the solid.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Limits {
    /// Points farther apart are left out [m].
    pub(super) margin: f32,
    /// Points nearer to each other are one [m].
    pub(super) merge: f32,
    /// Another axis must beat the face's normal by this to be taken [m].
    pub(super) bias: f32,
    /// A point may lie this far beside a triangle [m]: seams have no width.
    pub(super) slack: f32,
    /// Expected motion of the solid in this step [m].
    pub(super) way: Vec3,
    /// The same if it turns little on it, else zero [m].
    pub(super) straight: Vec3,
    /// Corners over a face are wanted even where an edge is nearer.
    pub(super) corners: bool,
    /// A contact this much deeper than triangle and solid overlap is wrong [m].
    pub(super) doubt: f32,
}

/// Along what a triangle and the solid are apart.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    pub(super) normal: Vec3,
    /// Along the normal, over all of triangle and solid [m].
    pub(super) separation: f32,
}

/// What one triangle contributes: some points with one normal.
#[derive(Clone, Copy, Debug)]
struct Patch {
    axis: Axis,
    /// A normal that needs less depth and that this triangle does not allow, but another that
    /// shares the corner may.
    refused: Option<Vec3>,
    deepest: f32,
    /// Deepest point when the solid has gone its way: what has no place is what matters least then.
    due: f32,
    corners: [Vec3; 3],
    /// How far the solid moves before its normal and points are so [m].
    shift: Vec3,
    first: usize,
    end: usize,
}

/// A patch among the others: what decides on its place, and its number.
#[derive(Clone, Copy, Debug)]
struct Place {
    stands_in: bool,
    due: f32,
    patch: u32,
}

/// The contacts of all triangles, and memory that is kept from one solid to the next.
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
    /// Begins with another solid.
    pub(super) fn restart(&mut self, limits: Limits) {
        self.limits = limits;
        self.points.clear();
        self.patches.clear();
        self.spare = None;
    }

    /// Takes those of `points` that lie within the margin as the contact of one triangle; false if
    /// there are none.
    #[inline(always)]
    pub(super) fn add(
        &mut self,
        triangle: &Triangle,
        axis: Axis,
        points: impl IntoIterator<Item = ManifoldPoint>,
    ) -> bool {
        self.add_instead(triangle, axis, None, points)
    }

    /// Like [`Self::add`], of what is so only when the solid has moved by `shift` [m]: the separations are those of then.
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
        // A face that lies flush stands in for none but itself.
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
                due: deepest + axis.normal.dot(self.limits.way),
                corners: triangle.corners,
                shift: Vec3::ZERO,
                first,
                end,
            });
        }
        end > first
    }

    /// Adds those of `corners` of the solid that are over the triangle and apart from it: each of them must
    /// stay so, whatever feature is nearer. `separation` is that of all of the solid.
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

    /// The same, of corners that are over the triangle: number, place, and how far apart.
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

    /// Keeps an overlap in case no triangle has a proper one: at a saddle the nearest point may be a
    /// corner whose normal lies between no two faces, and something must still stop the solid.
    pub(super) fn add_spare(&mut self, normal: Vec3, point: ManifoldPoint) {
        let deeper = |m: &Manifold| point.separation < m.points[0].separation;
        if point.separation < 0.0 && self.spare.as_ref().is_none_or(deeper) {
            let (at, feature) = (point.position, point.feature);
            self.spare = Some(Manifold::single(normal, at, point.separation, feature));
        }
    }

    /// True if the normal of another patch shows that triangle and solid are hardly as deep in each
    /// other as `patch` says: a triangle can allow only what its own edges tell, and one that meets
    /// the surface which carries the solid in no more than a corner would push it out through that
    /// surface. What carries is less deep itself, so the least deep patch always stays, and its
    /// points reach as deep as its normal says: else it holds another part of the solid. A patch whose
    /// own points are not deep pushes nothing and stays: what hangs over a ledge may be far below its
    /// plane while a corner is about to land on it.
    fn is_carried_by_another(&self, patch: &Patch) -> bool {
        let most = patch.axis.separation + self.limits.doubt;
        most < 0.0
            && patch.deepest + self.limits.doubt < 0.0
            && self.patches.iter().any(|other| {
                let Axis { normal, separation } = other.axis;
                let reach = |corners: [Vec3; 3]| {
                    corners.map(|c| normal.dot(c)).into_iter().fold(f32::NEG_INFINITY, greater)
                };
                separation > most
                    && other.refused.is_none()
                    && other.deepest <= separation + self.limits.doubt
                    && separation + reach(other.corners) - reach(patch.corners) > most
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

    /// Brings the patches in order: what is due first, and stand-ins last, for what they stand in for is known then.
    fn sort(&mut self) {
        self.order.clear();
        self.order.extend((0..).zip(&self.patches).map(|(patch, of)| Place {
            stands_in: of.refused.is_some(),
            due: of.due,
            patch,
        }));
        // Those that are due alike in the order in which they came, which is that of the triangles' numbers.
        self.order.sort_unstable_by(|a, b| {
            a.stands_in.cmp(&b.stands_in).then(a.due.total_cmp(&b.due)).then(a.patch.cmp(&b.patch))
        });
    }
}

/// One number from three: the features that make a point.
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

/// A number for a direction, the same for all triangles of a plane: a vertex that slides over a flat
/// floor keeps its feature from triangle to triangle, and has different ones on floor and wall.
#[inline(always)]
pub(super) fn direction_class(normal: Vec3) -> u32 {
    let class = |x: f32| {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 9")]
        let c = (x * 4.0 + 4.5) as u32;
        c
    };
    class(normal.x) | class(normal.y) << 8 | class(normal.z) << 16
}
