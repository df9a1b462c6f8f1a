//! Fixed steps for frames of any length, and interpolated poses.

use crate::base::id::BodyId;
use crate::base::limits;
use crate::base::math::Vec3;
use crate::base::pose::Pose;
use crate::state::def::{DefError, within};

use super::World;

/// The poses of a body before and after its last step.
#[derive(Clone, Copy, Debug)]
struct Track {
    body: BodyId,
    /// Number of that step.
    step: u64,
    poses: [Pose; 2],
}

/// Steps a world at a fixed rate while frames have another rate, and interpolates poses between the
/// last two steps. The world gives the same bits on every machine, at any frame rate.
///
/// The drawn poses lag behind the world by up to one step, because they lie between the last two
/// steps.
///
/// ```
/// use drystone::{BodyDef, Clock, ShapeDef, World};
///
/// # fn main() -> Result<(), drystone::DefError> {
/// let mut world = World::default();
/// let ball = BodyDef::dynamic().with_shape(ShapeDef::sphere(0.5));
/// let ball = world.add_body(ball.with_linear_velocity([1.2, 0.0, 0.0]))?;
/// let mut clock = Clock::new(1.0 / 60.0)?;
/// for _ in 0..144 {
///     // One frame of a display of 144 Hz.
///     clock.advance(&mut world, 1.0 / 144.0, |_| {});
///     let pose = clock.pose(&world, ball);
///     assert!(pose.is_some());
/// }
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct Clock {
    step: f32,
    scale: f32,
    max_steps: u32,
    /// Time not yet simulated [s].
    left: f32,
    /// Tracks by body slots.
    tracks: Vec<Option<Track>>,
}

impl Clock {
    /// A clock with steps of this length [s], 1e-6 to 10.
    ///
    /// # Errors
    /// The length is not from 1e-6 to 10 s.
    pub fn new(step: f32) -> Result<Self, DefError> {
        within("step", step, &limits::TIME_STEP)?;
        Ok(Self { step, scale: 1.0, max_steps: 8, left: 0.0, tracks: Vec::new() })
    }

    /// Length of a step [s].
    #[must_use]
    pub const fn step(&self) -> f32 {
        self.step
    }

    /// Sets the speed of the world's time relative to frame time; default 1. 0 stops it; a value
    /// that is negative or not finite counts as 0. Slow motion changes the time between steps, not
    /// their length, so results stay the same.
    pub fn set_scale(&mut self, scale: f32) {
        self.scale = if scale.is_finite() { scale.max(0.0) } else { 0.0 };
    }

    /// Sets the maximum number of steps per frame, at least 1; default 8. After a longer frame the
    /// world stays behind. Otherwise a program that steps more slowly than real time would fall
    /// behind without limit.
    pub fn set_most_steps(&mut self, steps: u32) {
        self.max_steps = steps.max(1);
    }

    /// Advances the world by the time of a frame [s], in whole steps. The remainder counts for the
    /// next frame. `before` is called before each step; apply forces for one step there. Returns
    /// the number of steps. A time that is negative or not finite counts as 0.
    pub fn advance(
        &mut self,
        world: &mut World,
        frame: f32,
        mut before: impl FnMut(&mut World),
    ) -> u32 {
        let passed = if frame.is_finite() { frame.max(0.0) * self.scale } else { 0.0 };
        let mut steps = 0;
        self.left += passed;
        while self.left >= self.step && steps < self.max_steps {
            self.left -= self.step;
            before(world);
            self.follow(world);
            steps += 1;
        }
        if !(self.left < self.step) {
            self.left = 0.0;
        }
        steps
    }

    /// Takes one step, and stores the poses of the moved bodies before and after it.
    fn follow(&mut self, world: &mut World) {
        for body in world.moved_bodies() {
            self.note(body.id(), world.step_count(), body.pose());
        }
        world.step(self.step);
        let now = world.step_count();
        for body in world.moved_bodies() {
            let slot = body.id().index() as usize;
            let known = self.tracks.get_mut(slot).and_then(Option::as_mut);
            match known.filter(|track| track.body == body.id() && track.step + 1 == now) {
                Some(track) => (track.step, track.poses[1]) = (now, body.pose()),
                // It woke in this step, so its pose before the step was not stored.
                None => self.note(body.id(), now, body.pose()),
            }
        }
    }

    /// Stores the pose of a body as both the current and the previous one.
    fn note(&mut self, body: BodyId, step: u64, pose: Pose) {
        let slot = body.index() as usize;
        if self.tracks.len() <= slot {
            self.tracks.resize(slot + 1, None);
        }
        self.tracks[slot] = Some(Track { body, step, poses: [pose; 2] });
    }

    /// The slots of bodies that the last step moved and that are still at that pose.
    pub(super) fn known<'a>(&'a self, world: &'a World) -> impl Iterator<Item = usize> + 'a {
        let tracks = self.tracks.iter().enumerate();
        tracks.filter_map(|(slot, track)| last_poses(world, track.as_ref()?).map(|_| slot))
    }

    /// Shifts the stored poses of a slot to another origin [m]; the body has been shifted already.
    pub(super) fn shift(&mut self, world: &World, slot: usize, origin: Vec3) {
        let track = self.tracks.get_mut(slot).and_then(Option::as_mut);
        if let Some(track) = track
            && let Some(body) = world.body(track.body)
        {
            track.poses[0].position -= origin;
            track.poses[1] = body.pose();
        }
    }

    /// Fraction of a step that has passed since the last one, 0 to 1.
    #[must_use]
    pub fn part(&self) -> f32 {
        (self.left / self.step).clamp(0.0, 1.0)
    }

    /// The pose at which to draw a body [world], interpolated between the poses before and after
    /// the last step. For a body that did not move, or was moved by a call since, it is the current
    /// pose. `None` if there is no such body.
    #[must_use]
    pub fn pose(&self, world: &World, body: BodyId) -> Option<Pose> {
        let now = world.body(body)?.pose();
        let track = self.tracks.get(body.index() as usize).and_then(Option::as_ref);
        let poses =
            track.filter(|track| track.body == body).and_then(|track| last_poses(world, track));
        Some(poses.map_or(now, |[before, _]| before.lerp(&now, self.part())))
    }
}

/// The two poses of a track, if they belong to the world's last step.
fn last_poses(world: &World, track: &Track) -> Option<[Pose; 2]> {
    let now = world.body(track.body)?.pose();
    let is_last = track.step == world.step_count() && track.poses[1] == now;
    is_last.then_some(track.poses)
}
