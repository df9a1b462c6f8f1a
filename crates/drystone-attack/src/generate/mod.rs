//! Generates programs from seeds, by style and subject.

mod bodies;
mod calls;
mod config;
mod draw;
mod edge;
mod joints;
mod particles;
mod queries;
mod shapes;

pub use self::edge::number as extreme_number;

use self::draw::Draw;
use crate::op::{Op, Program, Style};
use crate::rng::Rng;

/// The features of a world. Most are left out, so that worlds are small and fast.
#[derive(Clone, Copy, Debug)]
struct Subjects {
    joints: bool,
    particles: bool,
    calls: bool,
}

/// The program of a seed.
#[must_use]
pub fn program(seed: u64) -> Program {
    let mut rng = Rng::new(seed);
    let style = Style::ALL[rng.weighted(&[0.45, 0.15, 0.22, 0.18])];
    program_of(seed, style)
}

/// The program of a seed in a given style.
#[must_use]
pub fn program_of(seed: u64, style: Style) -> Program {
    let mut d = Draw::new(Rng::new(seed ^ 0x5eed), style);
    let subjects = Subjects {
        joints: d.rng.chance(0.45),
        particles: d.rng.chance(0.2),
        calls: d.rng.chance(0.5),
    };
    let hostile =
        style != Style::Ordinary && d.rng.chance(if style == Style::Edge { 0.3 } else { 0.04 });
    let config = d.config();
    d.scenery();
    let most = if subjects.joints || subjects.particles { 7 } else { 12 };
    let most = if style == Style::Edge { 4 } else { most };
    let count = d.rng.from_to(1, most);
    for _ in 0..count {
        d.body();
    }
    if subjects.joints {
        d.mechanism();
        for _ in 0..d.rng.below(3) {
            d.joint_between_any();
        }
        d.couplings();
    }
    if subjects.particles {
        d.particles();
    }
    let is_slow = config.method.name() == "analytic";
    let total = match style {
        _ if is_slow => 20,
        Style::Edge => 20 + d.rng.below_u32(70),
        _ => 200_u32,
    };
    d.run(subjects.calls, hostile, total);
    let mut program = Program { style, config, ops: d.ops };
    if style == Style::Edge {
        edge::mutate(&mut program, &mut d.rng);
    }
    program
}

impl Draw {
    /// Adds steps, with calls between them.
    fn run(&mut self, calls: bool, hostile: bool, total: u32) {
        let mut dt = self.step_length();
        let mut left = total;
        while left > 0 {
            if self.rng.chance(0.1) {
                dt = self.step_length();
            }
            let chunk = if calls { self.rng.below_u32(20) } else { self.rng.below_u32(90) };
            let count = (chunk + 1).min(left);
            left -= count;
            self.ops.push(Op::Step(dt, count));
            if hostile && self.rng.chance(0.3) {
                let dt = self.hostile_step_length();
                self.ops.push(Op::Step(dt, 1));
            }
            if calls {
                for _ in 0..self.rng.below(4) {
                    self.call();
                }
            } else if self.rng.chance(0.3) {
                self.query();
            }
        }
    }

    fn step_length(&mut self) -> f32 {
        if self.rng.chance(0.6) {
            return 1.0 / 60.0;
        }
        let hertz = self.rng.pick(&[30.0, 50.0, 90.0, 120.0, 144.0, 240.0]);
        1.0 / hertz
    }

    fn hostile_step_length(&mut self) -> f32 {
        self.rng.pick(&[
            0.0,
            -0.0,
            -1.0 / 60.0,
            f32::NAN,
            f32::INFINITY,
            f32::MIN_POSITIVE,
            1.0e-45,
            1.0e-30,
            1.0e-12,
            1.0e-9,
            1.0e-6,
            1.0e-4,
            0.5,
            10.0,
            10.000_001,
            1.0e3,
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::program;

    #[test]
    fn a_seed_gives_the_same_program_each_time() {
        for seed in 0..50 {
            let (a, b) = (program(seed), program(seed));
            assert_eq!(format!("{a:?}"), format!("{b:?}"));
            assert!(a.steps() >= 20, "seed {seed}");
        }
        assert_ne!(format!("{:?}", program(1)), format!("{:?}", program(2)));
    }
}
