//! Which triangles of a mesh a solid may touch before the step ends: eight at a time, by the axes
//! that cost least. What is left of them is tested one by one.

use crate::base::aabb::Aabb;
use crate::base::math::{Vec3, greater, lesser};
use crate::base::wide::{LANES, Lanes};
use crate::geometry::hull::Plane;
use crate::geometry::mesh::{Mesh, Pack, Window};

/// How far contacts of a mesh are looked for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reach {
    /// Points up to this far apart are contacts, whichever way the solid moves [m].
    pub(crate) margin: f32,
    /// Triangles that stay farther apart than this, beside the way below, are left out [m].
    pub(crate) rest: f32,
    /// How the solid's center is expected to move against the mesh in this step [m, frame of the mesh].
    pub(crate) way: Vec3,
    /// The solid is fast: its corners over a face are contacts even where an edge is nearer. After a hit
    /// at the edge they may come down within the step.
    pub(crate) corners: bool,
    /// Worth of looking farther, to know how far apart the two are when they do not touch [m].
    pub(crate) room: f32,
}

impl Reach {
    /// The same in all directions.
    pub(crate) fn still(margin: f32) -> Self {
        Self { margin, rest: margin, way: Vec3::ZERO, corners: false, room: 0.0 }
    }
}

/// The rims of a frustum's ends: unit axis, and the radius at each of the two points [m].
pub(super) type Discs = (Vec3, [f32; 2]);

/// The solid in the frame of the mesh, as these tests see it.
#[derive(Debug)]
pub(super) struct Outline<'a> {
    /// Around all of it, its rounding too.
    pub(super) bounds: Aabb,
    /// The box around its core along its own axes: center, unit axes and half extents [m].
    pub(super) core: (Vec3, [Vec3; 3], Vec3),
    /// What decides on which side of a triangle it is.
    pub(super) center: Vec3,
    /// Its corners.
    pub(super) points: &'a [Vec3],
    pub(super) discs: Option<Discs>,
    /// Its faces.
    pub(super) planes: &'a [Plane],
    /// Rounding [m].
    pub(super) radius: f32,
}

/// Lists the triangles that may be reached, in the order of their numbers; returns a distance [m] that
/// the solid is at least away from all triangles (below 0: not known).
pub(super) fn find(
    mesh: &Mesh,
    solid: &Outline<'_>,
    reach: &Reach,
    [stack, packs]: [&mut Vec<u32>; 2],
    near: &mut Vec<u32>,
) -> f32 {
    near.clear();
    let way = reach.way;
    let moved = Aabb::new(solid.bounds.min + way, solid.bounds.max + way);
    let look = reach.rest + reach.room;
    let (center, axes, half) = &solid.core;
    let along = [0, 1, 2].map(|k| 0.5 * axes[k].dot(way).abs() + solid.radius + look);
    let window = Window {
        bounds: solid.bounds.grown(look).union(&moved.grown(reach.rest)),
        center: *center + way * 0.5,
        axes: *axes,
        half: *half + Vec3 { x: along[0], y: along[1], z: along[2] },
    };
    // The window reaches `look` beyond the solid: what is outside it is farther by so much.
    let mut gap = look + mesh.tree().find(&window, stack, packs);
    for &item in packs.iter() {
        let pack = mesh.pack(item);
        let (apart, missed) = test(pack, solid, reach);
        for ((number, apart), missed) in pack.numbers().iter().zip(apart).zip(missed) {
            gap = lesser(gap, apart);
            if !(missed > reach.rest) {
                near.push(*number);
            }
        }
    }
    near.sort_unstable();
    gap
}

/// For each lane: how far apart the triangle and the solid are at least now, and how far they stay
/// apart along the solid's way.
#[inline]
fn test(pack: &Pack, solid: &Outline<'_>, reach: &Reach) -> (Lanes, Lanes) {
    let mut apart = [f32::NEG_INFINITY; LANES];
    let mut missed = [f32::NEG_INFINITY; LANES];
    let [p, q, r] = &pack.corners;
    for axis in 0..3 {
        let (low, high) = (solid.bounds.min[axis], solid.bounds.max[axis]);
        let way = reach.way[axis];
        let (back, on) = (lesser(way, 0.0), greater(way, 0.0));
        for i in 0..LANES {
            let least = lesser(lesser(p[axis][i], q[axis][i]), r[axis][i]);
            let most = greater(greater(p[axis][i], q[axis][i]), r[axis][i]);
            let (above, below) = (low - most, least - high);
            apart[i] = greater(apart[i], greater(above, below));
            missed[i] = greater(missed[i], greater(above + back, below - on));
        }
    }
    if missed.iter().all(|m| *m > reach.rest) {
        return (apart, missed);
    }
    let [nx, ny, nz] = &pack.normals;
    // The solid's extent along the normal, from the plane.
    let (mut low, mut high) = ([f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]);
    for (k, v) in solid.points.iter().enumerate() {
        let mut rim = [0.0; LANES];
        if let Some((axis, radii)) = &solid.discs {
            let radius = radii[k.min(1)];
            for i in 0..LANES {
                let along = nx[i] * axis.x + ny[i] * axis.y + nz[i] * axis.z;
                rim[i] = radius * greater(1.0 - along * along, 0.0).sqrt();
            }
        }
        for i in 0..LANES {
            let height =
                nx[i] * (v.x - p[0][i]) + ny[i] * (v.y - p[1][i]) + nz[i] * (v.z - p[2][i]);
            low[i] = lesser(low[i], height - rim[i]);
            high[i] = greater(high[i], height + rim[i]);
        }
    }
    let (center, way) = (solid.center, reach.way);
    for i in 0..LANES {
        let height = nx[i] * (center.x - p[0][i])
            + ny[i] * (center.y - p[1][i])
            + nz[i] * (center.z - p[2][i]);
        let rising = nx[i] * way.x + ny[i] * way.y + nz[i] * way.z;
        let below = height < 0.0;
        let over = (if below { -high[i] } else { low[i] }) - solid.radius;
        let closing = lesser(if below { -rising } else { rising }, 0.0);
        apart[i] = greater(apart[i], over);
        missed[i] = greater(missed[i], over + closing);
    }
    if missed.iter().all(|m| *m > reach.rest) {
        return (apart, missed);
    }
    for plane in solid.planes {
        let (n, offset) = (plane.normal, plane.offset + solid.radius);
        let closing = greater(n.dot(way), 0.0);
        for i in 0..LANES {
            let height = |c: &[Lanes; 3]| n.x * c[0][i] + n.y * c[1][i] + n.z * c[2][i];
            let over = lesser(lesser(height(p), height(q)), height(r)) - offset;
            apart[i] = greater(apart[i], over);
            missed[i] = greater(missed[i], over - closing);
        }
    }
    (apart, missed)
}
