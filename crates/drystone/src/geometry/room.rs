//! Rotation that a pair can make before a corner without a contact point lands.
//!
//! A manifold is reused while its pair hardly moves, and has at most four points. A rotation can
//! land other corners: corners next to the supporting face, or a fifth corner of the same face.
//! Take a corner that is `rise` higher than the deepest point, and `out` outside the area that the
//! points at that depth enclose. It lands at an angle of `rise / out`; a corner above the area
//! never lands.

use super::manifold::Manifold;
use super::solid::{Core, Solid};
use crate::base::math::{Vec3, greater, lesser, vec3};
use crate::base::pose::Pose;

/// Allowed extra depth of a corner below the deepest point, relative to its distance from the
/// middle of the manifold.
const DEEPER: f32 = 0.001;

/// Maximum descent of a corner, relative to its distance from the middle of the manifold: the
/// effect of a rotation of 0.1 rad. A corner may touch the other solid if it is inside it after
/// this descent.
const DOWN: f32 = 0.1;

/// Angle about a rim's axis by which its lowest point may move [rad].
const FAR_ROUND: f32 = 0.1;

/// A rim that lies flat has four points. A point between two of them descends by the rotation times
/// this fraction of the radius, which is 1 - cos 45°.
const BETWEEN: f32 = 0.29;

/// Maximum landing angle of a corner that counts [rad]: no manifold is reused over such a rotation.
const STEEPEST: f32 = 0.3;

/// Returns the minimum angle at which a corner of one of the solids lands beside the manifold
/// [rad]; [`f32::MAX`] if none does.
pub(crate) fn room_to_turn(m: &Manifold, [a, b]: [&Solid; 2], b_in_a: &Pose) -> f32 {
    let Some(plan) = Plan::of(m) else { return f32::MAX };
    let mut room = f32::MAX;
    match &a.core {
        Core::Hull(hull) if hull.cuboid.is_none() => {
            room = plan.room_of((&hull.vertices, &Pose::IDENTITY), (-1.0, a.radius), (b, b_in_a));
        }
        Core::Frustum { .. } => room = rim(m.normal, Vec3::Y),
        _ => {}
    }
    match &b.core {
        Core::Hull(hull) if hull.cuboid.is_none() => {
            let of_b =
                plan.room_of((&hull.vertices, b_in_a), (1.0, b.radius), (a, &Pose::IDENTITY));
            room = lesser(room, of_b);
        }
        Core::Segment { half_height } => {
            for y in [-half_height, *half_height] {
                let end = b_in_a.point(vec3(0.0, y, 0.0));
                room = lesser(room, plan.room(end, 1.0, b.radius));
            }
        }
        Core::Frustum { .. } => {
            room = lesser(room, rim(m.normal, b_in_a.direction(Vec3::Y)));
        }
        _ => {}
    }
    room
}

/// Angle by which a body of revolution may turn before another point of its rim lands. If its axis
/// leans from the normal by `a`, the lowest point moves about the axis by `turn / sin a`.
fn rim(normal: Vec3, axis: Vec3) -> f32 {
    greater(FAR_ROUND * axis.cross(normal).length(), DEEPER / BETWEEN)
}

/// A corner belongs to a contact point if it is nearer than this fraction of the manifold's size.
const SAME: f32 = 1.0e-3;

/// A manifold projected along its normal.
struct Plan {
    normal: Vec3,
    across: [Vec3; 2],
    /// The deepest point, half way between the surfaces, and its separation.
    deepest: Vec3,
    separation: f32,
    middle: [f32; 2],
    /// All points; those as deep as the deepest come first.
    points: [[f32; 2]; 4],
    level: usize,
    count: usize,
    /// Maximum distance of a point from the deepest [m].
    size: f32,
}

impl Plan {
    fn of(m: &Manifold) -> Option<Self> {
        let first = m.points().first()?;
        let mut deepest = first;
        for p in m.points() {
            if p.separation < deepest.separation {
                deepest = p;
            }
        }
        let u = m.normal.any_perpendicular();
        let across = [u, m.normal.cross(u)];
        let (mut points, mut count, mut level) = ([[0.0; 2]; 4], 0, 0);
        let (mut middle, mut size) = ([0.0; 2], 0.0);
        #[expect(clippy::cast_precision_loss, reason = "at most four")]
        let share = 1.0 / m.count as f32;
        for p in m.points() {
            let place = flat(p.position - deepest.position, across);
            let away = length(place);
            size = greater(size, away);
            middle[0] += place[0] * share;
            middle[1] += place[1] * share;
            points[count] = place;
            if p.separation <= deepest.separation + DEEPER * away {
                points.swap(level, count);
                level += 1;
            }
            count += 1;
        }
        Some(Self {
            normal: m.normal,
            across,
            deepest: deepest.position,
            separation: deepest.separation,
            middle,
            points,
            level,
            count,
            size,
        })
    }

    /// Minimum landing angle of the hull's corners that may touch the other solid, both at their
    /// poses.
    fn room_of(
        &self,
        (corners, pose): (&[Vec3], &Pose),
        (side, radius): (f32, f32),
        (other, other_pose): (&Solid, &Pose),
    ) -> f32 {
        let mut room = f32::MAX;
        for corner in corners {
            let corner = pose.point(*corner);
            let angle = self.room(corner, side, radius);
            if angle < room && self.may_touch(corner, side, other, other_pose) {
                room = angle;
            }
        }
        room
    }

    /// Angle at which a corner lands; `side` is 1 for B, -1 for A. `radius` is its rounding.
    fn room(&self, corner: Vec3, side: f32, radius: f32) -> f32 {
        let from = corner - self.deepest;
        // Height over the surface of the other solid at the deepest point, minus the separation
        // there.
        let rise = side * self.normal.dot(from) - 0.5 * self.separation - radius;
        let at = flat(from, self.across);
        let has_one = |p: &[f32; 2]| length(minus(at, *p)) <= SAME * self.size;
        if self.points[..self.count].iter().any(has_one) {
            return f32::MAX;
        }
        let away = length(minus(at, self.middle));
        let rise = greater(rise, 0.0) + DEEPER * away;
        if rise > STEEPEST * away {
            return f32::MAX;
        }
        let out = self.outside(at);
        if out * STEEPEST <= rise { f32::MAX } else { rise / out }
    }

    /// Returns true if a corner is in the other solid after its descent ([`DOWN`]). Corners beside
    /// that solid never are.
    fn may_touch(&self, corner: Vec3, side: f32, other: &Solid, pose: &Pose) -> bool {
        let Core::Hull(hull) = &other.core else { return true };
        let from = corner - self.deepest;
        let over = side * self.normal.dot(from) + 0.5 * self.separation;
        let away = length(minus(flat(from, self.across), self.middle));
        let down = greater(over, 0.0) + DOWN * away;
        let then = pose.local_point(corner - self.normal * (side * down));
        hull.planes.iter().all(|plane| plane.distance(then) <= other.radius)
    }

    /// Distance of a point outside the area that the deepest points enclose [m].
    fn outside(&self, at: [f32; 2]) -> f32 {
        let points = &self.points[..self.level];
        let mut minimum = f32::MAX;
        for (i, p) in points.iter().enumerate() {
            minimum = lesser(minimum, length(minus(at, *p)));
            for (j, q) in points.iter().enumerate().skip(i + 1) {
                minimum = lesser(minimum, to_segment(at, *p, *q));
                for r in points.iter().skip(j + 1) {
                    if is_in(at, [*p, *q, *r]) {
                        return 0.0;
                    }
                }
            }
        }
        minimum
    }
}

fn flat(v: Vec3, [x, y]: [Vec3; 2]) -> [f32; 2] {
    [x.dot(v), y.dot(v)]
}

fn minus(a: [f32; 2], b: [f32; 2]) -> [f32; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn length(v: [f32; 2]) -> f32 {
    (v[0] * v[0] + v[1] * v[1]).sqrt()
}

fn cross(a: [f32; 2], b: [f32; 2]) -> f32 {
    a[0] * b[1] - a[1] * b[0]
}

fn to_segment(at: [f32; 2], p: [f32; 2], q: [f32; 2]) -> f32 {
    let (along, from) = (minus(q, p), minus(at, p));
    let square = along[0] * along[0] + along[1] * along[1];
    let dot = along[0] * from[0] + along[1] * from[1];
    let t = if square > 0.0 { (dot / square).clamp(0.0, 1.0) } else { 0.0 };
    length(minus(from, [along[0] * t, along[1] * t]))
}

fn is_in(at: [f32; 2], [p, q, r]: [[f32; 2]; 3]) -> bool {
    let sides = [(p, q), (q, r), (r, p)].map(|(from, to)| cross(minus(to, from), minus(at, from)));
    sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::room_to_turn;
    use crate::base::math::vec3;
    use crate::base::pose::Pose;
    use crate::base::quat::Quat;
    use crate::base::simd::wide::SimdLevel;
    use crate::geometry::collide::collide;
    use crate::geometry::hull::Hull;
    use crate::geometry::manifold::PairCache;
    use crate::geometry::shape::Shape;
    use crate::geometry::solid::Solid;

    /// Room of a shape that rests on a plane.
    fn room(shape: &Shape, height: f32) -> f32 {
        let floor = Solid::of(&Shape::HalfSpace { normal: vec3(0.0, 1.0, 0.0), offset: 0.0 });
        let solid = Solid::of(shape);
        let pose = Pose { position: vec3(0.0, height, 0.0), rotation: Quat::IDENTITY };
        let mut cache = PairCache::default();
        let m = collide(SimdLevel::best().0, &floor, &solid, &pose, 0.02, &mut cache);
        room_to_turn(&m, [&floor, &solid], &pose)
    }

    #[test]
    fn a_prism_whose_sides_lean_out_may_turn_until_the_next_corner_comes_down() {
        // Corners 0.1 m higher and 0.5 m beside the face, or 1 m from its middle.
        let low = [
            vec3(-0.5, 0.0, -0.5),
            vec3(0.5, 0.0, -0.5),
            vec3(0.5, 0.0, 0.5),
            vec3(-0.5, 0.0, 0.5),
        ];
        let high = [vec3(1.0, 0.1, 0.0), vec3(-1.0, 0.1, 0.0)];
        let points: Vec<_> = low.into_iter().chain(high).chain([vec3(0.0, 1.0, 0.0)]).collect();
        let hull = Shape::Hull(Arc::new(Hull::from_points(&points).unwrap()));
        let expected = (0.1 + 0.001) / 0.5;
        assert!((room(&hull, 0.0) - expected).abs() < 1.0e-3, "{}", room(&hull, 0.0));
    }

    #[test]
    fn a_coin_may_turn_the_less_the_flatter_it_spins() {
        let floor = Solid::of(&Shape::HalfSpace { normal: vec3(0.0, 1.0, 0.0), offset: 0.0 });
        let coin = Solid::of(&Shape::Cylinder { half_height: 0.01, radius: 0.5 });
        for (sin, cos) in [(0.28_f32, 0.96), (0.6, 0.8), (0.96, 0.28)] {
            let rotation = Quat::from_arc(vec3(0.0, 1.0, 0.0), vec3(-sin, cos, 0.0));
            let height = 0.5 * sin + 0.01 * cos;
            let pose = Pose { position: vec3(0.0, height, 0.0), rotation };
            let mut cache = PairCache::default();
            let m = collide(SimdLevel::best().0, &floor, &coin, &pose, 0.02, &mut cache);
            // It rolls by a tenth of a radian.
            let expected = 0.1 * sin;
            let room = room_to_turn(&m, [&floor, &coin], &pose);
            assert!((room - expected).abs() < 1.0e-5, "{room} of {expected}");
        }
    }

    #[test]
    fn a_cube_may_turn_as_far_as_it_likes() {
        let corners = [-0.5_f32, 0.5]
            .map(|x| [-0.5_f32, 0.5].map(|y| [-0.5_f32, 0.5].map(|z| vec3(x, y, z))));
        let points: Vec<_> = corners.into_iter().flatten().flatten().collect();
        let hull = Shape::Hull(Arc::new(Hull::from_points(&points).unwrap()));
        assert!(room(&hull, 0.5) >= f32::MAX);
    }
}
