//! The thread that steps the world: takes commands, gives what is to be shown.

use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use drystone::{BodyId, BodyKind, Filter, Pose, Vec3, World, WorldConfig, WorldCounts};
use drystone_render::{Drawing, Look, Subject};

use crate::history::{History, Input};
use crate::overlay::{self, Overlays};

/// What the window asks for.
#[derive(Clone, Debug)]
pub enum Command {
    /// Run, or stand still.
    Play(bool),
    /// One step, standing still after it.
    Step,
    /// To this step, standing still after it.
    Seek(u64),
    /// How fast time goes: 1 is as in the world outside.
    Speed(f32),
    /// What is drawn over bodies.
    Overlays(Overlays),
    /// Take hold of the dynamic body on a ray: origin, unit direction [m, world].
    Grab(Vec3, Vec3),
    /// Pull what is held to this ray.
    Drag(Vec3, Vec3),
    /// Let it go.
    Release,
    /// Shoot a ball along a ray.
    Shoot(Vec3, Vec3),
    /// Other settings, from the next step on.
    Config(Box<WorldConfig>),
    /// The window is gone.
    Quit,
}

/// Numbers of a step, for plots.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Time that the step took [ms].
    pub step_ms: f32,
    /// Kinetic and potential energy [J].
    pub energy: f64,
    /// Contacts with points that were solved.
    pub contacts: usize,
}

/// What the window shows.
#[derive(Clone, Debug)]
pub struct Shown {
    /// The picture.
    pub drawing: Drawing,
    /// What it is about.
    pub subject: Subject,
    /// Steps taken.
    pub step: u64,
    /// The last step that was reached.
    pub furthest: u64,
    /// Length of a step [s].
    pub dt: f32,
    /// Whether the world runs.
    pub playing: bool,
    /// How many of everything there are.
    pub counts: WorldCounts,
    /// The settings.
    pub config: WorldConfig,
    /// Steps since the last picture.
    pub samples: Vec<Sample>,
    /// What is held: from where on it to where it is pulled [m, world].
    pub held: Option<(Vec3, Vec3)>,
    /// Answers to [`Command::Grab`] so far: how many, and whether the last one met a body.
    pub grabs: (u64, bool),
    /// What the user should know.
    pub message: Option<String>,
}

/// The newest picture, until the window takes it.
pub type Slot = Arc<Mutex<Option<Shown>>>;

/// Longest wait between pictures while the world runs [s].
const PICTURE_TIME: f64 = 1.0 / 60.0;
/// Frequency of the spring between mouse and body [Hz].
const GRAB_HERTZ: f32 = 3.0;
/// Time in which the grip takes most of the turning from what is held [s].
const GRIP_TIME: f32 = 0.3;

/// What is held by the mouse.
#[derive(Clone, Copy, Debug)]
struct Grab {
    body: BodyId,
    /// Where on it [m, its frame].
    local: Vec3,
    /// Distance from the eye [m].
    distance: f32,
    /// Where it is pulled [m, world].
    target: Vec3,
}

/// The world, its past and what is asked of it.
#[derive(Debug)]
pub struct Simulation {
    history: History,
    subject: Subject,
    playing: bool,
    speed: f32,
    overlays: Overlays,
    grab: Option<Grab>,
    grabs: (u64, bool),
    pending: Vec<Input>,
    samples: Vec<Sample>,
    message: Option<String>,
}

impl Simulation {
    /// Stands at the beginning.
    #[must_use]
    pub fn new(history: History, playing: bool) -> Self {
        let subject = Subject::of(&history.now().world);
        Self {
            history,
            subject,
            playing,
            speed: 1.0,
            overlays: Overlays::default(),
            grab: None,
            grabs: (0, false),
            pending: Vec::new(),
            samples: Vec::new(),
            message: None,
        }
    }

    /// Runs until the window is gone; calls `wake` when there is something new in the slot.
    pub fn run(mut self, commands: &Receiver<Command>, slot: &Slot, wake: &dyn Fn()) {
        let mut due = Instant::now();
        let mut last_picture = Instant::now();
        self.show(slot, wake);
        loop {
            let command = if self.playing {
                match commands.recv_timeout(due.saturating_duration_since(Instant::now())) {
                    Ok(command) => Some(command),
                    Err(RecvTimeoutError::Timeout) => None,
                    Err(RecvTimeoutError::Disconnected) => return,
                }
            } else {
                match commands.recv() {
                    Ok(command) => Some(command),
                    Err(_) => return,
                }
            };
            if let Some(command) = command {
                let was_playing = self.playing;
                if matches!(command, Command::Quit) {
                    return;
                }
                self.obey(command);
                // A queue of mouse moves makes one picture.
                while let Ok(more) = commands.try_recv() {
                    if matches!(more, Command::Quit) {
                        return;
                    }
                    self.obey(more);
                }
                if self.playing && !was_playing {
                    due = Instant::now();
                }
                if !self.playing {
                    self.show(slot, wake);
                    continue;
                }
            }
            let now = Instant::now();
            if self.playing && now >= due {
                self.step();
                let wait = f64::from(self.history.dt()) / f64::from(self.speed.max(0.01));
                due += Duration::from_secs_f64(wait.min(3600.0));
                if now.saturating_duration_since(due).as_secs_f64() > 0.1 {
                    // Too slow for real time: it is not made up for.
                    due = now;
                }
                let taken = slot.lock().unwrap_or_else(PoisonError::into_inner).is_none();
                if taken || !self.playing || last_picture.elapsed().as_secs_f64() > PICTURE_TIME {
                    self.show(slot, wake);
                    last_picture = Instant::now();
                }
            }
        }
    }

    /// Does what is asked.
    pub fn obey(&mut self, command: Command) {
        match command {
            Command::Play(playing) => self.playing = playing,
            Command::Step => {
                self.playing = false;
                self.step();
            }
            Command::Seek(step) => {
                self.playing = false;
                // Far jumps beyond what was reached would keep the window waiting.
                let most = self.history.furthest() + 600;
                let result = self.history.seek(step.min(most));
                self.note(result);
            }
            Command::Speed(speed) => self.speed = speed.clamp(0.01, 100.0),
            Command::Overlays(overlays) => self.overlays = overlays,
            Command::Grab(origin, direction) => self.take_hold(origin, direction),
            Command::Drag(origin, direction) => {
                if let Some(grab) = &mut self.grab {
                    grab.target = origin + direction * grab.distance;
                }
            }
            Command::Release => self.grab = None,
            Command::Shoot(origin, direction) => {
                let size = self.subject.radius();
                let radius = (0.06 * size).clamp(0.02, 2.0);
                let velocity = direction * (3.0 * size).clamp(4.0, 60.0);
                self.pending.push(Input::Shot { from: origin, velocity, radius });
            }
            Command::Config(config) => match config.validate() {
                Ok(()) => self.pending.push(Input::Config(config)),
                Err(e) => self.message = Some(e.to_string()),
            },
            Command::Quit => {}
        }
    }

    /// What is to be shown now.
    pub fn shown(&mut self) -> Shown {
        let world = &self.history.now().world;
        let colors = self.overlays.islands.then(|| overlay::island_colors(world));
        let look = Look {
            dim_asleep: self.overlays.sleeping,
            picked: self.grab.map(|g| g.body),
            colors: colors.as_deref(),
        };
        let mut drawing = Drawing::of(world, &self.subject, &look);
        overlay::add(&mut drawing, world, self.overlays, self.subject.radius());
        let held = self.held(world);
        if let Some((from, to)) = held {
            drawing.add_line(from, to, 3.0, [255, 176, 0, 255]);
        }
        Shown {
            drawing,
            subject: Subject::of(world),
            step: self.history.step_count(),
            furthest: self.history.furthest(),
            dt: self.history.dt(),
            playing: self.playing,
            counts: world.counts(),
            config: world.config().clone(),
            samples: std::mem::take(&mut self.samples),
            held,
            grabs: self.grabs,
            message: self.message.clone(),
        }
    }

    fn show(&mut self, slot: &Slot, wake: &dyn Fn()) {
        let mut shown = self.shown();
        let mut slot = slot.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(unseen) = slot.take() {
            // Plots lose no step.
            shown.samples.splice(0..0, unseen.samples);
        }
        *slot = Some(shown);
        drop(slot);
        wake();
    }

    fn step(&mut self) {
        let mut inputs = std::mem::take(&mut self.pending);
        inputs.extend(self.pull());
        let start = Instant::now();
        let result = self.history.step(inputs);
        let step_ms = start.elapsed().as_secs_f32() * 1.0e3;
        self.note(result);
        let world = &self.history.now().world;
        let energy = world.kinetic_energy() + world.potential_energy();
        self.samples.push(Sample { step_ms, energy, contacts: world.counts().contacts });
        for fault in &world.events().faults {
            self.message = Some(format!("a body was put aside: {:?}", fault.kind));
        }
    }

    fn note(&mut self, result: Result<(), drystone_scene::BuildError>) {
        if let Err(e) = result {
            self.message = Some(e.to_string());
            self.playing = false;
        }
    }

    fn take_hold(&mut self, origin: Vec3, direction: Vec3) {
        let world = &self.history.now().world;
        let delta = direction * 1.0e4;
        let hit = world.query().cast_ray(origin, delta, Filter::default()).ok().flatten();
        self.grab = hit.and_then(|hit| {
            let body = world.body(hit.body).filter(|b| b.kind() == BodyKind::Dynamic)?;
            Some(Grab {
                body: hit.body,
                local: body.pose().local_point(hit.point),
                distance: (hit.point - origin).length(),
                target: hit.point,
            })
        });
        self.grabs = (self.grabs.0 + 1, self.grab.is_some());
    }

    fn held(&self, world: &World) -> Option<(Vec3, Vec3)> {
        let grab = self.grab?;
        let pose: Pose = world.body(grab.body)?.pose();
        Some((pose.point(grab.local), grab.target))
    }

    /// The force that pulls what is held: a critically damped spring, as strong as the point's
    /// effective mass bears at this step, and what carries the body's weight.
    fn pull(&self) -> Option<Input> {
        let grab = self.grab?;
        let world = &self.history.now().world;
        let body = world.body(grab.body)?;
        let at = body.pose().point(grab.local);
        let arm = at - body.center_of_mass();
        let inertia = body.inertia();
        let least = inertia.xx.min(inertia.yy).min(inertia.zz).max(1.0e-12);
        let mass = 1.0 / (1.0 / body.mass().max(1.0e-9) + arm.length_squared() / least);
        // Explicit, so no faster than a quarter of the steps allows.
        let omega = (core::f32::consts::TAU * GRAB_HERTZ).min(0.5 / self.history.dt());
        let pulled = (grab.target - at) * (omega * omega) - body.velocity_at(at) * (2.0 * omega);
        let longest = 400.0;
        let pulled = pulled * (longest / pulled.length().max(longest));
        let force = pulled * mass - world.config().gravity * body.mass();
        // Without friction in the grip what is held would swing for ever.
        let calm = GRIP_TIME.max(2.0 * self.history.dt());
        let torque = inertia.mul(body.angular_velocity()) * -calm.recip();
        Some(Input::Force { body: grab.body, force, at, torque })
    }
}

#[cfg(test)]
mod tests {
    use drystone::{BodyKind, vec3};

    use super::{Command, History, Simulation, Vec3};

    fn simulation(scene: &str) -> Simulation {
        let running = drystone_scene::named(scene).unwrap().build().unwrap();
        Simulation::new(History::new(running, 1.0 / 60.0), false)
    }

    #[test]
    fn a_body_that_is_held_follows_the_mouse_and_stays_there() {
        let mut s = simulation("stack:n=1");
        let top = |s: &Simulation| {
            let world = &s.history.now().world;
            world.bodies().filter(|b| b.kind() == BodyKind::Dynamic).map(|b| b.position()).last()
        };
        let at = top(&s).unwrap();
        s.obey(Command::Grab(at + vec3(0.0, 0.0, 10.0), -Vec3::Z));
        assert!(s.grabs.1);
        s.obey(Command::Drag(at + vec3(2.0, 3.0, 10.0), -Vec3::Z));
        for _ in 0..240 {
            s.obey(Command::Step);
        }
        let held = s.shown().held.unwrap();
        assert!((held.0 - held.1).length() < 0.05, "{held:?}");
        s.obey(Command::Release);
        for _ in 0..240 {
            s.obey(Command::Step);
        }
        assert!((top(&s).unwrap().y - at.y).abs() < 0.1, "it fell back to the ground");
    }

    #[test]
    fn what_cannot_be_held_is_not() {
        let mut s = simulation("stack:n=1");
        s.obey(Command::Grab(vec3(0.0, 50.0, 0.0), Vec3::Y));
        assert_eq!(s.grabs, (1, false));
        s.obey(Command::Grab(vec3(30.0, 5.0, 0.0), -Vec3::Y));
        assert_eq!(s.grabs, (2, false), "the ground is static");
        s.obey(Command::Drag(Vec3::splat(f32::NAN), Vec3::X));
        s.obey(Command::Shoot(Vec3::splat(f32::NAN), Vec3::X));
        s.obey(Command::Step);
        assert_eq!(s.shown().step, 1);
    }

    #[test]
    fn time_can_be_turned_back() {
        let mut s = simulation("stack:n=2");
        for _ in 0..20 {
            s.obey(Command::Step);
        }
        s.obey(Command::Seek(19));
        let shown = s.shown();
        assert_eq!((shown.step, shown.furthest, shown.playing), (19, 20, false));
        s.obey(Command::Seek(u64::MAX));
        assert_eq!(s.shown().step, 620);
    }
}
