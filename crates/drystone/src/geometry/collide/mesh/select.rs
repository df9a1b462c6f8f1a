//! Selects the points that a manifold keeps among those that share a normal, eight at a time.

use fearless_simd::{Simd, SimdBase};

use super::contacts::Limits;
use crate::base::math::{Vec3, lesser};
use crate::base::simd::wide::{
    LANES, Lanes, Vec3w, Wide, above, at, bits, load, max, put, reduce_max, reduce_min, select,
    splat,
};
use crate::geometry::manifold::{FeatureId, Manifold, ManifoldPoint};

/// Eight points. Lanes not in use repeat the first.
#[derive(Clone, Copy, Debug)]
struct Group {
    position: [Lanes; 3],
    separation: Lanes,
    feature: [FeatureId; LANES],
}

/// Points that share a normal, in the order in which they were added.
#[derive(Clone, Debug, Default)]
pub(super) struct Members {
    groups: Vec<Group>,
    count: usize,
}

/// The point with the largest value, the first of equal ones.
#[derive(Clone, Copy)]
struct Best {
    value: f32,
    number: usize,
}

impl Best {
    const NONE: Self = Self { value: f32::NEG_INFINITY, number: 0 };

    /// Takes the best point of a group, if its value is larger.
    #[inline(always)]
    fn of<S: Simd>(&mut self, simd: S, group: usize, values: Wide<S>) {
        let value = reduce_max(values);
        if value > self.value {
            let lanes = !bits(above(splat(simd, value), values));
            *self = Self { value, number: group * LANES + lanes.trailing_zeros() as usize };
        }
    }
}

impl Members {
    pub(super) fn clear(&mut self) {
        self.groups.clear();
        self.count = 0;
    }

    #[inline(always)]
    pub(super) fn push(&mut self, point: &ManifoldPoint) {
        let ManifoldPoint { position, separation, feature } = *point;
        let lane = self.count % LANES;
        if lane == 0 {
            self.groups.push(Group {
                position: [[position.x; LANES], [position.y; LANES], [position.z; LANES]],
                separation: [separation; LANES],
                feature: [feature; LANES],
            });
        } else if let Some(group) = self.groups.last_mut() {
            put(&mut group.position, lane, position);
            group.separation[lane] = separation;
            group.feature[lane] = feature;
        }
        self.count += 1;
    }

    fn point(&self, number: usize) -> ManifoldPoint {
        let (group, lane) = (&self.groups[number / LANES], number % LANES);
        let (separation, feature) = (group.separation[lane], group.feature[lane]);
        ManifoldPoint { position: at(&group.position, lane), separation, feature }
    }

    /// Minimum separation [m].
    #[inline(always)]
    pub(super) fn deepest<S: Simd>(&self, simd: S) -> f32 {
        let mut low = f32::INFINITY;
        for group in &self.groups {
            low = lesser(reduce_min(load(simd, &group.separation)), low);
        }
        low
    }

    /// Selects at most four points that carry the same load: the deepest, whose separation is
    /// `deepest`, and the ones that span the largest area.
    #[inline(always)]
    pub(super) fn select<S: Simd>(
        &self,
        simd: S,
        normal: Vec3,
        deepest: f32,
        limits: &Limits,
    ) -> Manifold {
        let mut manifold = Manifold { normal, ..Manifold::default() };
        // Among points with equal depth up to rounding this takes the outermost in a fixed
        // direction, not the one that noise favors. The direction is along no axis, so that a
        // square has one outermost corner.
        let across = normal.any_perpendicular();
        let tangent = Vec3w::splat(simd, across + normal.cross(across) * 0.37);
        let level = splat(simd, deepest + 0.1 * limits.bias);
        let mut best = Best::NONE;
        for (number, group) in self.groups.iter().enumerate() {
            let position = Vec3w::load(simd, &group.position);
            let higher = above(load(simd, &group.separation), level);
            let none = splat(simd, f32::NEG_INFINITY);
            best.of(simd, number, select(higher, none, tangent.dot(position)));
        }
        let a = self.point(best.number);
        manifold.push(a);
        let merge = limits.merge;
        let n = Vec3w::splat(simd, normal);
        let start = Vec3w::splat(simd, a.position);
        let mut best = Best::NONE;
        for (number, group) in self.groups.iter().enumerate() {
            let arm = Vec3w::load(simd, &group.position) - start;
            let flat = arm - n * n.dot(arm);
            best.of(simd, number, flat.dot(flat));
        }
        if !(best.value > merge * merge) {
            return manifold;
        }
        let b = self.point(best.number);
        manifold.push(b);
        let span = b.position - a.position;
        let minimum = merge * span.length();
        let along = Vec3w::splat(simd, span);
        let mut best = Best::NONE;
        for (number, group) in self.groups.iter().enumerate() {
            let area = n.dot(along.cross(Vec3w::load(simd, &group.position) - start));
            best.of(simd, number, area.abs());
        }
        if !(best.value > minimum) {
            return manifold;
        }
        let c = self.point(best.number);
        manifold.push(c);
        // Counter-clockwise about the normal, so that points outside have a positive area.
        let corners = if normal.dot(span.cross(c.position - a.position)) > 0.0 {
            [a.position, b.position, c.position]
        } else {
            [b.position, a.position, c.position]
        };
        let mut best = Best::NONE;
        for (number, group) in self.groups.iter().enumerate() {
            let position = Vec3w::load(simd, &group.position);
            let mut gain = splat(simd, 0.0);
            for k in 0..3 {
                let side = Vec3w::splat(simd, corners[(k + 1) % 3] - corners[k]);
                let arm = position - Vec3w::splat(simd, corners[k]);
                gain = max(gain, n.dot(arm.cross(side)));
            }
            best.of(simd, number, gain);
        }
        if best.value > minimum {
            manifold.push(self.point(best.number));
        }
        manifold
    }
}

#[cfg(test)]
mod tests {
    use fearless_simd::dispatch;

    use super::super::contacts::Limits;
    use super::Members;
    use crate::base::math::{Vec3, lesser, vec3};
    use crate::base::random::Random;
    use crate::base::simd::wide::SimdLevel;
    use crate::geometry::manifold::ManifoldPoint;

    /// The first point with the largest `value`.
    fn largest(points: &[ManifoldPoint], value: impl Fn(&ManifoldPoint) -> f32) -> (Vec3, f32) {
        let mut best = (Vec3::ZERO, f32::NEG_INFINITY);
        for p in points {
            let v = value(p);
            if v > best.1 {
                best = (p.position, v);
            }
        }
        best
    }

    /// A scalar version of [`Members::select`].
    fn places(normal: Vec3, points: &[ManifoldPoint], limits: &Limits) -> Vec<Vec3> {
        let deepest = points.iter().map(|p| p.separation).fold(f32::INFINITY, lesser);
        let across = normal.any_perpendicular();
        let tangent = across + normal.cross(across) * 0.37;
        let (a, _) = largest(points, |p| {
            let level = p.separation <= deepest + 0.1 * limits.bias;
            if level { tangent.dot(p.position) } else { f32::NEG_INFINITY }
        });
        let (b, far) = largest(points, |p| {
            let arm = p.position - a;
            (arm - normal * normal.dot(arm)).length_squared()
        });
        if far <= limits.merge * limits.merge {
            return vec![a];
        }
        let minimum = limits.merge * (b - a).length();
        let area = |p: Vec3| normal.dot((b - a).cross(p - a));
        let (c, wide) = largest(points, |p| area(p.position).abs());
        if wide <= minimum {
            return vec![a, b];
        }
        let [p, q] = if area(c) > 0.0 { [a, b] } else { [b, a] };
        let (d, more) = largest(points, |x| {
            [(p, q), (q, c), (c, p)]
                .map(|(from, to)| normal.dot((x.position - from).cross(to - from)))
                .into_iter()
                .fold(0.0, f32::max)
        });
        if more > minimum { vec![a, b, c, d] } else { vec![a, b, c] }
    }

    #[test]
    fn eight_at_a_time_are_chosen_as_one_by_one() {
        let mut random = Random::new(1);
        #[expect(clippy::cast_possible_truncation, reason = "any number will do")]
        let mut any = || random.unit() as f32;
        let limits = Limits { merge: 0.05, bias: 0.01, ..Limits::default() };
        let mut sizes = [0; 5];
        for round in 0..2000_u16 {
            let normal = vec3(any() - 0.5, 1.0, any() - 0.5).normalize_or(Vec3::Y);
            // Some points are so near that they merge, some are on a line, some have equal depth.
            let size = [0.01, 0.2, 2.0][usize::from(round % 3)];
            let line = round % 5 == 0;
            let points: Vec<ManifoldPoint> = (0..=round % 37)
                .map(|feature| {
                    let z = if line { 0.0 } else { any() * size };
                    let position = vec3(any() * size, 0.01 * any(), z);
                    let separation = if round % 7 == 0 { 0.0 } else { 0.02 * any() };
                    ManifoldPoint { position, separation, feature: feature.into() }
                })
                .collect();
            let mut members = Members::default();
            points.iter().for_each(|p| members.push(p));
            let expected = places(normal, &points, &limits);
            for level in SimdLevel::available() {
                let manifold = dispatch!(level.0, simd => {
                    let deepest = members.deepest(simd);
                    members.select(simd, normal, deepest, &limits)
                });
                let found: Vec<Vec3> = manifold.points().iter().map(|p| p.position).collect();
                assert_eq!(found, expected, "round {round}");
                assert!(manifold.points().iter().all(|p| points.contains(p)));
            }
            sizes[expected.len()] += 1;
        }
        assert!(sizes[1..].iter().all(|n| *n > 50), "{sizes:?}");
    }
}
