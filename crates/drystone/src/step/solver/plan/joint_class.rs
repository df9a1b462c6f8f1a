//! Classes of joints: one kernel each.

use crate::state::joints::{Joint, Link};

/// Bit of the class of contacts whose rows are made anew within the step: they share no block with others.
pub(crate) const TURNING: u8 = 0x80;

/// Bit of those of them that are made anew in each substep.
pub(crate) const OFTEN: u8 = 0x40;

/// Class of distances; balls have 0.
pub(crate) const DISTANCE: u8 = 1;

/// Class of the joints of trees.
pub(crate) const TREE: u8 = 2;

/// Class of couplings and pulleys, which are in no batch either.
pub(crate) const COUPLED: u8 = 3;

/// Bit of the classes of joints of six axes.
pub(crate) const SIX: u8 = 8;

/// Bits of those on whose motions, and on whose turns, something acts: a drive, friction, a limit.
pub(crate) const SIX_ACTS: [u8; 2] = [1, 2];

/// Bit of those whose locked axes a tree holds.
pub(crate) const SIX_DIRECT: u8 = 4;

/// Bits of those that lock a motion, and a turn: a spring does neither, and what holds need not be worked out for it.
pub(crate) const SIX_HOLDS: [u8; 2] = [16, 32];

/// Bit of those that lock all motions.
pub(crate) const SIX_ANCHORED: u8 = 64;

/// The class of a joint: what kernel solves it, and what of it there is to solve.
pub(crate) fn class_of(joint: &Joint) -> u8 {
    match &joint.link {
        Link::Ball if joint.is_direct => TREE,
        Link::Ball => 0,
        Link::Distance { .. } => DISTANCE,
        Link::Coupling(_) | Link::Pulley(_) => COUPLED,
        Link::Six(six) => {
            let direct = if joint.is_direct { SIX_DIRECT } else { 0 };
            let parts = six.def.parts();
            let pinned = if parts.holds_all_motions { SIX_ANCHORED } else { 0 };
            SIX | direct | pinned | chosen(SIX_ACTS, parts.acts) | chosen(SIX_HOLDS, parts.holds)
        }
    }
}

/// Those of two bits that are wanted.
pub(crate) fn chosen(bits: [u8; 2], wanted: [bool; 2]) -> u8 {
    bits.into_iter().zip(wanted).fold(0, |all, (bit, wanted)| if wanted { all | bit } else { all })
}
