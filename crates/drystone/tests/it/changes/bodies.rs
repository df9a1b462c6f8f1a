//! Changes to existing bodies.

use std::collections::BTreeSet;

use drystone::breakage::Fracture;
use drystone::joint::SixDof;
use drystone::math::Sym3;
use drystone::particle::RopeDef;
use drystone::{
    BodyDef, BodyId, BodyKind, DefError, Filter, JointDef, MassDef, Pose, ShapeDef, Vec3, World,
    vec3,
};

use super::{DT, FLOORS, Floor, GRAVITY, Stack, brittle, chain, floor, glued, in_all_states};

#[test]
fn bodies_change_in_any_state() {
    in_all_states(&[
        ("static", &[|w, b, _| w.body_mut(b).unwrap().set_kind(BodyKind::Static)]),
        ("kinematic", &[|w, b, _| w.body_mut(b).unwrap().set_kind(BodyKind::Kinematic)]),
        ("dynamic", &[|w, b, _| w.body_mut(b).unwrap().set_kind(BodyKind::Dynamic)]),
        (
            "static, then dynamic",
            &[
                |w, b, _| w.body_mut(b).unwrap().set_kind(BodyKind::Static),
                |w, b, _| w.body_mut(b).unwrap().set_kind(BodyKind::Dynamic),
            ],
        ),
        (
            "static and dynamic at once",
            &[|w, b, _| {
                w.body_mut(b).unwrap().set_kind(BodyKind::Static)?;
                w.body_mut(b).unwrap().set_kind(BodyKind::Dynamic)
            }],
        ),
        ("heavy", &[|w, b, _| w.body_mut(b).unwrap().set_mass(MassDef::Mass(1.0e5))]),
        ("light", &[|w, b, _| w.body_mut(b).unwrap().set_mass(MassDef::Mass(10.0))]),
        (
            "mass given in full",
            &[|w, b, _| {
                let inertia = Sym3::diagonal(vec3(100.0, 200.0, 150.0));
                let center = vec3(0.1, -0.2, 0.0);
                w.body_mut(b).unwrap().set_mass(MassDef::Exact { mass: 500.0, center, inertia })
            }],
        ),
        (
            "disabled",
            &[|w, b, _| {
                w.body_mut(b).unwrap().set_enabled(false);
                Ok(())
            }],
        ),
        (
            "disabled and back",
            &[|w, b, _| {
                w.body_mut(b).unwrap().set_enabled(false);
                w.body_mut(b).unwrap().set_enabled(true);
                Ok(())
            }],
        ),
        (
            "disabled, of another kind",
            &[|w, b, _| {
                w.body_mut(b).unwrap().set_enabled(false);
                w.body_mut(b).unwrap().set_kind(BodyKind::Kinematic)
            }],
        ),
        (
            "put to sleep",
            &[|w, b, _| {
                w.body_mut(b).unwrap().sleep();
                Ok(())
            }],
        ),
        (
            "corrected",
            &[|w, b, _| {
                let pose = w.body(b).unwrap().pose();
                let pose = Pose { position: pose.position + Vec3::X * 0.01, ..pose };
                w.body_mut(b).unwrap().correct_state(pose, [0.1, 0.0, 0.0], [0.0; 3]).map(|_| ())
            }],
        ),
        ("sleep speed", &[|w, b, _| w.body_mut(b).unwrap().set_sleep_speed(Some(0.5))]),
    ]);
}

#[test]
fn a_static_body_made_dynamic_carries_on_what_stands_on_it() {
    for under in FLOORS {
        for size in [0.05, 1.0, 20.0] {
            for sleeps in [false, true] {
                let mut stack = Stack::new(under, size, BodyKind::Static);
                stack = if sleeps { stack.asleep() } else { stack };
                let of = format!("{under:?}, {size} m, sleeps: {sleeps}");
                let mut body = stack.world.body_mut(stack.cubes[0]).unwrap();
                body.set_kind(BodyKind::Dynamic).unwrap();
                let mass = stack.world.body(stack.cubes[0]).unwrap().mass();
                assert_eq!(mass, stack.world.body(stack.cubes[1]).unwrap().mass(), "{of}");
                assert_eq!(stack.world.counts().asleep, 0, "{of}");
                // The contact with the floor is new, and gets the load of the cubes above.
                stack.stands(&of, 60, 0.01 * size);
                // The cube touches the floor now, and no other touch ended.
                assert!(stack.world.contacts().any(|c| c.body_a() == stack.floor), "{of}");
            }
        }
    }
}

#[test]
fn a_dynamic_body_made_static_keeps_what_leans_on_it() {
    for under in FLOORS {
        for kind in [BodyKind::Static, BodyKind::Kinematic] {
            let mut stack = Stack::new(under, 1.0, BodyKind::Dynamic);
            let id = stack.cubes[2];
            stack.world.body_mut(id).unwrap().set_kind(kind).unwrap();
            assert_eq!(stack.world.body(id).unwrap().mass(), 0.0);
            let of = format!("{under:?}, {kind:?}");
            for _ in 0..3 {
                stack.world.step(DT);
                let events = stack.world.events();
                assert!(events.contact_end.is_empty() && events.contact_begin.is_empty(), "{of}");
            }
            stack.stands(&of, 60, 0.01);
            // The body below can be removed.
            assert!(stack.world.remove_body(stack.cubes[0]));
            assert!(stack.world.remove_body(stack.cubes[1]));
            stack.cubes.drain(..2);
            stack.stands(&of, 60, 0.01);
            // It falls with the others once it is dynamic again.
            stack.world.body_mut(id).unwrap().set_kind(BodyKind::Dynamic).unwrap();
            let before = stack.places();
            stack.steps(20);
            // ½ g t² for 20 steps of 8 substeps each, and one substep more.
            let fall = 0.5 * GRAVITY * (20.0 * DT) * (20.0 * DT + DT / 8.0);
            for (a, b) in before.iter().zip(stack.places()) {
                assert!((a.y - b.y - fall).abs() < 0.02, "{of}: {} m, not {fall}", a.y - b.y);
            }
        }
    }
}

#[test]
fn a_floor_disabled_under_a_sleeping_stack_lets_it_fall_and_carries_again() {
    for under in FLOORS {
        let mut stack = Stack::new(under, 1.0, BodyKind::Dynamic).asleep();
        let before = stack.places();
        stack.world.body_mut(stack.floor).unwrap().set_enabled(false);
        assert!(!stack.world.body(stack.floor).unwrap().is_enabled());
        let hit =
            stack.world.query().cast_ray([5.0, 1.0, 0.0], [0.0, -9.0, 0.0], Filter::default());
        assert_eq!(hit.unwrap(), None);
        stack.world.step(DT);
        let events = stack.world.events();
        assert_eq!(events.wake, stack.cubes);
        assert_eq!(events.contact_end.len(), 1, "{under:?}");
        stack.steps(19);
        let fall = 0.5 * GRAVITY * (20.0 * DT) * (20.0 * DT + DT / 8.0);
        for (a, b) in before.iter().zip(stack.places()) {
            assert!((a.y - b.y - fall).abs() < 0.02, "{under:?}: {} m, not {fall}", a.y - b.y);
        }
        for (id, place) in stack.cubes.iter().zip(&before) {
            let pose = Pose { position: *place, ..stack.world.body(*id).unwrap().pose() };
            let mut body = stack.world.body_mut(*id).unwrap();
            body.correct_state(pose, [0.0; 3], [0.0; 3]).unwrap();
        }
        stack.world.body_mut(stack.floor).unwrap().set_enabled(true);
        stack.stands("enabled again", 60, 0.01);
    }
}

#[test]
fn what_is_disabled_stays_as_it_is_and_goes_on_when_it_is_enabled() {
    let mut world = World::default();
    let ball = BodyDef::dynamic()
        .with_position([0.0, 5.0, 0.0])
        .with_linear_velocity([2.0, 1.0, 0.0])
        .with_shape(ShapeDef::sphere(0.5));
    let ball = world.add_body(ball).unwrap();
    let wall = BodyDef::dynamic().with_position([0.0, 5.0, 0.0]);
    world.set_gravity([0.0; 3]);
    world.step(DT);
    let (pose, energy) = (world.body(ball).unwrap().pose(), world.kinetic_energy());
    world.body_mut(ball).unwrap().set_enabled(false);
    assert_eq!(world.kinetic_energy(), 0.0);
    assert_eq!(world.audit().momentum.mass, 0.0);
    // Another body may take its place meanwhile.
    let wall = world.add_body(wall.with_shape(ShapeDef::box_half([1.0; 3]))).unwrap();
    for _ in 0..30 {
        world.step(DT);
        assert!(world.events().contact_begin.is_empty() && world.events().wake.is_empty());
    }
    let body = world.body(ball).unwrap();
    assert_eq!((body.pose(), body.linear_velocity()), (pose, vec3(2.0, 1.0, 0.0)));
    assert!(!body.is_asleep() && !body.is_enabled() && !body.is_faulted());
    assert_eq!(world.body(wall).unwrap().linear_velocity(), Vec3::ZERO);
    // Forces only act on bodies in the world.
    world.body_mut(ball).unwrap().apply_impulse([1.0, 0.0, 0.0]);
    assert!(world.remove_body(wall));
    world.body_mut(ball).unwrap().set_enabled(true);
    assert_eq!(world.kinetic_energy(), energy);
    world.step(DT);
    assert!(world.events().wake.is_empty());
    let way = world.body(ball).unwrap().position() - pose.position;
    assert!((way - vec3(2.0, 1.0, 0.0) * DT).length() < 1.0e-5, "{way:?}");
}

#[test]
fn joints_of_what_is_disabled_are_idle_until_it_is_enabled() {
    let (mut world, middle) = chain();
    let bodies: Vec<BodyId> = world.bodies().map(|b| b.id()).collect();
    let (first, last) = (bodies[1], bodies[3]);
    for _ in 0..30 {
        world.step(DT);
    }
    world.body_mut(middle).unwrap().set_enabled(false);
    let place = world.body(last).unwrap().position();
    for _ in 0..20 {
        world.step(DT);
    }
    // The lowest ball falls freely, the first still hangs.
    let fallen = place.y - world.body(last).unwrap().position().y;
    let start = world.body(last).unwrap().linear_velocity().y;
    assert!(fallen > 0.3 && start < -GRAVITY * 18.0 * DT, "{fallen} m, {start} m/s");
    let held = |world: &World, of: BodyId| {
        let errors = world.joints().filter(|j| j.body_b() == of).map(|j| j.error());
        errors.fold(0.0, f32::max)
    };
    assert!(held(&world, first) < 0.01);
    world.body_mut(middle).unwrap().set_enabled(true);
    for _ in 0..300 {
        world.step(DT);
    }
    assert!([first, middle, last].iter().all(|id| held(&world, *id) < 0.01));
}

#[test]
fn ropes_fall_from_what_is_disabled_and_are_held_again() {
    for kind in [BodyKind::Static, BodyKind::Kinematic] {
        let mut world = World::default();
        floor(&mut world, Floor::Box, 1.0);
        let post = BodyDef { kind, ..BodyDef::default() }.with_position([0.0, 5.0, 0.0]);
        let post = world.add_body(post.with_shape(ShapeDef::sphere(0.1))).unwrap();
        let rope = world.add_rope(RopeDef::between([0.0, 5.0, 0.0], [0.0, 3.0, 0.0], 4)).unwrap();
        let top = rope.particles[0];
        assert!(world.particle_mut(top).expect("there").attach(post, [0.0; 3]).is_ok());
        let height = |world: &World| world.particle(top).unwrap().position().y;
        // Runs until it sleeps.
        let rest = |world: &mut World| (0..600).for_each(|_| world.step(DT));
        rest(&mut world);
        assert!(height(&world) > 4.9, "{kind:?}");
        world.body_mut(post).unwrap().set_enabled(false);
        rest(&mut world);
        assert!(height(&world) < 0.5, "{kind:?}: {} m", height(&world));
        assert!(world.particle(top).unwrap().is_asleep());
        world.body_mut(post).unwrap().set_enabled(true);
        rest(&mut world);
        assert!(height(&world) > 4.9, "{kind:?}: {} m", height(&world));
    }
}

#[test]
fn what_is_put_to_sleep_by_hand_sleeps_in_the_air_until_it_is_woken() {
    let mut world = World::default();
    let ball =
        |y: f32| BodyDef::dynamic().with_position([0.0, y, 0.0]).with_shape(ShapeDef::sphere(0.5));
    let (a, b) = (world.add_body(ball(5.0)).unwrap(), world.add_body(ball(9.0)).unwrap());
    for _ in 0..10 {
        world.step(DT);
    }
    world.body_mut(a).unwrap().set_can_sleep(false);
    world.body_mut(a).unwrap().sleep();
    let place = world.body(a).unwrap().position();
    assert!(world.body(a).unwrap().is_asleep());
    assert_eq!(world.body(a).unwrap().linear_velocity(), Vec3::ZERO);
    world.step(DT);
    assert_eq!(world.events().sleep, [a]);
    // The calls cancel, so the step reports no event.
    world.body_mut(a).unwrap().wake();
    world.body_mut(a).unwrap().sleep();
    world.step(DT);
    assert!(world.events().sleep.is_empty() && world.events().wake.is_empty());
    let mut woken = None;
    for step in 0..120 {
        assert!(woken.is_some() || world.body(a).unwrap().position() == place);
        world.step(DT);
        if world.events().wake == [a] {
            woken = woken.or(Some(step));
        }
    }
    // The other body starts 3 m above, and is already falling.
    assert!(woken.is_some_and(|step| step > 20 && step < 60), "{woken:?}");
    assert!(world.body(b).unwrap().position().y < 5.0);
}

#[test]
fn sleep_by_hand_is_that_of_all_that_is_connected_and_of_nothing_else() {
    let mut stack = Stack::new(Floor::Box, 1.0, BodyKind::Dynamic);
    let far = BodyDef::dynamic().with_position([8.0, 0.5, 0.0]);
    let far = stack.world.add_body(far.with_shape(ShapeDef::box_half([0.5; 3]))).unwrap();
    stack.steps(5);
    stack.world.body_mut(stack.cubes[3]).unwrap().sleep();
    stack.world.step(DT);
    let cubes: BTreeSet<BodyId> = stack.cubes.iter().copied().collect();
    let asleep = stack.world.bodies().filter(|b| b.is_asleep()).map(|b| b.id());
    assert_eq!(asleep.collect::<BTreeSet<_>>(), cubes);
    assert_eq!(stack.world.events().sleep.iter().copied().collect::<BTreeSet<_>>(), cubes);
    assert!(!stack.world.body(far).unwrap().is_asleep());
    stack.stands("asleep by hand", 10, 1.0e-6);
    stack.world.body_mut(stack.cubes[0]).unwrap().wake();
    stack.stands("woken", 30, 0.01);
}

#[test]
fn masses_change_under_load_and_come_back() {
    // Much heavier bodies are at the bottom, because a stack below a heavy body sags by solver
    // error.
    let all = [0.1, 10.0].into_iter().flat_map(|factor| [0, 2, 4].map(|cube| (factor, cube)));
    for (factor, cube) in all.chain([(1.0e3, 0), (1.0e-3, 4)]) {
        for under in FLOORS {
            let mut stack = Stack::new(under, 1.0, BodyKind::Dynamic);
            let id = stack.cubes[cube];
            let before = stack.world.body(id).unwrap();
            let (mass, inertia) = (before.mass(), before.inertia());
            let mut body = stack.world.body_mut(id).unwrap();
            body.set_mass(MassDef::Mass(factor * mass)).unwrap();
            let now = body.get();
            assert_eq!(now.mass(), factor * mass);
            let ratio = now.inertia().xx / inertia.xx;
            assert!((ratio / factor - 1.0).abs() < 1.0e-5, "{ratio}");
            let of = format!("{factor} times cube {cube} on {under:?}");
            let limit = stack.speed_of_new_loads();
            stack.is_no_faster(&of, 60, 0.05, limit);
            let mut body = stack.world.body_mut(id).unwrap();
            body.set_mass(MassDef::FromShapes).unwrap();
            assert_eq!(body.get().mass(), mass);
            assert_eq!(body.get().mass_def(), MassDef::FromShapes);
            stack.is_no_faster(&of, 60, 0.05, limit);
        }
    }
}

#[test]
fn a_mass_given_in_full_survives_other_kinds_and_keeps_the_motion_of_every_point() {
    let mut world = World::default();
    world.set_gravity([0.0; 3]);
    let rod = BodyDef::dynamic()
        .with_linear_velocity([1.0, 0.0, 0.0])
        .with_angular_velocity([0.0, 0.0, 2.0])
        .with_shape(ShapeDef::box_half([1.0, 0.1, 0.1]));
    let rod = world.add_body(rod).unwrap();
    let tip = world.body(rod).unwrap().velocity_at([1.0, 0.0, 0.0]);
    let inertia = Sym3::diagonal(vec3(1.0, 2.0, 3.0));
    let exact = MassDef::Exact { mass: 7.0, center: vec3(0.5, 0.0, 0.0), inertia };
    world.body_mut(rod).unwrap().set_mass(exact).unwrap();
    let body = world.body(rod).unwrap();
    assert!((body.velocity_at([1.0, 0.0, 0.0]) - tip).length() < 1.0e-6);
    assert_eq!((body.mass(), body.position()), (7.0, Vec3::ZERO));
    assert_eq!(body.center_of_mass(), vec3(0.5, 0.0, 0.0));
    let moments = body.inertia();
    for kind in [BodyKind::Static, BodyKind::Kinematic, BodyKind::Dynamic] {
        world.body_mut(rod).unwrap().set_kind(kind).unwrap();
        assert_eq!(world.body(rod).unwrap().mass_def(), exact);
        world = World::restore(&world.snapshot()).unwrap();
    }
    assert_eq!(
        (world.body(rod).unwrap().mass(), world.body(rod).unwrap().inertia()),
        (7.0, moments)
    );
}

#[test]
fn a_correction_that_changes_nothing_wakes_nothing() {
    let mut stack = Stack::new(Floor::Box, 1.0, BodyKind::Dynamic).asleep();
    let (hash, bytes) = (stack.world.state_hash(), stack.world.snapshot());
    let states = |world: &World| -> Vec<_> {
        let all = world.bodies();
        all.map(|b| (b.id(), b.pose(), b.linear_velocity(), b.angular_velocity())).collect()
    };
    for (id, pose, v, w) in states(&stack.world) {
        let mut body = stack.world.body_mut(id).unwrap();
        assert!(!body.correct_state(pose, v, w).unwrap());
    }
    assert!(stack.world.snapshot() == bytes);
    stack.world.step(DT);
    assert_eq!(stack.world.state_hash(), hash);
    // The same for an awake body in flight.
    let mut body = stack.world.body_mut(stack.cubes[4]).unwrap();
    body.apply_impulse([3000.0, 5000.0, 0.0]);
    body.apply_angular_impulse([100.0, 50.0, 20.0]);
    stack.steps(10);
    let mut twin = stack.world.clone();
    for (id, pose, v, w) in states(&stack.world) {
        assert!(!twin.body_mut(id).unwrap().correct_state(pose, v, w).unwrap());
    }
    twin.step(DT);
    stack.world.step(DT);
    assert_eq!(twin.state_hash(), stack.world.state_hash());
    // A real change is applied, and wakes the body.
    let mut stack = Stack::new(Floor::Box, 1.0, BodyKind::Dynamic).asleep();
    let (id, pose, v, w) = states(&stack.world)[5];
    let pose = Pose { position: pose.position + Vec3::Y * 1.0e-3, ..pose };
    assert!(stack.world.body_mut(id).unwrap().correct_state(pose, v, w).unwrap());
    assert_eq!(stack.world.counts().asleep, 0);
    assert_eq!(stack.world.body(id).unwrap().pose(), pose);
}

#[test]
fn what_breaks_breaks_only_while_it_is_dynamic() {
    let strike = |world: &mut World, at: [f32; 3], velocity: [f32; 3]| {
        let rock = BodyDef::dynamic().with_position(at).with_linear_velocity(velocity);
        let rock = rock.with_shape(ShapeDef::sphere(0.5).with_density(2.0e4));
        let rock = world.add_body(rock).unwrap();
        let mut pieces = 0;
        for _ in 0..30 {
            world.step(DT);
            pieces += world.events().pieces.len();
        }
        world.remove_body(rock);
        pieces
    };
    for (scene, at, velocity) in [
        (glued as fn() -> (World, BodyId), [1.2, 4.0, 0.0], [0.0, -60.0, 0.0]),
        (brittle, [4.0, 0.6, 0.0], [-60.0, 0.0, 0.0]),
    ] {
        let (mut world, body) = scene();
        for _ in 0..40 {
            world.step(DT);
        }
        for kind in [BodyKind::Static, BodyKind::Kinematic] {
            world.body_mut(body).unwrap().set_kind(kind).unwrap();
            assert_eq!(strike(&mut world, at, velocity), 0, "{kind:?}");
            world = World::restore(&world.snapshot()).unwrap();
        }
        world.body_mut(body).unwrap().set_kind(BodyKind::Dynamic).unwrap();
        if world.body(body).unwrap().fracture().is_some() {
            // A body outside the world adds no pieces to it.
            world.body_mut(body).unwrap().set_enabled(false);
            let refused =
                world.body_mut(body).expect("there").break_at(at, &Fracture::by_impulse(1.0));
            assert_eq!(refused.unwrap_err().field(), "body");
            world.body_mut(body).unwrap().set_enabled(true);
        }
        assert!(strike(&mut world, at, velocity) > 0, "{at:?}");
    }
}

#[test]
fn joints_between_what_cannot_move_are_idle_until_something_can() {
    let (mut world, middle) = chain();
    let bodies: Vec<BodyId> = world.bodies().map(|b| b.id()).collect();
    for _ in 0..30 {
        world.step(DT);
    }
    for id in &bodies[1..] {
        world.body_mut(*id).unwrap().set_kind(BodyKind::Static).unwrap();
    }
    let hash = world.state_hash();
    for _ in 0..10 {
        world.step(DT);
    }
    assert_eq!(world.state_hash(), hash);
    world = World::restore(&world.snapshot()).unwrap();
    for id in &bodies[1..] {
        world.body_mut(*id).unwrap().set_kind(BodyKind::Dynamic).unwrap();
    }
    for _ in 0..100 {
        world.step(DT);
    }
    assert_ne!(world.state_hash(), hash);
    assert!(world.joints().all(|joint| joint.error() < 0.01));
    assert_eq!(world.body(middle).unwrap().joints().count(), 2);
}

#[test]
fn what_no_body_can_be_is_refused_by_name() {
    let mut world = World::default();
    let ground = floor(&mut world, Floor::HalfSpace, 1.0);
    let hills = floor(&mut world, Floor::Mesh, 1.0);
    let empty = world.add_body(BodyDef::fixed()).unwrap();
    let cube = world.add_body(BodyDef::dynamic().with_shape(ShapeDef::box_half([0.5; 3]))).unwrap();
    let before = world.snapshot();
    let field = |result: Result<(), DefError>| result.unwrap_err().field().to_owned();
    let mut kind = |id: BodyId, kind: BodyKind| field(world.body_mut(id).unwrap().set_kind(kind));
    assert_eq!(kind(ground, BodyKind::Kinematic), "shape");
    assert_eq!(kind(ground, BodyKind::Dynamic), "shape");
    assert_eq!(kind(hills, BodyKind::Dynamic), "shape");
    assert_eq!(kind(empty, BodyKind::Dynamic), "mass");
    let mut body = world.body_mut(cube).unwrap();
    assert_eq!(field(body.set_mass(MassDef::Mass(-1.0))), "mass");
    assert_eq!(field(body.set_mass(MassDef::Mass(f32::NAN))), "mass");
    assert_eq!(field(body.set_sleep_speed(Some(-1.0))), "sleep_speed");
    let pose = Pose::at([f32::NAN, 0.0, 0.0]);
    let corrected = body.correct_state(pose, [0.0; 3], [0.0; 3]).map(|_| ());
    assert_eq!(field(corrected), "position");
    let corrected = body.correct_state(Pose::IDENTITY, [0.0; 3], [f32::INFINITY; 3]).map(|_| ());
    assert_eq!(field(corrected), "angular_velocity");
    assert!(world.snapshot() == before);
    world.body_mut(hills).unwrap().set_kind(BodyKind::Kinematic).unwrap();
}

#[test]
fn what_starts_disabled_is_out_until_it_is_enabled() {
    let mut world = World::default();
    floor(&mut world, Floor::Box, 1.0);
    let cube = |x: f32| {
        let cube = BodyDef::dynamic().with_position([x, 0.5, 0.0]);
        cube.with_shape(ShapeDef::box_half([0.5; 3]))
    };
    let out = BodyDef { position: vec3(0.0, 5.0, 0.0), ..cube(0.0) };
    let out = world.add_body(out.starts_disabled()).unwrap();
    // The ball is in the middle of a plate, and the plate alone carries while it is out.
    let plate = ShapeDef::box_half([0.5, 0.1, 0.5]);
    let ball = ShapeDef::sphere(0.5).starts_disabled();
    let mass =
        [&plate, &ball].map(|s| drystone::geometry::MassProperties::of(&s.shape, 1000.0).mass);
    let both = BodyDef::dynamic().with_position([3.0, 0.1, 0.0]).with_shape(plate).with_shape(ball);
    let both = world.add_body(both).unwrap();
    let all = world.body(both).unwrap().mass();
    assert!((all - mass[0] - mass[1]).abs() < 1.0e-3 * all, "it counts for the mass");
    let hook = world.add_body(BodyDef::fixed().with_position([6.0, 0.5, 0.0])).unwrap();
    let held = world.add_body(cube(6.0)).unwrap();
    let joint = JointDef::new(hook, held, SixDof::FIXED).at([6.0, 0.5, 0.0]);
    let joint = world.add_joint(joint.starts_disabled()).unwrap();
    assert!(!world.joint(joint).unwrap().is_enabled());
    assert!(!world.joint(joint).unwrap().to_def().unwrap().enabled);
    assert!(world.events().wake.is_empty());
    for _ in 0..60 {
        world.step(DT);
        assert!(world.events().wake.is_empty());
    }
    let y = |world: &World, id: BodyId| world.body(id).unwrap().position().y;
    assert_eq!(y(&world, out), 5.0);
    assert!((y(&world, both) - 0.1).abs() < 1.0e-3, "{}", y(&world, both));
    world.body_mut(held).unwrap().apply_impulse([1000.0, 0.0, 0.0]);
    world.step(DT);
    assert!(world.body(held).unwrap().position().x > 6.0 + 0.5 * DT, "the joint holds nothing yet");
    world.body_mut(out).unwrap().set_enabled(true);
    let ball = world.body(both).unwrap().shapes().nth(1).unwrap();
    world.shape_mut(ball).unwrap().set_enabled(true);
    world.joint_mut(joint).unwrap().set_enabled(true);
    for _ in 0..120 {
        world.step(DT);
    }
    assert!((y(&world, out) - 0.5).abs() < 0.01, "it fell on the floor");
    assert!((y(&world, both) - 0.5).abs() < 0.02, "it rolls on its ball");
    assert!(world.joint(joint).unwrap().error() < 1.0e-3);
}
