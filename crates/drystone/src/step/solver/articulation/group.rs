//! The articulations of a group, and the rows of their contacts.

use crate::reduced::conserve::Before;
use crate::reduced::linked::{LinkMotion, SparseRows};

/// Stands for no link.
pub(super) const NO_LINK: u32 = u32::MAX;

/// An articulation in its group.
#[derive(Clone, Debug)]
pub(super) struct TreeIn {
    /// Row in the table of articulations.
    pub(super) row: u32,
    /// Its whitened velocities among those of the group.
    pub(super) first: usize,
    pub(super) count: usize,
    /// Whether something but its own rows may act on it in this step.
    pub(super) is_touched: bool,
    pub(super) before: Option<Before<f64>>,
    /// Coordinates at the step's start, for a step that fails.
    pub(super) q: Vec<f64>,
}

/// A moving link in its group.
#[derive(Clone, Debug)]
pub(super) struct LinkIn {
    pub(super) solver_row: u32,
    /// Index in [`TreeGroup::trees`], and the link's number.
    pub(super) tree: u32,
    pub(super) link: u32,
    /// Pose at the step's start.
    pub(super) start: LinkMotion,
    /// 1/α and S⁻¹ of the solver body (xx, yy, zz, xy, xz, yz).
    pub(super) inv_alpha: f64,
    pub(super) s_inverse: [f64; 6],
    /// Whitened velocity that the solver body got from the tree; what differs came from others.
    pub(super) written: [[f32; 4]; 2],
}

/// A contact of a link: a lane of a block.
#[derive(Clone, Copy, Debug)]
pub(super) struct LinkContact {
    pub(super) block: usize,
    pub(super) lane: usize,
    pub(super) count: usize,
    /// Index in [`TreeGroup::links`] of A and B, or [`NO_LINK`].
    pub(super) links: [u32; 2],
    /// Solver bodies of A and B that are no links; 0: cannot be pushed.
    pub(super) bodies: [u32; 2],
    /// Its first row in [`TreeGroup::rows`]: points, then both tangents and the twist.
    pub(super) first: usize,
    /// Separation of each point at the moment of the rows [m].
    pub(super) separation: [f64; 4],
    /// Speed after a bounce of each point [m/s]; 0: it does not bounce.
    pub(super) bounce: [f64; 4],
    /// Inverse of the matrix of the tangents and the twist: 11, 12, 22, 13, 23, 33; and a step
    /// along all three that does not overshoot.
    pub(super) mass_t: [f64; 6],
    pub(super) mass_slide: f64,
}

impl LinkContact {
    /// True if some point bounces in this substep.
    pub(super) fn bounces(&self) -> bool {
        self.bounce.iter().any(|speed| *speed > 0.0)
    }
}

/// A row over the whitened velocities of the group's trees.
#[derive(Clone, Copy, Debug)]
pub(super) struct LinkRow {
    /// Its numbers in [`TreeGroup::sparse`].
    pub(super) begin: usize,
    pub(super) end: usize,
    /// Inverse of the row's response.
    pub(super) mass: f64,
    /// Speed at which the tree has as much energy along the row as free links at a speed of 1, at
    /// most 1. Links that hardly move along the row move the whole tree fast.
    pub(super) part: f64,
}

/// The articulations of a group.
#[derive(Clone, Debug, Default)]
pub(crate) struct TreeGroup {
    pub(super) trees: Vec<TreeIn>,
    /// Sorted by solver body.
    pub(super) links: Vec<LinkIn>,
    pub(super) contacts: Vec<LinkContact>,
    pub(super) rows: Vec<LinkRow>,
    pub(super) sparse: SparseRows,
    /// An impulse from outside.
    pub(super) once: SparseRows,
    /// Whitened velocities of all trees, at the end of the substep and at its start.
    pub(super) y: Vec<f64>,
    pub(super) y_start: Vec<f64>,
    /// Impulses from outside in this substep, over whitened velocities.
    pub(super) outside: Vec<f64>,
    /// Generalized forces of all trees.
    pub(super) tau: Vec<f64>,
    /// A row of a tree before it is whitened, and one of the group; all 0 between uses.
    pub(super) row: Vec<f64>,
    pub(super) dense: Vec<f64>,
}

impl TreeGroup {
    /// The link of a solver body.
    pub(super) fn link_of(&self, solver_row: u32) -> u32 {
        match self.links.binary_search_by_key(&solver_row, |link| link.solver_row) {
            Ok(index) => u32::try_from(index).expect("fewer than 2^32 links"),
            Err(_) => NO_LINK,
        }
    }
}

/// The product of a symmetric matrix (xx, yy, zz, xy, xz, yz) and a vector.
pub(super) fn times(m: &[f64; 6], v: [f64; 3]) -> [f64; 3] {
    let [xx, yy, zz, xy, xz, yz] = *m;
    let [x, y, z] = v;
    [xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z]
}

/// The inverse of a symmetric matrix (xx, yy, zz, xy, xz, yz); 0 for a singular one.
pub(super) fn inverse(m: &[f64; 6]) -> [f64; 6] {
    let [xx, yy, zz, xy, xz, yz] = *m;
    let (a, b, c) = (yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy);
    let determinant = xx * a + xy * b + xz * c;
    if !(determinant.abs() > 0.0) {
        return [0.0; 6];
    }
    let d = 1.0 / determinant;
    [a * d, (xx * zz - xz * xz) * d, (xx * yy - xy * xy) * d, b * d, c * d, (xy * xz - xx * yz) * d]
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
