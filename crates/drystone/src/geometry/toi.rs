//! Time of impact of two moving solids within a step, and whether one ends deep in the other or
//! past it.
//!
//! Conservative advancement [Mirtich96] of both at once. Along the normal of their closest points
//! the two approach no faster than their middles do, plus the speed that their rotations give their
//! farthest points. The time to close the distance is therefore at least the distance over that
//! speed. Then the closest points are computed again.

use super::approach;
use super::collide::convex::Convex;
use super::solid::{Core, Solid};
use crate::base::math::{Vec3, greater, lesser};
use crate::base::pose::Pose;
use crate::base::quat::Quat;

/// Motion of a center of mass in a step: straight, while the body turns evenly.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion {
    /// Pose at the start [world].
    from: Pose,
    /// Displacement [m] and rotation vector [rad].
    shift: Vec3,
    turn: Vec3,
}

impl Motion {
    pub(crate) const fn standing(at: Pose) -> Self {
        Self { from: at, shift: Vec3::ZERO, turn: Vec3::ZERO }
    }

    /// `spin` is the approximate rotation [rad]: two poses do not show whole turns.
    pub(crate) fn between(from: Pose, to: &Pose, spin: Vec3) -> Self {
        let shift = to.position - from.position;
        let turn = (to.rotation * from.rotation.conjugate()).to_rotation_vector();
        if spin.length() < 2.0 {
            return Self { from, shift, turn };
        }
        let axis = turn.try_normalize().or_else(|| spin.try_normalize()).unwrap_or(Vec3::X);
        let whole = 2.0 * core::f32::consts::PI;
        // Above a million turns the step is meaningless.
        let turns = ((axis.dot(spin) - axis.dot(turn)) / whole).clamp(-1.0e6, 1.0e6).round();
        Self { from, shift, turn: turn + axis * (turns * whole) }
    }

    pub(crate) const fn shift(&self) -> Vec3 {
        self.shift
    }

    /// Pose after a fraction of the motion.
    pub(crate) fn at(&self, part: f32) -> Pose {
        let Pose { position, rotation } = self.from;
        let turns = self.turn != Vec3::ZERO;
        let rotation = if turns { rotation.turned_by(self.turn * part) } else { rotation };
        Pose { position: position + self.shift * part, rotation }
    }
}

/// A moving solid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mover<'a> {
    solid: &'a Solid,
    /// Pose of the solid [frame of the center of mass].
    centered: Pose,
    motion: Motion,
    /// Half of its minimum thickness [m]; infinite for a surface without an inside, so that the
    /// other solid decides.
    half: f32,
    /// Its middle [frame of the center of mass], and the maximum distance of its points from there
    /// [m].
    middle: Vec3,
    size: f32,
    /// Maximum displacement of its points relative to its middle, due to the rotation [m].
    swing: f32,
    /// Maximum change of its middle's velocity, due to the rotation [m].
    bend: f32,
}

impl<'a> Mover<'a> {
    pub(crate) fn new(solid: &'a Solid, centered: Pose, mut motion: Motion) -> Self {
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
        motion.turn = seen_turn(solid, &centered, &motion);
        let turn = motion.turn.length();
        // The rounding moves as the core does: a ball that turns in place does not move.
        let swing = turn * (size - solid.radius).max(0.0);
        let bend = turn * turn * middle.length();
        Self { solid, centered, motion, half, middle, size, swing, bend }
    }

    /// Velocity of its middle after a fraction of the motion [m per motion].
    fn velocity(&self, part: f32) -> Vec3 {
        let Motion { shift, turn, .. } = self.motion;
        if self.bend > 0.0 {
            shift + turn.cross(self.motion.at(part).direction(self.middle))
        } else {
            shift
        }
    }

    /// Motion of its body, without rotations that leave the solid unchanged.
    pub(crate) const fn motion(&self) -> &Motion {
        &self.motion
    }

    fn at(&self, part: f32) -> Pose {
        self.motion.at(part).compose(&self.centered)
    }

    /// Extent of the solid from `origin` along a direction [m]; `None` for a surface.
    fn reach(&self, pose: &Pose, origin: Vec3, direction: Vec3) -> Option<f32> {
        let seen = pose.local_direction(direction);
        let tip = pose.direction(Convex::of(&self.solid.core)?.support(seen));
        Some(direction.dot(pose.position - origin) + direction.dot(tip) + self.solid.radius)
    }

    /// Its middle at the start and at the end of the motion.
    fn middles(&self) -> [Vec3; 2] {
        [self.motion.at(0.0).point(self.middle), self.motion.at(1.0).point(self.middle)]
    }
}

/// Removes the part of the rotation that leaves the solid unchanged: for a ball about its center,
/// all of it; for a wheel, the part about the axle.
fn seen_turn(solid: &Solid, centered: &Pose, motion: &Motion) -> Vec3 {
    let axis = centered.direction(Vec3::Y);
    let off = centered.position - axis * centered.position.dot(axis);
    match solid.core {
        Core::Point if centered.position == Vec3::ZERO => Vec3::ZERO,
        Core::Segment { .. } | Core::Frustum { .. } if off.length_squared() <= 0.0 => {
            let axis = motion.from.direction(axis);
            // A rotation about another axis as well moves the axle.
            let along = axis * motion.turn.dot(axis);
            let across = motion.turn - along;
            if across.length() <= WOBBLE * along.length() { across } else { motion.turn }
        }
        _ => motion.turn,
    }
}

/// Maximum rotation across the axle, relative to that about the axle, for a solid to count as a
/// wheel.
const WOBBLE: f32 = 0.02;

/// Outcome of a step for two solids.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Course {
    /// They end apart, or no deeper in each other than contacts can handle.
    Clear,
    /// They overlap from the start.
    Overlap,
    /// They meet after this fraction of the motion, and end deep in each other or past each other.
    Deep(f32),
}

/// Allowed overlap at the end, as a fraction of the thinner solid's half thickness. Up to twice
/// that, for two thin solids, a contact still determines on which side the other one is.
const SHALLOW: f32 = 1.0;

/// Gap at which the two are stopped, as a fraction of the half thickness. A contact stops solids
/// with a gap at once, and overlapping ones softly.
const APART: f32 = 0.05;

/// Rounding error of distances, relative to the sizes: some roundings of f32.
const ROUNDING: f32 = 4.0e-6;

/// Maximum rotation of one piece [rad]; larger rotations are processed piece by piece. After more
/// rotation, a plane between the two no longer bounds where they are.
const PIECE: f32 = 0.5;

/// Maximum number of pieces. A solid that turns 16 rad in a step is as good as a disc.
const PIECES: u16 = 32;

/// Maximum number of advancement steps. Typical pairs take two to ten, grazing ones thirty; a
/// search that takes longer has reached the surface.
const MAX_STEPS: usize = 32;

/// The closest points at some time.
struct Seen {
    distance: f32,
    /// Normal from A to B [world].
    normal: Vec3,
    /// Closest point on A [its frame].
    point: Vec3,
}

/// Two moving solids. If one has no inside, it is A.
pub(crate) struct Pair<'a> {
    a: Mover<'a>,
    b: Mover<'a>,
    rounding: f32,
    /// Whether both can be pushed, and move relative to each other by less than the size of the
    /// smaller one. Such bodies may lean and slide.
    leans: bool,
}

impl<'a> Pair<'a> {
    pub(crate) fn new(a: Mover<'a>, b: Mover<'a>) -> Self {
        let (a, b) = if b.solid.is_surface() { (b, a) } else { (a, b) };
        let rounding = ROUNDING * (a.size + b.size);
        Self { a, b, rounding, leans: false }
    }

    /// Sets whether both bodies can be pushed.
    pub(crate) fn yielding(self, yields: bool) -> Self {
        let motion = self.b.motion.shift() - self.a.motion.shift();
        let leans = yields && motion.length() < lesser(self.a.size, self.b.size);
        Self { leans, ..self }
    }

    /// Returns the velocity of B's middle relative to A's after a fraction of the motion. Also
    /// returns an upper bound on the extra speed at which any two points may approach from there to
    /// `end`.
    fn speeds(&self, [at, end]: [f32; 2]) -> (Vec3, f32) {
        let bend = (self.a.bend + self.b.bend) * (end - at);
        (self.b.velocity(at) - self.a.velocity(at), self.a.swing + self.b.swing + bend)
    }

    /// Maximum relative displacement of points of both, on a part of the motion [m].
    fn max_displacement(&self, [at, end]: [f32; 2]) -> f32 {
        let (moves, turns) = self.speeds([at, end]);
        (moves.length() + turns) * (end - at)
    }

    /// Maximum approach speed along a normal [m per motion].
    fn closing(&self, normal: Vec3, times: [f32; 2]) -> f32 {
        let (moves, turns) = self.speeds(times);
        turns - normal.dot(moves)
    }

    /// The smaller of both half thicknesses [m].
    fn half(&self) -> f32 {
        lesser(self.a.half, self.b.half)
    }

    /// Returns true if the motion is so small that solids apart at the start overlap at the end no
    /// more than contacts can handle, and no more than `minimum` [m].
    pub(crate) fn hardly_moves(&self, minimum: f32) -> bool {
        self.max_displacement([0.0, 1.0]) <= lesser(SHALLOW * self.half(), minimum)
    }

    /// Returns false if they pass each other at a distance.
    pub(crate) fn may_meet(&self) -> bool {
        if self.a.solid.is_surface() {
            return true;
        }
        let ([a, a_end], [b, b_end]) = (self.a.middles(), self.b.middles());
        let (apart, motion) = (b - a, (b_end - b) - (a_end - a));
        let nearest = -apart.dot(motion) / greater(motion.dot(motion), f32::MIN_POSITIVE);
        let minimum = (apart + motion * nearest.clamp(0.0, 1.0)).length();
        // A middle that is off the center of mass leaves its straight path by at most an eighth of
        // its bend.
        minimum <= self.a.size + self.b.size + 0.125 * (self.a.bend + self.b.bend)
    }

    /// Computes the outcome of the step.
    pub(crate) fn course(&self) -> Course {
        let turn = greater(self.a.motion.turn.length(), self.b.motion.turn.length());
        let wanted = (turn / PIECE).clamp(0.0, f32::from(PIECES));
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in range")]
        let pieces = (wanted as u16).clamp(1, PIECES);
        let part = |piece: u16| f32::from(piece) / f32::from(pieces);
        for piece in 0..pieces {
            match self.course_between([part(piece), part(piece + 1)]) {
                Course::Clear => {}
                // An overlap that an earlier piece left is no deeper than contacts can handle.
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
        let maximum = self.max_displacement([start, end]);
        let near = greater(APART * self.half(), self.rounding);
        let Some(mut seen) = self.look(start, maximum + 2.0 * near) else { return Course::Clear };
        if seen.distance <= 0.0 {
            return Course::Overlap;
        }
        let near = lesser(near, 0.5 * seen.distance);
        let mut at = start;
        for _ in 0..MAX_STEPS {
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

    /// Returns true if one enters the other during the motion, at any depth. Closest points that
    /// are too near give no normal. If the two only touch, at the start or the end, the test is
    /// therefore whether they overlap a moment later or earlier.
    pub(crate) fn enters(&self) -> bool {
        let maximum = self.max_displacement([0.0, 1.0]);
        let Some(mut seen) = self.look(0.0, maximum + self.rounding) else { return false };
        let moment = lesser(4.0 * self.rounding / maximum, 0.5);
        if seen.distance <= self.rounding {
            return self.is_inside(moment);
        }
        let mut at = 0.0;
        for _ in 0..2 * MAX_STEPS {
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

    /// Returns the closest points after a fraction of the motion, if they are no farther apart than
    /// `reach` [m].
    fn look(&self, part: f32, reach: f32) -> Option<Seen> {
        let (pose_a, pose_b) = (self.a.at(part), self.b.at(part));
        let b_in_a = pose_a.relative(&pose_b);
        let near = approach::closest(self.a.solid, self.b.solid, &b_in_a, reach)?;
        let normal = pose_a.direction(near.normal);
        Some(Seen { distance: near.distance, normal, point: near.point_a })
    }

    /// Returns true if the two end on the wrong sides of the plane that was between them. If they
    /// lean, the plane is tested with the rotation of either one, since it may belong to a face of
    /// either. Otherwise it stays fixed: a wall does not turn, and a flying body must not pass it.
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
        let turned = |motion: &Motion| {
            let turn = motion.turn * (later - before);
            turn == Vec3::ZERO || is_behind(Quat::from_rotation_vector(turn).rotate(seen.normal))
        };
        is_behind(seen.normal) && (!self.leans || turned(&self.a.motion) && turned(&self.b.motion))
    }
}
