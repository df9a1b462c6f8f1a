//! Spheres and capsules against one triangle, in closed form.

use super::clip::Clipper;
use super::contacts::{Axis, Contacts, direction_class, mix};
use super::triangle::{Part, Triangle, closest_on_segments};
use crate::base::math::{Vec3, lesser};
use crate::geometry::manifold::ManifoldPoint;

/// Cosine of 0.8°: a normal this close to the face's counts as the face's.
const UPRIGHT: f32 = 0.9999;
/// Limit for the rotation of a normal during the step: it is ignored if it changes the motion along
/// the normal by no more than this fraction of the radius. Over the gap the normal turns by gap ·
/// along / (closing · radius); `closing` is the motion along the normal, `along` the motion
/// across.
const TURN: f32 = 1.0e-3;
/// Maximum number of advances to an edge, and the remaining gap relative to the radius. The error
/// of the normal is the root of this gap.
const MAX_STEPS: usize = 16;
const MET: f32 = 1.0e-5;
/// Bisections of the motion to the nearest point of a solid that passes by.
const HALVINGS: usize = 6;
/// Sine of the angle below which a segment and an edge touch in two points.
const PARALLEL: f32 = 0.1;

/// The midpoint between the surfaces, from a point of the core.
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

/// Displacement of a round solid before it hits the edge or corner that is `nearest` to its point
/// `core`, or before it is nearest to it within the step [m]. Zero if the normal hardly turns
/// during the motion.
///
/// The normal of an edge ahead points back along the motion, and would stop a solid that goes over
/// the edge. `closest` returns the nearest points after a displacement. Each advance is as long as
/// the plane between the two allows `[Mirtich96]`.
fn way_to_edge(
    start: (Vec3, Vec3),
    (radius, displacement): (f32, Vec3),
    closest: impl Fn(Vec3) -> (Vec3, Vec3),
) -> Vec3 {
    let seen = |(core, nearest): (Vec3, Vec3)| {
        let apart = core - nearest;
        let distance = apart.length();
        (apart, distance - radius, -apart.dot(displacement) / distance)
    };
    let (apart, gap, closing) = seen(start);
    // A row acts a substep ahead of the touch, and in the last sweep up to a step ahead of it.
    if !(gap > 0.0 && 2.0 * closing > gap) {
        return Vec3::ZERO;
    }
    let along = (displacement + apart * (closing / apart.length())).length();
    if gap * along < TURN * radius * radius {
        return Vec3::ZERO;
    }
    let mut before = 0.0;
    let mut fraction = lesser(gap / closing, 1.0);
    for _ in 0..MAX_STEPS {
        let (_, gap, closing) = seen(closest(displacement * fraction));
        if !(closing > 0.0) {
            // The solid passes by. Where it is nearest, the plane between the two is parallel to
            // the motion.
            for _ in 0..HALVINGS {
                let middle = 0.5 * (before + fraction);
                let (_, _, closing) = seen(closest(displacement * middle));
                if closing > 0.0 { before = middle } else { fraction = middle }
            }
            return displacement * before;
        }
        if gap <= MET * radius || fraction >= 1.0 {
            break;
        }
        before = fraction;
        fraction = lesser(fraction + gap / closing, 1.0);
    }
    displacement * fraction
}

/// Adds the contact of a sphere; if it is too far away for one, returns a lower bound on the
/// distance [m].
pub(super) fn sphere(
    triangle: &Triangle,
    center: Vec3,
    radius: f32,
    contacts: &mut Contacts,
) -> Option<f32> {
    let (mut nearest, mut part) = triangle.closest(center);
    let distance = (center - nearest).length();
    if distance - radius > contacts.limits.margin {
        return Some(distance - radius);
    }
    let feature = |normal| mix(1, direction_class(normal), 0);
    let mut shift = Vec3::ZERO;
    if part != Part::Face {
        let displacement = (radius, contacts.limits.straight);
        let closest = |shift: Vec3| (center + shift, triangle.closest(center + shift).0);
        shift = way_to_edge((center, nearest), displacement, closest);
        (nearest, part) = triangle.closest(center + shift);
    }
    let offset = center + shift - nearest;
    if part != Part::Face
        && let Some(normal) = offset.try_normalize()
    {
        let separation = offset.length() - radius;
        let p = point(center + shift, normal, separation, radius, feature(normal));
        if triangle.allows(part, normal) {
            contacts.add_ahead(triangle, Axis { normal, separation }, shift, [p]);
            return None;
        }
        if triangle.outside(center) > contacts.limits.slack {
            // A contact ahead is no overlap.
            if shift == Vec3::ZERO {
                contacts.add_spare(normal, p);
            }
            return None;
        }
    }
    let normal = triangle.normal;
    let separation = triangle.height(center) - radius;
    let p = point(center, normal, separation, radius, feature(normal));
    contacts.add(triangle, Axis { normal, separation }, [p]);
    None
}

/// Adds the contact of a capsule with its core from `ends[0]` to `ends[1]`. If it is too far away
/// for one, returns a lower bound on the distance [m].
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
        let (mut core, mut nearest, mut part) = closest_to_segment(triangle, ends);
        let apart = (core - nearest).length() - radius;
        if apart > limits.margin {
            return Some(apart);
        }
        let mut shift = Vec3::ZERO;
        if part != Part::Face {
            let at = |shift: Vec3| closest_to_segment(triangle, ends.map(|end| end + shift));
            let closest = |shift: Vec3| (at(shift).0, at(shift).1);
            shift = way_to_edge((core, nearest), (radius, limits.straight), closest);
            (core, nearest, part) = at(shift);
        }
        let offset = core - nearest;
        let separation = offset.length() - radius;
        if part != Part::Face
            && let Some(normal) = offset.try_normalize()
            && normal.dot(triangle.normal) < UPRIGHT
        {
            if triangle.allows(part, normal) {
                let axis = Axis { normal, separation };
                if limits.corners {
                    contacts.add_corners(triangle, &ends, (lowest, radius));
                }
                let (ends, moved) = (ends.map(|end| end + shift), (separation, radius));
                along_edge(triangle, part, axis, (ends, core), (moved, shift), contacts);
                return None;
            }
            let center = ends[0].lerp(ends[1], 0.5);
            if triangle.is_behind_neighbor(part, normal, center) {
                return None;
            }
            refused = Some(normal);
            let class = direction_class(normal);
            if shift == Vec3::ZERO {
                let p = point(core, normal, separation, radius, mix(2, class, 0));
                contacts.add_spare(normal, p);
            }
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

/// Returns the nearest points of segment and triangle, which do not cross, and the part of the
/// triangle.
fn closest_to_segment(triangle: &Triangle, ends: [Vec3; 2]) -> (Vec3, Vec3, Part) {
    let mut best = (ends[0], ends[0], Part::Face);
    let mut minimum = f32::INFINITY;
    for end in ends {
        let (q, part) = triangle.closest(end);
        let d = (end - q).length_squared();
        if d < minimum {
            (best, minimum) = ((end, q, part), d);
        }
    }
    for k in 0..3 {
        let edge = triangle.edge(k);
        let (s, t) = closest_on_segments(ends, edge);
        let (p, q) = (ends[0].lerp(ends[1], s), edge[0].lerp(edge[1], t));
        let d = (p - q).length_squared();
        if d < minimum {
            let part = if t <= 0.0 {
                Part::Corner(k)
            } else if t >= 1.0 {
                Part::Corner((k + 1) % 3)
            } else {
                Part::Edge(k)
            };
            (best, minimum) = ((p, q, part), d);
        }
    }
    best
}

/// Adds the contact of a segment at an edge or corner, after a displacement by `shift`: two points
/// where it runs along an edge.
pub(super) fn along_edge(
    triangle: &Triangle,
    part: Part,
    axis: Axis,
    (ends, core): ([Vec3; 2], Vec3),
    ((separation, radius), shift): ((f32, f32), Vec3),
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
            contacts.add_ahead(triangle, axis, shift, pair);
            return;
        }
    }
    let one = point(core, normal, separation, radius, mix(4, class, 0));
    contacts.add_ahead(triangle, axis, shift, [one]);
}
