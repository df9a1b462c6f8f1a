//! Small and thin things that lie on each other are as high as their parts: what a contact gives under a load follows the size of what lies
//! there.

use drystone::{BodyDef, BodyId, ShapeDef, World};

use crate::floors::{FLOORS, Floor, ground};

/// Cards of this thickness and half width [m], one on the other.
fn cards(floor: Floor, count: u8, [thick, wide]: [f32; 2]) -> (World, Vec<BodyId>) {
    let mut world = World::default();
    ground(&mut world, floor, [1.0, 0.1]);
    let card = |i: u8| {
        let shape = ShapeDef::box_half([wide, 0.5 * thick, 1.4 * wide]).with_density(700.0);
        let def = BodyDef::dynamic().with_position([0.0, thick * (0.5 + f32::from(i)), 0.0]);
        world.add_body(def.with_shape(shape)).unwrap()
    };
    let cards = (0..count).map(card).collect();
    (world, cards)
}

/// Each contact is at most a hundredth of half a card's thickness deep, and about so much is left of the way there. They fall asleep so.
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
        for (count, [thick, wide]) in decks {
            let (mut world, cards) = cards(floor, count, [thick, wide]);
            for _ in 0..900 {
                world.step(1.0 / 60.0);
            }
            let top = world.body(cards[cards.len() - 1]).unwrap();
            let at = top.position();
            let height = at.y / (thick * (f32::from(count) - 0.5));
            let name = format!("{floor:?}, {count} of {thick} m");
            assert!((height - 1.0).abs() < 0.02, "{name}: {height} of their height");
            assert!(at.x.hypot(at.z) < 0.1 * wide, "{name}: {at:?}");
            assert!(top.is_asleep(), "{name}: awake");
        }
    }
}

/// Coins and plates: of a disc that leans by a micrometer any four places of its rim may be the ones that count. (They lost what they bore
/// with each change, sank into each other, and fifteen plates never slept.)
#[test]
fn a_stack_of_discs_is_as_high_as_its_discs() {
    let stacks = [
        (3, [0.0012, 0.012], 0.0),
        (10, [0.0012, 0.012], 0.0),
        (15, [0.01, 0.1], 0.0),
        (15, [0.01, 0.1], 0.01),
        (20, [0.01, 0.1], 0.0),
    ];
    for floor in FLOORS {
        for (count, [thick, radius], aside) in stacks {
            let mut world = World::default();
            ground(&mut world, floor, [1.0, 0.1]);
            let disc = |i: u8| {
                let at = [aside * radius * f32::from(i % 3), thick * (0.5 + f32::from(i)), 0.0];
                let shape = ShapeDef::cylinder(0.5 * thick, radius);
                world.add_body(BodyDef::dynamic().with_position(at).with_shape(shape)).unwrap()
            };
            let discs: Vec<BodyId> = (0..count).map(disc).collect();
            for _ in 0..900 {
                world.step(1.0 / 60.0);
            }
            let top = world.body(discs[discs.len() - 1]).unwrap();
            let at = top.position();
            let height = at.y / (thick * (f32::from(count) - 0.5));
            let name = format!("{floor:?}, {count} of {thick} m");
            assert!((height - 1.0).abs() < 0.02, "{name}: {height} of their height");
            assert!(at.x.hypot(at.z) < 0.1 * radius, "{name}: {at:?}");
            assert!(top.is_asleep(), "{name}: awake");
        }
    }
}

/// What bears a stack that is taken away does not throw what is left, nor hold it up.
#[test]
fn the_lowest_card_lies_still_when_the_others_go() {
    let (mut world, cards) = cards(Floor::Box, 20, [0.002, 0.03]);
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
    // The surface that its spring starts from goes back with its load, in a step: no higher than it was to be, and than things rest.
    let left = world.body(cards[0]).unwrap().position().y;
    assert!(highest < 0.001 + 4.0 * 0.001, "{highest} m");
    assert!((left - 0.001).abs() < 1.0e-4, "{left} m");
}
