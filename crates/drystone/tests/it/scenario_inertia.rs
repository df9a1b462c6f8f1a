//! Load-adaptive inertia: the loads it holds, and the cases it must not affect.

use drystone::{BodyDef, BodyId, ShapeDef, Vec3, World, WorldConfig, vec3};

const DT: f32 = 1.0 / 60.0;
const G: f32 = 10.0;

fn world(most: f32) -> World {
    let mut config = WorldConfig { gravity: vec3(0.0, -G, 0.0), ..WorldConfig::default() };
    config.sleep.enabled = false;
    config.inertia.max_factor = most;
    World::new(config).unwrap()
}

fn grounded(most: f32) -> World {
    let mut world = world(most);
    let ground = ShapeDef::box_half([200.0, 1.0, 200.0]).with_friction(0.6);
    world.add_body(BodyDef::fixed().with_position([0.0, -1.0, 0.0]).with_shape(ground)).unwrap();
    world
}

fn boxed(world: &mut World, half: Vec3, at: Vec3, mass: f32) -> BodyId {
    let shape = ShapeDef::box_half(half).with_friction(0.6);
    world.add_body(BodyDef::dynamic().with_position(at).with_shape(shape).with_mass(mass)).unwrap()
}

fn stack(world: &mut World, n: u16, top: f32) -> Vec<BodyId> {
    let half = vec3(0.5, 0.5, 0.5);
    (0..n)
        .map(|i| {
            let mass = if i + 1 == n { top } else { 1.0 };
            boxed(world, half, vec3(0.0, 0.5 + f32::from(i), 0.0), mass)
        })
        .collect()
}

fn at(world: &World, id: BodyId) -> Vec3 {
    world.body(id).unwrap().position()
}

fn run(world: &mut World, steps: u32) {
    for _ in 0..steps {
        world.step(DT);
    }
}

/// Sum of m v over the bodies [kg m/s].
fn momentum(world: &World, all: &[BodyId]) -> Vec3 {
    let of = |id: &BodyId| world.body(*id).map(|b| b.linear_velocity() * b.mass()).unwrap();
    all.iter().map(of).fold(Vec3::ZERO, |sum, p| sum + p)
}

#[test]
fn heavy_loads_sink_no_deeper_than_the_factor_allows() {
    // A contact under the load N yields by N k / omega², k = 2/(s m), omega = 2 pi 54 Hz; the
    // lowest one, against the ground, by a quarter of half of that. 9 contacts of ten boxes. s is
    // 8. Under loads of more than 5 × 8 times 30 m/s² it grows as the root of the load, up to 3 ×
    // 8.
    let omega = 2.0 * core::f32::consts::PI * 54.0;
    for ratio in [100.0, 300.0, 1000.0, 2000.0] {
        let mut w = grounded(0.0);
        let s = stack(&mut w, 10, ratio);
        // Bodies placed at rest are held in place, so this one first slides by 0.2 mm.
        for id in &s {
            w.body_mut(*id).unwrap().set_linear_velocity([0.05, 0.0, 0.0]);
        }
        run(&mut w, 1200);
        let sag = 9.5 - at(&w, s[9]).y;
        // The uppermost contact has the heavy body on one side: k = 1/(s m) there.
        let factor = 8.0 * ((ratio + 4.5) * G / (30.0 * 40.0)).sqrt().clamp(1.0, 3.0);
        let per_contact = 2.0 * (ratio + 4.5) * G / (factor * omega * omega);
        // A deeper contact settles to a hundredth of half a box's thickness.
        let settled = |gives: f32| gives.min(0.005);
        let expected =
            8.0 * settled(per_contact) + settled(0.5 * per_contact) + settled(0.125 * per_contact);
        // The factor may stay a fifth below the value for the load (its hysteresis), and rounding
        // of the contact's own offset adds 5e-5 m each.
        assert!(sag < 1.25 * expected + 10.0 * 5.0e-5, "{ratio}: {sag}, {expected}");
        assert!(sag > 0.5 * expected, "{ratio}: {sag}, {expected}");
        let off = at(&w, s[9]);
        assert!(off.x.hypot(off.z) < 0.01, "{ratio}: {off:?}");
    }
}

#[test]
fn substeps_in_parts_make_squeezed_contacts_stiffer_by_the_square() {
    for (parts, ratio) in [(2_u16, 300.0), (2, 1000.0), (4, 1000.0), (4, 2000.0)] {
        let mut w = grounded(0.0);
        w.set_config(refined(w.config(), parts)).unwrap();
        let s = stack(&mut w, 10, ratio);
        run(&mut w, 1200);
        let sag = 9.5 - at(&w, s[9]).y;
        // As above, with contacts of 54 Hz times the number of parts.
        let omega = 2.0 * core::f32::consts::PI * 54.0 * f32::from(parts);
        let expected = 2.0 * (ratio + 4.5) * G / (8.0 * omega * omega) * (8.0 + 0.5 + 0.125);
        let offsets = 10.0 * 5.0e-5;
        assert!(sag < 1.25 * expected + offsets, "{parts}, {ratio}: {sag}, {expected}");
        assert!(sag > 0.5 * expected - offsets, "{parts}, {ratio}: {sag}, {expected}");
        let off = at(&w, s[9]);
        assert!(off.x.hypot(off.z) < 0.01, "{parts}, {ratio}: {off:?}");
    }
}

fn refined(config: &WorldConfig, parts: u16) -> WorldConfig {
    let mut config = config.clone();
    config.inertia.refine = parts.into();
    config
}

#[test]
fn substeps_in_parts_are_for_islands_that_need_them() {
    let of = |parts: u16| {
        let mut w = grounded(0.0);
        w.set_config(refined(w.config(), parts)).unwrap();
        let heavy = stack(&mut w, 10, 300.0);
        let half = vec3(0.5, 0.5, 0.5);
        let slid = boxed(&mut w, half, vec3(20.0, 0.5, 0.0), 1.0);
        w.body_mut(slid).unwrap().set_linear_velocity([3.0, 0.0, 1.0]);
        run(&mut w, 240);
        (at(&w, heavy[9]), at(&w, slid))
    };
    let (one, two) = (of(1), of(2));
    assert_ne!(one.0, two.0);
    assert_eq!(one.1, two.1, "the same bits where nothing is squeezed");
}

#[test]
fn a_stack_at_the_limit_of_parts_comes_to_rest() {
    // 30 boxes: the lowest ones' load reaches the maximum factor, and stiffer contacts push up
    // boxes that had sunk into them.
    for n in [20, 25, 30, 35] {
        let mut w = grounded(0.0);
        w.set_config(refined(w.config(), 2)).unwrap();
        let s = stack(&mut w, n, 1.0);
        run(&mut w, 1200);
        let fastest = s.iter().map(|id| w.body(*id).unwrap().linear_velocity().length());
        let fastest = fastest.fold(0.0, f32::max);
        // Below the speed that counts as still for sleep.
        assert!(fastest < 0.05, "{n}: {fastest}");
        let off = at(&w, s[usize::from(n) - 1]);
        assert!(off.x.hypot(off.z) < 0.01, "{n}: {off:?}");
    }
}

#[test]
fn parts_out_of_range_are_refused() {
    for parts in [0, 9] {
        let error = World::new(refined(&WorldConfig::default(), parts)).unwrap_err();
        assert!(error.to_string().contains("inertia.refine"), "{error}");
    }
}

#[test]
fn a_light_stack_is_left_alone() {
    // Two boxes press on one with 20 m/s² of the threshold's 30: the same bits with and without.
    let (mut with, mut without) = (grounded(0.0), grounded(1.0));
    let (a, b) = (stack(&mut with, 3, 1.0), stack(&mut without, 3, 1.0));
    run(&mut with, 300);
    run(&mut without, 300);
    for (a, b) in a.iter().zip(&b) {
        assert_eq!(at(&with, *a), at(&without, *b));
    }
}

#[test]
fn a_stack_rides_a_truck() {
    let mut w = world(0.0);
    let bed = ShapeDef::box_half([3.0, 0.5, 3.0]).with_friction(0.6);
    let def = BodyDef::kinematic().with_position([0.0, -0.5, 0.0]);
    let truck = w.add_body(def.with_linear_velocity([20.0, 0.0, 0.0]).with_shape(bed)).unwrap();
    let s = stack(&mut w, 10, 300.0);
    for id in &s {
        w.body_mut(*id).unwrap().set_linear_velocity([20.0, 0.0, 0.0]);
    }
    run(&mut w, 600);
    // As at rest: within the centimeter that a stack of this load may drift.
    let off = at(&w, s[9]) - at(&w, truck) - vec3(0.0, 10.0, 0.0);
    assert!(off.x.hypot(off.z) < 0.01 && off.y.abs() < 0.09, "{off:?}");
}

#[test]
fn a_loaded_cart_on_ice_keeps_its_speed() {
    let mut w = grounded(0.0);
    let cart = ShapeDef::box_half([3.0, 0.5, 3.0]).with_friction(0.0);
    let def = BodyDef::dynamic().with_position([0.0, 0.5, 0.0]).with_shape(cart).with_mass(10.0);
    let mut all = vec![w.add_body(def).unwrap()];
    for i in 0..5_u16 {
        let mass = if i == 4 { 300.0 } else { 1.0 };
        let shape = ShapeDef::box_half([0.5, 0.5, 0.5]).with_friction(1.0);
        let def = BodyDef::dynamic().with_position([0.0, 1.5 + f32::from(i), 0.0]);
        all.push(w.add_body(def.with_shape(shape).with_mass(mass)).unwrap());
    }
    for id in &all {
        w.body_mut(*id).unwrap().set_linear_velocity([5.0, 0.0, 0.0]);
    }
    let before = momentum(&w, &all).x;
    run(&mut w, 600);
    // No force acts along x. Rounding of 600 steps of 8 sweeps at velocities of 5 m/s: 3e-7 per
    // sweep at random, 2e-5. Rising factors take momentum only against the island's motion.
    let change = momentum(&w, &all).x / before - 1.0;
    assert!(change.abs() < 1.0e-4, "{change}");
}

#[test]
fn a_stack_turns_with_a_turntable() {
    let mut w = world(0.0);
    let bed = ShapeDef::box_half([5.0, 0.5, 5.0]).with_friction(0.6);
    let def = BodyDef::kinematic().with_position([0.0, -0.5, 0.0]);
    let table = w.add_body(def.with_angular_velocity([0.0, 0.1, 0.0]).with_shape(bed)).unwrap();
    let mut s = Vec::new();
    for i in 0..10_u16 {
        let shape = ShapeDef::box_half([0.5, 0.5, 0.5]).with_friction(0.6);
        let def = BodyDef::dynamic().with_position([3.0, 0.5 + f32::from(i), 0.0]);
        let mass = if i == 9 { 100.0 } else { 1.0 };
        s.push(w.add_body(def.with_shape(shape).with_mass(mass)).unwrap());
    }
    run(&mut w, 600);
    let t = w.body(table).unwrap();
    let (low, top) = (w.body(s[0]).unwrap(), w.body(s[9]).unwrap());
    let local = |b: Vec3| t.rotation().unrotate(b - t.position());
    // The table reaches its speed in one step, the lowest box after that: by half a step of 0.3
    // m/s, and each higher box later by the same amount.
    let (low, top) = (local(low.position()), local(top.position()));
    assert!((low - vec3(3.0, 1.0, 0.0)).length() < 0.005, "{low:?}");
    assert!((top - vec3(3.0, 10.0, 0.0)).length() < 0.1, "{top:?}");
}

#[test]
fn what_falls_does_not_float() {
    let mut w = world(0.0);
    let shape = ShapeDef::box_half([9.0, 1.0, 9.0]);
    let ground =
        w.add_body(BodyDef::fixed().with_position([0.0, -1.0, 0.0]).with_shape(shape)).unwrap();
    let s = stack(&mut w, 10, 300.0);
    run(&mut w, 300);
    assert!(w.remove_body(ground));
    run(&mut w, 60);
    // Momentum is that of a second's fall, except for the steps in which the factors return to 1.
    // They lose half of the rest in each step, so that less than the pull of two steps is missing.
    let v = momentum(&w, &s).y / 309.0;
    assert!(v < -G * (1.0 - 2.0 * DT) && v > -G * 1.001, "{v}");
}

#[test]
fn light_bodies_do_not_fly_when_their_load_is_taken() {
    let mut w = grounded(0.0);
    let s = stack(&mut w, 10, 300.0);
    run(&mut w, 300);
    let before: Vec<f32> = s.iter().map(|id| at(&w, *id).y).collect();
    let overlap = 8.5 - before[8];
    assert!(w.remove_body(s[9]));
    let mut rise: f32 = 0.0;
    for _ in 0..120 {
        w.step(DT);
        for (id, y) in s.iter().zip(&before).take(9) {
            rise = rise.max(at(&w, *id).y - y);
        }
    }
    // The initial compression, and the hop of boxes that separate at up to the limit of 0.25 m/s
    // each: 9 of them, (9 · 0.25)² / 2 g.
    assert!(rise < overlap + (9.0_f32 * 0.25).powi(2) / (2.0 * G), "{rise}, {overlap}");
}

#[test]
fn a_loaded_slab_holds_and_slides_at_the_limit_of_its_load() {
    for lower in [false, true] {
        for (pull, least, most) in [(0.9, -0.001, 0.001), (0.98, -0.001, 0.005), (1.1, 0.22, 0.36)]
        {
            let mut w = grounded(0.0);
            let base = boxed(&mut w, vec3(2.0, 0.25, 2.0), vec3(0.0, 0.25, 0.0), 100.0);
            let load = boxed(&mut w, vec3(1.0, 0.5, 1.0), vec3(0.0, 1.0, 0.0), 1000.0);
            run(&mut w, 120);
            let (id, mass) = if lower { (base, 1100.0) } else { (load, 1000.0) };
            let before = at(&w, id).x;
            let force = pull * 0.6 * mass * G;
            w.body_mut(id).unwrap().set_lasting_force([force, 0.0, 0.0]);
            run(&mut w, 60);
            // (pull - 1) mu g / 2 after a second: 0.3 m at 1.1. A slab of 100 kg that carries a ton
            // has 1000 g / (100 · 30 m/s²) = 3.3 times its inertia, so that it is slower by
            // 1100/1333.
            let way = at(&w, id).x - before;
            assert!(way > least && way < most, "{pull} lower {lower}: {way}");
        }
    }
}

#[test]
fn squeezed_bodies_that_nothing_holds_take_momentum_from_nobody() {
    // Without gravity a hammer drives five blocks into an anvil. Total momentum is constant up to
    // rounding, within 1e-5 as A21 of the list of tests requires.
    let mut w = world(0.0);
    w.set_gravity([0.0; 3]);
    let half = vec3(0.5, 0.5, 0.5);
    let mut all: Vec<_> =
        (0..5_u16).map(|i| boxed(&mut w, half, vec3(f32::from(i) * 1.01, 0.0, 0.0), 1.0)).collect();
    let hammer = boxed(&mut w, half, vec3(-3.0, 0.0, 0.0), 100.0);
    w.body_mut(hammer).unwrap().set_linear_velocity([5.0, 0.0, 0.0]);
    all.push(hammer);
    all.push(boxed(&mut w, half, vec3(7.0, 0.0, 0.0), 100.0));
    let energy = w.kinetic_energy();
    for _ in 0..300 {
        w.step(DT);
        let p = momentum(&w, &all).x;
        assert!((p - 500.0).abs() < 5.0e-3, "{p}");
        assert!(w.kinetic_energy() <= energy, "{}", w.kinetic_energy());
    }
}

#[test]
fn what_is_squeezed_in_free_flight_is_accelerated_by_its_own_mass() {
    // 3 kN from one side, 1 kN from the other: 2 kN move 151 kg for a second, or 158 kg if the body
    // of 1 kg had 8 times its mass.
    let mut w = world(0.0);
    w.set_gravity([0.0; 3]);
    let half = vec3(0.5, 0.5, 0.5);
    let mut all = Vec::new();
    for (x, mass, force) in [(0.0, 100.0, 3000.0), (1.0, 1.0, 0.0), (2.0, 50.0, -1000.0)] {
        let id = boxed(&mut w, half, vec3(x, 0.0, 0.0), mass);
        w.body_mut(id).unwrap().set_lasting_force([force, 0.0, 0.0]);
        all.push(id);
    }
    run(&mut w, 60);
    let p = momentum(&w, &all).x;
    assert!((p - 2000.0).abs() < 2000.0e-5, "{p}");
}

#[test]
fn stacks_lean_as_far_as_the_theory_says() {
    // Ten boxes, each offset by a further d. The center of the upper k is (k - 1) d / 2 + d beyond
    // the box below and must be within half an edge: 10 d / 2 < 0.5 for nine of them.
    for (lean, stands) in [(0.09, true), (0.105, false), (0.12, false)] {
        let mut w = grounded(0.0);
        let half = vec3(0.5, 0.5, 0.5);
        let column = (0..10_u16).map(|i| vec3(lean * f32::from(i), 0.5 + f32::from(i), 0.0));
        let s: Vec<_> = column.map(|p| boxed(&mut w, half, p, 1.0)).collect();
        run(&mut w, 1200);
        assert_eq!(at(&w, s[9]).y > 9.0, stands, "{lean}");
    }
}
