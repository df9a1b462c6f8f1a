//! Glued bodies separate where the stress exceeds the strength of bonds, and keep their momentum.

use std::sync::Arc;

use drystone::breakage::{Bond, BondStrength, Glue};
use drystone::events::FractureCause;
use drystone::joint::Ball;
use drystone::math::Sym3;
use drystone::threads::{SimdLevel, Team};
use drystone::{
    BodyDef, BodyId, DefErrorKind, JointDef, MassDef, Pose, Quat, ShapeDef, Vec3, World,
    WorldConfig, vec3,
};

const DT: f32 = 1.0 / 60.0;

fn weightless() -> World {
    World::new(WorldConfig { gravity: Vec3::ZERO, ..WorldConfig::default() }).unwrap()
}

/// `n` cubes of edge 1 m in a row along x, with the first at the origin, 1000 kg each.
fn rod(n: u8, strength: BondStrength) -> BodyDef {
    let cube = |i: u8| ShapeDef::box_full([1.0; 3]).with_position(vec3(f32::from(i), 0.0, 0.0));
    let shapes: Vec<ShapeDef> = (0..n).map(cube).collect();
    let glue = Glue::touching(&shapes, 1.0e-3, strength).unwrap();
    assert_eq!(glue.bonds.len(), usize::from(n) - 1);
    BodyDef { shapes, glue: Some(glue), ..BodyDef::default() }
}

/// Momentum, angular momentum about the origin, and kinetic energy of all dynamic bodies.
fn motion(world: &World) -> (Vec3, Vec3, f64) {
    let (mut p, mut l) = (Vec3::ZERO, Vec3::ZERO);
    for b in world.bodies() {
        let own = b.linear_velocity() * b.mass();
        p += own;
        l += b.center_of_mass().cross(own) + b.inertia().mul(b.angular_velocity());
    }
    (p, l, world.kinetic_energy())
}

#[test]
fn a_spinning_rod_breaks_in_its_middle_when_the_pull_of_its_halves_is_too_much() {
    // Half of four cubes pulls with m ω² r = 2000 · ω² · 1 on 1 m².
    for (spin, breaks) in [(3.1_f32, false), (3.2, true)] {
        let mut world = weightless();
        let strength = BondStrength { tension: 2000.0 * 3.15 * 3.15, shear: f32::INFINITY };
        let def = BodyDef {
            linear_velocity: vec3(5.0, 1.0, -2.0),
            angular_velocity: vec3(0.0, spin, 0.0),
            ..rod(4, strength)
        };
        let body = world.add_body(def).unwrap();
        let before = motion(&world);
        for _ in 0..10 {
            world.step(DT);
        }
        let after = motion(&world);
        let size = before.0.length() * 4.0 + before.1.length();
        assert!((after.0 - before.0).length() < 1e-5 * before.0.length(), "{before:?} {after:?}");
        assert!((after.1 - before.1).length() < 1e-5 * size, "{before:?} {after:?}");
        assert!((after.2 - before.2).abs() < 1e-5 * before.2);
        assert_eq!(world.bodies().count(), if breaks { 2 } else { 1 }, "{spin}");
        let all = world.bodies().map(|b| b.angular_velocity());
        for w in all {
            assert!((w - vec3(0.0, spin, 0.0)).length() < 1e-4, "{w:?}");
        }
        // Loads of the bonds: 1.5, 2 and 1.5 cube masses at their distances.
        if !breaks {
            let loads: Vec<f32> = world.body(body).unwrap().bonds().map(|b| b.load).collect();
            let middle = 3.1 * 3.1 / (3.15 * 3.15);
            assert!((loads[1] - middle).abs() < 1e-3, "{loads:?}");
            assert!((loads[0] - 0.75 * middle).abs() < 1e-3, "{loads:?}");
            assert!((loads[2] - 0.75 * middle).abs() < 1e-3, "{loads:?}");
        }
    }
}

#[test]
fn each_part_has_its_own_mass_place_inertia_and_the_velocity_of_its_matter() {
    let mut world = weightless();
    let mut def = rod(5, BondStrength::both(f32::INFINITY));
    for (shape, density) in def.shapes.iter_mut().zip([500.0, 1000.0, 7000.0, 100.0, 2500.0]) {
        shape.density = density;
        shape.material.friction = density / 1.0e4;
        shape.user_data = 7;
    }
    let glue = def.glue.as_mut().unwrap();
    glue.bonds[1].strength = BondStrength { tension: 1.0, shear: 1.0 };
    let turn = Quat::from_axis_angle(vec3(1.0, 2.0, -1.0), 0.8);
    let def = BodyDef {
        position: vec3(3.0, -20.0, 8.0),
        rotation: turn,
        linear_velocity: vec3(1.0, 2.0, 3.0),
        angular_velocity: vec3(0.5, 1.0, 0.2),
        gravity_scale: 0.5,
        user_data: 42,
        mass: MassDef::Mass(222.0),
        ..def
    };
    let id = world.add_body(def).unwrap();
    let shapes: Vec<_> = world.body(id).unwrap().shapes().collect();
    let spin = |b: drystone::BodyRef<'_>| b.angular_velocity();
    let mut whole = world.clone();
    let unbreakable = BondStrength::both(f32::INFINITY);
    whole.body_mut(id).unwrap().set_bond_strength(unbreakable).unwrap();
    world.step(DT);
    whole.step(DT);
    let (a, b) = (motion(&whole), motion(&world));
    assert!((a.0 - b.0).length() < 1e-5 * a.0.length() && (a.2 - b.2).abs() < 1e-5 * a.2);
    assert!((a.1 - b.1).length() < 1e-5 * (a.1.length() + 20.0 * a.0.length()), "{a:?} {b:?}");

    let [event] = world.events().fractures[..] else { panic!("{:?}", world.events()) };
    assert_eq!((event.body, event.cause), (id, FractureCause::Glue));
    assert!(event.value > 1.0);
    let [broken] = world.events().bond_break[..] else { panic!("{:?}", world.events()) };
    assert_eq!(broken.shapes, [shapes[1], shapes[2]]);
    let [piece] = world.events().pieces_of(&event)[..] else { panic!("{event:?}") };
    // The heavy end remains the body; shapes keep their ids and settings.
    let old = whole.body(id).unwrap();
    let parts = [(id, &shapes[2..], 9600.0), (piece, &shapes[..2], 1500.0)];
    for (part, own, density) in parts {
        let body = world.body(part).unwrap();
        assert_eq!(body.shapes().collect::<Vec<_>>(), own);
        assert!((body.mass() - 222.0 * density / 11_100.0).abs() < 1e-3, "{}", body.mass());
        let v = old.velocity_at(body.center_of_mass());
        assert!((body.linear_velocity() - v).length() < 1e-5);
        assert!((spin(body) - spin(old)).length() < 1e-6);
        assert_eq!(body.user_data(), 42);
        for id in own {
            let (now, then) = (world.shape(*id).unwrap(), whole.shape(*id).unwrap());
            assert_eq!(now.body(), part);
            assert_eq!((now.material(), now.user_data()), (then.material(), 7));
            assert!((now.pose().position - then.pose().position).length() < 1e-5);
        }
    }
    // Its inertia is that of two cubes side by side.
    let light = world.body(piece).unwrap();
    let scale = 222.0 / 11_100.0;
    let along = scale * 1500.0 / 6.0;
    let reduced = 500.0 * 1000.0 / 1500.0;
    let across = along + scale * reduced;
    let (moments, _) = light.inertia().eigen();
    let mut found = moments.to_array();
    found.sort_by(f32::total_cmp);
    for (found, expected) in found.into_iter().zip([along, across, across]) {
        assert!((found - expected).abs() < 1e-4 * expected, "{found} {expected}");
    }
    assert_eq!(world.body(id).unwrap().bonds().count(), 2);
}

/// A rod on two blocks at its ends, with a load on its middle: three-point bending.
fn beam(strength: BondStrength) -> (World, BodyId) {
    let mut world = World::default();
    for x in [0.0, 4.0] {
        // A line of support without friction. Otherwise the supports would hold the beam together
        // like the feet of an arch.
        let turn = Quat::from_axis_angle(Vec3::X, core::f32::consts::FRAC_PI_2);
        let block = BodyDef::fixed().with_position([x, -0.6, 0.0]).with_rotation(turn);
        world.add_body(block.with_shape(ShapeDef::capsule(1.0, 0.1).with_friction(0.0))).unwrap();
    }
    let body = world.add_body(rod(5, strength)).unwrap();
    (world, body)
}

#[test]
fn a_beam_on_two_supports_bears_the_moment_of_its_weight_and_breaks_beyond() {
    // 5 m of q = 9810 N/m on supports 4 m apart. At the faces beside the middle, 1.5 m from a
    // support and 2 m from an end, M = R 1.5 - q 2²/2 = 24525 · 1.5 - 19620 = 17168 N m: σ = 6 M /
    // 1 m³.
    let expected = 6.0 * 17_167.5_f32;
    let (mut world, body) = beam(BondStrength::both(1.0e9));
    for _ in 0..120 {
        world.step(DT);
    }
    let loads: Vec<f32> = world.body(body).unwrap().bonds().map(|b| b.load * 1.0e9).collect();
    for middle in [loads[1], loads[2]] {
        assert!((middle - expected).abs() < 0.02 * expected, "{loads:?} {expected}");
    }
    for (factor, parts) in [(0.9, 2), (1.1, 1)] {
        let (mut world, _) = beam(BondStrength { tension: 1.0e9, shear: 1.0e9 });
        for _ in 0..120 {
            world.step(DT);
        }
        let strength = BondStrength { tension: factor * expected, shear: 1.0e9 };
        let beam = world.bodies().find(|b| b.mass() > 0.0).unwrap().id();
        world.body_mut(beam).expect("there").set_bond_strength(strength).unwrap();
        for _ in 0..5 {
            world.step(DT);
        }
        let count = world.bodies().filter(|b| b.mass() > 0.0).count();
        assert!(if parts == 1 { count == 1 } else { count >= 2 }, "{factor} {count}");
    }
}

#[test]
fn a_rest_that_breaks_nothing_lets_a_glued_body_sleep_and_wake() {
    let mut world = World::default();
    world
        .add_body(BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], -0.5)))
        .unwrap();
    let body = world.add_body(rod(4, BondStrength::both(1.0e7))).unwrap();
    for _ in 0..120 {
        world.step(DT);
    }
    assert!(world.body(body).unwrap().is_asleep());
    assert_eq!(world.body(body).unwrap().bonds().count(), 3);
}

#[test]
fn a_joint_goes_with_the_part_that_it_holds() {
    // Hung from its left end, with 3 cubes below the first: too heavy for the first bond.
    let mut world = World::default();
    let hook = world.add_body(BodyDef::fixed()).unwrap();
    let tension = 2.5 * 9810.0;
    let down = Quat::from_axis_angle(Vec3::Z, -core::f32::consts::FRAC_PI_2);
    let def = BodyDef { rotation: down, ..rod(4, BondStrength { tension, shear: f32::INFINITY }) };
    let body = world.add_body(def).unwrap();
    let joint = JointDef::new(hook, body, Ball::new());
    let joint = world.add_joint(joint).unwrap();
    for _ in 0..120 {
        world.step(DT);
    }
    let held = world.joint(joint).unwrap();
    assert_eq!(world.bodies().filter(|b| b.mass() > 0.0).count(), 2);
    let hung = world.body(held.body_b()).unwrap();
    assert_ne!(held.body_b(), body, "the three others are heavier: they stay the body");
    assert!((hung.mass() - 1000.0).abs() < 0.1 && hung.center_of_mass().length() < 0.1, "{hung:?}");
    assert!(world.body(body).unwrap().center_of_mass().y < -10.0);
    assert!(held.error() < 1e-3);
}

/// A wall of 10 × 10 glued bricks on the ground, and a ball of 4 t that flies into it.
fn wall(strength: f32) -> (World, BodyId) {
    let mut world = World::default();
    let ground = ShapeDef::half_space([0.0, 1.0, 0.0], 0.0);
    world.add_body(BodyDef::fixed().with_shape(ground)).unwrap();
    let half = vec3(0.25, 0.15, 0.125);
    let mut shapes = Vec::new();
    for row in 0..10_u8 {
        for i in 0..10_u8 {
            let x = 0.5 * (f32::from(i) - 4.5) + if row % 2 == 1 { 0.125 } else { -0.125 };
            let at = vec3(x, 0.3 * f32::from(row) + 0.15, 0.0);
            shapes.push(ShapeDef::box_half(half).with_position(at).with_density(2000.0));
        }
    }
    let glue = Glue::touching(&shapes, 1.0e-3, BondStrength::both(strength)).unwrap();
    let wall = BodyDef { shapes, glue: Some(glue), ..BodyDef::default() };
    let wall = world.add_body(wall).unwrap();
    let ball = BodyDef::dynamic()
        .with_position([0.3, 1.7, 2.0])
        .with_linear_velocity([0.0, 0.0, -10.0])
        .with_mass(4000.0)
        .with_shape(ShapeDef::sphere(0.5));
    world.add_body(ball).unwrap();
    (world, wall)
}

#[test]
fn a_ball_breaks_a_wall_of_a_hundred_pieces_without_an_explosion_the_same_for_any_threads() {
    let mut hashes = Vec::new();
    for (threads, level) in [(1, None), (3, None), (1, Some(SimdLevel::available()[0]))] {
        let (mut world, wall) = wall(2.0e5);
        if threads > 1 {
            world.set_executor(Arc::new(Team::new(threads)));
        }
        if let Some(level) = level {
            world.set_simd_level(level);
        }
        let mut splits = 0;
        for _ in 0..120 {
            // The step as it would be without breaking bonds: its end is the moment before the
            // splits.
            let mut whole = world.clone();
            let glued: Vec<BodyId> =
                whole.bodies().filter(|b| b.bonds().next().is_some()).map(|b| b.id()).collect();
            for id in glued {
                whole
                    .body_mut(id)
                    .expect("there")
                    .set_bond_strength(BondStrength::both(f32::INFINITY))
                    .unwrap();
            }
            world.step(DT);
            let fastest = world.bodies().map(|b| b.linear_velocity().length()).fold(0.0, f32::max);
            assert!(fastest < 12.0, "{fastest} m/s, the ball brought 10");
            if world.events().fractures.is_empty() {
                continue;
            }
            splits += world.events().fractures.len();
            whole.step(DT);
            assert!(whole.events().fractures.is_empty());
            let (a, b) = (motion(&whole), motion(&world));
            let size = a.0.length().max(1000.0);
            assert!((a.0 - b.0).length() < 1e-5 * size, "{a:?} {b:?}");
            assert!((a.1 - b.1).length() < 1e-5 * 3.0 * size, "{a:?} {b:?}");
            assert!(b.2 <= a.2 * (1.0 + 1e-5), "{a:?} {b:?}");
        }
        assert!(splits > 0 && world.bodies().count() > 10, "{splits} {}", world.bodies().count());
        assert!(world.body(wall).is_some());
        let mass: f32 = world.bodies().map(|b| b.mass()).sum();
        assert!((mass - 4000.0 - 100.0 * 75.0).abs() < 0.1, "{mass}");
        hashes.push(world.state_hash());
    }
    assert_eq!(hashes[0], hashes[1]);
    assert_eq!(hashes[0], hashes[2]);
    // The wall stands if nothing hits it.
    let (mut world, wall) = wall(2.0e5);
    let ball = world.bodies().last().unwrap().id();
    world.remove_body(ball);
    for _ in 0..120 {
        world.step(DT);
    }
    assert_eq!(world.body(wall).unwrap().shapes().count(), 100);
}

#[test]
fn glue_that_makes_no_sense_is_refused_by_name() {
    let cubes: Vec<ShapeDef> = rod(3, BondStrength::both(1.0)).shapes;
    let refused = |change: &dyn Fn(&mut BodyDef)| {
        let mut def = rod(3, BondStrength::both(1.0));
        change(&mut def);
        World::default().add_body(def).unwrap_err().field().to_owned()
    };
    let bond = |change: &dyn Fn(&mut Bond)| {
        refused(&|def| change(&mut def.glue.as_mut().unwrap().bonds[1]))
    };
    assert_eq!(bond(&|b| b.area = 0.0), "glue.bonds[1].area");
    assert_eq!(bond(&|b| b.area = f32::NAN), "glue.bonds[1].area");
    assert_eq!(bond(&|b| b.shapes[0] = 3), "glue.bonds[1].shapes[0]");
    assert_eq!(bond(&|b| b.shapes[1] = 1), "glue.bonds[1].shapes[1]");
    assert_eq!(bond(&|b| b.normal = Vec3::ZERO), "glue.bonds[1].normal");
    assert_eq!(bond(&|b| b.point = vec3(f32::INFINITY, 0.0, 0.0)), "glue.bonds[1].point");
    assert_eq!(bond(&|b| b.strength.tension = -1.0), "glue.bonds[1].strength.tension");
    assert_eq!(bond(&|b| b.strength.shear = f32::NAN), "glue.bonds[1].strength.shear");
    assert_eq!(refused(&|d| d.glue.as_mut().unwrap().bonds.truncate(1)), "glue.bonds");
    assert_eq!(refused(&|d| d.glue.as_mut().unwrap().bonds.clear()), "glue.bonds");
    assert_eq!(refused(&|d| d.kind = drystone::BodyKind::Static), "glue.body");
    assert_eq!(refused(&|d| d.shapes[2].density = 0.0), "glue.density");
    let exact =
        MassDef::Exact { mass: 1.0, center: Vec3::ZERO, inertia: Sym3::diagonal(Vec3::ONE) };
    assert_eq!(refused(&|d| d.mass = exact), "glue.mass");
    let strength = BondStrength::both(1.0);
    assert_eq!(Glue::touching(&cubes, -1.0, strength).unwrap_err().field(), "gap");
    let none = Glue::touching(&cubes, 1e-3, BondStrength::both(0.0)).unwrap_err();
    assert_eq!(none.field(), "tension");
    // Shapes that are added and removed.
    let mut world = World::default();
    let id = world.add_body(rod(3, BondStrength::both(1.0e6))).unwrap();
    let shapes: Vec<_> = world.body(id).unwrap().shapes().collect();
    world.add_shape(id, ShapeDef::sphere(0.3).with_pose(Pose::at([0.0, 3.0, 0.0]))).unwrap();
    world.step(DT);
    assert_eq!(world.bodies().count(), 1);
    assert!(world.remove_shape(shapes[1]));
    world.step(DT);
    assert_eq!(world.bodies().count(), 2, "what nothing holds any more comes apart");
    let loose = world.bodies().last().unwrap().id();
    let refused = world.body_mut(loose).unwrap().set_bond_strength(strength).unwrap_err();
    assert_eq!(refused.kind(), DefErrorKind::Unsuitable);
}
