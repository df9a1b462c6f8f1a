//! A trigger counts bodies that move, sleep, are static or were there before, and those that leave.

use drystone::{BodyDef, BodyId, Pose, ShapeDef, ShapeId, World, events::Senses};
use std::collections::BTreeSet;

/// Takes some steps and compares the bodies in the trigger from a query with those from its events.
fn run(world: &mut World, zone: ShapeId, heard: &mut BTreeSet<ShapeId>) -> BTreeSet<BodyId> {
    for _ in 0..120 {
        world.step(1.0 / 60.0);
        heard.extend(world.events().sensor_enter.iter().map(|event| event.visitor));
        world.events().sensor_exit.iter().for_each(|event| _ = heard.remove(&event.visitor));
    }
    let inside: BTreeSet<_> = world.shape(zone).iter().flat_map(|z| z.sensor_overlaps()).collect();
    assert_eq!(&inside, heard, "events say the same");
    inside.iter().filter_map(|shape| world.shape(*shape)).map(|shape| shape.body()).collect()
}

#[expect(clippy::print_stdout, reason = "an example shows what it does")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut world = World::default();
    world.add_body(BodyDef::fixed().with_shape(ShapeDef::half_space([0.0, 1.0, 0.0], 0.0)))?;
    let cube = |x: f32| ShapeDef::box_half([0.2; 3]).with_position([x, 0.0, 0.0]);
    let put = |def: BodyDef, x: f32| def.with_position([x, 0.2, 0.0]).with_shape(cube(0.0));
    let early = world.add_body(put(BodyDef::dynamic(), -1.0))?;
    (0..120).for_each(|_| world.step(1.0 / 60.0));
    assert!(world.body(early).is_some_and(|body| body.is_asleep()));
    let body = world.add_body(BodyDef::fixed().with_position([0.0, 1.0, 0.0]))?;
    let (zone, senses) =
        (ShapeDef::box_half([2.0, 0.9, 2.0]), Senses { statics: true, sensors: false });
    let zone = world.add_shape(body, zone.as_sensor().with_senses(senses))?;
    let fixed = world.add_body(put(BodyDef::fixed(), 1.5))?;
    let driven = world.add_body(put(BodyDef::kinematic(), 0.7))?;
    let born = world.add_body(put(BodyDef { asleep: true, ..BodyDef::dynamic() }, -0.2))?;
    let double = world.add_body(put(BodyDef::dynamic(), -1.85).with_shape(cube(0.4)))?;
    let (mut heard, all) = (BTreeSet::new(), BTreeSet::from([early, fixed, driven, born, double]));
    assert_eq!(run(&mut world, zone, &mut heard), all);
    println!("{} bodies with {} shapes are in the trigger", all.len(), heard.len());
    world.remove_body(born);
    world.body_mut(double).ok_or("no body")?.set_pose(Pose::at([9.0, 0.2, 0.0]));
    world.body_mut(fixed).ok_or("no body")?.set_pose(Pose::at([12.0, 0.2, 0.0]));
    assert_eq!(run(&mut world, zone, &mut heard), BTreeSet::from([early, driven]));
    world.body_mut(body).ok_or("no trigger")?.set_pose(Pose::at([50.0, 1.0, 0.0]));
    assert!(run(&mut world, zone, &mut heard).is_empty(), "the trigger went away");
    Ok(())
}
