//! Stage 4: contacts and joints to velocities and poses' changes, by the passes of the method.
//!
//! Reads: bodies (state), contacts (manifolds), joints, colors. Writes: bodies (velocity, pose),
//! contacts and joints (impulses), events (begin, hit). Runs: parallel over bodies, and over the
//! blocks of one color after the other. Invariants: a color touches a dynamic body once; blocks are
//! eight wide everywhere; the order of colors is fixed.
//! References: docs/derivations/soft-step.md, [Catto24], [Macklin19].

pub(crate) mod softness;
pub(crate) mod rows;
pub(crate) mod contact;
pub(crate) mod joint;
pub(crate) mod integrate;
mod pack;
mod pack_joint;

use core::ops::Range;

use fearless_simd::dispatch;

use self::contact::Sweep;
use self::integrate::Aux;
use self::joint::JointSweep;
use self::rows::{ContactBlock, Extra, JointBlock, Line, Whitening};
use self::softness::Softness;
use super::context::StepContext;
use crate::base::disjoint::Rows;
use crate::base::grow;
use crate::base::jobs::{Executor, collect_ranges, for_items, for_ranges, grain};
use crate::base::math::Vec3;
use crate::base::wide::{LANES, Lanes};
use crate::state::bodies::Bodies;
use crate::state::colors::Colors;
use crate::state::contacts::Contacts;
use crate::state::joints::Joints;
use crate::state::method::{Method, Pass};

/// Sweeps of the bounce pass: enough for a bounce to run through a chain of a few bodies.
const BOUNCE_SWEEPS: u32 = 4;

/// Blocks of one color.
#[derive(Clone, Debug)]
struct Batch {
    blocks: Range<usize>,
    /// One side of every constraint cannot be pushed.
    fixed: bool,
    /// Place of the first constraint's color in its list.
    color: usize,
}

/// The solver's memory, kept from step to step so that a warm step allocates nothing.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    /// Body row of line k + 1.
    members: Vec<u32>,
    pub(crate) line_of: Vec<u32>,
    pub(crate) lines: Vec<Line>,
    pub(crate) whitening: Vec<Whitening>,
    aux: Vec<Aux>,
    acceleration: Vec<Vec3>,
    /// Lines with locked translation.
    locked: Vec<(u32, [bool; 3])>,
    blocks: Vec<ContactBlock>,
    extras: Vec<Extra>,
    given: Vec<[Lanes; 4]>,
    joints: Vec<JointBlock>,
    batches: Vec<Batch>,
    joint_batches: Vec<Batch>,
    begun: Vec<Vec<u32>>,
    /// Of the members of a color: what they are sorted by, and their rows.
    keys: Vec<(u8, u32, u32)>,
}

impl Scratch {
    /// Contact rows that were pressed together for the first time.
    pub(crate) fn begun(&self) -> impl Iterator<Item = u32> {
        self.begun.iter().flatten().copied()
    }
}

/// Runs the method's passes. Poses are written by finalize, from the lines.
pub(crate) fn solve(
    ctx: &StepContext,
    method: &Method,
    bodies: &Bodies,
    joints: &mut Joints,
    contacts: &mut Contacts,
    colors: &mut Colors,
    scratch: &mut Scratch,
    jobs: &dyn Executor,
) {
    prepare_bodies(ctx, bodies, scratch, jobs);
    order_contacts(bodies, contacts, colors, &mut scratch.keys);
    plan_batches(contacts, colors, scratch);
    pack_joint::prepare(ctx, bodies, joints, colors, scratch);
    prepare_contacts(ctx, bodies, contacts, colors, scratch, jobs);

    for substep in 0..ctx.substeps {
        for pass in method.substep() {
            run(ctx, *pass, substep, substep == 0, scratch, jobs);
        }
    }
    for pass in method.finish() {
        run(ctx, *pass, ctx.substeps, false, scratch, jobs);
    }
    store(contacts, scratch, jobs);
    pack_joint::store(joints, scratch);
}

fn run(
    ctx: &StepContext,
    pass: Pass,
    substep: u32,
    first: bool,
    scratch: &mut Scratch,
    jobs: &dyn Executor,
) {
    #[expect(clippy::cast_precision_loss, reason = "at most 256")]
    let elapsed = substep as f32 * ctx.h;
    // A relax pass within a substep stands after its positions.
    let moved = elapsed + if substep < ctx.substeps { ctx.h } else { 0.0 };
    match pass {
        Pass::Velocities => {
            let aux = Rows::new(&mut scratch.aux);
            let least = grain(jobs, scratch.lines.len(), 256);
            for_items(jobs, &mut scratch.lines, least, |start, lines| {
                let aux = aux.slice(start..start + lines.len());
                for (line, aux) in lines.iter_mut().zip(aux) {
                    integrate::velocities(line, aux, first);
                }
            });
            hold_locked(scratch);
        }
        Pass::Positions => {
            let least = grain(jobs, scratch.lines.len(), 256);
            for_items(jobs, &mut scratch.lines, least, |_, lines| {
                for line in lines {
                    integrate::positions(line, ctx.h);
                }
            });
        }
        Pass::Solve { inner } => {
            sweep_joints(ctx, ctx.soft_joint, elapsed, scratch, jobs);
            sweep_contacts(
                ctx,
                [ctx.soft, ctx.soft_fixed],
                inner.clamp(1, 8),
                elapsed,
                scratch,
                jobs,
            );
            hold_locked(scratch);
        }
        Pass::Relax => {
            sweep_joints(ctx, Softness::RIGID, moved, scratch, jobs);
            sweep_contacts(ctx, [Softness::RIGID; 2], 1, moved, scratch, jobs);
            hold_locked(scratch);
        }
        Pass::Restitution => {
            bounce(ctx, moved, scratch, jobs);
            hold_locked(scratch);
        }
    }
}

/// Lines of all awake dynamic bodies that some constraint acts on; the others fly (finalize).
fn prepare_bodies(ctx: &StepContext, bodies: &Bodies, scratch: &mut Scratch, jobs: &dyn Executor) {
    // Only what the last step set is reset: a world of a million static bodies costs nothing here.
    for row in &scratch.members {
        scratch.line_of[*row as usize] = 0;
    }
    if scratch.line_of.len() < bodies.rows.slot_count() {
        scratch.line_of.resize(bodies.rows.slot_count(), 0);
    }
    scratch.members.clear();
    scratch.locked.clear();
    for row in &bodies.awake {
        let body = bodies.at(*row);
        if !body.is_dynamic() || body.constraints == 0 {
            continue;
        }
        scratch.members.push(*row);
        let line = u32::try_from(scratch.members.len()).expect("fewer than 2^32 bodies");
        scratch.line_of[*row as usize] = line;
        if body.locks.linear != [false; 3] {
            scratch.locked.push((line, body.locks.linear));
        }
    }
    let n = scratch.members.len() + 1;
    scratch.lines.resize(n, Line::default());
    scratch.whitening.resize(n, Whitening::default());
    scratch.aux.resize(n, Aux::default());
    scratch.acceleration.resize(n, Vec3::ZERO);
    let whitening = Rows::new(&mut scratch.whitening);
    let aux = Rows::new(&mut scratch.aux);
    let acceleration = Rows::new(&mut scratch.acceleration);
    let members = &scratch.members;
    for_items(jobs, &mut scratch.lines[1..], grain(jobs, n, 64), |start, lines| {
        for (k, line) in lines.iter_mut().enumerate() {
            let i = start + k;
            let (l, w, mut a, acc) = integrate::whiten(ctx, bodies.at(members[i]));
            integrate::begin(&l, &mut a);
            *line = l;
            *whitening.row(i + 1) = w;
            *aux.row(i + 1) = a;
            *acceleration.row(i + 1) = acc;
        }
    });
}

/// Puts the contacts of changed colors in order: by number of points, so that blocks are even, then by
/// body, so that lines are near each other. Order within a color never shows in the result.
fn order_contacts(
    bodies: &Bodies,
    contacts: &mut Contacts,
    colors: &mut Colors,
    keys: &mut Vec<(u8, u32, u32)>,
) {
    for coloring in [&mut colors.contacts, &mut colors.contacts_fixed] {
        for (index, color) in (0_u32..).zip(&mut coloring.colors) {
            if !core::mem::take(&mut color.dirty) {
                continue;
            }
            keys.clear();
            keys.extend(color.members.iter().map(|row| {
                let c = contacts.at(*row);
                let body = if bodies.at(c.body_a).is_dynamic() { c.body_a } else { c.body_b };
                (4 - c.count.min(4), bodies.at(body).awake_row, *row)
            }));
            keys.sort_unstable();
            for ((row, member), key) in (0_u32..).zip(&mut color.members).zip(keys.iter()) {
                *member = key.2;
                contacts.at_mut(*member).place = crate::state::colors::Place { color: index, row };
            }
        }
    }
}

fn plan_batches(contacts: &Contacts, colors: &Colors, scratch: &mut Scratch) {
    let _ = contacts;
    scratch.batches.clear();
    let mut at = 0;
    for (fixed, coloring) in [(false, &colors.contacts), (true, &colors.contacts_fixed)] {
        for (color, members) in coloring.colors.iter().map(|c| &c.members).enumerate() {
            let n = members.len().div_ceil(LANES);
            if n > 0 {
                scratch.batches.push(Batch { blocks: at..at + n, fixed, color });
                at += n;
            }
        }
    }
    let more = at.saturating_sub(scratch.blocks.len());
    grow::make_room(&mut scratch.blocks, more);
    scratch.blocks.resize_with(at, ContactBlock::default);
    let extras = if colors.special > 0 { at } else { 0 };
    scratch.extras.resize_with(extras, Extra::default);
    scratch.given.clear();
    scratch.given.resize(extras, [[0.0; LANES]; 4]);
}

fn prepare_contacts(
    ctx: &StepContext,
    bodies: &Bodies,
    contacts: &mut Contacts,
    colors: &Colors,
    scratch: &mut Scratch,
    jobs: &dyn Executor,
) {
    let Scratch { lines, whitening, acceleration, line_of, blocks, extras, batches, .. } = scratch;
    let source = pack::Source {
        ctx,
        bodies,
        line_of,
        whitening,
        acceleration,
        impulse_scale: ctx.impulse_scale,
    };
    let lines = Rows::new(lines);
    let (slots, _) = contacts.slots_mut();
    let slots = Rows::new(slots);
    let with_extras = !extras.is_empty();
    let extras = Rows::new(extras);
    for batch in batches.iter() {
        let coloring = if batch.fixed { &colors.contacts_fixed } else { &colors.contacts };
        let members = &coloring.colors[batch.color].members;
        let first = batch.blocks.start;
        let blocks = &mut blocks[batch.blocks.clone()];
        let least = grain(jobs, blocks.len(), 8);
        for_items(jobs, blocks, least, |start, blocks| {
            dispatch!(ctx.level, simd => {
                for (k, block) in blocks.iter_mut().enumerate() {
                    let i = start + k;
                    let members = &members[i * LANES..((i + 1) * LANES).min(members.len())];
                    let extra = with_extras.then(|| extras.row(first + i));
                    pack::pack(simd, &source, members, &slots, block, extra, &lines);
                }
            });
        });
    }
}

fn sweep_contacts(
    ctx: &StepContext,
    [soft, soft_fixed]: [Softness; 2],
    inner: u32,
    elapsed: f32,
    scratch: &mut Scratch,
    jobs: &dyn Executor,
) {
    let Scratch { lines, blocks, extras, batches, .. } = scratch;
    let lines = Rows::new(lines);
    let with_extras = !extras.is_empty();
    let extras = Rows::new(extras);
    for batch in batches.iter() {
        let softness = if batch.fixed { soft_fixed } else { soft };
        let sweep = Sweep { inv_h: ctx.inv_h, softness, cap: ctx.push_speed, inner, elapsed };
        let first = batch.blocks.start;
        let blocks = &mut blocks[batch.blocks.clone()];
        let least = grain(jobs, blocks.len(), 8);
        for_items(jobs, blocks, least, |start, blocks| {
            dispatch!(ctx.level, simd => {
                for (k, block) in blocks.iter_mut().enumerate() {
                    let extra = with_extras.then(|| extras.row(first + start + k));
                    contact::solve(simd, block, extra, &lines, &sweep);
                }
            });
        });
    }
}

fn sweep_joints(
    ctx: &StepContext,
    softness: Softness,
    elapsed: f32,
    scratch: &mut Scratch,
    jobs: &dyn Executor,
) {
    let Scratch { lines, joints, joint_batches, .. } = scratch;
    let lines = Rows::new(lines);
    let sweep = JointSweep { inv_h: ctx.inv_h, softness, elapsed };
    for batch in joint_batches.iter() {
        let blocks = &mut joints[batch.blocks.clone()];
        let least = grain(jobs, blocks.len(), 8);
        for_items(jobs, blocks, least, |_, blocks| {
            dispatch!(ctx.level, simd => {
                for block in blocks {
                    if block.is_distance {
                        joint::solve_distance(simd, block, &lines, &sweep);
                    } else {
                        joint::solve_ball(simd, block, &lines, &sweep);
                    }
                }
            });
        });
    }
}

fn bounce(ctx: &StepContext, elapsed: f32, scratch: &mut Scratch, jobs: &dyn Executor) {
    let Scratch { lines, blocks, extras, given, batches, .. } = scratch;
    if !extras.iter().any(|e| e.bounces) {
        return;
    }
    let lines = Rows::new(lines);
    let given = Rows::new(given);
    for _ in 0..BOUNCE_SWEEPS {
        for batch in batches.iter() {
            let range = batch.blocks.clone();
            let least = grain(jobs, range.len(), 8);
            for_ranges(jobs, range.len(), least, |part| {
                dispatch!(ctx.level, simd => {
                    for i in range.start + part.start..range.start + part.end {
                        if extras[i].bounces {
                            contact::bounce(simd, &blocks[i], &extras[i], &lines, elapsed, given.row(i));
                        }
                    }
                });
            });
        }
    }
}

/// Locked translations are taken out again: a projection after every sweep.
fn hold_locked(scratch: &mut Scratch) {
    for (line, locks) in &scratch.locked {
        let line = &mut scratch.lines[*line as usize];
        for i in 0..3 {
            if locks[i] {
                line.v[i] = 0.0;
            }
        }
    }
}

fn store(contacts: &mut Contacts, scratch: &mut Scratch, jobs: &dyn Executor) {
    let Scratch { blocks, extras, begun, .. } = scratch;
    let (slots, _) = contacts.slots_mut();
    let slots = Rows::new(slots);
    collect_ranges(jobs, blocks.len(), 64, begun, |range, begun| {
        for i in range {
            pack::store(&blocks[i], extras.get(i), &slots, begun);
        }
    });
}
