//! Poses of bodies over time.

use drystone::Pose;

use crate::scene::Scene;

/// Where the bodies were at some times.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Motion {
    /// Times, rising [s].
    pub times: Vec<f32>,
    /// Poses of each body's origin at these times [world], `[body][time]`. A shorter list belongs
    /// to the last times: the body appeared later and is hidden before.
    pub poses: Vec<Vec<Pose>>,
    /// Number of the last times at which each body was gone. Its poses are those before, and it is
    /// hidden again. Bodies beyond the end of the list stay.
    pub gone: Vec<usize>,
}

impl Motion {
    /// No motion of the bodies of a scene: every node is where the document has it.
    #[must_use]
    pub fn still(scene: &Scene) -> Self {
        Self { poses: vec![Vec::new(); scene.bodies.len()], ..Self::default() }
    }

    /// The first of the times at which a body was there.
    pub(super) fn first(&self, body: usize) -> usize {
        let gone = self.gone.get(body).copied().unwrap_or(0);
        self.times.len().saturating_sub(gone + self.poses[body].len())
    }
}
