//! Penetration of two convex sets given by support mappings, after [Bergen01].
//!
//! The polytope grows inside the difference A - B, always at the face whose plane is nearest to the
//! origin *by signed distance*. It may therefore start anywhere, with the origin inside or not.
//! Sets that just miss each other give their separating axis instead of an error.

use smallvec::SmallVec;

use super::gjk::Wide;
use crate::base::math::Vec3;

const MAX_CORNERS: usize = 128;
const MAX_FACES: usize = 2 * MAX_CORNERS;
const MAX_HORIZON: usize = MAX_CORNERS;

#[derive(Clone, Copy)]
struct Face {
    corners: [u8; 3],
    /// Unit normal, outward.
    normal: Wide,
    offset: f64,
}

struct Growing {
    corners: SmallVec<[Wide; MAX_CORNERS]>,
    faces: SmallVec<[Face; MAX_FACES]>,
    /// Maximum height of a point above a face at which it counts as in its plane [m]: rounding must
    /// not make a far face visible.
    flush: f64,
}

/// Returns the unit direction from A to B of minimum overlap, within `tolerance` [m] of the depth;
/// `None` if the difference is flat or not finite.
pub(crate) fn min_overlap(
    support_a: impl Fn(Vec3) -> Vec3,
    support_b: impl Fn(Vec3) -> Vec3,
    tolerance: f32,
) -> Option<Vec3> {
    let support = |d: Wide| {
        let d = d.narrow();
        Wide::of(support_a(d)).minus(Wide::of(support_b(-d)))
    };
    // 13 KiB, which grow in place: to move or to clear them costs more than most searches.
    let mut body = Growing { corners: SmallVec::new(), faces: SmallVec::new(), flush: 0.0 };
    body.begin(&support)?;
    loop {
        let mut nearest = *body.faces.first()?;
        for f in &body.faces {
            if f.offset < nearest.offset {
                nearest = *f;
            }
        }
        let p = support(nearest.normal);
        let gain = nearest.normal.dot(p) - nearest.offset;
        let grows = gain > f64::from(tolerance) && body.grow(p);
        if !grows {
            return nearest.normal.narrow().try_normalize();
        }
    }
}

impl Growing {
    /// Starts with a tetrahedron.
    #[inline]
    fn begin(&mut self, support: &impl Fn(Wide) -> Wide) -> Option<()> {
        let axis = |x, y, z| Wide { x, y, z };
        let wider = |d: Wide, from: Wide| {
            let (p, q) = (support(d), support(d.times(-1.0)));
            if (p.minus(from).dot(d)).abs() >= (q.minus(from).dot(d)).abs() { p } else { q }
        };
        let a = support(axis(1.0, 0.0, 0.0));
        let b = support(axis(-1.0, 0.0, 0.0));
        let along = unit(b.minus(a))?;
        let side = unit(along.cross(if along.y.abs() < 0.6 {
            axis(0.0, 1.0, 0.0)
        } else {
            axis(0.0, 0.0, 1.0)
        }))?;
        let (mut c, other) = (wider(side, a), wider(along.cross(side), a));
        let area = |p: Wide| {
            let n = p.minus(a).cross(along);
            n.dot(n)
        };
        if area(other) > area(c) {
            c = other;
        }
        let normal = unit(b.minus(a).cross(c.minus(a)))?;
        let d = wider(normal, a);
        let height = normal.dot(d.minus(a));
        let width = b.minus(a).dot(b.minus(a)).sqrt();
        let is_solid = height.abs() > 1.0e-9 * width;
        if !is_solid {
            return None;
        }
        self.flush = 1.0e-12 * width;
        self.corners.extend_from_slice(&[a, b, c, d]);
        let faces: [[u8; 3]; 4] = if height > 0.0 {
            [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
        } else {
            [[0, 1, 2], [1, 0, 3], [2, 1, 3], [0, 2, 3]]
        };
        for f in faces {
            self.push(f).then_some(())?;
        }
        Some(())
    }

    fn push(&mut self, corners: [u8; 3]) -> bool {
        let [a, b, c] = corners.map(|i| self.corners[usize::from(i)]);
        if self.faces.len() == MAX_FACES {
            return false;
        }
        // A face of three collinear corners closes the surface and never grows.
        let nothing = Face { corners, normal: Wide::default(), offset: f64::INFINITY };
        self.faces.push(match unit(b.minus(a).cross(c.minus(a))) {
            Some(normal) => Face { corners, normal, offset: normal.dot(a) },
            None => nothing,
        });
        true
    }

    /// Adds a corner; returns false if there is no space left or the surface would not stay closed.
    fn grow(&mut self, p: Wide) -> bool {
        let new = self.corners.len();
        if new == MAX_CORNERS {
            return false;
        }
        self.corners.push(p);
        let mut horizon = SmallVec::<[(u8, u8); MAX_HORIZON]>::new();
        let mut k = 0;
        while let Some(f) = self.faces.get(k) {
            if f.normal.dot(p) - f.offset <= self.flush {
                k += 1;
                continue;
            }
            let [a, b, c] = f.corners;
            for edge in [(a, b), (b, c), (c, a)] {
                // An edge between two removed faces appears once from each side.
                if let Some(twin) = horizon.iter().position(|e| *e == (edge.1, edge.0)) {
                    horizon.swap_remove(twin);
                } else if horizon.len() < MAX_HORIZON {
                    horizon.push(edge);
                } else {
                    return false;
                }
            }
            self.faces.swap_remove(k);
        }
        #[expect(clippy::cast_possible_truncation, reason = "below MAX_CORNERS")]
        let top = new as u8;
        horizon.len() >= 3 && horizon.iter().all(|e| self.push([e.0, e.1, top]))
    }
}

fn unit(v: Wide) -> Option<Wide> {
    let length = v.dot(v).sqrt();
    (length > 1.0e-30 && length.is_finite()).then(|| v.times(1.0 / length))
}
