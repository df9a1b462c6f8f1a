//! Motion of a convex solid that turns, up to its first hit on another one.
//!
//! Conservative advancement as in the parent module. A plane between the two at their closest
//! points has a fixed normal n. Let r be the points of B relative to the origin of its frame, w its
//! rotation and v its displacement. After the fraction t from here, the heights of B's points over
//! the plane are
//!
//! ```text
//! n·(x + v t) + r·(n + t n×w) + e,   |e| <= ½ |n×w| |w| |r| t²
//! ```
//!
//! since the second derivative of a point's height is (n×w)·(w×r). The minimum over B belongs to
//! one support point along n + t n×w. This bound is exact to first order, and concave in t. The
//! fractions for which it keeps B above the plane therefore form an interval, whose end is found by
//! chords and bisection. Near a hit the steps shrink as the square of the gap.

use super::{ALONG, Course, Meeting, Nearby, Placed, convex_set, deepest, first_triangle, flat};
use crate::base::aabb::Aabb;
use crate::base::math::{Vec3, greater};
use crate::base::pose::Pose;
use crate::geometry::collide::convex::Convex;
use crate::geometry::mesh::Mesh;
use crate::geometry::solid::{Core, Solid};

/// Maximum number of advancement steps, and of extra steps per radian. Along a surface at a
/// constant gap, one step turns by the root of twice the gap over the size. A cast that takes
/// longer counts as a hit where it stands.
const MAX_STEPS: f32 = 64.0;

/// Maximum number of iterations for the length of a step: it need not be exact.
const ROUNDS_OF_STEP: usize = 12;

/// Returns the first hit of B, which turns as it moves, on A.
pub(super) fn meet(a: &Solid, b: &Solid, placed: &Placed<'_>, course: &Course) -> Option<Meeting> {
    let turning = Turning::new(b, placed, course);
    match &a.core {
        Core::HalfSpace { normal, offset } => {
            let look = |b: &Placed<'_>, shift: Vec3| {
                let near = b.above(*normal, *offset);
                Some(Nearby { distance: near.distance + normal.dot(shift), ..near })
            };
            let touch = || Some(placed.above(*normal, *offset));
            turning.advance(placed.met(offset.abs()), course.limit, look, touch)
        }
        Core::Mesh(mesh) => turning.meet_triangle(mesh),
        core => {
            let x = Convex::of(core)?;
            let set = convex_set(&x);
            let met = placed.met(set.size + set.center.length());
            let look = |b: &Placed<'_>, shift| b.nearby(&set, shift);
            let touch = || deepest(a, b, placed.pose);
            let found = turning.advance(met, course.limit, look, touch)?;
            let apart = placed.apart(&set);
            Some(turning.refined(found, met, apart, look))
        }
    }
}

/// B and its motion.
struct Turning<'a> {
    placed: &'a Placed<'a>,
    course: &'a Course,
    /// Maximum distance of a point of its core from the origin of its frame [m].
    reach: f32,
    radius: f32,
    rounds: usize,
}

impl<'a> Turning<'a> {
    fn new(b: &Solid, placed: &'a Placed<'a>, course: &'a Course) -> Self {
        let reach = greater(b.max_extent(Vec3::ZERO) - b.radius, 0.0);
        let rounds = (MAX_STEPS * (1.0 + course.turn.length())).clamp(MAX_STEPS, 200.0 * MAX_STEPS);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in range")]
        let rounds = rounds as usize;
        Self { placed, course, reach, radius: b.radius, rounds }
    }

    /// Pose of B's frame after a fraction of the motion.
    fn at(&self, part: f32) -> Pose {
        let Pose { position, rotation } = *self.placed.pose;
        let Course { delta, turn, .. } = *self.course;
        Pose { position: position + delta * part, rotation: rotation.turned_by(turn * part) }
    }

    /// Advances B to its first hit. `look` returns the closest points of A and of B moved by a
    /// shift. `touch` returns the contact at the start, if they touch or overlap there.
    fn advance(
        &self,
        met: f32,
        limit: f32,
        look: impl Fn(&Placed<'_>, Vec3) -> Option<Nearby>,
        touch: impl Fn() -> Option<Nearby>,
    ) -> Option<Meeting> {
        let off = self.placed.sliding.shift(met);
        let apart = |part: f32| {
            let now = self.at(part);
            let near = look(&Placed { pose: &now, ..*self.placed }, off);
            (now, near.filter(|near| near.distance > met))
        };
        let (mut now, mut near) = apart(0.0);
        let mut at = 0.0;
        if near.is_none() {
            let deep = touch()?;
            if deep.overlaps(met) || self.comes_closer(&deep) {
                return Some(Meeting::at_start(&deep, met));
            }
            // B moves away from a surface that it touches.
            for part in [1.0e-4, 1.0e-3, 1.0e-2, 1.0e-1] {
                if near.is_none() {
                    at = part;
                    (now, near) = apart(at);
                }
            }
            near?;
        }
        let mut last = near?;
        for _ in 0..self.rounds {
            let rest = 1.0 - at;
            let step = self.step(&now, last.normal, last.distance - 0.5 * met, rest);
            // Ends exactly at 1, with steps that do not depend on the limit.
            at = if step < rest { at + step } else { 1.0 };
            if at > limit {
                return None;
            }
            (now, near) = apart(at);
            let Some(next) = near else { break };
            if at >= 1.0 {
                return None;
            }
            last = next;
        }
        Some(Meeting { fraction: at, point: last.point_a, normal: last.normal, overlap: false })
    }

    /// Returns true if the touching point of B moves into A, by more than some roundings.
    fn comes_closer(&self, deep: &Nearby) -> bool {
        let Course { delta, turn, .. } = *self.course;
        let arm = deep.point_b - self.placed.pose.position;
        let speed = delta.length() + turn.length() * self.reach;
        deep.normal.dot(delta + turn.cross(arm)) < -ALONG * speed
    }

    /// Returns a fraction, at most `maximum`, in which B approaches a plane by no more than `gap`
    /// [m], however it turns. It is close to the maximum that the module's bound allows.
    fn step(&self, now: &Pose, normal: Vec3, gap: f32, maximum: f32) -> f32 {
        let Course { delta, turn, .. } = *self.course;
        let across = normal.cross(turn);
        let bend = 0.5 * across.length() * turn.length() * self.reach;
        let lowest = |direction: Vec3| {
            let seen = now.local_direction(direction);
            direction.dot(now.direction(self.placed.convex.support(-seen)))
        };
        let start = lowest(normal);
        let clear = |t: f32| {
            let falls = lowest(normal + across * t) - start;
            gap + normal.dot(delta) * t + falls - bend * t * t
        };
        if clear(maximum) >= 0.0 {
            return maximum;
        }
        let ([mut low, mut above], [mut high, mut below]) = ([0.0, gap], [maximum, clear(maximum)]);
        for round in 0..ROUNDS_OF_STEP {
            // A chord of a concave function lies below it, so the chord's zero is not beyond the
            // end.
            let chord = low + (high - low) * (above / (above - below));
            let part = if round % 2 == 0 { chord } else { 0.5 * (low + high) };
            let rest = clear(part);
            if rest >= 0.0 {
                [low, above] = [part, rest];
                if rest < 0.1 * gap {
                    break;
                }
            } else {
                [high, below] = [part, rest];
            }
        }
        low
    }

    /// Closest points that are too near give no normal: moves the two apart to compute it.
    fn refined(
        &self,
        found: Meeting,
        met: f32,
        apart: f32,
        look: impl Fn(&Placed<'_>, Vec3) -> Option<Nearby>,
    ) -> Meeting {
        if found.fraction <= 0.0 {
            return found;
        }
        let (now, off) = (self.at(found.fraction), self.placed.sliding.shift(met));
        let here = Placed { pose: &now, ..*self.placed };
        let mut found = found;
        for _ in 0..2 {
            let Some(near) = look(&here, off + found.normal * apart) else { break };
            found = Meeting { point: near.point_a, normal: near.normal, ..found };
        }
        found
    }

    /// Returns the first hit of B on a triangle.
    fn meet_triangle(&self, mesh: &Mesh) -> Option<Meeting> {
        let placed = self.placed;
        let at = placed.pose.position;
        let around = Aabb::new(at, at).grown(self.reach + self.radius + placed.met(placed.size));
        let (delta, limit) = (self.course.delta, self.course.limit);
        first_triangle(mesh, &around, delta, limit, |pack, lane, limit| {
            let corners = pack.triangle(lane);
            let set = flat(corners);
            let met = placed.met(set.size + set.center.length());
            let look = |b: &Placed<'_>, shift| b.nearby(&set, shift);
            let touch = || Some(placed.above_triangle(pack.normal(lane), corners[0]));
            let found = self.advance(met, limit, look, touch)?;
            Some(self.refined(found, met, placed.apart(&set), look))
        })
    }
}
