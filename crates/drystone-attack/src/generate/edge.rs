//! Numbers at the bounds of their fields and beyond, in an otherwise ordinary program.

use crate::numbers;
use crate::op::{Op, Program};
use crate::rng::Rng;

/// Bounds of various fields, and the extremes of `f32`.
const BOUNDS: [f32; 22] = [
    0.0,
    1.0e-45,
    1.0e-40,
    f32::MIN_POSITIVE,
    1.0e-20,
    1.0e-9,
    1.0e-6,
    1.0e-5,
    1.0e-4,
    1.0e-3,
    0.1,
    1.0,
    10.0,
    64.0,
    1.0e3,
    1.0e5,
    1.0e6,
    1.0e7,
    1.0e9,
    1.0e20,
    f32::MAX,
    f32::INFINITY,
];

/// An extreme number: a bound or its neighbor, of either sign; occasionally NaN.
pub fn number(rng: &mut Rng) -> f32 {
    if rng.chance(0.03) {
        return f32::NAN;
    }
    let bound = rng.pick(&BOUNDS);
    let value = match rng.below(4) {
        0 => bound.next_up(),
        1 => bound.next_down(),
        _ => bound,
    };
    if rng.chance(0.25) { -value } else { value }
}

/// Replaces some numbers by extreme ones.
pub(super) fn mutate(program: &mut Program, rng: &mut Rng) {
    if rng.chance(0.15) {
        one_of(rng, |f| numbers::of_config(&mut program.config, f));
    }
    let with_numbers: Vec<usize> = (0..program.ops.len())
        .filter(|i| {
            let mut count = 0;
            numbers::of_op(&mut program.ops[*i], &mut |_| count += 1);
            count > 0 && !matches!(program.ops[*i], Op::Step(..))
        })
        .collect();
    if with_numbers.is_empty() {
        return;
    }
    for _ in 0..rng.from_to(1, 3) {
        let at = rng.pick(&with_numbers);
        one_of(rng, |f| numbers::of_op(&mut program.ops[at], f));
    }
}

/// Replaces one of the numbers that `visit` passes on, or occasionally all of them.
fn one_of(rng: &mut Rng, mut visit: impl FnMut(numbers::Visit<'_>)) {
    let mut count = 0;
    visit(&mut |_| count += 1);
    let (at, value) = (rng.below(count), number(rng));
    let everywhere = rng.chance(0.03);
    let mut i = 0;
    visit(&mut |x| {
        if everywhere || i == at {
            *x = value;
        }
        i += 1;
    });
}
