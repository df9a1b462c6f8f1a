//! Access of a world's solver to a tree: motion of links, rows at their centers.

use super::row::{Bound, Segment};
use super::spatial::{Rotation, Spatial, Vector};
use super::tree::Tree;
use super::work::TreeWork;

/// Pose and velocity of a link's center of mass [m, m/s, rad/s; world].
#[derive(Clone, Copy, Debug)]
pub(crate) struct LinkMotion {
    pub(crate) center: [f64; 3],
    /// Unit quaternion, real part first.
    pub(crate) rotation: [f64; 4],
    pub(crate) v: [f64; 3],
    pub(crate) w: [f64; 3],
}

/// Numbers of rows over whitened velocities, each with the index of its velocity.
#[derive(Clone, Debug, Default)]
pub(crate) struct SparseRows {
    pub(crate) dofs: Vec<u32>,
    pub(crate) numbers: Vec<f64>,
}

impl SparseRows {
    pub(crate) fn clear(&mut self) {
        self.dofs.clear();
        self.numbers.clear();
    }
}

impl Tree<f64> {
    pub(crate) const fn set_gravity(&mut self, gravity: [f64; 3]) {
        self.gravity = Vector(gravity);
    }

    /// Moves a tree on the world by `shift` [m, world], with all its loops to the world.
    pub(crate) fn shift(&mut self, q: &mut [f64], shift: [f64; 3]) {
        if self.floats() {
            for (x, by) in q.iter_mut().zip(shift) {
                *x += by;
            }
        } else {
            self.links[0].position = self.links[0].position + Vector(shift);
        }
        for closure in self.loops.iter_mut().filter(|closure| closure.link_b.is_none()) {
            for (x, by) in closure.point_b.iter_mut().zip(shift) {
                *x += by;
            }
        }
    }

    /// False if no degree of freedom moves the link.
    pub(crate) fn moves(&self, link: usize) -> bool {
        !self.path_of(link).is_empty()
    }

    /// Center of mass of a link [m, world axes, from the reference point].
    fn center_of(&self, link: usize, work: &TreeWork<f64>) -> Vector<f64> {
        work.position[link] + work.rotation[link].rotate(self.links[link].center)
    }

    /// Motion of a link; after [`Tree::place`] and [`Tree::move_links`].
    pub(crate) fn link_motion(&self, link: usize, work: &TreeWork<f64>) -> LinkMotion {
        let center = self.center_of(link, work);
        let velocity = work.velocity[link];
        LinkMotion {
            center: (work.origin + center).0,
            rotation: work.rotation[link].0,
            v: velocity.at(center).0,
            w: velocity.angular.0,
        }
    }

    /// Adds to a generalized vector a force or direction [world] at a link's center of mass, and a
    /// moment about it.
    pub(crate) fn add_at_center(
        &self,
        link: usize,
        (force, moment): ([f64; 3], [f64; 3]),
        work: &TreeWork<f64>,
        row: &mut [f64],
    ) {
        let (force, moment) = (Vector(force), Vector(moment));
        let angular = self.center_of(link, work).cross(force) + moment;
        let wrench = Spatial { angular, linear: force };
        for &dof in self.path_of(link) {
            row[dof] += work.axis[dof].dot(wrench);
        }
    }

    /// Whitens a row that stands in `row`, appends its numbers that are not 0, and clears `row`.
    /// `first` is the index of the tree's first whitened velocity.
    pub(crate) fn take_row(
        &self,
        work: &TreeWork<f64>,
        row: &mut [f64],
        first: usize,
        out: &mut SparseRows,
    ) {
        for dof in (0..row.len()).rev() {
            let value = core::mem::replace(&mut row[dof], 0.0);
            if value == 0.0 {
                continue;
            }
            let above = self.rows[dof] + 1..self.rows[dof + 1];
            for (&other, &factor) in self.path[above.clone()].iter().zip(&work.matrix[above]) {
                row[other] -= factor * value;
            }
            let index = u32::try_from(first + dof).expect("fewer than 2^32 velocities");
            out.dofs.push(index);
            out.numbers.push(value * work.root_inverse[dof]);
        }
    }

    /// Changes velocities by a generalized impulse at the placed coordinates. `impulse` is used up.
    pub(crate) fn push(&self, v: &mut [f64], impulse: &mut [f64], work: &mut TreeWork<f64>) {
        self.fill_mass_matrix(work);
        self.factor(work, 0.0);
        self.solve(work, impulse);
        for (v, change) in v.iter_mut().zip(impulse) {
            *v += *change;
        }
    }

    /// Whitens the velocities at the substep's end, `work.buffers.v`.
    pub(crate) fn whiten_end(&self, work: &TreeWork<f64>, out: &mut [f64]) {
        self.whiten_velocity(work, &work.buffers.v, out);
    }

    /// Whitens the velocities at the substep's start.
    pub(crate) fn whiten_start(&self, work: &TreeWork<f64>, out: &mut [f64]) {
        self.whiten_velocity(work, &work.buffers.v_start, out);
    }

    /// Takes whitened velocities as those at the substep's end, and moves the links by them.
    pub(crate) fn color_end(&self, work: &mut TreeWork<f64>, whitened: &[f64]) {
        let mut v = core::mem::take(&mut work.buffers.v);
        self.color_velocity(work, whitened, &mut v);
        self.move_links(&v, work);
        work.buffers.v = v;
    }

    /// One sweep over the tree's own rows: limits, friction, couplings, tendons, loops.
    pub(crate) fn sweep_own(&self, work: &mut TreeWork<f64>, whitened: &mut [f64]) {
        work.rows.sweep(whitened);
    }

    /// Prepares rigid rows at the end of a step: the factor at the placed coordinates, and the
    /// limits there. The velocities `v` stand in `work.buffers.v` then.
    pub(crate) fn begin_relaxing(&self, q: &[f64], v: &[f64], h: f64, work: &mut TreeWork<f64>) {
        self.place(q, work);
        self.fill_mass_matrix(work);
        self.factor(work, 0.0);
        work.rows.clear();
        let mut buffers = core::mem::replace(&mut work.buffers, super::work::Buffers::empty());
        buffers.v.copy_from_slice(v);
        if self.may_have_rows() {
            let moment = super::gather::Moment { q, v, v_free: &buffers.v, h };
            self.gather(&moment, work, &mut buffers.row);
        }
        work.buffers = buffers;
    }
}

impl TreeWork<f64> {
    /// Adds a row to the position pass: an overlap [m, below 0] along whitened numbers.
    pub(crate) fn add_gap(&mut self, numbers: &[f64], gap: f64, compliance: f64) {
        let segment = self.rows.segment(0, numbers);
        let row = self.rows.add([segment, Segment::default()], Bound::Push(1.0));
        row.gap = gap;
        row.corrects = true;
        row.comply(compliance);
    }

    /// Velocities at the substep's end.
    pub(crate) fn end_velocities(&self) -> &[f64] {
        &self.buffers.v
    }
}

/// The rotation vector [rad, world] from one rotation to another.
pub(crate) fn turn_between(from: [f64; 4], to: [f64; 4]) -> [f64; 3] {
    Rotation(to).times(Rotation(from).inverse()).vector().0
}
