//! Builds a [`Hull`] from points: checks the input, triangulates, joins coplanar faces, checks the
//! result.

use super::facets::{dent, polygons, unmerged};
use super::quickhull::{Failure, Triangle, triangulate};
use super::{Hull, HullError, Plane, link_loops};
use crate::base::aabb::Aabb;
use crate::base::double::{DVec3, greater, lesser};
use crate::base::limits;
use crate::base::math::Vec3;

/// A closed surface of triangles with n vertices has 6n - 12 half-edges, numbered in 16 bits.
const MAX_VERTICES: usize = 10_000;

/// Coplanarity tolerance, relative to the extent of the points. Points from text or from a rotation
/// are accurate to 1e-6 of it; edges shorter than this tolerance carry no visible contact.
const COPLANAR: f64 = 1.0e-5;

/// Minimum thickness of a hull, in tolerances and in meters; the latter is the same as for other
/// shapes.
const MIN_TOLERANCES: f64 = 4.0;
const MIN_LENGTH: f64 = 1.0e-5;

/// Factors on the tolerance. Where a surface does not close, a coarser tolerance mostly closes it.
/// The last factor allows errors of 64 * 8 * 1e-5 = 0.5 % of the extent; no point cloud of our
/// tests needed it.
const COARSER: [f64; 4] = [1.0, 4.0, 16.0, 64.0];

/// Maximum distance, in tolerances, by which a plane is moved outward to hold all vertices.
const MAX_PUSH: f64 = 8.0;

/// Checks each point by itself: finite, within range, and enough of them.
pub(super) fn check_points(points: &[Vec3]) -> Result<(), HullError> {
    if let Some(i) = points.iter().position(|p| !p.is_finite()) {
        return Err(HullError::NotFinite(i));
    }
    if let Some(i) = points.iter().position(|p| p.abs().max_element() > limits::POSITION.maximum) {
        return Err(HullError::TooLarge(i));
    }
    if points.len() < 4 {
        return Err(HullError::TooFewPoints(points.len()));
    }
    Ok(())
}

/// Refuses planes that do not belong to these faces. A face's corners must lie on its plane, and
/// all other vertices behind it. The margin is twice the error at the coarsest tolerance, since
/// points that were left out are not among the vertices.
pub(super) fn check_planes(
    vertices: &[Vec3],
    planes: &[Plane],
    faces: &[Vec<u16>],
) -> Result<(), HullError> {
    let maximum = 2.0 * MAX_PUSH * COARSER[COARSER.len() - 1] * Cloud::new(vertices).tolerance;
    for (plane, face) in planes.iter().zip(faces) {
        let normal = DVec3::from(plane.normal);
        let is_unit = (normal.length() - 1.0).abs() < 1.0e-5;
        let offset = f64::from(plane.offset);
        let height = |v: &Vec3| normal.dot(DVec3::from(*v)) - offset;
        let on = face.iter().all(|v| height(&vertices[usize::from(*v)]) >= -maximum);
        if !(is_unit && on && vertices.iter().all(|v| height(v) <= maximum)) {
            return Err(HullError::Numerical);
        }
    }
    Ok(())
}

pub(super) fn quickhull(points: &[Vec3], max_vertices: usize) -> Result<Hull, HullError> {
    if max_vertices < 4 {
        return Err(HullError::LimitTooSmall(max_vertices));
    }
    check_points(points)?;
    let cloud = Cloud::new(points);
    let limit = max_vertices.min(MAX_VERTICES);
    for (k, factor) in COARSER.iter().enumerate() {
        let tolerance = cloud.tolerance * factor;
        let minimum = greater(tolerance * MIN_TOLERANCES, MIN_LENGTH);
        let triangles = match triangulate(&cloud.relative, limit, tolerance, minimum) {
            Ok(triangles) => triangles,
            #[expect(clippy::cast_possible_truncation, reason = "for a message")]
            Err(Failure::Flat(t)) if k == 0 => return Err(HullError::Flat(t as f32)),
            Err(Failure::Flat(_)) => break,
        };
        let merged = polygons(&cloud.relative, &triangles, tolerance);
        if let Some(hull) = cloud.hull(&merged, &triangles, tolerance) {
            return Ok(hull);
        }
        if let Some(hull) = cloud.hull(&unmerged(&triangles), &triangles, tolerance) {
            return Ok(hull);
        }
    }
    Err(HullError::Numerical)
}

/// The points, as given and in double precision relative to the middle of their bounding box.
struct Cloud<'a> {
    points: &'a [Vec3],
    relative: Vec<DVec3>,
    middle: DVec3,
    tolerance: f64,
}

impl<'a> Cloud<'a> {
    fn new(points: &'a [Vec3]) -> Self {
        let bounds = Aabb::of_points(points.iter().copied());
        let size = f64::from((bounds.max - bounds.min).max_element());
        let middle = DVec3::from(bounds.center());
        let reach = f64::from(bounds.max.abs().max(bounds.min.abs()).max_element());
        let tolerance = size * COPLANAR + reach * f64::from(f32::EPSILON);
        let relative = points.iter().map(|p| DVec3::from(*p) - middle).collect();
        Self { points, relative, middle, tolerance }
    }

    /// Builds the hull with these faces. Returns `None` if it is not closed, not convex or does not
    /// contain the corners of `triangles`, all within some tolerances.
    fn hull(&self, loops: &[Vec<usize>], triangles: &[Triangle], tolerance: f64) -> Option<Hull> {
        let mut used: Vec<usize> = loops.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        let mut numbered: Vec<Vec<u16>> = Vec::with_capacity(loops.len());
        for face in loops {
            let number = |v: &usize| u16::try_from(used.binary_search(v).ok()?).ok();
            numbered.push(face.iter().map(number).collect::<Option<_>>()?);
        }
        let (face_edges, edges) = link_loops(&numbered)?;
        if used.len() + loops.len() != edges.len() / 2 + 2 {
            return None;
        }
        let mut corners: Vec<usize> = triangles.iter().flat_map(|t| t.v).collect();
        corners.sort_unstable();
        corners.dedup();
        let mut planes = Vec::with_capacity(loops.len());
        for face in loops {
            planes.push(self.plane(face, &used, &corners, tolerance)?);
        }
        let vertices = used.iter().map(|v| self.points[*v]).collect();
        Some(Hull::from_parts(vertices, planes, face_edges, edges))
    }

    /// Plane of a face by Newell's sum over its edges, moved outward to hold all vertices.
    fn plane(
        &self,
        face: &[usize],
        used: &[usize],
        corners: &[usize],
        tolerance: f64,
    ) -> Option<Plane> {
        let p = |k: usize| self.relative[face[k % face.len()]];
        let n = face.len();
        let area =
            (2..n).map(|k| (p(k - 1) - p(0)).cross(p(k) - p(0))).fold(DVec3::ZERO, |s, c| s + c);
        let length = area.length();
        if length <= 0.0 {
            return None;
        }
        // All later tests use the rounded normal, so the rounded plane is the one to move.
        let normal = (area * (1.0 / length)).single();
        let exact = DVec3::from(normal);
        let height = |v: usize| exact.dot(self.relative[v]);
        let highest = |of: &[usize]| of.iter().map(|v| height(*v)).fold(f64::MIN, greater);
        let offset = highest(used);
        let lowest = face.iter().map(|v| height(*v)).fold(f64::MAX, lesser);
        let depth = used.iter().map(|v| offset - height(*v)).fold(0.0, greater);
        if offset - lowest > MAX_PUSH * tolerance
            || highest(corners) - offset > MAX_PUSH * tolerance
            || depth < tolerance
        {
            return None;
        }
        if dent(&self.relative, face, exact) > MAX_PUSH * tolerance {
            return None;
        }
        #[expect(clippy::cast_possible_truncation, reason = "rounded to the type of planes")]
        let offset = (offset + exact.dot(self.middle)) as f32;
        Some(Plane { normal, offset })
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Hull, HullError};
    use crate::base::math::{Vec3, vec3};

    fn corners(h: Vec3) -> Vec<Vec3> {
        Hull::cuboid(h).vertices().to_vec()
    }

    fn counts(hull: &Hull) -> (usize, usize, usize) {
        let p = hull;
        (p.vertices.len(), p.edges.len() / 2, p.planes.len())
    }

    #[test]
    fn points_on_the_faces_and_edges_of_a_box_leave_a_box() {
        let mut points = corners(vec3(1.0, 2.0, 3.0));
        for a in -4..=4_i8 {
            for b in -4..=4_i8 {
                let (a, b) = (f32::from(a) * 0.25, f32::from(b) * 0.25);
                for s in [-1.0, 1.0] {
                    points.push(vec3(s, 2.0 * a, 3.0 * b));
                    points.push(vec3(a, 2.0 * s, 3.0 * b));
                    points.push(vec3(a, 2.0 * b, 3.0 * s));
                    points.push(vec3(a * 0.9, b * 0.9, s * 0.9));
                }
            }
        }
        points.reverse();
        let hull = Hull::from_points(&points).unwrap();
        assert_eq!(counts(&hull), (8, 12, 6));
        assert!((hull.volume() - 48.0).abs() < 1e-4);
        // The corners alone are the farthest points, so a limit of eight keeps them.
        let hull = Hull::from_points_limited(&points, 8).unwrap();
        assert_eq!(counts(&hull), (8, 12, 6));
    }

    #[test]
    fn a_rotated_and_distant_box_is_a_box_in_spite_of_rounding() {
        let turn = crate::base::quat::Quat::from_axis_angle(vec3(1.0, 2.0, 3.0), 0.8);
        for far in [0.0, 10.0, 1000.0] {
            let at = vec3(far, -far, 0.5 * far);
            let points: Vec<Vec3> = corners(vec3(1.0, 0.5, 2.0))
                .into_iter()
                .chain([vec3(1.0, 0.3, 1.5), vec3(0.2, 0.5, -1.0), vec3(1.0, 0.5, 0.1)])
                .map(|p| turn.rotate(p) + at)
                .collect();
            let hull = Hull::from_points(&points).unwrap();
            assert_eq!(counts(&hull), (8, 12, 6), "{far}");
        }
    }

    #[test]
    fn bad_input_is_named() {
        let cube = corners(Vec3::ONE);
        let with = |p: Vec3| cube.iter().copied().chain([p]).collect::<Vec<_>>();
        let error = |points: &[Vec3]| Hull::from_points(points).unwrap_err();
        assert_eq!(error(&[]), HullError::TooFewPoints(0));
        assert_eq!(error(&with(vec3(f32::NAN, 0.0, 0.0))), HullError::NotFinite(8));
        assert_eq!(error(&with(vec3(0.0, 2.0e7, 0.0))), HullError::TooLarge(8));
        let limited = Hull::from_points_limited(&cube, 3).unwrap_err();
        assert_eq!(limited, HullError::LimitTooSmall(3));
        let flat: [fn(Vec3) -> Vec3; 3] =
            [|_| Vec3::ONE, |p| vec3(p.x, p.x, p.x), |p| vec3(p.x, p.y, p.x + p.y)];
        for f in flat {
            let points: Vec<Vec3> = cube.iter().map(|p| f(*p)).collect();
            assert!(matches!(error(&points), HullError::Flat(_)));
        }
    }

    #[test]
    fn a_limited_ball_keeps_its_limit_and_most_of_its_volume() {
        let mut points = Vec::new();
        for i in 0..100_u8 {
            for j in 0..50_u8 {
                let (s, c) = crate::base::trig::sin_cos(f32::from(i) * 0.062_831_85);
                let (t, u) = crate::base::trig::sin_cos(f32::from(j) * 0.062_831_85);
                points.push(vec3(s * t, c * t, u));
            }
        }
        for limit in [4, 5, 16, 64, 255] {
            let hull = Hull::from_points_limited(&points, limit).unwrap();
            assert!(hull.vertices().len() <= limit);
            assert!(limit < 64 || hull.volume() > 3.7, "{limit}: {}", hull.volume());
        }
        assert!(Hull::from_points_limited(&points, 100_000).unwrap().volume() > 4.17);
    }
}
