//! Initial loads: computes the impulses of contacts that bodies were placed on, so that a new stack
//! begins as if it had always stood.
//!
//! A contact learns its load from sweeps, and one sweep a substep spreads a load over N bodies in
//! N² of them. Until then such a stack collapses into itself: fifteen plates of 1 cm to half of
//! their height within a tenth of a second. So this file supports, from the start, a body without
//! earlier support that lies still on a contact whose first points are of this step. The contacts
//! below a body share its weight and its load equally, from the top of the stack down. That is a
//! statics estimate, which sweeps correct; it must be near, not exact.
//!
//! Reads: bodies, contacts that carry, changes of manifolds. Writes: contacts (impulses, settled
//! depth), loads of bodies. Runs: on the calling thread, over contacts whose first points are of
//! this step. Bodies with joints are left out, since joints carry loads too.

use super::change::Change;
use super::settling::{is_still, settle_at_once};
use crate::base::math::Vec3;
use crate::state::bodies::Bodies;
use crate::state::bodies::body::Body;
use crate::state::contacts::{Contact, Contacts};
use crate::step::context::{GIVES, StepContext};

/// Minimum cosine of the angle between the normal of a supporting contact and the vertical: 45
/// degrees.
const UPRIGHT: f32 = 0.7;

/// Maximum depth of a placed body, in half thicknesses of the thinner body. Its maximum separation
/// is the depth allowed for a settled contact ([`GIVES`]).
const DEEP: f32 = 0.2;

/// Maximum speed and rotation of a placed body, as a part of the speed that gravity gives in a
/// step.
const STILL: f32 = 0.1;

/// Capacity for more contacts than this is freed.
const KEPT: usize = 256;

/// A supporting contact: one body stands on another.
#[derive(Clone, Copy, Debug)]
struct Bears {
    upper: u32,
    contact: u32,
    lower: u32,
    /// Load that the contact carries [N].
    load: f32,
    /// The lower body is supported already, or needs no support.
    is_firm: bool,
}

/// A body that stands on such contacts.
#[derive(Clone, Copy, Debug)]
struct Stands {
    row: u32,
    height: f32,
    /// First of its contacts, and their number.
    first: usize,
    count: usize,
    /// Load on the body [N].
    load: f32,
    is_grounded: bool,
    /// The body's island subdivides its substeps.
    is_fine: bool,
}

/// Memory kept from step to step.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    /// Rows of placed bodies and of bodies stacked on them, each once, ascending.
    seen: Vec<u32>,
    /// Rows among these that remain to be processed.
    next: Vec<u32>,
    /// Sorted by the upper body.
    bears: Vec<Bears>,
    /// Sorted by row.
    stands: Vec<Stands>,
    /// Indices into `stands`, from the lowest body to the highest.
    order: Vec<usize>,
}

/// Sets the impulses of contacts that bodies were placed on.
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
    let Scratch { seen, next, bears, stands, order } = scratch;
    let put = Put { ctx, bodies, contacts, up, minimum: STILL * gravity * ctx.dt };
    next.clear();
    for change in changes.iter().flatten() {
        if let Change::Count(row) = change {
            next.extend(put.upper_of_new(*row));
        }
    }
    if next.is_empty() {
        return;
    }
    next.sort_unstable();
    next.dedup();
    seen.clone_from(next);
    bears.clear();
    while let Some(row) = next.pop() {
        let first = bears.len();
        put.supports(row, bears);
        if first == bears.len() {
            continue;
        }
        for above in put.above(row) {
            if let Err(at) = seen.binary_search(&above) {
                seen.insert(at, above);
                next.push(above);
            }
        }
    }
    bears.sort_unstable_by_key(|b| (b.upper, b.contact));
    stands.clear();
    for (first, b) in bears.iter().enumerate() {
        match stands.last_mut() {
            Some(last) if last.row == b.upper => last.count += 1,
            _ => {
                let row = b.upper;
                let height = up.dot(bodies.at(row).center);
                stands.push(Stands {
                    row,
                    height,
                    first,
                    count: 1,
                    load: 0.0,
                    is_grounded: false,
                    is_fine: false,
                });
            }
        }
    }
    order.clear();
    order.extend(0..stands.len());
    order.sort_unstable_by(|i, j| stands[*i].height.total_cmp(&stands[*j].height).then(i.cmp(j)));
    ground(bears, stands, order);
    for i in 0..stands.len() {
        let row = stands[i].row;
        let is_known = |upper: u32| upper != row && place(stands, upper).is_none();
        stands[i].load = put.carried(row, is_known);
    }
    share(ctx, bodies, (bears, stands, order));
    if ctx.inertia.is_on() {
        // Loaded bodies get their inertia factor now, and contacts yield less under it.
        for of in stands.iter().filter(|of| of.is_grounded) {
            let body = bodies.at_mut(of.row);
            body.history.load = of.load;
            body.history.inertia_factor = ctx.inertia.at_rest(body);
        }
    }
    refine(ctx, bodies, bears, stands, order);
    for of in bears.iter().filter(|of| of.load > 0.0) {
        let is_fine = place(stands, of.upper).is_some_and(|i| stands[i].is_fine);
        let contact = contacts.at_mut(of.contact);
        let side = if of.upper == contact.body_b { 1.0 } else { -1.0 };
        put_load(ctx, bodies, contact, up * (side * of.load), is_fine);
    }
    // Many bodies are placed at once when a world is made, and few later.
    if bears.capacity() > KEPT {
        *scratch = Scratch::default();
    }
}

/// Distributes the weight of each body and its load among its supports, from the highest body down.
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
        let load = load + weight(ctx, body);
        let bears = &mut bears[first..first + count];
        let firm: f32 = bears.iter().map(|b| f32::from(u8::from(is_firm(stands, b)))).sum();
        let share = load / firm;
        for b in bears {
            if !is_firm(stands, b) {
                continue;
            }
            b.load = share;
            if let Some(below) = place(stands, b.lower) {
                stands[below].load += share;
            }
        }
    }
}

/// Weight of a body [N].
fn weight(ctx: &StepContext, body: &Body) -> f32 {
    body.inertia.mass * body.forces.gravity_scale.max(0.0) * ctx.gravity.length()
}

/// Index of a body in the list.
fn place(stands: &[Stands], row: u32) -> Option<usize> {
    stands.binary_search_by_key(&row, |s| s.row).ok()
}

/// True if the lower body of a contact can carry a load.
fn is_firm(stands: &[Stands], of: &Bears) -> bool {
    place(stands, of.lower).map_or(of.is_firm, |i| stands[i].is_grounded)
}

/// Finds the bodies that stand on the ground, directly or through others.
fn ground(bears: &[Bears], stands: &mut [Stands], order: &[usize]) {
    for i in order {
        let Stands { first, count, .. } = stands[*i];
        let any = bears[first..first + count].iter().any(|b| is_firm(stands, b));
        stands[*i].is_grounded = any;
    }
}

/// Marks bodies whose island will subdivide its substeps, with the bodies below and above them:
/// contacts yield less there.
fn refine(
    ctx: &StepContext,
    bodies: &Bodies,
    bears: &[Bears],
    stands: &mut [Stands],
    order: &[usize],
) {
    if !ctx.inertia.in_parts {
        return;
    }
    for i in order {
        let Stands { row, first, count, .. } = stands[*i];
        let mut below = bears[first..first + count].iter().filter_map(|b| place(stands, b.lower));
        stands[*i].is_fine =
            below.any(|i| stands[i].is_fine) || ctx.inertia.wants_refining(bodies.at(row));
    }
    for i in order.iter().rev() {
        let Stands { first, count, is_fine, .. } = stands[*i];
        for b in &bears[first..first + count] {
            if let Some(below) = place(stands, b.lower) {
                stands[below].is_fine |= is_fine;
            }
        }
    }
}

/// Applies a force [N] on body B to a contact. It is vertical, as far as friction holds the body on
/// a slope.
fn put_load(ctx: &StepContext, bodies: &Bodies, contact: &mut Contact, force: Vec3, is_fine: bool) {
    // Impulse on B.
    let impulse = force * (ctx.h / ctx.impulse_scale);
    let normal = impulse.dot(contact.normal);
    let tangent = impulse - contact.normal * normal;
    let maximum = contact.friction * normal;
    let count = f32::from(contact.count);
    for point in &mut contact.points[..usize::from(contact.count)] {
        point.impulse = normal / count;
    }
    contact.tangent_impulse =
        tangent * (maximum / tangent.length().max(maximum).max(f32::MIN_POSITIVE));
    if !is_fine {
        settle_at_once(ctx, contact, [contact.body_a, contact.body_b].map(|row| bodies.at(row)));
    }
}

/// The bodies placed in this step, with the tables to search them.
struct Put<'a> {
    ctx: &'a StepContext,
    bodies: &'a Bodies,
    contacts: &'a Contacts,
    up: Vec3,
    /// Minimum speed that counts as motion [m/s].
    minimum: f32,
}

impl Put<'_> {
    /// The upper body of a supporting contact whose first points are of this step.
    fn upper_of_new(&self, row: u32) -> Option<u32> {
        let c = self.contacts.get(row)?;
        let Ends { upper, .. } = (!c.touching).then(|| self.ends(c))??;
        self.may_bear(c, upper).then_some(upper)
    }

    /// Collects the supports of a body, unless it is supported already.
    fn supports(&self, row: u32, bears: &mut Vec<Bears>) {
        let body = self.bodies.at(row);
        let hangs = (0..3).any(|i| body.inertia.locks.linear[i] && self.up[i].abs() > 1.0e-3);
        let is_held =
            !body.is_dynamic() || !body.ties.joints.is_empty() || body.record.dragged || hangs;
        if is_held || self.is_borne(row) {
            return;
        }
        for (contact, _) in self.contacts.of_body(body) {
            let c = self.contacts.at(contact);
            let Some(Ends { upper, lower, .. }) = self.ends(c) else { continue };
            let below = self.bodies.at(lower);
            if upper == row
                && self.may_bear(c, upper)
                && (!below.is_dynamic() || below.ties.joints.is_empty())
            {
                let is_firm = !below.is_dynamic() || self.is_borne(lower);
                bears.push(Bears { upper, contact, lower, load: 0.0, is_firm });
            }
        }
    }

    /// True if contacts carry the body already.
    fn is_borne(&self, row: u32) -> bool {
        let carried = self.carried(row, |upper| upper == row);
        carried > 0.5 * weight(self.ctx, self.bodies.at(row))
    }

    /// Bodies that lie on this one.
    fn above(&self, row: u32) -> impl Iterator<Item = u32> {
        self.contacts.of_body(self.bodies.at(row)).filter_map(move |(contact, _)| {
            let Ends { upper, .. } = self.ends(self.contacts.at(contact))?;
            (upper != row).then_some(upper)
        })
    }

    /// Sum of the vertical forces of a body's contacts whose upper body satisfies `counts` [N].
    fn carried(&self, row: u32, counts: impl Fn(u32) -> bool) -> f32 {
        let carried = self.contacts.of_body(self.bodies.at(row)).filter_map(|(contact, _)| {
            let c = self.contacts.at(contact);
            let Ends { upper, upright, .. } = self.ends(c)?;
            let impulse: f32 = c.points().iter().map(|p| p.impulse).sum();
            let along = impulse * (self.ctx.impulse_scale / self.ctx.h);
            counts(upper).then_some(along / upright)
        });
        carried.sum()
    }

    /// The upper and lower body of a contact; `None` if its normal is too flat, or if no body can
    /// lie there.
    fn ends(&self, c: &Contact) -> Option<Ends> {
        let along = c.normal.dot(self.up);
        let is_upright = c.count > 0 && !c.sensor && along.abs() > UPRIGHT;
        let (upper, lower) = if along > 0.0 { (c.body_b, c.body_a) } else { (c.body_a, c.body_b) };
        is_upright.then_some(Ends { upper, lower, upright: along.abs() })
    }

    /// True if the bodies of a contact touch and do not move against each other: a rolling body
    /// does.
    fn may_bear(&self, c: &Contact, upper: u32) -> bool {
        let [a, b] = [c.body_a, c.body_b].map(|row| self.bodies.at(row));
        let near = self.ctx.max_give([a, b]);
        let deep = DEEP / GIVES * near;
        let turns = (b.w - a.w).length();
        let minimum = self.minimum - turns * self.bodies.at(upper).extent;
        let lies = c.points().iter().all(|p| p.separation < near && p.separation > -deep);
        !c.traits.may_soften() && lies && is_still(c, [a, b], minimum)
    }
}

/// The bodies of a supporting contact.
struct Ends {
    upper: u32,
    lower: u32,
    /// Cosine of the angle between the contact's normal and the vertical.
    upright: f32,
}
