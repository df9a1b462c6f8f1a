//! The start of a step: the trees of a group, their links and contacts, and what changed them since
//! the last step.

use super::group::{LinkIn, TreeGroup, TreeIn, inverse};
use super::motion::{impulse_of, turned, vector, wide};
use super::rows::Jacobian;
use crate::base::math::Vec3;
use crate::state::articulations::ArticulationRow;
use crate::state::bodies::body::Body;
use crate::state::joints::{Joint, JointModel};
use crate::step::solver::lent::Solver;

impl Solver<'_> {
    /// The articulations of a group, if it has some.
    pub(super) fn trees_of(&self, number: usize) -> Option<&mut TreeGroup> {
        let has_trees = !self.plan.groups[number].articulations.is_empty();
        has_trees.then(|| self.articulation.groups.row(number))
    }

    /// Lists the trees of a group with their links and contacts, and takes what changed the
    /// velocities of links since the last step as impulses.
    pub(in crate::step::solver) fn begin_articulations(&self, number: usize) {
        let group = &self.plan.groups[number];
        let Some(trees) = self.trees_of(number) else { return };
        trees.trees.clear();
        trees.links.clear();
        let mut first = 0;
        for (_, row) in &self.plan.articulations[group.articulations.clone()] {
            let Some(articulation) = self.articulation.table.row(*row as usize) else { continue };
            let model = &mut articulation.model;
            model.tree.set_gravity(self.ctx.gravity.to_array().map(f64::from));
            let count = model.tree.v_count();
            let index = u32::try_from(trees.trees.len()).expect("fewer than 2^32 trees");
            let old = model.state.q.clone();
            trees.row.resize(trees.row.len().max(count), 0.0);
            self.take_changes(articulation, &mut trees.row);
            let is_touched = self.list_links(articulation, index, trees);
            let tree = TreeIn { row: *row, first, count, is_touched, before: None, q: old };
            trees.trees.push(tree);
            first += count;
        }
        trees.links.sort_unstable_by_key(|link| link.solver_row);
        for list in [&mut trees.y, &mut trees.y_start, &mut trees.outside, &mut trees.dense] {
            list.clear();
            list.resize(first, 0.0);
        }
        self.list_link_contacts(group, trees);
        self.warm_start_partners(trees);
    }

    /// Lists the moving links of a tree; true if other rows than those of contacts may act on one.
    fn list_links(
        &self,
        articulation: &mut ArticulationRow,
        tree: u32,
        trees: &mut TreeGroup,
    ) -> bool {
        let ArticulationRow { model, bodies, .. } = articulation;
        let mut is_touched = false;
        for (link, body) in (0_u32..).zip(&*bodies) {
            let solver_row = self.body.solver_row_of[*body as usize];
            if solver_row == 0 || !model.tree.moves(link as usize) {
                continue;
            }
            let whitening = self.body.whitening.read(solver_row as usize);
            let s = whitening.s();
            let wide = [s.xx, s.yy, s.zz, s.xy, s.xz, s.yz].map(f64::from);
            let of = self.bodies.at(*body);
            is_touched |= of.record.dragged || self.has_joints(of);
            trees.links.push(LinkIn {
                solver_row,
                tree,
                link,
                start: model.tree.link_motion(link as usize, &model.work),
                inv_alpha: 1.0 / f64::from(whitening.alpha()),
                s_inverse: inverse(&wide),
                written: [[0.0; 4]; 2],
            });
        }
        is_touched
    }

    /// True if a joint acts on the body besides those of its articulation.
    fn has_joints(&self, body: &Body) -> bool {
        body.ties.joints.iter().any(|row| {
            let joint = self.joint_slots.read(*row as usize);
            let acts = |joint: &Joint| joint.is_on() && !matches!(joint.model, JointModel::Link);
            joint.as_ref().is_some_and(acts)
        })
    }

    /// Takes changes of the velocities of links, by calls or particles, as impulses on the tree. A
    /// tree whose links were all stopped, as by sleep, stops.
    fn take_changes(&self, articulation: &mut ArticulationRow, impulse: &mut [f64]) {
        let ArticulationRow { model, bodies, .. } = articulation;
        model.update();
        let moving = |link: usize| model.tree.moves(link);
        let links = bodies.iter().enumerate().filter(|(link, _)| moving(*link));
        let stopped = |body: &Body| body.v == Vec3::ZERO && body.w == Vec3::ZERO;
        if links.clone().all(|(_, body)| stopped(self.bodies.at(*body))) {
            model.state.v.fill(0.0);
            model.update();
            return;
        }
        let mut changed = false;
        let impulse = &mut impulse[..model.tree.v_count()];
        for (link, body) in links {
            let motion = model.tree.link_motion(link, &model.work);
            let (v, w) = (vector(motion.v), vector(motion.w));
            let body = self.bodies.at(*body);
            if body.v == v && body.w == w {
                continue;
            }
            changed = true;
            let push = (body.v - v) * body.inertia.mass;
            let turn = turned(body, body.inertia.moments, body.w - w);
            let wrench = (wide(push), wide(turn));
            model.tree.add_at_center(link, wrench, &model.work, impulse);
        }
        if changed {
            model.tree.push(&mut model.state.v, impulse, &mut model.work);
            impulse.fill(0.0);
            model.update();
        }
    }

    /// Applies the impulses of the last step to the bodies that links touch. Later substeps carry
    /// them on.
    fn warm_start_partners(&self, trees: &TreeGroup) {
        for contact in &trees.contacts {
            let block = self.contact.blocks.read(contact.block);
            for (end, row) in contact.bodies.iter().enumerate().filter(|(_, row)| **row != 0) {
                for k in 0..contact.count + 3 {
                    let jacobian = Jacobian::of(block, contact.lane, k, contact.count);
                    let impulse = impulse_of(block, contact.lane, k, contact.count);
                    jacobian.push(end, impulse, self.body.solver_bodies.row(*row as usize));
                }
            }
        }
    }
}
