//! Constants of one step, computed once before its stages run.

pub(crate) mod caps;
pub(crate) mod load_inertia;
pub(crate) mod softness;

use fearless_simd::Level;

use self::caps::{Caps, SHORTEST};
use self::load_inertia::LoadInertia;
use self::softness::{Compliance, Softness};
use crate::base::math::Vec3;
use crate::state::bodies::body::{Body, Subdivision};
use crate::state::bodies::stillness::StillnessRule;
use crate::state::def::config::{PenaltyConfig, SleepConfig, WorldConfig};
use crate::state::def::material::ContactSoftness;

/// Maximum push-out speed of an island that subdivides its substeps [m/s]. When subdivision begins,
/// contacts get stiffer by the square of the number of parts. A stack of 30 boxes hopped with the
/// world's 3 m/s, and with 0.05 m/s too.
const REFINED_PUSH_SPEED: f32 = 0.01;

/// Maximum depth of a settled contact under its load, as a part of the half thickness of the
/// thinner body. A spring yields as far under a body of a millimeter as under one of a meter, and
/// would press small and thin stacks together.
pub(crate) const GIVES: f32 = 0.01;

/// Frequency of swept joints, times the substep. Take two soft rows on one body, of which only a
/// part κ of each correction lasts, such as a light body between a joint and a contact. They shrink
/// in a substep by κ (1 - w²) w (ζ + w/2), w = 2π f h: for any κ below 0.159 and only there
/// (docs/derivations/joints.md). A tenth of w² is left for damping; compliance grows by 1/w².
const SWEPT: f32 = 0.15;

/// Frequency, times the substep, of joints in trees (solved at once) and of contact-free tumbling
/// bodies. The limit of [`SWEPT`] does not apply to them.
const DIRECT: f32 = 0.25;

/// Frequency of joints [Hz], clamped to `part` of the substep rate.
fn joint_hertz(config: &WorldConfig, part: f32, inv_h: f32) -> f32 {
    let stiffest = part * inv_h.min(1.0 / SHORTEST);
    if config.joint.hertz > 0.0 { config.joint.hertz.min(stiffest) } else { stiffest }
}

/// Constants of a step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StepContext {
    /// Step and substep [s].
    pub(crate) dt: f32,
    pub(crate) h: f32,
    pub(crate) inv_h: f32,
    pub(crate) substeps: u32,
    /// Length of a typical body [m].
    pub(crate) length: f32,
    /// Reciprocal of `length`, rounded to a power of two so that scaling a length is exact: the
    /// unit of [`Track`](crate::state::bodies::Track).
    pub(crate) per_track: f32,
    /// Caps on the speed at which errors close.
    pub(crate) caps: Caps,
    pub(crate) gravity: Vec3,
    /// Displacement by gravity in a step, plus a tenth [m].
    pub(crate) fall: f32,
    /// Speculative distance [m].
    pub(crate) margin: f32,
    pub(crate) rest_offset: f32,
    pub(crate) recycle_distance: f32,
    pub(crate) restitution_speed: f32,
    pub(crate) hit_speed: f32,
    pub(crate) push_speed: f32,
    /// The solver parts a contact that is deeper than its load explains by more than `deep` [m]. It
    /// stops at a depth of `parted`: for two dynamic bodies, and for one with a static body.
    pub(crate) deep: f32,
    pub(crate) parted: [f32; 2],
    /// Maximum speed that warm starting a contact gives its bodies [m/s].
    pub(crate) warm_max: f32,
    /// Configured frequency of contacts [Hz]; 0: as stiff as the substeps allow.
    pub(crate) contact_hertz: f32,
    /// Contacts yield under a load; false for the classic methods.
    pub(crate) is_soft: bool,
    /// Softness of contacts of two dynamic bodies, and of those with static bodies.
    pub(crate) soft: Softness,
    pub(crate) soft_fixed: Softness,
    pub(crate) soft_joint: Softness,
    /// Softness of joints in trees that are solved directly, and the mass ratio that selects these
    /// trees.
    pub(crate) soft_tree: Compliance,
    /// Maximum [`Softness::hardness`] of drives and sprung limits in trees; elsewhere the maximum
    /// is that of `soft_joint`.
    pub(crate) hardest_in_trees: f32,
    pub(crate) tree_ratio: f32,
    pub(crate) inertia: LoadInertia,
    /// Factor of the last step's impulses, for substeps of another length.
    pub(crate) impulse_scale: f32,
    /// Springs of the penalty methods.
    pub(crate) penalty: PenaltyConfig,
    /// Subdivision of each of the world's substeps, 1 to 8.
    pub(crate) parts: u32,
    pub(crate) subdivision: Subdivision,
    /// Bodies freeze and wake individually.
    pub(crate) wakes_alone: bool,
    /// Sleep configuration, scaled by the world's length; enabled only if the method supports
    /// sleep.
    pub(crate) sleep: SleepConfig,
    /// Number of rounds of length `dt`, for islands that are solved anew in each of the world's
    /// substeps.
    pub(crate) rounds: u32,
    pub(crate) level: Level,
}

/// A contact of two dynamic bodies is parted if it would push out faster than this [m/s]. It is the
/// default of `contact.push_speed`, which is not reached at rest. Contacts with static bodies are
/// stiffer, but the same depth is an error in both: a body that slides over a kink is some
/// millimeters deep before the contact is found.
const PART_SPEED: f32 = 0.25;

/// Push-out speed at which parting ends, and to which the remaining depth corresponds [m/s]: a
/// sixteenth of [`PART_SPEED`].
const PARTED_SPEED: f32 = PART_SPEED / 16.0;

/// Maximum warm start of a contact, in weights of its bodies; gravity counts as at least
/// [`MIN_WEIGHT`] [m/s²].
const WARM_WEIGHTS: f32 = 1000.0;

const MIN_WEIGHT: f32 = 9.81;

impl StepContext {
    pub(crate) fn new(config: &WorldConfig, dt: f32, last_h: f32, level: Level) -> Self {
        let substeps =
            if config.substeps == 0 { config.method.substeps() } else { config.substeps }.max(1);
        #[expect(clippy::cast_precision_loss, reason = "at most 256")]
        let h = dt / substeps as f32;
        // The first step warm-starts from the loads of bodies that were placed at rest.
        let scale = if last_h > 0.0 { (h / last_h).min(4.0) } else { 1.0 };
        let impulse_scale = if config.method.persists() { scale } else { 0.0 };
        Self::with(config, dt, [substeps, 1], impulse_scale, level)
    }

    /// Contexts of islands that subdivide every substep, one for each [`Subdivision`].
    #[expect(clippy::cast_precision_loss, reason = "at most 256")]
    pub(crate) fn finer(&self, config: &WorldConfig) -> [Self; 4] {
        let in_parts = |parts: u32| {
            let substeps = [self.substeps, parts.clamp(1, 8)];
            Self::with(config, self.dt, substeps, self.impulse_scale, self.level)
        };
        let mut loaded = in_parts(config.inertia.refine);
        loaded.subdivision = Subdivision::Loaded;
        // Bodies that had sunk into softer contacts must not be thrown up.
        loaded.push_speed = loaded.push_speed.min(REFINED_PUSH_SPEED * self.length);
        // That depth is no error either.
        (loaded.deep, loaded.parted) = (self.deep, self.parted);
        let mut jointed = in_parts(config.joint.refine);
        jointed.subdivision = Subdivision::Jointed;
        // Contacts stay as soft as before; only joints get stiffer. (Stiffer contacts also threw
        // caught limbs out of their joints: docs/decisions/023-hits-on-joints.md.)
        [jointed.soft, jointed.soft_fixed] = contact_springs(config, self.inv_h, jointed.h);
        let struck = Self { subdivision: Subdivision::Struck, ..jointed };
        let (rounds, dt) = (self.substeps, self.dt / self.substeps as f32);
        let parts = jointed.parts;
        let tumbling = Self::with(config, dt, [1, parts], self.impulse_scale, self.level);
        // These bodies touch nothing, so no contact undoes a joint's correction.
        let hertz = joint_hertz(config, DIRECT, tumbling.inv_h);
        let soft_joint = Softness::new(hertz, config.joint.damping_ratio, tumbling.h);
        let tumbling = Self { subdivision: Subdivision::Tumbling, rounds, soft_joint, ..tumbling };
        [loaded, jointed, struck, tumbling]
    }

    /// See [`Self::per_track`].
    pub(crate) const fn per_track_of(length: f32) -> f32 {
        1.0 / power_below(length)
    }

    /// The rule by which bodies are still.
    pub(crate) const fn stillness(&self) -> StillnessRule {
        let (gravity, length, dt) = (self.gravity, self.length, self.dt);
        StillnessRule { gravity, length, speed: self.sleep.speed, time: self.sleep.time, dt }
    }

    /// Softness of a contact with its own frequency and damping.
    pub(crate) fn soft_contact(&self, softness: &ContactSoftness) -> Softness {
        let hertz = contact_hertz(softness.hertz, self.inv_h);
        Softness::new(hertz, softness.damping_ratio, self.h)
    }

    /// Maximum depth of a settled contact of these bodies under its load [m].
    pub(crate) fn max_give(&self, [a, b]: [&Body; 2]) -> f32 {
        let thick = |body: &Body| if body.is_dynamic() { body.inner } else { f32::MAX };
        GIVES * thick(a).min(thick(b))
    }

    /// Additional compliance of contacts of two dynamic bodies in substeps of `h` [s], compared
    /// with this step's: the difference of 1/ω² [s²]. 0 for equal lengths.
    pub(crate) fn gave_more(&self, h: f32) -> f32 {
        let is_same = (h - self.h).abs() <= 1.0e-4 * self.h;
        if is_same || !(h > 0.0) || !self.is_soft {
            return 0.0;
        }
        let square = |rate: f32| {
            let omega = 2.0 * core::f32::consts::PI * contact_hertz(self.contact_hertz, rate);
            omega * omega
        };
        1.0 / square(1.0 / h) - 1.0 / square(self.inv_h)
    }

    /// Factor of stored impulses: they refer to the world's substep, however finely an island
    /// subdivides it.
    #[expect(clippy::cast_precision_loss, reason = "at most 8")]
    pub(crate) const fn store_scale(&self) -> f32 {
        self.parts as f32
    }

    /// Length of the whole step [s], also for islands that are solved in rounds.
    #[expect(clippy::cast_precision_loss, reason = "at most 256")]
    pub(crate) const fn step(&self) -> f32 {
        self.dt * self.rounds as f32
    }

    #[expect(clippy::cast_precision_loss, reason = "at most 256 by 8")]
    fn with(
        config: &WorldConfig,
        dt: f32,
        [substeps, parts]: [u32; 2],
        impulse_scale: f32,
        level: Level,
    ) -> Self {
        let h = dt / (substeps * parts) as f32;
        let inv_h = 1.0 / h;
        let c = &config.contact_lengths();
        let [soft, soft_fixed] = contact_springs(config, inv_h, h);
        let [swept, direct] = [SWEPT, DIRECT].map(|part| joint_hertz(config, part, inv_h));
        let maximum = config.inertia.max_factor;
        let maximum = if maximum > 0.0 { maximum } else { config.method.inertia() };
        Self {
            dt,
            h,
            inv_h,
            substeps: substeps * parts,
            length: config.length_scale,
            per_track: Self::per_track_of(config.length_scale),
            caps: Caps::new(config.length_scale),
            gravity: config.gravity,
            fall: 1.1 * config.gravity.length() * dt * dt,
            margin: c.margin,
            rest_offset: c.rest_offset,
            recycle_distance: c.recycle_distance,
            restitution_speed: c.restitution_speed,
            hit_speed: c.hit_speed,
            push_speed: c.push_speed,
            deep: PART_SPEED * config.length_scale / soft.rate,
            parted: [soft, soft_fixed].map(|soft| PARTED_SPEED * config.length_scale / soft.rate),
            warm_max: WARM_WEIGHTS
                * config.gravity.length().max(MIN_WEIGHT * config.length_scale)
                * h,
            contact_hertz: c.hertz,
            is_soft: !config.method.is_classic(),
            soft,
            soft_fixed,
            inertia: LoadInertia {
                maximum,
                in_parts: config.inertia.refine > 1,
                threshold: config.inertia_threshold(),
                length: config.length_scale,
            },
            soft_joint: Softness::new(swept, config.joint.damping_ratio, h),
            penalty: config.penalty,
            soft_tree: Compliance::new(direct, config.joint.damping_ratio, h),
            hardest_in_trees: Softness::new(direct, config.joint.damping_ratio, h).hardness(),
            tree_ratio: config.joint.tree_ratio,
            impulse_scale: impulse_scale / parts as f32,
            parts,
            subdivision: Subdivision::Whole,
            wakes_alone: config.method.freezes(),
            sleep: SleepConfig {
                enabled: config.sleep.enabled && config.method.sleeps(),
                time: config.sleep.wait(dt),
                speed: config.sleep_speed(),
            },
            rounds: 1,
            level,
        }
    }
}

/// The greatest power of two that does not exceed a number above 0.
const fn power_below(x: f32) -> f32 {
    f32::from_bits(x.to_bits() & 0x7f80_0000)
}

/// Softness of contacts of two dynamic bodies and of contacts with static ones. The stiffness
/// follows from the substep rate [1/s]; it is discretized for substeps of `h` [s].
fn contact_springs(config: &WorldConfig, rate: f32, h: f32) -> [Softness; 2] {
    let c = &config.contact;
    let hertz = contact_hertz(c.hertz, rate);
    let fixed = Softness::new(2.0 * hertz, 0.5 * c.damping_ratio, h);
    [Softness::new(hertz, c.damping_ratio, h), fixed]
}

/// Frequency [Hz] of contacts of two dynamic bodies: `wanted`, clamped for substeps of a rate
/// [1/s].
fn contact_hertz(wanted: f32, rate: f32) -> f32 {
    // The stiffest contact that stays stable is tied to the substep: f h <= 0.11 to 0.125
    // (docs/derivations/soft-step.md).
    let rate = rate.min(1.0 / SHORTEST);
    if wanted > 0.0 { wanted.min(0.25 * rate) } else { 0.1125 * rate }
}
