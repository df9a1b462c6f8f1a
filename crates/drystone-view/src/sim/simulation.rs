//! The worlds that are shown: they carry out commands and take steps.

use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

use drystone::{BodyId, BodyKind, World};
use drystone_render::Subject;
use drystone_scene::BuildError;

use super::command::{Command, Deed};
use super::grab::{Grab, meet};
use super::opened::{Opened, Opener, shortened, shown_notes};
use crate::history::{History, Input};
use crate::overlay::Overlays;
use crate::side::Side;

/// The worlds, their past and the state of the window's commands.
pub struct Simulation {
    pub(super) open: Opener,
    pub(super) name: String,
    pub(super) scene: u64,
    /// One, or two that are shown side by side: they get the same inputs.
    pub(super) sides: Vec<Side>,
    pub(super) subject: Arc<Subject>,
    pub(super) playing: bool,
    pub(super) speed: f32,
    pub(super) overlays: Overlays,
    pub(super) grab: Option<Grab>,
    pub(super) grabs: (u64, bool),
    pub(super) picked: Option<BodyId>,
    pub(super) message: Option<String>,
    pub(super) notes: Arc<[String]>,
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

    pub(super) fn history(&self) -> &History {
        &self.sides[0].history
    }

    /// The world of a side.
    fn world(&self, side: usize) -> Option<&World> {
        Some(&self.sides.get(side)?.history.now().world)
    }

    /// Carries out a command.
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
            Command::Grab(origin, direction, side) => {
                self.grab = self.world(side).and_then(|world| Grab::of(world, origin, direction));
                self.grabs = (self.grabs.0 + 1, self.grab.is_some());
            }
            Command::Drag(origin, direction) => {
                if let Some(grab) = &mut self.grab {
                    grab.target = origin + direction * grab.distance;
                }
            }
            Command::Release => self.grab = None,
            Command::Pick(origin, direction, side) => {
                self.picked = self
                    .world(side)
                    .and_then(|world| meet(world, origin, direction))
                    .map(|(body, _)| body);
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

    /// The last step of a film.
    pub(super) fn film(&self) -> Option<u64> {
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
            let history = &mut self.sides[number].history;
            let pull = self.grab.and_then(|grab| grab.pull(&history.now().world, history.dt()));
            if let Some(input) = pull {
                history.act(input);
            }
            let result = self.sides[number].step(between);
            self.note(result);
        }
        if let Some(fault) = self.history().now().world.events().faults.last() {
            self.message = Some(format!("a body was put aside: {:?}", fault.kind));
        }
    }

    fn note(&mut self, result: Result<(), BuildError>) {
        if let Err(e) = result {
            self.message = Some(e.to_string());
            self.playing = false;
        }
    }
}
