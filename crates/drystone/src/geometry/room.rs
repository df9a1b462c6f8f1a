//! How far a pair may turn before a corner comes down that its manifold has no point of.
//!
//! A manifold is kept while its pair hardly moves, and has four points at most. What turns sets down other corners: next to the
//! face that stands, or of the same face, left out as the fifth. A corner that stands `rise` higher than the deepest point, `out`
//! outside of what the points at that depth enclose, comes down at an angle of `rise / out`; one above what they enclose never does.

use super::manifold::Manifold;
use super::solid::{Core, Solid};
use crate::base::math::{Vec3, greater, lesser, vec3};
use crate::base::pose::Pose;

/// A corner may come deeper than the deepest point by this part of how far it is from the middle of the manifold.
const DEEPER: f32 = 0.001;

/// A corner may touch the other solid if it is in that when it has come down by this part of its distance from the middle of the
/// manifold. That is what a turn of 0.1 rad does.
const DOWN: f32 = 0.1;

/// The lowest place may go round a rim by this angle about its axis [rad].
const FAR_ROUND: f32 = 0.1;

/// A rim that lies flat has four points. A place between two of them comes down by the turn times this part of the radius, which is
/// 1 - cos 45°.
const BETWEEN: f32 = 0.29;

/// Steeper corners are not asked [rad]: nothing is kept over such a turn.
const STEEPEST: f32 = 0.3;

/// The least angle at which a corner of one of the solids comes down beside the manifold [rad]; [`f32::MAX`] if none does.
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

/// How far a body of revolution may turn before another place of its rim comes down. If its axis leans from the normal by `a`, the
/// lowest place goes round by `turn / sin a`.
fn rim(normal: Vec3, axis: Vec3) -> f32 {
    greater(FAR_ROUND * axis.cross(normal).length(), DEEPER / BETWEEN)
}

/// Corners that are nearer to a point than this part of the manifold's size have that point.
const SAME: f32 = 1.0e-3;

/// A manifold seen along its normal.
struct Plan {
    normal: Vec3,
    across: [Vec3; 2],
    /// The deepest point, half way between the surfaces, and its separation.
    deepest: Vec3,
    separation: f32,
    middle: [f32; 2],
    /// Those as deep as the deepest, first, of all.
    points: [[f32; 2]; 4],
    level: usize,
    count: usize,
    /// Greatest distance of a point from the deepest [m].
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

    /// The least of the angles at which those corners of a hull come down that may touch the other solid. Both are with their poses.
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

    /// The angle at which a corner comes down; `side`: 1 of B, -1 of A. `radius` is its rounding.
    fn room(&self, corner: Vec3, side: f32, radius: f32) -> f32 {
        let from = corner - self.deepest;
        // Over the surface of the other solid at the deepest point, less the separation there.
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

    /// True if a corner is in the other solid when it has come down ([`DOWN`]). Those beside that solid never are.
    fn may_touch(&self, corner: Vec3, side: f32, other: &Solid, pose: &Pose) -> bool {
        let Core::Hull(hull) = &other.core else { return true };
        let from = corner - self.deepest;
        let over = side * self.normal.dot(from) + 0.5 * self.separation;
        let away = length(minus(flat(from, self.across), self.middle));
        let down = greater(over, 0.0) + DOWN * away;
        let then = pose.local_point(corner - self.normal * (side * down));
        hull.planes.iter().all(|plane| plane.distance(then) <= other.radius)
    }

    /// How far a place is outside of what the deepest points enclose [m].
    fn outside(&self, at: [f32; 2]) -> f32 {
        let points = &self.points[..self.level];
        let mut least = f32::MAX;
        for (i, p) in points.iter().enumerate() {
            least = lesser(least, length(minus(at, *p)));
            for (j, q) in points.iter().enumerate().skip(i + 1) {
                least = lesser(least, to_segment(at, *p, *q));
                for r in points.iter().skip(j + 1) {
                    if is_in(at, [*p, *q, *r]) {
                        return 0.0;
                    }
                }
            }
        }
        least
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
    use crate::base::wide::SimdLevel;
    use crate::geometry::collide::collide;
    use crate::geometry::hull::Hull;
    use crate::geometry::manifold::PairCache;
    use crate::geometry::shape::Shape;
    use crate::geometry::solid::Solid;

    /// Of a shape that rests on a plane.
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
