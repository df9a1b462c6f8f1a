//! Rules between pairs: bodies that never collide, and surfaces by layers.

use drystone::contact::SurfaceRule;
use drystone::{BodyDef, BodyId, Filter, ShapeDef, Vec3, World, vec3};

const G: f32 = 9.81;

fn ball_at(world: &mut World, x: f32, y: f32) -> BodyId {
    let ball = BodyDef::dynamic().with_position([x, y, 0.0]).with_shape(ShapeDef::sphere(0.5));
    world.add_body(ball).unwrap()
}

fn steps(world: &mut World, n: u32) -> [usize; 2] {
    let mut counts = [0; 2];
    for _ in 0..n {
        world.step(1.0 / 60.0);
        counts[0] += world.events().contact_begin.len();
        counts[1] += world.events().contact_end.len();
    }
    counts
}

#[test]
fn bodies_that_never_collide_pass_each_other_and_meet_again_when_they_may() {
    let mut world = World::default();
    let floor = BodyDef::fixed().with_shape(ShapeDef::half_space(Vec3::Y, 0.0));
    let floor = world.add_body(floor).unwrap();
    let low = ball_at(&mut world, 0.0, 0.5);
    let high = ball_at(&mut world, 0.0, 1.5);
    assert_eq!(steps(&mut world, 60), [2, 0]);
    assert!(world.bodies_collide(low, high));
    assert!(world.set_bodies_collide(high, low, false));
    assert!(!world.bodies_collide(low, high));
    let mut again = World::restore(&world.snapshot()).unwrap();
    // The upper body falls through the lower one, to the floor.
    assert_eq!(steps(&mut world, 90), [1, 1]);
    assert_eq!(steps(&mut again, 90), [1, 1]);
    assert_eq!(world.state_hash(), again.state_hash());
    let y = world.body(high).unwrap().position().y;
    assert!((y - 0.5).abs() < 0.01, "{y}");
    world.set_bodies_collide(low, high, true);
    // They overlap, and separate.
    steps(&mut world, 240);
    let at = |id: BodyId| world.body(id).unwrap().position();
    let apart = (at(low) - at(high)).length();
    assert!(apart > 0.99, "{apart}");
    // A removed body's rules do not apply to the next body in its slot.
    world.set_bodies_collide(low, floor, false);
    world.remove_body(low);
    assert!(!world.set_bodies_collide(low, floor, false));
    assert!(!world.set_bodies_collide(high, high, false));
    let next = ball_at(&mut world, 9.0, 0.5);
    steps(&mut world, 60);
    assert!(world.body(next).unwrap().position().y > 0.45);
}

#[test]
fn a_fast_body_passes_what_it_never_collides_with() {
    for collide in [true, false] {
        let mut world = World::default();
        let wall = BodyDef::fixed().with_shape(ShapeDef::box_half([0.05, 2.0, 2.0]));
        let wall = world.add_body(wall).unwrap();
        let shot = BodyDef::dynamic()
            .with_position([-3.0, 0.0, 0.0])
            .with_linear_velocity([200.0, 0.0, 0.0])
            .with_shape(ShapeDef::sphere(0.05));
        let shot = world.add_body(shot).unwrap();
        world.set_bodies_collide(wall, shot, collide);
        steps(&mut world, 10);
        let x = world.body(shot).unwrap().position().x;
        assert_eq!(x < 0.0, collide, "{x}");
    }
}

/// Distance that a box slides from 3 m/s [m].
fn slide(rules: Vec<SurfaceRule>, layers: [u64; 2], late: bool) -> f32 {
    let mut world = World::default();
    if !late {
        world.set_surface_rules(rules.clone()).unwrap();
    }
    let filter = |layers: u64| Filter { layers, ..Filter::default() };
    let floor = ShapeDef::half_space(Vec3::Y, 0.0).with_filter(filter(layers[0]));
    world.add_body(BodyDef::fixed().with_shape(floor)).unwrap();
    let body = BodyDef::dynamic().with_position([0.0, 0.25, 0.0]);
    let shape = ShapeDef::box_half([0.25; 3]).with_filter(filter(layers[1]));
    let id = world.add_body(body.with_shape(shape)).unwrap();
    steps(&mut world, 20);
    if late {
        world.set_surface_rules(rules).unwrap();
    }
    world.body_mut(id).unwrap().set_linear_velocity([3.0, 0.0, 0.0]);
    steps(&mut world, 300);
    world.body(id).unwrap().position().x
}

#[test]
fn surfaces_of_layers_rub_as_their_rule_says() {
    let (ice, rubber) = (1 << 1, 1 << 2);
    let rule = |f: f32| SurfaceRule { friction: Some(f), ..SurfaceRule::between(ice, rubber) };
    // v² / (2 μ g), less the effect of the first half step.
    let far = |f: f32| 9.0 / (2.0 * f * G);
    for (rules, layers, friction) in [
        (vec![], [ice, rubber], 0.6),
        (vec![rule(0.2)], [ice, rubber], 0.2),
        (vec![rule(0.2)], [rubber, ice], 0.2),
        (vec![rule(0.2)], [ice, ice], 0.6),
        (vec![rule(0.2), rule(0.9)], [ice | 1, rubber], 0.2),
    ] {
        for late in [false, true] {
            let way = slide(rules.clone(), layers, late);
            let off = (way - far(friction)).abs();
            assert!(off < 3.0 / 60.0, "{rules:?} {layers:?}: {way} m, {} m", far(friction));
        }
    }
    let mut world = World::default();
    world.set_surface_rules(vec![rule(0.2)]).unwrap();
    let error = world.set_surface_rules(vec![rule(-1.0)]).unwrap_err().to_string();
    assert!(error.contains("friction"), "{error}");
    assert!(world.set_surface_rules(vec![rule(0.1); 257]).is_err());
    assert_eq!(world.surface_rules(), [rule(0.2)]);
    assert_eq!(World::restore(&world.snapshot()).unwrap().surface_rules(), [rule(0.2)]);
}

#[test]
fn a_rule_follows_the_layers_of_a_shape() {
    let mut world = World::default();
    let bouncy = SurfaceRule { restitution: Some(0.9), ..SurfaceRule::between(1, 2) };
    world.set_surface_rules(vec![bouncy]).unwrap();
    world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space(Vec3::Y, 0.0))).unwrap();
    let id = ball_at(&mut world, 0.0, 0.5);
    steps(&mut world, 10);
    let shape = world.body(id).unwrap().shapes().next().unwrap();
    let filter = Filter { layers: 2, ..Filter::default() };
    world.shape_mut(shape).unwrap().set_filter(filter);
    world.body_mut(id).unwrap().set_linear_velocity(vec3(0.0, -4.0, 0.0));
    steps(&mut world, 1);
    let v = world.body(id).unwrap().linear_velocity().y;
    assert!((v - 3.6).abs() < 0.3, "{v}");
}
