//! Contact manifolds. **The normal points from A to B; separation < 0 is overlap.**

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::base::math::Vec3;

/// Names the features that made a point, stable while the same features touch: impulses are carried
/// from step to step by it.
pub(crate) type FeatureId = u32;

/// Feature ids begin with what the reference is: a face of B, a pair of edges; else a face of A.
pub(crate) const REFERENCE_B: FeatureId = 0x8000_0000;
pub(crate) const EDGE_PAIR: FeatureId = 0x4000_0000;
/// Of a mesh: the point is on an edge or corner where the mesh ends, and the normal is not that of a face.
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
    /// Unit, from A to B [frame of A].
    pub(crate) normal: Vec3,
    pub(crate) points: [ManifoldPoint; 4],
    pub(crate) count: usize,
    /// How far B moves before it is where the normal and the positions are told of [m, frame of A]. Separations are those of now.
    pub(crate) shift: Vec3,
    /// Without points: the solids are at least so far apart [m]; 0 if that was not worked out. With points, of the first with a
    /// mesh only: how far all triangles are that got none, and all vertices over those with some that are beyond the margin.
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

/// What a pair remembers from its last test, to begin the next one there. Any value is valid: it
/// only changes how long the test takes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct PairCache {
    /// Which kind of axis separated the pair or carried the contact; 0 = nothing known.
    pub(crate) kind: u8,
    /// Feature numbers of A and B of that axis.
    pub(crate) a: u16,
    pub(crate) b: u16,
}
