//! After any calls, a world that rolls back to a stored state continues like one that never left
//! it.

use drystone::World;
use proptest::prelude::{prop, proptest};
use proptest::test_runner::{Config, RngSeed};

use crate::property_snapshot::{Call, Known, call, ground, make};

const DT: f32 = 1.0 / 60.0;

/// Makes a call in both worlds, and compares the results.
fn make_in_both(world: &mut World, twin: &mut World, known: &mut Known, call: Call) {
    let (mut added, mut same) = (Known::default(), Known::default());
    make(world, known, &mut added, call);
    make(twin, known, &mut same, call);
    assert_eq!(same.bodies, added.bodies);
    assert_eq!(twin.state_hash(), world.state_hash(), "after {call:?}");
    assert_eq!(twin.events(), world.events(), "after {call:?}");
    known.learn(added, world);
}

proptest! {
    // The same calls in every run, in debug and release.
    #![proptest_config(Config { cases: 120, rng_seed: RngSeed::Fixed(2), ..Config::default() })]

    /// Cached data of an abandoned future, or of the stored world's previous content, must not
    /// affect the result.
    #[test]
    fn a_world_that_goes_back_to_what_it_kept_does_as_if_it_had_stayed(
        calls in prop::collection::vec(call(), 1..30),
        others in prop::collection::vec(call(), 4),
    ) {
        let (mut world, mut known) = ground();
        let (mut twin, mut kept) = (world.clone(), World::default());
        for (i, call) in calls.into_iter().enumerate() {
            kept.clone_from(&twin);
            // A separate future, which greatly grows the twin's data or leaves it unchanged.
            let mut strange = Known { bodies: known.bodies.clone(), ..Known::default() };
            for other in &others[..i % 5] {
                let mut added = Known::default();
                make(&mut twin, &strange, &mut added, *other);
                strange.learn(added, &twin);
            }
            (0..i % 3).for_each(|_| twin.step(DT));
            twin.clone_from(&kept);
            assert_eq!(twin.sweep_count(), world.sweep_count());
            assert_eq!(twin.contact_residual().to_bits(), world.contact_residual().to_bits());
            make_in_both(&mut world, &mut twin, &mut known, call);
        }
        // The snapshot also covers colors and positions in lists.
        assert!(twin.snapshot() == world.snapshot());
    }
}
