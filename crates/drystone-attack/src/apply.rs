//! Applies one operation to a world.

use std::collections::BTreeMap;
use std::sync::Arc;

use drystone::breakage::Glue;
use drystone::joint::CouplingDef;
use drystone::particle::{LinkDef, LinkId, ParticleId, Strand};
use drystone::{
    BodyDef, BodyId, DefError, Hull, JointDef, JointId, JointKind, JointMut, Mesh, Shape, ShapeDef,
    ShapeId, World,
};

use crate::ask::ask;
use crate::finding::{Findings, Kind};
use crate::op::{
    BodyCall, BodyPlan, CouplingPlan, Form, JointCall, JointPlan, Label, LinkPlan, Op, PIECES,
    ParticleCall, Place, ShapeCall, ShapePlan,
};
use crate::oracle::Gone;

/// Result of an operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Done {
    /// The operation succeeded.
    Yes,
    /// The engine refused it.
    Refused,
    /// An object that it names does not exist.
    Skipped,
}

/// The ids of a program's labels, including removed objects.
#[derive(Clone, Debug, Default)]
pub struct Ids {
    /// Bodies.
    pub bodies: BTreeMap<Label, BodyId>,
    /// Shapes.
    pub shapes: BTreeMap<Label, ShapeId>,
    /// Joints and couplings.
    pub joints: BTreeMap<Label, JointId>,
    /// Particles.
    pub particles: BTreeMap<Label, ParticleId>,
    /// Links.
    pub links: BTreeMap<Label, LinkId>,
    /// Number of pieces so far.
    pub pieces: Label,
    /// Ids of removed objects.
    pub gone: Gone,
}

impl Ids {
    /// Gives labels to the pieces of the last step.
    pub fn take_pieces(&mut self, world: &World) {
        for piece in &world.events().pieces {
            self.bodies.insert(PIECES + self.pieces, *piece);
            self.pieces += 1;
        }
    }

    pub(crate) fn take_body(&mut self, plan: &BodyPlan, id: BodyId, world: &World) {
        self.bodies.insert(plan.label, id);
        let made: Vec<ShapeId> = world.body(id).map(|b| b.shapes().collect()).unwrap_or_default();
        self.shapes.extend(plan.shapes.iter().map(|s| s.label).zip(made));
    }

    pub(crate) fn take_strand(&mut self, first: Label, first_link: Label, strand: &Strand) {
        self.particles.extend((first..).zip(strand.particles.iter().copied()));
        self.links.extend((first_link..).zip(strand.links.iter().copied()));
    }
}

/// Applies an operation other than a step.
pub fn apply(
    world: &mut World,
    ids: &mut Ids,
    op: &Op,
    findings: &mut Findings,
    step: u32,
) -> Done {
    match op {
        Op::AddBody(plan) => add_body(world, ids, plan),
        Op::AddShape(body, plan) => add_shape(world, ids, *body, plan),
        Op::RemoveBody(_)
        | Op::RemoveShape(_)
        | Op::RemoveJoint(_)
        | Op::RemoveParticle(_)
        | Op::RemoveLink(_)
        | Op::Detach(_) => remove(world, ids, op),
        Op::AddJoint(plan) => add_joint(world, ids, plan),
        Op::AddCoupling(plan) => add_coupling(world, ids, plan),
        Op::SetJointAxes(..) | Op::SetJointDrive(..) | Op::SetJointStrength(..) => {
            set_joint(world, ids, op)
        }
        Op::Joint(label, call) => joint_call(world, ids, *label, call),
        Op::AddParticle(..) | Op::AddRope(..) | Op::AddCloth(..) | Op::AddCloud(..) => {
            add_particles(world, ids, op)
        }
        Op::AddLink(plan) => add_link(world, ids, plan),
        Op::SetLinkLength(label, length) => {
            let Some(id) = ids.links.get(label) else { return Done::Skipped };
            let Some(mut link) = world.link_mut(*id) else { return Done::Skipped };
            link.set_length(*length);
            Done::Yes
        }
        Op::Attach(particle, body, point) => {
            let (Some(p), Some(b)) = (ids.particles.get(particle), ids.bodies.get(body)) else {
                return Done::Skipped;
            };
            let Some(mut particle) = world.particle_mut(*p) else { return Done::Skipped };
            of(particle.attach(*b, *point))
        }
        Op::Body(label, call) => body_call(world, ids, *label, call),
        Op::Shape(label, call) => shape_call(world, ids, *label, call),
        Op::Particle(label, call) => particle_call(world, ids, *label, call),
        Op::FractureBody(label, point, how) => {
            let Some(body) = ids.bodies.get(label).and_then(|id| world.body_mut(*id)) else {
                return Done::Skipped;
            };
            of(body.break_at(*point, how).map(|_| ()))
        }
        Op::SetFracture(label, how) => {
            let Some(mut body) = ids.bodies.get(label).and_then(|id| world.body_mut(*id)) else {
                return Done::Skipped;
            };
            of(body.set_fracture(*how))
        }
        Op::SetBondStrength(label, strength) => {
            let Some(mut body) = ids.bodies.get(label).and_then(|id| world.body_mut(*id)) else {
                return Done::Skipped;
            };
            of(body.set_bond_strength(*strength))
        }
        Op::SetConfig(config) => of(world.set_config((**config).clone())),
        Op::SetGravity(g) => {
            world.set_gravity(*g);
            Done::Yes
        }
        Op::ShiftOrigin(origin) => of(world.shift_origin(*origin)),
        Op::SurfaceBetween(a, b, rule) => {
            let (Some(a), Some(b)) = (ids.bodies.get(a), ids.bodies.get(b)) else {
                return Done::Skipped;
            };
            of(world.set_surface_between(*a, *b, *rule))
        }
        Op::WakeAll => {
            world.wake_all();
            Done::Yes
        }
        Op::BeginLedger => {
            world.begin_ledger();
            Done::Yes
        }
        Op::EndLedger => {
            if let Some(ledger) = world.end_ledger() {
                look(findings, "Ledger", &format!("{ledger:?}"), step);
            }
            Done::Yes
        }
        Op::Query(call) => ask(world, call, findings, step),
        Op::Impact(bodies, surface) => {
            match drystone::impact::impact(&bodies[0], &bodies[1], surface) {
                Ok(impact) => {
                    look(findings, "Impact", &format!("{impact:?}"), step);
                    Done::Yes
                }
                Err(_) => Done::Refused,
            }
        }
        Op::Step(..) => Done::Skipped,
    }
}

fn of(result: Result<(), DefError>) -> Done {
    if result.is_ok() { Done::Yes } else { Done::Refused }
}

/// Checks that no number of an answer is infinite or NaN.
pub(crate) fn look(findings: &mut Findings, of: &str, text: &str, step: u32) {
    if text.contains("NaN") || text.contains("inf") {
        findings.add(Kind::BadNumber, of, text, step);
    }
}

/// The shape of a form, or `None` if the engine refuses it.
#[must_use]
pub fn shape(form: &Form) -> Option<Shape> {
    match form {
        Form::Plain(shape) => Some(shape.clone()),
        Form::Hull(points) => Hull::from_points(points).ok().map(|h| Shape::Hull(Arc::new(h))),
        Form::Mesh(points, triangles) => {
            Mesh::new(points.clone(), triangles.clone()).ok().map(|m| Shape::Mesh(Arc::new(m)))
        }
    }
}

pub(crate) fn shape_def(plan: &ShapePlan) -> Option<ShapeDef> {
    Some(ShapeDef { shape: shape(&plan.form)?, ..plan.def.clone() })
}

/// The definition of a body, or `None` if one of its shapes or its glue is refused.
pub(crate) fn body_def(plan: &BodyPlan) -> Option<BodyDef> {
    let shapes: Option<Vec<ShapeDef>> = plan.shapes.iter().map(shape_def).collect();
    let mut def = BodyDef { shapes: shapes?, ..plan.def.clone() };
    if let Some((gap, strength)) = plan.glue {
        def.glue = Some(Glue::touching(&def.shapes, gap, strength).ok()?);
    }
    Some(def)
}

fn add_body(world: &mut World, ids: &mut Ids, plan: &BodyPlan) -> Done {
    let Some(def) = body_def(plan) else { return Done::Refused };
    let Ok(id) = world.add_body(def) else { return Done::Refused };
    ids.take_body(plan, id, world);
    Done::Yes
}

fn add_shape(world: &mut World, ids: &mut Ids, body: Label, plan: &ShapePlan) -> Done {
    let Some(body) = ids.bodies.get(&body) else { return Done::Skipped };
    let Some(def) = shape_def(plan) else { return Done::Refused };
    let Ok(id) = world.add_shape(*body, def) else { return Done::Refused };
    ids.shapes.insert(plan.label, id);
    Done::Yes
}

fn remove(world: &mut World, ids: &mut Ids, op: &Op) -> Done {
    let done = |removed: bool| if removed { Done::Yes } else { Done::Skipped };
    match op {
        Op::RemoveBody(label) => {
            let Some(id) = ids.bodies.get(label).copied() else { return Done::Skipped };
            if let Some(body) = world.body(id) {
                ids.gone.shapes.extend(body.shapes());
                ids.gone.joints.extend(body.joints());
                ids.gone.bodies.push(id);
            }
            done(world.remove_body(id))
        }
        Op::RemoveShape(label) => {
            let Some(id) = ids.shapes.get(label).copied() else { return Done::Skipped };
            ids.gone.shapes.push(id);
            done(world.remove_shape(id))
        }
        Op::RemoveJoint(label) => {
            let Some(id) = ids.joints.get(label).copied() else { return Done::Skipped };
            ids.gone.joints.push(id);
            done(world.remove_joint(id))
        }
        Op::RemoveParticle(label) => {
            let Some(id) = ids.particles.get(label).copied() else { return Done::Skipped };
            ids.gone.particles.push(id);
            done(world.remove_particle(id))
        }
        Op::RemoveLink(label) => {
            let Some(id) = ids.links.get(label).copied() else { return Done::Skipped };
            ids.gone.links.push(id);
            done(world.remove_link(id))
        }
        Op::Detach(label) => {
            let Some(id) = ids.particles.get(label).copied() else { return Done::Skipped };
            done(world.particle_mut(id).is_some_and(|mut particle| particle.detach()))
        }
        _ => Done::Skipped,
    }
}

/// The definition of a joint between two bodies.
pub(crate) fn joint_def([a, b]: [BodyId; 2], plan: &JointPlan) -> JointDef {
    let def = JointDef::new(a, b, plan.kind);
    let def = match (plan.place, plan.kind) {
        (Place::Along(anchor, axis), JointKind::SixDof(_)) => def.at(anchor).with_axis(axis),
        (Place::Along(p, q) | Place::Anchors(p, q), _) => def.with_anchors(p, q),
    };
    let JointPlan { collide_connected, strength, articulated, enabled, .. } = *plan;
    JointDef { collide_connected, strength, articulated, enabled, ..def }
}

fn add_joint(world: &mut World, ids: &mut Ids, plan: &JointPlan) -> Done {
    let [Some(a), Some(b)] = plan.bodies.map(|label| ids.bodies.get(&label).copied()) else {
        return Done::Skipped;
    };
    let def = joint_def([a, b], plan);
    let Ok(id) = world.add_joint(def) else { return Done::Refused };
    ids.joints.insert(plan.label, id);
    Done::Yes
}

fn add_coupling(world: &mut World, ids: &mut Ids, plan: &CouplingPlan) -> Done {
    let [Some(joint_a), Some(joint_b)] = plan.joints.map(|label| ids.joints.get(&label).copied())
    else {
        return Done::Skipped;
    };
    let [axis_a, axis_b] = plan.axes;
    let (ratio, offset) = (plan.ratio, plan.offset);
    let def = CouplingDef { joint_a, axis_a, joint_b, axis_b, ratio, offset };
    let Ok(id) = world.add_coupling(def) else { return Done::Refused };
    ids.joints.insert(plan.label, id);
    Done::Yes
}

fn set_joint(world: &mut World, ids: &Ids, op: &Op) -> Done {
    let (Op::SetJointAxes(label, _)
    | Op::SetJointDrive(label, ..)
    | Op::SetJointStrength(label, _)) = op
    else {
        return Done::Skipped;
    };
    let Some(mut joint) = joint_of(world, ids, *label) else { return Done::Skipped };
    match op {
        Op::SetJointAxes(_, axes) => set(joint.set_axes(**axes)),
        Op::SetJointDrive(_, axis, drive) => {
            joint.axis(*axis).map_or(Done::Refused, |mut axis| set(axis.set_drive(*drive)))
        }
        Op::SetJointStrength(_, strength) => set(joint.set_strength(*strength)),
        _ => Done::Skipped,
    }
}

fn joint_call(world: &mut World, ids: &Ids, label: Label, call: &JointCall) -> Done {
    let Some(mut joint) = joint_of(world, ids, label) else { return Done::Skipped };
    match call {
        JointCall::Anchors(a, b) => set(joint.set_anchors(*a, *b)),
        JointCall::Frames(a, b) => set(joint.set_frames(*a, *b)),
        JointCall::Kind(kind) => set(joint.set_kind(**kind)),
        JointCall::Lengths(min, max) => {
            joint.set_lengths(*min, *max);
            Done::Yes
        }
        JointCall::Spring(spring) => set(joint.set_spring(*spring)),
        JointCall::Motion(axis, motion) => {
            joint.axis(*axis).map_or(Done::Refused, |mut axis| set(axis.set_motion(*motion)))
        }
        JointCall::Limits(min, max) => set(joint.set_limits(*min, *max)),
        JointCall::Motor(speed, max_force) => {
            joint.set_motor(*speed, *max_force);
            Done::Yes
        }
        JointCall::Friction(friction) => set(joint.set_friction(*friction)),
        JointCall::TargetRotation(rotation, spring, max_torque) => {
            joint.set_target_rotation(*rotation, *spring, *max_torque);
            Done::Yes
        }
        JointCall::Coupling(ratio, offset) => set(joint.set_coupling(*ratio, *offset)),
        JointCall::CollideConnected(collide) => {
            joint.set_collide_connected(*collide);
            Done::Yes
        }
        JointCall::Enabled(enabled) => {
            joint.set_enabled(*enabled);
            Done::Yes
        }
    }
}

fn set(result: Result<(), DefError>) -> Done {
    if result.is_ok() { Done::Yes } else { Done::Refused }
}

fn joint_of<'w>(world: &'w mut World, ids: &Ids, label: Label) -> Option<JointMut<'w>> {
    world.joint_mut(ids.joints.get(&label).copied()?)
}

fn add_particles(world: &mut World, ids: &mut Ids, op: &Op) -> Done {
    match op {
        Op::AddParticle(label, def) => {
            let Ok(id) = world.add_particle(**def) else { return Done::Refused };
            ids.particles.insert(*label, id);
        }
        Op::AddRope(first, link, def) => {
            let Ok(strand) = world.add_rope(**def) else { return Done::Refused };
            ids.take_strand(*first, *link, &strand);
        }
        Op::AddCloth(first, link, def) => {
            let Ok(strand) = world.add_cloth(**def) else { return Done::Refused };
            ids.take_strand(*first, *link, &strand);
        }
        Op::AddCloud(first, points, def) => {
            let made = world.add_cloud(points.iter().copied(), **def);
            let Ok(particles) = made else { return Done::Refused };
            ids.take_strand(*first, 0, &Strand { particles, ..Strand::default() });
        }
        _ => return Done::Skipped,
    }
    Done::Yes
}

fn add_link(world: &mut World, ids: &mut Ids, plan: &LinkPlan) -> Done {
    let [Some(a), Some(b)] = plan.ends.map(|label| ids.particles.get(&label).copied()) else {
        return Done::Skipped;
    };
    let LinkPlan { kind, length, tear_strain, tear_force, .. } = *plan;
    let def = LinkDef { length, tear_strain, tear_force, ..LinkDef::new(a, b, kind) };
    let Ok(id) = world.add_link(def) else { return Done::Refused };
    ids.links.insert(plan.label, id);
    Done::Yes
}

fn body_call(world: &mut World, ids: &Ids, label: Label, call: &BodyCall) -> Done {
    let Some(mut body) = ids.bodies.get(&label).and_then(|id| world.body_mut(*id)) else {
        return Done::Skipped;
    };
    of(match call {
        BodyCall::Wake => {
            body.wake();
            Ok(())
        }
        BodyCall::Pose(pose) => {
            body.set_pose(*pose);
            Ok(())
        }
        BodyCall::LinearVelocity(v) => {
            body.set_linear_velocity(*v);
            Ok(())
        }
        BodyCall::AngularVelocity(w) => {
            body.set_angular_velocity(*w);
            Ok(())
        }
        BodyCall::MoveTo(pose, dt) => {
            body.move_to(*pose, *dt);
            Ok(())
        }
        BodyCall::Impulse(p) => {
            body.apply_impulse(*p);
            Ok(())
        }
        BodyCall::ImpulseAt(p, at) => {
            body.apply_impulse_at(*p, *at);
            Ok(())
        }
        BodyCall::AngularImpulse(p) => {
            body.apply_angular_impulse(*p);
            Ok(())
        }
        BodyCall::StepForce(f) => {
            body.add_step_force(*f);
            Ok(())
        }
        BodyCall::StepForceAt(f, at) => {
            body.add_step_force_at(*f, *at);
            Ok(())
        }
        BodyCall::StepTorque(t) => {
            body.add_step_torque(*t);
            Ok(())
        }
        BodyCall::LastingForce(f) => {
            body.set_lasting_force(*f);
            Ok(())
        }
        BodyCall::LastingTorque(t) => {
            body.set_lasting_torque(*t);
            Ok(())
        }
        BodyCall::GravityScale(scale) => {
            body.set_gravity_scale(*scale);
            Ok(())
        }
        BodyCall::Damping(linear, angular) => {
            body.set_damping(*linear, *angular);
            Ok(())
        }
        BodyCall::Locks(locks) => {
            body.set_locks(*locks);
            Ok(())
        }
        BodyCall::CanSleep(can) => {
            body.set_can_sleep(*can);
            Ok(())
        }
        BodyCall::UserData(data) => {
            body.set_user_data(*data);
            Ok(())
        }
        BodyCall::Kind(kind) => body.set_kind(*kind),
        BodyCall::Mass(mass) => body.set_mass(*mass),
        BodyCall::Enabled(enabled) => {
            body.set_enabled(*enabled);
            Ok(())
        }
        BodyCall::Sleep => {
            body.sleep();
            Ok(())
        }
        BodyCall::SleepSpeed(speed) => body.set_sleep_speed(*speed),
        BodyCall::Correct(pose, v, w) => body.correct_state(*pose, *v, *w).map(|_| ()),
    })
}

fn shape_call(world: &mut World, ids: &Ids, label: Label, call: &ShapeCall) -> Done {
    let Some(mut shape) = ids.shapes.get(&label).and_then(|id| world.shape_mut(*id)) else {
        return Done::Skipped;
    };
    of(match call {
        ShapeCall::Material(material) => shape.set_material(*material),
        ShapeCall::SurfaceVelocity(v) => {
            shape.set_surface_velocity(*v);
            Ok(())
        }
        ShapeCall::SurfaceSpin(w) => {
            shape.set_surface_spin(*w);
            Ok(())
        }
        ShapeCall::Filter(filter) => {
            shape.set_filter(*filter);
            Ok(())
        }
        ShapeCall::Sensor(sensor) => shape.set_sensor(*sensor),
        ShapeCall::Density(density) => shape.set_density(*density),
        ShapeCall::LocalPose(pose) => shape.set_local_pose(*pose),
        ShapeCall::Geometry(form) => match self::shape(form) {
            Some(form) => shape.set_geometry(form),
            None => return Done::Refused,
        },
        ShapeCall::Enabled(enabled) => {
            shape.set_enabled(*enabled);
            Ok(())
        }
        ShapeCall::Reports(reports) => shape.set_reports(*reports),
        ShapeCall::Senses(senses) => {
            shape.set_senses(*senses);
            Ok(())
        }
        ShapeCall::OneWay(front) => shape.set_one_way(*front),
    })
}

fn particle_call(world: &mut World, ids: &Ids, label: Label, call: &ParticleCall) -> Done {
    let Some(mut particle) = ids.particles.get(&label).and_then(|id| world.particle_mut(*id))
    else {
        return Done::Skipped;
    };
    of(match call {
        ParticleCall::Position(x) => {
            particle.set_position(*x);
            Ok(())
        }
        ParticleCall::Velocity(v) => {
            particle.set_velocity(*v);
            Ok(())
        }
        ParticleCall::Impulse(p) => {
            particle.apply_impulse(*p);
            Ok(())
        }
        ParticleCall::Mass(mass) => particle.set_mass(*mass),
        ParticleCall::Pinned(pinned) => {
            particle.set_pinned(*pinned);
            Ok(())
        }
    })
}
