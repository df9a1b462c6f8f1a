//! When the world steps and when it is shown: on a thread of its own, or between the pictures of a
//! browser, which has one thread for all.

use std::sync::PoisonError;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::Duration;

use web_time::Instant;

use crate::sim::{Command, Simulation, Slot};

/// Time between pictures while the world runs [s].
const PICTURE_TIME: f64 = 1.0 / 60.0;
/// Time behind the clock that is not made up for [s].
const BEHIND: f64 = 0.1;

/// The times at which steps and pictures are due.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    /// The next step.
    due: Instant,
    last_picture: Instant,
}

impl Pace {
    /// A step is due now.
    #[must_use]
    pub fn new() -> Self {
        Self { due: Instant::now(), last_picture: Instant::now() }
    }
}

impl Default for Pace {
    fn default() -> Self {
        Self::new()
    }
}

impl Simulation {
    /// Runs until the window is gone; calls `wake` when there is something new in the slot.
    pub fn run(mut self, commands: &Receiver<Command>, slot: &Slot, wake: &dyn Fn()) {
        let mut pace = Pace::new();
        self.show(slot, wake, 1.0);
        loop {
            let between = self.is_slow();
            let command = if self.is_playing() {
                let mut until = pace.due;
                if between {
                    until = until.min(pace.last_picture + Duration::from_secs_f64(PICTURE_TIME));
                }
                match commands.recv_timeout(until.saturating_duration_since(Instant::now())) {
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
                // A queue of mouse moves makes one picture.
                let all = std::iter::once(command).chain(commands.try_iter());
                if !self.obey_all(all, &mut pace, slot, wake) {
                    return;
                }
                if !self.is_playing() {
                    self.show(slot, wake, 1.0);
                    continue;
                }
            }
            let now = Instant::now();
            if !self.step_if_due(&mut pace, now) && !between {
                continue;
            }
            let late = pace.last_picture.elapsed().as_secs_f64() > PICTURE_TIME;
            let taken = slot.lock().unwrap_or_else(PoisonError::into_inner).is_none();
            if taken && (late || !between) || !self.is_playing() || late && now >= pace.due {
                self.show(slot, wake, self.part(&pace));
                pace.last_picture = Instant::now();
            }
        }
    }

    /// The part of [`Self::run`] between two pictures, for at most `budget` and a step. Carries out
    /// the commands, takes the steps that are due, puts the picture into the slot. Returns false
    /// when the window is gone.
    pub fn pump(
        &mut self,
        commands: &Receiver<Command>,
        slot: &Slot,
        pace: &mut Pace,
        budget: Duration,
    ) -> bool {
        let mut asked = commands.try_iter().peekable();
        let mut new = asked.peek().is_some();
        if !self.obey_all(asked, pace, slot, &|| ()) {
            return false;
        }
        let begin = Instant::now();
        // Pictures that come seldom get the steps of a tenth of a second each.
        let behind = begin.checked_sub(Duration::from_secs_f64(BEHIND));
        pace.due = behind.map_or(pace.due, |behind| pace.due.max(behind));
        while self.is_playing() && self.step_if_due(pace, Instant::now()) {
            new = true;
            if begin.elapsed() >= budget {
                break;
            }
        }
        if new || self.is_playing() && self.is_slow() {
            self.show(slot, &|| (), self.part(pace));
        }
        true
    }

    /// Returns false when the window is gone.
    fn obey_all(
        &mut self,
        commands: impl Iterator<Item = Command>,
        pace: &mut Pace,
        slot: &Slot,
        wake: &dyn Fn(),
    ) -> bool {
        let was_playing = self.is_playing();
        for command in commands {
            match command {
                Command::Quit => return false,
                Command::Open(_) => {
                    self.say("opening …");
                    self.show(slot, wake, 1.0);
                }
                _ => {}
            }
            self.obey(command);
        }
        if self.is_playing() && !was_playing {
            pace.due = Instant::now();
        }
        true
    }

    fn step_if_due(&mut self, pace: &mut Pace, now: Instant) -> bool {
        if now < pace.due {
            return false;
        }
        self.step();
        pace.due += self.wait();
        if now.saturating_duration_since(pace.due).as_secs_f64() > BEHIND {
            // Too slow for real time: it is not made up for.
            pace.due = now;
        }
        true
    }

    /// How much of the way from the last step but one to the last one has passed.
    fn part(&self, pace: &Pace) -> f32 {
        if !self.is_slow() || !self.is_playing() {
            return 1.0;
        }
        let left = pace.due.saturating_duration_since(Instant::now()).as_secs_f64();
        #[expect(clippy::cast_possible_truncation, reason = "a part of a step")]
        let part = (1.0 - left / self.wait().as_secs_f64()) as f32;
        part.clamp(0.0, 1.0)
    }

    /// Time between steps.
    fn wait(&self) -> Duration {
        let wait = f64::from(self.step_time()) / f64::from(self.speed().max(0.01));
        Duration::from_secs_f64(wait.clamp(1.0e-6, 3600.0))
    }

    /// Whether there are pictures between steps.
    pub(crate) fn is_slow(&self) -> bool {
        self.wait().as_secs_f64() > 1.2 * PICTURE_TIME
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;
    use std::time::Duration;

    use super::Pace;
    use crate::sim::tests::simulation;
    use crate::sim::{Command, Slot};

    #[test]
    fn a_pump_takes_the_steps_that_are_due_and_no_others() {
        let mut simulation = simulation("hello");
        let (sender, receiver) = channel();
        let (slot, mut pace) = (Slot::default(), Pace::new());
        let mut pump = |budget| {
            assert!(simulation.pump(&receiver, &slot, &mut pace, budget));
            slot.lock().unwrap().take().map(|shown| shown.step)
        };
        let long = Duration::from_secs(10);
        assert_eq!(pump(long), None, "it stands still, and nothing was asked");
        sender.send(Command::Play(true)).unwrap();
        assert_eq!(pump(long), Some(1), "one step is due at once");
        std::thread::sleep(Duration::from_millis(60));
        // Three steps are due after 50 ms; a slow machine may find more, up to 0.1 s.
        assert!((4..=10).contains(&pump(long).unwrap()));
        sender.send(Command::Seek(2)).unwrap();
        assert_eq!(pump(long), Some(2));
        sender.send(Command::Play(true)).unwrap();
        std::thread::sleep(Duration::from_millis(60));
        assert_eq!(pump(Duration::ZERO), Some(3), "a budget that is spent still gives a step");
        sender.send(Command::Quit).unwrap();
        assert!(!simulation.pump(&receiver, &slot, &mut pace, long));
    }
}
