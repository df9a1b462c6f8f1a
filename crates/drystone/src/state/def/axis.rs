//! The six axes of a joint, by name.

use core::fmt::{self, Display};

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

/// An axis of a joint's frame: a translation along it, or a rotation about it by the right-hand
/// rule.
///
/// ```
/// use drystone::Axis;
///
/// assert!(Axis::TurnX.is_turn() && !Axis::X.is_turn());
/// assert_eq!(Axis::ALL.len(), 6);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub enum Axis {
    /// Translation along x [m].
    X,
    /// Translation along y [m].
    Y,
    /// Translation along z [m].
    Z,
    /// Rotation about x [rad].
    TurnX,
    /// Rotation about y [rad].
    TurnY,
    /// Rotation about z [rad].
    TurnZ,
}

impl Axis {
    /// All axes: the translations, then the rotations.
    pub const ALL: &'static [Self] =
        &[Self::X, Self::Y, Self::Z, Self::TurnX, Self::TurnY, Self::TurnZ];

    /// True for the three rotations.
    #[must_use]
    pub const fn is_turn(self) -> bool {
        matches!(self, Self::TurnX | Self::TurnY | Self::TurnZ)
    }

    /// Index in [`Self::ALL`], 0 to 5.
    #[must_use]
    pub const fn index(self) -> usize {
        self as usize
    }

    /// Path of its field in a definition: `linear[0]` for x.
    pub(crate) const fn path(self) -> &'static str {
        match self {
            Self::X => "linear[0]",
            Self::Y => "linear[1]",
            Self::Z => "linear[2]",
            Self::TurnX => "angular[0]",
            Self::TurnY => "angular[1]",
            Self::TurnZ => "angular[2]",
        }
    }
}

impl Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
            Self::TurnX => "turn about x",
            Self::TurnY => "turn about y",
            Self::TurnZ => "turn about z",
        })
    }
}
