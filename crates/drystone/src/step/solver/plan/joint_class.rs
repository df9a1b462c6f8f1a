//! Classifies joints and contacts: each class has its own kernel or its own blocks.

use crate::state::joints::{Joint, JointModel};

/// Bit for contacts whose rows are rebuilt within the step; they share no block with others.
pub(crate) const TURNING: u8 = 0x80;

/// Bit for contacts among these that are rebuilt in each substep.
pub(crate) const OFTEN: u8 = 0x40;

/// Kind of contacts of links, whose blocks no kernel sweeps: see `solver/articulation`. No other
/// contact has this bit alone.
pub(crate) const LINKED: u8 = OFTEN;

/// True for a batch of contacts of links.
pub(crate) const fn is_linked(class: u8) -> bool {
    class & (TURNING | OFTEN) == LINKED
}

/// Class of distance joints; ball joints have 0.
pub(crate) const DISTANCE: u8 = 1;

/// Class of ball joints in trees.
pub(crate) const TREE: u8 = 2;

/// Class of couplings and pulleys; no batch contains them.
pub(crate) const COUPLED: u8 = 3;

/// Class of joints between links, which articulations solve; no batch contains them.
const LINK: u8 = 4;

/// Bit of six-axis joints.
pub(crate) const SIX_DOF: u8 = 8;

/// Bits for a drive, friction or limit on a translation, and on a rotation.
pub(crate) const SIX_DOF_ACTS: [u8; 2] = [1, 2];

/// Bit for six-axis joints whose locked axes a tree solves.
pub(crate) const SIX_DIRECT: u8 = 4;

/// Bits for a locked translation, and for a locked rotation. A spring sets neither and skips the
/// work for locked axes.
pub(crate) const SIX_DOF_LOCKS: [u8; 2] = [16, 32];

/// Bit for joints that lock all three translations.
pub(crate) const SIX_ANCHORED: u8 = 64;

/// Class of a joint, which selects its kernel and the rows that the kernel solves.
pub(crate) fn class_of(joint: &Joint) -> u8 {
    match &joint.model {
        JointModel::Ball if joint.is_direct => TREE,
        JointModel::Ball => 0,
        JointModel::Distance { .. } => DISTANCE,
        JointModel::Coupling(_) | JointModel::Pulley(_) => COUPLED,
        JointModel::Link => LINK,
        JointModel::SixDof(six_dof) => {
            let direct = if joint.is_direct { SIX_DIRECT } else { 0 };
            let parts = six_dof.def.parts();
            let pinned = if parts.locks_all_motions { SIX_ANCHORED } else { 0 };
            SIX_DOF
                | direct
                | pinned
                | chosen(SIX_DOF_ACTS, parts.acts)
                | chosen(SIX_DOF_LOCKS, parts.locks)
        }
    }
}

/// Combines the bits that are wanted.
pub(crate) fn chosen(bits: [u8; 2], wanted: [bool; 2]) -> u8 {
    bits.into_iter().zip(wanted).fold(0, |all, (bit, wanted)| if wanted { all | bit } else { all })
}
