//! What can be switched of a stepping method, one technique at a time; each has a value that leaves it to
//! the method.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::def::DefError;

/// Declares an option: its values with the words they are written as. The first is the method's own.
macro_rules! option {
    ($(#[$doc:meta])* $name:ident { $($(#[$of:meta])* $value:ident = $word:literal,)+ }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        #[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
        pub enum $name {
            /// As the method has it.
            #[default]
            Own,
            $($(#[$of])* $value,)+
        }

        impl $name {
            /// The words for its values.
            pub const WORDS: &'static [&'static str] = &["own", $($word,)+];

            /// The word for it.
            #[must_use]
            pub const fn word(self) -> &'static str {
                match self {
                    Self::Own => "own",
                    $(Self::$value => $word,)+
                }
            }

            /// The value of this word.
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
    /// In which order a sweep goes through the rows.
    Order {
        /// Colors: rows of a color share no body.
        Colors = "colors",
        /// From the ground up, by levels of the contact graph; bodies that support each other in a circle
        /// share a level [Guendelman03].
        Levels = "levels",
        /// By the same levels from the top down: the wrong way round, to see what that costs.
        TopDown = "top-down",
        /// Shuffled, by a fixed rule.
        Random = "random",
    }
}

option! {
    /// What keeps the weight of what lies above from pressing down what lies below.
    Shock {
        /// Nothing.
        Off = "off",
        /// Load-adaptive inertia: what is squeezed hard answers slowly.
        Inertia = "inertia",
        /// Shock propagation: a last sweep from the ground up, in which what lies below cannot be pushed
        /// [Guendelman03].
        Full = "full",
    }
}

option! {
    /// Whether impulses of the last step are where the next one starts [Catto05].
    Persistence {
        /// They are.
        On = "on",
        /// Every step starts from nothing.
        Off = "off",
    }
}

option! {
    /// How overlaps are removed.
    Overlap {
        /// By a bias in the velocity that a last sweep takes out again.
        Relax = "relax",
        /// By a bias in the velocity, which stays.
        VelocityBias = "velocity-bias",
        /// By moving bodies, level by level from the ground up, at no velocity.
        PushOut = "push-out",
        /// Not at all.
        Nothing = "none",
    }
}

option! {
    /// What becomes of bodies at rest.
    Rest {
        /// Islands sleep, as the configuration of sleep says.
        Sleep = "sleep",
        /// Bodies freeze one by one, as soon as they and all that carries them have come to rest
        /// [Schmidl04]; the configuration of sleep says after what time. Islands sleep too.
        Freeze = "freeze",
        /// They are simulated for ever.
        Nothing = "none",
    }
}

option! {
    /// How bodies move that nothing touches.
    Integration {
        /// Along their parabola.
        Exact = "exact",
        /// Symplectic Euler: velocity first, then position with the new velocity.
        Euler = "euler",
        /// Verlet: the velocity is the way of the last substep. (The same path as Euler's, until something
        /// moves a body: then that is velocity too.)
        Verlet = "verlet",
    }
}

option! {
    /// How a body's damping takes its velocity.
    Damping {
        /// `exp(-c h)`.
        Exponential = "exponential",
        /// `1 / (1 + c h)`: Padé's approximation, which never turns a velocity round.
        Pade = "pade",
        /// Not at all.
        Nothing = "none",
    }
}

/// What is switched of a method.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub struct MethodOptions {
    /// Order of rows.
    pub order: Order,
    /// Shock propagation.
    pub shock: Shock,
    /// Contact persistence.
    pub persistence: Persistence,
    /// Interpenetration.
    pub overlap: Overlap,
    /// Bodies at rest.
    pub rest: Rest,
    /// Free flight.
    pub integration: Integration,
    /// Damping.
    pub damping: Damping,
    /// Sweeps over the rows in a substep, 1 to 100,000; 0 (the default) takes the method's own number.
    pub sweeps: u32,
}

/// Most sweeps.
const MOST_SWEEPS: u32 = 100_000;

impl MethodOptions {
    /// Sets an option from text; `None` if there is none of this path.
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
                let value = t.parse().ok().filter(|n| *n <= MOST_SWEEPS);
                put(&mut self.sweeps, path, t, value, &["from 0 (the method's own) to 100000"])
            }
            _ => return None,
        })
    }

    pub(crate) fn check_numbers(&self) -> Result<(), DefError> {
        if self.sweeps > MOST_SWEEPS {
            let allowed = "from 0 (the method's own) to 100000";
            return Err(DefError::new("method.sweeps", self.sweeps, allowed));
        }
        Ok(())
    }
}
