//! How the triangles of a mesh meet along their edges; this distinguishes real edges from seams.

use core::ops::{Add, Mul, Sub};

use crate::base::math::Vec3;
use crate::base::trig;

/// Sine of the angle up to which two triangles count as one plane: 0.25°, well above the rounding
/// of vertices. Larger angles need no tolerance: the two faces bound the contact normals there.
const FLAT: f32 = 4.0e-3;

/// Maximum number of triangles at one edge; more are taken as separate sheets. Comparing all with
/// all would take quadratic time.
const MAX_SHARED: usize = 32;

/// The turn of the surface normal across an edge, for one side of the triangle. Behind the edge the
/// normal of that side is `cos * normal + sin * outward`; `outward` is the direction in the
/// triangle's plane away from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bend {
    pub(crate) cos: f32,
    pub(crate) sin: f32,
}

impl Bend {
    /// The surface ends here: its normal turns around to the other side.
    const BORDER: Self = Self { cos: -1.0, sin: 0.0 };

    /// Returns whether the surface turns away from this side: there are normals between the two
    /// faces' normals.
    #[inline]
    pub(crate) fn active(self) -> bool {
        self.sin > FLAT || (self.cos < 0.0 && self.sin >= -FLAT)
    }

    /// Returns whether no other triangle continues the surface behind the edge.
    #[inline]
    pub(crate) fn is_border(self) -> bool {
        self == Self::BORDER
    }

    /// Returns whether the surface turns towards this side.
    #[inline]
    pub(crate) fn concave(self) -> bool {
        self.sin < -FLAT
    }

    /// Signed angle of the turn [rad].
    fn angle(self) -> f32 {
        if self.cos < 0.0 && self.sin.abs() <= FLAT {
            return core::f32::consts::PI;
        }
        trig::atan2(self.sin, self.cos)
    }
}

/// A vector in double precision, for values that are computed once and stored.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wide([f64; 3]);

impl From<Vec3> for Wide {
    fn from(v: Vec3) -> Self {
        Self([f64::from(v.x), f64::from(v.y), f64::from(v.z)])
    }
}

impl Sub for Wide {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Self([self.0[0] - o.0[0], self.0[1] - o.0[1], self.0[2] - o.0[2]])
    }
}

impl Add for Wide {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self([self.0[0] + o.0[0], self.0[1] + o.0[1], self.0[2] + o.0[2]])
    }
}

impl Mul<f64> for Wide {
    type Output = Self;
    fn mul(self, s: f64) -> Self {
        Self(self.0.map(|x| x * s))
    }
}

impl Wide {
    pub(super) fn dot(self, o: Self) -> f64 {
        self.0[0] * o.0[0] + self.0[1] * o.0[1] + self.0[2] * o.0[2]
    }

    pub(super) fn cross(self, o: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, o.0);
        Self([b * z - c * y, c * x - a * z, a * y - b * x])
    }

    fn unit(self) -> Self {
        self * (1.0 / self.dot(self).sqrt())
    }

    #[expect(clippy::cast_possible_truncation, reason = "results are wanted in f32")]
    pub(super) fn narrow(self) -> Vec3 {
        Vec3 { x: self.0[0] as f32, y: self.0[1] as f32, z: self.0[2] as f32 }
    }
}

/// Returns for each vertex the lowest number of a vertex at exactly the same position. Files repeat
/// a vertex for every face that gives it another normal or texture coordinate.
pub(super) fn weld(vertices: &[Vec3]) -> Vec<u32> {
    // Adding zero gives -0 and 0 the same bits.
    let mut order: Vec<([u32; 3], u32)> = (0_u32..)
        .zip(vertices)
        .map(|(i, v)| (v.to_array().map(|x| (x + 0.0).to_bits()), i))
        .collect();
    order.sort_unstable();
    let mut first = vec![0; order.len()];
    let mut leader = 0;
    for k in 0..order.len() {
        let (place, vertex) = order[k];
        if k == 0 || order[k - 1].0 != place {
            leader = vertex;
        }
        first[vertex as usize] = leader;
    }
    first
}

/// Bends of a triangle: by side, then by edge.
pub(crate) type Bends = [[Bend; 3]; 2];

/// A side of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Edge {
    /// Welded vertex numbers of its ends, the lower one first.
    pub(super) ends: [u32; 2],
    pub(super) triangle: u32,
    /// Number of its start corner.
    pub(super) side: usize,
}

/// Returns the sides of all triangles; sides with the same ends are adjacent in the list.
pub(super) fn edges(triangles: &[[u32; 3]], welded: &[u32]) -> Vec<Edge> {
    let mut edges = Vec::with_capacity(triangles.len() * 3);
    for (number, triangle) in (0_u32..).zip(triangles) {
        for side in 0..3 {
            let at = |k: usize| welded[triangle[k % 3] as usize];
            let (a, b) = (at(side), at(side + 1));
            edges.push(Edge { ends: [a.min(b), a.max(b)], triangle: number, side });
        }
    }
    edges.sort_unstable();
    edges
}

/// The bends at an edge, one per side.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sides([Option<Bend>; 2]);

impl Sides {
    /// Adds a neighbor whose bend on the normal's side is `up`. Where three or more triangles share
    /// the edge, the one that closes in first on a side is the surface of that side.
    pub(super) fn take(&mut self, up: Bend) {
        for (slot, seen) in self.0.iter_mut().zip([up, Bend { sin: -up.sin, ..up }]) {
            if slot.is_none_or(|b| seen.angle() < b.angle()) {
                *slot = Some(seen);
            }
        }
    }

    /// Writes the bends; without a neighbor the surface ends.
    pub(super) fn write(self, of: &mut Bends, k: usize) {
        for (bends, found) in of.iter_mut().zip(self.0) {
            bends[k] = found.unwrap_or(Bend::BORDER);
        }
    }
}

/// The bends at the edges of all triangles.
pub(super) fn bends(vertices: &[Vec3], triangles: &[[u32; 3]], edges: &[Edge]) -> Vec<Bends> {
    let mut all = vec![[[Bend::BORDER; 3]; 2]; triangles.len()];
    for shared in edges.chunk_by(|x, y| x.ends == y.ends) {
        if shared.len() > MAX_SHARED {
            continue;
        }
        for edge in shared {
            let mut sides = Sides::default();
            for other in shared.iter().filter(|other| other.triangle != edge.triangle) {
                let apex = triangles[other.triangle as usize][(other.side + 2) % 3];
                let corners = triangles[edge.triangle as usize].map(|i| vertices[i as usize]);
                sides.take(bend(corners, edge.side, vertices[apex as usize]));
            }
            sides.write(&mut all[edge.triangle as usize], edge.side);
        }
    }
    all
}

/// The bend at edge `k` towards a neighbor with the third corner `apex`, on the normal's side.
pub(super) fn bend(corners: [Vec3; 3], k: usize, apex: Vec3) -> Bend {
    let p = [corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]].map(Wide::from);
    let edge = (p[1] - p[0]).unit();
    let inward = p[2] - p[0];
    let outward = (edge * inward.dot(edge) - inward).unit();
    let normal = outward.cross(edge);
    let to_apex = Wide::from(apex) - p[0];
    let across = to_apex + edge * -to_apex.dot(edge);
    let across = across.unit();
    #[expect(clippy::cast_possible_truncation, reason = "results are wanted in f32")]
    let (cos, sin) = (across.dot(outward) as f32, -across.dot(normal) as f32);
    if cos < 0.0 && sin.abs() <= FLAT { Bend::BORDER } else { Bend { cos, sin } }
}
