//! Tied particles: their passes within a step of the solver.

use fearless_simd::dispatch;

use super::meet::Meeting;
use super::pace::{Form, Pace, ParticlePass, SolverBodies};
use super::points::Contacts;
use super::rows::{Ground, HoldRow, Partner};
use super::{chain, links};
use crate::base::math::Vec3;
use crate::base::simd::wide::LANES;
use crate::base::sym3::Sym3;
use crate::base::threads::disjoint::{Apart, Rows};
use crate::base::threads::jobs::{Jobs, for_items, for_ranges, grain};
use crate::state::bodies::Bodies;
use crate::state::chains::{ChainBlock, ChainRow};
use crate::state::particles::{CROWD, LinkBlock, ParticleState, Particles};
use crate::step::context::softness::decay;
use crate::step::solver_body::SolverBody;

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    /// By line: velocity before any impulse of the substep (soft form), or displacement at the
    /// substep's start (positions).
    before: Vec<[f32; 4]>,
    /// By index of the tied particle: velocity that forces add in a substep, and the factor of
    /// damping.
    forces: Vec<[f32; 4]>,
    contacts: Contacts,
    holds: Vec<HoldRow>,
    /// Index of each attachment's row + 1, or 0.
    hold_of: Vec<u32>,
    /// Rows of the bodies that particles push or are held by in this step, ascending; and those of
    /// the last step.
    pub(crate) dragged: Vec<u32>,
    pub(crate) released: Vec<u32>,
    /// Motion of each dragged body in a substep beyond its velocity, beside a classic method.
    own: Vec<SolverBody>,
    /// Groups of the solver with such bodies, ascending.
    pub(crate) groups: Vec<usize>,
}

/// Particles that are tied by links, attachments or bodies, during a step.
#[derive(Debug)]
pub(crate) struct Tied<'a> {
    pub(crate) pace: Pace,
    pub(crate) particles: &'a mut Particles,
    /// Lines of the tied particles.
    pub(crate) tied: &'a [u32],
    pub(crate) meetings: &'a [Meeting],
    pub(crate) scratch: &'a mut Scratch,
}

impl Tied<'_> {
    /// True if there is nothing to do.
    pub(crate) const fn is_idle(&self) -> bool {
        self.tied.is_empty()
    }

    /// Prepares the rows of this step, and applies the stored impulses.
    pub(crate) fn begin(&mut self, bodies: &Bodies, to: &SolverBodies<'_>, jobs: &Jobs<'_>) {
        let pace = self.pace;
        let s = &mut *self.scratch;
        s.before.resize(self.particles.states.len(), [0.0; 4]);
        s.forces.clear();
        for solver_row in self.tied {
            let (p, row) =
                (self.particles.at(*solver_row), &self.particles.states[*solver_row as usize]);
            let free = row.inverse_mass() > 0.0;
            let a = if free { pace.gravity * (p.gravity_scale * pace.h) } else { Vec3::ZERO };
            let left = if free { decay(p.damping, pace.h) } else { 1.0 };
            s.forces.push([a.x, a.y, a.z, left]);
            s.before[*solver_row as usize] = row.v;
        }
        {
            let Particles { colors, x, states, .. } = &mut *self.particles;
            // SAFETY: a color's links share no particle; the crowd, which may, is one range.
            let states = Rows::new(states, unsafe { Apart::promise() });
            for (number, color) in colors.iter_mut().enumerate() {
                for_blocks(&mut color.blocks, number == CROWD, jobs, &|blocks| {
                    dispatch!(pace.level, simd => {
                        for block in blocks {
                            links::prepare(simd, block, x, &states, &pace);
                        }
                    });
                });
            }
        }
        self.begin_holds(bodies, to);
        self.begin_chains();
        self.begin_contacts(bodies, to, jobs);
    }

    fn begin_holds(&mut self, bodies: &Bodies, to: &SolverBodies<'_>) {
        let s = &mut *self.scratch;
        s.holds.clear();
        s.hold_of.clear();
        s.hold_of.resize(self.particles.attachments.len(), 0);
        for i in 0..self.particles.attachments.len() {
            let held = self.particles.attachments[i];
            let body = bodies.at(held.body);
            if !super::meet::moves(self.particles.at(held.solver_row)) || body.out {
                continue;
            }
            let r = body.rotation.rotate(held.anchor);
            let gap = self.particles.position(held.solver_row) - (body.center + r);
            let drift = if body.is_dynamic() { Vec3::ZERO } else { body.velocity_at(r) };
            let impulse = held.impulse * self.pace.impulse_scale;
            let states = &mut self.particles.states;
            let ground = Ground::new(&self.pace, states, &mut s.before, to.solver_bodies, 0.0);
            let number = u32::try_from(i).expect("fewer than 2^32 particles");
            let partner = Partner::new(to.solver_row_of[held.body as usize], &to.whitening);
            let vectors = [r, gap, drift, impulse];
            s.holds.push(HoldRow::new((held.solver_row, number), partner, vectors, &ground));
            s.hold_of[i] = u32::try_from(s.holds.len()).expect("fewer than 2^32 particles");
        }
    }

    /// Prepares chains with the impulses of their links; the links themselves become idle.
    fn begin_chains(&mut self) {
        if self.pace.form != Form::Soft {
            return;
        }
        let Particles { chains, colors, .. } = &mut *self.particles;
        for block in chains.blocks_mut() {
            chain::begin(block, colors);
        }
    }

    fn begin_contacts(&mut self, bodies: &Bodies, to: &SolverBodies<'_>, jobs: &Jobs<'_>) {
        let Scratch { before, contacts, .. } = &mut *self.scratch;
        let Particles { states, touches, .. } = &mut *self.particles;
        let ground = Ground::new(&self.pace, states, before, to.solver_bodies, 0.0);
        contacts.begin((self.meetings, touches), bodies, to, &ground, jobs);
    }

    /// Applies forces, and the part of the last substep's impulses that is kept.
    pub(crate) fn velocities(&mut self, first: bool, jobs: &Jobs<'_>) {
        let (pace, tied, forces) = (self.pace, self.tied, &self.scratch.forces);
        // SAFETY: tied particles are all different.
        let apart = unsafe { Apart::promise() };
        let states = Rows::new(&mut self.particles.states, apart);
        let before = Rows::new(&mut self.scratch.before, apart);
        for_ranges(jobs, tied.len(), grain(jobs, tied.len(), 256), |range| {
            for i in range {
                let [x, y, z, left] = forces[i];
                let (add, row) = ([x, y, z], tied[i] as usize);
                let (state, was) = (states.row(row), before.row(row));
                for k in 0..3 {
                    match pace.form {
                        Form::Soft => {
                            let keep = if first { 1.0 } else { pace.keep };
                            let impulse = (state.v[k] - was[k]) * keep;
                            let from = if first { was[k] } else { state.v[k] };
                            was[k] = (from + add[k]) * left;
                            state.v[k] = was[k] + impulse;
                        }
                        Form::Aim => state.v[k] = (state.v[k] + add[k]) * left,
                        Form::Verlet => {
                            was[k] = state.x[k];
                            state.x[k] += (state.v[k] * pace.h + add[k] * pace.h) * left;
                        }
                    }
                }
            }
        });
    }

    /// Sweeps of a substep, with bias.
    pub(crate) fn solve(&mut self, substep: u32, bodies: Rows<'_, SolverBody>, jobs: &Jobs<'_>) {
        #[expect(clippy::cast_precision_loss, reason = "at most 256")]
        let elapsed = substep as f32 * self.pace.h;
        // One sweep is enough for particles without links and attachments.
        let tied = !self.particles.links.is_empty() || !self.scratch.holds.is_empty();
        for sweep in 0..if tied { self.pace.sweeps } else { 1 } {
            let first = sweep == 0 && (substep > 0 || self.pace.form != Form::Soft);
            self.sweep(ParticlePass::Solve { first }, elapsed, bodies, jobs);
        }
    }

    /// The sweep without bias, after `moved` [s] of the step.
    pub(crate) fn relax(&mut self, moved: f32, bodies: Rows<'_, SolverBody>, jobs: &Jobs<'_>) {
        if self.pace.form == Form::Soft {
            self.sweep(ParticlePass::Relax, moved, bodies, jobs);
        }
    }

    fn sweep(
        &mut self,
        kind: ParticlePass,
        elapsed: f32,
        bodies: Rows<'_, SolverBody>,
        jobs: &Jobs<'_>,
    ) {
        let pace = &self.pace;
        let (is_relax, first) = (
            matches!(kind, ParticlePass::Relax),
            matches!(kind, ParticlePass::Solve { first: true }),
        );
        let Particles { colors, chains, states, .. } = &mut *self.particles;
        let s = &mut *self.scratch;
        let ground = Ground::new(pace, states, &mut s.before, bodies, elapsed);
        let states = ground.particles;
        for hold in &mut s.holds {
            hold.solve(&ground, is_relax, first);
        }
        if pace.form == Form::Soft {
            for block in &mut chains.held {
                sweep_held(block, (&mut s.holds, &s.hold_of), &ground, kind);
            }
            for color in &mut chains.colors {
                let minimum = grain(jobs, color.len(), 1);
                for_items(jobs, color, minimum, |_, blocks| {
                    for block in blocks {
                        sweep_chains(&mut block.rows, None, &states, pace, kind);
                    }
                });
            }
        }
        for (number, color) in colors.iter_mut().enumerate() {
            for_blocks(&mut color.blocks, number == CROWD, jobs, &|blocks| {
                sweep_links(blocks, &states, pace, kind);
            });
        }
        s.contacts.sweep(kind, &ground, jobs);
    }

    /// Advances displacements by velocities for one substep, or computes velocities from
    /// displacements.
    pub(crate) fn positions(&mut self, jobs: &Jobs<'_>) {
        let (pace, tied) = (self.pace, self.tied);
        // SAFETY: tied particles are all different.
        let apart = unsafe { Apart::promise() };
        let states = Rows::new(&mut self.particles.states, apart);
        let before = Rows::new(&mut self.scratch.before, apart);
        for_ranges(jobs, tied.len(), grain(jobs, tied.len(), 256), |range| {
            for i in range {
                let state = states.row(tied[i] as usize);
                for k in 0..3 {
                    if pace.form == Form::Verlet {
                        state.v[k] = (state.x[k] - before.read(tied[i] as usize)[k]) * pace.inv_h;
                    } else {
                        state.x[k] += pace.h * state.v[k];
                    }
                }
            }
        });
    }

    /// Applies restitution, and stores impulses.
    pub(crate) fn end(&mut self, bodies: Rows<'_, SolverBody>, jobs: &Jobs<'_>) {
        let s = &mut *self.scratch;
        let Particles { states, chains, colors, attachments, touches, .. } = &mut *self.particles;
        let ground = Ground::new(&self.pace, states, &mut s.before, bodies, 0.0);
        s.contacts.bounce(&ground, jobs);
        if self.pace.form == Form::Soft {
            for block in chains.blocks_mut() {
                chain::end(block, colors);
            }
        }
        for hold in &s.holds {
            attachments[hold.number as usize].impulse = hold.impulse;
        }
        s.contacts.store(self.meetings, touches);
    }

    /// The whole step after that of the bodies: effects of particles on them are added to their
    /// motion. `states` are whitened.
    pub(crate) fn follow(&mut self, bodies: &Bodies, to: &SolverBodies<'_>, jobs: &Jobs<'_>) {
        let (dragged, n) = (self.scratch.dragged.len(), self.pace.substeps);
        // Motion of each dragged body in a substep beyond its velocity.
        let mut own = core::mem::take(&mut self.scratch.own);
        own.clear();
        #[expect(clippy::cast_precision_loss, reason = "at most 256")]
        let part = 1.0 / n as f32;
        for i in 0..dragged {
            let solver_body =
                to.solver_bodies.row(to.solver_row_of[self.scratch.dragged[i] as usize] as usize);
            let mut of = SolverBody::default();
            for k in 0..4 {
                of.x[k] = solver_body.x[k] * part - self.pace.h * solver_body.v[k];
                of.t[k] = solver_body.t[k] * part - self.pace.h * solver_body.w[k];
            }
            (solver_body.x, solver_body.t) = ([0.0; 4], [0.0; 4]);
            own.push(of);
        }
        self.begin(bodies, to, jobs);
        self.tally(0.0);
        for substep in 0..n {
            self.velocities(substep == 0, jobs);
            self.solve(substep, to.solver_bodies, jobs);
            self.positions(jobs);
            for (i, of) in own.iter().enumerate() {
                let solver_body = to
                    .solver_bodies
                    .row(to.solver_row_of[self.scratch.dragged[i] as usize] as usize);
                for k in 0..4 {
                    solver_body.x[k] += of.x[k] + self.pace.h * solver_body.v[k];
                    solver_body.t[k] += of.t[k] + self.pace.h * solver_body.w[k];
                }
            }
            if substep + 1 < n {
                self.tally(1.0);
            }
        }
        #[expect(clippy::cast_precision_loss, reason = "at most 256")]
        let dt = self.pace.h * n as f32;
        self.relax(dt, to.solver_bodies, jobs);
        self.tally(1.0);
        self.average(part);
        self.end(to.solver_bodies, jobs);
        self.scratch.own = own;
    }

    /// Sums the impulses of holds and chains; a factor of 0 restarts the sum. Bodies that have
    /// completed their step already moved by all of their gravity, so the first substep pulls for
    /// the others too. The reported pull is therefore the mean.
    fn tally(&mut self, factor: f32) {
        for hold in &mut self.scratch.holds {
            hold.total = (hold.total + hold.impulse) * factor;
        }
        for row in self.particles.chains.blocks_mut().flat_map(|block| &mut block.rows) {
            for (total, impulse) in row.total.iter_mut().zip(row.impulse) {
                *total = (*total + impulse) * factor;
            }
        }
    }

    /// Replaces the last impulse by the mean: `part` of the sum.
    fn average(&mut self, part: f32) {
        if self.pace.form != Form::Soft {
            return;
        }
        for hold in &mut self.scratch.holds {
            hold.impulse = hold.total * part;
        }
        for row in self.particles.chains.blocks_mut().flat_map(|block| &mut block.rows) {
            for (total, impulse) in row.total.iter().zip(&mut row.impulse) {
                *impulse = total * part;
            }
        }
    }
}

/// Calls `f` with all blocks; a crowd, which may share particles, is passed as one slice.
pub(crate) fn for_blocks(
    blocks: &mut [LinkBlock],
    crowd: bool,
    jobs: &Jobs<'_>,
    f: &(dyn Fn(&mut [LinkBlock]) + Sync),
) {
    let n = blocks.len();
    let minimum = if crowd { n } else { grain(jobs, n, 32) };
    for_items(jobs, blocks, minimum, |_, blocks| f(blocks));
}

/// Solves a chain held by bodies, after the holds at its ends.
fn sweep_held(
    block: &mut ChainBlock,
    (holds, hold_of): (&mut [HoldRow], &[u32]),
    ground: &Ground<'_>,
    kind: ParticlePass,
) {
    let mut ends = [Sym3::ZERO; 2];
    let mut rows = [None; 2];
    for (side, number) in block.holds.iter().enumerate() {
        rows[side] = number.and_then(|n| hold_of[n as usize].checked_sub(1));
        if let Some(row) = rows[side] {
            // Another chain may have moved the body since the last solve of the holds.
            let hold = &mut holds[row as usize];
            hold.solve(ground, matches!(kind, ParticlePass::Relax), false);
            ends[side] = hold.less();
        }
    }
    let given = sweep_chains(&mut block.rows, Some(&ends), &ground.particles, ground.pace, kind);
    for (row, p) in rows.into_iter().zip(given) {
        if let Some(row) = row {
            holds[row as usize].hand_on(&ground.bodies, p);
        }
    }
}

fn sweep_chains(
    rows: &mut [ChainRow],
    ends: Option<&chain::Ends>,
    states: &Rows<'_, ParticleState>,
    pace: &Pace,
    kind: ParticlePass,
) -> [Vec3; 2] {
    dispatch!(pace.level, simd => match kind {
        ParticlePass::Solve { first } => chain::solve(simd, rows, ends, states, pace, first),
        ParticlePass::Relax => chain::relax(simd, rows, ends, states, pace),
    })
}

fn sweep_links(
    blocks: &mut [LinkBlock],
    states: &Rows<'_, ParticleState>,
    pace: &Pace,
    kind: ParticlePass,
) {
    dispatch!(pace.level, simd => {
        for block in blocks {
            if pace.form == Form::Soft && block.chained == [true; LANES] {
                continue;
            }
            match (kind, pace.form) {
                (ParticlePass::Relax, _) => links::relax(simd, block, states, pace),
                (ParticlePass::Solve { first }, Form::Soft) => {
                    links::solve(simd, block, states, pace, first);
                }
                (ParticlePass::Solve { first }, Form::Aim) => links::aim(simd, block, states, pace, first),
                (ParticlePass::Solve { first }, Form::Verlet) => {
                    links::project(simd, block, states, pace, first);
                }
            }
        }
    });
}
