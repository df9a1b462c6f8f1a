//! The constraint graph: constraints of one color share no dynamic body, so they can be solved side
//! by side in any grouping with the same result.

use serde::{Deserialize, Serialize};

use crate::base::bit_set::BitSet;

/// Where a constraint stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Place {
    /// Number of the color; `u32::MAX` if it is in none.
    pub(crate) color: u32,
    /// Place in the color's list.
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
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Color {
    bodies: BitSet,
    /// Rows of the constraints.
    pub(crate) members: Vec<u32>,
    /// The list changed since it was last put in order.
    #[serde(skip, default = "unknown")]
    pub(crate) dirty: bool,
}

impl Color {
    /// True if a constraint of it is on this body.
    pub(super) fn holds(&self, body: u32) -> bool {
        self.bodies.contains(body)
    }

    /// How many bodies its constraints are on.
    pub(super) fn count(&self) -> usize {
        self.bodies.len()
    }
}

/// Colors of one kind of constraint. As many as it takes: nothing overflows.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Coloring {
    pub(crate) colors: Vec<Color>,
}

impl Coloring {
    /// Enters a constraint on these dynamic bodies into the first color that holds none of them.
    pub(crate) fn insert(&mut self, member: u32, bodies: &[u32]) -> Place {
        let free = |c: &Color| !bodies.iter().any(|b| c.bodies.contains(*b));
        let index = self.colors.iter().position(free).unwrap_or_else(|| {
            self.colors.push(Color::default());
            self.colors.len() - 1
        });
        let color = &mut self.colors[index];
        for b in bodies {
            color.bodies.insert(*b);
        }
        color.members.push(member);
        color.dirty = true;
        let number = |n: usize| u32::try_from(n).expect("fewer constraints than 2^32");
        Place { color: number(index), row: number(color.members.len() - 1) }
    }

    /// Takes a constraint out; returns the one that took its place in the list.
    pub(crate) fn remove(&mut self, place: Place, bodies: &[u32]) -> Option<u32> {
        let color = &mut self.colors[place.color as usize];
        for b in bodies {
            color.bodies.remove(*b);
        }
        color.members.swap_remove(place.row as usize);
        color.dirty = true;
        color.members.get(place.row as usize).copied()
    }

    /// Constraints in all colors.
    pub(crate) fn len(&self) -> usize {
        self.colors.iter().map(|c| c.members.len()).sum()
    }
}

/// What changed is not saved, for what was made of it is not: it is to be made again.
const fn unknown() -> bool {
    true
}

/// All colors. What is solved last is satisfied best: joints, then contacts of two dynamic bodies, then
/// contacts with what cannot be moved.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Colors {
    pub(crate) joints: Coloring,
    pub(crate) joints_fixed: Coloring,
    pub(crate) contacts: Coloring,
    pub(crate) contacts_fixed: Coloring,
    /// Colored contacts that bounce, resist rolling or have a kinematic body.
    pub(crate) special: usize,
    /// A body that some constraint acts on became active or ceased to be.
    #[serde(skip, default = "unknown")]
    pub(crate) bodies_changed: bool,
    /// Contacts came or went, or the last relaxation still changed a level.
    pub(crate) levels_dirty: bool,
}
