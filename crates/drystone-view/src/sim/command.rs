//! Commands of the window.

use drystone::{Vec3, WorldConfig};

use crate::overlay::Overlays;

/// A command of the window.
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
    /// The overlays over bodies.
    Overlays(Overlays),
    /// Take hold of the dynamic body on a ray of a side: origin, unit direction [m, world].
    Grab(Vec3, Vec3, usize),
    /// Pull the body that is held to this ray.
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

/// An action on a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Deed {
    /// It is taken away.
    Remove,
    /// A second one beside it.
    Duplicate,
    /// It is held where it is, or let go again.
    Freeze,
}
