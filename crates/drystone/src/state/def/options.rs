//! Options of a stepping method, one per technique. Each has a value that selects the method's own
//! choice.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::DefError;

/// Declares an option: its values and their names. The first value is the method's own choice.
macro_rules! option {
    ($(#[$doc:meta])* $name:ident { $($(#[$of:meta])* $value:ident = $word:literal,)+ }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        #[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
        pub enum $name {
            /// The method's own choice.
            #[default]
            Own,
            $($(#[$of])* $value,)+
        }

        impl $name {
            /// The names of the values.
            pub const WORDS: &'static [&'static str] = &["own", $($word,)+];

            /// The name of the value.
            #[must_use]
            pub const fn word(self) -> &'static str {
                match self {
                    Self::Own => "own",
                    $(Self::$value => $word,)+
                }
            }

            /// The value of this name.
            #[must_use]
            pub fn named(word: &str) -> Option<Self> {
                match word {
                    "own" => Some(Self::Own),
                    $($word => Some(Self::$value),)+
                    _ => None,
                }
            }
        }
    };
}

option! {
    /// Order in which a sweep visits the rows.
    Order {
        /// Colors: rows of a color share no body.
        Colors = "colors",
        /// From the ground up, by levels of the contact graph; bodies that support each other in a
        /// cycle share a level [Guendelman03].
        Levels = "levels",
        /// By the same levels from the top down: the unfavorable order, for comparison.
        TopDown = "top-down",
        /// In a deterministic shuffled order.
        Random = "random",
    }
}

option! {
    /// Technique against the compression of stacks by their own weight.
    Shock {
        /// No technique.
        Off = "off",
        /// Load-adaptive inertia: heavily loaded bodies respond slowly.
        Inertia = "inertia",
        /// Shock propagation: a last sweep from the ground up, in which lower bodies are immovable
        /// [Guendelman03].
        Full = "full",
    }
}

option! {
    /// Whether a step starts from the impulses of the last one [Catto05].
    Persistence {
        /// It does.
        On = "on",
        /// Every step starts from zero impulses.
        Off = "off",
    }
}

option! {
    /// Removal of overlaps.
    Overlap {
        /// By a velocity bias that a last sweep removes again.
        Relax = "relax",
        /// By a velocity bias, which stays in the velocity.
        VelocityBias = "velocity-bias",
        /// By moving bodies, level by level from the ground up, without a change of velocity.
        PushOut = "push-out",
        /// No removal.
        Nothing = "none",
    }
}

option! {
    /// Treatment of bodies at rest.
    Rest {
        /// Islands sleep, under the conditions of the sleep configuration.
        Sleep = "sleep",
        /// Bodies freeze one by one, as soon as they and all their supports are at rest
        /// [Schmidl04]. The sleep configuration sets the time. Islands sleep too.
        Freeze = "freeze",
        /// Bodies at rest are simulated forever.
        Nothing = "none",
    }
}

option! {
    /// Integration of bodies without contacts.
    Integration {
        /// Exactly along their parabola.
        Exact = "exact",
        /// Symplectic Euler: velocity first, then position with the new velocity.
        Euler = "euler",
        /// Verlet: the velocity is the displacement of the last substep over time. The path equals
        /// Euler's until something moves a body, because that displacement then counts as velocity
        /// too.
        Verlet = "verlet",
    }
}

option! {
    /// Integration of a body's damping.
    Damping {
        /// `exp(-c h)`.
        Exponential = "exponential",
        /// `1 / (1 + c h)`: Padé's approximation, which never reverses a velocity.
        Pade = "pade",
        /// No damping.
        Nothing = "none",
    }
}

/// The options of a method.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct MethodOptions {
    /// Order of the rows.
    pub order: Order,
    /// Shock propagation.
    pub shock: Shock,
    /// Contact persistence.
    pub persistence: Persistence,
    /// Removal of overlaps.
    pub overlap: Overlap,
    /// Bodies at rest.
    pub rest: Rest,
    /// Free flight.
    pub integration: Integration,
    /// Damping.
    pub damping: Damping,
    /// Sweeps over the rows per substep, 0 to 100,000; 0 (the default): the method's own number.
    pub sweeps: u32,
}

/// Maximum number of sweeps.
const MAX_SWEEPS: u32 = 100_000;

impl MethodOptions {
    /// Sets an option from text; `None` if no option has this path.
    pub(crate) fn set(&mut self, path: &str, text: &str) -> Option<Result<(), DefError>> {
        fn put<T>(
            field: &mut T,
            path: &str,
            text: &str,
            value: Option<T>,
            words: &[&str],
        ) -> Result<(), DefError> {
            *field = value.ok_or_else(|| {
                DefError::new(path, text, &format!("one of {}", words.join(", ")))
            })?;
            Ok(())
        }
        let t = text;
        Some(match path {
            "method.order" => put(&mut self.order, path, t, Order::named(t), Order::WORDS),
            "method.shock" => put(&mut self.shock, path, t, Shock::named(t), Shock::WORDS),
            "method.persistence" => {
                put(&mut self.persistence, path, t, Persistence::named(t), Persistence::WORDS)
            }
            "method.overlap" => put(&mut self.overlap, path, t, Overlap::named(t), Overlap::WORDS),
            "method.rest" => put(&mut self.rest, path, t, Rest::named(t), Rest::WORDS),
            "method.integration" => {
                put(&mut self.integration, path, t, Integration::named(t), Integration::WORDS)
            }
            "method.damping" => put(&mut self.damping, path, t, Damping::named(t), Damping::WORDS),
            "method.sweeps" => {
                let value = t.parse().ok().filter(|n| *n <= MAX_SWEEPS);
                put(&mut self.sweeps, path, t, value, &["from 0 (the method's own) to 100000"])
            }
            _ => return None,
        })
    }

    pub(crate) fn check_numbers(&self) -> Result<(), DefError> {
        if self.sweeps > MAX_SWEEPS {
            let allowed = "from 0 (the method's own) to 100000";
            return Err(DefError::new("method.sweeps", self.sweeps, allowed));
        }
        Ok(())
    }
}
