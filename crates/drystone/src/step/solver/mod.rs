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
use crate::state::colors::Colors;
use crate::state::contacts::Contacts;
use crate::state::def::config::WorldConfig;
use crate::state::joints::Joints;

/// Runs the passes of the world's method: a default method in [`wide`], a classic one in
/// [`classic`]. `finalize` then writes the poses, from [`Scratch::solved`].
pub(crate) fn solve(
    ctx: &StepContext,
    config: &WorldConfig,
    input: Input<'_>,
    joints: &mut Joints,
    contacts: &mut Contacts,
    colors: &mut Colors,
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
        wide::solve(ctx, config, input, joints, contacts, colors, scratch, tied, jobs);
    }
}
