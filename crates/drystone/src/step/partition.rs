//! The stage `partition`: applies the narrowphase's changes to colors and islands, wakes sleeping
//! bodies that were met, and records ends of touches for `report`.
//!
//! Reads: bodies. Writes: colors, islands, sets, contacts (rows), events, bodies (levels). Runs:
//! wakes serially; then over lists of changes in parallel, then over tables in parallel, each in
//! the order of the changes; levels in parallel, color after color.
#![expect(unsafe_code, reason = "promises that rows are kept apart")]

use core::sync::atomic::{AtomicBool, Ordering};

use super::narrowphase;
use super::narrowphase::change::Change;
use super::touches::{Touches, contact_event, events_between, reports_touch};
use crate::base::grow::Slack;
use crate::base::sparse::Sparse;
use crate::base::threads::disjoint::{Apart, Rows};
use crate::base::threads::jobs::{Jobs, for_ranges, for_runs, grain};
use crate::state::bodies::body::Body;
use crate::state::bodies::{Bodies, NONE};
use crate::state::contacts::leave::Leaver;
use crate::state::contacts::{Contact, Slots};
use crate::state::events::SensorEvent;
use crate::state::islands::Islands;
use crate::state::sets::Sets;
use crate::state::sets::changes::{Move, SetChanges};
use crate::state::shapes::Shapes;

/// Prefetch distance for contacts, in changes.
const PREFETCH: usize = 6;

/// Fewer changes than this run on one thread.
const MIN: usize = 128;

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    /// New levels, while they are computed.
    levels: Sparse,
    /// Effects of each list of changes, then of each list of ghosts of seams.
    effects: [Vec<Effects>; 2],
    gone: Vec<Leaver>,
    slack: Slack,
}

/// Applies the narrowphase's changes. Bodies that are met wake; all workers compute the effects of
/// the changes; then the effects are applied. `step`: the number of steps before this one.
pub(crate) fn apply_changes(
    step: u64,
    found: &narrowphase::scratch::Scratch,
    shapes: &Shapes,
    sets: &mut Sets<'_>,
    scratch: &mut Scratch,
    jobs: &Jobs<'_>,
) {
    change_sets(found, shapes, sets, scratch, jobs);
    relax_levels(step, sets, scratch, jobs);
}

fn change_sets(
    found: &narrowphase::scratch::Scratch,
    shapes: &Shapes,
    sets: &mut Sets<'_>,
    scratch: &mut Scratch,
    jobs: &Jobs<'_>,
) {
    let [changes, ghosts] = found.changes();
    wake_the_met(changes, sets);
    sets.contacts.end_asking(sets.bodies);
    let Scratch { effects, gone, slack, .. } = scratch;
    let mut maximum = 0;
    for (lists, effects) in [changes, ghosts].into_iter().zip(&mut *effects) {
        effects.iter_mut().for_each(Effects::clear);
        let n: usize = lists.iter().map(Vec::len).sum();
        if n > 0 {
            let jobs = if n < MIN { &Jobs::Inline } else { jobs };
            maximum = maximum.max(apply(lists, shapes, sets, effects, gone, jobs));
        }
    }
    if let Some(enough) = slack.look(maximum) {
        for effects in effects {
            let each = enough / effects.len().max(1);
            effects.iter_mut().for_each(|effects| effects.shrink_to(each));
        }
        gone.shrink_to(enough);
    }
}

impl Scratch {
    /// Touches that the last step ended, in the order of the changes.
    pub(crate) fn touches(&self) -> impl Iterator<Item = &Touches> {
        self.effects.iter().flatten().map(|effects| &effects.touches)
    }
}

/// Wakes bodies that awake bodies met. Where bodies freeze individually, wakes bodies whose
/// supporting contact has ended.
fn wake_the_met(changes: &[Vec<Change>], sets: &mut Sets<'_>) {
    for change in changes.iter().flatten() {
        match *change {
            Change::Meets(row) => {
                let c = sets.contacts.at(row);
                let (count, [a, b]) = (c.count, [c.body_a, c.body_b]);
                if count > 0 && !is_gentle(c, sets.islands, sets.bodies) {
                    sets.wake(a);
                    sets.wake(b);
                }
            }
            Change::Apart(row) if sets.islands.wake_alone => wake_held(row, sets),
            _ => {}
        }
    }
}

/// True for a touch that wakes nothing: the bodies are slow and only near. Where bodies freeze
/// individually, any slow touch is gentle, since its load may wake the body later.
fn is_gentle(c: &Contact, islands: &Islands, bodies: &Bodies) -> bool {
    let [a, b] = [c.body_a, c.body_b].map(|body| bodies.at(body));
    // Points appear and vanish at the speculative distance. An awake slow body is still waiting to
    // sleep.
    let waits = |body: &Body| !body.is_dynamic() || body.active() && body.sleep.still_time > 0.0;
    if waits(a) && waits(b) && c.points().iter().all(|p| p.separation > 0.0) {
        return true;
    }
    let speed = a.greatest_speed(islands.length) + b.greatest_speed(islands.length);
    // Overlap with a body that was placed in a frozen one did not result from motion.
    let any_moves = a.active() || b.active();
    islands.wake_alone && any_moves && speed < islands.gentle_speed
}

/// Applies some lists of changes; returns the number of entries that needed memory.
fn apply(
    lists: &[Vec<Change>],
    shapes: &Shapes,
    sets: &mut Sets<'_>,
    effects: &mut Vec<Effects>,
    gone: &mut Vec<Leaver>,
    jobs: &Jobs<'_>,
) -> usize {
    effects.resize_with(effects.len().max(lists.len()), Effects::default);
    // SAFETY: a contact changes at most once in a step, and is in one list.
    let slots = sets.contacts.slots_mut(unsafe { Apart::promise() });
    let reader = ChangeReader { shapes, bodies: sets.bodies, islands: sets.islands, slots };
    let effects = &mut effects[..lists.len()];
    for_runs(jobs, effects, 1, |list, effects| {
        reader.look_at(&lists[list], &mut effects[0]);
    });
    let effects = &*effects;
    sets.carry_out(effects.iter().map(|effects| &effects.changes), gone, jobs);
    gone.len().max(effects.iter().map(|effects| effects.changes.len()).sum())
}

/// Effects of a list of changes.
#[derive(Clone, Debug, Default)]
struct Effects {
    changes: SetChanges,
    touches: Touches,
}

impl Effects {
    fn clear(&mut self) {
        self.changes.clear();
        self.touches.clear();
    }

    fn shrink_to(&mut self, enough: usize) {
        self.changes.shrink_to(enough);
        self.touches.shrink_to(enough);
    }
}

/// Computes the effects of changes. It writes only the `touching` flag of contacts: all contacts of
/// a pair are in one list.
struct ChangeReader<'a> {
    shapes: &'a Shapes,
    bodies: &'a Bodies,
    islands: &'a Islands,
    slots: Slots<'a>,
}

impl ChangeReader<'_> {
    fn look_at(&self, changes: &[Change], effects: &mut Effects) {
        for (i, change) in changes.iter().enumerate() {
            if let Some(Change::Apart(row) | Change::Count(row)) = changes.get(i + 2 * PREFETCH) {
                self.slots.prefetch_line(*row as usize, Contact::LISTS_LINE);
            }
            if let Some(Change::Apart(row) | Change::Count(row)) = changes.get(i + PREFETCH) {
                let c = self.at(*row);
                self.bodies.rows.prefetch(c.body_a, 1);
                self.bodies.rows.prefetch(c.body_b, 1);
            }
            match *change {
                Change::Apart(row) => self.end(row, effects),
                Change::Count(row) => self.recount(row, effects),
                Change::Meets(_)
                | Change::Made(_)
                | Change::Carries(_)
                | Change::Closes(_)
                | Change::Turns(_)
                | Change::Corotates(_)
                | Change::Impacts(_)
                | Change::Parts(_) => {}
            }
        }
    }

    /// The contact of a row in use.
    fn at(&self, row: u32) -> &Contact {
        self.slots.read(row as usize).as_ref().expect("changes name living contacts only")
    }

    /// Rows of a pair's manifolds.
    fn parts(&self, first: u32) -> impl Iterator<Item = u32> {
        let next = |row: &u32| Some(self.at(*row).next_part).filter(|next| *next != NONE);
        core::iter::successors(Some(first), next)
    }

    /// Ends a contact with all its manifolds.
    fn end(&self, first: u32, effects: &mut Effects) {
        self.report_end(first, effects);
        for row in self.parts(first) {
            effects.changes.remove(row, self.at(row), self.bodies);
        }
    }

    /// Reports the end of a pair's touch, if it touched.
    fn report_end(&self, first: u32, effects: &mut Effects) {
        let c = self.at(first);
        if !c.touching {
            return;
        }
        if c.sensor {
            effects.touches.sensed.extend(self.sensor_events(c).map(|e| (e, false)));
        } else if reports_touch(c, self.shapes) {
            effects.touches.ends.push(contact_event(c, self.shapes, self.bodies));
        }
        self.parts(first).for_each(|row| self.set_touching(row, false));
    }

    fn sensor_events(&self, c: &Contact) -> impl Iterator<Item = SensorEvent> + use<> {
        events_between([c.shape_a, c.shape_b], self.shapes, self.bodies)
    }

    fn set_touching(&self, row: u32, touching: bool) {
        if let Some(contact) = self.slots.row(row as usize) {
            contact.touching = touching;
        }
    }

    fn recount(&self, row: u32, effects: &mut Effects) {
        let c = self.at(row);
        let has_points = c.count > 0;
        if c.sensor {
            // A mesh has several manifolds: the pair overlaps while one of them has points.
            let first = c.first(row);
            let overlaps = self.parts(first).any(|part| self.at(part).count > 0);
            if self.at(first).touching != overlaps {
                effects.touches.sensed.extend(self.sensor_events(c).map(|e| (e, overlaps)));
                self.parts(first).for_each(|part| self.set_touching(part, overlaps));
            }
            return;
        }
        let solves = self.islands.solves(self.bodies.at(c.body_a), self.bodies.at(c.body_b));
        let what = match (has_points, c.place.is_somewhere()) {
            (true, true) => Move::Changes,
            // It is near a sleeping body, and does not touch it.
            (true, false) if !solves => return,
            (true, false) if is_gentle(c, self.islands, self.bodies) => Move::Enters,
            (true, false) => Move::Rouses,
            (false, true) => Move::Leaves,
            // It had points for a moment only, as a ghost.
            (false, false) if !c.touching => return,
            (false, false) => Move::Stays,
        };
        effects.changes.add(row, c, what, !has_points, self.bodies);
        let first = c.first(row);
        if !has_points && self.parts(first).all(|part| self.at(part).count == 0) {
            self.report_end(first, effects);
        }
    }
}

/// Levels are for display, so they may lag: a relaxation reads every contact.
const RELAX_EVERY: u64 = 4;

/// One Jacobi relaxation of the levels of the contact graph, level = 1 + the minimum level of a
/// touching neighbor. It converges in as many calls as the graph is deep, and costs nothing while
/// nothing changes. Values written for bodies that are not awake are never read.
fn relax_levels(step: u64, sets: &mut Sets<'_>, scratch: &mut Scratch, jobs: &Jobs<'_>) {
    let Sets { bodies, contacts, colors, .. } = sets;
    scratch.levels.cover(bodies.rows.slot_count());
    if !step.is_multiple_of(RELAX_EVERY) || !core::mem::take(&mut colors.levels_dirty) {
        return;
    }
    // SAFETY: no two contacts of a color share a dynamic body, and awake bodies are all different.
    let apart = unsafe { Apart::promise() };
    let next = scratch.levels.lend(apart);
    let n = bodies.awake.len();
    for_ranges(jobs, n, grain(jobs, n, 1024), |range| {
        bodies.awake[range].iter().for_each(|row| next.set(*row, NONE));
    });
    for coloring in [&colors.contacts, &colors.contacts_fixed] {
        for color in &coloring.colors {
            let members = &color.members;
            for_ranges(jobs, members.len(), grain(jobs, members.len(), 128), |range| {
                for k in range {
                    if let Some(soon) = members.get(k + PREFETCH) {
                        contacts.prefetch(*soon, 1);
                    }
                    let c = contacts.at(members[k]);
                    let ends = [c.body_a, c.body_b];
                    let [a, b] = ends.map(|row| bodies.at(row));
                    for (row, body, other) in [(ends[0], a, b), (ends[1], b, a)] {
                        if body.is_dynamic() {
                            next.set(row, next.get(row).min(other.history.level.saturating_add(1)));
                        }
                    }
                }
            });
        }
    }
    // The level of a body without support would count up for ever after its ground is removed.
    let maximum = u32::try_from(n).unwrap_or(NONE);
    let changed = AtomicBool::new(false);
    let (awake, rows) = (&bodies.awake, Rows::new(bodies.rows.values_mut(), apart));
    for_ranges(jobs, n, grain(jobs, n, 256), |range| {
        let mut any = false;
        for row in &awake[range] {
            if let Some(body) = rows.row(*row as usize)
                && body.is_dynamic()
            {
                let level = next.get(*row);
                let level = if level > maximum { NONE } else { level };
                any |= level != body.history.level;
                body.history.level = level;
            }
        }
        if any {
            changed.store(true, Ordering::Relaxed);
        }
    });
    colors.levels_dirty = changed.into_inner();
}

/// Wakes a frozen body that this contact supported in the last step. The support left so fast that
/// no step shows the loss in the load.
fn wake_held(first: u32, sets: &mut Sets<'_>) {
    let mut row = first;
    while row != NONE {
        let c = sets.contacts.at(row);
        let (held, bodies) = (c.count > 0 && !c.sensor, [c.body_a, c.body_b]);
        row = c.next_part;
        for body in bodies {
            if held && sets.bodies.at(body).is_dynamic() && !sets.bodies.at(body).active() {
                sets.wake(body);
            }
        }
    }
}

/// Removes a contact with all its manifolds; reports the end if it was touching.
pub(crate) fn end_contact(first: u32, shapes: &Shapes, sets: &mut Sets<'_>) {
    let mut effects = Effects::default();
    // SAFETY: there is no other worker.
    let slots = sets.contacts.slots_mut(unsafe { Apart::promise() });
    ChangeReader { shapes, bodies: sets.bodies, islands: sets.islands, slots }
        .end(first, &mut effects);
    sets.carry_out(core::iter::once(&effects.changes), &mut Vec::new(), &Jobs::Inline);
    effects.touches.report(sets.events);
}
