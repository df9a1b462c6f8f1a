//! Stacks of small and thin bodies are as high as their parts: the yield of a contact under a load
//! scales with the size of the bodies.

use drystone::{BodyDef, BodyId, ShapeDef, World};

use crate::floors::{FLOORS, Floor, ground};

/// A stack of bodies of this shape and thickness [m]. The offsets from the middle repeat every
/// three bodies: 0, 1 and 2 times `aside` [m].
fn stack(
    floor: Floor,
    count: u8,
    shape: &ShapeDef,
    thick: f32,
    aside: f32,
) -> (World, Vec<BodyId>) {
    let mut world = World::default();
    ground(&mut world, floor, [1.0, 0.1]);
    let put = |i: u8| {
        let at = [aside * f32::from(i % 3), thick * (0.5 + f32::from(i)), 0.0];
        world.add_body(BodyDef::dynamic().with_position(at).with_shape(shape.clone())).unwrap()
    };
    let things = (0..count).map(put).collect();
    (world, things)
}

/// A card of this thickness and half width [m].
fn card([thick, wide]: [f32; 2]) -> ShapeDef {
    ShapeDef::box_half([wide, 0.5 * thick, 1.4 * wide]).with_density(700.0)
}

/// After 15 s a stack is as high as its bodies within a fiftieth; its top did not move sideways,
/// and sleeps.
fn settles((mut world, things): (World, Vec<BodyId>), [thick, wide]: [f32; 2], floor: Floor) {
    for _ in 0..900 {
        world.step(1.0 / 60.0);
    }
    let top = world.body(things[things.len() - 1]).unwrap();
    let at = top.position();
    let height = at.y / (thick * (things.len() as f32 - 0.5));
    let name = format!("{floor:?}, {} of {thick} m", things.len());
    assert!((height - 1.0).abs() < 0.02, "{name}: {height} of their height");
    assert!(at.x.hypot(at.z) < 0.1 * wide, "{name}: {at:?}");
    assert!(top.is_asleep(), "{name}: awake");
}

/// Each contact is at most a hundredth of half a card's thickness deep, and about the same distance
/// remains to that depth. They fall asleep in this state.
#[test]
fn a_deck_of_cards_is_as_high_as_its_cards() {
    let decks = [
        (1, [0.0003, 0.03]),
        (3, [0.0003, 0.03]),
        (10, [0.002, 0.03]),
        (20, [0.002, 0.03]),
        (52, [0.003, 0.3]),
    ];
    for floor in FLOORS {
        for (count, size) in decks {
            settles(stack(floor, count, &card(size), size[0], 0.0), size, floor);
        }
    }
}

/// Coins and plates. The four deepest points of a rim change with a tilt of a micrometer. (Contacts
/// once lost their impulses with each change: discs sank into each other, and fifteen plates never
/// slept.)
#[test]
fn a_stack_of_discs_is_as_high_as_its_discs() {
    let stacks = [
        (3, [0.0012, 0.012], 0.0),
        (10, [0.0012, 0.012], 0.0),
        (15, [0.01, 0.1], 0.0),
        (15, [0.01, 0.1], 0.001),
        (20, [0.01, 0.1], 0.0),
    ];
    for floor in FLOORS {
        for (count, size @ [thick, radius], aside) in stacks {
            let disc = ShapeDef::cylinder(0.5 * thick, radius);
            settles(stack(floor, count, &disc, thick, aside), size, floor);
        }
    }
}

/// Removing the support of a stack neither throws the rest nor holds it up.
#[test]
fn the_lowest_card_lies_still_when_the_others_go() {
    let (mut world, cards) = stack(Floor::Box, 20, &card([0.002, 0.03]), 0.002, 0.0);
    for _ in 0..600 {
        world.step(1.0 / 60.0);
    }
    for card in &cards[1..] {
        world.remove_body(*card);
    }
    let mut highest = 0.0_f32;
    for _ in 0..60 {
        world.step(1.0 / 60.0);
        highest = highest.max(world.body(cards[0]).unwrap().position().y);
    }
    // The origin of its spring returns with its load, within a step: no higher than intended, and
    // than bodies rest.
    let left = world.body(cards[0]).unwrap().position().y;
    assert!(highest < 0.001 + 4.0 * 0.001, "{highest} m");
    assert!((left - 0.001).abs() < 1.0e-4, "{left} m");
}
