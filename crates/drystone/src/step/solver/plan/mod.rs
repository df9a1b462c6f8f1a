//! Plans the order of the solver's work: groups of islands, and within a group colors in sequence,
//! in blocks of eight.
//!
//! Islands do not act on each other, so they may be solved in any order and in parallel. Small
//! islands are combined into groups that fit a core's cache. One worker takes a group through all
//! its passes (docs/decisions/008-groups-of-islands.md). A large island is a group of its own, and
//! all workers share each of its colors. The result is the same for any grouping. The plan stays
//! valid until a constraint is added or removed.
#![expect(unsafe_code, reason = "promises that rows are kept apart")]

mod articulations;
pub(crate) mod bins;
mod changes;
pub(crate) mod forest;
pub(crate) mod group;
pub(crate) mod joint_class;
pub(crate) mod layout;
pub(crate) mod refine;
pub(crate) mod survey;
pub(crate) mod turning;

use self::bins::Bins;
use self::changes::{take_dirty, take_joint_changes};
use self::forest::Forest;
use self::group::{Group, number};
use self::joint_class::{COUPLED, LINKED, OFTEN, SIX_DOF, TREE, TURNING, class_of};
use self::layout::{CLASS, GROUP, Layout, Sorter, last_row, row_key};
use self::refine::{is_jointed, struck, subdivision_of, take_back, tumbles, was_struck, whirls};
use self::survey::Survey;
use self::turning::Turning;
use crate::base::bit_set::BitSet;
use crate::base::grow;
use crate::base::threads::disjoint::{Apart, Rows};
use crate::base::threads::jobs::{Jobs, for_each, for_items, grain};
use crate::state::articulations::Articulations;
use crate::state::bodies::body::{Body, Subdivision};
use crate::state::bodies::{Bodies, NONE};
use crate::state::colors::Colors;
use crate::state::contacts::Contacts;
use crate::state::islands::Islands;
use crate::state::joints::Joints;
use crate::state::shapes::Shapes;
use crate::step::context::StepContext;
use crate::step::narrowphase;

/// Maximum constraint ends of a group of islands: 1,200 contacts and their bodies, 0.5 MB.
const MAX_ENDS: usize = 2400;

/// Minimum constraint ends for which it pays that workers share a color.
const MIN_SHARED: usize = 1024;

/// Minimum constraint ends for which it pays to give them to another worker.
const MIN_GROUP: usize = 128;

/// An island's share of the solver bodies.
#[derive(Clone, Copy, Debug)]
struct Share {
    island: u32,
    solver_rows: u32,
    /// Constraint ends; a body that only particles act on counts as one end.
    ends: usize,
}

/// Places of bodies and constraints in the solver's rows.
#[derive(Clone, Debug, Default)]
pub(crate) struct Plan {
    /// Body row of solver body k + 1.
    pub(super) members: Vec<u32>,
    /// All workers share each of the first `shared` groups.
    pub(super) groups: Vec<Group>,
    pub(super) shared: usize,
    pub(super) contacts: Layout,
    pub(super) joints: Layout,
    pub(super) six_dof: Layout,
    /// Group and row of each coupling and pulley, sorted.
    pub(super) couplings: Vec<(u64, u32)>,
    /// Group and row of each articulation, sorted.
    pub(crate) articulations: Vec<(u64, u32)>,
    pub(super) forest: Forest,
    pub(super) bins: Bins,
    workers: usize,
    /// Refinement of each island, now and in the last step; missing entries are
    /// [`Subdivision::Whole`].
    subdivision: [Vec<Subdivision>; 2],
    /// [`Islands::dissolved`] in this step, and whether it has changed since the last one.
    dissolved: u64,
    regrouped: bool,
    /// Islands that were hit and continue with undivided substeps.
    whole_again: Vec<u32>,
    /// Index in `islands`, then group, of each island that has solver bodies.
    group_of: Vec<u32>,
    /// Islands that have solver bodies.
    islands: Vec<Share>,
    group_of_row: Vec<u32>,
    /// Class of each joint's row, updated when a joint is added or removed.
    joint_classes: Vec<u8>,
    survey: Survey,
    sorter: Sorter,
    pub(super) turning: Turning,
}

/// Maximum number of parts into which a shared group is sorted: the number that fits in a class
/// beside the number of points.
const MAX_PARTS: usize = 16;

/// Bits for the number of points in the class of a contact.
const COUNT: u32 = 2;

impl Plan {
    /// Discards the plan, so that the next step makes it from scratch.
    pub(super) fn forget(&mut self) {
        self.workers = 0;
        self.subdivision.iter_mut().for_each(Vec::clear);
    }

    /// Chooses the islands that subdivide every substep.
    pub(super) fn choose_subdivision(
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
        self.subdivision.swap(0, 1);
        let chosen = &mut self.subdivision[0];
        chosen.clear();
        let by_load = loaded.substeps > ctx.substeps && ctx.inertia.is_on();
        let by_joints = jointed.substeps > ctx.substeps && !joints.rows.is_empty();
        if !by_load && !by_joints {
            return;
        }
        chosen.resize(islands.rows.len(), Subdivision::Whole);
        if by_load {
            let wants = |body: &Body| ctx.inertia.wants_refining(body);
            self.survey.make(bodies, wants, jobs);
            for body in self.survey.marked(bodies).filter(|body| wants(body)) {
                chosen[body.sleep.island as usize] = Subdivision::Loaded;
            }
        }
        if by_joints {
            for_items(jobs, chosen, grain(jobs, islands.rows.len(), 16), |first, chosen| {
                for (island, chosen) in islands.rows[first..].iter().zip(chosen) {
                    if tumbles(island, bodies, joints, contacts, ctx.dt) {
                        *chosen = Subdivision::Tumbling;
                    } else if whirls(island, bodies, joints, ctx.h) {
                        *chosen = Subdivision::Jointed;
                    }
                }
            });
            for island in struck(closing, bodies, contacts) {
                let (Some(chosen), Some(island)) =
                    (chosen.get_mut(island as usize), islands.rows.get(island as usize))
                else {
                    continue;
                };
                if *chosen != Subdivision::Struck && is_jointed(island, bodies, joints) {
                    *chosen = Subdivision::Struck;
                }
            }
        }
        if chosen.iter().all(|subdivision| *subdivision == Subdivision::Whole) {
            return;
        }
        // Particles run at the world's substeps, so islands that they drag are not subdivided.
        // Links do not need it.
        self.survey.make(bodies, |_| false, jobs);
        let stays = |body: &&Body| body.record.dragged || body.record.is_link;
        for body in self.survey.marked(bodies).filter(stays) {
            chosen[body.sleep.island as usize] = Subdivision::Whole;
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
        self.turning.choose(&self.subdivision[0], bodies, contacts, shapes, found);
    }

    /// Rescales stored impulses of islands that were hit and now continue with undivided substeps.
    /// A subdivided step stores the impulses of its last part times the number of parts. That is
    /// right for a steady load, but too large by that factor for an impact.
    pub(super) fn take_back(
        &mut self,
        bodies: &Bodies,
        joints: &mut Joints,
        contacts: &mut Contacts,
        islands: &Islands,
        struck: &StepContext,
        jobs: &Jobs<'_>,
    ) {
        // A new plan has no record of the last step, but a restored world had one.
        if self.workers > 0 && !self.subdivision[1].contains(&Subdivision::Struck) {
            return;
        }
        self.survey.make(bodies, |_| false, jobs);
        let chosen = &self.subdivision[0];
        let marked = self.survey.marked(bodies);
        let goes_on = |body: &&Body| {
            was_struck(body) && subdivision_of(body.sleep.island, chosen) == Subdivision::Whole
        };
        self.whole_again.clear();
        self.whole_again.extend(marked.filter(goes_on).map(|body| body.sleep.island));
        self.whole_again.sort_unstable();
        self.whole_again.dedup();
        let factor = 1.0 / struck.store_scale();
        // SAFETY: an island belongs to one chunk, and the two bodies of a constraint are in one
        // island.
        let apart = unsafe { Apart::promise() };
        let contacts = contacts.slots_mut(apart);
        let joints = Rows::new(joints.rows.values_mut(), apart);
        for_each(jobs, self.whole_again.len(), |_, k| {
            let island = &islands.rows[self.whole_again[k] as usize];
            take_back(island, bodies, &joints, &contacts, factor);
        });
    }

    /// Updates the plan and `line_of`.
    pub(super) fn update(
        &mut self,
        (bodies, articulations): (&Bodies, &Articulations),
        joints: &mut Joints,
        contacts: &mut Contacts,
        colors: &mut Colors,
        solver_row_of: &mut Vec<u32>,
        ratio: f32,
        parts: [u32; 5],
        jobs: &Jobs<'_>,
    ) {
        let workers = jobs.workers().max(1);
        grow::zeros(solver_row_of, bodies.rows.slot_count());
        let joints_changed = take_joint_changes(colors) || !self.forest.is_by(ratio);
        let changed =
            take_dirty([&mut colors.contacts, &mut colors.contacts_fixed]) || joints_changed;
        // Refinement is stored by island number. If an island split, its bodies may have another
        // number, or the same number may stand for other bodies.
        let is_whole =
            self.subdivision[0].iter().all(|subdivision| *subdivision == Subdivision::Whole);
        let regrouped = self.regrouped && !is_whole;
        let same = self.subdivision[0] == self.subdivision[1] && !regrouped;
        if !changed && same && self.workers == workers && !self.turning.changed {
            if self.regrouped {
                self.bins.place(bodies, joints, &self.members, &mut self.groups);
            }
            return;
        }
        self.workers = workers;
        for row in &self.members {
            solver_row_of[*row as usize] = 0;
        }
        self.survey.make(bodies, |_| false, jobs);
        self.form_groups(parts.map(|parts| parts as usize));
        let moved = self.place_bodies(bodies, solver_row_of);
        if joints_changed {
            self.forest.form(bodies, joints, colors, solver_row_of, ratio);
        }
        self.forest.place(&self.group_of_row, solver_row_of, &mut self.groups);

        self.turning.place(solver_row_of);
        self.place_articulations(articulations, solver_row_of);
        let links = (!articulations.rows.is_empty()).then_some(bodies);
        self.place_contacts(contacts, colors, (solver_row_of, links), jobs);
        // Contacts change in every step, joints do not.
        if joints_changed || moved {
            self.place_joints(joints, colors, solver_row_of, joints_changed, jobs);
        }
        self.forest.locate(&self.six_dof);
        for (number, group) in (0..).zip(&mut self.groups) {
            group.contacts = self.contacts.batches_of(number);
            group.joints = self.joints.batches_of(number);
            group.six_dof = self.six_dof.batches_of(number);
            let first = self.couplings.partition_point(|(of, _)| *of < number);
            group.couplings = first..self.couplings.partition_point(|(of, _)| *of <= number);
            group.articulations = articulations::of_group(&self.articulations, number);
        }
        self.bins.place(bodies, joints, &self.members, &mut self.groups);
    }

    /// Places contacts in blocks, all colors in parallel. `links`: the bodies, if some are links.
    fn place_contacts(
        &mut self,
        contacts: &mut Contacts,
        colors: &mut Colors,
        (solver_row_of, links): (&[u32], Option<&Bodies>),
        jobs: &Jobs<'_>,
    ) {
        let key = row_key(&self.group_of_row);
        let (groups, shared, group_of_row) = (&self.groups, self.shared, &self.group_of_row);
        let parts = self.workers.min(MAX_PARTS);
        let Turning { bodies: turning, often, .. } = &self.turning;
        // In a shared group each worker begins with its own part of the solver bodies: see
        // `row_key`.
        let part_of = |solver_row: usize| {
            // Index 0 is for bodies without a solver body, which a contact may still name.
            groups[..shared].get(group_of_row[solver_row] as usize).map_or(0, |group| {
                solver_row.saturating_sub(group.solver_rows.start) * parts
                    / group.solver_rows.len().max(1)
            })
        };
        // SAFETY: a contact is in one color, which belongs to one chunk.
        let slots = contacts.slots_mut(unsafe { Apart::promise() });
        let key_of = |row: u32| {
            let c = slots.read(row as usize).as_ref()?;
            let count = match c.count {
                0 => 3,
                1 => 2,
                2 => 1,
                _ => 0,
            };
            let solver_row = last_row(solver_row_of, c.body_a, c.body_b);
            let is_of = |bodies: &BitSet| bodies.contains(c.body_a) || bodies.contains(c.body_b);
            let mut class = (part_of(solver_row) as u64) << COUNT | count;
            let is_link = |bodies: &Bodies, row: u32| bodies.at(row).record.is_link;
            if let Some(bodies) = links
                && (is_link(bodies, c.body_a) || is_link(bodies, c.body_b))
            {
                class |= u64::from(LINKED);
            } else if is_of(turning) {
                class |= u64::from(if is_of(often) { TURNING | OFTEN } else { TURNING });
            }
            Some(key(class, solver_row))
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
        // The two bits for rebuilt contacts keep these in separate blocks.
        self.sorter.sort(GROUP - 2, colorings, ask, key_of, set_place, runs, jobs);
        self.contacts.lay_out([&colors.contacts, &colors.contacts_fixed]);
    }

    /// Places joints in blocks. `anew`: their classes must be computed first.
    fn place_joints(
        &mut self,
        joints: &mut Joints,
        colors: &mut Colors,
        solver_row_of: &[u32],
        anew: bool,
        jobs: &Jobs<'_>,
    ) {
        grow::resize(&mut self.joint_classes, joints.rows.slot_count(), 0);
        // SAFETY: a joint is in one color, which belongs to one chunk.
        let apart = unsafe { Apart::promise() };
        let classes = Rows::new(&mut self.joint_classes, apart);
        let slots = Rows::new(joints.rows.values_mut(), apart);
        let key = row_key(&self.group_of_row);
        let key_of = |row: u32| {
            let j = slots.read(row as usize).as_ref()?;
            let class = classes.row(row as usize);
            if anew {
                *class = class_of(j);
            }
            Some(key(u64::from(*class), last_row(solver_row_of, j.body_a, j.body_b)))
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
        self.six_dof.runs.clear();
        self.six_dof.runs.extend(self.joints.runs.iter().filter(|run| run.class & SIX_DOF != 0));
        self.joints.runs.retain(|run| run.class < TREE);
        self.joints.lay_out(colorings);
        self.six_dof.lay_out(colorings);
    }

    /// The group of a solver body.
    pub(super) fn group_of(&self, solver_row: u32) -> usize {
        self.group_of_row[solver_row as usize] as usize
    }

    /// Assigns islands to groups. `parts`: parts of a substep for each [`Subdivision`].
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
                self.islands.push(Share { island: *island, solver_rows: 0, ends: 0 });
            }
            // A body that only particles act on takes a place too.
            let ends = (*ends).max(1) as usize;
            let share = &mut self.islands[self.group_of[at] as usize];
            (share.solver_rows, share.ends) = (share.solver_rows + 1, share.ends + ends);
            total += ends;
        }
        let workers = self.workers;
        let is_shared = |ends: usize| {
            ends > 2 * MAX_ENDS || (workers > 1 && ends > MIN_SHARED && 2 * workers * ends > total)
        };
        let work_of = |share: &Share| {
            share.ends * parts[subdivision_of(share.island, &self.subdivision[0]) as usize]
        };
        let alone = self.islands.iter().filter(|share| !is_shared(share.ends));
        let all: usize = alone.map(work_of).sum();
        // Divide the remaining work evenly among the workers. Groups are large at first, because
        // the last block of a color in each group is not full. Later groups are smaller, so that
        // all workers finish at about the same time (guided self-scheduling: Polychronopoulos and
        // Kuck 1987).
        let max_of = |left: usize| match workers {
            1 => (all / 4).max(MIN_SHARED / 2),
            _ => (left / workers).max(all / (8 * workers)).max(MIN_GROUP),
        };
        self.shared = 0;
        for share in &self.islands {
            if is_shared(share.ends) {
                self.group_of[share.island as usize] = number(self.shared);
                self.shared += 1;
            }
        }
        // The most expensive islands come first; otherwise one worker still has them when the
        // others finish.
        let (mut group, mut filled, mut begun) = (self.shared, 0, 0);
        let (mut left, mut maximum) = (all, max_of(all));
        for of in Subdivision::ALL.into_iter().rev() {
            for share in &self.islands {
                let ends = share.ends;
                if is_shared(ends) || subdivision_of(share.island, &self.subdivision[0]) != of {
                    continue;
                }
                let work = work_of(share);
                if filled > 0 && (filled + ends > MAX_ENDS || begun + work > maximum) {
                    (group, filled, begun) = (group + 1, 0, 0);
                    maximum = max_of(left);
                }
                self.group_of[share.island as usize] = number(group);
                (filled, begun, left) = (filled + ends, begun + work, left - work);
            }
            (group, filled, begun) = (group + usize::from(filled > 0), 0, 0);
            maximum = max_of(left);
        }
        self.groups.clear();
        self.groups.resize_with(group, Group::default);
        for share in &self.islands {
            let group = &mut self.groups[self.group_of[share.island as usize] as usize];
            group.subdivision = subdivision_of(share.island, &self.subdivision[0]);
            group.solver_rows.end += share.solver_rows as usize;
        }
        let mut solver_row = 1;
        for group in &mut self.groups {
            let n = group.solver_rows.end;
            group.solver_rows = solver_row..solver_row;
            solver_row += n;
        }
    }

    /// Assigns solver bodies, group by group, and within a group in the order of awake bodies. True
    /// if some body's index changed.
    fn place_bodies(&mut self, bodies: &Bodies, solver_row_of: &mut [u32]) -> bool {
        let n = self.islands.iter().map(|share| share.solver_rows as usize).sum();
        let mut moved = self.members.len() != n;
        self.members.resize(n, NONE);
        self.group_of_row.resize(n + 1, 0);
        let lined =
            bodies.awake.iter().zip(&self.survey.islands).filter(|(_, island)| **island != NONE);
        for (row, island) in lined {
            let group = self.group_of[*island as usize];
            let end = &mut self.groups[group as usize].solver_rows.end;
            let (member, of) = (&mut self.members[*end - 1], &mut self.group_of_row[*end]);
            moved |= (*member, *of) != (*row, group);
            (*member, *of) = (*row, group);
            solver_row_of[*row as usize] = number(*end);
            *end += 1;
        }
        moved
    }
}
