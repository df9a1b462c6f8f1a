//! The worlds that are shown: they take commands and give what is to be shown. `pace` says when.

use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError};

use drystone::query::{Inside, QueryFilter};
use drystone::{BodyId, BodyKind, Pose, Vec3, World, WorldConfig, WorldCounts};
use drystone_render::{Drawing, Look, Subject};
use drystone_scene::Running;

use crate::history::{History, Input};
use crate::overlay::{self, Overlays};
use crate::picked::{self, Picked};
pub use crate::side::Sample;
use crate::side::Side;

/// What the window asks for.
#[derive(Clone, Debug)]
pub enum Command {
    /// Another scene: a name of the catalog, or a path.
    Open(String),
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
    /// Take hold of the dynamic body on a ray of a side: origin, unit direction [m, world].
    Grab(Vec3, Vec3, usize),
    /// Pull what is held to this ray.
    Drag(Vec3, Vec3),
    /// Let it go.
    Release,
    /// Look closer at the body on a ray of a side, or at none.
    Pick(Vec3, Vec3, usize),
    /// Do this to the body that is looked at.
    Act(Deed),
    /// Shoot a ball or, if so said, a box along a ray.
    Shoot(Vec3, Vec3, bool),
    /// Other settings for a side, from the next step on.
    Config(usize, Box<WorldConfig>),
    /// Two runs of the scene side by side, which may have other settings, or one.
    Split(bool),
    /// The window is gone.
    Quit,
}

/// What can be done to a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Deed {
    /// It is taken away.
    Remove,
    /// A second one beside it.
    Duplicate,
    /// It is held where it is, or let go again.
    Freeze,
}

/// One of the runs that are shown.
#[derive(Clone, Debug)]
pub struct View {
    /// The picture.
    pub drawing: Drawing,
    /// How many of everything there are.
    pub counts: WorldCounts,
    /// The settings.
    pub config: WorldConfig,
    /// Steps since the last picture.
    pub samples: Vec<Sample>,
    /// The world's hash, while it stands still.
    pub hash: Option<u64>,
}

/// What the window shows.
#[derive(Clone, Debug)]
pub struct Shown {
    /// The scene's name.
    pub name: String,
    /// How many scenes were opened before this one.
    pub scene: u64,
    /// One run, or two side by side.
    pub views: Vec<View>,
    /// What the picture is about.
    pub subject: Arc<Subject>,
    /// Steps taken.
    pub step: u64,
    /// The last step that was reached.
    pub furthest: u64,
    /// The last step of a film.
    pub film: Option<u64>,
    /// Length of a step [s].
    pub dt: f32,
    /// Whether the world runs.
    pub playing: bool,
    /// What is held: from where on it to where it is pulled [m, world].
    pub held: Option<(Vec3, Vec3)>,
    /// Answers to [`Command::Grab`] so far: how many, and whether the last one met a body.
    pub grabs: (u64, bool),
    /// The body that is looked at.
    pub picked: Option<Picked>,
    /// What the user should know.
    pub message: Option<String>,
    /// What of the scene's file was left out, a line each.
    pub notes: Arc<[String]>,
}

/// A scene that was opened.
#[derive(Debug)]
pub struct Opened {
    /// Its name, for the window's title.
    pub name: String,
    /// The scene at its beginning.
    pub running: Running,
    /// Steps a second.
    pub hz: f32,
    /// What of its file was left out, a line each.
    pub notes: Vec<String>,
}

/// Opens a scene: a name of the catalog, or a path. An error is a line for the user.
pub type Opener = Box<dyn FnMut(&str) -> Result<Opened, String> + Send>;

/// The newest picture, until the window takes it.
pub type Slot = Arc<Mutex<Option<Shown>>>;

/// Frequency of the spring between mouse and body [Hz].
const GRAB_HERTZ: f32 = 3.0;
/// Time in which the grip takes most of the turning from what is held [s].
const GRIP_TIME: f32 = 0.3;

/// Notes on a file that are shown.
const MOST_NOTES: usize = 30;
/// Letters of a line that is shown.
const MOST_LETTERS: usize = 400;

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

/// The worlds, their past and what is asked of them.
pub struct Simulation {
    open: Opener,
    name: String,
    scene: u64,
    /// One, or two that are shown side by side: they get the same inputs.
    sides: Vec<Side>,
    subject: Arc<Subject>,
    playing: bool,
    speed: f32,
    overlays: Overlays,
    grab: Option<Grab>,
    grabs: (u64, bool),
    picked: Option<BodyId>,
    message: Option<String>,
    notes: Arc<[String]>,
}

impl fmt::Debug for Simulation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Simulation").field("name", &self.name).finish_non_exhaustive()
    }
}

impl Simulation {
    /// Stands at the beginning of a scene.
    #[must_use]
    pub fn new(opened: Opened, open: Opener, playing: bool) -> Self {
        let subject = Arc::new(Subject::of(&opened.running.world));
        let history = History::new(opened.running, opened.hz.recip());
        Self {
            open,
            name: opened.name,
            scene: 0,
            sides: vec![Side::new(history)],
            subject,
            playing,
            speed: 1.0,
            overlays: Overlays::default(),
            grab: None,
            grabs: (0, false),
            picked: None,
            message: None,
            notes: shown_notes(opened.notes),
        }
    }

    /// Whether the world runs.
    pub(crate) const fn is_playing(&self) -> bool {
        self.playing
    }

    /// How fast time goes: 1 is as in the world outside.
    pub(crate) const fn speed(&self) -> f32 {
        self.speed
    }

    /// Length of a step [s].
    pub(crate) fn step_time(&self) -> f32 {
        self.history().dt()
    }

    /// Tells the user something.
    pub(crate) fn say(&mut self, message: &str) {
        self.message = Some(message.to_owned());
    }

    fn history(&self) -> &History {
        &self.sides[0].history
    }

    /// Does what is asked.
    pub fn obey(&mut self, command: Command) {
        match command {
            Command::Open(what) => self.open(&what),
            Command::Play(playing) => self.playing = playing,
            Command::Step => {
                self.playing = false;
                self.step();
            }
            Command::Seek(step) => {
                self.playing = false;
                // Far jumps beyond what was reached would keep the window waiting.
                let step = step.min(self.film().unwrap_or(self.history().furthest() + 600));
                for number in 0..self.sides.len() {
                    let result = self.sides[number].history.seek(step);
                    self.note(result);
                }
            }
            Command::Speed(speed) => self.speed = speed.clamp(0.01, 100.0),
            Command::Overlays(overlays) => self.overlays = overlays,
            Command::Grab(origin, direction, side) => self.take_hold(origin, direction, side),
            Command::Drag(origin, direction) => {
                if let Some(grab) = &mut self.grab {
                    grab.target = origin + direction * grab.distance;
                }
            }
            Command::Release => self.grab = None,
            Command::Pick(origin, direction, side) => {
                self.picked = self.meet(origin, direction, side).map(|(body, _)| body);
            }
            Command::Act(deed) => self.act_on_picked(deed),
            Command::Shoot(origin, direction, boxed) => {
                let size = self.subject.radius();
                let radius = (0.06 * size).clamp(0.02, 2.0);
                let velocity = direction * (3.0 * size).clamp(4.0, 60.0);
                self.act(&Input::Shot { from: origin, velocity, radius, boxed });
            }
            Command::Config(side, config) => match config.validate() {
                Ok(()) => {
                    if let Some(side) = self.sides.get_mut(side) {
                        side.history.act(Input::Config(config));
                    }
                }
                Err(e) => self.message = Some(e.to_string()),
            },
            Command::Split(true) if self.sides.len() == 1 => {
                let fork = self.history().fork();
                self.sides.push(Side::new(fork));
            }
            Command::Split(split) => self.sides.truncate(if split { 2 } else { 1 }),
            Command::Quit => {}
        }
    }

    fn open(&mut self, what: &str) {
        self.message = None;
        // A file that no loader was prepared for must not take the window along.
        let opened = catch_unwind(AssertUnwindSafe(|| (self.open)(what)))
            .unwrap_or_else(|_| Err(format!("{what}: the loader failed; please report this file")));
        match opened {
            Ok(Opened { name, running, hz, notes }) => {
                self.notes = shown_notes(notes);
                self.subject = Arc::new(Subject::of(&running.world));
                self.sides = vec![Side::new(History::new(running, hz.recip()))];
                (self.name, self.scene) = (name, self.scene + 1);
                (self.grab, self.picked) = (None, None);
            }
            Err(why) => self.message = Some(shortened(why)),
        }
    }

    /// The user does something to all sides.
    fn act(&mut self, input: &Input) {
        for side in &mut self.sides {
            side.history.act(input.clone());
        }
    }

    fn act_on_picked(&mut self, deed: Deed) {
        let Some(id) = self.picked else { return };
        let Some(body) = self.history().now().world.body(id) else { return };
        match deed {
            Deed::Remove => {
                self.act(&Input::Remove(id));
                self.picked = None;
            }
            Deed::Duplicate => self.act(&Input::Duplicate(id)),
            Deed::Freeze if body.kind() == BodyKind::Dynamic => {
                let frozen = body.locks().any();
                self.act(&Input::Freeze(id, !frozen));
            }
            Deed::Freeze => {}
        }
    }

    /// What is to be shown now.
    pub fn shown(&mut self) -> Shown {
        self.shown_at(1.0)
    }

    /// What is to be shown at `part` of the way from the last step but one to the last one.
    fn shown_at(&mut self, part: f32) -> Shown {
        let (step, furthest) = (self.history().step_count(), self.history().furthest());
        let views = (0..self.sides.len()).map(|number| self.view(number, part)).collect();
        let world = &self.history().now().world;
        Shown {
            name: self.name.clone(),
            scene: self.scene,
            views,
            // While it runs what was framed at first is shown again: to look anew takes too long.
            subject: if self.playing {
                Arc::clone(&self.subject)
            } else {
                Arc::new(Subject::of(world))
            },
            step,
            furthest,
            film: self.film(),
            dt: self.history().dt(),
            playing: self.playing,
            held: self.held(world),
            grabs: self.grabs,
            picked: self.picked.and_then(|id| picked::look(self.history().now(), id)),
            message: self.message.clone(),
            notes: Arc::clone(&self.notes),
        }
    }

    fn view(&mut self, number: usize, part: f32) -> View {
        let side = &mut self.sides[number];
        let samples = std::mem::take(&mut side.samples);
        if !self.playing || side.is_time_to_look() {
            side.counts = side.history.now().world.counts();
        }
        let held = self.held(&self.sides[number].history.now().world);
        let side = &mut self.sides[number];
        let (counts, poses) = (side.counts, (part < 1.0).then(|| side.poses(part)));
        let Side { history, gatherer, .. } = side;
        let running = history.now();
        let world = &running.world;
        let colors = overlay::body_colors(world, self.overlays.tint);
        let look = Look {
            dim_asleep: self.overlays.sleeping,
            picked: self.grab.map(|g| g.body).or(self.picked),
            colors: colors.as_deref(),
            poses: poses.as_deref(),
            visuals: Some(&running.visuals),
            colliders: self.overlays.colliders,
        };
        let mut drawing = gatherer.gather(world, &self.subject, &look);
        overlay::add(&mut drawing, world, self.overlays, self.subject.radius());
        if let Some((from, to)) = held {
            drawing.add_line(from, to, 3.0, [255, 176, 0, 255]);
        }
        View {
            drawing,
            counts,
            config: world.config().clone(),
            samples,
            hash: (!self.playing).then(|| world.state_hash()),
        }
    }

    pub(crate) fn show(&mut self, slot: &Slot, wake: &dyn Fn(), part: f32) {
        let mut shown = self.shown_at(part);
        let mut slot = slot.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(unseen) = slot.take()
            && unseen.scene == shown.scene
        {
            // Plots lose no step.
            for (view, unseen) in shown.views.iter_mut().zip(unseen.views) {
                view.samples.splice(0..0, unseen.samples);
            }
        }
        *slot = Some(shown);
        drop(slot);
        wake();
    }

    /// The last step of a film.
    fn film(&self) -> Option<u64> {
        let steps = self.history().now().film_seconds()? / self.history().dt();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
        Some((steps - 1.0e-3).ceil().clamp(1.0, 1.0e6) as u64)
    }

    /// Takes a step of all sides, running or not. A film that has ended begins again.
    pub fn step(&mut self) {
        if self.film().is_some_and(|end| self.history().step_count() >= end) {
            for number in 0..self.sides.len() {
                let result = self.sides[number].history.seek(0);
                self.note(result);
            }
            return;
        }
        let between = self.playing && self.is_slow();
        for number in 0..self.sides.len() {
            if let Some(input) = self.pull(number) {
                self.sides[number].history.act(input);
            }
            let result = self.sides[number].step(between);
            self.note(result);
        }
        if let Some(fault) = self.history().now().world.events().faults.last() {
            self.message = Some(format!("a body was put aside: {:?}", fault.kind));
        }
    }

    fn note(&mut self, result: Result<(), drystone_scene::BuildError>) {
        if let Err(e) = result {
            self.message = Some(e.to_string());
            self.playing = false;
        }
    }

    /// The body that a ray of a side meets, and where [m, world].
    fn meet(&self, origin: Vec3, direction: Vec3, side: usize) -> Option<(BodyId, Vec3)> {
        let world = &self.sides.get(side)?.history.now().world;
        let delta = direction * 1.0e4;
        // A camera in a body sees what is before it.
        let outside = QueryFilter::default().with_inside(Inside::Ignore);
        let hit = world.query().cast_ray(origin, delta, outside).ok().flatten()?;
        Some((hit.body, hit.point))
    }

    fn take_hold(&mut self, origin: Vec3, direction: Vec3, side: usize) {
        self.grab = self.meet(origin, direction, side).and_then(|(id, point)| {
            let world = &self.sides.get(side)?.history.now().world;
            let body = world.body(id).filter(|b| b.kind() == BodyKind::Dynamic)?;
            let local = body.pose().local_point(point);
            Some(Grab { body: id, local, distance: (point - origin).length(), target: point })
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
    fn pull(&self, side: usize) -> Option<Input> {
        let grab = self.grab?;
        let history = &self.sides.get(side)?.history;
        let world = &history.now().world;
        let body = world.body(grab.body)?;
        let at = body.pose().point(grab.local);
        let arm = at - body.center_of_mass();
        let inertia = body.inertia();
        let least = inertia.xx.min(inertia.yy).min(inertia.zz).max(1.0e-12);
        let mass = 1.0 / (1.0 / body.mass().max(1.0e-9) + arm.length_squared() / least);
        // Explicit, so no faster than a quarter of the steps allows.
        let omega = (core::f32::consts::TAU * GRAB_HERTZ).min(0.5 / history.dt());
        let pulled = (grab.target - at) * (omega * omega) - body.velocity_at(at) * (2.0 * omega);
        let longest = 400.0;
        let pulled = pulled * (longest / pulled.length().max(longest));
        let force = pulled * mass - world.config().gravity * body.mass();
        // Without friction in the grip what is held would swing for ever.
        let calm = GRIP_TIME.max(2.0 * history.dt());
        let torque = inertia.mul(body.angular_velocity()) * -calm.recip();
        Some(Input::Force { body: grab.body, force, at, torque })
    }
}

/// The first notes on a file, each short enough for a window. A file may have any number of faults.
fn shown_notes(notes: Vec<String>) -> Arc<[String]> {
    let more = notes.len().saturating_sub(MOST_NOTES);
    let mut shown: Vec<String> = notes.into_iter().take(MOST_NOTES).map(shortened).collect();
    if more > 0 {
        shown.push(format!("and {more} more: `drystone info` lists them"));
    }
    shown.into()
}

/// A text without its end if it is long.
fn shortened(text: String) -> String {
    match text.char_indices().nth(MOST_LETTERS) {
        Some((end, _)) => format!("{} …", &text[..end]),
        None => text,
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use drystone::{BodyKind, Quat, vec3};
    use drystone_scene::bake::{self, Motion};
    use drystone_scene::gltf;

    use super::{
        Command, Deed, MOST_LETTERS, MOST_NOTES, Opened, Running, Simulation, Vec3, shown_notes,
    };
    use crate::side::mix;

    /// Opens scenes of the catalog.
    pub(crate) fn open(name: &str) -> Result<Opened, String> {
        let scene = drystone_scene::named(name).map_err(|e| e.to_string())?;
        let running = scene.build().map_err(|e| e.to_string())?;
        Ok(opened(name, running))
    }

    fn opened(name: &str, running: Running) -> Opened {
        Opened { name: name.to_owned(), running, hz: 60.0, notes: Vec::new() }
    }

    pub(crate) fn simulation(scene: &str) -> Simulation {
        Simulation::new(open(scene).unwrap(), Box::new(open), false)
    }

    #[test]
    fn a_body_that_is_held_follows_the_mouse_and_stays_there() {
        let mut s = simulation("stack:n=1");
        let top = |s: &Simulation| {
            let world = &s.history().now().world;
            world.bodies().filter(|b| b.kind() == BodyKind::Dynamic).map(|b| b.position()).last()
        };
        let at = top(&s).unwrap();
        s.obey(Command::Grab(at + vec3(0.0, 0.0, 10.0), -Vec3::Z, 0));
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
        s.obey(Command::Grab(vec3(0.0, 50.0, 0.0), Vec3::Y, 0));
        assert_eq!(s.grabs, (1, false));
        s.obey(Command::Grab(vec3(30.0, 5.0, 0.0), -Vec3::Y, 0));
        assert_eq!(s.grabs, (2, false), "the ground is static");
        s.obey(Command::Drag(Vec3::splat(f32::NAN), Vec3::X));
        s.obey(Command::Shoot(Vec3::splat(f32::NAN), Vec3::X, true));
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

    #[test]
    fn two_sides_with_the_same_settings_are_the_same_and_with_others_differ() {
        let mut s = simulation("stack:n=3");
        s.obey(Command::Seek(10));
        s.obey(Command::Split(true));
        s.obey(Command::Shoot(vec3(0.0, 1.5, 8.0), -Vec3::Z, true));
        for _ in 0..30 {
            s.obey(Command::Step);
        }
        let hashes = |s: &mut Simulation| -> Vec<_> {
            s.shown().views.iter().map(|view| view.hash.unwrap()).collect()
        };
        let same = hashes(&mut s);
        assert_eq!((same.len(), same[0]), (2, same[1]));
        s.obey(Command::Seek(20));
        let mut config = s.shown().views[1].config.clone();
        config.method = drystone::method::Method::soft_step_relax();
        s.obey(Command::Config(1, Box::new(config)));
        s.obey(Command::Seek(40));
        let other = hashes(&mut s);
        assert_eq!(other[0], same[0], "the first side is as it was");
        assert_ne!(other[0], other[1]);
        s.obey(Command::Split(false));
        assert_eq!(s.shown().views.len(), 1);
    }

    #[test]
    fn a_film_stops_at_its_end_and_begins_again() {
        let scene = drystone_scene::named("hello").unwrap();
        let mut running = scene.build().unwrap();
        let mut motion =
            Motion { poses: vec![Vec::new(); running.bodies.len()], ..Motion::default() };
        for step in 0..=30_u8 {
            motion.times.push(f32::from(step) / 60.0);
            for (number, id) in running.bodies.iter().enumerate() {
                motion.poses[number].push(running.world.body(*id).unwrap().pose());
            }
            running.step(1.0 / 60.0).unwrap();
        }
        let path = std::env::temp_dir().join(format!("drystone-film-{}.glb", std::process::id()));
        bake::write_scene(&path, &scene, &[], &motion).unwrap();
        let film = gltf::film(gltf::load(&path, &gltf::Options::default()).unwrap()).unwrap();
        std::fs::remove_file(path).unwrap();
        let opened = opened("film", film.build().unwrap());
        let mut s = Simulation::new(opened, Box::new(open), false);
        s.obey(Command::Seek(1000));
        let shown = s.shown();
        assert_eq!((shown.step, shown.film), (30, Some(30)));
        let low = |s: &Simulation| {
            let bodies = s.history().now().world.bodies();
            bodies.map(|b| b.position().y).fold(f32::MIN, f32::max)
        };
        let end = low(&s);
        s.obey(Command::Step);
        assert_eq!(s.shown().step, 0);
        assert!(low(&s) > end + 0.5, "the ball is up again");
    }

    #[test]
    fn what_is_picked_can_be_deleted_doubled_and_frozen() {
        let mut s = simulation("stack:n=2");
        let bodies = |s: &Simulation| s.history().now().world.bodies().count();
        let before = bodies(&s);
        s.obey(Command::Act(Deed::Remove));
        assert_eq!(bodies(&s), before, "nothing is picked");
        let toward = |s: &mut Simulation| {
            s.obey(Command::Pick(vec3(0.0, 1.5, 10.0), -Vec3::Z, 0));
            s.shown().picked.map(|p| p.title)
        };
        assert!(toward(&mut s).is_some_and(|title| title.contains("cube 1")));
        s.obey(Command::Act(Deed::Duplicate));
        assert_eq!(bodies(&s), before + 1);
        s.obey(Command::Act(Deed::Freeze));
        let body = s.picked.unwrap();
        assert!(s.history().now().world.body(body).unwrap().locks().any());
        s.obey(Command::Act(Deed::Remove));
        assert_eq!((bodies(&s), s.shown().picked.is_none()), (before, true));
    }

    #[test]
    fn what_cannot_be_opened_leaves_the_scene_and_says_why() {
        let mut s = simulation("stack:n=2");
        s.obey(Command::Step);
        s.obey(Command::Open("nonsense".to_owned()));
        let shown = s.shown();
        assert_eq!((shown.name.as_str(), shown.step, shown.scene), ("stack:n=2", 1, 0));
        assert!(shown.message.unwrap().contains("nonsense"));
        s.obey(Command::Open("hello".to_owned()));
        let shown = s.shown();
        assert_eq!((shown.name.as_str(), shown.step, shown.scene), ("hello", 0, 1));
        assert!(shown.message.is_none());
        s.open = Box::new(|_| panic!("a loader's defect"));
        s.obey(Command::Open("hello".to_owned()));
        assert!(s.shown().message.unwrap().contains("the loader failed"));
    }

    #[test]
    fn notes_on_a_file_go_with_it_and_are_no_longer_than_a_window() {
        let mut s = simulation("hello");
        assert!(s.shown().notes.is_empty());
        s.open = Box::new(|name| {
            let mut opened = open("hello")?;
            opened.notes = vec!["é".repeat(10_000); name.len()];
            Ok(opened)
        });
        s.obey(Command::Open("ab".to_owned()));
        let notes = s.shown().notes;
        assert_eq!(notes.len(), 2);
        assert_eq!(notes[0].chars().count(), MOST_LETTERS + 2, "{}", notes[0]);
        s.open = Box::new(open);
        s.obey(Command::Open("nonsense".to_owned()));
        assert_eq!(s.shown().notes.len(), 2, "the scene stays, and what is known of it");
        s.obey(Command::Open("hello".to_owned()));
        assert!(s.shown().notes.is_empty());
        let many = shown_notes(vec!["no".to_owned(); 1_000_000]);
        assert_eq!(many.len(), MOST_NOTES + 1);
        assert!(many[MOST_NOTES].contains(&(1_000_000 - MOST_NOTES).to_string()));
    }

    #[test]
    fn between_two_steps_bodies_are_between_their_places() {
        let mut s = simulation("hello");
        s.obey(Command::Speed(0.1));
        s.obey(Command::Seek(20));
        s.playing = true;
        s.step();
        let side = &s.sides[0];
        let world = &side.history.now().world;
        let ball = world.bodies().find(|b| b.kind() == BodyKind::Dynamic).unwrap();
        let slot = ball.id().index() as usize;
        let before = side.before[slot].unwrap().1;
        let half = side.poses(0.5)[slot];
        let middle = (before.position + ball.position()) * 0.5;
        assert!((half.position - middle).length() < 1.0e-6);
        assert!(before.position.y > half.position.y && half.position.y > ball.position().y);
        let turned = drystone::Pose::new(Vec3::ZERO, Quat::from_axis_angle(Vec3::Y, 1.0));
        let half = mix(&drystone::Pose::IDENTITY, &turned, 0.5);
        assert!((half.rotation.angle() - 0.5).abs() < 1.0e-6);
    }
}
