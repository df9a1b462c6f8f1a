//! The lists of bodies' contacts, which several workers change at once: each list has an owner.

use super::{Link, Slots};
use crate::base::jobs::Executor;
use crate::state::bodies::{Body, NONE};

/// The cache line of a body in which the head of its list is.
pub(super) const LIST: usize = core::mem::offset_of!(Body, contacts) / 64;

/// For so many changes of lists another owner is worth it.
const LEAST: usize = 64;

/// Who changes which lists: a power of two of owners, each with every so manieth body.
#[derive(Clone, Copy, Debug)]
pub(super) struct Owners {
    mask: u32,
}

impl Owners {
    /// For so many changes.
    pub(super) fn of(changes: usize, jobs: &dyn Executor) -> Self {
        let most = (changes / LEAST).clamp(1, jobs.workers());
        Self { mask: (1 << most.ilog2()) - 1 }
    }

    pub(super) const fn len(self) -> usize {
        self.mask as usize + 1
    }

    #[inline(always)]
    pub(super) const fn owns(self, owner: usize, body: u32) -> bool {
        (body & self.mask) as usize == owner
    }
}

/// All links.
#[derive(Clone, Copy)]
pub(super) struct Links<'a>(pub(super) Slots<'a>);

impl<'a> Links<'a> {
    /// The link that this names, row × 2 + side.
    #[inline(always)]
    pub(super) fn at(self, at: u32) -> Option<&'a Link> {
        if at == NONE {
            return None;
        }
        let contact = self.0.read(at as usize / 2).as_ref()?;
        Some(&contact.links[(at & 1) as usize])
    }
}
