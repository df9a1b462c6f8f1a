//! Configurations within their bounds, mostly the default.

use drystone::config::ParticleForm;
use drystone::method::{
    Damping, Integration, Method, MethodOptions, Order, Overlap, Persistence, Rest, Shock,
};
use drystone::{Vec3, WorldConfig};

use super::draw::Draw;
use crate::op::Style;

/// Weight of each of [`Method::NAMES`]; `analytic` can take seconds per step.
const METHODS: [f32; 9] = [14.0, 1.5, 0.8, 0.8, 0.4, 0.4, 0.5, 0.08, 0.8];

impl Draw {
    pub(super) fn config(&mut self) -> WorldConfig {
        let mut config = WorldConfig::default();
        let name = Method::NAMES[self.rng.weighted(&METHODS)];
        config.method = Method::named(name).unwrap_or_else(Method::soft_step);
        if self.rng.chance(0.15) {
            let options = self.options();
            // Invalid combinations are refused, and then the method stays unchanged.
            if let Ok(method) = config.method.clone().with_options(options) {
                config.method = method;
            }
        }
        if self.rng.chance(0.2) {
            config.gravity =
                self.rng.pick(&[Vec3::ZERO, Vec3::Y, Vec3::X * -9.81, Vec3::Y * -100.0]);
        }
        if self.rng.chance(0.6) {
            return config;
        }
        self.change(&mut config);
        config
    }

    /// Changes some fields of a configuration, each to a value within its bounds.
    pub(super) fn change(&mut self, config: &mut WorldConfig) {
        for _ in 0..self.rng.from_to(1, 5) {
            let r = &mut self.rng;
            match r.below(21) {
                0 => config.substeps = r.pick(&[1, 2, 4, 8, 16]),
                1 => config.contact.hertz = r.pick(&[0.0, 10.0, 60.0, 240.0]),
                2 => config.contact.damping_ratio = r.pick(&[0.0, 1.0, 10.0, 100.0]),
                3 => config.contact.push_speed = r.scale(0.01, 10.0),
                4 => config.contact.rest_offset = r.scale(1.0e-5, 0.01),
                5 => config.contact.margin = r.scale(0.001, 0.5),
                6 => config.contact.recycle_distance = r.pick(&[0.0, 0.01, 0.05, 0.5]),
                7 => config.contact.restitution_speed = r.pick(&[0.0, 0.5, 2.0]),
                8 => config.contact.hit_speed = r.pick(&[0.0, 0.1, 5.0]),
                9 => config.inertia.max_factor = r.pick(&[0.0, 1.0, 8.0, 64.0]),
                10 => config.inertia.threshold = r.scale(1.0, 1000.0),
                11 => config.inertia.refine = r.pick(&[1, 2, 4]),
                12 => config.joint.hertz = r.pick(&[0.0, 5.0, 60.0, 500.0]),
                13 => config.joint.damping_ratio = r.pick(&[0.0, 1.0, 5.0]),
                14 => config.joint.tree_ratio = r.pick(&[0.0, 1.0, 20.0, 1.0e6]),
                15 => config.joint.refine = r.pick(&[1, 2, 4, 8]),
                16 => {
                    let forms = [
                        ParticleForm::Own,
                        ParticleForm::Soft,
                        ParticleForm::Aim,
                        ParticleForm::Verlet,
                    ];
                    config.particle.form = r.pick(&forms);
                    config.particle.sweeps = r.pick(&[0, 1, 5, 20]);
                }
                17 => config.particle.hertz = r.pick(&[0.0, 10.0, 100.0]),
                18 => config.penalty.hertz = r.scale(5.0, 60.0),
                19 => config.breakage.max_pieces = r.pick(&[0, 3, 20, 4096]),
                _ => {
                    config.sleep.enabled = r.chance(0.7);
                    config.sleep.speed = r.scale(0.01, 1.0);
                    config.sleep.time = r.pick(&[0.0, 0.1, 0.5]);
                }
            }
        }
    }

    fn options(&mut self) -> MethodOptions {
        let r = &mut self.rng;
        let mut options = MethodOptions::default();
        for _ in 0..r.from_to(1, 2) {
            match r.below(8) {
                0 => {
                    options.order =
                        r.pick(&[Order::Colors, Order::Levels, Order::TopDown, Order::Random]);
                }
                1 => options.shock = r.pick(&[Shock::Off, Shock::Inertia, Shock::Full]),
                2 => options.persistence = r.pick(&[Persistence::On, Persistence::Off]),
                3 => {
                    options.overlap = r.pick(&[
                        Overlap::Relax,
                        Overlap::VelocityBias,
                        Overlap::PushOut,
                        Overlap::Nothing,
                    ]);
                }
                4 => options.rest = r.pick(&[Rest::Sleep, Rest::Freeze, Rest::Nothing]),
                5 => {
                    options.integration =
                        r.pick(&[Integration::Exact, Integration::Euler, Integration::Verlet]);
                }
                6 => {
                    options.damping =
                        r.pick(&[Damping::Exponential, Damping::Pade, Damping::Nothing]);
                }
                _ => {
                    let most: &[u32] =
                        if self.style == Style::Torture { &[1, 50] } else { &[1, 4, 20] };
                    options.sweeps = r.pick(most);
                }
            }
        }
        options
    }
}
