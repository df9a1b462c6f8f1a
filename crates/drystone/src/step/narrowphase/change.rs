//! Changes that the narrowphase finds.

/// What became of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Change {
    /// The boxes of the shapes are apart: the contact is over.
    Apart(u32),
    /// The number of its points changed.
    Count(u32),
    /// One of its bodies sleeps, and they touch in this step; where bodies freeze one by one, it has points again.
    Meets(u32),
    /// It has points that have not touched yet, and which close fast ([`CLOSES`](super::rebuild::CLOSES)). No change by itself.
    Closes(u32),
    /// It has points, and its bodies turn so far in this step that other corners may come down, or that levers are no more
    /// what they were ([`FAR_TURN`]). No change by itself.
    Turns(u32),
    /// It has points, and its bodies turn together ([`corotates`]). No change by itself.
    Corotates(u32),
    /// Its bodies meet at the speed of a blow, and it does not bounce ([`blows`]). No change by itself.
    Blows(u32),
    /// It may be parted in this step: a point of it is deep, or it was parted in the last one. No change by itself.
    Parts(u32),
    /// It has points, and may be a ghost of the seam of two shapes; no change by itself.
    Made(u32),
    /// It has points, and may make others ghosts, but is none. No change by itself.
    Carries(u32),
}
