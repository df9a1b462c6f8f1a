//! Strength of a joint: the loads at which it breaks.

use crate::state::def::DefError;
use crate::state::def::check::above_zero;
#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

/// The load limits of a joint. It breaks at the end of a step in which its load exceeded a limit:
/// it is removed and reported in [`crate::events::Events::joint_break`]. Force and torque are
/// averages over each substep of the step, however finely an island subdivides it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct JointStrength {
    /// Maximum force [N], above 0; may be infinite (the default).
    pub force: f32,
    /// Maximum torque of a joint of six axes [N m], above 0; may be infinite (the default).
    pub torque: f32,
    /// Maximum impulse in a step [N s], above 0; may be infinite (the default). It is the force
    /// integrated over the step, so an impact counts fully in whichever substep it comes.
    pub impulse: f32,
    /// Wear by loads below these limits; default `None`: no wear.
    pub fatigue: Option<Fatigue>,
}

/// Wear of a joint by loads below its limits. Damage grows by (load / limit)^`exponent` × time /
/// `life` while the load ratio, the larger one of force and torque, is at least `endurance`. The
/// joint breaks when damage reaches 1. Damage is a sum, independent of the order of loads
/// [Miner45], at a rate that is a power of the load [Basquin10]. The impulse does not count.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct Fatigue {
    /// Time until a load equal to the limit breaks the joint [s]; above 0.
    pub life: f32,
    /// Power of the load, 1 to 32; metals have 3 to 10.
    pub exponent: u32,
    /// Fraction of the limits below which a load causes no damage; 0 to 1.
    pub endurance: f32,
}

impl Default for JointStrength {
    /// No limits.
    fn default() -> Self {
        let force = f32::INFINITY;
        Self { force, torque: force, impulse: force, fatigue: None }
    }
}

impl JointStrength {
    pub(crate) fn validate(&self) -> Result<(), DefError> {
        let limits = [("force", self.force), ("torque", self.torque), ("impulse", self.impulse)];
        for (name, value) in limits {
            if value != f32::INFINITY {
                above_zero(name, value)?;
            }
        }
        let Some(fatigue) = self.fatigue else { return Ok(()) };
        fatigue.validate().map_err(|e| e.within("fatigue"))
    }
}

impl Fatigue {
    fn validate(&self) -> Result<(), DefError> {
        above_zero("life", self.life)?;
        if !(1..=32).contains(&self.exponent) {
            return Err(DefError::new("exponent", self.exponent, "a number from 1 to 32"));
        }
        if !(0.0..=1.0).contains(&self.endurance) {
            return Err(DefError::new("endurance", self.endurance, "a number from 0 to 1"));
        }
        Ok(())
    }

    /// Damage by a load of this fraction of the limit in a time [s].
    pub(crate) fn damage(&self, part: f32, time: f32) -> f32 {
        if !(part >= self.endurance) {
            return 0.0;
        }
        (0..self.exponent).fold(time / self.life, |damage, _| damage * part)
    }
}
