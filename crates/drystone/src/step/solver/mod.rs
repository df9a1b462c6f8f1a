//! The stage `solver`: computes the velocities and pose changes of a step from contacts and joints.
//!
//! Reads: bodies (state), shapes (surface velocities), contacts (manifolds), joints, colors.
//! Writes: contacts and joints (impulses), solver bodies. Runs: groups of small islands side by
//! side, one worker for each group. In a large island it runs in parallel over bodies, and over the
//! blocks of one color after another.
//!
//! Invariants: a color touches a dynamic body once; groups share no dynamic body; blocks are eight
//! wide on every machine; the order of colors is fixed.
//!
//! References: docs/derivations/soft-step.md, [Catto24], [Macklin19].

mod articulation;
mod bound;
pub(crate) mod work;
mod impact;
mod plan;
mod rounds;
mod passes;
mod totals;
mod vec6;
mod with_particles;
pub(crate) mod body;
pub(crate) mod contact;
pub(crate) mod input;
pub(crate) mod joint;
pub(crate) mod lent;
pub(crate) mod pass;
pub(crate) mod scratch;
pub(crate) mod totals_rows;
pub(crate) mod tree;
pub(crate) mod wide;

use self::input::Input;
use self::scratch::Scratch;
use super::classic;
use super::context::StepContext;
use super::particles::tied::Tied;
use crate::base::threads::jobs::Jobs;
use crate::state::articulations::Articulations;
use crate::state::colors::Colors;
use crate::state::contacts::Contacts;
use crate::state::def::config::WorldConfig;
use crate::state::joints::Joints;

/// State of the body of a link.
pub(crate) use self::articulation::link_state;

/// The tables that the solver writes.
pub(crate) type Tables<'a> =
    (&'a mut Joints, &'a mut Articulations, &'a mut Contacts, &'a mut Colors);

/// Runs the passes of the world's method: a default method in [`wide`], a classic one in
/// [`classic`]. `finalize` then writes the poses, from [`Scratch::solved`].
pub(crate) fn solve(
    ctx: &StepContext,
    config: &WorldConfig,
    input: Input<'_>,
    (joints, articulations, contacts, colors): Tables<'_>,
    scratch: &mut Scratch,
    tied: &mut Tied<'_>,
    jobs: &Jobs<'_>,
) {
    scratch.contact.begin_step();
    if config.method.is_classic() {
        scratch.leave_wide();
        let Scratch { classic, solved, .. } = scratch;
        classic::solve(ctx, &config.method, input, joints, contacts, colors, classic, solved);
        with_particles::follow(ctx, input.bodies, solved, tied, jobs);
    } else {
        scratch.leave_classic();
        let tables = (joints, articulations, contacts, colors);
        wide::solve(ctx, config, input, tables, scratch, tied, jobs);
    }
}
