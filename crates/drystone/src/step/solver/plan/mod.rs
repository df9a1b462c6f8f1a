//! The order of the solver's work: groups of islands, and within a group color after color, in blocks.
//!
//! Islands do not act on each other, so they may be solved in any order and side by side: small ones are
//! put together into groups that fit a core's cache, and one worker takes a group through all its
//! passes (docs/decisions/008-groups-of-islands.md). A large island is a group of its own, and all
//! workers share each of its colors. The result is the same for any grouping. The plan is kept until
//! a constraint comes or goes.
#![expect(unsafe_code, reason = "promises that rows are kept apart")]

pub(crate) mod bins;
pub(crate) mod forest;
pub(crate) mod group;
pub(crate) mod joint_class;
pub(crate) mod layout;
pub(crate) mod refine;
pub(crate) mod survey;
pub(crate) mod turning;

use self::bins::Bins;
use self::forest::Forest;
use self::group::{Group, number};
use self::joint_class::{COUPLED, OFTEN, SIX, TREE, TURNING, class_of};
use self::layout::{CLASS, GROUP, Layout, Sorter, last_line, line_key};
use self::refine::{fineness_of, is_jointed, struck, take_back, tumbles, was_struck, whirls};
use self::survey::Survey;
use self::turning::Turning;
use crate::base::bit_set::BitSet;
use crate::base::grow;
use crate::base::threads::disjoint::{Apart, Rows};
use crate::base::threads::jobs::{Jobs, for_each, for_items, grain};
use crate::state::bodies::{Bodies, Body, Fineness, NONE};
use crate::state::colors::{Coloring, Colors};
use crate::state::contacts::Contacts;
use crate::state::islands::Islands;
use crate::state::joints::Joints;
use crate::state::shapes::Shapes;
use crate::step::context::StepContext;
use crate::step::narrowphase;

/// Most constraint ends of a group of islands: 1,200 contacts and their bodies, 0.5 MB.
const MOST_ENDS: usize = 2400;

/// Fewest constraint ends for which it pays that workers share a color.
const LEAST_SHARED: usize = 1024;

/// Fewest constraint ends for which it pays that another worker takes them.
const LEAST_GROUP: usize = 128;

/// What of the lines is an island's.
#[derive(Clone, Copy, Debug)]
struct Share {
    island: u32,
    lines: u32,
    /// Ends of constraints; what only particles act on counts as well.
    ends: usize,
}

/// Which bodies and constraints stand where.
#[derive(Clone, Debug, Default)]
pub(crate) struct Plan {
    /// Body row of line k + 1.
    pub(super) members: Vec<u32>,
    /// The first `shared` ones are shared by all workers.
    pub(super) groups: Vec<Group>,
    pub(super) shared: usize,
    pub(super) contacts: Layout,
    pub(super) joints: Layout,
    pub(super) sixdofs: Layout,
    /// Group and row of each coupling and pulley, in this order.
    pub(super) couplings: Vec<(u64, u32)>,
    pub(super) forest: Forest,
    pub(super) bins: Bins,
    workers: usize,
    /// Of each island, now and in the last step; what is not there is [`Fineness::Whole`].
    fineness: [Vec<Fineness>; 2],
    /// [`Islands::dissolved`] in this step, and whether it is another number than in the last one.
    dissolved: u64,
    regrouped: bool,
    /// Islands that were hit and go on in whole substeps.
    whole_again: Vec<u32>,
    /// Number in `islands`, then group, of each island that has lines.
    group_of: Vec<u32>,
    /// Islands that have lines.
    islands: Vec<Share>,
    group_of_line: Vec<u32>,
    /// Of each joint's row, from when one came or went.
    joint_classes: Vec<u8>,
    survey: Survey,
    sorter: Sorter,
    pub(super) turning: Turning,
}

/// Most parts of a shared group that are kept apart: what fits into a class beside the number of points.
const MOST_PARTS: usize = 16;

/// Bits of the number of points in the class of a contact.
const COUNT: u32 = 2;

impl Plan {
    /// Is to be made anew, as if there had been none.
    pub(super) fn forget(&mut self) {
        self.workers = 0;
        self.fineness.iter_mut().for_each(Vec::clear);
    }

    /// Chooses the islands that take every substep in parts.
    pub(super) fn choose_fineness(
        &mut self,
        bodies: &Bodies,
        joints: &Joints,
        contacts: &Contacts,
        islands: &Islands,
        closing: impl Iterator<Item = u32>,
        [ctx, loaded, jointed, ..]: [&StepContext; 5],
        jobs: &Jobs<'_>,
    ) {
        self.survey.begin();
        self.regrouped = self.dissolved != islands.dissolved;
        self.dissolved = islands.dissolved;
        self.fineness.swap(0, 1);
        let chosen = &mut self.fineness[0];
        chosen.clear();
        let by_load = loaded.substeps > ctx.substeps && ctx.inertia.is_on();
        let by_joints = jointed.substeps > ctx.substeps && !joints.rows.is_empty();
        if !by_load && !by_joints {
            return;
        }
        chosen.resize(islands.rows.len(), Fineness::Whole);
        if by_load {
            let wants = |body: &Body| ctx.inertia.wants_refining(body);
            self.survey.make(bodies, wants, jobs);
            for body in self.survey.marked(bodies).filter(|body| wants(body)) {
                chosen[body.island as usize] = Fineness::Loaded;
            }
        }
        if by_joints {
            for_items(jobs, chosen, grain(jobs, islands.rows.len(), 16), |first, chosen| {
                for (island, chosen) in islands.rows[first..].iter().zip(chosen) {
                    if tumbles(island, bodies, joints, contacts, ctx.dt) {
                        *chosen = Fineness::Tumbling;
                    } else if whirls(island, bodies, joints, ctx.h) {
                        *chosen = Fineness::Jointed;
                    }
                }
            });
            for island in struck(closing, bodies, contacts) {
                let (Some(chosen), Some(island)) =
                    (chosen.get_mut(island as usize), islands.rows.get(island as usize))
                else {
                    continue;
                };
                if *chosen != Fineness::Struck && is_jointed(island, bodies, joints) {
                    *chosen = Fineness::Struck;
                }
            }
        }
        if chosen.iter().all(|fineness| *fineness == Fineness::Whole) {
            return;
        }
        // Particles keep pace with the world's substeps.
        self.survey.make(bodies, |_| false, jobs);
        for body in self.survey.marked(bodies).filter(|body| body.dragged) {
            chosen[body.island as usize] = Fineness::Whole;
        }
    }

    /// See [`Turning::choose`].
    pub(super) fn choose_turning(
        &mut self,
        bodies: &Bodies,
        contacts: &Contacts,
        shapes: &Shapes,
        found: (&narrowphase::scratch::Scratch, f32),
    ) {
        self.turning.choose(&self.fineness[0], bodies, contacts, shapes, found);
    }

    /// What is kept of a step in parts are the impulses of its last part times the parts: right for a load, and that many times
    /// too much of a blow that came in it. Where an island that was hit goes on in whole substeps they are taken back.
    pub(super) fn take_back(
        &mut self,
        bodies: &Bodies,
        joints: &mut Joints,
        contacts: &mut Contacts,
        islands: &Islands,
        struck: &StepContext,
        jobs: &Jobs<'_>,
    ) {
        // A plan that was never made knows nothing of the last step, which a restored world has had.
        if self.workers > 0 && !self.fineness[1].contains(&Fineness::Struck) {
            return;
        }
        self.survey.make(bodies, |_| false, jobs);
        let chosen = &self.fineness[0];
        let marked = self.survey.marked(bodies);
        let goes_on =
            |body: &&Body| was_struck(body) && fineness_of(body.island, chosen) == Fineness::Whole;
        self.whole_again.clear();
        self.whole_again.extend(marked.filter(goes_on).map(|body| body.island));
        self.whole_again.sort_unstable();
        self.whole_again.dedup();
        let factor = 1.0 / struck.store_scale();
        // SAFETY: an island is of one chunk, and two bodies on which one constraint acts are in one island.
        let apart = unsafe { Apart::promise() };
        let contacts = contacts.slots_mut(apart);
        let joints = Rows::new(joints.rows.values_mut(), apart);
        for_each(jobs, self.whole_again.len(), |_, k| {
            let island = &islands.rows[self.whole_again[k] as usize];
            take_back(island, bodies, &joints, &contacts, factor);
        });
    }

    /// Brings the plan up to date, and `line_of` with it.
    pub(super) fn update(
        &mut self,
        bodies: &Bodies,
        joints: &mut Joints,
        contacts: &mut Contacts,
        colors: &mut Colors,
        line_of: &mut Vec<u32>,
        ratio: f32,
        parts: [u32; 5],
        jobs: &Jobs<'_>,
    ) {
        let workers = jobs.workers().max(1);
        grow::zeros(line_of, bodies.rows.slot_count());
        let joints_changed = take_joint_changes(colors) || !self.forest.is_by(ratio);
        let changed = take_contact_changes(colors) || joints_changed;
        // Fineness is that of an island by its number: where one fell apart, its bodies have another number, or the same
        // one stands for others.
        let is_whole = self.fineness[0].iter().all(|fineness| *fineness == Fineness::Whole);
        let regrouped = self.regrouped && !is_whole;
        let same = self.fineness[0] == self.fineness[1] && !regrouped;
        if !changed && same && self.workers == workers && !self.turning.changed {
            if self.regrouped {
                self.bins.place(bodies, joints, &self.members, &mut self.groups);
            }
            return;
        }
        self.workers = workers;
        for row in &self.members {
            line_of[*row as usize] = 0;
        }
        self.survey.make(bodies, |_| false, jobs);
        self.form_groups(parts.map(|parts| parts as usize));
        let moved = self.place_bodies(bodies, line_of);
        if joints_changed {
            self.forest.form(bodies, joints, colors, line_of, ratio);
        }
        self.forest.place(&self.group_of_line, line_of, &mut self.groups);

        self.turning.place(line_of);
        self.place_contacts(contacts, colors, line_of, jobs);
        // Contacts come and go in every step, joints do not.
        if joints_changed || moved {
            self.place_joints(joints, colors, line_of, joints_changed, jobs);
        }
        self.forest.locate(&self.sixdofs);
        for (number, group) in (0..).zip(&mut self.groups) {
            group.contacts = self.contacts.batches_of(number);
            group.joints = self.joints.batches_of(number);
            group.sixdofs = self.sixdofs.batches_of(number);
            let first = self.couplings.partition_point(|(of, _)| *of < number);
            group.couplings = first..self.couplings.partition_point(|(of, _)| *of <= number);
        }
        self.bins.place(bodies, joints, &self.members, &mut self.groups);
    }

    /// Contacts to blocks, all colors side by side.
    fn place_contacts(
        &mut self,
        contacts: &mut Contacts,
        colors: &mut Colors,
        line_of: &[u32],
        jobs: &Jobs<'_>,
    ) {
        let key = line_key(&self.group_of_line);
        let (groups, shared, group_of_line) = (&self.groups, self.shared, &self.group_of_line);
        let parts = self.workers.min(MOST_PARTS);
        let Turning { bodies: turning, often, .. } = &self.turning;
        // Of a shared group each worker begins with its own part of the lines: see `line_key`.
        let part_of = |line: usize| {
            // Line 0 is of bodies that take no part: they may still be named by a contact.
            groups[..shared].get(group_of_line[line] as usize).map_or(0, |group| {
                line.saturating_sub(group.lines.start) * parts / group.lines.len().max(1)
            })
        };
        // SAFETY: a contact is in one color, which is of one chunk.
        let slots = contacts.slots_mut(unsafe { Apart::promise() });
        let key_of = |row: u32| {
            let c = slots.read(row as usize).as_ref()?;
            let count = match c.count {
                0 => 3,
                1 => 2,
                2 => 1,
                _ => 0,
            };
            let line = last_line(line_of, c.body_a, c.body_b);
            let is_of = |bodies: &BitSet| bodies.contains(c.body_a) || bodies.contains(c.body_b);
            let mut class = (part_of(line) as u64) << COUNT | count;
            if is_of(turning) {
                class |= u64::from(if is_of(often) { TURNING | OFTEN } else { TURNING });
            }
            Some(key(class, line))
        };
        let set_place = |row: u32, place| {
            if let Some(c) = slots.row(row as usize)
                && c.place != place
            {
                c.place = place;
            }
        };
        let colorings = [&mut colors.contacts, &mut colors.contacts_fixed];
        let ask = |row: u32| slots.prefetch(row as usize, 1);
        let runs = &mut self.contacts.runs;
        // The two bits of what is made anew keep blocks apart.
        self.sorter.sort(GROUP - 2, colorings, ask, key_of, set_place, runs, jobs);
        self.contacts.lay_out([&colors.contacts, &colors.contacts_fixed]);
    }

    /// Joints to blocks. `anew`: what kinds they are is not known from the last time.
    fn place_joints(
        &mut self,
        joints: &mut Joints,
        colors: &mut Colors,
        line_of: &[u32],
        anew: bool,
        jobs: &Jobs<'_>,
    ) {
        grow::resize(&mut self.joint_classes, joints.rows.slot_count(), 0);
        // SAFETY: a joint is in one color, which is of one chunk.
        let apart = unsafe { Apart::promise() };
        let classes = Rows::new(&mut self.joint_classes, apart);
        let slots = Rows::new(joints.rows.values_mut(), apart);
        let key = line_key(&self.group_of_line);
        let key_of = |row: u32| {
            let j = slots.read(row as usize).as_ref()?;
            let class = classes.row(row as usize);
            if anew {
                *class = class_of(j);
            }
            Some(key(u64::from(*class), last_line(line_of, j.body_a, j.body_b)))
        };
        let set_place = |row: u32, place| {
            if let Some(j) = slots.row(row as usize) {
                j.place = place;
            }
        };
        let colorings = [&mut colors.joints, &mut colors.joints_fixed];
        let ask = |row: u32| slots.prefetch(row as usize, 2);
        let runs = &mut self.joints.runs;
        self.sorter.sort(CLASS, colorings, ask, key_of, set_place, runs, jobs);
        let colorings = [&colors.joints, &colors.joints_fixed];
        self.couplings.clear();
        for run in self.joints.runs.iter().filter(|run| run.class == COUPLED) {
            self.couplings.extend(run.members(colorings).iter().map(|row| (run.group, *row)));
        }
        self.couplings.sort_unstable();
        self.sixdofs.runs.clear();
        self.sixdofs.runs.extend(self.joints.runs.iter().filter(|run| run.class & SIX != 0));
        self.joints.runs.retain(|run| run.class < TREE);
        self.joints.lay_out(colorings);
        self.sixdofs.lay_out(colorings);
    }

    /// The group of a line.
    pub(super) fn group_of(&self, line: u32) -> usize {
        self.group_of_line[line as usize] as usize
    }

    /// Islands to groups. `parts`: in which each [`Fineness`] takes a substep.
    fn form_groups(&mut self, parts: [usize; 5]) {
        for share in self.islands.drain(..) {
            self.group_of[share.island as usize] = NONE;
        }
        let mut total = 0;
        let all = self.survey.islands.iter().zip(&self.survey.ends);
        for (island, ends) in all.filter(|(island, _)| **island != NONE) {
            let at = *island as usize;
            if self.group_of.len() <= at {
                self.group_of.resize(at + 1, NONE);
            }
            if self.group_of[at] == NONE {
                self.group_of[at] = number(self.islands.len());
                self.islands.push(Share { island: *island, lines: 0, ends: 0 });
            }
            // What only particles act on takes a place too.
            let ends = (*ends).max(1) as usize;
            let share = &mut self.islands[self.group_of[at] as usize];
            (share.lines, share.ends) = (share.lines + 1, share.ends + ends);
            total += ends;
        }
        let workers = self.workers;
        let is_shared = |ends: usize| {
            ends > 2 * MOST_ENDS
                || (workers > 1 && ends > LEAST_SHARED && 2 * workers * ends > total)
        };
        let work_of = |share: &Share| {
            share.ends * parts[fineness_of(share.island, &self.fineness[0]) as usize]
        };
        let alone = self.islands.iter().filter(|share| !is_shared(share.ends));
        let all: usize = alone.map(work_of).sum();
        // Of what is left each worker gets one part: few groups at first, for in each the last block of a color is not full,
        // then smaller ones, so that all workers are done at about the same time (guided self-scheduling: Polychronopoulos
        // and Kuck 1987).
        let most_of = |left: usize| match workers {
            1 => (all / 4).max(LEAST_SHARED / 2),
            _ => (left / workers).max(all / (8 * workers)).max(LEAST_GROUP),
        };
        self.shared = 0;
        for share in &self.islands {
            if is_shared(share.ends) {
                self.group_of[share.island as usize] = number(self.shared);
                self.shared += 1;
            }
        }
        // What takes longest first: else one worker has it when the others are done.
        let (mut group, mut filled, mut begun) = (self.shared, 0, 0);
        let (mut left, mut most) = (all, most_of(all));
        for of in Fineness::ALL.into_iter().rev() {
            for share in &self.islands {
                let ends = share.ends;
                if is_shared(ends) || fineness_of(share.island, &self.fineness[0]) != of {
                    continue;
                }
                let work = work_of(share);
                if filled > 0 && (filled + ends > MOST_ENDS || begun + work > most) {
                    (group, filled, begun) = (group + 1, 0, 0);
                    most = most_of(left);
                }
                self.group_of[share.island as usize] = number(group);
                (filled, begun, left) = (filled + ends, begun + work, left - work);
            }
            (group, filled, begun) = (group + usize::from(filled > 0), 0, 0);
            most = most_of(left);
        }
        self.groups.clear();
        self.groups.resize_with(group, Group::default);
        for share in &self.islands {
            let group = &mut self.groups[self.group_of[share.island as usize] as usize];
            group.fineness = fineness_of(share.island, &self.fineness[0]);
            group.lines.end += share.lines as usize;
        }
        let mut line = 1;
        for group in &mut self.groups {
            let n = group.lines.end;
            group.lines = line..line;
            line += n;
        }
    }

    /// Bodies to lines, group by group; within a group in the order of the awake bodies. True if one has another
    /// line than before.
    fn place_bodies(&mut self, bodies: &Bodies, line_of: &mut [u32]) -> bool {
        let n = self.islands.iter().map(|share| share.lines as usize).sum();
        let mut moved = self.members.len() != n;
        self.members.resize(n, NONE);
        self.group_of_line.resize(n + 1, 0);
        let lined =
            bodies.awake.iter().zip(&self.survey.islands).filter(|(_, island)| **island != NONE);
        for (row, island) in lined {
            let group = self.group_of[*island as usize];
            let end = &mut self.groups[group as usize].lines.end;
            let (member, of) = (&mut self.members[*end - 1], &mut self.group_of_line[*end]);
            moved |= (*member, *of) != (*row, group);
            (*member, *of) = (*row, group);
            line_of[*row as usize] = number(*end);
            *end += 1;
        }
        moved
    }
}

/// True if a joint came or went since the last call, or a body that some constraint acts on fell asleep,
/// woke or was put aside.
fn take_joint_changes(colors: &mut Colors) -> bool {
    let changed = core::mem::take(&mut colors.bodies_changed);
    take_dirty([&mut colors.joints, &mut colors.joints_fixed]) || changed
}

/// True if a contact came, went or changed its number of points since the last call.
fn take_contact_changes(colors: &mut Colors) -> bool {
    take_dirty([&mut colors.contacts, &mut colors.contacts_fixed])
}

fn take_dirty(all: [&mut Coloring; 2]) -> bool {
    let mut changed = false;
    for color in all.into_iter().flat_map(|coloring| &mut coloring.colors) {
        changed |= core::mem::take(&mut color.dirty);
    }
    changed
}
