//! Which of the points that share a normal a manifold keeps: eight looked at at a time.

use fearless_simd::{Simd, SimdBase};

use super::contacts::Limits;
use crate::base::math::Vec3;
use crate::base::wide::{
    LANES, Lanes, Vec3w, Wide, above, at, bits, least, load, max, most, put, select, splat,
};
use crate::geometry::manifold::{FeatureId, Manifold, ManifoldPoint};

/// Eight points. Lanes that are not in use repeat the first.
#[derive(Clone, Copy, Debug)]
struct Group {
    position: [Lanes; 3],
    separation: Lanes,
    feature: [FeatureId; LANES],
}

/// Points that share a normal, in the order in which they came.
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

    /// Takes that of a group, if it is larger.
    #[inline(always)]
    fn of<S: Simd>(&mut self, simd: S, group: usize, values: Wide<S>) {
        let value = most(values);
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

    /// The least separation [m].
    #[inline(always)]
    pub(super) fn deepest<S: Simd>(&self, simd: S) -> f32 {
        let mut low = f32::INFINITY;
        for group in &self.groups {
            let depth = least(load(simd, &group.separation));
            if depth < low {
                low = depth;
            }
        }
        low
    }

    /// At most four that carry the same: the deepest, which `deepest` is the separation of, and those that span the largest
    /// area.
    #[inline(always)]
    pub(super) fn select<S: Simd>(
        &self,
        simd: S,
        normal: Vec3,
        deepest: f32,
        limits: &Limits,
    ) -> Manifold {
        let mut manifold = Manifold { normal, ..Manifold::default() };
        // Points of equal depth up to rounding: the outermost in a fixed direction, not the one that
        // noise favors. The direction is along no axis, so that a square has one outermost corner.
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
        let least = merge * span.length();
        let along = Vec3w::splat(simd, span);
        let mut best = Best::NONE;
        for (number, group) in self.groups.iter().enumerate() {
            let area = n.dot(along.cross(Vec3w::load(simd, &group.position) - start));
            best.of(simd, number, area.abs());
        }
        if !(best.value > least) {
            return manifold;
        }
        let c = self.point(best.number);
        manifold.push(c);
        // Counter-clockwise about the normal, so that what lies outside has a positive area.
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
        if best.value > least {
            manifold.push(self.point(best.number));
        }
        manifold
    }
}
