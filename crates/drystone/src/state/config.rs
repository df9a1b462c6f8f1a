//! The configuration of a world: every knob, its unit, range and default.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::check::{all_within, within};
use super::def::DefError;
use super::method::Method;
use crate::base::limits::{self, Limit};
use crate::base::math::{Vec3, vec3};

/// Contact behavior. Lengths and speeds count times [`WorldConfig::length_scale`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct ContactConfig {
    /// Stiffness of contacts as a frequency [Hz]; 0 (the default) takes 0.1125 per substep time:
    /// 54 Hz at 60 steps of 8 substeps a second. Contacts with static bodies have twice as much.
    pub hertz: f32,
    /// Damping ratio of contacts; at least 0; default 8. Half of it against static bodies.
    pub damping_ratio: f32,
    /// Bodies that overlap are pushed apart no faster than this [m/s]; above 0; default 0.25. Of deep overlaps the bound grows with
    /// the depth.
    pub push_speed: f32,
    /// Bodies at rest are held this far apart [m]; at least 0; default 5e-5: a lone body then does not
    /// sink below the surface it lies on by the give of its contacts (2e-5 m).
    pub rest_offset: f32,
    /// Contact points are made from this distance on [m]; above 0; default 0.02. A shape that comes near to
    /// a mesh may get them only at half of it, if it does not come there within a step.
    pub margin: f32,
    /// While the bodies of a contact have moved against each other less than this [m], and less than a
    /// quarter of the smaller one's size, its points and normal stay as they are and only the distances
    /// follow; at least 0; default 0.05.
    pub recycle_distance: f32,
    /// Contacts that meet slower than this do not bounce [m/s]; at least 0; default 0. Nor do those
    /// slower than what forces make a body in a step: 0.16 m/s under the earth's gravity at 60 Hz.
    pub restitution_speed: f32,
    /// Contacts that meet faster than this are reported as hits [m/s]; at least 0; default 1.
    pub hit_speed: f32,
}

/// Load-adaptive inertia: a body that is squeezed hard answers slowly, so that tall stacks and heavy loads
/// do not sink into what carries them. Loads, limits of friction and tipping stay exact.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct InertiaConfig {
    /// Mass and inertia of a squeezed body are multiplied by up to this in the solver, 1 to 64; 1: off.
    /// 0 (the default) takes the method's own: 8 for `soft-step`, 1 for `soft-step-relax`. Under loads of more
    /// than 5 times what gives that factor it grows on, up to three times this, if `refine` is 1.
    pub most: f32,
    /// Loads above this per mass [m/s²] raise a body's factor; above 0; default 30, some 3 bodies of
    /// its own mass on top of it. It counts times [`WorldConfig::length_scale`].
    pub threshold: f32,
    /// An island in which some body's factor is near its greatest gets this many times the substeps, 1 to
    /// 8; 1 (the default): none. 2 makes overlaps there a quarter and the island's solver time twice.
    pub refine: u32,
}

/// Joint behavior.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct JointConfig {
    /// Stiffness of joints as a frequency [Hz]; 0 (the default) takes 0.15 per substep time, 0.25 for
    /// trees that are solved at once, which are the greatest that are taken.
    pub hertz: f32,
    /// Damping ratio of joints; at least 0; default 2.
    pub damping_ratio: f32,
    /// Ball joints that connect bodies without a loop are solved all at once where a body between others
    /// carries at least this many times its own mass: a chain under a heavy load then keeps
    /// its length; at least 0; default 20. It takes longer than joint by joint.
    pub tree_ratio: f32,
    /// An island of at most 64 bodies that has joints gets this many times the substeps, 1 to 8, where a joint goes round fast, by
    /// more than a tenth of a radian in a substep, or a body is hit, by more than three hundredths of the thinner body's half
    /// thickness in a substep; default 4; 1: none. What tumbles on joints and touches nothing, turning by some tenths of a radian in a
    /// step about no principal axis of its own, is besides solved anew in each substep.
    pub refine: u32,
}

/// How links and contacts of particles are solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub enum ParticleForm {
    /// As the method has it: `Verlet` of `verlet`, else `Soft`.
    #[default]
    Own,
    /// Velocities; soft rows that keep their impulses from substep to substep.
    Soft,
    /// Velocities, with all of the error taken out in every substep (bias 1/h); no impulses are kept.
    Aim,
    /// Positions are projected, and velocity is the way moved [Jakobsen01]. The same as `Aim`, but for rounding.
    Verlet,
}

impl ParticleForm {
    /// The words for its values.
    pub const WORDS: &'static [&'static str] = &["own", "soft", "aim", "verlet"];

    /// The word for it.
    #[must_use]
    pub const fn word(self) -> &'static str {
        Self::WORDS[self as usize]
    }

    /// The value of this word.
    #[must_use]
    pub fn named(word: &str) -> Option<Self> {
        [Self::Own, Self::Soft, Self::Aim, Self::Verlet].into_iter().find(|f| f.word() == word)
    }
}

/// Particle behavior.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct ParticleConfig {
    /// How their links and contacts are solved; default as the method has it.
    pub form: ParticleForm,
    /// Sweeps over them in a substep, at most 1000; 0 (the default): 2 of the soft form, 10 of the others.
    pub sweeps: u32,
    /// Stiffness of rods and threads of the soft form as a frequency [Hz]; 0 (the default) takes 1 per substep
    /// time.
    pub hertz: f32,
    /// Damping ratio of those; at least 0; default 2.
    pub damping_ratio: f32,
}

/// Contacts as springs, of the penalty methods.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct PenaltyConfig {
    /// Stiffness of a contact point as a frequency, k = m (2πf)² with the effective mass m of the point [Hz];
    /// above 0; default 30.
    pub hertz: f32,
    /// Damping ratio; at least 0; default 0.5.
    pub damping_ratio: f32,
}

/// Bodies that come apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct BreakageConfig {
    /// Most pieces of fractured bodies at a time; default 4096. What would go beyond breaks into fewer pieces, or not
    /// at all.
    pub max_pieces: u32,
}

/// When bodies fall asleep: together with all that they touch or are joined to, when each of them has been still for
/// some time and nothing drives one of them.
///
/// Slow is not still. A body is still if it is slow, if what its supports leave over of the forces on it would not set
/// it in motion (a thousandth of them at most), and if it does not creep by more than a tenth of its extent in the
/// time until sleep. What nothing touches or holds is still only if no force acts on it, and if it drifts by no more than a
/// hundredth of its extent in ten seconds. Extent is the distance of its farthest point from its center of mass;
/// bodies without shapes have one of 1 m.
///
/// Driven is what touches a kinematic body that moves, or is joined to one; what touches a surface that moves over its
/// shape, and what a drive or a spring of a joint acts on, unless it has come to a stop all the same: it is blocked, or has
/// reached its place. [`crate::World::why_awake`] tells what keeps a body awake. The manual: [sleep](crate::manual::sleep).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct SleepConfig {
    /// Whether still islands fall asleep at all; default true.
    pub enabled: bool,
    /// A body is slow if no point of it moves faster than this [m/s]; at least 0; default 0.05. What is faster never
    /// sleeps; what is slower sleeps if it is still besides. 0: nothing sleeps. It counts times [`WorldConfig::length_scale`]; a
    /// body's own [`sleep_speed`](crate::BodyDef::sleep_speed) does not.
    pub speed: f32,
    /// An island sleeps when all its bodies have been still for this long [s]; at least 0, and at least two and a half
    /// steps, without which no acceleration can be told; default 0.5.
    pub time: f32,
}

/// Everything a world is configured by. The manual: [tuning](crate::manual::tuning).
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
    /// Length of a typical body in the world's unit of length, 1e-4 to 1e4; default 1, for bodies of some decimeters to some meters in
    /// meters. 100 for a world in centimeters, 0.02 for dice in meters. All lengths and speeds that the engine itself brings count
    /// times this: those of the configuration (`contact.*`, `inertia.threshold`, `sleep.speed`), and tolerances inside. What is
    /// given with bodies, shapes, joints and particles, and gravity, does not.
    pub length_scale: f32,
    /// How a step is made; default `soft-step`.
    pub method: Method,
    /// Solver substeps a step, 1 to 256; 0 (the default) takes the method's own number.
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

    /// Into the lists of passes that are there.
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
            inertia: InertiaConfig { most: 0.0, threshold: 30.0, refine: 1 },
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
    /// Paths that [`Self::set`] knows.
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
        "inertia.most",
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
            ("inertia.most", limits::INERTIA_FACTOR, &mut i.most),
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

    /// Contacts by the world's lengths.
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

    /// Speed below which a body is slow, by the world's lengths [m/s].
    pub(crate) fn sleep_speed(&self) -> f32 {
        scaled(self.sleep.speed, self.length_scale)
    }

    /// Load per mass that raises a body's factor, by the world's lengths [m/s²].
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

    /// Sets the field at `path` (see [`Self::PATHS`]) from text: numbers as written, `true` or `false`,
    /// vectors as `x,y,z`, methods by name. A method comes with its own options: set it before them.
    ///
    /// # Errors
    /// No such path, text that is not a value of the field, or a value out of range; then nothing is
    /// changed.
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

/// A length, speed or acceleration by the world's lengths, as far as there are numbers.
fn scaled(x: f32, length: f32) -> f32 {
    (x * length).min(f32::MAX)
}

/// Parts of a substep.
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
