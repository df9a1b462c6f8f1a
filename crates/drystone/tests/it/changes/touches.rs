//! Changes of shapes' reports during a touch: the events must still describe the touching pairs.

use drystone::breakage::Fracture;
use drystone::events::{ContactReports, Senses};
use drystone::{BodyDef, BodyKind, ShapeDef, ShapeId, World};

use super::{DT, FLOORS, Floor, Stack, Touches, floor, shape_of};

fn report(world: &mut World, shape: ShapeId, touches: bool) {
    let reports = ContactReports { touches, ..ContactReports::default() };
    world.shape_mut(shape).unwrap().set_reports(reports).unwrap();
}

/// Numbers of begin and end events in a step.
fn told(world: &mut World) -> [usize; 2] {
    world.step(DT);
    let events = world.events();
    [events.contact_begin.len(), events.contact_end.len()]
}

#[test]
fn touches_under_way_end_and_begin_for_who_follows_the_events() {
    for under in FLOORS {
        for asleep in [false, true] {
            let mut stack = Stack::new(under, 1.0, BodyKind::Dynamic);
            if asleep {
                stack = stack.asleep();
            }
            let (world, cube) = (&mut stack.world, stack.cubes[1]);
            let shape = shape_of(world, cube);
            report(world, shape, false);
            assert_eq!(told(world), [0, 2], "{under:?}: it tells no longer of the two it touches");
            assert_eq!(told(world), [0, 0]);
            report(world, shape, true);
            assert_eq!(told(world), [2, 0], "{under:?}: it tells of them again");
            // A change that is reversed before the step has no effect.
            report(world, shape, false);
            report(world, shape, true);
            assert_eq!(told(world), [0, 0]);
            report(world, shape, false);
            assert_eq!(told(world), [0, 2]);
            report(world, shape, true);
            report(world, shape, false);
            assert_eq!(told(world), [0, 0]);
            // If one shape disables reports, the pair is silent whatever the other shape's setting.
            let above = shape_of(world, stack.cubes[2]);
            report(world, above, false);
            assert_eq!(told(world), [0, 1], "of the cube above that");
            report(world, shape, true);
            assert_eq!(told(world), [1, 0], "of the cube below");
        }
    }
}

#[test]
fn a_touch_that_is_told_and_ends_before_the_step_is_not_told_at_all() {
    let mut stack = Stack::new(Floor::Box, 1.0, BodyKind::Dynamic);
    let top = stack.cubes[4];
    let shape = shape_of(&stack.world, top);
    report(&mut stack.world, shape, false);
    assert_eq!(told(&mut stack.world), [0, 1]);
    report(&mut stack.world, shape, true);
    let mut twin = World::restore(&stack.world.snapshot()).unwrap();
    for world in [&mut stack.world, &mut twin] {
        assert!(world.remove_body(top));
        assert_eq!(told(world), [0, 0]);
    }
    // The same if the touch ends in the step.
    let top = stack.cubes[3];
    let shape = shape_of(&stack.world, top);
    report(&mut stack.world, shape, false);
    assert_eq!(told(&mut stack.world), [0, 1]);
    report(&mut stack.world, shape, true);
    stack.world.body_mut(top).unwrap().set_pose(drystone::Pose::at([30.0, 9.0, 0.0]));
    assert_eq!(told(&mut stack.world), [0, 0]);
    // A refused step still reports earlier changes.
    let below = shape_of(&stack.world, stack.cubes[2]);
    report(&mut stack.world, below, false);
    stack.world.step(0.0);
    assert_eq!(stack.world.events().contact_end.len(), 1);
}

/// Found by the attack: a floor that reported a touch, and then stopped reporting, under a body
/// that broke.
#[test]
fn what_breaks_over_a_floor_that_tells_no_longer_leaves_no_touch() {
    let mut world = World::default();
    let ground = floor(&mut world, Floor::Box, 1.0);
    let vase = BodyDef::dynamic().with_position([0.0, 0.5, 0.0]);
    let vase = vase.with_fracture(Fracture::by_impulse(1.0e4).with_pieces(4));
    let vase = world.add_body(vase.with_shape(ShapeDef::box_half([0.5; 3]))).unwrap();
    let mut touches = Touches::default();
    let follow = |world: &mut World, touches: &mut Touches| {
        world.step(DT);
        touches.follow(world, "vase");
    };
    (0..20).for_each(|_| follow(&mut world, &mut touches));
    assert_eq!(touches.contacts.len(), 1);
    let shape = shape_of(&world, ground);
    report(&mut world, shape, false);
    world.body_mut(vase).unwrap().apply_impulse([0.0, -5.0e4, 0.0]);
    (0..10).for_each(|_| follow(&mut world, &mut touches));
    assert!(world.body(vase).is_none_or(|vase| vase.mass() < 1000.0), "it broke");
    let gone = |pair: &[ShapeId; 2]| pair.iter().any(|shape| world.shape(*shape).is_none());
    assert!(!touches.contacts.iter().any(gone), "{:?}", touches.contacts);
    assert!(!touches.contacts.iter().any(|pair| pair.contains(&shape)));
}

/// Found by the attack: a body made static inside a sensor, or a sensor made static, and then
/// removed.
#[test]
fn what_becomes_static_leaves_the_sensors_that_see_no_static_shapes() {
    for sees in [false, true] {
        for of_sensor in [false, true] {
            for removed in [false, true] {
                let of =
                    format!("sees static shapes: {sees}, the sensor turns: {of_sensor}, {removed}");
                let mut world = World::default();
                let senses = Senses { statics: sees, sensors: false };
                let gate = ShapeDef { senses, ..ShapeDef::box_half([1.0; 3]).as_sensor() };
                let ball = BodyDef::kinematic().with_shape(ShapeDef::sphere(0.5));
                let kind = |turns| if turns { BodyKind::Kinematic } else { BodyKind::Static };
                let gate = BodyDef { kind: kind(of_sensor), ..BodyDef::default() }.with_shape(gate);
                let ball = BodyDef { kind: kind(!of_sensor), ..ball };
                let [gate, ball] = [gate, ball].map(|def| world.add_body(def).unwrap());
                let turned = if of_sensor { gate } else { ball };
                let mut touches = Touches::default();
                let mut inside = |world: &mut World| {
                    world.step(DT);
                    touches.follow(world, &of);
                    touches.visits.values().sum::<i32>()
                };
                assert_eq!(inside(&mut world), 1, "{of}");
                world.body_mut(turned).unwrap().set_kind(BodyKind::Static).unwrap();
                if removed {
                    assert!(world.remove_body(ball));
                }
                let seen = i32::from(sees && !removed);
                assert_eq!(inside(&mut world), seen, "{of}");
                if removed {
                    continue;
                }
                world.body_mut(turned).unwrap().set_kind(BodyKind::Kinematic).unwrap();
                assert_eq!(inside(&mut world), 1, "{of}");
                assert!(world.remove_body(gate));
                assert_eq!(inside(&mut world), 0, "{of}");
            }
        }
    }
}
