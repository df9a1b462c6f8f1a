//! When two solids that move first meet within a step, and whether one is deep in the other, or past it, at the end.
//!
//! Conservative advancement [Mirtich96] of both at once: along the normal of their closest points the two come together no
//! faster than their middles do, and as their turns move their farthest points against these. The time in which the distance is
//! crossed is no less than the distance over that speed. Then the two are looked at again.

use super::approach;
use super::collide::convex::Convex;
use super::solid::{Core, Solid};
use crate::base::math::{Vec3, greater, lesser};
use crate::base::pose::Pose;
use crate::base::quat::Quat;

/// How a center of mass moves in a step: straight, while the body turns evenly.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    /// At the start [world].
    from: Pose,
    /// By how much it moves [m], and turns [rad].
    shift: Vec3,
    turn: Vec3,
}

impl Way {
    pub(crate) const fn standing(at: Pose) -> Self {
        Self { from: at, shift: Vec3::ZERO, turn: Vec3::ZERO }
    }

    /// `spin`: about how far it turned [rad]; two poses tell no whole turns.
    pub(crate) fn between(from: Pose, to: &Pose, spin: Vec3) -> Self {
        let shift = to.position - from.position;
        let turn = (to.rotation * from.rotation.conjugate()).to_rotation_vector();
        if spin.length() < 2.0 {
            return Self { from, shift, turn };
        }
        let axis = turn.try_normalize().or_else(|| spin.try_normalize()).unwrap_or(Vec3::X);
        let whole = 2.0 * core::f32::consts::PI;
        // Beyond a million turns a step says nothing.
        let turns = ((axis.dot(spin) - axis.dot(turn)) / whole).clamp(-1.0e6, 1.0e6).round();
        Self { from, shift, turn: turn + axis * (turns * whole) }
    }

    pub(crate) const fn shift(&self) -> Vec3 {
        self.shift
    }

    /// Where it is after this part of the way.
    pub(crate) fn at(&self, part: f32) -> Pose {
        let Pose { position, rotation } = self.from;
        let turns = self.turn != Vec3::ZERO;
        let rotation = if turns { rotation.turned_by(self.turn * part) } else { rotation };
        Pose { position: position + self.shift * part, rotation }
    }
}

/// A solid on its way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mover<'a> {
    solid: &'a Solid,
    /// Where it sits [frame of the center of mass].
    centered: Pose,
    way: Way,
    /// Half of its least thickness [m]; of a surface without an inside infinite: the other's tells.
    half: f32,
    /// Its middle [frame of the center of mass], and the greatest distance of its points from there [m].
    middle: Vec3,
    size: f32,
    /// The turn moves its points by no more than this against its middle [m].
    swing: f32,
    /// By how much it changes the velocity of its middle [m].
    bend: f32,
}

impl<'a> Mover<'a> {
    pub(crate) fn new(solid: &'a Solid, centered: Pose, mut way: Way) -> Self {
        let (middle, half, size) = match &solid.core {
            Core::HalfSpace { .. } => (Vec3::ZERO, f32::INFINITY, 0.0),
            Core::Mesh(mesh) => {
                let around = mesh.bounds();
                (around.center(), f32::INFINITY, around.half_extents().length())
            }
            _ => {
                let (middle, size) = solid.ball();
                let half = solid.core_box().half_extents().min_element() + solid.radius;
                (middle, half, size)
            }
        };
        let middle = centered.point(middle);
        way.turn = seen_turn(solid, &centered, &way);
        let turn = way.turn.length();
        // The rounding moves as the core does: a ball that turns stays where it is.
        let swing = turn * (size - solid.radius).max(0.0);
        let bend = turn * turn * middle.length();
        Self { solid, centered, way, half, middle, size, swing, bend }
    }

    /// Velocity of its middle after a part of the way [m per way].
    fn velocity(&self, part: f32) -> Vec3 {
        let Way { shift, turn, .. } = self.way;
        if self.bend > 0.0 {
            shift + turn.cross(self.way.at(part).direction(self.middle))
        } else {
            shift
        }
    }

    /// Its body's way, but for turns that nobody sees.
    pub(crate) const fn way(&self) -> &Way {
        &self.way
    }

    fn at(&self, part: f32) -> Pose {
        self.way.at(part).compose(&self.centered)
    }

    /// How far it reaches from `origin` along a direction [m]; `None` of a surface.
    fn reach(&self, pose: &Pose, origin: Vec3, direction: Vec3) -> Option<f32> {
        let seen = pose.local_direction(direction);
        let tip = pose.direction(Convex::of(&self.solid.core)?.support(seen));
        Some(direction.dot(pose.position - origin) + direction.dot(tip) + self.solid.radius)
    }

    /// Its middle now, and after the whole way.
    fn middles(&self) -> [Vec3; 2] {
        [self.way.at(0.0).point(self.middle), self.way.at(1.0).point(self.middle)]
    }
}

/// What is left of a turn when that is taken out which leaves every point of the solid on its surface: of a ball about its
/// center all, of a wheel about its axle that about the axle.
fn seen_turn(solid: &Solid, centered: &Pose, way: &Way) -> Vec3 {
    let axis = centered.direction(Vec3::Y);
    let off = centered.position - axis * centered.position.dot(axis);
    match solid.core {
        Core::Point if centered.position == Vec3::ZERO => Vec3::ZERO,
        Core::Segment { .. } | Core::Frustum { .. } if off.length_squared() <= 0.0 => {
            let axis = way.from.direction(axis);
            // A turn about another axis as well takes the axle with it.
            let along = axis * way.turn.dot(axis);
            let across = way.turn - along;
            if across.length() <= WOBBLE * along.length() { across } else { way.turn }
        }
        _ => way.turn,
    }
}

/// A wheel turns about its axle if it does so about nothing else by more than this part.
const WOBBLE: f32 = 0.02;

/// What becomes of two solids in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Course {
    /// They end apart, or no deeper in each other than contacts bear.
    Clear,
    /// They overlap from the start.
    Overlap,
    /// They meet after this part of the way, and end deep in each other or past each other.
    Deep(f32),
}

/// They may be as deep in each other at the end as this part of the thinner one's half thickness: up to twice that, both
/// thin, a contact knows on which side the other is.
const SHALLOW: f32 = 1.0;

/// They are stopped as far apart as this part of it: what is apart is stopped by a contact at once, what overlaps softly.
const APART: f32 = 0.05;

/// Distances are known to this part of the sizes: some roundings of f32.
const ROUNDING: f32 = 4.0e-6;

/// What turns farther is looked at piece by piece [rad]: a plane between the two says nothing of where they are after more.
const PIECE: f32 = 0.5;

/// At most so many. What turns 16 rad in a step is as good as a disc.
const PIECES: u16 = 32;

/// Steps of an advancement. Two to ten, thirty of what grazes; what takes longer has come to the surface.
const ROUNDS: usize = 32;

/// The closest points at some time.
struct Seen {
    distance: f32,
    /// From A to B [world].
    normal: Vec3,
    /// On A [its frame].
    point: Vec3,
}

/// Two solids on their ways. A is the one that has no inside, if one has none.
pub(crate) struct Pair<'a> {
    a: Mover<'a>,
    b: Mover<'a>,
    rounding: f32,
    /// Both can be pushed, and move against each other by less than the size of the smaller one. Such bodies may lean and slide.
    leans: bool,
}

impl<'a> Pair<'a> {
    pub(crate) fn new(a: Mover<'a>, b: Mover<'a>) -> Self {
        let (a, b) = if b.solid.is_surface() { (b, a) } else { (a, b) };
        let rounding = ROUNDING * (a.size + b.size);
        Self { a, b, rounding, leans: false }
    }

    /// The same of two that can be pushed both, or not.
    pub(crate) fn yielding(self, yields: bool) -> Self {
        let way = self.b.way.shift() - self.a.way.shift();
        let leans = yields && way.length() < lesser(self.a.size, self.b.size);
        Self { leans, ..self }
    }

    /// How fast B's middle moves against A's after a part of the way, and how much faster any two points of both may come together
    /// from there to `end`.
    fn speeds(&self, [at, end]: [f32; 2]) -> (Vec3, f32) {
        let bend = (self.a.bend + self.b.bend) * (end - at);
        (self.b.velocity(at) - self.a.velocity(at), self.a.swing + self.b.swing + bend)
    }

    /// How far points of both move against each other at most, on a part of the way [m].
    fn most(&self, [at, end]: [f32; 2]) -> f32 {
        let (moves, turns) = self.speeds([at, end]);
        (moves.length() + turns) * (end - at)
    }

    /// How fast the two come together at most along a normal [m per way].
    fn closing(&self, normal: Vec3, times: [f32; 2]) -> f32 {
        let (moves, turns) = self.speeds(times);
        turns - normal.dot(moves)
    }

    /// Half of the least thickness of both [m].
    fn half(&self) -> f32 {
        lesser(self.a.half, self.b.half)
    }

    /// True if they move so little that who is apart at the start is no deeper at the end than contacts bear, and no deeper than
    /// `least` [m].
    pub(crate) fn hardly_moves(&self, least: f32) -> bool {
        self.most([0.0, 1.0]) <= lesser(SHALLOW * self.half(), least)
    }

    /// False if they pass each other wide.
    pub(crate) fn may_meet(&self) -> bool {
        if self.a.solid.is_surface() {
            return true;
        }
        let ([a, a_end], [b, b_end]) = (self.a.middles(), self.b.middles());
        let (apart, way) = (b - a, (b_end - b) - (a_end - a));
        let nearest = -apart.dot(way) / greater(way.dot(way), f32::MIN_POSITIVE);
        let least = (apart + way * nearest.clamp(0.0, 1.0)).length();
        // Middles that are off the center of mass leave their straight ways by an eighth of what these bend, at most.
        least <= self.a.size + self.b.size + 0.125 * (self.a.bend + self.b.bend)
    }

    /// What becomes of them.
    pub(crate) fn course(&self) -> Course {
        let turn = greater(self.a.way.turn.length(), self.b.way.turn.length());
        let wanted = (turn / PIECE).clamp(0.0, f32::from(PIECES));
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in range")]
        let pieces = (wanted as u16).clamp(1, PIECES);
        let part = |piece: u16| f32::from(piece) / f32::from(pieces);
        for piece in 0..pieces {
            match self.course_between([part(piece), part(piece + 1)]) {
                Course::Clear => {}
                // What a piece before left is no deeper than contacts bear.
                Course::Overlap if piece > 0 => {
                    if let Some(seen) = self.look(part(piece), 0.0)
                        && self.is_deep(&seen, [part(piece), part(piece + 1)])
                    {
                        return Course::Deep(part(piece));
                    }
                }
                met => return met,
            }
        }
        Course::Clear
    }

    fn course_between(&self, [start, end]: [f32; 2]) -> Course {
        let most = self.most([start, end]);
        let near = greater(APART * self.half(), self.rounding);
        let Some(mut seen) = self.look(start, most + 2.0 * near) else { return Course::Clear };
        if seen.distance <= 0.0 {
            return Course::Overlap;
        }
        let near = lesser(near, 0.5 * seen.distance);
        let mut at = start;
        for _ in 0..ROUNDS {
            if seen.distance <= 1.5 * near {
                break;
            }
            let closing = self.closing(seen.normal, [at, end]);
            if !(closing > 0.0) {
                return Course::Clear;
            }
            let next = at + (seen.distance - near) / closing;
            if !(next < end) {
                return Course::Clear;
            }
            let Some(then) = self.look(next, f32::MAX) else { return Course::Clear };
            if then.distance <= 0.0 {
                break;
            }
            (at, seen) = (next, then);
        }
        if self.is_deep(&seen, [at, end]) { Course::Deep(at) } else { Course::Clear }
    }

    /// True if one comes into the other on the way, deep or not. Who only touches at the start or at the end does so if it is
    /// inside a moment later, or was a moment before: closest points that near tell no normal.
    pub(crate) fn enters(&self) -> bool {
        let most = self.most([0.0, 1.0]);
        let Some(mut seen) = self.look(0.0, most + self.rounding) else { return false };
        let moment = lesser(4.0 * self.rounding / most, 0.5);
        if seen.distance <= self.rounding {
            return self.is_inside(moment);
        }
        let mut at = 0.0;
        for _ in 0..2 * ROUNDS {
            let closing = self.closing(seen.normal, [at, 1.0]);
            at += (seen.distance - 0.5 * self.rounding) / closing;
            if !(closing > 0.0 && at < 1.0) {
                return false;
            }
            let Some(then) = self.look(at, f32::MAX) else { return false };
            if then.distance <= self.rounding {
                return at < 1.0 - moment || self.is_inside(1.0 - moment);
            }
            seen = then;
        }
        false
    }

    fn is_inside(&self, part: f32) -> bool {
        self.look(part, 0.0).is_some_and(|seen| seen.distance < 0.0)
    }

    /// The closest points after a part of the way, if they are no farther apart than `reach` [m].
    fn look(&self, part: f32, reach: f32) -> Option<Seen> {
        let (pose_a, pose_b) = (self.a.at(part), self.b.at(part));
        let b_in_a = pose_a.relative(&pose_b);
        let near = approach::closest(self.a.solid, self.b.solid, &b_in_a, reach)?;
        let normal = pose_a.direction(near.normal);
        Some(Seen { distance: near.distance, normal, point: near.point_a })
    }

    /// True if the two end on the wrong sides of the plane that was between them. Of two that lean the plane turns with either one,
    /// since it is not known whose face it is. Of others it stays: a wall does not turn, and what flies must not pass it.
    fn is_deep(&self, seen: &Seen, [before, later]: [f32; 2]) -> bool {
        let (pose_a, pose_b) = (self.a.at(later), self.b.at(later));
        let origin = pose_b.position;
        let limit = greater(SHALLOW * self.half(), 4.0 * self.rounding);
        let is_behind = |n: Vec3| {
            let of_surface = || n.dot(pose_a.point(seen.point) - origin);
            let high = self.a.reach(&pose_a, origin, n).unwrap_or_else(of_surface);
            let low = self.b.reach(&pose_b, origin, -n).unwrap_or(0.0);
            high + low > limit
        };
        let turned = |way: &Way| {
            let turn = way.turn * (later - before);
            turn == Vec3::ZERO || is_behind(Quat::from_rotation_vector(turn).rotate(seen.normal))
        };
        is_behind(seen.normal) && (!self.leans || turned(&self.a.way) && turned(&self.b.way))
    }
}
