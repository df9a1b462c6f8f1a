//! The part that articulations take in the passes of a group.

use super::group::{LinkContact, LinkIn, TreeGroup, TreeIn, times};
use super::motion::{four, impulse_mut, impulse_of, is_kept, lost, state_of, turned, wide};
use super::rows::Jacobian;
use super::sweep::LinkSweep;
use crate::base::math::Vec3;
use crate::reduced::linked::turn_between;
use crate::state::articulations::ArticulationRow;
use crate::step::solver::lent::Solver;

impl Solver<'_> {
    /// Generalized forces of a tree: those of its joints, and the forces on its links.
    fn gather_forces(&self, articulation: &ArticulationRow, tau: &mut [f64]) {
        let ArticulationRow { model, bodies, .. } = articulation;
        tau.copy_from_slice(&model.tau);
        for (link, body) in bodies.iter().enumerate() {
            let body = self.bodies.at(*body);
            let (forces, mass) = (&body.forces, body.inertia.mass);
            let lighter = self.ctx.gravity * ((forces.gravity_scale - 1.0) * mass);
            let slowed = body.v * (-mass * forces.linear_damping);
            let force = forces.force + forces.step_force + lighter + slowed;
            let slowed = turned(body, body.inertia.moments * -forces.angular_damping, body.w);
            let torque = forces.torque + forces.step_torque + slowed;
            if force != Vec3::ZERO || torque != Vec3::ZERO {
                let wrench = (wide(force), wide(torque));
                model.tree.add_at_center(link, wrench, &model.work, tau);
            }
        }
    }

    /// Begins a substep of the trees of a group: half of their motion, free velocities, rows of
    /// contacts, warm start.
    pub(in crate::step::solver) fn move_articulations(&self, number: usize) {
        let Some(trees) = self.trees_of(number) else { return };
        let h = f64::from(self.ctx.h);
        for index in 0..trees.trees.len() {
            let TreeIn { row, first, count, is_touched, .. } = trees.trees[index];
            let Some(articulation) = self.articulation.table.row(row as usize) else { continue };
            trees.tau.resize(trees.y.len(), 0.0);
            let tau = &mut trees.tau[first..first + count];
            self.gather_forces(articulation, tau);
            if !is_touched {
                continue;
            }
            let model = &mut articulation.model;
            let before = model.tree.begin(&mut model.state, tau, h, &model.config, &mut model.work);
            trees.trees[index].before = Some(before);
            model.tree.whiten_end(&model.work, &mut trees.y[first..first + count]);
            model.tree.whiten_start(&model.work, &mut trees.y_start[first..first + count]);
        }
        trees.outside.fill(0.0);
        self.show_links(trees, false);
        self.build_link_rows(trees);
        self.find_bounces(trees);
        for index in 0..trees.contacts.len() {
            let contact = trees.contacts[index];
            self.bound_warm_start(trees, &contact);
            let block = self.contact.blocks.read(contact.block);
            for k in 0..contact.count + 3 {
                let row = trees.rows[contact.first + k];
                let impulse = impulse_of(block, contact.lane, k, contact.count);
                TreeGroup::push(&trees.sparse, &row, impulse, &mut trees.y);
            }
        }
        self.show_links(trees, true);
    }

    /// Bounds the speed that the impulses of the last substep give the tree: its response may have
    /// changed since. A body that it touches has got them, and gives the rest back.
    #[expect(clippy::cast_possible_truncation, reason = "blocks have this precision")]
    fn bound_warm_start(&self, trees: &TreeGroup, contact: &LinkContact) {
        let (block, lane) = (self.contact.blocks.row(contact.block), contact.lane);
        let points = 0..contact.count;
        let most = |k: usize| {
            let row = &trees.rows[contact.first + k];
            (row.mass * row.part * f64::from(self.ctx.warm_max)) as f32
        };
        let part = |k: usize| {
            let impulse = block.points[k].impulse[lane];
            if impulse > most(k) { most(k) / impulse } else { 1.0 }
        };
        let part = points.map(part).fold(1.0, f32::min);
        if part >= 1.0 {
            return;
        }
        for k in 0..contact.count + 3 {
            let jacobian = Jacobian::of(block, lane, k, contact.count);
            let impulse = impulse_mut(block, lane, k, contact.count);
            let old = core::mem::replace(impulse, *impulse * part);
            let change = f64::from(*impulse) - f64::from(old);
            for (end, row) in contact.bodies.iter().enumerate().filter(|(_, row)| **row != 0) {
                jacobian.push(end, change, self.body.solver_bodies.row(*row as usize));
            }
        }
    }

    /// Solves the trees of a group: own rows and contacts, over whitened velocities.
    pub(in crate::step::solver) fn solve_articulations(&self, number: usize, substep: u32) {
        let Some(trees) = self.trees_of(number) else { return };
        self.read_back(trees);
        self.sweep_all(trees, &self.link_sweep(substep, false));
        self.sum_link_blocks(number, 1.0);
        self.show_links(trees, true);
    }

    /// A sweep after this number of substeps.
    fn link_sweep(&self, substeps: u32, relaxes: bool) -> LinkSweep {
        #[expect(clippy::cast_precision_loss, reason = "at most 256")]
        let elapsed = f64::from(substeps as f32 * self.ctx.h);
        LinkSweep { inv_h: f64::from(self.ctx.inv_h), relaxes, elapsed }
    }

    /// Sweeps own rows and contacts in turn.
    fn sweep_all(&self, trees: &mut TreeGroup, sweep: &LinkSweep) {
        let touched = || trees.trees.iter().filter(|tree| tree.is_touched);
        let rounds = touched().filter_map(|tree| {
            let row = self.articulation.table.read(tree.row as usize).as_ref()?;
            Some(row.model.config.sweeps.clamp(1, 1000))
        });
        for _ in 0..rounds.max().unwrap_or(0) {
            for tree in trees.trees.iter().filter(|tree| tree.is_touched) {
                if let Some(row) = self.articulation.table.row(tree.row as usize) {
                    let y = &mut trees.y[tree.first..tree.first + tree.count];
                    row.model.tree.sweep_own(&mut row.model.work, y);
                }
            }
            self.sweep_links(trees, sweep);
        }
    }

    /// Adds the impulses of the blocks of links to the sums of their contacts, `times` 1 or -1.
    fn sum_link_blocks(&self, number: usize, sign: f32) {
        for i in self.link_blocks(&self.plan.groups[number]) {
            if let Some(tally) = self.tally(i) {
                let block = self.contact.blocks.read(i);
                tally.add(block, sign);
                if sign > 0.0 && self.sum_requests.any() {
                    self.contact.peaks.row(i).note(block);
                }
            }
        }
    }

    /// Ends a substep of the trees of a group: the other half of their motion.
    pub(in crate::step::solver) fn advance_articulations(&self, number: usize) {
        let Some(trees) = self.trees_of(number) else { return };
        self.sum_contacts(trees);
        self.end_bounces(trees);
        self.add_overlaps(trees);
        let h = f64::from(self.ctx.h);
        for index in 0..trees.trees.len() {
            let TreeIn { row, first, count, is_touched, before, .. } = trees.trees[index];
            let Some(articulation) = self.articulation.table.row(row as usize) else { continue };
            let model = &mut articulation.model;
            let tau = &trees.tau[first..first + count];
            let done = if let (true, Some(before)) = (is_touched, &before) {
                model.tree.color_end(&mut model.work, &trees.y[first..first + count]);
                model.work.has_contacts = true;
                let sums = &trees.outside[first..first + count];
                model.work.contact_impulse.copy_from_slice(sums);
                let (state, config, work) = (&mut model.state, &model.config, &mut model.work);
                let done = model.tree.end(state, tau, h, config, work, before);
                model.work.has_contacts = false;
                done
            } else {
                let (state, config, work) = (&mut model.state, &model.config, &mut model.work);
                model.tree.step(state, tau, h, config, work).recovery_work
            };
            model.recovered += done;
            model.update();
        }
        self.show_links(trees, false);
    }

    /// Adds the impulses of contacts to those from outside.
    fn sum_contacts(&self, trees: &mut TreeGroup) {
        for contact in &trees.contacts {
            let block = self.contact.blocks.read(contact.block);
            for k in 0..contact.count + 3 {
                let row = trees.rows[contact.first + k];
                let impulse = impulse_of(block, contact.lane, k, contact.count);
                TreeGroup::push(&trees.sparse, &row, impulse, &mut trees.outside);
            }
        }
    }

    /// Takes the velocity with which links left overlaps, by rigid rows.
    pub(in crate::step::solver) fn relax_articulations(&self, number: usize, substep: u32) {
        let Some(trees) = self.trees_of(number) else { return };
        if trees.contacts.is_empty() {
            return;
        }
        let h = f64::from(self.ctx.h);
        for tree in trees.trees.iter().filter(|tree| tree.is_touched) {
            let Some(row) = self.articulation.table.row(tree.row as usize) else { continue };
            let model = &mut row.model;
            model.tree.begin_relaxing(&model.state.q, &model.state.v, h, &mut model.work);
            let y = &mut trees.y[tree.first..tree.first + tree.count];
            model.tree.whiten_end(&model.work, y);
        }
        self.show_links(trees, true);
        self.build_link_rows(trees);
        trees.contacts.iter_mut().for_each(|contact| contact.bounce = [0.0; 4]);
        let sweep = self.link_sweep(substep.min(self.ctx.substeps), true);
        self.sum_link_blocks(number, -1.0);
        self.sweep_all(trees, &sweep);
        self.sum_link_blocks(number, 1.0);
        for tree in trees.trees.iter().filter(|tree| tree.is_touched) {
            let Some(row) = self.articulation.table.row(tree.row as usize) else { continue };
            let model = &mut row.model;
            let y = &trees.y[tree.first..tree.first + tree.count];
            model.tree.color_end(&mut model.work, y);
            model.state.v.copy_from_slice(model.work.end_velocities());
            model.update();
        }
        self.show_links(trees, false);
    }

    /// Stores the state of each link at the step's end.
    pub(in crate::step::solver) fn end_articulations(&self, number: usize) {
        let Some(trees) = self.trees_of(number) else { return };
        for (index, tree) in trees.trees.iter_mut().enumerate() {
            let Some(row) = self.articulation.table.row(tree.row as usize) else { continue };
            let model = &mut row.model;
            let links = trees.links.iter().filter(|link| link.tree as usize == index);
            let motion = |link: &LinkIn| model.tree.link_motion(link.link as usize, &model.work);
            let is_kept = model.tree.check_state(&model.state.q, &model.state.v).is_ok()
                && links.clone().all(|link| is_kept(&motion(link)));
            for link in links {
                let end = if is_kept { state_of(&motion(link)) } else { lost() };
                self.put_end(link.solver_row as usize, end);
            }
            if !is_kept {
                // The bodies return to their places, and so does the tree.
                model.state.q.copy_from_slice(&tree.q);
                model.state.v.fill(0.0);
                model.update();
            }
        }
    }

    /// Writes the motion of touched trees to the solver bodies of their links. `ahead`: with the
    /// whitened velocities of the group, else with the velocities of the state.
    fn show_links(&self, trees: &mut TreeGroup, ahead: bool) {
        if ahead {
            for tree in trees.trees.iter().filter(|tree| tree.is_touched) {
                if let Some(row) = self.articulation.table.row(tree.row as usize) {
                    let y = &trees.y[tree.first..tree.first + tree.count];
                    row.model.tree.color_end(&mut row.model.work, y);
                }
            }
        }
        let TreeGroup { trees, links, .. } = trees;
        for link in links {
            let tree = &trees[link.tree as usize];
            let Some(row) = self.articulation.table.read(tree.row as usize) else { continue };
            if !tree.is_touched {
                continue;
            }
            let motion = row.model.tree.link_motion(link.link as usize, &row.model.work);
            let body = self.body.solver_bodies.row(link.solver_row as usize);
            body.v = four(motion.v.map(|x| x * link.inv_alpha));
            body.w = four(times(&link.s_inverse, motion.w));
            let moved = core::array::from_fn(|i| motion.center[i] - link.start.center[i]);
            let turned = turn_between(link.start.rotation, motion.rotation);
            body.x = four(moved.map(|x: f64| x * link.inv_alpha));
            body.t = four(times(&link.s_inverse, turned));
            link.written = [body.v, body.w];
        }
    }

    /// Takes what other rows changed in the solver bodies of links as impulses on their trees.
    fn read_back(&self, trees: &mut TreeGroup) {
        for index in 0..trees.links.len() {
            let link = &trees.links[index];
            let body = self.body.solver_bodies.read(link.solver_row as usize);
            if !trees.trees[link.tree as usize].is_touched || link.written == [body.v, body.w] {
                continue;
            }
            let change = |now: [f32; 4], then: [f32; 4]| -> [f64; 3] {
                core::array::from_fn(|i| f64::from(now[i]) - f64::from(then[i]))
            };
            let [v, w] = link.written;
            let push = change(body.v, v).map(|x| x * link.inv_alpha);
            let turn = times(&link.s_inverse, change(body.w, w));
            let tree = &trees.trees[link.tree as usize];
            let Some(row) = self.articulation.table.read(tree.row as usize) else { continue };
            let numbers = &mut trees.row[..tree.count];
            let (model, wrench) = (&row.model, (push, turn));
            model.tree.add_at_center(link.link as usize, wrench, &model.work, numbers);
            trees.once.clear();
            model.tree.take_row(&model.work, numbers, tree.first, &mut trees.once);
            for (dof, change) in trees.once.dofs.iter().zip(&trees.once.numbers) {
                trees.y[*dof as usize] += change;
                trees.outside[*dof as usize] += change;
            }
        }
    }
}
