//! All tables of a world.

use serde::{Deserialize, Serialize};

use super::bodies::Bodies;
use super::bounds::Bounds;
use super::breakage::Breakage;
use super::colors::Colors;
use super::config::WorldConfig;
use super::contacts::Contacts;
use super::events::Events;
use super::islands::Islands;
use super::joints::Joints;
use super::particles::Particles;
use super::shapes::Shapes;

/// Everything that lives from step to step.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Tables {
    pub(crate) config: WorldConfig,
    pub(crate) bodies: Bodies,
    pub(crate) shapes: Shapes,
    pub(crate) joints: Joints,
    pub(crate) particles: Particles,
    pub(crate) contacts: Contacts,
    pub(crate) bounds: Bounds,
    pub(crate) islands: Islands,
    pub(crate) colors: Colors,
    pub(crate) events: Events,
    pub(crate) breakage: Breakage,
    /// Steps taken.
    pub(crate) steps: u64,
}
