//! States that are stored, sent and restored: in memory, as bytes, as deltas, as calls.

use std::sync::Arc;

use drystone::breakage::{BondStrength, Fracture, Glue, JointStrength};
use drystone::contact::SurfaceRule;
use drystone::events::{ContactReports, Senses};
use drystone::joint::{
    CouplingDef, Distance, Hinge, JointAxis, JointDrive, JointMotion, JointSpring, Pulley, Spring,
};
use drystone::journal::{
    Answer, AxisCall, BodyCall, Call, JointCall, Journal, JournalError, ParticleCall, ShapeCall,
};
use drystone::particle::{ClothDef, LinkDef, LinkId, LinkKind, ParticleId, RopeDef, Strand};
use drystone::snapshot::{
    DeltaError, GeometryKey, Library, SnapshotError, apply_delta, write_delta,
};
use drystone::threads::{Executor, SimdLevel, Team};
use drystone::{
    Axis, AxisLocks, BodyDef, BodyId, BodyKind, Filter, Hull, JointDef, JointId, MassDef, Material,
    Mesh, Pose, Quat, Shape, ShapeDef, ShapeId, Vec3, World, WorldConfig, vec3,
};

const DT: f32 = 1.0 / 60.0;

fn stone() -> Shape {
    let points: Vec<Vec3> = (0..8_u8)
        .map(|i| vec3(f32::from(i & 1), 0.8 * f32::from(i >> 1 & 1), 0.6 * f32::from(i >> 2)))
        .collect();
    Shape::Hull(Arc::new(Hull::from_points(&points).unwrap()))
}

fn hills() -> Shape {
    let (mut corners, mut triangles) = (Vec::new(), Vec::new());
    for i in 0..30_u32 {
        for k in 0..30_u32 {
            let (x, z) = (i as f32 - 15.0, k as f32 - 15.0);
            corners.push(vec3(x, 0.01 * (x * x - z), z));
            if i > 0 && k > 0 {
                let a = 30 * i + k;
                triangles.extend([[a - 31, a - 30, a], [a - 31, a, a - 1]]);
            }
        }
    }
    Shape::Mesh(Arc::new(Mesh::new(corners, triangles).unwrap()))
}

/// Stones of one hull that roll on hills.
fn valley() -> World {
    let mut world = World::default();
    world.add_body(BodyDef::fixed().with_shape(ShapeDef::new(hills()))).unwrap();
    let stone = stone();
    for i in 0..20_u8 {
        let at = [f32::from(i % 5) * 2.0 - 4.0, 4.0, f32::from(i / 5) * 2.0 - 4.0];
        let at = BodyDef::dynamic().with_position(at);
        world.add_body(at.with_shape(ShapeDef::new(stone.clone()))).unwrap();
    }
    for _ in 0..60 {
        world.step(DT);
    }
    world
}

fn level(world: &World) -> String {
    format!("{:?}", world.simd_level())
}

fn assert_go_on_alike(world: &mut World, other: &mut World) {
    for step in 0..60 {
        world.step(DT);
        other.step(DT);
        assert_eq!(world.state_hash(), other.state_hash(), "step {step}");
        assert_eq!(world.events(), other.events(), "step {step}");
    }
}

#[test]
fn snapshots_name_what_a_library_has_and_hold_the_rest() {
    let mut world = valley();
    let whole = world.snapshot();
    let mut bytes = vec![1, 2, 3];
    world.snapshot_into(&mut bytes);
    assert!(bytes == whole);
    // The server's library has the meshes of its level; the client rebuilt them from its own files.
    let (mut server, mut client) = (Library::default(), Library::default());
    server.add_world(&world);
    assert_eq!((server.len(), server.add(&Shape::sphere(1.0))), (2, None));
    let keys: Vec<GeometryKey> = server.keys().collect();
    world.snapshot_with(&server, &mut bytes);
    // The mesh alone has 900 corners of 12 bytes, and the same number of triangles of 3 numbers,
    // twice.
    assert!(bytes.len() + 900 * 12 < whole.len(), "{} of {}", bytes.len(), whole.len());
    let mut other = World::default();
    for shape in [hills(), stone()] {
        let before = other.snapshot();
        let missing = other.restore_with(&client, &bytes).unwrap_err();
        let SnapshotError::MissingGeometry { key } = missing else { panic!("{missing}") };
        assert!(keys.contains(&key) && client.get(key).is_none());
        assert!(missing.to_string().contains(&key.to_string()));
        assert!(other.snapshot() == before, "a world that was not restored is as it was");
        let added = client.add(&shape).unwrap();
        assert!(keys.contains(&added), "the same content has the same key");
        assert_eq!(GeometryKey::from_bits(added.to_bits()), added);
    }
    other.restore_with(&client, &bytes).unwrap();
    // The client's snapshots also refer to meshes of the client's library.
    let mut again = Vec::new();
    other.snapshot_with(&client, &mut again);
    assert!(again == bytes);
    assert!(other.snapshot() == whole);
    assert_go_on_alike(&mut world, &mut other);
}

/// An executor with three threads of the user.
#[derive(Debug)]
struct InTurn;

impl Executor for InTurn {
    fn workers(&self) -> usize {
        3
    }

    fn run(&self, chunks: usize, task: &(dyn Fn(usize, usize) + Sync)) {
        (0..chunks).for_each(|chunk| task(chunk % 3, chunk));
    }
}

#[test]
fn a_world_that_is_restored_keeps_what_does_its_steps() {
    let mut world = valley();
    let bytes = world.snapshot();
    let executor: Arc<dyn Executor> = Arc::new(InTurn);
    let mut other = World::default().with_executor(Arc::clone(&executor));
    let lowest = *SimdLevel::available().last().unwrap();
    other.set_simd_level(lowest);
    other.add_body(BodyDef::dynamic().with_shape(ShapeDef::sphere(1.0))).unwrap();
    other.begin_ledger();
    other.step(DT);
    let before = other.snapshot();
    for end in 0..bytes.len().min(100) {
        assert!(other.restore_from(&bytes[..end]).is_err());
    }
    assert!(other.snapshot() == before);
    other.restore_from(&bytes).unwrap();
    assert_eq!(level(&other), format!("{lowest:?}"));
    // One reference here and one in the world.
    assert_eq!(Arc::strong_count(&executor), 2);
    assert!(other.end_ledger().is_none(), "books of another run say nothing of this one");
    assert_go_on_alike(&mut world, &mut other);
    // A copy continues like its source in both worlds.
    other.clone_from(&world);
    assert_eq!(Arc::strong_count(&executor), 1);
    assert_eq!(level(&other), level(&world));
}

#[test]
fn a_copy_tells_of_the_last_step_what_the_world_told() {
    let mut world = valley();
    world.begin_ledger();
    world.step(DT);
    let mut copy = World::default();
    copy.begin_ledger();
    copy.clone_from(&world);
    assert_eq!(copy.sweep_count(), world.sweep_count());
    assert!(world.sweep_count() > 0);
    assert_eq!(copy.stage_hashes(), world.stage_hashes());
    assert_go_on_alike(&mut world, &mut copy);
    let (ledger, copied) = (world.end_ledger().unwrap(), copy.end_ledger().unwrap());
    assert_eq!(ledger, copied, "the copy has the books too");
    assert_eq!(ledger.steps, 61);
}

#[test]
fn a_delta_is_small_where_little_moved_and_is_of_one_base() {
    let mut world = World::default();
    let floor = ShapeDef::half_space([0.0, 1.0, 0.0], 0.0);
    world.add_body(BodyDef::fixed().with_shape(floor)).unwrap();
    let mut balls = Vec::new();
    for i in 0..200_u16 {
        let at = BodyDef::dynamic().with_position([2.0 * f32::from(i), 0.5, 0.0]);
        let at = BodyDef { asleep: true, ..at };
        balls.push(world.add_body(at.with_shape(ShapeDef::sphere(0.5))).unwrap());
    }
    // After that no new data appears.
    (0..20).for_each(|_| world.step(DT));
    let base = world.snapshot();
    let mut hit = world.body_mut(balls[77]).unwrap();
    hit.set_linear_velocity([0.0, 0.0, 2.0]);
    world.add_body(BodyDef::fixed().with_shape(ShapeDef::sphere(0.5))).unwrap();
    world.step(DT);
    let snapshot = world.snapshot();
    let (mut delta, mut again) = (Vec::new(), Vec::new());
    write_delta(&base, &snapshot, &mut delta);
    // One body in two hundred moved. Apart from it only the trees of boxes were reordered, and
    // boxes are less than a tenth of the saved data of a ball with its contact: 24 bytes of 890.
    assert!(delta.len() * 10 < snapshot.len(), "{} of {}", delta.len(), snapshot.len());
    apply_delta(&base, &delta, &mut again).unwrap();
    assert!(again == snapshot);
    let mut other = World::default();
    other.restore_from(&again).unwrap();
    assert_go_on_alike(&mut world, &mut other);
    let wrong = apply_delta(&snapshot, &delta, &mut again).unwrap_err();
    assert!(matches!(wrong, DeltaError::WrongBase { .. }), "{wrong}");
}

/// A server sends the state of a body twice. The second time nothing changes and nothing wakes,
/// although the body's center of mass is not its origin and its rotation is normalized only up to
/// the last bits.
#[test]
fn a_correction_that_says_the_same_changes_nothing() {
    let mut server = valley();
    let mut client = server.clone();
    for _ in 0..7 {
        server.step(DT);
    }
    let bodies: Vec<_> = server.bodies().map(|b| b.id()).collect();
    for round in 0..3 {
        for id in &bodies {
            let there = server.body(*id).unwrap();
            let (v, w) = (there.linear_velocity(), there.angular_velocity());
            let mut here = client.body_mut(*id).unwrap();
            let changed = here.correct_state(there.pose(), v, w).unwrap();
            assert!(round == 0 || !changed, "round {round}, body {id:?}");
        }
    }
}

/// The objects for the calls of [`call_everything`].
struct Made {
    bodies: Vec<BodyId>,
    joints: Vec<JointId>,
    shape: ShapeId,
    strand: Strand,
    grain: ParticleId,
    link: LinkId,
}

fn pulley() -> Pulley {
    let points = [vec3(2.0, 9.0, 0.0), vec3(4.0, 9.0, 0.0)];
    Pulley { points, ratio: 1.0, length: 6.0, is_rigid: false }
}

/// A chain of bodies on joints of all kinds, a glued rod, a brittle cube, and a rope with a grain
/// tied to it.
fn make_all(call: &mut dyn FnMut(Call) -> Answer) -> Made {
    let cube = ShapeDef::box_half([0.4; 3]);
    let at = |x: f32, y: f32, z: f32| BodyDef::dynamic().with_position([x, y, z]);
    let shapes: Vec<ShapeDef> =
        (0..3_u8).map(|i| cube.clone().with_position([0.8 * f32::from(i), 0.0, 0.0])).collect();
    let glue = Glue::touching(&shapes, 1.0e-3, BondStrength::both(1.0e4)).unwrap();
    let bodies = [
        BodyDef::fixed().with_shape(ShapeDef::new(hills())),
        at(0.0, 5.0, 0.0).with_shape(cube.clone()),
        at(0.0, 6.0, 0.0).with_shape(ShapeDef::new(stone())),
        at(2.0, 6.0, 0.0).with_shape(ShapeDef::sphere(0.3)),
        at(4.0, 6.0, 0.0).with_shape(ShapeDef::capsule(0.3, 0.2)),
        BodyDef { shapes, ..at(-5.0, 6.0, 0.0) }.with_glue(glue),
        at(-5.0, 6.0, 4.0).with_shape(cube.clone()),
        at(50.0, 6.0, 4.0).with_shape(cube),
    ];
    let add = |def: BodyDef| match call(Call::AddBody(Box::new(def))) {
        Answer::Body(id) => Some(id),
        _ => None,
    };
    let bodies: Vec<BodyId> = bodies.into_iter().filter_map(add).collect();
    let (a, b, c, d) = (bodies[1], bodies[2], bodies[3], bodies[4]);
    let joints = [
        JointDef::new(a, b, Hinge::new()).with_anchors([0.5; 3], [0.0; 3]),
        JointDef::new(b, c, Hinge::new()).with_anchors([0.5; 3], [0.0; 3]),
        JointDef::new(c, d, Distance::exact(2.0)).with_anchors([0.0; 3], [0.0; 3]),
        JointDef::new(c, d, pulley()).with_anchors([0.0; 3], [0.0; 3]),
    ];
    let mut joint = |call_: Call| match call(call_) {
        Answer::Joint(id) => Some(id).into_iter(),
        _ => None.into_iter(),
    };
    let mut joints: Vec<JointId> =
        joints.into_iter().flat_map(|def| joint(Call::AddJoint(Box::new(def)))).collect();
    joints.extend(joint(Call::AddCoupling(CouplingDef::gear(joints[0], joints[1], -2.0))));
    let rope = RopeDef::between([5.0, 6.0, 0.0], [5.0, 4.0, 0.0], 5);
    let mut strand = Strand::default();
    if let Answer::Strand(made) = call(Call::AddRope(Box::new(rope))) {
        strand = made;
    }
    let grain = match call(Call::AddParticle(Box::default())) {
        Answer::Particle(id) => Some(id),
        _ => None,
    };
    let grain = grain.unwrap();
    let link = match call(Call::AddLink(LinkDef::new(grain, strand.particles[0], LinkKind::AtMost)))
    {
        Answer::Link(id) => Some(id),
        _ => None,
    };
    let shape = match call(Call::AddShape(a, Box::new(ShapeDef::sphere(0.5)))) {
        Answer::Shape(id) => Some(id),
        _ => None,
    };
    Made { bodies, joints, shape: shape.unwrap(), strand, grain, link: link.unwrap() }
}

/// All calls on bodies and shapes.
fn body_calls(made: &Made) -> Vec<Call> {
    let [_, a, b, c, d, _, _, gone] = made.bodies[..] else { return Vec::new() };
    let body = |id, call| Call::Body(id, call);
    let v = vec3(0.3, 0.2, -0.1);
    let locks = AxisLocks { linear: [false; 3], angular: [false, true, false] };
    let mut calls = vec![
        body(a, BodyCall::SetLinearVelocity(v)),
        body(a, BodyCall::SetAngularVelocity(v)),
        body(b, BodyCall::ApplyImpulse(v)),
        body(b, BodyCall::ApplyImpulseAt(v, vec3(0.0, 6.0, 0.0))),
        body(b, BodyCall::ApplyAngularImpulse(v)),
        body(c, BodyCall::AddStepForce(v)),
        body(c, BodyCall::AddStepForceAt(v, vec3(2.0, 6.0, 0.0))),
        body(c, BodyCall::AddStepTorque(v)),
        body(d, BodyCall::SetLastingForce(v)),
        body(d, BodyCall::SetLastingTorque(v)),
        body(d, BodyCall::SetGravityScale(0.5)),
        body(d, BodyCall::SetDamping(0.1, 0.2)),
        body(d, BodyCall::SetLocks(locks)),
        body(d, BodyCall::SetCanSleep(false)),
        body(d, BodyCall::SetSleepSpeed(Some(0.1))),
        body(d, BodyCall::SetUserData(7)),
        body(c, BodyCall::SetMass(MassDef::Mass(20.0))),
        body(gone, BodyCall::SetKind(BodyKind::Kinematic)),
        body(gone, BodyCall::MoveTo(Pose::at([49.0, 6.0, 4.0]), 1.0)),
        Call::Step(DT),
        body(c, BodyCall::SetEnabled(false)),
        body(a, BodyCall::Sleep),
        Call::WakeAll,
        body(b, BodyCall::Wake),
        body(b, BodyCall::SetPose(Pose::at([0.0, 6.1, 0.0]))),
        body(d, BodyCall::CorrectState(Pose::at([4.0, 6.0, 0.1]), v, v)),
        Call::Step(DT),
    ];
    let material = Material { restitution: 0.4, ..Material::default() };
    let shape = [
        ShapeCall::SetMaterial(material),
        ShapeCall::SetSurfaceVelocity(v),
        ShapeCall::SetSurfaceSpin(v),
        ShapeCall::SetFilter(Filter::default()),
        ShapeCall::SetSensor(true),
        ShapeCall::SetDensity(500.0),
        ShapeCall::SetLocalPose(Pose::at([0.1; 3])),
        ShapeCall::SetGeometry(stone()),
        ShapeCall::SetEnabled(false),
        ShapeCall::SetUserData(9),
        ShapeCall::SetReports(ContactReports::with_forces()),
        ShapeCall::SetSenses(Senses { statics: true, sensors: true }),
        ShapeCall::SetHooks(true),
        ShapeCall::SetOneWay(Some(Vec3::Y)),
    ];
    calls.extend(shape.into_iter().map(|call| Call::Shape(made.shape, call)));
    calls
}

/// All calls on joints and particles, and calls that break and remove.
fn other_calls(made: &Made) -> Vec<Call> {
    let [_, _, _, _, d, rod, brittle, gone] = made.bodies[..] else { return Vec::new() };
    let [hinge, other, distance, over, gear] = made.joints[..] else { return Vec::new() };
    let particles = &made.strand.particles;
    let v = vec3(0.3, 0.2, -0.1);
    let axes = Hinge::new().six_dof();
    let on = |axis, call| Call::Joint(hinge, JointCall::Axis(axis, call));
    let turn = Some(Axis::TurnX);
    let slick = SurfaceRule { friction: Some(0.1), ..SurfaceRule::between(1, 1) };
    let (force, torque, impulse) = (1.0e6, 1.0e6, f32::INFINITY);
    let strength = JointStrength { force, torque, impulse, fatigue: None };
    let limit = JointMotion::Limited { min: -0.1, max: 0.1, spring: None };
    let cloth = ClothDef::new([8.0, 6.0, 0.0], [Vec3::X, Vec3::Z], [3, 3]);
    let fracture = Fracture::by_impulse(10.0).with_pieces(3);
    let dust = vec![vec3(1.0, 8.0, 0.0), vec3(1.5, 8.0, 0.0)];
    vec![
        Call::AddCloth(Box::new(cloth)),
        Call::AddCloud(dust, Box::default()),
        Call::Particle(particles[5], ParticleCall::Attach(d, Vec3::ZERO)),
        Call::Joint(hinge, JointCall::SetAnchors(vec3(0.4, 0.5, 0.5), Vec3::ZERO)),
        Call::Joint(hinge, JointCall::SetFrames(Quat::IDENTITY, Quat::IDENTITY)),
        on(None, AxisCall::SetMotor(1.0, 50.0)),
        on(None, AxisCall::SetLimits(-2.0, 2.0)),
        on(None, AxisCall::SetFriction(0.1)),
        on(turn, AxisCall::SetDrive(Some(JointDrive::motor(1.0, 50.0)))),
        on(turn, AxisCall::SetServo(0.2, JointSpring::hertz(3.0, 1.0), 9.0)),
        on(turn, AxisCall::Set(JointAxis::limited(-1.0, 1.0))),
        Call::Joint(other, JointCall::SetAxes(Box::new(axes))),
        Call::Joint(other, JointCall::Axis(Some(Axis::TurnY), AxisCall::SetMotion(limit))),
        Call::Joint(hinge, JointCall::SetStrength(Some(strength))),
        Call::Joint(distance, JointCall::SetLengths(0.5, 2.5)),
        Call::Joint(distance, JointCall::SetSpring(Some(Spring::new(1.0, 4.0, 0.5)))),
        Call::Joint(distance, JointCall::Wake),
        Call::SetBodiesCollide(d, rod, false),
        Call::SetSurfaceRules(vec![slick]),
        Call::Joint(over, JointCall::SetPulley(Pulley { length: 6.5, ..pulley() })),
        Call::Joint(gear, JointCall::SetCoupling(-1.5, 0.1)),
        Call::Joint(hinge, JointCall::SetCollideConnected(true)),
        Call::Joint(hinge, JointCall::SetArticulated(true)),
        Call::Joint(distance, JointCall::SetEnabled(false)),
        Call::Joint(distance, JointCall::SetUserData(3)),
        Call::Step(DT),
        Call::Particle(made.grain, ParticleCall::SetPosition(vec3(5.0, 6.5, 0.0))),
        Call::Particle(made.grain, ParticleCall::SetVelocity(v)),
        Call::Particle(made.grain, ParticleCall::ApplyImpulse(v)),
        Call::Particle(made.grain, ParticleCall::SetMass(0.5)),
        Call::Particle(particles[0], ParticleCall::SetPinned(true)),
        Call::SetLinkLength(made.link, 0.7),
        Call::Body(rod, BodyCall::SetBondStrength(BondStrength::both(1.0e5))),
        Call::Body(brittle, BodyCall::SetFracture(Some(fracture))),
        Call::BreakAt(brittle, vec3(-5.0, 6.0, 4.0), Fracture::by_impulse(1.0)),
        Call::SetConfig(Box::new(WorldConfig { substeps: 4, ..WorldConfig::default() })),
        Call::SetGravity(vec3(0.0, -5.0, 0.0)),
        Call::Step(DT),
        Call::Particle(particles[5], ParticleCall::Detach),
        Call::RemoveLink(made.link),
        Call::RemoveParticle(made.grain),
        Call::RemoveJoint(gear),
        Call::RemoveShape(made.shape),
        Call::RemoveBody(gone),
    ]
}

/// Makes calls of all kinds, including refused ones and ones on removed objects.
fn call_everything(world: &mut World, journal: &mut Journal) {
    let made = make_all(&mut |call| journal.call(world, call).unwrap());
    for call in body_calls(&made).into_iter().chain(other_calls(&made)) {
        let text = format!("{call:?}");
        let answer = journal.call(world, call).map_err(|e| format!("{text}: {e}")).unwrap();
        assert_ne!(answer, Answer::Nothing, "{text}");
    }
    let (ground, first, gone) = (made.bodies[0], made.bodies[1], made.bodies[7]);
    let mut call = |call: Call| journal.call(world, call);
    assert_eq!(call(Call::RemoveBody(gone)), Ok(Answer::Nothing));
    assert_eq!(call(Call::Body(gone, BodyCall::Wake)), Ok(Answer::Nothing));
    assert!(call(Call::Body(first, BodyCall::SetDamping(-1.0, 0.0))).is_err());
    assert!(call(Call::AddShape(ground, Box::new(ShapeDef::sphere(-1.0)))).is_err());
    for _ in 0..30 {
        call(Call::Step(DT)).unwrap();
    }
    call(Call::Step(f32::NAN)).unwrap();
}

#[test]
fn every_call_can_be_written_down_and_made_again() {
    let mut world = World::default();
    let mut journal = Journal::begin(&world);
    call_everything(&mut world, &mut journal);
    let read = Journal::from_bytes(&journal.to_bytes()).unwrap();
    assert_eq!(read.calls().len(), journal.calls().len());
    // In a world with a different past, and on threads.
    let mut other = valley().with_executor(Arc::new(Team::new(2)));
    read.replay(&mut other).unwrap();
    assert_eq!(other.state_hash(), world.state_hash());
    assert_eq!(other.events(), world.events());
    // Another start gives another run.
    let mut else_where = Journal::begin(&valley());
    for call in journal.calls().take(3) {
        else_where.call(&mut other, call.clone()).unwrap();
    }
    assert!(matches!(else_where.replay(&mut other), Err(JournalError::Differs(_))));
}
