//! Two other ways to run a program: its operations as calls in a journal, and worlds that roll back
//! to a saved state. Both must give the same result as the operations themselves.

use drystone::journal::{Answer, Call, Journal};
use drystone::particle::{LinkDef, Strand};
use drystone::snapshot::{apply_delta, write_delta};
use drystone::{BodyId, JointKind, World};

use crate::apply::{Done, Ids, body_def, joint_def, shape, shape_def};
use crate::finding::{Findings, Kind};
use crate::op::{BodyCall, JointCall, Op, ParticleCall, ShapeCall};
use crate::rng::Rng;

/// Number of damaged copies of a journal or a delta.
const COPIES: usize = 4;

/// A run whose calls are recorded.
#[derive(Debug)]
pub struct Written {
    journal: Journal,
}

impl Written {
    /// Begins with the world in its current state.
    #[must_use]
    pub fn begin(world: &World) -> Self {
        Self { journal: Journal::begin(world) }
    }

    /// Applies an operation other than a step.
    pub fn apply(&mut self, world: &mut World, ids: &mut Ids, op: &Op) -> Done {
        // Queries and ledgers change nothing.
        let Some(call) = call_of(op, ids, world) else { return Done::Skipped };
        match self.journal.call(world, call) {
            Ok(Answer::Nothing) => Done::Skipped,
            Ok(answer) => {
                learn(op, answer, ids, world);
                Done::Yes
            }
            Err(_) => Done::Refused,
        }
    }

    /// Takes a step of `dt` [s].
    pub fn step(&mut self, world: &mut World, dt: f32) {
        // The engine refuses no step.
        let _ = self.journal.call(world, Call::Step(dt));
    }

    /// Replays the run from its bytes, and from damaged copies.
    pub fn end(self, world: &World, findings: &mut Findings, step: u32) {
        let bytes = self.journal.to_bytes();
        let mut again = world.clone();
        let replayed = Journal::from_bytes(&bytes).and_then(|journal| journal.replay(&mut again));
        if let Err(why) = replayed {
            findings.add(Kind::HashDiffers, "a journal that is made again", why.to_string(), step);
        } else if again.state_hash() != world.state_hash() {
            findings.add(Kind::HashDiffers, "what a journal comes to", "", step);
        }
        let mut rng = Rng::new(world.state_hash());
        for _ in 0..COPIES {
            let mut damaged = bytes.clone();
            crate::damage::bytes(&mut damaged, &mut rng);
            if damaged != bytes && Journal::from_bytes(&damaged).is_ok() {
                findings.add(Kind::SnapshotRefused, "a damaged journal is read", "", step);
            }
        }
    }
}

/// The call of an operation, if all objects that it names exist and can be built.
#[must_use]
pub fn call_of(op: &Op, ids: &Ids, world: &World) -> Option<Call> {
    let body = |label| ids.bodies.get(label).copied();
    let particle = |label| ids.particles.get(label).copied();
    Some(match op {
        Op::AddBody(plan) => Call::AddBody(Box::new(body_def(plan)?)),
        Op::AddShape(label, plan) => Call::AddShape(body(label)?, Box::new(shape_def(plan)?)),
        Op::RemoveBody(label) => Call::RemoveBody(body(label)?),
        Op::RemoveShape(label) => Call::RemoveShape(*ids.shapes.get(label)?),
        Op::AddJoint(plan) => {
            let [a, b] = plan.bodies;
            Call::AddJoint(Box::new(joint_def([body(&a)?, body(&b)?], plan)))
        }
        Op::RemoveJoint(label) => Call::RemoveJoint(*ids.joints.get(label)?),
        Op::AddCoupling(plan) => {
            let [a, b] = plan.joints.map(|label| ids.joints.get(&label).copied());
            let [axis_a, axis_b] = plan.axes;
            Call::AddCoupling(drystone::joint::CouplingDef {
                joint_a: a?,
                axis_a,
                joint_b: b?,
                axis_b,
                ratio: plan.ratio,
                offset: plan.offset,
            })
        }
        Op::SetJointAxes(label, axes) => {
            let id = *ids.joints.get(label)?;
            let mut axes = axes.clone();
            if let Some(JointKind::SixDof(now)) = world.joint(id).map(|joint| joint.kind()) {
                (axes.frame_a, axes.frame_b) = (now.frame_a, now.frame_b);
            }
            Call::Joint(id, drystone::journal::JointCall::SetAxes(axes))
        }
        Op::SetJointDrive(label, axis, drive) => {
            let call = drystone::journal::AxisCall::SetDrive(*drive);
            Call::Joint(
                *ids.joints.get(label)?,
                drystone::journal::JointCall::Axis(Some(*axis), call),
            )
        }
        Op::SetJointStrength(label, strength) => Call::Joint(
            *ids.joints.get(label)?,
            drystone::journal::JointCall::SetStrength(*strength),
        ),
        Op::Joint(label, call) => Call::Joint(*ids.joints.get(label)?, joint_call(call)),
        Op::AddParticle(_, def) => Call::AddParticle(def.clone()),
        Op::AddRope(_, _, def) => Call::AddRope(def.clone()),
        Op::AddCloth(_, _, def) => Call::AddCloth(def.clone()),
        Op::AddCloud(_, points, def) => Call::AddCloud(points.clone(), def.clone()),
        Op::RemoveParticle(label) => Call::RemoveParticle(particle(label)?),
        Op::AddLink(plan) => {
            let [a, b] = plan.ends;
            let (a, b) = (particle(&a)?, particle(&b)?);
            let def = LinkDef::new(a, b, plan.kind);
            let (tear_strain, tear_force) = (plan.tear_strain, plan.tear_force);
            Call::AddLink(LinkDef { length: plan.length, tear_strain, tear_force, ..def })
        }
        Op::RemoveLink(label) => Call::RemoveLink(*ids.links.get(label)?),
        Op::SetLinkLength(label, length) => Call::SetLinkLength(*ids.links.get(label)?, *length),
        Op::Attach(label, to, point) => {
            let call = drystone::journal::ParticleCall::Attach(body(to)?, *point);
            Call::Particle(particle(label)?, call)
        }
        Op::Detach(label) => {
            Call::Particle(particle(label)?, drystone::journal::ParticleCall::Detach)
        }
        Op::Body(label, call) => Call::Body(body(label)?, body_call(call)),
        Op::Shape(label, call) => Call::Shape(*ids.shapes.get(label)?, shape_call(call)?),
        Op::Particle(label, call) => Call::Particle(particle(label)?, particle_call(call)),
        Op::FractureBody(label, point, how) => Call::BreakAt(body(label)?, *point, *how),
        Op::SetFracture(label, how) => {
            Call::Body(body(label)?, drystone::journal::BodyCall::SetFracture(*how))
        }
        Op::SetBondStrength(label, strength) => {
            Call::Body(body(label)?, drystone::journal::BodyCall::SetBondStrength(*strength))
        }
        Op::SetConfig(config) => Call::SetConfig(config.clone()),
        Op::SetGravity(gravity) => Call::SetGravity(*gravity),
        Op::ShiftOrigin(origin) => Call::ShiftOrigin(*origin),
        Op::SurfaceBetween(a, b, rule) => Call::SetSurfaceBetween(body(a)?, body(b)?, *rule),
        Op::WakeAll => Call::WakeAll,
        Op::Step(dt, _) => Call::Step(*dt),
        Op::BeginLedger | Op::EndLedger | Op::Query(_) | Op::Impact(..) => return None,
    })
}

/// Gives labels to the objects that a call made.
fn learn(op: &Op, answer: Answer, ids: &mut Ids, world: &World) {
    match (op, answer) {
        (Op::AddBody(plan), Answer::Body(id)) => ids.take_body(plan, id, world),
        (Op::AddShape(_, plan), Answer::Shape(id)) => {
            ids.shapes.insert(plan.label, id);
        }
        (Op::AddJoint(plan), Answer::Joint(id)) => {
            ids.joints.insert(plan.label, id);
        }
        (Op::AddCoupling(plan), Answer::Joint(id)) => {
            ids.joints.insert(plan.label, id);
        }
        (Op::AddParticle(label, _), Answer::Particle(id)) => {
            ids.particles.insert(*label, id);
        }
        (Op::AddLink(plan), Answer::Link(id)) => {
            ids.links.insert(plan.label, id);
        }
        (Op::AddRope(first, link, _) | Op::AddCloth(first, link, _), Answer::Strand(strand)) => {
            ids.take_strand(*first, *link, &strand);
        }
        (Op::AddCloud(first, ..), Answer::Strand(strand)) => {
            ids.take_strand(*first, 0, &Strand { links: Vec::new(), ..strand });
        }
        _ => {}
    }
}

fn joint_call(call: &JointCall) -> drystone::journal::JointCall {
    use drystone::journal::{AxisCall as On, JointCall as To};
    match call {
        JointCall::Anchors(a, b) => To::SetAnchors(*a, *b),
        JointCall::Frames(a, b) => To::SetFrames(*a, *b),
        JointCall::Kind(kind) => To::SetKind(kind.clone()),
        JointCall::Lengths(min, max) => To::SetLengths(*min, *max),
        JointCall::Spring(spring) => To::SetSpring(*spring),
        JointCall::Motion(axis, motion) => To::Axis(Some(*axis), On::SetMotion(*motion)),
        JointCall::Limits(min, max) => To::Axis(None, On::SetLimits(*min, *max)),
        JointCall::Motor(speed, most) => To::Axis(None, On::SetMotor(*speed, *most)),
        JointCall::Friction(friction) => To::Axis(None, On::SetFriction(*friction)),
        JointCall::TargetRotation(rotation, spring, most) => {
            To::SetTargetRotation(*rotation, *spring, *most)
        }
        JointCall::Coupling(ratio, offset) => To::SetCoupling(*ratio, *offset),
        JointCall::CollideConnected(collide) => To::SetCollideConnected(*collide),
        JointCall::Enabled(enabled) => To::SetEnabled(*enabled),
    }
}

fn body_call(call: &BodyCall) -> drystone::journal::BodyCall {
    use drystone::journal::BodyCall as To;
    match call {
        BodyCall::Wake => To::Wake,
        BodyCall::Pose(pose) => To::SetPose(*pose),
        BodyCall::LinearVelocity(v) => To::SetLinearVelocity(*v),
        BodyCall::AngularVelocity(w) => To::SetAngularVelocity(*w),
        BodyCall::MoveTo(pose, time) => To::MoveTo(*pose, *time),
        BodyCall::Impulse(p) => To::ApplyImpulse(*p),
        BodyCall::ImpulseAt(p, at) => To::ApplyImpulseAt(*p, *at),
        BodyCall::AngularImpulse(p) => To::ApplyAngularImpulse(*p),
        BodyCall::StepForce(f) => To::AddStepForce(*f),
        BodyCall::StepForceAt(f, at) => To::AddStepForceAt(*f, *at),
        BodyCall::StepTorque(t) => To::AddStepTorque(*t),
        BodyCall::LastingForce(f) => To::SetLastingForce(*f),
        BodyCall::LastingTorque(t) => To::SetLastingTorque(*t),
        BodyCall::GravityScale(scale) => To::SetGravityScale(*scale),
        BodyCall::Damping(linear, angular) => To::SetDamping(*linear, *angular),
        BodyCall::Locks(locks) => To::SetLocks(*locks),
        BodyCall::CanSleep(can) => To::SetCanSleep(*can),
        BodyCall::UserData(data) => To::SetUserData(*data),
        BodyCall::Kind(kind) => To::SetKind(*kind),
        BodyCall::Mass(mass) => To::SetMass(*mass),
        BodyCall::Enabled(enabled) => To::SetEnabled(*enabled),
        BodyCall::Sleep => To::Sleep,
        BodyCall::SleepSpeed(speed) => To::SetSleepSpeed(*speed),
        BodyCall::Correct(pose, v, w) => To::CorrectState(*pose, *v, *w),
    }
}

fn shape_call(call: &ShapeCall) -> Option<drystone::journal::ShapeCall> {
    use drystone::journal::ShapeCall as To;
    Some(match call {
        ShapeCall::Material(material) => To::SetMaterial(*material),
        ShapeCall::SurfaceVelocity(v) => To::SetSurfaceVelocity(*v),
        ShapeCall::SurfaceSpin(w) => To::SetSurfaceSpin(*w),
        ShapeCall::Filter(filter) => To::SetFilter(*filter),
        ShapeCall::Sensor(sensor) => To::SetSensor(*sensor),
        ShapeCall::Density(density) => To::SetDensity(*density),
        ShapeCall::LocalPose(pose) => To::SetLocalPose(*pose),
        ShapeCall::Geometry(form) => To::SetGeometry(shape(form)?),
        ShapeCall::Enabled(enabled) => To::SetEnabled(*enabled),
        ShapeCall::Reports(reports) => To::SetReports(*reports),
        ShapeCall::Senses(senses) => To::SetSenses(*senses),
        ShapeCall::OneWay(front) => To::SetOneWay(*front),
    })
}

fn particle_call(call: &ParticleCall) -> drystone::journal::ParticleCall {
    use drystone::journal::ParticleCall as To;
    match call {
        ParticleCall::Position(x) => To::SetPosition(*x),
        ParticleCall::Velocity(v) => To::SetVelocity(*v),
        ParticleCall::Impulse(p) => To::ApplyImpulse(*p),
        ParticleCall::Mass(mass) => To::SetMass(*mass),
        ParticleCall::Pinned(pinned) => To::SetPinned(*pinned),
    }
}

/// Saved states of a run: a copy, and bytes.
#[derive(Debug, Default)]
pub struct Past {
    kept: World,
    base: Vec<u8>,
    snapshot: Vec<u8>,
    delta: Vec<u8>,
    turns: u32,
}

impl Past {
    /// Changes and steps the world, then restores it: from a copy, from bytes, or from a delta
    /// against the previous bytes.
    pub fn there_and_back(&mut self, world: &mut World, findings: &mut Findings, step: u32) {
        self.turns += 1;
        let as_copy = self.turns.is_multiple_of(3);
        if as_copy {
            self.kept.clone_from(world);
        } else {
            core::mem::swap(&mut self.base, &mut self.snapshot);
            world.snapshot_into(&mut self.snapshot);
        }
        let bodies: Vec<BodyId> = world.bodies().map(|body| body.id()).collect();
        for body in bodies.iter().step_by(3) {
            world.remove_body(*body);
        }
        world.wake_all();
        for _ in 0..self.turns % 4 {
            world.step(1.0 / 60.0);
        }
        if as_copy {
            world.clone_from(&self.kept);
            return;
        }
        if self.turns % 3 == 1 {
            write_delta(&self.base, &self.snapshot, &mut self.delta);
            self.damage(findings, step);
            let mut again = Vec::new();
            if let Err(why) = apply_delta(&self.base, &self.delta, &mut again) {
                findings.add(Kind::SnapshotRefused, why.to_string(), "", step);
            } else if again != self.snapshot {
                findings.add(Kind::HashDiffers, "a delta comes to other bytes", "", step);
            }
            self.snapshot = again;
        }
        if let Err(why) = world.restore_from(&self.snapshot) {
            findings.add(Kind::SnapshotRefused, why.to_string(), "", step);
        }
    }

    /// Checks that a damaged delta is refused, or gives the same bytes.
    fn damage(&self, findings: &mut Findings, step: u32) {
        let mut rng = Rng::new(u64::from(step));
        for _ in 0..COPIES {
            let (mut damaged, mut made) = (self.delta.clone(), Vec::new());
            crate::damage::bytes(&mut damaged, &mut rng);
            let applied = apply_delta(&self.base, &damaged, &mut made);
            if applied.is_ok() && made != self.snapshot {
                findings.add(Kind::SnapshotRefused, "a damaged delta is applied", "", step);
            }
        }
    }
}
