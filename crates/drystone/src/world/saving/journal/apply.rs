//! Execution of a [`Call`].

use super::call::{Answer, AxisCall, BodyCall, Call, JointCall, ParticleCall, ShapeCall};
use crate::state::def::DefError;
use crate::state::events::FrameCall;
use crate::world::World;
use crate::world::body::BodyMut;
use crate::world::joint::axis::AxisMut;
use crate::world::joint::change::JointMut;
use crate::world::particle::ParticleMut;
use crate::world::particle::strand::Strand;
use crate::world::refused::Told as _;
use crate::world::shape::ShapeMut;

type Answered = Result<Answer, DefError>;

impl World {
    /// Makes a call given as data. Returns the answer of the function that the call names, and
    /// [`Answer::Nothing`] for a stale id.
    ///
    /// ```
    /// # fn main() -> Result<(), drystone::DefError> {
    /// use drystone::{BodyDef, ShapeDef, World, vec3};
    /// use drystone::journal::{Answer, BodyCall, Call};
    ///
    /// let mut world = World::default();
    /// let ball = BodyDef::dynamic().with_shape(ShapeDef::sphere(0.5));
    /// let Answer::Body(ball) = world.apply(&Call::AddBody(Box::new(ball)))? else { return Ok(()) };
    /// world.apply(&Call::Body(ball, BodyCall::SetLinearVelocity(vec3(1.0, 0.0, 0.0))))?;
    /// world.apply(&Call::Step(1.0 / 60.0))?;
    /// assert!(world.body(ball).is_some_and(|ball| ball.position().x > 0.0));
    /// assert_eq!(world.apply(&Call::RemoveBody(ball)), Ok(Answer::Done));
    /// assert_eq!(world.apply(&Call::RemoveBody(ball)), Ok(Answer::Nothing));
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// The field that is out of range; then nothing is changed. A refused per-frame call is also a
    /// fault of the next step, as if its function had been called.
    pub fn apply(&mut self, call: &Call) -> Answered {
        match call {
            Call::Step(dt) => {
                self.step(*dt);
                Ok(Answer::Done)
            }
            Call::SetConfig(config) => done(self.set_config((**config).clone())),
            Call::SetGravity(gravity) => {
                done(self.attempt(FrameCall::SetGravity, |of| of.try_set_gravity(*gravity)))
            }
            Call::WakeAll => {
                self.wake_all();
                Ok(Answer::Done)
            }
            Call::AddBody(def) => self.add_body((**def).clone()).map(Answer::Body),
            Call::RemoveBody(id) => Ok(found(self.remove_body(*id))),
            Call::Body(id, call) => match self.body_mut(*id) {
                Some(body) => call_body(body, call),
                None => Ok(Answer::Nothing),
            },
            Call::AddShape(body, def) => self.add_shape(*body, (**def).clone()).map(Answer::Shape),
            Call::RemoveShape(id) => Ok(found(self.remove_shape(*id))),
            Call::Shape(id, call) => match self.shape_mut(*id) {
                Some(shape) => call_shape(shape, call),
                None => Ok(Answer::Nothing),
            },
            Call::AddJoint(def) => self.add_joint(**def).map(Answer::Joint),
            Call::AddCoupling(def) => self.add_coupling(*def).map(Answer::Joint),
            Call::RemoveJoint(id) => Ok(found(self.remove_joint(*id))),
            Call::Joint(id, call) => match self.joint_mut(*id) {
                Some(joint) => call_joint(joint, call),
                None => Ok(Answer::Nothing),
            },
            Call::SetBodiesCollide(a, b, collide) => {
                Ok(found(self.set_bodies_collide(*a, *b, *collide)))
            }
            Call::ShiftOrigin(origin) => done(self.shift_origin(*origin)),
            Call::SetSurfaceRules(rules) => done(self.set_surface_rules(rules.clone())),
            Call::SetSurfaceBetween(a, b, rule) => done(self.set_surface_between(*a, *b, *rule)),
            Call::BreakAt(id, point, how) => match self.body_mut(*id) {
                Some(body) => body.break_at(*point, how).map(Answer::Pieces),
                None => Ok(Answer::Nothing),
            },
            _ => self.apply_to_particles(call),
        }
    }

    fn apply_to_particles(&mut self, call: &Call) -> Answered {
        match call {
            Call::AddParticle(def) => self.add_particle(**def).map(Answer::Particle),
            Call::AddRope(def) => self.add_rope(**def).map(Answer::Strand),
            Call::AddCloth(def) => self.add_cloth(**def).map(Answer::Strand),
            Call::AddCloud(points, def) => {
                let made = self.add_cloud(points.iter().copied(), **def);
                let strand = |particles| Strand { particles, ..Strand::default() };
                made.map(strand).map(Answer::Strand)
            }
            Call::RemoveParticle(id) => Ok(found(self.remove_particle(*id))),
            Call::Particle(id, call) => match self.particle_mut(*id) {
                Some(particle) => call_particle(particle, call),
                None => Ok(Answer::Nothing),
            },
            Call::AddLink(def) => self.add_link(*def).map(Answer::Link),
            Call::RemoveLink(id) => Ok(found(self.remove_link(*id))),
            Call::SetLinkLength(id, length) => match self.link_mut(*id) {
                Some(mut link) => {
                    done(link.attempt(FrameCall::SetLinkLength, |of| of.try_set_length(*length)))
                }
                None => Ok(Answer::Nothing),
            },
            _ => Ok(Answer::Nothing),
        }
    }
}

fn done(result: Result<(), DefError>) -> Answered {
    result.map(|()| Answer::Done)
}

fn found(is_there: bool) -> Answer {
    if is_there { Answer::Done } else { Answer::Nothing }
}

fn call_joint(mut joint: JointMut<'_>, call: &JointCall) -> Answered {
    match call {
        JointCall::SetAnchors(a, b) => joint.set_anchors(*a, *b)?,
        JointCall::SetFrames(a, b) => joint.set_frames(*a, *b)?,
        JointCall::SetKind(kind) => joint.set_kind(**kind)?,
        JointCall::SetLengths(min, max) => {
            joint.attempt(FrameCall::SetLengths, |of| of.try_set_lengths(*min, *max))?;
        }
        JointCall::SetSpring(spring) => joint.set_spring(*spring)?,
        JointCall::SetPulley(pulley) => joint.set_pulley(*pulley)?,
        JointCall::SetCoupling(ratio, offset) => joint.set_coupling(*ratio, *offset)?,
        JointCall::SetAxes(axes) => joint.set_axes(**axes)?,
        JointCall::Axis(None, AxisCall::SetMotor(speed, maximum)) => {
            joint.attempt(FrameCall::SetMotor, |of| of.try_set_motor(*speed, *maximum))?;
        }
        JointCall::Axis(None, AxisCall::SetServo(position, spring, maximum)) => {
            joint.attempt(FrameCall::SetServo, |of| {
                of.try_set_servo(*position, *spring, *maximum)
            })?;
        }
        JointCall::Axis(None, call) => call_axis(joint.only()?, call)?,
        JointCall::Axis(Some(axis), call) => match joint.axis(*axis) {
            Some(axis) => call_axis(axis, call)?,
            None => return Ok(Answer::Nothing),
        },
        JointCall::SetTargetRotation(rotation, spring, maximum) => joint
            .attempt(FrameCall::SetTargetRotation, |of| {
                of.try_set_target_rotation(*rotation, *spring, *maximum)
            })?,
        JointCall::SetStrength(strength) => joint.set_strength(*strength)?,
        JointCall::SetArticulated(articulated) => joint.set_articulated(*articulated),
        JointCall::SetCollideConnected(collide) => joint.set_collide_connected(*collide),
        JointCall::SetEnabled(enabled) => joint.set_enabled(*enabled),
        JointCall::SetUserData(data) => joint.set_user_data(*data),
        JointCall::Wake => joint.wake(),
    }
    Ok(Answer::Done)
}

fn call_axis(mut axis: AxisMut<'_, '_>, call: &AxisCall) -> Result<(), DefError> {
    match *call {
        AxisCall::Set(def) => axis.set(def),
        AxisCall::SetMotion(motion) => axis.set_motion(motion),
        AxisCall::SetLimits(min, max) => axis.set_limits(min, max),
        AxisCall::SetDrive(drive) => axis.set_drive(drive),
        AxisCall::SetMotor(speed, maximum) => {
            axis.attempt(FrameCall::SetMotor, |of| of.try_set_motor(speed, maximum))
        }
        AxisCall::SetServo(position, spring, maximum) => {
            axis.attempt(FrameCall::SetServo, |of| of.try_set_servo(position, spring, maximum))
        }
        AxisCall::SetFriction(friction) => axis.set_friction(friction),
    }
}

fn call_body(mut body: BodyMut<'_>, call: &BodyCall) -> Answered {
    match *call {
        BodyCall::Wake => body.wake(),
        BodyCall::Sleep => body.sleep(),
        BodyCall::SetKind(kind) => body.set_kind(kind)?,
        BodyCall::SetMass(mass) => body.set_mass(mass)?,
        BodyCall::SetEnabled(enabled) => body.set_enabled(enabled),
        BodyCall::SetPose(pose) => body.attempt(FrameCall::SetPose, |of| of.try_set_pose(pose))?,
        BodyCall::SetLinearVelocity(v) => {
            body.attempt(FrameCall::SetLinearVelocity, |of| of.try_set_linear_velocity(v))?;
        }
        BodyCall::SetAngularVelocity(w) => {
            body.attempt(FrameCall::SetAngularVelocity, |of| of.try_set_angular_velocity(w))?;
        }
        BodyCall::CorrectState(pose, v, w) => return body.correct_state(pose, v, w).map(found),
        BodyCall::MoveTo(pose, time) => {
            body.attempt(FrameCall::MoveTo, |of| of.try_move_to(pose, time))?;
        }
        BodyCall::ApplyImpulse(p) => {
            body.attempt(FrameCall::ApplyImpulse, |of| of.try_apply_impulse(p))?;
        }
        BodyCall::ApplyImpulseAt(p, at) => {
            body.attempt(FrameCall::ApplyImpulseAt, |of| of.try_apply_impulse_at(p, at))?;
        }
        BodyCall::ApplyAngularImpulse(p) => {
            body.attempt(FrameCall::ApplyAngularImpulse, |of| of.try_apply_angular_impulse(p))?;
        }
        BodyCall::AddStepForce(f) => {
            body.attempt(FrameCall::AddStepForce, |of| of.try_add_step_force(f))?;
        }
        BodyCall::AddStepForceAt(f, at) => {
            body.attempt(FrameCall::AddStepForceAt, |of| of.try_add_step_force_at(f, at))?;
        }
        BodyCall::AddStepTorque(t) => {
            body.attempt(FrameCall::AddStepTorque, |of| of.try_add_step_torque(t))?;
        }
        BodyCall::SetLastingForce(f) => {
            body.attempt(FrameCall::SetLastingForce, |of| of.try_set_lasting_force(f))?;
        }
        BodyCall::SetLastingTorque(t) => {
            body.attempt(FrameCall::SetLastingTorque, |of| of.try_set_lasting_torque(t))?;
        }
        BodyCall::SetGravityScale(scale) => {
            body.attempt(FrameCall::SetGravityScale, |of| of.try_set_gravity_scale(scale))?;
        }
        BodyCall::SetDamping(linear, angular) => {
            body.attempt(FrameCall::SetDamping, |of| of.try_set_damping(linear, angular))?;
        }
        BodyCall::SetLocks(locks) => body.set_locks(locks),
        BodyCall::SetCanSleep(can_sleep) => body.set_can_sleep(can_sleep),
        BodyCall::SetSleepSpeed(speed) => body.set_sleep_speed(speed)?,
        BodyCall::SetFracture(how) => body.set_fracture(how)?,
        BodyCall::SetBondStrength(strength) => body.set_bond_strength(strength)?,
        BodyCall::SetUserData(data) => body.set_user_data(data),
    }
    Ok(Answer::Done)
}

fn call_shape(mut shape: ShapeMut<'_>, call: &ShapeCall) -> Answered {
    match call {
        ShapeCall::SetMaterial(material) => shape.set_material(*material)?,
        ShapeCall::SetSurfaceVelocity(v) => {
            shape.attempt(FrameCall::SetSurfaceVelocity, |of| of.try_set_surface_velocity(*v))?;
        }
        ShapeCall::SetSurfaceSpin(w) => {
            shape.attempt(FrameCall::SetSurfaceSpin, |of| of.try_set_surface_spin(*w))?;
        }
        ShapeCall::SetFilter(filter) => shape.set_filter(*filter),
        ShapeCall::SetSensor(sensor) => shape.set_sensor(*sensor)?,
        ShapeCall::SetDensity(density) => shape.set_density(*density)?,
        ShapeCall::SetLocalPose(pose) => shape.set_local_pose(*pose)?,
        ShapeCall::SetGeometry(form) => shape.set_geometry(form.clone())?,
        ShapeCall::SetEnabled(enabled) => shape.set_enabled(*enabled),
        ShapeCall::SetReports(reports) => shape.set_reports(*reports)?,
        ShapeCall::SetSenses(senses) => shape.set_senses(*senses),
        ShapeCall::SetHooks(hooks) => shape.set_hooks(*hooks),
        ShapeCall::SetOneWay(front) => shape.set_one_way(*front)?,
        ShapeCall::SetUserData(data) => shape.set_user_data(*data),
    }
    Ok(Answer::Done)
}

fn call_particle(mut particle: ParticleMut<'_>, call: &ParticleCall) -> Answered {
    match *call {
        ParticleCall::SetPosition(x) => {
            particle.attempt(FrameCall::SetParticlePosition, |of| of.try_set_position(x))?;
        }
        ParticleCall::SetVelocity(v) => {
            particle.attempt(FrameCall::SetParticleVelocity, |of| of.try_set_velocity(v))?;
        }
        ParticleCall::ApplyImpulse(p) => {
            particle.attempt(FrameCall::ApplyParticleImpulse, |of| of.try_apply_impulse(p))?;
        }
        ParticleCall::SetMass(mass) => particle.set_mass(mass)?,
        ParticleCall::SetPinned(pinned) => particle.set_pinned(pinned),
        ParticleCall::Attach(body, point) => particle.attach(body, point)?,
        ParticleCall::Detach => return Ok(found(particle.detach())),
    }
    Ok(Answer::Done)
}
