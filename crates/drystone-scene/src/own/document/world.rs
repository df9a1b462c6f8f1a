//! Settings of the world.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::own::value::{Or, Triple};

/// Settings of the world, by the paths of `--set`.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct World {
    /// Acceleration of free bodies [m/s², world]; default `[0, -9.81, 0]`.
    pub(crate) gravity: Option<Triple>,
    /// Length of a typical body in the unit of lengths of this scene, 1e-4 to 1e4; default 1:
    /// meters. Tolerances follow it.
    pub(crate) length_scale: Option<f32>,
    /// How a step is made: a name, or a name with options; default `soft-step`.
    pub(crate) method: Option<Or<Method>>,
    /// Solver substeps a step, 1 to 256; 0 (the default): the method's own number.
    pub(crate) substeps: Option<u32>,
    /// Contacts.
    pub(crate) contact: Option<Contact>,
    /// Load-adaptive inertia.
    pub(crate) inertia: Option<Inertia>,
    /// Joints.
    pub(crate) joint: Option<Joints>,
    /// Particles.
    pub(crate) particle: Option<Particles>,
    /// Springs of the penalty methods.
    pub(crate) penalty: Option<Penalty>,
    /// Sleep.
    pub(crate) sleep: Option<Sleep>,
    /// Bodies that come apart.
    pub(crate) breakage: Option<Breakage>,
}

/// A stepping method with its options; `own` leaves an option to the method.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Method {
    /// One of `drystone methods`.
    pub(crate) name: String,
    /// Order of rows: `own`, `colors`, `levels`, `top-down`, `random`.
    pub(crate) order: Option<String>,
    /// How weight is kept from pressing down the bodies below: `own`, `off`, `inertia`, `full`.
    pub(crate) shock: Option<String>,
    /// Whether impulses go on from step to step: `own`, `on`, `off`.
    pub(crate) persistence: Option<String>,
    /// How overlaps are removed: `own`, `relax`, `velocity-bias`, `push-out`, `none`.
    pub(crate) overlap: Option<String>,
    /// Bodies at rest: `own`, `sleep`, `freeze`, `none`.
    pub(crate) rest: Option<String>,
    /// Free flight: `own`, `exact`, `euler`, `verlet`.
    pub(crate) integration: Option<String>,
    /// How damping takes velocity: `own`, `exponential`, `pade`, `none`.
    pub(crate) damping: Option<String>,
    /// Sweeps over the rows in a substep, 1 to 100,000; 0 (the default): the method's own number.
    pub(crate) sweeps: Option<u32>,
}

/// Options by their names, with the words that were given.
pub(crate) type MethodOptions<'a> = [(&'static str, Option<&'a str>); 7];

impl Method {
    /// The options that are words.
    pub(crate) fn words(&self) -> MethodOptions<'_> {
        [
            ("order", self.order.as_deref()),
            ("shock", self.shock.as_deref()),
            ("persistence", self.persistence.as_deref()),
            ("overlap", self.overlap.as_deref()),
            ("rest", self.rest.as_deref()),
            ("integration", self.integration.as_deref()),
            ("damping", self.damping.as_deref()),
        ]
    }
}

/// Contacts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Contact {
    /// Stiffness as a frequency [Hz]; 0 (the default): 0.1125 per substep time.
    pub(crate) hertz: Option<f32>,
    /// Damping ratio; at least 0; default 8.
    pub(crate) damping_ratio: Option<f32>,
    /// Bodies that overlap are pushed apart no faster than this [m/s]; above 0; default 0.25.
    pub(crate) push_speed: Option<f32>,
    /// Bodies at rest are held this far apart [m]; at least 0; default 5e-5.
    pub(crate) rest_offset: Option<f32>,
    /// Contact points are made from this distance on [m]; above 0; default 0.02.
    pub(crate) margin: Option<f32>,
    /// Points of a contact stay while its bodies move less than this against each other [m]; at
    /// least 0; default 0.05.
    pub(crate) recycle_distance: Option<f32>,
    /// Contacts that meet slower than this do not bounce [m/s]; at least 0; default 0.
    pub(crate) restitution_speed: Option<f32>,
    /// Contacts that meet faster than this are hits [m/s]; at least 0; default 1.
    pub(crate) hit_speed: Option<f32>,
}

/// Load-adaptive inertia.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Inertia {
    /// Maximum factor, 1 to 64; 1: off; 0 (the default): the method's own.
    pub(crate) max_factor: Option<f32>,
    /// Loads above this per mass raise the factor [m/s²]; above 0; default 30.
    pub(crate) threshold: Option<f32>,
    /// Times the substeps where a factor is near its greatest, 1 to 8; default 1.
    pub(crate) refine: Option<u32>,
}

/// Joints.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Joints {
    /// Stiffness as a frequency [Hz]; 0 (the default): 0.15 per substep time, 0.25 of trees.
    pub(crate) hertz: Option<f32>,
    /// Damping ratio; at least 0; default 2.
    pub(crate) damping_ratio: Option<f32>,
    /// Trees are solved at once where a body carries at least this many times its own mass; at
    /// least 0; default 20.
    pub(crate) tree_ratio: Option<f32>,
    /// Times the substeps where joints go round fast or are hit, 1 to 8; default 4.
    pub(crate) refine: Option<u32>,
}

/// Particles.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Particles {
    /// How links and contacts are solved; default `own`.
    pub(crate) form: Option<ParticleForm>,
    /// Sweeps in a substep, at most 1000; 0 (the default): 2 of the soft form, 10 of the others.
    pub(crate) sweeps: Option<u32>,
    /// Stiffness of rods and threads as a frequency [Hz]; 0 (the default): 1 per substep time.
    pub(crate) hertz: Option<f32>,
    /// Damping ratio; at least 0; default 2.
    pub(crate) damping_ratio: Option<f32>,
}

/// How links and contacts of particles are solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum ParticleForm {
    /// As the method has it.
    Own,
    /// Soft rows that keep their impulses.
    Soft,
    /// All of the error is taken out in every substep.
    Aim,
    /// Positions are projected.
    Verlet,
}

/// Springs of the penalty methods.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Penalty {
    /// Stiffness of a contact point as a frequency [Hz]; above 0; default 30.
    pub(crate) hertz: Option<f32>,
    /// Damping ratio; at least 0; default 0.5.
    pub(crate) damping_ratio: Option<f32>,
}

/// Sleep.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Sleep {
    /// Whether still islands fall asleep; default true.
    pub(crate) enabled: Option<bool>,
    /// A body is slow if no point of it moves faster than this [m/s]; at least 0; default 0.05.
    pub(crate) speed: Option<f32>,
    /// An island sleeps when it was still for this long [s]; at least 0; default 0.5.
    pub(crate) time: Option<f32>,
}

/// Bodies that come apart.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct Breakage {
    /// Most pieces of fractured bodies at a time; default 4096.
    pub(crate) max_pieces: Option<u32>,
}
