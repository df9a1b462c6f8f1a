//! Breakable bodies: bonds between their shapes, and fracture settings. The world writes this table
//! when bodies are added, removed or broken.

use std::collections::BTreeMap;

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

use super::fracture::Fracture;
use super::glue::BondStrength;
use crate::base::copy;
use crate::base::math::Vec3;

/// A bond of a glued body.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct GlueBond {
    /// Indices of its two pieces in [`Glued::pieces`].
    pub(crate) pieces: [usize; 2],
    /// Center of its face [m, frame of the body's origin].
    pub(crate) point: Vec3,
    /// Unit normal from the first piece to the second [body].
    pub(crate) normal: Vec3,
    /// Area of its face [m²].
    pub(crate) area: f32,
    pub(crate) strength: BondStrength,
    /// Ratio of the stress in the last step to the strength.
    pub(crate) load: f32,
}

/// A body whose shapes are glued together.
#[derive(Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Glued {
    /// Rows of the shapes, one per piece.
    pub(crate) pieces: Vec<u32>,
    pub(crate) bonds: Vec<GlueBond>,
    /// Displacement of each piece in the last solve for the loads, which starts the next one; and
    /// the lack of each piece. Empty: not known.
    pub(crate) give: Vec<[f64; 6]>,
    pub(crate) lack: Vec<[f64; 6]>,
}

impl Clone for Glued {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Reuses the existing lists.
    fn clone_from(&mut self, from: &Self) {
        let Self { pieces, bonds, give, lack } = from;
        self.pieces.clone_from(pieces);
        self.bonds.clone_from(bonds);
        self.give.clone_from(give);
        self.lack.clone_from(lack);
    }
}

impl Glued {
    /// Keeps only the pieces for which `keep` is true, and the bonds between them.
    pub(crate) fn retain(&mut self, keep: impl Fn(u32) -> bool) {
        let mut number = vec![usize::MAX; self.pieces.len()];
        let mut pieces = Vec::with_capacity(self.pieces.len());
        for (i, shape) in self.pieces.iter().enumerate() {
            if keep(*shape) {
                number[i] = pieces.len();
                pieces.push(*shape);
            }
        }
        self.pieces = pieces;
        for bond in &mut self.bonds {
            bond.pieces = bond.pieces.map(|p| number[p]);
        }
        self.bonds.retain(|b| b.pieces.iter().all(|p| *p != usize::MAX));
        self.give.clear();
        self.lack.clear();
    }
}

/// All breakable bodies, by body row. Joints are not included.
#[derive(Debug, Default)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub(crate) struct Breakage {
    pub(crate) glued: BTreeMap<u32, Glued>,
    pub(crate) fractures: BTreeMap<u32, Fracture>,
    /// Number of existing bodies that are pieces of fractured ones.
    pub(crate) pieces: usize,
}

impl Clone for Breakage {
    fn clone(&self) -> Self {
        let mut copy = Self::default();
        copy.clone_from(self);
        copy
    }

    /// Reuses the existing lists.
    fn clone_from(&mut self, from: &Self) {
        let Self { glued, fractures, pieces } = from;
        copy::map(&mut self.glued, glued);
        copy::map(&mut self.fractures, fractures);
        self.pieces = *pieces;
    }
}

impl Breakage {
    /// Whether impulses of contacts must be summed.
    pub(crate) fn any(&self) -> bool {
        !self.glued.is_empty() || !self.fractures.is_empty()
    }

    /// Whether a body may come apart or fracture.
    pub(crate) fn breaks(&self, body: u32) -> bool {
        self.glued.contains_key(&body) || self.fractures.contains_key(&body)
    }

    /// Removes the entries of a body that is being removed.
    pub(crate) fn forget(&mut self, body: u32, is_piece: bool) {
        self.glued.remove(&body);
        self.fractures.remove(&body);
        self.pieces -= usize::from(is_piece);
    }
}
