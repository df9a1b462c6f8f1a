//! Triangles in groups of eight, laid out to test all eight at once.
//!
//! Plain arrays: a lane never depends on its neighbour, so the compiler turns each loop into the
//! target's vector instructions, and the result is the same everywhere.

use crate::base::aabb::Aabb;
use crate::base::math::{Vec3, greater, lesser};
use crate::base::simd::wide::{LANES, Lanes, at, put};
use crate::geometry::boxes::Boxes;

/// Up to eight triangles that lie near each other. Lanes not in use repeat the last triangle.
#[derive(Clone, Debug)]
pub(crate) struct Pack {
    /// Corner, coordinate, lane [m, local].
    pub(crate) corners: [[Lanes; 3]; 3],
    /// Unit normals: coordinate, lane.
    pub(crate) normals: [Lanes; 3],
    numbers: [u32; LANES],
    count: usize,
}

impl Pack {
    /// Builds a pack of one to eight triangles, each given by its number, corners and unit normal.
    pub(super) fn new(triangles: impl Iterator<Item = (u32, [Vec3; 3], Vec3)>) -> Self {
        let mut pack = Self {
            corners: [[[0.0; LANES]; 3]; 3],
            normals: [[0.0; LANES]; 3],
            numbers: [0; LANES],
            count: 0,
        };
        for (number, corners, normal) in triangles.take(LANES) {
            for lane in pack.count..LANES {
                for (to, corner) in pack.corners.iter_mut().zip(corners) {
                    put(to, lane, corner);
                }
                put(&mut pack.normals, lane, normal);
                pack.numbers[lane] = number;
            }
            pack.count += 1;
        }
        pack
    }

    /// The numbers of its triangles, one per lane.
    #[inline]
    pub(crate) fn numbers(&self) -> &[u32] {
        &self.numbers[..self.count]
    }

    /// The numbers of the triangles in all lanes.
    pub(super) const fn lanes(&self) -> [u32; LANES] {
        self.numbers
    }

    /// The unit normal of the triangle in `lane`, by the right-hand rule over its corners [local].
    #[inline]
    pub(crate) fn normal(&self, lane: usize) -> Vec3 {
        at(&self.normals, lane)
    }

    /// The corners of the triangle in `lane` [m, local].
    #[inline]
    pub(crate) fn triangle(&self, lane: usize) -> [Vec3; 3] {
        [0, 1, 2].map(|k| self.corner(k, lane))
    }

    /// The bounding boxes of its triangles, one per lane [m, local].
    #[inline]
    pub(crate) fn boxes(&self) -> Boxes {
        let [a, b, c] = &self.corners;
        let mut boxes = Boxes::EMPTY;
        for i in 0..3 {
            for l in 0..LANES {
                boxes.min[i][l] = lesser(lesser(a[i][l], b[i][l]), c[i][l]);
                boxes.max[i][l] = greater(greater(a[i][l], b[i][l]), c[i][l]);
            }
        }
        boxes
    }

    /// Corner `k` of the triangle in `lane` [m, local].
    #[inline]
    fn corner(&self, k: usize, lane: usize) -> Vec3 {
        at(&self.corners[k], lane)
    }

    /// The bounding box of all its triangles [m, local].
    pub(super) fn bounds(&self) -> Aabb {
        let corners = (0..self.count).flat_map(|lane| (0..3).map(move |k| (k, lane)));
        Aabb::of_points(corners.map(|(k, lane)| self.corner(k, lane)))
    }
}
