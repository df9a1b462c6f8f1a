//! Ropes, cloths and springs of particles against closed forms.

use std::sync::Arc;

use drystone::config::ParticleForm;
use drystone::particle::{
    ClothDef, LinkDef, LinkKind, LinkSpring, ParticleDef, ParticleId, RopeDef,
};
use drystone::threads::{SimdLevel, Team};
use drystone::{BodyDef, DefErrorKind, ShapeDef, Vec3, World, WorldConfig, vec3};

const DT: f32 = 1.0 / 60.0;

fn weightless() -> World {
    World::new(WorldConfig { gravity: Vec3::ZERO, ..WorldConfig::default() }).unwrap()
}

fn at(world: &World, id: ParticleId) -> Vec3 {
    world.particle(id).unwrap().position()
}

fn seconds(world: &mut World, n: u32) {
    (0..60 * n).for_each(|_| world.step(DT));
}

/// Positions of the particles of a rope of equal links and masses between two points at one height.
/// Each link points along the sum of the forces below it. Found by bisection over the horizontal
/// force.
fn hanging_chain(links: i32, length: f64, span: f64) -> Vec<(f64, f64)> {
    let part = length / f64::from(links);
    let place = |pull: f64| {
        let (mut x, mut y, mut out) = (0.0, 0.0, vec![(0.0, 0.0)]);
        for i in 0..links {
            // Vertical force in link i in units of a particle's weight: half of the others.
            let down = 0.5 * f64::from(links - 1) - f64::from(i);
            let size = (pull * pull + down * down).sqrt();
            x += part * pull / size;
            y -= part * down / size;
            out.push((x, y));
        }
        out
    };
    let (mut low, mut high) = (1.0e-9, 1.0e9_f64);
    for _ in 0..200 {
        let middle = (low * high).sqrt();
        let wide = place(middle).last().unwrap().0 > span;
        (low, high) = if wide { (low, middle) } else { (middle, high) };
    }
    place(low)
}

#[test]
fn a_rope_hangs_as_its_chain_of_links_does() {
    for (kind, links) in [(LinkKind::Equal, 20_u8), (LinkKind::AtMost, 20), (LinkKind::AtMost, 40)]
    {
        let mut config = WorldConfig::default();
        config.sleep.enabled = false;
        let mut world = World::new(config).unwrap();
        let mut def = RopeDef::between([0.0, 0.0, 0.0], [2.0, 0.0, 0.0], links.into());
        (def.length, def.pinned, def.kind) = (Some(3.0), [true, true], kind);
        // Damping brings it to rest; at rest it has no effect.
        def.particle.damping = 2.0;
        let rope = world.add_rope(def).unwrap();
        seconds(&mut world, 30);
        let expected = hanging_chain(links.into(), 3.0, 2.0);
        let sag = expected.iter().map(|p| -p.1).fold(0.0, f64::max);
        let mut worst = 0.0_f64;
        for (id, (x, y)) in rope.particles.iter().zip(&expected) {
            let p = at(&world, *id);
            worst = worst.max((f64::from(p.x) - x).hypot(f64::from(p.y) - y));
        }
        println!("{kind:?} {links} links: {worst} of a sag of {sag}");
        // A thread yields by parts per million under 5 N; positions of 3 m are accurate to 1e-7 of
        // it.
        assert!(worst < 1.0e-4 * sag, "{kind:?} {links}: {worst} of a sag of {sag}");
    }
}

/// As in `verlet`: each link's error is removed separately, so the number of sweeps matters.
#[test]
fn ropes_and_cloths_of_projected_positions_hang_as_their_chains_of_links_do() {
    for width in [0, 3] {
        let mut config = WorldConfig::default();
        (config.particle.form, config.particle.sweeps) = (ParticleForm::Verlet, 32);
        config.sleep.enabled = false;
        let mut world = World::new(config).unwrap();
        let particle = ParticleDef { damping: 2.0, ..ParticleDef::default() };
        let particles = if width == 0 {
            let mut def = RopeDef::between(Vec3::ZERO, [2.0, 0.0, 0.0], 20);
            (def.length, def.pinned, def.particle) = (Some(3.0), [true, true], particle);
            world.add_rope(def).unwrap().particles
        } else {
            let sides = [Vec3::X * 3.0, Vec3::Z * 0.45];
            let mut def = ClothDef::new(Vec3::ZERO, sides, [20, width]);
            (def.particle, def.bend) = (particle, None);
            let cloth = world.add_cloth(def).unwrap().particles;
            for (i, id) in cloth.iter().enumerate().filter(|(i, _)| i % 21 == 0 || i % 21 == 20) {
                let mut held = world.particle_mut(*id).unwrap();
                held.set_pinned(true);
                let (x, z) = (if i % 21 == 0 { 0.0 } else { 2.0 }, 0.15 * (i / 21) as f32);
                held.set_position([x, 0.0, z]);
            }
            cloth
        };
        seconds(&mut world, 20);
        let expected = hanging_chain(20, 3.0, 2.0);
        let sag = expected.iter().map(|p| -p.1).fold(0.0, f64::max);
        let mut worst = 0.0_f64;
        for (id, (x, y)) in particles.iter().zip(expected.iter().cycle()) {
            let p = at(&world, *id);
            worst = worst.max((f64::from(p.x) - x).hypot(f64::from(p.y) - y));
        }
        println!("{width} squares wide: {worst} of a sag of {sag}");
        assert!(worst < 0.01 * sag, "{width} squares wide: {worst} of a sag of {sag}");
    }
}

#[test]
fn a_cloth_by_two_corners_hangs_by_its_threads_and_does_not_stretch() {
    let mut config = WorldConfig::default();
    config.sleep.enabled = false;
    let mut world = World::new(config).unwrap();
    // Compressed by a tenth, so that it sags.
    let def = ClothDef::new([0.0, 0.0, 0.0], [Vec3::X * 2.0, Vec3::Y * -2.0], [20, 20]);
    let cloth = world.add_cloth(def).unwrap();
    for (i, x) in [(0, 0.1), (20, 1.9)] {
        let mut corner = world.particle_mut(cloth.particles[i]).unwrap();
        corner.set_pinned(true);
        corner.set_position([x, 0.0, 0.0]);
    }
    seconds(&mut world, 5);
    // Threads only: shear and bend links are springs.
    let threads = || world.links().filter(|l| l.kind() == LinkKind::AtMost);
    let worst = threads().map(|l| l.distance() / l.length() - 1.0).fold(0.0, f32::max);
    println!("{worst}");
    assert!(threads().count() == 840 && worst < 0.005, "{worst}");
    // The threads and the shear links at the two corners carry the whole weight.
    let top = threads().map(|l| l.tension()).fold(0.0, f32::max);
    assert!(top > 0.25 * 9.81, "{top}");
}

#[test]
fn momentum_of_a_weightless_cloth_stays() {
    let mut world = weightless();
    let def = ClothDef::new(Vec3::ZERO, [Vec3::X, Vec3::Z], [12, 12]);
    let mut def = ClothDef { stretch: LinkKind::Equal, ..def };
    def.particle.damping = 0.0;
    let cloth = world.add_cloth(def).unwrap();
    for (i, id) in (0_u8..).zip(&cloth.particles) {
        let v = vec3(f32::from(i % 7) - 3.0, f32::from(i % 5), f32::from(i % 3) - 1.0);
        world.particle_mut(*id).unwrap().set_velocity(v);
    }
    let before = world.audit().momentum;
    seconds(&mut world, 5);
    let after = world.audit().momentum;
    // 1 kg at some m/s, 900 links, 2,600 substeps, each a rounding of 1e-9 N s of either sign.
    assert!((after.linear - before.linear).length() < 2.0e-5, "{before:?} {after:?}");
    // Links push along their direction at the substep's end or middle: angular momentum is
    // conserved to second order only.
    let spin = (after.about_center - before.about_center).length();
    println!("angular momentum {:?}, off by {spin}", before.about_center);
}

#[test]
fn a_spring_swings_with_its_period() {
    let (k, m) = (200.0_f32, 0.5_f32);
    // By rate, and by the equivalent frequency for such masses.
    let omega = (k * 2.0 / m).sqrt();
    let hertz = omega / (2.0 * core::f32::consts::PI);
    for spring in [
        LinkSpring::Rate { stiffness: k, damping: 0.0 },
        LinkSpring::Frequency { hertz, damping_ratio: 0.0 },
    ] {
        let mut config = WorldConfig { gravity: Vec3::ZERO, ..WorldConfig::default() };
        config.substeps = 64;
        config.sleep.enabled = false;
        let mut world = World::new(config).unwrap();
        let a = world.add_particle(ParticleDef::default().with_mass(m)).unwrap();
        let b = world.add_particle(ParticleDef::at([1.1, 0.0, 0.0]).with_mass(m)).unwrap();
        world.add_link(LinkDef::new(a, b, LinkKind::Spring(spring)).with_length(1.0)).unwrap();
        let stretch = |world: &World| at(world, b).x - at(world, a).x - 1.0;
        // Times at which it crosses its rest length, interpolated.
        let (mut last, mut times) = (stretch(&world), Vec::new());
        for step in 0..120_u8 {
            world.step(DT);
            let now = stretch(&world);
            if (now < 0.0) != (last < 0.0) {
                times.push((f32::from(step) + last / (last - now)) * DT);
            }
            last = now;
        }
        let halves = f32::from(u8::try_from(times.len() - 1).unwrap());
        let period = 2.0 * (times[times.len() - 1] - times[0]) / halves;
        let expected = 2.0 * core::f32::consts::PI / omega;
        // Implicit Euler is slow by (ωh)²/3 = 2e-5. Linear interpolation between two samples of a
        // sine has an error of (ω dt)³/50 of a radian over 18 half turns.
        assert!((period / expected - 1.0).abs() < 2.0e-3, "{spring:?}: {period} {expected}");
    }
}

#[test]
fn a_rope_bears_the_weight_that_hangs_on_it() {
    let mut config = WorldConfig::default();
    config.sleep.enabled = false;
    let mut world = World::new(config).unwrap();
    let def = BodyDef::dynamic().with_position([0.0, 2.9, 0.0]).with_mass(2.0);
    let def = BodyDef { linear_damping: 1.0, ..def };
    let weight = world.add_body(def.with_shape(ShapeDef::box_half([0.1; 3]))).unwrap();
    let mut rope = RopeDef::between([0.0, 5.0, 0.0], [0.0, 3.0, 0.0], 10);
    rope.pinned = [true, false];
    rope.particle.damping = 0.5;
    let rope = world.add_rope(rope).unwrap();
    world.particle_mut(rope.particles[10]).expect("there").attach(weight, [0.0, 0.1, 0.0]).unwrap();
    seconds(&mut world, 20);
    let end = world.particle(rope.particles[10]).unwrap();
    assert_eq!(end.attachment().unwrap().0, weight);
    let (pull, top) = (-end.attachment_force().y, world.link(rope.links[0]).unwrap().tension());
    // m g of the body, and of the ten particles below the pinned one, 1/11 kg each.
    assert!((pull - 2.0 * 9.81).abs() < 0.01 * 2.0 * 9.81, "{pull}");
    let all = (2.0 + 10.0 / 11.0) * 9.81;
    assert!((top - all).abs() < 0.01 * all, "{top} {all}");
    // The attachment itself is stiff: the body hangs at the end of the rope.
    let gap = at(&world, rope.particles[10]) - world.body(weight).unwrap().position();
    assert!((gap - vec3(0.0, 0.1, 0.0)).length() < 1.0e-3, "{gap:?}");
}

/// Maximum relative stretch of a link.
fn stretch(world: &World) -> f32 {
    world.links().map(|l| l.distance() / l.length() - 1.0).fold(0.0, f32::max)
}

/// A rope of 2 m and 1 kg with 40 links from a pin at the origin. A box of `ratio` times a
/// particle's mass is at its end, at `end`.
fn loaded(ratio: f32, end: Vec3, kind: LinkKind) -> (World, ParticleId) {
    let mut config = WorldConfig::default();
    config.sleep.enabled = false;
    let mut world = World::new(config).unwrap();
    // Beyond the end, so that the rope does not lie on it.
    let beyond = end * (0.1 / end.length());
    let def = BodyDef::dynamic().with_position(end + beyond).with_mass(ratio / 41.0);
    let weight = world.add_body(def.with_shape(ShapeDef::box_half([0.1; 3]))).unwrap();
    let mut rope = RopeDef::between(Vec3::ZERO, end, 40);
    (rope.pinned, rope.kind) = ([true, false], kind);
    let rope = world.add_rope(rope).unwrap();
    let last = rope.particles[40];
    world.particle_mut(last).expect("there").attach(weight, -beyond).unwrap();
    (world, last)
}

#[test]
fn a_rope_does_not_stretch_under_a_thousand_times_its_particles() {
    for kind in [LinkKind::AtMost, LinkKind::Equal] {
        let (mut world, last) = loaded(1000.0, vec3(0.0, -2.0, 0.0), kind);
        let mut worst = 0.0_f32;
        for _ in 0..300 {
            world.step(DT);
            worst = worst.max(stretch(&world));
        }
        let pull = -world.particle(last).unwrap().attachment_force().y;
        let top = world.links().next().unwrap().tension();
        println!("{kind:?}: {worst}, at the end {}, {pull} N, {top} N", stretch(&world));
        assert!(worst < 0.002, "{kind:?}: {worst}");
        let weight = 1000.0 / 41.0 * 9.81;
        assert!((pull / weight - 1.0).abs() < 0.002, "{kind:?}: {pull} of {weight}");
        let all = weight * 1.04;
        assert!((top / all - 1.0).abs() < 0.002, "{kind:?}: {top} of {all}");
    }
}

#[test]
fn a_heavy_pendulum_on_a_light_rope_keeps_its_length_and_its_energy() {
    let (mut world, last) = loaded(1000.0, vec3(2.0, 0.0, 0.0), LinkKind::AtMost);
    let (mut worst, mut long) = (0.0_f32, 0.0_f32);
    let energy = |world: &World| world.kinetic_energy() + world.potential_energy();
    let start = energy(&world);
    for _ in 0..240 {
        world.step(DT);
        worst = worst.max(stretch(&world));
        long = long.max(at(&world, last).length());
    }
    // The energy of the descent to the lowest point.
    let whole = 1000.0 / 41.0 * 9.81 * 2.0;
    let lost = (start - energy(&world)) / whole;
    println!("{worst}, {long} m, lost {lost}");
    assert!(worst < 0.002 && long < 2.0 * 1.002, "{worst} {long}");
    assert!((-0.001..0.1).contains(&lost), "{lost}");
}

#[test]
fn a_rope_between_pins_that_are_as_far_apart_as_it_is_long_stays_straight() {
    // No finite tension holds a straight rope up: its sag depends on its stiffness.
    let mut config = WorldConfig::default();
    config.sleep.enabled = false;
    let mut world = World::new(config).unwrap();
    let mut def = RopeDef::between([0.0; 3], [2.0, 0.0, 0.0], 20);
    def.pinned = [true, true];
    let rope = world.add_rope(def).unwrap();
    let mut lowest = 0.0_f32;
    for _ in 0..300 {
        world.step(DT);
        lowest = rope.particles.iter().fold(lowest, |y, id| y.min(at(&world, *id).y));
    }
    println!("{lowest} m, {}", stretch(&world));
    assert!(lowest > -0.05 && stretch(&world) < 0.002, "{lowest} {}", stretch(&world));
}

#[test]
fn a_plank_hangs_level_on_two_light_ropes() {
    let mut config = WorldConfig::default();
    config.sleep.enabled = false;
    let mut world = World::new(config).unwrap();
    let def = BodyDef::dynamic().with_position([0.0, -2.05, 0.0]).with_mass(20.0);
    let plank = world.add_body(def.with_shape(ShapeDef::box_half([1.0, 0.05, 0.2]))).unwrap();
    for x in [-0.9, 0.9] {
        let mut rope = RopeDef::between([x, 0.0, 0.0], [x, -2.0, 0.0], 20);
        rope.pinned = [true, false];
        let rope = world.add_rope(rope).unwrap();
        world
            .particle_mut(rope.particles[20])
            .expect("there")
            .attach(plank, [x, 0.05, 0.0])
            .unwrap();
    }
    seconds(&mut world, 5);
    let body = world.body(plank).unwrap();
    println!("{} {:?}", stretch(&world), body.position());
    assert!(stretch(&world) < 0.002, "{}", stretch(&world));
    assert!((body.position().y + 2.05).abs() < 0.004, "{:?}", body.position());
}

#[test]
fn a_slack_chain_pulls_nothing_until_it_is_taut() {
    // The box falls freely by the slack of half a meter, and no further.
    let (mut world, last) = loaded(100.0, vec3(0.0, -1.5, 0.0), LinkKind::AtMost);
    for id in world.links().map(|l| l.id()).collect::<Vec<_>>() {
        world.link_mut(id).expect("there").set_length(0.05);
    }
    let mut low = 0.0_f32;
    for step in 1..=120_u8 {
        world.step(DT);
        let y = at(&world, last).y;
        low = low.min(y);
        let t = f32::from(step) * DT;
        if t < 0.3 {
            // In a velocity-first step the displacement is longer by g h t / 2, with h a fraction
            // of the step.
            let fall = 0.5 * 9.81 * t * t;
            assert!((-1.5 - y - fall).abs() < 0.5 * 9.81 * DT * t + 1.0e-3, "{y} after {t} s");
        }
    }
    assert!(low > -2.0 * 1.005 && low < -1.99, "{low}");
}

#[test]
fn a_box_is_dragged_over_the_floor_by_the_force_of_its_friction() {
    let mut world = World::default();
    let floor = ShapeDef::half_space([0.0, 1.0, 0.0], 0.0).with_friction(0.5);
    world.add_body(BodyDef::fixed().with_shape(floor)).unwrap();
    let def = BodyDef::dynamic().with_position([0.0, 0.1, 0.0]).with_mass(1.0);
    let shape = ShapeDef::box_half([0.2, 0.1, 0.2]).with_friction(0.5);
    let sled = world.add_body(def.with_shape(shape)).unwrap();
    // Horizontal, at the height of the box, held by a hand that moves at 1 m/s.
    let mut rope = RopeDef::between([0.2, 0.1, 0.0], [1.2, 0.1, 0.0], 4);
    rope.mass = 0.05;
    rope.particle.gravity_scale = 0.0;
    rope.pinned = [false, true];
    let rope = world.add_rope(rope).unwrap();
    world.particle_mut(rope.particles[0]).expect("there").attach(sled, [0.2, 0.0, 0.0]).unwrap();
    let hand = rope.particles[4];
    world.particle_mut(hand).unwrap().set_velocity([1.0, 0.0, 0.0]);
    seconds(&mut world, 3);
    let (mut pull, mut way) = (0.0, -world.body(sled).unwrap().position().x);
    for _ in 0..120 {
        world.step(DT);
        pull += world.particle(rope.particles[0]).unwrap().attachment_force().x / 120.0;
    }
    way += world.body(sled).unwrap().position().x;
    assert!((way - 2.0).abs() < 0.02, "{way}");
    assert!((-pull - 0.5 * 9.81).abs() < 0.05 * 0.5 * 9.81, "{pull}");
}

#[test]
fn links_tear_at_their_limit_and_not_below() {
    for (load, tears) in [(0.9_f32, false), (1.1, true)] {
        for by_force in [true, false] {
            let mut config = WorldConfig::default();
            // A creeping body would fall asleep on the way.
            config.sleep.enabled = false;
            let mut world = World::new(config).unwrap();
            let pin = world.add_particle(ParticleDef::at([0.0, 5.0, 0.0]).pinned()).unwrap();
            let def = ParticleDef::at([0.0, 4.0, 0.0]).with_mass(1.0);
            let hung = world.add_particle(ParticleDef { damping: 20.0, ..def }).unwrap();
            // 1 kg on 100 N/m stretches it by 9.81 cm, with a force of 9.81 N.
            let spring = LinkSpring::Rate { stiffness: 100.0, damping: 30.0 };
            let mut link = LinkDef::new(pin, hung, LinkKind::Spring(spring)).with_length(1.0);
            if by_force {
                link.tear_force = Some(9.81 / load);
            } else {
                link.tear_strain = Some(0.0981 / load);
            }
            let id = world.add_link(link).unwrap();
            let mut torn = Vec::new();
            for _ in 0..600 {
                world.step(DT);
                torn.extend_from_slice(&world.events().link_tear);
            }
            assert_eq!(torn.len(), usize::from(tears), "load {load}, by force {by_force}");
            assert_eq!(world.link(id).is_none(), tears);
            if tears {
                assert_eq!((torn[0].link, torn[0].a, torn[0].b), (id, pin, hung));
                // At most at g/c = 0.49 m/s, for seconds.
                assert!(at(&world, hung).y < 3.0, "it falls");
            }
        }
    }
}

/// A wavy cloth held by two corners, after `steps` steps.
fn flag(form: ParticleForm, steps: u32) -> World {
    let mut config = WorldConfig::default();
    (config.particle.form, config.particle.sweeps) = (form, 10);
    config.sleep.enabled = false;
    let mut world = World::new(config).unwrap();
    let mut def = ClothDef::new([0.0, 3.0, 0.0], [Vec3::X, vec3(0.0, -0.8, 0.6)], [8, 8]);
    (def.stretch, def.shear, def.bend) = (LinkKind::Equal, Some(LinkKind::Equal), None);
    let cloth = world.add_cloth(def).unwrap();
    for corner in [0, 8] {
        world.particle_mut(cloth.particles[corner]).unwrap().set_pinned(true);
    }
    for _ in 0..steps {
        world.step(DT);
    }
    world
}

#[test]
fn projecting_positions_is_a_bias_of_one_over_the_substep_to_rounding() {
    // Ten steps of 8 substeps of 10 sweeps: 800 roundings of 3 m (1.2e-7 of it each), which a
    // swinging cloth amplifies by some factor. A different method would differ by g h² = 4e-5 m in
    // every substep.
    let (a, b) = (flag(ParticleForm::Aim, 10), flag(ParticleForm::Verlet, 10));
    let moved = flag(ParticleForm::Aim, 0);
    let (mut worst, mut far) = (0.0_f32, 0.0_f32);
    for ((p, q), start) in a.particles().zip(b.particles()).zip(moved.particles()) {
        worst = worst.max((p.position() - q.position()).length());
        far = far.max((p.position() - start.position()).length());
    }
    println!("{worst} of {far}");
    assert!(far > 0.05 && worst < 2.0e-5, "{worst} of {far}");
}

#[test]
fn threads_and_lanes_are_not_observable() {
    let run = |threads: usize, level: SimdLevel| {
        let mut world = World::default();
        world.set_simd_level(level);
        if threads > 1 {
            world.set_executor(Arc::new(Team::new(threads)));
        }
        let floor = ShapeDef::half_space([0.0, 1.0, 0.0], 0.0);
        world.add_body(BodyDef::fixed().with_shape(floor)).unwrap();
        for i in 0..30_u8 {
            let x = vec3(0.5 * f32::from(i % 6) - 1.25, 0.3 + 0.4 * f32::from(i / 6), 0.1);
            let def = BodyDef::dynamic().with_position(x);
            world.add_body(def.with_shape(ShapeDef::box_half([0.15; 3]))).unwrap();
        }
        let sides = [Vec3::X * 4.0, Vec3::Z * 4.0];
        let cloth = ClothDef::new([-2.0, 2.6, -2.0], sides, [30, 30]);
        world.add_cloth(cloth).unwrap();
        let points = (0..3000_u16)
            .map(|i| vec3(0.004 * f32::from(i % 1000) - 2.0, 3.0 + 0.1 * f32::from(i / 1000), 0.3));
        world.add_cloud(points, ParticleDef::default()).unwrap();
        for _ in 0..90 {
            world.step(DT);
        }
        world.state_hash()
    };
    let expected = run(1, SimdLevel::best());
    for threads in [2, 3, 4] {
        assert_eq!(run(threads, SimdLevel::best()), expected, "{threads} threads");
    }
    for level in SimdLevel::available() {
        assert_eq!(run(1, level), expected, "{}", level.name());
    }
}

#[test]
fn a_clone_goes_on_alike() {
    let mut world = flag(ParticleForm::Soft, 20);
    let mut twin = world.clone();
    seconds(&mut world, 1);
    seconds(&mut twin, 1);
    assert_eq!(world.state_hash(), twin.state_hash());
}

#[test]
fn what_is_wrong_is_refused_and_changes_nothing() {
    let mut world = World::default();
    let a = world.add_particle(ParticleDef::default()).unwrap();
    let b = world.add_particle(ParticleDef::at([1.0, 0.0, 0.0])).unwrap();
    let field = |def: ParticleDef| {
        let error = World::default().add_particle(def).unwrap_err();
        error.field().to_owned()
    };
    assert_eq!(field(ParticleDef::at([f32::NAN, 0.0, 0.0])), "position");
    assert_eq!(field(ParticleDef::default().with_mass(-1.0)), "mass");
    assert_eq!(field(ParticleDef::default().with_mass(0.0)), "mass");
    assert_eq!(field(ParticleDef::default().with_mass(f32::INFINITY)), "mass");
    assert_eq!(field(ParticleDef::default().with_radius(0.0)), "radius");
    assert_eq!(field(ParticleDef { damping: -1.0, ..ParticleDef::default() }), "damping");
    let gravity_scale = f32::NAN;
    assert_eq!(field(ParticleDef { gravity_scale, ..ParticleDef::default() }), "gravity_scale");

    let refused = |world: &mut World, def: LinkDef| world.add_link(def).unwrap_err().to_string();
    let equal = LinkDef::new(a, b, LinkKind::Equal);
    assert!(refused(&mut world, equal.with_length(0.0)).contains("length"));
    assert!(refused(&mut world, equal.with_length(f32::NAN)).contains("length"));
    assert!(refused(&mut world, LinkDef { b: a, ..equal }).contains("other than `a`"));
    assert!(
        refused(&mut world, LinkDef { tear_force: Some(-1.0), ..equal }).contains("tear_force")
    );
    let spring = LinkKind::Spring(LinkSpring::Rate { stiffness: -1.0, damping: 0.0 });
    assert!(refused(&mut world, LinkDef { kind: spring, ..equal }).contains("stiffness"));
    // At one point, without a given length.
    let twin = world.add_particle(ParticleDef::default()).unwrap();
    assert!(refused(&mut world, LinkDef { b: twin, ..equal }).contains("length"));

    assert!(world.remove_particle(twin) && !world.remove_particle(twin));
    assert!(refused(&mut world, LinkDef { b: twin, ..equal }).contains("particle of this world"));
    assert!(world.particle(twin).is_none() && world.particle_mut(twin).is_none());
    let body = world.add_body(BodyDef::dynamic().with_shape(ShapeDef::sphere(0.1))).unwrap();
    let gone = world.add_body(BodyDef::fixed()).unwrap();
    world.remove_body(gone);
    let refused = world.particle_mut(a).expect("there").attach(gone, Vec3::ZERO).unwrap_err();
    assert_eq!(refused.kind(), DefErrorKind::Missing);
    assert!(world.particle_mut(a).expect("there").attach(body, [f32::NAN, 0.0, 0.0]).is_err());
    assert!(!world.particle_mut(a).expect("there").detach());
    let mut moved = world.particle_mut(a).unwrap();
    assert!(moved.set_mass(-2.0).is_err());

    let before = world.counts();
    let ends = (vec3(0.0, 0.0, 0.0), vec3(1.0, 0.0, 0.0));
    assert!(world.add_rope(RopeDef::between(ends.0, ends.1, 0)).is_err());
    assert!(world.add_rope(RopeDef::between(ends.0, ends.0, 5)).is_err());
    let flat = ClothDef::new(Vec3::ZERO, [Vec3::X, Vec3::ZERO], [3, 3]);
    assert!(world.add_cloth(flat).is_err());
    let bad = [Vec3::ZERO, vec3(f32::NAN, 0.0, 0.0)];
    assert!(world.add_cloud(bad, ParticleDef::default()).is_err());
    assert_eq!(world.counts(), before);
}

#[test]
fn what_goes_takes_along_what_hangs_on_it() {
    let mut world = World::default();
    let body = world.add_body(BodyDef::dynamic().with_shape(ShapeDef::sphere(0.1))).unwrap();
    let rope = world.add_rope(RopeDef::between([0.0; 3], [1.0, 0.0, 0.0], 4)).unwrap();
    world.particle_mut(rope.particles[0]).expect("there").attach(body, Vec3::ZERO).unwrap();
    world.particle_mut(rope.particles[4]).expect("there").attach(body, [1.0, 0.0, 0.0]).unwrap();
    world.step(DT);
    assert!(world.remove_particle(rope.particles[2]));
    assert_eq!((world.counts().particles, world.counts().links), (4, 2));
    assert!(world.link(rope.links[1]).is_none() && world.link(rope.links[0]).is_some());
    assert!(world.remove_body(body));
    world.step(DT);
    assert_eq!(world.events().detached, [rope.particles[0], rope.particles[4]]);
    assert!(world.particles().all(|p| p.attachment().is_none()));
    seconds(&mut world, 1);
    // The freed slot is reused, and the old id stays stale.
    let new = world.add_particle(ParticleDef::default()).unwrap();
    assert_eq!(new.index(), rope.particles[2].index());
    assert!(world.particle(rope.particles[2]).is_none());
    assert!(world.remove_link(rope.links[0]) && !world.remove_link(rope.links[0]));
    world.step(DT);
}

#[test]
fn energy_of_particles_is_in_the_books() {
    let mut world = flag(ParticleForm::Soft, 0);
    world.begin_ledger();
    seconds(&mut world, 3);
    let ledger = world.end_ledger().unwrap();
    // 1 kg, with two corners pinned; the swing ends below its start.
    assert!(ledger.now.potential < ledger.start.potential - 0.5, "{ledger:?}");
    assert!(ledger.now.linear >= 0.0 && ledger.impulses.abs() < 1.0e-9, "{ledger:?}");
    // Nothing drives it, so it can only lose energy. The push out of stretched links returns
    // little.
    assert!(ledger.dissipated > -0.01 * 9.81, "{ledger:?}");
}

#[test]
fn strands_at_rest_fall_asleep_and_wake_together() {
    let mut world = World::default();
    let floor = ShapeDef::half_space([0.0, 1.0, 0.0], 0.0);
    world.add_body(BodyDef::fixed().with_shape(floor)).unwrap();
    let mut def = RopeDef::between([0.0, 0.5, 0.0], [1.0, 0.5, 0.0], 10);
    def.particle.damping = 1.0;
    let rope = world.add_rope(def).unwrap();
    seconds(&mut world, 8);
    assert_eq!(world.counts().particles_asleep, 11);
    let before = world.state_hash();
    seconds(&mut world, 1);
    assert_eq!(world.state_hash(), before);
    world.particle_mut(rope.particles[0]).unwrap().apply_impulse([0.0, 0.1, 0.0]);
    world.step(DT);
    assert_eq!(world.counts().particles_asleep, 0);
}
