//! Actions on the bodies of a scene while it runs, besides physics.

use std::sync::Arc;

use drystone::math::trig;
use drystone::{Vec3, vec3};

use super::film::Film;
use super::parts::{SceneBody, SceneJoint};

/// Actions on the bodies while the scene runs, besides physics.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub enum Script {
    /// Nothing.
    #[default]
    None,
    /// Before every step, the kinematic body `body` is aimed at a point `radius` from `center` in
    /// the xz plane. The point's angle grows by `degrees_per_step` from 0. The body's velocity
    /// becomes the distance to the point over the step time. It starts at angle 0.
    Orbit {
        /// Number of the body.
        body: usize,
        /// Center of the circle [m].
        center: Vec3,
        /// Radius [m].
        radius: f32,
        /// Degrees a step, with sign.
        degrees_per_step: f32,
    },
    /// Before steps `every`, 2 `every`, … (counted from 0) one more of `bodies` is added, in order,
    /// until all are there. They are not in [`Scene::bodies`](super::Scene::bodies).
    Drop {
        /// Steps between two of them.
        every: u64,
        /// The bodies.
        bodies: Vec<SceneBody>,
    },
    /// Lasting forces and torques act on dynamic bodies.
    Loads {
        /// The first step with them, counted from 0.
        from: u64,
        /// The loads.
        loads: Vec<Load>,
    },
    /// The bodies, none of which is dynamic, are where a film has them.
    Film(Arc<Film>),
    /// Groups of bodies come, and go, before certain steps.
    Waves(Vec<Wave>),
}

/// A force that acts on a dynamic body in every step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load {
    /// Number of the body.
    pub body: usize,
    /// At its center of mass [N, world].
    pub force: Vec3,
    /// About it [N m, world].
    pub torque: Vec3,
}

/// Bodies that leave and bodies with their joints that join before a step. The numbers of bodies go
/// on from those of the scene in the order in which they come.
#[derive(Clone, Debug)]
pub struct Wave {
    /// Before which step, counted from 0; waves are in the order of their steps.
    pub step: u64,
    /// Numbers of the bodies that leave, with their joints.
    pub removed: core::ops::Range<usize>,
    /// Bodies that join.
    pub bodies: Vec<SceneBody>,
    /// Joints that are added then.
    pub joints: Vec<SceneJoint>,
}

/// The action of a script before one step.
#[derive(Clone, Copy, Debug)]
pub enum ScriptAction<'a> {
    /// Nothing.
    None,
    /// The kinematic body `body` gets the velocity that takes it to `position` in the step, without
    /// a turn.
    Aim {
        /// Number of the body.
        body: usize,
        /// Where its origin is to be after the step [m].
        position: Vec3,
    },
    /// This body joins.
    Add(&'a SceneBody),
    /// Bodies leave and join.
    Wave(&'a Wave),
    /// From now on these act.
    Loads(&'a [Load]),
    /// Every body is where this film has it after the step.
    Film(&'a Film),
}

impl Script {
    /// The bodies that join while the scene runs, in the order in which they come.
    pub fn joining(&self) -> impl Iterator<Item = &SceneBody> {
        let (dropped, waves): (&[SceneBody], &[Wave]) = match self {
            Self::Drop { bodies, .. } => (bodies, &[]),
            Self::Waves(waves) => (&[], waves),
            _ => (&[], &[]),
        };
        dropped.iter().chain(waves.iter().flat_map(|w| &w.bodies))
    }

    /// The action before step `step`, counted from 0.
    #[must_use]
    pub fn action(&self, step: u64) -> ScriptAction<'_> {
        match self {
            Self::None => ScriptAction::None,
            &Self::Orbit { body, center, radius, degrees_per_step } => {
                let position = orbit_point(center, radius, degrees_per_step, step + 1);
                ScriptAction::Aim { body, position }
            }
            Self::Drop { every, bodies } => {
                let every = (*every).max(1);
                let number = (step / every).checked_sub(1).filter(|_| step.is_multiple_of(every));
                let body = number.and_then(|n| bodies.get(usize::try_from(n).ok()?));
                body.map_or(ScriptAction::None, ScriptAction::Add)
            }
            Self::Loads { from, loads } if step == *from => ScriptAction::Loads(loads),
            Self::Loads { .. } => ScriptAction::None,
            Self::Film(film) => ScriptAction::Film(film),
            Self::Waves(waves) => {
                let wave = waves.binary_search_by_key(&step, |w| w.step).ok();
                wave.map_or(ScriptAction::None, |i| ScriptAction::Wave(&waves[i]))
            }
        }
    }
}

/// Where an orbiting body is to be after `steps` steps.
fn orbit_point(center: Vec3, radius: f32, degrees_per_step: f32, steps: u64) -> Vec3 {
    // The angle is kept within a turn in f64: a step's part of it would be lost in f32 after a
    // while.
    let degrees = (f64::from(degrees_per_step) * steps as f64) % 360.0;
    #[expect(clippy::cast_possible_truncation, reason = "within ±2π")]
    let angle = degrees.to_radians() as f32;
    let (s, c) = trig::sin_cos(angle);
    center + vec3(c, 0.0, s) * radius
}
