//! Keeps what calls of each frame are refused for: a fault of the next step, which names the call and whom it was made of.

use super::World;
use super::body::BodyMut;
use super::joint_axis::AxisMut;
use super::joint_mut::JointMut;
use super::particle::{LinkMut, ParticleMut};
use super::shape::ShapeMut;
use crate::base::id::{BodyId, JointId, ParticleId};
use crate::state::def::DefError;
use crate::state::events::{Fault, FaultKind, FrameCall};

/// Whom a call is made of: whom its fault names. Nobody: the world.
#[derive(Clone, Copy, Default)]
pub(super) struct Whom {
    body: Option<BodyId>,
    joint: Option<JointId>,
    particle: Option<ParticleId>,
}

/// What has calls of each frame.
pub(super) trait Told: Sized {
    fn whom(&self) -> Whom;

    fn world(&mut self) -> &mut World;

    /// Makes a call, and notes it if it was refused.
    fn told(
        &mut self,
        call: FrameCall,
        make: impl FnOnce(&mut Self) -> Result<(), DefError>,
    ) -> Result<(), DefError> {
        let done = make(self);
        let whom = self.whom();
        self.world().note_refused(done, call, whom)
    }
}

impl Told for World {
    fn whom(&self) -> Whom {
        Whom::default()
    }

    fn world(&mut self) -> &mut World {
        self
    }
}

impl Told for BodyMut<'_> {
    fn whom(&self) -> Whom {
        Whom { body: Some(self.get().id()), ..Whom::default() }
    }

    fn world(&mut self) -> &mut World {
        self.world
    }
}

impl Told for ShapeMut<'_> {
    fn whom(&self) -> Whom {
        Whom { body: Some(self.get().body()), ..Whom::default() }
    }

    fn world(&mut self) -> &mut World {
        self.world
    }
}

impl Told for ParticleMut<'_> {
    fn whom(&self) -> Whom {
        Whom { particle: Some(self.get().id()), ..Whom::default() }
    }

    fn world(&mut self) -> &mut World {
        self.world
    }
}

impl Told for LinkMut<'_> {
    fn whom(&self) -> Whom {
        let [particle, _] = self.get().particles();
        Whom { particle: Some(particle), ..Whom::default() }
    }

    fn world(&mut self) -> &mut World {
        self.world
    }
}

impl Told for JointMut<'_> {
    fn whom(&self) -> Whom {
        Whom { joint: Some(self.get().id()), ..Whom::default() }
    }

    fn world(&mut self) -> &mut World {
        self.world
    }
}

impl Told for AxisMut<'_, '_> {
    fn whom(&self) -> Whom {
        self.joint.whom()
    }

    fn world(&mut self) -> &mut World {
        self.joint.world
    }
}

impl World {
    /// Keeps a fault for the next step, if a call was refused; gives back what it was given.
    fn note_refused(
        &mut self,
        done: Result<(), DefError>,
        call: FrameCall,
        whom: Whom,
    ) -> Result<(), DefError> {
        if done.is_err() {
            let Whom { body, joint, particle } = whom;
            let step = self.tables.steps + 1;
            let kind = FaultKind::Refused(call);
            self.pending.faults.push(Fault { body, joint, particle, kind, step });
        }
        done
    }
}
