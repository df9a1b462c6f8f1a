//! Deferred color and island changes, recorded for each contact so that each table can be updated
//! independently, in the order of the list.
#![expect(unsafe_code, reason = "promises that rows are kept apart")]

use super::Sets;
use crate::base::threads::disjoint::Apart;
use crate::base::threads::jobs::{Jobs, side_by_side};
use crate::state::bodies::Bodies;
use crate::state::bodies::body::Body;
use crate::state::colors::{Coloring, Colors, Place};
use crate::state::contacts::leave::Leaver;
use crate::state::contacts::{Contact, Slots};
use crate::state::def::BodyKind;
use crate::state::islands::Islands;

/// Prefetch distance for contacts and bodies, in changes.
const PREFETCH: usize = 6;

/// Change of a contact in the colors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Move {
    /// No change.
    Stays,
    /// The contact stays in its color, which must be sorted: its number of points changed.
    Changes,
    /// The contact is added to a color.
    Enters,
    /// The contact is added to a color, and the still times of its bodies restart.
    Rouses,
    /// The contact is removed from its color.
    Leaves,
}

/// Deferred change of one contact.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DeferredMove {
    row: u32,
    /// The bodies, dynamic ones first.
    bodies: [u32; 2],
    /// Number of dynamic bodies.
    dynamic: u8,
    what: Move,
    /// The contact no longer connects its bodies.
    cuts: bool,
}

const _: () = assert!(size_of::<DeferredMove>() == 16);

impl DeferredMove {
    pub(crate) fn new(row: u32, c: &Contact, what: Move, cuts: bool, bodies: &Bodies) -> Self {
        let is_dynamic = |body: u32| bodies.at(body).is_dynamic();
        let (a, b) = (is_dynamic(c.body_a), is_dynamic(c.body_b));
        let ends = if b && !a { [c.body_b, c.body_a] } else { [c.body_a, c.body_b] };
        Self { row, bodies: ends, dynamic: u8::from(a) + u8::from(b), what, cuts }
    }

    fn dynamic(&self) -> &[u32] {
        &self.bodies[..usize::from(self.dynamic)]
    }

    /// Change in the number of colored contacts.
    const fn more(&self) -> isize {
        match self.what {
            Move::Enters | Move::Rouses if self.dynamic > 0 => 1,
            Move::Leaves if self.dynamic > 0 => -1,
            _ => 0,
        }
    }

    /// Change in the number of special colored contacts; `c` is the contact.
    fn more_special(&self, c: &Contact, bodies: &Bodies) -> isize {
        if self.more() != 0 && c.is_special(bodies) { self.more() } else { 0 }
    }

    /// Applies the change to the coloring for this number of dynamic bodies.
    pub(super) fn color(&self, coloring: &mut Coloring, slots: Slots<'_>) {
        let Some(contact) = slots.row(self.row as usize) else { return };
        match self.what {
            Move::Stays => {}
            Move::Changes => coloring.colors[contact.place.color as usize].dirty = true,
            Move::Enters | Move::Rouses => {
                contact.place = coloring.insert(self.row, self.dynamic());
            }
            Move::Leaves => {
                let place = core::mem::replace(&mut contact.place, Place::NOWHERE);
                let moved = coloring.remove(place, self.dynamic());
                if let Some(moved) = moved.and_then(|row| slots.row(row as usize).as_mut()) {
                    moved.place = place;
                }
            }
        }
    }

    /// Applies the change to the bodies and their islands.
    pub(super) fn tie(&self, islands: &mut Islands, bodies: &mut Bodies) {
        if self.what == Move::Rouses {
            for body in self.bodies {
                let body = bodies.at_mut(body);
                if !body.out && body.kind != BodyKind::Static {
                    body.sleep.still_time = 0.0;
                }
            }
        }
        for body in self.dynamic() {
            let constraints = &mut bodies.at_mut(*body).ties.constraints;
            match self.what {
                Move::Stays | Move::Changes => {}
                Move::Enters | Move::Rouses => *constraints += 1,
                Move::Leaves => *constraints -= 1,
            }
        }
        if let (Move::Enters | Move::Rouses, [a, b]) = (self.what, self.dynamic()) {
            islands.link(*a, *b, bodies);
        }
        if self.cuts {
            self.dynamic().iter().for_each(|body| islands.cut(*body, bodies));
        }
    }
}

/// Deferred changes of some contacts, in order.
#[derive(Clone, Debug, Default)]
pub(crate) struct SetChanges {
    list: Vec<DeferredMove>,
    /// Change in the number of special contacts in the colors.
    special: isize,
    /// True if a contact is added to a color or removed from one.
    recolors: bool,
    /// Contacts to remove after all changes.
    pub(crate) gone: Vec<Leaver>,
}

impl SetChanges {
    pub(crate) fn clear(&mut self) {
        self.list.clear();
        (self.special, self.recolors) = (0, false);
        self.gone.clear();
    }

    pub(crate) fn shrink_to(&mut self, enough: usize) {
        self.list.shrink_to(enough);
        self.gone.shrink_to(enough);
    }

    pub(crate) const fn len(&self) -> usize {
        self.list.len()
    }

    /// Records a change of a contact; `cuts`: it ceases to connect its bodies.
    pub(crate) fn add(&mut self, row: u32, c: &Contact, what: Move, cuts: bool, bodies: &Bodies) {
        let deferred = DeferredMove::new(row, c, what, cuts, bodies);
        self.list.push(deferred);
        self.recolors |= deferred.more() != 0;
        self.special += deferred.more_special(c, bodies);
    }

    /// Records the removal of a contact.
    pub(crate) fn remove(&mut self, row: u32, c: &Contact, bodies: &Bodies) {
        let what = if c.place.is_somewhere() { Move::Leaves } else { Move::Stays };
        let cuts = c.count > 0;
        if what != Move::Stays || cuts {
            self.add(row, c, what, cuts, bodies);
        }
        self.gone.push(Leaver::new(row, c));
    }
}

impl Sets<'_> {
    /// Applies the recorded changes. `gone`: reused memory.
    pub(crate) fn carry_out<'t>(
        &mut self,
        effects: impl Iterator<Item = &'t SetChanges> + Clone + Sync,
        gone: &mut Vec<Leaver>,
        jobs: &Jobs<'_>,
    ) {
        let Self { bodies, contacts, islands, colors, .. } = self;
        // SAFETY: a contact is in one coloring, which one of the tasks below has.
        let slots = contacts.slots_mut(unsafe { Apart::promise() });
        let all = || effects.clone().flat_map(|deferred| &deferred.list);
        let Colors { contacts: of_two, contacts_fixed: of_one, .. } = &mut **colors;
        let mut ties = || tie_all(all(), islands, bodies);
        let mut twos = || color_all(all().filter(|deferred| deferred.dynamic == 2), of_two, slots);
        let mut ones = || color_all(all().filter(|deferred| deferred.dynamic == 1), of_one, slots);
        side_by_side(jobs, &mut [&mut ties, &mut twos, &mut ones], 0, |_| {});
        for deferred in effects.clone() {
            colors.special = colors.special.wrapping_add_signed(deferred.special);
            colors.levels_dirty |= deferred.recolors;
        }
        gone.clear();
        gone.extend(effects.flat_map(|deferred| &deferred.gone));
        contacts.leave(gone, bodies, jobs);
    }

    /// Adds one contact to a color or removes it.
    pub(super) fn carry_out_one(&mut self, row: u32, what: Move) {
        let contact = self.contacts.at(row);
        let deferred = DeferredMove::new(row, contact, what, false, self.bodies);
        if (what == Move::Leaves) != contact.place.is_somewhere() || deferred.dynamic == 0 {
            return;
        }
        let special = deferred.more_special(contact, self.bodies);
        let colors = &mut *self.colors;
        colors.special = colors.special.wrapping_add_signed(special);
        colors.levels_dirty = true;
        let is_of_two = deferred.dynamic == 2;
        let coloring = if is_of_two { &mut colors.contacts } else { &mut colors.contacts_fixed };
        // SAFETY: there is no other worker, and `color` takes one contact after the other.
        deferred.color(coloring, self.contacts.slots_mut(unsafe { Apart::promise() }));
        deferred.tie(self.islands, self.bodies);
    }
}

fn color_all<'t>(
    deferred: impl Iterator<Item = &'t DeferredMove> + Clone,
    coloring: &mut Coloring,
    slots: Slots<'_>,
) {
    let mut soon = deferred.clone().skip(PREFETCH);
    for deferred in deferred {
        if let Some(soon) = soon.next() {
            slots.prefetch_line(soon.row as usize, Contact::LISTS_LINE);
        }
        deferred.color(coloring, slots);
    }
}

fn tie_all<'t>(
    deferred: impl Iterator<Item = &'t DeferredMove> + Clone,
    islands: &mut Islands,
    bodies: &mut Bodies,
) {
    const COUNTS: usize = core::mem::offset_of!(Body, ties.constraints) / 64;
    const STILL: usize = core::mem::offset_of!(Body, sleep.still_time) / 64;
    let mut soon = deferred.clone().skip(PREFETCH);
    for deferred in deferred {
        if let Some(soon) = soon.next() {
            for body in soon.bodies {
                for line in [0, COUNTS, STILL] {
                    bodies.rows.prefetch_line(body, line);
                }
            }
        }
        deferred.tie(islands, bodies);
    }
}
