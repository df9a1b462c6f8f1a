//! Clips polygons by planes.

use super::contacts::mix;
use super::triangle::Triangle;
use crate::base::math::Vec3;
use crate::geometry::manifold::FeatureId;

/// A corner of a polygon, and the features that made it.
#[derive(Clone, Copy, Debug)]
pub(super) struct ClipPoint {
    pub(super) position: Vec3,
    pub(super) feature: FeatureId,
}

/// A polygon (two points: a segment) and memory to clip it.
#[derive(Clone, Debug, Default)]
pub(super) struct Clipper {
    pub(super) points: Vec<ClipPoint>,
    spare: Vec<ClipPoint>,
}

impl Clipper {
    /// Starts a new polygon.
    #[inline(always)]
    pub(super) fn restart(&mut self) {
        self.points.clear();
    }

    #[inline(always)]
    pub(super) fn push(&mut self, position: Vec3, feature: FeatureId) {
        self.points.push(ClipPoint { position, feature });
    }

    /// Keeps the part where `normal · (p - at) <= slack` (Sutherland & Hodgman 1974).
    #[inline(always)]
    pub(super) fn cut(&mut self, normal: Vec3, at: Vec3, slack: f32, plane: u32) {
        let Some(&last) = self.points.last() else { return };
        self.spare.clear();
        let height = |p: &ClipPoint| normal.dot(p.position - at) - slack;
        let (mut from, mut from_height) = (last, height(&last));
        for &to in &self.points {
            let to_height = height(&to);
            if (from_height > 0.0) != (to_height > 0.0) {
                let t = from_height / (from_height - to_height);
                let (low, high) = (from.feature.min(to.feature), from.feature.max(to.feature));
                self.spare.push(ClipPoint {
                    position: from.position.lerp(to.position, t),
                    feature: mix(low, high, plane),
                });
            }
            if to_height <= 0.0 {
                self.spare.push(to);
            }
            (from, from_height) = (to, to_height);
        }
        core::mem::swap(&mut self.points, &mut self.spare);
    }

    /// Keeps the part over the triangle.
    #[inline(always)]
    pub(super) fn cut_by_prism(&mut self, triangle: &Triangle, slack: f32) {
        for (k, plane) in (0..3).zip(triangle.number.wrapping_mul(4)..) {
            self.cut(triangle.outward[k], triangle.corners[k], slack, plane);
        }
    }
}
