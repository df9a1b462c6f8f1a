//! Hooks that change contacts during a step.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use drystone::contact::{ContactHooks, HookedContact};
use drystone::threads::Team;
use drystone::{BodyDef, BodyId, ShapeDef, Vec3, World};

use crate::floors::square;

const G: f32 = 9.81;
const DT: f32 = 1.0 / 60.0;

/// Disables contacts of odd numbers, and sets the friction of number 2 to 0.2.
#[derive(Default)]
struct Rules {
    asked: AtomicU32,
}

impl ContactHooks for Rules {
    fn contact(&self, contact: &mut HookedContact<'_>) {
        self.asked.fetch_add(1, Ordering::Relaxed);
        let data = contact.user_data_a() | contact.user_data_b();
        assert!(contact.points().count() > 0 && contact.normal().is_finite());
        if data % 2 == 1 {
            contact.drop_contact();
        }
        if data == 2 {
            contact.set_friction(f32::NAN);
            contact.set_friction(0.2);
        }
    }
}

fn floor(kind: &str) -> ShapeDef {
    if kind == "plane" {
        return ShapeDef::half_space(Vec3::Y, 0.0);
    }
    if kind == "box" {
        return ShapeDef::box_half([30.0, 1.0, 30.0]).with_position([0.0, -1.0, 0.0]);
    }
    square(30.0)
}

fn box_with(world: &mut World, z: f32, user_data: u64, hooks: bool) -> BodyId {
    let shape = ShapeDef { user_data, hooks, ..ShapeDef::box_half([0.25; 3]) };
    let body = BodyDef::dynamic().with_position([0.0, 0.25, z]);
    let body = body.with_linear_velocity([3.0, 0.0, 0.0]).with_shape(shape);
    world.add_body(body).unwrap()
}

#[test]
fn hooks_drop_contacts_and_change_friction_for_the_step() {
    for kind in ["plane", "box", "mesh"] {
        let mut world = World::default();
        world.add_body(BodyDef::fixed().with_shape(floor(kind))).unwrap();
        let [plain, ghost, slick, unasked] =
            [(0, true), (1, true), (2, true), (1, false)].map(|(data, hooks)| {
                box_with(&mut world, f32::from(u8::try_from(data).unwrap()) * 2.0, data, hooks)
            });
        let rules = Rules::default();
        for _ in 0..240 {
            world.step_with(DT, &rules);
        }
        let at = |id: BodyId| world.body(id).unwrap().position();
        // v² / (2 μ g), up to the resolution of a step.
        for (id, friction) in [(plain, 0.6), (unasked, 0.6), (slick, 0.2)] {
            let far = 9.0 / (2.0 * friction * G);
            assert!((at(id).x - far).abs() < 3.0 * DT, "{kind}: {} m, {far}", at(id).x);
        }
        assert!(at(ghost).y < -5.0, "{kind}: {:?}", at(ghost));
        assert!(rules.asked.load(Ordering::Relaxed) > 0);
        // Without hooks the surfaces have their own values again.
        world.body_mut(slick).unwrap().set_linear_velocity([3.0, 0.0, 0.0]);
        let start = world.body(slick).unwrap().position().x;
        (0..240).for_each(|_| world.step(DT));
        let way = world.body(slick).unwrap().position().x - start;
        assert!((way - 9.0 / (1.2 * G)).abs() < 3.0 * DT, "{kind}: {way}");
    }
}

#[test]
fn the_answers_give_the_same_bits_on_any_number_of_threads() {
    let run = |threads: usize| {
        let mut world = World::default().with_executor(Arc::new(Team::with_threads(threads)));
        world.add_body(BodyDef::fixed().with_shape(floor("box"))).unwrap();
        for i in 0..200_u16 {
            let [x, y, z] = [i % 6, i / 36, i / 6 % 6].map(f32::from);
            let data = u64::from(i % 7 == 0) * u64::from(i % 3);
            let shape = ShapeDef { user_data: data, ..ShapeDef::box_half([0.25; 3]).with_hooks() };
            let body = BodyDef::dynamic().with_position([0.51 * x, 0.3 + 0.6 * y, 0.51 * z]);
            world.add_body(body.with_shape(shape)).unwrap();
        }
        let rules = Rules::default();
        (0..90).for_each(|_| world.step_with(DT, &rules));
        (world.state_hash(), world.events().clone(), rules.asked.into_inner())
    };
    let one = run(1);
    for threads in [2, 4] {
        assert_eq!(run(threads), one);
    }
}

#[test]
fn a_panic_of_hooks_ends_the_step_whole() {
    struct Breaks;
    impl ContactHooks for Breaks {
        fn contact(&self, _: &mut HookedContact<'_>) {
            panic!("no");
        }
    }
    let mut world = World::default().with_executor(Arc::new(Team::with_threads(3)));
    world.add_body(BodyDef::fixed().with_shape(floor("plane"))).unwrap();
    for i in 0..40_u8 {
        box_with(&mut world, f32::from(i), 0, true);
    }
    let mut twin = world.clone();
    world.step(DT);
    let broken = catch_unwind(AssertUnwindSafe(|| twin.step_with(DT, &Breaks)));
    assert!(broken.is_err());
    assert_eq!(world.state_hash(), twin.state_hash(), "contacts act that nobody could decide over");
    (0..20).for_each(|_| twin.step_with(DT, &Rules::default()));
    assert!(World::restore(&twin.snapshot()).is_ok());
}
