//! Rebuilds the manifolds and rows of contacts whose bodies turn far in a step: in each substep, or
//! once in the middle of the step if they turn little.
//!
//! Rows are frozen over a step. A separation that is linear in them errs by r θ²/2 for a body that
//! turns by θ at a lever arm r. Normals, lever arms and the inertia err as well. For a pencil that
//! turns by a radian per step nothing is right at its end, and pushes along outdated lever arms
//! created energy (up to ×180). Also, other corners come down within the step that are missing in
//! the manifold of its start.
//!
//! So bodies are *turning* if narrowphase lists their contacts
//! ([`Change::Turns`](crate::step::narrowphase::Change)) or if these close fast. After each substep
//! they are rotated as free bodies. When their contacts are rebuilt, from the poses of both bodies
//! at that time, their inertia is rotated too. All other bodies keep their rows, which keeps walls
//! steady (docs/decisions/003-frozen-rows-one-sweep.md).
//!
//! Bodies with joints are excluded: joints read the rotation of a solver body since the step's
//! start.
//!
//! References: docs/decisions/033-rows-made-anew.md.

use fearless_simd::{Simd, SimdBase, dispatch};

use super::block::{ContactBlock, Extra};
use super::{prepare, raw, store};
use crate::base::double::DVec3;
use crate::base::math::Vec3;
use crate::base::simd::wide::{LANES, Sym3w, Vec3w, load, scatter, splat};
use crate::base::threads::disjoint::{ReadRows, Rows};
use crate::base::threads::jobs::{Jobs, for_shares};
use crate::geometry::collide::{MAX_PARTS, MeshScratch, Reach, collide, collide_mesh};
use crate::geometry::manifold::Manifold;
use crate::geometry::solid::Core;
use crate::state::bodies::NONE;
use crate::state::contacts::Contact;
use crate::step::context::StepContext;
use crate::step::gyration::{Spin, rotate_freely};
use crate::step::solver::body::integrate;
use crate::step::solver::body::row::Aux;
use crate::step::solver::body::state::BodyState;
use crate::step::solver::contact::pair::{Pair, nearest};
use crate::step::solver::lent::Solver;
use crate::step::solver::plan::group::Group;
use crate::step::solver::plan::joint_class::{OFTEN, TURNING};
use crate::step::solver::plan::layout::Batch;
use crate::step::solver_body;
use crate::step::solver_body::{SolverBody, Whitening, load_motion};

impl Solver<'_> {
    /// True if the group has contacts that are rebuilt within the step.
    pub(crate) fn turns(&self, group: &Group) -> bool {
        self.ctx.rounds == 1 && self.turning_batches(group).next().is_some()
    }

    /// Batches of those contacts.
    fn turning_batches(&self, group: &Group) -> impl Iterator<Item = &Batch> {
        let batches = &self.plan.contacts.batches[group.contacts.clone()];
        batches.iter().filter(|batch| batch.class & TURNING != 0)
    }

    /// Batches that are rebuilt after `done` substeps.
    fn due_batches(&self, group: &Group, done: u16) -> impl Iterator<Item = &Batch> {
        let all = self.is_middle(done);
        self.turning_batches(group).filter(move |batch| all || batch.class & OFTEN != 0)
    }

    /// True in the middle of the step, when the contacts of all turning bodies are rebuilt.
    fn is_middle(&self, done: u16) -> bool {
        u32::from(done) == self.ctx.substeps.div_ceil(2)
    }

    /// Calls `f` with each block that is rebuilt after `done` substeps, and whether one body of
    /// each contact cannot be pushed.
    fn for_due(
        &self,
        (group, done): (&Group, u16),
        jobs: &Jobs<'_>,
        f: impl Fn(bool, usize) + Sync,
    ) {
        for batch in self.due_batches(group, done) {
            let first = batch.blocks.start;
            for_shares(jobs, batch.blocks.len(), 2, |part| {
                (first + part.start..first + part.end).for_each(|i| f(batch.fixed, i));
            });
        }
    }

    /// Solver bodies of the group's turning bodies.
    fn turning_rows(&self, group: &Group) -> &[u32] {
        let solver_rows = &self.plan.turning.solver_rows;
        let at = |solver_row: usize| solver_rows.partition_point(|of| (*of as usize) < solver_row);
        &solver_rows[at(group.solver_rows.start)..at(group.solver_rows.end)]
    }

    /// Prepares turning bodies at the step's start: free rotation is integrated separately, so it
    /// adds no velocity change.
    pub(crate) fn begin_turning(&self, group: &Group) {
        for solver_row in self.turning_rows(group) {
            let solver_row = *solver_row as usize;
            let body = self.bodies.at(self.plan.members[solver_row - 1]);
            *self.body.states.row(solver_row) = BodyState::of(body);
            self.body.aux.row(solver_row).turn_by_torque(
                self.body.whitening.read(solver_row),
                body,
                self.ctx.h,
            );
        }
    }

    /// Rotates the turning bodies after the positions of substep `done`, and rebuilds contacts. At
    /// the step's end narrowphase rebuilds them.
    pub(crate) fn renew(&self, number: usize, done: u16, jobs: &Jobs<'_>) {
        let group = &self.plan.groups[number];
        if u32::from(done) >= self.ctx.substeps {
            self.turn_all(group, jobs, |_| false);
            return;
        }
        let elapsed = f32::from(done) * self.ctx.h;
        let due = (group, done);
        let (all, often) = (self.is_middle(done), &self.plan.turning.often);
        self.for_due(due, jobs, |fixed, i| self.take_warm(fixed, i, elapsed));
        self.turn_all(group, jobs, |solver_row| {
            all || often.contains(self.plan.members[solver_row - 1])
        });
        self.for_due(due, jobs, |_, i| {
            for owner in self.plan.contacts.owners[i] {
                if owner != NONE {
                    self.collide_again(owner, elapsed);
                }
            }
        });
        // Contacts with meshes run one by one, because they share the scratch memory.
        let scratch = self.contact.meshes.row(number);
        for batch in self.due_batches(group, done) {
            for i in batch.blocks.clone() {
                for owner in self.plan.contacts.owners[i].into_iter().filter(|row| *row != NONE) {
                    self.collide_mesh_again(owner, elapsed, scratch);
                }
            }
        }
        let ctx = StepContext { impulse_scale: 1.0 / self.ctx.store_scale(), ..*self.ctx };
        self.for_due(due, jobs, |fixed, i| self.put_rows(&ctx, fixed, i, elapsed));
    }

    /// Rotates the group's turning bodies by a substep; `anew` selects the bodies whose rows are
    /// rebuilt then.
    fn turn_all(&self, group: &Group, jobs: &Jobs<'_>, anew: impl Fn(usize) -> bool + Sync) {
        let solver_rows = self.turning_rows(group);
        for_shares(jobs, solver_rows.len(), 16, |part| {
            for solver_row in &solver_rows[part.start..part.end] {
                let solver_row = *solver_row as usize;
                self.turn(solver_row, anew(solver_row));
            }
        });
    }

    /// Stores the end states of the turning bodies.
    pub(crate) fn end_turning(&self, group: &Group) {
        for solver_row in self.turning_rows(group) {
            let i = *solver_row as usize;
            let state = self.now(self.plan.members[i - 1], 0.0);
            self.put_end(i, state);
        }
    }

    /// Removes a block's impulses from those that its bodies carry, and stores them in the
    /// contacts.
    fn take_warm(&self, fixed: bool, i: usize, elapsed: f32) {
        let tables = (&self.contacts, self.bodies);
        dispatch!(self.ctx.level, simd => {
            let block = self.contact.blocks.read(i);
            let extra = if self.contact.has_extras { Some(self.contact.extras.read(i)) } else { None };
            warm_of(simd, block, extra, fixed).carry(block, &self.body.aux, 1.0);
            let owners = &self.plan.contacts.owners[i];
            let begun = self.contact.begun.row(i);
            let when = (self.ctx, Some(elapsed));
            *begun |= store::store(simd, block, extra, (owners, *begun), tables, when);
        });
    }

    /// Rotates a body freely for a substep. If its rows are rebuilt (`anew`), its inertia is
    /// rotated too.
    fn turn(&self, solver_row: usize, anew: bool) {
        let body = self.bodies.at(self.plan.members[solver_row - 1]);
        let (state, h) = (self.body.states.row(solver_row), self.ctx.h);
        let w = self
            .body
            .whitening
            .read(solver_row)
            .s()
            .mul(solver_body::three(self.body.solver_bodies.read(solver_row).w));
        let m = body.inertia.moments;
        let round = m.max_element() - m.min_element() <= 1.0e-3 * m.max_element();
        let free = m.min_element() > 0.0 && body.inertia.locks.angular == [false; 3];
        let before = state.rotation;
        if free && !round {
            let spin = Spin { rotation: state.rotation, ..Spin::of(body) };
            let turned = rotate_freely(&spin, DVec3::from(w), h, self.ctx.substeps);
            (state.rotation, state.w) = (turned.rotation, turned.w);
        } else {
            (state.rotation, state.w) = (state.rotation.turned_by(w * h), w);
        }
        let factor = self.body.squeezes.read(solver_row).factor;
        if !anew {
            let (_, s_inv) = integrate::scaled_roots(body, before, factor);
            self.body.aux.row(solver_row).strike(
                self.body.solver_bodies.row(solver_row),
                Vec3::ZERO,
                s_inv.mul(state.w - w),
            );
            return;
        }
        let (s, s_inv) = integrate::scaled_roots(body, state.rotation, factor);
        let alpha = self.body.whitening.read(solver_row).alpha();
        *self.body.whitening.row(solver_row) = Whitening::new(alpha, &s);
        let solver_body = self.body.solver_bodies.row(solver_row);
        (solver_body.w, solver_body.t) = (solver_body::four(s_inv.mul(state.w)), [0.0; 4]);
        let aux = self.body.aux.row(solver_row);
        aux.start_anew(solver_body);
        aux.turn_by_torque(self.body.whitening.read(solver_row), body, h);
    }

    /// State of a body `elapsed` [s] after the step's start.
    fn now(&self, row: u32, elapsed: f32) -> BodyState {
        let body = self.bodies.at(row);
        let start = BodyState::of(body);
        let solver_row = self.body.solver_row_of[row as usize] as usize;
        if solver_row == 0 {
            let moves = !body.is_dynamic() && body.active();
            return if moves { start.drifted(elapsed) } else { start };
        }
        let state = start
            .after(self.body.solver_bodies.read(solver_row), self.body.whitening.read(solver_row));
        if self.plan.turning.bodies.contains(row) {
            return BodyState { rotation: self.body.states.read(solver_row).rotation, ..state };
        }
        state
    }

    fn pair_of(&self, contact: &Contact, elapsed: f32) -> Pair<'_> {
        let rows = [contact.body_a, contact.body_b];
        Pair {
            ctx: self.ctx,
            bodies: rows.map(|row| self.bodies.at(row)),
            states: rows.map(|row| self.now(row, elapsed)),
            shapes: [contact.shape_a, contact.shape_b].map(|shape| self.shapes.at(shape)),
        }
    }

    /// Rebuilds the manifold of a pair of convex shapes.
    fn collide_again(&self, row: u32, elapsed: f32) {
        let Some(contact) = self.contacts.row(row as usize) else { return };
        if contact.is_part || self.shapes.at(contact.shape_a).is_mesh() {
            return;
        }
        let pair = self.pair_of(contact, elapsed);
        let (_, b_in_a) = pair.poses();
        let margin = pair.reach();
        let [a, b] = pair.shapes.map(|shape| &shape.solid);
        let m = collide(self.ctx.level, a, b, &b_in_a, margin, &mut contact.cache);
        pair.renew(contact, &m);
    }

    /// Rebuilds the manifolds of a pair with a mesh, if this contact is its first.
    fn collide_mesh_again(&self, row: u32, elapsed: f32, scratch: &mut MeshScratch) {
        let Some(contact) = self.contacts.row(row as usize) else { return };
        let (shape_a, shape_b) = (self.shapes.at(contact.shape_a), self.shapes.at(contact.shape_b));
        let Core::Mesh(mesh) = &shape_a.solid.core else { return };
        if contact.is_part {
            return;
        }
        let pair = self.pair_of(contact, elapsed);
        let (pose_a, b_in_a) = pair.poses();
        let reach = Reach::still(pair.reach()).in_lengths(self.ctx.length);
        let mut made = [Manifold::default(); MAX_PARTS];
        let solid = &shape_b.solid;
        let level = self.ctx.level;
        let count = collide_mesh(level, mesh, solid, &b_in_a, &reach, scratch, &mut made);
        let mut left = [true; MAX_PARTS];
        let mut part = Some(contact);
        while let Some(contact) = part {
            if contact.place.is_somewhere() {
                let taken = nearest(&made[..count], &left, &pose_a, contact.normal);
                let manifold = taken.map_or_else(Manifold::default, |k| made[k]);
                taken.into_iter().for_each(|k| left[k] = false);
                pair.renew(contact, &manifold);
            }
            let next = contact.next_part;
            part = if next == NONE { None } else { self.contacts.row(next as usize).as_mut() };
        }
    }

    /// Builds the rows of a block from its rebuilt contacts, and adds their impulses to those that
    /// bodies carry.
    fn put_rows(&self, ctx: &StepContext, fixed: bool, i: usize, elapsed: f32) {
        let source = raw::Source { is_renewed: true, ..self.pack_source(ctx) };
        let owners = &self.plan.contacts.owners[i];
        dispatch!(self.ctx.level, simd => {
            let block = self.contact.blocks.row(i);
            let extra = if self.contact.has_extras { Some(self.contact.extras.row(i)) } else { None };
            let [arrived, hit] = [block.arrives, block.hit];
            if fixed {
                prepare::build::<_, true>(simd, &source, owners, block, extra);
            } else {
                prepare::build::<_, false>(simd, &source, owners, block, extra);
            }
            let extra = self.contact.has_extras.then(|| self.contact.extras.row(i));
            (block.arrives, block.hit) = (block.arrives | arrived, hit);
            self.watch_more(i);
            rebase(simd, block, extra, &self.body.solver_bodies, (fixed, elapsed));
            let extra = if self.contact.has_extras { Some(self.contact.extras.read(i)) } else { None };
            warm_of(simd, block, extra, fixed).carry(block, &self.body.aux, -1.0);
        });
    }
}

/// Effect of the impulses of eight contacts on their bodies, not scaled by masses.
struct Carried {
    push: [[f32; 4]; LANES],
    turn_a: [[f32; 4]; LANES],
    turn_b: [[f32; 4]; LANES],
}

impl Carried {
    /// Removes the impulses from those that the bodies carry to the next substep (1), or adds them
    /// (-1).
    fn carry(&self, block: &ContactBlock, aux: &Rows<'_, Aux>, sign: f32) {
        for lane in 0..LANES {
            let (a, b) = (block.row_a[lane] as usize, block.row_b[lane] as usize);
            if b != 0 {
                let scale = sign * block.beta[lane];
                aux.row(b).begin_later(&self.push[lane], scale, &self.turn_b[lane], sign);
            }
            if a != 0 {
                let scale = -sign * block.alpha[lane];
                aux.row(a).begin_later(&self.push[lane], scale, &self.turn_a[lane], -sign);
            }
        }
    }
}

/// The impulses of a block, mapped by its rows.
#[inline(always)]
fn warm_of<S: Simd>(simd: S, block: &ContactBlock, extra: Option<&Extra>, fixed: bool) -> Carried {
    let [f1, f2, f3] = [0, 1, 2].map(|i| load(simd, &block.friction[i]));
    let of_b = Vec3w::load3(simd, &block.b_t);
    let mut turn_b = of_b[0] * f1 + of_b[1] * f2 + of_b[2] * f3;
    let mut turn_a = Vec3w::zero(simd);
    if !fixed {
        let of_a = Vec3w::load3(simd, &block.a_t);
        turn_a = of_a[0] * f1 + of_a[1] * f2 + of_a[2] * f3;
    }
    let mut total = splat(simd, 0.0);
    for point in &block.points[..block.rows()] {
        let impulse = load(simd, &point.impulse);
        total += impulse;
        turn_b = turn_b + Vec3w::load(simd, &point.b) * impulse;
        if !fixed {
            turn_a = turn_a + Vec3w::load(simd, &point.a) * impulse;
        }
    }
    if let Some(extra) = extra
        && extra.rolls
    {
        let impulse = Vec3w::load(simd, &extra.rolling_impulse);
        turn_a = turn_a + Sym3w::load(simd, &extra.s_a).mul(impulse);
        turn_b = turn_b + Sym3w::load(simd, &extra.s_b).mul(impulse);
    }
    let push = Vec3w::load(simd, &block.n) * total
        + Vec3w::load(simd, &block.t1) * f1
        + Vec3w::load(simd, &block.t2) * f2;
    let lanes = |v: Vec3w<S>| {
        let rows = scatter(simd, v);
        let mut out = [[0.0; 4]; LANES];
        for lane in 0..LANES {
            rows[lane].store_array(&mut out[lane]);
        }
        out
    };
    Carried { push: lanes(push), turn_a: lanes(turn_a), turn_b: lanes(turn_b) }
}

/// Shifts separations to the step's start. The kernel adds all motion since then, so the motion up
/// to now is subtracted from separations measured now.
#[inline(always)]
fn rebase<S: Simd>(
    simd: S,
    block: &mut ContactBlock,
    extra: Option<&mut Extra>,
    solver_bodies: &ReadRows<'_, SolverBody>,
    (fixed, elapsed): (bool, f32),
) {
    let n = Vec3w::load(simd, &block.n);
    let xb = load_motion(simd, solver_bodies, &block.row_b);
    let mut moved = n.dot(xb.v) * load(simd, &block.beta);
    let mut xa = xb;
    if !fixed {
        xa = load_motion(simd, solver_bodies, &block.row_a);
        moved -= n.dot(xa.v) * load(simd, &block.alpha);
    }
    let time = splat(simd, elapsed);
    let drifts = extra.as_ref().is_some_and(|extra| extra.drifts);
    for j in 0..block.rows() {
        let point = &mut block.points[j];
        let mut since = moved + Vec3w::load(simd, &point.b).dot(xb.w);
        if !fixed {
            since -= Vec3w::load(simd, &point.a).dot(xa.w);
        }
        if let Some(extra) = extra.as_deref()
            && drifts
        {
            since += load(simd, &extra.drift[j]) * time;
        }
        (load(simd, &point.s0) - since).store_array(&mut point.s0);
    }
    if let Some(extra) = extra
        && drifts
    {
        for i in 0..2 {
            let now = load(simd, &extra.drift_t[i]) - load(simd, &extra.drift_rate[i]) * time;
            now.store_array(&mut extra.drift_t[i]);
        }
    }
}
