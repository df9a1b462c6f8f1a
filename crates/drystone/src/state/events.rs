//! What happened in the last step, in lists of a defined order.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::base::id::{BodyId, JointId, LinkId, ParticleId, ShapeId};
use crate::base::math::Vec3;

/// Two shapes began or ceased to touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct ContactEvent {
    /// First shape.
    pub shape_a: ShapeId,
    /// Second shape.
    pub shape_b: ShapeId,
    /// Body of the first shape.
    pub body_a: BodyId,
    /// Body of the second shape.
    pub body_b: BodyId,
}

/// Two shapes met at speed: they began to touch, or points of them landed that bore nothing before.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct HitEvent {
    /// First shape.
    pub shape_a: ShapeId,
    /// Second shape.
    pub shape_b: ShapeId,
    /// Body of the first shape.
    pub body_a: BodyId,
    /// Body of the second shape.
    pub body_b: BodyId,
    /// Where [m, world].
    pub point: Vec3,
    /// Contact normal from A to B [world].
    pub normal: Vec3,
    /// Speed along the normal before the hit [m/s], of the point that came fastest; above 0.
    pub speed: f32,
    /// Impulse along the normals of the pair in the step of the hit [N s]. Some of a hit may come in the next step, as the
    /// solver spreads a blow over a stack.
    pub impulse: f32,
}

/// What a pair of shapes that touch gave to each other in the step, and how hard it pressed. See
/// [`ContactReports::forces`](crate::events::ContactReports::forces).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct ContactForce {
    /// First shape.
    pub shape_a: ShapeId,
    /// Second shape.
    pub shape_b: ShapeId,
    /// Body of the first shape.
    pub body_a: BodyId,
    /// Body of the second shape.
    pub body_b: BodyId,
    /// Impulse of the whole step on B, friction included [N s, world]; A got the opposite.
    pub impulse: Vec3,
    /// Part of it along the normals, in sum over the points [N s]; at least 0.
    pub normal_impulse: f32,
    /// Mean force of the step on B, friction included [N, world]: the impulse over the time of the step.
    pub force: Vec3,
    /// Greatest force along the normal, as the mean over a substep [N]. Over a mesh it is the sum of those of the pair's
    /// manifolds, which may have been in different substeps. Shorter substeps show a higher peak of the same blow.
    pub greatest_force: f32,
    /// Where its points are in [`Events::force_points`], and how many.
    pub(crate) points: [u32; 2],
}

impl ContactForce {
    /// Mean force of the step on this body [N, world]; 0 for a body that is not of the pair.
    #[must_use]
    pub fn force_on(&self, body: BodyId) -> Vec3 {
        let sign =
            f32::from(u8::from(self.body_b == body)) - f32::from(u8::from(self.body_a == body));
        self.force * sign
    }
}

/// A point of a [`ContactForce`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct ForcePoint {
    /// Where [m, world].
    pub position: Vec3,
    /// Contact normal from A to B [world].
    pub normal: Vec3,
    /// Impulse of the whole step along the normal [N s]; at least 0.
    pub impulse: f32,
    /// Greatest force along the normal, as the mean over a substep [N].
    pub greatest_force: f32,
}

/// A shape entered or left a sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct SensorEvent {
    /// The sensor.
    pub sensor: ShapeId,
    /// The other shape.
    pub visitor: ShapeId,
    /// Body of the sensor.
    pub sensor_body: BodyId,
    /// Body of the other shape.
    pub visitor_body: BodyId,
}

/// A joint had to bear more than its strength, and was removed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct JointBreak {
    /// Its id, stale now.
    pub joint: JointId,
    /// Its first body.
    pub body_a: BodyId,
    /// Its second body.
    pub body_b: BodyId,
    /// Which limit it passed; the first of them if it was several.
    pub limit: JointLimit,
    /// Force that it had to bear [N].
    pub force: f32,
    /// Torque [N m].
    pub torque: f32,
    /// Impulse of the step [N s].
    pub impulse: f32,
    /// How far it was worn out; 1 is all.
    pub damage: f32,
}

/// What broke a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub enum JointLimit {
    /// Its force.
    Force,
    /// Its torque.
    Torque,
    /// Its impulse in a step.
    Impulse,
    /// Fatigue.
    Fatigue,
}

/// A bond of a glued body broke.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct BondBreak {
    /// The body, as it was called before.
    pub body: BodyId,
    /// The two shapes that it held together.
    pub shapes: [ShapeId; 2],
    /// Where [m, world].
    pub point: Vec3,
    /// Tension, that of bending included [Pa]; 0 under pressure.
    pub tension: f32,
    /// Shear, that of twisting included [Pa].
    pub shear: f32,
}

/// Why a body came apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub enum FractureCause {
    /// Its bonds broke: it goes on as the largest part, and the pieces are the others.
    Glue,
    /// A blow of too much impulse. The body is no more.
    Impulse,
    /// A blow of too much energy. The body is no more.
    Energy,
}

/// A body came apart.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct FractureEvent {
    /// The body; its id is stale now unless glue broke.
    pub body: BodyId,
    /// Why.
    pub cause: FractureCause,
    /// Where it was hit [m, world]; of glue: where the bond was that bore most for its strength.
    pub point: Vec3,
    /// Impulse [N s] or energy [J] of the blow; of glue: the stress over what the bond bore, 1 or more.
    pub value: f32,
    /// The limit that it passed; 1 of glue.
    pub limit: f32,
    /// Where its pieces are in [`Events::pieces`], and how many.
    pub(crate) pieces: [u32; 2],
}

/// A link between two particles was stretched too far or pulled too hard, and was removed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct LinkTear {
    /// Its id, stale now.
    pub link: LinkId,
    /// Its first particle.
    pub a: ParticleId,
    /// Its second particle.
    pub b: ParticleId,
    /// What it pulled with in the last substep [N]; below 0: it pushed.
    pub force: f32,
    /// How far it was stretched, as a part of its length.
    pub strain: f32,
}

/// What was wrong in a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub enum FaultKind {
    /// The state of a body or a particle became infinite or NaN: it was put back to its last good pose,
    /// stopped, and takes no further part until the user sets its pose or velocity.
    NotFinite,
    /// The time step given was not a finite number above 0: nothing was stepped.
    BadTimeStep,
}

/// Something went wrong in a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct Fault {
    /// The body, if it is about one.
    pub body: Option<BodyId>,
    /// The particle, if it is about one.
    pub particle: Option<ParticleId>,
    /// What was wrong.
    pub kind: FaultKind,
    /// Number of the step, the first is 1.
    pub step: u64,
}

/// What happened in the last step; cleared when the next begins. Every list is in the order of the
/// contacts' or bodies' slots, the same for any number of threads.
#[derive(Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct Events {
    /// Shapes that began to touch: the first step in which one pushed the other, if for a part of it only.
    pub contact_begin: Vec<ContactEvent>,
    /// Shapes that ceased to touch, also because one of them was removed.
    pub contact_end: Vec<ContactEvent>,
    /// Shapes that landed on each other faster than their hit speed, see [`ContactReports`](crate::events::ContactReports): they began
    /// to touch, or a part of them came down that bore nothing before. One for each pair. What flies so fast
    /// that it would pass what it meets is stopped there, and hits it in the next step.
    pub hits: Vec<HitEvent>,
    /// What pairs gave to each other of which a shape reports forces. Those that sleep give none.
    pub contact_forces: Vec<ContactForce>,
    /// Their points: see [`Self::points_of`].
    pub force_points: Vec<ForcePoint>,
    /// Shapes that entered a sensor.
    pub sensor_enter: Vec<SensorEvent>,
    /// Shapes that left a sensor.
    pub sensor_exit: Vec<SensorEvent>,
    /// Bodies that fell asleep.
    pub sleep: Vec<BodyId>,
    /// Bodies that woke.
    pub wake: Vec<BodyId>,
    /// Joints that broke, and are no more.
    pub joint_break: Vec<JointBreak>,
    /// Links between particles that tore, and are no more.
    pub link_tear: Vec<LinkTear>,
    /// Particles whose attachment ended because its body was removed.
    pub detached: Vec<ParticleId>,
    /// Bonds of glued bodies that broke.
    pub bond_break: Vec<BondBreak>,
    /// Bodies that came apart; what they broke into: [`Self::pieces_of`].
    pub fractures: Vec<FractureEvent>,
    /// New bodies, pieces of those that came apart.
    pub pieces: Vec<BodyId>,
    /// What went wrong.
    pub faults: Vec<Fault>,
}

impl Clone for Events {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Into the lists that are there.
    fn clone_from(&mut self, from: &Self) {
        let Self {
            contact_begin,
            contact_end,
            hits,
            contact_forces,
            force_points,
            sensor_enter,
            sensor_exit,
            sleep,
            wake,
            joint_break,
            link_tear,
            detached,
            bond_break,
            fractures,
            pieces,
            faults,
        } = from;
        self.contact_begin.clone_from(contact_begin);
        self.contact_end.clone_from(contact_end);
        self.hits.clone_from(hits);
        self.contact_forces.clone_from(contact_forces);
        self.force_points.clone_from(force_points);
        self.sensor_enter.clone_from(sensor_enter);
        self.sensor_exit.clone_from(sensor_exit);
        self.sleep.clone_from(sleep);
        self.wake.clone_from(wake);
        self.joint_break.clone_from(joint_break);
        self.link_tear.clone_from(link_tear);
        self.detached.clone_from(detached);
        self.bond_break.clone_from(bond_break);
        self.fractures.clone_from(fractures);
        self.pieces.clone_from(pieces);
        self.faults.clone_from(faults);
    }
}

impl Events {
    /// The new bodies that a body broke into, in the order in which they were made.
    #[must_use]
    pub fn pieces_of(&self, event: &FractureEvent) -> &[BodyId] {
        let [first, count] = event.pieces.map(|n| n as usize);
        self.pieces.get(first..first + count).unwrap_or_default()
    }

    /// The points of a pair, 1 to 4 for each of its manifolds; only pairs with a mesh have several. Of what turns so far that
    /// its contacts are made anew within the step some may be gone: the impulse of the pair is all the same that of all.
    #[must_use]
    pub fn points_of(&self, pair: &ContactForce) -> &[ForcePoint] {
        let [first, count] = pair.points.map(|n| n as usize);
        self.force_points.get(first..first + count).unwrap_or_default()
    }

    /// Mean force of the step that contacts gave to a body [N, world], as far as they report forces. Of a body that rests on
    /// contacts alone it is the opposite of its weight.
    #[must_use]
    pub fn contact_force_on(&self, body: BodyId) -> Vec3 {
        self.contact_forces.iter().fold(Vec3::ZERO, |sum, pair| sum + pair.force_on(body))
    }

    /// Between steps bodies wake and sleep in turn by hand: leaves of each what it came to, and nothing if that is as it was.
    pub(crate) fn settle_sleep(&mut self) {
        let Self { sleep, wake, .. } = self;
        if sleep.is_empty() {
            return;
        }
        sleep.sort_unstable();
        wake.sort_unstable();
        let count = |list: &[BodyId], body: BodyId| list.iter().filter(|b| **b == body).count();
        let all = sleep.clone();
        sleep.dedup();
        sleep.retain(|body| count(&all, *body) > count(wake, *body));
        let mut once = wake.clone();
        once.dedup();
        once.retain(|body| count(wake, *body) > count(&all, *body));
        *wake = once;
    }

    pub(crate) fn clear(&mut self) {
        self.contact_begin.clear();
        self.contact_end.clear();
        self.hits.clear();
        self.contact_forces.clear();
        self.force_points.clear();
        self.sensor_enter.clear();
        self.sensor_exit.clear();
        self.sleep.clear();
        self.wake.clear();
        self.joint_break.clear();
        self.link_tear.clear();
        self.detached.clear();
        self.bond_break.clear();
        self.fractures.clear();
        self.pieces.clear();
        self.faults.clear();
    }
}
