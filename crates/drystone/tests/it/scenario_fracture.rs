//! Bodies that break at an impact.

use std::sync::Arc;

use drystone::breakage::Fracture;
use drystone::events::FractureCause;
use drystone::joint::Ball;
use drystone::math::Sym3;
use drystone::threads::Team;
use drystone::{
    BodyDef, BodyId, BodyKind, Hull, JointDef, MassDef, Shape, ShapeDef, Vec3, World, WorldConfig,
    vec3,
};

const DT: f32 = 1.0 / 60.0;

fn ground(world: &mut World) {
    let shape = ShapeDef::half_space([0.0, 1.0, 0.0], 0.0);
    world.add_body(BodyDef::fixed().with_shape(shape)).unwrap();
}

fn cube(edge: f32) -> BodyDef {
    BodyDef::dynamic().with_shape(ShapeDef::box_full([edge; 3]))
}

/// Mass, momentum, angular momentum about the origin, and kinetic energy of all dynamic bodies.
fn motion(world: &World) -> (f32, Vec3, Vec3, f64) {
    let (mut m, mut p, mut l) = (0.0, Vec3::ZERO, Vec3::ZERO);
    for b in world.bodies() {
        let own = b.linear_velocity() * b.mass();
        m += b.mass();
        p += own;
        l += b.center_of_mass().cross(own) + b.inertia().mul(b.angular_velocity());
    }
    (m, p, l, world.kinetic_energy())
}

#[test]
fn pieces_have_the_mass_momentum_spin_and_energy_of_the_body_together() {
    let points: Vec<Vec3> = (0..40_u8)
        .map(|i| {
            let t = f32::from(i);
            vec3((t * 1.7) % 2.0 - 1.0, (t * 0.93) % 1.3, (t * 2.31) % 0.9)
        })
        .collect();
    let hull = Shape::Hull(Arc::new(Hull::from_points(&points).unwrap()));
    for (shape, mass) in [
        (ShapeDef::box_full([1.0, 0.2, 3.0]), MassDef::FromShapes),
        (ShapeDef::new(hull.clone()).with_density(300.0), MassDef::FromShapes),
        (ShapeDef::new(hull).with_position([0.4, -2.0, 0.3]), MassDef::Mass(70.0)),
    ] {
        for pieces in [2, 7, 60, 300] {
            let mut world = World::default();
            let def = BodyDef {
                position: vec3(2.0, 5.0, -3.0),
                rotation: drystone::Quat::from_axis_angle(vec3(1.0, 1.0, 3.0), 1.1),
                linear_velocity: vec3(4.0, -1.0, 2.0),
                angular_velocity: vec3(0.3, 2.0, -1.0),
                mass,
                ..BodyDef::dynamic().with_shape(shape.clone())
            };
            let id = world.add_body(def).unwrap();
            let before = motion(&world);
            let at = world.body(id).unwrap().position();
            let how = Fracture { min_size: 0.01, ..Fracture::default() }.with_pieces(pieces);
            let made = world.body_mut(id).expect("there").break_at(at, &how).unwrap();
            assert!(made.len() >= 2 && made.len() <= pieces as usize, "{}", made.len());
            assert!(pieces > 60 || made.len() * 2 > pieces as usize, "{} of {pieces}", made.len());
            assert!(world.body(id).is_none());
            let after = motion(&world);
            let close = |a: Vec3, b: Vec3, size: f32| (a - b).length() < 1e-5 * size;
            assert!((before.0 - after.0).abs() < 1e-5 * before.0, "{before:?} {after:?}");
            assert!(close(before.1, after.1, before.1.length()), "{before:?} {after:?}");
            let arm = 6.0;
            assert!(close(before.2, after.2, arm * before.1.length()), "{before:?} {after:?}");
            assert!((before.3 - after.3).abs() < 1e-5 * before.3, "{before:?} {after:?}");
        }
    }
}

/// A cube of 1 t whose underside falls by `height` [m].
fn dropped(how: Fracture, height: f32) -> (World, BodyId) {
    let mut world = World::default();
    ground(&mut world);
    let def = cube(1.0).with_position([0.0, 0.5 + height, 0.0]).with_fracture(how);
    let id = world.add_body(def).unwrap();
    (world, id)
}

/// Steps until a body breaks; returns the event and the pieces.
fn breaks(world: &mut World, steps: u32) -> Option<(drystone::events::FractureEvent, Vec<BodyId>)> {
    for _ in 0..steps {
        world.step(DT);
        if let [event] = world.events().fractures[..] {
            return Some((event, world.events().pieces_of(&event).to_vec()));
        }
    }
    None
}

#[test]
fn a_body_breaks_under_a_blow_of_more_impulse_or_energy_than_its_limit_and_not_under_less() {
    // From 2 m: 6.26 m/s, 6264 N s, 19620 J. In the step of the impact gravity adds at most 164 N
    // s, and the ground's softness a little.
    let height = 2.0_f32;
    let speed = (2.0 * 9.81 * height).sqrt();
    let (impulse, energy) = (1000.0 * speed, 9810.0 * height);
    for (how, cause) in [
        (Fracture::by_impulse(0.95 * impulse), Some(FractureCause::Impulse)),
        (Fracture::by_impulse(1.1 * impulse), None),
        (Fracture::by_energy(0.9 * energy), Some(FractureCause::Energy)),
        (Fracture::by_energy(1.2 * energy), None),
    ] {
        let (mut world, id) = dropped(how, height);
        let found = breaks(&mut world, 120);
        assert_eq!(found.as_ref().map(|(e, _)| e.cause), cause, "{how:?} {found:?}");
        assert_eq!(world.body(id).is_none(), cause.is_some());
        let Some((event, pieces)) = found else { continue };
        assert_eq!(event.body, id);
        assert!(event.point.y.abs() < 0.1 && event.value > event.limit, "{event:?}");
        assert!(pieces.len() > 6, "{}", pieces.len());
        for id in pieces {
            assert!(world.body(id).unwrap().fracture().is_none(), "pieces do not break again");
        }
        // No explosion: no piece is faster than the cube was, and all come to rest.
        for _ in 0..300 {
            world.step(DT);
            for body in world.bodies() {
                assert!(body.linear_velocity().length() < speed, "{body:?}");
            }
        }
        assert!((motion(&world).0 - 1000.0).abs() < 0.01);
    }
}

#[test]
fn a_blow_counts_in_whichever_substep_it_comes_and_with_restitution() {
    // It bounces with e = 1/2: 1.5 m v. Slightly different heights shift the impact through all
    // substeps.
    for k in 0..12_u8 {
        let height = 1.0 + 0.02 * f32::from(k);
        let speed = (2.0 * 9.81 * height).sqrt();
        for (restitution, factor) in [(0.0, 1.0), (0.5, 1.5)] {
            let mut world = World::default();
            ground(&mut world);
            let shape = ShapeDef::box_full([1.0; 3]).with_restitution(restitution);
            let how = Fracture::by_impulse(0.9 * factor * 1000.0 * speed);
            let def = BodyDef::dynamic().with_shape(shape).with_fracture(how);
            world.add_body(def.with_position([0.0, 0.5 + height, 0.0])).unwrap();
            let (event, _) = breaks(&mut world, 120).unwrap();
            let ratio = event.value / (factor * 1000.0 * speed);
            assert!((0.93..1.07).contains(&ratio), "{height} {restitution}: {ratio}");
        }
    }
}

#[test]
fn pieces_are_smaller_near_the_hit() {
    let mut world = World::default();
    let id = world.add_body(cube(2.0)).unwrap();
    let how = Fracture { pieces: 100, focus: 2, ..Fracture::default() };
    let hit = vec3(1.0, 0.0, 0.0);
    let pieces = world.body_mut(id).expect("there").break_at(hit, &how).unwrap();
    let (mut near, mut far) = (Vec::new(), Vec::new());
    for id in pieces {
        let body = world.body(id).unwrap();
        let list = if (body.position() - hit).length() < 0.5 { &mut near } else { &mut far };
        list.push(body.mass());
    }
    let mean =
        |list: &[f32]| list.iter().sum::<f32>() / f32::from(u8::try_from(list.len()).unwrap());
    assert!(near.len() > 30 && mean(&far) > 5.0 * mean(&near), "{near:?} {far:?}");
}

#[test]
fn pieces_break_again_as_often_as_said_and_limits_of_size_and_number_hold() {
    // It breaks high above the ground, so that its pieces fall on it.
    let how = Fracture { generations: 3, min_size: 0.15, ..Fracture::by_energy(500.0) };
    let (mut world, id) = dropped(how, 5.0);
    let first = world.body_mut(id).expect("there").break_at(vec3(0.0, 5.0, 0.0), &how).unwrap();
    assert_eq!(world.body(first[0]).unwrap().fracture().unwrap().generations, 2);
    let mut events = 0;
    for _ in 0..400 {
        world.step(DT);
        events += world.events().fractures.len();
    }
    assert!(events > 1, "{events}");
    for body in world.bodies().filter(|b| b.kind() == BodyKind::Dynamic) {
        assert!(body.mass() >= 1000.0 * 0.15 * 0.15 * 0.15 * 0.999, "{}", body.mass());
    }
    assert!((motion(&world).0 - 1000.0).abs() < 0.01);

    // The world has a limit on pieces: at the limit a body breaks into fewer pieces, and then not
    // at all.
    let mut world = World::default();
    let mut config = WorldConfig::default();
    config.breakage.max_pieces = 20;
    world.set_config(config).unwrap();
    let how = Fracture::default().with_pieces(12);
    let ids: Vec<BodyId> = (0..3_u8)
        .map(|i| world.add_body(cube(1.0).with_position([5.0 * f32::from(i), 0.0, 0.0])).unwrap())
        .collect();
    let counts: Vec<usize> = ids
        .iter()
        .map(|id| world.body_mut(*id).expect("there").break_at(Vec3::ZERO, &how).unwrap().len())
        .collect();
    assert!(counts[0] > 8 && counts[1] >= 2 && counts.iter().sum::<usize>() <= 20, "{counts:?}");
    assert!(world.body(ids[2]).is_some() || counts[2] > 0);
    // Removed pieces make room for new ones.
    let pieces: Vec<BodyId> = world.bodies().map(|b| b.id()).filter(|id| *id != ids[2]).collect();
    for id in pieces {
        world.remove_body(id);
    }
    if world.body(ids[2]).is_some() {
        assert!(world.body_mut(ids[2]).unwrap().break_at(Vec3::ZERO, &how).unwrap().len() > 8);
    }
    // Too small to break.
    let small = world.add_body(cube(0.02)).unwrap();
    assert!(world.body_mut(small).expect("there").break_at(Vec3::ZERO, &how).unwrap().is_empty());
    assert!(world.body(small).is_some());
}

#[test]
fn a_seed_breaks_alike_for_any_threads_and_clones_break_alike() {
    let run = |threads: usize, seed: u64| {
        let how = Fracture { generations: 2, seed, ..Fracture::by_energy(1000.0) };
        let (mut world, _) = dropped(how.with_pieces(40), 3.0);
        for i in 0..10_u8 {
            let at = vec3(2.0 * f32::from(i), 3.0 + 0.1 * f32::from(i), 5.0);
            world.add_body(cube(1.0).with_position(at).with_fracture(how)).unwrap();
        }
        if threads > 1 {
            world.set_executor(Arc::new(Team::new(threads)));
        }
        for _ in 0..30 {
            world.step(DT);
        }
        let mut clone = world.clone();
        for _ in 0..90 {
            world.step(DT);
            clone.step(DT);
            assert_eq!(world.events(), clone.events());
        }
        assert_eq!(world.state_hash(), clone.state_hash());
        assert!(world.bodies().count() > 100);
        world.state_hash()
    };
    assert_eq!(run(1, 5), run(4, 5));
    assert_ne!(run(1, 5), run(1, 6));
}

#[test]
fn a_joint_holds_the_piece_that_it_was_fastened_to() {
    let mut world = World::default();
    let hook = world.add_body(BodyDef::fixed().with_position([0.0, 5.0, 0.0])).unwrap();
    let body = world.add_body(cube(1.0).with_position([0.0, 4.5, 0.0])).unwrap();
    let joint = world
        .add_joint(
            JointDef::new(hook, body, Ball::new()).with_anchors(Vec3::ZERO, vec3(0.0, 0.5, 0.0)),
        )
        .unwrap();
    world.step(DT);
    let pieces = world
        .body_mut(body)
        .expect("there")
        .break_at(vec3(0.5, 4.5, 0.0), &Fracture::default())
        .unwrap();
    let held = world.joint(joint).unwrap().body_b();
    assert!(pieces.contains(&held));
    for _ in 0..120 {
        world.step(DT);
    }
    assert!(world.joint(joint).unwrap().error() < 1e-3);
    for id in pieces {
        let y = world.body(id).unwrap().position().y;
        assert!(if id == held { y > 3.5 } else { y < 0.0 }, "{y}");
    }
}

#[test]
fn a_hull_can_be_cut_beforehand_and_glued() {
    let hull = Hull::from_points(&[
        vec3(0.0, 0.0, 0.0),
        vec3(2.0, 0.0, 0.0),
        vec3(0.0, 2.0, 0.0),
        vec3(0.0, 0.0, 2.0),
    ])
    .unwrap();
    let sites: Vec<Vec3> =
        (0..20_u8).map(|i| vec3(0.07 * f32::from(i), 0.3 + 0.01 * f32::from(i), 0.4)).collect();
    let pieces = hull.cut(&sites, 0.0).unwrap();
    let shapes: Vec<ShapeDef> = pieces
        .iter()
        .map(|p| ShapeDef::new(Shape::Hull(p.hull.clone())).with_position(p.center))
        .collect();
    let strength = drystone::breakage::BondStrength::both(1.0e5);
    let glue = drystone::breakage::Glue::touching(&shapes, 1.0e-4, strength).unwrap();
    assert!(glue.bonds.len() >= pieces.len() - 1);
    let mut world = World::default();
    let id = world.add_body(BodyDef { shapes, glue: Some(glue), ..BodyDef::default() }).unwrap();
    let mass = world.body(id).unwrap().mass();
    assert!((mass - 1000.0 * hull.volume()).abs() < 1e-5 * mass);
}

#[test]
fn fractures_that_make_no_sense_are_refused_by_name() {
    let refused = |change: &dyn Fn(&mut BodyDef)| {
        let mut def = cube(1.0).with_fracture(Fracture::default());
        change(&mut def);
        World::default().add_body(def).unwrap_err().field().to_owned()
    };
    let how =
        |change: &dyn Fn(&mut Fracture)| refused(&|def| change(def.fracture.as_mut().unwrap()));
    assert_eq!(how(&|f| f.impulse = 0.0), "fracture.impulse");
    assert_eq!(how(&|f| f.impulse = f32::NAN), "fracture.impulse");
    assert_eq!(how(&|f| f.energy = -1.0), "fracture.energy");
    assert_eq!(how(&|f| f.pieces = 0), "fracture.pieces");
    assert_eq!(how(&|f| f.pieces = 1_000_000_000), "fracture.pieces");
    assert_eq!(how(&|f| f.min_size = 0.0), "fracture.min_size");
    assert_eq!(how(&|f| f.focus = 9), "fracture.focus");
    assert_eq!(how(&|f| f.generations = 0), "fracture.generations");
    assert_eq!(refused(&|d| d.kind = BodyKind::Static), "fracture.body");
    assert_eq!(refused(&|d| d.shapes[0] = ShapeDef::sphere(1.0)), "fracture");
    assert_eq!(refused(&|d| d.shapes.push(ShapeDef::box_full([1.0; 3]))), "fracture");
    assert_eq!(refused(&|d| d.shapes[0].density = 0.0), "fracture.density");
    let exact =
        MassDef::Exact { mass: 1.0, center: Vec3::ZERO, inertia: Sym3::diagonal(Vec3::ONE) };
    assert_eq!(refused(&|d| d.mass = exact), "fracture.mass");

    let mut world = World::default();
    let ball = world.add_body(BodyDef::dynamic().with_shape(ShapeDef::sphere(0.5))).unwrap();
    let block = world.add_body(cube(1.0)).unwrap();
    let any = Fracture::default();
    assert_eq!(
        world.body_mut(ball).expect("there").break_at(Vec3::ZERO, &any).unwrap_err().field(),
        "body"
    );
    assert_eq!(
        world.body_mut(ball).expect("there").set_fracture(Some(any)).unwrap_err().field(),
        "body"
    );
    let nowhere = vec3(f32::NAN, 0.0, 0.0);
    assert_eq!(
        world.body_mut(block).expect("there").break_at(nowhere, &any).unwrap_err().field(),
        "point"
    );
    world.body_mut(block).expect("there").set_fracture(Some(any)).unwrap();
    assert_eq!(world.body(block).unwrap().fracture(), Some(any));
    world.body_mut(block).expect("there").set_fracture(None).unwrap();
    assert_eq!(world.body(block).unwrap().fracture(), None);
    world.remove_body(block);
    assert!(world.body_mut(block).is_none());
    let nothing = Hull::from_points(&[Vec3::ZERO, Vec3::X, Vec3::Y, vec3(1.0, 1.0, 0.0)]);
    assert!(nothing.is_err(), "a flat hull is refused when it is made");
}
