//! The point of a solid that is nearest to a given point, for contacts of particles.

use super::collide::convex::Convex;
use super::collide::frustum::Frustum;
use super::convex::clip::clamp01;
use super::convex::gjk;
use super::hull::Hull;
use super::mesh::Mesh;
use super::solid::{Core, Solid};
use crate::base::aabb::Aabb;
use crate::base::math::{Vec3, vec3};

/// Nearest surface of a solid to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Nearest {
    /// Distance from the surface [m]; below 0 inside a convex solid.
    pub(crate) distance: f32,
    /// Unit normal, away from the solid [its frame].
    pub(crate) normal: Vec3,
}

/// Returns the nearest surface to `p` [m, frame of the solid], unless it is farther than `reach`.
pub(crate) fn nearest(solid: &Solid, p: Vec3, reach: f32) -> Option<Nearest> {
    let found = match &solid.core {
        Core::Point => round(p),
        Core::Segment { half_height } => {
            round(p - vec3(0.0, p.y.clamp(-half_height, *half_height), 0.0))
        }
        Core::Hull(hull) => match hull.cuboid {
            Some(half) => cuboid(half, p),
            None => polytope(hull, p, reach + solid.radius)?,
        },
        Core::Frustum { half_height, radius_bottom, radius_top } => {
            let frustum = Frustum::new(*half_height, *radius_bottom, *radius_top);
            let m = frustum.against_point(p, reach);
            let point = m.points[..m.count].first()?;
            Nearest { distance: point.separation, normal: m.normal }
        }
        Core::HalfSpace { normal, offset } => {
            Nearest { distance: normal.dot(p) - offset, normal: *normal }
        }
        Core::Mesh(mesh) => triangles(mesh, p, reach)?,
    };
    let distance = found.distance - solid.radius;
    (distance <= reach).then_some(Nearest { distance, ..found })
}

fn round(away: Vec3) -> Nearest {
    Nearest { distance: away.length(), normal: away.normalize_or(Vec3::X) }
}

fn cuboid(half: Vec3, p: Vec3) -> Nearest {
    let beyond = p.abs() - half;
    let sign = |x: f32| if x < 0.0 { -1.0 } else { 1.0 };
    if beyond.max_element() <= 0.0 {
        let (distance, normal) = if beyond.x >= beyond.y && beyond.x >= beyond.z {
            (beyond.x, vec3(sign(p.x), 0.0, 0.0))
        } else if beyond.y >= beyond.z {
            (beyond.y, vec3(0.0, sign(p.y), 0.0))
        } else {
            (beyond.z, vec3(0.0, 0.0, sign(p.z)))
        };
        return Nearest { distance, normal };
    }
    let out = beyond.max(Vec3::ZERO);
    let distance = out.length();
    let away = vec3(out.x * sign(p.x), out.y * sign(p.y), out.z * sign(p.z));
    // The largest is above 0, but its square need not be.
    let fallback = if out.x > 0.0 {
        Vec3::X
    } else if out.y > 0.0 {
        Vec3::Y
    } else {
        Vec3::Z
    };
    Nearest {
        distance,
        normal: away.normalize_or(fallback.mul_each(vec3(sign(p.x), sign(p.y), sign(p.z)))),
    }
}

fn polytope(hull: &Hull, p: Vec3, reach: f32) -> Option<Nearest> {
    let (mut face, mut distance) = (Vec3::Y, f32::NEG_INFINITY);
    for plane in hull.planes() {
        let d = plane.distance(p);
        if d > distance {
            (face, distance) = (plane.normal, d);
        }
    }
    if distance > reach {
        return None;
    }
    let above = Nearest { distance, normal: face };
    if distance <= 0.0 {
        return Some(above);
    }
    // A point so near that the search reports a touch: the face normal is right.
    let shape = Convex::Hull(hull);
    let found = gjk::distance(|d| shape.support(d), |_| p, p - shape.center());
    Some(found.map_or(above, |c| Nearest { distance: c.distance, normal: c.normal }))
}

/// At equal distances (a shared edge) the triangle with the lower number wins, whatever order the
/// tree visits them in. A point on the surface counts as above the side that its triangle's normal
/// points to.
fn triangles(mesh: &Mesh, p: Vec3, reach: f32) -> Option<Nearest> {
    let around = Aabb::new(p, p).grown(reach);
    let mut best: Option<(f32, u32, Vec3, Vec3)> = None;
    mesh.tree().query(&around, &mut |item| {
        let pack = mesh.pack(item);
        for (lane, &number) in pack.numbers().iter().enumerate() {
            let away = p - on_triangle(pack.triangle(lane), p);
            let square = away.length_squared();
            if best.is_none_or(|(s, n, ..)| square < s || (square <= s && number < n)) {
                best = Some((square, number, away, pack.normal(lane)));
            }
        }
    });
    let (square, _, away, face) = best?;
    let distance = square.sqrt();
    let normal = if distance > 1.0e-6 { away * (1.0 / distance) } else { face };
    (distance <= reach).then_some(Nearest { distance, normal })
}

/// Point of a triangle nearest to `p`, by the Voronoi regions of its corners, edges and inside
/// [Ericson05].
fn on_triangle([a, b, c]: [Vec3; 3], p: Vec3) -> Vec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * clamp01(d1 / (d1 - d3));
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * clamp01(d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return b + (c - b) * clamp01(t);
    }
    let scale = 1.0 / (va + vb + vc);
    a + ab * (vb * scale) + ac * (vc * scale)
}

#[cfg(test)]
mod tests {
    use super::nearest;
    use crate::base::math::{Vec3, vec3};
    use crate::geometry::hull::Hull;
    use crate::geometry::mesh::Mesh;
    use crate::geometry::oracle::{Numbers, grid, parry};
    use crate::geometry::shape::Shape;
    use crate::geometry::solid::Solid;
    use parry3d::query::PointQuery;
    use parry3d::shape;
    use std::sync::Arc;

    /// Compares distances of points around the shape, and the surface points that they lead to.
    fn compare(shape: &Shape, reference: &impl PointQuery, solid: bool) {
        let ours = Solid::of(shape);
        let mut numbers = Numbers(7);
        let mut inside = 0;
        for _ in 0..20_000 {
            let p = numbers.point() * 3.0;
            let found = nearest(&ours, p, 100.0).expect("within reach");
            let theirs = reference.project_local_point(parry(p), false);
            let q = Vec3::from(theirs.point.to_array());
            let away = (p - q).length();
            let distance = if solid && theirs.is_inside { -away } else { away };
            inside += u32::from(distance < 0.0);
            // Both in f32 over coordinates up to 3 m; parry's projections of cones and hulls
            // iterate.
            assert!(
                (found.distance - distance).abs() < 2e-5,
                "{shape:?} {p:?}: {found:?} {distance}"
            );
            assert!((found.normal.length() - 1.0).abs() < 1e-5);
            let on = p - found.normal * found.distance;
            let back = reference.project_local_point(parry(on), false);
            assert!((on - Vec3::from(back.point.to_array())).length() < 1e-4, "{shape:?} {p:?}");
            if found.distance > 0.1 {
                assert!(nearest(&ours, p, 0.09).is_none());
            }
        }
        assert_eq!(inside > 100, solid, "{}: {inside} inside", shape.kind());
    }

    #[test]
    fn points_are_as_far_from_shapes_as_parry_says() {
        compare(&Shape::sphere(1.2), &shape::Ball::new(1.2), true);
        compare(&Shape::capsule(0.8, 0.6), &shape::Capsule::new_y(0.8, 0.6), true);
        let half = vec3(0.7, 1.1, 1.5);
        compare(&Shape::box_half(half), &shape::Cuboid::new(parry(half)), true);
        compare(&Shape::cylinder(0.9, 1.1), &shape::Cylinder::new(0.9, 1.1), true);
        compare(&Shape::cone(1.2, 1.3), &shape::Cone::new(1.2, 1.3), true);
        let normal = vec3(0.6, 0.8, 0.0);
        let plane = shape::HalfSpace::new(parry(normal));
        compare(&Shape::HalfSpace { normal, offset: 0.0 }, &plane, true);
    }

    #[test]
    fn points_are_as_far_from_a_hull_as_its_faces_say() {
        let mut numbers = Numbers(5);
        let points: Vec<Vec3> = (0..40).map(|_| numbers.point() * 1.5).collect();
        let hull = Hull::from_points(&points).unwrap();
        let mut triangles = Vec::new();
        for face in 0..hull.planes().len() {
            let corners = hull.face(face);
            for k in 1..corners.len() - 1 {
                triangles.push([corners[0], corners[k], corners[k + 1]].map(u32::from));
            }
        }
        let skin = Solid::of(&Shape::Mesh(Arc::new(
            Mesh::new(hull.vertices().to_vec(), triangles).unwrap(),
        )));
        let planes = hull.planes().to_vec();
        let solid = Solid::of(&Shape::Hull(Arc::new(hull)));
        for _ in 0..20_000 {
            let p = numbers.point() * 3.0;
            let (a, b) = (nearest(&solid, p, 100.0).unwrap(), nearest(&skin, p, 100.0).unwrap());
            let inside = planes.iter().all(|q| q.distance(p) < 0.0);
            assert_eq!(a.distance < 0.0, inside);
            assert!((a.distance.abs() - b.distance).abs() < 2e-5, "{p:?}: {a:?} {b:?}");
        }
    }

    #[test]
    fn points_are_as_far_from_a_mesh_as_parry_says() {
        let (vertices, triangles) = grid();
        let theirs = vertices.iter().map(|v| parry(*v)).collect();
        let reference = shape::TriMesh::new(theirs, triangles.clone()).unwrap();
        let mesh = Shape::Mesh(Arc::new(Mesh::new(vertices, triangles).unwrap()));
        compare(&mesh, &reference, false);
    }
}
