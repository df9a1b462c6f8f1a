//! The configuration of a world: every setting with its unit, range and default.

mod sleep;

pub use self::sleep::SleepConfig;

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::DefError;
use super::check::{all_within, within};
use super::method::Method;
use crate::base::limits;
use crate::base::limits::Limit;
use crate::base::math::{Vec3, vec3};

/// Contact behavior. Lengths and speeds are multiplied by [`WorldConfig::length_scale`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct ContactConfig {
    /// Stiffness of contacts as a frequency [Hz], at least 0; 0 (the default): 0.1125 / substep
    /// time, which is 54 Hz at 60 steps of 8 substeps per second. Contacts with static bodies are
    /// twice as stiff.
    pub hertz: f32,
    /// Damping ratio of contacts, at least 0; default 8. Contacts with static bodies have half of
    /// it.
    pub damping_ratio: f32,
    /// Maximum speed at which overlapping bodies are pushed apart [m/s], above 0; default 0.25. For
    /// deep overlaps the limit grows with the depth.
    pub push_speed: f32,
    /// Distance between bodies at rest [m], at least 0; default 5e-5. It compensates the compliance
    /// of the contacts (2e-5 m), so that a single body does not sink below the surface it lies on.
    pub rest_offset: f32,
    /// Distance below which contact points are created [m], above 0; default 0.02. A shape near a
    /// mesh may get them only at half of this distance, unless it would reach the mesh within a
    /// step.
    pub margin: f32,
    /// Displacement below which a contact keeps its points and normal, and only updates their
    /// separations [m], at least 0; default 0.05. It is the relative displacement of the two
    /// bodies, and is also limited to a quarter of the size of the smaller one.
    pub recycle_distance: f32,
    /// Approach speed below which contacts do not bounce [m/s], at least 0; default 0. Contacts
    /// slower than the speed that forces give a body in one step do not bounce either: 0.16 m/s
    /// under the earth's gravity at 60 Hz.
    pub restitution_speed: f32,
    /// Approach speed above which contacts are reported as hits [m/s], at least 0; default 1.
    pub hit_speed: f32,
}

/// Load-adaptive inertia. Heavily loaded bodies respond more slowly in the solver, so that tall
/// stacks and heavy loads do not sink into their supports. Loads, friction limits and tipping stay
/// exact.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct InertiaConfig {
    /// Maximum factor on the mass and inertia of a loaded body in the solver, 1 to 64; 1: off. 0
    /// (the default): the method's own, 8 for `soft-step` and 1 for `soft-step-relax`. If `refine`
    /// is 1, loads above 5 times the load of that factor raise it further, up to three times this
    /// value.
    pub max_factor: f32,
    /// Load per mass above which the factor of a body grows [m/s²], above 0; default 30, the weight
    /// of about 3 bodies of the same mass on top. It is multiplied by
    /// [`WorldConfig::length_scale`].
    pub threshold: f32,
    /// Substep multiplier for islands with a body whose factor is near its maximum, 1 to 8; default
    /// 1. With 2, overlaps there shrink to a quarter, and the solver time of the island doubles.
    pub refine: u32,
}

/// Joint behavior.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct JointConfig {
    /// Stiffness of joints as a frequency [Hz], at least 0; 0 (the default): 0.15 / substep time,
    /// or 0.25 / substep time for trees that are solved directly. Larger values have the same
    /// effect as these.
    pub hertz: f32,
    /// Damping ratio of joints; at least 0; default 2.
    pub damping_ratio: f32,
    /// Load ratio above which trees of ball joints are solved directly, at least 0; default 20. It
    /// applies to joints without a loop, if a body between others carries at least this many times
    /// its own mass. A chain under a heavy load then keeps its length. The direct solve takes
    /// longer than joint by joint.
    pub tree_ratio: f32,
    /// Substep multiplier for islands of at most 64 bodies with joints, 1 to 8; default 4; 1: off.
    /// It applies in two cases. A joint turns by more than 0.1 rad in a substep. Or a body is hit,
    /// so that it moves by more than 0.03 of the thinner body's half thickness in a substep.
    ///
    /// Islands that tumble on joints without contacts also re-linearize the joints in every
    /// substep. They must turn by some tenths of a radian in a step, about an axis that is not one
    /// of their principal axes.
    pub refine: u32,
}

/// Solver for links and contacts of particles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub enum ParticleForm {
    /// The method's own: `Verlet` for the method `verlet`, otherwise `Soft`.
    #[default]
    Own,
    /// Velocity constraints with softness; impulses are kept from substep to substep.
    Soft,
    /// Velocity constraints that remove the whole error in every substep (bias 1/h); impulses are
    /// not kept.
    Aim,
    /// Positions are projected, and velocity follows from displacement [Jakobsen01]. The same as
    /// `Aim` up to rounding.
    Verlet,
}

impl ParticleForm {
    /// The names of the values.
    pub const WORDS: &'static [&'static str] = &["own", "soft", "aim", "verlet"];

    /// The name of the value.
    #[must_use]
    pub const fn word(self) -> &'static str {
        Self::WORDS[self as usize]
    }

    /// The value of this name.
    #[must_use]
    pub fn named(word: &str) -> Option<Self> {
        [Self::Own, Self::Soft, Self::Aim, Self::Verlet].into_iter().find(|f| f.word() == word)
    }
}

/// Particle behavior.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct ParticleConfig {
    /// Solver for links and contacts; default: the method's own.
    pub form: ParticleForm,
    /// Sweeps per substep, 0 to 1000; 0 (the default): 2 for the soft form, 10 for the others.
    pub sweeps: u32,
    /// Stiffness of rods and threads in the soft form as a frequency [Hz]; 0 (the default): 1 /
    /// substep time.
    pub hertz: f32,
    /// Damping ratio of rods and threads in the soft form, at least 0; default 2.
    pub damping_ratio: f32,
}

/// Contact springs of the penalty methods.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct PenaltyConfig {
    /// Stiffness of a contact point as a frequency [Hz], above 0; default 30. k = m (2πf)², with
    /// the effective mass m of the point.
    pub hertz: f32,
    /// Damping ratio, at least 0; default 0.5.
    pub damping_ratio: f32,
}

/// Bodies that break.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct BreakageConfig {
    /// Maximum number of pieces of fractured bodies at a time; default 4096. A fracture that would
    /// exceed it makes fewer pieces, or none.
    pub max_pieces: u32,
}

/// The configuration of a world. The manual: [tuning](crate::manual::tuning).
///
/// ```
/// use drystone::{World, WorldConfig};
///
/// // A world in centimeters: one number, and gravity.
/// let config = WorldConfig {
///     length_scale: 100.0,
///     gravity: [0.0, -981.0, 0.0].into(),
///     ..WorldConfig::default()
/// };
/// let world = World::new(config)?;
/// # let _ = world;
/// # Ok::<(), drystone::DefError>(())
/// ```
#[derive(Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct WorldConfig {
    /// Acceleration of free bodies [m/s², world]; default (0, -9.81, 0).
    pub gravity: Vec3,
    /// Length of a typical body in the world's unit of length, 1e-4 to 1e4; default 1, for bodies
    /// of some decimeters to some meters in a world in meters. Use 100 for a world in centimeters,
    /// 0.02 for dice in meters. The engine's own lengths, speeds and load threshold are multiplied
    /// by it: those of the configuration (`contact.*`, `inertia.threshold`, `sleep.speed`) and
    /// internal tolerances. Gravity and values given with bodies, shapes, joints and particles are
    /// not.
    pub length_scale: f32,
    /// The stepping method; default `soft-step`.
    pub method: Method,
    /// Solver substeps per step, 0 to 256; 0 (the default): the method's own number.
    pub substeps: u32,
    /// Contacts.
    pub contact: ContactConfig,
    /// Load-adaptive inertia.
    pub inertia: InertiaConfig,
    /// Joints.
    pub joint: JointConfig,
    /// Particles.
    pub particle: ParticleConfig,
    /// Springs of the penalty methods.
    pub penalty: PenaltyConfig,
    /// Sleep.
    pub sleep: SleepConfig,
    /// Fracture.
    pub breakage: BreakageConfig,
}

impl Clone for WorldConfig {
    fn clone(&self) -> Self {
        Self { method: self.method.clone(), ..*self }
    }

    /// Reuses the existing lists of passes.
    fn clone_from(&mut self, from: &Self) {
        self.method.clone_from(&from.method);
        let Self { gravity, length_scale, method: _, substeps, contact, .. } = self;
        (*gravity, *substeps, *contact) = (from.gravity, from.substeps, from.contact);
        *length_scale = from.length_scale;
        let Self { inertia, joint, particle, penalty, sleep, breakage, .. } = self;
        (*inertia, *joint, *particle) = (from.inertia, from.joint, from.particle);
        (*penalty, *sleep, *breakage) = (from.penalty, from.sleep, from.breakage);
    }
}

impl Default for WorldConfig {
    fn default() -> Self {
        Self {
            gravity: vec3(0.0, -9.81, 0.0),
            length_scale: 1.0,
            method: Method::soft_step(),
            substeps: 0,
            contact: ContactConfig {
                hertz: 0.0,
                damping_ratio: 8.0,
                push_speed: 0.25,
                rest_offset: 5.0e-5,
                margin: 0.02,
                recycle_distance: 0.05,
                restitution_speed: 0.0,
                hit_speed: 1.0,
            },
            inertia: InertiaConfig { max_factor: 0.0, threshold: 30.0, refine: 1 },
            joint: JointConfig { hertz: 0.0, damping_ratio: 2.0, tree_ratio: 20.0, refine: 4 },
            particle: ParticleConfig {
                form: ParticleForm::Own,
                sweeps: 0,
                hertz: 0.0,
                damping_ratio: 2.0,
            },
            penalty: PenaltyConfig { hertz: 30.0, damping_ratio: 0.5 },
            sleep: SleepConfig { enabled: true, speed: 0.05, time: 0.5 },
            breakage: BreakageConfig { max_pieces: 4096 },
        }
    }
}

/// A scalar field of the configuration: path, its range, a reference to it.
type Scalar<'a> = (&'static str, Limit, &'a mut f32);

impl WorldConfig {
    /// The paths of [`Self::set`].
    pub const PATHS: &'static [&'static str] = &[
        "gravity",
        "length_scale",
        "method",
        "method.order",
        "method.shock",
        "method.persistence",
        "method.overlap",
        "method.rest",
        "method.integration",
        "method.damping",
        "method.sweeps",
        "substeps",
        "contact.hertz",
        "contact.damping_ratio",
        "contact.push_speed",
        "contact.rest_offset",
        "contact.margin",
        "contact.recycle_distance",
        "contact.restitution_speed",
        "contact.hit_speed",
        "inertia.max_factor",
        "inertia.threshold",
        "inertia.refine",
        "joint.hertz",
        "joint.damping_ratio",
        "joint.tree_ratio",
        "joint.refine",
        "particle.form",
        "particle.sweeps",
        "particle.hertz",
        "particle.damping_ratio",
        "penalty.hertz",
        "penalty.damping_ratio",
        "sleep.enabled",
        "sleep.speed",
        "sleep.time",
        "breakage.max_pieces",
    ];

    fn scalars(&mut self) -> [Scalar<'_>; 20] {
        let (c, i) = (&mut self.contact, &mut self.inertia);
        let (j, s, p) = (&mut self.joint, &mut self.sleep, &mut self.penalty);
        let particle = &mut self.particle;
        [
            ("length_scale", limits::LENGTH_SCALE, &mut self.length_scale),
            ("contact.hertz", limits::FREQUENCY, &mut c.hertz),
            ("contact.damping_ratio", limits::DAMPING_RATIO, &mut c.damping_ratio),
            ("contact.push_speed", limits::PUSH_SPEED, &mut c.push_speed),
            ("contact.rest_offset", limits::CONTACT_DISTANCE, &mut c.rest_offset),
            ("contact.margin", limits::MARGIN, &mut c.margin),
            ("contact.recycle_distance", limits::CONTACT_DISTANCE, &mut c.recycle_distance),
            ("contact.restitution_speed", limits::THRESHOLD, &mut c.restitution_speed),
            ("contact.hit_speed", limits::THRESHOLD, &mut c.hit_speed),
            ("inertia.max_factor", limits::INERTIA_FACTOR, &mut i.max_factor),
            ("inertia.threshold", limits::THRESHOLD_ABOVE_ZERO, &mut i.threshold),
            ("joint.hertz", limits::FREQUENCY, &mut j.hertz),
            ("joint.damping_ratio", limits::DAMPING_RATIO, &mut j.damping_ratio),
            ("joint.tree_ratio", limits::THRESHOLD, &mut j.tree_ratio),
            ("particle.hertz", limits::FREQUENCY, &mut particle.hertz),
            ("particle.damping_ratio", limits::DAMPING_RATIO, &mut particle.damping_ratio),
            ("penalty.hertz", limits::SPRING_FREQUENCY, &mut p.hertz),
            ("penalty.damping_ratio", limits::DAMPING_RATIO, &mut p.damping_ratio),
            ("sleep.speed", limits::THRESHOLD, &mut s.speed),
            ("sleep.time", limits::THRESHOLD, &mut s.time),
        ]
    }

    /// Contact settings, scaled by the world's length scale.
    pub(crate) fn contact_lengths(&self) -> ContactConfig {
        let scale = |x: f32| scaled(x, self.length_scale);
        let c = self.contact;
        ContactConfig {
            push_speed: scale(c.push_speed),
            rest_offset: scale(c.rest_offset),
            margin: scale(c.margin),
            recycle_distance: scale(c.recycle_distance),
            restitution_speed: scale(c.restitution_speed),
            hit_speed: scale(c.hit_speed),
            ..c
        }
    }

    /// Speed below which a body is slow, scaled by the world's length scale [m/s].
    pub(crate) fn sleep_speed(&self) -> f32 {
        scaled(self.sleep.speed, self.length_scale)
    }

    /// Load per mass above which a body's factor grows, scaled by the world's length scale [m/s²].
    pub(crate) fn inertia_threshold(&self) -> f32 {
        scaled(self.inertia.threshold, self.length_scale).max(f32::MIN_POSITIVE)
    }

    /// Checks every field.
    ///
    /// # Errors
    /// The first field that is out of range.
    pub fn validate(&self) -> Result<(), DefError> {
        all_within("gravity", self.gravity, &limits::GRAVITY)?;
        if self.substeps > 256 {
            return Err(DefError::new(
                "substeps",
                self.substeps,
                "from 0 (the method's own) to 256",
            ));
        }
        self.method.settle()?;
        for (path, parts) in
            [("inertia.refine", self.inertia.refine), ("joint.refine", self.joint.refine)]
        {
            if !(1..=8).contains(&parts) {
                return Err(DefError::new(path, parts, "from 1 to 8"));
            }
        }
        if self.particle.sweeps > 1000 {
            return Err(DefError::new("particle.sweeps", self.particle.sweeps, "from 0 to 1000"));
        }
        for (path, limit, value) in self.clone().scalars() {
            within(path, *value, &limit)?;
        }
        Ok(())
    }

    /// Sets the field at `path` (see [`Self::PATHS`]) from text: numbers, `true` or `false`,
    /// vectors as `x,y,z`, methods by name. A method resets its options: set it before them.
    ///
    /// # Errors
    /// The path does not exist, the text is not a value of the field, or the value is out of range.
    /// Then nothing is changed.
    pub fn set(&mut self, path: &str, text: &str) -> Result<(), DefError> {
        let mut next = self.clone();
        let text = text.trim();
        match path {
            "gravity" => {
                let parts: Vec<f32> =
                    text.split(',').filter_map(|p| p.trim().parse().ok()).collect();
                let [x, y, z] = parts[..] else {
                    return Err(DefError::new("gravity", text, "three numbers x,y,z"));
                };
                if text.split(',').count() != 3 {
                    return Err(DefError::new("gravity", text, "three numbers x,y,z"));
                }
                next.gravity = vec3(x, y, z);
            }
            "method" => {
                next.method = Method::named(text).ok_or_else(|| {
                    DefError::new("method", text, &format!("one of {}", Method::NAMES.join(", ")))
                })?;
            }
            "substeps" => {
                next.substeps = text
                    .parse()
                    .map_err(|_| DefError::new("substeps", text, "a whole number from 0 to 256"))?;
            }
            "inertia.refine" => next.inertia.refine = parts_of(path, text)?,
            "joint.refine" => next.joint.refine = parts_of(path, text)?,
            "particle.form" => {
                next.particle.form = ParticleForm::named(text).ok_or_else(|| {
                    DefError::new(
                        "particle.form",
                        text,
                        &format!("one of {}", ParticleForm::WORDS.join(", ")),
                    )
                })?;
            }
            "particle.sweeps" => {
                next.particle.sweeps = text.parse().map_err(|_| {
                    DefError::new("particle.sweeps", text, "a whole number from 0 to 1000")
                })?;
            }
            "breakage.max_pieces" => {
                let allowed = "a whole number of at least 0";
                next.breakage.max_pieces =
                    text.parse().map_err(|_| DefError::new(path, text, allowed))?;
            }
            "sleep.enabled" => {
                next.sleep.enabled = text
                    .parse()
                    .map_err(|_| DefError::new("sleep.enabled", text, "true or false"))?;
            }
            _ => match next.method.set_option(path, text) {
                Some(done) => done?,
                None => next.set_scalar(path, text)?,
            },
        }
        next.validate()?;
        *self = next;
        Ok(())
    }

    fn set_scalar(&mut self, path: &str, text: &str) -> Result<(), DefError> {
        let known = format!("one of {}", Self::PATHS.join(", "));
        let (name, limit, field) = self
            .scalars()
            .into_iter()
            .find(|(p, _, _)| *p == path)
            .ok_or_else(|| DefError::new("path", path, &known))?;
        *field = text.parse().map_err(|_| DefError::new(name, text, limit.allowed))?;
        Ok(())
    }
}

/// A length, speed or acceleration, scaled by the world's length scale and clamped to finite
/// numbers.
fn scaled(x: f32, length: f32) -> f32 {
    (x * length).min(f32::MAX)
}

/// Parses a substep multiplier.
fn parts_of(path: &str, text: &str) -> Result<u32, DefError> {
    text.parse().map_err(|_| DefError::new(path, text, "a whole number from 1 to 8"))
}

#[cfg(test)]
mod tests {
    use super::WorldConfig;

    #[test]
    fn every_path_can_be_set_and_bad_text_changes_nothing() {
        let mut config = WorldConfig::default();
        for path in WorldConfig::PATHS.iter().copied() {
            let good = match path {
                "gravity" => "0,-1.62,0",
                "method" => "soft-step",
                "method.sweeps" => "0",
                _ if path.starts_with("method.") => "own",
                "sleep.enabled" => "false",
                "particle.form" => "aim",
                _ => "3",
            };
            config.set(path, good).unwrap();
            let before = config.clone();
            for bad in ["", "x", "NaN", "-1", "1,2", "1,2,inf"] {
                assert!(config.set(path, bad).is_err(), "{path}={bad}");
            }
            assert_eq!(before, config);
        }
        assert!(
            config.set("contact.magic", "1").unwrap_err().to_string().contains("contact.hertz")
        );
    }
}
