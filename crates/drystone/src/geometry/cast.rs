//! Casts a ray against one solid.
//!
//! All in double precision: the discriminant of a distant ray is a small difference of large
//! squares.

use super::approach::ALONG;
use super::boxes::Ray;
use super::hull::Hull;
use super::mesh::Mesh;
use super::nearest::nearest;
use super::solid::{Core, Solid};
use crate::base::double::{DVec3, greater, lesser};
use crate::base::math::Vec3;

/// A hit of a ray on a solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RayHit {
    /// Fraction of the ray's length, 0 to 1.
    pub(crate) fraction: f32,
    /// Outward normal at the hit [frame of the solid].
    pub(crate) normal: Vec3,
}

/// Returns the first point of `origin + t delta`, 0 <= t <= `max_fraction`, on the surface of the
/// solid (both in its frame). A ray that starts inside a convex solid does not hit it.
pub(crate) fn ray(solid: &Solid, origin: Vec3, delta: Vec3, max_fraction: f32) -> Option<RayHit> {
    let line = Line { o: DVec3::from(origin), d: DVec3::from(delta) };
    let radius = f64::from(solid.radius);
    let hit = match &solid.core {
        Core::Point => ball(line, radius),
        Core::Segment { half_height } => capsule(line, f64::from(*half_height), radius),
        Core::Hull(hull) => polytope(hull, line),
        Core::Frustum { half_height, radius_bottom, radius_top } => {
            let (bottom, top) = (f64::from(*radius_bottom), f64::from(*radius_top));
            frustum(line, f64::from(*half_height), bottom, top)
        }
        Core::HalfSpace { normal, offset } => half_space(line, *normal, f64::from(*offset)),
        Core::Mesh(mesh) => return nearest_triangle(mesh, origin, delta, max_fraction),
    };
    let (t, normal) = hit?;
    let fraction = single(t);
    (fraction <= max_fraction).then(|| RayHit { fraction, normal: normal.single() })
}

/// Depth of a point inside a solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Depth {
    /// Outward normal of the nearest surface [frame of the solid].
    pub(crate) normal: Vec3,
    /// Depth below the surface [m].
    depth: f32,
    /// Rounding error of the surface [m].
    rounding: f32,
}

/// Rounding error of a solid's surface, relative to its size: some roundings of f32.
const ROUNDING: f32 = 4.0e-6;

impl Depth {
    /// Returns true if the point is no deeper than `slack` [m] plus some roundings.
    pub(crate) fn is_on_surface(&self, slack: f32) -> bool {
        self.depth <= self.rounding + slack
    }

    /// Returns true if `delta` leads from the surface into the solid, by more than some roundings
    /// of its direction.
    pub(crate) fn is_entered_along(&self, delta: Vec3) -> bool {
        self.normal.dot(delta) < -ALONG * delta.length()
    }
}

/// Depth of a point inside a solid; `None` outside. No point is inside a mesh.
pub(crate) fn depth(solid: &Solid, p: Vec3) -> Option<Depth> {
    if !is_inside(solid, p) {
        return None;
    }
    let rounding = ROUNDING * (solid.max_extent(Vec3::ZERO) + p.abs().max_element());
    let near = nearest(solid, p, rounding)?;
    Some(Depth { normal: near.normal, depth: -near.distance, rounding })
}

/// Returns whether a point is inside a solid and not on its surface. [`ray`] returns no hit for
/// such a start.
fn is_inside(solid: &Solid, p: Vec3) -> bool {
    let p = DVec3::from(p);
    let within = |radius: f64, away: DVec3| away.dot(away) < radius * radius;
    let radius = f64::from(solid.radius);
    match &solid.core {
        Core::Point => within(radius, p),
        Core::Segment { half_height } => {
            let h = f64::from(*half_height);
            within(radius, DVec3 { y: p.y - p.y.clamp(-h, h), ..p })
        }
        Core::Hull(hull) => {
            hull.planes().iter().all(|q| DVec3::from(q.normal).dot(p) < f64::from(q.offset))
        }
        Core::Frustum { half_height, radius_bottom, radius_top } => {
            let h = f64::from(*half_height);
            let (bottom, top) = (f64::from(*radius_bottom), f64::from(*radius_top));
            let wide = (bottom + top) * 0.5 + (top - bottom) / (2.0 * h) * p.y;
            p.y.abs() < h && within(wide, DVec3 { y: 0.0, ..p })
        }
        Core::HalfSpace { normal, offset } => DVec3::from(*normal).dot(p) < f64::from(*offset),
        Core::Mesh(_) => false,
    }
}

/// Returns the point where a ray that starts inside a solid leaves it, up to `max_fraction`. The
/// normal is outward: the ray moves along it.
pub(crate) fn exit(solid: &Solid, origin: Vec3, delta: Vec3, max_fraction: f32) -> Option<RayHit> {
    let line = Line { o: DVec3::from(origin), d: DVec3::from(delta) };
    let radius = f64::from(solid.radius);
    let (t, normal) = match &solid.core {
        Core::Point => leave_ball(line, radius),
        Core::Segment { half_height } => leave_capsule(line, f64::from(*half_height), radius),
        Core::Hull(hull) => leave_polytope(hull, line),
        Core::Frustum { half_height, radius_bottom, radius_top } => {
            let (bottom, top) = (f64::from(*radius_bottom), f64::from(*radius_top));
            leave_frustum(line, f64::from(*half_height), bottom, top)
        }
        Core::HalfSpace { normal, offset } => {
            leave_plane(line, DVec3::from(*normal), f64::from(*offset))
        }
        Core::Mesh(_) => None,
    }?;
    let fraction = single(t);
    (fraction <= max_fraction).then(|| RayHit { fraction, normal: normal.single() })
}

#[expect(clippy::cast_possible_truncation, reason = "rounding is what is asked for")]
fn single(x: f64) -> f32 {
    x as f32
}

/// The line of points o + t d.
#[derive(Clone, Copy)]
struct Line {
    o: DVec3,
    d: DVec3,
}

impl Line {
    fn at(self, t: f64) -> DVec3 {
        self.o + self.d * t
    }
}

/// A fraction, at least 0, and the unit normal there.
type Hit = Option<(f64, DVec3)>;

fn unit(v: DVec3) -> DVec3 {
    let length = v.length();
    if length > 0.0 { v * (1.0 / length) } else { DVec3::ZERO }
}

fn nearer(a: Hit, b: Hit) -> Hit {
    match (a, b) {
        (Some(x), Some(y)) => Some(if y.0 < x.0 { y } else { x }),
        (x, y) => x.or(y),
    }
}

/// Root of a t² + 2 b t + c where the value falls from above 0 to below.
fn falling_root(a: f64, b: f64, c: f64) -> Option<f64> {
    let discriminant = b * b - a * c;
    if discriminant <= 0.0 || discriminant.is_nan() {
        return None;
    }
    let s = discriminant.sqrt();
    // Both equal (-b - s) / a; neither subtracts numbers of equal sign, and the first allows a = 0.
    let root = if b < 0.0 { c / (s - b) } else { (-b - s) / a };
    root.is_finite().then_some(root)
}

/// Root of a t² + 2 b t + c, at least 0, where the value rises from below 0 (at t = 0) to above.
fn rising_root(a: f64, b: f64, c: f64) -> Option<f64> {
    let discriminant = b * b - a * c;
    if discriminant < 0.0 || discriminant.is_nan() {
        return None;
    }
    let s = discriminant.sqrt();
    // Both equal (s - b) / a; neither subtracts numbers of equal sign, and the first allows a = 0.
    let root = if b > 0.0 { -c / (b + s) } else { (s - b) / a };
    (root.is_finite() && root >= 0.0).then_some(root)
}

fn farther(a: Hit, b: Hit) -> Hit {
    match (a, b) {
        (Some(x), Some(y)) => Some(if y.0 > x.0 { y } else { x }),
        (x, y) => x.or(y),
    }
}

fn leave_ball(line: Line, radius: f64) -> Hit {
    let dd = line.d.dot(line.d);
    if dd <= 0.0 || dd.is_nan() {
        return None;
    }
    let shift = -line.o.dot(line.d) / dd;
    let nearest = line.at(shift);
    let rest = radius * radius - nearest.dot(nearest);
    let t = shift + (greater(rest, 0.0) / dd).sqrt();
    (rest >= 0.0 && t >= 0.0).then(|| (t, unit(line.at(t))))
}

/// A capsule is convex: the ray leaves it where it leaves the last of its parts.
fn leave_capsule(line: Line, half_height: f64, radius: f64) -> Hit {
    let (o, d) = (line.o, line.d);
    let end = DVec3 { x: 0.0, y: half_height, z: 0.0 };
    let ends = farther(
        leave_ball(Line { o: o - end, d }, radius),
        leave_ball(Line { o: o + end, d }, radius),
    );
    let (a, b) = (d.x * d.x + d.z * d.z, o.x * d.x + o.z * d.z);
    let c = o.x * o.x + o.z * o.z - radius * radius;
    let side = rising_root(a, b, c).and_then(|t| {
        let p = line.at(t);
        (p.y.abs() <= half_height).then(|| (t, unit(DVec3 { y: 0.0, ..p })))
    });
    farther(ends, side)
}

fn leave_plane(line: Line, normal: DVec3, offset: f64) -> Hit {
    let rate = normal.dot(line.d);
    let depth = offset - normal.dot(line.o);
    (rate > 0.0).then(|| (greater(depth, 0.0) / rate, normal))
}

fn leave_polytope(hull: &Hull, line: Line) -> Hit {
    let planes = hull.planes().iter();
    planes.map(|p| leave_plane(line, DVec3::from(p.normal), f64::from(p.offset))).fold(None, nearer)
}

/// The ray leaves through the cap or side that it passes first.
fn leave_frustum(line: Line, half_height: f64, bottom: f64, top: f64) -> Hit {
    let (o, d) = (line.o, line.d);
    let up = DVec3 { x: 0.0, y: 1.0, z: 0.0 };
    let caps =
        nearer(leave_plane(line, up, half_height), leave_plane(line, up * -1.0, half_height));
    let (k, m) = ((bottom + top) * 0.5, (top - bottom) / (2.0 * half_height));
    let side_radius = k + m * o.y;
    let (a, b, c) = (
        d.x * d.x + d.z * d.z - m * m * d.y * d.y,
        o.x * d.x + o.z * d.z - m * d.y * side_radius,
        o.x * o.x + o.z * o.z - side_radius * side_radius,
    );
    let side = rising_root(a, b, c).map(|t| {
        let radial = unit(DVec3 { y: 0.0, ..line.at(t) });
        (t, unit(DVec3 { y: -m, ..radial }))
    });
    nearer(caps, side)
}

fn ball(line: Line, radius: f64) -> Hit {
    // Relative to the point of the line nearest the center, where the coefficients are smallest.
    let dd = line.d.dot(line.d);
    let inside = line.o.dot(line.o) < radius * radius;
    if dd <= 0.0 || dd.is_nan() || inside {
        return None;
    }
    let shift = -line.o.dot(line.d) / dd;
    let nearest = line.at(shift);
    let rest = radius * radius - nearest.dot(nearest);
    if rest < 0.0 {
        return None;
    }
    let t = shift - (rest / dd).sqrt();
    (t >= 0.0).then(|| (t, unit(line.at(t))))
}

fn capsule(line: Line, half_height: f64, radius: f64) -> Hit {
    let (o, d) = (line.o, line.d);
    let end = DVec3 { x: 0.0, y: half_height, z: 0.0 };
    let on_axis = DVec3 { x: 0.0, y: o.y.clamp(-half_height, half_height), z: 0.0 };
    let away = o - on_axis;
    if away.dot(away) < radius * radius {
        return None;
    }
    let ends = nearer(ball(Line { o: o - end, d }, radius), ball(Line { o: o + end, d }, radius));
    let a = d.x * d.x + d.z * d.z;
    let b = o.x * d.x + o.z * d.z;
    let c = o.x * o.x + o.z * o.z - radius * radius;
    let side = falling_root(a, b, c).filter(|t| *t >= 0.0).and_then(|t| {
        let p = line.at(t);
        (p.y.abs() <= half_height).then(|| (t, unit(DVec3 { y: 0.0, ..p })))
    });
    nearer(ends, side)
}

/// Clips the ray by every plane.
fn polytope(hull: &Hull, line: Line) -> Hit {
    let mut enter: Hit = None;
    let mut leave = f64::INFINITY;
    for plane in hull.planes() {
        let normal = DVec3::from(plane.normal);
        let height = normal.dot(line.o) - f64::from(plane.offset);
        let rate = normal.dot(line.d);
        if rate < 0.0 {
            let t = height / -rate;
            if t >= 0.0 && enter.is_none_or(|(e, _)| t > e) {
                enter = Some((t, normal));
            }
        } else if rate > 0.0 {
            leave = lesser(height / -rate, leave);
        } else if height > 0.0 || rate.is_nan() {
            return None;
        }
    }
    enter.filter(|(t, _)| *t <= leave)
}

/// Intersects the slab |y| <= half height with the side x² + z² <= (k + m y)².
fn frustum(line: Line, half_height: f64, bottom: f64, top: f64) -> Hit {
    let (o, d) = (line.o, line.d);
    let (k, m) = ((bottom + top) * 0.5, (top - bottom) / (2.0 * half_height));
    let side_radius = k + m * o.y;
    let (a, b, c) = (
        d.x * d.x + d.z * d.z - m * m * d.y * d.y,
        o.x * d.x + o.z * d.z - m * d.y * side_radius,
        o.x * o.x + o.z * o.z - side_radius * side_radius,
    );
    // A ray can hit a cap only from its outer side.
    let cap = if o.y >= half_height && d.y < 0.0 {
        Some(((half_height - o.y) / d.y, top, 1.0))
    } else if o.y <= -half_height && d.y > 0.0 {
        Some(((-half_height - o.y) / d.y, bottom, -1.0))
    } else {
        None
    };
    if let Some((t, radius, sign)) = cap {
        let p = line.at(t);
        if p.x * p.x + p.z * p.z <= radius * radius {
            return Some((t, DVec3 { x: 0.0, y: sign, z: 0.0 }));
        }
    }
    // A falling root of the side's quadratic leads into the cone, or out of its mirror image beyond
    // the tip, which the slab cuts off.
    let t = falling_root(a, b, c).filter(|t| *t >= 0.0)?;
    let p = line.at(t);
    if p.y.abs() > half_height {
        return None;
    }
    let radial = unit(DVec3 { y: 0.0, ..p });
    Some((t, unit(DVec3 { y: -m, ..radial })))
}

fn half_space(line: Line, normal: Vec3, offset: f64) -> Hit {
    let normal = DVec3::from(normal);
    let height = normal.dot(line.o) - offset;
    let rate = normal.dot(line.d);
    (height >= 0.0 && rate < 0.0).then(|| (height / -rate, normal))
}

fn nearest_triangle(mesh: &Mesh, origin: Vec3, delta: Vec3, max_fraction: f32) -> Option<RayHit> {
    let line = Line { o: DVec3::from(origin), d: DVec3::from(delta) };
    let mut max = max_fraction;
    let mut best = None;
    let ray = Ray::new(origin, delta);
    mesh.tree().ray(&ray, max_fraction, |item| {
        let pack = mesh.pack(item);
        let near = pack.boxes().entries(&ray, max);
        for (lane, &number) in pack.numbers().iter().enumerate() {
            if near[lane].is_infinite() {
                continue;
            }
            if let Some((t, normal)) = triangle(line, pack.triangle(lane)) {
                let fraction = single(t);
                // At equal distances (a shared edge) the lower number wins, whatever order the tree
                // visits triangles in.
                let first =
                    best.is_none_or(|(f, i, _)| fraction < f || (fraction <= f && number < i));
                if fraction <= max && first {
                    max = fraction;
                    best = Some((fraction, number, normal));
                }
            }
        }
        max
    });
    best.map(|(fraction, _, normal)| RayHit { fraction, normal: normal.single() })
}

/// Hits a triangle from either side. The line passes it if it passes all edges on the same side, by
/// the triple products of its direction with the ends of each edge. A neighbor computes the same
/// product with the other sign, so no ray slips through between two triangles.
fn triangle(line: Line, corners: [Vec3; 3]) -> Hit {
    let [a, b, c] = corners.map(|p| DVec3::from(p) - line.o);
    let u = line.d.dot(b.cross(c));
    let v = line.d.dot(c.cross(a));
    let w = line.d.dot(a.cross(b));
    let one_side = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
    let normal = unit((b - a).cross(c - a));
    let rate = normal.dot(line.d);
    if !one_side || rate.abs() <= 0.0 {
        return None;
    }
    let t = normal.dot(a) / rate;
    let facing = if rate > 0.0 { -normal } else { normal };
    (t >= 0.0).then_some((t, facing))
}

#[cfg(test)]
mod tests {
    use super::{RayHit, ray};
    use crate::base::math::{Vec3, vec3};
    use crate::geometry::hull::Hull;
    use crate::geometry::mesh::Mesh;
    use crate::geometry::oracle::{Numbers, grid, parry};
    use crate::geometry::shape::Shape;
    use crate::geometry::solid::Solid;
    use parry3d::query::{Ray, RayCast};
    use parry3d::shape;
    use std::sync::Arc;

    /// Compares random rays, about half of which hit; rays that start inside must not hit.
    fn compare(shape: &Shape, reference: &impl RayCast, inside: impl Fn(Vec3) -> bool) {
        let solid = Solid::of(shape);
        let mut numbers = Numbers(99);
        let (mut hits, mut differ) = (0, 0);
        for _ in 0..20_000 {
            let origin = numbers.point() * 4.0;
            let delta = numbers.point() - origin * 0.8;
            if inside(origin) {
                assert!(ray(&solid, origin, delta, 1.0).is_none(), "{origin:?} is inside");
                continue;
            }
            let ours = ray(&solid, origin, delta, 1.0);
            let toward = Ray::new(parry(origin), parry(delta));
            let theirs = reference.cast_local_ray_and_get_normal(&toward, 1.0, true);
            match (ours, theirs) {
                (Some(a), Some(b)) => {
                    hits += 1;
                    assert!((a.normal.length() - 1.0).abs() < 1e-5);
                    assert!(a.normal.dot(delta) <= 0.0);
                    let near = (a.fraction - b.time_of_impact).abs() < 1e-3;
                    let along = a.normal.dot(Vec3::from(b.normal.to_array())) > 0.99;
                    // A ray through an edge may report the other face there.
                    differ += u32::from(!near || !along);
                }
                (None, None) => {}
                // Grazing rays: the reference finds roots in f32 or by iteration.
                _ => differ += 1,
            }
        }
        assert!(hits > 3000, "{} was hit {hits} times", shape.kind());
        assert!(differ * 200 < hits, "{}: {differ} of {hits} differ", shape.kind());
    }

    #[test]
    fn rays_meet_convex_shapes_where_parry_says() {
        compare(&Shape::sphere(1.2), &shape::Ball::new(1.2), |p| p.length() < 1.2);
        compare(&Shape::capsule(0.8, 0.6), &shape::Capsule::new_y(0.8, 0.6), |p| {
            (p - vec3(0.0, p.y.clamp(-0.8, 0.8), 0.0)).length() < 0.6
        });
        let half = vec3(0.7, 1.1, 1.5);
        compare(&Shape::box_half(half), &shape::Cuboid::new(parry(half)), |p| {
            (p.abs() - half).max_element() < 0.0
        });
        compare(&Shape::cylinder(0.9, 1.1), &shape::Cylinder::new(0.9, 1.1), |p| {
            p.y.abs() < 0.9 && p.x * p.x + p.z * p.z < 1.1 * 1.1
        });
        compare(&Shape::cone(1.2, 1.3), &shape::Cone::new(1.2, 1.3), |p| {
            let r = 1.3 * (1.2 - p.y) / 2.4;
            p.y.abs() < 1.2 && p.x * p.x + p.z * p.z < r * r
        });
        let mut numbers = Numbers(5);
        let points: Vec<Vec3> = (0..40).map(|_| numbers.point() * 1.5).collect();
        let hull = Hull::from_points(&points).unwrap();
        let reference = shape::ConvexPolyhedron::from_convex_hull(
            &points.iter().map(|p| parry(*p)).collect::<Vec<_>>(),
        );
        let planes = hull.planes().to_vec();
        compare(&Shape::Hull(Arc::new(hull)), &reference.unwrap(), |p| {
            planes.iter().all(|q| q.distance(p) < 0.0)
        });
    }

    #[test]
    fn rays_meet_a_mesh_where_parry_says_from_both_sides() {
        let (vertices, triangles) = grid();
        let theirs = vertices.iter().map(|v| parry(*v)).collect();
        let reference = shape::TriMesh::new(theirs, triangles.clone()).unwrap();
        let mesh = Mesh::new(vertices, triangles).unwrap();
        compare(&Shape::Mesh(Arc::new(mesh)), &reference, |_| false);
    }

    #[test]
    fn no_ray_slips_through_the_edges_and_vertices_of_a_mesh() {
        let (vertices, triangles) = grid();
        let mesh = Mesh::new(vertices.clone(), triangles).unwrap();
        let solid = Solid::of(&Shape::Mesh(Arc::new(mesh)));
        let mut numbers = Numbers(3);
        for _ in 0..20 {
            let origin = numbers.point() + vec3(0.0, 5.0, 0.0);
            for i in 1..20 {
                for k in 1..20 {
                    let (a, b) = (vertices[i * 21 + k], vertices[i * 21 + k + 1]);
                    for target in [a, a.lerp(b, 0.5), a.lerp(b, 0.3)] {
                        let hit = ray(&solid, origin, (target - origin) * 1.5, 1.0);
                        assert!(hit.is_some(), "{origin:?} to {target:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_ray_enters_a_truncated_cone_where_sampling_says() {
        let (half_height, bottom, top) = (1.0, 0.4, 1.4);
        let shape = Shape::Cone { half_height, radius_bottom: bottom, radius_top: top };
        let solid = Solid::of(&shape);
        let depth = |p: Vec3| {
            let r = bottom + (top - bottom) * (p.y + half_height) * 0.5;
            (p.y.abs() - half_height).max(vec3(p.x, 0.0, p.z).length() - r)
        };
        let mut numbers = Numbers(17);
        let mut hits = 0;
        for _ in 0..5000 {
            let (origin, target) = (numbers.point() * 4.0, numbers.point() * 1.2);
            let delta = (target - origin) * 2.0;
            let hit = ray(&solid, origin, delta, 1.0);
            if depth(origin) < 0.0 {
                assert!(hit.is_none());
                continue;
            }
            let end = hit.map_or(1.0, |h| h.fraction);
            for s in 0..200_u8 {
                let t = end * f32::from(s) / 200.0;
                assert!(depth(origin + delta * t) > -1e-4, "{origin:?} {delta:?} {t}");
            }
            if let Some(RayHit { fraction, normal }) = hit {
                hits += 1;
                let at = origin + delta * fraction;
                assert!(depth(at).abs() < 1e-4);
                // The normal is outward: a small step along it leaves, one against it enters.
                assert!(depth(at + normal * 1e-2) > 5e-3 && depth(at - normal * 1e-3) < 1e-4);
            }
        }
        assert!(hits > 2000);
    }

    #[test]
    fn the_fraction_is_limited_and_a_half_space_is_met_from_above_only() {
        let ground = Solid::of(&Shape::half_space(vec3(0.0, 1.0, 0.0), 1.0));
        let (above, below) = (vec3(3.0, 5.0, 0.0), vec3(0.0, -5.0, 0.0));
        let hit = ray(&ground, above, vec3(0.0, -8.0, 1.0), 1.0).unwrap();
        assert_eq!(hit, RayHit { fraction: 0.5, normal: Vec3::Y });
        assert!(ray(&ground, above, vec3(0.0, -8.0, 1.0), 0.4).is_none());
        assert!(ray(&ground, below, vec3(0.0, 20.0, 0.0), 1.0).is_none());
        let ball = Solid::of(&Shape::sphere(1.0));
        let hit = ray(&ball, vec3(-1.0e4, 0.6, 0.0), vec3(2.0e4, 0.0, 0.0), 1.0).unwrap();
        assert!((hit.normal - vec3(-0.8, 0.6, 0.0)).length() < 1e-5);
        for strange in [Vec3::ZERO, Vec3::splat(f32::NAN)] {
            assert!(ray(&ball, above, strange, 1.0).is_none());
            assert!(ray(&ground, above, strange, 1.0).is_none());
        }
    }
}
