//! Actuators: force = gain × input + bias, along a transmission.

/// How many numbers a law or the dynamics may have.
pub const NUMBERS: usize = 10;

/// The thing that an actuator pulls at.
#[derive(Clone, Debug, PartialEq)]
pub enum Transmission {
    /// A joint, by its number; for balls and free joints along the gear's axes, in the frame of the
    /// link, or with `in_parent` in that of its parent.
    Joint {
        /// Number of the joint.
        joint: usize,
        /// Whether the gear's axes are those of the parent.
        in_parent: bool,
    },
    /// A tendon, by its number.
    Tendon(usize),
    /// A site, by its number, along the axes of the site or of another one.
    Site {
        /// Number of the site.
        site: usize,
        /// Number of the site whose frame the force is in.
        reference: Option<usize>,
    },
    /// A crank on one site, by a rod at another one that slides along its z.
    Crank {
        /// Number of the crank's site.
        crank: usize,
        /// Number of the slider's site.
        slider: usize,
        /// Length of the rod [m].
        length: f32,
    },
    /// All contacts of a link, by its name: adhesion.
    Link(String),
}

/// The way from control to activation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dynamics {
    /// The control acts at once.
    None,
    /// The control is the rate of the activation.
    Integrator,
    /// The activation follows with the time constant of the first number [s].
    Filter,
    /// The same, integrated exactly.
    FilterExact,
    /// A muscle's: times to activate and to deactivate [s], and the width of the change between
    /// them.
    Muscle,
    /// The user's own.
    User,
}

/// The law of a gain or a bias.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Law {
    /// 0.
    None,
    /// The first number.
    Fixed,
    /// First number, plus the second times length, plus the third times velocity.
    Affine,
    /// A muscle's.
    Muscle,
    /// The user's own.
    User,
}

/// An actuator.
#[derive(Clone, Debug, PartialEq)]
pub struct Actuator {
    /// Its name, empty if it has none.
    pub name: String,
    /// Its transmission.
    pub transmission: Transmission,
    /// Factors from its force to the transmission's: the first for slides, hinges and tendons,
    /// three for balls, six for free joints and sites (force, then torque).
    pub gear: [f32; 6],
    /// Bounds of its control.
    pub control_range: Option<[f32; 2]>,
    /// Bounds of its force.
    pub force_range: Option<[f32; 2]>,
    /// Bounds of its activation.
    pub activation_range: Option<[f32; 2]>,
    /// Least and greatest length of its transmission, if the file says them: muscles need them.
    pub length_range: Option<[f32; 2]>,
    /// How many activations it has.
    pub activations: usize,
    /// The way from control to activation.
    pub dynamics: Dynamics,
    /// Numbers of that.
    pub dynamics_numbers: [f32; NUMBERS],
    /// Whether its force uses the activation at the step's end.
    pub acts_early: bool,
    /// The law of its gain.
    pub gain: Law,
    /// Numbers of that.
    pub gain_numbers: [f32; NUMBERS],
    /// The law of its bias.
    pub bias: Law,
    /// Numbers of that.
    pub bias_numbers: [f32; NUMBERS],
    /// The damping ratio that gives the third number of the bias: -2 ratio √(stiffness × mass at
    /// the transmission in the file's pose).
    pub damping_ratio: Option<f32>,
    /// Inertia of a rotor at the transmission.
    pub armature: f32,
    /// Damping at the transmission, and factors of the second and third power.
    pub damping: [f32; 3],
}
