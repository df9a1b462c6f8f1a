//! The pictures of the worlds that are shown.

use std::sync::{Arc, PoisonError};

use drystone_render::{Look, Subject};

use super::shown::{Shown, Slot, View};
use super::simulation::Simulation;
use crate::side::Side;
use crate::{overlay, picked};

impl Simulation {
    /// The pictures and numbers now.
    pub fn shown(&mut self) -> Shown {
        self.shown_at(1.0)
    }

    /// The pictures and numbers at `part` of the way from the step before the last one to the last
    /// one.
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
            held: self.grab.and_then(|grab| grab.line(world)),
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
        let world = &self.sides[number].history.now().world;
        let held = self.grab.and_then(|grab| grab.line(world));
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
}
