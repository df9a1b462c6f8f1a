//! The constraint graph. Constraints of one color share no dynamic body, so they can be solved side
//! by side in any grouping with the same result.

use core::iter::repeat;

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use crate::base::bit_set::BitSet;

/// The place of a constraint in the colors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Place {
    /// Index of the color; `u32::MAX` if it is in none.
    pub(crate) color: u32,
    /// Index in the color's list.
    pub(crate) row: u32,
}

impl Place {
    pub(crate) const NOWHERE: Self = Self { color: u32::MAX, row: 0 };

    #[inline]
    pub(crate) fn is_somewhere(self) -> bool {
        self != Self::NOWHERE && self.color != u32::MAX
    }
}

/// Constraints that share no dynamic body.
#[derive(Debug, Default)]
pub(crate) struct Color {
    bodies: BitSet,
    /// Rows of the constraints.
    pub(crate) members: Vec<u32>,
    /// True if the list changed since it was last sorted.
    pub(crate) dirty: bool,
}

impl Clone for Color {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Reuses the existing lists.
    fn clone_from(&mut self, from: &Self) {
        let Self { bodies, members, dirty } = from;
        self.bodies.clone_from(bodies);
        self.members.clone_from(members);
        self.dirty = *dirty;
    }
}

impl Color {
    fn is_free_of(&self, bodies: &[u32]) -> bool {
        !bodies.iter().any(|b| self.bodies.contains(*b))
    }

    /// Inserts a constraint on these bodies, which must not be in the color yet. Returns its index
    /// in the list.
    fn insert(&mut self, member: u32, bodies: &[u32]) -> u32 {
        for b in bodies {
            self.bodies.insert(*b);
        }
        self.members.push(member);
        self.dirty = true;
        number(self.members.len() - 1)
    }
}

fn number(n: usize) -> u32 {
    u32::try_from(n).expect("fewer constraints than 2^32")
}

/// Colors of one kind of constraint. Their number is unlimited.
#[derive(Debug, Default)]
pub(crate) struct Coloring {
    pub(crate) colors: Vec<Color>,
}

impl Clone for Coloring {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Reuses the existing lists. Colors beyond those of `from` stay, empty. For a constraint they
    /// are equivalent to colors that do not exist yet.
    fn clone_from(&mut self, from: &Self) {
        if self.colors.len() < from.colors.len() {
            self.colors.resize_with(from.colors.len(), Color::default);
        }
        let none = Color::default();
        for (color, from) in self.colors.iter_mut().zip(from.colors.iter().chain(repeat(&none))) {
            color.clone_from(from);
        }
    }
}

impl Coloring {
    /// Inserts a constraint on these dynamic bodies into the first color that contains none of
    /// them.
    pub(crate) fn insert(&mut self, member: u32, bodies: &[u32]) -> Place {
        let index = self.colors.iter().position(|c| c.is_free_of(bodies)).unwrap_or_else(|| {
            self.colors.push(Color::default());
            self.colors.len() - 1
        });
        Place { color: number(index), row: self.colors[index].insert(member, bodies) }
    }

    /// Inserts a constraint into the color with this index; `None` if one of its bodies is there.
    pub(crate) fn insert_at(&mut self, color: u32, member: u32, bodies: &[u32]) -> Option<Place> {
        let index = color as usize;
        if self.colors.len() <= index {
            self.colors.resize_with(index + 1, Color::default);
        }
        let to = &mut self.colors[index];
        to.is_free_of(bodies).then(|| Place { color, row: to.insert(member, bodies) })
    }

    /// Removes a constraint. Returns the constraint that was moved to its index.
    pub(crate) fn remove(&mut self, place: Place, bodies: &[u32]) -> Option<u32> {
        let color = &mut self.colors[place.color as usize];
        for b in bodies {
            color.bodies.remove(*b);
        }
        color.members.swap_remove(place.row as usize);
        color.dirty = true;
        color.members.get(place.row as usize).copied()
    }

    /// Number of constraints in all colors.
    pub(crate) fn len(&self) -> usize {
        self.colors.iter().map(|c| c.members.len()).sum()
    }
}

/// Initial value after loading: data derived from all colors is not saved and must be rebuilt.
const fn unknown() -> bool {
    true
}

/// All colors. Constraints solved last are satisfied best: joints first, then contacts of two
/// dynamic bodies, then contacts with immovable bodies. The places of constraints are saved, not
/// the lists.
#[derive(Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Colors {
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) joints: Coloring,
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) joints_fixed: Coloring,
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) contacts: Coloring,
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) contacts_fixed: Coloring,
    /// Number of colored contacts that bounce, resist rolling or have a kinematic body.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) special: usize,
    /// True if a body with constraints became active or inactive.
    #[cfg_attr(feature = "serde", serde(skip, default = "unknown"))]
    pub(crate) bodies_changed: bool,
    /// True if contacts were added or removed, or the last relaxation still changed a level.
    pub(crate) levels_dirty: bool,
}

impl Clone for Colors {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Reuses the existing lists.
    fn clone_from(&mut self, from: &Self) {
        let Self {
            joints,
            joints_fixed,
            contacts,
            contacts_fixed,
            special,
            bodies_changed,
            levels_dirty,
        } = from;
        self.joints.clone_from(joints);
        self.joints_fixed.clone_from(joints_fixed);
        self.contacts.clone_from(contacts);
        self.contacts_fixed.clone_from(contacts_fixed);
        self.special = *special;
        self.bodies_changed = *bodies_changed;
        self.levels_dirty = *levels_dirty;
    }
}
