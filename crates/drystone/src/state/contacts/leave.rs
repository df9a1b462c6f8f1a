//! Removes contacts from the tables: the lists of bodies, the watches, the set of pairs. The result
//! equals that of serial removal.
#![expect(unsafe_code, reason = "promises that rows are kept apart")]

use super::lists::{Links, Owners, prefetch_heads};
use super::{Contact, Contacts, Table, Watched};
use crate::base::pair_set::{PairSet, pair_key};
use crate::base::threads::disjoint::{Apart, Rows};
use crate::base::threads::jobs::{Jobs, side_by_side};
use crate::state::bodies::Bodies;
use crate::state::bodies::body::Body;

/// Prefetch distance, in contacts.
const PREFETCH: usize = 4;

/// A row to be removed.
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
    /// Removes rows from all lists. They must not be in a color.
    pub(crate) fn leave(&mut self, gone: &[Leaver], bodies: &mut Bodies, jobs: &Jobs<'_>) {
        let Self { rows, free, pairs, watched, .. } = self;
        let table = &*rows;
        // SAFETY: each body's list has a single owner.
        let bodies = Rows::new(bodies.rows.values_mut(), unsafe { Apart::promise() });
        let owners = Owners::of(gone.len(), jobs);
        let mut unwatch = || unwatch(gone, table, watched);
        let mut forget = || forget(gone, pairs);
        side_by_side(jobs, &mut [&mut unwatch, &mut forget], owners.len(), |owner| {
            unlink(gone, table, bodies, |body| owners.owns(owner, body));
        });
        for g in gone {
            if let Some(slot) = rows.get_mut(g.row as usize) {
                *slot = None;
            }
            free.push(g.row);
        }
    }
}

/// Removes the watches of the contacts.
fn unwatch(gone: &[Leaver], table: &Table, watched: &mut Watched) {
    for (k, g) in gone.iter().enumerate() {
        if let Some(soon) = gone.get(k + 2 * PREFETCH) {
            table.prefetch_line(soon.row as usize, Contact::LISTS_LINE);
        }
        if let Some(soon) = gone.get(k + PREFETCH) {
            watched.prefetch(soon.row, PREFETCH, table);
        }
        if let Some(contact) = table.read(g.row as usize).as_ref().filter(|c| !c.is_part) {
            watched.remove(contact.probe.get() as usize, table);
        }
    }
}

/// Removes the contacts from the set of pairs.
fn forget(gone: &[Leaver], pairs: &mut PairSet) {
    for (k, g) in gone.iter().enumerate() {
        if let Some(soon) = gone.get(k + 2 * PREFETCH) {
            pairs.prefetch(pair_key(soon.shapes[0], soon.shapes[1]));
        }
        if !g.is_part {
            pairs.remove(pair_key(g.shapes[0], g.shapes[1]));
        }
    }
}

/// Removes the contacts from the lists of an owner's bodies. Every owner walks over all contacts.
fn unlink(
    gone: &[Leaver],
    table: &Table,
    bodies: Rows<'_, Option<Body>>,
    owns: impl Fn(u32) -> bool,
) {
    let links = Links(table);
    for (k, g) in gone.iter().enumerate() {
        if let Some(soon) = gone.get(k + 2 * PREFETCH) {
            table.prefetch_line(soon.row as usize, Contact::LISTS_LINE);
            prefetch_heads(bodies, soon.bodies, &owns);
        }
        if let Some(soon) = gone.get(k + PREFETCH) {
            for (side, body) in (0..).zip(soon.bodies) {
                if owns(body)
                    && let Some(link) = links.at(2 * soon.row + side)
                {
                    table.prefetch_line(link.previous.get() as usize / 2, Contact::LISTS_LINE);
                    table.prefetch_line(link.next.get() as usize / 2, Contact::LISTS_LINE);
                }
            }
        }
        for (side, body) in (0..).zip(g.bodies) {
            if owns(body)
                && let Some(me) = links.at(2 * g.row + side)
                && let Some(body) = bodies.row(body as usize)
            {
                let (previous, next) = (me.previous.get(), me.next.get());
                match links.at(previous) {
                    Some(link) => link.next.set(next),
                    None => body.ties.contacts = next,
                }
                if let Some(link) = links.at(next) {
                    link.previous.set(previous);
                }
            }
        }
    }
}
