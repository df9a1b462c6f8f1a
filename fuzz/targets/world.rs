//! Snapshots of worlds with a corrected checksum: a snapshot that is accepted must step and be
//! readable again.

#![no_main]

mod seeds;

use drystone::World;
use libfuzzer_sys::fuzz_target;

/// Magic, version, checksum.
const HEADER: usize = 8 + 4 + 8;

const SCENES: [&str; 7] =
    ["hello", "stack:n=2", "cradle:balls=2", "rope", "fracture", "gears", "ragdolls:n=1"];

fn write_seeds() {
    let Some(folder) = seeds::folder() else { return };
    for name in SCENES {
        seeds::write(&folder, name, &seeds::running(name).world.snapshot());
    }
}

fuzz_target!(init: write_seeds(), |bytes: &[u8]| {
    let own = World::default().snapshot();
    let body = if bytes.starts_with(&own[..8]) { &bytes[HEADER.min(bytes.len())..] } else { bytes };
    let mut snapshot = own[..12].to_vec();
    snapshot.extend(checksum(body).to_le_bytes());
    snapshot.extend(body);
    let Ok(mut world) = World::restore(&snapshot) else { return };
    for _ in 0..20 {
        world.step(1.0 / 60.0);
    }
    World::restore(&world.snapshot()).expect("a world reads its own snapshot");
});

/// The engine's checksum.
fn checksum(bytes: &[u8]) -> u64 {
    let mut hash = 0x9e37_79b9_7f4a_7c15_u64;
    let mut word = |w: u32| {
        hash = (hash ^ u64::from(w)).wrapping_mul(0xff51_afd7_ed55_8ccd).rotate_left(31);
    };
    let (words, rest) = bytes.as_chunks::<4>();
    words.iter().for_each(|w| word(u32::from_le_bytes(*w)));
    rest.iter().for_each(|b| word(u32::from(*b)));
    hash = (hash ^ (hash >> 33)).wrapping_mul(0xc4ce_b9fe_1a85_ec53);
    hash ^ (hash >> 29)
}
