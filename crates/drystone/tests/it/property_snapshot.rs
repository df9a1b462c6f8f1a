//! After any calls, the world can be saved, and the restored world behaves like the original.

use drystone::breakage::{BondStrength, Fracture, Glue};
use drystone::joint::{Ball, Hinge, JointAxis, JointDrive, JointMotion, JointSpring};
use drystone::math::Sym3;
use drystone::method::Method;
use drystone::particle::{LinkId, LinkKind, ParticleId, RopeDef};
use drystone::{
    Axis, BodyDef, BodyId, BodyKind, Filter, JointDef, JointId, MassDef, Material, Pose, Shape,
    ShapeDef, ShapeId, Vec3, World, WorldConfig, vec3,
};
use proptest::prelude::{Strategy, any, prop, prop_oneof, proptest};
use proptest::test_runner::{Config, RngSeed};

const DT: f32 = 1.0 / 60.0;

/// A call: its kind, its objects, and its numbers.
pub(crate) type Call = (u8, [u8; 2], [f32; 3], f32);

pub(crate) fn call() -> impl Strategy<Value = Call> {
    let number = prop_oneof![
        12 => -6.0_f32..6.0,
        1 => prop::sample::select(vec![0.0, f32::NAN, f32::INFINITY, -1.0e30, 3.0e38, 1.0e-30]),
    ];
    let vector = prop::array::uniform3(number.clone());
    (any::<u8>(), any::<[u8; 2]>(), vector, number)
}

/// Objects of a world and its twin; ids are the same in both.
#[derive(Default)]
pub(crate) struct Known {
    pub(crate) bodies: Vec<BodyId>,
    pub(crate) joints: Vec<JointId>,
    pub(crate) particles: Vec<ParticleId>,
    pub(crate) links: Vec<LinkId>,
}

impl Known {
    /// Adds the objects that a call made, and the pieces of broken bodies.
    pub(crate) fn learn(&mut self, added: Self, world: &World) {
        self.bodies.extend(added.bodies);
        self.bodies.extend(&world.events().pieces);
        self.joints.extend(added.joints);
        self.particles.extend(added.particles);
        self.links.extend(added.links);
    }
}

/// A world with ground, and its objects.
pub(crate) fn ground() -> (World, Known) {
    let mut world = World::default();
    let ground = ShapeDef::half_space([0.0, 1.0, 0.0], 0.0);
    let ground = world.add_body(BodyDef::fixed().with_shape(ground)).unwrap();
    (world, Known { bodies: vec![ground], ..Known::default() })
}

fn pick<T: Copy>(list: &[T], k: u8) -> Option<T> {
    (!list.is_empty()).then(|| list[usize::from(k) % list.len()])
}

fn shape_of(k: u8, size: f32) -> ShapeDef {
    let material = Material { restitution: 0.3, rolling_resistance: 0.1, ..Material::default() };
    match k % 6 {
        0 => ShapeDef::sphere(size.abs()),
        1 => ShapeDef::capsule(0.5, 0.3).with_material(material),
        2 | 3 => ShapeDef::box_half([0.5, 0.4, size.abs()]),
        4 => ShapeDef::cylinder(0.4, 0.5),
        _ => ShapeDef { sensor: true, ..ShapeDef::box_half([1.0; 3]) },
    }
}

fn body_of(k: u8, at: [f32; 3], size: f32) -> BodyDef {
    let row = |n: u8| -> Vec<ShapeDef> {
        let at = |i: u8| vec3(0.6 * f32::from(i), 0.0, 0.0);
        (0..n).map(|i| ShapeDef::box_half([0.3; 3]).with_position(at(i))).collect()
    };
    let dynamic = BodyDef::dynamic().with_position(at);
    match k % 8 {
        0 => BodyDef::fixed().with_position(at).with_shape(shape_of(k / 8, size)),
        1 => {
            let moving = BodyDef::kinematic().with_linear_velocity([0.5, 0.0, 0.0]);
            moving.with_position(at).with_shape(shape_of(k / 8, size))
        }
        2 => {
            let shapes = row(3);
            let glue = Glue::touching(&shapes, 1.0e-3, BondStrength::both(1.0e5)).unwrap();
            BodyDef { shapes, glue: Some(glue), ..dynamic }
        }
        3 => {
            let fracture = Fracture { pieces: 3, ..Fracture::by_impulse(500.0) };
            BodyDef { shapes: row(1), fracture: Some(fracture), ..dynamic }
        }
        _ => dynamic.with_shape(shape_of(k / 8, size)),
    }
}

/// Changes a property of a body.
fn change_body(world: &mut World, id: BodyId, (what, v, x): (u8, [f32; 3], f32)) {
    let Some(mut body) = world.body_mut(id) else { return };
    let kinds = [BodyKind::Static, BodyKind::Kinematic, BodyKind::Dynamic];
    match what % 8 {
        0..=2 => drop(body.set_kind(kinds[usize::from(what % 8)])),
        3 => drop(body.set_mass(MassDef::Mass(100.0 * x))),
        4 => {
            let inertia = Sym3::diagonal(Vec3::from(v));
            drop(body.set_mass(MassDef::Exact { mass: x, center: Vec3::from(v) * 0.1, inertia }));
        }
        5 => body.set_enabled(x > 0.0),
        6 => body.sleep(),
        _ => drop(body.correct_state(Pose::at(v), v, [x; 3])),
    }
}

/// Changes a property of a shape.
fn change_shape(world: &mut World, id: ShapeId, (what, v, x): (u8, [f32; 3], f32)) {
    let Some(mut shape) = world.shape_mut(id) else { return };
    match what % 8 {
        0 => shape.set_filter(Filter { exclude: u64::from(x > 0.0), ..Filter::default() }),
        1 => drop(shape.set_sensor(x > 0.0)),
        2 => drop(shape.set_density(200.0 * x)),
        3 => drop(shape.set_local_pose(Pose::at(v))),
        4 => drop(shape.set_geometry(Shape::box_half(v))),
        5 => drop(shape.set_geometry(Shape::half_space(v, x))),
        6 => drop(shape.set_geometry(Shape::sphere(x))),
        _ => shape.set_enabled(x > 0.0),
    }
}

/// Changes a property of a joint.
fn change_joint(world: &mut World, id: JointId, (what, v, x): (u8, [f32; 3], f32)) {
    let Some(mut joint) = world.joint_mut(id) else { return };
    let axis = Axis::ALL[usize::from(what) % 6];
    match what % 5 {
        0 => drop(joint.set_anchors(v, [0.1; 3])),
        1 => drop(joint.axis(axis).map(|mut axis| axis.set_motion(JointMotion::Free))),
        2 => drop(joint.axis(axis).map(|mut axis| axis.set_limits(-x.abs(), x.abs()))),
        3 => joint.set_collide_connected(x > 0.0),
        _ => joint.set_enabled(x > 0.0),
    }
}

/// Makes a call; new objects go into `added`.
pub(crate) fn make(
    world: &mut World,
    known: &Known,
    added: &mut Known,
    (what, [a, b], v, x): Call,
) {
    let (first, second) = (pick(&known.bodies, a), pick(&known.bodies, b));
    let (Some(first), Some(second)) = (first, second) else { return };
    match what % 30 {
        0..=3 => added.bodies.extend(world.add_body(body_of(a, v, x))),
        4 => {
            let ball = JointDef::new(first, second, Ball::new()).with_anchors([0.5; 3], [0.0; 3]);
            let ball = if a % 2 == 0 { ball } else { ball.with_strength(3.0e4, 1.0e4) };
            added.joints.extend(world.add_joint(ball));
        }
        5 => {
            let drive = JointDrive::servo(x, JointSpring::new(100.0, 10.0), 50.0);
            let axes = Hinge::of(JointAxis::limited(-1.0, 1.0).with_drive(drive)).six_dof();
            let def = JointDef::new(first, second, axes).at(v).with_axis(Vec3::Z);
            added.joints.extend(world.add_joint(def));
        }
        6 => {
            world.remove_body(first);
        }
        7 => {
            if let Some(mut body) = world.body_mut(first) {
                body.apply_impulse(v);
                body.set_angular_velocity(v);
                body.set_lasting_force(v);
            }
        }
        8 => {
            if let Some(mut body) = world.body_mut(first) {
                body.set_pose(Pose::at(v));
            }
        }
        9 => {
            let shape = world.body(first).and_then(|body| body.shapes().next());
            match (shape, b % 2) {
                (Some(shape), 0) => {
                    world.remove_shape(shape);
                }
                _ => {
                    let _ = world.add_shape(first, shape_of(b, x).with_position(v));
                }
            }
        }
        10 => {
            let shape = world.body(first).and_then(|body| body.shapes().next());
            if let Some(mut shape) = shape.and_then(|shape| world.shape_mut(shape)) {
                let _ = shape.set_material(Material { restitution: x, ..Material::default() });
                shape.set_surface_velocity(v);
            }
        }
        11 => {
            let kind = if a % 2 == 0 { LinkKind::Equal } else { LinkKind::AtMost };
            let to = [v[0], v[1] + 2.0, v[2]];
            let rope = RopeDef { kind, ..RopeDef::between(v, to, 3) };
            let Ok(rope) = world.add_rope(rope) else { return };
            let _ = world.particle_mut(rope.particles[0]).expect("there").attach(second, [0.0; 3]);
            added.particles.extend(rope.particles);
            added.links.extend(rope.links);
        }
        12 => {
            if let Some(particle) = pick(&known.particles, a) {
                if b % 3 == 0 {
                    world.remove_particle(particle);
                } else if let Some(mut particle) = world.particle_mut(particle) {
                    if b % 3 == 1 {
                        particle.detach();
                    } else {
                        let _ = particle.attach(first, v);
                    }
                }
            }
        }
        13 => {
            if let Some(link) = pick(&known.links, a) {
                world.remove_link(link);
            }
        }
        14 => {
            if let Some(joint) = pick(&known.joints, a) {
                world.remove_joint(joint);
            }
        }
        15 => {
            let method =
                Method::named(Method::NAMES[usize::from(a) % Method::NAMES.len()]).unwrap();
            let config = WorldConfig { method, ..world.config().clone() };
            let _ = world.set_config(config);
        }
        16..=18 => change_body(world, first, (b, v, x)),
        19..=21 => {
            let shape = world.body(first).and_then(|body| body.shapes().next());
            if let Some(shape) = shape {
                change_shape(world, shape, (b, v, x));
            }
        }
        22..=23 => {
            if let Some(joint) = pick(&known.joints, a) {
                change_joint(world, joint, (b, v, x));
            }
        }
        _ => (0..a % 24).for_each(|_| world.step(DT)),
    }
}

proptest! {
    // The same calls in every run, in debug and release.
    #![proptest_config(Config { cases: 200, rng_seed: RngSeed::Fixed(1), ..Config::default() })]
    #[test]
    fn after_any_calls_the_world_can_be_saved_and_its_twin_does_as_it_does(
        calls in prop::collection::vec(call(), 1..70),
        at in 0_usize..40,
    ) {
        let (mut world, mut known) = ground();
        let mut twin = None;
        for (i, call) in calls.into_iter().enumerate() {
            if i == at {
                twin = Some(world.clone());
            }
            let mut added = Known::default();
            make(&mut world, &known, &mut added, call);
            if let Some(twin) = &mut twin {
                // Saved and restored after every call.
                *twin = World::restore(&twin.snapshot()).unwrap();
                let mut same = Known::default();
                make(twin, &known, &mut same, call);
                assert_eq!(same.bodies, added.bodies);
                assert_eq!(twin.state_hash(), world.state_hash(), "after {call:?}");
                assert_eq!(twin.events(), world.events());
            }
            let bytes = world.snapshot();
            let again = World::restore(&bytes).unwrap_or_else(|e| panic!("after {call:?}: {e}"));
            assert!(again.snapshot() == bytes, "after {call:?}");
            known.learn(added, &world);
        }
    }
}
