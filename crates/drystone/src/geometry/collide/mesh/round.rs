//! Spheres and capsules against one triangle, in closed form.

use super::clip::Clipper;
use super::contacts::{Axis, Contacts, direction_class, mix};
use super::triangle::{Part, Triangle, closest_on_segments};
use crate::base::math::{Vec3, lesser};
use crate::geometry::manifold::ManifoldPoint;

/// A normal this near to the face's (cosine of 0.8°) is the face's.
const UPRIGHT: f32 = 0.9999;
/// Sine of the angle below which a segment and an edge touch in two points.
const PARALLEL: f32 = 0.1;

/// The point half way between the surfaces, from a point of the core.
#[inline]
pub(super) fn point(
    core: Vec3,
    normal: Vec3,
    separation: f32,
    radius: f32,
    feature: u32,
) -> ManifoldPoint {
    let position = core - normal * (radius + 0.5 * separation);
    ManifoldPoint { position, separation, feature }
}

/// Adds the contact of a sphere; if it is too far away for one, says how far it is at least [m].
pub(super) fn sphere(
    triangle: &Triangle,
    center: Vec3,
    radius: f32,
    contacts: &mut Contacts,
) -> Option<f32> {
    let (nearest, part) = triangle.closest(center);
    let offset = center - nearest;
    let distance = offset.length();
    let separation = distance - radius;
    if separation > contacts.limits.margin {
        return Some(separation);
    }
    let feature = |normal| mix(1, direction_class(normal), 0);
    if part != Part::Face
        && let Some(normal) = offset.try_normalize()
    {
        if triangle.allows(part, normal) {
            let p = point(center, normal, separation, radius, feature(normal));
            contacts.add(triangle, Axis { normal, separation }, [p]);
            return None;
        }
        if triangle.outside(center) > contacts.limits.slack {
            contacts.add_spare(normal, point(center, normal, separation, radius, feature(normal)));
            return None;
        }
    }
    let normal = triangle.normal;
    let separation = triangle.height(center) - radius;
    let p = point(center, normal, separation, radius, feature(normal));
    contacts.add(triangle, Axis { normal, separation }, [p]);
    None
}

/// Adds the contact of a capsule with its core from `ends[0]` to `ends[1]`; if it is too far away for one, says how
/// far it is at least [m].
pub(super) fn capsule(
    triangle: &Triangle,
    ends: [Vec3; 2],
    radius: f32,
    contacts: &mut Contacts,
    clipper: &mut Clipper,
) -> Option<f32> {
    let limits = contacts.limits;
    let heights = ends.map(|e| triangle.height(e));
    let lowest = lesser(heights[0], heights[1]) - radius;
    if lowest > limits.margin {
        return Some(lowest);
    }
    let crosses = (heights[0] > 0.0) != (heights[1] > 0.0) && {
        let t = heights[0] / (heights[0] - heights[1]);
        triangle.outside(ends[0].lerp(ends[1], t)) <= 0.0
    };
    let mut refused = None;
    if !crosses {
        let (core, nearest, part) = closest_to_segment(triangle, ends);
        let offset = core - nearest;
        let separation = offset.length() - radius;
        if separation > limits.margin {
            return Some(separation);
        }
        if part != Part::Face
            && let Some(normal) = offset.try_normalize()
            && normal.dot(triangle.normal) < UPRIGHT
        {
            if triangle.allows(part, normal) {
                let axis = Axis { normal, separation };
                if limits.corners {
                    contacts.add_corners(triangle, &ends, (lowest, radius));
                }
                along_edge(triangle, part, axis, (ends, core), (separation, radius), contacts);
                return None;
            }
            let center = ends[0].lerp(ends[1], 0.5);
            if triangle.is_behind_neighbor(part, normal, center) {
                return None;
            }
            refused = Some(normal);
            let class = direction_class(normal);
            contacts.add_spare(normal, point(core, normal, separation, radius, mix(2, class, 0)));
        }
    }
    let normal = triangle.normal;
    let class = direction_class(normal);
    clipper.restart();
    clipper.push(ends[0], mix(2, class, 1));
    clipper.push(ends[1], mix(2, class, 2));
    clipper.cut_by_prism(triangle, limits.slack);
    let over = |p: Vec3| triangle.height(p) - radius;
    let points = clipper
        .points
        .iter()
        .map(|c| point(c.position, normal, over(c.position), radius, c.feature));
    let axis = Axis { normal, separation: lowest };
    contacts.add_instead(triangle, axis, refused, points);
    None
}

/// The nearest points of segment and triangle, which do not cross, and the part of the triangle.
fn closest_to_segment(triangle: &Triangle, ends: [Vec3; 2]) -> (Vec3, Vec3, Part) {
    let mut best = (ends[0], ends[0], Part::Face);
    let mut least = f32::INFINITY;
    for end in ends {
        let (q, part) = triangle.closest(end);
        let d = (end - q).length_squared();
        if d < least {
            (best, least) = ((end, q, part), d);
        }
    }
    for k in 0..3 {
        let edge = triangle.edge(k);
        let (s, t) = closest_on_segments(ends, edge);
        let (p, q) = (ends[0].lerp(ends[1], s), edge[0].lerp(edge[1], t));
        let d = (p - q).length_squared();
        if d < least {
            let part = if t <= 0.0 {
                Part::Corner(k)
            } else if t >= 1.0 {
                Part::Corner((k + 1) % 3)
            } else {
                Part::Edge(k)
            };
            (best, least) = ((p, q, part), d);
        }
    }
    best
}

/// The contact of a segment at an edge or corner: two points where it runs along an edge.
pub(super) fn along_edge(
    triangle: &Triangle,
    part: Part,
    axis: Axis,
    (ends, core): ([Vec3; 2], Vec3),
    (separation, radius): (f32, f32),
    contacts: &mut Contacts,
) {
    let normal = axis.normal;
    let class = direction_class(normal);
    if let Part::Edge(k) = part {
        let [a, b] = triangle.edge(k);
        let (along, edge) = (ends[1] - ends[0], b - a);
        let parallel = along.cross(edge).length_squared()
            < PARALLEL * PARALLEL * along.length_squared() * edge.length_squared();
        let slope = along.dot(edge);
        if parallel && slope.abs() > 0.0 {
            let at = |x: Vec3| ((x - ends[0]).dot(edge) / slope).clamp(0.0, 1.0);
            let pair = [at(a), at(b)].map(|t| {
                let p = ends[0].lerp(ends[1], t);
                let end = if t <= 0.0 {
                    1
                } else if t >= 1.0 {
                    2
                } else {
                    3
                };
                point(p, normal, normal.dot(p - a) - radius, radius, mix(3, class, end))
            });
            contacts.add(triangle, axis, pair);
            return;
        }
    }
    contacts.add(triangle, axis, [point(core, normal, separation, radius, mix(4, class, 0))]);
}
