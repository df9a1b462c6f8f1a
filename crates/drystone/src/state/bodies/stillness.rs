//! Stillness: decides whether a slow body is at rest, has only begun to move, or moves on
//! indefinitely.
//!
//! Speed alone is not enough. A body that starts from rest is slow under any force, and so is a
//! ball at the turning point of its path. While a body is slow, its pose is marked three times at
//! equal intervals. The marks give two displacements, and their difference gives the average
//! acceleration. The body is at rest if that acceleration is small against the forces that its
//! supports balance, and both displacements together are small against its size. Displacements are
//! used instead of velocities, because jitter displaces a body little, however fast it is
//! (docs/decisions/030-what-may-sleep.md).

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::body::{Body, Sleep};
use crate::base::limits::{self, TIME_STEP};
use crate::base::math::{Vec3, bounded, vec3};
use crate::base::quat::Quat;
use crate::state::def::config::SleepConfig;

/// Fraction of the forces on a body that its supports may leave unbalanced. A body that begins to
/// move under a smaller force is not detected. It corresponds to a slope of 0.06 degrees, and to
/// loads of a balance that differ by a five-hundredth.
const BALANCE: f32 = 1.0e-3;

/// Displacement between three marks below which a supported body is at rest, as a fraction of its
/// size: creep. Limbs of lying ragdolls creep by up to 0.07 (with 0.05 they slept twice as late). A
/// body that rolls this slowly does not get farther than its size.
const CREEP: f32 = 0.1;

/// Displacement per second below which a body without contacts is at rest, as a fraction of its
/// size: a hundredth in ten seconds. It is less than [`CREEP`], because nothing creeps in free
/// flight.
const DRIFT: f32 = 1.0e-3;

/// Maximum difference between the accelerations from velocities and from displacements, as a
/// fraction of the latter. Under a constant force they are equal, for a toppling pole they differ
/// by 0.3; for jitter they are unrelated.
const LASTS: f32 = 0.5;

/// Times of the marks, as fractions of the time until sleep. A body that has just become slow
/// settles before the first one. The third one comes at the end, and with rounding never after it.
const LAG: f32 = 0.199;
const SPACING: f32 = 0.4;

/// Rounding of a pose, relative to its numbers. Positions are sums over some hundred substeps
/// between two marks, each rounded by at most 6e-8 in either direction.
const ROUNDING: f32 = 1.0e-6;

/// Maximum time between two marks [s]. The minimum is a step, regardless of rounding of long times.
/// Steps of at most 10 s no longer change a still time of 2^28 s.
const LONGEST: f32 = 1.0e9;

/// The pose of a body at a time.
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

/// Displacement between two marks: of the center [m], and the rotation [rad]. Or an average
/// velocity [m/s; rad/s].
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Motion {
    pub(crate) moved: Vec3,
    pub(crate) turned: Vec3,
}

impl Motion {
    fn between(from: &Mark, to: &Mark) -> Self {
        let q = to.rotation * from.rotation.conjugate();
        // A body at rest rotates little, so twice the sine of the half angle suffices.
        let sign = if q.w < 0.0 { -2.0 } else { 2.0 };
        Self { moved: to.center - from.center, turned: vec3(q.x, q.y, q.z) * sign }
    }

    /// Upper bound on the displacement of any point of a body of this size [m].
    pub(crate) fn length(&self, size: f32) -> f32 {
        self.moved.length() + self.turned.length() * size
    }

    fn scaled(&self, by: f32) -> Self {
        Self { moved: self.moved * by, turned: self.turned * by }
    }

    /// This displacement minus `part` of another.
    fn less(&self, other: &Self, part: f32) -> Self {
        Self { moved: self.moved - other.moved * part, turned: self.turned - other.turned * part }
    }
}

/// The result of the last marks of a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) enum Verdict {
    /// It is at rest, or has not been watched for long enough.
    #[default]
    Rests,
    /// It moves on: average speed, and the maximum speed at rest [m/s].
    Creeps(f32, f32),
    /// It begins to move, or reverses: acceleration, and the maximum acceleration at rest [m/s²].
    Sways(f32, f32),
}

/// The motion of a slow body.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Stillness {
    marks: [Mark; 2],
    /// Number of marks since it became slow; values above two count as two.
    count: u32,
    /// Average velocities over the last two displacements.
    pub(crate) means: [Motion; 2],
    pub(crate) verdict: Verdict,
}

/// The times and thresholds for marks, from the configuration and the length of a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StillnessRule {
    /// Gravity [m/s²].
    pub(crate) gravity: Vec3,
    /// Length of a typical body [m].
    pub(crate) length: f32,
    /// Sleep speed of the configuration [m/s].
    pub(crate) speed: f32,
    /// Time until sleep [s].
    pub(crate) time: f32,
    /// Length of the step [s].
    pub(crate) dt: f32,
}

/// Minimum time until sleep for three marks one step apart, in steps.
const MIN_STEPS: f32 = 2.5;

impl SleepConfig {
    /// Time until sleep [s], long enough for the marks.
    pub(crate) fn wait(&self, dt: f32) -> f32 {
        self.time.max(MIN_STEPS * dt)
    }
}

/// Acceleration of an unsupported body by gravity and lasting forces [m/s²], and the sum of the
/// magnitudes that it is the balance of.
fn pull(gravity: Vec3, body: &Body) -> (Vec3, f32) {
    let (weight, push) =
        (gravity * body.forces.gravity_scale, body.forces.force * (1.0 / body.inertia.mass));
    let mut pull = weight + push;
    for i in 0..3 {
        if body.inertia.locks.linear[i] {
            pull[i] = 0.0;
        }
    }
    (pull, weight.length() + push.length())
}

/// Acceleration of the fastest point of a body in free flight [m/s²]; 0 if the forces cancel up to
/// rounding.
pub(crate) fn free_acceleration(gravity: Vec3, body: &Body, length: f32) -> f32 {
    let (pull, of) = pull(gravity, body);
    let straight = pull.length();
    let turning = body.turn_by(body.forces.torque).length() * size(body, length);
    let straight = if straight > ROUNDING * of { straight } else { 0.0 };
    straight + turning
}

/// Size of a body [m]; a body without shapes has this typical length.
pub(crate) fn size(body: &Body, length: f32) -> f32 {
    if body.extent > 0.0 { body.extent } else { length }
}

/// Speed below which a body without contacts is at rest, however long it flies [m/s].
pub(crate) fn drift_speed(body: &Body, length: f32) -> f32 {
    DRIFT * size(body, length)
}

/// True if nothing can hold a body: it has no contact nearby, no joint and no particle.
pub(crate) fn is_free(body: &Body) -> bool {
    body.ties.constraints == 0 && !body.record.dragged
}

/// Maximum error of a pose by rounding after some steps [m].
pub(crate) fn rounding(body: &Body, length: f32) -> f32 {
    ROUNDING * (body.center.abs().max_element() + size(body, length))
}

impl StillnessRule {
    /// Time between marks [s].
    pub(crate) fn spacing(&self) -> f32 {
        Self::spacing_of(self.time)
    }

    /// The same, for this time until sleep [s].
    pub(crate) const fn spacing_of(time: f32) -> f32 {
        SPACING * time
    }

    /// Number of marks due.
    fn marks_at(&self, still_time: f32) -> f32 {
        let past = still_time - LAG * self.time;
        if past >= 0.0 { 1.0 + (past / self.spacing()).floor() } else { 0.0 }
    }

    /// True if a body is slow enough to be watched. Its marks decide whether it is at rest.
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
        let before = body.sleep.still_time;
        if !slow {
            body.sleep.still_time = 0.0;
            return;
        }
        if before <= 0.0 {
            (known.count, known.verdict) = (0, Verdict::Rests);
        }
        body.sleep.still_time = before + self.dt;
        if self.marks_at(body.sleep.still_time) <= self.marks_at(before) {
            return;
        }
        let Body { center, rotation, v, w, sleep: Sleep { still_time: at, .. }, .. } = *body;
        let here = Mark { center, rotation, v, w, at };
        let [first, second] = known.marks;
        let marks = known.count;
        known.marks = [second, here];
        known.count = (marks + 1).min(2);
        if marks < 2 {
            if body.sleep.still_time >= self.time {
                // The step became longer meanwhile, so one more mark is needed.
                let now = self.time - 0.5 * self.spacing();
                known.go_back(body.sleep.still_time - now);
                body.sleep.still_time = now;
            }
            return;
        }
        known.judge(self, [&first, &second, &here], body);
        if known.verdict != Verdict::Rests {
            // The next test follows one mark later, slightly less for rounding.
            let back = body.sleep.still_time - (LAG + 1.02 * SPACING) * self.time;
            known.go_back(back);
            body.sleep.still_time -= back;
        }
    }
}

impl Stillness {
    /// Shifts the marks to another origin [m].
    pub(crate) fn shift(&mut self, origin: Vec3) {
        self.marks.iter_mut().for_each(|mark| mark.center -= origin);
    }

    /// Moves the still time back by `by` [s], together with the marks, so that the times between
    /// marks stay correct.
    pub(crate) fn go_back(&mut self, by: f32) {
        for mark in &mut self.marks {
            mark.at = bounded(mark.at - by);
        }
    }

    /// Decides from three marks whether a body is at rest.
    fn judge(&mut self, rule: &StillnessRule, [first, second, here]: [&Mark; 3], body: &Body) {
        let size = size(body, rule.length);
        let times = [second.at - first.at, here.at - second.at];
        let times = times.map(|time| time.clamp(TIME_STEP.minimum, LONGEST));
        let [before, after] = [Motion::between(first, second), Motion::between(second, here)];
        let whole = Motion::between(first, here).length(size);
        let per = times.map(|time| 1.0 / time);
        self.means = [before.scaled(per[0]), after.scaled(per[1])];
        let rounding = rounding(body, rule.length);
        let creep = CREEP * size + rounding;
        // Difference of the second displacement to the first, scaled to the same time: a τ².
        let sway = after.less(&before, times[1] * per[0]);
        // The velocity change over the second half; for jitter it is unrelated to the
        // displacements.
        let gain = Motion { moved: here.v - second.v, turned: here.w - second.w };
        let apart = gain.scaled(times[0]).less(&sway, 1.0).length(size);
        let sway = sway.length(size);
        let lasts = apart <= LASTS * sway;
        let square = times[0] * times[1];
        let load = pull(rule.gravity, body).1 + body.history.load / body.inertia.mass;
        let maximum = BALANCE * load * square + rounding;
        self.verdict = if sway > maximum && lasts {
            Verdict::Sways(sway / square, maximum / square)
        } else if whole > creep {
            let time = times[0] + times[1];
            Verdict::Creeps(whole / time, creep / time)
        } else {
            Verdict::Rests
        };
    }

    /// True if its numbers are valid, so that the verdict is computed from finite numbers.
    pub(crate) fn is_valid(&self) -> bool {
        let numbers = match self.verdict {
            Verdict::Rests => [0.0; 2],
            Verdict::Creeps(is, maximum) | Verdict::Sways(is, maximum) => [is, maximum],
        };
        let marks = self.marks.iter().all(|mark| {
            let (far, fast) = (limits::POSITION_KEPT.maximum, limits::SPEED_KEPT.maximum);
            let placed = mark.center.is_below(far) && mark.rotation.is_normalized();
            placed && mark.v.is_below(fast) && mark.w.is_below(fast) && mark.at.is_finite()
        });
        let finite = |motion: &Motion| motion.moved.is_finite() && motion.turned.is_finite();
        let is_valid = marks && self.means.iter().all(finite);
        is_valid && self.count <= 2 && numbers.iter().all(|x| *x >= 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::{Stillness, Verdict};
    use crate::base::math::Vec3;

    #[test]
    fn marks_that_no_body_can_have_are_not_sound() {
        assert!(Stillness::default().is_valid());
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
            assert!(!known.is_valid(), "{i}");
        }
    }
}
