//! One triangle of a mesh as a contact uses it: from one side, with active and inactive edges.

use fearless_simd::Simd;

use super::near::Near;
use crate::base::math::{Vec3, greater};
use crate::base::simd::wide::{Mask, Vec3w, above, splat};
use crate::geometry::mesh::{Bend, Mesh};

/// Sine of the angle up to which a direction counts as the triangle's normal, or as perpendicular
/// to one of its edges.
const ALIGNED: f32 = 1.0e-3;

/// A part of a triangle. Edge k runs from corner k to corner k + 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    Face,
    Edge(usize),
    Corner(usize),
}

impl Part {
    /// Returns the edges that meet in this part.
    #[inline(always)]
    fn edges(self) -> ([usize; 2], usize) {
        match self {
            Self::Face => ([0, 0], 0),
            Self::Edge(k) => ([k, k], 1),
            Self::Corner(i) => ([i, (i + 2) % 3], 2),
        }
    }
}

/// A triangle seen from the side of the other solid's center.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle {
    pub(super) number: u32,
    pub(super) corners: [Vec3; 3],
    /// Vertex numbers of the corners.
    pub(super) vertices: [u32; 3],
    /// Unit normal, towards that side.
    pub(super) normal: Vec3,
    /// Unit vectors in the plane, away from the triangle, one per edge.
    pub(super) outward: [Vec3; 3],
    bends: [Bend; 3],
}

impl Triangle {
    #[inline(always)]
    pub(super) fn new(mesh: &Mesh, near: Near, center: Vec3) -> Self {
        let (item, lane) = near.place();
        let (pack, face) = (mesh.pack(item), mesh.face(item, lane));
        let (corners, normal) = (pack.triangle(lane), pack.normal(lane));
        let below = normal.dot(center - corners[0]) < 0.0;
        Self {
            number: near.number(),
            corners,
            vertices: face.vertices,
            normal: if below { -normal } else { normal },
            outward: face.outward,
            bends: face.bends[usize::from(below)],
        }
    }

    /// Both ends of edge `k`.
    #[inline(always)]
    pub(super) fn edge(&self, k: usize) -> [Vec3; 2] {
        [self.corners[k], self.corners[(k + 1) % 3]]
    }

    /// Returns true if contacts at edge `k` may have normals other than the face's.
    #[inline(always)]
    pub(super) fn is_active(&self, k: usize) -> bool {
        self.bends[k].active()
    }

    /// Returns true if the surface turns towards the visible side at edge `k`.
    #[inline(always)]
    pub(super) fn is_concave(&self, k: usize) -> bool {
        self.bends[k].concave()
    }

    /// Bend of the surface behind edge `k`.
    #[inline(always)]
    pub(super) fn bend(&self, k: usize) -> Bend {
        self.bends[k]
    }

    /// Signed distance from the plane [m].
    #[inline(always)]
    pub(super) fn height(&self, p: Vec3) -> f32 {
        self.normal.dot(p - self.corners[0])
    }

    /// Distance of `p` outside the prism over the triangle [m]; negative inside.
    #[inline]
    pub(super) fn outside(&self, p: Vec3) -> f32 {
        (0..3).map(|k| self.outward[k].dot(p - self.corners[k])).fold(f32::NEG_INFINITY, greater)
    }

    /// Returns the part that is farthest along the unit vector `axis`.
    #[inline(always)]
    pub(super) fn support(&self, axis: Vec3) -> Part {
        let reach = self.corners.map(|c| axis.dot(c));
        let mut far = 0;
        for i in 1..3 {
            if reach[i] > reach[far] {
                far = i;
            }
        }
        let as_far = |i: usize| {
            let across = self.corners[far] - self.corners[i];
            reach[far] - reach[i] <= ALIGNED * across.length()
        };
        let (next, last) = ((far + 1) % 3, (far + 2) % 3);
        match (as_far(next), as_far(last)) {
            (true, true) => Part::Face,
            (true, false) => Part::Edge(far),
            (false, true) => Part::Edge(last),
            (false, false) => Part::Corner(far),
        }
    }

    /// Returns true if the part that touches along the unit vector `axis` is one where the mesh
    /// ends. `axis` is not the face's own normal.
    pub(super) fn is_border(&self, axis: Vec3) -> bool {
        let (edges, n) = self.support(axis).edges();
        edges[..n].iter().any(|k| self.bends[*k].is_border())
    }

    /// Returns true if the surface has the unit normal `axis` at `part`, an edge or a corner. At
    /// each edge that the axis leans to, it must lie between the normals of the two faces. All
    /// other normals are artifacts of the triangulation.
    #[inline(always)]
    pub(super) fn allows(&self, part: Part, axis: Vec3) -> bool {
        let (edges, n) = part.edges();
        let mut leans = false;
        for &k in &edges[..n] {
            let (up, out) = (axis.dot(self.normal), axis.dot(self.outward[k]));
            if out <= ALIGNED && up > 0.0 {
                continue;
            }
            let bend = self.bends[k];
            // The sine of the remaining angle between the axis and the far face's normal.
            if !bend.active() || bend.sin * up - bend.cos * out < -ALIGNED {
                return false;
            }
            leans = true;
        }
        leans
    }

    /// [`Self::allows`] for eight axes at edge `k`, which is active.
    #[inline(always)]
    pub(super) fn allows_at_edge<S: Simd>(&self, simd: S, k: usize, axis: Vec3w<S>) -> Mask<S> {
        let (zero, aligned) = (splat(simd, 0.0), splat(simd, ALIGNED));
        let up = axis.dot(Vec3w::splat(simd, self.normal));
        let out = axis.dot(Vec3w::splat(simd, self.outward[k]));
        let bend = self.bends[k];
        let left = splat(simd, bend.sin) * up - splat(simd, bend.cos) * out;
        !((!above(out, aligned) & above(up, zero)) | above(-aligned, left))
    }

    /// Returns true if `axis` at `part` leans over a concave edge and `center` is behind the face
    /// that rises there. The other solid is then on the far side of that face, which keeps it out;
    /// this triangle, seen from within, would pull it in.
    #[inline(always)]
    pub(super) fn is_behind_neighbor(&self, part: Part, axis: Vec3, center: Vec3) -> bool {
        let (edges, n) = part.edges();
        edges[..n].iter().any(|&k| {
            let (bend, outward) = (self.bends[k], self.outward[k]);
            let neighbor = self.normal * bend.cos + outward * bend.sin;
            bend.concave()
                && axis.dot(outward) > ALIGNED
                && neighbor.dot(center - self.corners[k]) < 0.0
        })
    }

    /// Returns the point of the triangle nearest to `p`, and its part.
    pub(super) fn closest(&self, p: Vec3) -> (Vec3, Part) {
        let mut best = (p - self.normal * self.height(p), Part::Face);
        let mut distance = f32::INFINITY;
        for k in 0..3 {
            if self.outward[k].dot(p - self.corners[k]) <= 0.0 {
                continue;
            }
            let [a, b] = self.edge(k);
            let along = b - a;
            let t = along.dot(p - a) / along.length_squared();
            let (q, part) = if t <= 0.0 {
                (a, Part::Corner(k))
            } else if t >= 1.0 {
                (b, Part::Corner((k + 1) % 3))
            } else {
                (a + along * t, Part::Edge(k))
            };
            let d = (p - q).length_squared();
            if d < distance {
                (best, distance) = ((q, part), d);
            }
        }
        best
    }
}

/// Nearest points of two segments, as fractions of their lengths, 0 to 1 (Ericson 2005, §5.1.9).
#[inline(always)]
pub(super) fn closest_on_segments(p: [Vec3; 2], q: [Vec3; 2]) -> (f32, f32) {
    let (u, v, w) = (p[1] - p[0], q[1] - q[0], p[0] - q[0]);
    let (a, e, f) = (u.length_squared(), v.length_squared(), v.dot(w));
    let unit = |x: f32| x.clamp(0.0, 1.0);
    if a <= f32::MIN_POSITIVE && e <= f32::MIN_POSITIVE {
        return (0.0, 0.0);
    }
    if a <= f32::MIN_POSITIVE {
        return (0.0, unit(f / e));
    }
    let c = u.dot(w);
    if e <= f32::MIN_POSITIVE {
        return (unit(-c / a), 0.0);
    }
    let b = u.dot(v);
    let det = a * e - b * b;
    let s = if det > 1.0e-6 * a * e { unit((b * f - c * e) / det) } else { 0.5 };
    let t = (b * s + f) / e;
    if t < 0.0 {
        (unit(-c / a), 0.0)
    } else if t > 1.0 {
        (unit((b - c) / a), 1.0)
    } else {
        (s, t)
    }
}
