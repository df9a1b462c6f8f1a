//! Particles against closed forms, and against shapes and bodies.

use std::sync::Arc;

use drystone::method::Method;
use drystone::particle::{ParticleDef, ParticleId};
use drystone::{
    BodyDef, Hull, Material, Mesh, Quat, Shape, ShapeDef, Vec3, World, WorldConfig, vec3,
};

const DT: f32 = 1.0 / 60.0;

fn weightless() -> World {
    World::new(WorldConfig { gravity: Vec3::ZERO, ..WorldConfig::default() }).unwrap()
}

fn at(world: &World, id: ParticleId) -> Vec3 {
    world.particle(id).unwrap().position()
}

fn velocity(world: &World, id: ParticleId) -> Vec3 {
    world.particle(id).unwrap().velocity()
}

#[test]
fn a_free_particle_falls_along_its_parabola() {
    let mut world = World::default();
    let start = vec3(1.0, 200.0, -2.0);
    let v = vec3(3.0, 4.0, 0.5);
    let id = world.add_particle(ParticleDef::at(start).with_velocity(v)).unwrap();
    for _ in 0..300 {
        world.step(DT);
    }
    let t = 300.0 * f64::from(DT);
    let expected = 200.0 + 4.0 * t - 0.5 * f64::from(9.81_f32) * t * t;
    // A rounding at 200 m in each step, 7.6e-6 m at most.
    let error = (f64::from(at(&world, id).y) - expected).abs();
    assert!(error < 300.0 * 7.7e-6, "{error}");
    assert!((at(&world, id).x - (1.0 + 3.0 * 5.0)).abs() < 300.0 * 1.0e-6);
}

/// A plate, a ball and other shapes around the origin, with their heights there.
fn stones() -> Vec<(&'static str, Vec<ShapeDef>)> {
    let corners: Vec<Vec3> = (0..8)
        .map(|i| vec3(f32::from(i & 1 == 1), f32::from(i & 2 == 2), f32::from(i & 4 == 4)))
        .map(|c| (c * 2.0 - Vec3::ONE) * 0.6)
        .chain([vec3(0.0, 1.0, 0.0), vec3(0.9, 0.1, 0.0)])
        .collect();
    let hull = Shape::Hull(Arc::new(Hull::from_points(&corners).unwrap()));
    // A bowl of 8 by 8 squares.
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for i in 0..9_u16 {
        for k in 0..9_u16 {
            let (x, z) = (0.25 * f32::from(i) - 1.0, 0.25 * f32::from(k) - 1.0);
            vertices.push(vec3(x, 0.5 * (x * x + z * z), z));
        }
    }
    for i in 0..8 {
        for k in 0..8 {
            let a = i * 9 + k;
            triangles.extend([[a, a + 1, a + 10], [a, a + 10, a + 9]]);
        }
    }
    let mesh = Shape::Mesh(Arc::new(Mesh::new(vertices, triangles).unwrap()));
    vec![
        ("ball", vec![ShapeDef::sphere(0.8)]),
        ("box", vec![ShapeDef::box_half([0.8, 0.4, 0.7])]),
        ("capsule", vec![ShapeDef::capsule(0.6, 0.5)]),
        ("cylinder", vec![ShapeDef::cylinder(0.5, 0.8)]),
        ("cone", vec![ShapeDef::new(Shape::cone(0.7, 0.9))]),
        ("hull", vec![ShapeDef::new(hull)]),
        ("mesh", vec![ShapeDef::new(mesh)]),
        (
            "compound",
            vec![
                ShapeDef::sphere(0.5).with_position([-0.4, 0.0, 0.0]),
                ShapeDef::box_half([0.4, 0.3, 0.4]).with_position([0.5, 0.0, 0.0]),
            ],
        ),
    ]
}

/// Dust above the origin.
fn dust(world: &mut World, height: f32) -> Vec<ParticleId> {
    let grid = (0..400_u16).map(|i| {
        let (x, z) = (f32::from(i % 20), f32::from(i / 20));
        vec3(0.09 * (x - 9.5) + 0.003, height + 0.01 * x, 0.09 * (z - 9.5))
    });
    let def = ParticleDef { radius: 0.01, ..ParticleDef::default() };
    world.add_cloud(grid, def).unwrap()
}

#[test]
fn dust_stays_outside_of_every_shape() {
    for (name, shapes) in stones() {
        let mut world = World::default();
        let floor = ShapeDef::half_space([0.0, 1.0, 0.0], -1.5);
        world.add_body(BodyDef::fixed().with_shape(floor)).unwrap();
        let stone = shapes.into_iter().fold(BodyDef::fixed(), BodyDef::with_shape);
        world.add_body(stone.with_rotation(Quat::from_axis_angle(Vec3::Y, 0.3))).unwrap();
        let points = dust(&mut world, 1.6);
        let mut deepest = 0.0_f32;
        for _ in 0..240 {
            world.step(DT);
            deepest = deepest.max(world.particle_penetration());
        }
        println!("{name}: {deepest}");
        // A particle that flies past an edge nearer than its radius has contact only in the next
        // step. Its ball may penetrate for that long, its center never.
        assert!(deepest < 0.01, "{name}: {deepest}");
        let left = world.particle_penetration();
        assert!(left < 1.0e-5, "{name}: {left}");
        assert!(points.iter().all(|id| at(&world, *id).y > -1.5), "{name}");
    }
}

#[test]
fn fast_dust_does_not_pass_thin_walls() {
    // 300 m/s is 5 m per step, through a sheet of 1 mm and a mesh without thickness.
    let square = vec![
        vec3(-5.0, 0.0, -5.0),
        vec3(5.0, 0.0, -5.0),
        vec3(5.0, 0.0, 5.0),
        vec3(-5.0, 0.0, 5.0),
    ];
    let mesh = Mesh::new(square, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
    for shape in [Shape::box_half([5.0, 0.0005, 5.0]), Shape::Mesh(Arc::new(mesh))] {
        for tied in [false, true] {
            let mut world = weightless();
            let kind = shape.kind();
            world.add_body(BodyDef::fixed().with_shape(ShapeDef::new(shape.clone()))).unwrap();
            let mut all = Vec::new();
            for i in 0..40_u8 {
                let y = 1.0 + 0.37 * f32::from(i);
                let x = vec3(0.1 * f32::from(i) - 2.0, y, 0.05 * f32::from(i));
                let def = ParticleDef::at(x).with_velocity([3.0, -300.0, 1.0]);
                all.push(world.add_particle(def).unwrap());
            }
            for pair in all.chunks(2).filter(|_| tied) {
                let link = drystone::particle::LinkDef::new(
                    pair[0],
                    pair[1],
                    drystone::particle::LinkKind::AtMost,
                );
                world.add_link(link).unwrap();
            }
            for _ in 0..30 {
                world.step(DT);
                for id in &all {
                    assert!(at(&world, *id).y > 0.0, "{kind}, tied {tied}: {:?}", at(&world, *id));
                }
            }
        }
    }
}

#[test]
fn dust_slides_on_a_slope_exactly_if_it_is_steeper_than_friction() {
    // A point has no spin: down the slope it accelerates at g (sin - mu cos).
    for (mu, tan) in [(0.5_f32, 0.4_f32), (0.5, 0.6), (0.2, 0.6)] {
        let mut world = World::default();
        let (c, s) = (1.0 / (1.0 + tan * tan).sqrt(), tan / (1.0 + tan * tan).sqrt());
        let normal = vec3(s, c, 0.0);
        let slope = ShapeDef::half_space(normal, 0.0).with_friction(mu);
        world.add_body(BodyDef::fixed().with_shape(slope)).unwrap();
        let material = Material { friction: mu, ..Material::default() };
        let def = ParticleDef { material, radius: 0.01, ..ParticleDef::at(normal * 0.01) };
        let id = world.add_particle(def).unwrap();
        for _ in 0..60 {
            world.step(DT);
        }
        let expected = (9.81 * (s - mu * c)).max(0.0);
        let along = velocity(&world, id).length();
        assert!((along - expected).abs() < 1.0e-4 * 9.81, "mu {mu} tan {tan}: {along} {expected}");
        let way = (at(&world, id) - normal * 0.01).length();
        assert!((way - 0.5 * expected).abs() < 1.0e-3, "mu {mu} tan {tan}: {way}");
    }
}

#[test]
fn dust_bounces_to_the_height_that_restitution_gives() {
    for e in [1.0_f32, 0.8, 0.5] {
        let mut world = World::default();
        let floor = ShapeDef::half_space([0.0, 1.0, 0.0], 0.0);
        world.add_body(BodyDef::fixed().with_shape(floor)).unwrap();
        let material = Material { restitution: e, ..Material::default() };
        let def = ParticleDef { material, ..ParticleDef::at([0.0, 2.01, 0.0]) };
        let id = world.add_particle(def).unwrap();
        let (mut bounced, mut top) = (false, 0.0_f32);
        for _ in 0..200 {
            world.step(DT);
            let v = velocity(&world, id).y;
            if bounced && v < 0.0 {
                break;
            }
            bounced |= v > 0.0;
            if bounced {
                // Adds the remaining rise, because the top of a step is not the apex.
                top = top.max(at(&world, id).y - 0.01 + v * v / (2.0 * 9.81));
            }
        }
        // The bounce is placed within its step by a quadratic: only rounding remains.
        assert!((top - 2.0 * e * e).abs() < 1.0e-4, "{e}: {top}");
    }
}

#[test]
fn a_particle_that_hits_a_free_body_shares_its_momentum() {
    for restitution in [0.0_f32, 1.0] {
        let mut world = weightless();
        let ball = ShapeDef::sphere(0.5).with_restitution(restitution);
        let ball = world.add_body(BodyDef::dynamic().with_mass(2.0).with_shape(ball)).unwrap();
        let material = Material { restitution, ..Material::default() };
        let def = ParticleDef { mass: 0.5, material, ..ParticleDef::at([-3.0, 0.0, 0.0]) };
        let id = world.add_particle(def.with_velocity([10.0, 0.0, 0.0])).unwrap();
        for _ in 0..60 {
            world.step(DT);
        }
        let body = world.body(ball).unwrap().linear_velocity().x;
        let particle = velocity(&world, id).x;
        // m v = 5 in total; after the impact the two separate at e times their approach speed.
        assert!(
            (world.momentum() - vec3(5.0, 0.0, 0.0)).length() < 1.0e-5,
            "{:?}",
            world.momentum()
        );
        let expected = (5.0 + 0.5 * restitution * 10.0) / 2.5;
        assert!((body - expected).abs() < 1.0e-3, "e {restitution}: {body} {expected}");
        assert!((body - particle - restitution * 10.0).abs() < 1.0e-3, "{body} {particle}");
    }
}

#[test]
fn more_particles_than_there_are_colors_share_their_momentum_with_one_body() {
    // 12 × 12 in one step, on a plate that in lanes may get 63 impacts.
    let mut world = weightless();
    let plate = ShapeDef::box_half([1.0, 0.1, 1.0]).with_friction(0.0);
    let plate = world.add_body(BodyDef::dynamic().with_mass(2.0).with_shape(plate)).unwrap();
    let def = ParticleDef { mass: 0.01, ..ParticleDef::default() };
    let mut points = Vec::new();
    for i in 0..144_u16 {
        let (x, z) = (f32::from(i % 12), f32::from(i / 12));
        let at = vec3(0.15 * x - 0.825, 0.5, 0.15 * z - 0.825);
        points.push(world.add_particle(ParticleDef { position: at, ..def }).unwrap());
    }
    for id in &points {
        world.particle_mut(*id).unwrap().set_velocity([0.0, -5.0, 0.0]);
    }
    for _ in 0..60 {
        world.step(DT);
    }
    let body = world.body(plate).unwrap();
    let plate = body.linear_velocity().y;
    // A rounding of each of 144 impacts.
    assert!((world.momentum().y + 7.2).abs() < 144.0 * 7.2 * 6.0e-8, "{:?}", world.momentum());
    // If all move on with the plate it has 7.2/3.44. If each hits once, one after the other, each
    // takes 0.01/2.01 of the remaining relative speed.
    let together = -7.2 / 3.44;
    let one_by_one = -5.0 * (1.0 - (2.0_f32 / 2.01).powi(144));
    assert!(one_by_one < plate && plate < together + 1.0e-4, "{one_by_one} {plate} {together}");
    // Impacts are symmetric: together they rotate it by less than the outermost alone would.
    assert!(
        body.angular_velocity().length() < 0.05 * 0.825 / 0.67,
        "{:?}",
        body.angular_velocity()
    );
    for id in points {
        // A touching particle does not penetrate further.
        assert!(velocity(&world, id).y > plate - 1.0e-3, "{}", velocity(&world, id).y);
    }
}

#[test]
fn a_particle_that_hits_a_box_off_center_turns_it() {
    // Total momentum and angular momentum are conserved: nothing else is there.
    let mut world = weightless();
    let plank = ShapeDef::box_half([1.0, 0.1, 0.1]);
    let plank = world.add_body(BodyDef::dynamic().with_mass(2.0).with_shape(plank)).unwrap();
    let def = ParticleDef { mass: 0.2, ..ParticleDef::at([0.8, 1.0, 0.0]) };
    world.add_particle(def.with_velocity([0.0, -20.0, 0.0])).unwrap();
    let before = world.audit().momentum;
    for _ in 0..20 {
        world.step(DT);
    }
    let after = world.audit().momentum;
    assert!(world.body(plank).unwrap().angular_velocity().z < -1.0);
    assert!((after.linear - before.linear).length() < 1.0e-5, "{before:?} {after:?}");
    // The lever arm of a contact is that of the step's start. The plank rotates by about 0.05 in
    // that step, and the impulse of 4 N s comes in its first substep or a later one.
    assert!((after.about_origin - before.about_origin).length() < 0.02, "{before:?} {after:?}");
}

#[test]
fn a_body_that_sleeps_is_woken_by_what_hits_it_and_not_by_what_rests() {
    let mut world = World::default();
    let floor = ShapeDef::half_space([0.0, 1.0, 0.0], 0.0);
    world.add_body(BodyDef::fixed().with_shape(floor)).unwrap();
    let cube = BodyDef::dynamic().with_position([0.0, 0.5, 0.0]);
    let cube = world.add_body(cube.with_shape(ShapeDef::box_half([0.5; 3]))).unwrap();
    let seconds = |world: &mut World, n: u32| (0..60 * n).for_each(|_| world.step(DT));
    seconds(&mut world, 2);
    assert!(world.body(cube).unwrap().is_asleep());
    let def = ParticleDef { mass: 0.5, ..ParticleDef::at([0.1, 2.0, 0.0]) };
    let id = world.add_particle(def).unwrap();
    let mut woke = false;
    for _ in 0..120 {
        world.step(DT);
        woke |= !world.body(cube).unwrap().is_asleep();
    }
    assert!(woke);
    seconds(&mut world, 4);
    assert!(world.body(cube).unwrap().is_asleep(), "what rests on it lets it sleep");
    assert!(world.particle(id).unwrap().is_asleep());
    // A call that wakes the body also wakes the particle on it.
    let mut moved = world.body_mut(cube).unwrap();
    moved.set_linear_velocity([0.0, 3.0, 0.0]);
    seconds(&mut world, 1);
    assert!((at(&world, id).y - 1.01).abs() > 1.0e-3 || !world.particle(id).unwrap().is_asleep());
    // When the floor is removed, all fall.
    let floor = world.bodies().next().unwrap().id();
    world.remove_body(floor);
    seconds(&mut world, 1);
    assert!(at(&world, id).y < 0.0, "{:?}", at(&world, id));
}

#[test]
fn a_particle_that_turns_non_finite_is_put_aside_and_reported() {
    let mut world =
        World::new(WorldConfig { gravity: vec3(0.0, -1.0e6, 0.0), ..WorldConfig::default() })
            .unwrap();
    // 1e9 m/s² for 0.2 s.
    let heavy = ParticleDef { gravity_scale: 1.0e3, ..ParticleDef::default() };
    let free = world.add_particle(heavy).unwrap();
    let a = world.add_particle(ParticleDef::at([1.0, 0.0, 0.0])).unwrap();
    let pin = world.add_particle(ParticleDef::at([2.0, 0.0, 0.0]).pinned()).unwrap();
    world
        .add_link(drystone::particle::LinkDef::new(a, pin, drystone::particle::LinkKind::Equal))
        .unwrap();
    let mut faults = Vec::new();
    for _ in 0..3 {
        world.step(0.2);
        faults.extend(world.events().faults.iter().map(|f| (f.particle, f.body)));
    }
    assert!(faults.contains(&(Some(free), None)), "{faults:?}");
    assert_eq!(faults.iter().filter(|f| f.0 == Some(free)).count(), 1);
    assert!(world.particles().all(|p| p.position().is_finite() && p.velocity().is_finite()));
    // It takes part again when the user sets its position.
    world.set_gravity([0.0, -9.81, 0.0]);
    world.particle_mut(free).unwrap().set_position([0.0, 5.0, 0.0]);
    world.step(DT);
    assert!(at(&world, free).y < 5.0);
}

#[test]
fn every_method_moves_particles_with_bodies() {
    for name in Method::NAMES {
        let method = Method::named(name).unwrap();
        let mut world = World::new(WorldConfig { method, ..WorldConfig::default() }).unwrap();
        let floor = ShapeDef::half_space([0.0, 1.0, 0.0], 0.0);
        world.add_body(BodyDef::fixed().with_shape(floor)).unwrap();
        let crate_ = ShapeDef::box_half([0.2; 3]);
        let def = BodyDef::dynamic().with_position([0.0, 2.0, 0.0]).with_mass(1.0);
        let weight = world.add_body(def.with_shape(crate_)).unwrap();
        let mut rope = drystone::particle::RopeDef::between([0.0, 4.0, 0.0], [0.0, 2.2, 0.0], 10);
        rope.pinned = [true, false];
        let rope = world.add_rope(rope).unwrap();
        world
            .particle_mut(rope.particles[10])
            .expect("there")
            .attach(weight, [0.0, 0.2, 0.0])
            .unwrap();
        dust(&mut world, 3.0);
        for _ in 0..300 {
            world.step(DT);
        }
        let y = world.body(weight).unwrap().position().y;
        let pull = world.particle(rope.particles[10]).unwrap().attachment_force().y;
        println!("{name}: {y} {pull}");
        // A tenth of the rope is more than any form stretches.
        assert!((y - 2.0).abs() < 0.18, "{name}: {y}");
        assert!(pull < -0.5 * 9.81, "{name}: {pull}");
        assert!(world.particle_penetration() < 0.005, "{name}");
    }
}

/// A body of 1 t is attached to a pinned particle 15 m away. It closes at 10 m/s, and in addition
/// by half in a tenth of a second, up to 10 m/s, for any number of sweeps and substeps. A sweep
/// must not close again the distance that the previous one already closes.
#[test]
fn what_is_attached_from_afar_comes_no_faster_than_may_be() {
    for form in ["soft", "aim", "verlet"] {
        for (sweeps, substeps) in [("1", "1"), ("1", "8"), ("20", "4"), ("20", "32")] {
            let mut config = WorldConfig { gravity: Vec3::ZERO, ..WorldConfig::default() };
            config.set("particle.form", form).unwrap();
            config.set("particle.sweeps", sweeps).unwrap();
            config.set("substeps", substeps).unwrap();
            let mut world = World::new(config).unwrap();
            let body = BodyDef::dynamic().with_position([15.0, 0.0, 0.0]).with_mass(1000.0);
            let body = world.add_body(body.with_shape(ShapeDef::sphere(1.0))).unwrap();
            let pin = ParticleDef { pinned: true, ..ParticleDef::at(Vec3::ZERO) };
            let pin = world.add_particle(pin).unwrap();
            world.particle_mut(pin).unwrap().attach(body, Vec3::ZERO).unwrap();
            let name = format!("{form}, {sweeps} sweeps, {substeps} substeps");
            for step in 0..240_u8 {
                world.step(DT);
                let v = world.body(body).unwrap().linear_velocity().length();
                assert!(v < 20.1, "{name}, step {step}: {v} m/s");
            }
            let far = world.body(body).unwrap().position().length();
            assert!(far < 0.01, "{name}: still {far} m away");
        }
    }
}
