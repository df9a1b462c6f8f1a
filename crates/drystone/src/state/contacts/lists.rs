//! The contact lists of bodies. Several workers change them at once, and each list has one owner.

use super::{ListLink, Table};
use crate::base::threads::disjoint::Rows;
use crate::base::threads::jobs::Jobs;
use crate::state::bodies::NONE;
use crate::state::bodies::body::Body;

/// Minimum number of list changes per owner.
const MIN: usize = 64;

/// Assignment of lists to owners. The number of owners is a power of two, and the last bits of a
/// body's row select its owner.
#[derive(Clone, Copy, Debug)]
pub(super) struct Owners {
    mask: u32,
}

impl Owners {
    /// Owners for this number of changes.
    pub(super) fn of(changes: usize, jobs: &Jobs<'_>) -> Self {
        let maximum = (changes / MIN).clamp(1, jobs.workers());
        Self { mask: (1 << maximum.ilog2()) - 1 }
    }

    pub(super) const fn len(self) -> usize {
        self.mask as usize + 1
    }

    #[inline(always)]
    pub(super) const fn owns(self, owner: usize, body: u32) -> bool {
        (body & self.mask) as usize == owner
    }
}

/// Prefetches the list heads of the two bodies, if this owner owns them.
#[inline(always)]
pub(super) fn prefetch_heads(
    bodies: Rows<'_, Option<Body>>,
    of: [u32; 2],
    owns: impl Fn(u32) -> bool,
) {
    const HEAD: usize = core::mem::offset_of!(Body, ties.contacts) / 64;
    for body in of.into_iter().filter(|body| owns(*body)) {
        // The first line tells whether a row is empty.
        bodies.prefetch_line(body as usize, 0);
        bodies.prefetch_line(body as usize, HEAD);
    }
}

/// All links.
#[derive(Clone, Copy)]
pub(super) struct Links<'a>(pub(super) &'a Table);

impl<'a> Links<'a> {
    /// The link with this number, row × 2 + side.
    #[inline(always)]
    pub(super) fn at(self, at: u32) -> Option<&'a ListLink> {
        if at == NONE {
            return None;
        }
        let contact = self.0.read(at as usize / 2).as_ref()?;
        Some(&contact.links[(at & 1) as usize])
    }
}
