//! A polytope against one triangle: separating axes, with the axes that a closed surface would not
//! have left out.

use super::clip::Clipper;
use super::contacts::{self, Contacts, direction_class, mix};
use super::round::point;
use super::triangle::{Part, Triangle, closest_on_segments};
use crate::base::math::{Vec3, greater, lesser};
use crate::base::pose::Pose;
use crate::geometry::hull::{HalfEdge, Hull, Plane};
use crate::geometry::manifold::ManifoldPoint;

/// Sine of the angle below which edges count as parallel: their axis is a face's.
const PARALLEL: f32 = 1.0e-3;

/// A polytope moved into the frame of the mesh.
#[derive(Debug)]
pub(super) struct PlacedHull<'a> {
    pub(super) vertices: &'a [Vec3],
    pub(super) planes: &'a [Plane],
    /// Room for one number a face.
    slopes: &'a mut Vec<f32>,
    face_edges: &'a [u16],
    edges: &'a [HalfEdge],
    pub(super) center: Vec3,
    radius: f32,
}

/// What separates the two most.
#[derive(Clone, Copy, Debug)]
enum Axis {
    Face(usize),
    /// Edge of the triangle, first half-edge of the polytope.
    Edges(usize, usize),
}

#[derive(Clone, Copy, Debug)]
struct Best {
    axis: Axis,
    normal: Vec3,
    part: Part,
    separation: f32,
}

impl<'a> PlacedHull<'a> {
    /// Uses `vertices`, `planes` and `slopes` as memory.
    pub(super) fn new(
        hull: &'a Hull,
        pose: &Pose,
        radius: f32,
        vertices: &'a mut Vec<Vec3>,
        planes: &'a mut Vec<Plane>,
        slopes: &'a mut Vec<f32>,
    ) -> Self {
        let turn = pose.rotation.to_mat3();
        let placed = |plane: &Plane| {
            let normal = turn * plane.normal;
            Plane { normal, offset: plane.offset + normal.dot(pose.position) }
        };
        vertices.clear();
        vertices.extend(hull.vertices.iter().map(|v| turn * *v + pose.position));
        planes.clear();
        planes.extend(hull.planes.iter().map(placed));
        Self {
            vertices,
            planes,
            slopes,
            face_edges: &hull.face_edges,
            edges: &hull.edges,
            center: turn * hull.center + pose.position,
            radius,
        }
    }

    /// True if no normal over edge `k`, from the triangle's to that of the neighbor, separates more than
    /// `least`: every vertex bounds that, by its height over the plane and its way beyond the edge.
    fn is_within(&self, triangle: &Triangle, k: usize, least: f32) -> bool {
        let (bend, outward, corner) = (triangle.bend(k), triangle.outward[k], triangle.corners[k]);
        let (cos, sin) = (greater(bend.cos, 0.0), if bend.cos < 0.0 { 1.0 } else { bend.sin });
        self.vertices.iter().any(|v| {
            let to = *v - corner;
            let (height, beyond) = (triangle.normal.dot(to), outward.dot(to));
            greater(height, height * cos) + greater(beyond, 0.0) * sin <= least
        })
    }

    fn ends(&self, edge: usize) -> [Vec3; 2] {
        [edge, edge ^ 1].map(|e| self.vertices[usize::from(self.edges[e].origin)])
    }

    /// Calls `f` with the half-edges of a face.
    fn around(&self, face: usize, mut f: impl FnMut(HalfEdge)) {
        let first = self.face_edges[face];
        let mut e = first;
        loop {
            let edge = self.edges[usize::from(e)];
            f(edge);
            e = edge.next;
            if e == first {
                return;
            }
        }
    }
}

/// Adds the contact of `hull` with `triangle`.
pub(super) fn hull(
    triangle: &Triangle,
    hull: &mut PlacedHull<'_>,
    contacts: &mut Contacts,
    clipper: &mut Clipper,
) {
    let limits = contacts.limits;
    let reach = limits.margin + hull.radius;
    let over = hull.vertices.iter().map(|v| triangle.height(*v)).fold(f32::INFINITY, lesser);
    if over > reach {
        return;
    }
    let mut best: Option<Best> = None;
    let mut refused: Option<Best> = None;
    let least = over + limits.bias;
    for (face, plane) in hull.planes.iter().enumerate() {
        let separation =
            triangle.corners.iter().map(|c| plane.distance(*c)).fold(f32::INFINITY, lesser);
        if separation > reach {
            return;
        }
        if separation <= least {
            continue;
        }
        let normal = -plane.normal;
        let part = triangle.support(normal);
        let found = Best { axis: Axis::Face(face), normal, part, separation };
        let slot = if triangle.allows(part, normal) { &mut best } else { &mut refused };
        if slot.is_none_or(|b| separation > b.separation) {
            *slot = Some(found);
        }
    }
    for k in 0..3 {
        if triangle.is_concave(k) {
            let (normal, corner) = (triangle.outward[k], triangle.corners[k]);
            let separation =
                hull.vertices.iter().map(|v| normal.dot(*v - corner)).fold(f32::INFINITY, lesser);
            if separation > refused.map_or(least, |b| b.separation) {
                let (axis, part) = (Axis::Edges(k, 0), Part::Edge(k));
                refused = Some(Best { axis, normal, part, separation });
            }
        }
        if !triangle.is_active(k) {
            continue;
        }
        let least = best.map_or(least, |b| b.separation + limits.bias);
        if hull.is_within(triangle, k, least) {
            continue;
        }
        match best_edge(triangle, k, hull, least, reach) {
            Err(Separated) => return,
            Ok(Some(found)) => best = Some(found),
            Ok(None) => {}
        }
    }
    if let Some(r) = refused
        && best.is_none_or(|b| r.separation > b.separation)
        && triangle.is_behind_neighbor(r.part, r.normal, hull.center)
    {
        return;
    }
    let face_axis = contacts::Axis { normal: triangle.normal, separation: over - hull.radius };
    if limits.corners {
        contacts.add_corners(triangle, hull.vertices, (over - hull.radius, hull.radius));
    }
    match best {
        Some(Best { axis: Axis::Face(face), .. }) => {
            on_hull_face(triangle, hull, face, contacts, clipper);
        }
        Some(found @ Best { axis: Axis::Edges(k, edge), .. }) => {
            if !on_edges(triangle, (k, edge), hull, &found, contacts) {
                on_triangle(triangle, hull, (face_axis, None), contacts, clipper);
            }
        }
        None => {
            let refused = refused.map(|r| r.normal);
            on_triangle(triangle, hull, (face_axis, refused), contacts, clipper);
        }
    }
}

/// The two are farther apart than contacts reach.
struct Separated;

/// The edge of the polytope whose axis with edge `k` of the triangle separates most and by more than
/// `least`.
fn best_edge(
    triangle: &Triangle,
    k: usize,
    hull: &mut PlacedHull<'_>,
    least: f32,
    reach: f32,
) -> Result<Option<Best>, Separated> {
    let [a, b] = triangle.edge(k);
    let along = b - a;
    let mut best = None;
    let mut most = least;
    hull.slopes.clear();
    hull.slopes.extend(hull.planes.iter().map(|plane| plane.normal.dot(along)));
    for (pair, edge) in hull.edges.chunks_exact(2).zip((0..).step_by(2)) {
        let [u, v] = [pair[0], pair[1]].map(|e| usize::from(e.face));
        // Opposite the normals at right angles to `along` lies none of those at this edge.
        if hull.slopes[u] * hull.slopes[v] > 0.0 {
            continue;
        }
        let [u, v] = [u, v].map(|face| hull.planes[face].normal);
        let [p, q] = hull.ends(edge);
        let d = q - p;
        let cross = along.cross(d);
        let size = cross.length_squared();
        if size <= PARALLEL * PARALLEL * along.length_squared() * d.length_squared() {
            continue;
        }
        let mut axis = cross * (1.0 / size.sqrt());
        let out = axis.dot(triangle.outward[k]);
        if out < 0.0 || (out <= 0.0 && axis.dot(triangle.normal) < 0.0) {
            axis = -axis;
        }
        let separation = axis.dot(p - a);
        if separation <= most {
            continue;
        }
        // The axis supports the polytope at this edge if its opposite lies between the normals of
        // the edge's faces (Gregorius 2013).
        let turn = u.cross(v).dot(d);
        if u.cross(-axis).dot(d) * turn < 0.0 || (-axis).cross(v).dot(d) * turn < 0.0 {
            continue;
        }
        if separation > reach {
            return Err(Separated);
        }
        if triangle.allows(Part::Edge(k), axis) {
            most = separation;
            best = Some(Best {
                axis: Axis::Edges(k, edge),
                normal: axis,
                part: Part::Edge(k),
                separation,
            });
        }
    }
    Ok(best)
}

/// The normal is the triangle's: the polytope's lowest face is cut to what lies over the triangle.
fn on_triangle(
    triangle: &Triangle,
    hull: &PlacedHull<'_>,
    (axis, refused): (contacts::Axis, Option<Vec3>),
    contacts: &mut Contacts,
    clipper: &mut Clipper,
) {
    let normal = triangle.normal;
    let mut lowest = (0, f32::INFINITY);
    for (face, plane) in hull.planes.iter().enumerate() {
        let d = plane.normal.dot(normal);
        if d < lowest.1 {
            lowest = (face, d);
        }
    }
    let class = direction_class(normal);
    clipper.restart();
    hull.around(lowest.0, |e| {
        let position = hull.vertices[usize::from(e.origin)];
        clipper.push(position, mix(5, u32::from(e.origin), class));
    });
    clipper.cut_by_prism(triangle, contacts.limits.slack);
    let points = clipper.points.iter().map(|c| {
        let separation = triangle.height(c.position) - hull.radius;
        point(c.position, normal, separation, hull.radius, c.feature)
    });
    contacts.add_instead(triangle, axis, refused, points);
}

/// The normal is that of a face of the polytope, which an edge or a corner of the triangle touches.
fn on_hull_face(
    triangle: &Triangle,
    hull: &PlacedHull<'_>,
    face: usize,
    contacts: &mut Contacts,
    clipper: &mut Clipper,
) {
    let plane = hull.planes[face];
    clipper.restart();
    push_corners(triangle, clipper);
    let mut side = 0;
    hull.around(face, |e| {
        let a = hull.vertices[usize::from(e.origin)];
        let b = hull.vertices[usize::from(hull.edges[usize::from(e.next)].origin)];
        if let Some(outward) = (b - a).cross(plane.normal).try_normalize() {
            clipper.cut(outward, a, contacts.limits.slack, side);
        }
        side += 1;
    });
    add_clipped_triangle(triangle, &plane, hull.radius, contacts, clipper);
}

/// Begins with the triangle as polygon.
pub(super) fn push_corners(triangle: &Triangle, clipper: &mut Clipper) {
    for (corner, vertex) in triangle.corners.iter().zip(triangle.vertices) {
        clipper.push(*corner, mix(6, vertex, 0));
    }
}

/// What is left of the triangle, as contact with the flat face on `plane`.
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

/// Two edges touch; false if the axis separates them but no points near each other lie along it.
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
