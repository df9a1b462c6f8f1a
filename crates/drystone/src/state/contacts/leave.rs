//! Contacts leave the tables: the lists of bodies, what is watched, the pairs. The result is that of taking out one after the
//! other.

use super::{Contact, Contacts, Slots, Watched};
use crate::base::disjoint::Rows;
use crate::base::jobs::{Executor, for_ranges, grain, side_by_side};
use crate::base::pair_set::pair_key;
use crate::state::bodies::{Bodies, Body, NONE};

/// So many contacts ahead what is written of one is asked for.
const AHEAD: usize = 4;

/// Fewer are not shared out.
const LEAST: usize = 64;

const LINKS: usize = core::mem::offset_of!(Contact, links) / 64;
const PROBE: usize = core::mem::offset_of!(Contact, probe) / 64;

/// A row to be taken out.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Leaver {
    row: u32,
    bodies: [u32; 2],
    shapes: [u32; 2],
    is_part: bool,
}

impl Leaver {
    pub(crate) const fn new(row: u32, c: &Contact) -> Self {
        let (bodies, shapes) = ([c.body_a, c.body_b], [c.shape_a, c.shape_b]);
        Self { row, bodies, shapes, is_part: c.is_part }
    }
}

impl Contacts {
    /// Takes rows out of all lists; they must be in no color.
    pub(crate) fn leave(&mut self, gone: &[Leaver], bodies: &mut Bodies, jobs: &dyn Executor) {
        let Self { rows, free, pairs, watched } = self;
        let slots = rows.lend();
        let bodies = Rows::new(bodies.rows.values_mut());
        let owners = (gone.len() / LEAST).clamp(1, jobs.workers());
        let mut unwatch = || unwatch(gone, slots, watched);
        let mut forget = || {
            for g in gone.iter().filter(|g| !g.is_part) {
                pairs.remove(pair_key(g.shapes[0], g.shapes[1]));
            }
        };
        side_by_side(jobs, &mut [&mut unwatch, &mut forget], owners, |owner| {
            unlink(gone, slots, bodies, (owner, owners));
        });
        for_ranges(jobs, gone.len(), grain(jobs, gone.len(), LEAST), |range| {
            gone[range].iter().for_each(|g| *slots.row(g.row as usize) = None);
        });
        free.extend(gone.iter().map(|g| g.row));
    }
}

/// Takes contacts out of what is watched.
fn unwatch(gone: &[Leaver], slots: Slots<'_>, watched: &mut Watched) {
    for (k, g) in gone.iter().enumerate() {
        if let Some(soon) = gone.get(k + 2 * AHEAD) {
            slots.prefetch_line(soon.row as usize, PROBE);
        }
        if let Some(soon) = gone.get(k + AHEAD) {
            watched.ask_for(soon.row, AHEAD, slots);
        }
        if let Some(contact) = slots.read(g.row as usize).as_ref().filter(|c| !c.is_part) {
            watched.remove(contact.probe.get() as usize, slots);
        }
    }
}

/// Takes contacts out of the lists of an owner's bodies. Every owner goes through all of them.
fn unlink(
    gone: &[Leaver],
    slots: Slots<'_>,
    bodies: Rows<'_, Option<Body>>,
    (owner, owners): (usize, usize),
) {
    const LIST: usize = core::mem::offset_of!(Body, contacts) / 64;
    let link = |at: u32| {
        let contact = slots.read(at as usize / 2).as_ref();
        contact.map(|c| &c.links[(at & 1) as usize])
    };
    let own = |g: &Leaver| {
        let sides = [(2 * g.row, g.bodies[0]), (2 * g.row + 1, g.bodies[1])];
        sides.into_iter().filter(move |(_, body)| *body as usize % owners == owner)
    };
    for (k, g) in gone.iter().enumerate() {
        if let Some(soon) = gone.get(k + 2 * AHEAD) {
            for (at, body) in own(soon) {
                slots.prefetch_line(at as usize / 2, LINKS);
                bodies.prefetch_line(body as usize, 0);
                bodies.prefetch_line(body as usize, LIST);
            }
        }
        if let Some(soon) = gone.get(k + AHEAD) {
            for link in own(soon).filter_map(|(at, _)| link(at)) {
                slots.prefetch_line(link.previous.get() as usize / 2, LINKS);
                slots.prefetch_line(link.next.get() as usize / 2, LINKS);
            }
        }
        for (at, body) in own(g) {
            let (Some(me), Some(body)) = (link(at), bodies.row(body as usize)) else { continue };
            let (previous, next) = (me.previous.get(), me.next.get());
            if previous == NONE {
                body.contacts = next;
            } else if let Some(link) = link(previous) {
                link.next.set(next);
            }
            if next != NONE
                && let Some(link) = link(next)
            {
                link.previous.set(previous);
            }
        }
    }
}
