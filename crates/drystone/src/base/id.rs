//! Typed, generational ids: `Copy`, 8 bytes, `Option<Id>` the same size.

use core::num::NonZeroU32;

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

/// The content of every id: a slot and the generation of its occupant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct RawId {
    index: u32,
    generation: NonZeroU32,
}

impl RawId {
    /// The id of generation `generation` in slot `index`.
    #[must_use]
    pub(crate) const fn new(index: u32, generation: NonZeroU32) -> Self {
        Self { index, generation }
    }

    /// Slot number.
    #[must_use]
    #[inline]
    pub(crate) const fn index(self) -> u32 {
        self.index
    }

    /// Generation: incremented for each occupant of the slot.
    #[must_use]
    #[inline]
    pub(crate) const fn generation(self) -> NonZeroU32 {
        self.generation
    }
}

macro_rules! id {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
        pub struct $name(pub(crate) RawId);

        impl $name {
            /// The slot number: stable while the object lives, reused afterwards.
            #[must_use]
            #[inline]
            pub const fn index(self) -> u32 {
                self.0.index()
            }

            /// Slot and generation as one number, for maps and files.
            #[must_use]
            pub const fn to_bits(self) -> u64 {
                ((self.0.generation().get() as u64) << 32) | self.0.index() as u64
            }

            /// The id with these [`Self::to_bits`]; `None` if no id has them. A world determines
            /// whether the id refers to an existing object.
            #[must_use]
            pub const fn from_bits(bits: u64) -> Option<Self> {
                #[expect(clippy::cast_possible_truncation, reason = "the lower half")]
                let (generation, index) = ((bits >> 32) as u32, bits as u32);
                match NonZeroU32::new(generation) {
                    Some(generation) => Some(Self(RawId::new(index, generation))),
                    None => None,
                }
            }
        }

        impl From<RawId> for $name {
            fn from(raw: RawId) -> Self {
                Self(raw)
            }
        }

        impl From<$name> for RawId {
            fn from(id: $name) -> Self {
                id.0
            }
        }
    };
}

id! {
    /// Identifies a body of a world.
    BodyId
}
id! {
    /// Identifies a shape of a world.
    ShapeId
}
id! {
    /// Identifies a joint of a world.
    JointId
}
id! {
    /// Identifies an articulation of a world.
    ArticulationId
}
id! {
    /// Identifies a particle of a world.
    ParticleId
}
id! {
    /// Identifies a distance constraint between two particles of a world.
    LinkId
}
