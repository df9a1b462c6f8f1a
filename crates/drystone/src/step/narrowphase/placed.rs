//! What was put down knows its load: a stack that is made at once begins as if it had always stood.
//!
//! A contact learns its load from sweeps, and one sweep a substep spreads a load over N bodies in N² of them. Until then what stands there
//! falls into itself: fifteen plates of 1 cm to half of their height within a tenth of a second. So contacts that are there without a
//! motion, at their first step, get the weight of what stands above them: from above down, each body's by equal parts to what bears it. That
//! is a guess of statics, which sweeps correct; it need not be right, but near. Bodies that bear already keep what they know.
//!
//! Reads: bodies, what manifolds changed. Writes: contacts (impulses, what they gave). Runs: on the caller, over contacts whose first
//! points are of this step. Bodies on joints are left out: those bear, too.

use super::Change;
use super::settling::settle_at_once;
use crate::base::math::Vec3;
use crate::state::bodies::{Bodies, Body};
use crate::state::contacts::{Contact, Contacts};
use crate::step::context::{GIVES, StepContext};

/// A contact bears if its normal leans from the vertical by less than 45 degrees: the cosine.
const UPRIGHT: f32 = 0.7;

/// What is deeper, or farther apart, in half thicknesses of the thinner body, was not put down.
const NEAR: f32 = 0.2;

/// Nor was what moves, faster than by this part of what gravity gives in a step.
const STILL: f32 = 0.1;

/// A contact that bears, of one body on another.
#[derive(Clone, Copy, Debug)]
struct Bears {
    upper: u32,
    contact: u32,
    lower: u32,
    /// Cosine of the angle between its normal and the vertical.
    upright: f32,
    /// Along the normal [N].
    load: f32,
}

/// A body that stands on such contacts.
#[derive(Clone, Copy, Debug)]
struct Stands {
    row: u32,
    height: f32,
    /// First of its contacts, and how many.
    first: usize,
    count: usize,
    /// What rests on it [N].
    load: f32,
    is_grounded: bool,
}

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    /// By the upper body.
    bears: Vec<Bears>,
    /// By row.
    stands: Vec<Stands>,
    /// Their places in that list, from below up.
    order: Vec<usize>,
}

/// Gives contacts that something was put down on their loads.
pub(super) fn tell_loads(
    ctx: &StepContext,
    bodies: &mut Bodies,
    contacts: &mut Contacts,
    changes: &[Vec<Change>],
    scratch: &mut Scratch,
) {
    let gravity = ctx.gravity.length();
    if !ctx.is_soft || !(gravity > 0.0) || !(ctx.impulse_scale > 0.0) {
        return;
    }
    let up = ctx.gravity * (-1.0 / gravity);
    let Scratch { bears, stands, order } = scratch;
    bears.clear();
    let put = Put { ctx, bodies, contacts, up, least: STILL * gravity * ctx.dt };
    for change in changes.iter().flatten() {
        if let Change::Count(row) = change {
            bears.extend(put.bears(*row));
        }
    }
    if bears.is_empty() {
        return;
    }
    bears.sort_unstable_by_key(|b| (b.upper, b.contact));
    stands.clear();
    for (first, b) in bears.iter().enumerate() {
        match stands.last_mut() {
            Some(last) if last.row == b.upper => last.count += 1,
            _ => {
                let height = up.dot(bodies.at(b.upper).center);
                let row = b.upper;
                stands.push(Stands { row, height, first, count: 1, load: 0.0, is_grounded: false });
            }
        }
    }
    order.clear();
    order.extend(0..stands.len());
    order.sort_unstable_by(|i, j| stands[*i].height.total_cmp(&stands[*j].height).then(i.cmp(j)));
    ground(bears, stands, order);
    share(ctx, bodies, (bears, stands, order));
    // What is squeezed answers slowly from now on, and gives less.
    for of in stands.iter().filter(|of| of.load > 0.0) {
        let body = bodies.at_mut(of.row);
        body.load = of.load;
        body.inertia_factor = ctx.inertia.factor(body);
    }
    for of in bears.iter().filter(|of| of.load > 0.0) {
        put_load(ctx, bodies, contacts.at_mut(of.contact), of.load);
    }
}

/// Shares what stands on each body, and its weight, among what bears it; from above down.
fn share(
    ctx: &StepContext,
    bodies: &Bodies,
    (bears, stands, order): (&mut [Bears], &mut [Stands], &[usize]),
) {
    for i in order.iter().rev() {
        let Stands { row, first, count, load, is_grounded, .. } = stands[*i];
        if !is_grounded {
            continue;
        }
        let body = bodies.at(row);
        let load = load + body.mass * body.gravity_scale.max(0.0) * ctx.gravity.length();
        let bears = &mut bears[first..first + count];
        let firm: f32 = bears.iter().map(|b| f32::from(u8::from(is_firm(stands, b.lower)))).sum();
        let share = load / firm;
        for b in bears {
            if !is_firm(stands, b.lower) {
                continue;
            }
            b.load = share / b.upright;
            if let Some(below) = place(stands, b.lower) {
                stands[below].load += share;
            }
        }
    }
}

/// Where a body stands in the list.
fn place(stands: &[Stands], row: u32) -> Option<usize> {
    stands.binary_search_by_key(&row, |s| s.row).ok()
}

/// True of what stands, or is no body that was put down.
fn is_firm(stands: &[Stands], row: u32) -> bool {
    place(stands, row).is_none_or(|i| stands[i].is_grounded)
}

/// Finds who stands on the ground, or on what does.
fn ground(bears: &[Bears], stands: &mut [Stands], order: &[usize]) {
    for i in order {
        let Stands { first, count, .. } = stands[*i];
        let any = bears[first..first + count].iter().any(|b| is_firm(stands, b.lower));
        stands[*i].is_grounded = any;
    }
}

/// Gives a contact a load [N].
fn put_load(ctx: &StepContext, bodies: &Bodies, contact: &mut Contact, load: f32) {
    let count = f32::from(contact.count);
    let impulse = load * ctx.h / (ctx.impulse_scale * count);
    for point in &mut contact.points[..usize::from(contact.count)] {
        point.impulse = impulse;
    }
    let ends = [contact.body_a, contact.body_b].map(|row| bodies.at(row));
    settle_at_once(ctx, contact, ends);
}

/// What was put down in this step.
struct Put<'a> {
    ctx: &'a StepContext,
    bodies: &'a Bodies,
    contacts: &'a Contacts,
    up: Vec3,
    /// Faster than this is a motion [m/s].
    least: f32,
}

impl Put<'_> {
    /// A contact that bears one that was put down.
    fn bears(&self, row: u32) -> Option<Bears> {
        let c = self.contacts.get(row)?;
        let along = c.normal.dot(self.up);
        let (upper, lower) = if along > 0.0 { (c.body_b, c.body_a) } else { (c.body_a, c.body_b) };
        let is_new = c.count > 0 && !c.sensor && !c.touching && !c.traits.may_soften();
        let stands = is_new && along.abs() > UPRIGHT && self.is_unknown(self.bodies.at(upper));
        let lower_body = self.bodies.at(lower);
        let is_held = !lower_body.is_dynamic() || lower_body.joints.is_empty();
        (stands && is_held && self.is_still(c)).then(|| Bears {
            upper,
            contact: row,
            lower,
            upright: along.abs(),
            load: 0.0,
        })
    }

    /// True of a body that nothing bears yet.
    fn is_unknown(&self, body: &Body) -> bool {
        body.is_dynamic()
            && body.joints.is_empty()
            && !body.dragged
            && self.contacts.of_body(body).all(|(row, _)| !self.contacts.at(row).touching)
    }

    /// True if the two of a contact are at each other, and do not move.
    fn is_still(&self, c: &Contact) -> bool {
        let [a, b] = [c.body_a, c.body_b].map(|row| self.bodies.at(row));
        let near = NEAR * (self.ctx.most_give([a, b]) / GIVES);
        c.points().iter().all(|p| {
            let speed = b.velocity_at(c.r_b(p)) - a.velocity_at(p.r_a);
            p.separation.abs() < near && speed.length() < self.least && p.impulse == 0.0
        })
    }
}
