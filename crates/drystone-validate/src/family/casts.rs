//! Shape casts and nearest-shape queries, against polytopes in f64.

use std::sync::Arc;

use drystone::{BodyDef, Filter, Hull, Pose, Shape, ShapeDef, World};
use drystone_bench::EngineError;

use super::geometry::{random_hull, refused};
use crate::lab::Lab;
use crate::numeric::{D3, Random, add, cross, dot, narrow, norm, rotate, scale, sub, wide, worst};
use crate::row::{Rows, Unit, limits};

/// A placed convex polytope.
struct Polytope {
    vertices: Vec<D3>,
    /// Outward unit normals of the faces, and the offset of each face along its normal.
    planes: Vec<(D3, f64)>,
    edges: Vec<D3>,
}

impl Polytope {
    fn of(hull: &Hull, pose: Pose) -> Self {
        let place = |v| add(rotate(pose.rotation, v), wide(pose.position));
        let vertices: Vec<D3> = hull.vertices().iter().map(|v| place(wide(*v))).collect();
        let mut planes = Vec::new();
        let mut edges = Vec::new();
        for (face, plane) in hull.planes().iter().enumerate() {
            let normal = rotate(pose.rotation, wide(plane.normal));
            planes.push((normal, f64::from(plane.offset) + dot(normal, wide(pose.position))));
            let corners = hull.face(face);
            for (k, corner) in corners.iter().enumerate() {
                let next = corners[(k + 1) % corners.len()];
                // Each edge belongs to two faces.
                if *corner < next {
                    let [a, b] = [*corner, next].map(|c| vertices[usize::from(c)]);
                    edges.push(sub(b, a));
                }
            }
        }
        Self { vertices, planes, edges }
    }

    /// Maximum extent along a direction.
    fn reach(&self, way: D3) -> f64 {
        self.vertices.iter().map(|v| dot(*v, way)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Distance of a point outside the polytope; negative inside.
    fn outside(&self, p: D3) -> f64 {
        let beyond = self.planes.iter().map(|(normal, offset)| dot(*normal, p) - offset);
        beyond.fold(f64::NEG_INFINITY, f64::max)
    }

    /// Gap from this polytope to `other` along a unit normal.
    fn gap(&self, other: &Self, normal: D3) -> f64 {
        -other.reach(scale(normal, -1.0)) - self.reach(normal)
    }
}

/// The interval in which two polytopes overlap while `b` moves by `way`, as fractions of that
/// displacement. It begins when no plane separates them any more, and ends when one does again.
/// Candidate planes are parallel to a face of either, or to an edge of each.
fn overlap(a: &Polytope, b: &Polytope, way: D3) -> Option<[f64; 2]> {
    let faces = a.planes.iter().chain(&b.planes).map(|(normal, _)| *normal);
    let pairs = a.edges.iter().flat_map(|u| b.edges.iter().map(move |v| cross(*u, *v)));
    let pairs = pairs.filter(|n| norm(*n) > 1.0e-9).map(|n| scale(n, 1.0 / norm(n)));
    let (mut from, mut to) = (f64::NEG_INFINITY, f64::INFINITY);
    for normal in faces.chain(pairs).flat_map(|n| [n, scale(n, -1.0)]) {
        let (gap, closing) = (a.gap(b, normal), -dot(normal, way));
        if closing > 0.0 {
            from = from.max(gap / closing);
        } else if closing < 0.0 {
            to = to.min(gap / closing);
        } else if gap > 0.0 {
            return None;
        }
    }
    (from <= to && to >= 0.0).then_some([from, to])
}

fn random_shape(kind: &str, random: &mut Random) -> Result<Option<(Shape, Hull)>, EngineError> {
    if kind == "hull" {
        return Ok(random_hull(random, 0.0).map(|h| (Shape::Hull(Arc::new(h.clone())), h)));
    }
    let half = narrow([0; 3].map(|_| random.between(0.1, 1.0)));
    let sign = |i: u32, bit: u32| if i >> bit & 1 == 0 { 1.0_f32 } else { -1.0 };
    let corner = |i| [half.x * sign(i, 0), half.y * sign(i, 1), half.z * sign(i, 2)].into();
    let corners: Vec<_> = (0..8).map(corner).collect();
    let hull = Hull::from_points(&corners).map_err(refused)?;
    Ok(Some((Shape::box_half(half), hull)))
}

fn random_pose(random: &mut Random, far: f64) -> Pose {
    Pose::new(narrow(scale(random.direction(), random.between(0.0, far))), random.rotation())
}

/// Casts each of two shapes from random places at the other. Distances are proved: the points
/// belong to the bodies, and the plane along the returned normal separates them by the returned
/// distance.
pub(super) fn casts(lab: &Lab, rows: &mut Rows) -> Result<(), EngineError> {
    lab.own("shape casts")?;
    let mut random = Random::new(44);
    for kind in ["box", "hull"] {
        let (mut missed, mut off, mut apart) = (0.0, 0.0, 0.0);
        for _ in 0..150 {
            let Some((still, still_hull)) = random_shape(kind, &mut random)? else { continue };
            let Some((moving, moving_hull)) = random_shape(kind, &mut random)? else { continue };
            let mut world = World::default();
            let pose = random_pose(&mut random, 3.0);
            let def = BodyDef::fixed().with_position(pose.position).with_rotation(pose.rotation);
            let id = world.add_body(def.with_shape(ShapeDef::new(still))).map_err(refused)?;
            let pose = world.body(id).map_or(Pose::IDENTITY, |b| b.pose());
            let a = Polytope::of(&still_hull, pose);
            let (query, all) = (world.query(), Filter::default());
            for _ in 0..20 {
                let from = scale(random.direction(), random.between(2.0, 5.0));
                let from = narrow(add(wide(pose.position), from));
                let at =
                    add(wide(pose.position), scale(random.direction(), random.between(0.0, 2.0)));
                let way = narrow(scale(sub(at, wide(from)), 2.0));
                let start = Pose::new(from, random.rotation());
                let b = Polytope::of(&moving_hull, start);
                let exact = overlap(&a, &b, wide(way));
                let length = norm(wide(way));
                let hit = query.cast_shape(&moving, start, way, all).map_err(refused)?;
                let clear = query.nearest_shape(&moving, start, 100.0, all).map_err(refused)?;
                match (exact, hit) {
                    (Some([from, _]), Some(hit)) => {
                        // At an oblique impact, a rounding error of the gap is a larger one of the
                        // displacement.
                        let slant = dot(wide(hit.normal), wide(way)).abs() / length;
                        let miss = (f64::from(hit.fraction) - from.max(0.0)).abs() * length;
                        off = worst(off, miss * slant.max(0.1));
                    }
                    (None, None) => {}
                    (Some([from, _]), None) if from > 1.0 => {}
                    // A grazing cast: either answer is right within 1e-4 of the size.
                    (Some([from, to]), None) if (to - from) * length < 1.0e-2 => {}
                    (None, Some(hit)) if grazes(&a, &b, wide(way), f64::from(hit.fraction)) => {}
                    _ => missed += 1.0,
                }
                match clear {
                    Some(near) if near.distance > 0.0 => {
                        let distance = f64::from(near.distance);
                        let (p, q) = (wide(near.point), wide(near.own_point));
                        let proofs = [
                            (norm(sub(q, p)) - distance).abs(),
                            (a.gap(&b, wide(near.normal)) - distance).abs(),
                            a.outside(p),
                            b.outside(q),
                        ];
                        apart = proofs.into_iter().fold(apart, worst);
                    }
                    // No shape is that far away; and no plane may separate bodies that overlap.
                    None => missed += 1.0,
                    Some(near) => apart = worst(apart, a.gap(&b, wide(near.normal))),
                }
            }
        }
        let l = limits(1.0e-4, 1.0e-5);
        rows.at_most(format!("{kind}, misses"), missed, Unit::Count, limits(0.0, 0.0));
        rows.at_most(format!("{kind}, way"), off, Unit::Meter, l);
        rows.at_most(format!("{kind}, distance"), apart, Unit::Meter, l);
    }
    Ok(())
}

/// True if bodies that pass each other are nearer than 1e-4 m at this fraction of the displacement.
fn grazes(a: &Polytope, b: &Polytope, way: D3, part: f64) -> bool {
    let moved = b.vertices.iter().map(|v| add(*v, scale(way, part))).collect();
    let b = Polytope { vertices: moved, planes: Vec::new(), edges: b.edges.clone() };
    let pairs = a.edges.iter().flat_map(|u| b.edges.iter().map(move |v| cross(*u, *v)));
    let faces = a.planes.iter().map(|(normal, _)| *normal);
    let along = faces.chain(pairs.filter(|n| norm(*n) > 1.0e-9)).flat_map(|n| [n, scale(n, -1.0)]);
    along.map(|n| a.gap(&b, scale(n, 1.0 / norm(n)))).fold(f64::NEG_INFINITY, f64::max) < 1.0e-4
}

#[cfg(test)]
mod tests {
    use drystone::{Hull, Pose, vec3};

    use super::{Polytope, overlap};

    fn cube(at: [f32; 3]) -> Polytope {
        let corner = |i: u32| {
            let at = |bit: u32| if i >> bit & 1 == 0 { 0.5 } else { -0.5 };
            vec3(at(0), at(1), at(2))
        };
        let corners: Vec<_> = (0..8).map(corner).collect();
        Polytope::of(&Hull::from_points(&corners).unwrap(), Pose::at(at))
    }

    #[test]
    fn cubes_overlap_from_where_they_meet_to_where_they_part() {
        let a = cube([0.0; 3]);
        assert_eq!((a.planes.len(), a.edges.len()), (6, 12));
        let [from, to] = overlap(&a, &cube([3.0, 0.2, 0.0]), [-8.0, 0.0, 0.0]).unwrap();
        assert!((from - 0.25).abs() < 1.0e-6 && (to - 0.5).abs() < 1.0e-6);
        assert!(overlap(&a, &cube([3.0, 0.2, 0.0]), [8.0, 0.0, 0.0]).is_none());
        assert!(overlap(&a, &cube([3.0, 1.2, 0.0]), [-8.0, 0.0, 0.0]).is_none());
        assert!((a.outside([0.0, 0.75, 0.2]) - 0.25).abs() < 1.0e-6);
    }
}
