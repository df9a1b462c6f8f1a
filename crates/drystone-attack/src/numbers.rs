//! Visits every number of a program, to replace it by an extreme or a simpler one.

use drystone::breakage::{BondStrength, Fracture, JointStrength};
use drystone::contact::SurfaceRule;
use drystone::impact::{ImpactBody, ImpactSurface};
use drystone::joint::{JointAxis, JointDrive, JointMotion, JointSpring, SixDof};
use drystone::math::Sym3;
use drystone::particle::{ClothDef, LinkKind, LinkSpring, ParticleDef, RopeDef};
use drystone::{
    BodyDef, JointKind, MassDef, Material, Pose, Quat, Shape, ShapeDef, Vec3, WorldConfig,
};

use crate::op::{
    BodyCall, Form, JointCall, Op, ParticleCall, Place, QueryCall, ShapeCall, ShapePlan,
};

/// A visitor of numbers.
pub type Visit<'a> = &'a mut dyn FnMut(&mut f32);

/// Visits all numbers of an operation.
pub fn of_op(op: &mut Op, f: Visit<'_>) {
    match op {
        Op::AddBody(plan) => {
            of_body(&mut plan.def, f);
            plan.shapes.iter_mut().for_each(|s| of_shape(s, f));
            if let Some((gap, strength)) = &mut plan.glue {
                f(gap);
                bond(strength, f);
            }
        }
        Op::AddShape(_, plan) => of_shape(plan, f),
        Op::AddJoint(plan) => {
            match &mut plan.place {
                Place::Anchors(a, b) | Place::Along(a, b) => {
                    vector(a, f);
                    vector(b, f);
                }
            }
            joint_kind(&mut plan.kind, f);
            plan.strength.iter_mut().for_each(|s| strength(s, f));
        }
        Op::AddCoupling(plan) => {
            f(&mut plan.ratio);
            f(&mut plan.offset);
        }
        Op::SetJointAxes(_, axes) => six(axes, f),
        Op::SetJointDrive(_, _, d) => d.iter_mut().for_each(|d| drive(d, f)),
        Op::SetJointStrength(_, s) => s.iter_mut().for_each(|s| strength(s, f)),
        Op::AddParticle(_, def) => particle(def, f),
        Op::AddRope(_, _, def) => rope(def, f),
        Op::AddCloth(_, _, def) => cloth(def, f),
        Op::AddCloud(_, points, def) => {
            points.iter_mut().for_each(|p| vector(p, f));
            particle(def, f);
        }
        Op::AddLink(plan) => {
            link(&mut plan.kind, f);
            [&mut plan.length, &mut plan.tear_strain, &mut plan.tear_force]
                .into_iter()
                .flatten()
                .for_each(f);
        }
        Op::SetLinkLength(_, length) => f(length),
        Op::Attach(_, _, v) | Op::SetGravity(v) | Op::ShiftOrigin(v) => vector(v, f),
        Op::SurfaceBetween(_, _, rule) => rule.iter_mut().for_each(|rule| surface_rule(rule, f)),
        Op::Body(_, call) => body_call(call, f),
        Op::Shape(_, call) => match call {
            ShapeCall::Material(m) => material(m, f),
            ShapeCall::SurfaceVelocity(v) | ShapeCall::SurfaceSpin(v) => vector(v, f),
            ShapeCall::Density(density) => f(density),
            ShapeCall::LocalPose(at) => pose(at, f),
            ShapeCall::Geometry(shape) => form(shape, f),
            ShapeCall::Reports(reports) => reports.hit_speed.iter_mut().for_each(f),
            ShapeCall::OneWay(front) => {
                if let Some(front) = front {
                    vector(front, f);
                }
            }
            ShapeCall::Filter(_)
            | ShapeCall::Sensor(_)
            | ShapeCall::Enabled(_)
            | ShapeCall::Senses(_) => {}
        },
        Op::Joint(_, call) => joint_call(call, f),
        Op::Particle(_, call) => match call {
            ParticleCall::Position(v) | ParticleCall::Velocity(v) | ParticleCall::Impulse(v) => {
                vector(v, f);
            }
            ParticleCall::Mass(m) => f(m),
            ParticleCall::Pinned(_) => {}
        },
        Op::FractureBody(_, point, how) => {
            vector(point, f);
            fracture(how, f);
        }
        Op::SetFracture(_, how) => how.iter_mut().for_each(|how| fracture(how, f)),
        Op::SetBondStrength(_, strength) => bond(strength, f),
        Op::SetConfig(config) => of_config(config, f),
        Op::Query(call) => query(call, f),
        Op::Impact(bodies, surface) => impact(bodies, surface, f),
        Op::Step(dt, _) => f(dt),
        Op::RemoveBody(_)
        | Op::RemoveShape(_)
        | Op::RemoveJoint(_)
        | Op::RemoveParticle(_)
        | Op::RemoveLink(_)
        | Op::Detach(_)
        | Op::WakeAll
        | Op::BeginLedger
        | Op::EndLedger => {}
    }
}

fn surface_rule(rule: &mut SurfaceRule, f: Visit<'_>) {
    let numbers = [&mut rule.friction, &mut rule.kinetic_friction, &mut rule.restitution];
    numbers.into_iter().flatten().for_each(&mut *f);
    if let Some(softness) = &mut rule.softness {
        f(&mut softness.hertz);
        f(&mut softness.damping_ratio);
    }
}

/// Visits all numbers of a configuration.
pub fn of_config(config: &mut WorldConfig, f: Visit<'_>) {
    vector(&mut config.gravity, f);
    let (c, i, j) = (&mut config.contact, &mut config.inertia, &mut config.joint);
    let (particle, penalty, sleep) = (&mut config.particle, &mut config.penalty, &mut config.sleep);
    [
        &mut config.length_scale,
        &mut c.hertz,
        &mut c.damping_ratio,
        &mut c.push_speed,
        &mut c.rest_offset,
        &mut c.margin,
        &mut c.recycle_distance,
        &mut c.restitution_speed,
        &mut c.hit_speed,
        &mut i.max_factor,
        &mut i.threshold,
        &mut j.hertz,
        &mut j.damping_ratio,
        &mut j.tree_ratio,
        &mut particle.hertz,
        &mut particle.damping_ratio,
        &mut penalty.hertz,
        &mut penalty.damping_ratio,
        &mut sleep.speed,
        &mut sleep.time,
    ]
    .into_iter()
    .for_each(f);
}

fn vector(v: &mut Vec3, f: Visit<'_>) {
    f(&mut v.x);
    f(&mut v.y);
    f(&mut v.z);
}

fn rotation(q: &mut Quat, f: Visit<'_>) {
    [&mut q.x, &mut q.y, &mut q.z, &mut q.w].into_iter().for_each(f);
}

fn pose(pose: &mut Pose, f: Visit<'_>) {
    vector(&mut pose.position, f);
    rotation(&mut pose.rotation, f);
}

fn symmetric(m: &mut Sym3, f: Visit<'_>) {
    [&mut m.xx, &mut m.yy, &mut m.zz, &mut m.xy, &mut m.xz, &mut m.yz].into_iter().for_each(f);
}

fn mass(def: &mut MassDef, f: Visit<'_>) {
    match def {
        MassDef::FromShapes => {}
        MassDef::Mass(mass) => f(mass),
        MassDef::Exact { mass, center, inertia } => {
            f(mass);
            vector(center, f);
            symmetric(inertia, f);
        }
    }
}

fn of_body(def: &mut BodyDef, f: Visit<'_>) {
    vector(&mut def.position, f);
    rotation(&mut def.rotation, f);
    vector(&mut def.linear_velocity, f);
    vector(&mut def.angular_velocity, f);
    mass(&mut def.mass, f);
    f(&mut def.gravity_scale);
    f(&mut def.linear_damping);
    f(&mut def.angular_damping);
    def.sleep_speed.iter_mut().for_each(&mut *f);
    def.fracture.iter_mut().for_each(|how| fracture(how, f));
}

fn of_shape(plan: &mut ShapePlan, f: Visit<'_>) {
    form(&mut plan.form, f);
    let ShapeDef {
        pose: at,
        density,
        material: surface,
        surface_velocity,
        surface_spin,
        one_way,
        reports,
        ..
    } = &mut plan.def;
    pose(at, f);
    f(density);
    material(surface, f);
    if let Some(front) = one_way {
        vector(front, f);
    }
    reports.hit_speed.iter_mut().for_each(&mut *f);
    vector(surface_velocity, f);
    vector(surface_spin, f);
}

fn form(form: &mut Form, f: Visit<'_>) {
    match form {
        Form::Hull(points) | Form::Mesh(points, _) => points.iter_mut().for_each(|p| vector(p, f)),
        Form::Plain(shape) => match shape {
            Shape::Sphere { radius } => f(radius),
            Shape::Capsule { half_height, radius } | Shape::Cylinder { half_height, radius } => {
                f(half_height);
                f(radius);
            }
            Shape::Box { half_extents } => vector(half_extents, f),
            Shape::Cone { half_height, radius_bottom, radius_top } => {
                [half_height, radius_bottom, radius_top].into_iter().for_each(f);
            }
            Shape::HalfSpace { normal, offset } => {
                vector(normal, f);
                f(offset);
            }
            _ => {}
        },
    }
}

fn material(m: &mut Material, f: Visit<'_>) {
    f(&mut m.friction);
    m.kinetic_friction.iter_mut().for_each(&mut *f);
    f(&mut m.restitution);
    f(&mut m.rolling_resistance);
    f(&mut m.spinning_resistance);
}

fn bond(strength: &mut BondStrength, f: Visit<'_>) {
    f(&mut strength.tension);
    f(&mut strength.shear);
}

fn fracture(how: &mut Fracture, f: Visit<'_>) {
    f(&mut how.impulse);
    f(&mut how.energy);
    f(&mut how.min_size);
}

fn joint_kind(kind: &mut JointKind, f: Visit<'_>) {
    match kind {
        JointKind::Distance { min, max, spring } => {
            f(min);
            f(max);
            if let Some(s) = spring {
                [&mut s.rest_length, &mut s.hertz, &mut s.damping_ratio].into_iter().for_each(f);
            }
        }
        JointKind::SixDof(axes) => six(axes, f),
        JointKind::Pulley(pulley) => {
            pulley.points.iter_mut().for_each(|p| vector(p, f));
            f(&mut pulley.length);
            f(&mut pulley.ratio);
        }
        _ => {}
    }
}

fn six(axes: &mut SixDof, f: Visit<'_>) {
    rotation(&mut axes.frame_a, f);
    rotation(&mut axes.frame_b, f);
    axes.linear.iter_mut().chain(&mut axes.angular).for_each(|a| axis(a, f));
    if let Some(cone) = &mut axes.cone {
        cone.swing.iter_mut().for_each(&mut *f);
        cone.spring.iter_mut().for_each(|s| spring(s, f));
    }
}

fn motion(motion: &mut JointMotion, f: Visit<'_>) {
    if let JointMotion::Limited { min, max, spring: s } = motion {
        f(min);
        f(max);
        s.iter_mut().for_each(|s| spring(s, f));
    }
}

fn axis(axis: &mut JointAxis, f: Visit<'_>) {
    motion(&mut axis.motion, f);
    axis.drive.iter_mut().for_each(|d| drive(d, f));
    f(&mut axis.friction);
}

fn drive(drive: &mut JointDrive, f: Visit<'_>) {
    f(&mut drive.position);
    f(&mut drive.velocity);
    spring(&mut drive.spring, f);
    f(&mut drive.max_force);
}

fn spring(spring: &mut JointSpring, f: Visit<'_>) {
    f(&mut spring.stiffness);
    f(&mut spring.damping);
}

fn strength(strength: &mut JointStrength, f: Visit<'_>) {
    f(&mut strength.force);
    f(&mut strength.torque);
    f(&mut strength.impulse);
    if let Some(fatigue) = &mut strength.fatigue {
        f(&mut fatigue.life);
        f(&mut fatigue.endurance);
    }
}

fn particle(def: &mut ParticleDef, f: Visit<'_>) {
    vector(&mut def.position, f);
    vector(&mut def.velocity, f);
    [&mut def.mass, &mut def.radius, &mut def.gravity_scale, &mut def.damping]
        .into_iter()
        .for_each(&mut *f);
    material(&mut def.material, f);
}

fn link(kind: &mut LinkKind, f: Visit<'_>) {
    if let LinkKind::Spring(spring) = kind {
        match spring {
            LinkSpring::Rate { stiffness, damping } => [stiffness, damping].into_iter().for_each(f),
            LinkSpring::Frequency { hertz, damping_ratio } => {
                [hertz, damping_ratio].into_iter().for_each(f);
            }
        }
    }
}

fn rope(def: &mut RopeDef, f: Visit<'_>) {
    vector(&mut def.from, f);
    vector(&mut def.to, f);
    def.length.iter_mut().for_each(&mut *f);
    f(&mut def.mass);
    link(&mut def.kind, f);
    particle(&mut def.particle, f);
    [&mut def.tear_strain, &mut def.tear_force].into_iter().flatten().for_each(f);
}

fn cloth(def: &mut ClothDef, f: Visit<'_>) {
    vector(&mut def.corner, f);
    def.sides.iter_mut().for_each(|side| vector(side, f));
    f(&mut def.mass);
    link(&mut def.stretch, f);
    [&mut def.shear, &mut def.bend].into_iter().flatten().for_each(|kind| link(kind, f));
    particle(&mut def.particle, f);
    [&mut def.tear_strain, &mut def.tear_force].into_iter().flatten().for_each(f);
}

fn body_call(call: &mut BodyCall, f: Visit<'_>) {
    match call {
        BodyCall::Pose(at) => pose(at, f),
        BodyCall::MoveTo(at, dt) => {
            pose(at, f);
            f(dt);
        }
        BodyCall::LinearVelocity(v)
        | BodyCall::AngularVelocity(v)
        | BodyCall::Impulse(v)
        | BodyCall::AngularImpulse(v)
        | BodyCall::StepForce(v)
        | BodyCall::StepTorque(v)
        | BodyCall::LastingForce(v)
        | BodyCall::LastingTorque(v) => vector(v, f),
        BodyCall::ImpulseAt(v, at) | BodyCall::StepForceAt(v, at) => {
            vector(v, f);
            vector(at, f);
        }
        BodyCall::GravityScale(scale) => f(scale),
        BodyCall::Damping(linear, angular) => {
            f(linear);
            f(angular);
        }
        BodyCall::Mass(def) => mass(def, f),
        BodyCall::SleepSpeed(speed) => speed.iter_mut().for_each(f),
        BodyCall::Correct(at, v, w) => {
            pose(at, f);
            vector(v, f);
            vector(w, f);
        }
        BodyCall::Wake
        | BodyCall::Locks(_)
        | BodyCall::CanSleep(_)
        | BodyCall::UserData(_)
        | BodyCall::Kind(_)
        | BodyCall::Enabled(_)
        | BodyCall::Sleep => {}
    }
}

fn joint_call(call: &mut JointCall, f: Visit<'_>) {
    match call {
        JointCall::Anchors(a, b) => {
            vector(a, f);
            vector(b, f);
        }
        JointCall::Kind(kind) => joint_kind(kind, f),
        JointCall::Lengths(a, b) | JointCall::Coupling(a, b) => {
            f(a);
            f(b);
        }
        JointCall::Frames(a, b) => {
            rotation(a, f);
            rotation(b, f);
        }
        JointCall::Spring(spring) => spring.iter_mut().for_each(|s| {
            f(&mut s.rest_length);
            f(&mut s.hertz);
            f(&mut s.damping_ratio);
        }),
        JointCall::Limits(a, b) | JointCall::Motor(a, b) => {
            f(a);
            f(b);
        }
        JointCall::Friction(x) => f(x),
        JointCall::TargetRotation(at, law, torque) => {
            rotation(at, f);
            spring(law, f);
            f(torque);
        }
        JointCall::Motion(_, at) => motion(at, f),
        JointCall::CollideConnected(_) | JointCall::Enabled(_) => {}
    }
}

fn query(call: &mut QueryCall, f: Visit<'_>) {
    match call {
        QueryCall::Ray(origin, delta, _) => {
            vector(origin, f);
            vector(delta, f);
        }
        QueryCall::OverlapBounds(bounds, _) => {
            vector(&mut bounds.min, f);
            vector(&mut bounds.max, f);
        }
        QueryCall::OverlapPoint(point, _) => vector(point, f),
        QueryCall::OverlapShape(shape, at, _) => {
            form(shape, f);
            pose(at, f);
        }
        QueryCall::CastShape(shape, at, motion, _) => {
            form(shape, f);
            pose(at, f);
            for part in motion {
                vector(part, f);
            }
        }
        QueryCall::Nearest(shape, at, reach, _) => {
            form(shape, f);
            pose(at, f);
            f(reach);
        }
        QueryCall::Pair(both, reach) => {
            for (shape, at) in both.iter_mut() {
                form(shape, f);
                pose(at, f);
            }
            f(reach);
        }
    }
}

fn impact(bodies: &mut [ImpactBody; 2], surface: &mut ImpactSurface, f: Visit<'_>) {
    for body in bodies {
        f(&mut body.mass);
        symmetric(&mut body.inertia, f);
        vector(&mut body.linear_velocity, f);
        vector(&mut body.angular_velocity, f);
        vector(&mut body.arm, f);
    }
    vector(&mut surface.normal, f);
    [&mut surface.restitution, &mut surface.static_friction, &mut surface.kinetic_friction]
        .into_iter()
        .for_each(f);
}
