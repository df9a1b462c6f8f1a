//! All tables of a world.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::articulations::Articulations;
use super::bodies::Bodies;
use super::bounds::Bounds;
use super::breakage::Breakage;
use super::colors::Colors;
use super::contacts::Contacts;
use super::def::config::WorldConfig;
use super::events::Events;
use super::islands::Islands;
use super::joints::Joints;
use super::particles::Particles;
use super::sets::Sets;
use super::shapes::Shapes;

/// All state that persists between steps.
#[derive(Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Tables {
    pub(crate) config: WorldConfig,
    pub(crate) bodies: Bodies,
    pub(crate) shapes: Shapes,
    pub(crate) joints: Joints,
    pub(crate) articulations: Articulations,
    pub(crate) particles: Particles,
    pub(crate) contacts: Contacts,
    pub(crate) bounds: Bounds,
    pub(crate) islands: Islands,
    pub(crate) colors: Colors,
    pub(crate) events: Events,
    pub(crate) breakage: Breakage,
    /// Number of steps taken.
    pub(crate) steps: u64,
}

/// Tables and values that stages use individually, beside [`Sets`].
#[derive(Debug)]
pub(crate) struct Others<'a> {
    pub(crate) config: &'a WorldConfig,
    pub(crate) shapes: &'a mut Shapes,
    pub(crate) articulations: &'a mut Articulations,
    pub(crate) particles: &'a mut Particles,
    pub(crate) bounds: &'a mut Bounds,
    pub(crate) breakage: &'a Breakage,
    pub(crate) steps: u64,
}

impl Tables {
    /// Lends all tables to the stages of a step.
    pub(crate) fn lend(&mut self) -> (Sets<'_>, Others<'_>) {
        let sets = Sets {
            bodies: &mut self.bodies,
            joints: &mut self.joints,
            contacts: &mut self.contacts,
            islands: &mut self.islands,
            colors: &mut self.colors,
            events: &mut self.events,
        };
        let others = Others {
            config: &self.config,
            shapes: &mut self.shapes,
            articulations: &mut self.articulations,
            particles: &mut self.particles,
            bounds: &mut self.bounds,
            breakage: &self.breakage,
            steps: self.steps,
        };
        (sets, others)
    }
}

impl Clone for Tables {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Reuses the existing lists.
    fn clone_from(&mut self, from: &Self) {
        let Self {
            config,
            bodies,
            shapes,
            joints,
            articulations,
            particles,
            contacts,
            bounds,
            islands,
            colors,
            events,
            breakage,
            steps,
        } = from;
        self.config.clone_from(config);
        self.bodies.clone_from(bodies);
        self.shapes.clone_from(shapes);
        self.joints.clone_from(joints);
        self.articulations.clone_from(articulations);
        self.particles.clone_from(particles);
        self.contacts.clone_from(contacts);
        self.bounds.clone_from(bounds);
        self.islands.clone_from(islands);
        self.colors.clone_from(colors);
        self.events.clone_from(events);
        self.breakage.clone_from(breakage);
        self.steps = *steps;
    }
}
