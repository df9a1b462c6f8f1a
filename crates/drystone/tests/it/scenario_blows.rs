//! A body without restitution stays where it falls: on the ground, on other bodies, and with bodies
//! on top of it. The impulse that stops an impact acts only once.

use drystone::{BodyDef, BodyId, ShapeDef, Vec3, World, vec3};

use crate::floors::{FLOORS, Floor, ground};

const GRAVITY: f32 = 9.81;

/// A stack of cubes with lower faces at these heights, in sizes.
fn pile(size: f32, floor: Floor, sleeps: bool, heights: &[f32]) -> (World, Vec<BodyId>) {
    let mut world = World::default();
    let mut config = world.config().clone();
    config.length_scale = size;
    config.sleep.enabled = sleeps;
    world.set_config(config).unwrap();
    ground(&mut world, floor, [10.0 * size, size]);
    let cube = |height: &f32| {
        let shape = ShapeDef::box_half([0.5 * size; 3]);
        let def = BodyDef::dynamic().with_position([0.0, (height + 0.5) * size, 0.0]);
        world.add_body(def.with_shape(shape)).unwrap()
    };
    let cubes = heights.iter().map(cube).collect();
    (world, cubes)
}

/// Maximum upward speed during the time of a fall by three sizes [m/s].
fn rises(world: &mut World, bodies: &[BodyId], size: f32, hertz: f32) -> f32 {
    let mut left = (6.0 * size / GRAVITY).sqrt() + 0.5 * size.sqrt();
    let mut most = 0.0_f32;
    while left > 0.0 {
        world.step(1.0 / hertz);
        left -= 1.0 / hertz;
        for body in bodies {
            most = most.max(world.body(*body).unwrap().linear_velocity().y);
        }
    }
    most
}

/// A cube falls on a cube, two fall on the ground together, two on two, and one on four. The
/// compressed bodies separate no faster than contacts push, and those in a stack push together.
#[test]
fn what_does_not_bounce_stays_down() {
    let worlds = [
        (1.0, 60.0),
        (1.0, 30.0),
        (1.0, 120.0),
        (0.1, 60.0),
        (0.1, 240.0),
        (0.01, 240.0),
        (10.0, 60.0),
        (100.0, 30.0),
    ];
    let piles: [&[f32]; 4] =
        [&[0.0, 2.0], &[1.0, 2.0], &[0.0, 1.0, 2.5, 3.5], &[0.0, 1.0, 2.0, 3.0, 5.0]];
    for (size, hertz) in worlds {
        for (floor, sleeps) in FLOORS.into_iter().flat_map(|floor| [(floor, true), (floor, false)])
        {
            for heights in piles {
                let (mut world, cubes) = pile(size, floor, sleeps, heights);
                let push = world.config().contact.push_speed * size;
                let most = push * heights.len() as f32;
                let up = rises(&mut world, &cubes, size, hertz);
                let name = format!("{size} m, {hertz} Hz, {floor:?}, {heights:?}");
                assert!(up <= most, "{name}: {up} of {most} m/s");
            }
        }
    }
}

/// A bouncing ball leaves a crate without restitution at rest on the ground.
#[test]
fn a_crate_that_a_ball_bounces_off_stays_down() {
    let (mut world, crates) = pile(1.0, Floor::Box, true, &[0.0]);
    let ball = BodyDef::dynamic().with_position([0.0, 2.3, 0.0]);
    world.add_body(ball.with_shape(ShapeDef::sphere(0.3).with_restitution(0.5))).unwrap();
    let up = rises(&mut world, &crates, 1.0, 60.0);
    assert!(up <= world.config().contact.push_speed, "{up} m/s");
}

/// Thirty dominoes with a thickness of an eighth of their height and a spacing of half, the first
/// of which falls. Returns the wave speed in the middle over √(g h), and the maximum depth in the
/// floor over the height.
fn dominoes(height: f32, hertz: f32) -> (f32, f32) {
    let half = vec3(height / 16.0, height / 2.0, height / 4.0);
    let pitch = 0.5 * height;
    let mut world = World::default();
    let floor = ShapeDef::half_space([0.0, 1.0, 0.0], 0.0);
    world.add_body(BodyDef::fixed().with_shape(floor)).unwrap();
    let pieces: Vec<BodyId> = (0..30_u8)
        .map(|i| {
            let at = [pitch * f32::from(i), half.y, 0.0];
            let mut def = BodyDef::dynamic().with_position(at).with_shape(ShapeDef::box_half(half));
            if i == 0 {
                // It rotates about its lower edge.
                let spin = 2.0 * (GRAVITY / height).sqrt();
                let speed = [spin * half.y, spin * half.x, 0.0];
                def = def.with_angular_velocity([0.0, 0.0, -spin]).with_linear_velocity(speed);
            }
            world.add_body(def).unwrap()
        })
        .collect();
    let mut fell = [None; 30];
    let (mut deepest, mut time) = (0.0_f32, 0.0);
    while time < 40.0 * (height / GRAVITY).sqrt() {
        world.step(1.0 / hertz);
        time += 1.0 / hertz;
        for (piece, fell) in pieces.iter().zip(&mut fell) {
            let body = world.body(*piece).unwrap();
            let up = |axis: Vec3| body.rotation().rotate(axis).y;
            let reach = [Vec3::X * half.x, Vec3::Y * half.y, Vec3::Z * half.z].map(|a| up(a).abs());
            deepest = deepest.max(reach.iter().sum::<f32>() - body.position().y);
            if fell.is_none() && up(Vec3::Y) < 0.94 {
                *fell = Some(time);
            }
        }
    }
    let [first, last] = [fell[10], fell[25]].map(|time| time.unwrap_or(f32::NAN));
    assert!(fell.iter().all(Option::is_some), "{height} m, {hertz} Hz: {fell:?}");
    (15.0 * pitch / (last - first) / (GRAVITY * height).sqrt(), deepest / height)
}

/// Dominoes of any size fall alike, even if one falls per step. The wave speed equals that of steps
/// of 1/480 s within a tenth, and no domino is pressed into the floor.
#[test]
fn dominoes_fall_alike_in_all_sizes() {
    let rows = [
        (0.02, 60.0),
        (0.05, 30.0),
        (0.05, 60.0),
        (0.1, 30.0),
        (0.1, 60.0),
        (0.2, 60.0),
        (1.0, 30.0),
        (1.0, 60.0),
        (10.0, 60.0),
    ];
    for (height, hertz) in rows {
        let (fine, _) = dominoes(height, 480.0);
        let (speed, depth) = dominoes(height, hertz);
        let name = format!("{height} m, {hertz} Hz");
        assert!((speed / fine - 1.0).abs() < 0.1, "{name}: {speed}, in fine steps {fine}");
        assert!(depth < 0.01, "{name}: {depth} of its height in the floor");
    }
}
