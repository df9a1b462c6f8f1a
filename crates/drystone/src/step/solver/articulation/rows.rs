//! Rows of the contacts of links, over the whitened velocities of their trees and the solver bodies
//! of what they touch.

use super::group::{LinkContact, LinkRow, NO_LINK, TreeGroup, dot, inverse, times};
use crate::base::simd::wide::{LANES, Lanes};
use crate::reduced::linked::SparseRows;
use crate::step::solver::contact::block::ContactBlock;
use crate::step::solver::lent::Solver;
use crate::step::solver::plan::group::Group;
use crate::step::solver_body::SolverBody;

/// A part of the trace of the matrix of a contact's tangents that is added to its diagonal. A link
/// may be unable to move along some of them.
const MIN_TANGENT: f64 = 1.0e-6;

/// Part of the response of free links that each row has at least. Links may be unable to move along
/// it.
const FREE_PART: f64 = 1.0e-6;

/// Response of a row if its links were free.
fn free_response(contact: &LinkContact, jacobian: &Jacobian) -> f64 {
    let ends = (0..2).filter(|end| contact.bodies[*end] != 0 || contact.links[*end] != NO_LINK);
    ends.map(|end| jacobian.response(jacobian, end)).sum()
}

/// A row of a contact: its direction, and the rows of both bodies times their S.
#[derive(Clone, Copy, Debug)]
pub(super) struct Jacobian {
    pub(super) direction: [f64; 3],
    pub(super) turns: [[f64; 3]; 2],
    /// α of A, negative, and of B.
    pub(super) scale: [f64; 2],
}

fn lane_of(lanes: &[Lanes; 3], lane: usize) -> [f64; 3] {
    lanes.map(|x| f64::from(x[lane]))
}

impl Jacobian {
    /// Row `k` of a lane: a point, or after these both tangents and the twist.
    pub(super) fn of(block: &ContactBlock, lane: usize, k: usize, count: usize) -> Self {
        let (n, t1, t2) = (&block.n, &block.t1, &block.t2);
        let (direction, a, b) = if k < count {
            (lane_of(n, lane), &block.points[k].a, &block.points[k].b)
        } else {
            let t = k - count;
            let direction = match t {
                0 => lane_of(t1, lane),
                1 => lane_of(t2, lane),
                _ => [0.0; 3],
            };
            (direction, &block.a_t[t.min(2)], &block.b_t[t.min(2)])
        };
        Self {
            direction,
            turns: [lane_of(a, lane).map(|x| -x), lane_of(b, lane)],
            scale: [-f64::from(block.alpha[lane]), f64::from(block.beta[lane])],
        }
    }

    /// Velocity, or displacement, of a solver body along the row.
    pub(super) fn along(&self, end: usize, v: [f32; 4], w: [f32; 4]) -> f64 {
        let wide = |x: [f32; 4]| [f64::from(x[0]), f64::from(x[1]), f64::from(x[2])];
        dot(self.direction, wide(v)) * self.scale[end] + dot(self.turns[end], wide(w))
    }

    /// Applies an impulse to a solver body.
    #[expect(clippy::cast_possible_truncation, reason = "solver bodies have this precision")]
    pub(super) fn push(&self, end: usize, impulse: f64, solver_body: &mut SolverBody) {
        for i in 0..3 {
            solver_body.v[i] += (self.direction[i] * self.scale[end] * impulse) as f32;
            solver_body.w[i] += (self.turns[end][i] * impulse) as f32;
        }
    }

    /// Response of row `self` of a solver body to an impulse on row `o`.
    fn response(&self, o: &Self, end: usize) -> f64 {
        let linear = dot(self.direction, o.direction) * self.scale[end] * self.scale[end];
        linear + dot(self.turns[end], o.turns[end])
    }
}

impl Solver<'_> {
    /// Lists the contacts of the links of a group.
    pub(super) fn list_link_contacts(&self, group: &Group, trees: &mut TreeGroup) {
        trees.contacts.clear();
        for i in self.link_blocks(group) {
            let block = self.contact.blocks.read(i);
            for lane in 0..LANES {
                let owner = self.plan.contacts.owners[i][lane];
                if owner == u32::MAX {
                    continue;
                }
                let Some(c) = self.contacts.read(owner as usize) else { continue };
                let ends = [block.row_a[lane], block.row_b[lane]];
                let links = ends.map(|row| if row == 0 { NO_LINK } else { trees.link_of(row) });
                let is_link = |row: u32| {
                    row != 0 && {
                        let body = self.plan.members[row as usize - 1];
                        self.bodies.at(body).record.is_link
                    }
                };
                // A link without a tree in this group cannot be pushed.
                let body_of = |end: usize| if is_link(ends[end]) { 0 } else { ends[end] };
                let bodies = [body_of(0), body_of(1)];
                for link in links.iter().filter(|link| **link != NO_LINK) {
                    let tree = trees.links[*link as usize].tree as usize;
                    trees.trees[tree].is_touched = true;
                }
                trees.contacts.push(LinkContact {
                    block: i,
                    lane,
                    count: usize::from(c.count.min(4)),
                    links,
                    bodies,
                    first: 0,
                    separation: [0.0; 4],
                    bounce: [0.0; 4],
                    mass_t: [0.0; 6],
                    mass_slide: 0.0,
                });
            }
        }
    }

    /// Builds the rows of all contacts of links at the placed coordinates of their trees.
    pub(super) fn build_link_rows(&self, trees: &mut TreeGroup) {
        trees.rows.clear();
        trees.sparse.clear();
        for index in 0..trees.contacts.len() {
            let mut contact = trees.contacts[index];
            contact.first = trees.rows.len();
            let block = self.contact.blocks.read(contact.block);
            for k in 0..contact.count + 3 {
                let jacobian = Jacobian::of(block, contact.lane, k, contact.count);
                let row = self.link_row(&contact, &jacobian, trees);
                trees.rows.push(row);
                if k < contact.count {
                    contact.separation[k] = self.separation(block, &contact, &jacobian, k);
                }
            }
            self.build_tangents(block, &mut contact, trees);
            trees.contacts[index] = contact;
        }
    }

    /// A row of a contact, whitened.
    fn link_row(
        &self,
        contact: &LinkContact,
        jacobian: &Jacobian,
        trees: &mut TreeGroup,
    ) -> LinkRow {
        let begin = trees.sparse.numbers.len();
        for (end, link) in contact.links.iter().enumerate() {
            if *link == NO_LINK {
                continue;
            }
            let link_in = &trees.links[*link as usize];
            let tree_in = &trees.trees[link_in.tree as usize];
            let Some(row) = self.articulation.table.read(tree_in.row as usize) else { continue };
            let (tree, work) = (&row.model.tree, &row.model.work);
            let sign = if end == 0 { -1.0 } else { 1.0 };
            let force = jacobian.direction.map(|x| x * sign);
            // The block's row is S J, so J = S⁻¹ (S J).
            let moment = times(&link_in.s_inverse, jacobian.turns[end]);
            let numbers = &mut trees.row[..tree_in.count];
            tree.add_at_center(link_in.link as usize, (force, moment), work, numbers);
            // Both ends of a contact of a tree with itself make one row.
            let other = contact.links[1];
            let is_last =
                end == 1 || other == NO_LINK || trees.links[other as usize].tree != link_in.tree;
            if is_last {
                tree.take_row(work, numbers, tree_in.first, &mut trees.sparse);
            }
        }
        let end = trees.sparse.numbers.len();
        let own = trees.sparse.numbers[begin..end].iter().map(|x| x * x).sum::<f64>();
        let square = own + self.body_response(contact, jacobian, jacobian);
        let free = free_response(contact, jacobian);
        let response = square + FREE_PART * free;
        if !(response > 0.0) {
            return LinkRow { begin, end, mass: 0.0, part: 0.0 };
        }
        LinkRow { begin, end, mass: 1.0 / response, part: (response / free).sqrt().min(1.0) }
    }

    fn body_response(&self, contact: &LinkContact, a: &Jacobian, b: &Jacobian) -> f64 {
        let ends = (0..2).filter(|end| contact.bodies[*end] != 0);
        ends.map(|end| a.response(b, end)).sum()
    }

    /// Separation of a point [m]: the block's, and the displacement since.
    pub(super) fn separation(
        &self,
        block: &ContactBlock,
        contact: &LinkContact,
        jacobian: &Jacobian,
        k: usize,
    ) -> f64 {
        let mut s = f64::from(block.points[k].s0[contact.lane]);
        for (end, row) in [block.row_a, block.row_b].into_iter().enumerate() {
            let row = row[contact.lane] as usize;
            if row != 0 {
                let body = self.body.solver_bodies.read(row);
                s += jacobian.along(end, body.x, body.t);
            }
        }
        s
    }

    /// The inverse of the matrix of a contact's tangents and twist.
    fn build_tangents(
        &self,
        block: &ContactBlock,
        contact: &mut LinkContact,
        trees: &mut TreeGroup,
    ) {
        let jacobians: [Jacobian; 3] = core::array::from_fn(|t| {
            Jacobian::of(block, contact.lane, contact.count + t, contact.count)
        });
        let rows: [LinkRow; 3] =
            core::array::from_fn(|t| trees.rows[contact.first + contact.count + t]);
        let mut k = [0.0; 6];
        for (at, (i, j)) in [(0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2)].into_iter().enumerate()
        {
            k[at] = trees.sparse_dot(&rows[i], &rows[j])
                + self.body_response(contact, &jacobians[i], &jacobians[j]);
        }
        let trace = k[0] + k[2] + k[5];
        let free: f64 = jacobians.iter().map(|j| free_response(contact, j)).sum();
        if !(trace > 1.0e-9 * free) {
            (contact.mass_t, contact.mass_slide) = ([0.0; 6], 0.0);
            return;
        }
        let least = MIN_TANGENT * trace + FREE_PART * free;
        let [k11, k12, k22, k13, k23, k33] = k;
        let m = inverse(&[k11 + least, k22 + least, k33 + least, k12, k13, k23]);
        let [m11, m22, m33, m12, m13, m23] = m;
        contact.mass_t = [m11, m12, m22, m13, m23, m33];
        contact.mass_slide = 1.0 / (trace + least);
    }
}

impl TreeGroup {
    /// Product of two rows. `dense` serves as memory.
    fn sparse_dot(&mut self, a: &LinkRow, b: &LinkRow) -> f64 {
        let Self { sparse, dense, .. } = self;
        for i in a.begin..a.end {
            dense[sparse.dofs[i] as usize] = sparse.numbers[i];
        }
        let sum =
            (b.begin..b.end).map(|i| dense[sparse.dofs[i] as usize] * sparse.numbers[i]).sum();
        for i in a.begin..a.end {
            dense[sparse.dofs[i] as usize] = 0.0;
        }
        sum
    }

    /// Velocity of the trees along a row.
    pub(super) fn velocity(&self, row: &LinkRow, y: &[f64]) -> f64 {
        let range = row.begin..row.end;
        let pairs = self.sparse.dofs[range.clone()].iter().zip(&self.sparse.numbers[range]);
        pairs.map(|(dof, number)| y[*dof as usize] * number).sum()
    }

    /// Applies an impulse on a row to whitened velocities, or to a sum of impulses.
    pub(super) fn push(sparse: &SparseRows, row: &LinkRow, impulse: f64, y: &mut [f64]) {
        for i in row.begin..row.end {
            y[sparse.dofs[i] as usize] += sparse.numbers[i] * impulse;
        }
    }
}
