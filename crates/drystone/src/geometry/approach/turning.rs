//! How far a convex solid can go while it turns, before it meets another one.
//!
//! Conservative advancement as in the parent module. A plane between the two at their closest points has a fixed normal n. With r the
//! points of B about the origin of its frame, w its turn and v its way, the heights of B's points over the plane after the part t
//! from here are
//!
//! ```text
//! n·(x + v t) + r·(n + t n×w) + e,   |e| <= ½ |n×w| |w| |r| t²
//! ```
//!
//! for the second derivative of a point's height is (n×w)·(w×r). The least of them over B is that of one support point along n + t n×w: a bound
//! that is exact to the first order, and concave in t. So the parts of the way on which it says that B stays above the plane are
//! an interval, whose end is found by chords and halving. Near a meeting the steps become shorter as the square of the gap.

use super::{ALONG, Course, Meeting, Nearby, Placed, convex_set, deepest, first_triangle, flat};
use crate::base::aabb::Aabb;
use crate::base::math::{Vec3, greater};
use crate::base::pose::Pose;
use crate::geometry::collide::convex::Convex;
use crate::geometry::mesh::Mesh;
use crate::geometry::solid::{Core, Solid};

/// Steps of an advancement, and as many more for each radian: along a surface at a constant gap, a step turns by the root of
/// twice the gap over the size. A cast that takes longer counts as met where it has come to.
const ROUNDS: f32 = 64.0;

/// Rounds of the search for the length of a step: it need not be exact.
const ROUNDS_OF_STEP: usize = 12;

/// Where B, turning on its course, first meets A.
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

/// B on its course.
struct Turning<'a> {
    placed: &'a Placed<'a>,
    course: &'a Course,
    /// Greatest distance of a point of its core from the origin of its frame [m].
    reach: f32,
    radius: f32,
    rounds: usize,
}

impl<'a> Turning<'a> {
    fn new(b: &Solid, placed: &'a Placed<'a>, course: &'a Course) -> Self {
        let reach = greater(b.max_extent(Vec3::ZERO) - b.radius, 0.0);
        let rounds = (ROUNDS * (1.0 + course.turn.length())).clamp(ROUNDS, 200.0 * ROUNDS);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in range")]
        let rounds = rounds as usize;
        Self { placed, course, reach, radius: b.radius, rounds }
    }

    /// Where B's frame is after a part of the way.
    fn at(&self, part: f32) -> Pose {
        let Pose { position, rotation } = *self.placed.pose;
        let Course { delta, turn, .. } = *self.course;
        Pose { position: position + delta * part, rotation: rotation.turned_by(turn * part) }
    }

    /// `look` gives the closest points of A and of B, moved by a shift; `touch` says how the two touch or overlap at the start, if
    /// they do.
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
            // It leaves what it touches.
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
            // The end of the whole way exactly, and steps that do not depend on the limit.
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

    /// True if the point of B that touches moves into A, by more than some roundings.
    fn comes_closer(&self, deep: &Nearby) -> bool {
        let Course { delta, turn, .. } = *self.course;
        let arm = deep.point_b - self.placed.pose.position;
        let speed = delta.length() + turn.length() * self.reach;
        deep.normal.dot(delta + turn.cross(arm)) < -ALONG * speed
    }

    /// A part of the way, at most `most`, in which B does not come closer to a plane by more than `gap` [m], however it turns: close
    /// to the greatest that the bound of the module allows.
    fn step(&self, now: &Pose, normal: Vec3, gap: f32, most: f32) -> f32 {
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
        if clear(most) >= 0.0 {
            return most;
        }
        let ([mut low, mut above], [mut high, mut below]) = ([0.0, gap], [most, clear(most)]);
        for round in 0..ROUNDS_OF_STEP {
            // A chord of a concave function is below it: where it comes to zero is no farther than the end.
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

    /// Closest points that near tell no normal: for it the two are moved apart.
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

    /// The first triangle that B meets.
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
