//! A polytope against one triangle: separating axes, without the axes that a closed surface would
//! not allow.

use fearless_simd::{Simd, SimdBase};

use super::clip::Clipper;
use super::contacts::{self, Contacts, direction_class, mix};
use super::placed::{EdgeAxis, PlacedHull, Separated};
use super::round::point;
use super::triangle::{Part, Triangle, closest_on_segments};
use crate::base::math::{Vec3, lesser};
use crate::base::simd::wide::{LANES, above, bits, reduce_max, splat};
use crate::geometry::convex::clip::STEEP;
use crate::geometry::hull::Plane;
use crate::geometry::manifold::ManifoldPoint;

/// The axis of largest separation.
#[derive(Clone, Copy, Debug)]
enum Axis {
    Face(usize),
    /// Edge of the triangle, and first half-edge of the polytope's edge.
    Edges(usize, usize),
}

#[derive(Clone, Copy, Debug)]
struct Best {
    axis: Axis,
    normal: Vec3,
    part: Part,
    separation: f32,
}

/// Adds the contact of `hull` with `triangle`. If an axis shows that they are too far apart for
/// one, returns a lower bound on their distance [m].
#[inline(always)]
pub(super) fn hull<S: Simd>(
    simd: S,
    triangle: &Triangle,
    hull: &mut PlacedHull<'_>,
    contacts: &mut Contacts,
    clipper: &mut Clipper,
) -> Option<f32> {
    let limits = contacts.limits;
    let reach = limits.margin + hull.radius;
    let over = hull.min_along(simd, triangle.normal, triangle.corners[0]);
    if over > reach {
        return Some(over - hull.radius);
    }
    let mut best: Option<Best> = None;
    let mut refused: Option<Best> = None;
    let minimum = over + limits.bias;
    for group in 0..hull.face_groups() {
        let heights = hull.heights(simd, group, triangle);
        if bits(above(heights, splat(simd, reach))) != 0 {
            return Some(reduce_max(heights) - hull.radius);
        }
        let mut higher = bits(above(heights, splat(simd, minimum))) & hull.faces_in(group);
        if higher == 0 {
            continue;
        }
        let mut separations = [0.0; LANES];
        heights.store_array(&mut separations);
        while higher != 0 {
            let lane = higher.trailing_zeros() as usize;
            higher &= higher - 1;
            let (face, separation) = (group * LANES + lane, separations[lane]);
            try_face(triangle, hull, (face, separation), [&mut best, &mut refused]);
        }
    }
    for k in 0..3 {
        if triangle.is_concave(k) {
            let normal = triangle.outward[k];
            let separation = hull.min_along(simd, normal, triangle.corners[k]);
            if separation > refused.map_or(minimum, |b| b.separation) {
                let (axis, part) = (Axis::Edges(k, 0), Part::Edge(k));
                refused = Some(Best { axis, normal, part, separation });
            }
        }
        if !triangle.is_active(k) {
            continue;
        }
        let minimum = if let Some(b) = &best { b.separation + limits.bias } else { minimum };
        if hull.is_within(simd, triangle, k, minimum) {
            continue;
        }
        match hull.best_edge(simd, (triangle, k), minimum, reach) {
            Err(Separated(by)) => return Some(by - hull.radius),
            Ok(Some(EdgeAxis { edge, normal, separation })) => {
                let (axis, part) = (Axis::Edges(k, edge), Part::Edge(k));
                best = Some(Best { axis, normal, part, separation });
            }
            Ok(None) => {}
        }
    }
    if let Some(r) = refused
        && best.is_none_or(|b| r.separation > b.separation)
        && triangle.is_behind_neighbor(r.part, r.normal, hull.center)
    {
        return None;
    }
    let face_axis = contacts::Axis { normal: triangle.normal, separation: over - hull.radius };
    if limits.corners {
        hull.find_vertices_over(simd, triangle, 0.0);
        contacts.add_vertices(triangle, hull.vertices_over(), (over - hull.radius, hull.radius));
    }
    let refused = match best {
        Some(Best { axis: Axis::Face(face), .. }) => {
            on_hull_face(triangle, hull, face, contacts, clipper);
            return None;
        }
        Some(found @ Best { axis: Axis::Edges(k, edge), .. }) => {
            if on_edges(triangle, (k, edge), hull, &found, contacts) {
                return None;
            }
            None
        }
        None => refused.map(|r| r.normal),
    };
    let lowest = hull.face_against(simd, triangle.normal);
    if !hull.is_cuboid() {
        hull.find_vertices_over(simd, triangle, f32::NEG_INFINITY);
    }
    on_triangle(triangle, (hull, lowest), (face_axis, refused), contacts, clipper);
    None
}

/// Keeps the axis of a face of the polytope, if it is better than the ones found before.
#[inline(always)]
fn try_face(
    triangle: &Triangle,
    hull: &PlacedHull<'_>,
    (face, separation): (usize, f32),
    [best, refused]: [&mut Option<Best>; 2],
) {
    let normal = -hull.plane(face).normal;
    let part = triangle.support(normal);
    let found = Best { axis: Axis::Face(face), normal, part, separation };
    let slot = if triangle.allows(part, normal) { best } else { refused };
    if slot.is_none_or(|b| separation > b.separation) {
        *slot = Some(found);
    }
}

/// Contact along the triangle's normal: the polytope's lowest face, clipped to the part over the
/// triangle.
#[inline(always)]
fn on_triangle(
    triangle: &Triangle,
    (hull, lowest): (&PlacedHull<'_>, usize),
    (axis, refused): (contacts::Axis, Option<Vec3>),
    contacts: &mut Contacts,
    clipper: &mut Clipper,
) {
    let normal = triangle.normal;
    let class = direction_class(normal);
    clipper.restart();
    hull.around(lowest, |e| {
        clipper.push(hull.origin(e), mix(5, u32::from(e.origin), class));
    });
    clipper.cut_by_prism(triangle, contacts.limits.slack);
    let points = clipper.points.iter().map(|c| {
        let separation = triangle.height(c.position) - hull.radius;
        point(c.position, normal, separation, hull.radius, c.feature)
    });
    let is_of_face = |number: u32| {
        let mut found = false;
        hull.around(lowest, |e| found |= u32::from(e.origin) == number);
        found
    };
    let low = low_vertices(hull).filter_map(|(number, position, separation)| {
        let feature = mix(5, number, class);
        (!is_of_face(number)).then(|| point(position, normal, separation, hull.radius, feature))
    });
    let points = points.chain(low);
    contacts.add_instead(triangle, axis, refused, points);
}

/// Returns the low vertices over a triangle: [`STEEP`] times their height above the lowest one is
/// at most their distance from it. The lowest vertex need not be one of the lowest face, and a body
/// that turns next lands on its low neighbors. A box has no such vertices beyond that face's.
fn low_vertices(hull: &PlacedHull<'_>) -> impl Iterator<Item = (u32, Vec3, f32)> {
    let over = || if hull.is_cuboid() { None } else { Some(hull.vertices_over()) };
    let mut lowest = (f32::INFINITY, Vec3::ZERO);
    for (_, position, height) in over().into_iter().flatten() {
        if height < lowest.0 {
            lowest = (height, position);
        }
    }
    over().into_iter().flatten().filter(move |(_, position, height)| {
        STEEP * (height - lowest.0) <= (*position - lowest.1).length()
    })
}

/// Contact along the normal of a face of the polytope, which an edge or a corner of the triangle
/// touches.
#[inline(always)]
fn on_hull_face(
    triangle: &Triangle,
    hull: &PlacedHull<'_>,
    face: usize,
    contacts: &mut Contacts,
    clipper: &mut Clipper,
) {
    let plane = hull.plane(face);
    clipper.restart();
    push_corners(triangle, clipper);
    let mut side = 0;
    hull.around(face, |e| {
        let (a, b) = (hull.origin(e), hull.origin(hull.next(e)));
        if let Some(outward) = (b - a).cross(plane.normal).try_normalize() {
            clipper.cut(outward, a, contacts.limits.slack, side);
        }
        side += 1;
    });
    add_clipped_triangle(triangle, &plane, hull.radius, contacts, clipper);
}

/// Starts with the triangle as polygon.
#[inline(always)]
pub(super) fn push_corners(triangle: &Triangle, clipper: &mut Clipper) {
    for (corner, vertex) in triangle.corners.iter().zip(triangle.vertices) {
        clipper.push(*corner, mix(6, vertex, 0));
    }
}

/// Adds the clipped triangle as contact with the flat face on `plane`.
#[inline(always)]
pub(super) fn add_clipped_triangle(
    triangle: &Triangle,
    plane: &Plane,
    radius: f32,
    contacts: &mut Contacts,
    clipper: &Clipper,
) {
    let points = clipper.points.iter().map(|c| {
        let separation = plane.distance(c.position) - radius;
        let position = c.position - plane.normal * (0.5 * separation);
        ManifoldPoint { position, separation, feature: c.feature }
    });
    let separation =
        triangle.corners.iter().map(|c| plane.distance(*c)).fold(f32::INFINITY, lesser) - radius;
    contacts.add(triangle, contacts::Axis { normal: -plane.normal, separation }, points);
}

/// Contact of two edges; returns false if the axis separates them but no points near each other lie
/// along it.
#[inline(always)]
fn on_edges(
    triangle: &Triangle,
    (k, edge): (usize, usize),
    hull: &PlacedHull<'_>,
    &Best { normal, separation, .. }: &Best,
    contacts: &mut Contacts,
) -> bool {
    let (ends, side) = (hull.ends(edge), triangle.edge(k));
    let (s, t) = closest_on_segments(ends, side);
    let (p, q) = (ends[0].lerp(ends[1], s), side[0].lerp(side[1], t));
    let slack = contacts.limits.slack + contacts.limits.merge;
    if (p - q - normal * separation).length() > slack {
        return false;
    }
    let [a, b] = [k, (k + 1) % 3].map(|i| triangle.vertices[i]);
    let number = u32::try_from(edge).unwrap_or(0);
    let feature = mix(number.wrapping_add(7), a.min(b), a.max(b));
    let found = point(p, normal, separation - hull.radius, hull.radius, feature);
    let separation = separation - hull.radius;
    contacts.add(triangle, contacts::Axis { normal, separation }, [found]);
    true
}
