//! The common part of two faces of hulls that lie flush.

use super::cells::across;
use super::hull::Hull;
use crate::base::double::DVec3;
use crate::base::math::Vec3;
use crate::base::pose::Pose;

/// The common part of two faces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Flush {
    /// Center of the part [m].
    pub(crate) point: Vec3,
    /// Normal from the first hull to the second.
    pub(crate) normal: Vec3,
    /// Area [m²].
    pub(crate) area: f32,
}

/// Faces count as parallel if the cosine between one and the back of the other is above this: 0.8
/// degrees.
const PARALLEL: f64 = 0.9999;

/// Returns the largest common part of a face of each of two hulls. The faces look at each other
/// from no farther than `gap` [m], and overlap no deeper. Returns `None` if there is none.
pub(crate) fn flush(a: (&Hull, &Pose), b: (&Hull, &Pose), gap: f32) -> Option<Flush> {
    let gap = f64::from(gap);
    let mut best: Option<Flush> = None;
    for face_a in 0..a.0.face_count() {
        let n = DVec3::from(a.1.direction(a.0.planes()[face_a].normal));
        let polygon_a = corners(a, face_a);
        let Some(&first) = polygon_a.first() else { continue };
        for face_b in 0..b.0.face_count() {
            let other = DVec3::from(b.1.direction(b.0.planes()[face_b].normal));
            if -n.dot(other) < PARALLEL {
                continue;
            }
            let polygon_b = corners(b, face_b);
            let Some(&second) = polygon_b.first() else { continue };
            if n.dot(second - first).abs() > gap {
                continue;
            }
            let Some(found) = common(n, &polygon_a, &polygon_b) else { continue };
            if best.is_none_or(|old| found.area > old.area) {
                best = Some(found);
            }
        }
    }
    best
}

fn corners((hull, pose): (&Hull, &Pose), face: usize) -> Vec<DVec3> {
    let vertex = |v: u16| DVec3::from(pose.point(hull.vertices()[usize::from(v)]));
    hull.face(face).into_iter().map(vertex).collect()
}

/// Common part of two polygons in a plane; B's corners are in the opposite order.
fn common(n: DVec3, a: &[DVec3], b: &[DVec3]) -> Option<Flush> {
    let (u, v) = across(n);
    let from = a[0];
    let flat = |p: &DVec3| [u.dot(*p - from), v.dot(*p - from)];
    let mut left: Vec<[f64; 2]> = a.iter().map(flat).collect();
    let sides: Vec<[f64; 2]> = b.iter().rev().map(flat).collect();
    for (k, p) in sides.iter().enumerate() {
        let q = sides[(k + 1) % sides.len()];
        // The part left of the side from p to q [Sutherland74].
        let inside = |x: &[f64; 2]| (q[0] - p[0]) * (x[1] - p[1]) - (q[1] - p[1]) * (x[0] - p[0]);
        let mut next = Vec::with_capacity(left.len() + 1);
        for (i, x) in left.iter().enumerate() {
            let y = left[(i + 1) % left.len()];
            let (hx, hy) = (inside(x), inside(&y));
            if hx >= 0.0 {
                next.push(*x);
            }
            if (hx > 0.0 && hy < 0.0) || (hx < 0.0 && hy > 0.0) {
                let t = hx / (hx - hy);
                next.push([x[0] + (y[0] - x[0]) * t, x[1] + (y[1] - x[1]) * t]);
            }
        }
        left = next;
    }
    let (mut area, mut sum) = (0.0, [0.0; 2]);
    for k in 2..left.len() {
        let (o, p, q) = (left[0], left[k - 1], left[k]);
        let half = 0.5 * ((p[0] - o[0]) * (q[1] - o[1]) - (p[1] - o[1]) * (q[0] - o[0]));
        area += half;
        for i in 0..2 {
            sum[i] += half * (o[i] + p[i] + q[i]) / 3.0;
        }
    }
    if area <= 0.0 {
        return None;
    }
    let point = from + u * (sum[0] / area) + v * (sum[1] / area);
    #[expect(clippy::cast_possible_truncation, reason = "rounding is what is asked for")]
    let area = area as f32;
    (area > 0.0).then(|| Flush { point: point.single(), normal: n.single(), area })
}

#[cfg(test)]
mod tests {
    use super::flush;
    use crate::base::math::{Vec3, vec3};
    use crate::base::pose::Pose;
    use crate::base::quat::Quat;
    use crate::geometry::hull::Hull;

    #[test]
    fn two_boxes_share_what_their_faces_have_in_common() {
        let (a, b) = (Hull::cuboid(Vec3::ONE), Hull::cuboid(vec3(0.5, 1.0, 2.0)));
        let turn = Quat::from_axis_angle(vec3(1.0, 2.0, 3.0), 0.7);
        let base = Pose::new([3.0, -2.0, 1.0], turn);
        for (at, area) in [
            (vec3(1.5, 0.0, 0.0), 4.0),
            (vec3(1.5, 1.0, 0.0), 2.0),
            (vec3(1.5, 1.5, 2.5), 0.25),
            (vec3(1.6, 0.0, 0.0), 0.0),
            (vec3(1.5, 3.0, 0.0), 0.0),
        ] {
            let placed = base.compose(&Pose::at(at));
            let found = flush((&a, &base), (&b, &placed), 1e-3);
            assert!((found.map_or(0.0, |f| f.area) - area).abs() < 1e-4, "{at:?} {found:?}");
            if let Some(found) = found {
                assert!((found.normal - turn.rotate(Vec3::X)).length() < 1e-6);
                assert!((base.local_point(found.point).x - 1.0).abs() < 1e-5);
            }
        }
    }
}
