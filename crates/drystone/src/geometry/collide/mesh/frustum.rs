//! A cylinder, cone or truncated cone against one triangle. Support points of the round surface are
//! exact; its discs become polygons only to place points.

use super::clip::Clipper;
use super::contacts::{self, Contacts, direction_class, mix};
use super::hull::{add_clipped_triangle, push_corners};
use super::near::Discs;
use super::round::{along_edge, point};
use super::triangle::{Part, Triangle, closest_on_segments};
use crate::base::math::{Vec3, lesser, vec3};
use crate::base::pose::Pose;
use crate::geometry::hull::Plane;

/// Cosine and sine of k · 22.5°, k = 0 to 3: a quarter of a disc's polygon.
const QUARTER: [(f32, f32); 4] = [
    (1.0, 0.0),
    (0.923_879_5, 0.382_683_43),
    (0.707_106_77, 0.707_106_77),
    (0.382_683_43, 0.923_879_5),
];

/// Sampled normals over the range of an edge, and interval reductions around the best of them. The
/// result is within 1/8 · (2/3)^10 of the range, 0.2° at most.
const SAMPLES: [f32; 9] = [0.0, 0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0];
const REFINEMENTS: usize = 10;

/// A frustum in the frame of the mesh. Ends and radii: bottom, top.
#[derive(Debug)]
pub(super) struct PlacedFrustum {
    center: Vec3,
    axis: Vec3,
    half_height: f32,
    radii: [f32; 2],
    /// Outward normal of the side: components away from and along the axis.
    side: (f32, f32),
    /// Rounding [m].
    radius: f32,
}

#[derive(Clone, Copy, Debug)]
enum Axis {
    Cap(usize),
    /// The triangle corner that the side faces.
    Side(usize),
    Edge,
}

#[derive(Clone, Copy, Debug)]
struct Best {
    axis: Axis,
    normal: Vec3,
    part: Part,
    separation: f32,
}

impl PlacedFrustum {
    pub(super) fn new(pose: &Pose, half_height: f32, radii: [f32; 2], radius: f32) -> Self {
        let side = vec3(2.0 * half_height, radii[0] - radii[1], 0.0).normalize_or(Vec3::X);
        Self {
            center: pose.position,
            axis: pose.direction(Vec3::Y),
            half_height,
            radii,
            side: (side.x, side.y),
            radius,
        }
    }

    /// Returns the data of the first tests: the centers of the ends, the rims, and the planes of
    /// the ends.
    pub(super) fn outline(&self) -> ([Vec3; 2], Discs, [Plane; 2]) {
        let centers = [self.cap_center(0), self.cap_center(1)];
        (centers, (self.axis, self.radii), [self.cap_plane(0), self.cap_plane(1)])
    }

    fn cap_center(&self, cap: usize) -> Vec3 {
        self.center + self.axis * if cap == 0 { -self.half_height } else { self.half_height }
    }

    fn cap_plane(&self, cap: usize) -> Plane {
        let normal = if cap == 0 { -self.axis } else { self.axis };
        Plane { normal, offset: normal.dot(self.center) + self.half_height }
    }

    /// Returns the unit vector perpendicular to the axis nearest to `direction`.
    fn away(&self, direction: Vec3) -> Vec3 {
        let across = direction - self.axis * self.axis.dot(direction);
        if across.length_squared() < 1.0e-12 * direction.length_squared() {
            return self.axis.any_perpendicular();
        }
        across.normalize_or(self.axis.any_perpendicular())
    }

    /// Returns the line of the side towards `away`.
    fn generator(&self, away: Vec3) -> [Vec3; 2] {
        [0, 1].map(|cap| self.cap_center(cap) + away * self.radii[cap])
    }

    /// Returns the point farthest along `direction`.
    fn support(&self, direction: Vec3) -> Vec3 {
        let [bottom, top] = self.generator(self.away(direction));
        if direction.dot(bottom) > direction.dot(top) { bottom } else { top }
    }

    /// Extent of the frustum along `direction`, from the origin.
    fn reach(&self, direction: Vec3) -> f32 {
        direction.dot(self.support(direction))
    }

    /// Returns the cap, if it faces `direction` more than the side does.
    fn cap_towards(&self, direction: Vec3) -> Option<usize> {
        let along = self.axis.dot(direction);
        let side = self.away(direction).dot(direction) * self.side.0 + along * self.side.1;
        let cap = usize::from(along > 0.0);
        (along.abs() > side && self.radii[cap] > 0.0).then_some(cap)
    }

    /// Starts with the polygon of a cap, its first corner towards `away`.
    fn push_cap(&self, cap: usize, away: Vec3, class: u32, clipper: &mut Clipper) {
        let (center, across) = (self.cap_center(cap), self.axis.cross(away));
        let (u, v) = (away * self.radii[cap], across * self.radii[cap]);
        clipper.restart();
        let mut turned = (u, v);
        let mut number = if cap == 0 { 0 } else { 32 };
        for _ in 0..4 {
            for (c, s) in QUARTER {
                clipper.push(center + turned.0 * c + turned.1 * s, mix(8, number, class));
                number += 1;
            }
            turned = (turned.1, -turned.0);
        }
    }

    /// Keeps the part over a cap, whose polygon starts towards `start`.
    fn cut_by_rim(&self, cap: usize, start: Vec3, slack: f32, clipper: &mut Clipper) {
        let center = self.cap_center(cap);
        let away = self.away(start - center);
        let across = self.axis.cross(away);
        // Distance from the center to the middle of a side, for a polygon with its corners on the
        // rim.
        let inner = self.radii[cap] * 0.980_785_25;
        let mut turned = (away, across);
        for quarter in 0..4 {
            for ((c, s), side) in QUARTER.into_iter().zip(quarter * 4..) {
                let outward = turned.0 * c + turned.1 * s;
                clipper.cut(outward, center + outward * inner, slack, side);
            }
            turned = (turned.1, -turned.0);
        }
    }
}

/// Adds the contact of `body` with `triangle`. If an axis shows that they are too far apart for
/// one, returns a lower bound on their distance [m].
pub(super) fn frustum(
    triangle: &Triangle,
    body: &PlacedFrustum,
    contacts: &mut Contacts,
    clipper: &mut Clipper,
) -> Option<f32> {
    let limits = contacts.limits;
    let reach = limits.margin + body.radius;
    let over = -body.reach(-triangle.normal) - triangle.normal.dot(triangle.corners[0]);
    if over > reach {
        return Some(over - body.radius);
    }
    let mut best: Option<Best> = None;
    let mut refused: Option<Best> = None;
    let minimum = over + limits.bias;
    let mut consider = |axis: Axis, plane: &Plane| {
        let separation =
            triangle.corners.iter().map(|c| plane.distance(*c)).fold(f32::INFINITY, lesser);
        let normal = -plane.normal;
        let part = triangle.support(normal);
        // A normal of the side is computed for one corner; for a contact at another it is useless.
        let fits = !matches!((axis, part), (Axis::Side(i), Part::Corner(j)) if i != j);
        let slot = if triangle.allows(part, normal) { &mut best } else { &mut refused };
        if fits && separation > slot.map_or(minimum, |b| b.separation) {
            *slot = Some(Best { axis, normal, part, separation });
        }
        (separation > reach).then_some(separation - body.radius)
    };
    for cap in 0..2 {
        if body.radii[cap] > 0.0
            && let Some(apart) = consider(Axis::Cap(cap), &body.cap_plane(cap))
        {
            return Some(apart);
        }
    }
    for (i, corner) in triangle.corners.into_iter().enumerate() {
        let away = body.away(corner - body.center);
        let normal = away * body.side.0 + body.axis * body.side.1;
        let offset = normal.dot(body.generator(away)[0]);
        if let Some(apart) = consider(Axis::Side(i), &Plane { normal, offset }) {
            return Some(apart);
        }
    }
    for k in 0..3 {
        if triangle.is_concave(k) {
            let (normal, corner) = (triangle.outward[k], triangle.corners[k]);
            let separation = -body.reach(-normal) - normal.dot(corner);
            if separation > refused.map_or(minimum, |b| b.separation) {
                let (axis, part) = (Axis::Edge, Part::Edge(k));
                refused = Some(Best { axis, normal, part, separation });
            }
        }
        if !triangle.is_active(k) {
            continue;
        }
        let (normal, separation) = best_over_edge(triangle, k, body);
        if separation > reach {
            return Some(separation - body.radius);
        }
        if separation > best.map_or(minimum, |b| b.separation + limits.bias)
            && triangle.allows(Part::Edge(k), normal)
        {
            best = Some(Best { axis: Axis::Edge, normal, part: Part::Edge(k), separation });
        }
    }
    if let Some(r) = refused
        && best.is_none_or(|b| r.separation > b.separation)
        && triangle.is_behind_neighbor(r.part, r.normal, body.center)
    {
        return None;
    }
    let done = match best {
        Some(Best { axis: Axis::Cap(cap), .. }) => {
            on_cap(triangle, body, cap, contacts, clipper);
            true
        }
        Some(Best { axis: Axis::Side(_), normal, part: Part::Corner(i), separation }) => {
            let corner = triangle.corners[i];
            at_line(triangle, body, [corner; 2], Part::Corner(i), (normal, separation), contacts)
        }
        Some(Best { normal, part: Part::Edge(k), separation, .. }) => {
            let edge = triangle.edge(k);
            at_line(triangle, body, edge, Part::Edge(k), (normal, separation), contacts)
                || edge_on_cap(triangle, body, edge, normal, contacts, clipper)
        }
        _ => false,
    };
    let face = contacts::Axis { normal: triangle.normal, separation: over - body.radius };
    let instead = if best.is_none() { refused.map(|r| r.normal) } else { None };
    if !done
        && !on_triangle(triangle, body, (face, instead), contacts, clipper)
        && let Some(b) = best
    {
        let lowest = body.support(-b.normal);
        let separation = b.separation - body.radius;
        contacts
            .add_spare(b.normal, point(lowest, b.normal, separation, body.radius, mix(9, 0, 0)));
    }
    None
}

/// Returns the normal over edge `k` with the largest separation. The range is from the face's
/// normal to the neighbor's, or to straight outward if that comes first.
fn best_over_edge(triangle: &Triangle, k: usize, body: &PlacedFrustum) -> (Vec3, f32) {
    let (bend, outward) = (triangle.bend(k), triangle.outward[k]);
    let last =
        if bend.cos < 0.0 { outward } else { triangle.normal * bend.cos + outward * bend.sin };
    let corner = triangle.corners[k];
    let at = |t: f32| {
        let normal = triangle.normal.lerp(last, t).normalize_or(triangle.normal);
        (normal, -body.reach(-normal) - normal.dot(corner))
    };
    let mut middle = 0.0;
    let mut maximum = f32::NEG_INFINITY;
    for t in SAMPLES {
        let separation = at(t).1;
        if separation > maximum {
            (middle, maximum) = (t, separation);
        }
    }
    // Between the neighbors of the best sample there is one peak.
    let (mut low, mut high) = ((middle - 0.125).max(0.0), (middle + 0.125).min(1.0));
    for _ in 0..REFINEMENTS {
        let third = (high - low) * (1.0 / 3.0);
        if at(low + third).1 > at(high - third).1 { high -= third } else { low += third }
    }
    at(0.5 * (low + high))
}

/// Contact along the triangle's normal: cap or side line, clipped to the part over the triangle.
fn on_triangle(
    triangle: &Triangle,
    body: &PlacedFrustum,
    (axis, refused): (contacts::Axis, Option<Vec3>),
    contacts: &mut Contacts,
    clipper: &mut Clipper,
) -> bool {
    let normal = triangle.normal;
    let class = direction_class(normal);
    let away = body.away(-normal);
    if let Some(cap) = body.cap_towards(-normal) {
        body.push_cap(cap, away, class, clipper);
    } else {
        clipper.restart();
        for (end, number) in body.generator(away).into_iter().zip([0, 32]) {
            clipper.push(end, mix(8, number, class));
        }
    }
    clipper.cut_by_prism(triangle, contacts.limits.slack);
    let points = clipper.points.iter().map(|c| {
        let separation = triangle.height(c.position) - body.radius;
        point(c.position, normal, separation, body.radius, c.feature)
    });
    contacts.add_instead(triangle, axis, refused, points)
}

/// Contact along the normal of a cap, which an edge or a corner of the triangle touches.
fn on_cap(
    triangle: &Triangle,
    body: &PlacedFrustum,
    cap: usize,
    contacts: &mut Contacts,
    clipper: &mut Clipper,
) {
    let plane = body.cap_plane(cap);
    clipper.restart();
    push_corners(triangle, clipper);
    body.cut_by_rim(cap, triangle.corners[0], contacts.limits.slack, clipper);
    add_clipped_triangle(triangle, &plane, body.radius, contacts, clipper);
}

/// Contact of an edge that cuts through a cap at a small angle. There the lowest point of the rim
/// changes with the last bits of the normal, so the points come from the part of the edge over the
/// cap. Returns false if there is none.
fn edge_on_cap(
    triangle: &Triangle,
    body: &PlacedFrustum,
    edge: [Vec3; 2],
    normal: Vec3,
    contacts: &mut Contacts,
    clipper: &mut Clipper,
) -> bool {
    let Some(cap) = body.cap_towards(-normal) else { return false };
    let plane = body.cap_plane(cap);
    clipper.restart();
    for (end, number) in edge.into_iter().zip([0, 1]) {
        clipper.push(end, mix(9, triangle.number, number));
    }
    body.cut_by_rim(cap, edge[0], contacts.limits.slack, clipper);
    let slope = -plane.normal.dot(normal);
    let points = clipper.points.iter().map(|c| {
        let separation = plane.distance(c.position) / slope;
        point(
            c.position + normal * separation,
            normal,
            separation - body.radius,
            body.radius,
            c.feature,
        )
    });
    let separation = -body.reach(-normal) - normal.dot(edge[0]) - body.radius;
    contacts.add(triangle, contacts::Axis { normal, separation }, points)
}

/// Contact of the side with an edge or a corner. Returns false if the axis separates them but no
/// points near each other lie along it.
fn at_line(
    triangle: &Triangle,
    body: &PlacedFrustum,
    line: [Vec3; 2],
    part: Part,
    (normal, separation): (Vec3, f32),
    contacts: &mut Contacts,
) -> bool {
    let ends = body.generator(body.away(-normal));
    let (s, t) = closest_on_segments(ends, line);
    let (p, q) = (ends[0].lerp(ends[1], s), line[0].lerp(line[1], t));
    let slack = contacts.limits.slack + contacts.limits.merge;
    let gap = p - q;
    // Along the generator the support points are equally far only up to the precision of the
    // normal.
    if (gap - normal * normal.dot(gap)).length() > slack + 0.01 * separation.abs() {
        return false;
    }
    let axis = contacts::Axis { normal, separation: separation - body.radius };
    let separation = normal.dot(gap) - body.radius;
    let of = ((separation, body.radius), Vec3::ZERO);
    along_edge(triangle, part, axis, (ends, p), of, contacts);
    true
}
