//! Changes of contacts that the narrowphase finds and later stages apply.

/// A change or a property of a contact, with the contact's row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Change {
    /// The boxes of the shapes are apart: the contact ends.
    Apart(u32),
    /// The number of its points changed.
    Count(u32),
    /// A body of the contact sleeps, and the two touch in this step. Where bodies freeze
    /// individually: the contact has points again.
    Meets(u32),
    /// The contact has points that have not touched yet, and they close fast
    /// ([`CLOSES`](super::rebuild::CLOSES)). No change by itself.
    Closes(u32),
    /// The contact has points, and its bodies turn so far in this step ([`RENEWED_ROTATION`]) that
    /// other corners may touch, or that its levers change. No change by itself.
    Turns(u32),
    /// The contact has points, and its bodies turn together ([`corotates`]). No change by itself.
    Corotates(u32),
    /// The bodies meet at impact speed, and the contact does not bounce ([`may_impact`]). No change
    /// by itself.
    Impacts(u32),
    /// The contact may be parted in this step: one of its points is deep, or it was parted in the
    /// last step. No change by itself.
    Parts(u32),
    /// The contact has points, and may be a ghost of the seam of two shapes. No change by itself.
    Made(u32),
    /// The contact has points, and may make others ghosts, but is no ghost itself. No change by
    /// itself.
    Carries(u32),
}
