//! Options of a method that go together, and those that do not.

use crate::state::def::DefError;
use crate::state::def::method::{Family, Method};
use crate::state::def::options::{Damping, Integration, Order, Overlap, Persistence, Shock};

/// The options of a method with every value resolved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Settings {
    pub(crate) order: Order,
    pub(crate) shock: Shock,
    pub(crate) persistence: bool,
    pub(crate) overlap: Overlap,
    pub(crate) integration: Integration,
    pub(crate) damping: Damping,
    pub(crate) sweeps: u32,
}

impl Method {
    /// The options with every value resolved.
    ///
    /// # Errors
    /// An option that does not suit this method, with the reason.
    pub(crate) fn settle(&self) -> Result<Settings, DefError> {
        use Family::{Analytic, Guendelman, Naive, PenaltyExplicit, Verlet, Wide};
        let (o, f) = (&self.options, self.family);
        o.check_numbers()?;
        if o.persistence == Persistence::On
            && matches!(f, Naive | Guendelman | Verlet | PenaltyExplicit)
        {
            return self.no(
                "method.persistence",
                "on",
                "off, because its impulses are not accumulated",
            );
        }
        if f == Wide && !matches!(o.damping, Damping::Own | Damping::Pade) {
            return self.no(
                "method.damping",
                o.damping.word(),
                "pade, because it is part of the kernel",
            );
        }
        if o.sweeps > 0 && matches!(f, Wide | PenaltyExplicit | Analytic) {
            let reason = "0, because it makes as many sweeps as it needs";
            return self.no("method.sweeps", &o.sweeps.to_string(), reason);
        }
        Ok(Settings {
            order: self.settle_order()?,
            shock: self.settle_shock()?,
            persistence: self.persists(),
            overlap: self.settle_overlap()?,
            integration: self.settle_integration()?,
            damping: if o.damping == Damping::Own { Damping::Pade } else { o.damping },
            sweeps: if o.sweeps > 0 { o.sweeps } else { self.sweeps },
        })
    }

    /// Refuses a value that does not suit the method.
    fn no<T>(&self, path: &str, word: &str, allowed: &str) -> Result<T, DefError> {
        Err(DefError::unsuitable(path, word, &format!("{allowed} (method {})", self.name)))
    }

    fn settle_order(&self) -> Result<Order, DefError> {
        let o = self.options.order;
        let no = |reason: &str| self.no("method.order", o.word(), reason);
        match (o, self.family) {
            (Order::Own, Family::Guendelman) => Ok(Order::Levels),
            (Order::Own | Order::Colors, _) => Ok(Order::Colors),
            (_, Family::Wide) => no("colors, because rows are solved eight at a time"),
            (_, Family::PenaltyExplicit) => no("own, because forces have no order"),
            (_, Family::Analytic) => no("own, because all rows are solved at once"),
            (chosen, _) => Ok(chosen),
        }
    }

    fn settle_shock(&self) -> Result<Shock, DefError> {
        use Family::{Guendelman, Naive, Sequential, Wide};
        match (self.options.shock, self.family) {
            (Shock::Own, Guendelman) | (Shock::Full, Guendelman | Sequential | Naive) => {
                Ok(Shock::Full)
            }
            (Shock::Own | Shock::Off, _) => Ok(Shock::Off),
            (Shock::Inertia, Wide) => Ok(Shock::Inertia),
            (Shock::Inertia, _) => {
                let reason = "off, because only soft-step and soft-step-relax weigh loads";
                self.no("method.shock", "inertia", reason)
            }
            (Shock::Full, Wide) => {
                let reason = "inertia or off, because infinite masses between frozen rows would \
                              carry the load themselves, and friction with it";
                self.no("method.shock", "full", reason)
            }
            (Shock::Full, _) => {
                let reason = "off, because it has no sweep whose remainder a shock could take";
                self.no("method.shock", "full", reason)
            }
        }
    }

    fn settle_overlap(&self) -> Result<Overlap, DefError> {
        use Family::{
            Analytic, Guendelman, Naive, PenaltyExplicit, PenaltyImplicit, Sequential, Verlet, Wide,
        };
        let o = self.options.overlap;
        let no = |reason: &str| self.no("method.overlap", o.word(), reason);
        match (o, self.family) {
            (Overlap::Own | Overlap::Relax, Wide) => Ok(Overlap::Relax),
            (_, Wide) => no("relax, because its passes end with it"),
            (Overlap::Own, Sequential | Analytic) => Ok(Overlap::VelocityBias),
            (Overlap::Own, Guendelman) => Ok(Overlap::PushOut),
            (Overlap::Own, _) => Ok(Overlap::Nothing),
            (_, PenaltyExplicit | PenaltyImplicit) => no("own, because its springs remove overlap"),
            (_, Verlet) => no("own, because its projection removes overlap"),
            (Overlap::Relax | Overlap::VelocityBias, Naive | Guendelman) => {
                no("push-out or none, because its impulses have no bias")
            }
            (Overlap::Relax, Analytic) => {
                no("velocity-bias, push-out or none, because it has no sweep to relax with")
            }
            (chosen, _) => Ok(chosen),
        }
    }

    fn settle_integration(&self) -> Result<Integration, DefError> {
        let o = self.options.integration;
        let no = |reason: &str| self.no("method.integration", o.word(), reason);
        match (o, self.family) {
            (Integration::Own | Integration::Verlet, Family::Verlet) => Ok(Integration::Verlet),
            (_, Family::Verlet) => no("verlet, because it has no other velocity"),
            (Integration::Verlet, _) => {
                no("exact or euler, because velocity from displacement is the method verlet")
            }
            (Integration::Euler, Family::Wide) => {
                no("exact, because bodies in flight are not part of the solve")
            }
            (Integration::Own | Integration::Exact, _) => Ok(Integration::Exact),
            (Integration::Euler, _) => Ok(Integration::Euler),
        }
    }
}
