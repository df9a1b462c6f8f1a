//! Half-space (A) against any convex core (B): the lowest points of B.

use super::convex::Convex;
use crate::base::math::{Vec3, lesser, vec3};
use crate::base::pose::Pose;
use crate::geometry::convex::clip::{Polygon, reduce};
use crate::geometry::manifold::{Manifold, ManifoldPoint};

const BATCH: usize = 64;

/// Computes the manifold in the frame of the half-space.
pub(super) fn collide(
    normal: Vec3,
    offset: f32,
    b: &Convex<'_>,
    b_in_a: &Pose,
    margin: f32,
) -> Manifold {
    let points = [ManifoldPoint::default(); BATCH];
    let mut lowest = Lowest { normal, offset, margin, minimum: f32::INFINITY, points, count: 0 };
    match b {
        Convex::Point => lowest.add(b_in_a.position, 0),
        Convex::Segment { half_height } => {
            let end = vec3(0.0, *half_height, 0.0);
            lowest.add(b_in_a.point(-end), 0);
            lowest.add(b_in_a.point(end), 1);
        }
        Convex::Hull(x) => {
            for (i, v) in (0_u32..).zip(&x.vertices) {
                lowest.add(b_in_a.point(*v), i);
            }
        }
        Convex::Frustum(_) => {
            let mut feature = Polygon::empty();
            b.incident(b_in_a.local_direction(-normal), &mut feature);
            for c in feature.corners() {
                lowest.add(b_in_a.point(c.p), c.id);
            }
        }
    }
    if lowest.count == 0 {
        return Manifold::apart(lowest.minimum);
    }
    reduce(&lowest.points[..lowest.count], normal)
}

struct Lowest {
    normal: Vec3,
    offset: f32,
    margin: f32,
    /// Minimum separation over all points.
    minimum: f32,
    points: [ManifoldPoint; BATCH],
    count: usize,
}

impl Lowest {
    fn add(&mut self, p: Vec3, feature: u32) {
        let separation = self.normal.dot(p) - self.offset;
        self.minimum = lesser(self.minimum, separation);
        let is_near = separation <= self.margin;
        if !is_near {
            return;
        }
        if self.count == BATCH {
            let four = reduce(&self.points, self.normal);
            self.points[..four.count].copy_from_slice(four.points());
            self.count = four.count;
        }
        let position = p - self.normal * (0.5 * separation);
        self.points[self.count] = ManifoldPoint { position, separation, feature };
        self.count += 1;
    }
}
