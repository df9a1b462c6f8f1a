//! `cargo xtask roofline`: the limits of this machine, for docs/roofline.md. It uses one thread;
//! take the best of several runs on a quiet machine, built with `--release`.
//!
//! Compiled for the target's baseline: on x86-64 that is SSE2, four numbers at a time. With AVX the
//! arithmetic doubles; bandwidth beyond the first cache does not change.

use std::hint::black_box;
use std::time::Instant;

/// Independent numbers processed together: enough to hide the latency of an addition.
const LANES: usize = 64;

/// Sizes of the sets that are read repeatedly [bytes]: within L2, around it, in L3, beyond.
const SETS: [usize; 5] = [256 << 10, 700 << 10, 2 << 20, 5 << 20, 64 << 20];

/// Bytes read in total for each set.
const TRAFFIC: usize = 1 << 30;

/// Prints bandwidths and arithmetic throughput.
pub fn run() {
    if cfg!(debug_assertions) {
        println!("built for debugging: these numbers mean nothing, use --release");
    }
    for bytes in SETS {
        println!("read {:6} KB again and again: {:5.1} GB/s", bytes >> 10, bandwidth(bytes));
    }
    println!("multiply and add, independent: {:5.1} Gflop/s", arithmetic());
}

/// GB/s when reading a set of this size.
#[expect(clippy::cast_precision_loss, reason = "counts far below 2^52")]
fn bandwidth(bytes: usize) -> f64 {
    let set = vec![1.0_f32; bytes / 4];
    let rounds = (TRAFFIC / bytes).max(1);
    let mut best = f64::INFINITY;
    for _ in 0..3 {
        let start = Instant::now();
        let mut sums = [0.0_f32; LANES];
        for _ in 0..rounds {
            for chunk in black_box(&set).chunks_exact(LANES) {
                for (sum, value) in sums.iter_mut().zip(chunk) {
                    *sum += value;
                }
            }
        }
        black_box(sums);
        best = best.min(start.elapsed().as_secs_f64());
    }
    (rounds * bytes) as f64 / best * 1.0e-9
}

/// Gflop/s of independent multiplications and additions.
#[expect(clippy::cast_precision_loss, reason = "counts far below 2^52")]
fn arithmetic() -> f64 {
    const ROUNDS: usize = 20_000_000;
    const WIDTH: usize = 32;
    let mut best = f64::INFINITY;
    for _ in 0..3 {
        let (scale, step) = (black_box(0.999_f32), black_box(1.0e-3_f32));
        let mut values = [1.0_f32; WIDTH];
        let start = Instant::now();
        for _ in 0..ROUNDS {
            for value in &mut values {
                *value = *value * scale + step;
            }
        }
        best = best.min(start.elapsed().as_secs_f64());
        black_box(values);
    }
    (2 * ROUNDS * WIDTH) as f64 / best * 1.0e-9
}
