//! The laws of actuators: every short form becomes the general actuator that it stands for, as
//! MuJoCo's compiler makes it.

use crate::error::SceneError;
use crate::read::xml::Element;
use crate::robot::{Dynamics, Law, NUMBERS};

/// Elements that are read.
pub(super) const TAGS: [&str; 9] = [
    "general",
    "motor",
    "position",
    "velocity",
    "intvelocity",
    "damper",
    "cylinder",
    "muscle",
    "adhesion",
];

/// Laws and their numbers, which elements and their classes set one after the other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Laws {
    /// The short form that set them last.
    form: Option<&'static str>,
    pub(super) dynamics: Dynamics,
    pub(super) dynamics_numbers: [f32; NUMBERS],
    pub(super) gain: Law,
    pub(super) gain_numbers: [f32; NUMBERS],
    pub(super) bias: Law,
    pub(super) bias_numbers: [f32; NUMBERS],
    /// Part of the target's range that its control has.
    pub(super) inherited: f32,
}

/// Numbers that begin with 1.
const ONE: [f32; NUMBERS] = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];

impl Default for Laws {
    fn default() -> Self {
        Self {
            form: None,
            dynamics: Dynamics::None,
            dynamics_numbers: ONE,
            gain: Law::Fixed,
            gain_numbers: ONE,
            bias: Law::None,
            bias_numbers: [0.0; NUMBERS],
            inherited: 0.0,
        }
    }
}

/// Writes over the first numbers.
pub(super) fn over(to: &mut [f32], element: &Element<'_>, name: &str) -> Result<(), SceneError> {
    let list = element.list(name, to.len())?.unwrap_or_default();
    to.iter_mut().zip(list).for_each(|(to, x)| *to = x);
    Ok(())
}

impl Laws {
    pub(super) fn apply(&mut self, element: &Element<'_>) -> Result<(), SceneError> {
        let Some(&tag) = TAGS.iter().find(|tag| **tag == element.tag()) else { return Ok(()) };
        if tag == "general" {
            return self.general(element);
        }
        self.begin(tag);
        self.inherited = element.at_least_zero("inheritrange")?.unwrap_or(self.inherited);
        match tag {
            "position" | "intvelocity" => self.position(element, tag == "intvelocity")?,
            "velocity" => {
                let kv = element.number("kv")?.unwrap_or(self.gain_numbers[0]);
                self.gain_numbers[0] = kv;
                self.bias_numbers[2] = -kv;
                self.bias = Law::Affine;
            }
            "damper" => {
                let kv = element.at_least_zero("kv")?;
                let kv = kv.unwrap_or(if self.gain == Law::Affine {
                    -self.gain_numbers[2]
                } else {
                    0.0
                });
                self.gain_numbers = [0.0; NUMBERS];
                self.gain_numbers[2] = -kv;
                self.gain = Law::Affine;
            }
            "cylinder" => self.cylinder(element)?,
            "muscle" => self.muscle(element)?,
            "adhesion" => over(&mut self.gain_numbers[..1], element, "gain")?,
            // A motor passes its control on.
            _ => {}
        }
        Ok(())
    }

    /// A short form keeps what the same one set before. Of a general actuator it keeps the numbers
    /// that it has itself, if the gain is of its kind.
    fn begin(&mut self, tag: &'static str) {
        let before = self.form.replace(tag);
        if before == Some(tag) {
            return;
        }
        let gain = match tag {
            "damper" => Law::Affine,
            "muscle" => Law::Muscle,
            _ => Law::Fixed,
        };
        if before.is_some() || self.gain != gain || tag == "motor" {
            *self = Self { form: Some(tag), ..Self::default() };
            return;
        }
        let is_exact = self.dynamics == Dynamics::FilterExact;
        let keeps_time = match tag {
            "position" | "intvelocity" => is_exact,
            "cylinder" | "muscle" => true,
            _ => false,
        };
        if !keeps_time {
            (self.dynamics, self.dynamics_numbers) = (Dynamics::None, ONE);
        }
        let [b0, b1, b2, ..] = self.bias_numbers;
        let kept = match tag {
            "position" | "intvelocity" => [0.0, b1, b2],
            "cylinder" => [b0, b1, b2],
            _ => [0.0; 3],
        };
        self.bias = Law::None;
        self.bias_numbers = [0.0; NUMBERS];
        self.bias_numbers[..3].copy_from_slice(&kept);
        if gain == Law::Fixed {
            self.gain_numbers[1..].fill(0.0);
            self.dynamics_numbers[1..].fill(0.0);
        }
    }

    fn general(&mut self, element: &Element<'_>) -> Result<(), SceneError> {
        self.form = None;
        self.inherited = element.at_least_zero("inheritrange")?.unwrap_or(self.inherited);
        over(&mut self.dynamics_numbers, element, "dynprm")?;
        over(&mut self.gain_numbers, element, "gainprm")?;
        over(&mut self.bias_numbers, element, "biasprm")?;
        self.dynamics = match element.get("dyntype") {
            None => self.dynamics,
            Some("none") => Dynamics::None,
            Some("integrator") => Dynamics::Integrator,
            Some("filter") => Dynamics::Filter,
            Some("filterexact") => Dynamics::FilterExact,
            Some("muscle") => Dynamics::Muscle,
            Some("user") => Dynamics::User,
            Some(_) => {
                let allowed = "none, integrator, filter, filterexact, muscle or user";
                return Err(element.wrong("dyntype", allowed));
            }
        };
        let law = |name: &str, before: Law| match element.get(name) {
            None => Ok(before),
            Some("none") if name == "biastype" => Ok(Law::None),
            Some("fixed") if name == "gaintype" => Ok(Law::Fixed),
            Some("affine") => Ok(Law::Affine),
            Some("muscle") => Ok(Law::Muscle),
            Some("user") => Ok(Law::User),
            Some(_) => Err(element.wrong(name, "none or fixed, affine, muscle or user")),
        };
        self.gain = law("gaintype", self.gain)?;
        self.bias = law("biastype", self.bias)?;
        Ok(())
    }

    /// A spring from the control to the position, with a damper.
    fn position(&mut self, element: &Element<'_>, is_rate: bool) -> Result<(), SceneError> {
        let kp = element.number("kp")?.unwrap_or(self.gain_numbers[0]);
        self.gain_numbers[0] = kp;
        self.bias_numbers[1] = -kp;
        self.bias = Law::Affine;
        if let Some(kv) = element.at_least_zero("kv")? {
            self.bias_numbers[2] = -kv;
        }
        if let Some(ratio) = element.at_least_zero("dampratio")? {
            if element.get("kv").is_some() {
                return Err(element.error("it has a kv and a dampratio", "one of them"));
            }
            // As in MuJoCo: above zero, it is a ratio.
            self.bias_numbers[2] = ratio;
        }
        if is_rate {
            self.dynamics = Dynamics::Integrator;
        } else if let Some(time) = element.at_least_zero("timeconst")? {
            self.dynamics_numbers[0] = time;
            self.dynamics = if time > 0.0 { Dynamics::FilterExact } else { Dynamics::None };
        }
        Ok(())
    }

    /// Takes the damping ratio out of the numbers of the bias: a spring's damping above zero is
    /// one.
    pub(super) fn ratio(&mut self) -> Option<f32> {
        let [_, stiffness, ratio, ..] = self.bias_numbers;
        let is_spring = self.gain == Law::Fixed
            && self.bias == Law::Affine
            && self.gain_numbers[0].to_bits() == (-stiffness).to_bits();
        (is_spring && ratio > 0.0).then(|| core::mem::take(&mut self.bias_numbers[2]))
    }

    fn cylinder(&mut self, element: &Element<'_>) -> Result<(), SceneError> {
        over(&mut self.dynamics_numbers[..1], element, "timeconst")?;
        over(&mut self.gain_numbers[..1], element, "area")?;
        if let Some(diameter) = element.at_least_zero("diameter")? {
            self.gain_numbers[0] = core::f32::consts::FRAC_PI_4 * diameter * diameter;
        }
        over(&mut self.bias_numbers[..3], element, "bias")?;
        (self.dynamics, self.bias) = (Dynamics::Filter, Law::Affine);
        Ok(())
    }

    fn muscle(&mut self, element: &Element<'_>) -> Result<(), SceneError> {
        if self.gain != Law::Muscle {
            self.dynamics_numbers = [0.01, 0.04, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
            self.gain_numbers = [0.75, 1.05, -1.0, 200.0, 0.5, 1.6, 1.5, 1.3, 1.2, 0.0];
        }
        over(&mut self.dynamics_numbers[..2], element, "timeconst")?;
        over(&mut self.dynamics_numbers[2..3], element, "tausmooth")?;
        over(&mut self.gain_numbers[..2], element, "range")?;
        let names = ["force", "scale", "lmin", "lmax", "vmax", "fpmax", "fvmax"];
        for (i, name) in names.into_iter().enumerate() {
            over(&mut self.gain_numbers[2 + i..3 + i], element, name)?;
        }
        self.bias_numbers = self.gain_numbers;
        (self.dynamics, self.gain, self.bias) = (Dynamics::Muscle, Law::Muscle, Law::Muscle);
        Ok(())
    }
}
