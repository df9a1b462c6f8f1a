//! Stepping methods as data: the passes over the rows, in order.

mod settle;

pub(crate) use self::settle::Settings;

use core::mem::take;

#[cfg(feature = "serde")]
use serde::de::Error;
#[cfg(feature = "serde")]
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::DefError;
use super::options::{MethodOptions, Persistence, Rest, Shock};

/// One pass of the solver over bodies, colors or levels.
///
/// The first five run over blocks of eight rows; the others, for the classic methods, over single
/// rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pass {
    /// Bodies: forces, free rotation, and the warm start stored per body.
    Velocities,
    /// Colors: joints, then contacts, with bias and softness; `inner` Gauss-Seidel sweeps over the
    /// points of a manifold.
    Solve {
        /// Sweeps over a manifold, 1 to 8.
        inner: u32,
    },
    /// Bodies: integrates positions from velocities.
    Positions,
    /// Colors: joints, then contacts, without bias. It removes the velocity that the bias added.
    Relax,
    /// Islands: reflects bodies that meet within the time of a substep. It comes before every sweep
    /// that could stop them: solve and relax.
    Impacts,

    /// Bodies: forces, free rotation, damping.
    Forces,
    /// Rows: applies the impulses of the last step.
    WarmStart,
    /// Rows: reflects approaching points that would overlap at the end of the substep, one after
    /// the other.
    Bounce {
        /// Maximum number of sweeps over all rows; 0: the method's sweeps.
        sweeps: u32,
        /// Whether forces are applied later in this substep. They then count for the predicted
        /// positions, but not for the reflected velocity.
        before_forces: bool,
    },
    /// Levels: stops bodies that would overlap. The restitution rises from near -1 to 0 over the
    /// sweeps, so that loads spread before contacts become rigid.
    Stop,
    /// Levels: stops bodies that would overlap once more, from the ground up, with lower bodies
    /// immovable.
    Shock,
    /// Levels: moves overlapping bodies apart.
    PushOut,
    /// Rows: solves for accumulated impulses, clamped as sums, with the bias of the method.
    Accumulate,
    /// Rows: the same without bias.
    AccumulateRelaxed,
    /// Rows: applies a damped spring force at every overlap.
    Springs,
    /// Rows: solves the damped springs together with the velocities that they cause.
    ImplicitSprings,
    /// Rows: projects the positions at the end of the substep until nothing overlaps.
    Project,
    /// Rows: solves for accumulated impulses in double precision until the residual is below a
    /// millionth.
    Converge,
}

/// The rows on which a method runs, which determine its possible options.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Family {
    /// Blocks of eight rows.
    Wide,
    Naive,
    Sequential,
    Guendelman,
    PenaltyExplicit,
    PenaltyImplicit,
    Analytic,
    Verlet,
}

/// A named list of passes. The manual: [methods](crate::manual::methods).
#[derive(Debug, PartialEq)]
pub struct Method {
    name: &'static str,
    summary: &'static str,
    family: Family,
    substeps: u32,
    sweeps: u32,
    inertia: f32,
    substep: Vec<Pass>,
    finish: Vec<Pass>,
    options: MethodOptions,
}

impl Clone for Method {
    fn clone(&self) -> Self {
        Self { substep: self.substep.clone(), finish: self.finish.clone(), ..*self }
    }

    /// Reuses the existing lists.
    fn clone_from(&mut self, from: &Self) {
        let (mut substep, mut finish) = (take(&mut self.substep), take(&mut self.finish));
        substep.clone_from(&from.substep);
        finish.clone_from(&from.finish);
        *self = Self { substep, finish, ..*from };
    }
}

impl Method {
    /// The names of [`Self::named`].
    pub const NAMES: &'static [&'static str] = &[
        "soft-step",
        "soft-step-relax",
        "guendelman",
        "sequential-impulses",
        "naive",
        "penalty",
        "penalty-implicit",
        "analytic",
        "verlet",
    ];

    /// The default: one fused sweep per substep, one relax sweep per step; 8 substeps.
    #[must_use]
    pub fn soft_step() -> Self {
        Self {
            substeps: 8,
            inertia: 8.0,
            substep: vec![
                Pass::Velocities,
                Pass::Impacts,
                Pass::Solve { inner: 2 },
                Pass::Positions,
            ],
            finish: vec![Pass::Impacts, Pass::Relax],
            ..Self::of(
                "soft-step",
                "8 substeps of impacts and one soft sweep each, one relax sweep at the end",
                Family::Wide,
            )
        }
    }

    /// The common scheme of today's engines with our rows: 4 substeps, each with a soft and a relax
    /// sweep [Catto24].
    #[must_use]
    pub fn soft_step_relax() -> Self {
        Self {
            substeps: 4,
            substep: vec![
                Pass::Velocities,
                Pass::Impacts,
                Pass::Solve { inner: 1 },
                Pass::Positions,
                Pass::Impacts,
                Pass::Relax,
            ],
            ..Self::of(
                "soft-step-relax",
                "4 substeps of impacts, a soft and a relax sweep each",
                Family::Wide,
            )
        }
    }

    /// Collisions before forces, contacts after them, in order of levels from the ground up, with
    /// shock propagation and push-out [Guendelman03].
    #[must_use]
    pub fn guendelman() -> Self {
        Self {
            sweeps: 10,
            substep: vec![
                Pass::Bounce { sweeps: 5, before_forces: true },
                Pass::Forces,
                Pass::Stop,
                Pass::Shock,
                Pass::Positions,
                Pass::PushOut,
            ],
            ..Self::of(
                "guendelman",
                "collisions, forces, contacts by level, shock propagation, push-out",
                Family::Guendelman,
            )
        }
    }

    /// Accumulated impulses that persist between steps, and a velocity bias [Catto05].
    #[must_use]
    pub fn sequential_impulses() -> Self {
        Self {
            sweeps: 10,
            substep: vec![
                Pass::Forces,
                Pass::WarmStart,
                Pass::Accumulate,
                Pass::Shock,
                Pass::Positions,
                Pass::AccumulateRelaxed,
                Pass::PushOut,
            ],
            ..Self::of(
                "sequential-impulses",
                "accumulated impulses that persist from step to step",
                Family::Sequential,
            )
        }
    }

    /// Update, then collide: the failing baseline.
    #[must_use]
    pub fn naive() -> Self {
        Self {
            sweeps: 1,
            substep: vec![
                Pass::Forces,
                Pass::Bounce { sweeps: 0, before_forces: false },
                Pass::Shock,
                Pass::Positions,
                Pass::PushOut,
            ],
            ..Self::of(
                "naive",
                "update, then collide: the baseline that fails, for comparison",
                Family::Naive,
            )
        }
    }

    /// Contacts as damped springs with the forces of the substep's start.
    #[must_use]
    pub fn penalty() -> Self {
        Self {
            substeps: 16,
            substep: vec![Pass::Springs, Pass::Forces, Pass::Positions],
            ..Self::of(
                "penalty",
                "contacts as damped springs, explicit: diverges beyond a limit of stiffness",
                Family::PenaltyExplicit,
            )
        }
    }

    /// Contacts as damped springs, solved together with the velocities that they cause.
    #[must_use]
    pub fn penalty_implicit() -> Self {
        Self {
            sweeps: 10,
            substep: vec![Pass::Forces, Pass::WarmStart, Pass::ImplicitSprings, Pass::Positions],
            ..Self::of(
                "penalty-implicit",
                "contacts as damped springs, implicit: stable for every stiffness",
                Family::PenaltyImplicit,
            )
        }
    }

    /// The contact problem solved to a millionth: the slow reference for the other methods.
    #[must_use]
    pub fn analytic() -> Self {
        Self {
            substep: vec![
                Pass::Forces,
                Pass::WarmStart,
                Pass::Converge,
                Pass::Positions,
                Pass::PushOut,
            ],
            ..Self::of(
                "analytic",
                "the contact problem solved to a relative residual of 1e-6: the reference, slow",
                Family::Analytic,
            )
        }
    }

    /// Positions are projected, and velocity follows from displacement [Jakobsen01].
    #[must_use]
    pub fn verlet() -> Self {
        Self {
            sweeps: 10,
            substep: vec![Pass::Forces, Pass::Project, Pass::Positions],
            ..Self::of(
                "verlet",
                "positions are projected out of overlap; velocity is the way moved",
                Family::Verlet,
            )
        }
    }

    fn of(name: &'static str, summary: &'static str, family: Family) -> Self {
        Self {
            name,
            summary,
            family,
            substeps: 1,
            sweeps: 0,
            inertia: 1.0,
            substep: Vec::new(),
            finish: Vec::new(),
            options: MethodOptions::default(),
        }
    }

    /// The method of this name, if there is one.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "soft-step" => Some(Self::soft_step()),
            "soft-step-relax" => Some(Self::soft_step_relax()),
            "guendelman" => Some(Self::guendelman()),
            "sequential-impulses" => Some(Self::sequential_impulses()),
            "naive" => Some(Self::naive()),
            "penalty" => Some(Self::penalty()),
            "penalty-implicit" => Some(Self::penalty_implicit()),
            "analytic" => Some(Self::analytic()),
            "verlet" => Some(Self::verlet()),
            _ => None,
        }
    }

    /// Its name.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        self.name
    }

    /// A one-line description.
    #[must_use]
    pub const fn summary(&self) -> &'static str {
        self.summary
    }

    /// Number of substeps per step, unless the world's configuration sets another.
    #[must_use]
    pub const fn substeps(&self) -> u32 {
        self.substeps
    }

    /// Maximum factor of load-adaptive inertia, unless the world's configuration sets another; 1:
    /// none.
    #[must_use]
    pub const fn inertia(&self) -> f32 {
        match self.options.shock {
            Shock::Off => 1.0,
            Shock::Inertia => 8.0,
            Shock::Own | Shock::Full => self.inertia,
        }
    }

    /// The passes of a substep. Passes of a disabled option do nothing.
    #[must_use]
    pub fn substep(&self) -> &[Pass] {
        &self.substep
    }

    /// The passes after the last substep.
    #[must_use]
    pub fn finish(&self) -> &[Pass] {
        &self.finish
    }

    /// The options.
    #[must_use]
    pub const fn options(&self) -> &MethodOptions {
        &self.options
    }

    /// The method with these options.
    ///
    /// # Errors
    /// An option that does not suit this method, with the reason.
    pub fn with_options(mut self, options: MethodOptions) -> Result<Self, DefError> {
        self.options = options;
        self.settle()?;
        Ok(self)
    }

    /// True if it runs over single rows rather than blocks of eight.
    pub(crate) fn is_classic(&self) -> bool {
        self.family != Family::Wide
    }

    /// True if it projects positions.
    pub(crate) fn is_verlet(&self) -> bool {
        self.family == Family::Verlet
    }

    /// Whether a step starts from the impulses of the last one.
    pub(crate) fn persists(&self) -> bool {
        match self.options.persistence {
            Persistence::On => true,
            Persistence::Off => false,
            Persistence::Own => matches!(
                self.family,
                Family::Wide | Family::Sequential | Family::PenaltyImplicit | Family::Analytic
            ),
        }
    }

    /// Whether still islands may sleep.
    pub(crate) fn sleeps(&self) -> bool {
        self.options.rest != Rest::Nothing
    }

    /// Whether bodies freeze one by one.
    pub(crate) fn freezes(&self) -> bool {
        self.options.rest == Rest::Freeze
    }

    /// Number of sweeps over the contacts in a step with this many substeps, for a method of
    /// blocks.
    pub(crate) fn wide_sweeps(&self, substeps: u32) -> u32 {
        let count = |passes: &[Pass]| {
            let sweeps = passes.iter().filter(|p| matches!(p, Pass::Solve { .. } | Pass::Relax));
            u32::try_from(sweeps.count()).unwrap_or(u32::MAX)
        };
        (count(&self.substep) * substeps).saturating_add(count(&self.finish))
    }

    /// Sets an option from text; `None` if no option has this path.
    pub(crate) fn set_option(&mut self, path: &str, text: &str) -> Option<Result<(), DefError>> {
        self.options.set(path, text)
    }
}

/// Serialized as its name and its options.
#[cfg(feature = "serde")]
impl Serialize for Method {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        (self.name, self.options).serialize(serializer)
    }
}

#[cfg(feature = "serde")]
impl<'de> Deserialize<'de> for Method {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let (name, options) = <(String, MethodOptions)>::deserialize(deserializer)?;
        let unknown = || D::Error::custom(format!("there is no method '{name}'"));
        Self::named(&name).ok_or_else(unknown)?.with_options(options).map_err(D::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::Method;
    use crate::state::def::options::{MethodOptions, Order, Overlap, Shock};

    #[test]
    fn every_name_has_its_method_and_every_method_its_own_options() {
        for name in Method::NAMES.iter().copied() {
            let method = Method::named(name).unwrap();
            assert_eq!(method.name(), name);
            method.settle().unwrap();
            assert!(!method.substep().is_empty());
        }
    }

    #[test]
    fn combinations_that_make_no_sense_are_refused_with_the_reason() {
        let with = |name: &str, options: MethodOptions| {
            Method::named(name).unwrap().with_options(options).map_err(|e| e.to_string())
        };
        let own = MethodOptions::default();
        let levels = MethodOptions { order: Order::Levels, ..own };
        assert!(with("soft-step", levels).unwrap_err().contains("eight at a time"));
        assert!(with("sequential-impulses", levels).is_ok());
        let shock = MethodOptions { shock: Shock::Full, ..own };
        assert!(with("soft-step", shock).unwrap_err().contains("friction"));
        assert!(with("naive", shock).is_ok());
        let overlap = MethodOptions { overlap: Overlap::PushOut, ..own };
        assert!(with("verlet", overlap).unwrap_err().contains("projection"));
        let sweeps = MethodOptions { sweeps: 100_001, ..own };
        assert!(with("naive", sweeps).unwrap_err().contains("100000"));
    }
}
