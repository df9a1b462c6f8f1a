//! User input is either processed or refused by name, and a disabled object is completely out of
//! the world.

use std::sync::Arc;

use drystone::breakage::JointStrength;
use drystone::events::{FaultKind, FrameCall};
use drystone::joint::{
    Ball, CouplingDef, Distance, Hinge, JointAxis, JointDrive, JointSpring, Rope, SixDof, Spring,
    Universal,
};
use drystone::math::Sym3;
use drystone::particle::{LinkDef, LinkKind, LinkSpring, ParticleDef, RopeDef};
use drystone::threads::SimdLevel;
use drystone::{
    BodyDef, BodyId, BodyKind, BodyMut, DefError, Filter, Hull, JointDef, JointKind, MassDef,
    Material, Pose, Quat, Shape, ShapeDef, Vec3, World, WorldConfig, limits, vec3,
};

const DT: f32 = 1.0 / 60.0;

fn ground(world: &mut World) -> BodyId {
    let plane = ShapeDef::half_space([0.0, 1.0, 0.0], 0.0);
    world.add_body(BodyDef::fixed().with_shape(plane)).unwrap()
}

fn ball(world: &mut World, at: impl Into<Vec3>) -> BodyId {
    let def = BodyDef::dynamic().with_position(at);
    world.add_body(def.with_shape(ShapeDef::sphere(0.5))).unwrap()
}

fn speed(world: &World, body: BodyId) -> f32 {
    world.body(body).unwrap().linear_velocity().length()
}

/// Whether every number that a user can get is finite.
fn all_finite(world: &World) -> bool {
    let bodies = world.bodies().all(|b| {
        let vectors = [
            b.position(),
            b.center_of_mass(),
            b.linear_velocity(),
            b.angular_velocity(),
            b.velocity_at([1.0, 2.0, 3.0]),
        ];
        let numbers = [b.mass(), b.kinetic_energy(), b.potential_energy()];
        vectors.iter().all(|v| v.is_finite()) && numbers.iter().all(|x| x.is_finite())
    });
    let joints = world.joints().all(|j| {
        let vectors = [j.anchor_a(), j.anchor_b(), j.force(), j.torque()];
        vectors.iter().all(|v| v.is_finite())
            && j.error().is_finite()
            && j.angular_error().is_finite()
    });
    let particles = world.particles().all(|p| {
        let vectors = [p.position(), p.velocity(), p.attachment_force()];
        vectors.iter().all(|v| v.is_finite()) && p.kinetic_energy().is_finite()
    });
    let links = world.links().all(|l| {
        [l.tension(), l.distance(), l.error()].iter().all(|x| x.is_finite())
            && l.elastic_energy().is_finite()
    });
    let contacts = world.contacts().all(|c| {
        let points = c
            .points()
            .all(|p| p.position.is_finite() && p.separation.is_finite() && p.impulse.is_finite());
        c.normal().is_finite() && c.friction_impulse().is_finite() && points
    });
    let sums = world.kinetic_energy().is_finite() && world.potential_energy().is_finite();
    bodies && joints && particles && links && contacts && sums && world.momentum().is_finite()
}

#[test]
fn a_joint_of_a_tree_takes_other_axes_while_it_moves() {
    let limited = JointAxis::limited(-1.0, 1.0);
    let motor = JointAxis::driven(JointDrive::motor(1.0, 100.0));
    let changes = [
        (Hinge::of(limited).six_dof(), Universal::of(limited, limited).six_dof()),
        (Universal::of(limited, limited).six_dof(), Hinge::of(limited).six_dof()),
        (Hinge::of(motor).six_dof(), Universal::of(motor, JointAxis::FREE).six_dof()),
    ];
    for (from, to) in changes {
        let mut world = World::default();
        let mut last = world.add_body(BodyDef::fixed()).unwrap();
        let mut joints = Vec::new();
        for i in [0.0, 1.0, 2.0] {
            let def = BodyDef::dynamic().with_position([0.0, -1.0 - i, 0.0]);
            let body = def.with_shape(ShapeDef::box_half([0.1, 0.4, 0.1]));
            let body = world.add_body(body).unwrap();
            let joint = JointDef::new(last, body, from).at([0.0, -0.5 - i, 0.0]).with_axis(Vec3::X);
            joints.push(world.add_joint(joint.with_articulated(true)).unwrap());
            last = body;
        }
        (0..5).for_each(|_| world.step(DT));
        assert_eq!(world.joint_mut(joints[1]).unwrap().set_axes(to), Ok(()));
        for _ in 0..60 {
            world.step(DT);
            assert!(world.joints().all(|j| j.error() < 1.0e-3));
        }
        assert!(all_finite(&world) && world.events().faults.is_empty());
    }
}

#[test]
fn the_search_for_the_nearest_shape_ends_however_small_the_shape_is_for_its_place() {
    let mut world = World::default();
    let sphere = ShapeDef::sphere(1.0);
    let def = BodyDef::fixed().with_position([1003.0, 1000.0, 1000.0]);
    let body = world.add_body(def.with_shape(sphere)).unwrap();
    let pose = Pose::at([1000.0, 1000.0, 1000.0]);
    // An ulp at 1000 m is 6e-5 m, so the shape's bounding box has no extent there.
    let tiny = Shape::sphere(1.0e-5);
    let nearest = world.query().nearest_shape(&tiny, pose, 10.0, Filter::default());
    let nearest = nearest.unwrap().unwrap();
    assert_eq!(nearest.body, body);
    assert!((nearest.distance - 2.0).abs() < 2.0e-4, "{}", nearest.distance);
    let empty = World::default();
    let far = limits::DISPLACEMENT.maximum;
    let none = empty.query().nearest_shape(&tiny, Pose::IDENTITY, far, Filter::default());
    assert_eq!(none, Ok(None));
}

#[test]
fn what_would_undo_a_coupling_is_refused_and_the_world_can_be_saved() {
    let mut world = World::default();
    let base = world.add_body(BodyDef::fixed()).unwrap();
    let hinge = |world: &mut World, x: f32| {
        let body = ball(world, [x, 1.0, 0.0]);
        let axes = Hinge::new().six_dof();
        let def = JointDef::new(base, body, axes).at([x, 1.0, 0.0]).with_axis(Vec3::X);
        world.add_joint(def).unwrap()
    };
    let (a, b) = (hinge(&mut world, 0.0), hinge(&mut world, 3.0));
    world.add_coupling(CouplingDef::gear(a, b, 2.0)).unwrap();
    world.step(DT);
    for joint in [a, b] {
        let error = world.joint_mut(joint).unwrap().set_axes(SixDof::FIXED).unwrap_err();
        assert!(error.field().contains("angular[0]"), "{error}");
    }
    let mut again = World::restore(&world.snapshot()).unwrap();
    for _ in 0..30 {
        world.step(DT);
        again.step(DT);
    }
    assert_eq!(world.state_hash(), again.state_hash());
}

#[test]
fn a_step_too_short_to_compute_with_passes_no_time() {
    let mut world = World::default();
    ground(&mut world);
    ball(&mut world, [0.0, 3.0, 0.0]);
    world.step(DT);
    let before = world.state_hash();
    for dt in [0.0, -1.0, f32::NAN, f32::INFINITY, 9.9e-7, 1.0e-12, 1.0e-38, 1.0e-45, 10.1] {
        world.step(dt);
        assert_eq!(world.events().faults[0].kind, FaultKind::BadTimeStep, "{dt}");
        assert_eq!(world.state_hash(), before, "{dt}");
    }
    for dt in [limits::TIME_STEP.minimum, limits::TIME_STEP.maximum] {
        world.step(dt);
        assert!(world.events().faults.is_empty(), "{dt}");
    }
}

/// At rest the errors of links are micrometers. A short step must not turn them into speed beyond
/// the speed gravity adds in a step of 1/60 s.
#[test]
fn one_short_step_gives_what_rests_no_speed() {
    for dt in [1.0e-3, 1.0e-4, 1.0e-5, 1.0e-6] {
        let mut world = World::default();
        ground(&mut world);
        for i in [0.0, 1.0, 2.0] {
            let cube = ShapeDef::box_half([0.5; 3]);
            let def = BodyDef::dynamic().with_position([0.0, 0.5 + i, 0.0]);
            world.add_body(def.with_shape(cube)).unwrap();
        }
        let mut rope = RopeDef::between([-5.0, 5.0, 0.0], [-5.0, 2.0, 0.0], 10);
        rope.pinned = [true, false];
        world.add_rope(rope).unwrap();
        (0..900).for_each(|_| world.step(DT));
        let speeds = |world: &World| -> Vec<Vec3> {
            let bodies = world.bodies().map(|b| b.linear_velocity());
            bodies.chain(world.particles().map(|p| p.velocity())).collect()
        };
        let before = speeds(&world);
        world.step(dt);
        for (v, before) in speeds(&world).into_iter().zip(before) {
            let jump = (v - before).length();
            assert!(jump < 9.81 * DT, "{dt}: {jump} m/s");
        }
        // It stays at rest.
        (0..60).for_each(|_| world.step(DT));
        assert!(all_finite(&world) && world.events().faults.is_empty());
    }
}

/// Gravity takes a particle out of the range of computation; a weak spring ties it to another
/// particle.
#[test]
fn a_particle_that_is_put_aside_is_out_of_the_world() {
    let config = WorldConfig { gravity: vec3(0.0, -1.0e6, 0.0), ..WorldConfig::default() };
    let mut world = World::new(config).unwrap();
    let add = |world: &mut World, x: f32, scale: f32| {
        let def = ParticleDef { gravity_scale: scale, ..ParticleDef::at([x, 0.0, 0.0]) };
        world.add_particle(def).unwrap()
    };
    let (lost, near) = (add(&mut world, 0.0, 1.0e3), add(&mut world, 1.0, 0.0));
    let weak = LinkSpring::Rate { stiffness: 1.0e-3, damping: 0.0 };
    let link = world.add_link(LinkDef::new(lost, near, LinkKind::Spring(weak))).unwrap();
    // 1e9 m/s² for 0.2 s.
    world.step(0.2);
    assert_eq!(world.events().faults.iter().filter_map(|f| f.particle).collect::<Vec<_>>(), [lost]);
    assert!(world.particle(lost).unwrap().is_faulted());
    assert!(!world.particle(near).unwrap().is_faulted());
    for _ in 0..20 {
        let before = world.particle(near).unwrap().velocity();
        world.step(DT);
        assert!(world.events().faults.is_empty() && all_finite(&world));
        // The link is inactive, so no force acts.
        assert_eq!(world.particle(near).unwrap().velocity(), before);
    }
    assert!(world.link(link).unwrap().tension().abs() < f32::MIN_POSITIVE);
    let mut other = World::restore(&world.snapshot()).unwrap();
    other.set_simd_level(SimdLevel::available()[0]);
    world.set_gravity(Vec3::ZERO);
    other.set_gravity(Vec3::ZERO);
    for w in [&mut world, &mut other] {
        w.particle_mut(lost).unwrap().set_position([3.0, 0.0, 0.0]);
        (0..5).for_each(|_| w.step(DT));
        assert!(!w.particle(lost).unwrap().is_faulted());
        // The particle and its spring are back: 1e-3 N/m at about 2 m.
        assert!(w.particle(lost).unwrap().velocity() != Vec3::ZERO);
    }
    assert_eq!(world.state_hash(), other.state_hash());
}

/// One of two balls on a weak spring is lost: the other moves on, and no query finds the lost one.
#[test]
fn a_body_that_is_put_aside_is_out_of_the_world() {
    let mut world = World::default();
    ground(&mut world);
    let (lost, near) = (ball(&mut world, [0.0, 5.0, 0.0]), ball(&mut world, [4.0, 5.0, 0.0]));
    let spring = Spring { rest_length: 4.0, hertz: 0.01, damping_ratio: 0.0 };
    let kind = JointKind::Distance { min: 0.0, max: 1.0e9, spring: Some(spring) };
    let joint = JointDef { kind, ..JointDef::new(lost, near, Ball::new()) };
    let joint = world.add_joint(joint).unwrap();
    world.step(DT);
    // 1e9 m/s² for 0.2 s.
    world.set_gravity([0.0, 1.0e6, 0.0]);
    world.body_mut(lost).unwrap().set_gravity_scale(1.0e3);
    world.body_mut(near).unwrap().set_gravity_scale(0.0);
    world.step(0.2);
    assert!(world.body(lost).unwrap().is_faulted());
    world.set_gravity(Vec3::ZERO);
    for body in [lost, near] {
        world.body_mut(body).unwrap().set_gravity_scale(1.0);
    }
    assert!(all_finite(&world) && !world.body(near).unwrap().is_faulted());
    let at = world.body(lost).unwrap().position();
    let up = Vec3::Y * 2.0;
    let ray = world.query().cast_ray(at - up, up * 2.0, Filter::default()).unwrap();
    assert!(ray.is_none_or(|hit| hit.body != lost), "a ray does not meet it");
    world.body_mut(near).unwrap().set_linear_velocity([1.0, 0.0, 0.0]);
    for _ in 0..60 {
        world.step(DT);
        // Its spring is inactive, so it flies on.
        assert!((speed(&world, near) - 1.0).abs() < 1.0e-5 && all_finite(&world));
    }
    assert_eq!(world.joint(joint).unwrap().force(), Vec3::ZERO);
    let mut other = World::restore(&world.snapshot()).unwrap();
    for w in [&mut world, &mut other] {
        w.body_mut(near).unwrap().set_pose(Pose::at([4.0, 0.5, 0.0]));
        w.body_mut(near).unwrap().set_linear_velocity(Vec3::ZERO);
        w.set_gravity([0.0, -9.81, 0.0]);
        w.body_mut(lost).unwrap().set_pose(Pose::at([4.0, 3.0, 0.0]));
        (0..240).for_each(|_| w.step(DT));
        assert!(!w.body(lost).unwrap().is_faulted());
        let height = w.body(lost).unwrap().position().y;
        assert!((0.4..1.6).contains(&height), "it lies on the other or on the ground: {height}");
    }
    assert_eq!(world.state_hash(), other.state_hash());
}

#[test]
fn a_contact_with_what_is_put_aside_ends() {
    let mut world = World::default();
    ground(&mut world);
    let lost = ball(&mut world, [0.0, 0.5, 0.0]);
    let top = ball(&mut world, [0.0, 1.5, 0.0]);
    let (mut begun, mut ended) = (0, 0);
    let count = |world: &World, begun: &mut usize, ended: &mut usize| {
        *begun += world.events().contact_begin.len();
        *ended += world.events().contact_end.len();
    };
    for _ in 0..60 {
        world.step(DT);
        count(&world, &mut begun, &mut ended);
    }
    assert_eq!(world.contacts().count(), 2);
    // Beyond the range in one step: 1e6 m/s for 10 s from 1e7 m is not enough, so gravity helps.
    world.set_gravity([1.0e6, 0.0, 0.0]);
    world.body_mut(lost).unwrap().set_gravity_scale(1.0e3);
    world.body_mut(top).unwrap().set_gravity_scale(0.0);
    world.step(0.2);
    count(&world, &mut begun, &mut ended);
    assert!(world.body(lost).unwrap().is_faulted());
    world.step(DT);
    count(&world, &mut begun, &mut ended);
    assert_eq!(world.contacts().filter(|c| c.body_a() == lost || c.body_b() == lost).count(), 0);
    assert!(all_finite(&world));
    assert!(world.remove_body(lost));
    world.step(DT);
    count(&world, &mut begun, &mut ended);
    let left = world.contacts().count();
    assert_eq!(begun, ended + left, "events come in pairs");
}

fn refused<T: core::fmt::Debug>(what: &str, result: Result<T, DefError>, field: &str) {
    let error = result.map(|_| what).unwrap_err();
    assert!(error.field().contains(field), "{what}: {error}");
    assert!(!error.allowed().is_empty(), "{what}");
}

#[test]
fn numbers_beyond_what_can_be_computed_with_are_refused_by_name() {
    let sphere = || BodyDef::dynamic().with_shape(ShapeDef::sphere(0.5));
    let exact = |mass: f32, center: Vec3, inertia: f32| BodyDef {
        mass: MassDef::Exact { mass, center, inertia: Sym3::diagonal(Vec3::splat(inertia)) },
        ..BodyDef::dynamic()
    };
    let resisting =
        Material { rolling_resistance: 3.4e38, spinning_resistance: 3.4e38, ..Material::default() };
    let far = ShapeDef::sphere(0.5).with_position([0.0, 3.4e38, 0.0]);
    let cases = [
        (
            "shape",
            BodyDef::dynamic().with_mass(1.0).with_shape(far.clone()),
            "shapes[0].pose.position",
        ),
        ("static shape", BodyDef::fixed().with_shape(far), "shapes[0].pose.position"),
        ("center", exact(1.0, vec3(0.0, 3.4e38, 0.0), 1.0), "center"),
        ("center", exact(1.0, vec3(1.0e20, 1.0e20, 0.0), 1.0), "center"),
        ("inertia", exact(1.0, Vec3::ZERO, 3.4e38), "inertia"),
        ("inertia", exact(1.0, Vec3::ZERO, 1.0e-40), "inertia"),
        ("mass", sphere().with_mass(3.4e38), "mass"),
        ("mass", sphere().with_mass(1.0e-45), "mass"),
        (
            "density",
            BodyDef::dynamic().with_shape(ShapeDef::sphere(0.5).with_density(3.4e38)),
            "density",
        ),
        (
            "density",
            BodyDef::dynamic().with_shape(ShapeDef::sphere(0.5).with_density(1.0e-40)),
            "density",
        ),
        (
            "both legal",
            BodyDef::dynamic().with_shape(ShapeDef::sphere(1.0e7).with_density(1.0e12)),
            "mass",
        ),
        ("gravity", BodyDef { gravity_scale: 3.4e38, ..sphere() }, "gravity_scale"),
        ("damping", BodyDef { linear_damping: 3.4e38, ..sphere() }, "linear_damping"),
        (
            "friction",
            BodyDef::dynamic().with_shape(ShapeDef::sphere(0.5).with_friction(3.4e38)),
            "friction",
        ),
        (
            "rolling",
            BodyDef::dynamic().with_shape(ShapeDef::sphere(0.5).with_material(resisting)),
            "rolling_resistance",
        ),
        (
            "legal alone",
            exact(1.0e15, Vec3::ZERO, 1.0e30).with_angular_velocity([1.0e6, 0.0, 0.0]),
            "angular_velocity",
        ),
    ];
    let mut world = World::default();
    let empty = world.state_hash();
    for (what, def, field) in cases {
        refused(what, world.add_body(def), field);
    }
    assert_eq!(world.state_hash(), empty);
    assert_eq!(world.bodies().count(), 0);
}

#[test]
fn calls_that_would_lead_beyond_are_refused_and_change_nothing() {
    let mut world = World::default();
    let carrier = BodyDef::kinematic().with_position([0.0, 5.0, 0.0]);
    let carrier = world.add_body(carrier.with_shape(ShapeDef::sphere(0.5))).unwrap();
    let body = ball(&mut world, [3.0, 3.0, 0.0]);
    let particle = world.add_particle(ParticleDef::at([0.0, 3.0, 0.0])).unwrap();
    let pose = Pose::at([0.0, 6.0, 0.0]);
    let (nan, huge) = ([f32::NAN, 0.0, 0.0], [3.0e38, 0.0, 0.0]);
    let rope = JointDef::new(body, carrier, Rope::new(9.0));
    let rope = world.add_joint(rope).unwrap();
    let hinge = world.add_joint(JointDef::new(body, carrier, Hinge::new())).unwrap();
    let ball = world.add_joint(JointDef::new(body, carrier, Ball::new())).unwrap();
    let link = RopeDef::between([0.0, 9.0, 0.0], [1.0, 9.0, 0.0], 1);
    let link = world.add_rope(link).unwrap().links[0];
    let far = Pose::at([0.0, 9.0e6, 0.0]);
    let spring = JointSpring::hertz(1.0, 1.0);
    let shape = world.body(body).unwrap().shapes().next().unwrap();
    let before = world.state_hash();
    type Make<'a> = &'a dyn Fn(&mut World);
    let of = |id: BodyId, make: fn(&mut BodyMut<'_>)| {
        move |w: &mut World| make(&mut w.body_mut(id).unwrap())
    };
    let calls: &[(FrameCall, Make<'_>)] = &[
        (FrameCall::SetPose, &|w| w.body_mut(body).unwrap().set_pose(Pose::at(nan))),
        (FrameCall::SetLinearVelocity, &of(body, |b| b.set_linear_velocity([1.1e6, 0.0, 0.0]))),
        (FrameCall::SetAngularVelocity, &of(body, |b| b.set_angular_velocity([f32::NAN; 3]))),
        (FrameCall::MoveTo, &|w| w.body_mut(carrier).unwrap().move_to(pose, 1.0e-42)),
        (FrameCall::MoveTo, &|w| w.body_mut(carrier).unwrap().move_to(pose, 1.0e-20)),
        (FrameCall::MoveTo, &|w| w.body_mut(carrier).unwrap().move_to(far, 1.0e-3)),
        (FrameCall::ApplyImpulse, &|w| w.body_mut(body).unwrap().apply_impulse(huge)),
        (FrameCall::ApplyAngularImpulse, &|w| {
            w.body_mut(body).unwrap().apply_angular_impulse(huge);
        }),
        (FrameCall::ApplyImpulseAt, &|w| {
            let (impulse, point) = ([1.0e6, 0.0, 0.0], [0.0, 1.0e7, 0.0]);
            w.body_mut(body).unwrap().apply_impulse_at(impulse, point);
        }),
        (FrameCall::AddStepForce, &|w| w.body_mut(body).unwrap().add_step_force(huge)),
        (FrameCall::AddStepForceAt, &|w| {
            w.body_mut(body).unwrap().add_step_force_at([1.0; 3], nan);
        }),
        (FrameCall::AddStepTorque, &|w| w.body_mut(body).unwrap().add_step_torque(huge)),
        (FrameCall::SetLastingForce, &|w| w.body_mut(body).unwrap().set_lasting_force(huge)),
        (FrameCall::SetLastingTorque, &|w| w.body_mut(body).unwrap().set_lasting_torque(huge)),
        (FrameCall::SetGravityScale, &of(body, |b| b.set_gravity_scale(1001.0))),
        (FrameCall::SetDamping, &of(body, |b| b.set_damping(0.0, -1.0))),
        (FrameCall::SetSurfaceVelocity, &|w| {
            w.shape_mut(shape).unwrap().set_surface_velocity(nan);
        }),
        (FrameCall::SetSurfaceSpin, &|w| w.shape_mut(shape).unwrap().set_surface_spin(huge)),
        (FrameCall::SetMotor, &|w| w.joint_mut(hinge).unwrap().set_motor(f32::NAN, 1.0)),
        (FrameCall::SetMotor, &|w| w.joint_mut(ball).unwrap().set_motor(1.0, 1.0)),
        (FrameCall::SetServo, &|w| w.joint_mut(hinge).unwrap().set_servo(0.0, spring, -1.0)),
        (FrameCall::SetTargetRotation, &|w| {
            let bad = Quat { w: 3.0, ..Quat::IDENTITY };
            w.joint_mut(ball).unwrap().set_target_rotation(bad, spring, 1.0);
        }),
        (FrameCall::SetLengths, &|w| w.joint_mut(rope).unwrap().set_lengths(2.0, 1.0)),
        (FrameCall::SetParticlePosition, &|w| {
            w.particle_mut(particle).unwrap().set_position(nan);
        }),
        (FrameCall::SetParticleVelocity, &|w| {
            w.particle_mut(particle).unwrap().set_velocity(huge);
        }),
        (FrameCall::ApplyParticleImpulse, &|w| {
            w.particle_mut(particle).unwrap().apply_impulse([3.0e38; 3]);
        }),
        (FrameCall::SetLinkLength, &|w| w.link_mut(link).unwrap().set_length(-1.0)),
        (FrameCall::SetGravity, &|w| w.set_gravity([0.0, -3.4e38, 0.0])),
    ];
    for (call, make) in calls {
        make(&mut world);
        assert_eq!(world.state_hash(), before, "{}", call.name());
        assert_eq!(world.config().gravity, WorldConfig::default().gravity);
    }
    let ray = world.query().cast_ray([0.0, 1.0, 0.0], [0.0, -3.0e38, 0.0], Filter::default());
    refused("ray", ray, "delta");
    assert_eq!(world.state_hash(), before);
    assert!(all_finite(&world));
    // The next step names the calls in order; the step after it names none.
    world.step(DT);
    let told: Vec<FaultKind> = world.events().faults.iter().map(|fault| fault.kind).collect();
    let made: Vec<FaultKind> = calls.iter().map(|(call, _)| FaultKind::Refused(*call)).collect();
    assert_eq!(told, made);
    assert_eq!(world.events().faults[0].body, Some(body));
    assert!(!world.body(body).unwrap().is_faulted(), "it goes on");
    world.step(DT);
    assert!(world.events().faults.is_empty());
}

#[test]
fn what_is_static_has_no_velocity_whatever_was_said() {
    let mut world = World::default();
    let def = BodyDef { kind: BodyKind::Static, ..BodyDef::default() };
    let body = world.add_body(def.with_linear_velocity([1.0, 2.0, 3.0])).unwrap();
    assert_eq!(world.body(body).unwrap().linear_velocity(), Vec3::ZERO);
}

/// Joints that are made far apart close at 10 m/s plus 3 m/s at any distance. A pull at an arm also
/// rotates the body: 0.5 m at 26 rad/s adds the same again. 60 m/s exceeds the sum of all these.
#[test]
fn joints_that_cannot_be_met_have_a_limit_of_speed() {
    for d in [0.5_f32, 2.0, 10.0, 100.0, 1.0e3] {
        for kind in ["ball", "rod", "hinge", "tree"] {
            let mut world = World::default();
            ground(&mut world);
            let (a, b) = (ball(&mut world, [0.0, 3.0, 0.0]), ball(&mut world, [d + 1.0, 3.3, 0.2]));
            let (near, far) = ([0.5, 0.0, 0.0], [-0.5, 0.0, 0.0]);
            let joint = match kind {
                "rod" => JointDef::new(a, b, Distance::exact(1.0)),
                "hinge" => JointDef::new(a, b, Hinge::new().six_dof()).with_anchors(near, far),
                _ => JointDef::new(a, b, Ball::new())
                    .with_anchors(near, far)
                    .with_articulated(kind == "tree"),
            };
            world.add_joint(joint).unwrap();
            let mut top = 0.0_f32;
            for _ in 0..300 {
                world.step(DT);
                top = top.max(speed(&world, a)).max(speed(&world, b));
                assert!(world.events().faults.is_empty(), "{kind} {d} m off");
            }
            assert!(top < 60.0, "{kind} {d} m off: {top} m/s");
            assert!(all_finite(&world));
        }
    }
}

#[test]
fn a_world_whose_joints_give_more_than_f32_has_can_be_saved() {
    // A beam of 20,000 km hangs from a pebble at its middle and overlaps a ball. Its moment of
    // inertia is 1e24 kg m², so squares of torques exceed f32. Sums of impulses are tracked because
    // a joint can break.
    let mut world = World::new(WorldConfig::default()).unwrap();
    ground(&mut world);
    let stone = world.add_body(BodyDef::dynamic().with_shape(ShapeDef::sphere(1.0))).unwrap();
    let post = world.add_body(BodyDef::kinematic()).unwrap();
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
    let pebble = ShapeDef::new(Shape::Hull(Arc::new(Hull::from_points(&corners).unwrap())));
    let pebble = BodyDef::dynamic().with_position([0.0, 1.0, 0.0]).with_shape(pebble);
    let pebble = world.add_body(pebble).unwrap();
    world.add_joint(JointDef::new(post, pebble, Ball::new())).unwrap();
    let beam = ShapeDef::box_half([1.0, 1.0e7, 0.4]);
    let beam = world.add_body(BodyDef::dynamic().with_shape(beam)).unwrap();
    let angular = [JointAxis::FREE, JointAxis::FREE, JointAxis::LOCKED];
    let held = SixDof { angular, ..SixDof::FIXED };
    let def = JointDef::new(pebble, beam, held).at([0.0; 3]).with_axis([0.0, 1.0, 1.0]);
    world.add_joint(def).unwrap();
    let kind = JointKind::Distance { min: 0.0, max: 0.0, spring: None };
    let strength = Some(JointStrength { force: 1.0, impulse: 1.0, ..JointStrength::default() });
    let def = JointDef::new(post, stone, Ball::new());
    world.add_joint(JointDef { kind, strength, ..def }).unwrap();
    for _ in 0..3 {
        world.step(DT);
        assert!(all_finite(&world));
        let again = World::restore(&world.snapshot()).unwrap();
        assert_eq!(again.state_hash(), world.state_hash());
    }
}

#[test]
fn the_page_of_limits_says_what_the_table_says() {
    let page = include_str!("../../manual/units_and_limits.md");
    for limit in limits::ALL {
        let row = format!("| {} | {} |", limit.quantity, limit.allowed);
        assert!(page.contains(&row), "manual/units_and_limits.md has no row `{row}`");
    }
    let of_four = |line: &&str| line.starts_with("| ") && line.matches('|').count() == 5;
    let rows = page.lines().filter(of_four).count();
    assert_eq!(rows, limits::ALL.len() + 1, "manual/units_and_limits.md has other rows");
}
