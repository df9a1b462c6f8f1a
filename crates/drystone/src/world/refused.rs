//! Records a fault of the next step for each refused per-frame call. The fault names the call and
//! the object.

use super::World;
use super::body::BodyMut;
use super::joint::axis::AxisMut;
use super::joint::change::JointMut;
use super::particle::{LinkMut, ParticleMut};
use super::shape::ShapeMut;
use crate::base::id::{BodyId, JointId, ParticleId};
use crate::state::def::DefError;
use crate::state::events::{Fault, FaultKind, FrameCall};

/// The object of a call, which its fault names. All `None`: the world.
#[derive(Clone, Copy, Default)]
pub(crate) struct Whom {
    body: Option<BodyId>,
    joint: Option<JointId>,
    particle: Option<ParticleId>,
}

/// A type with per-frame calls.
pub(crate) trait Told: Sized {
    fn whom(&self) -> Whom;

    fn world(&mut self) -> &mut World;

    /// Makes a call and records a fault if it was refused.
    fn attempt(
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
    /// Records a fault for the next step if `done` is an error. Returns `done`.
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
