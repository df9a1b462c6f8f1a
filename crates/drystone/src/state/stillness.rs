//! Stillness: what tells of a body that is slow whether it rests, or has only begun to move, or moves on without end.
//!
//! Speed alone does not tell: what starts from rest is slow under any force, and so is a ball at the turning point of
//! its way. While a body is slow, its pose is marked three times at equal distances in time. Two ways follow from
//! those, the first and the second, and from their difference the mean acceleration: a body rests if that is small
//! against the forces that its supports balance, and if both ways together are small against its size. Displacements
//! are used, not velocities: jitter moves nothing far, however fast it is
//! (docs/decisions/030-what-may-sleep.md).

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::bodies::Body;
use super::config::SleepConfig;
use crate::base::limits::{self, TIME_STEP};
use crate::base::math::{Vec3, bounded, vec3};
use crate::base::quat::Quat;

/// Part of the forces on a body that its supports may leave over: what begins to move under less is not seen. It is a
/// slope of 0.06 degrees, and loads of a balance that differ by a five-hundredth.
const BALANCE: f32 = 1.0e-3;

/// Part of its size by which a body may move between three marks and rest: creep of what is supported. Limbs of ragdolls
/// that lie creep by up to 0.07 (with 0.05 they slept twice as late); what rolls so slowly comes nowhere by its size.
const CREEP: f32 = 0.1;

/// Part of its size by which a body that nothing touches may move in a second and rest: a hundredth in ten seconds.
/// There is no creep in free flight, so it is less than [`CREEP`].
const DRIFT: f32 = 1.0e-3;

/// By how much the acceleration that velocities show may differ from that which ways show, in parts of that. Under a
/// constant force they are the same, for a pole that topples they differ by 0.3; those of jitter have no relation.
const LASTS: f32 = 0.5;

/// Where marks are set: parts of the time of sleep. Before the first, what has just become slow settles; the third comes
/// at the end, and not after it whatever the rounding.
const LAG: f32 = 0.199;
const SPACING: f32 = 0.4;

/// Rounding of a pose, in parts of its numbers: positions are added up in some hundred substeps between two marks, each
/// rounded by 6e-8 at most, one way or the other.
const ROUNDING: f32 = 1.0e-6;

/// Longest time between two marks [s]. A step is the shortest, whatever rounding of long times says; and steps, of 10 s at
/// most, add nothing to a still time of 2^28 s.
const LONGEST: f32 = 1.0e9;

/// Where a body was at a time.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
struct Mark {
    center: Vec3,
    rotation: Quat,
    v: Vec3,
    w: Vec3,
    /// The still time [s].
    at: f32,
}

/// Way from a mark to another: of the center [m], and the turn [rad]. Or a mean velocity [m/s; rad/s].
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Way {
    pub(crate) moved: Vec3,
    pub(crate) turned: Vec3,
}

impl Way {
    fn between(from: &Mark, to: &Mark) -> Self {
        let q = to.rotation * from.rotation.conjugate();
        // What rests turns by little: twice the sine of half of it will do.
        let sign = if q.w < 0.0 { -2.0 } else { 2.0 };
        Self { moved: to.center - from.center, turned: vec3(q.x, q.y, q.z) * sign }
    }

    /// No point of a body of this size moved farther [m].
    pub(crate) fn length(&self, size: f32) -> f32 {
        self.moved.length() + self.turned.length() * size
    }

    fn scaled(&self, by: f32) -> Self {
        Self { moved: self.moved * by, turned: self.turned * by }
    }

    /// This one less `part` of another.
    fn less(&self, other: &Self, part: f32) -> Self {
        Self { moved: self.moved - other.moved * part, turned: self.turned - other.turned * part }
    }
}

/// What the last marks of a body said.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) enum Verdict {
    /// It rests, or has not been watched for long enough.
    #[default]
    Rests,
    /// It moves on: mean speed, and the greatest that is rest [m/s].
    Creeps(f32, f32),
    /// It begins to move or turns round: acceleration, and the greatest that is rest [m/s²].
    Sways(f32, f32),
}

/// What is known of the motion of a body that is slow.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Stillness {
    marks: [Mark; 2],
    /// How many marks were set since it became slow; more than two are as two.
    count: u32,
    /// Mean velocities on the last two ways.
    pub(crate) means: [Way; 2],
    pub(crate) verdict: Verdict,
}

/// When bodies are looked at, by the configuration and the length of a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StillnessRule {
    /// Gravity [m/s²].
    pub(crate) gravity: Vec3,
    /// Length of a typical body [m].
    pub(crate) length: f32,
    /// Speed of the configuration [m/s].
    pub(crate) speed: f32,
    /// Time until sleep [s].
    pub(crate) time: f32,
    /// Length of the step [s].
    pub(crate) dt: f32,
}

/// How much of the time of sleep there must be for three marks a step apart, in steps.
const LEAST_STEPS: f32 = 2.5;

impl SleepConfig {
    /// Time until sleep [s], long enough for the marks.
    pub(crate) fn wait(&self, dt: f32) -> f32 {
        self.time.max(LEAST_STEPS * dt)
    }
}

/// Acceleration that gravity and lasting forces would give a body that nothing holds [m/s²], and what it is the
/// balance of.
fn pull(gravity: Vec3, body: &Body) -> (Vec3, f32) {
    let (weight, push) = (gravity * body.gravity_scale, body.force * (1.0 / body.mass));
    let mut pull = weight + push;
    for i in 0..3 {
        if body.locks.linear[i] {
            pull[i] = 0.0;
        }
    }
    (pull, weight.length() + push.length())
}

/// Acceleration of a body in free flight [m/s²], of its fastest point; 0 where forces cancel but for their rounding.
pub(crate) fn free_acceleration(gravity: Vec3, body: &Body, length: f32) -> f32 {
    let (pull, of) = pull(gravity, body);
    let straight = pull.length();
    let turning = body.turn_by(body.torque).length() * size(body, length);
    let straight = if straight > ROUNDING * of { straight } else { 0.0 };
    straight + turning
}

/// Size of a body [m]; one without shapes counts as a typical one, of this length.
pub(crate) fn size(body: &Body, length: f32) -> f32 {
    if body.extent > 0.0 { body.extent } else { length }
}

/// Speed below which a body that nothing touches rests, however long it flies [m/s].
pub(crate) fn drift_speed(body: &Body, length: f32) -> f32 {
    DRIFT * size(body, length)
}

/// True if nothing can hold a body: no contact near it, no joint, no particle.
pub(crate) fn is_free(body: &Body) -> bool {
    body.constraints == 0 && !body.dragged
}

/// How far a pose may be off by rounding after some steps [m].
pub(crate) fn rounding(body: &Body, length: f32) -> f32 {
    ROUNDING * (body.center.abs().max_element() + size(body, length))
}

impl StillnessRule {
    /// How far apart marks are in time [s].
    pub(crate) fn spacing(&self) -> f32 {
        Self::spacing_of(self.time)
    }

    /// The same, where the time until sleep is this [s].
    pub(crate) const fn spacing_of(time: f32) -> f32 {
        SPACING * time
    }

    /// How many marks there should be.
    fn marks_at(&self, still_time: f32) -> f32 {
        let past = still_time - LAG * self.time;
        if past >= 0.0 { 1.0 + (past / self.spacing()).floor() } else { 0.0 }
    }

    /// True if a body is slow enough to be watched; whether it rests is said by its marks.
    pub(crate) fn is_slow(&self, body: &Body, by_speed: bool) -> bool {
        if !is_free(body) {
            return by_speed;
        }
        by_speed
            && free_acceleration(self.gravity, body, self.length) <= 0.0
            && body.greatest_speed(self.length) < drift_speed(body, self.length)
    }

    /// Counts a step in which a body was slow, or not.
    pub(crate) fn count(&self, slow: bool, body: &mut Body, known: &mut Stillness) {
        let before = body.still_time;
        if !slow {
            body.still_time = 0.0;
            return;
        }
        if before <= 0.0 {
            (known.count, known.verdict) = (0, Verdict::Rests);
        }
        body.still_time = before + self.dt;
        if self.marks_at(body.still_time) <= self.marks_at(before) {
            return;
        }
        let Body { center, rotation, v, w, still_time: at, .. } = *body;
        let here = Mark { center, rotation, v, w, at };
        let [first, second] = known.marks;
        let marks = known.count;
        known.marks = [second, here];
        known.count = (marks + 1).min(2);
        if marks < 2 {
            if body.still_time >= self.time {
                // The step grew longer meanwhile: one more mark is needed.
                let now = self.time - 0.5 * self.spacing();
                known.go_back(body.still_time - now);
                body.still_time = now;
            }
            return;
        }
        known.judge(self, [&first, &second, &here], body);
        if known.verdict != Verdict::Rests {
            // It is looked at again a mark later, a little less for rounding.
            let back = body.still_time - (LAG + 1.02 * SPACING) * self.time;
            known.go_back(back);
            body.still_time -= back;
        }
    }
}

impl Stillness {
    /// Marks are told from another origin [m].
    pub(crate) fn shift(&mut self, origin: Vec3) {
        self.marks.iter_mut().for_each(|mark| mark.center -= origin);
    }

    /// The still time goes back by so much [s], and marks with it: the times between them are what their ways took.
    pub(crate) fn go_back(&mut self, by: f32) {
        for mark in &mut self.marks {
            mark.at = bounded(mark.at - by);
        }
    }

    /// Says by three marks whether a body rests.
    fn judge(&mut self, rule: &StillnessRule, [first, second, here]: [&Mark; 3], body: &Body) {
        let size = size(body, rule.length);
        let times = [second.at - first.at, here.at - second.at];
        let times = times.map(|time| time.clamp(TIME_STEP.least, LONGEST));
        let [before, after] = [Way::between(first, second), Way::between(second, here)];
        let whole = Way::between(first, here).length(size);
        let per = times.map(|time| 1.0 / time);
        self.means = [before.scaled(per[0]), after.scaled(per[1])];
        let rounding = rounding(body, rule.length);
        let creep = CREEP * size + rounding;
        // What the second way is more than the first, had it taken as long: a τ².
        let sway = after.less(&before, times[1] * per[0]);
        // And what the velocities say of the second half: of jitter, another thing.
        let gain = Way { moved: here.v - second.v, turned: here.w - second.w };
        let apart = gain.scaled(times[0]).less(&sway, 1.0).length(size);
        let sway = sway.length(size);
        let lasts = apart <= LASTS * sway;
        let square = times[0] * times[1];
        let load = pull(rule.gravity, body).1 + body.load / body.mass;
        let most = BALANCE * load * square + rounding;
        self.verdict = if sway > most && lasts {
            Verdict::Sways(sway / square, most / square)
        } else if whole > creep {
            let time = times[0] + times[1];
            Verdict::Creeps(whole / time, creep / time)
        } else {
            Verdict::Rests
        };
    }

    /// True if its numbers can be: what is judged by them is a number then.
    pub(crate) fn is_sound(&self) -> bool {
        let numbers = match self.verdict {
            Verdict::Rests => [0.0; 2],
            Verdict::Creeps(is, most) | Verdict::Sways(is, most) => [is, most],
        };
        let marks = self.marks.iter().all(|mark| {
            let (far, fast) = (limits::POSITION_KEPT.most, limits::SPEED_KEPT.most);
            let placed = mark.center.is_below(far) && mark.rotation.is_normalized();
            placed && mark.v.is_below(fast) && mark.w.is_below(fast) && mark.at.is_finite()
        });
        let finite = |way: &Way| way.moved.is_finite() && way.turned.is_finite();
        let sound = marks && self.means.iter().all(finite);
        sound && self.count <= 2 && numbers.iter().all(|x| *x >= 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::{Stillness, Verdict};
    use crate::base::math::Vec3;

    #[test]
    fn marks_that_no_body_can_have_are_not_sound() {
        assert!(Stillness::default().is_sound());
        let changes: [fn(&mut Stillness); 7] = [
            |s| s.marks[0].center.x = 1.0e30,
            |s| s.marks[1].rotation.w = 1.0e20,
            |s| s.marks[1].v.y = f32::NAN,
            |s| s.marks[0].at = f32::INFINITY,
            |s| s.means[0].moved = Vec3::splat(f32::INFINITY),
            |s| s.count = 3,
            |s| s.verdict = Verdict::Creeps(-1.0, 1.0),
        ];
        for (i, change) in changes.into_iter().enumerate() {
            let mut known = Stillness::default();
            change(&mut known);
            assert!(!known.is_sound(), "{i}");
        }
    }
}
