//! Contact manifolds. **The normal points from A to B; separation < 0 is overlap.**

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::base::math::Vec3;

/// Identifies the features that made a point, stable while the same features touch: it carries
/// impulses from step to step.
pub(crate) type FeatureId = u32;

/// A feature id starts with its reference: a face of B, a pair of edges, or else a face of A.
pub(crate) const REFERENCE_B: FeatureId = 0x8000_0000;
pub(crate) const EDGE_PAIR: FeatureId = 0x4000_0000;
/// Meshes: the point is on an edge or corner where the mesh ends, and the normal is not a face's.
pub(crate) const BORDER: FeatureId = 0x4000_0000;

/// One point of a manifold, in the frame of A.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ManifoldPoint {
    /// Half way between the two surfaces [m, frame of A].
    pub(crate) position: Vec3,
    /// Distance of the surfaces along the normal [m]; negative where they overlap.
    pub(crate) separation: f32,
    pub(crate) feature: FeatureId,
}

/// Up to four points that share a normal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Manifold {
    /// Unit normal, from A to B [frame of A].
    pub(crate) normal: Vec3,
    pub(crate) points: [ManifoldPoint; 4],
    pub(crate) count: usize,
    /// Displacement of B after which normal and positions hold [m, frame of A]. Separations are the
    /// current ones.
    pub(crate) shift: Vec3,
    /// Lower bound on a distance [m]. Without points: the distance of the solids, or 0 if unknown.
    /// With points, only in a mesh's first manifold: the distance of all triangles without points,
    /// and of all vertices beyond the margin over triangles with points.
    pub(crate) gap: f32,
}

impl Manifold {
    /// The points in use.
    pub(crate) fn points(&self) -> &[ManifoldPoint] {
        &self.points[..self.count]
    }

    pub(crate) fn push(&mut self, point: ManifoldPoint) {
        self.points[self.count] = point;
        self.count += 1;
    }

    /// No points: the solids are at least `gap` apart [m].
    pub(crate) fn apart(gap: f32) -> Self {
        Self { gap, ..Self::default() }
    }

    /// A manifold with one point.
    pub(crate) fn single(
        normal: Vec3,
        position: Vec3,
        separation: f32,
        feature: FeatureId,
    ) -> Self {
        let mut m = Self { normal, ..Self::default() };
        m.push(ManifoldPoint { position, separation, feature });
        m
    }
}

/// Result of a pair's last test, from which the next test starts. Any value is valid: it only
/// changes how long the test takes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct PairCache {
    /// Kind of axis that separated the pair or carried the contact; 0 = unknown.
    pub(crate) kind: u8,
    /// Feature numbers of A and B of that axis.
    pub(crate) a: u16,
    pub(crate) b: u16,
}
